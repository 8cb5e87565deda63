"""The way from where the machine stands to the first pose of the program, in a safe order.

Retract along the tool axis to machine Z 0, turn the table under the standing spindle, position the
spindle over the first pose at machine Z 0, plunge along the first pose's tool axis. Never lower than
either end: a machine that already stands above Z 0 stays at its height for the turn.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Machine
from verne_post.model.moves import ZERO9, Frame
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.detour import Step, joined, pieces_of

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
        Step(_pose((tip, angles)), poses[0]),
        Step(*_ends(machine, q_retracted, q_turned, tool), np.stack([q_retracted, q_turned])),
        Step(*_ends(machine, q_turned, q_above, tool), np.stack([q_turned, q_above])),
        Step(poses[1], path.first_pose),
    ]
    way = pieces_of(steps, path, 0)
    # no line of the program contains the approach
    nowhere = replace(
        way, line=np.zeros_like(way.line), move=np.full_like(way.move, -1), tool_length=0 * way.length + tool
    )
    return joined([nowhere, path], path)


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
