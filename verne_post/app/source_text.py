"""Whether the bytes of a source are a text that can be read."""

from typing import Final

from verne_post.base.long_text import Text
from verne_post.model.findings import InputError, finding

#: So much of a source is looked at.
_LOOKED_AT: Final = 4096
_UTF16_MARKS: Final = (b"\xff\xfe", b"\xfe\xff")
_UTF8_MARK: Final = b"\xef\xbb\xbf"


def check_source_text(source: Text, name: str) -> None:
    """Refuse bytes that are no text of one byte a character; UTF-16 is what ``>`` of PowerShell makes.

    Raises
    ------
    InputError
        VP022.
    """
    begin = source[:_LOOKED_AT]
    if is_utf16(begin):
        raise InputError(finding("VP022", f"{name} is {UTF16}"))
    if begin.startswith(_UTF8_MARK):
        raise InputError(finding("VP022", f"{name} begins with a byte-order mark; save it as UTF-8 without one"))
    if b"\0" in begin:
        raise InputError(finding("VP022", f"{name} is not a text file"))


def is_utf16(begin: bytes) -> bool:
    """Whether a file that begins so is text in UTF-16, with or without a byte-order mark."""
    if begin[:2] in _UTF16_MARKS:
        return True
    zeros = [begin[side::2].count(0) for side in (0, 1)]
    # ASCII in UTF-16: every other byte is zero, no other is
    return len(begin) >= 4 and min(zeros) == 0 and max(zeros) >= len(begin) // 2


#: The message about such a file.
UTF16: Final = (
    "text in UTF-16; save it as UTF-8. The > of PowerShell writes UTF-16: "
    "let verne-post, or the program that made the file, write it with -o"
)
