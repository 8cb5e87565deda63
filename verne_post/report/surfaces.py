"""Meshes of the scene: fixtures, the nominal part with deviations, and the stock left, as finely as a screen shows."""

from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.app.machined import place_on_table
from verne_post.base.arrays import Array, Ints
from verne_post.base.rotations import rotate_z
from verne_post.output.machined import measure_harm, paint_cells
from verne_post.part.compare import Cells, divide
from verne_post.part.verdict import Judged
from verne_post.report.pack import Pack

#: Vertices of all fixtures together: a screen shows no more, and the page stays small.
FIXTURE_VERTICES: Final = 24_000
#: Triangles of the nominal part: half as many vertices.
PART_FACETS: Final = 50_000
#: Places of a vertex along each side of its surface: the largest number of two bytes.
_PLACES: Final = 65_535
#: How much coarser the next attempt is, where a surface has too many vertices or triangles.
_COARSER: Final = 1.3
#: Deviations of the page have these steps, mm.
_STEP_MM: Final = 1e-4
#: Frames on another line are farther than any on the same one: mm a line.
_OTHER_LINE: Final = 1e5


class Deviation(Struct, frozen=True, eq=False):
    """What is known of the triangles (m,) of a part."""

    colour: Array  #: (m, 3): 0 to 255.
    value: Array  #: (m,): mm, along the normal: below 0 a cut into the part; NaN: no cutter comes near.
    line: Ints  #: (m,): Where the tool comes nearest; 0: nowhere.
    tip: Array  #: (m, 3): The tip there, table frame.


class Surface(Struct, frozen=True, eq=False):
    """Triangles on the table."""

    name: str
    kind: str  #: {"fixture", "stock", "part", "left"}
    vertices: Array  #: (n, 3): mm, about ``middle``.
    facets: Ints  #: (m, 3)
    middle: Array  #: (3,): mm, table frame.
    turn: float  #: About the table's normal, rad.
    deviation: Deviation | None = None  #: Of a part.

    def turn_to_part(self, part: Array, turn: float) -> "Surface":
        """The same in directions of the part; ``part`` (3, 3) leads there from the table frame, ``turn`` is there."""
        deviation = self.deviation
        if deviation is not None:
            deviation = replace(deviation, tip=deviation.tip @ part)
        return replace(self, middle=self.middle @ part, turn=turn, deviation=deviation)


def find_frames(frame_tip: Array, frame_line: Ints, tip: Array, line: Ints) -> Ints:
    """The frames (k,) nearest to tips (k, 3), on their lines (k,) where these have frames; -1 without any frame."""
    from scipy.spatial import cKDTree

    there = np.flatnonzero(np.isfinite(frame_tip).all(axis=1))
    if not len(there):
        return np.full(len(tip), -1)
    tree = cKDTree(np.column_stack([frame_tip[there], _OTHER_LINE * frame_line[there]]))
    return there[tree.query(np.column_stack([tip, _OTHER_LINE * line]))[1]]


def make_part(program: Program, judged: Judged) -> Surface:
    """The nominal part where it stands: each triangle has the worst of what was found in it."""
    part, found = program.options.part, judged.comparison
    assert part is not None
    origin, turn = place_on_table(program, found.mesh.name, part.system)
    cells, worst = _choose_cells(judged)
    line, tip = np.zeros(len(worst), dtype=np.int64), np.zeros((len(worst), 3))
    nearest = found.nearest.select(worst)
    for m, motion in enumerate(judged.motions):
        own = np.flatnonzero((nearest.motion == m) & (nearest.row >= 0))
        line[own], tip[own] = motion.line[nearest.row[own]], motion.tip[nearest.row[own]]
    vertices, facets = np.unique(cells.corner.reshape(-1, 3).round(6), axis=0, return_inverse=True)
    deviation = Deviation(paint_cells(judged)[worst], found.deviation[worst], line, rotate_z(tip, turn) + origin)
    return Surface(found.mesh.name, "part", vertices, facets.reshape(-1, 3), origin, turn, deviation)


def _choose_cells(judged: Judged) -> tuple[Cells, Ints]:
    """Cells of the part, not more than a page takes, and for each the worst cell of the comparison in it."""
    from scipy.spatial import cKDTree

    found = judged.comparison
    cells, grid, size = found.cells, found.grid, float(np.ptp(found.mesh.vertices, axis=0).max())
    if len(cells.facet) <= PART_FACETS:
        return cells, np.arange(len(cells.facet))
    while len(cells.facet) > PART_FACETS and grid < size:
        grid *= _COARSER
        cells = divide(found.mesh, grid)
    corner = cells.corner
    if len(corner) > PART_FACETS:
        vertices, facets = thin_surface(found.mesh.vertices, found.mesh.facets, PART_FACETS // 2)
        corner = vertices[facets]

    def describe(triangle: Array) -> Array:  # the two sides of a thin wall are far from each other
        normal = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
        return np.hstack(
            [triangle.mean(axis=1), grid * normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]]
        )

    fine, coarse = describe(found.cells.corner), describe(corner)
    owner = cKDTree(coarse).query(fine)[1]
    worst = np.asarray(cKDTree(fine).query(coarse)[1])
    order = np.lexsort((measure_harm(judged), owner))
    last = order[np.append(owner[order][1:] != owner[order][:-1], True)]
    worst[owner[last]] = last
    return Cells(corner, found.cells.facet[worst]), worst


def thin_surface(vertices: Array, facets: Ints, most: int) -> tuple[Array, Ints]:
    """A surface of at most ``most`` vertices: near ones merge, moved no farther than needed; flat facets go."""
    low = vertices.min(axis=0)
    step = max(float(np.ptp(vertices, axis=0).max()), 1e-9) / _PLACES
    while True:
        place, first, of = np.unique(
            np.rint((vertices - low) / step).astype(np.int64), axis=0, return_index=True, return_inverse=True
        )
        if len(place) <= most:
            break
        step *= max(_COARSER, np.sqrt(len(place) / most) / _COARSER)
    merged = of.reshape(-1)[facets]
    kept = (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2]) & (merged[:, 2] != merged[:, 0])
    return vertices[first], merged[kept]


def pack_surfaces(pack: Pack, surfaces: list[Surface], frame_tip: Array, frame_line: Ints) -> list[dict[str, Any]]:
    """Pack surfaces as ``surface.K.vertex``, ``surface.K.facet`` and so on; returns what else the script needs."""
    described = []
    for k, one in enumerate(surfaces):
        low = one.vertices.min(axis=0)
        step = max(float(np.ptp(one.vertices, axis=0).max()), 1e-9) / _PLACES
        pack.add(f"surface.{k}.vertex", np.rint((one.vertices - low) / step), "<u2")
        pack.add(f"surface.{k}.facet", one.facets, "<u4")
        if (of := one.deviation) is not None:
            pack.add(f"surface.{k}.colour", np.rint(of.colour), "|u1")
            pack.add(f"surface.{k}.value", np.rint(of.value / _STEP_MM) * _STEP_MM)
            frame = np.where(of.line > 0, find_frames(frame_tip, frame_line, of.tip, of.line), -1)
            pack.add(f"surface.{k}.frame", frame, "<i4")
        described.append(
            {
                "name": one.name,
                "kind": one.kind,
                "low": low.tolist(),
                "step": step,
                "middle": one.middle.tolist(),
                "turn": one.turn,
            }
        )
    return described
