"""The path: how far tip, tool axis and rotary angle of each row are from the programmed segment."""

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.numbers import format_beyond, format_fixed
from verne_post.base.rows import measure_rows
from verne_post.base.units import RAD_PER_DEG
from verne_post.verification.collector import FindingCollector
from verne_post.verification.deviation import measure_deviation
from verne_post.verification.programmed import find_tool_axis
from verne_post.verification.reference import Reference
from verne_post.verification.rows import MeasuredRows


class PathCheck:
    """Shows that the pose of every row is within tolerance of one pose of the segment of its line.

    The tip is within PATH_TIP_MM, tool axis and rotary angle are within PATH_AXIS_DEG, or within the tolerance of the
    segment where its corners may be rounded. No rounded corner reaches a standstill: there the former bounds hold, from
    the one pose of the program. Rounding to coarse decimals is allowed for.
    """

    def __init__(self, reference: Reference, findings: FindingCollector) -> None:
        self.reference, self.findings = reference, findings
        #: tip_deviation, axis_deviation: The largest so far, mm and rad.
        self.tip_deviation, self.axis_deviation = 0.0, 0.0
        # the least and greatest x, y, z of vectors from places of the program to rows that should be there
        self._aside: tuple[Array, Array] | None = None
        self._is_complete = False

    def check(self, rows: MeasuredRows) -> None:
        """Check the next rows."""
        off = measure_deviation(self.reference, rows.segment, rows.u, rows.pose)
        angle_bound = off.angle_bound / RAD_PER_DEG
        self.tip_deviation = max(self.tip_deviation, float(off.tip.max()))
        self.axis_deviation = max(self.axis_deviation, float(off.axis.max()))
        every = np.arange(len(rows.item))
        self._compare(rows, every, "tip", "mm", off.tip, off.tip_bound)
        self._compare(rows, every, "tool axis", "deg", off.axis / RAD_PER_DEG, angle_bound)
        self._compare(rows, every, "rotary angle", "deg", off.rotary / RAD_PER_DEG, angle_bound)
        self._check_standing(rows)
        if rows.item[-1] == len(self.reference.items.segment) - 1:
            self._is_complete = self._aside is not None
            self._widen_aside(rows.pose.tip[-1:] - self.reference.path.end[-1, :3])

    def finish(self) -> None:
        """Say where all of the file is off by one vector: nothing is wrong with its rows."""
        if self._aside is None or not self._is_complete:
            return
        least, most = self._aside
        bound = self.reference.exact_bounds[0]
        if (most - least).max() <= bound < measure_rows(0.5 * (least + most)[None])[0] - bound:
            vector = " ".join(
                f"{axis}{format_fixed(value, 3)}" for axis, value in zip("XYZ", 0.5 * (least + most), strict=True)
            )
            reason = (
                f"the file is off by {vector} mm on the table from its first row to its last: was it made with another "
                "work offset, tool length or set-up?"
            )
            self.findings.explain("VP411", reason)

    def _widen_aside(self, vectors: Array) -> None:
        """Let the box of vectors reach to these (n, 3), mm."""
        least, most = vectors.min(axis=0), vectors.max(axis=0)
        if self._aside is not None:
            least, most = np.minimum(least, self._aside[0]), np.maximum(most, self._aside[1])
        self._aside = least, most

    def _check_standing(self, rows: MeasuredRows) -> None:
        """Check the rows of dwells, and the first row after each standstill: that of the standstill itself."""
        stands = rows.dwell.copy()
        stands[rows.entered_rows] |= self.reference.items.stop_before[rows.item[rows.entered_rows]]
        row = np.flatnonzero(stands)
        if not len(row):
            return
        pose, some = self.reference.find_standing_poses(rows.item[row]), rows.pose.select(row)
        self._widen_aside(some.tip - pose[:, :3])
        tip_bound, angle_bound = (np.full(len(row), bound) for bound in self.reference.exact_bounds)
        where = "the place of the standstill"
        self._compare(rows, row, "tip", "mm", measure_rows(some.tip - pose[:, :3]), tip_bound, where)
        axis, rotary = measure_rows(some.axis - find_tool_axis(pose[:, 3:])), np.abs(some.angles[:, 1] - pose[:, 4])
        self._compare(rows, row, "tool axis", "deg", axis / RAD_PER_DEG, angle_bound / RAD_PER_DEG, where)
        self._compare(rows, row, "rotary angle", "deg", rotary / RAD_PER_DEG, angle_bound / RAD_PER_DEG, where)

    def _compare(
        self,
        rows: MeasuredRows,
        row: Ints,
        name: str,
        unit: str,
        off: Array,
        bound: Array,
        where: str = "the programmed segment",
    ) -> None:
        """Report the first of rows (n,) whose deviation (n,) exceeds its bound (n,) or is no number."""
        bad = np.flatnonzero(~(off <= bound))
        if len(bad):
            first = int(bad[0])
            line = int(rows.line[row[first]])
            self.findings.add(
                "VP411",
                f"the {name} is {format_beyond(off[first], bound[first])} {unit} off {where}, "
                f"allowed {bound[first]:.4g} {unit}",
                line,
                rows.first + int(row[first]),
                len(bad),
                (name, where),
                value=float(off[first]),
                limit=float(bound[first]),
                unit=unit,
            )
