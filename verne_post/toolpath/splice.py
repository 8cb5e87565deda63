"""Paths cut and joined: segments from no line of the program come before, between and after others.

Stops for a person become standstills (``--split-at-stops``): the file is cut there.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Machine
from verne_post.model.moves import MOVE_COLUMNS, ZERO9, Frame, MoveKind, Moves
from verne_post.model.toolpath import SEGMENT_COLUMNS, SegmentKind, ToolPath, find_sections
from verne_post.toolpath.metric import measure_metric

#: A stop stands as a dwell of this length, which becomes one cycle.
STOP_SECONDS: Final = 1e-9

#: What a path keeps for each segment or dwell and takes over as it is when paths are joined.
_COLUMNS: Final = (*(one for one in SEGMENT_COLUMNS if one not in ("joint", "section")), "dwell_seconds", "dwell_line")


#: Rise of Z of the machine per mm along the tool below which no retract goes along the tool.
_LEAST_RISE: Final = 0.2


class Step(Struct, frozen=True, eq=False):
    """One added segment: poses at both ends (5,), and joint values (2, n_joints) where it is linear in the joints."""

    start: Array
    end: Array
    joints: Array | None = None

    @property
    def delta(self) -> Array:
        """What changes from end to end: poses (5,), or joint values (n_joints,); the last two are table angles."""
        return self.end - self.start if self.joints is None else self.joints[1] - self.joints[0]

    @property
    def moves(self) -> bool:
        """It is more than a point."""
        delta = np.abs(self.delta)
        return bool(delta[:-2].max() > ZERO_LENGTH_MM or delta[-2:].max() > ZERO_ANGLE)


def retract_pose(pose: Array, machine: Machine, tool_length: float) -> Array:
    """The pose (5,) retracted along its tool axis until the gauge line is at machine Z 0, or unchanged if higher."""
    frame = Frame(tool=(0.0, 0.0, tool_length, *ZERO9[3:]))
    coordinates = machine.coordinates
    point = coordinates.map_to_machine(coordinates.map_from_table(pose[:3], pose[3:], frame), frame)
    if coordinates.head:
        axis = find_axis_of_angles(pose[3], pose[4])
        further = coordinates.map_to_machine(coordinates.map_from_table(pose[:3] + axis, pose[3:], frame), frame)
        return np.concatenate([pose[:3] + _find_retract(float(point[2]), float(further[2])) * axis, pose[3:]])
    point[2] = max(point[2], 0.0)
    return np.concatenate(coordinates.map_to_table(coordinates.map_to_program(point, frame), frame))


def _find_retract(height: float, further: float) -> float:
    """The way along the tool axis to machine Z 0, mm, where Z is at ``height``, and a mm along the axis at ``further``.

    Raises
    ------
    InputError
        VP018 where the tool lies too flat.
    """
    rise = further - height
    if height < 0.0 and rise < _LEAST_RISE:
        raise make_input_error(
            "VP018", "a retract along the tool axis does not reach machine Z 0: the tool is tilted too far there"
        )
    return max(-height, 0.0) / max(rise, _LEAST_RISE)


def make_rapid_segments(steps: Sequence[Step], like: ToolPath, segment: int) -> ToolPath:
    """Make rapid segments that stop at every end, with line, tool and frame of a segment of another path."""
    steps = [step for step in steps if step.moves]
    n = len(steps)
    joints = [step.joints for step in steps if step.joints is not None]
    linear = np.array([step.joints is None for step in steps], dtype=bool)
    return replace(
        slice_path(like, 0, 0),
        line=np.full(n, like.line[segment], dtype=np.int32),
        kind=np.where(linear, SegmentKind.LINE, SegmentKind.JOINT).astype(np.int8),
        start=np.array([step.start for step in steps]).reshape(n, 5),
        end=np.array([step.end for step in steps]).reshape(n, 5),
        tool_length=np.full(n, like.tool_length[segment]),
        feed_time=np.zeros(n),
        timed=np.zeros(n, dtype=bool),
        length=np.array([measure_metric(step.delta) for step in steps]),
        arc=np.full(n, -1, dtype=np.int32),
        spline=np.full(n, -1, dtype=np.int32),
        turn=np.full(n, -1, dtype=np.int32),
        circle=np.full(n, -1, dtype=np.int32),
        free=np.full(n, like.free[segment]),
        joints=np.array(joints, dtype=float).reshape(len(joints), 2, joints[0].shape[1] if joints else 0),
        joint=np.where(linear, -1, np.cumsum(~linear) - 1).astype(np.int32),
        move=np.full(n, like.move[segment], dtype=np.int32),
        section=np.arange(n, dtype=np.int32),
    )


def slice_path(path: ToolPath, first: int, last: int) -> ToolPath:
    """Cut out segments ``first`` to ``last`` (excluded), with the dwells before and between their sections."""
    before = path.dwell_segment  # segment that a dwell stands before
    mine = (before >= first) & ((before < last) | (last == len(path)))
    if first == last:
        mine[:] = False
    section = np.cumsum(np.diff(path.section[first:last], prepend=-1) != 0).astype(np.int32) - 1
    dwell_section = find_sections(section, np.clip(before[mine] - first, 0, last - first))
    return replace(
        path.take_part(first, last),
        section=section,
        dwell_section=dwell_section,
        dwell_seconds=path.dwell_seconds[mine],
        dwell_line=path.dwell_line[mine],
    )


def join_paths(parts: Sequence[ToolPath], like: ToolPath) -> ToolPath:
    """Join paths with stops in between; arcs, splines, turns and great circles are those of ``like``."""
    columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS}
    sections = np.cumsum([0, *(part.n_sections for part in parts)])
    for name in ("section", "dwell_section"):
        shifted = [getattr(part, name) + shift for part, shift in zip(parts, sections[:-1], strict=True)]
        columns[name] = np.concatenate(shifted).astype(np.int32)
    joint: list[NDArray[np.int32]] = []
    joints: list[Array] = []
    for part in parts:
        joint.append(np.where(part.joint >= 0, part.joint + sum(len(rows) for rows in joints), -1).astype(np.int32))
        if (part.joint >= 0).any():
            joints.append(part.joints)
    return replace(
        like, **columns, joint=np.concatenate(joint), joints=np.concatenate(joints) if joints else like.joints
    )


def insert_stops(
    moves: Moves, path: ToolPath, stops: Sequence[tuple[int, int]]
) -> tuple[Moves, ToolPath, tuple[int, ...]]:
    """Put standstills among the moves and along their path; returns both, and the numbers of the standstills.

    Parameters
    ----------
    path : ToolPath
        Of these moves.
    stops : sequence of (int, int)
        Number of the move that follows, and source line; ascending, each number once.
    """
    at = np.array([before for before, _line in stops], dtype=np.intp)
    rows = {name: np.insert(getattr(moves, name), at, getattr(moves, name)[at - 1], axis=0) for name in MOVE_COLUMNS}
    new = at + np.arange(len(at))
    rows["line"][new] = [line for _before, line in stops]
    rows["kind"][new], rows["feed"][new], rows["arc"][new], rows["spline"][new] = MoveKind.DWELL, STOP_SECONDS, -1, -1
    stopped = moves.insert(at, rows)
    return stopped, _insert_in_path(path, stopped, at), tuple(new.tolist())


def count_with_stops(moves: Moves, count: int) -> int:
    """How many moves there are up to the last of the first ``count`` that are no inserted standstills."""
    return int(np.flatnonzero(find_recorded(moves))[count - 1]) + 1 if count > 0 else 0


def find_recorded(moves: Moves) -> NDArray[np.bool_]:
    """Which moves are no inserted standstills."""
    return (moves.kind != MoveKind.DWELL) | (moves.feed != STOP_SECONDS)


def _insert_in_path(path: ToolPath, moves: Moves, at: NDArray[np.intp]) -> ToolPath:
    """Put standstills into the path before the moves ``at``, which are counted without them."""
    move = path.move + np.searchsorted(at, path.move, side="right")
    new_section = np.diff(path.section, prepend=path.section[:1]) > 0
    new_section[np.searchsorted(path.move, at)] = True
    new_section[0] = False
    section = np.cumsum(new_section).astype(np.int32)
    dwell = moves.dwells
    return replace(
        path,
        move=move.astype(np.int32),
        section=section,
        dwell_section=find_sections(section, np.searchsorted(move, dwell)),
        dwell_seconds=moves.feed[dwell],
        dwell_line=moves.line[dwell],
        called_lines=moves.called_lines,
    )
