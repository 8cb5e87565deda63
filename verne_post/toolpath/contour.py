"""ToolPath -> Contour: what the tool follows, and the poses along it."""

import numpy as np
from numpy.typing import NDArray

from verne_post.model.contour import Contour
from verne_post.model.toolpath import PieceKind, ToolPath
from verne_post.toolpath.evaluate import pose

Array = NDArray[np.float64]
Ints = NDArray[np.integer]


def exact_contour(path: ToolPath) -> Contour:
    """The pieces as they are, with a stop at every corner: one segment a piece."""
    return Contour(
        path=path,
        piece=np.arange(len(path), dtype=np.int32),
        length=path.length,
        turn=_turn(path),
        run=path.run,
        dwell_run=path.dwell_run,
    )


def _turn(path: ToolPath) -> Array:
    """Rotation of each piece: table angles and the sweep of arcs, rad."""
    turn = np.abs(path.end[:, 3:] - path.start[:, 3:]).sum(axis=1)
    curved = path.arc >= 0
    turn[curved] += np.abs(path.arcs.sweep[path.arc[curved]])
    joint = path.kind == PieceKind.JOINT
    if joint.any():
        ends = path.joints[path.joint[joint]]
        turn[joint] = np.abs(ends[:, 1, -2:] - ends[:, 0, -2:]).sum(axis=1)
    return turn


def contour_pose(contour: Contour, segment: Ints, w: Array) -> tuple[Array, Array]:
    """Tip (n, 3) and nominal angles (n, 2) at parameter w (n,) of segments (n,)."""
    return pose(contour.path, contour.piece[segment], w)
