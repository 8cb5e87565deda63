"""--split-at-stops: parts that meet, an index that is complete, and nothing that runs through a stop."""

import itertools
import json
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post as vp
from verne_post.app.assemble import cut_at_stops, read_draft
from verne_post.model.moves import Moves
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool
from verne_post.toolpath.splice import find_recorded

TOOLS = "T1 P1 Z80 D10\nT2 P2 Z95 D5\n"
PROGRAM = """G21 G90 G17 G54
T1 M6
G43 H1 G0 X0 Y0 Z40 A0 C0
S5000 M3 M8
G0 Z10
G1 X20 F1500
G0 Z60
M9
T2 M6
(MSG, drill in)
M0
G43 H2 G0 X10 Y10 Z60
S2000 M3
G81 Z5 R12 F300
X15
G80 G0 Z60 A10
G4 P.05
M1
M60
G1 X0 F2000
M0
M2
"""
FILES = ["two.1.csv", "two.2.csv", "two.3.csv"]


@pytest.fixture
def job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("t.tbl").write_text(TOOLS)
    Path("two.nc").write_text(PROGRAM)
    return tmp_path


PLACE = ("--tool-table", "t.tbl", "--wcs", "G54=0,0,40")


def table(name: str) -> np.ndarray:
    return np.loadtxt(name, delimiter=",", skiprows=1)


@pytest.mark.parametrize("more", [(), ("--smoothing", "off"), ("--from", "home"), ("--rapids", "joint")])
def test_parts_meet_and_rest(job: Path, run: Callable[..., Any], more: tuple[str, ...]) -> None:
    answer = run("convert", "two.nc", *PLACE, *more, "--split-at-stops", "-o", "two.csv")
    assert answer.code == 0, answer.err
    assert sorted(path.name for path in job.glob("two.*")) == [
        "two.1.csv",
        "two.2.csv",
        "two.3.csv",
        "two.index.json",
        "two.nc",
    ]
    parts = [table(name) for name in FILES]
    for before, after in itertools.pairwise(parts):
        assert np.array_equal(before[-1, 1:-1], after[0, 1:-1])
    for part in parts:
        assert np.allclose(part[:, 0], 0.001 * np.arange(len(part)), atol=1e-9)
        # at rest: 1 um or degree/1000 in the first and last cycle is far more than jerk limits allow
        assert np.abs(part[1, 1:-1] - part[0, 1:-1]).max() < 1e-3
        assert np.abs(part[-1, 1:-1] - part[-2, 1:-1]).max() < 1e-3
    lines = [set(part[:, -1].astype(int).tolist()) for part in parts]
    assert lines[0] <= {0, 3, 5, 6, 7, 9}
    assert lines[1] <= {12, 14, 15, 16, 17, 19}
    assert lines[2] <= {20}
    verdict = run("verify", "two.index.json", "--against", "two.nc", *PLACE, *more, "--split-at-stops")
    assert verdict.code == 0, verdict.err
    alone = run("verify", "two.1.csv", "--against", "two.nc", *PLACE, *more, "--split-at-stops")
    spelled = f"verne-post verify two.index.json --against two.nc {' '.join((*PLACE, *more))} --split-at-stops"
    # findings, which are about the parts that are not here, would look like faults of this one
    assert (alone.code, alone.out) == (3, "")
    assert alone.err == (
        f"two.1.csv is part 1 of 3. Alone, it is not checked for completeness. Verify all parts together: {spelled}\n"
    )
    assert run(*shlex.split(spelled)[1:]).code == 0
    assert re.search(r"^  verify +(verne-post .*)$", answer.err, re.MULTILINE)[1] == spelled  # type: ignore[index]
    assert run("verify", "two.index.json", "--against", "two.nc", *PLACE, *more).code == 0  # parts say what they are
    later = run("verify", "two.2.csv", "--against", "two.nc", *PLACE, *more, "--split-at-stops")
    assert later.code == 3
    assert later.err.startswith("two.2.csv is part 2 of 3. Alone, only the limits of its joints are check")


@pytest.mark.parametrize(("part", "codes"), [(1, {"VP401", "VP411"}), (2, {"VP401"})])
def test_a_part_alone_is_refused_for_what_its_own_rows_do(
    job: Path, run: Callable[..., Any], part: int, codes: set[str]
) -> None:
    del job
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv", "--meta", "two.json").code == 0
    head, *rows = Path(f"two.{part}.csv").read_text().splitlines()
    cells = rows[len(rows) // 2].split(",")
    cells[1] = f"{float(cells[1]) + 3:.6f}"  # one joint goes there and back, 3 mm in a control cycle
    rows[len(rows) // 2] = ",".join(cells)
    Path(f"two.{part}.csv").write_text("\n".join((head, *rows, "")))
    command = ("verify", f"two.{part}.csv", "--against", "two.nc", *PLACE, "--split-at-stops")
    answer = run(*command)
    assert answer.code == 1
    found = set(re.findall(r"VP\d+", answer.err))
    assert codes <= found
    assert "VP412" not in found
    assert (part == 1) or found.isdisjoint({"VP404", "VP411", "VP413"})
    assert f"two.{part}.csv is part {part} of 3." in answer.err
    # nor does the part keep what its metadata say to itself
    Path("two.nc").write_text(PROGRAM.replace("F300", "F301"))
    assert "the program is not the one that it was made from" in run(*command, "--meta", "two.json").err


def test_the_index_says_what_is_to_do(job: Path, run: Callable[..., Any]) -> None:
    answer = run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv")
    assert (
        "operator between the 3 parts into which the file is cut: load tool 2 (line 9); program stop (line 11); pallet "
        "stop (line 19)" in " ".join(answer.err.split())
    )
    assert "before the start: load tool 1 (line 2) operator between" in " ".join(answer.err.split())
    assert "at the end: program stop (line 21)" in " ".join(answer.err.split())
    index = json.loads((job / "two.index.json").read_text())
    assert [part["file"] for part in index["parts"]] == FILES
    for part in index["parts"]:
        rows = len(table(part["file"]))
        assert part["rows"] == rows
        assert part["duration_s"] == pytest.approx((rows - 1) * index["cycle_s"])
    then = [[(event["line"], event["kind"]) for event in part["then"]] for part in index["parts"]]
    assert then == [
        [(8, "coolant"), (9, "tool"), (10, "message"), (11, "stop")],
        [(18, "stop"), (19, "stop")],
        [(21, "stop"), (22, "end")],
    ]
    assert index["parts"][0]["then"][1]["number"] == 2


def test_without_the_option_such_programs_are_refused(job: Path, run: Callable[..., Any]) -> None:
    answer = run("convert", "two.nc", *PLACE)
    assert answer.code == 2
    assert answer.out == ""
    assert "--split-at-stops" in answer.err
    assert run("check", "two.nc", *PLACE).code == 2
    assert run("check", "two.nc", *PLACE, "--split-at-stops").code == 0
    assert run("convert", "two.nc", *PLACE, "--split-at-stops").code == 2  # no name for the files


def test_a_setup_that_cuts_needs_a_name_for_the_files(job: Path, run: Callable[..., Any]) -> None:
    Path("two.nc.toml").write_text("split_at_stops = true\n")
    refused = run("convert", "two.nc", *PLACE)
    assert refused.code == 2
    assert refused.out == ""
    assert "writes one file from each stop to the next; give their name: -o axes.csv" in refused.err
    assert run("convert", "two.nc", *PLACE, "-o", "two.csv").code == 0
    assert [Path(name).is_file() for name in FILES] == [True] * len(FILES)


def test_a_program_without_stops_is_one_part(job: Path, run: Callable[..., Any]) -> None:
    Path("one.nc").write_text("G49 G0 X0 Y0 Z120 A0 C0\nG1 X5 F900\nM2\n")
    assert run("convert", "one.nc", "--wcs", "G54=0,0,40", "-o", "whole.csv").code == 0
    assert run("convert", "one.nc", "--wcs", "G54=0,0,40", "-o", "one.csv", "--split-at-stops").code == 0
    assert Path("one.1.csv").read_bytes() == Path("whole.csv").read_bytes()
    assert not Path("one.csv").exists()


def test_optional_stops_cut_only_when_they_stop(job: Path, run: Callable[..., Any]) -> None:
    Path("two.nc").write_text(PROGRAM.replace("M60\n", ""))
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "a.csv").code == 0
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "--optional-stop", "-o", "b.csv").code == 0
    assert [len(list(job.glob(f"{name}.*.csv"))) for name in "ab"] == [2, 3]


@pytest.mark.parametrize("damage", ["shifted", "missing", "not an index", "swapped"])
def test_damaged_parts_are_found(job: Path, run: Callable[..., Any], damage: str) -> None:
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv").code == 0
    file = Path("two.2.csv")
    if damage == "shifted":
        lines = file.read_text().splitlines()
        cells = lines[1].split(",")
        lines[1] = ",".join([cells[0], f"{float(cells[1]) + 0.5:.7f}", *cells[2:]])
        file.write_text("\n".join(lines) + "\n")
    elif damage == "missing":
        file.unlink()
    elif damage == "not an index":
        Path("two.index.json").write_text("[]")
    else:
        index = json.loads(Path("two.index.json").read_text())
        index["parts"][1]["file"], index["parts"][2]["file"] = index["parts"][2]["file"], index["parts"][1]["file"]
        Path("two.index.json").write_text(json.dumps(index))
    answer = run("verify", "two.index.json", "--against", "two.nc", *PLACE, "--split-at-stops")
    assert answer.code == 2
    assert "VP020" in answer.err
    # one part is not all, and without an index nothing says that it is one
    alone = run("verify", "two.1.csv", "--against", "two.nc", *PLACE, "--split-at-stops")
    assert alone.code == (1 if damage == "not an index" else 3)
    assert ("if these are rows of one part, verify all parts together" in alone.err) == (alone.code == 1)


# --- what a hostile reader found ---------------------------------------------------------------------------

CHANGE = """G21 G90 G54 G94
T1 M6
G43 H1
S1000 M3
G0 X0 Y0 Z20
G1 X10 F1000
M9
G0
M5
T2 M6
G0 G90 G54
S5000 M3
G4 P0.05
M8
G43 H2
G0 X0 Y0 Z30
M30
"""


def test_no_event_is_lost_beside_moves_without_length_and_dwells(job: Path, run: Callable[..., Any]) -> None:
    Path("c.nc").write_text(CHANGE)
    assert run("convert", "c.nc", *PLACE, "--split-at-stops", "-o", "c.csv").code == 0
    index = json.loads(Path("c.index.json").read_text())
    assert [(event["line"], event["kind"]) for event in index["before"]] == [(2, "tool"), (4, "spindle")]
    assert [[(event["line"], event["kind"]) for event in part["then"]] for part in index["parts"]] == [
        [(7, "coolant"), (9, "spindle"), (10, "tool"), (12, "spindle"), (14, "coolant")],
        [(17, "end")],
    ]


def test_cuts_must_be_at_the_stops(job: Path, run: Callable[..., Any]) -> None:
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv").code == 0
    index = json.loads(Path("two.index.json").read_text())
    texts = [Path(name).read_text().splitlines() for name in FILES]
    rows = [line.partition(",")[2] for text in texts for line in text[1:]]
    joined = [texts[0][0], *(f"{0.001 * k:.3f},{rest}" for k, rest in enumerate(rows))]
    Path("two.1.csv").write_text("\n".join(joined) + "\n")
    Path("two.index.json").write_text(json.dumps({**index, "parts": index["parts"][:1]}))
    answer = run("verify", "two.index.json", "--against", "two.nc", *PLACE, "--split-at-stops")
    assert answer.code == 2
    assert "1 part, and the program has 2 stops" in answer.err
    Path("two.index.json").write_text(json.dumps({"parts": [{"file": "a\u0000"}] * 3}))
    assert run("verify", "two.index.json", "--against", "two.nc", *PLACE, "--split-at-stops").code == 2


def test_parts_of_an_older_run_do_not_stay(job: Path, run: Callable[..., Any]) -> None:
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv").code == 0
    Path("two.nc").write_text(PROGRAM.replace("M60\n", ""))
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv").code == 0
    assert sorted(path.name for path in job.glob("two.*.csv")) == ["two.1.csv", "two.2.csv"]


def test_rows_of_an_older_run_do_not_stay_beside_those_of_this_one(job: Path, run: Callable[..., Any]) -> None:
    """Whole and cut by turns under one name: nobody shall run rows of another program."""
    Path("two.csv").write_text("rows of another program\n")
    answer = run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv")
    assert answer.code == 0
    parts = ["two.1.csv", "two.2.csv", "two.3.csv", "two.index.json"]
    assert f"written         {', '.join(parts)}" in answer.err
    assert sorted(path.name for path in job.glob("two.*[vn]")) == parts
    Path("two.9.csv").write_text("not of the index\n")
    Path("one.nc").write_text("G21 G90\nG0 X0 Y0 Z90 A0 C0\nG1 X5 F600\nM2\n")
    assert run("convert", "one.nc", *PLACE, "--tool-length", "80", "-o", "two.csv").code == 0
    assert sorted(path.name for path in job.glob("two.*[vn]")) == ["two.9.csv", "two.csv"]


@pytest.mark.parametrize(
    "more", [("--meta", "two.index.json"), ("--meta", "two.2.csv"), ("--write-parameters", "two.1.csv")]
)
def test_names_of_parts_are_nobody_elses(job: Path, run: Callable[..., Any], more: tuple[str, str]) -> None:
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv", *more).code == 2
    assert list(job.glob("two.*")) == [job / "two.nc"]


def test_neither_the_program_nor_a_folder_is_overwritten(job: Path, run: Callable[..., Any]) -> None:
    Path("x.1.nc").write_text(PROGRAM)
    assert run("convert", "x.1.nc", *PLACE, "--split-at-stops", "-o", "x.nc").code == 2
    assert Path("x.1.nc").read_text() == PROGRAM
    Path("two.2.csv").mkdir()
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv").code == 2
    assert not Path("two.1.csv").exists()


def test_the_shortest_dwell_is_no_stop(job: Path, run: Callable[..., Any]) -> None:
    Path("d.nc").write_text("G49 G0 X0 Y0 Z120 A0 C0\nG1 X5 F900\nG4 P0.000000001\nX9\nM2\n")
    assert run("convert", "d.nc", "--wcs", "G54=0,0,40", "--split-at-stops", "-o", "d.csv").code == 0
    assert [path.name for path in job.glob("d.*.csv")] == ["d.1.csv"]


def test_python_writes_the_parts_of_the_command(job: Path, run: Callable[..., Any]) -> None:
    words = ("two.nc", *PLACE, "--split-at-stops")
    assert run("convert", *words, "-o", "two.csv").code == 0
    tools = {1: vp.Tool(1, 1, (0, 0, 80, 0, 0, 0, 0, 0, 0), 10), 2: vp.Tool(2, 2, (0, 0, 95, 0, 0, 0, 0, 0, 0), 5)}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 40)}, split_at_stops=True)
    result = vp.convert(Path("two.nc"), "verne", options)
    rows = result.setpoints
    assert rows is not None
    for write in (rows.to_csv, lambda: rows.to_csv("all.csv")):
        with pytest.raises(vp.UsageError, match=r"stops 2 times for the operator; .* write each part of split\(\)"):
            write()
    assert not (job / "all.csv").exists()
    assert repr(rows).endswith(f"{len(rows)} rows in 3 parts")
    assert [part.to_csv() for part in rows.split()] == [(job / name).read_text("utf-8") for name in FILES]
    files, given = [Path(name) for name in FILES], (Path("two.nc"), "verne", options)
    whole_ones = (rows, rows.split(), files, Path("two.index.json"))
    assert [vp.verify(one, *given).text.partition(" passes: ")[2] for one in whole_ones].count("") == 0
    assert vp.verify(
        Path("two.index.json"), PROGRAM, "verne", options.changed(split_at_stops=False)
    )  # a text has no name that may differ
    for named, parts in (("setpoints", rows.split()), ("two.{}.csv", files)):
        for number, part in enumerate(parts, start=1):  # as the command says of a part alone, exit status 3
            alone = vp.verify(part, *given)
            assert (alone.ok, list(alone.findings)) == (False, [])
            assert alone.unchecked.startswith(f"{named.format(number)} is part {number} of 3. Alone, ")
            assert alone.text.endswith("Verify all parts together: give verify their index, or a list of them.")
    assert "if these are rows of one part" in vp.verify(files[1].read_bytes(), *given).text
    for wrong, said in ((files[:2], "2 parts, and the program has 2 stops"), (files[::-1], "two.3.csv: ends in line")):
        with pytest.raises(vp.InputError, match=said):
            vp.verify(wrong, *given)
    for none, said in (
        (Path("none.index.json"), "none.index.json: No such file"),
        (iter(files), "a list of them, bytes"),
    ):
        with pytest.raises(vp.UsageError, match=said):
            vp.verify(none, *given)  # type: ignore[arg-type]
    # a program that never stops is one part, the whole
    whole = vp.convert("G21 G90\nG0 X0 Y0 Z20 A0 C0\nX5\nM2\n", "verne", vp.Options(tool_length=80)).setpoints
    assert whole is not None
    assert [part.to_csv() for part in whole.split()] == [whole.to_csv()]


@pytest.mark.parametrize(
    ("name", "line", "said"),
    [
        ("part.mpf", "N250 T2 M6", "load tool 2 (line 6, N250)"),
        ("part.mpf", "T2 M6", "load tool 2 (line 6)"),
        ("part.h", "25 TOOL CALL 2 Z S8000", "load tool 2 (line 6, block 25)"),
    ],
)
def test_the_operator_reads_the_number_that_the_control_shows(
    name: str, line: str, said: str, run: Callable[..., Any], tmp_path: Path
) -> None:
    klartext = "BEGIN PGM A MM\nTOOL CALL 1 Z S8000\nL A+0 C+0 FMAX\nL X+0 Y+0 Z+60 FMAX\nL X+20 F900 M3\n{}\n"
    klartext += "L X+0 F900 M3\nEND PGM A MM\n"
    siemens = "G710 G90\nT1 M6\nG0 A=0 C=0\nG0 X0 Y0 Z60\nG1 X20 F900\n{}\nG1 X0\nM30\n"
    (tmp_path / name).write_text((klartext if name == "part.h" else siemens).format(line), encoding="utf-8")
    tools = "split_at_stops = true\n[tools]\n1 = { length = 80 }\n2 = { length = 80 }\n[wcs]\nG54 = [0, 0, 60]\n"
    (tmp_path / f"{name}.toml").write_text(tools, encoding="utf-8")
    answer = run("convert", tmp_path / name, "-o", tmp_path / "o.csv")
    assert answer.code == 0, answer.err
    assert said in " ".join(answer.err.split())


@pytest.mark.parametrize(
    ("between", "then"),
    [
        ("M5\nM0\nM3\n", [[6, 7, 8]]),
        ("M5\nG4 P.1\nM0\nM3\nG4 P.1\nM8\n", [[6, 8, 9, 11]]),  # dwells are no motion
        ("M5\nM0\nM3\nG4 P.1\nM8\nM0\nG4 P.1\nM9\n", [[6, 7, 8], [10, 11, 13]]),
        ("M5\nM0\nM60\n", [[6, 7, 8]]),
    ],
)
def test_every_event_at_a_stop_belongs_to_one_part(between: str, then: list[list[int]]) -> None:
    source = (
        "G21 G90 G0 X0 Y0 Z20 A0 C0\nM3 S900\nG4 P.1\nM8\nG1 X5 F900\n" + between + "G1 X9\nM9\nX12\nG4 P.1\nM5\nM2\n"
    )
    result = vp.convert(source, "verne", vp.Options(tool_length=80, split_at_stops=True, approach="home"))
    assert result.ok, result.findings
    assert result.summary is not None
    *parts, last = result.summary.parts
    assert [one.line for one in result.summary.before] == [2, 4]
    assert [[one.line for one in part.then] for part in parts] == then
    n = source.count("\n")
    assert [one.line for one in last.then] == [n - 1, n]


@pytest.mark.parametrize(
    ("keys", "value", "said"),
    [
        (("schema",), 2, "schema is 2; right is 1"),
        (("program",), "other.nc", 'program is "other.nc"; right is "two.nc"'),
        (("cycle_s",), 0.002, "cycle_s is 0.002; right is 0.001"),
        (("before",), [], "before is []; right is [{"),
        (("before", 0, "number"), 2, "before[0].number is 2; right is 1"),
        (("parts", 0, "rows"), None, "parts[0].rows is null; right is "),
        (("parts", 1, "duration_s"), 1.5, "parts[1].duration_s is 1.5; right is "),
        (("parts", 0, "then", 1, "number"), 1, "parts[0].then[1].number is 1; right is 2"),
        (("parts", 0, "then", 1, "number"), True, "parts[0].then[1].number is true; right is 2"),
        (("parts", 1, "then", 0, "line"), 17, "parts[1].then[0].line is 17; right is 18"),
        (("more",), 1, "more is no field of an index"),
    ],
)
def test_an_index_that_says_something_else_is_found_out(
    job: Path, run: Callable[..., Any], keys: tuple[Any, ...], value: object, said: str
) -> None:
    """Other names of the files, and another folder of the program, are no difference."""
    assert run("convert", "two.nc", *PLACE, "--split-at-stops", "-o", "two.csv").code == 0
    again = ("--against", job / "two.nc", *PLACE, "--split-at-stops")
    path = job / "two.index.json"
    index = json.loads(path.read_text())
    Path("two.1.csv").rename("first.csv")
    index["parts"][0]["file"] = "first.csv"
    path.write_text(json.dumps(index))
    assert run("verify", path, *again).code == 0
    place = index
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    path.write_text(json.dumps(index))
    answer = run("verify", path, *again)
    assert answer.code == 1
    assert answer.err.count(" VP414 error: ") == 1
    assert f"two.index.json is not what a conversion writes: {said}" in " ".join(answer.err.split())
    del place[keys[-1]]
    path.write_text(json.dumps(index))
    assert run("verify", path, *again).code == (0 if keys == ("more",) else 1)


OF_A_FILE = """G21 G90 G17 G94
T1 M6
S3000 M3
G54 G0 X0 Y0
G43 H1 Z60
G91 G28 Z0
G90 G0 G43 H1 Z60
M98 P2000
T2 M6
S900 M4
G0 X10 Y15
G43 H2 Z50
M98 P2000
G68.2 X0 Y0 Z0 I0 J0 K0
G53.1
G0 X20
G69
G53 Z-10
G49
M30
"""


def test_what_is_said_of_moves_by_their_numbers_is_said_of_the_same_moves_between_stops() -> None:
    tools = {n: Tool(n, n, (0.0, 0.0, 50.0 + n, *(0.0,) * 6), 4.0) for n in (1, 2)}
    files = {"2000": b"O2000\nG0 X1\nX2\nM0\nX3\nG1 X4 F300\nM99\n"}
    options = Options(tools=tools, dialect="fanuc", split_at_stops=True, subroutines=files)
    draft = read_draft(OF_A_FILE.encode(), vp.load_machine("ac_trunnion"), options)
    stopped = cut_at_stops(draft)
    assert len(stopped.stops) == 3

    def name_lines(moves: Moves) -> dict[str, Any]:
        kept = find_recorded(moves)
        own = moves.called_lines.number_moves(moves.line, np.arange(len(moves)))
        ahead = [*np.minimum.accumulate(np.where(kept, np.arange(len(own)), len(own))[::-1])[::-1].tolist(), len(own)]
        names = [*map(moves.called_lines.name_line, own.tolist()), "the end"]
        return {
            "moves": [name for name, is_kept in zip(names, kept, strict=False) if is_kept],
            "machine": [names[number] for number in moves.machine_moves],
            **{
                name: [names[ahead[one.before]] for one in getattr(moves, name)]
                for name in ("events", "calls", "planes")
            },
            **{name: [names[ahead[one]] for one in getattr(moves, name)] for name in ("tcp_changes", "feeds")},
            "speeds": [(line, names[ahead[number]]) for line, number in moves.speeds],
        }

    said = name_lines(draft.moves)
    assert said["machine"] == ["line 6", "line 6", "line 18"]
    assert said["moves"][4:8] == ["line 7", *(f"2000.ngc, line {line}" for line in (2, 3, 5))]
    assert name_lines(stopped.moves) == said
    numbers = [one.path.number_lines(np.arange(len(one.path))).tolist() for one in (draft, stopped)]
    assert numbers[0] == numbers[1]
