"""What rows, as written or as measured, cut from the stock: volume by line and tool, touches, and what is left.

What is left around the nominal part is reported too.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.assemble import Program
from verne_post.app.machined import Body, find_tools, judge_rows, place_on_table, place_tips, report_missing_shape
from verne_post.app.result import Progress
from verne_post.app.stock_check import build_tool, find_rounding, report_touches
from verne_post.base.arrays import Array, Ints
from verne_post.kinematics.checks.keep_out import place_own_stock
from verne_post.model.findings import Finding
from verne_post.model.part_setup import Box, FixtureMesh, Wanted, describe_tool_number
from verne_post.model.setpoints import SetpointBlock
from verne_post.part.cutting import cut_stock
from verne_post.part.dexels import MOST_RAYS, Dexels
from verne_post.part.rests import find_rests
from verne_post.part.stock_forms import CELL_MM, make_box, make_cylinder, read_stock
from verne_post.part.tool_spans import Spans
from verne_post.part.verdict import Machined, add_rests

#: Rows nearer than this to the straight way between others are left out, mm; axes count as points at this height, mm.
STRAIGHT_MM: Final = 0.0005
AXIS_MM: Final = 50.0
#: A stretch that cuts less is in the air, mm3: rounding of rows and files shaves off as much.
AIR_MM3: Final = 1e-3


class StockRun(Struct, frozen=True, eq=False):
    """What was cut."""

    left: Dexels
    before: float  #: Volume of the stock, mm3.
    #: by_line, by_tool: Volume that lines and tools cut, mm3.
    by_line: dict[int, float]
    by_tool: dict[int, float]
    names: dict[int, str]  #: Of tools, as Moves names them.
    #: feeding, in_air: Time in feed motion, and what of it nothing is cut in, s.
    feeding: float
    in_air: float
    findings: tuple[Finding, ...]  #: VP216.


def judge_blocks(
    program: Program, part: Body, wanted: Wanted, blocks: Sequence[SetpointBlock], progress: Progress | None = None
) -> Machined:
    """Compare the rows of a program, as written, with its nominal part.

    Raises
    ------
    InputError
        As :func:`judge_rows`.
    """
    factor = np.array([column.factor for column in program.machine.columns])
    q, line = np.concatenate([one.values for one in blocks]) / factor, np.concatenate([one.line for one in blocks])
    machined = judge_rows(program, q, line, part, (), wanted, progress=progress)
    if part.mesh.open_edges or not (program.options.stock or program.moves.stock):
        return machined
    return add_stock(program, machined, part, cut_rows(program, q, line, make_stock(program)).left)


def add_stock(program: Program, machined: Machined, part: Body, left: Dexels) -> Machined:
    """The same with what stays of a stock around the part, a closed mesh.

    Raises
    ------
    InputError
        VP506.
    """
    allowed = machined.judged[0].comparison.wanted.excess
    inside = left.move(*place_on_table(program, part.mesh.name, part.system), back=True)
    return add_rests(machined, find_rests(inside, part.mesh, allowed))


def load_stock(program: Program, raw: bytes, name: str, system: int | None, unit: str) -> Dexels:
    """The stock of an STL file, or what another run has left (npz), in a work system; None: the table.

    Raises
    ------
    InputError
        VP018, VP506.
    """
    return read_stock(raw, name, unit).copy().move(*place_on_table(program, name, system))


def make_stock(program: Program, most: int = MOST_RAYS) -> Dexels:
    """The stock of the options, else what the program itself defines (BLK FORM, WORKPIECE), with so many rays at most.

    Raises
    ------
    InputError
        VP018.
    """
    box = program.options.stock
    if isinstance(box, FixtureMesh):
        place = place_on_table(program, box.name, box.system)
        return read_stock(box.raw, box.shown, box.unit).thin(most).move(*place)
    if isinstance(box, Box):
        low, high = np.array(box.low), np.array(box.high)
        return make_box(low, high, *place_on_table(program, box.name, box.system), _choose_cell(low, high, most))
    own = place_own_stock(program.machine, program.moves, program.options)
    half, stock = own.half, program.moves.stock
    cell = _choose_cell(-half, half, most)
    if stock is not None and stock.round:
        return make_cylinder(-half, half, stock.bore, own.middle, own.turn, cell)
    return make_box(-half, half, own.middle, own.turn, cell)


def _choose_cell(low: Array, high: Array, most: int) -> float:
    """Distance of the rays, mm."""
    return max(CELL_MM, float(np.sqrt((high[0] - low[0]) * (high[1] - low[1]) / most)))


def pack_stock(program: Program, left: Dexels, name: str, system: int | None) -> bytes:
    """What is left as a file: STL, or npz without loss, in a work system."""
    origin, turn = place_on_table(program, name, system)
    inside = left.move(origin, turn, back=True)
    return inside.pack() if name.lower().endswith(".npz") else inside.encode_stl()


def cut_rows(program: Program, q: Array, line: Ints, stock: Dexels) -> StockRun:
    """Run rows (n, n_joints), with their source lines (n,), through a stock, which is cut.

    Raises
    ------
    InputError
        VP018, VP411, VP413.
    """
    number, in_force = find_tools(program, line)
    tip, axis, length = place_tips(program, program.machine.five_axis, q, number, in_force)
    keep = _thin(tip, axis, line)
    first, last = keep[:-1], keep[1:]
    rapid = np.isin(line[first], list(_list_rapid_lines(program)))
    used, tool = np.unique(np.column_stack([number[first], np.round(length[first], 6)]), axis=0, return_inverse=True)
    tools = []
    for one, long in used.tolist():
        shape = program.options.tool_shapes.get(int(one), ())
        if not shape:
            name = describe_tool_number(int(one), program.moves.name_tools())
            raise report_missing_shape(int(one), name)
        tools.append(build_tool(shape, long, program.machine))
    spans = Spans(
        np.stack([tip[first], tip[last]], axis=1),
        np.stack([axis[first], axis[last]], axis=1),
        line[first],
        tool.reshape(-1),
        rapid,
        _find_rounding_of_rows(program, tip[first], tip[last], line[first]),
    )
    before = stock.measure_volume()
    box = program.options.stock or Box("the stock", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    cut = cut_stock(stock, spans, tools, box.distance)
    seconds = (last - first) * program.cycle
    feeding = ~rapid & (tip[first] != tip[last]).any(axis=1)
    coordinates, cell = program.machine.coordinates, float(stock.cell.max())
    found = tuple(report_touches(coordinates, cut, spans, tools, box.name, box.distance, cell))
    return StockRun(
        stock,
        before,
        cut.sum_by(line[first]),
        cut.sum_by(number[first]),
        program.moves.name_tools(),
        float(seconds[feeding].sum()),
        float(seconds[feeding & (cut.volume < AIR_MM3)].sum()),
        found,
    )


def describe_run(run: StockRun) -> str:
    """What was cut, in lines."""
    removed = sum(run.by_line.values())
    by_volume = sorted(run.by_line.items(), key=lambda item: -item[1])[:10]
    most = ", ".join(f"{line}: {volume:.1f} mm3" for line, volume in by_volume if volume > AIR_MM3)
    lines = [
        f"stock: {removed:.1f} of {run.before:.1f} mm3 cut, {run.left.measure_volume():.1f} left; "
        f"{run.in_air:.3f} of {run.feeding:.3f} s at feed in the air",
        *(f"  {describe_tool_number(tool, run.names)}: {volume:.1f} mm3" for tool, volume in run.by_tool.items()),
        *([f"  lines that cut most: {most}"] if most else []),
    ]
    return "\n".join(lines) + "\n"


def _list_rapid_lines(program: Program) -> set[int]:
    """Lines all of whose motion is rapid: of others, as of drilling cycles, a row does not say which it is."""
    path = program.path
    rapid = path.feed_time == 0
    return set(path.line[rapid].tolist()) - set(path.line[~rapid].tolist())


def _find_rounding_of_rows(program: Program, tip: Array, end: Array, line: Ints) -> Array:
    """:func:`find_rounding` for spans (n,) between rows: those that begin within the corner that begins their line."""
    contour = program.contour
    rounding, lines = find_rounding(contour), contour.find_lines()
    in_corner = np.flatnonzero(rounding > 0)
    if not len(in_corner):
        return np.zeros(len(line))
    corners = np.split(in_corner, np.flatnonzero(np.diff(in_corner) > 1) + 1)
    numbers, of_corner = np.unique([lines[corner[0]] for corner in corners], return_inverse=True)
    most, way = np.zeros((2, len(numbers)))
    np.maximum.at(most, of_corner, [rounding[corner].max() for corner in corners])
    np.maximum.at(way, of_corner, [contour.length[corner].sum() for corner in corners])
    step = np.linalg.norm(end - tip, axis=1)
    gone = np.cumsum(step) - step
    begins = np.append(True, line[1:] != line[:-1])
    gone -= gone[begins][np.cumsum(begins) - 1]
    at = np.minimum(np.searchsorted(numbers, line), len(numbers) - 1)
    return np.where((numbers[at] == line) & (gone < way[at]), most[at], 0.0)


def _thin(tip: Array, axis: Array, line: Ints) -> Ints:
    """Rows between which the motion is straight; the ends of every line are among them."""
    place = np.hstack([tip, AXIS_MM * axis])
    ends = np.flatnonzero(np.append(True, line[1:] != line[:-1]))
    ends = np.unique(np.append(ends, len(line) - 1))
    keep, waiting = [int(ends[0])], list(zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True))[::-1]
    while waiting:
        a, b = waiting.pop()
        along = place[b] - place[a]
        off = place[a : b + 1] - place[a]
        square = float(along @ along)
        share = np.clip(off @ along / square, 0.0, 1.0) if square > 0 else np.zeros(len(off))
        apart = np.linalg.norm(off - share[:, None] * along, axis=1)
        worst = int(apart.argmax())
        if apart[worst] > STRAIGHT_MM:
            waiting += [(a + worst, b), (a, a + worst)]
        else:
            keep.append(b)
    return np.array(keep)
