"""Feed moves in which the table turns much farther than the path does: most often C words that a post has wrapped."""

from typing import Any, Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import iterate_blocks
from verne_post.base.rotations import find_axis_of_angles, measure_angles, wrap_angle
from verne_post.base.tolerances import POLE_SINE, ZERO_ANGLE
from verne_post.model.findings import Finding, make_finding
from verne_post.model.machine import Machine
from verne_post.model.moves import Moves
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.evaluate import evaluate_pose

#: A great circle never turns C by half a turn, only by nearly as much. One that comes so near to it passes the pole
#: within a hundredth of the tilt at its ends: a post cannot mean the small difference from an axis through the pole.
_NEARLY_HALF_TURN: Final = np.radians(179.0)
#: Linear A and C between two tool vectors sweep the tool around a cone where the shortest way between the vectors comes
#: to the vertical within half the tilt of both: C turns by 120 deg or more.
_WIDE: Final = np.radians(120.0)
#: Vectors with less tilt may be steps of a smooth path over the pole, near which C turns fast on every machine. Two of
#: this tilt with 120 deg of C between them are 5.2 deg apart: no post makes such steps along a smooth surface.
_LEAST_TILT: Final = np.radians(3.0)
#: A turn by more, deg, the other way is no cure: the word itself is in doubt.
_NEAR: Final = 90.0
#: Chords in which the direction of arcs and splines is followed.
_CHORDS: Final = 32


def report_table_turns(path: ToolPath, moves: Moves, machine: Machine) -> list[Finding]:
    """Warn (VP301) of feed moves with a tilted tool in which C turns by half a turn more than the path does.

    Under a vertical tool C means nothing, and an arc or a spline may well take the table around with it. All such moves
    of a program are one finding, at the first; those on great circles another: their cause is the pole. So are those
    between tool vectors that are near to each other, and between which A and C go linearly.
    """
    found: dict[bool, list[int]] = {False: [], True: []}  # on a great circle -> segments
    swept: list[int] = []
    for begin, end in iterate_blocks(len(path)):
        rows = np.arange(begin, end)
        swung = path.circle[rows] >= 0
        least = np.where(swung, _NEARLY_HALF_TURN, np.pi + ZERO_ANGLE)
        turn = np.abs(path.end[rows, 4] - path.start[rows, 4])
        some = np.flatnonzero((turn > least) & (path.feed_time[rows] > 0) & _is_tilted(path, rows))
        some = some[turn[some] > least[some] + _turn_of_direction(path, rows[some])]
        for at in some.tolist():
            found[bool(swung[at])].append(begin + at)
        swept.extend(_find_swept(path, moves, rows).tolist())
    cones = [_report_swept(path, moves, machine, swept)] if swept else []
    return [*(_report(path, moves, machine, rows, swung) for swung, rows in found.items() if rows), *cones]


def _find_swept(path: ToolPath, moves: Moves, rows: Ints) -> Ints:
    """Which straight feed moves sweep the tool around a cone, though vectors give its axes at both ends."""
    turn = np.abs(path.end[rows, 4] - path.start[rows, 4])
    some = (turn >= _WIDE) & (turn <= np.pi + ZERO_ANGLE) & (path.circle[rows] < 0) & (path.feed_time[rows] > 0)
    some &= (path.kind[rows] == SegmentKind.LINE) & (path.move[rows] >= 0)
    some &= (path.start[rows, :3] != path.end[rows, :3]).any(axis=1)  # a turn in place is meant, mostly in the air
    some = rows[some]
    some = some[moves.find_aimed(path.move[some])]
    tilt = np.abs(np.sin([path.start[some, 3], path.end[some, 3]])).min(axis=0)
    turn = np.abs(path.end[some, 4] - path.start[some, 4])
    return np.asarray(some[(tilt >= np.sin(_LEAST_TILT)) & (2.0 * _measure_between(path, some) <= turn)])


def _measure_between(path: ToolPath, rows: Ints) -> Array:
    """The angle (n,), rad, between the tool axes at both ends of segments."""
    start, end = (find_axis_of_angles(ends[rows, 3], ends[rows, 4]) for ends in (path.start, path.end))
    return measure_angles(start, end)


def _is_tilted(path: ToolPath, rows: Ints) -> Mask:
    """Whether segments have a tilted tool at one of their ends."""
    return np.asarray((np.abs(np.sin([path.start[rows, 3], path.end[rows, 3]])) > POLE_SINE).any(axis=0))


def _turn_of_direction(path: ToolPath, rows: Ints) -> Array:
    """The angle (n,), rad, by which the direction of the tip turns along segments: 0 on straight lines."""
    turn = np.zeros(len(rows))
    curved = np.flatnonzero(path.kind[rows] != SegmentKind.LINE)
    u = np.linspace(0.0, 1.0, _CHORDS + 1)
    tip, _angles = evaluate_pose(path, np.repeat(rows[curved], len(u)), np.tile(u, len(curved)))
    chord = np.diff(tip.reshape(len(curved), len(u), 3), axis=1)
    a, b = chord[:, :-1], chord[:, 1:]
    bend = measure_angles(a, b)
    turn[curved] = bend.sum(axis=-1) * _CHORDS / (_CHORDS - 1)  # half a chord is missing at each end
    return turn


def _measure_first(path: ToolPath, moves: Moves, machine: Machine, first: int) -> tuple[float, float, str]:
    """How far C turns along a segment and where it ends, deg, and both in words."""
    factor, letter = machine.columns[-1].factor, machine.rotary_letters[1]
    turn = float((path.end[first, 4] - path.start[first, 4]) * factor)
    tip = float(np.linalg.norm(path.end[first, :3] - path.start[first, :3]))
    after = (
        float(moves.end[path.move[first], machine.coordinates.rotary[1]])
        if not path.free[first]
        else float(path.end[first, 4]) * factor
    )
    ends = " to ".join(map(_name_angle, (after - turn, after)))
    what = f"{letter} turns by {_name_angle(turn)} deg, from {ends}, while the tip goes {round(tip, 6):.4g} mm"
    return turn, after, what


def _count(path: ToolPath, rows: list[int]) -> dict[str, Any]:
    """Where a finding of segments stands: at the first, with the lines of all."""
    line, lines = int(path.line[rows[0]]), tuple(np.unique(path.line[rows]).tolist())
    return {"line": line, "count": len(rows), "lines": lines if len(lines) > 1 else ()}


#: Language -> what leads the tool axis straight from one tool vector to the next.
_STRAIGHT: Final = {
    "heidenhain": "Write PATHCTRL VECTOR in FUNCTION TCPM, which stands in place of M128",
    "siemens": "Write ORIWKS, or ORIVECT where orientation_by_group of the settings file is true",
}


def _report_swept(path: ToolPath, moves: Moves, machine: Machine, rows: list[int]) -> Finding:
    """One finding for all segments that sweep the tool around a cone."""
    _turn, _after, what = _measure_first(path, moves, machine, rows[0])
    between = float(np.degrees(_measure_between(path, np.array(rows[:1]))[0]))
    text = (
        f"{what}, and the tilted tool sweeps around with it: the tool vectors at both ends are {between:.3g} deg "
        f"apart, and pass close to the vertical, but {' and '.join(machine.rotary_letters)} go linearly"
    )
    by_option = not moves.find_named(path.move[rows[:1]])[0]
    straight = "Leave --orientation angles out" if by_option else _STRAIGHT[moves.language]
    advice = f"{straight}: the tool axis then goes straight from vector to vector."
    return make_finding("VP301", text, severity="warning", advice=advice, **_count(path, rows))


def _report(path: ToolPath, moves: Moves, machine: Machine, rows: list[int], swung: bool) -> Finding:
    """One finding for segments that have one cause."""
    factor, letter = machine.columns[-1].factor, machine.rotary_letters[1]
    first = rows[0]
    turn, after, what = _measure_first(path, moves, machine, first)
    line, where, advice = int(path.line[first]), _count(path, rows), ""
    if swung:
        text = f"{what}: the tool axis passes close to the vertical; lead it through the vertical, or farther around"
    else:
        short = float(np.degrees(wrap_angle(np.radians(turn))))
        short = 0.0 if abs(short) <= np.degrees(ZERO_ANGLE) else short
        right = f"{letter}{_name_angle(after - turn + short)}"
        is_near = abs(short) <= _NEAR
        text = (
            f"{what}, and the tilted tool sweeps around with it; {right}, {_name_angle(abs(short))} deg away, holds "
            f"the same tool axis{'' if is_near else f', and turns hardly less: is another {letter} meant?'}"
        )
        then = ""
        if is_near and (last := _find_last_to_turn(path, first, (short - turn) / factor)):
            then = f"then add {short - turn:.6g} deg to {letter} in the lines up to {last} too"
        if is_near and not path.free[first]:
            advice = f"Write {right} in line {line}{then and f'; {then}'}."
            advice += f" Check again: {letter} of the other lines follows from it." if where["lines"] else ""
        elif then:
            text += f"; {then}"
    return make_finding("VP301", text, severity="warning", advice=advice, **where)


def _name_angle(value: float) -> str:
    """An angle, deg, as a person writes it: what radians leave of 0 is 0."""
    return f"{round(value, 6) + 0.0:.6g}"


def _find_last_to_turn(path: ToolPath, first: int, shift: float) -> int:
    """The last line after a segment whose C words need the same ``shift`` (rad, whole turns), so that the next does not
    turn C back; 0 where none does. The next wrap of a post ends them: it needs another shift.
    """
    rows = np.arange(first + 1, len(path))
    step = np.diff(path.end[first:, 4])
    goes_on = (np.abs(step) <= np.pi + ZERO_ANGLE) & (np.abs(step - shift) > np.pi)
    goes_on &= (path.feed_time[rows] > 0) & ~path.free[rows] & _is_tilted(path, rows)
    stops = np.flatnonzero(~goes_on)
    last = first + (int(stops[0]) if len(stops) else len(rows))
    return int(path.line[last]) if path.line[last] != path.line[first] else 0
