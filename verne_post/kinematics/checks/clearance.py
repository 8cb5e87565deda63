"""Clearances along whole elements: no touch between two samples goes unseen.

A distance is no polynomial, but it cannot change faster than the points move that carry it. Their speed over a span
is bounded by enclosures; a span whose smallest sampled distance is larger than what they can travel to the next
sample is certain, every other one is halved.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np

from verne_post.base import spans
from verne_post.base.arrays import Array, Mask
from verne_post.base.team import ALONE, Team
from verne_post.kinematics.checks.cover import WORST_DEPTH, Spans, cover_elements, split_elements
from verne_post.kinematics.checks.limits import JointBounds, check_limits
from verne_post.kinematics.checks.violations import Check, Worst, report_limit
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.findings import Finding
from verne_post.model.protocols import ClearanceModel
from verne_post.model.toolpath import SegmentKind

if TYPE_CHECKING:
    from verne_post.kinematics.checks.keep_out import KeepOut

#: A span is halved at most this often: then its points move by a nanometre or less, and what is seen is what is.
MAX_DEPTH: Final = 24
#: Spans that are checked together.
CHUNK_SPANS: Final = 4096
#: Half the largest distance between neighbouring samples, ends included, as a share of the span.
HALF_GAP: Final = float(0.5 * np.diff(np.sort(spans.WITH_ENDS)).max())


def check_constraints(
    joints: JointPath, progress: Callable[[int], None] | None = None, team: Team = ALONE
) -> tuple[JointBounds, list[Finding]]:
    """Every geometric check of a contour: :func:`check_limits`, clearances of the machine file, keep-out bodies."""
    bounds, findings = check_limits(joints, progress, team)
    for model in list_clearances(joints):
        findings += check_clearance(joints, model)
    bodies = _find_bodies(joints)
    if bodies is not None:
        from verne_post.kinematics.checks.mesh_contacts import check_meshes, check_rigid

        meshes, rigid = bodies.select("mesh"), bodies.select("rigid")
        for check, pairs in ((check_meshes, meshes), (check_rigid, rigid)):
            findings += check(joints, pairs, build_clearance_checks(pairs, 0)) if pairs.pairs else []
    return bounds, sorted(findings, key=lambda item: (item.line or 0, item.code))


def _find_bodies(joints: JointPath) -> "KeepOut | None":
    """Bodies around the motion; most programs have none, and load nothing for them."""
    if joints.keep_out is None:
        return None
    from verne_post.kinematics.checks.keep_out import KeepOut

    return joints.keep_out if isinstance(joints.keep_out, KeepOut) else None


def list_clearances(joints: JointPath, *, meshes: bool = False) -> list[ClearanceModel]:
    """The models of distances in single poses: between bodies of the machine, from boxes (or meshes) on the table."""
    bodies = _find_bodies(joints)
    if bodies is not None and not meshes:
        bodies = bodies.select("box")
    return [model for model in (joints.machine.clearance, bodies) if model is not None and model.names]


def build_clearance_checks(clearance: ClearanceModel, first: int) -> list[Check]:
    """The bounds on the clearances, as quantities from ``first`` on."""
    return [
        Check(m.code, m.name, m.axis, first + k, 1.0, m.error_below, m.warn_below, clearance.slack, m.unit, 1.0)
        for k, m in enumerate(clearance.names)
    ]


def check_clearance(joints: JointPath, clearance: ClearanceModel) -> list[Finding]:
    """VP211 to VP216: VP215 as in :func:`check_meshes`, else one finding for each stretch of elements."""
    contour = joints.contour
    check = _ClearanceCheck(joints, clearance)
    for chunk in split_elements(len(contour)):
        for part in cover_elements(contour, chunk):
            waiting = [part]
            while waiting:  # the halves of some before others, so that few wait at a time
                part = waiting.pop()
                if len(part) > CHUNK_SPANS:
                    waiting.append(part.take(slice(CHUNK_SPANS, None)))
                    part = part.take(slice(CHUNK_SPANS))
                halves = part.halve(check.check(part))
                if len(halves):
                    waiting.append(halves)
    bodies = _find_bodies(joints)
    tool = None if bodies is None or clearance is joints.machine.clearance else bodies.moving.tool[contour.segment]
    checks = build_clearance_checks(clearance, len(joints.machine.columns))
    return [
        item
        for one, worst in zip(checks, check.worst, strict=True)
        for item in report_limit(contour, one, worst, tool if one.code == "VP215" else None)
    ]


class _ClearanceCheck:
    """Checks spans, and collects the worst violation of each clearance."""

    def __init__(self, joints: JointPath, clearance: ClearanceModel) -> None:
        self.joints, self.clearance = joints, clearance
        self.limits = np.array([margin.error_below for margin in clearance.names])
        self.worst = [Worst() for _ in clearance.names]
        #: How often a span that violates is halved at most. How deep a tool is in the box of a stock does not matter:
        #: the cut stock decides.
        of_stock = np.array([margin.code == "VP216" for margin in clearance.names])
        self.deepest = np.where(of_stock & np.isfinite(clearance.convex_below), 0, WORST_DEPTH)
        self.straight = find_straight(joints)

    def check(self, part: Spans) -> Mask:
        """Check spans (n,); those that have to be halved (n,)."""
        clearance = self.clearance
        element, w = part.place_samples()
        owner = element.ravel()
        margins, points = clearance.evaluate(self.joints.place_bodies(owner, self.joints.solve(owner, w.ravel())))
        margins = margins.reshape(*w.shape, -1)
        moved = {group: _bound_travel(values.reshape(*w.shape, -1)) for group, values in points.items()}
        seen = margins.min(axis=0) - self.limits
        certain = seen - clearance.reach * np.stack([moved[group] for group in clearance.group], axis=1)
        rigid = np.flatnonzero(self.straight[part.element])
        if len(rigid) and np.isfinite(clearance.convex_below).any():
            convex = _bound_convex(margins[:, rigid], clearance.convex_below) - self.limits
            certain[rigid] = np.maximum(certain[rigid], convex)
        solvable = np.isfinite(margins).all(axis=(0, 2))  # the others are findings of their own
        halve = np.zeros(len(part), dtype=bool)
        for k, worst in enumerate(self.worst):
            open_ = np.flatnonzero(solvable & (certain[:, k] < -clearance.slack))
            broken = open_[seen[open_, k] < -clearance.slack]
            at = w[margins[:, broken, k].argmin(axis=0), broken]
            worst.note(part.element[broken], seen[broken, k], seen[broken, k] + self.limits[k], at)
            deepest = np.where(seen[open_, k] < -clearance.slack, self.deepest[k], MAX_DEPTH)
            gap = seen[open_, k] - certain[open_, k]
            halve[open_[(gap > clearance.slack) & (part.depth[open_] < deepest)]] = True
        return halve


def find_straight(joints: JointPath) -> Mask:
    """Elements (n,) with a straight path and constant tool axis on the table: distances are convex along them."""
    contour, path = joints.contour, joints.contour.path
    even = (
        (path.kind == SegmentKind.LINE)
        & (path.circle < 0)
        & (np.abs(path.end[:, 3:] - path.start[:, 3:]).max(axis=1) == 0)
    )
    return np.asarray(even[contour.segment] & ~contour.blended)


def _bound_convex(margins: Array, below: Array) -> Array:
    """Lower bounds (n, k) of convex functions, from values (samples, n, k) at the samples of spans with their ends.

    Between two samples a convex function lies above both lines through the samples before and after it. Minus infinity
    where a value is not ``below`` (k,) and so no exact one.
    """
    order = np.argsort(spans.WITH_ENDS)
    x, f = spans.WITH_ENDS[order], margins[order]
    bound = np.full(f.shape[1:], np.inf)
    slope = np.diff(f, axis=0) / np.diff(x)[:, None, None]
    last = len(x) - 2
    for i in range(last + 1):
        here, there, width = f[i], f[i + 1], x[i + 1] - x[i]
        if i == 0:
            lowest = there - slope[1] * width
        elif i == last:
            lowest = here + slope[i - 1] * width
        else:
            before, after = slope[i - 1], slope[i + 1]
            rises = after > before  # else the stretch is straight, up to rounding
            # where the line that goes on from the left meets the one that comes from the right
            meet = (there - after * width - here) / np.where(rises, before - after, -1.0)
            lowest = np.where(rises, here + before * np.clip(meet, 0.0, width), here)
        bound = np.minimum(bound, np.minimum(lowest, np.minimum(here, there)))
    return np.where((f < below).all(axis=0), bound, -np.inf)


def _bound_travel(points: Array) -> Array:
    """How far a point of spans (samples, n, 3 p) can be at most from where it is at the nearest sample: (n,), mm."""
    low, high = spans.enclose_derivative(points[: spans.NODES], 1)
    speed = np.maximum(np.abs(low), np.abs(high)).reshape(len(low), -1, 3)
    return np.asarray(HALF_GAP * np.linalg.norm(speed, axis=-1).max(axis=1))
