"""Rapids that are linear in the joints instead of straight for the tip: faster, and another path of the tool."""

import numpy as np
from msgspec.structs import replace

from verne_post.model.machine import Machine
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.metric import measure_metric


def make_rapids_joint(path: ToolPath, machine: Machine) -> ToolPath:
    """Make straight rapids, and rapids that turn the table under a standing spindle, JOINT segments between stops.

    A rapid with an end out of reach stays as it is; the constraint check names the reason.
    """
    straight = (path.kind == SegmentKind.LINE) | (path.kind == SegmentKind.TURN)
    rapid = np.flatnonzero((path.feed_time == 0) & straight)
    ends = [
        machine.five_axis.solve(pose[rapid, :3], pose[rapid, 3:], path.tool_length[rapid])
        for pose in (path.start, path.end)
    ]
    solved = ends[0][2] & ends[1][2]
    rapid = rapid[solved]
    if not len(rapid):
        return path
    joints = np.stack([q[solved] for q, _platform, _ok in ends], axis=1)
    kind, length, joint = path.kind.copy(), path.length.copy(), path.joint.copy()
    circle, turn = path.circle.copy(), path.turn.copy()
    kind[rapid], circle[rapid], turn[rapid] = SegmentKind.JOINT, -1, -1
    length[rapid] = measure_metric(joints[:, 1] - joints[:, 0])
    joint[rapid] = len(path.joints) + np.arange(len(rapid))
    earlier = path.joints if len(path.joints) else joints[:0]
    breaks = np.zeros(len(path), dtype=bool)
    breaks[1:] = path.section[1:] != path.section[:-1]
    breaks[rapid] = True
    breaks[rapid[rapid + 1 < len(path)] + 1] = True
    breaks[0] = False
    section = np.cumsum(breaks).astype(np.int32)
    return replace(
        path,
        kind=kind,
        length=length,
        joint=joint,
        circle=circle,
        turn=turn,
        joints=np.concatenate([earlier, joints]),
        section=section,
        dwell_section=path.renumber_dwells(section),
    )
