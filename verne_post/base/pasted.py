"""Characters that mail and PDF put in place of those that are typed, in programs and in TOML files."""

import re
import unicodedata
from typing import Final

#: What each is meant for, and what that is called.
_MEANT: Final = {
    **dict.fromkeys("\u00a0\u2002\u2003\u2007\u2008\u2009\u200a\u202f\u3000", (" ", "a blank")),
    **dict.fromkeys("\u2010\u2011\u2012\u2013\u2014\u2015\u2212", ("-", "a minus (-)")),
    **dict.fromkeys("\u201c\u201d\u201e\u201f\u00ab\u00bb\u2033", ('"', 'a straight quote (")')),
    **dict.fromkeys("\u2018\u2019", ("'", "a straight quote (')")),
}
_SINGLE: Final = "'"
_TYPED: Final = str.maketrans({one: character for one, (character, _name) in _MEANT.items()})
#: Those that programs are searched for: a single quote is seldom what is meant there.
OF_PROGRAMS: Final = re.compile(f"[{''.join(one for one, meant in _MEANT.items() if meant[0] != _SINGLE)}]")


def is_pasted(character: str) -> bool:
    """Whether a character, or none at all, is one of these."""
    return character in _MEANT


def translate_pasted(text: str) -> str:
    """A text with the characters that are meant."""
    return text.translate(_TYPED)


def name_meant(character: str) -> str:
    """What such a character is meant for."""
    return _MEANT[character][1]


def name_pasted(character: str) -> str:
    """Such a character by its name, with the article."""
    name = unicodedata.name(character).lower()
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name} (U+{ord(character):04X})"


def explain_pasted(character: str) -> str:
    """What is wrong with such a character, and what to write."""
    return f"{name_pasted(character)}, as copied from a mail or PDF; write {name_meant(character)}"
