"""Arcs of cutter location text: CIRCLE with its axis, TLON,GOFWD with a circle or a cylinder; about any axis."""

import math
import re
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ARC_CHORD_MM, ARC_RADIUS_INCH_MM, ARC_RADIUS_MM, VECTOR_LENGTH
from verne_post.gcode.apt.statements import Statement, read_numbers
from verne_post.gcode.arcs import allow_mismatch
from verne_post.gcode.machining.spatial_arc import SpatialArc
from verne_post.gcode.program_error import POST_OTHERWISE, ProgramError
from verne_post.gcode.rs274.motion import MAX_TURNS

#: How far the axis of a circle may be off X, Y or Z: the last of six printed decimals.
_CIRCLE_AXIS: Final = 1e-6
#: Centre and axis; some CAM systems leave the radius out, others append the tolerance and sizes of the tool.
_CIRCLE_NUMBERS: Final = (6, 7, 11)
#: Numbers in brackets, and the two forms of TLON,GOFWD: a circle about Z, and a cylinder about any axis.
_NUMBERS: Final = r"\(\s*{}\s*/([^()]*)\)"
_POINT, _VECTOR = _NUMBERS.format("POINT"), _NUMBERS.format("VECTOR")
_FORMS: Final = tuple(
    re.compile(r"\s*".join(["", *form.split(), "$"]), re.IGNORECASE)
    for form in (
        rf"{_NUMBERS.format('CIRCLE')} , ON (?:,\s*[12]\s*,\s*INTOF\s*)? , {_NUMBERS.format('LINE')}",
        rf"{_NUMBERS.format('CYLNDR')} , ON , \( PLANE / PERPTO , \( PLANE / {_POINT} , PERPTO , {_VECTOR} \) ,"
        rf" {_POINT} , {_POINT} \)",
    )
)


class Circle(Struct, frozen=True):
    """A circle in coordinates and unit of the part: centre (3,), axis (3,) of its counter-clockwise turn, radius.

    ``radius`` is None where the statement has none; ``turns`` are whole ones before the arc.
    """

    center: Array
    normal: Array
    radius: float | None
    turns: int = 0

    def find_axis(self) -> int | None:
        """0, 1 or 2 where the axis is X, Y or Z, to the last printed decimal; None for any other."""
        along = int(np.argmax(np.abs(self.normal)))
        near = abs(abs(self.normal[along]) - 1.0) <= VECTOR_LENGTH
        return along if near and np.linalg.norm(np.delete(self.normal, along)) <= _CIRCLE_AXIS else None

    def find_distance(self, point: Array) -> float:
        """How far a point is from the axis."""
        return float(np.linalg.norm(np.cross(point - self.center, self.normal)))

    def has(self, point: Array, start: Array, tolerance: float) -> bool:
        """True for a point that is as far from the axis as ``start``, and as high along it."""
        apart = self.find_distance(point) - self.find_distance(start)
        return max(abs(apart), abs(float((point - start) @ self.normal))) <= tolerance


def read_circle(s: Statement, times: str) -> Circle:
    """CIRCLE/x,y,z,i,j,k,r, as its numbers are; ``times``: what TIMES counts, as the set-up says.

    Raises
    ------
    ProgramError
        For another count of numbers, TIMES that nobody has explained, or an axis that is no unit vector.
    """
    words, turns = s.words, 0
    if len(words) > 2 and words[-2].upper() == "TIMES":
        turns = _read_turns(s, times)
        words = words[:-2]
    numbers = read_numbers(s, words)
    if len(numbers) not in _CIRCLE_NUMBERS:
        raise ProgramError(
            "VP005", f"CIRCLE takes centre x, y, z, axis i, j, k, and the radius; here are {len(numbers)} numbers"
        )
    radius = numbers[6] if len(numbers) > 6 else None
    return Circle(np.array(numbers[:3]), _read_unit("CIRCLE", numbers[3:6]), radius, turns)


def _read_turns(s: Statement, times: str) -> int:
    """Whole turns before the arc of a CIRCLE with TIMES,n."""
    number = read_numbers(s, s.words[-1:])[0]
    if number != round(number) or not 1 <= number <= MAX_TURNS:
        raise ProgramError("VP007", f"CIRCLE: TIMES takes a whole number from 1 to {MAX_TURNS}", s.find_column("TIMES"))
    if number > 1 and not times:
        raise ProgramError(
            "VP002",
            f"CIRCLE with TIMES,{number:g}: it is not known whether TIMES includes the turn that the arc "
            'itself starts; give times = "begun" or "whole" under [aptcl] of the settings '
            "file",
            s.find_column("TIMES"),
        )
    return round(number) - (0 if times == "whole" else 1)


def _read_unit(name: str, numbers: list[float]) -> Array:
    size = float(np.linalg.norm(numbers))
    if abs(size - 1.0) > VECTOR_LENGTH:
        raise ProgramError("VP008", f"{name}: the axis (i, j, k) has length {size:.6g}; it must be a unit vector")
    return np.array(numbers) / size


def read_tool_on(s: Statement, start: Array, tangent: Array | None) -> tuple[Circle, list[float]]:
    """TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/x,y,z,x,y,z) or with CYLNDR: the circle and the end of the arc.

    Parameters
    ----------
    s : Statement
    start : array
        (3,) where the tool stands, in the coordinates and the unit of the statements.
    tangent : array or None
        (3,) of INDIRV, which says how the arc turns.

    Raises
    ------
    ProgramError
        For other forms, and where no INDIRV says how the arc turns.
    """
    shape, end = next((_read_ends(s, form) for form in _FORMS if form.match(s.text)), ([], []))
    if len(shape) == 4 and len(end) == 6:
        normal, end = np.array([0.0, 0.0, 1.0]), end[3:]
    elif len(shape) == 7 and len(end) == 3:
        normal = _read_unit("CYLNDR", shape[3:6])
    else:
        raise ProgramError(
            "VP005",
            "TLON is executed as TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/x,y,z,x,y,z), whose line ends where the arc "
            "does, and with CYLNDR and POINT; let the CAM system write such arcs, CIRCLE and GOTO, or points",
        )
    center, radius = np.array(shape[:3]), shape[-1]
    if tangent is None:
        raise ProgramError("VP005", "TLON needs INDIRV before it, for the direction of the arc")
    side = float(np.cross(normal, start - center) @ tangent)
    if abs(side) <= VECTOR_LENGTH * radius:
        raise ProgramError("VP008", "INDIRV is not tangent to the arc of TLON at the tool")
    return Circle(center, normal if side > 0 else -normal, radius), end


def _read_ends(s: Statement, form: re.Pattern[str]) -> tuple[list[float], list[float]]:
    """Numbers of the first and of the last bracket of a form."""
    found = form.match(s.text)
    groups = found.groups() if found else ("", "")
    first, last = (read_numbers(s, [word.strip() for word in text.split(",")]) for text in (groups[0], groups[-1]))
    return first, last


def find_allowed(radius: float, *, inch: bool) -> float:
    """How far a point may be off its circle (mm), whose radius is in mm."""
    return allow_mismatch(radius, ARC_RADIUS_INCH_MM if inch else ARC_RADIUS_MM)


def check_radius(circle: Circle, start: Array, unit: float) -> None:
    """Refuse (VP008) a start (3,) that is not on the circle; ``unit``: mm of a unit."""
    if circle.radius is None:
        return
    distance, radius = unit * circle.find_distance(start), unit * circle.radius
    allowed_difference = find_allowed(radius, inch=unit != 1.0)
    if abs(distance - radius) > allowed_difference:
        raise ProgramError(
            "VP008",
            f"CIRCLE: the tool is {distance:.6g} mm from the centre, and the radius is {radius:.6g} mm; allowed are "
            f"{allowed_difference:.6g} mm between them",
        ).advise(POST_OTHERWISE)


def lay_arc(circle: Circle, start: Array, end: Array, unit: float) -> SpatialArc:
    """The arc about any axis from start to end (3,), mm; a whole turn where they are one point.

    ``unit`` is mm of a unit of the circle.

    Raises
    ------
    ProgramError
        VP008 where the end is not on the circle.
    """
    normal, center = circle.normal, unit * circle.center
    first, last = (point - center - ((point - center) @ normal) * normal for point in (start, end))
    radius, other = float(np.linalg.norm(first)), float(np.linalg.norm(last))
    allowed_difference = find_allowed(max(radius, other), inch=unit != 1.0)
    if min(radius, other) < ARC_CHORD_MM or abs(radius - other) > allowed_difference:
        raise ProgramError(
            "VP008",
            f"CIRCLE: the end is not on the circle: radius {radius:.6g} mm at the start, {other:.6g} mm at the end; "
            f"allowed are {allowed_difference:.6g} mm between them",
        ).advise(POST_OTHERWISE)
    sweep = math.atan2(float(np.cross(first, last) @ normal), float(first @ last)) % (2.0 * math.pi)
    if sweep * radius < ARC_CHORD_MM:  # the end is the start, whichever side of it rounding has left it on
        sweep = 2.0 * math.pi
    return SpatialArc(center, normal, math.degrees(sweep))
