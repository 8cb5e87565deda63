"""What moves over the table: the tool and its holder, spindle, platform, and the rods of the legs."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.kinematics.checks.bodies import Clearance
from verne_post.model.machine import Machine
from verne_post.model.part_setup import TOOL_PARTS, Cylinder, ToolShape
from verne_post.model.poses import Pose
from verne_post.part.bodies import Piece, build_capsule, build_cylinder, build_pieces
from verne_post.part.fixture import load_fixture
from verne_post.part.rigid import Body, build_body

#: Stands for the distance of a body that is not there, or may be there, mm.
FAR_MM: Final = 1e6
#: Radius of what has no size, mm: a line would pierce a mesh unseen, and this is more than bodies may reach into one.
THIN_MM: Final = 0.01
#: Stands for a tool whose size nobody has given.
WIRE: Final = Cylinder("cutter", 2.0 * THIN_MM)


class Bar(Struct, frozen=True, eq=False):
    """Cylinders with flat ends at poses: start and end (n, 3) on the table, radius (n,), rounding skin; mm."""

    start: Array
    end: Array
    radius: Array
    skin: float = 0.0


class Carried(Struct, frozen=True, eq=False):
    """Pieces about an axis at poses: origin and axis (n, 3) on the table; all within ``far`` mm of the origin."""

    body: str
    origin: Array
    axis: Array
    far: float


@lru_cache(maxsize=8)
def _load_body(raw: bytes, name: str, unit: str) -> Body:
    return build_body(load_fixture(raw, name, unit))


class Moving:
    """The bodies of one program and its machine.

    Parameters
    ----------
    shapes : sequence of ToolShape
        Of the program's tools; an empty one is a thin line from tip to gauge line.
    lengths : ndarray, shape (len(shapes),)
        Gauge line to tip of the tools themselves, mm, not that in force; NaN where only the program knows it.
    tool : ndarray of int, shape (n_segments,)
        Index into ``shapes``.
    machine : Machine
        Has the sizes of spindle, platform and rods.
    """

    def __init__(self, shapes: Sequence[ToolShape], lengths: Array, tool: Ints, machine: Machine) -> None:
        self.shapes, self.lengths, self.tool, self.machine = tuple(shapes), lengths, tool, machine
        self.bodies = machine.bodies
        #: Of tools and lengths: remedies ask for them again and again.
        self._pieces: dict[tuple[int, float], tuple[Piece, ...]] = {}
        #: For each tool, cutter, shank, then all parts of the holder: distance of the ends from the tip (NaN: up to the
        #: gauge line) and largest radius; NaN: none.
        holders = max([sum(one.part == "holder" for one in shape) for shape in shapes], default=0)
        self.parts = np.array([_list_parts_of_shape(shape, holders) for shape in shapes]).reshape(
            len(shapes), 2 + holders, 3
        )
        self.thickest = float(np.nanmax(self.parts[:, :, 2], initial=0.0))
        known = np.isfinite(self.parts[:, :, 2]).any(axis=0)
        self.known = [part for part in TOOL_PARTS if known[_select_columns(part)].any()]
        self.module = machine.clearance.module if isinstance(machine.clearance, Clearance) else None
        #: Meshes of the machine, in the platform frame: against fixtures they stand for the capsule of the same name.
        self.rigid: dict[str, Body] = {one.name: _load_body(one.raw, one.shown, one.unit) for one in machine.meshes}
        #: Numbers of the rods of a leg.
        self.legs: dict[str, list[int]] = {}
        if self.bodies is not None:
            if self.bodies.spindle_radius is not None:
                self.known.append("spindle")
            if self.bodies.platform is not None:
                self.known.append("platform")
            if self.bodies.rod_radius is not None and self.module is not None:
                for k, leg in enumerate(self.module.rod_legs):
                    self.legs.setdefault(f"leg {leg}", []).append(k)
        self.known += self.legs

    def list_bodies(self, *, stock: bool) -> list[str]:
        """Bodies that keep out of the stock, or of fixtures."""
        return self.known if stock else list(dict.fromkeys([*self.known, *self.rigid]))

    def carry_corners(self, pose: Pose) -> dict[str, Array]:
        """Corners (n, 8, 3) on the table of the boxes around the meshes of the machine."""
        return {
            name: np.stack(
                [
                    self.machine.five_axis.carry_to_table(pose.platform.position + pose.platform.turn(corner), pose.q)
                    for corner in body.list_corners()
                ],
                axis=1,
            )
            for name, body in self.rigid.items()
        }

    def group_of(self, body: str) -> str:
        """Which points of :meth:`place` carry a body."""
        return "tool" if body in TOOL_PARTS else "rods" if body in self.legs else body

    def place(self, pose: Pose) -> tuple[dict[str, list[Bar]], dict[str, Array]]:
        """Bodies by name, and by group the points (n, p, 3) of the table frame whose motion bounds theirs."""
        axis, still = pose.axis, np.zeros(len(pose.axis))
        tip, nose, length = self.place_tools(pose)
        points = {"tool": np.stack([tip, nose, self.thickest * axis], axis=1)}
        rods: dict[str, list[Bar]] = {}
        for part in TOOL_PARTS:
            if part in self.known:
                rods[part] = self._place_tool_part(part, pose, tip, length, axis)
        if self.bodies is not None and self.bodies.spindle_radius is not None:
            top = nose + (self.machine.five_axis.nose_offset + self.bodies.spindle_top) * axis
            radius = self.bodies.spindle_radius
            if self.bodies.spindle_is_flat:  # its rim moves with its axis
                points["spindle"] = np.stack([nose, top, radius * axis], axis=1)
                rods["spindle"] = [Bar(nose, top, still + radius)]
            else:
                points["spindle"] = np.stack([nose, top], axis=1)
                rods["spindle"] = [Bar(nose, top, still, radius)]
        if "platform" in self.known and self.bodies is not None:
            first, last = self._place_platform(pose)
            points["platform"] = np.stack([first, last], axis=1)
            rods["platform"] = [Bar(first, last, still, self.bodies.platform_radius)]
        if self.legs and self.bodies is not None and self.bodies.rod_radius is not None:
            start, end = self._place_rods(pose)
            points["rods"] = np.concatenate([start, end], axis=1)
            thick = self.bodies.rod_radius.tolist()
            rods |= {leg: [Bar(start[:, k], end[:, k], still, thick[k]) for k in own] for leg, own in self.legs.items()}
        return rods, points

    def place_tools(self, pose: Pose) -> tuple[Array, Array, Array]:
        """Tips (n, 3), gauge lines (n, 3) and lengths (n,) of the tools themselves, not those in force."""
        nose = pose.tip + pose.tool_length[:, None] * pose.axis
        by_itself = self.lengths[self.tool[pose.segment]]
        length = np.where(np.isnan(by_itself), pose.tool_length, by_itself)
        return nose - length[:, None] * pose.axis, nose, length

    def carry(self, pose: Pose) -> list[Carried]:
        """Where the bodies of revolution of :func:`build_pieces` are; that of the tools comes first."""
        tip, _nose, length = self.place_tools(pose)
        spindle = 0.0
        if self.bodies is not None and self.bodies.spindle_radius is not None:
            spindle = self.machine.five_axis.nose_offset + self.bodies.spindle_top + self.bodies.spindle_radius
        far = float(np.hypot(np.nanmax(length, initial=0.0) + spindle, max(self.thickest, spindle)))
        carried = [Carried("tool", tip, pose.axis, far)]
        rods = []
        if "platform" in self.known and self.bodies is not None:
            rods.append(("platform", *self._place_platform(pose), self.bodies.platform_radius))
        if self.legs and self.bodies is not None and self.bodies.rod_radius is not None:
            start, end = self._place_rods(pose)
            rods += [
                (leg, start[:, k], end[:, k], float(self.bodies.rod_radius[k]))
                for leg, own in self.legs.items()
                for k in own
            ]
        for body, start, end, radius in rods:
            along = end - start
            long = np.linalg.norm(along, axis=1)
            axis = along / np.where(long > 0, long, 1.0)[:, None]
            axis[long == 0] = (0.0, 0.0, 1.0)
            carried.append(Carried(body, start, axis, float(np.nanmax(long, initial=0.0)) + radius))
        return carried

    def list_pieces(self, one: Carried, pose: Pose) -> Iterator[tuple[Ints, tuple[Piece, ...]]]:
        """Poses with one tool of one length that can be solved, and the pieces of what is carried there."""
        solved = np.isfinite(one.origin).all(axis=1) & np.isfinite(one.axis).all(axis=1)
        if one.body != "tool":
            yield np.flatnonzero(solved), self._build_capsule(one)
            return
        tool, length = self.tool[pose.segment], np.round(self.place_tools(pose)[2], 6)
        for k in np.unique(tool[solved]).tolist():
            own = np.flatnonzero(solved & (tool == k))
            for long in np.unique(length[own]).tolist():
                if (k, long) not in self._pieces:
                    pieces = build_pieces(self.shapes[k] or (WIRE,), long)
                    self._pieces[k, long] = (*pieces, *build_spindle(self.machine, long))
                yield own[length[own] == long], self._pieces[k, long]

    def _build_capsule(self, one: Carried) -> tuple[Piece, ...]:
        assert self.bodies is not None
        radius = self.bodies.platform_radius
        if one.body in self.legs and self.bodies.rod_radius is not None:
            radius = float(self.bodies.rod_radius[self.legs[one.body]].max())
        radius = max(radius, THIN_MM)
        return (build_capsule(one.body, 0.0, one.far - radius, radius),)

    def _place_platform(self, pose: Pose) -> tuple[Array, Array]:
        assert self.bodies is not None
        assert self.bodies.platform is not None
        first, last = (
            self.machine.five_axis.carry_to_table(pose.platform.position + pose.platform.turn(end), pose.q)
            for end in self.bodies.platform
        )
        return first, last

    def _place_rods(self, pose: Pose) -> tuple[Array, Array]:
        """Both ends (n, k, 3) of the rods."""
        assert self.module is not None
        start, end = (
            np.stack([self.machine.five_axis.carry_to_table(one, pose.q) for one in np.moveaxis(ends, 1, 0)], axis=1)
            for ends in self.module.find_rod_ends(pose.q[:, :-2], pose.platform)
        )
        return start, end

    def _place_tool_part(self, part: str, pose: Pose, tip: Array, length: Array, axis: Array) -> list[Bar]:
        """The cylinders of a part of the tool; NaN where the tool in use has no such part."""
        rods = []
        for low, high, radius in self.parts[self.tool[pose.segment]][:, _select_columns(part)].transpose(1, 2, 0):
            end = np.where(np.isnan(high), length, high)
            rods.append(Bar(tip + low[:, None] * axis, tip + end[:, None] * axis, radius))
        return rods


def build_spindle(machine: Machine, length: float) -> tuple[Piece, ...]:
    """The spindle above a tool of this length, mm; none where the machine file has no size of it."""
    bodies = machine.bodies
    if bodies is None or bodies.spindle_radius is None:
        return ()
    top = length + machine.five_axis.nose_offset + bodies.spindle_top
    build = build_cylinder if bodies.spindle_is_flat else build_capsule
    return (build("spindle", length, top, bodies.spindle_radius),)


def _select_columns(part: str) -> slice:
    """Which cylinders of :attr:`Moving.parts` are those of a part."""
    first = TOOL_PARTS.index(part)
    return slice(first, None if part == "holder" else first + 1)


def _list_parts_of_shape(shape: ToolShape, holders: int) -> Array:
    """Distances of both ends from the tip, and the largest radius, of every part; NaN as in :class:`Moving`."""
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
