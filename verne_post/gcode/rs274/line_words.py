"""How a line of RS274/NGC or Fanuc is read for explain, hover and cycles."""

import re
from collections.abc import Sequence
from functools import partial
from typing import Final

from msgspec import structs

from verne_post.gcode.block import KEYWORDS
from verne_post.gcode.codes import RS274, CodeTable
from verne_post.gcode.letters import OF_EXPRESSIONS, OF_NAMES
from verne_post.gcode.line_words import (
    ARGUMENT,
    BRACKET,
    CODE,
    MOST_WORDS,
    NUMBER,
    OF_SKIPPED_BLOCKS,
    REMARK,
    Grammar,
    LineReader,
    Word,
)
from verne_post.gcode.rs274.fanuc_codes import make_table
from verne_post.gcode.rs274.macro_text import number_argument

_VARIABLE: Final = rf"#+\d+|#<[^<>]*>|#{BRACKET}"
_FUNCTION: Final = rf"[A-Z]{{2,5}}[ \t]*{BRACKET}(?:[ \t]*/[ \t]*{BRACKET})?"
_VALUE: Final = rf"{NUMBER}|[-+]?(?:{_VARIABLE}|{BRACKET}|{_FUNCTION})"
_OPERATOR: Final = r"[ \t]*(?:[-+*/]|(?:AND|OR|XOR|MOD|EQ|NE|LT|LE|GT|GE)(?![A-Z]))[ \t]*"
_NAMES: Final = re.compile(r"#<[^<>]*>|#\d+|[A-Z_]+")  # a number may touch an operator: #1EQ9
_MESSAGE: Final = r"\([ \t]*(?:MSG|DEBUG|PRINT|LOG)[ \t]*,[^)]*\)"
#: What an O word marks by its keyword, without END.
_MARKS: Final = {
    **dict.fromkeys(("DO", "WHILE", "REPEAT", "BREAK", "CONTINUE"), "mark of a loop"),
    **dict.fromkeys(("IF", "ELSEIF", "ELSE"), "mark of a branch"),
}
_OF_SUBPROGRAM: Final = "number or name of the subprogram"


def _read_line(r: LineReader) -> None:
    """A line of RS274/NGC or Fanuc."""
    is_fanuc = r.dialect == "fanuc"
    keywords = OF_EXPRESSIONS["Fanuc"]
    letters = OF_NAMES[r.language]
    r.take_word(r"/\d?", OF_SKIPPED_BLOCKS)
    while not r.is_at_end:
        if not is_fanuc and r.take_word(_MESSAGE, "a message; it moves nothing"):
            continue
        if r.take_word(r"\([^)]*\)|;.*", REMARK) or r.take_word("%", "the text of the program begins, or ends"):
            continue
        if match := r.take(rf"(?:O|{':' if is_fanuc else 'O'})[ \t]*(?:<[^<>]*>|\d+|{_VARIABLE}|{BRACKET})"):
            keyword = None if is_fanuc else r.take(rf"(?:{'|'.join(sorted(KEYWORDS, key=len, reverse=True))})(?![A-Z])")
            text = _MARKS.get(keyword[0].removeprefix("END"), _OF_SUBPROGRAM) if keyword else letters["O"]
            r.words.append(Word(*match.span(), "mark" if keyword else "O", text, match[0][1:].strip()))
            if keyword is not None:
                r.add(keyword, OF_EXPRESSIONS[r.language][keyword[0]])
                text = "condition" if keyword[0] in ("IF", "ELSEIF", "WHILE") else f"value of {keyword[0].lower()}"
                number = 0
                while value := r.take(BRACKET):
                    number += 1
                    if keyword[0] == "CALL":
                        r.add(value, f"becomes #{number} of {match[0].strip().lower()}", name=ARGUMENT)
                    else:
                        r.add(value, text)
                    r.name_parts(*value.span())
        elif match := r.take(rf"({_VARIABLE})[ \t]*=[ \t]*"):
            name = match[1]
            r.add(match, f"sets {name}: {r.describe_variable(name) or letters['#']}", 1)
            r.told_names.add(name)
            _take_value(r)
        elif is_fanuc and (match := r.take(r"(IF|WHILE|THEN|GOTO|DO|END)(?![A-Z])")):
            r.add(match, keywords[match[0]])
            if match[0] != "THEN":
                _take_value(r)
            after = {"IF": ("GOTO or THEN", r"(?=GOTO|THEN)"), "WHILE": ("DO and a number", r"(?=DO)")}.get(match[0])
            if after and not re.compile(after[1]).match(r.code, r.at):
                raise r.refuse(after[0])
        elif is_fanuc and (match := r.take(rf",[ \t]*([RCA])[ \t]*({_VALUE})")):
            r.add_address(match, f",{match[1]}", match[2], "")
        elif match := r.take(r"[GM][ \t]*\d+(?:\.\d+)?"):
            r.add_code(match)
        elif match := r.take(rf"([GMNA-Z@^])[ \t]*({_VALUE})"):
            of_polar = {"@": "polar radius", "^": "polar angle, degrees"}
            text = of_polar.get(match[1]) or letters.get(match[1], "number that the code of the block takes")
            text = letters.get("".join(match[0].split()), text)  # D0
            r.add_address(match, match[1], match[2], text)
        elif r.takes_bare_letter and (match := r.take(rf"[{''.join(name for name in letters if name.isalpha())}]$")):
            r.add_bare_letter(match, letters[match[0]])
        else:
            raise r.refuse("a letter with a value such as X1.5, a G or M code, or #1=2")


def _read_function(r: LineReader, _head: str) -> None:
    """A function of RS274/NGC or Fanuc with its value."""
    if not re.compile(_FUNCTION).fullmatch(r.code, r.at):
        raise r.refuse("a function with its value")
    _take_value(r)


def _take_value(r: LineReader) -> None:
    more = rf"(?:{_OPERATOR}(?:{_VALUE}))*" if r.dialect == "fanuc" else ""
    value = r.take(rf"(?:{_VALUE}){more}")
    if value is None:
        raise r.refuse("a number, a variable or an expression in [ ]")
    r.name_parts(*value.span())


def _explain_name(r: LineReader, match: re.Match[str]) -> str:
    text = r.explain_name(match[0])
    if not text and match[0][0] != "#":
        raise r.refuse("a variable, a number or a function", match.start())
    return text


def _find_taking_code(table: CodeTable, letter: str, codes: Sequence[str]) -> str:
    """The code of a line whose value a letter is; empty where none is."""
    for one in codes:
        if code := CODE.fullmatch(one):
            number, of_code = float(code[2]), table.words_of_g if code[1] == "G" else table.words_of_m
            if letter in of_code.get(round(10 * number if code[1] == "G" else number), ""):
                return one
    return ""


def _find_argument(word: Word, words: Sequence[Word]) -> tuple[str, str] | None:
    at = next((at for at, one in enumerate(words) if one.name in ("G65", "G66")), len(words))
    behind = words[at + 1 : at + MOST_WORDS]
    if behind and words[at].begin < word.begin <= behind[-1].begin:
        letters = [one.name for one in behind if one.begin <= word.begin and one.value]
        if number := number_argument("".join(letters)):
            return words[at].name, f"argument #{number} of the macro: {{}}"
    return None


_OF_BLOCKS: Final = Grammar(_read_line, _read_function, ("",), names=_NAMES, explain_name=_explain_name)
RS274_GRAMMAR: Final = structs.replace(_OF_BLOCKS, find_taking_code=partial(_find_taking_code, RS274))
FANUC_GRAMMAR: Final = structs.replace(
    _OF_BLOCKS, find_taking_code=partial(_find_taking_code, make_table()), find_argument=_find_argument
)
