"""The path: how far tip, tool axis and rotary angle of each row are from the programmed segment."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.units import RAD_PER_DEG
from verne_post.verification.collector import FindingCollector
from verne_post.verification.deviation import measure_deviation
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
        off = measure_deviation(self.reference, rows.segment, rows.u, rows.pose)
        angle_bound = off.angle_bound / RAD_PER_DEG
        self.tip_deviation = max(self.tip_deviation, float(off.tip.max()))
        self.axis_deviation = max(self.axis_deviation, float(off.axis.max()))
        self._compare(rows, "tip", "mm", off.tip, off.tip_bound)
        self._compare(rows, "tool axis", "deg", off.axis / RAD_PER_DEG, angle_bound)
        self._compare(rows, "rotary angle", "deg", off.rotary / RAD_PER_DEG, angle_bound)

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
