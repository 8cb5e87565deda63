"""Where the part should stand on the table: the work offset with the largest margins, or the least time.

The points of the program are given on the part; a candidate place moves them to the table. The search samples places
around the best ones, in ranges that shrink. It uses the points that decide, and adds points that turn out to be worse.
Distances to limits are those of ``margins``; margins that no place changes do not count, or they would hide the others.
"""

from collections.abc import Callable
from typing import Final, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Mask
from verne_post.base.ragged import number_parts
from verne_post.base.rotations import rotate_z
from verne_post.base.suggestions import explain_names
from verne_post.base.text_tables import format_html_text
from verne_post.base.tolerances import MARGIN_CHANGE, TIED
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.findings import Finding
from verne_post.model.machine import Limits, Machine
from verne_post.model.part_setup import WorkOffset
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.evaluate import evaluate_coordinates
from verne_post.toolpath.margins import list_margin_functions

#: What a place is chosen for.
Aim = Literal["move", "margin", "time"]
#: Decimals of what is proposed, mm and degrees.
DECIMALS: Final = 3
#: Decimals of what is written: below them stand the errors of turning degrees into radians and back.
WRITTEN_DECIMALS: Final = 9
#: Points along a segment: at most this far apart, mm and rad, and no more than so many.
STEP_MM: Final = 10.0
STEP_ANGLE: Final = np.radians(3.0)
MOST_POINTS: Final = 64
#: Samples of the whole range, places that are improved from there, samples around each in a round, rounds, and the
#: share to which ranges shrink in a round.
SCATTERED: Final = 4096
FOLLOWED: Final = 8
AROUND: Final = 48
ROUNDS: Final = 40
SHRINK: Final = 0.82
#: Points to begin with, points added at a time, and how often.
FIRST_POINTS: Final = 200
ADDED: Final = 40
REFINEMENTS: Final = 12
#: Height over the table face that counts as plenty, mm.
PLENTY_MM: Final = 50.0
#: What is left of the cone of a joint that counts as plenty, degrees.
PLENTY_DEG: Final = 10.0
#: What a place is worth with poses out of reach: the share of them, below any margin.
UNREACHABLE: Final = -10.0
#: Least margin of a place of least time.
ENOUGH: Final = 0.02
#: Poses solved together.
BATCH: Final = 200_000


class Place(Struct, frozen=True):
    """Where the part zero stands on the table, mm, and how far the part is turned, ``c_deg`` or ``c_rad``."""

    x: float
    y: float
    z: float
    c_rad: float

    @property
    def c_deg(self) -> float:
        """How far the part is turned, degrees."""
        return self.c_rad / RAD_PER_DEG

    def pack_array(self) -> Array:
        """x, y, z (mm) and c (rad)."""
        return np.array([self.x, self.y, self.z, self.c_rad])


def make_offset(place: Place) -> WorkOffset:
    """The work offset of a place, its turn in degrees."""
    return WorkOffset((place.x, place.y, place.z), round(place.c_deg, WRITTEN_DECIMALS))


class PartPoints(Struct, frozen=True, eq=False):
    """Points of a program on the part, in order."""

    #: tip, angles (n, 3) and (n, 2): Tip (mm) and nominal A, C (rad) in the frame of the part.
    tip: Array
    angles: Array
    tool: Array  #: (n,): Tool length, mm.
    line: NDArray[np.int32]  #: (n,): Source line.
    seconds: Array  #: (n,): From the point before at the programmed feed rate.
    fresh: Mask  #: (n,): The motion stops between the point before and this one.

    def select(self, rows: NDArray[np.intp]) -> "PartPoints":
        """Some of them."""
        return PartPoints(*(column[rows] for column in asdict(self).values()))


def sample_part_points(path: ToolPath, place: Place, moved: ToolPath, other: Place, part_frame: Array) -> PartPoints:
    """Sample points along the segments of a path that are tied to the part.

    Parameters
    ----------
    path, moved : ToolPath
        The program with the part at ``place`` and at ``other``. What is not tied to the part, as positions in machine
        coordinates, does not move with it.
    part_frame : ndarray, shape (3, 3)
        Of the machine's coordinates.
    """
    _both, rows, twins = np.intersect1d(path.move, moved.move, return_indices=True)
    tied = np.ones(len(rows), dtype=bool)
    for name in ("start", "end"):
        here = _move_to_part(getattr(path, name)[rows], place, part_frame)
        there = _move_to_part(getattr(moved, name)[twins], other, part_frame)
        tied &= np.abs(here - there).max(axis=1, initial=0.0) < TIED
    kept = rows[tied & (path.kind[rows] != SegmentKind.JOINT)]
    swept = np.where(path.arc[kept] >= 0, np.abs(path.arcs.sweep[path.arc[kept]]) if len(path.arcs.sweep) else 0.0, 0.0)
    splined = np.flatnonzero(path.spline[kept] >= 0)
    swept[splined] = path.splines.turn[path.spline[kept[splined]]]
    turn = np.abs(path.end[kept, 3:] - path.start[kept, 3:]).sum(axis=1)
    wanted = np.max([path.length[kept] / STEP_MM, turn / STEP_ANGLE, 4 * swept], axis=0)
    parts = np.clip(np.ceil(wanted), 1, MOST_POINTS).astype(int)
    owner, index = number_parts(parts + 1)
    segment, parts = kept[owner], parts[owner]
    on_part = _move_to_part(evaluate_coordinates(path, segment, index / parts), place, part_frame)
    seconds = np.where(index > 0, path.feed_time[segment] / parts, 0.0)
    fresh = np.diff(path.section[segment], prepend=-1) != 0
    return PartPoints(on_part[:, :3], on_part[:, 3:], path.tool_length[segment], path.line[segment], seconds, fresh)


def _move_to_part(poses: Array, place: Place, part_frame: Array) -> Array:
    """Poses (n, 5) of the table frame in the frame of a part at a place."""
    moved = poses.copy()
    moved[:, :3] = rotate_z(poses[:, :3] @ part_frame - [place.x, place.y, place.z], -place.c_rad)
    moved[:, 4] += place.c_rad
    return moved


class Fit(Struct, frozen=True, eq=False):
    """A place, and the smallest margins (k,) there with their lines; ``counts`` marks those that depend on it."""

    place: Place
    margins: Array
    lines: NDArray[np.int32]
    counts: Mask
    names: tuple[str, ...]

    @property
    def smallest(self) -> float:
        """The smallest margin that depends on the place, minus infinity where something is out of reach."""
        return float(self.margins[self.counts].min())

    @property
    def nearest(self) -> int:
        """Which margin that is."""
        return int(np.argmin(np.where(self.counts, self.margins, np.inf)))


class Room(Struct, frozen=True, eq=False):
    """Where on the table the middle of what is cut may be: boxes alone would let a turn carry a part off the table."""

    middle: Array  #: (3,): On the part, mm; z 0.
    reach: float  #: How far the part goes from there, mm.
    low: Array
    high: Array  #: (2,): Of x and y on the table, part frame, mm; infinite where a range of the zero is given.

    def find_middle(self, turn: Array) -> Array:
        """The middle (n, 2) from the zero of parts turned by ``turn`` (n,), rad."""
        return rotate_z(np.broadcast_to(self.middle, (*np.shape(turn), 3)), turn)[..., :2]


@explain_names()
class Proposal(Struct, frozen=True, eq=False):
    """Where the part stands now, a place for it, and the findings of the whole program there.

    Attributes
    ----------
    wcs : dict
        The work offset to be set, by the number of its system, in mm and degrees: ``options.changed(wcs=p.wcs)``.
    system : int
        Number of the work system that moves.
    aim : {"move", "margin", "time"}
        What the place was chosen for: the smallest move, the largest margin, or the least time.
    findings : tuple of Finding
        Of the whole program at the place.
    seconds_before, seconds : float or None
        Machining time where the part is and at the place, s; None where the program cannot run there.
    before, after, largest : Fit
        The place of now, the one that is proposed, and that of the largest margin: ``after.place`` has x, y, z in mm
        and ``c_deg``, ``after.smallest`` is the smallest margin there.
    ranges : dict
        What was searched, (low, high) by the letter of each free coordinate, mm and degrees.
    turns : bool
        A joint of the machine turns the part about its z.
    g10 : str
        The language whose G10 sets work systems; empty where the program is in one without G10.
    fixed_lines : tuple of int
        Lines in machine coordinates with errors, which no work offset moves; margins do not count them.
    carried_lines : tuple of int
        Lines in which the tool or the spindle touches what moves with the part: no work offset parts them, and none
        was sought.
    cause : str
        Why the program is refused, and what to write, where a warning says that another motion is meant. A place is
        sought only where errors begin before that motion (``is_sought``). Or that lines in machine coordinates
        keep an angle of a line before. Else empty.
    room : Room or None
        Where on a table the middle of what is cut was sought; None on a machine without a table.
    refused : Place or None
        The place of the largest margin or the least time, where the check refuses it and ``after`` is the smallest
        move instead.
    largest_fits : bool
        Whether the check of the whole program accepts the place of the largest margin; False where none fits.
    text : str
        What ``fit`` says of it: what is printed.
    """

    system: int
    aim: Aim
    before: Fit
    after: Fit
    findings: tuple[Finding, ...]
    seconds_before: float | None
    seconds: float | None
    largest: Fit
    ranges: dict[str, tuple[float, float]]
    turns: bool = True
    g10: str = "rs274"
    fixed_lines: tuple[int, ...] = ()
    carried_lines: tuple[int, ...] = ()
    cause: str = ""
    room: Room | None = None
    refused: Place | None = None
    largest_fits: bool = True
    text: str = ""

    @property
    def is_sought(self) -> bool:
        """Whether another place was sought."""
        return self.largest is not self.before

    @property
    def wcs(self) -> dict[int, WorkOffset]:
        """The work offset to be set, by the number of its system."""
        return {self.system: make_offset(self.after.place)}

    def __repr__(self) -> str:
        return self.text or super().__repr__()

    def _repr_html_(self) -> str:
        return format_html_text(repr(self))


class Search:
    """The places of one program on one machine.

    Parameters
    ----------
    free : ndarray of bool, shape (4,)
        Which of x, y, z, c may change.
    low, high : ndarray, shape (4,)
        Range of x, y, z (mm) and c (rad).
    room : Room, optional
        On a table.
    """

    def __init__(
        self, machine: Machine, points: PartPoints, free: Mask, low: Array, high: Array, room: Room | None = None
    ) -> None:
        self.machine, self.points, self.free, self.low, self.high = machine, points, free, low, high
        self.room = room
        self.margins, names = list_margin_functions(machine, PLENTY_DEG)
        self.names = (*names, "height over the table face") if machine.table_radius else names

    def evaluate(self, place: Place, counts: Mask | None = None) -> Fit:
        """The margins of a place over all points."""
        table = self._measure_margins(place.pack_array()[None], self.points)
        margins = table[0].min(axis=0)
        lines = self.points.line[table[0].argmin(axis=0)]
        return Fit(place, margins, lines, np.ones(len(margins), bool) if counts is None else counts, self.names)

    def find_best(self, start: Place, notify: Callable[[int, int], None] | None = None) -> Fit:
        """The place with the largest smallest margin; ``notify`` gets done and total."""
        random = np.random.default_rng(0)  # the same program has the same fit
        scattered = self.draw_places(random, SCATTERED, self.low, self.high)
        scattered[:, ~self.free] = start.pack_array()[~self.free]
        scattered[0] = self.keep_inside(start.pack_array(), self.low, self.high)
        rows = self.choose_first_rows()
        smallest, lost = self._find_smallest(scattered, rows)
        with np.errstate(invalid="ignore"):
            reached = np.isfinite(smallest).all(axis=1)
            counts = (
                np.ptp(smallest[reached], axis=0) > MARGIN_CHANGE
                if reached.sum() > 1
                else np.ones(smallest.shape[1], bool)
            )
        if not counts.any():
            counts[:] = True
        best = scattered[np.argsort(-_rate_places(smallest, lost, counts), kind="stable")[:FOLLOWED]]
        for done in range(REFINEMENTS):
            if notify is not None:
                notify(done, REFINEMENTS)
            best = self._improve(best, rows, counts, random)
            worse = self.find_worst_rows(best[0])
            if np.isin(worse, rows).all():
                break
            rows = np.union1d(rows, worse)
        x, y, z, c = best[0].tolist()
        return self.evaluate(Place(x, y, z, c), counts)

    def holds(self, place: Place) -> bool:
        """Whether a place lies in the range."""
        return self.is_inside(place.pack_array())

    def is_inside(self, place: Array) -> bool:
        """The same of a place (4,)."""
        return bool(np.abs(self.keep_inside(place, self.low, self.high) - place).max() < TIED)

    def draw_places(self, random: np.random.Generator, n: int, low: Array, high: Array) -> Array:
        """Places (n, 4) all over the range from ``low`` to ``high`` (4,)."""
        share = random.random((n, 4))
        places = low + share * (high - low)
        if self.room is not None:
            bounded = np.isfinite(self.room.low) & np.isfinite(self.room.high)
            middle = self.room.find_middle(places[:, 3])[:, bounded]
            first, last = self.room.low[bounded], self.room.high[bounded]
            places[:, :2][:, bounded] = first + share[:, :2][:, bounded] * (last - first) - middle
        return self.keep_inside(places, low, high)

    def keep_inside(self, places: Array, low: Array, high: Array) -> Array:
        """Places (..., 4), those outside of the range from ``low`` to ``high`` (4,) or of the room moved inside."""
        kept = np.clip(places, low, high)
        if self.room is not None:
            middle = self.room.find_middle(kept[..., 3])
            kept[..., :2] = np.clip(kept[..., :2] + middle, self.room.low, self.room.high) - middle
        return np.asarray(np.clip(kept, low, high))

    def choose_first_rows(self) -> NDArray[np.intp]:
        """Points to begin with, spread over the program."""
        return np.unique(np.linspace(0, len(self.points.tip) - 1, FIRST_POINTS).astype(np.intp))

    def find_worst_rows(self, place: Array) -> NDArray[np.intp]:
        """Of every margin, the points that are worst at a place (4,)."""
        table = self._measure_margins(place[None], self.points)[0]
        return np.unique(np.argsort(table, axis=0)[: max(ADDED // table.shape[1], 1)])

    def rate(self, places: Array, counts: Mask, rows: NDArray[np.intp] | None = None) -> Array:
        """The smallest margin (n,) of places (n, 4) over points ``rows``; below any margin where out of reach."""
        every = np.arange(len(self.points.tip)) if rows is None else rows
        return _rate_places(*self._find_smallest(places, every), counts)

    def find_deciding_rows(self, places: Array, counts: Mask, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """Those of ``rows`` that have a smallest margin at one of the places (n, 4)."""
        table = self._measure_margins(places, self.points.select(rows))
        return rows[np.unique(table.argmin(axis=1)[:, counts])]

    def rate_promising(
        self, places: Array, counts: Mask, rows: NDArray[np.intp], few: NDArray[np.intp], floor: Array
    ) -> Array:
        """Rate places (n, 4) as :meth:`rate` does, but those below ``floor`` (n,) at some of ``few`` rows by these
        alone: more rows can only make a place worse. Where all is out of reach the share of it decides, and all rows
        are asked.
        """
        worth = self.rate(places, counts, few)
        asked = (worth >= floor) | (floor <= UNREACHABLE)
        if asked.any():
            worth[asked] = self.rate(places[asked], counts, rows)
        return worth

    def _improve(self, best: Array, rows: NDArray[np.intp], counts: Mask, random: np.random.Generator) -> Array:
        """Improve places by samples around each in ranges that shrink; returns them best first."""
        width = 0.25 * (self.high - self.low) * self.free
        worth = self.rate(best, counts, rows)
        for _ in range(ROUNDS):
            around = best[:, None] + width * random.uniform(-1, 1, (len(best), AROUND, 4))
            around = self.keep_inside(around, self.low, self.high)
            around[..., ~self.free] = best[0, ~self.free]
            few = self.find_deciding_rows(best, counts, rows)
            value = self.rate_promising(around.reshape(-1, 4), counts, rows, few, np.repeat(worth, AROUND))
            value = value.reshape(len(best), AROUND)
            top = value.argmax(axis=1)
            each = np.arange(len(best))
            better = value[each, top] > worth
            best[better], worth[better] = around[each, top][better], value[each, top][better]
            width = width * SHRINK
        return best[np.argsort(-worth, kind="stable")]

    def find_fastest(self, best: Fit) -> Fit:
        """The place of least time among samples around one of large margin, with enough of it."""
        random, counts = np.random.default_rng(0), best.counts
        width = 0.5 * (self.high - self.low) * self.free
        place = best.place.pack_array()
        time, rows = self._estimate_seconds(place), np.union1d(self.choose_first_rows(), self.find_worst_rows(place))
        for _ in range(ROUNDS):
            around = self.keep_inside(place + width * random.uniform(-1, 1, (AROUND, 4)), self.low, self.high)
            around[:, ~self.free] = place[~self.free]
            legal = self.rate(around, counts, rows) >= ENOUGH
            for candidate in around[legal]:
                seconds = self._estimate_seconds(candidate)
                if seconds < time and self.rate(candidate[None], counts)[0] >= ENOUGH:
                    place, time = candidate, seconds
            width = width * SHRINK
        x, y, z, c = place.tolist()
        return self.evaluate(Place(x, y, z, c), counts)

    def _find_smallest(self, places: Array, rows: NDArray[np.intp]) -> tuple[Array, Array]:
        """Smallest value (n, k) of every margin at places (n, 4) over points ``rows``; their share out of reach."""
        points = self.points.select(rows)
        each = max(BATCH // max(len(rows), 1), 1)
        smallest, lost = [], []
        for first in range(0, len(places), each):
            table = self._measure_margins(places[first : first + each], points)
            lost.append(np.isinf(table[..., 0]).mean(axis=1))
            smallest.append(table.min(axis=1))
        return np.concatenate(smallest), np.concatenate(lost)

    def _measure_margins(self, places: Array, points: PartPoints) -> Array:
        """Margins (n, m, k) of m points at n places; minus infinity out of reach."""
        n, m = len(places), len(points.tip)
        tip, angles, tool = self._place_points(places, points)
        margins = self.margins(tip, angles, tool)
        if not self.machine.table_radius:
            return margins.reshape(n, m, -1)
        inside = np.hypot(tip[:, 0], tip[:, 1]) < self.machine.table_radius
        height = np.where(inside, np.minimum(tip[:, 2] / PLENTY_MM, 1.0), 1.0)
        return np.concatenate([margins, height[:, None]], axis=1).reshape(n, m, -1)

    def _place_points(self, places: Array, points: PartPoints) -> tuple[Array, Array, Array]:
        """Tips, angles and tool lengths (n m) on the table."""
        n, m = len(places), len(points.tip)
        place = np.repeat(places, m, axis=0)
        tip = rotate_z(np.tile(points.tip, (n, 1)), place[:, 3]) + place[:, :3]
        tip = tip @ self.machine.coordinates.part_frame.T
        angles = np.tile(points.angles, (n, 1))
        angles[:, 1] -= place[:, 3]
        return tip, angles, np.tile(points.tool, n)

    def _estimate_seconds(self, place: Array) -> float:
        """Estimate the machining time from below: by the feed, and by velocity and acceleration between the points."""
        points = self.points
        q = self.machine.five_axis.solve(*self._place_points(place[None], points))[0]
        limits: Limits = self.machine.limits
        step = np.abs(np.diff(q, axis=0, prepend=q[:1]))
        bend = np.abs(np.diff(q, 2, axis=0, prepend=q[:1], append=q[-1:]))
        bend[points.fresh] = 0.0
        by_speed = (step / limits.velocity).max(axis=1)
        by_bend = np.sqrt((bend / limits.acceleration).max(axis=1))
        seconds = np.maximum(points.seconds, np.maximum(by_speed, by_bend))
        return float(np.where(points.fresh, 0.0, seconds).sum()) if np.isfinite(q).all() else np.inf


def _rate_places(smallest: Array, lost: Array, counts: Mask) -> Array:
    """Rate places (n,) by their smallest margin; those with poses out of reach come below, by the share of these."""
    inside = np.where(np.isfinite(smallest), smallest, 0.0)[:, counts].min(axis=1)
    return np.where(lost > 0, UNREACHABLE - lost, inside)
