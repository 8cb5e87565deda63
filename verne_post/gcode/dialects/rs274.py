"""RS274/NGC as LinuxCNC speaks it: the language of the interpreter itself."""

from typing import Final

from verne_post.gcode.dialect import Dialect, dialect_of_blocks
from verne_post.gcode.rs274.interpreter import Rs274

#: No header shows this dialect: it is the default.
DIALECT: Final[Dialect] = dialect_of_blocks(Rs274, recognise=lambda _source: False)
