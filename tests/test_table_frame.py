"""What is said and returned of a tip on the table is in the frame of --wcs and --keep-out, on every machine.

The tip is computed by hand from docs/conventions.md, ``o + Rz(c) p``, and a fixture of 1 mm there is run into. Some
machines compute in another frame: the fixture at the same numbers with other signs is not touched.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post as vp
from verne_post.base.rotations import rotate_z

ROOT = Path(__file__).resolve().parents[1]
MACHINES = sorted(path.stem for path in (ROOT / "machine_configs").glob("*.toml"))
#: With rods or legs, whose solutions take long: the turned case alone says as much.
LEGS = ("hexapod", "hexaglide", "hexam", "tricept", "george_v", "verne_by_rods")
#: Where the part has to be to be reached, mm.
PLACES = {"ca_fork_head": (1000, 1300, -200), "nutating_head": (30, 40, -200), "tricept": (30, 40, 450)}
LENGTH = 100.0
SLOT = "G21 G90 G61.1\nT1 M6 G43 H1\nG0 X-45 Y-20 Z20\nG0 Z-6\nG1 X45 F6000\nG0 Z20\nM2\n"
SHAPES = "[tool.1]\ncutter = { diameter = 12.0, length = 25.0 }\nholder = { diameter = 40.0 }\n"

Runner = Callable[..., Any]


def find_place(machine: str) -> np.ndarray:
    return np.array(PLACES.get(machine, (30, 40, 20)), dtype=float)


def name_corners(place: np.ndarray) -> str:
    return ",".join(f"{value:g}" for value in (*(place - 0.5), *(place + 0.5)))


@pytest.mark.parametrize(
    ("machine", "is_turned"),
    [*((name, True) for name in MACHINES), *((name, False) for name in MACHINES if name not in LEGS)],
)
def test_the_tip_on_the_table_is_where_a_fixture_is_hit(
    machine: str, is_turned: bool, run: Runner, tmp_path: Path
) -> None:
    """At rotary axes of 0, and at angles: with tool-centre-point control the place on the table is the same."""
    coordinates, letters = vp.load_machine(machine).coordinates, vp.load_machine(machine).rotary_letters
    origin, point, turn = find_place(machine), np.array([30.0, 20.0, 150.0]), 0.0
    rotary = "".join(f" {letter}0" for letter in letters)
    if is_turned:
        rotary = f" {letters[0]}{10 if machine == 'nutating_table' else -10} {letters[1]}20"
        turn = 15.0 if coordinates.turns_with_part else 0.0
    source, table = tmp_path / "part.nc", tmp_path / "t.tbl"
    source.write_text(
        f"G21 G90 G17 G54\nT1 M6\nG43.4 H1\nG0 X30 Y20 Z160{rotary}\nG1 Z150 F500\nM2\n", encoding="utf-8"
    )
    table.write_text(f"T1 P1 Z{LENGTH:g} D10 ;\n", encoding="utf-8")
    wcs = f"G54={origin[0]:g},{origin[1]:g},{origin[2]:g}" + (f",{turn:g}" if turn else "")
    given = ["--machine", machine, "--tool-table", table, "--wcs", wcs, "--dialect", "rs274"]
    there = rotate_z(point, np.radians(turn)) + origin
    explained = run("explain", f"{source}:5", "--all", *given).out
    said = re.findall(r"tip on the (?:table|part) +\(([^)]*)\) mm", explained)
    assert len(said) == 2
    for text in said:
        assert [float(value) for value in text.split(", ")] == pytest.approx(there.tolist(), abs=1e-3)
    hit = run("check", source, *given, "--keep-out", f"post={name_corners(there)}").out
    if machine == "ab_table":  # nothing may stand on its part
        assert "VP018" in hit
        return
    assert "VP215" in hit
    for signs in ((-1, -1, 1), (-1, 1, 1), (1, -1, 1)):
        assert "VP215" not in run("check", source, *given, "--keep-out", f"post={name_corners(signs * there)}").out


def test_a_refusal_names_the_tip_in_the_frame_of_the_set_up(run: Runner, tmp_path: Path) -> None:
    source = tmp_path / "far.nc"
    source.write_text("G0 X10 Y20 Z150\nG1 X30 Y300 F500\nM2\n", encoding="utf-8")
    given = ["--machine", "bc_trunnion", "--tool-length", "100", "--wcs", "G54=30,40,20"]
    said = run("explain", f"{source}:2", *given).out
    assert "at 100 % of the way: tip (60.000000, 340.000000, 170.000000) mm on the table" in said


def test_rows_of_another_work_offset_are_off_in_the_frame_of_the_set_up(run: Runner, tmp_path: Path) -> None:
    source, rows = tmp_path / "part.nc", tmp_path / "rows.csv"
    source.write_text("G61.1\nG0 X0 Y0 Z150\nG1 X30 F5000\nY20\nX0\nM2\n", encoding="utf-8")
    given = ["--machine", "bc_trunnion", "--tool-length", "100"]
    assert run("convert", source, *given, "--wcs", "G54=3,-4,0", "-o", rows).code == 0
    answer = run("verify", rows, "--against", source, *given, "--wcs", "G54=0,0,0")
    assert "the tip is off by X3.000 Y-4.000 Z0.000 mm on the table" in answer.out + answer.err


@pytest.mark.parametrize("machine", [name for name in MACHINES if name != "ab_table"])
def test_rows_cut_the_same_slot_on_every_machine(
    machine: str, run: Runner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """60 x 12 x 6 mm: the stock of the set-up stands where the rows cut, not at other signs."""
    monkeypatch.chdir(tmp_path)
    for name, text in (("slot.nc", SLOT), ("t.tbl", "T1 P1 Z100 D12 ;\n"), ("s.toml", SHAPES)):
        Path(name).write_text(text, encoding="utf-8")
    x, y, z = find_place(machine) + (0, 0, 60)
    given = ["--machine", machine, "--tool-table", "t.tbl", "--tool-shapes", "s.toml", "--wcs", f"G54={x},{y},{z}"]
    assert run("convert", "slot.nc", *given, "-o", "a.csv", "--quiet").code == 0
    done = run("machined", "a.csv", "--against", "slot.nc", *given, "--stock", "G54=-30,-40,-60,30,0,0")
    assert "stock: 4320.0 of 144000.0 mm3 cut" in done.out + done.err
    assert " error: " not in done.err


@pytest.mark.parametrize("machine", ["verne", "bc_trunnion"])
def test_a_contact_with_the_stock_is_returned_in_the_frame_of_the_set_up(machine: str) -> None:
    """A rapid through uncut stock: the flat end meets the side of the stock where its middle is 6 mm before it."""
    program = SLOT.replace("G1 X45 F6000", "G0 X45")
    origin = find_place(machine) + (0, 0, 60)
    options = vp.Options(
        tools={1: (100, 12)},
        tool_shapes={1: (vp.Cylinder("cutter", 12.0, 25.0), vp.Cylinder("holder", 40.0, None))},
        wcs={"G54": tuple(origin.tolist())},
        stock=vp.Box("the stock", (-30, -40, -60), (30, 0, 0), 1),
    )
    result = vp.check(program, machine, options)
    (contact,) = (item.contact for item in result.findings if item.contact is not None)
    assert contact == pytest.approx((origin + (-36, -20, -6)).tolist(), abs=0.6)
