"""Canned cycles: drilling, pecking, boring, tapping, in all planes. Moves and order as LinuxCNC has them."""

from typing import ClassVar, Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.codes import g_name
from verne_post.gcode.frame_codes import MAX_DWELL_S, polar_end, whole
from verne_post.gcode.spline_codes import SplineCodes
from verne_post.gcode.state import Cycle
from verne_post.model.moves import AXES, FeedMode, MoveKind

#: How far above the last depth a peck begins again, mm.
PECK_CLEARANCE_MM: Final = 0.254
#: So many holes, and pecks in all of them, may one block have.
MAX_HOLES, MAX_PECKS = 10_000, 30_000
_DWELLS: Final = (820, 860, 880, 890)
_NEEDS_STEP: Final = (730, 830)
_NEEDS_SPINDLE: Final = (740, 840, 860, 870, 880)


class CycleCodes(SplineCodes):
    """Codes that move, and cycles that consist of them."""

    #: Cycles that need P.
    needs_dwell: ClassVar[tuple[int, ...]] = (820, 860, 880, 890)
    #: G89 feeds out to the height that G98 or G99 asks for; False: to R, and goes on in rapid traverse.
    feeds_out_whole: ClassVar[bool] = True
    #: R and the bottom stay at their heights when G90 or G91 changes; else the numbers stay, and are read anew.
    keeps_heights: ClassVar[bool] = False
    #: L0 stores the words of a cycle and drills no hole.
    stores_without_holes: ClassVar[bool] = False

    def _execute_cycle(self, block: Block, motion: int, *, goes_on: bool) -> None:
        """Execute one block of a canned cycle; ``goes_on`` when the cycle was already active."""
        state = self.state
        name = g_name(motion)
        _u, _v, normal, *_ = PLANES[state.plane]
        state.position = list(self._motion_start(MoveKind.RAPID, absolute=state.absolute, machine=False))
        self._check_cycle(block, motion, normal)
        goes_on = goes_on and state.cycle is not None and state.cycle.normal == normal
        cycle = self._cycle_heights(block, motion, normal, state.cycle if goes_on else None)
        state.cycle = cycle
        repeats = whole(block, "L") if "L" in block.words else 1
        if repeats == 0 and self.stores_without_holes:
            return
        if not 1 <= repeats <= MAX_HOLES:
            raise block.error("VP007", f"L{repeats}: a cycle is repeated 1 to {MAX_HOLES} times", "L")
        if motion in _NEEDS_STEP and cycle.step and repeats * (cycle.clear - cycle.bottom) / cycle.step > MAX_PECKS:
            raise block.error("VP007", f"{name}: more than {MAX_PECKS} pecks in one block", "Q")
        if motion in _NEEDS_SPINDLE and not (state.spindle_on and state.spindle_speed > 0):
            raise BlockError("VP017", f"{name} needs a turning spindle; give S and M3 or M4 first")
        if motion in (740, 840) and state.spindle_reversed != (motion == 740):
            raise BlockError(
                "VP017",
                f"{name} cuts a {'left' if motion == 740 else 'right'}-hand thread; it needs {'M4' if motion == 740 else 'M3'}",
            )
        with state.exact_path():
            self._drill_holes(block, motion, cycle, repeats)

    def _check_cycle(self, block: Block, motion: int, normal: int) -> None:
        state = self.state
        axes = self._named_axes(block)
        if not axes:
            raise BlockError("VP005", f"{g_name(motion)} needs at least one of X, Y, Z")
        for axis in axes:
            if axis > 2:
                letter = AXES[axis]
                raise block.error("VP017", f"{letter} cannot stand in a canned cycle; write a G0 before it", letter)
        if state.feed_mode == FeedMode.INVERSE:
            raise BlockError("VP017", f"{g_name(motion)} with inverse-time feed (G93); use G94")
        if state.compensation is not None:
            raise BlockError("VP017", f"{g_name(motion)} under cutter compensation; write G40 first")
        if state.tcp_off:
            self._check_tcp_off(state.position, state.position)
        self._check_feed(block, motion)
        if state.absolute:  # the first place that the program names may be that of a hole
            places = {axis: self._axis_value(block, axis) for axis in axes if axis != normal}
            self._stand_at(places | ({normal: self._length(block.words["R"])} if "R" in block.words else {}))
        self._require_known(block, [0, 1, 2], f"{g_name(motion)}")
        if (tool := self.tilted_tool(normal)) is not None:
            raise BlockError(
                "VP017", f"{g_name(motion)} drills along {AXES[normal]}, but {tool}: it would be dragged sideways; turn the table, "
                "or write the hole with G0 and G1",
            )  # fmt: skip

    def _cycle_heights(self, block: Block, motion: int, normal: int, before: Cycle | None) -> Cycle:
        state = self.state
        letter, name = AXES[normal], g_name(motion)
        here = state.position[normal]
        series = state.cycle if state.cycle is not None and state.cycle.normal == normal else None
        if series is not None:
            lengths = {"R", letter, *("Q" if motion in _NEEDS_STEP else ""), *("IJK" if motion == 870 else "")}
            level = series.start_inch != state.inch and (
                state.initial_level
                or not state.absolute
                or series.start < self._length(block.words.get("R", here)) < here
            )
            if level or (before is not None and before.inch != state.inch and not lengths <= set(block.words)):
                raise BlockError(
                    "VP017", f"{name} after a change of units among the cycles: kept lengths, and the level where they began, would be "
                    "read in the other unit; write G80 before G20 or G21",
                )  # fmt: skip
        start = here if series is None else series.start
        if "R" not in block.words and before is None:
            raise BlockError("VP005", f"{name} needs R, the height from which it feeds")
        if letter not in block.words and before is None:
            raise BlockError("VP005", f"{name} needs {letter}, the bottom of the hole")
        kept = before.numbers if before is not None else (0.0, 0.0)
        r = self._length(block.words["R"]) if "R" in block.words else kept[0]
        z = self._axis_value(block, normal) if letter in block.words else kept[1]
        clear, bottom = self._heights(start, r, z)
        of_g90 = (state.absolute, state.absolute)
        if before is not None:
            (clear, bottom), of_g90 = self._heights_after_change(block, motion, before, (clear, bottom), z)
        if clear < bottom:
            raise block.error("VP007", f"R {clear:g} mm lies below the bottom of the hole, {letter} {bottom:g} mm", "R")
        step = self._length(block.words["Q"]) if "Q" in block.words else before.step if before else None
        if motion in _NEEDS_STEP:
            if step is None:
                raise BlockError("VP005", f"{name} needs Q, the depth of one peck")
            if step <= 0:
                raise block.error("VP007", f"Q{step:g}: the depth of a peck is greater than 0", "Q")
        dwell = self._dwell_seconds(block) if "P" in block.words else before.dwell if before else None
        if motion in self.needs_dwell and dwell is None:
            raise BlockError("VP005", f"{name} needs P, the dwell at the bottom")
        shift = before.shift if before else None
        changed = before is not None and before.absolute != state.absolute
        if motion == 870 and (shift is None or changed or any(axis in block.words for axis in "IJK")):
            for axis in "IJK":
                if axis not in block.words:
                    raise BlockError("VP005", f"G87 needs {axis}{', G90 or G91 having changed' if changed else ''}")
            shift = tuple(self._length(block.words[axis]) for axis in "IJK")
        of_start = state.inch if series is None else series.start_inch
        return Cycle(
            normal, start, of_start, clear, bottom, (r, z), of_g90, state.absolute, state.inch, step, dwell, shift
        )

    def _heights(self, start: float, r: float, z: float) -> tuple[float, float]:
        """Heights of R and of the bottom. In G91 R counts from where the cycles began, the bottom from R."""
        if self.state.absolute:
            return r, z
        return start + r, start + r + z

    def _heights_after_change(
        self, block: Block, motion: int, before: Cycle, anew: tuple[float, float], z: float
    ) -> tuple[tuple[float, float], tuple[bool, bool]]:
        """Heights of R and the bottom, and whether the numbers are of G90, where some are kept from blocks before.

        ``anew`` are the heights with the numbers read in the current mode. Warns where that is another hole.
        """
        absolute, letter = self.state.absolute, AXES[before.normal]
        fresh = "R" in block.words, letter in block.words
        was = tuple(absolute if new else old for new, old in zip(fresh, before.of_g90, strict=True))
        if was == (absolute, absolute):
            return anew, (absolute, absolute)
        clear = anew[0] if fresh[0] else before.clear
        same = clear, before.bottom if not fresh[1] else z if absolute else clear + z
        hole, other = (same, anew) if self.keeps_heights else (anew, same)
        differs = max(abs(a - b) for a, b in zip(anew, same, strict=True)) > ZERO_LENGTH_MM
        if differs and before.absolute != absolute:
            names = [name for name, mode in zip(("R", letter), was, strict=True) if mode != absolute]
            old, now = ("G91", "G90") if absolute else ("G90", "G91")
            how = f"read in {now}" if self.keeps_heights else "at the heights of before"
            self.recorder.warn(
                "VP030", f"{g_name(motion)} keeps {' and '.join(names)} of {old} in {now}: the hole goes from {letter} {hole[0]:g} to "
                f"{hole[1]:g} mm; {how} it would go from {other[0]:g} to {other[1]:g} mm; give R and {letter} again",
                block.line, None,
            )  # fmt: skip
        return hole, (was[0], was[1]) if self.keeps_heights else (absolute, absolute)

    def _dwell_seconds(self, block: Block) -> float:
        """The dwell of P."""
        seconds = block.words["P"]
        if seconds < 0:
            raise block.error("VP007", f"P{seconds:g}: a dwell is not negative", "P")
        if seconds > MAX_DWELL_S:
            raise block.error("VP007", f"P{seconds:g}: a dwell of more than a day is a mistake", "P")
        return seconds

    # --- the moves ---------------------------------------------------------------------------------

    def _drill_holes(self, block: Block, motion: int, cycle: Cycle, repeats: int) -> None:
        state = self.state
        u, v, w, *_ = PLANES[state.plane]
        position = state.position
        step = {axis: self._axis_value(block, axis) if AXES[axis] in block.words else None for axis in (u, v)}
        retract = max(cycle.start, cycle.clear) if state.initial_level else cycle.clear
        above = position[w]
        # first retract: to R, under G98 to the initial level
        if min(above, cycle.start) < cycle.clear or above < retract:
            self._go(block, MoveKind.RAPID, {w: retract})
            above = retract
        target = {
            axis: position[axis] if value is None or not state.absolute else value for axis, value in step.items()
        }
        for _hole in range(repeats):
            if block.polar and not state.absolute:  # from the last hole
                target = dict(zip((u, v), self._polar_place(block), strict=True))
            else:
                for axis, value in step.items():
                    if value is not None and not state.absolute:
                        target[axis] += value
            self._go(block, MoveKind.RAPID, {**target, w: above})
            if above != cycle.clear:
                self._go(block, MoveKind.RAPID, {w: cycle.clear})
            self._drill_hole(block, motion, cycle, retract)
            above = retract

    def _polar_place(self, block: Block) -> list[float]:
        """Where the polar words of a block lead in G91 from the present place, mm."""
        unit = self._length(1.0)
        x, y = self.state.position[:2]
        return [unit * value for value in polar_end(block, x / unit, y / unit, absolute=False)]

    def _drill_hole(self, block: Block, motion: int, cycle: Cycle, retract: float) -> None:
        w = PLANES[self.state.plane][2]
        rapid, feed = MoveKind.RAPID, MoveKind.FEED
        if motion in _NEEDS_STEP:
            self._peck(block, motion, cycle)
        elif motion == 870:
            self._back_bore(block, cycle, retract)
            return
        self._go(block, feed, {w: cycle.bottom})
        if motion in (740, 840):
            backwards = self.state.spindle_reversed
            self._switch_spindle(block.line, on=True, backwards=not backwards)
            self._record_dwell(block, cycle.dwell or 0.0)
            self._go(block, feed, {w: retract})
            self._switch_spindle(block.line, on=True, backwards=backwards)
            return
        if motion in _DWELLS and (motion in self.needs_dwell or cycle.dwell):
            self._record_dwell(block, cycle.dwell or 0.0)
        if motion == 850 or (motion == 890 and not self.feeds_out_whole):
            self._go(block, feed, {w: cycle.clear})
        if motion in (860, 880):
            self._switch_spindle(block.line, on=False)
        if motion == 880:
            self.recorder.event(block.line, "stop", stop="program")
            self.state.position = [retract if axis == w else value for axis, value in enumerate(self.state.position)]
        else:
            self._go(block, feed if motion == 890 and self.feeds_out_whole else rapid, {w: retract})
        if motion in (860, 880):
            self._switch_spindle(block.line, on=True, backwards=self.state.spindle_reversed)

    def _peck(self, block: Block, motion: int, cycle: Cycle) -> None:
        """All pecks of a hole but the last."""
        w = PLANES[self.state.plane][2]
        step = cycle.step or 0.0
        depth = cycle.clear - step
        while depth > cycle.bottom + ZERO_LENGTH_MM:  # the last one goes to the bottom; one of no depth is rounding
            self._go(block, MoveKind.FEED, {w: depth})
            if motion == 830:
                self._go(block, MoveKind.RAPID, {w: cycle.clear})
            self._go(block, MoveKind.RAPID, {w: depth + PECK_CLEARANCE_MM})
            depth -= step

    def _back_bore(self, block: Block, cycle: Cycle, retract: float) -> None:
        """G87: down beside the hole with the spindle oriented, up and down turning, out beside it again."""
        state = self.state
        u, v, w, *_ = PLANES[state.plane]
        assert cycle.shift is not None
        shift = cycle.shift
        top = shift[w] + (0.0 if state.absolute else cycle.bottom)
        hole = {u: state.position[u], v: state.position[v]}
        beside = {u: hole[u] + shift[u], v: hole[v] + shift[v]}
        rapid, backwards = MoveKind.RAPID, state.spindle_reversed
        self._go(block, rapid, beside)
        self._orient_spindle(block)
        self._go(block, rapid, {w: cycle.bottom})
        self._go(block, rapid, hole)
        self._switch_spindle(block.line, on=True, backwards=backwards)
        self._go(block, MoveKind.FEED, {w: top})
        self._go(block, MoveKind.FEED, {w: cycle.bottom})
        self._orient_spindle(block)
        self._go(block, rapid, beside)
        self._go(block, rapid, {w: retract})
        self._go(block, rapid, hole)
        self._switch_spindle(block.line, on=True, backwards=backwards)

    def _orient_spindle(self, block: Block) -> None:
        backwards = self.state.spindle_reversed
        self._switch_spindle(block.line, on=False)
        self.state.spindle_reversed = backwards
        self.recorder.event(block.line, "orient", angle=0.0)

    def _go(self, block: Block, kind: MoveKind, places: dict[int, float]) -> None:
        end = list(self.state.position)
        for axis, value in places.items():
            end[axis] = value
        self._record(block.line, kind, end, [0, 1, 2], absolute=True)

    def _record_dwell(self, block: Block, seconds: float) -> None:
        self.recorder.add(self.state, block.line, MoveKind.DWELL, self.state.position, seconds)
