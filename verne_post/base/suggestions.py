"""What a wrong name may have been meant for, as the end of a message."""

import difflib
import re
from collections.abc import Iterable


def suggest(word: str, *names: Iterable[str]) -> str:
    """The nearest name of the first group that has one near, as "; did you mean NAME?"; empty where none has."""
    near = next((found for group in names if (found := difflib.get_close_matches(word, list(group), n=1))), None)
    return f"; did you mean {near[0]}?" if near else ""


def find_correction(message: str) -> tuple[str, str] | None:
    """What a message says is written, and what is meant: of "SUAP: ...; did you mean SUPA?"; None where it does not."""
    found = re.search(r"^([^:]+): .*; did you mean (\S+)\?$", message)
    return None if found is None else (found[1], found[2])


def find_suggestion(message: str) -> str:
    """The name that :func:`suggest` has put at the end of a message; empty where there is none."""
    found = re.search(r"; did you mean ([^?\n]+)\?$", message)
    return found[1] if found else ""
