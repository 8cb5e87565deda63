"""Numbers of the command line, with the digits that files have."""

from typing import Any, Final

import click
from click.types import FloatParamType

from verne_post.base.numbers import is_plain, read_number


class _Number(FloatParamType):
    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read a number."""
        if isinstance(value, str) and not is_plain(value):
            self.fail(f"{value!r} is not a number", param, ctx)
        return super().convert(value, param, ctx)


class Whole(click.IntRange):
    """A whole number within bounds."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read a whole number."""
        if isinstance(value, str) and not is_plain(value):
            self.fail(f"{value!r} is not a whole number", param, ctx)
        return super().convert(value, param, ctx)


#: A number; whoever uses it checks its bounds.
NUMBER: Final = _Number()


def numbers_of(text: str, what: str, hint: str = "") -> list[float]:
    """Numbers with commas between them; ``what`` names the option in errors, ``hint`` says what else would be right."""
    try:
        return [read_number(part) for part in text.split(",")]
    except ValueError:
        raise click.UsageError(f"{what}: {text!r} is not a list of numbers{hint}") from None
