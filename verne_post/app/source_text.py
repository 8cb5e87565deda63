"""Whether the bytes of a source are a text that can be read."""

import re
from typing import Final

from verne_post.base.long_text import Text
from verne_post.base.text_marks import UTF16, is_utf16
from verne_post.gcode.words import read_whole_lines
from verne_post.model.findings import make_input_error

#: So much of a source is looked at.
_LOOKED_AT: Final = 4096
#: A carriage return that ends no line: most readers would take what follows for the same block.
_STRAY_RETURN: Final = re.compile(rb"\r(?![\r\n]|\Z)")
_LINE_ENDS_OF_OTHERS: Final = ("\r", "\v", "\f", "\x85", "\u2028", "\u2029")


def check_source_begin(begin: bytes, name: str) -> None:
    """Refuse what begins as no text of one byte a character; UTF-16 is what ``>`` of PowerShell makes.

    Raises
    ------
    InputError
        VP022.
    """
    begin = begin[:_LOOKED_AT]
    if is_utf16(begin):
        raise make_input_error("VP022", f"{name} is {UTF16}")
    if (at := begin.find(b"\0")) >= 0:
        raise make_input_error("VP022", f"{name} is not a text file: byte {at + 1} is zero")
    text = begin.decode("utf-8", errors="replace")
    if "\n" not in text and (other := next((end for end in _LINE_ENDS_OF_OTHERS if end in text.strip()), None)):
        raise make_input_error(
            "VP022", f"{name}: lines end with {other!r} alone; save it with line feeds (LF or CR LF)"
        )


def check_source_text(source: Text, name: str) -> None:
    """The same, and refuse carriage returns that end no line.

    Raises
    ------
    InputError
        VP022.
    """
    check_source_begin(source[:_LOOKED_AT], name)
    line = 1
    for text in read_whole_lines(source):
        if b"\r" in text and (stray := _STRAY_RETURN.search(text)) is not None:
            line += text.count(b"\n", 0, stray.start())
            why = "a carriage return is inside the line; end lines with a line feed, alone or after a carriage return"
            raise make_input_error("VP022", f"{name}: {why}", line=line, last_line=line, worst_line=line)
        line += text.count(b"\n")
