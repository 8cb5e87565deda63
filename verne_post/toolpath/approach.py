"""Ways that the program does not contain: from where the machine stands to the first pose, and from the last pose home.

In a safe order: retract along the tool axis to machine Z 0, turn the table under the standing spindle, position the
spindle over the goal at machine Z 0, plunge along the goal's tool axis. Never lower than either end: a machine that
already stands above Z 0 stays at its height for the turn.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rotations import axis_of_angles
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.contour import Contour
from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Machine
from verne_post.model.moves import ZERO9, Frame
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.contour import exact_contour, feeds_of
from verne_post.toolpath.contour_pose import contour_pose
from verne_post.toolpath.detour import Step, join_paths, segments_of, slice_path

Array = NDArray[np.float64]
Place = str | tuple[float, ...]

#: A way into the middle of a program feeds over this last part of its plunge, mm: material may stand there.
CAREFUL_MM: Final = 10.0


def joints_at_place(machine: Machine, place: Place, option: str) -> Array:
    """Joint values (mm, rad, workpiece sense) of "home", of "park", or of values in file units.

    Raises
    ------
    InputError
        VP015 where the machine file does not know the place, VP018 where it is out of reach or the values are too few.
    """
    if not isinstance(place, str):
        if len(place) != len(machine.columns):
            names = ",".join(column.joint for column in machine.columns)
            raise InputError(finding("VP018", f"{option} takes home, or {len(machine.columns)} values {names}"))
        return np.array(place, dtype=float) / [column.factor for column in machine.columns]
    stored = {"home": machine.home.g28, "park": machine.home.park} if machine.home else {}
    home = stored.get(place)
    if home is None:
        key = "[home]" if place == "home" else "home.park"
        raise InputError(finding("VP015", f"{option} {place} needs {key} in the machine file"))
    x, y, z, a, c = home
    point = np.array([x, y, z, a, 0.0, c, 0.0, 0.0, 0.0])
    tip, angles = machine.coordinates.to_table(machine.coordinates.to_program(point, Frame()), Frame())
    q, _position, _alpha, ok = machine.five_axis.solve(tip, angles, 0.0)
    if not ok:
        raise InputError(finding("VP018", f"{option} {place}: this position of the machine file is out of reach"))
    return q


def add_approach_and_departure(
    contour: Contour, machine: Machine, start: Array | None, goal: Array | None, start_at: tuple[int, int] | None = None
) -> Contour:
    """Put the way from joint values ``start`` before a contour, and the way to joint values ``goal`` behind it.

    Parameters
    ----------
    contour : Contour
    machine : Machine
    start, goal : ndarray, shape (n_joints,), or None
        mm and rad, workpiece sense; None for no such way.
    start_at : (int, int), optional
        A restart: the contour begins with this segment and this dwell; what comes before is left out. The rest stays what
        it is, also where the first corner is rounded: there the contour begins in its middle.

    Raises
    ------
    InputError
        VP018 when an end, or the place above it, cannot be taken by the machine.
    """
    path = contour.path
    first, first_dwell = start_at or (0, 0)
    own = np.flatnonzero(contour.segment >= first)
    entry = np.concatenate([pose[0] for pose in contour_pose(contour, own[:1], np.zeros(1))])
    before, behind = slice_path(path, 0, 0), slice_path(path, 0, 0)
    if start is not None:
        tool = float(path.tool_length[first])
        here = _pose_of(machine, start, tool, "--from")
        feed = _plunge_feed(contour, first) if start_at else np.inf
        before = _way(path, machine, here, entry, tool, "--from", feed)
    if goal is not None:
        tool = float(path.tool_length[-1])
        behind = _way(path, machine, path.end[-1], _pose_of(machine, goal, tool, "--to"), tool, "--to")

    def framed(middle: ToolPath) -> ToolPath:
        return join_paths(
            [before, _from_dwell(slice_path(middle, first, len(path)), middle, first, first_dwell), behind], path
        )

    whole = framed(path)
    if start_at:
        whole = replace(whole, first_pose=entry, first_tool_length=float(path.tool_length[first]))
    shape = framed(contour.shape)
    ways = exact_contour(before), exact_contour(behind)
    shift = len(before) - first
    sections = before.n_sections - int(contour.section[own[0]])
    segment_shifts = (0, shift, shift + len(path))
    section_shifts = (0, sections, sections + contour.n_sections)
    middle = contour.only(own)
    parts = (ways[0], replace(middle, section=contour.section[own]), ways[1])

    def column(name: str) -> Array:
        return np.concatenate([getattr(one, name) for one in parts])

    zeros = [np.zeros(len(way)) for way in (before, behind)]
    return replace(
        contour,
        path=whole,
        shape=replace(whole, start=shape.start, end=shape.end),
        segment=np.concatenate([one.segment + by for one, by in zip(parts, segment_shifts, strict=True)]).astype(
            np.int32
        ),
        section=np.concatenate([one.section + by for one, by in zip(parts, section_shifts, strict=True)]).astype(
            np.int32
        ),
        curve=column("curve").astype(np.int32),
        low=column("low"),
        high=column("high"),
        length=column("length"),
        turn=column("turn"),
        blended=column("blended").astype(bool),
        corners=contour.corners and replace(contour.corners, shift=contour.corners.shift - shift),
        feeds=feeds_of(whole),
        tip_tolerance=np.concatenate([zeros[0], contour.tip_tolerance[first:], zeros[1]]),
        axis_tolerance=np.concatenate([zeros[0], contour.axis_tolerance[first:], zeros[1]]),
        dwell_section=(contour.dwell_section[first_dwell:] + sections).astype(np.int32),
        entry=len(before) if start_at else -1,
    )


def _from_dwell(rest: ToolPath, path: ToolPath, first: int, first_dwell: int) -> ToolPath:
    """The part of a path from segment ``first`` on, without the dwells before ``first_dwell`` that stand before it."""
    gone = first_dwell - int((path.dwell_segment < first).sum())
    return replace(
        rest,
        dwell_section=rest.dwell_section[gone:],
        dwell_seconds=rest.dwell_seconds[gone:],
        dwell_line=rest.dwell_line[gone:],
    )


def _plunge_feed(contour: Contour, first: int) -> float:
    """Feed of the tip (mm/s) of the first feed move from a segment on, of the last one before it where there is none."""
    feeds = contour.feeds
    fed = np.flatnonzero(feeds.by_tip & np.isfinite(feeds.rate))
    if not len(fed):
        return np.inf
    behind = fed[fed >= first]
    return float(feeds.rate[behind[0] if len(behind) else fed[-1]])


def _way(
    like: ToolPath, machine: Machine, here: Array, there: Array, tool: float, option: str, feed: float = np.inf
) -> ToolPath:
    """Segments from pose to pose (5,) in the safe order; the last part of the plunge at ``feed`` (mm/s) where it is finite."""
    frame = Frame(tool=(0.0, 0.0, tool, *ZERO9[3:]))
    coordinates = machine.coordinates

    def at_height(pose: Array) -> Array:
        """The pose over, or at, a pose on its tool axis: machine Z 0 or higher."""
        point = coordinates.to_machine(coordinates.from_table(pose[:3], pose[3:], frame), frame)
        point[2] = max(point[2], 0.0)
        return np.concatenate(coordinates.to_table(coordinates.to_program(point, frame), frame))

    retracted, above = at_height(here), at_height(there)
    q_retracted, q_above = (_joints(machine, pose, tool, option) for pose in (retracted, above))
    q_turned = np.concatenate([q_retracted[:-2], q_above[-2:]])
    careful = np.isfinite(feed)
    height = float(np.linalg.norm(above[:3] - there[:3]))
    near = there.copy()
    if careful:
        near[:3] += min(CAREFUL_MM, height) * axis_of_angles(there[3], there[4])
    steps = [
        Step(here, retracted),
        Step(*_ends(machine, q_retracted, q_turned, tool), np.stack([q_retracted, q_turned])),
        Step(*_ends(machine, q_turned, q_above, tool), np.stack([q_turned, q_above])),
        Step(above, near),
        Step(near, there),
    ]
    found = segments_of(steps, like, 0)
    n = len(found)
    feed_time = np.zeros(n)
    if careful and height > ZERO_LENGTH_MM:
        feed_time[-1] = found.length[-1] / feed
    # no line of the program contains the way
    return replace(
        found, line=np.zeros_like(found.line), move=np.full_like(found.move, -1), tool_length=np.full(n, tool),
        feed_time=feed_time,
    )  # fmt: skip


def _pose_of(machine: Machine, q: Array, tool: float, option: str) -> Array:
    tip, angles, ok = machine.five_axis.nominal(q, tool)
    if not ok:
        raise InputError(finding("VP018", f"{option}: these joint values close no position of the platform"))
    return np.concatenate([tip, angles])


def _joints(machine: Machine, pose: Array, tool: float, option: str) -> Array:
    q, _position, _alpha, ok = machine.five_axis.solve(pose[:3], pose[3:], tool)
    if not ok:
        text = f"{option}: the retracted position, or the one above the goal of the way, is out of reach"
        raise InputError(finding("VP018", text))
    return q


def _ends(machine: Machine, q_from: Array, q_to: Array, tool: float) -> tuple[Array, Array]:
    tip, angles, _ok = machine.five_axis.nominal(np.stack([q_from, q_to]), tool)
    return np.concatenate([tip[0], angles[0]]), np.concatenate([tip[1], angles[1]])
