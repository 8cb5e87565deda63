"""Draw Figs. 5, 6 and 7 of the paper from our own code, and a slice of the workspace.

Run from the repository's root: python docs/pictures/paper_figures.py (needs the docs extra).
"""

import io
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

import verne_post
from verne_post.base.units import DEG_PER_RAD
from verne_post.output.plots import draw_iso_alpha, draw_workspace

FOLDER = Path("docs/pictures")
#: Half length of the platform along x. The paper does not give it, and it does not matter: only differences do.
PLATFORM = 110.0
#: Directions of view: turn about the vertical and elevation.
TURN, ELEVATION = np.radians(-40.0), np.radians(18.0)
LEGS = ("tab:blue", "tab:orange", "tab:green")

machine = verne_post.load_machine()
module = machine.module


def projected(points: np.ndarray) -> np.ndarray:
    """Points of the base frame (..., 3), z down, on the paper (..., 2)."""
    x, y, z = np.moveaxis(points, -1, 0)
    across = x * np.cos(TURN) - y * np.sin(TURN)
    deep = x * np.sin(TURN) + y * np.cos(TURN)
    return np.stack([across, -z * np.cos(ELEVATION) + deep * np.sin(ELEVATION)], axis=-1)


def draw(axes: Any, position: Any, alpha: float, rho: Any, ends: tuple[float, float]) -> None:
    """The module in one pose: guideways, sliders, rods (one for each parallelogram) and platform."""
    p, c, s = np.asarray(position, dtype=float), np.cos(alpha), np.sin(alpha)
    x1, x23 = PLATFORM - module.leg1_x_offset, -PLATFORM - module.leg23_x_offset
    sliders = [(x1, module.r1, rho[0]), (x1, -module.r1, rho[0]), (x23, -module.r4, rho[1]), (x23, module.r4, rho[2])]
    arms = [(PLATFORM, module.R1), (PLATFORM, -module.R1), (-PLATFORM, -module.R2), (-PLATFORM, module.R2)]
    ball = [p + np.array([x, arm * c, arm * s]) for x, arm in arms]
    for x, y in ((x1, 0.0), (x23, -module.r4), (x23, module.r4)):
        way = projected(np.array([(x, y, ends[0]), (x, y, ends[1])]))
        axes.plot(*way.T, color="0.75", linewidth=2.5, solid_capstyle="butt", zorder=1)
    axes.fill(*projected(np.array(ball)).T, facecolor="0.88", edgecolor="0.25", linewidth=0.9, zorder=2)
    axes.plot(*projected(np.array(sliders[:2])).T, color=LEGS[0], linewidth=3.0, zorder=3)
    for slider, end, leg in zip(sliders, ball, (0, 0, 1, 2), strict=True):
        axes.plot(*projected(np.array([slider, end])).T, color=LEGS[leg], linewidth=1.3, zorder=4)
        axes.plot(*projected(np.array(slider)), marker="s", markersize=3.5, color=LEGS[leg], zorder=5)
    axes.plot(*projected(p), marker="o", markersize=3, color="black", zorder=6)
    axes.set_aspect("equal")
    axes.set_axis_off()


def poses_figure(poses: list[tuple[Any, float, Any, str | None, str]], rows: int, columns: int, title: str) -> Figure:
    """Small pictures of several poses: position, tilt, sliders, why refused, what to write over it."""
    heights = np.concatenate([[pose[0][2], *pose[2]] for pose in poses])
    ends = (float(heights.min()) - 100.0, float(heights.max()) + 100.0)
    figure = Figure(figsize=(2.2 * columns, 2.6 * rows), layout="constrained")
    for axes, (position, alpha, rho, refused, text) in zip(figure.subplots(rows, columns).flat, poses, strict=True):
        draw(axes, position, alpha, rho, ends)
        used = refused is None
        axes.set_title(
            text + ("\nin use" if used else ""),
            fontsize=9,
            color="tab:red" if used else "black",
            fontweight="bold" if used else "normal",
        )
    figure.suptitle(title, fontsize=10)
    return figure


def save(figure: Figure, name: str, dpi: int) -> None:
    """A PNG of 256 colours."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi)
    Image.open(buffer).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(FOLDER / name, optimize=True)


save(draw_iso_alpha(machine, module), "fig5_iso_alpha.png", 90)

P = np.array([-240.0, -86.0, 1000.0])
solutions = [
    (
        P,
        one.alpha,
        one.rho,
        one.refused,
        f"alpha {DEG_PER_RAD * one.alpha:.1f} deg\ns = ({', '.join(f'{sign:+d}' for sign in one.signs)})",
    )
    for one in module.inverse_all(P)
]
title = "the 16 inverse solutions at P = (-240, -86, 1000) mm; leg I blue, II orange, III green; z up"
save(poses_figure(solutions, 4, 4, title), "fig6_inverse.png", 80)

RHO = np.array([250.0, 1000.0, 750.0])
modes = [
    (
        one.position,
        one.alpha,
        RHO,
        one.refused,
        f"alpha {DEG_PER_RAD * one.alpha:.1f} deg\nP = ({', '.join(f'{value:.0f}' for value in one.position)})",
    )
    for one in module.forward_all(RHO)
]
title = "the six assembly modes of rho = (250, 1000, 750) mm; leg I blue, II orange, III green; z up"
save(poses_figure(modes, 2, 3, title), "fig7_assembly.png", 95)

figure, _drawn = draw_workspace(machine, "xz", 0.0, np.radians([30.0, 0.0]), 100.0)
figure.savefig(FOLDER / "workspace.png", dpi=90)
