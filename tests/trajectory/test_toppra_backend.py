"""Two solvers of one problem: the reachability passes and toppra agree, and toppra's silent failure is heard."""

import numpy as np
import pytest
from msgspec.structs import replace

from verne_post.trajectory import reachability, toppra_backend
from verne_post.trajectory.section_path import grid_along

from .curves import Curve, limits, straight, wavy

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
    grid, top = grid_along(section), limits(3)
    ours = reachability.duration(grid.s, reachability.solve(grid, top))
    theirs = reachability.duration(grid.s, toppra_backend.solve(grid, top))
    # toppra's programs are solved to 1e-6 or so of their scale, which shows where joints turn back on a coarse grid
    assert theirs == pytest.approx(ours, rel=5e-6)


@pytest.mark.filterwarnings("ignore")
def test_no_answer_is_an_error() -> None:
    grid, top = grid_along(wavy(40.0, 2.0)), limits(3)
    lost = replace(grid, d2=np.full_like(grid.d2, np.nan))
    with pytest.raises(RuntimeError, match="toppra found no profile"):
        toppra_backend.solve(lost, top)
