"""How near bodies of the machine come to each other: rods, spindle, tool, table, and the cones of the ball joints.

Rods and spindle are capsules (a line segment and a radius). The tool is a cylinder with a flat end, and so is the
spindle of a serial machine. The table is everything below its face inside its radius. Every margin is a distance or an
angle, and comes with how much it can change when the points that carry it move: that makes verdicts between samples
certain (``check_clearance``).
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.segments import measure_between_segments
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.base.units import DEG_PER_RAD
from verne_post.model.machine import Bodies
from verne_post.model.poses import Platform, Pose
from verne_post.model.protocols import Margin, RodModule

#: Ternary steps on a convex distance along a line segment: the bracket ends at (2/3)^60 of it.
CONVEX_STEPS: Final = 60


class Clearance:
    """The clearances of one machine; implements ``ClearanceModel``.

    Parameters
    ----------
    module : RodModule or None
        None for a module without rods.
    nose_offset : float
        From P to the gauge line along the tool axis, mm.
    spindle : ndarray, shape (3,)
        Unit vector from P towards the tip, platform frame.
    table_radius : float
        mm.
    """

    def __init__(
        self, bodies: Bodies, module: RodModule | None, nose_offset: float, spindle: Array, table_radius: float
    ) -> None:
        self.bodies, self.module, self.slack, self.spindle = bodies, module, LIMIT_SLACK_MM, spindle
        self.nose_offset, self.table_radius = nose_offset, table_radius
        listed = self._list_clearances()
        self.names: tuple[Margin, ...] = tuple(margin for margin, _share, _group in listed)
        #: How much each margin changes at most while the points of its group move by 1 mm.
        self.reach: Array = np.array([share for _margin, share, _group in listed])
        #: None of them is taken for convex.
        self.convex_below: Array = np.full(len(listed), -np.inf)
        #: Group of points that carries each margin.
        self.group: tuple[str, ...] = tuple(group for _margin, _share, group in listed)

    def _list_clearances(self) -> list[tuple[Margin, float, str]]:
        bodies, module = self.bodies, self.module
        low = bodies.minimum
        listed: list[tuple[Margin, float, str]] = []
        if module is not None and bodies.rod_radius is not None:
            for a, b in _list_leg_pairs(module):
                what = f"distance of the rods of legs {a} and {b}" if a != b else f"distance of the two rods of leg {a}"
                listed.append((Margin(what, "VP211", None, "mm", low, low), 2.0, "module"))
            if bodies.spindle_radius is not None:
                listed += [
                    (Margin(f"distance of leg {leg} from the spindle", "VP212", None, "mm", low, low), 2.0, "module")
                    for leg in dict.fromkeys(module.rod_legs)
                ]
        if bodies.spindle_radius is not None:
            share = 2.0 if bodies.spindle_is_flat else 1.0
            listed.append(
                (Margin("distance of the spindle from the table", "VP213", None, "mm", low, low), share, "table")
            )
        if bodies.tool_radius is not None:
            listed.append((Margin("distance of the tool from the table", "VP213", None, "mm", low, low), 2.0, "table"))
        if module is not None and bodies.cone_centre is not None:
            # a chord of d turns a rod by at most pi/2 d / rod; both its ends move; the platform's own turn adds one
            share = DEG_PER_RAD / module.shortest_rod
            for what, cone, factor in (
                ("slider", bodies.slider_cone, np.pi),
                ("platform", bodies.platform_cone, np.pi + 1),
            ):
                if cone is not None:
                    listed += [
                        (
                            Margin(
                                f"rest of the cone of a {what} ball joint of leg {leg}", "VP214", None, "deg", 0.0, 0.0
                            ),
                            factor * share,
                            "module",
                        )
                        for leg in dict.fromkeys(module.rod_legs)
                    ]
        return listed

    def evaluate(self, pose: Pose, *, least_only: bool = False) -> tuple[Array, dict[str, Array]]:
        """Margins, and the points whose motion bounds their change.

        Returns
        -------
        margins : ndarray, shape (n, len(names))
            mm and degrees.
        points : dict of ndarray, shape (n, p, 3)
            By group: "module" in the base frame, "table" in the table frame, mm.
        """
        bodies, module = self.bodies, self.module
        axis, platform = pose.axis, pose.platform
        down = platform.turn(self.spindle)
        nose = platform.position + self.nose_offset * down
        top = platform.position - bodies.spindle_top * down
        nose_on_table = pose.tip + pose.tool_length[:, None] * axis
        top_on_table = nose_on_table + (self.nose_offset + bodies.spindle_top) * axis
        points, on_table = [nose, top], [pose.tip, nose_on_table, top_on_table]
        columns: list[Array] = []
        if module is not None and (bodies.rod_radius is not None or bodies.cone_centre is not None):
            start, end = module.find_rod_ends(pose.q[:, :-2], platform)
            points += [*np.moveaxis(start, 1, 0), *np.moveaxis(end, 1, 0)]
            if bodies.rod_radius is not None:
                columns += self._measure_between_rods(module, start, end, bodies.rod_radius)
                if bodies.spindle_radius is not None:
                    columns += self._measure_rods_to_spindle(module, start, end, nose, top, bodies.rod_radius)
        if bodies.spindle_radius is not None:
            columns.append(self._measure_spindle_to_table(nose_on_table, top_on_table, axis, bodies.spindle_radius))
            if bodies.spindle_is_flat:
                on_table.append(bodies.spindle_radius * axis)
        if bodies.tool_radius is not None:
            columns.append(_bound_flat_end_to_table(pose.tip, axis, bodies.tool_radius, self.table_radius))
            on_table.append(bodies.tool_radius * axis)
        if module is not None and bodies.cone_centre is not None:
            columns += self._measure_cones(module, start, end, platform)
            # rates of the three angles as a vector: at most this factor less than the rate of the rotation
            beta = float(np.nanmax(np.abs(platform.angles[:, 1]), initial=0.0))
            points.append(module.shortest_rod * np.sqrt(1.0 + np.sin(beta)) * platform.angles)
        return np.stack(columns, axis=1), {"module": np.stack(points, axis=1), "table": np.stack(on_table, axis=1)}

    def _measure_spindle_to_table(self, nose: Array, top: Array, axis: Array, radius: float) -> Array:
        if not self.bodies.spindle_is_flat:
            return _measure_to_table(nose, top, self.table_radius) - radius
        ends = [_bound_flat_end_to_table(end, axis, radius, self.table_radius) for end in (nose, top)]
        return np.minimum(*ends)

    def _measure_between_rods(self, module: RodModule, start: Array, end: Array, radius: Array) -> list[Array]:
        legs = np.array(module.rod_legs)
        columns = []
        for a, b in _list_leg_pairs(module):
            pairs = [(i, j) for i in np.flatnonzero(legs == a) for j in np.flatnonzero(legs == b) if i < j]
            gaps = [
                measure_between_segments(start[:, i], end[:, i], start[:, j], end[:, j]) - radius[i] - radius[j]
                for i, j in pairs
            ]
            columns.append(np.min(gaps, axis=0))
        return columns

    def _measure_rods_to_spindle(
        self, module: RodModule, start: Array, end: Array, nose: Array, top: Array, radius: Array
    ) -> list[Array]:
        legs = np.array(module.rod_legs)
        spindle = self.bodies.spindle_radius or 0.0
        return [
            np.min(
                [
                    measure_between_segments(start[:, i], end[:, i], nose, top) - radius[i] - spindle
                    for i in np.flatnonzero(legs == leg)
                ],
                axis=0,
            )
            for leg in dict.fromkeys(module.rod_legs)
        ]

    def _measure_cones(self, module: RodModule, start: Array, end: Array, platform: Platform) -> list[Array]:
        """What is left of the cones, degrees: for each leg its worst rod."""
        assert self.bodies.cone_centre is not None
        rest_of_slider, rest_of_platform = module.find_rod_directions(self.bodies.cone_centre)
        direction = (end - start) / np.linalg.norm(end - start, axis=-1, keepdims=True)
        legs = np.array(module.rod_legs)
        columns = []
        for cone, seen, rest in (
            (self.bodies.slider_cone, direction, rest_of_slider),
            (self.bodies.platform_cone, platform.add_axis().turn_back(direction), rest_of_platform),
        ):
            if cone is not None:
                # atan2 keeps its digits where the rod stands in the middle of the cone
                sine = np.linalg.norm(np.cross(seen, rest), axis=-1)
                angle = np.arctan2(sine, (seen * rest).sum(axis=-1))
                left = DEG_PER_RAD * (cone - angle)
                columns += [left[:, legs == leg].min(axis=1) for leg in dict.fromkeys(module.rod_legs)]
        return columns


def _list_leg_pairs(module: RodModule) -> list[tuple[str, str]]:
    """Legs whose rods can come near each other; the rods of a parallelogram keep their distance."""
    legs = list(dict.fromkeys(module.rod_legs))
    pairs = [(leg, leg) for leg in legs if leg not in module.parallelograms]
    return pairs + [(a, b) for i, a in enumerate(legs) for b in legs[i + 1 :]]


def _measure_to_table(start: Array, end: Array, radius: float) -> Array:
    """Distance of line segments (n, 3) from everything below z = 0 inside a radius, 0 where they reach into it."""

    def measure(share: Array) -> Array:
        point = start + share[:, None] * (end - start)
        outside = np.maximum(np.hypot(point[:, 0], point[:, 1]) - radius, 0.0)
        return np.hypot(outside, np.maximum(point[:, 2], 0.0))

    low, high = np.zeros(len(start)), np.ones(len(start))
    for _ in range(CONVEX_STEPS):
        third = (high - low) / 3
        left, right = low + third, high - third
        nearer = measure(left) <= measure(right)
        high, low = np.where(nearer, right, high), np.where(nearer, low, left)
    return np.minimum(measure(0.5 * (low + high)), np.minimum(measure(np.zeros_like(low)), measure(np.ones_like(low))))


def _bound_flat_end_to_table(tip: Array, axis: Array, tool_radius: float, radius: float) -> Array:
    """Lower bound of the distance of a tool's flat end from the table; negative where it reaches into it.

    Every point of the rim is at least as high as the lowest one and at least ``|tip| - tool_radius`` from the centre;
    above the face and beside it the bound is exact.
    """
    height = tip[:, 2] - tool_radius * np.hypot(axis[:, 0], axis[:, 1])
    beside = np.hypot(tip[:, 0], tip[:, 1]) - tool_radius - radius
    outside = np.hypot(np.maximum(height, 0.0), np.maximum(beside, 0.0))
    return np.where((height > 0) | (beside > 0), outside, np.maximum(height, beside))
