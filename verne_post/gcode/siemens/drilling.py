"""Drilling cycles of Siemens programs: CYCLE81 to 86, 89 and 840, at the place where the tool stands."""

from collections.abc import Iterator
from functools import partial
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.machining.holes import MAX_PECKS, Thread, check_tapping, note_tapping, tap
from verne_post.gcode.machining.machining import explain_inverse_time, explain_tilted_tool, refuse_sideways
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.siemens.arguments import OF_EDITOR, Arguments, check_depths, read_cycle, read_pitch
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.siemens.variables import Variables
from verne_post.gcode.siemens.words import Call
from verne_post.model.moves import AXES, FeedMode, MoveKind

_HEIGHTS: Final = ("RTP", "RFP", "SDIS", "DP", "DPR")
_TAIL: Final = ("_GMODE", "_DMODE", "_AMODE")
#: Values of each cycle, in order.
PARAMETERS: Final = {
    "CYCLE81": (*_HEIGHTS, "DTB", *_TAIL),
    "CYCLE82": (*_HEIGHTS, "DTB", *_TAIL, "_VARI", "_ZA", "_FA", "_ZD", "_FD"),
    "CYCLE83": (*_HEIGHTS, "FDEP", "FDPR", "DAM", "DTB", "DTS", "FRF", "VARI", "_AXN", "_MDEP", "_VRT", "_DTD", "_DIS1",
                *_TAIL),
    "CYCLE84": (*_HEIGHTS, "DTB", "SDAC", "MPIT", "PIT", "POSS", "SST", "SST1", "_AXN", "_PITA", "_TECHNO", "_VARI",
                "_DAM", "_VRT", "_PITM", "_PTAB", "_PTABA", *_TAIL),
    "CYCLE85": (*_HEIGHTS, "DTB", "FFR", "RFF", *_TAIL),
    "CYCLE86": (*_HEIGHTS, "DTB", "SDIR", "RPA", "RPO", "RPAP", "POSS", *_TAIL),
    "CYCLE89": (*_HEIGHTS, "DTB", *_TAIL),
    "CYCLE840": (*_HEIGHTS, "DTB", "SDR", "SDAC", "ENC", "MPIT", "PIT", "_AXN", "_PITA", "_TECHNO", "_PITM", "_PTAB",
                 "_PTABA", *_TAIL),
}  # fmt: skip
#: CYCLE83: how far it retracts to break the chip where _VRT does not say, mm.
_CHIP_MM: Final = 1.0
#: ... and the height above the last depth where rapid traverse ends without _DIS1: to this depth; share; at most.
_NEAR_MM, _NEAR_DEPTH_MM, _NEAR_SHARE, _NEAR_MOST_MM = 0.6, 30.0, 0.02, 7.0
_DIRECTIONS: Final = {3: False, 4: True}


class Drilling:
    """Executes drilling cycles on an interpreter."""

    def __init__(self, interpreter: SiemensInterpreter, variables: Variables) -> None:
        self.interpreter, self.variables = interpreter, variables

    def run(self, call: Call, line: int, holes: int = 1) -> None:
        """Execute one cycle where the tool stands, one of so many of a block."""
        given = read_cycle(call, PARAMETERS[call.name], self.variables)
        hole = _Hole(self.interpreter, given, At(line), holes)
        with self.interpreter.state.follow_exactly():
            hole.drill()


class _Hole:
    """One hole: its heights (mm, programmed), and the moves."""

    def __init__(self, interpreter: SiemensInterpreter, given: Arguments, block: At, holes: int) -> None:
        self.to, self.given, self.block, self.holes = interpreter, given, block, holes
        self.unit = interpreter.modes.length
        axis = given.read_whole("_AXN") if "_AXN" in given.names else 0
        plane = given.read_whole("_DMODE") % 10
        if plane not in (0, 1, 2, 3) or given.read_whole("_DMODE") > 3:
            raise given.error(
                "VP002", f"_DMODE {given.read_whole('_DMODE')} is not executed; 0 to 3 name the plane", "_DMODE"
            )
        number = interpreter.state.plane if plane == 0 else plane - 1
        self.normal = self.upright = PLANES[number][2]
        if axis:
            if axis not in (1, 2, 3):
                raise given.error("VP007", f"_AXN {axis}: axes of the plane are 1 to 3", "_AXN")
            first, second, third, *_ = PLANES[number]
            self.normal = (first, second, third)[axis - 1]
        self._check_place()
        self._read_heights()
        self.to.core.frames.stand_at({self.normal: self.to.motion.convert_to_core(self.normal, self.clear)})

    # --- checks and heights -------------------------------------------------------------------------------

    def _check_place(self) -> None:
        to, name = self.to, self.given.call.name
        to.core.require_known(self.block, [axis for axis in (0, 1, 2) if axis != self.normal], name)
        to.core.refuse_compensation(name)
        if to.state.feed_mode == FeedMode.INVERSE:
            text = f"{name} with inverse-time feed (G93); use G94"
            raise explain_inverse_time(to.core, ProgramError("VP017", text, self.given.call.column))
        if name != "CYCLE84":  # whose feed rate is pitch times speed
            to.motion.check_feed(name)
        if to.state.tool_axis is not None and not to.motion.follows_part:
            to.motion.settle_table(self.block)
        if (tool := to.core.find_tilted_tool(self.normal)) is not None:
            if self.normal != self.upright and to.core.find_tilted_tool(self.upright) is None:
                axis, along = self.given.read_whole("_AXN"), f"the tool points along {AXES[self.upright]}"
                text = f"_AXN {axis} drills along {AXES[self.normal]}, but {along}: it would be dragged sideways"
                error = self.given.error("VP017", f"{text}; write _AXN 3", "_AXN")
                error.line = self.given.call.line  # it stands there wherever MCALL calls it
                raise error
            remedy = explain_tilted_tool(to.core, "CYCLE800", self.normal)
            what = f"{name} drills along {AXES[self.normal]}, but {tool}"
            raise refuse_sideways(to.core, what, remedy, self.given.call.column)

    def _read_length(self, name: str) -> float:
        return self.given.number(name) * self.unit

    def _read_heights(self) -> None:
        given = self.given
        given.require(("RTP",), ("RFP",), ("DP", "DPR"))
        self.retract, self.reference = self._read_length("RTP"), self._read_length("RFP")
        modes = given.read_whole("_AMODE")
        if kind := given.read_whole("_GMODE"):
            raise given.error("VP002", f"_GMODE {kind} is not executed: with 0, DP is the depth of the tip", "_GMODE")
        most = 99_999_999 if given.call.name == "CYCLE83" else 99_999
        if not 0 <= modes <= most:
            raise given.error("VP002", f"_AMODE {modes} is not executed: {len(str(most))} digits are", "_AMODE")
        self.digits = [modes // 10**place % 10 for place in range(8)]
        if max(self.digits) > 2:
            raise given.error("VP002", f"_AMODE {modes}: digits are 0, 1 and 2", "_AMODE")
        self.up = self._find_up()
        clearance = self._read_length("SDIS")
        if clearance < 0:
            raise given.error("VP007", f"SDIS {given.number('SDIS'):g}: a distance is not negative", "SDIS")
        self.clear = self.reference + self.up * clearance
        self.bottom = self._read_depth("DP", "DPR", self.digits[0])
        if self.up < 0 and max(self.retract, self.bottom) < self.reference:
            raise given.error(
                "VP007",
                f"the retract plane {self.retract:g} mm lies below the reference plane {self.reference:g} mm, as the "
                f"bottom {self.bottom:g} mm does; expected RTP above RFP",
                "RTP",
            )
        if self.bottom == self.reference:
            text = f"the bottom is the reference plane {self.reference:g} mm: the hole has no depth"
            raise given.error("VP007", text, "DPR" if given.is_given("DPR") else "DP")
        if (self.reference - self.bottom) * self.up <= 0:
            is_sign = self._is_absolute("DP", "DPR", self.digits[0]) and (self.reference + self.bottom) * self.up > 0
            remedy = f"; write {-given.number('DP'):.15g}" if is_sign else ""
            error = given.error(
                "VP007",
                f"the bottom {self.bottom:g} mm lies on the wrong side of the reference plane {self.reference:g} mm"
                f"{remedy}",
                "DP",
            )
            error.edits = given.write_opposite("DP") if is_sign else ()
            raise error

    def _find_up(self) -> float:
        """Out of the hole: towards the retract plane, or away from an absolute depth if that is the reference plane."""
        if self.retract != self.reference:
            return 1.0 if self.retract > self.reference else -1.0
        if not self._is_absolute("DP", "DPR", self.digits[0]):
            raise self.given.error(
                "VP007",
                "RTP and RFP are the same height, so a relative depth has no direction; give only DP, the absolute "
                "depth",
                "RTP",
            )
        return 1.0 if self._read_length("DP") < self.reference else -1.0

    def _is_absolute(self, absolute: str, relative: str, digit: int) -> bool:
        """Whether a depth is given as a height."""
        given = self.given
        return digit == 2 or (
            digit == 0 and given.is_given(absolute) and not (given.is_given(relative) and given.number(relative))
        )

    def _read_depth(self, absolute: str, relative: str, digit: int) -> float:
        """A depth: absolute, or below the reference plane."""
        given = self.given
        if digit == 1:
            return self.reference - self.up * abs(self._read_length(absolute if given.is_given(absolute) else relative))
        if self._is_absolute(absolute, relative, digit):
            if not given.is_given(absolute):
                raise given.error("VP005", f"{absolute} is needed", absolute)
            return self._read_length(absolute)
        if not given.is_given(relative):
            raise given.error("VP005", f"{absolute} or {relative} is needed", absolute)
        bottom = self.reference - self.up * self._read_length(relative)
        check_depths(given, absolute, relative, bottom / self.unit, self.to.recorder, self.block.line)
        return bottom

    def _read_seconds(self, name: str, digit: int = 0) -> float:
        """A dwell: seconds, or turns of the spindle where it is negative or its digit says so."""
        value = self.given.number(name)
        if digit == 2 or (digit == 0 and value < 0):
            return self.to.convert_turns_to_seconds(abs(value))
        if value < 0:
            raise self.given.error("VP007", f"{name} {value:g}: a dwell is not negative", name)
        return value

    # --- moves --------------------------------------------------------------------------------------------

    def _go(self, height: float, *, rapid: bool) -> None:
        self.to.motion.run_line(self.block, MoveKind.RAPID if rapid else MoveKind.FEED, {self.normal: height})

    def _dwell(self, seconds: float) -> None:
        if seconds:
            self.to.dwell(self.block, seconds)

    def drill(self) -> None:
        """Make the hole, and go to the retract plane."""
        name, given = self.given.call.name, self.given
        here = self.to.motion.find_programmed(self.normal)
        if (here - self.clear) * self.up < -ZERO_LENGTH_MM and (here - self.retract) * self.up < -ZERO_LENGTH_MM:
            raise ProgramError(
                "VP017",
                f"{name}: the tool is at {here:g} mm, below the safety clearance {self.clear:g} mm: it would move "
                "through the part; move it to the retract plane before",
                given.call.column,
            )
        {
            "CYCLE81": self._execute_cycle_82,
            "CYCLE82": self._execute_cycle_82,
            "CYCLE83": self._execute_cycle_83,
            "CYCLE85": self._execute_cycle_85,
            "CYCLE86": self._execute_cycle_86,
            "CYCLE84": self._tap_rigidly,
            "CYCLE89": self._execute_cycle_89,
            "CYCLE840": self._execute_cycle_840,
        }[name]()

    def _execute_cycle_82(self, *, feeds_out: bool = False) -> None:
        seconds = self._read_seconds("DTB", self.digits[1])
        self.given.refuse_rest()
        self._go(self.clear, rapid=True)
        self._go(self.bottom, rapid=False)
        self._dwell(seconds)
        if feeds_out:
            self._go(self.clear, rapid=False)
        self._go(self.retract, rapid=True)

    def _execute_cycle_89(self) -> None:
        self._execute_cycle_82(feeds_out=True)

    def _execute_cycle_85(self) -> None:
        """Ream: FFR in, RFF out."""
        seconds = self._read_seconds("DTB", self.digits[1])
        feeds = [self.given.number(name) for name in ("FFR", "RFF")]
        self.given.refuse_rest()
        for name, feed in zip(("FFR", "RFF"), feeds, strict=True):
            if feed <= 0:
                raise self.given.error("VP009", f"{name} {feed:g}: a feed rate greater than 0 is needed", name)
        self._go(self.clear, rapid=True)
        self._read_feed(feeds[0], self.bottom)
        self._dwell(seconds)
        self._read_feed(feeds[1], self.clear)
        self._go(self.retract, rapid=True)

    def _read_feed(self, feed: float, height: float) -> None:
        with self.to.core.keep_feed():
            self.to.core.set_feed(feed * self.to.modes.feed)
            self._go(height, rapid=False)

    def _execute_cycle_86(self) -> None:
        """Bore: stop the spindle at an angle, lift off, out in rapid traverse."""
        given, to = self.given, self.to
        seconds = self._read_seconds("DTB", self.digits[1])
        direction = given.read_whole("SDIR", 3)
        if direction not in _DIRECTIONS:
            raise given.error("VP007", f"SDIR is {direction}; allowed are 3 and 4, in which the spindle turns", "SDIR")
        lift = [self._read_length(name) for name in ("RPA", "RPO", "RPAP")]
        angle = given.number("POSS")
        given.refuse_rest()
        plane = PLANES[to.state.plane][:2]
        axes = (*plane, self.normal)
        to.core.auxiliary.switch_spindle(self.block, on=True, backwards=_DIRECTIONS[direction])
        self._go(self.clear, rapid=True)
        self._go(self.bottom, rapid=False)
        self._dwell(seconds)
        to.core.auxiliary.orient_spindle(self.block, angle)
        hole = {axis: to.motion.find_programmed(axis) for axis in plane}
        to.motion.run_line(
            self.block,
            MoveKind.RAPID,
            {axis: to.motion.find_programmed(axis) + size for axis, size in zip(axes, lift, strict=True)},
        )
        self._go(self.clear, rapid=True)
        to.motion.run_line(self.block, MoveKind.RAPID, hole)
        self._go(self.retract, rapid=True)
        to.core.auxiliary.switch_spindle(self.block, on=True, backwards=_DIRECTIONS[direction])

    def _execute_cycle_840(self) -> None:
        """Tap with a compensating chuck: in, the spindle turns the other way, out."""
        given, to = self.given, self.to
        if not (to.state.spindle_on and to.state.spindle_speed > 0):
            raise ProgramError(
                "VP017", "CYCLE840 needs a turning spindle; give S and M3 or M4 first", given.call.column
            )
        seconds = self._read_seconds("DTB", self.digits[1])
        out, after = given.read_whole("SDR"), given.read_whole("SDAC", 3)
        pitch = read_pitch(given, self.unit)
        encoder = given.read_whole("ENC")
        given.refuse_rest(OF_EDITOR)
        if encoder not in (0, 1):
            raise given.error("VP002", f"ENC {encoder}: 0 and 1 are executed (1: feed rate as programmed)", "ENC")
        backwards = to.state.spindle_reversed
        if out not in (0, 3, 4) or after not in (3, 4, 5) or (out and _DIRECTIONS[out] == backwards):
            raise given.error("VP007", "SDR is 0 or the other direction of the spindle, SDAC 3, 4 or 5", "SDR")
        with to.core.keep_feed():
            if pitch and encoder == 0 and to.state.feed_mode == FeedMode.PER_MINUTE:
                to.core.set_feed(pitch * to.state.spindle_speed)
            note_tapping(to.core, self.block, line=given.call.line)
            self._go(self.clear, rapid=True)
            self._go(self.bottom, rapid=False)
            to.core.auxiliary.switch_spindle(self.block, on=True, backwards=not backwards)
            self._dwell(seconds)
            self._go(self.clear, rapid=False)
        if out:
            to.core.auxiliary.switch_spindle(self.block, on=after != 5, backwards=after == 4)
        else:  # without SDR the direction comes back by itself
            to.core.auxiliary.switch_spindle(self.block, on=True, backwards=backwards)
        self._go(self.retract, rapid=True)

    def _tap_rigidly(self) -> None:
        """Tap without a compensating chuck: in at SST and out at SST1, in one cut, or in several of _DAM."""
        given, to, here = self.given, self.to, self.given.call.column
        check_tapping(to.core, here)
        seconds, after = self._read_seconds("DTB", self.digits[1]), given.read_whole("SDAC", 5)
        pitch = read_pitch(given, self.unit)
        speeds = given.number("SST"), given.number("SST1") or given.number("SST")
        variant, step = given.read_whole("_VARI"), abs(self._read_length("_DAM"))
        back = abs(self._read_length("_VRT")) or _CHIP_MM
        angle = given.number("POSS")
        given.refuse_rest(("_TECHNO", *OF_EDITOR))
        needs = (
            (bool(pitch), "the pitch (value 9, PIT, or value 8, MPIT, as 8 for M8)"),
            (min(speeds) > 0, "SST greater than 0"),
            (after in (3, 4, 5), "SDAC 3, 4 or 5"),
        )
        if missing := [name for is_met, name in needs if not is_met]:
            raise ProgramError("VP005", f"CYCLE84 needs {' and '.join(missing)}", here)
        if variant not in (0, 1, 2) or (variant and not step):
            raise given.error("VP002", f"_VARI {variant}: 0 taps at once, 1 and 2 in cuts of _DAM", "_VARI")
        places, depth = list[float](), abs(self.reference - self.bottom)
        if variant and depth / step > MAX_PECKS:
            raise given.error("VP007", f"more than {MAX_PECKS} cuts in one hole", "_DAM")
        below = step if variant else depth
        while below < depth - ZERO_LENGTH_MM:
            height = self.reference - self.up * below
            places += [height, self._lower(height + self.up * back, self.clear) if variant == 1 else self.clear]
            below += step
        self._go(self.clear, rapid=True)
        to.core.auxiliary.orient_spindle(self.block, angle)
        thread = Thread(abs(pitch), pitch < 0, *speeds, seconds, given.call.line)
        go = partial(self._go, rapid=False)
        tap(to.core, self.block, thread, (*places, self.bottom, self.clear), go, (after != 5, after == 4))
        self._go(self.retract, rapid=True)

    # --- CYCLE83 --------------------------------------------------------------------------------------------

    def _execute_cycle_83(self) -> None:
        """Deep holes: strokes that grow smaller by DAM; after each, out (VARI 1) or a little back (VARI 0)."""
        given = self.given
        is_given = given.is_given("FDEP") or given.is_given("FDPR")
        first = self._read_depth("FDEP", "FDPR", self.digits[4]) if is_given else self.bottom
        amount, least = given.number("DAM"), self._read_length("_MDEP")
        if self.digits[5] == 2:  # a percentage: each stroke is that share of the one before
            if not 0 < amount <= 100:
                raise given.error("VP007", f"DAM {amount:g}: a percentage is more than 0, and at most 100", "DAM")
            amount = -0.01 * amount
        elif self.digits[5] == 1 and amount < 0:
            raise given.error("VP007", f"DAM {amount:g}: _AMODE says that it is a length, which is not negative", "DAM")
        dwells = [self._read_seconds("DTB", self.digits[1]), self._read_seconds("DTS", self.digits[3])]
        last_dwell = self._read_seconds("_DTD", self.digits[2]) if given.number("_DTD") else dwells[0]
        factor = given.number("FRF") or 1.0
        factor = 0.01 * factor if 1.0 < factor <= 100.0 else factor  # a percentage
        out = given.read_whole("VARI")
        back, near = self._read_length("_VRT"), self._read_length("_DIS1")
        given.refuse_rest()
        if out not in (0, 1):
            raise given.error("VP002", f"VARI {out} is not executed; 0 breaks the chip, 1 takes it out", "VARI")
        if not 0.001 <= factor <= 1.0:
            raise given.error(
                "VP007", f"FRF {factor:g}: the share of the feed rate is 0.001 to 1, or 1 to 100 percent", "FRF"
            )
        depth = (self.reference - self.bottom) * self.up
        first_stroke = (self.reference - first) * self.up
        if not 0 < first_stroke <= depth + ZERO_LENGTH_MM:
            raise given.error(
                "VP007", f"the first depth {first:g} mm is not between the reference plane and the bottom", "FDEP"
            )
        if near <= 0:
            near = _NEAR_MM if depth <= _NEAR_DEPTH_MM else min(_NEAR_SHARE * depth, _NEAR_MOST_MM)
        self._go(self.clear, rapid=True)
        feed = self.to.state.feed
        amount *= self.unit if amount > 0 else 1.0
        depths = list(_plan_strokes(depth, first_stroke, amount, abs(least), given, MAX_PECKS // self.holes))
        for number, below in enumerate(depths):
            height = self.reference - self.up * below
            with self.to.core.keep_feed():
                self.to.core.set_feed(feed * (factor if number == 0 else 1.0), is_given=False)
                self._go(height, rapid=False)
            last = number == len(depths) - 1
            self._dwell(last_dwell if last else dwells[0])
            if last:
                break
            if out:
                self._go(self.clear, rapid=True)
                self._dwell(dwells[1])
                self._go(self._lower(height + self.up * near, self.clear), rapid=True)
            else:
                self._go(self._lower(height + self.up * (abs(back) or _CHIP_MM), self.clear), rapid=False)
        self._go(self.retract, rapid=True)

    def _lower(self, a: float, b: float) -> float:
        return min(a, b) if self.up > 0 else max(a, b)


def _plan_strokes(
    depth: float, first: float, amount: float, least: float, given: Arguments, most: int
) -> Iterator[float]:
    """Depths of CYCLE83 below the reference plane, so many at most.

    Each stroke is smaller by ``amount`` (or is its share where it is negative), as long as that is more than ``amount``
    (``least`` where that is given); then strokes of this size follow, and the last two share what is left.
    """
    if amount < -1:
        raise given.error("VP007", f"DAM {amount:g}: a share is -0.001 to -1", "DAM")
    below, stroke, count = first, first, 1
    yield min(below, depth)
    smallest = least or (amount if amount > 0 else 0.0)
    while depth - below > ZERO_LENGTH_MM:
        count += 1
        if count > most:
            raise given.error("VP007", f"more than {MAX_PECKS} strokes in the holes of one block", "DAM")
        smaller = stroke - amount if amount >= 0 else -amount * stroke
        stroke = max(smaller, smallest) if smallest else smaller
        if stroke <= ZERO_LENGTH_MM:
            raise given.error("VP007", "the strokes become too small; give _MDEP or a smaller DAM", "DAM")
        depth_left = depth - below
        if amount > 0 and stroke <= smallest and stroke < depth_left < 2 * stroke:
            stroke = 0.5 * depth_left
        below = depth if depth_left - stroke <= ZERO_LENGTH_MM else below + stroke
        yield below
