"""What a machinist reads on the console: what helps in this case, numbers with their units, one order of findings."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import verne_post
from verne_post.gcode.known_words import describe_word
from verne_post.model.options import Options
from verne_post.model.verdict import ExitStatus

HEAD = "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nS3000 M3\nG0 X0. Y0.\nG43 H1 Z150.\n"
SETUP = "[tools]\n1 = { length = 80 }\n[wcs]\nG54 = [0, 0, 60]\n"


@pytest.fixture
def make_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """A program with its set-up, in a folder of its own, which is the current one."""
    monkeypatch.chdir(tmp_path)

    def make(body: str, name: str = "part.nc", setup: str = SETUP) -> Path:
        path = Path(name)
        path.write_text(f"%\nO1\n{HEAD}{body}\nM30\n%\n", encoding="utf-8")
        if setup:
            Path(f"{name}.toml").write_text(setup, encoding="utf-8")
        return path

    return make


def test_a_third_reference_position_is_not_sent_to_the_machine_file(make_program: Any, run: Any) -> None:
    answer = run("check", make_program("G91 G30 P3 Z0."))
    assert "Write G53 G0 with the machine coordinates of this position (parameter 1242 of the control)" in answer.out
    assert "[home]" not in answer.out


def test_a_fixed_point_beyond_the_second_is_not_sent_to_the_machine_file(tmp_path: Path, run: Any) -> None:
    part = tmp_path / "part.mpf"
    part.write_text("G54 G90 G710 D1\nG0 X0 Y0 Z50\nG75 FP=3 Z=0\nM30\n", encoding="utf-8")
    answer = run("check", part, "--tool-length", 80, "--wcs", "G54=0,0,60")
    assert "Write SUPA G0 with the machine coordinates of this point (MD30600" in answer.out


def test_times_have_no_exponent(make_program: Any, run: Any) -> None:
    answer = run("check", make_program("G4 X60000.\nG4 X60000.\nG1 Z120. F500."))
    assert "the program takes 1 day 9 h, in rows of 0.001 s; --max-rows allows 100000000 rows, 1 day 4 h" in answer.out
    assert "the longest line takes 16 h 40 min" in answer.out
    assert "a dwell of 104 days 4 h: more than a day is a mistake" in run("check", make_program("G4 X9000000.")).out


def test_findings_stand_by_their_lines_everywhere(tmp_path: Path, run: Any) -> None:
    part = tmp_path / "part.mpf"
    part.write_text(
        'G54 G90 G710\nT="MILL"\nM6 D1\nG0 X0 Y0 Z90\nT="DRILL"\nM6\nFOO=3\nG55\nG0 Z91\nM30\n', encoding="utf-8"
    )
    text = [
        int(line.split(":")[1])
        for line in run("check", part).out.splitlines()
        if line.startswith(f"{part}:") and line.split(":")[1].isdecimal()
    ]
    found = json.loads(run("check", part, "--output-format", "json").out)["programs"][0]["findings"]
    sarif = json.loads(run("check", part, "--output-format", "sarif").out)["runs"][0]["results"]
    places = [one["locations"][0]["physicalLocation"]["region"]["startLine"] for one in sarif]
    lines = [one["line"] for one in found]
    assert {one["severity"] for one in found} == {"error", "warning"}
    for order in (text, lines, places):
        assert len(order) > 3 and order == sorted(order)


def test_verify_names_the_file_that_is_wrong(make_program: Any, run: Any) -> None:
    good, wrong = make_program("G1 Z120. F500."), make_program("G1 Z120. F500. K[", "wrong.nc")
    assert run("convert", good, "-o", "axes.csv").code == 0
    assert run("verify", "axes.csv", "--against", wrong).err.startswith("wrong.nc:9")
    swapped = run("verify", good, "--against", "axes.csv").err
    assert swapped.startswith("axes.csv: VP022 error: axes.csv is a setpoint file, not a program; verify and machined")
    Path("note.pdf").write_text("")
    assert run("verify", "axes.csv", "--against", "note.pdf").err.startswith("note.pdf: VP022")


def test_files_that_are_of_another_kind_or_program_are_sent_where_they_belong(make_program: Any, run: Any) -> None:
    part = make_program("G1 Z120. F500.", setup="")
    assert run("machine", "show", "verne").code == 0
    Path("machine.toml").write_text(run("machine", "show", "verne").out, encoding="utf-8")
    answer = run("check", part, "--setup", "machine.toml")
    assert [line for line in (answer.out + answer.err).splitlines() if "VP503" in line] == [
        "machine.toml: VP503 error: this is a machine file, not a set-up; give it with --machine"
    ]
    Path("mine.toml").write_text(SETUP.replace("1 =", "7 ="), encoding="utf-8")
    answer = run("check", part, "--machine", "mine.toml")
    assert (
        "mine.toml: VP501 error: this is a set-up, not a machine file; give it with --setup" in answer.out + answer.err
    )
    assert "If mine.toml belongs to another program, leave it" in run("check", part, "--setup", "mine.toml").out
    Path("part.nc.toml").write_text(SETUP.replace("1 =", "7 ="), encoding="utf-8")
    assert "belongs to another" not in run("check", part).out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("check part.nc --setup chain.toml", "chain.toml: VP503 error: this is a machine file, not a set-up; give"),
        ("check part.nc --setup part.nc", "--setup part.nc: this is a program, not a set-up; give it first on"),
        ("check part.nc --machine part.nc", "part.nc: VP501 error: this is a program, not a machine file; give it"),
        ("machine validate a.stl", "a.stl: VP501 error: this is an STL model, not a machine file; name it in the"),
        ("machine validate s.toml", "s.toml: VP501 error: this is a settings file, not a machine file; give it"),
        ("machine check chain.toml", "did you mean `verne-post machine validate chain.toml`?"),
        ("check a.stl", "a.stl: VP022 error: a.stl is an STL model, not a program; name it in the set-up, as nominal"),
        (
            "check chain.toml",
            "chain.toml: VP022 error: chain.toml is a machine file, not a program; give",
        ),
        ("check part.nc --settings chain.toml", "this is a machine file, not a settings file; give it with --machine"),
        ("check part.nc --settings u.toml", "this is a set-up, not a settings file; give it with --setup"),
        ("check part.nc --tool-table u.toml", "either: this is a set-up, not a tool table; give"),
        ("check part.nc --tool-table l.csv", "either: this is a file of tool lengths, not a tool table; give"),
        ("check part.nc --tool-lengths part.nc", "this is a program, not a file of tool lengths; give it first"),
        ("check part.nc --tool-lengths k.h", "this is a program, not a file of tool lengths; give it first"),
        ("check part.nc --tool-lengths t.tbl", "this is a tool table, not a file of tool lengths; give it with"),
        ("check part.nc --tool-lengths rows.csv", "this is a setpoint file, not a file of tool lengths; verify and"),
        ("check part.nc --measured-offset l.csv", "this is a file of tool lengths, not a file of work offsets; give"),
        ("check part.nc --measured-offset part.nc", "this is a program, not a file of work offsets; give it first"),
        ("check part.nc --parameters part.nc", "no other line has one either: this is a program, not a parameter"),
        ("check part.nc --setup stl.toml", "it is no STL file: this is a program, not an STL model; give it first"),
    ],
)
def test_a_file_in_the_place_of_another_kind_is_named(make_program: Any, run: Any, words: str, said: str) -> None:
    make_program("G1 Z120. F500.")
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    Path("a.stl").write_text(f"solid a\n{facet}endsolid a\n")
    Path("s.toml").write_text('machine = "verne"\n')
    Path("k.h").write_text("0 BEGIN PGM A MM\n1 END PGM A MM\n")
    Path("t.tbl").write_text("; tools\nT1 P1 Z80\n")
    Path("l.csv").write_text("tool,length_mm\n1,80\n")
    Path("rows.csv").write_text("t_s,rho1_mm\n0,1\n")
    Path("u.toml").write_text(SETUP)
    Path("stl.toml").write_text(f'{SETUP}\n[keep_out.vise]\nfile = "part.nc"\n')
    Path("chain.toml").write_text(run("machine", "show", "ac_trunnion").out, encoding="utf-8")
    answer = run(*words.split())
    assert said in answer.out + answer.err


def test_a_header_without_columns_is_one_finding(tmp_path: Path, run: Any) -> None:
    readings = tmp_path / "readings.csv"
    names = "rho1_mm,rho2_mm,rho3_mm,a_deg,c_deg,tool_length_mm,x_mm,y_mm,z_mm"
    for text, told in (
        ("q_s,line,rho1_mm,rho2_mm,rho3_mm,a_deg,c_deg\n", ("'q_s' and 'line' are", "x_mm, y_mm and z_mm are")),
        ("%\nO1\n", ("no file of readings: no column of",)),
        ("t_s,x_mm,line\n0,1,2\n", ("this is a setpoint file, not a file of readings; verify and machined read it",)),
        ("rho1_mm;x_mm\n1;2\n", ("the names in its first line have ; between them; write commas",)),
        (f"{names}\n" + "1,2\n" * 6, ("2 values; expected 9, as many as the header in line 1 names (lines 2 to 7, 6",)),
    ):
        readings.write_text(text, encoding="utf-8")
        answer = run("machine", "calibrate", readings, "-o", tmp_path / "x.toml")
        found = [line for line in answer.err.splitlines() if "VP502" in line]
        assert len(found) == len(told)
        for line, part in zip(found, told, strict=True):
            assert part in line


@pytest.mark.parametrize("fault", [ZeroDivisionError("division by zero"), StopIteration("end"), OSError(5, "disk")])
def test_a_fault_of_one_program_does_not_stop_the_others(
    make_program: Any, run: Any, monkeypatch: pytest.MonkeyPatch, fault: Exception
) -> None:
    from verne_post.app import convert

    check = convert.check_source

    def fail_once(source: Any, *words: Any, **options: Any) -> Any:
        if b"X13." in source:
            raise fault
        return check(source, *words, **options)

    for name, x in (("a.nc", 12), ("b.nc", 13), ("c.nc", 14)):
        make_program(f"G1 Z120. F500.\nX{x}.", name)
    monkeypatch.setattr(convert, "check_source", fail_once)
    answer = run("check", ".")
    assert f"b.nc: VP902 error: internal error: {type(fault).__name__}: {fault}" in answer.out
    assert answer.out.count(" can run on VERNE: ") == 2
    assert "3 programs: 2 can run, 1 " in answer.out
    assert answer.code == ExitStatus.INTERNAL_ERROR
    monkeypatch.setenv("VERNE_POST_TRACEBACK", "1")
    with pytest.raises(type(fault)):
        run("check", ".")


def test_batch_says_what_was_not_checked(make_program: Any, run: Any) -> None:
    for name in ("a.nc", "b.nc"):
        make_program("G1 Z120. F500.", name)
    for _again in range(2):
        answer = run("batch", ".", "-o", "out", "-j", 1)
        assert "NOT CHECKED in 2 programs: contact with fixtures and stock" in answer.err
        listed = json.loads(Path("out/batch.json").read_text())["programs"]
        assert {one["unchecked"][:7] for one in listed} == {"contact"}


def test_explain_is_named_only_where_it_helps(make_program: Any, run: Any) -> None:
    """Beyond the travel of a rotary axis, where check has tried other angles and none helps."""
    part = make_program("G0 B200.\nG0 X10.")
    answer = run("check", part, "--machine", "bc_trunnion")
    assert "VP102 error: joint b reaches 200.000 deg" in answer.out
    assert "= Program less tilt, or take a machine whose axis goes so far." in answer.out
    assert "verne-post explain" not in answer.out


def test_what_explain_says_of_variables_is_what_programs_meet() -> None:
    """Each variable that is said to be refused is refused when a program reads it, and no other one is."""
    options = Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 60.0)}, dialect="fanuc")
    numbers = (1, 33, 1000, 2001, 3001, 3003, 3011, 3901, 4002, 4003, 4005, 4006, 4007, 4009, 4010, 4014, 4109, 4113)
    numbers += (4119, 4120, 5001, 5003, 5021, 5023, 5041, 5042, 5043, 5061, 5221, 5223, 5224, 5242, 5083, 99999)
    lines = [f"#100=#{number}" for number in numbers]
    head = "G21 G90 G94 G17\nG54 G0 X0. Y0. Z90. A0. C0.\nS1000 M3 F100.\n"
    source = head + "\n".join([*lines, "G1 X5.", "M30", ""])
    found = verne_post.check(source, "verne", options).findings
    refused = {line for one in found if one.code == "VP025" for line in one.lines or (one.line,)}
    for line, number in enumerate(numbers, start=4):
        (text,) = [one for one in describe_word(f"#{number}") if one.startswith("Fanuc: ")]
        assert ("refused (VP025)" in text) == (line in refused), (number, text)
    names = (
        "$P_EP[X]",
        "$AA_IW[Y]",
        "$AA_IM[Z]",
        "$P_UIFR[1,X,TR]",
        "$P_TOOL",
        "$P_TOOLNO",
        "$P_TOOLP",
        "$P_F",
        "$P_S",
    )
    names += ("$P_SDIR", "$P_UIFRNUM", "$P_TRAFO", "$P_SIM", "$AC_SIM", "$TC_DP2[1,1]", "$PI", "$A_DAY", "$AA_MW[X]")
    names += ("$MC_X", "$P_AXN1", "$TC_TP1[1]", "$SA_X", "$VA_IM[X]")
    head = "G54 G90 G710 G17\nG0 X0 Y0 Z90 A0 C0\n"
    source = head + "\n".join([*(f"R1={name}" for name in names), "G1 X5 F100", "M30", ""])
    found = verne_post.check(source, "verne", Options(tool_length=80.0, dialect="siemens")).findings
    refused = {line for one in found if one.code == "VP025" for line in one.lines or (one.line,)}
    for line, name in enumerate(names, start=3):
        (text,) = describe_word(name)
        assert ("refused (VP025)" in text) == (line in refused), (name, text)
    names = ("Q109", "Q113", "Q114", "Q120", "Q122", "Q100", "Q107", "Q110", "Q111", "Q112", "Q115", "Q150")
    head = (
        "0 BEGIN PGM A MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+90 A+0 C+0 R0 FMAX\nPLANE SPATIAL SPA+0 SPB+0 SPC+0 STAY\n"
    )
    source = head + "\n".join([*(f"FN 0: Q1 = {name}" for name in names), "L X+5 F100", "END PGM A MM", ""])
    found = verne_post.check(source, "verne", Options(tool_length=80.0, dialect="heidenhain")).findings
    refused = {line for one in found if one.code == "VP025" for line in one.lines or (one.line,)}
    for line, name in enumerate(names, start=5):
        (text,) = describe_word(name)
        assert ("refused (VP025)" in text) == (line in refused), (name, text)


def test_every_m_code_and_function_fn_has_a_sentence_of_each_language() -> None:
    for number in range(200):
        said = " ".join(describe_word(f"M{number}"))
        assert "in any language" in said or all(one in said for one in ("RS274", "Fanuc", "Siemens", "Klartext")), said
    assert all(describe_word(f"FN {number}") for number in range(40))
    assert describe_word("FN 14") == [
        "Klartext: stops the program with an error: a program that gets there is refused (VP027)"
    ]


def test_an_axis_that_is_not_named_beside_a_turn_is_said_to_stand_still(make_program: Any, run: Any) -> None:
    answer = run("check", make_program("G0 A0. C0.\nG49\nG0 X10. Y10. A90."), "--dialect", "fanuc")
    told = "Z is not named and stands still in the machine; after the turn, the tool cannot be at this X and Y unless Z"
    assert f"{told} moves too; name X, Y and Z, or turn the table in a separate block" in answer.out
