"""The table of machine kinds: one line each. The kind picks a class once; no other code compares kinds."""

from collections.abc import Callable
from typing import Final

from msgspec import Struct

from verne_post.config.schema import (
    LinearDeltaModuleFile,
    RodsFile,
    RodsModuleFile,
    SerialModuleFile,
    VerneModuleFile,
    VerneRodsFile,
)
from verne_post.config.sentences import Table
from verne_post.kinematics.modules.linear_delta import LinearDeltaModule
from verne_post.kinematics.modules.rods import RodsModule
from verne_post.kinematics.modules.serial import SerialModule
from verne_post.kinematics.modules.verne.module import VerneModule
from verne_post.model.deviations import RodPlaces
from verne_post.model.protocols import ParallelModule


class Kind(Struct, frozen=True):
    """What a kind needs."""

    schema: type[Table]  #: Of [module]; its fields are handed to ``build``.
    build: Callable[..., ParallelModule]  #: Makes the module.
    #: What the actuators are called together, not "a" or "c": the keys of [limits] are ``{group}_mm``,
    #: ``{group}_velocity``, ...
    group: str
    rods: bool  #: True where [limits] must say how close a rod may come to the horizontal (``serial_singularity_mm``).
    bodies: type[RodsFile] | None = None  #: or None: Schema of [rods]; None where the kind has no rods as bodies.
    #: or None: What the places of [rods] become; None where there are none in it.
    rod_places: type[RodPlaces] | None = None


KINDS: Final[dict[str, Kind]] = {
    "verne": Kind(VerneModuleFile, VerneModule, group="rho", rods=True, bodies=VerneRodsFile, rod_places=RodPlaces),
    "serial": Kind(SerialModuleFile, SerialModule, group="xyz", rods=False),
    "linear_delta": Kind(LinearDeltaModuleFile, LinearDeltaModule, group="rho", rods=True),
    "rods": Kind(RodsModuleFile, RodsModule, group="rho", rods=True, bodies=RodsFile),
}

#: Kinds that [as_built] has a model of.
AS_BUILT_KINDS: Final = tuple(name for name, kind in KINDS.items() if kind.rod_places is not None)
