"""Findings as text and JSON: the documented form, exactly."""

import inspect
import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

import verne_post as vp
from verne_post.model.codes import CODES
from verne_post.model.findings import make_finding
from verne_post.model.verdict import is_about_text
from verne_post.output.commands import Run
from verne_post.output.findings import Report, describe_remedy, format_causes, format_finding
from verne_post.output.reports import json as json_report
from verne_post.output.reports import text as text_report

from ..builders import MACHINE

#: What commands print: Python changes the words.
check_as_commands = inspect.unwrap(vp.check)
ARGUMENTS = ("--tool-length", "80", "--wcs", "G54=0,0,50")
KEYS = {"code", "severity", "line", "last_line", "worst_line", "axis", "value", "limit", "unit", "message", "count"}
# FILE:LINE: CODE severity: message
LINE = re.compile(
    r"(?P<file>.+?):(?P<line>\d+)(:(?P<column>\d+))?: (?P<code>VP\d{3}) (?P<severity>error|warning|note): "
    r"(?P<message>.+)"
)

PROGRAMS: dict[str, str] = {
    "good": "G0 X0 Y0 Z20 A0 C0\nG1 X3 F3000",
    "beyond the tilt": "G0 X0 Y0 Z120 A0 C0\nG1 A110 F2000\nA20\nA120\nA0",
    "two words wrong": "G0 X0 Y0 Z20 A0 C0\nG1 Q3 X3 F3000\nX2\nG1 B5",
    "no end": "G0 X0 Y0 Z20 A0 C0\nG1 X3 F3000",
    "no motion": "",
}


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    found = {}
    for name, body in PROGRAMS.items():
        found[name] = tmp_path / f"{name.replace(' ', '_')}.nc"
        end = "" if name == "no end" else "M2\n"
        found[name].write_text(f"G21 G90 G94 G17\n{body}\n{end}")
    return found


def strict(document: str) -> Any:
    """Parse JSON, refusing NaN and infinities, which are not JSON."""

    def refuse(constant: str) -> None:
        raise ValueError(constant)

    return json.loads(document, parse_constant=refuse)


def test_json_has_the_documented_keys(files: dict[str, Path], run: Callable[..., Any]) -> None:
    answer = run("check", *files.values(), *ARGUMENTS, "--output-format", "json")
    data = strict(answer.out)
    assert set(data) == {"schema", "programs"}
    assert data["schema"] == 1
    assert [item["program"] for item in data["programs"]] == [str(file) for file in files.values()]
    for item in data["programs"]:
        assert set(item) == {"program", "machine", "verdict", "summary", "unchecked", "called", "findings"}
        assert item["machine"] == {"name": "VERNE", "sha256": MACHINE.sha256}
        assert set(item["summary"]) == {"errors", "warnings", "ignored", "known", "cycle_time_s"}
        for found in item["findings"]:
            # the other keys are additions, which the contract allows
            assert (
                KEYS
                <= set(found)
                <= KEYS
                | {
                    "column",
                    "remedies",
                    "settled_by",
                    "remedy",
                    "file",
                    "file_line",
                    "file_column",
                    "lines",
                    "plane",
                    "counted_with",
                }
            )
            assert found["code"] in CODES
            assert found["severity"] in ("error", "warning", "note")
            assert found["count"] >= 1
        severities = [found["severity"] for found in item["findings"]]
        assert item["summary"]["errors"] == severities.count("error")
        assert item["summary"]["warnings"] == severities.count("warning")
    programs = dict(zip(files, data["programs"], strict=True))
    assert programs["good"]["findings"] == []
    assert programs["good"]["summary"]["cycle_time_s"] > 0
    assert programs["no motion"]["summary"]["cycle_time_s"] is None


def test_json_names_the_bodies_that_were_not_checked(files: dict[str, Path], run: Callable[..., Any]) -> None:
    """What the text prints after NOT CHECKED, of a refused program too."""
    for box in ((), ("--stock", "G54=-50,-50,-90,50,50,-80")):
        for name in ("good", "beyond the tilt"):
            asked = ("check", files[name], *ARGUMENTS, *box)
            data = strict(run(*asked, "--output-format", "json").out)
            (told,) = re.findall(r"^  NOT CHECKED: (.*)$", run(*asked).out, re.MULTILINE)
            assert data["programs"][0]["unchecked"] == told
            assert ("spindle, platform, rods" in told) == bool(box)


def test_one_finding_covers_a_stretch(files: dict[str, Path], run: Callable[..., Any]) -> None:
    answer = run("check", files["beyond the tilt"], *ARGUMENTS, "--output-format", "json")
    findings = [item for item in strict(answer.out)["programs"][0]["findings"] if item["code"] == "VP102"]
    # lines 3 and 4 meet at A110, lines 5 and 6 at A120: four moves in a row, the farthest at 120
    assert len(findings) == 1
    (item,) = findings
    assert (item["line"], item["last_line"], item["count"]) == (3, 6, 4)
    assert item["worst_line"] in (5, 6)
    assert (item["severity"], item["axis"], item["unit"], item["limit"]) == ("error", "a", "deg", 95.0)
    assert 110 < item["value"] < 121  # A programmed 120, less a tilt of some degrees


def test_text_is_one_line_a_finding(files: dict[str, Path], run: Callable[..., Any]) -> None:
    answer = run("check", *files.values(), *ARGUMENTS)
    data = strict(run("check", *files.values(), *ARGUMENTS, "--output-format", "json").out)
    lines = [line for line in answer.out.splitlines() if not line.startswith("  ")]  # without the quoted ones
    assert any(line.startswith("  5 | ") for line in answer.out.splitlines())
    for item in data["programs"]:
        for found in item["findings"]:
            shown = lines.pop(0)
            place = (item["program"], found["line"], found["column"])
            where = ":".join(str(one) for one in place if one is not None)
            assert shown.startswith(f"{where}: {found['code']} {found['severity']}: {found['message']}")
        assert lines.pop(0).startswith(f"{item['program']}: ")  # the verdict
    assert lines.pop(0).startswith("NOT CHECKED in 2 programs: contact with fixtures")
    assert lines == ["5 programs: 1 can run, 4 refused"]


@pytest.mark.parametrize("name", ["beyond the tilt", "two words wrong", "no end"])
def test_standard_error_has_the_documented_form(name: str, files: dict[str, Path], run: Callable[..., Any]) -> None:
    """FILE:LINE:COLUMN: CODE severity: message, so that other programs can find the place; not all have a column."""
    answer = run(files[name], *ARGUMENTS)
    assert answer.out == ""
    *findings, outcome = [line for line in answer.err.splitlines() if not line.startswith("  ")]
    assert re.fullmatch(
        re.escape(str(files[name])) + r": refused: \d errors?, \d warnings?; nothing was written", outcome
    )
    shown = [LINE.fullmatch(line) for line in findings]
    assert all(shown)
    assert {item["file"] for item in shown if item} == {str(files[name])}
    expected = {"beyond the tilt": {3}, "two words wrong": {3, 5}, "no end": {3}}
    found = {int(item["line"]) for item in shown if item}
    assert found >= expected[name]


def test_output_file_gets_what_standard_output_would(
    files: dict[str, Path], run: Callable[..., Any], tmp_path: Path
) -> None:
    for form in ("text", "json"):
        shown = run("check", files["good"], *ARGUMENTS, "--output-format", form)
        answer = run("check", files["good"], *ARGUMENTS, "--output-format", form, "--output-file", tmp_path / "f")
        assert answer.out == ""
        assert (tmp_path / "f").read_text() == shown.out


def test_a_remedy_says_more_than_its_message_or_is_left_out(tmp_path: Path, run: Callable[..., Any]) -> None:
    assert [code for code, known in CODES.items() if "that the message names" in known.remedy] == []
    program = tmp_path / "lacks.nc"
    program.write_text("G21 G90 G94\nG0 X0 Y0 Z20 A0 C0\nG4\nG10 L2 P10 Z1\nQ7\nM2\n")
    told = run("check", program, *ARGUMENTS).out
    findings = told.split(f"{program}:")
    missing, number, useless = (next(one for one in findings if code in one) for code in ("VP005", "VP007", "VP006"))
    assert "    = " not in missing
    assert "    = " not in number
    assert CODES["VP006"].remedy in useless
    assert "Remedy: Write a number in the range that the message gives." in run("explain", "VP007").out


_HEAD = "G21 G90 G94 G17 G54\nT1 M6\nG43 H1\nG0 X0 Y0 Z50 A0 C0\n"
_FANUC = f"%\nO1\n{_HEAD}"
_KLARTEXT = "0 BEGIN PGM P MM\n1 TOOL CALL 1 Z S500\n2 L X+0 Y+0 Z+50 A+0 C+0 R0 FMAX\n"
_SIEMENS = "G710 G90\nT1 M6\nD1 TRAORI\nG54 G0 X0 Y0 Z60 A=0 C=0\n"


@pytest.mark.parametrize(
    ("name", "program", "code", "remedy"),
    [
        ("a.nc", f"{_FANUC}M98 P77\nM30\n%\n", "VP023", "Put its file beside the program"),
        ("a.nc", f"{_HEAD}o7 call\nM2\n", "VP023", "Put its file beside the program"),
        ("a.nc", f"{_FANUC}GOTO 55\nM30\n%\n", "VP023", "Write the label, or the number of the block"),
        ("a.nc", f"{_FANUC}END1\nM30\n%\n", "VP023", "Open and close each in its order"),
        ("a.nc", f"{_HEAD}o1 break\nM2\n", "VP023", "Open and close each in its order"),
        ("a.nc", f"{_HEAD}o1 while [1]\nG1 X1 F100\nM2\n", "VP023", ""),
        ("a.mpf", f"{_SIEMENS}GOTOF LAB\nM30\n", "VP023", "Write the label, or the number of the block"),
        ("a.mpf", f"{_SIEMENS}ENDIF\nM30\n", "VP023", "Open and close each in its order"),
        ("a.h", f"{_KLARTEXT}3 CALL LBL 5\n4 END PGM P MM\n", "VP023", "Write the label, or the number of the block"),
        ("a.h", f"{_KLARTEXT}3 CALL PGM FOO.H\n4 END PGM P MM\n", "VP023", "Put its file beside the program"),
        ("a.h", f"{_KLARTEXT}3 LBL 7\n4 LBL 7\n5 LBL 0\n6 END PGM P MM\n", "VP023", ""),
        ("a.nc", "G49 G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG2 X10 Y1 I5 F500\nM2\n", "VP008", "more decimals, or as str"),
        (
            "a.nc",
            "G49 G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG2 X2 F500 I0 J0\nM2\n",
            "VP008",
            "The arc starts where the block before ends",
        ),
        ("a.nc", "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F500\nM2\n", "VP012", "Fill in tool_length, mm, in"),
        ("a.nc", f"{_HEAD}M2\n", "VP012", "Fill in the length in a.toml"),
        ("a.nc", "G21 G90 G94\nG43\nG0 X0 Y0 Z50 A0 C0\nM2\n", "VP012", ""),
        ("a.h", _KLARTEXT.replace("CALL 1", "CALL 0") + "3 L X+9 RL F9\n4 L X+99\n5 END PGM P MM\n", "VP012", ""),
        ("a.mpf", _SIEMENS.replace(" M6", "") + "G1 X1 F9\nM30\n", "VP012", ""),
        ("a.nc", f"{_HEAD}G0 B30\nM30\n", "VP011", "A and C, or with tool axes (I J K of G43.5), which"),
        ("a.mpf", f"{_SIEMENS}G0 B=30\nM30\n", "VP011", "tool axes (A3= B3= C3= of TRAORI), which name"),
        (
            "a.h",
            f"{_KLARTEXT}3 L B+30 FMAX\n4 END PGM P MM\n",
            "VP011",
            "(LN with M128), which name no rotary axis. Or",
        ),
        ("a.nc", f"{_HEAD}G0 U30\nM30\n", "VP011", ""),  # the message says it
        ("a.nc", f"{_HEAD}G0 X3O\nM30\n", "VP001", ""),
    ],
)
def test_a_remedy_is_made_where_the_finding_is(name: str, program: str, code: str, remedy: str, tmp_path: Path) -> None:
    """Whatever the words of the message, which an editor and Python change; nothing where it says what is right."""
    (tmp_path / name).write_text(program)
    found = [one for one in check_as_commands(tmp_path / name, vp.load_machine()).findings if one.code == code]
    said = describe_remedy(found[-1], "a")
    assert remedy in said if remedy else said == ""


@pytest.mark.parametrize(
    ("tools", "program", "said", "remedy"),
    [
        ("1 = {length = 80}", "T5 M6", "tool 5 has no length in force before the first feed move; write G43 H5", ""),
        ("1 = {diameter = 8}", "", "no tool length has been given", "Write the length of the tool under [tools]"),
    ],
)
def test_no_remedy_writes_tool_length_beside_the_tools_of_a_set_up(
    tools: str, program: str, said: str, remedy: str, tmp_path: Path
) -> None:
    """VP503 would refuse both keys."""
    (tmp_path / "a.nc").write_text(f"G21 G90 G94 {program}\nG0 X0 Y0 Z150 A0 C0\nG1 X5 F500\nM2\n")
    (tmp_path / "a.nc.toml").write_text(f"[tools]\n{tools}\n[wcs]\nG54 = [0, 0, 60]\n")
    result = check_as_commands(tmp_path / "a.nc", vp.load_machine())
    found = [one for one in result.findings if one.code == "VP012"]
    assert found[-1].message.startswith(said)
    assert [one.line for one in found] == ([1, 3] if program else [3])
    assert remedy in describe_remedy(found[-1], "a") if remedy else describe_remedy(found[-1], "a") == ""


_CUT = "G21 G90 G94 G17 {}\nT1 M6\nG0 X0 Y0 Z150 A0 C0\n{}\nG1 X5 Z120 F500\nG0 Z200\nM30\n"
_TURNED = (
    "G17 G54 G64 G90 G94 G710\nT1 D1\nM6\nS900 M3\nTRAORI\nG0 A-20 C0\nG0 X0 Y0 Z60\nTRAFOOF\n"
    "G0 Z70\nG1 Z55 F500\nG0 Z90\nM30\n"
)
_HEIDENHAIN = "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\n{}\nM30\nEND PGM P MM\n"
_FROM_ZERO = {"G54": (0, 0, 60)}
_OF_DIRECTIONS = "If directions of the machine are meant, give [fanuc]"


@pytest.mark.parametrize(
    ("program", "code", "given", "remedy"),
    [
        (_CUT.format("G54", "G43 H1"), "VP033", {}, "Fill in wcs.G54 in a.nc.toml, "),
        (_CUT.format("G54.1 P3", "G43 H1"), "VP033", {}, 'Fill in wcs."G54.1P3" in a.nc.toml, '),
        (_CUT.format("G55", "G43 H1"), "VP033", {"wcs": _FROM_ZERO}, "Write G55 = [x, y, z] under [wcs] of a.nc.toml"),
        (_CUT.format("G54", "G91 G10 L2 P2 X1\nG90 G43 H1"), "VP033", {"wcs": _FROM_ZERO}, "Fill in wcs.G55 in a.nc"),
        (_CUT.format("G54", "G49"), "VP034", {"wcs": _FROM_ZERO}, ""),
        (_CUT.format("G54", "G49"), "VP034", {"wcs": _FROM_ZERO, "tools": {1: 0.0}}, "If the gauge line is meant, "),
        (_CUT.format("G54", "G43 H1\nG0 A-30"), "VP037", {"wcs": _FROM_ZERO}, _OF_DIRECTIONS),
        (_CUT.format("G54", "G43.4 H1\nA-30\nG69\nG43 H1"), "VP037", {"wcs": _FROM_ZERO}, _OF_DIRECTIONS),
        # directions of the machine are what the control takes there: the message itself says what would be right
        (_TURNED, "VP037", {"wcs": _FROM_ZERO, "dialect": "siemens"}, ""),
        (_HEIDENHAIN.format("L X+10 Y+2 A+6 F600"), "VP037", {"wcs": _FROM_ZERO, "dialect": "heidenhain"}, ""),
        (_HEIDENHAIN.format("L A-20\nL Z+50 F600\nM128"), "VP037", {"wcs": _FROM_ZERO, "dialect": "heidenhain"}, ""),
    ],
)
def test_the_remedy_of_a_set_up_does_not_depend_on_the_words_of_the_message(
    program: str, code: str, given: dict[str, Any], remedy: str
) -> None:
    """It was chosen by patterns over messages: one in other words, as another language has it, had the wrong one."""
    options = vp.Options(**{"tools": {1: 80.0}, "dialect": "fanuc", **given})
    text = f"%\nO1\n{program}%\n" if options.dialect == "fanuc" else program
    [item] = [one for one in check_as_commands(text, "verne", options).findings if one.code == code]
    for said in (describe_remedy(item, "a.nc"), describe_remedy(replace(item, message="in other words"), "a.nc")):
        assert said.startswith(remedy)
        assert bool(said) == bool(remedy)


@pytest.mark.parametrize(
    ("code", "message", "remedy"),
    [
        ("VP026", "compensation along the normal is not executed; take DL and DR out", ""),
        ("VP026", "the tool (radius 5 mm) cannot reach into this inside corner", "Use a smaller tool, "),
        ("VP026", "tool 1 (diameter 10 mm) is too wide for this arc, whose radius is 4 mm: is G2 meant?", ""),
        ("VP022", "p.nc: a carriage return is inside the line; end lines with a line feed", ""),
        ("VP022", "p.nc: no such file", "Give the name of a program in a folder that you may read."),
        ("VP043", "the plane of G68.2 in line 5 is still in force; write G69 before if it is not meant", ""),
        ("VP002", "G54.2 is only executed with P0: the control stores it; let the CAM system write G43.4", ""),
        (
            "VP002",
            "G33 is not executed (spindle-synchronised motion)",
            "Correct it if it is misspelt; if not, post the program without it.",
        ),
        ("VP002", "G777 is not a code of this language", "Correct it if it is misspelt; if not, "),
        ("VP008", "CT straight back: no arc leads there", "Correct the end, the centre or the radius. "),
        ("VP013", "CT goes on in the direction of the motion before; write one first", ""),
        ("VP001", "expected '['", ""),
        ("VP023", "LBL 7 appears twice, first in line 3", ""),
    ],
)
def test_a_remedy_fits_the_cause(code: str, message: str, remedy: str) -> None:
    """A code has several causes: arcs of DL were to be posted with a smaller tool."""
    said = describe_remedy(make_finding(code, message), "a.nc")
    assert said.startswith(remedy)
    assert bool(said) == bool(remedy)
    assert ("more decimals" in said) == ("on the circle" in message)


@pytest.mark.parametrize("code", sorted(CODES))
def test_every_code_has_a_line(code: str) -> None:
    item = make_finding(code, "one sentence", line=7, last_line=9, worst_line=8, count=3)
    shown = LINE.match(format_finding("a b.nc", item))
    assert shown
    assert (shown["file"], shown["line"], shown["code"]) == ("a b.nc", "7", code)
    assert shown["severity"] == CODES[code].severity
    for number in ("7", "9", "3", *(() if is_about_text(code) else ("8",))):  # errors in the text have no worst line
        assert number in shown["message"]
    assert (
        format_finding("a.nc", make_finding(code, "one sentence"))
        == f"a.nc: {code} {CODES[code].severity}: one sentence"
    )


def test_json_never_contains_nan() -> None:
    """A value that is not a number is a bug to be seen here, not by a reader of the file."""
    report = Report("a.nc", (make_finding("VP101", "x", value=math.nan),))
    with pytest.raises(ValueError, match="JSON"):
        json_report.write([report], MACHINE)
    assert strict(json_report.write([Report("a.nc", ())], MACHINE))["programs"][0]["summary"]["cycle_time_s"] is None


def test_text_counts() -> None:
    shown = text_report.write(
        [Report("a.nc", (make_finding("VP101", "x"), make_finding("VP202", "y")), None), Report("b.nc", (), 1.5)]
    )
    assert shown.splitlines()[2] == "a.nc: refused: 1 error, 1 warning"
    assert shown.splitlines()[3] == "b.nc: can run: 0 errors, 0 warnings, machining time 1.500 s"


@pytest.mark.parametrize("words", [("--settings", "bad.toml"), ("--wcs", "G60=1,2,3")])
def test_every_format_says_why_a_check_could_not_begin(words, tmp_path, run, monkeypatch):
    """A CI server that waits for the file shows the mistake, not that the file is missing."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.nc").write_text("G21\n")
    (tmp_path / "bad.toml").write_text("nothing = 1\n")
    said = {}
    for name in ("json", "jsonl", "sarif", "junit", "github", "markdown"):
        answer = run("check", "a.nc", "--output-format", name, "--output-file", f"o.{name}", *words)
        assert answer.code == 2
        said[name] = (tmp_path / f"o.{name}").read_text()
    message = json.loads(said["json"])["failure"]["message"]
    assert json.loads(said["jsonl"])["failure"]["message"] == message
    [invocation] = json.loads(said["sarif"])["runs"][0]["invocations"]
    assert not invocation["executionSuccessful"]
    assert invocation["toolExecutionNotifications"][0]["message"]["text"] == message
    assert ElementTree.fromstring(said["junit"]).find("testsuite/testcase/error").text == message
    assert said["github"].startswith("::error ")
    assert said["markdown"].startswith("**verne-post could not check the programs**")
    assert ("| bad.toml:1 | " in said["markdown"]) == (words[0] == "--settings")


@pytest.mark.parametrize(
    ("words", "verdict"),
    [
        (("--machine", "bad.toml"), "refused: unusable configuration"),
        (("--settings", "bad.toml"), "refused: unusable configuration"),
        (("--tolerance", "-1"), "usage error"),
        (("--wcs", "G60=1,2,3"), "usage error"),
        (("--tool-table", "is_not_there.tbl"), "usage error"),
        ((), "refused: unusable program"),
    ],
)
def test_json_tells_bad_command_lines_from_bad_programs(words, verdict, tmp_path, run, monkeypatch):
    """All of them have exit status 2."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.nc").write_text("G1 X\n")
    (tmp_path / "bad.toml").write_text("nothing = 1\n")
    answer = run("check", "a.nc", "--output-format", "json", *words)
    assert answer.code == 2
    data = json.loads(answer.out)
    place = data["failure"] if words else data["programs"][0]
    assert place["verdict"] == verdict
    assert bool(data["programs"]) != bool(words)


@pytest.mark.parametrize("letters", ["AC", "BC", "AB"])
def test_the_remedy_of_a_missing_axis_names_machines_that_have_it(letters: str) -> None:
    """It was to post the program again, though a machine with B was shipped."""
    named = [f"{a}{b}_{kind}".lower() for a, b in [letters] for kind in ("trunnion", "table")]
    (name,) = [one for one in named if one in CODES["VP011"].remedy]
    assert set(letters) <= set(vp.load_machine(name).coordinates.axes)


def test_no_remedy_is_told_twice(tmp_path: Path, run: Callable[..., Any]) -> None:
    """What the message has is not in the line of remedies below it."""
    told = {}
    for change in ("T1", "T1 M6"):  # a tool that is not loaded is why it has no length: that is not told
        program = tmp_path / "bare.nc"
        program.write_text(
            f"%\nO1\nG21 G90 G94 G17 G49 G55\n{change}\nS900 M3\nG0 X0 Y0 Z300 A0 C0\nG1 Z290 F500\nM30\n%\n"
        )
        lengths = "" if change == "T1" else "[tools]\n1 = { length = 90 }\n"
        (tmp_path / "bare.nc.toml").write_text(lengths)
        shown = run("check", program).out
        found = re.findall(r": (VP\d+) \w+: (.*)\n.*\n(?: +\| +\^\n)? += [^:]+: (.*)\n", shown)
        assert {code for code, *_texts in found} == ({"VP033", "VP041"} if change == "T1" else set())
        assert ("VP034 error: " in shown and "activate its length (G43 H1) " in shown) is (change != "T1")
        told |= {code: (message, remedy) for code, message, remedy in found}
    for code, remedy in (("VP033", "give --wcs G55=X,Y,Z"), ("VP041", "write M6")):
        message, below = told[code]
        assert remedy in message and remedy.lower().partition("=")[0] not in below.lower()
        assert below[0].isupper() and below.endswith(".")


def test_a_hint_for_several_lines_names_those_for_which_it_is_true() -> None:
    """Other heights of a cycle are tried for contacts alone."""
    found = [
        make_finding(code, message, severity="error", line=line, last_line=line, worst_line=line, value=-1.0, axis=axis)
        for code, message, line, axis in (
            ("VP216", "the holder runs into the stock", 2, None),
            ("VP101", "1 mm beyond its travel", 3, "rho2"),
            ("VP216", "the shank runs into the stock", 4, None),
        )
    ]
    shown = ["\n".join(lines) for lines in format_causes("m.nc", found, b"G21\nX1\nX2\nX3\nM2\n")]
    assert [re.findall("m.nc:(.)`.*(other ends|within limits).*?(; likewise .*)?$", text) for text in shown] == [
        [],
        [("3", "within limits", "")],
        [("2", "other ends", "; likewise line 4")],
    ]


@pytest.mark.parametrize(
    ("machine", "name"), [("verne", "VERNE"), ("b_head_c_table", "B head, C table"), ("ab_table", "AB table")]
)
def test_an_axis_that_the_machine_lacks_names_the_machine(
    tmp_path: Path, run: Callable[..., Any], machine: str, name: str
) -> None:
    program = tmp_path / "axes.nc"
    program.write_text("G21 G90 G94 G17 G54\nG0 X0 Y0 Z300 U3\nM2\n")
    shown = run("check", program, "--machine", machine, "--tool-length", "80", "--wcs", "G54=0,0,50").out
    assert f"axes.nc:2:15: VP011 error: U: {name} has no such axis; it has X, Y, Z, " in shown
    assert "; post the program for these axes" in shown
    assert "rotary" not in shown  # U is none


def test_the_summary_begins_with_what_was_not_checked(files: dict[str, Path], run: Callable[..., Any]) -> None:
    said = "contact with fixtures and stock: no [keep_out.NAME] and no [stock] given"
    assert run("check", files["good"], *ARGUMENTS).out.split("\n")[1] == f"  NOT CHECKED: {said}"
    assert re.fullmatch(rf"  NOT CHECKED +{re.escape(said)}", run(files["good"], *ARGUMENTS).err.split("\n")[1])
    box = ("--keep-out", "vise=200,200,0,220,220,20", "--stock", "G54=-50,-50,-90,50,50,-80")
    shown = run("check", files["good"], *ARGUMENTS, *box).out
    assert "contact with" not in shown and "NOT CHECKED: spindle, platform, rods: " in shown


def test_a_set_up_on_standard_input_has_no_name_to_fill_in() -> None:
    said = describe_remedy(make_finding("VP033", "no work offset was given: G54"), "a.nc", Run("<stdin>"))
    assert said.startswith("Fill in wcs.G54 in the set-up, which verne-post setup a.nc writes,")


def test_a_set_up_named_as_a_remedy_names_it_is_kept() -> None:
    said = describe_remedy(make_finding("VP033", "no work offset was given: G54"), "a.nc", Run("my INPUT.toml"))
    assert "in my INPUT.toml, which verne-post setup a.nc -o 'my INPUT.toml' --setup 'my INPUT.toml' writes" in said
