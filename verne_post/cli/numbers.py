"""Numbers of the command line, with the digits that files have."""

from typing import Any, ClassVar, Final

import click
from click.types import FloatParamType, IntParamType

from verne_post.base.numbers import is_plain, read_number


class _PlainDigits:
    """A number of click that refuses what only Python reads as a number: 8_0, or digits of other scripts."""

    called: ClassVar[str]

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read a number."""
        if isinstance(value, str) and not is_plain(value):
            raise click.BadParameter(f"{value!r} is not {self.called}", ctx, param)
        try:
            return super().convert(value, param, ctx)  # type: ignore[misc]  # of the kind beside this class
        except click.BadParameter as error:  # click has the words of programmers
            text = error.message.replace(f"a valid {self.name}", self.called)  # type: ignore[attr-defined]
            raise click.BadParameter(text, ctx, param) from None


class _Number(_PlainDigits, FloatParamType):
    called = "a number"


class _Integer(_PlainDigits, IntParamType):
    called = "a whole number"


class Whole(_PlainDigits, click.IntRange):
    """A whole number within bounds."""

    called = "a whole number"


#: A number, and a whole one; whoever uses them checks their bounds.
NUMBER: Final = _Number()
INTEGER: Final = _Integer()


def read_numbers(text: str, what: str, hint: str = "") -> list[float]:
    """Numbers with commas between them; ``what`` names the option in errors, ``hint`` says what else would be right."""
    try:
        return [read_number(part) for part in text.split(",")]
    except ValueError:
        raise click.UsageError(f"{what}: {text!r} is not a list of numbers{hint}") from None
