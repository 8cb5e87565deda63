"""What keeps a tool out of the stock besides another end of its line: heights of a cycle, and a longer stick-out."""

import dataclasses
import math
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.assemble import Program, assemble
from verne_post.app.constraints import check_program
from verne_post.app.explain_numbers import format_number
from verne_post.app.line_remedies import Line, is_of_cycle
from verne_post.base.least import find_least
from verne_post.base.long_text import Text
from verne_post.base.program_lines import remove_remarks
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.model.findings import Finding, InputError, Remedy
from verne_post.model.moves import find_tool_of_moves

#: A height or a length is sought in steps of this, mm, and in a program in inches.
STEP_MM: Final = 0.1
_STEP_INCH: Final = 0.005
#: A longer contour is not checked anew with other heights.
TRIED_ELEMENTS: Final = 20_000
#: Doublings of the depth of the contact at which a height is sought.
_DOUBLINGS: Final = 7
_NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)"
#: The heights of a Siemens cycle, its first and third value.
_OF_SIEMENS: Final = re.compile(
    rf"\bCYCLE8(?:[1-69]|40)\s*\(\s*(?P<RTP>{_NUMBER})\s*,[^,()]*,\s*(?P<SDIS>{_NUMBER})(?=\s*[,)])", re.IGNORECASE
)
#: Those of a Klartext cycle, each in a line of its own or behind others; not as the result of a formula.
_OF_KLARTEXT: Final = re.compile(
    rf"(?:^\s*(?:\d+\s+)?|CYCL\s+DEF\s.*?)(?P<all>(?P<name>Q20[04])\s*=\s*(?P<value>{_NUMBER}))(?![\w*/])",
    re.IGNORECASE,
)
_OF_RS274: Final = re.compile(rf"(?<![A-Z_])(?P<all>R\s*(?P<value>{_NUMBER}))(?![\d.])", re.IGNORECASE)
#: What begins, and what ends, a cycle that holds from line to line.
_BEGINS: Final = re.compile(r"(?<![A-Z_])G0*(?:7[346]|8[1-9])(?![\d.])", re.IGNORECASE)
_ENDS: Final = re.compile(r"(?<![A-Z_])G0*(?:80|[0-3])(?![\d.])", re.IGNORECASE)
#: What the heights are called.
_NAMES: Final = {
    "R": "R",
    "SDIS": "safety clearance SDIS",
    "RTP": "retraction plane RTP",
    "Q200": "set-up clearance Q200",
    "Q204": "second set-up clearance Q204",
}


class _Height(Struct, frozen=True):
    """A number of a cycle from which its rapids follow."""

    name: str
    line: int
    written: str  #: What stands in the line, by which an editor finds it.
    begin: int  #: Of the number in it.
    number: str

    def write(self, value: str) -> str:
        return self.written[: self.begin] + value + self.written[self.begin + len(self.number) :]


def has_heights(source: Text, program: Program, line: Line) -> bool:
    """Whether :func:`propose_heights` has numbers to try for the contacts of a line."""
    asked = any(_is_of_heights(program, line, item) for item in line.findings)
    return asked and bool(_list_heights(source, program, line.number))


def _is_of_heights(program: Program, line: Line, item: Finding) -> bool:
    """Whether heights of a cycle may be what is wrong."""
    return _is_contact(program, item) and item.message.startswith("the cutter") and is_of_cycle(line)


def propose_heights(source: Text, program: Program, line: Line, item: Finding) -> Iterator[Remedy]:
    """The lowest clearance or retraction of a cycle, in steps, with which its rapids keep out of the stock."""
    if not _is_of_heights(program, line, item):
        return
    lines = bytes(source).split(b"\n")
    scale = line.unit[1]
    step = STEP_MM if scale == 1.0 else _STEP_INCH
    for height in _list_heights(source, program, line.number):
        first = math.floor(float(height.number) / step + 1e-6)

        def write(count: int, height: _Height = height, first: int = first) -> str:
            return height.write(format_number((first + count) * step))

        def is_right(count: int, height: _Height = height, write: Callable[[int], str] = write) -> bool:
            old, new = height.written.encode(), write(count).encode()
            changed = lines[height.line - 1].replace(old, new, 1)
            text = b"\n".join([*lines[: height.line - 1], changed, *lines[height.line :]])
            left = _list_errors(text, program)
            return left is not None and not any(_is_in_lines_of(one, item) for one in left)

        count = _find_steps(is_right, -(item.value or 0.0) / (step * scale))
        if count is not None:
            then = format_number((first + count) * step)
            where = f" in line {height.line}" if height.line != line.number else ""
            now = format_number(float(height.number))
            text = f"{_NAMES[height.name]} {then} instead of {now}{where}, one step of {step:g} above the lowest found"
            yield Remedy(text, write(count), line=height.line, misspelt=height.written)
            return


def propose_stick_out(source: Text, program: Program, line: Line, item: Finding) -> Remedy | None:
    """How much farther a tool has to stick out of its holder to keep it out of the stock; None where none is found.

    The tool is as much longer. The program was checked with it.
    """
    if not _is_contact(program, item) or not item.message.startswith("the holder") or line.move < 0:
        return None
    options, moves = program.options, program.moves
    number = int(find_tool_of_moves(np.array([line.move]), 0, moves)[0])
    shape, tool = options.tool_shapes.get(number, ()), (options.tools or {}).get(number)
    at = next((k for k, one in enumerate(shape) if one.part == "holder"), 0)
    below = shape[at - 1] if at else None
    if below is None or below.length is None or below.profile or below.taper:
        return None
    before = options.tool_length if options.tool_length is not None else tool.offset[2] if tool is not None else 0.0
    had = {one.code for one in _list_errors(source, program) or ()}
    own = set(moves.line[find_tool_of_moves(np.arange(len(moves.line)), 0, moves) == number].tolist())

    def is_right(count: int) -> bool:
        more = count * STEP_MM
        longer = dataclasses.replace(below, length=(below.length or 0.0) + more)
        change: dict[str, object] = {
            "tool_shapes": {**options.tool_shapes, number: (*shape[: at - 1], longer, *shape[at:])}
        }
        if options.tool_length is not None:
            change["tool_length"] = before + more
        elif tool is not None:
            offset = (*tool.offset[:2], before + more, *tool.offset[3:])
            change["tools"] = {**(options.tools or {}), number: dataclasses.replace(tool, offset=offset)}
        left = _list_errors(source, program, change)
        return left is not None and not any(
            one.code not in had or (one.message.startswith("the holder") and one.line in own) for one in left
        )

    count = _find_steps(is_right, -(item.value or 0.0) / STEP_MM) if before > 0.0 else None
    if count is None:
        return None
    more = count * STEP_MM
    return Remedy(
        f"stick-out of tool {number} {format_number(more)} mm more, its length {format_number(before + more)} instead "
        f"of {format_number(before)} mm: no holder contact of this tool is left, and no other kind of error appears"
    )


def _is_contact(program: Program, item: Finding) -> bool:
    is_short = len(program.contour) <= TRIED_ELEMENTS
    return is_short and item.code == "VP216" and item.severity == "error" and item.value is not None


def _is_in_lines_of(one: Finding, item: Finding) -> bool:
    return (one.line or 0) <= (item.last_line or 0) and (item.line or 0) <= (one.last_line or 0)


def _find_steps(is_right: Callable[[int], bool], depth: float) -> int | None:
    """The fewest whole steps, not fewer than the depth of the contact, for which a question is true, and one more.

    With the fewest, bodies may rub.
    """
    least = max(1, math.floor(depth))
    tried = (least, *((least + 1) * 2**k for k in range(_DOUBLINGS)))
    found = find_least(lambda steps: math.ceil(steps) >= least and is_right(math.ceil(steps)), tried, 1.0)
    count = None if found is None else math.ceil(found) + 1
    return count if count is not None and is_right(count) else None


def _list_errors(source: Text, program: Program, change: dict[str, object] | None = None) -> list[Finding] | None:
    """The errors of a program with another text or other options; None where it cannot be read."""
    try:
        options = program.options.changed(**change) if change else program.options
        found = check_program(assemble(source, program.machine, options, program.team))[1]
    except InputError:
        return None
    return [item for item in found if item.severity == "error"]


def _list_heights(source: Text, program: Program, number: int) -> list[_Height]:
    """The heights of the cycle that a line is executed by, in the order in which they are tried."""
    dialect = choose_dialect_name(program.options.dialect, source, program.options.source_name)
    texts = bytes(source).split(b"\n")[:number]
    lines = [remove_remarks(text.decode("utf-8", errors="replace"), dialect) for text in texts]
    if dialect == "siemens":
        return _list_of_siemens(lines)
    if dialect == "heidenhain":
        return _list_of_klartext(lines)
    return _list_of_rs274(lines) if dialect in ("rs274", "fanuc") else []


def _list_of_siemens(lines: Sequence[str]) -> list[_Height]:
    for number in range(len(lines), 0, -1):
        if found := _OF_SIEMENS.search(lines[number - 1]):
            begin, end = found.start("RTP"), found.end("SDIS")
            written = lines[number - 1][begin:end]
            return [_Height(name, number, written, found.start(name) - begin, found[name]) for name in ("SDIS", "RTP")]
    return []


def _list_of_klartext(lines: Sequence[str]) -> list[_Height]:
    heights: dict[str, _Height] = {}
    for number in range(len(lines), 0, -1):
        for found in _OF_KLARTEXT.finditer(lines[number - 1]):
            name = found["name"].upper()
            written, begin = found["all"], found.start("value") - found.start("all")
            heights.setdefault(name, _Height(name, number, written, begin, found["value"]))
        if heights and re.search(r"\bCYCL\s+DEF\b", lines[number - 1]):
            break
    return [heights[name] for name in ("Q200", "Q204") if name in heights]


def _list_of_rs274(lines: Sequence[str]) -> list[_Height]:
    height = None
    for number in range(len(lines), 0, -1):
        found = _OF_RS274.search(lines[number - 1])
        if height is None and found is not None:
            height = _Height("R", number, found["all"], found.start("value") - found.start("all"), found["value"])
        if _BEGINS.search(lines[number - 1]):
            return [] if height is None else [height]
        if _ENDS.search(lines[number - 1]):
            break
    return []
