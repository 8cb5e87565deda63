"""APT cutter location text -> statements: a major word, a slash, and words between commas."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.expressions import MAX_NUMBER, BlockError
from verne_post.gcode.text import decode_line
from verne_post.gcode.words import whole_lines

_NUMBER: Final = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[EeDd][+-]?[0-9]+)?$")
_MAJOR: Final = re.compile(r"\s*([A-Za-z][A-Za-z0-9]*)\s*(?:/|$)")
#: Words of six letters, whose text goes from the seventh to the end of the line, also when it begins with a digit.
_FREE_TEXT: Final = ("PARTNO", "PPRINT", "REMARK", "INSERT")


@dataclass(frozen=True)
class Statement:
    """One statement: its first line, major word, and the words after the slash."""

    line: int
    major: str
    words: tuple[str, ...]
    text: str


def is_number(word: str) -> bool:
    """True for a number, with an exponent or without."""
    return _NUMBER.match(word) is not None


def read_numbers(statement: Statement, words: Sequence[str]) -> list[float]:
    """The words as numbers; raises BlockError for anything else."""
    values = []
    for word in words:
        if not is_number(word):
            raise BlockError("VP001", f"{statement.major}: {word!r} is not a number")
        value = float(word.upper().replace("D", "E"))
        if not abs(value) <= MAX_NUMBER or math.isnan(value):
            raise BlockError("VP007", f"{statement.major}: {word[:20]} is beyond any machine")
        values.append(value)
    return values


def read_statements(source: Text) -> Iterator[Statement | BlockError]:
    """Statements in order; ``$`` at the end of a line goes on in the next, ``$$`` begins a remark."""
    begin, pending = 0, ""
    lines = (raw for chunk in whole_lines(source) for raw in chunk.removesuffix(b"\n").split(b"\n"))
    for number, raw in enumerate(lines, start=1):
        line = decode_line(raw).rstrip("\r")
        free = not pending and line.lstrip().upper().startswith(_FREE_TEXT)
        if not free:
            line = line.partition("$$")[0]
        line = line.rstrip()
        begin = begin if pending else number
        if line.endswith("$") and not free:
            pending += line[:-1].rstrip() + " "
            continue
        text, pending = (pending + line).strip(), ""
        if text:
            yield _read_statement(text, begin)
    if pending.strip():
        yield BlockError("VP001", "the statement goes on ($), and the text ends", line=begin)


def _read_statement(text: str, line: int) -> Statement | BlockError:
    if text.upper().startswith(_FREE_TEXT):
        major, rest = text[:6].upper(), text[6:]
        return Statement(line, major, (), rest.lstrip(" /").rstrip())
    major_word = _MAJOR.match(text)
    if major_word is None:
        return BlockError(
            "VP001", f"{text[:20]!r}: a statement begins with a word and a slash, as in GOTO/0,0,50", 1, line=line
        )
    major, rest = major_word.group(1).upper(), text[major_word.end() :].strip()
    words = tuple(word.strip() for word in rest.split(",")) if rest else ()
    if any(not word for word in words):
        return BlockError("VP001", f"{major}: nothing between two commas", line=line)
    return Statement(line, major, words, rest)
