"""How often loops and calls have repeated blocks, in any language: programs without an end are refused."""

from collections.abc import Hashable
from typing import Final

from msgspec import Struct, field

from verne_post.gcode.program_error import ProgramError

#: Moves of one block beyond this count as repeated blocks: a cycle with that many holes is a loop of its own.
MOVES_OF_BLOCK: Final = 1_000
#: What the message counts, behind which the loop is named.
REPEAT_UNIT: Final = " blocks and moves"


class Repeats(Struct):
    """Counts blocks that are executed again."""

    most: int  #: So many may be repeated.
    repeated_blocks: int = 0  #: So far.
    _counts: dict[Hashable, int] = field(default_factory=dict)

    def count(self, text: Hashable, first: int, last: int, moves: int) -> None:
        """Count lines ``first`` to ``last`` of a text, just executed, if that was not for the first time.

        Raises
        ------
        ProgramError
            VP024: loops and calls have repeated more blocks, or moves of such blocks, than is permitted.
        """
        count_before = self._counts.get(text, 0)
        blocks = moves - MOVES_OF_BLOCK if moves > MOVES_OF_BLOCK else 0
        if last > count_before:
            self._counts[text] = last
        if first <= count_before:
            blocks += max(min(last, count_before) - first + 1, moves)
        if blocks:
            self.add(blocks)

    def add(self, blocks: int) -> None:
        """Count so many blocks that are executed again.

        Raises
        ------
        ProgramError
            VP024, as above.
        """
        self.repeated_blocks += blocks
        if self.repeated_blocks > self.most:
            raise ProgramError(
                "VP024",
                f"loops and calls have repeated {self.most}{REPEAT_UNIT}; if the program is meant to, raise "
                "--max-repeats",
            )
