"""The time laws of a whole contour: a scalar law from stop to stop, a flowing law where corners are rounded."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import Growing, blocks, running_sums
from verne_post.model.contour import Contour
from verne_post.model.findings import SolverError, finding
from verne_post.model.machine import Limits
from verne_post.model.protocols import JointFunctions
from verne_post.timing.exact_stop import RunLaws, plan_runs
from verne_post.timing.playback import Playback
from verne_post.timing.visible import hidden, turn_rate, visible_speed

Array = NDArray[np.float64]
Ints = NDArray[np.integer]

#: Rows of rest added where a flowing run follows or precedes another; the row at the stop itself is the third.
REST_ROWS: Final = 2
#: Rows whose feed is looked at together.
CHUNK_ROWS: Final = 1 << 15
#: A feed counts as reached at this share of it, which laws come to from below; the same share makes a row slow (verify).
REACHED: Final = 0.99


@dataclass(frozen=True, eq=False)
class RunPlan:
    """The law of every run.

    Attributes
    ----------
    laws : RunLaws
        From stop to stop; what it says of flowing runs is not used.
    flow_first : ndarray of int64, shape (n_runs,)
        Where a flowing run's rows begin in ``flow_s``, -1 for the others.
    cycles : ndarray of int64, shape (n_runs,)
        Control cycles that each run lasts, at the speed at which it is played.
    flow_s : ndarray, shape (n,)
        Path parameter of each row of the flowing runs, mm.
    reached : ndarray of bool, shape (n_pieces,)
        The piece's feed is reached somewhere on it.
    flow_bound : float
        Sum of the second-order bounds of the flowing runs, s.
    other_bound : float or None
        The same by the other solver, where both were asked.
    """

    laws: RunLaws
    flow_first: NDArray[np.int64]
    cycles: NDArray[np.int64]
    flow_s: Array
    reached: NDArray[np.bool_]
    flow_bound: float
    other_bound: float | None


@dataclass(frozen=True)
class Planning:
    """How to plan.

    Attributes
    ----------
    cycle : float
        Control cycle, s.
    solver : {"scan", "toppra", "both"}
        Of the second-order problem; "both" plans with the scan and lets toppra give the bound as well.
    quality : bool
        Plan finely and without margin: practically the third-order optimum, at many times the cost.
    playback : Playback
        How fast what is planned is played.
    """

    cycle: float
    solver: str = "scan"
    quality: bool = False
    playback: Playback = field(default_factory=Playback)


#: A duration this close above a whole number of cycles is that number (in cycles).
WHOLE_CYCLE: Final = 1e-9


class ContourRun:
    """One run of a contour as a function of its path parameter; implements ``run_path.Run``.

    Parameters
    ----------
    joints : JointFunctions
    first, last : int
        Segments of the run, ``last`` excluded.
    cycle : float
        Control cycle, s.
    """

    def __init__(self, joints: JointFunctions, first: int, last: int, cycle: float) -> None:
        self.joints, self.first, self.cycle = joints, first, cycle
        contour = joints.contour
        self.breaks = running_sums(contour.length[first:last])
        turned = Growing(float)  # by arcs, over each segment, rad
        for begin, end in blocks(last, first) if len(contour.path.arcs.sweep) else ():
            turned.extend(turn_rate(contour, np.arange(begin, end)) * contour.length[begin:end])
        self.turned = running_sums(turned.column())

    @property
    def length(self) -> float:
        """Length by s, mm."""
        return float(self.breaks[-1])

    def locate(self, s: Array) -> tuple[Ints, Array]:
        """Segment and w of path parameters s (n,)."""
        local = np.clip(np.searchsorted(self.breaks, s, side="right") - 1, 0, len(self.breaks) - 2)
        w = (s - self.breaks[local]) / (self.breaks[local + 1] - self.breaks[local])
        return self.first + local, np.clip(w, 0.0, 1.0)

    def q(self, s: Array) -> Array:
        """Joints (n, n_joints) at s (n,)."""
        return self.joints.q(*self.locate(s))

    def speed(self, s: Array) -> Array:
        """Largest ds/dt (n,) at s (n,), mm/s: by the feed, and so that the rows show how arcs turn."""
        segment, w = self.locate(s)
        cap = self.joints.speed_cap(segment, w)
        if len(self.turned) == 1:
            return cap
        return np.minimum(cap, visible_speed(self.joints.contour, segment, self.cycle))

    def hidden(self, s: Array) -> Array:
        """How many times too far steps (n - 1,) between rows s (n,) are from the path between them, and arcs turn too far.

        The step before the first is taken to have been as long as need be.
        """
        segment, w = self.locate(s)
        turned = None
        if len(self.turned) > 1:
            local = segment - self.first
            turned = self.turned[local] + w * (self.turned[local + 1] - self.turned[local])
        return hidden(self.pose, self.joints.contour, s, segment, turned)

    def pose(self, s: Array) -> tuple[Array, Array]:
        """Tip (n, 3) and nominal angles (n, 2) at s (n,)."""
        return self.joints.pose(self.joints.contour, *self.locate(s))


def plan_contour(
    joints: JointFunctions, first: Array, second: Array, third: Array, limits: Limits, planning: Planning,
    progress: Callable[[int], None] | None = None,
) -> RunPlan:  # fmt: skip
    """Plan every run of a contour.

    Parameters
    ----------
    joints : JointFunctions
    first, second, third : ndarray, shape (n, n_joints)
        Largest derivatives of the joints by w over the segments of runs from stop to stop, one after the other.
    limits : Limits
    planning : Planning
    progress : callable, optional
        Told how many segments have been planned.

    Raises
    ------
    SolverError
        Naming the source line of the first run without a law.
    """
    contour = joints.contour
    begins = contour.run_begins
    flowing = contour.flowing
    laws = plan_runs(contour, first, second, third, limits, ~flowing, planning.cycle)
    reached = np.zeros(len(contour.path), dtype=bool)
    peak = np.where(flowing, 0.0, laws.peak_speed())
    for begin, end in blocks(len(contour)):
        some = slice(begin, end)
        by_peak = peak[contour.run[some]] * contour.pace(some) >= REACHED
        reached[contour.piece[some][by_peak]] = True
    flow_first = np.full(len(flowing), -1, dtype=np.int64)
    flow_s = Growing(float)
    flow_bound, other_bound = 0.0, 0.0
    cycle, played = planning.cycle, planning.playback
    cycles = np.maximum(np.ceil(laws.total / (played.override * cycle) - WHOLE_CYCLE), 1).astype(np.int64)
    clock = _Clock(contour, cycles, cycle)
    for run in range(len(flowing)) if played.ramp else np.flatnonzero(flowing).tolist():
        begin_s = clock.at(run) if played.ramp else 0.0
        if not flowing[run]:
            if begin_s < played.steady:
                cycles[run] = played.cycles(float(laws.total[run]), begin_s, cycle)
            continue
        # scipy, and toppra even more so, are only imported where they are needed
        from verne_post.timing import flowing as flow
        from verne_post.timing.first_law import second_order_bound

        run_path = ContourRun(joints, int(begins[run]), int(begins[run + 1]), cycle)
        try:
            effort = flow.QUALITY if planning.quality else flow.NORMAL
            law = flow.flowing_law(run_path, limits, cycle, effort, _solver(planning.solver), played, begin_s)
            flow_bound += law.bound
            if planning.solver == "both":
                other_bound += second_order_bound(run_path, limits, _solver("toppra"))
        except (ValueError, RuntimeError) as error:
            line = int(contour.line(begins[run : run + 1])[0])
            text = f"no time law found for the motion that begins in line {line}: {error}"
            raise SolverError(finding("VP420", text, line=line, last_line=line, worst_line=line)) from None
        # differences over four rows must not see the end of one motion and the beginning of the next
        s = law.s
        before, after = run > 0, run + 1 < len(flowing) and not flowing[run + 1]
        flow_first[run] = flow_s.count
        flow_s.copy(s, REST_ROWS * before, REST_ROWS * after)
        cycles[run] = flow_s.count - flow_first[run] - 1
        for begin, end in blocks(len(s) - 1):
            for row in range(begin, end, CHUNK_ROWS):
                part = s[row : min(row + CHUNK_ROWS, end) + 1]
                segment, w = run_path.locate(0.5 * (part[1:] + part[:-1]))
                fast = np.diff(part) / cycle >= REACHED * joints.speed_cap(segment, w)
                reached[contour.piece[segment[fast]]] = True
        if progress is not None:
            progress(int(begins[run + 1]))
    both = planning.solver == "both"
    return RunPlan(laws, flow_first, cycles, flow_s.column(), reached, flow_bound, other_bound if both else None)


class _Clock:
    """When runs begin in the file, while the durations of those before become known."""

    def __init__(self, contour: Contour, cycles: NDArray[np.int64], cycle: float) -> None:
        self.cycles, self.cycle = cycles, cycle
        dwells = np.bincount(contour.dwell_run, weights=dwell_cycles(contour, cycle), minlength=contour.n_runs + 1)
        self.dwelt = np.cumsum(dwells)
        self.run, self.row = 0, 0

    def at(self, run: int) -> float:
        """Time at which a run begins, s; asked in order."""
        self.row += int(self.cycles[self.run : run].sum())
        self.run = run
        return (self.row + float(self.dwelt[run])) * self.cycle


def dwell_cycles(contour: Contour, cycle: float) -> NDArray[np.int64]:
    """Cycles (d,) of every dwell: no shorter than programmed."""
    return np.maximum(np.ceil(contour.path.dwell_seconds / cycle - WHOLE_CYCLE), 1).astype(np.int64)


def _solver(name: str) -> Callable[..., Array]:
    """The second-order solver that plans."""
    if name == "toppra":
        from verne_post.timing import toppra_backend

        return toppra_backend.solve
    from verne_post.timing import scan

    return scan.solve
