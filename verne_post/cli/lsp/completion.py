"""What may be written at a place: words of a program's language, keys of a set-up, of settings and of machine files."""

import json
import math
import re
from collections import abc
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final, Literal, get_args, get_origin

from lsprotocol import types as lsp
from msgspec import NODEFAULT, Struct
from msgspec.structs import FieldInfo, fields

from verne_post.base.printable import quote_key
from verne_post.base.program_lines import remove_remarks
from verne_post.base.type_words import describe, find_note, list_alternatives, strip_bounds
from verne_post.cli.lsp.outline import Outline
from verne_post.cli.programs import is_setup
from verne_post.config.chain import ChainMachineFile
from verne_post.config.kinds import KINDS
from verne_post.config.machine_paths import list_machine_files
from verne_post.config.program_setup import TO_MEASURE, SetupFile, list_setup_options
from verne_post.config.schema import MachineFile, describe_limits_table
from verne_post.config.settings import FILE_NAME, PROJECT_FILE, SettingsFile
from verne_post.config.toml_entries import (
    OF_TOOLS,
    Key,
    find_cursor,
    find_value,
    list_seen_entries,
)
from verne_post.gcode.block import KEYWORDS
from verne_post.gcode.klartext.vocabulary import STATEMENTS
from verne_post.gcode.known_words import LANGUAGES, list_meanings, list_values_of_cycle
from verne_post.gcode.letters import OF_VALUES
from verne_post.gcode.siemens.vocabulary import VALUE_MODES
from verne_post.model.control_keys import KEYS
from verne_post.model.options import OPTIONS, find_about
from verne_post.model.part_setup import SYSTEM_NUMBERS


class Choice(Struct, frozen=True):
    """What may stand from column ``begin`` of a line to the cursor, and what it does."""

    begin: int
    word: str
    meaning: str
    sought: str  #: What an editor compares with what is written.
    snippet: str = ""  #: The word with places for the values that it takes, which editors go through.


#: Where a program names a tool: after T, T=, TOOL CALL or LOADTL, and after H and D of G41 to G43.
_TOOL: Final = re.compile(
    r"(?:(?<![A-Z_])T(?:\d?[ \t]*=)?|G4[123](?:\.\d)?(?![\d.])[^(;]*(?<![A-Z_])[HD]|TOOL[ \t]+(?:CALL|DEF)"
    r"|LOADTL[ \t]*/)[ \t]*(\"?[\w.-]*)$",
    re.IGNORECASE,
)
#: How names of keys with a unit end.
_UNITS: Final = {"mm": "mm", "deg": "degrees", "s": "s", "rpm": "rev/min", "percent": "%", "hz": "Hz"}
#: What follows the number or name of an O word; first words of Klartext that stand nowhere else.
_AFTER_O: Final = re.compile(r"[ \t]*o[ \t]*(?:\d+|<[^>]*>)[ \t]+([A-Z]*)$", re.IGNORECASE)
#: A place, or the angle of a spindle, of Siemens to which a value is to be given; blocks whose X is none.
_PLACE: Final = re.compile(r"(?<![A-Z_$\d])(?:[IJK]|([XYZ])|([ABC])|(SPOS))[ \t]*=[ \t]*$", re.IGNORECASE)
_NO_PLACE: Final = re.compile(r"\b(?:DEF|FOR|A?(?:TRANS|ROTS?|SCALE|MIRROR))\b|[\"(\[]", re.IGNORECASE)
#: Languages whose expressions stand in brackets or behind =; and what begins a value or a condition of another one.
_IN_BRACKETS: Final = ("rs274", "fanuc")
_VALUE: Final = re.compile(r"[=(]|\b(?:IF|WHILE|UNTIL|CASE|FOR|FN)\b", re.IGNORECASE)
_CODE: Final = re.compile(r"[A-Z](\d+(?:\.\d+)?)")
_STATEMENTS: Final = {word.split()[0] for word in STATEMENTS} - {"R0", "RL", "RR", "M", "F", "S", "Q", "QL", "QR", "QS"}


def complete_word(
    outline: Outline,
    number: int,
    column: int,
    tools: Mapping[str, str],
    folder: Path | None = None,
    paths: tuple[str, ...] = (),
) -> list[Choice]:
    """Words that are executed, and begin as the text before the cursor; what `explain WORD` says of each.

    A code may have several rows: it is offered once, with all that it does. Where a tool is named, ``tools`` are
    offered, with their sizes; names of the program come first.

    Parameters
    ----------
    number : int
        The line, from 0.
    folder, paths
        That of the program, and those below it in which its subprograms are; None for a program alone.
    """
    before, dialect = outline.lines[number][:column], outline.dialect
    if remove_remarks(before, dialect) == before and (tool := _TOOL.search(before)):
        begin, quote = tool.start(1), tool[1][:1] == '"'
        named = (Choice(begin, word, sizes, word if quote else word.strip('"')) for word, sizes in tools.items())
        found_tools = [one for one in named if one.sought.startswith(tool[1])]
        # else it may be a word that begins with T: TRANS, and in a calculation TAN
        is_word = dialect not in ("rs274", "fanuc") or re.search(r"[\[=]", before)
        if found_tools or before[begin - 1] in " \t=/" or not is_word:
            return found_tools
    known = list_meanings(dialect, executed_alone=True)
    if remove_remarks(before) != before:
        return []
    if dialect == "rs274" and (flow := _AFTER_O.match(before)):
        words = [word for word in KEYWORDS if word.startswith(flow[1].upper())]
        return [Choice(flow.start(1), word, "; ".join(known.get(word, ())), word) for word in words]
    begun = outline.list_begun(number, column, folder, paths)
    own = [
        Choice(begin, word, line, word if before[begin : begin + 1] == '"' else word.strip('"'))
        for begin, word, line in begun
    ]
    if dialect == "siemens" and (place := _PLACE.search(before)) and not _NO_PLACE.search(before):
        has_axis, turns, is_spindle = (bool(one) for one in place.groups())
        modes = [*["AC"] * (not is_spindle), *["IC"] * (has_axis or turns), *["DC"] * (turns or is_spindle)]
        own += [Choice(column, f"{mode}(", VALUE_MODES[mode], f"{mode}(") for mode in modes]
    if dialect == "heidenhain" and before.count('"') % 2:
        return own
    for begin in range(len(before)):
        written = before[begin:].upper()
        if not before[begin].isalpha() or (begin and (before[begin - 1].isalpha() or before[begin - 1] == "_")):
            continue
        found = [word for word in known if word.startswith(written)]
        is_open = before.count("[") > before.count("]")
        if not (is_open or "=" in before) if dialect in _IN_BRACKETS else not _VALUE.search(before[:begin]):
            found = [word for word in found if word not in OF_VALUES]
        elif is_open and dialect in _IN_BRACKETS:  # no code stands in brackets
            found = [word for word in found if word in OF_VALUES]
        found.sort(key=_find_order)
        if dialect == "heidenhain" and before[:begin].strip(" \t/0123456789"):
            found = [word for word in found if word.split()[0] not in _STATEMENTS]
        if found:
            return own + [
                Choice(begin, word, "; ".join(dict.fromkeys(known[word])), word, _make_snippet(word, dialect))
                for word in found
            ]
    return own


def _find_order(word: str) -> float:
    """Words of values come first, then codes by their numbers, then the other words as their tables have them."""
    code = _CODE.fullmatch(word)
    return -1.0 if word in OF_VALUES else math.inf if code is None else float(code[1])


def _make_snippet(word: str, dialect: str) -> str:
    """A cycle with a place for each of its values, as the protocol has it; empty for other words."""
    values = list_values_of_cycle(word, dialect)
    places = "".join(f"{before}${{{number}:{name}}}" for number, (before, name) in enumerate(values, 1))
    return f"{word}{places}{')' * (dialect == 'siemens')}" if values else ""


def complete_key(path: Path, text: str, line: int, column: int) -> list[Choice]:
    """Keys, names of tables and values that may stand at a place of a set-up, of settings or of a machine file.

    Each has the type of its value, or what the option is for. Keys that the table has already are not among them.
    """
    lines = text.split("\n")
    above = sum(len(one) + 1 for one in lines[:line])
    cursor = find_cursor(text[: above + column])
    if cursor is None:
        return []
    begin, written = cursor.begin - above, text[cursor.begin : above + column]
    top = _list_top(path, text)
    if cursor.key:
        kind = find_type(top, _cut_tools(cursor.key))
        key = cursor.key[-1]
        named = (
            [f'"{name}"' for name in _NAMES[key]()]
            if key in _NAMES and strip_bounds(kind)[0] is str
            else _list_values(kind)
        )
        found = dict.fromkeys(named, _describe_values(kind))
    else:
        keys = _list_keys(find_type(top, _cut_tools(cursor.table))) or {}
        if cursor.is_header:
            found = {quote_key(name): about for name, (kind, about) in keys.items() if _list_keys(kind) is not None}
        else:
            others = "\n".join([*lines[:line], "", *lines[line + 1 :]])
            known = {one.key for one in list_seen_entries(others)} | {one.key for one in list_seen_entries(lines[line])}
            found = {
                quote_key(name): about for name, (_kind, about) in keys.items() if (*cursor.table, name) not in known
            }
    quote = written[:1] if written[:1] in ('"', "'") else ""
    choices = (
        Choice(begin, word, about, quote + word.lstrip('"') if word.startswith('"') else word)
        for word, about in found.items()
    )
    return [one for one in choices if one.sought.startswith(written)]


def _cut_tools(key: Key) -> Key:
    """A key of the settings in a file of several tools as one of their own file."""
    return key[len(OF_TOOLS) :] if key[: len(OF_TOOLS)] == OF_TOOLS else key


#: Keys of a table that is no class: the type of each, and what is said of it; ``_ANY`` stands for every other key.
_Keys = dict[str, tuple[Any, str]]
_ANY: Final = ""


def _list_top(path: Path, text: str) -> _Keys:
    """The keys at the top of a file."""
    if path.name in (FILE_NAME, PROJECT_FILE):
        return {
            **_list_fields(SettingsFile),
            **_make_control_tables(),
            "options": (_list_options([name for name in OPTIONS if find_about(name).in_settings]), "options"),
            "setup": ({_ANY: (_list_setup_keys(), "")}, "set-ups of programs, by patterns of their names"),
        }
    if is_setup(path):
        return _list_setup_keys()
    from verne_post.config.as_built import AsBuiltFile  # few machine files have it

    top = _list_fields(ChainMachineFile if find_value(text, ("schema",)) == "2" else MachineFile)
    if "as_built" in top:
        in_file = {"file": (str, "a TOML file in the same folder that has only the table [as_built]; text")}
        top["as_built"] = {**_list_fields(AsBuiltFile), **in_file}, top["as_built"][1].removesuffix("; a value")
    kind = KINDS.get(find_value(text, ("kind",)).strip("\"'"))
    if kind is not None:
        limits = describe_limits_table(kind.group, kind.rods)
        own = {"module": kind.schema, "limits": limits, "rods": kind.bodies}
        top |= {name: (schema, top[name][1]) for name, schema in own.items() if schema is not None}
    return top


def _list_setup_keys() -> _Keys:
    """Options and tables of a set-up; work offsets by the names of their systems."""
    own = {**_list_options(list_setup_options()), **_list_fields(SetupFile), **_make_control_tables()}
    of_system = find_type(own, ("wcs", _ANY))
    return {**own, "wcs": (dict.fromkeys(SYSTEM_NUMBERS, (of_system, _describe_values(of_system))), own["wcs"][1])}


def _list_options(names: Iterable[str]) -> _Keys:
    """Options with what they are for."""
    return {name: (_find_option_type(name), _describe_option(name)) for name in names}


def _describe_option(name: str) -> str:
    """What an option is for, in which unit, and its default where the help does not say it."""
    about, default = find_about(name), OPTIONS[name].default()
    unit = about.unit or find_unit(name)
    known = default in (None, {}) or "default" in about.help
    return f"{about.help}{f' In {unit}.' if unit else ''}{'' if known else f' Default: {json.dumps(default)}.'}"


def find_unit(key: str) -> str:
    """The unit of the number of a key, which its name ends with; empty without one."""
    return _UNITS.get(key.rpartition("_")[2], "") if "_" in key else ""


def _find_option_type(name: str) -> Any:
    """Type of an option; its names, where it has any."""
    choices = find_about(name).choices
    return OPTIONS[name].kind if choices is None else Literal[choices()]


def _make_control_tables() -> _Keys:
    """The tables of the controls, by dialects."""
    return {
        name: (schema, f"what builders of machines choose, for programs in {LANGUAGES[name]}")
        for name, schema in KEYS.items()
    }


def _list_fields(schema: type[Struct]) -> _Keys:
    return {one.encode_name: (one.type, _describe_field(one)) for one in fields(schema)}


def _describe_field(one: FieldInfo) -> str:
    """What a key means where its schema says it, with its values, unit and default."""
    meaning = find_note(one.type)
    unit = find_unit(one.encode_name)
    # what stands for a size that is not known yet is no value to rely on
    is_known = one.default not in (NODEFAULT, None, "", TO_MEASURE)
    default = f"default: {json.dumps(one.default)}" if is_known else ""
    needed = "required" if one.required else default
    return "; ".join(filter(None, (meaning, _describe_values(one.type), f"in {unit}" if unit else "", needed)))


def _describe_values(kind: Any) -> str:
    """What a type holds, without bounds that no machine has, and without what is not written; empty for a table."""
    if isinstance(kind, dict):
        return ""
    said = (
        re.sub(r": -1e\+12 to 1e\+12|, at most 1e\+12", "", describe(kind))
        .replace("0 to 1e+12", "0 or more")
        .replace(": 1 or more characters", "")
    )
    return "" if said.endswith(_OF_TABLES) else said.replace("one of , ", "one of ")


def describe_key(path: Path, text: str, line: int, column: int) -> str:
    """What the key or table at a place of a set-up, settings or machine file is for; empty where none is known."""
    key, *_span = find_key(text, line, column)
    if not key:
        return ""
    top = _list_top(path, text)
    if (kind := find_type(top, key)) is None:
        return ""
    known, values = (_list_keys(find_type(top, key[:-1])) or {}).get(key[-1]), _describe_values(kind)
    about = values if known is None else known[1]
    if len(key) > 1 and (about.startswith(values) if values else not about):  # what its table is for says it
        above = (_list_keys(find_type(top, key[:-2])) or {}).get(key[-2], ("", ""))[1]
        about = "; ".join(filter(None, (above.partition("; a mapping")[0].removesuffix("; required"), about)))
    return f"**{'.'.join(key)}**: {about or 'a table of keys'}"


def find_key(text: str, line: int, column: int) -> tuple[Key, int, int]:
    """The key at a place of a TOML file, and the columns where it begins and ends; empty where none is there."""
    lines = text.split("\n")
    behind = re.match(r"[\w-]*", lines[line][column:])
    end, above = column + (behind.end() if behind is not None else 0), sum(len(one) + 1 for one in lines[:line])
    cursor = find_cursor(text[: above + end])
    if cursor is None or cursor.key:
        return (), column, end
    key = _cut_tools((*cursor.table, text[cursor.begin : above + end].strip("\"'")))
    return key, cursor.begin - above, end


def _list_keys(kind: Any) -> _Keys | None:
    """The keys of a table; none for one with names of the user's own; None where it is no table."""
    if isinstance(kind, dict):
        return {name: found for name, found in kind.items() if name != _ANY}
    for one in _list_plain(kind):
        if isinstance(one, type) and issubclass(one, Struct):
            return _list_fields(one)
        if get_origin(one) is dict and get_origin(get_args(one)[0]) is Literal:
            return dict.fromkeys(get_args(get_args(one)[0]), (get_args(one)[1], _describe_values(get_args(one)[1])))
        if get_origin(one) in (dict, abc.Mapping) or (get_origin(one) is list and _list_keys(get_args(one)[0])):
            return {}
    return None


def find_type(kind: Any, key: Key) -> Any:
    """The type of a key below a table; None where there is none."""
    none = (None, "")
    for part in key:
        if isinstance(kind, dict):
            kind = (kind.get(part) or kind.get(_ANY, none))[0]
            continue
        options = _list_plain(kind)
        schema = next((one for one in options if isinstance(one, type) and issubclass(one, Struct)), None)
        of_names = next((one for one in options if get_origin(one) in (dict, abc.Mapping, list, tuple)), None)
        if schema is not None:
            kind = _list_fields(schema).get(part, (None, ""))[0]
        else:
            kind = get_args(of_names)[-1] if of_names is not None else None
    return kind


def _list_plain(kind: Any) -> list[Any]:
    """The types of a union, without their bounds."""
    return [strip_bounds(one)[0] for one in list_alternatives(strip_bounds(kind)[0])]


#: How the words for the type of a table end, or of tables by names.
_OF_TABLES: Final = ("table of keys", "tables of keys", "to values")
#: Key -> the names that its text may be.
_NAMES: Final[Mapping[str, Callable[[], Iterable[str]]]] = {
    "machine": list_machine_files,
    "kind": lambda: KINDS,
    "system": lambda: ("table", *SYSTEM_NUMBERS),
}


def _list_values(kind: Any) -> Iterator[str]:
    """The values of a type that has few of them, as TOML."""
    for one in _list_plain(kind):
        if get_origin(one) is Literal:
            yield from (f'"{name}"' if isinstance(name, str) else str(name) for name in get_args(one))
        elif one is bool:
            yield from ("true", "false")


def make_item(choice: Choice, number: int, place: lsp.Range, *, with_snippets: bool) -> lsp.CompletionItem:
    """A choice as editors take it, which show choices by ``number``; ``place`` is what it replaces."""
    is_snippet = with_snippets and choice.snippet
    return lsp.CompletionItem(
        choice.word,
        kind=lsp.CompletionItemKind.Keyword,
        detail=choice.meaning,
        sort_text=f"{number:04}",  # else G17 comes before G2
        filter_text=choice.sought,
        text_edit=lsp.TextEdit(place, choice.snippet if is_snippet else choice.word),
        insert_text_format=lsp.InsertTextFormat.Snippet if is_snippet else None,
    )
