"""APT cutter location text -> statements: a major word, a slash, words between commas; stretches of GOTO at once."""

import math
import re
from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.base.long_text import Text
from verne_post.base.suggestions import drop_doubles, find_meant
from verne_post.gcode.expressions import MAX_NUMBER
from verne_post.gcode.plain import MIN_LINES
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.text import decode_line
from verne_post.gcode.words import mark_blanks_in_numbers, read_whole_lines, split_words

_NUMBER: Final = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[EeDd][+-]?[0-9]+)?$")
_NUMBER_OF_POINT: Final = rb"[ \t]*+[+-]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:[Ee][+-]?[0-9]++)?[ \t]*+"
#: One line with GOTO, and three or six numbers.
_POINT: Final = re.compile(rb"[ \t]*+GOTO[ \t]*+/%b(?:,%b){2}(?:(?:,%b){3})?\r?\n" % ((_NUMBER_OF_POINT,) * 3))
#: Consecutive lines with GOTO, and characters of numbers; this is found quickly.
_LINES_OF_POINTS: Final = re.compile(rb"(?:^[ \t]*+GOTO[ \t]*+/[-+0-9.Ee, \t]*+\r?\n){%d,}+" % MIN_LINES, re.MULTILINE)
_NOT_OF_NUMBERS: Final = b"GOT/ \t\r"
#: The slash and the commas as letters of words; the other letters of GOTO are deleted beside it.
_AS_LETTERS: Final = bytes.maketrans(b"/,", b"XX")
_OTHER_LETTERS: Final = b"GOT"
_X: Final = ord("X")
#: The reader of words would pass over these blanks.
_BLANKS_AFTER_SIGNS: Final = (b"- ", b"+ ", b"-\t", b"+\t")
#: Numbers on a line: a place, or a place and a tool axis.
_COUNTS: Final = (3, 6)
#: Major words of two parts are kept as the first of them, or with one blank: TLON,GOFWD/ is TLON.
_MAJOR: Final = re.compile(
    r"\s*(?:(TLON)\s*,\s*GOFWD|(TOOL)\s+(PATH)|(END-OF-PATH)|([A-Za-z][A-Za-z0-9_]*))\s*(?:/|$)", re.IGNORECASE
)
#: Words of six letters, whose text goes from the seventh to the end of the line, also when it begins with a digit.
FREE_TEXT: Final = ("PARTNO", "PPRINT", "REMARK", "INSERT")
#: A remark for the CAM system itself, which goes on in the next line after a $; that line has only numbers. One of them
#: names the system of the points.
_SYSTEM_REMARK: Final = "$$->"
_SYSTEM: Final = re.compile(r"\s*\$\$->\s*CSYS\s*/(.*)")
SYSTEM_OF_MODEL: Final = "$$-> CSYS"
#: The same of CATIA: after a remark with this name, and one with the system's, three with a row of its matrix each.
SYSTEM_OF_CATIA: Final = "$$*CATIA0"
_ROW: Final = re.compile(r"\s*\$\$((?:\s+[-+]?[0-9.]+){4})\s*$")
_ONLY_NUMBERS: Final = re.compile(r"[-+.,0-9EeDd\s]*(?:\$.*)?$")
#: The names of points and circles that some writers put into the last columns of a card.
_CARD_NAME: Final = re.compile(r"[A-Z]{2,3} +[0-9]+ *$")
_CARD_COLUMNS: Final = 72


class Statement(Struct, frozen=True):
    """One statement: its first line, major word, the words after the slash, and over how many lines it goes.

    The major word of a line without a slash is empty, and ``text`` is the line.
    ``columns`` are those of the major word and of the words after it; none where the statement goes over several lines.
    """

    line: int
    major: str
    words: tuple[str, ...]
    text: str
    columns: tuple[int, ...] = ()
    n_lines: int = 1

    def find_column(self, word: str) -> int | None:
        """The column of the first word of this text, in whatever case."""
        words = (self.major, *self.words)
        return next((at for one, at in zip(words, self.columns, strict=False) if one.upper() == word.upper()), None)


class Points(Struct, frozen=True, eq=False, dict=True):
    """Consecutive lines from ``line`` on, each a GOTO with three or six numbers; ``text`` are whole lines."""

    line: int
    text: bytes
    places: Array  #: (n, 3)
    axes: Array  #: (m, 3): tool axes of the lines that have one.
    which_axis: Ints  #: (n,): for each line the row of its tool axis; -1 before the first one.

    @cached_property
    def _lines(self) -> list[bytes]:
        return self.text.removesuffix(b"\n").split(b"\n")

    def __len__(self) -> int:
        return len(self.places)

    def make_statement(self, row: int) -> Statement:
        """One of them, from 0."""
        return _read_statement(decode_line(self._lines[row]), self.line + row)


def is_number(word: str) -> bool:
    """True for a number, with an exponent or without."""
    return _NUMBER.match(word) is not None


def correct_word(statement: Statement, words: Sequence[str], known_words: Collection[str]) -> None:
    """Raise ProgramError for the first of the words that is near one which the statement knows, but none of them."""
    for word in words:
        near = "" if word.upper() in known_words else find_meant(word.upper(), known_words)
        if near:
            text = f"{word}: no word of {statement.major}; did you mean {near}?"
            raise ProgramError("VP002", text, statement.find_column(word))


def read_numbers(statement: Statement, words: Sequence[str]) -> list[float]:
    """The words as numbers; raises ProgramError for anything else."""
    values = []
    for word in words:
        if not is_number(word):
            raise ProgramError("VP001", f"{statement.major}: {word!r} is not a number", statement.find_column(word))
        value = float(word.upper().replace("D", "E"))
        if not abs(value) <= MAX_NUMBER or math.isnan(value):
            column = statement.find_column(word)
            raise ProgramError("VP007", f"{statement.major}: {word[:20]} is beyond any machine", column)
        values.append(value)
    return values


def read_word(statement: Statement, expected_words: Sequence[str]) -> str:
    """The only word of a statement, which is one of those expected; "" where none is expected.

    Raises
    ------
    ProgramError
        For anything else.
    """
    words = [word.upper() for word in statement.words]
    if not words and not expected_words:
        return ""
    if len(words) != 1 or words[0] not in expected_words:
        takes = " or ".join(expected_words) if expected_words else "nothing after it"
        here = ", ".join(words)[:40] or "nothing"
        column = statement.find_column(words[0] if words else statement.major)
        near = next((one for one in drop_doubles(words[0]) if one in expected_words), "") if len(words) == 1 else ""
        if near:
            raise ProgramError("VP002", f"{words[0]}: no word of {statement.major}; did you mean {near}?", column)
        raise ProgramError("VP005", f"{statement.major} takes {takes}; here is {here}", column)
    return words[0]


def read_statements(source: Text) -> Iterator[Statement | Points | ProgramError]:
    """Statements in order; a line goes on in the next after a ``$``, and ``$$`` begins a remark."""
    begin, pending, number, remark = 0, "", 0, ""
    rows: list[str] | None = None
    for part in _split_text(source):
        if isinstance(part, bytes) or pending:
            lines = part if isinstance(part, bytes) else part.text
        else:
            yield part
            number, remark = number + len(part), ""
            continue
        for raw in lines.removesuffix(b"\n").split(b"\n"):
            number += 1
            line = decode_line(raw).rstrip("\r")
            if not pending and (line.lstrip().startswith(_SYSTEM_REMARK) or (remark and _ONLY_NUMBERS.match(line))):
                remark += line.rstrip()
                if not remark.endswith("$"):
                    yield from _read_system(remark, number)
                    remark = ""
                continue
            remark = ""
            if rows is not None or line.startswith("$$*"):
                rows = _collect_rows(line, rows)
                if rows is not None and len(rows) == 12:
                    yield Statement(number, SYSTEM_OF_CATIA, tuple(rows), " ".join(rows))
                    rows = None
            free = not pending and line.lstrip().upper().startswith(FREE_TEXT)
            begin = begin if pending else number
            if not free:
                line, goes_on, _name = _cut_card_name(line.partition("$$")[0]).partition("$")
                if goes_on:
                    pending += line.rstrip() + " "
                    continue
            text, pending = pending + line.rstrip(), ""
            if text.strip():
                yield _read_statement(text, begin, number + 1 - begin)
    if pending.strip():
        yield ProgramError("VP001", "the text ends, but $ continues the statement", line=begin)


def _read_system(remark: str, line: int) -> Iterator[Statement]:
    """The statement for a remark that says in which system the points are; none for other remarks."""
    found = _SYSTEM.match(remark)
    if found is not None:
        words = tuple(word.strip(" $\t") for word in found[1].split(","))
        yield Statement(line, SYSTEM_OF_MODEL, words, found[1].strip())


def _collect_rows(line: str, rows: list[str] | None) -> list[str] | None:
    """Numbers of the matrix of CATIA so far; None outside of one."""
    if line.startswith(SYSTEM_OF_CATIA[:-1]):
        return []
    row = _ROW.match(line) if rows is not None else None
    if rows is None or row is None:
        return rows if rows == [] and line.startswith("$$") else None
    return rows + row[1].split()


def _cut_card_name(line: str) -> str:
    return line[:_CARD_COLUMNS] if _CARD_NAME.match(line, _CARD_COLUMNS) else line


def _split_text(source: Text) -> Iterator[bytes | Points]:
    """Stretches of GOTO, and the lines between them."""
    number = 1
    for chunk in read_whole_lines(source):
        at = 0
        for match in _LINES_OF_POINTS.finditer(chunk):
            if match.start() > at:
                yield chunk[at : match.start()]
            number += chunk.count(b"\n", at, match.start())
            for part in _read_points(number, match.group()):
                yield part
                number += len(part) if isinstance(part, Points) else part.count(b"\n")
            at = match.end()
        if at < len(chunk):
            yield chunk[at:]
            number += chunk.count(b"\n", at)


def _read_points(first_line: int, text: bytes) -> Iterator[bytes | Points]:
    """Lines of GOTO as arrays; those that are no points stay text, and few lines between such too."""
    numbers, count = _read_numbers_of_points(first_line, text)
    ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n")) + 1
    begins = np.concatenate([[0], ends[:-1]])
    for row in np.flatnonzero(count == 0).tolist():
        line = text[begins[row] : ends[row]]
        if _POINT.fullmatch(line):  # with an exponent, or with more digits than the reader of words takes
            words = line.translate(None, _NOT_OF_NUMBERS).split(b",")
            count[row] = len(words)
            numbers[row, : len(words)] = [float(word) for word in words]
    changes = np.flatnonzero(np.diff(count > 0)) + 1
    for first, last in pairwise([0, *changes.tolist(), len(count)]):
        part = text[begins[first] : ends[last - 1]]
        if count[first] == 0 or last - first < MIN_LINES:
            yield part
            continue
        has_axis = count[first:last] == _COUNTS[1]
        table = numbers[first:last]
        yield Points(first_line + first, part, table[:, :3], table[has_axis, 3:], np.cumsum(has_axis) - 1)


def _read_numbers_of_points(first_line: int, text: bytes) -> tuple[Array, Ints]:
    """Numbers (n, 6) of lines of GOTO, and how many each has; 0 where the reader of words does not take the line."""
    marked_text = mark_blanks_in_numbers(text)
    for blank in _BLANKS_AFTER_SIGNS:
        marked_text = marked_text.replace(blank, b"?")
    words = split_words(first_line, marked_text.translate(_AS_LETTERS, _OTHER_LETTERS))
    count = np.bincount(words.row, minlength=words.n_lines)
    begin = np.cumsum(count) - count
    words.plain[words.row[words.letter != _X]] = False  # E of an exponent
    numbers = np.full((words.n_lines, _COUNTS[1]), np.nan)
    is_point = np.zeros(words.n_lines, dtype=bool)
    for size in _COUNTS:
        rows = np.flatnonzero(words.plain & (count == size))
        numbers[rows, :size] = words.value[begin[rows, None] + np.arange(size)]
        is_point[rows] = True
    return numbers, np.where(is_point, count, 0)


def _read_statement(text: str, line: int, n_lines: int = 1) -> Statement:
    """One statement, with the columns of the text where it stands on one line."""
    columns = n_lines == 1
    if text.lstrip().upper().startswith(FREE_TEXT):
        text = text.strip()
        return Statement(line, text[:6].upper(), (), text[6:].lstrip(" /"))
    major_word = _MAJOR.match(text)
    begins = len(text) - len(text.lstrip())
    if major_word is None:
        return Statement(line, "", (), text.strip(), (begins + 1,) if columns else (), n_lines)
    major = " ".join(filter(None, major_word.groups())).upper()
    rest = text[major_word.end() :]
    parts = rest.split(",") if rest.strip() else []
    ends = accumulate((len(part) + 1 for part in parts), initial=major_word.end())
    starts = [begins, *(end + len(part) - len(part.lstrip()) for end, part in zip(ends, parts, strict=False))]
    words = tuple(part.strip() for part in parts)
    return Statement(line, major, words, rest.strip(), tuple(at + 1 for at in starts) if columns else (), n_lines)
