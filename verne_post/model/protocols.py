"""What the rooms expect of each other, so that none has to import another.

Coordinates are given to gcode and toolpath, the kinematics to pipeline and verify.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from verne_post.model.contour import Contour
from verne_post.model.moves import Frame

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Margin:
    """A geometric margin of a module: positive is good.

    Attributes
    ----------
    name : str
        What it measures.
    code : str
        Finding code when it is too small.
    axis : str or None
        The joint concerned.
    unit : str
    error_below, warn_below : float
        Thresholds.
    """

    name: str
    code: str
    axis: str | None
    unit: str
    error_below: float
    warn_below: float


class PoseFunction(Protocol):
    """Evaluates the geometry of a contour."""

    def __call__(self, contour: Contour, segment: NDArray[np.integer], w: Array) -> tuple[Array, Array]:
        """Tip (n, 3) and nominal angles (n, 2) at parameter w (n,) of segments (n,)."""


class ModuleSolution(Protocol):
    """One of several inverse solutions of a module."""

    @property
    def alpha(self) -> float:
        """Lean of the platform, rad."""

    @property
    def signs(self) -> tuple[int, ...]:
        """Configuration indices."""

    @property
    def rho(self) -> tuple[float, ...]:
        """Actuators, mm."""

    @property
    def refused(self) -> str | None:
        """None for the one in use, else why not."""


class ParallelModule(Protocol):
    """Kinematics of the spindle carrier. Positions in the base frame (z down), mm.

    The platform may lean about x by an angle alpha that follows from its position.
    """

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of the actuated joints."""

    def inverse(self, position: Array) -> tuple[Array, Array, Mask]:
        """(..., 3) -> actuators (..., 3), alpha (...), ok (...), in the working mode."""

    def forward(self, rho: Array) -> tuple[Array, Array, Mask]:
        """(..., 3) -> position (..., 3), alpha (...), ok (...), in the working mode."""

    def inverse_leaning(self, pivot: Array, gauge: Array) -> tuple[Array, Array, Mask]:
        """Solve for a platform point that turns with the platform's own lean.

        The platform point is ``pivot + F Rx(alpha) gauge`` with ``F = diag(1, -1, -1)``.

        Parameters
        ----------
        pivot : ndarray, shape (3,)
            Base frame, mm.
        gauge : ndarray, shape (..., 3)
            Upright frame at alpha = 0, mm.

        Returns
        -------
        rho, alpha, ok
        """

    def why_not(self, pivot: Array, gauge: Array) -> list[str]:
        """Finding codes for poses (m, 3) without a solution in the working mode."""

    def inverse_all(self, position: Array) -> Sequence[ModuleSolution]:
        """All real inverse solutions of one position (3,), with the reason by geometry why each is refused."""

    def geometry_margins(self, position: Array, alpha: Array) -> Array:
        """Margins (..., m) of solved poses, in the order of :meth:`margin_names`."""

    def margin_names(self, serial_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`geometry_margins` returns, with thresholds."""


@runtime_checkable
class Identifiable(Protocol):
    """A module whose lengths can be identified: its loop equations may be asked with any lengths."""

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of the actuated joints, m of them."""

    @property
    def length_names(self) -> tuple[str, ...]:
        """Names of the p lengths: keys of [module], and attributes of the module (mm)."""

    @property
    def signed_lengths(self) -> frozenset[str]:
        """Those that may be negative."""

    def loop_equations(self, lengths: Array, rho: Array, pose: Array) -> tuple[Array, Array, Array, Array]:
        """Misfits of the loops (n, e), mm; their derivatives by lengths (n, e, p), actuators (n, e, m), pose (n, e, 4).

        Lengths (p,), actuators (n, m), pose (n, 4): x, y, z in the base frame (mm) and the lean alpha (rad).
        """


@runtime_checkable
class IsoAlpha(Protocol):
    """A module whose places of equal lean are closed curves in x and y."""

    def iso_alpha_ellipse(self, alpha: float, turn: Array) -> Array:
        """Points (n, 2) of P at which the platform may lean by alpha or -alpha, by the parameter turn (n,)."""


class FiveAxis(Protocol):
    """The whole machine: parallel module and tilting rotary table. Table frame, workpiece sense."""

    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Pose -> (q, ok)."""

    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Joints -> (tip, axis, ok)."""

    def solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """Tip (..., 3) and nominal angles (..., 2) -> (q, position (..., 3), alpha, ok); A + alpha and C as given."""

    def nominal(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Joints -> (tip (..., 3), nominal angles (..., 2), ok)."""

    def why_not(self, tip: Array, angles: Array, tool_length: Array | float) -> list[str]:
        """Finding codes of poses (m, 3), (m, 2) that :meth:`solve` cannot solve."""


class Coordinates(Protocol):
    """What program coordinates mean: the maps between program and machine coordinates.

    Points are nine-vectors X Y Z A B C U V W, shape (..., 9), mm and degrees, file sense.
    """

    def to_machine(self, program: Array, frame: Frame) -> Array:
        """Program coordinates -> machine coordinates."""

    def to_program(self, machine: Array, frame: Frame) -> Array:
        """Machine coordinates -> program coordinates."""

    def displacement(self, vector: Array, frame: Frame) -> Array:
        """Turn displacements (..., 3) of the program into the directions of the work origin."""


class TableCoordinates(Coordinates, Protocol):
    """Coordinates of a real machine: they also know where the tool is on the table."""

    @property
    def axes(self) -> str:
        """Letters of the axes that the machine has."""

    def to_table(self, program: Array, frame: Frame) -> tuple[Array, Array]:
        """Program (..., 9) -> tip in the table frame (..., 3), nominal angles (..., 2) rad, workpiece sense."""

    def from_table(self, tip: Array, angles: Array, frame: Frame) -> Array:
        """Inverse of :meth:`to_table`: program coordinates (..., 9)."""

    def to_work(self, point: Array, axis: Array, frame: Frame) -> tuple[Array, Array]:
        """A point and a direction (..., 3) of the table frame in the work frame."""

    def work_origin(self, offset_mm: tuple[float, float, float]) -> tuple[float, float, float]:
        """Origin in machine coordinates of a work offset o given in the table frame."""
