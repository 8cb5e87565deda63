"""Errors of programs, and the place in a program that they are about."""

from collections.abc import Iterator
from contextlib import contextmanager

from msgspec import Struct, field

from verne_post.model.findings import ProgramError as ProgramError


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
