"""Decimals of a setpoint file: how many each column needs, and what fewer would cost."""

from decimal import Decimal
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ROUNDING_MM, ROUNDING_RAD, ROUNDING_SHARES
from verne_post.model.drives import Drive
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Column, Machine
from verne_post.model.setpoints import SetpointFormat

#: A double near 1000 has 13 decimals; beyond 12 the digits would be noise.
MAX_DECIMALS: Final = 12


def choose_setpoint_format(
    machine: Machine, cycle: float, decimals: int | None, *, accept_rounding: bool, drives: tuple[Drive, ...] = ()
) -> SetpointFormat:
    """Choose the decimals of every column.

    With ``decimals`` None, the noise of the differences, ``q / cycle``, ``2 q / cycle^2`` and ``4 q / cycle^3`` with q
    one unit of the last decimal, stays under ROUNDING_SHARES of the column's limits, and q under ROUNDING_MM or
    ROUNDING_RAD. Drives that take whole numbers get those.

    Raises
    ------
    InputError
        VP018 when the noise of given decimals, or of whole numbers, exceeds a limit and ``accept_rounding`` is False.
    """
    size = np.abs([column.factor for column in machine.columns])
    limits = machine.limits.bound_jerk(cycle)
    jerk = limits.jerk * size
    whole = np.array([drive.integer for drive in drives] or [False] * len(jerk))
    scale = np.array([drive.scale for drive in drives] or [1.0] * len(jerk))
    coarsest = size * [ROUNDING_MM if column.unit == "mm" else ROUNDING_RAD for column in machine.columns]
    for order, (share, limit) in enumerate(
        zip(ROUNDING_SHARES, (limits.velocity, limits.acceleration, limits.jerk), strict=True)
    ):
        coarsest = np.minimum(coarsest, share * limit * size * cycle ** (order + 1) / 2**order)
    needed = np.ceil(-np.log10(coarsest * scale)).astype(int)
    chosen = np.clip(needed, 0, MAX_DECIMALS) if decimals is None else np.full(len(jerk), decimals)
    chosen = np.where(whole, 0, chosen)
    fmt = SetpointFormat(cycle, tuple(int(d) for d in chosen), choose_time_decimals(cycle), drives)
    if accept_rounding:
        return fmt
    for index, (column, noise, limit) in enumerate(
        zip(machine.columns, estimate_rounding_noise(fmt)[1], jerk, strict=True)
    ):
        if noise > limit and (whole[index] or decimals is not None):
            text = (
                f"drives.{column.joint} wants whole numbers of {fmt.quanta[index]:g} {column.unit}: rounding"
                if whole[index]
                else f"--decimals {decimals}: rounding {name_column(column, drives, index)}"
            )
            remedy = "use --units joint" if whole[index] else "use --decimals auto"
            text += (
                f" alone makes a jerk of {noise:g} {column.unit}/s3, over "
                f"{'its limit' if np.isfinite(machine.limits.jerk[index]) else 'what its acceleration allows,'} "
                f"{limit:g}; {remedy}, or --accept-rounding"
            )
            raise make_input_error("VP018", text)
    return fmt


def name_column(column: Column, drives: tuple[Drive, ...], index: int) -> str:
    """Name of a joint's column in a setpoint file."""
    return f"{column.joint}_{drives[index].unit}" if drives else column.header


def choose_trusted_format(machine: Machine, seen: SetpointFormat, *, accept_rounding: bool) -> SetpointFormat:
    """Choose the rounding for which verification may make an allowance.

    Few decimals in a column may be coarse rounding, or zeros that were left out. Where they would excuse more jerk than
    the limit, the decimals of ``--decimals auto`` count instead, unless ``accept_rounding`` is True.
    """
    if accept_rounding:
        return seen
    fine_drives = tuple(replace(drive, integer=False) for drive in seen.drives)
    auto = choose_setpoint_format(machine, seen.cycle, None, accept_rounding=True, drives=fine_drives)
    jerk = machine.limits.bound_jerk(seen.cycle).jerk * np.abs([column.factor for column in machine.columns])
    too_coarse = estimate_rounding_noise(seen)[1] > jerk
    decimals = tuple(
        fine if bad else as_seen for fine, as_seen, bad in zip(auto.decimals, seen.decimals, too_coarse, strict=True)
    )
    return replace(seen, decimals=decimals)


def estimate_rounding_noise(fmt: SetpointFormat) -> tuple[Array, Array]:
    """Largest acceleration and jerk that rounding adds to each column's differences, mm or degrees."""
    return 2 * fmt.quanta / fmt.cycle**2, 4 * fmt.quanta / fmt.cycle**3


def choose_time_decimals(cycle: float) -> int:
    """Decimals of t_s: as many as the cycle needs."""
    exponent = Decimal(repr(cycle)).normalize().as_tuple().exponent
    return min(max(-int(exponent), 0), MAX_DECIMALS)


def round_setpoints(q: Array, machine: Machine, fmt: SetpointFormat) -> tuple[Array, Array | None]:
    """Round joint values to what will be written.

    Parameters
    ----------
    q : ndarray, shape (n, n_joints)
        mm and rad.

    Returns
    -------
    ndarray, shape (n, n_joints)
        The positions, mm and degrees, that the written numbers stand for.
    ndarray, shape (n, n_joints), or None
        The numbers; None where they are the positions themselves.
    """
    values = q * np.array([column.factor for column in machine.columns])
    for joint, drive in enumerate(fmt.drives):
        values[:, joint] = drive.find_numbers(values[:, joint])
    for joint, decimals in enumerate(fmt.decimals):
        values[:, joint] = np.round(values[:, joint], decimals)
    values = values + 0.0  # no negative zeros
    if not fmt.drives:
        return values, None
    return convert_positions(values, fmt), values


def convert_positions(numbers: Array, fmt: SetpointFormat) -> Array:
    """Convert numbers (n, n_joints) of a file to mm and degrees."""
    if not fmt.drives:
        return numbers
    return np.stack([drive.find_places(numbers[:, joint]) for joint, drive in enumerate(fmt.drives)], axis=1)
