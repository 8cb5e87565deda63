"""Formats of setpoint files, one file a format: its name is the name of the format, its ``FORMAT`` says how to write it.

A writer yields bytes. The readers in the tests follow the rules of the receivers.
"""

from typing import Final

from verne_post.base.modules import ModuleTable
from verne_post.output.file_format import FileFormat

FORMATS: Final = ModuleTable[FileFormat](__name__, __path__, "FORMAT")
