"""Two solvers of one problem: the reachability passes and toppra agree, and toppra's silent failure is heard."""

import re
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from verne_post import Options, convert
from verne_post.config.load import build_machine
from verne_post.output.summary import list_facts
from verne_post.trajectory import reachability, toppra_backend
from verne_post.trajectory.continuous import plan_continuous
from verne_post.trajectory.section_path import build_grid_along

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


SHORT = [
    "blade_5axis.nc", "fanuc_nurbs.nc", "fanuc_tilted.nc", "inch.nc", "inverse_time.nc", "posted.nc", "slider_bound.nc", "wing.cls",
]  # fmt: skip


@pytest.mark.filterwarnings("ignore")  # of toppra itself
@pytest.mark.parametrize("sample", SHORT)
def test_without_jerk_limits_samples_take_the_time_that_toppra_finds(sample: str) -> None:
    """Rows come 0.1 % after the bound of both solvers, or a whole cycle or two for each of three sections."""
    pytest.importorskip("toppra")
    raw = re.sub(r"(?m)^\w+_jerk = .*$", "", (ROOT / "machine_configs/serial.toml").read_text(encoding="utf-8"))
    machine = build_machine(raw.encode(), "mine.toml")
    summary = convert(ROOT / "gcode_samples" / sample, machine, Options(solver="both")).summary
    bound, theirs = summary.second_order_bound_s, summary.toppra_bound_s
    assert theirs == pytest.approx(bound, rel=1e-5)
    # the bound is that of a grid: on the blade, whose acceleration switches in every second row, a fine one says 0.18 % more
    share = 0.002 if sample == "blade_5axis.nc" else 0.001
    assert bound < summary.continuous_time <= theirs + max(share * theirs, 0.004)
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
