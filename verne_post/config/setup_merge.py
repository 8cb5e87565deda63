"""A set-up that is there, with what the program needs and the file lacks: all that stands there stays as it is written.

Lines are changed one by one, so that remarks and their order stay. The result is read as TOML and compared with what it
must say; where a file is written in a way that is not seen here, nothing is changed.
"""

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from msgspec import Struct

from verne_post.base.printable import make_printable, quote_key

#: Behind a key that no line of the program asks for.
UNUSED: Final = "not used by the program"
_UNUSED_REMARK: Final = re.compile(rf"[ \t]*(?:#[ \t]*|;[ \t]*){re.escape(UNUSED)}[ \t]*$")
_HEADER: Final = re.compile(r"\s*\[+(?P<name>[^\[\]\n]+)\]+\s*(?:#.*)?$")
#: The first line of a form, and what it says while something is to be filled in.
_TITLE: Final = re.compile(r"(# set-up of .*: mm and degrees)(?:; write numbers where it says measure)?$")
_TODO: Final = "; write numbers where it says measure"

Key = tuple[str, ...]


class UnknownLayoutError(ValueError):
    """The file is TOML, and a line of it is written in a way that is not seen here."""


class Edit(Struct, frozen=True):
    """A key of a set-up that gets a value where it has none, or where it is still to be filled in."""

    key: Key  #: Its table and name; one of a tool has three parts, and a whole tool two.
    value: str  #: As TOML.
    remark: str = ""  #: Behind it, where the line is new.


class _Entry(Struct):
    """Lines that give one key a value."""

    table: Key  #: Of the header above.
    name: Key  #: As the line writes it, which may have dots.
    first: int
    last: int  #: The line after the last one.


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
    text : str
        TOML.
    edits : iterable of Edit
        What is to be written.
    unused, used : iterable of tuple
        Keys of it that get the remark :data:`UNUSED`, and keys that lose it.
    headers : mapping, optional
        Remarks behind the headers of tables that are not there yet.

    Raises
    ------
    UnknownLayoutError
    """
    newline = "\r\n" if "\r\n" in text else "\n"
    before = tomllib.loads(text)
    expected = before
    lines = text.splitlines()
    for edit in edits:
        expected = _put(expected, edit.key, tomllib.loads(f"x = {edit.value}")["x"])
        _write(lines, edit, headers or {})
    for keys, is_unused in ((used, False), (unused, True)):
        for key in keys:
            _mark(lines, key, is_unused=is_unused)
    if lines and (title := _TITLE.match(lines[0])):
        lines[0] = title[1] + (_TODO if re.search(r"""=\s*["']measure["']""", "\n".join(lines)) else "")
    merged = newline.join([*lines, ""])
    try:
        is_right = tomllib.loads(merged) == expected
    except tomllib.TOMLDecodeError:
        is_right = False
    if not is_right:
        raise UnknownLayoutError
    return merged


def show_key(key: Key) -> str:
    """A key with its tables, as messages write it."""
    return make_printable(".".join(quote_key(part) for part in key))


def _put(data: Mapping[str, Any], key: Key, value: object) -> dict[str, Any]:
    """A copy of nested tables in which a key has a value."""
    inner = value if len(key) == 1 else _put(data.get(key[0], {}), key[1:], value)
    return {**data, key[0]: inner}


def _list_entries(lines: list[str]) -> Iterator[_Entry]:
    """The keys of a text; a value of several lines belongs to one."""
    table: Key = ()
    at = 0
    while at < len(lines):
        first, line = at, lines[at]
        at += 1
        if not (bare := line.strip()) or bare.startswith("#"):
            continue
        if header := _HEADER.match(line):
            table = _split_key(header["name"])
            yield _Entry(table, (), first, at)
            continue
        while not _is_whole("\n".join(lines[first:at])) and at < len(lines):
            at += 1
        name = re.match(r"""\s*((?:"(?:[^"\\]|\\.)*"|'[^']*'|[^"'=])+)=""", line)
        if name is None:
            raise UnknownLayoutError
        yield _Entry(table, _split_key(name[1]), first, at)


def _is_whole(text: str) -> bool:
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return False
    return True


def _split_key(text: str) -> Key:
    """The parts of a key with dots."""
    try:
        data: Any = tomllib.loads(f"{text.strip()} = 0")
    except tomllib.TOMLDecodeError:
        raise UnknownLayoutError from None
    parts: list[str] = []
    while isinstance(data, dict):
        ((part, data),) = data.items()
        parts.append(part)
    return tuple(parts)


def _find(entries: list[_Entry], key: Key) -> _Entry | None:
    return next((entry for entry in entries if entry.name and entry.table + entry.name == key), None)


def _write(lines: list[str], edit: Edit, headers: Mapping[str, str]) -> None:
    """Give a key a value: where it has one, in a tool that has a line, or on a line of its own."""
    entries = list(_list_entries(lines))
    if (known := _find(entries, edit.key)) is not None:
        _replace(lines, known, r"=\s*", edit.value)
    elif len(edit.key) == 3 and (tool := _find(entries, edit.key[:2])) is not None:
        _write_in_braces(lines, tool, edit.key[2], edit.value)
    else:
        _insert(lines, entries, edit, headers)


def _replace(lines: list[str], entry: _Entry, before: str, value: str) -> None:
    """Put a value in place of a plain one of one line."""
    line = lines[entry.first]
    match = re.search(rf"""({before})("[^"]*"|'[^']*'|[^\s,#\[\]{{}}]+)""", line)
    if match is None or entry.last != entry.first + 1:
        raise UnknownLayoutError
    lines[entry.first] = line[: match.start(2)] + value + line[match.end(2) :]


def _write_in_braces(lines: list[str], entry: _Entry, name: str, value: str) -> None:
    """A size of a tool that is written on one line, ``5 = { length = 80 }``."""
    line = lines[entry.first]
    if re.search(rf"[{{,]\s*{name}\s*=", line):
        _replace(lines, entry, rf"[{{,]\s*{name}\s*=\s*", value)
        return
    match = re.search(r"\{\s*([^{}]*?)\s*\}", line)
    if match is None:
        raise UnknownLayoutError
    held = f"{match[1]}, " if match[1] else ""
    lines[entry.first] = f"{line[: match.start()]}{{ {held}{name} = {value} }}{line[match.end() :]}"


def _insert(lines: list[str], entries: list[_Entry], edit: Edit, headers: Mapping[str, str]) -> None:
    """A line with a new key, behind those of its table."""
    remark = f"  # {edit.remark}" if edit.remark else ""
    table, name = edit.key[:-1], edit.key[-1:]
    own = [entry for entry in entries if entry.table == table]  # the header, too
    dotted = [entry for entry in entries if not entry.table and entry.name[: len(table)] == table]
    if not table:
        heads = [entry.first for entry in entries if entry.table]
        at = own[-1].last if own else heads[0] if heads else len(lines)
        while at and not own and not lines[at - 1].strip():
            at -= 1
    elif own:
        at = own[-1].last
    elif dotted:
        at, name = dotted[-1].last, edit.key
    else:
        said = f"  # {headers[table[0]]}" if table[0] in headers else ""
        lines += [*([""] if lines and lines[-1].strip() else []), f"[{'.'.join(map(quote_key, table))}]{said}"]
        at = len(lines)
    lines.insert(at, f"{'.'.join(map(quote_key, name))} = {edit.value}{remark}")


def _mark(lines: list[str], key: Key, *, is_unused: bool) -> None:
    """Write the remark behind a key, or take it away."""
    for entry in _list_entries(lines):
        if (entry.table + entry.name)[: len(key)] != key:
            continue
        line = _UNUSED_REMARK.sub("", lines[entry.last - 1])
        if is_unused:
            has_remark = _is_whole(f"{line}; {UNUSED}")
            line += f"; {UNUSED}" if has_remark else f"  # {UNUSED}"
        lines[entry.last - 1] = line
        return
