"""A contradiction that shows a wrong sense of rotation: a plane turns the table back."""

from collections.abc import Iterator

import numpy as np

from verne_post.base.tolerances import UPRIGHT_DEG
from verne_post.model.findings import Finding, make_finding
from verne_post.model.machine import Machine
from verne_post.model.moves import AXES, MoveKind, Moves

#: Rapids between the words of the rotary axes, the plane, and the turn to it.
_MOST_BETWEEN = 3
#: Programs round angles to three decimals, and planes to as many.
_SAME_DEG = 0.01
#: In place of the advice to turn the axis on the machine first.
_CORRECT_ANGLES = (
    "Correct the angles before the plane, or those of the plane. If both are right, turn the axis on the machine by a "
    "positive angle, and correct its sense in the machine file."
)


def check_senses(moves: Moves, machine: Machine) -> Iterator[Finding]:
    """VP054, once a program: the angles named before a plane would hold it if an axis had the opposite sense.

    Of a nutating pair no sign of a word tells the two apart. Where the machine file has measured senses, the angles are
    in doubt first.
    """
    coordinates, sources = machine.coordinates, machine.provenance
    if coordinates.nutation is not None:
        return
    (tilt, turn), reached = coordinates.rotary, -1
    for plane in (one for one in moves.planes if one.word):
        first = plane.before
        while first > 0 and moves.line[first - 1] == plane.line:  # PLANE with MOVE or TURN; a retract of CYCLE800
            first -= 1
        named, before = _find_turn(moves, first - 1, -1), reached
        reached = _find_turn(moves, first, 1)
        if named < 0 or reached < 0 or named == before:
            continue
        ends = moves.end[[named, reached]][:, [tilt, turn]]
        (a, c), (other_a, other_c) = (np.round(ends, 6) + 0.0).tolist()  # no -0
        if abs(a) <= UPRIGHT_DEG or _is_same(a, c, other_a, other_c):
            continue
        senses = ((tilt, (-a, c)), (turn, (a, -c)))
        wrong = [AXES[axis] for axis, (tilted, turned) in senses if _is_same(tilted, turned, other_a, other_c)]
        if wrong:
            line, end = int(moves.line[named]), int(moves.line[reached])
            keys = " or ".join(f"{letter.lower()}_positive" for letter in wrong)
            angles = f"{AXES[tilt]}{a:.6g} {AXES[turn]}{c:.6g}"
            is_measured = sources.get("joints", sources.get("table", "")).startswith("measured")
            asked = f"is {angles} meant? The senses of the machine file are measured; if it is, " * is_measured
            text = (
                f"{angles} before the plane of {plane.word} in line {plane.line}, which "
                f"line {end} turns to {AXES[tilt]}{other_a:.6g} {AXES[turn]}{other_c:.6g}: the named angles would hold "
                f"this plane if {' or '.join(wrong)} had the opposite sense; {asked}compare {keys} of [table], or "
                "positive of the joint, in the machine file with the control"
            )
            advice = _CORRECT_ANGLES if is_measured else None
            yield make_finding("VP054", text, line=line, advice=advice)
            return


def _is_same(a: float, c: float, other_a: float, other_c: float) -> bool:
    """Whether two pairs of angles, degrees, hold the same tool axis."""
    half = 0.0 if abs(a - other_a) <= _SAME_DEG else 180.0
    turned = abs(np.remainder(c - other_c + half + 180.0, 360.0) - 180.0)
    return (half == 0.0 or abs(a + other_a) <= _SAME_DEG) and bool(turned <= _SAME_DEG)


def _find_turn(moves: Moves, first: int, step: int) -> int:
    """The first move from ``first`` on that turns a rotary axis, behind a few rapids; -1 without one."""
    for at in range(first, first + step * _MOST_BETWEEN, step):
        if not 0 <= at < len(moves) or moves.kind[at] not in (MoveKind.RAPID, MoveKind.TURN):
            return -1
        before = moves.end[at - 1] if at else moves.start
        # where a program starts, the table stands as the first line that names its angles says
        if (moves.end[at, 3:6] != before[3:6]).any() or (step < 0 and moves.line[at] == moves.fixes_c):
            return at
    return -1
