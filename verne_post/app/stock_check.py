"""The stock as it is cut: which bodies that are in its box are in material at that time."""

import math
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.app.result import Progress
from verne_post.base.arrays import Array, Ints
from verne_post.base.columns import iterate_blocks
from verne_post.base.printable import join_names, quote_key
from verne_post.base.ragged import number_parts
from verne_post.base.rotations import find_axis_of_angles, rotate_z
from verne_post.base.stopping import check_wanted
from verne_post.gcode.missing_setup import find_tool_key
from verne_post.kinematics.checks.clearance import find_straight
from verne_post.kinematics.checks.keep_out import KeepOut, Placed, build_moving, find_shape
from verne_post.kinematics.checks.moving import Moving, build_spindle
from verne_post.kinematics.checks.separation import measure_cylinder_to_box
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.contour import Contour
from verne_post.model.findings import Finding, make_finding
from verne_post.model.machine import Machine
from verne_post.model.moves import MoveKind, Moves, find_tool_of_moves
from verne_post.model.part_setup import (
    TOOL_PARTS,
    WORK_SYSTEMS,
    Cylinder,
    ToolShape,
    describe_tool_number,
    name_system,
)
from verne_post.model.protocols import TableCoordinates, turn_from_setup, turn_to_setup
from verne_post.model.toolpath import SegmentKind
from verne_post.model.verdict import Family, find_family
from verne_post.part.bodies import build_pieces
from verne_post.part.cutting import Cut, Touch, cut_stock
from verne_post.part.dexels import Dexels
from verne_post.part.motion import join_chords
from verne_post.part.stock_forms import make_box
from verne_post.part.thin_cutters import LINE_HEIGHT_MM
from verne_post.part.tool_spans import Spans, Tool, group_pieces

#: Curved or turning motion is cut in chords of this length, mm and rad: 0.003 mm off an arc of radius 0.5.
CHORD_MM: Final = 0.1
CHORD_ANGLE: Final = np.radians(0.5)
#: In the line of progress, which is shown where cutting takes a second or more.
NO_NUMBA: Final = ", ten times faster with numba (extra part)"
#: Stands for a tool whose size nobody has given: thin, but no ray passes beside it unseen.
WIRE: Final = Cylinder("cutter", 0.3)
#: Said of it where it meets the stock.
AS_LINE: Final = " (the cutter as a thin line: no diameter is given)"
AS_FLAT: Final = (
    " (the cutter counts as flat: no corner_radius is given, in [tools] of the set-up or in a file of tool_shapes)"
)
#: Material that lies deeper in a flat cutter, as a share of its radius, a ball of the same radius touches too.
DEPTH_IN_CORNER: Final = 1.0 - math.sqrt(0.5)
#: Where the tip goes less than this, mm, the place of a contact is an angle.
SHORT_WAY_MM: Final = 0.1
#: A cut that comes so near to the stock, mm, is one that only scratches it; a cutter of unknown radius has this one.
NEAR_STOCK_MM: Final = 1.0
UNKNOWN_MM: Final = 10.0
#: Rounding of shifts, as shares of the size of the stock.
PLACE_SLACK: Final = 1e-6
#: Spans of a program that is out of limits beside contacts with the stock: more are not cut, which may take minutes.
MOST_OF_REFUSED: Final = 50_000
#: Poses that are solved at a time.
SOLVED: Final = 8192


def settle_stock(
    program: Program,
    joints: JointPath,
    found: list[Finding],
    progress: Progress | None = None,
    *,
    only_first: bool | str = False,
    only_lines: bool = False,
) -> list[Finding]:
    """Findings where VP216 is about the stock as it is cut, in place of its box.

    A body that keeps out of the box keeps out of what is left of it, so only programs with such a finding are cut. The
    box counts for platform and legs, which do not turn about the tool's axis. A tool of unknown size counts as a wire.
    With ``only_first`` nothing is cut after the first error, or the first of a body of this name. With ``only_lines``
    findings have no depths and no places.
    """
    keep_out = joints.keep_out
    boxes = [one for one in keep_out.boxes if one.stock] if isinstance(keep_out, KeepOut) else []
    if not isinstance(keep_out, KeepOut) or not boxes:
        return found
    (box,) = boxes
    begun = _check_start(program, joints, keep_out, box)
    if not (only_first or only_lines) and not any(item.severity == "error" for item in (*begun, *found)):
        begun += _report_untouched(program, keep_out, box)
    if not any(item.code == "VP216" for item in found):
        return [*begun, *found]
    left = tuple(
        name.name
        for (body, at), name in zip(keep_out.pairs, keep_out.names, strict=True)
        if at is box and body not in (*TOOL_PARTS, "spindle")
    )
    open_ = [item for item in found if item.code == "VP216" and not item.message.startswith(left or ("\0",))]
    if not open_:
        return [*begun, *found]
    last = _find_last(joints, open_)
    out = next((one for one in found if one.severity == "error" and find_family(one.code) == Family.POSITION), None)
    if out is not None and count_spans(joints, last).sum() > MOST_OF_REFUSED:
        text = (
            f"contact with {box.name} is not computed: line {out.line} is out of limits ({out.code}), and the motion "
            f"is long; correct line {out.line} first"
        )
        undecided = make_finding("VP216", text, severity="warning", line=open_[0].line)
        return [*begun, *(item for item in found if item not in open_), undecided]
    stock = _make_stock(box)
    spans, tools, skipped = list_spans(program, joints, keep_out.moving, last)
    total = len(spans.line)
    stage = "cutting the stock" + NO_NUMBA * (find_spec("numba") is None)

    def report(done: int) -> None:
        check_wanted()
        if progress is not None:
            progress(stage, done, total)

    cut = cut_stock(
        stock,
        spans,
        tools,
        box.distance,
        report,
        only_first=False if skipped else only_first,
        only_spans=bool(only_first) or only_lines,
    )
    cut = replace(cut, touches=tuple(one for one in cut.touches if one.span >= skipped))
    coordinates, cell = program.machine.coordinates, float(stock.cell.max())
    place = program.path.called_lines.place
    thin = _list_thin_tools(program) if any(one.by_line or one.line_gap == one.line_gap for one in cut.touches) else []
    settled = [
        *report_touches(coordinates, cut, spans, tools, box.name, box.distance, cell, _say_no_diameter(program, thin))
    ]
    settled += _report_lines(program, cut, box.name, thin)
    return [*begun, *(item for item in found if item not in open_), *map(place, settled)]


def _list_thin_tools(program: Program) -> list[int]:
    """Tools of unknown diameter, here thin lines, that move at feed."""
    numbers = set[int]()
    for one in (program, program.skipped):
        if one is not None:
            moved = find_tool_of_moves(one.path.move_reached, one.path.first_move, one.moves)
            cutters = set(moved[one.path.feed_time > 0].tolist())
            numbers |= cutters.intersection(_list_started_tools(one.moves)) or cutters
    return [number for number in sorted(numbers) if not find_shape(number, program.options)]


def _say_no_diameter(program: Program, thin: list[int]) -> str:
    names = program.moves.name_tools()
    has = "has no diameter" if len(thin) == 1 else "have no diameters"
    return f"{join_names([describe_tool_number(number, names) for number in thin])} {has}" if thin else ""


def _report_lines(program: Program, cut: Cut, name: str, thin: list[int]) -> list[Finding]:
    """VP216, undecided, where a rapid meets what a cutter of unknown diameter may have cut."""
    sure = {one.line for one in cut.touches if one.body == "cutter" and one.depth == one.depth}
    at = [one.line for one in cut.touches if one.by_line and one.line not in sure]
    if not at or not thin:
        return []
    names = program.moves.name_tools()
    tools, keys = program.options.tools or {}, [find_tool_key(number, "diameter", names) for number in thin]
    length = program.options.tool_length or (tools[thin[0]].offset[2] if thin[0] in tools else 0.0)
    instead = " (which has no tool_length then)" if program.options.tool_length is not None else ""
    entry = f"{quote_key(keys[0][1])} = {{ length = {f'{length:.9g}' if length else 'MM'}, diameter = MM }}"
    text = (
        f"whether the cutter runs into {name} in a rapid traverse is not decided: {_say_no_diameter(program, thin)}, "
        f"so how much was cut before is not known; write [tools] {entry} into the set-up{instead}"
    )
    lines = tuple(dict.fromkeys(at))
    where = {"line": lines[0], "last_line": lines[-1], "worst_line": lines[0], "lines": lines, "count": len(lines)}
    return [make_finding("VP216", text, severity="warning", settled_by=tuple(keys), **where)]


def _make_stock(box: Placed) -> Dexels:
    return make_box(-box.half, box.half, box.middle, box.turn) if box.form is None else box.form.copy()


def _check_start(program: Program, joints: JointPath, keep_out: KeepOut, box: Placed) -> list[Finding]:
    """VP216 where rapids name a first place that is in the stock: however they come there, material is in the way.

    The rapids that name it have no length, because nothing says where the tool comes from.
    """
    moves, first = program.moves, int(program.path.moves_with_length[0])
    named = moves.kind[:first] != MoveKind.DWELL
    rapids = moves.kind[:first] == MoveKind.RAPID
    if program.options.from_line is not None or not named.any() or (named & ~rapids).any():
        return []
    spans, tools, _skipped = list_spans(program, joints, keep_out.moving, 0)
    cutter = tools[int(spans.tool[0])].cutter
    if not cutter:
        return []
    low, high = min(piece.low for piece in cutter), max(piece.high for piece in cutter)
    start, end = (box.map_inside(spans.tip[:1, 0] + height * spans.axis[:1, 0]) for height in (low, high))
    radius = np.array([max(piece.radius for piece in cutter)])
    if measure_cylinder_to_box(start, end, radius, box.half)[0] > 0:  # most programs start above it: no stock is made
        return []
    tip, axis = (np.repeat(one[:1, :1], 2, axis=1) for one in (spans.tip, spans.axis))
    standing = Spans(tip, axis, spans.line[:1], spans.tool[:1], np.ones(1, dtype=bool))
    touches = cut_stock(_make_stock(box), standing, tools).touches
    depth = max((one.depth for one in touches if one.body == "cutter" and one.depth > 0), default=0.0)
    if not depth:
        return []
    line = int(moves.line[np.flatnonzero(named)[-1]])
    text = (
        f"the cutter stands in {box.name} after the rapid traverse of line {line}, to the first place of the program: "
        f"material lies up to {depth:.3f} mm inside it{AS_LINE * tools[int(spans.tool[0])].is_line}"
    )
    return [make_finding("VP216", text, line=line, value=-depth, limit=0.0, unit="mm")]


def _report_untouched(program: Program, keep_out: KeepOut, box: Placed) -> list[Finding]:
    """VP505 where no cut comes into the stock: it, or the part, stands elsewhere, and contacts are looked for in vain.

    Nothing is cut for it: around each cut, and around the stock, stands an upright box.
    """
    options, path = program.options, program.path
    is_doubted = any(one.code == "VP505" and one.message.startswith(f"{box.name}:") for one in program.findings)
    if options.from_line is not None or options.air or is_doubted:
        return []
    gaps, rows = _find_gaps(program, keep_out, box)
    nearest = int(gaps.argmin())
    if gaps[nearest] <= NEAR_STOCK_MM:
        return list(_report_tools_in_air(program, keep_out, box, gaps, rows))
    if gaps[nearest] == np.inf:
        return []
    row = int(rows[nearest])
    frame = program.moves.frames[program.moves.frame[path.move[row]]]
    name, number = name_system(frame.system), int(path.number_lines(np.array([row]))[0])
    remedy = f"correct {name} or [stock]"
    if not box.with_part and frame.system in WORK_SYSTEMS:
        origin = np.array(program.machine.find_origin_on_table(frame))
        there = box.move(turn_from_setup(program.machine.coordinates, origin))
        if _find_gaps(program, keep_out, there)[0].min() <= NEAR_STOCK_MM:
            remedy += f', or write system = "{name}" under [stock] if its numbers are those of the program'
    text = (
        f"no cut comes into {box.name}: the nearest, of {path.called_lines.name_line(number)}, is "
        f"{gaps[nearest]:.1f} mm or more away from it; {remedy}"
    )
    item = make_finding("VP505", text, line=number, advice="")
    return [path.called_lines.place(item)]


def _list_started_tools(moves: Moves) -> list[int]:
    """Tools whose spindle the program starts: others are no cutters, as a probe, unless it starts none."""
    starts = [one.before for one in moves.events if one.kind == "spindle" and one.data["direction"] != "stop"]
    return np.unique(find_tool_of_moves(np.array(starts, dtype=np.int64), 0, moves)).tolist()


def _report_tools_in_air(
    program: Program, keep_out: KeepOut, box: Placed, gaps: Array, rows: Ints
) -> Iterator[Finding]:
    """VP505 of each tool that cuts nothing of the stock, in a work system in which another tool does.

    A tool without a diameter is none that cuts, as a probe; nor is one whose spindle is never started. In a work system
    of its own, or shifted aside by the size of the stock, a tool may cut another part.
    """
    path, moves, tool = program.path, program.moves, keep_out.moving.tool
    started_tools = _list_started_tools(moves)

    def list_places(cuts: Ints) -> Iterator[tuple[int, Array]]:
        for number in np.unique(moves.frame[path.move[cuts]]).tolist():
            frame = moves.frames[number]  # G52, TRANS, cycle 7 and planes make other places of a system
            if frame.feature is not None and not frame.feature.is_programmed:
                frame = replace(frame, feature=None)
            zero, _angles = program.machine.coordinates.map_to_table(np.zeros(9), frame)
            yield frame.system, 0.5 * box.map_inside(zero)[:2] / box.half[:2]

    places_of_cuts = list(list_places(rows[gaps <= NEAR_STOCK_MM]))
    for k in np.flatnonzero((gaps > NEAR_STOCK_MM) & np.isfinite(gaps)).tolist():
        cuts = np.flatnonzero((tool == k) & (path.feed_time > 0) & (path.move >= 0))
        of_tool = int(find_tool_of_moves(path.move[cuts[:1]], path.first_move, moves)[0])
        if not keep_out.moving.shapes[k] or of_tool not in started_tools:
            continue
        if not all(
            any(system == other and np.hypot(*(at - there)) < 1.0 - PLACE_SLACK for other, there in places_of_cuts)
            for system, at in list_places(cuts)
        ):
            continue
        first, last, nearest = path.number_lines(np.array([cuts[0], cuts[-1], rows[k]])).tolist()
        text = (
            f"{describe_tool_number(of_tool, moves.name_tools())} cuts nothing of {box.name}: its nearest cut, of "
            f"{path.called_lines.name_line(nearest)}, is {gaps[k]:.1f} mm or more away from it, and other tools cut "
            f"it; is a height wrong, its sign, or [stock]?"
        )
        lines = {"line": first, "last_line": max(first, last), "worst_line": nearest}
        yield path.called_lines.place(make_finding("VP505", text, **lines, advice=""))


def _find_gaps(program: Program, keep_out: KeepOut, box: Placed) -> tuple[Array, Ints]:
    """How far the cuts of each tool (n,) keep from a box at least, mm, and the segment that comes nearest.

    A tool without cuts has an infinite gap. The first block of segments in which it reaches the box ends its search.
    """
    path, moving = program.path, keep_out.moving
    nearest, at = np.full(len(moving.shapes), np.inf), np.zeros(len(moving.shapes), dtype=np.intp)
    for begin, end in iterate_blocks(len(path)):
        sought = (nearest > NEAR_STOCK_MM)[moving.tool[begin:end]]
        rows = begin + np.flatnonzero(sought & (path.feed_time[begin:end] > 0) & (path.move[begin:end] >= 0))
        if not len(rows):
            continue
        sizes = np.column_stack([moving.tool[rows], np.round(path.tool_length[rows], 6)])
        used, tool = np.unique(sizes, axis=0, return_inverse=True)
        cutters = [build_tool(moving.shapes[int(k)], long, program.machine) for k, long in used.tolist()]
        heights = np.array([max((piece.high for piece in one.cutter), default=0.0) for one in cutters])
        radii = [max((piece.radius for piece in one.cutter), default=0.0) + UNKNOWN_MM * one.is_line for one in cutters]
        height, radius = heights[tool.reshape(-1)], np.array(radii)[tool.reshape(-1)]
        ends = [path.start[rows], path.end[rows]]
        axes = [find_axis_of_angles(one[:, 3], one[:, 4]) for one in ends]
        points = [
            one[:, :3] + part * height[:, None] * axis for one, axis in zip(ends, axes, strict=True) for part in (0, 1)
        ]
        inside = np.array([box.map_inside(one) for one in points])
        sides = [rotate_z(one, -box.turn) for one in axes]
        # around a cylinder stands an upright box, which is wider than its axis across this, and not along it
        across = np.sqrt(np.maximum(1.0 - np.minimum(*np.square(sides)), 0.0))
        # an arc or a spline stays within half of its length of one of its ends, and a tool that turns within its size
        bulge = np.where(path.kind[rows] == SegmentKind.LINE, 0.0, 0.5 * path.length[rows])
        bulge += (height + radius) * np.linalg.norm(axes[1] - axes[0], axis=1)
        reach = radius[:, None] * across + bulge[:, None]
        off = np.maximum(inside.min(axis=0) - box.half, -box.half - inside.max(axis=0)) - reach
        gaps = np.linalg.norm(np.maximum(off, 0.0), axis=1)
        order = np.lexsort((gaps, moving.tool[rows]))
        used, first = np.unique(moving.tool[rows[order]], return_index=True)
        least = order[first]
        nearer = gaps[least] < nearest[used]
        nearest[used[nearer]], at[used[nearer]] = gaps[least[nearer]], rows[least[nearer]]
    return nearest, at


def _find_last(joints: JointPath, found: list[Finding]) -> int:
    """The last element on the lines of findings: what comes after it need not be cut."""
    line = joints.contour.find_lines()
    concerned = np.zeros(len(line), dtype=bool)
    for item in found:
        concerned |= (line >= (item.line or 0)) & (line <= (item.last_line or 0))
    return int(np.flatnonzero(concerned)[-1]) if concerned.any() else len(line) - 1


def list_spans(
    program: Program, joints: JointPath, moving: Moving, last: int, coarse: float = 1.0
) -> tuple[Spans, list[Tool], int]:
    """The motion of elements 0 to ``last`` as spans, and their tools; chords are ``coarse`` times longer.

    What a restart skips comes first, because it has cut the stock; the third value is how many spans that is.
    """
    spans, built = _list_spans(program, joints, moving, last, coarse)
    skipped, whole = 0, program.skipped
    if whole is not None:
        turning = build_moving(whole.machine, whole.path, whole.moves, whole.options)
        before, tools = _list_spans(whole, whole.build_joint_path(), turning, len(whole.contour) - 1, coarse)
        tools += [tool for tool in built if tool not in tools]
        # the same tool may follow its own cut
        spans = replace(spans, tool=np.array([tools.index(tool) for tool in built], dtype=np.intp)[spans.tool])
        both = {name: np.concatenate([getattr(before, name), getattr(spans, name)]) for name in Spans.__struct_fields__}
        spans, built, skipped = Spans(**both), tools, len(before.line)
    return spans, [build_tool(shape, length, joints.machine) for shape, length in built], skipped


def _list_spans(
    program: Program, joints: JointPath, moving: Moving, last: int, coarse: float
) -> tuple[Spans, list[tuple[ToolShape, float]]]:
    """The same of one program, with the shapes and lengths of the tools."""
    contour, path = joints.contour, program.path
    parts = count_spans(joints, last, coarse)
    owner, index = number_parts(parts + 1)
    tip, axis, length = (np.empty((len(owner), *shape)) for shape in ((3,), (3,), ()))
    for begin in range(0, len(owner), SOLVED):
        rows = slice(begin, begin + SOLVED)
        pose = joints.place_bodies(owner[rows], joints.solve(owner[rows], index[rows] / parts[owner[rows]]))
        tip[rows], _nose, length[rows] = moving.place_tools(pose)
        axis[rows] = pose.axis
    chords = np.flatnonzero(
        (index < parts[owner]) & np.isfinite(tip).all(axis=1) & np.isfinite(np.roll(tip, -1, axis=0)).all(axis=1)
    )
    first, ends = join_chords(tip, axis, owner, chords)
    segment = contour.segment[owner[first]]
    used, tool = np.unique(
        np.column_stack([moving.tool[segment], np.round(length[first], 6)]), axis=0, return_inverse=True
    )
    tools = [(moving.shapes[int(k)], long) for k, long in used.tolist()]
    tips, axes = (np.stack([one[first], one[ends]], axis=1) for one in (tip, axis))
    lines, rounding = path.number_lines(segment), find_rounding(contour)[owner[first]]
    started_tools = _list_started_tools(program.moves)
    numbers = find_tool_of_moves(path.move_reached[segment], path.first_move, program.moves)
    still = ~np.isin(numbers, started_tools) & bool(started_tools)
    return Spans(tips, axes, lines, tool.reshape(-1), path.feed_time[segment] == 0, rounding, still), tools


def find_rounding(contour: Contour) -> Array:
    """How far the cutter of a rapid may be in the material that the cut before it leaves in its last corner, mm.

    It is twice the tolerance of that corner, on elements (n,) that belong to it; 0 on others. The rounded corner leaves
    what the programmed one would have cut, and the half of the corner that belongs to the rapid goes through it: each
    half leaves the programmed path by the tolerance, to either side.
    """
    is_rapid = contour.path.feed_time[contour.segment] == 0
    leaves_cut = is_rapid & contour.blended & np.append(False, ~is_rapid[:-1] & contour.blended[:-1])
    return np.where(leaves_cut, 2.0 * contour.tip_tolerance[contour.segment], 0.0)


def count_spans(joints: JointPath, last: int, coarse: float = 1.0) -> Ints:
    """Spans (last + 1,) of elements: one of a straight motion, else as many as it has chords."""
    curved = count_chords(joints)[: last + 1] / coarse
    return np.where(find_straight(joints)[: last + 1], 1, np.maximum(np.ceil(curved), 1)).astype(np.intp)


def count_chords(joints: JointPath) -> Array:
    """Chords (n,) of elements, as shares of whole ones."""
    contour = joints.contour
    return np.maximum(contour.length / CHORD_MM, contour.rotation / CHORD_ANGLE)


def build_tool(shape: ToolShape, length: float, machine: Machine) -> Tool:
    """Cutter, shank, holder and spindle about the axis of a tool of this length, mm."""
    pieces = build_pieces(shape or (WIRE,), length, joined=False)
    flat = 0.5 * shape[0].diameter if shape and shape[0].assumed_flat else 0.0
    tool = group_pieces([*pieces, *build_spindle(machine, length)])
    return replace(tool, is_line=not shape, flat_radius=flat)


def report_touches(
    coordinates: TableCoordinates,
    cut: Cut,
    spans: Spans,
    tools: Sequence[Tool],
    name: str,
    keep_off: float,
    cell: float,
    no_diameter: str = "",
) -> Iterator[Finding]:
    """Findings, one for each body and stretch of neighbouring spans; of bodies that do not cut, of neighbouring lines.

    What may touch is not told in lines in which the same body certainly does, nor here what a line leaves open.
    ``no_diameter`` says which tools that cut before have none.
    """
    for body in dict.fromkeys(one.body for one in cut.touches):
        own = [one for one in cut.touches if one.body == body and not one.by_line]
        sure = [one for one in own if one.depth == one.depth]
        stretches = list(_split_touches(sure))
        lines = {one.line for part in stretches for one in part}
        stretches += _split_touches([one for one in own if one.depth != one.depth and one.line not in lines])
        for part in stretches:
            touching = [(one, tools[int(spans.tool[one.span])]) for one in part if body == "cutter"]
            is_line = any(tool.is_line for _one, tool in touching)
            in_corner = touching and all(one.depth < DEPTH_IN_CORNER * tool.flat_radius for one, tool in touching)
            gaps = [one.line_gap for one, _tool in touching if one.line_gap == one.line_gap]
            remark = AS_LINE if is_line and not gaps else AS_FLAT if in_corner else ""
            if gaps and max(gaps) < np.inf:
                remark += f" ({no_diameter}: part of this material is {max(gaps):.1f} mm away from the cuts before)"
            elif gaps:
                high = f"below the cuts before, or more than {LINE_HEIGHT_MM:g} mm above them"
                remark += f" ({no_diameter}: part of this material is {high})"
            yield _make_finding(coordinates, part, name, keep_off, cell, remark)


def _split_touches(touches: list[Touch]) -> Iterator[list[Touch]]:
    """Stretches of touches of one body, in the order of time."""
    touches = sorted(touches, key=lambda one: one.span)
    begin = 0
    for k in range(1, len(touches) + 1):
        if k < len(touches):
            before, after = touches[k - 1], touches[k]
            if after.span - before.span <= 1 or 0 <= after.line - before.line <= (after.body != "cutter"):
                continue
        yield touches[begin:k]
        begin = k


def _make_finding(
    coordinates: TableCoordinates, touches: list[Touch], name: str, keep_off: float, cell: float, remark: str
) -> Finding:
    worst = max(touches, key=lambda one: np.nan_to_num(one.depth))
    lines = {
        "line": touches[0].line,
        "last_line": touches[-1].line,
        "worst_line": worst.line,
        "count": len({one.line for one in touches}),
    }
    when = " in a rapid traverse" if worst.body == "cutter" else ""
    if worst.depth == worst.depth:
        (before, after), unit = touches[0].begin, "mm"
        if before + after < SHORT_WAY_MM:  # it turns about its tip
            (before, after), unit = touches[0].begin_turn, "deg"
        begins = f"begins {before:.1f} {unit} along line {touches[0].line}, {after:.1f} {unit} before its end"
        if worst.depth > 0:
            what = f"runs into {name}{when}: the contact {begins}; material lies up to {worst.depth:.3f} mm inside it"
        else:
            what = f"passes {name}{when} at {-worst.depth:.3f} mm, nearer than {keep_off:g} mm: this {begins}"
        text = f"the {worst.body} {what}{remark}"
        tip = touches[0].tip
        contact = None if tip is None else tuple(turn_to_setup(coordinates, np.array(tip)).tolist())
        return make_finding("VP216", text, **lines, value=-worst.depth, limit=keep_off, unit="mm", contact=contact)
    text = (
        f"the {worst.body}{when} may touch {name} at that time: it passes nearer than the resolution of {cell:.3g} mm "
        f"can tell{remark}"
    )
    advice = f"Keep the {worst.body} {cell:.3g} mm or more away from the stock there; a smaller stock is cut finer."
    return make_finding("VP216", text, severity="warning", advice=advice, **lines)
