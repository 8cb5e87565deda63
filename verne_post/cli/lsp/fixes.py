"""Edits that settle a finding: each was made in a copy, and the copy checked, before it is offered."""

import dataclasses
import json
import logging
import re
import threading
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Final

from msgspec import Struct
from msgspec.structs import replace

from verne_post.app.assemble import SPLIT_KEY
from verne_post.app.remedies.refused import list_ends
from verne_post.base.numbers import format_count
from verne_post.base.pasted import translate_pasted
from verne_post.base.printable import quote_key
from verne_post.base.program_lines import find_word, find_word_of, remove_remarks, split_lines, write_like
from verne_post.base.stopping import stop_by
from verne_post.base.suggestions import find_suggestion
from verne_post.base.units import MM_PER_INCH
from verne_post.cli.lsp.addresses import find_end_of_places
from verne_post.cli.lsp.inspector import Inspected, Inspector, SupersededError, require_wanted
from verne_post.cli.lsp.places import MARK, cut_file, find_range
from verne_post.cli.setup import make_setup
from verne_post.cli.setups import NONE
from verne_post.config.toml_entries import (
    SYNTAX_PLACE,
    Change,
    Edit,
    Key,
    UnknownLayoutError,
    find_entry,
    find_place,
    find_value,
    list_entries,
    list_seen_entries,
    plan_edit,
)
from verne_post.config.toml_text import COLON, LACKS_COMMA, LACKS_EQUALS, read_toml, replace_pasted
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.machining.holes import TAPPING_KEY
from verne_post.gcode.rs274.fanuc_points import list_missing_points
from verne_post.model.findings import Finding, Remedy
from verne_post.model.verdict import count_findings, is_about_pose, is_about_text

#: T with a name.
_NAMED_TOOL: Final = re.compile(r"(?<![A-Z_])(T\d?[ \t]*=[ \t]*)(\"[^\"]+\")", re.IGNORECASE)
_TOOL_CALL: Final = re.compile(r"\bTOOL[ \t]+CALL\b", re.IGNORECASE)
#: A line of Klartext that goes to a place.
_PATH_OF_KLARTEXT: Final = re.compile(r"\s*(?:\d+\s+)?L\b[^;]*")
#: A value of a TOML file that is written as none of TOML, as a number with a comma, and a number in quotes.
_VALUE_OF_TOML: Final = re.compile(
    r"((?<=not a TOML file: ).+?|[-+\d.]+[ \t]+[a-zA-Z°]+|\S+): (?:[^;:]+; )?"
    r"write (\"[^\"]+\"|\[.*\]|\{.*\}|[^\s,;]+)(?:, in|$)"
    r"|= '(([-+]?\d+(?:\.\d+)?)(?: *(?:mm|deg|°))?)': expected a (?:whole )?number"
)
#: What a message says is missing there, and how it is written.
_BETWEEN: Final = {LACKS_EQUALS: " = ", COLON: " = ", LACKS_COMMA: ", "}
_REPLACE_PASTED: Final = "Replace typographic dashes, quotes and spaces"
#: What stands before the rest of an expression: without that, a variable would get another value.
_REST_OF_VALUE: Final = re.compile(r"#[^=]*=.*[\w.\])>]$")
#: A word with a number, and a label of RS274/NGC.
_NUMBERED: Final = re.compile(r"[A-Z]{1,2}[-+]?[\d.]+|o?<[^<>]*>", re.IGNORECASE)
_LIKE_M99: Final = re.compile(r"\n[ \t]*(?:N\d+[ \t]*)?[MN]\d?9\d?\s*\Z", re.IGNORECASE)
_LIKE_TOOL: Final = re.compile(r"; did you mean T=\"([^\"]+)\"\?$")
_KEY_PART: Final = re.compile(r"\"[^\"]*\"|'[^']*'|[\w-]+")
_PROC: Final = re.compile(r"[ \t]*(?:N\d+[ \t]*)?PROC\b", re.IGNORECASE)
#: What stands in a new line of a file until it is filled in: a wrong value, whose message says what is right.
_TO_FILL_IN: Final = '"measure"'
#: Findings that are mistakes of a program much more often than of the place of its part: a depth with a digit too many.
_OF_PROGRAMS: Final = ("VP210",)
#: How a remedy ends that corrects a number of the set-up.
_SLIP_THERE: Final = " wrong there?"
#: What stands for what nobody has said, by the table of the set-up.
_MARKS: Final = {"wcs": '"measure"', "tools": '{ length = "measure" }', "remap": '"decide"'}
#: Keys of a set-up that stand in no table of it, and what settles a finding.
_SETTLING: Final[dict[tuple[str, ...], str]] = {SPLIT_KEY: "true", TAPPING_KEY: '"feed"'}


#: Signs and numbers that a slip leaves open, a blank, and what is meant: a sign too many or the other one, an = that is
#: a sign or point, a digit too many before a letter, two letters for one, thousands, a comma before all digits.
_DOUBTFUL: Final = re.compile(
    r"== =|= EQ|\S*(?:\+-|-\+)\S* .*|\d+[A-Z][-+]?[\d.]* [A-Z].*|([A-Z]\w*+)([-.]\S*) \1=\2|([A-Z])([A-Z]) (?:\3|\4)"
    r"|(?:\S*[^\d\s])?[1-9]\d{0,2},\d{3} .*\..*|\S*[A-Z=][-+]?,\d+ .*",
    re.IGNORECASE,
)
_BLANK_IN_NUMBER: Final = re.compile(r"(?<=\d)[ \t]+(?=\d)")
#: A letter that looks like a digit in a number that is one without it; an O may be of the key beside 0.
_LETTER_IN_NUMBER: Final = re.compile(r"(?<=[\d.])[lI]|[lI](?=\.?\d)|(?<=0)O|O(?=0)", re.IGNORECASE)


class Fix(Struct, frozen=True):
    """An edit of one file: what stands from ``begin`` to ``end`` in ``text`` becomes ``new``."""

    title: str
    path: Path
    text: str | None  #: What the file holds; None where it is to be created.
    begin: int
    end: int
    new: str
    settles: bool = False  #: No error stays, and the tool points where the program says.
    turns: bool = False  #: The tool axis becomes another one.
    spells: bool = False  #: Corrects how words of a program are spelt.
    is_choice: bool = False  #: Right only if the program means it so.
    words: tuple[tuple[int, int, str], ...] = ()  #: The same of its words alone, where it is one of several places.

    def list_edits(self) -> tuple[tuple[int, int, str], ...]:
        """Where each change begins and ends, and what is written there, with the ends of lines of the text."""
        edits = self.words or ((self.begin, self.end, self.new),)
        if "\r\n" not in (self.text or ""):
            return edits
        return tuple((begin, end, re.sub("\r?\n", "\r\n", new)) for begin, end, new in edits)


def find_fixes(
    inspector: Inspector, found: Inspected, item: Finding, texts: Mapping[Path, str], superseded: threading.Event
) -> list[Fix]:
    """The edits that leave fewer errors, or as many errors and fewer warnings.

    Raises
    ------
    SupersededError
    """
    fixes, before, places = [], count_findings(found.findings), _count_places(found.findings)
    setup, codes = _find_setup(inspector, found.path, texts), {one.code for one in found.findings}
    # another place is within limits too, and a word that is not used may stand beside the wrong code, unless the one
    # that is meant is missing
    is_choice = is_about_pose(item.code) or (item.code == "VP006" and "; did you mean " not in item.message)
    with stop_by(partial(require_wanted, superseded)):
        proposed = list(_list_worked_out(_propose_fixes(found, item, setup, texts)))
    for fix in proposed:
        after = _try_fix(inspector, found.path, _change_texts(fix, texts), superseded)
        if after is None:
            continue
        errors, warnings = count_findings(after)
        # what a set-up settles could not be told while the program had errors: it does not speak against the edit
        shown = [one for one in after if one.severity == "error" and one.settled_by and one.code not in codes]
        # an edit that turns an error into a warning helps, as a point among numbers without one (VP038); and one that
        # mends a word in one place of several, which are one finding; and one that removes its finding, though what
        # could not be told before is wrong elsewhere
        is_mended = _is_settled(fix, item, found, after, is_as_bad=errors <= before[0])
        uncovered = _list_uncovered(fix, item, found, after) if (errors, warnings) == before else []
        is_better = (errors - len(shown), warnings) < before
        is_narrower = (errors, warnings) == before and _count_places(after) < places
        if is_better or is_narrower or is_mended or uncovered:
            left = f"{errors} error{'s stay' if errors > 1 else ' stays'}" if errors else "no errors then"
            left += f", with {format_count(warnings, 'warning')}" if warnings > before[1] else ""
            left += "".join(f", and {one.code} in {_name_place(one)}" for one in uncovered)
            left += ", another tool axis" if fix.turns else ""
            settles = not errors and not (fix.turns or fix.is_choice or is_choice or uncovered)
            fixes.append(replace(fix, title=f"{fix.title} ({left})", settles=settles))
    lacking = item.settled_by and setup is not None and not setup.exists() and setup not in texts
    if lacking and setup is not None and found.machine is not None and found.options is not None:
        new, missing, _others, said = make_setup(found.path.name, found.source, found.machine, found.options)
        told = f"{said}to be filled in: {missing}" if missing else said.removesuffix("; ")
        title = f"Write {setup.name}{f', {told}' if told else ''}"
        fixes.append(Fix(title, setup, None, 0, 0, new))
    elif item.settled_by and setup is not None:
        for fix in _list_worked_out(_mark_missing(item, setup, texts)):
            after = _try_fix(inspector, found.path, _change_texts(fix, texts), superseded)
            if after is not None and all(one.file != str(setup.absolute()) for one in after):
                fixes.append(fix)
    return fixes


def _name_place(item: Finding) -> str:
    """The line of a finding: of the program, or of the file that it is about."""
    file = "" if item.file is None else Path(item.file).name
    number = item.file_line if file else item.line
    return ", ".join(filter(None, (file, f"line {number}" if number else ""))) or "the program"


def _list_worked_out(proposed: Iterator[Fix]) -> Iterator[Fix]:
    """Edits up to one that cannot be worked out: editors ask at every move of the cursor, and show each failure."""
    try:
        yield from filter(_keeps_toml, proposed)
    except SupersededError:
        raise
    except Exception as error:
        _report_failure(error)


def _keeps_toml(fix: Fix) -> bool:
    """Whether a TOML file is one after an edit; of one that was none, the next mistake may stand behind the edit."""
    if fix.path.suffix != ".toml":
        return True
    before, after = _find_mistake(fix.text or ""), _find_mistake(_change_texts(fix, {})[fix.path])
    if before is None or after is None:
        return after is None
    head, text = f"{(fix.text or '')[: fix.begin]}{fix.new}", _change_texts(fix, {})[fix.path]
    at = _find_offset(text, after[0] - 1) + after[1] - 1
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


def _try_fix(
    inspector: Inspector, path: Path, texts: Mapping[Path, str], superseded: threading.Event
) -> Sequence[Finding] | None:
    """The findings of a program in which an edit was made; None where the check fails."""
    try:
        return inspector.check(path, texts, superseded, only_cause=True).findings
    except SupersededError:
        raise
    except Exception as error:
        _report_failure(error)
        return None


def _report_failure(error: Exception) -> None:
    logging.getLogger("pygls").warning("an edit is not offered: %s: %s", type(error).__name__, error)


def _is_settled(fix: Fix, item: Finding, found: Inspected, after: Sequence[Finding], *, is_as_bad: bool) -> bool:
    """Whether an error of the text is gone after an edit, and the text has no new one in its line or above.

    A word that can be read now may lead on to errors above, and, unless there are more, to what it needs in its line.
    """
    if item.severity != "error" or not is_about_text(item.code) or fix.turns or item.line is None:
        return False
    if _count_same(after, item) >= _count_same(found.findings, item):  # moved by a line, it is not gone
        return False
    whole = fix.text or "" if fix.path == found.path else ""
    at = 1 + whole.count("\n", 0, fix.begin)
    first = at + (whole[: fix.begin][-1:] not in ("", "\n"))  # the first line that the edit moves
    shift = fix.new.count("\n") - whole.count("\n", fix.begin, fix.end) if whole else 0
    moved = {one: (one.line or 0) + shift * ((one.line or 0) >= first) for one in found.findings}
    known, own = {(one.code, line) for one, line in moved.items() if one != item}, moved[item]
    left = [one for one in after if one.severity == "error" and (one.code, one.line or 0) not in known]
    if fix.spells:
        near = [one for one in left if one.line in (own, at)]
        # what stands above was executed: there, a jump is wrong because it leads to the wrong place
        if item.code == "VP023" and any(is_about_text(one.code) and (one.line or 0) < min(own, at) for one in left):
            return False
        return all(is_as_bad and not fix.is_choice and (one.code, one.line) != (item.code, own) for one in near)
    return not any(is_about_text(one.code) and (one.line or 0) <= own for one in left)


def find_file_fixes(
    inspector: Inspector, path: Path, item: Finding, texts: Mapping[Path, str], superseded: threading.Event
) -> list[Fix]:
    """Edits of a set-up, settings or a machine file after which it does not say the same any more.

    Raises
    ------
    SupersededError
    """
    fixes = []
    for fix in _list_worked_out(_propose_file_fixes(path, item, texts[path])):
        after, _program = inspector.check_file(path, _change_texts(fix, texts), superseded)
        said = [cut_file(one.message) for one in after]
        # a text in quotes where a number stands is as wrong, and so is a name in quotes that is no key
        quoted = fix.new[1:-1] if fix.new[:1] == '"' and fix.new != _TO_FILL_IN else "\0"
        as_wrong = (f"= '{quoted}': expected a", f"{quoted} is not a key", f"{quoted}: this is no option")
        if not any(one == cut_file(item.message) or any(why in one for why in as_wrong) for one in said):
            fixes.append(fix)
    return fixes


def find_fixes_of_its_file(
    inspector: Inspector, _found: Inspected, item: Finding, texts: Mapping[Path, str], superseded: threading.Event
) -> list[Fix]:
    """Edits of the file because of which a program is refused, for who sees the program alone.

    Raises
    ------
    SupersededError
    """
    path = Path(item.file or "")
    all_texts = {**texts, path: _read_setup(path, texts)}
    there = dataclasses.replace(item, line=item.file_line, file=None)
    fixes = find_file_fixes(inspector, path, there, all_texts, superseded)
    return [replace(fix, title=f"{fix.title} in {path.name}, line {item.file_line or 1}") for fix in fixes]


def _propose_file_fixes(path: Path, item: Finding, text: str) -> Iterator[Fix]:
    """What a message means by a name, and lines for what it says is missing."""
    yield from _mark_missing(item, path, {path: text})
    sentence = cut_file(item.message)
    near, place = find_suggestion(sentence), find_place(text.removeprefix(MARK), sentence)
    if near and place is not None:
        begin = _find_offset(text, place[0] - 1) + place[1]
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
            begin, new = _find_offset(text, at - 1) + there.start(), wrong_value[2] or wrong_value[4]
            yield Fix(f"Write {new} in place of {there[0]}", path, text, begin, begin + len(there[0]), new)
    yield from _write_between(path, sentence, text)
    if (new := replace_pasted(text)) != text:
        signs = enumerate(zip(text, new, strict=True))
        yield _change_words(_REPLACE_PASTED, path, text, [(k, k + 1, one) for k, (had, one) in signs if one != had])
    missing = re.match(r"([\w.-]+) is missing\b", sentence)
    if missing is not None and (change := _plan_change(text, tuple(missing[1].split(".")), _TO_FILL_IN)):
        title = f"Add {missing[1]} = {_TO_FILL_IN}, to be filled in"
        yield Fix(title, path, text, change.begin, change.end, change.new)


def _write_between(path: Path, sentence: str, text: str) -> Iterator[Fix]:
    """The = or the comma that a line lacks before the place where a text stops being TOML."""
    new = next((one for what, one in _BETWEEN.items() if sentence.endswith(what)), "")
    if not new or (place := _find_mistake(text)) is None or not place[0]:
        return
    at = _find_offset(text, place[0] - 1) + place[1] - 1
    begin, end = len(text[:at].rstrip()), at + (text[at : at + 1] in (":", ";"))
    title = f"Write {new.strip()} after {text[:begin].split()[-1]}"
    yield Fix(title, path, text, begin, end + len(text[end:]) - len(text[end:].lstrip(" \t")), new)


def _change_texts(fix: Fix, texts: Mapping[Path, str]) -> dict[Path, str]:
    """The texts of an editor after a fix."""
    whole = fix.text or ""
    return {**texts, fix.path: whole[: fix.begin] + fix.new + whole[fix.end :]}


def _mark_missing(item: Finding, setup: Path, texts: Mapping[Path, str]) -> Iterator[Fix]:
    """Entries of a set-up that is there, to be filled in: until then the program is refused, or says what it lacks."""
    text = _read_setup(setup, texts)
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
        change = _plan_change(text, key[:2], _MARKS[key[0]])
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
    left, edit, words = text, Edit(key, _TO_FILL_IN), list[tuple[int, int, str]]()
    if find_value(text, key):
        return None
    if not find_value(text, tool):
        if (whole := re.search(r"(?m)^[ \t]*tool_length[ \t]*=.*\n?", text)) is not None:
            words, left = [(*whole.span(), "")], text[: whole.start()] + text[whole.end() :]
        edit = Edit(tool, f"{{ length = {length or _TO_FILL_IN}, diameter = {_TO_FILL_IN} }}")
    change = _plan_change(left, edit.key, edit.value)
    if change is None:
        return None
    what = f"{name}{'.diameter' * (edit.key == key)} = {edit.value}"
    title = f"Add {what} to {setup.name}{' in place of tool_length' * bool(words)}, to be filled in"
    below = len(text) - len(left) if words and change.begin >= words[0][0] else 0
    return _change_words(title, setup, text, sorted([*words, (change.begin + below, change.end + below, change.new)]))


def _read_setup(setup: Path, texts: Mapping[Path, str]) -> str:
    """The text of a set-up as the editor or the disk has it; empty where there is none."""
    if setup in texts or not setup.is_file():
        return texts.get(setup, "")
    return setup.read_bytes().decode("utf-8", errors="replace")  # with the ends of lines that it has


def _list_uncovered(fix: Fix, item: Finding, found: Inspected, after: Sequence[Finding]) -> list[Finding]:
    """Warnings that come to light where an edit has settled one: of other causes, and not in the lines it wrote."""
    if fix.path != found.path or fix.is_choice or item.severity != "warning" or _count_same(after, item):
        return []
    at = 1 + found.text.count("\n", 0, fix.begin)
    known = {(one.code, one.message) for one in found.findings}
    new = [one for one in after if one.severity != "note" and (one.code, one.message) not in known]
    written = range(at, at + fix.new.count("\n") + 1)
    return [] if any(one.code == item.code or one.line in written for one in new) else new


def _count_same(findings: Sequence[Finding], item: Finding) -> int:
    """Places of which the same is said as of a finding."""
    return sum(one.count for one in findings if (one.code, one.message) == (item.code, item.message))


def _count_places(findings: Sequence[Finding]) -> int:
    """Places of a text that cannot be read."""
    return sum(item.count for item in findings if item.severity == "error" and is_about_text(item.code))


def _find_setup(inspector: Inspector, path: Path, texts: Mapping[Path, str]) -> Path | None:
    """The file of the set-up of a program; None where there is to be none, or neither is saved yet."""
    named = inspector.given.get("setup_file")
    if named is None:
        setup = Path(f"{path}.toml")
        return setup if path.is_file() or setup in texts or setup.is_file() else None
    return None if named == NONE else Path(named)


def _propose_fixes(found: Inspected, item: Finding, setup: Path | None, texts: Mapping[Path, str]) -> Iterator[Fix]:
    """Edits that may settle a finding."""
    program, told = found.made.program, {(one.line, one.word) for one in item.edits}
    ends = () if program is None else list_ends(found.source, program, item)
    others = (one for one in ends if one.is_choice or (one.line, one.word) not in told)
    settling = (Remedy("", _SETTLING[key], key) for key in item.settled_by if key in _SETTLING)
    placed = set[tuple[str, str]]()
    for remedy in (*item.edits, *settling, *others):
        if item.code in _OF_PROGRAMS and remedy.key[:1] == ("wcs",) and not remedy.text.endswith(_SLIP_THERE):
            continue
        if remedy.misspelt:
            yield from _spell(found, item, remedy)
            continue
        if remedy.line and not remedy.word[0]:
            if (remedy.text, remedy.value) in placed:  # in a better place
                continue
            yield from _PLACES.get(remedy.way, _PLACED.get(item.code, _write_below))(found, item, remedy)
            continue
        fix = _change_word(found, remedy) if remedy.line else _change_setup(setup, remedy, texts)
        if fix is not None:
            placed.add((remedy.text, remedy.value))
            yield fix
    text = found.text
    if any(one.misspelt for one in item.edits):
        return
    near = find_suggestion(item.message)
    if near and item.column is not None:
        begin, end = _find_span(item, text)
        written = text[begin:end]
        # the name alone, without quotes and without the number of an assignment
        name = re.search(r"[A-Za-z_][\w.-]*" if written.startswith('"') else r"\A[A-Za-z_]\w*", written)
        if name is not None:
            begin += name.start()
            end, title = begin + len(name[0]), f"Write {near} in place of {name[0]}"
            is_rivalled = _has_rival(name[0], near)
            yield Fix(title, found.path, text, begin, end, near, spells=True, is_choice=is_rivalled)
            yield from _spell_in_proc(found, item, near, name[0])
    if item.code == "VP038":
        words = [(at, at, ".") for at in list_missing_points(text)]
        title = f"Write the point after {format_count(len(words), 'number')} without one"
        # the point of a lone number may have been between its digits
        yield _change_words(title, found.path, text, words, is_choice=len(words) == 1)
    if item.code == "VP006" and item.column is not None and not item.edits:
        begin, end = _find_span(item, text)
        if _REST_OF_VALUE.search(text[:begin].rpartition("\n")[2]) is None:
            yield Fix(f"Remove {text[begin:end].strip()}", found.path, text, begin, end, "")


def _has_rival(written: str, meant: str) -> bool:
    """Whether a slip may have been made from another number or sign, as X1l5 from X115, X15 and X1.5."""
    letters = (one.start() for one in _LETTER_IN_NUMBER.finditer(written))
    is_block_number = written[:1] in ("N", "n")  # which moves nothing
    if not is_block_number and len(written) == len(meant) and any(meant[at].isdigit() for at in letters):
        return True
    if _BLANK_IN_NUMBER.sub("", written) == meant != written:
        return True
    return _DOUBTFUL.fullmatch(f"{''.join(written.split())} {''.join(meant.split())}") is not None


def _spell(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """A misspelt word of a line, as it is meant."""
    line = split_lines(found.text)[remedy.line - 1]
    begin = (item.column or 1) - 1
    written = line[begin : begin + len(remedy.misspelt)]
    if item.line == remedy.line and written.upper() == remedy.misspelt.upper():
        at = _find_offset(found.text, remedy.line - 1) + begin
        title = f"Write {remedy.value} in place of {written}"
        is_choice = remedy.is_choice or _has_rival(written, remedy.value)
        # without G43 in its block an H may be a G, whose key is beside it
        is_choice |= written[:1].upper() == "H" and re.search(r"G0*4[34]", line, re.IGNORECASE) is None
        pasted = translate_pasted(written) == remedy.value
        if pasted or not remedy.value:  # what is not seen is named
            title = f"{remedy.text[:1].upper()}{remedy.text[1:]}"
        yield Fix(title, found.path, found.text, at, at + len(written), remedy.value, spells=True, is_choice=is_choice)
        if pasted:
            yield from _translate_everywhere(found)
        else:
            yield from _change_everywhere(found, item, remedy, written, is_choice=is_choice)
        return
    code = remove_remarks(line, _find_dialect(found))
    word = re.search(rf"(?<!\w){re.escape(remedy.misspelt)}(?!\w)", code, re.IGNORECASE)
    if word is not None:
        at = _find_offset(found.text, remedy.line - 1) + word.start()
        title = f"Write {remedy.value} in place of {word[0]} in line {remedy.line}"
        fix = Fix(title, found.path, found.text, at, at + len(word[0]), remedy.value, is_choice=remedy.is_choice)
        yield replace(fix, spells=not remedy.turns, turns=remedy.turns)


def _spell_in_proc(found: Inspected, item: Finding, wrong: str, right: str) -> Iterator[Fix]:
    """The name of a value in the PROC line of a subprogram, as the subprogram writes it."""
    lines = split_lines(found.text)[: item.line]
    procs = (number for number in range(len(lines) - 1, -1, -1) if _PROC.match(lines[number]))
    number = next(procs, None) if item.code == "VP025" else None
    word = None if number is None else re.search(rf"(?<!\w){re.escape(wrong)}(?!\w)", lines[number], re.IGNORECASE)
    if number is not None and word is not None:
        at = _find_offset(found.text, number) + word.start()
        title = f"Write {right} in place of {word[0]} in the PROC line {number + 1}"
        yield Fix(title, found.path, found.text, at, at + len(word[0]), right, spells=True)


def _write_before(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What is missing above a line."""
    at, new = _find_offset(found.text, remedy.line - 1), remedy.value
    title, is_choice = f"Write {new} before line {remedy.line}", remedy.is_choice
    yield Fix(title, found.path, found.text, at, at, f"{new}\n", turns=remedy.turns, is_choice=is_choice)


def _write_at_end(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What ends the program; a caller cannot end its subprogram."""
    text = found.text
    if item.called is not None:
        return
    closing = re.search(r"(?<=\n)[ \t]*%\s*\Z", text)
    at = closing.start() if closing else len(text)
    new = f"{'' if text[:at].endswith(chr(10)) or not at else chr(10)}{remedy.value}\n"
    title = f"End the program with {remedy.value}{' before the closing %' * bool(closing)}"
    is_choice = remedy.value == "M99" and _LIKE_M99.search(text[:at]) is not None  # it may be the mistyped end
    yield Fix(title, found.path, text, at, at, new, is_choice=is_choice)


def _write_marked(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What is meant in place of the word that a finding marks."""
    if item.column is not None:
        begin, end = _find_span(item, found.text)
        written = found.text[begin:end].rstrip()
        title = f"Write {remedy.value} in place of {written}"
        yield Fix(title, found.path, found.text, begin, begin + len(written), remedy.value, is_choice=remedy.is_choice)


def _write_here(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What is missing behind what stands before the column of a finding, or at the end of a line."""
    line = split_lines(found.text)[remedy.line - 1]
    place = item.column - 1 if item.line == remedy.line and item.column else len(line)
    head = remove_remarks(line[:place], _find_dialect(found)).rstrip()
    at = _find_offset(found.text, remedy.line - 1) + len(head)
    title = f"Write {remedy.value.strip()}{f' after {head.split()[-1]}' if head else ''} in line {remedy.line}"
    yield Fix(title, found.path, found.text, at, at, remedy.value, is_choice=remedy.is_choice)


def _write_after(found: Inspected, _item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What is missing at the end of a line, behind its remark."""
    line = split_lines(found.text)[remedy.line - 1].rstrip()
    at = _find_offset(found.text, remedy.line - 1) + len(line)
    words = line.split()[-1:]
    title = f"Write {remedy.value.strip()}{f' after {words[0]}' if words else ''} in line {remedy.line}"
    yield Fix(title, found.path, found.text, at, at, remedy.value)


def _start_spindle(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """M3 after the S of the tool that was changed; before the cut where S of an earlier tool holds."""
    lines, cut = split_lines(found.text), item.line or 1
    speeds = [(number, word) for number, line in enumerate(lines[:cut]) if (word := find_word(line, "S"))]
    if not speeds:
        return
    number, word = speeds[-1]
    if _TOOL_CALL.search(lines[number]):  # which takes S and no M
        paths = ((k, _PATH_OF_KLARTEXT.match(line)) for k, line in enumerate(lines) if k >= remedy.line)
        at, path = next(((k, path) for k, path in paths if path is not None), (0, None))
        if path is not None:
            end = _find_offset(found.text, at) + len(path[0].rstrip())
            yield Fix(f"Write M3 in line {at + 1}", found.path, found.text, end, end, " M3")
    elif re.match(r"[ \t]*\d", lines[number][word.end() :]):  # S6000 3: M behind it would take the 3
        return
    elif number + 1 >= remedy.line:
        at, new = _find_offset(found.text, number) + word.end(), " M3"
        yield Fix(f"Write M3 after {word[0]} in line {number + 1}", found.path, found.text, at, at, new)
    else:
        at = _find_offset(found.text, cut - 1)
        yield Fix(f"Write M3 before line {cut}", found.path, found.text, at, at, "M3\n")


def _name_angles(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """A and C in the first line with a place: upright, and as the table is taken to stand."""
    dialect = _find_dialect(found)
    places = (
        (number, find_end_of_places(line, dialect)) for number, line in enumerate(split_lines(found.text)[: item.line])
    )
    number, end = next(((number, end) for number, end in places if end), (0, 0))
    if not end:
        return
    at = _find_offset(found.text, number) + end
    for angles in dict.fromkeys((re.sub(r"-?[\d.]+", "0", remedy.value), remedy.value)):
        title = f"Write {angles} in line {number + 1}"
        yield Fix(title, found.path, found.text, at, at, f" {angles}", is_choice=True)


def _find_dialect(found: Inspected) -> str:
    """The language of a program."""
    dialect = "auto" if found.options is None else found.options.dialect
    return choose_dialect_name(dialect, found.source, found.path.name)


def _write_below(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What is missing below a line."""
    at, words = _find_offset(found.text, remedy.line), remedy.value
    title, is_choice = f"Write {words} below line {remedy.line}", remedy.is_choice
    yield Fix(title, found.path, found.text, at, at, f"{words}\n", turns=remedy.turns, is_choice=is_choice)


#: What finds the places of edits in the text: by their way, and by the code of their finding.
_PLACES: Final = {
    "before": _write_before,
    "below": _write_below,
    "marked": _write_marked,
    "here": _write_here,
    "after": _write_after,
    "end": _write_at_end,
}
_PLACED: Final = {"VP017": _name_angles, "VP036": _name_angles, "VP050": _start_spindle}


def _change_everywhere(
    found: Inspected, item: Finding, remedy: Remedy, written: str, *, is_choice: bool
) -> Iterator[Fix]:
    """The same correction in all places that are no remarks, where there are several."""
    meant = remedy.value
    # a sign, a number, a word with one or a label that is right elsewhere; a quote or name that is closed there
    is_right_elsewhere = re.fullmatch(r"\W+|\d+", written) or (item.count == 1 and _NUMBERED.fullmatch(written))
    if is_right_elsewhere or written.count('"') % 2 or written.count("<") != written.count(">"):
        return
    word, at, words = re.compile(rf"(?<![\w.]){re.escape(written)}(?![\w.])"), 0, list[tuple[int, int, str]]()
    for line in found.text.split("\n"):
        words += [(at + one.start(), at + one.end(), meant) for one in word.finditer(remove_remarks(line))]
        at += len(line) + 1
    if len(words) > 1:
        title = f"Write {meant} in place of {written} in all {len(words)} places"
        yield _change_words(title, found.path, found.text, words, is_choice=is_choice)


def _change_words(title: str, path: Path, text: str, words: list[tuple[int, int, str]], **what: bool) -> Fix:
    """One edit of several words, from first to last."""
    ends = [0, *(end for _begin, end, _new in words)]
    parts = [text[end:begin] + new for end, (begin, _end, new) in zip(ends, words, strict=False)]
    whole = "".join(parts) + text[ends[-1] :]
    return Fix(title, path, text, 0, len(text), whole, words=tuple(words), **what)


def _translate_everywhere(found: Inspected) -> Iterator[Fix]:
    """The characters of a program in place of those of mail and PDF, in all lines that have some outside remarks."""
    at, dialect, count, words = 0, _find_dialect(found), 0, list[tuple[int, int, str]]()
    for line in found.text.split("\n"):
        code = remove_remarks(line, dialect)
        if (meant := translate_pasted(code)) != code:
            signs = enumerate(zip(code, meant, line, strict=True), at)
            words += [(k, k + 1, right) for k, (one, right, written) in signs if one == written and right != one]
            count += 1
        at += len(line) + 1
    if count > 1:
        title = f"{_REPLACE_PASTED} in all {count} lines"
        yield _change_words(title, found.path, found.text, words, spells=True)


def _find_span(item: Finding, text: str) -> tuple[int, int]:
    """Where in a text the word of a finding begins and ends."""
    place = find_range(item, split_lines(text))
    begin = _find_offset(text, place.start.line) + place.start.character
    return begin, begin + place.end.character - place.start.character


def _find_offset(text: str, line: int) -> int:
    """Where a line, counted from 0, begins."""
    return sum(len(one) + 1 for one in text.split("\n")[:line]) or int(text.startswith(MARK))


def _change_word(found: Inspected, remedy: Remedy) -> Fix | None:
    """The number of a word, or what comes behind it; None where no line has it, as in a loop or in G91."""
    letter, now = remedy.word
    lines = split_lines(found.text)
    numbers = range(remedy.line, 0 if remedy.is_above else remedy.line - 1, -1)
    units = (1.0, MM_PER_INCH) if remedy.way == "behind" else (1.0,)  # another number may be written in mm
    tried = ((one, _find_word(lines[one - 1], letter, now / unit)) for one in numbers for unit in units)
    number, word = next(((number, word) for number, word in tried if word is not None), (0, None))
    if word is None:
        return None
    if remedy.way == "below":
        at = _find_offset(found.text, number)
        title = f"Write {remedy.value} below {word[0]}, line {number}"
        return Fix(title, found.path, found.text, at, at, f"{remedy.value}\n", turns=True)  # the table, to a plane
    if remedy.way == "behind":
        at = _find_offset(found.text, number - 1) + word.end()
        title = f"Write {remedy.value} after {word[0]} in line {number}"
        # another M may be the mistyped one
        is_choice = remedy.is_choice or (remedy.value[0] == "M" and find_word(lines[number - 1], "M") is not None)
        return Fix(title, found.path, found.text, at, at, f" {remedy.value}", is_choice=is_choice)
    if remedy.way == "exchanged":
        return _exchange_words(found, remedy, number, word)
    new = write_like(word[2], remedy.value, _find_dialect(found))
    begin = _find_offset(found.text, number - 1) + word.start(2)
    end = word[0].removeprefix(word[1] + word[2])
    title = f"Write {word[1]}{new}{end} in place of {word[0]} in line {number}"
    turns, is_choice = letter.upper() in ("A", "B", "C"), remedy.is_choice
    return Fix(title, found.path, found.text, begin, begin + len(word[2]), new, turns=turns, is_choice=is_choice)


def _exchange_words(found: Inspected, remedy: Remedy, number: int, word: re.Match[str]) -> Fix:
    """A word and that of another letter with the numbers exchanged; the letter alone where it has no word."""
    line = split_lines(found.text)[number - 1]
    other = find_word(line, remedy.value)
    if other is None:
        begin, end, new = word.start(1), word.end(1), remedy.value
    else:
        first, second = sorted((word, other), key=lambda one: one.start())
        begin, end = first.start(2), second.end(2)
        new = second[2] + line[first.end(2) : second.start(2)] + first[2]
    at = _find_offset(found.text, number - 1)
    title = f"Exchange {word[1]} and {remedy.value} in line {number}"
    return Fix(title, found.path, found.text, at + begin, at + end, new, is_choice=remedy.is_choice)


def _find_word(line: str, letter: str, value: float) -> re.Match[str] | None:
    """A letter with this number; T with a name, which has a number only here."""
    return find_word_of(line, letter, value) or (_NAMED_TOOL.search(line) if letter == "T" else None)


def _change_setup(setup: Path | None, remedy: Remedy, texts: Mapping[Path, str]) -> Fix | None:
    """A key of the set-up."""
    if setup is None:
        return None
    text = _read_setup(setup, texts) if setup in texts or setup.is_file() else None
    change = _plan_change(text or "", remedy.key, remedy.value)
    if change is None:
        return None
    is_moved = remedy.key[0] == "wcs" and not remedy.text.endswith(_SLIP_THERE)
    what = "Clamp the part at" if is_moved else "Set"
    title = f"{what} {'.'.join(remedy.key)} = {remedy.value} in {setup.name}"
    return Fix(title, setup, text, change.begin, change.end, change.new)


def _plan_change(text: str, key: tuple[str, ...], value: str) -> Change | None:
    """The change of a set-up; None where it is written in a way that is not seen."""
    try:
        return plan_edit(text, Edit(key, value))
    except UnknownLayoutError:
        return None
