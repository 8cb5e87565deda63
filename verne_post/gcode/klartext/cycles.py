"""Machining cycles of Klartext, 200 to 209, 240, 241: the moves of one hole. Heights along Z of the input."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.cycle_words import FMAX_VALUE
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.milling import CYCLES as MILLED
from verne_post.gcode.klartext.milling import KlartextMilling
from verne_post.gcode.klartext.threads import THREADS, KlartextThreads
from verne_post.gcode.klartext.vocabulary import Q
from verne_post.gcode.lengths import measure_helix
from verne_post.gcode.machining.elements import make_arc
from verne_post.gcode.machining.holes import MAX_PECKS, Thread, check_tapping, note_tapping, tap
from verne_post.gcode.machining.machining import MAX_DWELL_S, explain_tilted_tool, warn_of_long_dwell
from verne_post.gcode.machining.plane_geometry import Point
from verne_post.gcode.program_error import ProgramError, write_parameter

_Q = dict[int, float]
#: Q403 of cycle 209, as the control bounds it.
_MOST_FASTER: Final = 10.0
#: Q214: direction in which a boring tool leaves the wall.
_DIRECTIONS: Final[Mapping[float, Point]] = {
    0: (0.0, 0.0),
    1: (-1.0, 0.0),
    2: (0.0, -1.0),
    3: (1.0, 0.0),
    4: (0.0, 1.0),
}


class KlartextCycles:
    """Planes, and the moves of machining cycles."""

    def __init__(self, frames: KlartextFrames, contour: KlartextContour) -> None:
        self.frames = frames
        self.contour = contour
        self.core = frames.core
        self.state = frames.state
        self.recorder = frames.recorder
        self.waiting = frames.waiting
        self.milling = KlartextMilling(frames, contour)
        self.threads = KlartextThreads(self.milling)
        self.holes = 1
        self.pitch_line: int | None = None  #: As in :class:`Thread`.

    @contextmanager
    def expect_holes(self, count: int) -> Iterator[None]:
        """So many holes belong to one block: their pecks count together."""
        self.holes = count
        try:
            yield
        finally:
            self.holes = 1

    def run_cycle(self, number: int, q: _Q) -> None:
        """One hole, pocket or stud at the present place."""
        self.waiting.refuse("a cycle call")
        self.frames.refuse_beside(f"cycle {number}")
        self.core.require_known(self.frames.block, [0, 1], f"cycle {number}")
        self.core.frames.stand_at({2: self.frames.find_height(q[Q.SURFACE] + q[Q.CLEARANCE])})
        self._check_hole(number, q)
        with self.core.keep_feed(), self.state.follow_exactly():
            if number in HOLES and q.get(Q.DEPTH) == 0:  # the control makes no hole, and turns no spindle
                self._leave(q, self._start_height(q)[0])
            elif number in THREADS:
                self._mill_thread(number, q)
            elif number in HOLES:
                HOLES[number](self, q)
            else:
                self.milling.run(number, q)
        self.contour.last_rapid, self.contour.last_cut = True, 0

    def _check_hole(self, number: int, q: _Q) -> None:
        self.frames.check_upright(f"cycle {number}")
        if (tool := self.core.find_tilted_tool()) is not None:
            remedy = explain_tilted_tool(self.core, "PLANE ... TURN")
            does = "mills" if number in (208, *MILLED, *THREADS) else "drills"
            text = f"cycle {number} {does} along Z, but {tool}: it would be dragged sideways; {remedy}"
            raise ProgramError("VP017", text, edits=self.core.recorder.list_plane_edits())
        for name in (Q.CLEARANCE, Q.SECOND_CLEARANCE, Q.UPPER_STOP, Q.LOWER_STOP):
            if q.get(name, 0.0) < 0:
                raise ProgramError("VP007", f"Q{name}={q[name]:g}: a distance is not negative")
        for name in (Q.DWELL_ABOVE, Q.DWELL_BELOW, Q.BORE_DWELL):
            if not 0 <= q.get(name, 0.0) <= MAX_DWELL_S:
                raise ProgramError("VP007", f"Q{name}={q[name]:g}: a dwell lies between 0 and a day")
        for name in (Q.PLUNGE_FEED, Q.BORE_FEED) if number not in MILLED else ():
            if not 0 < q.get(name, 1.0) < FMAX_VALUE:
                raise ProgramError(
                    "VP009", f"Q{name}={q[name]:g}: the tool cuts at this feed rate; it is greater than 0, and not FMAX"
                )
        for name in (Q.RETRACT_FEED, Q.POSITIONING_FEED):
            if q.get(name, 0.0) < 0:
                raise ProgramError("VP007", f"Q{name}={q[name]:g}: a feed rate is not negative")
        if q.get(Q.DEPTH_OF_SHANK):
            raise ProgramError("VP002", "Q395=1 is not executed: the angle of the tool's point is not known")
        if q.get(Q.DEPTH, -1.0) > 0:
            depth = q[Q.DEPTH]
            edits = write_parameter(Q.DEPTH, depth, -depth)
            text = f"Q201={depth:g}: a depth is negative, below Q203; write Q201={-depth:.15g}"
            raise ProgramError("VP007", text, edits=edits)

    # --- moves in heights of the input system --------------------------------------------------------------

    def go_to_height(self, height: float, feed: float) -> None:
        """Along Z; a feed rate of 0 or MAX is rapid traverse."""
        rapid = not 0 < feed < FMAX_VALUE
        end = list(self.state.position)
        end[2] = self.frames.find_height(height)
        self.contour.go_straight(end, rapid, feed)

    def _start_height(self, q: _Q) -> tuple[float, float]:
        """Rapid to the set-up clearance over the surface; returns it and the height of the surface."""
        surface = q[Q.SURFACE]
        clear = surface + q[Q.CLEARANCE]
        self.go_to_height(clear, 0.0)
        return clear, surface

    def _leave(self, q: _Q, clear: float) -> None:
        """To the second set-up clearance, where it lies higher."""
        second = q[Q.SURFACE] + q[Q.SECOND_CLEARANCE]
        if second > clear:
            self.go_to_height(second, 0.0)

    def _wait(self, seconds: float) -> None:
        if seconds:
            self.core.dwell(self.frames.block, seconds)
            warn_of_long_dwell(self.core, self.frames.block.line, seconds)

    def _check_pecks(self, depth: float, step: float) -> None:
        if step <= 0:
            raise ProgramError("VP007", f"Q202={step:g}: a plunging depth is greater than 0")
        if self.holes * depth / step > MAX_PECKS:
            raise ProgramError("VP007", f"more than {MAX_PECKS} pecks in the holes of one block")

    # --- cycles ------------------------------------------------------------------------------------------------

    def _drill(self, q: _Q) -> None:
        """200: pecks with full retract in rapid traverse."""
        self._drill_universal({**q, Q.RETRACT_FEED: FMAX_VALUE, Q.BREAKS: 0.0, Q.DECREMENT: 0.0})

    def _ream(self, q: _Q) -> None:
        """201: back at Q208, or at Q206 where that is 0."""
        clear, surface = self._start_height(q)
        self._finish_hole(q, clear, surface + q[Q.DEPTH])

    def _bore(self, q: _Q) -> None:
        """202: orients the spindle at the bottom and leaves the wall by Q357, where Q214 says to which side."""
        direction = _DIRECTIONS.get(q[Q.DIRECTION])
        if direction is None:
            raise ProgramError("VP007", f"Q214={q[Q.DIRECTION]:g}: directions are 0 to 4")
        self._need_spindle(202)
        clear, surface = self._start_height(q)
        self.go_to_height(surface + q[Q.DEPTH], q[Q.PLUNGE_FEED])
        self._wait(q[Q.DWELL_BELOW])
        backwards = self.state.spindle_reversed
        self._stop_oriented(q[Q.SPINDLE_ANGLE])
        hole = list(self.state.position)
        self._leave_wall(hole, direction, q[Q.SIDE_CLEARANCE])
        self.go_to_height(clear, q[Q.RETRACT_FEED] or q[Q.PLUNGE_FEED])
        self._leave(q, clear)
        back = list(self.state.position)
        back[:2] = hole[:2]
        if any(direction):
            self.contour.go_straight(back, rapid=True)
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=backwards)

    def _leave_wall(self, hole: list[float], direction: tuple[float, float], distance: float) -> None:
        if any(direction):
            end = list(self.state.position)
            for axis in (0, 1):
                end[axis] = hole[axis] + direction[axis] * distance * float(
                    self.frames.factors[axis]
                ) * self.frames.convert_length(1.0)
            self.contour.go_straight(end, rapid=True)

    def _need_spindle(self, number: int) -> None:
        if not (self.state.spindle_on and self.state.spindle_speed > 0):
            raise ProgramError("VP017", f"cycle {number} needs a turning spindle; give S and M3 first")

    def _stop_oriented(self, angle: float) -> None:
        self.core.auxiliary.switch_spindle(self.frames.block, on=False)
        self.recorder.record_event(self.frames.block.line, "orient", angle=angle)

    def _drill_universal(self, q: _Q) -> None:
        """203: chip breaks by Q256, a full retract after Q213 of them, plunges that get smaller by Q212."""
        clear, surface = self._start_height(q)
        bottom, step, depth, breaks = surface + q[Q.DEPTH], q[Q.INFEED], surface, 0
        self._check_pecks(
            -q[Q.DEPTH], min(step, q[Q.SMALLEST_INFEED]) if q[Q.DECREMENT] and q[Q.SMALLEST_INFEED] > 0 else step
        )
        while depth - step > bottom + ZERO_LENGTH_MM:
            depth -= step
            self.go_to_height(depth, q[Q.PLUNGE_FEED])
            if breaks < q[Q.BREAKS]:
                breaks += 1
                self.go_to_height(depth + q[Q.CHIP_RETRACT], 0.0)
            else:
                breaks = 0
                self.go_to_height(clear, q[Q.RETRACT_FEED] or q[Q.PLUNGE_FEED])
                self._wait(q[Q.DWELL_ABOVE])
                self.go_to_height(depth + q[Q.CLEARANCE], 0.0)
            step = _shorten_step(q, step)
        self._finish_hole(q, clear, bottom)

    def _finish_hole(self, q: _Q, clear: float, bottom: float) -> None:
        """To the bottom, wait there, and out."""
        self.go_to_height(bottom, q[Q.PLUNGE_FEED])
        self._wait(q[Q.DWELL_BELOW])
        self.go_to_height(clear, q[Q.RETRACT_FEED] or q[Q.PLUNGE_FEED])
        self._leave(q, clear)

    def _bore_back(self, q: _Q) -> None:
        """204: a counterbore from below."""
        direction = _DIRECTIONS.get(q[Q.DIRECTION])
        if direction is None or not any(direction):
            raise ProgramError("VP007", f"Q214={q[Q.DIRECTION]:g}: cycle 204 needs a direction, 1 to 4")
        self._need_spindle(204)
        clear, surface = self._start_height(q)
        below = surface - q[Q.THICKNESS]
        hole, backwards = list(self.state.position), self.state.spindle_reversed
        self._stop_oriented(q[Q.SPINDLE_ANGLE])
        self._leave_wall(hole, direction, q[Q.OFFSET])
        self.go_to_height(below - q[Q.CLEARANCE] - q[Q.EDGE_HEIGHT], q[Q.POSITIONING_FEED])
        centre = [*hole[:2], *self.state.position[2:]]
        self.contour.go_straight(centre, rapid=False, feed=q[Q.POSITIONING_FEED])
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=backwards)
        self.go_to_height(below + q[Q.BORE_DEPTH] - q[Q.EDGE_HEIGHT], q[Q.BORE_FEED])
        self._wait(q[Q.BORE_DWELL])
        self.go_to_height(below - q[Q.CLEARANCE] - q[Q.EDGE_HEIGHT], q[Q.POSITIONING_FEED])
        self._stop_oriented(q[Q.SPINDLE_ANGLE])
        self._leave_wall(hole, direction, q[Q.OFFSET])
        self.go_to_height(clear, q[Q.POSITIONING_FEED])
        self._leave(q, clear)
        self.contour.go_straight([*hole[:2], *self.state.position[2:]], rapid=True)
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=backwards)

    def _drill_universal_pecks(self, q: _Q) -> None:
        """Drill cycle 205: pecks of Q202, chip breaks of Q257, stop distances Q258 to Q259, deeper start Q379."""
        clear, surface = self._start_height(q)
        bottom = surface + q[Q.DEPTH]
        depth = surface - abs(q[Q.START_DEPTH])
        if depth < surface:
            self.go_to_height(depth + q[Q.CLEARANCE], q[Q.POSITIONING_FEED])
        self._drill_down(q, clear, depth)
        self._finish_hole(q, clear, bottom)

    def _drill_down(self, q: _Q, clear: float, depth: float) -> None:
        """The pecks of 205 and 264, from a depth to the bottom."""
        bottom = q[Q.SURFACE] + q[Q.DEPTH]
        step, total = q[Q.INFEED], max(depth - bottom, 0.0)
        if total > 0:
            smallest = max(q[Q.SMALLEST_INFEED], 0.0) if q[Q.DECREMENT] else step
            self._check_pecks(total, min(step, smallest, q[Q.CHIP_DEPTH] or step) or step)
            count = max(math.ceil(total / step) - 1, 1)
            peck_count = 0
            while depth - step > bottom + ZERO_LENGTH_MM:
                self._break_chips(q, depth, depth - step)
                depth -= step
                self.go_to_height(depth, q[Q.PLUNGE_FEED])
                stop = q[Q.UPPER_STOP] + (q[Q.LOWER_STOP] - q[Q.UPPER_STOP]) * min(peck_count / count, 1.0)
                self.go_to_height(clear, q[Q.RETRACT_FEED] or q[Q.PLUNGE_FEED])
                self.go_to_height(depth + stop, 0.0)
                peck_count += 1
                step = _shorten_step(q, step)
            self._break_chips(q, depth, bottom)

    def _break_chips(self, q: _Q, depth: float, end: float) -> None:
        """Drill from a depth towards its end, and break the chip each Q257 before it by going up Q256."""
        while q[Q.CHIP_DEPTH] > 0 and depth - q[Q.CHIP_DEPTH] > end + ZERO_LENGTH_MM:
            depth -= q[Q.CHIP_DEPTH]
            self.go_to_height(depth, q[Q.PLUNGE_FEED])
            self.go_to_height(depth + q[Q.CHIP_RETRACT], 0.0)

    def _tap(self, q: _Q) -> None:
        """206: with a floating tap holder; the spindle turns back at the bottom."""
        self._need_spindle(206)
        feed = self.contour.read_feed_word(q[Q.PLUNGE_FEED])
        note_tapping(self.core, self.frames.block, feed / self.state.spindle_speed, self.pitch_line)
        clear, surface = self._start_height(q)
        backwards = self.state.spindle_reversed
        self.go_to_height(surface + q[Q.DEPTH], q[Q.PLUNGE_FEED])
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=not backwards)
        self._wait(q[Q.DWELL_BELOW])
        self.go_to_height(clear, q[Q.PLUNGE_FEED])
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=backwards)
        self._leave(q, clear)

    def _tap_rigidly(self, q: _Q) -> None:
        """207 and 209: pitch Q239, left-hand below 0.

        209 breaks the chip each Q257, back by Q256 pitches or out of the hole, and goes out Q403 times as fast.
        """
        check_tapping(self.core)
        speed, pitch = self.state.spindle_speed, q[Q.PITCH]
        bottom, step = q[Q.SURFACE] + q[Q.DEPTH], q.get(Q.CHIP_DEPTH, 0.0)
        if not pitch:
            raise ProgramError("VP007", "Q239=0: a thread has a pitch; write its mm a turn, below 0 for left-hand")
        for name in (Q.CHIP_DEPTH, Q.CHIP_RETRACT):
            if q.get(name, 0.0) < 0:
                raise ProgramError("VP007", f"Q{name}={q[name]:g}: it is not negative; write {-q[name]:g}")
        if not 0 < (factor := q.get(Q.RETRACT_FACTOR, 1.0)) <= _MOST_FASTER:
            raise ProgramError("VP007", f"Q403={factor:g}: the tap goes out up to {_MOST_FASTER:g} times as fast")
        if not speed:
            raise ProgramError("VP007", "rigid tapping needs the speed of the spindle; write S in TOOL CALL")
        clear, surface = self._start_height(q)
        before = self.state.spindle_on, self.state.spindle_reversed
        places, depth = list[float](), surface - step
        if step:
            self._check_pecks(-q[Q.DEPTH], step)
        while step and depth > bottom + ZERO_LENGTH_MM:
            places += [depth, min(depth + q[Q.CHIP_RETRACT] * abs(pitch), clear) if q[Q.CHIP_RETRACT] else clear]
            depth -= step
        if Q.SPINDLE_ANGLE in q:
            self._stop_oriented(q[Q.SPINDLE_ANGLE])
        speeds = speed, speed * factor
        thread = Thread(abs(pitch) * self.frames.unit, pitch < 0, *speeds, line=self.pitch_line)
        tap(self.core, self.frames.block, thread, (*places, bottom, clear), self._go_at_feed, before)
        self._leave(q, clear)

    def _go_at_feed(self, height: float) -> None:
        """Along Z at the feed rate in force."""
        end = list(self.state.position)
        end[2] = self.frames.find_height(height)
        self.contour.go_straight(end, rapid=False)

    def _mill_bore(self, q: _Q) -> None:
        """208: a helix to the depth, one full circle there, back to the centre."""
        if q[Q.CLIMB] not in (1.0, -1.0):
            raise ProgramError("VP007", f"Q351={q[Q.CLIMB]:g}: 1 for climb milling, -1 for up-cut")
        bore = 0.5 * q[Q.HOLE_DIAMETER] * self.frames.unit
        radius = bore - self.contour.find_tool_radius()
        if radius <= ZERO_LENGTH_MM or q[Q.HELIX_PITCH] <= 0 or q[Q.OVERLAP]:
            text = "cycle 208 needs a hole wider than the tool, an infeed Q334 greater than 0, and Q370=0"
            raise ProgramError("VP007", text)
        clear, surface = self._start_height(q)
        self._check_pecks(-q[Q.DEPTH], q[Q.HELIX_PITCH])
        hole = (self.state.position[0], self.state.position[1])
        sense = int(q[Q.CLIMB]) * (-1 if self.frames.flips else 1)
        wall = (hole[0] + radius, hole[1])
        self._go_on_arc(wall, (hole[0] + 0.5 * radius, hole[1]), sense * 180.0, clear, q[Q.PLUNGE_FEED])
        depth, bottom = clear, surface + q[Q.DEPTH]
        turns = math.ceil((depth - bottom) / q[Q.HELIX_PITCH] - 1e-9)
        for turn in range(turns):
            self._go_on_arc(
                wall, hole, sense * 360.0, clear + (bottom - clear) * (turn + 1) / turns, q[Q.PLUNGE_FEED], bore
            )
        self._go_on_arc(wall, hole, sense * 360.0, bottom, q[Q.PLUNGE_FEED], bore)
        self._go_on_arc(hole, (hole[0] + 0.5 * radius, hole[1]), sense * 180.0, bottom, q[Q.PLUNGE_FEED])
        self.go_to_height(clear, 0.0)
        self._leave(q, clear)

    def _mill_thread(self, number: int, q: _Q) -> None:
        """262 to 265 and 267; 264 drills the hole before, and goes on from its bottom."""
        strokes, feeds = self.threads.plan(number, q, self.holes)
        hole = (self.state.position[0], self.state.position[1])
        clear, surface = self._start_height(q)
        if number == 264:
            drilled_hole = {Q.DEPTH: q[Q.SINKING_DEPTH], Q.LOWER_STOP: q[Q.UPPER_STOP], Q.DECREMENT: 0.0}
            self._drill_down({**q, **drilled_hole, Q.RETRACT_FEED: FMAX_VALUE}, clear, surface)
            self.go_to_height(surface + q[Q.SINKING_DEPTH], q[Q.PLUNGE_FEED])
        for stroke in strokes:
            self.milling.follow_stroke(stroke, feeds)
        self.go_to_height(clear, 0.0)
        self._leave(q, clear)
        if math.dist(hole, self.state.position[:2]) > ZERO_LENGTH_MM:
            self.contour.go_straight([*hole, *self.state.position[2:]], rapid=True)

    def _go_on_arc(
        self, place: Point, center: Point, sweep: float, height: float, feed: float, bore: float | None = None
    ) -> None:
        """A helix to a place at an input height; ``bore`` is the radius (mm) of the wall that it cuts, if any."""
        self.contour.set_cycle_feed(feed)
        start = list(self.state.position)
        end = [place[0], place[1], self.frames.find_height(height), *start[3:]]
        if bore is not None:
            lengths = [measure_helix(radius, sweep, end[2] - start[2]) for radius in (math.dist(place, center), bore)]
            self.core.set_feed(self.state.feed * self.core.find_arc_feed_share(lengths[0] / lengths[1]))
        self.core.go_on_arc(self.frames.block, start, end, make_arc(start, 0, center, sweep), [0, 1, 2])

    def _drill_single_lip(self, q: _Q) -> None:
        """241: into the pilot hole at the speed Q427, to the depth at Q428 with coolant, and out as it came in."""
        if q[Q.DWELL_DEPTH]:
            edits = write_parameter(Q.DWELL_DEPTH, q[Q.DWELL_DEPTH], 0.0)
            raise ProgramError("VP002", "Q435 is not executed: the dwell is at the bottom; write Q435=0", edits=edits)
        if q[Q.INFEED] > 0 and q[Q.INFEED] < -q[Q.DEPTH]:
            raise ProgramError(
                "VP002", "Q202 is not executed in cycle 241 where it is less than the depth; write cycle 205 for pecks"
            )
        turning = {3.0: False, 4.0: True, 5.0: None}.get(q[Q.ENTRY_SENSE])
        if (
            q[Q.ENTRY_SENSE] not in (3.0, 4.0, 5.0)
            or q[Q.COOLANT_IN] not in (7.0, 8.0, 9.0)
            or q[Q.COOLANT_OUT] not in (7.0, 8.0, 9.0)
        ):
            raise ProgramError("VP007", "cycle 241: Q426 is 3, 4 or 5, Q429 and Q430 are 7, 8 or 9")
        if q[Q.ENTRY_SPEED] < 0 or q[Q.DRILLING_SPEED] <= 0:
            raise ProgramError("VP007", "cycle 241: the speed Q427 is not negative, and Q428 is greater than 0")
        auxiliary, at = self.core.auxiliary, self.frames.block
        clear, surface = self._start_height(q)
        auxiliary.set_speed(at, q[Q.ENTRY_SPEED], is_switched=True)
        auxiliary.switch_spindle(at, on=turning is not None, backwards=bool(turning))
        if q[Q.START_DEPTH]:
            self.go_to_height(surface - abs(q[Q.START_DEPTH]) + q[Q.CLEARANCE], q[Q.POSITIONING_FEED])
        auxiliary.set_speed(at, q[Q.DRILLING_SPEED], is_switched=True)
        auxiliary.switch_spindle(at, on=True)
        auxiliary.switch_coolant(at, round(q[Q.COOLANT_IN]))
        self.go_to_height(surface + q[Q.DEPTH], q[Q.PLUNGE_FEED])
        self._wait(q[Q.DWELL_BELOW])
        auxiliary.switch_coolant(at, round(q[Q.COOLANT_OUT]))
        auxiliary.set_speed(at, q[Q.ENTRY_SPEED], is_switched=True)
        auxiliary.switch_spindle(at, on=turning is not None, backwards=bool(turning))
        self.go_to_height(clear, q[Q.RETRACT_FEED] or q[Q.PLUNGE_FEED])
        self._leave(q, clear)

    def _drill_center(self, q: _Q) -> None:
        """240: centring to a depth."""
        if q[Q.BY_DIAMETER]:
            raise ProgramError(
                "VP002",
                "cycle 240 with Q343=1 is not executed: the angle of the tool's point is not known; give the depth, "
                "Q343=0",
            )
        clear, surface = self._start_height(q)
        self._finish_hole({**q, Q.RETRACT_FEED: FMAX_VALUE}, clear, surface + q[Q.DEPTH])


#: Moves of each machining cycle.
HOLES: Final[Mapping[int, Callable[[KlartextCycles, _Q], None]]] = {
    200: KlartextCycles._drill, 201: KlartextCycles._ream, 202: KlartextCycles._bore,
    203: KlartextCycles._drill_universal,
    204: KlartextCycles._bore_back, 205: KlartextCycles._drill_universal_pecks, 206: KlartextCycles._tap,
    207: KlartextCycles._tap_rigidly, 208: KlartextCycles._mill_bore, 209: KlartextCycles._tap_rigidly,
    240: KlartextCycles._drill_center,
    241: KlartextCycles._drill_single_lip,
}  # fmt: skip


def _shorten_step(q: _Q, step: float) -> float:
    """The plunging depth after one: smaller by Q212, no smaller than Q205."""
    if not q[Q.DECREMENT]:
        return step
    smaller = max(step - q[Q.DECREMENT], q[Q.SMALLEST_INFEED])
    if smaller <= ZERO_LENGTH_MM:
        raise ProgramError(
            "VP007",
            f"Q212={q[Q.DECREMENT]:g}: no plunging depth is left before the hole is done; give Q205, the smallest one",
        )
    return smaller
