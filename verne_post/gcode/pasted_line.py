"""The reader of a line: its words with columns and values, in each language; explain, hover and cycles use it.

`explain "G1 X10 F500"` shows those of every language that can read the whole line. The front ends compute values while
they read, and need the program for it; this reader has a line alone.

A value that is computed is not known here: only the program, and the place of the line in it, give it.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from types import MappingProxyType
from typing import Final, NamedTuple

from verne_post.base.printable import join_names
from verne_post.base.program_lines import find_machine_code, remove_remarks
from verne_post.gcode.apt import words as apt
from verne_post.gcode.block import KEYWORDS, raise_case
from verne_post.gcode.codes import RS274, describe_remap
from verne_post.gcode.klartext import vocabulary as klartext
from verne_post.gcode.klartext.words import WORD as WORD_OF_KLARTEXT
from verne_post.gcode.known_variables import describe_variable
from verne_post.gcode.known_words import (
    LANGUAGES,
    PAGES,
    GivenValue,
    describe_place,
    describe_values,
    list_meanings,
    list_parameters,
)
from verne_post.gcode.letters import (
    BESIDE_MOTION,
    LETTERS_OF_KLARTEXT,
    OF_CORNERS,
    OF_EXPRESSIONS,
    OF_FN,
    OF_FORMULAS,
    OF_LETTERS,
    OF_NAMES,
    WORDS_OF_STATEMENTS,
)
from verne_post.gcode.rs274.fanuc_codes import make_table
from verne_post.gcode.rs274.macro_text import number_argument
from verne_post.gcode.siemens import vocabulary as siemens

_BLANKS: Final = re.compile(r"[ \t]*")
_NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_BRACKET: Final = r"\[(?:[^][]|\[(?:[^][]|\[(?:[^][]|\[[^][]*\])*\])*\])*\]"
_PARENTHESES: Final = r"\((?:[^()]|\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\))*\)"
_TEXT: Final = r"\"[^\"]*\""
_MACRO_VARIABLE: Final = rf"#+\d+|#<[^<>]*>|#{_BRACKET}"
_MACRO_FUNCTION: Final = rf"[A-Z]{{2,5}}[ \t]*{_BRACKET}(?:[ \t]*/[ \t]*{_BRACKET})?"
_MACRO_VALUE: Final = rf"{_NUMBER}|[-+]?(?:{_MACRO_VARIABLE}|{_BRACKET}|{_MACRO_FUNCTION})"
_MACRO_OPERATOR: Final = r"[ \t]*(?:[-+*/]|(?:AND|OR|XOR|MOD|EQ|NE|LT|LE|GT|GE)(?![A-Z]))[ \t]*"
_KLARTEXT_NUMBER: Final = r"[-+]?[ \t]*(?:\d+[.,]?\d*|[.,]\d+|Q[LRS]?\d+)"
_OPERAND: Final = (
    rf"(?:[-+]|NOT[ \t]+|B_NOT[ \t]+)*[ \t]*(?:{_TEXT}|'[HB][\dA-F]+'|(?:\d+\.?\d*|\.\d+)(?:EX[-+]?\d+)?"
    rf"|[$A-Z_][\w$]*(?:[ \t]*(?:{_BRACKET}|{_PARENTHESES}))*|{_PARENTHESES})"
)
_OPERATOR: Final = r"[ \t]*(?:<<|==|<>|<=|>=|[-+*/<>]|(?:B_)?(?:AND|OR|XOR)\b|DIV\b|MOD\b)[ \t]*"
#: Longer ones are several words without a blank, as X1Y2 may be.
_SIEMENS_NAME: Final = r"[$A-Z_][\w$]{0,99}+"
_SIEMENS_VALUE: Final = rf"{_OPERAND}(?:{_OPERATOR}{_OPERAND})*"
#: What a name in an expression may be, apart from the functions and operators of the language.
_NAME: Final = re.compile(r"\"[^\"]*\"|\$?[A-Z_]\w*")
_MACRO_NAME: Final = re.compile(r"#<[^<>]*>|#\d+|[A-Z_]+")  # a number may touch an operator: #1EQ9
#: Words behind G65 that may be arguments, or before an F, so that a long line takes no time.
_MOST_WORDS: Final = 100
_OF_COMPUTED_VALUE: Final = "; computed: the value is known only in the program (explain FILE:LINE)"
#: How the text of a letter that moves an axis begins.
_OF_AXES: Final = ("where ", "by how much")
_FANUC: Final = make_table()
_REMARK: Final = "a remark; it moves nothing"
_MESSAGE: Final = r"\([ \t]*(?:MSG|DEBUG|PRINT|LOG)[ \t]*,[^)]*\)"
_OF_SKIPPED_BLOCKS: Final = "the block is executed, unless --block-delete is given"
#: First words of the statements of Klartext in which an axis may stand without a value.
_WITH_BARE_AXES: Final = ("TOOL", "BLK", "CYCL", "TRANS")
#: What an O word marks by its keyword, without END.
_MARKS: Final = {
    **dict.fromkeys(("DO", "WHILE", "REPEAT", "BREAK", "CONTINUE"), "mark of a loop"),
    **dict.fromkeys(("IF", "ELSEIF", "ELSE"), "mark of a branch"),
}
#: Name of a value that the call of an O word gives.
ARGUMENT: Final = "argument"
_OF_SUBPROGRAM: Final = "number or name of the subprogram"
#: Columns of a card that are read.
_CARD_COLUMNS: Final = 72
_CODE: Final = re.compile(r"([GM])[ \t]*0*(\d+(?:\.\d+)?)")
_IS_NUMBER: Final = re.compile(r"[-+]?[ \t]*[\d.,]+|\"[^\"]*\"|")
_MODE: Final = re.compile(rf"(AC|IC|DC|ACP|ACN)[ \t]*\([ \t]*({_NUMBER})[ \t]*\)")
_IS_KNOWN: Final = re.compile(rf"{_IS_NUMBER.pattern}|{_MODE.pattern}")
#: A value of a call, with what ends it; what stands between its name and the cycle.
_VALUE_OF_CALL: Final = re.compile(r"[ \t]*((?:\"[^\"]*\"|\([^()]*\)|[^,()\"])*)([,)]|$)")
_OF: Final = " of "
_MAY_HAVE_VALUES: Final = re.compile(r"\(|\bCYCL[ \t]+DEF\b", re.IGNORECASE)


#: A word, and a letter without its value: G64 P.
_WITH_BARE_LETTER: Final = re.compile(r"[ \t]*[A-Z]+[\d.]*[ \t]+[A-Z][ \t]*", re.IGNORECASE)
#: Of a value whose statement would say what it is.
_SAYS_NOTHING: Final = re.compile(r"a value of |its value$")
#: Letters of Siemens that mean the same beside most words.
_BARE_OF_SIEMENS: Final = (*"XYZABCFSIJK",)


#: What is passed as one word where it is not read.
_UNREAD: Final = r"[$#]?[A-Z_]+[-+\d.]*|[$#]+|[-+\d.]+|."


class UnreadWord(ValueError):
    """The word at which the language that came farthest stopped: its column, from 1, and what it would have read."""

    def __init__(self, column: int, word: str, languages: str, expected_words: str) -> None:
        pages = join_names([PAGES[one] for one in languages.split(", ")])
        super().__init__(
            f"column {column}: {word} is not read here; {languages}: {expected_words} may stand here (see {pages})"
        )
        self.column, self.word, self.languages, self.expected_words = column, word, languages, expected_words


@cache
def _list_texts(dialect: str) -> Mapping[str, str]:
    """The words of a dialect, each with what it does."""
    return {name: texts[0] for name, texts in list_meanings(dialect).items()}


class Word(NamedTuple):
    """A word of a line: where it begins and ends, its name, what it does, and its value, if it has one."""

    begin: int
    end: int
    name: str  #: As tables have it: G1 for G01.
    text: str
    value: str | None = None


class _Reader:
    """A line in one language: the place up to which it is read, and its words."""

    def __init__(self, line: str, dialect: str, remap: Mapping[str, str] = MappingProxyType({})) -> None:
        self.dialect, self.language = dialect, LANGUAGES[dialect]
        self.code = raise_case(line).rstrip()
        self.at, self.words = 0, list[Word]()
        self.texts = {**_list_texts(dialect), **{code: f'"{meaning}", says [remap]' for code, meaning in remap.items()}}
        self.statement: str | None = None  #: Of Klartext, once its own words have been read.
        self.told_names = set[str]()  #: Variables, functions and operators that need not be told again.
        self.takes_bare_letter = False  #: The last letter has no value: what it would say is asked.
        self.is_doubtful = False  #: A name of the program's own is assumed, which other languages do not need.
        self._pass_blanks()

    def _pass_blanks(self) -> None:
        self.at = _BLANKS.match(self.code, self.at).end()  # type: ignore[union-attr]

    @property
    def is_at_end(self) -> bool:
        return self.at >= len(self.code)

    def take(self, pattern: str | re.Pattern[str]) -> re.Match[str] | None:
        """What stands here, if it is that; the place is after it then."""
        match = re.compile(pattern).match(self.code, self.at)
        if match is None or match.end() == self.at:
            return None
        self.at = match.end()
        self._pass_blanks()
        return match

    def add(self, match: re.Match[str], text: str, group: str | int = 0, name: str = "") -> None:
        self.words.append(Word(*match.span(group), name or " ".join(match[group].split()), text))

    def take_word(self, pattern: str, text: str) -> bool:
        """Whether that stands here; it is told then."""
        match = self.take(pattern)
        if match is not None:
            self.add(match, text)
        return match is not None

    def refuse(self, expected_words: str, at: int | None = None) -> UnreadWord:
        at = self.at if at is None else at
        word = re.compile(rf"{_UNREAD}|$").match(self.code, at)
        return UnreadWord(at + 1, word[0] if word and word[0] else "the end", self.language, expected_words)

    def take_name(self, names: Mapping[str, str], most: int = 3) -> bool:
        """Whether one of some names stands here, of up to so many words; the longest is told."""
        for count in range(most, 0, -1):
            match = re.compile(rf"[A-Z$_][\w$.]*(?:[ \t]+[A-Z\d][\w.]*){{{count - 1}}}(?![\w=+-])").match(
                self.code, self.at
            )
            if match is not None and (name := " ".join(match[0].split())) in names:
                self.at = match.end()
                self._pass_blanks()
                self.add(match, names[name], name=name)
                return True
        return False

    def add_code(self, match: re.Match[str]) -> None:
        """A G or M code; an M code that the language does not have may get a meaning from the set-up."""
        code = _CODE.fullmatch(match[0])
        name = f"{code[1]}{code[2]}" if code else match[0]
        text = self.texts.get(name) or self.texts.get(name.removesuffix(".0"), "")
        is_lacking = not text and name[0] == "G"
        why_refused = "not known, and refused (VP002)"
        self.add(match, text or (why_refused if is_lacking else f"{why_refused}; {describe_remap(name)}"), name=name)
        if is_lacking:
            raise self.refuse("a G code that it has", match.start())

    def name_parts(self, begin: int, end: int) -> None:
        """The variables, functions and operators of an expression; raises :class:`UnreadWord` for what is none."""
        pattern = _MACRO_NAME if self.dialect in ("rs274", "fanuc") else _NAME
        for match in pattern.finditer(self.code, begin, end):
            name = match[0]
            is_index = self.code[match.start() - 1] + self.code[match.end() : match.end() + 1] == "[]"
            if name[0] == '"' or (is_index and self.dialect == "siemens"):  # of a system variable: $P_EP[X]
                continue
            text = OF_EXPRESSIONS.get(self.language, {}).get(name, "") or self.describe_variable(name)
            if not text and self.dialect == "siemens":
                text = self.texts.get(name, "")
            if not text and self.dialect == "siemens" and name not in ("TRUE", "FALSE", "EX", "PI"):
                text, self.is_doubtful = "a variable of the program, which DEF declares", True
            if not text and pattern is _MACRO_NAME and name[0] != "#":
                raise self.refuse("a variable, a number or a function", match.start())
            if text and name not in self.told_names:
                self.told_names.add(name)
                self.add(match, text)

    def describe_variable(self, name: str) -> str:
        """What a variable is; empty for other words."""
        if name.startswith("#<"):
            return "a variable with a name; one whose name begins with _ is of the whole program"
        if text := describe_variable(name).get(self.language, ""):
            return text
        is_index = self.dialect == "siemens"  # R[1] is R1
        letters = re.fullmatch(rf"(R|Q[LRS]?|#)\d{'*' if is_index else '+'}", name)
        return "" if letters is None else OF_NAMES[self.language].get(letters[1], "")

    def add_address(self, match: re.Match[str], name: str, value: str, text: str) -> None:
        """A letter or a name with its value."""
        is_known = _IS_KNOWN.fullmatch(value) or not re.search(r"[A-Z#$]", value)
        self.words.append(Word(*match.span(), name, text if is_known else f"{text}{_OF_COMPUTED_VALUE}", value))
        if not _IS_NUMBER.fullmatch(value):
            self.name_parts(match.end() - len(value), match.end())

    def add_bare_letter(self, match: re.Match[str], text: str) -> None:
        """A letter without its value, which its own letter stands for."""
        self.words.append(Word(*match.span(), match[0], text, match[0]))

    def list_words(self) -> list[Word]:
        """The words in their order; a letter as what it means beside the codes of its line."""
        words = sorted(self.words)
        codes, is_of_machine = list_codes(words), bool(find_machine_code(self.code, self.dialect))
        return [
            word._replace(text=self._describe(word, words, codes, is_of_machine=is_of_machine)) if word.value else word
            for word in words
        ]

    def _describe(self, word: Word, words: Sequence[Word], codes: Sequence[str], *, is_of_machine: bool) -> str:
        """What a word with a value does; the places of the line may be those of the machine."""
        name, value, text = word.name, word.value or "", word.text.removesuffix(_OF_COMPUTED_VALUE)
        tail = word.text.removeprefix(text)  # that it is computed
        mode = _MODE.fullmatch(value)
        if beside := find_beside(word, words, codes, self.dialect)[1]:
            return f"{beside.format(value.strip().removeprefix('+').rstrip('.'))}{tail}"
        if not tail and name.removeprefix("I") in [*"XYZABCUVW"] and text.startswith(_OF_AXES):
            shown_text, end = describe_place(name, mode[2] if mode else value, self.dialect), "; in G91 on by that much"
            if is_of_machine:
                return f"{shown_text.removesuffix(end)}, in machine coordinates"
            is_step = mode is not None and mode[1] == "IC"
            return shown_text.removesuffix(end).replace(" to ", " on by ", is_step) if mode else shown_text
        if name == "S" and "G96" in codes:
            return f"speed of the surface, in m/min{tail}"
        if name in ("F", "S") and text in ("feed rate", "spindle speed"):
            return f"{siemens.ADDRESSES[name]}{tail}"
        if name in [*"PQLEKR"] and (code := _find_taking_code(name, codes, self.dialect)):
            return word.text if name == "R" and code[0] != "M" else f"a value of {code}{tail}"
        return word.text


def _find_taking_code(letter: str, codes: Sequence[str], dialect: str) -> str:
    """The code of a line whose value a letter is, in RS274/NGC and Fanuc; empty where none is."""
    if dialect not in ("rs274", "fanuc"):
        return ""
    table = _FANUC if dialect == "fanuc" else RS274
    for one in codes:
        if code := _CODE.fullmatch(one):
            number, of_code = float(code[2]), table.words_of_g if code[1] == "G" else table.words_of_m
            if letter in of_code.get(round(10 * number if code[1] == "G" else number), ""):
                return one
    return ""


def list_codes(words: Sequence[Word]) -> list[str]:
    """The codes of a line, beside which its letters may mean something else, as tables of letters have them."""
    names = [word.name for word in words]
    kinds = [f"G10 L{word.value.lstrip('0')}" for word in words if word.name == "L" and word.value]
    heads = [" ".join(name.split()[:2]) for name in names if " " in name]  # TRANS DATUM AXIS
    return sorted(dict.fromkeys([*kinds[: "G10" in names], *names, *heads]), key=lambda one: one in BESIDE_MOTION)


def find_beside(word: Word, words: Sequence[Word], codes: Sequence[str], dialect: str) -> tuple[str, str]:
    """The code beside which a letter of a line means something else, and what, with {} for its value; empty without."""
    if word.name[0] == ",":
        return ",", OF_CORNERS[word.name[1:]]
    if dialect == "fanuc" and ("G65" in codes or "G66" in codes):
        at, call = next((at, one) for at, one in enumerate(words) if one.name in ("G65", "G66"))
        letters = [one.name for one in words[at + 1 : at + _MOST_WORDS] if one.begin <= word.begin and one.value]
        is_argument = call.begin < word.begin <= words[at + 1 : at + _MOST_WORDS][-1].begin
        if is_argument and (number := number_argument("".join(letters))):
            return call.name, f"argument #{number} of the macro: {{}}"
    of_codes = OF_LETTERS.get(dialect, {})
    code = next((one for one in codes if word.name in of_codes.get(one, {})), "")
    return code, of_codes[code][word.name] if code else ""


def describe_pasted(line: str) -> list[str]:
    """The words of a line, each with what it does below it, by language; empty for a line without words.

    Raises
    ------
    UnreadWord
        No language can read the whole line.
    """
    readers, stops = _read_in_all(line)
    if not readers and _WITH_BARE_LETTER.fullmatch(line):
        readers, _ = _read_in_all(line, takes_bare_letter=True)
    if not {"heidenhain", "aptcl"} & {one.dialect for one in readers}:
        readers += _read_alone(line, is_read=bool(readers))
    readers = [one for one in readers if not one.is_doubtful] or readers
    if not readers and stops:
        last = max(stops, key=lambda stop: stop.column)
        languages = [
            stop.languages for stop in stops if (stop.column, stop.expected_words) == (last.column, last.expected_words)
        ]
        raise UnreadWord(last.column, last.word, ", ".join(languages), last.expected_words)
    found = dict[tuple[int, int], dict[str, list[str]]]()
    for reader in readers:
        for word in reader.list_words():
            texts = found.setdefault((word.begin, -word.end), {})
            texts.setdefault(word.text, []).append(reader.language)
    lines = list[str]()
    for (begin, end), texts in sorted(found.items()):
        lines += [" ".join(line[begin:-end].split()), *(f"  {', '.join(of)}: {text}" for text, of in texts.items())]
    return lines


def _read_in_all(line: str, *, takes_bare_letter: bool = False) -> tuple[list[_Reader], list[UnreadWord]]:
    """A line in the languages that read it, and where the others stop."""
    readers, stops = list[_Reader](), list[UnreadWord]()
    for dialect, read in _READERS.items():
        reader = _Reader(line, dialect)
        reader.takes_bare_letter = takes_bare_letter
        try:
            read(reader)
        except UnreadWord as stop:
            stops.append(stop)
        else:
            readers.append(reader)
    return readers, stops


def _read_alone(line: str, *, is_read: bool) -> Iterator[_Reader]:
    """A word with its value that begins no line, read as within its statements: SPA+20, SQRT[4], RAPTO,3.

    Of Klartext also several, as after a ~, unless another language has read them (``is_read``).
    """
    told_texts = set[str]()
    for dialect, read, heads in (
        ("rs274", _read_function, ("",)),
        ("fanuc", _read_function, ("",)),
        ("heidenhain", _read_klartext_words, tuple(WORDS_OF_STATEMENTS)),
        ("aptcl", _read_apt_words, tuple(apt.WORDS_OF) if "," in line else ()),
    ):
        for head in heads:
            reader = _Reader(line, dialect)
            try:
                read(reader, head)
            except UnreadWord:
                continue
            words = reader.list_words()
            if not words or words[0].text in told_texts or any(_SAYS_NOTHING.match(word.text) for word in words):
                continue
            first = words[0]
            if dialect == "heidenhain":
                if first.end < len(reader.code) and (is_read or head not in ("*", "PLANE")):
                    continue  # several words
                if told_texts:  # what its value is of has been told
                    reader.words = [word for word in reader.words if word.begin == first.begin]
                told_texts.add(first.text)
            is_general = head in ("", "*") or first.text == OF_NAMES.get(reader.language, {}).get(first.name)
            reader.language += "" if is_general else f", in {head}"
            yield reader


def find_words(
    line: str, dialect: str, *, is_continued: bool = False, remap: Mapping[str, str] = MappingProxyType({})
) -> list[Word]:
    """The words of a line of a program, without remarks, and what each does; what is not read is left out.

    ``is_continued``: the line goes on with a cycle of Klartext that an earlier one begins. ``remap`` are codes that a
    set-up gives a meaning.
    """
    reader, read = _Reader(remove_remarks(line, dialect), dialect, remap), _READERS[dialect]
    if is_continued:
        read = _read_klartext_words
    while not reader.is_at_end:
        try:
            read(reader)
        except UnreadWord as stop:
            if reader.at < stop.column:  # else the word has been passed
                reader.at = stop.column - 1
                reader.take(_UNREAD)
            if dialect == "heidenhain" and reader.statement is not None:
                read = partial(_read_klartext_words, statement=reader.statement)
    return [word._replace(text=word.text.removesuffix(_OF_COMPUTED_VALUE)) for word in reader.list_words()]


def find_cycle_call(line: str, dialect: str) -> Word | None:
    """The first call or definition of a cycle that has values in a line."""
    words = find_words(line, dialect) if _MAY_HAVE_VALUES.search(line) else []  # programs of many lines are searched
    return next((word for word in words if describe_values(word.name, dialect)), None)


def find_given_values(lines: Sequence[str], number: int, dialect: str) -> dict[str, GivenValue]:
    """The values that the call of a cycle at a 1-based line gives, by their names."""
    found = dict[str, GivenValue]()
    for at, line in enumerate(lines[number - 1 :], start=number):
        for word in find_words(line, dialect, is_continued=at > number):
            name, is_value, _cycle = word.name.partition(_OF)
            if word.value and (is_value or (dialect == "heidenhain" and re.fullmatch(r"Q\d+", name))):
                found[name] = GivenValue(at, word.end - len(word.value), line[word.end - len(word.value) : word.end])
        if dialect != "heidenhain" or not line.rstrip().endswith("~"):
            break
    return found


# --- RS274/NGC and Fanuc -------------------------------------------------------------------------


def _read_macro(r: _Reader) -> None:
    """A line of RS274/NGC or Fanuc."""
    is_fanuc = r.dialect == "fanuc"
    keywords = OF_EXPRESSIONS["Fanuc"]
    letters = OF_NAMES[r.language]
    r.take_word(r"/\d?", _OF_SKIPPED_BLOCKS)
    while not r.is_at_end:
        if not is_fanuc and r.take_word(
            r"\([ \t]*(?:MSG|DEBUG|PRINT|LOG)[ \t]*,[^)]*\)", "a message; it moves nothing"
        ):
            continue
        if r.take_word(r"\([^)]*\)|;.*", _REMARK) or r.take_word("%", "the text of the program begins, or ends"):
            continue
        if match := r.take(rf"(?:O|{':' if is_fanuc else 'O'})[ \t]*(?:<[^<>]*>|\d+|{_MACRO_VARIABLE}|{_BRACKET})"):
            keyword = None if is_fanuc else r.take(rf"(?:{'|'.join(sorted(KEYWORDS, key=len, reverse=True))})(?![A-Z])")
            text = _MARKS.get(keyword[0].removeprefix("END"), _OF_SUBPROGRAM) if keyword else letters["O"]
            r.words.append(Word(*match.span(), "mark" if keyword else "O", text, match[0][1:].strip()))
            if keyword is not None:
                r.add(keyword, OF_EXPRESSIONS[r.language][keyword[0]])
                text = "condition" if keyword[0] in ("IF", "ELSEIF", "WHILE") else f"value of {keyword[0].lower()}"
                number = 0
                while value := r.take(_BRACKET):
                    number += 1
                    if keyword[0] == "CALL":
                        r.add(value, f"becomes #{number} of {match[0].strip().lower()}", name=ARGUMENT)
                    else:
                        r.add(value, text)
                    r.name_parts(*value.span())
        elif match := r.take(rf"({_MACRO_VARIABLE})[ \t]*=[ \t]*"):
            name = match[1]
            r.add(match, f"sets {name}: {r.describe_variable(name) or letters['#']}", 1)
            r.told_names.add(name)
            _take_macro_value(r)
        elif is_fanuc and (match := r.take(r"(IF|WHILE|THEN|GOTO|DO|END)(?![A-Z])")):
            r.add(match, keywords[match[0]])
            if match[0] != "THEN":
                _take_macro_value(r)
            after = {"IF": ("GOTO or THEN", r"(?=GOTO|THEN)"), "WHILE": ("DO and a number", r"(?=DO)")}.get(match[0])
            if after and not re.compile(after[1]).match(r.code, r.at):
                raise r.refuse(after[0])
        elif is_fanuc and (match := r.take(rf",[ \t]*([RCA])[ \t]*({_MACRO_VALUE})")):
            r.add_address(match, f",{match[1]}", match[2], "")
        elif match := r.take(r"[GM][ \t]*\d+(?:\.\d+)?"):
            r.add_code(match)
        elif match := r.take(rf"([GMNA-Z@^])[ \t]*({_MACRO_VALUE})"):
            of_polar = {"@": "polar radius", "^": "polar angle, degrees"}
            text = of_polar.get(match[1]) or letters.get(match[1], "number that the code of the block takes")
            text = letters.get("".join(match[0].split()), text)  # D0
            r.add_address(match, match[1], match[2], text)
        elif r.takes_bare_letter and (match := r.take(rf"[{''.join(name for name in letters if name.isalpha())}]$")):
            r.add_bare_letter(match, letters[match[0]])
        else:
            raise r.refuse("a letter with a value such as X1.5, a G or M code, or #1=2")


def _read_function(r: _Reader, _head: str) -> None:
    """A function of RS274/NGC or Fanuc with its value."""
    if not re.compile(_MACRO_FUNCTION).fullmatch(r.code, r.at):
        raise r.refuse("a function with its value")
    _take_macro_value(r)


def _take_macro_value(r: _Reader) -> None:
    more = rf"(?:{_MACRO_OPERATOR}(?:{_MACRO_VALUE}))*" if r.dialect == "fanuc" else ""
    value = r.take(rf"(?:{_MACRO_VALUE}){more}")
    if value is None:
        raise r.refuse("a number, a variable or an expression in [ ]")
    r.name_parts(*value.span())


# --- Siemens -------------------------------------------------------------------------------------


def _read_siemens(r: _Reader) -> None:
    r.take_word(r"/\d?", _OF_SKIPPED_BLOCKS)
    if match := r.take(r"[A-Z_]\w+[ \t]*:(?!=)"):
        if match[0].rstrip(" \t:") in r.texts:
            raise r.refuse("a label, or a word", match.start())
        r.add(match, "label, to which GOTOF, GOTOB and GOTO jump")
    while not r.is_at_end:
        if r.take_word(";.*", _REMARK) or r.take_word("%.*", "the text of the program begins: its name"):
            continue
        if match := r.take(rf"({_SIEMENS_NAME}(?:[ \t]*{_BRACKET})?)[ \t]*=[ \t]*(?!=)"):
            _read_assignment(r, match)
        elif match := r.take(rf"({_SIEMENS_NAME})[ \t]*(?=\()({_PARENTHESES})"):
            _read_call(r, match)
        elif match := r.take(rf"({'|'.join(list_parameters())})[ \t]*(\([^()]*)$"):
            _read_call(r, match)
            raise r.refuse("a closing parenthesis")
        elif match := r.take(r"G[ \t]*\d+(?![\w.])|M[ \t]*\d+(?![\w.])|G\d+(?=[A-Z])|M\d+(?=[A-Z])"):
            r.add_code(match)
        elif match := r.take(rf"([A-Z])[ \t]*({_NUMBER})(?!\d)"):
            if match[1] not in siemens.ADDRESSES or match[1] in "GM":
                raise r.refuse("a word of Siemens", match.start())
            r.add_address(match, match[1], match[2], siemens.ADDRESSES[match[1]])
        elif match := r.take(r"[A-Z_]\w*"):
            _read_bare(r, match)
        else:
            raise r.refuse("a word such as X1.5, CR=2 or TRAORI, or a variable such as R1=2")


def _read_assignment(r: _Reader, match: re.Match[str]) -> None:
    value = r.take(_SIEMENS_VALUE)
    if value is None:
        raise r.refuse("a value")
    name = match[1].split("[")[0].strip()
    whole = re.compile(re.escape(r.code[match.start() : value.end()])).match(r.code, match.start())
    assert whole is not None
    if name in siemens.ADDRESSES:
        r.add_address(whole, name, value[0], siemens.ADDRESSES[name])
    elif text := r.texts.get(name) or r.describe_variable(name):
        r.add(match, f"sets {match[1]}: {text}" if r.describe_variable(name) else text, 1)
        r.told_names.add(name)
        r.name_parts(*value.span())
    else:
        r.is_doubtful = True
        r.add(match, f"sets {match[1]}, a variable of the program, which DEF declares", 1)
        r.name_parts(*value.span())


def _read_call(r: _Reader, match: re.Match[str]) -> None:
    name = match[1]
    if name in ("IF", "WHILE", "UNTIL", "CASE"):
        r.add(match, r.texts[name], 1)
        r.name_parts(*match.span(2))
        more = r.take(rf"{_OPERATOR}{_SIEMENS_VALUE}")
        if more is not None:
            r.name_parts(*more.span())
        return
    why_refused = siemens.explain_refusal(name)
    text = r.texts.get(name) or ("" if why_refused is None else f"not executed: {why_refused}")
    if not text and re.match(r"CYCLE|E_|F_", name):
        raise r.refuse("a cycle that it has", match.start())
    r.is_doubtful |= not text
    r.add(match, text or "calls a subprogram of this name with these values; PROC begins it", 1)
    names = list_parameters().get(name)
    if names is None:
        if r.code[match.start(2) + 1 : match.end(2) - 1].strip():
            r.add(match, "its values", 2)
            r.name_parts(*match.span(2))
        return
    for own, value in zip(names, _VALUE_OF_CALL.finditer(r.code, match.start(2) + 1), strict=False):
        if shown_value := value[1].rstrip():
            meaning, begin = siemens.CYCLE_VALUES.get(own, ""), value.start(1)
            text = f"{own}{_OF}{name}{': ' * bool(meaning)}{meaning}"
            r.words.append(Word(begin, begin + len(shown_value), f"{own}{_OF}{name}", text, shown_value))
        if value[2] != ",":
            return
    if r.code[match.start(2) + 1 : match.end(2) - 1].count(",") >= len(names):
        raise r.refuse(f"at most {len(names)} values of {name}", match.start())


def _read_bare(r: _Reader, match: re.Match[str]) -> None:
    """A word without a value, and what belongs to it: a label, a condition, a declaration."""
    name = match[0]
    if r.takes_bare_letter and r.is_at_end and name in _BARE_OF_SIEMENS:
        r.add_bare_letter(match, siemens.ADDRESSES[name])
        return
    text = r.texts.get(name, "")
    needs_value = (*siemens.ADDRESSES, *siemens.VALUE_MODES, *OF_EXPRESSIONS["Siemens"])
    if not text or (name in needs_value and name != "M1"):
        raise r.refuse("a word such as X1.5, CR=2 or TRAORI, or a variable such as R1=2", match.start())
    r.add(match, text)
    if name in ("IF", "WHILE", "UNTIL", "CASE"):
        value = r.take(_SIEMENS_VALUE)
        if value is None:
            raise r.refuse("a condition")
        r.name_parts(*value.span())
        r.take_word(r"OF\b", "the values follow, each with the jump to its label")
        while number := r.take(rf"{_NUMBER}(?=[ \t]+GOTO)"):
            r.add(number, "if the value is this")
            jump = r.take(r"GOTO[FBC]?")
            label = r.take(r"\w+")
            if jump is None or label is None:
                raise r.refuse("GOTOF and a label")
            r.add(jump, r.texts[jump[0]])
            r.add(label, "the label, or block, to which it jumps")
        r.take_word(r"DEFAULT\b", "if the value is none of them")
    elif name.startswith("GOTO"):
        r.take_word(rf"{_TEXT}|\w+", "the label, or block, to which it jumps")
    elif name in ("REPEAT", "REPEATB"):
        while r.take_word(r"(?!P[ \t]*=)[A-Z_]\w*", "a label of the lines that are repeated"):
            pass
    elif name in ("CALL", "EXTCALL", "EXTERN"):
        r.take_word(rf"{_TEXT}|[A-Z_]\w*(?:[ \t]*{_PARENTHESES})?", "the subprogram")
    elif name == "FOR":
        counter = r.take(r"([A-Z_]\w*)[ \t]*=[ \t]*")
        first, to, last = r.take(_SIEMENS_VALUE), r.take(r"TO\b"), r.take(_SIEMENS_VALUE)
        if counter is None or first is None or to is None or last is None:
            raise r.refuse("a variable, its first value, TO, and its last value")
        r.add(counter, "the variable that counts", 1)
        r.add(to, OF_EXPRESSIONS["Siemens"]["TO"])
    elif name in ("DEF", "PROC"):
        _read_declaration(r, name)


def _read_declaration(r: _Reader, name: str) -> None:
    kinds = {**OF_EXPRESSIONS["Siemens"], "AXIS": "the name of an axis, as a type", "FRAME": "a frame, as a type"}
    if name == "PROC":
        r.take_word(r"[A-Z_]\w*", "the name of the subprogram")
        if values := r.take(_PARENTHESES):
            r.add(values, "its parameters, each with its type")
            for kind in re.compile(rf"\b(?:{'|'.join(kinds)})\b").finditer(r.code, *values.span()):
                r.add(kind, kinds[kind[0]])
        return
    if not any(r.take_word(rf"{kind}\b(?:[ \t]*\[\d+\])?", text) for kind, text in kinds.items()):
        raise r.refuse("a type: REAL, INT, BOOL, CHAR, STRING")
    while variable := r.take(rf"([A-Z_]\w*(?:[ \t]*{_BRACKET})?)(?:[ \t]*=[ \t]*(?:{_SIEMENS_VALUE}))?[ \t]*,?"):
        r.add(variable, "a variable of the program; its value is 0, or the one given", 1)


# --- Klartext ------------------------------------------------------------------------------------


def _read_klartext(r: _Reader) -> None:
    r.take_word(r"/", _OF_SKIPPED_BLOCKS)
    r.take_word(r"\d+(?=[ \t]+\S)", "block number")
    r.take_word(r"DECLARE[ \t]+STRING\b(?=[ \t]+QS)", "a text parameter follows")
    if r.take_word(r"\*.*|;.*", "a remark, or the title of a section; it moves nothing"):
        return
    if not (match := _take_statement(r)):
        first = re.compile(r"([A-Z]+)[ \t]+").match(r.code, r.at)
        seconds = [one.split()[1] for one in klartext.STATEMENTS if first and one.startswith(f"{first[1]} ")]
        if first and seconds:
            raise r.refuse(f"{' or '.join(seconds)} after {first[1]}", first.end())
        raise r.refuse("a statement such as L, CYCL DEF or TOOL CALL")
    name = " ".join(match[0].split())
    if name in ("PLANE", "FUNCTION", "TRANS", "APPR", "DEP", "CYCL"):
        own = WORDS_OF_STATEMENTS[name]
        if not any(re.compile(rf"{re.escape(one)}(?!\w)").match(r.code, r.at) for one in own):
            raise r.refuse(f"a word of {name}")
    if name in ("BEGIN PGM", "END PGM"):
        r.take_word(r".*?(?=[ \t]+(?:MM|INCH)[ \t]*$)", "name of the program")
        r.take_word(r"MM|INCH", "unit of all lengths")
    elif name == "FN":
        _read_fn(r)
    elif name in ("LBL", "CALL LBL", "CALL PGM", "SEL TABLE", "TOOL CALL", "TOOL DEF", "CALL SELECTED PGM"):
        whose = {
            "L": "label: its number or name",
            "P": "the program",
            "T": "the datum table",
            "D": "tool: its number or name",
        }
        what = whose[
            "T" if name == "SEL TABLE" else "P" if name.endswith("PGM") else "L" if name.endswith("LBL") else "D"
        ]
        pattern = r"[^\s;~]+" if name == "CALL PGM" else r"\d+(?:\.\d+)?|QS?\d+"
        if value := r.take(rf"{_TEXT}|{pattern}"):
            r.words[-1:] = [r.words[-1]._replace(value=value[0]), Word(*value.span(), name, what, value[0])]
    elif name == "CYCL DEF":
        _read_cycle(r)
    elif re.fullmatch(r"Q[LRS]?", name):
        _read_formula(r, match)
    r.statement = name
    _read_klartext_words(r, name)


def _read_klartext_words(r: _Reader, statement: str = "CYCL DEF") -> None:
    while not r.is_at_end:
        if r.take_word(r";.*?(?=~|$)", _REMARK) or r.take_word("~", "the statement goes on in the next line"):
            continue
        _read_klartext_word(r, statement)


@cache
def _list_statements() -> list[tuple[str, re.Pattern[str]]]:
    """The keywords of statements, the longest first; M, F, S and compensation are words, and stay."""
    firsts = {name.split()[0] for name in klartext.STATEMENTS if " " in name} | {"PLANE", "FUNCTION", "TRANS"}
    phrases = {name for name in _list_texts("heidenhain") if " " in name and name.split()[0] in firsts}
    phrases = {name for name in phrases if not re.fullmatch(r"CYCL DEF \d+", name)}
    names = sorted({*klartext.STATEMENTS, *klartext.REFUSED_STATEMENTS, *phrases}, key=len, reverse=True)
    ends = dict.fromkeys(("L", "C"), r"(?=[ \t]|$)")
    ends |= dict.fromkeys(("M", "F", "S"), r"(?=[ \t]*[\d.,QMAU])") | dict.fromkeys(("R0", "RL", "RR"), r"(?!\w)")
    ends = {name: r"(?=[ \t]*\d+[ \t]*=)" if name[0] == "Q" else r"(?![A-Z])" for name in names} | ends
    return [(name, re.compile(r"[ \t]+".join(map(re.escape, name.split())) + ends[name])) for name in names]


def _take_statement(r: _Reader) -> re.Match[str] | None:
    """The keyword of a statement, which is told."""
    first = r.code[r.at : r.at + 1]
    for name, pattern in _list_statements():
        if name[0] != first:
            continue
        if name in ("M", "F", "S", "R0", "RL", "RR"):
            if pattern.match(r.code, r.at):
                return re.compile(r"").match(r.code, r.at)
        elif match := r.take(pattern):
            text = r.texts.get(name, "")
            if name in klartext.REFUSED_STATEMENTS:
                r.add(match, text)
                r.take_word(r"[^;]+", "its values")
            elif name[0] != "Q" and name not in ("CYCL DEF", "FN"):
                r.add(match, text)
            return match
    return None


def _read_fn(r: _Reader) -> None:
    match = r.take(r"(\d+)[ \t]*:")
    name = f"FN {int(match[1])}" if match else ""
    if match is None or name not in r.texts:
        raise r.refuse("the number of a function of FN, and a colon")
    begin = r.code.rindex("FN", 0, match.start())
    r.words.append(Word(begin, match.end(1), name, r.texts[name]))
    if int(match[1]) > 13:
        r.take_word(r"[^;]+", "what it is about")
        return
    while not r.is_at_end and r.code[r.at] != ";":
        if variable := r.take(r"[-+]?(Q[LRS]?\d+)"):
            r.add(variable, r.describe_variable(variable[1]))
        elif not (r.take(r"[-+*/=]|[-+]?[\d.,]+") or r.take_word(_TEXT, "a label") or r.take_name(OF_FN, 2)):
            raise r.refuse("a number, a Q parameter, or a word of FN")


def _read_formula(r: _Reader, keyword: re.Match[str]) -> None:
    match = r.take(r"(\d+)[ \t]*=[ \t]*")
    assert match is not None
    name = f"{keyword[0]}{match[1]}"
    of_cycles = klartext.describe_parameter(int(match[1])) if keyword[0] == "Q" else ""
    text = f"sets {name}: {r.describe_variable(name)}{f'; in cycles: {of_cycles}' * bool(of_cycles)}"
    r.words.append(Word(keyword.start(), match.end(1), name, text))
    while not r.is_at_end and r.code[r.at] not in ";~":
        if variable := r.take(r"Q[LRS]?\d+"):
            r.add(variable, r.describe_variable(variable[0]))
        elif not (r.take(rf"[-+*/^()%|]|[\d.,]+|{_TEXT}") or r.take_name(OF_FORMULAS, 1)):
            raise r.refuse("a number, a Q parameter, a function or a sign of a formula")


def _read_cycle(r: _Reader) -> None:
    match = r.take(r"(\d+)(?:\.\d+)?")
    name = f"CYCL DEF {int(match[1])}" if match else ""
    if match is None or name not in r.texts:
        raise r.refuse("the number of a cycle that it has")
    begin = r.code.rindex("CYCL", 0, match.start())
    r.words.append(Word(begin, match.end(), name, r.texts[name]))
    if not re.compile(r"(?:ROT|SCL|F|V\.?ZEIT|DWELL)[ \t]*[-+\d]|[TPR]?I?[A-Z]?[ \t]*[-+\d#]|Q\d").match(r.code, r.at):
        r.take_word(
            r"(?![XYZ](?!\w))[A-Z][^\d~;=#]*?(?=[ \t]*(?:~|;|$)|[ \t]+(?:Q\d|[XYZABC][-+\d]))",
            "name of the cycle; it is a remark",
        )


def _read_klartext_word(r: _Reader, statement: str) -> None:
    first = statement.partition(" ")[0]
    own = WORDS_OF_STATEMENTS.get(first, {})
    names = "|".join(map(re.escape, sorted(own, key=len, reverse=True)))
    if match := r.take(rf"(Q\d+)[ \t]*=[ \t]*(F?(?:MAX|AUTO)|PREDEF|{_KLARTEXT_NUMBER})"):
        meaning = klartext.describe_parameter(int(match[1][1:])) or "a value of the cycle"
        is_number = re.fullmatch(r"[-+ \d.,]+|[A-Z]+", match[2])
        text = meaning if is_number else f"{meaning}{_OF_COMPUTED_VALUE}"
        r.words.append(Word(*match.span(), match[1], text, match[2]))
    elif re.compile(r"F[ \t]*(?:MAX|AUTO)(?![A-Z])").match(r.code, r.at):
        match = r.take(r"F[ \t]*(MAX|AUTO)")
        assert match is not None
        r.add(match, klartext.WORDS["FMAX" if match[1] == "MAX" else "F AUTO"])
    elif own and (match := r.take(rf"({names})[ \t]*:?[ \t]*({_KLARTEXT_NUMBER})")):
        r.add_address(match, match[1], match[2], own[match[1]])
    elif r.take_name({**klartext.WORDS, **own}, 2):
        pass
    elif own and (match := r.take(rf"({names})(?![A-Z])")):
        r.add(match, own[match[1]])
    elif first == "PATTERN" and r.take(r"[()]"):
        pass
    elif match := r.take(WORD_OF_KLARTEXT):
        _add_klartext_word(r, match, statement)
    elif statement in ("RND", "CHF", "CYCL DEF", "CALL LBL", "TRANS") and (match := r.take(_KLARTEXT_NUMBER)):
        r.add(match, {"RND": "radius", "CHF": "length on each line"}.get(statement, "its value"))
    elif first in _WITH_BARE_AXES and (match := r.take(r"[XYZ](?![\w+-])")):
        r.add(match, "the tool axis" if statement[:4] in ("TOOL", "BLK ") else "mirror image of this axis")
    else:
        raise r.refuse(f"a word of {statement or 'a block'}, such as X+10, F500, FMAX or M3")


def _add_klartext_word(r: _Reader, match: re.Match[str], statement: str) -> None:
    begin = match.end() - len(match[0].lstrip())
    word = re.compile(re.escape(match[0].lstrip())).match(r.code, begin)
    assert word is not None
    if match["m"]:
        r.add_code(word)
    elif match["name"]:
        name, value = match["name"], match["value"]
        text = LETTERS_OF_KLARTEXT.get(name) or OF_NAMES["Klartext"].get(name, "") or r.texts.get(name, "")
        if name == "F" and statement == "TOOL CALL":
            text = "feed rate in mm/min, from here on and of F AUTO"
        elif name == "F":
            in_force = klartext.STATEMENTS["F"] if statement != "RND" else "feed rate of this rounding alone"
            in_force = "feed rate of the turn of the rotary axes" if statement.startswith("PLANE") else in_force
            last_words = reversed(r.words[-_MOST_WORDS:])
            last = next((one.name for one in last_words if _CODE.fullmatch(one.name)), "")
            text = klartext.FEED_OF_FUNCTIONS.get(last, in_force)
        elif name == "R" and not statement:
            text = "radius"
        r.add_address(word, name, value, text or WORDS_OF_STATEMENTS["*"].get(name, f"a value of {statement}"))
    elif match["comp"]:
        r.add(word, klartext.STATEMENTS.get(match["comp"], "compensation of a move along one axis, which is refused"))
    elif match["rotation"]:
        r.add(word, LETTERS_OF_KLARTEXT["".join(match["rotation"].split())])
    elif match["max"]:
        r.add(word, "retracts to the end of the travel")
    elif match["axis"]:
        r.add(word, "the rotary axis that the M function is for")
    else:
        r.add(word, klartext.WORDS["R F M"])


# --- CL files --------------------------------------------------------------------------------------


def _read_apt(r: _Reader) -> None:
    r.take_word(r"\d+(?=[ \t]+[A-Z])", "number of the line")
    if r.take_word(
        r"[-+]?[\d.](?=[-+.\dED \t]{0,40}+,)[-+.,\dED \t]*+\$?$", "numbers of the statement that the line before begins"
    ):
        return
    if r.take_word(r"\$\$.*", "a remark; a system of coordinates in it counts"):
        return
    free = ("PARTNO", "PPRINT", "REMARK", "INSERT")
    with_slash = r"(TLON)[ \t]*,[ \t]*GOFWD(?=[ \t]*/)|TOOL[ \t]+PATH(?=[ \t]*/)|END-OF-PATH"
    major = r.take(rf"{with_slash}|(?:{'|'.join(free)})|[A-Z][A-Z\d_]*(?=[ \t]*(?:/|\$\$|$))")
    name = "" if major is None else major[1] or " ".join(major[0].split())
    text = r.texts.get(name, "")
    if major is None or not text:
        raise r.refuse("a statement of CL files such as GOTO/1,2,3", None if major is None else major.start())
    r.add(major, text)
    r.take("/")
    if name in (*free, *apt.REMARKS, *apt.WITHOUT_EFFECT, *apt.REFUSED_WORDS, "TOOL PATH", "TOOLNO"):
        r.take_word(r".+", "its text")
        return
    _read_apt_words(r, name)


def _read_apt_words(r: _Reader, name: str) -> None:
    """What may follow the slash of a statement."""
    own, last = apt.WORDS_OF.get(name, {}), name
    while not r.is_at_end:
        if r.take_word(r"\$\$.*", _REMARK) or r.take_word(r"\$.*", "the statement goes on in the next line"):
            continue
        if r.at >= _CARD_COLUMNS and r.take_word(r"[A-Z]{2,3} +\d+$", "the name that the CAM system gives the point"):
            continue
        number = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[ED][-+]?\d+)?"
        if match := r.take(rf"{number}(?:[ \t]*,[ \t]*{number})*(?![\w.])"):
            n_numbers = match[0].count(",") + 1
            of_numbers = apt.NUMBERS_OF.get((last, n_numbers)) or apt.NUMBERS_OF.get((last, 0))
            r.add(match, of_numbers or (f"value of {last}" if last != name else f"value of {name}"))
        elif match := r.take(r"[A-Z\d][A-Z\d_-]*"):
            if match[0] not in own:
                raise r.refuse(f"{', '.join(own) or 'numbers'} after {name}/", match.start())
            r.add(match, own[match[0]])
            last = match[0]
        elif not r.take(r"[,()/=]+"):
            raise r.refuse("numbers and words between commas")


_READERS: Final[Mapping[str, Callable[[_Reader], None]]] = {
    "rs274": _read_macro,
    "fanuc": _read_macro,
    "siemens": _read_siemens,
    "heidenhain": _read_klartext,
    "aptcl": _read_apt,
}
