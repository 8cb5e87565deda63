"""--units drive: rows in what drives count, read back by hand and by verify."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.config import list_machine_files
from verne_post.model.drives import Drive
from verne_post.model.findings import InputError

PROGRAM = "G21 G90 G64\nG0 X0 Y0 Z50 A0 C0\nG1 X40 Y10 A8 C30 F3000\nG1 X10 Y30\nG4 P0.1\nG0 Z80\nM2\n"
PLACE = ("--tool-length", 60, "--wcs", "G54=5,-8,30")
DRIVES = """
[drives.rho1]
unit = "counts"
sign = -1
zero = 650.0
scale = 4e6
integer = true
[drives.rho2]
unit = "counts"
scale = 5e6
integer = true
lead_error = [[0.0, 0.0], [300.0, 0.02], [700.0, -0.01], [1300.0, 0.03]]
[drives.rho3]
unit = "inch"
sign = -1
zero = 100.0
scale = 0.03937007874015748
[drives.a]
unit = "mdeg"
sign = -1
scale = 1000.0
[drives.c]
unit = "rev"
scale = 0.002777777777777778
lead_error = [[-180.0, 0.0], [-60.0, 0.02], [60, -0.02], [180.0, 0.0]]
"""


def file_with(drives: str, folder: Path, *, replaced: tuple[str, str] = ("", "")) -> Path:
    text = list_machine_files()["verne"].read_text(encoding="utf-8")
    text = text.replace("[control]", f"{drives.replace(*replaced)}\n[control]", 1)
    path = folder / "drives.toml"
    path.write_text(text + 'drives = "measured, a test"\n', encoding="utf-8")
    return path


def tool_path(file: Path, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    machine = verne_post.load_machine(file)
    tip, axis, ok = machine.forward(q / [column.factor for column in machine.columns], 60.0)
    assert ok.all()
    return tip, axis


def test_counts_give_the_same_tool_path(tmp_path: Path, run: Callable[..., Any]) -> None:
    machine = file_with(DRIVES, tmp_path)
    program, plain, counts = tmp_path / "p.nc", tmp_path / "plain.csv", tmp_path / "counts.csv"
    program.write_text(PROGRAM, encoding="utf-8")
    place = (*PLACE, "--machine", machine)
    assert run("convert", program, *place, "-o", plain).code == 0
    answer = run("convert", program, *place, "--units", "drive", "-o", counts)
    assert answer.code == 0, answer.err
    assert "rho1 0.5 mm/s2 and 1e+03 mm/s3" in " ".join(answer.err.split())
    header = counts.read_text().partition("\n")[0]
    assert header == "t_s,rho1_counts,rho2_counts,rho3_inch,a_mdeg,c_rev,line"
    texts = [line.split(",") for line in counts.read_text().splitlines()[1:]]
    assert all("." not in cell for row in texts for cell in row[1:3])
    numbers, joint = np.array(texts, dtype=float), np.loadtxt(plain, delimiter=",", skiprows=1)
    assert np.array_equal(numbers[:, [0, -1]], joint[:, [0, -1]])
    # by hand, but for the two tables of lead errors: there the commanded place is off by the error, read off the table
    q = joint[:, 1:6].copy()
    assert np.abs(650.0 - numbers[:, 1] / 4e6 - q[:, 0]).max() < 0.51 / 4e6 + 1e-7
    assert np.abs(100.0 - numbers[:, 3] * 25.4 - q[:, 2]).max() < 1e-6
    assert np.abs(-numbers[:, 4] / 1000.0 - q[:, 3]).max() < 2e-8
    linear = np.interp(q[:, 1], [0.0, 300.0, 700.0, 1300.0], [0.0, 0.02, -0.01, 0.03])
    assert np.abs(q[:, 1] - numbers[:, 2] / 5e6 - linear).max() < 0.02
    assert np.abs(q[:, 1] - numbers[:, 2] / 5e6).max() > 0.002
    # a drive with these errors, simulated with a spline of its own, stands where the plain file says
    from scipy.interpolate import CubicSpline

    lead = CubicSpline([0.0, 300.0, 700.0, 1300.0], [0.0, 0.02, -0.01, 0.03], bc_type="natural")
    turn = CubicSpline([-180.0, -60.0, 60.0, 180.0], [0.0, 0.02, -0.02, 0.0], bc_type="periodic")
    commanded = numbers[:, 2] / 5e6, numbers[:, 5] * 360.0
    stands = np.stack(
        [
            650.0 - numbers[:, 1] / 4e6,
            commanded[0] + lead(commanded[0]),
            100.0 - numbers[:, 3] * 25.4,
            -numbers[:, 4] / 1000.0,
            commanded[1] + turn(commanded[1]),
        ],
        axis=1,
    )
    for ours, theirs in zip(tool_path(machine, stands), tool_path(machine, q), strict=True):
        assert np.abs(ours - theirs).max() < 2e-6
    verdict = run("verify", counts, "--against", program, *place, "--units", "drive")
    assert verdict.code == 0, verdict.err
    wrong = run("verify", counts, "--against", program, *place)
    assert wrong.code == 2
    assert "other units, see --units" in wrong.err


def test_verify_sees_a_count_too_many(tmp_path: Path, run: Callable[..., Any]) -> None:
    """A thousand counts, a quarter of a micrometre, in one row are a jerk."""
    machine = file_with(DRIVES, tmp_path)
    program, counts = tmp_path / "p.nc", tmp_path / "counts.csv"
    program.write_text(PROGRAM, encoding="utf-8")
    place = (*PLACE, "--machine", machine, "--units", "drive")
    assert run("convert", program, *place, "-o", counts).code == 0
    lines = counts.read_text().splitlines()
    cells = lines[300].split(",")
    cells[1] = str(int(cells[1]) + 1000)
    lines[300] = ",".join(cells)
    counts.write_text("\n".join(lines) + "\n")
    verdict = run("verify", counts, "--against", program, *place)
    assert verdict.code == 1
    assert "VP403" in verdict.err


def test_parts_and_events_are_in_drive_units_too(tmp_path: Path, run: Callable[..., Any]) -> None:
    machine = file_with(DRIVES, tmp_path)
    program, out, events = tmp_path / "p.nc", tmp_path / "o.csv", tmp_path / "e.csv"
    program.write_text(PROGRAM.replace("G4 P0.1", "M0"), encoding="utf-8")
    place = (*PLACE, "--machine", machine, "--units", "drive", "--split-at-stops")
    assert run("convert", program, *place, "-o", out, "--events", events).code == 0
    first = (tmp_path / "o.1.csv").read_text().splitlines()
    stop = next(line for line in events.read_text().splitlines() if ",stop," in line)
    assert stop.split(",")[-5:] == first[-1].split(",")[1:6]
    assert run("verify", tmp_path / "o.index.json", "--against", program, *place).code == 0


def test_from_takes_what_the_drives_read(tmp_path: Path, run: Callable[..., Any]) -> None:
    machine = file_with(DRIVES, tmp_path)
    program, out = tmp_path / "p.nc", tmp_path / "o.csv"
    program.write_text(PROGRAM, encoding="utf-8")
    start = ("1000000000", "2000000000", "-11.8", "0", "0")
    place = (*PLACE, "--machine", machine, "--units", "drive", "--from", ",".join(start))
    answer = run("convert", program, *place, "-o", out)
    assert answer.code == 0, answer.err
    first = out.read_text().splitlines()[1].split(",")[1:6]
    assert first[:2] == ["1000000000", "2000000000"]
    assert [float(cell) for cell in first] == pytest.approx([float(cell) for cell in start], abs=1e-9)
    assert run("verify", out, "--against", program, *place).code == 0


def test_coarse_counts_do_not_excuse_themselves(tmp_path: Path, run: Callable[..., Any]) -> None:
    machine = file_with(DRIVES, tmp_path, replaced=("scale = 4e6", "scale = 10000.0"))
    program, out = tmp_path / "p.nc", tmp_path / "o.csv"
    program.write_text(PROGRAM, encoding="utf-8")
    place = (*PLACE, "--machine", machine, "--units", "drive")
    assert run("convert", program, *place, "--accept-rounding", "-o", out).code == 0
    assert run("verify", out, "--against", program, *place, "--accept-rounding").code == 0
    assert run("verify", out, "--against", program, *place).code == 1


def test_counts_that_are_too_coarse_are_refused(tmp_path: Path, run: Callable[..., Any]) -> None:
    machine = file_with(DRIVES, tmp_path, replaced=("scale = 4e6", "scale = 1000.0"))
    program = tmp_path / "p.nc"
    program.write_text(PROGRAM, encoding="utf-8")
    answer = run("convert", program, *PLACE, "--machine", machine, "--units", "drive")
    assert answer.code == 2
    assert "drives.rho1 wants whole numbers of 0.001 mm" in answer.err
    # check says no less than convert
    assert run("check", program, *PLACE, "--machine", machine, "--units", "drive").code == 2
    assert run("check", program, *PLACE, "--machine", machine, "--units", "drive", "--accept-rounding").code == 0
    assert run("check", program, *PLACE, "--decimals", "1").code == 2
    assert "needs [drives]" in run("check", program, *PLACE, "--units", "drive").out
    assert "4e+06 mm/s3, over its limit 100000" in answer.err
    assert answer.out == ""
    place = (*PLACE, "--machine", machine, "--units", "drive", "--accept-rounding")
    out = tmp_path / "o.csv"
    assert run("convert", program, *place, "-o", out).code == 0
    assert run("verify", out, "--against", program, *place).code == 0


def test_drives_must_be_there(tmp_path: Path, run: Callable[..., Any]) -> None:
    program = tmp_path / "p.nc"
    program.write_text(PROGRAM, encoding="utf-8")
    answer = run("convert", program, *PLACE, "--units", "drive")
    assert answer.code == 2
    assert "--units drive needs [drives] in the machine file" in answer.err


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[drives.c]", "[drives.b]", "drives.b is no joint of this machine; they are rho1, rho2, rho3, a, c"),
        ("[drives.c]", "[drives.b]", "drives.c is missing"),
        ("sign = -1", "sign = 0", "drives.rho1.sign = 0"),
        ("scale = 4e6", "scale = -4e6", "drives.rho1.scale"),
        ("scale = 4e6", 'scale = "many"', "drives.rho1.scale"),
        ("scale = 4e6", "scales = 4e6", "drives.rho1.scales is not a key of a machine file"),
        ("[1300.0, 0.03]", "[1200.0, 0.03]", "reaches from 0 to 1200; it must cover the travel from 50 to 1250"),
        ("[700.0, -0.01]", "[250.0, -0.01]", "places rise from row to row; 250 follows 300"),
        ("[700.0, -0.01]", "[700.0, -60.0]", "changes by more than 0.1 of the way"),
        ("[180.0, 0.0]]", "[180.0, 0.01]]", "expected one turn of 360 degrees, with the same error at both ends"),
        ('unit = "rev"', 'unit = "a,b"', "drives.c.unit"),
    ],
)
def test_bad_drives(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(InputError) as refused:
        verne_post.load_machine(file_with(DRIVES, tmp_path, replaced=(old, new)))
    assert any(said in finding.message for finding in refused.value.findings), refused.value.findings


def test_every_group_says_where_it_is_from(tmp_path: Path) -> None:
    path = file_with(DRIVES, tmp_path)
    path.write_text(re.sub(r"(?m)^drives = .*$", "", path.read_text()), encoding="utf-8")
    with pytest.raises(InputError, match=r"provenance\.drives is missing"):
        verne_post.load_machine(path)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_numbers_and_places_are_inverse(sign: float) -> None:
    drive = Drive("counts", sign, 17.0, 123.0, error=lambda x: 0.09 * np.sin(x))
    places = np.linspace(-500.0, 900.0, 1001)
    assert np.abs(drive.find_places(drive.find_numbers(places)) - places).max() < 1e-10
