"""Words of a text that ask for inches, and the same text in mm: for programs that fit no machine as they are."""

import re

from msgspec import Struct

from verne_post.base.long_text import Text
from verne_post.gcode.dialects import choose_dialect
from verne_post.gcode.setup import Setup


class InchWord(Struct, frozen=True):
    """The first word of a text that asks for inches, where it stands, and the word for mm."""

    line: int
    column: int
    word: str
    word_for_mm: str


def read_as_mm(source: Text, setup: Setup) -> tuple[InchWord, bytes] | None:
    """The first word for inches, and the text with words for mm in place of all of them; None where there is none."""
    words = choose_dialect(setup.dialect, source, setup.source_name).inch
    if words is None:
        return None
    (pattern, word_for_mm), whole = words, source[:]
    code = re.compile(rb"\([^)\n]*\)?|;[^\n]*|" + pattern.encode(), re.IGNORECASE | re.MULTILINE)
    found = next((match for match in code.finditer(whole) if match[1] is not None), None)
    if found is None:
        return None
    begin = found.start(1)
    place = whole.count(b"\n", 0, begin) + 1, begin - whole.rfind(b"\n", 0, begin)

    def write_mm(match: re.Match[bytes]) -> bytes:
        if match[1] is None:
            return match[0]
        at = match.start(1) - match.start()
        return match[0][:at] + match.expand(word_for_mm.encode()) + match[0][at + len(match[1]) :]

    return InchWord(*place, found[1].decode(), found.expand(word_for_mm.encode()).decode()), code.sub(write_mm, whole)
