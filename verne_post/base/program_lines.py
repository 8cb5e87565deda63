"""Remarks and words of a program's line as it is written, without reading the program."""

import math
import re
from collections.abc import Iterable, Sequence
from typing import Final

from verne_post.base.tolerances import LIMIT_SLACK_MM

#: Remarks of languages, by dialect, in which parentheses are no remarks, or a text, in which none begins.
_REMARKS: Final = {**dict.fromkeys(("siemens", "heidenhain"), r"(\"[^\"]*\")|;.*"), "aptcl": r"\$\$.*"}
_REMARKS_IN_PARENTHESES: Final = r"\([^)]*\)?|;.*"
#: So many characters of a line are read, apart from remarks. Blocks of controls have 255 to 512; Python reads whole
#: numbers of up to 4300 digits.
LONGEST_LINE: Final = 16000


def split_lines(text: str) -> list[str]:
    """Lines without their ends and without the mark of UTF-8, as the readers of programs count them."""
    return [line.removesuffix("\r") for line in text.removeprefix("\ufeff").split("\n")]


def remove_remarks(line: str, dialect: str = "") -> str:
    """A line with blanks for its remarks; without a dialect, those in parentheses and after a semicolon."""
    return re.sub(_REMARKS.get(dialect, _REMARKS_IN_PARENTHESES), _blank, line)


def count_code(line: str, dialect: str) -> int:
    """How many characters a line has outside remarks."""
    found = re.finditer(_REMARKS.get(dialect, _REMARKS_IN_PARENTHESES), line)
    return len(line) - sum(len(remark[0]) for remark in found if not remark.lastindex)


def _blank(remark: re.Match[str]) -> str:
    """Blanks for a remark; a text stays."""
    return remark[0] if remark.lastindex else " " * len(remark[0])


#: The word that ends a program, outside remarks.
_END: Final = re.compile(r"^[^(;]*(?<![A-Z])M0*(?:2|30)(?![\d.])", re.IGNORECASE)


def find_end(lines: Iterable[str]) -> int | None:
    """The line, from 0, that ends a program (M2, M30); None where none does."""
    return next((number for number, line in enumerate(lines) if _END.search(line)), None)


#: Codes whose places are those of the machine, in which no work offset counts: G28, G30, G53 of RS274/NGC and Fanuc;
#: SUPA, G53, G153, G74, G75 of Siemens; M91, M92 of Klartext; GOHOME of CL files.
_MACHINE_CODES: Final = re.compile(
    r"(?<![A-Z_$])(?:G0*(?:28|30|53|74|75|153)(?:\.0)?(?![\d.])|SUPA\b|M9[12](?!\d)|GOHOME\b)", re.IGNORECASE
)
#: Those of them whose words are no machine coordinates.
_REFERENCE_CODES: Final = re.compile(r"(?<![A-Z_$])(?:G0*(?:28|30|74|75)(?:\.0)?(?![\d.])|GOHOME\b)", re.IGNORECASE)


def find_machine_code(line: str, dialect: str) -> str:
    """The code by which the places of a line are those of the machine; empty without one."""
    found = _MACHINE_CODES.search(remove_remarks(line, dialect))
    code = "" if found is None else found[0].upper()
    return "" if dialect in ("rs274", "fanuc") and code in ("G74", "G75") else code


def goes_to_reference(line: str) -> bool:
    """Whether a line leads to a place that is stored in the machine, and no word of it says where that is."""
    return _REFERENCE_CODES.search(remove_remarks(line)) is not None


#: Klartext may have a comma for the point.
_DIGITS: Final = r"(?:\d+(?:,\d+|\.\d*)?|[.,]\d+)"


def read_number(number: str) -> float:
    """The value of a number of :func:`find_word`."""
    return float(number.replace(",", "."))


def find_word(line: str, letter: str) -> re.Match[str] | None:
    """A letter (1) with its number (2), outside remarks; None where the line does not have it once."""
    found = _list_words(line, letter)
    return found[0] if len(found) == 1 else None


def find_coordinate(line: str, letter: str, language: str) -> re.Match[str] | None:
    """The same for X, Y or Z, which in a CL file are the numbers (2) of GOTO."""
    if language != "aptcl":
        return find_word(line, letter)
    before = f"(?:[ \\t]*+{_NUMBER}[ \\t]*+,){{{'XYZ'.index(letter)}}}"
    return re.search(rf"(GOTO[ \t]*+/{before}[ \t]*+)({_NUMBER})", line, re.IGNORECASE)


def find_address(line: str, letter: str) -> int | None:
    """The column of a letter, whatever gives its number, as in A#2, A[#1+2], A=R2, A=IC(5) or IA+Q5; None as above."""
    pattern = rf"(?<![A-Za-z_])I?{letter}[ \t]*+(?==|[-+]?[#\[.\dQ])(?!\d++[ \t]*+=)"
    found = list(re.finditer(pattern, remove_remarks(line, _find_dialect(line)), re.IGNORECASE))
    return found[0].start() + 1 if len(found) == 1 else None


def _list_words(line: str, letter: str) -> list[re.Match[str]]:
    code, begin = remove_remarks(line, dialect := _find_dialect(line)), rf"(?<![A-Za-z_])({letter}[ \t]*+=?+[ \t]*+"
    found = list(re.finditer(rf"{begin})([-+]?{_DIGITS})", code, re.IGNORECASE))
    if dialect and letter in ("A", "B", "C"):
        found += re.finditer(rf"{begin}{_PLACE})([-+]?{_DIGITS})[ \t]*+\)", code, re.IGNORECASE)
    return found


#: Siemens: how a rotary axis goes to its place, which is no remark.
_PLACE: Final = r"(?:DC|AC[PN]?)[ \t]*+\([ \t]*+"


def _find_dialect(line: str) -> str:
    """That of a line with such a place; empty for others."""
    return "siemens" if re.search(rf"=[ \t]*+{_PLACE}", line, re.IGNORECASE) else ""


def find_word_of(line: str, letter: str, value: float) -> re.Match[str] | None:
    """A letter with this number; None where the line does not have it once.

    In a loop, an incremental block or inches the number has another meaning.
    """
    words = _list_words(line, letter)
    found = [one for one in words if math.isclose(read_number(one[2]), value, abs_tol=LIMIT_SLACK_MM)]
    return found[0] if len(found) == 1 else None


#: The words of a tool axis, by language; of G-code, I J K. Of CL files, i j k stand for the numbers of GOTO.
_VECTOR_LETTERS: Final = {"siemens": ("A3", "B3", "C3"), "heidenhain": ("TX", "TY", "TZ"), "aptcl": ("i", "j", "k")}
_NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:E[-+]?\d+)?"
#: The tool axis of a CL file, behind the point.
_GOTO: Final = re.compile(rf"GOTO\s*/(?:\s*{_NUMBER}\s*,){{3}}" + ",".join([rf"\s*({_NUMBER})\s*"] * 3), re.IGNORECASE)


def change_number(line: str, word: re.Match[str], value: str) -> str:
    """A line with another number in a word of :func:`find_word`, which keeps its sign, point or comma where it can."""
    return f"{line[: word.start(2)]}{write_like(word[2], value)}{line[word.end(2) :]}"


def write_like(number: str, value: str, language: str = "") -> str:
    """A number as another one is written: with its point or comma, and its sign, as most numbers of Klartext have."""
    if "," in number:
        value = value.replace(".", ",")
    elif "." in number and "." not in value:
        value = f"{value}."
    has_sign = number.startswith("+") or (number.startswith("-") and language == "heidenhain")
    return f"+{value}" if has_sign and not value.startswith("-") else value


def add_angle(line: str, letter: str, value: str) -> str | None:
    """A line that gets a rotary word, behind its last linear one; None where it has no such word, or this letter."""
    if re.search(rf"(?<![A-Za-z_])I?{letter}(?![A-Za-z])", remove_remarks(line), re.IGNORECASE):
        return None
    ends = [word.end() for axis in "XYZ" for word in _list_words(line, axis)]
    return f"{line[: max(ends)]} {letter}{value}{line[max(ends) :]}" if ends else None


def name_component(language: str, component: int) -> str:
    """The word of a component of the tool axis."""
    return _VECTOR_LETTERS.get(language, ("I", "J", "K"))[component]


def change_vector(line: str, language: str, vector: Iterable[float]) -> tuple[str, str] | None:
    """The words of a tool axis as they stand in a line, and with another one; None where it is not written out."""
    words = _find_vector(line, language)
    numbers = (f"{round(value, 7) + 0.0:.7f}".rstrip("0").rstrip(".") for value in vector)
    right = [write_like(line[first:last], number) for (_, first, last), number in zip(words, numbers, strict=False)]
    return _write_vector(line, words, right)


def flip_component(line: str, language: str, component: int) -> tuple[str, str, str] | None:
    """The words of a tool axis in a line, and with the other sign of one component, and its number then; or None."""
    words = _find_vector(line, language)
    right = [line[first:last] for _, first, last in words]
    if len(right) < 3:
        return None
    now = right[component]
    right[component] = now[1:] if now.startswith("-") else f"-{now.lstrip('+')}"
    changed = _write_vector(line, words, right)
    return None if changed is None else (*changed, right[component])


def _find_vector(line: str, language: str) -> list[tuple[int, int, int]]:
    """Where the words of a tool axis begin, and where their numbers begin and end."""
    if language == "aptcl":
        found = _GOTO.search(remove_remarks(line, language))
        return [] if found is None else [(found.start(group), *found.span(group)) for group in (1, 2, 3)]
    letters = (find_word(line, name_component(language, one)) for one in range(3))
    return [(word.start(), *word.span(2)) for word in letters if word is not None]


def _write_vector(line: str, words: Sequence[tuple[int, int, int]], numbers: Sequence[str]) -> tuple[str, str] | None:
    """The words of a tool axis as they stand, and with other numbers."""
    if len(words) < 3:
        return None
    begin, end, changed = min(word[0] for word in words), max(word[2] for word in words), line
    for (_start, first, last), number in sorted(zip(words, numbers, strict=True), reverse=True):
        changed = f"{changed[:first]}{number}{changed[last:]}"
    return line[begin:end], changed[begin : len(changed) - len(line) + end]
