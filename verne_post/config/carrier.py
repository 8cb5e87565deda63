"""[carrier] of machine files of schema 2: a parallel module in a chain, or six legs. Keys: docs/machine-file.md."""

from typing import Annotated, ClassVar, Final, Literal

import numpy as np
from msgspec import Meta

from verne_post.base.arrays import Array
from verne_post.base.units import RAD_PER_DEG
from verne_post.config.schema import Cone, Number, Point, Positive, expect_direction
from verne_post.config.sentences import Checks, Table
from verne_post.kinematics.chain.carried import CarriedMachine
from verne_post.kinematics.chain.hexapod import HexapodMachine
from verne_post.kinematics.chain.machine import ChainMachine
from verne_post.kinematics.chain.sliding import SlidingMachine
from verne_post.kinematics.checks.bodies import Clearance
from verne_post.kinematics.modules.central_leg import CentralLeg
from verne_post.kinematics.modules.rod_geometry import Rod
from verne_post.kinematics.modules.rods import RodsModule
from verne_post.kinematics.modules.six_legs import SixLegs
from verne_post.model.machine import Bodies

#: The wrist's centre may be off the leg, and the gauge line off it, by this, mm: files give places with nine digits.
IN_LINE: Final = 1e-6


class StrutFile(Table, frozen=True, kw_only=True):
    """One of carrier.struts: its joints on the platform and on the base, and the joint whose value is its length."""

    platform: Annotated[Point, "joint on the platform, seen from P, mm"]
    base: Annotated[Point, "joint on the base, mm"]
    length: Annotated[str, "name of the joint that is the strut's length"]


class CentralFile(Table, frozen=True, kw_only=True):
    """carrier.central: the middle of the universal joint, and its axis that is fixed to the base."""

    base: Annotated[Point, "middle of the leg's universal joint, mm"]
    first_axis: Annotated[Point, "direction of its axis that is fixed to the base"]


class CarrierRodFile(Table, frozen=True, kw_only=True):
    """A row of carrier.rods: joint on the platform, on the slider at 0, direction of the rail, length, actuator."""

    platform: Annotated[Point, "joint on the platform, seen from P, mm"]
    slider: Annotated[Point, "joint on the slider at 0, mm"]
    rail: Annotated[Point, "direction of the rail"]
    rod: Annotated[Positive, "length of the rod, mm"]
    by: Annotated[str, "name of the slider"]


def _check_rods(value: list[CarrierRodFile] | None) -> None:
    if value is not None and len(value) != 6:
        raise ValueError(f"{len(value)} rods; a platform has six motions, so expected 6")


class CarrierFile(Table, frozen=True, kw_only=True):
    """[carrier]: three struts and a central leg; six rods on three sliders; six struts; or six rods and sliders."""

    checks: ClassVar[Checks] = {"rods": _check_rods}

    kind: Annotated[Literal["rods"], "kind of carrier"]
    actuators: Annotated[list[str], "names of the joints of struts or sliders, in the order of the columns"]
    home: Annotated[Point, "platform point P at home, mm"]
    home_actuators_mm: Annotated[
        list[Number] | None, "approximate sliders at home; they choose the side of each rod"
    ] = None
    rods: Annotated[list[CarrierRodFile] | None, "the six rods"] = None
    struts: Annotated[list[StrutFile] | None, "the struts"] = None
    central: Annotated[CentralFile | None, "the central leg"] = None
    rod_diameter_mm: Annotated[Positive | None, "of the legs of a hexapod, which must not meet"] = None
    spare_turn_deg: Annotated[
        Annotated[float, Meta(ge=-180, le=180)] | None,
        "turn about the tool axis at home, beside the shortest turn from home",
    ] = None
    largest_turn_deg: Annotated[
        float, Meta(gt=0, lt=90), "turn from home beyond which the module is in another assembly mode"
    ] = 60.0
    smallest_singular_value: Annotated[Positive, "smallest measure of the Jacobian of rods or struts"]
    smallest_drop_mm: Annotated[Positive | None, "smallest drop of a rod along its rail"] = None
    base_cone_deg: Annotated[
        Cone | None, "how far a rod or strut may turn from its direction at home, at the base or slider"
    ] = None
    platform_cone_deg: Annotated[
        Cone | None, "how far a rod or strut may turn from its direction at home, at the platform"
    ] = None

    @property
    def is_hexapod(self) -> bool:
        """Six actuators hold the platform alone."""
        return len(self.actuators) == 6

    def check_together(self) -> None:
        if len(self.actuators) not in {3, 6}:
            raise ValueError(
                f"{len(self.actuators)} actuators: expected 3 that carry a rotary pair, or 6 that hold the "
                "platform alone"
            )
        of_rods = {"rods", "home_actuators_mm", "smallest_drop_mm"}
        wanted = {"struts"} if self.rods is None else of_rods
        other = of_rods - wanted if self.rods is None else {"struts"}
        if self.is_hexapod:
            other = other | {"central"}
        else:
            wanted = wanted | {"central"} if self.rods is None else wanted
            other = (other | {"central", "rod_diameter_mm", "spare_turn_deg"}) - wanted
        missing = sorted(key for key in wanted if getattr(self, key) is None)
        spare = sorted(key for key in other if getattr(self, key) is not None)
        if missing or spare:
            raise ValueError(
                f"{len(self.actuators)} actuators with {'struts' if self.rods is None else 'rods'} need "
                f"{', '.join(sorted(wanted))}, and do not take {', '.join(sorted(other))}; "
                f"{'missing: ' + ', '.join(missing) if missing else 'too many: ' + ', '.join(spare)}"
            )
        moved = [strut.length for strut in self.struts or ()] or [rod.by for rod in self.rods or ()]
        each = self.struts is not None or self.is_hexapod
        if (each and len(set(moved)) != len(moved)) or set(moved) != set(self.actuators):
            raise ValueError(
                f"{'the struts are' if self.struts else 'the rods are moved by'} {', '.join(moved)}, and actuators "
                f"{', '.join(self.actuators)}; expected each once"
            )
        if self.home_actuators_mm is not None and len(self.home_actuators_mm) != len(self.actuators):
            raise ValueError(
                f"home_actuators_mm has {len(self.home_actuators_mm)} values for {len(self.actuators)} "
                "actuators; expected one each"
            )
        if self.central is not None:
            expect_direction("central.first_axis", self.central.first_axis)
        for k, rod in enumerate(self.rods or ()):
            expect_direction(f"rods, value {k + 1}.rail", rod.rail)


def describe_refused_carrier(carrier: object, schema: object) -> str | None:
    """Why a [carrier] is refused as a whole, in a sentence; None where its keys are looked at one by one."""
    keys = carrier if isinstance(carrier, dict) else {}
    if schema == 2 and ("rods" in keys or "struts" in keys):
        return None
    return (
        "[carrier], the platform of a parallel machine, belongs to schema 2, and has three struts and a central leg, "
        "six rods on three sliders, six struts, or six rods on six sliders: expected its key struts or rods; a machine "
        "over a tilting rotary table (schema 1) has kind = 'verne', 'serial', 'linear_delta' or 'rods' in its place"
    )


def build_carrier_machine(
    file: CarrierFile, chain: ChainMachine, to_polar: Array, part_zero: Array, names: tuple[str, str]
) -> CarriedMachine | SlidingMachine | HexapodMachine:
    """The machine of a rotary pair and its carrier, or of six legs; see :func:`build_carried_machine`."""
    if file.is_hexapod:
        return _build_hexapod(file, chain, to_polar, part_zero)
    if file.rods is None:
        return build_carried_machine(file, chain, to_polar, part_zero, names)
    rods = [Rod(rod.platform, rod.slider, rod.rail, rod.rod, rod.by) for rod in file.rods]
    sliders = file.home_actuators_mm or []
    module = RodsModule(file.home, sliders, rods, file.largest_turn_deg, tuple(file.actuators), "carrier.rods")
    if module.tilts:
        raise ValueError(
            "the rods of a slider do not stay parallel, so that the platform turns as it moves; in a chain "
            "the rods of each slider "
            "are parallel and equal; a platform that tilts about x is the [module] of a file of schema 1, kind = 'rods'"
        )
    cones = [cone for cone in (file.base_cone_deg, file.platform_cone_deg) if cone is not None]
    return SlidingMachine(chain, module, to_polar, part_zero, min(cones) if cones else None)


def _build_hexapod(file: CarrierFile, chain: ChainMachine, to_polar: Array, part_zero: Array) -> HexapodMachine:
    """The machine of six legs, in the order of the actuators."""
    names = tuple(file.actuators)
    if file.rods is None:
        struts = {strut.length: strut for strut in file.struts or ()}
        joints = [(struts[name].platform, struts[name].base) for name in names]
        rails = rods = None
        key, moved = "struts", [strut.length for strut in file.struts or ()]
    else:
        ordered = [{rod.by: rod for rod in file.rods}[name] for name in names]
        joints = [(rod.platform, rod.slider) for rod in ordered]
        rails, rods = [rod.rail for rod in ordered], [rod.rod for rod in ordered]
        key, moved = "rods", [rod.by for rod in file.rods]
    legs = SixLegs(
        file.home,
        [end for end, _foot in joints],
        [foot for _end, foot in joints],
        file.largest_turn_deg,
        rails,
        rods,
        file.home_actuators_mm,
        [f"carrier.{key}, value {moved.index(name) + 1}" for name in names],
    )
    return HexapodMachine(
        chain,
        legs,
        to_polar,
        part_zero,
        RAD_PER_DEG * (file.spare_turn_deg or 0.0),
        names,
        file.base_cone_deg,
        file.platform_cone_deg,
    )


def build_leg_clearance(file: CarrierFile, machine: HexapodMachine) -> Clearance | None:
    """Distances of the legs from each other, capsules of the diameter of the file; None where it has none."""
    if file.rod_diameter_mm is None:
        return None
    bodies = Bodies(minimum=0.0, rod_radius=np.full(6, 0.5 * file.rod_diameter_mm))
    return Clearance(bodies, machine, machine.nose_offset, machine.spindle, 0.0)


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
        file.home,
        file.central.base,
        file.central.first_axis,
        [strut.platform for strut in ordered],
        [strut.base for strut in ordered],
        file.largest_turn_deg,
    )
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
