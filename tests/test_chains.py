"""Machines of one chain, end to end: the words of the machine, one part on five machines, and what is refused by name.

The judge of written files moves points by the joints of the machine file, with matrices of its own.
"""

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post as vp
from tests.kinematics.test_chain import judge
from verne_post.app.assemble import assemble, build_interpreter_setup
from verne_post.app.machined import place_on_table
from verne_post.base.rotations import rotate_z
from verne_post.kinematics.checks.keep_out import place_body

ROOT = Path(__file__).resolve().parents[1]
#: Where the part is on each machine.
PLACES = {
    "bc_trunnion": "0,0,0",
    "ac_trunnion": "0,0,0",
    "b_head_c_table": "0,0,0",
    "ca_fork_head": "1000,1000,-200",
    "ab_table": "0,0,0",
    "nutating_table": "0,0,0",
    "nutating_head": "0,0,-200",
}
LENGTH = 100.0
_TILT = np.radians(20.0)
WAY = np.array([(30, 0, 40, 0.2, 0.05), (30, 20, 42, 0.2, 0.2), (-20, 10, 42, -0.25, 0.1), (10, -20, 42, 0.1, -0.2)])

Runner = Callable[..., Any]


def tool_axes(places: np.ndarray) -> np.ndarray:
    return np.column_stack([places[:, 3:5], np.sqrt(1.0 - (places[:, 3:5] ** 2).sum(axis=1))])


def options_of(machine: str) -> list[str]:
    return ["--machine", machine, "--tool-length", f"{LENGTH:g}", "--wcs", f"G54={PLACES[machine]}"]


def read_rows(machine: str, csv: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lines (n,), and tip and tool axis (n, 3) in the work frame by the judge."""
    table = np.genfromtxt(io.StringIO(csv), delimiter=",", names=True)
    text = (ROOT / f"machine_configs/{machine}.toml").read_text(encoding="utf-8")
    names = [name for name in table.dtype.names or () if name.endswith(("_mm", "_deg"))]
    tip, axis = judge(text, {name.split("_")[0]: table[name] for name in names}, LENGTH)
    return table["line"], tip - [float(value) for value in PLACES[machine].split(",")], axis


@pytest.mark.parametrize("machine", PLACES)
def test_one_cl_file_on_every_machine(machine: str, run: Runner, tmp_path: Path) -> None:
    """Tip and tool axis come to every place of the CL file, within the tolerances of [accuracy], whatever the joints
    are.
    """
    source, axes = tmp_path / "part.cl", tmp_path / "axes.csv"
    head = ["PARTNO/TEST", "UNITS/MM", "MULTAX/ON", "LOADTL/1", "RAPID", "GOTO/0,0,80,0,0,1", "FEDRAT/2000,MMPM"]
    numbers = np.column_stack([WAY[:, :3], tool_axes(WAY)])
    source.write_text(
        "\n".join([*head, *("GOTO/" + ",".join(f"{value:.12g}" for value in row) for row in numbers), "FINI\n"])
    )
    answer = run("convert", source, *options_of(machine), "-o", axes)
    assert answer.code == 0, answer.err
    assert run("verify", axes, "--against", source, *options_of(machine)).code == 0
    _line, tip, axis = read_rows(machine, axes.read_text(encoding="utf-8"))
    for place in numbers:
        away, leans = np.linalg.norm(tip - place[:3], axis=1), np.linalg.norm(axis - place[3:], axis=1)
        near = away < 0.01 + 0.05  # rows lie up to 0.05 mm apart: 33 mm/s, a row each ms
        assert near.any()
        assert leans[near].min() < np.radians(0.05) + 1e-4


PROGRAM = """G21 G90 G94 G17
G0 X20 Y-10 Z60 {t}0 {u}0
G1 Z25 F1200
X40 Y15 {t}{s}20 {u}35
G3 X20 Y35 I-20 J0 F900
G1 {t}{s}10 {u}60 F900
G53 G0 Z0
G91 G28 Z0
M2
"""


@pytest.mark.parametrize(
    ("machine", "letters", "sense", "leans"),
    [
        ("bc_trunnion", "BC", "", (0.3420201, 0.0, 0.9396926)),
        ("ac_trunnion", "AC", "-", (0.0, 0.3420201, 0.9396926)),
        ("b_head_c_table", "BC", "", (0.3420201, 0.0, 0.9396926)),
        ("ca_fork_head", "AC", "", (0.0, -0.3420201, 0.9396926)),
    ],
)
def test_words_of_the_machine(
    machine: str, letters: str, sense: str, leans: tuple[float, ...], run: Runner, tmp_path: Path
) -> None:
    """Columns have the words of the program; the tool leans as the joints of the file say; another letter is
    refused.
    """
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    text = PROGRAM.format(t=letters[0], u=letters[1], s=sense)
    source.write_text(text, encoding="utf-8")
    answer = run("convert", source, *options_of(machine), "--smoothing", "off", "-o", axes)
    assert answer.code == 0, answer.err
    csv = axes.read_text(encoding="utf-8")
    assert csv.splitlines()[0] == f"t_s,x_mm,y_mm,z_mm,{letters[0].lower()}_deg,{letters[1].lower()}_deg,line"
    line, tip, axis = read_rows(machine, csv)
    at = np.flatnonzero(line == 4)[-1]
    turn = np.radians(35.0)
    x, y, z = leans
    assert tip[at] == pytest.approx([40, 15, 25], abs=1e-4)
    assert axis[at] == pytest.approx(
        [np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, z], abs=1e-6
    )
    source.write_text(text.replace(letters[0], "B" if letters[0] == "A" else "A"), encoding="utf-8")
    refused = run("check", source, *options_of(machine))
    assert refused.code == 2
    assert f"it has X, Y, Z, {letters[0]}, {letters[1]}" in refused.out
    values = ",".join(csv.splitlines()[1].split(",")[1:6])
    source.write_text(text, encoding="utf-8")
    assert run("convert", source, *options_of(machine), f"--from={values}", "-o", axes).code == 0
    assert run("convert", source, *options_of(machine), "--from", "home", "-o", axes).code == 0


def test_trunnion_is_the_serial_machine_on_its_table(run: Runner, tmp_path: Path) -> None:
    """ac_trunnion as kind serial of schema 1 with the same joints: the same setpoints to 1e-9."""
    serial = (ROOT / "machine_configs/serial.toml").read_text(encoding="utf-8")
    for before, after in (
        ("zero = [0.0, 0.0, 1050.0]", "zero = [0.0, 0.05, -472.3]"),
        ("pivot = [0.0, 0.0, 1600.0]", "pivot = [0.0, 0.0, 0.0]"),
        ("rotary_offset = [0.0, 0.0, 0.0]", "rotary_offset = [0.0, -0.05, 52.3]"),
        ("machine_zero = [0.0, 0.0, 550.0]", "machine_zero = [0.0, 0.0, 420.0]"),
        ("radius = 250.0", "radius = 200.0"),
        ('a_positive = "workpiece"', 'a_positive = "tool"'),
        ('c_positive = "workpiece"', 'c_positive = "tool"'),
        ("[[-400.0, 400.0], [-400.0, 400.0], [-600.0, 100.0]]", "[[-300.0, 300.0], [-300.0, 300.0], [-400.0, 150.0]]"),
        ("a_deg = [-95.0, 95.0]", "a_deg = [-120.0, 30.0]"),
    ):
        assert before in serial
        serial = serial.replace(before, after)
    (tmp_path / "serial.toml").write_text(serial, encoding="utf-8")
    source, tables = tmp_path / "part.nc", []
    source.write_text(
        PROGRAM.format(t="A", u="C", s="-").replace("G53", "G43.5 X10 Y30 I0.1 J0.2 K0.97467943\nG53"), encoding="utf-8"
    )
    for machine in ("ac_trunnion", str(tmp_path / "serial.toml")):
        # blended corners are found by iteration, which multiplies last digits: to 1e-5 mm
        options = ["--machine", machine, "--tool-length", "100", "--wcs", "G54=7,-3,15,25", "--smoothing", "off"]
        answer = run("convert", source, *options, "--decimals", "11", "--accept-rounding")
        assert answer.code == 0, answer.err
        tables.append(np.loadtxt(io.StringIO(answer.out), delimiter=",", skiprows=1))
    assert tables[0].shape == tables[1].shape
    assert np.abs(tables[0] - tables[1]).max() < 1e-9


PLANES = {
    "fanuc": "G0 X0 Y0 Z60 {0}0 {1}0\n"
    "G68.2 X5 Y0 Z0 I{fanuc} J20 K0\n"
    "G53.1\n"
    "G0 X0 Y0 Z40\n"
    "G1 Z25 F500\n"
    "G0 Z60\n"
    "G69\n"
    "M2\n",
    "siemens": 'G17 G90 G71 G94\nTRAORI\nG0 X0 Y0 Z60 {0}0 {1}0\nCYCLE800(1,"",10,57,5,0,0,{siemens},0,0,0,-1)\n'
    "G0 X0 Y0 Z40\nG1 Z25 F500\nG0 Z60\nCYCLE800()\nM30\n",
    "heidenhain": "BEGIN PGM P MM\n"
    "TOOL CALL 1 Z S900\n"
    "M128\n"
    "L X+0 Y+0 Z+60 {0}+0 {1}+0 FMAX\n"
    "CYCL DEF 7.0\n"
    "CYCL DEF 7.1 X+5\n"
    "PLANE SPATIAL {klartext} MOVE DIST0 FMAX\n"
    "L X+0 Y+0 Z+40 FMAX\n"
    "L Z+25 F500\n"
    "L Z+60 FMAX\n"
    "M30\n"
    "END PGM P MM\n",
}


@pytest.mark.parametrize("language", PLANES)
@pytest.mark.parametrize("machine", PLACES)
def test_tilted_planes_under_tcp(machine: str, language: str, run: Runner, tmp_path: Path) -> None:
    """A plane turned about one axis of the part by 20 degrees: the tool comes down 25 mm over it, along its normal."""
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    letters = {"bc_trunnion": "BC", "b_head_c_table": "BC", "ab_table": "AB", "nutating_table": "BC"}.get(machine, "AC")
    about_y = machine != "ac_trunnion"  # its A goes to -120
    angles = (
        {"fanuc": "90", "siemens": "0,20,0", "klartext": "SPA+0 SPB+20 SPC+0"}
        if about_y
        else {"fanuc": "0", "siemens": "20,0,0", "klartext": "SPA+20 SPB+0 SPC+0"}
    )
    source.write_text(PLANES[language].format(*letters, **angles), encoding="utf-8")
    options = [*options_of(machine), "--dialect", language]
    answer = run("convert", source, *options, "-o", axes)
    assert answer.code == 0, answer.err
    assert run("verify", axes, "--against", source, *options).code == 0
    _line, tip, axis = read_rows(machine, axes.read_text(encoding="utf-8"))
    normal = np.array([np.sin(_TILT), 0.0, np.cos(_TILT)] if about_y else [0.0, -np.sin(_TILT), np.cos(_TILT)])
    place = [5.0, 0.0, 0.0] + 25.0 * normal
    nearest = np.linalg.norm(tip - place, axis=1).argmin()
    assert tip[nearest] == pytest.approx(place, abs=0.02)  # the corner is blended
    assert axis[nearest] == pytest.approx(normal, abs=1e-3)


WITHOUT_TCP = {
    "heidenhain": "BEGIN PGM P MM\n"
    "TOOL DEF 1 L+90\n"
    "TOOL DEF 2 L+120\n"
    "TOOL CALL 1 Z S900\n"
    "L X+0 Y+0 Z+90 R0 FMAX\n"
    "L {0}+0 {1}+0 R0 FMAX\n"
    "L {0}{tilt} {1}+{turn} R0 FMAX\n"
    "L X+12 Y-7 Z+65 R0 F900\n"
    "L X+20\n"
    "TOOL CALL 2 Z S900\n"
    "L X+3 Y+4 Z+80 R0 FMAX\n"
    "M30\n"
    "END PGM P MM\n",
    "siemens": "G17 G90 G71 G94\n"
    "T1 M6\n"
    "D1\n"
    "G0 X0 Y0 Z90\n"
    "G0 {0}=0 {1}=0\n"
    "G0 {0}={tilt} {1}={turn}\n"
    "G1 X12 Y-7 Z65 F900\n"
    "X20\n"
    "T2 M6\n"
    "D1\n"
    "G0 X3 Y4 Z80\n"
    "M30\n",
}


@pytest.mark.parametrize("language", WITHOUT_TCP)
@pytest.mark.parametrize("machine", PLACES)
def test_linear_joints_without_tcp(machine: str, language: str, run: Runner, tmp_path: Path) -> None:
    """Without tool-centre-point control X Y Z are the linear joints, however tables and heads stand, the length along
    Z.
    """
    letters = {"bc_trunnion": "BC", "b_head_c_table": "BC", "ab_table": "AB", "nutating_table": "BC"}.get(machine, "AC")
    (tmp_path / "tools.tbl").write_text("T1 P1 Z90 D6\nT2 P2 Z120 D6\n", encoding="utf-8")
    options = ["--machine", machine, "--tool-table", tmp_path / "tools.tbl", "--wcs", f"G54={PLACES[machine]}"]
    options += ["--dialect", language, "--smoothing", "off", "--split-at-stops"]
    ends = []
    for tilt, turn in (("+0", "0"), ("+20" if machine != "ac_trunnion" else "-20", "15")):
        folder = tmp_path / turn
        folder.mkdir()
        source = folder / "part.txt"
        source.write_text(WITHOUT_TCP[language].format(*letters, tilt=tilt, turn=turn), encoding="utf-8")
        answer = run("convert", source, *options, "-o", folder / "axes.csv")
        assert answer.code == 0, answer.err
        rows = np.concatenate(
            [np.loadtxt(file, delimiter=",", skiprows=1) for file in sorted(folder.glob("axes*.csv"))]
        )
        ends.append({int(line): rows[np.flatnonzero(rows[:, -1] == line)[-1], 1:4] for line in np.unique(rows[:, -1])})
    if language == "heidenhain":  # the linear joints stand while table and head turn
        assert np.ptp(rows[rows[:, -1] == 7, 1:4], axis=0).max() < 1e-4
    straight, turned = ends
    both = set(straight) & set(turned)
    assert len(both) > 3
    for line in both:
        assert turned[line] == pytest.approx(straight[line], abs=1e-4)


@pytest.mark.parametrize(
    ("machine", "options", "program", "said"),
    [
        ("ca_fork_head", ["--dialect", "heidenhain"],
         "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nM128\nL X+0 Y+0 Z+60 A+0 C+0 FMAX\nPLANE AXIAL A+10 MOVE DIST0 "
         "FMAX\nM30\nEND PGM P MM\n", "PLANE AXIAL is not executed"),
        ("b_head_c_table", ["--dialect", "siemens"],
         'G90 G71 G94\nTRAORI\nG0 X0 Y0 Z60 B0 C0\nCYCLE800(1,"",10,192,0,0,0,30,0,0,0,0,0,-1)\nM30\n',
         "CYCLE800 by rotary axes directly"),
        ("ab_table", ["--wcs", "G54=0,0,0,30"], "G0 X0 Y0 Z60 A0 B0\nM2\n",
         "a part turned by 30 degrees on the table is not executed"),
        ("b_head_c_table", ["--from", "home"], "G0 X0 Y0 Z60 B89 C0\nG1 X5 F500\nM2\n", "the tool is tilted too far"),
    ],
)  # fmt: skip
def test_what_is_refused_by_name(
    machine: str, options: list[str], program: str, said: str, run: Runner, tmp_path: Path
) -> None:
    source = tmp_path / "part.nc"
    source.write_text(program, encoding="utf-8")
    answer = run("convert", source, *(options_of(machine)[:4] if "--wcs" in options else options_of(machine)), *options)
    assert answer.code == 2
    assert said in answer.err
    assert not answer.out


def test_offsets_and_boxes_are_in_the_part_frame(run: Runner, tmp_path: Path) -> None:
    """On a BC trunnion the frame of the nominal angles is turned against that of the part: what the user gives and
    reads is not.
    """
    source = tmp_path / "part.nc"
    source.write_text("G0 X0 Y0 Z60 B0 C0\nG1 Z30 F900\nX250\nM2\n", encoding="utf-8")
    options = ["--machine", "bc_trunnion", "--tool-length", "100", "--wcs", "G54=100,0,0"]
    answer = run("check", source, *options)
    assert answer.code == 1
    assert "joint x reaches 350.000 mm, 50.000 mm above its travel" in answer.out
    assert "if the part is moved by" in answer.out
    moved = answer.out.partition("if the part is moved by ")[2].partition(" mm")[0].split(", ")
    assert [float(value) for value in moved] == pytest.approx([-50.0, 0.0, 0.0], abs=0.2)  # rounded up to 0.1
    box = ["--keep-out", "block=110,-10,0,130,10,50"]
    assert "VP215" in run("check", source, *options, *box).out
    assert "VP215" not in run("check", source, *options, "--keep-out", "block=-10,110,0,10,130,50").out


@pytest.mark.parametrize("machine", PLACES)
def test_explain_and_report(machine: str, run: Runner, tmp_path: Path) -> None:
    """Pages and texts of a machine without rods; its own words."""
    source, tilt = tmp_path / "part.nc", 10 if machine == "nutating_table" else -10
    letters = {"ca_fork_head": "AC", "ac_trunnion": "AC", "ab_table": "AB", "nutating_head": "AC"}.get(machine, "BC")
    source.write_text(
        f"G0 X0 Y0 Z60 {letters[0]}0 {letters[1]}0\nG1 X10 {letters[0]}{tilt} {letters[1]}20 F900\nM2\n",
        encoding="utf-8",
    )
    text = run("explain", f"{source}:2", *options_of(machine)).out
    assert f"words                {letters[0]} {tilt}.000, {letters[1]} 20.000 deg" in text
    assert "every solution of the whole machine: 2" in run("explain", f"{source}:2", "--all", *options_of(machine)).out
    assert run("report", source, *options_of(machine), "-o", tmp_path / "r.html").code == 0
    assert (
        run(
            "machine",
            "axis-check",
            "--machine",
            machine,
            "--at",
            f"100,100,-100,{max(tilt, 0)},0",
            "-o",
            tmp_path / "check",
        ).code
        == 0
    )
    shown = run("machine", "show", machine).out
    assert f"# {letters[0]} +10: the tool leans towards" in shown


def test_a_dry_run_rises_along_z_of_the_part(run: Runner, tmp_path: Path) -> None:
    """On the A-B table the nominal angles count from another axis of the part."""
    source = tmp_path / "part.nc"
    source.write_text("G0 X5 Y6 Z30 A0 B0\nG1 X10 A10 B-20 F900\nM2\n", encoding="utf-8")
    places = []
    for air in ([], ["--air", "50", "--air-along", "table"]):
        answer = run("convert", source, *options_of("ab_table"), *air)
        assert answer.code == 0, answer.err
        places.append(read_rows("ab_table", answer.out)[1][[0, -1]])
    assert places[1] - places[0] == pytest.approx(np.tile([0.0, 0.0, 50.0], (2, 1)), abs=1e-5)


@pytest.mark.parametrize("machine", ["verne", "serial", "bc_trunnion", "ac_trunnion", "b_head_c_table", "ca_fork_head"])
def test_a_body_on_the_table_stands_where_one_in_a_work_system_without_offset_does(machine: str) -> None:
    """Boxes and meshes: the table frame of the checks may be turned from the part frame, from which work
    offsets count.
    """
    loaded, options = vp.load_machine(machine), vp.Options(tool_length=LENGTH, wcs={"G54": (0.0, 0.0, 0.0)})
    letters = loaded.coordinates.axes[3:]
    source = f"G21 G90 G94 F600\nG0 X0 Y0 Z60 {letters[0]}0 {letters[1]}0\nG1 X1\nM2\n".encode()
    program, point = assemble(source, loaded, options), np.array([10.0, 20.0, 30.0])
    frames = build_interpreter_setup(loaded, options).frames
    on_table, in_system = (
        place_body(loaded, "vise", system, point, program.moves, options, frames) for system in (None, 1)
    )
    assert on_table[0] == pytest.approx(in_system[0], abs=1e-9)
    assert np.exp(1j * on_table[1]) == pytest.approx(np.exp(1j * in_system[1]), abs=1e-12)
    origin, turn = place_on_table(program, "part.stl", None)
    assert origin + rotate_z(point, turn) == pytest.approx(in_system[0], abs=1e-9)


def test_bodies_are_refused_where_the_part_does_not_turn_about_its_z(run: Runner, tmp_path: Path) -> None:
    part, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    part.write_text("G21 G90 G94 F600\nG54\nG0 X0 Y0 Z80 A0 B0\nG1 X5\nM2\n")
    assert run(part, "-o", axes, *options_of("ab_table")).code == 0
    stl = tmp_path / "part.stl"
    vertices = "".join(f"vertex {x} {y} 0\n" for x, y in ((0, 0), (9, 0), (0, 9)))
    stl.write_text(f"solid part\nfacet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\nendsolid part\n")
    words = ("--nominal", f"{stl}@table", *options_of("ab_table"))
    answer = run("machined", axes, "--against", part, *words)
    assert answer.code == 2
    assert "do not turn about z of the part" in answer.err


def test_places_of_the_machine_after_a_rewind(run: Runner, tmp_path: Path) -> None:
    """A 20 is on the other side of its pole than A -20: where the table turns there, G53 Z0 is of the side where it
    stands.

    The tilting axis lies 0.05 mm beside the turning one, so that by the words z would end 0.08 mm away.
    """
    source = tmp_path / "part.nc"
    source.write_text(
        "G0 X0 Y0 Z60 A0 C0\nG1 Z30 A20 F900\nG1 C90\nG1 A50\nG53 G0 Z0\nG0 X20 Z80\nM2\n", encoding="utf-8"
    )
    options = [*options_of("ac_trunnion"), "--allow-rewind", "--smoothing", "off"]
    answer = run("convert", source, *options)
    assert answer.code == 0, answer.err
    table = np.genfromtxt(io.StringIO(answer.out), delimiter=",", names=True)
    before, there = (np.flatnonzero(table["line"] == number)[-1] for number in (4, 5))
    assert table["a_deg"][before] == pytest.approx(-50.0, abs=1e-4)
    assert [table[name][there] for name in ("z_mm", "a_deg")] == pytest.approx([0.0, -50.0], abs=1e-4)
    for name in ("x_mm", "y_mm"):
        assert table[name][there] == pytest.approx(table[name][before], abs=1e-4)


@pytest.mark.parametrize("tail", ["G91 G28 Z0", "G53 G0 Z0", "G53 G0 Z0\nG0 A0 C0", "G53 G0 Z0\nG53 G0 X0 Y0 A0 C0"])
def test_c_does_not_turn_for_the_place_of_the_machine_at_the_end(tail: str) -> None:
    """The tool axis swings through the vertical from one side to the other: A does that alone, and C stands.

    What the machine coordinates after it mean depends on where the table stands then, and is no word for it.
    """
    cuts = "".join(f"X{5 * at} I0 J{0.1 * (-1) ** at} K0.995\n" for at in range(1, 5))
    source = f"G21 G90\nG54 G0 X0 Y0 A0 C0\nG43.5 H1 Z50\nG1 Z0 I0 J0 K1 F1500\n{cuts}G0 Z50\nG49\n{tail}\nM30\n"
    setup = vp.Options(tool_length=LENGTH, wcs={"G54": (0, 0, 0)}, dialect="fanuc")
    program = assemble(source.encode(), vp.load_machine("ac_trunnion"), setup)
    assert np.abs(np.degrees(program.path.end[:, 4])).max() == 0.0
    assert np.abs(np.degrees(program.path.end[:, 3])).max() == pytest.approx(np.degrees(np.arctan2(0.1, 0.995)))


@pytest.mark.parametrize("word", ["C0", "C180"])
@pytest.mark.parametrize("end", ["", "X30 Z5 I0 J0 K1\n"])
def test_a_place_of_the_machine_after_tool_axes_is_that_of_its_words(word: str, end: str) -> None:
    """The text is read again for where the tool axes leave the table."""
    cuts = "G1 X5 Z0 I0 J-.3 K.9539392 F1500\nX10 I0 J.3 K.9539392\n"
    source = (
        f"G21 G90 G54\nG0 X0 Y0 A0 {word}\nG43.5 H1 Z50\n{cuts}{end}G0 Z60\nG49\nG53 G0 Z0\nG53 G0 X100 Y-70\nM30\n"
    )
    setup = vp.Options(tool_length=LENGTH, wcs={"G54": (10, 20, 60)}, dialect="fanuc")
    machine = vp.load_machine("ac_trunnion")
    path = assemble(source.encode(), machine, setup).path
    joints, _platform, _ok = machine.five_axis.solve(path.end[-1:, :3], path.end[-1:, 3:], path.tool_length[-1:])
    assert joints[0, :3] == pytest.approx([100.0, -70.0, 0.0], abs=1e-4)


@pytest.mark.parametrize(
    ("dialect", "source"),
    [
        (
            "fanuc",
            "G90 G21 G94\nG54\n{first}G43.5 H5\nG0 X-10 Y-5 Z60 I0 J0 K1\nG0 Z80\nG49\nG53 G0 Z0\n"
            "G53 G0 X100 Y-70\nG43.5 H5\nG0 X-10 Y-5 Z60\nG1 X4 F700\nG1 X7.5 Y-.6 Z6.6 I.0349 J-.0261 K.9990\n"
            "X9 Y.6 Z6 I-.0349 J.0261 K.9990\nX10.7 Y2.5 Z5.8 I0 J0 K1\nG0 Z80\nG49\nG53 G0 Z0\n"
            "G53 G0 X100 Y-70\nM30\n",
        ),
        (
            "siemens",
            "G17 G71 G90 G94\nG54\n{first}TRAORI\nORIWKS\nG0 X-10 Y-5 Z60 A3=0 B3=0 C3=1\nG1 X4 F700\n"
            "X7.5 Y-.6 Z6.6 A3=.0349 B3=-.0261 C3=.9990\nX9 Y.6 Z6 A3=-.0349 B3=.0261 C3=.9990\n"
            "X10.7 Y2.5 Z5.8 A3=0 B3=0 C3=1\nG0 Z80\nTRAFOOF\nSUPA G0 Z0\nSUPA G0 X100 Y-70\nTRAORI\n"
            "G0 X10 Y2 Z60\nTRAFOOF\nSUPA G0 Z0\nM30\n",
        ),
    ],
)
@pytest.mark.parametrize("first", ["", "G0 A0 C0\n"])
@pytest.mark.parametrize("name", ["verne", "ac_trunnion"])
def test_machine_coordinates_under_an_upright_tool_leave_c_to_the_whole_program(
    dialect: str, source: str, first: str, name: str
) -> None:
    """The tool leans to -53.2 degrees and back: C is there or goes there, and never by 126.8 or 306.8 degrees."""
    setup = vp.Options(tool_length=80, wcs={"G54": (0, 0, 50)}, dialect=dialect)
    path = assemble(source.format(first=first).encode(), vp.load_machine(name), setup).path
    c = np.degrees(path.end[:, 4])
    assert np.ptp(c) <= 53.3
    assert c[-1] == pytest.approx(-np.degrees(np.arctan2(0.0349, 0.0261)), abs=0.1)


@pytest.mark.parametrize("between", ["G0 A0\n", "G0 A0 C0\n", "G53 G0 Z0\nG0 C0\n", ""])
def test_words_of_one_axis_after_tool_axes_that_end_upright(between: str) -> None:
    """C may turn in any of the rapids between two operations: the text is read again once for where it does."""
    cuts = "G1 X{} Y1 Z0 I{} J{} K{} F900\nX{} Y1 I0 J0 K1\nG0 Z80\nG49\n"
    source = (
        "G17 G21 G90 G54\nG43.5 H5\nG0 X0 Y0 Z60 I0 J0 K1\n"
        + cuts.format(3, ".0794", ".0425", ".9959", 11)
        + between
        + "G43.5 H5\nG0 X11 Y1 Z60 I0 J0 K1\n"
        + cuts.format(18, ".0168", ".0134", ".9998", 25)
        + "G53 G0 Z0\nM30\n"
    )
    setup = vp.Options(tool_length=LENGTH, wcs={"G54": (0, 0, 50)}, dialect="fanuc")
    path = assemble(source.encode(), vp.load_machine("ac_trunnion"), setup).path
    assert np.degrees(np.ptp(path.end[:, 4])) < 70.0


@pytest.mark.parametrize("first", ["G1 X10 A110 F3000", "G2 X20 I10 A110 F3000"])
def test_a_corner_at_the_end_of_a_travel_does_not_swing_beyond_it(first: str, run: Runner, tmp_path: Path) -> None:
    """Wide corners swing out before they turn: A stands at its limit along line 3, which is legal to the last digit."""
    source = tmp_path / "part.nc"
    source.write_text(f"G0 X0 Y0 Z60 A0 C0\n{first}\nG1 X30\nG1 X50 A20\nM2\n", encoding="utf-8")
    answer = run("convert", source, *options_of("ca_fork_head"))
    assert answer.code == 0, answer.err
    assert read_rows("ca_fork_head", answer.out)[0].size
    assert np.genfromtxt(io.StringIO(answer.out), delimiter=",", names=True)["a_deg"].max() <= 110.0


def test_a_turn_back_at_the_end_of_a_travel_does_not_swing_beyond_it(run: Runner, tmp_path: Path) -> None:
    """The swing is largest in B where the path has hardly left the corner, not where the shape lies farthest
    outside.
    """
    source = tmp_path / "part.nc"
    text = "G21 G90 G94\nG0 X0 Y0 Z60 B0 C0\nG1 X5.8434 Y2.5732 Z35.6532 B-35 C279.035 F6000\n"
    source.write_text(text + "G1 X-29.7753 Y3.7820 Z37.0131 B54.065 C279.035\nM2\n", encoding="utf-8")
    answer = run("convert", source, *options_of("bc_trunnion"))
    assert answer.code == 0, answer.err
    assert np.genfromtxt(io.StringIO(answer.out), delimiter=",", names=True)["b_deg"].min() >= -35.0


def test_b_is_a_coordinate_of_a_spline(run: Runner, tmp_path: Path) -> None:
    """Blocks of BSPLINE with B words are control points, as those with A are."""
    source = tmp_path / "part.mpf"
    points = "\n".join(f"X{x} Y{y} B{b}" for x, y, b in ((5, 0, 5), (10, 5, 10), (20, 0, 20), (30, 0, 25)))
    source.write_text(f"G90 G71 G94\nT1 D1\nTRAORI\nG1 F900 X0 Y0 Z60 B0 C0\nBSPLINE {points}\nG1 X40\nM30\n")
    answer = run("check", source, *options_of("bc_trunnion"), "--dialect", "siemens")
    assert answer.code == 0, answer.out
