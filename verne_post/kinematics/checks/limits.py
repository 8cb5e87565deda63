"""Every check of geometry, along whole elements, before any time is planned.

Each element is covered by spans (:mod:`verne_post.base.spans`). A limit is judged on the bounds
between the samples; where they cannot decide, the span is halved until they can. On the way the
largest derivatives of the joints are collected, which the time law needs.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base import spans
from verne_post.base.columns import GrowingTable, blocks
from verne_post.base.ragged import ragged
from verne_post.base.rotations import axis_of_angles
from verne_post.base.rows import row_max
from verne_post.base.tolerances import LIMIT_SLACK, LIMIT_SLACK_MM, SPAN_TAIL, SPAN_TAIL_MM
from verne_post.kinematics.joint_path import JointPath, Solved
from verne_post.model.codes import CODES
from verne_post.model.contour import Contour
from verne_post.model.findings import Finding, finding
from verne_post.model.machine import Machine
from verne_post.model.verdict import Severity

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: Segments judged at a time.
CHUNK_SEGMENTS: Final = 2048
#: First guess of a span: at most this much path and rotation.
SPAN_MM: Final = 50.0
SPAN_ANGLE: Final = np.radians(20.0)
#: Derivatives are not taken over less than this: the third one of a joint that is exact to 1e-13 mm is then exact
#: to 1e-7 per mm2, far below what any time law notices.
MIN_SPAN_MM: Final = 0.2
#: A span is halved at most this often; 2**-16 of a metre is 0.015 mm.
MAX_DEPTH: Final = 16
#: Once a violation is certain its worst value is refined only this much further.
WORST_DEPTH: Final = 7


@dataclass(frozen=True)
class Check:
    """One bound on one quantity: ``sign * (value - limit)`` must not be below zero.

    ``warn`` is a second, weaker threshold; below it a warning is due.
    """

    code: str
    name: str
    axis: str | None
    quantity: int
    sign: float
    limit: float
    warn: float
    slack: float
    unit: str
    factor: float


@dataclass(frozen=True, eq=False)
class JointBounds:
    """Largest derivatives of the joints by w over the elements of runs from stop to stop, one run after the other.

    A law from stop to stop needs them; one that flows looks at the joints themselves.

    Attributes
    ----------
    first, second, third : ndarray, shape (n, n_joints)
    """

    first: Array
    second: Array
    third: Array


@dataclass
class Worst:
    """Worst value of one check for each segment that violates it."""

    value: dict[int, tuple[float, float]] = field(default_factory=dict)  # segment -> (margin, value)

    def note(self, segment: Ints, margin: Array, value: Array) -> None:
        for p, m, v in zip(segment.tolist(), margin.tolist(), value.tolist(), strict=True):
            if p not in self.value or m < self.value[p][0]:
                self.value[p] = (m, v)


def machine_checks(machine: Machine) -> list[Check]:
    """The bounds of a machine, from its limits and the margins of its module."""
    found = []
    for joint, column in enumerate(machine.columns):
        slack = LIMIT_SLACK_MM if column.unit == "mm" else LIMIT_SLACK
        for sign, limit in ((1.0, machine.limits.lower[joint]), (-1.0, machine.limits.upper[joint])):
            if np.isfinite(limit):
                found.append(
                    Check(column.code, CODES[column.code].title, column.joint, joint, sign, float(limit), float(limit),
                          slack, column.unit, column.factor)
                )  # fmt: skip
    n = len(machine.columns)
    for index, margin in enumerate(machine.margins):
        found.append(
            Check(margin.code, margin.name, margin.axis, n + index, 1.0, margin.error_below, margin.warn_below,
                  LIMIT_SLACK_MM, margin.unit, 1.0)
        )  # fmt: skip
    return found


def check_limits(joints: JointPath, progress: Callable[[int], None] | None = None) -> tuple[JointBounds, list[Finding]]:
    """Judge every element of a contour.

    Parameters
    ----------
    joints : JointPath
    progress : callable, optional
        Told how many elements have been judged.

    Returns
    -------
    JointBounds
        What the time laws from stop to stop need.
    list of Finding
        VP1xx and VP2xx, one for each stretch of consecutive violating segments.
    """
    machine, contour = joints.machine, joints.contour
    n, n_joints = len(contour), len(machine.columns)
    every = GrowingTable(**dict.fromkeys(("first", "second", "third"), (float, n_joints)))
    stopping = ~contour.continuous
    checks = machine_checks(machine)
    worst = [Worst() for _ in checks]
    below_table = Worst()
    unreachable: dict[int, str] = {}
    for chunk in chunks(n):
        own = stopping[contour.section[chunk]]
        row = np.cumsum(own) - 1  # of the bounds of this chunk
        bounds = JointBounds(*(np.zeros((int(row[-1]) + 1, n_joints)) for _ in range(3)))
        bounded = _Bounded(bounds, int(chunk[0]), np.where(own, row, -1))
        for segment, low, high, depth in first_cover(contour, chunk):
            _judge_spans(joints, segment, low, high, depth, bounded, checks, worst, below_table, unreachable)
        every.extend(**vars(bounds))
        if progress:
            progress(int(chunk[-1]) + 1)
    findings = _unreachable_findings(contour, unreachable)
    for check, found in zip(checks, worst, strict=True):
        findings += limit_findings(contour, check, found)
    findings += _table_findings(contour, below_table)
    return JointBounds(**every.columns()), sorted(findings, key=lambda item: (item.line or 0, item.code))


def chunks(n: int) -> Iterator[Ints]:
    """The numbers of n elements, so many as are judged at a time."""
    for begin, end in blocks(n):
        for first in range(begin, end, CHUNK_SEGMENTS):
            yield np.arange(first, min(first + CHUNK_SEGMENTS, end))


def first_cover(contour: Contour, chunk: Ints) -> Iterator[tuple[Ints, Array, Array, Ints]]:
    """First cover of elements: (element, low, high, depth)."""
    wanted = np.maximum(contour.length[chunk] / SPAN_MM, contour.turn[chunk] / SPAN_ANGLE)
    parts = np.maximum(np.ceil(wanted), 1).astype(int)
    owner, index = ragged(parts)
    segment, share = chunk[owner], parts[owner]
    for begin in range(0, len(segment), CHUNK_SEGMENTS):
        some = slice(begin, begin + CHUNK_SEGMENTS)
        yield (
            segment[some],
            index[some] / share[some],
            (index[some] + 1) / share[some],
            np.zeros(len(segment[some]), int),
        )


def _judge_spans(
    joints: JointPath, segment: Ints, low: Array, high: Array, depth: Ints, bounded: "_Bounded",
    checks: list[Check], worst: list[Worst], below_table: Worst, unreachable: dict[int, str],
) -> None:  # fmt: skip
    """Judge spans, halving those that the bounds cannot decide."""
    machine = joints.machine
    n_joints = len(machine.columns)
    tails = np.array([SPAN_TAIL_MM if column.unit == "mm" else SPAN_TAIL for column in machine.columns])
    while len(segment):
        u = low + spans.WITH_ENDS[:, None] * (high - low)
        solved = joints.solve(np.tile(segment, len(u)), u.ravel())
        solvable = solved.ok.reshape(u.shape).all(axis=0)
        if not solvable.all():
            _note_unreachable(joints, segment, u, solved, unreachable)
        quantities = np.concatenate([solved.q, machine.module.geometry_margins(solved.position, solved.alpha)], axis=1)
        every = quantities.reshape(*u.shape, -1)
        if not solvable.all():
            every = every[:, solvable]
        values = every[: spans.NODES]
        kept = np.flatnonzero(solvable)
        halve = np.zeros(len(segment), dtype=bool)
        # Spans next to an unsolvable one are judged too; the unsolvable ones are already a finding.
        rough = spans.tail(values)
        coarse = row_max(rough[:, :n_joints] - tails) > 0.0
        deep = depth[kept] >= MAX_DEPTH
        halve[kept] |= coarse & ~deep
        fine = (~coarse | deep) & (bounded.row[segment[kept] - bounded.first] >= 0)
        if fine.any():
            some = kept[fine]
            _collect(joints, bounded, segment[some], low[some], high[some], values[:, fine, :n_joints])
        lower, upper = spans.enclosure(values)
        for check, found in zip(checks, worst, strict=True):
            k = check.quantity
            if check.sign > 0:
                certain, seen = lower[:, k] - rough[:, k] - check.warn, every[:, :, k].min(axis=0) - check.warn
            else:
                certain, seen = check.warn - upper[:, k] - rough[:, k], check.warn - every[:, :, k].max(axis=0)
            open_ = np.flatnonzero(certain < -check.slack)
            if not len(open_):
                continue
            broken = open_[seen[open_] < -check.slack]
            found.note(segment[kept[broken]], seen[broken], check.warn + check.sign * seen[broken])
            gap = seen[open_] - certain[open_]
            limit = np.where(seen[open_] < -check.slack, WORST_DEPTH, MAX_DEPTH)
            more = (gap > check.slack) & (depth[kept[open_]] < limit)
            halve[kept[open_[more]]] = True
        _judge_table(joints, segment, solved, depth, halve, below_table)
        if unreachable:  # an unreachable segment is a finding already; its other bounds need no refinement
            halve &= ~np.isin(segment, list(unreachable))
        index = np.flatnonzero(halve)
        middle = 0.5 * (low[index] + high[index])
        segment = np.concatenate([segment[index], segment[index]])
        low, high = np.concatenate([low[index], middle]), np.concatenate([middle, high[index]])
        depth = np.concatenate([depth[index], depth[index]]) + 1


@dataclass(frozen=True, eq=False)
class _Bounded:
    """Bounds of the elements from number ``first`` on, and the row (n,) that each has there; -1: none."""

    bounds: JointBounds
    first: int
    row: Ints


def _collect(joints: JointPath, bounded: _Bounded, segment: Ints, low: Array, high: Array, values: Array) -> None:
    """Keep the largest derivatives; those of very short spans are taken from a longer stretch around them."""
    contour = joints.contour
    width = high - low
    short = np.flatnonzero(contour.length[segment] * width < MIN_SPAN_MM)
    if len(short):
        own = 0.5 * width[short]
        turn = SPAN_ANGLE / np.maximum(contour.turn[segment[short]], 1e-12)
        half = np.maximum(0.5 * np.minimum(MIN_SPAN_MM / contour.length[segment[short]], turn), own)
        around = 0.5 * (low + high)[short] - half + spans.SAMPLES[:, None] * (2 * half)
        q = joints.q(np.tile(segment[short], spans.NODES), around.ravel()).reshape(*around.shape, -1)
        solved = np.isfinite(q).all(axis=(0, 2))
        values, width = values.copy(), width.copy()
        values[:, short[solved]], width[short[solved]] = q[:, solved], 2 * half[solved]
    bounds, row = bounded.bounds, bounded.row[segment - bounded.first]
    for order, target in enumerate((bounds.first, bounds.second, bounds.third), start=1):
        lower, upper = spans.enclosure(values, order)
        np.maximum.at(target, row, np.maximum(np.abs(lower), np.abs(upper)) / width[:, None] ** order)


def _judge_table(joints: JointPath, segment: Ints, solved: Solved, depth: Ints, halve: Mask, found: Worst) -> None:
    """VP210: tip or nose below z = 0 of the table frame within the table's radius."""
    radius = joints.machine.table_radius
    shape = (len(spans.WITH_ENDS), len(segment), 1)
    tool_length = joints.contour.tool_length(np.tile(segment, shape[0]))
    upwards = np.cos(solved.angles[:, 0])
    for along in (np.full(len(upwards), joints.lift), tool_length):
        height = (solved.tip[:, 2] + along * upwards).reshape(shape)
        if height.min() > SPAN_MM:
            continue
        low_height = spans.enclosure(height[: spans.NODES])[0][:, 0]
        if min(height.min(), low_height.min()) >= -LIMIT_SLACK_MM:
            continue
        point = solved.tip + along[:, None] * axis_of_angles(solved.angles[:, 0], solved.angles[:, 1])
        away = (point[:, 0] ** 2 + point[:, 1] ** 2).reshape(shape)
        low_away = spans.enclosure(away[: spans.NODES])[0][:, 0]
        open_ = (low_height < -LIMIT_SLACK_MM) & (low_away < radius**2)
        under = (height[:, :, 0] < -LIMIT_SLACK_MM) & (away[:, :, 0] < radius**2)
        anywhere = under.any(axis=0)
        broken = np.flatnonzero(anywhere)
        if len(broken):
            deepest = np.where(under[:, broken], height[:, broken, 0], np.inf).min(axis=0)
            found.note(segment[broken], deepest, deepest)
        limit = np.where(anywhere, WORST_DEPTH, MAX_DEPTH)
        gap = height[:, :, 0].min(axis=0) - low_height
        halve |= open_ & (depth < limit) & ((gap > LIMIT_SLACK_MM) | ~anywhere)


# --- findings ------------------------------------------------------------------------------


def _note_unreachable(joints: JointPath, segment: Ints, u: Array, solved: Solved, unreachable: dict[int, str]) -> None:
    span, sample = np.nonzero(~solved.ok.reshape(u.shape).T)
    bad = sample * len(segment) + span
    new, first = np.unique(segment[span], return_index=True)  # the first one along the way says why
    fresh = [k for k, p in enumerate(new) if int(p) not in unreachable]
    if not fresh:
        return
    rows = bad[first[fresh]]
    codes = joints.machine.five_axis.why_unreachable(
        solved.tip[rows], solved.angles[rows], joints.contour.tool_length(new[fresh])
    )
    unreachable.update(zip((int(p) for p in new[fresh]), codes, strict=True))


def _segments(contour: Contour, group: list[int]) -> int:
    """How many programmed segments a group of elements belongs to."""
    return len(np.unique(contour.segment[group]))


def _stretches(segments: list[int]) -> Iterator[list[int]]:
    """Maximal groups of consecutive numbers."""
    group: list[int] = []
    for segment in sorted(segments):
        if group and segment != group[-1] + 1:
            yield group
            group = []
        group.append(segment)
    if group:
        yield group


def _unreachable_findings(contour: Contour, unreachable: dict[int, str]) -> list[Finding]:
    found = []
    for code in sorted(set(unreachable.values())):
        for group in _stretches([segment for segment, why in unreachable.items() if why == code]):
            lines = contour.line(np.array(group))
            what = {
                "VP110": "out of reach: no position of the sliders closes the rods",
                "VP201": "the rods of leg I would cross: R1 cos(alpha) <= r1 in every solution",
                "VP203": "out of reach: beyond a parallel singularity in every solution",
            }.get(code, CODES[code].meaning)
            found.append(
                finding(
                    code,
                    what,
                    severity="error",
                    line=int(lines[0]),
                    last_line=int(lines[-1]),
                    worst_line=int(lines[0]),
                    count=_segments(contour, group),
                )
            )
    return found


def limit_findings(contour: Contour, check: Check, worst: Worst) -> list[Finding]:
    found = []
    levels: list[tuple[Severity, list[int], float]] = []
    deficit = {segment: value for segment, (_m, value) in worst.value.items()}
    if check.warn == check.limit:
        levels.append(("error", list(deficit), check.limit))
    else:
        bad = [p for p, v in deficit.items() if check.sign * (v - check.limit) < -check.slack]
        levels.append(("error", bad, check.limit))
        levels.append(("warning", [p for p in deficit if p not in set(bad)], check.warn))
    for severity, segments, limit in levels:
        for group in _stretches(segments):
            at = min(group, key=lambda segment: check.sign * deficit[segment])
            value, bound = deficit[at] * check.factor, limit * check.factor
            side = "below" if value < bound else "above"
            what = check.axis if check.code.startswith("VP10") and check.axis else check.name
            if check.code == "VP202":
                what = f"{check.name} ({check.axis})"
            unit = f" {check.unit}" if check.unit else ""
            first, last, at_worst = contour.line(np.array([group[0], group[-1], at])).tolist()
            message = f"{what} {value:.6f}{unit} is {side} {bound:g}{unit} by {abs(value - bound):.6f}{unit}"
            found.append(
                finding(
                    check.code, message, severity=severity, line=first, last_line=last, worst_line=at_worst, axis=check.axis,
                    value=value, limit=bound, unit=check.unit, count=_segments(contour, group),
                )
            )  # fmt: skip
    return found


def _table_findings(contour: Contour, below: Worst) -> list[Finding]:
    found = []
    for group in _stretches(list(below.value)):
        at = min(group, key=lambda segment: below.value[segment][0])
        value = below.value[at][1]
        first, last, at_worst = contour.line(np.array([group[0], group[-1], at])).tolist()
        message = f"tip or spindle nose {-value:.6f} mm below the table face, inside the table's radius"
        found.append(
            finding("VP210", message, line=first, last_line=last, worst_line=at_worst, value=value, limit=0.0, unit="mm", count=_segments(contour, group))
        )  # fmt: skip
    return found
