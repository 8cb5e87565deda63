"""The list of public programs: its rows can be read, and the script judges a program as they say; and programs of ours
in place of them.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.benchmarks.public_programs import ROOT, judge, table_rows
from tests.gcode.conftest import make_tool
from verne_post import convert
from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode.read import interpret_program
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options

CORPUS = ROOT / "tests" / "corpus" / "apt"


def test_rows_of_the_list_are_of_one_form():
    rows = table_rows()
    assert len({(row.repository, row.path) for row in rows}) == len(rows) >= 25
    for row in rows:
        assert row.repository.count("/") == 1
        assert {row.read, row.run} <= {"yes", "no"}
        assert (row.run == "yes") == (row.refusal == row.right == ""), row  # a refusal says why it is right
        assert Path(row.path).name


def test_the_first_sentence_of_the_page_counts_the_rows():
    rows = table_rows()
    page = (ROOT / "docs" / "public-programs.md").read_text("utf-8").partition("\n\n")[2]
    read, run = (sum(getattr(row, column) == "yes" for row in rows) for column in ("read", "run"))
    assert page.startswith(f"Of {len(rows)} programs from public repositories, verne-post reads {read} and runs {run}.")


def test_a_program_is_judged_as_the_list_has_it():
    row = next(row for row in table_rows() if "insert" in row.setup)
    raw = (CORPUS / "bracket.apt").read_bytes()
    good = judge(row, raw)
    assert (good.read, good.run, good.refusal) == ("yes", "yes", "")
    bad = judge(replace(row, setup=""), raw)
    assert (bad.read, bad.run, bad.refusal) == ("no", "no", "VP002, line 10")
    far = judge(row, raw.replace(b"GOTO/0,20.,60.", b"GOTO/0,20.,29000."))
    assert (far.read, far.run, far.refusal[:5]) == ("yes", "no", "VP101")


def test_a_program_with_another_axis_names_its_machine():
    row = next(row for row in table_rows() if "machine" in row.setup)
    raw = (
        b"BEGIN PGM B MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+50 R0 FMAX\nL B+30 C+0 R0 FMAX M128\nL X+9 F500\nEND PGM B "
        b"MM\n"
    )
    assert judge(row, raw).run == "yes"
    without = judge(replace(row, setup=""), raw)
    assert (without.read, without.run, without.refusal) == ("yes", "no", "VP011, line 4")


def test_one_part_of_four_controls_has_the_same_setpoints(machine):
    """Slot, round pocket, holes on a circle, threads, edge and five axes: written out, as macros and cycles of Fanuc,
    as cycles of Siemens and of Klartext.

    Setpoints are compared to 1e-6 mm and degrees: none of these cycles differs between the controls in where the tool
    goes.
    """
    given = {
        "tools": {1: make_tool(1, 80.0, 8.0)},
        "wcs": {"G54": (0.0, 0.0, 40.0)},
        "cycle": 0.01,
        "smoothing": "off",
        "tapping": "feed",
    }
    values = []
    for name in ("rs274/plate.ngc", "fanuc/plate.nc", "siemens/plate.mpf", "heidenhain/plate.h"):
        options = Options(source_name=name, **given)
        result = convert((CORPUS.parent / name).read_bytes(), machine, options)
        assert result.ok, (name, result.findings)
        values.append(result.setpoints.values)
    assert np.ptp(values[0], axis=0).min() > 1  # every axis moves
    assert max(np.abs(each - values[0]).max() for each in values[1:]) < 1e-6


def find_places(machine, name, raw):
    """Places of the axes, mm and degrees, after each move of a program at a feed rate or on an arc, and after
    the last.
    """
    given = {"tools": {1: make_tool(1, 80.0, 8.0)}, "remap": dict.fromkeys(("M10", "M11", "M12", "M13"), "event")}
    options = Options(source_name=name, wcs={"G54": (0.0, 0.0, 40.0)}, **given)
    moves = interpret_program(raw, build_interpreter_setup(machine, options))
    rows = np.flatnonzero(np.isin(moves.kind, (MoveKind.FEED, MoveKind.ARC)))
    return np.array(
        [
            machine.coordinates.map_to_machine(moves.end[row], moves.frames[moves.frame[row]])[:6]
            for row in (*rows, len(moves) - 1)
        ]
    )


def test_one_slot_on_a_side_as_posts_of_two_controls_write_it(machine):
    """CYCLE800, a frame under TRAORI, Euler and projected angles of G68.2, G254 and G234: the same places of all axes.

    The plane is turned by 20 degrees about X, 5 mm above G54. umc.nc is written with six decimals.
    """
    zero = find_places(machine, "zero.ngc", b"G21 G90 G54\nT1 M6 G43 H1\nG0 X0 Y0 Z0 A-20 C0\nM2\n")[-1]
    plane = zero + (0, 5.0 * np.sin(np.radians(20.0)), 5.0 * np.cos(np.radians(20.0)), 0, 0, 0)
    ends = plane + np.array([(u, v, -1, 0, 0, 0) for u, v in ((-10, 4), (10, 4), (10, 8), (-10, 8))])
    for name, again, close in (("siemens/side.mpf", 4, 1e-9), ("fanuc/side.nc", 4, 1e-9), ("fanuc/umc.nc", 2, 2e-6)):
        found = find_places(machine, name, (CORPUS.parent / name).read_bytes())[:-1]
        expected = np.concatenate([ends, ends[:again]])
        assert found.shape == expected.shape, name
        assert np.abs(found - expected).max() < close, name
