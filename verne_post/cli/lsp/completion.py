"""What may be written at a place: words of a program's language, keys of a set-up, of settings and of machine files."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final, get_args, get_origin

from lsprotocol import types as lsp
from msgspec import Struct
from msgspec.structs import fields

from verne_post.base.program_lines import remove_remarks
from verne_post.base.type_words import describe, list_alternatives, strip_bounds
from verne_post.cli.programs import is_setup
from verne_post.config.chain import ChainMachineFile
from verne_post.config.kinds import KINDS
from verne_post.config.program_setup import SetupFile, list_setup_options
from verne_post.config.schema import MachineFile, describe_limits_table
from verne_post.config.sentences import Table
from verne_post.config.settings import FILE_NAME, PROJECT_FILE, SettingsFile
from verne_post.config.toml_entries import OF_TOOLS, Key, find_value, scan_table
from verne_post.gcode.known_words import list_words
from verne_post.model.options import OPTIONS, find_about

#: Dialect -> how the tables of words call its language.
_LANGUAGES: Final = {"rs274": "RS274/NGC", "fanuc": "Fanuc", "siemens": "Siemens", "heidenhain": "Klartext"}


class Choice(Struct, frozen=True):
    """What may stand from column ``begin`` of a line to the cursor, and what it does."""

    begin: int
    word: str
    meaning: str


def complete_word(line: str, column: int, dialect: str) -> list[Choice]:
    """Words that are executed, and begin as the text before the cursor; what `explain WORD` says of each.

    A code may have several rows: it is offered once, with all that it does.
    """
    before = line[:column]
    known: dict[str, list[str]] = {}
    for language, word, meaning, is_executed in list_words():
        if language == _LANGUAGES.get(dialect) and is_executed:
            known.setdefault(word, []).append(meaning)
    if remove_remarks(before) != before:
        return []
    for begin in range(len(before)):
        written = before[begin:].upper()
        if not before[begin].isalpha() or (begin and (before[begin - 1].isalpha() or before[begin - 1] == "_")):
            continue
        if found := [word for word in known if word.startswith(written)]:
            return [Choice(begin, word, "; ".join(known[word])) for word in found]
    return []


def complete_key(path: Path, text: str, line: int, column: int) -> list[Choice]:
    """Keys of the table in which a line (from 0) stands, with the types of their values, or what options are for."""
    lines = text.split("\n")
    written = lines[line][:column].lstrip()
    if not all(one.isalnum() or one in "_-" for one in written):
        return []
    table = scan_table("\n".join([*lines[:line], ""]))
    table = table[len(OF_TOOLS) :] if table[: len(OF_TOOLS)] == OF_TOOLS else table
    begin = column - len(written)
    return [Choice(begin, key, meaning) for key, meaning in _list_keys(path, text, table) if key.startswith(written)]


def _list_keys(path: Path, text: str, table: Key) -> Iterator[tuple[str, str]]:
    """The keys that a table may have."""
    schema: type[Table] = SetupFile
    names: list[str] = [] if table else list_setup_options()
    if path.name in (FILE_NAME, PROJECT_FILE):
        if table == ("options",):
            names, schema = [name for name in OPTIONS if find_about(name).in_settings], Table
        elif len(table) > 1 and table[0] == "setup":
            table = table[2:]
            names = [] if table else list_setup_options()
        else:
            names, schema = [], SettingsFile
    elif not is_setup(path):
        names, schema = [], ChainMachineFile if find_value(text, ("schema",)) == "2" else MachineFile
        kind = KINDS.get(find_value(text, ("kind",)).strip("\"'"))
        own: Mapping[str, Any] = (
            {}
            if kind is None
            else {"module": kind.schema, "limits": describe_limits_table(kind.group, kind.rods), "rods": kind.bodies}
        )
        if table and own.get(table[0]) is not None:
            schema, table = own[table[0]], table[1:]
    yield from ((name, find_about(name).help) for name in names if name != "tools")
    if table and schema is Table:
        return
    found = _find_schema(schema, table)
    if found is not None:
        yield from ((one.encode_name, describe(one.type)) for one in fields(found) if one.encode_name not in names)


def _find_schema(schema: type[Table], table: Key) -> type[Table] | None:
    """The schema of a table inside one that has a schema; None where it has none."""
    kind: Any = schema
    for part in table:
        options = [strip_bounds(one)[0] for one in list_alternatives(strip_bounds(kind)[0])]
        inner = next((one for one in options if isinstance(one, type) and issubclass(one, Table)), None)
        of_names = next((one for one in options if get_origin(one) in (dict, list)), None)
        if inner is not None:
            kind = next((one.type for one in fields(inner) if one.encode_name == part), None)
        else:
            kind = get_args(of_names)[-1] if of_names is not None else None
        if kind is None:
            return None
    options = [strip_bounds(one)[0] for one in list_alternatives(strip_bounds(kind)[0])]
    return next((one for one in options if isinstance(one, type) and issubclass(one, Table)), None)


def make_item(choice: Choice, place: lsp.Range) -> lsp.CompletionItem:
    """A choice as editors take it; ``place`` is what it replaces."""
    return lsp.CompletionItem(
        choice.word,
        kind=lsp.CompletionItemKind.Keyword,
        detail=choice.meaning,
        filter_text=choice.word,
        text_edit=lsp.TextEdit(place, choice.word),
    )
