"""Errors of programs, and the place in a program that they are about."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final

from msgspec import Struct, field

from verne_post.base.suggestions import find_meant
from verne_post.model.codes import CODES
from verne_post.model.findings import ProgramError as ProgramError
from verne_post.model.findings import Remedy

#: What helps against VP023, where a program, a label, or the partner of a word is missing.
GIVE_FILE: Final = "Put its file beside the program, or into a folder of --subroutine-path."
GIVE_LABEL: Final = "Write the label, or the number of the block, where the program is to go on, or correct its name."
CLOSE_IN_ORDER: Final = "Open and close each in its order, by the same name."
#: Against VP008, where the numbers of an arc do not fit.
POST_OTHERWISE: Final = (
    f"{CODES['VP008'].remedy} If they are right, post the arc with more decimals, or as straight moves."
)
GIVE_PLACE: Final = (
    "Fill in wcs.{} in INPUT.toml, which verne-post setup INPUT writes, in mm from that point; 0, 0, 0 if the part "
    "zero really is there."
)
FILL_IN_LENGTH: Final = "Fill in the length in INPUT.toml, which verne-post setup INPUT writes."


def write_before(words: str, *, line: int = 0, turns: bool = False, is_choice: bool = False) -> tuple[Remedy, ...]:
    """The edit of an error that words on a line before its own settle."""
    return (Remedy(f"write {words} before", words, line=line, way="before", turns=turns, is_choice=is_choice),)


def close_here(bracket: str) -> tuple[Remedy, ...]:
    """The edit of an error that a bracket at its place settles, where nothing but another word follows."""
    return (Remedy(f"write {bracket}", bracket, way="here", is_choice=True),)


def end_with(words: str) -> tuple[Remedy, ...]:
    """The edit of an error that a last line settles, before a closing %."""
    return (Remedy(f"write {words}", words, line=1, way="end"),)


def write_parameter(number: int, value: float, right_value: float) -> tuple[Remedy, ...]:
    """The edit of an error that another value of a Q parameter settles, in the last line that gives it ``value``."""
    right = f"{right_value:.15g}"  # all its digits
    return (Remedy(f"write Q{number}={right}", right, word=(f"Q{number}", value), is_above=True),)


def write_words(wrong: str, *rights: str, line: int = 0, is_choice: bool = False) -> tuple[Remedy, ...]:
    """The edits of an error that another word settles: of several, each is a choice."""
    is_choice = is_choice or len(rights) > 1
    return tuple(Remedy(f"write {one}", one, line=line, misspelt=wrong, is_choice=is_choice) for one in rights)


def write_meant(word: str, *names: Iterable[str]) -> tuple[Remedy, ...]:
    """The edit of an error that one of ``names`` settles of which ``word`` is a slip; none where none is near."""
    near = find_meant(word, *names, slip_alone=True)
    return write_words(word, near) if near else ()


def write_numbers(numbers: Sequence[str], number: str, name: str, line: int) -> tuple[Remedy, ...]:
    """The edits of an error that another number behind ``name`` settles: one of ``numbers`` in place of ``number``."""
    return write_words(f"{name}{number}", *(f"{name}{one}" for one in numbers), line=line)


def refuse_missing(what: str, missing: Sequence[tuple[str, str]]) -> ProgramError:
    """The error (VP005) of all values that are missing: the name and the meaning of each."""
    *some, last = [f"{name} (the {meaning})" for name, meaning in missing]
    names = f"{', '.join(some)} and {last}" if some else "{}, the {}".format(*missing[0])
    return ProgramError("VP005", f"{what} needs {names}")


#: How the error of a subprogram begins that is read without its caller.
IS_SUBPROGRAM: Final = "this is a subprogram"
#: The same, and of one that may be a program too.
LIKE_SUBPROGRAM: Final = (IS_SUBPROGRAM, "is this a subprogram?")
#: How an error ends that says so, or that it may be one.
CHECK_CALLER: Final = "check the program that calls it"
#: Where a value is given, and a sign of comparison stands.
DOUBLE_EQUALS: Final = "==: compares, and gives no value; did you mean =?"


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
        self,
        code: str,
        message: str,
        word: str,
        about: str | None = None,
        settled_by: tuple[str, ...] = (),
        edits: tuple[Remedy, ...] = (),
    ) -> ProgramError:
        """An error at a word; without a column where the line has no such word."""
        return ProgramError(code, message, self.columns.get(word), about=about, settled_by=settled_by, edits=edits)
