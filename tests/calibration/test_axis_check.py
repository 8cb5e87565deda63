"""`machine axis-check`: one actuator at a time, slowly, and the truth about what must be seen."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.config import list_machine_files

AT = (600.0, 580.0, 590.0, 4.0, -30.0)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rows(path: Path) -> np.ndarray:
    return np.loadtxt(path, delimiter=",", skiprows=1)


@pytest.mark.parametrize("machine", ["verne", "serial", "linear_delta"])
def test_one_actuator_moves_at_two_hundredths_of_its_speed(folder: Path, run: Callable[..., Any], machine: str) -> None:
    model = verne_post.load_machine(machine)
    at = (
        AT
        if machine == "verne"
        else (0.0, 10.0, 0.0, 4.0, -30.0)
        if machine == "serial"
        else (500.0, 510.0, 495.0, 4.0, -30.0)
    )
    answer = run("machine", "axis-check", "--machine", machine, "--at", ",".join(map(str, at)), "-o", "out")
    assert answer.code == 0, answer.err
    files = sorted((folder / "out").glob("*.csv"))
    joints = [column.joint for column in model.columns]
    assert [path.stem.split("_")[1] for path in files] == joints * 2
    size = np.abs([column.factor for column in model.columns])
    for number, path in enumerate(files):
        table, joint = rows(path), number % 5
        distance = 1.0 if number < 5 else 10.0
        moved = table[:, 1:6] - np.array(at)
        assert np.abs(np.delete(moved, joint, axis=1)).max() < 1e-6
        own = moved[:, joint]
        assert own[0] == pytest.approx(0.0, abs=1e-6)
        assert own[-1] == pytest.approx(0.0, abs=1e-6)
        assert own.max() == pytest.approx(distance, abs=1e-6)
        assert own.min() == pytest.approx(-distance, abs=1e-6)
        assert int(np.argmax(own)) < int(np.argmin(own))  # first to the positive side
        assert (np.abs(own - distance) < 1e-6).sum() >= 1000  # stands there for a second
        limits = model.limits
        for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), start=1):
            most = np.abs(np.diff(own, order)).max() / 0.001**order
            quantum = 4.1 * 10.0 ** -len(path.read_text().splitlines()[1].split(",")[1 + joint].partition(".")[2])
            assert most <= 1.001 * 0.02**order * limit[joint] * size[joint] + quantum / 0.001**order
        assert (table[:, -1] == 0).all()


def test_what_must_be_seen_is_what_happens(folder: Path, run: Callable[..., Any]) -> None:
    """The nose by the module's forward kinematics, marks on the table by hand."""
    machine = verne_post.load_machine()
    assert run("machine", "axis-check", "--at", ",".join(map(str, AT)), "-o", "out").code == 0
    text = " ".join((folder / "out" / "README.txt").read_text().split())
    told = dict(re.findall(r"\[ \] (\S+)\.csv \([^)]*\): (.*?)(?= \[ \]|$)", text))
    assert len(told) == 10
    place, alpha, _ok = machine.module.forward(np.array(AT[:3]))
    for joint, name in enumerate(("rho1", "rho2", "rho3")):
        moved = np.array(AT[:3])
        moved[joint] += 10.0
        after, tilt, _ok = machine.module.forward(moved)
        x, y, z = (after - place) * [1, -1, -1]
        said = told[f"{6 + joint:02d}_{name}_10mm"]
        assert f"{name} goes +10 mm, back, -10 mm, and back, at" in said
        assert float(re.search(r"([-+][\d.]+) mm in x", said)[1]) == pytest.approx(x, abs=6e-5)  # type: ignore[index]
        assert float(re.search(r"([-+][\d.]+) mm in y", said)[1]) == pytest.approx(y, abs=6e-5)  # type: ignore[index]
        assert f"{abs(z):.4f} mm {'up' if z > 0 else 'down'}" in said
        assert f"tilts by {np.degrees(tilt - alpha):+.4f} deg" in said
    # positive A lifts the table's y side; positive C turns counter-clockwise seen from above
    a = np.radians([4.0, 5.0])
    y_mark = 100 * np.cos(np.radians(-30.0))
    assert f"{y_mark * (np.sin(a[1]) - np.sin(a[0])):.4f} mm up" in told["04_a_1deg"]
    c = np.radians([-30.0, -29.0])
    x_moves = 100 * (np.cos(c[1]) - np.cos(c[0])), -100 * (np.sin(c[1]) - np.sin(c[0]))
    said = told["05_c_1deg"]
    numbers = [float(value) for value in re.findall(r"([-+][\d.]+) mm in [xy]", said)]
    mark_x = [100 * (np.cos(c[1]) - np.cos(c[0])), 100 * (np.sin(c[1]) - np.sin(c[0])) * np.cos(a[0])]
    mark_y = [x_moves[1], 100 * (np.cos(c[1]) - np.cos(c[0])) * np.cos(a[0])]
    assert any(np.allclose(numbers, expected, atol=6e-5) for expected in (mark_x, mark_y))


def test_senses_of_the_machine_file_are_named(folder: Path, run: Callable[..., Any]) -> None:
    """A named by the tool: its positive side lowers the table's y side. A drive that counts the other way says so."""
    text = (
        list_machine_files()["verne"]
        .read_text(encoding="utf-8")
        .replace('a_positive = "workpiece"', 'a_positive = "tool"')
    )
    drives = "".join(
        f'[drives.{joint}]\nunit = "counts"\nsign = {sign}\nscale = 1e7\ninteger = true\n'
        for joint, sign in (("rho1", -1), ("rho2", 1), ("rho3", 1), ("a", -1), ("c", 1))
    )
    Path("m.toml").write_text(text.replace("[control]", f"{drives}\n[control]") + 'drives = "assumed"\n')
    at = "-6000000000,5800000000,5900000000,0,0"
    answer = run("machine", "axis-check", "--machine", "m.toml", "--at", at, "--units", "drive", "-o", "out")
    assert answer.code == 0, answer.err
    said = " ".join(answer.out.split())
    assert (
        "rho1 goes +1 mm, back, -1 mm, and back, at 0.58 mm/s at most. The drive counts down by 10000000 (rho1_counts)."
        in said
    )
    assert (
        "rho2 goes +1 mm, back, -1 mm, and back, at 0.58 mm/s at most. The drive counts up by 10000000 (rho2_counts)."
        in said
    )
    assert re.search(
        r"a goes \+1 deg, back, -1 deg, and back, at [0-9.]+ deg/s at most\. The drive counts down by 10000000 "
        r"\(a_counts\)\.[^[]* mm down\.",
        said,
    )
    first = (folder / "out" / "01_rho1_1mm.csv").read_text().splitlines()
    assert first[0] == "t_s,rho1_counts,rho2_counts,rho3_counts,a_counts,c_counts,line"
    assert first[1] == f"0.000,{at},0"
    numbers = rows(folder / "out" / "01_rho1_1mm.csv")[:, 1]
    assert numbers.min() == -6010000000
    assert int(np.argmin(numbers)) < int(np.argmax(numbers))


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ("1245,580,590,0,0", "rho1 +10 mm from --at: rho1_mm would be 1255.0000, beyond its limit 1250"),
        ("600,580,590,0", "--at takes 5 values rho1,rho2,rho3,a,c, got 4"),
        ("600,580,590,0,x", "is not a list of numbers"),
        ("100,1200,600,0,0", "no position of the platform fits these sliders"),
        ("1060,1000,1005,0,0", "the spindle nose would be"),
        ("250,240,230,94.5,0", "a +1 deg from --at: a_deg would be 95.5000, beyond its limit 95"),
    ],
)
def test_positions_that_are_none(folder: Path, run: Callable[..., Any], at: str, said: str) -> None:
    answer = run("machine", "axis-check", "--at", at, "-o", "out")
    assert answer.code in (1, 2)
    assert said in answer.err
    assert not ("takes 5 values" in said and "verne" in answer.err.partition("Error: ")[2])
    assert not Path("out").exists()


def test_two_checks_are_not_mixed(folder: Path, run: Callable[..., Any]) -> None:
    Path("out").mkdir()
    Path("out/old.csv").write_text("x")
    answer = run("machine", "axis-check", "--at", ",".join(map(str, AT)), "-o", "out")
    assert answer.code == 2
    assert "not empty" in answer.err


def test_the_help_says_what_holds_for_a_hexapod_too(folder: Path, run: Callable[..., Any]) -> None:
    """Eight columns of which six are driven: it said five values and ten files of every machine."""
    said = " ".join(run("machine", "axis-check", "--help").out.split())
    assert "two files for each actuator that is driven" in said
    assert "a value for each column of a setpoint file" in said
    model = verne_post.load_machine("hexapod")
    at = ",".join(["1270"] * 6 + ["0", "0"])
    answer = run("machine", "axis-check", "--machine", "hexapod", "--at", at, "-o", "out")
    assert answer.code == 0, answer.err
    driven = sum(column.driven for column in model.columns)
    assert len(list((folder / "out").glob("*.csv"))) == 2 * driven == 12
    assert len(at.split(",")) == len(model.columns) == 8
