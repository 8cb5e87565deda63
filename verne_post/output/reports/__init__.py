"""Formats of ``check``'s findings, one file a format: its name is the name of the format, its ``write`` makes the text."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, TypeAlias

from verne_post.base.modules import ModuleTable

if TYPE_CHECKING:
    from verne_post.model.machine import Machine
    from verne_post.output.findings import Report

Writer: TypeAlias = "Callable[[Sequence[Report], Machine], str]"

FORMATS: Final = ModuleTable[Writer](__name__, __path__, "write")
