"""Arc geometry of G2 and G3: centre, turns and sweep in the active plane.

Rules and tolerances are those measured on LinuxCNC's interpreter (docs/gcode.md). mm, degrees.
"""

import math
from collections.abc import Iterable
from typing import Final

from msgspec import Struct

from verne_post.base.tolerances import (
    ARC_CHORD_MM,
    ARC_HALF_CIRCLE_SHARE,
    ARC_R_TOO_SMALL_MM,
    ARC_RADIUS_MM,
    ARC_RADIUS_SHARE,
)
from verne_post.gcode.program_error import POST_OTHERWISE, ProgramError
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES

#: Plane -> indices of its first, second and normal axis, and the names of its offset words.
PLANES: Final = {0: (0, 1, 2, "I", "J"), 1: (2, 0, 1, "K", "I"), 2: (1, 2, 0, "J", "K")}
PLANE_NAMES: Final = ("XY", "ZX", "YZ")
#: Share of the diameter from which a chord is about that of half a turn.
_NEARLY_HALF: Final = 0.99


class Arc(Struct, frozen=True):
    """One arc: plane number, centre (3), signed turns and sweep in degrees (counter-clockwise positive)."""

    plane: int
    center: tuple[float, float, float]
    turns: int
    sweep: float


def build_arc_from_center(
    start: list[float],
    end: list[float],
    plane: int,
    clockwise: bool,
    offsets: dict[str, float],
    absolute: bool,
    extra_turns: int,
    tolerance: float = ARC_RADIUS_MM,
    plane_word: str = "",
    unit: float = 1.0,
    *,
    is_scaled: bool = False,
) -> Arc:
    """Arc given by its centre (I, J, K).

    Parameters
    ----------
    start, end : list of float
        Program coordinates, at least X Y Z, mm.
    offsets : dict
        The I, J, K words of the block, mm.
    absolute : bool
        G90.1: centres are absolute.
    extra_turns : int
        Full turns beyond the first (P - 1).
    tolerance : float
        Radius mismatch that is always accepted, mm.
    plane_word : str
        What says that the plane is this one.
    unit : float
        mm in the unit of the program, which messages have.
    is_scaled : bool
        The program has other values of I, J and K.
    """
    name = "mm" if unit == 1.0 else "inch"
    first, second, _normal, letter1, letter2 = PLANES[plane]
    wrong = set(offsets) - {letter1, letter2}
    if wrong:
        raise ProgramError(
            "VP006",
            f"{min(wrong)} does not belong to an arc in the {PLANE_NAMES[plane]} plane{plane_word}",
            cause=plane_word.removeprefix("; "),
        )
    if absolute:
        missing = [letter for letter in (letter1, letter2) if letter not in offsets]
        if missing:
            raise ProgramError("VP005", f"an arc with absolute centre (G90.1) needs {missing[0]} too")
        c1, c2 = offsets[letter1], offsets[letter2]
    else:
        c1 = start[first] + offsets.get(letter1, 0.0)
        c2 = start[second] + offsets.get(letter2, 0.0)
    r1 = math.hypot(start[first] - c1, start[second] - c2)
    r2 = math.hypot(end[first] - c1, end[second] - c2)
    if r1 < ARC_R_TOO_SMALL_MM or r2 < ARC_R_TOO_SMALL_MM:
        raise ProgramError(
            "VP008",
            "the radius of the arc is zero"
            if r1 == r2
            else f"the radius of the arc is {r1 / unit:.6g} {name} at the start, {r2 / unit:.6g} {name} at the end: "
            f"its centre is the {'end' if r2 < r1 else 'start'}",
        )
    gap = abs(r1 - r2)
    allowed_difference = allow_mismatch(max(r1, r2), tolerance)
    if gap > allowed_difference:
        # the start is as far from a centre on its other side
        sides = (
            (end[first] - 2 * start[first] + c1, end[second] - c2),
            (end[first] - c1, end[second] - 2 * start[second] + c2),
        )
        letters = [
            letter
            for letter, side in zip((letter1, letter2), sides, strict=True)
            if not absolute and abs(math.hypot(*side) - r1) <= allow_mismatch(r1, tolerance)
        ]
        hint, edits = "", tuple[Remedy, ...]()
        if len(letters) == 1:
            letter, value = letters[0], offsets[letters[0]] / unit
            hint = f"; write {letter} with the other sign, if that is meant: the radii agree then"
            edits = (Remedy(f"write {letter}{-value:.9g}", f"{-value:.9g}", word=(letter, value), is_choice=True),)
        elif not absolute and not is_scaled and {letter1, letter2} <= set(offsets):
            u, v = offsets[letter1] - start[first], offsets[letter2] - start[second]
            to_start = math.hypot(u, v)
            to_end = math.hypot(offsets[letter1] - end[first], offsets[letter2] - end[second])
            if abs(to_start - to_end) <= allow_mismatch(to_start, tolerance):
                words = f"{letter1}{round(u / unit, 6):.9g} {letter2}{round(v / unit, 6):.9g}"
                hint = (
                    f"; {letter1} and {letter2} fit as coordinates of the centre: write {words}, from the start to it"
                )
        raise ProgramError(
            "VP008",
            f"the end is not on the circle: radius {r1 / unit:.6g} {name} at the start ({AXES[first]}"
            f"{start[first] / unit:g} {AXES[second]}{start[second] / unit:g}), {r2 / unit:.6g} {name} at the end, "
            f"difference {gap / unit:.6g} {name}; allowed {allowed_difference / unit:.6g} {name}{hint}",
            edits=edits,
        ).advise("" if hint else POST_OTHERWISE)
    angle = math.atan2(end[second] - c2, end[first] - c1) - math.atan2(start[second] - c2, start[first] - c1)
    sweep = (-angle if clockwise else angle) % (2 * math.pi)
    if sweep * r1 < ARC_CHORD_MM:  # the end is the start, whichever side of it rounding has left it on
        sweep = 2 * math.pi
    return _make_arc(start, plane, (c1, c2), sweep, clockwise, extra_turns)


def allow_mismatch(radius: float, tolerance: float) -> float:
    """How much two radii of one arc may differ, mm; ``tolerance``: as of :func:`build_arc_from_center`."""
    return min(max(tolerance, ARC_RADIUS_SHARE * radius), 100 * tolerance)


def build_arc_from_radius(
    start: list[float],
    end: list[float],
    plane: int,
    clockwise: bool,
    radius: float,
    extra_turns: int,
    unit: float = 1.0,
) -> Arc:
    """Arc given by its radius R; a negative one takes the long way. It is never a full circle.

    ``unit`` is that of :func:`build_arc_from_center`.
    """
    first, second, *_ = PLANES[plane]
    d1, d2 = end[first] - start[first], end[second] - start[second]
    half = 0.5 * math.hypot(d1, d2)
    if 2 * half < ARC_CHORD_MM:
        raise ProgramError(
            "VP008",
            f"an arc with R needs an end point other than its start; they are {2 * half:.2g} mm apart, and less than "
            f"{ARC_CHORD_MM:g} mm does not determine the centre; write a full circle with I, J, K, or leave "
            "the block out",
        )
    short = half - abs(radius)
    if short > ARC_R_TOO_SMALL_MM or radius == 0.0:
        name = "mm" if unit == 1.0 else "inch"
        raise ProgramError(
            "VP008",
            f"the radius {radius / unit:g} {name} is too small to reach the end point from {AXES[first]}"
            f"{start[first] / unit:g} {AXES[second]}{start[second] / unit:g}; it takes at least "
            f"{half / unit:.6g} {name}",
        )
    height = 0.0
    if half <= (1.0 - ARC_HALF_CIRCLE_SHARE) * abs(radius):
        height = math.sqrt(radius * radius - half * half)
    # the centre lies left of the chord for a short counter-clockwise arc
    side = 1.0 if clockwise == (radius < 0) else -1.0
    c1 = 0.5 * (start[first] + end[first]) - side * height * d2 / (2 * half)
    c2 = 0.5 * (start[second] + end[second]) + side * height * d1 / (2 * half)
    sweep = 2 * math.atan2(half, height)
    return _make_arc(start, plane, (c1, c2), sweep if radius > 0 else 2 * math.pi - sweep, clockwise, extra_turns)


def name_other_plane(plane: int, axes: Iterable[int], start: list[float], end: list[float], radius: float) -> str:
    """The plane that the axes of a block with an arc by its radius belong to, where it is not ``plane``; else empty.

    Two axes of another plane are a helix only by what was written before. Half a turn of one ends beside its start.
    """
    first, second, normal, *_ = PLANES[plane]
    named_axes = {axis for axis in axes if axis < 3}
    in_plane = named_axes - {normal}
    if normal not in named_axes or len(in_plane) != 1 or end[normal] == start[normal]:
        return ""
    if math.hypot(end[first] - start[first], end[second] - start[second]) > _NEARLY_HALF * 2.0 * abs(radius):
        return ""
    chord = math.hypot(*(end[axis] - start[axis] for axis in named_axes))
    is_possible = chord <= 2.0 * (abs(radius) + ARC_R_TOO_SMALL_MM)
    return next(f"G{17 + other}" for other in PLANES if set(PLANES[other][:2]) == named_axes) if is_possible else ""


def _make_arc(
    start: list[float], plane: int, centre: tuple[float, float], angle: float, clockwise: bool, extra: int
) -> Arc:
    first, second, normal, *_ = PLANES[plane]
    sign = -1 if clockwise else 1
    center = [0.0, 0.0, 0.0]
    center[first], center[second], center[normal] = *centre, start[normal]
    sweep = sign * math.degrees(angle + 2 * math.pi * extra)
    return Arc(plane, (center[0], center[1], center[2]), sign * (1 + extra), sweep)
