"""One block after the other: the general interpreter, in LinuxCNC's order of execution.

It is exact and complete for the language; long stretches of plain moves are done by
:mod:`verne_post.gcode.plain`, which must agree with it to the last bit. O words and
subprograms, which decide where a program goes on, are in :mod:`verne_post.gcode.rs274.flow`.
"""

from collections.abc import Iterable
from typing import ClassVar, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Ints
from verne_post.base.suggestions import has_one_more
from verne_post.base.tolerances import WHOLE_NUMBER
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.block import POLAR, Block, read_block
from verne_post.gcode.codes import (
    CYCLES,
    HAS_MEANING,
    RS274,
    TAKES_AXES,
    CodeTable,
    describe_remap,
    drop_doubled_digits,
    read_m_code,
    spell_g_code,
)
from verne_post.gcode.machining.auxiliary import REMAPPED_WORDS
from verne_post.gcode.machining.machining import (
    MOTION_LINES,
    Machining,
    explain_g91,
    note_g91,
    note_rapid_feed,
    note_word,
    warn_of_idle_feed,
)
from verne_post.gcode.machining.state import State
from verne_post.gcode.mistyped import explain_unknown
from verne_post.gcode.parameters import Parameters
from verne_post.gcode.plain import PlainView
from verne_post.gcode.program_error import ProgramError, write_before
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.cycles import CycleCodes
from verne_post.gcode.rs274.functions import FunctionCodes
from verne_post.gcode.rs274.letterless import find_candidates, find_divided
from verne_post.gcode.rs274.messages import read_message
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.rs274.motion import MotionCodes
from verne_post.gcode.rs274.offsets import OffsetCodes
from verne_post.gcode.rs274.splines import SPLINES, SplineCodes
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.rs274.values import WordValues, find_polar_end, read_whole
from verne_post.gcode.setup import Setup
from verne_post.gcode.text import Language
from verne_post.gcode.words import WordTable
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES, ZERO9, PathControl, PathMode
from verne_post.model.plausibility import PLAUSIBLE

_MAX_M_CODES: Final = 4
_DIGITS_OF_CODES: Final = 2
#: With U or W they are no holes in a pattern.
_CYCLES_OF_LATHES: Final = (700, 710, 720)
_MOST_NAMED: Final = 3
#: Codes that few builders have, as G111 and G187 of Haas, begin here: they are written for no slip.
_CODES_OF_BUILDERS: Final = 1000
#: Two digits whose keys are neighbours.
_KEYS_BESIDE: Final = frozenset(f"{one}{one + step}" for one in range(10) for step in (-1, 1))
#: Groups of codes on which all moves behind them depend, and G10 and G50: no slip is taken for one of them.
_OF_ALL_MOVES: Final = ("units", "plane", "distance", "arc distance")
_OF_SETTINGS: Final = (100, 500)
_LEAST_PROGRAM: Final = 100  #: Numbers of subprograms are not below it, as a rule.
#: Words of a tool, and the codes that use them.
_CODES_BESIDE: Final = {"H": ("G43",), "D": ("G41", "G42")}
#: Letters -> those of motion, codes, feed and speed whose keys are beside.
_KEYS_OF_WORDS: Final = {
    "A": "ZS", "B": "G", "C": "XF", "D": "FSX", "E": "S", "H": "GY", "I": "", "J": "M", "K": "M", "N": "M", "R": "F",
    "T": "FGY", "U": "Y", "V": "GF", "W": "S",
}  # fmt: skip
_KEY_BESIDE_G0: Final = 90  #: G9, times ten.
_LEAST_SPEED: Final = 30  #: Numbers of F and S are not below it, as a rule.
#: Words of G83 that no other block of G93 has.
_OF_DRILLING: Final = frozenset("RQPKL")
#: Numbers of G words -> codes of motion that need nothing but their own words.
_PLAIN_MOTIONS: Final = {0.0: 0, 1.0: 10, 2.0: 20, 3.0: 30}


class Call(Struct, frozen=True):
    """Which subprogram, how often; label None: M99. ``word`` begins the call, before P."""

    label: str | None
    column: int | None
    repeats: int = 1
    number: int | None = None  #: The block (N) where M97 begins, or to which M99 goes back.
    #: Label and repeats, where a control may read the digits of the label so.
    divided_label: tuple[str, int] | None = None
    #: Local variables of a macro (G65, G66); ``keeps``: they are kept from one call to the next (G66).
    arguments: dict[int, float] | None = None
    keeps: bool = False
    word: str = "M98"


def _write_beside(word: str, rights: Iterable[str]) -> tuple[Remedy, ...]:
    """The edits that write one of these in place of a word; its number may have a 0 before it, as in H01."""
    return tuple(
        Remedy(f"write {one}", one, is_choice=True, way="marked")
        if one in (f"G{word[1:]}", f"M{word[1:]}")
        else Remedy(f"write {one}", one, misspelt=word, is_choice=True)
        for one in rights
    )


_SYSTEMS: Final = {540: 1, 550: 2, 560: 3, 570: 4, 580: 5, 590: 6, 591: 7, 592: 8, 593: 9}


class Rs274(Language):
    """Executes blocks on a state and records what they do.

    ``ended`` becomes True at M2 or M30; ``call`` is the call of M98 or M99 in the last block.
    """

    table: ClassVar[CodeTable] = RS274
    traits: ClassVar[Traits] = Traits()
    #: Lines of plain words have their meaning of RS274/NGC, however :meth:`read` treats others. Each class that reads
    #: in its own way sets this itself.
    plain_words: ClassVar[bool] = True
    #: The end of the text ends a program.
    ends_with_text: ClassVar[bool] = False
    #: Expressions are read as Fanuc's custom macro has them.
    custom_macro: ClassVar[bool] = False

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.core = Machining(setup, state, recorder)
        self.setup, self.state, self.recorder = setup, state, recorder
        self.modes: Modes = state.modes
        self.values = WordValues(setup, state)
        self.offsets = OffsetCodes(self.core, self.values, self.traits)
        self.functions = FunctionCodes(self.core, self.values)
        self.motion = MotionCodes(self.core, self.values, self.traits)
        self.splines = SplineCodes(self.core, self.values, self.motion, self.traits)
        self.cycles = CycleCodes(self.core, self.values, self.motion, self.traits)
        self.parameters = Parameters(setup, state, custom_macro=self.custom_macro)
        own = type(self)
        self.reads_plain_words = own.read is Rs274.read or own.__dict__.get("plain_words", False)
        self._axes = frozenset(setup.axes)
        straight, arcs = self._axes | {"F"}, self._axes | set("F" + self.table.words_of_g[20])
        self._plain_words: dict[int | None, frozenset[str]] = {0: straight, 10: straight, 20: arcs, 30: arcs}
        self.has_ended = False
        self.call: Call | None = None

    # --- what the run of a program asks --------------------------------------------------------

    def may_restart(self) -> bool:
        """True where the next block does not depend on those before."""
        return self.modes.cycle is None and self.modes.spline is None

    def view_plain_lines(self, *, has_vector: bool) -> PlainView | None:
        """What the modes make of plain lines, of which the first has I, J or K; None where they are more than moves."""
        modes = self.modes
        if not modes.absolute or modes.diameter_mode or modes.spline is not None or (modes.vectors and not has_vector):
            return None
        if (
            modes.vectors and self.setup.coordinates.nutation is not None
        ):  # a vector may be out of reach: at its own line
            return None
        return PlainView(
            modes.motion,
            modes.inch,
            arcs=not modes.absolute_centers,
            has_tool_axes=modes.vectors,
            turning=not (self.motion.is_without_tcp() or self.motion.is_retracted()),
        )

    def find_unfinished(self) -> str | None:
        """What a program may not end without, in words; None where nothing is open."""
        return None if self.modes.spline is None else "the end of a spline"

    def go_on_after_plain_lines(self, view: PlainView) -> None:
        """Plain lines have been executed, the last of them with a motion."""
        self.modes.motion, self.modes.cycle = view.motion, None

    # --- one block -------------------------------------------------------------------------

    @classmethod
    def leave_to_reader(cls, text: bytes, words: WordTable, setup: Setup) -> Ints:
        """Lines with a number that may lack its letter."""
        return find_candidates(text)

    def read(self, text: str, line: int) -> Block:
        """Read a line; with the current values of parameters."""
        self.warn_of_divided_number(text, line)
        return read_block(text, line, self.parameters)

    def warn_of_divided_number(self, text: str, line: int) -> None:
        """Warn of a number that a blank divides."""
        if self.setup.machine and (found := next(find_divided(text, line), None)) is not None:
            error = found.error
            self.recorder.warn("VP001", error.message, line, error.column, "warning", error.edits)

    def execute(self, block: Block) -> None:
        """Execute one block.

        Raises
        ------
        ProgramError
            Before anything of the block has taken effect, except for its modal words.
        """
        self.call = None
        for key, value, column in block.settings:
            self.set_parameter(key, value, column)
        if block.comment is not None:
            self._show_comment(block)
        if not (block.codes or block.words) or self.execute_plain_motion(block):
            return
        g, m = self._group_codes(block)
        active = self.modes.motion
        self.splines.guard(g)
        motion = self._plan(block, g, m)
        self.functions.set_feed(block, g)
        if "spindle mode" in g:
            self.functions.set_spindle_mode(block, g["spindle mode"])
        self.functions.execute(block, m)
        if 40 in g.values():
            self._dwell(block)
        self._set_modes(block, g)
        non_modal = g.get("non-modal")
        if non_modal is not None and non_modal != 40:
            self._execute_non_modal(block, non_modal)
        if motion in CYCLES:
            self._execute_cycle(block, motion, goes_on=active == motion)
        elif motion in SPLINES:
            self._execute_spline(block, motion)
        elif motion is not None and motion != 800:
            if motion == 0 and "F" in block.words and "motion" not in g and "machine coordinates" not in g:
                warn_of_idle_feed(self.core, block, block.words["F"])
            elif motion == 0 and "F" in block.words and "machine coordinates" not in g:
                note_rapid_feed(self.core, block, block.words["F"], names_only_z=block.words.keys() == {"Z", "F"})
            self.motion.move(block, motion, machine="machine coordinates" in g)
        self._execute_stops(block, m)
        self._execute_call(block, m)

    def execute_plain_motion(self, block: Block) -> bool:
        """Execute a block that only moves, with G0 to G3 or as the block before; False for any other.

        It is the short way through :meth:`execute`: one code or none, axis words, F, and the words of arcs.
        """
        words = block.words
        if block.codes:
            letter, number, _column = block.codes[0]
            motion = _PLAIN_MOTIONS.get(number) if letter == "G" and len(block.codes) == 1 else None
        else:
            motion = self.modes.motion if not self._axes.isdisjoint(words) else None
        letters = self._plain_words.get(motion)
        if (
            letters is None
            or not letters.issuperset(words)
            or self.modes.spline is not None
            or self.modes.diameter_mode
        ):
            return False
        if "F" in words:
            if words["F"] < 0:
                return False
            self.functions.set_feed(block, {})
            if motion == 0 and not block.codes:
                warn_of_idle_feed(self.core, block, words["F"])
            elif motion == 0:
                note_rapid_feed(self.core, block, words["F"], names_only_z=words.keys() == {"Z", "F"})
        assert motion is not None
        if block.codes and (name := MOTION_LINES.get(motion)):
            note_word(self.core, name, block.line)
        self.modes.motion, self.modes.cycle = motion, None
        self.motion.move(block, motion, machine=False)
        return True

    def set_parameter(self, key: int | str, value: float, column: int) -> None:
        """Set a parameter of a block."""
        try:
            self.parameters.set(key, value)
        except ProgramError as error:
            raise ProgramError(error.code, error.message, column, edits=error.edits).advise(error.advice) from None

    def _show_comment(self, block: Block) -> None:
        answer = read_message(block.comment or "", self.parameters, self.traits.speaking_remarks)
        if answer is None:
            return
        channel, text = answer
        if channel == "abort":
            raise ProgramError("VP027", f"the program asks to stop: {text.strip()}")
        kind = "not executed" if channel == "file" else "message"
        channel_words = {} if channel in ("file", "msg") else {"channel": channel}
        self.recorder.record_event(block.line, kind, text=text, **channel_words)

    def _plan(self, block: Block, g: dict[str, int], m: dict[str, list[int]]) -> int | None:
        """The motion code that the axis words of the block are for; refuses words that nothing uses."""
        self._resolve_polar(block, g)
        axes = [letter for letter in block.words if letter in AXES]
        for letter in axes:
            if letter not in self.setup.axes:
                text = self.setup.describe_missing_axis(letter)
                lathe_code = next((code for code in g.values() if code in _CYCLES_OF_LATHES and letter in "UW"), None)
                if lathe_code is not None:
                    text += f"; {spell_g_code(lathe_code)} with {letter} is a cycle of lathes, which is not executed"
                # a rotary axis is another machine's, and no slip
                rights = [] if letter in "ABC" or lathe_code else self._list_keys_beside(block, letter)
                text += f"; {' or '.join(rights)} may be meant, whose key is beside" if rights else ""
                edits = _write_beside(f"{letter}{block.words[letter]:g}", rights)
                error = block.error("VP011", text, letter, edits=edits)
                raise error.advise(self.setup.advise_axis(letter, "I J K of G43.5"))
        motion = self._choose_motion(block, g, axes)
        if motion in CYCLES and (98 in m.get("subprograms", []) or 40 in g.values()):
            raise ProgramError(
                "VP003", "M98 or G4 in a block of a canned cycle: P and L would serve both; write two blocks"
            )
        self._check_words(block, self._find_usable_words(block, g, m, motion))
        if "machine coordinates" in g and motion not in (0, 10):
            raise ProgramError("VP017", "G53 needs G0 or G1")
        if "machine coordinates" in g and g.get("distance", 900 if self.modes.absolute else 910) != 900:
            error = ProgramError("VP017", "G53 is absolute; it cannot be used with G91")
            raise error if "distance" in g else explain_g91(self.core, error, block.line)
        return motion

    def _choose_motion(self, block: Block, g: dict[str, int], axes: list[str]) -> int | None:
        """The motion code of a block: its own, or the modal one for axis words that no other code takes."""
        # G80 beside another motion code, as headers have it, gives way to it
        explicit = g.get("motion", g.get("cancel"))
        non_modal = g.get("non-modal")
        takes = non_modal in TAKES_AXES or g.get("tool length") == 431
        if takes and explicit is not None and explicit != 800:
            taker = spell_g_code(non_modal if non_modal in TAKES_AXES else 431)
            raise ProgramError(
                "VP003", f"{taker} and {spell_g_code(explicit)} both use the axis words; write two blocks"
            )
        if axes and explicit == 800 and not takes and self.traits.resumes_motion:
            explicit = self._find_resumed_motion()
        elif axes and explicit == 800 and not takes:
            raise block.error("VP006", f"{axes[0]}: G80 cancels motion, nothing uses axis words", axes[0])
        if explicit is not None or takes:
            return explicit
        # I J K alone: a full circle, or under G43.5 a turn of the tool
        arc = self.modes.motion in (20, 30)
        words = axes or [letter for letter in "IJK" if letter in block.words and (arc or self.modes.vectors)]
        if words and self.modes.motion is None:
            length = f"; {spell_g_code(g['tool length'])} is none: write G0 beside it" if "tool length" in g else ""
            text = f"{words[0]} without a motion code: no G0, G1, G2 or G3 is active{length}"
            raise block.error("VP005", text, words[0])
        if axes and self._has_user_code(block, "G"):
            raise block.error("VP006", f"{axes[0]} beside a user-defined code, and no motion code uses it", axes[0])
        return self.modes.motion if words else None

    def _find_usable_words(
        self, block: Block, g: dict[str, int], m: dict[str, list[int]], motion: int | None
    ) -> set[str]:
        """Letters that some code of the block uses."""
        letters = set("FST" + AXES)
        vectors = g.get("tool length", 435 if self.modes.vectors else 490) == 435
        if vectors and motion in (0, 10) and "machine coordinates" not in g:
            letters |= set("IJK")
        for code in (*g.values(), motion):
            letters |= set(self.table.words_of_g.get(code, "")) if code is not None else set()
        for codes in m.values():
            for code in codes:
                letters |= set(self.table.words_of_m.get(code, ""))
                letters |= set(self.traits.repeats_of_calls if code == 98 else "")
        if self._has_user_code(block):
            letters |= set(REMAPPED_WORDS)
        return letters

    def _check_words(self, block: Block, usable: set[str]) -> None:
        unused_letters = [letter for letter in block.columns if letter not in usable]
        inverse = next((code for code in block.codes if code[:2] == ("G", 93.0)), None)
        if (
            inverse is not None
            and "Z" in block.words
            and {"R", "Q"} & {*unused_letters}
            and {*unused_letters} <= _OF_DRILLING
        ):
            block.codes.remove(inverse)  # so that no line after it lacks its inverse time
            raise ProgramError("VP006", f"G93 takes no {', '.join(unused_letters)}; did you mean G83?", inverse[2])
        pocket = next((code for code in block.codes if code[:2] in (("G", 12.0), ("G", 13.0))), None)
        if pocket is not None and {"X", "Y"} & block.words.keys() and {"J", "R"} & {*unused_letters}:
            right = f"G{pocket[1] - 10:g}"
            text = f"G{pocket[1]:g}: a round pocket takes no place and no J or R; did you mean {right}?"
            raise ProgramError("VP006", text, pocket[2], edits=(Remedy(f"write {right}", right, way="marked"),))
        for letter in unused_letters:
            text = f"nothing in the block uses {letter}{block.words[letter]:g}"
            if letter in "IJK" and not block.codes and {"X", "Y", "Z"} & block.words.keys():
                text += ", because no G2 or G3 is in force: write one if an arc is meant"
            word = f"{letter}{block.words[letter]:g}"
            rights = self._list_keys_beside(block, letter)
            if rights:
                text += f"; {' or '.join(rights)} may be meant, whose key is beside"
            is_length = word != "H0"  # which would cancel the length of the tool
            if letter in _CODES_BESIDE and is_length and self.table.is_executed(_CODES_BESIDE[letter][0]):
                text += f"; the {' or '.join(_CODES_BESIDE[letter])} of a tool may be missing before it"
                rights += [f"{code} {word}" for code in _CODES_BESIDE[letter]]
            edits = _write_beside(word, rights)
            if letter == "P" and block.words["P"] >= _LEAST_PROGRAM:
                wrong = f"P{block.words['P']:.0f}"
                cut = next(
                    (f"M{number:g}" for code, number, _at in block.codes if code == "M" and number in (8, 9)), ""
                )
                if cut:
                    text += f"; M98 may be meant by {cut}"
                    edits = (Remedy("write M98", "M98", line=block.line, misspelt=cut, is_choice=True),)
                elif not block.codes:
                    text += "; the M98 of a call may be missing before it"
                    edits = (Remedy(f"write M98 {wrong}", f"M98 {wrong}", misspelt=wrong, is_choice=True),)
            raise ProgramError("VP006", text, block.columns[letter], edits=edits)

    def _list_keys_beside(self, block: Block, letter: str) -> list[str]:
        """The words of which one may be mistyped as ``letter``: its key is beside, and the block has a place for it."""
        value = block.words[letter]
        found = list[str]()
        for near in _KEYS_OF_WORDS.get(letter, ""):
            is_free = near not in block.words
            if near == "G":
                has_axes = not {*AXES}.isdisjoint(block.words.keys() - {letter})
                group = self.table.group_of_g.get(round(10 * value))
                groups = {self.table.group_of_g.get(round(10 * code[1])) for code in block.codes if code[0] == "G"}
                is_free = group not in (None, *groups) and (letter != "H" or (value in (0, 1) and has_axes))
            elif near == "M":
                is_free = value in self.table.group_of_m
            elif near in "FS":
                is_free = is_free and value >= _LEAST_SPEED and not any(one[0] == "G" for one in found)
            elif near in AXES:
                is_free = is_free and near in self.setup.axes and (letter not in "DHT" or value != int(value))
            if is_free:
                found.append(f"{near}{value:g}")
        return found

    # --- modes -----------------------------------------------------------------------------------

    def _set_modes(self, block: Block, g: dict[str, int]) -> None:
        if "plane" in g:
            self.core.set_plane((g["plane"] - 170) // 10)
            note_word(self.core, "plane", block.line)
        if "units" in g:
            self.modes.inch = g["units"] == 200
        if "lathe diameter" in g:
            self.modes.diameter_mode = g["lathe diameter"] == 70
        if self.modes.diameter_mode and "X" in block.words:
            text = "X under G7 is a diameter, which only a lathe has; write G8 first"
            raise block.error("VP002", text, "X", edits=write_before("G8"))
        if "cutter compensation" in g:
            self.motion.compensate(block, g["cutter compensation"])
        if "tool length" in g:
            self.core.refuse_compensation(spell_g_code(g["tool length"]))
            self.modes.vectors = g["tool length"] == 435
            self.offsets.set_tool_length(block, g["tool length"])
        if "work offset" in g:
            self.select_system(block, g["work offset"])
        if "path control" in g:
            self._set_path_control(block, g["path control"])
        if "distance" in g:
            self.modes.absolute = g["distance"] == 900
            note_g91(self.core, block.line, absolute=self.modes.absolute)
        if "arc distance" in g:
            self.modes.absolute_centers = g["arc distance"] == 901
        if "retract" in g:
            self.modes.initial_level = g["retract"] == 980
        if name := MOTION_LINES.get(g.get("motion")):
            note_word(self.core, name, block.line)
        if "motion" in g or "cancel" in g:
            self._set_motion(g.get("motion"))
        if self.modes.motion not in CYCLES:
            self.modes.cycle = None

    def _set_motion(self, code: int | None) -> None:
        """Set the motion code that holds; None is G80 alone."""
        modes = self.modes
        if code in CYCLES and modes.motion not in CYCLES:
            modes.motion_before = modes.motion
        if code is None and self.traits.resumes_motion:
            code = self._find_resumed_motion()
        modes.motion = code

    def _find_resumed_motion(self) -> int | None:
        """The motion code that goes on after a cycle where G80 ends the cycle alone."""
        return self.modes.motion_before if self.modes.motion in CYCLES else self.modes.motion

    def select_system(self, block: Block, code: int) -> None:
        system = self._find_system_number(block, code)
        self.core.recorder.note_system(system, block.line, block.find_code(spell_g_code(code)))
        self.core.frames.select_system(system)

    def _find_system_number(self, block: Block, code: int) -> int:
        return _SYSTEMS[code]

    def _set_path_control(self, block: Block, code: int) -> None:
        if code != 640:
            mode = PathMode.EXACT_PATH if code == 610 else PathMode.EXACT_STOP
            self.core.set_path_control(PathControl(mode))
            return
        values = []
        for letter in "PQ":
            value = block.words.get(letter)
            if value is not None and value < 0:
                raise block.error("VP007", f"{letter}{value:g}: a tolerance is not negative", letter)
            values.append(None if value is None else self.values.convert_length(value))
        self.core.set_path_control(
            PathControl(PathMode.BLEND, values[0], values[1] if values[1] is not None else values[0])
        )

    # --- dwell, offsets, home ------------------------------------------------------------

    def _dwell(self, block: Block) -> None:
        if "P" not in block.words:
            column = next(at for letter, number, at in block.codes if (letter, number) == ("G", 4.0))
            if "X" in block.words and self.modes.dwell_unit == 1.0:
                seconds = f"{block.words['X']:g}"
                raise block.error("VP005", f"X{seconds}: G4 needs P, the time; did you mean P{seconds}?", "X")
            if "S" in block.words:
                speed = f"{block.words['S']:g}"
                raise block.error("VP005", f"S{speed}: G4 needs P, the time; did you mean P{speed}?", "S")
            raise ProgramError("VP005", "G4 needs P, the time", column)
        self.core.dwell(block, self.values.read_dwell(block))
        self._warn_of_long_dwell(block)

    def _warn_of_long_dwell(self, block: Block) -> None:
        """VP505: P of G4 or of a cycle, in seconds, that would be a plausible number of milliseconds; the first one."""
        seconds, plausible = self.values.read_dwell(block), PLAUSIBLE["dwell"]
        if self.traits.dwells_in_seconds and self.setup.machine and seconds > plausible.high:
            text = (
                f"P{block.words['P']:g} is a dwell of {seconds:g} s: RS274/NGC has seconds; if milliseconds are meant, "
                f"as in Fanuc programs, give --dialect fanuc, or write P{block.words['P'] * plausible.factor:g}"
            )
            if not any(item.quantity == "dwell" for item in self.core.recorder.warnings.values()):
                self.core.recorder.note_once("VP505", text, block.line, quantity="dwell")

    def _execute_non_modal(self, block: Block, code: int) -> None:
        if code == 100:
            self.offsets.execute_g10(block)
        elif code in (280, 300):
            self.motion.go_home(block, code)
        elif code in (281, 301):
            self._store_home(block, code)
        elif code in (520, 920):
            self.offsets.execute_g92(block, code)
        elif code in (921, 922):
            if code == 921:
                self.core.frames.store_shift(ZERO9)
                self.modes.local_shift = ZERO9
            self.core.frames.apply_shift(on=False)
        else:
            self.core.frames.apply_shift(on=True)

    def _store_home(self, block: Block, code: int) -> None:
        """G28.1, G30.1: the home position is where the machine stands."""
        state = self.state
        self.core.require_known(block, [AXES.index(letter) for letter in self.setup.axes], spell_g_code(code))
        point = tuple(float(v) for v in self.setup.coordinates.map_to_machine(np.array(state.position), state.frame))
        self.core.frames.set_home(point, second=code != 281)

    def _execute_cycle(self, block: Block, motion: int, *, goes_on: bool) -> None:
        if motion in self.traits.needs_dwell and "P" in block.words:
            self._warn_of_long_dwell(block)
        self.cycles.execute(block, motion, goes_on=goes_on)

    def _execute_spline(self, block: Block, motion: int) -> None:
        self.splines.execute(block, motion)

    # --- ends, subprograms ---------------------------------------------------------------------

    def _execute_stops(self, block: Block, m: dict[str, list[int]]) -> None:
        for code in m.get("stopping", []):
            if code in (2, 30):
                self.has_ended = True
                self.splines.refuse_unfinished()
                self.core.auxiliary.end(block, f"M{code}")
            else:
                self.core.auxiliary.stop(block, code)

    def _execute_call(self, block: Block, m: dict[str, list[int]]) -> None:
        for code in m.get("subprograms", []):
            column = next(at for letter, number, at in block.codes if letter == "M" and round(number) == code)
            if code == 99:
                self.call = Call(None, column)
                return
            if "P" not in block.words:
                raise ProgramError("VP005", "M98 needs P, the number of the subprogram", column)
            repeat_letter = next((letter for letter in self.traits.repeats_of_calls if letter in block.words), None)
            repeats = 1 if repeat_letter is None else read_whole(block, repeat_letter)
            self.call = Call(str(read_whole(block, "P")), block.columns.get("P", column), repeats)

    # --- polar words -------------------------------------------------------------------------------

    def _resolve_polar(self, block: Block, g: dict[str, int]) -> None:
        """Turn ``@`` distance and ``^`` angle about XY zero into X and Y words."""
        words, state = block.words, self.state
        given = [letter for letter in POLAR if letter in words]
        if not given:
            return
        column = block.columns[given[0]]
        if g.get("non-modal") in (*TAKES_AXES, 281, 301) or "machine coordinates" in g or g.get("tool length") == 431:
            raise ProgramError(
                "VP017", f"{given[0]}: polar words are for motion, and not in machine coordinates", column
            )
        for letter in "XY":
            if letter in words:
                raise ProgramError(
                    "VP003", f"{letter} beside {given[0]}: a place is given by X, Y or by @, ^, not both", column
                )
        if g.get("plane", 170 + 10 * state.plane) != 170:
            raise ProgramError("VP017", "polar words (@, ^) need the XY plane (G17)", column)
        absolute = g.get("distance", 900 if self.modes.absolute else 910) == 900
        unit = MM_PER_INCH if g.get("units", 200 if self.modes.inch else 210) == 200 else 1.0
        x, y = state.position[0] / unit, state.position[1] / unit
        if not absolute or len(given) < len(POLAR):
            self.core.require_known(block, [0, 1], "a polar word alone, or in G91,")
        block.polar = {letter: words.pop(letter) for letter in given}
        block.columns["X"] = block.columns["Y"] = column
        for letter in given:
            del block.columns[letter]
        to_x, to_y = find_polar_end(block, x, y, absolute=absolute)
        words["X"], words["Y"] = (to_x, to_y) if absolute else (to_x - x, to_y - y)

    # --- codes ---------------------------------------------------------------------------------------

    def _group_codes(self, block: Block) -> tuple[dict[str, int], dict[str, list[int]]]:
        """G codes by modal group (times ten) and M codes by modal group; user-defined codes are executed here."""
        g: dict[str, int] = {}
        m: dict[str, list[int]] = {}
        for letter, number, column in block.codes:
            if self.core.auxiliary.execute_user_code(block, letter, number, block.words):
                if self.table.is_executed(name := f"{letter}{number:g}"):  # in other languages it has none
                    raise ProgramError("VP002", f"{name}{HAS_MEANING}; take it out of [remap]", column)
                stand_in = self.core.auxiliary.find_stand_in(letter, number)
                if stand_in is None:
                    continue
                letter, number = "M", float(stand_in)
            if letter == "G":
                code = self._read_g_code(number, column, moves=any(axis in block.words for axis in AXES))
                group = self.table.group_of_g[code]
                if group in g:
                    raise ProgramError(
                        "VP003",
                        f"{spell_g_code(g[group])} and {spell_g_code(code)} are of one modal group ({group})",
                        column,
                    )
                g[group] = code
                continue
            code = read_m_code(self.table, number, column)
            group = self.table.group_of_m[code]
            if group in m:
                raise ProgramError("VP003", f"M{m[group][0]} and M{code} are of one modal group ({group})", column)
            m.setdefault(group, []).append(code)
        if sum(len(codes) for codes in m.values()) > _MAX_M_CODES:
            raise ProgramError("VP003", f"more than {_MAX_M_CODES} M codes in one block")
        return g, m

    def _read_g_code(self, number: float, column: int, *, moves: bool) -> int:
        """The G code of a number, times ten; ``moves``: its block names axes, which nobody may ignore."""
        code = round(number * 10)
        is_code = abs(number * 10 - code) <= 10 * WHOLE_NUMBER and number >= 0
        if is_code and code in self.table.refused_g:
            name = spell_g_code(code)
            text, right_code = f"not executed: {name} ({self.table.refused_g[code]})", self.table.instead_of_g.get(code)
            edits = tuple[Remedy, ...]()
            if right_code:
                edits = (Remedy(f"write {right_code}", right_code, way="marked"),)
            raise ProgramError("VP002", text, column, about=name, edits=edits)
        if not is_code or code not in self.table.group_of_g:
            plain_codes = self._list_plain_codes()
            name = spell_g_code(code) if is_code else f"G{number:g}"
            near_codes: list[str] = []
            text = f"{name} is not a code"
            if is_code:
                text += " of this language"
                near = [spell_g_code(one) for one in sorted(self.table.group_of_g) if one // 10 == code // 10]
                codes_with_point = [one for one in plain_codes if moves and one == number]  # G434
                near_codes = self._list_near_codes(f"{number:g}", codes_with_point if moves else plain_codes)
                near_codes += ["G0"] if moves and code == _KEY_BESIDE_G0 else []
                near += [] if near else near_codes
                such = f", such as {' or '.join(', '.join(near).rsplit(', ', 1))}" if near else ""
                text += f", as {' or '.join(near_codes)} would be" if near_codes and not moves else ""
                text += (
                    f", and its block names axes; write the code that is meant{such}"
                    if moves
                    else f"; {describe_remap(name)}"
                )
            full_text = explain_unknown(text, name, map(spell_g_code, plain_codes))
            if -code in plain_codes and abs(number * 10 - code) <= 10 * WHOLE_NUMBER:
                full_text = f"{name}: no meaning in this language; did you mean {spell_g_code(-code)}?"
            is_settled = is_code and not moves and full_text == text  # else another code is meant
            near_codes = near_codes if full_text == text else []
            edits = tuple(Remedy(f"write {one}", one, way="marked", is_choice=True) for one in near_codes)
            key = ("remap", name) if is_settled else ()
            raise ProgramError("VP002", full_text, column, settled_by=key, edits=edits)
        return code

    def _list_plain_codes(self) -> list[int]:
        groups = self.table.group_of_g.items()
        return [code for code, group in groups if group not in _OF_ALL_MOVES and code not in _OF_SETTINGS]

    def _list_near_codes(self, digits: str, codes: Iterable[int]) -> list[str]:
        """The code of which a digit is there twice, if only as a choice; else the few of ``codes`` that are near.

        Those have lost a digit or a point, or have a key beside or digits swapped.
        """

        def is_near(name: str) -> bool:
            changes = [one + other for one, other in zip(name, digits, strict=False) if one != other]
            if len(name) == len(digits):
                is_swapped = len(changes) > 1 and changes[0] == changes[1][::-1]
                return changes[0] in _KEYS_BESIDE if len(changes) == 1 else is_swapped and not changes[2:]
            return has_one_more(name, digits)

        names = [spell_g_code(one)[1:] for one in sorted(self.table.group_of_g)]
        single_digits = drop_doubled_digits(digits)
        if twice := [name for name in names if name in single_digits]:
            return [f"G{name}" for name in twice]
        is_slip = len(digits) > _DIGITS_OF_CODES and not digits.endswith("0")  # G200 is one of builders and macros
        with_point = f"{digits[:-1]}.{digits[-1]}" if is_slip else ""
        names = [spell_g_code(one)[1:] for one in sorted(codes) if one < _CODES_OF_BUILDERS]
        near = [f"G{name}" for name in names if name == with_point or is_near(name) or is_near(f"0{name}")]
        return near if len(near) <= _MOST_NAMED else []

    def _has_user_code(self, block: Block, letters: str = "GM") -> bool:
        find_meaning = self.core.auxiliary.find_user_meaning
        return any(letter in letters and find_meaning(letter, number) for letter, number, _column in block.codes)
