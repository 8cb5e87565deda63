"""The table of machine kinds: one line each. The kind picks a class once and is never asked again."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from verne_post.config.schema import Group, LinearDeltaModuleFile, SerialModuleFile, VerneModuleFile
from verne_post.kinematics.modules.linear_delta import LinearDeltaModule
from verne_post.kinematics.modules.serial import SerialModule
from verne_post.kinematics.modules.verne import VerneModule
from verne_post.model.protocols import ParallelModule


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
    """

    schema: type[Group]
    build: Callable[..., ParallelModule]
    group: str
    rods: bool


KINDS: Final[dict[str, Kind]] = {
    "verne": Kind(VerneModuleFile, VerneModule, group="rho", rods=True),
    "serial": Kind(SerialModuleFile, SerialModule, group="xyz", rods=False),
    "linear_delta": Kind(LinearDeltaModuleFile, LinearDeltaModule, group="rho", rods=True),
}
