"""Limits of the joints: velocity, acceleration and jerk by differences of the rows as written, and travel."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.numbers import choose_decimals, format_beyond, format_fixed
from verne_post.base.tolerances import ACCELERATION_RATIO, JERK_RATIO, LIMIT_SLACK, LIMIT_SLACK_MM, VELOCITY_RATIO
from verne_post.model.setpoints import SetpointBlock
from verne_post.verification.collector import FindingCollector
from verne_post.verification.reference import DERIVATIVES, Reference

#: Rows at rest that stand before the first row and after the last one: as many as a third difference needs.
_REST_ROWS: Final = 3
#: With less than this share of every limit no joint holds the tool back: the motion is shorter than its control cycles.
_NEAR_SHARE: Final = 0.1
#: Finding code and accepted share of the limit, by the order of the difference - 1.
_BOUNDS: Final = (("VP401", VELOCITY_RATIO), ("VP402", ACCELERATION_RATIO), ("VP403", JERK_RATIO))


class DynamicsCheck:
    """Shows that no joint leaves its travel, nor exceeds its velocity, acceleration and jerk.

    First, second and third differences of each column over the cycle stay within 1.001, 1.005 and 1.02 of the limits,
    plus the noise of coarse decimals. The machine stands before the first row and after the last one. Every row is
    inside the travel, within LIMIT_SLACK_MM or LIMIT_SLACK and one unit of the last decimal.
    """

    def __init__(self, reference: Reference, findings: FindingCollector) -> None:
        self.reference, self.findings = reference, findings
        #: (n_joints,) each: Largest velocity, acceleration and jerk so far, in file units.
        self.worst = [np.zeros(len(reference.columns)) for _ in DERIVATIVES]
        self._tail = np.empty((0, len(reference.columns)))
        self._last_row, self._last_line = -1, 0

    def check(self, block: SetpointBlock) -> Ints:
        """Check the next rows.

        Returns
        -------
        ndarray of int, shape (n,)
            The limit that is nearest to each row: number of its derivative times n_joints, plus number of the joint.
            The next number after all of them where none is near: the control cycle is longer than limits ask for.
        """
        if not len(self._tail):
            self._tail = np.repeat(block.values[:1], _REST_ROWS, axis=0)
        values = np.concatenate([self._tail, block.values])
        self._last_row, self._last_line = block.first + len(block.values) - 1, int(block.line[-1])
        nearest = self._check_differences(values, block.first, block.line)
        self._check_travel(block)
        self._tail = values[-_REST_ROWS:]
        return nearest

    def finish(self, n_rows: int) -> None:
        """Check the standstill after the last of ``n_rows`` rows."""
        rest = np.repeat(self._tail[-1:], _REST_ROWS, axis=0)
        self._check_differences(np.concatenate([self._tail, rest]), n_rows, None)

    def _check_differences(self, values: Array, first: int, lines: Ints | None) -> Ints:
        """Check differences that end in row ``first`` or later; ``values`` begins with the rows before that row."""
        columns, n = self.reference.columns, len(values) - _REST_ROWS
        difference = np.ascontiguousarray(values.T)  # a joint at a time: numpy is slow along short rows
        largest, nearest = np.zeros(n), np.zeros(n, dtype=np.int64)
        for order, (code, ratio) in enumerate(_BOUNDS):
            difference = np.diff(difference, axis=1) / self.reference.cycle
            limit = self.reference.derivative_limits[order]
            bound = ratio * limit + self.reference.noise.differences[order]
            for joint, size in enumerate(np.abs(difference[:, _REST_ROWS - 1 - order :])):
                share = size / limit[joint]
                nearest[share > largest] = order * len(columns) + joint
                np.maximum(largest, share, out=largest)
                worst = size.max()
                self.worst[order][joint] = np.maximum(self.worst[order][joint], worst)
                if worst <= bound[joint]:
                    continue
                rows = np.flatnonzero(~(size <= bound[joint]))
                column, row = columns[joint], int(rows[0])
                unit = f"{column.unit}/s{order + 1}" if order else f"{column.unit}/s"
                times = format_beyond(size[row] / limit[joint], ratio)
                top = int(size.argmax())
                text = f"the {DERIVATIVES[order]} of joint {column.joint} is {times} times its limit of "
                text += f"{limit[joint]:.15g} {unit}"
                if lines is None:
                    text += "; the file ends there in motion"
                self.findings.add(
                    code,
                    text,
                    self._last_line if lines is None else int(lines[row]),
                    min(first + row, self._last_row),
                    0 if lines is None else len(rows),
                    worst=(min(first + top, self._last_row), float(size[top] / limit[joint]), "times its limit"),
                    axis=column.joint,
                    value=float(size[row]),
                    limit=float(limit[joint]),
                    unit=unit,
                )
        return np.where(largest < _NEAR_SHARE, len(_BOUNDS) * len(columns), nearest)

    def _check_travel(self, block: SetpointBlock) -> None:
        """Check the travel of every joint."""
        factor, limits = self.reference.factor, self.reference.limits
        inside = block.values / factor
        for joint, column in enumerate(self.reference.columns):
            slack = (LIMIT_SLACK_MM if column.unit == "mm" else LIMIT_SLACK) + self.reference.noise.joints[joint]
            low, high = limits.lower[joint], limits.upper[joint]
            bad = np.flatnonzero(~((inside[:, joint] >= low - slack) & (inside[:, joint] <= high + slack)))
            if len(bad):
                row = int(bad[0])
                value = block.values[row, joint]
                limit = (low if inside[row, joint] < low else high) * factor[joint]
                decimals = choose_decimals(abs(value - limit), column.unit)
                self.findings.add(
                    column.code,
                    f"joint {column.joint} is at {format_fixed(value, decimals)} {column.unit}, beyond the end of its "
                    f"travel at {format_fixed(limit, 3)} {column.unit}",
                    int(block.line[row]),
                    block.first + row,
                    len(bad),
                    axis=column.joint,
                    value=float(value),
                    limit=float(limit),
                    unit=column.unit,
                )
