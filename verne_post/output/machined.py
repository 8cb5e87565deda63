"""What rows leave of a part: a summary, a table of the worst places, a PLY file and a picture of the deviations."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.numbers import format_count
from verne_post.model.part_setup import GRID_MM
from verne_post.output.plots import picture
from verne_post.part.compare import GOUGE, UNDECIDED, measure_areas
from verne_post.part.verdict import Judged, Machined, describe_other_depth, describe_place

#: Deviations beyond this many times what is asked for have the full colour.
_FULL: Final = 2.0
#: Colours: within tolerance, full gouge, full excess, no cutter near, not decided.
_FINE, _CUT, _LEFT, _UNTOUCHED, _OPEN = np.array(
    [[190, 190, 190], [200, 20, 20], [30, 60, 210], [120, 110, 100], [230, 200, 40]], dtype=float
)
#: Every gouge ranks before every excess, whose shares are smaller.
_GOUGED: Final = 1e6
#: Rows of the table of worst places.
WORST: Final = 200
#: A picture has no more triangles than this: the worst of each group are drawn.
_MOST_DRAWN: Final = 40_000


def describe_comparisons(name: str, machined: Machined) -> str:
    """The summary of a comparison, line by line."""
    lines = []
    if machined.judged:
        first, motions = machined.judged[0].comparison, machined.judged[0].motions
        rows, tools = sum(len(one.tip) for one in motions), ", ".join(one.name for one in motions)
        lines.append(
            f"{name}: {rows} poses of {tools} against {first.mesh.name}: {len(first.state)} facets, "
            f"{len(first.cells.facet)} sample places, at most {first.grid:g} mm from any point of the surface"
        )
        lines += [f"  {note}" for note in machined.notes]
        lines += [f"  {text}" for text in describe_judged(machined)]
        lines.append(
            f"  the verdict is about the facets of {first.mesh.name}; their distance from the true surface adds to it"
        )
    for touched in machined.contacts:
        count = len(np.unique(np.concatenate([one.line for one in touched.found]))) if touched.found else 0
        verdict = (
            f"nearer than {touched.allowed:g} mm in {format_count(count, 'line')}"
            if count
            else f"never nearer than {touched.allowed:g} mm"
        )
        lines.append(
            f"{name}: {touched.mesh.name}, {len(touched.mesh.facets)} facets: {verdict}; nearest place seen "
            f"{touched.least:.3f} mm"
        )
    return "\n".join(lines) + "\n"


def describe_judged(machined: Machined) -> list[str]:
    """Each comparison in a sentence."""
    lines = [f"{_describe_one(one)}{' (counts)' if k == 0 else ''}" for k, one in enumerate(machined.judged)]
    if machined.judged and (first := machined.judged[0].comparison).wanted.grid is None and first.grid > GRID_MM:
        lines.append(
            f"NOT CHECKED: excess between places that are {first.grid:g} mm apart; on this part a grid of "
            f"{GRID_MM:g} mm has too many places"
        )
    if machined.rests is not None:
        allowed = machined.judged[0].comparison.wanted.excess
        volume = sum(one.volume for one in machined.rests)
        what = f"{volume:.1f} mm3 stay" if volume else "nothing stays"
        lines.append(f"stock: {what} farther than {allowed:g} mm from the part")
    return lines


def _describe_one(judged: Judged) -> str:
    """One comparison in a line."""
    found = judged.comparison
    place = (
        "where the set-up puts the part"
        if judged.datum == "table"
        else f"moved to the best fit, by at most {judged.shift:.3f} mm"
    )
    parts = []
    if len(found.gouges.depth):
        worst = int(found.gouges.shortest.argmax())
        along = describe_other_depth(judged, worst)
        parts.append(
            f"gouged {found.gouges.shortest[worst]:.3f} mm deep at {describe_place(found.gouges.place[worst])}"
            f"{f' ({along})' * bool(along)}, {int((found.state == GOUGE).sum())} facets"
        )
    if undecided := int((found.state == UNDECIDED).sum()):
        parts.append(
            f"{undecided} facets not decided (none gouged deeper than "
            f"{found.deepest[found.state == UNDECIDED].max():.3f} mm)"
        )
    if not parts:
        parts.append(f"clear of gouges deeper than {found.wanted.gouge:g} mm")
    touched = found.deviation[np.isfinite(found.deviation)]
    if len(touched):
        parts.append(f"at most {max(float(touched.max()), 0.0):.4f} mm of excess")
    area = measure_areas(found.cells.corner)
    far = float(area[np.isnan(found.deviation)].sum() / area.sum())
    if far > 0:
        parts.append(f"over {100 * far:.1f} % of the surface no cutter comes within {found.wanted.search:g} mm")
    return f"{judged.machine} machine, part {place}: {'; '.join(parts)}"


def list_worst(judged: Judged) -> str:
    """The places (CSV) that are worst: gouges, by the shortest way out, then excess; mm, in the system of the part."""
    found, motions = judged.comparison, judged.motions
    rows = ["x_mm,y_mm,z_mm,deviation_mm,line,tool,body,facet,along_normal_mm"]
    high = np.flatnonzero(np.nan_to_num(found.deviation, nan=0.0) > found.wanted.excess)
    kinds = (
        (
            found.gouges.place,
            -found.gouges.shortest,
            -found.gouges.depth,
            found.gouges.nearest,
            found.gouges.facet,
        ),
        (
            found.cells.corner[high].mean(axis=1),
            found.deviation[high],
            found.deviation[high],
            found.nearest.select(high),
            found.cells.facet[high],
        ),
    )
    for place, deviation, along, nearest, facet in kinds:
        for k in np.argsort(-np.abs(deviation), kind="stable")[:WORST].tolist():
            motion = motions[nearest.motion[k]]
            x, y, z = place[k]
            body = motion.pieces[nearest.piece[k]].part
            rows.append(
                f"{x:.4f},{y:.4f},{z:.4f},{deviation[k]:.4f},"
                f"{motion.line[nearest.row[k]]},{motion.name},{body},{facet[k]},{along[k]:.4f}"
            )
    return "\n".join(rows) + "\n"


def measure_harm(judged: Judged) -> Array:
    """How bad the cells (n,) are, in this order: gouges, excess, undecided ones, good ones, untouched ones."""
    found = judged.comparison
    share = _find_share(judged)
    rank = share + _GOUGED * ((found.deviation < 0) & (share > 1.0))
    rank = np.where((found.state == UNDECIDED)[found.cells.facet], np.maximum(rank, 1.0), rank)
    return np.where(np.isnan(found.deviation), -1.0, rank)


def _find_share(judged: Judged) -> Array:
    """Deviations (n,) as shares of what is asked for."""
    value = np.nan_to_num(judged.comparison.deviation, nan=0.0)
    wanted = judged.comparison.wanted
    return np.abs(value) / np.where(value < 0, wanted.gouge, wanted.excess)


def paint_cells(judged: Judged) -> Array:
    """Colours (n, 3) of cells, 0 to 255: grey good, red cut into, blue left, brown untouched, yellow undecided."""
    found = judged.comparison
    share = np.clip((_find_share(judged) - 1.0) / (_FULL - 1.0), 0.0, 1.0)[:, None]
    shade = np.where(share > 0, 0.3 + 0.7 * share, 0.0)
    colour = (1.0 - shade) * _FINE + shade * np.where(found.deviation[:, None] < 0, _CUT, _LEFT)
    colour[np.isnan(found.deviation)] = _UNTOUCHED
    colour[(found.state == UNDECIDED)[found.cells.facet] & (share[:, 0] == 0)] = _OPEN
    return colour


def encode_ply(judged: Judged) -> bytes:
    """The cells as triangles with a colour and a deviation each (binary PLY)."""
    found = judged.comparison
    count = len(found.cells.facet)
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment deviation along the normal in mm: below 0 cut "
        "into, above 0 left; nan untouched\n"
        f"element vertex {3 * count}\nproperty float x\nproperty float y\nproperty float z\nelement face {count}\n"
        "property list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property float deviation\nend_header\n"
    )
    faces = np.zeros(count, dtype=[("n", "u1"), ("vertex", "<i4", 3), ("colour", "u1", 3), ("deviation", "<f4")])
    faces["n"], faces["vertex"] = 3, np.arange(3 * count).reshape(-1, 3)
    faces["colour"], faces["deviation"] = np.rint(paint_cells(judged)), found.deviation
    return header.encode() + found.cells.corner.astype("<f4").tobytes() + faces.tobytes()


def draw_map(judged: Judged, suffix: str) -> bytes:
    """A picture of the part from two sides with its deviations. Needs matplotlib (extra ``plot``)."""
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    found = judged.comparison
    chosen = _choose_drawn(measure_harm(judged))
    corner, colour = found.cells.corner[chosen], paint_cells(judged)[chosen] / 255.0
    low, high = found.cells.corner.min(axis=(0, 1)), found.cells.corner.max(axis=(0, 1))
    figure = Figure(figsize=(11, 5.5))
    for k, (elevation, turn) in enumerate(((35, -60), (20, 120))):
        axes = figure.add_subplot(1, 2, k + 1, projection="3d")
        axes.add_collection3d(Poly3DCollection(corner, facecolors=colour, edgecolors=colour, linewidths=0.2))
        for letter, a, b in zip("xyz", low, high, strict=True):
            middle, half = 0.5 * (a + b), 0.5 * max(float((high - low).max()), 1.0)
            getattr(axes, f"set_{letter}lim")(middle - half, middle + half)
            getattr(axes, f"set_{letter}label")(letter)
        axes.view_init(elev=elevation, azim=turn)
    wanted = found.wanted
    figure.suptitle(
        f"{found.mesh.name}, {judged.machine} machine: red cut deeper than {wanted.gouge:g} mm, blue more than "
        f"{wanted.excess:g} mm left, brown untouched, yellow not decided",
        fontsize=9,
    )
    return picture(figure, suffix)


def _choose_drawn(rank: Array) -> Ints:
    """Cells that are drawn: all, or of each group of neighbours the worst."""
    step = -(-len(rank) // _MOST_DRAWN)
    if step == 1:
        return np.arange(len(rank))
    padded = np.append(rank, np.full(-len(rank) % step, -np.inf)).reshape(-1, step)
    return np.arange(len(padded)) * step + padded.argmax(axis=1)
