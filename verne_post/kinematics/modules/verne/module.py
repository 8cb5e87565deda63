"""The parallel module of the VERNE: three vertical sliders, six rods, a platform that tilts.

What each function computes stands in a file of its own, as a function of the lengths (:class:`VerneGeometry`).
"""

from functools import cached_property
from typing import ClassVar

import numpy as np

from verne_post.base.arrays import Array
from verne_post.kinematics.modules.solutions import build_determinant_margin, drop_margins
from verne_post.kinematics.modules.verne import assembly_modes, loops, rods, working_modes
from verne_post.kinematics.modules.verne.forward import solve_forward
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.kinematics.modules.verne.inverse import explain_unreachable, solve_inverse, solve_inverse_coupled
from verne_post.model.protocols import Margin


class VerneModule(VerneGeometry, frozen=True, dict=True):
    """``ParallelModule``, ``Identifiable``, ``IsoAlpha`` and ``Drawable``; lengths as in :class:`VerneGeometry`."""

    length_names: ClassVar[tuple[str, ...]] = loops.LENGTHS
    signed_lengths: ClassVar[frozenset[str]] = loops.SIGNED

    # --- one solution, in the working mode -----------------------------------------------------

    inverse = solve_inverse
    solve_coupled = solve_inverse_coupled
    explain_unreachable = explain_unreachable
    forward = solve_forward

    # --- every solution --------------------------------------------------------------------------

    inverse_all = working_modes.inverse_all
    solve_coupled_all = working_modes.solve_coupled_all
    trace_iso_alpha = working_modes.trace_iso_alpha
    forward_all = assembly_modes.forward_all
    forward_modes = assembly_modes.find_forward_modes

    # --- rods: velocities, pictures, identification ------------------------------------------------

    find_jacobians = rods.compute_rod_jacobians
    measure_conditioning = rods.measure_conditioning
    sketch = rods.sketch
    evaluate_loops = staticmethod(loops.evaluate_loops)

    # --- margins -----------------------------------------------------------------------------------

    def find_geometry_margins(self, position: Array, alpha: Array) -> Array:
        """Vertical drops of the three legs (mm), R1 cos(alpha) - r1 (mm), scaled parallel determinant; shape (..., 5).

        The determinant counts positive on the side of the middle of the workspace.
        """
        c, s = np.cos(alpha), np.sin(alpha)
        drops = np.sqrt(np.maximum(self.find_radicands(position[..., 0], position[..., 1], c), 0.0))
        determinant = self._determinant_side * rods.compute_parallel_determinant(self, position, (c, s), drops)
        return np.stack([drops[0], drops[1], drops[2], self.R1 * c - self.r1, determinant], axis=-1)

    @cached_property
    def _determinant_side(self) -> float:
        """Sign of the parallel determinant in the middle of the workspace."""
        x, _drop = self.find_workspace_middle()
        middle, upright = np.array([x, 0.0, 0.0]), (np.array(1.0), np.array(0.0))
        drops = np.sqrt(np.maximum(self.find_radicands(middle[0], middle[1], upright[0]), 0.0))
        return 1.0 if rods.compute_parallel_determinant(self, middle, upright, drops) >= 0 else -1.0

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` measures, with thresholds (mm; the determinant has no unit)."""
        crossing = Margin("R1 cos(alpha) - r1", "VP201", None, "mm", 0.0, 0.0)
        return (
            *drop_margins(self.actuators, serial_singularity),
            crossing,
            build_determinant_margin(parallel_singularity),
        )
