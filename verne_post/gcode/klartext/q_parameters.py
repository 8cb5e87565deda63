"""Q, QL, QR and QS parameters: their values, what of the control they show, and the statements that set them."""

import re
from typing import Final

from msgspec import Struct, field

from verne_post.base.suggestions import list_near_numbers, name_near_numbers
from verne_post.gcode.expressions import MAX_NUMBER
from verne_post.gcode.klartext.first_words import LETTERS_AS_DIGITS
from verne_post.gcode.klartext.formulas import VALUE, combine, evaluate, holds, read_value
from verne_post.gcode.klartext.statements import Statement, label_name
from verne_post.gcode.klartext.vocabulary import FN, REFUSED_FN
from verne_post.gcode.program_error import DOUBLE_EQUALS, ProgramError, write_meant, write_words
from verne_post.model.findings import Remedy

_ASSIGNMENT: Final = re.compile(r"(Q[LRS]?)[ \t]*(\d+)[ \t]*=")
#: In the lines that ~ adds to an assignment: they are parameters of a cycle.
_NEXT_PARAMETER: Final = re.compile(r"[ \t]*Q\d+[ \t]*=")
_OPERATORS: Final = {1: r"\+", 2: "-", 3: r"\*", 4: "/|DIV", 5: "SQRT", 6: "SIN", 7: "COS", 8: "LEN", 13: "ANG"}
#: The same as messages name them.
_NAMES: Final = {number: "DIV" if number == 4 else sign.lstrip("\\") for number, sign in _OPERATORS.items()}
_LETTER_FOR_1: Final = re.compile(r"((?:[-+]|(?<!\d))\d++)[lI](?!\w)")
#: Where a part of FN ends: a word before anything but a letter, a number before anything but a digit, as in Q1DIV+2.
_END_OF_PART: Final = r"(?:(?<![A-Z])|(?![A-PR-Z_]|Q(?![LRS]?\d)))(?:(?<!\d)|(?![\d_]))"
_ANY_LABEL: Final = r"\"[^\"]*\"|\d+|QS\d+"
_DEFINITION_TEST: Final = re.compile(
    r"IF[ \t]+(Q[LRS]?\d+)[ \t]+IS[ \t]+(UNDEFINED|DEFINED)[ \t]+GOTO[ \t]+LBL[ \t]*(?:\"([^\"]*)\"|(\d+)|(QS\d+))[ "
    r"\t]*$"
)
_RELATIONS: Final = {9: "EQU", 10: "NE", 11: "GT", 12: "LT"}
_STRING_PART: Final = re.compile(
    r"[ \t]*(?:\"([^\"]*)\"|(QS\d+)|TOCHAR[ \t]*\([ \t]*DAT[ \t]*("
    + VALUE
    + r")[ \t]*(?:DECIMALS[ \t]*(\d{1,3}))?[ \t]*\))[ \t]*"
)
#: So many numbers of Q, QL, QR, QS there are.
_LAST: Final = {"Q": 1999, "QL": 499, "QR": 499, "QS": 1999}
#: Parameters that the control sets.
_OF_CONTROL: Final = range(100, 200)
#: Why a parameter has no value: nothing of it is to be told.
SETTING_REFUSED: Final = "the statement that sets it is refused"
_SET_NAME: Final = re.compile(r"[ \t]*(?:\d{1,2}[ \t]*:?[ \t]*)?(Q[LR]?\d+)")
_MAX_STRING: Final = 10_000


class QParameters(Struct):
    """Values of the parameters; ``control_values`` are the control's own, by number, which the program's effects set.

    ``unknown`` are those that a read at the machine has set: their value is not known here. ``refused_names`` are
    those that a refused statement sets: errors about them only follow from it.
    """

    values: dict[str, float] = field(default_factory=dict)
    strings: dict[str, str] = field(default_factory=dict)
    local: list[dict[str, float]] = field(default_factory=lambda: [{}])
    control_values: dict[int, float] = field(default_factory=dict)
    unknown: set[str] = field(default_factory=set)
    refused_names: set[str] = field(default_factory=set)
    is_jump_refused: bool = False  #: A call or a jump was refused, which may lead to what sets a parameter.

    def read_value(self, name: str) -> float:
        """Value of Q1, QL1, QR1; VP025 where it has none."""
        kind, number = _split(name)
        if kind == "QS":
            raise ProgramError("VP025", f"{name} is a text, not a number")
        key = f"{kind}{number}"
        if key in self.unknown:
            raise ProgramError("VP025", f"{key} was read at the machine (FN 18), so its value is not known here")
        table = self.local[-1] if kind == "QL" else self.values
        if key in table:
            return table[key]
        if kind == "Q" and number in self.control_values:
            return self.control_values[number]
        near = list_near_numbers(str(number), self._list_numbers(kind))
        names = [f"{kind}{one}" for one in near] or self._list_other_kinds(number)
        edits = write_words(name, *names, is_choice=True)
        raise ProgramError("VP025", f"{key} has no value; {self._say_what_sets_it(kind, number)}", edits=edits)

    def _say_what_sets_it(self, kind: str, number: int) -> str:
        if f"{kind}{number}" in self.refused_names or self.is_jump_refused:
            return SETTING_REFUSED
        others = self._list_other_kinds(number)
        numbers = self._list_numbers(kind)
        near = name_near_numbers(str(number), numbers, kind) or (others and f"{others[0]}, which is another parameter")
        if kind == "Q" and number in _OF_CONTROL and not near:
            return f"the control gives Q{_OF_CONTROL[0]} to Q{_OF_CONTROL[-1]}, and this one only at the machine"
        return f"set it first{f'; the program sets {near}' if near else ''}"

    def _list_numbers(self, kind: str) -> list[str]:
        """Numbers of the parameters that the program sets, also by refused statements: in the next pass they are so."""
        names = dict.fromkeys((*self.values, *self.local[-1], *sorted(self.refused_names)))
        return [name.removeprefix(kind) for name in names]

    def _list_other_kinds(self, number: int) -> list[str]:
        """Parameters of the other kinds with this number that have a value: QL1 where Q1 has none."""
        return [key for kind in ("Q", "QL", "QR") if (key := f"{kind}{number}") in (*self.values, *self.local[-1])]

    def look_up(self, name: str) -> float | str | None:
        """Number, or text of QS1; None where it has none."""
        try:
            return self.read_text(name.upper()) if name.upper().startswith("QS") else self.read_value(name.upper())
        except ProgramError:
            return None

    def is_defined(self, name: str) -> bool:
        """True for a parameter with a value."""
        kind, number = _split(name)
        key = f"{kind}{number}"
        table = {"QL": self.local[-1], "QS": self.strings}.get(kind, self.values)
        return key in table or (kind == "Q" and number in self.control_values)  # type: ignore[operator]

    def has(self, name: str, value: float) -> bool:
        """True where Q1, QL1 or QR1 has this value."""
        try:
            return self.read_value(name) == value
        except ProgramError:
            return False

    def set(self, name: str, value: float) -> None:
        """Set Q1, QL1 or QR1; VP007 beyond any number that means something."""
        kind, number = _split(name)
        if not abs(value) <= MAX_NUMBER:
            raise ProgramError("VP007", f"{kind}{number} would be {value:g}, beyond {MAX_NUMBER:g}")
        key = f"{kind}{number}"
        self.unknown.discard(key)
        self.refused_names.discard(key)
        (self.local[-1] if kind == "QL" else self.values)[key] = value

    def read_text(self, name: str) -> str:
        """Text of QS1; VP025 where it has none."""
        kind, number = _split(name)
        if f"{kind}{number}" not in self.strings:
            raise ProgramError("VP025", f"{name} has no text; set it first")
        return self.strings[f"{kind}{number}"]

    def refuse(self, name: str) -> None:
        """The statement that sets a parameter is refused."""
        kind, number = _split(name)
        self.refused_names.add(f"{kind}{number}")
        for table in (self.values, self.local[-1]):
            table.pop(f"{kind}{number}", None)

    def forget(self, name: str) -> None:
        """A value that only the machine knows."""
        kind, number = _split(name)
        self.unknown.add(f"{kind}{number}")


def _split(name: str) -> tuple[str, int]:
    kind = name.rstrip("0123456789")
    digits = name[len(kind) :]
    number = int(digits) if len(digits) < 6 else 10**6
    if number > _LAST.get(kind, -1):
        raise ProgramError("VP025", f"{name[:12]}: there are {kind}0 to {kind}{_LAST.get(kind, 0)}")
    return kind, number


def assign(statement: Statement, parameters: QParameters) -> None:
    """``Q1 = formula``, ``QS1 = "text" || QS2``."""
    match = _ASSIGNMENT.match(statement.rest)
    if match is None:
        letters = re.match(r"[ \t]*((?:QS|QR|QL(?=.*\d)|Q)\d*[LIO][LIO\d]*)(?=[ \t]*=)", statement.rest)
        if letters is not None:
            right = re.sub(r"[LIO]", lambda one: one[0].translate(LETTERS_AS_DIGITS), letters[1][1:])
            right = f"Q{right if letters[1][1] not in 'LRS' else letters[1][1] + right[1:]}"
            written_word = letters[1][:2] + letters[1][2:].replace("L", "l")
            text = f"{written_word}: a letter in the number; did you mean {right}?"
            raise statement.error("VP001", text, letters.start(1))
        written_text = re.match(r"[ \t]*(Q[LRS]?[ \t]*\d+)([ \t]*[-+]|)[ \t]*", statement.rest)
        name = written_text[1] if written_text else "Q1"
        if written_text and written_text[2].endswith("-") and statement.rest[written_text.end() :]:
            wrong = f"{name}{written_text[2]}"  # the keys of = and - are neighbours
            rights = (f"{name} =", f"{name} = -")
            raise statement.refuse_word(wrong, "an = is missing after the parameter", *rights, at=written_text.start(1))
        edits = write_words(name, f"{name} =") if written_text and statement.rest[written_text.end() :] else ()
        raise statement.error(
            "VP001", f"{name}: an = is missing after the parameter; write {name} = and its value", 0, edits
        )
    name = match.group(1) + match.group(2)
    if statement.rest.startswith("==", match.end() - 1):
        raise statement.error("VP001", DOUBLE_EQUALS, match.end() - 1)
    if statement.further_lines and _NEXT_PARAMETER.match(statement.rest, statement.further_lines[0]):
        text = f"{name} = ... ~ is a parameter of a cycle, and no CYCL DEF is before it"
        raise statement.error("VP005", f"{text}; write CYCL DEF with its number and ~ in the line before", 0)
    rest = statement.rest[match.end() :]
    if not rest.strip():
        raise statement.error("VP005", f"{name} = without a value")
    if match.group(1) == "QS" and rest.count('"') % 2:
        begin = match.end() + len(rest) - len(rest.lstrip())
        right = '"{}"'.format(rest.strip().strip('"'))
        edits = write_words(rest.strip(), right, is_choice=True)
        raise statement.error("VP001", f"a text stands between two quotes; write {right}", begin, edits)
    if match.group(1) == "QS":
        parameters.strings[f"QS{_split(name)[1]}"] = _join_strings(rest, parameters)
    elif rest.strip().startswith("TONUMB"):
        parameters.set(name, _convert_to_number(rest, parameters))
    else:
        with statement.place_errors(match.end()):
            parameters.set(name, evaluate(rest, parameters))


def find_set_name(statement: Statement) -> str | None:
    """The parameter that an assignment or a function sets; None where it sets none."""
    found = _SET_NAME.match(statement.rest)
    return None if found is None or "IF" in statement.rest else found[1]


def _join_strings(text: str, parameters: QParameters) -> str:
    joined_text, at = "", 0
    while True:
        match = _STRING_PART.match(text, at)
        if match is None:
            raise ProgramError(
                "VP002", f"{text[at:].strip()[:20]}: expected a text in quotes, QS parameters and TOCHAR, joined by ||"
            )
        literal, name, number, decimals = match.groups()
        if literal is not None:
            joined_text += literal
        elif name is not None:
            joined_text += parameters.read_text(name)
        else:
            joined_text += f"{read_value(number, parameters):.{min(int(decimals or 0), 9)}f}"
        if len(joined_text) > _MAX_STRING:
            raise ProgramError("VP007", f"a text of more than {_MAX_STRING} characters")
        at = match.end()
        if at == len(text):
            return joined_text
        if not text.startswith("||", at):
            raise ProgramError("VP001", f"{text[at:].strip()[:20]!r} in a text formula; expected ||")
        at += 2


def _convert_to_number(text: str, parameters: QParameters) -> float:
    match = re.fullmatch(r"[ \t]*TONUMB[ \t]*\([ \t]*SRC_(QS\d+)[ \t]*\)[ \t]*", text)
    if match is None:
        raise ProgramError("VP001", "expected TONUMB( SRC_QS1 )")
    try:
        return read_value(parameters.read_text(match.group(1)), parameters)
    except ProgramError as error:
        raise ProgramError("VP007", f"TONUMB: {error}") from None


class FnAnswer(Struct, frozen=True):
    """What a function of FN asks for: a jump to a label, or a message."""

    label: str | None = None
    message: str | None = None


def execute_fn(statement: Statement, parameters: QParameters) -> FnAnswer:
    """``FN 0: Q1 = +5`` to ``FN 18``.

    Raises
    ------
    ProgramError
        VP002 for functions that are not executed, VP027 for FN 14, which stops the program.
    """
    match = re.match(r"[ \t]*(\d{1,2})[ \t]*:[ \t]*", statement.rest)
    if match is None:
        digits = re.match(r"[ \t]*(\d{1,2})", statement.rest)
        right = f"FN {digits[1]}:" if digits else "FN 0:"
        text = f"a colon is missing after the number of FN; write {right}"
        edits = write_words(digits[1], f"{digits[1]}:") if digits else ()
        if digits and not statement.rest[digits.end() :].strip():  # the rest is a remark
            text, edits = f"{text} and the assignment", write_words(f"{digits[1]};", f"{digits[1]}:")
        raise statement.error("VP001", text, 0, edits)
    number, rest = int(match.group(1)), statement.rest[match.end() :].rstrip()
    if number == 14:
        raise ProgramError("VP027", f"the program asks to stop: {rest.strip()}")
    if number in REFUSED_FN:
        raise ProgramError("VP002", f"FN {number} is not executed ({REFUSED_FN[number]})")
    if number not in FN:
        raise ProgramError("VP002", f"FN {number} is not a function of the language")
    if number in _RELATIONS:
        return FnAnswer(label=_jump(number, statement, match.end(), parameters))
    if number in (15, 16):
        return FnAnswer(message=f"FN {number}: {rest}")
    if number == 18:
        read = re.match(r"SYSREAD[ \t]+(Q[LR]?\d+)[ \t]*=", rest)
        if read is None:
            raise ProgramError("VP001", "expected FN 18: SYSREAD Q1 = ID...")
        parameters.forget(read.group(1))
        return FnAnswer(message=f"FN 18: {rest}")
    if "==" in rest:
        raise statement.error("VP001", DOUBLE_EQUALS, match.end() + rest.index("=="))
    parts = [("Q1", r"Q[LR]?\d+"), ("=", "="), ("value", VALUE)]
    if number in (5, 6, 7):
        parts.insert(2, (_NAMES[number], _OPERATORS[number]))
    elif number:
        parts += [(_NAMES[number], _OPERATORS[number]), ("value", VALUE)]
    (name, *_), values = _match_parts(number, statement, match.end(), parts, parameters)
    value = values[0]
    if number:
        with statement.place_errors(match.end()):
            value = combine(number, value, values[1] if len(values) > 1 else 0.0)
    parameters.set(name, value)
    return FnAnswer()


def _match_parts(
    number: int, statement: Statement, at: int, parts: list[tuple[str, str]], parameters: QParameters
) -> tuple[list[str], list[float]]:
    """The parts of what follows FN and its colon as they are written, and the values among them.

    Raises
    ------
    ProgramError
        VP001 at the first part that is not of the form of the function, which it says.
    """
    text, found, values = statement.rest.rstrip(), list[str](), list[tuple[int, str]]()
    for name, pattern in [*parts, ("", r"\Z")]:
        match = re.compile(rf"[ \t]*({pattern}){_END_OF_PART}", re.DOTALL).match(text, at)
        if match is None:
            raise _refuse_part(number, statement, at, parts, name)
        found.append(match[1])
        values += [(match.start(1), match[1])] if name == "value" else []
        at = match.end()
    numbers = []
    for place, value in values:
        with statement.place_errors(place):
            numbers.append(read_value(value, parameters))
    return found, numbers


def _refuse_part(number: int, statement: Statement, at: int, parts: list[tuple[str, str]], name: str) -> ProgramError:
    """The error of a part of FN that is not what belongs there."""
    rest = statement.rest[at:].strip()
    form = f"FN {number}: {' '.join(one for one, _pattern in parts)}"
    word = re.match(r"[^\s]+", rest)
    for slip in _LETTER_FOR_1.finditer(statement.rest):
        if slip.end() == at + 1:
            return statement.refuse_word(slip[0], "a letter in the number", f"{slip[1]}1", at=slip.start())
    other = next((one for one, sign in _OPERATORS.items() if number in _OPERATORS and re.match(sign, rest)), number)
    if other != number and number in (1, 2, 3, 4) and name == _NAMES[number]:
        sign = re.match(_OPERATORS[other], rest)[0]  # type: ignore[index]
        right = _NAMES[number]
        text = f"{sign} belongs to FN {other}; write {right}, or FN {other}: in place of FN {number}:"
        return statement.error("VP001", text, at, write_words(sign, right, is_choice=True))
    part_names = {"": "the end of the line", "value": "a value", "label": "a number, or a name in quotes"}
    wanted_part = part_names.get(name, name)
    edits: tuple[Remedy, ...] = ()
    if (parameter := re.match(r"[-+]?Q[LR]?[ \t]+\d+", rest)) is not None and name == "value":
        right = "".join(parameter[0].split())
        return statement.refuse_word(parameter[0], "a blank is in the number", right, at=at)
    if word is not None and name == "label" and not word[0].strip('"').isdecimal():
        right = '"{}"'.format(word[0].strip('"'))
        edits = write_words(word[0], right)
    elif (
        (pair := re.match(r"(\w+)[ \t]+(\w+)", rest)) is not None
        and name.isalpha()
        and name.isupper()
        and (pair[1] + pair[2]).startswith(name)
    ):
        right = f"{name} {(pair[1] + pair[2])[len(name) :]}".rstrip()
        return statement.refuse_word(pair[0], "the blank is at a wrong place", right, at=at)
    elif word is not None and name.isalpha() and name.isupper() and word[0] != "=":
        edits = write_meant(word[0], [name]) or _write_near(word[0], name)
    elif (
        name == "value"
        and word is not None
        and (
            re.fullmatch(
                VALUE, right := re.sub(r"(?<=[Q\dOIL])[OIL]", lambda one: one[0].translate(LETTERS_AS_DIGITS), word[0])
            )
        )
    ):
        return statement.error("VP001", f"{word[0]}: a letter in the number; did you mean {right}?", at)
    elif (
        word is not None
        and word[0].isdigit()
        and (before := re.search(r"[-+]?Q?(?<!\d)\d++[ \t]*+$", statement.rest[:at]))
    ):
        written_word = f"{before[0]}{statement.rest[at : statement.rest.index(word[0], at)]}{word[0]}"
        right = "".join(written_word.split())
        return statement.refuse_word(written_word, "a blank is in the number", right, at=before.start())
    elif word is not None and name == "=" and word[0] in ("-", "+"):
        edits = write_words(word[0], "=")
    elif word is not None and name == "=" and word[0][0] == "-":  # the key of = is beside it
        edits = write_words(word[0], f"= {word[0]}", f"= {word[0][1:]}")
    elif word is not None and name == "=":
        edits = write_words(word[0], f"= {word[0]}")
    shown_text = f"found {word[0][:15]}" if word is not None else "the line ends"
    return statement.error("VP001", f"expected {wanted_part}, {shown_text}; write {form}", at, edits)


def _read_digits(word: str) -> str:
    """A value with digits in place of the letters that look like them."""
    return re.sub(r"(?<=[Q\dOIL])[OIL]", lambda one: one[0].translate(LETTERS_AS_DIGITS), word)


def _write_near(word: str, name: str) -> tuple[Remedy, ...]:
    """The edit of a word of few letters in place of which only one can stand."""
    is_near = word.isalpha() and len(word) > 1 and (set(word) <= set(name) or word[:2] == name[:2])
    return write_words(word, name) if is_near else ()


def _jump(number: int, statement: Statement, at: int, parameters: QParameters) -> str | None:
    rest = statement.rest[at:].rstrip()
    match_defined = _DEFINITION_TEST.match(rest)
    if match_defined is not None and number == 9:
        name, wanted_state, quoted_name, digits, text = match_defined.groups()
        return (
            label_of(quoted_name, digits, text, parameters)
            if parameters.is_defined(name) == (wanted_state == "DEFINED")
            else None
        )
    relation = _RELATIONS[number]
    parts = [("IF", "IF"), ("value", VALUE), (relation, relation), ("value", VALUE), ("GOTO", "GOTO"), ("LBL", "LBL")]
    found, values = _match_parts(number, statement, at, [*parts, ("label", _ANY_LABEL)], parameters)
    label = found[-2]
    if not holds(relation, *values):
        return None
    quoted_name = label.strip('"') if label.startswith('"') else None
    return label_of(quoted_name, label, label if label.startswith("QS") else None, parameters)


def label_of(quoted_name: str | None, digits: str | None, text: str | None, parameters: QParameters) -> str:
    """The label that a call or a jump names."""
    if text is not None:
        return label_name(parameters.read_text(text))
    return label_name(quoted_name if quoted_name is not None else digits or "")
