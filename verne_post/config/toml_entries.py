"""Where the keys of a TOML file stand in its text: one scanner, for the places of mistakes and for edits.

tomllib says what a file means, and not where.
"""

import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from itertools import islice
from typing import Final

from msgspec import Struct, structs

from verne_post.base.printable import quote_key

Key = tuple[str, ...]

_BLANK: Final = re.compile(r"[ \t]*")
_BLANK_LINES: Final = re.compile(r"(?:\s|#[^\n]*)*")
_PART: Final = re.compile(r"\"(?:[^\"\\\n]|\\.)*\"|'[^'\n]*'|[\w-]+")
#: A text, of one line or of several; or a number, a date, a word, to the next comma, bracket or remark.
_PLAIN: Final = re.compile(
    r"\"\"\"(?:[^\\]|\\.)*?\"{3,5}|'''.*?'{3,5}|\"(?:[^\"\\\n]|\\.)*\"|'[^'\n]*'"
    r"|[^\s,#\[\]{}]+(?:[ \t]+[^\s,#\[\]{}]+)*",
    re.DOTALL,
)
#: The header of a table on a line of its own.
_HEADER: Final = re.compile(r"^[ \t]*\[\[?[ \t]*[\w\"'-][^\n=,{}]*\]\n", re.MULTILINE)
_REMARK_LINE: Final = re.compile(r"[ \t]*#")
#: A key that may go on: bare, or in a quote that is open; a value likewise, with the points and signs of numbers.
_UNFINISHED_KEY: Final = re.compile(r"[\w-]*|\"[^\"\n]*|'[^'\n]*")
_UNFINISHED_VALUE: Final = re.compile(r"[\w.+-]*|\"[^\"\n]*|'[^'\n]*")
#: How a sentence about a mistake of the syntax ends.
SYNTAX_PLACE: Final = re.compile(r" \(at line (\d+), column (\d+)\)$")
#: How sentences name a value of a list.
_VALUE: Final = re.compile(r", value (\d+)")
#: Where the settings stand in a file of several tools.
OF_TOOLS: Final = ("tool", "verne-post")


class UnknownLayoutError(ValueError):
    """The text is no TOML, or TOML whose keys are written in a way that is not seen here."""


class Entry(Struct, frozen=True):
    """A key with its value, an element of an array, or the header of a table; offsets count characters of the text."""

    table: Key  #: That of the header above; of a header its own. A table of an array has its number, from 0.
    name: Key  #: As the line writes it, which may have dots, behind what it is inside of; empty for a header.
    begin: int  #: Of the key; of an element its value.
    key_end: int
    value: int  #: Where the value begins; a header has none.
    end: int
    depth: int = 0  #: Brackets and braces around it.

    @property
    def key(self) -> Key:
        """From the top of the file on."""
        return self.table + self.name


class Edit(Struct, frozen=True):
    """A key of a file that gets a value where it has none, or in place of the one that it has."""

    key: Key  #: Its table and name; one of a tool has three parts, and a whole tool two.
    value: str  #: As TOML.
    remark: str = ""  #: Behind it, where the line is new.


class Change(Struct, frozen=True):
    """What stands from ``begin`` to ``end`` in a text becomes ``new``."""

    begin: int
    end: int
    new: str

    def apply(self, text: str) -> str:
        """The text with the change."""
        return text[: self.begin] + self.new + text[self.end :]


class Cursor(Struct, frozen=True):
    """What is being written at the end of a text: a key, the name of a table, or a value."""

    table: Key  #: In which the key, or the table, is to stand.
    begin: int  #: Offset of what is written of it.
    key: Key = ()  #: Whose value it is; empty for a key.
    is_header: bool = False  #: Behind a bracket at the beginning of a line.


class _Scanner:
    """Reads a text from its beginning; ``entries`` are those before ``at``, and ``cursor`` is what was read last."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.entries: list[Entry] = []
        self.table: Key = ()
        self.numbers: dict[Key, int] = {}
        self.cursor = Cursor((), 0)

    def read(self) -> None:
        while True:
            before = self.at
            if "\n" in self.text[before : self.skip(_BLANK_LINES)]:
                self.cursor = Cursor(self.table, self.at)
            if self.at >= len(self.text):
                return
            if self.text[self.at] == "[":
                self.read_header()
            else:
                self.read_pair((), 0)
            if self.skip(_BLANK) < len(self.text) and self.text[self.at] not in "\r\n#":
                raise UnknownLayoutError

    def skip(self, blank: re.Pattern[str]) -> int:
        self.at = self.match(blank).end()
        return self.at

    def match(self, pattern: re.Pattern[str]) -> re.Match[str]:
        found = pattern.match(self.text, self.at)
        if found is None:
            raise UnknownLayoutError
        return found

    def take(self, mark: str) -> None:
        if not self.text.startswith(mark, self.at):
            raise UnknownLayoutError
        self.at += len(mark)

    def read_header(self) -> None:
        begin = self.at
        is_array = self.text.startswith("[[", begin)
        self.take("[[" if is_array else "[")
        name, _end = self.read_key((), is_header=True)
        self.take("]]" if is_array else "]")
        self.table = ()
        for part in name:  # a table inside one of an array is inside the last one
            self.table = (*self._number(self.table), part)
        if is_array:
            self.numbers[self.table] = self.numbers.get(self.table, -1) + 1
        self.table = self._number(self.table)
        self.entries.append(Entry(self.table, (), begin, self.at, self.at, self.at))

    def _number(self, table: Key) -> Key:
        return (*table, str(self.numbers[table])) if table in self.numbers else table

    def read_key(self, above: Key, *, is_header: bool = False) -> tuple[Key, int]:
        """The parts of a key with dots, and where the last one ends; ``above`` is the table that has it."""
        parts: list[str] = []
        while True:
            self.cursor = Cursor((*above, *parts), self.skip(_BLANK), is_header=is_header)
            written = self.match(_PART)
            part = written[0]
            parts.append(tomllib.loads(f"x = {part}")["x"] if part[0] in "\"'" else part)
            self.at = written.end()
            if not self.text.startswith(".", self.skip(_BLANK)):
                return tuple(parts), written.end()
            self.at += 1

    def read_pair(self, above: Key, depth: int) -> None:
        begin = self.at
        name, key_end = self.read_key((*self.table, *above))
        self.take("=")
        self.skip(_BLANK)
        self.read_value((*above, *name), begin, key_end, depth)

    def read_value(self, name: Key, begin: int, key_end: int, depth: int) -> None:
        value, place = self.at, len(self.entries)
        self.cursor = Cursor(self.table, value, (*self.table, *name))
        if self.text.startswith("{", value):
            self.read_list("}", name, depth + 1)
        elif self.text.startswith("[", value):
            self.read_list("]", name, depth + 1)
        else:
            self.at = self.match(_PLAIN).end()
        self.entries.insert(place, Entry(self.table, name, begin, key_end, value, self.at, depth))

    def read_list(self, closing: str, name: Key, depth: int) -> None:
        """What stands in brackets or braces."""
        self.at += 1
        count = 0
        while not self.text.startswith(closing, self.skip(_BLANK_LINES)):
            if closing == "}":
                self.cursor = Cursor((*self.table, *name), self.at)
                self.read_pair(name, depth)
            else:
                self.read_value((*name, str(count)), self.at, self.at, depth)
            count += 1
            if not self.text.startswith(closing, self.skip(_BLANK_LINES)):
                self.take(",")
        self.at += 1


def list_entries(text: str) -> list[Entry]:
    """The keys of a text; those in brackets and braces come behind the one that they are inside of.

    Raises
    ------
    UnknownLayoutError
    """
    scanner = _Scanner(text)
    try:
        scanner.read()
    except (tomllib.TOMLDecodeError, RecursionError):
        raise UnknownLayoutError from None
    return scanner.entries


def list_seen_entries(text: str) -> list[Entry]:
    """The keys of a text; none where it is written in a way that is not seen."""
    try:
        return list_entries(text)
    except UnknownLayoutError:
        return []


def find_cursor(text: str) -> Cursor | None:
    """What is being written at the end of a text that may be wrong above; None in a remark or behind a whole value."""
    last = text.rfind("\n") + 1
    cursor = _scan_cursor(text)
    if cursor.begin < last:  # a line above cannot be read: its table is enough
        heads = list(_HEADER.finditer(text, 0, last))
        head = heads[-1][0] if heads else ""
        shift = last - len(head)
        cursor = _scan_cursor(head + text[last:])
        cursor = structs.replace(cursor, begin=cursor.begin + shift)
    written = _UNFINISHED_VALUE if cursor.key else _UNFINISHED_KEY
    if cursor.begin < last or _REMARK_LINE.match(text, last) or written.fullmatch(text, cursor.begin) is None:
        return None
    return cursor


def _scan_cursor(text: str) -> Cursor:
    scanner = _Scanner(text)
    with suppress(UnknownLayoutError, tomllib.TOMLDecodeError, RecursionError):
        scanner.read()
    return scanner.cursor


def find_value(text: str, key: Key) -> str:
    """What is written as the value of a key, as far as the text can be read; of a table its header; else empty."""
    scanner = _Scanner(text)
    with suppress(UnknownLayoutError, tomllib.TOMLDecodeError, RecursionError):
        scanner.read()
    found = next((one for one in scanner.entries if one.key == key), None)
    return "" if found is None else text[found.value if found.name else found.begin : found.end]


def find_place(text: str, sentence: str, least: int = 1) -> tuple[int, int, int] | None:
    """Where that stands of which a sentence about a TOML file begins: a key, its table where it is missing.

    Of a mistake of the syntax it is what the sentence names.

    Parameters
    ----------
    least : int
        So many names of the key, or more, stand in the sentence.

    Returns
    -------
    tuple of int or None
        Line from 1, and the columns from 0 where it begins and ends; None where no place is meant.
    """
    if place := SYNTAX_PLACE.search(sentence):
        return int(place[1]), int(place[2]) - 1, int(place[2])
    said = _VALUE.sub(lambda value: f".{int(value[1]) - 1}", re.sub("['\"]", "", sentence).lstrip("["))
    best, found, parts = "", None, 0
    for entry in list_seen_entries(text):
        key = entry.key[len(OF_TOOLS) :] if entry.key[: len(OF_TOOLS)] == OF_TOOLS else entry.key
        # the header [keep_out.NAME] names keep_out too; one of an array is one of several
        is_whole = entry.name or any(part.isdecimal() for part in key)
        for count in range(max(len(key) if is_whole else 1, least), len(key) + 1):
            name = ".".join(key[:count]).replace('"', "").replace("'", "")
            # "wcs: G540 is no work system" is about wcs.G540, if there is one
            if len(name) > len(best) and any(_is_named(one, name) for one in (said, said.replace(": ", ".", 1))):
                best, found, parts = name, entry, count
    if found is None:
        return None
    begin = text.rfind("\n", 0, found.begin) + 1
    end = found.key_end if found.key_end > found.begin else found.end
    if not found.name and parts < len(found.key):
        end = next((one.end() for one in islice(_PART.finditer(text, found.begin, end), parts - 1, None)), end)
    return text.count("\n", 0, begin) + 1, found.begin - begin, end - begin


def _is_named(sentence: str, name: str) -> bool:
    after = sentence[len(name) : len(name) + 1]
    return sentence.startswith(name) and not (after.isalnum() or after in ("_", "-"))


def find_entry(entries: list[Entry], key: Key) -> Entry | None:
    """The entry of a key; None where it has none."""
    return next((entry for entry in entries if entry.name and entry.key == key), None)


def plan_edit(text: str, edit: Edit, headers: Mapping[str, str] | None = None) -> Change:
    """The change that gives a key a value: in place of its value, in the braces of its table, or on a line of its own.

    A new line comes behind the last one of its table; a table that is not there is added.

    Parameters
    ----------
    headers : mapping, optional
        Remarks behind the headers of tables that are not there yet.

    Raises
    ------
    UnknownLayoutError
    """
    entries = list_entries(text)
    if (known := find_entry(entries, edit.key)) is not None:
        return Change(known.value, known.end, edit.value)
    table, name = edit.key[:-1], edit.key[-1:]
    above = find_entry(entries, table)
    if above is not None:
        if text[above.value] != "{":
            raise UnknownLayoutError
        inside = text[above.value + 1 : above.end - 1].strip()
        held = f"{inside}, " if inside else ""
        return Change(above.value, above.end, f"{{ {held}{quote_key(name[0])} = {edit.value} }}")
    return _plan_line(text, [entry for entry in entries if not entry.depth], edit, headers or {})


def _plan_line(text: str, entries: list[Entry], edit: Edit, headers: Mapping[str, str]) -> Change:
    newline = "\r\n" if "\r\n" in text else "\n"
    table, name = edit.key[:-1], edit.key[-1:]
    own = [entry for entry in entries if entry.table == table]  # the header, too
    dotted = [entry for entry in entries if entry.name and len(entry.table) < len(table) and _holds(table, entry.key)]
    before = ""
    if own or dotted:
        last = (own or dotted)[-1]
        at, name = find_line_end(last, text), edit.key[len(last.table) :]
    elif not table:
        heads = [entry.begin for entry in entries]
        at = text.rfind("\n", 0, heads[0]) + 1 if heads else len(text)
        while (line := text[: at - 1].rfind("\n") + 1) < at and not text[line:at].strip():
            at = line
    else:
        at = len(text)
        said = f"  # {headers[table[0]]}" if table[0] in headers else ""
        gap = newline if text and text.splitlines()[-1].strip() else ""
        before = f"{gap}[{'.'.join(map(quote_key, table))}]{said}{newline}"
    if at and text[at - 1] != "\n":
        before = newline + before
    remark = f"  # {edit.remark}" if edit.remark else ""
    return Change(at, at, f"{before}{'.'.join(map(quote_key, name))} = {edit.value}{remark}{newline}")


def _holds(table: Key, key: Key) -> bool:
    return key[: len(table)] == table


def find_line_end(entry: Entry, text: str) -> int:
    """Where the line begins that follows an entry."""
    at = text.find("\n", entry.end)
    return len(text) if at < 0 else at + 1
