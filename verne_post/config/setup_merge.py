"""A set-up that is there, with what the program needs and the file lacks: all that stands there stays as it is written.

The text is changed key by key, so that remarks and their order stay. The result is read as TOML and compared with what
it must say; where a file is written in a way that is not seen here, nothing is changed.
"""

import re
import tomllib
from collections.abc import Iterable, Mapping
from typing import Any, Final

from verne_post.base.printable import make_printable, quote_key
from verne_post.config.toml_entries import Edit, Key, UnknownLayoutError, find_line_end, list_entries, plan_edit

#: Behind a key that no line of the program asks for.
UNUSED: Final = "not used by the program"
_UNUSED_REMARK: Final = re.compile(rf"[ \t]*(?:#[ \t]*|;[ \t]*){re.escape(UNUSED)}[ \t]*$")
#: The first line of a form, and what it says while something is to be filled in.
_TITLE: Final = re.compile(
    r"(# set-up of [^\r\n]*: mm and degrees)(?:; write numbers where it says measure)?(?=\r?\n|\Z)"
)
_TODO: Final = "; write numbers where it says measure"


def merge_setup(
    text: str,
    edits: Iterable[Edit],
    unused: Iterable[Key] = (),
    used: Iterable[Key] = (),
    headers: Mapping[str, str] | None = None,
) -> str:
    """The text of a set-up with more in it.

    Parameters
    ----------
    unused, used : iterable of tuple
        Keys of it that get the remark :data:`UNUSED`, and keys that lose it.
    headers : mapping, optional
        Remarks behind the headers of tables that are not there yet.

    Raises
    ------
    UnknownLayoutError
    """
    expected, merged = tomllib.loads(text), text
    for edit in edits:
        expected = _put(expected, edit.key, tomllib.loads(f"x = {edit.value}")["x"])
        merged = plan_edit(merged, edit, headers).apply(merged)
    for keys, is_unused in ((used, False), (unused, True)):
        for key in keys:
            merged = _mark(merged, key, is_unused=is_unused)
    if title := _TITLE.match(merged):
        merged = title[1] + (_TODO if re.search(r"""=\s*["']measure["']""", merged) else "") + merged[title.end() :]
    if not merged.endswith("\n"):
        merged += "\r\n" if "\r\n" in text else "\n"
    try:
        is_right = tomllib.loads(merged) == expected
    except tomllib.TOMLDecodeError:
        is_right = False
    if not is_right:
        raise UnknownLayoutError
    return merged


def turn_into_remark(text: str, key: Key) -> str:
    """The text of a set-up in which the line of a key is a remark: its value stays to be read."""
    entry = next((entry for entry in list_entries(text) if not entry.depth and entry.key == key), None)
    if entry is None:
        raise UnknownLayoutError
    return f"{text[: entry.begin]}# {text[entry.begin :]}"


def show_key(key: Key) -> str:
    """A key with its tables, as messages write it."""
    return make_printable(".".join(quote_key(part) for part in key))


def _put(data: Mapping[str, Any], key: Key, value: object) -> dict[str, Any]:
    """A copy of nested tables in which a key has a value."""
    inner = value if len(key) == 1 else _put(data.get(key[0], {}), key[1:], value)
    return {**data, key[0]: inner}


def _mark(text: str, key: Key, *, is_unused: bool) -> str:
    """The text with the remark behind a key, or without it."""
    entry = next((entry for entry in list_entries(text) if not entry.depth and entry.key[: len(key)] == key), None)
    if entry is None:
        return text
    end = find_line_end(entry, text)
    behind = text[entry.end : end]
    kept = _UNUSED_REMARK.sub("", behind.rstrip("\r\n"))
    remark = "" if not is_unused else f"; {UNUSED}" if "#" in kept else f"  # {UNUSED}"
    return text[: entry.end] + kept + remark + behind[len(behind.rstrip("\r\n")) :] + text[end:]
