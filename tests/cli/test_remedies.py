"""Remedies hold: what `check` proposes is applied, and the program is checked again by the same command as a user
would.
"""

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post as vp
from verne_post.base.program_lines import add_angle, change_number, change_vector, find_word_of

SAMPLES = Path(__file__).resolve().parents[2] / "gcode_samples"


@pytest.mark.parametrize(
    ("sample", "given"),
    [
        ("violates_slider_travel.nc", ["--tool-length", "50", "--wcs", "G54=0,0,420"]),
        ("pocket_3axis.nc", ["--tool-length", "80"]),
        ("two_faces.nc", ["--tool-length", "80"]),
    ],
)
def test_the_proposed_offset_makes_the_program_legal(sample: str, given: list[str], run: Callable[..., Any]) -> None:
    before = run("check", SAMPLES / sample, "--setup", "none", *given)
    assert before.code == 1
    proposed = set(
        re.findall(r"= tried: .*?within limits if the part is moved by (.*) mm \(then (G54 = .*)\)", before.out)
    )
    assert len(proposed) == 1, before.out
    moved, then = proposed.pop()
    now = [float(word) for word in given[-1].partition("=")[2].split(",")] if "--wcs" in given else [0.0, 0.0, 0.0]
    ends = [float(word) for word in then.partition("=")[2].split(",")]
    assert [float(word) for word in moved.split(",")] == pytest.approx(np.subtract(ends, now).tolist(), abs=1e-6)
    place = ["--wcs", then]
    kept = given[:2]  # the tool length
    assert run("check", SAMPLES / sample, "--setup", "none", *kept, *place).code == 0


def test_a_dry_run_needs_less_of_a_lift(tmp_path: Path, run: Callable[..., Any]) -> None:
    """With --air the tool hangs higher: the part has to be moved by so much less."""
    program = tmp_path / "low.nc"
    program.write_text("G21 G90\nG0 X0 Y0 Z60 A0 C0\nG1 X10 F500\nZ-60\nM2\n", encoding="utf-8")
    moved = {}
    for air in (0, 5):
        said = run("explain", f"{program}:4", "--all", "--tool-length", 80, "--wcs", "G54=0,0,50", "--air", air).out
        found = re.search(r"the part moved by [^)]*, ([0-9.]+) mm \(then G54 = ", said)
        assert found, said
        moved[air] = float(found[1])
        assert f"tip over the table face              {air - 10:.3f} mm" in said
    assert moved[0] - moved[5] == pytest.approx(5.0, abs=0.1)


def test_the_other_table_solution_is_not_offered_where_it_is_refused_too(
    tmp_path: Path, run: Callable[..., Any]
) -> None:
    given = ["--tool-length", "120", "--wcs", "G54=0,0,60"]
    for command in ("check", "convert"):
        answer = run(command, SAMPLES / "violates_tilt.nc", *given)
        said = answer.out + answer.err
        assert answer.code == 1
        assert "other table solution" not in said
        assert "| G1 A101" in said
        tilt = re.search(r"line 10 alone: within limits if the line ends at A ([\d.]+) instead of A 101", said)
        assert tilt is not None
    text = (SAMPLES / "violates_tilt.nc").read_text(encoding="utf-8")
    mended = tmp_path / "mended.nc"
    mended.write_text(text.replace("G1 A101", f"G1 A{tilt[1]}"), encoding="utf-8")
    assert run("check", mended, *given).code == 0
    mended.write_text(text.replace("G1 A101", f"G1 A{float(tilt[1]) + 0.01}"), encoding="utf-8")
    assert run("check", mended, *given).code == 1, "the tilt is the largest that is legal"


def test_a_rewind_is_offered_with_the_option_that_allows_it(tmp_path: Path, run: Callable[..., Any]) -> None:
    """A tool of 30 degrees swings nearly once around, lifts, and does so again: the table must rewind between
    the two.
    """
    short = tmp_path / "short.toml"
    serial = (SAMPLES.parent / "machine_configs" / "serial.toml").read_text(encoding="utf-8")
    short.write_text(serial.replace("# c_deg absent: unlimited", "c_deg = [-200.0, 200.0]"), encoding="utf-8")

    def place(degrees: int, z: int) -> str:
        s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        return f"X{40 * s:.4f} Y{40 * c:.4f} Z{z} I{0.5 * s:.6f} J{0.5 * c:.6f} K{math.sqrt(0.75):.6f}"

    lines = [f"G21 G90 G94\nG0 G43.5 H0 {place(0, 60)}", *(f"G1 {place(d, 60)} F800" for d in range(20, 341, 20))]
    lines += [f"G0 {place(340, 120)}", f"G0 {place(0, 120)}", f"G0 {place(0, 60)}"]
    lines += [*(f"G1 {place(d, 60)} F800" for d in range(20, 181, 20)), f"G0 {place(180, 120)}", "M2"]
    program = tmp_path / "round.nc"
    program.write_text("\n".join(lines) + "\n", encoding="utf-8")
    given = ["--machine", short, "--tool-length", "80", "--wcs", "G54=0,0,60"]
    answer = run("check", program, *given)
    assert answer.code == 1
    assert "tried: --allow-rewind brings the program within limits" in answer.out
    assert run("check", program, *given, "--allow-rewind").code == 0


def test_no_offset_is_proposed_where_none_was_found(run: Callable[..., Any]) -> None:
    """Far off the table, turning C swings the part through every limit: only a search over the table helps."""
    answer = run("check", SAMPLES / "blade_5axis.nc", "--tool-length", "120", "--wcs", "G54=600,0,10")
    assert answer.code == 1
    assert "then G54" not in answer.out
    assert "verne-post fit" in answer.out


def test_passes_over_the_same_lines_are_one_finding(tmp_path: Path, run: Callable[..., Any]) -> None:
    """A loop that goes deeper each time leaves its limit many times: one finding, with the deepest place."""
    program = tmp_path / "loop.nc"
    program.write_text(
        "G21 G90 G94 G61\n"
        "G0 X0 Y0 Z5\n"
        "#1=0\n"
        "o1 while [#1 lt 60]\n"
        "G1 X20 Z[-#1] F900\n"
        "X0\n"
        "G0 Z5\n"
        "#1=[#1+1]\n"
        "o1 endwhile\n"
        "M2\n",
        encoding="utf-8",
    )
    answer = run("check", program, "--tool-length", "80", "--wcs", "G54=0,0,20")
    found = [line for line in answer.out.splitlines() if "VP210" in line]
    assert len(found) == 1, answer.out
    assert "39.000 mm below" in found[0]


def test_a_missing_offset_is_said_first_and_named_in_the_remedy(run: Callable[..., Any]) -> None:
    answer = run("convert", SAMPLES / "two_faces.nc", "--setup", "none", "--tool-length", "80")
    assert answer.code == 1
    assert "VP033" in answer.err.splitlines()[0]
    assert "tried: no work offset was given; within limits if the part is moved by" in answer.err


def test_a_tilt_beyond_the_number_of_the_limit_says_where_the_joint_is(run: Callable[..., Any], tmp_path: Path) -> None:
    """A 99 looks illegal beside a limit of 95: the joint is A plus the platform's tilt. A machine without that tilt
    says nothing of it.
    """
    path = tmp_path / "p.ngc"
    path.write_text("G21 G90 G94\nG0 X0 Y0 Z160 A60 C0\nG1 A101 F600\nM2\n")
    answer = run("check", path, "--tool-length", "80", "--wcs", "G54=0,0,0")
    found = re.search(
        r"ends at A ([\d.]+) instead of A 101, tip and C as they are \(the joint a is A plus the platform's tilt, "
        r"(-[\d.]+) deg: ([\d.]+) deg\)",
        answer.out,
    )
    assert found is not None, answer.out
    word, tilt, joint = map(float, found.groups())
    assert abs(word + tilt - joint) < 0.002
    assert joint <= 95.0 < word
    answer = run("check", path, "--machine", "serial", "--tool-length", "80", "--wcs", "G54=0,0,0")
    assert "platform's tilt" not in answer.out


def test_a_tilt_is_sought_on_where_its_limit_breaks_another_one(run: Callable[..., Any], tmp_path: Path) -> None:
    """At A 94.999 the spindle nose is below the table: nothing was proposed."""
    path = tmp_path / "p.ngc"
    text = "G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG1 Z2 A{} F600\nM2\n"
    given = ("--machine", "serial", "--tool-length", "80", "--wcs", "G54=0,0,0")
    path.write_text(text.format(94))
    assert "VP210" in run("check", path, *given).out
    path.write_text(text.format(170))
    found = re.search(r"ends at A ([\d.]+) instead of A 170", run("check", path, *given).out)
    assert found is not None
    path.write_text(text.format(found[1]))
    assert run("check", path, *given).code == 0


@pytest.mark.parametrize(
    ("name", "line", "code"),
    [
        ("part.nc", "G53 G0 Z500.", "G53"),
        ("part.mpf", "SUPA G0 Z500 D0", "SUPA"),
        ("part.h", "L Z+500 R0 FMAX M91", "M91"),
        ("part.h", "L Z+400 R0 FMAX\nL Z+3000 R0 FMAX M91", "M91"),
        ("part.mpf", "TRAFOOF\nG500\nG0 Z500", "G500"),
    ],
)
def test_no_work_offset_is_named_for_machine_coordinates(
    name: str, line: str, code: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    texts = {
        "part.nc": "G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG1 X20 F900\n{}\nM2\n",
        "part.mpf": "G710 G90\nT1 D1\nM6\nTRAORI\nG54\nG0 X0 Y0 Z60 A=0 C=0\nG1 X20 F900\n{}\nM30\n",
        "part.h": "BEGIN PGM A MM\nTOOL CALL 1 Z S8000\nL A+0 C+0 FMAX\nL X+0 Y+0 Z+60 R0 FMAX\nL X+20 F900 M3\n{}\n"
        "END PGM A MM\n",
    }
    (tmp_path / name).write_text(texts[name].format(line), encoding="utf-8")
    said = " ".join(run("check", tmp_path / name, "--tool-length", 80, "--wcs", "G54=0,0,60").out.split())
    assert "VP101 error" in said
    place = re.escape(f"is in machine coordinates ({code}), which no work offset moves; ")
    end = re.search(rf"{place}within limits if line \d+ ends at Z (\S+) instead of \+?(?:500|3000)(?!\.)", said)
    assert end is not None
    again = re.sub(r"(Z\+?)(500|3000)\.?", rf"\g<1>{end[1]}", texts[name].format(line))
    (tmp_path / name).write_text(again, encoding="utf-8")
    assert run("check", tmp_path / name, "--tool-length", 80, "--wcs", "G54=0,0,60").code == 0
    assert "no work offset near" not in said
    assert "verne-post fit" not in said


@pytest.mark.parametrize("machine", ["ac_trunnion", "verne"])
def test_explain_gives_another_machine_coordinate(machine: str, tmp_path: Path, run: Callable[..., Any]) -> None:
    """The number that explain gives runs; a little more does not. G28 has no number that would help."""
    lines = "G21 G90 G94 G54\nG0 A0 C0\nG0 X0 Y0 Z50.\nG1 X10. F500\n{}\nM30\n"
    given = ("--machine", machine, "--tool-length", 100, "--wcs", "G54=0,0,200")
    path = tmp_path / "part.nc"
    path.write_text(lines.format("G53 G0 Z500."), encoding="utf-8")
    said = run("explain", f"{path}:5", *given).out
    end = re.search(r"ended elsewhere: Z (\S+) in place of 500 mm \(in machine coordinates\)", said)
    assert end is not None
    assert "ended elsewhere: X" not in said
    for more, found in ((0.0, 0), (0.1, 1)):
        path.write_text(lines.format(f"G53 G0 Z{float(end[1]) + more:.3f}"), encoding="utf-8")
        assert run("check", path, *given).code == found


def test_a_machine_coordinate_is_not_at_fault_where_the_line_before_broke_the_limit(
    tmp_path: Path, run: Callable[..., Any]
) -> None:
    path = tmp_path / "part.nc"
    path.write_text("G21 G90 G94 G54\nG0 A0 C0\nG0 X0 Y0 Z50.\nG1 Z900. F500\nG53 G0 X10.\nM30\n", encoding="utf-8")
    given = ("--machine", "ac_trunnion", "--tool-length", 100, "--wcs", "G54=0,0,200")
    assert "machine coordinates" not in run("check", path, *given).out
    assert "none here: the line begins beyond the limit; a line before it" in run("explain", f"{path}:5", *given).out


def test_a_line_that_is_in_machine_coordinates_once_alone_is_not_called_so(
    tmp_path: Path, run: Callable[..., Any]
) -> None:
    """A loop executes the line in G54, where it fails, and in G500."""
    (tmp_path / "part.mpf").write_text(
        "G710 G90 G54\nT1 D1\nM6\nG0 A0 C0\nREPEATED:\nG0 X0 Y0 Z60\nG500\nENDED:\nREPEAT REPEATED ENDED P=1\nM30\n",
        encoding="utf-8",
    )
    said = run("check", tmp_path / "part.mpf", "--tool-length", 80, "--wcs", "G54=0,0,600").out
    assert "part.mpf:6: VP101 error" in said
    assert "machine coordinates" not in said


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("G91\nG1 Z5 F500\nX300\nX400", "line 4 has G90 instead of G91, which"),
        ("G91 G28 Z0\nG0 X300 Y60\nX330", "G90 stands below line 4, whose G91"),
    ],
)
def test_a_limit_that_a_forgotten_g90_breaks_names_the_line_of_g91(
    lines: str, said: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    given, program = ["--tool-length", "80", "--wcs", "G54=0,0,60"], tmp_path / "forgotten.nc"
    text = f"G21 G90 G54\nG0 X0 Y0 Z50\nG1 Z5 F100\n{lines}\nM2\n"
    program.write_text(text, encoding="utf-8")
    answer = run("check", program, *given)
    assert answer.code == 1
    assert f"tried: within limits if {said} makes the values from there on distances" in answer.out
    mended = text.replace("Z0\n", "Z0\nG90\n") if "G28" in lines else text.replace("\nG91", "\nG90")
    program.write_text(mended, encoding="utf-8")
    assert run("check", program, *given).code == 0


def test_a_remedy_for_some_errors_names_those_that_remain(tmp_path: Path, run: Callable[..., Any]) -> None:
    program = tmp_path / "two.nc"
    program.write_text(
        "G21 G90 G94 G54\nG0 X0 Y0 Z50 A0 C0\nG1 X50 F1000\nG0 A-120\nG0 A0\nG1 X700\nG0 Z100\nM2\n", encoding="utf-8"
    )
    answer = run("check", program, "--tool-length", "80", "--wcs", "G54=0,0,100")
    said = re.search(
        r"tried: the other errors are gone if the part is moved by .* mm \(then (G54 = .*)\); "
        r"VP102 \(tilt range\) remains\n",
        answer.out,
    )
    assert said, answer.out
    moved = run("check", program, "--tool-length", "80", "--wcs", said[1].replace(" ", ""))
    errors = {line.split()[1] for line in moved.out.splitlines() if " error: " in line}
    assert errors == {"VP102"}, moved.out


@pytest.mark.parametrize(
    ("machine", "offset", "said"),
    [
        ("ac_trunnion", "-150.3, -105.1, -280.2", "0, 0, 420, plus these numbers is G54 = -150.3, -105.1, 139.8:"),
        ("ac_trunnion", "-412.3, -205.1, -380.2", "0, 0, 420, plus these numbers is G54 = -412.3, -205.1, 39.8:"),
        ("verne", "-15.3, -5.1, -480.2", "0, 0, 550, plus these numbers is G54 = -15.3, -5.1, 69.8:"),
        ("ac_trunnion", "-15, -10, -40", ""),  # a sign may be wrong there
        ("ac_trunnion", "0, 0, -280.2", ""),
    ],
)
def test_the_offset_page_of_a_control_is_no_place_of_a_part(
    machine: str, offset: str, said: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """The remedy was a part 280 mm above the table, or another place that nobody could have meant."""
    program, setup = tmp_path / "p.nc", tmp_path / "p.nc.toml"
    program.write_text("G21 G90\nT1 M6\nM3 S900\nG43 H1\nG0 X0 Y0 Z50 A0 C0\nG1 Z-5 F500\nG0 Z50\nM2\n")
    setup.write_text(f"split_at_stops = true\n[tools]\n1 = {{ length = 80 }}\n[wcs]\nG54 = [{offset}]\n")
    out = run("check", program, "--machine", machine).out
    assert ("offset page" in out, "is a sign wrong" in out) == (bool(said), not said), out
    assert said in out


@pytest.mark.parametrize(
    ("length", "z", "said"),
    [
        (900, 40, "the set-up gives tool 1 the length 90 instead of 900: is a decimal point missing"),
        (80, -40, "G54 = 0, 0, 40 instead of 0, 0, -40 of p.nc.toml: is a sign wrong there?"),
        (80, 4000, "G54 = 0, 0, 400 instead of 0, 0, 4000 of p.nc.toml: is a decimal point wrong there?"),
    ],
)
def test_a_slip_in_a_number_of_the_set_up_is_named(
    length: float, z: float, said: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """It was advice about the work offset alone; of a wrong sign, a part that is moved until nothing is refused."""
    program, setup = tmp_path / "p.nc", tmp_path / "p.nc.toml"
    program.write_text("G21 G90\nT1 M6\nM3 S900\nG43 H1\nG0 X0 Y0 Z50 A0 C0\nG1 Z-5 F500\nG0 Z50\nM2\n")
    setup.write_text(f"split_at_stops = true\n[tools]\n1 = {{ length = {length} }}\n[wcs]\nG54 = [0, 0, {z}]\n")
    (first, *_others) = re.findall(r"= tried: (.*)", run("check", program).out)
    assert said in first
    right = setup.read_text().replace("900", "90").replace("-40", "40").replace("4000", "400")
    setup.write_text(right)
    assert run("check", program).code == 0


@pytest.mark.parametrize(("depth", "codes"), [(-50, ["VP210"]), (-30, ["VP215"])])
def test_a_retract_beside_a_jaw_is_given_another_z(
    depth: int, codes: list[str], tmp_path: Path, run: Callable[..., Any]
) -> None:
    """The distance from the wall of a jaw does not change with Z: Newton's method on it alone finds no other Z."""
    text = "G21 G90 G94 G54\nT1 M6\nG0 A0 C0\nG43 H1 X-60 Y-45 Z50\nG1 Z-4 F300\nX-50\nY-40\nX-60 Y-45\nG0 Z{}\nM2\n"
    (tmp_path / "b.nc.toml").write_text(
        "[tools]\n1 = { length = 90, diameter = 10 }\n[wcs]\nG54 = [0, 0, 40]\n"
        '[keep_out.jaw]\nmin = [-80, -45, -35]\nmax = [-62, 45, -18]\nsystem = "G54"\n',
        encoding="utf-8",
    )
    path = tmp_path / "b.nc"
    path.write_text(text.format(depth), encoding="utf-8")
    said = run("check", path, "--machine", "ac_trunnion").out
    assert sorted(re.findall(r"(VP\d+) error", said)) == codes
    assert ("also distance of the cutter from jaw by " in said) == (codes == ["VP210"])
    end = re.search(rf"within limits if line 9 ends at Z (\S+) instead of {depth}", said)
    assert end is not None, said
    assert "no work offset near" not in said
    assert re.search(r"Z -17\.99[78] in place of", run("explain", f"{path}:9", "--machine", "ac_trunnion").out)
    for more, found in ((0.0, 0), (-0.2, 1)):
        path.write_text(text.format(float(end[1]) + more), encoding="utf-8")
        assert run("check", path, "--machine", "ac_trunnion").code == found


@pytest.mark.parametrize("end", [26, 44, 45, 60, 80])
def test_a_line_into_a_vise_ends_before_it(end: int, tmp_path: Path, run: Callable[..., Any]) -> None:
    """The deeper the cutter went, the farther off another end was proposed: X-4.1 instead of 60, and X4.9 of 45."""
    program = tmp_path / "part.nc"
    program.write_text(
        "G21 G90 G17 G54\nT1 M6\nS5000 M3\nG0 X-60 Y0\nG0 G43 H1 Z20\nG0 Z-5\nG1 X0 F1000\nG0 X20 Y10\n"
        f"G1 Z-15 F500\nG1 X{end}\nG0 Z50\nM30\n",
        encoding="utf-8",
    )
    Path(f"{program}.toml").write_text("tools.1 = { length = 100, diameter = 10 }\nwcs.G54 = [0, 0, 150]\n")
    answer = run("check", program, "--keep-out", "vise@G54=30,-30,-20,70,30,5")
    assert f"tried: within limits if line 10 ends at X 24.9 instead of {end}\n" in answer.out


#: The corners of its arc are rounded and deeper than the lines beside them.
RIB = (
    "0 BEGIN PGM RIB MM\n1 TOOL CALL 5 Z S12000 F1800\n2 CYCL DEF 32.0 TOLERANCE\n3 CYCL DEF 32.1 T0.02\n"
    "4 CYCL DEF 32.2 HSC-MODE:0 TA0.1\n5 L Z+100 R0 FMAX M3\n6 L X-40 Y-20 A-10 C+0 R0 FMAX\n7 M128 F5000\n"
    "8 L X-40 Y-20 Z+10 FMAX M8\n9 L X-40.000 Y-20.000 Z-6.000 A-10.000 C+0.000 F1800\n"
    "10 L X-36.667 Y-19.583 Z-5.478 A{} C+2.500\n11 L X-33.333 Y-19.167 Z-4.965 A{} C+5.000\n"
    "12 L Z+50 FMAX M9\n13 M129\n14 L A+0 C+0 R0 FMAX M5\n15 M30\n16 END PGM RIB MM\n"
)


@pytest.mark.parametrize(("machine", "z"), [("verne", 0), ("verne", -4), ("ac_trunnion", -20), ("verne", 5.99)])
def test_a_corner_that_is_deeper_than_its_line_is_lifted_too(
    machine: str, z: float, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """The line alone was within limits at the place before, and the search ended there: no offset was found."""
    path = tmp_path / "rib.h"
    path.write_text(RIB.format(-13.916, -17.765), encoding="utf-8")
    given = ("--machine", machine, "--tool-length", 100)
    said = run("check", path, *given, "--wcs", f"G54=0,0,{z}").out
    found = re.search(r"tried: within limits if the part is moved by .* \(then (G54 = .*)\)\n", said)
    assert found is not None, said
    assert float(found[1].rpartition(",")[2]) == pytest.approx(6.1, abs=0.11)
    assert run("check", path, *given, "--wcs", found[1].replace(" ", "")).code == 0


def test_explain_names_fit_where_the_place_of_the_part_changes_the_tilt(
    tmp_path: Path, run: Callable[..., Any]
) -> None:
    """A line that begins and ends beyond the tilt: it said that no move within 1000 mm helps, and had tried none."""
    path = tmp_path / "rib.h"
    path.write_text(RIB.format(-100, -104), encoding="utf-8")
    for machine, is_platform in (("verne", True), ("ac_trunnion", False)):
        given = ("--machine", machine, "--tool-length", 100, "--wcs", "G54=0,0,80")
        told = run("explain", f"{path}:12", *given).out
        if is_platform:
            assert "VP102" in told
            assert "no other table solution was found; the part was not moved" in told
            assert f"`verne-post fit {path} --machine {machine} " in told
        assert "no move within" not in told


def test_a_small_move_is_proposed_on_and_beside_an_axis_of_symmetry(tmp_path: Path, run: Callable[..., Any]) -> None:
    """On the pole of the wrist no direction is better than its reverse; beside it, Z alone would need 230 mm."""
    program = tmp_path / "pole.nc"
    program.write_text("G21 G90 G94\nG0 X0 Y0 Z30 A0 C0\nG1 Z10 F1000\nM2\n", encoding="utf-8")
    for y, farthest in ((0, 15.0), (-12, 3.0)):
        said = run("check", program, "--machine", "tricept", "--tool-length", 60, "--wcs", f"G54=0,{y},60").out
        found = re.search(r"within limits if the part is moved by (.*) mm \(then G54 = ", said)
        assert found, said
        assert math.hypot(*(float(word) for word in found[1].split(","))) < farthest


#: A tool axis beyond the travel of the tilt in each language: name, program, the line, what stands between its numbers.
VECTORS = [
    ("a.cls", "UNITS/MM\nMULTAX/ON\nLOADTL/1\nSPINDL/RPM,8000,CLW\nRAPID\nGOTO/0,0,60,0,0,1\nFEDRAT/MMPM,500\n"
     "GOTO/10,4,8,0.84,0.42,-0.342\nGOTO/10,4,50,0,0,1\nFINI\n", 8, ("", ",", ",")),
    ("a.mpf", "G17 G71 G90\nT1 D1\nM6\nTRAORI\nG54\nS8000 M3\nG0 X0 Y0 Z60 A3=0 B3=0 C3=1\nG1 Z20 F500\n"
     "X10 Y4 Z8 A3=0.84 B3=0.42 C3=-0.342\nX10 Y4 Z50 A3=0 B3=0 C3=1\nM30\n", 9, ("A3=", " B3=", " C3=")),
    ("a.h", "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S8000\n2 M3\n3 M128\n4 L X+0 Y+0 Z+60 A+0 C+0 R0 FMAX\n"
     "5 LN X+10 Y+4 Z+8 TX+0.84 TY+0.42 TZ-0.342 F500\n6 LN X+10 Y+4 Z+50 TX+0 TY+0 TZ+1\n7 M30\n"
     "8 END PGM A MM\n", 6, ("TX+", " TY+", " TZ")),
    ("a.nc", "%\nO1\nG17 G21 G90\nT1 M6\nG54\nS8000 M3\nG43.5 H1\nG0 X0. Y0. Z60. I0. J0. K1.\n"
     "G1 X10. Y4. Z8. I0.84 J0.42 K-0.342 F500.\nX10. Y4. Z50. I0. J0. K1.\nM30\n%\n", 9, ("I", " J", " K")),
]  # fmt: skip


@pytest.mark.parametrize(("name", "program", "line", "words"), VECTORS, ids=lambda value: str(value)[:5])
def test_less_tilt_of_a_tool_axis_is_given_in_the_words_of_its_line(
    name: str, program: str, line: int, words: tuple[str, ...], tmp_path: Path, run: Callable[..., Any]
) -> None:
    """It was an angle A, a word that these programs do not have."""
    path, setup = tmp_path / name, tmp_path / "s.toml"
    setup.write_text("[wcs]\nG54 = [0, -12, 80]\n[tools]\n1 = { length = 80, diameter = 8 }\n", "utf-8")
    path.write_text(program, "utf-8")
    told = [run(*one, "--setup", setup).out for one in (("check", path), ("explain", f"{path}:{line}"))]
    found = [re.search(r"line ends with the tool axis (.*) instead of (.*), the tip as it is", one) for one in told]
    assert found[0] is not None, told[0]
    assert found[1] is not None, told[1]
    then, now = found[0].groups()
    assert found[1].groups() == (then, now)
    number = r"(-?[\d.]+)"
    vector = re.fullmatch(number.join(map(re.escape, words)) + number, then)
    assert vector is not None, then
    i, j, k = map(float, vector.groups())
    assert math.isclose(math.hypot(i, j, k), 1.0, abs_tol=1e-6)
    assert i / j == pytest.approx(2.0, abs=1e-5), "the turn stays"
    assert k < 0.0, "no more than the limit asks for"
    path.write_text(program.replace(now, then), "utf-8")
    assert run("check", path, "--setup", setup).code == 0


#: The same tilt by words that cannot be written anew: where they are incremental, of a variable, or computed.
COMPUTED = [
    ("a.nc", "G21 G90 G94 G54\n#1=101\nG0 X0 Y0 Z100 A0 C0\nG1 Z60 F500\nG1 X10 A#1\nG1 A60\nM30\n", 5),
    ("b.nc", "G21 G90 G94 G54\nG0 X0 Y0 Z100 A0 C0\nG1 Z60 F500 A50\nG91 G1 X10 A51\nG1 A-41\nG90\nM30\n", 4),
    ("a.mpf", "G17 G54 G90 G94 G710\nTRAORI\nG0 X0 Y0 Z100 A0 C0\nG1 Z60 F500\nX10 A=(100+1)\nA60\nM30\n", 5),
    (
        "a.h",
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nM128\nL X+0 Y+0 Z+100 A+0 C+0 R0 FMAX M3\nL Z+60 F500 A+50\n"
        "L X+10 IA+51\nL A+60\nM30\nEND PGM A MM\n",
        6,
    ),
]


@pytest.mark.parametrize(("name", "program", "line"), COMPUTED, ids=lambda value: str(value)[:5])
def test_less_tilt_of_computed_words_is_a_sentence_without_an_edit(
    name: str, program: str, line: int, tmp_path: Path, run: Callable[..., Any]
) -> None:
    (tmp_path / name).write_text(program, "utf-8")
    given = ("--tool-length", 80, "--wcs", "G54=0,0,40")
    said = r"within limits if the line ends at A 97\.6\d+ instead of A 101, tip and C as they are"
    assert re.search(said, run("explain", f"{tmp_path / name}:{line}", *given).out)
    told = run("check", tmp_path / name, *given, "--output-format", "jsonl").out
    (item,) = (one for one in map(json.loads, told.splitlines()) if one.get("code") == "VP102")
    remedies = json.dumps(item)
    assert re.search(f"line {line} alone: {said}", remedies)
    assert '"97.6' not in remedies


def test_less_tilt_keeps_the_comma_of_its_word(tmp_path: Path, run: Callable[..., Any]) -> None:
    """A-101,5 was read as -101: the remedy was lost."""
    line = "6 L X+10,5 A-101,5 F500"
    word = find_word_of(line, "A", -101.5)
    assert word is not None
    assert change_number(line, word, "-97.5") == "6 L X+10,5 A-97,5 F500"
    assert add_angle("6 L X+10,5 F500", "A", "-97") == "6 L X+10,5 A-97 F500"
    (tmp_path / "a.h").write_text(
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nM128\n4 L X+0 Y+0 Z+100 A+0 C+0 R0 FMAX M3\n5 L Z+60 F500 A-60\n"
        f"{line}\n7 L A-60\n8 L Z+100 A+0\nM30\nEND PGM A MM\n",
        "utf-8",
    )
    told = run("check", tmp_path / "a.h", "--tool-length", 80, "--wcs", "G54=0,0,40").out
    assert "line 6 alone: within limits if the line ends at A -97.686 instead of A -101.5" in told


def test_a_component_of_a_vector_is_no_negative_zero() -> None:
    line = "X10 A3=0 B3=-0.99 C3=-0.2"
    assert change_vector(line, "siemens", (-0.0, -0.9, -1e-9)) == ("A3=0 B3=-0.99 C3=-0.2", "A3=0 B3=-0.9 C3=0.")


def test_a_line_that_begins_beyond_the_tilt_names_the_line_before(run: Callable[..., Any]) -> None:
    """Line 11 ends at A60: no words of it help."""
    told = run("explain", f"{SAMPLES / 'violates_tilt.nc'}:11").out
    assert "line 11 begins at A 101 of line 10: correct line 10 first" in told


def test_another_branch_of_a_line_is_tried_with_both_of_its_ends(tmp_path: Path, run: Callable[..., Any]) -> None:
    """It was proposed for the end alone of a line that begins beyond the limit, and changed nothing there."""
    narrow, program = tmp_path / "narrow.toml", tmp_path / "p.nc"
    original = (SAMPLES.parent / "machine_configs" / "verne.toml").read_text(encoding="utf-8")
    narrow.write_text(original.replace("a_deg = [-95.0, 95.0]", "a_deg = [-20.0, 110.0]"), "utf-8")
    program.write_text("G21 G90 G94\nG0 X0 Y0 Z120 A0 C0\nG1 X5 A-50 C10 F900\nG1 X10 A20 C0\nM2\n", "utf-8")
    given = ("--machine", narrow, "--tool-length", 80, "--wcs", "G54=0,-12,80")
    told = run("explain", f"{program}:4", *given).out
    assert "VP102 error" in told
    assert "same tool axis" not in told
    assert "line 4 begins at A -50 of line 3" in told


def test_a_move_of_the_part_has_no_traces_that_nothing_needs(tmp_path: Path, run: Callable[..., Any]) -> None:
    """It was -9.7, -9.7, 0.2 mm, and the program can run with -9.7, -9.7, 0."""
    program = tmp_path / "p.nc"
    program.write_text(
        "G21 G90 G94 G54\nS5000 M3\nG0 X0 Y0 Z60 A0 C0\nG1 Z-20 A20 F500\nX10 Z-25\nX20 Y30 Z-28 A40\nG0 Z60\nM2\n",
        "utf-8",
    )
    given = ("--machine", "tricept", "--tool-length", 80)
    told = run("check", program, *given, "--wcs", "G54=0,0,10").out
    moved = re.search(r"if the part is moved by (.*) mm \(then (G54 = .*)\)", told)
    assert moved is not None, told
    assert moved[1].endswith(", 0"), "not 0.2"
    assert run("check", program, *given, "--wcs", moved[2]).code == 0


_DRILLED = {
    "a.mpf": "G17 G54 G90 G94 G710\nT1 D1\nM6\nS900 M3 F200\nG0 A0 C0\nX0 Y0 Z50\nMCALL CYCLE82(20,0,2,{},,0.2)\n"
    "X-20 Y5\nX20\nMCALL\nG0 Z50\nM30\n",
    "a.nc": "%\nO1\nG21 G90 G17 G94\nT1 M6\nS900 M3\nG54 G0 A0. C0.\nG0 X0. Y0.\nG43 H1 Z50.\n"
    "G81 X-20. Y5. Z{} R3. F200.\nX20.\nG80\nG0 Z60.\nM30\n%\n",
    "a.h": "BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+50 A+0 C+0 R0 FMAX M3\nCYCL DEF 200 DRILLING ~\nQ200=+2 ~\n"
    "Q201={} ~\nQ206=+200 ~\nQ202=+200 ~\nQ210=+0 ~\nQ203=+0 ~\nQ204=+15 ~\nQ211=+0\nL X-20 Y+5 FMAX M99\n"
    "L X+20 FMAX M99\nL Z+60 FMAX\nM30\nEND PGM A MM\n",
    "a.cls": "PARTNO/A\nUNITS/MM\nLOADTL/1\nSPINDL/900,RPM,CLW\nRAPID\nGOTO/-20,5,50,0,0,1\n"
    "CYCLE/DRILL,DEPTH,{},MMPM,200,CLEAR,2\nGOTO/-20,5,0,0,0,1\nGOTO/20,5,0,0,0,1\nCYCLE/OFF\nRAPID\n"
    "GOTO/20,5,60,0,0,1\nFINI\n",
}
_DIALECTS = {"a.mpf": "siemens", "a.nc": "fanuc", "a.h": "heidenhain", "a.cls": "aptcl"}


@pytest.mark.parametrize(
    ("name", "depth", "said"),
    [
        ("a.mpf", "-150", "DP -15 may be meant instead of -150 in line 7"),
        ("a.mpf", "-25", ""),  # a hole that is 5 mm too deep has no point in the wrong place
        ("a.nc", "-150.", "Z -15. may be meant instead of -150. in line 9"),
        ("a.nc", "-25.", ""),
        ("a.h", "-150", "Q201 -15 may be meant instead of -150 in line 6"),
        ("a.cls", "150.0", "DEPTH 15. may be meant instead of 150.0 in line 7"),
    ],
)
def test_a_depth_with_its_point_one_place_off_is_named(name: str, depth: str, said: str) -> None:
    """The part alone was to be raised by 130 mm."""
    tools = {1: vp.Tool(1, 1, (0.0, 0.0, 120.0, *(0.0,) * 6))}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 20)}, dialect=_DIALECTS[name])
    errors = [one for one in vp.check(_DRILLED[name].format(depth), "verne", options).findings if one.remedies]
    assert errors
    assert ("may be meant instead" in errors[0].remedies[0]) == bool(said)
    assert said in errors[0].remedies[0]
    if said:
        edit = errors[0].edits[0]
        right = _DRILLED[name].format(depth.replace("150", "15").removesuffix("0"))
        assert not [one for one in vp.check(right, "verne", options).findings if one.severity == "error"]
        assert edit.is_choice


def test_a_number_of_goto_that_lost_its_point_is_named() -> None:
    points = "".join(f"GOTO/{x},0,{z},0,0,1\n" for x, z in ((0, "0.500"), (5, 800), (9, "0.500"), (12, "0.400")))
    program = (
        f"PARTNO/A\nUNITS/MM\nLOADTL/1\nSPINDL/900,RPM,CLW\nRAPID\nGOTO/0,0,9,0,0,1\nFEDRAT/600,MMPM\n{points}FINI\n"
    )
    tools = {1: vp.Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6))}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 60)}, dialect="aptcl")
    first = next(one for one in vp.check(program, "verne", options).findings if one.remedies)
    assert first.remedies[0] == "z 0.800 may be meant in line 9, its point is missing: within limits with it"
    (edit, *_others) = first.edits
    assert program.splitlines()[8].replace(edit.misspelt, edit.value) == "GOTO/5,0,0.800,0,0,1"


def test_a_turn_to_a_plane_names_the_line_that_has_its_angles(tmp_path: Path, run: Callable[..., Any]) -> None:
    """G53.1 has no number that could be corrected."""
    path = tmp_path / "a.nc"
    head = "%\nO1\nG90 G94 G17 G21\nT1 M6\nS900 M3\nG54 G0 A0. C0.\nX-20. Y0.\nG43 H1 Z50.\n"
    given = [path, "--dialect", "fanuc", "--tool-length", "80", "--wcs", "G54=0,0,100", "--machine", "verne"]
    cut = "G0 X-15. Y5.\nZ10.\nG1 Z2. F300.\nX15.\nG0 Z40.\nG69\nG0 A0. C0.\nM30\n%\n"
    for turn, is_told in (("G53.1", True), ("A-160. C0.", False)):
        path.write_text(f"{head}G68.2 X0. Y0. Z0. I0. J200. K0.\n{turn}\n{cut}")
        said = "correct the angles of G68.2 in line 9 first: line 10 turns the table to this plane"
        told = run("check", *given)
        assert "VP102 error" in told.out
        assert (f"not tried: {said}" in told.out) == is_told
        if is_told:
            assert said in run("explain", f"{path}:10", *given[1:]).out


#: Programs in which the plane may be the first that says how the table stands.
_FANUC_PLANE = (
    "%\nO1\nG90 G94 G17 G21\nG91 G28 Z0.\nG90\nT1 M6\nS900 M3\nG54\n{}G68.2 X0. Y0. Z-10. I0. J-125. K0.\nG53.1\n"
    "G0 X0. Y0.\nG43 H1 Z50.\nG1 Z40. F300.\nG0 Z50.\nG69\nG0 A0. C0.\nM30\n%\n"
)
_SIEMENS_PLANE = (
    "G17 G71 G90 G94 G54\nT1 M6\nD1 S900 M3\nCYCLE800()\n{}G0 SUPA Z0 D0\n"
    'CYCLE800(0,"TC1",0,57,0,0,0,-125,0,0,0,0,0,-1)\n'
    "G0 X0 Y0\nZ50 D1\nG1 Z40 F300\nG0 Z50\nCYCLE800()\nG0 A0 C0\nM30\n"
)
_KLARTEXT_PLANE = (
    "BEGIN PGM A MM\nTOOL CALL 1 Z S900 F300\nM3\n{}L Z+0 R0 FMAX M91\n"
    "PLANE SPATIAL SPA-125 SPB+0 SPC+0 TURN FMAX TABLE ROT\nL X+0 Y+0 R0 FMAX\nL Z+50 FMAX\nL Z+40 F200\n"
    "L Z+50 R0 FMAX\nPLANE RESET TURN FMAX\nM30\nEND PGM A MM\n"
)


@pytest.mark.parametrize(
    ("program", "before", "turning", "plane"),
    [
        (_FANUC_PLANE, "G0 A0. C0.\n", "G53.1", "G68.2"),
        (_SIEMENS_PLANE, "G0 A0 C0\n", "CYCLE800(0", "CYCLE800"),
        (_KLARTEXT_PLANE, "L A+0 C+0 R0 FMAX\n", "PLANE SPATIAL", "PLANE SPATIAL"),
    ],
)
def test_the_first_tilt_is_told_at_the_block_that_turns_the_table(
    program: str, before: str, turning: str, plane: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """The program starts at the angle that its first plane has: the lines before, and A0 behind, are not at fault."""
    place = {"tools": {1: (90.0, 6.0)}, "wcs": {"G54": (0, 100, 100)}}
    for head in ("", before):
        lines = program.format(head).splitlines()
        at = next(n for n, one in enumerate(lines, 1) if one.startswith(turning))
        said = at - (turning == "G53.1")
        found = vp.check("\n".join(lines), "ac_trunnion", vp.Options(**place)).errors
        (item,) = (one for one in found if one.code == "VP102")
        assert item.line == at and (item.last_line or 0) > at + 4
        assert item.remedies[0].startswith(f"not tried: correct the angles of {plane} in line {said} first")
        assert item.plane == (plane, said)
    path = tmp_path / "a.h"
    path.write_text(program.format(""))
    given = ("--tool-length", "90", "--wcs", "G54=0,100,100", "--machine", "ac_trunnion")
    told = json.loads(run("check", path, *given, "--output-format", "json").out)["programs"][0]["findings"]
    results = json.loads(run("check", path, *given, "--output-format", "sarif").out)["runs"][0]["results"]
    of_json, of_sarif = ([one for one in found if "VP102" in one.values()] for found in (told, results))
    named = {"word": plane, "line": said - 1}
    assert [of_json[0]["plane"], of_sarif[0]["properties"]["plane"]] == [named, named]
    at, said = at - 1, said - 1
    for line in (at, at + 2, at + 3):
        assert f"correct the angles of {plane} in line {said} first" in run("explain", f"{path}:{line}", *given).out


_FIRST_PLANE = (
    "O1\nG21 G90 G94 G17 G40 G49 G80 G54\nT1 M6\nS3000 M3\nG43 H1\nG0 X{}. Y0.\nG68.2 X0 Y0 Z0. I90. J{}. K0.\nG53.1\n"
    "G0 Z300.\nG1 Z290. F500.\nG69\nM30\n"
)
_CALLED_PLANE = {
    "T.H": "BEGIN PGM T MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 R0 FMAX M3\nCALL PGM UP\nM30\nEND PGM T MM\n",
    "UP.H": "BEGIN PGM UP MM\nPLANE SPATIAL SPA+110 SPB+0 SPC+0 TURN FMAX\nL Z+50 FMAX\nL X+10 F900\nL Z+100 FMAX\n"
    "PLANE RESET TURN FMAX\nEND PGM UP MM\n",
}


@pytest.mark.parametrize(
    ("files", "code", "place"),
    [
        ({"O1.nc": _FIRST_PLANE.format(0, 110)}, "VP110", (8, None)),
        ({"O1.nc": _FIRST_PLANE.format(4000, 20)}, "VP110", (6, None)),
        (_CALLED_PLANE, "VP102", (4, 2)),
    ],
)
def test_the_place_before_a_plane_is_blamed_only_where_another_height_or_angle_would_not_do(
    files: dict[str, str], code: str, place: tuple[int, int | None], tmp_path: Path
) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    options = vp.Options(tool_length=85.0, wcs={"G54": (0, 0, 60)})
    first = vp.check(tmp_path / next(iter(files)), "verne", options).errors[0]
    assert (first.code, first.line, first.called and first.called.line) == (code, *place)


def test_a_tilt_of_words_is_told_at_them_though_a_plane_follows() -> None:
    program = _FANUC_PLANE.format("G0 A-125. C0.\n")
    options = vp.Options(tools={1: (90.0, 6.0)}, wcs={"G54": (0, 100, 100)})
    (item,) = (one for one in vp.check(program, "ac_trunnion", options).errors if one.code == "VP102")
    assert (item.line, any("plane" in one for one in item.remedies)) == (9, False)


def test_a_tip_below_the_table_names_the_plane_that_turns_it() -> None:
    head = "%\nO1\nG90 G94 G17 G21\nT1 M6\nS900 M3\nG54 G0 A0. C0.\nX-20. Y0.\nG43 H1 Z50.\n"
    cut = "G68.2 X0. Y0. Z0. I0. J-85. K0.\nG53.1\nG0 X0. Y70. Z20.\nG1 Z2. F300.\n"
    options = vp.Options(tools={1: (80.0, 6.0)}, wcs={"G54": (0, 0, 60)}, dialect="fanuc")
    found = vp.check(f"{head}{cut}G0 Z40.\nG69\nM30\n%\n", "ac_trunnion", options).findings
    (item,) = (one for one in found if one.code == "VP210")
    assert item.message.endswith("; the plane of G68.2 in line 9 turns the table to A-85 C0")
    (level,) = vp.check(f"{head}G1 Z-70. F300.\nM30\n%\n", "ac_trunnion", options).errors
    assert (level.code, "plane" in level.message) == ("VP210", False)
