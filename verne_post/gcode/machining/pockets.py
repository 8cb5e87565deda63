"""Milling cycles: the moves that mill a pocket, a slot, a stud or a face, for every language.

A language turns its parameters into an outline and a :class:`Milling`, and executes the strokes. The manuals of
controls define depth, wall, allowances, infeeds, retract heights, kind of plunge, climb or up-cut. The order of the
strokes is ours, since no manual gives it: from the middle outwards, on paths beside the outline.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Final, Literal

from msgspec import Struct

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.outlines import ROUNDING_SHARE, Leg, Outline, Path, PocketOutline, spread_offsets
from verne_post.gcode.machining.plane_geometry import Point, turn_way
from verne_post.gcode.machining.strokes import Pace, Stroke

#: Strokes that the cycles of one block may have: more is a wrong infeed.
MAX_STROKES: Final = 30_000
#: Largest distance of paths in a pocket, in radii of the tool. In a right-angled corner a place is up to s / (1 +
#: sqrt(0.5)) from two sharp paths that are s apart; this is less than the radius up to 1.707.
_CORNER_STEP: Final = 1.7
#: Widest way to and fro while the tool plunges, in diameters of the tool.
_SWING_DIAMETERS: Final = 2.0
_HALF_TURN: Final = 180.0

Entry = Literal["straight", "helix", "swing"]


class Milling(Struct, frozen=True):
    """How an outline is milled. Heights along the normal of the plane, mm, upwards."""

    radius: float  #: Of the tool.
    clear: float  #: Where rapid traverse towards the part ends.
    levels: Sequence[float]  #: Heights at which the roughing clears, downwards; empty: no roughing.
    bottom: float  #: The finished floor.
    step: float  #: The most that two paths beside each other are apart.
    #: 1: counter-clockwise, which is climb milling in a pocket with a spindle that turns clockwise; -1 the other
    #: way.
    sense: int = 1
    side: float = 0.0  #: Allowance that the roughing leaves on the wall.
    walls: Sequence[float] = ()  #: Heights of the finishing passes along the wall, downwards; empty: none.
    floor: bool = False  #: The floor is finished.
    #: How the tool plunges: "straight" down, "helix" and "swing" (to and fro along the middle line).
    entry: Entry = "straight"
    slope: float = 0.0  #: Mm down in a mm of the way of a helix or swing.
    pitch: float = 0.0  #: Mm down in a turn of the helix; 0: as ``slope`` has it.
    helix: float = math.inf  #: Radius of the helix, mm; less where the pocket has no room for it.
    near: float = 0.0  #: Rapid traverse into what is milled already ends so far above it.

    def lead_in(self, height: float) -> float:
        """The height above a milled one at which rapid traverse ends."""
        return min(height + self.near, self.clear)


class MillingError(ValueError):
    """What is to be milled cannot be, in words: most often the tool is too wide."""


def spread_levels(top: float, bottom: float, most: float) -> list[float]:
    """Heights of as few equal infeeds as keep to the largest one; 0: in one."""
    count = count_infeeds(top - bottom, most)
    return [top - (top - bottom) * number / count for number in range(1, count)] + [bottom]


def list_levels(top: float, bottom: float, most: float) -> list[float]:
    """Heights of infeeds of the largest size, the last one what is left; 0: in one."""
    count = count_infeeds(top - bottom, most)
    return [top - most * number for number in range(1, count)] + [bottom]


def count_infeeds(depth: float, most: float) -> int:
    """How many infeeds of the largest size a depth takes; 0: one."""
    count = math.ceil(depth / most - ROUNDING_SHARE) if most > 0 else 1
    if count > MAX_STROKES:
        raise MillingError(f"{count} infeeds are more than the {MAX_STROKES} strokes that a cycle may have")
    return max(count, 1)


# --- pockets and slots -----------------------------------------------------------------------------------


def mill_pocket(outline: PocketOutline, milling: Milling) -> Iterator[Stroke]:
    """Strokes of a pocket or slot, from above its middle, where the tool stands at the clearance, to there.

    Parameters
    ----------
    outline : PocketOutline
        The finished wall, local coordinates, mm.
    milling : Milling

    Yields
    ------
    Stroke
        Local coordinates, mm.

    Raises
    ------
    MillingError
        The tool does not fit.
    """
    rough = _spread_inwards(outline, milling, milling.radius + milling.side) if milling.levels else []
    fine = _spread_inwards(outline, milling, milling.radius) if milling.walls or milling.floor else []
    _refuse_many(rough, milling, fine)
    room = outline.inradius - milling.radius - (milling.side if milling.levels else 0.0)
    middle = (rough or fine)[0].start
    yield Stroke(middle, milling.clear, "rapid")
    top = milling.clear
    for level in milling.levels:
        yield Stroke(middle, top, "rapid")
        yield from _lead_down(outline, milling, middle, room, top, level)
        yield from _follow_all(rough, level, "mill")
        top = milling.lead_in(level)
        yield Stroke(rough[-1].end, top, "rapid")
        yield Stroke(middle, top, "rapid")
    yield Stroke(middle, milling.clear, "rapid")
    if milling.walls:
        yield from _finish_wall(fine[-1], milling, min(milling.radius, outline.inradius - milling.radius))
        yield Stroke(middle, milling.clear, "rapid")
    if milling.floor:
        yield Stroke(middle, milling.lead_in(milling.levels[-1] if milling.levels else milling.bottom), "rapid")
        yield Stroke(middle, milling.bottom, "plunge")
        yield from _follow_all(fine, milling.bottom, "finish")
        yield Stroke(fine[-1].end, milling.clear, "rapid")
        yield Stroke(middle, milling.clear, "rapid")


def _spread_inwards(outline: PocketOutline, milling: Milling, wall: float) -> list[Path]:
    """Paths of the tool's centre from the middle line of a pocket to ``wall`` mm before its outline."""
    if outline.inradius - wall < -ZERO_LENGTH_MM:
        raise MillingError(
            f"it is {2 * outline.inradius:g} mm wide inside, and the tool of {2 * milling.radius:g} mm"
            + (f" with an allowance of {wall - milling.radius:g} mm a side" if wall > milling.radius else "")
            + " has no room in it"
        )
    inmost = max(outline.inradius, wall)
    step = min(milling.step, _CORNER_STEP * milling.radius)
    _check_count((inmost - wall) / step)
    paths = [outline.lead_beside(inward) for inward in spread_offsets(inmost, wall, step)]
    return paths if milling.sense > 0 else [path.turn_round() for path in paths]


def _check_count(count: float) -> None:
    if count > MAX_STROKES:
        raise MillingError(f"{count:.0f} paths are more than the {MAX_STROKES} strokes that a cycle may have")


def _refuse_nothing(milling: Milling) -> None:
    if not (milling.levels or milling.walls or milling.floor):
        raise MillingError("nothing is left to mill: the allowance of the floor is the whole depth")


def _refuse_many(rough: list[Path], milling: Milling, fine: list[Path]) -> None:
    _refuse_nothing(milling)
    legs = sum(len(path.legs) + 1 for path in rough) * len(milling.levels)
    last = len(fine[-1].legs) + 4 if fine else 0
    _check_count(legs + last * len(milling.walls) + (sum(len(path.legs) + 1 for path in fine) if milling.floor else 0))


def _lead_down(
    outline: PocketOutline, milling: Milling, middle: Point, room: float, top: float, level: float
) -> Iterator[Stroke]:
    """From ``top`` above the middle of the pocket down to a level, back to the middle."""
    if milling.entry == "straight":
        yield Stroke(middle, level, "plunge")
    elif milling.entry == "helix":
        radius = min(milling.helix, room)
        if radius <= ZERO_LENGTH_MM:
            raise MillingError("the tool has no room to plunge on a helix; let it plunge straight, or to and fro")
        yield from _lead_on_helix(middle, radius, milling, top, level)
        yield Stroke(middle, level, "mill")
    else:
        yield from _lead_to_and_fro(outline.lead_along(room), milling, middle, top, level)


def _lead_on_helix(center: Point, radius: float, milling: Milling, top: float, level: float) -> Iterator[Stroke]:
    """Half turns about a place, down to a level."""
    ends = ((center[0] - radius, center[1]), (center[0] + radius, center[1]))
    yield Stroke(ends[1], top, "rapid")
    pitch = milling.pitch or milling.slope * 2 * math.pi * radius
    count = 2 * max(math.ceil((top - level) / pitch - ROUNDING_SHARE), 1)
    _check_count(count)
    for number in range(1, count + 1):
        height = level if number == count else top + (level - top) * number / count
        yield Stroke(ends[(number + 1) % 2], height, "plunge", center, milling.sense * 180.0)


def _lead_to_and_fro(whole: Path, milling: Milling, middle: Point, top: float, level: float) -> Iterator[Stroke]:
    """To and fro along the middle line, down to a level, then back to the middle."""
    way = _shorten(whole, 2 * _SWING_DIAMETERS * milling.radius)
    if way.length <= ZERO_LENGTH_MM:
        raise MillingError("the tool has no room to plunge to and fro; let it plunge straight")
    count = max(math.ceil((top - level) / (milling.slope * way.length) - ROUNDING_SHARE), 1)
    _check_count(count)
    yield from _go_along(whole, way, middle, top, "rapid")
    for number in range(1, count + 1):
        height = level if number == count else top + (level - top) * number / count
        leg = (way if number % 2 else way.turn_round()).legs[0]
        yield Stroke(leg.end, height, "plunge", leg.center, leg.sweep)
    yield from _go_along(whole, way if count % 2 == 0 else way.turn_round(), middle, level, "mill", back=True)


def _go_along(
    whole: Path, way: Path, middle: Point, height: float, pace: Pace, *, back: bool = False
) -> Iterator[Stroke]:
    """Along the middle line between the middle of a pocket and the begin of a swing."""
    leg = whole.legs[0]
    if leg.center is None:
        yield Stroke(middle if back else way.start, height, pace)
        return
    # on a curved slot the middle of the path beside the wall, and the middle line, share their angle
    first, last = (way.start, middle) if back else (middle, way.start)
    turn = math.atan2(last[1], last[0]) - math.atan2(first[1], first[0])
    turn = math.degrees((turn + math.pi) % (2 * math.pi) - math.pi)
    if abs(turn) > 0.0:
        yield Stroke(last, height, "mill" if pace == "rapid" else pace, leg.center, turn)


def _shorten(path: Path, most: float) -> Path:
    """The part of a path of one leg about its middle that is no longer than ``most`` mm."""
    share = min(most / path.length, 1.0) if path.length > 0 else 1.0
    leg, start = path.legs[0], path.start
    if share >= 1.0:
        return path
    if leg.center is None:
        middle = (0.5 * (start[0] + leg.end[0]), 0.5 * (start[1] + leg.end[1]))
        ends = [
            (middle[0] + share * (end[0] - middle[0]), middle[1] + share * (end[1] - middle[1]))
            for end in (start, leg.end)
        ]
        return Path(ends[0], (Leg(ends[1]),))
    rest = 0.5 * (1.0 - share) * leg.sweep
    first, last = (turn_way((0.0, 0.0), end, angle) for end, angle in ((start, rest), (leg.end, -rest)))
    return Path(first, (Leg(last, leg.center, share * leg.sweep),))


def _follow_all(paths: Iterable[Path], height: float, pace: Pace) -> Iterator[Stroke]:
    """Paths one after the other at a height, straight from the end of one to the start of the next."""
    for path in paths:
        yield Stroke(path.start, height, pace)
        yield from _follow(path, height, pace)


def _follow(path: Path, height: float, pace: Pace) -> Iterator[Stroke]:
    for leg in path.legs:
        yield Stroke(leg.end, height, pace, leg.center, leg.sweep)


def _finish_wall(path: Path, milling: Milling, room: float) -> Iterator[Stroke]:
    """Passes along a wall, each from and to a place inside it on quarter circles of the radius ``room``, mm."""
    arcs = _find_quarters(path, room, outward=False, sense=milling.sense)
    begin = arcs[0].start
    yield Stroke(begin, milling.clear, "rapid")
    for number, level in enumerate(milling.walls):
        if number:
            yield Stroke(begin, milling.lead_in(milling.walls[number - 1]), "rapid")
        yield Stroke(begin, level, "plunge")
        yield from _follow(arcs[0], level, "finish")
        yield from _follow(path, level, "finish")
        yield from _follow(arcs[1], level, "finish")
        yield Stroke(arcs[1].end, milling.lead_in(level), "rapid")
    yield Stroke(arcs[1].end, milling.clear, "rapid")


def _find_quarters(path: Path, radius: float, *, outward: bool, sense: int) -> tuple[Path, Path]:
    """Quarter circles that lead tangentially onto a closed path at its start, and away from it."""
    start = path.start
    if radius <= ZERO_LENGTH_MM or not path.legs:
        return Path(start, ()), Path(start, ())
    t = _begin_direction(path)
    side = (-sense if outward else sense) * 1.0  # the side of the path on which the tool waits: left for 1
    n = (-side * t[1], side * t[0])
    center = (start[0] + radius * n[0], start[1] + radius * n[1])
    before, after = ((center[0] + sign * radius * t[0], center[1] + sign * radius * t[1]) for sign in (-1.0, 1.0))
    return Path(before, (Leg(start, center, side * 90.0),)), Path(start, (Leg(after, center, side * 90.0),))


def _begin_direction(path: Path) -> Point:
    start, leg = path.start, path.legs[0]
    du, dv = (leg.end[0] - start[0], leg.end[1] - start[1])
    if leg.center is not None:
        sign = math.copysign(1.0, leg.sweep)
        du, dv = -sign * (start[1] - leg.center[1]), sign * (start[0] - leg.center[0])
    size = math.hypot(du, dv)
    return du / size, dv / size


# --- studs -------------------------------------------------------------------------------------------------


def mill_stud(outline: Outline, milling: Milling, reach: float, blank: float) -> Iterator[Stroke]:
    """Strokes of a stud, from outside of its blank inwards, to there.

    Parameters
    ----------
    outline : Outline
        The finished stud, local coordinates, mm.
    milling : Milling
        ``sense``: 1 goes round it counter-clockwise.
    reach : float
        How far the blank stands out from the stud at most, mm.
    blank : float
        How far it stands out where the paths begin, mm: there the tool plunges beside it.
    """
    radius = milling.radius
    last = radius + milling.side
    first = max(last + max(reach - milling.side, 0.0) - milling.step, last)
    _check_count((first - radius) / milling.step)
    rough, fine = (
        [outline.lead_beside(-away) for away in spread_offsets(first, wall, milling.step)] if levels else []
        for wall, levels in ((last, milling.levels), (radius, (*milling.walls, milling.floor)))
    )
    if milling.sense < 0:
        rough, fine = [path.turn_round() for path in rough], [path.turn_round() for path in fine]
    _refuse_many(rough, milling, fine)
    for level in milling.levels:
        yield from _go_round(rough, level, milling, blank, "mill")
    for level in milling.walls:
        yield from _go_round(fine[-1:], level, milling, blank, "finish")
    if milling.floor:
        yield from _go_round(fine, milling.bottom, milling, blank, "finish")


def _go_round(paths: list[Path], level: float, milling: Milling, blank: float, pace: Pace) -> Iterator[Stroke]:
    """Plunge outside of the blank, lead onto the outermost path, go round on all of them, and lead away."""
    away = -paths[0].start[1]
    beside = max(blank + milling.radius + milling.near - away, milling.radius)
    lead_in = _find_quarters(paths[0], beside, outward=True, sense=milling.sense)[0]
    lead_out = _find_quarters(paths[-1], max(beside, milling.radius), outward=True, sense=milling.sense)[1]
    yield Stroke(lead_in.start, milling.clear, "rapid")
    yield Stroke(lead_in.start, level, "plunge")
    yield from _follow(lead_in, level, pace)
    yield from _follow_all(paths, level, pace)
    yield from _follow(lead_out, level, pace)
    yield Stroke(lead_out.end, milling.clear, "rapid")


# --- slots that are open at both ends ------------------------------------------------------------------------


def mill_open_slot(length: float, width: float, milling: Milling) -> Iterator[Stroke]:
    """Strokes of a slot along u about 0 that is open at both ends; the tool goes down outside of it.

    It is roughed on loops as wide as the slot, each ``milling.step`` further, so that the tool never cuts with its
    whole width. On the next level it comes back from the other end.

    Parameters
    ----------
    length, width : float
        Mm; beyond the length there is no stock.
    milling : Milling

    Raises
    ------
    MillingError
        The tool does not fit.
    """
    _refuse_nothing(milling)
    room = 0.5 * width - milling.radius
    if room < -ZERO_LENGTH_MM or (milling.levels and room - milling.side <= ZERO_LENGTH_MM):
        raise MillingError(
            f"it is {width:g} mm wide, and the tool of {2 * milling.radius:g} mm has no room to circle in it"
            if milling.levels
            else f"it is {width:g} mm wide, narrower than the tool of {2 * milling.radius:g} mm"
        )
    room, end = max(room, 0.0), 0.5 * length + milling.radius + milling.near
    way = 1
    for level in milling.levels:
        yield from _mill_in_loops(0.5 * length, end, room - milling.side, level, way, milling)
        way = -way
    lines = [(-end, -room), (end, -room), (end, room), (-end, room)]
    if milling.sense < 0:
        lines = [(u, -v) for u, v in lines]
    for level in milling.walls:
        yield from _go_outside(lines, level, milling)
    if milling.floor:
        rows = list(spread_offsets(-room, room, _CORNER_STEP * milling.radius))
        ways = [(-end, end), (end, -end)]
        path = [(u, row) for number, row in enumerate(rows) for u in ways[number % 2]]
        yield from _go_outside(path, milling.bottom, milling)


def _mill_in_loops(half: float, end: float, room: float, level: float, way: int, milling: Milling) -> Iterator[Stroke]:
    """Loops of half circles of the radius ``room`` from outside of one end to the other, then out along a wall.

    A loop goes on along one wall, cuts on its front half circle, and comes back along the other wall, so that no
    cusps stay on it.
    """
    begin, wall, half_turn = -way * (end + room), -milling.sense * way * room, milling.sense * _HALF_TURN
    count = math.ceil(abs(way * half - begin) / milling.step - ROUNDING_SHARE)
    _check_count((4 * count + 4) * len(milling.levels))
    middles = [begin + (way * half - begin) * number / count for number in range(count + 1)]
    yield Stroke((begin, wall), milling.clear, "rapid")
    yield Stroke((begin, wall), level, "plunge")
    for back, front in pairwise(middles):
        yield Stroke((front, wall), level, "mill")
        yield Stroke((front, -wall), level, "mill", (front, 0.0), half_turn)
        yield Stroke((back, -wall), level, "mill")
        yield Stroke((back, wall), level, "mill", (back, 0.0), half_turn)
    yield Stroke((way * end, wall), level, "mill")
    yield Stroke((way * end, wall), milling.clear, "rapid")


def _go_outside(path: list[Point], level: float, milling: Milling) -> Iterator[Stroke]:
    """Straight lines that begin and end outside of the slot."""
    yield Stroke(path[0], milling.clear, "rapid")
    yield Stroke(path[0], level, "plunge")
    for place in path[1:]:
        yield Stroke(place, level, "finish")
    yield Stroke(path[-1], milling.clear, "rapid")


# --- faces ----------------------------------------------------------------------------------------------------


class Face(Struct, frozen=True):
    """A face of ``length`` along the strokes and ``width`` across, from 0; strokes go ``overrun`` beyond it, mm."""

    length: float
    width: float
    overrun: float
    zigzag: bool = True


def mill_face(face: Face, milling: Milling) -> Iterator[Stroke]:
    """Straight strokes over a face, level by level; the tool goes down beside it, where the first stroke begins.

    The strokes are evenly spread: the first takes as much as the others, and the last reaches the far edge exactly.
    """
    count = max(math.ceil(face.width / milling.step - ROUNDING_SHARE), 1)
    _check_count((count * 3 + 3) * max(len(milling.levels), 1))
    _refuse_nothing(milling)
    rows = [face.width * (row + 1) / count - milling.radius for row in range(count)]
    ends = (-face.overrun, face.length + face.overrun)
    passes: list[tuple[float, Pace]] = [(level, "mill") for level in milling.levels]
    if milling.floor:
        passes.append((milling.bottom, "finish"))
    for level, pace in passes:
        yield Stroke((ends[0], rows[0]), milling.clear, "rapid")
        yield Stroke((ends[0], rows[0]), level, "plunge")
        for row, across in enumerate(rows):
            begin, end = ends if not face.zigzag or row % 2 == 0 else ends[::-1]
            if row and not face.zigzag:
                yield Stroke((ends[1], rows[row - 1]), milling.clear, "rapid")
                yield Stroke((begin, across), milling.clear, "rapid")
                yield Stroke((begin, across), level, "plunge")
            yield Stroke((begin, across), level, pace)
            yield Stroke((end, across), level, pace)
        yield Stroke((end, rows[-1]), milling.clear, "rapid")
