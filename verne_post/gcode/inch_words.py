"""Words of a text that ask for inches, and the same text in mm: for programs that fit no machine as they are."""

import re

from msgspec import Struct

from verne_post.base.long_text import Text, count_line
from verne_post.gcode.dialects import choose_dialect
from verne_post.gcode.setup import Setup


class InchWord(Struct, frozen=True):
    """The first word of a text that asks for inches, where it stands, and the word for mm."""

    line: int
    column: int
    word: str
    word_for_mm: str


def is_in_inches(source: Text, setup: Setup, line: int) -> bool:
    """Whether a line stands below a word for inches, and no word for mm is between."""
    text = b"\n".join(source[:].split(b"\n")[:line])
    found = _list_inch_words(text, choose_dialect(setup.dialect, source, setup.source_name).inch)
    for_mm = {word.upper().encode() for _begin, _word, word in found}
    return bool(found) and found[-1][0] > max(text.upper().rfind(word) for word in for_mm)


def _list_inch_words(text: bytes, words: tuple[str, str] | None) -> list[tuple[int, str, str]]:
    """Words for inches outside of remarks: where each begins, and the word for mm; ``words`` are those of a dialect."""
    if words is None:
        return []
    found = (match for match in _compile(words[0]).finditer(text) if match[1] is not None)
    return [(one.start(1), one[1].decode(), one.expand(words[1].encode()).decode()) for one in found]


def _compile(pattern: str) -> re.Pattern[bytes]:
    return re.compile(rb"\([^)\n]*\)?|;[^\n]*|" + pattern.encode(), re.IGNORECASE | re.MULTILINE)


def read_as_mm(source: Text, setup: Setup) -> tuple[InchWord, bytes] | None:
    """The first word for inches, and the text with words for mm in place of all of them; None where there is none."""
    words = choose_dialect(setup.dialect, source, setup.source_name).inch
    if words is None:
        return None
    (pattern, word_for_mm), whole = words, source[:]
    code = _compile(pattern)
    found = _list_inch_words(whole, words)
    if not found:
        return None
    begin, word, word_in_mm = found[0]
    place = count_line(whole, begin), begin - whole.rfind(b"\n", 0, begin)

    def write_mm(match: re.Match[bytes]) -> bytes:
        if match[1] is None:
            return match[0]
        at = match.start(1) - match.start()
        return match[0][:at] + match.expand(word_for_mm.encode()) + match[0][at + len(match[1]) :]

    return InchWord(*place, word, word_in_mm), code.sub(write_mm, whole)
