"""Blocks of Fanuc controls (and of those that speak like them), with tool-centre-point and tilted-plane codes.

What means the same as in RS274/NGC is executed by the same interpreter; here stands what differs: times in
milliseconds, K for repeats, subprogram words, G54.1, G68.2 with G53.1, exact stops. docs/fanuc.md has the table.
"""

import math
import re
from typing import ClassVar, Final

import numpy as np

from verne_post.base.arrays import Ints
from verne_post.base.long_text import Text
from verne_post.base.suggestions import has_one_more
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.block import Block, read_block
from verne_post.gcode.codes import TAKES_AXES, CodeTable, spell_g_code
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.machining.machining import note_word
from verne_post.gcode.machining.state import State
from verne_post.gcode.plain import PlainView
from verne_post.gcode.program_error import ProgramError, write_before
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.corners import FanucCorners
from verne_post.gcode.rs274.fanuc_codes import (
    ADDITIONAL,
    ALONE,
    HIGH_SPEED,
    MIRROR,
    MIRROR_OFF,
    MIRRORS_OF_HAAS,
    NAMES_AXES,
    NUMBERED_SYSTEMS,
    NURBS,
    OF_FRAMES,
    OF_TOOL,
    OVERRIDE,
    PATTERNS,
    PLANE,
    PLANE_OFF,
    POCKETS,
    TABLE,
    TWINS,
    WORDS_OF_FRAMES,
    make_table,
)
from verne_post.gcode.rs274.fanuc_directions import MachineDirections
from verne_post.gcode.rs274.fanuc_lengths import FanucLengths
from verne_post.gcode.rs274.fanuc_maps import FanucMaps
from verne_post.gcode.rs274.fanuc_offsets import FanucOffsets
from verne_post.gcode.rs274.fanuc_planes import FanucPlanes
from verne_post.gcode.rs274.fanuc_points import (
    INCREMENT,
    find_lines_without_point,
    find_mixtures,
    find_unrounded,
    scale_words,
)
from verne_post.gcode.rs274.fanuc_text import (
    NESTED_COMMENT,
    end_of_number,
    find_program,
    prepare_line,
    read_corner,
    refuse_letter_in_number,
)
from verne_post.gcode.rs274.fanuc_words import FanucWords
from verne_post.gcode.rs274.haas import HaasCodes
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.letterless import refuse_letterless
from verne_post.gcode.rs274.macro_calls import (
    divide_number,
    find_local_call,
    find_macro_call,
    read_macro_call,
    set_control_variable,
)
from verne_post.gcode.rs274.macro_text import ARGUMENTS, explain_misspelt, read_statement
from verne_post.gcode.rs274.modes import NO_MAPS
from verne_post.gcode.rs274.nurbs import NurbsCodes
from verne_post.gcode.rs274.run import execute_blocks, note_missing_unit
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.rs274.values import read_whole
from verne_post.gcode.setup import Setup
from verne_post.gcode.words import WordTable
from verne_post.model.control_keys import FanucKeys, read_keys
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES, ArcFeed, PathControl, PathMode
from verne_post.model.part_setup import ADDITIONAL_SYSTEMS

_DRILLING: Final = 810
_INCH: Final = 200
#: Cutter compensation begins, and ends.
_SIDES: Final = {410, 420}
_END_OF_SIDE: Final = 400
_CUTS: Final = (10, 20, 30)
_UNITS: Final = (_INCH, 210)
_NO_MOTION: Final = (
    '; where a control begins with one, parameter 3402 says which: [fanuc] motion = "G0" or "G1" in verne-post.toml'
)
#: Groups whose codes find the frame as it is without the turn of the table.
_OF_DIRECTIONS: Final = frozenset(
    ("tilted plane", "dynamic work offset", "work offset", "mirror image", "scaling", "polar coordinates")
)
#: Angles of a plane under the letters of rotary axes.
_ANGLES_AS_AXES: Final = re.compile(r"[ABC][-+]?[\d.]+(?:\s*[ABC][-+]?[\d.]+)*", re.IGNORECASE)
_TO_ANGLES: Final = str.maketrans("ABC", "IJK")
_ROTARY_LETTERS: Final = (ord("A"), ord("B"), ord("C"))
_BARE_ARCS: Final = (
    '; a control whose parameter 3403 says so goes straight: [fanuc] bare_arcs = "lines" in verne-post.toml'
)
#: Lines that may be statements of custom macros.
_MACRO: Final = re.compile(
    r"\s*(?:/\s*)?(?:N\s*\d+\s*)?(?:\([^)]*\)\s*)*(?:IF|WH|GO|DO|EN|TH|EL|POPEN|PCLOS|DPRNT|BPRNT|SETVN)", re.IGNORECASE
)
#: Calls of macros, G51, G68.2: what the words of their blocks do not say; nor do they whether the time P has a decimal
#: point.
_BY_TEXT: Final = (51.0, 65.0, 66.0, 68.2)
_TIME: Final = re.compile(r"\([^)]*\)|;.*|(?<![A-Z])(P)[ \t]*[-+]?[0-9 \t]*\.", re.IGNORECASE)
_FACTOR: Final = re.compile(r"(?<![A-Z])[PIJK][ \t]*[-+]?[ \t]*(?:[0-9 \t]*\.|[#\[])", re.IGNORECASE)
#: What of a comment with others in it stands after its first end, up to the parenthesis that was meant.
_LEFT_OVER: Final = re.compile(r"[^()]*\)")


class FanucInterpreter(Rs274):
    """The interpreter of RS274/NGC, which gets blocks in its words."""

    table: ClassVar[CodeTable] = make_table()
    traits: ClassVar[Traits] = Traits(
        tilted_plane="G68.2 and G53.1",
        separates_programs=True,
        zero_is_no_offset=True,
        perpendicular_entry=True,
        begins_at_once=False,
        diameter_codes=False,
        beside_spline=(NURBS,),
        spline_end="as many blocks with K alone as the order of the spline end it",
        needs_dwell=(),
        dwells_in_seconds=False,
        feeds_out_whole=False,
        keeps_heights=True,
        stores_without_holes=True,
        turns_table_alone=True,
        keeps_words=True,
        resumes_motion=True,
        taps_rigidly=True,
        speaking_remarks=(),
    )
    percent: ClassVar[bytes] = rb"[^\n]*"
    o_letters: ClassVar[bytes] = b"O:"
    end_alone: ClassVar[bool] = True
    custom_macro: ClassVar[bool] = True
    plain_words: ClassVar[bool] = True

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        super().__init__(setup, state, recorder)
        self._text = ""  # the last line that was read word by word
        self._has_motion = False  # a code of motion has stood in the program
        #: The last block whose P has a decimal point.
        self._in_seconds: Block | None = None
        self.nurbs = NurbsCodes(self.core, self.values, self.motion)
        self.fanuc_offsets = FanucOffsets(self.offsets)
        given = setup.control.get("fanuc", {})
        self.keys: FanucKeys = read_keys(FanucKeys, given)
        self.words = FanucWords(self.modes, self.table, self.keys)
        self.planes = FanucPlanes(self.core, self.values, self.keys)
        self.maps = FanucMaps(self.core, self.values)
        self.lengths = FanucLengths(self.core, self.values, self.keys)
        self.corners = FanucCorners(self.core)
        self.haas = HaasCodes(self.core, self.values, self.motion, self.cycles)
        self.motion.draw_line, self.motion.draw_arc = self.corners.add_line, self.corners.add_arc
        self.cycles.bore_shift = self.keys.bore_shift
        self.motion.bare_arcs_are_lines = self.keys.bare_arcs == "lines"
        self.motion.bare_arcs_remedy = _BARE_ARCS
        self.directions: MachineDirections | None = None
        if self.keys.directions == "machine" and setup.machine:
            self.directions = self.motion.directions = MachineDirections(self.core, self.motion)
        self.motion.offsets_are_wear = self.keys.cutter_offsets == "wear"
        least = 0.01 * self.keys.inside_arc_percent
        self.core.set_arc_feed(ArcFeed("[fanuc] inside_arc_percent", least, 1.0, assumed=not given))

    @classmethod
    def leave_to_reader(cls, text: bytes, words: WordTable, setup: Setup) -> Ints:
        """Calls of macros, scales and times, and numbers that may lack their letter.

        Turns of the table, and words without a point, where they mean more.
        """
        codes = np.flatnonzero(words.letter == ord("G"))
        codes = codes[np.isin(words.value[codes], _BY_TEXT)]
        lines = words.row[np.concatenate([codes, np.flatnonzero(words.letter == ord("P"))])].astype(np.int32)
        lines = np.concatenate([lines, super().leave_to_reader(text, words, setup)])
        given = setup.control.get("fanuc", {})
        if given.get("directions") == "machine":
            lines = np.union1d(lines, words.row[np.isin(words.letter, _ROTARY_LETTERS)].astype(np.int32))
        conventional = given.get("decimal_point") == "conventional"
        return np.union1d(lines, find_lines_without_point(text)) if conventional else lines

    def _execute_cycle(self, block: Block, motion: int, *, goes_on: bool) -> None:
        """As RS274/NGC; says what it does where R is above the tool."""
        above = self.state.position
        words = [letter for letter in "PQ" if motion == _DRILLING and letter in block.words]
        if words:
            self.recorder.note_once(
                "VP039",
                f"{' and '.join(words)} of G81 {'is' if len(words) == 1 else 'are'} kept for other cycles: G81 goes "
                "down at once and does not dwell; write G82, G73 or G83 if that was meant",
                block.line,
            )
        super()._execute_cycle(block, motion, goes_on=goes_on)
        cycle = self.modes.cycle
        if cycle is not None and above[cycle.normal] < cycle.clear - ZERO_LENGTH_MM:
            self.recorder.note_once(
                "VP039",
                "R of a canned cycle is above the tool: it goes up to R first and then over the hole, and stays "
                "at R after it, also under G98; a control may go over the hole first",
                block.line,
            )

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
        """Read a line: words, or a statement of a custom macro."""
        nested_comment = None
        if ")" in text:
            nested_comment = NESTED_COMMENT.search(text, 0, text.rfind(")") + 1)
            text = prepare_line(text)
        elif text[:1] in ":/ \t":
            text = prepare_line(text)
        if "O" in text or "o" in text:
            refuse_letter_in_number(text)
        if ("O" in text or "o" in text) and (number := end_of_number(text)):
            text = " " * number + text[number:]
        self._text = text
        begins_with_word = text[1:2].isdigit() and text[:1] not in "Nn(/"  # as most lines do, and no statement
        if (
            not begins_with_word
            and _MACRO.match(text)
            and (statement := read_statement(text, self.parameters)) is not None
        ):
            return Block(line, macro=statement)
        self.parameters.passed_word = ""
        refuse_letterless(text)
        self.warn_of_divided_number(text, line)
        corner = None
        try:
            if "," in text:
                text, corner = read_corner(text, self.parameters)
            head, arguments = read_macro_call(text, self.parameters, self.keys) if "6" in text else (text, None)
            block = read_block(head, line, self.parameters)
        except ProgramError as error:
            if error.code == "VP001" and (misspelt := explain_misspelt(text)) is not None:
                raise misspelt from None
            if (
                nested_comment is None
                or (error.column or 0) <= nested_comment.end()
                or not _LEFT_OVER.match(text, nested_comment.end())
            ):
                raise
            raise ProgramError(
                error.code,
                f"the comment that begins in column {nested_comment.start() + 1} ends at the ')' of column "
                f"{nested_comment.end(1) + 1}, because comments do not nest; what follows is read as words, and there "
                f"{error.message}",
                error.column,
            ) from None
        block.corner, block.arguments = corner, arguments
        if "." in head and ("P" in head or "p" in head) and any(match[1] for match in _TIME.finditer(head)):
            self._in_seconds = block
        if self.parameters.passed_word:
            vacant_word = self._name_vacant(self.parameters.passed_word, text)
            self.recorder.note_once(
                "VP039", f"{vacant_word} without a value: the word is passed over, as controls do", line
            )
        if self.keys.decimal_point == "conventional":
            codes = {round(number * 10) for letter, number, _column in block.codes if letter == "G"}
            scale_words(block, self._text, self.state, drills=self.words.has_cycle(block, codes))
        if "#" in text and (letter := find_unrounded(block, text, self.state)) is not None:
            self.recorder.note_once(
                "VP039",
                f"{letter} has a value with more digits than the least input increment ({INCREMENT:g}): it is used as "
                "it is; a control rounds it",
                line,
            )
        if block.o is not None and block.o.keyword is not None:
            raise ProgramError(
                "VP002", f"O{block.o.label} {block.o.keyword}: O words with keywords are RS274/NGC; see --dialect rs274"
            )
        return block

    def _name_vacant(self, letter: str, text: str) -> str:
        """A word and its variables that have no value, each with the letter by which G65 gives it one."""
        word = re.search(rf"{letter}([^A-Z]*)", text.upper())
        numbers = dict.fromkeys(int(number) for number in re.findall(r"#(\d{1,2})(?!\d)", word[1] if word else ""))
        letters = {number: argument for argument, number in ARGUMENTS.items()}
        vacant = [number for number in numbers if math.isnan(self.parameters.read_value(number))]
        names = [f"#{number} ({letters[number]} of G65)" if number in letters else f"#{number}" for number in vacant]
        return f"{letter} has {' and '.join(names) or 'a variable'}"

    def set_parameter(self, key: int | str, value: float, column: int) -> None:
        """Set a variable; some of the control stop the program, or have no effect here."""
        if not set_control_variable(self.core, self.parameters.line, key, value, column, self._text):
            super().set_parameter(key, value, column)

    # --- what holds ----------------------------------------------------------------------------------

    def may_restart(self) -> bool:
        """As RS274/NGC; not between the blocks of a corner or of a plane."""
        return super().may_restart() and self.corners.queue.corner is None and self.planes.given is None

    def view_plain_lines(self, *, has_vector: bool) -> PlainView | None:
        """As RS274/NGC, where lines mean no more than their words."""
        return super().view_plain_lines(has_vector=has_vector) if self._is_plain() else None

    def find_unfinished(self) -> str | None:
        """As RS274/NGC; and a corner, or a plane of several blocks."""
        if self.corners.queue.corner is not None:
            return f"the block that {self.corners.queue.corner.name} needs after its own"
        return "the last block of G68.2" if self.planes.given is not None else super().find_unfinished()

    def _is_plain(self) -> bool:
        """True where blocks mean no more than their words: no modal call, maps, or checks are in force."""
        modes = self.modes
        return (
            self.corners.queue.corner is None
            and modes.macro is None
            and modes.maps is NO_MAPS
            and not modes.after_turn
            and not modes.follows_table
            and not self.state.length_end
            and not modes.length_travel
            and self.planes.given is None
        )

    def _execute_call(self, block: Block, m: dict[str, list[int]]) -> None:
        """As RS274/NGC; M97 P and M99 P lead to block numbers."""
        self.call = find_local_call(block, m.get("subprograms", []))
        if self.call is None:
            super()._execute_call(block, m)
        if self.call is not None and self.call.number is None and "L" not in block.words:
            self.call = divide_number(self.call)

    def execute(self, block: Block) -> None:
        """Execute one block, in the words of RS274/NGC."""
        self.call = None
        corners = self.corners
        if block.corner is not None or corners.corner is not None or corners.queue.corner is not None:
            corners.prepare(block, self.modes)
        if self._is_plain():
            if not block.settings:
                if block.comment is None and self.execute_plain_motion(block):
                    return
            elif not block.codes and not block.words:
                super().execute(block)
                return
        codes = {round(number * 10) for letter, number, _column in block.codes if letter == "G"}
        if not codes.isdisjoint(MIRRORS_OF_HAAS):
            numbers = {code / 10: twin / 10 for code, twin in MIRRORS_OF_HAAS.items()}
            block.codes = [
                (letter, numbers.get(number, number) if letter == "G" else number, at)
                for letter, number, at in block.codes
            ]
            codes = {round(number * 10) for letter, number, _column in block.codes if letter == "G"}
        if self.planes.given is not None and PLANE not in codes and (block.codes or block.words):
            self.planes.check_complete()
        if self.modes.follows_table:
            self.planes.refuse_turning(block)
        if self.modes.after_turn:
            self.planes.check_first_motion(block, codes)
        control = self.state.control
        flipped_sides = None if self.modes.maps is NO_MAPS else self.maps.convert(block, codes)
        self.words.convert_length(block, codes)
        self.words.convert_system(block, codes)
        self.words.convert_times(block, codes, in_seconds=block is self._in_seconds)
        self.words.convert_repeats(block, codes)
        if 530 in codes and not set(AXES).intersection(block.words):  # no axis goes there
            block.codes = [code for code in block.codes if code[0] != "G" or round(code[1] * 10) != 530]
            codes.discard(530)
            self.recorder.record_event(block.line, "without effect", word="G53")
        modal = self.words.convert_rapids(block, codes)
        changes = ("M", 6.0) in [code[:2] for code in block.codes]
        if changes:  # G43 in its block is that of the new tool
            self.modes.length_number = None
        if not codes.isdisjoint(_UNITS):  # F of the block too has its unit
            self.modes.inch = _INCH in codes
        super().execute(block)
        self.lengths.end(block, codes)
        if self.directions is not None:  # G28 and G53 may have turned the table
            self.directions.follow()
        if changes:
            self.modes.cutter_number = None
        if changes or codes & _SIDES:
            self.modes.idle_cutter = 0
        if "D" in block.words:
            self.modes.cutter_number = read_whole(block, "D")
            if self.modes.cutter_number and self.state.compensation is None and not codes & _SIDES:
                self.modes.idle_cutter = block.line
        if _END_OF_SIDE in codes and self.modes.idle_cutter and self.modes.motion in _CUTS:
            self._warn_of_idle_cutter(block)
        if modal is not None or flipped_sides is not None:
            self.modes.motion = modal if flipped_sides is None else flipped_sides
        if 90 in codes:  # G9: exact stop in this block
            self.core.set_path_control(control)
        if self.modes.macro is not None or codes & {650, 660}:
            self.call = find_macro_call(block, codes, self.modes, self.setup.axes) or self.call

    def _warn_of_idle_cutter(self, block: Block) -> None:
        """VP026: G40 beside a cut, as at the end of a contour, and a D since the tool change without G41 or G42."""
        line, number = self.modes.idle_cutter, self.modes.cutter_number
        if line != block.line and not set(AXES).isdisjoint(block.words):
            text = (
                f"D{number} is not used: no G41 or G42 is between it and G40 of line {block.line}, and the centre "
                f"of the tool follows the path; write G41 D{number} or G42 D{number} if the tool is to go beside it"
            )
            self.recorder.note_once("VP026", text, line, severity="warning")
            self.modes.idle_cutter = 0

    def _read_g_code(self, number: float, column: int, *, moves: bool) -> int:
        """The code of a G word; twins of one code are that code."""
        code = super()._read_g_code(number, column, moves=moves)
        return TWINS.get(code, code)

    def _choose_motion(self, block: Block, g: dict[str, int], axes: list[str]) -> int | None:
        """As RS274/NGC; before any code of motion that of the machine holds, which the settings file says."""
        begins_with = {"": None, "G0": 0, "G1": 10}[self.keys.motion]
        self._has_motion = self._has_motion or "motion" in g or self.modes.motion not in (None, begins_with)
        if not self._has_motion:
            self.modes.motion = begins_with
        try:
            motion = super()._choose_motion(block, g, axes)
        except ProgramError as error:
            if error.code == "VP005" and not self._has_motion and "tool length" not in g:
                error.message += _NO_MOTION
            raise
        return NURBS if motion is None and self.nurbs.goes_on(block, g) else motion

    def execute_plain_motion(self, block: Block) -> bool:
        """As RS274/NGC, where Z is certain."""
        return not (self.state.length_end or self.modes.length_travel) and super().execute_plain_motion(block)

    # --- codes of Fanuc alone ------------------------------------------------------------------------------

    def _set_modes(self, block: Block, g: dict[str, int]) -> None:
        length = self.lengths.measure()
        self._set_modes_in_directions(block, g)
        if not any(code in (*OF_FRAMES, MIRROR_OFF) for code in g.values()):  # which take the axis words
            self.lengths.follow(block, g, length)

    def _set_modes_in_directions(self, block: Block, g: dict[str, int]) -> None:
        if self.directions is None:
            self._set_own_modes(block, g)
            return
        if not _OF_DIRECTIONS.isdisjoint(g) or g.get("non-modal") in (100, 520, 920):
            self.directions.leave()
        self._set_own_modes(block, g)
        if g.get("non-modal") not in (100, 520, 920):
            self.directions.follow()

    def _set_own_modes(self, block: Block, g: dict[str, int]) -> None:
        if "plane" in g:
            self.core.set_plane((g["plane"] - 170) // 10)
            note_word(self.core, "plane", block.line)
        if "tilted plane" in g:
            if g["tilted plane"] != PLANE_OFF:
                self._select_beside_plane(block, g)
            self.planes.set_plane(block, g["tilted plane"])
        if "dynamic work offset" in g:
            self.planes.follow_table(block, g["dynamic work offset"] == TABLE)
        if "mirror image" in g:
            self._set_mirror(block, g["mirror image"])
        if "scaling" in g:
            self.maps.set_scale(block, g["scaling"], _FACTOR.search(self._text) is not None)
        if "polar coordinates" in g:
            self.maps.set_polar(g["polar coordinates"] == 160)
        if "exact stop" in g:
            self.core.set_path_control(PathControl(PathMode.EXACT_STOP))
        if "look-ahead" in g:
            code = spell_g_code(g["look-ahead"])
            words = {letter: block.words[letter] for letter in "PE" if letter in block.words}
            self.recorder.record_event(block.line, "look-ahead", code=code, **words)
        if g.get("path control") == OVERRIDE:
            g = {**g, "path control": 640}
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
            self.recorder.record_event(block.line, "smoothing", code=f"G{g['smoothing'] / 10:g}", **words)
        if "fixture offset" in g and block.words.get("P") != 0.0:
            raise block.error(
                "VP002",
                f"{spell_g_code(g['fixture offset'])} is only executed with P0: how other work offsets turn or lie is "
                "stored in the control; let the CAM system write G43.4, or write G68.2 and G53.1, and give the turn of "
                "the part in --wcs",
                "P",
            )
        if "plane axis" in g:
            is_first = not any(self.state.named_axes[axis] for axis in self.setup.rotary)
            self.planes.turn_to_plane(block, g["plane axis"])
            self.recorder.note_turn_to_plane(is_first=is_first)

    def _set_mirror(self, block: Block, code: int) -> None:
        """G51.1; G50.1, which names axes whether they are mirrored or not."""
        if code == MIRROR or self.modes.maps.mirrors != NO_MAPS.mirrors:
            self.maps.set_mirror(block, code)

    def _select_beside_plane(self, block: Block, g: dict[str, int]) -> None:
        """Take the work offset in the block of a plane, which is certain where it changes nothing; else VP017.

        A plane that is in force is an error of :meth:`FanucPlanes.set_plane`.
        """
        code = g.pop("work offset", None)
        if code is None or self.state.frame.feature is not None or self.modes.follows_table:
            return
        name, before = spell_g_code(code), self.state.frame.system
        if code != ADDITIONAL:
            self.select_system(block, code)
            if self.state.frame.system == before:
                return
        text = (
            f"{name} in the block of {spell_g_code(g['tilted plane'])}: which of the two a control executes first is "
            f"not known; write {name} in a line before it"
        )
        # P may be that of either
        error = ProgramError("VP017", text, edits=() if code == ADDITIONAL else write_before(name))
        error.leaves_unknown = True  # where the plane lies
        raise error

    def _find_system_number(self, block: Block, code: int) -> int:
        if code in NUMBERED_SYSTEMS:
            system = ADDITIONAL_SYSTEMS + NUMBERED_SYSTEMS[code]
        elif code != ADDITIONAL:
            system = super()._find_system_number(block, code)
        elif "P" not in block.words:
            raise ProgramError("VP005", "G54.1 needs P, the number of the work system")
        else:
            system = ADDITIONAL_SYSTEMS + self.fanuc_offsets.find_additional(block)
            del block.words["P"]  # and no dwell of a cycle
        if system == self.state.frame.system:
            return system  # nothing changes: posts write the work offset in force again, those for Haas after G254
        self.planes.refuse_under_plane("a change of work offset", block.line)
        if self.modes.maps is not NO_MAPS:
            raise ProgramError(
                "VP017", "a change of work offset under G51, G51.1 or G16; write G50, G50.1 or G15 first"
            )
        return system

    def _execute_spline(self, block: Block, _motion: int) -> None:
        self.nurbs.execute(block)

    def _execute_non_modal(self, block: Block, code: int) -> None:
        if code in (100, 520, 920):
            self.planes.refuse_under_plane(spell_g_code(code), block.line)
        if code == 100:
            if self.motion.offsets_are_wear and block.words.get("L") in (12.0, 13.0):
                raise block.error(
                    "VP017",
                    f"G10 L{block.words['L']:g} gives a radius, and [fanuc] cutter_offsets says that D has only the "
                    "wear, which is 0: leave one of the two out",
                    "L",
                )
            self.fanuc_offsets.store_offset(block)
        elif code in (520, 920):
            self.fanuc_offsets.shift_system(block, code)
        elif code in (*POCKETS, *PATTERNS):
            self.haas.execute(block, code)
        else:
            super()._execute_non_modal(block, code)

    def _find_usable_words(
        self, block: Block, g: dict[str, int], m: dict[str, list[int]], motion: int | None
    ) -> set[str]:
        """D may stand without G41 and G42: the next one takes it."""
        usable = super()._find_usable_words(block, g, m, motion)
        return usable if self.state.compensation is not None else usable | {"D"}

    def _plan(self, block: Block, g: dict[str, int], m: dict[str, list[int]]) -> int | None:
        of_frames = OF_FRAMES if self.modes.maps.mirrors == NO_MAPS.mirrors else (*OF_FRAMES, MIRROR_OFF)
        if frame_codes := [code for code in g.values() if code in of_frames]:  # take the axis words, all alone
            name = spell_g_code(frame_codes[0])
            if len(frame_codes) > 1 or g.keys() & {"motion", "non-modal", "machine coordinates", "plane axis"}:
                raise ProgramError(
                    "VP003", f"{name} takes the axis words of its block; write the other code in another block"
                )
            if frame_codes[0] == PLANE and not block.words.keys() & set("IJK"):
                self._refuse_axes_as_angles(block)
            for letter, column in block.columns.items():
                if letter not in WORDS_OF_FRAMES[frame_codes[0]] + "FST":
                    is_by_angles = frame_codes[0] == OF_TOOL and letter in "IJK"
                    advice = f"; a plane by the angles I, J, K is {spell_g_code(PLANE)}" if is_by_angles else ""
                    raise ProgramError("VP006", f"{name} does not use {letter}{advice}", column)
            return None
        self._drop_axes(block, g)
        return super()._plan(block, g, m)

    def _refuse_axes_as_angles(self, block: Block) -> None:
        """VP006: the angles of G68.2 under the letters of rotary axes; the block goes on with I, J and K."""
        stray = [letter for letter in "ABC" if letter in block.words]
        if not stray:
            return
        wrong = _ANGLES_AS_AXES.search(self._text)
        is_whole = wrong is not None and all(letter in wrong[0].upper() for letter in stray)
        was = wrong[0].upper() if wrong is not None and is_whole else ", ".join(stray)
        right = was.translate(_TO_ANGLES)
        edits = (Remedy(f"write {right}", right, misspelt=was, is_choice=True),) if is_whole else ()
        about = "" if block.words.get("P") else ", about Z, about X, and about Z again"
        text = f"the angles of G68.2 are I, J and K{about}; write {right} in place of {was}"
        first = min(stray, key=lambda letter: abs(block.columns[letter]))
        error = block.error("VP006", text, first, edits=edits)
        for letter in stray:
            angle = letter.translate(_TO_ANGLES)
            block.words[angle], block.columns[angle] = block.words[letter], block.columns[letter]
            if letter != first:  # which is dropped as the error's word
                del block.words[letter], block.columns[letter]
        raise error

    def _drop_axes(self, block: Block, g: dict[str, int]) -> None:
        """Axis words beside codes that are only modal here: names of axes, or a mistake, but no motion."""
        axes = [letter for letter in block.words if letter in AXES]
        if not axes or "motion" in g or g.get("non-modal") in TAKES_AXES:
            return
        code = next((code for code in g.values() if code in (*NAMES_AXES, *ALONE)), None)
        if code is None:
            return
        if code in ALONE:
            name = spell_g_code(code)
            near = [spell_g_code(one) for one in TAKES_AXES if has_one_more(spell_g_code(one), name)]
            edits = tuple(Remedy(f"write {one}", one, line=block.line, misspelt=name, is_choice=True) for one in near)
            text = f"{axes[0]} beside {name}, which takes no axis words; write two blocks"
            raise block.error(
                "VP006", f"{text}{f', or {near[0]} in place of {name}' if near else ''}", axes[0], edits=edits
            )
        for letter in axes:
            del block.words[letter], block.columns[letter]


def execute_fanuc(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    """Execute a text until it ends or a stop condition is met, and say what a setting of the control decides."""
    execution = execute_blocks(source, setup, state, stop, FanucInterpreter)
    keys = read_keys(FanucKeys, setup.control.get("fanuc", {}))
    if setup.machine and stop == StopConditions():
        recorder = execution.recorder
        mixtures = () if keys.decimal_point else find_mixtures(source, recorder, setup, execution.errors)
        for number, found in enumerate(mixtures):  # several files may be called in one line
            place = found.line or 1 if found.column is not None else -number
            recorder.warnings[place, found.code] = found
        if not keys.units:
            note_missing_unit(execution, source, "fanuc")
    return execution
