"""Make a part in a vise: ``python gcode_samples/make_vise_sample.py FOLDER`` writes a program, its set-up, tools, and
three STL files.

vise.nc faces a block, mills a step around it above the jaws of the vise, and a pocket between them. vise.stl stands on
the table; stock.stl and part.stl, the part as it should be, are in G54.
"""

import itertools
import struct
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

#: Lower and upper corners of boxes, mm; z = 0 is the top of the part, 70 mm over the table.
Boxes = Sequence[tuple[tuple[float, float, float], tuple[float, float, float]]]
BASE, JAWS = (
    ((-55.0, -65.0, 0.0), (55.0, 65.0, 40.0)),
    (((-50.0, -60.0, 40.0), (50.0, -20.0, 62.0)), ((-50.0, 20.0, 40.0), (50.0, 60.0, 62.0))),
)
STOP = ((20.0, 32.0, 62.0), (40.0, 60.0, 84.0))
STOCK = ((-40.0, -20.0, -30.0), (40.0, 20.0, 1.0))
#: Half sizes of the part below the step, above it, and of the pocket, whose corners have the radius of the tool.
LOWER, STEP, POCKET, CORNER = (40.0, 20.0), (38.0, 18.0), (15.0, 8.0), 3.0

PROGRAM = """%
(A block in a vise: face, step, pocket)
G21 G90 G17 G40 G54 G94
T1 M6
S6000 M3
G43 H1
G0 X-50 Y-13.5 Z20
Z0
G1 X50 F1500
Y-4.5
X-50
Y4.5
X50
Y13.5
X-50
G0 Z5
X-50 Y-23
Z-6
G1 X43 F1500
Y23
X-43
Y-23
G0 Z20
T2 M6 S4000 M3
G43 H2
G0 X0 Y0
Z2
G1 X12 Z-4 F400
X-12 Z-12
X12
Y5
X-12
Y-5
X12
Y5
X0 Y0
G0 Z20
M2
%
"""
TOOLS = "T1 P1 Z100 D10\nT2 P2 Z90 D6\n"
SHAPES = """[tool.1]
cutter = { diameter = 10.0, length = 20.0 }
shank = { diameter = 10.0, length = 10.0 }
holder = [{ diameter = 40.0, length = 20.0 }, { diameter = 50.0 }]

[tool.2]
cutter = { diameter = 6.0, length = 14.0 }
shank = { diameter = 6.0, length = 14.0 }
holder = { profile = [[10.0, 0.0], [16.0, 15.0], [16.0, 62.0]] }
"""
SETUP = """tool_table = "tools.tbl"
tool_shapes = "shapes.toml"
split_at_stops = true

[wcs]
G54 = [0.0, 0.0, 70.0]

[keep_out.vise]
file = "vise.stl"

[stock]
min = [-40.0, -20.0, -30.0]
max = [40.0, 20.0, 1.0]
system = "G54"

[part]
nominal = "part.stl"
system = "G54"
grid_mm = 1.0
"""


def unite_boxes(boxes: Boxes) -> np.ndarray:
    """Facets (m, 3, 3) of the surface of boxes together, counter-clockwise from outside."""
    corner = np.array(boxes)
    grid = [np.unique(corner[:, :, k]) for k in range(3)]
    middle = np.stack(np.meshgrid(*(0.5 * (one[1:] + one[:-1]) for one in grid), indexing="ij"), axis=-1)
    full = np.zeros(middle.shape[:3], dtype=bool)
    for low, high in corner:
        full |= ((middle > low) & (middle < high)).all(axis=-1)
    facets = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        change = np.diff(np.moveaxis(np.pad(full, 1), k, 0).astype(int), axis=0)
        for place in np.argwhere(change):
            cell = np.insert(place[1:], k, place[0]) - 1  # the one before the face; padding counts from -1
            square = np.empty((4, 3))
            square[:, k] = grid[k][cell[k] + 1]
            square[:, i] = grid[i][cell[i] + np.array([0, 1, 1, 0])]
            square[:, j] = grid[j][cell[j] + np.array([0, 0, 1, 1])]
            if change[tuple(place)] > 0:  # the body lies beyond the face
                square = square[::-1]
            facets += [square[[0, 1, 2]], square[[0, 2, 3]]]
    return np.array(facets)


def make_part() -> np.ndarray:
    """Facets (m, 3, 3) of the part: strips between outlines that have their points in the same directions from the
    middle.
    """
    turns = np.radians(np.arange(0.0, 91.0, 7.5))
    arcs = [
        (np.array(POCKET) - CORNER) * sign
        + CORNER * np.stack([np.cos(turns + k * np.pi / 2), np.sin(turns + k * np.pi / 2)], axis=1)
        for k, sign in enumerate(([1, 1], [-1, 1], [-1, -1], [1, -1]))
    ]
    pocket = np.concatenate(arcs)
    corners = [np.array(half) * sign for half in (LOWER, STEP) for sign in ([1, 1], [-1, 1], [-1, -1], [1, -1])]
    angle = np.unique(np.arctan2(*np.concatenate([pocket, corners]).T[::-1]).round(12))
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def outline(polygon: np.ndarray, z: float) -> np.ndarray:
        edge = np.roll(polygon, -1, axis=0) - polygon
        normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1)
        reach = direction @ normal.T
        far = np.where(reach > 0, (normal * polygon).sum(axis=1) / np.where(reach > 0, reach, 1.0), np.inf).min(axis=1)
        return np.column_stack([far[:, None] * direction, np.full(len(angle), z)])

    lower, step = np.array(corners[:4]), np.array(corners[4:])
    levels = [
        outline(pocket, -12.0) * [0, 0, 1],
        outline(pocket, -12.0),
        outline(pocket, 0.0),
        outline(step, 0.0),
        outline(step, -6.0),
        outline(lower, -6.0),
        outline(lower, -30.0),
        outline(lower, -30.0) * [0, 0, 1],
    ]
    facets = []
    for inner, outer in itertools.pairwise(levels):
        a, b, c, d = inner, outer, np.roll(outer, -1, axis=0), np.roll(inner, -1, axis=0)
        facets += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    facet = np.concatenate(facets)
    return facet[np.linalg.norm(np.cross(facet[:, 1] - facet[:, 0], facet[:, 2] - facet[:, 0]), axis=1) > 1e-9]


def pack_stl(facets: np.ndarray) -> bytes:
    """A binary STL."""
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *one.ravel(), 0) for one in facets)
    return b"made by make_vise_sample.py".ljust(80) + struct.pack("<I", len(facets)) + rows


def main(folder: Path) -> None:
    """Write all files, into a folder that is made where it is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, facets in (
        ("vise", unite_boxes([BASE, *JAWS, STOP])),
        ("stock", unite_boxes([STOCK])),
        ("part", make_part()),
    ):
        (folder / f"{name}.stl").write_bytes(pack_stl(facets))
    for name, text in (("vise.nc", PROGRAM), ("vise.nc.toml", SETUP), ("tools.tbl", TOOLS), ("shapes.toml", SHAPES)):
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
