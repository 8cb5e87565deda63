"""The stock of a program in the scene of the report, in the summary and in the side-car."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.report.stock import outline
from verne_post.report.study import study

from ..builders import MACHINE, SAMPLES

OPTIONS = Options(tool_length=80.0, wcs={1: WorkOffset((5.0, -7.0, 40.0), 90.0)}, dialect="heidenhain")


def lines_of(form: str) -> np.ndarray:
    text = (
        f"BEGIN PGM A MM\n{form}\nTOOL CALL 1 Z S900 F900\nL X+1 Y+2 Z+30 A+0 C+0 FMAX\nL X+5 FMAX\nM30\nEND PGM A MM"
    )
    return study(text.encode(), MACHINE, OPTIONS).stock


def test_a_box_stands_where_the_part_stands():
    """The part is turned by a quarter: its X is the table's Y."""
    drawn = lines_of("BLK FORM 0.1 Z X-40 Y-30 Z-10\nBLK FORM 0.2 X+40 Y+30 Z+5")
    corners = {tuple(point) for point in drawn[np.isfinite(drawn[:, 0])].round(6)}
    assert corners == {(5 - y, -7 + x, 40 + z) for x in (-40, 40) for y in (-30, 30) for z in (-10, 5)}
    ends = np.flatnonzero(np.isnan(drawn[:, 0]))
    edges = sum(len(part) - 1 for part in np.split(drawn, ends + 1)[:-1] for part in [part[:-1]])
    assert edges == 12


def test_a_cylinder_has_both_rims_and_its_bore():
    drawn = lines_of("BLK FORM CYLINDER Z R30 L20 DIST+2 RI10")
    points = drawn[np.isfinite(drawn[:, 0])]
    radius = np.hypot(points[:, 0] - 5, points[:, 1] + 7)
    assert set(radius.round(6)) == {10.0, 30.0}
    assert set(points[:, 2].round(6)) == {22.0, 42.0}


def test_no_stock_no_lines():
    assert outline(None, MACHINE).shape == (0, 3)


def test_page_summary_and_side_car_name_it(run: Callable[..., Any], tmp_path: Path):
    pytest.importorskip("plotly")
    where = ("--tool-length", 80, "--wcs", "G54=0,0,40")
    assert run("report", SAMPLES / "two_faces.h", *where, "-o", tmp_path / "r.html").code == 0
    assert '"name":"stock"' in (tmp_path / "r.html").read_text("utf-8")
    done = run("convert", SAMPLES / "two_faces.h", *where, "-o", tmp_path / "s.csv", "--meta", tmp_path / "m.json")
    assert "stock of the program: 80 x 60 x 15 mm from (-40, -30, -10) in G54" in " ".join(done.err.split())
    assert json.loads((tmp_path / "m.json").read_text())["stock"]["high_mm"] == [40, 30, 5]
