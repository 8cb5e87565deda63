"""Which findings count: codes, severities, baselines; from options, the environment and files, in that order."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verne_post.config import list_machine_files

#: VP101 in line 3, and VP202 warnings: near the level rod.
BEYOND = "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 Z680 F3000\nM2\n"


@pytest.fixture
def job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, ...]:
    monkeypatch.chdir(tmp_path)
    for name in ("SELECT", "IGNORE", "FAIL_LEVEL", "BASELINE"):
        monkeypatch.delenv(f"VERNE_POST_{name}", raising=False)
    Path("p.nc").write_text(BEYOND)
    return ("check", "p.nc", "--tool-length", 60, "--wcs", "G54=0,0,20")


@pytest.fixture
def warned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, ...]:
    """A program with nothing but warnings: on a machine whose rods are warned of early."""
    monkeypatch.chdir(tmp_path)
    text = (
        list_machine_files()["verne"]
        .read_text()
        .replace("serial_singularity_mm = 100.0", "serial_singularity_mm = 400.0")
    )
    Path("m.toml").write_text(text)
    Path("w.nc").write_text("G21 G90\nG0 X0 Y0 Z60 A0 C0\nG1 X20 F3000\nM2\n")
    return ("check", "w.nc", "--tool-length", 60, "--wcs", "G54=0,0,0", "--machine", "m.toml")


def test_ignored_codes_do_not_count_and_are_counted(job: tuple[Any, ...], run: Callable[..., Any]) -> None:
    assert run(*job).code == 1
    answer = run(*job, "--ignore", "VP101")
    assert answer.code == 0
    assert "VP101" not in answer.out
    assert "ignored; convert refuses the errors among them all the same." in answer.out
    assert run(*job, "--ignore", "VP1").code == 0
    assert run(*job, "--select", "VP2,VP3").code == 0
    assert run(*job, "--select", "VP1").code == 1
    # whatever check ignores, convert refuses
    assert run("convert", *job[1:]).code == 1


@pytest.mark.parametrize(
    ("words", "lacks"),
    [(("--ignore", "VP101"), "2 errors do not count"), (("--limits-only", "--ignore", "VP4"), "nothing was planned")],
)
def test_what_is_not_wholly_checked_is_not_said_to_run(
    job: tuple[Any, ...], run: Callable[..., Any], words: tuple[str, ...], lacks: str
) -> None:
    if "--limits-only" in words:
        Path("p.nc").write_text(BEYOND.replace("Z680", "Z60"))
    # the note that nothing was planned stays, whatever is ignored
    assert f"p.nc: not refused on VERNE, {lacks}: 0 errors" in run(*job, *words).out
    told = json.loads(run(*job, *words, "--output-format", "json").out)
    assert told["programs"][0]["verdict"] == "not refused"
    refused = run(*job, "--ignore", "VP421")
    assert refused.code == 2
    assert "VP421: says that the program was not planned, always" in refused.err


def test_ignored_warnings_are_not_called_refused(warned: tuple[Any, ...], run: Callable[..., Any]) -> None:
    answer = run(*warned, "--ignore", "VP202")
    assert "Not counted: 1 finding ignored.\n" in answer.out


@pytest.mark.parametrize("name", ["text", "markdown", "github", "junit", "sarif"])
def test_every_format_says_how_many_findings_do_not_count(
    warned: tuple[Any, ...], run: Callable[..., Any], name: str
) -> None:
    """A green check of a host was nothing but ignored warnings."""
    said = "Not counted: 1 finding ignored"
    assert said not in run(*warned, "--output-format", name).out
    assert run(*warned, "--ignore", "VP202", "--output-format", name).out.count(said) == 1
    # of several programs it is the sum; JUnit has a test case for each
    shutil.copy(warned[1], "again.nc")
    told = run(*warned, "again.nc", "--ignore", "VP202", "--output-format", name).out
    assert told.count(said) == (2 if name == "junit" else 0)
    assert told.count("Not counted: 2 findings ignored") == (0 if name == "junit" else 1)
    assert "Not counted" not in run(*warned, "again.nc", "--ignore", "VP202", "-q").out


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program, and a subprogram that no program of the folder calls."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p" / "lib").mkdir(parents=True)
    (tmp_path / "p" / "a.nc").write_text("G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 Z20 F2000\nM2\n")
    (tmp_path / "p" / "lib" / "O1234.nc").write_text("O1234\nG91 G1 X5\nG90\nM99\n")
    return tmp_path


@pytest.mark.parametrize(
    ("words", "settings"),
    [
        (("--exclude", "lib"), ""),
        (("--exclude", "lib/*.nc"), ""),
        (("--exclude", "p/lib"), ""),  # as findings name it
        (("--exclude", "**/O*.nc"), ""),
        ((), 'exclude = ["p/lib"]'),  # from the folder of the settings file
    ],
)
def test_excluded_files_refuse_nothing(
    folder: Path, run: Callable[..., Any], words: tuple[str, ...], settings: str
) -> None:
    options = ("--tool-length", "60", "--wcs", "G54=0,0,20", "--limits-only")
    assert run("check", "p", *options).code == 2
    Path("verne-post.toml").write_text(f"[check]\n{settings}\n")
    answer = run("check", "p", *options, *words)
    assert answer.code == 0
    assert answer.out.endswith("not checked: 1 file excluded\n")
    assert "matches no file" not in answer.err
    # a file that is named is checked all the same
    named = ("check", "p/lib/O1234.nc", *options, *(("--exclude", "p/lib") if words else ()))
    assert run(*named).code == 2


def test_patterns_that_exclude_nothing_or_all_are_named(folder: Path, run: Callable[..., Any]) -> None:
    Path("verne-post.toml").write_text('[check]\nexclude = ["old"]\n')
    answer = run("check", "p", "--exclude", "none", "--limits-only")
    assert "--exclude none: matches no file\n" in answer.err
    assert "verne-post.toml: check.exclude old: matches no file\n" in answer.err
    for command in (("check",), ("batch", "-o", "out")):
        answer = run(*command, "p", "--exclude", "*")
        assert answer.code == 2
        assert "every program is excluded, by --exclude *" in answer.err


def test_a_link_is_excluded_by_its_own_name_alone(folder: Path, run: Callable[..., Any]) -> None:
    Path("p/own.nc").symlink_to(Path("p/lib/O1234.nc").absolute())
    answer = run("check", "p", "--exclude", "lib", "--limits-only")
    assert str(Path("p/own.nc")) in answer.out
    assert "\nnot checked: 1 file excluded\n" in answer.out


def test_reports_of_a_run_without_programs_are_empty(folder: Path, run: Callable[..., Any]) -> None:
    """What the run before had found was uploaded again."""
    Path("s.sarif").write_text("of the run before")
    job = ("check", "--changed", "p/a.nc", "--exclude", "p/*")
    answer = run(*job, "--sarif", "s.sarif", "--output-format", "json")
    assert (answer.code, json.loads(answer.out)["programs"]) == (0, [])
    assert json.loads(Path("s.sarif").read_text())["runs"][0]["results"] == []
    assert run(*job).out == ""


def test_batch_leaves_excluded_files_out(folder: Path, run: Callable[..., Any]) -> None:
    answer = run("batch", "p", "-o", "out", "-j", "1", "--tool-length", "60", "--wcs", "G54=0,0,20", "--exclude", "lib")
    assert answer.code == 0
    assert "not checked: 1 file excluded\n" in answer.err
    assert [one.name for one in Path("out").rglob("*.csv")] == ["a.csv"]


def test_json_has_the_numbers_of_findings_that_do_not_count(job: tuple[Any, ...], run: Callable[..., Any]) -> None:
    run(*job, "--write-baseline", "known.json")
    numbers = []
    for words in (("--ignore", "VP101"), ("--baseline", "known.json")):
        (told,) = json.loads(run(*job, *words, "--output-format", "json").out)["programs"]
        numbers.append([told["summary"][key] for key in ("errors", "ignored", "known")])
    assert numbers == [[0, 2, 0], [0, 0, 2]]


def test_severities(warned: tuple[Any, ...], run: Callable[..., Any]) -> None:
    plain = run(*warned)
    assert plain.code == 0
    assert "VP202 warning" in plain.out
    assert run(*warned, "--fail-level", "warning").code == 1
    raised = run(*warned, "--severity", "VP202=error")
    assert raised.code == 1
    assert "VP202 error" in raised.out
    assert run(*warned, "--severity", "VP2=note", "--fail-level", "warning").code == 0
    # the longer beginning decides
    assert run(*warned, "--severity", "VP2=note", "--severity", "VP202=error").code == 1


def test_warnings_that_fail_are_said_to(warned: tuple[Any, ...], run: Callable[..., Any], tmp_path: Path) -> None:
    level = ("--fail-level", "warning")
    plain = run(*warned, *level)
    assert "w.nc: refused: 0 errors, 1 warning (--fail-level warning)" in plain.out
    quiet = run(*warned, *level, "-q")
    assert quiet.code == 1
    assert "VP202 warning" in quiet.out
    assert "(--fail-level warning)" in quiet.out
    assert run(*warned, "-q").out == ""
    (tmp_path / "e.nc").write_text(Path(warned[1]).read_text("utf-8").replace("M2", "G53 G0 Z2000\nM2"), "utf-8")
    for options in ((), level):  # an error beside it hides no warning from the count, nor from those that it fails
        both = run(warned[0], tmp_path / "e.nc", *warned[2:], *options, "-q").out
        assert "e.nc: refused: 1 error, 1 warning" in both
        assert ("VP202 warning" in both) == bool(options)
    told = json.loads(run(*warned, *level, "--output-format", "json").out)
    assert told["programs"][0]["verdict"] == "refused: warnings fail"
    table = run(*warned, *level, "--output-format", "markdown").out
    assert "| refused: 0 errors, 1 warning (--fail-level warning) |" in table
    assert "1 program: 1 refused" in table
    log = run(*warned, *level, "--output-format", "github").out.splitlines()
    assert log[0].startswith("::warning ")
    assert log[-1] == "::error title=verne-post::w.nc: refused: 0 errors, 1 warning (--fail-level warning)"
    cases = run(*warned, *level, "--output-format", "junit").out
    assert 'failures="1"' in cases
    assert 'failures="0"' in run(*warned, "--output-format", "junit").out


def test_option_environment_file(
    warned: tuple[Any, ...], run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("pyproject.toml").write_text('[tool.other]\nx = 1\n[tool.verne-post.check]\nfail_level = "warning"\n')
    assert run(*warned).code == 1
    Path("verne-post.toml").write_text('[check]\nfail_level = "error"\n')  # the nearer of two in one folder
    assert run(*warned).code == 0
    monkeypatch.setenv("VERNE_POST_FAIL_LEVEL", "warning")
    assert run(*warned).code == 1
    assert run(*warned, "--fail-level", "error").code == 0
    monkeypatch.setenv("VERNE_POST_IGNORE", "VP202")
    assert run(*warned).code == 0
    Path("verne-post.toml").write_text('[check]\nseverity = {VP202 = "error"}\n')
    monkeypatch.delenv("VERNE_POST_IGNORE")
    assert run(*warned).code == 1


def test_a_baseline_lets_old_findings_be_and_new_ones_count(job: tuple[Any, ...], run: Callable[..., Any]) -> None:
    assert run(*job, "--write-baseline", "known.json").code == 1
    assert "p.nc:3: VP101" in Path("known.json").read_text()
    answer = run(*job, "--baseline", "known.json")
    assert answer.code == 0
    assert "in the baseline" in answer.out
    # lines that come before change nothing; another mistake counts
    Path("p.nc").write_text("(a remark)\n" + BEYOND)
    assert run(*job, "--baseline", "known.json").code == 0
    Path("p.nc").write_text(BEYOND.replace("M2", "X30\nM2"))
    assert run(*job, "--baseline", "known.json").code == 1
    Path("verne-post.toml").write_text('[check]\nbaseline = "known.json"\n')
    Path("p.nc").write_text(BEYOND)
    assert run(*job).code == 0
    for text, why in (("[]", "expected an object with the keys"), ('{"schema": 1}', "its key 'known' is missing")):
        Path("known.json").write_text(text)
        answer = run(*job)
        assert answer.code == 2
        assert f"known.json: not a baseline that check has written: {why}" in answer.err


@pytest.mark.parametrize("written", ["jobs/../jobs/p.nc", "{}/jobs/p.nc"])
def test_a_baseline_holds_from_every_folder(
    job: tuple[Any, ...], run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, written: str
) -> None:
    """Whichever folder the command is started in, and however the program is written; another p.nc is another one."""
    root, options = Path.cwd(), (*job[2:], "--limits-only")
    Path("jobs").mkdir()
    Path("jobs/p.nc").write_text(BEYOND)
    Path("verne-post.toml").write_text('[check]\nbaseline = "known.json"\n')
    Path("none.toml").write_text("")
    run("check", written.format(root), *options, "--settings", "none.toml", "--write-baseline", "known.json")
    assert '": "jobs/p.nc:3: VP101' in Path("known.json").read_text()
    for folder, name, code in (
        (root / "jobs", "p.nc", 0),
        (root.parent, f"{root.name}/jobs/p.nc", 0),
        (root, "p.nc", 1),
    ):
        monkeypatch.chdir(folder)
        assert run("check", name, *options).code == code, (folder, name)


def test_a_baseline_that_is_moved_counts_from_where_its_programs_are(
    job: tuple[Any, ...], run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One on standard input counts from the current folder. A program of the same name elsewhere is another one."""
    root = Path.cwd()
    for name in ("build", "other"):
        Path(name).mkdir()
    run(*job, "--write-baseline", "build/b.json")
    run(*job, "--write-baseline", "b.json")
    text = Path("build/b.json").read_bytes()
    Path("moved.json").write_bytes(text)
    Path("other/p.nc").write_text(BEYOND)
    anew = "where they or it have been moved, write it anew\n"
    several = f"../moved.json: several folders have its programs, {root} and {root / 'other'}; {anew}"
    for folder, baseline, code, said in (
        (".", "build/b.json", 0, ""),
        (".", "-", 0, ""),
        (".", "moved.json", 0, f"moved.json has been moved: its paths count from {root}\n"),
        ("other", "../build/b.json", 1, ""),
        ("other", "../moved.json", 1, several),
    ):
        monkeypatch.chdir(root / folder)
        answer = run(*job, "--baseline", baseline, stdin=text)
        assert (answer.code, answer.err) == (code, said)
    (root / "p.nc").unlink()
    answer = run(*job, "--baseline", "../b.json")  # it has not been moved
    assert (answer.code, answer.err) == (1, f"../b.json: its programs are gone, such as {root / 'p.nc'}; {anew}")


@pytest.mark.parametrize(
    ("written", "moves", "folder", "baseline", "told"),
    [
        ("b.json", [("b.json", "ci/b.json")], ".", "ci/b.json", True),
        ("b.json", [("b.json", "ci/known/b.json")], "jobs", "../ci/known/b.json", True),
        ("b.json", [("b.json", "../{root.name}.json")], ".", "../{root.name}.json", True),
        ("../{root.name}.json", [("../{root.name}.json", "ci/b.json")], "ci", "b.json", True),
        ("ci/b.json", [("ci", "jobs/ci")], ".", "jobs/ci/b.json", True),
        ("ci/b.json", [("ci/b.json", "b.json")], "ci", "../b.json", True),
        ("jobs/b.json", [("jobs", "parts")], ".", "parts/b.json", False),
        ("b.json", [("jobs", "new/jobs"), ("b.json", "new/b.json")], "ci", "../new/b.json", False),
    ],
)
def test_whatever_is_moved_the_programs_of_a_baseline_are_found(
    job: tuple[Any, ...],
    run: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    written: str,
    moves: list[tuple[str, str]],
    folder: str,
    baseline: str,
    told: bool,
) -> None:
    """Whether it is told from where the paths count: not where nothing else has changed its place."""
    root, options = Path.cwd(), (*job[2:], "--limits-only")
    for name in ("jobs", "ci/known", "new"):
        Path(name).mkdir(parents=True)
    shutil.copy("p.nc", "jobs/p.nc")
    Path("p.nc").unlink()
    run("check", root / "jobs" / "p.nc", *options, "--write-baseline", written.format(root=root))
    for old, new in moves:
        Path(old.format(root=root)).rename(new.format(root=root))
    (program,) = root.rglob("p.nc")
    monkeypatch.chdir(root / folder)
    name = baseline.format(root=root)
    answer = run("check", program, *options, "--baseline", name)
    moved = f"{name} has been moved: its paths count from {root}\n" if told else ""
    assert (answer.code, answer.err) == (0, moved)


@pytest.mark.parametrize("by", ["option", "settings", "environment"])
def test_a_baseline_is_written_in_place_of_the_one_that_is_read(
    job: tuple[Any, ...], run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, by: str
) -> None:
    """What the old one exempts is in the new one, ignored or not; the old one need not be there."""
    job = (*job, "--limits-only", *(("--baseline", Path("known.json").absolute()) if by == "option" else ()))
    if by == "settings":
        Path("verne-post.toml").write_text('[check]\nbaseline = "known.json"\n')
    elif by == "environment":
        monkeypatch.setenv("VERNE_POST_BASELINE", "./known.json")
    answer = run(*job, "--write-baseline", "known.json")
    assert answer.code == 1
    assert "known.json: written, 2 known findings\n" in answer.err
    Path("p.nc").write_text(BEYOND.replace("M2", "X30\nM2"))
    for words, said in (
        (("--ignore", "VP1"), "3 known findings, with 2 of the 2 known before\n"),
        ((), "3 known findings, with 3 of the 3 known before\n"),
    ):
        answer = run(*job, *words, "--write-baseline", "known.json")
        assert answer.code == 0
        assert f"known.json: written, {said}" in answer.err
    Path("p.nc").write_text(BEYOND)
    answer = run(*job, "--write-baseline", "known.json")
    assert "2 known findings, with 2 of the 3 known before" in answer.err
    assert run(*job).code == 0


def test_a_baseline_that_is_not_there_is_refused_unless_one_is_written(
    job: tuple[Any, ...], run: Callable[..., Any]
) -> None:
    none = (*job, "--limits-only", "--baseline", "none.json")
    assert "--baseline none.json: No such file" in run(*none).err
    answer = run(*none, "--write-baseline", "known.json")
    assert answer.code == 1
    assert "none.json: not there; no finding is known yet\nknown.json: written, 2 known findings\n" in answer.err
    assert not Path("none.json").exists()
    assert (
        "this is the file of --baseline"
        in run(*none, "--write-baseline", "known.json", "--output-file", "none.json").err
    )


def test_a_baseline_of_the_older_layout_has_programs_as_they_were_named(
    job: tuple[Any, ...], run: Callable[..., Any]
) -> None:
    """Standard output is in no folder: its baseline has this layout too."""
    older = run(*job, "--write-baseline", "-", "--output-file", "found.txt").out
    assert json.loads(older)["schema"] == 1
    Path("known.json").write_text(older)
    assert run(*job, "--baseline", "known.json").code == 0
    assert run("check", "./p.nc", *job[2:], "--baseline", "known.json").code == 0
    assert run("check", Path("p.nc").absolute(), *job[2:], "--baseline", "known.json").code == 1


def test_what_cannot_be_read_cannot_be_ignored(job: tuple[Any, ...], run: Callable[..., Any]) -> None:
    Path("p.nc").write_text("G21 G90\nG1 X\nM2\n")
    assert run(*job, "--select", "VP3").code == 2
    for words in (("--ignore", "VP0"), ("--ignore", "VP"), ("--severity", "VP0=note")):
        answer = run(*job, *words)
        assert answer.code == 2
        assert "VP001 error" in answer.out
    Path("verne-post.toml").write_text('[check]\nignore = ["VP001"]\n')
    answer = run(*job)
    assert answer.code == 2
    assert "check ignores" not in answer.err
    assert "cannot be read or checked are errors" in answer.err
    Path("verne-post.toml").unlink()
    for words in (("--ignore", "VP001"), ("--severity", "VP001=note")):
        answer = run(*job, *words)
        assert answer.code == 2
        assert "cannot be read or checked are errors" in answer.err


def test_warnings_about_a_text_are_ignored_weighed_and_known(run: Callable[..., Any], job: tuple[Any, ...]) -> None:
    Path("p.nc").write_text("G21 G90\nG0 X0 Y0 Z60 A0 C0\nG1 X10 F600\nM2\n")
    job = job[:4]  # nobody has placed G54: VP033
    strict = (*job, "--fail-level", "warning")
    assert "VP033 warning" in run(*strict).out
    assert run(*strict).code == 1
    others = sorted({line.split()[1] for line in run(*strict).out.splitlines() if " warning: " in line})
    assert run(*strict, "--ignore", ",".join(others)).code == 0
    assert run(*strict, *(word for code in others for word in ("--severity", f"{code}=note"))).code == 0
    raised = run(*job, "--severity", "VP033=error")
    assert (raised.code, "VP033 error" in raised.out) == (2, True)
    written = run(*strict, "--write-baseline", "known.json")
    assert f"known.json: written, {len(others)} known finding" in written.err
    assert "without" not in written.err
    assert run(*strict, "--baseline", "known.json").code == 0
    Path("verne-post.toml").write_text('[check]\nignore = ["VP033"]\n')
    answer = run(*job)
    assert (answer.code, "check ignores VP033" in answer.err, "VP033" in answer.out) == (0, True, False)


def test_a_baseline_leaves_out_errors_of_the_text_and_says_so(run: Callable[..., Any], job: tuple[Any, ...]) -> None:
    Path("p.nc").write_text("G21 G90\nG1 X\nM2\n")
    answer = run(*job, "--write-baseline", "known.json")
    assert "known.json: written, 0 known findings, without 1 error that cannot be ignored" in answer.err
    assert run(*job, "--baseline", "known.json").code == 2


def test_a_baseline_of_another_layout_is_refused(job: tuple[Any, ...], run: Callable[..., Any]) -> None:
    Path("b.json").write_text('{"schema": 3, "known": []}')
    answer = run(*job, "--baseline", "b.json")
    assert answer.code == 2
    assert "its layout is 3, this version reads 1 and 2" in answer.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--ignore", "VP7"), "'VP7' is no code"),
        (("--select", "X1"), "'X1' is no code"),
        (("--severity", "VP202"), "expected CODE=error"),
        (("--severity", "VP202=bad"), "expected CODE=error"),
    ],
)
def test_bad_policies(job: tuple[Any, ...], run: Callable[..., Any], words: tuple[str, ...], said: str) -> None:
    answer = run(*job, *words)
    assert answer.code == 2
    assert said in answer.err


def test_an_error_shows_its_line_and_what_helps(job: tuple[Any, ...], run: Callable[..., Any]) -> None:
    out = run(*job).out
    assert "  3 | G1 Z680 F3000" in out
    assert "= tried: within limits if the part is moved by 0, 0, " in out
    assert (
        "`verne-post explain p.nc:3 --tool-length 60 --wcs G54=0,0,20` explains this line and what would bring it"
        in out
    )


def test_one_finding_a_line(job: tuple[Any, ...], run: Callable[..., Any]) -> None:
    rows = [json.loads(line) for line in run(*job, "--output-format", "jsonl").out.splitlines()]
    whole = json.loads(run(*job, "--output-format", "json").out)["programs"][0]["findings"]
    assert [{key: value for key, value in row.items() if key != "program"} for row in rows] == whole
    assert {row["program"] for row in rows} == {"p.nc"}


def test_a_selection_under_which_no_error_of_a_motion_counts_is_refused(
    job: tuple[Any, ...], run: Callable[..., Any]
) -> None:
    """Codes of VP9 are errors with any setting: such a selection would only leave all others out."""
    answer = run(*job, "--select", "VP9")
    assert answer.code == 2
    assert "select: VP9: programs that cannot be read or checked are errors, always; nothing else would" in answer.err
