"""The mistakes that are most likely in the first five minutes: each is told so that one knows what to do."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verne_post.config.load import build_machine

GOOD = "G21 G90\nT1 M6\nG43 H1\nG0 X0 Y0 Z50 A0 C0\nG1 X9 F900\nG0 Z80\nM2\n"
PLACE = ("--tool-length", 60, "--wcs", "G54=0,0,20")


@pytest.mark.parametrize(
    ("length", "program", "expected"),
    [
        ("250.0", GOOD, ["m.toml:31:1: VP501"]),
        ("850.0", GOOD, []),
        ("850.0", GOOD.replace("X9", "X3500"), ["p.nc:5: VP110"]),  # the home is within reach
    ],
)
def test_a_wrong_rod_is_a_mistake_of_the_machine_file(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    run: Callable[..., Any],
    length: str,
    program: str,
    expected: list[str],
) -> None:
    """A rod 600 mm too short was told as a line of the program that is out of reach."""
    shipped = (Path(__file__).parents[2] / "machine_configs" / "verne.toml").read_text()
    (tmp_path / "m.toml").write_text(shipped.replace("L1 = 850.0", f"L1 = {length}"))
    (tmp_path / "p.nc").write_text(program)
    monkeypatch.chdir(tmp_path)
    done = run("check", "p.nc", *PLACE, "--machine", "m.toml")
    errors = [line for line in (done.out + done.err).splitlines() if " error: " in line]
    assert [line.split(" error: ")[0] for line in errors] == expected
    if "VP501" in str(expected):
        assert "home.g28 = [0.0, 0.0, 0.0, 0.0, 0.0] is out of reach, and so is the program" in errors[0]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "L1 = 850.0",
            "L1 = 0.85",
            "module.L1 = 0.85: home.g28 = [0.0, 0.0, 0.0, 0.0, 0.0] is out of reach, and so is "
            "the program; with 850 it is within reach",
        ),
        ("L1 = 850.0", "L1 = 85.0", "module.L1 = 85: home.g28"),
        ("R1 = 130.0", "R1 = 1300.0", "it is within reach with module.R1 = 130 instead of 1300 or module.r1 = 800"),
        ("L1 = 850.0", "L1 = 250.0", ": correct the lengths of [module], or [table], or this position"),
    ],
)
def test_a_length_with_a_slip_is_named(old: str, new: str, said: str) -> None:
    """The message stood at home.g28, which is right, and named no length."""
    shipped = (Path(__file__).parents[2] / "machine_configs" / "verne.toml").read_text()
    machine = build_machine(shipped.replace(old, new).encode(), "m.toml")
    assert said in machine.unreachable[0].message


SET_UP = """[wcs]
G54 = [0, 0, 20]

[tools]
1 = {{ length = {length}, diameter = 10 }}

[stock]
min = [-30, -30, 0]
max = [{high}, 30, 69.5]

[keep_out.vise]
min = [-330, -30, 0]
max = [-320, 30, 20]
{system}
"""


@pytest.mark.parametrize(
    ("values", "place"),
    [
        ({}, None),
        ({"length": 2400}, "p.nc.toml:5:1: VP505 warning: tool 1: a length of 2400 mm"),
        ({"high": 30_000}, "p.nc.toml:7:1: VP505 warning: the stock: a size of 30030 mm"),
        ({"system": 'system = "G55"'}, "p.nc.toml:11:1: VP018 error: vise is given in G55, and G55 is not"),
    ],
)
def test_what_is_wrong_in_a_set_up_has_its_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any], values: dict[str, Any], place: str | None
) -> None:
    """It was told of the program, without a line."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.nc").write_text(GOOD.replace("G43", "M3 S900 G43"))
    (tmp_path / "p.nc.toml").write_text(SET_UP.format(**{"length": 60, "high": 30, "system": ""} | values))
    for arguments in (("check", "p.nc"), ("p.nc", "-o", "rows.csv")):
        done = run(*arguments)
        told = [line for line in (done.out + done.err).splitlines() if "VP505" in line or "VP018" in line]
        assert len(told) == (place is not None)
        assert all(line.startswith(place) for line in told)


def test_a_set_up_is_named_for_its_own_program_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]
) -> None:
    """The length of a tool table was told at the tool of the same number of another program."""
    monkeypatch.chdir(tmp_path)
    for name, tools in (("a.nc", "tools.1 = {length = 60}"), ("b.nc", 'tool_table = "b.tbl"')):
        (tmp_path / name).write_text(GOOD.replace("G43", "M3 S900 G43"))
        (tmp_path / f"{name}.toml").write_text(f"{tools}\n[wcs]\nG54 = [0, 0, 20]\n")
    (tmp_path / "b.tbl").write_text("T1 P1 Z2400\n")
    told = [line for line in run("check", "a.nc", "b.nc").out.splitlines() if "VP505" in line]
    assert [line[:38] for line in told] == ["b.nc: VP505 warning: tool 1: a length "]


def test_the_letter_o_in_the_number_of_a_parameter(tmp_path: Path, run: Callable[..., Any]) -> None:
    """Q2OO for Q200 was told as a cycle without Q200."""
    cycle = "CYCL DEF 200 D Q2OO=2 Q201=-5 Q206=9 Q202=2 Q210=0 Q203=0 Q204=9"
    (tmp_path / "p.h").write_text(f"BEGIN PGM T MM\nTOOL CALL 1 Z S9\nL X+0 Y+0 Z+9 FMAX\n{cycle}\nEND PGM T MM\n")
    lines = run("check", tmp_path / "p.h", *PLACE).out.splitlines()
    assert lines[0].endswith("p.h:4:16: VP001 error: Q2OO: the letter O in a number; did you mean Q200?")
    assert [" error: " in line for line in lines[:-1]].count(True) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        # 1: a wrong name
        (("pp.nc", *PLACE), "pp.nc: VP022 error: no such file"),
        # 2: no tool length for a program that asks for one
        (("p.nc",), "give --tool-table FILE, or give --tool-length MM"),
        # 3: the offset in another spelling
        (("p.nc", "--tool-length", 60, "--wcs", "0,0,20"), "expected G54=X,Y,Z or G54=X,Y,Z,C"),
        (("p.nc", "--tool-length", 60, "--wcs", "G54=0,0"), "got 2 numbers, expected 3 (X,Y,Z), or 4 (X,Y,Z,C)"),
        (("p.nc", "--tool-length", 60, "--wcs", "G54=0"), "G54=0: got 1 number, expected 3 (X,Y,Z), or 4 (X,Y,Z,C)"),
        # 4: a machine that is not there
        (
            ("p.nc", *PLACE, "--machine", "nope"),
            "file or directory; verne-post machine list prints the machines by name",
        ),
        (("p.nc", *PLACE, "--machine", "vern"), "file or directory; did you mean verne?"),
        (("p.nc", *PLACE, "--machine", "VERNE.toml"), "; did you mean verne?"),
        (("p.nc", *PLACE, "--machine", "delta"), "; did you mean linear_delta?"),
        # 5: a misspelt option, a misspelt command
        (("p.nc", "--tool-lenght", 60), "--tool-lenght"),
        (("explain", "p.nc", 12), "a line of a program is one word with it: verne-post explain p.nc:12"),
        (("chek", "p.nc"), "no such file, and no command; did you mean check?"),
        (("wrods", "--help"), "wrods: no such file, and no command; verne-post --help lists the commands"),
        (("convert", "p.nc", "-o", "f.xlsx"), "the file would be csv in spite of its name; write -o f.csv"),
        (("report", "p.nc", "-o", "f.pdf"), "-o f.pdf: expected a name that ends in .html"),
        (("p.nc", "--against", "p.nc"), "No such option '--against'; verify and machined have it."),
        (("p.nc", "--simulate", "x"), "No such option '--simulate'; machine calibrate has it."),
        (("convert", "."), ".: VP022 error: is a folder; check and batch take folders"),
        (("p.nc", *PLACE[2:], "--tool-table", "p.nc"), "is that of a tool either: this is a program, not a"),
        (("setup", "t.tbl"), "t.tbl is no NC program: .tbl is a tool table"),
        (("setup", "p.nc", "-o", "t.tbl"), "t.tbl is there already, and is not the set-up that is read (none)"),
        (("--machine", "serial", "chek", "p.nc"), "chek: no such file, and no command; did you mean check?"),
        (("--machine", "serial"), "Missing argument 'INPUT'"),
        (("-q",), "Missing argument 'INPUT'"),
        (("--tool-length", "60", "check", "p.nc"), "check comes first: verne-post check --tool-length 60 p.nc"),
        (("--exit-zero", "check", "p.nc"), "check comes first: verne-post check --exit-zero p.nc"),
        (("--machin", "serial", "p.nc"), "--machine"),
        # 6: output that cannot be, or would destroy something
        (("p.nc", *PLACE, "-o", "no/axes.csv"), "the folder does not exist"),
        (("p.nc", *PLACE, "-o", "p.nc"), "this is the file of INPUT; choose another name"),
        # 7: a setpoint file, or a picture, for a program
        (("axes.csv",), "is a setpoint file, not a program"),
        (("check", "picture.png"), "is not a text file"),
        # 8: a restart from nowhere
        (("p.nc", *PLACE, "--from-line", 5, "-o", "a.csv"), "--from-line"),
        # 9: a stop on the way
        (("stops.nc", *PLACE), "Write one file of setpoints for each part between two stops: --split-at-stops"),
        # 10: the part too low, too far: the limit and its excess, and where to go on
        (("check", "low.nc", "--tool-length", 60), "below the table face"),
        (
            ("check", "far.nc", *PLACE),
            "`verne-post explain far.nc:5 ",
        ),
    ],
)
def test_likely_mistakes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any], words: tuple[object, ...], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("p.nc").write_text(GOOD)
    Path("stops.nc").write_text(GOOD.replace("G0 Z80", "M0\nG0 Z80"))
    Path("low.nc").write_text(GOOD.replace("G1 X9", "G1 Z-5"))
    Path("far.nc").write_text(GOOD.replace("G1 X9", "G1 Z690"))
    Path("axes.csv").write_text("t_s,rho1_mm\n")
    Path("t.tbl").write_text("T1 Z80")
    Path("picture.png").write_bytes(b"\x89PNG\0\0")
    before = sorted(path.name for path in tmp_path.iterdir())
    answer = run(*words)
    assert answer.code in (1, 2)
    assert said in " ".join((answer.err + answer.out).split())
    if words[0] != "check":
        assert answer.out == ""
    assert sorted(path.name for path in tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    "option", [["--machine", "serial"], ["-o", "check"], ["--meta", "report"], ["--events", "fit.csv"]]
)
def test_options_may_stand_before_the_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any], option: list[str]
) -> None:
    """Also options that nearly read as a command, and values that do."""
    monkeypatch.chdir(tmp_path)
    Path("p.nc").write_text(GOOD)
    first = run(*option, "p.nc", *PLACE)
    assert first.code == 0, first.err
    assert first.out == run("p.nc", *PLACE, *option).out
    Path("report").write_text(GOOD)
    assert run("report", "--help").out.startswith("Usage: verne-post report")


def test_without_arguments_the_help_is_shown(run: Callable[..., Any]) -> None:
    answer = run()
    assert "Usage: verne-post" in answer.out + answer.err
    assert "verne-post check input.nc" in answer.out + answer.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--tool-length", "8_0"), "'8_0' is not a number"),
        (("--tool-length", "٣"), "is not a number"),
        (("--max-rows", "1_000"), "'1_000' is not a whole number"),
        (("--wcs", "G54=1_0,2,3"), "is not a list of numbers"),
        (("--decimals", "٣"), "expected auto, or a whole number from 0 to 12"),
        (("--decimals", "9" * 5000), "expected auto, or a whole number from 0 to 12"),
    ],
)
def test_numbers_have_the_digits_of_programs(
    tmp_path: Path, run: Callable[..., Any], words: tuple[str, ...], said: str
) -> None:
    (tmp_path / "part.nc").write_text("G21 G90 F600\nG1 X1 Z60\nM2\n", encoding="utf-8")
    answer = run("convert", tmp_path / "part.nc", "-o", tmp_path / "axes.csv", *words)
    assert answer.code == 2
    assert said in answer.err


TOOLS_OF = {
    "no.h": (
        "BEGIN PGM NO MM\nL A+0 C+0 R0 FMAX\nL X+0 Y+0 Z+50 FMAX\nL Z+20 F300\nL X+20 F AUTO\nM30\nEND PGM NO MM\n",
        "no TOOL CALL before the first feed move; write TOOL CALL",
        ("TOOL CALL 7 Z S with its speed before it", 'TOOL CALL "MILL" Z S with its speed before it'),
    ),
    "no.mpf": (
        "G17 G54 G90 G94 G710\nS3000 M3\nG0 A0 C0\nX0 Y0 Z50\nG1 Z20 F300\nM30\n",
        "no tool is called before the first feed move; write T",
        ("T7 D1 and M6 before it", 'T="MILL" D1 and M6 before it'),
    ),
    "no.nc": (
        "G17 G54 G90 G94 G21\nS3000 M3\nG0 A0 C0\nX0 Y0 Z50\nG1 Z20 F300\nM30\n",
        "no tool is called before the first feed move; write T",
        ("T7 M6 and G43 H7 before it", ""),
    ),
}


def test_a_tool_that_is_only_selected_is_named_where_no_length_is_in_force(
    run: Callable[..., Any], tmp_path: Path
) -> None:
    """It was "no tool length has been given", with the length in the set-up."""
    program, setup = tmp_path / "a.nc", tmp_path / "a.nc.toml"
    setup.write_text("[tools]\n1 = {length = 80}\n[wcs]\nG54 = [0, 0, 40]\n")
    text = "%\nO1\nG21 G17 G90 G94\nT1\nG54 S5000 M3\nG0 X0. Y0. Z60.\nG1 Z15. F500.\nX10.\nM30\n%\n"
    program.write_text(text)
    told = run("check", program)
    assert "a.nc:7: VP012 error: T1 of line 4 only selects the tool" in told.out
    assert "write M6 after T1, and G43 H1 before this move" in told.out
    program.write_text(text.replace("T1\n", "T1 M6\n").replace("G1 Z15.", "G43 H1\nG1 Z15."))
    told = run("check", program)
    assert (told.code, "VP" in told.out) == (0, False), told.out


def test_klartext_without_a_tool_call_has_one_remedy(run: Callable[..., Any], tmp_path: Path) -> None:
    program = tmp_path / "a.h"
    program.write_text("BEGIN PGM A MM\nL X+0 Y+0 Z+50 R0 FMAX M3\nL Z+20 F300\nL X+20\nM30\nEND PGM A MM\n")
    told = run("check", program, "--wcs", "G54=0,0,40")
    assert "write TOOL CALL with --tool-table" in told.out
    assert told.out.count("tool in the program") == 0


@pytest.mark.parametrize("name", TOOLS_OF)
def test_where_no_tool_is_called_the_call_is_the_remedy(run: Callable[..., Any], tmp_path: Path, name: str) -> None:
    """It was "fill in the length in the set-up", where all lengths were."""
    text, begin, calls = TOOLS_OF[name]
    program, setup = tmp_path / name, tmp_path / f"{name}.toml"
    program.write_text(text)
    for key, call in zip(("7", "MILL"), calls, strict=True):
        setup.write_text(f"[tools]\n{key} = {{length = 80, diameter = 6}}\n[wcs]\nG54 = [0, 0, 40]\n")
        told = run("check", program)
        assert (told.code, told.out.count("VP"), begin in told.out, call in told.out) == (2, 1, True, True), told.out
        assert "Fill in the length" not in told.out
    setup.write_text("[tools]\n7 = {length = 80}\n8 = {length = 90}\n[wcs]\nG54 = [0, 0, 40]\n")
    told = run("check", program)
    assert begin in told.out
    assert told.out.count("has the tools 7, 8\n") == 1
    setup.write_text("[wcs]\nG54 = [0, 0, 40]\n")  # no length is known: that is the first thing to say
    assert "Fill in tool_length, mm, in" in run("check", program).out


OTHER_SIGN = "(I with the other sign), if that is meant: the radii agree then"


@pytest.mark.parametrize(
    ("name", "arc", "said"),
    [
        ("arc.nc", "G2 X10 Y0 I-5 J0", f"; write I5 J0 {OTHER_SIGN}"),
        (
            "arc.nc",
            "G3 X10 Y10 I0 J-10",
            "; write I0 J10 (J with the other sign), if that is meant: the radii agree then",
        ),
        (
            "arc.nc",
            "G2 X10 Y10 I0 J-10",
            "; write I0 J10 (J with the other sign), if that is meant: the radii agree then, on an arc of 270 deg",
        ),
        ("arc.nc", "G3 X-40 Y0 J-20", "; write I-20 J0 (I and J exchanged), if that is meant: the radii agree then"),
        (
            "arc.nc",
            "G3 X-20 Y20 I0 J-20",
            "; the radii agree with I-20 J0 (I and J exchanged: an arc of 90 deg), and with I0 J20 (J with the other "
            "sign: an arc of 270 deg)",
        ),
        (
            "arc.nc",
            "G3 X-6 Y8 I3 J-4",
            "; write I-3 J4 (I and J with the other sign), if that is meant: the radii agree then",
        ),
        # the end is so near that almost any centre fits
        ("arc.nc", "G0 X12\nG3 X12 Y1 I-12 J0", ""),
        (
            "arc.nc",
            "G91 G2 X10 Y0 I-5 J3",
            "; the radii agree with I5 J-3 (I and J with the other sign: an arc of 118.1 deg), and with I5 J3 (I with "
            "the other sign: an arc of 241.9 deg)",
        ),
        ("arc.nc", "G20 G2 X1 Y0 I-0.5 J0", f"; write I0.5 J0 {OTHER_SIGN}"),
        ("arc.nc", "G18 G2 X10 Z20 I-5 K0", f"; write K0 I5 {OTHER_SIGN}"),
        ("arc.nc", "G2 X10 Y0 I-6 J0", ""),
        ("arc.nc", "G90.1 G2 X10 Y0 I-5 J0", ""),  # the centre is a place
        ("arc.mpf", "G2 X10 Y0 I-5 J0", f"; write I5 J0 {OTHER_SIGN}"),
    ],
)
def test_slips_in_the_centre_of_an_arc_are_told(
    run: Callable[..., Any], tmp_path: Path, name: str, arc: str, said: str
) -> None:
    """Only both radii were told, and that they differ."""
    head = "G17 G54 G90 G94 G21\nT1 M6\nG43\n" if name == "arc.nc" else "G17 G54 G90 G94 G710\nT1 D1\nM6\n"
    program = tmp_path / name
    program.write_text(f"{head}S900 M3\nG0 A0 C0\nX0 Y0 Z50\nG1 Z20 F300\n{arc}\nM30\n")
    told = run("check", program, "--tool-length", 80, "--wcs", "G54=0,0,40")
    line = next(line for line in told.out.splitlines() if ": VP" in line)
    assert ": VP008 error: the end is not on the circle: radius " in line, told.out
    assert line.endswith(f" {'inch' if 'G20' in arc else 'mm'}{said}"), line
    assert ("Correct the end, the centre or the radius" in told.out) == (not said)


@pytest.mark.parametrize("name", ["arc.nc", "arc.mpf"])
@pytest.mark.parametrize("arcs", ["G3 X18 Y2 I-2\nG3 X16 Y0 I0 J-2", "G3 X16 Y0 I-2 J0\nX18 Y2 I2 J0\nX20 Y4 J2"])
def test_the_word_of_another_plane_is_the_one_cause_of_its_arcs(
    run: Callable[..., Any], tmp_path: Path, name: str, arcs: str
) -> None:
    """It was two errors of the words of the arcs, and only one named G18."""
    head = "G18 G54 G90 G94 G21\nT1 M6\nG43\n" if name == "arc.nc" else "G18 G54 G90 G94 G710\nT1 D1\nM6\n"
    program, options = tmp_path / name, ("--tool-length", 80, "--wcs", "G54=0,0,40")
    text = f"{head}S900 M3\nG0 A0 C0\nX20 Y0 Z50\nG1 Z20 F300\n{arcs}\nM30\n"
    program.write_text(text)
    told = run("check", program, *options)
    assert told.out.count(": VP") == 1, told.out
    assert "G18 of line 1 is active" in told.out
    assert ("write G17 before, if that is meant" in told.out) == (name == "arc.nc" or "I-2\n" in arcs), told.out
    program.write_text(text.replace("G18", "G17"))
    assert ": VP0" not in run("check", program, *options).out


@pytest.mark.parametrize(
    ("name", "arc", "said"),
    [
        (
            "arc.nc",
            "G3 X20 Y30 I20 J20",
            "; write I-10 J0 (I and J fit as coordinates of the centre), if that is meant",
        ),
        ("arc.mpf", "G3 X20 Y30 I=20 J=20", "; write I-10 J0 (I and J fit as coordinates of the centre)"),
        ("arc.nc", "G3 X20 Y30 I21 J20", ""),
        ("arc.nc", "G90.1 G3 X20 Y30 I-10 J0", ""),
        # the program has other values than those that are compared
        ("arc.mpf", "MIRROR X0\nG1 X30 Y20\nG3 X20 Y30 I=20 J=20", ""),
        ("arc.nc", "G51.1 X0\nG1 X30 Y20\nG3 X20 Y30 I20 J20", ""),
    ],
)
def test_a_centre_given_as_a_place_is_told(
    run: Callable[..., Any], tmp_path: Path, name: str, arc: str, said: str
) -> None:
    """Only both radii were told; what is told cures the program."""
    head = "G17 G54 G90 G94 G21\nT1 M6\nG43\n" if name == "arc.nc" else "G17 G54 G90 G94 G710\nT1 D1\nM6\n"
    program, dialect = tmp_path / name, "fanuc" if "G51.1" in arc else "siemens" if name == "arc.mpf" else "rs274"
    text = f"{head}S900 M3\nG0 A0 C0\nX30 Y20 Z50\nG1 Z20 F300\n{arc}\nM30\n"
    options = ("--tool-length", 80, "--wcs", "G54=0,0,40", "--dialect", dialect)
    program.write_text(text)
    told = run("check", program, *options)
    line = next(line for line in told.out.splitlines() if ": VP008" in line)
    assert (said in line) if said else "coordinates of the centre" not in line, line
    if said:
        right = arc.replace("I20 J20", "I-10 J0").replace("I=20 J=20", "I=-10 J=0")
        program.write_text(text.replace(arc, right))
        assert "VP008" not in run("check", program, *options).out
