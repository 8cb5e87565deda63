"""The verifier: rows in, in order, block by block; a verdict out.

It is handed the programmed segments as data and the forward kinematics as a function, and shares nothing with planning.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Final, Protocol

from msgspec import Struct

from verne_post.base.tolerances import PATH_AXIS_DEG
from verne_post.base.units import DEG_PER_RAD
from verne_post.model.contour import Contour
from verne_post.model.machine import Column, Limits
from verne_post.model.protocols import TableCoordinates
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.verification import Verification
from verne_post.verification.between import BetweenRowsCheck
from verne_post.verification.collector import FindingCollector
from verne_post.verification.completeness import CompletenessCheck
from verne_post.verification.dynamics import DynamicsCheck
from verne_post.verification.feed import FeedCheck
from verne_post.verification.path import OTHER_ROWS, PathCheck
from verne_post.verification.reference import Reference, build_reference
from verne_post.verification.rows import Forward, LostPath, MeasuredRows, RowMatcher

#: What follows where the rows are those of another program or set-up, which VP411 or VP413 says.
_OF_OTHER_ROWS: Final = ("VP404", "VP412", "VP413")
#: Rows of another program are lost before this share of them.
_FEW_FOLLOWED: Final = 0.1


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
    coordinates : TableCoordinates
        Of the machine: which frame messages name places in.
    forward : callable
        (q, tool_length) -> tip, nominal angles, true tool axis, ok; mm and rad, workpiece sense.
    limits, columns :
        Of the machine.
    fmt : SetpointFormat
        How the rows are rounded, and their cycle.
    axis_error_limit : float
        How far the true tool axis may be from that of the nominal angles, rad.
    joints_by_axis : bool
        The joints of the machine tell the tool axis, and not which words hold it.
    header_lines : int, optional
        Lines before the first row, where all rows are in one file of text: findings name its lines.
    """

    def __init__(
        self,
        contour: Contour,
        coordinates: TableCoordinates,
        forward: Forward,
        limits: Limits,
        columns: tuple[Column, ...],
        fmt: SetpointFormat,
        axis_error_limit: float = math.inf,
        *,
        joints_by_axis: bool = False,
        header_lines: int | None = None,
    ) -> None:
        reference = build_reference(contour, limits, columns, fmt, by_axis=joints_by_axis)
        self._matcher = RowMatcher(reference, forward, joints_by_axis=joints_by_axis)
        self._lost = False
        #: What checks the measured rows. They share no state: each may be left to a process of its own.
        self.parts: tuple[VerifierPart, ...] = (
            _PathPart(reference, coordinates, FindingCollector(header_lines)),
            _MotionPart(reference, self._matcher, axis_error_limit, FindingCollector(header_lines)),
        )

    def check_rows(self, block: SetpointBlock) -> None:
        """Check the next rows."""
        measured = self.measure(block)
        for part in self.parts:
            part.check(measured)

    def measure(self, block: SetpointBlock) -> MeasuredBlock:
        """Match the next rows with the program, and measure them."""
        if self._lost:
            return MeasuredBlock(block, [], None)
        parts, lost = self._matcher.match(block)
        self._lost = lost is not None
        return MeasuredBlock(block, parts, lost)

    def finish(self) -> Verification:
        """Check the end of the file and return the verdict."""
        return join_verdicts(part.finish() for part in self.parts)


def join_verdicts(verdicts: Iterable[tuple[Verification, list[str]]]) -> Verification:
    """The verdict of all parts of a verifier, from those of each, with the codes explained; findings by their codes.

    What follows from rows that are those of another program or set-up is no finding of its own.
    """
    (path, path_codes), (motion, motion_codes) = verdicts
    found = sorted([*motion.findings, *path.findings], key=lambda item: item.code)
    if causes := [*path_codes, *motion_codes]:
        found = [item for item in found if item.code == min(causes) or item.code not in _OF_OTHER_ROWS]
    return replace(
        motion, tip_deviation_mm=path.tip_deviation_mm, axis_deviation_deg=path.axis_deviation_deg, findings=found
    )


class VerifierPart(Protocol):
    """Some of the checks."""

    def check(self, measured: MeasuredBlock) -> None:
        """Check the next rows."""

    def finish(self) -> tuple[Verification, list[str]]:
        """Check the end of the file; returns what these checks found, the rest as it is at the beginning.

        With it come the codes of findings that rows of another program or set-up explain.
        """


class _PathPart:
    """How far the rows are from the program."""

    def __init__(self, reference: Reference, coordinates: TableCoordinates, findings: FindingCollector) -> None:
        self._findings = findings
        self._path = PathCheck(reference, coordinates, self._findings)

    def check(self, measured: MeasuredBlock) -> None:
        for rows in measured.parts:
            self._path.check(rows)

    def finish(self) -> tuple[Verification, list[str]]:
        self._path.finish()
        result = Verification(
            tip_deviation_mm=self._path.tip_deviation,
            axis_deviation_deg=self._path.axis_deviation * DEG_PER_RAD,
            findings=self._findings.findings,
        )
        return result, self._findings.explained


class _MotionPart:
    """Whether the joints, and the progress from row to row, are as they should be."""

    def __init__(
        self, reference: Reference, matcher: RowMatcher, axis_error_limit: float, findings: FindingCollector
    ) -> None:
        self._matcher, self._axis_error_limit = matcher, axis_error_limit
        self._derivative_limits = reference.derivative_limits
        self._findings = findings
        self._dynamics = DynamicsCheck(reference, self._findings)
        self._completeness = CompletenessCheck(reference, self._findings)
        self._between = BetweenRowsCheck(reference, self._findings)
        self._feed = FeedCheck(reference, self._findings)
        self._result = Verification()
        self._lost: LostPath | None = None

    def check(self, measured: MeasuredBlock) -> None:
        block, lost = measured.block, measured.lost
        if not len(block.values):
            return
        if self._result.n_rows == 0:
            self._result.first_row = block.values[0].copy()
        self._result.n_rows += len(block.values)
        nearest = self._dynamics.check(block)
        for rows in measured.parts:
            self._result.n_followed += len(rows.item)
            first = rows.first - block.first
            self._completeness.check(rows)
            self._between.check(rows)
            self._feed.check(rows, nearest[first : first + len(rows.item)])
        if lost is not None:
            self._lost = lost
            self._findings.add(lost.code, lost.text, int(block.line[lost.row]), block.first + lost.row)

    def finish(self) -> tuple[Verification, list[str]]:
        result = self._result
        if result.n_rows == 0:
            self._findings.add("VP412", "the file has no rows", None)
        else:
            # where a file is cut short the joints do not come to rest: one cause, which is told by completeness
            if self._lost is not None or self._completeness.finish(self._matcher.last):
                self._dynamics.finish(result.n_rows)
            if self._lost is None:
                self._feed.blocks.finish(self._matcher.last, result.n_rows)
            elif result.n_followed < _FEW_FOLLOWED * result.n_rows and not self._lost.approaches:
                self._findings.explain(self._lost.code, OTHER_ROWS)
        self._check_axis_error()
        result.velocity_ratio, result.acceleration_ratio, result.jerk_ratio = (
            worst / limit for worst, limit in zip(self._dynamics.worst, self._derivative_limits, strict=True)
        )
        self._feed.finish(result)
        result.axis_error_deg = self._matcher.axis_error * DEG_PER_RAD
        result.findings = self._findings.findings
        return result, self._findings.explained

    def _check_axis_error(self) -> None:
        """Compare the axis error that the machine leaves with what its file accepts."""
        error, limit = self._matcher.axis_error * DEG_PER_RAD, self._axis_error_limit * DEG_PER_RAD
        if error > limit + PATH_AXIS_DEG:
            text = f"the true tool axis is {error:.6f} deg off that of the axes' angles, accepted {limit:.4g} deg"
            self._findings.add("VP411", text, None, value=error, limit=limit, unit="deg")
