"""The whole program in the air: every pose lifted by the same distance, for a dry run."""

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.splines import lift_splines


def lift_path(path: ToolPath, distance: float, part_frame: Array, *, along_tool: bool) -> ToolPath:
    """A path lifted by ``distance`` (mm), along the tool axis or along z of the ``part_frame``.

    Along the tool axis the programmed tip path stays, and the machine moves as with a tool that is longer by as much.
    Segments that are linear in the joints cannot be lifted: they are to be made from lifted ends.
    """
    if (path.kind == SegmentKind.JOINT).any():
        raise ValueError("lift a path before its rapids become linear in the joints")
    if along_tool:
        return replace(
            path, tool_length=path.tool_length + distance, first_tool_length=path.first_tool_length + distance
        )
    up = np.array([*(part_frame @ [0.0, 0.0, distance]), 0.0, 0.0])
    return replace(
        path,
        start=path.start + up,
        end=path.end + up,
        first_pose=path.first_pose + up,
        arcs=replace(path.arcs, center=path.arcs.center + up[:3]),
        splines=lift_splines(path.splines, up[:3]),
        turns=replace(path.turns, shift=path.turns.shift + up[:3]),
    )
