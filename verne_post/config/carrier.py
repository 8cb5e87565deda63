"""[carrier] of machine files of schema 2: a parallel module with the wrist of a chain. Keys: docs/machine-file.md."""

from typing import Annotated, ClassVar, Final, Literal

import numpy as np
from msgspec import Meta

from verne_post.base.arrays import Array
from verne_post.config.schema import Cone, Point, Positive
from verne_post.config.sentences import Checks, Table
from verne_post.kinematics.chain.carried import CarriedMachine
from verne_post.kinematics.chain.machine import ChainMachine
from verne_post.kinematics.chain.sliding import SlidingMachine
from verne_post.kinematics.modules.central_leg import CentralLeg
from verne_post.kinematics.modules.rod_geometry import Rod
from verne_post.kinematics.modules.rods import RodsModule

#: The wrist's centre may be off the leg, and the gauge line off it, by this, mm: files give places with nine digits.
IN_LINE: Final = 1e-6


class StrutFile(Table, frozen=True, kw_only=True):
    """One of carrier.struts: its joints on the platform and on the base, and the joint whose value is its length."""

    platform: Point
    base: Point
    length: str


class CentralFile(Table, frozen=True, kw_only=True):
    """carrier.central: the middle of the universal joint, and its axis that is fixed to the base."""

    base: Point
    first_axis: Point


class CarrierRodFile(Table, frozen=True, kw_only=True):
    """A row of carrier.rods: joint on the platform, on the slider at 0, direction of the rail, length, actuator."""

    platform: Point
    slider: Point
    rail: Point
    rod: Positive
    by: str


def _check_struts(value: list[StrutFile] | None) -> None:
    if value is not None and len(value) != 3:
        raise ValueError(f"{len(value)} struts; a central leg leaves the platform three motions, so expected 3")


def _check_rods(value: list[CarrierRodFile] | None) -> None:
    if value is not None and len(value) != 6:
        raise ValueError(f"{len(value)} rods; a platform has six motions, so expected 6")


class CarrierFile(Table, frozen=True, kw_only=True):
    """[carrier]: three struts of variable length and a central leg, or six rods of fixed length on three sliders."""

    checks: ClassVar[Checks] = {"struts": _check_struts, "rods": _check_rods}

    kind: Literal["rods"]
    actuators: list[str]
    home: Point
    home_actuators_mm: Point | None = None
    rods: list[CarrierRodFile] | None = None
    struts: list[StrutFile] | None = None
    central: CentralFile | None = None
    largest_turn_deg: Annotated[float, Meta(gt=0, lt=90)] = 60.0
    smallest_singular_value: Positive
    smallest_drop_mm: Positive | None = None
    base_cone_deg: Cone | None = None
    platform_cone_deg: Cone | None = None

    def check_together(self) -> None:
        of_rods, of_struts = ("rods", "home_actuators_mm", "smallest_drop_mm"), ("struts", "central")
        wanted, other = (of_struts, of_rods) if self.rods is None else (of_rods, of_struts)
        missing = [key for key in wanted if getattr(self, key) is None]
        spare = [key for key in other if getattr(self, key) is not None]
        if missing or spare:
            raise ValueError(
                f"expected {', '.join(of_struts)} (struts of variable length), or {', '.join(of_rods)} (rods of fixed length on "
                f"sliders); {'missing: ' + ', '.join(missing) if missing else 'too many: ' + ', '.join(spare)}"
            )
        moved = [strut.length for strut in self.struts or ()] or [rod.by for rod in self.rods or ()]
        if (self.struts is not None and len(set(moved)) != len(moved)) or set(moved) != set(self.actuators):
            raise ValueError(
                f"{'the struts are' if self.struts else 'the rods are moved by'} {', '.join(moved)}, and actuators "
                f"{', '.join(self.actuators)}; expected each once"
            )
        if len(self.actuators) != 3:
            raise ValueError(
                f"{len(self.actuators)} actuators: expected 3; six that hold a platform alone (a hexapod) are not executed"
            )
        if self.central is not None and not any(self.central.first_axis):
            raise ValueError("central.first_axis = [0, 0, 0]: expected a direction")
        for k, rod in enumerate(self.rods or ()):
            if not any(rod.rail):
                raise ValueError(f"rods.{k}.rail = [0, 0, 0]: expected a direction")


def describe_refused_carrier(carrier: object, schema: object) -> str | None:
    """Why a [carrier] is refused as a whole, in a sentence; None where its keys are looked at one by one."""
    keys = carrier if isinstance(carrier, dict) else {}
    if schema == 2 and ("rods" in keys or "central" in keys):
        return None
    what = "carrier: what it describes"
    if "struts" in keys:
        what = "carrier.struts: struts of variable length without a central leg (a hexapod)"
    return (
        f"{what} is not executed; a carrier in a chain (schema 2) has three struts of variable length and a central leg, or six rods "
        "of fixed length on three sliders; over the tilting rotary table (schema 1) there are the kinds 'verne', 'serial', "
        "'linear_delta' and 'rods'"
    )


def build_carrier_machine(
    file: CarrierFile, chain: ChainMachine, to_polar: Array, part_zero: Array, names: tuple[str, str]
) -> CarriedMachine | SlidingMachine:
    """The machine of a rotary pair and its carrier; see :func:`build_carried_machine`."""
    if file.rods is None:
        return build_carried_machine(file, chain, to_polar, part_zero, names)
    rods = [Rod(rod.platform, rod.slider, rod.rail, rod.rod, rod.by) for rod in file.rods]
    sliders = file.home_actuators_mm or []
    module = RodsModule(file.home, sliders, rods, file.largest_turn_deg, tuple(file.actuators))
    if module.tilts:
        raise ValueError(
            "the rods of a slider do not stay parallel, so that the platform turns as it moves; in a chain the rods of each slider "
            "are parallel and equal; a platform that tilts about x is the [module] of a file of schema 1, kind = 'rods'"
        )
    cones = [cone for cone in (file.base_cone_deg, file.platform_cone_deg) if cone is not None]
    return SlidingMachine(chain, module, to_polar, part_zero, min(cones) if cones else None)


def build_carried_machine(
    file: CarrierFile, chain: ChainMachine, to_polar: Array, part_zero: Array, names: tuple[str, str]
) -> CarriedMachine:
    """The machine of a wrist on its carrier.

    Parameters
    ----------
    chain : ChainMachine
        The wrist, on linear axes.
    to_polar : ndarray, shape (3, 3)
        Turns directions of the base frame into the polar frame of the wrist.
    part_zero : ndarray, shape (3,)
        Base frame, mm.
    names : tuple of str
        Of the tilting and the turning joint.

    Raises
    ------
    ValueError
        In a sentence.
    """
    assert file.struts is not None
    assert file.central is not None
    struts = {strut.length: strut for strut in file.struts}
    ordered = [struts[name] for name in file.actuators]
    leg = CentralLeg(
        file.home, file.central.base, file.central.first_axis, [strut.platform for strut in ordered],
        [strut.base for strut in ordered], file.largest_turn_deg,
    )  # fmt: skip
    tilting, turning = names
    along = to_polar @ leg.frame[:, 2]
    platform = to_polar @ (np.array(file.home) - part_zero)
    if chain.pair.nutation is not None:
        raise ValueError(f"{tilting} and {turning} nutate: a nutating wrist on a carrier is not executed yet")
    if chain.pair.home_tilt != 0.0 or np.abs(np.cross(along, chain.axis)).max() > IN_LINE:
        raise ValueError(f"chain.axis is not along the axis of {turning} and the central leg at home: not executed yet")
    if np.linalg.norm(np.cross(chain.turn.through - platform, along)) > IN_LINE:
        raise ValueError(f"joints.{turning}.through is not on the central leg: a wrist beside it is not executed yet")
    reach = float((chain.tilt.through - platform) @ along)
    centre = platform + reach * along
    across = chain.tilt.through - centre
    if np.linalg.norm(across - across[0] * np.eye(3)[0]) > IN_LINE:
        raise ValueError(f"the axis of {tilting} does not cross the central leg: not executed yet")
    nose = float((centre - chain.gauge) @ chain.axis)
    if np.linalg.norm(centre - nose * chain.axis - chain.gauge) > IN_LINE:
        raise ValueError("chain.gauge is not on the line of the wrist's centre along chain.axis: not executed yet")
    return CarriedMachine(
        chain, leg, to_polar, part_zero, reach, nose, tuple(file.actuators), file.base_cone_deg, file.platform_cone_deg
    )
