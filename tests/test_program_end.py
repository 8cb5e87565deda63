"""VP051: moves after the end of a program; VP052: a way home that goes down first."""

import pytest

import verne_post as vp

OPTIONS = vp.Options(tool_length=80.0, wcs={1: vp.WorkOffset((0.0, 0.0, 60.0))})
FANUC = "%\nO1\nG21 G90 G94\nG54 G0 X0 Y0 Z50 A0 C0\nM3 S1000\nG43 Z50 H0\n{}G1 X10 F600\n{}%\n"
SIEMENS = "G0 X0 Y0 Z50 A0 C0\nM3 S1000\nG1 X10 F600\n{}"
KLARTEXT = "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+50 A+0 C+0 R0 FMAX M3\nL X+10 F600\n{}END PGM A MM\n"
CL = "UNITS/MM\nLOADTL/1\nSPINDL/1000,CLW\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/600,MMPM\nGOTO/10,0,50,0,0,1\n{}"


def find(code, text, dialect):
    result = vp.check(text, "verne", vp.Options(tool_length=80.0, wcs=OPTIONS.wcs, dialect=dialect))
    assert result.ok, result
    return [(item.line, item.message) for item in result.findings if item.code == code]


@pytest.mark.parametrize(
    ("dialect", "text", "line", "lines"),
    [
        ("fanuc", FANUC.format("", "M30\nG1 Y5\nX0\nM30\n"), 8, "lines 9 to 10 move"),
        ("fanuc", FANUC.format("", "M30\n(Y)\nG1 Y5\n"), 8, "line 10 moves"),
        ("rs274", "G21 G90\nG0 X0 Y0 Z50 A0 C0\nM3 S1\nG1 X1 F60\nM2\nG1 Y#5\n", 5, "line 6 moves"),
        ("siemens", SIEMENS.format("M30\nN5 G1 Y=5\nM30\n"), 4, "line 5 moves"),
        # a subprogram below is executed, and does not hide them
        (
            "fanuc",
            FANUC.format("M98 P2000\n", "M30\nG1 Y5\nX0\nM30\nO2000\nG1 X5 F600\nM99\n"),
            9,
            "lines 10 to 11 move",
        ),
        (
            "siemens",
            SIEMENS.format("UP(1)\nM30\nG1 Y5\nM30\n%_N_UP_SPF\nPROC UP(REAL U)\nX5\nRET\n"),
            5,
            "line 6 moves",
        ),
        ("heidenhain", KLARTEXT.format("CALL LBL 9\nM30\nL Z+80\nM30\nLBL 9\nL X+5\nLBL 0\n"), 6, "line 7 moves"),
        ("heidenhain", KLARTEXT.format("M30\nL Z+80\nL Z+90\nM30\n"), 5, "lines 6 to 7 move"),
        ("aptcl", CL.format("FINI\nGOTO/20,0,50,0,0,1\n"), 8, "line 9 moves"),
    ],
)
def test_moves_after_the_end_are_reported_where_it_is(dialect, text, line, lines):
    ((at, message),) = find("VP051", text, dialect)
    assert at == line and f"ends the program: {lines} axes after it" in message


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("fanuc", FANUC.format("", "M30\nO2\nG1 Y5\nM99\n")),
        ("fanuc", FANUC.format("M98 P2\n", "M30\nN9 O2\nG1 Y5 F600\nM99\n")),
        ("fanuc", FANUC.format("", "M30\n(X0 Y5)\n")),
        ("rs274", "G21 G90\nG0 X0 Y0 Z50 A0 C0\nM3 S1\nG1 X1 F60\nM2\n; X5\no9 sub\nG1 Y5\no9 endsub\n"),
        ("siemens", SIEMENS.format("GOTOF LATER\nM30\nLATER:\nG1 Y5\nM30\n")),
        ("siemens", SIEMENS.format("GOTOF LATER\nEND:\nM30\nLATER:\nG1 Y5\nGOTOB END\n")),
        ("fanuc", FANUC.format("", "GOTO 9\nN8 M30\nN9 G1 Y5\nGOTO 8\n")),
        ("siemens", SIEMENS.format("M30\n; G1 Y5\n")),
        ("heidenhain", KLARTEXT.format("M30\n9 LBL 1\nL Z+80\nLBL 0\n")),
        ("heidenhain", KLARTEXT.format("")),
        ("aptcl", CL.format("FINI\n$$ GOTO/20,0,50\n")),
    ],
)
def test_what_stands_after_the_end_on_purpose_is_not_reported(dialect, text):
    assert find("VP051", text, dialect) == []


def test_the_end_in_a_called_file_names_the_file() -> None:
    text = FANUC.format("M98 P2000\n", "M30\n")
    options = vp.Options(
        tool_length=80.0, wcs=OPTIONS.wcs, dialect="fanuc", subroutines={"o2000": b"O2000\nG1 X5 F600\nM30\n"}
    )
    (found,) = (item for item in vp.check(text, "verne", options).findings if item.code == "VP051")
    assert found.line == 7 and "line 3: M30 ends the program" in found.full_message and "M99" in found.message


def test_a_long_program_is_searched_from_its_end():
    """Its last lines are looked at alone; those after an end further up, from there."""
    lines = "".join(f"G1 X{1 + number % 2}\n" for number in range(20_000))
    head = "G21 G90 G61\nG0 X0 Y0 Z50 A0 C0\nM3 S1\nG1 X1 F6000\n"
    options = vp.Options(tool_length=80.0, wcs=OPTIONS.wcs, dialect="rs274")
    for text, where in (
        (f"{head}{lines}M2\nX9\n", "line 20006 moves"),
        (f"{head}M2\n{lines}", "lines 6 to 10005 move"),
    ):
        found = vp.check(text, "verne", options, limits_only=True).findings
        assert [where in item.message for item in found if item.code == "VP051"] == [True]


@pytest.mark.parametrize(
    ("home", "message"),
    [
        ("G28 Z0", "50 mm down to Z0"),
        ("G90 G28 X5 Z20", "30 mm down to Z20"),
        ("G30 P2 Z49", "1 mm down to Z49"),
        ("G91 G28 Z0\nG90", None),
        ("G28 Z50", None),
        ("G28 Z60", None),
        ("G28 X0 Y0", None),
        ("G53 Z0", None),
    ],
)
def test_a_way_home_that_goes_down_first_is_reported(home, message):
    text = FANUC.format(f"{home}\nG0 X0 Y0 Z50\n", "M30\n")
    found = find("VP052", text, "fanuc")
    assert [line for line, _message in found] == ([7] if message else [])
    assert all(message in text for _line, text in found)


def test_a_way_home_before_any_z_is_reported():
    ((line, message),) = find("VP052", FANUC.replace("G54 G0", "G28 Z0\nG54 G0").format("", "M30\n"), "fanuc")
    assert line == 4 and "goes by Z0 of the part first" in message


def test_a_way_home_without_a_length_and_without_g91_names_g91():
    """It was VP034, whose remedy, a length before it, led to VP052."""
    lines = "G21 G90 G54\nT1 M6\nG43 H1\nM3 S900\nG0 X0 Y0 Z90 A0 C0\nG1 Z60 F100\nG0 Z90\nG49\nG28 Z0\nM30\n"
    options = vp.Options(wcs={1: vp.WorkOffset((0.0, 0.0, 40.0))}, tools={1: 80}, dialect="fanuc")
    (found,) = (item for item in vp.check(lines, "verne", options).findings if item.severity == "error")
    assert (found.code, found.line) == ("VP052", 9)
    assert "its tip goes 40 mm below the table face: write G91 G28 Z0, then G90" in found.message
