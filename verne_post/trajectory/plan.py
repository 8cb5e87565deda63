"""The motion profiles of a contour: stop-to-stop profiles, and continuous ones where corners are rounded."""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import groupby
from operator import itemgetter
from typing import Final

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, find_used
from verne_post.base.columns import Growing, iterate_blocks, release_memory, sum_running
from verne_post.base.team import ALONE, Team, split_evenly
from verne_post.base.tolerances import WHOLE_CYCLE
from verne_post.model.contour import Contour
from verne_post.model.findings import SolverError, make_finding
from verne_post.model.machine import Limits
from verne_post.model.protocols import JointFunctions
from verne_post.trajectory import tuning
from verne_post.trajectory.follow_feed import follow_feed
from verne_post.trajectory.override import AS_PLANNED, FeedOverride
from verne_post.trajectory.row_limits import REST_ROWS
from verne_post.trajectory.section_path import SectionTask
from verne_post.trajectory.shaper import UNSHAPED
from verne_post.trajectory.standstills import Standstills
from verne_post.trajectory.stop_to_stop import StopToStopProfiles, plan_sections
from verne_post.trajectory.visible import Turning, limit_visible_speed, measure_hidden

#: From so many elements on, several processes plan a section together; each has its own sections up to there.
LONG_SECTION: Final = 3000


class MotionProfiles(Struct, frozen=True, eq=False):
    """The profile of every section."""

    profiles: StopToStopProfiles  #: From stop to stop; what it says of continuous sections is not used.
    #: (n_sections,): Where a continuous section's rows begin in ``continuous_s``, -1 for the others.
    continuous_first: NDArray[np.int64]
    #: (n_sections,): Control cycles that each section lasts, at the speed at which it is executed.
    cycles: NDArray[np.int64]
    continuous_s: Array  #: (n,): Path parameter of each row of the continuous sections, mm.
    reached_segments: NDArray[np.bool_]  #: (n_segments,): The segment's feed is reached somewhere on it.
    second_order_bound_s: float  #: Sum of the second-order bounds of the continuous sections, s.
    toppra_bound_s: float | None  #: The same by the other solver, where both were asked.


class PlanningOptions(Struct, frozen=True):
    """How to plan."""

    cycle: float  #: Control cycle, s.
    #: {"reachability", "toppra", "both"}: Of the second-order problem; "both" plans with the reachability passes
    #: and lets toppra give the bound as well.
    solver: str = "reachability"
    #: Plan finely and without margin: practically the third-order optimum, at many times the cost.
    quality: bool = False
    playback: FeedOverride = field(default_factory=FeedOverride)  #: How fast what is planned is executed.
    #: (2 h + 1,): Of the input shaper that the rows are convolved with; every section has h cycles of rest before
    #: and after it.
    weights: Array = field(default_factory=lambda: UNSHAPED)
    team: Team = ALONE  #: The processes that plan.

    @property
    def rest(self) -> int:
        """Cycles of rest before and after each section: the shaper's reach."""
        return len(self.weights) // 2


class ContourSection:
    """One section of a contour as a function of its path parameter; implements ``section_path.Section``.

    Parameters
    ----------
    joints : JointFunctions
    first, last : int
        Elements of the section, ``last`` excluded.
    cycle : float
        Control cycle, s.
    """

    def __init__(self, joints: JointFunctions, first: int, last: int, cycle: float) -> None:
        self.joints, self.first, self.cycle = joints, first, cycle
        contour = joints.contour
        self.breaks = sum_running(contour.length[first:last])
        timed = contour.path.timed[contour.segment[first:last]]
        #: Seconds up to each break that elements ask for whose feed rate is a time: a step may pass some of them whole.
        self.asked = None
        if timed.any():
            pace = contour.find_pace(slice(first, last))
            self.asked = sum_running(np.where(timed, pace * contour.length[first:last], 0.0))
        path = contour.path
        curves = len(path.arcs.sweep) + len(path.splines) + len(path.turns.first)
        self.turning = Turning(contour, first, last) if curves else None

    @property
    def length(self) -> float:
        """Length by s, mm."""
        return float(self.breaks[-1])

    def locate(self, s: Array) -> tuple[Ints, Array]:
        """Element and w of path parameters s (n,)."""
        local = np.searchsorted(self.breaks[1:-1], s, side="right")
        low = self.breaks.take(local)
        w = (s - low) / (self.breaks.take(local + 1) - low)
        return self.first + local, np.clip(w, 0.0, 1.0)

    def find_joints(self, s: Array) -> Array:
        """Joints (n, n_joints) at s (n,)."""
        return self.joints.find_joints(*self.locate(s))

    def find_speed(self, s: Array) -> Array:
        """Largest ds/dt (n,) at s (n,), mm/s: by the feed, and so that the rows show how arcs turn."""
        element, w = self.locate(s)
        cap = self.joints.find_speed_cap(element, w)
        if self.turning is None:
            return cap
        return np.minimum(cap, limit_visible_speed(self.joints.contour, element, w, self.cycle))

    def measure_hidden(self, s: Array) -> Array:
        """How far steps (n - 1,) between rows s (n,) are beyond what is allowed, as ratios.

        The ratio is the largest of three: of the distance of the path from the step, of the turn of an arc, and of the
        speed in blocks whose feed rate is a time.

        The step before the first is taken to have been as long as need be.
        """
        element, w = self.locate(s)
        return self._find_hidden(s, element, w, self.joints.pose(self.joints.contour, element, w))

    def find_joints_and_hidden(self, s: Array) -> tuple[Array, Array]:
        """What :meth:`find_joints` and :meth:`measure_hidden` say of rows s (n,), of poses evaluated once."""
        element, w = self.locate(s)
        rows = self.joints.find_joint_poses(element, w)
        return rows.q, self._find_hidden(s, element, w, (rows.tip, rows.angles))

    def _find_hidden(self, s: Array, element: Ints, w: Array, poses: tuple[Array, Array]) -> Array:
        turned = None if self.turning is None else self.turning.measure_turn(element, w)
        found = measure_hidden(self._find_pose, self.joints.contour, s, element, poses, turned)
        if self.asked is not None:
            passed = np.flatnonzero(
                np.diff(element) > 1
            )  # the feed cap at both ends and in the middle shows any others
            asked = np.interp(s[passed + 1], self.breaks, self.asked) - np.interp(s[passed], self.breaks, self.asked)
            found[passed] = np.maximum(found[passed], asked / self.cycle)
        return found

    def _find_pose(self, s: Array) -> tuple[Array, Array]:
        """Tip (n, 3) and nominal angles (n, 2) at s (n,)."""
        return self.joints.pose(self.joints.contour, *self.locate(s))


def plan_contour(
    joints: JointFunctions,
    first: Array,
    second: Array,
    third: Array,
    limits: Limits,
    planning: PlanningOptions,
    progress: Callable[[int], None] | None = None,
    slower: Array | None = None,
) -> MotionProfiles:
    """Plan every section of a contour.

    Parameters
    ----------
    first, second, third : ndarray, shape (n, n_joints)
        Largest derivatives of the joints by w over the elements of sections from stop to stop, one after the other.
    progress : callable, optional
        Called with the number of elements that have been planned.
    slower : ndarray, shape (n_sections,), optional
        By which factors sections from stop to stop last longer than they need.

    Raises
    ------
    SolverError
        Naming the source line of the first section without a profile.
    """
    contour = joints.contour
    continuous = contour.continuous
    profiles = plan_sections(
        contour, first, second, third, limits.bound_jerk(planning.cycle), ~continuous, planning.cycle
    )
    continuous |= _find_uneven(joints, limits, planning, profiles)
    if slower is not None and (slower > 1.0).any():
        profiles = profiles.slow_down(slower)
    planner = _Planner(joints, limits, planning, profiles, continuous)
    for section, planned in planner.plan_in_time() if planning.playback.ramp else planner.plan_each():
        planner.keep(section, planned)
        if progress is not None:
            progress(int(planner.begins[section + 1]))
    return planner.plan_profiles()


def _find_uneven(
    joints: JointFunctions, limits: Limits, planning: PlanningOptions, profiles: StopToStopProfiles
) -> NDArray[np.bool_]:
    """Sections (n_sections,) whose profile from stop to stop takes far longer than need be.

    Its limits are those of the worst place of the section. Near the pole of the table, where C turns far over a few
    micrometers, that place would set the speed of all of it.
    """
    contour, begins = joints.contour, joints.contour.section_begins
    uneven = np.zeros(len(profiles.total), dtype=bool)
    for section in np.flatnonzero(profiles.total > tuning.UNEVEN_S).tolist():
        first, last = int(begins[section]), int(begins[section + 1])
        longest = tuning.UNEVEN_RATIO * contour.length[first:last] @ contour.find_pace(slice(first, last))
        if profiles.total[section] > longest:
            from verne_post.trajectory.initial_profile import bound_second_order_time

            path = ContourSection(joints, first, last, planning.cycle)
            bound = bound_second_order_time(path, limits, _choose_solver(planning.solver))
            uneven[section] = profiles.total[section] > tuning.UNEVEN_RATIO * bound
    return uneven


class _SectionProfile(Struct, frozen=True, eq=False):
    """Rows s (n,) of a continuous section, its second-order bounds (s), and the segments (m,) that reach their feed."""

    s: Array
    second_order_bound_s: float
    toppra_bound_s: float
    reached_segments: Ints


class _Planner:
    """Takes the sections of a contour in order: continuous ones are planned, the others have stop-to-stop profiles."""

    def __init__(
        self,
        joints: JointFunctions,
        limits: Limits,
        planning: PlanningOptions,
        profiles: StopToStopProfiles,
        continuous: NDArray[np.bool_],
    ) -> None:
        contour = joints.contour
        self.joints, self.limits, self.planning, self.profiles = joints, limits, planning, profiles
        self.begins, self.continuous = contour.section_begins, continuous
        self.first_row = np.full(contour.n_sections, -1, dtype=np.int64)
        self.rows = Growing(float)
        self.reached = np.zeros(len(contour.path), dtype=bool)
        self.second_order_bound_s, self.toppra_bound_s = 0.0, 0.0
        cycles = np.ceil(profiles.total / (planning.playback.override * planning.cycle) - WHOLE_CYCLE)
        self.cycles = np.maximum(cycles, 1).astype(np.int64)
        self.clock = _Clock(contour, self.cycles, planning)
        #: First and last rows s of the last two continuous sections, by their numbers.
        self.ends = dict[int, tuple[Array, Array]]()
        timed = contour.path.timed[contour.segment[[self.begins[:-1], self.begins[1:] - 1]]]
        timed &= planning.playback == AS_PLANNED and not planning.rest
        dwelt = np.diff(self.clock.dwelt, prepend=0.0)
        jerky = limits.bound_jerk(planning.cycle)
        self.standstills = Standstills(self._find_end_joints, continuous, timed, dwelt, jerky, planning.cycle)

    def plan_in_time(self) -> Iterator[tuple[int, _SectionProfile]]:
        """Plan the continuous sections and stretch the others, one by one, for an override that is not steady yet."""
        playback = self.planning.playback
        for section, total in enumerate(self.profiles.total.tolist()):
            begin_s = self.clock.find_begin(section)
            if self.continuous[section]:
                yield section, self._plan(begin_s, self.planning.team, section)
            elif begin_s < playback.steady:
                self.cycles[section] = playback.count_cycles(total, begin_s, self.planning.cycle)

    def plan_each(self) -> Iterator[tuple[int, _SectionProfile]]:
        """Plan the continuous sections: several processes plan short ones side by side, and each long one together."""
        team, sections = self.planning.team, np.flatnonzero(self.continuous)
        long = np.diff(self.begins)[sections] >= LONG_SECTION
        for together, group in groupby(zip(long.tolist(), sections.tolist(), strict=True), key=itemgetter(0)):
            run = [section for _long, section in group]
            plan = partial(self._plan, 0.0, team if together else ALONE)
            yield from zip(run, map(plan, run) if together else team.map(plan, run), strict=True)

    def _plan(self, begin_s: float, team: Team, section: int) -> _SectionProfile:
        """Plan a continuous section that begins at a time (s)."""
        # scipy, and toppra even more so, are only imported where they are needed
        from verne_post.trajectory import continuous
        from verne_post.trajectory.initial_profile import bound_second_order_time

        planning, contour = self.planning, self.joints.contour
        first, last = int(self.begins[section]), int(self.begins[section + 1])
        path = ContourSection(self.joints, first, last, planning.cycle)
        toppra_bound = 0.0
        try:
            profile = continuous.plan_continuous(
                path,
                self.limits,
                planning.cycle,
                tuning.QUALITY if planning.quality else tuning.NORMAL,
                _choose_solver(planning.solver),
                planning.playback,
                begin_s,
                team,
            )
            if planning.solver == "both":
                toppra_bound = bound_second_order_time(path, self.limits, _choose_solver("toppra"), team)
        except (ValueError, RuntimeError) as error:
            line = int(contour.find_lines(self.begins[section : section + 1])[0])
            text = f"no feasible motion profile for the motion that begins in line {line}: {error}"
            raise SolverError(make_finding("VP420", text, line=line)) from None
        s = profile.s
        timed = contour.path.timed[contour.segment[first:last]]
        if planning.playback == AS_PLANNED and timed.any():
            limits = self.limits.bound_jerk(planning.cycle)
            s = follow_feed(SectionTask(path, limits, planning.cycle, planning.cycle), s, timed)
        return _SectionProfile(s, profile.bound, toppra_bound, self._find_feed_reached(path, s, team))

    def keep(self, section: int, planned: _SectionProfile) -> None:
        """Keep the profile of a section, with rows of rest beside other continuous sections."""
        self.ends[section] = planned.s[: REST_ROWS + 1].copy(), planned.s[-REST_ROWS - 1 :].copy()
        self.first_row[section] = self.rows.count
        self.rows.copy(planned.s, self.standstills.count_before(section), self.standstills.count_after(section))
        self.ends.pop(section - 1, None)
        self.cycles[section] = self.rows.count - self.first_row[section] - 1
        self.second_order_bound_s += planned.second_order_bound_s
        self.toppra_bound_s += planned.toppra_bound_s
        self.reached[planned.reached_segments] = True

    def _find_end_joints(self, section: int, begins: bool) -> Array:
        """Joints (4, n_joints) of the first rows of a section, or else of the last; of fewer rows if it has no more."""
        count, (first, last) = int(self.cycles[section]), self.begins[section : section + 2].tolist()
        if section in self.ends:
            s = self.ends[section][0 if begins else 1]
        else:
            row = np.arange(count + 1.0)[: REST_ROWS + 1] if begins else np.arange(count + 1.0)[-REST_ROWS - 1 :]
            s = self.profiles.find_position(np.full(len(row), section), row * (self.profiles.total[section] / count))
        return ContourSection(self.joints, first, last, self.planning.cycle).find_joints(s)

    def _find_feed_reached(self, path: ContourSection, s: Array, team: Team) -> Ints:
        """Segments (m,) on which the steps between rows s (n,) are as long as the feed rate allows."""

        def find(part: tuple[int, int]) -> Ints:
            release_memory()
            first, last = part
            rows = s[first : last + 1]
            element, w = path.locate(0.5 * (rows[1:] + rows[:-1]))
            cap = tuning.FEED_REACHED * self.joints.find_speed_cap(element, w)
            fast = np.diff(rows) / self.planning.cycle >= cap
            return find_used(self.joints.contour.segment[element[fast]])

        found = Growing(np.intp)
        for segments in team.map(find, split_evenly(len(s) - 1, tuning.SHARED_ROWS)):
            found.extend(segments)
        return found.freeze()

    def plan_profiles(self) -> MotionProfiles:
        """The profiles of all sections."""
        contour = self.joints.contour
        peak = np.where(self.continuous, 0.0, self.profiles.find_peak_speed())
        for begin, end in iterate_blocks(len(contour)):
            chunk = slice(begin, end)
            by_peak = peak[contour.section[chunk]] * contour.find_pace(chunk) >= tuning.FEED_REACHED
            self.reached[contour.segment[chunk][by_peak]] = True
        return MotionProfiles(
            self.profiles,
            self.first_row,
            self.cycles,
            self.rows.freeze(),
            self.reached,
            self.second_order_bound_s,
            self.toppra_bound_s if self.planning.solver == "both" else None,
        )


class _Clock:
    """When sections begin in the file, while the durations of those before become known."""

    def __init__(self, contour: Contour, cycles: NDArray[np.int64], planning: PlanningOptions) -> None:
        self.cycles, self.cycle, self.rest = cycles, planning.cycle, planning.rest
        dwells = np.bincount(
            contour.dwell_section, weights=dwell_cycles(contour, self.cycle), minlength=contour.n_sections + 1
        )
        self.dwelt = np.cumsum(dwells)
        self.section, self.row = 0, 0

    def find_begin(self, section: int) -> float:
        """Time at which a section begins, s; asked in order."""
        self.row += int(self.cycles[self.section : section].sum()) + 2 * self.rest * (section - self.section)
        self.section = section
        return (self.row + self.rest + float(self.dwelt[section])) * self.cycle


def dwell_cycles(contour: Contour, cycle: float) -> NDArray[np.int64]:
    """Cycles (d,) of every dwell: no shorter than programmed."""
    return np.maximum(np.ceil(contour.path.dwell_seconds / cycle - WHOLE_CYCLE), 1).astype(np.int64)


def _choose_solver(name: str) -> Callable[..., Array]:
    """The second-order solver that plans."""
    if name == "toppra":
        from verne_post.trajectory import toppra_backend

        return toppra_backend.solve
    from verne_post.trajectory import reachability

    return reachability.solve
