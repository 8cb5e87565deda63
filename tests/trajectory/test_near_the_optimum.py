"""Sharp corners in all joints at once, under limits of many proportions: planned times against the fine solution."""

from dataclasses import replace

import numpy as np
import pytest

from verne_post import Machine, Options
from verne_post.app.assemble import assemble
from verne_post.app.plan import plan_program

MOVES = 40


def wandering(seed: int) -> bytes:
    """Moves of 0.5 mm in directions that have little to do with each other; the tool axis wanders too."""
    rng = np.random.default_rng(seed)
    heading = np.cumsum(np.radians(rng.uniform(-120, 120, MOVES)))
    x, y = np.cumsum(0.5 * np.cos(heading)), np.cumsum(0.5 * np.sin(heading))
    a, c = np.cumsum(rng.normal(0, 0.4, (2, MOVES)), axis=1)
    lines = [f"G1 X{p:.4f} Y{q:.4f} Z60 A{u:.4f} C{v:.4f}" for p, q, u, v in zip(x, y, a, c, strict=True)]
    return "\n".join(["G21 G90 G64 P0.003 F6000", *lines, "M2\n"]).encode()


@pytest.mark.parametrize("cycle", [0.00025, 0.004])
@pytest.mark.parametrize("shares", [(0.15, 1, 1), (1, 1, 0.15), (0.3, 5, 1)], ids=str)
@pytest.mark.parametrize("seed", [1, 3])
def test_corners_take_at_most_one_percent_more(
    seed: int, shares: tuple[float, float, float], cycle: float, machine: Machine
) -> None:
    """Profiles that leave out what later turns out to bind take up to four times as long."""
    limits = machine.limits
    scaled = replace(
        limits,
        **{
            name: share * getattr(limits, name)
            for name, share in zip(("velocity", "acceleration", "jerk"), shares, strict=True)
        },
    )
    ours, fine = (
        plan_program(
            assemble(
                wandering(seed), replace(machine, limits=scaled), Options(tool_length=80, cycle=cycle, quality=quality)
            )
        ).profiles.cycles.sum()
        for quality in (False, True)
    )
    # and two cycles, for the whole number of them
    assert ours <= 1.01 * fine + 2
