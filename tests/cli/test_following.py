"""verify --measured: errors that were put into a log come out, in the joints and at the tool."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post

PROGRAM = "G21 G90 G64\nG0 X0 Y0 Z50 A0 C0\nG1 X40 Y10 A8 C30 F3000\nG1 X10 Y30\nG0 Z80\nM2\n"
PLACE = ("--tool-length", 60, "--wcs", "G54=5,-8,30")


@pytest.fixture
def rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]) -> np.ndarray:
    monkeypatch.chdir(tmp_path)
    Path("p.nc").write_text(PROGRAM)
    assert run("convert", "p.nc", *PLACE, "-o", "axes.csv").code == 0
    return np.loadtxt("axes.csv", delimiter=",", skiprows=1)


def verified(run: Callable[..., Any], *more: object) -> tuple[int, str]:
    answer = run("verify", "axes.csv", "--against", "p.nc", *PLACE, "--measured", "log", *more)
    return answer.code, " ".join(answer.err.split())


def numbers(said: str) -> dict[str, float]:
    found = re.search(
        r"The tip was at most ([\d.]+) mm .*? and ([\d.]+) mm from the commanded path .*? axis at most ([\d.]+) deg",
        said,
    )
    assert found
    joints = dict(re.findall(r"(rho\d|a|c) ([\d.]+) (?:mm|deg) \(rms", said))
    return {
        "tip": float(found[1]),
        "path": float(found[2]),
        "axis": float(found[3]),
        **{k: float(v) for k, v in joints.items()},
    }


def test_a_perfect_run(rows: np.ndarray, run: Callable[..., Any]) -> None:
    np.savetxt("log", rows[:, 1:6], fmt="%.9f")  # as halsampler writes
    code, said = verified(run)
    assert code == 0
    assert "0 rows (0 s) later than" in said
    assert max(numbers(said).values()) < 1e-6


def test_an_offset_of_one_slider_is_seen_at_the_tool(rows: np.ndarray, run: Callable[..., Any]) -> None:
    machine = verne_post.load_machine()
    measured = rows[:, 1:6].copy()
    measured[:, 1] += 0.05
    np.savetxt("log", np.column_stack([np.arange(len(rows)), measured]), fmt="%.9f")  # halsampler -t
    code, said = verified(run)
    assert code == 0
    told = numbers(said)
    assert told["rho2"] == pytest.approx(0.05, abs=1e-6)
    assert told["rho1"] < 1e-6
    factor = [column.factor for column in machine.columns]
    tips, axes = zip(*(machine.forward(q / factor, 60.0)[:2] for q in (rows[:, 1:6], measured)), strict=True)
    assert told["tip"] == pytest.approx(np.linalg.norm(tips[1] - tips[0], axis=1).max(), abs=1e-6)
    assert told["axis"] == pytest.approx(np.degrees(np.linalg.norm(axes[1] - axes[0], axis=1).max()), abs=1e-6)
    assert 0 < told["path"] <= told["tip"]
    assert verified(run, "--following", told["path"] + 1e-4)[0] == 0
    code, said = verified(run, "--following", told["path"] - 1e-3)
    assert code == 1
    assert "farther from the commanded path" in said
    for wrong in ("nan", "-1"):
        code, said = verified(run, "--following", wrong)
        assert code == 2
        assert "--following" in said


def test_a_lag_of_all_axes_leaves_the_tool_on_the_path(rows: np.ndarray, run: Callable[..., Any]) -> None:
    """A log that is 17 rows late: found by itself; told to be on time, the tip lags, but keeps to the path."""
    late = np.concatenate([rows[:1, 1:6].repeat(17, axis=0), rows[:, 1:6]])
    np.savetxt("log", late, fmt="%.9f", delimiter=",", header="rho1_mm,rho2_mm,rho3_mm,a_deg,c_deg", comments="")
    code, said = verified(run)
    assert "17 rows (0.017 s) later than" in said
    assert numbers(said)["tip"] < 1e-6
    code, said = verified(run, "--delay", 0)
    assert code == 0
    told = numbers(said)
    assert told["tip"] > 0.5
    assert told["path"] < 2e-3  # chords between rows at 50 mm/s


def test_a_log_that_ends_early_or_lags_to_its_end(rows: np.ndarray, run: Callable[..., Any]) -> None:
    """Drives with a time constant of 10 ms: some ten rows behind, so the last rows have nothing to be compared with."""
    slow = rows[:, 1:6].copy()
    for k in range(1, len(slow)):
        slow[k] = slow[k - 1] + (slow[k] - slow[k - 1]) * (1 - np.exp(-0.1))
    np.savetxt("log", slow[:-100], fmt="%.9f")
    code, said = verified(run)
    assert code == 0
    delay = re.search(r"(\d+) rows \(0\.\d+ s\) later than", said)
    assert delay
    assert 8 <= int(delay[1]) <= 12
    assert numbers(said)["path"] < numbers(said)["tip"]


def test_columns_of_other_names(rows: np.ndarray, run: Callable[..., Any]) -> None:
    np.savetxt("log", rows[:, [5, 1, 2, 3, 4]], fmt="%.9f", delimiter=";", header="C;x1;x2;x3;A", comments="")
    code, said = verified(run, "--columns", "rho1=x1,rho2=x2,rho3=x3,a=A,c=C")
    assert code == 0
    assert max(numbers(said).values()) < 1e-6
    np.savetxt("log", rows[:, [5, 1, 2, 3, 4]], fmt="%.9f")
    code, said = verified(run, "--columns", "rho1=2,rho2=3,rho3=4,a=5,c=1")
    assert max(numbers(said).values()) < 1e-6


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        ("", (), "the log is empty"),
        ("x,y\n1,2\n", (), "no column rho1_mm or rho1 for rho1; say which with --columns"),
        ("1 2 3\n", (), "3 columns without a header; expected 5"),
        ("1 2 3 4 5\n1 2 overrun 4 5\n", (), "log:2: VP020 error: value 3, 'overrun', is not a finite number"),
        ("0 1 2 3 4 5\n2 1 2 3 4 5\n", (), "samples are missing after number 0"),
        ("1 2 3 4 5\n", ("--columns", "b=1"), "'b' is no joint"),
        ("1 2 3 4 5\n", ("--columns", "rho1"), "expected JOINT=NAME"),
        ("1 2 3 4 5\n", ("--delay", "x"), "expected auto"),
    ],
)
def test_bad_logs(rows: np.ndarray, run: Callable[..., Any], text: str, words: tuple[str, ...], said: str) -> None:
    Path("log").write_text(text)
    code, told = verified(run, *words)
    assert code == 2
    assert said in told


def test_options_of_a_log_need_one(rows: np.ndarray, run: Callable[..., Any]) -> None:
    answer = run("verify", "axes.csv", "--against", "p.nc", *PLACE, "--delay", 3)
    assert answer.code == 2
    assert "name it with --measured" in answer.err
