"""Machines whose rotary pair nutates, end to end: joints that go linearly, the fold, and what is refused by name."""

from pathlib import Path

import numpy as np
import pytest

from tests.kinematics.test_chain import describe
from tests.test_chains import Runner, options_of, read_rows
from verne_post.model.nutation import REACH_SLACK, Nutation


def test_angles_and_joints_at_the_fold_and_the_pole() -> None:
    """Tilts are kept to 1e-12; so rounded, the fold is the fold, and the joint beyond the reach is beyond its
    travel.
    """
    for near, far in ((0.25 * np.pi, 0.25 * np.pi), (np.radians(50.0), np.radians(50.0)), (1.1, 0.7)):
        pair = Nutation(near, far, 0.0)
        joints = np.array([[np.pi, 0.4], [-np.pi, 0.4], [1e-3, 0.1], [3.0, 0.2], [-2.0, 5.0], [3.2, 0.0]])
        rounded = np.round(pair.find_angles(joints), 12)
        back = pair.find_joints(rounded)
        assert (back[:2, 0] == joints[:2, 0]).all()
        assert np.abs(back - joints)[2:].max() < 1e-9
        assert pair.measure_miss(np.abs(rounded[:5, 0])).max() == 0.0
        assert pair.measure_miss(np.array(pair.reach[1] + 0.01)) == pytest.approx(0.01)
        assert pair.measure_miss(np.array(pair.reach[1] + 0.5 * REACH_SLACK)) == 0.0


@pytest.mark.parametrize(("machine", "tilt"), [("nutating_table", "B"), ("nutating_head", "A")])
def test_words_go_linearly_in_the_joints(machine: str, tilt: str, run: Runner, tmp_path: Path) -> None:
    """Between words the rotary joints keep their ratio while the tip is on its line, to the fold and back; a cut there
    stays at it.
    """
    source, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    source.write_text(
        f"G0 X0 Y0 Z60 {tilt}0 C0\n"
        f"G1 X20 Y10 {tilt}60 C30 F900\n"
        f"G1 X40 Y-10 Z80 {tilt}180 C-60\n"
        "G1 X10\n"
        "G0 Z120\n"
        f"G0 {tilt}0\n"
        "M2\n"
    )
    answer = run("convert", source, *options_of(machine), "-o", axes)
    assert answer.code == 0, answer.err
    assert run("verify", axes, "--against", source, *options_of(machine)).code == 0
    line, tip, axis = read_rows(machine, axes.read_text(encoding="utf-8"))
    table = np.genfromtxt(axes, delimiter=",", names=True)
    for number, start, end, joints in (
        (2, [0, 0, 60], [20, 10, 60], [[0, 0], [60, 30]]),
        (3, [20, 10, 60], [40, -10, 80], [[60, 30], [180, -60]]),
    ):
        rows = np.flatnonzero(line == number)[400:-400]  # corners are blended
        share = (table[f"{tilt.lower()}_deg"][rows] - joints[0][0]) / (joints[1][0] - joints[0][0])
        assert share.min() < 0.4
        assert share.max() > 0.6
        assert np.abs(table["c_deg"][rows] - joints[0][1] - share * (joints[1][1] - joints[0][1])).max() < 1e-5
        assert np.abs(tip[rows] - start - share[:, None] * np.subtract(end, start)).max() < 1e-4
    cut = np.flatnonzero(line == 4)[1:]
    assert (table[f"{tilt.lower()}_deg"][cut] == 180.0).all()
    assert axis[cut, 2] == pytest.approx(np.cos(np.radians(90.0 if tilt == "B" else 100.0)), abs=1e-12)


@pytest.mark.parametrize("machine", ["nutating_table", "nutating_head"])
def test_a_tool_that_lies_flat_by_its_vector(machine: str, run: Runner, tmp_path: Path) -> None:
    """The rapid goes there by the joints, and the cuts keep it; a head of 50 degrees reaches beyond, without a fold."""
    source, axes = tmp_path / "part.cl", tmp_path / "axes.csv"
    source.write_text(
        "PARTNO/T\n"
        "UNITS/MM\n"
        "MULTAX/ON\n"
        "LOADTL/1\n"
        "RAPID\n"
        "GOTO/0,0,80,0,0,1\n"
        "FEDRAT/2000,MMPM\n"
        "GOTO/0,0,40,0,0,1\n"
        "GOTO/20,0,40,0.6,0,0.8\n"
        "RAPID\n"
        "GOTO/40,0,90,0,1,0\n"
        "FEDRAT/1000,MMPM\n"
        "GOTO/40,20,40,0,1,0\n"
        "GOTO/20,20,40,0,1,0\n"
        "FINI\n"
    )
    answer = run("convert", source, *options_of(machine), "-o", axes)
    assert answer.code == 0, answer.err
    line, tip, axis = read_rows(machine, axes.read_text(encoding="utf-8"))
    assert axis[line == 14] == pytest.approx(np.tile([0.0, 1.0, 0.0], ((line == 14).sum(), 1)), abs=1e-9)
    assert tip[-1] == pytest.approx([20, 20, 40], abs=1e-5)


FLAT = "G0 X0 Y0 Z60 I0 J0 K1\nG1 X20 I0 J1 K0 F900\n"
#: What nutating_table does not do: dialect, program, finding and what it says.
REFUSED = [
    (
        "fanuc",
        f"G43.5 H1\n{FLAT.replace('J1 K0', 'J0.9 K-0.4358898943540674')}M30\n",
        "VP110",
        "is at 115.8419 degrees to the axis of C, 25.8419 outside",
    ),
    ("fanuc", f"G43.5 H1\n{FLAT}M30\n", "VP202", "comes within 0.0000 degrees of the fold of the tilting joint"),
    (
        "siemens",
        "G90 G71 G94\n"
        "T1 D1\n"
        "TRAORI\n"
        "ORIVECT\n"
        "G1 F900 X0 Y0 Z60 A3=0 B3=0 C3=1\n"
        "G1 X20 A3=0 B3=0.9 C3=-0.4358898943540674\n"
        "M30\n",
        "VP110",
        "25.8419",
    ),
    (
        "heidenhain",
        "BEGIN PGM P MM\n"
        "TOOL CALL 1 Z S900\n"
        "M128\n"
        "LN X+0 Y+0 Z+60 TX0 TY0 TZ1 FMAX\n"
        "LN X+9 Y+0 Z+60 TX0 TY+0.9 TZ-0.4358898943540674 F900\n"
        "END PGM P MM\n",
        "VP110",
        "25.8419",
    ),
    (
        "heidenhain",
        "BEGIN PGM P MM\n"
        "TOOL CALL 1 Z S900\n"
        "M128\n"
        "L X+0 Y+0 Z+60 B+0 C+0 FMAX\n"
        "PLANE SPATIAL SPA+0 SPB+100 SPC+0 TURN FMAX\n"
        "END PGM P MM\n",
        "VP110",
        "10.0000 outside",
    ),
    (
        "heidenhain",
        "BEGIN PGM P MM\n"
        "TOOL CALL 1 Z S900\n"
        "M128\n"
        "L X+0 Y+0 Z+60 B+0 C+0 FMAX\n"
        "PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN SEQ- FMAX\n"
        "END PGM P MM\n",
        "VP102",
        "SEQ-",
    ),
    (
        "fanuc",
        "G0 X0 Y0 Z60 B0 C0\nG1 X9 B190 F900\nM30\n",
        "VP102",
        "joint b reaches 190.000 deg, 10.000 deg above its travel of 0 to 180 deg",
    ),
    (
        "siemens",
        "G90 G71 G94\n"
        "T1 D1\n"
        "TRAORI\n"
        "ORIAXES\n"
        "G1 F900 X0 Y0 Z60 B0 C0\n"
        "BSPLINE X5 Y0 B5\n"
        "X10 Y5 B10\n"
        "X20 B20\n"
        "X30 B20\n"
        "X40 B25\n"
        "X50 B25\n"
        "X60 B25\n"
        "G1 X70\n"
        "M30\n",
        "VP031",
        "is not executed on a nutating pair",
    ),
]


@pytest.mark.parametrize(("dialect", "text", "code", "said"), REFUSED)
def test_what_is_refused(dialect: str, text: str, code: str, said: str, run: Runner, tmp_path: Path) -> None:
    source = tmp_path / "part.nc"
    source.write_text(text, encoding="utf-8")
    answer = run("check", source, *options_of("nutating_table"), "--dialect", dialect)
    assert answer.code in (1, 2)
    assert f"{code} error" in answer.out
    assert said in answer.out


def test_seq_is_refused_where_the_sign_tells_no_position(run: Runner, tmp_path: Path) -> None:
    """A pair whose tool leans with all joints at 0."""
    machine, source = tmp_path / "leans.toml", tmp_path / "part.h"
    joints = {
        "b": "turns = [0, 1, 1]\nthrough = [0, 0, 0]\ntravel_deg = [-90, 90]\n",
        "c": "turns = [0, 0, 1]\nthrough = [0, 0, 0]\n",
    }
    machine.write_text(describe("xyz", "bc", joints, axis="[0.5, 0.14644660940672624, 0.8535533905932737]"))
    source.write_text(
        "BEGIN PGM P MM\n"
        "TOOL CALL 1 Z S900\n"
        "M128\n"
        "L X+0 Y+0 Z+60 B+0 C+0 FMAX\n"
        "PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN SEQ+ FMAX\n"
        "END PGM P MM\n"
    )
    answer = run(
        "check", source, "--machine", machine, "--tool-length", "50", "--wcs", "G54=0,0,0", "--dialect", "heidenhain"
    )
    assert answer.code == 2
    assert "SEQ+: the two positions of this nutating pair do not lie on both sides of B 0" in answer.out


def test_words_keep_their_side(run: Runner, tmp_path: Path) -> None:
    """The other side would be another path of the tool: a limit that words break is a finding, and no rewind is
    added.
    """
    source = tmp_path / "part.nc"
    source.write_text("G0 X0 Y0 Z60 A0 C0\nG1 X9 A30 C280 F900\nM2\n")
    answer = run("check", source, *options_of("nutating_head"), "--allow-rewind")
    assert answer.code == 1
    assert "joint c reaches 280.000 deg, 10.000 deg above its travel" in answer.out
