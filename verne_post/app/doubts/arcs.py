"""Arcs of half a turn and more that meet both neighbours at an angle, where another arc would continue them."""

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.machining.machining import OTHER_PLANE
from verne_post.gcode.machining.plane_geometry import Point, find_tangent
from verne_post.model.findings import Finding, add_line, make_finding
from verne_post.model.moves import MoveKind, Moves

#: As directions of unit length differ: a degree.
_NEARLY: Final = math.radians(1.0)
#: Centres are rounded, and half a turn may be a little less.
_HALF_TURN_DEG: Final = 179.9
#: Radii of arcs that repeat differ by rounding, mm.
_SAME_MM: Final = 0.01
#: How words of a language say the sense of an arc, and its radius.
_SENSES: Final = {
    "heidenhain": "DR+ or DR-",
    "aptcl": "the axis of CIRCLE the other way",
}
_RADII: Final = {"siemens": "CR"}


def check_arcs(moves: Moves, from_move: int = 0) -> Iterator[Finding]:
    """VP056: one finding for the senses, and one for the signs of radii, that are in doubt from a move on."""
    found: dict[str, Finding] = {}
    sweeps = np.abs(moves.arcs.sweep)
    large = np.flatnonzero(moves.kind == MoveKind.ARC)
    large = large[(np.abs(moves.arcs.turns[moves.arc[large]]) == 1) & (sweeps[moves.arc[large]] > _HALF_TURN_DEG)]
    for at in large[large >= from_move].tolist():
        doubt = _find_doubt(moves, at)
        if not doubt or (doubt == "radius" and moves.language == "aptcl"):  # whose arcs have no sign
            continue
        line, sweep = int(moves.line[at]), float(sweeps[moves.arc[at]])
        if doubt in found:
            found[doubt] = add_line(found[doubt], line)
            continue
        sense = _SENSES.get(moves.language, "G2 or G3")
        meant = f"is the other sense meant ({sense})?"
        if doubt == "radius":
            meant = f"is the other sign of {_RADII.get(moves.language, 'R')} meant?"
        meets = "goes back on both moves beside it" if doubt == "sense" else "meets both moves beside it at an angle"
        text = f"the arc of {sweep:.4g} deg {meets}, and one of {360.0 - sweep:.4g} deg would continue them: {meant}"
        found[doubt] = make_finding("VP056", text, line=line)
    yield from found.values()


def drop_helices(moves: Moves, from_move: int = 0) -> list[Finding]:
    """Findings of the text, without VP056 of another plane where the arc, in its own, goes on from or to a neighbour.

    So does one turn of a thread that is written in parts, of which a chord along an axis names this axis and Z alone.
    What stands before the first move of a restart is not judged either.
    """
    own_moves = moves.count_own_lines()

    def is_helix(line: int) -> bool:
        rows = np.flatnonzero((own_moves.line == line) & (moves.kind == MoveKind.ARC))
        return not len(rows) or rows[-1] < from_move or any(_goes_on(moves, at) for at in rows.tolist())

    pairs = zip(moves.findings, own_moves.findings, strict=True)
    return [item for item, own in pairs if item.quantity != OTHER_PLANE or not is_helix(own.line or 0)]


def _goes_on(moves: Moves, at: int) -> bool:
    """Whether an arc is like one beside it, or continues a cut or is continued by one, as seen along its axis."""
    axes = PLANES[int(moves.arcs.plane[moves.arc[at]])][:2]
    for row, is_before in ((at - 1, True), (at + 1, False)):
        if not 0 < row < len(moves):
            continue
        beside = _find_direction(moves, row, axes, at_end=is_before)
        own = _find_direction(moves, at, axes, at_end=not is_before)
        if _is_alike(moves, at, row) or (beside is not None and own is not None and math.dist(beside, own) < _NEARLY):
            return True
    return False


def _find_doubt(moves: Moves, at: int) -> str:
    """What is in doubt, "sense" or "radius": its change alone lets an arc continue both neighbours; else empty."""
    axes = PLANES[int(moves.arcs.plane[moves.arc[at]])][:2]
    first, last = at - 1, at + 1
    if first < 1 or last >= len(moves) or moves.line[first] == moves.line[at]:
        return ""  # as in a cycle, whose arcs stand in no block
    p, q, c = _read_point(moves.end[first], axes), _read_point(moves.end[at], axes), _find_center(moves, at, axes)
    # cutter compensation goes about an outside corner, in the line before it
    if moves.kind[first] == MoveKind.ARC and moves.line[first] == moves.line[first - 1]:
        p, first = _find_center(moves, first, axes), first - 1
    if moves.kind[last] == MoveKind.ARC and moves.line[last] == moves.line[at]:
        q, last = _find_center(moves, last, axes), last + 1
    before, after = _find_direction(moves, first, axes, at_end=True), _find_direction(moves, last, axes)
    if before is None or after is None or not moves.frame[first] == moves.frame[at] == moves.frame[last]:
        return ""
    if any(_is_alike(moves, at, row) for row in (first, last)):
        return ""  # as in a row of scallops
    sense = 1.0 if moves.arcs.sweep[moves.arc[at]] > 0 else -1.0
    beyond = p[0] + q[0] - c[0], p[1] + q[1] - c[1]

    def list_fits(middle: Point, turn: float) -> list[bool]:
        ends = (find_tangent(p, middle, turn), before), (find_tangent(q, middle, turn), after)
        return [math.dist(tangent, direction) < _NEARLY for tangent, direction in ends]

    if any(list_fits(c, sense)):
        return ""
    return "sense" if all(list_fits(c, -sense)) else "radius" if all(list_fits(beyond, sense)) else ""


def _is_alike(moves: Moves, at: int, row: int) -> bool:
    """Whether a move is an arc of the same sense and radius as an arc."""
    if moves.arc[row] < 0:
        return False
    arcs = moves.arc[[at, row]]
    sweeps, radii = moves.arcs.sweep[arcs], np.linalg.norm(moves.end[[at, row], :3] - moves.arcs.center[arcs], axis=1)
    return bool(sweeps[0] * sweeps[1] > 0.0 and abs(radii[0] - radii[1]) <= _SAME_MM)


def _find_direction(moves: Moves, row: int, axes: tuple[int, int], *, at_end: bool = False) -> Point | None:
    """Direction of a cut in the plane of two axes, where it begins or ends; None where there is none."""
    if not 0 < row < len(moves) or moves.kind[row] not in (MoveKind.FEED, MoveKind.ARC):
        return None
    here, there = _read_point(moves.end[row - 1], axes), _read_point(moves.end[row], axes)
    arc = int(moves.arc[row])
    if arc < 0:
        length = math.dist(here, there)
        return ((there[0] - here[0]) / length, (there[1] - here[1]) / length) if length > 0.0 else None
    if PLANES[int(moves.arcs.plane[arc])][:2] != axes:
        return None
    sense = 1.0 if moves.arcs.sweep[arc] > 0 else -1.0
    return find_tangent(there if at_end else here, _find_center(moves, row, axes), sense)


def _find_center(moves: Moves, row: int, axes: tuple[int, int]) -> Point:
    return _read_point(moves.arcs.center[moves.arc[row]], axes)


def _read_point(values: Array, axes: tuple[int, int]) -> Point:
    return float(values[axes[0]]), float(values[axes[1]])
