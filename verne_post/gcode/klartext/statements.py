"""Lines of a Klartext program -> statements: block number, keyword and the text after it, without comments."""

import difflib
import re
from bisect import bisect_right
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.long_text import count_line
from verne_post.base.numbers import is_count
from verne_post.base.suggestions import find_correction
from verne_post.gcode.klartext.first_words import (
    KEYWORD,
    LETTERS_AS_DIGITS,
    is_half_keyword,
    refuse_joined,
    refuse_unread,
)
from verne_post.gcode.plain import PlainLines
from verne_post.gcode.program_error import ProgramError, write_words
from verne_post.gcode.text import Chunk, ChunkedText, decode_line, take_code
from verne_post.gcode.words import split_words
from verne_post.model.findings import Remedy

_NUMBER: Final = re.compile(r"[ \t]*(/)?[ \t]*(\d+)?[ \t]*(/)?[ \t]*(?:DECLARE[ \t]+STRING[ \t]+(?=QS))?")
#: A line that goes on with parameters of the cycle defined above it, where the tilde is left out. A cycle line that has
#: some itself is complete, and what follows it may be an assignment.
_CYCLE_PARAMETER: Final = re.compile(r"[ \t]*Q\d+[ \t]*=")
_PARAMETER: Final = re.compile(r"[ \t]Q\d+[ \t]*=")
_CYCLE: Final = re.compile(r"[ \t]*+\d*+[ \t]*+CYCL[ \t]+DEF[ \t]*\d[\dO]{2}", re.IGNORECASE)
_EQUALS: Final = re.compile(r"[ \t]*(?!Q)([A-Z]+)[ \t]*=[ \t]*([-+]?(?:\d+(?:[.,]\d*)?|Q[LR]?\d+))(?!\w)")
#: Statements that change the corner at the end of the move before them.
_CORNER: Final = re.compile(rb"[ \t]*+/?[ \t]*+\d*+[ \t]*+/?[ \t]*+(?:RND|CHF)(?![A-Z])", re.IGNORECASE)
_IGNORED_LINE: Final = re.compile(rb"[ \t\r]*+\d*+[ \t]*+(?:;[^\n]*|\*[ \t]*-?[^\n]*)?")
#: A line that is nothing but a comment; one that goes on is a comment in the next line too.
_REMARK: Final = re.compile(rb"[ \t]*+\d*+[ \t]*+;.*", re.DOTALL)
_LABEL: Final = re.compile(
    rb"^[ \t]*+/?[ \t]*+N?\d*+(?:[A-Z](?=[ \t]+LBL))?[ \t]*+/?[ \t]*+(?:LBL[ \t]+(?:\"([^\"\n]*)\"|(\d+))|(LBL\d+)"
    rb"|([A-Z]{2,5}+[ \t]*+(?:\"[^\n;]*|[\dLIO]*|[^\n;]*\")))[ \t\r]*(?:;[^\n]*)?$",
    re.MULTILINE | re.IGNORECASE,
)
_MOST_LABELS: Final = 3  #: Of so many one is worth a choice.
#: What calls a label, or jumps to it.
_TO_LABEL: Final = re.compile(rb"(?:CALL|GOTO)[ \t]+LBL[ \t]+(?:\"([^\"\n]+)\"|(\d+))", re.IGNORECASE)
_LETTER_IN_NUMBER: Final = re.compile(rb"[ \t]*+/?[ \t]*+(?:N\d|\d++[A-Z])", re.IGNORECASE)
#: BEGIN PGM or END PGM: which, the name, the unit.
_FRAME: Final = re.compile(
    rb"^[ \t]*+\d*+[ \t]*+(BEGIN|END)[ \t]+PGM\b[ \t]*([^;\r\n]*?)[ \t]*(?:(?<=[ \t])(MM|INCH|IN))?"
    rb"[ \t\r]*(?:;[^\n]*)?$",
    re.MULTILINE | re.IGNORECASE,
)
_END: Final = "ENDPGM"
#: So similar a line is meant for END PGM.
_ALIKE: Final = 0.75
#: Bytes at the end of a program in which END PGM is looked for first.
_TAIL: Final = 65_536
_G: Final = 10

# Plain lines in words of RS274/NGC: L becomes G1, with FMAX G0; R0 goes. What a Klartext line may not have must not
# become a plain line: G and N, brackets, blanks inside numbers.
_TRANSLATION: Final = bytes.maketrans(b",GgNn()", b".??????")
_RAPID: Final = re.compile(
    rb"^[ \t]*(?:\d+[ \t]+)?L(?=[ \t])([^\nLMRFQ;]*)(?:R0[ \t]+)?FMAX[ \t]*(?=[;\r\n]|$)", re.MULTILINE | re.IGNORECASE
)
_STRAIGHT: Final = re.compile(rb"^[ \t]*(?:\d+[ \t]+)?L(?=[ \t])", re.MULTILINE | re.IGNORECASE)
_NO_SIDE: Final = re.compile(rb"(?<=[ \t])R0(?=[ \t\r\n;])", re.IGNORECASE)
_GOES_ON: Final = re.compile(rb"(?:;[^\n]*)?~[ \t\r]*$", re.MULTILINE)
_SPLIT_NUMBER: Final = re.compile(rb"[ \t](?=[\d.])")


class Statement(Struct, frozen=True):
    """One statement."""

    line: int  #: Its first line.
    keyword: str  #: "" for a comment, a structure line or a blank line.
    rest: str  #: What follows the keyword, in upper case but for what stands in quotes.
    begin: int = 0  #: Column (from 0) at which ``rest`` begins, of the first line.
    is_deleted: bool = False  #: A slash stands before it.
    further_lines: tuple[int, ...] = ()  #: Where in ``rest`` its second and later lines begin.

    def error(self, code: str, message: str, at: int | None = None, edits: tuple[Remedy, ...] = ()) -> ProgramError:
        """An error of this statement, at a place of ``rest``: what stands behind blanks there."""
        line, column = (None, None) if at is None else self.find_place(at + count_blanks(self.rest[at:]))
        return ProgramError(code, message, column, line if line != self.line else None, edits=edits)

    def refuse_word(self, wrong: str, what: str, *rights: str, at: int) -> ProgramError:
        """VP001 of a word at a place of ``rest``, with the words of which one is to be written, each an edit."""
        message = f"{wrong}: {what}; write {' or '.join(rights)}"
        return self.error("VP001", message, at, write_words(wrong, *rights))

    @contextmanager
    def place_errors(self, at: int) -> Iterator[None]:
        """Errors of what is read from a place of ``rest`` on stand there, as far behind it as their column says."""
        try:
            yield
        except ProgramError as error:
            if error.line is None:
                line, error.column = self.find_place(at + (error.column or 1) - 1)
                error.line = line if line != self.line else None
            raise

    def find_place(self, at: int) -> tuple[int, int]:
        """Line, and column from 1, of a place of ``rest``."""
        number = bisect_right(self.further_lines, at)
        begin = self.further_lines[number - 1] if number else -self.begin
        return self.line + number, at - begin + 1


def count_blanks(text: str) -> int:
    """Those before the first word; none where no word follows."""
    word = text.lstrip(" \t")
    return len(text) - len(word) if word else 0


class KlartextText(ChunkedText):
    """One file: statements on demand, its labels, and its plain lines as the scanner has them.

    ``label_errors`` are those of mistyped labels, which are called as they are meant.
    """

    @cached_property
    def label_errors(self) -> list[ProgramError]:
        """Filled by :attr:`labels`."""
        return []

    def make_chunk(self, first_line: int, text: bytes) -> Chunk:
        """Scan plain lines: those that become G0 or G1 in words of RS274/NGC, and comments."""
        words = split_words(first_line, _translate_lines(text))
        lines = PlainLines(words, self.setup, bare_codes=False)
        rows = np.arange(words.n_lines)
        lines.plain &= (lines.row[:, _G] == rows) | (np.bincount(words.row, minlength=len(rows)) == 0)
        return Chunk(first_line, text, lines)

    def read_raw(self, line: int) -> bytes | None:
        """One line; None after the end of the text."""
        chunk = self.find_chunk(line)
        return None if chunk is None else chunk.read_raw(line - chunk.first_line)

    def read_parts(self, line: int, warn: Callable[[int], None] | None = None) -> list[str]:
        """The lines of the statement that begins in a line, without comments.

        ``warn`` is given the line of a cycle that has no ~, where others have one. The last line of a cycle may have
        one before a block of its own (:meth:`goes_on`).

        Raises
        ------
        ProgramError
            VP001: the statement goes on, and the text ends.
        """
        raw = self.read_raw(line)
        assert raw is not None
        text, goes_on = _strip_comment(decode_line(raw))
        parts = [text]
        remark = goes_on and _REMARK.fullmatch(raw) is not None
        cycle = _is_cycle(text) and _PARAMETER.search(text.upper()) is None
        tilde, without = False, 0
        while goes_on or cycle:
            following = self.read_raw(line + len(parts))
            if following is None:
                if goes_on:
                    raise ProgramError("VP001", "the text ends, but ~ continues the statement", line=line)
                break
            more = decode_line(following)
            if not goes_on and not _CYCLE_PARAMETER.match(more.upper()):
                break
            if cycle and not goes_on and not parts[-1].lstrip().startswith("~"):
                without = without or line + len(parts) - 1
            if goes_on and _is_cycle(parts[0]) and _is_block(more):
                break
            tilde |= goes_on
            text, goes_on = _strip_comment(more)
            parts.append("" if remark else text)
        if without and tilde and warn is not None:
            warn(without)
        return parts

    def find_wrong_frame(self) -> Iterator[tuple[int, str, tuple[Remedy, ...]]]:
        """Where BEGIN PGM or END PGM is missing, or they differ, and what is right; the edits that are sure."""
        line = 1
        while (raw := self.read_raw(line)) is not None and _IGNORED_LINE.fullmatch(raw):
            line += 1
        begin = None if raw is None else _FRAME.match(raw)
        if begin is None or begin[1].upper() != b"BEGIN":
            yield (
                line,
                "BEGIN PGM is missing, and lengths are taken as mm; write BEGIN PGM, a name and MM as first line",
                (),
            )
        ends = self._list_ends()
        name, unit = ("NAME", "MM") if begin is None else _read_frame(begin)
        right = f"END PGM {name or 'NAME'} {unit}".rstrip()
        if not ends and (mistyped_end := self._find_mistyped_end(right)) is not None:
            yield mistyped_end
            return
        if not ends:
            yield (
                self.n_lines,
                f"END PGM is missing, which ends the file on the control; write {right} as last line",
                (),
            )
            return
        if not (name and unit):  # BEGIN PGM is refused, with what END PGM has
            return
        end_name, end_unit = _read_frame(ends[-1])
        differ = end_name.upper() != name.upper() or (end_unit[:2] != unit[:2] and end_unit)
        if begin is not None and end_name and differ:
            number = count_line(self.source, ends[-1].start())
            what = f"END PGM differs from BEGIN PGM in line {line}"
            if end_name.upper() == name.upper() and unit and end_unit:
                yield (
                    number,
                    f"{what}; BEGIN has {unit} and END has {end_unit}; write in both the unit of the numbers",
                    (),
                )
                return
            written_line = decode_line(self.source[ends[-1].start(1) : max(ends[-1].end(2), ends[-1].end(3))])
            edit = Remedy(f"write {right}", right, line=number, misspelt=written_line, is_choice=bool(end_unit))
            if not end_unit:
                yield number, f"{what}; write {right}", (edit,)
                return
            first_line = decode_line(self.source[begin.start(1) : begin.end(3)])
            other = f"BEGIN PGM {end_name} {end_unit}"
            other_edit = Remedy(f"write {other}", other, line=line, misspelt=first_line, is_choice=True)
            yield number, f"{what}; write {right}, or {other} in line {line}", (edit, other_edit)

    def _list_ends(self) -> list[re.Match[bytes]]:
        """The END PGM of the file: those of its last lines, or all."""
        ends = _FRAME.finditer(self.source, max(len(self.source) - _TAIL, 0))
        found = [one for one in ends if one[1].upper() == b"END"]
        return found or [one for one in _FRAME.finditer(self.source) if one[1].upper() == b"END"]

    def complete_begin(self, error: ProgramError, line_text: str) -> None:
        """Say in the error of a BEGIN PGM that lacks its name or unit what END PGM has; sure where the rest fits."""
        written_line = re.search(r"BEGIN[ \t]+PGM\b[ \t]*([^;]*)", line_text, re.IGNORECASE)
        ends = self._list_ends()
        name, unit = _read_frame(ends[-1]) if ends else ("", "")
        if written_line is None or not (name and unit) or find_correction(error.message):
            return
        right, rest = f"BEGIN PGM {name} {unit}", written_line[1].strip().upper()
        is_sure = rest == unit or re.match(rf"{re.escape(name.upper())}(?:[ \t]|MM|INCH|$)", rest) is not None
        error.column, error.message = written_line.start() + 1, f"{error.message}; write {right}, as END PGM has it"
        error.edits = write_words(written_line[0].rstrip(), right, is_choice=not is_sure)

    def _find_mistyped_end(self, right: str) -> tuple[int, str, tuple[Remedy, ...]] | None:
        """The last line with text, if it is nearly END PGM."""
        line = self.n_lines
        while line > 0 and not (self.read_raw(line) or b"").strip():
            line -= 1
        code = _strip_comment(decode_line(self.read_raw(line) or b""))[0]
        written_line = re.sub(r"^[ \t]*\d*[ \t]*", "", code)
        head = "".join(written_line.split()).upper()[: len(_END)]
        if difflib.SequenceMatcher(None, head, _END).ratio() < _ALIKE:
            return None
        edit = Remedy(f"write {right}", right, line=line, misspelt=written_line)
        return line, f"{written_line} is no END PGM, which ends the file on the control; write {right}", (edit,)

    def skip_parameters(self, line: int) -> int:
        """The first line from one on that is no ``Q200=2``."""
        while (raw := self.read_raw(line)) is not None and _CYCLE_PARAMETER.match(decode_line(raw).upper()):
            line += 1
        return line

    def goes_on(self, line: int) -> bool:
        """True where a line ends with ~."""
        raw = self.read_raw(line)
        return raw is not None and _strip_comment(decode_line(raw))[1]

    def is_corner_next(self, line: int) -> bool:
        """True where the next statement from a line on is RND or CHF."""
        while (raw := self.read_raw(line)) is not None:
            if not _IGNORED_LINE.fullmatch(raw):
                return _CORNER.match(raw) is not None
            line += 1
        return False

    def _find_mistyped_label(self, line: int) -> str:
        """The label that a line is meant for whose LBL, or whose name, is mistyped; the error is kept for the end."""
        text = _strip_comment(decode_line(self.read_raw(line) or b""))[0]
        try:
            statement = read_statement([text], line)
            if statement.keyword != "LBL":
                return ""
            error = refuse_label(statement)
        except ProgramError as unread:
            error, correction = unread, find_correction(unread.message)
            if correction is not None and correction[1].isdigit():
                unread.line = line
                self.label_errors.append(unread)
                return ""
            # CALL LBK and GOTO LBK are no labels
            if correction is None or correction[1] != "LBL" or re.search("[A-Z]", text[: (unread.column or 1) - 1]):
                return ""
            statement = Statement(line, "LBL", _capitalise(text)[(unread.column or 1) - 1 + len(correction[0]) :])
        error.line = line
        self.label_errors.append(error)
        return _find_meant_label(statement.rest).strip('"')

    @cached_property
    def labels(self) -> dict[str, int]:
        """Label -> line of its LBL.

        Raises
        ------
        ProgramError
            VP023: a label that appears twice. VP001: LBL1 in place of LBL 1.
        """
        found: dict[str, int] = {}
        line, at, bare_line = 1, 0, 0
        for match in _LABEL.finditer(self.source):
            line += self.source.count(b"\n", at, match.start())
            at = match.start()
            name = label_name(next(one for one in match.groups() if one is not None))
            column = match.group().upper().index(b"LBL") + 1 if match.group(4) is None else 0
            if match.group(3) is not None:
                raise refuse_joined(match.group(3).decode().upper(), column, line)
            if _LETTER_IN_NUMBER.match(match.group()):
                self._find_mistyped_label(line)
            if match.group(4) is not None:
                meant_label = self._find_mistyped_label(line)
                if not meant_label:
                    bare_line = line if match.group(4).strip().upper() == b"LBL" else bare_line
                    continue
                name = label_name(meant_label)
            if name == "0":
                continue
            if name in found:
                wrong, right = f"LBL {name}", f"CALL LBL {name}"
                text = f"{wrong} appears twice, first in line {found[name]}; write {right} in the line that calls it"
                lines = (line, found[name])
                edits = tuple(
                    Remedy(f"write {right}", right, line=one, misspelt=wrong, is_choice=True) for one in lines
                )
                raise ProgramError("VP023", text, column, line=line, edits=edits)
            found[name] = line
        if bare_line:
            self._name_bare_label(bare_line, found)
        return found

    def _name_bare_label(self, line: int, found: dict[str, int]) -> None:
        """The label that a line with LBL alone is meant for: one that is called and missing, or else the end of one."""
        missing = [one for one in self._called_labels if one not in found] or ["0"]
        _name_choices(self.label_errors[-1], "LBL", missing, line)
        if len(missing) == 1 and missing != ["0"]:
            found[missing[0]] = line

    @property
    def _called_labels(self) -> list[str]:
        """The labels that statements call, or jump to."""
        return [label_name(one[1] or one[2]) for one in _TO_LABEL.finditer(self.source)]

    def name_label(self, error: ProgramError, keyword: str, line: int) -> None:
        """Add to the error of LBL, or of CALL LBL, alone which label it lacks: one of those without the other."""
        labels = self.labels
        if keyword == "CALL LBL":
            called_labels = self._called_labels
            _name_choices(error, keyword, [one for one in labels if one not in called_labels], line)
        elif same := next((one for one in self.label_errors if one.line == line), None):
            error.message, error.edits = same.message, same.edits


def _name_choices(error: ProgramError, keyword: str, labels: list[str], line: int) -> None:
    """Add to an error the labels of which one stands behind a keyword."""
    rights = [f"{keyword} {one}" if is_count(one) else f'{keyword} "{one}"' for one in dict.fromkeys(labels)]
    if 0 < len(rights) <= _MOST_LABELS:
        error.message += f"; write {' or '.join(rights)}"
        error.edits = write_words(keyword, *rights, line=line, is_choice=True)


def find_equals(statement: Statement, text: str, at: int) -> ProgramError | None:
    """The error of a word with = before its number: SPA=25 may have either sign, the key of - is beside that of =."""
    word = _EQUALS.match(text, at)
    if word is None:
        return None
    what = "the letters and the number of a word have no = between them"
    signs = ("",) if word[2][0] in "+-" else ("+", "-") if word[2].strip("0.,") else ("+",)
    rights = [f"{word[1]}{sign}{word[2]}" for sign in signs]
    if len(rights) > 1:
        return statement.refuse_word(word[0].strip(), what, *rights, at=at)
    return statement.error("VP001", f"{word[0].strip()}: {what}; did you mean {rights[0]}?", at)


def _find_meant_label(text: str) -> str:
    """The number, or the name in quotes, that stands or is meant after LBL; empty where nothing is read from it."""
    word = text.strip()
    digits = word.translate(LETTERS_AS_DIGITS)
    if digits.isdecimal():
        return digits
    name = word.strip("\"'").strip()
    return f'"{name}"' if name and '"' not in name and not name[0].isdecimal() else ""


def refuse_label(statement: Statement) -> ProgramError:
    """The error of a label, or of the call of one, that is no number and no name in quotes."""
    written_label = re.sub(r"[ \t]+REP\b.*", "", statement.rest).strip()
    right = _find_meant_label(written_label)
    if not right or right == written_label:
        text = f"{statement.keyword} needs {'a label, ' * (statement.keyword != 'LBL')}a number or a name in quotes"
        return statement.error("VP001", text, 0)
    what = "a name stands between two quotes"
    if '"' not in right:
        written_label, what = written_label.replace("L", "l"), "a letter in the number"
    edits = (Remedy(f"write {right}", right, line=statement.line, misspelt=written_label, is_choice='"' in right),)
    return statement.error("VP001", f"{written_label}: {what}; did you mean {right}?", 0, edits)


def label_name(text: bytes | str) -> str:
    """A label as it is compared: numbers without leading zeros."""
    name = text.decode("latin-1") if isinstance(text, bytes) else text
    return str(int(name)) if is_count(name) else name


def join_keyword(statement: Statement, word: str) -> str:
    """The first word of a longer statement that begins with the letter of this one, as in C YCL DEF; empty if none."""
    first = f"{statement.keyword}{word}"
    keyword = KEYWORD.match(f"{statement.keyword}{statement.rest.lstrip()}")
    return first if keyword is not None and keyword.group().split()[0] == first else ""


def _read_frame(match: re.Match[bytes]) -> tuple[str, str]:
    """Name and unit of BEGIN PGM or END PGM; an empty unit where there is none."""
    name, unit = (decode_line(group or b"").strip().strip('"') for group in match.groups()[1:])
    return name, unit.upper()


def _is_cycle(text: str) -> bool:
    """Whether a line defines a cycle with Q parameters."""
    return _CYCLE.match(text) is not None


def _is_block(text: str) -> bool:
    """Whether a line begins with a word of the language, and not with a Q parameter."""
    text = _capitalise(_strip_comment(text)[0])
    number = _NUMBER.match(text)
    keyword = None if number is None else KEYWORD.match(text, number.end())
    return keyword is not None and not keyword.group().startswith("Q")


def _strip_comment(text: str) -> tuple[str, bool]:
    """A line without its comment, and whether it goes on (~)."""
    text = text.rstrip(" \t\r")
    return take_code(text.removesuffix("~")).rstrip(" \t"), text.endswith("~")


def _capitalise(text: str) -> str:
    """Upper case, but for what stands in quotes; other alphabets stay, so that columns do."""
    if text.isascii() and '"' not in text:
        return text.upper()
    parts = text.split('"')
    return '"'.join(
        part if index % 2 else "".join(c.upper() if c.isascii() else c for c in part)
        for index, part in enumerate(parts)
    )


def read_statement(parts: list[str], line: int) -> Statement:
    """The statement of some lines, of which ``line`` is the first.

    Raises
    ------
    ProgramError
        VP002: they begin with no word of the language.
    """
    text = _capitalise(parts[0])
    number = _NUMBER.match(text)
    assert number is not None
    is_deleted = number.group(1) is not None or number.group(3) is not None
    begin = number.end()
    if begin == len(text) and not any(parts[1:]):
        return Statement(line, "", "", begin, is_deleted)
    if text.startswith("*", begin):  # a structure line
        return Statement(line, "", text[begin:], begin, is_deleted)
    keyword = KEYWORD.match(text, begin)
    if keyword is None or is_half_keyword(text, keyword):
        raise refuse_unread(text, number, line)
    name = " ".join(keyword.group().split())
    at = keyword.end() if name not in ("Q", "QL", "QR", "QS", "M", "F", "S", "R0", "RL", "RR") else begin
    rest, further_lines = text[at:], list[int]()
    for part in parts[1:]:
        further_lines.append(len(rest) + 1)
        rest += f" {_capitalise(part)}"
    return Statement(line, name, rest.rstrip(" "), at, is_deleted, tuple(further_lines))


def _translate_lines(text: bytes) -> bytes:
    """Lines in words of RS274/NGC; those that are no plain straight moves stay as no scanner can read them."""
    words = text.translate(_TRANSLATION)
    if b"~" in words:
        words = _GOES_ON.sub(b"?", words)
    if b"MAX" in words.upper():
        words = _RAPID.sub(rb"G0\1", words)
    words = _STRAIGHT.sub(b"G1", words)
    if b"R0" in words:
        words = _NO_SIDE.sub(b"", words)
    return _SPLIT_NUMBER.sub(b"?", words)
