"""Pictures of a machine: slices of its workspace, and curves of equal tilt. Needs matplotlib (extra ``plot``)."""

import io
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.workspace import Reach, classify
from verne_post.model.machine import Machine
from verne_post.model.moves import Frame
from verne_post.model.protocols import IsoAlpha

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Axes of a slice: across, up, and the one held.
PLANES: Final = {"xy": (0, 1, 2), "xz": (0, 2, 1), "yz": (1, 2, 0)}
#: A slice is first looked for this far from the rotary centre, in steps of SEARCH_STEP; mm.
SEARCH: Final = 1500.0
SEARCH_STEP: Final = 50.0
#: Points along each side of the drawn slice.
RESOLUTION: Final = 241
#: Border around the reached region, as a share of it: it shows the limits that end the region.
_BORDER: Final = 0.12
#: Platform tilts that are drawn, as in Fig. 5: steps of pi / 90, rad.
_ALPHAS: Final = np.pi * np.arange(91) / 90

_COLOURS: Final = (
    "#d9d9d9",
    "#f4a582",
    "#92c5de",
    "#f7d38c",
    "#c2a5cf",
    "#a6dba0",
    "#e78ac3",
    "#b3b3b3",
    "#d6a77a",
    "#80cdc1",
    "#fddbc7",
    "#cbd5e8",
    "#e6f598",
    "#fbb4ae",
)


#: Letters of a title that have room beside the colour bar; longer ones are smaller.
_TITLE_LETTERS: Final = 60


class NothingReached(ValueError):
    """No tip of the slice is reached."""


def picture(figure: "Figure", suffix: str) -> bytes:
    """The bytes of a picture; the same figure gives the same bytes."""
    import matplotlib as mpl

    buffer = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "verne-post"}):
        figure.savefig(
            buffer, format=suffix.removeprefix("."), dpi=110, metadata={"Date": None} if suffix == ".svg" else {}
        )
    return buffer.getvalue()


def slice_grid(plane: str, at: float, across: Array, up: Array) -> Array:
    """Tips (len(up) * len(across), 3) of a slice of the part frame, row by row."""
    i, j, k = PLANES[plane]
    tip = np.empty((len(up), len(across), 3))
    tip[..., i], tip[..., j], tip[..., k] = across[None, :], up[:, None], at
    return tip.reshape(-1, 3)


def reach_of_slice(
    machine: Machine, plane: str, at: float, angles: Array, tool_length: float
) -> tuple[Array, Array, Reach]:
    """Classify a plane of the part frame, on a grid that just contains what the machine reaches there.

    Parameters
    ----------
    plane : {"xy", "xz", "yz"}
    at : float
        Coordinate along the third axis, mm.
    angles : ndarray, shape (2,)
        Nominal A and C, workpiece sense, rad.
    tool_length : float
        mm.

    Returns
    -------
    across, up : ndarray, shape (RESOLUTION,)
        Coordinates of the grid, mm.
    Reach
        Of :func:`slice_grid`.

    Raises
    ------
    NothingReached
    """
    to_table = machine.coordinates.part_frame.T
    steps = np.arange(-SEARCH, SEARCH + SEARCH_STEP / 2, SEARCH_STEP)
    rough = classify(machine, slice_grid(plane, at, steps, steps) @ to_table, angles, tool_length)
    rows, columns = np.nonzero(rough.reached.reshape(len(steps), len(steps)))
    if not len(rows):
        raise NothingReached(f"no tip with |{plane[0]}|, |{plane[1]}| up to {SEARCH:g} mm is reached in this plane")
    sides = []
    for index in (columns, rows):
        low, high = steps[index.min()] - SEARCH_STEP, steps[index.max()] + SEARCH_STEP
        border = _BORDER * (high - low)
        sides.append(np.linspace(low - border, high + border, RESOLUTION))
    across, up = sides
    return across, up, classify(machine, slice_grid(plane, at, across, up) @ to_table, angles, tool_length)


def find_reached_plane(machine: Machine, plane: str, angles: Array, tool_length: float) -> float:
    """Coordinate of the slice nearest to the middle of what is reached along the third axis, mm, in whole SEARCH_STEP.

    Raises
    ------
    NothingReached
    """
    steps = np.arange(-SEARCH, SEARCH + SEARCH_STEP / 2, SEARCH_STEP)
    tips = np.concatenate([slice_grid(plane, at, steps, steps) for at in steps]) @ machine.coordinates.part_frame.T
    reached = steps[classify(machine, tips, angles, tool_length).reached.reshape(len(steps), -1).any(axis=1)]
    if not len(reached):
        raise NothingReached(f"no tip with |x|, |y|, |z| up to {SEARCH:g} mm is reached with these angles")
    return float(reached[np.abs(reached - (reached[0] + reached[-1]) / 2).argmin()])


def draw_workspace(
    machine: Machine, plane: str, at: float, angles: Array, tool_length: float
) -> tuple["Figure", tuple[Array, Array, Reach]]:
    """Draw a slice of the workspace; see :func:`reach_of_slice`, whose answer comes with it."""
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    across, up, reach = reach_of_slice(machine, plane, at, angles, tool_length)
    shape = (len(up), len(across))
    broken = reach.broken.reshape(shape)
    margin = np.ma.masked_where(broken >= 0, reach.margin.reshape(shape))
    step = ((across[1] - across[0]) / 2, (up[1] - up[0]) / 2)
    extent = (across[0] - step[0], across[-1] + step[0], up[0] - step[1], up[-1] + step[1])
    figure = Figure(figsize=(min(1.9 + 5.0 * np.ptp(across) / np.ptp(up), 14.0), 6.6), layout="constrained")
    axes = figure.add_subplot()
    present = [int(limit) for limit in np.unique(broken) if limit >= 0]
    colours = [_COLOURS[index % len(_COLOURS)] for index in range(len(reach.limits))]
    if present:
        axes.imshow(
            np.ma.masked_less(broken, 0),
            origin="lower",
            extent=extent,
            interpolation="nearest",
            cmap=ListedColormap(colours),
            norm=BoundaryNorm(np.arange(len(colours) + 1) - 0.5, len(colours)),
        )
    image = axes.imshow(margin, origin="lower", extent=extent, interpolation="nearest", cmap="viridis", vmin=0.0)
    figure.colorbar(image, ax=axes, label="reached: smallest margin of travel or rod drop, mm")
    axes.contour(across, up, broken < 0, levels=[0.5], colors="black", linewidths=0.9)
    _draw_table(axes, machine, plane, at)
    i, j, k = PLANES[plane]
    where = "on the table" if machine.table_radius else "of the part"
    axes.set(xlabel=f"{'xyz'[i]} {where}, mm", ylabel=f"{'xyz'[j]} {where}, mm", aspect="equal")
    axes.set_xlim(extent[0], extent[1])
    axes.set_ylim(extent[2], extent[3])
    program = machine.coordinates.map_from_table(np.zeros(3), angles, Frame())
    tilt, turn = (
        f"{letter}{round(float(program[axis]), 9) + 0.0:g}"
        for letter, axis in zip(machine.rotary_letters, machine.coordinates.rotary, strict=True)
    )
    title = f"{machine.name}: tips reached, tool {tool_length:g} mm, {tilt} {turn}, {'xyz'[k]} = {at:g} mm"
    axes.set_title(title, fontsize=min(11.0, 11.0 * _TITLE_LETTERS / len(title)), parse_math=False)
    handles = [Patch(facecolor=colours[limit], label=reach.limits[limit]) for limit in present]
    if handles:
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=3 if np.ptp(across) > np.ptp(up) else 2,
            fontsize=8,
            frameon=False,
            title="outside, by the limit that is broken most",
            title_fontsize=8,
        )
    return figure, (across, up, reach)


def _draw_table(axes: Any, machine: Machine, plane: str, at: float) -> None:
    """Outline of the table face where the slice meets it or looks at it from above."""
    from matplotlib.patches import Circle

    radius = machine.table_radius
    if not radius:
        return
    if plane == "xy":
        axes.add_patch(Circle((0, 0), radius, fill=False, color="white", linestyle="--", linewidth=1.2))
    elif abs(at) < radius:
        half = float(np.sqrt(radius**2 - at**2))
        axes.plot([-half, half], [0, 0], color="white", linestyle="--", linewidth=1.5)


def draw_iso_alpha(machine: Machine, module: IsoAlpha) -> "Figure":
    """Curves on which the platform tilts alike: the ellipses (8), Fig. 5 of the paper.

    Every point lies on two of them. They grow with the tilt up to the one that is drawn in both panels, a circle on the
    VERNE, where R1 cos(alpha) = r1, and shrink beyond.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    turn = np.linspace(0.0, 2 * np.pi, 181)
    curves = [module.trace_iso_alpha(float(alpha), turn) for alpha in _ALPHAS]
    highest = int(np.nanargmax([np.ptp(curve[:, 1]) for curve in curves]))
    figure = Figure(figsize=(9.6, 5.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    norm = Normalize(0.0, 180.0)
    for axes, family in ((left, slice(0, highest + 1)), (right, slice(highest, None))):
        for alpha, curve in zip(_ALPHAS[family], curves[family], strict=True):
            axes.plot(*curve.T, color=colormaps["turbo"](norm(DEG_PER_RAD * alpha)), linewidth=0.6)
        first, last = (DEG_PER_RAD * _ALPHAS[family][index] for index in (0, -1))
        axes.set_title(f"|alpha| {first:.0f} to {last:.0f} degrees", fontsize=10)
        axes.set(xlabel="x of P, mm (base frame)", aspect="equal")
    left.set_ylabel("y of P, mm")
    figure.suptitle(
        f"{machine.name}: where the platform may tilt by alpha, every 2 degrees", fontsize=11, parse_math=False
    )
    figure.colorbar(
        ScalarMappable(norm, "turbo"), ax=right, label="|alpha|, degrees", ticks=np.arange(0, 181, 30), shrink=0.8
    )
    return figure


def describe_slice(plane: str, across: Array, up: Array, reach: Reach) -> str:
    """One sentence about a slice: how far it reaches, and what ends it."""
    inside = reach.reached.reshape(len(up), len(across))
    rows, columns = np.nonzero(inside)
    # limits that stand next to a tip that is reached
    beside = np.zeros_like(inside)
    beside[1:] |= inside[:-1]
    beside[:-1] |= inside[1:]
    beside[:, 1:] |= inside[:, :-1]
    beside[:, :-1] |= inside[:, 1:]
    ends = np.unique(reach.broken.reshape(inside.shape)[beside & ~inside])
    names = ", ".join(reach.limits[index] for index in ends)
    return (
        f"reached: {plane[0]} from {across[columns.min()]:.0f} to {across[columns.max()]:.0f} mm, "
        f"{plane[1]} from {up[rows.min()]:.0f} to {up[rows.max()]:.0f} mm; ended by: {names}"
    )
