"""A peer of the planner: copp-py (extra ``bench``), third-order profiles along a path as a sequence of linear programs.

It knows limits at the stations of a grid, with its jerk constraint made linear about the profile before: the first is
that of its second-order pass, and each program starts from the one before. Differences of rows, which drives see, are
not among its constraints; they are measured here.
"""

import time
from typing import Final

import copp_py
import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from verne_post.model.machine import Limits
from verne_post.trajectory.plan import ContourSection

Array = NDArray[np.float64]

#: Stations for each mm: more cost time in proportion, with 50 zigzags take up to 0.5 % longer.
STATIONS_PER_MM: Final = 100
#: Linear programs follow each other until the time changes by less than this share, as many as MOST_PROGRAMS.
SETTLED: Final = 1e-3
MOST_PROGRAMS: Final = 20
#: Steps that a program may take: the seventh of the blade needs more than the 200 of Clarabel.
MOST_STEPS: Final = 1000
#: A joint that moves less, m or rad, has no part in it.
LEAST_MOVE: Final = 1e-9


class PeerProfile(Struct, frozen=True):
    """Time, s; the largest joint jerk of its rows over the limit; what it took, CPU s; programs, and what the last
    changed.
    """

    time_s: float
    jerk_ratio: float
    cpu_s: float
    programs: int
    last_change: float


def find_profile(section: ContourSection, limits: Limits, cycle: float) -> PeerProfile | None:
    """Profile of a section from stop to stop, that of the last linear program that is solved; None where none is."""
    s = np.linspace(0.0, section.length, int(np.ceil(section.length * STATIONS_PER_MM)) + 1)
    joints = section.find_joints(s)
    moving = np.flatnonzero(np.ptp(joints, axis=0) > LEAST_MOVE)
    path = make_interp_spline(s, joints[:, moving], k=5)
    speed = section.find_speed(s)
    begun = time.process_time()
    robot = copp_py.Robot(len(moving), capacity=len(s))
    robot.append_s(s)
    robot.set_q(path(s), path(s, 1), path(s, 2), 0, dddq=path(s, 3))
    for add, limit in (
        (robot.add_velocity_limits, limits.velocity),
        (robot.add_acceleration_limits, limits.acceleration),
        (robot.add_jerk_limits, limits.jerk),
    ):
        add(limit[moving], -limit[moving], start_idx_s=0, length=len(s))
    constraints = robot.constraints
    constraints.amax_substitute(np.minimum(constraints.amax_values(), speed**2), 0)
    second = copp_py.solver.topp2_ra
    squared_speed = second.solve(
        second.Problem(constraints, idx_s_interval=(0, len(s) - 1), a_boundary=(0.0, 0.0)), second.Options()
    )
    third = copp_py.solver.topp3_lp
    options = third.Options(clarabel_settings=copp_py.clarabel.ClarabelSettings(max_iter=MOST_STEPS))
    acceleration, profile, total = None, None, np.inf
    programs, change = 0, np.inf
    for _ in range(MOST_PROGRAMS):
        problem = third.Problem(constraints, squared_speed, b_linearization=acceleration)
        try:
            profile = third.solve(problem, options)
        except copp_py.CoppError:
            break  # what the program before has found still stands
        squared_speed, acceleration, before = np.asarray(profile.a), np.asarray(profile.b), total
        total, arrivals = copp_py.interpolation.s_to_t_topp3(s, profile)
        programs, change = programs + 1, abs(before - total) / total
        if change < SETTLED:
            break
    if profile is None:
        return None
    spent = time.process_time() - begun
    rows = copp_py.interpolation.t_to_s_topp3_uniform(s, profile, arrivals, cycle, include_final=True)
    at_rest = np.concatenate([np.zeros(3), rows, np.full(3, section.length)])
    jerk = np.diff(path(at_rest), n=3, axis=0) / cycle**3
    return PeerProfile(total, float(np.abs(jerk / limits.jerk[moving]).max()), spent, programs, change)
