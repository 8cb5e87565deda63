"""The path between rows: what the program has between two rows lies near the straight step from one to the other."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.verification.collector import FindingCollector
from verne_post.verification.linear_joints import find_lines, find_rows
from verne_post.verification.programmed import RADIAN_MM, find_programmed_pose, find_tool_axis, measure_lengths_to
from verne_post.verification.reference import Reference
from verne_post.verification.rows import MeasuredRows

#: Where a segment between two rows is looked at, as shares of what the step passes; no multiples of a turn, for arcs of
#: several.
_PLACES: Final = (0.17, 0.41, 0.68, 1.0)
#: What lies between two rows is at most half the length between them from the nearer one. The length is known from the
#: step and the one before, and a corner is a little longer than its chord.
_BULGE: Final = 0.6
#: A step along an arc of half a turn is longer than its chord by pi / 2; rows do not show more than half a turn.
_ARC_OVER_CHORD: Final = 1.6
#: A pose within both bounds, of tip and angles, has a sum of squared shares of at most 2, and so has the nearest one.
_TWO_BOUNDS: Final = 2.0


class _Places(Struct, frozen=True, eq=False):
    """Places of the program at u of segments, that the steps to rows pass; (m,) each."""

    row: Ints
    segment: Ints
    u: Array


class BetweenRowsCheck:
    """Shows that nothing is left out between two rows, though both are on the path.

    Progress needs motion: two rows pass at most 1.6 of the step between them on the path. Beside rounded corners a step
    may be shorter. There, places of the program that it passes lie near the straight step: within the tolerance and 0.6
    of the longer of this step and the one before. Where a rounded corner cuts short the narrow turns of a curve, they
    lie that near to the step or to a row before it.
    """

    def __init__(self, reference: Reference, findings: FindingCollector) -> None:
        self.reference, self.findings = reference, findings
        self._last_step = np.zeros(5)
        self._rows_before: MeasuredRows | None = None

    def check(self, rows: MeasuredRows) -> None:
        """Check the steps to the next rows."""
        touched, length = rows.touched, self._measure_steps(rows)
        # a corner is shorter than its vertex: there the places that the step passes are compared
        length[touched.row] = 0.0
        goes_on = ~self.reference.items.stop_before[rows.item[touched.row]]
        places = self._list_places(touched.row[goes_on], touched.segment[goes_on], touched.part[goes_on])
        self._report_places(rows, places, self._find_far_places(rows, places))
        longer = length > _ARC_OVER_CHORD * self._measure_motion(rows) + PATH_TIP_MM + 2 * self.reference.noise.tip
        # a corner may cut turns of a curve short that are narrower than its tolerance
        cut = longer & (rows.item_before == rows.item) & self.reference.measures.has_tolerance[rows.segment]
        self._check_cut_turns(rows, np.flatnonzero(cut))
        bad = np.flatnonzero(longer & ~cut)
        if len(bad):
            row, line = int(bad[0]), int(rows.line[bad[0]])
            text = f"{length[row]:.4g} mm of the path of line {line} are left out"
            self.findings.add("VP412", text, line, rows.first + row)
        self._last_step, self._rows_before = rows.step[-1], rows

    def _check_cut_turns(self, rows: MeasuredRows, row: Ints) -> None:
        """Check that what rows pass of their segments at once lies near their steps, or near rows before them.

        Rows that do not go to the end of a narrow turn belong to its first leg as long as that is the nearer one.
        """
        part = np.clip(np.stack([rows.u_before[row], rows.u[row]], axis=1), 0.0, 1.0)
        places = self._list_places(row, rows.segment[row], part)
        far = self._find_far_places(rows, places)
        if not len(far):
            return
        row, segment = places.row[far], places.segment[far]
        tip, angles = find_programmed_pose(self.reference.path, segment, places.u[far])
        place, bound = np.concatenate([tip, RADIAN_MM * angles], axis=1), self._bound_distances(rows, row, segment)
        near = np.zeros(len(far), dtype=bool)
        for some in (rows, self._rows_before):
            if some is None:
                continue
            pose = np.concatenate([some.pose.tip, RADIAN_MM * some.pose.angles], axis=1)
            for k in np.flatnonzero(~near).tolist():
                own = np.flatnonzero(some.item == rows.item[row[k]])
                own = own[some.first + own < rows.first + row[k]]
                near[k] = bool((np.sum(((pose[own] - place[k]) / bound[k]) ** 2, axis=1) <= _TWO_BOUNDS).any())
        self._report_places(rows, places, far[~near])

    def _measure_motion(self, rows: MeasuredRows) -> Array:
        """Length (n,) of the steps; where the joints of a nutating pair go linearly, by them if that is more."""
        path, items = self.reference.path, self.reference.items
        motion = measure_rows(rows.step)
        for segment in (rows.segment, items.segment[rows.item_before]):
            if not len(on := find_rows(path, segment)):
                continue
            before, here = (
                find_lines(path, segment[on], pose[on, 3:] / RADIAN_MM)[0]
                for pose in (rows.origin, rows.origin + rows.step)
            )
            joints = np.hypot(measure_rows(rows.step[on, :3]), RADIAN_MM * measure_rows(here - before))
            motion[on] = np.maximum(motion[on], joints)
        return motion

    # --- lengths along the path -----------------------------------------------------------

    def _measure_steps(self, rows: MeasuredRows) -> Array:
        """Length (n,) along the path that each step passes, mm; 0 for dwells and where a stop is left out."""
        items = self.reference.items
        stays = (rows.item_before == rows.item) & ~rows.dwell
        length = self._measure_length(rows.item, rows.u) - self._measure_length(
            rows.item, np.where(stays, rows.u_before, rows.u)
        )
        entered = rows.entered_rows
        if len(entered):
            old, new = rows.item_before[entered], rows.item[entered]
            begun, left, came, whole = items.measure_passed(old, new, rows.u_before[entered], rows.u[entered])
            passed = self._measure_length(begun, np.ones(len(old))) - self._measure_length(begun, 1.0 - left)
            passed += items.length_before[new] - items.length_before[old + 1] + self._measure_length(new, came)
            length[entered] = passed * whole
        return length

    def _measure_length(self, item: Ints, u: Array) -> Array:
        """Length (n,) from the start of items to u (n,), mm; 0 for dwells."""
        segment = self.reference.items.segment[item]
        length = measure_lengths_to(self.reference.path, segment, u, self.reference.measures.metric_length)
        return np.where(segment >= 0, length, 0.0)

    # --- places between rows --------------------------------------------------------------

    def _list_places(self, row: Ints, segment: Ints, part: Array) -> _Places:
        """Rows, segments and u of places that steps pass; of a straight segment its end is enough."""
        straight = self._are_straight(segment)
        last = np.diff(row, append=-1) != 0
        touch, within = number_parts(np.where(straight, ~last, len(_PLACES)))
        share = np.where(straight[touch], _PLACES[-1], np.array(_PLACES)[within])
        low, high = part[touch].T
        return _Places(row[touch], segment[touch], low + share * (high - low))

    def _are_straight(self, segment: Ints) -> Mask:
        """Segments (m,) that are straight, or arcs no farther from their chords than their tolerance."""
        path = self.reference.path
        straight = (path.spline[segment] < 0) & (path.turn[segment] < 0) & (path.circle[segment] < 0)
        on_arc = np.flatnonzero(path.arc[segment] >= 0)
        arcs, row = path.arcs, path.arc[segment[on_arc]]
        height = np.maximum(arcs.r0, arcs.r1)[row] * (1.0 - np.cos(np.minimum(0.5 * np.abs(arcs.sweep[row]), np.pi)))
        straight[on_arc] &= height <= self.reference.tip_tolerance[segment[on_arc]]
        return straight

    def _find_far_places(self, rows: MeasuredRows, places: _Places) -> Ints:
        """Which places are not near the straight steps to their rows."""
        row, segment, u = places.row, places.segment, places.u
        if not len(row):
            return row
        path = self.reference.path
        tip, angles = find_programmed_pose(path, segment, u)
        place = np.concatenate([tip, RADIAN_MM * angles], axis=1)
        start, step = rows.origin[row], rows.step[row]
        # along a great circle the tool axis turns evenly; near the pole A and C do not
        on_circle = np.flatnonzero(path.circle[segment] >= 0)
        if len(on_circle):
            ends = [RADIAN_MM * find_tool_axis(at[on_circle, 3:] / RADIAN_MM) for at in (start, start + step)]
            here = RADIAN_MM * find_tool_axis(angles[on_circle])
            # two components tell the axis apart: those across the mean of both ends
            across = _find_perpendiculars(ends[0] + ends[1])
            begin, end, middle = (np.einsum("nij,nj->ni", across, vector) for vector in (*ends, here))
            start[on_circle, 3:], step[on_circle, 3:], place[on_circle, 3:] = begin, end - begin, middle
        bound = self._bound_distances(rows, row, segment)
        off = (place - start) / bound
        step /= bound
        along = np.sum(off * step, axis=1) / np.maximum(np.sum(step**2, axis=1), np.finfo(float).tiny)
        off -= np.clip(along, 0.0, 1.0)[:, None] * step
        return np.flatnonzero(np.sum(off**2, axis=1) > _TWO_BOUNDS)

    def _report_places(self, rows: MeasuredRows, places: _Places, far: Ints) -> None:
        """Report the first of the places that are far (m,)."""
        if len(far):
            row, line = int(places.row[far[0]]), int(self.reference.path.line[places.segment[far[0]]])
            self.findings.add("VP412", f"the motion of line {line} is left out", int(rows.line[row]), rows.first + row)

    def _bound_distances(self, rows: MeasuredRows, row: Ints, segment: Ints) -> Array:
        """How far places of segments (m,) may be from the steps to rows (m,), by component: (m, 5), mm."""
        reference, noise = self.reference, self.reference.noise
        steps = np.vstack([self._last_step[None], rows.step])
        size = np.stack([measure_rows(steps[:, :3]), measure_rows(steps[:, 3:])])
        size = np.maximum(size[:, 1:], size[:, :-1])[:, row]
        # the segments that a step passes share their corners, and each corner its tolerance
        tip_tolerance, axis_tolerance = np.zeros(len(rows.step)), np.zeros(len(rows.step))
        np.maximum.at(tip_tolerance, row, reference.tip_tolerance[segment])
        np.maximum.at(axis_tolerance, row, reference.axis_tolerance[segment])
        turn = axis_tolerance[row] + PATH_AXIS_DEG * RAD_PER_DEG + noise.angle
        bound = np.empty((len(row), 5))
        bound[:, :3] = (tip_tolerance[row] + PATH_TIP_MM + noise.tip + _BULGE * size[0])[:, None]
        bound[:, 3:] = (RADIAN_MM * turn + _BULGE * size[1])[:, None]
        return bound


def _find_perpendiculars(axis: Array) -> Array:
    """Two unit vectors (n, 2, 3) across each axis (n, 3), whose length may be any."""
    normal = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    helper = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normal, first)], axis=1)
