"""SARIF, JUnit and GitHub annotations: the same findings in every format, and what each consumer needs of them."""

import json
import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from msgspec.structs import replace

import verne_post
from verne_post.cli.batch import _write_results_json
from verne_post.cli.jobs import Outcome
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding, describe, make_finding, merge_same
from verne_post.model.verdict import find_exit_status
from verne_post.output.batch_table import format_batch
from verne_post.output.code_pages import make_markdown, make_text
from verne_post.output.findings import Report, describe_remedy
from verne_post.output.reports import FORMATS, github, junit, markdown, sarif

PLACE = ("--tool-length", "80", "--wcs", "G54=0,0,50")
TEXTS = {
    "good": "G0 X0 Y0 Z20 A0 C0\nG1 X3 F900\nM2\n",
    "tilt": "G0 X0 Y0 Z120 A0 C0\nG1 A110 F2000\nA112\nM2\n",
    "two words": "G0 X0 Y0 Z20 A0 C0\nG1 X3 Q5 F3000\nG12\nM2\n",
}


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.chdir(tmp_path)
    for name, text in TEXTS.items():
        Path(f"{name}.nc").write_text(text)
    return [f"{name}.nc" for name in TEXTS]


def reported(run: Callable[..., Any], files: list[str], form: str) -> Any:
    answer = run("check", *files, *PLACE, "--output-format", form)
    assert answer.code == 2
    return answer.out


def from_json(run: Callable[..., Any], files: list[str]) -> list[tuple[str, str, int, str]]:
    """File, code, line, message of every finding, by way of the JSON report."""
    data = json.loads(reported(run, files, "json"))
    return sorted((p["program"], f["code"], f["line"], f["message"]) for p in data["programs"] for f in p["findings"])


def test_a_finding_is_the_same_in_every_format(run: Callable[..., Any], files: list[str]) -> None:
    wanted = from_json(run, files)
    assert {code for _file, code, _line, _message in wanted} >= {"VP102", "VP006", "VP002"}
    results = json.loads(reported(run, files, "sarif"))["runs"][0]["results"]
    found = []
    for item in results:
        place = item["locations"][0]["physicalLocation"]
        found.append(
            (
                place["artifactLocation"]["uri"].replace("%20", " "),
                item["ruleId"],
                place["region"]["startLine"],
                item["message"]["text"].partition("\n")[0],
            )
        )
    assert sorted(found) == wanted
    said = {item["ruleId"]: item["message"]["text"].partition("\n")[2] for item in results}
    assert said["VP006"] == f"{CODES['VP006'].title}: {CODES['VP006'].remedy}"
    assert said["VP102"].startswith("tried: line 2 alone: within limits if the line ends at A ")
    annotations = re.findall(
        r"::\w+ file=([^,]*),line=(\d+).*title=(VP\d+) [^:]*::(.*)", reported(run, files, "github")
    )
    told = [(file, code, int(line), *text.partition("%0A")[::2]) for file, line, code, text in annotations]
    assert sorted((file, code, line, text) for file, code, line, text, _remedy in told) == wanted
    remedies = {code: remedy for _file, code, _line, _text, remedy in told}
    assert remedies["VP006"] == CODES["VP006"].remedy
    assert remedies["VP102"].startswith("worst in line 3%0Atried: line 2 alone: within limits if the line ends at A ")
    cases = ElementTree.fromstring(reported(run, files, "junit").encode()).iter("testcase")
    text = "\n".join(node.text or "" for case in cases for node in case)
    for file, code, line, message in wanted:
        assert re.search(rf"{re.escape(file)}:{line}(:\d+)?: {code} error: {re.escape(message)}", text)


def test_sarif_has_what_its_standard_requires(run: Callable[..., Any], files: list[str]) -> None:
    data = json.loads(reported(run, files, "sarif"))
    assert data["version"] == "2.1.0"
    assert data["$schema"].endswith("sarif-2.1.0.json")
    (one,) = data["runs"]
    driver = one["tool"]["driver"]
    assert driver["name"] == "verne-post"
    ids = [rule["id"] for rule in driver["rules"]]
    assert ids == sorted(set(ids))
    for rule in driver["rules"]:
        assert rule["shortDescription"]["text"] == CODES[rule["id"]].title
        assert rule["help"] == {"text": make_text(rule["id"]), "markdown": make_markdown(rule["id"])}
        assert rule["defaultConfiguration"]["level"] in ("error", "warning", "note")
    prints = []
    for item in one["results"]:
        assert driver["rules"][item["ruleIndex"]]["id"] == item["ruleId"]
        assert item["level"] in ("error", "warning", "note")
        place = item["locations"][0]["physicalLocation"]
        assert re.fullmatch(r"[A-Za-z0-9%._/-]+", place["artifactLocation"]["uri"])
        assert place["region"]["startLine"] >= 1
        assert place["region"].get("endLine", 10**9) > place["region"]["startLine"]
        prints += set(item["partialFingerprints"].values())
    assert len(set(prints)) == len(prints)
    tilt = next(item for item in one["results"] if item["ruleId"] == "VP102")
    assert tilt["locations"][0]["physicalLocation"]["region"] == {"startLine": 2, "endLine": 3}
    assert tilt["properties"]["limit"] == 95.0
    assert tilt["properties"]["unit"] == "deg"


def test_fingerprints_stay_when_other_lines_come_and_go(run: Callable[..., Any], files: list[str]) -> None:
    def prints() -> dict[str, str]:
        results = json.loads(reported(run, ["two words.nc"], "sarif"))["runs"][0]["results"]
        return {item["ruleId"]: next(iter(item["partialFingerprints"].values())) for item in results}

    before = prints()
    Path("two words.nc").write_text("(a)\n(b)\n" + TEXTS["two words"].replace("G1 X3 Q5", "g1  x3 q5"))
    assert prints() == before
    Path("two words.nc").write_text(TEXTS["two words"].replace("Q5", "Q6"))
    assert prints()["VP006"] != before["VP006"]
    assert prints()["VP002"] == before["VP002"]


def test_sarif_is_cut_where_hosts_stop_reading() -> None:
    many = tuple(make_finding("VP202", f"m{i}", line=i + 1) for i in range(sarif.MAX_RESULTS)) + (
        make_finding("VP101", "gravest", line=1),
    )
    (one,) = json.loads(sarif.write([Report("a.nc", many)]))["runs"]
    assert len(one["results"]) == sarif.MAX_RESULTS
    texts = [result["message"]["text"].partition("\n")[0] for result in one["results"]]
    assert texts == [
        *(f"m{i}" for i in range(sarif.MAX_RESULTS - 1)),
        "gravest",
    ]  # in their order, the last but one out
    assert "1 further findings" in one["invocations"][0]["toolExecutionNotifications"][0]["message"]["text"]


def test_a_note_about_the_control_is_told_whole_once_a_run_and_named_in_every_program() -> None:
    """Programs with taps printed three lines each; then the second one, with another pitch, none."""
    notes = [f"the control must couple the spindle ({pitch} mm a turn)" for pitch in (1.25, 1.75)]
    tapped = [make_finding("VP047", f"{note}: events have the speed", line=1) for note in notes]
    reports = [Report(name, (item,), source=b"G84 Z-5\n") for name, item in zip(("a.nc", "b.nc"), tapped, strict=True)]
    text = FORMATS["text"](reports, None)
    assert text.splitlines() == [
        f"a.nc:1: VP047 note: {notes[0]}: events have the speed",
        "a.nc: can run: 0 errors, 0 warnings",
        f"b.nc:1: VP047 note: {notes[1]}",
        "b.nc: can run: 0 errors, 0 warnings",
    ]


def test_a_check_of_several_programs_ends_with_their_number(run: Callable[..., Any], files: list[str]) -> None:
    assert reported(run, files, "text").splitlines()[-1] == "3 programs: 1 can run, 2 refused"
    assert " programs: " not in run("check", files[0], *PLACE).out


def test_junit_has_the_time_of_the_check() -> None:
    """A server that shows slow tests would call a long program slow to check."""
    root = ElementTree.fromstring(junit.write([Report("a.nc", (), 3600.0, elapsed_s=0.25)]).encode())
    (case,) = root.iter("testcase")
    assert [one.get("time") for one in (root, case)] == ["0.250", "0.250"]
    assert [one.get("value") for one in case.iter("property")] == ["3600.000"]


def test_junit_counts_failures_and_errors(run: Callable[..., Any], files: list[str]) -> None:
    root = ElementTree.fromstring(reported(run, files, "junit").encode())
    (suite,) = root
    cases = suite.findall("testcase")
    assert [(case.get("name"), [node.tag for node in case]) for case in cases] == [
        ("good.nc", ["properties", "system-out"]),
        ("tilt.nc", ["properties", "failure", "system-out"]),
        ("two words.nc", ["properties", "error"]),
    ]
    of_suite, of_case = (
        {one.get("name"): one.get("value") for one in element.findall("properties/property")}
        for element in (suite, cases[0])
    )
    assert of_suite == {"version": verne_post.__version__}
    assert (of_case.pop("machine"), len(of_case.pop("machine_sha256") or "")) == ("VERNE", 64)
    wanted = json.loads(reported(run, files, "json"))["programs"][0]["summary"]["cycle_time_s"]
    assert of_case == {"machining_time_s": f"{wanted:.3f}"}
    for element in (root, suite):
        assert [element.get(key) for key in ("tests", "failures", "errors")] == ["3", "1", "1"]
    error = cases[2][1]
    assert error.get("type") == "VP006"
    assert "  2 | G1 X3 Q5 F3000\n    |       ^" in (error.text or "")


def test_every_format_says_what_was_not_checked_and_on_which_machine() -> None:
    """A green table read as no collision."""
    text, other = "contact with stock: no [stock] given", verne_post.load_machine("ac_trunnion")
    reports = [Report("a.nc", (), 1.0, unchecked=text), Report("b.nc", (), 1.0, unchecked=text, machine=other)]
    shown = {name: FORMATS[name](reports, verne_post.load_machine("verne")) for name in FORMATS if name != "jsonl"}
    assert "\n\n**NOT CHECKED** in 2 programs: contact with stock: no \\[stock\\] given\n" in shown["markdown"]
    assert shown["github"] == f"::notice title=verne-post::NOT CHECKED in 2 programs: {text}\n"
    (invocation,) = json.loads(shown["sarif"])["runs"][0]["invocations"]
    (note,) = invocation["toolExecutionNotifications"]
    assert note == {"level": "note", "message": {"text": f"NOT CHECKED in 2 programs: {text}"}}
    cases = list(ElementTree.fromstring(shown["junit"].encode()).iter("testcase"))
    assert [case.findtext("system-out") for case in cases] == [f"NOT CHECKED: {text}"] * 2
    machines = [case.find("properties/property[@name='machine']") for case in cases]
    assert [one.get("value") for one in machines if one is not None] == ["VERNE", other.name]


def test_warnings_do_not_fail_a_test_case() -> None:
    xml = junit.write([Report("a.nc", (make_finding("VP202", "near", line=3),))])
    (case,) = ElementTree.fromstring(xml.encode()).iter("testcase")
    assert [node.tag for node in case] == ["system-out"]


def test_odd_characters_survive_every_format() -> None:
    odd = make_finding("VP001", "a\x00b & <c> \u00e4\n50%, x: y", line=1, column=2)
    reports = [Report("d,i:r/\u00e4 %.nc", (odd,), None, b"\x00\xff<&\n")]
    assert ElementTree.fromstring(junit.write(reports).encode()) is not None
    assert json.loads(sarif.write(reports))["runs"][0]["results"][0]["message"]["text"].startswith(f"{odd.message}\n")
    (line,) = github.write(reports).splitlines()
    assert line.startswith("::error file=d%2Ci%3Ar/\u00e4 %25.nc,line=1,col=2,title=VP001 unreadable block::")
    assert line.endswith(f"<c> \u00e4%0A50%25, x: y%0A{CODES['VP001'].remedy}")


def test_github_shows_ten_of_each_level_and_says_how_many_more() -> None:
    many = tuple(make_finding("VP202", f"w{i}", line=i + 1) for i in range(13)) + (make_finding("VP101", "e", line=1),)
    lines = github.write([Report("a.nc", many)]).splitlines()
    assert lines[0].startswith("::error ")
    assert len(lines) == 1 + github.MAX_ANNOTATIONS + 1
    assert "3 further findings" in lines[-1]
    assert github.write([Report("a.nc", ())]) == ""


def test_github_names_the_worst_line_of_a_stretch() -> None:
    """An annotation stands beside one end of the stretch."""
    stretch = make_finding("VP102", "too far", line=3, last_line=9, worst_line=7, count=4, value=96.0)
    one = make_finding("VP102", "too far", line=3, last_line=3, worst_line=3)
    first, second = github.write([Report("a.nc", (stretch,)), Report("b.nc", (one,))]).splitlines()
    assert ",line=3,endLine=9," in first
    assert "::too far%0Aworst in line 7" in first
    assert "worst in line" not in second
    # four times the same word in the text: none is worse than the others
    helped = make_finding("VP101", "too far", line=3, last_line=3, worst_line=3, value=9.0, remedies=("one", "two"))
    (text,) = github.write([Report("a.nc", (helped,))]).splitlines()
    assert "%0Atried: one%0Atried: two%0A`verne-post explain a.nc:3`" in text
    words = make_finding("VP002", "M11 has no meaning", line=14, last_line=64, worst_line=14, count=6)
    (text,) = github.write([Report("a.nc", (words,))]).splitlines()
    assert "::M11 has no meaning%0Alines 14 to 64, 6 times" in text
    assert "worst" not in text


def test_markdown_is_a_table_in_which_no_program_writes_markup(run: Callable[..., Any], files: list[str]) -> None:
    wanted = from_json(run, files)
    text = reported(run, files, "markdown")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert len(rows) == 1 + len(files) + len({file for file, *_more in wanted}) + len(wanted)
    # two cells, or three: a bar inside a cell is escaped
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {3, 4}
    for _file, code, line, _message in wanted:
        assert re.search(rf"^\| {line} \| {code} error: ", text, re.MULTILINE)
    nasty = make_finding("VP006", "@someone #12 | <b>*x*</b> `y`\nz", line=1)
    shown = markdown.write([Report("a|b.nc", (nasty,))])
    assert "| a\\|b.nc | refused: 1 error, 0 warnings |  |" in shown
    assert "@\u2060someone #\u206012 \\| \\<b\\>\\*x\\*\\</b\\> \\`y\\`" in shown


def test_markdown_without_room_has_the_errors_of_all_programs() -> None:
    doubts = tuple(make_finding("VP505", f"doubt {k}: {'x' * 600}", line=k) for k in range(1, 99))
    errors = tuple(make_finding("VP006", f"error {k}", line=k) for k in (7, 8))
    shown = markdown.write([Report("a.nc", (*doubts, *errors[:1])), Report("b.nc", errors[1:])])
    assert len(shown) <= 65_536 and "error 8" in shown
    assert 0 < shown.index("error 7") < shown.index("doubt 1:")
    left_out = 98 - shown.count("doubt ")
    assert left_out > 0 and f"{left_out} further findings" in shown


def test_markdown_says_once_what_a_set_up_settles() -> None:
    """Who reads a comment on a pull request has no terminal with the remedies beside it."""
    lengths = [make_finding("VP012", f"tool {k}", line=k, settled_by=(("tools", f"{k}"),)) for k in (1, 2)]
    rows = markdown.write([Report("my part.nc", (*lengths, make_finding("VP006", "Q", line=3)))]).splitlines()[-3:]
    assert rows[0].endswith(
        "which verne-post setup 'my part.nc' writes. Or give --tool-table FILE, or --tool-length MM where the program "
        "has one tool; the program may set it too (G10 L1, \\$TC\\_DP3, TOOL DEF). |"
    )
    assert [row.count("<br>") for row in rows] == [1, 0, 1]


@pytest.mark.parametrize("code", ["VP049", "VP050"])
def test_markdown_has_the_remedy_of_an_annotation(code: str) -> None:
    report = Report("part.nc", (make_finding(code, "T4", line=3), make_finding(code, "T5", line=9)))
    told, again = markdown.write([report]).splitlines()[-2:]
    remedy = describe_remedy(report.findings[0], "part.nc")
    assert remedy
    assert remedy in github.write([report])
    shown = remedy.replace("[", r"\[").replace("]", r"\]")  # as Markdown has it
    assert told == f"| 3 | {code} warning: T4<br>{shown} |"
    assert again == f"| 9 | {code} warning: T5 |"


def test_markdown_counts_the_programs_by_their_results() -> None:
    refused, warned = make_finding("VP102", "too far", line=1), make_finding("VP203", "near", line=1)
    reports = [Report("a.nc", (refused,)), Report("b.nc", (warned,)), Report("c.nc", ()), Report("d.nc", (refused,))]
    assert "\n\n4 programs: 2 refused, 2 can run\n\n" in markdown.write(reports)


def test_markdown_fits_into_a_comment() -> None:
    many = tuple(make_finding("VP006", "x" * 1000, line=k + 1) for k in range(100))
    shown = markdown.write([Report("a.nc", many), Report("b.nc", many[:1])])
    assert 50_000 < len(shown) < 65_536
    assert (
        int(
            re.search(
                r"^(\d+) further findings",
                shown,
                re.MULTILINE,
            )[1]
        )
        + shown.count("VP006")
        == 101
    )  # type: ignore[index]


@pytest.fixture
def two_programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Programs with set-ups, of which one has a misspelt table, and a machine file with a cycle of a second."""
    monkeypatch.chdir(tmp_path)
    verne = (Path(__file__).resolve().parents[2] / "machine_configs" / "verne.toml").read_text("utf-8")
    Path("bad.toml").write_text(re.sub(r"(?m)^cycle_s = .*$", "cycle_s = 1.0", verne), "utf-8")
    for name, table in (("a", "wcs"), ("b", "wsc"), ("c", "wcs")):
        Path(f"{name}.nc").write_text("G21 G90 G94 G54\nG0 X0 Y0 Z120 A0 C0\nG1 X10 F500\nM2\n", "utf-8")
        Path(f"{name}.nc.toml").write_text(f"tool_length = 120\n# place\n[{table}]\nG54 = [0, 0, 60]\n", "utf-8")
    return tmp_path


def test_mistakes_of_files_stand_in_these_files_at_their_keys(two_programs: Path, run: Callable[..., Any]) -> None:
    """A set-up's table at its line; a suspect value of the machine once, though every program has it."""
    line = Path("bad.toml").read_text("utf-8").split("\n").index("cycle_s = 1.0") + 1
    words = ("check", ".", "--machine", "bad.toml", "--limits-only")
    shown = run(*words).out.splitlines()
    assert [text for text in shown if "VP505" in text] == [
        text for text in shown if text.startswith(f"bad.toml:{line}:1: VP505 warning: control.cycle_s: 1 s is")
    ]
    assert sum("VP505" in text for text in shown) == 1
    assert any(text.startswith("b.nc.toml:3:1: VP503 error: wsc: ") for text in shown)
    commands = run(*words, "--output-format", "github").out.splitlines()
    assert [text.partition("title")[0].rstrip(" ,") for text in commands] == [
        "::error file=b.nc.toml,line=3,col=1",
        f"::warning file=bad.toml,line={line},col=1",
        *["::notice file=a.nc", "::notice file=c.nc"],  # nothing was planned
        "::notice",  # not checked
    ]
    results = json.loads(run(*words, "--output-format", "sarif").out)["runs"][0]["results"]
    places = [one["locations"][0]["physicalLocation"] for one in results if one["level"] != "note"]
    assert [(place["artifactLocation"]["uri"], place["region"]["startLine"]) for place in places] == [
        ("bad.toml", line),
        ("b.nc.toml", 3),
    ]
    Path("bad.toml").write_text(Path("bad.toml").read_text("utf-8").replace("cycle_s = 1.0", "cycle_s = -1.0"), "utf-8")
    (command,) = run(*words, "--output-format", "github").out.splitlines()
    assert command.startswith(f"::error file=bad.toml,line={line},col=1,title=VP501 ")
    (run_of_all,) = json.loads(run(*words, "--output-format", "sarif").out)["runs"]
    (notice,) = run_of_all["invocations"][0]["toolExecutionNotifications"]
    place = notice["locations"][0]["physicalLocation"]
    assert (place["artifactLocation"]["uri"], place["region"]["startLine"]) == ("bad.toml", line)


def draw_findings(seed: int) -> tuple[Finding, ...]:
    """Errors and warnings at random, in a few lines, so that many of them have one cause."""
    rng = random.Random(seed)
    found = []
    for _ in range(rng.randint(0, 15)):
        code = rng.choice(("VP101", "VP102", "VP110", "VP202", "VP210", "VP210", "VP216", "VP301", "VP050", "VP039"))
        level = {"VP050": "warning", "VP039": "note"}.get(code) or rng.choice(("error", "warning"))
        line = rng.randint(1, 9)
        where = {"line": line, "last_line": line + rng.randint(0, 3), "worst_line": line}
        how_far = {} if code in ("VP110", "VP301") else {"value": 40.0, "limit": 50.0, "unit": "mm"}
        found.append(make_finding(code, f"{code} at random", severity=level, **where, **how_far))
    return tuple(found)


def count_shown(text: str, pattern: str) -> tuple[int, int]:
    """How many places of a text name an error, and a warning."""
    return tuple(len(re.findall(pattern.format(level), text, re.MULTILINE)) for level in ("error", "warning"))


@pytest.mark.parametrize("seed", range(60))
def test_a_refused_program_has_errors_and_one_count_in_every_format(seed: int) -> None:
    """A warning hid the error that it was shown with: the program was refused with no error, and JUnit was green."""
    found, machine = draw_findings(seed), verne_post.load_machine()
    report, outcome = Report("a.nc", found), Outcome("a.nc", int(find_exit_status(found)), found)
    form = {name: FORMATS[name]([report], machine) for name in FORMATS}
    listed = json.loads(form["json"])["programs"][0]
    errors, warnings = (listed["summary"][key] for key in ("errors", "warnings"))
    refused = bool(find_exit_status(found))
    assert refused == any(one.severity == "error" for one in found) == (errors >= 1)
    assert listed["verdict"].startswith("refused") == refused
    records = [json.loads(line) for line in form["jsonl"].splitlines()]
    for exact in (listed["findings"], records):
        counted = [one["severity"] for one in exact if one["counted_with"] is None]
        assert (counted.count("error"), counted.count("warning")) == (errors, warnings)
        heads = [exact[one["counted_with"]] for one in exact if one["counted_with"] is not None]
        assert all(head["counted_with"] is None for head in heads)
    said = f"{errors} error{'s' * (errors != 1)}, {warnings} warning{'s' * (warnings != 1)}"
    row = form["markdown"].splitlines()[2]
    assert f": {said}" in form["text"].splitlines()[-1]
    assert f": {said} |" in row
    assert ("refused" in form["text"].splitlines()[-1]) == ("refused" in row) == refused
    assert count_shown(form["text"], r"^a\.nc:\d+: VP\d+ {}: ") == (errors, warnings)
    assert count_shown(form["markdown"], r"^\| \d+ \| VP\d+ {}: ") == (errors, warnings)
    assert count_shown(form["github"], "^::{} file=") == (errors, warnings)
    levels = [one["level"] for one in json.loads(form["sarif"])["runs"][0]["results"]]
    assert (levels.count("error"), levels.count("warning")) == (errors, warnings)
    suite = ElementTree.fromstring(form["junit"].partition("?>")[2])
    assert int(suite.get("failures", "")) + int(suite.get("errors", "")) == refused
    assert count_shown(form["junit"], r"a\.nc:\d+: VP\d+ {}: ") == (errors, warnings)
    quiet = FORMATS["text"]([replace(report, shown=tuple(one for one in found if one.severity == "error"))], machine)
    assert count_shown(quiet, r"^a\.nc:\d+: VP\d+ {}: ") == (errors, 0)
    written = json.loads(_write_results_json([outcome], [report]))["programs"][0]
    assert (written["errors"], written["warnings"]) == (errors, warnings)
    table = format_batch([outcome], is_brief=True).splitlines()[1]
    assert ("refused" in table) == refused
    named = ", ".join(word for word in said.split(", ") if not word.startswith("0"))
    assert f"  {named}: VP" in table if named else "VP" not in table


def test_one_mistake_in_two_lines_marks_no_line_between_them() -> None:
    """VP014 of lines 8 and 11 marked lines 9 and 10 in a pull request, which have no mistake."""
    found = merge_same(make_finding("VP014", "T2 M6 waits", line=line, last_line=line) for line in (11, 8, 11, 12))
    assert [(one.line, one.last_line, one.count, one.lines) for one in found] == [(11, 12, 4, (8, 11, 12))]
    assert describe(found[0]).endswith("T2 M6 waits (lines 8 and 11 to 12, 4 times)")
    [one] = merge_same(make_finding("VP014", "T2 M6 waits", line=line, last_line=line) for line in (8, 11))
    annotation = github.write([Report("a.nc", (one,))])
    assert annotation.startswith("::error file=a.nc,line=8,title=")
    assert "%0Alines 8 and 11, 2 times%0A" in annotation
    [result] = json.loads(sarif.write([Report("a.nc", (one,))]))["runs"][0]["results"]
    assert result["locations"][0]["physicalLocation"]["region"] == {"startLine": 8}
    assert [one["physicalLocation"]["region"] for one in result["relatedLocations"]] == [{"startLine": 11}]
    assert result["message"]["text"].splitlines()[1] == "in lines 8 and 11"
    [twice] = merge_same(make_finding("VP014", "T2 M6 waits", line=line, last_line=line) for line in (8, 8))
    assert (twice.lines, twice.count) == ((), 2)
    many = merge_same(make_finding("VP014", "waits", line=line, last_line=line) for line in range(2, 42, 2))
    assert describe(many[0]).endswith("(lines 2, 4, 6, 8, 10, 12 and 14 more, 20 times)")
