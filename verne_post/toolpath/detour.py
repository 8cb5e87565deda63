"""Segments put between programmed ones where the table must go to another branch.

A rewind retracts along the tool axis to machine Z 0, turns the table there, and comes back to the same place on the
part. With a vertical tool C turns where it stands: the tip keeps its place on the part.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rotations import axis_of_angles
from verne_post.base.tolerances import POLE_SINE, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Machine
from verne_post.model.moves import ZERO9, Frame
from verne_post.model.toolpath import SegmentKind, ToolPath, sections_at
from verne_post.toolpath.branches import Change
from verne_post.toolpath.build import ROTARY_METRIC_MM

Array = NDArray[np.float64]

#: What a path keeps for each segment or dwell and takes over as it is when paths are joined.
_COLUMNS: Final = (
    "line", "kind", "start", "end", "tool_length", "feed_time", "length", "arc", "circle", "free", "move",
    "dwell_seconds", "dwell_line",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Step:
    """One segment of a detour: poses at both ends (5,), and joint values (2, n_joints) where it is linear in the joints."""

    start: Array
    end: Array
    joints: Array | None = None

    @property
    def moves(self) -> bool:
        """It is more than a point."""
        delta = self.end - self.start if self.joints is None else self.joints[1] - self.joints[0]
        return bool(np.abs(delta[:-2]).max() > ZERO_LENGTH_MM or np.abs(delta[-2:]).max() > ZERO_ANGLE)


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
        parts.append(segments_of(_steps(path, change, machine), path, change.segment))
        done = change.segment
    return join_paths([*parts, slice_path(path, done, len(path))], path)


def _steps(path: ToolPath, change: Change, machine: Machine) -> list[Step]:
    tip, tool = path.start[change.segment, :3], float(path.tool_length[change.segment])
    before, after = np.array(change.before), np.array(change.after)
    here, there = np.concatenate([tip, before]), np.concatenate([tip, after])
    if max(abs(np.sin(before[0])), abs(np.sin(after[0]))) <= POLE_SINE:
        return [Step(here, there)]
    axis = axis_of_angles(before[0], before[1])
    # machine Z of the gauge line grows by a millimetre a millimetre along the tool axis
    height = _machine_z(machine, tip, before, tool)
    away = tip + max(-height, 0.0) * axis
    q = []
    for angles in (before, after):
        joints, _position, _alpha, ok = machine.five_axis.solve(away, angles, tool)
        if not ok:
            line = int(path.line[change.segment])
            text = "the table cannot rewind here: the retracted place (machine Z 0 along the tool axis) is out of reach"
            raise InputError(finding("VP301", text, line=line, last_line=line, worst_line=line))
        q.append(joints)
    up, down = np.concatenate([away, before]), np.concatenate([away, after])
    return [Step(here, up), Step(up, down, np.array(q)), Step(down, there)]


def _machine_z(machine: Machine, tip: Array, angles: Array, tool: float) -> float:
    frame = Frame(tool=(0.0, 0.0, tool, *ZERO9[3:]))
    coordinates = machine.coordinates
    return float(coordinates.to_machine(coordinates.from_table(tip, angles, frame), frame)[2])


def segments_of(steps: Sequence[Step], like: ToolPath, segment: int) -> ToolPath:
    """Rapid segments that stop at every end, with line, tool and frame of a segment of another path."""
    steps = [step for step in steps if step.moves]
    n = len(steps)
    start = np.array([step.start for step in steps]).reshape(n, 5)
    end = np.array([step.end for step in steps]).reshape(n, 5)
    joints = [step.joints for step in steps if step.joints is not None]
    length = np.array([
        metric_length(step.end - step.start if step.joints is None else step.joints[1] - step.joints[0]) for step in steps
    ])  # fmt: skip
    linear = np.array([step.joints is None for step in steps], dtype=bool)
    n_joints = joints[0].shape[1] if joints else 0
    return replace(
        slice_path(like, 0, 0),
        line=np.full(n, like.line[segment], dtype=np.int32),
        kind=np.where(linear, SegmentKind.LINE, SegmentKind.JOINT).astype(np.int8),
        start=start,
        end=end,
        tool_length=np.full(n, like.tool_length[segment]),
        feed_time=np.zeros(n),
        length=length,
        arc=np.full(n, -1, dtype=np.int32),
        circle=np.full(n, -1, dtype=np.int32),
        free=np.full(n, like.free[segment]),
        joints=np.array(joints, dtype=float).reshape(len(joints), 2, n_joints),
        joint=np.where(linear, -1, np.cumsum(~linear) - 1).astype(np.int32),
        move=np.full(n, like.move[segment], dtype=np.int32),
        section=np.arange(n, dtype=np.int32),
    )


def metric_length(delta: Array) -> Array:
    """Metric length (...) of differences (..., k) whose last two are table angles, mm."""
    return np.hypot(
        np.linalg.norm(delta[..., :-2], axis=-1), ROTARY_METRIC_MM * np.linalg.norm(delta[..., -2:], axis=-1)
    )


def slice_path(path: ToolPath, first: int, last: int) -> ToolPath:
    """Segments ``first`` to ``last`` (excluded), with the dwells before the first of their runs and between them."""
    before = path.dwell_segment  # segment that a dwell stands before
    mine = (before >= first) & ((before < last) | (last == len(path)))
    if first == last:
        mine[:] = False
    section = np.cumsum(np.diff(path.section[first:last], prepend=-1) != 0).astype(np.int32) - 1
    dwell_section = sections_at(section, np.clip(before[mine] - first, 0, last - first))
    return replace(
        path.part(first, last), section=section, dwell_section=dwell_section,
        dwell_seconds=path.dwell_seconds[mine], dwell_line=path.dwell_line[mine],
    )  # fmt: skip


def join_paths(parts: Sequence[ToolPath], like: ToolPath) -> ToolPath:
    """Paths one after the other, with a stop in between; arcs and great circles are those of ``like``."""
    sections = np.append(0, np.cumsum([slice_path.n_sections for slice_path in parts])).astype(np.int32)
    offset, joints, joint = 0, [], []
    for one in parts:
        own = one.joint >= 0
        joint.append(np.where(own, one.joint + offset, -1).astype(np.int32))
        if own.any():
            joints.append(one.joints)
            offset += len(one.joints)

    together: dict[str, Any] = {name: np.concatenate([getattr(one, name) for one in parts]) for name in _COLUMNS}

    return replace(
        like,
        **together,
        joints=np.concatenate(joints) if joints else like.joints,
        joint=np.concatenate(joint),
        section=np.concatenate([one.section + shift for one, shift in zip(parts, sections[:-1], strict=True)]).astype(
            np.int32
        ),
        dwell_section=np.concatenate(
            [one.dwell_section + shift for one, shift in zip(parts, sections[:-1], strict=True)]
        ).astype(np.int32),
    )
