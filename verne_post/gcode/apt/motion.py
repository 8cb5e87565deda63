"""Statements that move: points, arcs, holes, the table; and the modes of their motion."""

import re
from collections.abc import Iterator, Sequence
from decimal import Decimal
from typing import Final

import numpy as np

from verne_post.base.tolerances import VECTOR_LENGTH
from verne_post.gcode.apt.arcs import Circle, check_radius, find_allowed, read_circle, read_tool_on
from verne_post.gcode.apt.auxiliary import change_tool, give_feed, make_block
from verne_post.gcode.apt.cycles import is_end_of_cycle, read_cycle
from verne_post.gcode.apt.holes import drill
from verne_post.gcode.apt.interpreter import make_arc_block
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.statements import Statement, read_numbers, read_word
from verne_post.gcode.block import Block
from verne_post.gcode.program_error import ProgramError

#: What may be one number with a decimal comma, where no number has a decimal point.
_DECIMAL_COMMA: Final = re.compile(r"\d+,(?:0\d+|\d{3,}|[1-9]\d*)(?![\d.])")
_PLANES: Final = {0: 19, 1: 18, 2: 17}
#: Sines and cosines of angles in degrees, and their products, are off by less than this.
_NOISE: Final = 1e-12


# --- motion -------------------------------------------------------------------------------------


def go_to(to: AptModes, s: Statement) -> Iterator[Block]:
    """GOTO: a point, or after CIRCLE the points of an arc."""
    points, axis = _read_points(to, s, read_numbers(s, s.words))
    axis_before = to.axis
    _take_axis(to, s, axis)
    _check_table(to, s)
    if to.circle is not None and _differ(to.axis, axis_before, _find_half_step(to.axis) + _find_half_step(axis_before)):
        raise ProgramError(
            "VP002",
            f"{s.major} after CIRCLE with another tool axis: arcs keep the axis; write points in their place",
        )
    yield from _prepare_tool(to, s)
    circle = to.circle
    for number, point in enumerate(points):
        to.circle = circle if number else to.circle
        yield from _approach(to, s, to.map.map_point(point))


def _read_points(to: AptModes, s: Statement, numbers: list[float]) -> tuple[list[list[float]], list[float]]:
    """Points, several after CIRCLE, and the tool axis; [] where the statement has none."""
    triples = [numbers[at : at + 3] for at in range(0, len(numbers), 3)]
    if not numbers or len(triples[-1]) < 3 or (len(numbers) > 6 and to.circle is None):
        text = f"{s.major} takes x, y, z, or x, y, z, i, j, k; here are {len(numbers)} numbers"
        commas = None if "." in "".join(s.words) else _DECIMAL_COMMA.search(",".join(s.words))
        if commas:
            text += f"; if {commas[0]} is one number, write a decimal point: {commas[0].replace(',', '.')}"
        raise ProgramError("VP005", text)
    axes = triples[1::2]
    with_axis = len(triples) == 2 * len(axes) and all(axis == axes[0] for axis in axes)
    if with_axis and (to.circle is None or abs(np.linalg.norm(axes[0]) - 1.0) <= VECTOR_LENGTH):
        return triples[::2], axes[0]
    return triples, []


def go_by(to: AptModes, s: Statement) -> Iterator[Block]:
    numbers = read_numbers(s, s.words)
    if len(numbers) not in (1, 3):
        raise ProgramError("VP005", "GODLTA takes dx, dy, dz, or a distance along the tool axis")
    if to.circle is not None or to.cycle is not None:
        raise ProgramError("VP017", "GODLTA after CIRCLE or under CYCLE; write GOTO")
    _require_place(to, "GODLTA")
    _check_table(to, s)
    yield from _prepare_tool(to, s)
    along = numbers if len(numbers) == 3 else [numbers[0] * value for value in to.axis]
    step = dict(zip("XYZ", to.map.turn(along), strict=True))
    yield make_block(s, ("G", 91.0), g=to.motion, **step, **to.axis_words)
    yield make_block(s, ("G", 90.0))
    to.rapid = False


def start(to: AptModes, s: Statement) -> Iterator[Block]:
    to.rapid = True
    yield from go_to(to, s)


def go_home(to: AptModes, s: Statement) -> Iterator[Block]:
    if to.in_path and s.words:
        yield from start(to, s)
        return
    read_word(s, ())
    if to.setup.home is None:
        raise ProgramError(
            "VP015",
            "GOHOME needs the home position of the machine: add [home] g28 to the machine file, or write RAPID and "
            "GOTO in its place",
        )
    yield make_block(s, ("G", 91.0), ("G", 28.0), Z=0.0)
    yield make_block(s, ("G", 90.0))


def _require_place(to: AptModes, what: str) -> None:
    if not all(map(to.state.is_known, range(3))):
        raise ProgramError("VP013", f"{what} needs a known position of the tool; write FROM or GOTO before")


def _take_axis(to: AptModes, s: Statement, axis: list[float]) -> None:
    if not axis:
        if to.axis_is_old and _differ(to.axis, (0.0, 0.0, 1.0), VECTOR_LENGTH):
            raise ProgramError(
                "VP005",
                f"{s.major} without a tool axis after TOOL PATH or MSYS, and the axis before was not 0, 0, 1: it "
                "is not known which axis applies; write x, y, z, i, j, k",
            )
        return
    if not to.multax and _differ(axis, to.axis, VECTOR_LENGTH):
        column = s.columns[-len(axis)] if s.columns else None
        raise ProgramError("VP017", f"{s.major} with a tool axis while MULTAX is off; write MULTAX/ON before", column)
    to.axis, to.axis_is_old = tuple(axis), False


def _prepare_tool(to: AptModes, s: Statement) -> Iterator[Block]:
    """Before a motion: the tool of the path, and one that has only been described, are in the spindle."""
    tool = to.tool
    if tool.described_tool is not None:
        raise ProgramError(
            "VP017", f"TOOLNO/{tool.described_tool} describes a tool that no LOADTL has loaded before this motion"
        )
    if tool.named_tool == tool.mounted_tool:
        return
    number = to.keys.tools.get(tool.named_tool or "")
    if number is not None:
        yield from change_tool(to, s, float(number), float(number))
    elif tool.mounted_tool is None:
        tool.load()  # the one that is in the spindle at the start
    else:
        raise ProgramError(
            "VP012",
            f"TOOL PATH is for tool {tool.named_tool}, the path before was for {tool.mounted_tool}, and there is "
            "no LOAD/TOOL between them; write it, or give the names numbers under [aptcl.tools] of the settings file",
            about=tool.named_tool,
        )


def _check_table(to: AptModes, s: Statement) -> None:
    """After ROTABL the table stands as programmed while the tool axis is that one, as printed; another axis turns it.

    Points in the coordinates of a turned table would have the axis 0, 0, 1: the first point after a tilt shows it,
    however small the tilt.
    """
    if to.state.modes.vectors:
        return
    stands = to.setup.coordinates.find_tool_axis(to.state.position, to.state.frame)
    table_axis = None if stands is None else [float(value) for value in stands]
    near = VECTOR_LENGTH if any(to.axis[:2]) else _find_half_step(to.axis)
    if to.table_has_turned and (table_axis is None or _differ(table_axis, to.tool_axis, near)):
        shown_axis = "not known without a machine" if stands is None else ", ".join(f"{value:.6f}" for value in stands)
        raise ProgramError(
            "VP017",
            f"{s.major} after ROTABL with another tool axis than it has turned to ({shown_axis}): "
            "give the axis in the coordinates of the part",
        )
    same = table_axis is not None and not _differ(table_axis, to.tool_axis, _find_half_step(to.axis))
    to.table_has_turned, to.state.modes.vectors = False, not same


def _approach(to: AptModes, s: Statement, point: list[float]) -> Iterator[Block]:
    """To a point of the part: straight, on the arc of CIRCLE, or a hole."""
    if to.cycle is not None:
        if to.rapid:
            raise ProgramError(
                "VP017",
                "RAPID before a GOTO of a CYCLE: CAM systems differ in whether that place is a hole; write "
                "CYCLE/OFF before a move without a hole, and no RAPID before a hole",
            )
        with to.state.follow_exactly():
            yield from drill(to, s, to.cycle, point)
        return
    if to.circle is not None:
        circle, to.circle = to.circle, None  # an arc that is refused is told once: the next point ends a line
        if to.rapid:
            raise ProgramError("VP017", "RAPID and CIRCLE before one GOTO: an arc is not rapid traverse")
        yield from _go_round(to, s, circle, point)
        return
    _check_listed(to, s, point)
    yield make_block(s, g=to.motion, **dict(zip("XYZ", point, strict=True)), **to.axis_words)
    to.rapid = False


def _check_listed(to: AptModes, s: Statement, point: list[float]) -> None:
    """A writer that lists points of an arc may mean that this one belongs to the arc before."""
    last, to.last_arc = to.last_arc, None
    if last is None or to.rapid:
        return
    circle, start = last
    allowed_distance = find_allowed(to.unit * circle.find_distance(start), inch=to.state.modes.inch) / to.unit
    if circle.has(np.array(point), start, allowed_distance):
        raise ProgramError(
            "VP008",
            f"{s.major}: the point is on the circle of the arc before, and it is not known whether it "
            "continues that arc or ends a straight move; let Creo write one point for each arc (NUMBER_OF_ARC_PTS), or "
            "points alone (CIRC_INTERPOLATION)",
        )


# --- arcs ------------------------------------------------------------------------------------------


def _go_round(to: AptModes, s: Statement, circle: Circle, point: list[float]) -> Iterator[Block]:
    _require_place(to, "an arc")
    held_axis = to.state.tool_axis or to.setup.coordinates.find_tool_axis(to.state.position, to.state.frame)
    if held_axis is not None and _differ(to.tool_axis, [float(value) for value in held_axis], VECTOR_LENGTH):
        raise ProgramError(
            "VP002",
            f"{s.major} on an arc, and TLAXIS or TRACUT has turned the tool axis since the point before: arcs keep the "
            "axis; write a point with the new axis before the arc",
        )
    start = to.place
    check_radius(circle, start, to.unit)
    along, words = circle.find_axis(), dict(zip("XYZ", point, strict=True))
    if along is None:
        if circle.turns:
            raise ProgramError(
                "VP002",
                "CIRCLE with TIMES is executed about X, Y and Z alone; let the CAM system write one turn in "
                "each CIRCLE, or points",
            )
        yield make_arc_block(make_block(s, g=1.0, **words), circle)
    else:
        words |= {letter: float(circle.center[axis]) for axis, letter in enumerate("IJK") if axis != along}
        words |= {"P": 1.0 + circle.turns} if circle.turns else {}
        motion = 3.0 if circle.normal[along] > 0 else 2.0
        yield make_block(s, ("G", float(_PLANES[along])), ("G", 90.1), g=motion, **words)
    to.last_arc = (circle, start) if to.lists_arcs else None


def take_circle(to: AptModes, s: Statement) -> Iterator[Block]:
    circle = read_circle(s, to.keys.times)
    if to.cycle is not None:
        raise ProgramError("VP017", "CIRCLE under CYCLE; write CYCLE/OFF before")
    if to.circle is not None:
        raise ProgramError("VP017", "CIRCLE after CIRCLE: the GOTO that ends the first arc is missing")
    to.circle = _move_circle(to, circle)
    return iter(())


def _move_circle(to: AptModes, circle: Circle) -> Circle:
    """A circle of the statements in the coordinates of the part."""
    center, normal = np.array(to.map.map_point(circle.center)), np.array(to.map.turn(circle.normal))
    return Circle(center, normal, circle.radius, circle.turns)


def take_tangent(to: AptModes, s: Statement) -> Iterator[Block]:
    numbers = read_numbers(s, s.words)
    size = float(np.linalg.norm(numbers)) if len(numbers) == 3 else 0.0
    if not size:
        raise ProgramError("VP005", "INDIRV takes a direction i, j, k")
    to.tangent = np.array(numbers) / size
    return iter(())


def go_on_tool(to: AptModes, s: Statement) -> Iterator[Block]:
    if to.cycle is not None or to.circle is not None or to.rapid:
        raise ProgramError("VP017", "TLON under CYCLE, or after CIRCLE or RAPID")
    _require_place(to, "an arc")
    circle, end = read_tool_on(s, np.array(to.map.invert().map_point(to.place)), to.tangent)
    to.tangent = None
    _check_table(to, s)
    yield from _prepare_tool(to, s)
    yield from _go_round(to, s, _move_circle(to, circle), to.map.map_point(end))


# --- cycles ---------------------------------------------------------------------------------------


def set_cycle(to: AptModes, s: Statement) -> Iterator[Block]:
    again = iter(()) if to.cycle is None or to.cycle.feed is None or to.feed is None else give_feed(to, s, *to.feed)
    to.cycle = None if is_end_of_cycle(s) else read_cycle(s)
    to.level, to.low_hole = None, None if to.cycle is None else to.low_hole
    return again


# --- modes ------------------------------------------------------------------------------------------


def set_rapid(to: AptModes, s: Statement) -> Iterator[Block]:
    """RAPID: the next move."""
    read_word(s, ())
    to.rapid = True
    return iter(())


def set_multax(to: AptModes, s: Statement) -> Iterator[Block]:
    to.multax = not s.words or read_word(s, ("ON", "OFF")) == "ON"
    return iter(())


def set_axis(to: AptModes, s: Statement) -> Iterator[Block]:
    numbers = read_numbers(s, s.words)
    if len(numbers) != 3:
        raise ProgramError("VP005", "TLAXIS takes i, j, k")
    to.axis, to.axis_is_old = tuple(numbers), False
    return iter(())


# --- the table ----------------------------------------------------------------------------------


def turn_table(to: AptModes, s: Statement) -> Iterator[Block]:
    pairs = list(zip(s.words[::2], (word.upper() for word in s.words[1::2]), strict=False))
    names = [name for _angle, name in pairs]
    if len(s.words) != 4 or sorted(names) != ["AAXIS", "CAXIS"]:
        raise ProgramError(
            "VP005",
            "ROTABL takes an angle and AAXIS, and an angle and CAXIS, as in ROTABL/-20,AAXIS,90,CAXIS; the "
            "angles decide the direction (CLW, CCLW and other axes are not read)",
        )
    if to.cycle is not None or to.circle is not None:
        raise ProgramError("VP017", "ROTABL under CYCLE or after CIRCLE")
    angles = dict(zip((name[0] for name in names), read_numbers(s, s.words[::2]), strict=True))
    to.state.modes.vectors, to.table_has_turned = False, angles["A"] != 0
    yield make_block(s, g=0.0, **angles)


# --- tool axes that are printed with few decimals -------------------------------------------------------


def _find_half_step(axis: Sequence[float]) -> float:
    """Half of the last decimal with which an axis is printed: of the component that has most; 0 where all are whole."""
    decimals = max(-int(Decimal(repr(value)).normalize().as_tuple().exponent) for value in axis)
    return 0.5 * 10.0**-decimals if decimals > 0 else 0.0


def _differ(axis: Sequence[float], other: Sequence[float], tolerance: float) -> bool:
    """True where a component of two tool axes differs by more than this."""
    return any(abs(a - b) > tolerance + _NOISE for a, b in zip(axis, other, strict=True))
