"""Marks that editors put before a text, and what a text in UTF-16 looks like: one place for every file that is read."""

from typing import Final

_UTF16_MARKS: Final = (b"\xff\xfe", b"\xfe\xff")
_UTF8_MARK: Final = b"\xef\xbb\xbf"
#: The message about a file with bytes that UTF-8 does not have.
NO_TEXT: Final = "it is no text in UTF-8 (an archive, a picture or a program, for example)"
#: The message about a file in UTF-16.
UTF16: Final = (
    "text in UTF-16; save it as UTF-8. The > of PowerShell writes UTF-16: "
    "let verne-post, or the program that made the file, write it with -o"
)


def strip_mark(begin: bytes) -> bytes:
    """The first bytes of a text without the mark that editors write before UTF-8."""
    return begin.removeprefix(_UTF8_MARK)


def is_utf16(begin: bytes) -> bool:
    """Whether a file that begins so is text in UTF-16, with or without a byte-order mark."""
    if begin[:2] in _UTF16_MARKS:
        return True
    zeros = [begin[side::2].count(0) for side in (0, 1)]
    # ASCII in UTF-16: every other byte is zero, no other is
    return len(begin) >= 4 and min(zeros) == 0 and max(zeros) >= len(begin) // 2


def decode_text(raw: bytes, errors: str = "strict") -> str:
    """The text of a file in UTF-8, with or without the mark; ``errors`` is that of ``bytes.decode``."""
    return strip_mark(raw).decode("utf-8", errors=errors)
