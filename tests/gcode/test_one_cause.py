"""One cause, one finding: what only follows from an error is not reported, and other languages are named."""

from pathlib import Path

import pytest

import verne_post as vp
from tests.builders import check_unplanned as check
from verne_post.gcode.languages import find_other_language
from verne_post.gcode.machining.watcher import place_at_plane
from verne_post.gcode.tools import read_tool_table
from verne_post.model.findings import InputError, make_finding
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool
from verne_post.output.findings import describe_remedy, format_finding

HEAD = "G21 G90\nG0 X0 Y0 Z100 A0 C0\n"


def found(machine, program, **options):
    """Code, first and last line, and count of every finding of a program."""
    result = check(
        f"{HEAD}{program}\nM30".encode(), machine, Options(dialect="rs274", wcs={"G54": (0, 0, 0)}, **options)
    )
    return [(item.code, item.line, item.last_line, item.count) for item in result.findings]


@pytest.mark.parametrize(("program", "wanted"), [
    # a tool length that is missing, once, and what comes after it
    ("G1 X1 F100\n" + "X2\n" * 49 + "G91 X1\nG2 X5 I2.5", [("VP012", 3, 3, 1)]),
    ("T5 M6\nG43 H5\nG1 X5 F100\nG41 D5\nX50\nG40", [("VP012", 4, 4, 1)]),
    ("G43\nG1 X5 F100", [("VP012", 3, 3, 1)]),
    # the same words, wherever they stand
    ("G49\nM200 P5\nG0 X1\nM200 P6\nM201", [("VP002", 4, 7, 3)]),
    ("G49\nG1 X1 B5 F100\nX2 B6\nG3 X4 I1 B7", [("VP011", 4, 6, 3)]),
    # what the words of a refused block would have set
    ("G49\nG1 X1 F100 P5\nX2\nG91 X1\nG2 X5 I2.5", [("VP006", 4, 4, 1)]),
    ("G49\nG1 X1.2.3 Y5 F100\nX2\nG91 X1\nG2 X5 I2.5", [("VP001", 4, 4, 1)]),
    ("G49\nG1 G2 X1 F100\nX2", [("VP003", 4, 4, 1)]),
    ("G49\nG1 X1\nX2\nG93 G1 X3\nG1 X4", [("VP009", 4, 4, 1), ("VP009", 6, 7, 2)]),
    ("G49\nF100 G2 X1 Y8 I5\nG3 X5 I2\nG91 G1 X1", [("VP008", 4, 4, 1)]),
    ("G49\nG80\nX1\nY5\nG1 X2 F100", [("VP005", 5, 5, 1)]),
    # numbers as large as those that tools with names get here
    ("T3090588 M6\nG43\nG1 X5 F100", [("VP012", 4, 4, 1)]),
    ("G49\nG68 X0 Y0 R30\nG1 X5 F100\nG91 X2\nG2 X4 I2", [("VP002", 4, 4, 1)]),
    ("G49 F100\nG41.1 D9\nG1 X4\nX9\nX20\nG40\nG2 X30 I5", [("VP026", 5, 5, 1)]),
    # a second mistake is not hidden by the first
    ("G49\nG1 X1 F100 P5\nG1 Q2\nG2 X9 Y9 I1", [("VP006", 4, 4, 1), ("VP006", 5, 5, 1), ("VP008", 6, 6, 1)]),
    ("G49\nM200 M201", [("VP002", 4, 4, 2)]),
    ("G49 F100\nG0 X(\nG2 X9 Y9 I1\nG0 X5\nG2 X8 Y8 I1", [("VP001", 4, 4, 1), ("VP008", 7, 7, 1)]),
])  # fmt: skip
def test_one_cause_is_one_finding(machine, program, wanted):
    assert found(machine, program) == wanted


#: Paths are 8 mm apart: more than the diameter of the tool that stands in for one that is not known.
POCKETS = "D1\nS900 M3 F99\nG0 X0 Y0 Z9\n" + "POCKET4(5,0,2,-6,12,0,0,3,0.1,0.1,600,200,0,21,8,,,4,2,,)\n" * 2


@pytest.mark.parametrize(("program", "wanted"), [
    ("G1 X0 Y0 Z0 F1000\nX=IC(10)\nG2 X5 CR=30", [("VP012", 1, 1)]),
    ("G1 X0 Y0 Z0\nX=IC(10)\nG2 X5 CR=30", [("VP009", 1, 1), ("VP012", 2, 2)]),
    ("G0 X0 Y0 Z=FOO(1) A0 C0 D1\nG1 X5 F100\nX=IC(3)\nG2 X5 Y3 CR=30", [("VP002", 1, 1), ("VP012", 2, 2)]),
    ("G1 F=QUX X0 Y0 Z0 A0 C0\nX5\nX=IC(3)", [("VP025", 1, 1), ("VP012", 2, 2)]),
    ("G0 X0 Y0 Z60 A0 C0\nTRAORI\nG1 A10 F9\nTRAFOOF,\nSUPA Z0", [("VP012", 3, 3), ("VP001", 4, 4)]),
    ("G0 X0 Y0 Z0 A0 C0 D1\nGG1 G1 X9 F9", [("VP001", 2, 2)]),
    ("G0 X0 Y0 Z9 A0 C0\nS9 M3 F9\nCYCLE81(5,0,2,-6)\nG0 X9\nCYCLE81(5,0,2,-6)", [("VP012", 3, 3)]),
    ("G0 X0 Y0 Z0 A0 C0\nG1 9 F9 D1\nG2 X5 Y9 CR=1", [("VP001", 2, 2), ("VP012", 3, 3)]),
    ("G0 X0 Y0 Z0 A0 C0 WAITM\nG1 X=IC(4) F100\nCIP X1 I1=4", [("VP002", 1, 1), ("VP012", 2, 2)]),
    ("M6\nPOCKETS", [("VP041", 1, 1), ("VP012", 5, 5)]),
    ('T="MILL\nM6\nPOCKETS', [("VP001", 1, 1)]),
    ('T="MIL"\nM6\nPOCKETS', [("VP012", 1, 1)]),
])  # fmt: skip
def test_a_siemens_block_that_lacks_a_tool_or_f_is_one_finding(machine, program, wanted):
    tools = {"MILL": (60.0, 12.0)} if "POCKETS" in program else None
    options = Options(dialect="siemens", wcs={"G54": (0, 0, 0)}, tools=tools)
    findings = check(f"{program.replace('POCKETS', POCKETS)}\nM30".encode(), machine, options).findings
    assert [(item.code, item.line, item.last_line) for item in findings] == wanted
    assert all("G43" not in item.message for item in findings)


@pytest.mark.parametrize(
    ("after", "code", "place"),
    [
        ("G0 Z60\nG0 X40 Y40\nX42\nG2 X46 Y40 CR=2\nG1 X40", "VP026", "rapid of line 10"),
        ("G0 Z60", "VP017", "M6 under"),
    ],
)
def test_a_siemens_contour_that_nothing_ends_is_one_finding(machine, after, code, place):
    """G40 was forgotten: each change of tool, plane, offset or side after it was an error of its own."""
    contour = "G1 Z41 F500\nG41 X-10 Y-10\nY10\nX10\nY-10\nX-10\n"
    rest = (
        "\nT2 D1 M6\nS1 M3\nG0 Z60\nCYCLE81(50,40,2,37)\nTRANS X10\nTRANS\nG18\nG17\nG0 A20\nA0\nX0 Y0\n"
        "G42 X20 Y20\nX30\nG40 X40\nM30"
    )
    tools = read_tool_table("T1 P1 Z50 D10\nT2 P2 Z90 D10\n", "t.tbl")
    options = Options(dialect="siemens", tools=tools, wcs={"G54": (0, 0, 0)})
    program = f"T1 D1 M6\nS1 M3\nG0 X-20 Y-20 Z50 A0 C0\n{contour}{after}{rest}"
    [finding] = [one for one in check(program.encode(), machine, options).findings if one.severity == "error"]
    assert finding.code == code
    assert place in finding.message
    assert "G41 of line 5 is still in force" in finding.message
    assert "write G40" in finding.message


@pytest.mark.parametrize("call", ["", ","])
def test_what_follows_from_a_comma_too_many_is_not_told(machine, call):
    """_DIR is then taken for _FR_I; the table, which CYCLE800 was to turn, turns later with axes that nobody names."""
    cycle = f'CYCLE800(0,"",0,57,0,10,5,25,0,0{call},0,0,0,-1)'
    tool = "T{} D1 M6\nS900 M3\nG0 A0 C0\nX0 Y0\n"
    program = (
        f"G17 G90 G94 G710 G54\n{tool.format(1)}Z80\n{cycle}\nG1 X5 F100\nCYCLE800()\n{tool.format(2)}G1 X5\nM30\n"
    )
    tools = read_tool_table("T1 P1 Z50 D6\nT2 P2 Z90 D6\n", "t.tbl")
    options = Options(dialect="siemens", tools=tools, wcs={"G54": (0, 0, 0)}, split_at_stops=True)
    found = [(item.code, item.line) for item in check(program.encode(), machine, options).findings]
    if call:
        assert found == [("VP007", 7)]
    else:
        assert ("VP046", 12) in found


def test_a_change_to_a_tool_without_a_number_lacks_no_t(machine):
    """The T whose name has no number was told, and the M6 after it as one without T."""
    program = (Path(__file__).parents[1] / "corpus/siemens/blade.mpf").read_bytes()
    options = Options(dialect="siemens", tools=read_tool_table("T1 P1 Z50 D6\n", "t.tbl"), wcs={"G54": (0, 0, 0)})
    findings = check(program, machine, options).findings
    assert [one.line for one in findings if one.code == "VP012" and "BALL_MILL_8" in one.message] == [16]
    assert "VP041" not in [one.code for one in findings]


def test_tools_that_the_table_lacks_are_one_finding_with_their_numbers(machine):
    table = read_tool_table("T1 P1 Z50 D6\n", "t.tbl")
    program = "T7 M6\nG43\nG41\nG40\nG43 H8\nG43 H8"
    assert found(machine, program, tools=table) == [("VP012", 3, 7, 2)]


@pytest.mark.parametrize(("program", "wanted"), [
    # what comes after the end point of a refused move: arcs by their radius, about a pole, tangential ones, steps
    ("L X+50 Y+0 FZ0.1\nCR X+60 Y+10 R+10 DR+", [("VP002", 4, 4)]),
    ("L X+50 Y+0 R+\nCC X+50 Y+10\nC X+60 Y+10 DR+", [("VP002", 4, 4)]),
    ("L X+50 Y+0 FOO\nCC X+50 Y+10\nC X+60 Y+10 DR+", [("VP001", 4, 4)]),
    ("L X+50 Y+0 B+5\nCR X+60 Y+10 R+10 DR+", [("VP011", 4, 4)]),
    ("CC X+20 Y+0\nC X+45 Y+0 DR+\nCC X+45 Y+10\nC X+55 Y+10 DR+", [("VP008", 5, 5)]),
    ("CC X+20 Y+0\nC X+40 Y+0\nCT X+50 Y+10", [("VP005", 5, 5)]),
    ("CC X+50 Y+0\nLP PR+10 PA+0 FOO\nCP IPA+90 DR+\nCR X+60 Y+0 R+20 DR+\nL IX+5 FOO\nCR X+65 Y+30 R+15 DR+",
     [("VP001", 5, 5), ("VP001", 8, 8)]),
    ("L IX+50 Y+0 FZ0.1\nL IX+10\nCR X+70 Y+10 R+10 DR+", [("VP002", 4, 4)]),
    ("L X+50 Y+0 RND\nRND R5\nL X+60 Y+10\nCR X+70 Y+20 R+10 DR+", [("VP001", 4, 4)]),
    ("APPR LT X+50 Y+0 LEN5 FOO\nL X+60\nCR X+70 Y+10 R+10 DR+", [("VP001", 4, 4)]),
    ("L A+20 C+30 FOO\nM128\nL X+50 Y+0 FMAX\nCR X+60 Y+10 R+10 DR+", [("VP001", 4, 4)]),
    # modes, poles and computed positions
    ("L X+50 Y+0 M128 FOO\nLN X+60 Y+10 TX+0 TY+0 TZ+1", [("VP001", 4, 4)]),
    ("CC X+20 Y+0 Q\nC X+40 Y+0 DR+\nLP PR+5 PA+0", [("VP001", 4, 4)]),
    ("PLANE SPATIAL SPA+10 SPB+0 TURN FMAX\nL A+Q120 C+Q122 FMAX", [("VP005", 4, 4)]),
    ("PLANE SPATIAL SPA+0 SPB+200 SPC+0 STAY SEQ+\nL A+Q120 C+Q122 FMAX", [("VP102", 4, 4)]),
    # a word that is misspelt so far that the line says nothing
    ("X+50 Y+0\nCR X+70 Y+10 R+5 DR+", [("VP001", 4, 4)]),
    ("CYCL 200 DRILLING\nCYCL CALL", [("VP002", 4, 4)]),
    # a second mistake is not hidden by the first
    ("L X+50 Y+0 FOO\nCR X+60 Y+10 R+1 DR+\nL X+60 BAR", [("VP001", 4, 4), ("VP008", 5, 5), ("VP001", 6, 6)]),
])  # fmt: skip
def test_a_refused_klartext_move_still_sets_its_end_point(machine, program, wanted):
    head = "BEGIN PGM A MM\nTOOL CALL 1 Z S5000 F500\nL X+0 Y+0 Z+100 A+0 C+0 R0 FMAX M3\n"
    options = Options(wcs={"G54": (0, 0, 0)}, tool_length=80.0)
    result = check(f"{head}{program}\nEND PGM A MM".encode(), machine, options)
    assert [(item.code, item.line, item.last_line) for item in result.findings] == wanted


def test_r0_without_a_move_in_the_plane_is_one_finding(machine):
    """The block after it, and the retract in machine coordinates, had one each."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0)}
    text = (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S5000 F500\nL X+0 Y+0 Z+100 A+0 C+0 R0 FMAX M3\n"
        "L X+20 RL F100\nL X+40\nL Z+150 R0 FMAX\nL Z-1 R0 FMAX M91\nEND PGM A MM\n"
    )
    findings = check(text.encode(), machine, Options(wcs={"G54": (0, 0, 0)}, tools=tools)).findings
    assert [(item.code, item.line) for item in findings] == [("VP017", 6)]


@pytest.mark.parametrize("first", ["L X+0 Y+0 Z+50 F100 FOO", "L X+0 Y+0 Z+50 FZ0.1"])
def test_a_refused_first_klartext_move_makes_its_axes_known(machine, first):
    text = f"BEGIN PGM A MM\nTOOL CALL 1 Z S5000\n{first}\nL IX+5\nCR X+15 Y+10 R+10 DR+\nEND PGM A MM\n"
    findings = check(text.encode(), machine, Options(wcs={"G54": (0, 0, 0)}, tool_length=80.0)).findings
    assert [item.line for item in findings] == [3]


#: The tool n in a program of each dialect, what stands before the first and after the last one, and what the first is
#: called.
MANY_TOOLS = {
    "rs274": (HEAD, "T{n} M6\nG43 H{n}\nG0 Z50\nG1 X50 F100\nG0 Z100\n", "M30", "tool 1"),
    "fanuc": (f"%\nO1\n{HEAD}", "T{n} M6\nG43 H{n}\nG0 Z50\nG1 X50 F100\nG0 Z100\n", "M30\n%", "tool 1"),
    "siemens": (
        HEAD.replace("G21", "G71"),
        'T="MILL{n}"\nM6\nD1\nG0 Z50\nG1 X50 F100\nG0 Z100\n',
        "M30\n",
        'tool "MILL1"',
    ),
    "heidenhain": (
        "BEGIN PGM A MM\n",
        "TOOL CALL {n} Z S5000\nL X+0 Y+0 Z+100 R0 FMAX M3\nL X+50 F200\nL X+0\n",
        "END PGM A MM\n",
        "tool 1",
    ),
}


@pytest.mark.parametrize("dialect", MANY_TOOLS)
def test_many_tools_without_a_table_are_one_finding_and_the_work_offset_is_asked_for_with_them(machine, dialect):
    before, each, after, first = MANY_TOOLS[dialect]
    text = before + "".join(each.format(n=number) for number in range(1, 61)) + after
    by_code = {item.code: item for item in check(text.encode(), machine, Options(dialect=dialect)).findings}
    tools = by_code["VP012"]
    assert {code: item.severity for code, item in by_code.items()} == {"VP012": "error", "VP033": "warning"}
    assert tools.message.startswith(first) and "and 53 more: " in tools.message
    assert tools.last_line > 4 * 59
    placed = check(text.encode(), machine, Options(dialect=dialect, wcs={"G54": (0, 0, 9)})).findings
    assert [item.code for item in placed] == ["VP012"]
    one = check(text.encode(), machine, Options(dialect=dialect, tool_length=80.0)).findings
    assert sorted(item.code for item in one) == ["VP018", "VP033"]
    assert any("52 more" in item.message for item in one)


def test_stops_for_a_person_are_one_finding(machine):
    program = "G49\nG1 X1 F100\n" + "M0\nG1 X2\nG1 X1\n" * 40
    assert found(machine, program) == [("VP014", 5, 4 + 3 * 39 + 1, 40)]


def test_a_finding_names_few_tools_one_by_one(machine):
    program = f"{HEAD}T1 M6\nG43 H1\nG1 X1 F100\nT2 M6\nG43 H2\nG1 X2\nM30"
    (item,) = check(program.encode(), machine, Options(dialect="rs274", wcs={"G54": (0, 0, 0)})).findings
    assert item.message.startswith("tool 1 and tool 2: the length is in no set-up and in no tool table")


def test_findings_say_where_else_and_what_settles_them(machine):
    (item,) = check(f"{HEAD}G49\nM200\nM200\nM30".encode(), machine, Options(dialect="rs274")).findings
    assert item.message.startswith("M200: no meaning in this language")
    assert item.settled_by == (("remap", "M200"),)
    shown = format_finding("a.nc", item)
    assert shown.startswith("a.nc:4:1: VP002 error: M200: ") and shown.endswith(" (lines 4 to 5, 2 times)")


def test_apt_statements_go_on_too(machine):
    text = (
        "PARTNO X\nMULTAX/ON\nFROM/0,0,100,0,0,1\nFEDRAT/100\nGOTO/1,0,90\nGOTO/2,0,90\nINSERT X\nGOTO/3,0,90\nFINI\n"
    )
    result = check(text.encode(), machine, Options(wcs={"G54": (0, 0, 0)}))
    assert [(item.code, item.line) for item in result.findings] == [("VP012", 5), ("VP002", 7)]


# --- other languages ------------------------------------------------------------------------------------

LANGUAGES = {
    "Heidenhain Klartext": "0 BEGIN PGM A MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-4\n2 L X+5 R0 FMAX\n3 END PGM A MM",
    "Siemens": ";$PATH=/_N_WKS_DIR\nN10 G54 G0 X=5\nTRAORI\nM30",
    "DIN/ISO": "%NEU G71 *\nN10 G30 G17 X+0 Y+0 Z-40 *\nN20 G00 X+5 *",
    "APT": "G0 X1\nGOTO/0,0,0\nFINI",
    "Okuma": "G15 H1\nVC1=5\nCALL O100\nM30",
    "Fagor": "G0 X1\n#RTCP ON\nM30",
    "NUM": "%10\nN10 G79 N30\nE80000=5\nM02",
    "robot": "&ACCESS RVP\nDEF part ( )\nPTP HOME\nEND",
    "printer": "M140 S60\nM104 S200\nG28\nG1 E5 F100",
    "Excellon": "M48\nMETRIC,TZ\nT1C0.8\n%\nX1Y1",
    "Gerber": "%FSLAX46Y46*%\n%MOMM*%\nD10*\nX0Y0D02*",
    "STEP": "ISO-10303-21;\nHEADER;",
    "DXF": "  0\nSECTION\n  2\nHEADER",
    "STL": "solid part\nfacet normal 0 0 1",
    "XML": "<?xml version='1.0'?>\n<a/>",
    "JSON": '{"G": 1}',
    "PDF": "%PDF-1.4\n...",
    "binary": "G0\n\x01\x02\x03\x04\x05\n",
}


@pytest.mark.parametrize("name", LANGUAGES)
def test_another_language_is_one_finding(machine, name):
    result = check(LANGUAGES[name].encode(), machine, Options(dialect="rs274"))
    assert [item.code for item in result.findings] == ["VP032"]
    assert name in result.findings[0].message


def test_it_names_the_dialect_that_reads_the_text(view):
    (item,) = view("G0 X1\nGOTO/0,0,0\nFINI", dialect="rs274")[1]
    assert (item.code, item.line) == ("VP032", 2)
    assert "--dialect aptcl" in item.message


@pytest.mark.parametrize(
    "text",
    [
        "Hello dear reader\nthis is a letter, of 3 pages.\nBye",
        "import os\n\nprint(os.stat)\n",
        "x,y,z\n1.0,2.0,3.0\n4.0,5.0,6.0\n",
        "Teil 12, Werkzeug: Schaftfräser\nNullpunkt oben links\n",
    ],
)
@pytest.mark.parametrize("dialect", ["auto", "rs274", "fanuc", "siemens", "heidenhain", "aptcl"])
def test_a_text_of_no_language_is_one_finding(view, text, dialect):
    (item,) = view(text, dialect=dialect)[1]
    assert (item.code, item.line) == ("VP032", 1)
    assert text.splitlines()[0][:20] in item.message


@pytest.mark.parametrize(
    "program",
    [
        "G0 X1 P5\n(TRAORI)\nM2",
        "G0 X1 P5\nM0 ; GOTO/0,0\nM2",
        "(#RTCP ON)\nG0 Q5\nM2",
        "o1 if [1]\nG0 Q1\no1 endif\nM2",
        "M140 P1\nM2",
        "#1=5\nG0 X#1 Q2\nM2",
        "G1 X1,5 F100\nX2,5\nX3,5\nM2",
        "X\nM2",
        "G1 X 5mm\nY 5mm\nM2",
        "G0 X1\n\x01\nM2",
    ],
)
def test_a_mistake_in_a_program_of_the_language_is_shown(view, program):
    (item,) = view(program, dialect="rs274")[1]
    assert item.code != "VP032"


@pytest.mark.parametrize(("name", "codes"), [("PDF", ["VP032"]), ("DIN/ISO", ["VP032"])])
def test_a_percent_does_not_hide_what_a_file_is(machine, name, codes):
    assert [item.code for item in check(LANGUAGES[name].encode(), machine, Options()).findings] == codes


def test_a_text_that_begins_as_its_dialect_is_of_no_other(view):
    found = view("%\nO1\nG0 X5\nTRANS X10\nM30\n%")[1]
    assert [item.code for item in found] == ["VP001"]


def test_what_can_be_read_is_read_whatever_it_looks_like(view):
    assert view("(BEGIN PGM A MM)\n(0 BEGIN PGM A MM)\nG0 X1 ; PARTNO\nM2")[1] == ()


def test_a_language_that_gets_a_dialect_is_named_with_it():
    text = b"0 BEGIN PGM A MM"
    assert find_other_language(text, (), "rs274", ["rs274", "heidenhain"]).message.endswith("--dialect heidenhain")
    assert "which is not read" in find_other_language(text, (), "rs274", ["rs274"]).message
    assert find_other_language(text, (), "heidenhain", ["rs274", "heidenhain"]) is None


@pytest.mark.parametrize(
    ("head", "said"), [("G71 G90", "G43 is not"), ("G90 G17\nT1 D1", "G43 is not"), ("G291\nG90 G21", "G291 is not")]
)
def test_a_siemens_program_with_g43_is_one(view, head, said):
    found = view(f"{head}\nG0 X0 Y0\nG43 H1 Z50\nM30\n", dialect="siemens")[1]
    assert any(item.code == "VP002" and item.message.startswith(said) for item in found)


@pytest.mark.parametrize("dialect", ["heidenhain", "siemens", "aptcl"])
@pytest.mark.parametrize(("head", "meant"), [("%\nO4711 (CAP)\n", "fanuc"), ("G90 G17\n", "rs274")])
def test_blocks_in_another_language_are_one_error(view, dialect, head, meant):
    text = f"{head}(T3 D16 ENDMILL)\nN10 G21 G17 G49\nN40 T3 M6\nN80 G43 H3 Z60. M8\nN100 G1 Z-3. F400.\nM30\n"
    (item,) = view(text, dialect=dialect)[1]
    assert item.code == "VP032"
    assert item.message.endswith(f"--dialect {meant}")
    assert "VP032" not in [one.code for one in view(f"{text}BAD\n", dialect=meant)[1]]
    assert "VP032" not in [one.code for one in view("O100 sub\nBAD\nO100 endsub\nM2\n", dialect="rs274")[1]]


@pytest.mark.parametrize("call", ['T="MILL10"\nM6\nD1', 'T="MILL10" M6'])
def test_a_name_without_a_number_is_one_finding(view, call):
    text = f"G71 G90 G54\n{call}\nG0 X0 Y0 Z50\nG1 Z-1 F500 S1000 M3\nG41 X10 Y10\nX30\nG40 Y40\nM30\n"
    errors = view(text, dialect="siemens", tools=read_tool_table("T1 Z80 D10\n", "t.tbl"))[1]
    assert [(item.code, item.line) for item in errors] == [("VP012", 2)]


def test_of_two_near_names_of_tools_both_are_named(machine):
    options = Options(dialect="siemens", tools={"MILL_D10": (80.0, 10.0), "MILL_D12": (80.0, 12.0)})
    (item,) = check(b'G17 G90 G54\nT="MILL_D13" M6\nD1\nG0 X0 Y0 Z60\nM30\n', machine, options).errors
    assert item.message.endswith("; MILL_D10 or MILL_D12 may be meant")
    assert [(one.value, one.misspelt, one.is_choice) for one in item.edits] == [
        ("MILL_D10", "MILL_D13", True),
        ("MILL_D12", "MILL_D13", True),
    ]
    assert item.advice == ""


@pytest.mark.parametrize(
    ("row", "said"), [("T1 Z-80", "has the length -80 mm"), ("T1 Z80 X2", "has offsets other than a length (Z)")]
)
def test_a_tool_that_cannot_be_used_is_named_with_its_row(machine, row, said):
    options = Options(tools=read_tool_table(f"T2 Z90\n{row}\n", "t.tbl"), wcs={"G54": (0, 0, 0)})
    (item,) = [one for one in check(f"{HEAD}G43 H1\nM30".encode(), machine, options).findings if one.code == "VP007"]
    assert item.message.startswith(f"t.tbl:2: tool 1 {said}")


def test_one_length_is_not_offered_for_several_tools(machine):
    program = f"{HEAD}G43 H11\nG1 Z9 F500\n{{}}M30".format
    for more, offered in (("", True), ("G43 H12\nG1 X10\nG43 H13\nG1 X10\n", False)):
        options = Options(tools=read_tool_table("T1 Z80\n", "t.tbl"), wcs={"G54": (0, 0, 0)})
        (item,) = check(program(more).encode(), machine, options).findings[:1]
        assert ("tool_length=MM" in item.message) == offered, item.message


def test_a_code_of_tool_length_is_named_where_a_motion_code_is_meant(view):
    ((code, text),) = [
        (item.code, item.message)
        for item in view(
            "O1\nG21\nG49\nG43.4 H1 X10. Y5.\nM30", dialect="fanuc", tools=read_tool_table("T1 Z80\n", "t.tbl")
        )[1]
    ]
    assert code == "VP005"
    assert text.endswith("G43.4 is none: write G0 beside it")


def test_a_departure_names_the_end_point_that_lies_in_its_arc(view):
    text = (
        "BEGIN PGM A MM\n"
        "TOOL CALL 1 Z S900\n"
        "L X+0 Y+0 Z+50 R0 FMAX M3\n"
        "APPR LT X+10 Y+20 Z-5 LEN15 RL F500\n"
        "L X+50\n"
        "{}\n"
        "END PGM A MM\n"
    )
    ((first, second),) = [
        [
            view(text.format(last), dialect="heidenhain", tools=read_tool_table("T1 Z80 D10\n", "t.tbl"))[1]
            for last in ("DEP LCT X+51 Y+33 R8", "L X+60 Y+20\nDEP LT LEN9")
        ]
    ]
    assert second == ()
    assert [item.code for item in first] == ["VP008"]
    assert "the end point of the departure lies inside the arc" in first[0].message


TILTED = (
    "G90 G17 G21\nT1 M6\nS3000 M3\nG54\nG0 A0. C0.\nG68.2 X0. Y-25. Z0. I0. J30. K0.\n{}G0 X-15. Y5.\nG43 Z60. H1\n"
    "Z8.\nG1 Z-1. F400.\nX15. F1500.\nG3 X15. Y11. I0. J3.\n{}G0 Z60.\nG69\nG0 A0. C0.\nM30\n"
)


@pytest.mark.parametrize(
    ("turn", "more", "wanted"),
    [
        ("", "G1 X0.\nY5.\nX15.\nG3 X15. Y11. I0. J3.\n", [12]),  # each such arc is the same cause
        ("", "G1 X0.\nY5.\nX15.\nG3 X15. Y11. I0. J4.\n", [12, 16]),  # this one is wrong by itself
        ("G53.1\n", "", []),
    ],
)
def test_arcs_in_a_plane_to_which_nothing_turns_the_table_are_one_finding(turn, more, wanted):
    tools = {1: Tool(1, 1, (0.0, 0.0, 100.0, *(0.0,) * 6), 8.0)}
    options = Options(dialect="fanuc", wcs={"G54": (0, 0, 80)}, tools=tools)
    findings = check(TILTED.format(turn, more).encode(), vp.load_machine("ac_trunnion"), options).findings
    assert [item.line for item in findings if item.code == "VP008"] == wanted
    for item in findings[: len(wanted[:1])]:
        assert "nothing turns the table to it" in item.message
        assert [(one.value, one.line, one.way) for one in item.edits] == [("G53.1", 6, "below")]
        assert "line 6 is in force" in item.message


def test_an_arc_of_a_called_file_names_a_plane_of_the_main_program():
    """Line 6 of the called file was understood."""
    begin, arcs = TILTED.format("", "").partition("G0 X-15.")[::2]
    called, end = f"G0 X-15.{arcs}".partition("G69")[::2]
    tools = {1: Tool(1, 1, (0.0, 0.0, 100.0, *(0.0,) * 6), 8.0)}
    files = {"o400": f"%\nO400\n{called}M99\n%\n".encode()}
    options = Options(dialect="fanuc", wcs={"G54": (0, 0, 80)}, tools=tools, subroutines=files)
    (item,) = check(f"{begin}M98 P400\nG69{end}".encode(), vp.load_machine("ac_trunnion"), options).findings
    assert "G68.2 in line 6 of the main program is in force" in item.message


@pytest.mark.parametrize(
    ("dialect", "head", "wrong", "arc"),
    [
        ("rs274", "G17 G21 G90 G94\nG0 X-40 Y0 Z60 A0 C0", "G1 X-3500 F500", "G3 X-30 Y0 I5 J0"),
        ("rs274", "G17 G21 G90 G94\nG0 X-40 Y0 Z60 A0 C0", "G1 X-3500 F500", "G3 X-30 Y10 R12"),
        ("siemens", "G17 G71 G90 G94\nG0 X-40 Y0 Z60 A0 C0", "G1 X-3500 F500", "G3 X-20 Y10 I=AC(-30) J=AC(10)"),
        ("heidenhain", "BEGIN PGM A MM\nL X-40 Y0 Z60 A0 C0 FMAX", "L X-3500 F500", "CC X-30 Y10\nC X-20 Y10 DR+"),
    ],
)
def test_an_arc_that_begins_out_of_reach_is_the_fault_of_the_line_before(dialect, head, wrong, arc):
    """A slip of the point in X-35.00 was reported at the arc behind it, which was right."""
    end = "L M30\nEND PGM A MM\n" if dialect == "heidenhain" else "M30\n"
    source = f"{head}\n{wrong}\n{arc}\n{end}"
    options = Options(dialect=dialect, tool_length=80.0, wcs={"G54": (0, 0, 60)})
    (found,) = check(source, "verne", options).findings
    assert (found.code, found.line) == ("VP008", 3)
    line = 3 + len(arc.splitlines())
    assert found.message.startswith(
        f"X-3500 Y0 Z60 is out of the reach of the machine, and the arc of line {line} begins"
    )
    # an arc that begins within reach is wrong itself; so is one of a part that stands out of reach as a whole
    for near, wcs in (("-80", 60), ("-3500", 6000)):
        options = Options(dialect=dialect, tool_length=80.0, wcs={"G54": (0, 0, wcs)})
        (found,) = check(source.replace("-3500", near), "verne", options).findings
        assert (found.code, found.line) == ("VP008", line)


HEAD_S = "N10 G90 G17 G71 G94\nT1 D1\nM6\nS900 M3\nG54\n"


@pytest.mark.parametrize(
    ("dialect", "source", "code", "line", "says"),
    [
        # TRAORI was asked for in each line behind its misspelt word
        ("siemens", HEAD_S + "TRORI\nG0 X0 Y0 Z60 A0 C0\nG1 X9 A5 F500\nG1 X0 A0\nM30\n", "VP002", 6, "TRAORI?"),
        # the word T was replaced by the name of the tool alone
        ("siemens", HEAD_S.replace("T1", 'T="MIL"') + "G0 X0 Y0 Z60\nM30\n", "VP012", 2, 'did you mean T="MILL"?'),
        # F AUTO lacked the F of a TOOL CALL whose tool has no number
        (
            "heidenhain",
            'BEGIN PGM A MM\nTOOL CALL "MIL" Z S600 F800\nL X0 Y0 Z60 A0 C0 FMAX M3\nL X9 F AUTO\nM30\n',
            "VP012",
            2,
            "MILL?",
        ),
        # cycle 206 lacked the S of a TOOL CALL whose tool has no length, and Q108 and Q114 had no value
        (
            "heidenhain",
            "BEGIN PGM A MM\nTOOL CALL 1 Z S600 F800\nTOOL CALL 4 Z S600 F800\nQ1 = Q108 + Q114\n"
            "L X0 Y0 Z60 A0 C0 FMAX M3\nCYCL DEF 206 TAPPING Q200=2 Q201=-5 Q206=AUTO Q211=0 Q203=0 Q204=9\n"
            "CYCL CALL\nTOOL CALL 1 Z S600\nM30\n",
            "VP012",
            3,
            "tool 4: no entry",
        ),
        # the move lacked the feed rate of the misspelt statement
        (
            "aptcl",
            "UNITS/MM\nLOADTL/1,LENGTH,80\nSPINDL/RPM,500,CLW\nRAPID\nGOTO/0,0,60,0,0,1\nFEDRATE/MMPM,800\n"
            "GOTO/9,0,60,0,0,1\nFINI\n",
            "VP002",
            6,
            "FEDRAT?",
        ),
        # a letter in place of a digit was a word without a decimal point, too
        (
            "fanuc",
            "%\nO1\nG21 G90 G94\nT1 M6\nS900 M3\nG54 G0 X0. Y0. A0. C0.\nG43 Z60. H1\nG1 X3O. F500.\nM30\n%\n",
            "VP001",
            8,
            "did you mean X30.?",
        ),
    ],
)
def test_a_slip_is_told_once_and_what_would_be_right(dialect, source, code, line, says):
    tool = Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0)
    control = {"heidenhain": {"tools": {"MILL": 1}}, "siemens": {"tools": {"MILL": 1}}}
    options = Options(dialect=dialect, tools={1: tool}, wcs={"G54": (0, 0, 30)}, control=control)
    (found,) = check(source, "verne", options).findings
    assert (found.code, found.line) == (code, line)
    assert says in found.message


_STAY = """BEGIN PGM T MM
TOOL CALL 1 Z S1000
L X+0 Y+0 Z+60 A+0 C+0 R0 FMAX M3
PLANE SPATIAL SPA+20 SPB+0 SPC+0 STAY
L X+1 FMAX
CYCL DEF 200 D Q200=2 Q201=-5 Q206=9 Q202=2 Q210=0 Q203=0 Q204=9 Q211=0
CYCL CALL
L X+5 FMAX M99
PLANE RESET STAY
M30
END PGM T MM
"""
_HOLES = """TOOL PATH/A,TOOL,T1
LOAD/TOOL,1
SPINDL/RPM,2000,CLW
RAPID
GOTO/0,0,50
CYCLE/DRILL,DEPTH,5,IPM,100,CLEAR,2
GOTO/5,0,0
CYCLE/OFF
RAPID
GOTO/10,0,50
FEDRAT/500,MMPM
GOTO/10,0,40
FINI
"""
_INCREMENTAL = """G21 G90 G17 G40 G49 G94
T1 M6
S8000 M3
G43 H1
G0 X30 Y20 A0 C0
Z12
G1 Z5 F400
G3 X20 Y30 I-10 J0
G53 G0 Z0
M2
"""


@pytest.mark.parametrize(
    ("name", "program", "wanted"),
    [
        ("stay.h", _STAY, [("VP017", 5)]),
        ("holes.cls", _HOLES, []),
        ("of.cls", _HOLES.replace("OFF", "OF"), [("VP002", 8)]),
        ("kind.cls", _HOLES.replace("DRILL", "DRLL"), [("VP002", 6)]),
        ("other.cls", _HOLES.replace("CYCLE/OFF", "CYCLE/FOO,1"), [("VP002", 8)]),
        ("g90.nc", _INCREMENTAL, []),
        ("g91.nc", _INCREMENTAL.replace("G90", "G91"), [("VP013", 5)]),
    ],
)
def test_a_slip_that_later_lines_follow_from_is_one_finding(tmp_path, machine, name, program, wanted):
    """PLANE ... STAY, CYCLE/OF and G91 for G90 were up to three errors each."""
    (tmp_path / name).write_text(program)
    findings = check(tmp_path / name, machine, Options(tool_length=60.0, wcs={"G54": (0, 0, 60)})).findings
    assert [(item.code, item.line) for item in findings if item.severity == "error"] == wanted
    if name == "stay.h":
        assert findings[0].message.startswith("a motion and cycle 200 in a tilted plane that the tool is not normal to")
    if name in ("of.cls", "kind.cls"):
        assert f"did you mean {'OFF' if name[0] == 'o' else 'DRILL'}?" in findings[0].message


@pytest.mark.parametrize(
    ("name", "cut", "said"),
    [
        ("p.mpf", "R77=0\nG1 X5 F=R77", "G1 with feed rate zero; the last F has the value 0"),
        ("p.mpf", "G1 X5", "G1 with feed rate zero; give F"),
        ("p.mpf", "CYCLE81(20,0,2,-5)", "CYCLE81 with feed rate zero; give F"),
        ("p.mpf", "G1 X5 F9\nG95 X6", "G1 with feed rate zero; give F"),
        ("p.nc", "#7=0\nG1 X5 F#7", "G1 with feed rate zero; the last F has the value 0"),
        ("p.nc", "G1 X5", "G1 with feed rate zero; give F"),
        ("p.mpf", "TRAORI\nTRAFOOF\nG1 A9 F9", "without TRAORI, which TRAFOOF in line 3 has ended"),
        ("p.mpf", "G1 A9 F9", "without TRAORI: on a machine"),
    ],
)
def test_why_the_feed_rate_or_the_transformation_is_not_there(tmp_path, machine, name, cut, said):
    """F=R77 with R77 = 0 was told to give F."""
    (tmp_path / name).write_text(f"G17 G54 G90 G94 G0 X0 Y0 Z60 A0 C0 S9 M3\n{cut}\nM30\n")
    options = Options(tool_length=60.0, wcs={"G54": (0, 0, 60)}, dialect="auto" if name == "p.mpf" else "rs274")
    findings = check(tmp_path / name, machine, options).findings
    assert [said in item.message for item in findings if item.severity == "error"] == [True]


KLARTEXT = "BEGIN PGM A MM\n{}L X-20 Y-20 Z+40 A+0 C+0 R0 FMAX\nL X+0 Y-10 RL F500\nL Y+26\nL R0 X-30\nEND PGM A MM"
SIEMENS = "T1 D1\nS8000 M3\nG0 X-30 Y-20 Z80 A0 C0\nG41 G1 X-20 F500\nY20\nG40 X-30\nM30"


@pytest.mark.parametrize(("dialect", "program", "wanted"), [
    ("siemens", SIEMENS, ("VP012", 4, "G41: tool 1 of line 1 is only selected by T, and no M6 loads it; write M6 after "
                          "that T")),
    ("rs274", SIEMENS.replace("T1 D1", "T1 G49"),
     ("VP012", 4, "G41 without D, and tool 1 of line 1 is only selected by T, and no M6 loads it; write M6 after that "
      "T, or write G41.1 with the diameter (D0 for a path on the contour)")),
    ("heidenhain", KLARTEXT.format(""), ("VP012", 3, "no TOOL CALL before line 3, which needs the radius of the tool; "
                                         "write TOOL CALL with the number of the tool, Z and S; if this is a "
                                         "subprogram, check the program that calls it")),
    ("heidenhain", KLARTEXT.format("TOOL DEF 1\n"), ("VP012", 4, "no TOOL CALL before line 4, which needs the radius "
     "of the tool: TOOL DEF 1 in line 2 only names the tool; write TOOL CALL 1 Z S with its speed after it")),
    ("heidenhain", KLARTEXT.format("TOOL CALL 1 X S9\n"), ("VP017", 2, "tool axis X: the spindle of this machine "
                                                           "points along Z")),
])  # fmt: skip
def test_a_tool_that_is_not_in_the_spindle_is_one_finding_with_its_cause(machine, dialect, program, wanted):
    """The length of the tool is known, and nothing about it is to be filled in."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 0)}, tools=tools)
    errors = [item for item in check(program.encode(), machine, options).findings if item.severity == "error"]
    assert [(item.code, item.line, item.message) for item in errors] == [wanted]
    assert describe_remedy(errors[0], "a.nc") == ""


@pytest.mark.parametrize(
    ("dialect", "program", "place"),
    [
        ("heidenhain", KLARTEXT.format("TOOL CALL 1 Y S9\n"), (2, 13)),
        ("aptcl", "UNITS/MM\nMULTAX/OFF\nLOADTL/1\nRAPID\nGOTO/1,20,3,.5,0,.866\nFINI", (5, 13)),
    ],
)
def test_an_error_about_the_tool_axis_stands_at_it(machine, dialect, program, place):
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 0)}, tools=tools)
    found = [item for item in check(program.encode(), machine, options).findings if item.code == "VP017"]
    assert [(item.line, item.column) for item in found] == [place]


@pytest.mark.parametrize(
    ("dialect", "program", "says", "remedy"),
    [
        # [remap] takes no cycles
        (
            "heidenhain",
            "BEGIN PGM A MM\nCYCL DEF 999 FOO Q1=2\nEND PGM A MM",
            "lists the cycles that are",
            "Correct it if it is misspelt; if not, post the program without it. Take it out only if you know that "
            "nothing depends on it.",
        ),
        ("siemens", "T1 D1 M6\nSUPA G0 Z=_ZHOME D0\nM30", "write its value on top: DEF REAL _ZHOME=0", None),
        ("siemens", "DEF REAL ZHOME=9\nSUPA G0 Z=_ZHOME D0\nM30", "did you mean ZHOME?", None),
    ],
)
def test_a_remedy_is_one_of_the_language(machine, dialect, program, says, remedy):
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 0)}, tool_length=80.0)
    (item,) = (one for one in check(program.encode(), machine, options).findings if one.code in ("VP002", "VP025"))
    assert says in item.message
    assert remedy is None or describe_remedy(item, "a.nc") == remedy
    if "DEF REAL" in says:
        cured = check(f"DEF REAL _ZHOME=0\n{program}".encode(), machine, options).findings
        assert "VP025" not in [one.code for one in cured]


@pytest.mark.parametrize(
    ("on", "off", "wanted"),
    [
        ("M128", "", [("M91", 6)]),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS", "", [("M91", 6)]),
        ("M128", "M129\n", []),
        ("M128", "FUNCTION RESET TCPM\n", []),
    ],
)
def test_m128_before_m91_and_tool_call_is_told(machine, on, off, wanted):
    """Once for each M128: one M129 settles what follows."""
    tools = {number: Tool(number, number, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0) for number in (1, 2)}
    program = (
        f"BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 R0 FMAX M3\n{on}\nL X+20 F500\n{off}"
        "L Z-100 R0 FMAX M91\nL X+0 R0 FMAX M91\nTOOL CALL 2 Z S900\nL X+0 Y+0 Z+60 FMAX M3\nEND PGM A MM"
    )
    options = Options(dialect="heidenhain", wcs={"G54": (0, 0, 0)}, tools=tools, split_at_stops=True)
    found = [item for item in check(program.encode(), machine, options).findings if item.code == "VP043"]
    said = "M128 of line 4 is still in force at {}, before which controls require its end; write M129 first"
    assert [(item.message, item.severity, item.line) for item in found] == [
        (said.format(what), "warning", line) for what, line in wanted
    ]


def test_a_rounding_that_is_too_small_is_told_in_its_line(machine):
    """The line after it was told, and a second finding said that DEP has no RL, which the first had ended."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0)}
    program = (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S900 F500\nL X-60 Y-50 Z+60 A+0 C+0 R0 FMAX M3\n"
        "APPR LT X-45 Y-35 LEN10 RL\nL X-45 Y+35\nRND R{}\nL X-80 Y+35\nDEP LT LEN12\nL Z+60 FMAX\nEND PGM A MM"
    )
    options = Options(dialect="heidenhain", wcs={"G54": (0, 0, 0)}, tools=tools)

    def list_contour(radius):
        found = check(program.format(radius).encode(), machine, options).findings
        return [(item.code, item.severity, item.line) for item in found if item.code == "VP026"]

    assert list_contour(3) == [("VP026", "error", 6)]
    assert list_contour(6) == []


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        # G18 for G17: the cycle, the arc, and the corner beside it
        (("G17 G54", "G18 G54"), [("VP017", "G18 of line 1 is active; write G17", 2)]),
        # SUPA under TRAORI does not turn the table back, and the cycle is not at fault
        (("TRAFOOF\n", ""), [("VP017", "write TRAFOOF first", 2)]),
        (("M5", "M5"), []),
    ],
)
def test_a_siemens_plane_or_transformation_left_in_force_is_one_error(machine, change, wanted):
    program = (
        "G17 G54 G90 G94 G710\nT1 D1 M6\nS900 M3\nTRAORI\nG0 A0 C0\nX0 Y0 Z90\nA-10 C20\nTRAFOOF\n"
        "SUPA G0 Z0 D0\nSUPA G0 A0 C0\nG54 D1\nG0 X0 Y0\nZ90\nF300\nMCALL CYCLE81(90,70,2,60)\nX5 Y5\nMCALL\n"
        "G41 G1 X10 Y10\nX20\nG3 X30 Y20 I0 J10\nG1 Y30\nG40 X40\nG0 Z90\nM5\nM30"
    )
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0)}
    options = Options(dialect="siemens", wcs={"G54": (0, 0, 0)}, tools=tools)
    assert change[0] in program
    errors = [
        item for item in check(program.replace(*change).encode(), machine, options).findings if item.severity == "error"
    ]
    assert [(item.code, item.count) for item in errors if item.code[:3] == "VP0"] == [(a, b) for a, _, b in wanted]
    assert all(said in item.message for item, (_, said, _) in zip(errors, wanted, strict=False))


HEADS = {
    "fanuc": "O1\nG21 G90 G94\nT1 M6\nG43 H1\nS800 M3\nG0 X0. Y0. Z60. A0. C0. F100.\n{}\nM30",
    "siemens": "G17 G90 G94 G710\nT1 D1 M6\nS800 M3\nG0 X0 Y0 Z60 A0 C0\nF100\n\n{}\nM30",
    "heidenhain": "BEGIN PGM A MM\nTOOL CALL 1 Z S800\nL X+0 Y+0 Z+60 A+0 C+0 R0 FMAX M3\n\n\n\n{}\nEND PGM A MM",
}


@pytest.mark.parametrize(("dialect", "line", "wanted"), [
    ("fanuc", "G99 G93 X5. Z50. R55. Q2. F90.\nX9. Y9.\nG80\nG1 X7. F100.",
     ("VP006", 5, "G93 takes no R, Q; did you mean G83?")),
    ("fanuc", "G93 X5. Z50. R55. F90.", ("VP006", 1, "G93 takes no R; did you mean G83?")),
    ("fanuc", "G94 X5. Z50. R55. F90.", ("VP006", 14, "nothing in the block uses R55")),
    ("fanuc", "M98 P2000", ("VP023", 5, "M98 calls O2000: not in the program, and in no file beside it whose name has "
                            "the number (2000.ngc, O2000.nc or O2000)")),
    ("fanuc", "M98 P20", ("VP023", 5, "M98 calls O20: not in the program, and in no file beside it whose name has the "
                          "number (20.ngc, O0020.nc or O0020)")),
    ("fanuc", "G2 X5. Y5. I5. J5.", ("VP008", None, "the radius of the arc is 7.07107 mm at the start, 0 mm at the "
                                     "end: its centre is the end")),
    ("fanuc", "G2 X5. Y5. I0 J0", ("VP008", None, "the radius of the arc is 0 mm at the start, 7.07107 mm at the end: "
                                   "its centre is the start")),
    ("siemens", "CYCLE83(-20,0,3,-12,,-5,,2,0,0,1,1)",
     ("VP007", 9, "CYCLE83: the retract plane -20 mm lies below the reference plane 0 mm, as the bottom -12 mm does; "
      "expected RTP above RFP")),
    ("siemens", "CYCLE82(50,0,3,12)", ("VP007", 16, "CYCLE82: the bottom 12 mm lies on the wrong side of the reference "
                                       "plane 0 mm; write -12")),
    ("siemens", "CYCLE82(50,0,3,0)", ("VP007", 16, "CYCLE82: the bottom is the reference plane 0 mm: the hole has no "
                                      "depth")),
    ("siemens", "CYCLE81(50,0,3,,0)", ("VP007", 17, "CYCLE81: the bottom is the reference plane 0 mm: the hole has no "
                                       "depth")),
    ("fanuc", "M98 P1001\nM30\nO1000\nM99", ("VP023", 5, "M98 calls O1001: not in the program, and in no file beside "
     "it whose name has the number (1001.ngc, O1001.nc or O1001); the program has "
     "O1000, which is nearly this number, in line 9, and which nothing calls")),
    ("heidenhain", "CALL LBL 11\nM30\nLBL 1\nLBL 0", ("VP023", 10, "LBL 11 is not in the program; it has LBL 1, "
                                                      "which is nearly this number")),
    ("heidenhain", "CALL LBL 1O\nM30\nLBL 10\nLBL 0", ("VP001", 10, "1O: the letter O in a number; did you mean "
                                                       "10?")),
    ("heidenhain", "PLANE SPATIAL SPA+20 SPB+0 SPC+0 MOVE DIST0 FMAX SEQ 1",
     ("VP001", 50, "SEQ without its sign; write SEQ+ or SEQ-, as A is to be positive or negative")),
    ("heidenhain", "M140 MB", ("VP001", 6, "MB without a number; write MB and its value, or MB MAX")),
    ("heidenhain", "TOOL CALL 11 Z S800", ("VP012", 11, "tool 11: no entry in the set-up or the tool table; add "
     "one, or give tool_length=MM where the program has one tool; did you mean 1?")),
    ("heidenhain", "TOOL CALL 51 Z S800", ("VP012", 11, "tool 51: no entry in the set-up or the tool table, which has "
     "tool 1; add one, or give tool_length=MM where the program has one tool")),
    ("siemens", "FOR I=1 TO 3\nX5\nENDFOR", ("VP025", 5, "I is not defined; write DEF REAL I at the beginning")),
    # contradicting M codes, in each language as in RS274/NGC
    ("fanuc", "G68.2 X0. Y9. Z60. A0. B20. C0.\nG53.1\nG0 X0. Y0. Z9.\nG69", ("VP006", 20, "the angles of G68.2 are I, "
     "J and K, about Z, about X, and about Z again; write I0. J20. K0. in place of A0. B20. C0.")),
    ("fanuc", "G68.2 P1 X0. Y9. Z60. C[1-1] B20.\nG69", ("VP006", 23, "the angles of G68.2 are I, J and K; write J, K "
     "in place of B, C")),
    ("fanuc", "G68.2 X0. Y9. Z60. I0. B20.\nG69", ("VP006", 24, "G68.2 does not use B")),
    ("siemens", "X5 M8 M9", ("VP003", 7, "M8 and M9 are of one modal group (coolant)")),
    ("siemens", "X5 M3 M5", ("VP003", 7, "M3 and M5 are of one modal group (spindle)")),
    ("fanuc", "X5. M8 M9", ("VP003", 8, "M8 and M9 are of one modal group (coolant)")),
    ("heidenhain", "L X+5 F100 M8 M9", ("VP003", 15, "M8 and M9 are of one modal group (coolant)")),
    ("heidenhain", "M3 M5", ("VP003", 4, "M3 and M5 are of one modal group (spindle)")),
    ("heidenhain", "M13 M9", ("VP003", 5, "M13 and M9 are of one modal group (coolant)")),
    ("siemens", 'MSG("DRILL D6)', ("VP001", 5, "the quote is not closed on its line; expected '\"'")),
    ("siemens", 'MSG("DRILL D6"', ("VP001", 4, "the bracket is not closed on its line; expected ')'")),
    ("heidenhain", "L X+5 RLL F100", ("VP001", 7, "RLL: no meaning in this language; did you mean RL?")),
    ("heidenhain", "CR X+5 Y+5 R+9 DRR- F100", ("VP001", 16, "DRR-: no meaning in this language; did you mean DR-?")),
    ("heidenhain", "L Y+5 X", ("VP001", 7, "X without a number; write X and its value")),
    ("heidenhain", "L X-4.0.5 Y+5", ("VP001", 3, "X-4.0.5: two points in one number; write it with one")),
    ("heidenhain", "CYCL DEF 230", ("VP002", 10, "CYCL DEF 230 is not executed (multipass milling of older controls; "
                                    "write cycle 233)")),
])  # fmt: skip
def test_a_mistake_is_told_by_its_cause_at_its_place(machine, dialect, line, wanted):
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 0)}, tools=tools)
    findings = check(HEADS[dialect].format(line).encode(), machine, options).findings
    errors = [item for item in findings if item.severity == "error"]
    assert [(item.code, item.line, item.column, item.message) for item in errors] == [
        (wanted[0], 7, wanted[1], wanted[2])
    ]


PLANE = 'CYCLE800(0,"T",200000,57,0,9,60{},0,0,0,-1)'


@pytest.mark.parametrize(("dialect", "line", "wanted"), [
    ("fanuc", "G0 X5.\nG68.2 X0. Y9. Z60.\nG69", [("VP005", 8, 1, "G68.2 without I, J, K: its angles are 0")]),
    ("fanuc", "G0 X5.\nG68.2 X0. Y9. Z60. I0.\nG69", []),
    ("siemens", "G0 X5\n" + PLANE.format(",,,") + "\nCYCLE800()",
     [("VP005", 8, 1, "CYCLE800 without _A, _B, _C: its angles are 0")]),
    ("siemens", "G0 X5\n" + PLANE.format(",0,0,0") + "\nCYCLE800()", []),
    # a cut at a tilt before TRAORI, or without it, counts in directions of the machine
    ("siemens", "G0 A-10 C0\nX5\nG1 X9\nTRAORI\nX8 A-12\nTRAFOOF",
     [("VP037", 9, None, "X Y Z cut at A-10 before TRAORI of line 10")]),
    ("siemens", "G0 A-10 C0\nX5\nTRAORI\nG1 X9\nTRAFOOF\nTRAORI\nX8\nTRAFOOF", []),
    ("siemens", "G0 A-10 C0\nX5\nG1 X9\nX8 A-12",
     [("VP017", 10, 4, "follow a curve; write TRAORI before line 8, the first with X Y Z at A-10, or G0")]),
    ("siemens", "G1 X9\nX8 A-12", [("VP017", 8, 4, "curve; write TRAORI in a block before this one, or G0")]),
])  # fmt: skip
def test_what_leaves_cuts_in_other_directions_is_told_where_it_is_to_be_written(machine, dialect, line, wanted):
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 0)}, tools=tools)
    findings = check(HEADS[dialect].format(line).encode(), machine, options).findings
    told = [item for item in findings if item.code in {"VP005", "VP017", "VP037"}]
    assert [(item.code, item.line, item.column) for item in told] == [item[:3] for item in wanted]
    assert all(words in item.message for item, (*_place, words) in zip(told, wanted, strict=True))


@pytest.mark.parametrize(("end", "wanted"), [("M30\n%\n", []), ("M2\n%\n", []), ("%\n", [("VP010", "warning", 9)])])
def test_a_fanuc_program_that_percent_alone_ends_is_told(machine, end, wanted):
    """END PGM that is missing was a warning; M30 was not."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = Options(dialect="fanuc", wcs={"G54": (0, 0, 0)}, tools=tools)
    program = f"%\n{HEADS['fanuc'].format('G1 X5.').removesuffix('M30')}{end}"
    found = check(program.encode(), machine, options).findings
    assert [(item.code, item.severity, item.line) for item in found] == wanted


MANY = "".join(f"X{n}.\n" for n in range(20))


@pytest.mark.parametrize(
    ("dialect", "program", "line", "since"),
    [
        ("fanuc", "G0 X9.\nZ60. F600.\nX5. F400.", 4, "G0 of line 3"),
        ("rs274", "G0 X9\nZ60 F600 M8", 4, "G0 of line 3"),
        ("siemens", "G0 X9\nZ60 F600\nX5 F400", 4, "G0 of line 3"),
        ("fanuc", f"G1 X8. F500.\nG0 X9.\n{MANY}Z60. F600.\n{MANY}", 25, "G0 of line 4"),
        ("siemens", f"G1 X8 F500\nG0 X9\n{MANY}Z60 F600\n{MANY}", 25, "G0 of line 4"),
        ("fanuc", "G0 X9. F600.\nZ60.\nG1 X5.\nX7. F500.", None, ""),
        ("siemens", "G0 X9 F600\nG1 X5\nX7 F500", None, ""),
        ("siemens", "G0 X9\nX5 Y5 F250\nG1 X7 F500", None, ""),
        ("siemens", "G0 X9\nX5 Y5 F250\nCYCLE82(100,90,2,80,,0.3)", None, ""),
        ("siemens", "G1 X8 F500\nG0 X9\nX5 F400\nY5\nG0 Z120", 5, "G0 of line 4"),
        ("siemens", "G1 X8 F500\nG0 Z120\nX5 Y60 F5000", None, ""),  # parks
        ("siemens", "G1 X8 F500\nG0 Z120\nX5 Y60 F5000\nZ130", None, ""),
        ("siemens", "G1 X8 F500\nG0 Z120\nX5\nZ100\nX9 F500\nX5\nZ130", 7, "G0 of line 4"),
        ("siemens", "G0 X9\nX5 F400\nG0 Z120\nT1 D1\nM6\nS900 M3\nG0 X9\nG1 X7 F500", 4, "G0 of line 3"),
        ("rs274", "F600\nG53 X9 F600\nG1 X5 F400", None, ""),
    ],
)
def test_f_in_a_block_that_an_earlier_g0_moves_is_told_once(machine, dialect, program, line, since):
    """G1 is missing, and the cut is a rapid; also inside a stretch that is executed at once."""
    head = f"{'G71' if dialect == 'siemens' else 'G21'} G90\nG0 X0. Y0. Z100. A0. C0.\n"
    setup = Options(dialect=dialect, tool_length=80.0, wcs={"G54": (0, 0, 60)}, split_at_stops=True)
    told = [item for item in check(f"{head}{program}\nM30\n", machine, setup).findings if item.code == "VP009"]
    assert [(item.line, item.severity) for item in told] == ([] if line is None else [(line, "warning")])
    said = f"{since} is still active; write G1 in the first block from {since[len('G0 of ') :]} on"
    assert all(said in item.message for item in told)


STARTS = {
    "fanuc": "G21 G90\nT1 M6\nG43 H1\nG0 X0. Y0. Z100. A0. C0.\n",
    "rs274": "G21 G90\nT1 M6\nG43 H1\nG0 X0 Y0 Z100 A0 C0\n",
    "siemens": "G71 G90\nT1 M6\nD1\nG0 X0 Y0 Z100 A0 C0\n",
}


@pytest.mark.parametrize(
    ("dialect", "program", "told", "said"),
    [
        ("fanuc", "G91 G28 Z0.\nG49\nG0 A20. C0.\nG43.4 H1\nG0 X10. Y0. Z5.\nZ2.", ("VP016", 9), "G91 of line 5"),
        ("rs274", "G91 G0 Z2.\nX5.\nG53 G0 Z0.\nG53 Z0.", ("VP017", 7), "G91 of line 5"),
        ("siemens", "G91 G0 Z2\nG0 SUPA Z0 D0\nG0 Z3\nD1\nZ4\nG90 X9\nSUPA Z0", ("VP017", 6), "G91 of line 5"),
        ("siemens", "G91 G0 Z2\nG90\nG91 X1\nSUPA Z0", ("VP017", 8), "G91 of line 7"),
        ("rs274", "G53 G91 G0 Z0.", ("VP017", 5), ""),
        ("siemens", "G90\nSUPA Z=IC(5)", ("VP017", 6), ""),
        ("fanuc", "G18\nG1 X5. F100.\nG2 X15. Y5. I0. J5.", ("VP006", 7), "G18 of line 5"),
        ("siemens", "G18\nG1 X5 F100\nG2 X15 Y5 I0 J5", ("VP006", 7), "G18 of line 5"),
        ("rs274", "G18 G2 X15. Y5. I0. J5. F100.", ("VP006", 5), ""),
        ("siemens", "G18 F100\nG0 X5\nCYCLE81(90,80,2,60)", ("VP017", 7), "G18 of line 5"),
        ("siemens", "G18 F100\nS900 M3\nPOCKET4(90,80,2,60,9,20,20,5,0,0,100,100,0,11)", ("VP017", 7), "G18 of line 5"),
        ("fanuc", "G18 F100.\nG0 X5.\nG81 X9. Y50. R60. Z20.", ("VP017", 7), "G18 of line 5"),
    ],
)
def test_a_mode_that_was_left_on_is_named_with_its_line(machine, dialect, program, told, said):
    """G91 or G18 of an earlier line is the cause, and what follows from one G91 is one finding."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0) + (0.0,) * 6, 10.0)}
    setup = Options(dialect=dialect, tools=tools, wcs={"G54": (0, 0, 60)}, split_at_stops=True)
    found = check(f"{STARTS[dialect]}{program}\nM30\n", machine, setup).findings
    (error,) = [item for item in found if item.severity == "error"]
    assert (error.code, error.line) == told
    assert ("is active" in error.message, f"{said} is active" in error.message) == (said != "", said != "")


DRILL = "CYCL DEF 200 Q200=2 Q201=-5 Q206=250 Q202=5 Q210=0 Q203=40 Q204=20 Q211=0\n"
HOLE = "CYCLE81(60,40,2,35)"
SWIVEL = 'CYCLE800(0,"",0,57,0,10,5,25,0,0,0,0,0,-1)'
PLANE = "G68.2 X0. Y0. Z40. I0 J25. K0\nG53.1"
SPATIAL = "PLANE SPATIAL SPA+25 SPB+0 SPC+0 TURN FMAX SEQ-"
CYCLE_19 = "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+25 B+0 C+0"


@pytest.mark.parametrize(
    ("dialect", "lines", "wanted"),
    [
        (
            "heidenhain",
            f"{DRILL}L X+5 FMAX\nL X+9 FMAX",
            [
                (
                    "VP023",
                    7,
                    "cycle 200 is not called: no CYCL CALL, M99 or M89 before the end of the program; write M99",
                )
            ],
        ),
        ("heidenhain", f"{DRILL}L X+5 FMAX\n{DRILL}L X+9 FMAX M99", [("VP023", 7, "before the next one in line 9")]),
        ("heidenhain", f"{DRILL}{DRILL}L X+5 FMAX\nL X+9 FMAX M99", []),  # what is defined anew was not to be called
        ("heidenhain", f"{DRILL}L X+5 FMAX M89\nL X+9 FMAX", []),
        # a cycle that nobody has ended drilled on, at each line of the next tool, without a word
        (
            "heidenhain",
            f"{DRILL}L X+5 FMAX M89\nL X+9 FMAX\nL Z+90 FMAX\nL Z+95 FMAX",
            [("VP043", 10, "M89 of line 8 still calls cycle 200 at Z alone, which is one more place; write M99")],
        ),
        (
            "heidenhain",
            f"{DRILL}L X+5 FMAX M89\nTOOL CALL 2 Z S900\nL Z+90 FMAX M3",
            [("VP043", 9, "M89 of line 8 still calls cycle 200 at TOOL CALL")],
        ),
        ("heidenhain", f"{DRILL}L X+5 FMAX M89\nL X+9 FMAX M99\nL Z+90 FMAX", []),
        (
            "heidenhain",
            f"{DRILL}L X+5 FMAX M89\nL Z+90 FMAX\nM128\nL A-20 FMAX\nL X+9 Y+9 FMAX\nL X+5 FMAX",
            [
                (
                    "VP017",
                    9,
                    "M89 of line 8 still calls cycle 200; write M99 at its last place, before line 9 (line 11: ",
                )
            ],
        ),
        (
            "siemens",
            f"MCALL {HOLE}\nX5\nG0 Z70\nG0 X9\nZ80",
            [
                (
                    "VP043",
                    9,
                    "MCALL of line 7 still calls CYCLE81 at Z alone, which is one more place; write MCALL alone",
                )
            ],
        ),
        (
            "siemens",
            f"MCALL {HOLE}\nX5\nG0 Z70\nTRAORI\nG0 A20\nX9",
            [("VP017", 9, "MCALL of line 7 still calls CYCLE81; write MCALL alone before line 9 (line 11: ")],
        ),
        (
            "siemens",
            f"MCALL {HOLE}\nX5\nT2 M6\nS900 M3 F100\nG0 Z70",
            [("VP043", 9, "MCALL of line 7 still calls CYCLE81 at M6")],
        ),
        ("siemens", f"MCALL {HOLE}\nX5", [("VP043", 9, "MCALL of line 7 still calls CYCLE81 at M30")]),
        ("siemens", f"MCALL {HOLE}\nX5\nX9 Z70\nC30\nMCALL\nZ90", []),
        (
            "fanuc",
            "G81 X5. Z35. R42. F200\nT2 M6\nS900 M3\nG43 H2\nX9. F200\nX7.\nG80",
            [("VP043", 11, "G81 of line 7 is still in force after the change of tools in line 8; write G80 before")],
        ),
        ("fanuc", "G81 X5. Z35. R42. F200\nT2 M6\nS900 M3\nG43 H2\nG81 X9. Z35. R42. F200\nX7.\nG80", []),
        ("fanuc", "G81 X5. Z35. R42. F200\nT2 M6\nG0 X9.\nX7.", []),
        # the next hole was approached by a straight rapid in the new plane, without a word
        (
            "siemens",
            f"MCALL {HOLE}\nX5\n{SWIVEL}\nX9\nX12\nMCALL",
            [("VP043", 9, "MCALL of line 7 still calls CYCLE81 in the new plane of line 9; write MCALL alone before")],
        ),
        (
            "siemens",
            f"MCALL {HOLE}\nX5\n{SWIVEL}\nHOLES1(10,10,0,5,5,3)\nMCALL",
            [("VP043", 9, "MCALL of line 7 still calls CYCLE81 in the new plane of line 9")],
        ),
        (
            "siemens",
            f"{SWIVEL}\nMCALL {HOLE}\nX9\nCYCLE800()\nG0 A0 C0\nX12\nMCALL",
            [("VP043", 10, "MCALL of line 8 still calls CYCLE81 after the plane, which line 10 ends")],
        ),
        (
            "siemens",
            f"MCALL {HOLE}\nX5\n{SWIVEL.replace(',5,25,', ',40,25,')}\nX9\nMCALL",
            [("VP017", 9, "MCALL of line 7 still calls CYCLE81; write MCALL alone before line 9 (line 10: ")],
        ),
        # at its first hole MCALL is not forgotten
        (
            "siemens",
            f"{SWIVEL[:-3]}0)\nMCALL {HOLE}\nX9\nMCALL",
            [("VP017", 9, "CYCLE81 drills along Z, but the tool points along (")],
        ),
        ("siemens", f"MCALL {HOLE}\nX5\nMCALL\n{SWIVEL}\nX9\nMCALL", []),
        ("siemens", f"MCALL {HOLE}\nX5\n{SWIVEL}\nMCALL\nX9", []),
        ("siemens", f"MCALL {HOLE}\n{SWIVEL}\nX9\nX12\nMCALL", []),  # its first hole is in that plane
        ("siemens", f"{SWIVEL}\nMCALL {HOLE}\nX9\n{SWIVEL}\nX12\nMCALL", []),  # the same plane again
        # in each turn of the loop MCALL begins anew
        (
            "siemens",
            f"R1=0\nA1:\nMCALL {HOLE}\nX5\nX9\nMCALL\n{SWIVEL}\nR1=R1+1\nIF R1<2 GOTOB A1",
            [],
        ),
        (
            "fanuc",
            f"G81 X5. Z35. R42. F200\n{PLANE}\nX9.\nX7.\nG80\nG69",
            [("VP043", 8, "G81 of line 7 is still in force in the new plane of line 8; write G80 before that if no")],
        ),
        (
            "fanuc",
            f"G81 X5. Z35. R42. F200\n{PLANE[:-6]}\nX9.\nX7.\nG80\nG69",
            [("VP017", 9, "write G53.1 after G68.2, or A and C (G69 ends it); G81 of line 7 is still in force in the")],
        ),
        ("fanuc", f"G81 X5. Z35. R42. F200\n{PLANE}\nG81 X9. Z35. R42.\nX7.\nG80\nG69", []),
        ("fanuc", f"G81 X5. Z35. R42. F200\n{PLANE}\nG0 X9.\nX7.\nG69", []),
        ("fanuc", f"G81 X5. Z35. R42. F200\nG80\n{PLANE}\nG0 X9.\nX7.\nG69", []),
        ("fanuc", "G81 X5. Z35. R42. F200\nG68.2 X0. Y0. Z0. I0 J0. K30.\nG53.1\nX9.\nG80\nG69", []),
        (
            "heidenhain",
            f"{DRILL}L X+5 FMAX M89\n{SPATIAL}\nL X+9 FMAX\nL X+12 FMAX M99",
            [("VP043", 9, "M89 of line 8 still calls cycle 200 in the new plane of line 9; write M99 at its last")],
        ),
        (
            "heidenhain",
            f"{DRILL}L X+5 FMAX M89\n{CYCLE_19}\nL A+Q120 C+Q122 FMAX\nL X+12 FMAX M99",
            [("VP043", 10, "M89 of line 8 still calls cycle 200 in the new plane of line 10")],
        ),
        (
            "heidenhain",
            f"{SPATIAL}\n{DRILL}L X+5 FMAX M89\nPLANE RESET TURN FMAX\nL X+12 FMAX\nL X+8 FMAX M99",
            [("VP043", 10, "M89 of line 9 still calls cycle 200 after the plane, which line 10 ends")],
        ),
        ("heidenhain", f"{DRILL}L X+5 FMAX M89\nL X+7 FMAX M99\n{SPATIAL}\nL X+9 FMAX\nL X+12 FMAX M99", []),
        ("heidenhain", f"{DRILL}L X+5 FMAX M89\n{SPATIAL}\nL X+9 FMAX M99\nL X+12 FMAX", []),  # M99 asks for it
        # holes of depth 0, which the control does not drill: once, where the cycle has the depth
        (
            "heidenhain",
            f"{DRILL.replace('Q201=-5', 'Q201=+0')}L X+5 FMAX M99\nL X+9 FMAX M99",
            [("VP007", 7, "Q201=0: the control does not run cycle 200 with depth 0; write the depth, below 0")],
        ),
        ("heidenhain", f"{DRILL}CYCL CALL", []),
        ("heidenhain", f"{DRILL}CYCL CALL POS X+5 Y+5 Z+0 FMAX", []),
        ("heidenhain", f"{DRILL}PATTERN DEF POS1 (X+5 Y+5 Z+0)\nCYCL CALL PAT FMAX", []),
        (
            "heidenhain",
            f"{DRILL}CYCL DEF 220 Q216=0 Q217=0 Q244=30 Q245=0 Q246=360 Q247=0 Q241=2 Q200=2 Q203=40 Q204=20 Q301=1",
            [],
        ),
        ("heidenhain", "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+5\nL X+9 FMAX", []),
        ("heidenhain", "CYCL DEF 7.0\nCYCL DEF 7.1 X+5\nCYCL DEF 7.0\nCYCL DEF 7.1 X+0\nL X+9 FMAX", []),
        (
            "siemens",
            f"{HOLE}\nX5\nX9\nMCALL",
            [
                (
                    "VP023",
                    10,
                    "MCALL ends nothing: CYCLE81 of line 7 is called at one "
                    "place alone; write MCALL CYCLE81(...) there",
                )
            ],
        ),
        ("siemens", f"{HOLE}\nX5\n{HOLE}\nMCALL", []),
        ("siemens", f"MCALL\n{HOLE}\nMCALL\nX5\nMCALL", []),
        ("siemens", f"MCALL {HOLE}\nX5\nMCALL\nMCALL\nX9\nMCALL", []),
        (
            "siemens",
            f"MCAL {HOLE}\nX5\nMCALL",
            [("VP002", 7, "MCAL: no meaning in this language; did you mean MCALL?")],
        ),
        (
            "siemens",
            f"MCALL {HOLE}\nX5\nMCAL\nG0 A20",
            [("VP002", 9, "MCAL: no meaning in this language; did you mean")],
        ),
        ("fanuc", "G68.5 X0 Y0 Z5. I0 J25. K0", [("VP002", 7, "write the code that is meant, such as G68, G68.2 or")]),
    ],
)
def test_a_cycle_that_nothing_calls_or_ends_is_told(machine, dialect, lines, wanted):
    """Holes were missing without a word: the cycle was not called, or called at the first place alone."""
    tools = {number: Tool(number, number, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0) for number in (1, 2)}
    options = Options(split_at_stops=True, dialect=dialect, wcs={"G54": (0, 0, 0)}, tools=tools)
    found = check(HEADS[dialect].format(lines).encode(), machine, options).findings
    found = [item for item in found if item.code != "VP039" and item.quantity != "end"]
    assert [(item.code, item.line) for item in found] == [item[:2] for item in wanted]
    assert all(said in item.message for item, (_code, _line, said) in zip(found, wanted, strict=True))


@pytest.mark.parametrize(("lines", "wanted"), [
    ("CYCL DEF 7.0\nCYCL DEF 7.1 Z+5O", ("VP001", 8, 14, "Z+5O: the letter O in a number; did you mean Z+50?")),
    ("CYCL DEF 7.0\nCYCL DEF 7.1 FOO", ("VP001", 8, 14, "'FOO' is not a coordinate of a datum shift; write an axis and "
                                        "a number")),
    ("CYCL DEF 7.0\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 X+1", ("VP004", 9, None, "the datum shift has X in line 8 already, "
     "and this one replaces it; write another axis, or one of the two lines")),
    ("L X+5 F100 RL\nL Z-100 R0 FMAX M91", ("VP017", 8, None, "M91 (beside R0, which takes effect after it) under "
     "cutter compensation: RL of line 7 is still in force; write R0 first")),
    # formulas and parameters: at their place, with what is meant, and not again where the value is used
    ("Q1 = 5 + 1O\nL X+Q1 FMAX", ("VP001", 7, 10, "1O: the letter O in a number; did you mean 10?")),
    ("FN 1: Q1 = +5 + 1O\nL X+Q1 FMAX", ("VP001", 7, 17, "1O: the letter O in a number; did you mean 10?")),
    ("Q1 = SIM 30\nL X+Q1 FMAX", ("VP001", 7, 6, "SIM: no function of this name; did you mean SIN?")),
    ("Q1 = 3 * (4 + 2\nL X+Q1 FMAX", ("VP001", 7, 10, "a bracket of the formula is not closed; write )")),
    ("Q3 = Q1 * 2\nQ4 = Q3 + 1\nFN 9: IF +Q4 EQU +5 GOTO LBL 3\nL X+Q4\nLBL 3",
     ("VP025", 7, 6, "Q1 has no value; set it first")),
    ("Q1 = 5\nL X+Q11 FMAX", ("VP025", 8, 5, "Q11 has no value; set it first; the program sets Q1, which is "
                                       "nearly this number")),
    ("QL1 = 5\nL X+Q1 FMAX", ("VP025", 8, 5, "Q1 has no value; set it first; the program sets QL1, which is "
                                       "another parameter")),
    ("Q1 = 5\nQ10 = 5\nL X+Q1O FMAX", ("VP001", 9, 5, "Q1O: the letter O in a number; did you mean Q10?")),
    ("TOOL DEF 5 L+8O R+3", ("VP001", 7, 12, "L+8O: the letter O in a number; did you mean L+80?")),
    ("CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.O5", ("VP001", 8, 15, "T0.O5: the letter O in a number; did you mean "
                                                     "T0.05?")),
    ("CYCL DEF 10.0 ROTATION", ("VP005", 7, None, "CYCL DEF 10.1 is missing after 10.0, so nothing of cycle 10 is set; "
                                "write it with ROT and the angle")),
    ("CYCL DEF 7.0\nCYCL DEF 10.0\n; a remark\nCYCL DEF 10.1 ROT+30", ("VP005", 7, None, "CYCL DEF 7.1 is missing "
     "after 7.0, so nothing of cycle 7 is set; write it with the axes and their shifts")),
    (
        "L X+1 FMAX\nLBL 1\nLBL 0\nLBL 1\nLBL 0",
        ("VP023", 10, 1, "LBL 1 appears twice, first in line 8; write CALL LBL 1 in the line that calls it"),
    ),
    ("APPR LT X+0 Y+0 LEN10 RL F100\nL X+50\nDEP LT\nL Z+70 R0 FMAX",
     ("VP005", 9, None, "DEP LT needs LEN, greater than 0")),
])  # fmt: skip
def test_a_slip_of_several_klartext_lines_is_told_at_its_place(machine, lines, wanted):
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = Options(dialect="heidenhain", wcs={"G54": (0, 0, 0)}, tools=tools)
    (item,) = check(HEADS["heidenhain"].format(f"{lines}\nL X+9 FMAX").encode(), machine, options).findings
    assert (item.code, item.line, item.column, item.message) == wanted


def test_an_r_parameter_that_nothing_sets_is_told_once(machine):
    options = Options(dialect="siemens", wcs={"G54": (0, 0, 0)}, tools={1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6))})
    lines = "R1=5 X=R1\nX=R11\nY=R11+R7\nR8=3\nX=R8 Y=R1"
    found = check(HEADS["siemens"].format(lines).encode(), machine, options).findings
    text = "is read before the program sets it: it counts as 0, and a control has its last value; write {}=0 first if "
    assert [(item.code, item.severity, item.line, item.message) for item in found] == [
        (
            "VP025",
            "warning",
            8,
            f"R11 {text.format('R11')}that is meant; the program sets R1, which is nearly this number",
        ),
        ("VP025", "warning", 9, f"R7 {text.format('R7')}that is meant"),
    ]


@pytest.mark.parametrize(("word", "right"), [("DC(400)", "DC(40)"), ("ACP(-20)", "ACP(340)"), ("ACN(370)", "ACN(10)")])
@pytest.mark.parametrize("line", ["C={}", "SUPA C={}"])
def test_a_place_beyond_a_turn_is_told(machine, word, right, line):
    """A control stops with an alarm, or reads another number: machine data decide."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = Options(dialect="siemens", wcs={"G54": (0, 0, 0)}, tools=tools)
    (item,) = check(HEADS["siemens"].format(line.format(word)).encode(), machine, options).findings
    assert (item.code, item.severity, item.line, item.column) == ("VP007", "warning", 7, line.index("C") + 1)
    assert item.message == (
        f"C={word} is not from 0 to 359.999: a control stops with alarm 16830, unless bit 0 of its MD30455 is set; "
        f"write C={right}"
    )
    assert not check(HEADS["siemens"].format(line.format(right)).encode(), machine, options).findings


@pytest.mark.parametrize(("dialect", "lines", "wanted"), [
    ("fanuc", "G68 X0. Y0. R10.\nG1 X5. Y5.\nG55\nG68.2 X0. Y0. Z5. I0. J25. K0.\nG53.1",
     ("VP017", 9, 1, "a change of work offset under G68; write G69 first")),
    ("fanuc", "G0 Z60.\nG55 G68.2 X0. Y0. Z5. I0. J25. K0.\nG53.1\nX5. Y5.",
     ("VP017", 8, 1, "G55 in the block of G68.2: which of the two a control executes first is not known; write G55 "
                     "in a line before it")),
    ("fanuc", "G0 Z60.\nG54.1 P2 G68.2 X0. Y0. Z5. I0. J25. K0.\nG53.1\nX5. Y5.",
     ("VP017", 8, 1, "G54.1 in the block of G68.2: which of the two a control executes first is not known; write G54.1 "
                     "in a line before it")),
    # G28 has cancelled the length that the second G43 was to give
    ("fanuc", "G43 H1 Z50.\nG28 G91 Z0.\nG90\nT1 M6\nG43 Z50. M8\nG1 Z45. F90.",
     ("VP005", 11, 1, "a tool length offset needs H, its number: none was given since the tool change")),
    ("fanuc", "G43.5 H1 Z50.\nG0 X1. A5. C9.\nX2. A6.\nX3. C8.",
     ("VP006", 8, 3, "A and C under G43.5, where I J K give the tool axis; use G43.4 for these words")),
    ("fanuc", "G93\nG1 X5.\nG2 X9. R9.\nG1 X20.", ("VP009", 7, 3, "G1 with inverse-time feed (G93) needs F in the same "
                                                   "block, or G94; first in line 8")),
    ("fanuc", "G93\nG1 X5. F9.\nX20.\nG81 X9. Z50. R55. F90.\nX20.\nG80\nG1 X5.",
     ("VP009", 7, 4, "G1 with inverse-time feed (G93) needs F in the same block, or G94; first in line 9")),
    ("siemens", "G93\nG1 X5\nG2 X9 CR=9\nCYCLE81(60,40,2,35)",
     ("VP009", 7, 3, "G1 with inverse-time feed (G93) needs F in the same block, or G94; first in line 8")),
    ("siemens", "G93\nG1 X5 F9\nG94\nX20 F90\nG93\nG1 X5", ("VP009", 12, 1, "G1 with inverse-time feed (G93) needs F "
                                                            "in the same block, or G94; G93 of line 11 is active")),
])  # fmt: skip
def test_a_mode_that_was_not_meant_is_one_finding(machine, dialect, lines, wanted):
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 0)}, tools=tools)
    (item,) = check(HEADS[dialect].format(lines).encode(), machine, options).findings
    assert (item.code, item.line, item.count, item.message) == wanted
    at_word = {"VP006": 8}.get(item.code)
    assert item.column == (1 if "first in line" in item.message else at_word)  # at G93, at A


def test_the_active_work_offset_may_stand_in_the_block_of_a_plane_and_under_it(view):
    text = HEADS["fanuc"].format("G54\nG0 Z60.\n{} G68.2 X0. Y0. Z5. I0. J25. K0.\n{}\nG53.1\n{}\nX5. Y5.\nG69")
    codes = (("G54",) * 3, ("",) * 3)
    (with_offset, found), (without, _) = (view(text.format(*three), dialect="fanuc") for three in codes)
    assert found == ()
    assert (with_offset.end == without.end).all()
    assert with_offset.frames == without.frames


_CONTOURS = {
    "siemens": "G17 G90 G54\nG0 A0 C0\nX-25 Y-20 Z5\nG1 Y20 F100\n{}\nG2 X30 Y15 CR=5\n{}\nX-25\nG3 X9 CR=1\nM30\n",
    "fanuc": "G17 G90 G54\nG0 A0. C0.\nX-25. Y-20. Z5.\nG1 Y20. F100.\n{}\nG2 X30. Y15. R5.\n{}\nX-25.\n"
    "G3 X9. R1.\nM30\n%\n",
    "heidenhain": "TOOL CALL 1 Z S1\nL A+0 C+0 FMAX\nL X-25 Y-20 Z+5 FMAX\nL Y+20 F100\n{}\nCR X+30 Y+15 R-5 DR-\n{}\n"
    "L X-25\nCR X+9 R+1 DR+\nM30\n",
}


@pytest.mark.parametrize(
    ("language", "to_arc", "after", "line"),
    [
        ("siemens", "X2O", "G1 Y-20", 5),
        ("siemens", "X25", "G1 -20", 7),
        ("siemens", "X25", "1 Y-20", 7),
        ("siemens", "X25", "N7 01 Y-20", 7),
        ("fanuc", "X2O.", "G1 Y-20.", 5),
        ("fanuc", "25.", "G1 Y-20.", 5),
        ("heidenhain", "L X+2,,5", "L Y-20", 5),
        ("heidenhain", "L X+-25", "L Y-20", 5),
        ("heidenhain", "L +25", "L Y-20", 5),
    ],
)
def test_an_arc_from_where_a_misspelt_word_leads_is_no_finding(machine, language, to_arc, after, line):
    """The corrected X20 was executed, and the next arc was told to be too small; a line lost its G1 with the rest."""
    result = check(
        _CONTOURS[language].format(to_arc, after).encode(),
        machine,
        Options(dialect=language, wcs={"G54": (0, 0, 0)}, tool_length=80.0),
    )
    found = [(item.code, item.line) for item in result.findings if item.severity == "error"]
    assert found[0] == ("VP001", line)
    # a second mistake is told, where the language goes on from a place that it has read
    own = language == "fanuc" or (language == "heidenhain" and "X" in to_arc)
    assert found[1:] == ([("VP008", 9)] if own else [])


@pytest.mark.parametrize(
    ("sizes", "code", "column"),
    [
        ("L+95 R+5 DL+1", "VP006", 21),
        ("L+95 R+5 R2+1", "VP004", 21),
        ("L+95 L+90 R+5", "VP004", 17),
        ("R+5", "VP005", None),
    ],
)
def test_a_tool_def_that_is_refused_is_no_missing_length(machine, sizes, code, column):
    text = (
        f"BEGIN PGM T MM\nTOOL DEF 1 {sizes}\nTOOL CALL 1 Z S2000\nL X+0 Y+0 Z+50 R0 FMAX M3\nL X+30 F300\nEND PGM T MM"
    )
    options = Options(dialect="heidenhain", wcs={"G54": (0, 0, 100)})
    found = check(text.encode(), machine, options).findings
    assert [(item.code, item.line, item.column) for item in found] == [(code, 2, column)]


def test_mcall_of_no_cycle_is_one_finding(machine):
    """It was corrected to CYCLE801, and then told that MCALL does not call this one."""
    text = "G17 G90 G54\nG0 A0 C0\nX0 Y0 Z60\nF100 S9 M3\nMCALL CYCLE810(60,41,2,30)\nX5\nMCALL\nM30\n"
    options = Options(dialect="siemens", wcs={"G54": (0, 0, 0)}, tool_length=80.0)
    [finding] = [one for one in check(text.encode(), machine, options).findings if one.severity == "error"]
    assert (finding.code, finding.line, finding.column) == ("VP002", 5, 7)
    assert finding.message == "CYCLE810: no cycle that MCALL calls; write the cycle that is meant, such as CYCLE81"


def test_a_subprogram_of_a_number_that_is_nearly_another_names_it(machine):
    text = "%_N_P_MPF\nG17 G90 G54\nL101\nM30\n%_N_L100_SPF\nM17\n"
    options = Options(dialect="siemens", wcs={"G54": (0, 0, 0)}, tool_length=80.0)
    [finding] = [one for one in check(text.encode(), machine, options).findings if one.severity == "error"]
    assert finding.message.startswith("L101: no meaning in this language, and no file of that name")
    assert "; the program has L100, which is nearly this number;" in finding.message


@pytest.mark.parametrize(
    ("dialect", "text", "place", "message"),
    [
        ("siemens", "n10l20\nM30\n", (1, 4), "L20: no meaning in this language, and no file of that name"),
        ("siemens", "g17 g90\ng1x1f100l20\nM30\n", (2, 9), "L20: no meaning in this language beside other words"),
        (
            "siemens",
            "DEF REAL ZDEP=-2\nG0 A0 C0\nG0 X0 Y0 Z=ZDEP+9\nG0 =ZDEP\nM30\n",
            (4, 4),
            "=ZDEP: no address stands before the =; did you mean Z=ZDEP?",
        ),
        (
            "siemens",
            "DEF REAL ZDEP=-2, DEP\nG0 A0 C0\nG0 X0 Y0 Z=ZDEP+9\nG0 =ZDEP\nM30\n",
            (4, 4),
            "=ZDEP: no address stands before the =; write Z=ZDEP or Z=DEP",
        ),
        (
            "heidenhain",
            "0 BEGIN PGM A MM\n1 CALL LBL 'A'\n2 M30\n3 LBL \"A\"\n4 LBL 0\n5 END PGM A MM\n",
            (2, 12),
            "'A': a name stands between two quotes; did you mean \"A\"?",
        ),
    ],
)
def test_a_slip_is_read_as_what_is_there(machine, dialect, text, place, message):
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 0)}, tool_length=80.0)
    [finding] = [one for one in check(text.encode(), machine, options).findings if one.severity == "error"]
    assert (finding.line, finding.column) == place
    assert finding.message.startswith(message)


@pytest.mark.parametrize(
    ("dialect", "text", "said"),
    [
        ("fanuc", "G21 G90 G17\nG0 X0 Y0 Z9 A0 C0\nG1 X5 F90\nG2 X9 Y4 R4\nY9\nX20\nM30\n", "G2 of line 4"),
        ("rs274", "G21 G90 G17\nG0 X0 Y0 Z9 A0 C0\nG1 X5 F90\nG3 X9 Y4 R4\nY9\nX20\nM2\n", "G3 of line 4"),
        ("siemens", "G71 G90 G17\nG0 X0 Y0 Z9 A0 C0\nG1 X5 F90\nG2 X9 Y4 CR=4\nY9\nX20\nM30\n", "G2 of line 4"),
    ],
)
def test_an_arc_that_is_still_in_force_is_named(dialect: str, text: str, said: str) -> None:
    """The message asked for I, J, K or R where G1 was missing."""
    options = vp.Options(tool_length=80.0, wcs={1: vp.WorkOffset((0.0, 0.0, 60.0))}, dialect=dialect)
    (found,) = (one for one in vp.check(text, "verne", options).findings if one.code == "VP005")
    assert found.line == 5 and f"{said} is still in force: write G1 if a line is meant; an arc needs" in found.message


def test_g91_names_the_line_below_which_g90_is_missing() -> None:
    text = "G21 G90 G17\nT1 M6\nG43 H1\nG0 X0 Y0 Z90 A0 C0\nG91 G28 Z0\nT2 M6\nG43 H2\nG0 X9 Y0 Z60\nM30\n"
    wcs = {1: vp.WorkOffset((0.0, 0.0, 60.0))}
    options = vp.Options(tools={1: 80, 2: 90}, wcs=wcs, dialect="fanuc", split_at_stops=True)
    (found,) = vp.check(text, "verne", options).findings
    assert "G91 of line 5 is active: write G90 below line 5 if places are meant" in found.message
    assert [(one.value, one.line, one.way) for one in found.edits] == [("G90", 5, "below")]


@pytest.mark.parametrize("angles", ["I0. J2S. K0.", "I. J20. K0.", "J#", "X"])
def test_a_plane_that_cannot_be_read_does_not_also_lack_its_angles(angles: str) -> None:
    """The warning had no column either, and an editor showed nothing at all."""
    text = (
        f"%\nO1\nG21 G90 G17\nT1 M6\nS900 M3\nG0 G43 H1 X0. Y0. Z90.\nG68.2 X0. Y0. Z0. {angles}\nG53.1\nG69\nM30\n%\n"
    )
    options = vp.Options(tools={1: 80}, wcs={1: vp.WorkOffset((0.0, 0.0, 60.0))}, dialect="fanuc")
    told = vp.check(text, "verne", options).findings
    assert [one.code for one in told if one.line == 7] == ["VP001"]
    assert all(one.column is None or one.column > 0 for one in told)


@pytest.mark.parametrize("end", ["SPC", "SPC+", "SPC MOVE DIST0 FMAX", "SPB+0 SPC+0"])
def test_an_angle_of_a_plane_that_is_still_typed_ends_the_check(end: str) -> None:
    """SPC was taken for a misspelt SPC, again and again."""
    head = "BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+90 R0 FMAX M3\n"
    text = f"{head}PLANE SPATIAL SPA+0 SPB+0 {end}\nEND PGM A MM\n"
    options = vp.Options(tools={1: 80}, wcs={1: vp.WorkOffset((0.0, 0.0, 60.0))}, dialect="heidenhain")
    told = vp.check(text, "verne", options).findings
    assert next(one.line for one in told if one.severity == "error") == 4


@pytest.mark.parametrize(
    ("dialect", "text", "wanted"),
    [
        # what follows a jump to nowhere: words that cannot be read, tools that lack; not what depends on the way there
        (
            "fanuc",
            "G21 G90 G54\nT1 M6\nG43 H1\nG0 X0 Y0 Z50\nGOTO 99\nG779\nG1 X5 Q4\nX1O F100\n#9=#7\nG2 X9 Y9 I1\n"
            "T5 M6\nG43 H5\nGOTO 98\nM30\nG780\n",
            [("VP012", 3), ("VP023", 5), ("VP002", 6), ("VP001", 8), ("VP023", 13)],
        ),
        (
            "heidenhain",
            "0 BEGIN PGM P MM\n1 TOOL CALL 1 Z S500\n2 L X+0 Y+0 Z+50 FMAX M3\n3 CALL LBL 7\n4 L X+Q5 F100\n5 FOO 12\n"
            "6 TOOL CALL 4 Z S200\n7 M777\n8 M30\n9 END PGM P MM\n",
            [("VP012", 2), ("VP023", 4), ("VP002", 6), ("VP002", 8)],
        ),
        (
            "siemens",
            "G54 G90 G17\nT1 D1 M6\nS50 M3\nG0 X0 Y0 Z50\nGOTOF LAB\nG1 X=R7\nT7 D1 M6\nG888\nX1O\nM30\n",
            [("VP012", 2), ("VP023", 5), ("VP002", 8), ("VP001", 9)],
        ),
        # behind a program without end, and behind an alarm of its own, nothing is executed
        ("siemens", "G54 G90 D0\nG0 X0 Y0 Z50\nA1:\nG4 F1\nGOTOB A1\nG888\nM30\n", [("VP024", 3)]),
        ("fanuc", "G21 G90 G49\nG0 X0 Y0 Z50\n#3000=1(WRONG)\nG779\nM30\n", [("VP027", 3)]),
    ],
)
def test_what_a_jump_to_nowhere_hides_is_found_in_the_same_run(machine, dialect, text, wanted):
    """The first jump that leads nowhere was the last error that was found."""
    given = Options(dialect=dialect, wcs={"G54": (0, 0, 0)}, max_repeats=50)
    errors = [item for item in check(text.encode(), machine, given).findings if item.severity == "error"]
    assert [(item.code, item.line) for item in errors] == wanted
    of_tools = [item.settled_by for item in errors if item.code == "VP012"]
    assert all(len(keys) == 2 for keys in of_tools), "the tool behind the jump is in the finding of the first one"


_START = "G54 G90 G17 D0\nG0 X0 Y0 Z50 F500 S9 M3\n"


@pytest.mark.parametrize(
    ("dialect", "text", "wanted"),
    [
        # up to the next label, and not behind it
        ("siemens", f"{_START}GOTOF ENDE1\nDIES IST\nG1 X1O\nENDE:\nDIES IST\nM30\n", [("VP023", 3), ("VP001", 7)]),
        (
            "siemens",
            f"{_START}R5=7\nCASE R5 OF 1 GOTOF L1 2 GOTOF L2 DEFAULT GOTOF L3\nTEXT EINS\nL1:\nG888\nL2:\nM30\n",
            [("VP023", 4), ("VP002", 7)],
        ),
        # up to the near label that the finding names, over another one
        (
            "siemens",
            f"{_START}GOTOF ENDEE\nTEXT EINS\nL1:\nTEXT ZWEI\nENDE:\nG888\nM30\n",
            [("VP023", 3), ("VP002", 8)],
        ),
        # a block number is no label of a jump to a name
        ("siemens", f"{_START}GOTOF FERTIG\nN5 TEXT EINS\nN6 TEXT ZWEI\nENDE:\nM30\n", [("VP023", 3)]),
        # the label is behind the jump back, and its colon is missing
        ("siemens", f"{_START}GOTOB ENDE\nTEXT EINS\nENDE:\nG888\nM30\n", [("VP023", 3), ("VP002", 6)]),
        ("siemens", f"{_START}GOTOF ENDE\nTEXT EINS\nENDE\nG888\nM30\n", [("VP001", 5), ("VP002", 6)]),
        # a jump back passes over nothing
        ("siemens", f"{_START}GOTOB ENDE1\nTEXT EINS\nENDE:\nM30\n", [("VP023", 3), ("VP001", 4)]),
        (
            "heidenhain",
            "BEGIN PGM P MM\nL X+0 Y+0 Z+50 FMAX\nFN 9: IF +0 EQU +0 GOTO LBL 21\nBLAH BLAH\nLBL 20\nFOO 1\nM30\n"
            "END PGM P MM\n",
            [("VP023", 3), ("VP002", 6)],
        ),
        # what follows a call is executed
        (
            "heidenhain",
            "BEGIN PGM P MM\nL X+0 Y+0 Z+50 FMAX\nCALL LBL 21\nBLAH BLAH\nLBL 20\nM30\nEND PGM P MM\n",
            [("VP023", 3), ("VP002", 4)],
        ),
        (
            "fanuc",
            "G21 G90 G54 G49\nG0 X0 Y0 Z50\nGOTO 990\nG779\nN5 G780\nN99 G781\nM30\n",
            [("VP023", 3), ("VP002", 6)],
        ),
        ("fanuc", "G21 G90 G54 G49\nG0 X0 Y0 Z50\nGOTO 70\nG779\nN5 G780\nM30\n", [("VP023", 3), ("VP002", 5)]),
    ],
)
def test_what_a_misspelt_jump_passes_over_is_not_read(machine, dialect, text, wanted):
    """Text for the operator, which the program jumps over, was refused where the label was misspelt."""
    given = Options(dialect=dialect, wcs={"G54": (0, 0, 60)}, tool_length=80)
    errors = [item for item in check(text.encode(), machine, given).findings if item.severity == "error"]
    assert [(item.code, item.line) for item in errors] == wanted


@pytest.mark.parametrize("line", ["#105=#105-1.5", "#105=[#105-1.5]", "#105=#105+#106"])
def test_a_variable_that_is_counted_before_it_is_set_is_an_error_of_its_line(machine, line):
    """Its own line is not one that failed to set it: the Z that reads it was passed over, and nothing was said."""
    program = f"%\nO1\nG21 G90 G94 G17 G54\nS900 M3\nG0 X0. Y0. A0. C0. Z60.\nG1 Z50. F500.\n{line}\nG1 Z#105\nM30\n%\n"
    result = check(program.encode(), machine, Options(dialect="fanuc", wcs={"G54": (0, 0, 0)}, tool_length=90))
    assert [(item.code, item.line) for item in result.findings if item.severity == "error"] == [("VP025", 7)]


def test_a_klartext_turn_without_a_feed_rate_is_no_second_error(machine):
    """The feed rate that is assumed after the first error is that of axes too."""
    program = "BEGIN PGM Q MM\nTOOL CALL 7 Z S9\nL X+0 Y+0 Z+50 R0 FMAX M3\nL Z+20\nL X+10 A+5\nM30\nEND PGM Q MM\n"
    result = check(program.encode(), machine, Options(dialect="heidenhain", tools={7: 90}, wcs={"G54": (0, 0, 0)}))
    assert [(item.code, item.line) for item in result.findings if item.severity == "error"] == [("VP009", 4)]


@pytest.mark.parametrize(
    ("quantity", "line", "column"),
    [
        ("plane", b"N5 G68.2 X0", 4),
        ("change of tools", b"T2 M6", 4),
        ("change of tools", b'T="D6"', 1),
        ("G49", b"G0 G49", 4),
        ("end", b"N9 M5 M30", 7),
        ("", b"G49", None),
    ],
)
def test_the_word_of_a_held_plane_is_data(quantity: str, line: bytes, column: int | None) -> None:
    """The message chose it: other words of it, and the place in the line was lost."""
    item = make_finding("VP043", "a message of any words", line=1, quantity=quantity)
    assert place_at_plane(line, item).column == column


@pytest.mark.parametrize(
    ("turn", "wanted"),
    [
        ("G0 A0 C0", [("VP011", 4)]),
        ("G0 A0 C0\nG0 B30", [("VP011", 4), ("VP017", 6)]),  # the machine's own axis is named again
        ("G0 A0 C0\nG0 Q1", [("VP011", 4), ("VP006", 5)]),
    ],
)
@pytest.mark.parametrize("dialect", ["rs274", "fanuc"])
def test_a_cycle_after_a_turn_of_an_axis_that_the_machine_lacks_is_no_error(turn, wanted, dialect):
    program = f"G90 G21 M3 S900\nT1 M6 G43 H1\nG0 B30 C0 X0 Y0 Z50\n{turn}\nG81 X10 Y10 Z-5 R2 F200\nG80\nM30\n"
    tools = read_tool_table("T1 P1 Z100 D6\n", "t.tbl")
    options = Options(dialect=dialect, tools=tools, wcs={"G54": (0, 0, 0)})
    findings = check(program.encode(), vp.load_machine("bc_trunnion"), options).findings
    assert [(one.code, one.line) for one in findings if one.severity == "error"] == wanted


@pytest.mark.parametrize(
    ("plane", "code", "meant"),
    [
        ("G68.3 X20. Y15. Z0 I0 J20. K0", "VP006", "a plane by the angles I, J, K is G68.2"),
        ("G68.3 X20. Y15. Z0", "VP017", "write G68.2"),
        ("G68.3 X20. Y15.", "VP005", "needs X, Y and Z"),
    ],
)
def test_a_turn_to_a_plane_that_was_refused_is_no_second_error(machine, plane, code, meant):
    program = f"G90 G21 G54\nG49 G0 X0 Y0 Z100 A0 C0\n{plane}\nG53.1\nG0 X5\nG69\nM30\n"
    options = Options(dialect="fanuc", wcs={"G54": (0, 0, 0)})
    findings = [one for one in check(program.encode(), machine, options).findings if one.severity == "error"]
    assert [(one.code, one.line) for one in findings] == [(code, 3)]
    assert meant in findings[0].message


@pytest.mark.parametrize(
    ("program", "dialect", "meant"),
    [
        ('G54 G90\nT="{}"\nM6\nD1\nG0 X0 Y0 Z50 A0 C0\nG1 Z5 F500\nM30\n', "siemens", 'T="{}"'),
        (
            'BEGIN PGM B MM\nTOOL CALL "{}" Z S3000\nL X+0 Y+0 Z+50 A+0 C+0 FMAX\nL Z+5 F500\nM30\nEND PGM B MM\n',
            "heidenhain",
            "{}",
        ),
    ],
)
@pytest.mark.parametrize(("written", "known"), [("BALL 6", "BALL6"), ("BALL6", "BALL 6"), ("BAL 6", "BALL 6")])
def test_a_name_in_quotes_that_is_mistyped_is_one_finding(machine, program, dialect, meant, written, known):
    tools = {5: 100.0}
    control = {dialect: {"tools": {known: 5}}}
    options = Options(dialect=dialect, tools=tools, control=control, wcs={"G54": (0, 0, 0)})
    findings = check(program.format(written).encode(), machine, options).findings
    [error] = [one for one in findings if one.severity == "error"]
    assert error.code == "VP012"
    assert error.message.endswith(f"; did you mean {meant.format(known)}?")


def test_loadtl_says_that_its_length_is_not_used(machine):
    program = "LOADTL/4,LENGTH,90\nLOADTL/5,LENGTH,80\nLOADTL/6\nFEDRAT/300,MMPM\nGOTO/0,0,50\nFINI\n"
    findings = check(program.encode(), machine, Options(dialect="aptcl", wcs={"G54": (0, 0, 0)})).findings
    messages = [one.message for one in findings if one.code == "VP012"]
    assert ["LENGTH in its statement is not used" in one for one in messages] == [True, False]
    assert "tool 4 and tool 5: LENGTH" in messages[0]


@pytest.mark.parametrize(("program", "dialect", "wanted"), [
    # the tool that no M6 loads, where a cycle needs its radius before any feed move
    ("T1 D1\nG0 X0 Y0 Z60\nPOCKET3(20,0,2,-5,30,20,4,0,0,0,5,0,0,300,100,0,11,5,0,0,0,2,2)\nM30", "siemens",
     ("VP012", 1, "write M6 after T1")),
    # the side is in force although its radius is missing
    ("BEGIN PGM K MM\nTOOL CALL 4 Z S1\nL X+0 Y-10 Z+60 R0 FMAX\nL X+0 Y+5 RL F500\nL Y+20\nCHF 2\nL X+30 RL\n"
     "L X+50 R0\nM30\nEND PGM K MM", "heidenhain", ("VP012", 4, "the radius of tool 4 is not known")),
    ("UNITS/MM\nLOADTL/1\nFEDRAT/500,MMPM\nGOTO/0,0,60\nGOTO/20,0000,0,20\nFINI", "aptcl",
     ("VP005", 5, "if 20,0000 is one number, write a decimal point: 20.0000")),
    # places that G91 makes unknown leave nothing to say of the contour
    ("G91\nT1 M6\nG0 X0 Y0 Z60\nG43 H1\nG1 Z-9 F500\nG41 D1 X20\nX40\nY2\nX-10\nG40 Y9\nM30", "rs274",
     ("VP013", 3, "G91 of line 1 is active")),
])  # fmt: skip
def test_one_mistake_of_a_program_is_one_error(machine, program, dialect, wanted):
    tools = {1: Tool(1, 1, (0, 0, 80, *(0,) * 6), 10), 4: Tool(4, 4, (0, 0, 80, *(0,) * 6))}
    findings = check(program.encode(), machine, Options(dialect=dialect, tools=tools, wcs={"G54": (0, 0, 60)})).findings
    (error,) = (item for item in findings if item.severity == "error")
    assert (error.code, error.line) == wanted[:2]
    assert wanted[2] in error.message


@pytest.mark.parametrize(("line", "column"), [("T1 P1 L80 D8", 7), ("T1 G43 H80", 4)])
def test_a_word_that_tool_tables_lack_has_its_column(line, column):
    with pytest.raises(InputError) as refusal:
        read_tool_table(f"{line}\n", "t.tbl")
    (finding,) = refusal.value.findings
    assert finding.column == column
    assert finding.message.endswith("Q; the length is Z") is ("L80" in line)


def test_a_length_for_all_tools_gives_no_tool_the_diameter_of_another(machine, tmp_path):
    path = tmp_path / "p.ngc"
    path.write_text(
        f"{HEAD}T3 M6\nS3000 M3\nG43 H3\nG0 X-40 Y-40 Z50\nG41 D1 G1 X-20 Y-20 F500\nX9\nX9 Y9\nG40 X30 Y30\nM30"
    )
    Path(f"{path}.toml").write_text("[tools]\n1 = { length = 80, diameter = 10 }\n[wcs]\nG54 = [0, 0, 40]\n")
    findings = check(path, machine, Options(dialect="rs274", tool_length=70.0)).findings
    (error,) = (one for one in findings if one.severity == "error")
    assert (error.code, error.line) == ("VP012", 7)
    assert error.message.startswith("D1: tool 3 is in the spindle, and the set-up gives it no diameter; ")


@pytest.mark.parametrize(
    ("source", "kept"),
    [
        ("%\nO1\nG90 G54 G21\nG0 X0. Y0.\nG1 X1O. Y9. Z-1. F500\nY20\nM30\n%\n", {("VP038", 6)}),
        ("G90 G54 G17\nG0 X0 Y0\nG1 X1O Y9 Z-1 F500\nTRAORI\nG1 A3=1 X5\nM30\n", {("VP044", 5)}),
        ("G90 G54 G17\nTRAORI\nG0 X0 Y0\nS8000 M4\nG1 X1O Y9 Z-1 F500\nM30\n", set()),
    ],
)
def test_an_error_in_the_first_lines_hides_no_warning_about_the_text(source: str, kept: set[tuple[str, int]]) -> None:
    """Where the program starts is not known then; what later words lack is seen all the same."""
    found = check(source.encode(), "verne", Options(tool_length=80.0, wcs={"G54": (0, 0, 60)})).findings
    assert {(item.code, item.line) for item in found if item.severity == "warning"} == kept
    assert [item.code for item in found if item.severity == "error"] == ["VP001"]


def test_a_linuxcnc_subprogram_alone_is_named(view):
    """It was told to end with M30, and then does nothing where it is called."""
    (item,) = view("o<hole> sub\nG1 X4 F900\no<hole> endsub\n", dialect="rs274")[1]
    said = "this is a subprogram, and nothing calls it here; check the program that calls it"
    assert (item.code, item.message, item.advice, item.edits) == ("VP010", said, "", ())
    assert {item.code for item in view("o<a> sub\no<b> endsub\n", dialect="rs274")[1]} == {"VP023"}
    assert {item.code for item in view("M200\no<a> sub\n", dialect="rs274")[1]} >= {"VP002"}
    for text in ("o<a> sub\nG21 G90\no<a> endsub\no<a> call\nM3 S1000\n", "G21\no<a> sub\no<a> endsub\n"):
        (item,) = view(text, dialect="rs274")[1]
        assert (item.code, item.message) == ("VP010", "the file ends without M2 or M30")
