"""BSPLINE of Siemens programs: control points block by block, with weights and intervals, until another word."""

from typing import Final

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array
from verne_post.base.tolerances import WHOLE_NUMBER, ZERO_LENGTH_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.gcode.machining.machining import explain_inverse_time
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.siemens.motion import SiemensMotion
from verne_post.gcode.siemens.places import SiemensPlaces
from verne_post.gcode.siemens.words import Word, Words
from verne_post.gcode.splines import BSpline, build_uniform_knots, check_room
from verne_post.model.moves import FeedMode

#: Words of a block that gives a control point.
_POINT_WORDS: Final = {"X", "Y", "Z", "A", "B", "C", "A3", "B3", "C3", "PW", "PL", "SD", "F"}
_DEGREES: Final = (2, 3)
#: Largest angle between the tool axis of A and C of control points and great circles between its control axes.
_ASIDE: Final = 0.5 * RAD_PER_DEG


class _Draft(Struct):
    """Control points so far (core numbers, nine axes), the first is where the tool is; ``intervals`` are those of PL.

    ``axes`` are the tool axes (3,) of the control points, without any where A and C go along by themselves.
    """

    block: At
    degree: int
    points: list[list[float]]
    weights: list[float] = field(default_factory=lambda: [1.0])
    lines: list[int] = field(default_factory=list)
    intervals: list[float | None] = field(default_factory=list)
    axes: list[Array] = field(default_factory=list)


class SiemensSplines:
    """Frame words, and splines."""

    def __init__(self, motion: SiemensMotion, places: SiemensPlaces) -> None:
        self.motion = motion
        self.places = places
        self.core = motion.core
        self.setup = motion.setup
        self.state = motion.state
        self.draft: _Draft | None = None  # the spline whose control points are being read

    def end_spline(self, words: Words | None = None) -> None:
        """Follow the spline that has been read, unless a block only gives it another point."""
        draft = self.draft
        if draft is None or (words is not None and _is_point(words)):
            return
        self.draft = None
        count, degree = len(draft.points), draft.degree
        if count <= degree:
            code = None if words is None else words.find_code("motion")
            why = "" if code in (None, "BSPLINE") else f" before {code} ends it: leave {code} out of its blocks"
            raise ProgramError(
                "VP031",
                f"BSPLINE of degree {degree} needs {degree} points after its start; there are {count - 1}{why}",
                None,
                draft.block.line,
            )
        axes = np.array(draft.axes) if draft.axes else None
        if axes is not None:
            self._check_axes(draft, axes)
            if self.setup.machine:  # A and C are coordinates of the spline
                axes = None
                self.core.hold_tool_axis(None)
        spline = BSpline(degree, draft.points, draft.weights, _make_knots(draft), draft.lines, axes)
        self.core.follow_spline(draft.block, spline, "BSPLINE")
        first, last = draft.points[-2][:3], draft.points[-1][:3]
        self.motion.set_heading([b - a for a, b in zip(first, last, strict=True)])

    def add_spline_point(self, words: Words, block: At) -> None:
        """Read a block under BSPLINE."""
        if self.draft is None and not words.words.keys() & _POINT_WORDS - {"F"} and words.find_code("motion") is None:
            return  # such a block neither begins a spline nor goes on with one
        if not self.motion.modes.absolute:
            raise ProgramError("VP017", "BSPLINE in G91: control points are absolute; write G90")
        degree = _read_degree(words.take("SD"))
        draft = self.draft
        if draft is None:
            self.core.check_spline("BSPLINE")
            if self.state.feed_mode == FeedMode.INVERSE:
                text = "BSPLINE with inverse-time feed (G93): its blocks are one motion; use G94"
                raise explain_inverse_time(self.core, ProgramError("VP017", text))
            self.core.require_known(block, [0, 1, 2], "BSPLINE")
            draft = self.draft = _Draft(block, degree or _DEGREES[-1], [list(self.state.position)], lines=[block.line])
        elif degree is not None and degree != draft.degree:
            raise ProgramError(
                "VP031", f"SD={degree} in a spline of degree {draft.degree}; write SD in its first block"
            )
        weight, interval = words.take("PW"), words.take("PL")
        if weight is not None and weight.value <= 0:
            raise weight.error("VP031", f"PW={weight.value:g}: the weight of a control point is positive")
        if interval is not None and interval.value < 0:
            raise interval.error("VP031", f"PL={interval.value:g}: a parameter interval is not negative")
        places, vector = self.places.read_places(words, block), self.places.read_vector(words)
        if not places:
            for word in (weight, interval, *(words.words.get(name) for name in ("A3", "B3", "C3"))):
                if word is not None:
                    raise word.error("VP005", f"{word.name}= needs the axes of its control point")
            return
        self.motion.check_feed("G1")
        self.motion.check_places(block, places)
        if not self.motion.modes.tcp and set(self.motion.setup.rotary) & set(places):
            raise ProgramError(
                "VP017",
                f"{' and '.join(self.motion.setup.rotary_letters)} in BSPLINE {self.motion.explain_no_tcp()}: "
                "the tip would follow another curve",
            )
        point = list(draft.points[-1])
        for axis, value in places.items():
            point[axis] = self.motion.convert_to_core(axis, value)
        point = self._lead_axis(draft, point, vector, turns=bool(set(self.motion.setup.rotary) & set(places)))
        check_room(len(draft.points))
        draft.points.append(point)
        draft.weights.append(1.0 if weight is None else weight.value)
        draft.lines.append(block.line)
        draft.intervals.append(None if interval is None else interval.value)

    def _lead_axis(self, draft: _Draft, point: list[float], vector: Array | None, *, turns: bool) -> list[float]:
        """A control point with A and C that hold its tool axis (3,); ``turns``: its block names A or C."""
        if vector is None and not draft.axes:
            return point
        if turns:
            letters = " or ".join(self.motion.setup.rotary_letters)
            raise ProgramError(
                "VP003", f"{letters}, and A3= B3= C3=, in one BSPLINE: give the tool axis by one of them"
            )
        if not draft.axes:
            if len(draft.points) > 1:
                raise ProgramError("VP031", "A3= B3= C3= begin in the first block of BSPLINE, or in none")
            draft.axes.append(self._find_first_axis())
        axis = draft.axes[-1] if vector is None else self.motion.turn_vectors(vector)
        draft.axes.append(axis)
        return self.setup.coordinates.turn_to_axis(point, axis, self.state.frame)

    def _find_first_axis(self) -> Array:
        """The tool axis (3,) where a spline begins."""
        state = self.state
        if state.tool_axis is not None:
            return np.array(state.tool_axis)
        axis = self.setup.coordinates.find_tool_axis(state.position, state.frame)
        return np.array([0.0, 0.0, 1.0]) if axis is None else axis

    def _check_axes(self, draft: _Draft, axes: Array) -> None:
        """Refuse a spline along which A and C would lead the tool axis far beside the great circles of its vectors."""
        points, state = np.array(draft.points), self.state
        for line, here, there, first, second in zip(draft.lines[1:], points, points[1:], axes, axes[1:], strict=False):
            between = self.setup.coordinates.find_tool_axis((0.5 * (here + there)).tolist(), state.frame)
            if between is None:
                return  # nobody knows how A and C turn the tool
            middle = first + second
            if float(np.linalg.norm(np.cross(between, middle))) > _ASIDE * float(np.linalg.norm(middle)):
                raise ProgramError(
                    "VP031",
                    "the tool axes of these control points are too far apart, or too near to the vertical, for A and "
                    "C to lead the tool along BSPLINE between them; write G1",
                    None,
                    line,
                )


def _is_point(words: Words) -> bool:
    return (
        set(words.words) <= _POINT_WORDS
        and words.groups.keys() <= {"motion"}
        and words.find_code("motion") in (None, "BSPLINE")
        and not (words.m or words.calls or words.user_names or words.modal_call)
    )


def _read_degree(word: Word | None) -> int | None:
    if word is None:
        return None
    degree = round(word.value)
    if abs(word.value - degree) > WHOLE_NUMBER or degree not in _DEGREES:
        raise word.error("VP031", f"SD={word.value:g}: the degree of a spline is 2 or 3")
    return degree


def _make_knots(draft: _Draft) -> list[float]:
    """Knots of a curve that begins and ends in its first and last control point.

    Without PL, or with equal ones, they are even. Else the intervals between them are those of PL, of which as many as
    the degree less one are 0, all at the beginning or all at the end.
    """
    count, degree = len(draft.points), draft.degree
    given = [1.0 if value is None else value for value in draft.intervals]
    if max(given) - min(given) <= ZERO_LENGTH_MM and min(given) > 0:
        return build_uniform_knots(count, degree)
    still = degree - 1
    inner = given[still:] if not any(given[:still]) else given[: len(given) - still]
    if sum(value == 0 for value in given) != still or 0 in inner:
        raise ProgramError(
            "VP031",
            f"PL= of BSPLINE: {count - 1} blocks of degree {degree} have {count - degree} intervals greater than 0, "
            f"and {still} of 0 at the beginning or at the end",
            None,
            draft.block.line,
        )
    knots = [0.0] * (degree + 1)
    for value in inner:
        knots.append(knots[-1] + value)
    return [*knots, *[knots[-1]] * degree]
