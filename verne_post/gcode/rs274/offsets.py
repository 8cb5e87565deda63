"""Codes that change what coordinates mean while the machine stands still: tool lengths, G10, G52, G92."""

import dataclasses
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.gcode.block import Block
from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.machining.machining import Machining, note_word
from verne_post.gcode.offsets import make_vector9
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.modes import TCP_CODES
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.rs274.values import WordValues, read_whole
from verne_post.model.moves import AXES, ZERO9
from verne_post.model.part_setup import Tool, Vector9

_Z: Final = 2


def say_directions(core: Machining) -> None:
    """Record whether a code defines the directions of X Y Z: G43.4, G43.5, a plane of the part, a user's code.

    G43.4 does not while the control has cancelled its length.
    """
    state = core.state
    plane = state.frame.feature is not None and not state.modes.turns  # G68 turns it where it is
    holds_tip = state.modes.length_code in TCP_CODES and not state.length_end
    core.recorder.say_tcp(holds_tip or plane or state.tcp_off is not None)


class OffsetCodes:
    """G10, G92, G52 and the codes of tool length: what coordinates mean, while the machine stands still."""

    def __init__(self, core: Machining, values: WordValues, traits: Traits) -> None:
        self.core, self.values, self.traits = core, values, traits
        self.setup, self.state = core.setup, core.state

    def set_tool_length(self, block: Block, code: int) -> None:
        if code != 490 or self.state.modes.length_code is not None:
            self.state.modes.length_code = code
            note_word(self.core, "length", block.line)
        say_directions(self.core)
        if code == 490:
            self.core.recorder.note_tcp_end(block.line, "G49")
        find = {490: lambda: ZERO9, 431: lambda: self._read_offset(block), 432: lambda: self._add_offset(block)}.get(
            code
        )
        self.core.tools.set_length(find or (lambda: self._find_length_in_force(block)))

    def _read_offset(self, block: Block) -> Vector9:
        """G43.1: the offset itself."""
        values = list(self.state.frame.tool)
        for axis, letter in enumerate(AXES):
            if letter in block.words:
                values[axis] = self.values.read_axis_value(block, axis)
        if self.setup.machine and any(values[:2] + values[3:]):
            raise ProgramError("VP007", "G43.1 can only set a length (Z) on this machine; X, Y and angles must be 0")
        if self.setup.machine and values[2] < 0:
            raise block.error("VP007", f"G43.1 Z{block.words['Z']:g}: a tool length is not negative", "Z")
        return make_vector9(values)

    def _add_offset(self, block: Block) -> Vector9:
        """G43.2: the offset of another tool on top of the one in force."""
        if "H" not in block.words:
            raise ProgramError("VP005", "G43.2 needs H, the tool whose offset is added")
        return make_vector9(np.add(self.state.frame.tool, self._find_tool_offset(block)))

    def _find_tool_offset(self, block: Block) -> Vector9:
        """The offset of H; without H, or H0, the spindle tool's, except with :attr:`Traits.zero_is_no_offset`."""
        if self.traits.zero_is_no_offset:
            if "H" not in block.words and self.state.modes.length_number is None:
                error = ProgramError(
                    "VP005", "a tool length offset needs H, its number: none was given since the tool change"
                )
                error.leaves_unknown = True  # which length holds, and where G28 or G53 has cancelled it
                raise error
            block.words.setdefault("H", self.state.modes.length_number or 0.0)
            self.state.modes.length_number = block.words["H"]
            if not block.words["H"]:
                return ZERO9
        return self.core.tools.find_offset(block, read_whole(block, "H") if "H" in block.words else 0)

    def _find_length_in_force(self, block: Block) -> Vector9:
        """The offset that a code puts in force by itself: one of another tool than the spindle has is told (VP049)."""
        offset = self._find_tool_offset(block)
        if block.words.get("H"):
            self.core.tools.compare_length(block, read_whole(block, "H"))
        return offset

    def execute_g10(self, block: Block, *, adds_wear: bool = False) -> None:
        """G10; ``adds_wear``: the value of a tool differs by its wear from the one that is measured."""
        state = self.state
        if block.words.get("L") == 0:
            if state.loaded_tool:
                raise ProgramError(
                    "VP017", f"G10 L0 with tool {state.loaded_tool} in the spindle; unload it with T0 M6 first"
                )
            self.core.tools.reload_table()
            return
        if "L" not in block.words or "P" not in block.words:
            raise ProgramError("VP005", "G10 needs L and P")
        kind, number = read_whole(block, "L"), read_whole(block, "P")
        if kind in (1, 10, 11):
            tool = self._read_tool(block, kind, number, self.values.list_named_axes(block))
            self.core.tools.define(tool, "" if adds_wear else "G10")
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
            self.set_origin(block, number or state.frame.system)
        else:
            self._set_origin_here(block, number or state.frame.system)

    def set_origin(self, block: Block, system: int, *, adds: bool = False) -> None:
        """G10 L2: the origin in machine coordinates, and R; or how far it moves."""
        frame = self.core.frames.build_stored_frame(system)
        origin = list(frame.origin)
        for axis in self.values.list_named_axes(block):
            origin[axis] = self.values.read_axis_value(block, axis) + (origin[axis] if adds else 0.0)
        self.core.frames.store_frame(replace(frame, origin=make_vector9(origin), turn=block.words.get("R", frame.turn)))

    def _set_origin_here(self, block: Block, system: int) -> None:
        """G10 L20: the origin such that the present place gets the given values."""
        if "R" in block.words:
            raise block.error("VP006", "G10 L20 does not use R", "R")
        axes, coordinates = self.values.list_named_axes(block), self.setup.coordinates
        self.core.require_known(block, axes, "G10 L20")
        frame = self.core.frames.build_stored_frame(system)
        here = coordinates.map_to_program(
            coordinates.map_to_machine(np.array(self.state.position), self.state.frame), frame
        )
        shift = np.zeros(9)
        for axis in axes:
            shift[axis] = here[axis] - self.values.read_axis_value(block, axis)
        shift[:3] = coordinates.turn_displacement(shift[:3], frame)
        self.core.frames.store_frame(replace(frame, origin=make_vector9(np.asarray(frame.origin) + shift)))

    def _read_tool(self, block: Block, kind: int, number: int, axes: list[int]) -> Tool:
        """A tool for the tool table: L1 the offset itself; L10, L11 such that the present place gets the values."""
        state = self.state
        if number < 1:
            raise block.error("VP007", f"P{number}: a tool number is 1 or more", "P")
        old = (state.tools or {}).get(
            number, Tool(number, number, ZERO9, unmeasured=f"G10 L{kind} in line {block.line}")
        )
        offset = np.array(old.offset)
        values = {axis: self.values.read_axis_value(block, axis) for axis in axes}
        if kind == 1:
            offset[axes] = list(values.values())
        else:
            self.core.require_known(block, axes, f"G10 L{kind}")
            if self.core.find_tilted_tool() is not None:
                raise ProgramError(
                    "VP017",
                    f"G10 L{kind} measures along Z, and the tool is tilted; turn the {self.setup.rotary_side} to "
                    f"{self.setup.rotary_letters[0]}0 first",
                )
            bare = replace(state.frame if kind == 10 else state.systems[9], tool=ZERO9)
            if kind == 11:
                bare = replace(bare, g92=ZERO9)
            coordinates = self.setup.coordinates
            here = coordinates.map_to_program(coordinates.map_to_machine(np.array(state.position), state.frame), bare)
            rotation = coordinates.turn_displacement(
                np.eye(3), bare
            )  # offsets count along the machine, values along the system
            offset[:3] = rotation @ offset[:3]
            for axis, value in values.items():
                offset[axis] = here[axis] - value
            offset[:3] = coordinates.turn_displacement(offset[:3], bare)
        diameter = 2 * self.values.convert_length(block.words["R"]) if "R" in block.words else old.diameter
        for letter in "IJQ":
            if letter in block.words:
                raise block.error("VP006", f"G10 L{kind} uses {letter} only on a lathe", letter)
        without_length = "" if _Z in values else old.unmeasured
        return dataclasses.replace(
            old, number=number, offset=make_vector9(offset), diameter=diameter, unmeasured=without_length, row=""
        )

    def execute_g92(self, block: Block, code: int) -> None:
        state = self.state
        axes = self.values.list_named_axes(block)
        if not axes:
            raise ProgramError("VP005", f"{spell_g_code(code)} needs at least one axis word")
        g92 = list(state.frame.g92)
        if code == 920:
            self.core.require_known(block, axes, "G92")
        for axis in axes:
            value = self.values.read_axis_value(block, axis)
            g92[axis] = value if code == 520 else g92[axis] + state.position[axis] - value
        self.core.frames.store_shift(g92)
        self.core.frames.apply_shift(on=True)
