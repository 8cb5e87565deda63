"""A line in one language: the place up to which it is read, and its words. Each language has its own grammar.

The grammars are the files ``line_words.py`` of the packages of languages; :mod:`verne_post.gcode.pasted_line` has the
table of them.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Final, NamedTuple

from msgspec import Struct

from verne_post.base.printable import join_names
from verne_post.gcode.block import raise_case
from verne_post.gcode.codes import describe_remap
from verne_post.gcode.known_variables import describe_variable
from verne_post.gcode.known_words import LANGUAGES, PAGES, list_meanings
from verne_post.gcode.letters import OF_EXPRESSIONS, OF_NAMES

_BLANKS: Final = re.compile(r"[ \t]*")
NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)"
BRACKET: Final = r"\[(?:[^][]|\[(?:[^][]|\[(?:[^][]|\[[^][]*\])*\])*\])*\]"
PARENTHESES: Final = r"\((?:[^()]|\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\))*\)"
TEXT: Final = r"\"[^\"]*\""
#: What a name in an expression may be, apart from the functions and operators of the language.
_NAME: Final = re.compile(r"\"[^\"]*\"|\$?[A-Z_]\w*")
OF_COMPUTED_VALUE: Final = "; computed: the value is known only in the program (explain FILE:LINE)"
#: Between the name of a value and the cycle that it is of.
OF: Final = " of "
#: Name of a value that the call of an O word gives.
ARGUMENT: Final = "argument"
REMARK: Final = "a remark; it moves nothing"
OF_SKIPPED_BLOCKS: Final = "the block is executed, unless --block-delete is given"
#: Words of a line that are gone through for one of them, so that a long line takes no time.
MOST_WORDS: Final = 100
CODE: Final = re.compile(r"([GM])[ \t]*0*(\d+(?:\.\d+)?)")
_IS_NUMBER: Final = re.compile(r"[-+]?[ \t]*[\d.,]+|\"[^\"]*\"|")
MODE: Final = re.compile(rf"(AC|IC|DC|ACP|ACN)[ \t]*\([ \t]*({NUMBER})[ \t]*\)")
_IS_KNOWN: Final = re.compile(rf"{_IS_NUMBER.pattern}|{MODE.pattern}")
#: What is passed as one word where it is not read.
UNREAD: Final = r"[$#]?[A-Z_]+[-+\d.]*|[$#]+|[-+\d.]+|."


class UnreadWord(ValueError):
    """The word at which the language that came farthest stopped: its column, from 1, and what it would have read."""

    def __init__(self, column: int, word: str, languages: str, expected_words: str) -> None:
        pages = join_names([PAGES[one] for one in languages.split(", ")])
        super().__init__(
            f"column {column}: {word} is not read here; {languages}: {expected_words} may stand here (see {pages})"
        )
        self.column, self.word, self.languages, self.expected_words = column, word, languages, expected_words


@cache
def list_texts(dialect: str) -> Mapping[str, str]:
    """The words of a dialect, each with what it does."""
    return {name: texts[0] for name, texts in list_meanings(dialect).items()}


class Word(NamedTuple):
    """A word of a line: where it begins and ends, its name, what it does, and its value, if it has one."""

    begin: int
    end: int
    name: str  #: As tables have it: G1 for G01.
    text: str
    value: str | None = None


class LineReader:
    """A line in one language: the place up to which it is read, and its words."""

    def __init__(
        self, line: str, dialect: str, grammar: "Grammar", remap: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        self.dialect, self.language, self.grammar = dialect, LANGUAGES[dialect], grammar
        self.code = raise_case(line).rstrip()
        self.at, self.words = 0, list[Word]()
        self.texts = {**list_texts(dialect), **{code: f'"{meaning}", says [remap]' for code, meaning in remap.items()}}
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
        word = re.compile(rf"{UNREAD}|$").match(self.code, at)
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
        code = CODE.fullmatch(match[0])
        name = f"{code[1]}{code[2]}" if code else match[0]
        text = self.texts.get(name) or self.texts.get(name.removesuffix(".0"), "")
        is_lacking = not text and name[0] == "G"
        why_refused = "not known, and refused (VP002)"
        self.add(match, text or (why_refused if is_lacking else f"{why_refused}; {describe_remap(name)}"), name=name)
        if is_lacking:
            raise self.refuse("a G code that it has", match.start())

    def name_parts(self, begin: int, end: int) -> None:
        """The variables, functions and operators of an expression; raises :class:`UnreadWord` for what is none."""
        for match in self.grammar.names.finditer(self.code, begin, end):
            name = match[0]
            text = "" if name[0] == '"' else self.grammar.explain_name(self, match)
            if text and name not in self.told_names:
                self.told_names.add(name)
                self.add(match, text)

    def explain_name(self, name: str) -> str:
        """What a function, an operator or a variable is; empty for other words."""
        return OF_EXPRESSIONS.get(self.language, {}).get(name, "") or self.describe_variable(name)

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
        self.words.append(Word(*match.span(), name, text if is_known else f"{text}{OF_COMPUTED_VALUE}", value))
        if not _IS_NUMBER.fullmatch(value):
            self.name_parts(match.end() - len(value), match.end())

    def add_bare_letter(self, match: re.Match[str], text: str) -> None:
        """A letter without its value, which its own letter stands for."""
        self.words.append(Word(*match.span(), match[0], text, match[0]))


class Grammar(Struct, frozen=True):
    """How a language reads a line."""

    read: Callable[[LineReader], None]
    #: Words of the statement that is named, which may be one word alone, or what goes on in the next line.
    read_words: Callable[[LineReader, str], None] = lambda r, _statement: r.grammar.read(r)
    statements: tuple[str, ...] = ()  #: Those that are tried for a word alone.
    #: What is a name in an expression, and what it does; empty where that need not be told.
    names: re.Pattern[str] = _NAME
    explain_name: Callable[[LineReader, re.Match[str]], str] = lambda r, match: r.explain_name(match[0])
    #: (letter, codes of its line) -> the code whose value the letter is; empty where none is.
    find_taking_code: Callable[[str, Sequence[str]], str] = lambda _letter, _codes: ""
    #: (word, words of its line) -> the code that calls a macro, and which argument of it the word is; None without.
    find_argument: Callable[[Word, Sequence[Word]], tuple[str, str] | None] = lambda _word, _words: None
