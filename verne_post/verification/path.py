"""The path: how far tip, tool axis and rotary angle of each row are from the programmed segment."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.numbers import format_beyond, format_fixed
from verne_post.base.rows import measure_rows
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.protocols import TableCoordinates, turn_to_setup
from verne_post.verification.axis_words import find_slack
from verne_post.verification.collector import FindingCollector
from verne_post.verification.deviation import measure_deviation
from verne_post.verification.programmed import find_tool_axis
from verne_post.verification.reference import Reference
from verne_post.verification.rows import MeasuredRows

_OTHER: Final = "these are rows of another program, or were made with other options or set-up"
#: Why nearly all rows of a file may be off, and what share of them that is.
OTHER_ROWS: Final = f"nearly no row fits: {_OTHER}"
_NEARLY_ALL: Final = 0.9
#: The share where the first row is off too, as it is not in a file that goes wrong later.
_MOST: Final = 0.5


class PathCheck:
    """Shows that the pose of every row is within tolerance of one pose of the segment of its line.

    The tip is within PATH_TIP_MM, tool axis and rotary angle are within PATH_AXIS_DEG, or within the tolerance of the
    segment where its corners may be rounded. No rounded corner reaches a standstill: there the former bounds hold, from
    the one pose of the program. Rounding to coarse decimals is allowed for.
    """

    def __init__(self, reference: Reference, coordinates: TableCoordinates, findings: FindingCollector) -> None:
        self.reference, self.coordinates, self.findings = reference, coordinates, findings
        #: tip_deviation, axis_deviation: The largest so far, mm and rad.
        self.tip_deviation, self.axis_deviation = 0.0, 0.0
        # vectors (n, 3) from places of the program, where it stands, to rows that should be there; tool axes (n, 3)
        self._aside: list[Array] = []
        self._axes: list[Array] = []
        # rows so far, and those that are off their segment
        self._n, self._n_off = 0, 0
        self._begins_aside = False  # the first row is not at the start pose

    def check(self, rows: MeasuredRows) -> None:
        """Check the next rows."""
        off = measure_deviation(self.reference, rows.segment, rows.u, rows.pose)
        angle_bound = off.angle_bound / RAD_PER_DEG
        self.tip_deviation = max(self.tip_deviation, float(off.tip.max()))
        self.axis_deviation = max(self.axis_deviation, float(off.axis.max()))
        every = np.arange(len(rows.item))
        if not self._n:
            start = self.reference.path.first_pose[:3]
            self._begins_aside = bool(measure_rows(rows.pose.tip[:1] - start)[0] > self.reference.exact_bounds[0])
        self._n, self._n_off = self._n + len(every), self._n_off + int((~off.within).sum())
        self._compare(rows, every, "tip", "mm", off.tip, off.tip_bound)
        self._compare(rows, every, "tool axis", "deg", off.axis / RAD_PER_DEG, angle_bound)
        self._compare(rows, every, "rotary angle", "deg", off.rotary / RAD_PER_DEG, angle_bound)
        self._check_standing(rows)
        if rows.item[-1] == len(self.reference.items.segment) - 1 and rows.line[-1]:
            self._aside.append(rows.pose.tip[-1:] - self.reference.path.end[-1, :3])
            self._axes.append(rows.pose.axis[-1:])

    def finish(self) -> None:
        """Say by which vector the tip is off where the program stands: nothing is wrong with such rows.

        Where the tool axis turns, a constant distance along it tells another tool length from another work offset.
        """
        bound, vectors = self.reference.exact_bounds[0], np.concatenate([np.empty((0, 3)), *self._aside])
        axes, n = np.concatenate([np.empty((0, 3)), *self._axes]), len(vectors)
        along = (vectors * axes).sum(axis=1)
        usual, longer = (np.median(vectors, axis=0), float(np.median(along))) if n > 1 else (np.zeros(3), 0.0)
        alike = int((np.abs(vectors - usual) <= bound).all(axis=1).sum())
        alike_along = int((np.abs(vectors - longer * axes) <= bound).all(axis=1).sum())
        fits = max(alike, alike_along)
        where = "at every standstill" if fits == n else f"at {fits} of {n} standstills"
        if 2 * fits <= n or max(abs(longer), measure_rows(usual[None])[0]) <= 2.0 * bound:
            if self._n_off > _NEARLY_ALL * self._n:
                self.findings.explain("VP411", OTHER_ROWS)
            elif self._begins_aside and self._n_off > _MOST * self._n:
                self.findings.explain("VP411", f"the first row and most others do not fit: {_OTHER}")
        elif alike_along > alike:
            self.findings.explain(
                "VP411",
                f"the rows fit a tool that is {abs(longer):.3f} mm {'longer' if longer > 0 else 'shorter'}, {where}: "
                "they were made with another tool length",
            )
        else:
            aside = turn_to_setup(self.coordinates, usual)
            vector = " ".join(f"{axis}{format_fixed(value, 3)}" for axis, value in zip("XYZ", aside, strict=True))
            reason = (
                f"the tip is off by {vector} mm on the table {where}: the rows were made with another work offset, "
                "tool length or set-up"
            )
            self.findings.explain("VP411", reason)

    def _check_standing(self, rows: MeasuredRows) -> None:
        """Check the rows of dwells, and the first row after each standstill: that of the standstill itself."""
        stands = rows.dwell.copy()
        stands[rows.entered_rows] |= self.reference.items.stop_before[rows.item[rows.entered_rows]]
        row = np.flatnonzero(stands)
        if not len(row):
            return
        pose, some = self.reference.find_standing_poses(rows.item[row]), rows.pose.select(row)
        # of a dwell its first row; an approach begins and ends at places of the machine
        begins = np.flatnonzero((rows.line[row] > 0) & np.isin(row, rows.entered_rows))
        self._aside.append((some.tip - pose[:, :3])[begins])
        self._axes.append(some.axis[begins])
        tip_bound, angle_bound = (np.full(len(row), bound) for bound in self.reference.exact_bounds)
        where = "the place of the standstill"
        self._compare(rows, row, "tip", "mm", measure_rows(some.tip - pose[:, :3]), tip_bound, where)
        axis, rotary = measure_rows(some.axis - find_tool_axis(pose[:, 3:])), np.abs(some.angles[:, 1] - pose[:, 4])
        if some.by_axis:
            # rounding of the joints turns C by any angle near the pole
            rotary[rotary <= find_slack(pose[:, 3:], self.reference.words_bound)] = 0.0
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
            first, worst = int(bad[0]), int(bad[np.argmax(off[bad])])
            line = int(rows.line[row[first]])
            self.findings.add(
                "VP411",
                f"the {name} is {format_beyond(off[first], bound[first])} {unit} off {where}, "
                f"allowed {bound[first]:.4g} {unit}",
                line,
                rows.first + int(row[first]),
                len(bad),
                (name, where),
                (rows.first + int(row[worst]), float(off[worst]), unit),
                value=float(off[first]),
                limit=float(bound[first]),
                unit=unit,
            )
