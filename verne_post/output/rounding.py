"""Decimals of a setpoint file: how many each column needs, and what fewer would cost."""

from decimal import Decimal
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.tolerances import ROUNDING_JERK_SHARE
from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Machine
from verne_post.model.setpoints import SetpointFormat

Array = NDArray[np.float64]

#: A double near 1000 has 13 decimals; beyond 12 the digits would be noise.
MAX_DECIMALS: Final = 12


def setpoint_format(machine: Machine, cycle: float, decimals: int | None, *, accept_rounding: bool) -> SetpointFormat:
    """Choose the decimals of every column.

    With ``decimals`` None, the noise of the third difference, ``4 q / cycle^3`` with q one unit of
    the last decimal, stays under 1 % of the column's jerk limit.

    Raises
    ------
    InputError
        VP018 when the noise of given decimals exceeds a limit itself and ``accept_rounding`` is False.
    """
    jerk = machine.limits.jerk * np.abs([column.factor for column in machine.columns])
    needed = np.ceil(-np.log10(ROUNDING_JERK_SHARE * jerk * cycle**3 / 4)).astype(int)
    chosen = np.clip(needed, 0, MAX_DECIMALS) if decimals is None else np.full(len(jerk), decimals)
    fmt = SetpointFormat(cycle, tuple(int(d) for d in chosen), time_decimals(cycle))
    if decimals is not None and not accept_rounding:
        for column, noise, limit in zip(machine.columns, rounding_noise(machine, fmt)[1], jerk, strict=True):
            if noise > limit:
                text = (
                    f"--decimals {decimals}: rounding {column.header} alone makes a jerk of {noise:g} {column.unit}/s3, "
                    f"over its limit {limit:g}; use --decimals auto, or --accept-rounding"
                )
                raise InputError(finding("VP018", text))
    return fmt


def trusted_format(machine: Machine, seen: SetpointFormat, *, accept_rounding: bool) -> SetpointFormat:
    """How a file was rounded, as far as verification may allow for it.

    Where the decimals seen in a column would excuse more jerk than its limit, they excuse nothing, unless
    ``accept_rounding`` says that they may: few decimals may also just be zeros left out.
    """
    if accept_rounding:
        return seen
    auto = setpoint_format(machine, seen.cycle, None, accept_rounding=False)
    jerk = machine.limits.jerk * np.abs([column.factor for column in machine.columns])
    coarse = rounding_noise(machine, seen)[1] > jerk
    decimals = tuple(
        fine if bad else as_seen for fine, as_seen, bad in zip(auto.decimals, seen.decimals, coarse, strict=True)
    )
    return SetpointFormat(seen.cycle, decimals, seen.time_decimals)


def rounding_noise(machine: Machine, fmt: SetpointFormat) -> tuple[Array, Array]:
    """Largest acceleration and jerk that rounding adds to each column's differences, file units."""
    quantum = 10.0 ** -np.array(fmt.decimals, dtype=float)
    return 2 * quantum / fmt.cycle**2, 4 * quantum / fmt.cycle**3


def time_decimals(cycle: float) -> int:
    """As many decimals as the cycle needs."""
    exponent = Decimal(repr(cycle)).normalize().as_tuple().exponent
    return min(max(-int(exponent), 0), MAX_DECIMALS)


def rounded(q: Array, machine: Machine, fmt: SetpointFormat) -> Array:
    """Joint values (n, n_joints) in mm and rad -> file units, rounded as they will be written."""
    values = q * np.array([column.factor for column in machine.columns])
    for joint, decimals in enumerate(fmt.decimals):
        values[:, joint] = np.round(values[:, joint], decimals)
    return values + 0.0  # no negative zeros
