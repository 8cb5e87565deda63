"""What a letter of a line with its value means, as X10, H1 or T="EM10", and what it comes to in this program."""

import re
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.explain_numbers import format_number
from verne_post.app.line_remedies import Line
from verne_post.base.arrays import Array
from verne_post.base.program_lines import find_word, remove_remarks
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.codes import CYCLES
from verne_post.gcode.klartext.vocabulary import describe_parameter
from verne_post.gcode.letters import BESIDE_MOTION, LETTERS, LETTERS_OF_KLARTEXT, OF_CORNERS, OF_LETTERS
from verne_post.gcode.machining.state import State, name_unit_of_speed
from verne_post.gcode.parameters import POSITION
from verne_post.gcode.rs274.macro_text import number_argument
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
_CODE: Final = re.compile(r"(?<![A-Z_#<])([GM])[ \t]*0*(\d+(?:\.\d+)?)")
_MACRO: Final = re.compile(r"(?<![A-Z_#<])G[ \t]*0*6[56](?![\d.])")
#: How other languages write a code whose words have a meaning of their own.
_HEADS: Final = {
    "siemens": re.compile(r"(?<![\w$])(A?(?:TRANS|ROT|SCALE|MIRROR)|G0*4|G11[0-2])(?!\w)"),
    "heidenhain": re.compile(
        r"^[ \t]*(?:\d+[ \t]+)?(TOOL[ \t]+CALL|CYCL[ \t]+DEF[ \t]+\d+|BLK[ \t]+FORM|TRANS[ \t]+\w+|CC|CR|RND)(?!\w)"
    ),
}
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
_IS_NUMBER: Final = re.compile(r"[-+]?[\d.]+")
_PARAMETER: Final = re.compile(r"#<[^<>]*>|#\d+")
_TEXT: Final = r"\"[^\"]*\""
_POINT: Final = r"\.?"
_NUMBER: Final = rf"[-+]?(?:\d+{_POINT}\d*|\.\d+)"
#: Values that are computed. Brackets may hold brackets, three deep.
_BRACKET: Final = r"\[(?:[^][]|\[(?:[^][]|\[[^][]*\])*\])*\]"
_COMPUTED_VALUE: Final = rf"(?P<value>{_TEXT}|{_NUMBER}|[-+]?(?:#+\d+|#<[^<>]*>|#?{_BRACKET}))"
#: Klartext also writes a comma in numbers.
_KLARTEXT_VALUE: Final = (
    rf"(?P<value>{_TEXT}|{_NUMBER.replace(_POINT, '[.,]?')}|[-+]?Q[LRS]?\d+|(?:(?<==)|(?<== ))F?(?:MAX|AUTO)\b)"
)
_PARENTHESES: Final = r"\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)"
_OPERAND: Final = rf"[-+]?(?:[\d.]+|[$A-Z_][\w$]*(?:{_PARENTHESES}|{_BRACKET})?|{_PARENTHESES})"
_SIEMENS_VALUE: Final = rf"(?P<value>{_TEXT}|{_OPERAND}(?:[ \t]*[-+*/][ \t]*{_OPERAND})*)"
#: How a language writes a letter, or a name, with its value; letters may touch the value before.
_PATTERNS: Final = {
    "siemens": re.compile(
        rf"(?<![A-Z_$])(?:(?P<long>[A-Z]+\d*)[ \t]*=[ \t]*{_SIEMENS_VALUE}|"
        r"(?P<name>[A-Z])[ \t]*(?P<number>[-+]?[\d.]+))"
    ),
    "heidenhain": re.compile(
        rf"(?<![A-Z_])(?P<name>TOOL[ \t]+(?:CALL|DEF)|I?[XYZABCUVW]|I?P[RA]|D[LR]|SP[ABC]|SCL|ROT|DIST|LBL|REP|MB|"
        rf"Q\d+(?=[ \t]*=)|(?!R0(?![\d.]))[A-Z])"
        rf"[ \t]*=?[ \t]*{_KLARTEXT_VALUE}|(?<![A-Z_])(?P<alone>DR[-+]|[XYZ])(?![-+=\w.])"
    ),
}
_LETTER_AND_VALUE: Final = re.compile(rf"(?<![A-Z_#<])(?P<name>[A-Z])[ \t]*{_COMPUTED_VALUE}")


class Address(Struct, frozen=True):
    """A letter or name with its value, from column ``begin`` to ``end`` of its line."""

    name: str
    value: str  #: As it is written: a number, a text, a variable or a calculation.
    begin: int
    value_begin: int
    end: int


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


def find_address(line: str, column: int, dialect: str) -> Address | None:
    """The address at a column, from 0; None where none is there, as in a remark or at G and M codes."""
    return next((one for one in _list_addresses(line, dialect) if one.begin <= column < one.end), None)


def find_end_of_places(line: str, dialect: str) -> int:
    """Where the last X, Y or Z of a line that says where the tip goes ends; 0 without one."""
    words = [one for one in _list_addresses(line, dialect) if one.name in ("X", "Y", "Z") and one.value]
    ends = [one.end for one in words if not _find_meaning_beside(one, dialect, line, None)]
    return max(ends, default=0)


def _list_addresses(line: str, dialect: str) -> Iterator[Address]:
    """The addresses of a line, without G and M codes."""
    code = remove_remarks(line, dialect).upper()
    for found in _PATTERNS.get(dialect, _LETTER_AND_VALUE).finditer(code):
        groups = {key: text for key, text in found.groupdict().items() if text is not None}
        name = groups.get("long") or groups.get("alone") or " ".join(groups["name"].split())
        begin, end = (
            (found.end(), found.end()) if "alone" in groups else found.span("number" if "number" in groups else "value")
        )
        if name not in "GM":
            yield Address(name, line[begin:end].strip('"'), found.start(), begin, found.end())


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
    address: Address,
    dialect: str,
    block: str,
    state: State | None,
    place: Place | None,
    machine: Machine | None,
    options: Options | None,
) -> str:
    """What an address means, and what it comes to; empty for one that the language does not have.

    Parameters
    ----------
    block : str
        Its line.
    state : State or None
        After its line; None where the program itself does not come to it.
    place : Place or None
        At the end of its motion; None without motion, where the state has the place.
    """
    if own := _find_meaning_beside(address, dialect, block, state):
        return own
    meaning = _find_meaning(address.name, dialect) if address.value or len(address.name) > 1 else ""
    if meaning and dialect == "heidenhain" and address.name[0] == "Q":
        unit = "inch" if state is not None and state.modes.inch else "mm"
        for words, short in ((f"per minute, {_OF_PROGRAM}", f"in {unit}/min"), (_OF_PROGRAM, f"in {unit}")):
            meaning = meaning.replace(words, short)
        shown = address.value if address.value.isalpha() else _show_value(address, state)  # FMAX
        return f"{meaning}; here {shown}"
    if not meaning or machine is None or options is None:
        return meaning
    axis = address.name.removeprefix("I") if dialect == "heidenhain" else address.name
    if axis in AXES and axis in machine.coordinates.axes:
        if place is None and state is not None and state.is_known(AXES.index(axis)):
            place = Place(np.array(state.position), state.frame, state.tool_axis is None)
        values = [] if place is None else list(_describe_axis(AXES.index(axis), place, machine))
    else:
        values = [] if state is None else list(_find_values(address, dialect, state, options, block))
        if not values and (shown := _show_value(address, state)) != address.value:
            values = [] if _IS_NUMBER.fullmatch(address.value.replace(",", ".")) else [shown]
    return "; ".join([meaning, *values])


def _find_meaning_beside(address: Address, dialect: str, block: str, state: State | None) -> str:
    """What a letter means beside the codes of its block, or else for the motion in force; empty where none tells."""
    code, of_codes = remove_remarks(block, dialect).upper(), OF_LETTERS.get(dialect, {})
    if dialect in _HEADS:
        codes = [" ".join(one[1].split()).replace("G04", "G4") for one in _HEADS[dialect].finditer(code)]
    else:
        if call := _MACRO.search(code):
            return _describe_argument(code, call.end(), address, state)
        codes = [f"{one[1]}{one[2]}" for one in _CODE.finditer(code)]
        if "G10" in codes and (kind := find_word(code, "L")):
            codes.insert(0, f"G10 L{kind[2]}")
        if code[: address.begin].rstrip().endswith(",") and address.name in OF_CORNERS:
            return OF_CORNERS[address.name].format(_show_value(address, state))
        if state is not None and not any(one in of_codes and one not in BESIDE_MOTION for one in codes):
            in_plane = address.name == "Z" and state.plane  # cycles drill along another axis
            shown = state.modes.show(state.feed_mode, state.control.mode)
            codes += [] if in_plane else [shown[0], shown[-1]]
        if state is not None and dialect == "rs274" and state.modes.absolute_centers:
            codes = [f"{one} G90.1" if one in ("G2", "G3") else one for one in codes]
    beside = next((one for one in codes if address.name in of_codes.get(one, {})), "")
    meaning = of_codes[beside][address.name].format(_show_value(address, state)) if beside else ""
    if address.name == "P" and state is not None and dialect in ("rs274", "fanuc"):
        cycle = state.modes.cycle
        if beside == "M98" and dialect == "fanuc" and (call := _REPEATED.fullmatch(address.value)):
            meaning += f"; O{int(call[2])}, {int(call[1])} times, or on Haas controls O{int(address.value)}"
        elif beside in _CYCLES and cycle is not None and cycle.dwell is not None:
            meaning += f"; {cycle.dwell:g} s"
    return meaning


def _show_value(address: Address, state: State | None) -> str:
    """A number, or that of a variable; a calculation as it is written."""
    value, sign = address.value.replace(",", "."), -1.0 if address.value.startswith("-") else 1.0
    if _IS_NUMBER.fullmatch(value):
        return format_number(float(value), _DECIMALS)
    number = None if state is None or address.value[:1] in "[(" else state.look_up(address.value.lstrip("+-"))
    return address.value if not isinstance(number, float | int) else format_number(sign * number, _DECIMALS)


def _describe_argument(code: str, begin: int, address: Address, state: State | None) -> str:
    """The variable of a macro that a letter of its call, from a column on, sets; empty for P and L."""
    letters = re.findall(r"[A-Z](?=[ \t]*[-+#\[\d.])", code[begin : address.begin]) if address.begin >= begin else []
    number, shown = number_argument("".join([*letters, address.name])), _show_value(address, state)
    return f"argument #{number} of the macro: {shown}" if number else OF_LETTERS["fanuc"]["G65"].get(address.name, "")


def _find_meaning(name: str, dialect: str) -> str:
    if dialect == "siemens":
        return ADDRESSES.get(name, "")
    if dialect == "heidenhain":
        return describe_parameter(int(name[1:])) if re.fullmatch(r"Q\d+", name) else LETTERS_OF_KLARTEXT.get(name, "")
    return LETTERS.get(name, "")


def _find_values(address: Address, dialect: str, state: State, options: Options, block: str) -> Iterator[str]:
    """What holds of it after its line."""
    beside_tool_call = re.search(r"\bTOOL[ \t]+CALL\b", block, re.IGNORECASE) is not None
    if address.name == "F" and state.feed > 0.0:
        inverse = f"the move takes 1/{state.feed:g} min"
        units = {FeedMode.PER_MINUTE: "mm/min", FeedMode.PER_REVOLUTION: "mm per turn of the spindle"}
        yield f"{state.feed:g} {units[state.feed_mode]}" if state.feed_mode in units else inverse
    elif address.name in ("S", "S1"):
        direction = (
            f", {'left' if state.spindle_reversed else 'right'}" if state.spindle_on else ", the spindle does not turn"
        )
        direction = "" if beside_tool_call and not state.spindle_on else direction  # M3 cannot stand there
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


def _find_tool(address: Address, dialect: str, state: State, options: Options) -> int | None:
    """Number of the tool that an address names; None for one that names none."""
    by_name = {"siemens": ("T", "T1"), "heidenhain": ("TOOL CALL", "TOOL DEF")}.get(dialect, ("T", "H", "D"))
    if dialect == "siemens" and address.name == "D":
        # before the first M6 it is for the tool that T has selected
        return (state.loaded_tool or state.selected_tool) if address.value != "0" else None
    if address.name not in by_name:
        return None
    if address.value.isdecimal():
        return int(address.value) or None
    known = {
        name.upper(): number
        for name, number in [
            *_get_named_tools(options, dialect).items(),
            *((b, a) for a, b in state.tool_names.items()),
        ]
    }
    return known.get(address.value.upper())


def _get_named_tools(options: Options, dialect: str) -> Mapping[str, int]:
    """Name -> number of the tools that a set-up gives a language by name."""
    names: Mapping[str, int] = options.control.get(dialect, {}).get("tools", {})
    return names


def _describe_tool(number: int, address: Address, state: State, options: Options) -> str:
    """Length and diameter of a tool, and where they are from."""
    names = dict(state.tool_names)
    if not address.value.isdecimal():
        names.setdefault(number, address.value)
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
