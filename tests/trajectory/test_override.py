"""Override and slow start: the planned path, slower; every limit kept, every section a whole number of cycles."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from verne_post.app.assemble import Program
from verne_post.model.findings import InputError
from verne_post.trajectory.override import START_RATE, FeedOverride, build_feed_override

from ..builders import LEGAL_SAMPLES, MACHINE, SAMPLES


@given(st.floats(0.05, 1.0), st.sampled_from([0.0, 4.5, 20.0, 300.0]))
def test_planned_time_passes_at_the_override(override: float, ramp: float) -> None:
    played = FeedOverride(override, ramp)
    t = np.linspace(0.0, 2.0 * ramp + 5.0, 4001)
    rate = np.diff(played.find_planned_time(t)) / np.diff(t)
    assert played.find_planned_time(np.zeros(1))[0] == 0.0
    assert (rate <= override * (1 + 1e-9)).all()
    assert (np.diff(rate) >= -1e-9).all()
    assert rate[-1] == pytest.approx(override, rel=1e-9 if ramp == 0 else 1e-3)
    assert played.find_planned_time(np.array([played.steady + 9.0]))[0] - played.find_planned_time(
        np.array([played.steady])
    )[0] == pytest.approx(9.0 * override, rel=1e-12)
    if ramp:
        assert rate[0] == pytest.approx(START_RATE * override, rel=0.05)


@given(st.floats(0.05, 1.0), st.sampled_from([0.0, 4.5, 30.0]), st.floats(0.0, 40.0), st.floats(1e-4, 20.0))
def test_the_fewest_whole_cycles(override: float, ramp: float, begin: float, planned: float) -> None:
    played, cycle = FeedOverride(override, ramp), 0.001
    n = played.count_cycles(planned, begin, cycle)

    def passed(cycles: int) -> float:
        start, end = played.find_planned_time(np.array([begin, begin + cycles * cycle]))
        return float(end - start)

    assert passed(n) >= planned * (1 - 1e-9)
    assert n == 1 or passed(n - 1) < planned * (1 + 1e-9)
    shares = played.find_shares(np.arange(n + 1.0), np.full(n + 1, float(n)), np.full(n + 1, begin), cycle)
    assert shares[0] == 0.0
    assert shares[-1] == 1.0
    assert (np.diff(shares) > 0).all()


def test_the_ramp_leaves_room_for_what_it_adds() -> None:
    """The two inequalities of the module, sampled: r'V + r^2 A <= A and r^3 J + 3 r r' A + r'' V <= J for every
    joint.
    """
    limits = MACHINE.limits
    with pytest.raises(InputError, match=r"at least 4\.32 s"):
        build_feed_override(1.0, 4.31, limits)
    played = build_feed_override(1.0, 4.33, limits)
    t = np.linspace(0.0, 8.0, 200_001)
    r = np.gradient(played.find_planned_time(t), t)
    r1 = np.gradient(r, t)
    r2 = np.gradient(r1, t)
    some = slice(5, -5)  # one-sided differences at the ends; second ones of t have noise of 1e-4 of the jerk
    for v, a, j in zip(limits.velocity, limits.acceleration, limits.jerk, strict=True):
        assert (r1 * v + r**2 * a)[some].max() <= a * (1 + 1e-6)
        assert (r**3 * j + 3 * r * r1 * a + np.abs(r2) * v)[some].max() <= j * (1 + 1e-3)


def off_the_path(plain: Program, table: np.ndarray) -> float:
    """How far the joint values of a file's rows, mm and rad, are at most from the joint path of a program."""
    joints, n = plain.build_joint_path(), len(plain.contour)
    q, line = table[:, 1:6] / [column.factor for column in MACHINE.columns], table[:, -1]
    every, share = np.arange(n), np.linspace(0.0, 1.0, 41)
    travel = (
        np.abs(np.diff(joints.find_joints(np.repeat(every, 41), np.tile(share, n)).reshape(n, 41, -1), axis=1))
        .sum(axis=1)
        .max(axis=1)
    )
    samples = np.ceil(travel / 0.05).astype(int) + 3
    of = np.repeat(every, samples)
    at = np.concatenate([np.linspace(0.0, 1.0, count) for count in samples])
    on = np.column_stack(
        [joints.find_joints(of, at), 1e3 * plain.contour.find_lines()[of]]
    )  # by line: passes may run along each other
    tree, wanted = cKDTree(on), np.column_stack([q, 1e3 * line])
    gap = np.full(len(q), np.inf)
    for which in ([1], range(2, 41)):  # the nearest sample is mostly of the right element
        rest = np.flatnonzero(gap >= 1e-9)
        for near in tree.query(wanted[rest], k=which)[1].T:
            left = gap[rest] >= 1e-9
            row, element, w = rest[left], of[near[left]], at[near[left]]
            for _ in range(9):  # Gauss-Newton for the nearest place of the element, until it is near enough
                here = joints.find_joints(element, w)
                gap[row] = np.minimum(gap[row], np.abs(q[row] - here).max(axis=1))
                left = gap[row] >= 1e-9
                row, element, w, here = row[left], element[left], w[left], here[left]
                step = np.where(w < 0.5, 1e-6, -1e-6)
                slope = (joints.find_joints(element, w + step) - here) / step[:, None]
                off = ((q[row] - here) * slope).sum(1)
                w = np.clip(w + off / np.maximum((slope**2).sum(1), 1e-30), 0.0, 1.0)
    return float(gap.max())


# the curves of splines.nc are those of fanuc_nurbs.nc, and take three times as long
@pytest.mark.parametrize("name", [name for name in LEGAL_SAMPLES if name != "splines.nc"])
def test_every_sample_at_three_tenths_of_its_speed(
    tmp_path: Path,
    run: Callable[..., Any],
    sample_words: Callable[[str], list[str]],
    laid_out: Callable[..., Program],
    name: str,
) -> None:
    program, place = SAMPLES / name, sample_words(name)
    tips, times = [], []
    for override in (1.0, 0.3):
        out = tmp_path / f"{override}.csv"
        answer = run("convert", program, *place, "--override", override, "-o", out, "--decimals", 12)
        assert answer.code == 0, answer.err
        rows = np.loadtxt(out, delimiter=",", skiprows=1)
        q = rows[:, 1:6]
        dt = rows[1, 0] - rows[0, 0]
        factor = np.abs([column.factor for column in MACHINE.columns])
        padded = np.concatenate([q[:1].repeat(3, axis=0), q, q[-1:].repeat(3, axis=0)])
        for order, limit in enumerate((MACHINE.limits.velocity, MACHINE.limits.acceleration), start=1):
            worst = np.abs(np.diff(padded, order, axis=0)).max(axis=0) / dt**order / (limit * factor)
            assert worst.max() <= (1.005 if override == 1.0 else 1.01 * override**order)
        times.append(len(q) - 1)
        tips.append(q)
    # of the whole program: repaired rows at full speed, and rest at the ends of sections, make the only difference
    plain = laid_out(name)
    still = round(plain.path.dwell_seconds.sum() / dt)
    assert (times[1] - still) * 0.3 == pytest.approx(times[0] - still, rel=0.006)
    assert np.abs(tips[1][[0, -1]] - tips[0][[0, -1]]).max() < 1e-9
    verdict = run("verify", tmp_path / "0.3.csv", "--against", program, *place)
    assert verdict.code == 0, verdict.err
    assert off_the_path(plain, rows) < 1e-9  # of the slower file, which was read last


@pytest.mark.parametrize(
    "more",
    [("--slow-start", 4.5), ("--slow-start", 8, "--override", 0.6), ("--slow-start", 5, "--smoothing", "off"),
     ("--override", 0.98), ("--override", 0.71, "--smoothing", "off", "--cycle", 0.004)],
)  # fmt: skip
def test_slow_starts_hold_all_limits_and_keep_dwells(
    tmp_path: Path, run: Callable[..., Any], more: tuple[object, ...]
) -> None:
    program = tmp_path / "p.nc"
    program.write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X40 F6000\nG4 P0.5\nG1 Y40 A10\nG3 X0 Y0 R40\nG0 Z90 C40\nM2\n")
    cycle = 0.004 if "--cycle" in more else 0.001
    out = tmp_path / "o.csv"
    place = ("--tool-length", 60, "--wcs", "G54=0,0,30")
    answer = run("convert", program, *place, *more, "-o", out)
    assert answer.code == 0, answer.err
    rows = np.loadtxt(out, delimiter=",", skiprows=1)
    assert math.isclose(float((rows[:, -1] == 4).sum()) * cycle, 0.5, abs_tol=1.5 * cycle)
    cycles = ("--cycle", cycle) if "--cycle" in more else ()
    smoothing = ("--smoothing", "off") if "off" in more else ()
    assert run("verify", out, "--against", program, *place, *cycles, *smoothing).code == 0
    if "--slow-start" in more:
        speed = np.abs(np.diff(rows[:, 1:6], axis=0)).max(axis=1)
        plain = tmp_path / "plain.csv"
        assert run("convert", program, *place, *smoothing, "-o", plain).code == 0
        full = np.abs(np.diff(np.loadtxt(plain, delimiter=",", skiprows=1)[:, 1:6], axis=0)).max(axis=1)
        assert speed[:300].max() < 0.25 * full[:300].max()


@pytest.mark.parametrize(("override", "cycle"), [(0.5, 0.01), (0.3, 0.001), (0.05, 0.01), (0.05, 0.001)])
def test_from_row_to_row_the_tool_keeps_the_share_of_the_feed_rate(
    tmp_path: Path, run: Callable[..., Any], override: float, cycle: float
) -> None:
    """Where a motion begins and ends too: at 0.05 and 10 ms its first step was 1.7 times as long, its jerk 0.2 of the
    limit.
    """
    program, out = tmp_path / "p.nc", tmp_path / "o.csv"
    program.write_text("G21 G90 G64 P0.01\nG0 X0 Y0 Z5 A0 C0\nG1 X1 F600\nY1\nX2\nM2\n")
    place = ("--tool-length", 80, "--wcs", "G54=0,0,60", "--override", override, "--cycle", cycle)
    answer = run("convert", program, *place, "-o", out, "--decimals", 12)
    assert answer.code == 0, answer.err
    rows = np.loadtxt(out, delimiter=",", skiprows=1)
    q = rows[:, 1:6] / [column.factor for column in MACHINE.columns]
    tip = MACHINE.forward(q, 80.0)[0]
    assert np.linalg.norm(np.diff(tip, axis=0), axis=1).max() <= 1.001 * override * 10.0 * cycle
    rested = np.concatenate([q[:1].repeat(3, axis=0), q, q[-1:].repeat(3, axis=0)])
    jerk = np.abs(np.diff(rested, 3, axis=0)).max(axis=0) / cycle**3 / MACHINE.limits.jerk
    # differences of slow rows see what those of the planned rows average; by the first rows it was 1600 times as much
    assert jerk.max() <= (20.0 if override == 0.05 else 1.5) * override**3
    assert run("verify", out, "--against", program, *place).code == 0
