"""What every module answers when asked for all its solutions, and what modules that never tilt have in common."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class InverseSolution:
    """One inverse solution: tilt (rad), configuration indices s1, s2, ..., actuators (mm).

    ``refused`` is None for the one that the machine uses, else the reason by geometry.
    """

    alpha: float
    signs: tuple[int, ...]
    rho: tuple[float, float, float]
    refused: str | None


@dataclass(frozen=True)
class ForwardSolution:
    """One assembly mode: position of P (mm), tilt (rad), and why it is refused (None for the one in use)."""

    position: tuple[float, float, float]
    alpha: float
    refused: str | None


def upright_position(pivot: Array, gauge: Array) -> Array:
    """Platform point (..., 3) of a module that never tilts: ``pivot + F gauge``, ``F = diag(1, -1, -1)``; base frame."""
    return np.asarray(gauge, dtype=float) * [1.0, -1.0, -1.0] + np.asarray(pivot, dtype=float)


def triple(values: Array) -> tuple[float, float, float]:
    """Three numbers of an array (3,)."""
    a, b, c = (float(value) for value in values)
    return a, b, c
