"""Words of axes after a semicolon, which ends a block on a Fanuc control and begins a remark here (VP001)."""

import re
from collections.abc import Iterator
from typing import Final

from verne_post.base.long_text import Text, iterate_lines
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.text import decode_line
from verne_post.model.findings import Finding, add_line, make_finding
from verne_post.model.options import Options

#: A word of an axis with a number.
_AXIS: Final = re.compile(rb"[XYZABC][ \t]*+[-+]?[ \t]*+\.?\d", re.IGNORECASE)
#: Words with numbers, and nothing else: remarks in words are none.
_WORDS: Final = re.compile(rb"(?:[ \t;]*+[A-Z][ \t]*+[-+]?(?:\d++\.?\d*+|\.\d++))++[ \t;]*+\r?", re.IGNORECASE)
_ADVICE: Final = (
    "Write the words after ; into a line of their own if they are a block, or in parentheses if they are a remark."
)


def check_block_ends(source: Text, options: Options) -> Iterator[Finding]:
    """VP001, a warning, once a program: words of axes after a semicolon that itself stands after words of axes."""
    if source.find(b";") < 0 or choose_dialect_name(options.dialect, source, options.source_name) != "fanuc":
        return
    found: Finding | None = None
    for line, raw in enumerate(iterate_lines(source), start=1):
        head, _, tail = raw.partition(b";")
        if not _AXIS.search(tail) or not _AXIS.search(head) or head.count(b"(") != head.count(b")"):
            continue
        if _WORDS.fullmatch(tail) is None:
            continue
        if found is not None:
            found = add_line(found, line)
            continue
        text = (
            f"{decode_line(tail).strip(' ;')} is read as a remark and not executed, because it stands after a "
            "semicolon; a control may take that for the end of a block and execute what follows"
        )
        column = len(decode_line(head)) + 1
        found = make_finding("VP001", text, severity="warning", advice=_ADVICE, line=line, column=column)
    if found is not None:
        yield found
