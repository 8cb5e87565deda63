"""The contour evaluated at any of its places: where the tool is, and how fast the feed lets it go.

Every row and every point that is planned or judged comes through here, a few thousand at a time.
"""

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rows import row_sum
from verne_post.model.contour import Contour
from verne_post.toolpath.corners import displacement, displacement_slope
from verne_post.toolpath.evaluate import bernstein, bernstein_slope, coordinates

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]


def contour_pose(contour: Contour, element: Ints, w: Array) -> tuple[Array, Array]:
    """Tip (n, 3) and nominal angles (n, 2) at parameter w (n,) of elements (n,)."""
    at = _along(contour, element, w)
    segment = contour.segment.take(element)
    found = coordinates(contour.shape, segment, at)
    if contour.corners is not None and (blended := contour.blended.take(element)).any():
        some = _rows(blended)
        own = segment[some]
        corner = own + contour.corners.shift
        s = contour.corners.s.take(corner) + at[some] * contour.shape.length.take(own)
        found[some] += displacement(contour.corners, corner, s)
    if len(contour.controls):
        curve = contour.curve.take(element)
        curved = np.flatnonzero(curve >= 0)
        found[curved] = bernstein(contour.controls[curve[curved]], at[curved])
    return found[:, :3], found[:, 3:]


def _along(contour: Contour, element: Ints, w: Array) -> Array:
    """Parameter (n,) of the segment or curve at parameter w (n,) of elements (n,)."""
    low = contour.low.take(element)
    return np.asarray(low + w * (contour.high.take(element) - low))


def _rows(wanted: Mask) -> slice | Ints:
    """Rows that are wanted, of which there are some; if all are, as a slice, which copies nothing."""
    return slice(None) if wanted.all() else np.flatnonzero(wanted)


def speed_cap(contour: Contour, element: Ints, w: Array) -> Array:
    """Largest ds/dt (n,) at which the tool keeps to the programmed feed, mm/s; infinite for rapids.

    On a segment the tip moves evenly with s. In a corner it moves slower than s, by how much follows from the derivative of
    the curve; for segments whose tip stands still the table angles count.
    """
    feeds, shape = contour.feeds, contour.shape
    segment = contour.segment.take(element)
    cap = feeds.even.take(segment)
    rate = feeds.rate.take(segment)
    uneven = (contour.blended.take(element) | (contour.curve.take(element) >= 0)) & np.isfinite(rate)
    if not uneven.any():
        return cap
    some = _rows(uneven)
    row, own = element[some], segment[some]
    at = _along(contour, row, w[some])
    length = shape.length.take(own)
    slope = shape.end.take(own, axis=0)
    slope -= shape.start.take(own, axis=0)
    slope /= length[:, None]
    if contour.corners is not None:
        corner = own + contour.corners.shift
        s = contour.corners.s.take(corner, mode="clip") + at * length
        slope += displacement_slope(contour.corners, corner, s)
    if len(contour.controls):
        curve = contour.curve.take(row)
        curved = np.flatnonzero(curve >= 0)
        on = row[curved]
        slope[curved] = bernstein_slope(contour.controls[curve[curved]], at[curved])
        slope[curved] *= ((contour.high[on] - contour.low[on]) / contour.length[on])[:, None]
    slope *= slope
    square = row_sum(slope[:, :3])
    by_tip = feeds.by_tip.take(own)
    if not by_tip.all():
        square = np.where(by_tip, square, row_sum(slope[:, 3:]))
    with np.errstate(divide="ignore"):
        cap[some] = rate[some] / np.sqrt(square)
    return cap
