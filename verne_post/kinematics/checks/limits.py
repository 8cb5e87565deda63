"""Limits along whole elements, before any time is planned: travel, margins of the module, height over the table.

Each element is covered by spans (:mod:`verne_post.base.spans`). A limit is checked on the bounds between the samples.
Where they cannot decide, the span is halved until they can. Short spans far from every limit need few samples. On the
way the largest derivatives of the joints are collected, which stop-to-stop profiles need.
"""

from collections.abc import Callable
from itertools import tee
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base import spans
from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import GrowingTable
from verne_post.base.rows import find_row_max
from verne_post.base.stopping import check_wanted
from verne_post.base.team import ALONE, Team
from verne_post.base.tolerances import LIMIT_SLACK_MM, SPAN_TAIL, SPAN_TAIL_MM
from verne_post.kinematics.checks.cover import SPAN_ANGLE, SPAN_MM, WORST_DEPTH, Spans, cover_elements, split_elements
from verne_post.kinematics.checks.violations import (
    Worst,
    list_machine_checks,
    report_limit,
    report_table,
    report_unreachable,
)
from verne_post.kinematics.joint_path import JointPath, Solved
from verne_post.model.findings import Finding

#: Derivatives are not taken over less than this: the third one of a joint that is exact to 1e-13 mm is then exact
#: to 1e-7 per mm2, far below what any motion profile notices.
MIN_SPAN_MM: Final = 0.2
#: Rotation of an element (rad) below which it counts as none where a span is widened.
NO_TURN: Final = 1e-12
#: Spans no longer than this, with no more turn, get few samples first: most are far from every limit.
BRIEF_MM: Final = 5.0
BRIEF_ANGLE: Final = np.radians(5.0)
#: A span is halved at most this often; 2**-16 of a metre is 0.015 mm.
MAX_DEPTH: Final = 16


class JointBounds(Struct, frozen=True, eq=False):
    """Largest derivatives of the joints by w over the elements of stop-to-stop sections, one section after the other.

    Stop-to-stop profiles need them; continuous profiles look at the joints themselves.
    """

    #: first, second, third (n, n_joints)
    first: Array
    second: Array
    third: Array
    axis_error_deg: float  #: Over all elements: the largest tool axis error that an as-built machine cannot correct.


def check_limits(
    joints: JointPath, progress: Callable[[int], None] | None = None, team: Team = ALONE
) -> tuple[JointBounds, list[Finding]]:
    """Check every element of a contour.

    Parameters
    ----------
    progress : callable, optional
        Called with the number of elements that have been checked.

    Returns
    -------
    JointBounds
        What stop-to-stop profiles need.
    list of Finding
        VP1xx and VP2xx, one for each stretch of consecutive violating elements.
    """
    contour = joints.contour
    limits = _LimitCheck(joints)
    every = GrowingTable(**dict.fromkeys(("first", "second", "third"), (float, len(joints.machine.columns))))
    chunks, ahead = tee(split_elements(len(contour)))
    for chunk, parts in zip(chunks, team.map(limits.open_spans, ahead), strict=True):
        check_wanted()
        derivatives = _Derivatives(joints, chunk, limits.needs_derivatives(chunk))
        for part in parts:
            # of an element that cannot be reached, and has more spans than are checked together, the rest tells nothing
            part = part.take(~limits.is_unreachable(part.element))
            while len(part):
                part = part.halve(limits.check(part, derivatives))
        every.extend(**derivatives.largest)
        if progress:
            progress(int(chunk[-1]) + 1)
    bounds = JointBounds(**every.freeze(), axis_error_deg=limits.axis_error_deg)
    return bounds, sorted(limits.list_findings(), key=lambda item: (item.line or 0, item.code))


class _Derivatives:
    """Collects the largest derivatives of the joints over a chunk's elements of stop-to-stop sections.

    Parameters
    ----------
    chunk : ndarray of int, shape (n,)
        Consecutive elements.
    wanted : ndarray of bool, shape (n,)
        Those among them.
    """

    def __init__(self, joints: JointPath, chunk: Ints, wanted: Mask) -> None:
        count = np.cumsum(wanted)
        shape = (int(count[-1]), len(joints.machine.columns))
        self.joints, self._first = joints, int(chunk[0])
        self.largest = {name: np.zeros(shape) for name in ("first", "second", "third")}
        #: Row of each element in the bounds; -1: none.
        self._row = np.where(wanted, count - 1, -1)

    def collect(self, part: Spans, values: Array) -> None:
        """Take spans (n,) with their samples (NODES, n, n_joints); very short ones by a longer stretch around them."""
        contour, element = self.joints.contour, part.element
        width = part.high - part.low
        short = np.flatnonzero(contour.length[element] * width < MIN_SPAN_MM)
        if len(short):
            present = 0.5 * width[short]
            turn = SPAN_ANGLE / np.maximum(contour.rotation[element[short]], NO_TURN)
            half = np.maximum(0.5 * np.minimum(MIN_SPAN_MM / contour.length[element[short]], turn), present)
            around = 0.5 * (part.low + part.high)[short] - half + spans.SAMPLES[:, None] * (2 * half)
            q = self.joints.find_joints(np.tile(element[short], spans.NODES), around.ravel()).reshape(*around.shape, -1)
            solved = np.isfinite(q).all(axis=(0, 2))
            values, width = values.copy(), width.copy()
            values[:, short[solved]], width[short[solved]] = q[:, solved], 2 * half[solved]
        row = self._row[element - self._first]
        for order, target in enumerate(self.largest.values(), start=1):
            lower, upper = spans.enclose_derivative(values, order)
            np.maximum.at(target, row, np.maximum(np.abs(lower), np.abs(upper)) / width[:, None] ** order)


class _LimitCheck:
    """Checks spans, and collects the worst violation of each limit."""

    def __init__(self, joints: JointPath) -> None:
        machine = joints.machine
        self.joints, self._continuous = joints, joints.contour.continuous
        self.checks = list_machine_checks(machine)
        self.worst = [Worst() for _ in self.checks]
        #: Columns of the axis error, of either sign, and the largest error so far, degrees.
        self.axis_columns = [len(machine.columns) + k for k, one in enumerate(machine.margins) if one.code == "VP217"]
        self.axis_error_deg = 0.0
        self.below_table = {name: Worst() for name in ("tip", "spindle nose")}
        #: Finding codes of elements that cannot be solved, and the parameter where.
        self.unreachable: dict[int, tuple[str, float]] = {}
        self.tails = np.array([SPAN_TAIL_MM if column.unit == "mm" else SPAN_TAIL for column in machine.columns])

    def list_findings(self) -> list[Finding]:
        """What is violated."""
        contour = self.joints.contour
        findings = report_unreachable(contour, self.unreachable, self.joints.machine.five_axis)
        for check, worst in zip(self.checks, self.worst, strict=True):
            findings += report_limit(contour, check, worst)
        return findings + report_table(contour, self.below_table)

    def check(self, part: Spans, derivatives: _Derivatives) -> Mask:
        """Check spans (n,); those that have to be halved (n,)."""
        element, w = part.place_samples()
        solved = self.joints.solve(element.ravel(), w.ravel())
        solvable = solved.ok.reshape(w.shape).all(axis=0)
        margins = self.joints.find_margins(solved)
        quantities = np.concatenate([solved.q, margins], axis=1).reshape(*w.shape, -1)
        if not solvable.all():
            self._note_unreachable(part.element, w, solved)
            quantities = quantities[:, solvable]
        # Spans next to an unsolvable one are checked too; the unsolvable ones are already a finding.
        kept = np.flatnonzero(solvable)
        halve = np.zeros(len(part), dtype=bool)
        halve[kept] = self._check_quantities(part.take(kept), w[:, kept], quantities, derivatives)
        halve |= self._check_table(part, w, solved)
        return halve & ~self.is_unreachable(part.element)

    def open_spans(self, chunk: Ints) -> list[Spans]:
        """First spans of elements (n,), without those that few samples show to be inside and that nobody needs."""
        contour = self.joints.contour
        return [
            part.take(self.needs_derivatives(part.element) | ~self.are_surely_legal(part))
            for part in cover_elements(contour, chunk)
        ]

    def needs_derivatives(self, element: Ints) -> Mask:
        """Elements (n,) of sections from stop to stop."""
        return np.asarray(~self._continuous[self.joints.contour.section[element]])

    def are_surely_legal(self, part: Spans) -> Mask:
        """Spans (n,) that few samples show to be within limits, as :meth:`check` would.

        They are short and farther from limits than they move. None are where the axis error is measured, which takes
        the bounds of all spans.
        """
        contour, width, legal = self.joints.contour, part.high - part.low, np.zeros(len(part), dtype=bool)
        brief = (contour.length[part.element] * width <= BRIEF_MM) & (
            contour.rotation[part.element] * width <= BRIEF_ANGLE
        )
        some = np.flatnonzero(brief) if not self.axis_columns else np.empty(0, dtype=np.intp)
        if not len(some):
            return legal
        element, w = part.take(some).place_samples(spans.FEW_SAMPLES)
        solved = self.joints.solve(element.ravel(), w.ravel())
        values = np.concatenate([solved.q, self.joints.find_margins(solved)], axis=1).reshape(*w.shape, -1)
        lower, upper = _bound(values)
        # not a number where a sample cannot be solved: not within limits
        enough = [
            lower[:, one.quantity] >= one.warn if one.sign > 0 else upper[:, one.quantity] <= one.warn
            for one in self.checks
        ]
        axis, tool_length = self.joints.find_tool_axis(solved)[:, 2], contour.find_tool_lengths(element.ravel())
        heights = (solved.tip[:, 2] + along * axis for along in (self.joints.lift, tool_length))
        enough += [_bound(height.reshape(*w.shape, 1))[0][:, 0] >= 0.0 for height in heights]
        legal[some] = np.all(enough, axis=0)
        return legal

    def is_unreachable(self, element: Ints) -> Mask:
        """Elements (n,) that are a finding already: their other bounds need no refinement."""
        if not self.unreachable:
            return np.zeros(len(element), dtype=bool)
        return np.isin(element, list(self.unreachable))

    def _check_quantities(self, part: Spans, w: Array, quantities: Array, derivatives: _Derivatives) -> Mask:
        """Check joints and margins: samples (m, n, k) of spans at w (m, n); what has to be halved (n,)."""
        n_joints = len(self.tails)
        values = quantities[: spans.NODES]
        tail = spans.bound_tail(values)
        coarse = find_row_max(tail[:, :n_joints] - self.tails) > 0.0
        deep = part.depth >= MAX_DEPTH
        halve = coarse & ~deep
        fine = (~coarse | deep) & self.needs_derivatives(part.element)
        if fine.any():
            derivatives.collect(part.take(fine), values[:, fine, :n_joints])
        lower, upper = spans.enclose_derivative(values)
        for check, worst in zip(self.checks, self.worst, strict=True):
            k = check.quantity
            if check.sign > 0:
                certain, margin = lower[:, k] - tail[:, k] - check.warn, quantities[:, :, k] - check.warn
            else:
                certain, margin = check.warn - upper[:, k] - tail[:, k], check.warn - quantities[:, :, k]
            seen = margin.min(axis=0)
            open_ = np.flatnonzero(certain < -check.slack)
            if not len(open_):
                continue
            broken = open_[seen[open_] < -check.slack]
            at = w[margin[:, broken].argmin(axis=0), broken]
            worst.note(part.element[broken], seen[broken], check.warn + check.sign * seen[broken], at)
            deepest = np.where(seen[open_] < -check.slack, WORST_DEPTH, MAX_DEPTH)
            halve[open_[(seen[open_] - certain[open_] > check.slack) & (part.depth[open_] < deepest)]] = True
        settled = np.flatnonzero(~halve)
        for k in self.axis_columns:
            bound = tail[settled, k] - lower[settled, k]
            self.axis_error_deg = max(self.axis_error_deg, float(bound.max(initial=0.0)))
        return np.asarray(halve)

    def _check_table(self, part: Spans, w: Array, solved: Solved) -> Mask:
        """VP210, tip or nose below z = 0 of the table frame within the table's radius; what has to be halved (n,)."""
        radius = self.joints.machine.table_radius
        halve = np.zeros(len(part), dtype=bool)
        shape = (len(spans.WITH_ENDS), len(part), 1)
        tool_length = self.joints.contour.find_tool_lengths(np.tile(part.element, shape[0]))
        axis = self.joints.find_tool_axis(solved)
        ways = (np.full(len(axis), self.joints.lift), tool_length)
        for along, below in zip(ways, self.below_table.values(), strict=True):
            height = (solved.tip[:, 2] + along * axis[:, 2]).reshape(shape)
            if height.min() > SPAN_MM:
                continue
            low_height = spans.enclose_derivative(height[: spans.NODES])[0][:, 0]
            if min(height.min(), low_height.min()) >= -LIMIT_SLACK_MM:
                continue
            point = solved.tip + along[:, None] * axis
            away = (point[:, 0] ** 2 + point[:, 1] ** 2).reshape(shape)
            low_away = spans.enclose_derivative(away[: spans.NODES])[0][:, 0]
            open_ = (low_height < -LIMIT_SLACK_MM) & (low_away < radius**2)
            under = (height[:, :, 0] < -LIMIT_SLACK_MM) & (away[:, :, 0] < radius**2)
            anywhere = under.any(axis=0)
            broken = np.flatnonzero(anywhere)
            if len(broken):
                low = np.where(under[:, broken], height[:, broken, 0], np.inf)
                lowest, at = low.min(axis=0), w[low.argmin(axis=0), broken]
                below.note(part.element[broken], lowest, lowest, at)
            deepest = np.where(anywhere, WORST_DEPTH, MAX_DEPTH)
            gap = height[:, :, 0].min(axis=0) - low_height
            halve |= open_ & (part.depth < deepest) & ((gap > LIMIT_SLACK_MM) | ~anywhere)
        return halve

    def _note_unreachable(self, element: Ints, w: Array, solved: Solved) -> None:
        """Keep why elements (n,) of spans, with samples at w (m, n), cannot be solved: the code of one such sample.

        The place is the begin of an element where that cannot be solved, which the line before it brings; else the
        farthest, which its own line brings.
        """
        unsolved = ~solved.ok.reshape(w.shape)
        span, sample = np.nonzero(unsolved.T)
        bad = sample * len(element) + span
        elements, first = np.unique(element[span], return_index=True)
        fresh = [k for k, e in enumerate(elements.tolist()) if e not in self.unreachable]
        if not fresh:
            return
        rows = bad[first[fresh]]
        codes = self.joints.machine.five_axis.explain_unreachable(
            solved.tip[rows], solved.angles[rows], self.joints.contour.find_tool_lengths(elements[fresh])
        )
        for e, code in zip(elements[fresh].tolist(), codes, strict=True):
            places = w[unsolved & (element == e)]
            self.unreachable[e] = code, float(places.max() if places.min() > 0.0 else 0.0)


def _bound(values: Array) -> tuple[Array, Array]:
    """Lower and upper bound (n, k) of samples (m, n, k), by what the polynomial may be off."""
    (lower, upper), tail = spans.enclose_derivative(values), spans.bound_tail(values)
    return lower - tail, upper + tail
