"""How near bodies come to a mesh in single poses, by points of its surface: for remedies and places of contacts.

No bound: whole motions are decided by ``mesh_contacts``.
"""

from functools import lru_cache
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.ragged import number_parts
from verne_post.base.rotations import rotate_z
from verne_post.kinematics.checks.moving import FAR_MM, Moving
from verne_post.model.poses import Pose
from verne_post.part.bodies import Piece
from verne_post.part.compare import Cells
from verne_post.part.stl import Mesh, order_facets
from verne_post.part.sweep import look, take

#: Points of a surface are no farther apart than this, mm, or than about so many of them allow.
_APART_MM: Final = 2.0
_MOST_POINTS: Final = 6000
#: Neighbouring points that are held against a pose together first, and neighbouring groups of them before that.
_CLUSTER: Final = 16
#: Pairs of balls and poses that are looked into together, the nearest first: what they find leaves few others.
_AT_A_TIME: Final = 1 << 8


def measure_distances(
    mesh: Mesh, middle: Array, turn: float, moving: Moving, pose: Pose, near: float, *, least_only: bool
) -> dict[str, Array]:
    """Signed distances (n,) of bodies at poses from a mesh, mm.

    Parameters
    ----------
    middle : ndarray, shape (3,)
        Where the zero of the mesh is on the table, mm.
    turn : float
        By how much it is turned about the table's normal, rad.
    near : float
        Larger distances are lower bounds, mm.
    least_only : bool
        Of each body the least distance is right, and the others are no smaller.
    """
    found = {body: np.full(len(pose.q), FAR_MM) for body in moving.known}
    for one in moving.carry(pose):
        for rows, pieces in moving.list_pieces(one, pose):
            tip, axis = rotate_z(one.origin[rows] - middle, -turn), rotate_z(one.axis[rows], -turn)
            for piece in pieces:
                if piece.part in found:
                    own = found[piece.part]
                    # of the next piece only what is nearer counts
                    if least_only:
                        least = _find_least_of_all(piece, tip, axis, _sample(mesh), min(float(own.min()), near))
                    else:
                        least = _find_least(piece, tip, axis, _sample(mesh), np.minimum(own[rows], near))
                    own[rows] = np.minimum(own[rows], least)
    return found


@lru_cache(maxsize=8)
def _sample(mesh: Mesh) -> list[tuple[Array, Array]]:
    """Balls, middles (n, 3) and radii (n,), from large to small: about groups of groups, about groups, and points."""
    cells = Cells(mesh.list_corners(), np.arange(len(mesh.facets)))
    sides = cells.corner[:, 1:] - cells.corner[:, :1]
    area = 0.5 * float(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum())
    apart = max(_APART_MM, float(np.sqrt(area / _MOST_POINTS)))
    done = []
    while len(cells.facet):
        side = cells.corner - np.roll(cells.corner, 1, axis=1)
        long = (side * side).sum(axis=2).max(axis=1) > apart * apart
        done.append(cells.corner[~long].reshape(-1, 3))
        cells = cells.select(long).halve()
    points = np.unique(np.concatenate(done), axis=0)
    points = points[order_facets(points)]
    balls = [(points, np.zeros(len(points)))]
    low = high = points
    for _ in range(2):
        first = np.arange(0, len(low), _CLUSTER)
        low, high = np.minimum.reduceat(low, first), np.maximum.reduceat(high, first)
        balls.insert(0, (0.5 * (low + high), 0.5 * np.linalg.norm(high - low, axis=1)))
    return balls


def _find_least(piece: Piece, tip: Array, axis: Array, balls: list[tuple[Array, Array]], near: Array) -> Array:
    """The least distance (n,) of points from a piece at poses (n, 3), (n, 3); a lower bound above ``near`` (n,)."""
    n, count = len(tip), len(balls[0][0])
    row, ball = np.repeat(np.arange(n), count), np.tile(np.arange(count), n)
    phi = look(piece, balls[0][0][ball], tip[row], axis[row]).phi
    lower = phi - balls[0][1][ball]
    least = lower.reshape(n, count).min(axis=1)
    is_close = least < near
    close = np.flatnonzero(is_close)
    # down to one point first: few others can be nearer
    chosen = phi.reshape(n, count)[close].argmin(axis=1)
    for centre, _radius in balls[1:]:
        child = np.minimum(_CLUSTER * chosen[:, None] + np.arange(_CLUSTER), len(centre) - 1)
        owner = np.repeat(close, _CLUSTER)
        of_child = look(piece, centre[child.ravel()], tip[owner], axis[owner]).phi.reshape(child.shape)
        best = of_child.argmin(axis=1)
        chosen = child[np.arange(len(close)), best]
        least[close] = of_child[np.arange(len(close)), best]
    sought = np.minimum(least, near)
    row, ball = take(np.flatnonzero(is_close[row] & (lower < sought[row])), row, ball)
    for centre, radius in balls[1:]:
        pair, child = number_parts(np.minimum(_CLUSTER, len(centre) - _CLUSTER * ball))
        row, ball = row[pair], _CLUSTER * ball[pair] + child
        lower = look(piece, centre[ball], tip[row], axis[row]).phi - radius[ball]
        row, ball, lower = take(np.flatnonzero(lower < sought[row]), row, ball, lower)
    np.minimum.at(least, row, lower)
    return least


def _find_least_of_all(piece: Piece, tip: Array, axis: Array, balls: list[tuple[Array, Array]], near: float) -> Array:
    """As :func:`_find_least`, where only the least (n,) of all poses has to be right: others are no smaller."""
    least, at = near, -1

    def seek(row: Ints, ball: Ints, level: int) -> Array:
        """Lower bounds (m,) of pairs of poses and balls; what is nearer than the least so far is looked into."""
        nonlocal least, at
        centre, radius = balls[level]
        lower = look(piece, centre[ball], tip[row], axis[row]).phi - radius[ball]
        if level == len(balls) - 1:
            best = int(lower.argmin())
            if lower[best] < least:
                least, at = float(lower[best]), int(row[best])
            return lower
        order = np.argsort(lower)
        for first in range(0, len(order), _AT_A_TIME):
            some = order[first : first + _AT_A_TIME]
            some = some[lower[some] < least]
            if not len(some):
                break
            pair, child = number_parts(np.minimum(_CLUSTER, len(balls[level + 1][0]) - _CLUSTER * ball[some]))
            seek(row[some][pair], _CLUSTER * ball[some][pair] + child, level + 1)
        return lower

    n, count = len(tip), len(balls[0][0])
    bounds = seek(np.repeat(np.arange(n), count), np.tile(np.arange(count), n), 0).reshape(n, count).min(axis=1)
    bounds = np.maximum(bounds, np.nextafter(least, np.inf))
    if at >= 0:
        bounds[at] = least
    return bounds
