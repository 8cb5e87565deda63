"""Tables that machine files of every schema have, as the program has them: drives, vibration, stored positions."""

from typing import TYPE_CHECKING

import numpy as np

from verne_post.config.schema import DriveFile, HomeFile, VibrationFile
from verne_post.model.drives import Drive
from verne_post.model.findings import InputError, make_finding, make_input_error
from verne_post.model.machine import Column, Home, Limits
from verne_post.model.vibration import Mode, Vibration

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline


def convert_drives(
    files: dict[str, DriveFile] | None, columns: tuple[Column, ...], limits: Limits, file_name: str
) -> tuple[Drive, ...]:
    """The drives in the order of the joints; empty where the file names none.

    Raises
    ------
    InputError
        VP501: a joint without a drive, a drive without a joint, or lead errors that do not cover the travel.
    """
    if files is None:
        return ()
    joints = [column.joint for column in columns if column.driven]
    wrong = [
        f"{file_name}: drives.{name} is no joint of this machine; they are {', '.join(joints)}"
        for name in files
        if name not in joints
    ]
    wrong += [
        f"{file_name}: drives.{name} is missing: every joint needs its drive" for name in joints if name not in files
    ]
    if wrong:
        raise InputError(*(make_finding("VP501", text) for text in wrong))
    drives = []
    for column, low, high in zip(columns, limits.lower, limits.upper, strict=True):
        if not column.driven:
            drives.append(Drive(column.unit))
            continue
        file = files[column.joint]
        ends = sorted((float(low) * column.factor, float(high) * column.factor))
        error = (
            None
            if file.lead_error is None
            else _interpolate_errors(file.lead_error, ends, f"{file_name}: drives.{column.joint}.lead_error")
        )
        drives.append(Drive(file.unit, float(file.sign), file.zero, file.scale, file.integer, error))
    return tuple(drives)


def _interpolate_errors(table: list[list[float]], travel: list[float], where: str) -> "CubicSpline":
    """A cubic spline through the table: positions between its points must not jerk."""
    from scipy.interpolate import CubicSpline

    place, error = np.array(table).T
    endless = not np.isfinite(travel).all()
    if endless and not (place[-1] - place[0] == 360.0 and error[-1] == error[0]):
        raise make_input_error(
            "VP501",
            f"{where}: this joint has no limits; expected one turn of 360 degrees, with the same error at both ends",
        )
    if not endless and not (place[0] <= travel[0] and place[-1] >= travel[1]):
        raise make_input_error(
            "VP501",
            f"{where} reaches from {place[0]:g} to {place[-1]:g}; it must cover the travel from "
            f"{travel[0]:g} to {travel[1]:g}",
        )
    return CubicSpline(
        place, error, bc_type="periodic" if endless else "natural", extrapolate="periodic" if endless else True
    )


def convert_vibration(file: VibrationFile | None) -> Vibration | None:
    if file is None:
        return None
    return Vibration(tuple(Mode(*pair) for pair in file.modes), file.shaper)


def convert_home(file: HomeFile) -> Home:
    g28, g30, park = (None if pose is None else tuple(pose) for pose in (file.g28, file.g30, file.park))
    return Home(g28, g30, park)  # type: ignore[arg-type]
