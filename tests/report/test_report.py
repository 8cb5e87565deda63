"""What the report page holds: its numbers against the setpoint file, and that data stay data; test_browser.py
opens it.
"""

import base64
import inspect
import json
import re
import zlib
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import verne_post
from verne_post.cli.lsp import outline
from verne_post.config import list_machine_files
from verne_post.gcode.remarks import find_title, find_tool_remarks
from verne_post.model.options import Options
from verne_post.model.part_setup import Box, Tool, WorkOffset
from verne_post.report.head import write_verdict_html
from verne_post.report.scene import describe_scene
from verne_post.report.sheet import is_sheet_long, write_sheet_html
from verne_post.report.study import study
from verne_post.report.worst import write_findings_html, write_places_html
from verne_post.toolpath.margins import list_margin_functions

from ..benchmarks.random_chains import PLACES
from ..builders import MACHINE, SAMPLES
from ..kinematics.test_chain import CHAINS

POCKET = (SAMPLES / "pocket_3axis.nc", "--tool-length", 80, "--wcs", "G54=-10,15,60")
TRAVEL = (SAMPLES / "violates_slider_travel.nc", "--tool-length", 50, "--wcs", "G54=0,0,420")


TYPES = {
    "Float64Array": "<f8",
    "Float32Array": "<f4",
    "Int32Array": "<i4",
    "Uint32Array": "<u4",
    "Uint16Array": "<u2",
    "Int8Array": "|i1",
    "Uint8Array": "|u1",
}


def embedded(page: str) -> dict[str, Any]:
    """The data of a page, with its arrays by name."""
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)
    packed = re.search(r'<script id="bytes" type="text/plain">(.*?)</script>', page, re.DOTALL)
    assert found
    assert packed
    data, raw = json.loads(found[1]), zlib.decompress(base64.b64decode(packed[1]))
    for name, entry in data["arrays"].items():
        flat = np.frombuffer(raw, TYPES[entry["type"]], int(np.prod(entry["shape"])), entry["begin"])
        data[name] = flat.reshape(entry["shape"])
    return data


def program_text(data: dict[str, Any]) -> list[str]:
    return bytes(data["text"]).decode("utf-8").split("\n")


# --- what is shown ---------------------------------------------------------------------------------

#: A joint's name, and what of it is drawn: "position", or the order of the difference in per cent of its limit.
Curves = dict[tuple[str, int], tuple[np.ndarray, np.ndarray]]
LIMITS = (MACHINE.limits.velocity, MACHINE.limits.acceleration, MACHINE.limits.jerk)


def curves_of_page(data: dict[str, Any]) -> Curves:
    return {
        (joint["name"], order): (data[f"{name}.{k}.x"] * data["tick"], data[f"{name}.{k}.y"].astype(float))
        for order, name in enumerate(("position", "velocity", "acceleration", "jerk"))
        for k, joint in enumerate(data["joints"])
    }


def curves_of_picture(figure: Any) -> Curves:
    found: Curves = {}
    names = [column.joint for column in MACHINE.columns]
    drawn = [panel for panel in figure.axes if panel.lines and panel.get_xlabel() != "x mm on the table"]
    for panel, (order, joints) in zip(
        drawn, ((0, names[:3]), (0, names[3:]), (1, names), (2, names), (3, names)), strict=True
    ):
        for line, name in zip(panel.lines, joints, strict=True):
            found[name, order] = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    return found


def assert_true_to_the_rows(curves: Curves, frames: np.ndarray, values: np.ndarray, cycle: float) -> None:
    """Every point of a curve is a row's, and from frame to frame none of the rows goes beyond what the curve shows."""
    assert len(curves) == 20
    before = np.pad(values, ((3, 0), (0, 0)), mode="edge")
    for (name, order), (x, y) in curves.items():
        joint = [column.joint for column in MACHINE.columns].index(name)
        exact = np.diff(before[:, joint], order)[3 - order :] / cycle**order
        if order:
            exact = 100 * exact / (LIMITS[order - 1][joint] * abs(MACHINE.columns[joint].factor))
        row = np.round(x / cycle).astype(int)
        assert np.abs(x - row * cycle).max() < 1e-9
        assert (np.diff(row) > 0).all()
        # curves of the page have the 24 bits of a float32
        slack = 1e-7 * np.abs(exact).max()
        assert np.abs(y - exact[row]).max() <= slack, (name, order)
        begins = np.searchsorted(row, frames)
        assert np.array_equal(row[begins], frames)
        for extreme in (np.minimum, np.maximum):
            off = extreme.reduceat(y, begins) - extreme.reduceat(exact, frames)
            assert np.abs(off).max() <= slack, (name, order)


def test_a_long_program_is_shown_as_it_moves(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three minutes of 30,000 lines, slow but for some tenths of a second here and there: page and picture against the
    setpoint file.
    """
    pytest.importorskip("jupyter_threejs_sage")
    from verne_post.report import picture

    program, page, rows = tmp_path / "long.nc", tmp_path / "r.html", tmp_path / "rows.csv"
    turn = 2 * np.pi * np.arange(30_000) / 5000
    slow = [f"X{x:.3f} Y{y:.3f}\n" for x, y in zip(80 * np.sin(turn), 80 - 80 * np.cos(turn), strict=True)]
    fast = "G1 Z52 A1 F3000\nG1 Z50 A0 F3000\nF1000\n"
    blocks = [fast + "".join(slow[k : k + 5000]) for k in range(0, len(slow), 5000)]
    program.write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\n" + "".join(blocks) + "M2\n")
    kept: list[Any] = []
    monkeypatch.setattr(picture, "picture", lambda figure, suffix: kept.append(figure) or b"")
    assert run("report", program, "--tool-length", 60, "-o", page, "--static", tmp_path / "r.png").code == 0
    assert run("convert", program, "--tool-length", 60, "-o", rows).code == 0
    table = np.loadtxt(rows, delimiter=",", skiprows=1)
    t, values, line = table[:, 0], table[:, 1:6], table[:, 6]
    assert t[-1] > 175
    assert page.stat().st_size < 5e6
    data = embedded(page.read_text("utf-8"))
    x = data["x"]
    assert (x[0], x[-1]) == (0.0, pytest.approx(t[-1], abs=1e-12))
    assert np.diff(x).max() <= t[-1] / 1000
    frames = np.round(x / 0.001).astype(int)
    assert (
        np.ptp(np.diff(x)[:-1]) < 1e-8
    )  # so many blocks have no frame each: frames are evenly spaced, and the end is the last
    assert np.abs(data["q"] - values[frames]).max() < 1e-12
    assert np.array_equal(data["line"], line[frames])
    assert_true_to_the_rows(curves_of_page(data), frames, values, 0.001)
    assert_true_to_the_rows(curves_of_picture(kept[0]), frames, values, 0.001)


@pytest.mark.parametrize("frames", [2000, 50])
def test_frames_are_rows_and_nothing_between_is_lost(monkeypatch: pytest.MonkeyPatch, frames: int) -> None:
    monkeypatch.setattr("verne_post.report.study.FRAMES", frames)
    source = (SAMPLES / "pocket_3axis.nc").read_bytes()
    options = Options(tool_length=80.0, wcs={1: WorkOffset((-10.0, 15.0, 60.0))})
    seen = study(source, MACHINE, options)
    rows = verne_post.convert(source, MACHINE, options).setpoints
    assert rows is not None
    assert frames / 2 < len(seen.x) <= 2 * frames + 1
    at = np.round(seen.x / 0.001).astype(int)
    assert np.allclose(seen.q, rows.values[at], rtol=1e-14, atol=1e-14)
    assert np.array_equal(seen.line, rows.line[at])
    assert (at[0], at[-1]) == (0, len(rows.values) - 1)
    starts = np.flatnonzero(np.diff(rows.line)) + 1
    assert 10 < len(starts) <= frames
    assert np.isin(starts, at).all()  # the cursor can go block by block
    # tip, alpha and margin of every row by the public kinematics
    q = rows.values / [column.factor for column in MACHINE.columns]
    tip, _axis, _ok = MACHINE.forward(q, 80.0)
    alpha = MACHINE.module.forward(q[:, :3])[1]
    assert np.abs(seen.tip - tip[at]).max() < 1e-9
    speed = np.linalg.norm(np.diff(tip, axis=0, prepend=tip[:1]), axis=1) / 0.001
    assert np.abs(seen.speed - speed[at]).max() < 1e-6
    angles = np.stack([q[:, 3] - alpha, q[:, 4]], axis=1)
    margin = list_margin_functions(MACHINE)[0](tip, angles, np.full(len(q), 80.0)).min(axis=1)
    assert np.abs(seen.margin - margin[at]).max() < 1e-9
    assert np.abs(seen.alpha_deg - np.degrees(alpha[at])).max() < 1e-9
    assert np.abs(seen.alpha_deg).max() > 0.1  # degrees, not radians
    assert (seen.tool_length == 80.0).all()
    begins = np.searchsorted(seen.trail.frame, np.arange(len(at)))
    drawn_alpha = seen.curves["alpha"][0]
    shown = [
        (begins, seen.trail.margin, margin),
        *((begins, seen.trail.tip[:, k], tip[:, k]) for k in range(3)),
        (np.searchsorted(np.round(drawn_alpha.x / 0.001).astype(int), at), drawn_alpha.values, np.degrees(alpha)),
    ]
    for first, drawn, exact in shown:
        for extreme in (np.minimum, np.maximum):
            assert np.abs(extreme.reduceat(drawn, first) - extreme.reduceat(exact, at)).max() < 1e-9
    lengths = np.linalg.norm(seen.rods[:, :, 1] - seen.rods[:, :, 0], axis=-1)
    assert np.abs(lengths - [850, 850, 950, 950, 950, 950]).max() < 1e-5  # rounded rows
    # the tool ends where the forward kinematics say, carried to the machine by hand
    nose_to_tip = np.linalg.norm(seen.nose - seen.platform, axis=1)
    assert np.abs(nose_to_tip).max() < 1e-9  # nose offset 0


def test_lines_that_run_with_several_tools_are_shown_with_each() -> None:
    source = (
        b"G21 G90\no100 sub\nG1 X10 F600\nG1 X0\no100 endsub\nG43.1 Z60\nG0 X0 Y0 Z50 A0 C0\no100 call\nG43.1 "
        b"Z80\no100 call\nM2\n"
    )
    seen = study(source, MACHINE, Options())
    half = len(seen.x) // 2
    # the second tool is 20 mm longer, and the machine does not move for that
    assert np.abs(seen.tip[: half - 1, 2] - 50).max() < 1e-5
    assert np.abs(seen.tip[half + 1 :, 2] - 30).max() < 1e-5
    assert seen.trail.speed.max() < 10.1  # F600; a longer tool is no motion


def test_the_set_up_sheet_says_what_the_program_says_about_its_tools() -> None:
    """By number or by the tool's name, in the table of tools and where a person puts one in."""
    text = (
        '; T="BALL_D6" D=6 R3\n; T7 - NOT USED\nG17 G54 G90 G71\nT="BALL_D6"\nM6\nS900 M3\nG0 X0 Y0 Z50 D1\n'
        "G1 X5 F600\nT=2\nM6\nG0 Z49 D1\nM30\n"
    )
    names = {"siemens": {"tools": {"BALL_D6": 1}}}
    options = Options(
        dialect="siemens", tools={1: 60, 2: 60}, control=names, wcs={"G54": (0, 0, 0)}, split_at_stops=True
    )
    seen = study(text.encode(), MACHINE, options)
    page = re.sub(r"(<[^>]+>)+", "|", write_sheet_html("p.mpf", text.encode(), MACHINE, seen))
    assert "|1 &quot;BALL_D6&quot;|D=6 R3|60|not given in the set-up; remark: 6|900|" in page
    assert re.search(r"\|T2\|60\|not given\|off\|[\d.]+\|line 10, [\d.]+ s\|", page)
    # a person puts in each of them once: that stands beside the tool, not in a second list
    assert "|line 5, 0.000 s|" in page and "put in tool" not in page
    assert "NOT USED" not in page


def test_a_tool_with_only_a_name_is_drawn_by_its_name() -> None:
    """The numbers by which the program keeps such tools are its own."""
    text = b'G17 G54 G90 G71\nT="BALL_D6"\nM6\nS900 M3\nG0 X0 Y0 Z50 D1\nG1 X5 F600\nM30\n'
    options = Options(
        dialect="siemens",
        tools={100_001: (60, 8)},
        control={"siemens": {"tools": {"BALL_D6": 100_001}}},
        wcs={"G54": (0, 0, 0)},
    )
    assert describe_scene(MACHINE, study(text, MACHINE, options))["tools"] == {"BALL_D6": [[0.0, None, 4.0]]}


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("a.nc", "T1 M6 (FLAT MILL D5.5)"),
        ("a.nc", "(FLAT MILL D5.5)\nT1 M6"),
        ("a.nc", "T1 M6\n(FLAT MILL D5.5)"),
        ("a.nc", "(BORE)\n(FLAT MILL D5.5)\n\nN10 T01\nM06"),
        ("a.nc", "T1 (FLAT MILL D5.5)\nM6\n(BORE)"),
        ("a.nc", "(T1 FLAT MILL D5.5)\n(T2 END MILL D8)\nT1 M6 (ROUGH)"),
        ("a.mpf", "T1 D1 M6 ; FLAT MILL D5.5"),
        ("a.h", "TOOL CALL 1 Z S3000 ; FLAT MILL D5.5"),
    ],
)
def test_what_is_said_at_a_tool_change_is_said_of_the_tool(
    name: str, change: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """In the sheet, where a person puts it in, in a new set-up and in the outline of the editor."""
    klartext = name == "a.h"
    motion = "L X+0 Y+0 Z+50 A+0 C+0 R0 FMAX M3\nL X+5 F600" if klartext else "S900 M3\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F600"
    head, end = ("BEGIN PGM A MM", "END PGM A MM") if klartext else ("G21 G90" if name == "a.nc" else "G710 G90", "M30")
    length = "G43 H1\n" * (name == "a.nc")
    (tmp_path / name).write_text(f"{head}\n{change}\n{length}{motion}\n{end}\n")
    answer = run("setup", tmp_path / name)
    assert "FLAT MILL D5.5 - diameter from this remark, check it" in (tmp_path / f"{name}.toml").read_text()
    assert "the diameter of tool 1" in answer.err
    (tmp_path / f"{name}.toml").write_text("split_at_stops = true\n[tools]\n1.length = 60\n[wcs]\nG54 = [0, 0, 40]\n")
    assert run("report", tmp_path / name, "-o", tmp_path / "a.html").code == 0
    page = re.sub(r"(<[^>]+>)+", "|", (tmp_path / "a.html").read_text("utf-8"))
    assert re.search(r"\|T1\|FLAT MILL D5\.5\|60\|not given in the set-up; remark: 5\.5\|", page)
    assert "|put in at|T1|FLAT MILL D5.5|" in page
    text = (tmp_path / name).read_text()
    tools = [one.name for one in outline.Outline(text.split("\n"), "auto", text.encode(), name).list_symbols()]
    number = "01" if "T01" in change else "1"
    assert f"tool {number} ({'ROUGH' if 'ROUGH' in change else 'FLAT MILL D5.5'})" in tools


@pytest.mark.parametrize(
    "remark", ["DRILL", "DRILL HOLES", "POCKET 20 DEEP", "TAP 4 HOLES", "MILL 2", "T2 END MILL D8"]
)
def test_remarks_beside_a_tool_change_may_be_about_something_else(remark: str) -> None:
    for lines in (["T1 M6", f"({remark})"], [f"({remark})", "T1 M6"]):
        assert "1" not in find_tool_remarks(lines, "fanuc")
    assert find_tool_remarks(["(END MILL)", "G0 X0", "T1 M6", "G0 X1", "(END MILL)"], "fanuc") == {}


def test_the_sheet_says_who_gives_an_offset_and_how_the_part_is_turned(tmp_path: Path, run: Callable[..., Any]) -> None:
    program, page = tmp_path / "a.nc", tmp_path / "a.html"
    program.write_text("%\nO1042 (BRACKET OP10)\nG21 G90\nG0 X0 Y0 Z60 A0 C0\nG1 X5 F600\nG55\nX9\nM2\n")
    (tmp_path / "a.nc.toml").write_text("tool_length = 80\n[wcs]\nG54 = [0, 0, 50]\nG55 = [0, 0, 60, 10]\n")
    assert run("report", program, "-o", page, "--wcs", "G54=1,2,60").code == 0
    text = re.sub(r"(<[^>]+>)+", "|", page.read_text("utf-8"))
    assert "|G54|1|2|60|0|--wcs|G55|0|0|60|10|a.nc.toml|The part zero, from the rotary centre on the table" in text
    start = text.partition("|Start position|")[2].partition("|Tools|")[0]
    assert start.endswith(
        "|X|0.000 mm|Y|0.000 mm|Z|60.000 mm|A|0.0000 deg|C|0.0000 deg|"
        "X, Y, Z: the tip in G54, with a tool length of 80 mm."
    )
    assert "|G54 at 1, 2, 60 mm; G55 at 0, 0, 60 mm, turned 10 deg|" in text
    assert "|title|O1042 (BRACKET OP10)|" in text


@pytest.mark.parametrize(
    ("dialect", "text", "title"),
    [
        ("rs274", "%\n(BRACKET)\n(OP10)\nG21\n", "BRACKET"),
        ("rs274", "%\n(BRACKET)\nO7\nG21\n", "O7"),
        ("rs274", "G21\n(FACE)\n", ""),
        ("siemens", "%_N_LID_MPF\n;$PATH=/_N_WKS_DIR\nG71\n", "%_N_LID_MPF"),
        ("heidenhain", "0  BEGIN PGM LID MM\n", "LID"),
        ("aptcl", "$$ A\nPARTNO LID\n", "PARTNO LID"),
    ],
)
def test_the_title_of_a_program(dialect: str, text: str, title: str) -> None:
    assert find_title(text.split("\n"), dialect) == title


@pytest.mark.parametrize(
    ("dialect", "stop", "said"),
    [
        ("rs274", "M0 (TURN CLAMP 2)", "program stop: TURN CLAMP 2"),
        ("rs274", "(TURN CLAMP 2)\nM0", "program stop: TURN CLAMP 2"),
        ("rs274", "M0 (MSG, TURN CLAMP 2)", "program stop: TURN CLAMP 2"),
        ("rs274", "(CLAMP 1 STAYS)\n; TURN CLAMP 2\nM0", "program stop: CLAMP 1 STAYS; TURN CLAMP 2"),
        ("rs274", "(TURN CLAMP 2)\nG4 P1\nM0", "program stop"),  # about the dwell
        ("fanuc", "N10 M00 (TURN CLAMP 2)", "program stop: TURN CLAMP 2"),
        ("siemens", 'N1 MSG("TURN CLAMP 2")\nN2 M0 ;CLAMP', "program stop: TURN CLAMP 2"),
        ("siemens", "M0 ; TURN CLAMP 2 (BY HAND)", "program stop: TURN CLAMP 2 (BY HAND)"),
        ("heidenhain", "STOP ; TURN CLAMP 2", "program stop: TURN CLAMP 2"),
    ],
)
def test_the_sheet_says_what_to_do_at_a_stop(dialect: str, stop: str, said: str) -> None:
    moves = (
        ("BEGIN PGM P MM\nL X+1 F600\n", "L X+9\nEND PGM P MM\n")
        if dialect == "heidenhain"
        else ("G1 X1 F600\n", "X9\nM30\n")
    )
    text = f"{moves[0]}{stop}\n{moves[1]}".encode()
    options = Options(dialect=dialect, tool_length=80, wcs={"G54": (0, 0, 60)}, split_at_stops=True)
    seen = study(text, MACHINE, options)
    assert seen.program is not None, seen.findings
    page = re.sub(r"(<[^>]+>)+", "|", write_sheet_html("p", text, MACHINE, seen))
    assert f"|{said}|" in page


@pytest.mark.parametrize(
    ("between", "said"),
    [
        ("", "|none besides the tools above, each put in at its line|"),
        ("M0\n", "|program stop|Besides: the tools above, each put in at its line.|"),
    ],
)
def test_the_sheet_says_that_the_operator_puts_tools_in(between: str, said: str) -> None:
    """The actions were none, while convert named one for each tool."""
    text = f"T1 D1 M6\nG0 X0\nG1 X1 F600\n{between}T2 D1 M6\nG1 X2\nM30\n".encode()
    options = Options(dialect="siemens", tools={1: 80, 2: 80}, wcs={"G54": (0, 0, 60)}, split_at_stops=True)
    page = re.sub(r"(<[^>]+>)+", "|", write_sheet_html("p", text, MACHINE, study(text, MACHINE, options)))
    actions = page.partition("|Actions of the operator")[2]
    assert said in actions
    assert "put in tool" not in actions  # a tool is told once


def test_the_sheet_of_a_program_that_cannot_be_read_has_the_set_up() -> None:
    tools = {2: Tool(2, 2, (0, 0, 0, 0, 0, 0, 0, 0, 0), unmeasured="line 2"), 1: 120.0}
    options = Options(tools=tools, wcs={"G55": (1, 2, 45.5)}, unmeasured_wcs={1: "p.nc.toml"})
    text = b"(T1 face mill)\nG1 X2O\n"
    seen = study(text, MACHINE, options)
    assert seen.program is None
    page = re.sub(r"(<[^>]+>)+", "|", write_sheet_html("p.nc", text, MACHINE, seen))
    assert "|T1|face mill|120|not given|T2|to be measured|not given|From the set-up: the program was not read" in page
    assert "|G54|to be measured|G55|1|2|45.5|0|given|" in page
    head = re.sub(r"(<[^>]+>)+", "|", write_verdict_html(MACHINE, seen))
    assert "|T1: 120 mm; T2 to be measured, from the gauge line to the tip|" in head
    zero = "G54 to be measured, from the rotary centre on the table face to the part zero"
    assert f"|work offset|G55 at 1, 2, 45.5 mm; {zero}|" in head
    assert "Start position" not in page
    assert is_sheet_long(MACHINE, seen) is False


def test_errors_stand_before_warnings() -> None:
    text = b"G21 G90\nG0 X0 Y0 Z50 A0 C0\nG43\nG1 X5 F600\nG55\nX20 Y10\nG0 Z50\nZ800\nM2\n"
    options = Options(tool_length=80, wcs={"G54": (0, 0, 60), "G55": (0, 0, 60, 10)})
    seen = study(text, MACHINE, options)
    found = [item.severity for item in seen.findings]
    assert found.index("warning") < found.index("error")
    kinds = re.findall(r'<li class="(\w+)"', write_findings_html("p.nc", text, seen))
    assert kinds == sorted(kinds, key=["error", "warning", "note"].index)
    assert {"error", "warning"} <= set(kinds)


def test_findings_are_printed_before_a_long_table_of_tools() -> None:
    """Of 25 tools a page of paper has no room for a finding below them."""
    body = "".join(f"T{k} M6\nG43 H{k}\nG0 Z50\n" for k in range(1, 26))
    options = Options(tools=dict.fromkeys(range(1, 26), 80.0), wcs={"G54": (0, 0, 60)}, split_at_stops=True)
    seen = study(f"G21 G90\nG0 X0 Y0 Z60 A0 C0\n{body}G1 X10 F600\nM2\n".encode(), MACHINE, options)
    assert seen.timed
    assert is_sheet_long(MACHINE, seen) is True


#: 3000 short lines, one of which turns A too far.
ONE_IN_3000 = "".join(
    ["G21 G90\nG0 X0 Y0 Z50 A0 C0\nF1000\n", *(f"G1 X{k % 2} A{97 if k == 1501 else 0}\n" for k in range(3000)), "M2\n"]
)


def test_a_long_program_that_is_refused_is_shown_along_its_path(tmp_path: Path, run: Callable[..., Any]) -> None:
    pytest.importorskip("jupyter_threejs_sage")
    program, page = tmp_path / "p.nc", tmp_path / "r.html"
    program.write_text(ONE_IN_3000)
    assert run("report", program, "--tool-length", 60, "-o", page).code == 1
    seen = study(ONE_IN_3000.encode(), MACHINE, Options(tool_length=60.0))
    assert not seen.timed
    assert np.diff(seen.x).max() < 1.001e-3 * seen.x[-1]
    [index] = [k for k, item in enumerate(seen.findings) if item.code == "VP102"]
    assert seen.findings[index].worst_line == 1505
    assert abs(int(seen.line[seen.place[index]]) - 1505) <= 1
    # the highest A of all is drawn, whichever line has it
    a = seen.curves["position"][3].values
    assert np.nanmax(a) == pytest.approx(97, abs=3)  # and the alpha
    assert np.isfinite(seen.place_tip[index]).all()
    data = embedded(page.read_text("utf-8"))
    assert f'data-frame="{seen.place[index]}"' in page.read_text("utf-8")
    assert data["trail.bad"].any()
    # red is where it is: on the lines that turn to A 97 and back, beyond the limit
    assert set(seen.trail.line[seen.trail.bad].tolist()) <= {1505, 1506}
    assert (seen.trail.margin[seen.trail.bad] < 0).all()


@pytest.mark.parametrize("machine", ["serial", "linear_delta"])
def test_other_machines_have_a_page_too(tmp_path: Path, run: Callable[..., Any], machine: str) -> None:
    pytest.importorskip("jupyter_threejs_sage")
    answer = run("report", *POCKET, "--machine", machine, "-o", tmp_path / "r.html")
    assert answer.code == 0, answer.err
    data = embedded((tmp_path / "r.html").read_text("utf-8"))
    assert data["rods"].shape[1] == len(data["scene"]["guides"]) == (3 if machine == "linear_delta" else 0)


@pytest.mark.parametrize("machine", ["verne", *CHAINS, "tricept", "george_v", "hexapod", "hexam", "urane_sx"])
def test_the_drawn_tool_ends_on_the_drawn_path(machine: str) -> None:
    """The tip, carried by the drawn table or bed, is the nose less the tool; the bed lies level, under the part, as its
    x says.
    """
    loaded = verne_post.load_machine(machine)
    tilt, turn = loaded.rotary_letters
    place, length = {**PLACES, "tricept": (300.0, 100.0, 50.0)}.get(machine, (0.0, 0.0, 50.0)), 100.0
    source = f"G21 G90\nG0 X10 Y0 Z50 {tilt}0 {turn}0\nG1 X30 Y-20 {tilt}12 {turn}20 F900\nM2\n".encode()
    seen = study(source, loaded, Options(tool_length=length, wcs={1: WorkOffset(place)}))
    assert seen.timed, seen.findings
    scene = describe_scene(loaded, seen)
    table = [
        Rotation.from_rotvec(np.outer(turned, scene[name]))
        for name, turned in (("tiltAxis", seen.tilt), ("turnAxis", seen.turn))
    ]
    drawn = scene["pivot"] + table[0].apply(scene["offset"] + table[1].apply(np.array(scene["part"]) + seen.tip))
    assert np.abs(seen.nose - length * seen.basis[:, 1] - drawn).max() < 1e-6
    assert np.abs(seen.tip[[0, -1]] - place - [[10, 0, 50], [30, -20, 50]]).max() < 1e-4
    assert np.abs(table[0].apply(table[1].apply(seen.axis)) - seen.basis[:, 1]).max() < 1e-9
    assert np.abs((seen.basis[:, 0] * seen.basis[:, 1]).sum(axis=1)).max() < 1e-12
    if (bed := scene["bed"]) is not None:
        low, high = (np.array(bed["middle"][:2]) + side * np.array(bed["half"]) for side in (-1, 1))
        assert ((seen.tip[:, :2] > low) & (seen.tip[:, :2] < high)).all()
        assert bed["middle"][2] <= seen.tip[:, 2].min()
    assert scene["carries"] == {
        "ca_fork_head": 0,
        "nutating_head": 0,
        "tricept": 0,
        "hexapod": 0,
        "hexam": 0,
        "george_v": 0,
        "b_head_c_table": 1,
    }.get(machine, 2)


def test_the_plate_between_the_struts_is_not_the_spindle() -> None:
    """The wrist turns against it; its outline is that of the struts' ends at every frame."""
    loaded, options = verne_post.load_machine("tricept"), Options(tool_length=100.0, wcs={1: WorkOffset((300, 100, 0))})
    seen = study(b"G21 G90\nG0 X0 Y0 Z50 A20 C0\nG1 X90 A40 C60 F900\nM2\n", loaded, options)
    scene, ends = describe_scene(loaded, seen), seen.rods[:, :, 1]
    assert scene["joints"] == []
    outline = np.array(scene["plate"])
    for one, other in ((0, 1), (1, 2), (2, 0)):
        wanted = np.linalg.norm(outline[one] - outline[other])
        assert np.abs(np.linalg.norm(ends[:, one] - ends[:, other], axis=1) - wanted).max() < 1e-3
    # the central leg ends in the wrist's centre, 100 mm above the gauge line
    assert np.abs(ends[:, 3] - (seen.nose + 100.0 * seen.basis[:, 1])).max() < 1e-6


def test_the_slice_is_for_the_tool_axis_of_the_frame() -> None:
    """On a head that leans, the picture of the reach names the words, and lets the tool lean."""
    pytest.importorskip("jupyter_threejs_sage")
    from verne_post.report.page import make_page

    loaded = verne_post.load_machine("ca_fork_head")
    source = b"G21 G90\nG0 X0 Y0 Z50 A30 C20\nG1 X30 F900\nM2\n"
    options = Options(tool_length=100.0, wcs={1: WorkOffset(PLACES["ca_fork_head"])})
    data = embedded(make_page("part.nc", source, loaded, study(source, loaded, options)))
    assert data["slice"]["title"].endswith("A 30.0, C 20.0 deg")
    x, y = (np.linspace(*data["slice"][axis], 61) for axis in "xy")
    tip = np.array([x[0], y[-1], float(data["tip"][0, 2])])
    axis = np.array(data["axis"][0], dtype=float)
    joints, ok = loaded.inverse(tip, axis, 100.0)
    assert ok
    limits = loaded.limits
    spare = np.minimum(joints - limits.lower, limits.upper - joints)[:3].min()
    assert data["reach"][-1, 0] == pytest.approx(spare, abs=1e-2)


#: What a page could take for its own: markup, comments, places of the template, ends of lines of JavaScript, quotes.
NASTY = (
    "</script><script>alert(1)</script>",
    "<!--library-->",
    "<!--data-->",
    "<!--<script>",
    "<!--",
    "-->",
    "]]>",
    "<img src=x>",
    "&lt;&amp;&#60;",
    "\"'`onmouseover=alert(1) x='",
    "a\u2028b\u2029c",
    "\\u003c\\",
    "${data}",
    "\\1\\g<0>",
    "\x01\x7f",
)
NASTY_PROGRAM = (
    "G21 G90\nG0 X0 Y0 Z50 A0 C0\n" + "".join(f"G1 X{k + 1} F900 ;{text}\n" for k, text in enumerate(NASTY)) + "M2\n"
)
#: A folder and a file in it.
NASTY_NAME = "<!--data-->&lt;\"'`$x_{$\u2028\udcff<!--<script></script><script>alert(1)<!--.nc"


class Outline(HTMLParser):
    """The tags and comments of a page, and its texts outside of scripts."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, tuple[str, ...]]] = []
        self.texts: list[str] = []
        self.comments: list[str] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag != "wbr":  # where a file's name may break
            self.tags.append((tag, tuple(name for name, _value in attrs)))

    def handle_comment(self, data: str) -> None:
        self.comments.append(data)

    def handle_data(self, data: str) -> None:
        if self.cdata_elem is None:
            self.texts.append(data)


def outside_of_the_library(page: str) -> str:
    """All that is ours."""
    from verne_post.report.page import read_library

    before, found, after = page.partition(read_library())
    assert found
    return before + after


def test_data_stay_data(tmp_path: Path, run: Callable[..., Any]) -> None:
    pytest.importorskip("jupyter_threejs_sage")
    plain, page = tmp_path / "p.nc", tmp_path / "r.html"
    plain.write_text(re.sub(";.*", "", NASTY_PROGRAM))
    assert run("report", plain, "--tool-length", 60, "-o", page).code == 0
    expected = Outline(outside_of_the_library(page.read_text("utf-8")))
    assert [tag for tag, _names in expected.tags].count("script") == 9
    machine, program = tmp_path / "m.toml", tmp_path / NASTY_NAME
    text = list_machine_files()["verne"].read_text("utf-8")
    machine.write_text(text.replace('name = "VERNE"', 'name = "<!--library--></script>"'), "utf-8")
    program.parent.mkdir(exist_ok=True)
    program.write_text(NASTY_PROGRAM, "utf-8")
    assert run("report", program, "--tool-length", 60, "--machine", machine, "-o", page).code == 0
    written = page.read_text("utf-8")
    ours = outside_of_the_library(written)
    found = Outline(ours)
    assert (found.tags, found.comments) == (expected.tags, [])
    shown = str(program).replace("\u2028", "\\u2028").replace("\udcff", "\\udcff")
    assert f"{shown} on <!--library--></script>" in found.texts
    raw = re.search(r'type="application/json">(.*?)</script>', ours, re.DOTALL)
    assert raw
    assert raw[1].isascii()
    assert not set(raw[1]) & set("<>&")
    lines = NASTY_PROGRAM.removesuffix("\n").split("\n")
    assert program_text(embedded(written)) == [line.strip() for line in lines]
    # a message that quotes the program
    program.write_text(NASTY_PROGRAM.replace("M2", "G1 X<!--data--></ul>"))
    assert run("report", program, "--tool-length", 60, "-o", page).code == 2
    assert page.stat().st_size < 200_000  # nothing is drawn
    refused = Outline(page.read_text("utf-8"))
    assert refused.comments == []
    quoted = {"code", "mark"}
    assert {tag for tag, _names in refused.tags} <= {tag for tag, _names in expected.tags} | quoted
    assert not {name for _tag, names in found.tags + refused.tags for name in names if name.startswith("on")}


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_a_picture_takes_any_name(tmp_path: Path, run: Callable[..., Any], suffix: str) -> None:
    from xml.etree import ElementTree

    program, out = tmp_path / NASTY_NAME, tmp_path / f"r{suffix}"
    program.parent.mkdir(exist_ok=True)
    program.write_text(NASTY_PROGRAM, "utf-8")
    assert run("report", program, "--tool-length", 60, "--static", out).code == 0
    if suffix == ".svg":
        ElementTree.fromstring(out.read_bytes())


def test_the_page_has_no_address_outside_of_itself(tmp_path: Path, run: Callable[..., Any]) -> None:
    """Of the library, which names many, the settings leave none in use; the browser test below looks at what
    happens.
    """
    pytest.importorskip("jupyter_threejs_sage")
    assert run("report", *POCKET, "-o", tmp_path / "r.html").code == 0
    ours = outside_of_the_library((tmp_path / "r.html").read_text("utf-8"))
    assert re.findall(r"(?i)//[\w-]+\.|\b(?:src|href|action)\s*=|@import|url\(", ours) == []
    [policy] = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', ours)
    allowed = dict(part.split(None, 1) for part in policy.split("; "))
    assert allowed["default-src"] == "'none'"
    assert {source for sources in allowed.values() for source in sources.split()} <= {
        "'none'",
        "'unsafe-inline'",
        "data:",
        "blob:",
    }


#: A cut of 60 by 0 mm, and a rapid that leads far away.
FAR_RAPID = b"G21 G90\nG0 X0 Y0 Z20 A0 C0\nG1 Z0 F900\nX60\nG0 Z20\nG0 Y130\nM2\n"


def test_pictures_frame_what_is_cut() -> None:
    """A rapid to a place away from the part is drawn, and leaves the part as large as before."""
    pytest.importorskip("jupyter_threejs_sage")
    from verne_post.report.page import make_page

    seen = study(FAR_RAPID, MACHINE, Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 60.0))}))
    assert seen.trail.tip[:, 1].max() == pytest.approx(130.0, abs=0.01)
    assert np.ptp(seen.trail.framed, axis=0) == pytest.approx([60.0, 0.0, 20.0], abs=0.01)
    place = embedded(make_page("part.nc", FAR_RAPID, MACHINE, seen))["slice"]
    middles = [sum(place[axis]) / 2 for axis in "xy"]
    assert middles == pytest.approx([30.0, 0.0], abs=0.05)


def test_no_line_ends_between_a_number_and_its_unit() -> None:
    seen = study(FAR_RAPID, MACHINE, Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 60.0))}))
    shown = write_places_html(MACHINE, seen)
    assert "allowed 102\N{NO-BREAK SPACE}%" in shown
    assert not re.search(r"\d (?:%|mm|s|deg)\b", shown)


def test_a_joint_has_one_colour_in_all_panels(monkeypatch: pytest.MonkeyPatch) -> None:
    """And each panel has a legend, beside it, where it hides no curve."""
    from verne_post.report import picture

    kept: list[Any] = []
    monkeypatch.setattr(picture, "picture", lambda figure, suffix: kept.append(figure) or b"")
    text = b"G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F600\nM2\n"
    picture.picture_of("a.nc", MACHINE, study(text, MACHINE, Options(tool_length=80.0)), ".png")
    [figure] = kept
    figure.draw_without_rendering()
    panels = [panel for panel in figure.axes if panel.get_legend() is not None]
    assert [len(panel.lines) for panel in panels] == [3, 2, 5, 5, 5]
    colours: dict[str, set[str]] = {}
    for panel in panels:
        legend = panel.get_legend()
        assert [one.get_color() for one in legend.get_lines()] == [line.get_color() for line in panel.lines]
        assert legend.get_window_extent().x0 >= panel.get_window_extent().x1
        # a curve under an equal one is seen on both sides of it
        assert (np.diff([line.get_linewidth() for line in panel.lines]) < -0.25).all()
        for line in panel.lines:
            colours.setdefault(line.get_label(), set()).add(line.get_color())
    assert list(colours) == [column.joint for column in MACHINE.columns]
    assert [len(each) for each in colours.values()] == [1] * 5
    assert len(set.union(*colours.values())) == 5


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_a_static_picture(tmp_path: Path, run: Callable[..., Any], suffix: str) -> None:
    import matplotlib.image

    out = tmp_path / f"r{suffix}"
    for sample, code in ((POCKET, 0), (TRAVEL, 1)):
        assert run("report", *sample, "--static", out).code == code
        raw = out.read_bytes()
        if sample is POCKET:  # the same bytes again
            assert run("report", *sample, "--static", out).code == code
            assert out.read_bytes() == raw
        if suffix == ".png":
            pixels = matplotlib.image.imread(out)
            assert pixels[..., :3].std() > 0.05
        else:
            assert raw.count(b"<path") > 20
            assert b"<!-- position mm -->" in raw and b"<!-- position deg -->" in raw


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "say where to write"),
        (("--static", "r.gif"), "ends in .png or .svg"),
        (("-o", "no/r.html"), "the folder does not exist"),
    ],
)
def test_bad_options(run: Callable[..., Any], words: tuple[str, ...], said: str) -> None:
    answer = run("report", *POCKET, *words)
    assert answer.code == 2
    assert said in answer.err


def test_the_sheet_says_what_each_part_of_the_file_holds() -> None:
    """It said only into how many parts the file is cut."""
    text = (
        b"G21 G90 G94 G17 G54\nT1 M6\nG43 H1\nS900 M3\nG0 X0 Y0 Z150 A0 C0\nG1 Z140 F500\nX10\nG0 Z190\nM0\nG0 Z160\n"
        b"G1 X0\nT2 M6\nG43 H2\nS900 M3\nG0 Z150\nG1 Z140 F500\nM30\n"
    )
    options = Options(tools={1: 90, 2: 95}, wcs={"G54": (0, 0, 60)}, split_at_stops=True)
    seen = study(text, MACHINE, options)
    page = re.sub(r"(<[^>]+>)+", "|", write_sheet_html("p.nc", text, MACHINE, seen))
    assert seen.summary is not None
    table = page.partition("Parts of the setpoint file")[2]
    rows = re.findall(r"\|(\d)\|(\d+ to \d+)\|(T[^|]*)\|([\d.]+)(?=\|)", table)
    assert [row[:3] for row in rows] == [("1", "6 to 9", "T1"), ("2", "10 to 12", "T1"), ("3", "15 to 16", "T2")]
    assert sum(float(row[3]) for row in rows) == pytest.approx(seen.summary.cycle_time, abs=0.004)
    whole = study(text, MACHINE, options.changed(split_at_stops=False))
    assert "Parts of the setpoint file" not in write_sheet_html("p.nc", text, MACHINE, whole)


@pytest.mark.parametrize("end", ["X900", "X5 Q1"])
def test_the_head_of_a_refused_program_says_what_is_not_checked(end: str) -> None:
    text = f"G21 G90 G94 G17 G54\nG0 X0 Y0 Z150 A0 C0\nG1 Z140 F500\n{end}\nM30\n".encode()
    options = Options(tool_length=80.0, wcs={"G54": (0, 0, 60)})
    said = "<dt>not checked</dt><dd>contact with fixtures and stock: no [keep_out.NAME] and no [stock] given</dd>"
    seen = study(text, MACHINE, options)
    assert seen.summary is None
    assert said in write_verdict_html(MACHINE, seen)
    stock = Box("stock", (-10.0, -10.0, 0.0), (10.0, 10.0, 10.0))
    head = write_verdict_html(MACHINE, study(text, MACHINE, options.changed(stock=stock)))
    said = said.replace("fixtures and stock", "fixtures").replace(" and no [stock]", "")
    if seen.program is not None:  # as the command check says; Python has names of its own
        unchecked = inspect.unwrap(verne_post.check)(text, MACHINE, options.changed(stock=stock)).unchecked
        assert "the width of the tool: without a diameter it is a line" in unchecked
        said = f"<dt>not checked</dt><dd>{unchecked}</dd>"
    assert said in head
