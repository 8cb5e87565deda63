r"""Texts from outside, shown so that they steer neither a terminal nor the agent of a CI server that reads the log.

Agents take commands from what a job prints: GitHub's from ``::name ...::`` at the beginning of a line, after blanks,
and from ``##[name]`` anywhere in it; Azure's from ``##vso[area.name ...]`` and ``##[name]``; TeamCity's from
``##teamcity[name ...]``. Markers of GitLab and of others have control characters. The last character of what begins a
command is escaped, as ``\u005b`` or ``\u003a``: JSON, TOML and Python read the same text from that.
"""

import re
from collections.abc import Sequence
from typing import Any, Final

#: Characters that end a line, for one reader of logs or another.
LINE_ENDS: Final = "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029"
#: Other characters outside ASCII. Agents trim some of them as blanks, and ignore others (marks of no width).
_ODD: Final = r"[^\x00-\x7f\x85\u2028\u2029]"
_AT_BEGIN: Final = rf"(?:\A|(?<=[{LINE_ENDS}]))(?:[ \t\x1f]|{_ODD})*:{_ODD}*"
#: A key that TOML reads without quotes.
_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
_ANYWHERE: Final = rf"#{_ODD}*#(?:[\w.-]|{_ODD})*"
#: What begins a command, without its last character; and that.
_COMMAND: Final = re.compile(rf"({_AT_BEGIN})(:)|({_ANYWHERE})(\[)")


def break_commands(text: str) -> str:
    """A text of any number of lines in which no agent finds a command; any other text stays as it is."""
    if text.isascii() and "##" not in text and "::" not in text:
        return text
    return _COMMAND.sub(lambda found: (found[1] or found[3] or "") + _escape(found[2] or found[4]), text)


def find_open_line(text: str) -> str:
    """The last line of a text, which has no end yet: with it a command may begin that the next text goes on with."""
    last = text.splitlines(keepends=True)[-1:]
    return last[0] if last and last[0][-1] not in LINE_ENDS else ""


def _escape(character: str) -> str:
    return f"\\u{ord(character):04x}"


def escape_unprinted(text: str) -> str:
    r"""Text in one line, with every character that does not print escaped as Python does (``\n``, ``\x1b``)."""
    if text.isprintable():
        return text
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode() for character in text
    )


def make_printable(text: str) -> str:
    """One line for people: what is not printed is :func:`escape_unprinted`, commands are broken."""
    return break_commands(escape_unprinted(text))


def make_lines_printable(text: str) -> str:
    """The same for a text of several lines, which stay lines."""
    return "\n".join(make_printable(line) for line in text.split("\n"))


def make_printable_in_place(text: str) -> str:
    """One line with as many characters, so that columns still count: ``?`` for what :func:`make_printable` escapes."""
    text = "".join(character if character.isprintable() else "?" for character in text)
    return _COMMAND.sub(lambda found: (found[1] or found[3] or "") + "?", text)


def join_names(names: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join((*([", ".join(names[:-1])] if names[:-1] else []), *names[-1:]))


def format_json(data: Any, indent: int | None = None, *, ensure_ascii: bool = True) -> str:
    """JSON that may be printed into a log: the same values, with commands of agents escaped inside the strings."""
    import json  # not needed where a command only says something

    return break_commands(json.dumps(data, indent=indent, ensure_ascii=ensure_ascii, allow_nan=False))


def quote_key(name: str) -> str:
    """A key of TOML, in quotes where it needs them."""
    if _BARE_KEY.fullmatch(name):
        return name
    escaped = "".join(
        f"\\u{ord(one):04x}" if ord(one) < 32 or ord(one) == 127 else f"\\{one}" if one in '"\\' else one
        for one in name
    )
    return f'"{escaped}"'
