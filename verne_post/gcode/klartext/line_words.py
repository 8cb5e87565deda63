"""How a line of Klartext is read for explain, hover and cycles."""

import re
from functools import cache
from typing import Final

from verne_post.gcode.klartext import vocabulary
from verne_post.gcode.klartext.words import WORD
from verne_post.gcode.letters import LETTERS_OF_KLARTEXT, OF_FN, OF_FORMULAS, OF_NAMES, WORDS_OF_STATEMENTS
from verne_post.gcode.line_words import (
    CODE,
    MOST_WORDS,
    OF_COMPUTED_VALUE,
    OF_SKIPPED_BLOCKS,
    REMARK,
    TEXT,
    Grammar,
    LineReader,
    Word,
    list_texts,
)

_NUMBER: Final = r"[-+]?[ \t]*(?:\d+[.,]?\d*|[.,]\d+|Q[LRS]?\d+)"
#: First words of the statements in which an axis may stand without a value.
_WITH_BARE_AXES: Final = ("TOOL", "BLK", "CYCL", "TRANS")


def _read_line(r: LineReader) -> None:
    r.take_word(r"/", OF_SKIPPED_BLOCKS)
    r.take_word(r"\d+(?=[ \t]+\S)", "block number")
    r.take_word(r"DECLARE[ \t]+STRING\b(?=[ \t]+QS)", "a text parameter follows")
    if r.take_word(r"\*.*|;.*", "a remark, or the title of a section; it moves nothing"):
        return
    if not (match := _take_statement(r)):
        first = re.compile(r"([A-Z]+)[ \t]+").match(r.code, r.at)
        seconds = [one.split()[1] for one in vocabulary.STATEMENTS if first and one.startswith(f"{first[1]} ")]
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
        if value := r.take(rf"{TEXT}|{pattern}"):
            r.words[-1:] = [r.words[-1]._replace(value=value[0]), Word(*value.span(), name, what, value[0])]
    elif name == "CYCL DEF":
        _read_cycle(r)
    elif re.fullmatch(r"Q[LRS]?", name):
        _read_formula(r, match)
    r.statement = name
    _read_words(r, name)


def _read_words(r: LineReader, statement: str) -> None:
    while not r.is_at_end:
        if r.take_word(r";.*?(?=~|$)", REMARK) or r.take_word("~", "the statement goes on in the next line"):
            continue
        _read_word(r, statement)


@cache
def _list_statements() -> list[tuple[str, re.Pattern[str]]]:
    """The keywords of statements, the longest first; M, F, S and compensation are words, and stay."""
    firsts = {name.split()[0] for name in vocabulary.STATEMENTS if " " in name} | {"PLANE", "FUNCTION", "TRANS"}
    phrases = {name for name in list_texts("heidenhain") if " " in name and name.split()[0] in firsts}
    phrases = {name for name in phrases if not re.fullmatch(r"CYCL DEF \d+", name)}
    names = sorted({*vocabulary.STATEMENTS, *vocabulary.REFUSED_STATEMENTS, *phrases}, key=len, reverse=True)
    ends = dict.fromkeys(("L", "C"), r"(?=[ \t]|$)")
    ends |= dict.fromkeys(("M", "F", "S"), r"(?=[ \t]*[\d.,QMAU])") | dict.fromkeys(("R0", "RL", "RR"), r"(?!\w)")
    ends = {name: r"(?=[ \t]*\d+[ \t]*=)" if name[0] == "Q" else r"(?![A-Z])" for name in names} | ends
    return [(name, re.compile(r"[ \t]+".join(map(re.escape, name.split())) + ends[name])) for name in names]


def _take_statement(r: LineReader) -> re.Match[str] | None:
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
            if name in vocabulary.REFUSED_STATEMENTS:
                r.add(match, text)
                r.take_word(r"[^;]+", "its values")
            elif name[0] != "Q" and name not in ("CYCL DEF", "FN"):
                r.add(match, text)
            return match
    return None


def _take_number(r: LineReader, keyword: str, pattern: str, expected_words: str) -> int:
    """The number (1) of a function or a cycle, which is one word with the ``keyword`` before it."""
    match = r.take(pattern)
    number = int(match[1].partition(".")[0]) if match else 0
    name = f"{keyword} {number}"
    if match is None or name not in r.texts:
        raise r.refuse(expected_words)
    begin = r.code.rindex(keyword.split()[0], 0, match.start())
    r.words.append(Word(begin, match.end(1), name, r.texts[name]))
    return number


def _read_fn(r: LineReader) -> None:
    number = _take_number(r, "FN", r"(\d+)[ \t]*:", "the number of a function of FN, and a colon")
    if number > 13:
        r.take_word(r"[^;]+", "what it is about")
        return
    while not r.is_at_end and r.code[r.at] != ";":
        if variable := r.take(r"[-+]?(Q[LRS]?\d+)"):
            r.add(variable, r.describe_variable(variable[1]))
        elif not (r.take(r"[-+*/=]|[-+]?[\d.,]+") or r.take_word(TEXT, "a label") or r.take_name(OF_FN, 2)):
            raise r.refuse("a number, a Q parameter, or a word of FN")


def _read_formula(r: LineReader, keyword: re.Match[str]) -> None:
    match = r.take(r"(\d+)[ \t]*=[ \t]*")
    assert match is not None
    name = f"{keyword[0]}{match[1]}"
    of_cycles = vocabulary.describe_parameter(int(match[1])) if keyword[0] == "Q" else ""
    text = f"sets {name}: {r.describe_variable(name)}{f'; in cycles: {of_cycles}' * bool(of_cycles)}"
    r.words.append(Word(keyword.start(), match.end(1), name, text))
    while not r.is_at_end and r.code[r.at] not in ";~":
        if variable := r.take(r"Q[LRS]?\d+"):
            r.add(variable, r.describe_variable(variable[0]))
        elif not (r.take(rf"[-+*/^()%|]|[\d.,]+|{TEXT}") or r.take_name(OF_FORMULAS, 1)):
            raise r.refuse("a number, a Q parameter, a function or a sign of a formula")


def _read_cycle(r: LineReader) -> None:
    _take_number(r, "CYCL DEF", r"(\d+(?:\.\d+)?)", "the number of a cycle that it has")
    if not re.compile(r"(?:ROT|SCL|F|V\.?ZEIT|DWELL)[ \t]*[-+\d]|[TPR]?I?[A-Z]?[ \t]*[-+\d#]|Q\d").match(r.code, r.at):
        r.take_word(
            r"(?![XYZ](?!\w))[A-Z][^\d~;=#]*?(?=[ \t]*(?:~|;|$)|[ \t]+(?:Q\d|[XYZABC][-+\d]))",
            "name of the cycle; it is a remark",
        )


@cache
def _match_names(first: str) -> str:
    return "|".join(map(re.escape, sorted(WORDS_OF_STATEMENTS.get(first, {}), key=len, reverse=True)))


def _read_word(r: LineReader, statement: str) -> None:
    first = statement.partition(" ")[0]
    own, names = WORDS_OF_STATEMENTS.get(first, {}), _match_names(first)
    if match := r.take(rf"(Q\d+)[ \t]*=[ \t]*(F?(?:MAX|AUTO)|PREDEF|{_NUMBER})"):
        meaning = vocabulary.describe_parameter(int(match[1][1:])) or "a value of the cycle"
        is_number = re.fullmatch(r"[-+ \d.,]+|[A-Z]+", match[2])
        text = meaning if is_number else f"{meaning}{OF_COMPUTED_VALUE}"
        r.words.append(Word(*match.span(), match[1], text, match[2]))
    elif re.compile(r"F[ \t]*(?:MAX|AUTO)(?![A-Z])").match(r.code, r.at):
        match = r.take(r"F[ \t]*(MAX|AUTO)")
        assert match is not None
        r.add(match, vocabulary.WORDS["FMAX" if match[1] == "MAX" else "F AUTO"])
    elif own and (match := r.take(rf"({names})[ \t]*:?[ \t]*({_NUMBER})")):
        r.add_address(match, match[1], match[2], own[match[1]])
    elif r.take_name({**vocabulary.WORDS, **own}, 2):
        pass
    elif own and (match := r.take(rf"({names})(?![A-Z])")):
        r.add(match, own[match[1]])
    elif first == "PATTERN" and r.take(r"[()]"):
        pass
    elif match := r.take(WORD):
        _add_word(r, match, statement)
    elif statement in ("RND", "CHF", "CYCL DEF", "CALL LBL", "TRANS") and (match := r.take(_NUMBER)):
        r.add(match, {"RND": "radius", "CHF": "length on each line"}.get(statement, "its value"))
    elif first in _WITH_BARE_AXES and (match := r.take(r"[XYZ](?![\w+-])")):
        r.add(match, "the tool axis" if statement[:4] in ("TOOL", "BLK ") else "mirror image of this axis")
    else:
        raise r.refuse(f"a word of {statement or 'a block'}, such as X+10, F500, FMAX or M3")


def _add_word(r: LineReader, match: re.Match[str], statement: str) -> None:
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
            in_force = vocabulary.STATEMENTS["F"] if statement != "RND" else "feed rate of this rounding alone"
            in_force = "feed rate of the turn of the rotary axes" if statement.startswith("PLANE") else in_force
            last_words = reversed(r.words[-MOST_WORDS:])
            last = next((one.name for one in last_words if CODE.fullmatch(one.name)), "")
            text = vocabulary.FEED_OF_FUNCTIONS.get(last, in_force)
        elif name == "R" and not statement:
            text = "radius"
        r.add_address(word, name, value, text or WORDS_OF_STATEMENTS["*"].get(name, f"a value of {statement}"))
    elif match["comp"]:
        r.add(word, vocabulary.STATEMENTS.get(match["comp"], "compensation of a move along one axis, which is refused"))
    elif match["rotation"]:
        r.add(word, LETTERS_OF_KLARTEXT["".join(match["rotation"].split())])
    elif match["max"]:
        r.add(word, "retracts to the end of the travel")
    elif match["axis"]:
        r.add(word, "the rotary axis that the M function is for")
    else:
        r.add(word, vocabulary.WORDS["R F M"])


GRAMMAR: Final = Grammar(_read_line, _read_words, tuple(WORDS_OF_STATEMENTS))
