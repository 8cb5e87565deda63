"""What a letter of a line with its value means, as X10, H1 or T="EM10", and what it comes to in this program."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.explain_numbers import format_number
from verne_post.app.remedies.lines import Line
from verne_post.base.arrays import Array
from verne_post.base.program_lines import remove_remarks
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.codes import CYCLES
from verne_post.gcode.klartext.vocabulary import describe_parameter
from verne_post.gcode.letters import BESIDE_MOTION, LETTERS, LETTERS_OF_KLARTEXT, OF_LETTERS
from verne_post.gcode.line_words import Word
from verne_post.gcode.machining.state import State, name_unit_of_speed
from verne_post.gcode.parameters import POSITION
from verne_post.gcode.pasted_line import find_beside, find_words, list_codes
from verne_post.gcode.rs274.macro_variables import ENDS
from verne_post.gcode.siemens.vocabulary import ADDRESSES
from verne_post.model.machine import Machine
from verne_post.model.moves import AXES, FeedMode, Frame, MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import FIRST_NAMED_TOOL, Tool, describe_tool_number, name_system

#: How a Q parameter of cycles names its unit.
_OF_PROGRAM: Final = "in the unit of the program"
#: Decimals of coordinates, mm and degrees.
_DECIMALS: Final = 4
#: How a language writes a variable; in Siemens other names look the same.
_VARIABLES: Final = {
    "siemens": re.compile(r"(?<![\w$])[A-Z_]\w*", re.IGNORECASE),
    "heidenhain": re.compile(r"(?<![A-Z_\d])Q[LRS]?\d+", re.IGNORECASE),
}
#: Variables that are positions -> the axis.
_POSITIONS: Final = {
    "rs274": {f"#{POSITION + axis}": axis for axis in range(len(AXES))},
    "fanuc": {f"#{number}": axis for number, axis in ENDS.items()},
}
#: P of M98: how often, and the four digits of the program.
_REPEATED: Final = re.compile(r"(\d+)(\d{4})")
#: Codes whose P is a dwell at the bottom of a hole.
_CYCLES: Final = tuple(f"G{code // 10}" for code in CYCLES)
_IS_NUMBER: Final = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)")
_PARAMETER: Final = re.compile(r"#<[^<>]*>|#\d+")


class Place(Struct, frozen=True, eq=False):
    """Where the motion of a line ends."""

    position: Array  #: (9,), program coordinates, mm and degrees.
    frame: Frame
    is_by_words: bool  #: A and C words say how the table stands, and the position is no control point of a spline.
    centre: Array | None = None  #: (9,), where compensation leads the tool's centre elsewhere.
    side: str = ""  #: Where that is, as ``5 mm left of the contour``.

    @classmethod
    def find(cls, line: Line) -> "Place | None":
        """That of a line; None for the approach."""
        moves, move = line.moves, line.move
        if move < 0:
            return None
        by_vector = bool(np.isfinite(moves.tool_axis[move]).all())
        is_by_words = not by_vector and moves.kind[move] != MoveKind.SPLINE
        state, end = line.state, line.contour_end
        if end is None or state is None or state.compensation is None:
            return cls(moves.end[move], line.frame, is_by_words)
        return cls(end, line.frame, is_by_words, moves.end[move], state.compensation.describe_side())


def find_end_of_places(line: str, dialect: str) -> int:
    """Where the last X, Y or Z of a line that says where the tip goes ends; 0 without one."""
    words = find_words(line, dialect)
    places, codes = [one for one in words if one.name in ("X", "Y", "Z") and one.value], list_codes(words)
    return max((one.end for one in places if not find_beside(one, words, codes, dialect)[0]), default=0)


def find_variable(line: str, column: int, dialect: str) -> str:
    """What may be a variable at a column, from 0, as it is spelt; empty where none is there."""
    found = _VARIABLES.get(dialect, _PARAMETER).finditer(remove_remarks(line, dialect))
    return next((one[0] for one in found if one.start() <= column < one.end()), "")


def describe_variable(name: str, state: State | None, dialect: str, line: str) -> str:
    """The value of a variable after its line; empty for a name of Siemens that is none there."""
    value = None if state is None else state.look_up(name)
    if value is None and dialect == "siemens":
        kind = re.search(rf"\bPROC\b.*[(,]\s*(?:VAR\s+)?(\w+)\s+{re.escape(name)}\b", line, re.IGNORECASE)
        return "" if kind is None else f"value of the subprogram, {kind[1].upper()}: its call gives it"
    axis = _POSITIONS.get(dialect, {}).get(name)
    if axis is not None and state is not None and state.is_known(axis):
        scale = MM_PER_INCH if state.modes.inch and AXES[axis] not in "ABC" else 1.0
        return f"{AXES[axis]} of the program; {format_number(state.position[axis] / scale)} after this line"
    if value is None:
        return "variable; no value is known after this line"
    shown = f'"{value}"' if isinstance(value, str) else format_number(value)
    return f"variable; {shown} after this line"


def describe_address(
    address: Word,
    dialect: str,
    words: Sequence[Word],
    state: State | None,
    place: Place | None,
    machine: Machine | None,
    options: Options | None,
) -> str:
    """What an address means, and what it comes to; empty for one that the language does not have.

    Parameters
    ----------
    words : sequence of Word
        Those of its line.
    state : State or None
        After its line; None where the program itself does not come to it.
    place : Place or None
        At the end of its motion; None without motion, where the state has the place.
    """
    if own := _find_meaning_beside(address, dialect, words, state):
        return own
    meaning = _find_meaning(address.name, dialect) or address.text
    if meaning and dialect == "heidenhain" and address.name[0] == "Q":
        unit = "inch" if state is not None and state.modes.inch else "mm"
        for long, short in ((f"per minute, {_OF_PROGRAM}", f"in {unit}/min"), (_OF_PROGRAM, f"in {unit}")):
            meaning = meaning.replace(long, short)
        shown = _show_value(address, state, dialect)
        return f"{meaning}; here {shown}"
    if not meaning or machine is None or options is None:
        return meaning
    axis = address.name.removeprefix("I") if dialect == "heidenhain" else address.name
    if axis in AXES and axis in machine.coordinates.axes:
        if place is None and state is not None and state.is_known(AXES.index(axis)):
            place = Place(np.array(state.position), state.frame, state.tool_axis is None)
        values = [] if place is None else list(_describe_axis(AXES.index(axis), place, machine))
    else:
        is_tool_call = any(one.name == "TOOL CALL" for one in words)
        values = [] if state is None else list(_find_values(address, dialect, state, options, is_tool_call))
        if not values and (shown := _show_value(address, state, dialect)) != (value := _get_value(address)):
            values = [] if _IS_NUMBER.fullmatch(value.replace(",", ".")) else [shown]
    return "; ".join([meaning, *values])


def _find_meaning_beside(address: Word, dialect: str, words: Sequence[Word], state: State | None) -> str:
    """What a letter means beside the codes of its block, or else for the motion in force; empty where none tells."""
    codes, of_codes = list_codes(words), OF_LETTERS.get(dialect, {})
    if dialect in ("rs274", "fanuc") and state is not None:
        if not any(one in of_codes and one not in BESIDE_MOTION for one in codes):
            in_plane = address.name == "Z" and state.plane  # cycles drill along another axis
            shown = state.modes.show(state.feed_mode, state.control.mode)
            codes += [] if in_plane else [shown[0], shown[-1]]
        if dialect == "rs274" and state.modes.absolute_centers:
            codes = [f"{one} G90.1" if one in ("G2", "G3") else one for one in codes]
    beside, meaning = find_beside(address, words, codes, dialect)
    meaning, value = meaning.format(_show_value(address, state, dialect)), _get_value(address)
    if address.name == "P" and state is not None and dialect in ("rs274", "fanuc"):
        cycle = state.modes.cycle
        if beside == "M98" and dialect == "fanuc" and (call := _REPEATED.fullmatch(value)):
            meaning += f"; O{int(call[2])}, {int(call[1])} times, or on Haas controls O{int(value)}"
        elif beside in _CYCLES and cycle is not None and cycle.dwell is not None:
            meaning += f"; {cycle.dwell:g} s"
    return meaning


def _get_value(address: Word) -> str:
    """The value of an address as it is written, a text without its quotes."""
    return (address.value or "").strip('"')


def _show_value(address: Word, state: State | None, dialect: str) -> str:
    """A number, or that of a variable; a calculation as it is written."""
    written_value = _get_value(address)
    value, sign = written_value.replace(",", "."), -1.0 if written_value.startswith("-") else 1.0
    if _IS_NUMBER.fullmatch(value):
        return format_number(float(value), _DECIMALS)
    name = (address.value or "").lstrip("+- ")
    is_variable = _VARIABLES.get(dialect, _PARAMETER).fullmatch(name)
    number = state.look_up(name) if state is not None and is_variable else None
    return written_value if not isinstance(number, float | int) else format_number(sign * number, _DECIMALS)


def _find_meaning(name: str, dialect: str) -> str:
    if dialect == "siemens":
        return ADDRESSES.get(name, "")
    if dialect == "heidenhain":
        return describe_parameter(int(name[1:])) if re.fullmatch(r"Q\d+", name) else LETTERS_OF_KLARTEXT.get(name, "")
    return LETTERS.get(name, "")


def _find_values(address: Word, dialect: str, state: State, options: Options, is_tool_call: bool) -> Iterator[str]:
    """What holds of it after its line."""
    if address.name == "F" and state.feed > 0.0:
        inverse = f"the move takes 1/{state.feed:g} min"
        units = {FeedMode.PER_MINUTE: "mm/min", FeedMode.PER_REVOLUTION: "mm per turn of the spindle"}
        yield f"{state.feed:g} {units[state.feed_mode]}" if state.feed_mode in units else inverse
    elif address.name in ("S", "S1"):
        direction = (
            f", {'left' if state.spindle_reversed else 'right'}" if state.spindle_on else ", the spindle does not turn"
        )
        direction = "" if is_tool_call and not state.spindle_on else direction  # M3 cannot stand there
        yield f"{state.spindle_speed:g} {name_unit_of_speed(state).get('unit', '1/min')}{direction}"
    elif (number := _find_tool(address, dialect, state, options)) is not None:
        yield _describe_tool(number, address, state, options)


def _describe_axis(axis: int, place: Place, machine: Machine) -> Iterator[str]:
    """Program and machine coordinate of an axis."""
    unit, letter, plane = ("deg" if AXES[axis] in "ABC" else "mm"), AXES[axis], place.frame.feature
    tilted = ", in the tilted plane" if plane is not None and plane.is_programmed and not plane.is_level else ""
    shown = format_number(place.position[axis], _DECIMALS)
    yield f"{letter} {shown} {unit} in {name_system(place.frame.system)}{tilted}"
    centre = place.position if place.centre is None else place.centre
    if place.centre is not None and axis in (0, 1, 2):
        yield f"tool centre {letter} {format_number(centre[axis], _DECIMALS)} mm, {place.side}"
    if place.is_by_words:
        there = machine.coordinates.map_to_machine(centre, place.frame)
        yield f"machine {letter} {format_number(there[axis], _DECIMALS)} {unit}"


def _find_tool(address: Word, dialect: str, state: State, options: Options) -> int | None:
    """Number of the tool that an address names; None for one that names none."""
    by_name = {"siemens": ("T", "T1"), "heidenhain": ("TOOL CALL", "TOOL DEF")}.get(dialect, ("T", "H", "D"))
    if dialect == "siemens" and address.name == "D":
        # before the first M6 it is for the tool that T has selected
        return (state.loaded_tool or state.selected_tool) if _get_value(address) != "0" else None
    if address.name not in by_name:
        return None
    if _get_value(address).isdecimal():
        return int(_get_value(address)) or None
    known = {
        name.upper(): number
        for name, number in [
            *_get_named_tools(options, dialect).items(),
            *((b, a) for a, b in state.tool_names.items()),
        ]
    }
    return known.get(_get_value(address).upper())


def _get_named_tools(options: Options, dialect: str) -> Mapping[str, int]:
    """Name -> number of the tools that a set-up gives a language by name."""
    names: Mapping[str, int] = options.control.get(dialect, {}).get("tools", {})
    return names


def _describe_tool(number: int, address: Word, state: State, options: Options) -> str:
    """Length and diameter of a tool, and where they are from."""
    names = dict(state.tool_names)
    if not _get_value(address).isdecimal():
        names.setdefault(number, _get_value(address))
    shown = describe_tool_number(number, names) if number in names or number < FIRST_NAMED_TOOL else "tool"
    tool: Tool | None = (state.tools or {}).get(number)
    if tool is None:
        length = options.tool_length
        return f"{shown}: " + (
            "the set-up gives no such tool" if length is None else f"length {length:g} mm (tool_length)"
        )
    return f"{shown}: {_describe_sizes(tool)}"


def _describe_sizes(tool: Tool) -> str:
    length = "no length given yet" if tool.unmeasured else f"length {tool.offset[2]:g} mm"
    return f"{length}, diameter {tool.diameter:g} mm" if tool.diameter else f"{length}, no diameter given"


def list_tools(options: Options, dialect: str) -> dict[str, str]:
    """How a program of a language may call the tools of a set-up, by name in quotes or by number, and their sizes."""
    tools = options.tools or {}
    named = {f'"{name}"': number for name, number in _get_named_tools(options, dialect).items() if number in tools}
    numbers = {str(number): number for number in sorted(tools) if number < FIRST_NAMED_TOOL}
    return {word: _describe_sizes(tools[number]) for word, number in (named | numbers).items()}
