"""Machining cycles of Klartext, 200 to 209, 240, 241 and 262: the moves of one hole. Heights along Z of the input system."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.cycle_words import FMAX_VALUE
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.milling import KlartextMilling
from verne_post.gcode.lengths import measure_helix
from verne_post.gcode.machining.elements import Point, make_arc
from verne_post.gcode.machining.holes import MAX_PECKS, Thread, check_tapping, note_tapping, tap
from verne_post.gcode.machining.machining import MAX_DWELL_S
from verne_post.gcode.program_error import ProgramError
from verne_post.model.moves import MoveKind

_Q = dict[int, float]
#: Q403 of cycle 209, as the control bounds it.
_MOST_FASTER: Final = 10.0
#: Q214: direction in which a boring tool leaves the wall.
_DIRECTIONS: Final = {0: (0.0, 0.0), 1: (-1.0, 0.0), 2: (0.0, -1.0), 3: (1.0, 0.0), 4: (0.0, 1.0)}


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
        self.holes = 1

    @contextmanager
    def expect_holes(self, count: int) -> Iterator[None]:
        """So many holes belong to one block: their pecks count together."""
        self.holes = count
        try:
            yield
        finally:
            self.holes = 1

    def run_cycle(self, number: int, q: _Q) -> None:
        """One hole, pocket or stud at the present place.

        Raises
        ------
        ProgramError
        """
        self.waiting.refuse("a cycle call")
        self.frames.refuse_beside(f"cycle {number}")
        self.core.require_known(self.frames.block, [0, 1], f"cycle {number}")
        self.core.frames.stand_at({2: self.find_height(q[203] + q[200])})
        self._check_hole(number, q)
        with self.core.keep_feed(), self.state.follow_exactly():
            if number in HOLES:
                HOLES[number](self, q)
            else:
                self.milling.run(number, q)
        self.contour.last_rapid = True

    def _check_hole(self, number: int, q: _Q) -> None:
        if (tool := self.core.find_tilted_tool()) is not None:
            raise ProgramError(
                "VP017", f"cycle {number} drills along Z, but {tool}: it would be dragged sideways; position the rotary axes first (PLANE ... MOVE or TURN)",
            )  # fmt: skip
        for name in (200, 204, 258, 259):
            if q.get(name, 0.0) < 0:
                raise ProgramError("VP007", f"Q{name}={q[name]:g}: a distance is not negative")
        for name in (210, 211, 255):
            if not 0 <= q.get(name, 0.0) <= MAX_DWELL_S:
                raise ProgramError("VP007", f"Q{name}={q[name]:g}: a dwell lies between 0 and a day")
        for name in (206, 254) if number in HOLES else ():
            if not 0 < q.get(name, 1.0) < FMAX_VALUE:
                raise ProgramError(
                    "VP009", f"Q{name}={q[name]:g}: the tool cuts at this feed rate; it is greater than 0, and not FMAX"
                )
        for name in (208, 253):
            if q.get(name, 0.0) < 0:
                raise ProgramError("VP007", f"Q{name}={q[name]:g}: a feed rate is not negative")
        if q.get(395):
            raise ProgramError("VP002", "Q395=1 is not executed: the angle of the tool's point is not known")
        if q.get(201, -1.0) > 0:
            raise ProgramError("VP007", f"Q201={q[201]:g}: a depth is negative, below Q203")

    # --- moves in heights of the input system --------------------------------------------------------------

    def find_height(self, height: float) -> float:
        """Input height as Z of the frame, mm."""
        return height * float(self.frames.factors[2]) * self.frames.length(1.0)

    def go_to_height(self, height: float, feed: float) -> None:
        """Along Z; a feed rate of 0 or MAX is rapid traverse."""
        rapid = not 0 < feed < FMAX_VALUE
        end = list(self.state.position)
        end[2] = self.find_height(height)
        self.go_straight(end, rapid, feed)

    def go_straight(self, end: list[float], rapid: bool, feed: float | None = None) -> None:
        """To a place of the frame; where no feed rate of a cycle is given, at the one in force."""
        kind = MoveKind.RAPID if rapid else MoveKind.FEED
        if not rapid:
            if feed is not None:
                self.core.set_feed(self.contour.read_feed_word(feed))
                self._change_feed_mode_to_minutes()
            self.contour.check_feed()
        self.core.start_of_motion(kind, absolute=True, machine=False)
        self.frames.run_line(self.frames.block, kind, end, [0, 1, 2])

    def _change_feed_mode_to_minutes(self) -> None:
        self.contour.change_feed_mode(type(self.state.feed_mode).PER_MINUTE)

    def _start_height(self, q: _Q) -> tuple[float, float]:
        """Rapid to the set-up clearance over the surface; returns it and the height of the surface."""
        surface = q[203]
        clear = surface + q[200]
        self.go_to_height(clear, 0.0)
        return clear, surface

    def _leave(self, q: _Q, clear: float) -> None:
        """To the second set-up clearance, where it lies higher."""
        second = q[203] + q[204]
        if second > clear:
            self.go_to_height(second, 0.0)

    def _wait(self, seconds: float) -> None:
        if seconds:
            self.core.dwell(self.frames.block, seconds)

    def _check_pecks(self, depth: float, step: float) -> None:
        if step <= 0:
            raise ProgramError("VP007", f"Q202={step:g}: a plunging depth is greater than 0")
        if self.holes * depth / step > MAX_PECKS:
            raise ProgramError("VP007", f"more than {MAX_PECKS} pecks in the holes of one block")

    # --- cycles ------------------------------------------------------------------------------------------------

    def _drill(self, q: _Q) -> None:
        """200: pecks with full retract."""
        clear, surface = self._start_height(q)
        bottom, step = surface + q[201], q[202]
        depth = surface
        if q[201] < 0:
            self._check_pecks(-q[201], step)
            while depth - step > bottom + ZERO_LENGTH_MM:
                depth -= step
                self.go_to_height(depth, q[206])
                self.go_to_height(clear, 0.0)
                self._wait(q[210])
                self.go_to_height(depth + q[200], 0.0)
        if q[201] != 0:
            self.go_to_height(bottom, q[206])
            self._wait(q[211])
        self.go_to_height(clear, 0.0)
        self._leave(q, clear)

    def _ream(self, q: _Q) -> None:
        """201: back at Q208, or at Q206 where that is 0."""
        clear, surface = self._start_height(q)
        if q[201] != 0:
            self._finish_hole(q, clear, surface + q[201])
        else:
            self._leave(q, clear)

    def _bore(self, q: _Q) -> None:
        """202: orients the spindle at the bottom and leaves the wall by Q357, where Q214 says to which side."""
        direction = _DIRECTIONS.get(int(q[214])) if q[214] == int(q[214]) else None
        if direction is None:
            raise ProgramError("VP007", f"Q214={q[214]:g}: directions are 0 to 4")
        self._need_spindle(202)
        clear, surface = self._start_height(q)
        self.go_to_height(surface + q[201], q[206])
        self._wait(q[211])
        backwards = self.state.spindle_reversed
        self._stop_oriented(q[336])
        hole = list(self.state.position)
        self._leave_wall(hole, direction, q[357])
        self.go_to_height(clear, q[208] or q[206])
        self._leave(q, clear)
        back = list(self.state.position)
        back[:2] = hole[:2]
        if any(direction):
            self.go_straight(back, rapid=True)
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=backwards)

    def _leave_wall(self, hole: list[float], direction: tuple[float, float], distance: float) -> None:
        if any(direction):
            end = list(self.state.position)
            for axis in (0, 1):
                end[axis] = hole[axis] + direction[axis] * distance * float(
                    self.frames.factors[axis]
                ) * self.frames.length(1.0)
            self.go_straight(end, rapid=True)

    def _need_spindle(self, number: int) -> None:
        if not (self.state.spindle_on and self.state.spindle_speed > 0):
            raise ProgramError("VP017", f"cycle {number} needs a turning spindle; give S and M3 first")

    def _stop_oriented(self, angle: float) -> None:
        self.core.auxiliary.switch_spindle(self.frames.block, on=False)
        self.recorder.event(self.frames.block.line, "orient", angle=angle)

    def _drill_universal(self, q: _Q) -> None:
        """203: chip breaks by Q256, a full retract after Q213 of them, plunges that get smaller by Q212."""
        clear, surface = self._start_height(q)
        bottom, step, depth, breaks = surface + q[201], q[202], surface, 0
        if q[201] < 0:
            self._check_pecks(-q[201], min(step, q[205]) if q[212] and q[205] > 0 else step)
            while depth - step > bottom + ZERO_LENGTH_MM:
                depth -= step
                self.go_to_height(depth, q[206])
                if breaks < q[213]:
                    breaks += 1
                    self.go_to_height(depth + q[256], 0.0)
                else:
                    breaks = 0
                    self.go_to_height(clear, q[208] or q[206])
                    self._wait(q[210])
                    self.go_to_height(depth + q[200], 0.0)
                step = _shorten_step(q, step)
        self._finish_hole(q, clear, bottom)

    def _finish_hole(self, q: _Q, clear: float, bottom: float) -> None:
        """To the bottom, where the depth is not zero, wait there, and out."""
        if q[201] != 0:
            self.go_to_height(bottom, q[206])
            self._wait(q[211])
        self.go_to_height(clear, q[208] or q[206])
        self._leave(q, clear)

    def _bore_back(self, q: _Q) -> None:
        """204: a counterbore from below."""
        direction = _DIRECTIONS.get(int(q[214])) if q[214] == int(q[214]) else None
        if direction is None or not any(direction):
            raise ProgramError("VP007", f"Q214={q[214]:g}: cycle 204 needs a direction, 1 to 4")
        self._need_spindle(204)
        clear, surface = self._start_height(q)
        below = surface - q[250]
        hole, backwards = list(self.state.position), self.state.spindle_reversed
        self._stop_oriented(q[336])
        self._leave_wall(hole, direction, q[251])
        self.go_to_height(below - q[200] - q[252], q[253])
        centre = [*hole[:2], *self.state.position[2:]]
        self.go_straight(centre, rapid=False, feed=q[253])
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=backwards)
        self.go_to_height(below + q[249] - q[252], q[254])
        self._wait(q[255])
        self.go_to_height(below - q[200] - q[252], q[253])
        self._stop_oriented(q[336])
        self._leave_wall(hole, direction, q[251])
        self.go_to_height(clear, q[253])
        self._leave(q, clear)
        self.go_straight([*hole[:2], *self.state.position[2:]], rapid=True)
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=backwards)

    def _drill_universal_pecks(self, q: _Q) -> None:
        """205: pecks to full retracts each Q202, chip breaks each Q257 between them, stop distances Q258 to Q259, a deeper start Q379."""
        clear, surface = self._start_height(q)
        bottom = surface + q[201]
        depth = surface - abs(q[379])
        if depth < surface:
            self.go_to_height(depth + q[200], q[253])
        step, total = q[202], max(depth - bottom, 0.0)
        if total > 0:
            smallest = max(q[205], 0.0) if q[212] else step
            self._check_pecks(total, min(step, smallest, q[257] or step) or step)
            count = max(math.ceil(total / step) - 1, 1)
            done = 0
            while depth - step > bottom + ZERO_LENGTH_MM:
                self._break_chips(q, depth, depth - step)
                depth -= step
                self.go_to_height(depth, q[206])
                stop = q[258] + (q[259] - q[258]) * min(done / count, 1.0)
                self.go_to_height(clear, q[208] or q[206])
                self.go_to_height(depth + stop, 0.0)
                done += 1
                step = _shorten_step(q, step)
            self._break_chips(q, depth, bottom)
        self._finish_hole(q, clear, bottom)

    def _break_chips(self, q: _Q, depth: float, end: float) -> None:
        """Drill from a depth towards its end, and break the chip each Q257 before it by going up Q256."""
        while q[257] > 0 and depth - q[257] > end + ZERO_LENGTH_MM:
            depth -= q[257]
            self.go_to_height(depth, q[206])
            self.go_to_height(depth + q[256], 0.0)

    def _tap(self, q: _Q) -> None:
        """206: with a floating tap holder; the spindle turns back at the bottom."""
        self._need_spindle(206)
        note_tapping(self.core, self.frames.block)
        clear, surface = self._start_height(q)
        backwards = self.state.spindle_reversed
        self.go_to_height(surface + q[201], q[206])
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=not backwards)
        self._wait(q[211])
        self.go_to_height(clear, q[206])
        self.core.auxiliary.switch_spindle(self.frames.block, on=True, backwards=backwards)
        self._leave(q, clear)

    def _tap_rigidly(self, q: _Q) -> None:
        """207 and 209: pitch Q239 (left-hand below 0); 209 breaks the chip each Q257, back by Q256 pitches or out of the hole, and
        goes out Q403 times as fast.
        """
        check_tapping(self.core)
        speed, pitch, bottom, step = self.state.spindle_speed, q[239], q[203] + q[201], q.get(257, 0.0)
        if not speed or not pitch or step < 0 or q.get(256, 0.0) < 0 or not 0 < q.get(403, 1.0) <= _MOST_FASTER:
            raise ProgramError(
                "VP007",
                f"rigid tapping needs the speed S, Q239 other than 0, Q257 and Q256 not below 0, and Q403 up to {_MOST_FASTER}",
            )
        clear, surface = self._start_height(q)
        before = self.state.spindle_on, self.state.spindle_reversed
        places, depth = list[float](), surface - step
        if step:
            self._check_pecks(-q[201], step)
        while step and depth > bottom + ZERO_LENGTH_MM:
            places += [depth, min(depth + q[256] * abs(pitch), clear) if q[256] else clear]
            depth -= step
        if 336 in q:
            self._stop_oriented(q[336])
        thread = Thread(abs(pitch) * self.frames.unit, pitch < 0, speed, speed * q.get(403, 1.0))
        if q[201] != 0:
            tap(self.core, self.frames.block, thread, (*places, bottom, clear), self._go_at_feed, before)
        self._leave(q, clear)

    def _go_at_feed(self, height: float) -> None:
        """Along Z at the feed rate in force."""
        end = list(self.state.position)
        end[2] = self.find_height(height)
        self.go_straight(end, rapid=False)

    def _mill_bore(self, q: _Q) -> None:
        """208: a helix to the depth, one full circle there, back to the centre."""
        if q[351] not in (1.0, -1.0):
            raise ProgramError("VP007", f"Q351={q[351]:g}: 1 for climb milling, -1 for up-cut")
        bore = 0.5 * q[335] * self.frames.unit
        radius = bore - self.contour.tool_radius()
        if radius <= ZERO_LENGTH_MM or q[334] <= 0 or q[370]:
            raise ProgramError(
                "VP007", "cycle 208 needs a hole wider than the tool, an infeed Q334 greater than 0, and Q370=0"
            )
        clear, surface = self._start_height(q)
        self._check_pecks(-q[201], q[334])
        hole = (self.state.position[0], self.state.position[1])
        sense = int(q[351]) * (-1 if self.frames.flips else 1)
        wall = (hole[0] + radius, hole[1])
        self._arc(wall, (hole[0] + 0.5 * radius, hole[1]), sense * 180.0, clear, q[206])
        depth, bottom = clear, surface + q[201]
        turns = math.ceil((depth - bottom) / q[334] - 1e-9)
        for turn in range(turns):
            self._arc(wall, hole, sense * 360.0, clear + (bottom - clear) * (turn + 1) / turns, q[206], bore)
        self._arc(wall, hole, sense * 360.0, bottom, q[206], bore)
        self._arc(hole, (hole[0] + 0.5 * radius, hole[1]), sense * 180.0, bottom, q[206])
        self.go_to_height(clear, 0.0)
        self._leave(q, clear)

    def _mill_thread(self, q: _Q) -> None:
        """262: helices of the pitch Q239 on the diameter Q335, each from and to the middle of the hole on half circles.

        A helix goes on at its pitch on both half circles, so the tool goes down by half a pitch more before the first, as manuals
        warn. Q355: 0 one turn at the depth, 1 the whole depth in one helix, else one turn each Q355 pitches.
        """
        pitch, count = abs(q[239]), q[355]
        if not pitch or q[351] not in (1.0, -1.0) or count < 0 or count != round(count):
            raise ProgramError(
                "VP007",
                "cycle 262 needs a pitch Q239 other than 0, Q351 1 for climb milling or -1 for up-cut, and Q355 whole and not negative",
            )
        for name in (207, 512):
            if not 0 < (q[name] or q[207]) < FMAX_VALUE:
                raise ProgramError("VP009", f"Q{name}={q[name]:g}: the tool cuts at this feed rate; it is greater than 0, and not FMAX")  # fmt: skip
        wall = 0.5 * q[335] * self.frames.unit
        radius = wall - self.contour.tool_radius()
        if radius <= ZERO_LENGTH_MM:
            raise ProgramError("VP007", f"cycle 262: Q335={q[335]:g}: the tool has no room in the thread")
        clear, surface = self._start_height(q)
        depth, step = -q[201], pitch * (count if count > 1 else 1)
        turns = depth / pitch if count == 1 else 1.0
        starts = [surface + q[201]]
        if count > 1:
            self._check_pecks(depth, step)
            starts += [starts[0] + step * number for number in range(1, math.ceil(depth / step - 1e-9))]
        if depth * self.holes > MAX_PECKS * pitch:
            raise ProgramError("VP007", f"more than {MAX_PECKS} turns in the holes of one block")
        climb = round(q[351]) * (-1 if self.state.spindle_reversed else 1)
        rises = (climb > 0) == (q[239] > 0)
        sense = climb * (-1 if self.frames.flips else 1)
        hole, lead = (self.state.position[0], self.state.position[1]), pitch if rises else -pitch
        for bottom in starts if rises else reversed(starts) if depth else ():
            height = bottom if rises else bottom + turns * pitch
            self._turn_in_thread(q, hole, radius, wall, sense, lead, height, turns)
        self.go_to_height(clear, 0.0)
        self._leave(q, clear)

    def _turn_in_thread(
        self, q: _Q, hole: Point, radius: float, wall: float, sense: int, lead: float, height: float, turns: float
    ) -> None:
        """One helix from a height on, with both half circles; ``lead`` is what it rises in a turn."""
        begin = hole[0] + radius, hole[1]
        self.go_to_height(height - 0.5 * lead, q[253])
        self._arc(begin, (hole[0] + 0.5 * radius, hole[1]), sense * 180.0, height, q[512] or q[207])
        whole, rest = divmod(turns, 1.0)
        for number in range(round(whole)):
            self._arc(begin, hole, sense * 360.0, height + lead * (number + 1), q[207], wall)
        angle = math.radians(sense * 360.0 * rest)
        end = hole[0] + radius * math.cos(angle), hole[1] + radius * math.sin(angle)
        last = height + lead * turns
        if radius * abs(angle) > ZERO_LENGTH_MM:
            self._arc(end, hole, math.degrees(angle), last, q[207], wall)
        middle = 0.5 * (hole[0] + end[0]), 0.5 * (hole[1] + end[1])
        self._arc(hole, middle, sense * 180.0, last + 0.5 * lead, q[207])

    def _arc(
        self, place: Point, center: Point, sweep: float, height: float, feed: float, bore: float | None = None
    ) -> None:
        """A helix to a place at an input height; ``bore`` is the radius (mm) of the wall that it cuts, where it cuts one."""
        self.core.set_feed(self.contour.read_feed_word(feed))
        self._change_feed_mode_to_minutes()
        self.contour.check_feed()
        start = list(self.state.position)
        end = [place[0], place[1], self.find_height(height), *start[3:]]
        if bore is not None:
            lengths = [measure_helix(radius, sweep, end[2] - start[2]) for radius in (math.dist(place, center), bore)]
            self.core.set_feed(self.state.feed * self.core.find_arc_feed_share(lengths[0] / lengths[1]))
        self.core.arc(self.frames.block, start, end, make_arc(start, 0, center, sweep), [0, 1, 2])

    def _drill_single_lip(self, q: _Q) -> None:
        """241: into the pilot hole at the speed Q427, to the depth at Q428 with coolant, and out as it came in."""
        if q[435]:
            raise ProgramError("VP002", "Q435 is not executed: the dwell is at the bottom; write Q435=0")
        if q[202] > 0 and q[202] < -q[201]:
            raise ProgramError(
                "VP002", "Q202 is not executed in cycle 241 where it is less than the depth; write cycle 205 for pecks"
            )
        turning = {3.0: False, 4.0: True, 5.0: None}.get(q[426])
        if q[426] not in (3.0, 4.0, 5.0) or q[429] not in (7.0, 8.0, 9.0) or q[430] not in (7.0, 8.0, 9.0):
            raise ProgramError("VP007", "cycle 241: Q426 is 3, 4 or 5, Q429 and Q430 are 7, 8 or 9")
        if q[427] < 0 or q[428] <= 0:
            raise ProgramError("VP007", "cycle 241: the speed Q427 is not negative, and Q428 is greater than 0")
        auxiliary, at = self.core.auxiliary, self.frames.block
        clear, surface = self._start_height(q)
        auxiliary.set_speed(at, q[427], switched=True)
        auxiliary.switch_spindle(at, on=turning is not None, backwards=bool(turning))
        if q[379]:
            self.go_to_height(surface - abs(q[379]) + q[200], q[253])
        auxiliary.set_speed(at, q[428], switched=True)
        auxiliary.switch_spindle(at, on=True)
        auxiliary.switch_coolant(at, round(q[429]))
        if q[201] != 0:
            self.go_to_height(surface + q[201], q[206])
            self._wait(q[211])
        auxiliary.switch_coolant(at, round(q[430]))
        auxiliary.set_speed(at, q[427], switched=True)
        auxiliary.switch_spindle(at, on=turning is not None, backwards=bool(turning))
        self.go_to_height(clear, q[208] or q[206])
        self._leave(q, clear)

    def _center(self, q: _Q) -> None:
        """240: centring to a depth."""
        if q[343]:
            raise ProgramError(
                "VP002",
                "cycle 240 with Q343=1 is not executed: the angle of the tool's point is not known; give the depth, Q343=0",
            )
        clear, surface = self._start_height(q)
        if q[201] != 0:
            self.go_to_height(surface + q[201], q[206])
            self._wait(q[211])
        self.go_to_height(clear, 0.0)
        self._leave(q, clear)


#: Moves of each machining cycle.
HOLES: Final[Mapping[int, Callable[[KlartextCycles, _Q], None]]] = {
    200: KlartextCycles._drill, 201: KlartextCycles._ream, 202: KlartextCycles._bore, 203: KlartextCycles._drill_universal,
    204: KlartextCycles._bore_back, 205: KlartextCycles._drill_universal_pecks, 206: KlartextCycles._tap,
    207: KlartextCycles._tap_rigidly, 208: KlartextCycles._mill_bore, 209: KlartextCycles._tap_rigidly, 240: KlartextCycles._center,
    241: KlartextCycles._drill_single_lip, 262: KlartextCycles._mill_thread,
}  # fmt: skip


def _shorten_step(q: _Q, step: float) -> float:
    """The plunging depth after one: smaller by Q212, no smaller than Q205."""
    if not q[212]:
        return step
    smaller = max(step - q[212], q[205])
    if smaller <= ZERO_LENGTH_MM:
        raise ProgramError(
            "VP007", f"Q212={q[212]:g}: no plunging depth is left before the hole is done; give Q205, the smallest one"
        )
    return smaller
