"""Codes that move: straight moves, arcs, tool vectors, home positions, cutter compensation."""

import math
from typing import Final, Protocol

import numpy as np

from verne_post.base.tolerances import ARC_RADIUS_INCH_MM, ARC_RADIUS_MM, UPRIGHT_DEG, VECTOR_LENGTH, ZERO_LENGTH_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.gcode.arcs import build_arc_from_center, build_arc_from_radius
from verne_post.gcode.block import Block
from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.lengths import measure_length
from verne_post.gcode.machining.compensation import Compensation
from verne_post.gcode.machining.machining import (
    Machining,
    explain_inverse_time,
    explain_no_feed,
    name_word,
    refuse_bare_arc,
    warn_of_other_plane,
)
from verne_post.gcode.machining.turning import find_machine_place, go_to_machine, turn_table, warn_of_unnamed
from verne_post.gcode.missing_setup import (
    advise_length,
    find_length_key,
    find_tool_key,
    report_unloaded,
    stands_in,
    suggest_call,
)
from verne_post.gcode.program_error import FILL_IN_LENGTH, ProgramError, locate_errors, write_before
from verne_post.gcode.rs274.modes import NO_MAPS, TCP_CODES, Modes
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.rs274.values import MAX_LENGTH_MM, WordValues, read_whole
from verne_post.model.moves import AXES, MoveKind
from verne_post.model.part_setup import describe_tool_number
from verne_post.model.protocols import name_solution

_X, _Y, _Z = 0, 1, 2
_LINEAR: Final = frozenset((_X, _Y, _Z))
_ROTARY: Final = frozenset((3, 4, 5))
#: So many turns of one arc at most.
MAX_TURNS: Final = 10_000


#: What gives a tool length.
LENGTH_WORDS: Final = "G43 H with --tool-table, --tool-length MM, or G49 for length 0"


def refuse_lacking(
    core: Machining,
    name: str,
    *,
    given: bool,
    length_words: str,
    turns_itself: bool = False,
    feed_words: str = "F",
    loads_lengths: bool = False,
) -> None:
    """Refuse a feed move, ``name``, that lacks a feed rate (VP009) or a tool length (VP012).

    ``given``: its block has its own F, which inverse-time feed needs; ``turns_itself``: it switches the spindle on;
    ``loads_lengths``: M6 brings the length of its tool.
    """
    lacking = core.find_lacking(given=given, turns_itself=turns_itself)
    if lacking == "F in the block":
        text = f"{name} with inverse-time feed (G93) needs F in the same block, or G94"
        raise explain_inverse_time(core, ProgramError("VP009", text))
    if lacking == "feed rate":
        raise ProgramError("VP009", f"{name} with feed rate zero; {explain_no_feed(core, feed_words)}")
    if lacking == "constant spindle speed":
        raise ProgramError(
            "VP017",
            f"{name} with feed per revolution (G95) under G96: the feed rate would depend on the spindle speed, and "
            "that on the distance of the tool from X0; write G94, or G97 with S",
        )
    if lacking == "spindle":
        raise ProgramError("VP009", f"{name} with feed per revolution (G95) needs a turning spindle; give S and M3")
    if lacking == "tool length":
        state = core.state
        tool, selections = (state.tools or {}).get(state.loaded_tool or 0), core.recorder.selections
        if loads_lengths and not state.loaded_tool and selections and not selections[-1].is_loaded:
            raise report_unloaded(selections[-1], "the first feed move")
        forms = (
            ("T{word} D1 and M6", "T D1 and M6")
            if loads_lengths
            else ("T{word} M6 and G43 H{number}", "T M6 and G43 H")
        )
        if not selections and (how := suggest_call(core.setup, state, *forms)):
            raise ProgramError(
                "VP012", f"no tool is called before the first feed move; {how}".replace('T"', 'T="')
            ).advise("")
        if selections and not selections[-1].is_loaded and not state.loaded_tool:
            selection = selections[-1]
            if selection.number in (state.tools or {}):
                then = f"G43 H{selection.number}"
                text = (
                    f"{selection.spell()} of line {selection.own_line} only selects the tool, and no length is in "
                    f"force before the first feed move; write {selection.describe_change()}, and "
                    f"{then} before this move"
                )
                raise ProgramError("VP012", text, edits=write_before(then)).advise("")
        length = None if tool is None or tool.unmeasured else tool.offset[2]
        # a tool that no table has was reported at its call; that nothing takes its length is another mistake
        is_reported = tool is not None and stands_in(tool) and bool(selections) and selections[-1].is_loaded
        if not state.loaded_tool or (length == 0.0 and not is_reported) or (loads_lengths and length is None):
            raise ProgramError(
                "VP012",
                f"no tool length has been given before the first feed move; use {length_words}",
                settled_by=() if state.loaded_tool else find_length_key(core.setup),
            ).advise(advise_length(core.setup))
        number = state.loaded_tool
        how = f"write G43 H{number} before it, or G49 for length 0: a length of [tools] or of a tool table is in force "
        how += "from G43 on; --tool-length MM, for programs with one tool, needs no G43"
        raise ProgramError(
            "VP012",
            f"{describe_tool_number(number, state.tool_names)} has no length in force before the first feed move; "
            f"{f'use {length_words}' if loads_lengths else how}",
            settled_by=find_tool_key(number, "length", state.tool_names) if length is None else (),
            edits=() if loads_lengths else write_before(f"G43 H{number}"),
        ).advise(FILL_IN_LENGTH if length is None else "")


class Directions(Protocol):
    """What reads X, Y, Z in directions of the machine."""

    def hold(self) -> bool:
        """True while they count so."""

    def turn(self, block: Block, kind: MoveKind, axes: list[int]) -> None:
        """A move that names rotary axes."""


class MotionCodes:
    """Codes that move the axes, and cutter compensation."""

    def __init__(self, core: Machining, values: WordValues, traits: Traits) -> None:
        self.core, self.values, self.traits = core, values, traits
        self.setup, self.state, self.recorder = core.setup, core.state, core.recorder
        self.modes: Modes = core.state.modes
        #: G2 and G3 without I, J, K and R go straight; else they are refused, with ``bare_arcs_remedy``.
        self.bare_arcs_are_lines = False
        self.bare_arcs_remedy = ""
        #: D is the wear of the tool, which is 0; else the tool of the table.
        self.offsets_are_wear = False
        #: Where moves with A, B or C go while X, Y, Z are in directions of the machine; None where they never are.
        self.directions: Directions | None = None
        #: Where lines and arcs go: to the core, or where a language has corners that need the next one.
        self.draw_line, self.draw_arc = core.go_straight, core.go_on_arc

    # --- home --------------------------------------------------------------------------------

    def go_home(self, block: Block, code: int) -> None:
        state, setup = self.state, self.setup
        self.core.refuse_compensation(spell_g_code(code))
        home = state.home if code == 280 else state.home2
        if home is None:
            raise ProgramError(
                "VP015",
                f"{spell_g_code(code)} needs the home position of the machine: add [home] {spell_g_code(code).lower()} "
                "to the machine file, or retract with G53 G0 Z0",
            )
        axes = self.values.list_named_axes(block)
        # an incremental via word of 0 means no via point, so the axis need not be known
        moving = [axis for axis in axes if self.modes.absolute or block.words[AXES[axis]] != 0.0]
        if not self.modes.absolute:
            self.core.require_known(block, moving, f"{spell_g_code(code)} with an incremental via point")
        if self.traits.turns_table_alone and self._is_turned_alone(moving):
            self._turn_table(block, MoveKind.RAPID, moving)
        else:
            self._go_via(block, moving)
        chosen_axes = axes or [axis for axis, letter in enumerate(AXES) if letter in setup.axes]
        for axis in chosen_axes:
            if math.isnan(home[axis]):
                raise ProgramError(
                    "VP015", f"{spell_g_code(code)} needs the home position of {AXES[axis]}, which was never set"
                )
        self.core.end_tool_axis(block, chosen_axes)
        go_to_machine(self.core, block, MoveKind.RAPID, self._find_home_targets(block, code, home, chosen_axes))

    def _go_via(self, block: Block, moving: list[int]) -> None:
        """To the via point of G28 and G30; without one nothing moves."""
        state = self.state
        if state.tool_axis is not None or self.modes.vectors:
            self._check_vector_axes(block, moving, machine=False)
        start = self.core.start_of_motion(
            MoveKind.RAPID, absolute=self.modes.absolute, machine=not moving, axes=moving, at=block
        )
        via = self._find_end(block, start, moving)
        if state.tcp_off and moving:
            self.core.check_tcp_off(state.position, via)
        self._warn_of_way_down(block, start, via, moving)
        self._move_straight(block, MoveKind.RAPID, via, moving)

    def _warn_of_way_down(self, block: Block, start: list[float], via: list[float], moving: list[int]) -> None:
        """VP052: the way home goes by a Z of the part that is below the tool, or that the program names first here."""
        is_known = self.state.named_axes[_Z]
        if not self.modes.absolute or _Z not in moving or (is_known and via[_Z] > start[_Z] - ZERO_LENGTH_MM):
            return
        how = f"{start[_Z] - via[_Z]:.6g} mm down to" if is_known else "by"
        z = via[_Z] / self.values.convert_length(1.0)
        text = f"the way home goes {how} Z{z:.6g} of the part first, because G90 is active"
        self.recorder.warn("VP052", f"{text}: write G91 G28 Z0, then G90", block.line, None)

    def _find_end(self, block: Block, start: list[float], axes: list[int]) -> list[float]:
        """Where a move from ``start`` (9) ends by the words of a block."""
        end = list(start)
        if self.setup.rotary[1] in axes:
            self.recorder.fix_c(block.line)
        for axis in axes:
            value = self.values.read_axis_value(block, axis)
            end[axis] = value if self.modes.absolute else end[axis] + value
        return end

    def _find_home_targets(self, block: Block, code: int, home: tuple[float, ...], axes: list[int]) -> dict[int, float]:
        """Machine coordinates of axes that go home; X or Y alone goes along its direction in a turned work system."""
        targets = {axis: home[axis] for axis in axes}
        state, coordinates = self.state, self.setup.coordinates
        if not state.frame.turn or len({_X, _Y} & set(axes)) != 1:
            return targets
        axis = _X if _X in axes else _Y
        name = f"{spell_g_code(code)} {AXES[axis]} alone in a turned work system (R of G10 L2)"
        self.core.require_known(block, [_X, _Y], name)
        if math.isnan(home[_X]) or math.isnan(home[_Y]):
            raise ProgramError("VP015", f"{name} needs the home position of X and of Y")
        here = np.array([state.position, state.position])
        here[1, axis] += 1.0
        place, beside = coordinates.map_to_machine(here, state.frame)[:, :3]
        angle = RAD_PER_DEG * state.frame.turn + (0.5 * math.pi if axis == _Y else 0.0)
        direction = np.array([math.cos(angle), math.sin(angle), 0.0])
        if np.abs(beside - place - direction).max() > RAD_PER_DEG * UPRIGHT_DEG:
            raise block.error(
                "VP017",
                f"{name}, with the {self.setup.rotary_side} turned or tilted: {AXES[axis]} is not a direction of the "
                f"machine; name X and Y together, or turn to {'0 '.join(self.setup.rotary_letters)}0 before",
                AXES[axis],
            )
        end = place + np.dot([home[_X] - place[0], home[_Y] - place[1]], direction[:2]) * direction
        return targets | {_X: float(end[0]), _Y: float(end[1])}

    # --- motion ----------------------------------------------------------------------------------

    def move(self, block: Block, motion: int, *, machine: bool) -> None:
        kind = MoveKind.RAPID if motion == 0 else MoveKind.FEED
        axes = self.values.list_named_axes(block)
        state = self.state
        if self.bare_arcs_are_lines and motion in (20, 30) and block.words.keys().isdisjoint("IJKR"):
            self.recorder.note_once(
                "VP039",
                f"{spell_g_code(motion)} without I, J, K and R goes straight ([fanuc] bare_arcs): where an arc was "
                "meant, its words are missing",
                block.line,
            )
            motion = 10
        if kind == MoveKind.FEED and not (motion == 10 and self._goes_beside_part(block, axes)):
            self.check_feed(block, motion)
        in_machine = self.directions is not None and self.directions.hold()
        if in_machine and not machine and motion in (0, 10) and not _ROTARY.isdisjoint(axes):
            assert self.directions is not None
            self.directions.turn(block, kind, axes)
            return
        if not machine and motion in (0, 10) and self.traits.turns_table_alone and self._is_turned_alone(axes):
            self._turn_table(block, kind, axes)
            return
        if state.tool_axis is not None or self.modes.vectors:
            self._check_vector_axes(block, axes, machine=machine)
        if machine:
            self.core.refuse_compensation("G53")
            self.core.end_tool_axis(block, axes)
            go_to_machine(self.core, block, kind, {axis: self.values.read_axis_value(block, axis) for axis in axes})
            return
        if False in state.known_axes:
            if motion in (20, 30):
                self.core.require_known(block, self._find_arc_axes(axes), "an arc")
            if not self.modes.absolute:
                self.core.require_known(block, axes, "an incremental move")
        start = self.core.start_of_motion(kind, absolute=self.modes.absolute, machine=False, axes=axes, at=block)
        if in_machine:  # axes of the machine that are not named stand, whatever length the tool has now
            start = list(state.position)
        end = self._find_end(block, start, axes)
        if state.tcp_off:
            self.core.check_tcp_off(start, end)
        if motion in (0, 10) and self.modes.vectors and any(letter in block.words for letter in "IJK"):
            end = self._aim_tool(block, end)
            axes = [*axes, *self.setup.rotary] if self.setup.machine else axes
        if motion in (20, 30):
            self._move_on_arc(block, motion, start, end)
        else:
            self._move_straight(block, kind, end, axes)

    def _move_straight(self, block: Block, kind: MoveKind, end: list[float], axes: list[int]) -> None:
        turns = not _ROTARY.isdisjoint(axes)
        is_retracted = turns and _Z not in axes and self.is_retracted()
        before = find_machine_place(self.core) if is_retracted or (turns and self._is_turned_alone(axes)) else None
        self.draw_line(block, kind, end, axes, absolute=self.modes.absolute)
        if before is not None:
            when = "while no tool length is in force"
            if is_retracted:
                when = "where no Z of the tip is programmed, as after G53 and G28"
            other = ""
            if self.traits.turns_table_alone:
                other = ", or cancel the tool length before it (G49)"
            elif self._is_turned_alone(axes):
                other = ", or read it as a Fanuc program (--dialect fanuc)"
            turn = f"a turn of the {self.setup.rotary_side}"
            why = f"{when}, {turn} keeps the tip at its place of the part"
            remedy = f"name X, Y and Z in it, or write G53 in it{other}"
            if is_retracted and self.modes.length_code in TCP_CODES:
                code, line = spell_g_code(self.modes.length_code), self.core.word_lines["length"]
                why = f"{code} of line {line} is active and keeps the tip at its place of the part in {turn}"
                remedy = "write G49 before this line if the tool is done, else name X, Y and Z, or write G53 in it"
            warn_of_unnamed(self.core, block, before, axes, why, remedy)

    def _goes_beside_part(self, block: Block, axes: list[int]) -> bool:
        """True for X and Y of a head that is retracted and has no length yet: posts write such rapids as G1.

        Over an upright table the head stays at its height in the machine, and no length alters its way. Over another
        one it is refused.
        """
        if self.state.has_tool_length or not self.setup.machine:  # most lines end here
            return False
        if not set(axes) <= {_X, _Y} or not self.is_retracted():
            return False
        if self.core.find_lacking(given="F" in block.words) != "tool length":
            return False
        machine = self.setup.coordinates.map_to_machine(np.array(self.state.position), self.state.frame)
        tilt = float(machine[self.setup.rotary[0]])
        if abs(tilt) > UPRIGHT_DEG:
            letter = self.setup.rotary_letters[0]
            raise ProgramError(
                "VP012",
                f"no tool length has been given before a feed move with the {self.setup.rotary_side} at {letter} "
                f"{tilt:g}, where the height of the spindle depends on it; use {LENGTH_WORDS}, or turn to "
                f"{letter}0 before",
                settled_by=find_length_key(self.setup),
            ).advise(advise_length(self.setup))
        self.recorder.first_cut = self.recorder.count + 1
        return True

    def is_retracted(self) -> bool:
        """True where Z of the tip follows from machine coordinates (G53, G28) alone; never with tool vectors."""
        return (
            self.setup.machine and self.state.has_position and not self.state.named_axes[_Z] and not self.modes.vectors
        )

    def _is_turned_alone(self, axes: list[int]) -> bool:
        """True where A or C are named, not all of X Y Z, and the tip is not held, or would not be on a control."""
        return not _ROTARY.isdisjoint(axes) and not _LINEAR.issubset(axes) and self.is_without_tcp()

    def is_without_tcp(self) -> bool:
        """True where no tool length holds, or a code of the control says that the tip is not held."""
        code = self.modes.length_code
        if not self.setup.machine or code in (434, 435):
            return False
        if code == 490 or self.state.length_end or (self.traits.turns_table_alone and self.recorder.tcp_changes):
            return True  # where the program knows G43.4 or G68.2, it has not written G43.4 here
        return code is None and not any(self.state.frame.tool)

    def _turn_table(self, block: Block, kind: MoveKind, axes: list[int]) -> None:
        if not self.modes.absolute:
            self.core.require_known(block, axes, "an incremental move")
        if set(self.setup.rotary) & set(axes):
            self.core.end_tool_axis(block, [axis for axis in axes if axis in _ROTARY])
        here = [0.0] * len(AXES) if self.modes.absolute else self.state.position
        words = {axis: here[axis] + self.values.read_axis_value(block, axis) for axis in axes}
        turn_table(self.core, block, kind, words)

    def _check_vector_axes(self, block: Block, axes: list[int], *, machine: bool) -> None:
        """While a tool axis holds, A and C words mean nothing; after it, both must come together."""
        rotary = [axis for axis in axes if axis in _ROTARY]
        if not rotary:
            return
        letter = AXES[rotary[0]]
        if self.modes.vectors:
            raise block.error(
                "VP006",
                f"{self.setup.both_rotary} under G43.5, where I J K give the tool axis; use G43.4 for these words",
                letter,
            )
        if len(rotary) < 2 if not self.setup.machine else not set(self.setup.rotary) <= set(rotary):
            raise block.error(
                "VP013",
                f"{letter} alone after tool vectors: no word has chosen between the two "
                f"{name_solution(self.setup.coordinates)}s; name {self.setup.both_rotary} together",
                letter,
            )
        if not machine:
            self.core.hold_tool_axis(None)

    def _aim_tool(self, block: Block, end: list[float]) -> list[float]:
        """Take the tool axis I J K: the end point with a pair A, C that holds it."""
        for letter in "IJK":
            if letter not in block.words:
                given = next(other for other in "IJK" if other in block.words)
                raise block.error("VP005", f"{given} without {letter}: a tool axis needs I, J and K", given)
        vector = np.array([block.words[letter] for letter in "IJK"])
        size = float(measure_length(vector))
        if abs(size - 1.0) > VECTOR_LENGTH:
            text = f"the tool axis ({self.core.axis_words}) has length {size:.6g}; it must be a unit vector"
            raise block.error("VP007", text, "I")
        self.core.hold_tool_axis(vector / size)
        return self.setup.coordinates.turn_to_axis(end, vector / size, self.state.frame)

    @staticmethod
    def _find_arc_axes(axes: list[int]) -> list[int]:
        return sorted({0, 1, 2, *axes})

    def check_feed(self, block: Block, motion: int, *, turns_itself: bool = False) -> None:
        given = "F" in block.words
        if self.core.find_lacking(given=given, turns_itself=turns_itself) is not None:
            refuse_lacking(
                self.core, spell_g_code(motion), given=given, length_words=LENGTH_WORDS, turns_itself=turns_itself
            )

    def _move_on_arc(self, block: Block, motion: int, start: list[float], end: list[float]) -> None:
        state = self.state
        offsets = {letter: self.values.convert_length(block.words[letter]) for letter in "IJK" if letter in block.words}
        if self.setup.machine:
            for letter in "IJKR":
                if abs(self.values.convert_length(block.words.get(letter, 0.0))) > MAX_LENGTH_MM:
                    raise block.error("VP007", f"{letter}{block.words[letter]:g} is beyond any machine", letter)
        turns = read_whole(block, "P") if "P" in block.words else 1
        if not 1 <= turns <= MAX_TURNS:
            raise block.error("VP007", f"P{turns}: the number of turns is 1 to {MAX_TURNS}", "P")
        clockwise = motion == 20
        if "R" in block.words:
            if offsets:
                raise block.error("VP003", "an arc has either R or a centre (I, J, K), not both", "R")
            radius, unit = (self.values.convert_length(one) for one in (block.words["R"], 1.0))
            with locate_errors(block.columns.get("R")):
                arc = build_arc_from_radius(start, end, state.plane, clockwise, radius, turns - 1, unit)
            warn_of_other_plane(self.core, self.values.list_named_axes(block), start, end, radius, block.line)
        elif offsets:
            tolerance = ARC_RADIUS_INCH_MM if self.modes.inch else ARC_RADIUS_MM
            plane_word = name_word(self.core, "plane", f"G{17 + state.plane}", block.line)
            arc = build_arc_from_center(
                start,
                end,
                state.plane,
                clockwise,
                offsets,
                self.modes.absolute_centers,
                turns - 1,
                tolerance,
                plane_word,
                self.values.convert_length(1.0),
                is_scaled=self.modes.maps is not NO_MAPS,
            )
        else:
            text = f"an arc needs its centre (I, J, K) or its radius (R){self.bare_arcs_remedy}"
            raise refuse_bare_arc(self.core, f"G{motion // 10}", block.line, text)
        self.draw_arc(block, start, end, arc, self.values.list_named_axes(block), absolute=self.modes.absolute)

    # --- cutter compensation ------------------------------------------------------------------------

    def compensate(self, block: Block, code: int) -> None:
        """G40, G41, G42, G41.1, G42.1; a negative diameter (G41.1, G42.1) changes the side."""
        if code == 400:
            self.core.end_compensation()
            return
        name = spell_g_code(code)
        if self.modes.vectors:
            text = f"{name} while a tool axis (I J K) is in force; write G49 before"
            raise ProgramError("VP017", f"{text}, and name {self.setup.both_rotary} in a move after it")
        self.core.check_compensation(name)
        radius = 0.5 * self.find_cutter_diameter(block, code)
        self.core.start_compensation(
            Compensation(
                code,
                self.state.plane,
                radius if code < 420 else -radius,
                block.line,
                offset=0 if code % 10 else int(block.words.get("D", 0)),
                perpendicular=self.traits.perpendicular_entry,
                at_once=self.traits.begins_at_once,
            )
        )

    def find_cutter_diameter(self, block: Block, code: int) -> float:
        state = self.state
        if code % 10:  # in the block
            if "D" not in block.words:
                raise ProgramError("VP005", f"{spell_g_code(code)} needs D, the diameter")
            return self.values.convert_length(block.words["D"])
        if self.traits.zero_is_no_offset:
            if "D" not in block.words:
                if self.modes.cutter_number is None:
                    raise ProgramError(
                        "VP005", f"{spell_g_code(code)} needs D, the number of the offset, after the tool change"
                    )
                block.words["D"] = float(self.modes.cutter_number)
            if not block.words["D"] or self.offsets_are_wear:
                return 0.0
        number = (read_whole(block, "D") if "D" in block.words else 0) or state.loaded_tool or 0
        if number == 0:
            other = (
                f", or write {spell_g_code(code + 1)} with the diameter (D0 for a path on the contour)"
                if self.traits.diameter_codes
                else ""
            )
            raise ProgramError(
                "VP012", f"{spell_g_code(code)} without D, and {self.core.tools.explain_empty_spindle()}{other}"
            ).advise("")
        instead = f", or use {spell_g_code(code + 1)} D" if self.traits.diameter_codes else ""
        diameter = self.core.tools.find_diameter(block, number, instead)
        self.core.tools.compare_diameter(block, number)
        return diameter
