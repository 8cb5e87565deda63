"""The path: how far tip, tool axis and rotary angle of each row are from the programmed segment."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.verification.collector import FindingCollector
from verne_post.verification.projection import RADIAN_MM, deviation, deviation_nearby
from verne_post.verification.reference import Reference
from verne_post.verification.rows import MeasuredRows


class PathCheck:
    """Shows that the pose of every row is within tolerance of one pose of the segment of its line.

    The tip is within PATH_TIP_MM, tool axis and rotary angle are within PATH_AXIS_DEG, or within the tolerance of the segment
    where its corners may be rounded. Rounding to coarse decimals is allowed for.

    Attributes
    ----------
    tip_deviation, axis_deviation : float
        The largest so far, mm and rad.
    """

    def __init__(self, reference: Reference, findings: FindingCollector) -> None:
        self.reference, self.findings = reference, findings
        self.tip_deviation, self.axis_deviation = 0.0, 0.0

    def check(self, rows: MeasuredRows) -> None:
        """Check the next rows."""
        reference, noise = self.reference, self.reference.noise
        path, segment, pose = reference.path, rows.segment, rows.pose
        tip_off, axis_off, rotary_off = deviation(path, segment, np.clip(rows.u, 0.0, 1.0), pose)
        tip_bound = np.maximum(PATH_TIP_MM, reference.tip_tolerance[segment]) + noise.coarse * noise.tip
        angle_bound = np.maximum(PATH_AXIS_DEG * RAD_PER_DEG, reference.axis_tolerance[segment]) + noise.angle
        # a projection weighs tip against angles; where both may be off, another pose of the segment may be nearer
        doubtful = np.flatnonzero(
            (reference.measures.has_tolerance[segment] | (path.circle[segment] >= 0))
            & ~((tip_off <= tip_bound) & (axis_off <= angle_bound) & (rotary_off <= angle_bound))
        )
        if len(doubtful):
            on, tip_allowed, angle_allowed = segment[doubtful], tip_bound[doubtful], angle_bound[doubtful]
            # by metric length: near the pole C turns far over a small part of a great circle
            measures = reference.measures
            length = np.where(path.spline[on] >= 0, measures.motion_length[on], measures.metric_length[on])
            reach = np.maximum(2.0 * (tip_allowed + RADIAN_MM * angle_allowed) / length, measures.blend_u[on])
            tip_off[doubtful], axis_off[doubtful], rotary_off[doubtful] = deviation_nearby(
                path, on, rows.u[doubtful], pose.select(doubtful), tip_allowed, angle_allowed, reach
            )
        self.tip_deviation = max(self.tip_deviation, float(tip_off.max()))
        self.axis_deviation = max(self.axis_deviation, float(axis_off.max()))
        self._compare(rows, "tip", "mm", tip_off, tip_bound)
        self._compare(rows, "tool axis", "deg", axis_off / RAD_PER_DEG, angle_bound / RAD_PER_DEG)
        self._compare(rows, "rotary angle", "deg", rotary_off / RAD_PER_DEG, angle_bound / RAD_PER_DEG)

    def _compare(self, rows: MeasuredRows, name: str, unit: str, off: Array, bound: Array) -> None:
        """Report the first row whose deviation (n,) exceeds its bound (n,), or is no number."""
        bad = np.flatnonzero(~(off <= bound))
        if len(bad):
            row = int(bad[0])
            self.findings.add(
                "VP411", f"row {rows.first + row}: the {name} is {off[row]:.6f} {unit} off the programmed segment, "
                f"allowed {bound[row]:.6f} {unit} ({len(bad)} rows)", int(rows.line[row]),
                value=float(off[row]), limit=float(bound[row]), unit=unit,
            )  # fmt: skip
