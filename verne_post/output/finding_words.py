"""The word of a line that a finding is about: consoles put a caret under it, and editors mark it."""

import re
from typing import Final

from verne_post.base.program_lines import find_word, find_word_of
from verne_post.base.suggestions import MAY_BE_MEANT, find_correction
from verne_post.model.findings import Finding

#: A word from its column on: a name in quotes, a variable, A=DC(0), letters and a number, a name, or one character.
_WORD: Final = re.compile(
    r"\"[^\"]*\"|#+(?:\d+|<[^<>]*>)|[A-Za-z]+[ \t]*=[ \t]*[A-Za-z]+\([^()]*\)"
    r"|[A-Za-z_]+(?:[ \t]*=?[ \t]*[-+]?[\d.]+)?|[-+]?[\d.]+|."
)


def find_span(item: Finding, line: str, at: int) -> tuple[int, int] | None:
    """Where the word of a finding begins and ends in line ``at``, from 0; None where it is about no word."""
    if item.column is not None:
        begin = min(item.column - 1, len(line))
        found = _WORD.match(line, begin)
        end = found.end() if found else begin
        correction = find_correction(item.message)
        wrong = next((one.misspelt for one in item.edits if item.message.endswith(f"; {one.value}{MAY_BE_MEANT}")), "")
        wrong = wrong if correction is None else correction[0]
        if wrong and line[begin:].upper().startswith(wrong.upper()):
            end = begin + len(wrong)
        return begin, end
    words = _list_own_words(item, line, at)
    return (min(one.start() for one in words), max(one.end() for one in words)) if words else None


def _list_own_words(item: Finding, line: str, at: int) -> list[re.Match[str]]:
    """Words of a finding without a column: of its axis, that of an edit, or the end of an arc beside its circle."""
    word = find_word(line, item.axis) if item.axis is not None and len(item.axis) == 1 else None
    own = (find_word_of(line, *one.word) for one in item.edits if one.line == at and one.word[0])
    word = word or next((one for one in own if one is not None), None)
    if word is not None or item.code != "VP008":
        return [] if word is None else [word]
    axes = re.search(r"at the start \(([A-Z])\S+ ([A-Z])", item.message)
    found = (find_word(line, letter) for letter in (axes.groups() if axes is not None else ()))
    return [one for one in found if one is not None]
