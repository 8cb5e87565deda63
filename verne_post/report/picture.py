"""The report as a picture: path, positions and shares of the limits. Needs matplotlib (extra ``plot``)."""

from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.printable import make_printable
from verne_post.model.machine import Machine
from verne_post.output.findings import format_outcome
from verne_post.output.plots import picture
from verne_post.report.table import Study
from verne_post.report.worst import iterate_shares

_SIZE: Final = (11.0, 8.0)
#: Width of a curve, in points; the curve of another joint below it is wider by a step, so that both show where they are
#: equal. All steps together are no wider than the last of these.
_WIDTH: Final = 0.6
_STEP: Final = 0.8
_STEPS: Final = 2.4
#: Beside the panel: in it, a legend hides curves.
_LEGEND: Final = {"fontsize": 7, "loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}


def picture_of(program: str, machine: Machine, study: Study, suffix: str) -> bytes:
    """The bytes of the picture; the same study gives the same bytes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, layout="constrained")
    verdict = format_outcome("", study.findings).removeprefix(": ")
    # a name is no formula, whatever dollars are in it
    figure.suptitle(f"{make_printable(program)} on {machine.name}: {verdict}", fontsize=11, parse_math=False)
    names = ["velocity", "acceleration", "jerk"] if study.timed else []
    grid = figure.add_gridspec(2 + len(names), 2, width_ratios=[1.1, 1.0])
    plan = figure.add_subplot(grid[:, 0])
    if len(study.x):
        x, y, _z = study.trail.tip.T
        margin = np.nan_to_num(study.trail.margin, nan=-1.0)
        dots = plan.scatter(x, y, c=margin, s=2, cmap="RdYlGn", vmin=0.0, vmax=1.0)
        figure.colorbar(dots, ax=plan, label="margin: 0 at a limit, 1 plenty", shrink=0.6)
        plan.plot(*find_violations(study)[:, :2].T, "x", color="#c0392b", ms=3)
        framed = np.concatenate([study.trail.framed, find_violations(study)])[:, :2]
        low, high = np.nanmin(framed, axis=0), np.nanmax(framed, axis=0)
        border = max(0.05 * float((high - low).max()), 1.0)
        plan.set(xlim=(low[0] - border, high[0] + border), ylim=(low[1] - border, high[1] + border))
    plan.set_aspect("equal")
    plan.set_xlabel("x mm on the table")
    plan.set_ylabel("y mm")
    n = len(machine.columns)
    for row, joints in enumerate((range(n - 2), range(n - 2, n))):
        axes = figure.add_subplot(grid[row, 1])
        curves = [study.curves["position"][joint] for joint in joints]
        _plot_joints(axes, machine, joints, [(curve.x, curve.values) for curve in curves])
        axes.set_ylabel(f"position {machine.columns[joints[0]].unit}", fontsize=7)
    for row, name in enumerate(names, start=2):
        axes = figure.add_subplot(grid[row, 1])
        _plot_joints(axes, machine, range(n), iterate_shares(machine, study, name))
        axes.axhspan(-100, 100, color="#27ae60", alpha=0.08)
        axes.set_ylabel(f"{name} %", fontsize=7)
    figure.axes[-1].set_xlabel("time, s" if study.timed else "path, mm")
    return picture(figure, suffix)


def _plot_joints(axes: Any, machine: Machine, joints: range, curves: Iterable[tuple[Array, Array]]) -> None:
    """Draw a curve of each joint, with a legend; where two are equal, both are seen."""
    step = min(_STEP, _STEPS / len(joints))
    for above, joint, (x, values) in zip(range(len(joints))[::-1], joints, curves, strict=True):
        axes.plot(x, values, lw=_WIDTH + above * step, color=f"C{joint}", label=machine.columns[joint].joint)
    axes.legend(**_LEGEND)
    axes.tick_params(labelsize=7)


def find_violations(study: Study) -> Array:
    """Tips (n, 3) in violation, and those of the worst point of every error."""
    worst = [item.severity == "error" and place >= 0 for item, place in zip(study.findings, study.place, strict=True)]
    return np.concatenate([study.trail.tip[study.trail.bad], study.place_tip[np.array(worst, dtype=bool)]])
