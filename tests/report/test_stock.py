"""The stock of a program in the scene of the report, in the summary and in the metadata file."""

import json
import re
import runpy
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from verne_post.model.options import Options
from verne_post.model.part_setup import Box, FixtureMesh, OwnStock, Tool, WorkOffset
from verne_post.report.scene import describe_scene
from verne_post.report.sheet import write_sheet_html
from verne_post.report.study import study

from ..builders import MACHINE, SAMPLES
from ..kinematics.test_fixture_meshes import pack_stl, unite_boxes

PLATE = pack_stl(unite_boxes([((-1.0, -2.0, 0.0), (1.0, 2.0, 0.5))]))
OPTIONS = Options(tool_length=80.0, wcs={1: WorkOffset((5.0, -7.0, 40.0), 90.0)}, dialect="heidenhain")


def boxes_of(form: str) -> list[dict[str, Any]]:
    text = (
        f"BEGIN PGM A MM\n{form}\nTOOL CALL 1 Z S900 F900\nL X+1 Y+2 Z+30 A+0 C+0 FMAX\nL X+5 FMAX\nM30\nEND PGM A MM"
    )
    boxes: list[dict[str, Any]] = describe_scene(MACHINE, study(text.encode(), MACHINE, OPTIONS))["boxes"]
    return boxes


def test_a_box_stands_where_the_part_stands():
    """The part is turned by a quarter: its X is the table's Y."""
    [box] = boxes_of("BLK FORM 0.1 Z X-40 Y-30 Z-10\nBLK FORM 0.2 X+40 Y+30 Z+5")
    along, across = (
        np.array([np.cos(box["turn"]), np.sin(box["turn"])]),
        np.array([-np.sin(box["turn"]), np.cos(box["turn"])]),
    )
    corners = {
        (
            *np.round(box["middle"][:2] + i * box["half"][0] * along + j * box["half"][1] * across, 6),
            round(box["middle"][2] + k * box["half"][2], 6),
        )
        for i in (-1, 1)
        for j in (-1, 1)
        for k in (-1, 1)
    }
    assert corners == {(5 - y, -7 + x, 40 + z) for x in (-40, 40) for y in (-30, 30) for z in (-10, 5)}
    assert (box["round"], box["stock"]) == (False, True)


def test_a_cylinder_has_its_bore():
    [box] = boxes_of("BLK FORM CYLINDER Z R30 L20 DIST+2 RI10")
    assert box["round"]
    assert np.allclose(box["middle"], [5.0, -7.0, 32.0])
    assert np.allclose(box["half"], [30.0, 30.0, 10.0])
    assert box["bore"] == 10.0


def test_no_stock_no_box():
    assert boxes_of("") == []


@pytest.mark.parametrize(
    ("stock", "said"),
    [
        (None, "80 x 60 x 15 mm from (-40, -30, -10); not checked (--stock program checks it)"),
        (OwnStock(), "80 x 60 x 15 mm from (-40, -30, -10)"),
        (Box("the stock", (-1.0, -2.0, -3.0), (1.0, 2.0, 3.0)), "-1 to 1; -2 to 2; -3 to 3"),
        (FixtureMesh("the stock", PLATE, unit="cm", file="plate.stl"), "-10 to 10; -20 to 20; 0 to 5; plate.stl"),
        (FixtureMesh("the stock", b"", file="plate.stl"), "plate.stl"),  # a finding says that it cannot be read
    ],
)
def test_the_sheet_has_the_stock_and_whether_it_is_checked(stock: Any, said: str) -> None:
    source = (SAMPLES / "two_faces.h").read_bytes()
    sheet = write_sheet_html("p.h", source, MACHINE, study(source, MACHINE, replace(OPTIONS, stock=stock)))
    kind = re.findall('<div class="([^"]*)"><h3>Fixtures and stock</h3>', sheet)
    assert kind == ["named wide" if len(said) > 30 else "named"]  # a long place has two columns
    cells = re.findall("<td>([^<]*)</td>", sheet.partition("<h3>Fixtures and stock</h3>")[2].partition("</table>")[0])
    own = isinstance(stock, OwnStock | None)
    assert cells == [*(("the stock of the program", "G54") if own else ("the stock", "table")), said]


def test_page_summary_and_side_car_name_it(run: Callable[..., Any], tmp_path: Path):
    pytest.importorskip("jupyter_threejs_sage")
    where = ("--tool-length", 80, "--wcs", "G54=0,0,40")
    assert run("report", SAMPLES / "two_faces.h", *where, "-o", tmp_path / "r.html").code == 0
    assert '"name":"the stock of the program"' in (tmp_path / "r.html").read_text("utf-8")
    done = run("convert", SAMPLES / "two_faces.h", *where, "-o", tmp_path / "s.csv", "--meta", tmp_path / "m.json")
    assert "stock of the program: 80 x 60 x 15 mm from (-40, -30, -10) in G54" in " ".join(done.err.split())
    assert json.loads((tmp_path / "m.json").read_text())["stock"]["high_mm"] == [40, 30, 5]


def test_the_page_opens_where_the_contact_begins() -> None:
    """Not where the line is nearest to another limit, here at its beginning."""
    text = "G90\nT1 M6\nG54 G0 X-40 Y-20 A0 C0\nG68.2 X0 Y20 Z0 I0 J30 K0\nG53.1\nG43 H1 Z50\nX-20 Y0\nZ3\nM30\n"
    options = Options(
        tools={1: Tool(1, 1, (0.0, 0.0, 100.0) + (0.0,) * 6, 12.0)},
        wcs={1: WorkOffset((0.0, 0.0, 60.0))},
        stock=Box("the stock", (-45.0, -30.0, -30.0), (45.0, 30.0, 0.0), 1),
        dialect="fanuc",
    )
    found = study(text.encode(), MACHINE, options)
    (index,) = (k for k, item in enumerate(found.findings) if item.code == "VP216")
    said = re.search(r"begins ([\d.]+) mm along line 8, ([\d.]+) mm before its end", found.findings[index].message)
    assert said is not None
    line = found.tip[found.line == 8]
    begin, at = found.place_tip[index] - line[0], found.tip[found.place[index]]
    assert np.linalg.norm(found.place_tip[index] - line[-1]) == pytest.approx(float(said[2]), abs=0.06)
    assert np.linalg.norm(begin) == pytest.approx(float(said[1]), abs=1.0)  # the first frame is within the line
    assert np.linalg.norm(at - found.place_tip[index]) < 1.0


@pytest.mark.parametrize("is_mesh", [False, True])
def test_a_fixture_is_shown_where_the_contact_begins(is_mesh: bool) -> None:
    """The line begins 70 mm before the clamp; the next one also ends in it, beside a rapid that is free."""
    low, high = (30.0, -15.0, -10.0), (60.0, 15.0, 20.0)
    vise = runpy.run_path(str(SAMPLES / "make_vise_sample.py"))
    raw = vise["pack_stl"](vise["unite_boxes"]([(low, high)]))
    clamp = FixtureMesh("clamp", raw, system=1) if is_mesh else Box("clamp", low, high, 1)
    options = Options(
        tools={1: Tool(1, 1, (0.0, 0.0, 120.0) + (0.0,) * 6, 10.0)},
        wcs={1: WorkOffset((0.0, 0.0, 60.0))},
        keep_out=(clamp,),
    )
    text = b"G21 G90\nT1 M6\nG54 G0 X-40 Y0 A0 C0\nG43 H1 Z30\nG1 Z-2 F500\nX40\nG0 Z50\nM30\n"
    found = study(text, MACHINE, options)
    places = {found.findings[k].message: found.place[k] for k in range(len(found.findings))}
    (at,) = (place for message, place in places.items() if message.startswith("the cutter"))
    assert found.line[at] == 6
    assert found.tip[at] == pytest.approx([25.0, 0.0, 58.0], abs=0.6)  # its radius before the clamp
