"""How near tool, spindle, platform and rods come to fixtures and stock on the table, as boxes or meshes.

Against boxes, tool, holder and shank are cylinders with flat ends; platform and rods are capsules, and the spindle is
one of both. Every distance is signed and certain (``separation``). It cannot change faster than the points that carry
the bodies move over the table, so whole motions are checked as in ``check_clearance``. Against meshes,
``mesh_contacts`` checks them.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Final, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rotations import find_axis_of_angles, rotate_z
from verne_post.base.tolerances import ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.kinematics.checks.mesh_distances import measure_distances
from verne_post.kinematics.checks.moving import FAR_MM, Bar, Moving
from verne_post.kinematics.checks.separation import bound_distance, measure_cylinder_to_box
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Machine
from verne_post.model.moves import Frame, Moves, Stock, find_tool_of_moves
from verne_post.model.options import Options
from verne_post.model.part_setup import (
    TOOL_PARTS,
    Box,
    Cylinder,
    FixtureMesh,
    OwnStock,
    ToolShape,
    describe_tool_number,
    name_system,
)
from verne_post.model.poses import Pose
from verne_post.model.protocols import Margin
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.model.work_systems import find_placer
from verne_post.part.bodies import check_tool
from verne_post.part.clearance import TOUCH_MM
from verne_post.part.dexels import Dexels
from verne_post.part.fixture import load_fixture
from verne_post.part.rigid import CORNERS, Balls, build_balls, find_distances
from verne_post.part.stl import Mesh, build_mesh
from verne_post.part.stock_forms import make_cylinder, read_stock

#: Corners of the facets of a box, counter-clockwise from outside.
_BOX_FACETS: Final = np.array(
    [
        (a, *pair)
        for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
        for pair in ((b, c), (c, d))
    ]
)
#: Bodies farther from a box than this, beyond what it asks for, are not measured exactly, mm.
NEAR_MM: Final = 25.0


#: How a body and an obstacle are held against each other.
Kind = Literal["box", "mesh", "rigid"]
KINDS: Final[tuple[Kind, ...]] = ("box", "mesh", "rigid")


@lru_cache(maxsize=64)
def _make_box(x: float, y: float, z: float) -> Mesh:
    """The mesh of a box about zero with these half sizes."""
    corner = (2.0 * CORNERS - 1.0) * (x, y, z)
    return build_mesh("box", corner[_BOX_FACETS])


@lru_cache(maxsize=64)
def _make_balls(mesh: Mesh) -> Balls:
    return build_balls(mesh)


class Placed(Struct, frozen=True, eq=False):
    """A box or a mesh in the table frame."""

    name: str
    middle: Array  #: (3,): Of a box, or the zero of a mesh; mm, table frame.
    half: Array  #: (3,): Half sizes along the box's own edges, mm; 0 of a mesh.
    turn: float  #: The box is turned by this about the table's normal, rad.
    distance: float  #: mm.
    stock: bool  #: Feeding cutters may be in it.
    with_part: bool = False  #: It is given in a work system: it moves with the work offset.
    mesh: Mesh | None = None  #: About its zero, not turned.
    form: Dexels | None = None  #: Of a stock that is no box: the box is around it.

    def map_inside(self, point: Array) -> Array:
        """Points (n, 3) of the table frame in its own frame."""
        return rotate_z(point - self.middle, -self.turn)

    @property
    def surface(self) -> Mesh:
        """Its mesh, or that of the box, in its own frame."""
        return self.mesh if self.mesh is not None else _make_box(*self.half.tolist())

    @property
    def balls(self) -> Balls:
        """The tree of that mesh."""
        return _make_balls(self.surface)

    def find_extent(self) -> tuple[Array, Array]:
        """Least and greatest x, y, z (3,) of it on the table, mm."""
        corner = rotate_z(self.surface.vertices, self.turn) + self.middle
        return corner.min(axis=0), corner.max(axis=0)

    def describe_extent(self) -> str:
        """Its size along x, y, z of the table, and its least corner there, in words."""
        low, high = self.find_extent()
        size = " x ".join(f"{one:.4g}" for one in high - low)
        return f"{size} mm from ({', '.join(f'{one:.4g}' for one in low + 0.0)})"

    def move(self, shift: Array) -> "Placed":
        """The same elsewhere on the table by ``shift`` (3,), mm."""
        form = None if self.form is None else self.form.move(shift, 0.0)
        return replace(self, middle=self.middle + shift, form=form)


def place_box(box: Box, middle: Array, turn: float, *, stock: bool) -> Placed:
    """A box whose middle stands at ``middle`` of the table frame, turned by ``turn``."""
    half = 0.5 * (np.array(box.high) - np.array(box.low))
    return Placed(box.name, middle, half, turn, box.distance, stock, box.system is not None)


class KeepOut:
    """The distances between moving bodies and boxes and meshes of one program; implements ``ClearanceModel``.

    Parameters
    ----------
    obstacles : sequence of Placed
    entering : ndarray of bool, shape (n_segments,)
        Whether a cutter in the stock is a mistake on the segment.
    kinds : sequence of {"box", "mesh", "rigid"}
        Which pairs: bodies of revolution and boxes, those and meshes, or meshes of the machine and both.
    """

    def __init__(
        self, obstacles: Sequence[Placed], moving: Moving, entering: Mask, kinds: Sequence[Kind] = KINDS
    ) -> None:
        self.obstacles, self.moving, self.entering, self.slack = tuple(obstacles), moving, entering, TOUCH_MM
        self.boxes = tuple(one for one in self.obstacles if one.mesh is None)
        self.kinds = kinds
        self.pairs = [
            (body, one)
            for one in self.obstacles
            for body in moving.list_bodies(stock=one.stock)
            if _find_kind(body, one, moving) in kinds
        ]
        self.names: tuple[Margin, ...] = tuple(
            Margin(
                f"distance of the {body} from {one.name}{_describe_when(body, one)}",
                "VP216" if one.stock else "VP215",
                None,
                "mm",
                one.distance,
                one.distance,
            )
            for body, one in self.pairs
        )
        #: A tool's rim moves with its axis: two points carry it.
        flat = (*TOOL_PARTS, *["spindle"] * (moving.bodies is not None and moving.bodies.spindle_is_flat))
        self.reach: Array = np.array([2.0 if body in flat else 1.0 for body, _one in self.pairs])
        #: Platform and legs tilt while the tool moves straight, so their distance is not convex.
        self.convex_below: Array = np.array(
            [one.distance + NEAR_MM if body in (*TOOL_PARTS, "spindle") else -np.inf for body, one in self.pairs]
        )
        self.group: tuple[str, ...] = tuple(moving.group_of(body) for body, _one in self.pairs)

    def move_part(self, shift: Array) -> "KeepOut":
        """The same with the part moved on the table by ``shift`` (3,), mm: bodies of work systems go with it."""
        obstacles = [one.move(shift) if one.with_part else one for one in self.obstacles]
        return KeepOut(obstacles, self.moving, self.entering, self.kinds)

    def select(self, kind: Kind) -> "KeepOut":
        """The same of one kind of pairs alone."""
        kept = dict.fromkeys(one for body, one in self.pairs if _find_kind(body, one, self.moving) == kind)
        return KeepOut(tuple(kept), self.moving, self.entering, (kind,))

    def evaluate(self, pose: Pose, *, least_only: bool = False) -> tuple[Array, dict[str, Array]]:
        """Margins (n, m) of poses, and by group the points (n, p, 3), table frame, whose motion bounds their change.

        Those from meshes are no bounds: points of the surface have them.
        """
        bars, points = self.moving.place(pose)
        meshes = {
            one.name: measure_distances(
                one.mesh, one.middle, one.turn, self.moving, pose, one.distance + NEAR_MM, least_only=least_only
            )
            for one in self.obstacles
            if one.mesh is not None
        }
        corners = self.moving.carry_corners(pose)
        columns = []
        for body, one in self.pairs:
            if _find_kind(body, one, self.moving) == "rigid":
                corner = one.map_inside(corners[body])
                distance = find_distances(self.moving.rigid[body], one.balls, corner, one.distance + NEAR_MM)
                columns.append(np.where(np.isnan(distance), FAR_MM, distance))
                continue
            if one.mesh is not None:
                columns.append(meshes[one.name][body])
                continue
            there = self.entering[pose.segment] if one.stock and body == "cutter" else None
            columns.append(np.min([_measure_to_box(one, bar, there) for bar in bars[body]], axis=0))
        return np.stack(columns, axis=1), points


def _find_kind(body: str, one: Placed, moving: Moving) -> Kind:
    """How a body and an obstacle are held against each other."""
    if body in moving.rigid and not one.stock:
        return "rigid"
    return "box" if one.mesh is None else "mesh"


def _measure_to_box(box: Placed, bar: Bar, there: Mask | None) -> Array:
    """Signed distances (n,); exact near the distance that the box requires."""
    distance = np.full(len(bar.start), FAR_MM)
    row = np.flatnonzero(
        np.isfinite(bar.radius) & np.isfinite(bar.start).all(axis=1) & (True if there is None else there)
    )
    start, end, radius = box.map_inside(bar.start[row]), box.map_inside(bar.end[row]), bar.radius[row]
    value = bound_distance(start, end, radius, box.half) - bar.skin
    near = np.flatnonzero(value < box.distance + NEAR_MM)
    value[near] = measure_cylinder_to_box(start[near], end[near], radius[near], box.half) - bar.skin
    distance[row] = value
    return distance


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
    standing = place_bodies(machine, moves, options, frames)
    if not standing:
        return None
    moving = build_moving(machine, path, moves, options)
    # a cutter that is wider below, or may be, does not come back up through what it has left
    undercuts = np.array(
        [any(one.neck_diameter > 0 or one.taper < 0 or bool(one.profile) for one in shape) for shape in moving.shapes]
    )
    entering = _find_entering_rapids(path, moving.tool) | (undercuts[moving.tool] & (path.feed_time == 0))
    return KeepOut(standing, moving, entering)


def place_bodies(machine: Machine, moves: Moves, options: Options, frames: Mapping[int, Frame]) -> list[Placed]:
    """The fixtures and the stock of the options, in this order, where they stand.

    Raises
    ------
    InputError
        VP018, VP506.
    """
    standing: list[Placed] = []
    for body in (*options.keep_out, *([] if options.stock is None else [options.stock])):
        if isinstance(body, OwnStock):
            standing.append(place_own_stock(machine, moves, options, body.distance))
            continue
        zero = np.zeros(3) if isinstance(body, FixtureMesh) else 0.5 * (np.array(body.low) + np.array(body.high))
        middle, turn = place_body(machine, body.name, body.system, zero, moves, options, frames)
        if isinstance(body, FixtureMesh) and body is options.stock:
            standing.append(_place_stock(body, middle, turn))
        elif isinstance(body, FixtureMesh):
            mesh = load_fixture(body.raw, body.shown, body.unit)
            with_part = body.system is not None
            standing.append(Placed(body.name, middle, np.zeros(3), turn, body.distance, False, with_part, mesh))
        else:
            standing.append(place_box(body, middle, turn, stock=body is options.stock))
    return standing


def place_own_stock(machine: Machine, moves: Moves, options: Options, distance: float = 0.0) -> Placed:
    """The stock that a program defines, where its part stands: a box, or a cylinder and the box around it.

    Raises
    ------
    InputError
        VP018 where the program defines none, in a work system without a place beside others that have one, or it leans
        in the table frame.
    """
    own = moves.stock
    if own is None:
        raise make_input_error("VP018", "--stock program: the program defines no stock (BLK FORM, WORKPIECE)")
    if options.wcs and find_placer(own.frame, machine, options, moves.placed_systems) == "nobody":
        name = name_system(own.frame.system)
        text = (
            f"--stock program: line {own.line} defines the stock in {name}, and {name} is not given: give it with --wcs"
        )
        raise make_input_error("VP018", text)
    refuse_leaning_part(machine, "the stock of the program")
    middle, along, half = measure_own_stock(machine, own)
    turn = float(np.arctan2(along[1], along[0]))
    form = make_cylinder(-half, half, own.bore, middle, turn) if own.round else None
    return Placed(OwnStock().name, middle, half, turn, distance, True, True, form=form)


def measure_own_stock(machine: Machine, own: Stock) -> tuple[Array, Array, Array]:
    """Middle (3,) of a program's stock, direction (3,) of its x, and half of its sides (3,); table frame, mm."""
    low, high = np.array(own.low), np.array(own.high)
    middle = machine.coordinates.map_to_table(np.concatenate([0.5 * (low + high), np.zeros(6)]), own.frame)[0]
    return middle, machine.coordinates.turn_displacement(np.array([1.0, 0.0, 0.0]), own.frame), 0.5 * (high - low)


def _place_stock(body: FixtureMesh, origin: Array, turn: float) -> Placed:
    """A stock of a file whose zero stands at ``origin``, turned by ``turn``: as it is, and the box around it."""
    form = read_stock(body.raw, body.shown, body.unit).move(origin, turn)
    middle, half = form.place_outside(0.5 * (form.least + form.most)), 0.5 * (form.most - form.least)
    return Placed(body.name, middle, half, form.turn, body.distance, True, body.system is not None, form=form)


def build_moving(machine: Machine, path: ToolPath, moves: Moves, options: Options) -> Moving:
    """What moves over the table: the tools of a program, and the machine.

    Raises
    ------
    InputError
        VP018 where a tool is shorter than its parts.
    """
    number = find_tool_of_moves(path.move_reached, path.first_move, moves)
    numbers, index = np.unique(number, return_inverse=True)
    shapes = [find_shape(int(one), options) for one in numbers]
    lengths = np.array([find_length_by_itself(int(one), options) for one in numbers])
    for one, shape, by_itself in zip(numbers.tolist(), shapes, lengths.tolist(), strict=True):
        in_force = float(path.tool_length[number == one].max()) - options.lift
        table = (options.tools or {}).get(int(one))
        check_tool(
            describe_tool_number(int(one), moves.name_tools()),
            shape,
            in_force if np.isnan(by_itself) else by_itself,
            table,
        )
    return Moving(shapes, lengths, index, machine)


def _describe_when(body: str, box: Placed) -> str:
    """When a body has to keep out of a box, where that is not always."""
    return " in a rapid traverse" if box.stock and body == "cutter" else ""


def refuse_leaning_part(machine: Machine, name: str) -> None:
    """Refuse (VP018) a body on a machine that turns the part about another axis than z: it would lean."""
    if not np.isclose(machine.coordinates.part_frame[2, 2], 1.0):
        text = f"{name}: bodies on the part are not executed on a machine whose joints do not turn about z of the part"
        raise make_input_error("VP018", text)


def place_body(
    machine: Machine,
    name: str,
    system: int | None,
    point: Array,
    moves: Moves,
    options: Options,
    frames: Mapping[int, Frame],
) -> tuple[Array, float]:
    """Where a point (3,) of a body is in the table frame, mm, and how far the body is turned there, rad.

    Parameters
    ----------
    system : int or None
        The work system in which the body is given; None: the part frame, of which work offsets count.

    Raises
    ------
    InputError
        VP018 where the place of the system is not given, the program moves it, or the body leans in the table frame.
    """
    refuse_leaning_part(machine, name)
    if system is None:
        x, y, _z = machine.coordinates.part_frame[:, 0]
        return machine.coordinates.part_frame @ point, float(np.arctan2(y, x))
    if system not in options.wcs:
        text = (
            f"{name} is given in {name_system(system)}, and {name_system(system)} is not: give it with --wcs or "
            f"--measured-offset, or {name} on the table"
        )
        raise make_input_error("VP018", text)
    given = frames[system]
    place = (given.origin, given.turn, given.part_turn)
    if any(one.system == system and (one.origin, one.turn, one.part_turn) != place for one in moves.frames):
        text = f"{name} is given in {name_system(system)}, which the program moves (G10); give {name} on the table"
        raise make_input_error("VP018", text)
    direction = machine.coordinates.turn_displacement(np.array([1.0, 0.0, 0.0]), given)
    on_table = machine.coordinates.map_to_table(np.concatenate([point, np.zeros(6)]), given)[0]
    return on_table, float(np.arctan2(direction[1], direction[0]))


def find_shape(number: int, options: Options) -> ToolShape:
    """The shape of a tool: the given one, a cutter of the tool table's diameter and corner, or nothing known.

    A cutter without a known corner counts as flat.
    """
    if number in options.tool_shapes:
        return options.tool_shapes[number]
    tool = (options.tools or {}).get(number)
    if tool is None or not tool.diameter > 0:
        return ()
    corner = tool.corner_radius
    return (Cylinder("cutter", tool.diameter, corner_radius=corner or 0.0, assumed_flat=corner is None),)


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
    axis = find_axis_of_angles(path.start[:, 3], path.start[:, 4])
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
