"""Pitches of taps that no thread has, or not that of the program's remark (VP505)."""

import re
from collections.abc import Iterator
from typing import Final

from verne_post.app.source_text import take_line_of_move
from verne_post.base.long_text import Text, decode_lines
from verne_post.base.program_lines import remove_remarks
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.machining.holes import METRIC_PITCH
from verne_post.gcode.remarks import find_tool_remarks
from verne_post.model.findings import Finding, make_finding
from verne_post.model.moves import Moves, Tap
from verne_post.model.options import Options
from verne_post.model.part_setup import describe_tool_number, list_setup_names
from verne_post.model.plausibility import PLAUSIBLE

_OWNER: Final = r"(TAP|COLLET|CHUCK|HOLDER)"
#: M8, M8X1, M10x1,25 in a remark about a tool, with what stands before and behind it; M08 is a code, and so is M3
#: before S.
_THREAD: Final = re.compile(
    rf"(?:\b{_OWNER}S?\W*+)?+(?<![A-Z0-9.])M(?![34]\s*S\s*\d)([1-9]\d?)(?![A-WYZ\d]|[.,]\d)"
    rf"(?:\s*[X*]\s*(\d(?:[.,]\d{{1,3}})?)(?![\d.,]))?(?=(?:\W*+{_OWNER}S?\b)?+)"
)
#: Another thread, as 1/2-13, 4-40, 8X1.25, and another diameter, as 8 MM or 1/2: M beside it may be a code.
_OTHER_THREAD: Final = re.compile(
    r"(?<![MX\d.,])\d++(?:[.,/]\d++)?+\s*+(?:-\s*+([1-9]\d?)(?!\d)|X\s*+(\d(?:[.,]\d{1,3})?)(?![\d.,]))"
)
_OTHER_DIAMETER: Final = re.compile(
    r"(?<![MX\d.,/-])([1-9]\d?(?:[.,]\d{1,3})?)\s*+(?:MM\b|/\s*+(2|4|8|16|32|64)(?![\d.,/]))"
)
#: No thread of an inch size has a larger pitch, as a share of the diameter: that of 1/8 NPT.
_OF_INCH: Final = 0.3
#: Fine threads of a size have a smaller pitch than the coarse one, and none a larger: bounds of it, as shares.
_OF_COARSE: Final = (0.25, 1.15)
#: Siemens cycle -> the places of its pitches among the values; the first that is given counts.
_PITCHES: Final = {"84": (("PIT", 8), ("MPIT", 7)), "840": (("PIT", 10), ("MPIT", 9))}
#: A floating holder is fed a little less than the pitch that the remark gives.
_OF_GIVEN: Final = (0.85, 1.15)


def check_pitches(source: Text, moves: Moves, options: Options, from_move: int = 0) -> Iterator[Finding]:
    """VP505: threads whose pitch is not that of the tool's remark, or that no tap of its diameter, or none, has."""
    taps = [tap for tap in moves.taps if tap.before >= from_move and tap.pitch]
    if not taps:
        return
    names = {**list_setup_names(options.control), **moves.name_tools()}
    dialect = choose_dialect_name(options.dialect, source, options.source_name)
    remarks = find_tool_remarks(decode_lines(source), dialect)
    for tap in taps:
        name = names.get(tap.tool or 0, "")
        if reason := _find_reason(tap, remarks.get(str(tap.tool)) or remarks.get(name) or name, options, names):
            line = take_line_of_move(source, options, moves.called_lines, tap.line)
            word, column = _find_word(remove_remarks(line, dialect), dialect)
            text = f"{tap.pitch:g} mm a turn is no pitch of this tap: {reason}; correct {word}"
            yield make_finding("VP505", text, line=tap.line, column=column)


def _find_word(line: str, dialect: str) -> tuple[str, int | None]:
    """What gives the pitch in a line of a program, in words of its language, and its column."""
    by_speed = " (pitch times S)"
    if dialect == "heidenhain":
        found = re.search(r"Q0*(239|206)[ \t]*=", line, re.IGNORECASE)
        word = f"Q{found[1]}{by_speed if found[1] == '206' else ''}" if found else "Q239"
        return word, found and found.start() + 1
    if dialect == "siemens":
        call = re.search(r"CYCLE(84|840)[ \t]*\(((?:[^()]|\([^()]*\))*)", line, re.IGNORECASE)
        if call is None:
            return "PIT or MPIT", None
        values = call[2].split(",")
        for name, at in _PITCHES[call[1]]:
            if (value := "".join(values[at : at + 1])).strip(" \t+-0."):
                before = sum(len(one) + 1 for one in values[:at]) + len(value) - len(value.lstrip())
                return f"{name}, value {at + 1} of CYCLE{call[1]}", call.start(2) + before + 1
        return f"F{by_speed}", None
    if dialect == "aptcl":
        return "the pitch", None
    found = re.search(r"F[ \t]*(?=[-+.\d#\[=])", line, re.IGNORECASE)
    return "F (pitch times S; under G95, the pitch)", found and found.start() + 1


def _is_of_another(pitch: float, remark: str) -> bool:
    """Whether a remark names another thread of this pitch, or a diameter that has it."""
    given = [25.4 / float(turns) if turns else _read(other) for turns, other in _OTHER_THREAD.findall(remark)]
    bounds = [[one * by for by in _OF_GIVEN] for one in given]
    for size, part in _OTHER_DIAMETER.findall(remark):
        coarse = METRIC_PITCH.get(_read(size), 0.0)
        bounds.append(
            [0.0, _OF_INCH * 25.4 * _read(size) / float(part)] if part else [coarse * by for by in _OF_COARSE]
        )
    return any(low <= pitch <= high for low, high in bounds)


def _read(number: str) -> float:
    return float(number.replace(",", ".") or 0.0)


def _find_reason(tap: Tap, remark: str, options: Options, names: dict[int, str]) -> str:
    """Why a tap cannot have this pitch; empty where it can."""
    found = [(size, given, before or after) for before, size, given, after in _THREAD.findall(remark.upper())]
    of_taps = {one[:2] for one in found if one[2] == "TAP"}
    threads = of_taps or {one[:2] for one in found if not one[2]}
    if len(threads) == 1:
        ((size, given),) = threads
        coarse, pitch = METRIC_PITCH.get(float(size), 0.0), _read(given)
        is_given = 0.0 < pitch <= coarse  # M8X20 has a length
        low, high = (pitch * by for by in _OF_GIVEN) if is_given else (coarse * by for by in _OF_COARSE)
        is_other = not is_given and _is_of_another(tap.pitch, remark.upper())
        if coarse and not is_other and not low <= tap.pitch <= high:
            thread = f"M{size}X{pitch:g}" if is_given else f"M{size}, whose coarse pitch is {coarse:g} mm"
            return f"the program says of its tool that it is {thread}"
    plausible = PLAUSIBLE["pitch of a tap"]
    tool = (options.tools or {}).get(tap.tool or 0)
    if tool is not None and 0.0 < tool.diameter < tap.pitch:
        return f"{describe_tool_number(tool.number, names)} has a diameter of {tool.diameter:g} mm"
    if tap.pitch > plausible.high:
        return f"none has more than {plausible.high:g} mm"
    return f"none has less than {plausible.low:g} mm" if tap.pitch < plausible.low else ""
