"""Edits of a program: what the remedies of a finding, or its message, say of words and lines."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from msgspec.structs import replace

from verne_post.app.assemble import SPLIT_KEY
from verne_post.app.remedies.refused import list_ends
from verne_post.base.numbers import format_count
from verne_post.base.pasted import translate_pasted
from verne_post.base.program_lines import find_word, find_word_of, remove_remarks, split_lines, write_like
from verne_post.base.suggestions import find_suggestion
from verne_post.base.units import MM_PER_INCH
from verne_post.cli.lsp.addresses import find_end_of_places
from verne_post.cli.lsp.edits import REPLACE_PASTED, Fix, change_words, find_offset
from verne_post.cli.lsp.file_fixes import SLIP_THERE, change_setup
from verne_post.cli.lsp.inspector import Inspected
from verne_post.cli.lsp.places import find_range
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.machining.holes import TAPPING_KEY
from verne_post.gcode.rs274.fanuc_points import list_missing_points
from verne_post.model.findings import Finding, Remedy

#: T with a name.
_NAMED_TOOL: Final = re.compile(r"(?<![A-Z_])(T\d?[ \t]*=[ \t]*)(\"[^\"]+\")", re.IGNORECASE)
_TOOL_CALL: Final = re.compile(r"\bTOOL[ \t]+CALL\b", re.IGNORECASE)
#: A line of Klartext that goes to a place.
_PATH_OF_KLARTEXT: Final = re.compile(r"\s*(?:\d+\s+)?L\b[^;]*")
#: What stands before the rest of an expression: without that, a variable would get another value.
_REST_OF_VALUE: Final = re.compile(r"#[^=]*=.*[\w.\])>]$")
#: A word with a number, and a label of RS274/NGC.
_NUMBERED: Final = re.compile(r"[A-Z]{1,2}[-+]?[\d.]+|o?<[^<>]*>", re.IGNORECASE)
_LIKE_M99: Final = re.compile(r"\n[ \t]*(?:N\d+[ \t]*)?[MN]\d?9\d?\s*\Z", re.IGNORECASE)
_PROC: Final = re.compile(r"[ \t]*(?:N\d+[ \t]*)?PROC\b", re.IGNORECASE)
#: Findings that are mistakes of a program much more often than of the place of its part: a depth with a digit too many.
_OF_PROGRAMS: Final = ("VP210",)
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


def propose_fixes(found: Inspected, item: Finding, setup: Path | None, texts: Mapping[Path, str]) -> Iterator[Fix]:
    """Edits that may settle a finding."""
    program, told = found.made.program, {(one.line, one.word) for one in item.edits}
    ends = () if program is None else list_ends(found.source, program, item)
    others = (one for one in ends if one.is_choice or (one.line, one.word) not in told)
    settling = (Remedy("", _SETTLING[key], key) for key in item.settled_by if key in _SETTLING)
    placed = set[tuple[str, str]]()
    for remedy in (*item.edits, *settling, *others):
        if item.code in _OF_PROGRAMS and remedy.key[:1] == ("wcs",) and not remedy.text.endswith(SLIP_THERE):
            continue
        if remedy.misspelt:
            yield from _spell(found, item, remedy)
            continue
        if remedy.line and not remedy.word[0]:
            if (remedy.text, remedy.value) in placed:  # in a better place
                continue
            yield from _PLACES.get(remedy.way, _PLACED.get(item.code, _write_below))(found, item, remedy)
            continue
        fix = _change_word(found, remedy) if remedy.line else change_setup(setup, remedy, texts)
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
        yield change_words(title, found.path, text, words, is_choice=len(words) == 1)
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
        at = find_offset(found.text, remedy.line - 1) + begin
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
        at = find_offset(found.text, remedy.line - 1) + word.start()
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
        at = find_offset(found.text, number) + word.start()
        title = f"Write {right} in place of {word[0]} in the PROC line {number + 1}"
        yield Fix(title, found.path, found.text, at, at + len(word[0]), right, spells=True)


def _write_before(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What is missing above a line."""
    at, new = find_offset(found.text, remedy.line - 1), remedy.value
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
    at = find_offset(found.text, remedy.line - 1) + len(head)
    title = f"Write {remedy.value.strip()}{f' after {head.split()[-1]}' if head else ''} in line {remedy.line}"
    yield Fix(title, found.path, found.text, at, at, remedy.value, is_choice=remedy.is_choice)


def _write_after(found: Inspected, _item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What is missing at the end of a line, behind its remark."""
    line = split_lines(found.text)[remedy.line - 1].rstrip()
    at = find_offset(found.text, remedy.line - 1) + len(line)
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
            end = find_offset(found.text, at) + len(path[0].rstrip())
            yield Fix(f"Write M3 in line {at + 1}", found.path, found.text, end, end, " M3")
    elif re.match(r"[ \t]*\d", lines[number][word.end() :]):  # S6000 3: M behind it would take the 3
        return
    elif number + 1 >= remedy.line:
        at, new = find_offset(found.text, number) + word.end(), " M3"
        yield Fix(f"Write M3 after {word[0]} in line {number + 1}", found.path, found.text, at, at, new)
    else:
        at = find_offset(found.text, cut - 1)
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
    at = find_offset(found.text, number) + end
    for angles in dict.fromkeys((re.sub(r"-?[\d.]+", "0", remedy.value), remedy.value)):
        title = f"Write {angles} in line {number + 1}"
        yield Fix(title, found.path, found.text, at, at, f" {angles}", is_choice=True)


def _find_dialect(found: Inspected) -> str:
    """The language of a program."""
    dialect = "auto" if found.options is None else found.options.dialect
    return choose_dialect_name(dialect, found.source, found.path.name)


def _write_below(found: Inspected, item: Finding, remedy: Remedy) -> Iterator[Fix]:
    """What is missing below a line."""
    at, words = find_offset(found.text, remedy.line), remedy.value
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
        yield change_words(title, found.path, found.text, words, is_choice=is_choice)


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
        title = f"{REPLACE_PASTED} in all {count} lines"
        yield change_words(title, found.path, found.text, words, spells=True)


def _find_span(item: Finding, text: str) -> tuple[int, int]:
    """Where in a text the word of a finding begins and ends."""
    place = find_range(item, split_lines(text))
    begin = find_offset(text, place.start.line) + place.start.character
    return begin, begin + place.end.character - place.start.character


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
        at = find_offset(found.text, number)
        title = f"Write {remedy.value} below {word[0]}, line {number}"
        return Fix(title, found.path, found.text, at, at, f"{remedy.value}\n", turns=True)  # the table, to a plane
    if remedy.way == "behind":
        at = find_offset(found.text, number - 1) + word.end()
        title = f"Write {remedy.value} after {word[0]} in line {number}"
        # another M may be the mistyped one
        is_choice = remedy.is_choice or (remedy.value[0] == "M" and find_word(lines[number - 1], "M") is not None)
        return Fix(title, found.path, found.text, at, at, f" {remedy.value}", is_choice=is_choice)
    if remedy.way == "exchanged":
        return _exchange_words(found, remedy, number, word)
    new = write_like(word[2], remedy.value, _find_dialect(found))
    begin = find_offset(found.text, number - 1) + word.start(2)
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
    at = find_offset(found.text, number - 1)
    title = f"Exchange {word[1]} and {remedy.value} in line {number}"
    return Fix(title, found.path, found.text, at + begin, at + end, new, is_choice=remedy.is_choice)


def _find_word(line: str, letter: str, value: float) -> re.Match[str] | None:
    """A letter with this number; T with a name, which has a number only here."""
    return find_word_of(line, letter, value) or (_NAMED_TOOL.search(line) if letter == "T" else None)
