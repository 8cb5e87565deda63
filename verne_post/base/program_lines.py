"""Remarks and words of a program's line as it is written, without reading the program."""

import math
import re
from typing import Final

from verne_post.base.tolerances import LIMIT_SLACK_MM

#: Remarks of languages, by dialect, in which parentheses are no remarks.
_REMARKS: Final = {"siemens": r";.*", "heidenhain": r";.*", "aptcl": r"\$\$.*"}


def remove_remarks(line: str, dialect: str = "") -> str:
    """A line with blanks for its remarks; without a dialect, those in parentheses and after a semicolon."""
    return re.sub(_REMARKS.get(dialect, r"\([^)]*\)?|;.*"), lambda remark: " " * len(remark[0]), line)


def find_word(line: str, letter: str) -> re.Match[str] | None:
    """A letter (1) with its number (2), outside remarks; None where the line does not have it once."""
    found = _list_words(line, letter)
    return found[0] if len(found) == 1 else None


def _list_words(line: str, letter: str) -> list[re.Match[str]]:
    pattern = rf"(?<![A-Za-z_])({letter}[ \t]*=?[ \t]*)([-+]?(?:\d+\.?\d*|\.\d+))"
    return list(re.finditer(pattern, remove_remarks(line), re.IGNORECASE))


def find_word_of(line: str, letter: str, value: float) -> re.Match[str] | None:
    """A letter with this number; None where the line does not have it once.

    In a loop, an incremental block or inches the number has another meaning.
    """
    found = [one for one in _list_words(line, letter) if math.isclose(float(one[2]), value, abs_tol=LIMIT_SLACK_MM)]
    return found[0] if len(found) == 1 else None
