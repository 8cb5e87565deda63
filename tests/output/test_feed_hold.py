"""The time of a feed hold, by holds of a file at many places: rows at a changing rate, with a cubic between them."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post

PROGRAM = "G21 G90 G64\nG0 X0 Y0 Z50 A0 C0\nG1 X40 Y10 A8 C30 F3000\nG1 X10 Y30\nG0 Z80 X-100 Y50 C-40\nG0 X100\nM2\n"


def hold(rows: np.ndarray, cycle: float, start: float, seconds: float) -> np.ndarray:
    """Rows of a hold that begins at a time of the file, and of the restart after it."""
    times = np.arange(-14 * seconds, 10 * seconds, cycle)
    rate = 1 / (1 + np.exp(times / seconds))
    passed = np.append(0.0, np.cumsum((rate[1:] + rate[:-1]) / 2 * cycle))
    tau = np.concatenate([start + passed, np.full(5, start + passed[-1])])
    tau = np.concatenate([tau, tau[-1] + passed[-1] - passed[::-1]]) / cycle
    before = np.clip(np.floor(tau).astype(int), 1, len(rows) - 3)
    u = (tau - before)[:, None]
    weights = (
        -u * (u - 1) * (u - 2) / 6,
        (u + 1) * (u - 1) * (u - 2) / 2,
        -(u + 1) * u * (u - 2) / 2,
        (u + 1) * u * (u - 1) / 6,
    )
    return sum(weight * rows[before + k] for k, weight in enumerate(weights, start=-1))


def test_meta_has_the_least_time_of_a_feed_hold(tmp_path: Path, run: Callable[..., Any]) -> None:
    (tmp_path / "p.nc").write_text(PROGRAM, encoding="utf-8")
    output, meta = tmp_path / "o.csv", tmp_path / "m.json"
    place = ("--tool-length", 60, "--wcs", "G54=5,-8,30")
    assert run("convert", tmp_path / "p.nc", *place, "-o", output, "--meta", meta).code == 0
    data, machine = json.loads(meta.read_text(encoding="utf-8")), verne_post.load_machine("verne")
    found, cycle = data["feed_hold"], data["cycle_s"]
    assert (found["before_T"], found["after_T"]) == (14, 10)
    assert found["stop_s"] == pytest.approx(24 * found["T_s"])
    assert found["runs_on_s"] == pytest.approx(14 * found["T_s"])
    rows = np.loadtxt(output, delimiter=",", skiprows=1)[:, 1:-1]
    factors = np.abs([column.factor for column in machine.columns])

    def find_shares(seconds: float) -> list[float]:
        starts = np.arange(0.005, len(rows) * cycle - 28 * seconds - 0.005, 0.08)
        held = [hold(rows, cycle, float(start), seconds) for start in starts]
        return [
            max(float((np.abs(np.diff(one, order, axis=0)) / (limit * factors * cycle**order)).max()) for one in held)
            for order, limit in ((2, machine.limits.acceleration), (3, machine.limits.jerk))
        ]

    acceleration, jerk = find_shares(found["T_s"])
    assert acceleration < 1.005
    assert jerk < 1.03
    assert max(find_shares(0.6 * found["T_s"])) > 1.05
