"""Approach and departure: from where the machine stands to the first pose, and from the last pose to a goal.

In a safe order: retract along the tool axis to machine Z 0, turn the table under the standing spindle, position the
spindle over the goal at machine Z 0, plunge along the goal's tool axis. Never lower than either end: a machine that
already stands above Z 0 stays at its height for the turn.

Detours go between segments, where the table must go to another branch. A rewind retracts along the tool axis to machine
Z 0, turns the table there, and comes back to the same place on the part. With a vertical tool C turns in place: the tip
keeps its place on the part.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.numbers import format_fixed
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.contour import Contour
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Machine
from verne_post.model.moves import Frame
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.branches import Change
from verne_post.toolpath.contour import make_exact_contour
from verne_post.toolpath.contour_pose import find_contour_pose
from verne_post.toolpath.elements import find_feeds
from verne_post.toolpath.splice import Step, join_paths, make_rapid_segments, retract_pose, slice_path

Place = str | tuple[float, ...]

#: An approach to the middle of a program feeds over this last part of its plunge, mm: material may stand there.
CAREFUL_MM: Final = 10.0
#: Actuators of six legs may be off the place that rows have for the same tool by this: a step that a drive follows.
OWN_TURN_MM: Final = 1e-3
#: Columns of a contour for each element that are taken over as they are when contours are joined.
_COLUMNS: Final = ("low", "high", "length", "rotation", "blended")


def find_joints_of_place(machine: Machine, place: Place, option: str) -> Array:
    """Joint values (mm, rad, workpiece sense) of "home", of "park", or of values in file units.

    Raises
    ------
    InputError
        VP015 where the machine file does not know the place, VP018 where it is out of reach or the values are too few.
    """
    if not isinstance(place, str):
        if len(place) != len(machine.columns):
            names = ",".join(column.joint for column in machine.columns)
            raise make_input_error("VP018", f"{option} takes home, or {len(machine.columns)} values {names}")
        q = np.array(place, dtype=float) / [column.factor for column in machine.columns]
        if not machine.columns[-1].driven:
            _require_own_turn(machine, q, option)
        return q
    stored = {"home": machine.home.g28, "park": machine.home.park} if machine.home else {}
    home = stored.get(place)
    if home is None:
        key = "[home]" if place == "home" else "home.park"
        raise make_input_error("VP015", f"{option} {place} needs {key} in the machine file")
    point = machine.place_stored(home)
    tip, angles = machine.coordinates.map_to_table(machine.coordinates.map_to_program(point, Frame()), Frame())
    q, _platform, ok = machine.five_axis.solve(tip, angles, 0.0)
    if not ok:
        raise make_input_error("VP018", f"{option} {place}: this position of the machine file is out of reach")
    return q


def _require_own_turn(machine: Machine, q: Array, option: str) -> None:
    """Refuse actuators (n_joints,) with another turn about the tool axis than rows have: they would jump at once."""
    tip, angles, ok = machine.five_axis.find_nominal_pose(q, 0.0)
    own = machine.five_axis.find_joints(tip, angles, 0.0)
    n = len(machine.actuators)
    if ok and np.isfinite(own).all() and np.abs(own - q)[:n].max() > OWN_TURN_MM:
        values = ", ".join(
            f"{name} {format_fixed(value, 4)}" for name, value in zip(machine.actuators, own[:n].tolist(), strict=True)
        )
        raise make_input_error(
            "VP018",
            f"{option}: there the platform is turned about the tool axis otherwise than this machine turns it; "
            f"bring it to {values} first, with the tool in the same place",
        )


def add_approach_and_departure(
    contour: Contour, machine: Machine, start: Array | None, goal: Array | None, start_at: tuple[int, int] | None = None
) -> Contour:
    """Put an approach from joint values ``start`` before a contour, and a departure to joint values ``goal`` after it.

    Parameters
    ----------
    start, goal : ndarray, shape (n_joints,), or None
        mm and rad, workpiece sense; None for no approach or no departure.
    start_at : (int, int), optional
        A restart: the contour begins with this segment and this dwell; what comes before is left out. The rest stays as
        it is. Where the first corner is blended, the contour begins in the middle of the blend.

    Raises
    ------
    InputError
        VP018 when an end, or the place above it, cannot be taken by the machine.
    """
    path = contour.path
    first, first_dwell = start_at or (0, 0)
    kept = np.flatnonzero(contour.segment >= first)
    entry = np.concatenate([pose[0] for pose in find_contour_pose(contour, kept[:1], np.zeros(1))])
    before = after = slice_path(path, 0, 0)
    if start is not None:
        tool = float(path.tool_length[first])
        here = _find_pose(machine, start, tool, "--from")
        feed = _find_plunge_feed(contour, first) if start_at else np.inf
        before = _connect(path, machine, (here, entry), tool, "--from", feed)
    if goal is not None:
        tool = float(path.tool_length[-1])
        after = _connect(path, machine, (path.end[-1], _find_pose(machine, goal, tool, "--to")), tool, "--to")

    def extend(middle: ToolPath) -> ToolPath:
        rest = _drop_dwells(slice_path(middle, first, len(path)), middle, first, first_dwell)
        return join_paths([before, rest, after], path)

    whole, shape = extend(path), extend(contour.shape)
    if start_at:
        whole = replace(whole, first_pose=entry, first_tool_length=float(path.tool_length[first]))
    shift = len(before) - first
    sections = before.n_sections - int(contour.section[kept[0]])
    middle = replace(contour.select(kept), section=contour.section[kept])
    parts = make_exact_contour(before), middle, make_exact_contour(after)
    columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS}
    for name, shifts in (
        ("segment", (0, shift, shift + len(path))),
        ("section", (0, sections, sections + contour.n_sections)),
    ):
        shifted = [getattr(part, name) + by for part, by in zip(parts, shifts, strict=True)]
        columns[name] = np.concatenate(shifted).astype(np.int32)
    for name in ("tip_tolerance", "axis_tolerance"):
        columns[name] = np.pad(getattr(contour, name)[first:], (len(before), len(after)))
    return replace(
        contour,
        **columns,
        path=whole,
        shape=shape,
        feeds=find_feeds(whole),
        corners=contour.corners and replace(contour.corners, shift=contour.corners.shift - shift),
        dwell_section=(contour.dwell_section[first_dwell:] + sections).astype(np.int32),
        entry=len(before) if start_at else -1,
    )


def _drop_dwells(rest: ToolPath, path: ToolPath, first: int, first_dwell: int) -> ToolPath:
    """Drop the dwells before ``first_dwell`` from the part of a path from segment ``first`` on."""
    dropped = first_dwell - int((path.dwell_segment < first).sum())
    return replace(
        rest,
        dwell_section=rest.dwell_section[dropped:],
        dwell_seconds=rest.dwell_seconds[dropped:],
        dwell_line=rest.dwell_line[dropped:],
    )


def _find_plunge_feed(contour: Contour, first: int) -> float:
    """Feed rate of the tip (mm/s) of the first feed move from a segment on, else of the last one before it."""
    feeds = contour.feeds
    fed = np.flatnonzero((feeds.rate > 0) & np.isfinite(feeds.rate))
    if not len(fed):
        return np.inf
    after = fed[fed >= first]
    return float(feeds.rate[after[0] if len(after) else fed[-1]])


def _connect(
    like: ToolPath, machine: Machine, ends: tuple[Array, Array], tool: float, option: str, feed: float = np.inf
) -> ToolPath:
    """Connect two poses (5,) in the safe order; the last part of the plunge at ``feed`` (mm/s) where it is finite."""
    here, there = ends
    retracted, above = (retract_pose(pose, machine, tool) for pose in ends)
    q_retracted, q_above = (_solve(machine, pose, tool, option) for pose in (retracted, above))
    q_turned = np.append(q_retracted[:-2], q_above[-2:])
    turn, travel = np.stack([q_retracted, q_turned]), np.stack([q_turned, q_above])
    height = float(np.linalg.norm(above[:3] - there[:3]))
    near = there.copy()
    if np.isfinite(feed):
        near[:3] += min(CAREFUL_MM, height) * find_axis_of_angles(there[3], there[4])
    steps = [
        Step(here, retracted),
        _make_joint_step(machine, turn, tool),
        _make_joint_step(machine, travel, tool),
        Step(above, near),
        Step(near, there),
    ]
    path = make_rapid_segments(steps, like, 0)
    n = len(path)
    feed_time = np.zeros(n)
    if np.isfinite(feed) and height > ZERO_LENGTH_MM:
        feed_time[-1] = path.length[-1] / feed
    # no line of the program contains these segments
    return replace(
        path,
        line=np.zeros_like(path.line),
        move=np.full_like(path.move, -1),
        tool_length=np.full(n, tool),
        feed_time=feed_time,
    )


def _find_pose(machine: Machine, q: Array, tool: float, option: str) -> Array:
    tip, angles, ok = machine.five_axis.find_nominal_pose(q, tool)
    if not ok:
        raise make_input_error("VP018", f"{option}: no position of the platform fits these joint values")
    return np.concatenate([tip, angles])


def _make_joint_step(machine: Machine, q: Array, tool: float) -> Step:
    """A step that is linear in the joints, between joint values (2, n_joints)."""
    tip, angles, _ok = machine.five_axis.find_nominal_pose(q, tool)
    start, end = np.concatenate([tip, angles], axis=1)
    return Step(start, end, q)


def _solve(machine: Machine, pose: Array, tool: float, option: str) -> Array:
    q, _platform, ok = machine.five_axis.solve(pose[:3], pose[3:], tool)
    if not ok:
        text = f"{option}: the retracted position, or the one above the goal, is out of reach"
        raise make_input_error("VP018", text)
    return q


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
        parts.append(make_rapid_segments(_plan_detour(path, change, machine), path, change.segment))
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
        text = (
            f"the {machine.rotary_side} cannot rewind here: the retracted place (machine Z 0 along the tool axis) is "
            "out of reach"
        )
        raise make_input_error("VP301", text, line=line)
    return [Step(here, up), Step(up, down, q), Step(down, there)]
