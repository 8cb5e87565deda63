"""Rest-to-rest scalar profiles by ruckig. The only file that imports it.

Ruckig is fed a dimensionless problem (distance 1, jerk 1): its tolerances are absolute. Its answers
are checked: a profile that is not finished, leaves [0, 1] or takes no time is an error, never a profile.
"""

import numpy as np
from numpy.typing import NDArray

from verne_post.trajectory import tuning

Array = NDArray[np.float64]


def rest_to_rest(distance: Array, velocity: Array, acceleration: Array, jerk: Array) -> tuple[Array, Array]:
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
    jerk = np.minimum(jerk, (velocity / tuning.RUCKIG_SLOWEST) ** 3 / distance**2)
    unit = np.cbrt(distance / jerk)
    v = np.minimum(velocity * unit / distance, tuning.RUCKIG_UNREACHED).tolist()
    a = np.minimum(acceleration * unit**2 / distance, tuning.RUCKIG_UNREACHED).tolist()
    problem.max_jerk = [1.0]
    for row in range(len(distance)):
        problem.max_velocity = [v[row]]
        problem.max_acceleration = [a[row]]
        if solver.calculate(problem, trajectory) != ruckig.Result.Working:
            continue
        extrema = trajectory.position_extrema[0]
        if (
            extrema.min < -tuning.RUCKIG_OVERSHOOT
            or extrema.max > 1 + tuning.RUCKIG_OVERSHOOT
            or not trajectory.duration > 0
        ):
            continue
        profile = trajectory.profiles[0][0]
        durations[row], jerks[row] = profile.t, profile.j
    return durations * unit[:, None], jerks * jerk[:, None]
