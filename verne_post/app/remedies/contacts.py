"""What keeps a tool out of the stock besides another end of its line: heights of a cycle, and a longer stick-out."""

import dataclasses
import math
import re
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.app.explain_numbers import format_number
from verne_post.app.remedies.lines import Line, is_of_cycle
from verne_post.app.remedies.trials import is_short, try_program
from verne_post.base.long_text import Text
from verne_post.base.program_lines import remove_remarks, write_like
from verne_post.gcode.codes import CYCLES
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.line_words import Word
from verne_post.gcode.pasted_line import find_cycle_call, find_given_values
from verne_post.model.findings import Finding, Remedy, join_lines
from verne_post.model.moves import find_tool_of_moves
from verne_post.model.part_setup import describe_tool_number

#: A height or a length is sought in steps of this, mm.
STEP_MM: Final = 0.1
#: In a program in inches, inch.
_STEP_INCH: Final = 0.005
#: A decimal point one place too far to the right; and the share of a depth that is beyond a limit then.
_TOO_DEEP: Final = 10.0
_SHARE_BEYOND: Final = 3.0
#: Doublings of the depth of the contact at which a height is sought.
_DOUBLINGS: Final = 7
_NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)"
#: A letter of a cycle of RS274 with its number.
_OF_RS274: Final = {
    letter: re.compile(rf"(?<![A-Z_]){letter}\s*({_NUMBER})(?![\d.])", re.IGNORECASE) for letter in "RZ"
}
#: A cycle of a CL file, and its depth.
_CYCLE_OF_CL: Final = re.compile(r"[ \t]*+CYCLE[ \t]*+/", re.IGNORECASE)
_DEPTH_OF_CL: Final = re.compile(rf"(?<![A-Z])DEPTH\s*,\s*({_NUMBER})(?![\d.])", re.IGNORECASE)
#: What begins, and what ends, a cycle of RS274 that holds from line to line.
_BEGINS: Final = re.compile(rf"(?<![A-Z_])G0*({'|'.join(str(code // 10) for code in CYCLES)})(?![\d.])", re.IGNORECASE)
_ENDS: Final = re.compile(r"(?<![A-Z_])G0*(?:80|[0-3])(?![\d.])", re.IGNORECASE)
_MODAL_CALL: Final = re.compile(r"\bMCALL\b", re.IGNORECASE)
#: The heights of cycles in the order in which they are tried, and what they are called.
_NAMES: Final = {
    "R": "R",
    "SDIS": "safety clearance SDIS",
    "RTP": "retraction plane RTP",
    "Q200": "set-up clearance Q200",
    "Q204": "second set-up clearance Q204",
}
#: What a cycle calls the depth of its holes.
_DEPTHS: Final = ("DP", "DPR", "Q201")


class _Height(Struct, frozen=True):
    """A number of a cycle from which its rapids follow."""

    cycle: str  #: Its name, and the line that calls or defines it.
    name: str
    line: int
    text: str  #: Of the line.
    begin: int  #: Of the number in it, from 0.
    number: str
    call: int = -1  #: Where the call begins that gives the number by its order.
    #: The plane, earlier in the call, that is raised with this clearance, and how far above its value at least.
    plane: "_Height | None" = None
    base: float = 0.0

    def write(self, value: str) -> str:
        """The line with another number."""
        text = self.text[: self.begin] + value + self.text[self.begin + len(self.number) :]
        return text if self.plane is None else replace(self.plane, text=text).write(self.raise_plane(value))

    def raise_plane(self, value: str) -> str:
        """The number of the plane, not below another clearance."""
        return format_number(max(float(self.plane.number) if self.plane else 0.0, self.base + float(value)))

    def describe(self, value: str) -> str:
        """What becomes what."""
        raised = f"{self.plane.describe(self.raise_plane(value))} and " if self.plane else ""
        return f"{raised}{_NAMES[self.name]} {value} instead of {format_number(float(self.number))}"

    def make_remedy(self, text: str, value: str) -> Remedy:
        """The edit that writes another number."""
        if self.call < 0:
            return Remedy(text, value, line=self.line, word=(self.name, float(self.number)))
        end, new = self.begin + len(self.number), self.write(value)
        right = new[self.call : len(new) - len(self.text) + end]
        return Remedy(text, right, line=self.line, misspelt=self.text[self.call : end])


def name_heights(source: Text, program: Program, line: Line) -> str:
    """The heights that :func:`propose_heights` tries for the contacts of a line; empty where there are none."""
    asked = any(_is_of_heights(program, line, item) for item in line.findings)
    heights = _list_in_force(source, program, line) if asked else []
    names = " and ".join(_NAMES[height.name] for height in heights if height.plane is None)
    return f"{names} of {heights[0].cycle}" if heights else ""


def _is_of_heights(program: Program, line: Line, item: Finding) -> bool:
    """Whether heights of a cycle may be what is wrong."""
    return _is_contact(program, item) and item.message.startswith("the cutter") and is_of_cycle(line)


def propose_heights(source: Text, program: Program, line: Line, item: Finding) -> Iterator[Remedy]:
    """The lowest clearance or retraction of a cycle, in steps, with which its rapids keep out of the stock.

    They do so in all lines that the same call executes; where none is found, in this line, and the others are named.
    """
    if not _is_of_heights(program, line, item):
        return
    lines = bytes(source).split(b"\n")
    scale = line.unit[1]
    step = STEP_MM if scale == 1.0 else _STEP_INCH
    heights = _list_in_force(source, program, line, step)

    @cache
    def list_left(number: int, text: str) -> tuple[list[Finding], list[int]] | None:
        """The errors in this line, and the other lines of the call that have a contact."""
        changed = text.encode("utf-8", errors="surrogateescape")
        tried = try_program(b"\n".join([*lines[: number - 1], changed, *lines[number:]]), program, only_lines=True)
        if tried is None:
            return None
        left = tried[1]
        first, last = item.line or 0, item.last_line or 0
        own = [one for one in left if (one.line or 0) <= last and first <= (one.last_line or 0)]
        contacts = [one.line or 0 for one in left if one.code == "VP216" and one not in own]
        return own, [at for at in contacts if _is_of_call(source, program, at, heights[0])]

    for is_strict in (True, False):
        for height in heights:
            first = math.floor(float(height.number) / step + 1e-6)

            def is_right(count: int, height: _Height = height, first: int = first, strict: bool = is_strict) -> bool:
                left = list_left(height.line, height.write(format_number((first + count) * step)))
                return left is not None and not left[0] and not (strict and left[1])

            count = _find_steps(is_right, -(item.value or 0.0) / (step * scale))
            if count is not None:
                then = format_number((first + count) * step)
                where = f" in line {height.line}" if height.line != line.number else ""
                text = f"{height.describe(then)}{where}, one step of {step:g} above the lowest found"
                left = list_left(height.line, height.write(then))
                if left is not None and left[1]:
                    text += f"; a contact remains in {join_lines(dict.fromkeys(sorted(left[1])))}"
                yield height.make_remedy(text, then)
                return


def _is_of_call(source: Text, program: Program, number: int, height: _Height) -> bool:
    """Whether a line is executed by the call that gives a height."""
    return any(one.cycle == height.cycle for one in _list_heights(source, program, number))


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

    @cache
    def list_codes() -> set[str]:
        tried = try_program(source, program, only_lines=True)
        return set() if tried is None else {one.code for one in tried[1]}

    own = set(moves.line[find_tool_of_moves(np.arange(len(moves.line)), 0, moves) == number].tolist())

    def is_right(count: int) -> bool:
        more = count * STEP_MM
        longer = dataclasses.replace(below, length=(below.length or 0.0) + more)
        change: dict[str, Any] = {
            "tool_shapes": {**options.tool_shapes, number: (*shape[: at - 1], longer, *shape[at:])}
        }
        if options.tool_length is not None:
            change["tool_length"] = before + more
        elif tool is not None:
            offset = (*tool.offset[:2], before + more, *tool.offset[3:])
            change["tools"] = {**(options.tools or {}), number: dataclasses.replace(tool, offset=offset)}
        for only_first in ("holder", False):
            tried = try_program(source, program, only_first=only_first, only_lines=True, **change)
            left = [] if tried is None else tried[1]
            touches = [one.line in own for one in left if one.message.startswith("the holder")]
            if not touches or any(touches):  # else that of another tool, behind which nothing was cut
                break
        if tried is None or any(touches):
            return False
        new = {one.code for one in left} - {item.code}
        return not new or new <= list_codes()

    count = _find_steps(is_right, -(item.value or 0.0) / STEP_MM) if before > 0.0 else None
    if count is None:
        return None
    more = count * STEP_MM
    tool_name = describe_tool_number(number, program.moves.name_tools())
    return Remedy(
        f"stick-out of {tool_name} {format_number(more)} mm more, its length {format_number(before + more)} instead "
        f"of {format_number(before)} mm: no holder contact of this tool is left, and no other kind of error appears"
    )


def _is_contact(program: Program, item: Finding) -> bool:
    return is_short(program) and item.code == "VP216" and item.severity == "error" and item.value is not None


def _find_steps(is_right: Callable[[int], bool], depth: float) -> int | None:
    """The fewest whole steps, not fewer than the depth of the contact, for which a question is true, and one more.

    One step more than the fewest keeps the bodies apart.
    """
    ask = cache(is_right)
    least = max(1, math.floor(depth))
    tried = (least, *((least + 1) * 2**k for k in range(_DOUBLINGS)))
    right = next(filter(ask, tried), None)
    if right is None:
        return None
    wrong = max((count for count in tried if count < right), default=right - 1)
    while right - wrong > 1:
        middle = (right + wrong) // 2
        wrong, right = (wrong, middle) if ask(middle) else (middle, right)
    return right + 1 if ask(right + 1) else None


def _list_heights(source: Text, program: Program, number: int, step: float = STEP_MM) -> list[_Height]:
    """The heights of the cycle that a line is executed by, in the order in which they are tried.

    Last comes SDIS with the plane RTP, a ``step`` above it: at RTP a tool goes from hole to hole.
    """
    dialect = choose_dialect_name(program.options.dialect, source, program.options.source_name)
    lines = bytes(source).decode("utf-8", errors="surrogateescape").split("\n")
    if dialect in ("rs274", "fanuc"):
        return _list_of_rs274(lines, number, "R")
    call = _find_call(lines, number, dialect)
    if call is None:
        return []
    line, found = call
    values = find_given_values(lines, line, dialect)
    begin = -1 if dialect == "heidenhain" else found.begin
    heights = [
        _Height(f"{found.name} in line {line}", name, value.line, lines[value.line - 1], value.begin, value.text, begin)
        for name, value in ((name, values[name]) for name in _NAMES if name in values)
        if re.fullmatch(_NUMBER, value.text)
    ]
    by_name = {height.name: height for height in heights}
    if by_name.keys() >= {"SDIS", "RTP"} and "RFP" in values and re.fullmatch(_NUMBER, values["RFP"].text):
        plane, reference = by_name["RTP"], float(values["RFP"].text)
        if float(plane.number) > reference:  # out of the hole is up
            heights.append(replace(by_name["SDIS"], plane=plane, base=reference + step))
    return heights


def find_shallow_depth(source: Text, program: Program, number: int, beyond: float) -> tuple[Text, Remedy] | None:
    """The program, and the edit, with a tenth of the depth of the cycle that a line is executed by.

    None where that is not probable: the line goes ``beyond`` its limit, in the unit of the program, by less than a
    third of the depth.
    """
    dialect = choose_dialect_name(program.options.dialect, source, program.options.source_name)
    lines = bytes(source).decode("utf-8", errors="surrogateescape").split("\n")
    if dialect in ("rs274", "fanuc"):
        depths = _list_of_rs274(lines, number, "Z")
    elif (call := _find_call(lines, number, dialect)) is not None:
        values, begin = find_given_values(lines, call[0], dialect), -1 if dialect == "heidenhain" else call[1].begin
        depths = [
            _Height("", name, one.line, lines[one.line - 1], one.begin, one.text, begin)
            for name in _DEPTHS
            if (one := values.get(name)) is not None and re.fullmatch(_NUMBER, one.text)
        ]
    else:
        depths = [] if dialect != "aptcl" else _list_of_cl(lines, number)
    if not depths or beyond * _SHARE_BEYOND < abs(float(depths[0].number)) or not float(depths[0].number):
        return None
    depth, then = depths[0], write_like(depths[0].number, format_number(float(depths[0].number) / _TOO_DEEP))
    lines[depth.line - 1] = depth.write(then)
    said = f"{depth.name} {then} may be meant instead of {depth.number} in line {depth.line}: within limits with it"
    changed = "\n".join(lines).encode("utf-8", errors="surrogateescape")
    return changed, dataclasses.replace(depth.make_remedy(said, then), is_choice=True)


def _list_of_cl(lines: Sequence[str], number: int) -> list[_Height]:
    """The depth of the CYCLE statement of a CL file that is in force in a line."""
    for at in range(number, 0, -1):
        if _CYCLE_OF_CL.match(lines[at - 1]):
            words = (_DEPTH_OF_CL.search(lines[at - 1]),)
            return [_Height("", "DEPTH", at, one.string, one.start(1), one[1], one.start()) for one in words if one]
    return []


def _list_in_force(source: Text, program: Program, line: Line, step: float = STEP_MM) -> list[_Height]:
    """The heights that a line is executed with: a jump or a subprogram may have given others than the text above it."""
    state, found = line.state, _list_heights(source, program, line.number, step)
    if state is None:
        return found

    def is_in_force(height: _Height) -> bool:
        if height.name.startswith("Q"):
            return state.look_up(height.name) == float(height.number)
        cycle = state.modes.cycle
        if height.name == "R":
            return cycle is None or bool(cycle.numbers[0] == float(height.number))
        return height.line == line.number or height.cycle.startswith(f"{cycle} ")

    return [height for height in found if is_in_force(height)]


def _find_call(lines: Sequence[str], number: int, dialect: str) -> tuple[int, Word] | None:
    """The line, and the call in it, of the cycle that a line executes: its own, or the last that is in force."""
    if dialect not in ("siemens", "heidenhain"):
        return None
    for at in range(number, 0, -1):
        is_modal = dialect == "heidenhain" or _MODAL_CALL.search(remove_remarks(lines[at - 1], dialect)) is not None
        found = find_cycle_call(lines[at - 1], dialect) if is_modal or at == number else None
        values = {} if found is None else find_given_values(lines, at, dialect)
        if found is not None and not values.keys().isdisjoint(_NAMES):
            return at, found
        if is_modal and dialect == "siemens":  # MCALL alone, or with a cycle without heights
            return None
    return None


def _list_of_rs274(lines: Sequence[str], number: int, letter: str) -> list[_Height]:
    heights: list[_Height] = []
    for at in range(number, 0, -1):
        code = remove_remarks(lines[at - 1])
        found = _OF_RS274[letter].search(code)
        if not heights and found is not None:
            heights = [_Height("", letter, at, lines[at - 1], found.start(1), found[1])]
        if begin := _BEGINS.search(code):
            return [replace(height, cycle=f"G{begin[1]} in line {at}") for height in heights]
        if _ENDS.search(code):
            break
    return []
