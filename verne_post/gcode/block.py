"""One block read exactly: the reader for every line that is not plain, and the only one that reports errors.

Blanks may stand anywhere outside comments, letter case means nothing, a number is an optional sign,
digits and at most one point; there is no exponent.
"""

import math
import re
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

from msgspec import Struct, field

from verne_post.base.suggestions import MAY_BE_MEANT, drop_doubles, has_one_more
from verne_post.gcode.expressions import Key, ValueReader, Values, show_key
from verne_post.gcode.letters import FLOW
from verne_post.gcode.program_error import DOUBLE_EQUALS, At, ProgramError, write_meant, write_words
from verne_post.gcode.templates import read_by_template
from verne_post.model.findings import Remedy

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Block", "OWord", "read_block"]

_BLANKS: Final = " \t\r"
#: Lines whose characters are kept: loops read the same ones again and again.
_KEPT_LINES: Final = 4096
#: Letters that may start a word, in addition to N (first only), O (flow, first only) and # (settings).
WORD_LETTERS: Final = "ABCDEFGHIJKLMPQRSTUVWXYZ"
#: Words of polar coordinates: distance and angle.
POLAR: Final = "@^"
KEYWORDS: Final = tuple(FLOW)
#: Where one keyword begins another the longer comes first.
_KEYWORD: Final = re.compile(rf"(?:{'|'.join(sorted(KEYWORDS, key=len, reverse=True))})(?![A-Z])")
_OPERAND: Final = r"(?:#(?:\d+|<[^>]*>)|\[[^\[\]]*\]|\d++\.?\d*+|\.\d++)"
#: What stands between two operands; a sign that stands at the second alone may be of a word without its letter.
_OPERATOR: Final = r"[ \t]*(?:[*/]|(?<![ \t])[-+]|[-+](?=[ \t]))[ \t]*"
#: Words that no expression gives a number.
_CODE_BEFORE: Final = re.compile(r"[GMNT][ \t]*$", re.IGNORECASE)
#: An expression without its brackets, behind a letter or =.
_EXPRESSION: Final = re.compile(rf"(?<=[A-Za-z= \t])(?:[-+][ \t]*)?{_OPERAND}(?:{_OPERATOR}{_OPERAND})+")


#: ``0<name>`` and ``0100 endsub`` for o.
ZERO_FOR_O: Final = re.compile(rf"0(<[^<>]*>|\d+(?=(?:{'|'.join(KEYWORDS)})))", re.IGNORECASE)
#: Keys beside those of words of places.
_KEYS_OF_TWICE: Final = {"A": "Z", "C": "X", "X": "Z", "Z": "X", "I": "JK", "J": "KI", "K": "JI"}
#: X36/ for X36.: the keys are side by side. Codes have no point, and X10/5 may be a quotient.
_SLASH_FOR_POINT: Final = re.compile(r"(?<![A-Z#<])[A-FH-LP-Z][-+]?\d+/(?!\d)")
#: Codes that often stand alone in a block, or beside few words.
_NUMBERS_OF_M: Final = ("1", "2", "3", "4", "5", "6", "7", "8", "9", "30")
#: What follows the o of ``oh<ole>``.
_SPLIT_LABEL: Final = re.compile(r"([A-Z]{1,2})<([A-Z_][A-Z\d_]*)>", re.IGNORECASE)
#: A label without its o.
_LABEL_ALONE: Final = re.compile(rf"(<[^<>]+>)(?=(?:{'|'.join(KEYWORDS)})\b)", re.IGNORECASE)
#: N5 for M5, and a name behind 3, which has the # of many keyboards, or $, whose key is beside.
_M_BEHIND_NUMBER: Final = re.compile(r"N0?(\d{1,2})(?![\d.])", re.IGNORECASE)
_NAME_WITHOUT_HASH: Final = re.compile(r"[3$](<[^<>]+>)")
_CODES_WITH_POINT: Final = ("5.1", "05.1", "43.4", "43.5", "53.1", "54.1", "54.2", "68.2", "68.3")
_FEED_OR_PLACE: Final = re.compile(r"(?<![A-Z<_])[ABCFXYZ](?=[-+.\d#\[])")
_BARE_NUMBER: Final = re.compile(r"[-+]?[\d.]*")
#: Statements of custom macros, before which no word stands but N.
_STATEMENT_BEHIND: Final = re.compile(r"(?:WHILE|IF)\[|GOTO\d|END\d|#\d+=")
#: A name that is set, without its #.
_BARE_NAME: Final = re.compile(r"<[^<>=]+>(?==)")


class OWord(Struct, frozen=True):
    """An O word: its label, its keyword (None: a bare number), and its values, read when they are asked for."""

    label: str | None
    keyword: str | None
    reader: ValueReader
    begin: int  # of the values
    label_at: int

    def resolve_label(self) -> str:
        """The label; a computed one is read now.

        A file that is searched for labels must not compute any: there ``label`` None is what counts.
        """
        if self.label is not None:
            return self.label
        self.reader.at = self.label_at
        value = self.reader.read_value("O")
        return _label_of_number(value, self.reader, self.label_at)

    def read_condition(self) -> float:
        """The one bracket of if, elseif, while, repeat."""
        self.reader.at = self.begin
        value = self.reader.read_bracket(f"o{self.label or ''} {self.keyword}")
        self._check_end()
        return value

    def read_arguments(self) -> list[float]:
        """The brackets of call; comments may stand between them."""
        self.reader.at = self.begin
        values = []
        while self._has_more():
            values.append(self.reader.read_bracket(f"o{self.label or ''} {self.keyword}"))
        return values

    def read_return_value(self) -> float | None:
        """The one bracket of return and endsub, or None; it directly follows the keyword."""
        reader = self.reader
        reader.at = self.begin
        value = reader.read_bracket() if reader.characters[reader.at : reader.at + 1] == "[" else None
        self._check_end()
        return value

    def check_bare(self) -> None:
        """Nothing may follow the keyword."""
        self.reader.at = self.begin
        self._check_end()

    def _has_more(self) -> bool:
        """Pass comments; True where something else follows."""
        reader = self.reader
        while reader.characters[reader.at : reader.at + 1] == "(":
            reader.at += 1
        return reader.at < len(reader.characters)

    def _check_end(self) -> None:
        reader = self.reader
        if self._has_more():
            value = "; a value comes before them" if reader.characters[reader.at] == "[" else ""
            shown_words = f"o{self.label or ''} {self.keyword or ''}".rstrip()
            raise reader.error("VP001", f"only comments may follow {shown_words}{value}", reader.at)


class Block(At):
    """The words of one block.

    ``codes`` are G and M words as ("G", number, column); ``words`` maps other letters to numbers; ``settings`` are the
    parameters that the block sets, with their columns. A column below 0 is minus the number of the word in its line:
    see :func:`~verne_post.gcode.templates.find_word_columns`. ``polar`` are the words ``@`` and ``^``, once X and Y
    stand in their place. ``macro`` is a statement of a custom macro, which decides where the program goes on;
    ``corner`` is the letter and the size of a corner at the end of a move (``,R5``);
    ``arguments`` are P and L, and the local variables, of a macro that the block calls.
    """

    codes: list[tuple[str, float, int]] = field(default_factory=list)
    words: dict[str, float] = field(default_factory=dict)
    settings: list[tuple[Key, float, int]] = field(default_factory=list)
    comment: str | None = None
    polar: dict[str, float] = field(default_factory=dict)
    o: OWord | None = None
    macro: Any = None  # Statement
    corner: tuple[str, float] | None = None
    arguments: "tuple[dict[str, float], dict[int, float]] | None" = None

    def find_code(self, name: str) -> int | None:
        """The column of a code, as G43.4; None where the block does not have it."""
        return next((column for letter, number, column in self.codes if f"{letter}{number:g}" == name), None)


def build_block_of_words(letters: str, values: list[float], line: int) -> Block | None:
    """The block of a line of plain words; None where only the exact reader can read it."""
    block = Block(line)
    codes, words, columns = block.codes, block.words, block.columns
    has_number = letters.startswith("N") and values[0] >= 0
    for at, (letter, value) in enumerate(zip(letters[has_number:], values[has_number:], strict=True), 1):
        if letter in "GM":
            codes.append((letter, value, -at))
        elif letter in words or letter in "NO":
            return None
        else:
            words[letter], columns[letter] = value, -at
    return block


def read_block(text: str, line: int, values: Values | None = None) -> Block:
    """Read one line.

    Parameters
    ----------
    text : str
        The line without its line end.
    line : int
        1-based line number.
    values : Values, optional
        Parameters; without them ``#`` is refused.

    Raises
    ------
    ProgramError
        With the column of the first character that does not fit.
    """
    if values is not None and (fast := read_by_template(text, values)) is not None:
        return Block(line, fast.columns, fast.codes, fast.words, fast.settings)
    return read_exactly(text, line, values)


def read_exactly(text: str, line: int, values: Values | None = None) -> Block:
    """As :func:`read_block`, word by word: the only reader that reports errors."""
    try:
        return _read_words(text, line, values)
    except ProgramError as error:
        raise (_find_missing_brackets(text, error) or error) from None


def _read_words(text: str, line: int, values: Values | None) -> Block:
    block = Block(line)
    characters, places, block.comment = strip_comments(text)
    reader = ValueReader(characters, places, values)
    first, slash, has_number = True, False, False
    while reader.at < len(characters):
        at = reader.at
        character = characters[at]
        reader.at += 1
        if character == "(":
            continue
        if character == "/" and first and not slash:
            slash = True
            continue
        if character == "N" and first:
            if characters[at + 1 : at + 2] in ("#", "["):  # lines are searched for O words without computing anything
                raise reader.error("VP001", "N needs a number, not a value to compute", at + 1)
            number = reader.read_word("N")
            if number < 0:
                raise reader.error("VP007", f"N{number:g}: a block number is not negative", at)
            has_number, first = True, False
            continue
        if character == "O" and (first or has_number):
            block.o = _read_o_word(reader)
            return block
        elif character in WORD_LETTERS or character in POLAR:
            number = reader.read_word(character)
            if math.isnan(number):  # a vacant variable of Fanuc
                first = has_number = False
                continue
            if character in "GM":
                block.codes.append((character, number, reader.find_column(at)))
            elif character in block.words:
                edits = _list_other_words(characters, character, line)
                raise reader.error("VP004", f"{character} appears twice in the block", at, edits)
            else:
                block.words[character] = number
                block.columns[character] = reader.find_column(at)
        elif character == "#" and values is not None:
            block.settings.append(read_setting(reader))
        else:
            if (match := ZERO_FOR_O.match(characters, at)) and (first or has_number):
                error = refuse_zero(match[1])
                error.column = reader.find_column(at)
                raise error
            if (match := _LABEL_ALONE.match(characters, at)) and (first or has_number):
                right = f"o{match[1]}".lower()
                raise reader.error(
                    "VP001", f"{match[1].lower()}: the o is missing before it; did you mean {right}?", at
                )
            begin = at - (character == "<")
            if (match := _NAME_WITHOUT_HASH.match(characters, begin)) and not characters[begin - 1 : begin].isdigit():
                wrong, right = match[0].lower(), f"#{match[1].lower()}"
                what = "the digit on the key of the #" if wrong[0] == "3" else "the key beside that of the #"
                raise reader.error("VP001", f"{wrong}: {what}; did you mean {right}?", begin)
            text, edits = _describe_strange(character, reader, at, first=first), tuple[Remedy, ...]()
            if character in "0123456789+-.":
                text, edits = _describe_number(reader, at, first=first, has_number=has_number)
            if (match := _M_BEHIND_NUMBER.match(characters, at)) and match[1] in _NUMBERS_OF_M:  # keys side by side
                right = f"M{match[1]}"
                text += f"; write {right} if that is meant"
                edits = write_words(match[0], right, is_choice=True)
            if character == "/" and (match := _SLASH_FOR_POINT.search(characters, 0, at + 2)):
                text = f"{match[0]}: a / in place of the point; did you mean {match[0][:-1]}.?"
                raise reader.error("VP001", text, match.start())
            raise reader.error("VP001", text, at, edits)
        first = has_number = False
    return block


def _list_other_words(characters: str, letter: str, line: int) -> tuple[Remedy, ...]:
    """The edits of a block in which a word stands twice: one of both may be another one whose key is beside."""
    words = [one[0] for one in re.finditer(rf"(?<![A-Z#<]){letter}[-+]?[\d.]+", characters)]
    nears = [one for one in _KEYS_OF_TWICE.get(letter, "") if re.search(rf"{one}[-+.\d#\[]", characters) is None]
    rights = {one: [f"{near}{one[1:]}" for near in nears] for one in words}
    if words and letter in "BHJM" and characters.startswith(words[0]) and words[0][1:].isdigit():
        rights[words[0]] = [f"N{words[0][1:]}"]
    edits = (write_words(wrong, *some, line=line, is_choice=True) for wrong, some in rights.items())
    return sum(edits, ()) if len(rights) == len(words) else ()


def read_setting(reader: ValueReader) -> tuple[Key, float, int]:
    """What follows the ``#`` of a parameter that is set: its key, the value, the column of the ``#``."""
    at = reader.at - 1
    key = reader.read_key()
    if reader.characters[reader.at : reader.at + 1] != "=":
        if (behind := reader.find_number_behind_blank(at + 1)) or re.match(r"[\d.#\[]", reader.characters[reader.at :]):
            behind = behind or reader.at
            name = show_key(key) if behind == reader.at else reader.characters[at:behind]
            edits = (Remedy("write =", "=", way="here"),)
            raise reader.error("VP001", f"{name}: an = is missing after it, before its value", behind, edits)
        raise reader.error("VP001", f"{show_key(key)}: expected '=' and a value, or a letter before the '#'", at)
    if reader.characters.startswith("==", reader.at):
        raise reader.error("VP001", DOUBLE_EQUALS, reader.at)
    reader.at += 1
    return key, reader.read_assigned(f"{show_key(key)}="), reader.find_column(at)


def _read_o_word(reader: ValueReader) -> OWord:
    """What follows an O that begins a block."""
    characters, begin = reader.characters, reader.at
    label: str | None = None
    if characters[begin : begin + 1] == "<":
        label = f"<{reader.read_key()}>"
    elif characters[begin : begin + 1] in ("#", "["):
        reader.values, values = None, reader.values  # only looked over: computed where it is needed
        _skip_value(reader)
        reader.values = values
    elif (match := _SPLIT_LABEL.match(characters, begin)) is not None:
        wrong, right = f"o{match[0]}".lower(), f"o<{match[1]}{match[2]}>".lower()
        raise reader.error("VP001", f"{wrong}: a letter before the <; did you mean {right}?", begin - 1)
    else:
        label = _label_of_number(reader.read_word("O"), reader, begin)
    keyword = _KEYWORD.match(characters, reader.at)
    if keyword is None:
        o = OWord(label, None, reader, reader.at, begin)
        if reader.at < len(characters) and characters[reader.at] != "(":
            word = re.split(r"\W", characters[reader.at :])[0]
            if re.fullmatch(r"O(?=O*\d)[\dO]+", word) and label is not None and label.isdigit():
                wrong = characters[begin - 1 : reader.at] + word
                right = f"O{wrong[1:].replace('O', '0')}"
                message = f"{wrong}: the letter O in a number; did you mean {right}?"
                raise reader.error("VP001", message, begin - 1)
            edits = write_meant(word.lower(), [one.lower() for one in KEYWORDS]) or _write_short(word.lower())
            text = f"o{label or ''}: expected {', '.join(KEYWORDS).lower()}, or nothing after a program number"
            if edits:
                text = f"{word.lower()}: no word after o{label or ''}; did you mean {edits[0].value}?"
            elif word.isalpha() and label is not None and label.isdigit():
                text += (
                    ". These are words of RS274/NGC (LinuxCNC); a title is written in parentheses, "
                    f"as in O{label} ({word})"
                )
            raise reader.error("VP023", text, reader.at, edits)
        o.check_bare()
        return o
    return OWord(label, keyword.group().lower(), reader, keyword.end(), begin)


def _write_short(word: str) -> tuple[Remedy, ...]:
    """The edit of a word of few letters, as ``o`` and ``ddo`` for do, that one letter tells from one keyword alone."""
    names = [one.lower() for one in KEYWORDS]
    near = [one for one in names if has_one_more(one, word)]
    near += [one for one in names if one in drop_doubles(word, "a-z")]
    return (Remedy(f"write {near[0]}", near[0], misspelt=word),) if len(near) == 1 else ()


def refuse_zero(label: str) -> ProgramError:
    """The error of an O word that begins with the digit 0."""
    wrong, right = f"0{label.lower()}", f"o{label.lower()}"
    text = f"{wrong}: the digit 0 in place of the letter o; did you mean {right}?"
    return ProgramError("VP023", text, edits=(Remedy(f"write {right}", right, misspelt=wrong),))


def _skip_value(reader: ValueReader) -> None:
    """Go past a value without reading it: a ``#`` and what it takes, or a bracket."""
    characters, depth = reader.characters, 0
    while reader.at < len(characters):
        character = characters[reader.at]
        if character == "[":
            depth += 1
        elif character == "]":
            depth -= 1
        elif depth == 0 and character not in "#0123456789":
            if character != "<" or characters[reader.at - 1] != "#":
                return
            reader.read_key()
            return
        reader.at += 1
        if depth == 0 and character == "]":
            return


def _label_of_number(value: float, reader: ValueReader, at: int) -> str:
    if value != round(value) or value < 0:
        raise reader.error("VP023", f"O{value:g}: a number after O is whole and not negative", at)
    return str(round(value))


def _find_missing_brackets(text: str, error: ProgramError) -> ProgramError | None:
    """The error of an expression without brackets, at an operator of which another one is; None for other errors."""
    at = (error.column or 0) - 1
    if error.code != "VP001" or text[at : at + 1] not in ("+", "-", "*", "/"):
        return None
    found = next((one for one in _EXPRESSION.finditer(text) if one.start() < at < one.end()), None)
    if (
        found is None
        or _CODE_BEFORE.search(text, 0, found.start())
        or text.count("[", found.start(), at) > text.count("]", found.start(), at)
    ):
        return None
    if parts := re.fullmatch(r"(\d+)(-)(\d+\.?\d*)", found[0]):  # the sign may be a place too far
        rights = [f"-{parts[1]}{parts[3]}", f"[{found[0]}]"]
        message = f"{found[0]}: a sign after a digit; write {rights[0]}, or {rights[1]} for an expression"
        return ProgramError("VP001", message, found.start() + 1, edits=write_words(found[0], *rights))
    right = f"[{found[0]}]"
    is_closed = text[found.end() : found.end() + 1] == "]" and text.count("[") < text.count("]")
    wrong = f"{found[0]}]" if is_closed else found[0]
    message = f"{wrong}: an expression is written in brackets; did you mean {right}?"
    if re.fullmatch(r"[-+]?\d+/\d+", wrong):  # the key of the / is beside that of the point
        number = wrong.replace("/", ".")
        text = f"{wrong}: an expression is written in brackets; write {number} or {right}"
        return ProgramError("VP001", text, found.start() + 1, edits=write_words(wrong, number, right))
    edits = (Remedy(f"write {right}", right, misspelt=wrong),)
    return ProgramError("VP001", message, found.start() + 1, edits=edits)


def _list_letters_behind_value(code: str, at: int, number: str) -> str:
    """Letters that a number may have lost; behind an expression or a named parameter those of words not yet there."""
    if code[at - 1 : at] not in ("]", ">"):
        return "XYZ"
    letters = re.sub("|".join(_FEED_OR_PLACE.findall(code)) or "$", "", "FXYZ")
    is_feed = number[0] not in "+-" and not _FEED_OR_PLACE.search(code, at)
    return (letters if is_feed else letters.removeprefix("F")) or "XYZ"


def _describe_number(reader: ValueReader, at: int, *, first: bool, has_number: bool) -> tuple[str, tuple[Remedy, ...]]:
    """The message about a number where a word begins, and the edits of which each may be meant."""
    number = _BARE_NUMBER.match(reader.characters, at)[0]  # type: ignore[index]
    if not any(sign.isdigit() for sign in number):
        return f"{number}: a sign without a number; write the number, or brackets around an expression: X[5+#1]", ()
    start = f"{number}: a number without a letter before it"
    if (first or has_number) and number in _CODES_WITH_POINT:
        return f"{start}; did you mean G{number}?", ()
    if first and number.isdigit() and reader.characters[at + len(number) :].startswith("="):
        if number[0] == "3" and len(number) > 1:  # whose key has the # of many keyboards
            words = [f"#{number[1:]}", f"#{number}"]
            return f"{start}; {' or '.join(words)}{MAY_BE_MEANT}", write_words(number, *words)
        return f"{start}; did you mean #{number}?", ()
    code = "G" if len(number) <= len("99") else "S"
    code += "M" if number in _NUMBERS_OF_M else ""
    letters = _list_letters_behind_value(reader.characters, at, number)
    if number.isdigit() and (first or has_number):
        is_statement = _STATEMENT_BEHIND.match(reader.characters, at + len(number)) is not None
        if first and is_statement:
            return f"{start}; did you mean N{number}?", ()
        letters = f"N{code}" if first else code
    words = [f"{letter}{number}" for letter in letters]
    *some, last = words
    such = f"{', '.join(some)} or {last}" if some else last
    return f"{start}; write its letter, such as {such}", write_words(number, *words, is_choice=True)


def _describe_strange(character: str, reader: ValueReader, at: int, *, first: bool) -> str:
    if character == "N":
        return "N must be the first word of a block"
    if character == "O":
        return "the letter O must be the first word of a block; write 0 if the digit is meant"
    if character in "#[":
        return f"'{character}' without a letter before it"
    if character == "$":
        return "'$': this machine has one spindle, numbers of spindles mean nothing here"
    if first and (name := _BARE_NAME.match(reader.characters, at)):
        return f"{name[0]}: a name without # before it; did you mean #{name[0]}?"
    if character == "/" and not first:
        return "'/' may only be the first character of a block"
    if character == ")":
        return "')' without a comment that it would end"
    if character == "%":
        if reader.characters == "%":
            return "% stands in the first line and below the last block; take it out"
        return "'%' must be alone on its line"
    return f"{character!r} does not begin a word; expected a letter and a number"


@lru_cache(maxsize=_KEPT_LINES)
def strip_comments(text: str) -> tuple[str, "Sequence[int]", str | None]:
    """The line in upper case without blanks, comments as ``(``; the place of each character and the end; the comment.

    Only the last comment counts, and only one in parentheses can be a message.
    """
    if "(" not in text and ";" not in text:
        if not any(blank in text for blank in _BLANKS):
            return raise_case(text), range(len(text) + 1), None
        places = [at for at, character in enumerate(text) if character not in _BLANKS]
        return raise_case("".join([text[at] for at in places])), [*places, len(text) - text.endswith("\r")], None
    kept_parts: list[str] = []
    places, comment, at = [], None, 0
    while at < len(text):
        character = text[at]
        if character in "(;":
            last, end = _read_comment(text, at)
            if character == "(":
                comment = last
            kept_parts.append("(")
            places.append(at)
            at = end
            continue
        if character not in _BLANKS:
            kept_parts.append(character)
            places.append(at)
        at += 1
    return raise_case("".join(kept_parts)), [*places, len(text) - text.endswith("\r")], comment


def raise_case(text: str) -> str:
    """Upper case, character by character: some letters of other alphabets would become two."""
    return text.upper() if text.isascii() else "".join(c.upper() if c.isascii() else c for c in text)


def _read_comment(text: str, at: int) -> tuple[str, int]:
    """Text of the comment that begins at ``at``, and where reading goes on."""
    if text[at] == ";":
        return text[at + 1 :].rstrip("\r"), len(text)
    for end in range(at + 1, len(text)):
        if text[end] == "(":
            raise ProgramError(
                "VP001", f"'(' inside the comment that begins in column {at + 1}: comments do not nest", end + 1
            )
        if text[end] == ")":
            return text[at + 1 : end], end + 1
    comment = text[at:].rstrip()
    edits = (Remedy(f"write {comment})", f"{comment})", misspelt=comment),)
    raise ProgramError("VP001", "the comment is not closed on its line; expected ')'", at + 1, edits=edits)
