"""Whether the bytes of a source are a text that can be read."""

import re
from collections.abc import Iterator
from typing import Final

from verne_post.base.file_kinds import describe_binary, describe_kind
from verne_post.base.long_text import Text, take_line
from verne_post.base.program_lines import LONGEST_LINE, count_code
from verne_post.base.text_marks import UTF16, is_utf16
from verne_post.gcode.dialects import choose_dialect, name_dialect
from verne_post.gcode.read import find_language
from verne_post.gcode.text import decode_line
from verne_post.gcode.words import read_whole_lines
from verne_post.model.findings import InputError, make_finding, make_input_error
from verne_post.model.moves import CalledLines
from verne_post.model.options import Options

#: So much of a source is looked at.
_LOOKED_AT: Final = 4096
#: A carriage return that ends no line: most readers would take what follows for the same block.
_STRAY_RETURN: Final = re.compile(rb"\r(?![\r\n]|\Z)")
_LINE_ENDS_OF_OTHERS: Final = ("\r", "\v", "\f", "\x85", "\u2028", "\u2029")
#: What helps where a line is too long.
_DIVIDE: Final = "Divide the line into several blocks. If a line feed is missing, write it where the next block begins."


def take_line_of_move(source: Text, options: Options, called: CalledLines, number: int) -> str:
    """A line as moves count it, of the program or of a file that it calls; empty where that is not there."""
    line, file, _calling_line = called.find_file(number)
    if file is not None:
        keys = {name: key for key, name in options.subroutine_files.items()}
        source = options.subroutines.get(keys.get(file, file.rpartition(".")[0].lower()), b"")
    return decode_line(take_line(source, line) or b"")


def check_source_begin(begin: bytes, name: str) -> None:
    """Refuse setpoints, and what begins as no text of one byte a character; ``>`` of PowerShell makes UTF-16.

    Raises
    ------
    InputError
        VP022.
    """
    begin = begin[:_LOOKED_AT]
    if is_utf16(begin):
        raise make_input_error("VP022", f"{name} is {UTF16}")
    if binary := describe_binary(begin):
        raise make_input_error("VP022", f"{name} is not a text file: {binary}")
    if begin.startswith(b"t_s,"):  # other kinds may look like a program
        raise make_input_error("VP022", describe_kind(begin, "a program", name), advice="")
    text = begin.decode("utf-8", errors="replace")
    if "\n" not in text and (other := next((end for end in _LINE_ENDS_OF_OTHERS if end in text.strip()), None)):
        raise make_input_error(
            "VP022", f"{name}: lines end with {other!r} alone; save it with line feeds (LF or CR LF)"
        )


def check_source_text(source: Text, name: str, dialect: str) -> None:
    """The same, and refuse carriage returns that end no line, and lines that are too long for a block.

    Parameters
    ----------
    dialect : str
        Its name, or "auto".

    Raises
    ------
    InputError
        VP022; VP001, or VP032, for a long line.
    """
    check_source_begin(source[:_LOOKED_AT], name)
    line, language = 1, None
    for text in read_whole_lines(source):
        for start, end in _find_long_lines(text):
            language = language or choose_dialect(dialect, source, name)
            count = count_code(decode_line(text[start:end]), name_dialect(language))
            if count > LONGEST_LINE:
                at = line + text.count(b"\n", 0, start)
                said = f"the line has {count} characters outside remarks; at most {LONGEST_LINE} are read"
                found = make_finding("VP001", said, advice=_DIVIDE, line=at)
                raise InputError(find_language(source, [found], language) or found)
        if b"\r" in text and (stray := _STRAY_RETURN.search(text)) is not None:
            line += text.count(b"\n", 0, stray.start())
            why = "a carriage return is inside the line; end lines with a line feed, alone or after a carriage return"
            raise make_input_error("VP022", f"{name}: {why}", line=line)
        line += text.count(b"\n")


def _find_long_lines(text: bytes) -> Iterator[tuple[int, int]]:
    """Where the lines begin and end that have more bytes than a line may have characters."""
    start = 0
    while start + LONGEST_LINE < len(text):
        last = text.rfind(b"\n", start, start + LONGEST_LINE + 1)
        if last < 0:
            end = text.find(b"\n", start)
            last = len(text) if end < 0 else end
            yield start, last
        start = last + 1
