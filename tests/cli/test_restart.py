"""--from-line: a restart follows the very path of the whole program, and is refused where that cannot be promised."""

import json
import random
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

import verne_post
from verne_post.app.assemble import Program, assemble
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Box, Tool
from verne_post.report.left import make_left
from verne_post.toolpath.contour_pose import find_contour_pose

from ..builders import LEGAL_SAMPLES, SAMPLES

#: So many lines of each sample, and samples with fewer outside cycles, subprograms and splines that go over several
#: lines.
COMPARED = 5
FEWER = {"fanuc_nurbs.nc": 4}
#: The curves of splines.nc are those of fanuc_nurbs.nc, and take three times as long.
LINES = {"splines.nc": 2}


@pytest.mark.parametrize("name", LEGAL_SAMPLES)
@pytest.mark.parametrize("smoothing", ["spline", "off"])
def test_the_rest_of_the_path_is_that_of_the_whole_program(
    laid_out: Callable[..., Program], name: str, smoothing: str
) -> None:
    whole = laid_out(name, smoothing=smoothing)
    lines = sorted(set(whole.path.line.tolist()))
    compared = 0
    for line in random.Random(name).sample(lines, len(lines)):
        try:
            rest = laid_out(name, smoothing=smoothing, approach="home", from_line=line)
        except InputError as refused:  # inside a cycle or a subprogram: the next one
            assert refused.findings[0].code == "VP029"
            continue
        own = np.flatnonzero(rest.contour.find_lines() > 0)
        begin = len(whole.contour) - len(own)
        for w in (0.0, 0.37, 1.0):
            at = np.full(len(own), w)
            tip, angles = find_contour_pose(rest.contour, own, at)
            tip_whole, angles_whole = find_contour_pose(whole.contour, begin + np.arange(len(own)), at)
            # the same formulas on the same numbers, added up from another beginning
            assert np.abs(tip - tip_whole).max() < 1e-9
            assert np.abs(angles - angles_whole).max() < 1e-11
        assert rest.contour.find_lines()[own[0]] == line
        assert whole.contour.find_lines()[begin] == line
        assert begin == 0 or whole.contour.find_lines()[begin - 1] != line or whole.contour.find_lines()[begin] == line
        assert np.array_equal(rest.contour.find_lines()[own], whole.contour.find_lines()[begin:])
        compared += 1
        if compared == LINES.get(name, COMPARED):
            break
    assert compared == LINES.get(name, FEWER.get(name, COMPARED))


@pytest.mark.parametrize("line", [12, 18, 26, 37])
def test_rows_of_a_restart_lie_on_rows_of_the_whole_program(
    tmp_path: Path, run: Callable[..., Any], sample_words: Callable[[str], list[str]], line: int
) -> None:
    """Read back from the files: every row of the restart is on the polyline of the whole program's rows."""
    sample, place = SAMPLES / "pocket_3axis.nc", sample_words("pocket_3axis.nc")
    whole, rest = tmp_path / "whole.csv", tmp_path / "rest.csv"
    assert run("convert", sample, *place, "-o", whole).code == 0
    again = (*place, "--from", "home", "--from-line", line, "--to", "home")
    answer = run("convert", sample, *again, "-o", rest)
    assert answer.code == 0, answer.err
    said = " ".join(answer.err.split())
    assert f"starts at line {line}; before the start there must be: tool 1, spindle clockwise at 12000/min" in said
    verdict = run("verify", rest, "--against", sample, *again)
    assert verdict.code == 0, verdict.err
    machine = verne_post.load_machine()
    tips = []
    for path in (whole, rest):
        rows = np.loadtxt(path, delimiter=",", skiprows=1)
        rows = rows[rows[:, -1] >= (line if path == rest else 1)]
        q = rows[:, 1:6] / [column.factor for column in machine.columns]
        tips.append(machine.forward(q, 80.0)[0])
    _distance, near = cKDTree(tips[0]).query(tips[1], k=40)  # several: the path comes back to the same places
    gap = np.full(len(tips[1]), np.inf)
    for first in np.clip(np.concatenate([near, near - 1], axis=1), 0, len(tips[0]) - 2).T:
        a, b = tips[0][first], tips[0][first + 1]
        u = np.clip(((tips[1] - a) * (b - a)).sum(1) / np.maximum(((b - a) ** 2).sum(1), 1e-30), 0, 1)
        gap = np.minimum(gap, np.linalg.norm(tips[1] - a - u[:, None] * (b - a), axis=1))
    # at 25 mm/s rows are 25 um apart: the chord of a corner of 10 um, or of a radius of 6 mm, is this far off
    assert gap.max() < 3e-4


PROGRAM = """G21 G90 G17 G54
T3 M6
S5000 M3 M8
G0 X0 Y0 Z50 A0 C0
G1 X20 F1500
G41 D3 X22 Y4
G1 X30
G1 X30 Y14
G40 X40
G0 Z60
G4 P0.2
G81 X10 Y10 Z30 R45 F300
X20
X30
G80
o1 repeat [2]
G1 X5
G1 X6
o1 endrepeat
o100 sub
G1 Y20
o100 endsub
o100 call
M9
G0 Z70
M2
"""


def restarted(machine: verne_post.Machine, line: int, **more: Any) -> Program:
    tools = {3: Tool(3, 3, (0.0, 0.0, 60.0, *(0.0,) * 6), 4.0)}
    options = Options(tool_length=60.0, tools=tools, approach="home", from_line=line, **more)
    return assemble(PROGRAM.encode(), machine, options)


@pytest.mark.parametrize(
    ("line", "why", "near"),
    [
        (7, "cutter compensation, a canned cycle or a spline", 6),
        (9, "cutter compensation, a canned cycle or a spline", 10),
        (13, "cutter compensation, a canned cycle or a spline", 12),
        (14, "cutter compensation, a canned cycle or a spline", 12),
        (15, "cutter compensation, a canned cycle or a spline", 16),
        (17, "executed 2 times", 16),
        (21, "does not execute it, or only in a subprogram", 20),
        (99, "does not execute it", 26),
    ],
)
def test_a_line_that_depends_on_others_is_refused(machine: verne_post.Machine, line: int, why: str, near: int) -> None:
    with pytest.raises(InputError, match=why) as refused:
        restarted(machine, line)
    finding = refused.value.findings[0]
    assert finding.code == "VP029"
    assert finding.line == line
    named = re.search(r"the nearest line that will do is (\d+)", finding.message)
    assert named
    assert int(named[1]) == near


KLARTEXT_CYCLE = b"""BEGIN PGM A MM
TOOL CALL 1 Z S900
L X+0 Y+0 Z+50 A+0 C+0 R0 FMAX M3
CYCL DEF 200 DRILLING ~
  Q200=2 Q201=-5 ~
  Q206=250 Q202=5 ~
  Q210=0 Q203=0 ~
  Q204=50 Q211=0
L X+9 FMAX M99
L X+19 FMAX M99
END PGM A MM"""
CONTINUED_LINES = b"""UNITS/MM
LOADTL/1
RAPID
GOTO/0,0,$
50
FEDRAT/500,$
MMPM
GOTO/9,$
0,$
45
GOTO/19,0,45
FINI
"""


@pytest.mark.parametrize(
    ("dialect", "text", "lines", "last"),
    [
        ("heidenhain", KLARTEXT_CYCLE, ((4, None), (5, 4), (6, 4), (7, 9), (8, 9), (9, None)), 10),
        ("aptcl", CONTINUED_LINES, ((4, None), (5, 4), (7, 6), (8, None), (9, 8), (10, 11), (11, None)), 11),
    ],
)
def test_a_line_that_goes_on_with_a_statement_is_refused(
    machine: verne_post.Machine, dialect: str, text: bytes, lines: tuple[tuple[int, int | None], ...], last: int
) -> None:
    """All lines of a Klartext cycle counted as its beginning, and none as one that the program comes to.

    Of a CL file, the program did not execute the line, as the message said, though its statement was executed.
    """
    for line, near in lines:
        options = Options(dialect=dialect, tool_length=60.0, wcs={"G54": (0, 0, 100)}, approach="home", from_line=line)
        if near is None:
            assert assemble(text, machine, options).moves.line.max() == last
            continue
        with pytest.raises(
            InputError, match=f"a statement, cutter .* the nearest line that will do is {near}$"
        ) as refused:
            assemble(text, machine, options)
        assert [(item.code, item.line) for item in refused.value.findings] == [("VP029", line)]


@pytest.mark.parametrize("line", [4, 5, 6, 10, 11, 12, 16, 23, 24, 25])
def test_what_the_skipped_lines_switched_on_is_listed(machine: verne_post.Machine, line: int) -> None:
    rest = restarted(machine, line)
    told = [(event.kind, *event.data.values()) for event in rest.moves.events if event.before == 0]
    on = [("tool", 3), ("spindle", "clockwise", 5000.0), ("coolant", "flood")]
    assert told[:2] == on[:2]
    # M9 of line 24 comes before the first motion behind it: what it switches off need not be on
    assert (("coolant", "flood") in told) == (line < 24)
    begins = rest.contour.find_lines()[np.flatnonzero(rest.contour.find_lines() > 0)[0]]
    assert begins == 21 if line == 23 else begins >= line  # the call's own moves
    assert len(rest.path.dwell_seconds) == (line <= 11)


TWO_TOOLS = """G21 G90 G17 G54
T1 M6
G43 H1
M64 P3
S5000 M3
G0 X0 Y0 Z50 A0 C0
G1 X20 F1500
G0 Z60
T2 M6
G43 H2
S900 M4
G0 X10 Y10 Z60
G1 Z50
M2
"""


@pytest.mark.parametrize(
    ("line", "on", "before"),
    [
        (7, [("tool", 1), ("spindle", "clockwise"), ("signal", 3)], []),
        (9, [("signal", 3)], [("tool", 2), ("spindle", "counterclockwise")]),
        (10, [("tool", 2), ("signal", 3)], [("spindle", "counterclockwise")]),
        (12, [("tool", 2), ("spindle", "counterclockwise"), ("signal", 3)], []),
    ],
)
def test_what_is_on_is_what_holds_at_the_first_motion(
    machine: verne_post.Machine, line: int, on: list[Any], before: list[Any]
) -> None:
    """A tool change between the line and its first motion replaces the tool, and stops the spindle."""
    tools = {n: Tool(n, n, (0.0, 0.0, 50.0 + n, *(0.0,) * 6), 4.0) for n in (1, 2)}
    options = Options(tools=tools, approach="home", from_line=line, split_at_stops=True)
    rest = assemble(TWO_TOOLS.encode(), machine, options)

    def short(events: Any) -> list[tuple[str, object]]:
        return [(one.kind, next(iter(one.data.values()))) for one in events]

    assert short(rest.restored) == on
    ahead = [one for one in rest.moves.events if one.before == 0 and one not in rest.restored]
    assert short(ahead) == before


def test_a_stop_that_is_skipped_is_still_a_standstill(machine: verne_post.Machine) -> None:
    """The corner at M0 is not rounded in the whole program, so the restart behind it begins in the corner itself."""
    source = "G21 G90 G64 P0.5\nG0 X0 Y0 Z50 A0 C0\nG1 X30 F600\nM0\nY20\nX0\nM2\n"
    for line in (4, 5):
        options = Options(tool_length=60.0, approach="home", from_line=line)
        path = assemble(source.encode(), machine, options).path
        first = int(np.flatnonzero(path.move >= 0)[0])
        assert path.end[first - 1, :2] == pytest.approx([30.0, 0.0], abs=1e-9)


def test_nothing_is_left_after_the_end(machine: verne_post.Machine) -> None:
    with pytest.raises(InputError, match="no motion from line 26 on"):
        restarted(machine, 26)


def test_the_way_into_the_middle_feeds_at_its_end(machine: verne_post.Machine) -> None:
    """The last 10 mm of the plunge, along the tool axis, at the feed of the first feed move."""
    path = restarted(machine, 5).path
    last = int(np.flatnonzero(path.move < 0)[-1])
    assert path.end[last, 2] - path.start[last, 2] == pytest.approx(-10.0)
    assert path.length[last] / path.feed_time[last] == pytest.approx(1500.0 / 60.0)
    assert (path.feed_time[:last] == 0).all()


def test_a_stop_before_the_line_is_passed_and_one_after_it_splits(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("p.nc").write_text(
        "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X9 F900\nM0\nG1 X20\nG1 Y9\nM0\nG1 X0\nM2\n", encoding="utf-8"
    )
    place = ("p.nc", "--tool-length", 60, "--wcs", "G54=0,0,40", "--from", "home")
    assert run("convert", *place, "--from-line", 8, "-o", "a.csv").code == 0
    assert run("convert", *place, "--from-line", 5, "-o", "a.csv").code == 2
    assert run("convert", *place, "--from-line", 5, "-o", "b.csv", "--split-at-stops").code == 0
    assert sorted(path.name for path in tmp_path.glob("b.*")) == ["b.1.csv", "b.2.csv", "b.index.json"]
    again = ("--against", *place, "--from-line", 5, "--split-at-stops")
    assert run("verify", "b.index.json", *again).code == 0
    # the stop's own line: its stop is done by whoever takes the program up there
    assert run("convert", *place, "--from-line", 7, "-o", "c.csv").code == 0


def test_a_restart_needs_to_know_where_the_machine_stands(
    run: Callable[..., Any], sample_words: Callable[[str], list[str]]
) -> None:
    answer = run("convert", SAMPLES / "pocket_3axis.nc", *sample_words("pocket_3axis.nc"), "--from-line", 20)
    assert answer.code == 2
    assert "--from" in answer.err
    assert answer.out == ""


@pytest.mark.parametrize("angle", [90, 120, 150, 171])
def test_a_restart_begins_beside_a_sharp_corner_too(tmp_path: Path, run: Callable[..., Any], angle: float) -> None:
    """The middle of the blend is within 0.5 mm of both lines: up to 3 mm from their vertex."""
    program, out = tmp_path / "p.nc", tmp_path / "o.csv"
    x, y = 10 + 10 * np.cos(np.radians(angle)), 10 * np.sin(np.radians(angle))
    program.write_text(f"G21 G90 G64 P0.5\nG0 X0 Y0 Z5 A0 C0\nG1 X10 F700\nX{x:.4f} Y{y:.4f}\nM2\n")
    words = ("--tool-length", 80, "--wcs", "G54=0,0,60", "--from", "home", "--from-line", 4)
    answer = run("convert", program, *words, "-o", out)
    assert answer.code == 0, answer.err
    assert run("verify", out, "--against", program, *words).code == 0
    # a file whose motion begins farther away is found out: its first rows on the line are missing
    rows = out.read_text().splitlines(keepends=True)
    own = next(number for number, row in enumerate(rows) if row.endswith(",4\n"))
    out.write_text("".join(rows[: own + 1] + rows[own + 400 :]))
    assert run("verify", out, "--against", program, *words).code != 0


def test_a_line_inside_a_cycle_of_m89_is_refused(machine: verne_post.Machine) -> None:
    """Each positioning block drills there, with depths and feeds of blocks before."""
    program = (
        "BEGIN PGM A MM\n"
        "TOOL CALL 1 Z S900 F900\n"
        "L X+0 Y+0 Z+50 A+0 C+0 R0 FMAX M3\n"
        "CYCL DEF 200 DRILL Q200=2 Q201=-5 Q206=150 Q202=5 Q210=0 Q203=20 Q204=2 Q211=0\n"
        "L X+10 Y+10 FMAX M89\n"
        "L X+20 FMAX\n"
        "L X+30 FMAX\n"
        "L X+40 FMAX M99\n"
        "L Z+60 R0 FMAX\n"
        "END PGM A MM\n"
    )
    options = Options(tool_length=60.0, wcs={"G54": (0.0, 0.0, 40.0)}, dialect="heidenhain", approach="home")
    for line, refused in ((5, False), (6, True), (7, True), (8, True), (9, False)):
        try:
            assemble(program.encode(), machine, replace(options, from_line=line))
        except InputError as error:
            assert refused, error.findings[0].message
            assert error.findings[0].code == "VP029"
        else:
            assert not refused, line


HEAD = "G21 G90 G94\nT1 M6\nS1000 M3\n"
PLACE = "G54 G43 H1 G0 X-10 Y0 Z20 A0 C0\n"


@pytest.mark.parametrize(
    ("body", "line", "before", "said"),
    [
        # a clamp: what was executed last comes last, however often the program executed it before
        (
            "M11\n" + PLACE + "M10\nG1 Z10 F600\nM11\nG0 Z20\nG0 C90\nM10\nG1 X40\n",
            10,
            [("remapped", "M10", 6), ("remapped", "M11", 8)],
            "the program has executed, in this order: M10 of line 6, M11 of line 8",
        ),
        (
            PLACE + "M100 P1\nM100 P2\nM100 P1\nG1 Z10 F600\nX30\n",
            9,
            [("remapped", "M100", 6), ("remapped", "M100", 7)],
            "in this order: M100 P2 of line 6, M100 P1 of line 7",
        ),
        (
            PLACE + "M64 P1\nM68 E1 Q3.5\nG1 Z10 F600\nX30\n",
            8,
            [("signal", 1, 5), ("signal", 1, 6)],
            "digital output 1 as line 5 sets it, analog output 1 as line 6 sets it",
        ),
        # only the output of the same kind is set anew before the first motion
        (PLACE + "M64 P1\nM68 E1 Q3.5\nG1 Z10 F600\nM65 P1\nX30\n", 8, [("signal", 1, 6)], "analog output 1 as line 6"),
        ("M7\n" + PLACE + "G1 Z10 F600\nM8\nX30\n", 7, [("coolant", "mist", 7)], "coolant mist"),
        ("M7\n" + PLACE + "M8\nG1 Z10 F600\nM9\nX30\n", 8, [], ""),
        ("M5\nM19 R30\n" + PLACE + "G1 Z10 F600\nX30\n", 8, [("orient", 30.0, 8)], "stopped at 30 degrees"),
        ("M19 R30\n" + PLACE + "G1 Z10 F600\nM3\nX30\n", 7, [], ""),
        ("M52 P1\n" + PLACE + "G1 Z10 F600\nX30\n", 7, [("override", True, 7)], "adaptive on"),
        (
            "G96 D2000 S100\nS120\n" + PLACE + "G1 Z10 F600\nX30\n",
            8,
            [("spindle mode", "G96", 8)],
            "G96 (at most 2000/min), spindle clockwise at 120 m/min",
        ),
    ],
)
def test_what_the_skipped_lines_executed_is_repeated(
    machine: verne_post.Machine, body: str, line: int, before: list[Any], said: str
) -> None:
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0)}
    options = Options(tools=tools, remap=dict.fromkeys(("M10", "M11", "M100"), "event"), wcs={"G54": (0.0, 0.0, 60.0)})
    source = HEAD + body + "M30\n"
    whole = verne_post.convert(source, machine, options)
    rest = verne_post.convert(source, machine, replace(options, approach="home", from_line=line))
    assert rest.ok, rest.findings
    assert rest.summary is not None and whole.summary is not None
    others = [one for one in rest.summary.switched if one.kind not in ("tool", "spindle")]
    assert [(one.kind, next(iter(one.data.values())), one.line) for one in others] == before
    assert said in " ".join(str(rest.summary).split())
    # codes of the builder and outputs are, with their words, those of the whole program
    builder = [(one.kind, one.line, one.data) for one in rest.summary.switched if one.kind in ("signal", "remapped")]
    assert all(one in [(each.kind, each.line, each.data) for each in whole.summary.events] for one in builder)


def test_h_functions_of_siemens_are_repeated(machine: verne_post.Machine) -> None:
    source = "G17 G90 G71 G94\nT1 D1\nM6\nS3000 M3\nH5\nH=7\nH5\nG54\nG0 X-20 Y0 Z40 A0 C0\nG1 Z10 F500\nX10\nM30\n"
    options = Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 60.0)}, dialect="siemens", approach="home", from_line=11)
    rest = verne_post.convert(source, machine, options)
    assert rest.summary is not None
    told = [(one.data["code"], one.line) for one in rest.summary.switched if one.kind == "auxiliary"]
    assert told == [("H7", 6), ("H5", 7)]
    assert "in this order: H7 of line 6, H5 of line 7" in " ".join(str(rest.summary).split())


DWELLS = """G21 G90 G94
T1 M6
S1000 M3
G54 G43 H1 G0 X-10 Y0 Z20 A0 C0
G1 Z10 F600
G4 P0.25
G1 X40
M0
G4 P1
M8
T2 M6
M3
G4 P0.5
G43 H2
G1 X50
G1 X60
M30
"""


@pytest.mark.parametrize(
    ("line", "dwells", "stops"),
    [
        (6, [6, 9, 13], [8, 11]),
        (7, [9, 13], [8, 11]),
        (8, [9, 13], [11]),  # M0 directly before the first row of the program: its operator takes the program up
        (9, [9, 13], [11]),
        (10, [13], []),  # M6 too
        (12, [13], []),
        (13, [13], []),
        (14, [], []),
        (16, [], []),
    ],
)
def test_a_restart_keeps_every_dwell_from_its_line_on(
    machine: verne_post.Machine, line: int, dwells: list[int], stops: list[int]
) -> None:
    """Compared with the events and the rows of the whole program, which is cut at both stops of one place."""
    tools = {n: Tool(n, n, (0.0, 0.0, 70.0 + n, *(0.0,) * 6), 4.0) for n in (1, 2)}
    options = Options(tools=tools, wcs={"G54": (0.0, 0.0, 60.0)}, split_at_stops=True)
    whole = verne_post.convert(DWELLS, machine, options)
    rest = verne_post.convert(DWELLS, machine, replace(options, approach="home", from_line=line))

    def list_dwells(result: verne_post.Result) -> list[tuple[int, int, Any]]:
        """Line, rows that stand, and seconds of each dwell after its row of the events."""
        assert result.setpoints is not None and result.summary is not None
        values, found = result.setpoints.values, []
        for timed in result.summary.timed:
            if timed.event.kind == "dwell":
                after = (values[timed.row :] != values[timed.row]).any(axis=1)
                assert result.setpoints.line[timed.row + 1] == timed.event.line
                found.append((timed.event.line, int(np.argmax(after)), timed.event.data["seconds"]))
        return found

    assert rest.ok and rest.summary is not None and whole.summary is not None
    told = list_dwells(rest)
    assert [line for line, _rows, _seconds in told] == dwells
    assert all(rows >= seconds * 1000 for _line, rows, seconds in told)
    assert [one[2] for one in told] == [one[2] for one in list_dwells(whole)[3 - len(dwells) :]]
    assert [[one.line for one in part.then if one.kind in ("stop", "tool")] for part in rest.summary.parts[:-1]] == [
        [one] for one in stops
    ]
    assert [[one.line for one in part.then] for part in whole.summary.parts] == [[8], [10, 11, 12], [17]]
    assert rest.summary.dwell_time == pytest.approx(sum(one[2] for one in told))


SLOTS = """G21 G90 G94
T1 M6
S1000 M3
G54 G43 H1 G0 X-30 Y0 Z40 A0 C0
G1 Z5 F600
G1 X20
G0 X-30
G0 Z40
T2 M6
G43 H2
G0 Y8
G1 Z4 F600
G1 X20
G0 X-30 Y{}
G0 Z40
M30
"""


@pytest.mark.parametrize("y", [8, -9])
def test_skipped_lines_have_cut_the_stock(tmp_path: Path, run: Callable[..., Any], y: int) -> None:
    """A rapid back through a slot that was cut before line N is free; one through material is found as ever."""
    program = tmp_path / "p.nc"
    program.write_text(SLOTS.format(y))
    (tmp_path / "t.tbl").write_text("T1 P1 Z80 D10\nT2 P2 Z65.5 D6\n")
    words = (
        "--machine",
        "ac_trunnion",
        "--tool-table",
        tmp_path / "t.tbl",
        "--wcs",
        "G54=-10,15,60",
        "--split-at-stops",
    )
    checked = ("check", program, *words, "--stock", "G54=-40,-20,0,40,20,10")

    def list_contacts(*more: object) -> list[str]:
        answer = run(*checked, *more)
        found = [one for one in answer.err.splitlines() + answer.out.splitlines() if " VP216 " in one]
        # a restart in line 14 has no rounded corner before it, so its contact begins 0.1 mm earlier
        return [re.sub("begins .* before its end", "begins", one) for one in found]

    whole = list_contacts()
    assert len(whole) == (y != 8)
    for line in (7, 14):
        assert list_contacts("--from", "home", "--from-line", line) == whole, line
    answer = run(*checked, "--from", "home", "--from-line", 15)
    assert answer.code == 0, answer.err
    assert "on the table (as the lines before 15 have cut it)" in " ".join(answer.out.split() + answer.err.split())


def test_the_picture_of_what_is_left_has_the_skipped_cuts() -> None:
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0), 2: Tool(2, 2, (0.0, 0.0, 65.5, *(0.0,) * 6), 6.0)}
    stock = Box("the stock", (-40.0, -20.0, 0.0), (40.0, 20.0, 10.0), system=1)
    options = Options(tools=tools, wcs={"G54": (-10.0, 15.0, 60.0)}, stock=stock, split_at_stops=True)
    machine = verne_post.load_machine("ac_trunnion")

    def picture(**more: Any) -> Any:
        return make_left(assemble(SLOTS.format(8).encode(), machine, replace(options, **more)))[0]

    whole, rest = picture(), picture(approach="home", from_line=15)
    assert whole is not None and rest is not None
    assert np.array_equal(whole.vertices, rest.vertices)


@pytest.mark.parametrize(("line", "codes"), [(10, []), (7, ["VP505"]), (8, ["VP505"])])
def test_sizes_of_lines_before_a_restart_are_not_judged(tmp_path: Path, run: Callable[..., Any], line, codes) -> None:
    """F400000 of line 7 is in force in line 8, and no longer in line 11."""
    program = tmp_path / "a.nc"
    lines = (
        "G21 G17 G90 G94",
        "G49 G0 A0 C0",
        "X-20 Y-10",
        "Z160",
        "S900 M3",
        "G4 P1",
        "G1 Z150 F400000",
        "X0",
        "G0 Z160",
    )
    program.write_text("\n".join((*lines, "X5", "G1 Z150 F500", "X20", "M2", "")), "utf-8")
    place = ("--wcs", "G54=0,0,40", "--from", "home", "--from-line", line, "--limits-only", "--output-format", "json")
    found = json.loads(run("check", program, *place).out)["programs"][0]["findings"]
    assert [item["code"] for item in found if item["code"] == "VP505"] == codes
