"""Which branch of the table each segment uses: a shortest path over the whole program.

The tool axis of (A, C) is also that of (-A, C + 180 degrees), and C may be a whole turn elsewhere. A *branch* is one
of these solutions; a segment keeps its branch. Programs with tool axes (I J K) leave it open. Programs with A and C
words name it, and another one is taken only where the named one breaks a limit.

Segments that must share a branch unless the table rewinds form a *span*. Spans end where the tool is vertical (C is
free there) and where it crosses the pole; when no branch keeps the limits on a whole span, also where it begins or
ceases to keep them. The branches of the spans are those with the least cost, in this order: segments beyond a hard
limit, rewinds while the tool feeds, other rewinds, segments off the programmed branch, turns in place under a vertical
tool, rotary travel.
"""

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import release_memory
from verne_post.base.team import ALONE, Team, split_evenly
from verne_post.base.tolerances import POLE_CROSSING, POLE_SINE, TRAVEL_STEP, ZERO_ANGLE
from verne_post.model.branch import AS_PROGRAMMED, Branch
from verne_post.model.nutation import Nutation
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.evaluate import evaluate_pose

#: Turns of C that a free span may be away from where it would continue, where C is unlimited; and as many more as C
#: winds up along the path, up to a bound: the work grows with their square.
TURNS: Final = 2
MORE_TURNS: Final = 8
#: Points of a segment at which a branch is tried; the constraint check looks at the whole segment later.
TRIED: Final = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
#: Segments of no more than this by metric length are tried at their ends alone.
BRIEF_MM: Final = 1.0
#: Segments that are tried at a time.
CHUNK_SEGMENTS: Final = 2048
#: Most spans that end at changes of legality: beyond it a program is hopeless, not long.
MAX_SPANS: Final = 20_000

#: Are poses possible? (segment (m,), u (m,), angles (m, 2)) -> (m,), by reach and by every travel but that of C.
Legal = Callable[[Ints, Array, Array], Mask]


class Change(Struct, frozen=True):
    """A junction before ``segment`` at which the table must change its branch, from one pair of angles to another."""

    segment: int
    before: tuple[float, float]
    after: tuple[float, float]
    feeding: bool

    @property
    def upright(self) -> bool:
        """The tool is vertical: C turns where it stands."""
        return _are_upright(self.before, self.after)


class BranchPlan(Struct, frozen=True, eq=False):
    """What was chosen."""

    #: start, end (n, 2): Nominal angles at both ends of every segment.
    start: Array
    end: Array
    changes: tuple[Change, ...]  #: Where the table must rewind or flip.
    departs: Mask  #: (n,): The segment has A and C words and is not on the branch that they name.
    legal: bool  #: Every segment keeps the hard limits that were tried.


def plan_branches(
    path: ToolPath,
    legal: Legal,
    c_range: tuple[float, float],
    team: Team = ALONE,
    nutation: Nutation | None = None,
    named: Mask | None = None,
    away: float | None = None,
    held: Mask | None = None,
) -> BranchPlan | None:
    """Choose the branch of every segment; None where the programmed one keeps the limits, or nothing is better.

    Parameters
    ----------
    path : ToolPath
        Provisional: free segments have the tilt in [0, pi] (through zero where they cross the pole).
    c_range : tuple of float
        Travel of C, rad; infinite where it is unlimited.
    nutation : Nutation, optional
        Of a nutating pair. Programmed A and C words keep their side: the joints then go linearly, and on the other side
        that is another path of the tool.
    named : ndarray of bool, shape (n,), optional
        Segments whose A and C are words of the program: those that are not free, and those whose words go along a great
        circle.
    away : float, optional
        Angle of C, rad, by which the provisional start is beyond where words before the path have left it.
    held : ndarray of bool, shape (n,), optional
        Segments whose A and C are where tool axes before them have left the table, which is not known yet.
    """
    free, n = path.free, len(path)
    held = np.zeros(n, dtype=bool) if held is None else held
    if not free.any() and _is_legal_throughout(path, legal, c_range, team, nutation):
        return None
    onward = _find_onward(path, held)
    start = path.start.copy()
    start[onward, 3:] = path.end[onward, 3:]
    path = replace(path, start=start)
    possible = tuple(_check_branch(path, legal, Branch(flip, 0), team) for flip in (0, 1))
    if nutation is not None:
        possible = (possible[0], possible[1] & path.free)
    vertical = free & (np.abs(np.sin(path.start[:, 3])) <= POLE_SINE) & (np.abs(np.sin(path.end[:, 3])) <= POLE_SINE)
    named = (~free if named is None else named) & ~held
    choice = _Choice(path, named, onward, _find_states(path, c_range, nutation), possible, c_range, nutation, away)
    breaks = _find_breaks(path, vertical, held)
    plan = _find_plan(choice, _find_spans(breaks, vertical, n))
    if not plan.legal or not all(change.upright for change in plan.changes):
        finer = _split_breaks(choice, breaks)
        if len(finer) <= MAX_SPANS:
            plan = _find_plan(choice, _find_spans(finer, vertical, n))
    if not plan.legal and not free.any():
        return None
    return plan


class _Choice(Struct, frozen=True, eq=False):
    """What branches are chosen from."""

    path: ToolPath  #: n segments on the provisional branch.
    named: Mask  #: (n,): Segments whose A and C are words of the program.
    onward: Mask  #: (n,): Rapids that begin wherever the table stands.
    states: list[Branch]
    #: (n,) each: Whether each segment can be driven without and with the flip, C's travel aside.
    possible: tuple[Mask, ...]
    c_range: tuple[float, float]
    nutation: Nutation | None
    away: float | None  #: Angle of C from where words before the path have left it to the provisional start, rad.

    def find_legal(self, branch: Branch) -> Mask:
        """Segments (n,) that a branch can take, the travel of C included."""
        c0, c1 = (_find_turn(branch.apply_to(pose[:, 3:]), self.nutation) for pose in (self.path.start, self.path.end))
        low, high = self.c_range[0] - ZERO_ANGLE, self.c_range[1] + ZERO_ANGLE
        return self.possible[branch.flip] & (np.minimum(c0, c1) >= low) & (np.maximum(c0, c1) <= high)


def _find_onward(path: ToolPath, held: Mask) -> Mask:
    """Find rapids whose A and C words follow tool axes, or what these hold: they begin wherever the table stands."""
    turns = (np.abs(path.end - path.start)[:, 3:] > ZERO_ANGLE).any(axis=1)
    onward = ~(path.free | held) & (path.feed_time == 0) & turns
    onward[1:] &= (path.free | held)[:-1]
    onward[:1] = False
    return onward


def _find_turn(angles: Array, nutation: Nutation | None) -> Array:
    """The turning joint (...) of nominal angles (..., 2): C, but on a nutating pair."""
    return np.asarray(angles[..., 1] if nutation is None else nutation.find_joints(angles)[..., 1])


def _is_legal_throughout(
    path: ToolPath, legal: Legal, c_range: tuple[float, float], team: Team, nutation: Nutation | None
) -> bool:
    """Whether every segment can be driven as it is programmed."""
    low, high = c_range

    def is_legal(part: tuple[int, int]) -> bool:
        release_memory()
        rows = np.arange(*part)
        c = _find_turn(np.stack([path.start[rows, 3:], path.end[rows, 3:]]), nutation)
        return bool(c.min() >= low and c.max() <= high and _check_segments(path, legal, AS_PROGRAMMED, rows).all())

    return all(team.map(is_legal, split_evenly(len(path), CHUNK_SEGMENTS)))


def _check_branch(path: ToolPath, legal: Legal, branch: Branch, team: Team) -> Mask:
    """Whether each segment can be driven on a branch, C's travel aside."""

    def try_branch(part: tuple[int, int]) -> Mask:
        return _check_segments(path, legal, branch, np.arange(*part))

    return np.concatenate([np.empty(0, dtype=bool), *team.map(try_branch, split_evenly(len(path), CHUNK_SEGMENTS))])


def _check_segments(path: ToolPath, legal: Legal, branch: Branch, rows: Ints) -> Mask:
    # the length of splines counts no rotation
    brief, good = (path.length[rows] <= BRIEF_MM) & (path.spline[rows] < 0), np.empty(len(rows), dtype=bool)
    for some, tried in ((np.flatnonzero(brief), TRIED[[0, -1]]), (np.flatnonzero(~brief), TRIED)):
        segment, u = np.repeat(rows[some], len(tried)), np.tile(tried, len(some))
        _tip, angles = evaluate_pose(path, segment, u)
        good[some] = legal(segment, u, branch.apply_to(angles)).reshape(len(some), len(tried)).all(axis=1)
    return good


def _find_states(path: ToolPath, c_range: tuple[float, float], nutation: Nutation | None) -> list[Branch]:
    """Find the branches that can matter: all whose C overlaps its travel, or a few turns where it is unlimited."""
    low, high = c_range
    both = np.concatenate([path.start[:, 3:], path.end[:, 3:]])
    branches, c = [], both[:, 1]
    free_turns = TURNS + min(int(np.ceil(np.ptp(c) / (2 * np.pi))), MORE_TURNS)
    for flip in (0, 1):
        if np.isfinite(low) or np.isfinite(high):
            if nutation is not None:
                c = _find_turn(both * [1 - 2 * flip, 1], nutation)
            shifted_low, shifted_high = c.min() + flip * np.pi, c.max() + flip * np.pi
            first = int(np.ceil((low - shifted_high) / (2 * np.pi) - ZERO_ANGLE)) if np.isfinite(low) else -free_turns
            last = int(np.floor((high - shifted_low) / (2 * np.pi) + ZERO_ANGLE)) if np.isfinite(high) else free_turns
            turns: Iterable[int] = range(min(first, 0), max(last, 0) + 1)
        else:
            turns = range(-free_turns, free_turns + 1) if path.free.any() else (0,)
        branches += [Branch(flip, turn) for turn in turns]
    return sorted(branches, key=lambda branch: (branch.flip, abs(branch.turns), branch.turns))


def _find_breaks(path: ToolPath, vertical: Mask, held: Mask) -> set[int]:
    """Find segments before which a span begins: at vertical tools, at the pole, between tool axes and words."""
    apart = np.abs(path.start[1:, 3:] - path.end[:-1, 3:]).max(axis=1, initial=0.0) > ZERO_ANGLE
    kind = (path.free[1:] != path.free[:-1]) | (held[1:] != held[:-1])
    upright = path.free[1:] & path.free[:-1] & (np.abs(np.sin(path.start[1:, 3])) <= POLE_SINE)
    at = np.flatnonzero(apart | kind | upright | (vertical[1:] != vertical[:-1])) + 1
    return {0, *at.tolist()}


def _split_breaks(choice: _Choice, breaks: set[int]) -> set[int]:
    """Add breaks where the legality of a branch changes, and on both sides of rapids."""
    finer = set(breaks)
    for branch in choice.states:
        good = choice.find_legal(branch)
        finer.update((np.flatnonzero(good[1:] != good[:-1]) + 1).tolist())
    rapid = choice.path.feed_time == 0
    finer.update((np.flatnonzero(rapid[1:] | rapid[:-1]) + 1).tolist())
    return finer


def _find_spans(breaks: set[int], vertical: Mask, n: int) -> list[tuple[int, int]]:
    """Find (first, last) of the spans, vertical stretches left out: they join spans, and are none."""
    begins = [*sorted(breaks), n]
    pairs = [(a, b) for a, b in pairwise(begins) if a < b]
    spans = [(a, b) for a, b in pairs if not vertical[a]]
    return spans or [(0, n)]


def _find_plan(choice: _Choice, spans: list[tuple[int, int]]) -> BranchPlan:
    """Find the best branch of every span (dynamic programming), and the angles that follow."""
    path, states = choice.path, choice.states
    firsts = np.array([first for first, _last in spans])
    lasts = np.array([last for _first, last in spans])
    words = np.append(0, np.cumsum(choice.named))
    illegal, departures = [], []
    for branch in states:
        bad = np.append(0, np.cumsum(~choice.find_legal(branch)))
        illegal.append(bad[lasts] - bad[firsts])
        departures.append(0 * firsts if branch == AS_PROGRAMMED else words[lasts] - words[firsts])
    begin = np.stack([branch.apply_to(path.start[firsts, 3:]) for branch in states], axis=1)
    finish = np.stack([branch.apply_to(path.end[lasts - 1, 3:]) for branch in states], axis=1)
    feeding = path.feed_time > 0
    ways = _find_ways(choice, begin[0, :, 1])
    costs: list[list[_Cost]] = [
        [(int(illegal[s][k]), 0, 0, int(departures[s][k]), 0, *((0, 0) if k else way)) for s, way in enumerate(ways)]
        for k in range(len(firsts))
    ]
    best = costs[0]
    came: list[list[int]] = []
    for k in range(1, len(firsts)):
        # vertical segments in between, or a rapid that begins wherever the table stands
        bridged = bool(lasts[k - 1] < firsts[k] or choice.onward[firsts[k]])
        fed = bool(feeding[lasts[k - 1] - 1] and feeding[firsts[k]])
        here, back = [], []
        for s in range(len(states)):
            step = [
                _add(best[t], _compute_passage_cost(finish[k - 1, t], begin[k, s], bridged=bridged, fed=fed))
                for t in range(len(states))
            ]
            t = min(range(len(states)), key=lambda t: step[t])
            here.append(_add(step[t], costs[k][s]))
            back.append(t)
        best = here
        came.append(back)
    chosen = [min(range(len(states)), key=lambda s: best[s])]
    total = best[chosen[0]]
    for back in reversed(came):
        chosen.append(back[chosen[-1]])
    chosen.reverse()
    return _lay_out(choice, spans, [states[s] for s in chosen], legal=total[0] == 0)


def _find_ways(choice: _Choice, begin: Array) -> list[tuple[int, int]]:
    """Travel of C to where each branch begins (n,), from where words have left the table; and the branch's rank.

    Where no word has, a branch begins where the machine is put before the start: whole turns count. Of equal travel
    the nearest branch is the first.
    """
    # a vertical beginning already stands as it will leave
    away = np.abs((choice.away or 0.0) + begin - choice.path.start[0, 4])
    nearest = np.rint(away / TRAVEL_STEP).astype(int)
    if choice.away is None:
        away = 2 * np.pi * np.ceil(away / (2 * np.pi) - 0.5 - ZERO_ANGLE)
    ranks = np.argsort(np.argsort(nearest, kind="stable"), kind="stable")
    return list(zip(np.rint(away / TRAVEL_STEP).astype(int).tolist(), ranks.tolist(), strict=True))


#: Numbers in order of weight: segments beyond a limit, rewinds while the tool feeds, other rewinds, segments off the
#: programmed branch, turns of C in place under a vertical tool, rotary travel. Where all are equal, the last one keeps
#: the first segment near its provisional angles.
_Cost = tuple[int, int, int, int, int, int, int]


def _add(a: _Cost, b: _Cost) -> _Cost:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5], a[6] + b[6])


def _compute_passage_cost(before: Array, after: Array, *, bridged: bool, fed: bool) -> _Cost:
    """Cost of going from one pair of angles to another between spans."""
    tilt, turn = abs(float(after[0] - before[0])), abs(float(after[1] - before[1]))
    travel = round((tilt + turn) / TRAVEL_STEP)
    if _meets(before, after):
        return (0, 0, 0, 0, 0, 0, 0)
    if bridged:
        return (0, 0, 0, 0, 0, travel, 0)
    if _are_upright(before, after) and tilt <= ZERO_ANGLE:
        return (0, 0, 0, 0, 1, travel, 0)
    return (0, int(fed), 1, 0, 0, travel, 0)


def _meets(before: Array, after: Array) -> bool:
    """One pair of angles goes on where the other ends; under a vertical tool within what the axis may be off later."""
    away = np.abs(after - before)
    return bool(away[0] <= ZERO_ANGLE and away[1] <= (POLE_CROSSING if _are_upright(before, after) else ZERO_ANGLE))


def _are_upright(before: Array | tuple[float, float], after: Array | tuple[float, float]) -> bool:
    """Whether the tool is vertical at both pairs of angles."""
    return bool(max(abs(np.sin(before[0])), abs(np.sin(after[0]))) <= POLE_SINE)


def _lay_out(choice: _Choice, spans: list[tuple[int, int]], chosen: list[Branch], *, legal: bool) -> BranchPlan:
    """Find the angles of every segment on the chosen branches; vertical stretches turn in between."""
    path, onward = choice.path, choice.onward
    n = len(path)
    start, end = path.start[:, 3:].copy(), path.end[:, 3:].copy()
    departs = np.zeros(n, dtype=bool)
    for (first, last), branch in zip(spans, chosen, strict=True):
        start[first:last], end[first:last] = branch.apply_to(start[first:last]), branch.apply_to(end[first:last])
        departs[first:last] = choice.named[first:last] & (branch != AS_PROGRAMMED)
    changes = []
    if (leave := spans[0][0]) > 0:  # a vertical beginning already stands as it will leave
        if choice.named[0] and (path.feed_time[:leave] == 0).any():  # but words hold where the table stands before
            if not onward[leave]:
                _turn_between(path, start, end, 0, leave, float(start[0, 1]), float(start[leave, 1]))
        elif not onward[leave]:
            start[:leave, 1] = end[:leave, 1] = start[leave, 1]
        start[leave] = end[leave - 1]
    for (_first, last), (following, _end) in pairwise(spans):
        before, after = end[last - 1], start[following]
        if last < following:
            target = before if onward[following] else after  # such a rapid turns C itself
            _turn_between(path, start, end, last, following, float(before[1]), float(target[1]))
        if onward[following]:
            start[following] = end[following - 1]
        elif last < following:
            continue
        elif not _meets(before, after):
            fed = bool(path.feed_time[last - 1] > 0 and path.feed_time[following] > 0)
            pairs = tuple((float(pair[0]), float(pair[1])) for pair in (before, after))
            changes.append(Change(following, pairs[0], pairs[1], fed))
        else:
            start[following] = before  # to the last bit, so that no gap opens
    tail = spans[-1][1]
    if tail < n:
        start[tail:, 1] = end[tail:, 1] = end[tail - 1, 1]
    return BranchPlan(start, end, tuple(changes), departs, legal)


def _turn_between(path: ToolPath, start: Array, end: Array, first: int, last: int, begin: float, finish: float) -> None:
    """Turn C under a vertical tool: over the rapids of the stretch, or over all of it where there is none."""
    rows = np.arange(first, last)
    rapid = path.feed_time[rows] == 0
    weight = path.length[rows] * (rapid if rapid.any() else 1.0)
    share = np.append(0.0, np.cumsum(weight)) / weight.sum()
    c = begin + share * (finish - begin)
    c[-1] = finish
    start[rows, 1], end[rows, 1] = c[:-1], c[1:]
