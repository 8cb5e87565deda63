"""Words of path functions: coordinates (absolute or I for incremental), feed, compensation, M functions."""

import re
from contextlib import suppress
from typing import Final

from msgspec import Struct, field

from verne_post.base.numbers import is_count
from verne_post.gcode.klartext.formulas import VALUE, Numbers, read_value
from verne_post.gcode.klartext.slips import find_slip
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.vocabulary import WORDS
from verne_post.gcode.mistyped import explain_unknown
from verne_post.gcode.program_error import ProgramError

#: Functions that take numbers after them, by M number, and the words that belong to them.
_M_WORDS: Final = {128: ("F",), 140: ("F", "MB"), 103: ("F",), 120: ("LA",), 112: ("T", "A")}
_SIDES: Final = r"R0(?![.,])|RL|RR|R\+(?![\d.,Q])|R-(?![\d.,Q])"
_NAMES: Final = "IPR|IPA|PR|PA|CCA|LEN|NX|NY|NZ|TX|TY|TZ|DL|DR2|DR|MB|LA|FU|FZ|I?[XYZABCUVW]|[FSRT]"


def _build_pattern(sides: str, names: str) -> re.Pattern[str]:
    return re.compile(
        rf"[ \t]*(?:(?P<comp>{sides})(?![A-Z0-9])|(?P<feed>F[ \t]*(?:MAX"
        r"|AUTO))(?![A-Z0-9])|(?P<rotation>DR[ \t]*[+-])(?![ \t]*[\d.,Q])|(?P<max>MB[ \t]*MAX)|M[ \t]*(?P<m>\d+)"
        rf"|(?P<name>{names})[ \t]*:?[ \t]*(?P<value>{VALUE})"
        r"|(?P<axis>[ABC])(?=[ \t]|$)|(?P<empty>[RFM])(?=[ \t]|$))"
    )


#: Words of a path function.
WORD: Final = _build_pattern(_SIDES, _NAMES)
#: Words of TOOL DEF: L is a length, and R0 the radius of a tool that is a line.
TOOL_WORDS: Final = _build_pattern("RL|RR", f"{_NAMES}|L")

#: Up to the next blank.
_UNREAD: Final = re.compile(r"[ \t]+|[^ \t]+")


class MWord(Struct, frozen=True):
    """An M function with the words that belong to it."""

    number: int
    column: int
    words: dict[str, float] = field(default_factory=dict)
    axes: str = ""
    to_limit: bool = False


class Words(Struct):
    """The words of one statement."""

    #: Letter (``X``, ``IX``, ``PR`` ...) -> value, in the unit of the program.
    values: dict[str, float] = field(default_factory=dict)
    columns: dict[str, int] = field(default_factory=dict)  #: Their places in the statement.
    compensation: str | None = None  #: R0, RL, RR.
    #: rapid, automatic: FMAX; F AUTO, the feed rate of TOOL CALL.
    rapid: bool = False
    automatic: bool = False
    rotation: int | None = None  #: DR+ is 1, DR- is -1.
    functions: list[MWord] = field(default_factory=list)

    def take(self, name: str) -> float | None:
        """A value that is used now; None where it is not given."""
        return self.values.pop(name, None)

    def read_coordinate(self, letter: str, here: float) -> float | None:
        """Where a coordinate leads from ``here``: X or IX; None where neither is given."""
        absolute, step = self.take(letter), self.take("I" + letter)
        if absolute is not None and step is not None:
            raise ProgramError("VP004", f"{letter} and I{letter} in one block")
        return absolute if step is None else here + step

    def take_no_other_feed(self, statement: Statement) -> None:
        """F AUTO is the only feed rate of its block."""
        for name in ("FU", "FZ"):
            if name in self.values:
                raise statement.error("VP004", f"F AUTO and {name} in one block", self.columns[name])

    def check_used(self, statement: Statement, other_words: str = "") -> None:
        """Refuse words that nothing has used; ``other_words`` may name side, F (FMAX, F AUTO), DR and M."""
        for name, value in self.values.items():
            written_word = statement.rest[self.columns[name] :].split()[0]
            divided_word = re.match(r"R[ \t]+0(?![^ \t])", statement.rest[self.columns[name] :])
            written_word = divided_word[0] if divided_word else written_word
            if not value and (divided_word or re.fullmatch("R00|T0", written_word)):  # keys beside R, or 0 twice
                text = f"{written_word}: {statement.keyword} does not use {name}; did you mean R0?"
                raise statement.error("VP006", text, self.columns[name])
            raise statement.error(
                "VP006", f"{statement.keyword or 'the block'} does not use {name}", self.columns[name]
            )
        if not (self.compensation or self.rapid or self.automatic or self.rotation or self.functions):
            return
        unused_words = {
            "side": self.compensation,
            "F": "FMAX" if self.rapid else "F AUTO" if self.automatic else None,
            "DR": "DR" if self.rotation is not None else None,
            "M": f"M{self.functions[0].number}" if self.functions else None,
        }
        used_words = other_words.split()
        for kind, shown_word in unused_words.items():
            if shown_word is not None and kind not in used_words:
                raise statement.error("VP006", f"{statement.keyword or 'the block'} does not use {shown_word}")


def read_words(statement: Statement, numbers: Numbers, pattern: re.Pattern[str] = WORD) -> Words:
    """The words after the keyword of a statement, those of a ``pattern``.

    Raises
    ------
    ProgramError
        With the column of the first character that fits nothing.
    """
    words, text, at = Words(), statement.rest, 0
    text = text.rstrip()
    while at < len(text):
        match = pattern.match(text, at)
        if match is None:
            raise _explain_unread(pattern, statement, text, at + len(text[at:]) - len(text[at:].lstrip()))
        begin = match.start() + len(match.group()) - len(match.group().lstrip())
        is_r0 = match["name"] == "R" and match["value"] == "0" and text[match.end() : match.end() + 1].isalpha()
        if match["value"] and (text.startswith("O", match.end()) or is_r0):
            raise _explain_unread(pattern, statement, text, begin if is_r0 else match.end())
        _add(statement, words, match, begin, numbers)
        at = match.end()
    return words


def _explain_unread(pattern: re.Pattern[str], statement: Statement, text: str, begin: int) -> ProgramError:
    """Why no word begins at a place of the text: a slip of the word that is meant, a number that is none or missing."""
    word = text[begin:].split()[0]
    if word[0] in ".," and text[begin - 1 : begin].isdigit():
        begin = len(text[:begin].rstrip()) - len(text[:begin].split()[-1])
        word = text[begin:].split()[0]
        return statement.error("VP001", f"{word}: two points in one number; write it with one", begin)
    if word == "DR" and statement.keyword in ("C", "CR", "CP", "CTP"):
        return statement.error("VP001", "DR without a sign; write DR+ or DR-", begin)
    if pattern.fullmatch(f"{word}1"):
        text = f"{word} without a number; write {word} and its value{', or MB MAX' if word == 'MB' else ''}"
        return statement.error("VP001", text, begin)
    if slip := find_slip(pattern, statement, text, begin, _NAMES.split("|")):
        return slip
    message = f"{word[:15]!r} is not a word of {statement.keyword or 'a block'}"
    known_words = (name for phrase in WORDS for name in phrase.split())
    message = explain_unknown(message, word, known_words, ("FAUTO",))
    return statement.error("VP001", message, begin)


def read_usable_words(statement: Statement, numbers: Numbers) -> Words:
    """As :func:`read_words`, of a statement that has been refused: what cannot be read is left out."""
    words, text, at = Words(), statement.rest, 0
    while at < len(text):
        match = WORD.match(text, at)
        if match is not None:
            with suppress(ProgramError):
                _add(statement, words, match, match.start(), numbers)
            at = match.end()
        else:
            at += _UNREAD.match(text[at:]).end()  # type: ignore[union-attr]
    return words


def _add(statement: Statement, words: Words, match: re.Match[str], begin: int, numbers: Numbers) -> None:
    found = match.groupdict()
    last = words.functions[-1] if words.functions else None
    if found["empty"]:
        if found["empty"] == "F" and not re.search(r"[ \t]M", statement.rest[match.end() :]):
            after = statement.rest[match.end() :].split()[:1]
            if after and (auto := explain_unknown("", after[0], ("AUTO",))):
                raise statement.error("VP001", auto, match.end())
            raise statement.error("VP001", "F without a number; write the feed rate, F AUTO or FMAX", begin)
        return  # older controls show what was asked for and not answered, up to M: nothing changes
    if found["m"]:
        if not is_count(found["m"]):
            raise statement.error("VP002", f"M{found['m'][:9]}... is not a function that is known here", begin)
        words.functions.append(MWord(int(found["m"]), statement.begin + begin + 1))
    elif found["comp"]:
        if words.compensation is not None:
            raise statement.error("VP004", f"{words.compensation} and {found['comp']} in one block", begin)
        words.compensation = found["comp"]
    elif found["feed"]:
        if words.rapid or words.automatic or "F" in words.values:
            raise statement.error("VP004", "F appears twice in the block", begin)
        words.rapid, words.automatic = found["feed"].endswith("MAX"), found["feed"].endswith("AUTO")
    elif found["rotation"]:
        if words.rotation is not None:
            raise statement.error("VP004", "DR appears twice in the block", begin)
        words.rotation = 1 if found["rotation"].endswith("+") else -1
    elif found["max"]:
        if last is None or last.number != 140:
            raise statement.error("VP006", "MB MAX belongs to M140", begin)
        words.functions[-1] = MWord(140, last.column, last.words, last.axes, to_limit=True)
    elif found["axis"]:
        if last is None or last.number not in (94, 138):
            raise statement.error(
                "VP001", f"{found['axis']} without a number; write {found['axis']} and its value", begin
            )
        if found["axis"] in last.axes:
            raise statement.error("VP004", f"{found['axis']} appears twice in the block", begin)
        words.functions[-1] = MWord(last.number, last.column, last.words, last.axes + found["axis"])
    else:
        name = found["name"]
        with statement.place_errors(match.start("value")):
            value = read_value(found["value"], numbers)
        if last is not None and name in _M_WORDS.get(last.number, ()) and name not in last.words:
            last.words[name] = value
            return
        if name in words.values or (name == "F" and (words.rapid or words.automatic)):
            raise statement.error("VP004", f"{name} appears twice in the block", begin)
        words.values[name], words.columns[name] = value, begin
