"""Codes that change what coordinates mean while the machine stands still: tool lengths, G10, G52, G92.

The base of the interpreter: it holds the state, and what words mean as lengths and angles.
"""

import dataclasses
import math
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.tolerances import DRILL_TILT, WHOLE_NUMBER, ZERO_LENGTH_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.codes import g_name
from verne_post.gcode.missing_setup import check_measured, missing_tool
from verne_post.gcode.offsets import vector9
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State
from verne_post.model.moves import AXES, ZERO9, Frame
from verne_post.model.part_setup import Tool, Vector9, tool_word

#: Axes whose words are lengths.
LINEAR: Final = "XYZUVW"
_NUMBER_OF_AXIS: Final = {letter: axis for axis, letter in enumerate(AXES)}
#: Coordinates beyond this are mistakes, not motion: 100 m, and nearly 300 turns.
MAX_LENGTH_MM: Final = 1e5
MAX_ANGLE_DEG: Final = 1e5
MAX_DWELL_S: Final = 86_400.0


def whole(block: Block, letter: str) -> int:
    """Value of a word that must be a whole number from 0 on."""
    value = block.words[letter]
    number = round(value)
    if abs(value - number) > WHOLE_NUMBER:
        raise block.error("VP007", f"{letter}{value:g} must be a whole number", letter)
    if number < 0:
        raise block.error("VP007", f"{letter}{value:g} must not be negative", letter)
    return number


def polar_end(block: Block, x: float, y: float, *, absolute: bool) -> tuple[float, float]:
    """Where the polar words of a block lead from a place, all in the unit of the program."""
    distance, angle = math.hypot(x, y), math.degrees(math.atan2(y, x))
    if distance < ZERO_LENGTH_MM and (not absolute or "^" not in block.polar):
        raise block.error("VP017", "at X0 Y0 there is no angle to go on from; name @ and ^ in G90", "X")
    if absolute:
        distance, angle = block.polar.get("@", distance), block.polar.get("^", angle)
    else:
        distance, angle = distance + block.polar.get("@", 0.0), angle + block.polar.get("^", 0.0)
    return distance * math.cos(math.radians(angle)), distance * math.sin(math.radians(angle))


class FrameCodes:
    """State of an interpretation, and the codes that set frames."""

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.setup, self.state, self.recorder = setup, state, recorder

    def _length(self, value: float) -> float:
        return value * MM_PER_INCH if self.state.inch else value

    def _axis_value(self, block: Block, axis: int) -> float:
        letter = AXES[axis]
        value = block.words[letter]
        if self.state.inch and letter in LINEAR:
            value *= MM_PER_INCH
        if self.setup.machine and abs(value) > (MAX_LENGTH_MM if letter in LINEAR else MAX_ANGLE_DEG):
            raise block.error("VP007", f"{letter}{value:g} is beyond any machine", letter)
        return value

    def _named_axes(self, block: Block) -> list[int]:
        return sorted([_NUMBER_OF_AXIS[letter] for letter in block.words if letter in _NUMBER_OF_AXIS])

    def tilted_tool(self, axis: int = 2) -> str | None:
        """The tool axis in words where it does not point along Z, or another axis of the program; else None."""
        tool = self.setup.coordinates.tool_axis(self.state.position, self.state.frame)
        if tool is None or tool[axis] >= 1.0 - DRILL_TILT:
            return None
        return f"the tool points along ({tool[0]:.4f}, {tool[1]:.4f}, {tool[2]:.4f})"

    def _require_known(self, block: Block, axes: list[int], why: str) -> None:
        for axis in axes:
            if not self.state.is_known(axis):
                letter = AXES[axis]
                raise block.error("VP013", f"{why} needs the position of {letter}, which no absolute word has named yet; "
                    f"name {letter} with G90 first", letter)  # fmt: skip

    def _name_axes(self, end: list[float], axes: list[int], *, machine: bool = False) -> None:
        """Axes are named in absolute terms, by a motion that is about to end at ``end``; ``machine``: in machine coordinates."""
        state = self.state
        if state.first_places is None:
            for axis in axes:
                state.known[axis] = True
            return
        frame, coordinates = state.frame, self.setup.coordinates
        state.first_places.note(
            state.known, state.position, end, axes, lambda program: coordinates.to_machine(program, frame),
            machine=machine,
        )  # fmt: skip

    def _stand_at(self, places: dict[int, float]) -> None:
        """Let axes that nothing has named stand where a block that is more than a move (a cycle, a pattern) goes first."""
        state = self.state
        end = list(state.position)
        fresh = [axis for axis in places if not state.is_known(axis)]
        for axis in fresh:
            end[axis] = places[axis]
        if fresh:
            self._name_axes(end, fresh)
            state.position = end

    def _refuse_compensation(self, code: str) -> None:
        if self.state.compensation is not None:
            raise BlockError("VP017", f"{code} under cutter compensation; write G40 first")

    def _check_one_tool(self, tool: int) -> None:
        """--tool-length is the length of one tool."""
        state = self.state
        if self.setup.tool_length is not None and state.only_tool is not None and state.only_tool != tool:
            names = [tool_word(number, state.tool_names) for number in (state.only_tool, tool)]
            raise BlockError(
                "VP018",
                f"--tool-length holds for one tool, but the program uses {names[0]} and {names[1]}; use --tool-table instead",
                about=names[1],
            )
        state.only_tool = tool

    def _set_tool_length(self, block: Block, code: int) -> None:
        state = self.state
        state.length_given = True
        if code in (434, 435):
            self.recorder.says_tcp = True
        if code == 490:
            offset = ZERO9
        elif code == 431:
            values = list(state.frame.tool)
            for axis, letter in enumerate(AXES):
                if letter in block.words:
                    values[axis] = self._axis_value(block, axis)
            if self.setup.machine and any(values[:2] + values[3:]):
                raise BlockError("VP007", "G43.1 can only set a length (Z) on this machine; X, Y and angles must be 0")
            if self.setup.machine and values[2] < 0:
                raise block.error("VP007", f"G43.1 Z{block.words['Z']:g}: a tool length is not negative", "Z")
            offset = vector9(values)
        elif code == 432:
            if "H" not in block.words:
                raise BlockError("VP005", "G43.2 needs H, the tool whose offset is added")
            offset = vector9(np.add(state.frame.tool, self._offset_of_tool(block)))
        else:
            offset = self._offset_of_tool(block)
        if self.setup.tool_length is None:
            self._set_frame(replace(state.frame, tool=offset))

    def _offset_of_tool(self, block: Block) -> Vector9:
        state = self.state
        number = whole(block, "H") if "H" in block.words else 0
        if self.setup.tool_length is not None:
            if number:
                self._check_one_tool(number)
            return ZERO9
        if number == 0:
            number = state.loaded_tool or 0
        if number == 0:
            if self.setup.machine:
                raise BlockError(
                    "VP012", "G43 without H, and no tool is in the spindle; write G43 H, or use --tool-length"
                )
            return ZERO9
        if state.tools is None or number not in state.tools:
            raise missing_tool(number, "H", block, self.setup, state)
        check_measured(state.tools[number], self.setup, state, block.columns.get("H"))
        offset = state.tools[number].offset
        if self.setup.machine and offset[2] < 0:
            raise BlockError("VP007", f"tool {number} has the length {offset[2]:g} mm; a length is not negative")
        if self.setup.machine and any(offset[:2] + offset[3:]):
            raise BlockError(
                "VP007", f"tool {number} has offsets other than a length (Z), which this machine cannot use"
            )
        return offset

    def _set_frame(self, frame: Frame) -> None:
        """Change frames while the machine stands still: the same place has new program coordinates."""
        state, coordinates = self.state, self.setup.coordinates
        old = state.frame
        if frame == old:
            return
        self._refuse_compensation("a change of offsets")
        if state.tool_axis is not None and _directions(frame) != _directions(old):
            # the tool stands still, so its axis has other words
            rotation = coordinates.displacement(np.eye(3), frame)
            held = rotation @ coordinates.displacement(np.array(state.tool_axis), old)
            state.tool_axis = (float(held[0]), float(held[1]), float(held[2]))
        machine = coordinates.to_machine(np.array(state.position), old)
        position = [float(v) for v in coordinates.to_program(machine, frame)]
        if self.setup.machine:
            if frame.tool != old.tool and state.held is None and state.placed:
                state.held = [p if named else math.nan for p, named in zip(state.position, state.named, strict=True)]
            if state.held is not None:
                # programmed values follow a change of work offset, but not one of tool length
                before = np.where(np.isnan(state.held), state.position, state.held)
                same_tool = replace(frame, tool=old.tool)
                moved = coordinates.to_program(coordinates.to_machine(before, old), same_tool)
                state.held = [float(v) if n else math.nan for v, n in zip(moved, state.named, strict=True)]
        if state.centre is not None:  # the tool still stands beside its last contour
            centre = coordinates.to_program(coordinates.to_machine(np.array(state.centre), old), frame)
            state.centre = [float(v) for v in centre]
        state.position = position
        state.frame = frame
        if frame.tool != old.tool:
            state.systems = {number: replace(item, tool=frame.tool) for number, item in state.systems.items()}

    def _execute_g10(self, block: Block) -> None:
        state = self.state
        if block.words.get("L") == 0:
            if state.loaded_tool:
                raise BlockError(
                    "VP017", f"G10 L0 with tool {state.loaded_tool} in the spindle; unload it with T0 M6 first"
                )
            state.tools = dict(self.setup.tools) if self.setup.tools is not None else None
            return
        if "L" not in block.words or "P" not in block.words:
            raise BlockError("VP005", "G10 needs L and P")
        kind, number = whole(block, "L"), whole(block, "P")
        if kind in (1, 10, 11):
            self._set_tool_offset(block, kind, number, self._named_axes(block))
            return
        if kind not in (2, 20):
            raise block.error(
                "VP002", f"G10 L{kind} is not a code of this language; expected L0, L1, L2, L10, L11 or L20", "L"
            )
        for letter in "IJQ":
            if letter in block.words:
                raise block.error("VP006", f"G10 L{kind} does not use {letter}", letter)
        if not 0 <= number <= 9:
            raise block.error("VP007", f"P{number}: work systems are P1 to P9, P0 is the active one", "P")
        if kind == 2:
            self._set_origin(block, number or state.frame.system)
        else:
            self._set_origin_here(block, number or state.frame.system)

    def _set_origin(self, block: Block, system: int) -> None:
        """G10 L2: the origin in machine coordinates, and R."""
        frame = self._stored_frame(system)
        origin = list(frame.origin)
        for axis in self._named_axes(block):
            origin[axis] = self._axis_value(block, axis)
        self._store_frame(replace(frame, origin=vector9(origin), turn=block.words.get("R", frame.turn)))

    def _set_origin_here(self, block: Block, system: int) -> None:
        """G10 L20: the origin such that the present place gets the given values."""
        if "R" in block.words:
            raise block.error("VP006", "G10 L20 does not use R", "R")
        axes, coordinates = self._named_axes(block), self.setup.coordinates
        self._require_known(block, axes, "G10 L20")
        frame = self._stored_frame(system)
        here = coordinates.to_program(coordinates.to_machine(np.array(self.state.position), self.state.frame), frame)
        shift = np.zeros(9)
        for axis in axes:
            shift[axis] = here[axis] - self._axis_value(block, axis)
        shift[:3] = coordinates.displacement(shift[:3], frame)
        self._store_frame(replace(frame, origin=vector9(np.asarray(frame.origin) + shift)))

    def _stored_frame(self, system: int) -> Frame:
        return replace(self.state.systems[system], g92=self.state.frame.g92, tool=self.state.frame.tool)

    def _store_frame(self, frame: Frame) -> None:
        """A work system gets a new origin; the active one at once."""
        self.state.systems[frame.system] = replace(frame, g92=ZERO9)
        self.recorder.placed.add(frame.system)
        if frame.system == self.state.frame.system:
            self._set_frame(frame)

    def _set_tool_offset(self, block: Block, kind: int, number: int, axes: list[int]) -> None:
        """The tool table: L1 the offset itself; L10, L11 such that the present place gets the values."""
        state = self.state
        if number < 1:
            raise block.error("VP007", f"P{number}: a tool number is 1 or more", "P")
        tools = dict(state.tools or {})
        old = tools.get(number, Tool(number, number, ZERO9, unmeasured=f"G10 L{kind} in line {block.line}"))
        offset = np.array(old.offset)
        values = {axis: self._axis_value(block, axis) for axis in axes}
        if kind == 1:
            offset[axes] = list(values.values())
        else:
            self._require_known(block, axes, f"G10 L{kind}")
            if self.tilted_tool() is not None:
                raise BlockError(
                    "VP017", f"G10 L{kind} measures along Z, and the tool is tilted; turn the table to A0 first"
                )
            bare = replace(state.frame if kind == 10 else state.systems[9], tool=ZERO9)
            if kind == 11:
                bare = replace(bare, g92=ZERO9)
            coordinates = self.setup.coordinates
            here = coordinates.to_program(coordinates.to_machine(np.array(state.position), state.frame), bare)
            rotation = coordinates.displacement(
                np.eye(3), bare
            )  # offsets count along the machine, values along the system
            offset[:3] = rotation @ offset[:3]
            for axis, value in values.items():
                offset[axis] = here[axis] - value
            offset[:3] = coordinates.displacement(offset[:3], bare)
        diameter = 2 * self._length(block.words["R"]) if "R" in block.words else old.diameter
        for letter in "IJQ":
            if letter in block.words:
                raise block.error("VP006", f"G10 L{kind} uses {letter} only on a lathe", letter)
        unmeasured = "" if _NUMBER_OF_AXIS["Z"] in values else old.unmeasured
        tools[number] = dataclasses.replace(old, offset=vector9(offset), diameter=diameter, unmeasured=unmeasured)
        state.tools = tools

    def _execute_g92(self, block: Block, code: int) -> None:
        state = self.state
        axes = self._named_axes(block)
        if not axes:
            raise BlockError("VP005", f"{g_name(code)} needs at least one axis word")
        g92 = list(state.frame.g92)
        if code == 920:
            self._require_known(block, axes, "G92")
        for axis in axes:
            value = self._axis_value(block, axis)
            g92[axis] = value if code == 520 else g92[axis] + state.position[axis] - value
        state.g92_stored = tuple(g92)
        self._apply_shift(on=True)

    def _apply_shift(self, *, on: bool) -> None:
        """The stored shift of G92 and G52 is in force, or not."""
        self.state.g92_on = on
        self._set_frame(replace(self.state.frame, g92=vector9(self.state.g92_stored) if on else ZERO9))


def _directions(frame: Frame) -> tuple[object, ...]:
    """What decides the directions of the program's X, Y, Z."""
    return frame.turn, frame.part_turn, frame.feature
