"""Edits of set-ups, settings and machine files: what a message says of a key, a value or what is missing."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from verne_post.base.printable import quote_key
from verne_post.base.program_lines import split_lines
from verne_post.base.suggestions import find_suggestion
from verne_post.cli.lsp.edits import (
    REPLACE_PASTED,
    TO_FILL_IN,
    Fix,
    change_texts,
    change_words,
    find_offset,
    plan_change,
    read_setup,
)
from verne_post.cli.lsp.places import MARK, cut_file
from verne_post.config.toml_entries import (
    SYNTAX_PLACE,
    Edit,
    Key,
    find_entry,
    find_place,
    find_value,
    list_entries,
    list_seen_entries,
)
from verne_post.config.toml_text import COLON, LACKS_COMMA, LACKS_EQUALS, read_toml, replace_pasted
from verne_post.model.findings import Finding, Remedy

#: A value of a TOML file that is written as none of TOML, as a number with a comma, and a number in quotes.
_VALUE_OF_TOML: Final = re.compile(
    r"((?<=not a TOML file: ).+?|[-+\d.]+[ \t]+[a-zA-Z°]+|\S+): (?:[^;:]+; )?"
    r"write (\"[^\"]+\"|\[.*\]|\{.*\}|[^\s,;]+)(?:, in|$)"
    r"|= '(([-+]?\d+(?:\.\d+)?)(?: *(?:mm|deg|°))?)': expected a (?:whole )?number"
)
#: What a message says is missing there, and how it is written.
_BETWEEN: Final = {LACKS_EQUALS: " = ", COLON: " = ", LACKS_COMMA: ", "}
_LIKE_TOOL: Final = re.compile(r"; did you mean T=\"([^\"]+)\"\?$")
_KEY_PART: Final = re.compile(r"\"[^\"]*\"|'[^']*'|[\w-]+")
#: How a remedy ends that corrects a number of the set-up.
SLIP_THERE: Final = " wrong there?"
#: What stands for what nobody has said, by the table of the set-up.
_MARKS: Final = {"wcs": '"measure"', "tools": '{ length = "measure" }', "remap": '"decide"'}


def keeps_toml(fix: Fix) -> bool:
    """Whether a TOML file is one after an edit; of one that was none, the next mistake may stand behind the edit."""
    if fix.path.suffix != ".toml":
        return True
    before, after = _find_mistake(fix.text or ""), _find_mistake(change_texts(fix, {})[fix.path])
    if before is None or after is None:
        return after is None
    head, text = f"{(fix.text or '')[: fix.begin]}{fix.new}", change_texts(fix, {})[fix.path]
    at = find_offset(text, after[0] - 1) + after[1] - 1
    # in the same value it is what the edit leaves wrong
    return after[0] > before[0] or re.search(r"[,\n]", text[len(head) : at]) is not None


def _find_mistake(text: str) -> tuple[int, int] | None:
    """The line and column, from 1, where a text is no TOML; zeros where that is not told."""
    try:
        read_toml(text.encode())
    except ValueError as error:
        place = SYNTAX_PLACE.search(str(error))
        return (0, 0) if place is None else (int(place[1]), int(place[2]))
    return None


def propose_file_fixes(path: Path, item: Finding, text: str) -> Iterator[Fix]:
    """What a message means by a name, and lines for what it says is missing."""
    yield from mark_missing(item, path, {path: text})
    sentence = cut_file(item.message)
    near, place = find_suggestion(sentence), find_place(text.removeprefix(MARK), sentence)
    if near and place is not None:
        begin = find_offset(text, place[0] - 1) + place[1]
        end = begin + place[2] - place[1]
        if re.match(r"\S+ = ", sentence):  # of its value
            wrong = next((one for one in list_entries(text) if one.begin == begin), None)
            if wrong is not None:
                new = near if near in ("true", "false") else f'"{near}"'
                title = f"Write {new} in place of {text[wrong.value : wrong.end]}"
                yield Fix(title, path, text, wrong.value, wrong.end, new)
        else:  # of the last part of its key
            written = re.search(r"(?:\"[^\"]*\"|'[^']*'|[\w-]+)(?=\W*$)", text[begin:end])
            if written is not None:
                begin, end = begin + written.start(), begin + written.end()
                yield Fix(f"Write {near} in place of {written[0]}", path, text, begin, end, quote_key(near))
    wrong_value = _VALUE_OF_TOML.search(sentence)
    if wrong_value is not None:
        lines, at = split_lines(text), item.line or 1
        written = re.search(rf"(?<![\w.]){re.escape(wrong_value[1] or wrong_value[3])}(?![\w.])", lines[at - 1])
        quoted = re.search(rf"([\"']){re.escape(wrong_value[3] or '')}\1", lines[at - 1]) if wrong_value[3] else None
        if (there := quoted or written) is not None:
            begin, new = find_offset(text, at - 1) + there.start(), wrong_value[2] or wrong_value[4]
            yield Fix(f"Write {new} in place of {there[0]}", path, text, begin, begin + len(there[0]), new)
    yield from _write_between(path, sentence, text)
    if (new := replace_pasted(text)) != text:
        signs = enumerate(zip(text, new, strict=True))
        yield change_words(REPLACE_PASTED, path, text, [(k, k + 1, one) for k, (had, one) in signs if one != had])
    missing = re.match(r"([\w.-]+) is missing\b", sentence)
    if missing is not None and (change := plan_change(text, tuple(missing[1].split(".")), TO_FILL_IN)):
        title = f"Add {missing[1]} = {TO_FILL_IN}, to be filled in"
        yield Fix(title, path, text, change.begin, change.end, change.new)


def _write_between(path: Path, sentence: str, text: str) -> Iterator[Fix]:
    """The = or the comma that a line lacks before the place where a text stops being TOML."""
    new = next((one for what, one in _BETWEEN.items() if sentence.endswith(what)), "")
    if not new or (place := _find_mistake(text)) is None or not place[0]:
        return
    at = find_offset(text, place[0] - 1) + place[1] - 1
    begin, end = len(text[:at].rstrip()), at + (text[at : at + 1] in (":", ";"))
    title = f"Write {new.strip()} after {text[:begin].split()[-1]}"
    yield Fix(title, path, text, begin, end + len(text[end:]) - len(text[end:].lstrip(" \t")), new)


def mark_missing(item: Finding, setup: Path, texts: Mapping[Path, str]) -> Iterator[Fix]:
    """Entries of a set-up that is there, to be filled in: until then the program is refused, or says what it lacks."""
    text = read_setup(setup, texts)
    if find_suggestion(item.message):  # it is to be written in another way
        key = find_meant_tool(item)
        entry = find_entry(list_seen_entries(text), key) if key else None
        if entry is not None:
            end, name = entry.key_end, item.settled_by[0][1]
            *_above, written = _KEY_PART.finditer(text, entry.begin, end)
            new = json.dumps(name) if written[0][0] in "\"'" else quote_key(name)
            title = f"Write {new} in place of {written[0]} in {setup.name}"
            yield Fix(title, setup, text, written.start(), end, new)
        return
    for key in (key for key in item.settled_by if key[0] in _MARKS):
        fix = _mark_diameter(setup, text, key) if key[2:] == ("diameter",) else None
        change = plan_change(text, key[:2], _MARKS[key[0]])
        if fix is not None:
            yield fix
        elif change is not None and change.begin == change.end:  # what stands there is not replaced
            title = f"Add {key[0]}.{quote_key(key[1])} = {_MARKS[key[0]]} to {setup.name}, to be filled in"
            yield Fix(title, setup, text, change.begin, change.end, change.new)


def find_meant_tool(item: Finding) -> Key:
    """The key of the tool of a set-up whose name is nearly that of a finding; empty where there is none."""
    near = _LIKE_TOOL.search(item.message)
    is_of_tool = any(key[:1] == ("tools",) for key in item.settled_by)
    return ("tools", near[1]) if near is not None and is_of_tool else ()


def _mark_diameter(setup: Path, text: str, key: Key) -> Fix | None:
    """The diameter of a tool, to be filled in: beside its length, also where that is the one of the whole program."""
    tool, name, length = key[:2], f"{key[0]}.{quote_key(key[1])}", find_value(text, ("tool_length",))
    left, edit, words = text, Edit(key, TO_FILL_IN), list[tuple[int, int, str]]()
    if find_value(text, key):
        return None
    if not find_value(text, tool):
        if (whole := re.search(r"(?m)^[ \t]*tool_length[ \t]*=.*\n?", text)) is not None:
            words, left = [(*whole.span(), "")], text[: whole.start()] + text[whole.end() :]
        edit = Edit(tool, f"{{ length = {length or TO_FILL_IN}, diameter = {TO_FILL_IN} }}")
    change = plan_change(left, edit.key, edit.value)
    if change is None:
        return None
    what = f"{name}{'.diameter' * (edit.key == key)} = {edit.value}"
    title = f"Add {what} to {setup.name}{' in place of tool_length' * bool(words)}, to be filled in"
    below = len(text) - len(left) if words and change.begin >= words[0][0] else 0
    return change_words(title, setup, text, sorted([*words, (change.begin + below, change.end + below, change.new)]))


def change_setup(setup: Path | None, remedy: Remedy, texts: Mapping[Path, str]) -> Fix | None:
    """A key of the set-up."""
    if setup is None:
        return None
    text = read_setup(setup, texts) if setup in texts or setup.is_file() else None
    change = plan_change(text or "", remedy.key, remedy.value)
    if change is None:
        return None
    is_moved = remedy.key[0] == "wcs" and not remedy.text.endswith(SLIP_THERE)
    what = "Clamp the part at" if is_moved else "Set"
    title = f"{what} {'.'.join(remedy.key)} = {remedy.value} in {setup.name}"
    return Fix(title, setup, text, change.begin, change.end, change.new)
