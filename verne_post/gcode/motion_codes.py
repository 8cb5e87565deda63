"""Codes that move: straight moves, arcs, tool vectors, home positions, cutter compensation."""

import math
from typing import ClassVar, Final

import numpy as np

from verne_post.base.tolerances import (
    ARC_RADIUS_INCH_MM,
    ARC_RADIUS_MM,
    POLE_SINE,
    UPRIGHT_DEG,
    VECTOR_LENGTH,
    ZERO_LENGTH_MM,
)
from verne_post.base.units import RAD_PER_DEG
from verne_post.gcode.arcs import Arc, center_arc, radius_arc
from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.codes import g_name
from verne_post.gcode.compensation import Compensation
from verne_post.gcode.frame_codes import MAX_LENGTH_MM, whole
from verne_post.gcode.lengths import arc_length, effective_feed, length_of, line_lengths
from verne_post.gcode.machine_codes import MachineCodes
from verne_post.model.moves import AXES, FeedMode, MoveKind, TablePlace
from verne_post.model.part_setup import tool_text

_X, _Y, _Z = 0, 1, 2
_A, _C = 3, 5
_ROTARY: Final = (3, 4, 5)
#: So many turns of one arc at most.
MAX_TURNS: Final = 10_000


class MotionCodes(MachineCodes):
    """Machine codes, and those that move the axes."""

    #: The entry move of cutter compensation ends beside the start of the contour, not beside its own end.
    perpendicular_entry: ClassVar[bool] = False
    #: Such a compensation begins with its first block, also without motion in the plane.
    begins_at_once: ClassVar[bool] = True
    #: G41.1 and G42.1 are there, which take the diameter itself.
    diameter_codes: ClassVar[bool] = True
    #: Words that give a tool axis.
    axis_words: ClassVar[str] = "I J K"
    #: What gives a tool length.
    length_words: ClassVar[str] = "G43 H with --tool-table, --tool-length MM, or G49 for length 0"

    # --- home --------------------------------------------------------------------------------

    def _go_home(self, block: Block, code: int) -> None:
        state, setup = self.state, self.setup
        self._refuse_compensation(g_name(code))
        home = state.home if code == 280 else state.home2
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
        if state.tool_axis is not None or state.vectors:
            self._check_vector_axes(block, moving, machine=False)
        via = list(self._motion_start(MoveKind.RAPID, absolute=state.absolute, machine=not moving))
        if _C in moving:
            self.recorder.fix_c(block.line)
        for axis in moving:
            value = self._axis_value(block, axis)
            via[axis] = value if state.absolute else via[axis] + value
        if state.tcp_off and moving:
            self._check_tcp_off(state.position, via)
        self._record(block.line, MoveKind.RAPID, via, moving, absolute=state.absolute)
        chosen = axes or [axis for axis, letter in enumerate(AXES) if letter in setup.axes]
        for axis in chosen:
            if math.isnan(home[axis]):
                raise BlockError(
                    "VP015", f"{g_name(code)} needs the home position of {AXES[axis]}, which was never set"
                )
        self._end_vector_for_machine(block.line, chosen)
        self._move_to_machine(block.line, MoveKind.RAPID, self._home_targets(block, code, home, chosen))

    def _home_targets(self, block: Block, code: int, home: tuple[float, ...], axes: list[int]) -> dict[int, float]:
        """Machine coordinates of axes that go home; X or Y alone goes along its direction in a turned work system."""
        targets = {axis: home[axis] for axis in axes}
        state, coordinates = self.state, self.setup.coordinates
        if not state.frame.turn or len({_X, _Y} & set(axes)) != 1:
            return targets
        axis = _X if _X in axes else _Y
        name = f"{g_name(code)} {AXES[axis]} alone in a turned work system (R of G10 L2)"
        self._require_known(block, [_X, _Y], name)
        if math.isnan(home[_X]) or math.isnan(home[_Y]):
            raise BlockError("VP015", f"{name} needs the home position of X and of Y")
        here = np.array([state.position, state.position])
        here[1, axis] += 1.0
        place, beside = coordinates.to_machine(here, state.frame)[:, :3]
        angle = RAD_PER_DEG * state.frame.turn + (0.5 * math.pi if axis == _Y else 0.0)
        direction = np.array([math.cos(angle), math.sin(angle), 0.0])
        if np.abs(beside - place - direction).max() > RAD_PER_DEG * UPRIGHT_DEG:
            raise block.error("VP017", f"{name}, while the table is turned or tilted: {AXES[axis]} is no direction of the machine; name X and Y "
                "together, or turn the table to A0 C0 before", AXES[axis])  # fmt: skip
        end = place + np.dot([home[_X] - place[0], home[_Y] - place[1]], direction[:2]) * direction
        return targets | {_X: float(end[0]), _Y: float(end[1])}

    # --- motion ----------------------------------------------------------------------------------

    def _move(self, block: Block, motion: int, *, machine: bool) -> None:
        kind = MoveKind.RAPID if motion == 0 else MoveKind.FEED
        axes = self._named_axes(block)
        state = self.state
        if kind == MoveKind.FEED:
            self._check_feed(block, motion)
        if state.tool_axis is not None or state.vectors:
            self._check_vector_axes(block, axes, machine=machine)
        if machine:
            self._refuse_compensation("G53")
            self._end_vector_for_machine(block.line, axes)
            self._move_to_machine(block.line, kind, {axis: self._axis_value(block, axis) for axis in axes})
            return
        if False in state.known:
            if motion in (20, 30):
                self._require_known(block, self._arc_axes(axes), "an arc")
            if not state.absolute:
                self._require_known(block, axes, "an incremental move")
        start = self._motion_start(kind, absolute=state.absolute, machine=False)
        end = list(start)
        if _C in axes:
            self.recorder.fix_c(block.line)
        for axis in axes:
            value = self._axis_value(block, axis)
            end[axis] = value if state.absolute else end[axis] + value
        if state.tcp_off:
            self._check_tcp_off(start, end)
        if motion in (0, 10) and state.vectors and any(letter in block.words for letter in "IJK"):
            end = self._point_tool(block, end)
            axes = [*axes, _A, _C] if self.setup.machine else axes
        if motion in (20, 30):
            self._move_on_arc(block, motion, start, end)
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
            raise block.error(
                "VP006", f"{letter} under G43.5, where I J K give the tool axis; use G43.4 for A and C words", letter
            )
        if not {_A, _C} <= set(rotary):
            raise block.error("VP013", f"{letter} alone after tool vectors: which side the table stands on was not programmed; "
                "name A and C together", letter)  # fmt: skip
        if not machine:
            state.tool_axis = None

    def _end_vector_for_machine(self, line: int, axes: list[int]) -> None:
        """A tool axis and machine coordinates: Z keeps the axis, a whole place of the table ends it, anything else settles the table."""
        if self.state.tool_axis is None or (not set(axes) - {_Z} and not self._depends_on_side()):
            return
        if {_X, _Y, _A, _C} <= set(axes):
            self.state.tool_axis = None
        else:
            self._settle_table(line)

    def _depends_on_side(self) -> bool:
        """Whether Z of the machine is another one on the other side of the table: where the axes of the table do not meet."""
        coordinates, frame = self.setup.coordinates, self.state.frame
        here = coordinates.to_machine(np.array(self.state.position), frame)
        turned = here.copy()
        turned[[_A, _C]] = -here[_A], here[_C] + 180.0
        other = np.array(self.state.position)
        other[[_A, _C]] = coordinates.to_program(turned, frame)[[_A, _C]]
        return bool(abs(coordinates.to_machine(other, frame)[_Z] - here[_Z]) > ZERO_LENGTH_MM)

    def _settle_table(self, line: int) -> None:
        """A tool axis gives way to the place of the table that it has.

        Of all that hold the axis, only the whole program decides which one that is: the place that has been found for it
        (``setup.table_places``), and as long as there is none the nearest. A rapid to it has no length in the end: it begins
        where the table stands.
        """
        state, coordinates, recorder = self.state, self.setup.coordinates, self.recorder
        machine = coordinates.to_machine(np.array(state.position), state.frame)
        places, number = self.setup.table_places, len(recorder.table_places)
        pair = places[number] if number < len(places) else (float(machine[_A]), float(machine[_C]))
        recorder.table_places.append(TablePlace(recorder.count, pair))
        state.tool_axis = None
        if pair == (machine[_A], machine[_C]):
            return
        machine[[_A, _C]] = pair
        place = coordinates.to_program(machine, state.frame)
        end = list(state.position)  # the tip stays at its place of the part
        end[_A], end[_C] = float(place[_A]), float(place[_C])
        recorder.add(state, line, MoveKind.RAPID, end, math.nan)
        state.position = end

    def _point_tool(self, block: Block, end: list[float]) -> list[float]:
        """Take the tool axis I J K: the end point with a pair A, C that holds it."""
        for letter in "IJK":
            if letter not in block.words:
                given = next(other for other in "IJK" if other in block.words)
                raise block.error("VP005", f"{given} without {letter}: a tool axis needs I, J and K", given)
        vector = np.array([block.words[letter] for letter in "IJK"])
        size = float(length_of(vector))
        if abs(size - 1.0) > VECTOR_LENGTH:
            raise block.error("VP007", f"the tool axis (I, J, K) has length {size:.6g}; it must be a unit vector", "I")
        self.state.tool_axis = tuple(float(value) for value in vector / size)  # type: ignore[assignment]
        return self.setup.coordinates.point_axis(end, vector / size, self.state.frame)

    @staticmethod
    def _arc_axes(axes: list[int]) -> list[int]:
        return sorted({0, 1, 2, *axes})

    def _check_feed(self, block: Block, motion: int) -> None:
        state = self.state
        name = g_name(motion)
        if state.feed_mode == FeedMode.INVERSE and "F" not in block.words:
            raise BlockError("VP009", f"{name} with inverse-time feed (G93) needs F in the same block")
        if state.feed == 0.0:
            raise BlockError("VP009", f"{name} with feed rate zero; give F")
        if state.feed_mode == FeedMode.PER_REVOLUTION and state.surface_speed and self.setup.machine:
            raise BlockError("VP017", f"{name} with feed per revolution (G95) under G96: the feed rate would follow the spindle, and that the distance "
                             "of the tool from X0; write G94, or G97 with S")  # fmt: skip
        turning = state.spindle_on and state.spindle_speed > 0
        if state.feed_mode == FeedMode.PER_REVOLUTION and self.setup.machine and not turning:
            raise BlockError("VP009", f"{name} with feed per revolution (G95) needs a turning spindle; give S and M3")
        if self.setup.machine and not state.length_given:
            raise BlockError(
                "VP012", f"no tool length has been given before the first feed move; use {self.length_words}"
            )

    def _motion_start(self, kind: MoveKind, *, absolute: bool, machine: bool) -> list[float]:
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

    def _move_to_machine(self, line: int, kind: MoveKind, targets: dict[int, float]) -> None:
        """Move the named axes to machine coordinates; the others keep theirs."""
        state, coordinates = self.state, self.setup.coordinates
        self._motion_start(kind, absolute=True, machine=True)
        if {_X, _Y, _C} & set(targets):
            self.recorder.fix_c(line)
        machine = coordinates.to_machine(np.array(state.position), state.frame)
        for axis, value in targets.items():
            machine[axis] = value
        end = [float(v) for v in coordinates.to_program(machine, state.frame)]
        self._name_axes(end, list(targets), machine=True)
        self._record(line, kind, end, list(targets), absolute=False)
        for axis in {0, 1, 2, *targets}:
            state.named[axis] = False  # what it has now was not programmed but follows from machine coordinates

    def _record(self, line: int, kind: MoveKind, end: list[float], axes: list[int], *, absolute: bool) -> None:
        state = self.state
        begin, target = state.centre or state.position, end
        state.centre = None
        if state.compensation is not None:
            self._check_compensated(state.position, end)
            target = state.compensation.offset_line(self.recorder, state.position, end, state.feed)
        if kind == MoveKind.RAPID:
            feed = math.nan
        elif state.feed_mode != FeedMode.INVERSE and state.feed == state.feed_angular:
            feed = state.feed
        else:
            feed = self._feed_of(line_lengths(np.array(target) - np.array(begin)))
        self.recorder.add(state, line, kind, target, feed)
        if state.compensation is not None:
            state.compensation.settle(self.recorder.count - 1, line, end)
            state.centre = target
        state.arc_may_follow = True
        self._arrive(end, axes, absolute=absolute)

    def _arrive(self, end: list[float], axes: list[int], *, absolute: bool) -> None:
        state = self.state
        if absolute and False in state.known:
            self._name_axes(end, axes)
        state.position = end
        state.placed = state.placed or bool(axes)
        for axis in axes:
            state.named[axis] = True

    def _feed_of(self, lengths: tuple[object, object]) -> float:
        """Feed of a move as `dump moves` shows it: see :func:`~verne_post.gcode.lengths.effective_feed`."""
        state = self.state
        return float(effective_feed(state.feed_mode, state.feed, state.feed_angular, *lengths))

    def _move_on_arc(self, block: Block, motion: int, start: list[float], end: list[float]) -> None:
        state = self.state
        offsets = {letter: self._length(block.words[letter]) for letter in "IJK" if letter in block.words}
        if self.setup.machine:
            for letter in "IJKR":
                if abs(self._length(block.words.get(letter, 0.0))) > MAX_LENGTH_MM:
                    raise block.error("VP007", f"{letter}{block.words[letter]:g} is beyond any machine", letter)
        turns = whole(block, "P") if "P" in block.words else 1
        if not 1 <= turns <= MAX_TURNS:
            raise block.error("VP007", f"P{turns}: the number of turns is 1 to {MAX_TURNS}", "P")
        clockwise = motion == 20
        if "R" in block.words:
            if offsets:
                raise block.error("VP003", "an arc has either R or a centre (I, J, K), not both", "R")
            arc = radius_arc(start, end, state.plane, clockwise, self._length(block.words["R"]), turns - 1)
        elif offsets:
            tolerance = ARC_RADIUS_INCH_MM if state.inch else ARC_RADIUS_MM
            arc = center_arc(start, end, state.plane, clockwise, offsets, state.absolute_centers, turns - 1, tolerance)
        else:
            raise BlockError("VP005", "an arc needs its centre (I, J, K) or its radius (R)")
        self._record_arc(block.line, start, end, arc, self._named_axes(block), absolute=state.absolute)

    def _record_arc(
        self, line: int, start: list[float], end: list[float], arc: Arc, axes: list[int], *, absolute: bool
    ) -> None:
        """Record an arc; under cutter compensation beside it."""
        state = self.state
        if not state.arc_may_follow:
            raise BlockError(
                "VP026", "the move after the end of cutter compensation (G40) must be straight, not an arc"
            )
        target, feed = end, state.feed
        if state.compensation is not None:
            self._check_compensated(start, end)
            programmed = arc
            target, arc = state.compensation.offset_arc(self.recorder, start, end, arc, state.feed)
            feed *= self._arc_feed_share(state.compensation.length_ratio(start, end, programmed))
        elif state.feed_mode == FeedMode.INVERSE:  # which compensation refuses
            feed *= arc_length(arc, start, end)
        self.recorder.add(state, line, MoveKind.ARC, target, feed, arc)
        if state.compensation is not None:
            state.compensation.settle(self.recorder.count - 1, line, end)
            state.centre = target
        self._arrive(end, axes, absolute=absolute)

    def _arc_feed_share(self, on_contour: float) -> float:
        """Feed rate of the tool's centre over F on an arc, by the rule in force; ``on_contour`` keeps F on the contour."""
        share = self.state.arc_feed.share(on_contour)
        self.recorder.note_arc_feed(self.state.arc_feed, share)
        return share

    # --- cutter compensation ------------------------------------------------------------------------

    def _compensate(self, block: Block, code: int) -> None:
        """G40, G41, G42, G41.1, G42.1; a negative diameter (G41.1, G42.1) changes the side."""
        state = self.state
        if code == 400:
            state.arc_may_follow = state.arc_may_follow and (
                state.compensation is None or state.compensation.segment is None
            )
            state.compensation = None
            return
        name = g_name(code)
        if state.compensation is not None:
            raise BlockError("VP017", f"{name} while cutter compensation is on; write G40 first")
        if state.plane == 2:
            raise BlockError("VP017", f"{name} in the YZ plane (G19); cutter compensation works in G17 and G18")
        if state.feed_mode == FeedMode.INVERSE:
            raise BlockError(
                "VP017", f"{name} under G93: beside the contour moves have other lengths; write G94 or G95"
            )
        if state.vectors or not self._is_tool_upright():
            raise BlockError("VP017", f"{name} while a tool axis ({self.axis_words}) holds")
        radius = 0.5 * self._cutter_diameter(block, code)
        state.compensation = Compensation(
            code,
            state.plane,
            radius if code < 420 else -radius,
            perpendicular=self.perpendicular_entry,
            at_once=self.begins_at_once,
        )

    def _is_tool_upright(self) -> bool:
        """True where no tool axis holds, or the one along Z of a tilted work plane (G53.1), in which the contour then lies."""
        state = self.state
        return state.tool_axis is None or (
            state.frame.feature is not None and state.plane == 0 and state.tool_axis == (0.0, 0.0, 1.0)
        )

    def _cutter_diameter(self, block: Block, code: int) -> float:
        state = self.state
        if code % 10:  # in the block
            if "D" not in block.words:
                raise BlockError("VP005", f"{g_name(code)} needs D, the diameter")
            return self._length(block.words["D"])
        number = (whole(block, "D") if "D" in block.words else 0) or state.loaded_tool or 0
        if number == 0:
            other = (
                f", or write {g_name(code + 1)} with the diameter (D0 for a path on the contour)"
                if self.diameter_codes
                else ""
            )
            raise BlockError("VP012", f"{g_name(code)} without D, and no tool is in the spindle; load one{other}")
        name = tool_text(number, state.tool_names)
        if state.tools is None or number not in state.tools:
            other = f", or use {g_name(code + 1)} D" if self.diameter_codes else ""
            text = f"the diameter of {name} is not known; give --tool-table FILE{other}"
            raise block.error("VP012", text, "D", name)
        if state.tools[number].diameter <= 0:
            raise block.error("VP012", f"{name} has no diameter in the tool table (D)", "D", name)
        return state.tools[number].diameter

    def _check_compensated(self, start: list[float], end: list[float]) -> None:
        turning = next((axis for axis in _ROTARY if start[axis] != end[axis]), None)
        if turning is not None:
            raise BlockError(
                "VP026", f"{AXES[turning]} turns under cutter compensation: the contour is plane; write G40 first"
            )

    def _check_tcp_off(self, start: list[float], end: list[float]) -> None:
        """Without tool-centre-point control other controls mean other places, but for an upright, unturned table."""
        coordinates, frame = self.setup.coordinates, self.state.frame
        for point in (start, end):
            machine = coordinates.to_machine(np.array(point), frame)
            if self.setup.machine and (abs(machine[_A]) > UPRIGHT_DEG or abs(machine[_C]) > UPRIGHT_DEG):
                raise BlockError(
                    "VP017", f"tool-centre-point control is off (user-defined code), and the table stands at A {machine[_A]:g}, "
                    f"C {machine[_C]:g}: this machine always controls the tool centre point; turn to A0 C0 before, or use machine coordinates",
                )  # fmt: skip
