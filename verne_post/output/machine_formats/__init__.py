"""Formats of whole machines (`machine export`), one file a format; ``_`` of its name is ``-`` on the command line."""

from typing import Final

from verne_post.base.modules import ModuleTable
from verne_post.output.file_format import MachineFormat

MACHINE_FORMATS: Final = ModuleTable[MachineFormat](__name__, __path__, "FORMAT")
