"""Tool axes of cutter location text: when two of them, printed with few decimals, are the same one."""

from collections.abc import Sequence
from decimal import Decimal
from typing import Final

#: Sines and cosines of angles in degrees, and their products, are off by less than this.
_NOISE: Final = 1e-12


def find_half_step(axis: Sequence[float]) -> float:
    """Half of the last decimal with which an axis is printed: of the component that has most; 0 where all are whole."""
    decimals = max(-int(Decimal(repr(value)).normalize().as_tuple().exponent) for value in axis)
    return 0.5 * 10.0**-decimals if decimals > 0 else 0.0


def differ(axis: Sequence[float], other: Sequence[float], tolerance: float) -> bool:
    """True where a component of two tool axes differs by more than this."""
    return any(abs(a - b) > tolerance + _NOISE for a, b in zip(axis, other, strict=True))
