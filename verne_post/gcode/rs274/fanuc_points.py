"""Words of Fanuc programs without a decimal point: X20 is 20 mm or 20 least increments, by a setting."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from verne_post.base.arrays import Ints
from verne_post.base.long_text import Text, take_line
from verne_post.gcode.block import Block
from verne_post.gcode.machining.state import State
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.fanuc_codes import NURBS, PATTERNS, PLANE, POCKETS, ROTATION
from verne_post.gcode.setup import Setup
from verne_post.gcode.words import read_whole_lines
from verne_post.model.findings import CalledPlace, Finding, make_finding
from verne_post.model.moves import FeedMode

#: Least input increment (IS-B): of lengths in mm and in inches, of angles in degrees and of dwells in seconds.
INCREMENT: Final = 1e-3
_INCREMENT_INCH: Final = 1e-4
#: A value is a whole number of increments to within this share of one: rounding of expressions stays far below.
_WHOLE_INCREMENTS: Final = 1e-6
_ANGLES: Final = "ABC"
_LENGTHS: Final = "XYZUVWIJKRQ"
#: What is no word: comments, what follows a %, and levels of G5.1.
_SILENT: Final = rb"\([^)\n]*|;[^\n]*|^[ \t]*%[^\n]*|G0*5\.1[^\n]*"
_LETTER: Final = rb"|(?<![A-Z])([A-CFI-KQRU-Z])[ \t]*+[+-]?+[ \t]*+"
#: Words with a number that has a decimal point, and those of one that has none and is not 0; group 1 is the letter.
#: A number with the letter O or a comma in place of the point is an error of its own; ``,R5`` is a corner.
_POINTED_WORD: Final = re.compile(_SILENT + _LETTER + rb"[0-9 \t]*+\.", re.IGNORECASE | re.MULTILINE)
_BARE: Final = re.compile(
    _SILENT + _LETTER + rb"[0 \t]*+[1-9](?:[ \t]*[0-9])*+(?![ \t]*(?:[.O]|,[ \t]*[0-9]))", re.IGNORECASE | re.MULTILINE
)
#: A word whose value is computed.
_COMPUTED_WORD: Final = re.compile(r"(?<![A-Z])([A-CX-Z])[ \t]*+[+-]?+[ \t]*+[#\[]", re.IGNORECASE)
_UNIT: Final = re.compile(_SILENT + rb"|(G[ \t]*0*2[ \t]*[01])(?![0-9.])", re.IGNORECASE | re.MULTILINE)
#: A length with so many decimals as programs in inches have.
_FINE: Final = re.compile(_SILENT + rb"|(?<![A-Z])([XYZ])[ \t]*+[+-]?+[0-9]*+\.[0-9]{4}", re.IGNORECASE | re.MULTILINE)
_DWELL: Final = re.compile(rb"G0*4(?![0-9.])", re.IGNORECASE)
_REMARK: Final = re.compile(rb"\([^)\n]*\)?|;.*")
#: Codes beside which I, J and K are angles, unless they are the directions of P3; and those beside which R is one.
_TILT: Final = re.compile(rb"G[ \t]*0*68[ \t]*\.[ \t]*20*(?![0-9])", re.IGNORECASE)
_DIRECTIONS: Final = re.compile(rb"P[ \t]*0*3(?![0-9])", re.IGNORECASE)
_TURN: Final = re.compile(rb"G[ \t]*0*68(?![0-9])", re.IGNORECASE)
_WEIGHTS: Final = re.compile(rb"G0*6\.2", re.IGNORECASE)
#: Words that are lengths, angles or times wherever they stand; and R, but where it may be a weight.
_PLAIN: Final = b"XYZUVWABC"


def find_mixtures(source: Text, recorder: Recorder, setup: Setup, errors: Iterable[Finding]) -> Iterator[Finding]:
    """VP038: words both with and without a decimal point, and nobody has described the control.

    One finding for the program, and one for each file that it has called, at the first call. Words of lines that have
    an error lack no point: a letter may stand in place of it.
    """
    called_texts = {setup.name_file(name, "ngc"): text for name, text in setup.subroutines.items()}
    texts = {"": source, **{name: called_texts[name] for name in recorder.lines.other_files if name in called_texts}}
    pointed_lines = {name: _find_pointed_line(text) for name, text in texts.items()}
    in_error = {("", item.line) if item.called is None else item.called[:2] for item in errors}
    for name, text in texts.items():
        own = name if pointed_lines[name] else next((one for one, line in pointed_lines.items() if line), None)
        if own is None:
            continue
        letters = _list_letters(text)
        bare = [one for one in _find_words(text, _BARE, letters) if (name, one[0]) not in in_error]
        if bare:
            there = "" if own == name else f" of {own}" if own else " of the program"
            of_units = text if _has_unit(text) else source
            found = _report_mixture(text, bare, f"line {pointed_lines[own]}{there}", of_units)
            if name:
                line, place = recorder.lines.other_files[name], CalledPlace(name, found.line or 1, found.column)
                found = replace(found, called=place, line=line, last_line=line, worst_line=line, column=None)
            yield found


def _find_pointed_line(source: Text) -> int | None:
    """The first line with a decimal point."""
    return next((line for line, _column, _word in _find_words(source, _POINTED_WORD, _list_letters(source))), None)


def _list_letters(source: Text) -> bytes:
    """Letters whose numbers controls may count in increments; I, J and K alone where they are angles of a plane."""
    letters = _PLAIN if _WEIGHTS.search(source) is not None else _PLAIN + b"R"
    return letters + (b"IJK" if _TILT.search(source) is not None else b"")


def _is_counted(match: "re.Match[bytes]", letters: bytes) -> bool:
    """Whether a word is one of some letters, I, J and K in a line of G68.2 alone."""
    if match[1] is None or match[1].upper() not in letters:
        return False
    if match[1].upper() not in b"IJK":
        return True
    text = match.string
    end = text.find(b"\n", match.start())
    line = text[text.rfind(b"\n", 0, match.start()) + 1 : end if end >= 0 else len(text)]
    line = _REMARK.sub(b"", line)
    return _TILT.search(line) is not None and _DIRECTIONS.search(line) is None


def list_missing_points(text: str) -> list[int]:
    """Where a program lacks a decimal point, behind each number without one."""
    source = text.encode("ascii", errors="replace")
    letters = _list_letters(source)
    return [one.end() for one in _BARE.finditer(source) if _is_counted(one, letters)]


def _has_unit(source: Text) -> bool:
    """Whether a text has G20 or G21."""
    return any(match[1] is not None for text in read_whole_lines(source) for match in _UNIT.finditer(text))


def find_length_without_unit(source: Text, *, only_fine: bool = False) -> int | None:
    """Line of the first X, Y or Z of a program that has neither G20 nor G21; None where it has one, or no lengths.

    With ``only_fine`` a length counts that has four decimals.
    """
    if _has_unit(source):
        return None
    patterns = (_FINE,) if only_fine else (_POINTED_WORD, _BARE)
    found = [next(_find_words(source, pattern, b"XYZ"), None) for pattern in patterns]
    return min((place[0] for place in found if place is not None), default=None)


def _find_words(source: Text, pattern: "re.Pattern[bytes]", letters: bytes) -> Iterator[tuple[int, int, str]]:
    """Line, column and text of the words of some letters that a pattern finds."""
    line = 1
    for text in read_whole_lines(source):
        start = 0
        for match in pattern.finditer(text):
            if _is_counted(match, letters):
                begin = match.start()
                line += text.count(b"\n", start, begin)
                start = begin
                yield line, begin - text.rfind(b"\n", 0, begin), match.group().decode("ascii")
        line += text.count(b"\n", start)


def _report_mixture(source: Text, bare: list[tuple[int, int, str]], pointed_line: str, of_units: Text) -> Finding:
    """What the first word is here, what it would be for a control that counts increments, and how many there are.

    ``of_units`` is the text that says G20 or G21.
    """
    (line, column, word), last_line = bare[0], bare[-1][0]
    number = "".join(word[1:].split())
    code = _REMARK.sub(b"", take_line(source, line) or b"")
    if _DWELL.search(code) is not None:
        units = ["s"]
    elif word[0].upper() in f"{_ANGLES}IJK" or (word[0].upper() == "R" and _TURN.search(code) is not None):
        units = ["degrees"]
    else:
        named_codes = {
            match[1][-1:] for text in read_whole_lines(of_units) for match in _UNIT.finditer(text) if match[1]
        }
        units = [unit for unit, code in (("mm", b"1"), ("inch", b"0")) if not named_codes or code in named_codes]
    steps = [
        f"{float(number) * (_INCREMENT_INCH if unit == 'inch' else INCREMENT):.9f}".rstrip("0").rstrip(".")
        for unit in units
    ]
    counted_values = " or ".join(f"{step} {unit}" for step, unit in zip(steps, units, strict=True))
    subject, it, point = f"{word} has", "it", f"point ({word}.)"
    if len(bare) > 1:
        lines = f"line {line}" if last_line == line else f"lines {line} to {last_line}"
        subject, it, point = f"{len(bare)} words ({word} first; {lines}) have", word, "points"
    return make_finding(
        "VP038",
        f"{subject} no decimal point, and words of {pointed_line} have one: {it} is read as {number} "
        f"{' or '.join(units)}; a control set otherwise counts increments, and reads {counted_values}; write the "
        f'{point}, or say which is meant: [fanuc] decimal_point = "calculator" ({number} {units[0]}) or '
        f'"conventional" ({steps[0]} {units[0]}) in verne-post.toml',
        advice="",
        line=line,
        column=column,
    )


def find_lines_without_point(text: bytes) -> Ints:
    """Lines of a chunk, from 0, that have a word without a decimal point, other than 0."""
    places = [match.start() for match in _BARE.finditer(text) if match[1] is not None]
    ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n"))
    return np.unique(np.searchsorted(ends, places)).astype(np.int32)


def scale_words(block: Block, text: str, state: State, *, drills: bool) -> None:
    """Read the words of a block that have no decimal point as least input increments; the block changes in place.

    Parameters
    ----------
    block : Block
    text : str
        The line, with its corner.
    state : State
        Before the block.
    drills : bool
        The words are those of a canned cycle.
    """
    raw = text.encode("ascii", errors="replace")
    bare, sizes = set(), 0
    for match in _BARE.finditer(raw):
        if match[1] is not None and raw[: match.start()].rstrip().endswith(b","):
            sizes += 1  # that of the corner: a line has one
        elif match[1] is not None:
            bare.add(match[1].decode("ascii").upper())
    codes = {round(number * 10) for letter, number, _column in block.codes if letter == "G"}
    inch = 200 in codes or (state.modes.inch and 210 not in codes)
    spline = NURBS in codes or (state.modes.motion == NURBS and not codes)
    if block.corner is not None and sizes:
        block.corner = block.corner[0], block.corner[1] * (_INCREMENT_INCH if inch else INCREMENT)
    for letter in bare & set(block.words):
        if letter == "F":
            if 950 in codes or (state.feed_mode == FeedMode.PER_REVOLUTION and not codes & {930, 940}):
                raise block.error(
                    "VP007", "F per turn without a decimal point: controls count it in different increments", "F"
                )
            continue
        if letter == "Q" and not drills and not codes.intersection(POCKETS):
            continue
        if (letter == "K" and drills and "I" not in block.words) or (spline and letter in "KR"):
            continue  # repeats, knots and weights
        if letter in "IJK" and (state.modes.vectors or 435 in codes):
            continue  # a direction has no unit
        angle = (
            letter in _ANGLES
            or (letter in "IJK" and PLANE in codes)
            or (letter == "R" and ROTATION in codes)
            or (letter in "JK" and codes.intersection(PATTERNS))
        )
        time = 40 in codes and letter in "XU"
        block.words[letter] *= _INCREMENT_INCH if inch and not angle and not time else INCREMENT


def find_unrounded(block: Block, text: str, state: State) -> str | None:
    """A computed word that has more digits than the least input increment; None where there is none."""
    for match in _COMPUTED_WORD.finditer(text):
        letter = match[1].upper()
        if letter in block.words:
            step = _INCREMENT_INCH if state.modes.inch and letter not in _ANGLES else INCREMENT
            steps = block.words[letter] / step
            if abs(steps - round(steps)) > _WHOLE_INCREMENTS * max(abs(steps), 1.0):
                return letter
    return None
