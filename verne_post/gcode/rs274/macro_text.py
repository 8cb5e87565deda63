"""Statements of custom macros as they are written: IF, WHILE, DO, END, GOTO; and the arguments of G65 and G66."""

import math
import re
from collections.abc import Collection, Iterator, Mapping
from itertools import pairwise
from typing import Final, Literal

from msgspec import Struct

from verne_post.base.long_text import Text, count_line, iterate_lines
from verne_post.base.suggestions import find_meant
from verne_post.gcode.block import read_setting, strip_comments
from verne_post.gcode.expressions import NO_OPENING_BRACKET, TAKE_BRACKET, Key, ValueReader, Values
from verne_post.gcode.program_error import CLOSE_IN_ORDER, ProgramError, write_words
from verne_post.gcode.text import decode_line
from verne_post.model.findings import Remedy

Kind = Literal["if", "while", "do", "end", "goto"]
#: What each statement does.
STATEMENTS: Final[Mapping[Kind, str]] = {
    "if": "IF [...] GOTO jumps; IF [...] THEN sets variables, or is followed by GOTO",
    "goto": "jumps to the block, whose number may be computed. The search goes from here to the end of the "
    "program, then "
    "from its beginning",
    **dict.fromkeys(("while", "do", "end"), "loops DO1 to DO9, which may be nested; `DO1` alone has no condition"),
}
KINDS: Final[Mapping[str, Kind]] = {
    "IF": "if",
    **dict.fromkeys(("WHILE", "WH"), "while"),
    **dict.fromkeys(("GOTO", "GO"), "goto"),
    "DO": "do",
    **dict.fromkeys(("END", "EN"), "end"),
}
#: Keywords and their short forms; what belongs to the words of a block is no statement.
_KEYWORD: Final = re.compile(rf"({'|'.join(sorted(KINDS, key=len, reverse=True))})(?=[\[#\d(]|$)")
#: GO1 X30.: a G code with the letter O, because nothing but a comment follows the number of a jump.
_LETTER_O: Final = re.compile(r"GO\d+[A-Z]")
_LABEL: Final = re.compile(r"\(*/?(?:N\d+)?\(*")
_OTHERS: Final = re.compile(r"(THEN|ELSE|ENDIF|POPEN|PCLOS|DPRNT|BPRNT|SETVN)\b")
#: END of a loop with a letter lost, another one in its place, or two in the wrong order.
_LIKE_END: Final = re.compile(
    rb"^[ \t]*(?:N\d+[ \t]*)?((?:E[ND]|ND|NED|EDN|[WRSD]ND|E[BHJM]D|EN[SERFCX])[ \t]*[1-3]|EN[1-3]D)(?![\w.])",
    re.MULTILINE | re.IGNORECASE,
)
#: Lines that may open or close a loop, and that may begin with a number.
_LOOP_LINE: Final = re.compile(
    rb"^[^\n]*?(?:(?:DO|END?|WH[^\n]*D0)[ \t]*[1-9]|WH[^\n]*\])[^\n]*$", re.MULTILINE | re.IGNORECASE
)
_LOOP: Final = re.compile(r"(?:(?:WH(?:ILE)?\[.*\])?(DO)|WH(?:ILE)?\[.*\](D0)|END?)([1-9])\(*|WH(?:ILE)?(\[.*\])\(*")
#: Letter -> local variable, in the first way to give arguments; in the second I, J, K stand up to ten times.
ARGUMENTS: Final = dict(
    zip(
        "ABCIJKDEFHMQRSTUVWXYZ",
        (1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 13, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26),
        strict=True,
    )
)
_REPEATED_LETTERS: Final = "IJK"
_MOST_SETS: Final = 10


_LETTERS: Final = re.compile("[A-Z]*")
_LONG_KEYWORDS: Final = ("WHILE", "GOTO", "END", "IF", "DO")
#: A word that may be a misspelt keyword, and such words of other languages.
_MISSPELT: Final = re.compile(r"[ \t]*(?:/[ \t]*)?(?:N\d+[ \t]*)?([A-Z]{3,9})[ \t]*(?=[\[#\d(]|$)", re.IGNORECASE)
#: A condition without IF or WHILE.
_BARE_CONDITION: Final = re.compile(
    r"[ \t]*(?:/[ \t]*)?(?:N\d+[ \t]*)?(\[.*\])[ \t]*(GOTO|THEN|DO)[ \t]*[\d#\[]", re.IGNORECASE
)
#: ENDI and END+1 for END1.
_NO_LOOP_NUMBER: Final = re.compile(
    r"[ \t]*+(?:N\d+[ \t]*+)?(?:WHILE.*\])?[ \t]*+((END|DO)(?:[IL]|[-+=]([1-9])))[ \t]*$", re.IGNORECASE
)
_OF_OTHERS: Final = re.compile("END(?:WHILE|REPEAT|DO|FOR|LOOP)", re.IGNORECASE)


class Statement(Struct, frozen=True):
    """A statement of a custom macro; its values are computed when they are asked for."""

    kind: Kind
    reader: ValueReader  #: At ``begin`` stands what follows the keyword.
    #: begin, column: The column is that of the keyword.
    begin: int
    column: int

    def start(self) -> None:
        """Reading begins after the keyword."""
        self.reader.at = self.begin

    def read_condition(self) -> bool:
        """The condition of IF or WHILE; reading goes on after it."""
        self.start()
        value = self.reader.read_bracket()
        return value != 0.0 and not math.isnan(value)

    def read_number(self, what: str) -> int:
        """The number of GOTO, after it nothing may follow."""
        reader, begin = self.reader, self.reader.at
        value = reader.read_value(what)
        self.check_end()
        if math.isnan(value) or value != round(value) or value < 0:
            found = "a variable without a value" if math.isnan(value) else f"{value:g}"
            raise reader.error("VP007", f"{what} {found}: the number of a block is whole and not negative", begin)
        return round(value)

    def pass_word(self, *words: str) -> bool:
        """Go past one of some words; False where none of them follows."""
        word = next((word for word in words if self.reader.characters.startswith(word, self.reader.at)), None)
        self.reader.at += len(word or "")
        return word is not None

    def refuse_misspelt(self, *words: str) -> None:
        """Refuse (VP001) a word that is a slip of one of some words."""
        reader = self.reader
        if reader.characters[reader.at : reader.at + 1] == "]":
            raise reader.error("VP001", NO_OPENING_BRACKET, reader.at, TAKE_BRACKET)
        match = _LETTERS.match(reader.characters, reader.at)
        word = "" if match is None else match[0]
        if not word.startswith(words) and (near := find_meant(word, words, slip_alone=True)):
            raise reader.error("VP001", f"{word}: no word of custom macros; did you mean {near}?", reader.at)

    def read_settings(self) -> Iterator[tuple[Key, float, int]]:
        """What follows THEN: variables that are set."""
        reader = self.reader
        while reader.at < len(reader.characters) and reader.characters[reader.at] != "(":
            if not self.pass_word("#"):
                raise reader.error(
                    "VP002", "after THEN only #1=... and GOTO are executed; write IF [...] GOTO", reader.at
                )
            yield read_setting(reader)

    def check_end(self) -> None:
        """Nothing but a comment may follow."""
        reader = self.reader
        if reader.at < len(reader.characters) and reader.characters[reader.at] != "(":
            raise reader.error("VP001", f"nothing may follow here: {reader.characters[reader.at :][:20]!r}", reader.at)


def read_statement(text: str, values: Values) -> Statement | None:
    """The statement of a line; None where it has words.

    Raises
    ------
    ProgramError
        VP002: a statement that is not executed.
    """
    characters, places, _comment = strip_comments(text)
    label = _LABEL.match(characters)
    at = 0 if label is None else label.end()
    other = _OTHERS.match(characters, at)
    if other is not None:
        instead = "write IF [...] GOTO" if other.group() in ("THEN", "ELSE", "ENDIF") else "take it out"
        raise ProgramError("VP002", f"{other.group()}: this macro statement is not executed; {instead}", places[at] + 1)
    keyword = _KEYWORD.match(characters, at)
    if keyword is None or _LETTER_O.match(characters, at):
        return None
    kind = KINDS[keyword.group(1)]
    return Statement(kind, ValueReader(characters, places, values), keyword.end(), places[at] + 1)


def explain_misspelt(text: str) -> ProgramError | None:
    """The error (VP001) of a line that begins with a misspelt keyword; None for other lines."""
    if (match := _BARE_CONDITION.match(text)) is not None:
        right = f"{'WHILE' if match[2].upper() == 'DO' else 'IF'} {match[1]}"
        edits = (Remedy(f"write {right}", right, misspelt=match[1]),)
        return ProgramError(
            "VP001", f"{right.split()[0]} is missing before the condition", match.start(1) + 1, edits=edits
        )
    if (match := _NO_LOOP_NUMBER.match(text)) is not None:
        right = f"{match[2]}{match[3] or 1}"
        what = "words have no sign and no =" if match[3] else "a letter in place of 1"
        return ProgramError("VP001", f"{match[1]}: {what}; did you mean {right}?", match.start(1) + 1)
    match = _MISSPELT.match(text)
    if match is None or match[1].upper() in KINDS:
        return None
    word = match[1]
    if _OF_OTHERS.fullmatch(word):
        message = f"{word}: no word of custom macros; a loop ends with END and the number of its DO, such as END1"
        return ProgramError("VP001", message, match.start(1) + 1)
    near = find_meant(word.upper(), _LONG_KEYWORDS, slip_alone=True, least=2)
    if not near:
        return None
    return ProgramError("VP001", f"{word}: no word of custom macros; did you mean {near}?", match.start(1) + 1)


def number_argument(letters: str) -> int:
    """The local variable of the last of the letters of a call; 0 for one that sets none, as P and L.

    Of I, J and K a new set begins where one does not follow the last.
    """
    number = ARGUMENTS.get(letters[-1:], 0)
    if letters[-1:] not in [*_REPEATED_LETTERS]:
        return number
    own = [one for one in letters if one in _REPEATED_LETTERS]
    return number + len(_REPEATED_LETTERS) * sum(after <= before for before, after in pairwise(own))


def read_arguments(reader: ValueReader) -> tuple[dict[str, float], dict[int, float]]:
    """What follows G65 or G66: P and L, and local variables by their numbers.

    Raises
    ------
    ProgramError
        For a letter that gives no argument, or stands too often.
    """
    calls: dict[str, float] = {}
    found: dict[int, float] = {}
    letters = ""
    while reader.at < len(reader.characters):
        at, letter = reader.at, reader.characters[reader.at]
        reader.at += 1
        if letter == "(":
            continue
        if letter == "O" or not letter.isalpha():
            raise reader.error("VP001", f"{letter!r} does not begin a word; expected a letter and a number", at)
        if letter not in ARGUMENTS and letter not in "PL":
            raise reader.error(
                "VP006", f"{letter!r} is no argument of a macro; arguments are A to Z except G, L, N, O, P", at
            )
        value = reader.read_word(letter)
        number = number_argument(letters + letter)
        if letter in _REPEATED_LETTERS and number >= ARGUMENTS["I"] + len(_REPEATED_LETTERS) * _MOST_SETS:
            raise reader.error("VP004", f"more than {_MOST_SETS} sets of I, J, K", at)
        if letter in letters and letter not in _REPEATED_LETTERS:
            raise reader.error("VP004", f"{letter} appears twice", at)
        letters += letter
        if letter in "PL":
            calls[letter] = value
        elif not math.isnan(value):
            found[number] = value  # of two that give one variable the last counts
    return calls, found


class Loops(Struct, frozen=True):
    """The loops of a text: line of DO -> line of END, and the other way round."""

    end: dict[int, int]
    begin: dict[int, int]

    def find_entered(self, line: int, target: int) -> int | None:
        """The line of a loop that a jump from a line would enter; None where it enters none."""
        return next((at for at, end in self.end.items() if at < target <= end and not at <= line <= end), None)


def find_loops(source: Text, programs: Collection[int]) -> Loops:
    """Pair DO and END of a text; ``programs`` are the lines where one begins.

    Raises
    ------
    ProgramError
        With its line: VP023, one without the other; VP001, D01 for DO1.
    """
    try:
        return _find_loops(source, programs)
    except ProgramError:
        for number, raw in enumerate(iterate_lines(source), 1):
            if (misspelt := explain_misspelt(decode_line(raw))) is not None:
                misspelt.line = number
                raise misspelt from None
        raise


def _find_loops(source: Text, programs: Collection[int]) -> Loops:
    loops, open_loops = Loops({}, {}), list[tuple[int, str]]()
    bare = (0, 0, "")  # line, column and text of the last WHILE without DO
    line, at, starts = 1, 0, sorted(programs)
    for match in _LOOP_LINE.finditer(source):
        before, line, at = line, line + source.count(b"\n", at, match.start()), match.start()
        if open_loops and any(before < start <= line for start in starts):
            break
        try:
            characters, places, _comment = strip_comments(decode_line(match.group()))
        except ProgramError:  # which is reported where it is read
            continue
        found = _LOOP.fullmatch(characters, _LABEL.match(characters).end())  # type: ignore[union-attr]
        if found is None:
            continue
        number, column, last = found[3], places[found.start()] + 1, found.end(3) if found[3] else found.end(4)
        written_word = decode_line(match.group())[column - 1 : places[last - 1] + 1]
        if found[4]:
            bare = line, column, written_word
            continue
        if found[2]:
            text = f"D0{number}: a zero in place of the letter O; did you mean DO{number}?"
            raise ProgramError("VP001", text, places[found.start(2)] + 1, line=line)
        if found[1]:
            open_loops.append((line, number))
        elif not open_loops or open_loops[-1][1] != number:
            text, edits = f"END{number} without the DO{number} that it would end", tuple[Remedy, ...]()
            if bare[0] > (open_loops[-1][0] if open_loops else 0):
                text = f"{bare[2]}: DO{number}, which END{number} of line {line} would end, is missing"
                line, column, right = bare[0], bare[1], f"{bare[2]} DO{number}"
                edits = (Remedy(f"write {right}", right, line=line, misspelt=bare[2]),)
            elif open_loops:
                begin, other = open_loops[-1]
                text += f"; DO{other} of line {begin} is open"
                edits = (Remedy(f"write END{other}", f"END{other}", line=line, misspelt=written_word),)
            raise ProgramError("VP023", text, column, line=line, edits=edits).advise(CLOSE_IN_ORDER)
        else:
            first, _number = open_loops.pop()
            loops.end[first], loops.begin[line] = line, first
    if open_loops:
        line, number = open_loops[-1]
        text = f"DO{number} is never ended; expected END{number}"
        slips = _LIKE_END.finditer(source)
        ends = [one for one in slips if source.count(b"\n", 0, one.start(1)) >= line and number.encode() in one[1]]
        if len(ends) != 1:
            raise ProgramError("VP023", text, line=line)
        wrong, at = ends[0][1].decode(), count_line(source, ends[0].start(1))
        edits = write_words(wrong, f"END{number}", line=at, is_choice=True)
        raise ProgramError("VP023", f"{text}; line {at} has {wrong}: write END{number} there", line=line, edits=edits)
    return loops


def find_block_numbers(source: Text) -> dict[str, int]:
    """The numbers of all blocks (N), and the last line of each."""
    return {number.decode(): line for number, line in _list_block_numbers(source, rb"\d+")}


def find_numbered_lines(source: Text, number: int) -> list[int]:
    """Lines whose block has a number (N)."""
    return [line for _number, line in _list_block_numbers(source, rb"%d(?![0-9.])" % number)]


def _list_block_numbers(source: Text, number: bytes) -> Iterator[tuple[bytes, int]]:
    line, at = 1, 0
    pattern = rb"^[ \t]*(?:/[0-9]?[ \t]*)?N[ \t]*0*(%b)" % number
    for match in re.finditer(pattern, source, re.MULTILINE | re.IGNORECASE):
        line, at = line + source.count(b"\n", at, match.start()), match.start()
        yield match[1], line
