"""`machine perturb`, `calibrate` and `tolerances`: files, answers, exit status, refusals."""

import json
import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest

import verne_post
from verne_post.calibration.as_built import plan as planning


@pytest.fixture(scope="module")
def shop(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a simulated machine, a plan that is filled in, and the machine file calibrated from it."""
    from verne_post.cli.main import main

    folder = tmp_path_factory.mktemp("shop")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(planning, "CANDIDATES", 500)
        for words in (
            "perturb --seed 1 -o true.toml",
            "calibrate --plan 30 --simulate true.toml --seed 4 -o plan.csv",
            "calibrate plan.csv -o mine.toml --plot errors.png",
        ):
            assert main(["machine", *words.split()]) == 0
        yield folder


@pytest.fixture
def inside(shop: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(shop)
    return shop


def numbers(text: str, start: str) -> list[float]:
    """The numbers of the line that begins with some words."""
    line = next(line for line in text.splitlines() if line.startswith(start))
    return [float(word) for word in re.findall(r"[-+]?\d+\.\d+", line)]


# --- perturb -----------------------------------------------------------------------------------------


def test_a_perturbed_machine_is_sound_and_says_so(inside: Path, run: Callable[..., Any]) -> None:
    answer = run("machine", "validate", "true.toml")
    assert answer.code == 0
    assert "as_built: perturbed with seed 1, sigma 0.05 mm and 0.1 mrad" in answer.out
    again = run("machine", "perturb", "--machine", "true.toml", "--seed", "1", "-o", "again.toml")
    assert again.code == 0
    assert (inside / "again.toml").read_bytes() == (inside / "true.toml").read_bytes()


def test_a_file_may_be_called_dash(inside: Path, run: Callable[..., Any]) -> None:
    assert run("machine", "perturb", "--seed", 1, "-o", "./-").code == 0
    assert Path("./-").is_file()
    assert "the name is empty" in run("machine", "perturb", "--seed", 1, "-o", "").err


def test_sigmas_scale_the_same_draw(inside: Path, run: Callable[..., Any]) -> None:
    assert (
        run("machine", "perturb", "--seed", "1", "--sigma-mm", "0.025", "--sigma-mrad", "0.2", "-o", "half.toml").code
        == 0
    )
    one, half = (verne_post.load_machine(name).five_axis.deviations for name in ("true.toml", "half.toml"))
    assert half.rod_lengths == pytest.approx(0.5 * one.rod_lengths, abs=1e-6)
    assert half.guides == pytest.approx(2.0 * one.guides, abs=1e-9)


def test_machines_without_an_as_built_model_are_refused(tmp_path: Path, run: Callable[..., Any]) -> None:
    output = tmp_path / "x.toml"
    for words in (
        ("perturb", "--seed", "1", "-o", output),
        ("tolerances",),
        ("calibrate", "--plan", "5", "-o", tmp_path / "p.csv"),
    ):
        assert "Only for machines of kind verne." in " ".join(run("machine", words[0], "--help").out.split())
        for name, kind in (
            ("serial", "kind serial"),
            ("hexapod", "schema 2, [carrier]"),
            ("ca_fork_head", "schema 2, [chain]"),
        ):
            answer = run("machine", *words, "--machine", name)
            assert answer.code == 2
            text = " ".join(answer.err.split())
            assert f"{name}: this command works only for machines of kind verne; this one is {kind}" in text
            assert "as_built" not in text
    assert not output.exists()
    assert run("machine", "perturb", "--seed", "1", "--sigma-mm", "-1", "-o", output).code == 2


# --- calibrate -----------------------------------------------------------------------------------------


def test_thirty_planned_readings_calibrate_the_machine(inside: Path) -> None:
    """The file written makes joints with which the true machine stands within micrometres of the program."""
    true, mine, nominal = (verne_post.load_machine(name) for name in ("true.toml", "mine.toml", "verne"))
    rng = np.random.default_rng(3)
    tip = np.stack([*rng.uniform(-120, 120, (2, 300)), rng.uniform(0, 150, 300)], axis=1)
    angles = np.stack([rng.uniform(-0.9, 0.9, 300), rng.uniform(-3, 3, 300)], axis=1)
    off = []
    for machine in (nominal, mine):
        joints = machine.five_axis.find_joints(tip, angles, 100.0)
        off.append(np.linalg.norm(true.forward(joints, 100.0)[0] - tip, axis=1))
    assert np.median(off[0]) > 0.05
    assert np.nanmax(off[1]) < 0.02
    assert mine.provenance["as_built"] == "calibration from plan.csv, 30 readings"


def test_the_report_says_what_the_readings_tell(inside: Path, run: Callable[..., Any]) -> None:
    answer = run("machine", "calibrate", "plan.csv", "-o", "again.toml")
    assert (answer.code, answer.err) == (0, "")
    assert (inside / "again.toml").read_bytes() == (inside / "mine.toml").read_bytes()
    before, after = (numbers(answer.out, f"{when}, with the file") for when in ("before", "after"))
    assert before[0] > 40.0 > 10.0 > after[0] > 0.5
    assert "of 58 directions of the deviations are known better than before" in answer.out
    assert "at 90 degrees of freedom" in answer.out
    assert "each reading predicted from others" in answer.out


def test_json_says_the_same(inside: Path, run: Callable[..., Any]) -> None:
    answer = run("machine", "calibrate", "plan.csv", "-o", "again.toml", "--json")
    assert (answer.code, answer.err) == (0, "")
    data = json.loads(answer.out)
    assert (data["schema"], data["left_out"], data["contradicted"], data["drift_mm"]) == (1, [], False, None)
    assert data["readings"] == {"tools": 30, "lengths": 0, "blank": 0}
    assert data["degrees_of_freedom"] == 90
    written = tomllib.loads(Path("again.toml").read_text())["as_built"]
    for key, value in data["as_built"].items():
        assert np.array(written[key]) == pytest.approx(np.array(value), abs=1e-7)
    text = run("machine", "calibrate", "plan.csv", "-o", "again.toml").out
    median, high, worst = numbers(text, "after, with the file")[:3]
    after = data["workspace"]["after"]["tip_mm"]
    assert [1e3 * after[key] for key in ("median", "p95", "max")] == pytest.approx([median, high, worst], abs=0.06)
    assert f"{data['determined']} of 58 directions" in text


def test_the_picture_is_one(inside: Path) -> None:
    height, width, _colours = matplotlib.image.imread(inside / "errors.png").shape
    assert height > 500
    assert width > 500


def test_a_bad_reading_is_named_and_left_out(inside: Path, run: Callable[..., Any]) -> None:
    lines = Path("plan.csv").read_text().splitlines()
    cells = lines[12].split(",")
    cells[7] = f"{float(cells[7]) - 1.0:.4f}"
    Path("bad.csv").write_text("\n".join([*lines[:12], ",".join(cells), *lines[13:]]) + "\n")
    answer = run("machine", "calibrate", "bad.csv", "-o", "bad.toml")
    assert answer.code == 0
    assert re.search(r"left out: line 13, from what the others say: x [-+]0\.0\d+ mm, y -\S+ mm", answer.out)
    assert numbers(answer.out, "left out")[1] == pytest.approx(-1.0, abs=0.05)
    assert "calibration from bad.csv, 29 readings" in Path("bad.toml").read_text()


def test_readings_that_contradict_their_uncertainties_write_nothing(inside: Path, run: Callable[..., Any]) -> None:
    answer = run("machine", "calibrate", "plan.csv", "--sigma-mm", "0.0005", "-o", "wrong.toml")
    assert answer.code == 1
    assert "the readings contradict the stated uncertainties" in answer.out
    assert "not written" in answer.err
    assert not Path("wrong.toml").exists()
    assert not Path("wrong.covariance.csv").exists()


def test_readings_that_are_no_place_of_the_machine(inside: Path, run: Callable[..., Any]) -> None:
    lines = Path("plan.csv").read_text().splitlines()
    Path("far.csv").write_text("\n".join([*lines[:4], re.sub(r"^[^,]*", "5000", lines[4]), *lines[5:]]) + "\n")
    answer = run("machine", "calibrate", "far.csv", "-o", "wrong.toml")
    assert answer.code == 2
    assert "far.csv:5: VP502 error: no position of the platform fits these joints" in answer.err
    rows = [line.split(",") for line in lines[1:]]
    Path("inch.csv").write_text(
        "\n".join([lines[0], *(",".join([*r[:6], *(str(float(x) / 25.4) for x in r[6:9]), r[9]]) for r in rows)]) + "\n"
    )
    answer = run("machine", "calibrate", "inch.csv", "-o", "wrong.toml")
    assert answer.code == 3
    assert "30 of 30 readings are farther off than any machine" in answer.err
    assert not Path("wrong.toml").exists()


def test_a_machine_far_beyond_its_tolerances_is_told(inside: Path, run: Callable[..., Any]) -> None:
    answer = run(
        "machine", "calibrate", "plan.csv", "--tolerance-mm", "0.004", "--tolerance-mrad", "0.01", "-o", "wrong.toml"
    )
    assert answer.code == 1
    assert "or the machine its tolerances" in answer.out


def test_a_warm_machine_is_touched_up(inside: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Rods of leg II grow by 0.06 mm; six reference readings find it."""
    from verne_post.calibration.as_built.machine_text import write_machine_text
    from verne_post.model.deviations import Deviations

    monkeypatch.setattr(planning, "CANDIDATES", 300)
    true = verne_post.load_machine("true.toml").five_axis.deviations.pack_vector()
    true[38:40] += 0.06
    Path("warm.toml").write_text(
        write_machine_text(Path("true.toml").read_bytes(), Deviations.build_from_vector(true), "warm", "w")
    )
    plan = "calibrate --plan 6 --machine mine.toml --touch-up --simulate warm.toml --seed 9 -o ref.csv"
    assert run("machine", *plan.split()).code == 0
    answer = run("machine", "calibrate", "ref.csv", "--machine", "mine.toml", "--touch-up", "-o", "touched.toml")
    assert answer.code == 0
    for leg, grown in (("I ", 0.0), ("II ", 0.06), ("III ", 0.0)):
        told, sigma = numbers(answer.out, f"  growth of the rods, leg {leg}")
        assert abs(told - grown) < 4 * sigma < 0.12
    before, after = (numbers(answer.out, f"{when}, with the file") for when in ("before", "after"))
    assert before[0] > 5 * after[0]
    assert Path("touched.covariance.csv").exists()


def test_a_touch_up_needs_the_covariance_of_its_machine(inside: Path, run: Callable[..., Any]) -> None:
    missing = run("machine", "calibrate", "plan.csv", "--machine", "true.toml", "--touch-up", "-o", "x.toml")
    assert missing.code == 2
    assert "true.covariance.csv is missing" in missing.err
    other = run(
        "machine",
        "calibrate",
        "plan.csv",
        "--machine",
        "true.toml",
        "--touch-up",
        "--covariance",
        "mine.covariance.csv",
        "-o",
        "x.toml",
    )
    assert other.code == 2
    assert "belongs to another machine file" in other.err
    assert not Path("x.toml").exists()


def test_a_plan_is_a_program_and_a_file_to_fill_in(
    inside: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planning, "CANDIDATES", 300)
    answer = run("machine", "calibrate", "--plan", "5", "--tool-length", "80", "--dwell", "1", "-o", "blank.csv")
    assert answer.code == 0
    assert Path("blank.csv").read_text().count(",,,pose") == 5
    assert Path("blank.nc").read_text().count("G4 P1\n") == 5
    assert run("check", "blank.nc").code == 0
    empty = run("machine", "calibrate", "blank.csv", "-o", "x.toml")
    assert empty.code == 2
    assert "no row has a measured value" in empty.err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("-o x.toml", "READINGS.csv is missing"),
        ("plan.csv -o x.toml --at 0,0,5", "--at is about poses to measure"),
        ("plan.csv -o x.toml --dwell 0", "--dwell is about poses to measure"),
        ("plan.csv -o x.toml --drift-mm 0.1", "goes with --touch-up"),
        ("plan.csv -o x.toml --seed 0", "--simulate"),
        ("plan.csv -o x.toml --sigma-mm 0", "--sigma-mm 0"),
        ("plan.csv -o x.toml --sigma-rho -1", "--sigma-rho -1"),
        ("plan.csv -o x.toml --tolerance-mm 0", "--tolerance-mm 0"),
        ("plan.csv -o x.toml --touch-up --tolerance-mm 0.1", "leave --tolerance-mm"),
        ("plan.csv -o x.toml --covariance c.csv --tolerance-mrad 0.1", "leave --tolerance-mm"),
        ("--plan 8 -o x.csv --lengths len.csv", "goes with READINGS.csv"),
        ("--plan 8 -o x.csv --sigma-mrad 5", "goes with READINGS.csv"),
        ("plan.csv -o x.toml --plot x.pdf", ".png or .svg"),
        ("plan.csv -o plan.csv", "this is the file of"),
        ("--plan 5 -o x.nc", "names the empty file of readings"),
        ("--plan 5 -o x.csv --plot x.png", "leave it out"),
        ("--plan 5 -o x.csv --json", "leave it out"),
        ("--plan 5 -o x.csv --at 1,2", "three numbers"),
        ("--plan 5 -o x.csv --at 900,0,5", "keep every limit"),
        ("--plan 5 -o x.csv --tool-length -5", "--tool-length -5"),
        ("--plan 5 -o x.csv --simulate verne", "has no [as_built]"),
    ],
)  # fmt: skip
def test_wrong_use_is_told(
    inside: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, words: str, says: str
) -> None:
    monkeypatch.setattr(planning, "CANDIDATES", 300)
    answer = run("machine", "calibrate", *words.split())
    assert answer.code == 2
    assert says in answer.err
    assert not Path("x.toml").exists()


# --- tolerances ----------------------------------------------------------------------------------------


def test_tolerances_rank_the_parts(run: Callable[..., Any]) -> None:
    answer = run("machine", "tolerances", "--tool-length", "100", "--all")
    assert answer.code == 0
    lines = answer.out.splitlines()
    assert len(lines) == 2 + 58 + 1
    assert lines[2].startswith("rod_lengths_mm, rod I")
    rms = [float(line.split()[-4]) for line in lines[2:-1]]
    assert rms == sorted(rms, reverse=True)
    doubled = run("machine", "tolerances", "--tool-length", "100", "--tolerance-mm", "0.1", "--tolerance-mrad", "0.2")
    assert numbers(doubled.out, "all together") == pytest.approx(
        [2 * x for x in numbers(answer.out, "all together")], rel=1e-3
    )
    assert "and 43 less (--all)" in doubled.out


# --- docs ------------------------------------------------------------------------------------------------


def test_a_machine_is_named_as_an_argument_too(run: Callable[..., Any], tmp_path: Path) -> None:
    """`machine show` takes NAME|FILE; `axis-check` and `tolerances` took only --machine."""
    words = ("--at", "600,600,600,0,0", "-o")
    by_argument = run("machine", "axis-check", "verne", *words, tmp_path / "a")
    assert by_argument.code == 0, by_argument.err
    assert by_argument.out == run("machine", "axis-check", "--machine", "verne", *words, tmp_path / "b").out
    told = run("machine", "tolerances", "verne", "--machine", "ours.toml")
    assert told.code == 2
    assert "the machine is given twice: verne, and --machine ours.toml" in told.err
