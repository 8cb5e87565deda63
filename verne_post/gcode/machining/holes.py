"""How many holes, and pecks in them, are taken at once, in every language: more is a wrong number, and would run for hours."""

from typing import Final

#: Holes of one block.
MAX_HOLES: Final = 10_000
#: Pecks in all holes of one block.
MAX_PECKS: Final = 30_000
