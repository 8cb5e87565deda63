"""One block after the other: the general interpreter, in LinuxCNC's order of execution.

It is exact and complete for the supported words; long stretches of plain moves are done by
:mod:`verne_post.gcode.plain`, which must agree with it to the last bit.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.tolerances import ARC_RADIUS_INCH_MM, ARC_RADIUS_MM, POLE_SINE, VECTOR_LENGTH, WHOLE_NUMBER
from verne_post.base.units import RAD_PER_DEG
from verne_post.gcode.arcs import Arc, center_arc, radius_arc
from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.codes import (
    GROUP_OF_G,
    GROUP_OF_M,
    REFUSED_G,
    REFUSED_M,
    TAKES_AXES,
    WORDS_OF_G,
    g_name,
)  # fmt: skip
from verne_post.gcode.frame_codes import MAX_LENGTH_MM, FrameCodes, whole
from verne_post.gcode.offsets import vector9
from verne_post.gcode.state import Recorder, Setup, State
from verne_post.model.moves import AXES, ZERO9, FeedMode, MoveKind, PathControl, PathMode

Array = NDArray[np.float64]

_SYSTEMS: Final = {540: 1, 550: 2, 560: 3, 570: 4, 580: 5, 590: 6, 591: 7, 592: 8, 593: 9}
_MAX_M_CODES: Final = 4
MAX_DWELL_S: Final = 86_400.0
_X, _Y, _Z = 0, 1, 2
_A, _C = 3, 5
_ROTARY: Final = (3, 4, 5)
#: So many turns of one arc at most.
MAX_TURNS: Final = 10_000


def initial_state(setup: Setup) -> State:
    """The state that a program finds: G80 G17 G90 G91.1 G94 G40 G49 G54 G64, mm."""
    systems = dict(setup.frames)
    if setup.tool_length is not None:
        tool = (0.0, 0.0, setup.tool_length, *ZERO9[3:])
        systems = {number: replace(frame, tool=tool) for number, frame in systems.items()}
    return State(
        position=[0.0] * 9,
        known=[not setup.machine] * 9,
        systems=systems,
        frame=systems[1],
        tools=dict(setup.tools) if setup.tools is not None else None,
        length_said=setup.tool_length is not None,
    )


class Interpreter(FrameCodes):
    """Executes blocks on a state and records what they do.

    ``ended`` becomes True at M2 or M30.
    """

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        super().__init__(setup, state, recorder)
        self.ended = False

    # --- one block -------------------------------------------------------------------------

    def execute(self, block: Block) -> None:
        """Execute one block.

        Raises
        ------
        BlockError
            Before anything of the block has taken effect, except for its modal words.
        """
        if block.comment is not None:
            self._comment(block)
        if block.program_number or not (block.codes or block.words):
            return
        g, m = _codes(block)
        motion = self._plan(block, g)
        self._feed_mode(block, g)
        self._speed_and_tool(block, m)
        if 40 in g.values():
            self._dwell(block)
        self._modes(block, g)
        non_modal = g.get("non-modal")
        if non_modal is not None and non_modal != 40:
            self._non_modal(block, non_modal)
        if motion is not None and motion != 800:
            self._move(block, motion, machine="machine coordinates" in g)
        self._stop(block, m)

    def _plan(self, block: Block, g: dict[str, int]) -> int | None:
        """What the axis words of the block are for; refuses words that nothing uses."""
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
            allowed |= set(WORDS_OF_G.get(code, "")) if code is not None else set()
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

    def _comment(self, block: Block) -> None:
        text = block.comment or ""
        if text[:4].upper() == "MSG,":
            self.recorder.event(block.line, "message", text=text[4:])

    def _feed_mode(self, block: Block, g: dict[str, int]) -> None:
        state = self.state
        mode = g.get("feed mode")
        if mode is not None:
            wanted = {930: FeedMode.INVERSE, 940: FeedMode.PER_MINUTE, 950: FeedMode.PER_REVOLUTION}[mode]
            if wanted != state.feed_mode:
                state.feed = state.feed_angular = 0.0
            state.feed_mode = wanted
        if "F" in block.words:
            value = block.words["F"]
            if value < 0:
                raise BlockError("VP007", f"F{value:g}: a feed is not negative", block.columns["F"])
            state.feed_angular = value
            state.feed = value if state.feed_mode == FeedMode.INVERSE else self._length(value)

    def _speed_and_tool(self, block: Block, m: dict[str, list[int]]) -> None:
        state, record = self.state, self.recorder
        if "S" in block.words:
            if block.words["S"] < 0:
                raise BlockError("VP007", f"S{block.words['S']:g}: a spindle speed is not negative", block.columns["S"])
            state.spindle_speed = block.words["S"]
        if "T" in block.words:
            tool = whole(block, "T")
            if state.tools is not None and tool != 0 and tool not in state.tools:
                raise BlockError("VP012", f"T{tool}: the tool table has no such tool", block.columns["T"])
            state.selected_tool = tool
        if "tool change" in m:
            self._change_tool(block)
        for code in m.get("spindle", []):
            state.spindle_on = code != 5
            direction = {3: "clockwise", 4: "counterclockwise", 5: "stop"}[code]
            record.event(block.line, "spindle", direction=direction, speed=state.spindle_speed)
        for code in m.get("coolant", []):
            record.event(block.line, "coolant", state={7: "mist", 8: "flood", 9: "off"}[code])

    def _change_tool(self, block: Block) -> None:
        state = self.state
        tool = state.selected_tool or 0
        if tool:
            self._one_tool(tool)
        state.loaded_tool = tool
        state.spindle_on = False
        self.recorder.event(block.line, "tool", number=tool)

    def _modes(self, block: Block, g: dict[str, int]) -> None:
        state = self.state
        if "plane" in g:
            state.plane = (g["plane"] - 170) // 10
        if "units" in g:
            state.inch = g["units"] == 200
        if "tool length" in g:
            state.vectors = g["tool length"] == 435
            self._tool_length(block, g["tool length"])
        if "work offset" in g:
            self._set_frame(
                replace(state.systems[_SYSTEMS[g["work offset"]]], g92=state.frame.g92, tool=state.frame.tool)
            )
        if "path control" in g:
            self._path_control(block, g["path control"])
        if "distance" in g:
            state.absolute = g["distance"] == 900
        if "arc distance" in g:
            state.absolute_centers = g["arc distance"] == 901
        if "motion" in g or "cancel" in g:
            state.motion = g.get("motion")

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
        seconds = block.words.get("P")
        if seconds is None:
            raise BlockError("VP005", "G4 needs P, the time in seconds")
        if seconds < 0:
            raise BlockError("VP007", f"P{seconds:g}: a dwell is not negative", block.columns["P"])
        if seconds > MAX_DWELL_S:
            raise BlockError("VP007", f"P{seconds:g}: a dwell of more than a day is a mistake", block.columns["P"])
        self.recorder.add(self.state, block.line, MoveKind.DWELL, self.state.position, seconds)

    def _non_modal(self, block: Block, code: int) -> None:
        if code == 100:
            self._g10(block)
        elif code in (280, 300):
            self._home(block, code)
        elif code in (520, 920):
            self._g92(block, code)
        elif code in (921, 922):
            if code == 921:
                self.state.g92_stored = ZERO9
            self._set_frame(replace(self.state.frame, g92=ZERO9))
        else:
            self._set_frame(replace(self.state.frame, g92=vector9(self.state.g92_stored)))

    def _home(self, block: Block, code: int) -> None:
        state, setup = self.state, self.setup
        home = setup.home if code == 280 else setup.home2
        if home is None:
            raise BlockError(
                "VP015", f"{g_name(code)} needs the home position of the machine: add [home] {g_name(code).lower()} "
                "to the machine file, or retract with G53 G0 Z0",
            )  # fmt: skip
        axes = self._named_axes(block)
        # an incremental via word of 0 means no via point, so the axis need not be known
        moving = [axis for axis in axes if state.absolute or block.words[AXES[axis]] != 0.0]
        if not state.absolute:
            self._require_known(block, moving, f"{g_name(code)} with an incremental via point")
        if state.vector is not None or state.vectors:
            self._check_vector_axes(block, moving, machine=False)
        via = list(self._start_of_motion(MoveKind.RAPID, absolute=state.absolute, machine=not moving))
        if _C in moving:
            self.recorder.fix_c(block.line)
        for axis in moving:
            value = self._axis_value(block, axis)
            via[axis] = value if state.absolute else via[axis] + value
            state.known[axis] = True
        self._record(block.line, MoveKind.RAPID, via, moving, absolute=state.absolute)
        chosen = axes or [axis for axis, letter in enumerate(AXES) if letter in setup.axes]
        self._leave_vector_for_machine(block, chosen, g_name(code))
        self._to_machine(block.line, MoveKind.RAPID, {axis: home[axis] for axis in chosen})

    # --- motion ----------------------------------------------------------------------------------

    def _move(self, block: Block, motion: int, *, machine: bool) -> None:
        kind = MoveKind.RAPID if motion == 0 else MoveKind.FEED
        axes = self._named_axes(block)
        state = self.state
        if kind == MoveKind.FEED:
            self._check_feed(block, motion)
        if state.vector is not None or state.vectors:
            self._check_vector_axes(block, axes, machine=machine)
        if machine:
            self._leave_vector_for_machine(block, axes, "G53")
            self._to_machine(block.line, kind, {axis: self._axis_value(block, axis) for axis in axes})
            return
        if motion in (20, 30):
            self._require_known(block, self._arc_axes(axes), "an arc")
        if not state.absolute:
            self._require_known(block, axes, "an incremental move")
        start = self._start_of_motion(kind, absolute=state.absolute, machine=False)
        end = list(start)
        if _C in axes:
            self.recorder.fix_c(block.line)
        for axis in axes:
            value = self._axis_value(block, axis)
            end[axis] = value if state.absolute else end[axis] + value
        if motion in (0, 10) and state.vectors and any(letter in block.words for letter in "IJK"):
            end = self._pointed(block, end)
            axes = [*axes, _A, _C] if self.setup.machine else axes
        if motion in (20, 30):
            self._arc(block, motion, start, end)
        else:
            self._record(block.line, kind, end, axes, absolute=state.absolute)

    def _check_vector_axes(self, block: Block, axes: list[int], *, machine: bool) -> None:
        """While a tool axis holds, A and C words mean nothing; after it, both must come together."""
        state = self.state
        rotary = [axis for axis in axes if axis in _ROTARY]
        if not rotary:
            return
        letter = AXES[rotary[0]]
        if state.vectors:
            raise BlockError(
                "VP006", f"{letter} under G43.5, where I J K give the tool axis; use G43.4 for A and C words",
                block.columns[letter],
            )  # fmt: skip
        if not {_A, _C} <= set(rotary):
            raise BlockError(
                "VP013", f"{letter} alone after tool vectors: which side the table stands on was not programmed; "
                "name A and C together", block.columns[letter],
            )  # fmt: skip
        if not machine:
            state.vector = None

    def _leave_vector_for_machine(self, block: Block, axes: list[int], code: str) -> None:
        """A tool axis and machine coordinates: Z keeps the axis, a whole place of the table ends it, nothing else is told."""
        if self.state.vector is None or not set(axes) - {_Z}:
            return
        if not {_X, _Y, _A, _C} <= set(axes):
            letter = AXES[next(axis for axis in axes if axis != _Z)]
            raise BlockError(
                "VP017", f"{code} {letter} while a tool axis (I J K) holds: the table may stand on either side; name only Z, "
                "or X, Y, A and C together after G43.4 or G49", block.columns.get(letter),
            )  # fmt: skip
        self.state.vector = None

    def _pointed(self, block: Block, end: list[float]) -> list[float]:
        """Take the tool axis I J K: the end point with a pair A, C that holds it."""
        for letter in "IJK":
            if letter not in block.words:
                given = next(other for other in "IJK" if other in block.words)
                raise BlockError(
                    "VP005", f"{given} without {letter}: a tool axis needs I, J and K", block.columns[given]
                )
        vector = np.array([block.words[letter] for letter in "IJK"])
        size = float(np.linalg.norm(vector))
        if abs(size - 1.0) > VECTOR_LENGTH:
            raise BlockError(
                "VP007", f"the tool axis (I, J, K) has length {size:.6g}; it must be a unit vector", block.columns["I"]
            )
        self.state.vector = tuple(float(value) for value in vector / size)  # type: ignore[assignment]
        return self.setup.coordinates.pointed(end, vector / size, self.state.frame)

    @staticmethod
    def _arc_axes(axes: list[int]) -> list[int]:
        return sorted({0, 1, 2, *axes})

    def _check_feed(self, block: Block, motion: int) -> None:
        state = self.state
        name = g_name(motion)
        if state.feed_mode == FeedMode.INVERSE and "F" not in block.words:
            raise BlockError("VP009", f"{name} in inverse time mode (G93) needs F in its own block")
        if state.feed == 0.0:
            raise BlockError("VP009", f"{name} with feed zero; give F")
        turning = state.spindle_on and state.spindle_speed > 0
        if state.feed_mode == FeedMode.PER_REVOLUTION and self.setup.machine and not turning:
            raise BlockError("VP009", f"{name} with feed per revolution (G95) needs a turning spindle; give S and M3")
        if self.setup.machine and not state.length_said:
            raise BlockError(
                "VP012", "the tool length has not been said before the first feed move; "
                "use G43 H with --tool-table, --tool-length MM, or G49 for length 0",
            )  # fmt: skip

    def _start_of_motion(self, kind: MoveKind, *, absolute: bool, machine: bool) -> list[float]:
        """Where unnamed axes stay; applies the rule for a change of tool length under tilt."""
        state = self.state
        held, state.held = state.held, None
        if held is None:
            return state.position
        tilt = self.setup.coordinates.to_machine(np.array(state.position), state.frame)[3]
        if abs(math.sin(RAD_PER_DEG * tilt)) <= POLE_SINE and math.cos(RAD_PER_DEG * tilt) > 0:
            return state.position
        if kind != MoveKind.RAPID or not (absolute or machine):
            raise BlockError(
                "VP016", f"the tool length has changed while the table is tilted (A {tilt:g} deg), so the tip is elsewhere; "
                "the next motion must be a G0 in absolute terms",
            )  # fmt: skip
        if machine:
            return state.position
        return [p if math.isnan(h) else h for p, h in zip(state.position, held, strict=True)]

    def _to_machine(self, line: int, kind: MoveKind, targets: dict[int, float]) -> None:
        """Move the named axes to machine coordinates; the others keep theirs."""
        state, coordinates = self.state, self.setup.coordinates
        self._start_of_motion(kind, absolute=True, machine=True)
        if {_X, _Y, _C} & set(targets):
            self.recorder.fix_c(line)
        machine = coordinates.to_machine(np.array(state.position), state.frame)
        for axis, value in targets.items():
            machine[axis] = value
        end = [float(v) for v in coordinates.to_program(machine, state.frame)]
        self._record(line, kind, end, list(targets), absolute=True)
        for axis in {0, 1, 2, *targets}:
            state.named[axis] = False  # what it has now was not programmed but follows from machine coordinates

    def _record(self, line: int, kind: MoveKind, end: list[float], axes: list[int], *, absolute: bool) -> None:
        state = self.state
        if kind == MoveKind.RAPID:
            feed = math.nan
        else:
            feed = self._feed_of(line_lengths(np.array(end) - np.array(state.position)))
        self.recorder.add(state, line, kind, end, feed)
        self._arrive(end, axes, absolute=absolute)

    def _arrive(self, end: list[float], axes: list[int], *, absolute: bool) -> None:
        state = self.state
        state.position = end
        state.placed = state.placed or bool(axes)
        for axis in axes:
            state.named[axis] = True
            if absolute:
                state.known[axis] = True

    def _feed_of(self, lengths: tuple[object, object]) -> float:
        """Feed of a move as `dump moves` shows it: see :func:`effective_feed`."""
        state = self.state
        return float(effective_feed(state.feed_mode, state.feed, state.feed_angular, *lengths))

    def _arc(self, block: Block, motion: int, start: list[float], end: list[float]) -> None:
        state = self.state
        offsets = {letter: self._length(block.words[letter]) for letter in "IJK" if letter in block.words}
        for letter in "IJKR":
            if self.setup.machine and abs(self._length(block.words.get(letter, 0.0))) > MAX_LENGTH_MM:
                raise BlockError(
                    "VP007", f"{letter}{block.words[letter]:g} is beyond any machine", block.columns[letter]
                )
        turns = whole(block, "P") if "P" in block.words else 1
        if not 1 <= turns <= MAX_TURNS:
            raise BlockError("VP007", f"P{turns}: the number of turns is 1 to {MAX_TURNS}", block.columns["P"])
        clockwise = motion == 20
        if "R" in block.words:
            if offsets:
                raise BlockError("VP003", "an arc has either R or a centre (I, J, K), not both", block.columns["R"])
            arc = radius_arc(start, end, state.plane, clockwise, self._length(block.words["R"]), turns - 1)
        elif offsets:
            tolerance = ARC_RADIUS_INCH_MM if state.inch else ARC_RADIUS_MM
            arc = center_arc(start, end, state.plane, clockwise, offsets, state.absolute_centers, turns - 1, tolerance)
        else:
            raise BlockError("VP005", "an arc needs its centre (I, J, K) or its radius (R)")
        feed = self._feed_of((arc_length(arc, start, end), True))
        self.recorder.add(state, block.line, MoveKind.ARC, end, feed, arc)
        self._arrive(end, self._named_axes(block), absolute=state.absolute)

    # --- ends ------------------------------------------------------------------------------------

    def _stop(self, block: Block, m: dict[str, list[int]]) -> None:
        for code in m.get("stopping", []):
            if code in (2, 30):
                self.ended = True
                self.recorder.event(block.line, "end", code=f"M{code}")
            else:
                kind = {0: "program", 1: "optional", 60: "pallet"}[code]
                self.recorder.event(block.line, "stop", stop=kind)


def line_lengths(delta: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Length of a straight move by LinuxCNC's rule, and whether the tip moves.

    XYZ if they move, else UVW, else the norm of ABC; ``delta`` has shape (..., 9).
    """
    linear = np.sqrt(delta[..., 0] ** 2 + delta[..., 1] ** 2 + delta[..., 2] ** 2)
    second = np.sqrt(delta[..., 6] ** 2 + delta[..., 7] ** 2 + delta[..., 8] ** 2)
    angular = np.sqrt(delta[..., 3] ** 2 + delta[..., 4] ** 2 + delta[..., 5] ** 2)
    length = np.where(linear > 0, linear, np.where(second > 0, second, angular))
    return length, (linear > 0) | (second > 0)


def arc_length(arc: Arc, start: list[float], end: list[float]) -> float:
    """Length of a helical arc, mm."""
    first, second, normal = ((0, 1, 2), (2, 0, 1), (1, 2, 0))[arc.plane]
    radius = math.hypot(start[first] - arc.center[first], start[second] - arc.center[second])
    return math.hypot(radius * math.radians(arc.sweep), end[normal] - start[normal])


def effective_feed(mode: FeedMode, feed: object, angular: object, length: object, tip_moves: object) -> Array:
    """Feed in mm/min, deg/min for rotary-only moves, mm or deg per revolution for G95.

    Inverse time (F in 1/min) becomes the speed that results, length times F.
    """
    if mode == FeedMode.INVERSE:
        return np.asarray(length) * np.asarray(feed)
    return np.where(np.asarray(tip_moves), np.asarray(feed), np.asarray(angular))


def _codes(block: Block) -> tuple[dict[str, int], dict[str, list[int]]]:
    """G codes by modal group (times ten) and M codes by modal group."""
    g: dict[str, int] = {}
    m: dict[str, list[int]] = {}
    for letter, number, column in block.codes:
        if letter == "G":
            code = round(number * 10)
            if abs(number * 10 - code) > 10 * WHOLE_NUMBER or number < 0:
                raise BlockError("VP002", f"G{number:g} is not a code", column)
            if code in REFUSED_G:
                raise BlockError(
                    "VP002", f"{g_name(code)} ({REFUSED_G[code]}) is not supported by this version", column
                )
            if code not in GROUP_OF_G:
                raise BlockError("VP002", f"{g_name(code)} is not a code of this language", column)
            group = GROUP_OF_G[code]
            if group in g:
                raise BlockError(
                    "VP003", f"{g_name(g[group])} and {g_name(code)} are of one modal group ({group})", column
                )
            g[group] = code
            continue
        code = round(number)
        if abs(number - code) > WHOLE_NUMBER or number < 0:
            raise BlockError("VP007", f"M{number:g}: an M code is a whole number", column)
        if code in REFUSED_M:
            raise BlockError("VP002", f"M{code} ({REFUSED_M[code]}) is not supported by this version", column)
        if code not in GROUP_OF_M:
            raise BlockError("VP002", f"M{code} is not a code of this language", column)
        group = GROUP_OF_M[code]
        if group in m:
            raise BlockError("VP003", f"M{m[group][0]} and M{code} are of one modal group ({group})", column)
        m.setdefault(group, []).append(code)
    if sum(len(codes) for codes in m.values()) > _MAX_M_CODES:
        raise BlockError("VP003", f"more than {_MAX_M_CODES} M codes in one block")
    return g, m
