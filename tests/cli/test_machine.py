"""`machine identify` and `machine show --plot`: answers, exit status, refusals."""

import json
import re
import sys
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest

import verne_post

ROOT = Path(__file__).resolve().parents[2]
TABLE_III = ROOT / "tests" / "reference" / "table_iii.csv"
AS_PRINTED = ("--sigma-rho", "0.29", "--sigma-xyz", "0.003", "--sigma-alpha-deg", "inf", "--tie", "L2=L3")
MODULE = verne_post.load_machine().module


@pytest.fixture
def flat(tmp_path: Path) -> Path:
    """Poses on y = 0, where the platform does not tilt."""
    x, z = np.meshgrid([-200.0, 0.0, 200.0], [900.0, 1200.0])
    position = np.stack([x.ravel(), np.zeros(6), z.ravel()], axis=-1)
    rho = MODULE.inverse(position)[0]
    file = tmp_path / "flat.csv"
    rows = [",".join(f"{value:.6f}" for value in (*r, *p, 0.0)) for r, p in zip(rho, position, strict=True)]
    file.write_text("\n".join(["rho1_mm,rho2_mm,rho3_mm,x_mm,y_mm,z_mm,alpha_deg", *rows]) + "\n")
    return file


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slices of fewer points, for speed."""
    from verne_post.output import plots

    monkeypatch.setattr(plots, "RESOLUTION", 61)


class Serial:
    """A spindle carrier that has neither loop equations nor curves of equal tilt."""

    actuators = ("x", "y", "z")


@pytest.fixture
def serial(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every machine that is loaded is of another kind."""
    from verne_post.cli import machine

    plain = replace(verne_post.load_machine(), kind="serial", module=Serial())
    monkeypatch.setattr(machine, "load", lambda *_: plain)


# --- identify --------------------------------------------------------------------------------------


def test_table_iii_gives_a_table_to_paste(run: Callable[..., Any], tmp_path: Path) -> None:
    """What is printed makes a machine file, and its lengths round to the shipped ones."""
    answer = run("machine", "identify", TABLE_III, *AS_PRINTED)
    assert (answer.code, answer.err) == (0, "")
    assert "4 degrees of freedom" in answer.out
    pasted = tomllib.loads(answer.out[answer.out.index("[module]") :])
    assert pasted["provenance"] == {"module": f"identified from {TABLE_III}"}
    text = (ROOT / "machine_configs" / "verne.toml").read_text()
    shipped = tomllib.loads(text)["module"]
    assert {key: round(value) for key, value in pasted["module"].items()} == shipped
    assert list(pasted["module"]) == list(shipped)
    for key, value in pasted["module"].items():
        text = re.sub(rf"(?m)^{key} = \S+", f"{key} = {value}", text)
    file = tmp_path / "mine.toml"
    file.write_text(text.replace("identified from Table III of the paper", "identified from table_iii.csv"))
    assert run("machine", "validate", file).code == 0


def test_digits_taken_as_exact(run: Callable[..., Any]) -> None:
    """The numbers that a fit finds which knows nothing of rounding, all error in the rods."""
    options = (
        "--sigma-rho",
        "0",
        "--sigma-xyz",
        "0",
        "--sigma-alpha-deg",
        "inf",
        "--sigma-rod",
        "0.1",
        "--tie",
        "L2=L3",
    )
    data = json.loads(run("machine", "identify", TABLE_III, *options, "--json").out)
    found = {key: round(data["lengths_mm"][key], 1) for key in ("leg23_x_offset", "r4", "L2")}
    assert found == {"leg23_x_offset": 240.8, "r4": 565.4, "L2": 950.4}


def test_json_says_the_same(run: Callable[..., Any]) -> None:
    answer = run("machine", "identify", TABLE_III, *AS_PRINTED, "--starts", "3", "--json")
    data = json.loads(answer.out)
    assert (data["schema"], data["converged"], data["undetermined"]) == (1, True, [])
    assert data["uncertainties"] == {"rho_mm": 0.29, "xyz_mm": 0.003, "alpha_deg": None, "rod_mm": 0.0}
    text = run("machine", "identify", TABLE_III, *AS_PRINTED).out
    for name, value in data["lengths_mm"].items():
        assert f"{name} = {value:.4f}" in text
    assert f"chi-square {data['chi_square']:.4g} " in text
    assert sorted(row["line"] for row in data["residuals"]) == [4, 5, 6, 7]
    assert sum(start["count"] for start in data["starts"]) + data["failed_starts"] == 3
    assert np.shape(data["correlation"]) == (9, 9)


def test_readings_that_contradict_their_uncertainties_are_1(run: Callable[..., Any]) -> None:
    answer = run("machine", "identify", TABLE_III, *AS_PRINTED, "--sigma-rho", "0.001")
    assert answer.code == 1
    assert "contradict the stated uncertainties" in answer.out
    assert "# the readings contradict" in answer.out[answer.out.index("[module]") :]


def test_lengths_that_the_readings_cannot_tell_are_3_and_named(flat: Path, run: Callable[..., Any]) -> None:
    answer = run("machine", "identify", flat)
    assert answer.code == 3
    assert answer.out.count("not determined by these readings: ") == 4
    assert re.search(
        r"not determined by these readings: R1 \+\d\.\d\d with|not determined by these readings: .*R1 ", answer.out
    )
    assert "no [module] table: the readings do not determine every length" in answer.out
    assert "[module]\n" not in answer.out
    asked = re.search(r"--fix (\S+)\)", answer.out)
    assert asked
    held = run("machine", "identify", flat, "--fix", asked[1])
    assert held.code == 0
    assert held.out.count(" held ") == 4
    free = [name for name in MODULE.length_names if name not in asked[1].split(",")]
    assert run("machine", "identify", flat, "--free", ",".join(free)).out == held.out


def test_random_starts_are_reported(run: Callable[..., Any]) -> None:
    out = run("machine", "identify", TABLE_III, *AS_PRINTED, "--starts", "4").out
    assert "of 4 random starts:" in out
    assert re.search(r"  \d ended at chi-square 4\.4\d*: leg1_x_offset -320\.1", out)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--free", "R1,R9"), "'R9' is no length of this machine; they are leg1_x_offset"),
        (("--free", "R1", "--fix", "r1"), "exclude each other"),
        (("--fix", "leg1_x_offset,R1,r1,L1,leg23_x_offset,R2,r4,L2,L3"), "no length is left"),
        (("--tie", "L2"), "--tie L2: expected different lengths, such as L2=L3"),
        (("--tie", "L2=L3", "--tie", "L3=L1"), "each named once"),
        (("--tie", "L2=L3", "--fix", "L3"), "L3 is held"),
        (("--sigma-rho", "-1"), "--sigma-rho -1"),
        (("--sigma-xyz", "inf"), "--sigma-xyz inf"),
        (("--sigma-xyz", "nan"), "--sigma-xyz nan"),
        (("--sigma-xyz", "0"), "one of them must be above 0"),
        (("--sigma-rho", "0", "--sigma-alpha-deg", "0"), "contradict each other"),
        (("--machine", "none.toml"), "none.toml"),
    ],
)
def test_wrong_use_is_2(options: tuple[str, ...], says: str, run: Callable[..., Any]) -> None:
    answer = run("machine", "identify", TABLE_III, *options)
    assert (answer.code, answer.out) == (2, "")
    assert says in answer.err


def test_bad_files_are_2_with_their_line(run: Callable[..., Any], tmp_path: Path) -> None:
    file = tmp_path / "bad.csv"
    file.write_text(TABLE_III.read_text().replace("355.92", "355,92"))
    answer = run("machine", "identify", file)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"{file}:4: VP502 error: 10 values; expected 9")
    assert run("machine", "identify", tmp_path / "none.csv").code == 2
    assert run("machine", "identify", "-", *AS_PRINTED, stdin=TABLE_III.read_bytes()).code == 0


def test_a_kind_without_loop_equations_is_refused(serial: None, run: Callable[..., Any]) -> None:
    answer = run("machine", "identify", TABLE_III)
    assert (answer.code, answer.out) == (2, "")
    assert "(kind serial) cannot be identified" in answer.err


def test_identify_refuses_a_machine_as_built(tmp_path: Path, run: Callable[..., Any]) -> None:
    built = tmp_path / "built.toml"
    assert run("machine", "perturb", "--seed", "1", "-o", built).code == 0
    answer = run("machine", "identify", TABLE_III, "--machine", built)
    assert (answer.code, answer.out) == (2, "")
    assert "machine calibrate" in answer.err


# --- pictures ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [("--tool-length", "100", "--tilt", "20", "--plane", "xz"), ("--iso-alpha",)])
def test_png_and_svg_are_drawn(options: tuple[str, ...], coarse: None, run: Callable[..., Any], tmp_path: Path) -> None:
    for name in ("a.png", "b.SVG"):
        answer = run("machine", "show", "verne", "--plot", tmp_path / name, *options)
        assert (answer.code, answer.err) == (0, "")
        assert "schema" not in answer.out  # the picture comes in place of the file
    pixels = matplotlib.image.imread(tmp_path / "a.png")
    assert pixels.shape[0] > 300
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 50
    svg = (tmp_path / "b.SVG").read_text()
    assert svg.startswith("<?xml")
    assert svg.count("<path") > 50


def test_the_same_picture_has_the_same_bytes(run: Callable[..., Any], tmp_path: Path) -> None:
    for name in ("a.svg", "b.svg"):
        run("machine", "show", "--plot", tmp_path / name, "--iso-alpha")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_a_slice_says_how_far_it_reaches(coarse: None, run: Callable[..., Any], tmp_path: Path) -> None:
    """Ends on y = 0 from a grid of its own; each end is off by at most a step of either, 25 and 16 mm."""
    out = run("machine", "show", "--plot", tmp_path / "a.png", "--plane", "xz", "--tool-length", "80").out
    said = re.search(
        r"reached: x from (-?\d+) to (-?\d+) mm, z from (-?\d+) to (-?\d+) mm; ended by: .*at its lower end", out
    )
    assert said
    from verne_post.kinematics.workspace import classify

    x, z = (axis.ravel() for axis in np.meshgrid(np.arange(-700.0, 700.0, 16.0), np.arange(-600.0, 900.0, 16.0)))
    tip = np.stack([x, 0 * x, z], axis=-1)
    inside = tip[classify(verne_post.load_machine(), tip, np.zeros(2), 80.0).reached]
    ends = [inside[:, 0].min(), inside[:, 0].max(), inside[:, 2].min(), inside[:, 2].max()]
    assert [float(text) for text in said.groups()] == pytest.approx(ends, abs=41)


def test_a_slice_where_nothing_is_reached_is_moved_to_the_middle(
    coarse: None, run: Callable[..., Any], tmp_path: Path
) -> None:
    """The spindle of ac_trunnion reaches z from 21 to 570 mm, as a slice through it says; 300 is the nearest step."""
    beside = run("machine", "show", "ac_trunnion", "--plot", tmp_path / "a.png", "--plane", "xz").out
    said = re.search(r": y = 0 mm; .*z from (-?\d+) to (-?\d+) mm", beside)
    assert said
    low, high = map(float, said.groups())
    assert low > 0
    moved = run("machine", "show", "ac_trunnion", "--plot", tmp_path / "a.png")
    place = re.search(r": z = (\d+) mm \(the middle of what is reached, as nothing is at z = 0;", moved.out)
    assert place, moved.err
    assert float(place[1]) == pytest.approx((low + high) / 2, abs=30)
    given = run("machine", "show", "ac_trunnion", "--plot", tmp_path / "a.png", "--at", "0")
    assert given.code == 2
    assert "is reached in this plane; choose another --at" in given.err
    tilted = run("machine", "show", "ac_trunnion", "--plot", tmp_path / "a.png", "--tilt", "160")
    assert "these angles; --tilt 160 is outside the travel of A, -120 to 30 deg" in tilted.err


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--plot", "a.pdf"), "expected a name that ends in .png or .svg"),
        (("--plot", "a"), "expected a name that ends in .png or .svg"),
        (("--plot", "none/a.png"), "the folder does not exist"),
        (("--tilt", "3"), "--tilt is about a picture: name its file with --plot"),
        (("--iso-alpha",), "--iso-alpha is about a picture"),
        (("--plot", "a.png", "--iso-alpha", "--at", "3"), "--at: --iso-alpha draws places of the platform"),
        (("--plot", "a.png", "--tool-length", "-3"), "--tool-length -3: a tool length lies between"),
        (("--plot", "a.png", "--tilt", "nan"), "--tilt nan: expected a number"),
        (("--plot", "a.png", "--at", "5000"), "is reached in this plane; choose another --at"),
        (("--plot", "a.png", "--plane", "zz"), "'zz' is not one of"),
    ],
)
def test_wrong_pictures_are_2(
    options: tuple[str, ...], says: str, run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = run("machine", "show", "verne", *options)
    assert (answer.code, answer.out) == (2, "")
    assert says in answer.err
    assert not list(tmp_path.iterdir())


def test_without_matplotlib_the_extra_is_named(
    run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    answer = run("machine", "show", "--plot", tmp_path / "a.png")
    assert (answer.code, answer.out) == (2, "")
    assert "pip install 'matplotlib>=" in answer.err


def test_a_kind_without_equal_tilt_is_refused(serial: None, run: Callable[..., Any], tmp_path: Path) -> None:
    answer = run("machine", "show", "--plot", tmp_path / "a.png", "--iso-alpha")
    assert (answer.code, answer.out) == (2, "")
    assert "(kind serial) has no curves of equal tilt" in answer.err


@pytest.mark.parametrize("name", ["hexapod", "ca_fork_head", "bc_trunnion"])
def test_a_slice_of_any_machine_is_one_of_its_part_frame(name: str, run: Callable[..., Any], tmp_path: Path) -> None:
    """Tips that count as reached are those whose joints, by the machine's inverse in the part frame, keep every
    travel.
    """
    from verne_post.model.moves import AXES, Frame
    from verne_post.output.plots import reach_of_slice, slice_grid

    machine = verne_post.load_machine(name)
    words = np.zeros(len(AXES))
    words[list(machine.coordinates.rotary)] = (12.0, 25.0)
    _tip, angles = machine.coordinates.map_to_table(words, Frame())
    across, up, reach = reach_of_slice(machine, "xy", -30.0 if name == "ca_fork_head" else 40.0, angles, 70.0)
    tips = slice_grid("xy", -30.0 if name == "ca_fork_head" else 40.0, across, up)
    axis = np.broadcast_to(machine.coordinates.find_tool_axis(words.tolist(), Frame()), tips.shape)
    q, ok = machine.inverse(tips, axis, 70.0)
    n = len(machine.actuators)
    inside = ok & ((q >= machine.limits.lower) & (q <= machine.limits.upper))[:, :n].all(axis=1)
    assert (inside | ~reach.reached).all()
    assert reach.reached.sum() > 100
    if name != "hexapod":  # which has cones and a Jacobian too
        assert (inside == reach.reached).all()
    answer = run("machine", "show", name, "--plot", tmp_path / "a.png", "--tilt", "12", "--rotary", "25", "--at", "40")
    assert answer.code == 0, answer.err
    assert "reached: x from" in answer.out


@pytest.mark.parametrize(
    ("name", "kind"),
    [("verne", "kind verne"), ("ab_table", "schema 2, [chain]"), ("tricept", "schema 2, [carrier]")],
)
def test_messages_name_a_machine_by_what_its_file_has(run: Callable[..., Any], name: str, kind: str) -> None:
    """A file of schema 2 has no key `kind` at its top, but a table that people can look for, in the docs too."""
    assert f" ({kind}) is sound; " in run("machine", "validate", name).out
    table, text = kind.rpartition("[")[2].rstrip("]"), run("machine", "show", name).out
    assert f"\n[{table}]" in text if "[" in kind else '\nkind = "verne"' in text
    assert f"`{kind}`" in (Path(__file__).parents[2] / "docs/machine-file.md").read_text("utf-8") or name == "verne"


def test_a_carrier_without_legs_is_told_which_there_are(run: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(run("machine", "show", "verne").out + '\n[carrier]\nkind = "rods"\n', encoding="utf-8")
    told = run("machine", "validate", path).err
    assert "[carrier], the platform of a parallel machine, belongs to schema 2" in told
    assert "expected its key struts or rods" in told
