"""One block after the other: the general interpreter, in LinuxCNC's order of execution.

It is exact and complete for the language; long stretches of plain moves are done by
:mod:`verne_post.gcode.plain`, which must agree with it to the last bit. Where a program goes on, O words
and subprograms say, in :mod:`verne_post.gcode.flow`.
"""

from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np

from verne_post.base.tolerances import WHOLE_NUMBER
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.block import POLAR, Block, BlockError, read_block
from verne_post.gcode.codes import CYCLES, RS274, TAKES_AXES, CodeTable, g_name
from verne_post.gcode.cycle_codes import CycleCodes
from verne_post.gcode.frame_codes import polar_end, whole
from verne_post.gcode.messages import message
from verne_post.gcode.offsets import vector9
from verne_post.gcode.parameters import Parameters
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State
from verne_post.model.moves import AXES, ZERO9, PathControl, PathMode

_SYSTEMS: Final = {540: 1, 550: 2, 560: 3, 570: 4, 580: 5, 590: 6, 591: 7, 592: 8, 593: 9}
_MAX_M_CODES: Final = 4
#: Words that may stand beside a code of the shop.
_REMAPPED_WORDS: Final = "PQRLEDHK"


def initial_state(setup: Setup) -> State:
    """The state that a program finds: G80 G17 G90 G91.1 G94 G40 G49 G54 G64, mm."""
    systems = dict(setup.frames)
    if setup.tool_length is not None:
        tool = (0.0, 0.0, setup.tool_length, *ZERO9[3:])
        systems = {number: replace(frame, tool=tool) for number, frame in systems.items()}
    state = State(
        position=[0.0] * 9,
        known=[not setup.machine] * 9,
        systems=systems,
        frame=systems[1],
        tools=dict(setup.tools) if setup.tools is not None else None,
        length_given=setup.tool_length is not None,
        home=setup.home,
        home2=setup.home2,
    )
    _take_parameters(setup, state)
    return state


def _take_parameters(setup: Setup, state: State) -> None:
    """Start from a parameter file: what it keeps, and the work system and G92 that were active."""
    parameters = Parameters(setup, state)
    for index, value in setup.parameters.items():
        if index not in (5210, 5220) and not 5221 <= index < 5400:
            parameters.set(index, value)
    for index, value in setup.parameters.items():
        if 5221 <= index < 5400 and (index - 5221) // 20 + 1 not in setup.given_systems:
            parameters.set(index, value)
    if setup.parameters:
        system = round(setup.parameters.get(5220, 1.0))
        state.g92_on = setup.parameters.get(5210, 0.0) != 0.0
        g92 = vector9(state.g92_stored) if state.g92_on else ZERO9
        state.frame = replace(state.systems[system if system in state.systems else 1], g92=g92)


@dataclass(frozen=True)
class Call:
    """M98: which subprogram, how often; None: M99."""

    label: str | None
    column: int
    repeats: int = 1


class Interpreter(CycleCodes):
    """Executes blocks on a state and records what they do.

    ``ended`` becomes True at M2 or M30; ``call`` is what M98 or M99 of the last block ask for.
    """

    table: ClassVar[CodeTable] = RS274
    #: What may stand behind a ``%`` that begins or ends a program.
    percent: ClassVar[bytes] = rb"[ \t\r]*"
    #: Letters that begin an O word.
    o_letters: ClassVar[bytes] = b"O"
    #: Expressions are read as Fanuc's custom macro has them.
    custom_macro: ClassVar[bool] = False

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        super().__init__(setup, state, recorder)
        self.parameters = Parameters(setup, state, custom_macro=self.custom_macro)
        self.ended = False
        self.call: Call | None = None

    # --- one block -------------------------------------------------------------------------

    @classmethod
    def prepared(cls, text: str) -> str:
        """A line in the words of RS274/NGC; every character keeps its column."""
        return text

    def read(self, text: str, line: int) -> Block:
        """Read a line; parameters have the values of now."""
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
            self._set(key, value, column)
        if block.comment is not None:
            self._comment(block)
        if not (block.codes or block.words):
            return
        g, m = self._codes(block)
        goes_on = self.state.motion
        motion = self._plan(block, g, m)
        self._feed_mode(block, g)
        self._speed_and_tool(block, m)
        if 40 in g.values():
            self._dwell(block)
        self._modes(block, g)
        non_modal = g.get("non-modal")
        if non_modal is not None and non_modal != 40:
            self._non_modal(block, non_modal)
        if motion in CYCLES:
            self._cycle(block, motion, goes_on=goes_on == motion)
        elif motion is not None and motion != 800:
            self._move(block, motion, machine="machine coordinates" in g)
        self._stop(block, m)
        self._subprogram(block, m)

    def _set(self, key: int | str, value: float, column: int) -> None:
        try:
            self.parameters.set(key, value)
        except BlockError as error:
            raise BlockError(error.code, error.message, column) from None

    def _comment(self, block: Block) -> None:
        found = message(block.comment or "", self.parameters)
        if found is None:
            return
        channel, text = found
        if channel == "abort":
            raise BlockError("VP027", f"the program asks to stop: {text.strip()}")
        if channel == "file":
            self.recorder.event(block.line, "not executed", text=text)
        elif channel == "msg":
            self.recorder.event(block.line, "message", text=text)
        else:
            self.recorder.event(block.line, "message", text=text, channel=channel)

    def _plan(self, block: Block, g: dict[str, int], m: dict[str, list[int]]) -> int | None:
        """What the axis words of the block are for; refuses words that nothing uses."""
        self._polar(block, g)
        axes = [letter for letter in block.words if letter in AXES]
        for letter in axes:
            if letter not in self.setup.axes:
                named = ", ".join(self.setup.axes)
                raise BlockError(
                    "VP011", f"{letter}: the machine has no such axis; it has {named}", block.columns[letter]
                )
        # G80 beside another motion code, as headers have it, gives way to it
        explicit = g.get("motion", g.get("cancel"))
        non_modal = g.get("non-modal")
        takes = non_modal in TAKES_AXES or g.get("tool length") == 431
        if takes and explicit is not None and explicit != 800:
            taker = g_name(non_modal if non_modal in TAKES_AXES else 431)
            raise BlockError("VP003", f"{taker} and {g_name(explicit)} both use the axis words; write two blocks")
        motion = explicit
        tool_axis = self.state.vectors and any(letter in block.words for letter in "IJK")
        if (axes or tool_axis) and not takes and explicit is None:
            motion = self.state.motion
            if motion is None:
                first = axes[0] if axes else next(letter for letter in "IJK" if letter in block.words)
                raise BlockError(
                    "VP005", f"{first} without a motion code: no G0, G1, G2 or G3 is active", block.columns[first]
                )
        if axes and explicit == 800:
            if not takes:
                raise BlockError(
                    "VP006", f"{axes[0]}: G80 cancels motion, nothing uses axis words", block.columns[axes[0]]
                )
            motion = 800
        allowed = set("FST" + AXES)
        vectors = g.get("tool length", 435 if self.state.vectors else 490) == 435
        if vectors and motion in (0, 10) and "machine coordinates" not in g:
            allowed |= set("IJK")
        for code in (*g.values(), motion):
            allowed |= set(self.table.words_of_g.get(code, "")) if code is not None else set()
        for codes in m.values():
            for code in codes:
                allowed |= set(self.table.words_of_m.get(code, ""))
        if any(self._meaning(letter, number) for letter, number, _column in block.codes):
            allowed |= set(_REMAPPED_WORDS)
            if axes and explicit is None and not takes:
                raise BlockError(
                    "VP006", f"{axes[0]} beside a code of the shop: nothing says what it is for", block.columns[axes[0]]
                )
        if motion in CYCLES and (98 in m.get("subprograms", []) or 40 in g.values()):
            raise BlockError(
                "VP003", "M98 or G4 in a block of a canned cycle: P and L would serve both; write two blocks"
            )
        for letter, column in block.columns.items():
            if letter not in allowed:
                raise BlockError("VP006", f"nothing in the block uses {letter}{block.words[letter]:g}", column)
        if "machine coordinates" in g and motion not in (0, 10):
            raise BlockError("VP017", "G53 needs G0 or G1")
        absolute = g.get("distance", 900 if self.state.absolute else 910) == 900
        if "machine coordinates" in g and not absolute:
            raise BlockError("VP017", "G53 is absolute; it cannot be used with G91")
        return motion

    # --- words that set modes ----------------------------------------------------------------

    def _modes(self, block: Block, g: dict[str, int]) -> None:
        state = self.state
        if "plane" in g:
            plane = (g["plane"] - 170) // 10
            if plane != state.plane:
                self._refuse_compensation("a change of plane")
            state.plane = plane
        if "units" in g:
            state.inch = g["units"] == 200
        if "lathe diameter" in g:
            state.diameter_mode = g["lathe diameter"] == 70
        if state.diameter_mode and "X" in block.words:
            raise BlockError(
                "VP002", "X under G7 is a diameter, which only a lathe has; write G8 first", block.columns["X"]
            )
        if "cutter compensation" in g:
            self._compensate(block, g["cutter compensation"])
        if "tool length" in g:
            self._refuse_compensation(g_name(g["tool length"]))
            state.vectors = g["tool length"] == 435
            self._tool_length(block, g["tool length"])
        if "work offset" in g:
            self._select_system(block, g["work offset"])
        if "path control" in g:
            self._path_control(block, g["path control"])
        if "distance" in g:
            state.absolute = g["distance"] == 900
        if "arc distance" in g:
            state.absolute_centers = g["arc distance"] == 901
        if "retract" in g:
            state.initial_level = g["retract"] == 980
        if "motion" in g or "cancel" in g:
            state.motion = g.get("motion")
        if state.motion not in CYCLES:
            state.cycle = None

    def _select_system(self, block: Block, code: int) -> None:
        state = self.state
        system = self._system(block, code)
        if system != state.frame.system:
            self._set_frame(replace(state.systems[system], g92=state.frame.g92, tool=state.frame.tool))

    def _system(self, block: Block, code: int) -> int:
        """Number of the work system of a code."""
        return _SYSTEMS[code]

    def _path_control(self, block: Block, code: int) -> None:
        if code != 640:
            mode = PathMode.EXACT_PATH if code == 610 else PathMode.EXACT_STOP
            self.state.control = PathControl(mode)
            return
        values = []
        for letter in "PQ":
            value = block.words.get(letter)
            if value is not None and value < 0:
                raise BlockError("VP007", f"{letter}{value:g}: a tolerance is not negative", block.columns[letter])
            values.append(None if value is None else self._length(value))
        self.state.control = PathControl(PathMode.BLEND, values[0], values[1] if values[1] is not None else values[0])

    # --- dwell, offsets, home ------------------------------------------------------------

    def _dwell(self, block: Block) -> None:
        if "P" not in block.words:
            raise BlockError("VP005", "G4 needs P, the time in seconds")
        self._wait(block, self._seconds(block))

    def _non_modal(self, block: Block, code: int) -> None:
        if code == 100:
            self._g10(block)
        elif code in (280, 300):
            self._home(block, code)
        elif code in (281, 301):
            self._store_home(block, code)
        elif code in (520, 920):
            self._g92(block, code)
        elif code in (921, 922):
            if code == 921:
                self.state.g92_stored = ZERO9
            self._shift(on=False)
        else:
            self._shift(on=True)

    def _store_home(self, block: Block, code: int) -> None:
        """G28.1, G30.1: the home position is where the machine stands."""
        state = self.state
        self._require_known(block, [AXES.index(letter) for letter in self.setup.axes], g_name(code))
        point = tuple(float(v) for v in self.setup.coordinates.to_machine(np.array(state.position), state.frame))
        if code == 281:
            state.home = point
        else:
            state.home2 = point

    # --- ends, subprograms ---------------------------------------------------------------------

    def _stop(self, block: Block, m: dict[str, list[int]]) -> None:
        for code in m.get("stopping", []):
            if code in (2, 30):
                self.ended = True
                self.recorder.event(block.line, "end", code=f"M{code}")
            else:
                kind = {0: "program", 1: "optional", 60: "pallet"}[code]
                self.recorder.event(block.line, "stop", stop=kind)

    def _subprogram(self, block: Block, m: dict[str, list[int]]) -> None:
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

    def _polar(self, block: Block, g: dict[str, int]) -> None:
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

    def _codes(self, block: Block) -> tuple[dict[str, int], dict[str, list[int]]]:
        """G codes by modal group (times ten) and M codes by modal group; codes of the shop are done here."""
        g: dict[str, int] = {}
        m: dict[str, list[int]] = {}
        for letter, number, column in block.codes:
            if self._remapped(block, letter, number):
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
        if code in self.table.refused_m:
            raise BlockError("VP002", f"M{code} is not executed ({self.table.refused_m[code]})", column)
        if code not in self.table.group_of_m:
            raise BlockError(
                "VP002",
                f"M{code} is not a code of this language; [remap] in the settings file can give it a meaning",
                column,
            )
        return code

    def _meaning(self, letter: str, number: float) -> str | None:
        """What the settings say about a code."""
        if not self.setup.remap or number < 0:
            return None
        return self.setup.remap.get(g_name(round(number * 10)) if letter == "G" else f"M{number:g}")

    def _remapped(self, block: Block, letter: str, number: float) -> bool:
        """Do what the settings say about a code of the shop."""
        meaning = self._meaning(letter, number)
        if meaning is None:
            return False
        if meaning in ("tcp on", "tcp off"):
            self.state.tcp_off = meaning == "tcp off"
        if meaning != "ignore":
            words = {key: value for key, value in block.words.items() if key in _REMAPPED_WORDS}
            self.recorder.event(block.line, "remapped", code=f"{letter}{number:g}", meaning=meaning, **words)
        return True
