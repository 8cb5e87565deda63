"""A table of options in a file: what is wrong with it."""

from collections.abc import Sequence
from typing import Any

from verne_post.base.suggestions import suggest
from verne_post.model.findings import UsageError
from verne_post.model.options import Options


def find_wrong_options(
    given: dict[str, Any], allowed: Sequence[str], others: Sequence[str] = (), kind: str = "a settings file"
) -> list[str]:
    """What is wrong with a table of options, as sentences: a name that is none of those allowed, or a value.

    Parameters
    ----------
    others : sequence of str
        Names that the table may have beside options.
    kind : str
        Of the file, in words.
    """
    for name in given:
        if name not in allowed:
            return [f"{name}: this is no option of {kind}{suggest(name, [*allowed, *others])}"]
    values: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in given.items()}
    try:
        Options(**values)
    except UsageError as error:
        return [f"{error.option} = {error.reason}"]
    return []
