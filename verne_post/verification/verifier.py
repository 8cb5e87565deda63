"""The verifier: rows in, in order, block by block; a verdict out.

It is handed the programmed segments as data and the forward kinematics as a function, and shares nothing with planning.
"""

import math

from msgspec import Struct

from verne_post.base.tolerances import PATH_AXIS_DEG
from verne_post.base.units import DEG_PER_RAD
from verne_post.model.contour import Contour
from verne_post.model.machine import Column, Limits
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.verification import Verification
from verne_post.verification.between import BetweenRowsCheck
from verne_post.verification.collector import FindingCollector
from verne_post.verification.completeness import CompletenessCheck
from verne_post.verification.dynamics import DynamicsCheck
from verne_post.verification.feed import FeedCheck
from verne_post.verification.path import PathCheck
from verne_post.verification.reference import build_reference
from verne_post.verification.rows import Forward, LostPath, MeasuredRows, RowMatcher


class MeasuredBlock(Struct, frozen=True, eq=False):
    """Rows as written, measured in consecutive parts, and why the rest cannot be followed."""

    block: SetpointBlock
    parts: list[MeasuredRows]
    lost: LostPath | None


class Verifier:
    """Checks a stream of setpoint rows against a program: dynamics, path, completeness, and feed.

    Parameters
    ----------
    contour : Contour
        The programmed segments, where they may be stopped between, and how far the motion may be from each. Nothing
        else is taken from it: the geometry that was followed is not looked at.
    forward : callable
        (q, tool_length) -> tip, nominal angles, true tool axis, ok; mm and rad, workpiece sense.
    limits, columns :
        Of the machine.
    fmt : SetpointFormat
        How the rows are rounded, and their cycle.
    axis_error_limit : float
        How far the true tool axis may be from that of the nominal angles, rad.
    """

    def __init__(
        self, contour: Contour, forward: Forward, limits: Limits, columns: tuple[Column, ...], fmt: SetpointFormat,
        axis_error_limit: float = math.inf,
    ) -> None:  # fmt: skip
        self._axis_error_limit = axis_error_limit
        reference = build_reference(contour, limits, columns, fmt)
        self._derivative_limits = reference.derivative_limits
        self._findings = FindingCollector()
        self._matcher = RowMatcher(reference, forward)
        self._dynamics = DynamicsCheck(reference, self._findings)
        self._path = PathCheck(reference, self._findings)
        self._completeness = CompletenessCheck(reference, self._findings)
        self._between = BetweenRowsCheck(reference, self._findings)
        self._feed = FeedCheck(reference, self._findings)
        self._result = Verification()
        self._lost = False

    def feed(self, block: SetpointBlock) -> None:
        """Check the next rows."""
        self.check(self.measure(block))

    def measure(self, block: SetpointBlock) -> MeasuredBlock:
        """Match the next rows with the program, and measure them."""
        if self._lost:
            return MeasuredBlock(block, [], None)
        parts, lost = self._matcher.match(block)
        self._lost = lost is not None
        return MeasuredBlock(block, parts, lost)

    def check(self, measured: MeasuredBlock) -> None:
        """Check the next rows that have been measured."""
        block, lost = measured.block, measured.lost
        if not len(block.values):
            return
        if self._result.n_rows == 0:
            self._result.first_row = block.values[0].copy()
        self._result.n_rows += len(block.values)
        nearest = self._dynamics.check(block)
        for rows in measured.parts:
            first = rows.first - block.first
            self._path.check(rows)
            self._completeness.check(rows)
            self._between.check(rows)
            self._feed.check(rows, nearest[first : first + len(rows.item)])
        if lost is not None:
            self._findings.add(lost.code, f"row {block.first + lost.row}{lost.text}", int(block.line[lost.row]))

    def finish(self) -> Verification:
        """Check the end of the file and return the verdict."""
        result = self._result
        if result.n_rows == 0:
            self._findings.add("VP412", "the file has no rows", None)
        else:
            self._dynamics.finish(result.n_rows)
            if not self._lost:
                self._completeness.finish(self._matcher.last)
        self._check_axis_error()
        result.velocity_ratio, result.acceleration_ratio, result.jerk_ratio = (
            worst / limit for worst, limit in zip(self._dynamics.worst, self._derivative_limits, strict=True)
        )
        result.feed_ratio, result.feed_line = self._feed.ratio, self._feed.line
        result.tip_deviation_mm = self._path.tip_deviation
        result.axis_deviation_deg = self._path.axis_deviation * DEG_PER_RAD
        result.axis_error_deg = self._matcher.axis_error * DEG_PER_RAD
        result.slow = self._feed.slow_seconds()
        result.findings = self._findings.findings
        return result

    def _check_axis_error(self) -> None:
        """Compare the axis error that the machine leaves with what its file accepts."""
        error, limit = self._matcher.axis_error * DEG_PER_RAD, self._axis_error_limit * DEG_PER_RAD
        if error > limit + PATH_AXIS_DEG:
            text = f"the true tool axis is {error:.6f} deg off that of the axes' angles, accepted {limit:g} deg"
            self._findings.add("VP411", text, None, value=error, limit=limit, unit="deg")
