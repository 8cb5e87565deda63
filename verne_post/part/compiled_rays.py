""":mod:`ray_tables` and :mod:`dexels` for one ray after the other, compiled by numba: the same answers."""

import math
from typing import Any

import numpy as np
from numba import njit

from verne_post.part.ray_tables import BALL_MM, FLAT, HALVINGS, NEWTON_STEPS, ON_SURFACE_MM, VERTICAL

#: Division by zero is infinity, as with numpy.
_compile = njit(cache=True, nogil=True, error_model="numpy")


@_compile
def _lies_between(r: Any, h: Any, n1r: Any, n1h: Any, n2r: Any, n2h: Any) -> Any:
    return n1r * h - n1h * r >= 0 and r * n2h - h * n2r >= 0


@_compile
def _round_end(corners: Any, n: Any, x: Any, y: Any, ux: Any, uy: Any, uz: Any, z: Any, stop: Any, way: Any) -> Any:
    rc, hc, radius = corners[n, 0], corners[n, 1], corners[n, 2]
    n1r, n1h, n2r, n2h = corners[n, 3], corners[n, 4], corners[n, 5], corners[n, 6]
    for _ in range(NEWTON_STEPS):
        h = x * ux + y * uy + z * uz
        r = math.sqrt(max(x * x + y * y + z * z - h * h, 0.0))
        off_r, off_h = r - rc, h - hc
        if not _lies_between(off_r, off_h, n1r, n1h, n2r, n2h):
            return z
        if rc < BALL_MM:
            inside = radius * radius - (x - hc * ux) ** 2 - (y - hc * uy) ** 2
            return hc * uz - way * math.sqrt(inside) if inside > 0 else way * np.inf
        size = math.sqrt(off_r * off_r + off_h * off_h)
        gap = size - radius
        if gap <= ON_SURFACE_MM:
            return z
        slope = (off_r * (z - h * uz) / max(r, BALL_MM) + off_h * uz) / size
        if way * slope >= 0:
            return way * np.inf
        z -= gap / slope
        if way * (stop - z) <= 0:
            return z
    return z


@_compile
def _meet_standing(
    edges: Any, x: Any, first: Any, step: Any, count: Any, ux: Any, uy: Any, uz: Any, low: Any, high: Any
) -> None:
    """:func:`ray_tables.meet_standing` for a row of rays at y = first, first + step, ...

    The loops have no branches, so that they are vectorised.
    """
    low[:count], high[:count] = -np.inf, np.inf
    xu, xx = x * ux, x * x
    for n in range(len(edges)):
        nr, nh, d = edges[n, 0], edges[n, 1], edges[n, 2]
        if nr == 0:
            slope = nh * uz
            if slope > 0:
                for j in range(count):
                    at = (d - nh * (xu + (first + j * step) * uy)) / slope
                    high[j] = at if at < high[j] else high[j]
            elif slope < 0:
                for j in range(count):
                    at = (d - nh * (xu + (first + j * step) * uy)) / slope
                    low[j] = at if at > low[j] else low[j]
            else:
                for j in range(count):
                    high[j] = -np.inf if d < nh * (xu + (first + j * step) * uy) else high[j]
            continue
        m, k = d / nr, -nh / nr
        a = ux * ux + uy * uy - k * k * uz * uz
        if abs(a) <= FLAT:
            for j in range(count):
                y = first + j * step
                h0 = xu + y * uy
                wide = m + k * h0
                b, c = -uz * (h0 + k * wide), xx + y * y - h0 * h0 - wide * wide
                if b > 0:
                    high[j] = min(high[j], -c / (2.0 * b))
                elif b < 0:
                    low[j] = max(low[j], -c / (2.0 * b))
                elif c > 0:
                    high[j] = -np.inf
        elif a > 0:
            for j in range(count):
                y = first + j * step
                h0 = xu + y * uy
                wide = m + k * h0
                b, c = -uz * (h0 + k * wide), xx + y * y - h0 * h0 - wide * wide
                inside = b * b - a * c
                root = math.sqrt(inside if inside > 0 else 0.0)
                enter, leave = (-b - root) / a, (-b + root) / a
                leave = leave if inside >= 0 else -np.inf
                low[j] = enter if enter > low[j] else low[j]
                high[j] = leave if leave < high[j] else high[j]
        else:
            for j in range(count):
                y = first + j * step
                h0 = xu + y * uy
                wide = m + k * h0
                b, c = -uz * (h0 + k * wide), xx + y * y - h0 * h0 - wide * wide
                root = math.sqrt(max(b * b - a * c, 0.0))
                if k * uz > 0:
                    low[j] = max(low[j], (-b - root) / a)
                else:
                    high[j] = min(high[j], (-b + root) / a)


@_compile
def _round_ray(corners: Any, x: Any, y: Any, ux: Any, uy: Any, uz: Any, low: Any, high: Any) -> Any:
    for n in range(len(corners)):
        if low < high:
            low = _round_end(corners, n, x, y, ux, uy, uz, low, high, 1.0)
        if low < high:
            high = _round_end(corners, n, x, y, ux, uy, uz, high, low, -1.0)
    return low, high


@_compile
def _find_side(edges: Any, corners: Any, r: Any, side: Any) -> Any:
    height, slope = side * np.inf, 0.0
    for n in range(len(edges)):
        nr, nh = edges[n, 0], edges[n, 1]
        if side * nh > 0:
            here = (edges[n, 2] - nr * r) / nh
            if side * here < side * height:
                height, slope = here, -nr / nh
    for n in range(len(corners)):
        n1r, n1h, n2r, n2h = corners[n, 3], corners[n, 4], corners[n, 5], corners[n, 6]
        if side * n1h > 0 or side * n2h > 0:
            first = n1r if side * n1h > 0 else 1.0
            last = n2r if side * n2h > 0 else 1.0
            hc, radius = corners[n, 1], corners[n, 2]
            off = r - corners[n, 0]
            if radius * min(first, last) < off <= radius * max(first, last):
                rise = math.sqrt(max(radius * radius - off * off, 0.0))
                height, slope = hc + side * rise, -side * off / max(rise, BALL_MM)
    return height, slope


@_compile
def _meet_moving(
    edges: Any, corners: Any, level: Any, radius: Any, x: Any, y: Any, start: Any, end: Any, most: Any
) -> Any:
    dx, dy, dz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    x, y = x - start[0], y - start[1]
    long = dx * dx + dy * dy
    near = (x * dx + y * dy) / long if long > 0 else 0.0
    beside = max(x * x + y * y - near * near * long, 0.0)
    inside = radius * radius - beside
    if inside < 0:
        return np.inf, -np.inf
    if dz == 0 or long == 0:
        share = min(max(near, 0.0), 1.0)
        r = math.sqrt(beside + (near - share) ** 2 * long)
        if r > radius:
            return np.inf, -np.inf
        low = _find_side(edges, corners, r, -1.0)[0] + min(start[2], end[2])
        if low >= most:
            return np.inf, -np.inf
        return low, _find_side(edges, corners, r, 1.0)[0] + max(start[2], end[2])
    half = math.sqrt(inside / long)
    if near - half > 1.0 or near + half < 0.0:
        return np.inf, -np.inf
    first, last = min(max(near - half, 0.0), 1.0), min(max(near + half, 0.0), 1.0)
    nearest = math.sqrt(beside + (near - min(max(near, first), last)) ** 2 * long)
    if _find_side(edges, corners, nearest, -1.0)[0] + min(start[2], end[2]) >= most:
        return np.inf, -np.inf
    ends = (0.0, 0.0)
    for which in range(2):
        side = -1.0 if which == 0 else 1.0
        if level[which]:
            share = last if side * dz > 0 else first
        else:
            a, b = first, last
            for _ in range(HALVINGS):
                middle = 0.5 * (a + b)
                r = math.sqrt(beside + (near - middle) ** 2 * long)
                slope = _find_side(edges, corners, r, side)[1] * (middle - near) * long / max(r, BALL_MM) + dz
                if side * slope > 0:
                    a = middle
                else:
                    b = middle
            share = 0.5 * (a + b)
        r = math.sqrt(beside + (near - share) ** 2 * long)
        z = _find_side(edges, corners, r, side)[0] + start[2] + share * dz
        ends = (z, ends[1]) if which == 0 else (ends[0], z)
    return ends


@_compile
def _find_window(table: Any, pose: Any, cell: Any, n: Any, k: Any) -> Any:
    """First cell along axis k of a body, and the one after its last."""
    (_edges, _corners, radius, bottom, top), (start, end, axis) = table, pose
    side = radius * math.sqrt(max(1.0 - axis[k] * axis[k], 0.0))
    least = min(start[k], end[k]) + min(bottom * axis[k], top * axis[k]) - side
    most = max(start[k], end[k]) + max(bottom * axis[k], top * axis[k]) + side
    return max(math.ceil(least / cell[k] - 0.5), 0), min(math.floor(most / cell[k] - 0.5) + 1, n)


@_compile
def _narrow_row(table: Any, pose: Any, cell: Any, i: Any, j0: Any, j1: Any) -> Any:
    """Which rays of row i, of those from j0 to j1, an upright body may meet: beside a slanting way are many others."""
    radius, (start, end, axis) = table[2] + cell[1], pose
    if axis[2] <= 0 or math.sqrt(axis[0] * axis[0] + axis[1] * axis[1]) >= VERTICAL:
        return j0, j1
    x = (i + 0.5) * cell[0]
    dx, dy = end[0] - start[0], end[1] - start[1]
    first, last = 0.0, 1.0
    if dx != 0:  # where its axis is no farther from the row than its radius
        a, b = (x - radius - start[0]) / dx, (x + radius - start[0]) / dx
        first, last = min(max(min(a, b), 0.0), 1.0), min(max(max(a, b), 0.0), 1.0)
    off_a, off_b = start[0] + first * dx - x, start[0] + last * dx - x
    off = min(abs(off_a), abs(off_b)) if off_a * off_b > 0 else 0.0
    half = math.sqrt(max(radius * radius - off * off, 0.0))
    a, b = start[1] + first * dy, start[1] + last * dy
    least, most = min(a, b) - half, max(a, b) + half
    return max(j0, math.ceil(least / cell[1] - 0.5)), min(j1, math.floor(most / cell[1] - 0.5) + 1)


@_compile
def _meet_row(
    table: Any, level: Any, cell: Any, i: Any, j0: Any, j1: Any, pose: Any, stock: Any, low: Any, high: Any
) -> None:
    """Where rays (i, j0) to (i, j1) enter and leave a body; rays whose material it passes by count as missed."""
    (edges, corners, radius, bottom, _top), (start, end, axis) = table, pose
    stock_low, stock_high, rows, more_low, more_high, used, _in_use = stock
    ux, uy, uz = axis[0], axis[1], axis[2]
    x, first = (i + 0.5) * cell[0] - end[0], (j0 + 0.5) * cell[1] - end[1]
    upright = uz > 0 and math.sqrt(ux * ux + uy * uy) < VERTICAL
    if not upright:
        _meet_standing(edges, x, first, cell[1], j1 - j0, ux, uy, uz, low, high)
    for j in range(j1 - j0):
        if not upright and not low[j] < high[j]:
            continue
        least, most = np.inf, -np.inf
        for k in range(stock_low.shape[2]):
            least, most = min(least, stock_low[i, j0 + j, k]), max(most, stock_high[i, j0 + j, k])
        row = rows[i, j0 + j]
        for k in range(used[row] if row else 0):
            least, most = min(least, more_low[row, k]), max(most, more_high[row, k])
        if upright and min(start[2], end[2]) + bottom >= most:  # most rays that are cut again
            low[j], high[j] = np.inf, -np.inf
        elif upright:
            y = (j0 + j + 0.5) * cell[1]
            low[j], high[j] = _meet_moving(edges, corners, level, radius, x + end[0], y, start, end, most)
        elif low[j] + end[2] >= most or high[j] + end[2] <= least:
            low[j], high[j] = np.inf, -np.inf
        else:
            if len(corners):
                low[j], high[j] = _round_ray(corners, x, first + j * cell[1], ux, uy, uz, low[j], high[j])
            low[j], high[j] = low[j] + end[2], high[j] + end[2]


@_compile
def _list_level(edges: Any, corners: Any) -> Any:
    """Whether the lower and the upper side are flat."""
    level = np.ones(2, dtype=np.bool_)
    for which in range(2):
        side = -1.0 if which == 0 else 1.0
        for n in range(len(edges)):
            level[which] &= not (edges[n, 0] > 0 and side * edges[n, 1] > 0)
        for n in range(len(corners)):
            level[which] &= not (side * corners[n, 4] > 0 or side * corners[n, 6] > 0)
    return level


@_compile
def _take(low: Any, high: Any, a: Any, b: Any) -> Any:
    """Take the interval from ``a`` to ``b`` away from places; its length, and where one that is split ended (or b)."""
    length, rest = 0.0, b
    for k in range(len(low)):
        lo, hi = low[k], high[k]
        if not (a < hi and b > lo):
            continue
        length += min(hi, b) - max(lo, a)
        if lo < a:
            high[k] = a
            rest = max(rest, hi)
        elif hi > b:
            low[k] = b
        else:
            low[k], high[k] = 1e30, -1e30
    return length, rest


@_compile
def _put(low: Any, high: Any, a: Any, b: Any) -> Any:
    """Give the interval from ``a`` to ``b`` a free place; the number of places up to it, 0 where none is free."""
    for k in range(len(low)):
        if low[k] > high[k]:
            low[k], high[k] = a, b
            return k + 1
    return 0


@_compile
def _has_material(low: Any, high: Any, a: Any, b: Any) -> Any:
    """Whether there is material between ``a`` and ``b``."""
    found = False
    for k in range(len(low)):
        found = found or max(low[k], a) < min(high[k], b)
    return found


@_compile
def cut(stock: Any, cell: Any, sweeps: Any, table: Any, volume: Any, first: Any) -> Any:
    """Take bodies away from number ``first`` on.

    The number done; it is fewer where a ray has no free place left, and then which ray, and the interval without place.
    """
    low, high, rows, more_low, more_high, used, in_use = stock
    (starts, ends, axes), level = sweeps, _list_level(table[0], table[1])
    area = cell[0] * cell[1]
    enter, leave = np.empty(low.shape[1]), np.empty(low.shape[1])
    for row in range(first, len(starts)):
        pose = starts[row], ends[row], axes[row]
        i0, i1 = _find_window(table, pose, cell, low.shape[0], 0)
        first_j, end_j = _find_window(table, pose, cell, low.shape[1], 1)
        for i in range(i0, i1):
            j0, j1 = _narrow_row(table, pose, cell, i, first_j, end_j)
            _meet_row(table, level, cell, i, j0, j1, pose, stock, enter, leave)
            for j in range(j0, j1):
                a, b = enter[j - j0], leave[j - j0]
                if not a < b:
                    continue
                more = rows[i, j]
                length, rest = _take(low[i, j], high[i, j], a, b)
                if more:
                    n = used[more]
                    length_more, rest_more = _take(more_low[more, :n], more_high[more, :n], a, b)
                    length, rest = length + length_more, max(rest, rest_more)
                    while n > 0 and more_low[more, n - 1] > more_high[more, n - 1]:
                        n -= 1
                    used[more] = n
                volume[row] += length * area
                if rest > b and not _put(low[i, j], high[i, j], b, rest):
                    if not more and in_use[0] < len(more_low):
                        more = rows[i, j] = in_use[0]
                        in_use[0] += 1
                    place = _put(more_low[more], more_high[more], b, rest) if more else 0
                    if not place:
                        return row, i, j, b, rest
                    used[more] = max(used[more], place)
    return len(starts), 0, 0, 0.0, 0.0


@_compile
def touch(stock: Any, cell: Any, sweeps: Any, table: Any, found: Any, only_first: Any) -> None:
    """Note which bodies have material in them, or the first of them."""
    low, high, rows, more_low, more_high, used, _in_use = stock
    (starts, ends, axes), level = sweeps, _list_level(table[0], table[1])
    enter, leave = np.empty(low.shape[1]), np.empty(low.shape[1])
    for row in range(len(starts)):
        if only_first and row > 0 and found[row - 1]:
            return
        pose = starts[row], ends[row], axes[row]
        i0, i1 = _find_window(table, pose, cell, low.shape[0], 0)
        first_j, end_j = _find_window(table, pose, cell, low.shape[1], 1)
        for i in range(i0, i1):
            if found[row]:
                break
            j0, j1 = _narrow_row(table, pose, cell, i, first_j, end_j)
            _meet_row(table, level, cell, i, j0, j1, pose, stock, enter, leave)
            for j in range(j0, j1):
                a, b, more = enter[j - j0], leave[j - j0], rows[i, j]
                has = _has_material(low[i, j], high[i, j], a, b)
                n = used[more]  # none for row 0
                if has or (more and _has_material(more_low[more, :n], more_high[more, :n], a, b)):
                    found[row] = True
                    break
