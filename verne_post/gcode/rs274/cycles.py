"""Canned cycles: drilling, pecking, boring, tapping, in all planes. Moves and order as LinuxCNC has them."""

from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.block import Block
from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.machining.holes import MAX_HOLES, MAX_PECKS, Thread, check_tapping, note_tapping, tap
from verne_post.gcode.machining.machining import Machining, explain_inverse_time, explain_tilted_tool, refuse_sideways
from verne_post.gcode.machining.watcher import name_new_plane
from verne_post.gcode.program_error import ProgramError, refuse_missing, write_before
from verne_post.gcode.rs274.modes import Cycle, Modes
from verne_post.gcode.rs274.motion import MotionCodes
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.rs274.values import WordValues, find_polar_end, read_whole
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES, FeedMode, MoveKind

#: How far above the last depth a peck begins again, mm.
PECK_CLEARANCE_MM: Final = 0.254
#: J of rigid tapping, as Haas controls bound it.
MAX_FASTER_OUT: Final = 9
DWELLS: Final = (820, 860, 880, 890)
NEEDS_STEP: Final = (730, 830)
_TAPS: Final = (740, 840)
_FINE_BORING: Final = 760
_NEEDS_SPINDLE: Final = (*_TAPS, _FINE_BORING, 860, 870, 880)


def _has_code(block: Block, motion: int) -> bool:
    return any(word == "G" and round(10 * number) == motion for word, number, _column in block.codes)


class CycleCodes:
    """Canned cycles."""

    def __init__(self, core: Machining, values: WordValues, motion: MotionCodes, traits: Traits) -> None:
        self.core, self.values, self.motion, self.traits = core, values, motion, traits
        self.state, self.recorder = core.state, core.recorder
        self.modes: Modes = core.state.modes
        #: Where the oriented tool of G76 leaves the wall: "+X" and the like; "" where nobody has said it.
        self.bore_shift = ""

    def execute(self, block: Block, motion: int, *, goes_on: bool) -> None:
        """Execute one block of a canned cycle; ``goes_on`` when the cycle was already active."""
        state = self.state
        name = spell_g_code(motion)
        _u, _v, normal, *_ = PLANES[state.plane]
        start = self.core.start_of_motion(MoveKind.RAPID, absolute=self.modes.absolute, machine=False, axes=(normal,))
        self.core.stand(list(start))
        before = self.modes.cycle
        goes_on = goes_on and before is not None and before.normal == normal
        mode_text: tuple[str, str, str] | None = None
        watcher, told_line, end_line = self.core.watcher, block.line, 0
        if not goes_on or before is None or _has_code(block, motion):
            watcher.last_hole = None
        plane = watcher.find_new_plane(state) if block.words.get("L") != 0 else None
        if before is not None and goes_on and not _has_code(block, motion) and (before.change or plane is not None):
            where, end_line = f"after the change of tools in line {before.change}", before.change
            if plane is not None and not before.change:
                where, told_line, end_line = name_new_plane(plane), plane.own_line, plane.own_line
            mode = f"{name} of line {before.line} is still in force"
            mode_text = mode, where, "write G80 before that if no hole is meant"
        try:
            self._check_cycle(block, motion, normal)
        except ProgramError as error:
            error.message += "; {} {}; {}".format(*mode_text) if mode_text else ""
            raise
        if mode_text:
            at_plane = plane is not None and told_line == plane.own_line
            watcher.report(*mode_text, told_line, write_before("G80", line=end_line), at_plane=at_plane)
        before = self.modes.cycle if goes_on else self._find_kept(block, motion, normal)
        cycle = self._read_cycle_heights(block, motion, normal, before)
        self.modes.cycle = cycle
        repeats = read_whole(block, "L") if "L" in block.words else 1
        if repeats == 0 and self.traits.stores_without_holes:
            return
        if not 1 <= repeats <= MAX_HOLES:
            raise block.error("VP007", f"L{repeats}: a cycle is repeated 1 to {MAX_HOLES} times", "L")
        least = cycle.falling[2] if cycle.falling else cycle.step
        if motion in NEEDS_STEP and least and repeats * (cycle.clear - cycle.bottom) / least > MAX_PECKS:
            raise block.error("VP007", f"{name}: more than {MAX_PECKS} pecks in one block", "Q")
        if motion in _TAPS and self.traits.taps_rigidly:
            self._check_rigid_tapping(block, name)
        elif motion in _NEEDS_SPINDLE and not (state.spindle_on and state.spindle_speed > 0):
            raise ProgramError("VP017", f"{name} needs a turning spindle; give S and M3 or M4 first")
        elif motion in _TAPS and state.spindle_reversed != (motion == 740):
            raise ProgramError(
                "VP017",
                f"{name} cuts a {'left' if motion == 740 else 'right'}-hand thread; it needs "
                f"{'M4' if motion == 740 else 'M3'}",
            )
        with state.follow_exactly():
            self._drill_holes(block, motion, cycle, repeats)

    def _find_kept(self, block: Block, motion: int, normal: int) -> Cycle | None:
        """The cycle in force if this block lacks words that the control keeps until G80; else None."""
        cycle, words = self.modes.cycle, block.words
        needs = {
            "R",
            AXES[normal],
            *("Q" if motion in NEEDS_STEP and "I" not in words else ""),
            *("P" if motion in DWELLS else ""),
        }
        if not self.traits.keeps_words or cycle is None or cycle.normal != normal or needs <= set(words):
            return None
        return cycle

    def _check_cycle(self, block: Block, motion: int, normal: int) -> None:
        state = self.state
        axes = self.values.list_named_axes(block)
        if not axes:
            raise ProgramError("VP005", f"{spell_g_code(motion)} needs at least one of X, Y, Z")
        for axis in axes:
            if axis > 2:
                letter = AXES[axis]
                raise block.error("VP017", f"{letter} cannot be in a canned cycle; write a G0 before it", letter)
        if state.feed_mode == FeedMode.INVERSE:
            text = f"{spell_g_code(motion)} with inverse-time feed (G93); use G94"
            raise explain_inverse_time(self.core, ProgramError("VP017", text))
        self.core.refuse_compensation(spell_g_code(motion))
        if state.tcp_off:
            self.core.check_tcp_off(state.position, state.position)
        self.motion.check_feed(block, motion, turns_itself=motion in _TAPS and self.traits.taps_rigidly)
        if self.modes.absolute:  # the first place that the program names may be that of a hole
            places = {axis: self.values.read_axis_value(block, axis) for axis in axes if axis != normal}
            self.core.frames.stand_at(
                places | ({normal: self.values.convert_length(block.words["R"])} if "R" in block.words else {})
            )
        self.core.require_known(block, [0, 1, 2], f"{spell_g_code(motion)}")
        if (tool := self.core.find_tilted_tool(normal)) is not None:
            remedy = explain_tilted_tool(self.core, self.traits.tilted_plane, normal)
            raise refuse_sideways(self.core, f"{spell_g_code(motion)} drills along {AXES[normal]}, but {tool}", remedy)

    def _read_cycle_heights(self, block: Block, motion: int, normal: int, before: Cycle | None) -> Cycle:
        state = self.state
        letter, name = AXES[normal], spell_g_code(motion)
        here = state.position[normal]
        series = self.modes.cycle if self.modes.cycle is not None and self.modes.cycle.normal == normal else None
        if series is not None:
            self._refuse_other_unit(block, motion, series, before)
        start = here if series is None else series.start
        step = self.values.convert_length(block.words["Q"]) if "Q" in block.words else before.step if before else None
        dwell = self.values.read_dwell(block) if "P" in block.words else before.dwell if before else None
        falling = before.falling if before is not None and "Q" not in block.words else None
        has_pecks = motion not in NEEDS_STEP or "I" in block.words or falling or step is not None
        missing = [
            ("R", "height from which it feeds") if "R" not in block.words and before is None else None,
            (letter, "bottom of the hole") if letter not in block.words and before is None else None,
            None if has_pecks else ("Q", "depth of one peck"),
            ("P", "dwell at the bottom") if motion in self.traits.needs_dwell and dwell is None else None,
        ]
        if any(missing):
            raise refuse_missing(name, list(filter(None, missing)))
        numbers_before = before.numbers if before is not None else (0.0, 0.0)
        r = self.values.convert_length(block.words["R"]) if "R" in block.words else numbers_before[0]
        z = self.values.read_axis_value(block, normal) if letter in block.words else numbers_before[1]
        clear, bottom = self._find_heights(start, r, z)
        of_g90 = (self.modes.absolute, self.modes.absolute)
        if before is not None:
            (clear, bottom), of_g90 = self._read_changed_heights(block, motion, before, (clear, bottom), z)
        goes_on = series is not None and not _has_code(block, motion)
        line = series.line if series is not None and goes_on else self.recorder.lines.find_own(block.line)
        if clear <= bottom + ZERO_LENGTH_MM:
            self._report_no_depth(block, motion, line, clear, bottom)
        if motion in NEEDS_STEP and "I" in block.words:
            falling = self._read_falling_pecks(block, name)
        if motion in NEEDS_STEP and not falling and step is not None and step <= 0:
            raise block.error("VP007", f"Q{step:g}: the depth of a peck is greater than 0", "Q")
        shift = self._read_way_out(block, motion, step, before)
        of_start = self.modes.inch if series is None else series.start_inch
        return Cycle(
            normal,
            start,
            of_start,
            clear,
            bottom,
            (r, z),
            of_g90,
            self.modes.absolute,
            self.modes.inch,
            step,
            dwell,
            shift,
            falling,
            (before is not None and before.dwells) or (motion in NEEDS_STEP and "P" in block.words),
            line,
        )

    def _report_no_depth(self, block: Block, motion: int, line: int, clear: float, bottom: float) -> None:
        """Refuse (VP007) R below the bottom of a hole, at the word that is likelier wrong; warn where they are equal.

        A part is mostly set up with its upper face at 0, so R below that is wrong, and else the bottom is. A bottom in
        a block without the code is often a retract, and G80 is missing before it.
        """
        letter = AXES[PLANES[self.state.plane][2]]
        words = [word for word in ("R", letter) if word in block.words]
        is_r = words == ["R"] or (len(words) == 2 and self.modes.absolute and clear <= 0)
        wrong_letter = "R" if is_r else letter
        still = f"; {spell_g_code(motion)} of line {line} is still active: if no hole is meant, write G80 first"
        remedy = still if line != self.recorder.lines.find_own(block.line) and not is_r else ""
        r, z = (f"{value / MM_PER_INCH:g} inch" if self.modes.inch else f"{value:g} mm" for value in (clear, bottom))
        if clear >= bottom:
            if words:  # the holes after it are of the same cause
                text = f"the hole has no depth: {letter} {z} is R{remedy}"
                self.recorder.warn("VP007", text, block.line, None, "warning")
            return
        text = (
            f"R {r} lies below the bottom of the hole, {letter} {z}"
            if is_r
            else f"{letter} {z}, the bottom of the hole, lies above R {r}"
        )
        edits = write_before("G80") if remedy else ()
        if not (remedy or is_r) and self.modes.absolute and letter in block.words and -bottom < clear:
            value = block.words[letter]
            text += f"; write {letter}{-value:.15g}, if its sign is missing"
            edits = (Remedy(f"write {letter}{-value:.15g}", f"{-value:.15g}", word=(letter, value), is_choice=True),)
        raise block.error("VP007", f"{text}{remedy}", wrong_letter, edits=edits)

    def _refuse_other_unit(self, block: Block, motion: int, series: Cycle, before: Cycle | None) -> None:
        """Refuse (VP017) lengths that are kept from a cycle, and the level where a series began, in another unit."""
        letter = AXES[series.normal]
        here = self.state.position[series.normal]
        lengths = {"R", letter, *("Q" if motion in NEEDS_STEP else ""), *("IJK" if motion == 870 else "")}
        level = series.start_inch != self.modes.inch and (
            self.modes.initial_level
            or not self.modes.absolute
            or series.start < self.values.convert_length(block.words.get("R", here)) < here
        )
        if level or (before is not None and before.inch != self.modes.inch and not lengths <= set(block.words)):
            raise ProgramError(
                "VP017",
                f"{spell_g_code(motion)} after a change of units among the cycles: kept lengths, and the level where "
                "they began, would be read in the other unit; write G80 before G20 or G21",
            )

    def _read_way_out(
        self, block: Block, motion: int, step: float | None, before: Cycle | None
    ) -> tuple[float, ...] | None:
        """How the tool goes away from the wall of the hole, mm, in cycles with an oriented stop."""
        shift = before.shift if before else None
        if motion == _FINE_BORING:
            shift = self._find_way_out(block, step, shift, spell_g_code(motion))
        is_other_mode = before is not None and before.absolute != self.modes.absolute
        if motion == 870 and (shift is None or is_other_mode or any(axis in block.words for axis in "IJK")):
            for axis in "IJK":
                if axis not in block.words:
                    raise ProgramError(
                        "VP005", f"G87 needs {axis}{', G90 or G91 having changed' if is_other_mode else ''}"
                    )
            shift = tuple(self.values.convert_length(block.words[axis]) for axis in "IJK")
        return shift

    def _read_falling_pecks(self, block: Block, name: str) -> tuple[float, float, float]:
        """I J K of G73 and G83 of Haas, mm."""
        for letter in "IJK":
            if letter not in block.words:
                raise ProgramError("VP005", f"{name} needs I, J and K together: first peck, less for each, least; or Q")
        first, less, least = (self.values.convert_length(block.words[letter]) for letter in "IJK")
        if "Q" in block.words or not (0 < least <= first and less >= 0):
            raise block.error(
                "VP007",
                f"{name} I J K: pecks fall from I by J to no less than K, which is greater than 0, and there is no Q",
                "I",
            )
        return first, less, least

    def _find_heights(self, start: float, r: float, z: float) -> tuple[float, float]:
        """Heights of R and of the bottom. In G91 R counts from where the cycles began, the bottom from R."""
        if self.modes.absolute:
            return r, z
        return start + r, start + r + z

    def _read_changed_heights(
        self, block: Block, motion: int, before: Cycle, anew: tuple[float, float], z: float
    ) -> tuple[tuple[float, float], tuple[bool, bool]]:
        """Heights of R and the bottom, and whether the numbers are of G90, where some are kept from blocks before.

        ``anew`` are the heights with the numbers read in the current mode. Warns where that is another hole.
        """
        absolute, letter = self.modes.absolute, AXES[before.normal]
        fresh = "R" in block.words, letter in block.words
        was = tuple(absolute if new else old for new, old in zip(fresh, before.of_g90, strict=True))
        if was == (absolute, absolute):
            return anew, (absolute, absolute)
        clear = anew[0] if fresh[0] else before.clear
        same = clear, before.bottom if not fresh[1] else z if absolute else clear + z
        hole, other = (same, anew) if self.traits.keeps_heights else (anew, same)
        differs = max(abs(a - b) for a, b in zip(anew, same, strict=True)) > ZERO_LENGTH_MM
        if differs and before.absolute != absolute:
            names = [name for name, mode in zip(("R", letter), was, strict=True) if mode != absolute]
            old, now = ("G91", "G90") if absolute else ("G90", "G91")
            how = f"read in {now}" if self.traits.keeps_heights else "at the earlier heights"
            self.recorder.warn(
                "VP030",
                f"{spell_g_code(motion)} keeps {' and '.join(names)} of {old} in {now}: the hole goes from "
                f"{letter} {hole[0]:g} to "
                f"{hole[1]:g} mm; {how} it would go from {other[0]:g} to {other[1]:g} mm; give R and {letter} again",
                block.line,
                None,
            )
        return hole, (was[0], was[1]) if self.traits.keeps_heights else (absolute, absolute)

    # --- the moves ---------------------------------------------------------------------------------

    def _drill_holes(self, block: Block, motion: int, cycle: Cycle, repeats: int) -> None:
        state = self.state
        u, v, w, *_ = PLANES[state.plane]
        position = state.position
        step = {
            axis: self.values.read_axis_value(block, axis) if AXES[axis] in block.words else None for axis in (u, v)
        }
        retract = max(cycle.start, cycle.clear) if self.modes.initial_level else cycle.clear
        above = position[w]
        # first retract: to R, under G98 to the initial level
        if min(above, cycle.start) < cycle.clear or above < retract:
            self._go(block, MoveKind.RAPID, {w: retract})
            above = retract
        target = {
            axis: position[axis] if value is None or not self.modes.absolute else value for axis, value in step.items()
        }
        for _hole in range(repeats):
            if block.polar and not self.modes.absolute:  # from the last hole
                target = dict(zip((u, v), self._find_polar_place(block), strict=True))
            else:
                for axis, value in step.items():
                    if value is not None and not self.modes.absolute:
                        target[axis] += value
            self._go(block, MoveKind.RAPID, {**target, w: above})
            if above != cycle.clear:
                self._go(block, MoveKind.RAPID, {w: cycle.clear})
            self._drill_hole(block, motion, cycle, retract)
            above = retract

    def _find_polar_place(self, block: Block) -> list[float]:
        """Where the polar words of a block lead in G91 from the present place, mm."""
        unit = self.values.convert_length(1.0)
        x, y = self.state.position[:2]
        return [unit * value for value in find_polar_end(block, x / unit, y / unit, absolute=False)]

    def _drill_hole(self, block: Block, motion: int, cycle: Cycle, retract: float) -> None:
        w = PLANES[self.state.plane][2]
        rapid, feed = MoveKind.RAPID, MoveKind.FEED
        if motion in NEEDS_STEP:
            self._drill_pecks(block, motion, cycle)
        elif motion == 870:
            self._bore_back(block, cycle, retract)
            return
        elif motion == _FINE_BORING:
            self._bore_finely(block, cycle, retract)
            return
        elif motion in _TAPS and self.traits.taps_rigidly:
            self._tap_rigidly(block, motion, cycle)
            self._go(block, rapid, {w: retract})
            return
        self._go(block, feed, {w: cycle.bottom})
        if motion in _TAPS:
            note_tapping(self.core, block)
            backwards = self.state.spindle_reversed
            self.core.auxiliary.switch_spindle(block, on=True, backwards=not backwards)
            self.core.dwell(block, cycle.dwell or 0.0)
            self._go(block, feed, {w: retract})
            self.core.auxiliary.switch_spindle(block, on=True, backwards=backwards)
            return
        dwells = motion in DWELLS or (motion in NEEDS_STEP and cycle.dwells)
        if dwells and (motion in self.traits.needs_dwell or cycle.dwell):
            self.core.dwell(block, cycle.dwell or 0.0)
        if motion == 850 or (motion == 890 and not self.traits.feeds_out_whole):
            self._go(block, feed, {w: cycle.clear})
        if motion in (860, 880):
            self.core.auxiliary.switch_spindle(block, on=False)
        if motion == 880:
            self.recorder.record_event(block.line, "stop", stop="program")
            self.core.stand([retract if axis == w else value for axis, value in enumerate(self.state.position)])
        else:
            self._go(block, feed if motion == 890 and self.traits.feeds_out_whole else rapid, {w: retract})
        if motion in (860, 880):
            self.core.auxiliary.switch_spindle(block, on=True, backwards=self.state.spindle_reversed)

    def _check_rigid_tapping(self, block: Block, name: str) -> None:
        check_tapping(self.core)
        if not self.state.spindle_speed:
            raise ProgramError("VP017", f"{name} needs the speed of the spindle; give S first")
        if "Q" in block.words:
            raise block.error(
                "VP002",
                f"{name} Q: a parameter of the control decides how far the tap goes back between pecks; leave Q out",
                "Q",
            )
        if not 1.0 <= block.words.get("J", 1.0) <= MAX_FASTER_OUT:
            raise block.error(
                "VP007", f"{name} J{block.words['J']:g}: the tap goes out 1 to {MAX_FASTER_OUT} times as fast", "J"
            )

    def _tap_rigidly(self, block: Block, motion: int, cycle: Cycle) -> None:
        """To the bottom and back to R; F is the pitch in G95, and pitch times speed in G94."""
        state = self.state
        speed = state.spindle_speed
        pitch = state.feed if state.feed_mode == FeedMode.PER_REVOLUTION else state.feed / speed
        thread = Thread(pitch, motion == 740, speed, speed * block.words.get("J", 1.0), cycle.dwell or 0.0)
        w = PLANES[state.plane][2]
        after = state.spindle_on and not self.modes.stops_after_tapping, state.spindle_reversed
        tap(
            self.core,
            block,
            thread,
            (cycle.bottom, cycle.clear),
            lambda height: self._go(block, MoveKind.FEED, {w: height}),
            after,
        )

    def _drill_pecks(self, block: Block, motion: int, cycle: Cycle) -> None:
        """All pecks of a hole but the last."""
        w = PLANES[self.state.plane][2]
        step, less, least = cycle.falling or (cycle.step or 0.0, 0.0, 0.0)
        depth = cycle.clear - step
        while depth > cycle.bottom + ZERO_LENGTH_MM:  # the last one goes to the bottom; one of no depth is rounding
            self._go(block, MoveKind.FEED, {w: depth})
            if motion == 830:
                self._go(block, MoveKind.RAPID, {w: cycle.clear})
            self._go(block, MoveKind.RAPID, {w: depth + PECK_CLEARANCE_MM})
            step = max(step - less, least) if less else step
            depth -= step

    def _find_way_out(
        self, block: Block, step: float | None, before: tuple[float, ...] | None, name: str
    ) -> tuple[float, ...]:
        """The way of the oriented tool off the wall, in the plane (mm): I and J, or Q in the set direction."""
        words = block.words
        if {"I", "J"} & set(words):
            return self.values.convert_length(words.get("I", 0.0)), self.values.convert_length(words.get("J", 0.0))
        if before is not None and "Q" not in words:
            return before
        if not step or step < 0:
            raise ProgramError(
                "VP005", f"{name} needs Q greater than 0, or I and J, by which the oriented tool leaves the wall"
            )
        if not self.bore_shift:
            raise block.error(
                "VP005",
                f"{name} Q: parameter 5148 decides where the oriented tool leaves the wall; give [fanuc] "
                'bore_shift = "+X", "-X", "+Y" or "-Y" in the '
                "settings file, or write I and J",
                "Q",
            )
        way = -step if self.bore_shift[0] == "-" else step
        return (way, 0.0) if self.bore_shift[1] == "X" else (0.0, way)

    def _bore_finely(self, block: Block, cycle: Cycle, retract: float) -> None:
        """G76: in, the spindle stops at an angle, off the wall, out, back over the hole."""
        position, rapid, backwards = list(self.state.position), MoveKind.RAPID, self.state.spindle_reversed
        u, v, w, *_ = PLANES[self.state.plane]
        off = cycle.shift or (0.0, 0.0)
        self._go(block, MoveKind.FEED, {w: cycle.bottom})
        if cycle.dwell:
            self.core.dwell(block, cycle.dwell)
        self._orient_spindle(block)
        self._go(block, rapid, {u: position[u] + off[0], v: position[v] + off[1]})
        self._go(block, rapid, {w: retract})
        self._go(block, rapid, {u: position[u], v: position[v]})
        self.core.auxiliary.switch_spindle(block, on=True, backwards=backwards)

    def _bore_back(self, block: Block, cycle: Cycle, retract: float) -> None:
        """G87: down beside the hole with the spindle oriented, up and down turning, out beside it again."""
        state = self.state
        u, v, w, *_ = PLANES[state.plane]
        assert cycle.shift is not None
        shift = cycle.shift
        top = shift[w] + (0.0 if self.modes.absolute else cycle.bottom)
        hole = {u: state.position[u], v: state.position[v]}
        beside = {u: hole[u] + shift[u], v: hole[v] + shift[v]}
        rapid, backwards = MoveKind.RAPID, state.spindle_reversed
        self._go(block, rapid, beside)
        self._orient_spindle(block)
        self._go(block, rapid, {w: cycle.bottom})
        self._go(block, rapid, hole)
        self.core.auxiliary.switch_spindle(block, on=True, backwards=backwards)
        self._go(block, MoveKind.FEED, {w: top})
        self._go(block, MoveKind.FEED, {w: cycle.bottom})
        self._orient_spindle(block)
        self._go(block, rapid, beside)
        self._go(block, rapid, {w: retract})
        self._go(block, rapid, hole)
        self.core.auxiliary.switch_spindle(block, on=True, backwards=backwards)

    def _orient_spindle(self, block: Block) -> None:
        self.core.auxiliary.switch_spindle(block, on=False)
        self.core.auxiliary.orient_spindle(block, 0.0)

    def _go(self, block: Block, kind: MoveKind, places: dict[int, float]) -> None:
        end = list(self.state.position)
        for axis, value in places.items():
            end[axis] = value
        self.core.go_straight(block, kind, end, [0, 1, 2])
