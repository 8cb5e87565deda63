"""Texts of Siemens programs: lines, programs in one file (%_N_NAME_MPF), labels, and which lines belong together."""

import re
from functools import cached_property
from typing import ClassVar, Final

import numpy as np
from msgspec import Struct, field

from verne_post.base.long_text import Text, count_line
from verne_post.base.suggestions import LETTERS_OF_FUNCTIONS, find_correction, find_meant
from verne_post.gcode import plain_arcs
from verne_post.gcode.plain import PlainLines
from verne_post.gcode.program_error import CLOSE_IN_ORDER, ProgramError, write_before
from verne_post.gcode.setup import Setup
from verne_post.gcode.siemens.cursor import NAME, strip_zeros
from verne_post.gcode.siemens.headers import find_meant_header
from verne_post.gcode.siemens.slips import HEADS, explain_moved_blank
from verne_post.gcode.text import Chunk, Language, ProgramText, decode_line, take_code
from verne_post.gcode.words import mark_blanks_in_numbers, read_whole_lines, split_words
from verne_post.model.findings import Remedy

#: The line that begins a program in a file that holds several.
_HEADER: Final = re.compile(rb"^[ \t]*+%_N_([A-Za-z0-9_]+?)_(MPF|SPF)[ \t]*+\r?$", re.MULTILINE | re.IGNORECASE)
#: Skip level, block number, label: what may stand before a block.
_PREFIX: Final = re.compile(
    r"[ \t]*+(?P<skip>/[ \t]*+[0-9]?)?[ \t]*+(?:(?:N|:)[ \t]*+(?P<number>[0-9]+))?[ "
    r"\t]*+(?:(?P<label>[A-Za-z_][A-Za-z0-9_]*)[ \t]*+:(?!=))?",
    re.IGNORECASE,
)
#: A block number may have a slip, which is told in its line.
_BEGINS: Final = (
    rb"^[ \t]*+(?:/[ \t]*+[0-9]?)?[ \t]*+(?:[N:][ \t]*+[0-9]+|(?=\w{0,8}[0-9])\w{1,9}(?=[ \t]))?[ \t]*+"
    rb"(?:[A-Z_][A-Z0-9_]*[ \t]*+:(?!=)[ \t]*+)?"
)
_STRUCTURE: Final = re.compile(
    _BEGINS + rb"(IF|ELSE|ENDIF|FOR|ENDFOR|WHILE|ENDWHILE|LOOP|ENDLOOP|REPEAT|UNTIL)(?![A-Z0-9_])([^\n]*)",
    re.IGNORECASE | re.MULTILINE,
)
_FIRST_WORD: Final = re.compile(_BEGINS + rb"([A-Z][A-Z0-9]*)(?![A-Z0-9_])", re.IGNORECASE | re.MULTILINE)
_TWO_PARTS: Final = re.compile(rb"[A-Z]+[ \t]+[A-Z]+(?![A-Z0-9_])", re.IGNORECASE)
_DIVIDED_END: Final = re.compile(rb"END[ \t]+(?:IF|FOR|WHILE|LOOP)(?![A-Z0-9_])", re.IGNORECASE)
_LABEL: Final = re.compile(
    rb"^[ \t]*+(?:/[ \t]*+[0-9]?)?[ \t]*+(?:[N:][ \t]*+[-+]?[0-9OIL]+)?[ \t]*+([A-Z_][A-Z0-9_]*)[ \t]*+:(?!=)",
    re.IGNORECASE | re.MULTILINE,
)
#: A line of this name alone, and a jump to it.
_BARE_LABEL: Final = rb"^[ \t]*+(?:[N:][ \t]*+[0-9]+)?[ \t]*+(%s)[ \t\r]*(?:;[^\n]*)?$"
#: A line of one word that has this name in it.
_LINE_WITH_NAME: Final = rb"^[ \t]*+([^ \t\r\n]{0,9}%s[^ \t\r\n]{0,9})[ \t\r]*$"
#: The line that begins the subprogram whose PROC line has this name.
_HEADER_ABOVE_PROC: Final = (
    rb"^[ \t]*+%%_N_(\w+)_SPF[ \t]*+\r?\n(?:[ \t]*+(?:;[^\n]*+)?+\r?\n)*+[ \t]*+(?:N\d+[ \t]*+)?PROC[ \t]+%s(?!\w)"
)
_PROC_LINE: Final = rb"^[ \t]*+(?:N\d+[ \t]*+)?(PROC)[ \t]+%s(?!\w)"
_TARGET: Final = rb"(?<![A-Z0-9_])GOTO[FBC]?[ \t]+%s(?![A-Z0-9_])"
_NUMBER: Final = re.compile(rb"^[ \t]*+(?:/[ \t]*+[0-9]?)?[ \t]*+([N:])[ \t]*+([0-9]+)", re.IGNORECASE | re.MULTILINE)
#: Characters behind a word that may be those of its name.
_LONGEST_NAME: Final = 40
#: Also one that lacks a blank, or has a 0 for an O.
_JUMPS: Final = re.compile(rb"(?<![A-Z_])G[O0]T[O0]", re.IGNORECASE)
#: A line of one word that may be meant for ELSE.
_LONE_WORD: Final = re.compile(_BEGINS + rb"([ELS]{3,5})(?=[ \t\r]*(?:;[^\n]*)?$)", re.IGNORECASE | re.MULTILINE)
_CLOSES: Final = {"ENDIF": "IF", "ENDFOR": "FOR", "ENDWHILE": "WHILE", "ENDLOOP": "LOOP", "UNTIL": "REPEAT"}
#: Words that are no slip of another one.
_STRUCTURE_WORDS: Final = (*_CLOSES, *_CLOSES.values(), "ELSE")
#: Ends that no condition follows.
_WITHOUT_VALUE: Final = ("ENDIF", "ENDFOR", "ENDWHILE", "ENDLOOP")

#: What the reader of plain words would pass, and these controls do not: comments in brackets, G1.0, G.0, N.5.
_NOT_PLAIN: Final = re.compile(rb"\(|(?<=[GgNn])\.|(?<=[Gg][01])\.|(?<=[Gg]0[01])\.")
#: A3= and so on, the letters that stand for them in the table of words, and what takes those letters away before.
_VECTOR: Final = re.compile(rb"([ABC])3[ \t]*+=", re.IGNORECASE)
_STANDS_FOR: Final = np.zeros(256, dtype=np.uint8)
_STANDS_FOR[list(b"ABCabc")] = list(b"IJKIJK")
_NO_CENTERS: Final = bytes.maketrans(b"IJKijk", b"??????")
#: The same for CR=, with what stands for it in between.
_RADIUS: Final = re.compile(rb"CR[ \t]*+=", re.IGNORECASE)
_BETWEEN: Final = b"\x02"
#: To look for these first is much quicker.
_IN_VECTORS: Final = (b"3=", b" =", b"\t=")
_IN_RADII: Final = (b"CR", b"cr", b"Cr", b"cR")
_NO_RADII: Final = bytes.maketrans(b"Rr" + _BETWEEN, b"??R")
_POINT, _ZERO, _THREE, _EQUALS, _BLANK = b".03= "
#: A capital letter differs from its small one by this bit.
_CASE: Final = 0x20


def _mark_strange(text: bytes) -> bytes:
    """A chunk in which what is not plain here, but is in other dialects, has a character that no plain word has."""
    raw = np.frombuffer(text + b"\n\n\n", dtype=np.uint8)
    g = np.flatnonzero(raw[:-3] | _CASE == ord("g"))
    point = (raw[g + 1] == _POINT) | (raw[g + 2] == _POINT) | ((raw[g + 1] == _ZERO) & (raw[g + 3] == _POINT))
    if b"(" in text or b"N." in text or b"n." in text or point.any():
        text = _NOT_PLAIN.sub(b"?", text)
    return mark_blanks_in_numbers(text)


def _put_radii(text: bytes) -> bytes:
    """A chunk with R for CR=; where it stood before is a character that no plain word has."""
    text = text.replace(_BETWEEN, b"?")
    if b"=" in text and any(part in text for part in _IN_RADII):
        text = _RADIUS.sub(_BETWEEN, text)
    return text.translate(_NO_RADII)


def _has_vectors(text: bytes) -> bool:
    return b"=" in text and any(part in text for part in _IN_VECTORS) and _VECTOR.search(text) is not None


def _put_vectors(text: bytes) -> bytes:
    """A chunk with I, J and K for A3=, B3= and C3=; where they stood before is a character that no plain word has."""
    characters = bytearray(text.translate(_NO_CENTERS))
    raw = np.frombuffer(characters, dtype=np.uint8)
    equals = np.flatnonzero(raw[2:] == _EQUALS) + 2
    stands_for = _STANDS_FOR[raw[equals - 2]]
    is_vector = (stands_for != 0) & (raw[equals - 1] == _THREE)
    if not is_vector.all():
        equals, stands_for = equals[is_vector], stands_for[is_vector]
    raw[equals - 2] = stands_for
    raw[equals - 1] = raw[equals] = _BLANK  # a word may have blanks before its number
    put_text = bytes(characters)
    # as few are written with blanks, these are looked for one by one
    return put_text if is_vector.all() else _VECTOR.sub(lambda match: bytes([_STANDS_FOR[match[1][0]]]), put_text)


def refuse_header(text: str, right: str, line: int | None = None) -> ProgramError:
    """The error of a line that is meant for another one, with which a program begins."""
    wrong = text.strip()
    message = f"{wrong}: no program begins with this line; did you mean {right}?"
    return ProgramError("VP001", message, text.index(wrong) + 1, line)


class SiemensLanguage(Language):
    """No % begins a program here, and there are no O words; the texts mark by themselves what is not plain."""

    percent: ClassVar[bytes] = rb"(?!)"
    o_letters: ClassVar[bytes] = b"\x00"


class Line(Struct, frozen=True):
    """One line without comment, number and label: where its block begins, and what stood before."""

    text: str
    begin: int
    is_skipped: bool
    label: str | None


def split_line(raw: bytes) -> Line:
    """Take a line apart."""
    text = take_code(decode_line(raw).rstrip("\r"))
    match = _PREFIX.match(text)
    assert match is not None
    label = match["label"]
    return Line(text, match.end(), match["skip"] is not None, label.upper() if label else None)


class Section(Struct, frozen=True, eq=False):
    """A program or subprogram: a stretch of lines, ``last`` included; not ``is_whole``: lines between two labels."""

    text: "SiemensText"
    name: str
    first: int
    last: int
    is_main: bool
    is_whole: bool = True


class Structure(Struct):
    """Lines that belong together, by line: IF -> ELSE or ENDIF, ELSE -> ENDIF, loops -> their ends, and back."""

    branch: dict[int, int] = field(default_factory=dict)
    end: dict[int, int] = field(default_factory=dict)
    begin: dict[int, int] = field(default_factory=dict)
    until: set[int] = field(default_factory=set)  # lines of REPEAT that UNTIL ends


class SiemensText(ProgramText):
    """One file: its lines in chunks, and the programs in it."""

    def __init__(self, source: Text, setup: Setup, name: str | None = None) -> None:
        super().__init__(source, setup, SiemensLanguage, name)

    def make_chunk(self, first_line: int, text: bytes) -> Chunk:
        """Split the lines of a chunk into words: those of arcs, or, where there are tool axes, these as I, J and K."""
        marked_text, vectors = _mark_strange(text), _has_vectors(text)
        words = split_words(first_line, _put_vectors(marked_text) if vectors else _put_radii(marked_text))
        lines = PlainLines(words, self.setup, bare_codes=False, others="IJK" if vectors else plain_arcs.WORDS)
        return Chunk(first_line, text, lines, words)

    @cached_property
    def sections(self) -> list[Section]:
        """The programs of the file, in order; a file without %_N_ lines is one program."""
        starts: list[tuple[int, str, bool]] = []
        line = 1
        for chunk in read_whole_lines(self.source):
            if b"%" in chunk:
                starts += [
                    (line + chunk.count(b"\n", 0, match.start()), match[1].decode().upper(), match[2].upper() == b"MPF")
                    for match in _HEADER.finditer(chunk)
                ]
            line += chunk.count(b"\n")
        before = starts[0][0] - 1 if starts else self.n_lines
        # comments before the first header belong to no program
        if any(take_code(decode_line(self.read_line(number))).strip() for number in range(1, before + 1)):
            starts.insert(0, (0, "", True))
        if not starts:
            return [Section(self, (self.name or "").partition(".")[0].upper(), 1, self.n_lines, True)]
        ends = [first - 1 for first, *_ in starts[1:]] + [self.n_lines]
        return [
            Section(self, name, first + 1, last, main) for (first, name, main), last in zip(starts, ends, strict=True)
        ]

    @property
    def main(self) -> Section:
        """The program that is executed."""
        return next((section for section in self.sections if section.is_main), self.sections[0])

    def find_section(self, name: str) -> Section | None:
        """The program of that name in this file."""
        return next((section for section in self.sections if section.name == name), None)

    # --- labels -----------------------------------------------------------------------------------------

    @cached_property
    def labels(self) -> dict[str, list[int]]:
        """Label, or block number as N10, -> lines."""
        found: dict[str, list[int]] = {}
        for pattern in (_LABEL, _NUMBER):
            line, at = 1, 0
            for match in pattern.finditer(self.source):
                line += self.source.count(b"\n", at, match.start())
                at = match.start()
                name = (
                    match[1].decode().upper()
                    if pattern is _LABEL
                    else f"{match[1].decode().upper()}{strip_zeros(match[2].decode())}"
                )
                found.setdefault(name, []).append(line)
        return found

    def find_bare_label(self, name: str) -> ProgramError | None:
        """The error of the one line that has a label without its colon; None where no line, or several, has it."""
        if not NAME.fullmatch(name):
            return None
        found = list(re.finditer(_BARE_LABEL % name.encode(), self.source, re.IGNORECASE | re.MULTILINE))
        if len(found) != 1:
            return None
        line = count_line(self.source, found[0].start())
        edits = (Remedy(f"write {name}:", f"{name}:", line=line, way="marked"),)
        column = found[0].start(1) - found[0].start() + 1
        return ProgramError("VP001", f"{name}: a label ends with a colon; write {name}:", column, line, edits=edits)

    def find_damaged_labels(self, name: str) -> list[int]:
        """The lines of a label that stands behind what cannot be read, or has a blank in it."""
        letters = rb"[ \t]*".join(re.escape(one.encode()) for one in name[:_LONGEST_NAME])
        pattern = rb"^[ \t]*+N?[\w \t]{0,12}?%b[ \t]*:(?!=)" % letters
        found = re.finditer(pattern, self.source, re.IGNORECASE | re.MULTILINE)
        lines = (count_line(self.source, one.start()) for one in found)
        return [line for line in lines if split_line(self.read_line(line)).label is None]

    def find_misspelt_header(self, name: str) -> ProgramError | None:
        """The error of a line that would begin the subprogram of this name, such as %_NFACE_SPF; None without one.

        A slip in the name shows where the PROC line below has it right.
        """
        for match in re.finditer(_LINE_WITH_NAME % name.encode(), self.source, re.IGNORECASE | re.MULTILINE):
            if find_meant_header(match[1].decode(errors="replace"), is_first=False) == f"%_N_{name}_SPF":
                line = count_line(self.source, match.start())
                return refuse_header(decode_line(match[0]), f"%_N_{name}_SPF", line)
        above = re.search(_HEADER_ABOVE_PROC % name.encode(), self.source, re.IGNORECASE | re.MULTILINE)
        if above is not None and above[1].decode().upper() != name:
            line = count_line(self.source, above.start())
            wrong = f"%_N_{above[1].decode()}_SPF"
            message = f"{wrong}: the PROC line below it begins {name}; did you mean %_N_{name}_SPF?"
            return ProgramError("VP001", message, above.start(1) - above.start() - 3, line)
        proc = re.search(_PROC_LINE % name.encode(), self.source, re.IGNORECASE | re.MULTILINE)
        if proc is not None and self.find_section(name) is None:
            line, right = count_line(self.source, proc.start()), f"%_N_{name}_SPF"
            message = f"PROC {name}: no subprogram begins here without the line {right} before it; write that line"
            column = proc.start(1) - proc.start() + 1
            return ProgramError("VP001", message, column, line, edits=write_before(right, line=line))
        return None

    def is_target(self, name: str) -> bool:
        """Whether a jump of the text names this label."""
        return re.search(_TARGET % name.encode(), self.source, re.IGNORECASE) is not None

    # --- structure --------------------------------------------------------------------------------------

    @cached_property
    def structure(self) -> Structure:  # type: ignore[override]
        """Which lines belong together.

        ProgramError VP023, with its line: something is closed that is not open, or never closed.
        """
        structure, open_words = Structure(), list[tuple[str, int, int]]()
        line, at = 1, 0
        for match in _STRUCTURE.finditer(self.source):
            line += self.source.count(b"\n", at, match.start())
            at = match.start()
            word = match[1].decode().upper()
            rest = take_code(decode_line(match[2]))
            if word == "IF" and _JUMPS.search(_blank_texts(rest)):
                continue
            if word == "REPEAT" and rest.strip() and not rest.strip().startswith("/"):
                continue  # REPEAT label
            if (word in _CLOSES or word == "ELSE") and not _fits(open_words, word):
                self._refuse_misspelt_begin(_CLOSES.get(word, "IF"), open_words[-1][1] if open_words else 0, line)
                if open_words:
                    self._refuse_open(*open_words[-1], line)
            self._take(structure, open_words, word, line, match.start(1) - match.start() + 1)
        for opening in open_words:
            self._refuse_open(*opening)
        return structure

    @cached_property
    def like_else(self) -> dict[int, tuple[str, int]]:
        """Lines of one word that may be meant for ELSE: the word and its column."""
        found = dict[int, tuple[str, int]]()
        for match in _LONE_WORD.finditer(self.source):
            if find_meant(match[1].decode().upper(), ["ELSE"], slip_alone=True):
                line = count_line(self.source, match.start(1))
                found[line] = match[1].decode(), match.start(1) - match.start() + 1
        return found

    def has_name(self, name: str) -> bool:
        """Whether a name stands in the text."""
        return re.search(rb"(?<![\w$])%b(?!\w)" % re.escape(name.encode()), self.source, re.IGNORECASE) is not None

    def _refuse_open(self, word: str, begin: int, column: int, end: int = 0) -> None:
        """Refuse (VP023) what is never closed; what another word closes at ``end``, if its own end is misspelt."""
        closing = _find_end(word)
        edits = self._find_misspelt_end(begin, closing, end)
        text = f"{word} is never closed; expected {closing}"
        text += "".join(f", which line {edit.line} writes as {edit.misspelt}" for edit in edits)
        if edits or not end:
            raise ProgramError("VP023", text, column, line=begin, edits=edits)

    def _refuse_misspelt_begin(self, opening: str, begin: int, end: int) -> None:
        """Refuse (VP002) the first word of a line between two that is nearly the one which opens a structure."""
        for match in _FIRST_WORD.finditer(self.source):
            word = match[1].decode()
            if message := self._explain_moved_blank(match, opening):
                line = count_line(self.source, match.start(1))
                if begin < line < end:
                    raise ProgramError("VP001", message, match.start(1) - match.start() + 1, line=line)
            code, what = "VP002", "no meaning in this language"
            if opening.startswith(word.upper()) and word.upper() != opening:
                two_words = _TWO_PARTS.match(self.source, match.start(1))
                word = "" if two_words is None else two_words[0].decode()
                code, what = "VP001", "a blank is in the word"
            one_word = "".join(word.upper().split())
            least = LETTERS_OF_FUNCTIONS  # the end that has no begin says that FPR is none but FOR
            if word.upper() == opening or not (
                one_word == opening or find_meant(one_word, [opening], slip_alone=True, least=least)
            ):
                continue
            line = count_line(self.source, match.start())
            if begin < line < end:
                message = f"{word}: {what}; did you mean {opening}?"
                raise ProgramError(code, message, match.start(1) - match.start() + 1, line=line)

    def _explain_moved_blank(self, match: "re.Match[bytes]", word: str) -> str:
        """The message about a statement whose blank is missing or one place too far, at the begin of a line."""
        if match[1][:1].upper() != word[:1].encode() or word not in HEADS:
            return ""
        text = decode_line(self.source[match.start(1) : match.end(1) + _LONGEST_NAME])
        return explain_moved_blank(text.partition("\n")[0], 0, [word], lambda _head, name: self.has_name(name))

    def _find_misspelt_end(self, begin: int, closing: str, end: int) -> tuple[Remedy, ...]:
        """The first word of a line below that is nearly the end of a structure; up to ``end`` if it is not 0."""
        is_near: dict[str, bool] = {}  # a long text has few words
        for match in _FIRST_WORD.finditer(self.source):
            word = match[1].decode()
            if word.upper() == "END" and (two_words := _DIVIDED_END.match(self.source, match.start(1))):
                word = two_words[0].decode()  # END FOR
            correction = find_correction(self._explain_moved_blank(match, closing))
            if correction is not None:
                word, is_near[correction[0]] = correction[0], True
            elif word not in is_near:
                one_word = "".join(word.upper().split())
                is_near[word] = word.upper() not in _STRUCTURE_WORDS and (
                    one_word == closing or bool(find_meant(one_word, [closing]))
                )
            line = count_line(self.source, match.start(1)) if is_near[word] else 0
            if begin < line and not 0 < end <= line:
                right = closing if correction is None else correction[1]
                return (Remedy(f"write {right}", right, line=line, misspelt=word),)
        return ()

    @staticmethod
    def _take(structure: Structure, open_words: list[tuple[str, int, int]], word: str, line: int, column: int) -> None:
        if word in ("IF", "FOR", "WHILE", "LOOP", "REPEAT"):
            open_words.append((word, line, column))
            return
        if not _fits(open_words, word):
            text, edits = f"{word} without {_CLOSES.get(word, 'IF')} before it", tuple[Remedy, ...]()
            if open_words:
                opening, begin, _column = open_words[-1]
                text += f"; {opening} of line {begin} is open"
                right = _find_end(opening)
                if word in _WITHOUT_VALUE and right in _WITHOUT_VALUE:
                    edits = (Remedy(f"write {right}", right, line=line, misspelt=word),)
            raise ProgramError("VP023", text, column, line=line, edits=edits).advise(CLOSE_IN_ORDER)
        _word, begin, _column = open_words.pop()
        structure.branch[begin] = line
        structure.end[begin], structure.begin[line] = line, begin
        if word == "ELSE":
            open_words.append(("ELSE", line, column))


def _fits(open_words: list[tuple[str, int, int]], word: str) -> bool:
    """Whether a word closes what is open, or is the ELSE of it."""
    opening = open_words[-1][0] if open_words else ""
    return opening == _CLOSES.get(word, "IF") or (word == "ENDIF" and opening == "ELSE")


def _find_end(word: str) -> str:
    """What closes a structure that a word opens."""
    return next(end for end, opening in _CLOSES.items() if opening == ("IF" if word == "ELSE" else word))


def _blank_texts(text: str) -> bytes:
    return re.sub(r'"[^"]*"', "", text).encode()
