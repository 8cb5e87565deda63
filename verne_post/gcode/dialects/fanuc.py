"""G-code of Fanuc controls (and of those that speak like them), with tool-centre-point and tilted-plane codes.

What means the same as in RS274/NGC is executed by the same interpreter; here stands what differs: times in
milliseconds, K for repeats, subprogram words, G54.1, G68.2 with G53.1, exact stops. docs/gcode.md has the table.
"""

import math
import re
from typing import ClassVar, Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Ints
from verne_post.base.long_text import Text
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.gcode.block import Block
from verne_post.gcode.codes import CYCLES, TAKES_AXES, CodeTable, g_name
from verne_post.gcode.dialect import Dialect, dialect_of_blocks
from verne_post.gcode.execution import Execution, StopConditions, execute_blocks
from verne_post.gcode.initial_state import initial_state
from verne_post.gcode.machining.state import State
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.fanuc_codes import (
    ADDITIONAL,
    ALONE,
    HIGH_SPEED,
    NAMES_AXES,
    PLANE,
    PLANE_OFF,
    SMOOTHING,
    TWINS,
    make_table,
)
from verne_post.gcode.rs274.fanuc_header import is_fanuc
from verne_post.gcode.rs274.fanuc_points import (
    INCREMENT,
    find_mixture,
    find_unrounded,
    lines_without_point,
    scale_words,
)
from verne_post.gcode.rs274.fanuc_text import NESTED, end_of_number, find_program, prepare_line
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.nurbs import NURBS, NurbsCodes
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.rs274.values import whole
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import FanucKeys, read_keys
from verne_post.model.moves import AXES, ArcFeed, Feature, MoveKind, PathControl, PathMode
from verne_post.model.part_setup import ADDITIONAL_SYSTEMS

_SECONDS_PER_P: Final = 1e-3
_MACRO: Final = re.compile(
    r"\s*(?:N\s*\d+\s*)?(IF|WHILE|GOTO|DO|END|THEN|POPEN|PCLOS|DPRNT|BPRNT|SETVN)\b", re.IGNORECASE
)
#: What of a comment with others in it stands after its first end, up to the parenthesis that was meant.
_LEFT_OVER: Final = re.compile(r"[^()]*\)")


class FanucInterpreter(Rs274):
    """The interpreter of RS274/NGC, which gets blocks in its words."""

    table: ClassVar[CodeTable] = make_table()
    traits: ClassVar[Traits] = Traits(
        zero_is_no_offset=True,
        perpendicular_entry=True,
        begins_at_once=False,
        diameter_codes=False,
        beside_spline=(NURBS,),
        spline_end="as many blocks with K alone as the order of the spline end it",
        needs_dwell=(820, 890),
        feeds_out_whole=False,
        keeps_heights=True,
        stores_without_holes=True,
        taps_rigidly=True,
    )
    percent: ClassVar[bytes] = rb"[^\n]*"
    o_letters: ClassVar[bytes] = b"O:"
    end_alone: ClassVar[bool] = True
    custom_macro: ClassVar[bool] = True
    plain_words: ClassVar[bool] = True

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        super().__init__(setup, state, recorder)
        self.nurbs = NurbsCodes(self.core, self.values, self.motion)
        given = setup.control.get("fanuc", {})
        self.keys: FanucKeys = read_keys(FanucKeys, given)
        least = 0.01 * self.keys.inside_arc_percent
        self.core.set_arc_feed(ArcFeed("[fanuc] inside_arc_percent", least, 1.0, assumed=not given))

    @classmethod
    def leave_to_reader(cls, text: bytes, setup: Setup) -> Ints:
        """Words without a decimal point, where they count increments."""
        if setup.control.get("fanuc", {}).get("decimal_point") != "conventional":
            return super().leave_to_reader(text, setup)
        return lines_without_point(text)

    def _execute_cycle(self, block: Block, motion: int, *, goes_on: bool) -> None:
        """As RS274/NGC; says what it does where R is above the tool."""
        above = self.state.position
        super()._execute_cycle(block, motion, goes_on=goes_on)
        cycle = self.modes.cycle
        if cycle is not None and above[cycle.normal] < cycle.clear - ZERO_LENGTH_MM:
            self.recorder.note_once(
                "VP039", "R of a canned cycle is above the tool: it goes up to R first and then over the hole, and stays "
                "at R after it, also under G98; a control may go over the hole first", block.line,
            )  # fmt: skip

    def _show_comment(self, block: Block) -> None:
        """These controls have no messages in comments."""

    @classmethod
    def prepare(cls, text: str) -> str:
        """``:1000`` is O1000, ``/2`` is ``/``, ``(a (b))`` is one comment; every character keeps its column."""
        return prepare_line(text)

    @classmethod
    def label_of(cls, text: str) -> str:
        """The program number, without the words beside it."""
        text = prepare_line(text)
        return text[: end_of_number(text)] if end_of_number(text) else text

    @classmethod
    def find_start(cls, source: Text) -> int:
        """The ``%`` before the first program number: a control reads nothing before it."""
        return find_program(source)

    def read(self, text: str, line: int) -> Block:
        """Read a line; custom macros are refused by name."""
        macro = _MACRO.match(text)
        if macro is not None:
            raise ProgramError(
                "VP002",
                f"{macro.group(1).upper()}: custom macro statements are not executed, only parameters and expressions",
                macro.start(1) + 1,
            )
        nested, text = NESTED.search(text), self.prepare(text)
        number = end_of_number(text)
        text = " " * number + text[number:]
        try:
            block = super().read(text, line)
        except ProgramError as error:
            if nested is None or (error.column or 0) <= nested.end() or not _LEFT_OVER.match(text, nested.end()):
                raise
            raise ProgramError(
                error.code,
                f"the comment that begins in column {nested.start() + 1} ends at the ')' of column {nested.end(1) + 1}, because comments do not "
                f"nest; what follows is read as words, and there {error.message}",
                error.column,
            ) from None
        if self.keys.decimal_point == "conventional":
            codes = {round(number * 10) for letter, number, _column in block.codes if letter == "G"}
            scale_words(block, text, self.state, drills=self._drills(block, codes))
        if "#" in text and (letter := find_unrounded(block, text, self.state)) is not None:
            self.recorder.note_once(
                "VP039", f"{letter} has a value with more digits than the least input increment ({INCREMENT:g}): it is used as it is; "
                "a control rounds it", line,
            )  # fmt: skip
        if block.o is not None and block.o.keyword is not None:
            raise ProgramError(
                "VP002", f"O{block.o.label} {block.o.keyword}: O words with keywords are RS274/NGC; see --dialect rs274"
            )
        return block

    def execute(self, block: Block) -> None:
        """Execute one block, in the words of RS274/NGC."""
        self.call = None
        if block.comment is None and not block.settings and self.execute_plain_motion(block):
            return
        codes = {round(number * 10) for letter, number, _column in block.codes if letter == "G"}
        self._convert_times(block, codes)
        self._convert_repeats(block, codes)
        modal = self._convert_rapids(block, codes)
        super().execute(block)
        if ("M", 6.0) in [code[:2] for code in block.codes]:
            self.modes.cutter_number = None
        if "D" in block.words:
            self.modes.cutter_number = whole(block, "D")
        if modal is not None:
            self.modes.motion = modal

    # --- the same thing in other words -----------------------------------------------------------

    def _convert_times(self, block: Block, codes: set[int]) -> None:
        """G4 X or U in seconds, P in milliseconds, also in cycles."""
        words, columns = block.words, block.columns
        if 40 in codes:
            for letter in "XU":
                if letter in words:
                    if "P" in words:
                        raise ProgramError("VP003", f"G4 with {letter} and P; one of them is the time", columns[letter])
                    words["P"], columns["P"] = words.pop(letter), columns.pop(letter)
                    return
        if "P" in words and (40 in codes or self._drills(block, codes)):
            whole(block, "P")
            words["P"] *= _SECONDS_PER_P

    def _drills(self, block: Block, codes: set[int]) -> bool:
        """True where the words of a block are those of a cycle: no other code takes them."""
        if codes & {*TAKES_AXES, ADDITIONAL, *SMOOTHING, 0, 10, 20, 30, 40, 800} or self._has_call(block):
            return bool(codes & set(CYCLES))
        return bool(codes & set(CYCLES)) or self.modes.motion in CYCLES

    @staticmethod
    def _has_call(block: Block) -> bool:
        """True where M98 or M99 stands in the block: P is theirs."""
        return any(letter == "M" and number in (98, 99) for letter, number, _column in block.codes)

    def _convert_repeats(self, block: Block, codes: set[int]) -> None:
        """K of cycles is L; M98 P with more than four digits has the repeats before the number."""
        words, columns = block.words, block.columns
        if "K" in words and "I" not in words and self._drills(block, codes):
            if "L" in words:
                raise ProgramError(
                    "VP003", "K and L in one block: both would be the repeats of the cycle", columns["K"]
                )
            words["L"], columns["L"] = words.pop("K"), columns.pop("K")
        if any(letter == "M" and number == 98 for letter, number, _column in block.codes) and "P" in words:
            number = whole(block, "P")
            if number > 9999 and "L" not in words:
                words["P"], words["L"], columns["L"] = float(number % 10000), float(number // 10000), columns["P"]
        if any(letter == "M" and number == 99 for letter, number, _column in block.codes) and "P" in words:
            raise ProgramError("VP002", "M99 P (return to a block number) is not executed", columns["P"])

    def _convert_rapids(self, block: Block, codes: set[int]) -> int | None:
        """G28, G30 and G53 are rapid moves in themselves; a G0 beside them is only modal. Returns the modal motion after the block."""
        motion = next((code for code in codes if code in self.table.g_groups["motion"]), None)
        if codes & {280, 300}:
            block.codes = [
                code
                for code in block.codes
                if code[0] != "G" or round(code[1] * 10) not in self.table.g_groups["motion"]
            ]
            if 300 in codes and block.words.get("P") == 2.0:
                del block.words["P"], block.columns["P"]
            return motion
        if 530 in codes and motion is None:
            column = next(
                column for letter, number, column in block.codes if letter == "G" and round(number * 10) == 530
            )
            block.codes.append(("G", 0.0, column))
            return self.modes.motion
        return None

    def _g_code(self, number: float, column: int) -> int:
        """The code of a G word; twins of one code are that code."""
        code = super()._g_code(number, column)
        return TWINS.get(code, code)

    # --- codes of Fanuc alone ------------------------------------------------------------------------------

    def _set_modes(self, block: Block, g: dict[str, int]) -> None:
        if "tilted plane" in g:
            self._set_tilted_plane(block, g["tilted plane"])
        super()._set_modes(block, g)
        if "cancel" in g or g.get("motion", 840) not in (740, 840):
            self.modes.stops_after_tapping = False
        if g.get("path control") == 610:  # here the tool stops at the end of every move
            self.core.set_path_control(PathControl(PathMode.EXACT_STOP))
        if "smoothing" in g:
            words = {letter: block.words[letter] for letter in "PQR" if letter in block.words}
            if g["smoothing"] == 50 and words.get("P") not in HIGH_SPEED:
                raise block.error(
                    "VP002", "G5 is only executed with P0 to P3 and P10000: other numbers call high-speed cycles", "P"
                )
            self.recorder.event(block.line, "smoothing", code=f"G{g['smoothing'] / 10:g}", **words)
        if "plane axis" in g:
            self._turn_to_plane(block)

    def _system_number(self, block: Block, code: int) -> int:
        if self.state.frame.feature is not None:
            raise ProgramError("VP017", "a change of work offset under G68.2; write G69 first")
        if code != ADDITIONAL:
            return super()._system_number(block, code)
        if "P" not in block.words:
            raise ProgramError("VP005", "G54.1 needs P, the number of the work system")
        system = ADDITIONAL_SYSTEMS + self._additional_system(block)
        del block.words["P"]  # and no dwell of a cycle
        return system

    def _additional_system(self, block: Block) -> int:
        number = whole(block, "P")
        if ADDITIONAL_SYSTEMS + number not in self.state.systems or number == 0:
            last = max(self.state.systems) - ADDITIONAL_SYSTEMS
            raise block.error("VP007", f"P{number}: additional work systems are P1 to P{last}", "P")
        return number

    def _choose_motion(self, block: Block, g: dict[str, int], axes: list[str]) -> int | None:
        motion = super()._choose_motion(block, g, axes)
        return NURBS if motion is None and self.nurbs.goes_on(block, g) else motion

    def _execute_spline(self, block: Block, _motion: int) -> None:
        self.nurbs.execute(block)

    def _execute_non_modal(self, block: Block, code: int) -> None:
        if code in (100, 520, 920) and self.state.frame.feature is not None:
            raise ProgramError("VP017", f"{g_name(code)} under G68.2; write G69 first")
        if code == 100:
            self._store_offset(block)
        elif code in (520, 920):
            self._shift_system(block, code)
        else:
            super()._execute_non_modal(block, code)

    def _store_offset(self, block: Block) -> None:
        """L2: G54 to G59; L20: G54.1 P; L10: the length of a tool, as L1 of RS274/NGC has it."""
        words = block.words
        if "L" not in words:
            raise ProgramError("VP005", "G10 needs L: L2 for G54 to G59, L20 for G54.1, L10 for the length of a tool")
        kind = whole(block, "L")
        if not self.modes.absolute:
            raise ProgramError("VP017", "G10 in G91 adds to what is stored; write G90, and the whole value")
        if kind == 2 and words.get("P") == 0:
            raise block.error("VP007", "P0: the external work offset is not kept here; give it with --wcs", "P")
        if kind == 20 and "P" in words:
            self.offsets.set_origin(block, ADDITIONAL_SYSTEMS + self._additional_system(block))
            return
        if kind == 10:
            if "R" not in words:
                raise ProgramError("VP005", "G10 L10 needs R, the length")
            words["L"], words["Z"], block.columns["Z"] = 1.0, words.pop("R"), block.columns.pop("R")
        elif kind == 2 and "R" in words:
            raise block.error("VP006", "G10 L2 does not use R: work systems are not turned here", "R")
        elif kind != 2:
            raise block.error("VP002", f"G10 L{kind} is not executed; expected L2, L10 or L20", "L")
        self.offsets.execute_g10(block)

    def _shift_system(self, block: Block, code: int) -> None:
        """G92, and G52: a system inside that of G92, which ends it on the axes that it names."""
        state, axes = self.state, self.values.named_axes(block)
        local, outer = list(self.modes.local_shift), np.subtract(state.frame.g92, self.modes.local_shift)
        self.offsets.execute_g92(block, code)
        for axis in axes:
            local[axis] = self.values.axis_value(block, axis) if code == 520 else 0.0
        self.modes.local_shift = tuple(local)
        if code == 520:
            self.core.frames.store_shift(float(value) for value in outer + local)
            self.core.frames.apply_shift(on=True)

    def _usable_words(self, block: Block, g: dict[str, int], m: dict[str, list[int]], motion: int | None) -> set[str]:
        """D may stand without G41 and G42: the next one takes it."""
        usable = super()._usable_words(block, g, m, motion)
        return usable if self.state.compensation is not None else usable | {"D"}

    # --- tilted work plane -------------------------------------------------------------------------------

    def _set_tilted_plane(self, block: Block, code: int) -> None:
        """G68.2 X Y Z I J K: origin and Euler angles (Z, X, Z) of the plane in which the program goes on; G69 ends it."""
        state = self.state
        if code == PLANE_OFF:
            self.core.frames.set_frame(replace(state.frame, feature=None))
            return
        self.recorder.says_tcp = True  # a plane of the part
        if state.frame.feature is not None:
            raise ProgramError("VP017", "G68.2 under G68.2; write G69 first")
        origin = [
            self.values.axis_value(block, axis) if letter in block.words else 0.0 for axis, letter in enumerate("XYZ")
        ]
        i, j, k = (RAD_PER_DEG * block.words.get(letter, 0.0) for letter in "IJK")
        rotation = _rotation_z(i) @ _rotation_x(j) @ _rotation_z(k)
        feature = Feature((origin[0], origin[1], origin[2]), tuple(float(v) for v in rotation.ravel()))
        self.core.frames.set_frame(replace(state.frame, feature=feature))
        for letter in "XYZIJK":
            block.words.pop(letter, None)

    def _turn_to_plane(self, block: Block) -> None:
        """G53.1: turn the table so that the tool stands upright on the plane; the tip stays where it is on the part."""
        state = self.state
        if state.frame.feature is None:
            raise ProgramError("VP017", "G53.1 without G68.2: there is no plane to turn to")
        self.core.refuse_compensation("G53.1")
        if state.tcp_off:
            raise ProgramError("VP017", "G53.1 while tool-centre-point control is off (user-defined code)")
        self.core.hold_tool_axis((0.0, 0.0, 1.0))
        begin = self.core.start_of_motion(MoveKind.RAPID, absolute=True, machine=False, axes=(3, 5))
        end = self.setup.coordinates.point_axis(list(begin), np.array([0.0, 0.0, 1.0]), state.frame)
        self.recorder.fix_c(block.line)
        self.core.line(block, MoveKind.RAPID, end, [3, 5] if self.setup.machine else [])

    def _plan(self, block: Block, g: dict[str, int], m: dict[str, list[int]]) -> int | None:
        if g.get("tilted plane") == PLANE:  # takes the axis words; nothing else in the block may
            if g.keys() & {"motion", "non-modal", "machine coordinates", "plane axis"}:
                raise ProgramError(
                    "VP003", "G68.2 takes the axis words of its block; write the other code in a block of its own"
                )
            for letter, column in block.columns.items():
                if letter not in "XYZIJKFST":
                    raise ProgramError("VP006", f"G68.2 does not use {letter}", column)
            return None
        self._drop_axes(block, g)
        return super()._plan(block, g, m)

    def _drop_axes(self, block: Block, g: dict[str, int]) -> None:
        """Axis words beside codes that are only modal here: names of axes, or a mistake, but no motion."""
        axes = [letter for letter in block.words if letter in AXES]
        if not axes or "motion" in g or g.get("non-modal") in TAKES_AXES:
            return
        code = next((code for code in g.values() if code in (*NAMES_AXES, *ALONE)), None)
        if code is None:
            return
        if code in ALONE:
            raise block.error(
                "VP006", f"{axes[0]} beside {g_name(code)}, which takes no axis words; write two blocks", axes[0]
            )
        for letter in axes:
            del block.words[letter], block.columns[letter]


def _rotation_z(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _rotation_x(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


# --- the dialect ------------------------------------------------------------------------------------


def _recognise(source: Text) -> bool:
    start = FanucInterpreter.find_start(source)
    return is_fanuc(source[start : start + (1 << 16)])


def _initial_state(setup: Setup) -> State:
    """As RS274/NGC, but G98, and F on inside arcs is that on the contour, regardless of G62."""
    state = initial_state(setup)
    state.modes.initial_level = True
    return state


def _execute(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    execution = execute_blocks(source, setup, state, stop, FanucInterpreter)
    keys = read_keys(FanucKeys, setup.control.get("fanuc", {}))
    if setup.machine and not keys.decimal_point and stop == StopConditions() and (found := find_mixture(source)):
        execution.recorder.warnings[found.line or 1, found.code] = found
    return execution


DIALECT: Final[Dialect] = replace(dialect_of_blocks(FanucInterpreter, _recognise, _initial_state), execute=_execute)
