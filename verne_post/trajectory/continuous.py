"""Time profiles of runs that flow: near the time optimum, inside every limit on the differences of the rows.

A first profile (:mod:`initial_profile`) comes from the second-order scan. It need not be legal: the interior point method
re-times it in a few passes, coarse to fine, each on the profile of the pass before. Only s(t) changes, so the tool
stays on the path whatever happens here. Rows that are still beyond a limit are mended one stretch at a time.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import Growing, release_memory
from verne_post.model.machine import Limits
from verne_post.trajectory import reachability, tuning
from verne_post.trajectory.initial_profile import Solver, initial_profile
from verne_post.trajectory.interior_point import Problem, solve
from verne_post.trajectory.override import FeedOverride
from verne_post.trajectory.repair import at_rest, exceeding, excess, repair_or_slow_down, repair_rows
from verne_post.trajectory.section_path import Section, joints_at
from verne_post.trajectory.spline_profile import Profile, Times, positions
from verne_post.trajectory.tuning import Effort, PassSettings

Array = NDArray[np.float64]

#: At the speed that was planned.
AS_PLANNED: Final = FeedOverride()


@dataclass(frozen=True, eq=False)
class ContinuousProfile:
    """The profile of one run.

    Attributes
    ----------
    s : ndarray, shape (n,)
        Path parameter at t = 0, cycle, 2 cycle, ..., from rest to rest; the first is 0, the last the run's length.
    bound : float
        Time of the second-order optimum of the same run, s: no profile inside the limits is faster, but for what the feed and
        the limits allow between the points of the grid (0.2 % at most was seen, with a slow feed over many short segments).
    """

    s: Array
    bound: float


def plan_continuous(
    section: Section, limits: Limits, cycle: float, effort: Effort = tuning.NORMAL, solver: Solver = reachability.solve,
    played: FeedOverride = AS_PLANNED, begin: float = 0.0,
) -> ContinuousProfile:  # fmt: skip
    """Plan a run from rest to rest.

    Parameters
    ----------
    section : Run
    limits : Limits
    cycle : float
        Control cycle, s.
    effort : Effort
        How finely to plan.
    solver : callable
        Of the second-order problem.
    played : FeedOverride
        How fast the planned profile is played.
    begin : float
        When the run begins in the file, s.

    Raises
    ------
    ValueError
        The run, a limit or the cycle is not a finite positive number, or the joints jump along the run.
    """
    positive = np.concatenate([limits.velocity, limits.acceleration, limits.jerk, [cycle]])
    if not (np.isfinite(positive).all() and (positive > 0).all()):
        raise ValueError("velocity, acceleration, jerk and cycle must be finite and above 0")
    profile, unit, bound = initial_profile(section, limits, max(tuning.TIME_UNIT, cycle), solver)
    for step in effort.passes:
        profile = rebuild_profile(profile, retime(section, profile, limits, cycle, unit, step, step.shares), unit)
    last = effort.jerk_bound if profile.duration > tuning.JERK_BOUND_RATIO * bound else effort.last
    times = retime(section, profile, limits, cycle, unit, last, last.shares)

    def rows(slower: float, played: FeedOverride = played) -> Array:
        return _rows(section, profile, times, limits, cycle, slower, played, begin)

    for left in reversed(range(effort.repeats + 1)):
        z = at_rest(rows(1.0, AS_PLANNED))
        over = exceeding(excess(section, z, limits, cycle))
        if not left or tuning.ROWS_PER_FAR_ROW * np.count_nonzero(over[1] > tuning.FAR_RATIO) <= len(z):
            found = repair_rows(section, z, over, limits, cycle, unit)
            if found is not None and played == AS_PLANNED:
                return ContinuousProfile(found, bound)
            if found is not None or (not left and effort is tuning.QUALITY):
                break
            if not left:  # a better profile costs less than to mend this one, and is faster by far
                return plan_continuous(section, limits, cycle, tuning.QUALITY, solver, played, begin)
        profile = rebuild_profile(profile, times, unit)
        times = retime(section, profile, limits, cycle, unit, replace(last, tightest_rows=tuning.ALL_ROWS), last.shares)
    return ContinuousProfile(repair_or_slow_down(section, rows, limits, cycle, unit), bound)


def rebuild_profile(profile: Profile, times: Times, unit: float) -> Profile:
    """A profile that has been re-timed, as a profile of its own."""
    count = int(np.ceil(times.total / unit)) + 1
    samples = Growing(float)
    for part in positions(profile, times, count, lambda number: np.minimum(unit * number, times.total)):
        samples.extend(part)
    return Profile.through_samples(samples.column(), unit)


# --- one pass ------------------------------------------------------------------------------------


def retime(
    section: Section,
    profile: Profile,
    limits: Limits,
    cycle: float,
    unit: float,
    settings: PassSettings,
    shares: tuple[float, float, float],
) -> Times:
    """One pass of the interior point method over the whole run, window by window."""
    knot = settings.knot_units * unit
    n = int(np.ceil(profile.duration / knot * (1 - 1e-12)))
    settled = Growing(float)
    recent = np.empty(0)  # coefficients behind those: of the window before, and of this one
    begin, careful = 0, -1
    while begin < n:
        release_memory()
        end = min(begin + settings.window_knots + settings.look_ahead_knots, n)
        if n - end < settings.look_ahead_knots:
            end = n
        recent = np.append(recent, np.ones(max(end + 3 - settled.count - len(recent), 0)))
        coefficients = recent[begin - settled.count : end + 3 - settled.count]
        fixed = coefficients[:3].copy() if begin else np.empty(0)
        slow = None if end == n else tuning.CRAWLING_X if begin <= careful else settings.window_end_x
        problem = _problem(section, profile, limits, cycle, unit, settings, shares, begin, end, fixed, slow)
        start = _start(coefficients, settings, begin > 0, slow)
        found = solve(problem, start, centre=settings.start_gap, gap=settings.final_gap, iterations=settings.iterations)
        if begin > careful and begin and not found.legal:
            # the window before may have been too fast at its end: again, this time down to a crawl
            careful = begin
            begin -= settings.window_knots
            continue
        if _crawls(found.coefficients[: settings.window_knots + 3]):
            coefficients[len(fixed) :] = 1.0  # the profile as it is needs less mending than one that all but stands
        else:
            coefficients[:] = found.coefficients
        done = begin - settled.count
        settled.extend(recent[:done].copy())
        recent = recent[done:]
        begin = end if end == n else begin + settings.window_knots
    settled.extend(recent)
    return Times.of_coefficients(settled.column(), knot)


def _crawls(coefficients: Array) -> bool:
    """A solution that has lost its way slows down far more than re-timing a profile near the optimum ever needs."""
    return Times.of_coefficients(coefficients, 1.0).total > tuning.STRAYED * (len(coefficients) - 3)


def _start(known: Array, settings: PassSettings, goes_on: bool, slow: float | None) -> Array:
    """Coefficients that a window starts from; where it goes on, ``known`` begins with those of the window before."""
    start = np.full(len(known), tuning.START_X)
    ramp = min(round(tuning.START_RAMP / settings.knot_units), settings.look_ahead_knots // 2)
    if goes_on:  # less and less of them: the window before slows down
        seen = settings.look_ahead_knots - ramp
        start[:seen] += (known[:seen] - tuning.START_X) * _falling(seen)
    if slow is not None:  # as the solution will, slow down over the end of the window
        start[-ramp:] *= slow ** (1.0 - _falling(ramp))
    return start


def _falling(n: int) -> Array:
    """From 1 to 0 in n values, even at both ends."""
    f = np.linspace(0.0, 1.0, n)
    return np.asarray(1.0 - f * f * (3.0 - 2.0 * f))


def _problem(
    section: Section, profile: Profile, limits: Limits, cycle: float, unit: float, settings: PassSettings,
    shares: tuple[float, float, float], begin: int, end: int, fixed: Array, slow: float | None,
) -> Problem:  # fmt: skip
    """Limits at the points of a window, from differences of rows a cycle apart: the acceptance metric itself."""
    delta = max(cycle, tuning.SHORTEST_DIFFERENCE * unit)
    n, k = end - begin, settings.points_per_knot
    knot = settings.knot_units * unit
    spacing = knot / k
    points = n * k
    apart = round(delta / spacing)
    if apart >= 1 and abs(apart * spacing - delta) < 1e-9 * delta:  # points share their samples
        first = begin * knot + 0.5 * spacing - 1.5 * delta
        at = first + spacing * np.arange(points + 3.0 * apart)
        s = profile.s(at)
        q = np.ascontiguousarray(joints_at(section, s).T)
        speed = np.asarray(section.speed(s), dtype=float)
        samples = [q[:, m * apart : m * apart + points] for m in range(4)]
        low, high = slice(apart, apart + points), slice(2 * apart, 2 * apart + points)
        slope, speed = s[high] - s[low], np.minimum(speed[low], speed[high])
    else:
        at = (begin + (np.arange(points) + 0.5) / k) * knot
        s = profile.s(at + delta * np.array([[-1.5], [-0.5], [0.5], [1.5]])).reshape(-1)
        q = np.ascontiguousarray(joints_at(section, s).T)
        speed = np.asarray(section.speed(s[points : 3 * points]), dtype=float)
        samples = [q[:, m * points : (m + 1) * points] for m in range(4)]
        slope = s[2 * points : 3 * points] - s[points : 2 * points]
        speed = np.minimum(speed[:points], speed[points:])
    a, b, c, d = samples
    q1 = _by_phase((c - b) / delta, k)
    q2 = _by_phase((d - c - b + a) / (2 * delta**2), k)
    q3 = _by_phase((d - 3 * (c - b) - a) / delta**3, k)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_feed = _by_phase((shares[0] * delta * speed / slope)[None], k)[0] ** 2
        by_speed = 1.0 / ((q1 / (shares[0] * limits.velocity[:, None])) ** 2).max(axis=0)
    cap = np.minimum(np.where(np.isnan(by_feed), np.inf, by_feed), by_speed)
    cap = np.clip(cap, 2 * tuning.SMALLEST_X, settings.largest_x)
    # a window that goes on where another has used every limit up needs some room to do so
    by_interval = np.ones(n)
    if len(fixed):
        by_interval[: tuning.HANDOVER_KNOTS] -= np.linspace(tuning.HANDOVER_EXCESS, 0.0, tuning.HANDOVER_KNOTS)[:n]
    room = np.tile(by_interval, k)
    cap /= room
    acceleration = shares[1] * limits.acceleration[:, None] / room
    jerk = shares[2] * limits.jerk[:, None] / room
    virtual = np.zeros((1, points))
    q1a = np.concatenate([0.5 * q1 / acceleration, virtual + 0.5 * unit / tuning.VIRTUAL_ACCELERATION])
    q2a = np.concatenate([q2 / acceleration, virtual])
    q1j = np.concatenate([0.5 * q1 / jerk, virtual + 0.5 * unit**2 / tuning.VIRTUAL_JERK])
    q2j = np.concatenate([1.5 * q2 / jerk, virtual])
    q3j = np.concatenate([q3 / jerk, virtual])

    both: list[tuple[Array, ...]] = [(q2a, q1a), (q3j, q2j, q1j)]
    acceleration_rows, jerk_rows = (
        _signed(rows, count or len(rows[0])) for rows, count in zip(both, settings.tightest_rows, strict=True)
    )
    return Problem(knot, (np.arange(k) + 0.5) / k, cap, acceleration_rows, jerk_rows, fixed, slow)


def _signed(rows: tuple[Array, ...], count: int) -> tuple[Array, ...]:
    """Both signs of rows (m, points); of each side the ``count`` that can become tight first.

    A side are the rows that bound the highest derivative from above, or from below. Tight first are those near
    their limit now, or soon when that derivative changes.
    """
    above = np.where(rows[-1] < 0, -1.0, 1.0)
    upper = tuple(row * above for row in rows)
    if count >= len(above):
        return tuple(np.concatenate([row, -row]) for row in upper)
    reach = upper[-1] / upper[-1].max(axis=0)
    sides = []
    points = np.arange(reach.shape[1])
    for sign in (1.0, -1.0):
        chosen = largest(sign * upper[0] + reach, count) * len(points) + points
        sides.append([sign * row.take(chosen) for row in upper])
    return tuple(np.concatenate(pair) for pair in zip(*sides, strict=True))


def largest(scores: Array, count: int) -> NDArray[np.int64]:
    """Rows (count, points) in which the largest of finite scores (m, points) stand, the largest first.

    Every score carries the number of its row in its last bits, so that ordering the scores orders the rows: scores that are
    equal but for these bits are as good as equal.
    """
    mask = (1 << (len(scores) - 1).bit_length()) - 1
    keys = scores.copy()
    bits = keys.view(np.int64)
    bits &= ~mask
    bits |= np.arange(len(scores))[:, None]
    found = np.full((count, scores.shape[1]), -np.inf)
    for key in keys:
        for place in found:
            lower = np.minimum(place, key)
            np.maximum(place, key, out=place)
            key = lower  # what gives way may be larger than the next
    return found.view(np.int64) & mask


def _by_phase(a: Array, k: int) -> Array:
    """Points in order of time (m, n k) -> by phase, then by interval."""
    return np.ascontiguousarray(a.reshape(len(a), -1, k).transpose(0, 2, 1)).reshape(len(a), -1)


def _rows(
    section: Section,
    profile: Profile,
    times: Times,
    limits: Limits,
    cycle: float,
    slower: float,
    played: FeedOverride,
    begin: float,
) -> Array:
    """Rows of the profile as it is played, stretched by ``slower`` to a whole number of cycles; resting ends are left out."""
    cycles = played.cycles(times.total * slower, begin, cycle)

    def instants(row: Array) -> Array:
        done = played.shares(row, np.full(len(row), float(cycles)), np.full(len(row), begin), cycle)
        return times.total * done

    every, farthest = Growing(float), 0.0
    for s in positions(profile, times, cycles + 1, instants):
        s = np.maximum.accumulate(np.append(farthest, np.clip(s, 0.0, section.length)))[1:]
        every.extend(s)
        farthest = float(s[-1])
    s = every.column()
    first = int(np.searchsorted(s, tuning.REST_SHARE * section.length, side="right")) - 1
    last = int(np.searchsorted(s, (1 - tuning.REST_SHARE) * section.length, side="left"))
    s = s[max(first, 0) : last + 1]
    at_start, at_end = _creeping(section, s, limits, cycle)
    rows = Growing(float)
    rows.extend(np.zeros(1))
    rows.copy(s[1 + at_start : len(s) - 1 - at_end])
    rows.extend(np.array([section.length]))
    return rows.column()


def _creeping(section: Section, s: Array, limits: Limits, cycle: float) -> tuple[int, int]:
    """How many rows behind the first and before the last a joint hardly moves over; the profile creeps there, and need not."""
    n = len(s)
    count = min(tuning.CREEPING_ROWS, n // 4)
    if count < 2:
        return 0, 0
    reach = np.minimum(limits.jerk * cycle**3, np.minimum(limits.acceleration * cycle**2, limits.velocity * cycle))
    tail = np.concatenate([[0.0], s[1:count], s[n - count : -1], [section.length]])
    moved = joints_at(section, tail)
    by_feed = cycle * np.asarray(section.speed(tail), dtype=float)

    def creeping(rows: slice, end: int) -> int:
        strain = (np.abs(moved[rows] - moved[end]) / reach).max(axis=1)
        strain = np.maximum(strain, np.abs(tail[rows] - tail[end]) / by_feed[rows])
        return int(np.count_nonzero(strain < tuning.CREEPING_MOTION))

    at_start, at_end = creeping(slice(1, count), 0), creeping(slice(count, -1), -1)
    # the step that takes their place must be one that the rows allow
    while at_start and _too_far(section, np.array([0.0, 0.0, s[1 + at_start]]), cycle):
        at_start //= 2
    while at_end and _too_far(section, np.append(s[[-3 - at_end, -2 - at_end]], section.length), cycle):
        at_end //= 2
    return at_start, at_end


def _too_far(section: Section, s: Array, cycle: float) -> bool:
    """Whether the last step between rows s (n,) hides the path, or where the feed changes along it is far beyond the feed."""
    cap = np.asarray(section.speed(np.array([s[-2], 0.5 * (s[-2] + s[-1]), s[-1]])), dtype=float).min()
    return bool(section.hidden(s)[-1] > 1.0 or s[-1] - s[-2] > (1.0 + 2 * tuning.CREEPING_MOTION) * cycle * cap)
