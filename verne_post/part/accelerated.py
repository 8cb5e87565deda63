"""What ``sweep``, ``bound`` and ``places`` do, compiled by numba, point by point; imported only where numba is."""

# mypy: allow-untyped-defs, allow-untyped-calls

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.part.bodies import Piece
from verne_post.part.motion import BOW_SHARE, FAN, SEARCHED_MM, SMALL_BEND_MM, Level, Motion


def _compile(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compiled once a machine, where there is a place to keep it."""
    try:
        return njit(cache=True, fastmath=False)(function)
    except RuntimeError:  # no folder for the cache
        return njit(function)


@_compile
def _evaluate(body, edges, r, h):
    """The distance and its derivatives by r and h, as ``Piece.evaluate``."""
    plain, rounding, low, high, radius = body
    if plain > 0:
        beside, below, above = r - radius, low - h, h - high
        a, b = beside + rounding, below + rounding
        if beside > 0 and above > 0 and b <= 0:
            reach = math.sqrt(beside * beside + above * above)
            return reach, beside / reach, above / reach
        if a > 0 and b > 0:
            reach = math.sqrt(a * a + b * b)
            phi, by_r, by_h = reach - rounding, a / reach, -b / reach
        elif beside >= below:
            phi, by_r, by_h = beside, 1.0, 0.0
        else:
            phi, by_r, by_h = below, 0.0, -1.0
    else:
        above = h - high
        nearest, farthest, to_r, to_h, by_r, by_h = math.inf, -math.inf, 0.0, 0.0, 0.0, 0.0
        for k in range(len(edges)):
            off_r, off_h = r - edges[k, 0], h - edges[k, 1]
            signed = off_r * edges[k, 4] + off_h * edges[k, 5]
            share = min(max(off_r * edges[k, 2] + off_h * edges[k, 3], 0.0), 1.0) * edges[k, 6]
            off_r, off_h = off_r - share * edges[k, 2], off_h - share * edges[k, 3]
            square = off_r * off_r + off_h * off_h
            if square < nearest:
                nearest, to_r, to_h = square, off_r, off_h
            if signed > farthest:
                farthest, by_r, by_h = signed, edges[k, 4], edges[k, 5]
        if farthest > 0 and nearest > 0:
            reach = math.sqrt(nearest)
            phi, by_r, by_h = reach - rounding, to_r / reach, to_h / reach
        else:
            phi = min(farthest, 0.0) - rounding
    if above > phi:
        return above, 0.0, 1.0
    return phi, by_r, by_h


@_compile
def _look_from(body, edges, x, y, z, tip, axis, i):
    """The point from the pose of a row: offset (3), r, h, phi, derivatives."""
    dx, dy, dz = x - tip[i, 0], y - tip[i, 1], z - tip[i, 2]
    h = dx * axis[i, 0] + dy * axis[i, 1] + dz * axis[i, 2]
    r = math.sqrt(max(dx * dx + dy * dy + dz * dz - h * h, 0.0))
    phi, by_r, by_h = _evaluate(body, edges, r, h)
    return dx, dy, dz, r, h, phi, by_r, by_h


@_compile
def _find_slope(dx, dy, dz, r, h, by_r, by_h, ux, uy, uz, mx, my, mz, tx, ty, tz):
    """Derivative of phi by the share of a span: move (m), change of the axis (t)."""
    dh = dx * tx + dy * ty + dz * tz - h * (ux * tx + uy * ty + uz * tz) - (mx * ux + my * uy + mz * uz)
    dr = (-(dx * mx + dy * my + dz * mz) - h * dh) / r if r > 0 else 0.0
    return by_r * dr + by_h * dh


@_compile
def _find_slopes(tip, axis, i, dx, dy, dz, r, h, by_r, by_h, ex, ey, ez, r1, h1, by_r1, by_h1):
    """Derivatives of phi at both ends of the span from row i to the next, of a point seen from each."""
    j = i + 1
    mx, my, mz = tip[j, 0] - tip[i, 0], tip[j, 1] - tip[i, 1], tip[j, 2] - tip[i, 2]
    tx, ty, tz = axis[j, 0] - axis[i, 0], axis[j, 1] - axis[i, 1], axis[j, 2] - axis[i, 2]
    g0 = _find_slope(dx, dy, dz, r, h, by_r, by_h, axis[i, 0], axis[i, 1], axis[i, 2], mx, my, mz, tx, ty, tz)
    g1 = _find_slope(ex, ey, ez, r1, h1, by_r1, by_h1, axis[j, 0], axis[j, 1], axis[j, 2], mx, my, mz, tx, ty, tz)
    return g0, g1


@_compile
def _search(body, edges, bow, x, y, z, tip, axis, i, f0, g0, f1, g1, best, enough):
    """The least distance between rows i and i + 1, where both tangents fall inwards; ``best`` where it is no better.

    The first distance no larger than ``enough`` will do.
    """
    mx, my, mz = tip[i + 1, 0] - tip[i, 0], tip[i + 1, 1] - tip[i, 1], tip[i + 1, 2] - tip[i, 2]
    tx, ty, tz = axis[i + 1, 0] - axis[i, 0], axis[i + 1, 1] - axis[i, 1], axis[i + 1, 2] - axis[i, 2]
    low, high = 0.0, 1.0
    for step in range(60):
        crossing = min(max((f0 - f1 + g1 * (high - low)) / (g1 - g0), 0.0), high - low)
        lower = f0 + g0 * crossing
        if lower - bow >= best or min(f0, f1) - lower <= SEARCHED_MM:
            break
        s = low + crossing if step % 3 < 2 else 0.5 * (low + high)
        ux, uy, uz = axis[i, 0] + s * tx, axis[i, 1] + s * ty, axis[i, 2] + s * tz
        long = math.sqrt(ux * ux + uy * uy + uz * uz)
        ux, uy, uz = ux / long, uy / long, uz / long
        along = ux * tx + uy * ty + uz * tz
        vx, vy, vz = (tx - ux * along) / long, (ty - uy * along) / long, (tz - uz * along) / long
        dx, dy, dz = x - tip[i, 0] - s * mx, y - tip[i, 1] - s * my, z - tip[i, 2] - s * mz
        h = dx * ux + dy * uy + dz * uz
        r = math.sqrt(max(dx * dx + dy * dy + dz * dz - h * h, 0.0))
        phi, by_r, by_h = _evaluate(body, edges, r, h)
        if phi < best:
            best = phi
        if best <= enough:
            break
        slope = _find_slope(dx, dy, dz, r, h, by_r, by_h, ux, uy, uz, mx, my, mz, vx, vy, vz)
        if slope < 0:
            low, f0, g0 = s, phi, slope
        else:
            high, f1, g1 = s, phi, slope
        if not (g0 < 0 and g1 > 0):
            break
    return best


@_compile
def _look_at_leaf(body, edges, bow, slack, x, y, z, tip, axis, linked, first, last, best, at):
    """The rows from ``first`` to ``last`` and the spans between them: least distance and its row."""
    dx, dy, dz, r, h, f0, by_r, by_h = _look_from(body, edges, x, y, z, tip, axis, first)
    if f0 < best:
        best, at = f0, first
    for i in range(first, last):
        ex, ey, ez, r1, h1, f1, by_r1, by_h1 = _look_from(body, edges, x, y, z, tip, axis, i + 1)
        if f1 < best:
            best, at = f1, i + 1
        if linked[i]:
            mx, my, mz = tip[i + 1, 0] - tip[i, 0], tip[i + 1, 1] - tip[i, 1], tip[i + 1, 2] - tip[i, 2]
            tx, ty, tz = axis[i + 1, 0] - axis[i, 0], axis[i + 1, 1] - axis[i, 1], axis[i + 1, 2] - axis[i, 2]
            away = math.sqrt(mx * mx + my * my + mz * mz)
            away += math.sqrt((tx * tx + ty * ty + tz * tz) * (dx * dx + dy * dy + dz * dz))
            if 0.5 * (f0 + f1 - away) < best - slack:
                g0, g1 = _find_slopes(tip, axis, i, dx, dy, dz, r, h, by_r, by_h, ex, ey, ez, r1, h1, by_r1, by_h1)
                if g0 < 0 and g1 > 0:
                    found = _search(body, edges, bow, x, y, z, tip, axis, i, f0, g0, f1, g1, best, -math.inf)
                    if found < best:
                        best, at = found, i
        dx, dy, dz, r, h, f0, by_r, by_h = ex, ey, ez, r1, h1, f1, by_r1, by_h1
    return best, at


@_compile
def _bound_bow(tip, axis, i, j, far):
    """How far a point at a distance may be off its straight relative path between two rows."""
    move, turn = 0.0, 0.0
    for k in range(3):
        move += (tip[j, k] - tip[i, k]) ** 2
        turn += (axis[j, k] - axis[i, k]) ** 2
    return BOW_SHARE * (2.0 * math.sqrt(move * turn) + turn * far)


@_compile
def _bound_stretch(body, edges, x, y, z, tip, axis, i, j, tip_bend, chord_bend):
    """Lower bound of the distance between rows i and j, by tangents to their straight motion and how it is bent."""
    dx, dy, dz, r, h, f0, by_r, by_h = _look_from(body, edges, x, y, z, tip, axis, i)
    mx, my, mz = tip[j, 0] - tip[i, 0], tip[j, 1] - tip[i, 1], tip[j, 2] - tip[i, 2]
    tx, ty, tz = axis[j, 0] - axis[i, 0], axis[j, 1] - axis[i, 1], axis[j, 2] - axis[i, 2]
    ex, ey, ez, r1, h1, f1, by_r1, by_h1 = _look_from(body, edges, x, y, z, tip, axis, j)
    far = math.sqrt(max(dx * dx + dy * dy + dz * dz, ex * ex + ey * ey + ez * ez))
    bent = tip_bend + chord_bend * (far + tip_bend) + _bound_bow(tip, axis, i, j, far)
    g0 = _find_slope(dx, dy, dz, r, h, by_r, by_h, axis[i, 0], axis[i, 1], axis[i, 2], mx, my, mz, tx, ty, tz)
    if g0 >= 0:
        return f0 - bent
    g1 = _find_slope(ex, ey, ez, r1, h1, by_r1, by_h1, axis[j, 0], axis[j, 1], axis[j, 2], mx, my, mz, tx, ty, tz)
    if g1 <= 0:
        return f1 - bent
    return f0 + g0 * (f0 - f1 + g1) / (g1 - g0) - bent


@_compile
def _make_stack(offset, fan):
    """Room for the nodes that wait while one point goes down the tree."""
    levels = len(offset) - 1
    return np.empty((fan + 1) * (levels + 1) + offset[levels] - offset[levels - 1], dtype=np.int64)


@_compile
def _add_nodes(stack, depth, first, end):
    """Put the nodes from ``first`` up to ``end`` on the stack; its new depth."""
    for node in range(first, end):
        stack[depth] = node
        depth += 1
    return depth


@_compile
def _find_level(offset, node):
    """The level of a node, 0 for those of rows."""
    level = len(offset) - 2
    while node < offset[level]:
        level -= 1
    return level


@_compile
def _scan(body, edges, bow, slack, point, path, tree, distance, row):
    """Points in turn; each begins with the leaf in which the one before ended."""
    (tip, axis, linked), (offset, middle, reach, chord, last, tip_bend, chord_bend) = path, tree
    levels, n, fan = len(offset) - 1, len(tip), 8
    stack = _make_stack(offset, fan)
    before = -1
    for p in range(len(point)):
        x, y, z = point[p, 0], point[p, 1], point[p, 2]
        best, at = distance[p], row[p]
        mine = False
        if before >= 0:
            first = before // fan * fan
            found, where = _look_at_leaf(
                body, edges, bow, slack, x, y, z, tip, axis, linked, first, min(first + fan, n - 1), best, at
            )
            if found < best:
                best, at, mine = found, where, True
        depth = 0
        for node in range(offset[levels] - 1, offset[levels - 1] - 1, -1):
            stack[depth] = node
            depth += 1
        while depth:
            depth -= 1
            node = stack[depth]
            i = middle[node]
            dx, dy, dz, _r, _h, phi, _a, _b = _look_from(body, edges, x, y, z, tip, axis, i)
            if phi < best:
                best, at, mine = phi, i, True
            if phi - reach[node] - chord[node] * math.sqrt(dx * dx + dy * dy + dz * dz) >= best - slack:
                continue
            level = _find_level(offset, node)
            if tip_bend[node] < SMALL_BEND_MM:
                i, j = (node - offset[level]) * fan ** (level + 1), last[node]
                lower = _bound_stretch(body, edges, x, y, z, tip, axis, i, j, tip_bend[node], chord_bend[node])
                if lower - bow >= best - slack:
                    continue
            child = (node - offset[level]) * fan
            if level == 0:
                found, where = _look_at_leaf(
                    body, edges, bow, slack, x, y, z, tip, axis, linked, child, min(child + fan, n - 1), best, at
                )
                if found < best:
                    best, at, mine = found, where, True
            else:
                for one in range(
                    min(offset[level - 1] + child + fan, offset[level]) - 1, offset[level - 1] + child - 1, -1
                ):
                    stack[depth] = one
                    depth += 1
        distance[p] = best
        if mine:
            row[p] = before = at


@_compile
def _view(x, y, z, n, tx, ty, tz, ux, uy, uz, mx, my, mz, vx, vy, vz):
    """Radius and height of a point, their derivatives by the share of a span, and along the normal n of its facet."""
    dx, dy, dz = x - tx, y - ty, z - tz
    h = dx * ux + dy * uy + dz * uz
    r = math.sqrt(max(dx * dx + dy * dy + dz * dz - h * h, 0.0))
    dh = dx * vx + dy * vy + dz * vz - (mx * ux + my * uy + mz * uz)
    along = n[0] * ux + n[1] * uy + n[2] * uz
    if r > 0:
        dr = (-(dx * mx + dy * my + dz * mz) - h * dh) / r
        return r, h, dr, dh, (dx * n[0] + dy * n[1] + dz * n[2] - h * along) / r, along
    return r, h, 0.0, dh, 0.0, along


@_compile
def _view_from(x, y, z, n, tip, axis):
    """The point from a pose that does not move on."""
    return _view(x, y, z, n, tip[0], tip[1], tip[2], axis[0], axis[1], axis[2], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@_compile
def _view_between(x, y, z, n, tip, axis, i, j, s):
    """The point from a pose at share s of the straight motion from row i to row j."""
    mx, my, mz = tip[j, 0] - tip[i, 0], tip[j, 1] - tip[i, 1], tip[j, 2] - tip[i, 2]
    tx, ty, tz = axis[j, 0] - axis[i, 0], axis[j, 1] - axis[i, 1], axis[j, 2] - axis[i, 2]
    ux, uy, uz = axis[i, 0] + s * tx, axis[i, 1] + s * ty, axis[i, 2] + s * tz
    long = math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / long, uy / long, uz / long
    along = ux * tx + uy * ty + uz * tz
    vx, vy, vz = (tx - ux * along) / long, (ty - uy * along) / long, (tz - uz * along) / long
    return _view(
        x, y, z, n, tip[i, 0] + s * mx, tip[i, 1] + s * my, tip[i, 2] + s * mz, ux, uy, uz, mx, my, mz, vx, vy, vz
    )


@_compile
def _bound_one(f0, f1, a0, b0, a1, b1, at0, at1, width, delta):
    """Lower bound of one convex function over a facet and an interval, from tangents at both ends."""
    q0 = math.sqrt(max((a0 * a0 if at0[0] > 0 else 0.0) + b0 * b0 - (a0 * at0[4] + b0 * at0[5]) ** 2, 0.0))
    g0 = a0 * at0[2] + b0 * at0[3]
    if g0 >= 0 or width == 0:
        return f0 - delta * q0
    q1 = math.sqrt(max((a1 * a1 if at1[0] > 0 else 0.0) + b1 * b1 - (a1 * at1[4] + b1 * at1[5]) ** 2, 0.0))
    g1 = a1 * at1[2] + b1 * at1[3]
    if g1 <= 0:
        return f1 - delta * q1
    return f0 + g0 * (f0 - f1 + g1 * width) / (g1 - g0) - delta * max(q0, q1)


@_compile
def _measure_gap(body, edges, at):
    """How far the whole piece is beyond the plane of a facet, on its outer side."""
    across = math.sqrt(max(1.0 - at[5] * at[5], 0.0))
    support = -math.inf
    for k in range(len(edges)):
        r, h = edges[k, 0], edges[k, 1]
        support = max(support, r * across - h * at[5])
        r, h = r + edges[k, 2] * edges[k, 6], h + edges[k, 3] * edges[k, 6]
        support = max(support, r * across - h * at[5])
    return -(at[4] * at[0] + at[5] * at[1]) - support - body[1]


@_compile
def _is_above(body, edges, at0, at1, width, delta, limit):
    """Whether phi is above a limit over a facet and an interval, by its tangents or by a plane supporting the piece."""
    f0, a0, b0 = _evaluate(body, edges, at0[0], at0[1])
    f1, a1, b1 = _evaluate(body, edges, at1[0], at1[1])
    if _bound_one(f0, f1, a0, b0, a1, b1, at0, at1, width, delta) > limit:
        return True
    # along the facet's own normal: concave along a straight path, so the ends have its least value
    if min(_measure_gap(body, edges, at0), _measure_gap(body, edges, at1)) > limit:
        return True
    for k in range(len(edges)):
        a, b = edges[k, 4], edges[k, 5]
        s0 = (at0[0] - edges[k, 0]) * a + (at0[1] - edges[k, 1]) * b - body[1]
        s1 = (at1[0] - edges[k, 0]) * a + (at1[1] - edges[k, 1]) * b - body[1]
        if _bound_one(s0, s1, a, b, a, b, at0, at1, width, delta) > limit:
            return True
    return False


@_compile
def _is_stretch_above(body, edges, x, y, z, n, tip, axis, i, j, tip_bend, chord_bend, delta, limit):
    """Whether phi is above a limit over a facet and all rows from i to j, by their straight motion and its bend."""
    at0 = _view_between(x, y, z, n, tip, axis, i, j, 0.0)
    at1 = _view_between(x, y, z, n, tip, axis, i, j, 1.0)
    far = math.sqrt(max(at0[0] ** 2 + at0[1] ** 2, at1[0] ** 2 + at1[1] ** 2)) + delta
    bent = tip_bend + chord_bend * (far + tip_bend) + _bound_bow(tip, axis, i, j, far)
    return _is_above(body, edges, at0, at1, 1.0, delta, limit + bent)


@_compile
def _is_span_clear(body, edges, x, y, z, n, tip, axis, i, delta, limit):
    """Whether phi stays above a limit between rows i and i + 1; halves that do not say so are halved again."""
    depth = 0
    place = 0  # of the interval among 2**depth ones
    while True:
        width = 0.5**depth
        at0 = _view_between(x, y, z, n, tip, axis, i, i + 1, width * place)
        at1 = _view_between(x, y, z, n, tip, axis, i, i + 1, width * (place + 1))
        if _is_above(body, edges, at0, at1, width, delta, limit):
            while place % 2 == 1:  # go on with the next interval
                place //= 2
                depth -= 1
            if depth == 0:
                return True
            place += 1
            continue
        if (
            depth == 10
            or not _is_above(body, edges, at0, at0, 0.0, delta, limit)
            or not _is_above(body, edges, at1, at1, 0.0, delta, limit)
        ):
            return False
        depth += 1
        place *= 2


@_compile
def _check(body, edges, point, normal, delta, limit, path, tree, clear):
    """Whether phi stays above a limit on facets within delta of points, for all time."""
    (tip, axis, linked), (offset, middle, reach, chord, last, tip_bend, chord_bend) = path, tree
    levels, n, fan = len(offset) - 1, len(tip), 8
    stack = _make_stack(offset, fan)
    for p in range(len(point)):
        if not clear[p]:
            continue
        x, y, z = point[p, 0], point[p, 1], point[p, 2]
        depth = _add_nodes(stack, 0, offset[levels - 1], offset[levels])
        while depth and clear[p]:
            depth -= 1
            node = stack[depth]
            dx, dy, dz, _r, _h, phi, _a, _b = _look_from(body, edges, x, y, z, tip, axis, middle[node])
            if phi - reach[node] - chord[node] * math.sqrt(dx * dx + dy * dy + dz * dz) - delta[p] > limit:
                continue
            level = _find_level(offset, node)
            i, j = (node - offset[level]) * fan ** (level + 1), last[node]
            if tip_bend[node] < delta[p] and _is_stretch_above(
                body, edges, x, y, z, normal[p], tip, axis, i, j, tip_bend[node], chord_bend[node], delta[p], limit
            ):
                continue
            child = (node - offset[level]) * fan
            if level > 0:
                first = offset[level - 1] + child
                depth = _add_nodes(stack, depth, first, min(first + fan, offset[level]))
                continue
            for i in range(child, min(child + fan, n)):
                dx, dy, dz, _r, _h, phi, _a, _b = _look_from(body, edges, x, y, z, tip, axis, i)
                away = 0.0
                if linked[i]:
                    for k in range(3):
                        away += (tip[i + 1, k] - tip[i, k]) ** 2
                    turn = 0.0
                    for k in range(3):
                        turn += (axis[i + 1, k] - axis[i, k]) ** 2
                    away = math.sqrt(away) + math.sqrt(turn * (dx * dx + dy * dy + dz * dz))
                if phi - away - delta[p] > limit:
                    continue
                if linked[i]:
                    good = _is_span_clear(body, edges, x, y, z, normal[p], tip, axis, i, delta[p], limit)
                else:
                    at = _view_from(x, y, z, normal[p], tip[i], axis[i])
                    good = _is_above(body, edges, at, at, 0.0, delta[p], limit)
                if not good:
                    clear[p] = False
                    break


@_compile
def _note(marks, offset, i, phi, x, y, z):
    """The line of row i touches at a point: nothing more is asked of its rows."""
    group, order, begin, touched, value, place, row, left = marks
    g = group[i]
    touched[g], value[g], row[g] = True, phi, i
    place[g, 0], place[g, 1], place[g, 2] = x, y, z
    for k in range(begin[g], begin[g + 1]):
        node = order[k]
        for level in range(len(offset) - 1):
            node //= 8
            left[offset[level] + node] -= 1


@_compile
def _touch(body, edges, bow, point, normal, delta, limit, least, path, tree, marks, opened):
    """Mark the lines that touch cells; ``opened`` are cells with lines that neither touch nor miss for certain."""
    (tip, axis, linked), (offset, middle, reach, chord, last, tip_bend, chord_bend) = path, tree
    levels, n, fan = len(offset) - 1, len(tip), 8
    stack = _make_stack(offset, fan)
    group, touched, left = marks[0], marks[3], marks[7]
    for p in range(len(point)):
        x, y, z, d = point[p, 0], point[p, 1], point[p, 2], delta[p]
        depth = _add_nodes(stack, 0, offset[levels - 1], offset[levels])
        while depth:
            depth -= 1
            node = stack[depth]
            if left[node] == 0:
                continue
            dx, dy, dz, _r, _h, phi, _a, _b = _look_from(body, edges, x, y, z, tip, axis, middle[node])
            if phi - reach[node] - chord[node] * math.sqrt(dx * dx + dy * dy + dz * dz) - d > limit:
                continue
            level = _find_level(offset, node)
            i, j = (node - offset[level]) * fan ** (level + 1), last[node]
            if tip_bend[node] < SMALL_BEND_MM:
                lower = _bound_stretch(body, edges, x, y, z, tip, axis, i, j, tip_bend[node], chord_bend[node])
                if lower - bow - d > limit:
                    continue
                if tip_bend[node] < d and _is_stretch_above(
                    body, edges, x, y, z, normal[p], tip, axis, i, j, tip_bend[node], chord_bend[node], d, limit + bow
                ):
                    continue
            child = (node - offset[level]) * fan
            if level > 0:
                first = offset[level - 1] + child
                depth = _add_nodes(stack, depth, first, min(first + fan, offset[level]))
                continue
            for i in range(child, min(child + fan, n)):
                if touched[group[i]]:
                    continue
                dx, dy, dz, r, h, f0, by_r, by_h = _look_from(body, edges, x, y, z, tip, axis, i)
                found = f0
                if linked[i] and f0 > limit:
                    mx, my, mz = tip[i + 1, 0] - tip[i, 0], tip[i + 1, 1] - tip[i, 1], tip[i + 1, 2] - tip[i, 2]
                    tx, ty, tz = axis[i + 1, 0] - axis[i, 0], axis[i + 1, 1] - axis[i, 1], axis[i + 1, 2] - axis[i, 2]
                    away = math.sqrt(mx * mx + my * my + mz * mz)
                    away += math.sqrt((tx * tx + ty * ty + tz * tz) * (dx * dx + dy * dy + dz * dz))
                    if f0 - away - bow - d > limit:
                        continue
                    ex, ey, ez, r1, h1, f1, by_r1, by_h1 = _look_from(body, edges, x, y, z, tip, axis, i + 1)
                    if 0.5 * (f0 + f1 - away) - bow - d > limit:
                        continue
                    found = min(f0, f1)
                    if found > limit:
                        g0, g1 = _find_slopes(
                            tip, axis, i, dx, dy, dz, r, h, by_r, by_h, ex, ey, ez, r1, h1, by_r1, by_h1
                        )
                        if g0 < 0 and g1 > 0:
                            best = min(found, limit + d + bow)
                            found = _search(body, edges, bow, x, y, z, tip, axis, i, f0, g0, f1, g1, best, limit)
                if found <= limit:
                    _note(marks, offset, i, found, x, y, z)
                    continue
                if opened[p] or found >= limit + d + bow:
                    continue
                if linked[i]:
                    clear = _is_span_clear(body, edges, x, y, z, normal[p], tip, axis, i, d, limit + bow)
                else:
                    at = _view_between(x, y, z, normal[p], tip, axis, i, i, 0.0)
                    clear = _is_above(body, edges, at, at, 0.0, d, limit)
                if clear:
                    continue
                if d <= least:
                    _note(marks, offset, i, found, x, y, z)
                else:
                    opened[p] = True


def _pack(motion: Motion) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """The rows of a motion, and its tree, whose levels follow one after the other."""
    assert FAN == 8  # the kernels count on it
    offset = np.cumsum([0, *(len(level.middle) for level in motion.levels)])
    columns = (np.concatenate([getattr(level, name) for level in motion.levels]) for name in Level.__struct_fields__)
    return (motion.tip, motion.axis, motion.linked), (offset, *columns)


def _pack_piece(piece: Piece) -> tuple[tuple[float, ...], Array]:
    """The sizes of a piece, and the edges of its core."""
    return (float(piece.plain), piece.rounding, piece.low, piece.high, piece.radius), piece.list_edges()


def scan(motion: Motion, piece: Piece, point: Array, distance: Array, row: Ints, slack: float) -> None:
    """Improve the least distances (n,) of points (n, 3) from one piece, and the rows (n,) where they are."""
    _scan(*_pack_piece(piece), motion.bow, slack, point, *_pack(motion), distance, row)


def touch(
    motion: Motion,
    piece: Piece,
    cells: tuple[Array, Array, Array],
    limit: float,
    least: float,
    marks: tuple[Array, ...],
) -> Mask:
    """What ``places.touch_cells`` does; marks are changed."""
    point, normal, delta = cells
    opened = np.zeros(len(point), dtype=bool)
    _touch(*_pack_piece(piece), motion.bow, point, normal, delta, limit, least, *_pack(motion), marks, opened)
    return opened


def check_above(
    motion: Motion, piece: Piece, point: Array, normal: Array, delta: Array, limit: float, clear: Mask
) -> None:
    """Leave ``clear`` (n,) where a piece's phi is surely above a limit on facets within delta (n,) of points."""
    _check(*_pack_piece(piece), point, normal, delta, limit, *_pack(motion), clear)
