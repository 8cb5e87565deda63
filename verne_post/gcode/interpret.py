"""One block after the other: the general interpreter, in LinuxCNC's order of execution.

It is exact and complete for the language; long stretches of plain moves are done by
:mod:`verne_post.gcode.plain`, which must agree with it to the last bit. O words and
subprograms, which decide where a program goes on, are in :mod:`verne_post.gcode.flow`.
"""

from typing import ClassVar, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Ints
from verne_post.base.long_text import Text
from verne_post.base.tolerances import WHOLE_NUMBER
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.block import POLAR, Block, BlockError, read_block
from verne_post.gcode.codes import CYCLES, RS274, TAKES_AXES, CodeTable, g_name
from verne_post.gcode.frame_codes import polar_end, whole
from verne_post.gcode.messages import read_message
from verne_post.gcode.modal_codes import ModalCodes
from verne_post.gcode.parameters import Parameters
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.spline_codes import SPLINES
from verne_post.gcode.state import State
from verne_post.model.moves import AXES

_MAX_M_CODES: Final = 4
#: Numbers of G words -> codes of motion that need nothing but their own words.
_PLAIN_MOTIONS: Final = {0.0: 0, 1.0: 10, 2.0: 20, 3.0: 30}
#: M codes with which LinuxCNC's examples of switchable kinematics select one, and what it is there.
_KINEMATICS: Final = {428: "tcp on", 429: "tcp off", 430: "tcp off"}
#: Words that may stand beside a user-defined code.
_REMAPPED_WORDS: Final = "PQRLEDHK"


class Call(Struct, frozen=True):
    """M98: which subprogram, how often; None: M99."""

    label: str | None
    column: int
    repeats: int = 1


class Interpreter(ModalCodes):
    """Executes blocks on a state and records what they do.

    ``ended`` becomes True at M2 or M30; ``call`` is the call of M98 or M99 in the last block.
    """

    table: ClassVar[CodeTable] = RS274
    #: What may follow a ``%`` that begins or ends a program.
    percent: ClassVar[bytes] = rb"[ \t\r]*"
    #: Letters that begin an O word.
    o_letters: ClassVar[bytes] = b"O"
    #: A ``%`` ends a program also where none begins it.
    end_alone: ClassVar[bool] = False
    #: Lines of plain words mean what they mean in RS274/NGC, whatever :meth:`read` does with others; each class that reads
    #: in its own way says so itself.
    plain_words: ClassVar[bool] = True
    #: The end of the text ends a program.
    ends_with_text: ClassVar[bool] = False
    #: Expressions are read as Fanuc's custom macro has them.
    custom_macro: ClassVar[bool] = False

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        super().__init__(setup, state, recorder)
        self.parameters = Parameters(setup, state, custom_macro=self.custom_macro)
        own = type(self)
        self.reads_plain_words = own.read is Interpreter.read or own.__dict__.get("plain_words", False)
        self._axes = frozenset(setup.axes)
        straight, arcs = self._axes | {"F"}, self._axes | set("F" + self.table.words_of_g[20])
        self._plain_words: dict[int | None, frozenset[str]] = {0: straight, 10: straight, 20: arcs, 30: arcs}
        self.ended = False
        self.call: Call | None = None

    # --- one block -------------------------------------------------------------------------

    @classmethod
    def prepare(cls, text: str) -> str:
        """A line in the words of RS274/NGC; every character keeps its column."""
        return text

    @classmethod
    def label_of(cls, text: str) -> str:
        """What a line that begins with an O word says about the structure."""
        return cls.prepare(text)

    @classmethod
    def find_start(cls, source: Text) -> int:
        """Where the program begins in its text: after what a control does not read."""
        return 0

    @classmethod
    def leave_to_reader(cls, text: bytes, setup: Setup) -> Ints:
        """Lines of a chunk, from 0, that mean more than their words, so that only the exact reader can read them."""
        return np.empty(0, dtype=np.int32)

    def read(self, text: str, line: int) -> Block:
        """Read a line; with the current values of parameters."""
        return read_block(text, line, self.parameters)

    def execute(self, block: Block) -> None:
        """Execute one block.

        Raises
        ------
        BlockError
            Before anything of the block has taken effect, except for its modal words.
        """
        self.call = None
        for key, value, column in block.settings:
            self._set_parameter(key, value, column)
        if block.comment is not None:
            self._show_comment(block)
        if not (block.codes or block.words) or self._execute_plain_motion(block):
            return
        g, m = self._group_codes(block)
        active = self.state.motion
        self._guard_spline(g)
        motion = self._plan(block, g, m)
        self._set_feed(block, g)
        if "spindle mode" in g:
            self._set_spindle_mode(block, g["spindle mode"])
        self._execute_auxiliary(block, m)
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
            self._move(block, motion, machine="machine coordinates" in g)
        self._execute_stops(block, m)
        self._execute_call(block, m)

    def _execute_plain_motion(self, block: Block) -> bool:
        """Execute a block that only moves, with G0 to G3 or as the block before; False for any other.

        It is the short way through :meth:`execute`: one code or none, axis words, F, and the words of arcs.
        """
        state, words = self.state, block.words
        if block.codes:
            letter, number, _column = block.codes[0]
            motion = _PLAIN_MOTIONS.get(number) if letter == "G" and len(block.codes) == 1 else None
        else:
            motion = state.motion if not self._axes.isdisjoint(words) else None
        letters = self._plain_words.get(motion)
        if letters is None or not letters.issuperset(words) or state.spline is not None or state.diameter_mode:
            return False
        if "F" in words:
            if words["F"] < 0:
                return False
            self._set_feed(block, {})
        assert motion is not None
        state.motion, state.cycle = motion, None
        self._move(block, motion, machine=False)
        return True

    def _set_parameter(self, key: int | str, value: float, column: int) -> None:
        try:
            self.parameters.set(key, value)
        except BlockError as error:
            raise BlockError(error.code, error.message, column) from None

    def _show_comment(self, block: Block) -> None:
        answer = read_message(block.comment or "", self.parameters)
        if answer is None:
            return
        channel, text = answer
        if channel == "abort":
            raise BlockError("VP027", f"the program asks to stop: {text.strip()}")
        kind = "not executed" if channel == "file" else "message"
        named = {} if channel in ("file", "msg") else {"channel": channel}
        self.recorder.event(block.line, kind, text=text, **named)

    def _plan(self, block: Block, g: dict[str, int], m: dict[str, list[int]]) -> int | None:
        """The motion code that the axis words of the block are for; refuses words that nothing uses."""
        self._resolve_polar(block, g)
        axes = [letter for letter in block.words if letter in AXES]
        for letter in axes:
            if letter not in self.setup.axes:
                named = ", ".join(self.setup.axes)
                raise block.error("VP011", f"{letter}: the machine has no such axis; it has {named}", letter)
        motion = self._choose_motion(block, g, axes)
        if motion in CYCLES and (98 in m.get("subprograms", []) or 40 in g.values()):
            raise BlockError(
                "VP003", "M98 or G4 in a block of a canned cycle: P and L would serve both; write two blocks"
            )
        self._check_words(block, self._usable_words(block, g, m, motion))
        if "machine coordinates" in g and motion not in (0, 10):
            raise BlockError("VP017", "G53 needs G0 or G1")
        if "machine coordinates" in g and g.get("distance", 900 if self.state.absolute else 910) != 900:
            raise BlockError("VP017", "G53 is absolute; it cannot be used with G91")
        return motion

    def _choose_motion(self, block: Block, g: dict[str, int], axes: list[str]) -> int | None:
        """The motion code of a block: its own, or the modal one for axis words that no other code takes."""
        # G80 beside another motion code, as headers have it, gives way to it
        explicit = g.get("motion", g.get("cancel"))
        non_modal = g.get("non-modal")
        takes = non_modal in TAKES_AXES or g.get("tool length") == 431
        if takes and explicit is not None and explicit != 800:
            taker = g_name(non_modal if non_modal in TAKES_AXES else 431)
            raise BlockError("VP003", f"{taker} and {g_name(explicit)} both use the axis words; write two blocks")
        if axes and explicit == 800 and not takes:
            raise block.error("VP006", f"{axes[0]}: G80 cancels motion, nothing uses axis words", axes[0])
        if explicit is not None or takes:
            return explicit
        # I J K alone: a full circle, or under G43.5 a turn of the tool
        arc = self.state.motion in (20, 30)
        words = axes or [letter for letter in "IJK" if letter in block.words and (arc or self.state.vectors)]
        if words and self.state.motion is None:
            raise block.error("VP005", f"{words[0]} without a motion code: no G0, G1, G2 or G3 is active", words[0])
        if axes and self._has_user_code(block):
            raise block.error("VP006", f"{axes[0]} beside a user-defined code, and no motion code uses it", axes[0])
        return self.state.motion if words else None

    def _usable_words(self, block: Block, g: dict[str, int], m: dict[str, list[int]], motion: int | None) -> set[str]:
        """Letters that some code of the block uses."""
        letters = set("FST" + AXES)
        vectors = g.get("tool length", 435 if self.state.vectors else 490) == 435
        if vectors and motion in (0, 10) and "machine coordinates" not in g:
            letters |= set("IJK")
        for code in (*g.values(), motion):
            letters |= set(self.table.words_of_g.get(code, "")) if code is not None else set()
        for codes in m.values():
            for code in codes:
                letters |= set(self.table.words_of_m.get(code, ""))
        if self._has_user_code(block):
            letters |= set(_REMAPPED_WORDS)
        return letters

    @staticmethod
    def _check_words(block: Block, usable: set[str]) -> None:
        for letter, column in block.columns.items():
            if letter not in usable:
                raise BlockError("VP006", f"nothing in the block uses {letter}{block.words[letter]:g}", column)

    # --- ends, subprograms ---------------------------------------------------------------------

    def _execute_stops(self, block: Block, m: dict[str, list[int]]) -> None:
        for code in m.get("stopping", []):
            if code in (2, 30):
                self.ended = True
                self._refuse_unfinished_spline()
                self.recorder.event(block.line, "end", code=f"M{code}")
            else:
                kind = {0: "program", 1: "optional", 60: "pallet"}[code]
                self.recorder.event(block.line, "stop", stop=kind)

    def _execute_call(self, block: Block, m: dict[str, list[int]]) -> None:
        for code in m.get("subprograms", []):
            column = next(at for letter, number, at in block.codes if letter == "M" and round(number) == code)
            if code == 99:
                self.call = Call(None, column)
                return
            if "P" not in block.words:
                raise BlockError("VP005", "M98 needs P, the number of the subprogram", column)
            repeats = whole(block, "L") if "L" in block.words else 1
            self.call = Call(str(whole(block, "P")), column, repeats)

    # --- polar words -------------------------------------------------------------------------------

    def _resolve_polar(self, block: Block, g: dict[str, int]) -> None:
        """Turn ``@`` distance and ``^`` angle about XY zero into X and Y words."""
        words, state = block.words, self.state
        given = [letter for letter in POLAR if letter in words]
        if not given:
            return
        column = block.columns[given[0]]
        if g.get("non-modal") in (*TAKES_AXES, 281, 301) or "machine coordinates" in g or g.get("tool length") == 431:
            raise BlockError("VP017", f"{given[0]}: polar words are for motion, and not in machine coordinates", column)
        for letter in "XY":
            if letter in words:
                raise BlockError(
                    "VP003", f"{letter} beside {given[0]}: a place is given by X, Y or by @, ^, not both", column
                )
        if g.get("plane", 170 + 10 * state.plane) != 170:
            raise BlockError("VP017", "polar words (@, ^) need the XY plane (G17)", column)
        absolute = g.get("distance", 900 if state.absolute else 910) == 900
        unit = MM_PER_INCH if g.get("units", 200 if state.inch else 210) == 200 else 1.0
        x, y = state.position[0] / unit, state.position[1] / unit
        if not absolute or len(given) < len(POLAR):
            self._require_known(block, [0, 1], "a polar word alone, or in G91,")
        block.polar = {letter: words.pop(letter) for letter in given}
        block.columns["X"] = block.columns["Y"] = column
        for letter in given:
            del block.columns[letter]
        to_x, to_y = polar_end(block, x, y, absolute=absolute)
        words["X"], words["Y"] = (to_x, to_y) if absolute else (to_x - x, to_y - y)

    # --- codes ---------------------------------------------------------------------------------------

    def _group_codes(self, block: Block) -> tuple[dict[str, int], dict[str, list[int]]]:
        """G codes by modal group (times ten) and M codes by modal group; user-defined codes are executed here."""
        g: dict[str, int] = {}
        m: dict[str, list[int]] = {}
        for letter, number, column in block.codes:
            if self._execute_user_code(block, letter, number):
                continue
            if letter == "G":
                code = self._g_code(number, column)
                group = self.table.group_of_g[code]
                if group in g:
                    raise BlockError(
                        "VP003", f"{g_name(g[group])} and {g_name(code)} are of one modal group ({group})", column
                    )
                g[group] = code
                continue
            code = self._m_code(number, column)
            group = self.table.group_of_m[code]
            if group in m:
                raise BlockError("VP003", f"M{m[group][0]} and M{code} are of one modal group ({group})", column)
            m.setdefault(group, []).append(code)
        if sum(len(codes) for codes in m.values()) > _MAX_M_CODES:
            raise BlockError("VP003", f"more than {_MAX_M_CODES} M codes in one block")
        return g, m

    def _g_code(self, number: float, column: int) -> int:
        code = round(number * 10)
        if abs(number * 10 - code) > 10 * WHOLE_NUMBER or number < 0:
            raise BlockError("VP002", f"G{number:g} is not a code", column)
        if code in self.table.refused_g:
            raise BlockError("VP002", f"{g_name(code)} is not executed ({self.table.refused_g[code]})", column)
        if code not in self.table.group_of_g:
            raise BlockError("VP002", f"{g_name(code)} is not a code of this language", column)
        return code

    def _m_code(self, number: float, column: int) -> int:
        code = round(number)
        if abs(number - code) > WHOLE_NUMBER or number < 0:
            raise BlockError("VP007", f"M{number:g}: an M code is a whole number", column)
        settles = f'[remap] in verne-post.toml can give it a meaning: M{code} = "ignore", or "event"'
        if code in _KINEMATICS:
            settles = (
                f"LinuxCNC switches kinematics with it, and [remap] in verne-post.toml says to which: M{code} = "
                f'"tcp on" or "tcp off" (in its examples "{_KINEMATICS[code]}")'
            )
        if code in self.table.refused_m:
            raise BlockError("VP002", f"M{code} is not executed ({self.table.refused_m[code]}); {settles}", column)
        if code not in self.table.group_of_m:
            raise BlockError("VP002", f"M{code} is not a code of this language; {settles}", column)
        return code

    def _meaning(self, letter: str, number: float) -> str | None:
        """The meaning that [remap] in the settings file gives to a code."""
        if not self.setup.remap or number < 0:
            return None
        return self.setup.remap.get(g_name(round(number * 10)) if letter == "G" else f"M{number:g}")

    def _has_user_code(self, block: Block) -> bool:
        return any(self._meaning(letter, number) for letter, number, _column in block.codes)

    def _execute_user_code(self, block: Block, letter: str, number: float) -> bool:
        """Execute a user-defined code ([remap]); False for any other."""
        meaning = self._meaning(letter, number)
        if meaning is None:
            return False
        if meaning in ("tcp on", "tcp off"):
            self.state.tcp_off = meaning == "tcp off"
            self.recorder.says_tcp = True
        if meaning != "ignore":
            words = {key: value for key, value in block.words.items() if key in _REMAPPED_WORDS}
            self.recorder.event(block.line, "remapped", code=f"{letter}{number:g}", meaning=meaning, **words)
        return True
