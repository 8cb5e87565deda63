"""Formats of setpoint files, one file for each: the file has the format's name, its ``FORMAT`` says how to write it.

A writer yields bytes. The readers in the tests follow the rules of the receivers.
"""

from typing import Final

from verne_post.base.modules import ModuleTable
from verne_post.output.file_format import FileFormat

FORMATS: Final = ModuleTable[FileFormat](__name__, __path__, "FORMAT")
