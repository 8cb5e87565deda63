"""--events: what is not motion, in step with the rows."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post as vp

PROGRAM = """G21 G90 G17 G54 G64
T1 M6
S5000 M3
M8
G0 X0 Y0 Z60 A0 C0
G1 X20 F1500
M9
G1 X20 Y20
(MSG, half way)
G4 P0.25
S7000
M4
G1 X0 Y20
M62 P3
G0 Z70
T2 M6
M3
G0 X10
M5
M30
"""
TOOLS = "T1 P1 Z60 D10\nT2 P2 Z60 D5\n"
PLACE = ("--tool-length", 60, "--wcs", "G54=0,0,30", "--split-at-stops")


@pytest.fixture
def job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("p.nc").write_text(PROGRAM.replace("T2 M6", "M60"), encoding="utf-8")
    return tmp_path


def parts() -> list[np.ndarray]:
    return [np.loadtxt(f"o.{number}.csv", delimiter=",", skiprows=1) for number in (1, 2)]


@pytest.mark.parametrize("more", [(), ("--from", "home"), ("--smoothing", "off"), ("--override", 0.4)])
def test_every_event_stands_at_the_row_where_its_motion_is_over(
    job: Path, run: Callable[..., Any], more: tuple[object, ...]
) -> None:
    answer = run("convert", "p.nc", *PLACE, *more, "-o", "o.csv", "--events", "e.json")
    assert answer.code == 0, answer.err
    found = json.loads(Path("e.json").read_text())
    assert found["program"] == "p.nc"
    rows = parts()
    events = found["events"]
    assert [(one["line"], one["kind"]) for one in events] == [
        (2, "tool"),
        (3, "spindle"),
        (4, "coolant"),
        (7, "coolant"),
        (9, "message"),
        (10, "dwell"),
        (11, "spindle"),
        (12, "spindle"),
        (14, "signal"),
        (16, "stop"),
        (17, "spindle"),
        (19, "spindle"),
        (20, "end"),
    ]
    for one in events:
        part = rows[one["part"] - 1]
        row = part[one["row"]]
        assert one["t_s"] == pytest.approx(row[0], abs=1e-12)
        assert list(one["axes"].values()) == row[1:6].tolist()
    by_line = {one["line"]: one for one in events}
    assert by_line[2]["row"] == by_line[4]["row"] == 0
    first, second = rows
    # the coolant goes off at the first row of line 8, the dwell begins with the rows of line 10
    assert by_line[7]["row"] == int(np.argmax(first[:, -1] == 8))
    assert by_line[9]["row"] == by_line[10]["row"] == int(np.argmax(first[:, -1] == 10))
    assert by_line[10]["seconds"] == 0.25
    assert by_line[12]["row"] == int(np.argmax(first[:, -1] == 13)) > by_line[10]["row"] + 249
    assert (by_line[11]["direction"], by_line[11]["speed"]) == ("clockwise", 7000.0)
    assert by_line[14]["row"] == int(np.argmax(first[:, -1] == 15))
    assert (by_line[16]["part"], by_line[16]["row"]) == (1, len(first) - 1)
    assert (by_line[19]["part"], by_line[19]["row"]) == (2, len(second) - 1)


def test_the_csv_says_the_same(job: Path, run: Callable[..., Any]) -> None:
    for name in ("e.json", "e.csv"):
        assert run("convert", "p.nc", *PLACE, "-o", "o.csv", "--events", name).code == 0
    events = json.loads(Path("e.json").read_text())["events"]
    with Path("e.csv").open(newline="", encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert len(table) == len(events)
    for row, one in zip(table, events, strict=True):
        assert (float(row["t_s"]), int(row["row"]), int(row["part"]), int(row["line"]), row["kind"]) == (
            one["t_s"],
            one["row"],
            one["part"],
            one["line"],
            one["kind"],
        )
        assert {name: float(row[name]) for name in one["axes"]} == one["axes"]
        assert json.loads(row["data"]).items() <= one.items()


def test_a_program_that_is_refused_writes_no_events(job: Path, run: Callable[..., Any]) -> None:
    assert run("convert", "p.nc", *PLACE[:-1], "-o", "o.csv", "--events", "e.csv").code == 2
    assert not Path("e.csv").exists()


def test_an_ending_that_means_nothing(job: Path, run: Callable[..., Any]) -> None:
    answer = run("convert", "p.nc", *PLACE, "-o", "o.csv", "--events", "e.txt")
    assert answer.code == 2
    assert "ends in .csv or .json" in answer.err


def test_a_restart_has_its_events_from_the_beginning(job: Path, run: Callable[..., Any]) -> None:
    more = ("--from", "home", "--from-line", 13)
    assert run("convert", "p.nc", *PLACE, *more, "-o", "o.csv", "--events", "e.json").code == 0
    events = json.loads(Path("e.json").read_text())["events"]
    begin = [(one["kind"], one["line"]) for one in events if one["row"] == 0 and one["part"] == 1]
    assert begin == [("tool", 13), ("spindle", 13)]
    assert events[1]["direction"] == "counterclockwise"
    assert all(one["line"] >= 13 for one in events)


@pytest.mark.parametrize("number", [None, 7])
def test_a_tool_with_only_a_name_has_no_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any], number: int | None
) -> None:
    monkeypatch.chdir(tmp_path)
    change = 'T="{}"\nM6\nS5000 M3\nG0 X0 Y0 Z10\nG1 X20 F500\n'
    Path("p.mpf").write_text(f"G17 G90 G54\n{change.format('EM_10')}M0\n{change.format('EM_20')}M30\n")
    given = "" if number is None else f", number = {number}"
    lengths = f"EM_10 = {{ length = 90, diameter = 10 }}\nEM_20 = {{ length = 110, diameter = 20{given} }}\n"
    Path("p.mpf.toml").write_text(f"split_at_stops = true\n[tools]\n{lengths}[wcs]\nG54 = [0, 0, 60]\n")
    assert run("convert", "p.mpf", "-o", "o.csv", "--events", "e.json").code == 0
    expected = [(None, "EM_10"), (number, "EM_20")]
    events = json.loads(Path("e.json").read_text())["events"]
    assert [(one["number"], one["name"]) for one in events if one["kind"] == "tool"] == expected
    index = json.loads(Path("o.index.json").read_text())
    every = [*index["before"], *(event for part in index["parts"] for event in part["then"])]
    assert [(one["number"], one["name"]) for one in every if one["kind"] == "tool"] == expected
    assert run("verify", "o.index.json", "--against", "p.mpf").code == 0
    result = vp.convert(Path("p.mpf"))
    assert result.summary is not None
    assert result.summary.tools == (("EM_10", 90.0), (number or "EM_20", 110.0))
    record = result.summary.options.record()
    assert record["tools"] == {"EM_10": [90.0, 10.0], str(number or "EM_20"): [110.0, 20.0]}
    assert record["control"]["siemens"]["tools"] == {"EM_10": None, "EM_20": number}  # type: ignore[index]
    said = 'tool "EM_10": 90 mm, tool ' + (f'{number} "EM_20"' if number else '"EM_20"') + ": 110 mm"
    assert said in " ".join(str(result.summary).split())
