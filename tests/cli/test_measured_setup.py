"""Work offsets and tool lengths as other software measured them, and files that are out of date."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PROGRAM = "G21 G90\nT3 M6\nG43 H3\nG0 X0 Y0 Z50 A0 C0\nG1 X20 F1500\nG0 Z60\nM2\n"
OFFSET = "system,x_mm,y_mm,z_mm,c_deg\nG54,5.25,-8.125,30.5,15\n"
LENGTHS = "tool,length_mm\n3,61.125\n"


@pytest.fixture
def job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in (
        ("p.nc", PROGRAM),
        ("o.csv", OFFSET),
        ("l.csv", LENGTHS),
        ("t.tbl", "T3 P3 Z60 D6\nT4 P4 Z10\n"),
    ):
        Path(name).write_text(text, encoding="utf-8")
    return tmp_path


def converted(run: Callable[..., Any], *words: object) -> str:
    answer = run("convert", "p.nc", *words)
    assert answer.code == 0, answer.err
    return str(answer.out)


def test_they_mean_what_wcs_and_a_tool_table_mean(job: Path, run: Callable[..., Any]) -> None:
    Path("t2.tbl").write_text("T3 P3 Z61.125\n")
    plain = converted(run, "--wcs", "G54=5.25,-8.125,30.5,15", "--tool-table", "t2.tbl")
    assert converted(run, "--measured-offset", "o.csv", "--tool-lengths", "l.csv") == plain
    # the table's own length of T3 is replaced, the other tools stay
    assert converted(run, "--measured-offset", "o.csv", "--tool-table", "t.tbl", "--tool-lengths", "l.csv") == plain
    Path("o.json").write_text('[{"system": "G54", "x_mm": 5.25, "y_mm": -8.125, "z_mm": 30.5, "c_deg": 15}]')
    Path("l.json").write_text('[{"tool": 3, "length_mm": 61.125, "diameter_mm": 6}]')
    assert converted(run, "--measured-offset", "o.json", "--tool-lengths", "l.json") == plain


def test_a_table_without_z_has_its_lengths_from_elsewhere(job: Path, run: Callable[..., Any]) -> None:
    """A tool of which nobody has said a length was one of 0 mm, 61 mm too deep; other tools of the table are not
    missed.
    """
    Path("d.tbl").write_text("T4 P4 D8\n\nT3 P3 D6 ; not measured\n")
    place = ("--wcs", "G54=0,0,40")
    for command in (("convert", "p.nc"), ("check", "p.nc")):
        answer = run(*command, *place, "--tool-table", "d.tbl")
        assert answer.code == 2
        assert "p.nc:3:5: VP012 error: tool 3: d.tbl:3 gives no length" in answer.out + answer.err
    measured = converted(run, *place, "--tool-table", "d.tbl", "--tool-lengths", "l.csv")
    assert measured == converted(run, *place, "--tool-table", "d.tbl", "--tool-length", "61.125")
    Path("z.tbl").write_text("T3 P3 Z61.125\nT4 P4 D8\n")
    assert measured == converted(run, *place, "--tool-table", "z.tbl")
    Path("z.tbl").write_text("T3 P3 Z0\n")
    answer = run("check", "p.nc", "--wcs", "G54=0,0,140", "--tool-table", "z.tbl")
    assert answer.code == 0
    assert "VP034 warning: tool 3 has the length 0 in the tool table" in answer.out


@pytest.mark.parametrize(
    ("name", "program", "said"),
    [
        ("a.nc", "G21 G90 F600\nT2 M6\nG43 H2\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nM2\n",
         "a.nc:3:5: VP012 error: tool 2: d.tbl:1"),
        ("b.nc", "G21 G90 F600\nG10 L1 P7 R3\nT7 M6\nG43 H7\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nM2\n",
         "b.nc:4:5: VP012 error: tool 7: G10 L1 in line 2"),
        ("c.nc", "G21 G90 F600\nG10 L1 P2 Z60\nT2 M6\nG43 H2\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nM2\n", "can run"),
        ("d.nc", "G21 G90 F600\nT2 M6\nG43.1 Z60\nG0 X0 Y0 Z80 A0 C0\nG1 X#5403\nM2\n",
         "d.nc:5:5: VP012 error: tool 2: d.tbl:1"),
        ("e.nc", "%\nO1\nG21 G90 F600\nT2 M6\nG43.4 H2\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nM30\n%\n",
         "e.nc:5:7: VP012 error: tool 2: d.tbl:1"),
        ("f.mpf", "$TC_DP6[7,1]=3\nT7 M6\nG0 X0 Y0 Z80 A0 C0\nG1 X5 F600\nM30\n",
         "f.mpf:2: VP012 error: tool 7: $TC_DP6 without $TC_DP3"),
        ("g.mpf", "T2 M6\nTRAORI\nG0 X0 Y0 Z80 A0 C0\nG1 X5 F600\nM30\n", "g.mpf:1: VP012 error: tool 2: d.tbl:1"),
        ("h.h", "BEGIN PGM H MM\nTOOL CALL 2 Z S1000\nM128\nL X+0 Y+0 Z+80 A+0 C+0 R0 FMAX\nL X+5 F600\nEND PGM H MM\n",
         "h.h:2:11: VP012 error: tool 2: d.tbl:1"),
        ("i.cls", "PARTNO E\nUNITS/MM\nLOADTL/2\nRAPID\nGOTO/0,0,80,0,0,1\nFEDRAT/600,MMPM\nGOTO/5,0,80,0,0,1\nFINI\n",
         "i.cls:3:1: VP012 error: tool 2: d.tbl:1"),
    ],
)  # fmt: skip
def test_a_tool_without_a_length_in_every_dialect(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any], name: str, program: str, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("d.tbl").write_text("T2 P2 D6\n")
    Path(name).write_text(program)
    answer = run("check", name, "--tool-table", "d.tbl", "--wcs", "G54=0,0,60")
    assert said in answer.out
    assert answer.out.count("VP012") == (said != "can run")
    # one sentence says what settles it: that of the message, or of the remedy
    assert answer.out.count("write one there, mm from the gauge line") == ("d.tbl:1" in said)
    assert answer.out.count("Fill in the length in") == (name in ("b.nc", "f.mpf"))


def test_a_program_that_changed_is_not_its_own_subroutine_too(tmp_path: Path, run: Callable[..., Any]) -> None:
    """Its name in a remark made it a file that it may call, whose two hashes filled a second finding."""
    program = "; OWN\nG17 G90 G54 G71\nG0 X0 Y0 Z60 A0 C0\nOTHER\nG1 Z50 F500\nM30\n"
    own, other = tmp_path / "own.mpf", tmp_path / "other.spf"
    own.write_text(program)
    other.write_text("G1 Z55 F500\nRET\n")
    given = ("--tool-length", 60, "--wcs", "G54=0,0,60", "--meta", tmp_path / "own.json")
    assert run(own, *given, "-o", tmp_path / "own.csv").code == 0
    verify = ("verify", tmp_path / "own.csv", "--against", own, *given)
    own.write_text(program.replace("Z50", "Z49"))
    assert run(*verify).err.count("VP414") == 1
    own.write_text(program)
    other.write_text("G1 Z54 F500\nRET\n")
    (said,) = (line for line in run(*verify).err.splitlines() if "VP414" in line)
    assert re.search(r'subroutines other was "[0-9a-f]{12}", and is "[0-9a-f]{12}"$', said)


def test_verify_notices_what_has_changed_since(job: Path, run: Callable[..., Any]) -> None:
    setup = ("--measured-offset", "o.csv", "--tool-lengths", "l.csv")
    converted(run, *setup, "-o", "axes.csv", "--meta", "axes.json", "--override", 0.5)
    verify = ("verify", "axes.csv", "--against", "p.nc", *setup, "--meta", "axes.json")
    answer = run(*verify)
    assert answer.code == 0, answer.err
    # a change far below every tolerance of the path is still a change
    Path("o.csv").write_text(OFFSET.replace("-8.125", "-8.12501"))
    answer = run(*verify)
    assert answer.code == 1
    assert (
        "VP414 error: the setpoint file is out of date: work offset G54 was [5.25, -8.125, 30.5, 15.0], and is [5.25, "
        "-8.12501, 30.5, 15.0]" in answer.err
    )
    Path("o.csv").write_text(OFFSET)
    Path("l.csv").write_text("tool,length_mm\n3,61.2\n")
    answer = run(*verify)
    assert answer.code == 1
    assert "tool 3 was [61.125, 0.0], and is [61.2, 0.0]" in answer.err
    assert "VP411" in answer.err  # 0.075 mm are seen in the rows too
    Path("l.csv").write_text(LENGTHS)
    Path("p.nc").write_text(PROGRAM + "(more)\n")
    answer = run(*verify)
    assert answer.code == 1
    assert "the program is not the one that it was made from (p.nc)" in answer.err
    assert "VP411" not in answer.err


def test_a_side_car_that_is_none(job: Path, run: Callable[..., Any]) -> None:
    converted(run, "--measured-offset", "o.csv", "--tool-lengths", "l.csv", "-o", "axes.csv")
    other = "it is JSON without schema, program.sha256, machine.sha256 or options"
    for text, why in (("{}", other), ("[1]", other), ("no", "it is no JSON")):
        Path("axes.json").write_text(text)
        answer = run("verify", "axes.csv", "--against", "p.nc", "--tool-length", 60, "--meta", "axes.json")
        assert answer.code == 2
        assert f"axes.json: not a metadata file: {why}; give the file that --meta of convert wrote" in answer.err


@pytest.mark.parametrize(
    ("option", "text", "said"),
    [
        ("--measured-offset", "", "f: VP504 error: no rows; expected the columns system,x_mm,y_mm,z_mm,c_deg"),
        ("--measured-offset", "system,x_mm,y_mm\nG54,1,2\n", "f:2: VP504 error: z_mm is missing"),
        ("--measured-offset", "system,x_mm,y_mm,z_mm,b\nG54,1,2,3,4\n", "f:2: VP504 error: 'b' is no column of it"),
        ("--measured-offset", "system,x_mm,y_mm,z_mm\nG53,1,2,3\n", "'G53' is no work system"),
        ("--measured-offset", "system,x_mm,y_mm,z_mm\nG54,1,2,nan\n", "z_mm = 'nan' is not a number"),
        ("--measured-offset", "system,x_mm,y_mm,z_mm\nG54,1,2,3\nG54,1,2,3\n", "f:3: VP504 error: G54 appears twice"),
        ("--measured-offset", '{"system": "G54"}', "expected a list of objects"),
        ("--measured-offset", "[1", "neither CSV nor JSON"),
        (
            "--tool-lengths",
            "tool,length_mm\n3.5,60\n",
            "f:2: VP504 error: tool '3.5': expected a whole number from 1 on",
        ),
        ("--tool-lengths", "tool,length_mm\n3,60\n3,61\n", "f:3: VP504 error: tool 3 appears twice"),
        ("--tool-lengths", "tool,length_mm\n3,-1\n", "a tool length lies between 0 and 10000 mm"),
        ("--tool-lengths", "tool,length_mm\n3,6e1x\n", "length_mm = '6e1x' is not a number"),
    ],
)
def test_bad_files(job: Path, run: Callable[..., Any], option: str, text: str, said: str) -> None:
    Path("f").write_text(text)
    more = () if option == "--tool-lengths" else ("--tool-length", 60)
    answer = run("check", "p.nc", option, "f", *more)
    assert answer.code == 2
    assert said in answer.err + answer.out


def test_two_answers_to_one_question(job: Path, run: Callable[..., Any]) -> None:
    answer = run("check", "p.nc", "--measured-offset", "o.csv", "--wcs", "G54=1,2,3", "--tool-length", 60)
    assert answer.code == 2
    assert "--wcs G54: o.csv has this work offset too; give it once" in answer.err
    answer = run("check", "p.nc", "--tool-length", 60, "--tool-lengths", "l.csv")
    assert answer.code == 2
    assert "exclude each other" in answer.err


def test_the_side_car_tells_what_was_kept_out_of(job: Path, run: Callable[..., Any]) -> None:
    converted(
        run,
        "--measured-offset",
        "o.csv",
        "--tool-lengths",
        "l.csv",
        "-o",
        "axes.csv",
        "--meta",
        "axes.json",
        "--keep-out",
        "vise@G54=100,0,0,120,50,20",
    )
    told = json.loads(Path("axes.json").read_text())["options"]
    assert told["keep_out"] == [
        {"name": "vise", "min": [100.0, 0.0, 0.0], "max": [120.0, 50.0, 20.0], "system": "G54", "distance_mm": 0.0}
    ]
