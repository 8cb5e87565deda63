"""The line with which a program of a Siemens file begins, %_N_NAME_MPF, and what is meant by one with a slip."""

import re
from typing import Final

from verne_post.base.suggestions import has_one_more

#: One word, as no block is.
_WORD: Final = re.compile(r"[^\s;\"=()/,\[\]]{6,60}")
_RIGHT: Final = re.compile(r"%_N_\w+_(?:MPF|SPF)")
_NAME: Final = re.compile(r"[A-Z0-9]\w*", re.ASCII)
_BEGIN: Final = "%_N_"
_ENDS: Final = ("_MPF", "_SPF")


def find_meant_header(line: str, *, is_first: bool) -> str:
    """The line %_N_NAME_MPF or %_N_NAME_SPF that a line with one slip in its marks is meant for; else empty.

    Where either ending is as near, the program ``is_first`` in its file is the main one.
    """
    word = line.strip().upper()
    if not _WORD.fullmatch(word) or _RIGHT.fullmatch(word):
        return ""
    if word.endswith(_ENDS):
        rests = (word[size:] for size in (3, 4, 5) if _is_near(word[:size], _BEGIN))
        return next((f"{_BEGIN}{rest}" for rest in rests if _NAME.fullmatch(rest[:-4])), "")
    if not word.startswith(_BEGIN):
        return ""
    ends = _ENDS if is_first else _ENDS[::-1]
    sizes = (3, 4, 5) if word[-3:] in ("MPF", "SPF") and word[-4].isalnum() else (4, 3, 5)
    if "_" in (word[-5], word[-3]):  # a letter too many or too few, as in _MMPF and _PF
        sizes = (5, 4, 3) if word[-5] == "_" else (3, 4, 5)
    near = ((word[4:-size], end) for size in sizes for end in ends if _is_near(word[-size:], end))
    return next((f"{_BEGIN}{name}{end}" for name, end in near if _NAME.fullmatch(name)), "")


def _is_near(word: str, right: str) -> bool:
    """Whether one character is another one, left out or too many, or two neighbours have changed places."""
    if len(word) != len(right):
        return has_one_more(word, right) or has_one_more(right, word)
    wrong = [at for at, (one, other) in enumerate(zip(word, right, strict=True)) if one != other]
    return len(wrong) == 1 or (len(wrong) == 2 and sorted(word) == sorted(right) and wrong[1] == wrong[0] + 1)
