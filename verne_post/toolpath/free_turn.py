"""A vertical tool leaves C free: the constant C that keeps farthest from every limit.

The margin of an angle is the smallest one over the whole path, as ``margins`` measures it. Margins that C does not
change, such as the height of a retract on a serial machine, do not count: they would hide the others. Clearances do not
count either; the clearance check measures them.
"""

from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.ragged import number_parts
from verne_post.base.tolerances import MARGIN_GAIN, POLE_SINE, ZERO_ANGLE
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Machine
from verne_post.model.summary import FreeTurn
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.evaluate import evaluate_pose
from verne_post.toolpath.margins import Margins, list_margin_functions

#: Candidates of the first round, rad apart.
COARSE: Final = np.radians(5.0)
#: So many of them are refined, each by rounds of this many points over two steps of the round before.
REFINED: Final = 3
POINTS: Final = 9
ROUNDS: Final = 5
#: Points along a segment: at most this far apart, mm, and at least two.
STEP_MM: Final = 10.0
MOST_POINTS: Final = 64
#: One of the points in a cube of this size, mm, is enough to choose by; the reported margin is that of all points.
CUBE_MM: Final = 2.0
#: Poses solved together.
BATCH: Final = 200_000


class _Points(Struct, frozen=True, eq=False):
    tip: Array
    tool: Array


def choose_free_turn(path: ToolPath, fixes: int | None, machine: Machine) -> tuple[ToolPath, FreeTurn]:
    """Turn a path to the best constant C.

    Parameters
    ----------
    path : ToolPath
        Before any approach or detour.
    fixes : int or None
        First source line that names C, or a place in machine coordinates that depends on it.

    Raises
    ------
    InputError
        VP018 where the tool is not vertical throughout, or the program names C.
    """
    margins, names = list_margin_functions(machine)
    _require_free(path, fixes)
    points = _sample(path)
    few = _thin(points)
    before = float(path.start[0, 4])
    low, high = float(machine.limits.lower[-1]), float(machine.limits.upper[-1])
    if not (np.isfinite(low) and np.isfinite(high)):
        low, high = -np.pi, np.pi
    angles = np.linspace(low, high, max(int(np.ceil((high - low) / COARSE)), 1) + 1)
    table = _find_smallest(few, angles, margins)
    with np.errstate(invalid="ignore"):
        moved = ~(np.ptp(table, axis=0) <= MARGIN_GAIN)  # also where some angles are out of reach
    if not moved.any():
        moved[:] = True
    best = [angles[k] for k in _order_by_margin(table[:, moved].min(axis=1), angles, before)[:REFINED]]
    step = float(angles[1] - angles[0])
    for _ in range(ROUNDS):
        around = np.clip(np.concatenate([c + step * np.linspace(-1, 1, POINTS) for c in best]), low, high)
        value = _find_smallest(few, around, margins)[:, moved].min(axis=1)
        best = [
            group[int(np.argmax(v))]
            for group, v in zip(around.reshape(-1, POINTS), value.reshape(-1, POINTS), strict=True)
        ]
        step *= 2.0 / (POINTS - 1)
    every = np.array([before, *best])
    table = np.where(moved, _find_smallest(points, every, margins), np.inf)
    smallest = table.min(axis=1)
    top = int(_order_by_margin(smallest, every, before)[0])
    chosen = top if smallest[top] > smallest[0] + MARGIN_GAIN else 0
    start, end, first = path.start.copy(), path.end.copy(), path.first_pose.copy()
    start[:, 4] = end[:, 4] = first[4] = every[chosen]
    turn = FreeTurn(
        before, float(every[chosen]), float(smallest[0]), float(smallest[chosen]), names[int(np.argmin(table[chosen]))]
    )
    return replace(path, start=start, end=end, first_pose=first), turn


def _order_by_margin(value: Array, c: Array, before: float) -> NDArray[np.intp]:
    """Order angles by their margin; of equal ones (to six digits) the nearest to where C stood."""
    return np.lexsort((np.abs(c - before), -np.round(value, 6)))


def _require_free(path: ToolPath, fixes: int | None) -> None:
    tilt = np.maximum(np.abs(path.start[:, 3]), np.abs(path.end[:, 3]))
    turned = np.maximum(np.abs(path.start[:, 4] - path.start[0, 4]), np.abs(path.end[:, 4] - path.start[0, 4]))
    tilted = path.line[tilt > POLE_SINE]
    named = [*path.line[turned > ZERO_ANGLE][:1].tolist(), *([] if fixes is None else [fixes])]
    if len(tilted) and (not named or tilted[0] <= min(named)):
        line, why = int(tilted[0]), "this line tilts the tool, or begins with a tilted one"
    elif named:
        line, why = min(named), "this line names C, or a place in machine coordinates that depends on it"
    else:
        return
    text = f"--free-c needs a program whose tool is always vertical and that never names C; {why}"
    raise make_input_error("VP018", text, line=line)


def _sample(path: ToolPath) -> _Points:
    """Sample tips along the path, and the tool lengths there."""
    parts = np.clip(np.ceil(path.length / STEP_MM), 1, MOST_POINTS).astype(int)
    curved = np.isin(path.kind, (SegmentKind.ARC, SegmentKind.SPLINE, SegmentKind.TURN))
    parts[curved] = np.maximum(parts[curved], 16)
    segment, index = number_parts(parts + 1)
    tip, _angles = evaluate_pose(path, segment, index / parts[segment])
    return _Points(tip, path.tool_length[segment])


def _thin(points: _Points) -> _Points:
    cubes = np.column_stack([np.floor(points.tip / CUBE_MM), points.tool])
    _cube, first = np.unique(cubes, axis=0, return_index=True)
    return _Points(points.tip[first], points.tool[first])


def _find_smallest(points: _Points, c: Array, margins: Margins) -> Array:
    """Smallest value (n, k) of every margin at every angle (n,)."""
    smallest = []
    each = max(BATCH // len(points.tool), 1)
    for first in range(0, len(c), each):
        tried = c[first : first + each]
        parts = []
        for begin in range(0, len(points.tool), BATCH):
            tip, tool = points.tip[begin : begin + BATCH], points.tool[begin : begin + BATCH]
            angles = np.column_stack([np.zeros(len(tool) * len(tried)), np.repeat(tried, len(tool))])
            value = margins(np.tile(tip, (len(tried), 1)), angles, np.tile(tool, len(tried)))
            parts.append(value.reshape(len(tried), len(tool), -1).min(axis=1))
        smallest.append(np.min(parts, axis=0))
    return np.concatenate(smallest)
