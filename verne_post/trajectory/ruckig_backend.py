"""Rest-to-rest scalar profiles by ruckig. The only file that imports it.

Ruckig is fed a dimensionless problem (distance 1, jerk 1): its tolerances are absolute. Its answers
are checked: a profile that is not finished, leaves [0, 1] or takes no time is an error, never a profile.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array

#: Smallest dimensionless speed limit. A slower one would make the profile longer than ruckig allows
#: (7e3 time units); accelerating more gently instead costs 6e-5 of the time.
_SLOWEST: Final = 1e-3
#: A limit above this is never reached by a unit distance at unit jerk, whose peak values are 0.63 and 0.8. ruckig takes
#: no infinite limits.
_UNREACHED: Final = 10.0
#: How far a profile may leave [0, 1]: rounding of its polynomials.
_OVERSHOOT: Final = 1e-9


def plan_rest_to_rest(distance: Array, velocity: Array, acceleration: Array, jerk: Array) -> tuple[Array, Array]:
    """Time-optimal profiles s(t) from rest to rest under scalar limits.

    Parameters
    ----------
    distance, velocity, acceleration, jerk : ndarray, shape (n,)
        All positive; velocity and acceleration may be infinite.

    Returns
    -------
    durations : ndarray, shape (n, 7)
        Seconds of the seven phases of constant jerk; NaN in rows where no profile was found.
    jerks : ndarray, shape (n, 7)
        Jerk of each phase.
    """
    import ruckig

    solver = ruckig.Ruckig(1)
    problem, trajectory = ruckig.InputParameter(1), ruckig.Trajectory(1)
    problem.target_position = [1.0]
    durations, jerks = np.full((len(distance), 7), np.nan), np.zeros((len(distance), 7))
    jerk = np.minimum(jerk, (velocity / _SLOWEST) ** 3 / distance**2)
    unit = np.cbrt(distance / jerk)
    v = np.minimum(velocity * unit / distance, _UNREACHED).tolist()
    a = np.minimum(acceleration * unit**2 / distance, _UNREACHED).tolist()
    problem.max_jerk = [1.0]
    for row in range(len(distance)):
        problem.max_velocity = [v[row]]
        problem.max_acceleration = [a[row]]
        if solver.calculate(problem, trajectory) != ruckig.Result.Working:
            continue
        extrema = trajectory.position_extrema[0]
        if extrema.min < -_OVERSHOOT or extrema.max > 1 + _OVERSHOOT or not trajectory.duration > 0:
            continue
        profile = trajectory.profiles[0][0]
        durations[row], jerks[row] = profile.t, profile.j
    return durations * unit[:, None], jerks * jerk[:, None]
