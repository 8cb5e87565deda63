"""A program that visits poses to be measured, and the order of the poses in it.

Between two poses the tool goes straight where every point on the way is within limits; else it goes back to a middle
pose over the table, upright, from which each planned pose is reached.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.units import DEG_PER_RAD
from verne_post.calibration.as_built.workspace import WorkspacePoses, solve_legal
from verne_post.model.machine import Machine

#: Points of a way that are tried. The checks of the whole program, which leave nothing out, come after.
POINTS: Final = 24
#: Decimals of the program, mm and degrees.
DECIMALS: Final = 3
#: Heights of the middle pose that are tried, as shares of the table's radius.
MIDDLES: Final = (1.0, 0.6, 1.4, 0.3, 1.8)


def round_poses(machine: Machine, poses: WorkspacePoses) -> tuple[WorkspacePoses, Mask]:
    """The poses as the program will say them, and which of them are still within limits (n,)."""
    tip = np.round(poses.tip, DECIMALS)
    angles = np.round(poses.angles * DEG_PER_RAD, DECIMALS) / DEG_PER_RAD
    joints, ok = solve_legal(machine, tip, angles, poses.length)
    return WorkspacePoses(tip, angles, poses.length, joints), ok


def find_middle(machine: Machine, lengths: Sequence[float]) -> Array:
    """Tip (3,) of the middle pose, within limits with every tool.

    Raises
    ------
    ValueError
        There is none.
    """
    length = np.array(lengths, dtype=float)
    for share in MIDDLES:
        tip = np.array([0.0, 0.0, round(share * machine.table_radius, DECIMALS)])
        ok = solve_legal(machine, np.tile(tip, (len(length), 1)), np.zeros((len(length), 2)), length)[1]
        if ok.all():
            return tip
    raise ValueError("no upright pose over the middle of the table is within limits with every tool")


def reach_from(machine: Machine, middle: Array, poses: WorkspacePoses) -> Mask:
    """Poses (n,) to which the straight way from the middle pose, with their own C, is within limits."""
    n = len(poses.length)
    upright = np.stack([np.zeros(n), poses.angles[:, 1]], axis=1)
    return _is_way_legal(machine, np.broadcast_to(middle, (n, 3)), upright, poses.tip, poses.angles, poses.length)


def _is_way_legal(machine: Machine, tip0: Array, angles0: Array, tip1: Array, angles1: Array, length: Array) -> Mask:
    """Ways (n,) whose tried points are all within limits."""
    share = np.linspace(0.0, 1.0, POINTS)[:, None, None]
    tip = tip0 + share * (tip1 - tip0)
    angles = angles0 + share * (angles1 - angles0)
    many = np.broadcast_to(length, tip.shape[:2]).ravel()
    ok = solve_legal(machine, tip.reshape(-1, 3), angles.reshape(-1, 2), many)[1]
    return np.asarray(ok.reshape(tip.shape[:2]).all(axis=0))


def order_poses(machine: Machine, poses: WorkspacePoses) -> tuple[list[int], list[bool]]:
    """The order in which poses are visited, tool by tool, and which motions go over the middle pose.

    The next pose is the one that the drives reach first among those with a straight way; else the nearest one.
    """
    order: list[int] = []
    over: list[bool] = []
    for length in np.unique(poses.length):
        left = np.flatnonzero(poses.length == length)
        at = int(left[np.argmin(np.abs(poses.angles[left, 0]))])
        order.append(at)
        over.append(True)
        left = left[left != at]
        while len(left):
            time = (np.abs(poses.joints[left] - poses.joints[at]) / machine.limits.velocity).max(axis=1)
            here = np.broadcast_to(poses.tip[at], (len(left), 3)), np.broadcast_to(poses.angles[at], (len(left), 2))
            straight = _is_way_legal(machine, *here, poses.tip[left], poses.angles[left], poses.length[left])
            over.append(not straight.any())
            at = int(left[np.argmin(np.where(straight, time, np.inf) if straight.any() else time)])
            order.append(at)
            left = left[left != at]
    return order, over


def write_program_lines(
    machine: Machine, middle: Array, poses: WorkspacePoses, over: Sequence[bool], dwell: float, readings: str
) -> Iterator[str]:
    """The program that visits poses (n,) in their order, and stands ``dwell`` seconds at each.

    Parameters
    ----------
    machine : Machine
        Its machine zero and senses; the program sets its own work offset, the table frame.
    middle : ndarray, shape (3,)
    over : sequence of bool
        Ways to each pose that go over the middle pose.
    readings : str
        Name of the file of readings, for the first comment.
    """
    origin = machine.coordinates.work_origin((0.0, 0.0, 0.0))
    a_sign, c_sign = (np.sign(column.factor) for column in machine.columns[-2:])
    yield f"(poses to measure; write the readings into {readings})\n"
    yield "G21 G90 G94 G17 G40 G49\n"
    yield "G10 L2 P1 X{} Y{} Z{} A0 C0 R0 (the table frame)\n".format(*(_number(value) for value in origin))
    yield "G54 G61.1\n"
    turn, tool = 0.0, None
    for row, (tip, angles, length) in enumerate(zip(poses.tip, poses.angles * DEG_PER_RAD, poses.length, strict=True)):
        a, c = angles[0] * a_sign, angles[1] * c_sign
        upright = f"X{_number(middle[0])} Y{_number(middle[1])} Z{_number(middle[2])} A0"
        if length != tool:
            if tool is not None:
                yield f"G0 {upright} C{_number(turn)}\n"
                yield f"M0 (change the tool: gauge line to tip {_number(length)} mm)\n"
            yield f"G43.1 Z{_number(length)}\n"
            yield f"G0 {upright} C{_number(c)}\n"
            tool = length
        elif over[row]:
            yield f"G0 {upright} C{_number(turn)}\n"
            yield f"G0 C{_number(c)}\n"
        yield (
            f"G0 X{_number(tip[0])} Y{_number(tip[1])} Z{_number(tip[2])} A{_number(a)} C{_number(c)} (pose "
            f"{row + 1})\n"
        )
        yield f"G4 P{dwell:g}\n"
        turn = c
    yield f"G0 X{_number(middle[0])} Y{_number(middle[1])} Z{_number(middle[2])} A0\n"
    yield "M2\n"


def _number(value: float) -> str:
    """A number of the program, without needless zeros."""
    return f"{round(value, DECIMALS) + 0.0:.{DECIMALS}f}".rstrip("0").rstrip(".")
