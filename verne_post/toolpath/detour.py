"""Segments put between programmed ones where the table must go to another branch.

A rewind retracts along the tool axis to machine Z 0, turns the table there, and comes back to the same place on the
part. With a vertical tool C turns where it stands: the tip keeps its place on the part.
"""

from collections.abc import Sequence

import numpy as np

from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Machine
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.branches import Change
from verne_post.toolpath.splice import Step, join_paths, rapid_segments, retract_pose, slice_path


def add_detours(path: ToolPath, changes: Sequence[Change], machine: Machine) -> ToolPath:
    """Put a detour before the segment of every change.

    Raises
    ------
    InputError
        VP301 where the retracted place, or the turn there, is out of reach.
    """
    parts, done = [], 0
    for change in changes:
        parts.append(slice_path(path, done, change.segment))
        parts.append(rapid_segments(_plan_detour(path, change, machine), path, change.segment))
        done = change.segment
    return join_paths([*parts, slice_path(path, done, len(path))], path)


def _plan_detour(path: ToolPath, change: Change, machine: Machine) -> list[Step]:
    tip, tool = path.start[change.segment, :3], float(path.tool_length[change.segment])
    here, there = np.append(tip, change.before), np.append(tip, change.after)
    if change.upright:
        return [Step(here, there)]
    away = retract_pose(here, machine, tool)[:3]
    up, down = np.append(away, change.before), np.append(away, change.after)
    q, _platform, ok = machine.five_axis.solve(np.stack([up, down])[:, :3], np.stack([up, down])[:, 3:], tool)
    if not ok.all():
        line = int(path.line[change.segment])
        text = "the table cannot rewind here: the retracted place (machine Z 0 along the tool axis) is out of reach"
        raise InputError(finding("VP301", text, line=line, last_line=line, worst_line=line))
    return [Step(here, up), Step(up, down, q), Step(down, there)]
