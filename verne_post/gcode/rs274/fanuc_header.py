"""Whether a text is a program of a Fanuc control: by how it begins, and by words that only these controls, or only RS274/NGC, have."""

import re
from typing import Final

#: Lines that are looked at.
_HEADER_LINES: Final = 200
#: ``%`` and a program number, or such a number alone in its line.
_OPENING: Final = re.compile(
    rb"\s*%[^\n]*\n\s*[O:]\s*[0-9]++(?!\s*(?:SUB|CALL|IF|WHILE|DO|REPEAT))|\s*O[ \t]*[0-9]++[ \t\r]*(?:\([^\n]*)?(?:\n|$)",
    re.IGNORECASE,
)
#: What only these controls have.
_OWN_CODES: Final = re.compile(
    rb"(?<![A-Z])G0*(?:43\.[45]|68\.2|53\.1|54\.1|5\.1|69|8(?=\s*P)|6\.2)(?![0-9.])|(?<![A-Z])M98\s*P[0-9]{5,}",
    re.IGNORECASE,
)
#: What no control but these has, so that no header is needed: calls of macros, and modes of looking ahead.
_NOBODY_ELSES: Final = re.compile(
    rb"(?<![A-Z])G0*(?:6[56][ \t]*P[0-9]|5\.1[ \t]*Q[01]|[58][ \t]*P[0-9]+[ \t\r]*(?:[(;\n]|$))", re.IGNORECASE
)
#: What only RS274/NGC has: such a text is not Fanuc's, whatever its header.
_OTHER_CODES: Final = re.compile(
    rb"#<|(?<![A-Z])O\s*(?:<|[0-9]+\s*(?:SUB|CALL|IF|WHILE|DO|REPEAT))|\((?:MSG|DEBUG|PRINT|ABORT),|(?<![A-Z])G0*64[ \t]*[PQ]"
    rb"|(?<![A-Z])G0*(?:43\.2|43\.1(?![^\n]*H)|59\.[123]|61\.1|92\.[23]|9[01]\.1|4[12]\.1|5\.[23])(?![0-9.])", re.IGNORECASE
)  # fmt: skip
#: G10 L20, and G54.1.
_HERE: Final = re.compile(rb"(?<![A-Z])L[ \t]*20(?![0-9.])", re.IGNORECASE)
_ADDITIONAL_CODE: Final = re.compile(rb"(?<![A-Z])G0*54\.1", re.IGNORECASE)


def is_fanuc(begin: bytes) -> bool:
    """Text after ``%``, or an O number, with ``%`` or alone in its line, unless words near the top are RS274/NGC's alone.

    ``begin`` is how the program begins, behind what a listing prints before it.
    """
    head = b"\n".join(begin.split(b"\n")[:_HEADER_LINES])
    if re.match(rb"\s*%(?!_N_)[ \t]*[^ \t\r\n]", head) or re.match(rb"\s*(?:%[^\n]*\n\s*)?:[0-9]+", head):
        return True
    without_comments = re.sub(rb"\([^)\n]*(?:\)|$)", b"", head, flags=re.MULTILINE)
    if _OPENING.match(head) is None:
        return _NOBODY_ELSES.search(without_comments) is not None and _OTHER_CODES.search(head) is None
    if _HERE.search(without_comments) and not _ADDITIONAL_CODE.search(without_comments):
        return False  # G10 L20 is an origin of G54.1 there, and the present place in RS274/NGC
    # read as Fanuc's, an RS274 text is refused or stays higher; the other way it would dwell for minutes
    return _OWN_CODES.search(without_comments) is not None or _OTHER_CODES.search(head) is None
