"""Arc geometry of G2 and G3: centre, turns and sweep in the active plane.

Rules and tolerances are those measured on LinuxCNC's interpreter (docs/gcode.md). mm, degrees.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from msgspec import Struct

from verne_post.base.tolerances import (
    ARC_CHORD_MM,
    ARC_HALF_CIRCLE_SHARE,
    ARC_R_TOO_SMALL_MM,
    ARC_RADIUS_MM,
    ARC_RADIUS_SHARE,
)
from verne_post.gcode.program_error import POST_OTHERWISE, ProgramError, write_before
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES

#: Plane -> indices of its first, second and normal axis, and the names of its offset words.
PLANES: Final = {0: (0, 1, 2, "I", "J"), 1: (2, 0, 1, "K", "I"), 2: (1, 2, 0, "J", "K")}
PLANE_NAMES: Final = ("XY", "ZX", "YZ")
#: Share of the diameter from which a chord is about that of half a turn.
_NEARLY_HALF: Final = 0.99
#: So much of a mismatch of radii may stay where other words of the centre explain it: what rounding leaves is less.
_REST_OF_GAP: Final = 0.1
#: Arcs of half a turn are none of more: the roundings of their ends turn them by less.
_HALF_TURN_DEG: Final = 180.5


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
    first, second, normal, letter1, letter2 = PLANES[plane]
    wrong = set(offsets) - {letter1, letter2}
    if wrong:
        text = f"{min(wrong)} does not belong to an arc in the {PLANE_NAMES[plane]} plane"
        if not absolute and (right := _name_plane_of_centre(plane, start, end, offsets, tolerance)):
            raise _refuse_plane("VP006", text, plane, right, plane_word)
        raise ProgramError("VP006", f"{text}{plane_word}", cause=plane_word.removeprefix("; "))
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
    is_zero = r1 < ARC_R_TOO_SMALL_MM or r2 < ARC_R_TOO_SMALL_MM
    gap = abs(r1 - r2)
    allowed_difference = allow_mismatch(max(r1, r2), tolerance)
    if is_zero or gap > allowed_difference:
        if not is_zero:
            text = (
                f"the end is not on the circle: radius {r1 / unit:.6g} {name} at the start ({AXES[first]}"
                f"{start[first] / unit:g} {AXES[second]}{start[second] / unit:g}), {r2 / unit:.6g} {name} at the end, "
                f"difference {gap / unit:.6g} {name}; allowed {allowed_difference / unit:.6g} {name}"
            )
        elif r1 == r2:
            text = "the radius of the arc is zero"
        else:
            text = (
                f"the radius of the arc is {r1 / unit:.6g} {name} at the start, {r2 / unit:.6g} {name} at the end: "
                f"its centre is the {'end' if r2 < r1 else 'start'}"
            )
        is_helix = start[normal] != end[normal]
        if is_helix and not absolute and (right := _name_plane_of_centre(plane, start, end, offsets, tolerance)):
            raise _refuse_plane("VP008", text, plane, right, plane_word)
        if is_zero:
            raise ProgramError("VP008", text)
        fits = [] if absolute else _find_slips(start, end, plane, offsets, clockwise, tolerance, is_scaled=is_scaled)
        hint, edits = _explain_slips(fits, offsets, plane, unit, is_scaled=is_scaled)
        raise ProgramError("VP008", f"{text}{hint}", edits=edits).advise("" if hint else POST_OTHERWISE)
    sweep = _measure_sweep(start[first] - c1, start[second] - c2, end[first] - c1, end[second] - c2, clockwise)
    if sweep * r1 < ARC_CHORD_MM:  # the end is the start, whichever side of it rounding has left it on
        sweep = 2 * math.pi
    return _make_arc(start, plane, (c1, c2), sweep, clockwise, extra_turns)


def _measure_sweep(s1: float, s2: float, e1: float, e2: float, clockwise: bool) -> float:
    """Radians from a start to an end, both from the centre."""
    angle = math.atan2(e2, e1) - math.atan2(s2, s1)
    return (-angle if clockwise else angle) % (2 * math.pi)


def _name_plane_of_centre(
    plane: int, start: list[float], end: list[float], offsets: dict[str, float], tolerance: float
) -> str:
    """Another plane, in which start and end are equally far from the centre, and the arc is no helix; else empty."""
    named_letters = {letter for letter, value in offsets.items() if value}
    for other, (first, second, normal, *letters) in PLANES.items():
        if other == plane or start[normal] != end[normal] or not named_letters <= set(letters):
            continue
        u, v = (offsets.get(letter, 0.0) for letter in letters)
        radius = math.hypot(u, v)
        mismatch = abs(radius - math.hypot(end[first] - start[first] - u, end[second] - start[second] - v))
        if radius >= ARC_R_TOO_SMALL_MM and mismatch <= allow_mismatch(radius, tolerance):
            return f"G{17 + other}"
    return ""


def _refuse_plane(code: str, text: str, plane: int, right: str, plane_word: str) -> ProgramError:
    """The error of an arc whose words fit in another plane; all that one word of a plane leads to are one."""
    since = plane_word or f"; G{17 + plane} is active"
    return ProgramError(
        code,
        f"{text}{since}; the words fit an arc in the plane of {right}: write {right} before, if that is meant",
        cause=plane_word.removeprefix("; "),
        edits=write_before(right, is_choice=True),
    ).advise("")


class _Slip(NamedTuple):
    """Other words of a centre with which the end is on the circle."""

    what: str
    offset: tuple[float, float]  #: From the start, mm.
    degrees: float
    letter: str  #: The only word that changes, by its sign.


def _find_slips(
    start: list[float],
    end: list[float],
    plane: int,
    offsets: dict[str, float],
    clockwise: bool,
    tolerance: float,
    *,
    is_scaled: bool,
) -> list[_Slip]:
    """Slips in I, J, K that explain why the end is not on the circle; arcs of more than half a turn come last.

    Where the end is near the start, almost any centre is about as far from both: the mismatch must be nearly gone.
    """
    first, second, _normal, one, two = PLANES[plane]
    i, j = offsets.get(one, 0.0), offsets.get(two, 0.0)
    d1, d2 = end[first] - start[first], end[second] - start[second]
    both = f"{one} and {two}"
    trials = [] if is_scaled else [(f"{both} exchanged", (j, i), "")]
    trials += [(f"{one} with the other sign", (-i, j), one), (f"{two} with the other sign", (i, -j), two)]
    trials.append((f"{both} with the other sign", (-i, -j), ""))
    if not is_scaled and {one, two} <= set(offsets):
        trials.append((f"{both} fit as coordinates of the centre", (i - start[first], j - start[second]), ""))
    gap = abs(math.hypot(i, j) - math.hypot(d1 - i, d2 - j))
    found = dict[tuple[float, float], _Slip]()
    for what, (u, v), letter in trials:
        radius = math.hypot(u, v)
        allowed_rest = min(allow_mismatch(radius, tolerance), _REST_OF_GAP * gap)
        if radius >= ARC_R_TOO_SMALL_MM and abs(radius - math.hypot(d1 - u, d2 - v)) <= allowed_rest:
            degrees = math.degrees(_measure_sweep(-u, -v, d1 - u, d2 - v, clockwise))
            found.setdefault((u, v), _Slip(what, (u, v), degrees, letter))
    return sorted(found.values(), key=lambda slip: slip.degrees > _HALF_TURN_DEG)


def _explain_slips(
    slips: Sequence[_Slip], offsets: dict[str, float], plane: int, unit: float, *, is_scaled: bool
) -> tuple[str, tuple[Remedy, ...]]:
    """What may settle the error of an arc, as the end of its message, and the edit, where one short arc alone fits."""
    letters = PLANES[plane][3:]

    def spell(slip: _Slip) -> str:
        values = zip(letters, slip.offset, strict=True)
        return " ".join(f"{letter}{one / unit + 0.0:.9g}" for letter, one in values if one or letter in offsets)

    if len(slips) > 1 and not is_scaled:
        fits = (f"{spell(slip)} ({slip.what}: an arc of {slip.degrees:.4g} deg)" for slip in slips)
        edits = tuple(one for slip in slips for one in _write_slip(slip, offsets, letters, unit))
        return f"; the radii agree with {', and with '.join(fits)}", edits
    if len(slips) != 1:
        return "", ()
    slip, is_long = slips[0], slips[0].degrees > _HALF_TURN_DEG
    words = slip.what if is_scaled else f"{spell(slip)} ({slip.what})"
    hint = f"; write {words}, if that is meant: the radii agree then"
    if is_long:
        return f"{hint}, on an arc of {slip.degrees:.4g} deg", ()
    return hint, () if is_scaled else _write_slip(slip, offsets, letters, unit)


def _write_slip(slip: _Slip, offsets: dict[str, float], letters: Sequence[str], unit: float) -> tuple[Remedy, ...]:
    """The edit of one word by its sign, or of both that are exchanged."""
    if slip.letter:
        value = offsets[slip.letter] / unit
        right = f"{-value:.9g}"
        return (Remedy(f"write {slip.letter}{right}", right, word=(slip.letter, value), is_choice=True),)
    if not slip.what.endswith("exchanged"):
        return ()
    one, two = letters if letters[0] in offsets else letters[::-1]
    word = one, offsets[one] / unit
    return (Remedy(f"exchange {one} and {two}", two, word=word, way="exchanged", is_choice=True),)


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
