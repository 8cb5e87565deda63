"""The table of machine kinds: one line each. The kind picks a class once; no other code compares kinds."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from verne_post.config.schema import (
    Group,
    LinearDeltaModuleFile,
    RodsFile,
    SerialModuleFile,
    VerneModuleFile,
    VerneRodsFile,
)
from verne_post.kinematics.modules.linear_delta import LinearDeltaModule
from verne_post.kinematics.modules.serial import SerialModule
from verne_post.kinematics.modules.verne.bodies import VerneRods
from verne_post.kinematics.modules.verne.module import VerneModule
from verne_post.model.protocols import ParallelModule, RodModule


@dataclass(frozen=True)
class Kind:
    """What a kind needs.

    Attributes
    ----------
    schema : type of Group
        Of [module]; its fields are handed to ``build``.
    build : callable
        Makes the module.
    group : str
        What the actuators are called together, not "a" or "c": the keys of [limits] are ``{group}_mm``,
        ``{group}_velocity``, ...
    rods : bool
        True where [limits] must say how close a rod may come to the horizontal (``serial_singularity_mm``).
    rod_bodies : pair of a type of Group and a callable, or None
        Schema of [rods], and what makes a ``RodModule`` of the module and the fields that say where the rods are;
        None where the kind does not know its rods as bodies.
    """

    schema: type[Group]
    build: Callable[..., ParallelModule]
    group: str
    rods: bool
    rod_bodies: tuple[type[RodsFile], Callable[..., RodModule]] | None = None


KINDS: Final[dict[str, Kind]] = {
    "verne": Kind(VerneModuleFile, VerneModule, group="rho", rods=True, rod_bodies=(VerneRodsFile, VerneRods)),
    "serial": Kind(SerialModuleFile, SerialModule, group="xyz", rods=False),
    "linear_delta": Kind(LinearDeltaModuleFile, LinearDeltaModule, group="rho", rods=True),
}
