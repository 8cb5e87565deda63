"""Decimals of every column: as many as the jerk limit needs and no more, and what fewer would cost."""

import math
import tomllib
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.cli.files import RunFiles
from verne_post.cli.options import build_options
from verne_post.model.findings import InputError
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.rounding import choose_setpoint_format, estimate_rounding_noise, round_setpoints
from verne_post.output.setpoints import write_csv_rows

from ..builders import MACHINE

LIMITS = tomllib.loads((Path(__file__).resolve().parents[2] / "machine_configs" / "verne.toml").read_text())["limits"]
JOINTS = ("rho", "rho", "rho", "a", "c")
JERK = [Fraction(LIMITS[f"{name}_jerk"]) for name in JOINTS]
OPTIONS = ("--tool-length", 80, "--wcs", "G54=0,0,50")


def enough(decimals: int, joint: str, cycle: str) -> bool:
    """q / cycle, 2 q / cycle^2 and 4 q / cycle^3 within 0.02 %, 0.1 % and 1 % of the limits; q itself 1e-5 mm or 2e-8
    rad.
    """
    q, dt = Fraction(1, 10**decimals), Fraction(cycle)
    shares = (("velocity", 1, Fraction(1, 5000)), ("acceleration", 2, Fraction(1, 1000)), ("jerk", 4, Fraction(1, 100)))
    place = Fraction(1, 10**5) if joint == "rho" else Fraction(math.degrees(2e-8))
    return q <= place and all(
        factor * q / dt ** (order + 1) <= share * Fraction(LIMITS[f"{joint}_{name}"])
        for order, (name, factor, share) in enumerate(shares)
    )


@pytest.mark.parametrize(
    "cycle", ["0.000125", "0.00025", "0.0004", "0.0005", "0.001", "0.002", "0.004", "0.005", "0.008", "0.01"]
)
def test_auto_decimals_are_enough_and_not_one_too_many(cycle: str) -> None:
    fmt = choose_setpoint_format(MACHINE, float(cycle), None, accept_rounding=False)
    assert fmt.cycle == float(cycle)
    for decimals, joint in zip(fmt.decimals, JOINTS, strict=True):
        assert enough(decimals, joint, cycle)
        assert not enough(decimals - 1, joint, cycle)
    # t_s shows the cycle exactly, with no digit to spare
    assert Fraction(cycle) * 10**fmt.time_decimals % 1 == 0
    assert Fraction(cycle) * 10 ** (fmt.time_decimals - 1) % 1 != 0


def test_default_machine_at_one_millisecond() -> None:
    fmt = choose_setpoint_format(MACHINE, 0.001, None, accept_rounding=False)
    assert fmt.decimals == (7, 7, 7, 8, 8)
    assert fmt.time_decimals == 3


@pytest.mark.parametrize("cycle", [1e-3, 1e-4, 3e-5, 1e-5, 1e-6])
def test_every_cycle_that_the_command_line_takes_keeps_the_promise_of_auto(cycle: float) -> None:
    """Where doubles have no room for the decimals that a short cycle needs, the cycle must be refused."""
    import click

    try:
        options = build_options(RunFiles(), "a.nc", cycle=cycle)
        fmt = choose_setpoint_format(MACHINE, options.cycle or 0.0, None, accept_rounding=False)
    except (InputError, click.UsageError):
        assert cycle < 1e-4  # nothing that a machine uses
        return
    for decimals, jerk in zip(fmt.decimals, JERK, strict=True):
        assert 4 * 10.0**-decimals / cycle**3 <= 0.01 * float(jerk) * (1 + 1e-9)


@pytest.mark.parametrize("decimals", [0, 3, 5])
def test_decimals_whose_noise_exceeds_a_limit_are_refused(decimals: int) -> None:
    with pytest.raises(InputError) as caught:
        choose_setpoint_format(MACHINE, 0.001, decimals, accept_rounding=False)
    (item,) = caught.value.findings
    assert item.code == "VP018"
    assert str(decimals) in item.message
    assert "--accept-rounding" in item.message
    fmt = choose_setpoint_format(MACHINE, 0.001, decimals, accept_rounding=True)
    assert fmt.decimals == (decimals,) * 5


@pytest.mark.parametrize("decimals", [6, 7, 12])
def test_decimals_whose_noise_is_below_every_limit_are_taken(decimals: int) -> None:
    assert choose_setpoint_format(MACHINE, 0.001, decimals, accept_rounding=False).decimals == (decimals,) * 5


def test_noise_is_what_differences_of_rounded_numbers_can_show() -> None:
    """The bounds 2 q / dt^2 and 4 q / dt^3 are reached, and never exceeded, by errors of half a unit."""
    fmt = choose_setpoint_format(MACHINE, 0.001, 6, accept_rounding=False)
    acceleration, jerk = estimate_rounding_noise(fmt)
    half = 0.5e-6
    errors = np.random.default_rng(1).uniform(-half, half, 100000)
    worst = np.resize([half, -half], 8)
    for order, bound in ((2, acceleration), (3, jerk)):
        assert np.abs(np.diff(errors, order)).max() / 0.001**order <= bound[0] * (1 + 1e-9)
        assert np.abs(np.diff(worst, order)).max() / 0.001**order == pytest.approx(bound[0])


def test_rounding_is_to_the_nearest_and_makes_no_negative_zero() -> None:
    fmt = choose_setpoint_format(MACHINE, 0.001, None, accept_rounding=False)
    factor = np.array([column.factor for column in MACHINE.columns])
    file = np.array([[100.00000004, 100.00000006, -4e-8, -4e-9, -0.0], [1.0, 2.0, 3.0, 45.123456786, -360.0]])
    values, numbers = round_setpoints(file / factor, MACHINE, fmt)
    assert numbers is None
    assert values[0].tolist() == [100.0, 100.0000001, 0.0, 0.0, 0.0]
    assert values[1].tolist() == [1.0, 2.0, 3.0, 45.12345679, -360.0]
    assert not np.signbit(values[0]).any()
    text = write_csv_rows(SetpointBlock(0, values, np.array([1, 2], dtype=np.int32), fmt))
    assert text.splitlines()[0] == "0.000,100.0000000,100.0000001,0.0000000,0.00000000,0.00000000,1"
    assert "-0.0" not in text


# --- through the command line ----------------------------------------------------------------------


@pytest.fixture
def program(tmp_path: Path) -> Path:
    file = tmp_path / "a.nc"
    file.write_text("G21 G90 G94 G17\nG0 X0 Y0 Z20 A0 C0\nG1 X3 F3000\nY2 A3 C5\nG2 I1\nM2\n")
    return file


def test_coarse_decimals_are_refused_with_the_noise(program: Path, run: Callable[..., Any]) -> None:
    answer = run(program, *OPTIONS, "--decimals", 3)
    assert answer.code == 2
    assert answer.out == ""
    assert "decimals" in answer.err
    assert "--accept-rounding" in answer.err
    assert "4e+06 mm/s3" in answer.err  # 4 * 0.001 mm / (1 ms)^3
    assert "100000" in answer.err


@pytest.mark.parametrize("decimals", [3, 4])
def test_accepted_rounding_is_written_and_passes(
    decimals: int, program: Path, run: Callable[..., Any], tmp_path: Path
) -> None:
    answer = run(program, *OPTIONS, "--decimals", decimals, "--accept-rounding")
    assert answer.code == 0, answer.err
    for row in answer.out.splitlines()[1:]:
        assert [len(cell.partition(".")[2]) for cell in row.split(",")] == [3, *[decimals] * 5, 0]
    # the summary says what rounding may add
    text = " ".join(answer.err.split())
    assert f"{2 * 10.0 ** (6 - decimals):.3g} mm/s2" in text
    assert f"{4 * 10.0 ** (9 - decimals):.3g} mm/s3" in text
    file = tmp_path / "axes.csv"
    file.write_text(answer.out, newline="")
    verified = run("verify", file, "--against", program, *OPTIONS, "--accept-rounding")
    assert verified.code == 0, verified.err
    # what nobody has accepted is as wrong as any other jerk
    refused = run("verify", file, "--against", program, *OPTIONS)
    assert refused.code == 1
    assert "VP403 error: " in refused.err


@pytest.mark.parametrize("cycle", ["0.0005", "0.004"])
def test_decimals_follow_the_cycle_into_the_file(
    cycle: str, program: Path, run: Callable[..., Any], tmp_path: Path
) -> None:
    fmt = choose_setpoint_format(MACHINE, float(cycle), None, accept_rounding=False)
    answer = run(program, *OPTIONS, "--cycle", cycle)
    assert answer.code == 0, answer.err
    rows = answer.out.splitlines()[1:]
    for k, row in enumerate(rows):
        cells = row.split(",")
        assert cells[0] == f"{k * float(cycle):.{fmt.time_decimals}f}"
        assert [len(cell.partition(".")[2]) for cell in cells[1:6]] == list(fmt.decimals)
    file = tmp_path / "axes.csv"
    file.write_text(answer.out, newline="")
    assert run("verify", file, "--against", program, *OPTIONS, "--cycle", cycle).code == 0
    # with another cycle the times are wrong, which is named
    other = run("verify", file, "--against", program, *OPTIONS)
    assert other.code == 2
    assert "VP020" in other.err
    assert "t_s" in other.err


@pytest.mark.parametrize("share", [0.1, 0.3, 10.0])
def test_long_cycles_keep_acceleration_and_path_too(share: float) -> None:
    """At 10 ms the jerk alone would ask for 3 or 4 decimals; 1e-3 mm is 20 mm/s2 then, and all that the path may be
    off.
    """
    limits = MACHINE.limits
    scaled = replace(limits, acceleration=share * limits.acceleration, jerk=share * limits.jerk)
    turns = "".join(
        f"G1 X{x}.3 Y{y}.1 Z{50 + y} A{y}\n"
        for x, y in zip(range(0, 40, 4), [0, 7, 1, 3, 9, 2, 8, 1, 6, 4], strict=True)
    )
    source = f"G21 G90 G61 F3000\n{turns}M2\n".encode()
    result = verne_post.convert(source, replace(MACHINE, limits=scaled), verne_post.Options(tool_length=80, cycle=0.01))
    assert result.ok, result.findings
