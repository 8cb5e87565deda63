"""What the planned motion comes to line by line: time, feed, what limits it, and how near to a limit of position."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.assemble import Program
from verne_post.app.plan import Plan
from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.toolpath.margins import list_margin_functions
from verne_post.trajectory.sample import BLOCK_ROWS, RowSampler

#: What governs where no limit of a joint does.
OTHERS: Final = ("programmed feed", "no limit near", "standstill")
#: A row at this share of the programmed feed is at the feed: motion profiles approach it from below.
AT_FEED: Final = 0.99
#: Velocity, acceleration and jerk grow by the first, second and third power of the speed along a path.
RATES: Final = {"velocity": 1, "acceleration": 2, "jerk": 3}
#: Below this share of every limit none of them holds the motion back.
_NEAR_SHARE: Final = 0.1
#: Of one motion, so many blocks of rows between its first and its last are gone through: at a mistyped feed rate it
#: lasts hours, over which the motion is even.
_BLOCKS: Final = 16


class RowShares(Struct, frozen=True, eq=False):
    """How near rows (m,) are to the programmed feed rate, and to the limits of the joints."""

    feeding: Mask  #: (m,): The row moves at a feed rate, not in a rapid.
    share: Array  #: (m,): Of the feed rate.
    shares: Array  #: (m, k): Of each limit of a joint.
    nearest: Ints  #: (m,): What governs, by its place in ``names`` of :class:`RowLimits`.


class RowLimits:
    """The programmed feed rates of a program and the limits of its joints, to compare rows with."""

    def __init__(self, program: Program) -> None:
        machine, feeds, override = program.machine, program.contour.feeds, program.options.override
        self.factor = np.array([column.factor for column in machine.columns])
        self._limits = {name: getattr(machine.limits, name) * np.abs(self.factor) for name in RATES}
        self.rate, self._cap, self._by_tip = feeds.rate * override, feeds.cap * override, feeds.by_tip
        self.names = (*(f"{name} of {column.joint}" for name in RATES for column in machine.columns), *OTHERS)

    def measure(self, segment: Ints, speed: Array, turning: Array, rates: dict[str, Array]) -> RowShares:
        """Compare rows (m,): segment, speed of the tip (mm/s) and of A and C together (rad/s), rates as in the file."""
        rate, by_tip = self.rate[segment], self._by_tip[segment]
        feeding = np.isfinite(rate)
        # where the feed rate is a time, progress counts: tip and table together, as metric length has them
        along = np.where(by_tip, speed, np.hypot(speed, ROTARY_METRIC_MM * turning))
        share = np.where(feeding, along / np.where(feeding, np.where(by_tip, rate, self._cap[segment]), 1.0), 0.0)
        shares = np.concatenate([np.abs(rates[name]) / self._limits[name] for name in RATES], axis=1)
        nearest = shares.argmax(axis=1)
        feed, shape, rest = range(shares.shape[1], len(self.names))
        nearest[shares.max(axis=1) < _NEAR_SHARE] = shape
        nearest[share >= AT_FEED] = feed
        nearest[~np.asarray(rates["velocity"]).any(axis=1)] = rest
        return RowShares(feeding, share, shares, nearest)


class LineFacts(Struct, frozen=True, eq=False):
    """Facts of source lines (n,), which are in order."""

    line: Ints  #: (n,)
    seconds: Array  #: (n,): Over all passes of a line.
    speed: Array  #: (n,): Of the tip over the part where it is fastest, mm/s.
    margin: Array  #: (n,): The smallest: 0 at a limit, 1 where there is plenty (:mod:`verne_post.toolpath.margins`).
    nearest: Ints  #: (n,): Which limit that is, by its place in ``names``.
    names: tuple[str, ...]
    #: (n,): What holds the feed back for most of the time in which it is not reached; empty where it is reached.
    held_by: tuple[str, ...]

    def find(self, line: int) -> int | None:
        """Place of a line in the columns; None for one without rows."""
        at = int(np.searchsorted(self.line, line))
        return at if at < len(self.line) and self.line[at] == line else None


def measure_lines(plan: Plan) -> LineFacts:
    """Go through the rows of a plan, before an input shaper."""
    program, cycle = plan.program, plan.timeline.cycle
    joints, path = program.build_joint_path(), program.path
    margins, names = list_margin_functions(program.machine)
    sampler = RowSampler(program.contour, plan.profiles, plan.timeline)
    lines = np.unique(np.append(program.contour.find_lines(), plan.timeline.line))
    limits, none = RowLimits(program), np.zeros(len(lines))
    count, speed = none.copy(), none.copy()
    lost = np.zeros((len(lines), len(limits.names) - len(OTHERS)))
    recent: Array | None = None  # (3, n_joints): positions before the next row, units of the file
    margin, nearest = np.full(len(lines), np.inf), np.zeros(len(lines), dtype=np.int64)
    last: tuple[Array, Array, Array, Array] | None = None  # tip, joints, tool length and angles of the row before
    following = 0
    for first_row, n_blocks in _choose_blocks(plan):
        if first_row != following:  # what comes before these rows
            rows = sampler.make_rows(first_row - BLOCK_ROWS)
            poses = joints.find_joint_poses(rows.shown[-3:], rows.shown_w[-3:])
            length = path.tool_length[program.contour.segment[rows.shown[-1:]]]
            recent, last = poses.q * limits.factor, (poses.tip[-1:], poses.q[-1:], length, poses.angles[-1:])
        rows, following = sampler.make_rows(first_row), first_row + BLOCK_ROWS
        of = np.searchsorted(lines, rows.line)
        poses = joints.find_joint_poses(rows.shown, rows.shown_w)
        steps = of if rows.first else of[1:]  # the first row is the start, not a step
        count += n_blocks * np.bincount(steps, minlength=len(lines))
        length = path.tool_length[program.contour.segment[rows.shown]]
        here = poses.tip, poses.q, length, poses.angles
        tip, q, of_tool, angles = (
            np.concatenate(pair) for pair in zip(last or [one[:1] for one in here], here, strict=True)
        )
        step = np.diff(tip, axis=0)
        # a change of the tool's length is no motion: both ends of a step in time are solved with the later tool
        changed = np.flatnonzero(np.diff(of_tool))
        solve = program.machine.five_axis.find_nominal_pose
        step[changed] = solve(poses.q[changed], length[changed])[0] - solve(q[changed], length[changed])[0]
        turned = np.remainder(np.diff(angles, axis=0) + np.pi, 2 * np.pi) - np.pi
        moved, turning = np.linalg.norm(step, axis=1) / cycle, np.linalg.norm(turned, axis=1) / cycle
        np.maximum.at(speed, of, moved)
        places = poses.q * limits.factor
        recent = np.concatenate([np.repeat(places[:1], 3, axis=0) if recent is None else recent, places])
        rates = {name: np.diff(recent, k, axis=0)[3 - k :] / cycle**k for name, k in RATES.items()}
        recent = recent[-3:]
        row = limits.measure(program.contour.segment[rows.shown], moved, turning, rates)
        slow = np.flatnonzero(row.feeding & (row.nearest < lost.shape[1]))
        np.add.at(lost, (of[slow], row.nearest[slow]), n_blocks * np.maximum(1.0 - row.share[slow], 0.0))
        last = poses.tip[-1:], poses.q[-1:], length[-1:], poses.angles[-1:]
        table = margins(poses.tip, poses.angles, length)
        least = table.min(axis=1)
        worst_first = np.lexsort((least, of))
        lines_here, first = np.unique(of[worst_first], return_index=True)
        rows_of = worst_first[first]
        lower = least[rows_of] < margin[lines_here]
        margin[lines_here[lower]] = least[rows_of][lower]
        nearest[lines_here[lower]] = table[rows_of].argmin(axis=1)[lower]
    kept = count > 0
    held_by = tuple(limits.names[int(row.argmax())] if row.any() else "" for row in lost[kept])
    return LineFacts(lines[kept], cycle * count[kept], speed[kept], margin[kept], nearest[kept], names, held_by)


def _choose_blocks(plan: Plan) -> Iterator[tuple[int, int]]:
    """First rows of the blocks that facts are made of, and how many blocks each stands for.

    Within one element from stop to stop they are few and evenly spread.
    """
    begins = plan.timeline.first_row
    first = np.arange(0, plan.timeline.n_rows, BLOCK_ROWS)
    item = np.searchsorted(begins, first, side="right") - 1
    section = plan.timeline.section[np.minimum(item, len(begins) - 2)]
    even = (np.diff(plan.program.contour.section_begins)[section] == 1) & (section >= 0)
    even &= plan.profiles.continuous_first[section] < 0
    # the block before is in the same motion, too
    inner = even & (first - BLOCK_ROWS > begins[item]) & (first + BLOCK_ROWS < np.append(begins, 0)[item + 1])
    runs = np.flatnonzero(np.diff(np.where(inner, section, -1), prepend=-2))
    for begin, end in zip(runs.tolist(), [*runs[1:].tolist(), len(first)], strict=True):
        parts = _BLOCKS if inner[begin] else end - begin
        edges = np.unique(np.linspace(begin, end, parts + 1).astype(int)).tolist()
        yield from ((int(first[low]), high - low) for low, high in pairwise(edges))


def describe_feed(plan: Plan, line: int, held_by: str = "") -> str:
    """Whether the feed rate of a line is reached, and what limits it; empty where nothing moves at a feed rate."""
    path = plan.program.path
    feeds = (path.line == line) & (path.feed_time > 0)
    if not feeds.any():
        return ""
    if plan.profiles.reached_segments[feeds].all():
        return "the feed rate is reached"
    by = f", held back by {held_by}" if held_by else ""
    timed = f"; the programmed time is {path.feed_time[feeds].sum():.3f} s" if path.timed[feeds].all() else ""
    return f"the feed rate is not reached{by}{timed}"


def describe_time(plan: Plan, facts: LineFacts, line: int) -> str:
    """``0.532 s; the feed rate is reached; fastest tip 2400 mm/min``."""
    at = facts.find(line)
    if at is None:
        return "less than a control cycle"
    reached = describe_feed(plan, line, facts.held_by[at])
    tip = f"fastest tip {60 * facts.speed[at]:.0f} mm/min"
    return "; ".join(filter(None, (f"{facts.seconds[at]:.3f} s", reached, tip)))
