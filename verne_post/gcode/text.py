"""A program text: chunks of lines split into words on demand, its limits, and where its O words lead."""

import re
from abc import ABC, abstractmethod
from collections import OrderedDict
from functools import cached_property
from itertools import pairwise
from typing import ClassVar, Final

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Ints
from verne_post.base.long_text import Text, count_line, decode_lines
from verne_post.base.program_lines import find_end, remove_remarks
from verne_post.gcode import plain_arcs
from verne_post.gcode.block import ZERO_FOR_O, Block, build_block_of_words, read_block, refuse_zero
from verne_post.gcode.plain import PlainLines
from verne_post.gcode.program_error import CLOSE_IN_ORDER, ProgramError, end_with, write_words
from verne_post.gcode.setup import Setup
from verne_post.gcode.words import (
    OPENING_BYTES,
    WordTable,
    count_lines,
    find_chunk_end,
    read_whole_lines,
    split_words,
)
from verne_post.model.findings import Remedy

#: So many chunks are kept: loops that stay within them are split into words once.
_KEPT_CHUNKS: Final = 8
_SILENT: Final = rb"(?:[ \t\r/]|\([^()\n]*\))*+"  # possessive: a line of blanks is passed once
_O_LINE: Final = rb"^" + _SILENT + rb"(?:N[ \t0-9.+]*+" + _SILENT + rb")?[%b][^\n]*"


#: A line that may be an O word with a zero for its letter.
_ZERO_LINE: Final = re.compile(
    rb"^[ \t]*(?:N\d+[ \t]*)?(0(?:<[^<>\n]*>|\d+)[ \t]*[A-Z]+)", re.MULTILINE | re.IGNORECASE
)

#: A line of RS274/NGC that calls a subprogram, which one of a file of its own seldom does.
_CALL: Final = re.compile(rb"^[^(;\n]*\bCALL\b", re.MULTILINE | re.IGNORECASE)


#: A line up to its semicolon outside texts.
_BEFORE_REMARK: Final = re.compile(r'(?:[^";]|"[^"]*(?:"|$))*+')


class Language:
    """What a text must know of its language; the defaults are for words of RS274/NGC with nothing before them."""

    #: What may follow a ``%`` that begins or ends a program, as a regular expression.
    percent: ClassVar[bytes] = rb"[ \t\r]*"
    #: Letters that begin an O word.
    o_letters: ClassVar[bytes] = b"O"
    #: A ``%`` ends a program also where none begins it.
    end_alone: ClassVar[bool] = False

    @classmethod
    def prepare(cls, text: str) -> str:
        """A line in the words of RS274/NGC; every character keeps its column."""
        return text

    @classmethod
    def label_of(cls, text: str) -> str:
        """What a line that begins with an O word says about the structure."""
        return cls.prepare(text)

    @classmethod
    def find_start(cls, source: Text) -> int:
        """Where the program begins in its text: after what a control does not read."""
        return 0

    @classmethod
    def leave_to_reader(cls, text: bytes, words: WordTable, setup: Setup) -> Ints:
        """Lines of a chunk, from 0, that mean more than their words, so that only the exact reader can read them."""
        return np.empty(0, dtype=np.int32)


class Chunk(Struct, frozen=True, dict=True):
    """Scanned lines and their tables."""

    first_line: int
    text: bytes
    lines: PlainLines
    words: WordTable | None = None

    @cached_property
    def end_line(self) -> int:
        """The line after the last."""
        return self.first_line + len(self.lines.plain)

    @cached_property
    def _ends(self) -> list[int]:
        """Where each line ends, without its line end."""
        ends = np.flatnonzero(np.frombuffer(self.text, dtype=np.uint8) == ord("\n")).tolist()
        return ends if self.text.endswith(b"\n") else [*ends, len(self.text)]

    def read_raw(self, row: int) -> bytes:
        """A line itself, counted from 0."""
        ends = self._ends
        return self.text[ends[row - 1] + 1 if row else 0 : ends[row]]

    @cached_property
    def _starts(self) -> list[int]:
        assert self.words is not None
        return np.searchsorted(self.words.row, np.arange(self.words.n_lines + 1)).tolist()

    def build_block(self, row: int, line: int) -> Block | None:
        """The block of a line of plain words, counted from 0; None for any other line."""
        if self.words is None or not self.words.plain[row]:
            return None
        words = slice(self._starts[row], self._starts[row + 1])
        return build_block_of_words(
            self.words.letter[words].tobytes().decode("ascii"), self.words.value[words].tolist(), line
        )


class Structure(Struct):
    """Where O words lead, by line: everything that is known without executing."""

    subs: dict[str, tuple[int, int]] = field(default_factory=dict)  #: Label -> (line of sub, line of endsub).
    programs: dict[str, int] = field(default_factory=dict)  #: Number -> line of an O number that stands alone.
    repeated_numbers: dict[str, int] = field(default_factory=dict)  #: Number -> its second line.
    #: Line of if or elseif -> line of the next elseif, else or endif.
    branch: dict[int, int] = field(default_factory=dict)
    #: Line of if, elseif, else -> line of endif; of while, do, repeat -> the line that ends the loop.
    end: dict[int, int] = field(default_factory=dict)
    begin: dict[int, int] = field(default_factory=dict)  #: Line that ends a loop -> line that begins it.
    loop: dict[int, int] = field(default_factory=dict)  #: Line of break or continue -> line that begins its loop.


class ChunkedText(ABC):
    """One file, in chunks of lines that are scanned when they are reached; the last few are kept.

    ``name`` is None for the program itself, else the file of a subroutine.
    """

    language: type[Language] | None = None
    #: The first chunk that was scanned last, and what it depends on: the search for the start runs the opening lines
    #: several times before the program itself does.
    _opening: ClassVar[tuple[tuple[object, ...], Setup, Chunk] | None] = None

    def __init__(self, source: Text, setup: Setup, name: str | None = None) -> None:
        self.source, self.setup, self.name = source, setup, name
        self._starts = [(1, 0)]  # first line and offset of every chunk met so far
        self._kept_chunks: OrderedDict[int, Chunk] = OrderedDict()
        self._last: Chunk | None = None

    @cached_property
    def n_lines(self) -> int:
        """How many lines the file has."""
        return max(sum(count_lines(text) for text in read_whole_lines(self.source)), 1)

    @abstractmethod
    def make_chunk(self, first_line: int, text: bytes) -> Chunk:
        """Scan the lines of a chunk."""

    def find_chunk(self, line: int) -> Chunk | None:
        """The chunk that holds a line; None after the end of the text."""
        last = self._last
        if last is not None and last.first_line <= line < last.end_line:
            return last
        self._last = self._find_chunk(line)
        return self._last

    def _find_chunk(self, line: int) -> Chunk | None:
        for chunk_before in reversed(self._kept_chunks.values()):
            if chunk_before.first_line <= line < chunk_before.end_line:
                return chunk_before
        while True:
            first, start = self._starts[-1]
            if line < first or start >= len(self.source):
                break
            end = find_chunk_end(self.source, start)
            self._starts.append((first + count_lines(self.source[start:end]), end))
        at = next((i for i in range(len(self._starts) - 2, -1, -1) if self._starts[i][0] <= line), None)
        if at is None or line >= self._starts[at + 1][0]:
            return None
        first, start = self._starts[at]
        text = self.source[start : self._starts[at + 1][1]]
        is_opening = first == 1 and len(text) <= OPENING_BYTES
        chunk = self._scan_opening(text) if is_opening else self.make_chunk(first, text)
        self._kept_chunks[first] = chunk
        if len(self._kept_chunks) > _KEPT_CHUNKS:
            self._kept_chunks.popitem(last=False)
        return chunk

    def _scan_opening(self, text: bytes) -> Chunk:
        """The first chunk, while it is short; the same lines under the same set-up are scanned once."""
        key, last = (type(self), self.language, text), ChunkedText._opening
        if last is not None and last[0] == key and last[1] is self.setup:
            return last[2]
        chunk = self.make_chunk(1, text)
        ChunkedText._opening = key, self.setup, chunk
        return chunk


class ProgramText(ChunkedText):
    """One file.

    Attributes
    ----------
    name : str or None
        None for the program itself, else the file of a subroutine.
    first_line : int
        1-based; the lines before are not the program's.
    """

    def __init__(self, source: Text, setup: Setup, language: type[Language], name: str | None = None) -> None:
        super().__init__(source, setup, name)
        self.language: type[Language] = language
        start = language.find_start(source)
        self.first_line = count_line(source, start)
        self.opening, self.closing = _find_percent_lines(source, language, start)

    def make_chunk(self, first_line: int, text: bytes) -> Chunk:
        """Split the lines of a chunk into words."""
        words = split_words(first_line, text)
        words.plain[self.language.leave_to_reader(text, words, self.setup)] = False
        return Chunk(first_line, text, PlainLines(words, self.setup, others=plain_arcs.WORDS), words)

    def read_line(self, line: int) -> bytes:
        """One line."""
        chunk = self.find_chunk(line)
        return b"" if chunk is None else chunk.read_raw(line - chunk.first_line)

    def is_head(self, line: int) -> bool:
        """Whether nothing but remarks stands before a line of the program."""
        before = (decode_line(self.read_line(number)) for number in range(self.first_line, line))
        return not any(remove_remarks(text).strip(" \t\r/%") for text in before)

    @cached_property
    def _o_lines(self) -> re.Pattern[bytes]:
        return re.compile(_O_LINE % self.language.o_letters, re.MULTILINE | re.IGNORECASE)

    def has_o_word(self, line: int) -> bool:
        """Whether a line has an O word as it is written."""
        return self._o_lines.match(self.read_line(line)) is not None

    @cached_property
    def structure(self) -> Structure:
        """Where O words lead.

        Raises
        ------
        ProgramError
            VP023, with its line: labels that do not fit together.
        """
        structure, open_words = Structure(), _Opened(self.source)
        line, at = 1, 0
        for match in self._o_lines.finditer(self.source):
            line += self.source.count(b"\n", at, match.start())
            at = match.start()
            if line < self.first_line or (self.closing is not None and not (self.opening or 0) < line < self.closing):
                continue
            if self.setup.block_delete and match.group().lstrip().startswith(b"/"):
                continue
            try:
                block = read_block(self.language.label_of(decode_line(match.group())), line)
                if block.o is not None:
                    open_words.take(structure, block)
            except ProgramError as error:
                column = error.column or 1
                self._refuse_zero(line)
                error.column, error.line, error.breaks_structure = column, line, True
                raise
        try:
            open_words.check_all_closed(self.source)
        except ProgramError:
            self._refuse_zero(self.n_lines + 1)
            raise
        return structure

    def _refuse_zero(self, last: int) -> None:
        """Refuse (VP023) an O word before a line that begins with the digit 0: the structure lacks it."""
        for match in _ZERO_LINE.finditer(self.source):
            line = count_line(self.source, match.start())
            zero = ZERO_FOR_O.match("".join(match[1].decode("latin-1").split()))
            if zero is not None and self.first_line <= line < last:
                error = refuse_zero(zero[1])
                error.column, error.line = match.start(1) - match.start() + 1, line
                raise error


def take_code(line: str) -> str:
    """A line without its comment; a semicolon inside a text begins none."""
    return _BEFORE_REMARK.match(line)[0] if ";" in line else line  # type: ignore[index]


def count_name(source: Text, name: str) -> int:
    """How often a name stands in a program."""
    return len(re.findall(rb"(?<![\w])%b(?!\w)" % re.escape(name.encode()), bytes(source), re.IGNORECASE))


def decode_line(raw: bytes) -> str:
    """A line of bytes as text."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")  # older CAM systems; it can only matter inside comments


def _find_percent_lines(source: Text, language: type[Language], start: int) -> tuple[int | None, int | None]:
    """1-based lines of the opening and the closing ``%`` from an offset on; None where there are none."""
    opening = re.compile(rb"\s*%" + language.percent + rb"(?:\n|$)").match(source, start)
    if opening is None and not language.end_alone:
        return None, None
    first, after = None, start
    if opening is not None:
        first, after = count_line(source, source.find(b"%", start)), opening.end()
    pattern = re.compile(rb"^[ \t]*%" + language.percent + rb"$", re.MULTILINE)
    line = count_line(source, after)
    for text in read_whole_lines(source, after):
        closing = pattern.search(text)
        if closing is not None:
            return first, line + text.count(b"\n", 0, closing.start())
        line += text.count(b"\n")
    return first, None


# --- the structure of O words -----------------------------------------------------------------

_CLOSES: Final = {"endsub": "sub", "endif": "if", "endwhile": "while", "endrepeat": "repeat"}
_ENDS: Final = {begin: end for end, begin in _CLOSES.items()} | {"do": "while"}
_LOOPS: Final = ("while", "do", "repeat")
#: Keywords that take no value.
_BARE: Final = ("sub", "else", "endif", "do", "endwhile", "endrepeat", "break", "continue")


class _Construct(Struct):
    kind: str
    label: str
    line: int
    column: int
    branches: list[int] = field(default_factory=list)


class _Opened:
    """Constructs that are open while a text is read from top to bottom."""

    def __init__(self, source: Text) -> None:
        self._source = source
        self._open: list[_Construct] = []

    def take(self, structure: Structure, block: Block) -> None:
        """Go on with the next O word."""
        o, line = block.o, block.line
        assert o is not None
        if o.keyword in ("call", "return"):
            return
        if o.label is None:
            raise ProgramError("VP023", f"o... {o.keyword or ''}: a computed label can only be called")
        kind, label = o.keyword, o.label
        if kind in _BARE:
            o.check_bare()
        if kind is None:
            if structure.programs.setdefault(label, line) != line:
                structure.repeated_numbers.setdefault(label, line)
        elif kind == "while" and self._is_top("do", label):
            self._close_loop(structure, line)
        elif kind in ("sub", "if", *_LOOPS):
            if kind == "sub" and self._open:
                raise ProgramError("VP023", f"o{label} sub inside {self._describe(self._open[-1])}; close that first")
            if kind == "sub" and label in structure.subs:
                raise ProgramError("VP023", f"o{label} sub appears twice, first in line {structure.subs[label][0]}")
            self._open.append(_Construct(kind, label, line, o.reader.find_column(o.label_at - 1)))
        elif kind in ("elseif", "else"):
            self._expect("if", label, kind)
            self._open[-1].branches.append(line)
        elif kind in ("break", "continue"):
            loop = next((item for item in reversed(self._open) if item.kind in _LOOPS and item.label == label), None)
            if loop is None:
                raise ProgramError("VP023", f"o{label} {kind} is in no loop with this label").advise(CLOSE_IN_ORDER)
            structure.loop[line] = loop.line
        else:
            self._close(structure, _CLOSES[kind], kind, label, line)

    def _close(self, structure: Structure, opening: str, kind: str, label: str, line: int) -> None:
        self._expect(opening, label, kind)
        if opening in _LOOPS:
            self._close_loop(structure, line)
            return
        item = self._open.pop()
        if opening == "sub":
            structure.subs[label] = (item.line, line)
            return
        bounds = [item.line, *item.branches, line]
        for here, following in pairwise(bounds):
            structure.branch[here] = following
            structure.end[here] = line

    def _close_loop(self, structure: Structure, line: int) -> None:
        item = self._open.pop()
        structure.end[item.line], structure.begin[line] = line, item.line

    def _is_top(self, kind: str, label: str) -> bool:
        return bool(self._open) and self._open[-1].kind == kind and self._open[-1].label == label

    def _expect(self, opening: str, label: str, kind: str) -> None:
        if not self._is_top(opening, label):
            still, edits = "", tuple[Remedy, ...]()
            if self._open:
                item = self._open[-1]
                still, wrong, right = f"; {self._describe(item)} is open", f"o{item.label}", f"o{label}"
                if count_name(self._source, wrong) == 1 and count_name(self._source, right) >= len(("end", "call")):
                    still += f"; line {item.line} has {wrong}, which nothing else names; write {right} there"
                    edits = write_words(wrong, right, line=item.line)
                elif item.kind == opening:
                    edits = write_words(right, wrong)
                if item.label == label and kind in _CLOSES:
                    edits = (Remedy(f"write {_ENDS[item.kind]}", _ENDS[item.kind], misspelt=kind),)
            raise ProgramError(
                "VP023", f"o{label} {kind} without o{label} {opening} before it{still}", edits=edits
            ).advise(CLOSE_IN_ORDER)

    @staticmethod
    def _describe(item: _Construct) -> str:
        return f"o{item.label} {item.kind} (line {item.line})"

    def check_all_closed(self, source: Text) -> None:
        """Nothing may be open at the end of the text.

        Behind the end of the program what is to be written is certain, and in a file of one subprogram.
        """
        if self._open:
            item = self._open[-1]
            end = f"o{item.label} {_ENDS[item.kind]}"
            stop = find_end(decode_lines(source))
            is_file = stop is None and len(self._open) == 1 and _CALL.search(source) is None
            is_last = item.kind == "sub" and (is_file or (stop is not None and stop < item.line - 1))
            raise ProgramError(
                "VP023",
                f"o{item.label} {item.kind} is never closed; expected {end}",
                item.column,
                line=item.line,
                edits=end_with(end) if is_last else (),
            )
