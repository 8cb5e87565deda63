"""`explain`: a line from words to sliders, its solutions and findings, and proposals that hold when they are
followed.
"""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post as vp
import verne_post.app.explain as explain_app
from verne_post import load_machine
from verne_post.app.explain_line import is_axis_named
from verne_post.app.python_names import name_in_python
from verne_post.app.remedies.lines import Line, Trial
from verne_post.cli.main import main
from verne_post.config import list_machine_files, schema
from verne_post.config.carrier import CarrierFile
from verne_post.gcode.block import KEYWORDS
from verne_post.gcode.expressions import FUNCTIONS
from verne_post.gcode.known_words import describe_values, describe_word, list_meanings, list_words
from verne_post.gcode.siemens import values as siemens_values
from verne_post.model.codes import CODES

ROOT = Path(__file__).resolve().parents[2]
OPTIONS = ("--tool-length", "120", "--wcs", "G54=0,0,60")
NUMBER = r"(-?\d+(?:\.\d+)?)"


def lines(*texts: str) -> str:
    return "".join(f"{text}\n" for text in texts)


PROGRAM = lines("G49 G0 X0 Y0 Z120 A0 C0", "G1 Z100 A60 F2000", "G1 A101", "M2")


@pytest.fixture
def explain(run: Callable[..., Any], tmp_path: Path) -> Callable[..., str]:
    """Text about one line of a program, with every step."""

    def told(program: str, line: int, *options: object) -> str:
        path = tmp_path / "part.nc"
        path.write_text(program, encoding="utf-8")
        answer = run("explain", f"{path}:{line}", "--all", *options)
        assert (answer.code, answer.err) == (0, "")
        return answer.out

    return told


@pytest.fixture
def codes(run: Callable[..., Any], tmp_path: Path) -> Callable[..., set[str]]:
    """Codes of the findings of a program, of errors unless warnings are asked for."""

    def judged(program: str, *options: object, warnings: bool = False) -> set[str]:
        path = tmp_path / "judged.nc"
        path.write_text(program, encoding="utf-8")
        report = json.loads(run("check", path, *options, "--output-format", "json").out)
        found = report["programs"][0]["findings"]
        return {item["code"] for item in found if warnings or item["severity"] == "error"}

    return judged


def vector(text: str, name: str) -> np.ndarray:
    """The numbers in parentheses behind a name."""
    found = re.search(re.escape(name) + rf"\({NUMBER}, {NUMBER}, {NUMBER}\)", text)
    assert found, name
    return np.array([float(number) for number in found.groups()])


def scalar(text: str, pattern: str) -> float:
    found = re.search(pattern + NUMBER, text)
    assert found, pattern
    return float(found[1])


def rod_lengths(position: np.ndarray, alpha: float, rho: np.ndarray) -> np.ndarray:
    """The four rods of the VERNE for a pose, less their lengths: equations (3) to (6)."""
    x, y, z = position
    c, s = np.cos(alpha), np.sin(alpha)
    ends = [
        (x - 320.0, y + 130.0 * c - 80.0, z + 130.0 * s - rho[0]),
        (x - 320.0, y - 130.0 * c + 80.0, z - 130.0 * s - rho[0]),
        (x + 240.0, y - 190.0 * c + 565.0, z - 190.0 * s - rho[1]),
        (x + 240.0, y + 190.0 * c - 565.0, z + 190.0 * s - rho[2]),
    ]
    return np.linalg.norm(ends, axis=1) - [850.0, 850.0, 950.0, 950.0]


# --- what is asked first ---------------------------------------------------------------------------


def test_the_first_answer_is_short(explain: Callable[..., str], run: Callable[..., Any], tmp_path: Path) -> None:
    """Line, what is wrong by how much, its place once, what would settle it, the pose; steps and solutions are more."""
    program = lines("G49 G0 X0 Y0 Z120 A0 C0", "G1 Z800 F900", "M2")
    whole = explain(program, 2, "--tool-length", "60")
    answer = run("explain", tmp_path / "part.nc:2", "--tool-length", "60")
    shown = answer.out.splitlines()
    assert len(shown) <= 26  # a terminal of 30 lines shows it with the prompt
    assert shown[0] == "line 2: G1 Z800 F900"
    assert shown[-1] == "--all shows each step, every margin and every solution"
    assert whole.startswith("\n".join(shown[:-1]) + "\n\nfrom words to joints")
    text = answer.out
    for joint, excess in (("rho1", "95.875"), ("rho2", "149.211"), ("rho3", "149.211")):
        assert re.search(
            rf"VP101 error: slider . \({joint}\) reaches -\S+ mm, {excess} mm below its travel of 50 to 1250 mm\n", text
        )
    assert text.count("at 100 % of the way") == 1
    assert "the line ended elsewhere: Z 650.787 in place of 800 mm" in text
    assert f"Fill in wcs.G54 in {tmp_path}/part.nc.toml" in text  # VP033, with the name to paste
    assert f"setup {tmp_path}/part.nc --tool-length 60 writes" in text
    joints = "rho1 -45.875 mm, rho2 -99.211 mm, rho3 -99.211 mm, a 0.000 deg"
    assert f"joints               {joints}" in text
    assert "margin to travel     rho1 -95.875 mm, rho2 -149.211 mm, rho3 -149.211 mm, a 95.000 deg, c unlimited" in text
    assert "nearest limit        travel of rho2, exceeded" in text
    # from Z 120 to 800 at 900 mm/min
    assert f"time                 {680 / 15:.3f} s at the feed rate, without acceleration" in text
    assert "margin to its travel" not in text
    assert "every solution of" not in text
    assert vector(text, "tip on the table     ") == pytest.approx([0, 0, 800], abs=1e-6)


def test_places_that_differ_are_told_each(explain: Callable[..., str]) -> None:
    """Two sliders are lowest at two places of the line, and the tilt is largest at its end."""
    text = explain(
        lines("G49 G0 X0 Y0 Z120 A0 C0", "G1 Z690 F900", "G1 Z100 A101 F900", "M2"), 3, "--tool-length", "60"
    )
    assert len(re.findall(r"VP10\d error: .*\n    at \S+ % of the way", text)) == 3


def test_the_head_is_no_table_and_its_angles_are_words(run: Callable[..., Any]) -> None:
    """A nutating head: nominal angles stood beside words of the same letters, and a table was named that is none."""
    program = ROOT / "gcode_samples/blade_5axis.nc"
    text = run("explain", f"{program}:312", "--machine", "nutating_head").out
    place = re.search(rf"at 100 % of the way: tip .*, words A {NUMBER}, C {NUMBER} deg", text)
    assert place is not None
    assert [float(word) for word in place.groups()] == pytest.approx([69.0, -273.357], abs=1e-3)
    assert "the head must go from (A 68.945, C -270.000) to (A 68.945, C 90.000) deg" in text
    assert "no other head solution" in text
    assert "table" not in text.replace("on the table", "")


def test_all_is_for_lines(run: Callable[..., Any]) -> None:
    answer = run("explain", "VP102", "--all")
    assert answer.code == 2
    assert "--all is for a line of a program" in answer.err


# --- from words to joints ------------------------------------------------------------------------


def test_a_line_from_words_to_sliders(explain: Callable[..., str]) -> None:
    text = explain(PROGRAM, 2, *OPTIONS)
    assert text.startswith("line 2: G1 Z100 A60 F2000\n")
    assert "G1, G21 (mm), G90 (absolute), G94, G64, G54, tool length 120 mm, feed 2000 mm/min" in text
    assert "findings: none, the whole line is within limits\nNOT CHECKED: contact with fixtures and stock" in text
    assert "what would" not in text
    text = text.partition("from words to joints")[2]
    assert "X 0 mm (kept), Y 0 mm (kept), Z 100 mm (word Z100), A 60 deg (word A60), C 0 deg (kept)" in text
    # printed with six decimals
    near = {"abs": 1e-6, "rel": 0}
    assert vector(text, "o = ") == pytest.approx([0, 0, 60], **near)
    assert vector(text, "tip on the table     ") == pytest.approx([0, 0, 160], **near)
    assert vector(text, "cos A) = ") == pytest.approx([0, np.sqrt(0.75), 0.5], **near)
    gauge = vector(text, "+ (0, 0, l) = ")
    assert gauge == pytest.approx([0, -160 * np.sqrt(0.75), 80 + 120], **near)
    position, alpha = vector(text, "Rx(alpha) g = "), np.radians(scalar(text, "platform tilt alpha "))
    c, s = np.cos(alpha), np.sin(alpha)
    by_hand = [gauge[0], -(c * gauge[1] - s * gauge[2]), 1600 - (s * gauge[1] + c * gauge[2])]
    # six decimals of alpha in degrees turn the gauge point by 4e-6 mm
    assert position == pytest.approx(by_hand, abs=1e-5, rel=0)
    rho = np.array([scalar(text, rf"\n +.*rho{leg} ") for leg in (1, 2, 3)])
    assert rod_lengths(position, alpha, rho) == pytest.approx(np.zeros(4), abs=1e-5)
    assert scalar(text, r"rho3 \S+ mm, a ") == pytest.approx(60 + np.degrees(alpha), **near)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("PLANE SPATIAL SPA+10 SPB+0 SPC+0 TURN FMAX", ""),
        ("PLANE POINTS P1X+0 P1Y+0 P1Z+5 TURN FMAX", ""),
        ("L X+Q5 IY-2 R0 FMAX ; Z+3", "XY"),
        ("CP IPA+30 DR+", ""),
        ("L A+Q120 C+Q122 FMAX", "AC"),
        ("G1 X=R1 Y=AC(5) C=DC(R2)", "XYC"),
        ('MSG("X 5") G1 Z=IC(-R3)', "Z"),
        ("o1 call [5] [7]", ""),
        ("g1x[#1+2]y#2(z 5)", "XY"),
        ("GOTO/5,0,20", "XYZ"),
    ],
)
def test_axes_that_a_computed_line_names(text: str, named: str) -> None:
    assert "".join(letter for letter in "XYZABC" if is_axis_named(text, letter)) == named


def test_a_plane_names_no_axis(explain: Callable[..., str]) -> None:
    """The table turns and takes the tip along; the line has no X to be shown."""
    program = lines(
        "0 BEGIN PGM P MM",
        "1 TOOL CALL 1 Z S5000",
        "2 L X+10 Y+20 Z+80 A+0 C+0 R0 FMAX",
        "3 Q1 = 5",
        "4 PLANE SPATIAL SPA+10 SPB+0 SPC+0 TURN F2000",
        "5 L X+Q1 R0 F2000",
        "6 END PGM P MM",
    )
    place = ("--tool-length", "80", "--wcs", "G54=0,0,50")
    text = explain(program, 5, *place)
    assert re.search(r"program coordinates  X \S+ mm, Y \S+ mm, Z \S+ mm, A ", text)
    assert "as the line says" not in text
    assert re.search(r"X \S+ mm \(as the line says\), Y \S+ mm, ", explain(program, 6, *place))


def test_words_in_inches_with_a_shift_on_a_turned_part(explain: Callable[..., str]) -> None:
    program = lines("G20 G91 G43.5", "G90 G0 X1 Y0 Z2 I0 J0 K1", "G92 X0", "G91 G1 X1.5 I0.5 J0 K0.8660254 F30", "M2")
    text = explain(program, 4, "--tool-length", "80", "--wcs", "G54=0,0,50,90")
    assert "G1, G20 (inch), G91 (incremental)" in text
    assert "feed 762 mm/min" in text  # 30 in/min
    assert "X 38.1 mm (word X1.5 in), Y 0 mm (kept), Z 50.8 mm (kept)" in text
    assert "A 30 deg (of the tool axis), C 90 deg (of the tool axis)" in text
    assert "p = program coordinates + (X 25.4, Y 0, Z 0, A 0, C 0)" in text
    # 2.5 inches in x, turned by 90 degrees into y; the table stands at 90 - 90 degrees
    assert vector(text, "tip on the table     ") == pytest.approx([0, 63.5, 100.8], abs=1e-6)
    assert "nominal angles       A 30.000000 deg, C 0.000000 deg" in text
    assert vector(text, "cos A) = ") == pytest.approx([0, 0.5, np.sqrt(0.75)], abs=1e-6)


def test_machine_words_are_called_so(explain: Callable[..., str]) -> None:
    text = explain(lines("G49 G0 X0 Y0 Z120 A0 C0", "G53 G0 Z-100", "M2"), 2, *OPTIONS)
    # machine Z -100 is 450 over the rotary centre: 120 of tool and 60 of the part lie between
    assert "Z 270 mm (word Z-100 of G53)" in text


def test_the_approach_is_explained_without_words(explain: Callable[..., str]) -> None:
    text = explain(PROGRAM, 0, *OPTIONS, "--from", "home")
    assert text.startswith("line 0: the approach (--from)")
    assert vector(text, "tip on the table     ") == pytest.approx([0, 0, 180], abs=1e-6)


@pytest.mark.parametrize(
    ("name", "text", "told", "force"),
    [
        (
            "a.ngc",
            "G21 G90\nG0 X0 Y0 Z120 A0 C0\nT2 M6\nS5000\nF2400\nG1 X5\nM2\n",
            "F2400                feed rate, in mm/min",
            "feed 2400 mm/min, spindle off, S 5000 1/min, tool 2",
        ),
        (
            "a.mpf",
            "G710 G90 G94\nG0 X0 Y0 Z120 A=0 C=0\nT2 D1 M6\nM3 S=5000\nF=2400\nG1 X5\nM30\n",
            "F=2400               feed rate",
            "feed 2400 mm/min, spindle on, S 5000 1/min, tool 2",
        ),
        (
            "a.h",
            "BEGIN PGM A MM\nTOOL CALL 2 Z S5000\nL X+0 Y+0 Z+120 A+0 C+0 FMAX\nM3\nF2400\nL X+5\nM30\nEND PGM A MM\n",
            "F2400                feed rate",
            "feed 2400 mm/min, spindle on, S 5000 1/min, tool 2",
        ),
    ],
)
def test_every_word_of_a_line_is_told_and_its_value_is_in_force(
    name: str, text: str, told: str, force: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    path = tmp_path / name
    path.write_text(text)
    answer = run("explain", f"{path}:5", *OPTIONS).out
    assert told in answer and answer.splitlines()[-1].endswith(force), answer
    # past an error some values are assumed: none is told; the words around one that is not read are
    path.write_text(text.replace("0 C0", "0 Q C0").replace("C=0", "Q C=0").replace("+0 C+0", "+0 QQ C+0"))
    answer = run("explain", f"{path}:5", *OPTIONS).out
    assert told in answer and "spindle o" not in answer, answer
    refused = run("explain", f"{path}:3" if name == "a.h" else f"{path}:2", *OPTIONS).out
    assert "  X" in refused and "  C" in refused, refused


def test_a_line_without_motion_says_what_its_words_do(tmp_path: Path, run: Callable[..., Any]) -> None:
    path = tmp_path / "a.nc"
    path.write_text(
        lines("(head)", "G49 G0 X0 Y0 Z120 A0 C0", "Z100", "(here)", "G091S3 M03 G61", "G1 G90 X3 F900", "M2"),
        encoding="utf-8",
    )
    for line, near in ((4, "3 and 6"), (1, "3"), (5, "3 and 6")):
        answer = run("explain", f"{path}:{line}", *OPTIONS)
        assert answer.code == 0
        assert f"no motion; the nearest lines that have: {near}\n" in answer.out
    words = [line.split()[0] for line in answer.out.splitlines()[2:-1]]
    assert words == ["G091", "S3", "M03", "G61"]
    assert "spindle on, clockwise" in answer.out
    assert answer.out.splitlines()[-1].startswith("  in force: G0, G21 (mm), G91 (incremental), G94, G61")
    assert "a remark" in run("explain", f"{path}:4", *OPTIONS).out
    beyond = run("explain", f"{path}:99", *OPTIONS)
    told = " ".join(beyond.err.split())
    assert (beyond.code, "line 99 is after the end of the program, whose last line is 7" in told) == (2, True)
    unread = run("explain", f"{path}:1x", *OPTIONS)
    assert (unread.code, "'1x' is no line number; such as" in " ".join(unread.err.split())) == (2, True)


def test_a_code_names_the_page_of_its_section(run: Callable[..., Any]) -> None:
    told = run("explain", "G95").out
    assert "RS274/NGC: feed per turn of the spindle: see Feed modes G93, G94, G95 in docs/gcode.md" in told
    assert "Siemens: feed per turn of the spindle; a change sets F to 0" in told


@pytest.mark.parametrize("dialect", ["rs274", "fanuc", "siemens", "heidenhain", "aptcl"])
def test_a_word_has_one_meaning_of_its_own(dialect: str) -> None:
    """M1 of Siemens is the stop; M1=, the function of a spindle, is another word."""
    meanings = list_meanings(dialect, executed_alone=True)
    assert [name for name, texts in meanings.items() if len(texts) != 1] == []
    of_several = [text for texts in meanings.values() for text in texts if "clockwise, counter-clockwise" in text]
    assert of_several == []


def test_words_of_cl_files_are_explained(run: Callable[..., Any]) -> None:
    assert "APT: sets the feed rate: a number and its unit" in run("explain", "FEDRAT").out
    assert "APT: not executed: " in run("explain", "nurbs").out
    assert "APT: runs a subprogram" in run("explain", "CALSUB").out
    assert "APT: turns the table in rapid traverse; the tip stays" in run("explain", "ROTABL").out
    assert "APT: names the system of the model; a change is refused" in run("explain", "$$*CATIA0").out


# --- every solution --------------------------------------------------------------------------------


def rows(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith("  alpha ")]


def test_every_solution_closes_the_rods_and_says_why_it_is_refused(explain: Callable[..., str]) -> None:
    text = explain(PROGRAM, 2, *OPTIONS)
    assert text.count("in use") == 1
    counted = re.search(r"whole machine: (\d+), of which (\d+) possible, (\d+) refused by geometry\n", text)
    assert counted
    total, possible, geometry = map(int, counted.groups())
    found = rows(text)
    assert len(found) == total == possible + geometry
    assert sum("refused: " in row for row in found) == geometry
    gauge = {60.0: [0, -160 * np.sqrt(0.75), 200], -60.0: [0, 160 * np.sqrt(0.75), 200]}
    seen = set()
    for row in found:
        alpha, *rho, a = (scalar(row, name) for name in ("alpha +", "rho1 ", "rho2 ", "rho3 ", ", a "))
        nominal = round(a - alpha)
        assert nominal in gauge
        x, y, z = gauge[nominal]
        c, s = np.cos(np.radians(alpha)), np.sin(np.radians(alpha))
        position = np.array([x, -(c * y - s * z), 1600 - (s * y + c * z)])
        # four decimals in degrees move P and the arms by up to 1e-3 mm
        assert rod_lengths(position, np.radians(alpha), np.array(rho)) == pytest.approx(np.zeros(4), abs=2e-3)
        outside = [name for name, value in zip(("rho1", "rho2", "rho3"), rho, strict=True) if not 50 <= value <= 1250]
        outside += ["a"] if abs(a) > 95 else []
        assert re.findall(r"travel of (.*)", row) == ([", ".join(outside)] if outside else [])
        crossed = 130 * c <= 80
        assert ("rod crossing" in row) == crossed
        seen.add((nominal, row.split("  s ")[1][:10], round(alpha, 2)))
    assert len(seen) == total


def test_limits_that_refuse_solutions_are_named(explain: Callable[..., str]) -> None:
    text = explain("G0 X0 Y0 Z100 A0 C0\nG1 A101 F500\nM2\n", 2, *OPTIONS)
    counted = re.search(r"whole machine: (\d+), of which 0 possible, (\d+) refused by geometry, 2 by the (.*)\n", text)
    assert counted
    assert counted[3] == "travel of a"
    assert int(counted[1]) == int(counted[2]) + 2


@pytest.mark.parametrize(("name", "each"), [("serial", 1), ("linear_delta", 8)])
def test_other_machines_have_their_own_numbers_of_solutions(name: str, each: int, explain: Callable[..., str]) -> None:
    text = explain(PROGRAM, 2, "--machine", name, *OPTIONS)
    assert f"every solution of the whole machine: {2 * each}, of which 2 possible, {2 * each - 2} refused" in text
    assert f" this table solution, c 0.0000 deg: {each}\n" in text
    assert f" other table solution, c 180.0000 deg: {each}\n" in text
    assert text.count("in use") == 1


def test_solutions_of_an_as_built_machine_have_the_c_that_is_used(
    explain: Callable[..., str], run: Callable[..., Any], tmp_path: Path
) -> None:
    built = tmp_path / "built.toml"
    assert run("machine", "perturb", "--seed", "1", "-o", built).code == 0
    program = lines("G49 G0 X40 Y-30 Z80 A20 C30", "G1 X60 Y10 Z70 A25 C50 F800", "M2")
    for words in ((), ("--correct-axis",)):
        text = explain(program, 2, "--machine", built, *words, *OPTIONS)
        (row,) = [line for line in text.splitlines() if line.endswith("in use")]
        *_first, in_steps = re.findall(r"joints +(rho1 .*)", text)
        numbers, used = (re.findall(r"(?:rho\d|a) (-?[\d.]+)", part) for part in (in_steps, row))
        assert [f"{float(value):.4f}" for value in numbers] == used


def test_a_dry_run_has_the_length_of_the_tool(explain: Callable[..., str]) -> None:
    assert "tool length 80 mm" in explain(PROGRAM, 2, "--tool-length", "80", "--wcs", "G54=0,0,0", "--air", "30")


def test_margins_reach_to_clearances_and_the_table(explain: Callable[..., str], tmp_path: Path) -> None:
    """A spindle of radius 60 whose nose is 20 over the face: 40 short, and every solution says so."""
    file = tmp_path / "guarded.toml"
    original = list_machine_files()["verne"].read_text(encoding="utf-8")
    guard = '[clearance]\nminimum_mm = 5.0\nspindle_diameter_mm = 120.0\n\n[provenance]\nclearance = "assumed"\n'
    file.write_text(original.replace("[provenance]", guard), encoding="utf-8")
    program = lines("G49 G0 X0 Y0 Z100 A0 C0", "G1 Z5 F2000", "M2")
    text = explain(program, 2, "--machine", file, "--tool-length", "15")
    assert "distance of the spindle from the table -40.000 mm, must be above 5 (VP213)" in text
    assert "tip over the table face              5.000 mm, must be above 0 (VP210)" in text
    assert "nose over the table face             20.000 mm" in text
    assert "VP213 error: distance of the spindle from the table -40.000 mm is below 5 mm by 45.000 mm" in text
    assert "as programmed: refused: VP213 distance of the spindle from the table\n" in text
    assert "0 possible" in text
    assert 45 < scalar(text, r"along one axis of the program: Z \+") < 45.1


def test_a_line_beyond_the_tilt_names_the_joint(explain: Callable[..., str]) -> None:
    text = explain(PROGRAM, 3, *OPTIONS)
    assert "as programmed: refused: beyond the travel of a" in text
    assert "in use" not in text


# --- what would make it legal -------------------------------------------------------------------------

#: A line that leaves the travel of a slider or linear axis, by machine.
BEYOND = {
    "verne": ("G1 X30 Z650", ("G54=0,0,60", "50"), "rho2"),
    "serial": ("G1 X450 Y380 Z120", ("G54=0,0,60", "50"), "x"),
    "linear_delta": ("G1 X30 Z950", ("G54=0,0,60", "50"), "rho1"),
}


@pytest.mark.parametrize("name", BEYOND)
def test_the_move_proposed_makes_the_program_legal_and_is_the_smallest(
    name: str, explain: Callable[..., str], codes: Callable[..., set[str]]
) -> None:
    word, (place, tool), joint = BEYOND[name]
    program = lines("G49 G0 X0 Y0 Z300 A0 C0", f"{word} F900", "M2")
    options = ("--machine", name, "--tool-length", tool)
    assert codes(program, *options, "--wcs", place) == {"VP101"}
    text = explain(program, 2, *options, "--wcs", place)
    assert re.search(rf"VP101 error: [^;]*\b{joint}\b", text)
    proposed = re.search(r"\(then (G54 = .*?)\)", text)
    assert proposed
    assert codes(program, *options, "--wcs", proposed[1]) == set()
    was = np.array([0.0, 0.0, 60.0])
    shift = np.array([float(v) for v in proposed[1].partition("=")[2].split(",")]) - was
    # no move that is 2 per cent shorter does, in whatever direction: the end of the line stays outside
    machine = load_machine(name)
    numbers = {letter: float(value) for letter, value in re.findall(rf"([XYZ]){NUMBER}", word)}
    end = was + [numbers.get("X", 0.0), numbers.get("Y", 0.0), numbers["Z"]]
    ways = np.random.default_rng(5).normal(size=(4000, 3))
    ways = np.vstack([ways, shift]) / np.linalg.norm(np.vstack([ways, shift]), axis=1)[:, None]
    q, ok = machine.inverse(end + 0.98 * np.linalg.norm(shift) * ways, np.array([0.0, 0.0, 1.0]), float(tool))
    inside = ok & ((q >= machine.limits.lower) & (q <= machine.limits.upper)).all(axis=1)
    assert not inside.any()


@pytest.mark.parametrize("name", BEYOND)
def test_ends_proposed_make_the_program_legal_just_so(
    name: str, explain: Callable[..., str], codes: Callable[..., set[str]]
) -> None:
    word, (place, tool), _joint = BEYOND[name]
    options = ("--machine", name, "--tool-length", tool, "--wcs", place)
    program = lines("G49 G0 X0 Y0 Z300 A0 C0", f"{word} F900", "M2")
    (told,) = re.findall(r"the line ended elsewhere: (.*)", explain(program, 2, *options))
    ends = re.findall(rf"([XYZ]) {NUMBER} in place of {NUMBER} mm", told)
    assert ends
    for letter, new, old in ends:
        assert codes(_with(program, letter, float(new)), *options) == set(), letter
        back = float(new) + 0.01 * np.sign(float(old) - float(new))
        assert "VP101" in codes(_with(program, letter, back), *options), letter


def _with(program: str, letter: str, value: float) -> str:
    """The program with another word, or one more, in its second line."""
    first, second, *rest = program.splitlines()
    second = re.sub(rf" {letter}{NUMBER}", "", second) + f" {letter}{value:.4f}"
    return lines(first, second, *rest)


def test_less_tilt(explain: Callable[..., str], codes: Callable[..., set[str]]) -> None:
    text = explain(PROGRAM, 3, *OPTIONS)
    assert re.search(
        r"VP102 error: joint a reaches 96\.742 deg, 1\.742 deg above its travel of -95 to 95 deg\n"
        r"    at 100 % of the way",
        text,
    )
    tilt = scalar(text, "within limits if the line ends at A ")
    assert "instead of A 101," in text
    assert codes(PROGRAM.replace("A101", f"A{tilt:.3f}"), *OPTIONS) == set()
    assert codes(PROGRAM.replace("A101", f"A{tilt + 0.005:.3f}"), *OPTIONS) == {"VP102"}
    # no move of the part is proposed for a tilt
    assert "G54 =" not in text


@pytest.mark.parametrize(
    ("limits", "words", "proposed"),
    [
        ("a_deg = [-20.0, 110.0]", "A-50 C10", ("the other table solution", 50.0, 190.0)),
        ("a_deg = [-95.0, 95.0]\nc_deg = [-180.0, 180.0]", "A-50 C300", ("another turn of C", -50.0, -60.0)),
    ],
)
def test_the_other_branch(
    limits: str,
    words: str,
    proposed: tuple[str, float, float],
    explain: Callable[..., str],
    codes: Callable[..., set[str]],
    tmp_path: Path,
) -> None:
    file = tmp_path / "narrow.toml"
    original = list_machine_files()["verne"].read_text(encoding="utf-8")
    file.write_text(original.replace("a_deg = [-95.0, 95.0]", limits), encoding="utf-8")
    options = ("--machine", file, *OPTIONS)
    program = lines(f"G49 G0 X0 Y0 Z120 {words}", "G1 X20 F900", "M2")
    assert codes(program, *options) & {"VP102", "VP103"}
    name, a, c = proposed
    text = explain(program, 2, *options)
    assert f"{name}: line 1 ends at A {a:g}, C {c:g} with the same tool axis" in text
    assert codes(program.replace(words, f"A{a:g} C{c:g}"), *options) == set()


def test_out_of_reach_finds_the_way_back(explain: Callable[..., str], codes: Callable[..., set[str]]) -> None:
    program = lines("G0 X0 Y0 Z50 A0 C0", "G1 Y600 F1000", "M2")
    text = explain(program, 2, "--tool-length", "50")
    assert "no platform tilt alpha closes the legs in the working mode: VP110 out of reach" in text
    share = scalar(text, "VP110 error: .*\n    first at ")
    # the first place that cannot be reached, by the machine itself
    machine = load_machine()
    for w, reached in ((share / 100 - 1e-4, True), (share / 100 + 1e-4, False)):
        assert machine.inverse(np.array([0, 600 * w, 50.0]), np.array([0.0, 0.0, 1.0]), 50.0)[1] == reached
    proposed = re.search(r"\(then (G54 = .*?)\)", text)
    assert proposed
    assert codes(program, "--tool-length", "50", "--wcs", proposed[1]) == set()


def test_a_dip_below_the_table_between_legal_ends(explain: Callable[..., str]) -> None:
    text = explain(lines("G0 X-50 Y0 Z10 A0 C0", "G18 G2 X50 Z10 I50 K50 F1000", "M2"), 2, "--tool-length", "50")
    # the circle of radius sqrt(50^2 + 50^2) about (0, 60) dips to 60 - 70.710678
    assert "10.711 mm below the table face" in text
    assert "at 50 % of the way" in text
    low = scalar(text, r"along one axis of the program: Z \+")
    assert 10.710678 < low < 10.72
    # an arc has no end that could be named elsewhere on its own
    assert "ended elsewhere" not in text


def test_a_warning_is_removed_by_the_move_proposed(explain: Callable[..., str], codes: Callable[..., set[str]]) -> None:
    program = lines("G0 X0 Y0 Z50 A0 C0", "G1 Y572 F1000", "M2")
    options = ("--tool-length", "50")
    assert codes(program, *options) == set()
    assert codes(program, *options, "--wcs", "G54=0,0,0", warnings=True) == {"VP202"}
    text = explain(program, 2, *options)
    assert "what would remove the warnings" in text
    proposed = re.search(r"\(then (G54 = .*?)\)", text)
    assert proposed
    assert codes(program, *options, "--wcs", proposed[1], warnings=True) == set()


# --- codes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("file", sorted((ROOT / "tests" / "rejected").glob("*.nc")), ids=lambda file: file.stem)
def test_the_response_told_is_what_happens(file: Path, run: Callable[..., Any]) -> None:
    code = file.stem[:5].upper()
    head = file.read_text(encoding="utf-8", errors="replace").splitlines()[0]
    options = re.search(r"options: ([^)]*)", head)
    status = run("convert", file, *(options[1].split() if options else ())).code
    assert f"status {status}" in " ".join(run("explain", code).out.split())


def test_parameters_name_keys_and_options_that_exist(run: Callable[..., Any]) -> None:
    groups = {
        "limits": {
            *schema.describe_limits_table("rho", True).__struct_fields__,
            *schema.describe_limits_table("xyz", False).__struct_fields__,
        },
        "module": schema.VerneModuleFile.__struct_fields__,
        "spindle": schema.SpindleFile.__struct_fields__,
        "table": schema.TableFile.__struct_fields__,
        "home": schema.HomeFile.__struct_fields__,
        "rods": schema.RodsFile.__struct_fields__,
        "clearance": schema.ClearanceFile.__struct_fields__,
        "control": schema.ControlFile.__struct_fields__,
        "carrier": CarrierFile.__struct_fields__,
        "accuracy": schema.AccuracyFile.__struct_fields__,
        "joints": {"NAME"},  # of a chain
    }
    options = run("convert", "--help-all").out + run("machined", "--help-all").out
    told = 0
    for code in CODES:
        shown = " ".join(run("explain", code).out.split())
        text = shown.partition("Parameters: ")[2].partition(". Related: ")[0]
        told += bool(text)
        for group, key in re.findall(r"\b([a-z]+)\.(\w+)", text):
            assert key in groups[group], (code, group, key)
        for option in re.findall(r"--[a-z-]+", text):
            assert option in options, (code, option)
    assert told >= 28


def test_main_is_what_the_command_calls(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Line ends of Windows and a comment with foreign letters stay out of the way."""
    path = tmp_path / "dos.nc"
    path.write_bytes(b"G49 G0 X0 Y0 Z120 A0 C0\r\nG1 Z100 F900 (Fl\xe4che)\r\nM2\r\n")
    assert main(["explain", f"{path}:2", *OPTIONS]) == 0
    assert capsys.readouterr().out.startswith("line 2: G1 Z100 F900 (Fl")


def test_each_line_that_turns_the_table_has_the_warning(run: Callable[..., Any], tmp_path: Path) -> None:
    """One finding stands for all of them, and only its first line was told."""
    (program := tmp_path / "part.nc").write_text(
        "G21 G90\nG0 X0 Y0 Z60 A20 C-180\nG1 X1 C180 F900\nX2\nX3 C-180\nM30\n"
    )
    answer = run("check", program, *OPTIONS)
    assert "  3 | G1 X1 C180 F900\n    = Write C-180 in line 3; then add -360 deg" in answer.out
    for line in (3, 5):
        told = run("explain", f"{program}:{line}", *OPTIONS).out
        assert " (lines 3 and 5; the numbers are those of line 3)\n" in told
    assert "findings: none" in run("explain", f"{program}:4", *OPTIONS).out


def test_a_warning_about_words_proposes_no_move(explain: Callable[..., str]) -> None:
    program = lines("G49 F600 G0 X0 Y0 Z60 A0 C0", "G81 X5 Y5 Z-5 R3", "G91", "X-5 L2", "G80", "M2")
    out = explain(program, 4, "--wcs", "G54=0,0,60")
    assert "VP030 warning: G81 keeps R and Z of G90 in G91" in out
    assert "what would" not in out
    assert "nothing is proposed" not in out


def test_the_response_to_a_warning_about_words(run: Callable[..., Any], tmp_path: Path) -> None:
    assert "It is printed and does not stop the conversion" in run("explain", "VP030").out.replace("\n", " ")
    path = tmp_path / "part.nc"
    path.write_text(lines("G49 F600 G0 X0 Y0 Z60 A0 C0", "G81 X5 Y5 Z-5 R3", "G91 X-5", "G80", "M2"), "utf-8")
    wcs = ("--wcs", "G54=0,0,60")
    converted = run("convert", path, *wcs, "-o", tmp_path / "part.csv")
    assert converted.code == 0
    assert "VP030" in converted.err
    assert (tmp_path / "part.csv").exists()
    assert run("check", path, *wcs).code == 0
    assert run("check", path, *wcs, "--fail-level", "warning").code == 1
    assert "VP030" in run("dump", "moves", path).err


@pytest.mark.parametrize(
    ("word", "lines"),
    [
        ("G68.2", ("RS274/NGC: not executed: tilted work planes", "Fanuc: tilts the work plane, by angles")),
        ("CYCLE83", ("Siemens: deep-hole drilling", "  RTP: retraction plane", "  VARI")),
        ("PLANE", ("Klartext: a tilted plane: ", "  PLANE SPATIAL: turned about X")),
        ("PLANE SPATIAL", ("Klartext: tilts the work plane: turned about X",)),
        ("Q206", ("Klartext: a value of CYCL DEF 200, ",)),
        ("_DMODE", ("Siemens: a value of CYCLE81, ",)),
        ("traori", ("Siemens: tool-centre-point control on",)),
        ("CYCL DEF 208", ("Klartext: ",)),
        ("CYCL DEF 203", ("Klartext: universal drilling with chip breaking: see Cycles in docs/heidenhain.md",)),
        ("G41", ("Fanuc: the tool goes left of the contour: see Cutter compensation",)),
        ("FN 0", ("Klartext: sets a Q parameter",)),
        ("function tcpm", ("Klartext: tool-centre-point control on, as M128",)),
        ("FUNCTION MODE MILL", ("Klartext: milling",)),
        ("APPR LCT", ("Klartext, APPR: approaches the first point of the contour (LT, LN, CT, LCT",)),
        ("G61.1", ("RS274/NGC: exact stop at the end of every move: see Path control in docs/gcode.md",)),
        ("TRANS", ("Siemens: shifts the zero; replaces the frame in force", "APT: shifts nothing: one that")),
        ("cos", ("RS274/NGC: cosine", "Fanuc: cosine", "Siemens: cosine")),
        ("TRANS DATUM", ("Klartext, TRANS: shifts (DATUM AXIS), mirrors",)),
        ("M128", ("RS274/NGC: not executed: external programs", "Klartext: tool-centre-point control")),
    ],
)
def test_a_word_of_a_language_is_explained_from_its_tables(
    run: Callable[..., Any], word: str, lines: tuple[str, ...]
) -> None:
    answer = run("explain", word)
    assert answer.code == 0
    head, *rows = answer.out.splitlines()
    assert head == word.upper()
    for line in lines:
        assert [row for row in rows if row.startswith(f"  {line}")], (line, rows)


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("RS274/NGC", ("G5", "G5.1", "G5.2", "G5.3", "G61", "G61.1", "G64")),
        ("Siemens", ("TRANS", "ROT", "SCALE", "MIRROR", "ATRANS", "AROT", "ORIWKS", "ORIMKS", "FOR", "WHILE", "LOOP")),
    ],
)
def test_words_of_one_group_have_texts_of_their_own(language: str, words: tuple[str, ...]) -> None:
    texts = [line for word in words for line in describe_word(word) if line.startswith(language)]
    assert len(set(texts)) == len(words)


def test_functions_and_o_words_that_are_executed_are_explained() -> None:
    for language, names in (("RS274/NGC", (*FUNCTIONS, *KEYWORDS)), ("Siemens", siemens_values.FUNCTIONS)):
        assert [name for name in names if not any(text.startswith(language) for text in describe_word(name))] == []


def test_what_is_neither_a_line_nor_a_code_nor_a_word(run: Callable[..., Any]) -> None:
    answer = run("explain", "G1234")
    assert answer.code == 2
    assert "'G1234' is neither INPUT:LINE (part.nc:12) nor a finding code (VP102)" in " ".join(answer.err.split())
    for word, near in (("CYCLE999", "CYCLE99"), ("TRAROI", "TRAORI")):
        text = " ".join(run("explain", word).err.split())
        assert f"(G68.2); did you mean {near}? verne-post explain --list prints" in text
    assert "(G68.2). verne-post explain --list prints" in " ".join(run("explain", "XYZZY").err.split())


def test_a_code_that_does_not_exist_names_those_that_do(run: Callable[..., Any]) -> None:
    text = " ".join(run("explain", "VP999").err.split())
    assert "VP999: no finding code has this number; codes are within VP001 to VP" in text
    assert "VP301, VP401 to " in text
    assert "explain --list" in text
    assert "did you mean" not in text
    assert "did you mean VP033?" in " ".join(run("explain", "vp33").err.split())


def test_an_m_code_of_the_builder_is_told_how_it_gets_a_meaning(run: Callable[..., Any]) -> None:
    """`check` has asked for it, and `explain` did not know it."""
    answer = run("explain", "m11")
    assert answer.code == 0
    assert answer.out.startswith("M11\n  no meaning in any language here; [remap] of the set-up")
    assert 'M11 = "ignore", or "event"' in answer.out


@pytest.mark.parametrize("word", ["XYZZY", "VP999"])
def test_what_is_unknown_names_where_to_look(run: Callable[..., Any], word: str) -> None:
    answer = run("explain", word)
    assert answer.code == 2
    assert "verne-post explain --list" in " ".join(answer.err.split())
    listed = run("explain", "--list")
    assert listed.code == 0
    assert [line.split()[0] for line in listed.out.splitlines()] == list(CODES)
    assert run("explain", "--list", "VP101").code == run("explain").code == 2


def test_sections_that_words_refer_to_exist() -> None:
    words = {(name, text) for _language, name, _text, _executed in list_words() for text in describe_word(name)}
    named = {found for _name, text in words for found in re.findall(r"see ([A-Z][\w ,-]*) in (docs/\w+\.md)", text)}
    assert len(named) > 20
    for section, page in named:
        headings = re.findall(r"^##+ (.*)$", (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE)
        assert section in headings, page


def test_a_line_of_a_program_with_errors_is_explained_first(run: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "part.mpf"
    path.write_text(
        "G710 G90\nT1 M6\nD1 FOO=3\nTRAORI\nG54 G1 X1 BAR2 F300\nG0 Z60 A=0 C=0\nG1 X20 BAZ\nM30\n", encoding="utf-8"
    )
    answer = run("explain", f"{path}:5", *OPTIONS)
    assert answer.code == 2
    head, *rest, last = answer.out.splitlines()
    assert head == "line 5: G54 G1 X1 BAR2 F300"
    assert [line.split()[0] for line in rest][:2] == ["G54", "G1"]
    assert [line for line in rest if "error" in line] == [line for line in rest if "BAR2" in line]
    assert "in force: G1, G710" in rest[-1]
    assert "2 other errors, the first in line 3: verne-post check " in last
    assert "FOO" not in answer.out + answer.err
    beyond = run("explain", f"{path}:99", *OPTIONS)
    assert (beyond.code, "line 99 is after the end of the program" in " ".join(beyond.err.split())) == (2, True)


def test_a_line_that_names_the_start_says_so(run: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    path.write_text("G21 G90 G94 G49\nG0 G54 X-35 Y-15 Z100 A0 C0\nG1 X0 F900\nG1 X0\nM2\n", encoding="utf-8")
    assert "no motion: the line names the place where the program starts" in run("explain", f"{path}:2", *OPTIONS).out
    assert "no motion: the machine is already at the place that the line" in run("explain", f"{path}:4", *OPTIONS).out
    assert "no motion; the nearest lines that have: 3" in run("explain", f"{path}:5", *OPTIONS).out


def test_numbers_of_a_blended_line_say_which_is_which(run: Callable[..., Any], tmp_path: Path) -> None:
    """A plunge whose corner is blended: the depth as it is driven, and the programmed one."""
    path = tmp_path / "p.ngc"
    path.write_text("G21 G90 G94\nG0 X0 Y0 Z30 A0 C0\nG1 Z-15.85 F600\nG1 X20\nG0 Z60\nM2\n")
    options = ("--tool-length", "80", "--wcs", "G54=0,0,0")
    text = run("explain", f"{path}:3", *options).out
    assert "worst over the whole line, its corners as they are blended (check adds the rest of the corner" in text
    assert "pose at the end of the motion, as programmed\n" in text
    assert "-15.850) mm" in text
    text = run("explain", f"{path}:3", *options, "--smoothing", "off").out
    assert "worst over the whole line\n" in text
    assert "pose at the end of the motion\n" in text


def test_what_is_in_force_behind_a_call_is_that_of_the_line(tmp_path: Path, run: Callable[..., Any]) -> None:
    """Not that of the call, after which the program goes on in a subprogram below the line."""
    program = tmp_path / "part.nc"
    program.write_text(
        "%\nO1\nG21 G90 G94 G17 G49 G54\nG0 X0. Y0. Z130. A0. C0.\nM98 P2\nG1 X7. F500.\nG0 Z160.\nM30\n"
        "O2\nG0 X-30.\nM99\n%\n"
    )
    place = ("--tool-length", "80", "--wcs", "G54=0,0,60")
    shown = run("explain", f"{program}:6", *place).out
    assert re.search(r"in force +G1, .*feed 500 mm/min", shown), shown
    assert re.search(r"in force +G0, ", run("explain", f"{program}:10", *place).out)


INCHES = """%
O1
G20 G90 G17 G40 G80 G49
T1 M6
S3000 M3
G54 G0 X0 Y0 A0 C0
G43 H1 Z2.
{cut}
G0 Z2.
M30
%
"""


@pytest.mark.parametrize(
    ("cut", "line", "said"),
    [
        ("G1 Z-1.7 F20.\nX1.", 8, "within limits if line 8 ends at Z -1.57 instead of -1.7"),
        ("G1 Z1. F20.\nG81 X1. Y1. Z-1.7 R1.9 F20.\nG80", 9, "within limits if line 9 has Z -1.57 instead of -1.7"),
    ],
)
def test_remedies_of_a_program_in_inches_are_in_inches(
    run: Callable[..., Any], tmp_path: Path, cut: str, line: int, said: str
) -> None:
    """The words were compared with mm: Z-1.7 was not found, and `explain` proposed -39.998 in place of it."""
    program = tmp_path / "part.nc"
    program.write_text(INCHES.format(cut=cut))
    given = ("--tool-length", 80, "--wcs", "G54=0,0,40")
    assert f"tried: {said}\n" in run("check", program, *given).out
    program.write_text(INCHES.format(cut=cut).replace("Z-1.7", "Z-1.57"))
    assert run("check", program, *given).code == 0
    # after G21 the words are mm
    program.write_text(INCHES.format(cut=f"G21\n{cut}").replace("Z-1.7", "Z-43.18").replace("G0 Z2.", "G0 Z60."))
    if line == 8:
        assert "within limits if line 9 ends at Z -39.98 instead of -43.18" in run("check", program, *given).out
        program.write_text(INCHES.format(cut=cut))
        assert "Z -1.57472 in place of -1.7 inch" in run("explain", f"{program}:8", *given).out


def test_a_hole_in_inches_names_inches(run: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(INCHES.format(cut="G81 X1. Y1. Z.5 R-1. F20.\nG80"))
    told = run("check", tmp_path / "part.nc", "--tool-length", 80, "--wcs", "G54=0,0,40").out
    assert "R -1 inch lies below the bottom of the hole, Z 0.5 inch" in told


def test_the_cycle_of_mcall_is_in_force_until_it_ends(tmp_path: Path, run: Callable[..., Any]) -> None:
    program = tmp_path / "part.mpf"
    program.write_text(
        "G17 G54 G90 G71\nT1 D1\nM6\nS1000 M3 F100\nG0 A0 C0\nG0 X0 Y0 Z50\nMCALL CYCLE81(20,0,2,-5)\nX10 Y10\nMCALL\n"
        "X20\nM30\n"
    )
    place = ("--tool-length", 80, "--wcs", "G54=0,0,60")
    shown = [run("explain", f"{program}:{line}", *place).out for line in (6, 7, 8, 9, 10)]
    assert ["MCALL CYCLE81, G54" in one for one in shown] == [False, True, True, False, False]


def test_a_line_of_several_moves_that_runs_once_ends_where_the_tool_does(
    tmp_path: Path, run: Callable[..., Any]
) -> None:
    """A stop at which the file is cut shifted the moves, and a round that waits for its next line was another pass."""
    place = ("--tool-length", 80, "--wcs", "G54=0,0,60")
    (hole := tmp_path / "hole.mpf").write_text(
        "G17 G54 G90 G71\nT1 D1\nM6\nS1000 M3 F100\nG0 A0 C0\nG0 X0 Y0 Z50\nM0\nMCALL CYCLE81(20,0,2,-5)\nX10\nMCALL\n"
        "X20\nM30\n"
    )
    shown = run("explain", f"{hole}:9", *place, "--split-at-stops").out
    assert "several times" not in shown
    assert (
        "pose at the end of the motion, the last of 4 moves\n  tip on the table     (10.000, 0.000, 80.000) mm" in shown
    )
    restarted = run("explain", f"{hole}:9", *place, "--split-at-stops", "--from", "home", "--from-line", 8).out
    assert (
        restarted.partition("pose at the end")[2].splitlines()[:3]
        == shown.partition("pose at the end")[2].splitlines()[:3]
    )
    (corner := tmp_path / "corner.mpf").write_text(
        "G17 G54 G90 G71\nT1 D1\nM6\nS1000 M3 F500\nG0 A0 C0\nG0 X0 Y0 Z50\nG42 G1 X10 Y0\nX30 RND=3\nY30 CHF=2\nX0\n"
        "Y0\nG40 X-20\nM30\n"
    )
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 Z80 D8\n")
    for line in range(7, 13):
        told = run("explain", f"{corner}:{line}", "--tool-table", table, *place[2:]).out
        assert "pose at the end" in told and "several times" not in told


def test_a_line_below_its_feed_rate_says_what_holds_it_back(run: Callable[..., Any], tmp_path: Path) -> None:
    """The time is that of the rows, and the limit one that the rows of the line are at."""
    text = "G21 G90 G94 G61.1\nG0 X0 Y0 Z50 A0 C0\nG1 X60 F200000\nG1 X50 F600\nG93 G1 X0 F900\nM2\n"
    job = tmp_path / "feeds.nc"
    job.write_text(text, "utf-8")
    (tmp_path / "feeds.nc.toml").write_text("tool_length = 80\n[wcs]\nG54 = [0, 0, 0]\n", "utf-8")
    rows = tmp_path / "rows.csv"
    assert run("convert", job, "-o", rows).code == 0
    lines = [int(row.rpartition(",")[2]) for row in rows.read_text("utf-8").splitlines()[1:]]
    said = {line: run("explain", f"{job}:{line}").out for line in (3, 4, 5)}
    for line, out in said.items():
        seconds = float(re.search(r"motion +([\d.]+) s; the feed rate is", out)[1])  # type: ignore[index]
        assert abs(seconds - 0.001 * lines.count(line)) < 0.0025, out
    assert re.search(r"not reached, held back by (jerk|acceleration|velocity) of rho\d; fastest tip", said[3])
    assert re.search(r"the feed rate is reached; fastest tip (599|60[0-3]) mm/min", said[4])
    assert "the programmed time is 0.067 s" in said[5]
    out = run("check", job).out
    assert "feed rate: 1 of 3 feed moves reaches the programmed feed rate; line 3 is the first that does not" in out
    job.write_text(text.replace("200000", "600").replace("F900", "F1"), "utf-8")
    assert "feed rate" not in run("check", job).out


def test_every_word_is_explained_for_itself() -> None:
    """No entry is empty, a rest of a list, or the name of another table."""
    for language, name, _text, _executed in list_words():
        lines = [line for line in describe_word(name) if line.startswith(f"{language}: ")]
        assert lines, (language, name)
        said = lines[0].removeprefix(f"{language}: ")
        assert re.match(r"[a-zA-Z0-9#\"]\S* \S|.*[a-z]{4}", said), (language, name, said)
        assert not re.search(r"as in RS274|^(?:on|off|off, left), |^the same\b|^no effect$|^in a ", said), said
    for dialect in ("siemens", "heidenhain"):
        names = [name for _language, name, _text, _executed in list_words()]
        lacking = {name: [one for one in describe_values(name, dialect) if ": " not in one] for name in names}
        assert not any(lacking.values()), lacking


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("F", ("RS274/NGC: feed rate", "Fanuc: feed rate", "Klartext: feed rate in mm/min")),
        ("T1", ("RS274/NGC: selects a tool", "Fanuc: selects", "Siemens: selects", "Klartext: number or name")),
        ("C1", ("Klartext: axis C goes to 1 degree",)),  # it was an arc, as C alone is
        ("X1", ("Siemens: axis X goes to 1 mm", "Siemens: an axis that G75 moves (as X1=)")),
        ("MMPM", ("APT, in FEDRAT: the feed rate is in mm/min",)),
        ("G55", ("RS274/NGC: work offset G55", "Siemens: work offset G55")),
        ("M30", ("Klartext: end of the program",)),
        ("TCPM", ("Klartext: FUNCTION TCPM switches tool-centre-point control on",)),
        ("FN18", ("Klartext: reads a value of the control",)),
        ("Q336", ("Klartext: a value of CYCL DEF 202, 204, 209: spindle angle",)),
        ("Q339", ("Klartext: a value of CYCL DEF 247: preset number",)),
        ("SEQ-", ("Klartext: chooses the sign of the tilting axis",)),
        ("A3=", ("Siemens: the tool axis",)),
        ("CR=", ("Siemens: radius of an arc; a negative one takes the long way", "Klartext: arc by its radius; a neg")),
        ("START", ("Siemens: not executed: programs of", "Klartext, in PATTERN: angle of the first")),
        ("DIST", ("Klartext: how far before the tip", "Klartext, in BLK: height of the datum over its upper face")),
        ("TA", ("Klartext, in CYCL: tolerance of the rotary axes, degrees: no effect",)),
        ("LEN", ("Klartext: length of the straight line",)),
        ("G44", ("Fanuc: not executed: subtracts the tool length of H, which G43 adds; write G43",)),
        ("R1", ("Siemens: an R parameter",)),
        ("Q1", ("Klartext: a Q parameter",)),
        ("#100", ("RS274/NGC: a variable", "Fanuc: a variable")),
        ("CYCL", ("Klartext: CYCL DEF defines",)),
        ("G83", ("RS274/NGC: deep-hole drilling, out of the hole after each peck: see Canned cycles",)),
        ("G94", ("RS274/NGC: feed per minute: see Feed modes G93, G94, G95 in docs/gcode.md",)),
    ],
)
def test_words_that_machinists_type_are_known(word: str, said: tuple[str, ...]) -> None:
    lines = describe_word(word)
    for text in said:
        assert any(line.startswith(text) for line in lines), (text, lines)


def test_a_q_of_klartext_leads_with_its_cycles_and_has_no_other_language() -> None:
    from verne_post.gcode.klartext.cycle_words import OF_PARAMETERS

    for number in {one for needs, defaults in OF_PARAMETERS.values() for one in (*needs, *defaults)}:
        first, *rest = describe_word(f"Q{number}")
        assert re.fullmatch(r"Klartext: a value of CYCL DEF [\d, ]+: [a-z ]+(, .+)?", first)
        assert [line.split(":")[0] for line in rest] == ["Klartext"]
    assert [line.split(":")[0] for line in describe_word("Q5")] == ["RS274/NGC", "Fanuc", "Klartext"]
    for word in ("M1=", "M1 =", "m1  ="):  # an address of Siemens, and not M1
        assert describe_word(word) == ["Siemens: an M function; M1= is one of the spindle"]
    assert [describe_word(word) for word in ("M12=", "M12 =", "M1-", "M3=")] == [[]] * 4


def test_axes_whose_values_are_parameters_are_named(run: Callable[..., Any], tmp_path: Path) -> None:
    text = (
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S8000\n2 L X+0 Y+0 Z+150 R0 FMAX M3\n"
        "3 PLANE SPATIAL SPA+0 SPB+10 SPC+0 STAY\n"
        "4 L A+Q120 C+Q122 FMAX\n5 L X+10 F500\n6 END PGM A MM\n"
    )
    (tmp_path / "a.h").write_text(text, "utf-8")
    (tmp_path / "a.h.toml").write_text("tool_length = 90\n[wcs]\nG54 = [0, 0, 100]\n", "utf-8")
    words = [line.split()[0] for line in run("explain", tmp_path / "a.h:5").out.splitlines()[2:-1]]
    assert words == ["4", "L", "A+Q120", "Q120", "C+Q122", "Q122", "FMAX"]
    answer = run("explain", tmp_path / "a.h:0")
    assert answer.code == 2
    assert "line 0 is the approach (--from), and none is given" in " ".join(answer.err.split())


def test_f_of_m128_is_told_once(run: Callable[..., Any], tmp_path: Path) -> None:
    """It said that F has no effect, and that it is the feed rate from there on."""
    (tmp_path / "q.h").write_text(
        "0 BEGIN PGM Q MM\n1 TOOL CALL 1 Z S8000\n2 L X+0 Y+0 Z+150 R0 FMAX M3\n3 L X+10 F500\n4 M128 F1000\n"
        "5 L Y+10\n6 L M140 MB5 F300\n7 END PGM Q MM\n"
    )
    options = ("--tool-length", 90, "--wcs", "G54=0,0,100")
    text = run("explain", f"{tmp_path / 'q.h'}:5", *options).out
    assert re.search(r"\n  F1000 +belongs to M128, and has no effect: the feed rate in force stays\n", text)
    assert "from this block on" not in text
    assert "feed 500 mm/min" in run("explain", f"{tmp_path / 'q.h'}:6", *options).out


def test_a_document_and_a_key_in_the_wrong_table_have_one_error(run: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "README.md").write_text("# Title\n\nSome text, with G1 X0\n", "utf-8")
    out = run("check", tmp_path / "README.md").out
    assert "README.md is no NC program: .md is a document" in out
    assert "refused: 1 error," in out
    (tmp_path / "b.nc").write_text("G0 X0\n", "utf-8")
    (tmp_path / "b.nc.toml").write_text('[wcs]\nG54 = [0, 0, 100]\nstock = "program"\n', "utf-8")
    assert "write stock = ... above the first [table] of the file" in run("check", tmp_path / "b.nc").out


def test_a_tool_that_is_in_the_spindle_is_not_loaded_again(run: Callable[..., Any], tmp_path: Path) -> None:
    job, setup = tmp_path / "tools.nc", tmp_path / "tools.nc.toml"
    job.write_text("G21 G90 G94\nT1 M6\nT2 M6\nT2 M6\nG43 H2\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F500\nM2\n", "utf-8")
    setup.write_text("[tools]\n1 = { length = 80 }\n2 = { length = 90 }\n[wcs]\nG54 = [0, 0, 0]\n", "utf-8")
    said = " ".join(run("convert", job, "-o", tmp_path / "tools.csv").err.split())
    assert "load tool 1 (line 2); load tool 2 (line 3)" in said
    assert "(line 4)" not in said


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            4,
            "  part of line 3, which has the error\n  limits were not checked, because line 3 cannot be executed: ",
        ),
        (5, "  part of line 3, which has the error\n"),
        (7, "  no error is found in its words\n  limits were not checked, because line 3 cannot be executed: VP005"),
    ],
)
def test_a_line_beside_an_error_says_that_its_limits_were_not_checked(
    run: Callable[..., Any], tmp_path: Path, line: int, said: str
) -> None:
    """A-110 is beyond the travel, and nobody has looked."""
    path = tmp_path / "p.h"
    path.write_text(
        "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nCYCL DEF 251 POCKET ~\n Q200=2 ~\n Q201=-3\nL X+0 FMAX\n"
        "L A-110 FMAX\nM30\nEND PGM P MM\n"
    )
    answer = run("explain", f"{path}:{line}", "--tool-length", 60, "--wcs", "G54=0,0,60")
    assert said in answer.out


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("QL3", "Klartext: a Q parameter"),
        ("TX", "Klartext: a component of the tool axis, in LN"),
        ("TCH PROBE", "Klartext, TCH: not executed: touch probes"),
        ("VP 102", "VP102 error: tilt range"),
    ],
)
def test_words_as_people_type_them_are_explained(run: Callable[..., Any], word: str, said: str) -> None:
    assert said in run("explain", word).out


@pytest.mark.parametrize(("machine", "name"), [("verne", "VERNE"), ("ca_fork_head", "CA fork head")])
def test_a_line_names_the_machine_whose_limits_it_was_measured_by(
    run: Callable[..., Any], tmp_path: Path, machine: str, name: str
) -> None:
    """A line without motion and a word say the same on every machine, and name none."""
    program = tmp_path / "part.nc"
    program.write_text("G21 G90 G94 G17 G54\nG0 X0 Y0 Z100 A0 C0\nG1 X5 F500\nM2\n", encoding="utf-8")
    given = ("--machine", machine, "--tool-length", "80", "--wcs", "G54=0,0,60")
    assert f"\n  machine              {name}\n" in run("explain", f"{program}:3", *given).out
    assert name not in run("explain", f"{program}:1", *given).out
    assert name not in run("explain", "G54", "--machine", machine).out


def test_findings_are_printed_before_remedies_are_sought(
    run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The search may take ten times as long as the check: nothing was printed until it had ended."""
    (tmp_path / "a.nc").write_text(PROGRAM, "utf-8")
    before, search = [], explain_app.add_line_remedies

    def seek(line: Line, holds: Trial) -> Line:
        before.append(capsys.readouterr().out)
        return search(line, holds)

    monkeypatch.setattr(explain_app, "add_line_remedies", seek)
    assert main(["explain", f"{tmp_path / 'a.nc'}:3", *OPTIONS]) == 0
    after = capsys.readouterr().out
    (first,) = before
    assert "VP102 error" in first
    assert "what would bring" not in first
    assert after.startswith("what would bring the line within limits")
    explained = vp.explain(PROGRAM, "verne", 3, vp.Options(tool_length=120, wcs={"G54": (0, 0, 60)})).text
    assert name_in_python(first + after).startswith(explained)


@pytest.mark.parametrize(
    ("name", "text", "line", "said"),
    [
        ("a.nc", lines("%", "O1", "G90 G94 G17 G21 G54", "T1 M6", "S900 M3", "G0 A0. C0.", "G43 H1 Z50.", "G52 Y25.",
                       "G0 X10. Y0.", "G1 Z2. F300.", "M30", "%"), 9, "G54, zero shifted by Y 25 mm (G52, G92), tool"),
        ("a.ngc", lines("G90 G94 G17 G20 G54", "T1 M6", "S900 M3", "G43 H1", "G0 A0 C0", "G0 X0 Y0 Z2", "G92 X1 A10",
                        "G1 X0.5 Z1 F12", "M30"), 8, "G54, zero shifted by X -25.4 mm, A -10 deg (G52, G92), tool"),
        ("a.h", lines("0 BEGIN PGM A MM", "1 TOOL CALL 1 Z S900", "2 L A+0 C+0 R0 FMAX M3", "3 L Z+100 FMAX",
                      "4 CYCL DEF 7.0 NULLPUNKT", "5 CYCL DEF 7.1 Y+25", "6 PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN FMAX",
                      "7 L X+0 Y+0 FMAX", "8 L Z+50 FMAX", "9 M30", "10 END PGM A MM"), 8,
         "tilted work plane, its Z along (0, -0.5, 0.866), zero shifted by (0, 25, 0) mm, tool"),
    ],
)  # fmt: skip
def test_a_shift_of_the_zero_is_in_force(
    run: Callable[..., Any], tmp_path: Path, name: str, text: str, line: int, said: str
) -> None:
    path = tmp_path / name
    path.write_text(text)
    path.with_name(f"{name}.toml").write_text(SIZES)
    assert said in run("explain", f"{path}:{line}").out


SIZES = "[tools]\n1 = { length = 80, diameter = 10 }\n[wcs]\nG54 = [0, 0, 60]\n"
#: The same contour in three languages: name, program, line of its first side, line of its arc, and what is in force.
BESIDE = [
    ("a.h", lines(
        "0 BEGIN PGM A MM", "1 TOOL CALL 1 Z S5000", "2 L X-40 Y-20 A+0 C+0 R0 FMAX M3", "3 L Z-2 FMAX M109",
        "4 L Y+0 RL F1200", "5 L X+30", "6 CC X+30 Y+10", "7 C X+40 Y+10 DR+", "8 L Y+30", "9 L X+60 R0",
        "10 L Z+20 FMAX M30", "11 END PGM A MM"), 6, 8, "RL (tool centre 5 mm left of the contour: tool 1)"),
    ("a.mpf", lines(
        "G17 G54 G64 G90 G94 G710", "T1 D1", "M6", "S8000 M3", "G0 A0 C0", "G0 X-40 Y-20 Z-2", "G41 G1 Y0 F1200",
        "X30", "G3 X40 Y10 I0 J10", "G1 Y30", "G40 X60", "G0 Z30", "M30"), 8, 9,
        "G41 (tool centre 5 mm left of the contour: tool 1)"),
    ("a.nc", lines(
        "%", "O1", "G90 G94 G17 G21 G40 G49", "T1 M6", "S8000 M3", "G54 G0 X-40. Y-20. A0. C0.", "G43 H1 Z-2.",
        "G41 D1 G1 Y0. F1200.", "X30.", "G3 X40. Y10. I0. J10.", "G1 Y30.", "G40 X60.", "G0 Z30.", "M30", "%"), 9, 10,
        "G41 (tool centre 5 mm left of the contour: D1, tool 1)"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "side", "arc", "said"), BESIDE)
def test_cutter_compensation_is_in_force_and_its_centre_is_no_word(
    run: Callable[..., Any], tmp_path: Path, name: str, text: str, side: int, arc: int, said: str
) -> None:
    """A tool of 10 mm along an inside arc from X30 Y0 to X40 Y10, of 10 mm: its centre has half of F."""
    path = tmp_path / name
    path.write_text(text)
    path.with_name(f"{name}.toml").write_text(SIZES)
    told = run("explain", f"{path}:{arc}", "--all").out
    assert said in told
    assert "feed 600 mm/min of the tool centre: F1200 at the contour of the arc" in told
    assert "program coordinates  X 40 mm" in told and "tool centre          X 35, Y 10, Z -2 mm, 5 mm left" in told
    assert "tip on the table     (35.000, 10.000, 58.000) mm, tool centre, 5 mm left of the contour" in told
    told = run("explain", f"{path}:{side}").out
    assert said in told and "feed 1200 mm/min\n" in told
    after = run("explain", f"{path}:{arc + 2}", "--all").out  # it has ended
    assert "tool centre" not in after and "program coordinates  X 60 mm" in after


def test_an_inside_corner_under_compensation_keeps_the_word(run: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "r.h"
    path.write_text(BESIDE[0][1].replace("6 CC X+30 Y+10\n7 C X+40 Y+10 DR+\n", ""))
    path.with_name("r.h.toml").write_text(SIZES)
    told = run("explain", f"{path}:6", "--all").out
    assert "program coordinates  X 30 mm (as the line says), Y 0 mm" in told
    assert "tool centre          X 25, Y 5, Z -2 mm, 5 mm left of the contour" in told


def test_a_length_that_g53_has_cancelled_is_not_in_force(run: Callable[..., Any], tmp_path: Path) -> None:
    """Nor does G49 have to cancel it again: the table turns alone."""
    path = tmp_path / "g53.nc"
    head = "%\nO1\nG90 G94 G17 G21\nT1 M6\nS5000 M3\nG54 G0 X0. Y0. A0. C0.\nG43 Z30. H1\nG1 Z5. F500.\n"
    path.write_text(f"{head}G53 G0 Z0.\nG0 A20. C0.\nA0.\nG43 X20. Y0. Z30. H1\nM30\n%\n")
    setup = path.with_name("g53.nc.toml")
    setup.write_text(SIZES)
    for line in (9, 10, 11):
        told = run("explain", f"{path}:{line}").out
        assert "tool length cancelled by G53 of line 9 (a tip is shown for 80 mm)" in told
        assert "VP046" not in told
    assert "tool length 80 mm" in run("explain", f"{path}:12").out
    spindle = [re.search(r"rho1 .*?rho3 [\d.]+", run("explain", f"{path}:{line}").out) for line in (9, 10)]
    assert spindle[0] and spindle[1] and spindle[0][0] == spindle[1][0]  # the linear axes do not move
    setup.write_text(SIZES + '[fanuc]\nlength_after_return = "restored"\n')
    assert "or cancel the tool length before it (G49)" in run("check", path).out


def test_names_that_are_no_words_and_the_tool_0(run: Callable[..., Any]) -> None:
    told = run("explain", "RTCP").out
    assert all(code in told for code in ("G43.4 H", "TRAORI", "M128 or FUNCTION TCPM"))
    told = run("explain", "D0").out
    assert "RS274/NGC: the tool in the spindle" in told and "Fanuc: no radius: under G41" in told and "D0 ends" in told
    assert "Fanuc: tool whose radius is used" in run("explain", "D1").out
    assert "Fanuc: no radius: under G41" in run("explain", "G41 D0").out


def test_words_name_the_rotary_axes_of_the_machine(run: Callable[..., Any], tmp_path: Path) -> None:
    """Those of --machine; without one no letters, which would be those of another machine."""
    for word, own, general in (
        ("G53.1", "turns B and C until", "turns the rotary axes until"),
        ("G43.4", "while B and C turn", "while the rotary axes turn"),
        ("SEQ", "the sign of B; without it B and C take", "the sign of the tilting axis; without it the rotary axes"),
        ("G12.1", "write X Y Z with B and C", "write X Y Z with the rotary axes"),
        ("CYCL DEF 27", "write X Y Z with B and C", "write X Y Z with the rotary axes"),
        ("C2", "or the angles of B and C", "or the angles of the rotary axes"),
    ):
        assert own in run("explain", word, "--machine", "bc_trunnion").out
        shown = run("explain", word).out
        assert general in shown and "A and C" not in shown
    program = tmp_path / "b.nc"
    program.write_text("G21 G90 G54\nG43.4 H1\nG0 X0 Y0 Z50 B0 C0\nG1 Z20 F500\nM2\n", "utf-8")
    for length in ((), ("--tool-length", "50")):
        shown = run("explain", f"{program}:2", "--machine", "bc_trunnion", *length).out
        assert "X Y Z are those of the tip while B and C turn" in shown
    for code, own in (("G12.1", "write X Y Z with the rotary axes"), ("", "VP036")):
        program.write_text(f"G21 G90 G54\nG49\nG0 X0 Y0 Z50\nG1 Z20 F500\n{code}\nG1 B30\nM2\n", "utf-8")
        shown = run("check", program, "--machine", "bc_trunnion", "--dialect", "fanuc").out
        assert own in shown and "A and C" not in shown
