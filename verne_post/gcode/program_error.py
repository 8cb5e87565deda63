"""Errors of programs, and the place in a program that they are about."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from msgspec import Struct, field

#: Characters of a message: a name may be as long as its file.
_LONGEST_MESSAGE: Final = 1000


class ProgramError(Exception):
    """What a program says cannot be executed: finding code, sentence, 1-based column (None: the whole line).

    ``line`` is None where it is the line being executed. ``about`` is the thing that the message names, such as a tool:
    the same message about another thing has the same cause. ``settled_by`` is the key of a set-up that would settle it.
    """

    def __init__(
        self,
        code: str,
        message: str,
        column: int | None = None,
        line: int | None = None,
        about: str | None = None,
        settled_by: tuple[str, ...] = (),
    ) -> None:
        super().__init__(message)
        self.message = message if len(message) <= _LONGEST_MESSAGE else f"{message[:_LONGEST_MESSAGE]} ..."
        self.code, self.column, self.line, self.about, self.settled_by = code, column, line, about, settled_by


@contextmanager
def locate_errors(column: int | None) -> Iterator[None]:
    """Errors of what a line calls stand at the column of the call, unless they have one, or name another line."""
    try:
        yield
    except ProgramError as error:
        error.column = error.column or (None if error.line else column)
        raise


class At(Struct):
    """Where in the program something is executed: the line, and the columns of its words by their names."""

    line: int
    columns: dict[str, int] = field(default_factory=dict)

    def error(
        self, code: str, message: str, word: str, about: str | None = None, settled_by: tuple[str, ...] = ()
    ) -> ProgramError:
        """An error at a word; without a column where the line has no such word."""
        return ProgramError(code, message, self.columns.get(word), about=about, settled_by=settled_by)
