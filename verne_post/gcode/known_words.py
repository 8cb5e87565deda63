"""What a word does in every language that knows it: for `explain G68.2`, out of the tables by which it is executed."""

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from itertools import takewhile
from types import MappingProxyType
from typing import Final, NamedTuple

from verne_post.base.printable import join_names
from verne_post.base.suggestions import find_meant
from verne_post.gcode.apt import words as apt
from verne_post.gcode.apt.translator import STATEMENTS as OF_APT
from verne_post.gcode.codes import RS274, CodeTable, describe_remap, spell_g_code
from verne_post.gcode.klartext import vocabulary as klartext
from verne_post.gcode.known_variables import describe_variable
from verne_post.gcode.letters import OF_EXPRESSIONS, OF_NAMES, WORDS_OF_STATEMENTS
from verne_post.gcode.rs274.fanuc_codes import make_table
from verne_post.gcode.siemens import vocabulary as siemens

#: Tables of Klartext by what stands before their numbers.
_TABLES_OF_NUMBERS: tuple[tuple[str, Mapping[int, str], bool], ...] = (
    ("M", klartext.FUNCTIONS, True),
    ("M", klartext.FUNCTIONS_WITHOUT_EFFECT, True),
    ("M", klartext.REFUSED_FUNCTIONS, False),
    ("CYCL DEF ", klartext.CYCLES, True),
    ("CYCL DEF ", klartext.CYCLES_WITHOUT_EFFECT, True),
    ("CYCL DEF ", klartext.REFUSED_CYCLES, False),
    ("FN ", klartext.FN, True),
    ("FN ", {14: "stops the program with an error: a program that gets there is refused (VP027)"}, True),
    ("FN ", klartext.REFUSED_FN, False),
)
#: Pages of the languages, and sections that Fanuc has from the page of RS274/NGC.
PAGES: Final = {
    "RS274/NGC": "docs/gcode.md",
    "Fanuc": "docs/fanuc.md",
    "Siemens": "docs/siemens.md",
    "Klartext": "docs/heidenhain.md",
    "APT": "docs/apt.md",
}
_OWN_OF_FANUC: Final = (
    "Variables",
    "Circles of Haas",
    "Cycles",
    "Tilted planes",
    "Turns, scales, mirror images",
    "Arguments",
)
_SECTION: Final = re.compile(r"(?<=\bsee )([A-Z][\w ,-]*\w)")
#: Languages by the names of their dialects.
LANGUAGES: Final = {
    "rs274": "RS274/NGC",
    "fanuc": "Fanuc",
    "siemens": "Siemens",
    "heidenhain": "Klartext",
    "aptcl": "APT",
}
_M_CODE: Final = re.compile(r"M\d{1,9}")
#: Cycles of RS274/NGC and Fanuc that make holes.
_HOLES: Final = ("G73", "G74", *(f"G{number}" for number in range(81, 90)))


#: A letter with a number, of which the number says nothing: T1, R1, #100.
_LETTER_AND_NUMBER: Final = re.compile(r"^([A-FH-LN-Z#]|Q[LRS])[-+]?(?:\d+\.?\d*|\.\d+)$")
#: Zeros before the number of a word: M03, G05.1, FN 09.
_ZEROS: Final = re.compile(r"^([A-Z#]|Q[LRS]|FN |CYCL DEF )0+(?=\d)")
#: What a program writes behind the number of a cycle: .0, and its name.
_BEHIND_CYCLE: Final = re.compile(r"^(CYCL DEF \d+)(?:\.\d+)?(?: (?![XYZABC]\b)[^\d+#~]*)?$")
#: A sign or = before the value of a word: SEQ-, A3=.
_SIGN: Final = re.compile(r" ?[-+=]$")
#: What the line above the kinds of PLANE says.
_TOLD_ABOVE: Final = "tilts the work plane: "


class GivenValue(NamedTuple):
    """A value that the call of a cycle gives: its 1-based line, where it begins there, and how it is written."""

    line: int
    begin: int
    text: str


def name_axes(text: str, letters: tuple[str, str]) -> str:
    """What a word does, with the letters of a machine in place of its rotary axes; it lacks the third letter."""
    (lacking,) = {*"ABC"} - {*letters}
    text = re.sub(rf"\baxis {lacking} goes.*", f"axis {lacking}, which this machine lacks: refused (VP011)", text)
    text = re.sub(r"\bthe tilting axis\b", letters[0], text)
    return re.sub(r"\bthe rotary axes\b", " and ".join(letters), text)


def list_meanings(dialect: str, *, executed_alone: bool = False) -> dict[str, list[str]]:
    """The words of a dialect, and what each does; more than one text where tables have it more than once."""
    language, found = LANGUAGES[dialect], dict[str, list[str]]()
    for owner, name, text, is_executed in list_words():
        if owner == language and (is_executed or not executed_alone):
            found.setdefault(name, []).append(_describe(language, name, text, is_executed=is_executed))
    phrases = {name: text for name, text in OF_NAMES.get(language, {}).items() if " " in name}
    for name, text in phrases.items():  # a letter means nothing without its value
        found.setdefault(name, [text])
    return found


def describe_word(word: str) -> list[str]:
    """One line for each language that knows a word such as G68.2, TRAORI or CYCL DEF 208; empty where none does.

    Below it are the values of a cycle, in their order, and what may follow a word.

    Of an M code that none knows, which the builder of a machine may have, how a set-up gives it a meaning.
    """
    name = re.sub(r"^FN(?=\d)", "FN ", " ".join(word.upper().split()))
    name = _BEHIND_CYCLE.sub(r"\1", _ZEROS.sub(r"\1", name))
    bare = _SIGN.sub("", name)
    if bare != name and _M_CODE.fullmatch(bare):  # M1= is the M code of a spindle, not M1
        return [f"Siemens: {siemens.ADDRESSES[bare]}"] if name[-1] == "=" and bare in siemens.ADDRESSES else []
    texts = {
        language: f"{language}: {_describe(language, name, text, is_executed=is_executed)}"
        for language, known_word, text, is_executed in list_words()
        if known_word == name
    }
    variable = describe_variable(name)
    texts |= {language: f"{language}: {text}" for language, text in variable.items()}
    alone = _LETTER_AND_NUMBER.sub(r"\1", name)
    # X1= of Siemens is another word than X1, which is X with its value
    is_indexed = alone != name and alone in "XYZABC" and "Siemens" in texts
    indexed_words = [f"{texts.pop('Siemens')} (as {name}=)"] if is_indexed else []
    for dialect, language in LANGUAGES.items():
        names = _list_names().get(language, {})
        if language not in texts and (text := names.get(alone if is_indexed else name, names.get(alone, ""))):
            text = _describe(language, alone, text, is_executed=True)
            is_place = alone != name and text.startswith("where ")
            shown_text = describe_place(alone, name.removeprefix(alone), dialect) if is_place else text
            texts[language] = f"{language}: {shown_text}"
    values = list(_describe_values(name))
    if variable.keys() == {"Klartext"} and not values:
        found = [texts["Klartext"]]
    elif any(one.startswith("Klartext: ") for one in values):  # no other language has a Q of this number
        found = [*values, texts["Klartext"]]
    else:
        found = [*texts.values(), *indexed_words, *values]
    # what its tables have of it: names of values, and what may follow it
    found += [f"  {value}" for dialect in ("siemens", "heidenhain") for value in describe_values(name, dialect)]
    found += [
        f"  {known_word}: {_describe(language, known_word, text.removeprefix(_TOLD_ABOVE), is_executed=True)}"
        for language, known_word, text, is_executed in list_words()
        if language in texts and is_executed and known_word.startswith(f"{name} ")
    ]
    if _M_CODE.fullmatch(name):
        if not found:
            return [f"no meaning in any language here; {describe_remap(name)}"]
        lacking = join_names(
            [language for language in ("RS274/NGC", "Fanuc", "Siemens", "Klartext") if language not in texts]
        )
        return [*found, *([f"{lacking}: not known, and refused (VP002); {describe_remap(name)}"] if lacking else [])]
    if not found and re.fullmatch(r"FN \d+", name):
        return ["Klartext: no function FN has this number: a program with it is refused (VP002)"]
    if not found and bare != name and not _SIGN.search(bare):
        found = describe_word(bare)
    of_statements = (  # what may follow the slash of a CL statement, or stand in a statement of Klartext
        ("APT", apt.WORDS_OF),
        ("Klartext", WORDS_OF_STATEMENTS),
    )
    found += [
        f"{language}{'' if head == '*' else f', in {head}'}: {words[name]}"
        for language, statements in of_statements
        for head, words in statements.items()
        if name in words and f"{language}: {words[name]}" not in found
    ]
    # else the first word of statements, or a statement with words that its table lists
    return (
        found
        or [
            f"{language}, {known_word}: {_describe(language, known_word, text, is_executed=is_executed)}"
            for language, known_word, text, is_executed in list_words()
            if known_word.startswith(f"{name} ")
        ]
        or [
            f"{language}, {known_word}: {_describe(language, known_word, text, is_executed=is_executed)}"
            for language, known_word, text, is_executed in list_words()
            if name.startswith(f"{known_word} ")
            and not re.search(r"[\d\"]", name)  # else a line, whose words are told each
            and (not is_executed or re.search(rf"\b{re.escape(name[len(known_word) + 1 :])}\b", text))
        ]
    )


def describe_place(name: str, value: str, dialect: str) -> str:
    """Where a letter with a number takes its axis: "axis X goes to 1 mm"."""
    axis, number = name.removeprefix("I"), value.replace(" ", "").removeprefix("+")
    number = number.rstrip(".").replace("-.", "-0.")
    inch = {"siemens": "inch under G70", "heidenhain": "inch, where BEGIN PGM says so"}.get(dialect, "inch under G20")
    unit = "degrees" if axis in "ABC" else f"mm ({inch})"
    shown_text = f"axis {axis} goes {'to' if name == axis else 'on by'} {number} {unit}"
    return shown_text if dialect == "heidenhain" else f"{shown_text}; in G91 on by that much"


def find_near_word(word: str, codes: Iterable[str]) -> str:
    """The nearest of the finding codes and of the words of all languages; empty where none is near."""
    return find_meant(word, codes, dict.fromkeys(name for _language, name, _text, _is_executed in list_words()))


def _list_names() -> dict[str, Mapping[str, str]]:
    """Letters and names that stand in no table of words, by language."""
    return {**OF_NAMES, "Siemens": {**siemens.ADDRESSES, **OF_NAMES["Siemens"]}}


def _describe_values(name: str) -> Iterator[str]:
    """A value of cycles: what it is, and whose."""
    cycles = [cycle for cycle, names in list_parameters().items() if name in names]
    if cycles:
        meaning = siemens.CYCLE_VALUES.get(name, "")
        yield f"Siemens: a value of {', '.join(cycles)}{': ' * bool(meaning)}{meaning}"
    if name.startswith("Q") and name[1:].isdecimal():
        from verne_post.gcode.klartext.cycle_words import OF_PARAMETERS

        numbers = [f"{cycle}" for cycle, (own, defaults) in OF_PARAMETERS.items() if int(name[1:]) in (*own, *defaults)]
        meaning = klartext.describe_parameter(int(name[1:]))
        if numbers:
            yield f"Klartext: a value of CYCL DEF {', '.join(numbers)}{f': {meaning}' if meaning else ''}"


def _describe(language: str, name: str, text: str, *, is_executed: bool) -> str:
    """What a word does itself, and the page that its row in a table names; why it is refused."""

    def name_page(section: re.Match[str]) -> str:
        is_general = language == "Fanuc" and section[1] not in _OWN_OF_FANUC
        return f"{section[1]} in {PAGES['RS274/NGC' if is_general else language]}"

    meaning = text if is_executed else f"not executed: {text}"
    return re.sub(r": below\b", f": see {PAGES[language]}", _SECTION.sub(name_page, meaning))


def list_values_of_cycle(word: str, dialect: str) -> list[tuple[str, str]]:
    """The values that a cycle takes: the text before each, and its name; none for other words, and in CL files.

    Of Klartext those without a default, and the dwell; of Siemens those whose names do not begin with _, if it has any.
    """
    if dialect == "siemens":
        names = list_parameters().get(word, ())
        plain_names = tuple(takewhile(lambda name: not name.startswith("_"), names)) or names
        return [("," if number else "(", name) for number, name in enumerate(plain_names)]
    if dialect == "heidenhain":
        needs, defaults = _list_q_parameters(word)
        # controls ask for the dwell of every cycle that has one
        numbers = [*needs, *(number for number in defaults if number == klartext.Q.DWELL_BELOW)]
        return [(f" ~\n  Q{number}=", klartext.name_parameter(number) or "value") for number in numbers]
    if word not in _HOLES:
        return []
    from verne_post.gcode.rs274.cycles import DWELLS, NEEDS_STEP

    code = 10 * int(word[1:])
    own = "P" * (code in DWELLS) + "Q" * (code in NEEDS_STEP)
    return [(f" {letter}", letter) for letter in f"XYZR{own}F"]


def describe_values(word: str, dialect: str, given: Mapping[str, GivenValue] = MappingProxyType({})) -> list[str]:
    """The values of a cycle of Siemens or Klartext, in their order, with what each is; none for other words.

    ``given`` are those of a call, by their names.
    """
    if dialect == "siemens":
        values = ((name, siemens.CYCLE_VALUES.get(name, "")) for name in list_parameters().get(word, ()))
    else:
        needs, defaults = _list_q_parameters(word) if dialect == "heidenhain" else ((), {})
        without = {
            f"Q{number}": f"; {value:g} where it is not given"
            for number, value in defaults.items()
            if f"Q{number}" not in given
        }
        values = (
            (name, f"{klartext.describe_parameter(int(name[1:]))}{without.get(name, '')}")
            for name in (f"Q{number}" for number in (*needs, *defaults))
        )
    named_values = ((f"{name} = {given[name].text}" if name in given else name, meaning) for name, meaning in values)
    return [f"{name}: {meaning}" if meaning else name for name, meaning in named_values]


def _list_q_parameters(word: str) -> tuple[tuple[int, ...], dict[int, float]]:
    """The Q parameters that a cycle of Klartext needs, and those that have a default."""
    from verne_post.gcode.klartext.cycle_words import OF_PARAMETERS

    cycle = word.removeprefix("CYCL DEF ")
    return OF_PARAMETERS.get(int(cycle) if cycle.isdecimal() else 0, ((), {}))


@cache
def list_parameters() -> dict[str, tuple[str, ...]]:
    """Siemens cycle -> the names of its values, in order."""
    from verne_post.gcode.siemens import contour_milling, drilling, milling_values, patterns, swivel

    return {
        **drilling.PARAMETERS,
        **milling_values.PARAMETERS,
        **patterns.PARAMETERS,
        **contour_milling.PARAMETERS,
        **swivel.PARAMETERS,
    }


@cache
def list_words() -> tuple[tuple[str, str, str, bool], ...]:
    """Language, word, what it does or why it is refused, and whether it is executed."""
    return tuple(_collect_words())


def _collect_words() -> Iterator[tuple[str, str, str, bool]]:
    """Read :func:`list_words` from the tables of all languages."""
    for language, words in OF_EXPRESSIONS.items():
        yield from ((language, name, text, True) for name, text in words.items())
    for language, table in (("RS274/NGC", RS274), ("Fanuc", make_table())):
        for name, text, is_executed in _list_codes(table):
            yield language, name, text, is_executed
    tables = (*siemens.GROUPS.values(), siemens.ADDRESSES, siemens.VALUE_MODES, siemens.STATEMENTS, siemens.CYCLES)
    for words in tables:
        yield from (("Siemens", name, text, True) for name, text in words.items() if name != "M1")  # but M1=
    for functions in siemens.M_FUNCTIONS.values():
        yield from (("Siemens", f"M{number}", text, True) for number, text in functions.items())
    yield from (("Siemens", name, f"no effect: {text}", True) for name, text in siemens.NO_EFFECT.items())
    yield from (("Siemens", name, text, False) for name, text in siemens.REFUSED_WORDS.items())
    for phrases in (klartext.STATEMENTS, klartext.WORDS):
        yield from (("Klartext", name, text, True) for name, text in phrases.items())
    yield from (("Klartext", f"PLANE {name}", text, True) for name, text in klartext.PLANES.items())
    yield from (("Klartext", name, text, False) for name, text in klartext.REFUSED_STATEMENTS.items())
    yield from (("APT", name, text, True) for name, (_method, text) in OF_APT.items())
    yield from (("APT", name, "no effect: a remark of the CAM system", True) for name in apt.REMARKS)
    yield from (("APT", name, f"no effect: {apt.FOR_OTHERS}", True) for name in apt.WITHOUT_EFFECT)
    yield from (("APT", name, text, False) for name, text in apt.REFUSED_WORDS.items())
    for head, functions, is_executed in _TABLES_OF_NUMBERS:
        yield from (("Klartext", f"{head}{number}", text, is_executed) for number, text in functions.items())


def _list_codes(table: CodeTable) -> Iterator[tuple[str, str, bool]]:
    """Code, what it does, or why it is refused, and whether it is executed."""
    for codes in table.g_groups.values():
        yield from ((spell_g_code(code), text, True) for code, text in codes.items())
    for codes in table.m_groups.values():
        yield from ((f"M{code}", text, True) for code, text in codes.items())
    yield from ((spell_g_code(code), text, False) for code, text in table.refused_g.items())
    yield from ((f"M{code}", text, False) for code, text in table.refused_m.items())
