"""A block of a Siemens program -> its words: addresses with values, G functions, calls; variables are set here."""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Final

from msgspec import Struct, field

from verne_post.base.numbers import is_count
from verne_post.base.suggestions import (
    LETTERS_OF_FUNCTIONS,
    drop_doubles,
    find_correction,
    find_meant,
    list_near_numbers,
    name_near_numbers,
    name_numbers,
    suggest,
)
from verne_post.gcode.codes import REMAP_GIVES
from verne_post.gcode.mistyped import MEANT_CHARACTERS, OF_ALL_MOVES, explain_unknown
from verne_post.gcode.program_error import DOUBLE_EQUALS, GIVE_FILE, ProgramError
from verne_post.gcode.siemens.cursor import Cursor
from verne_post.gcode.siemens.slips import (
    HEADS,
    explain_blanks,
    explain_equals,
    explain_function,
    explain_glued,
    explain_moved_blank,
    explain_signed_count,
    find_letter_of_digit,
    find_lost_bracket,
    find_radius,
    propose_feed,
    propose_key_beside,
    refuse_l,
    refuse_lost_equals,
    refuse_no_value,
    refuse_no_word,
    refuse_r,
    refuse_remark,
)
from verne_post.gcode.siemens.values import Value, read_indices, read_number, read_value
from verne_post.gcode.siemens.variables import Variables, read_r_number, refuse_leftover
from verne_post.gcode.siemens.vocabulary import (
    ADDRESSES,
    CYCLES,
    FRAME_FUNCTIONS,
    GROUP_OF,
    NO_EFFECT,
    REFUSED_WORDS,
    STATEMENTS,
    TYPES,
    VALUE_MODES,
    explain_refusal,
)
from verne_post.model.findings import Remedy
from verne_post.model.option_checks import CODE

#: Words whose values may be meant otherwise than G90 and G91 say.
MODAL_ADDRESSES: Final = (*"XYZABCUVWIJK", "I1", "J1", "K1", "AP", "RP", "SPOS")
_LETTER_NUMBER: Final = re.compile(r"[A-Za-z][ \t]*+(?:[+-][ \t]*+)?(?:[0-9]|\.[0-9])")
#: AC and its value without parentheses.
_MODE_AND_NUMBER: Final = re.compile(
    r"(ACP|ACN|AC|IC|DC)(?![A-Z_])[ \t]*([-+]?(?:\d+\.?\d*|\.\d+)(?![\w.]))?", re.IGNORECASE
)
#: The numbers of G functions but for further work offsets and the pole, which are near to too many.
_COMMON_CODES: Final = [
    name[1:] for name in (*GROUP_OF, *NO_EFFECT) if re.fullmatch(r"G(?!11[0-2]|5(?:0[1-9]|[1-9]\d)$)\d+", name)
]
#: A G function with a blank in its number.
_DIVIDED_CODE: Final = re.compile(r"G(\d+)[ \t]+(\d+)(?![\w.])", re.IGNORECASE)
#: A G function with a point in its number, which other controls have.
_POINTED_CODE: Final = re.compile(r"G\d++\.\d++", re.IGNORECASE)
#: An address, a sign and a name.
_SIGNED_NAME: Final = re.compile(r"([A-Za-z]\w*)[-+]([A-Za-z_$]\w*)")
#: A text after two quotes.
_QUOTED_TWICE: Final = re.compile(r'""[^"\s]+"')
_SIGNED_NUMBER: Final = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?![\w.])")
#: What stands behind FOR.
_COUNTS: Final = re.compile(r"[ \t]*[A-Z_]\w*[ \t]*=.*\bTO\b", re.IGNORECASE)
#: A letter and a number that make one name: a G function of a group, or a subprogram.
_CODE: Final = re.compile(r"([GML])[ \t]*([0-9]+)(?![0-9.])", re.IGNORECASE)
#: Names of subprograms that may stand alone: a letter and a number are a word.
_SUBPROGRAM: Final = re.compile(r"(?![A-Z][0-9]+$)[A-Z_][A-Z0-9_]+$")
_TEXTS: Final = ("T", "T1")
#: Where a subprogram is looked for.
_WHERE: Final = "in the folder of the program or a --subroutine-path"
#: Codes that a misspelt word may be taken for.
_PLAIN_CODES: Final = tuple(code for code in GROUP_OF if code not in OF_ALL_MOVES)


class Word(Struct, frozen=True):
    """An address and its value; ``mode`` is AC, IC, DC, ACP, ACN, or empty."""

    name: str
    value: float
    column: int
    mode: str = ""
    text: str | None = None

    def error(self, code: str, message: str) -> ProgramError:
        """An error at this word."""
        return ProgramError(code, message, self.column)


class Argument(Struct, frozen=True):
    """What stands between two commas of a call, unread; empty where nothing does."""

    text: str
    column: int

    def make_cursor(self) -> Cursor:
        """A cursor whose columns are those of the line."""
        return Cursor(" " * (self.column - 1) + self.text, self.column - 1)


#: Cycles of two digits are too near to each other: CYCLE97 cuts threads on lathes, CYCLE79 mills a polygon.
_LONG_NUMBER: Final = re.compile(r"CYCLE\d{3,}")
#: But machining has no cycles of these: the digits of one changed places, or CYCLE800 lacks its last 0.
_SLIP_OF_CYCLE: Final = re.compile(r"CYCLE(?:[1-5]\d|80)")
_MEANS_NOTHING: Final = "no meaning in this language; did you mean"
_LIKE_DIGITS: Final = str.maketrans("OILZSB", "011258")


class Call(Struct, frozen=True):
    """A name with arguments in brackets, or a subprogram without any; ``line`` is that of its MCALL."""

    name: str
    arguments: tuple[Argument, ...] | None
    column: int
    line: int | None = None


class Words(Struct):
    """The words of one block."""

    line: int
    words: dict[str, Word] = field(default_factory=dict)
    groups: dict[str, tuple[str, int]] = field(default_factory=dict)
    m: list[tuple[int, int]] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)
    no_effect: list[tuple[str, int]] = field(default_factory=list)
    user_names: list[str] = field(default_factory=list)  # names that [remap] gives a meaning
    counts_turns: str = ""  # FGROUP that names rotary axes beside others
    modal_call: int | None = None  # column of MCALL
    used_words: set[str] = field(default_factory=set)

    def take(self, name: str) -> Word | None:
        """A word, which then counts as used."""
        word = self.words.get(name)
        if word is not None:
            self.used_words.add(name)
        return word

    def find_code(self, group: str) -> str | None:
        """The G function of a group."""
        found = self.groups.get(group)
        return None if found is None else found[0]

    def find_column(self, group: str) -> int | None:
        """Where it stands."""
        found = self.groups.get(group)
        return None if found is None else found[1]

    @property
    def is_empty(self) -> bool:
        """True where nothing was programmed but variables."""
        names = self.calls or self.user_names or self.no_effect
        return not (self.words or self.groups or self.m or names or self.modal_call)


class WordReader:
    """Reads blocks; knows the variables, which names are subprograms, and which have a meaning by [remap]."""

    def __init__(
        self, variables: Variables, is_subprogram: Callable[[str], bool], user_names: Mapping[str, str]
    ) -> None:
        self.variables, self.is_subprogram, self.user_names = variables, is_subprogram, user_names
        #: The names of subprograms, and which are labels; the flow of a program sets both.
        self.list_subprograms: Callable[[], Iterable[str]] = tuple
        self.is_label: Callable[[str], bool] = lambda _name: False
        self.motion = ""  #: In force before the block.
        self.declared_names: set[str] = set()  #: By EXTERN.
        self._never_set: set[int] = set()  #: R parameters that only a word without its value has named.

    def read(self, cursor: Cursor, line: int) -> Words:
        """Read the rest of a line. ProgramError: With the column of what does not fit, or is not executed."""
        words = Words(line)
        while not cursor.is_at_end:
            self._read_word(cursor, words)
        return words

    def _read_word(self, cursor: Cursor, words: Words) -> None:
        at = cursor.at
        name = cursor.name()
        if name is None:
            raise refuse_no_word(cursor, at, self.variables.is_known)
        following = cursor.skip()
        if cursor.text.startswith("==", cursor.at):
            raise cursor.error("VP001", DOUBLE_EQUALS)
        if following == "=":
            self._read_assignment(name, cursor, words, at)
        elif following == "[":
            self._read_indexed(name, cursor, words, at)
        elif following == "(":
            self._read_call(name, cursor, words, at)
        elif following and (lost_bracket := find_lost_bracket(cursor, at, self.is_subprogram)) is not None:
            raise lost_bracket
        else:
            self._read_bare(name, cursor, words, at)

    # --- NAME=value -----------------------------------------------------------------------------------

    def _read_assignment(self, name: str, cursor: Cursor, words: Words, at: int) -> None:
        if name == "R" and (radius := find_radius(cursor, at, self._is_set, self.motion)) is not None:
            raise radius
        if self.variables.is_known(name):
            self.variables.assign(name, cursor, at)
            return
        if (
            name[0] in "GMN"
            and name[1:].isdigit()
            and (error := explain_equals(cursor, cursor.at, self.variables.is_known)) is not None
        ):
            raise error
        cursor.expect("=", f"after {name}")
        refuse_no_value(cursor, name, at)
        if name in NO_EFFECT:
            read_value(cursor, self.variables)
            words.no_effect.append((name, at + 1))
            return
        number = name[1:]
        if name[0] in "SM" and number.isdigit() and name not in ("S1", "M1"):
            raise cursor.error("VP002", f"{name}=: spindle {number}; there is one spindle", at)
        if name not in ADDRESSES:
            if message := self.explain_moved_blank(cursor.text, at) or explain_glued(
                name, cursor.text, at, self.variables.is_known
            ):
                raise cursor.error("VP001", message, at)
            if explain_refusal(name) is None and (len(name) == 1 or not name[1:].isdigit()):
                written_name = cursor.text[at : at + len(name)]
                digits = written_name[1:].translate(MEANT_CHARACTERS)
                if name[0] == "R" and digits.isdecimal():
                    text = f"{written_name}: a letter in the number; did you mean {written_name[0]}{digits}?"
                    raise cursor.error("VP001", text, at)
                near = suggest(name, *({*scope} for scope in reversed(self.variables.scopes)), ADDRESSES)
                text = f"{name}: not defined (DEF), and no address of this language{near}"
                raise cursor.error("VP002", text, at)
            for near in drop_doubles(name, "0-9"):
                if near in ADDRESSES:
                    raise cursor.error("VP001", f"{name}: a digit is there twice; did you mean {near}?", at)
            raise self._make_unknown_error(name, cursor, at)
        self._add(words, self._read_address(name, cursor, at), cursor, at)

    def _read_address(self, name: str, cursor: Cursor, at: int) -> Word:
        """The value of an address after ``=``."""
        mode = cursor.peek_name()
        if mode is not None and mode in VALUE_MODES and name in MODAL_ADDRESSES:
            begin = cursor.at
            cursor.name()
            if cursor.take("("):
                value = read_number(cursor, self.variables)
                cursor.expect(")", f"after the value of {mode}")
                return Word(name, value, at + 1, mode)
            cursor.at = begin
        mode_and_number = _MODE_AND_NUMBER.match(cursor.text, cursor.at) if name in MODAL_ADDRESSES else None
        if mode_and_number is not None and self.variables.find(mode or "") is None:
            written_word, mode, number = mode_and_number.group(0, 1, 2)
            right = f"{mode}({number or '...'})"
            edits = (Remedy(f"write {right}", right, misspelt=written_word),) if number else ()
            text = f"{mode}: its value stands in parentheses; write {name}={right}"
            raise cursor.error("VP001", text, cursor.at, edits)
        tool = cursor.peek_name() if name in _TEXTS else None
        begin = cursor.at
        try:
            value_or_text = read_value(cursor, self.variables)
        except ProgramError as error:
            if tool is None or error.code != "VP025" or error.column != begin + 1:
                raise
            end = begin + len(tool)
            end += cursor.text[end : end + 1] == '"'
            right_word = f'{name}="{cursor.text[begin : begin + len(tool)]}"'
            text = (
                f"{cursor.text[at:end]}: the name of a tool is written in quotation marks; did you mean {right_word}?"
            )
            raise cursor.error("VP001", text, at) from None
        if isinstance(value_or_text, str):
            if name not in _TEXTS:
                raise cursor.error("VP007", f"{name}= needs a number, not a text", at)
            if not value_or_text and (twice := _QUOTED_TWICE.match(cursor.text, begin)) is not None:
                text = f"{twice[0]}: a quote too many; did you mean {twice[0][1:]}?"
                raise cursor.error("VP001", text, begin)
            return Word(name, 0.0, at + 1, text=value_or_text)
        return Word(name, value_or_text, at + 1)

    def _add(self, words: Words, word: Word, cursor: Cursor, at: int) -> None:
        name = {"S1": "S", "T1": "T", "M1": "M"}.get(word.name, word.name)
        if name in ("M", "G", "L"):
            number = round(word.value)
            if abs(word.value - number) > _WHOLE or number < 0:
                raise cursor.error("VP007", f"{name}{word.value:g}: the number is whole and not negative", at)
            self._add_code(words, name, number, cursor, at)
            return
        if name in words.words:
            raise cursor.error("VP004", f"{name} appears twice in the block", at)
        words.words[name] = word

    def _add_code(self, words: Words, letter: str, number: int, cursor: Cursor, at: int, digits: str = "") -> None:
        name = f"{letter}{number}"
        if letter == "L":
            name = f"L{digits or number}"
            if name in self.user_names:
                words.user_names.append(name)
            elif self.is_subprogram(name):
                words.calls.append(Call(name, None, at + 1))
            else:
                raise self._make_unknown_call(name, cursor, words, at)
        elif letter == "M":
            words.m.append((number, at + 1))
        elif (why := explain_refusal(name)) is not None:
            is_number_with_l = cursor.text[cursor.at : cursor.at + 1] == "l"
            number_with_l = refuse_l(cursor, cursor.at) if is_number_with_l else None
            raise number_with_l or cursor.error("VP002", f"{name} is not executed ({why})", at)
        else:
            self._add_function(words, name, cursor, at)

    @staticmethod
    def _add_function(words: Words, name: str, cursor: Cursor, at: int) -> None:
        if name in NO_EFFECT:
            words.no_effect.append((name, at + 1))
            return
        group = GROUP_OF.get(name)
        if group is None:
            near = list_near_numbers(name[1:], _COMMON_CODES)
            text = f"{name} is not a code of this language"
            text += f"; it has {name_numbers(near, 'G')}" if near else ""
            edits = tuple(Remedy(f"write G{one}", f"G{one}", way="marked", is_choice=True) for one in near)
            raise cursor.error("VP002", text, at, edits)
        if group in words.groups:
            raise cursor.error("VP003", f"{words.groups[group][0]} and {name} are of one group ({group})", at)
        words.groups[group] = (name, at + 1)

    # --- NAME[...] and NAME(...) ------------------------------------------------------------------------

    def _read_indexed(self, name: str, cursor: Cursor, words: Words, at: int) -> None:
        if self.variables.is_known(name):
            self.variables.assign(name, cursor, at)
            return
        if name == "SPOS":
            if read_indices(cursor, self.variables) != (1,):
                raise cursor.error("VP002", "SPOS[n]: there is one spindle, SPOS[1]", at)
            cursor.expect("=", "after SPOS[1]")
            self._add(words, self._read_address(name, cursor, at), cursor, at)
            return
        if name not in NO_EFFECT:
            raise self._make_unknown_error(name, cursor, at)
        end = cursor.text.find("]", cursor.at)
        if end < 0:
            raise cursor.error("VP001", f"{name}[: expected ']'", at)
        cursor.at = end + 1
        if cursor.take("="):
            read_value(cursor, self.variables)
        words.no_effect.append((name, at + 1))

    def _read_call(self, name: str, cursor: Cursor, words: Words, at: int) -> None:
        arguments = read_arguments(cursor)
        if name == "SETMS" and arguments[0].text.strip() not in ("", "1"):
            raise cursor.error("VP002", f"SETMS({arguments[0].text.strip()}): there is one spindle", at)
        if name == "FGROUP":
            words.counts_turns = _read_feed_group(arguments, cursor, at)
        if name in self.user_names:
            words.user_names.append(name)
        elif name in NO_EFFECT:
            words.no_effect.append((name, at + 1))
        elif name in ("TRAORI", "TRAFOOF"):
            if name == "TRAFOOF" or len(arguments) > 1 or arguments[0].text.strip() not in ("", "1"):
                raise cursor.error(
                    "VP002", f"{name} with these values: there is one transformation, TRAORI or TRAORI(1)", at
                )
            self._add_function(words, name, cursor, at)
        elif (why := explain_refusal(name)) is not None:
            error = cursor.error("VP002", _explain_refused(name, why), at)
            if _LONG_NUMBER.fullmatch(name) and name[-1] == "9" and f"{name[:-1]}0" in CYCLES:
                propose_key_beside(error, cursor.text[at : at + len(name)], f"{name[:-1]}0")
            raise error
        elif name in CYCLES or self.is_subprogram(name):
            words.calls.append(Call(name, arguments, at + 1))
        else:
            raise self._make_unknown_error(name, cursor, at, words)

    # --- a name alone, or letters with numbers ----------------------------------------------------------

    def _read_bare(self, name: str, cursor: Cursor, words: Words, at: int) -> None:
        if name == "MCALL":
            words.modal_call = at + 1
        elif name == "EXTERN":  # declares a subprogram; its own PROC line says the same
            words.no_effect.append((name, at + 1))
            self.declared_names.add(cursor.name() or "")
            if cursor.skip() == "(":
                read_arguments(cursor)
            refuse_leftover(cursor)
        elif name in NO_EFFECT:
            words.no_effect.append((name, at + 1))
        elif name in GROUP_OF:
            self._add_function(words, name, cursor, at)
        elif name in self.user_names and _SUBPROGRAM.match(name):
            words.user_names.append(name)
        elif _SUBPROGRAM.match(name) and self.is_subprogram(name):
            words.calls.append(Call(name, None, at + 1))
        elif name[0] == "R" and (radius := find_radius(cursor, at, self._is_set, self.motion)) is not None:
            raise radius
        elif (number := read_r_number(name)) is not None:
            is_in_number = cursor.text[at - 1 : at].isdigit()
            letter_of_digit = find_letter_of_digit(cursor, at) if is_in_number else None
            error = letter_of_digit or _refuse_missing_equals(name, cursor, at)
            if not self._is_set(name) and letter_of_digit is None:
                propose_feed(error, cursor, at)
            if number not in self.variables.r:  # nothing more of it; a loop says the same again
                self.variables.r[number] = 0.0
                self._never_set.add(number)
            raise error
        elif _LETTER_NUMBER.match(cursor.text, at) and (len(name) == 1 or name[1].isdigit()):
            cursor.at = at
            self._read_letter(cursor, words)
        elif name in CYCLES:
            words.calls.append(Call(name, None, at + 1))
        else:
            raise self._make_unknown_error(name, cursor, at, words if _SUBPROGRAM.match(name) else None)

    def explain_moved_blank(self, text: str, at: int) -> str:
        """The message about a statement and its name whose blank is missing, or one place too far; else empty."""
        return explain_moved_blank(text, at, HEADS, self._is_operand)

    def _is_operand(self, head: str, name: str) -> bool:
        """Whether a name may follow a statement."""
        if head.startswith("GOTO"):
            return self.is_label(name)
        if head == "MCALL":
            return name in CYCLES or self.is_subprogram(name)
        return name in TYPES if head == "DEF" else name != "R" and self.variables.is_known(name)

    def _is_set(self, name: str) -> bool:
        number = read_r_number(name)
        return number in self.variables.r and number not in self._never_set

    def _read_letter(self, cursor: Cursor, words: Words) -> None:
        """A letter and a number; another word may follow without a blank."""
        at, text = cursor.at, cursor.text
        letter = text[at].upper()
        code = _CODE.match(text, at)
        if code is not None:
            if not is_count(code[2]):
                raise self._make_unknown_error(code.group()[:12], cursor, at)
            divided_code = _DIVIDED_CODE.match(text, at)
            if divided_code is not None and f"G{divided_code[1]}" not in GROUP_OF:
                right = f"G{divided_code[1]}{divided_code[2]}"
                if right in GROUP_OF:
                    raise cursor.error("VP001", f"{divided_code[0]}: a blank is in the word; did you mean {right}?", at)
            cursor.at = code.end()
            self._add_code(words, letter, int(code[2]), cursor, at, code[2])
            return
        if message := explain_signed_count(cursor, at):
            raise cursor.error("VP001", message, at)
        if letter == "N" and cursor.text[:at].strip(" \t/0123456789"):
            text = "a block number stands at the beginning of its block; write the letter that is meant, such as M"
            raise cursor.error("VP001", f"{cursor.text[at:].split()[0]}: {text}", at)
        if letter not in ADDRESSES or letter in "GML":
            point_code = _POINTED_CODE.match(text, at)
            name = letter if point_code is None else point_code[0].upper()
            raise self._make_unknown_error(name if name in REFUSED_WORDS else letter, cursor, at)
        cursor.at += 1
        sign = -1.0 if cursor.skip() == "-" else 1.0
        if cursor.text[cursor.at] in "+-":
            cursor.at += 1
            cursor.skip()
        value = cursor.number()
        assert value is not None
        self._add(words, Word(letter, sign * value, at + 1), cursor, at)

    def _make_unknown_call(self, name: str, cursor: Cursor, words: Words, at: int) -> ProgramError:
        if name in self.declared_names:  # it is no code of the builder, and moves axes
            text = f"{name}, which EXTERN declares, is defined neither in the program nor in a file {name}.SPF"
            return ProgramError("VP023", text, at + 1, about=name, goes_on=True).advise(GIVE_FILE)
        if (number := refuse_l(cursor, at)) is not None:
            return number
        own_names = [*self.list_subprograms(), *self.user_names]
        is_alone = not (words.words or words.groups or words.m or _WORD_AFTER.match(cursor.text, cursor.at))
        error = _make_unknown_call(name, at + 1, own_names, is_alone=is_alone)
        is_remark = find_correction(error.message) is None
        return (refuse_remark(cursor, at) if is_remark else None) or error

    def _make_unknown_error(self, name: str, cursor: Cursor, at: int, calls: Words | None = None) -> ProgramError:
        """Why a name is not executed; ``calls``: the words before it, of a name that would be a subprogram."""
        if message := (
            self.explain_moved_blank(cursor.text, at)
            or explain_blanks(name, cursor.text, at, self.is_subprogram)
            or explain_function(name)
            or explain_glued(name, cursor.text, at, self.variables.is_known)
        ):
            return cursor.error("VP001", message, at)
        signed_name = _SIGNED_NAME.match(cursor.text, at)
        if name in ADDRESSES and signed_name is not None and self.variables.is_known(signed_name[2].upper()):
            return refuse_lost_equals(cursor, at, signed_name[1], signed_name[0])
        if (letter := find_letter_of_digit(cursor, at)) is not None:
            return letter
        if name == "N":
            return cursor.error("VP001", "N: the number of the block is missing; write it, or take N out", at)
        if name == "DO" and cursor.is_at_end and at:
            return cursor.error("VP001", "DO: the letter O in a number; did you mean D0?", at)
        if name == "R":
            return refuse_r(cursor, at)
        if name in FRAME_FUNCTIONS:
            return cursor.error("VP001", f"{name}() is the value of a frame; write $P_PFRAME={name}(...)", at)
        near_for = find_meant(name, ("FOR",), slip_alone=True, least=LETTERS_OF_FUNCTIONS)
        if near_for and _COUNTS.match(cursor.text, cursor.at):
            return cursor.error("VP002", f"{name}: no meaning in this language; did you mean {near_for}?", at)
        why = explain_refusal(name)
        if why is not None:
            return cursor.error("VP002", _explain_refused(name, why), at)
        if name in STATEMENTS:
            return cursor.error("VP001", f"{name} must be the first word of its block", at)
        following = cursor.peek_name()
        if name in ADDRESSES and following is not None and self.variables.is_known(following):
            written_words = cursor.text[at : cursor.at + len(following)]
            right_word = f"{name}={cursor.text[cursor.at : cursor.at + len(following)]}"
            return cursor.error("VP001", f"{written_words}: an = is missing; did you mean {right_word}?", at)
        if len(name) > 1 and name in ADDRESSES and (number := _SIGNED_NUMBER.match(cursor.text, cursor.at)) is not None:
            return refuse_lost_equals(cursor, at, name, cursor.text[at : number.end()])
        if name == "L" and (number_with_l := refuse_l(cursor, at)) is not None:
            return number_with_l
        if name in (*ADDRESSES, *GROUP_OF, *CYCLES):
            wanted_text = "'=' and a value" if len(name) > 1 and name in ADDRESSES else "'=' or a number"
            return cursor.error("VP001", f"{name}: expected {wanted_text} after it", at)
        if self.variables.find(name) is not None:
            return _refuse_missing_equals(name, cursor, at)
        if calls is None or CODE.fullmatch(name) is None:
            return cursor.error("VP002", f"{name}: no meaning in this language, and no file {name}.SPF {_WHERE}", at)
        return self._make_unknown_call(name, cursor, calls, at)


_NUMBER_ALONE: Final = re.compile(r"[ \t]*(?:N\d+[ \t]*)?", re.IGNORECASE)


def _refuse_missing_equals(name: str, cursor: Cursor, at: int) -> ProgramError:
    """The error of a variable that no = follows."""
    kind = "an R parameter" if read_r_number(name) is not None else "a variable (DEF)"
    text_from, value = cursor.text[at:].rstrip(), re.sub(r"(?<=^[-+*/])\s+", "", cursor.text[cursor.at :].strip())
    if not value or not _NUMBER_ALONE.fullmatch(cursor.text[:at]):
        return cursor.error("VP001", f"{name} is {kind}; an = and its new value are missing", at)
    readings = [f"{name}={name}{value}", f"{name}={value}"] if value[0] in "+-" else [f"{name}={value}"]
    readings += [f"{name}={value[1:]}"] * (value[0] == "-")  # the key beside that of =
    if value[0] in "*/":
        readings = [f"{name}={name}{value}"]
    edits = tuple(Remedy(f"write {one}", one, misspelt=text_from, is_choice=len(readings) > 1) for one in readings)
    text = f"{name} is {kind}; an = is missing: write {' or '.join(readings)}"
    return cursor.error("VP001", text, at, edits)


def _make_unknown_call(name: str, column: int, own_names: Iterable[str], *, is_alone: bool) -> ProgramError:
    """Refuse (VP002) a name that is no word and no subprogram; all of a program are one finding, but misspelt ones.

    ``own_names`` are those of the program. Beside other words, ``not is_alone``, a name calls nothing: what it means
    for their motion nobody can ignore.
    """
    address = _ADDRESS.fullmatch(name)
    if address is not None and address[1] in ADDRESSES:
        return ProgramError(
            "VP002", f"{name}: no meaning in this language; did you mean {address[1]}={address[2]}?", column
        )
    if not is_alone:
        text = f"{name}: no meaning in this language beside other words of a block; write the intended word"
        message = explain_unknown(text, name, own_names, _PLAIN_CODES, NO_EFFECT, STATEMENTS)
        return ProgramError("VP002", message, column)
    if find_meant(name, ("RET",), slip_alone=True, least=LETTERS_OF_FUNCTIONS):
        return ProgramError("VP002", f"{name}: no meaning in this language; did you mean RET?", column)
    text = f"{name}: no meaning in this language, and no file of that name (.SPF) {_WHERE}; "
    numbers = (one[1:] for one in own_names if one[:1] == name[0])
    if near := name_near_numbers(name[1:], numbers, name[0]):
        text += f"the program has {near}; "
    text += f"if it moves no axis, {REMAP_GIVES}"
    message = explain_unknown(text, name, own_names, _PLAIN_CODES, CYCLES, STATEMENTS, NO_EFFECT)
    if message == text and (cycle := _find_cycle(name)):
        message = f"{name}: {_MEANS_NOTHING} {cycle}?"
    if message != text:  # a word that moves axes, or changes how they move, is not to be ignored
        return ProgramError("VP002", message, column)
    return ProgramError("VP002", message, column, about=name, settled_by=("remap", name))


def _explain_refused(name: str, why: str) -> str:
    """Why a word is not executed, or which cycle is meant by a number that none has."""
    text = f"{name} is not executed ({why})"
    if name in REFUSED_WORDS:
        return text
    if _LONG_NUMBER.fullmatch(name):
        cycle = _find_cycle(name)
        return f"{name}: {_MEANS_NOTHING} {cycle}?" if cycle else explain_unknown(text, name, CYCLES, NO_EFFECT)
    near = (_find_cycle(name) or find_meant(name, CYCLES, slip_alone=True)) if _SLIP_OF_CYCLE.fullmatch(name) else ""
    return f"{text}; did you mean {near}?" if near else text


def _find_cycle(name: str) -> str:
    """The cycle whose number has a digit twice, or CYCLE800 without its last 0; letters may stand for digits."""
    number = name.removeprefix("CYCLE").translate(_LIKE_DIGITS)
    numbers = (f"{number}0" if number == "80" else number, *drop_doubles(number, "0-9"))
    near = next((f"CYCLE{one}" for one in numbers if f"CYCLE{one}" in CYCLES), "")
    return near if name.startswith("CYCLE") else ""


#: A word of letters and a number, or with =, after a name.
_WORD_AFTER: Final = re.compile(r"[ \t]*(?!P[ \t]*=?[ \t]*\d)[A-Z][A-Z0-9]*[ \t]*[-+=.0-9]", re.IGNORECASE)
#: A name of several letters and a number, as CR10 in place of CR=10.
_ADDRESS: Final = re.compile(r"([A-Z]{2,})(\d+)")
_WHOLE: Final = 1e-4


def read_arguments(cursor: Cursor) -> tuple[Argument, ...]:
    """Read ``(...)``: the texts between the commas outside of brackets and quotes."""
    begin = cursor.at
    cursor.expect("(", "")
    found: list[Argument] = []
    depth, start, in_quotes, quote, text = 0, cursor.at, False, 0, cursor.text
    for at in range(cursor.at, len(text)):
        character = text[at]
        if character == '"':
            in_quotes, quote = not in_quotes, at
        elif in_quotes:
            continue
        elif character in "([":
            depth += 1
        elif character in ")]" and depth:
            depth -= 1
        elif character in ",)":
            found.append(Argument(text[start:at], start + 1))
            start = at + 1
            if character == ")":
                cursor.at = at + 1
                return tuple(found)
    if in_quotes and (many := text.find('"""', begin)) >= 0:
        edits = (Remedy('write ""', '""', misspelt='"""'),)
        raise cursor.error("VP001", 'a quote too many; write ""', many, edits)
    if in_quotes:
        is_empty = text[quote + 1 : quote + 2] in (",", ")")
        empty_text = Remedy('write ""', '""', misspelt='"', is_choice=True)
        raise cursor.error(
            "VP001", "the quote is not closed on its line; expected '\"'", quote, (empty_text,) if is_empty else ()
        )
    if text.startswith("((", begin) and depth == 1 - text.startswith("(()", begin):
        edits = (Remedy("write (", "(", misspelt="(("),)
        raise cursor.error("VP001", "((: a bracket too many; write (", begin, edits)
    open_text = text[begin:].rstrip()
    edits = (Remedy("write )", f"{open_text})", misspelt=open_text, is_choice=True),)
    raise cursor.error("VP001", "the bracket is not closed on its line; expected ')'", begin, edits)


def read_argument_values(arguments: tuple[Argument, ...], variables: Variables) -> list[Value | None]:
    """Values of arguments; None for empty ones."""
    values: list[Value | None] = []
    for argument in arguments:
        if not argument.text.strip():
            values.append(None)
            continue
        cursor = argument.make_cursor()
        values.append(read_value(cursor, variables))
        if not cursor.is_at_end:
            raise cursor.error("VP001", "expected ',' or ')' after a value")
    return values


def _read_feed_group(arguments: tuple[Argument, ...], cursor: Cursor, at: int) -> str:
    """An FGROUP that counts rotary axes beside X, Y or Z; empty where F is the speed of the tip on a control too."""
    axes = [argument.text.strip().upper() for argument in arguments]
    rotary = [axis for axis in axes if axis in ("A", "B", "C")]
    text = f"FGROUP({','.join(axes)})"
    if rotary and len(rotary) == len(axes):
        why = "F would be that of rotary axes alone, also where X Y Z move; write G93, or leave FGROUP out"
        raise cursor.error("VP002", f"{text}: {why}", at)
    return text if rotary else ""
