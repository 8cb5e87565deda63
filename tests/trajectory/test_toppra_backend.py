"""Two solvers of one problem: the reachability passes and toppra agree, and toppra's silent failure is heard."""

import re
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from verne_post import Options, convert
from verne_post.base.arrays import Array
from verne_post.config.load import build_machine
from verne_post.model.machine import Limits
from verne_post.output.summary import list_facts
from verne_post.trajectory import reachability, toppra_backend
from verne_post.trajectory.continuous import plan_continuous
from verne_post.trajectory.section_path import Grid, build_grid_along

from ..builders import SAME_PATHS
from .curves import ACCEPTED, Curve, limits, straight, wavy, worst

ROOT = Path(__file__).resolve().parents[2]

#: Where a joint turns back its q' is zero, and its acceleration bounds the speed alone.
TURNING = Curve(40.0, lambda s: [np.sin(s), np.cos(1.3 * s), np.sin(0.7 * s + 1)], elements=40)


@pytest.mark.filterwarnings("ignore")  # of toppra itself
@pytest.mark.parametrize(
    "section",
    [
        straight(30.0),
        straight(30.0, 5.0),
        wavy(40.0, 2.0),
        wavy(40.0, 2.0, 25.0),
        wavy(2.0, 1.0, 900.0),
        TURNING,
    ],
    ids=[
        "line",
        "slow line",
        "waves",
        "waves at a feed",
        "short",
        "joints that turn back",
    ],
)
def test_reachability_and_toppra_agree(section) -> None:  # type: ignore[no-untyped-def]
    grid, top = build_grid_along(section), limits(3)
    ours = reachability.find_duration(grid.s, reachability.solve(grid, top))
    theirs = reachability.find_duration(grid.s, toppra_backend.solve(grid, top))
    # toppra's programs are solved to 1e-6 or so of their scale, which shows where joints turn back on a coarse grid
    assert theirs == pytest.approx(ours, rel=5e-6)


@pytest.mark.filterwarnings("ignore")
def test_no_answer_is_an_error() -> None:
    grid, top = build_grid_along(wavy(40.0, 2.0)), limits(3)
    lost = replace(grid, d2=np.full_like(grid.d2, np.nan))
    with pytest.raises(RuntimeError, match="toppra found no profile"):
        toppra_backend.solve(lost, top)


SAMPLES = sorted(
    setup.stem
    for setup in (ROOT / "gcode_samples").glob("*.toml")
    if not setup.name.startswith("violates") and setup.stem not in SAME_PATHS
)


@pytest.mark.filterwarnings("ignore")  # of toppra itself
@pytest.mark.parametrize(
    ("sample", "solver"),
    [*((sample, "both") for sample in SAMPLES), ("slider_bound.nc", "toppra"), ("wing.cls", "toppra")],
)
def test_without_jerk_limits_samples_take_the_time_of_toppra(
    sample: str, solver: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No more than 0.1 % over toppra's own profiles, one of each section, on the grids that it is given."""
    pytest.importorskip("toppra")
    raw = re.sub(r"(?m)^\w+_jerk = .*$", "", (ROOT / "machine_configs/serial.toml").read_text(encoding="utf-8"))
    machine = build_machine(raw.encode(), "mine.toml")
    solve, theirs = toppra_backend.solve, []

    def record(grid: Grid, limits: Limits, *, start: float) -> Array:
        assert start == 0.0  # the whole section at once
        x = solve(grid, limits)
        theirs.append(reachability.find_duration(grid.s, x))
        return x

    monkeypatch.setattr(toppra_backend, "solve", record)
    summary = convert(ROOT / "gcode_samples" / sample, machine, Options(solver=solver)).summary
    assert summary.second_order_bound_s < summary.continuous_time <= 1.001 * sum(theirs)
    if (
        sample != "blade_5axis.nc"
    ):  # its acceleration switches in every second row; what holds between points of a grid is below
        assert summary.continuous_time <= 1.001 * summary.second_order_bound_s
    if solver == "both":
        assert summary.toppra_bound_s == pytest.approx(summary.second_order_bound_s, rel=1e-5)
    assert ("not limited", machine.unlimited) in list_facts(summary)
    assert not any("jerk " in text for key, text in list_facts(summary) if key == "limits")


@pytest.mark.filterwarnings("ignore")  # of toppra itself
@pytest.mark.parametrize("section", [straight(30.0), wavy(40.0, 2.0), wavy(40.0, 2.0, 25.0), TURNING])
def test_both_solvers_plan_rows_without_jerk_limits(section) -> None:  # type: ignore[no-untyped-def]
    top = limits(3, jerk=np.inf)
    grid = build_grid_along(section)
    theirs = reachability.find_duration(grid.s, toppra_backend.solve(grid, top))
    for solver in (reachability.solve, toppra_backend.solve):
        rows = plan_continuous(section, top, 0.001, solver=solver).s
        # 0.1 per cent, and two cycles for the whole number of them
        assert (len(rows) - 1) * 0.001 <= 1.001 * theirs + 0.002
        assert (worst(section, rows, top, 0.001) <= ACCEPTED).all()
