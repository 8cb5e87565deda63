"""Programs on the Tricept-like machine, end to end; the judge of written files has matrices of its own."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from tests.kinematics.test_carried import judge

ROOT = Path(__file__).resolve().parents[1]
OPTIONS = ["--machine", "tricept", "--tool-length", "100"]
Runner = Callable[..., Any]


def read_rows(csv: str, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows of the struts and the wrist, their lines, and tip and tool axis in the part frame by the judge."""
    table = np.genfromtxt(io.StringIO(csv), delimiter=",", names=True)
    values = np.column_stack([table[name] for name in ("l1_mm", "l2_mm", "l3_mm", "a_deg", "c_deg")])
    place, ok = verne_post.load_machine("tricept").five_axis.leg.find_position(values[:, :3])
    assert ok.all()
    misfit, tip, axis = judge(values, length)(place)
    assert np.abs(misfit).max() < 1e-9
    return values, table["line"], tip, axis


def test_the_blade_is_converted(run: Runner, tmp_path: Path) -> None:
    """At the end of every tenth line of the sample, tip and tool axis are where its words say."""
    axes, source = tmp_path / "blade.csv", ROOT / "gcode_samples/blade_5axis.nc"
    answer = run("convert", source, "--machine", "tricept", "-o", axes)
    assert answer.code == 0, answer.err
    _values, line, tip, axis = read_rows(axes.read_text(encoding="utf-8"), 120.0)
    checked = 0
    for number, text in enumerate(source.read_text(encoding="utf-8").splitlines(), start=1):
        words = (
            {word[0]: float(word[1:]) for word in text.split() if word[0] in "XYZAC" and word[1:]}
            if text[:1] == "X"
            else {}
        )
        if len(words) < 5 or number % 10:
            continue
        a, c = np.radians([words["A"], words["C"]])
        wanted = np.array([-np.sin(a) * np.sin(c), -np.sin(a) * np.cos(c), np.cos(a)])
        away = np.linalg.norm(tip - [words["X"], words["Y"], words["Z"] + 10.0], axis=1)
        near = np.abs(line - number) <= 1
        at = np.flatnonzero(near)[np.argmin(away[near])]
        assert away[at] < 0.01 + 0.03
        assert np.linalg.norm(axis[at] - wanted) < np.radians(0.3)
        checked += 1
    assert checked > 50


def test_the_blade_is_converted_on_sliders(run: Runner, tmp_path: Path) -> None:
    """The same program of the part on another carrier: the rows of both hold the same tips and axes line by line."""
    source, ends = ROOT / "gcode_samples/blade_5axis.nc", []
    for machine in ("tricept", "george_v"):
        axes, loaded = tmp_path / f"{machine}.csv", verne_post.load_machine(machine)
        place = {"tricept": "0,0,10", "george_v": "0,0,10"}[machine]
        words = ["--machine", machine, "--tool-length", "120", "--wcs", f"G54={place}"]
        answer = run("convert", source, *words, "-o", axes)
        assert answer.code == 0, answer.out + answer.err
        table = np.genfromtxt(axes, delimiter=",", names=True)
        rows = np.column_stack([table[f"{column.joint}_{column.unit}"] for column in loaded.columns])
        tip, axis, ok = loaded.forward(rows / [column.factor for column in loaded.columns], 120.0)
        assert ok.all()
        assert run("verify", axes, "--against", source, *words).code == 0
        ends.append([tip[[0, -1]] - [float(value) for value in place.split(",")], axis[[0, -1]]])
    assert np.abs(np.array(ends[0]) - np.array(ends[1])).max() < 1e-4


HEAD = "G21 G90 G94 G17\nG0 X10 Y0 Z30 {words}\nG1 Z0 F1000\n"


@pytest.mark.parametrize("place", ["300,100,0", "-300,-100,0", "100,-300,0"])
def test_an_upright_tool_all_around_and_one_that_passes_upright(place: str, run: Runner, tmp_path: Path) -> None:
    """Circles with an upright tool; A from 20 to -20: the wrist goes by its pole, whole turns follow the way, no joint
    jumps.
    """
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    for text in (
        HEAD.format(words="A0 C0") + "X60 Y20\nG3 X20 Y60 I-40 J0\nM2\n",
        HEAD.format(words="A20 C30") + "X60 Y20 A-20\nX20 Y40 C70\nX20 Y0 A20 C30\nM2\n",
    ):
        source.write_text(text.replace("F1000", "F3000"), encoding="utf-8")  # a third of the rows
        answer = run("convert", source, *OPTIONS, "--wcs", f"G54={place}", "-o", axes)
        assert answer.code == 0, answer.out + answer.err
        values, _line, tip, axis = read_rows(axes.read_text(encoding="utf-8"), 100.0)
        assert np.abs(np.diff(values[:, 4])).max() < 180.0 * 1.006e-3  # of a row of 1 ms
        origin = np.array([float(value) for value in place.split(",")])
        assert np.abs(tip[0] - origin - [10, 0, 30]).max() < 1e-4
        end = [20, 60, 0] if "G3" in text else [20, 0, 0]
        assert np.abs(tip[-1] - origin - end).max() < 1e-4
        lean = 0.0 if "G3" in text else np.radians(20.0)
        assert np.arctan2(np.hypot(*axis[-1, :2]), axis[-1, 2]) == pytest.approx(lean, abs=1e-5)
        assert run("verify", axes, "--against", source, *OPTIONS, "--wcs", f"G54={place}").code == 0


def test_a_whole_circle_round_the_middle_of_the_machine(run: Runner, tmp_path: Path) -> None:
    """c turns once round with the leg, though the word C stands; under the leg's joint the wrist is at its pole:
    refused (VP202).
    """
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text("G21 G90 G94 G17\nG0 X100 Y0 Z0 A0 C0\nG3 X100 Y0 I-100 J0 F6000\nM2\n", encoding="utf-8")
    assert run("convert", source, *OPTIONS, "-o", axes).code == 0
    values, _line, _tip, axis = read_rows(axes.read_text(encoding="utf-8"), 100.0)
    assert abs(values[-1, 4] - values[0, 4]) == pytest.approx(360.0, abs=1e-3)
    assert np.abs(axis[:, :2]).max() < 1e-7
    source.write_text("G21 G90 G94 G17\nG0 X100 Y0 Z0 A0 C0\nG1 X-100 F6000\nM2\n", encoding="utf-8")
    refused = run("check", source, *OPTIONS)
    assert refused.code != 0
    assert "VP202 error: tilt of the tool against the central leg 0.000 deg is below 0.5 deg" in refused.out


@pytest.mark.parametrize("move", ["G1 C45 F500", "G0 C45"])
def test_a_turn_of_c_alone_at_the_pole_is_refused(move: str, run: Runner, tmp_path: Path) -> None:
    """No joint would move, so that nothing times the move and no row tells it."""
    source = tmp_path / "part.nc"
    place = ["--wcs", "G54=300,100,0"]
    source.write_text(HEAD.format(words="A0 C0") + move + "\nG1 X20 F500\nM2\n", encoding="utf-8")
    refused = run("check", source, *OPTIONS, *place)
    assert refused.code != 0
    assert "part.nc:4: VP202 error: the tool is along the axis of C while C turns by 45.000 deg" in refused.out
    source.write_text(HEAD.format(words="A0 C0") + move + " X20\nX30 A10\nM2\n", encoding="utf-8")
    assert run("check", source, *OPTIONS, *place).code == 0


@pytest.mark.parametrize(
    "moves",
    [
        "G1 A0 X20.031\nG0 X-28.531 C-41.096\nG1 A-17.885 C-14.199 Z37.2",
        "G1 X12.374 C28.89",
        "G1 X-5.902\nG1 A-2.489 C55.52 Z34.67\nG1 A-4.638 C-17.201 Z36.82",
        "G1 X-1.233\nG0 X-2.538 C-75.182",
        "G3 X0 Y10 I-10 J0 C80\nG1 A-10 C20",
        "G0 X-76.4 Y5.6 Z28 A50 C-41\nG0 C-372.77",
        "G0 X-76.4 Y5.6 Z58 A50 C-41\nG0 Z69 A-50 C-396.9\nG1 C231.8",
    ],
)
def test_c_that_turns_with_an_upright_tool_is_no_false_finding(moves: str, run: Runner, tmp_path: Path) -> None:
    """The rows do not tell C while the tool stands upright, and little beside it: progress is what the tip says (no
    VP901).
    """
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text(HEAD.format(words="A0 C30") + moves + "\nM2\n", encoding="utf-8")
    place = ["--wcs", "G54=300,100,0"]
    answer = run("convert", source, *OPTIONS, *place, "-o", axes)
    assert answer.code == 0, answer.out + answer.err
    assert run("verify", axes, "--against", source, *OPTIONS, *place).code == 0


@pytest.mark.parametrize(("column", "by"), [("c_deg", 0.3), ("a_deg", 0.1), ("l2_mm", 0.05)])
def test_a_wrong_row_is_found(column: str, by: float, run: Runner, tmp_path: Path) -> None:
    """With the tool at 20 degrees 0.3 of c turn its axis by 0.1."""
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text(HEAD.format(words="A20 C30") + "X60 Y20\nX70 C40\nM2\n", encoding="utf-8")
    place = ["--wcs", "G54=300,100,0"]
    assert run("convert", source, *OPTIONS, *place, "-o", axes).code == 0
    head, *rows = axes.read_text(encoding="utf-8").splitlines(keepends=True)
    names = next(line for line in (head, *rows) if column in line).strip().split(",")
    at = len(rows) // 2
    for k in range(at, len(rows)):
        cells = rows[k].rstrip("\n").split(",")
        cells[names.index(column)] = f"{float(cells[names.index(column)]) + by:.6f}"
        rows[k] = ",".join(cells) + "\n"
    axes.write_text(head + "".join(rows), encoding="utf-8")
    refused = run("verify", axes, "--against", source, *OPTIONS, *place)
    assert refused.code != 0
    assert "VP411" in refused.out + refused.err


@pytest.mark.parametrize(
    ("machine", "start", "place", "height"),
    [("tricept", "1430,1480,1320,13,-55", "300,100,0", 600.0), ("george_v", "163,150,170,20,0", "0,0,0", 300.0)],
)
def test_an_approach_goes_back_to_machine_z_0(
    machine: str, start: str, place: str, height: float, run: Runner, tmp_path: Path
) -> None:
    """Machine Z is that of the wrist's centre against home, whatever the third strut or slider does; the end is where
    the program starts.
    """
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text("G21 G90 G94\nG0 X0 Y0 Z50 A10 C0\nG1 X20 F3000\nM2\n", encoding="utf-8")
    words = ["--machine", machine, "--tool-length", "100", "--wcs", f"G54={place}"]
    answer = run("convert", source, *words, "--from", start, "-o", axes)
    assert answer.code == 0, answer.out + answer.err
    loaded = verne_post.load_machine(machine)
    table = np.genfromtxt(axes, delimiter=",", names=True)
    rows = np.column_stack([table[f"{column.joint}_{column.unit}"] for column in loaded.columns])
    tip, axis, ok = loaded.forward(rows / [column.factor for column in loaded.columns], 100.0)
    assert ok.all()
    wrist = tip + 200.0 * axis
    first = np.flatnonzero(np.abs(wrist[:, 2] - height) < 1e-3)
    assert len(first)
    assert np.abs(np.cross(wrist[first[0]] - wrist[0], axis[0])).max() < 1e-3  # along the tool
    assert np.abs(rows[0] - [float(value) for value in start.split(",")]).max() < 1e-5
    assert np.abs(tip[-1] - [float(value) for value in place.split(",")] - [20, 0, 50]).max() < 1e-4
    assert run("verify", axes, "--against", source, *words, "--from", start).code == 0


def test_explain_and_machine_show(run: Runner, tmp_path: Path) -> None:
    source = tmp_path / "part.nc"
    source.write_text(HEAD.format(words="A20 C30") + "M2\n", encoding="utf-8")
    shown = run("explain", f"{source}:3", "--all", *OPTIONS, "--wcs", "G54=300,100,0").out
    assert "every solution of the whole machine: 2, of which 1 possible, 1 refused by geometry" in shown
    assert "the wrist on the other side of its pole" in shown
    senses = run("machine", "show", "tricept").out
    assert "# A +10: the tool leans towards -y of the part" in senses
