"""B-splines of programs: what makes them curves, and the pieces that are recorded.

A B-spline is cut at its knots. Each piece is one motion, of the source line of its last control point: that block has
completed what the piece needs. What cannot be followed along exactly is refused; nothing is replaced by chords.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.bsplines import (
    evaluate_piece_ends,
    find_bezier_controls,
    find_even_parts,
    split_bezier,
    split_slices,
)
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import STRAIGHT_MM, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.program_error import ProgramError
from verne_post.model.splines import Splines

#: A higher degree than any control has; the basis of a piece is evaluated by its degree.
MAX_DEGREE: Final = 15
#: No control has memory for more control points in one curve; 40,000 take 200 MB here.
MAX_POINTS: Final = 100_000
#: So many pieces are measured before anything is refused: where a curve stops, that takes a hundred times as long.
_MOST_TRIES: Final = 1 << 8
#: An end of a piece that is at rest is cut off where what is cut off is straight: it is halved so often at most.
_MOST_HALVINGS: Final = 20
_ROTARY: Final = [3, 4, 5]


class BSpline(Struct, frozen=True):
    """A rational B-spline in program coordinates, n control points."""

    degree: int  #: 1 and more: the order less one.
    points: Sequence[Sequence[float]]  #: mm and degrees; the first is where the tool is.
    weights: Sequence[float]
    #: n + degree + 1, never falling; at both ends at least ``degree`` equal ones, besides the outermost.
    knots: Sequence[float]
    lines: Sequence[int]  #: Source line of each control point.
    #: (n, 3), or None: Tool axes of the control points, unit, program directions, where no A and C hold them.
    axes: Array | None = None


class SplineDraft(Struct):
    """A spline whose control points are being read, block by block."""

    code: int  #: The code that has begun it.
    line: int
    order: int
    points: list[list[float]] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)
    knots: list[float] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)  #: Of each control point.

    def add(self, point: list[float], weight: float, line: int) -> None:
        """Add a control point.

        Raises
        ------
        ProgramError
            VP031: one too many.
        """
        check_room(len(self.points))
        self.points.append(point)
        self.weights.append(weight)
        self.lines.append(line)


def check_room(count: int) -> None:
    """Refuse another control point where a spline has ``count`` already."""
    if count >= MAX_POINTS:
        raise ProgramError(
            "VP031", f"more than {MAX_POINTS} control points in one spline; end it before, and begin another"
        )


class CutSpline(Struct, frozen=True, eq=False):
    """The motions (m,) that follow a B-spline."""

    pieces: Splines
    line: list[int]
    end: list[list[float]]
    straight: Mask  #: (m,): The piece is a straight move, however its parameter runs.
    length: Array  #: (m,): Of the tip, mm.
    axis: Array | None  #: (m, 3), or None: Tool axes at the ends, unit.


def build_uniform_knots(count: int, degree: int) -> list[float]:
    """Knots of a B-spline with evenly spaced ones that begins and ends at its control points (``count`` of them)."""
    inner = count - degree
    return [float(min(max(k - degree, 0), inner)) for k in range(count + degree + 1)]


def cut_spline(spline: BSpline) -> CutSpline:
    """Cut a B-spline into the motions that follow it.

    Raises
    ------
    ProgramError
        VP031, with the line where that is known.
    """
    _check(spline)
    degree, knots = spline.degree, np.array(spline.knots, dtype=float)
    all_points, all_weights = np.array(spline.points, dtype=float), np.array(spline.weights, dtype=float)
    last: Ints = np.arange(degree, len(all_points))
    last = last[knots[last] < knots[last + 1]]  # of the control points that a piece depends on
    owner = last[:, None] + np.arange(-degree, 1)
    knot = last[:, None] + np.arange(1 - degree, degree + 1)
    is_kept = np.array([not _stands(spline, all_points[rows]) for rows in owner], dtype=bool)
    last, owner, knot = last[is_kept], owner[is_kept], knot[is_kept]
    if not len(last):
        raise ProgramError("VP031", "all control points of the spline coincide", None, spline.lines[0])
    points, weights, knots = all_points[owner], all_weights[owner], knots[knot]
    if spline.axes is None:
        points, weights, knots, last = _cut_at_rests(points, weights, knots, last)
    n = len(last)
    straight, length, ends = np.empty(n, dtype=bool), np.empty(n), np.empty((n, points.shape[2]))
    axes = None if spline.axes is None else np.empty((n, 3))
    for some in split_slices(n, _MOST_TRIES):  # up to the first that is refused
        here = points[some], weights[some], knots[some]
        straight[some], length[some] = _measure(*here, [spline.lines[k] for k in last[some].tolist()])
        ends[some] = evaluate_piece_ends(*here)
        if axes is not None and spline.axes is not None:
            axes[some] = evaluate_piece_ends(spline.axes[owner[some]], *here[1:])
    if axes is not None:
        axes /= measure_rows(axes)[:, None]
    pieces = Splines(
        np.full(n, degree, dtype=np.int32),
        (degree + 1) * np.arange(n),
        2 * degree * np.arange(n),
        points.reshape(-1, points.shape[2]),
        weights.ravel(),
        knots.ravel(),
    )
    return CutSpline(pieces, [spline.lines[k] for k in last.tolist()], ends.tolist(), straight, length, axes)


def _cut_at_rests(points: Array, weights: Array, knots: Array, last: Ints) -> tuple[Array, Array, Array, Ints]:
    """Cut off ends of pieces with coinciding control points: there the curve has a direction, but no speed.

    What is cut off is so short that it is straight; the rest has a speed throughout.
    """
    controls = find_bezier_controls(points - points[:, :1], weights, knots)
    places = controls[..., :-1] / controls[..., -1:]
    begins, ends = (np.abs(places[:, a] - places[:, b]).max(axis=1) <= ZERO_LENGTH_MM for a, b in ((0, 1), (-1, -2)))
    resting = (begins != ends) & (controls.shape[1] > 3)
    if not resting.any():
        return points, weights, knots, last
    parts: list[tuple[Array, Array, Array, int]] = []
    bezier = np.repeat([0.0, 1.0], controls.shape[1] - 1)
    for piece, at in enumerate(last.tolist()):
        cut = _cut_rest(controls[piece], points[piece, 0], at_begin=bool(begins[piece])) if resting[piece] else None
        own = points[piece], weights[piece], knots[piece]
        parts += (
            [(*own, at)] if cut is None else [(*_divide_weights(part, points[piece, 0]), bezier, at) for part in cut]
        )
    split_points, split_weights, split_knots, lasts = zip(*parts, strict=True)
    return np.array(split_points), np.array(split_weights), np.array(split_knots), np.array(lasts, dtype=last.dtype)


def _cut_rest(controls: Array, origin: Array, *, at_begin: bool) -> tuple[Array, Array] | None:
    """Two parts of a Bezier piece (homogeneous, from ``origin``) with an end at rest; None where none is straight."""
    share = 0.5
    for _ in range(_MOST_HALVINGS):
        parts = split_bezier(controls, share if at_begin else 1.0 - share)
        if _is_straight(_divide_weights(parts[0 if at_begin else 1], origin)[0]):
            return parts
        share *= 0.5
    return None


def _divide_weights(controls: Array, origin: Array) -> tuple[Array, Array]:
    """Control points and weights of homogeneous ones."""
    return controls[:, :-1] / controls[:, -1:] + origin, controls[:, -1]


def _measure(points: Array, weights: Array, knots: Array, lines: list[int]) -> tuple[Mask, Array]:
    """Which pieces of one degree are straight moves, and how long they all are.

    Raises
    ------
    ProgramError
        VP031, for the first that stops or turns back.
    """
    parts = find_even_parts(find_bezier_controls(points - points[:, :1], weights, knots), 3)
    straight = ~parts.regular | (points.shape[1] == 2)
    for piece in np.flatnonzero(straight).tolist():
        if not _is_straight(points[piece]):
            raise _refuse_singular(points[piece], lines[piece])
    return straight, np.where(straight, np.linalg.norm(points[:, -1, :3] - points[:, 0, :3], axis=1), parts.length)


def _check(spline: BSpline) -> None:
    """Numbers of control points, weights and knots that make a curve."""
    degree, n, line = spline.degree, len(spline.points), spline.lines[0] if spline.lines else None
    if not 1 <= degree <= MAX_DEGREE:
        raise ProgramError("VP031", f"a spline of degree {degree}; a degree is 1 to {MAX_DEGREE}", None, line)
    if n <= degree:
        text = (
            f"{n} control points are too few for a spline of degree {degree}; it needs at least {degree + 1}, the "
            "start included"
        )
        raise ProgramError("VP031", text, None, line)
    for weight, of_line in zip(spline.weights, spline.lines, strict=True):
        if not (weight > 0 and np.isfinite(weight)):
            raise ProgramError(
                "VP031", f"the weight {weight:g} of a control point; weights are positive", None, of_line
            )
    knots = spline.knots
    if len(knots) != n + degree + 1:
        text = f"{len(knots)} knots for {n} control points of degree {degree}; expected {n + degree + 1}"
        raise ProgramError("VP031", text, None, line)
    for k, (before, after) in enumerate(pairwise(knots)):
        if not after >= before:
            of_line = spline.lines[min(k + 1, n - 1)]
            raise ProgramError(
                "VP031", f"the knot {after:g} comes after {before:g}; knots never decrease", None, of_line
            )
    if knots[degree] == knots[n]:
        raise ProgramError(
            "VP031", f"all knots are {knots[0]:g}; between the first and the last they must rise", None, line
        )
    if knots[1] != knots[degree] or knots[n] != knots[n + degree - 1]:
        text = "the spline does not begin at its first control point and end at its last: the first and the last "
        raise ProgramError("VP031", f"{text}{degree + 1} knots must be equal each", None, line)
    for k in range(1, n):
        if knots[k] == knots[k + degree]:
            text = (
                f"the knot {knots[k]:g}, neither the first nor the last, is given {degree + 1} times, which tears the "
                f"curve; at most {degree} are possible"
            )
            raise ProgramError("VP031", text, None, spline.lines[min(k + degree, n - 1)])


def _stands(spline: BSpline, points: Array) -> bool:
    """Whether a piece is one place; it must not turn the table there."""
    away = np.abs(points - points[0]).max(axis=0)
    if away[[0, 1, 2, 6, 7, 8]].max() > ZERO_LENGTH_MM:
        return False
    if away[_ROTARY].max() > DEG_PER_RAD * ZERO_ANGLE:
        text = (
            f"the control points near {_name_place(points[0])} turn the rotary axes and move no linear axis; write G1 "
            "for that"
        )
        raise ProgramError("VP031", text, None, spline.lines[0])
    return True


def _is_straight(points: Array) -> bool:
    """Whether control points (m, 9) stand on a straight line in the order in which they come."""
    span = points[-1] - points[0]
    square = float(span @ span)
    if square == 0.0:
        return False
    share = (points - points[0]) @ span / square
    aside = np.abs(points - points[0] - share[:, None] * span).max()
    return bool(aside <= STRAIGHT_MM and (np.diff(share) >= 0).all() and np.linalg.norm(span[:3]) > ZERO_LENGTH_MM)


def _refuse_singular(points: Array, line: int) -> ProgramError:
    text = (
        f"the spline stops or turns back at a point between {_name_place(points[0])} and {_name_place(points[-1])}: it "
        "has no direction there. Control points that coincide, or a closing loop, cause this"
    )
    return ProgramError("VP031", text, None, line)


def _name_place(point: Array) -> str:
    return " ".join(f"{letter}{value:.6g}" for letter, value in zip("XYZ", point, strict=False))
