"""Whole motions against fixtures that are meshes: nothing between two samples goes unseen.

The motion is divided into chords, which leave it by less than ``CHORD_MM``. The least distance of every place of a mesh
from bodies that go along these chords decides (``verne_post.part.clearance``). Facets that no body comes near are clear
at all times, so a program without a contact costs little more than one test of each facet.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base import spans
from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.base.rotations import rotate_z
from verne_post.kinematics.checks.cover import Spans, cover_elements, split_elements
from verne_post.kinematics.checks.keep_out import KeepOut, Placed
from verne_post.kinematics.checks.moving import THIN_MM, Moving
from verne_post.kinematics.checks.violations import Check, Worst, report_limit
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.findings import Finding
from verne_post.model.poses import Pose
from verne_post.part.clearance import TOUCH_MM, find_contacts
from verne_post.part.compare import is_inside
from verne_post.part.motion import BOW_SHARE, Motion, build_motion
from verne_post.part.rigid import build_way, find_inside, find_lines
from verne_post.part.stl import Mesh

#: No point of a body is farther than this from where its chord says, mm; what chords bow counts as well.
CHORD_MM: Final = 0.002
#: A span is divided into so many chords at most: of 50 mm, chords of 0.01 mm.
_MOST_CHORDS: Final = 4096
#: Poses that are held against the meshes together.
_BLOCK: Final = 1 << 17
#: Joint values that differ by less are the same pose, mm and rad.
_SAME: Final = 1e-6


class _Rows(Struct, frozen=True, eq=False):
    """Poses (n,) with their elements; ``linked`` ones go on to the next along a chord."""

    element: Ints
    pose: Pose
    linked: Mask


def check_meshes(joints: JointPath, keep_out: KeepOut, checks: list[Check]) -> list[Finding]:
    """VP215 of meshes, one finding for each body, mesh and tool: their elements mostly have one cause.

    Parameters
    ----------
    keep_out : KeepOut
        Of meshes alone.
    checks : list of Check
        One for each of its pairs of body and mesh.
    """
    worst = {(body, mesh.name): Worst() for body, mesh in keep_out.pairs}
    for rows in sample_chords(joints, keep_out.moving):
        motions = list(_list_motions(keep_out.moving, rows))
        for mesh in keep_out.obstacles:
            assert mesh.mesh is not None
            for body, element, value in _find_touching(mesh, mesh.mesh, motions):
                if (body, mesh.name) in worst:
                    worst[body, mesh.name].note(element, value - mesh.distance, value)
    return report_pairs(joints, keep_out, checks, worst)


def check_rigid(joints: JointPath, keep_out: KeepOut, checks: list[Check]) -> list[Finding]:
    """VP215 of bodies that are meshes, from boxes and meshes: as :func:`check_meshes`, of the pairs of ``keep_out``.

    Touching counts, and there is no depth: the distance is 0 where surfaces meet, or one is inside the other.
    """
    worst = {(body, one.name): Worst() for body, one in keep_out.pairs}
    for rows in sample_chords(joints, keep_out.moving):
        for body, corner in keep_out.moving.carry_corners(rows.pose).items():
            solved = np.flatnonzero(np.isfinite(corner).all(axis=(1, 2)))
            if not len(solved):
                continue
            linked = np.append(rows.linked[solved[:-1]] & (np.diff(solved) == 1), False)
            for one in keep_out.obstacles:
                way = build_way(one.map_inside(corner[solved]), rows.element[solved], linked)
                limit = max(one.distance - TOUCH_MM, 0.0) + CHORD_MM
                element, value = find_lines(keep_out.moving.rigid[body], one.balls, way, limit)
                worst[body, one.name].note(element, value - one.distance, value)
                inside = find_inside(keep_out.moving.rigid[body], one.surface, way)
                worst[body, one.name].note(way.line[inside], np.full(len(inside), -one.distance), np.zeros(len(inside)))
    return report_pairs(joints, keep_out, checks, worst)


def report_pairs(
    joints: JointPath, keep_out: KeepOut, checks: list[Check], worst: dict[tuple[str, str], Worst]
) -> list[Finding]:
    """Findings of pairs of bodies and fixtures, with their checks."""
    return [
        item
        for check, pair in zip(checks, worst.values(), strict=True)
        for item in report_limit(joints.contour, check, pair, keep_out.moving.tool[joints.contour.segment])
    ]


def _find_touching(place: Placed, mesh: Mesh, motions: list[Motion]) -> Iterator[tuple[str, Ints, Array]]:
    """Bodies that come too near to a mesh, on which elements (n,), and how near (n,), mm."""
    moved = mesh.move(rotate_z(np.eye(3), place.turn).T, place.middle)
    for motion in motions:  # a body that begins inside need not cross the surface
        start = np.flatnonzero(np.append(True, ~motion.linked[:-1]))
        for piece in motion.pieces:
            middle = 0.5 * (piece.low + min(piece.high, piece.low + 2.0 * piece.radius))
            inside = start[is_inside(moved, motion.tip[start] + middle * motion.axis[start])]
            yield piece.part, motion.line[inside], np.full(len(inside), -max(piece.radius, THIN_MM))
    for one in find_contacts(moved, tuple(motions), place.distance + CHORD_MM).found:
        yield one.part, one.line, one.value
        motion, deepest = motions[one.deepest.motion], one.deepest
        yield one.part, motion.line[deepest.row :][:1], np.array([deepest.distance])


def _list_motions(moving: Moving, rows: _Rows) -> Iterator[Motion]:
    """The bodies along the rows; lines are elements."""
    for carried in moving.carry(rows.pose):
        for own, pieces in moving.list_pieces(carried, rows.pose):
            if len(own):
                linked = np.append(rows.linked[own[:-1]] & (np.diff(own) == 1), False)
                yield build_motion(
                    carried.body, pieces, carried.origin[own], carried.axis[own], rows.element[own], linked
                )


def sample_chords(joints: JointPath, moving: Moving) -> Iterator[_Rows]:
    """The motion as chords, so many at a time."""
    waiting: list[tuple[Ints, Array, Mask]] = []
    chunks = list(split_elements(len(joints.contour)))
    for k, chunk in enumerate(chunks):
        for part in cover_elements(joints.contour, chunk):
            count = _count_chords(joints, moving, part)
            owner, index = number_parts(count + 1)
            w = part.low[owner] + (part.high - part.low)[owner] * (index / count[owner])
            waiting.append((part.element[owner], w, index < count[owner]))
        if sum(len(one[0]) for one in waiting) >= _BLOCK or k == len(chunks) - 1:
            element, w, linked = (np.concatenate(one) for one in zip(*waiting, strict=True))
            waiting = []
            pose = joints.place_bodies(element, joints.solve(element, w))
            same = np.abs(np.diff(pose.q, axis=0)).max(axis=1, initial=0.0) < _SAME
            linked[:-1] |= same
            yield _Rows(element, pose, linked)


def _count_chords(joints: JointPath, moving: Moving, part: Spans) -> Ints:
    """Into how many chords each span (n,) is divided."""
    element, w = part.place_samples(spans.SAMPLES)
    owner = element.ravel()
    off = np.zeros(len(part))
    for one in moving.carry(joints.place_bodies(owner, joints.solve(owner, w.ravel()))):
        (shift, bend), (turn, sway) = (_bound_rates(values.reshape(*w.shape, 3)) for values in (one.origin, one.axis))
        # a chord of both ends, then the axis made a unit vector again; and what the chord itself bows
        chord = bend / 8.0 + 2.0 * one.far * sway / 8.0
        off = np.fmax(off, chord + BOW_SHARE * turn * (2.0 * shift + turn * one.far))
    for corner in moving.carry_corners(joints.place_bodies(owner, joints.solve(owner, w.ravel()))).values():
        for k in range(corner.shape[1]):  # every place of a body is between the corners of the box around it
            off = np.fmax(off, _bound_rates(corner[:, k].reshape(*w.shape, 3))[1] / 8.0)
    return np.clip(np.ceil(np.sqrt(np.nan_to_num(off) / CHORD_MM)), 1, _MOST_CHORDS).astype(np.int64)


def _bound_rates(values: Array) -> tuple[Array, Array]:
    """Largest first and second derivative (n,) of points (samples, n, 3) by the share of their spans."""
    rates = []
    for order in (1, 2):
        low, high = spans.enclose_derivative(values, order)
        rates.append(np.linalg.norm(np.maximum(np.abs(low), np.abs(high)), axis=1))
    return rates[0], rates[1]
