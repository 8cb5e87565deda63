"""[as_built] of a machine file: how far the parts are from their nominal places, in this file or one that it names."""

from collections.abc import Callable
from typing import Annotated, Final

import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from verne_post.base.units import MILLI
from verne_post.config.sentences import Table, WrongTableError, check_table
from verne_post.config.toml_text import read_toml
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.kinematics.as_built.soundness import find_fault
from verne_post.kinematics.five_axis import HybridMachine
from verne_post.model.deviations import ENTRIES, Deviations, RodPlaces
from verne_post.model.findings import InputError, make_finding, make_input_error
from verne_post.model.machine import Limits

#: Deviations beyond this are typing errors or other units: parts are made to some tenths of a millimetre.
LARGEST_MM: Final = 20.0
LARGEST_MRAD: Final = 20.0

_Place = Annotated[float, Meta(ge=-LARGEST_MM, le=LARGEST_MM)]
_Direction = Annotated[float, Meta(ge=-LARGEST_MRAD, le=LARGEST_MRAD)]
_Point = Annotated[list[_Place], Meta(min_length=3, max_length=3)]
_Pair = Annotated[list[_Place], Meta(min_length=2, max_length=2)]
_Angles = Annotated[list[_Direction], Meta(min_length=2, max_length=2)]


class AsBuiltFile(Table, frozen=True, kw_only=True):
    """[as_built]: deviations from the nominal machine, mm and mrad; absent means zero."""

    source: Annotated[str, Meta(min_length=1), "origin of the values: a calibration, a seed"]
    platform_ends_mm: Annotated[
        Annotated[list[_Point], Meta(min_length=6, max_length=6)] | None,
        "joint centres on the platform, platform frame (z down, turned with the platform)",
    ] = None
    slider_ends_mm: Annotated[
        Annotated[list[_Point], Meta(min_length=6, max_length=6)] | None,
        "joint centres on the sliders at rho = 0, base frame",
    ] = None
    rod_lengths_mm: Annotated[
        Annotated[list[_Place], Meta(min_length=6, max_length=6)] | None, "lengths of the rods"
    ] = None
    guides_mrad: Annotated[
        Annotated[list[_Angles], Meta(min_length=3, max_length=3)] | None,
        "x and y of the direction (x, y, 1) of each guide, mrad",
    ] = None
    tilt_axis_mm: Annotated[_Pair | None, "y and z by which the tilt axis lies off the pivot, upright frame"] = None
    tilt_axis_mrad: Annotated[
        _Angles | None, "y and z of the direction (1, y, z) of the tilt axis, upright frame, mrad"
    ] = None
    rotary_axis_mm: Annotated[
        _Pair | None, "x and y by which the rotary axis lies off rotary_offset, tilt frame at A = 0"
    ] = None
    rotary_axis_mrad: Annotated[
        _Angles | None, "x and y of the direction (x, y, 1) of the rotary axis, tilt frame at A = 0, mrad"
    ] = None
    spindle_axis_mrad: Annotated[
        _Angles | None, "x and y of the direction (x, y, 1) of the spindle, platform frame, mrad"
    ] = None

    def build_deviations(self) -> Deviations:
        """The deviations, mm and rad."""
        given = {name: getattr(self, key) for name, (key, _shape, _angle) in ENTRIES.items()}
        return replace(
            Deviations.build_nominal(),
            **{
                name: np.array(value, dtype=float) * (MILLI if ENTRIES[name][2] else 1.0)
                for name, value in given.items()
                if value is not None
            },
        )


def read_as_built(table: object, file_name: str, read: Callable[[str], bytes]) -> tuple[AsBuiltFile, bytes]:
    """The table, from the machine file or from the file that its only key ``file`` names; and the bytes of that file.

    Raises
    ------
    InputError
        VP501 with every mistake.
    """
    raw = b""
    if isinstance(table, dict) and "file" in table:
        name = table["file"]
        if not isinstance(name, str) or len(table) > 1:
            raise _make_error(
                file_name,
                'as_built.file names a file with an [as_built] table, such as "as-built.toml"; '
                "then [as_built] has no other key here",
            )
        raw = read(name)
        try:
            data = read_toml(raw)
        except ValueError as error:
            raise _make_error(name, str(error)) from None
        if list(data) != ["as_built"]:
            raise _make_error(name, "expected one table, [as_built], and nothing else")
        table, file_name = data["as_built"], name
    if not isinstance(table, dict):
        raise _make_error(file_name, f"as_built = {table!r}: expected a table of keys")
    try:
        return check_table(AsBuiltFile, table, "[as_built]", "as_built"), raw
    except WrongTableError as error:
        raise InputError(*(make_finding("VP501", f"{file_name}: {text}") for text in error.sentences)) from None


def build_as_built(
    nominal: HybridMachine, places: RodPlaces, file: AsBuiltFile, axis_error_deg: float, limits: Limits, file_name: str
) -> AsBuiltMachine:
    """The as-built machine; refused where it does not work in the nominal machine's working mode."""
    machine = AsBuiltMachine(nominal, places, file.build_deviations(), axis_error_deg)
    travel = np.stack([limits.lower[:3], limits.upper[:3]], axis=1)
    fault = find_fault(machine, travel, limits.serial_singularity)
    if fault is not None:
        raise _make_error(
            file_name,
            f"as_built: with these deviations the rods do not close where the nominal machine's do; see {fault}",
        )
    return machine


def _make_error(file_name: str, text: str) -> InputError:
    return make_input_error("VP501", f"{file_name}: {text}")
