"""[carrier] of machine files of schema 2: a parallel module that carries the wrist of a chain. docs/machine-file.md has the keys."""

from typing import Annotated, ClassVar, Final, Literal

import numpy as np
from msgspec import Meta

from verne_post.base.arrays import Array
from verne_post.config.schema import Cone, Point, Positive
from verne_post.config.sentences import Checks, Table
from verne_post.kinematics.chain.carried import CarriedMachine
from verne_post.kinematics.chain.machine import ChainMachine
from verne_post.kinematics.modules.central_leg import CentralLeg

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


def _check_struts(value: list[StrutFile]) -> None:
    if len(value) != 3:
        raise ValueError(f"{len(value)} struts; a central leg leaves the platform three motions, so expected 3")


class CarrierFile(Table, frozen=True, kw_only=True):
    """[carrier]: struts of variable length and a central leg."""

    checks: ClassVar[Checks] = {"struts": _check_struts}

    kind: Literal["rods"]
    actuators: list[str]
    home: Point
    struts: list[StrutFile]
    central: CentralFile
    largest_turn_deg: Annotated[float, Meta(gt=0, lt=90)] = 60.0
    smallest_singular_value: Positive
    base_cone_deg: Cone | None = None
    platform_cone_deg: Cone | None = None

    def check_together(self) -> None:
        lengths = [strut.length for strut in self.struts]
        if sorted(lengths) != sorted(self.actuators) or len(set(lengths)) != len(lengths):
            raise ValueError(
                f"the struts are {', '.join(lengths)}, and actuators {', '.join(self.actuators)}; expected each once"
            )
        if not any(self.central.first_axis):
            raise ValueError("central.first_axis = [0, 0, 0]: expected a direction")


#: Keys of carriers that are described elsewhere but not executed here, and what they ask for.
_NOT_EXECUTED: Final = {
    "rods": "rods of fixed length; three sliders on six of them are the [module] of a file of schema 1, kind = 'rods'",
    "struts": "struts of variable length without a central leg (a hexapod)",
}


def describe_refused_carrier(carrier: object, schema: object) -> str | None:
    """Why a [carrier] is refused as a whole, in a sentence; None where its keys are looked at one by one."""
    keys = carrier if isinstance(carrier, dict) else {}
    if schema == 2 and "central" in keys and "rods" not in keys:
        return None
    what = next(
        (f"carrier.{key}: {text}" for key, text in _NOT_EXECUTED.items() if key in keys), "carrier: what it describes"
    )
    return (
        f"{what} is not executed; a carrier in a chain (schema 2) has three struts of variable length and a central leg; over the "
        "tilting rotary table (schema 1) there are the kinds 'verne', 'serial', 'linear_delta' and 'rods'"
    )


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
