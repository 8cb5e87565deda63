"""The reader of a line: its words with columns and values, in each language; explain, hover and cycles use it.

`explain "G1 X10 F500"` shows those of every language that can read the whole line. The front ends compute values while
they read, and need the program for it; this reader has a line alone.

A value that is computed is not known here: only the program, and the place of the line in it, give it.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from verne_post.base.program_lines import find_machine_code, remove_remarks
from verne_post.gcode.apt.line_words import GRAMMAR as APT
from verne_post.gcode.klartext.line_words import GRAMMAR as KLARTEXT
from verne_post.gcode.known_words import GivenValue, describe_place, describe_values
from verne_post.gcode.letters import BESIDE_MOTION, OF_CORNERS, OF_LETTERS, OF_NAMES
from verne_post.gcode.line_words import MODE, OF, OF_COMPUTED_VALUE, UNREAD, Grammar, LineReader, UnreadWord, Word
from verne_post.gcode.rs274.line_words import FANUC_GRAMMAR, RS274_GRAMMAR
from verne_post.gcode.siemens.line_words import GRAMMAR as SIEMENS
from verne_post.gcode.siemens.vocabulary import ADDRESSES

#: How the text of a letter that moves an axis begins.
_OF_AXES: Final = ("where ", "by how much")
#: Of lines of a program that may have a cycle with values.
_MAY_HAVE_VALUES: Final = re.compile(r"\(|\bCYCL[ \t]+DEF\b", re.IGNORECASE)
#: A word, and a letter without its value: G64 P.
_WITH_BARE_LETTER: Final = re.compile(r"[ \t]*[A-Z]+[\d.]*[ \t]+[A-Z][ \t]*", re.IGNORECASE)
#: Of a value whose statement would say what it is.
_SAYS_NOTHING: Final = re.compile(r"a value of |its value$")
_GRAMMARS: Final[Mapping[str, Grammar]] = {
    "rs274": RS274_GRAMMAR,
    "fanuc": FANUC_GRAMMAR,
    "siemens": SIEMENS,
    "heidenhain": KLARTEXT,
    "aptcl": APT,
}


def _list_words(r: LineReader) -> list[Word]:
    """The words in their order; a letter as what it means beside the codes of its line."""
    words = sorted(r.words)
    codes, is_of_machine = list_codes(words), bool(find_machine_code(r.code, r.dialect))
    return [
        word._replace(text=_describe(r, word, words, codes, is_of_machine=is_of_machine)) if word.value else word
        for word in words
    ]


def _describe(r: LineReader, word: Word, words: Sequence[Word], codes: Sequence[str], *, is_of_machine: bool) -> str:
    """What a word with a value does; the places of the line may be those of the machine."""
    name, value, text = word.name, word.value or "", word.text.removesuffix(OF_COMPUTED_VALUE)
    tail = word.text.removeprefix(text)  # that it is computed
    mode = MODE.fullmatch(value)
    if beside := find_beside(word, words, codes, r.dialect)[1]:
        return f"{beside.format(value.strip().removeprefix('+').rstrip('.'))}{tail}"
    if not tail and name.removeprefix("I") in [*"XYZABCUVW"] and text.startswith(_OF_AXES):
        shown_text, end = describe_place(name, mode[2] if mode else value, r.dialect), "; in G91 on by that much"
        if is_of_machine:
            return f"{shown_text.removesuffix(end)}, in machine coordinates"
        is_step = mode is not None and mode[1] == "IC"
        return shown_text.removesuffix(end).replace(" to ", " on by ", is_step) if mode else shown_text
    if name == "S" and "G96" in codes:
        return f"speed of the surface, in m/min{tail}"
    if name in ("F", "S") and text in ("feed rate", "spindle speed"):
        return f"{ADDRESSES[name]}{tail}"
    if name in [*"PQLEKR"] and (code := r.grammar.find_taking_code(name, codes)):
        return word.text if name == "R" and code[0] != "M" else f"a value of {code}{tail}"
    return word.text


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
    if {"G65", "G66"}.intersection(codes) and (argument := _GRAMMARS[dialect].find_argument(word, words)):
        return argument
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
        for word in _list_words(reader):
            texts = found.setdefault((word.begin, -word.end), {})
            texts.setdefault(word.text, []).append(reader.language)
    lines = list[str]()
    for (begin, end), texts in sorted(found.items()):
        lines += [" ".join(line[begin:-end].split()), *(f"  {', '.join(of)}: {text}" for text, of in texts.items())]
    return lines


def _read_in_all(line: str, *, takes_bare_letter: bool = False) -> tuple[list[LineReader], list[UnreadWord]]:
    """A line in the languages that read it, and where the others stop."""
    readers, stops = list[LineReader](), list[UnreadWord]()
    for dialect, grammar in _GRAMMARS.items():
        reader = LineReader(line, dialect, grammar)
        reader.takes_bare_letter = takes_bare_letter
        try:
            grammar.read(reader)
        except UnreadWord as stop:
            stops.append(stop)
        else:
            readers.append(reader)
    return readers, stops


def _read_alone(line: str, *, is_read: bool) -> Iterator[LineReader]:
    """A word with its value that begins no line, read as within its statements: SPA+20, SQRT[4], RAPTO,3.

    Of Klartext also several, as after a ~, unless another language has read them (``is_read``).
    """
    told_texts = set[str]()
    for dialect, grammar in _GRAMMARS.items():
        for head in grammar.statements:
            reader = LineReader(line, dialect, grammar)
            try:
                grammar.read_words(reader, head)
            except UnreadWord:
                continue
            words = _list_words(reader)
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
    grammar = _GRAMMARS[dialect]
    reader = LineReader(remove_remarks(line, dialect), dialect, grammar, remap)
    reader.statement = "CYCL DEF" if is_continued else None
    while not reader.is_at_end:
        try:
            if reader.statement is None:
                grammar.read(reader)
            else:
                grammar.read_words(reader, reader.statement)
        except UnreadWord as stop:
            if reader.at < stop.column:  # else the word has been passed
                reader.at = stop.column - 1
                reader.take(UNREAD)
    return [word._replace(text=word.text.removesuffix(OF_COMPUTED_VALUE)) for word in _list_words(reader)]


def find_cycle_call(line: str, dialect: str) -> Word | None:
    """The first call or definition of a cycle that has values in a line."""
    words = find_words(line, dialect) if _MAY_HAVE_VALUES.search(line) else []  # programs of many lines are searched
    return next((word for word in words if describe_values(word.name, dialect)), None)


def find_given_values(lines: Sequence[str], number: int, dialect: str) -> dict[str, GivenValue]:
    """The values that the call of a cycle at a 1-based line gives, by their names."""
    found = dict[str, GivenValue]()
    for at, line in enumerate(lines[number - 1 :], start=number):
        for word in find_words(line, dialect, is_continued=at > number):
            name, is_value, _cycle = word.name.partition(OF)
            if word.value and (is_value or (dialect == "heidenhain" and re.fullmatch(r"Q\d+", name))):
                found[name] = GivenValue(at, word.end - len(word.value), line[word.end - len(word.value) : word.end])
        if dialect != "heidenhain" or not line.rstrip().endswith("~"):
            break
    return found
