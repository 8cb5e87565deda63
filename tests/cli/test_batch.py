"""`batch`: the same results whoever computes them, nothing made twice, no failure that spreads."""

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from msgspec.structs import replace

import verne_post
from verne_post.app.called_files import find_callers
from verne_post.cli.files import RunFiles
from verne_post.cli.jobs import Job, Outcome, run_here, run_job
from verne_post.model.findings import make_finding
from verne_post.model.options import Options
from verne_post.model.verdict import find_exit_status
from verne_post.output.batch_table import format_batch
from verne_post.output.findings import format_outcome

GOOD = "G21 G90 G64\nG0 X0 Y0 Z{z} A0 C0\nG1 X{x} Y5 F3000\nG1 X5\nM2\n"
BEYOND = "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 Z680 F3000\nM2\n"
PLACE = ("--tool-length", 60, "--wcs", "G54=0,0,20")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Nine good programs, one that breaks a limit, one that cannot be read, one that is no text, and a remark."""
    monkeypatch.chdir(tmp_path)
    for number in range(9):
        path = Path("in") / ("sub" if number % 3 else "") / f"p{number}.nc"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(GOOD.format(z=50 + number, x=10 + number), encoding="utf-8")
    Path("in/far.nc").write_text(BEYOND, encoding="utf-8")
    Path("in/bad.ngc").write_text("G21 G90\nG1 X\nM2\n", encoding="utf-8")
    Path("in/picture.nc").write_bytes(b"\x89PNG\0\0")
    Path("in/readme.txt").write_text("no program", encoding="utf-8")
    return tmp_path


def contents(out: str) -> dict[str, bytes]:
    """Everything that was written, by name, but the records."""
    return {
        str(path.relative_to(out)): path.read_bytes()
        for path in Path(out).rglob("*")
        if path.is_file() and ".verne-post" not in path.parts
    }


def read_reports() -> tuple[str, str]:
    """JUnit, without what each program took, and SARIF."""
    return re.sub(r' time="[^"]*"', "", Path("j.xml").read_text()), Path("s.json").read_text()


def test_results_do_not_depend_on_who_made_them(folder: Path, run: Callable[..., Any]) -> None:
    told = ("--junit", "j.xml", "--sarif", "s.json", "--github")
    one = run("batch", "in", "-o", "one", "-j", 1, *told, *PLACE)
    reports = read_reports()
    assert one.code == 2  # the gravest of 0, 1, 2
    two = run("batch", "in", "-o", "two", "-j", 2, *told, *PLACE)
    assert two.code == 2
    assert read_reports() == tuple(text.replace("one/", "two/") for text in reports)
    assert one.out == two.out
    assert contents("one") == contents("two")
    names = {name for name in contents("one") if name.endswith(".csv")}
    assert names == {"p0.csv", "p3.csv", "p6.csv", *(f"sub/p{n}.csv" for n in (1, 2, 4, 5, 7, 8))}
    assert "12 programs: 9 can run, 3 refused" in one.out
    assert "VP101 line 3" in one.out
    # each is what convert writes
    assert run("convert", "in/sub/p4.nc", *PLACE).out.encode() == contents("one")["sub/p4.csv"]


def test_quiet_says_the_errors_and_nothing_else(folder: Path, run: Callable[..., Any]) -> None:
    """On standard error, as ``convert --quiet`` does; a batch that refuses nothing is silent."""
    far = run("convert", "in/far.nc", "-o", "far.csv", "--quiet", *PLACE)
    done = run("batch", "in/far.nc", "in/p0.nc", "-o", "out", "--quiet", *PLACE)
    assert (done.code, done.out) == (1, "")
    assert "in/far.nc:3: VP101 error" in done.err
    assert far.err.startswith(done.err) and "p0" not in done.err
    done = run("batch", "in/p0.nc", "-o", "out", "--quiet", *PLACE)
    assert (done.code, done.out, done.err) == (0, "", "")


def test_nothing_is_made_twice(folder: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    run("batch", "in", "-o", "out", "-j", 1, *PLACE)
    before = {path: path.stat().st_mtime_ns for path in Path("out").rglob("*.csv")}
    again = run("batch", "in", "-o", "out", "-j", 1, *PLACE)
    assert "9 can run (as before)" in again.out
    assert {path: path.stat().st_mtime_ns for path in Path("out").rglob("*.csv")} == before
    # one program, one lost file, one spoilt file: those three and no others
    Path("in/p0.nc").write_text(GOOD.format(z=70, x=3), encoding="utf-8")
    Path("out/p3.csv").unlink()
    Path("out/sub/p4.csv").write_text("spoilt", encoding="utf-8")
    third = run("batch", "in", "-o", "out", "-j", 1, *PLACE)
    assert "6 can run (as before)" in third.out
    assert "3 can run" in third.out
    assert contents("out")["sub/p4.csv"] == run("convert", "in/sub/p4.nc", *PLACE).out.encode()
    # other options: everything
    assert "9 can run" in run("batch", "in", "-o", "out", "-j", 1, *PLACE, "--override", 0.5).out


#: A program that was good, and is not any more: by its limits, its words, its bytes, or because it cannot be opened.
SPOILT = {
    "limits": BEYOND.encode(),
    "words": b"G1 X\n",
    "no text": b"\x89PNG\0\0",
    "setpoints": b"t_s,rho1_mm\n",
    "a dead link": None,
}


def spoil(how: str, path: Path = Path("in/p0.nc")) -> None:
    path.unlink()
    text = SPOILT[how]
    if text is None:
        path.symlink_to("nowhere")
    else:
        path.write_bytes(text)


@pytest.mark.parametrize("how", SPOILT)
def test_rows_of_a_program_that_is_refused_now_do_not_stay(folder: Path, run: Callable[..., Any], how: str) -> None:
    words = ("batch", "in/p0.nc", "in/p3.nc", "-o", "out", "-j", 1, *PLACE)
    assert run(*words).code == 0
    spoil(how)
    for _again in range(2):
        answer = run(*words)
        assert answer.code == (1 if how == "limits" else 2)
        assert "not removed" not in answer.err
        assert set(contents("out")) == {"batch.json", "p3.csv", "p3.csv.meta.json"}


@pytest.mark.parametrize("how", SPOILT)
def test_what_batch_did_not_make_stays_and_is_named(folder: Path, run: Callable[..., Any], how: str) -> None:
    words = ("batch", "in/p0.nc", "-o", "out", "-j", 1, *PLACE)
    assert run(*words).code == 0
    Path("out/p0.csv").write_text("of somebody else")
    spoil(how)
    for _again in range(2):
        answer = run(*words)
        assert answer.code == (1 if how == "limits" else 2)
        assert contents("out")["p0.csv"] == b"of somebody else"
        assert "out/p0.csv: not removed: batch did not make this file, or it was changed since" in answer.err
        assert "meta.json" not in answer.err
        assert not Path("out/p0.csv.meta.json").exists()


def test_parts_that_are_not_made_any_more_go(folder: Path, run: Callable[..., Any]) -> None:
    stops = "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F3000\nM0\nG1 X6\nM0\nG1 X7\nM2\n"
    words = ("batch", "in/s.nc", "-o", "out", "-j", 1, *PLACE, "--split-at-stops")
    Path("in/s.nc").write_text(stops)
    assert run(*words).code == 0
    names = {"batch.json", "s.csv.meta.json", "s.index.json", "s.1.csv", "s.2.csv", "s.3.csv"}
    assert set(contents("out")) == names
    assert "1 can run (as before)" in run(*words).out
    Path("in/s.nc").write_text(stops.replace("M0\n", "", 1))
    Path("out/s.2.csv").write_text("changed")  # it is made anew, the third goes
    answer = run(*words)
    assert "not removed" not in answer.err
    assert set(contents("out")) == names - {"s.3.csv"}
    for name in ("s.3.csv", "s.1.csv.bak", "s.x.csv", "t.1.csv"):
        Path("out", name).write_text("of somebody else")
    assert run(*words).err.count("not removed") == run(*words).err.count("out/s.3.csv: not removed: ") == 1
    Path("in/s.nc").write_text("G1 X\n")
    Path("out/s.1.csv").write_text("of somebody else")
    answer = run(*words)
    assert (answer.code, answer.err.count("not removed")) == (2, 2)
    assert all(f"out/{name}: not removed: " in answer.err for name in ("s.1.csv", "s.3.csv"))
    assert set(contents("out")) == {"batch.json", "s.3.csv", "s.1.csv", "s.1.csv.bak", "s.x.csv", "t.1.csv"}


def test_rows_of_another_program_are_no_unknown_part(folder: Path, run: Callable[..., Any]) -> None:
    """p0.1.nc alone has the name of a part of p0.nc, and a record of its own."""
    shutil.copy("in/p0.nc", "in/p0.1.nc")
    assert run("batch", "in/p0.1.nc", "-o", "out", "-j", 1, *PLACE).code == 0
    answer = run("batch", "in/p0.nc", "-o", "out", "-j", 1, *PLACE, "--split-at-stops")
    assert (answer.code, "not removed" in answer.err) == (0, False)


def test_rows_keep_no_other_name_where_a_neighbour_has_gone(folder: Path, run: Callable[..., Any]) -> None:
    """part.nc beside part.ngc had part.nc.csv. The rows of part.ngc, which is gone, are named."""
    words = ("batch", "in", "-o", "out", "-j", 1, *PLACE)
    shutil.copy("in/p0.nc", "in/p0.ngc")
    assert "left over" not in run(*words).err
    assert {"p0.nc.csv", "p0.ngc.csv"} <= set(contents("out"))
    Path("in/p0.ngc").unlink()
    answer = run(*words)
    assert "out/p0.ngc.csv: left over from an earlier run: in/p0.ngc is not there any more" in answer.err
    assert "p0.nc.csv" not in answer.err
    names = {"p0.csv", "p0.csv.meta.json", "p0.ngc.csv", "p0.ngc.csv.meta.json"}
    assert {name for name in contents("out") if "p0" in name} == names
    Path("in/p0.nc").write_text("G1 X\n")
    run(*words)
    assert {name for name in contents("out") if "p0" in name} == {"p0.ngc.csv", "p0.ngc.csv.meta.json"}
    Path("out/p0.ngc.csv").write_text("of somebody else")
    Path("out/p0.ngc.csv.meta.json").unlink()
    assert "left over" not in run(*words).err
    assert "left over" not in run("batch", "in/p1.nc", "-o", "out", "-j", 1, *PLACE).err  # the others are still there


def test_records_hold_in_whatever_folder_one_is(
    folder: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A record that named files from the current folder would remove those of another one."""
    run("batch", "in/p0.nc", "-o", "out", "-j", 1, *PLACE)
    Path("other/out").mkdir(parents=True)
    for name in ("p0.csv", "p0.csv.meta.json"):
        Path("other/out", name).write_bytes(Path("out", name).read_bytes())  # not even the content tells them apart
    Path("in/p0.nc").write_text("G1 X\n", encoding="utf-8")
    monkeypatch.chdir("other")
    assert run("batch", "../in/p0.nc", "-o", "../out", "-j", 1, *PLACE).code == 2
    assert set(contents("out")) == {"p0.csv", "p0.csv.meta.json"}
    assert set(contents("../out")) == {"batch.json"}


FOREIGN = (
    "{folder}/precious.csv",
    "../precious.csv",
    "sub/../../precious.csv",
    "p3.csv",
    "batch.json",
    "link.csv",
    "p0.7.csv",
)


@pytest.mark.parametrize("name", FOREIGN)
@pytest.mark.parametrize("program", [GOOD.format(z=60, x=8), "G1 X\n"], ids=["good", "unusable"])
def test_a_record_removes_nothing_but_what_batch_made_of_its_program(
    folder: Path, run: Callable[..., Any], name: str, program: str
) -> None:
    words = ("batch", "in/p0.nc", "in/p3.nc", "-o", "out", "-j", 1, *PLACE)
    assert run(*words).code == 0
    Path("precious.csv").write_text("precious")
    Path("out/sub").mkdir()
    Path("out/link.csv").symlink_to("../precious.csv")
    Path("out/p0.7.csv").symlink_to("../precious.csv")  # a name that a part could have
    record = Path("out/.verne-post/p0.csv.json")
    data = json.loads(record.read_text())
    name = name.format(folder=folder)
    data["files"][name] = hashlib.sha256(Path("out", name).read_bytes()).hexdigest()
    record.write_text(json.dumps(data))
    Path("in/p0.nc").write_text(program)
    answer = run(*words)
    assert answer.code == (0 if program.startswith("G21") else 2)
    assert Path("precious.csv").read_text() == "precious"
    assert {"p3.csv", "p3.csv.meta.json", "batch.json", "link.csv", "p0.7.csv"} <= set(contents("out"))
    if program.startswith("G21"):
        assert contents("out")["p0.csv"] == run("convert", "in/p0.nc", *PLACE).out.encode()
    else:
        assert "p0.csv: not removed" in answer.err or not Path("out/p0.csv").exists()


MALFORMED: dict[str, Callable[[dict[str, Any]], object]] = {
    "a list": lambda data: [data],
    "null": lambda data: None,
    "another layout": lambda data: {**data, "layout": 1},
    "files as a list": lambda data: {**data, "files": list(data["files"])},
    "a digest that is no text": lambda data: {**data, "files": dict.fromkeys(data["files"], 1)},
    "no files": lambda data: {**data, "files": {}},
    "a zero byte": lambda data: {**data, "files": {**data["files"], "p\0.csv": ""}},
    "no outcome": lambda data: {key: value for key, value in data.items() if key != "outcome"},
    "an outcome of words": lambda data: {**data, "outcome": {**data["outcome"], "status": "0"}},
    "an endless time": lambda data: {**data, "outcome": {**data["outcome"], "cycle_time_s": float("inf")}},
    "a finding of numbers": lambda data: {**data, "outcome": {**data["outcome"], "findings": [1]}},
}


@pytest.mark.parametrize("how", [*MALFORMED, "no JSON", "no UTF-8", "nested without end", "cut off"])
def test_a_malformed_record_is_none(folder: Path, run: Callable[..., Any], how: str) -> None:
    words = ("batch", "in/p0.nc", "-o", "out", "-j", 1, "--junit", "j.xml", *PLACE)
    assert run(*words).code == 0
    before, record = contents("out"), Path("out/.verne-post/p0.csv.json")
    good = record.read_bytes()
    raw = {"no JSON": b"{", "no UTF-8": b"\xff", "nested without end": b"[" * 100_000, "cut off": good[:-20]}
    record.write_bytes(raw[how] if how in raw else json.dumps(MALFORMED[how](json.loads(good))).encode())
    answer = run(*words)
    assert answer.code == 0, answer.err
    assert "1 can run" in answer.out
    assert contents("out") == before
    assert record.read_bytes() == good


def test_a_record_of_other_code_is_none(folder: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Two revisions of a repository may have one version."""
    words = ("batch", "in/p0.nc", "-o", "out", "-j", 1, *PLACE)
    assert "as before" not in run(*words).out
    assert "as before" in run(*words).out
    monkeypatch.setattr("verne_post.cli.jobs._compute_code_digest", lambda: "other")
    assert "as before" not in run(*words).out


@pytest.mark.parametrize("placed", [0, 1])
@pytest.mark.parametrize("then", ["the same", "changed", "refused", "unusable"])
def test_killed_between_the_record_and_its_files(
    folder: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, placed: int, then: str
) -> None:
    """Rows without their metadata file, or none: never taken as current, nor left beside a refused program."""
    words = ("batch", "in/p0.nc", "-o", "out", "-j", 1, *PLACE)
    assert run(*words).code == 0
    Path("in/p0.nc").write_text(GOOD.format(z=70, x=3), encoding="utf-8")
    done, place = [], RunFiles.place

    def killed(self: RunFiles, made: Path, path: Path, what: str) -> None:
        if path.parent == Path("out") and path.suffix in (".csv", ".json"):
            if len(done) == placed:
                raise KeyboardInterrupt
            done.append(path)
        place(self, made, path, what)

    monkeypatch.setattr(RunFiles, "place", killed)
    assert run(*words).code == 130
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    assert set(contents("out")) - {"batch.json"} == {"p0.csv"} if placed else {"batch.json"}
    if then != "the same":
        text = {"changed": GOOD.format(z=71, x=4), "refused": BEYOND, "unusable": "G1 X\n"}[then]
        Path("in/p0.nc").write_text(text, encoding="utf-8")
    answer = run(*words)
    assert "as before" not in answer.out
    assert "not removed" not in answer.err
    if then in ("refused", "unusable"):
        assert set(contents("out")) == {"batch.json"}
    else:
        assert contents("out")["p0.csv"] == run("convert", "in/p0.nc", *PLACE).out.encode()


@pytest.mark.parametrize("link", ["out/sub", "out/p0.csv", "out/p3.csv.meta.json", "out/.verne-post"])
def test_nothing_is_written_outside_the_folder(folder: Path, run: Callable[..., Any], link: str) -> None:
    Path("out").mkdir()
    Path("elsewhere/sub").mkdir(parents=True)
    Path(link).symlink_to(folder / "elsewhere" / ("new" if "csv" in link else ""))
    answer = run("batch", "in", "-o", "out", "-j", 1, *PLACE)
    assert answer.code == 2
    assert "a symbolic link inside out leads to it" in answer.err
    assert contents("elsewhere") == contents("out") == {}
    # the folder itself may be a link
    Path("linked").symlink_to("elsewhere")
    assert run("batch", "in/p0.nc", "-o", "linked", "-j", 1, *PLACE).code == 0
    assert "1 can run (as before)" in run("batch", "in/p0.nc", "-o", "linked", "-j", 1, *PLACE).out


def test_parts_follow_no_link_either(folder: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    Path("in/s.nc").write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F3000\nM0\nG1 X6\nM2\n")
    Path("out").mkdir()
    Path("precious").write_text("precious")
    Path("out/s.2.csv").symlink_to("../precious")
    answer = run("batch", "in/s.nc", "-o", "out", "-j", 1, *PLACE, "--split-at-stops")
    assert answer.code == 2
    assert "out/s.2.csv: a symbolic link inside out leads to it" in answer.err
    assert Path("precious").read_text() == "precious"
    assert not Path("out/s.1.csv").exists()


def test_programs_beside_their_rows(folder: Path, run: Callable[..., Any]) -> None:
    Path("in/p9.csv").write_text(GOOD.format(z=50, x=1))
    before = contents("in")
    answer = run("batch", "in/p9.csv", "in/p0.nc", "-o", "in", "-j", 1, *PLACE)
    assert answer.code == 2
    assert "in/p9.csv (the rows of in/p9.csv): this is the file of program in/p9.csv" in answer.err
    assert contents("in") == before
    assert run("batch", "in/p0.nc", "-o", "in", "-j", 1, *PLACE).code == 0
    assert set(contents("in")) - set(before) == {"p0.csv", "p0.csv.meta.json", "batch.json"}


def test_findings_of_the_whole_batch(folder: Path, run: Callable[..., Any]) -> None:
    answer = run("batch", "in", "-o", "out", "-j", 1, "--junit", "j.xml", "--sarif", "s.json", "--github", *PLACE)
    said = answer.out
    suite = ElementTree.parse("j.xml").getroot()
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("12", "1", "2")
    listed = json.loads(Path("out/batch.json").read_text())["programs"]
    times = {
        case.get("name"): float(one.get("value", "nan"))
        for case in suite.iter("testcase")
        for one in case.iter("property")
        if one.get("name") == "machining_time_s"
    }
    assert times == pytest.approx({one["program"]: one["cycle_time_s"] for one in listed if one["rows"]}, abs=5e-4)
    assert len(times) == 9
    # what it took, at least a millisecond where rows were made
    taken = {case.get("name"): float(case.get("time", "nan")) for case in suite.iter("testcase")}
    assert all(taken[name] > 0 for name in times)
    refused = {one["program"] for one in listed if one["status"]}
    assert {line.split("file=")[1].split(",")[0] for line in said.splitlines() if " file=" in line} == refused
    counted = re.findall("NOT CHECKED in .* programs", said + answer.err + Path("s.json").read_text())
    assert len(counted) >= 3
    assert len({*counted}) == 1
    results = json.loads(Path("s.json").read_text())["runs"][0]["results"]
    found = {(one["ruleId"], one["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]) for one in results}
    assert ("VP101", "in/far.nc") in found
    assert ("VP001", "in/bad.ngc") in found

    # findings that are known from last time are the same
    first = read_reports()
    run("batch", "in", "-o", "out", "-j", 1, "--junit", "j.xml", "--sarif", "s.json", *PLACE)
    assert read_reports() == first


def test_a_warning_about_a_set_up_stands_at_its_line_there(folder: Path, run: Callable[..., Any]) -> None:
    """It had the file of the program and no line, in each format; the set-up of the program before has other tools."""
    shutil.rmtree(folder / "in")
    Path("in").mkdir()
    for name, tool in (("a", 8), ("b", 9)):
        Path(f"in/{name}.nc").write_text("T1 M6\nG43 H1\n" + GOOD.format(z=50, x=10))
        Path(f"in/{name}.nc.toml").write_text(
            f"[wcs]\nG54 = [0, 0, 20]\n[tools.{tool}]\nlength = 80\n[tools.1]\nlength = 60\n"
        )
    for line in (3, 4):  # the second time the rows are known, and a comment has moved the lines of one set-up
        answer = run("batch", "in", "-o", "out", "-j", 1, "--sarif", "s.json", "--github")
        assert f"file=in/b.nc.toml,line={line},col=1,title=VP041" in answer.out
        assert "in/a.nc.toml:3:1: VP041 warning: tools.8 of" in answer.err
        results = json.loads(Path("s.json").read_text())["runs"][0]["results"]
        places = [one["locations"][0]["physicalLocation"] for one in results if one["ruleId"] == "VP041"]
        assert [(one["artifactLocation"]["uri"], one["region"]["startLine"]) for one in places] == [
            ("in/a.nc.toml", 3),
            ("in/b.nc.toml", line),
        ]
        Path("in/b.nc.toml").write_text("# lengths in mm\n" + Path("in/b.nc.toml").read_text())
    assert "(as before)" in run("batch", "in", "-o", "out", "-j", 1).out


def test_a_folder_names_what_may_be_a_program_by_its_text(tmp_path: Path, run: Callable[..., Any]) -> None:
    """O1001, as machines store it, was passed over without a word where other programs were beside it."""
    (tmp_path / "p").mkdir()
    others = {
        "O1001": "%\nO1001\nM30\n%\n",
        "a.eia": "O7(A)\nM30\n",
        "b.txt": "0 BEGIN PGM B MM\n",
        "c.txt": "(PART; A)\n; 3 MM\nN10 T1 M6\nN20 G90 G54 X-1. Y.5\nM8\n#1=2\n",
    }
    none = {
        "readme.txt": "Of the parts: 5% more\n",
        "LICENSE": "",
        "codes.txt": "G54 is the zero\nG1 X5\n",
        "mill.tbl": "T1 P1 Z80 D6\nT2 P2 Z70 D8 ;G1\n",
        "parts.csv": "O,1\n",
    }
    calls = {"a.mpf": "G90 G0 X0 Y0 Z50\nUP\nM30\n", "UP.SPF": "G1 X1 F900\nX2\nX3\nRET\n"}
    for name, text in {**calls, **others, **none}.items():
        (tmp_path / "p" / name).write_text(text)
    said = f"not checked: {', '.join(str(tmp_path / 'p' / name) for name in others)}: "
    place = ("--tool-length", "80", "--wcs", "G54=0,0,60")
    answer = run("check", tmp_path / "p", *place)
    assert said in answer.out + answer.err
    answer = run("batch", tmp_path / "p", "-o", tmp_path / "out", "-j", 1, *place)
    assert said.replace("checked", "converted") in answer.err
    for given in ((tmp_path / "p" / "a.mpf",), (tmp_path / "p", "--quiet")):
        answer = run("check", *given, *place)
        assert "not checked:" not in answer.out + answer.err
    for name in calls:
        (tmp_path / "p" / name).unlink()
    for words in (("check",), ("batch", "-o", tmp_path / "new")):
        answer = run(*words, tmp_path / "p", *place)
        assert answer.code == 2
        assert f"; not taken: {said.removeprefix('not checked: ')}" in answer.err


def test_hidden_folders_are_not_searched(folder: Path, run: Callable[..., Any]) -> None:
    """A virtual environment has C headers, which end as Klartext does; what is named by itself is read."""
    for name in (".all/.venv/numpy.h", ".all/sub/.cache/deep/a.nc"):
        Path(name).parent.mkdir(parents=True)
        Path(name).write_text("#include <numpy.h>\n")
    for words in (("check", ".all"), ("batch", ".all", "-o", "out")):
        answer = run(*words)
        assert answer.code == 2
        assert "no programs in .all; looked for .nc, " in answer.err
        assert "but not in hidden folders" in answer.err
    shutil.copy("in/p0.nc", ".all/sub/p0.nc")
    assert ".all/sub/p0.nc: can run" in run("check", ".all", *PLACE).out
    assert "1 program: 1 can run" in run("batch", ".all", "-o", "out", "-j", 1, *PLACE).out
    assert run("check", ".all/.venv", *PLACE).code == 2
    assert run("check", ".all/.venv", *PLACE).out.startswith(".all/.venv/numpy.h")


@pytest.mark.parametrize("command", [("check", "--output-format", "github"), ("batch", "-o", "out", "--github")])
def test_an_empty_folder_is_told_in_every_report(
    folder: Path, run: Callable[..., Any], command: tuple[str, ...]
) -> None:
    """A workflow shows why there was nothing to check, and no report of that replaces a program that was found."""
    Path("empty").mkdir()
    answer = run(*command, "empty", "none*.nc", "--junit", "j.xml")
    assert answer.code == 2
    assert answer.out.startswith("::error title=verne-post::no programs in empty; looked for .nc, ")
    assert answer.out.endswith("; none*.nc: no such file\n")
    assert "no programs in empty" in ElementTree.parse("j.xml").find("testsuite/testcase/error").text
    before = Path("in/p0.nc").read_bytes()
    answer = run(*command, "empty", "in", "--junit", "in/p0.nc")
    assert answer.code == 2
    assert "choose another name" in answer.err
    assert Path("in/p0.nc").read_bytes() == before


#: A program and a file that it calls, which is no program: Siemens, LinuxCNC, Klartext, Fanuc.
CALLS = {
    "siemens": ("T.MPF", "G90 G0 X0 Y0 Z50\nUP(4)\nM30\n", "UP.MPF", "PROC UP(REAL W)\nG1 X=W F900\nRET\n"),
    "linuxcnc": ("t.ngc", "G0 X0 Y0 Z50\no<up> call [4]\nM2\n", "up.ngc", "o<up> sub\nG1 X#1 F900\no<up> endsub\n"),
    "klartext": (
        "T.H",
        "L X+0 Y+0 Z+50 R0 FMAX\nCALL PGM UP\nM30\n",
        "UP.H",
        "BEGIN PGM UP MM\nL X+4 F900\nEND PGM UP MM\n",
    ),
    "fanuc": ("O1.nc", "O1\nG0 X0 Y0 Z50\nM98 P20\nM30\n", "O20.nc", "O20\nG1 X4. F900\nM99\n"),
}


@pytest.mark.parametrize("language", CALLS)
def test_a_file_that_only_a_program_of_the_run_calls_is_checked_there(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, language: str
) -> None:
    """Alone it lacked its parameters, its tool or its end, and failed the check of a folder that is right."""
    monkeypatch.chdir(tmp_path)
    main, text, name, called = CALLS[language]
    Path("p").mkdir()
    Path("p", main).write_text(text)
    Path("p", name).write_text(called)
    note = f"not checked alone: {Path('p', name)}, called by {Path('p', main)}\n"
    place = ("--tool-length", "100", "--wcs", "G54=0,0,20")
    answer = run("check", "p", *place, "--markdown", "m.md")
    assert (answer.code, answer.out.endswith(note), "1 can run" in Path("m.md").read_text()) == (0, True, True)
    (record,) = json.loads(run("check", "p/*", *place, "--output-format", "json").out)["programs"]
    assert (record["program"], record["called"]) == (str(Path("p", main)), [str(Path("p", name))])
    answer = run("batch", "p", "-o", "o", *place, "-j", 1)
    assert (answer.code, note in answer.err, "1 program" in answer.out) == (0, True, True), answer.err
    shares = [run("batch", "p", "-o", f"o{k}", *place, "-j", 1, "--shard", f"{k}/2") for k in (1, 2)]
    assert [(one.code, note in one.err) for one in shares] == [(0, True), (0, False)], shares
    assert name not in run("check", "p", "--quiet", *place).out
    # named, with a set-up of its own, or with the end of a program, it is one
    assert f"{Path('p', name)}: refused" in run("check", "p", Path("p", name)).out
    Path("p", main).write_text(
        text.replace("UP(4)", "").replace("o<up> call [4]", "").replace("CALL PGM UP", "").replace("M98 P20", "")
    )
    assert "not checked alone" not in run("check", "p", *place).out
    Path("p", main).write_text(text)
    Path("p", f"{name}.toml").write_text("")
    assert "not checked alone" not in run("check", "p", *place).out


@pytest.mark.parametrize(
    ("line", "code", "said"),
    [
        ("o<up> call [4]", 0, "not checked alone: p/up.ngc, called by p/b.ngc\n"),
        (
            "o1 if [Q]\no<up> call [4]\no1 endif",
            2,
            "undecided: whether p/b.ngc calls p/up.ngc; correct p/b.ngc first\n",
        ),
        ("X1", 2, "refused"),
    ],
)
def test_a_subprogram_whose_first_caller_never_comes_to_its_call_may_be_called_in_another_share(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, line: str, code: int, said: str
) -> None:
    """It was refused alone in the share of that caller, though the whole run was right."""
    monkeypatch.chdir(tmp_path)
    Path("p").mkdir()
    Path("p", "a.ngc").write_text("G0 X0 Y0 Z50\no1 if [0]\no<up> call [4]\no1 endif\nX9\nM2\n")
    Path("p", "b.ngc").write_text(f"G0 X0 Y0 Z50\n{line}\nM2\n")
    Path("p", "up.ngc").write_text("o<up> sub\nG1 X#1 F900\no<up> endsub\n")
    place = ("--tool-length", "100", "--wcs", "G54=0,0,20", "-j", 1)
    whole = run("batch", "p", "-o", "o", *place)
    first = run("batch", "p", "-o", "o1", *place, "--shard", "1/2")
    assert (whole.code, first.code) == (code, code), first.err
    assert said in (first.out + first.err).replace(os.sep, "/")
    assert "b.ngc" not in first.out


HEAD = "L X+0 Y+0 Z+50 R0 FMAX\n"
FAR_UP = "BEGIN PGM UP MM\nL X+4000 F900\nEND PGM UP MM\n"


@pytest.mark.parametrize(
    ("files", "refused"),
    [
        (
            {"O1.nc": "O1\nG0 X0 Y0 Z50\nM98 P20\nM30\nO20\nG1 X5. F900\nM99\n", "O20.nc": "O20\nX4000.\nM99\n"},
            "O20.nc",
        ),
        ({"O1.nc": "O1\nG0 X0 Y0 Z50\nGOTO 9\nM98 P20\nN9 M30\n", "O20.nc": "O20\nX4000.\nM99\n"}, "O20.nc"),
        (
            {"t.ngc": "G0 X0 Y0 Z50\no1 if [0]\no<up> call\no1 endif\nM2\n", "up.ngc": "o<up> sub\nX4\no<up> endsub\n"},
            "up.ngc",
        ),
        # an error in the line that jumps, or that sets what it asks, hides whether the call is executed; a corrected
        # M3O and 1==l do not lead to it
        ({"O1.nc": "O1\nG0 X0 Y0 Z50\nGOTO 9O\nM98 P20\nN90 M30\n", "O20.nc": "O20\nX4000.\nM99\n"}, "O20.nc"),
        (
            {"O1.nc": "O1\n#1=9O\nIF [#1 EQ 9] GOTO 90\nM98 P20\nN90 M30\n", "O20.nc": "O20\nX4000.\nM99\n"},
            "O20.nc",
        ),
        ({"O1.nc": "O1\nG0 X0 Y0 Z50\nM3O\nM98 P20\nM30\n", "O20.nc": "O20\nX4000.\nM99\n"}, "O20.nc"),
        (
            {"t.ngc": "G0 X0 Y0 Z50\no1 if [O]\no<up> call\no1 endif\nM2\n", "up.ngc": "o<up> sub\nX4\no<up> endsub\n"},
            "up.ngc",
        ),
        (
            {"A.MPF": "G90 G0 X0 Y0 Z50\nIF 1==l GOTOF E\nUP\nE: M30\n", "UP.MPF": "PROC UP\nG1 X4000 F900\nRET\n"},
            "UP.MPF",
        ),
        ({"T.H": f"{HEAD}FN 9: IF +1 EQU +l GOTO LBL 9\nCALL PGM UP\nLBL 9\nM30\n", "UP.H": FAR_UP}, "UP.H"),
        ({"A.MPF": "G90 G0 X0 Y0 Z50\nT1 D1\nM6\nM30\n", "T1.MPF": "PROC T1\nG1 X4000 F900\nRET\n"}, "T1.MPF"),
        ({"T.H": f"{HEAD}M30\nCALL PGM UP\n", "UP.H": FAR_UP}, "UP.H"),
        (
            {
                "T.H": f"{HEAD}CALL PGM UP\nM30\n",
                "UP.H": FAR_UP.replace("4000", "4"),
                "verne-post.toml": '[setup."UP.H".wcs]\nG54 = [0, 0, 20]\n',
            },
            "UP.H",
        ),
    ],
)
def test_a_file_that_no_program_of_the_run_executes_is_checked(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, files: dict[str, str], refused: str
) -> None:
    """A program has its name, or jumps over the call; or the file can run alone, or has a set-up of its own."""
    monkeypatch.chdir(tmp_path)
    for name, text in files.items():
        Path(name).write_text(text)
    answer = run("check", ".", "--tool-length", "100", "--wcs", "G54=0,0,20")
    assert answer.code in (1, 2)
    assert f"{refused}: refused" in answer.out, answer.out
    assert "not checked alone" not in answer.out
    main, *_others = files
    hint = f"undecided: whether {main} calls {refused}; correct {main} first\n"
    assert (hint in answer.out) == any(slip in files[main] for slip in ("GOTO 9O", "#1=9O", "[O]", "+l"))
    if hint in answer.out:
        batch = run("batch", ".", "-o", "out", "-j", 1, "--tool-length", "100", "--wcs", "G54=0,0,20")
        assert hint in batch.err


@pytest.mark.parametrize("language", CALLS)
@pytest.mark.parametrize("place", [(), ("--tool-length", "100", "--wcs", "G54=0,0,20")], ids=["no set-up", "a slip"])
def test_a_file_that_a_refused_program_executes_is_not_refused_alone(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, language: str, place: tuple[str, ...]
) -> None:
    """Errors of the subprogram alone followed those of the program."""
    monkeypatch.chdir(tmp_path)
    main, text, name, called = CALLS[language]
    Path(main).write_text(text.replace("50", "5O") if place else text)
    Path(name).write_text(called)
    answer = run("check", ".", *place)
    assert answer.code in (1, 2)
    assert f"not checked alone: {name}, called by {main}" in answer.out, answer.out


@pytest.mark.parametrize(
    ("options", "text", "code"),
    [
        ((), "L X+4000 F900\n", 1),
        (("--fail-level", "warning"), "", 1),
        (("--fail-level", "warning", "--ignore", "VP050"), "", 0),
    ],
)
def test_a_refused_klartext_program_without_m30_covers_what_it_calls(
    tmp_path: Path,
    run: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    text: str,
    code: int,
) -> None:
    """It looks like a subprogram, and nothing calls it; findings that do not count refuse nothing."""
    monkeypatch.chdir(tmp_path)
    called = f"CALL PGM UP\n{text}L Z+60 FMAX\nEND PGM T MM\n"
    Path("T.H").write_text(f"BEGIN PGM T MM\nTOOL CALL 1 Z S1000\n{HEAD}{called}")
    Path("UP.H").write_text("BEGIN PGM UP MM\nL X+4 F900\nEND PGM UP MM\n")
    answer = run("check", ".", "--tool-length", "100", "--wcs", "G54=0,0,20", *options)
    assert answer.code == code, answer.out
    assert "not checked alone: UP.H, called by T.H" in answer.out.splitlines()


def test_links_to_a_called_file_are_checked_there(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    main, text, name, called = CALLS["fanuc"]
    Path(main).write_text(text)
    Path(name).write_text(called)
    Path("T20.nc").symlink_to(name)
    answer = run("check", ".", "--tool-length", "100", "--wcs", "G54=0,0,20")
    assert (answer.code, answer.out.splitlines()[-1]) == (0, f"not checked alone: {name}, T20.nc, called by {main}")


def test_files_that_only_call_each_other_are_checked(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for one, other in (("A", "B"), ("B", "A")):
        Path(f"{one}.H").write_text(f"BEGIN PGM {one} MM\nCALL PGM {other}\nEND PGM {one} MM\n")
    answer = run("check", ".")
    assert (answer.code, answer.out.count("refused"), "not checked" in answer.out) == (2, 3, False)


@pytest.mark.skipif(not shutil.which("git"), reason="needs git")
def test_a_called_file_that_has_changed_is_checked_by_its_callers(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    main, text, name, called = CALLS["klartext"]
    Path(main).write_text(text)
    Path(name).write_text(called)
    subprocess.run(["git", "init", "-q"], check=True)
    subprocess.run(["git", "add", "."], check=True)
    answer = run("check", "--changed", name, "--tool-length", "100", "--wcs", "G54=0,0,20")
    assert (answer.code, f"{main}: can run" in answer.out, f"{name}: " in answer.out) == (0, True, False), answer.out


def test_an_empty_folder_does_not_stop_the_programs_beside_it(folder: Path, run: Callable[..., Any]) -> None:
    """A job that names a folder before it is filled still tells of all the others, and has the gravest status."""
    Path("empty").mkdir()
    lacking = (
        "empty: VP022 error: is a folder without programs; looked for .nc, ",
        "none*.nc: VP022 error: no such file",
    )
    checked = run("check", "empty", "none*.nc", "in/p0.nc", *PLACE)
    batch = run("batch", "empty", "none*.nc", "in/p0.nc", "-o", "out", "-j", 1, *PLACE)
    assert all(text in checked.out and text in batch.err for text in lacking)
    assert "in/p0.nc: can run on VERNE" in checked.out
    assert "3 programs: 1 can run, 2 not read" in checked.out
    assert Path("out/p0.csv").exists()
    assert checked.code == batch.code == 2
    assert "empty: VP022 error: is a folder without programs" in run("convert", "empty", *PLACE).err


@pytest.mark.parametrize(
    ("code", "word"),
    [
        ("VP001", "refused"),
        ("VP101", "refused"),
        ("VP502", "refused"),
        ("VP420", "no verdict"),
        ("VP902", "internal error"),
    ],
)
def test_check_and_batch_have_one_word_for_a_result(code: str, word: str) -> None:
    found = (make_finding(code, "text", severity="error"),)
    assert format_outcome("a.nc", found) == f"a.nc: {word}: 1 error, 0 warnings"
    table = format_batch([Outcome("a.nc", int(find_exit_status(found)), found)]).splitlines()
    assert table[1].startswith(f"a.nc     {word} ")
    assert table[2] == f"1 program: 1 {word}"


def test_a_table_has_the_first_error_else_the_first_warning() -> None:
    note, warning = make_finding("VP039", "over"), make_finding("VP050", "T5", line=7)
    for found, shown in (
        ((note,), ""),
        ((note, warning), "VP050 line 7: T5"),
        ((warning, make_finding("VP101", "rho1", line=9)), "VP101 line 9: rho1"),
    ):
        row = format_batch([Outcome("a.nc", int(find_exit_status(found)), found)]).splitlines()[1]
        assert row.endswith(f"         -          -  {shown}".rstrip())


def test_a_table_counts_the_errors_that_it_does_not_name_and_says_the_machine() -> None:
    found = tuple(make_finding("VP216", f"contact {line}", line=line, severity="error") for line in range(3, 24, 3))
    outcomes = [Outcome("a.nc", 1, found), Outcome("b.nc", 0)]
    one = format_batch(outcomes, is_brief=True, machines={"a.nc": "VERNE", "b.nc": "VERNE"}).splitlines()
    assert one[1].endswith("  7 errors: VP216 line 3 +6")
    assert one[-1] == "2 programs: 1 can run, 1 refused, on VERNE"
    assert format_batch(outcomes).splitlines()[1].endswith("  VP216 line 3 +6: contact 3")
    two = format_batch(outcomes, is_brief=True, machines={"a.nc": "VERNE", "b.nc": "serial"}).splitlines()
    assert two[1].startswith("a.nc     refused on VERNE  ")
    assert two[2].startswith("b.nc     can run on serial ")
    assert two[-1] == "2 programs: 1 can run, 1 refused"


def test_a_table_names_the_file_in_which_a_set_up_is_wrong(folder: Path, run: Callable[..., Any]) -> None:
    Path("in/p0.nc.toml").write_text("[wcs]\nG54 = [0, 0]\n", encoding="utf-8")
    told = run("batch", "in/p0.nc", "-o", "out").out
    assert re.search(r"in/p0\.nc +refused +- +-  1 error: VP503 in/p0\.nc\.toml:2\n", told)


def test_the_findings_of_each_program_stand_before_the_table(folder: Path, run: Callable[..., Any]) -> None:
    """As `check` prints them, warnings too; the table counts them; the last line is the result of all."""
    Path("in/s.nc").write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X5 Q17 F3000\nM2\n")
    Path("in/w.nc").write_text("G21 G90\nG0 X0 Y0 Z50\nG1 X5 F3000\nG1 X9 A20\nM2\n")
    words = ("batch", "in/s.nc", "in/w.nc", "in/p0.nc", "-o", "out", "-j", 1, *PLACE)
    first, again = run(*words), run(*words)
    checked = run("check", "in/s.nc", "in/w.nc", *PLACE)
    said = [line for line in checked.out.splitlines() if re.match(r"in/\w\.nc:\d+(:\d+)?: VP", line)]
    assert [re.sub(r".*(VP\d+ \w+):.*", r"\1", line) for line in said] == [
        "VP006 error",
        "VP036 warning",
        "VP037 warning",
    ]
    for answer in (first, again):
        assert [line for line in answer.err.splitlines() if line in said] == said
        assert "  3 | G1 X5 Q17 F3000\n" in answer.err
        table = {line.split()[0]: line.rpartition("  ")[2] for line in answer.out.splitlines()}
        assert (table["in/s.nc"], table["in/w.nc"]) == ("1 error: VP006 line 3", "2 warnings: VP036 line 3 +1")
        assert answer.out.splitlines()[-1].startswith("3 programs: ")
    annotated = run(*words, "--github").out.splitlines()
    assert [line[:9] for line in annotated[:4]] == ["::error f", "::warning", "::warning", "::notice "]
    assert annotated[4].startswith("program ")


def test_shards_are_a_partition(folder: Path, run: Callable[..., Any]) -> None:
    listed = []
    for share in ("1/3", "2/3", "3/3"):
        run("batch", "in", "-o", f"out{share[0]}", "-j", 1, "--shard", share, *PLACE)
        listed.append([one["program"] for one in json.loads(Path(f"out{share[0]}/batch.json").read_text())["programs"]])
    assert [len(names) for names in listed] == [4, 4, 4]
    assert len({name for names in listed for name in names}) == 12


def test_files_that_call_each_other_are_in_one_share_each(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """O1 comes to O3 through O2; O4 and O5 only call each other, and O6 calls itself."""
    monkeypatch.chdir(tmp_path)
    for number, called in ((3, 3), (2, 3), (1, 2), (4, 5), (5, 4), (6, 6)):
        end = "M30" if number == 1 else "M99"
        Path(f"O{number}.nc").write_text(f"O{number}\nG1 X4. F900\n(M98 P1)\nM98 P{called}\n{end}\n")
    callers = find_callers([f"O{number}.nc" for number in range(1, 7)])
    assert callers == {"O2.nc": "O1.nc", "O3.nc": "O1.nc"}


def test_globs_and_files(folder: Path, run: Callable[..., Any]) -> None:
    answer = run("batch", "in/sub/*.nc", "in/p0.nc", "-o", "out", "-j", 1, *PLACE)
    assert answer.code == 0
    assert "7 programs: 7 can run" in answer.out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("in/none*.nc", "-o", "out"), "no such file"),
        (("empty", "-o", "out"), "no programs in empty"),
        (("empty", "-o", "empty"), "empty: is in the folder of -o, where no programs are looked for; give another -o"),
        (("in", "-o", "out", "--shard", "4/3"), "expected I/N"),
        (("in", "-o", "out", "--shard", "x"), "expected I/N"),
        (("in", "same/p0.nc", "-o", "out"), "would both be written to out/p0.nc.csv"),
        (("in", "-o", "out", "--scheduler", "tcp://localhost:1", "-j", "2"), "-j is for processes of this machine"),
    ],
)
def test_bad_options(folder: Path, run: Callable[..., Any], words: tuple[str, ...], said: str) -> None:
    Path("empty").mkdir()
    Path("same").mkdir()
    Path("same/p0.nc").write_text(GOOD.format(z=50, x=1))
    answer = run("batch", *words, *PLACE)
    assert answer.code == 2
    assert said in answer.err
    assert not Path("out").exists()


@pytest.mark.parametrize("address", ["nonsense", "http://localhost:1", "tcp://127.0.0.1:port", "tcp://127.0.0.1:9"])
def test_a_scheduler_that_does_not_answer_is_named(
    folder: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    config = pytest.importorskip("dask").config
    pytest.importorskip("distributed")
    with config.set({"distributed.comm.timeouts.connect": "200ms"}):
        answer = run("batch", "in", "-o", "out", "--scheduler", address, *PLACE)
    assert answer.code == 2
    assert f"Error: --scheduler {address}: " in answer.err
    assert "as tcp://host:8786" in answer.err


@pytest.mark.skipif(sys.platform != "linux", reason="signals as Linux has them")
@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_a_batch_that_is_ended_warns_of_no_semaphores(folder: Path, environment: dict[str, str], ending: int) -> None:
    """The process that removes them has nothing to say; standard error is closed when the last process has ended."""
    for number in range(40):
        Path(f"in/more{number}.nc").write_text(GOOD.format(z=60 + number, x=20 + number), encoding="utf-8")
    command = [sys.executable, "-m", "verne_post", "batch", "in", "-o", "out", "-j", "2", *map(str, PLACE)]
    running = subprocess.Popen(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=_hear_hang_ups
    )
    begin = time.monotonic()
    while count_records("out/.verne-post") < 2 and running.poll() is None and time.monotonic() - begin < 60:
        time.sleep(0.02)
    running.send_signal(ending)
    _out, said = running.communicate()
    assert running.returncode == -ending
    assert said == b""


def _hear_hang_ups() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


class Bomb:
    """Kills the process that unpickles it."""

    def __reduce__(self) -> tuple[Any, ...]:
        return os._exit, (9,)


def test_a_process_that_dies_takes_no_other_program_with_it(folder: Path) -> None:
    machine, options = verne_post.load_machine(), Options(tool_length=60.0)
    jobs = [Job(f"in/p{n}.nc", Path("out"), Path(f"p{n}.csv"), machine, options, "csv", ()) for n in (0, 3, 6)]
    jobs[1] = replace(jobs[1], options=Bomb())  # type: ignore[arg-type]
    outcomes = {one.program: one for one in run_here(jobs, 2)}
    assert {name: one.status for name, one in outcomes.items()} == {"in/p0.nc": 0, "in/p3.nc": 70, "in/p6.nc": 0}
    assert "killed" in outcomes["in/p3.nc"].findings[0].message


def test_an_internal_error_is_an_outcome(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = verne_post.load_machine()
    job = Job("in/p0.nc", Path("out"), Path("p0.csv"), machine, Options(tool_length=60.0), "no such", ())
    outcome = run_job(job)
    assert outcome.status == 70
    assert outcome.findings[0].code == "VP902"
    assert not Path("out/p0.csv").exists()


def count_records(folder: str) -> int:
    """Records of finished programs; folders that vanish during the count are passed over, which ``rglob`` does
    not do.
    """
    return sum(name.endswith(".csv.json") for _folder, _below, names in os.walk(folder) for name in names)


def test_a_batch_that_was_killed_goes_on(folder: Path, run: Callable[..., Any], environment: dict[str, str]) -> None:
    for number in range(12):
        Path(f"in/more{number}.nc").write_text(GOOD.format(z=60 + number, x=20 + number), encoding="utf-8")
    command = [sys.executable, "-m", "verne_post", "batch", "in", "-o", "out", "-j", "1", *map(str, PLACE)]
    running = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    begin = time.monotonic()
    while count_records("out/.verne-post") < 5 and running.poll() is None and time.monotonic() - begin < 60:
        time.sleep(0.02)
    running.send_signal(signal.SIGKILL)
    running.wait()
    made = count_records("out/.verne-post")
    assert made >= 5
    answer = run("batch", "in", "-o", "out", "-j", 1, *PLACE)
    counted = re.search(r"(\d+) can run \(as before\)", answer.out.splitlines()[-1])
    assert counted
    as_before = int(counted[1])
    assert 1 <= as_before <= made
    whole = contents("out")
    run("batch", "in", "-o", "fresh", "-j", 1, *PLACE)
    assert {name: raw for name, raw in whole.items() if not name.startswith(".")} == contents("fresh")


CLUSTER = """
import sys
from distributed import LocalCluster

if __name__ == "__main__":
    local = {"dashboard_address": None, "host": "127.0.0.1"}
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, **local) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


def test_a_dask_cluster_with_two_workers(folder: Path, run: Callable[..., Any], environment: dict[str, str]) -> None:
    pytest.importorskip("distributed")
    Path("cluster.py").write_text(CLUSTER, encoding="utf-8")
    cluster = subprocess.Popen(
        [sys.executable, "cluster.py"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=environment,
    )
    try:
        assert cluster.stdout is not None
        address = cluster.stdout.readline().strip()
        assert address.startswith("tcp://")
        command = [
            sys.executable,
            "-m",
            "verne_post",
            "batch",
            "in",
            "-o",
            "dask",
            "--scheduler",
            address,
            *map(str, PLACE),
        ]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=120)
    finally:
        cluster.communicate("")
    assert done.returncode == 2, done.stderr
    here = run("batch", "in", "-o", "here", "-j", 1, *PLACE)
    assert done.stdout == here.out
    assert contents("dask") == contents("here")
