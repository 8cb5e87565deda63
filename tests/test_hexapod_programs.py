"""Programs on platforms that six legs hold, end to end; the judge of written files has equations of its own."""

import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import verne_post
from tests.kinematics.test_carrier_descriptions import read
from tests.kinematics.test_hexapod import NAMES, judge

ROOT = Path(__file__).resolve().parents[1]
LENGTH = 90.0  # of the judge
HEAD = "G21 G90 G94 G17\nG0 X10 Y0 Z60 {words}\nG1 Z30 F1000\n"
Runner = Callable[..., Any]


def follow_rows(name: str, csv: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Every tenth row of a file by the judge, each solved from the one before: numbers, lines, tip and tool axis in the
    part frame.
    """
    data, table = read(name), np.genfromtxt(io.StringIO(csv), delimiter=",", names=True)[::10]
    columns = [f"{joint}_mm" for joint in data["carrier"]["actuators"]]
    assert list(table.dtype.names or ()) == ["t_s", *columns, "a_deg", "c_deg", "line"]
    values = np.column_stack([table[column] for column in columns])
    at, poses = np.append(np.array(data["carrier"]["home"]), np.zeros(3)), []
    for now in values[:, None]:
        for _ in range(6):  # Newton, by differences of the judge
            ways = at + 1e-6 * np.vstack([np.zeros(6), np.eye(6)])
            off = judge(now, ways[:, :3], Rotation.from_rotvec(ways[:, 3:]), data)[0]
            at = at - np.linalg.solve((off[1:] - off[0]).T / 1e-6, off[0])
            if np.abs(off[0]).max() < 1e-6:  # the step after this one is below rounding
                break
        poses.append(at)
    found = np.array(poses)
    misfit, tip, axis = judge(values, found[:, :3], Rotation.from_rotvec(found[:, 3:]), data)
    assert np.abs(misfit).max() < 1e-7
    angles = np.radians(np.column_stack([table["a_deg"], table["c_deg"]]))
    stated = Rotation.from_euler("ZX", angles[:, ::-1]).apply([0.0, 0.0, 1.0])
    assert np.abs(stated - axis).max() < 1e-7  # what the last two columns say is where the tool points
    return np.column_stack([values, np.degrees(angles)]), table["line"], tip, axis


@pytest.mark.parametrize("name", NAMES)
def test_tips_and_axes_of_a_program(name: str, run: Runner, tmp_path: Path) -> None:
    """Straight, round and tilting moves, one that passes upright, G53, by a judge that shares nothing with the package;
    verify agrees.
    """
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text(
        HEAD.format(words="A10 C0") + "X40 Y20 A-10\nX20 Y40 C70\nG3 X0 Y20 I-20 J0\nG1 X20 Y0 A8 C30\nG53 G0 Z0\nM2\n",
        encoding="utf-8",
    )
    options = ["--machine", name, "--tool-length", f"{LENGTH:g}", "--wcs", "G54=5,-8,2"]
    answer = run("convert", source, *options, "-o", axes)
    assert answer.code == 0, answer.out + answer.err
    _values, line, tip, axis = follow_rows(name, axes.read_text(encoding="utf-8"))
    for number, place, a, c in ((4, [40, 20, 30], -10, 0), (5, [20, 40, 30], -10, 70), (7, [20, 0, 30], 8, 30)):
        near = np.flatnonzero(np.abs(line - number) <= 1)
        away = np.linalg.norm(tip[near] - np.array(place) - [5, -8, 2], axis=1)
        assert away.min() < 0.2  # rows of 10 ms at 1000 mm/min
        wanted = Rotation.from_euler("ZX", [c, a], degrees=True).apply([0.0, 0.0, 1.0])
        assert np.linalg.norm(axis[near[np.argmin(away)]] - wanted) < np.radians(0.4)
    # machine coordinates are those of the gauge point, 0 at home
    data = read(name)
    at_home = data["chain"]["part_zero"][2] - data["chain"]["gauge"][2]
    assert (tip[-1] + LENGTH * axis[-1])[2] == pytest.approx(at_home, abs=2e-3)
    assert run("verify", axes, "--against", source, *options).code == 0


SAMPLES = {
    "hexapod": ("posted.nc", "inverse_time.nc", "two_faces.h", "wing.cls", "fanuc_tilted.nc"),
    "hexam": ("posted.nc", "two_faces.mpf", "wing.cls"),
    "hexaglide": ("inverse_time.nc", "two_faces.mpf", "wing.cls"),
}


@pytest.mark.parametrize(("name", "sample"), [(name, sample) for name in NAMES for sample in SAMPLES[name]])
def test_samples_are_converted(name: str, sample: str, run: Runner, tmp_path: Path) -> None:
    """To rows that are verified as they are written; files of these machines are read again in the test above."""
    axes = tmp_path / "axes.csv"
    answer = run("convert", ROOT / "gcode_samples" / sample, "--machine", name, "-o", axes)
    assert answer.code == 0, answer.out + answer.err
    assert "verified" in answer.err
    assert axes.exists()


@pytest.mark.parametrize(("by", "turn"), [(0.05, 30.0), (-0.05, 30.0), (0.0, 30.005)])
def test_a_wrong_strut_or_turn_is_found(by: float, turn: float, run: Runner, tmp_path: Path) -> None:
    """Of a tilted tool axis a C of 0.005 degrees is too, at a standstill."""
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text(HEAD.format(words="A10 C30") + "X30 Y20\nM2\n", encoding="utf-8")
    options = ["--machine", "hexapod", "--tool-length", "90", "--wcs", "G54=0,0,0"]
    assert run("convert", source, *options, "-o", axes).code == 0
    head, *rows = axes.read_text(encoding="utf-8").splitlines()
    for k in range(len(rows) // 2, len(rows)):
        cells = rows[k].split(",")
        cells[2] = f"{float(cells[2]) + by:.7f}"
        rows[k] = ",".join(cells)
    axes.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    source.write_text(HEAD.format(words=f"A10 C{turn:g}") + "X30 Y20\nM2\n", encoding="utf-8")
    refused = run("verify", axes, "--against", source, *options)
    assert refused.code != 0
    assert "VP411" in refused.out + refused.err


def test_the_last_two_columns_drive_nothing(run: Runner, tmp_path: Path) -> None:
    """Drives are those of the six; the two numbers go out in degrees as they are."""
    text = (ROOT / "machine_configs/hexapod.toml").read_text(encoding="utf-8")
    drives = "".join(f'[drives.l{k}]\nunit = "counts"\nscale = 1000.0\n' for k in range(1, 7))
    machine = tmp_path / "mine.toml"
    machine.write_text(text.replace("[home] ", drives + "[home] ", 1) + 'drives = "assumed"\n', encoding="utf-8")
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text(HEAD.format(words="A10 C30") + "M2\n", encoding="utf-8")
    options = ["--machine", machine, "--tool-length", "90", "--wcs", "G54=0,0,0", "--units", "drive"]
    answer = run("convert", source, *options, "-o", axes)
    assert answer.code == 0, answer.out + answer.err
    head, first = axes.read_text(encoding="utf-8").splitlines()[:2]
    assert head == "t_s,l1_counts,l2_counts,l3_counts,l4_counts,l5_counts,l6_counts,a_deg,c_deg,line"
    assert [float(cell) for cell in first.split(",")[7:9]] == pytest.approx([10.0, 30.0], abs=1e-6)
    assert run("verify", axes, "--against", source, *options).code == 0
    machine.write_text(
        text.replace("[home] ", drives + '[drives.a]\nunit = "counts"\n[home] ', 1) + 'drives = "assumed"\n',
        encoding="utf-8",
    )
    assert "drives.a is no joint of this machine" in run("convert", source, *options, "-o", axes).err


def test_a_turn_of_c_alone_at_the_pole_is_refused(run: Runner, tmp_path: Path) -> None:
    source = tmp_path / "part.nc"
    source.write_text(HEAD.format(words="A0 C0") + "G0 C45\nM2\n", encoding="utf-8")
    options = ["--machine", "hexapod", "--tool-length", "90", "--wcs", "G54=0,0,0"]
    refused = run("check", source, *options)
    assert refused.code != 0
    assert "other table solution" not in refused.out
    assert (
        "VP202 error: the tool is along the axis of C while C turns by 45.000 deg: the joints follow from the "
        "tool axis" in refused.out
    )


def test_legs_beyond_their_cones_are_one_finding_that_names_each(run: Runner) -> None:
    """One finding a leg and stretch without a leg's name, five of them in one line, told nobody which leg it was."""
    refused = run("check", ROOT / "gcode_samples/blade_5axis.nc", "--machine", "hexapod").out
    errors = re.findall(r"(VP\d+) error: (.*)", refused)
    assert [code for code, _text in errors] == ["VP214", "VP110"]
    assert errors[0][1].startswith("angle left to the leg's joint on the platform (l3) -0.506 deg is below 0 deg")
    others = re.search(r"= also (.*)", refused)
    assert others is not None
    legs = re.findall(r"(?:^|; )(l\d) by [\d.]+ deg in lines \d+ to \d+", others[1])
    assert sorted(legs) == ["l1", "l2", "l3", "l4", "l5", "l6"]
    assert "as for VP214" not in refused


@pytest.mark.parametrize(
    ("machine", "said"),
    [
        ("hexapod", "the platform would turn 60 degrees from home or more (carrier.largest_turn_deg)"),
        ("hexaglide", "no slider position satisfies the rod lengths with the platform turned less than 60 degrees"),
        ("tricept", "the central leg would turn 60 degrees from home or more (carrier.largest_turn_deg)"),
        ("verne", "no slider position satisfies the rod lengths"),
    ],
)
def test_out_of_reach_is_said_in_the_words_of_the_machine(machine: str, said: str, run: Runner, tmp_path: Path) -> None:
    """Struts have a length for every pose: what bounds them is a turn."""
    source = tmp_path / "part.nc"
    end = "A120" if machine == "hexapod" else "Y6000"
    source.write_text(f"G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 {end} F1000\nM2\n", encoding="utf-8")
    refused = run("check", source, "--machine", machine, "--tool-length", "50").out
    assert f"part.nc:3: VP110 error: out of reach: {said}" in refused


def test_an_approach_comes_from_joint_values(run: Runner, tmp_path: Path) -> None:
    """Eight values: the last two choose the turn of C. The file begins there, and goes back along the tool to machine Z
    0.

    Values with another turn of the platform about the tool would be left with a jump: refused, with those that fit.
    """
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text(HEAD.format(words="A10 C0") + "X30\nM2\n", encoding="utf-8")
    options = ["--machine", "hexapod", "--tool-length", "90", "--wcs", "G54=0,0,0"]
    wrong = "1063,1083,1076,1060,1045,1044,5,0"
    refused = run("convert", source, *options, "--from", wrong, "-o", axes)
    assert refused.code != 0
    message = refused.out + refused.err
    assert "there the platform is turned about the tool axis otherwise" in message
    values = [float(value) for value in re.findall(r"l[1-6] ([0-9.]+)", message.partition("bring it to")[2])]
    assert len(values) == 6
    start = ",".join(f"{value:.4f}" for value in values) + ",5,0"
    answer = run("convert", source, *options, "--from", start, "-o", axes)
    assert answer.code == 0, answer.out + answer.err
    table = np.genfromtxt(axes, delimiter=",", names=True)
    assert [float(table[0][k]) for k in range(1, 7)] == pytest.approx(values, abs=1e-3)
    assert run("verify", axes, "--against", source, *options, "--from", start).code == 0


def test_explain_and_machine_show(run: Runner, tmp_path: Path) -> None:
    source = tmp_path / "part.nc"
    source.write_text(HEAD.format(words="A10 C30") + "M2\n", encoding="utf-8")
    shown = run(
        "explain", f"{source}:3", "--all", "--machine", "hexapod", "--tool-length", "90", "--wcs", "G54=0,0,0"
    ).out
    assert "as programmed: possible" in shown
    assert "other table solution" not in shown
    assert "distance of the rods of legs l1 and l2" in shown
    senses = run("machine", "show", "hexapod").out
    assert "# A +10: the tool leans towards -y of the part" in senses
    assert "# C +10: with A +10, the tool leans from -y towards +x of the part" in senses


def test_axis_check_moves_the_six_alone(run: Runner, tmp_path: Path) -> None:
    """A and C are no axes to move; what one strut does to nose and tool is that of the machine's forward kinematics."""
    machine, folder = verne_post.load_machine("hexapod"), tmp_path / "check"
    at = [1060.0, 1065.0, 1062.0, 1058.0, 1061.0, 1059.0, 0.0, 0.0]
    answer = run("machine", "axis-check", "--machine", "hexapod", "--at", ",".join(map(str, at)), "-o", folder)
    assert answer.code == 0, answer.err
    names = sorted(path.name for path in folder.glob("*.csv"))
    assert names == [f"{k + 6 * n + 1:02d}_l{k + 1}_{mm}mm.csv" for n, mm in enumerate((1, 10)) for k in range(6)]
    text = " ".join(
        " ".join(path.read_text(encoding="utf-8") for path in folder.glob("*.*") if path.suffix != ".csv").split()
    )
    tip, axis, _ok = machine.forward(np.array([at, [1070.0, *at[1:]]]), 0.0)
    x, y, _z = tip[1] - tip[0]
    leaned = np.degrees(np.linalg.norm(axis[1] - axis[0]))
    assert f"{x:+.4f} mm in x, {y:+.4f} mm in y" in text
    assert f"The tool leans by {leaned:.4f} deg towards" in text


@pytest.mark.parametrize(
    ("name", "body"),
    [
        ("hexapod", "g1 x[-20+#<i>*10] a[-10-#<i>*3] f1200"),
        ("tricept", "g1 x[-20+#<i>*5] a-9 c[40-#<i>*20] f1500"),
        ("hexam", "g91\ng3 x10 y0 i5 j0 a-2 f1500\ng3 x-10 y0 i-5 j0 a2\ng90"),
    ],
)
def test_rows_of_a_tilted_line_that_a_loop_repeats_are_told_apart(name: str, body: str) -> None:
    """With A below 0 they were matched by the angles that the joints tell, whose A is above 0: VP901."""
    program = (
        "g21 g17 g90 g94 g64 p0.01\nt3 m6 g43.4 h3\ns5000 m3\ng0 x-20 y0 z20 a-10 c40\ng1 z0 f800\n#<i> = 1\n"
        f"o100 while [#<i> le 3]\n{body}\n#<i> = [#<i>+1]\no100 endwhile\ng0 z30\nm2\n"
    )
    result = verne_post.convert(program, name, verne_post.Options(tool_length=92, wcs={"G54": (0, 0, 60)}))
    assert [item for item in result.findings if item.severity == "error"] == []


#: A tool that stands upright, where rounded legs lean it towards any C; and tool axes on a great circle that comes near
#: the pole, so that A and C go far from the lines between those of its ends.
UPRIGHT = "G0 X0 Y0 Z20\nG81 X0 Y0 Z-10 R2 F300\nX5\nG80\nG0 Z20\nM2\n"
NEAR_POLE = (
    "G43.5 G0 X0 Y0 Z30 I0.426961 J-0.216257 K0.878031\nG1 X1 Y1 Z29 I-0.421593 J0.150985 K0.894127 F1200\n"
    "Z35 I0 J0 K1\nM2\n"
)


@pytest.mark.parametrize(
    ("name", "cycle", "body"),
    [
        ("hexapod", 0.004, UPRIGHT),
        ("hexaglide", 0.01, UPRIGHT),
        ("hexapod", 0.002, NEAR_POLE),
    ],
    ids=["upright-struts", "upright-sliders", "near-pole"],
)
def test_words_of_the_tool_axes_that_legs_hold_are_those_of_the_program(name: str, cycle: float, body: str) -> None:
    """They were matched with another C, or with the other sign of A: VP901."""
    options = verne_post.Options(tool_length=80, wcs={"G54": (0, 0, 60)}, cycle=cycle)
    result = verne_post.convert("G21 G17 G90 G94\n" + body, name, options)
    assert [item for item in result.findings if item.severity == "error"] == []
