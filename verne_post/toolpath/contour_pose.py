"""The contour evaluated at any of its points: where the tool is, and its feed cap.

Every row and every point that is planned or checked is evaluated here, a few thousand at a time.
"""

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import sum_rows
from verne_post.model.contour import Contour
from verne_post.toolpath.corners import differentiate_displacement, find_displacement, find_replaced
from verne_post.toolpath.evaluate import (
    differentiate_bernstein,
    differentiate_coordinates,
    evaluate_bernstein,
    evaluate_coordinates,
)


def find_contour_pose(contour: Contour, element: Ints, w: Array) -> tuple[Array, Array]:
    """Tip (n, 3) and nominal angles (n, 2) at parameter w (n,) of elements (n,)."""
    at = contour.find_parameters(element, w)
    segment = contour.segment.take(element)
    pose = evaluate_coordinates(contour.shape, segment, at)
    if contour.corners is not None and (blended := contour.blended.take(element)).any():
        rows = _select(blended)
        on = segment[rows]
        corner = on + contour.corners.shift
        s = contour.corners.s.take(corner) + at[rows] * contour.shape.length.take(on)
        pose[rows] += find_displacement(contour.corners, corner, s)
        for points, controls, v, _reach in find_replaced(contour.corners, corner, s):
            pose[np.arange(len(pose))[rows][points]] = evaluate_bernstein(controls, v)
    return pose[:, :3], pose[:, 3:]


def _select(mask: Mask) -> slice | Ints:
    """Rows where a mask is set; where it is set throughout, a slice, which copies nothing."""
    return slice(None) if mask.all() else np.flatnonzero(mask)


def find_speed_cap(contour: Contour, element: Ints, w: Array) -> Array:
    """Feed cap: the largest ds/dt (n,) that the programmed feed rate allows, mm/s; infinite for rapids.

    On a segment the tip moves evenly with s. In a corner blend it moves slower than s; by how much follows from the
    derivative of the contour. Where the feed rate is a time, s itself counts: a blend may shift the tip's motion from
    one segment to the next, and takes no time from either.
    """
    feeds, shape = contour.feeds, contour.shape
    segment = contour.segment.take(element)
    cap = feeds.cap.take(segment)
    rate = feeds.rate.take(segment)
    uneven = contour.blended.take(element) & feeds.by_tip.take(segment) & np.isfinite(rate)
    if not uneven.any():
        return cap
    rows = _select(uneven)
    uneven_element, on = element[rows], segment[rows]
    at = contour.find_parameters(uneven_element, w[rows])
    length = shape.length.take(on)
    slope = differentiate_coordinates(shape, on, at)
    slope /= length[:, None]
    if contour.corners is not None:
        corner = on + contour.corners.shift
        s = contour.corners.s.take(corner, mode="clip") + at * length
        slope += differentiate_displacement(contour.corners, corner, s)
        for points, controls, v, reach in find_replaced(contour.corners, corner, s):
            slope[points] = differentiate_bernstein(controls, v) / (2.0 * reach[:, None])
    slope *= slope
    with np.errstate(divide="ignore"):
        cap[rows] = rate[rows] / np.sqrt(sum_rows(slope[:, :3]))
    return cap
