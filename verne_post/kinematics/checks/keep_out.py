"""How near tool, spindle and platform come to fixtures and stock on the table, as boxes.

Tool, holder and shank are cylinders with flat ends, spindle and platform capsules. Every distance is signed and
certain (``separation``), and cannot change faster than the points that carry the bodies move over the table, so whole
motions are checked as in ``check_clearance``.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rotations import axis_of_angles, rotate_z
from verne_post.base.tolerances import ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.kinematics.checks.separation import cylinder_to_box, farther_than
from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Bodies, Machine
from verne_post.model.moves import Frame, Moves
from verne_post.model.options import Options
from verne_post.model.part_setup import SYSTEM_NAMES, TOOL_PARTS, Box, Cylinder, ToolShape
from verne_post.model.poses import Pose
from verne_post.model.protocols import FiveAxis, Margin
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.part.bodies import check_tool

#: Bodies farther from a box than this, beyond what it asks for, are not measured exactly, mm.
NEAR_MM: Final = 25.0
#: Bodies may touch, and reach into a box by this, mm: a tool that slides along a fixture would else be checked in
#: steps of a nanometre.
TOUCH_MM: Final = 0.005
#: Stands for the distance of a body that is not there, or may be there, mm.
FAR_MM: Final = 1e6


class Placed(Struct, frozen=True, eq=False):
    """A box in the table frame.

    Attributes
    ----------
    middle, half : ndarray, shape (3,)
        mm, table frame; half sizes along the box's own edges.
    turn : float
        The box is turned by this about the table's normal, rad.
    distance : float
        mm.
    stock : bool
        Feeding cutters may be in it.
    with_part : bool
        It is given in a work system: it moves with the work offset.
    """

    name: str
    middle: Array
    half: Array
    turn: float
    distance: float
    stock: bool
    with_part: bool = False

    def inside(self, point: Array) -> Array:
        """Points (n, 3) of the table frame in the frame of the box."""
        return rotate_z(point - self.middle, -self.turn)


def place_box(box: Box, middle: Array, turn: float, *, stock: bool) -> Placed:
    """A box whose middle stands at ``middle`` of the table frame, turned by ``turn``."""
    half = 0.5 * (np.array(box.high) - np.array(box.low))
    return Placed(box.name, middle, half, turn, box.distance, stock, box.system is not None)


class KeepOut:
    """The distances between bodies and boxes of one program; implements ``ClearanceModel``.

    Parameters
    ----------
    shapes : sequence of ToolShape
        Of the program's tools; an empty one is a thin line from tip to gauge line.
    lengths : ndarray, shape (len(shapes),)
        Gauge line to tip of the tools themselves, mm, whatever length the program has in force; NaN where nobody knows it
        better than the program.
    tool, entering : ndarray, shape (n_segments,)
        Index into ``shapes``; whether a cutter in the stock is a mistake on the segment.
    bodies : Bodies or None
        Spindle and platform of the machine.
    """

    def __init__(
        self, boxes: Sequence[Placed], shapes: Sequence[ToolShape], lengths: Array, tool: Ints, entering: Mask, bodies: Bodies | None,
        five_axis: FiveAxis,
    ) -> None:  # fmt: skip
        self.boxes, self.lengths, self.tool, self.entering = tuple(boxes), lengths, tool, entering
        self.shapes = tuple(shapes)
        self.bodies, self.five_axis, self.slack = bodies, five_axis, TOUCH_MM
        #: For each tool: cutter, shank, then all parts of the holder: distance of the ends from the tip (NaN: up to the gauge
        #: line) and largest radius; NaN: none.
        holders = max([sum(one.part == "holder" for one in shape) for shape in shapes], default=0)
        self.parts = np.array([_list_parts_of_shape(shape, holders) for shape in shapes]).reshape(
            len(shapes), 2 + holders, 3
        )
        self.thickest = float(np.nanmax(self.parts[:, :, 2], initial=0.0))
        known = np.isfinite(self.parts[:, :, 2]).any(axis=0)
        self.bodies_known = [part for part in TOOL_PARTS if known[_select_columns(part)].any()]
        if bodies is not None and bodies.spindle_radius is not None:
            self.bodies_known.append("spindle")
        if bodies is not None and bodies.platform is not None:
            self.bodies_known.append("platform")
        listed = [(body, box) for box in self.boxes for body in self.bodies_known]
        self.pairs = listed
        self.names: tuple[Margin, ...] = tuple(
            Margin(f"distance of the {body} from {box.name}{_describe_when(body, box)}", "VP216" if box.stock else "VP215", None, "mm",
                   box.distance, box.distance)
            for body, box in listed
        )  # fmt: skip
        #: A tool's rim moves with its axis: two points carry it.
        self.reach: Array = np.array([2.0 if body in TOOL_PARTS else 1.0 for body, _box in listed])
        #: The platform tilts while the tool moves straight, so its distance is not convex.
        self.convex_below: Array = np.array(
            [-np.inf if body == "platform" else box.distance + NEAR_MM for body, box in listed]
        )
        self.group: tuple[str, ...] = tuple("tool" if body in TOOL_PARTS else body for body, _box in listed)

    def moved(self, shift: Array) -> "KeepOut":
        """The same where the part stands elsewhere on the table by ``shift`` (3,), mm: boxes of work systems go with it."""
        boxes = [replace(box, middle=box.middle + shift) if box.with_part else box for box in self.boxes]
        return KeepOut(boxes, self.shapes, self.lengths, self.tool, self.entering, self.bodies, self.five_axis)

    def evaluate(self, pose: Pose) -> tuple[Array, dict[str, Array]]:
        """Margins (n, m) of poses, and by group the points (n, p, 3) of the table frame whose motion bounds their change."""
        axis = pose.axis
        tip, nose, length = self.place_tools(pose)
        points = {"tool": np.stack([tip, nose, self.thickest * axis], axis=1)}
        cylinders: dict[str, list[tuple[Array, Array, Array]]] = {
            part: self._place_tool_part(part, pose, tip, length, axis)
            for part in TOOL_PARTS
            if part in self.bodies_known
        }
        if self.bodies is not None and self.bodies.spindle_radius is not None:
            top = nose + (self.five_axis.nose_offset + self.bodies.spindle_top) * axis
            points["spindle"] = np.stack([nose, top], axis=1)
            cylinders["spindle"] = [(nose, top, np.zeros(len(nose)))]
        if self.bodies is not None and self.bodies.platform is not None:
            ends = [
                self.five_axis.on_table(pose.platform.position + pose.platform.turn(end), pose.q)
                for end in self.bodies.platform
            ]
            points["platform"] = np.stack(ends, axis=1)
            cylinders["platform"] = [(ends[0], ends[1], np.zeros(len(axis)))]
        columns = [
            np.min([self._measure_distance(body, box, one, pose) for one in cylinders[body]], axis=0)
            for body, box in self.pairs
        ]
        return np.stack(columns, axis=1), points

    def place_tools(self, pose: Pose) -> tuple[Array, Array, Array]:
        """Tips (n, 3), gauge lines (n, 3) and lengths (n,) of the tools by themselves, whatever the program has in force."""
        nose = pose.tip + pose.tool_length[:, None] * pose.axis
        by_itself = self.lengths[self.tool[pose.segment]]
        length = np.where(np.isnan(by_itself), pose.tool_length, by_itself)
        return nose - length[:, None] * pose.axis, nose, length

    def _place_tool_part(
        self, part: str, pose: Pose, tip: Array, length: Array, axis: Array
    ) -> list[tuple[Array, Array, Array]]:
        """Both ends and radius of the cylinders of a part of the tool; NaN where the tool in use has no such part."""
        cylinders = []
        for low, high, radius in self.parts[self.tool[pose.segment]][:, _select_columns(part)].transpose(1, 2, 0):
            end = np.where(np.isnan(high), length, high)
            cylinders.append((tip + low[:, None] * axis, tip + end[:, None] * axis, radius))
        return cylinders

    def _measure_distance(self, body: str, box: Placed, cylinder: tuple[Array, Array, Array], pose: Pose) -> Array:
        """Signed distances (n,); exact near the distance that the box requires."""
        start, end, radius = cylinder
        distance = np.full(len(start), FAR_MM)
        there = np.isfinite(radius) & np.isfinite(start).all(axis=1)
        if box.stock and body == "cutter":
            there &= self.entering[pose.segment]
        skin = 0.0
        if self.bodies is not None:
            skin = {"spindle": self.bodies.spindle_radius, "platform": self.bodies.platform_radius}.get(body) or 0.0
        row = np.flatnonzero(there)
        start, end, radius = box.inside(start[row]), box.inside(end[row]), radius[row]
        value = farther_than(start, end, radius, box.half) - skin
        near = np.flatnonzero(value < box.distance + NEAR_MM)
        value[near] = cylinder_to_box(start[near], end[near], radius[near], box.half) - skin
        distance[row] = value
        return distance


def _select_columns(part: str) -> slice:
    """Which cylinders of :attr:`KeepOut.parts` are those of a part."""
    first = TOOL_PARTS.index(part)
    return slice(first, None if part == "holder" else first + 1)


def _list_parts_of_shape(shape: ToolShape, holders: int) -> Array:
    """Distances of both ends from the tip, and the largest radius, of every part; NaN as in :class:`KeepOut`."""
    parts = np.full((2 + holders, 3), np.nan)
    if not shape:
        parts[0] = 0.0, np.nan, 0.0
    at, holder = 0.0, 2
    for one in shape:
        # the last part goes up to the gauge line, whatever its length: something is there
        end = np.nan if one.length is None or one is shape[-1] else at + one.length
        parts[holder if one.part == "holder" else TOOL_PARTS.index(one.part)] = at, end, 0.5 * one.widest
        holder += one.part == "holder"
        at = end
    return parts


def build_keep_out(
    machine: Machine, path: ToolPath, moves: Moves, options: Options, frames: Mapping[int, Frame]
) -> KeepOut | None:
    """What a program has to keep out of; None where nothing is named.

    Parameters
    ----------
    moves : Moves
        Says which tool is in the spindle.
    options : Options
        ``keep_out``, ``stock``, ``tool_shapes``, and the diameters of the tool table.
    frames : mapping
        Work systems by number, as they are given before the program.

    Raises
    ------
    InputError
        VP018 where a tool is shorter than its parts.
    """
    boxes = [(box, False) for box in options.keep_out]
    if options.stock is not None:
        boxes.append((options.stock, True))
    if not boxes:
        return None
    standing = []
    for box, stock in boxes:
        middle = 0.5 * (np.array(box.low) + np.array(box.high))
        middle, turn = place_body(machine, box.name, box.system, middle, moves, options, frames)
        standing.append(place_box(box, middle, turn, stock=stock))
    number = tool_of_moves(path.move_reached, path.first_move, moves)
    numbers, index = np.unique(number, return_inverse=True)
    shapes = [_shape_of(int(one), options) for one in numbers]
    lengths = np.array([find_length_by_itself(int(one), options) for one in numbers])
    for one, shape, by_itself in zip(numbers.tolist(), shapes, lengths.tolist(), strict=True):
        in_force = float(path.tool_length[number == one].max()) - options.lift
        table = (options.tools or {}).get(int(one))
        check_tool(
            f"tool {one}",
            shape,
            in_force if np.isnan(by_itself) else by_itself,
            0.0 if table is None else table.diameter,
        )
    # a cutter that is wider below, or may be, does not come back up through what it has left
    undercuts = np.array(
        [any(one.neck_diameter > 0 or one.taper < 0 or bool(one.profile) for one in shape) for shape in shapes]
    )
    entering = _find_entering_rapids(path, index) | (undercuts[index] & (path.feed_time == 0))
    return KeepOut(standing, shapes, lengths, index, entering, machine.bodies, machine.five_axis)


def _describe_when(body: str, box: Placed) -> str:
    """When a body has to keep out of a box, where that is not always."""
    return " in a rapid traverse" if box.stock and body == "cutter" else ""


def refuse_leaning_part(machine: Machine, name: str) -> None:
    """Refuse (VP018) a body on a machine that turns the part about another axis than z: it would lean in the table frame."""
    if not np.isclose(machine.coordinates.part_frame[2, 2], 1.0):
        text = f"{name}: bodies on the part are not executed on a machine whose joints do not turn about z of the part"
        raise InputError(finding("VP018", text))


def place_body(
    machine: Machine, name: str, system: int | None, point: Array, moves: Moves, options: Options, frames: Mapping[int, Frame]
) -> tuple[Array, float]:  # fmt: skip
    """Where a point (3,) of a body is in the table frame, mm, and how far the body is turned there, rad.

    Parameters
    ----------
    system : int or None
        The work system in which the body is given; None: the part frame, of which work offsets count.

    Raises
    ------
    InputError
        VP018 where nobody has given the place of the system, the program moves it, or the body leans in the table frame.
    """
    refuse_leaning_part(machine, name)
    if system is None:
        x, y, _z = machine.coordinates.part_frame[:, 0]
        return machine.coordinates.part_frame @ point, float(np.arctan2(y, x))
    if system not in options.wcs:
        text = f"{name} is given in {SYSTEM_NAMES[system]}, and {SYSTEM_NAMES[system]} is not: give it with --wcs or --measured-offset, or {name} on the table"
        raise InputError(finding("VP018", text))
    given = frames[system]
    place = (given.origin, given.turn, given.part_turn)
    if any(one.system == system and (one.origin, one.turn, one.part_turn) != place for one in moves.frames):
        text = f"{name} is given in {SYSTEM_NAMES[system]}, which the program moves (G10); give {name} on the table"
        raise InputError(finding("VP018", text))
    direction = machine.coordinates.displacement(np.array([1.0, 0.0, 0.0]), given)
    on_table = machine.coordinates.to_table(np.concatenate([point, np.zeros(6)]), given)[0]
    return on_table, float(np.arctan2(direction[1], direction[0]))


def tool_of_moves(move: Ints, first: int, moves: Moves) -> Ints:
    """Number of the tool in the spindle at moves (n,), 0 where none is named; the way to the ``first`` motion has its tool."""
    changes = [event for event in moves.events if event.kind in ("tool", "tool number")]
    before = np.array([event.before for event in changes], dtype=np.int64)
    numbers = np.array([0, *(event.data["number"] for event in changes)], dtype=np.int64)
    return np.asarray(numbers[np.searchsorted(before, np.maximum(move, first), side="right")])


def _shape_of(number: int, options: Options) -> ToolShape:
    """The shape of a tool: the given one, a cylinder of the tool table's diameter, or nothing known."""
    if number in options.tool_shapes:
        return options.tool_shapes[number]
    tool = (options.tools or {}).get(number)
    return (Cylinder("cutter", tool.diameter),) if tool is not None and tool.diameter > 0 else ()


def find_length_by_itself(number: int, options: Options) -> float:
    """Gauge line to tip of a tool by itself, also while G49 is in force; NaN where only the program gives it."""
    if options.tool_length is not None:
        return options.tool_length
    tool = (options.tools or {}).get(number)
    return np.nan if tool is None else tool.offset[2]


def _find_entering_rapids(path: ToolPath, tool: Ints) -> Mask:
    """Rapids in which a cutter must keep out of the stock, of segments with these tools (n,).

    All but straight ones along the tool axis that retract, or go back down into a hole which the tool has just drilled.
    """
    delta = path.end - path.start
    axis = axis_of_angles(path.start[:, 3], path.start[:, 4])
    up = (delta[:, :3] * axis).sum(1)
    aside = np.linalg.norm(delta[:, :3] - up[:, None] * axis, axis=1)
    turned = (np.abs(delta[:, 3:]) > ZERO_ANGLE).any(axis=1)
    axial = (path.kind == SegmentKind.LINE) & (aside < ZERO_LENGTH_MM) & ~turned
    rapid = path.feed_time == 0
    entering = rapid & ~(axial & (up > 0))
    run = np.cumsum(~axial | (np.diff(tool, prepend=tool[:1]) != 0))  # up and down one line with one tool
    height = np.cumsum(up)
    for one in np.unique(run[entering & axial]):
        rows = slice(*np.searchsorted(run, [one, one + 1]))
        drilled = np.minimum.accumulate(np.where(rapid[rows], np.inf, height[rows]))
        entering[rows] &= ~axial[rows] | (height[rows] < drilled - ZERO_LENGTH_MM)
    return np.asarray(entering)
