"""Values of Siemens milling cycles: heights, feed rates, and how an outline is milled."""

import math
from collections.abc import Iterable
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.machining.machining import explain_inverse_time, explain_tilted_tool, list_plane_edits
from verne_post.gcode.machining.pockets import Entry, Milling, spread_levels
from verne_post.gcode.missing_setup import report_unloaded
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.siemens.arguments import Arguments, check_depths
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.model.moves import AXES, FeedMode
from verne_post.model.part_setup import describe_tool_number

_HEIGHTS: Final = ("RTP", "RFP", "SDIS", "DP")
_WAYS: Final = ("SDIS", "DP1", "FDP", "FDP1", "LP1", "LP2")
#: Lengths of which no sign has a meaning.
_NOT_NEGATIVE: Final = (*_WAYS, "KDIAM", "RC", "MID", "MIDF", "MIDA", "FAL", "FALD", "CRAD", "RAD1")
_CHAMFER: Final = ("FS", "ZFS")
_TAIL: Final = ("_GMODE", "_DMODE", "_AMODE")
_SLOTS: Final = ("STA1", "INDA", "FFD", "FFP1", "MID", "CDIR", "FAL", "VARI", "MIDF", "FFP2", "SSF")
_FINE: Final = ("MID", "FAL", "FALD", "FFP1", "FFD", "CDIR", "VARI")
#: Values of each cycle, in order.
PARAMETERS: Final = {
    "POCKET1": (*_HEIGHTS, "DPR", "LENG", "WID", "CRAD", "PA", "PO", "STA", "FFD", "FFP1", "MID", "CDIR", "FAL", "VARI",
                "MIDF", "FFP2", "SSF"),
    "POCKET2": (*_HEIGHTS, "DPR", "PRAD", "PA", "PO", "FFD", "FFP1", "MID", "CDIR", "FAL", "VARI", "MIDF", "FFP2",
                "SSF"),
    "POCKET3": (*_HEIGHTS, "LENG", "WID", "CRAD", "PA", "PO", "STA", *_FINE, "MIDA", "AP1", "AP2", "AD", "RAD1", "DP1",
                "_UMODE", *_CHAMFER, *_TAIL),
    "POCKET4": (*_HEIGHTS, "PRAD", "PA", "PO", *_FINE, "MIDA", "AP1", "AD", "RAD1", "DP1", "_UMODE", *_CHAMFER, *_TAIL),
    "SLOT1": (*_HEIGHTS, "DPR", "NUM", "LENG", "WID", "PA", "PO", "RAD", *_SLOTS, "FALD", "STA2", "DP1", "_UMODE",
              *_CHAMFER, *_TAIL),
    "SLOT2": (*_HEIGHTS, "DPR", "NUM", "AFSL", "WID", "PA", "PO", "RAD", *_SLOTS, "FFCP", "_UMODE", *_CHAMFER, *_TAIL),
    "LONGHOLE": (*_HEIGHTS, "DPR", "NUM", "LENG", "PA", "PO", "RAD", "STA1", "INDA", "FFD", "FFP1", "MID", "VARI",
                 "_UMODE", *_TAIL),
    "CYCLE76": (*_HEIGHTS, "DPR", "LENG", "WID", "CRAD", "PA", "PO", "STA", *_FINE, "AP1", "AP2", *_CHAMFER, *_TAIL),
    "CYCLE77": (*_HEIGHTS, "DPR", "PRAD", "PA", "PO", *_FINE, "AP1", *_CHAMFER, *_TAIL),
    "CYCLE70": (*_HEIGHTS, "DIATH", "H1", "FAL", "PIT", "NT", "MID", "FFR", "TYPTH", "PA", "PO", "NSP", "VARI", "_PITA",
                "_PITM", "_PTAB", "_PTABA", *_TAIL),
    "CYCLE79": (*_HEIGHTS, "NUM", "SWL", "PA", "PO", "STA", "RC", "AP1", "MIDA", "MID", "FAL", "FALD", "FFP1", "CDIR",
                "VARI", *_CHAMFER, *_TAIL),
    "CYCLE899": (*_HEIGHTS, "LENG", "WID", "PA", "PO", "STA", "MID", "MIDA", "FAL", "FALD", "FFP1", "CDIR", "VARI",
                 *_TAIL, "_UMODE", *_CHAMFER),
    "CYCLE90": (*_HEIGHTS, "DPR", "DIATH", "KDIAM", "PIT", "FFR", "CDIR", "TYPTH", "PA", "PO"),
    "CYCLE61": (*_HEIGHTS, "PA", "PO", "LENG", "WID", "MID", "MIDA", "FALD", "FFP1", "VARI", "LIM", "_DMODE", "_AMODE"),
    "CYCLE71": (*_HEIGHTS, "PA", "PO", "LENG", "WID", "STA", "MID", "MIDA", "FDP", "FALD", "FFP1", "VARI", "FDP1"),
}  # fmt: skip
#: _DMODE without its last digit. The tens are the feed mode of the feed rates, here always that in force. Thousands of
#: CYCLE72: CYCLE62 names the contour, as an empty name says too.
_DISPLAY: Final = (0, 1)
_DISPLAYS: Final = {"CYCLE72": (0, 1, 100, 101)}
#: Tens digit of VARI: how the tool plunges. With 0 controls go down in rapid traverse, into a hole drilled before.
_ENTRIES: Final[tuple[Entry, ...]] = ("straight", "straight", "helix", "swing")
_TENS: Final = {
    "POCKET1": (0,), "POCKET2": (0,), "POCKET3": (0, 1, 2, 3), "POCKET4": (0, 1, 2), "SLOT1": (0, 1, 3),
    "SLOT2": (0, 1), "LONGHOLE": (0, 1),
    "CYCLE76": (0, 1), "CYCLE77": (0, 1), "CYCLE79": (0,),
}  # fmt: skip
#: Digits of _AMODE from the last one on, and what they say of values that are executed.
_MODES: Final = (
    ("last", " (DP: 0 and 2 a height, 1 a depth)"),
    ("tens", " (MIDA: 0 a length, 1 a share of the diameter)"),
    ("hundreds", ""),
    ("thousands", ""),
    ("ten thousands", ""),
)
_WORK: Final = "the last digit is 1 roughing, 2 finishing, 4 finishing of the edge"
#: Share of the tool's diameter between two paths where MIDA does not say.
_SHARE_OF_DIAMETER: Final = 0.8


class MillingValues:
    """The values of one call, lengths in mm of the program.

    Attributes
    ----------
    clear, top, bottom, retract : float
        Heights: safety clearance, reference plane, floor, retract plane.
    feeds : dict
        Feed rates of the strokes by their pace.
    radius : float
        Of the tool.
    digits : list of int
        Of _AMODE, the last one first.
    is_upward : bool
        CYCLE90 with DP above RFP mills from there up; ``top`` is then DP.
    """

    def __init__(self, interpreter: SiemensInterpreter, given: Arguments, at: At) -> None:
        self.to, self.given, self.at = interpreter, given, at
        self.name, self.unit = given.call.name, interpreter.modes.length
        self.plane = PLANES[interpreter.state.plane][:3]
        self._check_place()
        self._read_heights()
        self.feeds = self._read_feeds()
        self.radius = self._find_radius()

    def _check_place(self) -> None:
        to, name, column = self.to, self.name, self.given.call.column
        to.core.refuse_compensation(name)
        if to.state.feed_mode == FeedMode.INVERSE:
            text = f"{name} with inverse-time feed (G93); use G94"
            raise explain_inverse_time(to.core, ProgramError("VP017", text, column))
        if not to.motion.has_no_scale and {abs(to.motion.scale(axis)) for axis in (0, 1, 2)} != {1.0}:
            raise ProgramError(
                "VP017",
                f"{name} under SCALE: the tool would not be scaled with it; write the values themselves",
                column,
            )
        if to.state.tool_axis is not None and not to.motion.follows_part:
            to.motion.settle_table(self.at)
        if (tool := to.core.find_tilted_tool(self.plane[2])) is not None:
            remedy = explain_tilted_tool(to.core, "CYCLE800", self.plane[2])
            text = f"{name} works along {AXES[self.plane[2]]}, but {tool}; {remedy}"
            raise ProgramError("VP017", text, column, edits=list_plane_edits(to.core))

    def measure(self, name: str, *, positive: bool = False) -> float:
        """A length, mm; greater than 0 where it must be."""
        value = self.given.number(name) * self.unit
        if positive and value <= 0:
            raise self.given.error("VP007", f"{name} {value / self.unit:g}: a length greater than 0 is needed", name)
        if name in _NOT_NEGATIVE and value < 0:
            raise self.given.error("VP007", f"{name} {value / self.unit:g}: it is not negative", name)
        return value

    def _read_heights(self) -> None:
        given = self.given
        given.require(("RTP",), ("RFP",), tuple(name for name in ("DP", "DPR") if name in given.names))
        self.retract, self.top = self.measure("RTP"), self.measure("RFP")
        self.clear = self.top + self.measure("SDIS")
        modes = given.read_whole("_AMODE")
        self.digits = [modes // 10**place % 10 for place in range(5)]
        has_height = given.is_given("DP")
        takes_dpr = "DPR" in given.names and given.is_given("DPR") and (given.number("DPR") != 0 or not has_height)
        relative = "DPR" if takes_dpr else "DP"
        is_relative = relative == "DPR" or self.digits[0] == 1
        self._check_modes(modes)
        depth = self.measure(relative)
        self.bottom = self.top - abs(depth) if is_relative else depth
        if takes_dpr:
            check_depths(given, "DP", "DPR", self.bottom / self.unit, self.to.recorder, self.at.line)
        self.is_upward = self.name == "CYCLE90" and not is_relative and self.bottom > self.top
        if self.is_upward:
            if self.clear > self.top:
                raise given.error(
                    "VP002",
                    f"SDIS {given.number('SDIS'):g} is not executed where DP is above RFP, so that the thread is "
                    "milled upwards; write 0",
                    "SDIS",
                )
            self.top, self.bottom, self.clear = self.bottom, self.top, self.retract
        if not self.bottom < self.top or self.retract < self.top:
            raise given.error(
                "VP007",
                f"the bottom {self.bottom:g} lies below the reference plane {self.top:g}, and the retract plane "
                f"{self.retract:g} above it",
                "DP",
            )

    def _check_modes(self, modes: int) -> None:
        """Refuse _AMODE for the first of its digits that is not executed."""
        if not 0 <= modes < 100_000:
            raise self.given.error("VP002", f"_AMODE {modes} is not executed: it has at most five digits", "_AMODE")
        is_face, is_thread = self.name == "CYCLE61", self.name in ("CYCLE70", "CYCLE90")
        counts = (3, 1 if is_thread else 2, 1 if is_face or is_thread else 10, 1 + is_face, 1 + is_face)
        for digit, count, (place, what) in zip(self.digits, counts, _MODES, strict=True):
            if digit >= count:
                right = f"{what}; it must be 0{f' to {count - 1}' if count > 1 else ''}"
                text = f"_AMODE {modes} is not executed for {digit}, its {place} digit{right}"
                raise self.given.error("VP002", text, "_AMODE")
        if any(self.digits[3:]) and (self.measure("PA") or self.measure("PO")):
            text = (
                f"_AMODE {modes} is not executed where PA or PO is not 0: its thousands and ten thousands say "
                f"whether LENG and WID count from PA and PO, or from zero; write {modes % 1000}, "
                "and LENG and WID from PA and PO"
            )
            raise self.given.error("VP002", text, "_AMODE")

    def _read_feeds(self) -> dict[str, float]:
        given, plane = self.given, 0.0
        mode = given.read_whole("_DMODE") if "_DMODE" in given.names else 0
        if mode % 10 not in (0, self.to.state.plane + 1) or mode // 10 not in _DISPLAYS.get(self.name, _DISPLAY):
            raise given.error("VP002", f"_DMODE {mode} is not executed; it names the plane in force", "_DMODE")
        found = {}
        main = "FFR" if "FFR" in given.names else "FFP1"
        for pace, name in (("mill", main), ("plunge", "FFD"), ("finish", "FFP2")):
            value = given.number(name) if name in given.names else 0.0
            if value < 0:
                raise given.error("VP009", f"{name} {value:g}: a feed rate is not negative", name)
            found[pace] = plane = value * self.to.modes.feed or plane or self.to.state.feed
        if not found["mill"]:
            raise given.error("VP009", f"{main}, the feed rate in the plane, is needed, or F before", main)
        found["approach"] = found["thread"] = found["mill"]
        found["finish"] = found["finish"] if "FFP2" in given.names and given.number("FFP2") else found["mill"]
        return found

    def _find_radius(self) -> float:
        to = self.to
        number, selections = to.state.loaded_tool or 0, to.core.recorder.selections
        if number == 0 and selections and not selections[-1].is_loaded:
            raise report_unloaded(selections[-1], "the first feed move")
        if number == 0 or not to.modes.edge:
            why = f"needs the radius of {describe_tool_number(number, to.state.tool_names)}: write D1 before it"
            text = f"{self.name} {why}" if number else f"{self.name}: {to.core.tools.explain_empty_spindle()}"
            raise ProgramError("VP012", text, self.given.call.column).advise("")
        return 0.5 * to.core.tools.find_diameter(self.at, number, "")

    def refuse_digits(self, name: str, value: int, allowed_digits: Iterable[int], what: str) -> int:
        if value not in allowed_digits:
            raise self.given.error("VP002", f"{name} {self.given.read_whole(name)} is not executed: {what}", name)
        return value

    def plan(self, *, inside: bool = True) -> Milling:
        """How the values of the cycle mill."""
        given, name = self.given, self.name
        kind = given.read_whole("VARI")
        if kind < 0 or kind > 99:
            raise given.error("VP002", f"VARI {kind} is not executed: it has two digits", "VARI")
        work = self.refuse_digits(
            "VARI", kind % 10, (0, 1, 2, 4) if "DPR" in given.names and inside else (1, 2, 4), _WORK
        )
        tens = self.refuse_digits(
            "VARI", kind // 10, _TENS[name], "the tens are 0 and 1 straight down, 2 on a helix, 3 to and fro"
        )
        entry = _ENTRIES[tens]
        side, floor = (self.measure(one) if one in given.names else 0.0 for one in ("FAL", "FALD"))
        if (work == 0 and not side and not floor) or name == "LONGHOLE":
            work = 1
        most = self.measure("MID")
        levels: list[float] = []
        if work in (0, 1) and self.top - self.bottom - floor > ZERO_LENGTH_MM:
            levels = spread_levels(self.top, self.bottom + floor, most)
        infeed = self.measure("MIDF") if "MIDF" in given.names else most
        slope, pitch, helix = self._read_entry(entry)
        return Milling(
            self.radius,
            self.clear,
            levels,
            self.bottom,
            self.read_step(),
            self.read_sense(inside=inside),
            side,
            walls=spread_levels(self.top, self.bottom, infeed) if work in (2, 4) or (work == 0 and side) else (),
            floor=work in (0, 2) and floor > 0,
            entry=entry,
            slope=slope,
            pitch=pitch,
            helix=helix or self.radius,
            near=self.clear - self.top,
        )

    def _read_entry(self, entry: Entry) -> tuple[float, float, float]:
        """Slope of a swing, mm down in a mm, then the pitch and the radius of a helix, mm."""
        given = self.given
        angle = "STA2" if "STA2" in given.names else "RAD1"
        if entry == "swing":
            if not 0 < given.number(angle) < 90:
                raise given.error(
                    "VP007",
                    f"{angle} {given.number(angle):g}: the angle to plunge at is more than 0 and less than 90 degrees",
                    angle,
                )
            given.is_given("DP1")
            return math.tan(math.radians(given.number(angle))), 0.0, 0.0
        if entry == "helix":
            return 0.0, self.measure("DP1", positive=True), self.measure("RAD1", positive=True)
        for name in (angle, "DP1"):
            given.is_given(name)  # they say nothing where the tool plunges straight
        return 0.0, 0.0, 0.0

    def read_step(self) -> float:
        """The most that two paths are apart, mm."""
        given, diameter = self.given, 2.0 * self.radius
        width = given.number("MIDA") if "MIDA" in given.names else 0.0
        step = width / 100.0 * diameter if self.digits[1] else width * self.unit
        if width < 0 or step >= diameter:
            raise (width >= 0 and self.to.core.tools.report_stand_in(self.at)) or given.error(
                "VP007", f"MIDA {width:g}: paths are less than the diameter of the tool apart, {diameter:g} mm", "MIDA"
            )
        return step or _SHARE_OF_DIAMETER * diameter

    def read_sense(self, *, inside: bool) -> int:
        """1: counter-clockwise."""
        direction = self.given.read_whole("CDIR") if "CDIR" in self.given.names else 0
        if direction not in (0, 1, 2, 3):
            raise self.given.error("VP007", f"CDIR {direction}: 0 is climb, 1 up-cut, 2 G2, 3 G3", "CDIR")
        if direction >= 2:
            return 1 if direction == 3 else -1
        return (1 if direction == 0 else -1) * (1 if inside else -1) * (-1 if self.to.state.spindle_reversed else 1)
