"""toppra as a second solver of the second-order problem, to check :mod:`verne_post.trajectory.reachability` against.

toppra solves small linear programs with absolute tolerances, so the path parameter is scaled first. The path is
given by its derivatives at the grid points: no spline stands for it.
"""

from typing import Any, Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.rows import find_row_min
from verne_post.model.machine import Limits
from verne_post.trajectory.section_path import Grid

#: The path parameter is scaled so that the largest speed along it is this; toppra is sound from 0.7 to 7.
_SPEED: Final = 7.0
#: Speeds squared beyond this (scaled) are not asked of toppra: its programs need bounds.
_X: Final = 1e4


def solve(grid: Grid, limits: Limits, *, start: float = 0.0) -> Array:
    """Squared speed x = sd^2 of the time-optimal profile from rest to rest; see :func:`reachability.solve`.

    Parameters
    ----------
    start : float
        x at the first point, mm2/s2.

    Returns
    -------
    ndarray, shape (n,)
        mm2/s2.

    Raises
    ------
    RuntimeError
        toppra found no profile; the message carries its return code.
    """
    import toppra
    from toppra.algorithm import TOPPRA
    from toppra.algorithm.algorithm import ParameterizationReturnCode
    from toppra.constraint import DiscretizationType, JointAccelerationConstraint, LinearConstraint

    with np.errstate(divide="ignore"):
        x_cap = np.minimum(grid.speed**2, find_row_min(limits.velocity / np.abs(grid.d1)) ** 2)
    finite = x_cap[np.isfinite(x_cap)]
    scale = _SPEED / np.sqrt(finite.max()) if len(finite) else _SPEED / float(grid.s[-1])
    scaled = grid.s * scale
    bound = np.minimum(x_cap * scale**2, _X)

    class Path:
        """The derivatives by scaled s, known at the grid points only."""

        dof = grid.d1.shape[1]
        path_interval = np.array([scaled[0], scaled[-1]])
        waypoints = None

        def __call__(self, s: Array, order: int = 0) -> Array:
            at = np.searchsorted(scaled, np.atleast_1d(s))
            if order == 0:
                return np.zeros((len(at), self.dof))
            return np.asarray((grid.d1 / scale, grid.d2 / scale**2)[order - 1][at])

    class SpeedCap(LinearConstraint):  # type: ignore[misc]
        """Bounds on x alone: feed and joint velocities."""

        def __init__(self) -> None:
            super().__init__()
            self.discretization_type = DiscretizationType.Collocation
            self.dof = grid.d1.shape[1]
            self._format_string = "    speed cap\n"

        def compute_constraint_params(self, _path: Any, gridpoints: Array) -> tuple[Any, ...]:
            at = np.searchsorted(scaled, gridpoints)
            xbound = np.stack([np.zeros(len(at)), bound[at]], axis=1)
            return None, None, None, None, None, None, xbound

    acceleration = JointAccelerationConstraint(
        np.stack([-limits.acceleration, limits.acceleration], axis=1),
        discretization_scheme=DiscretizationType.Interpolation,
    )
    toppra.setup_logging("ERROR")
    algorithm = TOPPRA([SpeedCap(), acceleration], Path(), gridpoints=scaled, solver_wrapper="seidel")
    _acceleration, speed, _steps = algorithm.compute_parameterization(scale * np.sqrt(start), 0.0)
    code = algorithm.problem_data.return_code
    if speed is None or code != ParameterizationReturnCode.Ok or not np.isfinite(speed).all():
        raise RuntimeError(f"toppra found no profile: {code}")
    return np.asarray(speed, dtype=float) ** 2 / scale**2
