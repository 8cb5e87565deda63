"""What a program takes as given: the tool that M6 would load, and the speed of the spindle."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PLACE = ("--tool-length", "80", "--wcs", "G54=0,0,0")
HEAD = "G21 G90 G94 G17\n{}\nG0 X0 Y0 Z60 A0 C0\nG1 X10 Z50 F600\n{}M2\n"


@pytest.mark.parametrize(
    ("begin", "more", "line"),
    [
        ("T2\nS900 M3", "", 2),
        ("T2 M6\nS900 M3", "", None),
        ("T2\nM6 T3\nS900 M3", "", None),  # the next tool is made ready
        ("T2\nS900 M3", "M6\n", None),  # loaded later: another tool may be in the spindle at first
        ("M61 Q2\nT3\nS900 M3", "", None),
        ("T0\nS900 M3", "", None),
        ("T2\nM101\nS900 M3", "", None),  # a code of the builder loads it
        ("T2\nM102\nS900 M3", "", 2),
        ("S900 M3", "", None),
    ],
)
def test_a_tool_that_is_only_selected(
    run: Callable[..., Any], tmp_path: Path, begin: str, more: str, line: int | None
) -> None:
    path, settings = tmp_path / "p.ngc", tmp_path / "s.toml"
    path.write_text(HEAD.format(begin, more))
    settings.write_text('[remap]\nM101 = "M6"\nM102 = "event"\n')
    answer = run("check", path, *PLACE, "--split-at-stops", "--settings", settings)
    assert answer.code == 0, answer.out
    assert answer.out.count("VP041") == (line is not None)
    if line is not None:
        cut = 4 + begin.count("\n")
        assert (
            f"p.ngc:{line}: VP041 warning: T2 only selects the tool, and no M6 loads it: line {cut} cuts" in answer.out
        )


@pytest.mark.parametrize(
    ("begin", "more", "line"),
    [
        ("M3", "", 2),
        ("S900 M3", "", None),
        ("S900\nM3", "", None),
        ("M3", "S900\nG1 X5\n", 2),  # too late: a tool has cut
        ("M3\nS900", "", None),
        ("M3\nM5", "M3\nG1 X5\n", 6),  # the start under which it cuts
    ],
)
def test_a_spindle_without_a_speed(
    run: Callable[..., Any], tmp_path: Path, begin: str, more: str, line: int | None
) -> None:
    path = tmp_path / "p.ngc"
    path.write_text(HEAD.format(begin, more))
    answer = run("check", path, *PLACE)
    assert answer.code == 0, answer.out
    assert answer.out.count("gives its speed") == (line is not None)
    if line is not None:
        late = "before the cut " if "S" in more else ""
        text = f"VP050 warning: the spindle is started here, and no block {late}gives its speed"
        assert f"p.ngc:{line}: {text}" in answer.out


@pytest.mark.parametrize(
    ("begin", "more", "line"),
    [
        ("S900 M3\nS0 M03", "", 3),
        ("S0 M3\nS900", "", None),
        ("S900 M3\nS0", "", 3),
        ("S900 M3\nS0\nM5", "", None),
    ],
)
def test_a_cut_at_speed_0(run: Callable[..., Any], tmp_path: Path, begin: str, more: str, line: int | None) -> None:
    path = tmp_path / "p.ngc"
    path.write_text(HEAD.format(begin, more))
    answer = run("check", path, *PLACE)
    assert answer.code == 0, answer.out
    assert answer.out.count("S0: the spindle does not turn in the cut") == (line is not None)
    if line is not None:
        assert f"p.ngc:{line}: VP050 warning: S0" in answer.out


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("p.mpf", "G17 G90 G54\nT1 D1 M6\nS900 M3\nG0 A0 C0\nX0 Y0 Z9\nT1 D1 M6\nS0 M3\nG1 X5 F100\nM30\n", 7),
        (
            "p.h",
            "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+9 A+0 C+0 FMAX M3\nTOOL CALL 1 Z S0\nL X+5 F100 M3\nM30\n"
            "END PGM P MM\n",
            4,
        ),
    ],
)
def test_a_cut_at_speed_0_in_other_languages(
    run: Callable[..., Any], tmp_path: Path, name: str, text: str, line: int
) -> None:
    (tmp_path / name).write_text(text)
    answer = run("check", tmp_path / name, *PLACE)
    assert f"{name}:{line}: VP050 warning: S0: the spindle does not turn in the cut" in answer.out, answer.out


SLOT_OF_KLARTEXT = (
    "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X0 Y0 Z60 A0 C0 R0 FMAX M3\nCYCL DEF 253 SLOT Q215=0 Q218=40 Q219=9 Q368=0 "
    "Q374=0 Q367=0 Q207=500 Q351=+1 Q201=-5 Q202=2 Q369=0 Q206=150 Q338=0 Q200=2 Q203=0 Q204=50 Q366=0 Q385=500 "
    "Q439=0\nL X10 Y10 FMAX M99\nL X60 FMAX M99\nM30\nEND PGM P MM\n"
)
#: Its many strokes are those of a narrow tool.
POCKET_OF_SIEMENS = (
    "G17 G90 G94 G71 G54\nT1 D1 M6\nS1000 M3\nG0 A0 C0\nG0 X0 Y0 Z60\n"
    "POCKET3(20,0,2,-90,200,150,10,0,0,0,0.05,0,0,150,500,0,11)\nM30\n"
)


@pytest.mark.parametrize(("name", "text"), [("p.h", SLOT_OF_KLARTEXT), ("p.mpf", POCKET_OF_SIEMENS)])
def test_a_cycle_says_nothing_of_the_width_of_an_unknown_tool(
    run: Callable[..., Any], tmp_path: Path, name: str, text: str
) -> None:
    path = tmp_path / name
    path.write_text(text)
    answer = run("check", path)
    assert "VP007" not in answer.out
    assert answer.out.count("VP012 error: the diameter of tool 1 is not known; write [tools] 1 =") == 1
    assert answer.out.count("VP012") == 2


def test_a_subprogram_alone_is_checked_where_it_is_called(run: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "BORE5.SPF"
    text = "PROC BORE5(REAL _SC,REAL _DP,REAL _FE)\nG0 Z=_SC\nG1 Z=_DP F=_FE\nRET\n"
    path.write_text(text)
    said = "this is a subprogram, and a call gives it _SC, _DP and _FE; check the program that calls it"
    answer = run("check", path, *PLACE)
    assert answer.code == 2
    assert f"BORE5.SPF:1:1: VP005 error: {said}" in answer.out
    assert "1 error," in answer.out
    assert "VP009" not in answer.out
    assert "1 error, 0 warnings" in run("check", path, "--machine", "ac_trunnion").out  # nor is a set-up missing
    answer = run("explain", f"{path}:3", *PLACE)
    assert said in answer.out
    assert "feed rate zero" not in answer.out
    # with values of its own it is a program
    path.write_text(text.replace("_SC,", "_SC=5,").replace("_DP,", "_DP=-1,").replace("_FE)", "_FE=100)"))
    assert "VP005" not in run("check", path, *PLACE).out


@pytest.mark.parametrize(
    ("name", "text", "line", "why", "main", "call", "tool"),
    [
        ("SUB1.h", "BEGIN PGM SUB1 MM\nL IX+10 F500\nEND PGM SUB1 MM\n", 3, "neither M2 nor M30 ends it",
         "MAIN.h", "BEGIN PGM MAIN MM\nTOOL CALL 1 Z S500\nCALL PGM SUB1\nM30\nEND PGM MAIN MM\n", "TOOL CALL"),
        ("SUB1.h", "LBL 4\nL X+10 F500\nLBL 0\n", 1, "LBL 4 begins it", "MAIN.h", "", ""),
        ("O1000.nc", "%\nO1000 (POCKET)\nG91 X1O F500\nG1 X4.\n(END)\nM99 ( M30 )\n%\n", 6, "M99 ends it",
         "O0001.nc", "O1\nT1 M6\nM98 P1000\nM30\n", "T and M6"),
        ("SUB1.SPF", "G91 Z-4\nG1 X10 F500\nM5\nM17\n", 4, "M17 ends it", "MAIN.MPF", "T1 M6\nSUB1\nM30\n", ""),
        ("SUB1.MPF", "G91 Z-4\nG1 X10 F500\nM5\nRET\n", 4, "RET ends it", "MAIN.MPF", "", "T, D and M6"),
        ("SUB1.SPF", "PROC SUB1 SAVE\nG1 X10 F500\nRET\n", 1, "PROC begins it", "MAIN.MPF", "T1 M6\nSUB1\nM30\n", ""),
        ("1000.ngc", "O1000\nG1 X10 F500\nM99\n", 3, "M99 ends it", "a.ngc", "T1 M6\nM98 P1000\nM2\n", "T and M6"),
    ],
)  # fmt: skip
def test_a_subprogram_alone_is_one_finding_and_has_no_set_up(
    run: Callable[..., Any], tmp_path: Path, name: str, text: str, line: int, why: str, main: str, call: str, tool: str
) -> None:
    """Its tool and its places were asked for, in a set-up that no program reads."""
    path = tmp_path / name
    path.write_text(text)
    start, slips = f"{name}:{line}: VP010 error: ", text.count("1O")
    said = f"{start}this is a subprogram: it calls no tool, and {why}; check "
    alone, called = f"{said}the program that calls it", said
    if tool:  # a program may end so, too
        alone = (
            f"{start}is this a subprogram? it calls no tool, and {why}; if it is a program, call its tool "
            f"({tool}) and end it with M30; if it is a subprogram, check the program that calls it"
        )
        called = f"{start}this is a subprogram; check "
    for command in ("check", "convert", "setup"):
        answer = run(command, path)
        shown = answer.out + answer.err
        assert f"{alone}\n" in shown
        assert shown.count("VP") == 1 + slips  # of its own words
        assert "toml" not in shown
    assert answer.code == 2
    assert list(tmp_path.iterdir()) == [path]
    if call:
        (tmp_path / main).write_text(call)
        for command in ("check", "setup"):
            answer = run(command, path)
            assert f"{called}{tmp_path / main}, which calls it\n" in answer.out + answer.err
        assert not list(tmp_path.glob("*.toml"))


@pytest.mark.parametrize(
    ("name", "text", "others"),
    [
        ("p.h", "BEGIN PGM P MM\nTOOL CALL 1 Z S500\nL X+0 Y+0 Z+9 R0 FMAX M3\nL X+9 F500\nEND PGM P MM\n", ""),
        ("p.h", "BEGIN PGM P MM\nL X+0 Y+0 Z+9 R0 FMAX M3\nL X+9 F500\nEND PGM P MM\n", ""),
        ("p.h", "BEGIN PGM P MM\nL X+0 Y+0 Z+9 R0 FMAX\nL X+9 F500\nEND PGM P MM\n", "TOOL"),
        ("p.nc", "%\nO1\nT1 M6\nG54 G0 X0 Y0\nG43 H1 Z9.\nG1 X9. F500\nM99\n%\n", "M99"),
        ("p.mpf", "G54 G17 G90\nT1 D1\nM6\nG0 X0 Y0 Z9\nG1 X9 F500\nM17\n", ""),
        ("p.mpf", "G54 G17 G90\nS500 M3\nG0 X0 Y0 Z9\nG1 X9 F500\nRET\n", ""),
    ],
)
def test_a_program_without_m30_is_no_subprogram(
    run: Callable[..., Any], tmp_path: Path, name: str, text: str, others: str
) -> None:
    """What names a tool or starts the spindle is a program; a Klartext without both may be one, and is told so."""
    path = tmp_path / name
    path.write_text(text)
    answer = run("check", path)
    assert "VP012 error" in answer.out
    assert "this is a subprogram" not in answer.out.replace("if this is a subprogram", "")
    assert ("check the program that calls it" in answer.out) == bool(others)
    assert others != "TOOL" or "Fill in tool_length" not in answer.out  # the message has all that helps
    run("setup", path)
    assert Path(f"{path}.toml").exists()


@pytest.mark.parametrize("call", ["BORE5(5,-3,100)", "MCALL BORE5(5,-3,100)", "BORE5"])
def test_a_declared_subprogram_without_its_file_is_no_code_of_the_builder(
    run: Callable[..., Any], tmp_path: Path, call: str
) -> None:
    path = tmp_path / "p.mpf"
    path.write_text(
        f"EXTERN BORE5(REAL,REAL,REAL)\nG17 G90 G94 G71 G54\nG0 X0 Y0 Z60 A0 C0\n{call}\nX10\n{call}\nM30\n"
    )
    answer = run("check", path, *PLACE)
    assert answer.out.count("VP023 error: BORE5, which EXTERN declares, is defined neither") == 1
    assert "Put its file beside the program" in answer.out
    assert "1 error," in answer.out
    assert "remap" not in answer.out
    run("setup", path)
    setup = tmp_path / "p.mpf.toml"
    assert not setup.exists() or "BORE5" not in setup.read_text().partition("[wcs]")[2]
