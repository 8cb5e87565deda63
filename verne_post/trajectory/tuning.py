"""The constants of planning: what each one means, and what it trades.

None of them decides whether rows are inside the limits: repair and verification do. They decide how near to the least
time a profile comes, and what that costs. ``tests/benchmarks/tuning.py`` lists the range of each one and measures it;
docs/tuning.md has the changes of cycle time and CPU. Times are in s, lengths in mm. A *unit* is the time scale of a
profile (``TIME_UNIT`` or the control cycle, the longer one; less for short sections). X is the square of the rate at
which a pass re-times the profile of the pass before (:mod:`interior_point`).
"""

from typing import Final

import numpy as np
from msgspec import Struct

# --- passes of the interior point method -----------------------------------------------------------

#: Shares of the velocity, acceleration and jerk limits that are planned with. More leaves more rows to repair; rows may
#: reach ``ACCEPTED_RATIOS``.
PLANNED_SHARES: Final = (0.9998, 0.9998, 0.999)
#: Tightest acceleration and jerk rows: those of every joint. A profile that is far from its limits, or far beyond some,
#: says little about which will bind. Where rows were left out, such profiles never recovered: up to 4.5 times as long.
ALL_ROWS: Final = (0, 0)


class PassSettings(Struct, frozen=True, kw_only=True):
    """Settings of one pass of the interior point method."""

    #: knot_units, points_per_knot: Knot spacing, and points per knot at which the limits hold. Fewer are faster
    #: and leave more to repair.
    knot_units: int
    points_per_knot: int
    #: So many of the tightest acceleration and jerk rows count on each side of each point; 0: all.
    tightest_rows: tuple[int, int]
    largest_x: float  #: How much faster than the profile before a pass may become, squared.
    #: start_gap, final_gap: Complementarity to start from and to end at, over the time. A smaller end is nearer
    #: the optimum.
    start_gap: float
    final_gap: float
    iterations: int  #: At most so many.
    shares: tuple[float, float, float] = PLANNED_SHARES  #: Of the velocity, acceleration and jerk limits.


class Effort(Struct, frozen=True, kw_only=True):
    """How finely a profile is planned."""

    passes: tuple[PassSettings, ...]  #: Coarse to fine.
    last: PassSettings  #: The pass after them; with knots of one unit where jerk sets the time (``JERK_BOUND_RATIO``).
    repeats: int  #: The last pass is repeated, with every row, at most so often.
    #: Passes before the last one stop when the profile takes less than so many times the second-order bound.
    near_bound: float = 0.0
    #: A section is planned anew where many rows are still so far beyond a limit after a round of repair.
    hopeless: float = np.inf


#: The passes that plan a section unless ``--quality`` is set: a coarse one, a finer one, and the last. The first two
#: take every joint, and the second ends near the optimum: the last one, whose knots are nearer, does not recover from
#: less. With a coarser end, a sharp corner between long lines was up to 24 ms slower than a stop, depending on the
#: places of the knots. A profile near the second-order bound has little to gain. Without the second pass, finely
#: divided programs take 11 % less CPU; of 400 random ones none takes more than 0.13 % longer (0.5 % where
#: ``near_bound`` is 1.2). A single sharp corner between long lines loses 0.1 to 0.8 ms more. With ``hopeless`` rows
#: given up, random moves of 0.2 to 5 mm take 13 % less CPU at cycles of 4 to 10 ms, and 0 to 0.8 % less time; with 1.1,
#: another 0.1 to 0.4 % less time, and as much CPU as without.
NORMAL: Final = Effort(
    passes=(
        PassSettings(knot_units=8, points_per_knot=3, tightest_rows=ALL_ROWS,
                     largest_x=8.0, start_gap=100.0, final_gap=3e-1, iterations=25),
        PassSettings(knot_units=4, points_per_knot=2, tightest_rows=ALL_ROWS,
                     largest_x=4.0, start_gap=10.0, final_gap=0.1, iterations=25),
    ),
    last=PassSettings(knot_units=2, points_per_knot=2, tightest_rows=(2, 3),
                      largest_x=4.0, start_gap=3.0, final_gap=3e-3, iterations=20),
    repeats=3,
    near_bound=1.1,
    hopeless=1.2,
)  # fmt: skip

_WHOLE: Final = (1.0, 1.0, 1.0)
#: No margin, more passes, every row and a small gap: the optimum in practice, to compare with. Its CPU is many times
#: that of ``NORMAL``; docs/performance.md has the gain. It also plans what ``NORMAL`` could not repair.
QUALITY: Final = Effort(
    passes=tuple(
        PassSettings(
            knot_units=2,
            points_per_knot=points,
            tightest_rows=ALL_ROWS,
            largest_x=largest_x,
            start_gap=start_gap,
            final_gap=final_gap,
            iterations=iterations,
            shares=_WHOLE,
        )
        for points, largest_x, start_gap, final_gap, iterations in (
            (2, 8.0, 30.0, 1e-1, 25),
            (2, 4.0, 10.0, 1e-1, 25),
            (4, 2.0, 3.0, 3e-3, 40),
            (4, 2.0, 1.0, 1e-3, 40),
        )
    ),
    last=PassSettings(
        knot_units=1,
        points_per_knot=2,
        tightest_rows=ALL_ROWS,
        largest_x=2.0,
        start_gap=1.0,
        final_gap=5e-4,
        iterations=40,
        shares=_WHOLE,
    ),
    repeats=3,
)

#: The finest time scale of a profile; at least the control cycle. A longer one is faster and leaves more to repair.
TIME_UNIT: Final = 1e-3
#: Knots that are kept of each solution, and the look-ahead beyond them in units. They bound the memory; a short
#: look-ahead slows down at the end of each window.
WINDOW_KNOTS: Final = 3500
LOOK_AHEAD_UNITS: Final = 300
#: Pieces between cruises are solved together up to so many values of their constraints. Fewer pay more for each array
#: operation: with 20,000 finely divided programs take 8 % more CPU, with 40,000 to 75,000 they take the same. More no
#: longer fit the processor's cache, and one difficult piece makes all of them iterate longer.
TOGETHER_VALUES: Final = 55_000
#: X at the end of a window before others, and after a window without a feasible next one: smaller is safer and slower.
WINDOW_END_X: Final = 0.1
CRAWLING_X: Final = 0.01
#: A virtual joint with Q' = 1 keeps X from jumping where the joints rest: its acceleration and jerk limits, times the
#: unit and its square. X needs at least some 20 units to change by its own size.
VIRTUAL_ACCELERATION: Final = 0.3
VIRTUAL_JERK: Final = 0.2
#: X where a pass starts, and units over which it slows down at the end of a window. Both only change the iterations.
START_X: Final = 0.98
START_RAMP: Final = 100
#: The last pass is repeated while more than one row in so many is far beyond a limit, since repair takes time at each.
ROWS_PER_FAR_ROW: Final = 500
#: Jerk sets the time of a profile that takes so many times as long as the second-order bound. It needs twice the knots,
#: since its jerk switches often, and only at knots. Smaller costs CPU everywhere; larger costs time at sharp corners.
JERK_BOUND_RATIO: Final = 1.2

# --- interior point method -------------------------------------------------------------------------

#: Smallest X: one pass may slow the profile down a hundredfold. X^(-1/2) is evaluated no closer to zero.
SMALLEST_X: Final = 1e-4
#: Slacks start no smaller than this, so that a start outside the limits is inside the method's set.
START_SLACK: Final = 0.3
#: A constraint may be off by this share of its limit at the end. More saves iterations and is left to repair.
ACCEPTED_INFEASIBILITY: Final = 5e-4
#: Diagonal entry that keeps an unknown where it is; far above any other, and far from overflow.
FIXED_DIAGONAL: Final = 1e30
#: Steps go this share of the way to the boundary of the feasible set.
TO_BOUNDARY: Final = 0.99
#: After a step shorter than this, the next one aims at no less than this share of the complementarity.
SHORT_STEP: Final = 0.3
RECENTRE: Final = 0.3
#: Where a step would be shorter than this, rounding has spoilt the direction: the iteration ends with what it has. An
#: iteration that went on ended once near rest, where any limit holds, at twelve times the duration.
STUCK_STEP: Final = 1e-4
#: A pass without a solution that slows a section down by more than this has got lost near rest, where any limit holds.
#: No pass needs to: the first profile is slower than the time-optimal one.
LOST_RATIO: Final = 2.0
#: The jerk constraints bend the other way than the objective: at least this share of the objective's curvature stays.
LEAST_CURVATURE: Final = 0.1

# --- first profile ---------------------------------------------------------------------------------

#: Short sections have a finer time scale, in proportion but no finer than the last share. A section is long from so
#: many units on; it is assumed to need so many units more than without jerk limits. Finer costs CPU in proportion on
#: short sections, and is nearer the optimum.
LONG_SECTION: Final = 200
SHORT_SECTION: Final = 20
FINEST_UNIT: Final = 0.25
#: Spacing of the first profile's samples, in units, and how many of them are averaged.
START_STEP: Final = 4
START_SMOOTH: Final = 10
#: The first profile may exceed the allowed jerk: its squared speed is at most this factor times the jerk's cap.
START_JERK_EXCESS: Final = 2.0
#: It is slowed down by this factor: knots are even in its time, and the slow spots of the profile need many.
START_SLOWER: Final = 1.5

# --- cruise: where there is nothing to plan ----------------------------------------------------------

#: In a cruise no joint takes more than this share of a limit. More leaves less to solve, and more to repair.
CRUISE_SHARE: Final = 0.7
#: A cruise ends where the feed rate along the path changes by more than this. Smaller changes are followed at the
#: lowest of the feed rates around, evened out over so many units: more costs time, less takes jerk.
CRUISE_STEP: Final = 0.02
CRUISE_EVEN: Final = 16

# --- grid and reachability passes ------------------------------------------------------------------

#: A span of the grid is at most this much path. Longer ones are halved where a joint needs it.
LONGEST_SPAN: Final = 20.0
#: In long sections, elements that are passed together in so many seconds at the feed rate share a span. A span for each
#: costs a quarter more CPU on finely divided programs; 12 ms cost 2 % more; much longer spans are halved again. From 0
#: to 32 ms the cycle time changes by 0.1 %.
SHORT_SPAN: Final = 20e-3
#: The most elements of such a span. Where the motion is far slower than the feed rate, hundreds of kinks would share a
#: span that is not halved often enough to follow them. Without a bound one section had no profile. With 16 and more,
#: single dense programs take up to 4 % longer; with 4 to 1000 the CPU is the same.
SPAN_ELEMENTS: Final = 8
#: A span is halved while the last Chebyshev coefficients of a joint exceed this share of its motion over the span.
TAIL_SHARE: Final = 1e-4
#: Motion below this (mm or rad) is rounding noise and asks for no smaller spans.
TAIL_NOISE: Final = 1e-9
#: The Chebyshev points of a span, evenly spread, that become points of the grid where there are so many spans. All of
#: them cost twice the CPU of the reachability pass.
KEPT_POINTS: Final = [1, 3, 4, 6]
MANY_SPANS: Final = 200
#: Joints are known to this share of their largest value; derivatives that could be rounding alone count as zero.
JOINT_ROUNDING: Final = 3e-14
#: Grid points per window: enough steps to forget the start, few enough Python steps. Changes CPU only.
PASS_WINDOW: Final = 96

# --- rows: what may be left out, and repair --------------------------------------------------------

#: Rows are left out at the ends while they stay this near, as a share of the motion that the limits allow in one cycle
#: from rest; and at most so many.
CREEPING_MOTION: Final = 0.1
CREEPING_ROWS: Final = 200
#: Ratios that rows may reach: velocity and feed, acceleration, jerk. Verification accepts more, for rounding.
ACCEPTED_RATIOS: Final = (1.0003, 1.002, 1.008)
#: Ratios that shifts aim at; least squares approaches them from outside.
AIMED_RATIOS: Final = (1.0001, 1.0007, 1.0055)
#: Rows are shifted over so many units on each side of one that is beyond a limit. With 20, random programs take 3 to 7
#: % less CPU, and one in a hundred short ones up to 1.3 % longer.
REPAIR_REACH: Final = 40
#: A round finds the stretches and shifts their rows; from the second on, they get more rows first.
REPAIR_ROUNDS: Final = 6
#: Steps of the least squares in one round, and how often in one step the rows beyond their aims are sought anew.
#: With 8, programs of 3,000 moves at cycles of 10 ms take 2 and 3 % more time, and as much CPU.
SHIFT_STEPS: Final = 24
ACTIVE_SET_STEPS: Final = 4
#: Weight of the jerk of the shifts against the excess.
SHIFT_DAMPING: Final = 1e-4
#: ... and at most, where steps shift hardly anything. With 1e4, those programs take 40 % more evaluations of rows and
#: 0.3 % less time; with 300, 20 % fewer and up to 0.9 % more.
LARGEST_DAMPING: Final = 1e3
#: A row so far beyond a limit is not repaired by shifts alone: its stretch gets one row more.
FAR_RATIO: Final = 1.15
#: More rows come over a stretch so long that the change of speed takes a share of the jerk only: its length cubed is
#: this times the rows, times the motion of a cycle over the motion that the jerk makes in one.
GENTLE_LENGTH: Final = 600.0
#: Sections of at most so many rows are tried with one row less, again and again. Among 300 random programs those with
#: 20 to 100 rows take 3 % less time, and planning them 50 % more CPU. Of 100 rows one is 1 %, which shifts rarely find.
FEW_ROWS: Final = 100
#: From so many elements to a row on, a row is taken out at each place in turn. 12 programs of moves about as long as
#: the tolerance, at cycles of 2 to 10 ms, take 34 % less time, and seven times the CPU of planning, up to 3 s for a
#: section. With 1, sections are tried as well that gain 3 %; with 3, some are not tried that gain half.
CROWDED_ELEMENTS: Final = 2.0
#: ... over so many rows, wide to narrow. Without 24 and 3, those programs take 11 % longer, and a third less CPU.
TAKEN_OUT_OVER: Final = (24, 12, 6, 3)
#: Their shifts are not small: so many rounds. One round means 6 % more time, three 1 % less and a third more CPU.
CROWDED_ROUNDS: Final = 2
#: Sections with fewer elements and at most so many rows: a row is taken out over so many, in one round. One row is 2.5
#: % and more of their time, and repair may have cost several. Circles within a few cycles take 11 % less time so.
SINGLE_ROWS: Final = 40
SINGLE_OVER: Final = 12
#: Strain counts as no less than this share of the largest; where the joints rest, shifts cost something too.
SMALLEST_STRAIN: Final = 1e-6

# --- slowing down where repair does not do -----------------------------------------------------------

#: Places that cannot be repaired are slowed down before the section as a whole is: so often, over so many units on each
#: side, and by this factor more than the excess asks for.
SLOWDOWN_ATTEMPTS: Final = 5
SLOWDOWN_REACH: Final = 60
SLOWDOWN_MARGIN: Final = 1.3
#: Half the speed halves the worst ratio of a section or more. Where it stays above this share, the joints jump.
JUMP_SHARE: Final = 0.9

# --- what rows show of the path (verne_post.trajectory.visible) --------------------------------------

#: Largest turn of an arc from row to row, rad: at half a turn nobody could tell the sense of it.
MOST_TURN: Final = 0.42 * 2 * np.pi
#: Largest distance of the path between two rows from the straight step between them, as a share of the step, or of the
#: step before where that is longer. Half way between two rows of even speed nothing is farther than half a step from
#: both.
BULGE: Final = 0.45
#: A feed counts as reached at this share of it, which profiles approach from below; verification uses the same share.
FEED_REACHED: Final = 0.99

# --- input shaper --------------------------------------------------------------------------------------

#: Share of every tolerance that a shaper may use; corners are blended with the rest. More is faster where the shaper
#: limits the speed, less where the blend does: from 0.25 to 0.75, zigzags with a mode of 40 Hz gain 30 %, with one of
#: 150 Hz they lose 30 %.
SHAPER_SHARE: Final = 0.5
#: The speed is reduced, where the shaper displaces the tool too far, so often at most.
SHAPER_ATTEMPTS: Final = 8
#: ... and by so much more than the displacement asks for: a larger margin needs fewer attempts and costs time.
SHAPER_MARGIN: Final = 1.02

# --- stop-to-stop profiles ---------------------------------------------------------------------------

#: Shares of the largest speed and acceleration that are tried. More of them cost CPU and gain little time.
SPEED_SHARES: Final = np.concatenate([[1.0], np.geomspace(0.97, 0.02, 30)])
ACCELERATION_SHARES: Final = np.array([1.0, 0.85, 0.7, 0.55, 0.4, 0.25, 0.12])
#: The joint limits that are planned with. The bounds on the derivatives are exact up to 1e-9; the
#: rest is left for the rounding of the written numbers, which verification also counts.
STOP_TO_STOP_SHARE: Final = 1.0 - 1e-6

#: Profiles from stop to stop that take longer, s, and so many times the second-order bound and the time at the feed
#: rate, are planned like continuous sections. The CPU for looking grows with the number of sections that are longer.
UNEVEN_S: Final = 1.0
UNEVEN_RATIO: Final = 2.0

# --- how much is done at a time: memory against overhead, the same rows -------------------------------

#: Elements, sections, rows or times that are worked on together.
AT_A_TIME: Final = 1 << 14
#: Elements of a section in the grid of one process. Spans end where such a piece does: with 41 elements the time
#: changes by up to 0.2 %. So many pieces are scanned at a time, and so many points, with one more piece as look-ahead.
GRID_ELEMENTS: Final = 1 << 12
GRID_PIECES: Final = 4
GRID_POINTS: Final = 3 << 15
#: Rows of a section that one process evaluates together; half as many cost one process 1 % more time in all.
SHARED_ROWS: Final = 1 << 13
#: Products of so many multiplications are made by one thread.
BLAS_WORK: Final = 200_000
