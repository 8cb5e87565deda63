"""A plain serial spindle: three Cartesian axes that carry an upright spindle over the table.

The axes x, y, z have the directions of the ``upright`` frame: right-handed, z away from the table. They say where P
stands, seen from a configured zero: ``(x, y, z) = F (P - zero)`` with ``F = diag(1, -1, -1)``. Base frame: z points
down; mm, rad. The tilt alpha is 0 everywhere.
"""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.kinematics.modules.solutions import make_triple, place_upright
from verne_post.model.protocols import ForwardSolution, InverseSolution, Margin

_UPRIGHT = np.array([1.0, -1.0, -1.0])


class SerialModule(Struct, frozen=True):
    """Three Cartesian axes; ``zero`` is where P stands at x = y = z = 0, base frame, mm."""

    zero: Sequence[float]

    actuators: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    # --- one solution each way ---------------------------------------------------------------

    def inverse(self, position: Array) -> tuple[Array, Array, Mask]:
        """Axis positions x, y, z for a platform position: ``F (P - zero)``; not ok only where P is not finite."""
        rho = (np.asarray(position, dtype=float) - self.zero) * _UPRIGHT
        return _mark_finite(rho)

    def solve_coupled(self, pivot: Array, gauge: Array) -> tuple[Array, Array, Mask]:
        """Axis positions for ``pivot + F gauge`` (3,), (..., 3); as :meth:`inverse`, because nothing tilts."""
        return self.inverse(place_upright(pivot, gauge))

    def forward(self, rho: Array) -> tuple[Array, Array, Mask]:
        """P (..., 3) in the base frame, alpha and ok for axis positions (..., 3): ``zero + F (x, y, z)``, mm."""
        return _mark_finite(np.asarray(rho, dtype=float) * _UPRIGHT + self.zero)

    def explain_unreachable(self, pivot: Array, gauge: Array) -> list[str]:
        """Finding codes of poses (m, 3) without a solution: only those that are no numbers."""
        return ["VP110"] * len(gauge)

    # --- every solution ----------------------------------------------------------------------

    def inverse_all(self, position: Array) -> list[InverseSolution]:
        """The only solution of one position (3,)."""
        rho, _alpha, ok = self.inverse(position)
        return [InverseSolution(0.0, (), make_triple(rho), None)] if ok else []

    def forward_all(self, rho: Array) -> list[ForwardSolution]:
        """The only position of one set of axis positions (3,)."""
        position, _alpha, ok = self.forward(rho)
        return [ForwardSolution(make_triple(position), 0.0, None)] if ok else []

    def solve_coupled_all(self, pivot: Array, gauge: Array) -> list[InverseSolution]:
        """As :meth:`inverse_all` for ``pivot + F gauge``, because nothing tilts."""
        return self.inverse_all(place_upright(pivot, gauge))

    # --- velocities ----------------------------------------------------------------------------

    def find_jacobians(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Derivatives of ``F (P - zero) - (x, y, z) = 0`` and ``alpha = 0``: (..., 4, 4) by pose, (..., 4, 3) by q."""
        shape = np.shape(rho)[:-1]
        parallel = np.broadcast_to(np.diag([*_UPRIGHT, 1.0]), (*shape, 4, 4))
        serial = np.broadcast_to(-np.eye(4, 3), (*shape, 4, 3))
        return parallel, serial

    def measure_conditioning(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """1 and 1, each (...): the axes are at right angles everywhere."""
        ones = np.ones(np.shape(rho)[:-1])
        return ones, ones

    # --- margins -----------------------------------------------------------------------------

    def find_geometry_margins(self, position: Array, alpha: Array) -> Array:
        """No margins, shape (..., 0): a serial spindle has no singularity of its own."""
        return np.empty((*np.shape(position)[:-1], 0))

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """None, whatever the thresholds: there are no rods."""
        return ()


def _mark_finite(point: Array) -> tuple[Array, Array, Mask]:
    """A mapped point with tilt 0 and ok; NaN throughout where a coordinate is not finite."""
    ok = np.asarray(np.isfinite(point).all(axis=-1))
    return np.where(ok[..., None], point, np.nan), np.where(ok, 0.0, np.nan), ok
