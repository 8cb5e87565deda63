"""The table of machine kinds: one line each. The kind picks a class once; no other code compares kinds."""

from collections.abc import Callable
from typing import Final

from msgspec import Struct

from verne_post.config.schema import (
    LinearDeltaModuleFile,
    RodsFile,
    SerialModuleFile,
    VerneModuleFile,
    VerneRodsFile,
)
from verne_post.config.sentences import Table
from verne_post.kinematics.modules.linear_delta import LinearDeltaModule
from verne_post.kinematics.modules.serial import SerialModule
from verne_post.kinematics.modules.verne.module import VerneModule
from verne_post.model.deviations import RodPlaces
from verne_post.model.protocols import ParallelModule


class Kind(Struct, frozen=True):
    """What a kind needs.

    Attributes
    ----------
    schema : type of Table
        Of [module]; its fields are handed to ``build``.
    build : callable
        Makes the module.
    group : str
        What the actuators are called together, not "a" or "c": the keys of [limits] are ``{group}_mm``,
        ``{group}_velocity``, ...
    rods : bool
        True where [limits] must say how close a rod may come to the horizontal (``serial_singularity_mm``).
    rod_places : pair of types, or None
        Schema of [rods], and what its places become; None where the kind does not know its rods as bodies.
    """

    schema: type[Table]
    build: Callable[..., ParallelModule]
    group: str
    rods: bool
    rod_places: tuple[type[RodsFile], type[RodPlaces]] | None = None


KINDS: Final[dict[str, Kind]] = {
    "verne": Kind(VerneModuleFile, VerneModule, group="rho", rods=True, rod_places=(VerneRodsFile, RodPlaces)),
    "serial": Kind(SerialModuleFile, SerialModule, group="xyz", rods=False),
    "linear_delta": Kind(LinearDeltaModuleFile, LinearDeltaModule, group="rho", rods=True),
}
