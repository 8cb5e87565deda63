"""The way from where the machine stands to the first pose of the program, in a safe order.

Retract along the tool axis to machine Z 0, turn the table under the standing spindle, position the
spindle over the first pose at machine Z 0, plunge along the first pose's tool axis. Never lower than
either end: a machine that already stands above Z 0 stays at its height for the turn.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from verne_post.base.tolerances import ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Machine
from verne_post.model.moves import ZERO9, Frame
from verne_post.model.toolpath import ArcPieces, PieceKind, ToolPath
from verne_post.toolpath.build import ROTARY_METRIC_MM

Array = NDArray[np.float64]


def with_approach(path: ToolPath, machine: Machine, q_start: Array) -> ToolPath:
    """Put the approach from joint values ``q_start`` (mm, rad, workpiece sense) before a path.

    Raises
    ------
    InputError
        VP018 when the start or the point above the first pose cannot be taken by the machine.
    """
    tool = path.first_tool_length
    frame = Frame(tool=(0.0, 0.0, tool, *ZERO9[3:]))
    five_axis, coordinates = machine.five_axis, machine.coordinates
    tip, angles, ok = five_axis.nominal(q_start, tool)
    if not ok:
        raise InputError(finding("VP018", "--from: these joint values close no position of the platform"))
    here = coordinates.to_machine(coordinates.from_table(tip, angles, frame), frame)
    first = coordinates.to_machine(coordinates.from_table(path.first_pose[:3], path.first_pose[3:], frame), frame)

    retracted, above = here.copy(), first.copy()
    retracted[2] = max(here[2], 0.0)
    above[2] = max(first[2], 0.0)
    poses = [_pose(coordinates.to_table(coordinates.to_program(point, frame), frame)) for point in (retracted, above)]
    q_retracted, q_above = (_joints(machine, pose, tool) for pose in poses)
    q_turned = np.concatenate([q_retracted[:-2], q_above[-2:]])
    steps = [
        (PieceKind.LINE, _pose((tip, angles)), poses[0], None),
        (PieceKind.JOINT, *_ends(machine, q_retracted, q_turned, tool), (q_retracted, q_turned)),
        (PieceKind.JOINT, *_ends(machine, q_turned, q_above, tool), (q_turned, q_above)),
        (PieceKind.LINE, poses[1], path.first_pose, None),
    ]
    moving = [step for step in steps if _moves(step[1], step[2], step[3])]
    return _join(_approach_path(moving, path, tool), path)


def _pose(table: tuple[Array, Array]) -> Array:
    return np.concatenate(table)


def _joints(machine: Machine, pose: Array, tool: float) -> Array:
    q, _position, _alpha, ok = machine.five_axis.solve(pose[:3], pose[3:], tool)
    if not ok:
        text = "--from: the retracted position, or the one above the first pose, is out of reach"
        raise InputError(finding("VP018", text))
    return q


def _ends(machine: Machine, q_from: Array, q_to: Array, tool: float) -> tuple[Array, Array]:
    tip, angles, _ok = machine.five_axis.nominal(np.stack([q_from, q_to]), tool)
    return np.concatenate([tip[0], angles[0]]), np.concatenate([tip[1], angles[1]])


def _moves(start: Array, end: Array, joints: tuple[Array, Array] | None) -> bool:
    delta = end - start if joints is None else joints[1] - joints[0]
    return bool(np.abs(delta[:-2]).max() > ZERO_LENGTH_MM or np.abs(delta[-2:]).max() > ZERO_ANGLE)


def _approach_path(
    steps: list[tuple[PieceKind, Array, Array, tuple[Array, Array] | None]], path: ToolPath, tool: float
) -> ToolPath:
    n = len(steps)
    start = np.array([step[1] for step in steps]).reshape(n, 5)
    end = np.array([step[2] for step in steps]).reshape(n, 5)
    joints = [step[3] for step in steps if step[3] is not None]
    row, count = np.full(n, -1, dtype=np.int32), 0
    length = np.empty(n)
    for index, (_kind, begin, stop, pair) in enumerate(steps):
        delta = stop - begin if pair is None else pair[1] - pair[0]
        length[index] = np.hypot(np.linalg.norm(delta[:-2]), ROTARY_METRIC_MM * np.linalg.norm(delta[-2:]))
        if pair is not None:
            row[index] = count
            count += 1
    n_joints = len(joints[0][0]) if joints else 5
    none, empty = np.empty(0), np.empty((0, 3))
    return replace(
        path,
        line=np.zeros(n, dtype=np.int32),
        kind=np.array([step[0] for step in steps], dtype=np.int8),
        start=start,
        end=end,
        tool_length=np.full(n, tool),
        feed_time=np.zeros(n),
        length=length,
        arc=np.full(n, -1, dtype=np.int32),
        arcs=ArcPieces(empty, empty, empty, empty, none, none, none),
        joints=np.array(joints, dtype=float).reshape(count, 2, n_joints),
        joint=row,
        move=np.full(n, -1, dtype=np.int32),
        run=np.arange(n, dtype=np.int32),
    )


def _join(first: ToolPath, second: ToolPath) -> ToolPath:
    """One path after the other; the second has no JOINT pieces of its own."""
    runs = np.int32(first.n_runs)
    return replace(
        second,
        line=np.concatenate([first.line, second.line]),
        kind=np.concatenate([first.kind, second.kind]),
        start=np.concatenate([first.start, second.start]),
        end=np.concatenate([first.end, second.end]),
        tool_length=np.concatenate([first.tool_length, second.tool_length]),
        feed_time=np.concatenate([first.feed_time, second.feed_time]),
        length=np.concatenate([first.length, second.length]),
        move=np.concatenate([first.move, second.move]),
        arc=np.concatenate([first.arc, second.arc]),
        joints=first.joints,
        joint=np.concatenate([first.joint, second.joint]),
        run=np.concatenate([first.run, second.run + runs]),
        dwell_run=second.dwell_run + runs,
    )
