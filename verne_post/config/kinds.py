"""The table of machine kinds: one line each. The kind picks a class once and is never asked again."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from verne_post.config.schema import Group, VerneModuleFile
from verne_post.kinematics.modules.verne import VerneModule
from verne_post.model.protocols import ParallelModule


@dataclass(frozen=True)
class Kind:
    """Schema of [module] and the class that it feeds."""

    schema: type[Group]
    build: Callable[..., ParallelModule]


KINDS: Final[dict[str, Kind]] = {
    "verne": Kind(VerneModuleFile, VerneModule),
}
