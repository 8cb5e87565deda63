"""VP033, VP034, VP040, VP049, VP050, VP055, VP505: what set-up and program leave open although the program uses it."""

from pathlib import Path

import pytest

import verne_post as vp
from verne_post.output.findings import describe_remedy

from .builders import check_unplanned as check

BODY = "G21 G90 F600\n{length}\nG0 X0 Y0 Z80 A0 C0\nG1 X5\n{more}M2\n"
TOOLS = {1: vp.Tool(1, 1, (0.0, 0.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))}
OF_10_MM = {1: vp.Tool(1, 1, TOOLS[1].offset, 10.0)}


def warnings(length="", more="", **options):
    result = check(BODY.format(length=length, more=more), "verne", vp.Options(**options))
    assert all(item.severity == "warning" for item in result.findings), result.findings
    return [(item.code, item.line) for item in result.findings if item.code in ("VP033", "VP034")]


@pytest.mark.parametrize(
    ("options", "length", "more", "expected"),
    [
        ({"tool_length": 80.0}, "", "", [("VP033", 4)]),
        ({"tool_length": 80.0, "wcs": {"G54": (0, 0, 0)}}, "", "", []),  # meant so
        ({"tool_length": 80.0, "wcs": {"G54": (0, 0, 30)}}, "", "", []),
        ({"tool_length": 80.0}, "G10 L2 P1 X0 Y0 Z-400", "", []),  # the program places it
        ({"tool_length": 80.0}, "G10 L2 P1 X0 Y0 Z-550", "", []),  # at the rotary centre, where it is without words
        ({"tools": TOOLS, "wcs": {"G54": (0, 0, 30)}}, "G43 H1", "", []),
        ({"tools": TOOLS, "wcs": {"G54": (0, 0, 30)}}, "G49", "", [("VP034", 4)]),
        ({"tool_length": 0.0, "wcs": {"G54": (0, 0, 30)}}, "", "", []),
    ],
)
def test_what_nobody_has_given(options, length, more, expected):
    assert warnings(length, more, **options) == expected


@pytest.mark.parametrize(
    ("program", "line", "text"),
    [
        ("T2 M6\nG43 H2\nG0 X0 Y0 Z80 A0 C0\nG1 X5\n", 5, "tool 2 has the length 0 in the tool table"),
        ("T1 M6\nG43 H1\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nG49\nG0 Z90\nG1 X6\n", 8, "the set-up gives it 80 mm"),
    ],
)
def test_a_length_of_0_in_the_tool_table_is_told_as_such(program, line, text):
    """The warning asked for G43 where the program has it."""
    options = vp.Options(tools=TOOLS | {2: vp.Tool(2, 2, (0.0,) * 9)}, wcs={"G54": (0, 0, 30)})
    result = check(f"G21 G90 F600\n{program}M2\n".replace("G43", "S900 M3 G43"), "verne", options)
    assert [(item.code, item.line) for item in result.findings] == [("VP034", line)]
    assert text in result.findings[0].message
    assert result.findings[0].severity == ("error" if "G49" in program else "warning")


def test_a_tool_with_the_length_of_the_one_before() -> None:
    """A forgotten G43 drives tool 2 too deep by 30 mm; H22, another offset of tool 2, may be meant."""
    lengths = {1: 80.0, 2: 110.0, 22: 110.2}
    tools = {n: vp.Tool(n, n, (0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)) for n, z in lengths.items()}
    program = (
        "G21 G90 F600 S900\nT1 M6\nM3 G43 H1\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nG0 Z90\nT2 M6\n{}S900 M3 G1 X6 F600\nX7\nM2\n"
    )
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}, split_at_stops=True)
    found = check(program.format(""), "verne", options).findings
    assert [(item.code, item.severity, item.line) for item in found] == [("VP034", "warning", 8)]
    assert "tool 2 cuts with a length of 80 mm, which is that of tool 1; its own is 110 mm" in found[0].message
    assert found[0].message.endswith("(G43 H2) after line 7, or the tip is 30 mm off")
    assert describe_remedy(found[0], "p.nc") == ""  # --tool-length 0 is not what is meant
    for offset in (2, 22):
        found = check(program.format(f"G43 H{offset}\n"), "verne", options).findings
        assert "VP034" not in [item.code for item in found]
    # without a retract the tip is where the tool before has cut: nothing else can be meant
    at_depth = program.replace("G0 Z90\n", "")
    for text, severity in (
        (at_depth.replace("Z80", "Z0"), "error"),
        (at_depth, "error"),  # Z0 may be the bottom of the part
        (at_depth.replace("X7\n", "X7\nG43 H2\nG1 Z40\n"), "warning"),  # above all cuts of the part, in air
        (at_depth.replace("Z80", "Z0").replace("G1 X6 F600\nX7", "G1 Z40 F600"), "warning"),  # a retract at feed rate
    ):
        found = check(text.format(""), "verne", options).findings
        assert [(item.code, item.severity, item.line) for item in found] == [("VP034", severity, 7)]
    found = check(program.format("G43 H1\n"), "verne", options).findings
    assert [(item.code, item.severity, item.line) for item in found] == [("VP049", "warning", 8)]  # one cause


@pytest.mark.parametrize(
    ("first", "second", "severity"),
    [("H1", "H2", ""), ("H2", "H2", "error"), ("H1", "H1", "error"), ("H1", "H9", "warning"), ("H9", "H2", "warning")],
)
def test_the_length_of_a_tool_that_the_program_calls_is_no_offset_of_another(first, second, severity) -> None:
    """H9 of a tool that is never called may be a second offset; H2 under T1 drives it 30 mm too high."""
    lengths = {1: 80.0, 2: 110.0, 9: 95.0}
    tools = {n: vp.Tool(n, n, (0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)) for n, z in lengths.items()}
    cut = "M6\nM3 S900\nG0 X0 Y0\nG43 Z40 {}\nG1 Z20 F600\nX5\nG0 Z40\nM5\n"
    program = f"G21 G90 G94\nG0 A0 C0\nT1 {cut.format(first)}T2 {cut.format(second)}M2\n"
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}, split_at_stops=True)
    result = check(program, "verne", options)
    told = [(item.severity, item.line, item.column) for item in result.findings if item.code == "VP049"]
    assert told == ([(severity, 6 if first != "H1" else 14, 9)] if severity else [])
    assert result.ok == (severity != "error")


@pytest.mark.parametrize(
    ("change", "before", "said"),
    [
        ("T2 M6", "", "; activate its length (G43 H2) after line 10, or write the rapid in machine coordinates"),
        ("T2 M6\nG0 X1\nZ70", "", "; activate its length (G43 H2 in line 12, with the first Z), or write the rapid"),
        ("T2 M6\nG43 H2\nG0 Z60", "G49", "; from line 15 on its length is not in force, and no block since then calls"),
    ],
)
def test_a_rapid_without_length_after_a_tool_change_lacks_g43(change, before, said) -> None:
    """Only G53 and --tool-length 0 were advised, where G43 H2 was forgotten."""
    tools = {n: vp.Tool(n, n, (0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)) for n, z in {1: 80.0, 2: 110.0}.items()}
    program = "G21 G90 G94\nG0 A0 C0\nT1 M6\nG43 H1\nM3 S900\nG0 X0 Y0 Z60\nG1 Z20 F600\nG0 Z60\nG49\n"
    program += f"{change}\nM3 S900\n{before}\nG0 X0 Y0 Z30\nG1 Z20 F600\nG0 Z90\nM5\nM2\n"
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}, split_at_stops=True)
    (item,) = check(program, "verne", options).findings
    assert (item.code, item.severity) == ("VP034", "error")
    assert said in item.message
    if "first Z" in said:
        assert [(one.line, one.word, one.way, one.value) for one in item.edits] == [
            (12, ("Z", 70.0), "behind", "G43 H2"),
            (10, ("", 0.0), "below", "G43 H2"),  # where no word is found
        ]
    assert "--tool-length 0" not in describe_remedy(item, "p.nc")  # it is not what is meant


@pytest.mark.parametrize(
    ("name", "change", "cut", "line", "said"),
    [
        ("nc", "T1 M6", "G0 X0 Y0 Z60\nG0 Z3", 7, "(G43 H1) after line 2, or write the rapid in"),
        ("nc", "G0 Z190\nZ180\nT1 M6", "Z60\nZ3", 9, "(G43 H1 in line 8, with the first Z), or write the rapid in"),
        ("nc", "G0 Z190\nZ180\nT1 M6", "M98 P100\nM30\nO100\nG0 Z60\nZ3", 12, "(G43 H1) after line 4, or write the"),
        ("mpf", "T1 M6\nD0", "G0 X0 Y0 Z60\nG0 Z3", 8, "(D1) after line 2, or write the rapid in"),
    ],
)
def test_a_rapid_of_a_program_without_any_length_lacks_it(name, change, cut, line, said) -> None:
    """Machine coordinates were advised, or to keep a length that was never in force."""
    head = "G710 G90 G94 G17" if name == "mpf" else "G21 G90 G94 G17 G49"
    end = "M99" if "M98" in cut else "M30"
    program = f"{head}\n{change}\nG54\nS900 M3\nG0 A0 C0\n{cut}\nG1 X20 F300\nG0 Z60\n{end}\n"
    dialect = "siemens" if name == "mpf" else "rs274"
    options = vp.Options(tools={1: tool(1, 120.0)}, wcs={"G54": (0, 0, 60)}, dialect=dialect)
    (item,) = (one for one in check(program, "verne", options).findings if one.severity == "error")
    assert (item.code, item.line) == ("VP034", line)
    assert f"mm below the table face; activate its length {said}" in item.message


def test_a_tool_change_that_is_forgotten_refuses() -> None:
    """T2 without M6, and then H2: tool 1 went down 30 mm off, with a warning."""
    tools = {n: vp.Tool(n, n, (0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)) for n, z in {1: 80.0, 2: 110.0}.items()}
    cut = "M3 S900\nG0 X0 Y0\nG43 Z40 H{}\n{}\nG1 Z20 F600\nX5\nG0 Z90\nM5\n"
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}, split_at_stops=True)
    for change, severity in (("T2", ["error"]), ("T2 M6", [])):
        program = f"G21 G90 G94\nG0 A0 C0\nT1 M6\n{cut.format(1, 'T2')}{change}\n{cut.format(2, 'T1')}M2\n"
        found = check(program, "verne", options).findings
        assert [(item.code, item.line) for item in found] == [("VP041", 12)][: len(severity)]
        assert [item.severity for item in found] == severity
        assert all("T2 only selects the tool, and no M6 loads it: H2 in line 15 puts" in one.message for one in found)
        # M6 behind T2; H1 would be no remedy
        assert [(one.value, one.line, one.way) for item in found for one in item.edits] == [("M6", 12, "behind")][
            : len(severity)
        ]


#: Two tools as CAM writes them, in each dialect: the lines that bring each tool, and cuts with it; and lengths.
TWO_TOOLS = {
    "fanuc": (
        ("T1 M06\nS8000 M03\nG43 H1", "T2 M06\nS9000 M03\nG43 H2"),
        "%\nO1\nG00 G17 G21 G40 G49 G69 G80 G90 G94\nG28 G91 Z0.\nG90 G54\n{}{}M30\n%\n",
        "{}\nG00 A0. C0.\nX-30. Y-20.\nZ40. M08\nG01 Z2. F400.\nX30. F1200.\nG00 Z40.\nM09\nM05\nG28 G91 Z0.\nG90\n",
    ),
    "rs274": (
        ("T1 M6\nS8000 M3\nG43 H1", "T2 M6\nS9000 M3\nG43 H2"),
        "G17 G21 G40 G49 G80 G90 G94 G54\n{}{}M2\n",
        "{}\nG0 A0 C0\nX-30 Y-20\nZ40 M8\nG1 Z2 F400\nX30 F1200\nG0 Z40\nM9\nM5\nG53 G0 Z-1\nG0 Z80\n",
    ),
    "siemens": (
        ('T="EM6" D1\nM6\nS8000 M3', 'T="EM10" D1\nM6\nS9000 M3'),
        "G17 G54 G64 G90 G94 G710\n{}{}M30\n",
        "{}\nG0 A0 C0\nX-30 Y-20\nG0 Z40 M8\nG1 Z2 F400\nX30 F1200\nG0 Z40\nM9\nM5\nG0 Z100\n",
    ),
    "heidenhain": (
        ("TOOL CALL 1 Z S8000", "TOOL CALL 2 Z S9000"),
        "BEGIN PGM PART MM\n{}{}M30\nEND PGM PART MM\n",
        "{}\nL A+0 C+0 R0 FMAX M3\nL X-30 Y-20 FMAX M8\nL Z+40 FMAX\nL Z+2 F400\nL X+30 F1200\nL Z+40 FMAX M9\nM5\n",
    ),
}


def check_text(dialect: str, text: str) -> list[tuple[str, str, str, str]]:
    """Findings of a program with tools of 80 and 110 mm: code, severity, line, message."""
    tools = {n: vp.Tool(n, n, (0.0, 0.0, z, *(0.0,) * 6), 6.0) for n, z in {1: 80.0, 2: 110.0}.items()}
    control = {"siemens": {"tools": {"EM6": 1, "EM10": 2}}}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 40)}, dialect=dialect, split_at_stops=True, control=control)
    return [
        (item.code, item.severity, text.splitlines()[(item.line or 0) - 1], item.message)
        for item in check(text, "verne", options).findings
        if item.code not in ("VP046", "VP421")
    ]


def check_two_tools(dialect: str, first: tuple[str, str], second: tuple[str, str]) -> list[tuple[str, str, str, str]]:
    """The same of the program with these replacements in the lines that bring each tool."""
    calls, program, cuts = TWO_TOOLS[dialect]
    bodies = [cuts.format(call.replace(*change)) for call, change in zip(calls, (first, second), strict=True)]
    return check_text(dialect, program.format(*bodies))


NOTHING = ("", "")


@pytest.mark.parametrize(
    ("dialect", "first", "second", "expected", "said"),
    [
        ("fanuc", NOTHING, ("T2 M06", "M06"), ("VP041", "error", "M06"), "H2 in line 21 puts"),
        ("rs274", NOTHING, ("T2 M6", "M6"), ("VP041", "error", "M6"), "write T2 before M6"),
        ("siemens", NOTHING, ('T="EM10" D1\n', ""), ("VP041", "warning", "M6"), "no block after line 3 selects a tool"),
        ("fanuc", ("T1 M06", "M06"), NOTHING, ("VP041", "warning", "M06"), "no block before it selects a tool"),
        (
            "siemens",
            ('T="EM6" D1\n', ""),
            NOTHING,
            ("VP041", "error", "M6"),
            "no block before it selects a tool; the",
        ),
        ("fanuc", NOTHING, ("T2 M06", "T2"), ("VP041", "error", "T2"), "write M6 after T2"),
        ("siemens", NOTHING, ("M6\n", ""), ("VP041", "warning", 'T="EM10" D1'), 'write M6 after T="EM10"'),
        ("siemens", ("M6\n", ""), NOTHING, ("VP012", "error", 'T="EM6" D1'), 'write M6 after T="EM6"'),
        ("fanuc", ("T1 M06\n", ""), NOTHING, ("VP041", "warning", "G01 Z2. F400."), "that does: the cut is made with"),
        ("rs274", ("T1 M6\nS8000 M3\n", ""), NOTHING, ("VP041", "warning", "G1 Z2 F400"), "write T1 M6 before it"),
        # for the tool that is in the spindle, but not with the lengths of two
        ("fanuc", ("T1 M06\n", ""), ("T2 M06\nS9000 M03\nG43 H2", "S9000 M03\nG43 H1"), None, ""),
        ("fanuc", ("T1 M06\n", ""), ("T2 M06\n", ""), ("VP041", "warning", "G43 H2"), "no tool is called, and H2 puts"),
        ("fanuc", ("T1", "T1"), NOTHING, None, ""),
        ("fanuc", ("G43 H1", "G43 H1\nT2"), ("T2 M06", "M06"), None, ""),  # made ready before
        ("siemens", ("M6\n", 'M6\nT="EM10"\n'), ('T="EM10" D1\n', ""), None, ""),
        ("heidenhain", NOTHING, NOTHING, None, ""),
    ],
)
def test_a_change_of_tools_lacks_t_or_m6(dialect, first, second, expected, said):
    """The line that has to be changed is told, and nothing that follows from it."""
    found = check_two_tools(dialect, first, second)
    assert [item[:3] for item in found] == ([] if expected is None else [expected])
    assert said in "".join(item[3] for item in found)


@pytest.mark.parametrize(("second", "said"), [("D0\nM6", ["VP039"]), ("\nM6 D0", ["VP034"]), ("\nM6\nD1", [])])
def test_d0_before_m6_is_no_length_of_the_new_tool(second, said):
    """M6 made D1 active without a word."""
    found = check_two_tools("siemens", NOTHING, ("D1\nM6", second))
    assert [item[0] for item in found] == said
    assert all("M6 makes D1 of the new tool active" in item[3] for item in found if item[0] == "VP039")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            "T1",
            "cuts with the tool that was in the spindle before; the cut has length 0, and the set-up gives tool 1",
        ),
        ("M6", "no block before it selects a tool; the cut has length 0, and the set-up has lengths of tools; write T"),
    ],
)
def test_no_tool_is_loaded_and_none_has_its_length(change, said):
    """It cut with length 0, and a warning said so, where T1 M6 was refused."""
    text = f"%\nO1\nG21 G90 G49 G94 G17\n{change}\nG54 S600 M3\nG0 X0. Y0. Z60. A0. C0.\nG1 Z{{}} F800.\nX9.\nM30\n%\n"
    ((code, severity, line, message),) = check_text("fanuc", text.format("2."))
    assert (code, severity, line) == ("VP041", "error", change)
    assert said in message
    # a head that moves at feed rate, and has not come down, needs no length yet
    assert [item[:2] for item in check_text("fanuc", text.format("60."))] == [("VP041", "warning")]


@pytest.mark.parametrize(
    ("dialect", "old", "new", "line"),
    [
        ("fanuc", "S9000 M03", "M03", "M03"),
        ("rs274", "S9000 M3", "M3", "M3"),
        ("siemens", "S9000 M3", "M3", "M3"),
        ("heidenhain", " S9000", "", "L A+0 C+0 R0 FMAX M3"),
        ("fanuc", "S9000 M03", "M03\nS8000", None),
        ("heidenhain", "S9000", "S8000", None),
        ("fanuc", "T2 M06\nS9000 M03", "T2 M06 S8000\nM03", None),
        ("fanuc", "T2 M06\nS9000 M03\nG43 H2", "T1 M06\nM03\nG43 H1", None),  # the same tool again
    ],
)
def test_the_speed_of_the_tool_before(dialect, old, new, line):
    """A drill turned as fast as the mill before it, without a word."""
    found = check_two_tools(dialect, NOTHING, (old, new))
    assert [item[:3] for item in found] == ([("VP050", "warning", line)] if line else [])
    assert all(
        "starts with S8000 of the tool before: no block gives S after the change to tool 2" in one[3] for one in found
    )


@pytest.mark.parametrize(
    ("dialect", "old", "new", "line"),
    [
        ("fanuc", "S8000 M03", "M03", "M03"),
        ("siemens", "S8000 M3", "M3", "M3"),
        ("heidenhain", " S8000", "", "L A+0 C+0 R0 FMAX M3"),
    ],
)
def test_the_first_tool_has_no_speed(dialect, old, new, line):
    """S of the second tool hid that the first one has none."""
    found = check_two_tools(dialect, (old, new), NOTHING)
    assert [item[:3] for item in found] == [("VP050", "warning", line)]
    assert "no block before the cut gives its speed" in found[0][3]


@pytest.mark.parametrize(
    ("machine", "old", "new"),
    [
        ("verne", "[spindle]", "[spindle]\nmax_speed_rpm = 12000"),
        ("ac_trunnion", "[provenance]", '[spindle]\nmax_speed_rpm = 12000\n\n[provenance]\nspindle = "measured"'),
    ],
)
def test_a_speed_above_that_of_the_spindle(tmp_path, machine, old, new):
    """Each speed once, at the S that gives it while the spindle turns; the greatest itself is none of them."""
    path = tmp_path / "m.toml"
    text = (Path(__file__).parents[1] / "machine_configs" / f"{machine}.toml").read_text("utf-8")
    path.write_text(text.replace(old, new))
    program = (
        "G21 G17 G90 G94 G54\nS12000 M3\nG0 X0 Y0 Z50\nG1 Z45 F400\nS24000\nX10\nS18000\nX20\nS24000\nX0\nM5\n"
        "S30000\nG0 Z50\nM30\n"
    )
    options = vp.Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 60.0)})
    for name, lines in ((machine, []), (str(path), [(5, 12000.0), (7, 12000.0)])):
        found = check(program, name, options).findings
        assert [(one.line, one.limit) for one in found if one.code == "VP055"] == lines
    path.write_text(path.read_text().replace("12000", "12"))
    assert "if krpm were meant" in " ".join(one.message for one in vp.load_machine(str(path)).warnings)


@pytest.mark.parametrize("dialect", ["fanuc", "rs274", "siemens", "heidenhain"])
def test_the_feed_rate_of_the_tool_before(dialect):
    """A drill went down at the feed rate of the mill; F in the block of the change, or before the cut, is its own."""
    calls, program, cuts = TWO_TOOLS[dialect]
    first, second = (cuts.format(call) for call in calls)
    (cut,) = [line for line in second.splitlines() if "F400" in line]
    bare = cut.replace(" F400.", "").replace(" F400", "")
    found = check_text(dialect, program.format(first, second.replace(cut, bare)))
    assert [item[:3] for item in found] == [("VP009", "warning", bare)]
    assert "no block gives F after the change to tool 2" in found[0][3]
    for own in (" F400",) if dialect == "heidenhain" else ("\nF400", " F400"):
        change, more = calls[1].split("\n", 1) if dialect in ("fanuc", "rs274") else (calls[1], "")
        given = second.replace(calls[1], f"{change}{own}\n{more}".rstrip()).replace(cut, bare)
        assert check_text(dialect, program.format(first, given)) == []
    same = second.replace(calls[1], calls[0]).replace(cut, bare)
    assert check_text(dialect, program.format(first, same)) == []


@pytest.mark.parametrize("dialect", ["fanuc", "rs274", "siemens"])
@pytest.mark.parametrize(
    ("cut", "line"),
    [
        ("G0 Z-2 F300\nG1 X30 F1200", 5),
        ("G90 G0 Z-2 F300\nG1 X30 F1200\nG0 Z5\nX0\nG0 Z-2 F300\nG1 X30 F1200", 5),
        ("G0 Z-2 F300\nG3 X10 Y0 I5 J0 F1200", 5),
        ("G0 Z5 F300\nG1 Z-2\nX20 F1200\nG0 Z5\nX0\nG0 Z-2 F300\nG1 X30 F1200", 10),
        ("G0 Z-2 F300\nG1 X30", None),  # its F is used
        ("G0 Z5 F300\nG1 Z-2 F400\nX30 F1200", None),
        ("G0 Z-2 F5000\nG1 X30 F1200", None),  # a post that gives rapids an F
        ("G0 X5 F300\nG0 Z-2 F300\nG1 X30 F1200", None),
        ("G0 Z-2 F300\nG1 X30 F1200\nG0 Z50 F300\nG0 X0 F300", None),
        ("G0 Z-2 F300\nG1 X30 F1200\nG0 Z50 F300\nG0 X0", None),
        ("G0 Z60 F300\nG1 X30 F1200", None),  # it rises
        ("G0 Z5 F300\nG1 X30 F1200\nG1 Z-2 F300", None),  # above the part
    ],
)
def test_the_feed_rate_of_a_plunge_in_rapid_traverse(dialect: str, cut: str, line: int | None) -> None:
    """G0 Z-2 F300 stands where G1 was meant; the tool went down in rapid traverse, and nothing said so."""
    program = f"G17 G90 G94 G54\nS900 M3\nG0 X0 Y0 A0 C0\nG0 Z50\n{cut}\nG0 Z50\nM30\n"
    options = vp.Options(dialect=dialect, tool_length=80.0, wcs={"G54": (0.0, 0.0, 60.0)})
    found = [one for one in vp.check(program, "ac_trunnion", options, limits_only=True).findings if one.code == "VP009"]
    assert [(one.line, one.severity) for one in found] == [(line, "warning")] * (line is not None)
    assert all("F300 is not used: G0 goes down in rapid traverse" in one.message for one in found)
    for one in found[0].edits if found else ():
        assert (one.value, one.word) == ("1", ("G", 0.0))


@pytest.mark.parametrize("cycle", ["CYCLE81(20,0,2,-5)", "CYCLE83(20,0,2,-5,,-3,,2,0,0,1,0)"])
@pytest.mark.parametrize("own", ["", "F400\n"])
def test_a_cycle_of_siemens_has_the_feed_rate_of_the_tool_before(cycle, own):
    """The strokes of CYCLE83 counted as if each gave a feed rate."""
    calls, program, cuts = TWO_TOOLS["siemens"]
    bodies = [cuts.format(call) for call in calls]
    bodies[1] = "".join(f"{own}{cycle}\n" if "F400" in line else f"{line}\n" for line in bodies[1].splitlines())
    # the cut after the cycle is a rapid now, which has a finding of its own
    found = [item[:3] for item in check_text("siemens", program.format(*bodies)) if item[0] == "VP009"]
    assert [item[2] for item in found if item[2] != "X30 F1200"] == [cycle] * (own == ""), found


@pytest.mark.parametrize(("cut", "line"), [("G81 Z1. R3.", 18), ("G81 Z1. R3. F200.", None)])
def test_a_cycle_has_the_feed_rate_of_the_tool_before(cut, line):
    calls, program, cuts = TWO_TOOLS["fanuc"]
    bodies = [cuts.format(call) for call in calls]
    bodies[1] = bodies[1].replace("G01 Z2. F400.\nX30. F1200.\n", f"{cut}\nG80\n")
    found = check_text("fanuc", program.format(*bodies))
    assert [item[:3] for item in found if item[0] == "VP009"] == ([("VP009", "warning", cut)] if line else [])


PLANE = "G68.2 X0. Y10. Z5. I0. J25. K0.\nG53.1"
DRILL = "G81 Z1. R3. F200.\nG80\n"
SWIVEL = 'CYCLE800(0,"",0,57,0,10,5,25,0,0,0,0,0,-1)'
SPATIAL = "PLANE SPATIAL SPA+25 SPB+0 SPC+0 TURN FMAX SEQ-"


@pytest.mark.parametrize(
    ("dialect", "plane", "last", "end", "expected", "said"),
    [
        ("fanuc", PLANE, "", "", ("VP043", "warning", "T2 M06"), "the plane of G68.2 in line 10 is still in force"),
        ("fanuc", PLANE, "", "G69\n", None, ""),
        ("siemens", SWIVEL, "", "", ("VP017", "error", "G0 A0 C0"), "write CYCLE800() first"),
        ("siemens", SWIVEL, "", "CYCLE800()\n", None, ""),
        (
            "heidenhain",
            SPATIAL,
            "",
            "",
            ("VP017", "error", "L X-30 Y-20 FMAX M8"),
            "is still in force: write PLANE RESET where it is over",
        ),
        ("heidenhain", SPATIAL, "", "PLANE RESET STAY\n", None, ""),
        # the table is not turned to the plane
        ("fanuc", PLANE[:-6], "", "G69\n", ("VP042", "warning", "G01 Z-2. F400."), "write G53.1 after G68.2"),
        ("fanuc", PLANE[:-6], DRILL, "G69\n", ("VP017", "error", "G81 Z1. R3. F200."), "write G53.1"),
        ("fanuc", PLANE, DRILL, "G69\n", None, ""),
        # a plane of the same tool is more often given wrongly than left in force
        (
            "fanuc",
            PLANE.replace("I0. J25.", "I25. J0.").replace("G53.1", "A-25. C0.\nG0 X5. Y0.\nG0 Z30."),
            DRILL,
            "G69\n",
            ("VP017", "error", "G81 Z1. R3. F200."),
            "is in force: write G53.1 after G68.2, or A and C; look at its angles too; or write G69 where it is over",
        ),
        ("siemens", SWIVEL[:-3] + "0)", "", "CYCLE800()\n", ("VP042", "warning", "G1 Z-2 F400"), "give _DIR -1 or 1"),
        (
            "heidenhain",
            SPATIAL.replace("TURN FMAX", "STAY"),
            "",
            "PLANE RESET STAY\n",
            ("VP017", "error", "L X-30 Y-20 FMAX M8"),
            "write MOVE or TURN in place of STAY",
        ),
    ],
)
def test_a_plane_that_is_not_ended_or_to_which_nothing_turns(dialect, plane, last, end, expected, said):
    """The plane is programmed before the first tool cuts, and ended after it."""
    calls, program, cuts = TWO_TOOLS[dialect]
    lines = cuts.replace("Z2", "Z-2").replace("Z+2", "Z-2").splitlines(keepends=True)
    at = next(number for number, text in enumerate(lines) if "X-30" in text)
    retract = next(number for number, text in enumerate(lines) if "M09" in text or "M9" in text)
    first = [*lines[:at], "L Z+100 FMAX\n" * (dialect == "heidenhain"), f"{plane}\n", *lines[at:retract]]
    first += [last, lines[retract], end, *lines[retract + 1 :]]
    found = check_text(dialect, program.format("".join(first).format(calls[0]), cuts.format(calls[1])))
    assert [item[:3] for item in found] == ([] if expected is None else [expected])
    assert said in "".join(item[3] for item in found)


@pytest.mark.parametrize(
    ("machine", "axes", "parameters"),
    [("bc_trunnion", "B and C", "Q121 and Q122"), ("verne", "A and C", "Q120 and Q122")],
)
def test_what_turns_the_table_has_the_axes_of_the_machine(machine, axes, parameters):
    """Of a machine with B and C the remedy named A, and Q120."""
    placed = {"tool_length": 60.0, "wcs": {"G54": (0, 0, 200)}}
    plane = "PLANE SPATIAL SPA+20 SPB+0 SPC+0 STAY\nL X+0 Y+0 R0 FMAX\nL Z-2 F300\nPLANE RESET STAY\nM30\n"
    klartext = f"BEGIN PGM T MM\nTOOL CALL 1 Z S5000 F500\nM3\nL Z+100 FMAX\n{plane}END PGM T MM\n"
    [item] = check(klartext, machine, vp.Options(dialect="heidenhain", **placed)).findings
    assert f"or turn {axes} to its {parameters} (" in item.message
    swivel = 'T1 D1 M6\nS1 M3\nG0 Z9\nCYCLE800(0,"",0,57,0,0,0,0,20,0,0,0,0,0)\nG0 X0 Y0\nG1 Z-2 F9\nCYCLE800()\nM30\n'
    [item] = check(swivel, machine, vp.Options(dialect="siemens", **placed)).findings
    assert item.message.endswith(f"or turn {axes}")


@pytest.mark.parametrize(
    ("more", "wcs", "expected"),
    [
        ("G55 X0\n", {"G54": (0, 0, 30)}, ("error", 5, "G55 has no place on the table, and G54 has one")),
        (
            "G55 X0\n",
            {"G54": (0, 0, 30), "G56": (0, 0, 40)},
            ("error", 5, 'G54 and G56 have one: give wcs={"G55": (X, Y, Z)}, mm'),
        ),
        ("G55 X0\n", {}, ("warning", 2, "is at the rotary centre on the table face")),  # of both: nothing is given
        (
            "G59.1 X0\n",
            {"G54": (0, 0, 30)},
            ("error", 5, 'wcs={"G59.1": (X, Y, Z)}, mm from the rotary centre on the table face, or write G54 '),
        ),
        ("", {"G55": (0, 0, 30)}, ("error", 4, "G54 has no place")),  # it cuts in it
        ("G10 L2 P2 X0 Y0 Z-400\nG55 X0\n", {"G54": (0, 0, 30)}, None),  # the program places it
    ],
)
def test_a_work_offset_that_is_missing_beside_others_refuses(more, wcs, expected):
    """Cuts were made at the rotary centre because a line of the set-up was forgotten, and a warning went by."""
    found = check(BODY.format(length="", more=more), "verne", vp.Options(tool_length=80.0, wcs=wcs)).findings
    items = [item for item in found if item.code == "VP033"]
    assert bool(items) == (expected is not None)
    if expected is not None:
        severity, _line, text = expected
        assert items[0].severity == severity
        assert text in items[0].message
        all_given = vp.Options(tool_length=80.0, wcs=dict.fromkeys(("G54", "G55", "G59.1"), (0, 0, 30)))
        assert check(BODY.format(length="", more=more), "verne", all_given).ok


@pytest.mark.parametrize(
    ("rapid", "said"),
    [
        (
            "G0 X5 Z-5",
            ["a rapid with length 80, and tool 2 is 95 mm long: its tip goes down to Z-20; activate its length"],
        ),
        ("G0 X5", []),  # as CAM posts move before G43
        ("G0 X5 Z40", []),
        ("G0 X5 Z-5 (T1 AGAIN)", []),
    ],
)
def test_a_rapid_with_the_length_of_the_shorter_tool_before_goes_below_the_zero_of_the_part(rapid, said):
    """Only a cut with that length was told."""
    number = 1 if "AGAIN" in rapid else 2
    program = f"G21 G90\nT1 M6\nG0 X0 Y0 A0 C0\nG43 Z90 H1\nT{number} M6\n{rapid}\nG43 Z95 H{number}\nG0 X10\nM2\n"
    tools = {1: (80.0, 6.0), 2: (95.0, 6.0)}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 60)}, split_at_stops=True, dialect="rs274")
    found = [item for item in check(program, "verne", options).findings if item.code == "VP034"]
    assert [(item.line, item.message[: len(text)]) for item, text in zip(found, said, strict=True)] == [
        (6, text) for text in said
    ]


def test_rapids_before_the_first_work_system_do_not_use_the_one_before():
    program = "G21 G90 F600\nG0 Z90\nG55 X0 Y0 Z80 A0 C0\nG1 X5\nM2\n"
    found = check(program, "verne", vp.Options(tool_length=80.0, wcs={"G55": (0, 0, 30)})).findings
    assert {item.severity for item in found} <= {"warning"}


@pytest.mark.parametrize(
    ("program", "severity", "text"),
    [
        (
            "T1 M6\nG49 G0 X0 Y0 Z80 A0 C0\nG1 Z70\n",
            "error",
            "tool 1 cuts with length 0, and the set-up gives it 80 mm",
        ),
        ("T1 M6\nG49 G0 X0 Y0 Z80 A0 C0\nG1 X5\nG0 Z70\nG1 X9\n", "error", "it comes 80 mm too deep"),
        # posts without fast rapids move the retracted head at feed rate before G43
        ("T1 M6\nG49 G0 X0 Y0 Z80 A0 C0\nG1 X5\nG43 H1\nG1 Z70\n", "warning", "tool 1 cuts with length 0"),
        ("G49 G0 X0 Y0 Z80 A0 C0\nG1 Z70\n", "warning", "the tool has no length"),  # nor said which tool it is
    ],
)
def test_a_tool_that_comes_down_without_its_length_refuses(program, severity, text):
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 30)}, split_at_stops=True)
    (found,) = check(f"G21 G90 F600 S900\n{program}M2\n".replace("M6\n", "M6 M3\n"), "verne", options).findings
    assert (found.code, found.severity) == ("VP034", severity)
    assert text in found.message


def test_a_length_that_is_given_and_not_active_is_not_asked_for(run, tmp_path) -> None:
    """The remedy asked to fill in the length, which was there; what is missing is G43."""
    program = tmp_path / "part.nc"
    program.write_text("G21 G90\nT1 M6\nS900 M3\nG54 G0 X0 Y0 Z80 A0 C0\nG1 X5 F600\nM2\n")
    (tmp_path / "part.nc.toml").write_text("tools.1.length = 80\nwcs.G54 = [0, 0, 30]\n")
    out = run("check", program).out
    assert "part.nc:5: VP012 error: tool 1 has no length in force before the first feed move; " in out
    assert "write G43 H1 before it" in out
    assert "Fill in" not in out


def test_a_called_tool_without_g43_is_told_so_and_setup_asks_for_its_length(run, tmp_path) -> None:
    """The remedy was to call the tool, which is called, and no form had the length."""
    program, form = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    program.write_text("G21 G90\nT1 M6\nS900 M3\nG54 G0 X0 Y0 Z80 A0 C0\nG1 X5 F600\nM2\n")
    out = run("check", program, "--wcs", "G54=0,0,30").out
    assert "VP012 error: tool 1 has no length in force before the first feed move; write G43 H1 before it" in out
    assert "call the tool" not in out
    assert "write G43 H1" in run("setup", program, "--wcs", "G54=0,0,30").err  # before the form is filled in
    assert '1 = { length = "measure"' in form.read_text()
    form.write_text(form.read_text().replace('"measure"', "80"))
    assert "tool 1 has no length in force before the first feed move" in run("check", program).out
    program.write_text(program.read_text().replace("G54 G0", "G54 G43 H1 G0"))
    assert run("check", program).code == 0
    form.unlink()
    program.write_text(program.read_text().replace("G43 H1 ", ""))
    assert run("check", program, "--wcs", "G54=0,0,30", "--tool-length", 80).code == 0


def test_a_tool_that_comes_down_with_the_length_of_another_refuses() -> None:
    tools = {n: vp.Tool(n, n, (0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)) for n, z in {1: 80.0, 2: 110.0}.items()}
    program = (
        "G21 G90 F600 S900\nT1 M6\nM3 G43 H1\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nG0 Z90\nT2 M6\nS900 M3 G1 X6 F600\n{}Z70\nM2\n"
    )
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}, split_at_stops=True)
    (found,) = check(program.format(""), "verne", options).findings
    assert (found.code, found.severity, found.line) == ("VP034", "error", 9)
    (found,) = check(program.format("G43 H2\n"), "verne", options).findings
    assert (found.code, found.severity, found.line) == ("VP034", "warning", 8)


CUTS = "G1 X10 F500\nY10\nM30\n"


@pytest.mark.parametrize(
    ("dialect", "program", "said"),
    [
        ("rs274", f"G21 G90 G64 P10\nG0 X0 Y0 Z80 A0 C0\n{CUTS}", "off by 10 mm"),
        ("rs274", f"G21 G90 G64 P1\nG0 X0 Y0 Z80 A0 C0\n{CUTS}", ""),
        ("rs274", "G21 G90 G64 P10\nG0 X0 Y0 Z80 A0 C0\nX9\nG64 P0.1\nG1 X10 F500\nY10\nM2\n", ""),
        ("siemens", f"G71 G90 G641 ADIS=10\nG0 X0 Y0 Z80 A0 C0\n{CUTS}", "off by 2.5 mm"),
        ("siemens", f"G71 G90 G645 CTOL=2\nG0 X0 Y0 Z80 A0 C0\n{CUTS}", "off by 2 mm"),
        ("siemens", f"G71 G90 G642 OTOL=30\nG0 X0 Y0 Z80 A0 C0\n{CUTS}", "off by 30 deg"),
        (
            "heidenhain",
            "BEGIN PGM G MM\nCYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T10\nL X+0 Y+0 Z+80 A+0 C+0 R0 FMAX\n"
            "L X+10 F500\nL Y+10\nEND PGM G MM\n",
            "off by 10 mm",
        ),
    ],
)
def test_a_tolerance_of_the_program_that_cannot_be_meant(dialect, program, said):
    """G64 P10 passed without a word, though --tolerance 10 has a warning."""
    options = vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 30)}, dialect=dialect)
    found = [item for item in check(program, "verne", options).findings if item.code == "VP505"]
    assert [said in item.message for item in found] == ([True] if said else [])
    for item in found:
        line = program.split("\n")[item.line - 1]
        assert line[item.column - 1 :].startswith(("G64 P10", "ADIS=", "CTOL=", "OTOL=", "T10"))


def test_a_name_that_begins_like_another_is_a_system_of_its_own():
    result = check(BODY.format(length="", more="G59.1 X0\nG59 X2\n"), "verne", vp.Options(tool_length=80.0))
    texts = " ".join(item.message for item in result.findings if item.code == "VP033")
    assert 'wcs={"G59.1": (' in texts
    assert 'wcs={"G59": (' in texts


@pytest.mark.parametrize(
    ("number", "name"), [("", "G54"), ("2", "G55"), ("9", "G59.3"), ("10", "G54.1P10"), ("48", "G54.1P48")]
)
def test_klartext_calls_a_work_system_a_preset(number, name):
    """A person at a Heidenhain control has never seen G54."""
    chosen = f"CYCL DEF 247 DATUM SETTING Q339={number}\n" if number else ""
    program = f"BEGIN PGM P MM\n{chosen}L X+0 Y+0 Z+80 A+0 C+0 R0 FMAX\nL X+5 F500\nEND PGM P MM\n"
    result = check(program, "verne", vp.Options(tool_length=80.0, dialect="heidenhain"))
    preset = f"preset {number or 1}"
    assert [item.message for item in result.findings if item.code == "VP033"] == [
        f"no datum was given: {preset} is at the rotary centre on the table face; "
        f'give wcs={{"{name}": (X, Y, Z)}}, the name of {preset} here'
    ]


def test_each_system_once_and_with_its_option():
    source = BODY.format(length="", more="G55 X0\nG54 X0\nG55 X5\n")
    result = check(source, "verne", vp.Options(tool_length=80.0))
    texts = [item.message for item in result.findings if item.code == "VP033"]
    assert len(texts) == 2
    assert 'give wcs={"G54": (X, Y, Z)}' in texts[0]
    assert 'give wcs={"G55": (X, Y, Z)}' in texts[1]


def tool(number, length):
    """A tool of the set-up; one without a length still has to be measured."""
    return vp.Tool(number, number, (0.0, 0.0, length or 0.0, *(0.0,) * 6), 10.0, "" if length else "part.nc.toml")


TWO, HABIT = (tool(1, 80.0), tool(5, 90.0)), "T1 M6\nG43 H51\n"


@pytest.mark.parametrize("dialect", ["rs274", "fanuc"])
@pytest.mark.parametrize(
    ("body", "tools", "said"),
    [
        ("T1 M6\nG43 H5\n", TWO, "number 5, 90 mm, is in force, but tool 1, which has 80 mm, is in the spindle"),
        ("T1 M6\nG43.4 H5\n", TWO, "is in force, but tool 1, which has 80 mm, is in the spindle"),
        ("T1 M6\nT5\nG43 H5\n", TWO, "T5 only selects the tool, and no M6 loads it: H5 in line"),
        ("T5\nG43 H5\n", TWO, "puts its length, 90 mm, in force, and the tool table has others; write M6 after T5"),
        ("T1\nG43 H5\n", TWO, "but T1 was called, which has 80 mm"),
        (HABIT, (tool(1, 80.0), tool(51, 81.0)), "but tool 1, which has 80 mm, is in the spindle"),
        ("T1 M6\nG43 H5\n", TWO, "; if tool 5 is to cut, call T5 M6 before, else write H1"),
        (HABIT, (tool(1, 80.0), tool(51, 80.0)), ""),  # a shop's numbers: nothing contradicts them
        (HABIT, (tool(1, None), tool(51, 80.0)), ""),
        ("T1 M6\nT5\nG43 H1\n", TWO, ""),  # the next tool is made ready
        ("G43 H5\n", TWO, ""),  # what is in the spindle is not known
        ("T5\nG43 H5\n", (tool(5, 90.0),), ""),  # no other tool is there
    ],
)
def test_the_length_of_another_tool(dialect, body, tools, said):
    """G43 H5 after T1 M6 moved the tip by the difference of two tools, without a word."""
    cuts = f"S3000 M3\nG0 X0. Y0. Z50. A0. C0.\nG1 X10. F600.\n{body.splitlines()[-1]}\nG0 Z60.\nM30\n"
    source = f"O1\nG21 G90 G94\n{body}{cuts}"
    options = vp.Options(tools={one.number: one for one in tools}, wcs={"G54": (0, 0, 60)}, dialect=dialect)
    found = check(source.removeprefix("O1\n" if dialect == "rs274" else ""), "verne", options).findings
    found = [item for item in found if said or item.code == "VP049"]
    assert [item.code for item in found] == ["VP041" if "no M6" in said or "write M6" in said else "VP049"][
        : bool(said)
    ]
    assert {item.severity for item in found} <= {"warning"}
    assert said in "".join(item.message for item in found)


SWITCHED = """G17 G90 G94 G710 G54
SUPA G0 Z0 D0
T1 D1
M6
S900 M3
G0 X0 Y0 A0 C0
Z60
G1 Z20 F600
G0 Z60
SUPA G0 Z0 D0
{}S900 M3
G0 X5 Y5
G0 Z{}
G1 Z20 F600
G0 Z60
M30
"""


AGAIN = (
    "T1 in line 11 only selects the tool that is in the spindle, and D1 beside T waits for M6; write D1 in a block "
    "without T, or M6 after T1"
)


@pytest.mark.parametrize(
    ("change", "low", "wanted"),
    [
        ("T2 D1\n", -20, ("VP041", 11, "T2 only selects the tool, and no M6 loads it")),
        (
            "",
            -20,
            ("VP034", 13, "from line 10 on its length is not in force, and no block since then calls a tool or a"),
        ),
        ("T1 D1\n", -20, ("VP034", 14, f"{AGAIN}, or the rapid in machine coordinates (SUPA)")),
        ("T1 D1\n", 95, ("VP034", 15, f"it comes 90 mm too deep; {AGAIN}, or give it the length 0")),
    ],
)
def test_a_rapid_without_length_has_the_cause_that_the_change_lacks(change, low, wanted) -> None:
    """M6 was missing, and a second finding asked for machine coordinates; T and M6 were, and nothing named D0."""
    tools = {number: tool(number, length) for number, length in ((1, 90.0), (2, 80.0))}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}, split_at_stops=True, dialect="siemens")
    (item,) = check(SWITCHED.format(change, low), "verne", options).findings
    assert (item.code, item.line, item.severity) == (*wanted[:2], "error")
    assert wanted[2] in item.message
    for right in ("T1 D1\nD1\n", "T1 M6\nD1\n") if AGAIN in item.message else ():  # as the edits write it
        assert check(SWITCHED.format(right, 95), "verne", options).findings == ()
        assert [one.value for one in item.edits] == ["D1", "M6"]


CUTTERS = {4: tool(4, 80.0), 5: vp.Tool(5, 5, tool(5, 80.0).offset, 12.0), 25: vp.Tool(25, 25, (0.0,) * 9, 11.8, "s")}
MILL = "O1\nG21 G90 G94\nG0 A0. C0.\n{}T5 M6\nS3000 M3\nG0 X-35. Y-25.\nG43 Z25. H{}\n"
MILL += "G1 Z20. F400.\nG41 X-25. Y-20. D{}\nY20.\nX-10.\nG40 X-35. Y-25.\nG0 Z90.\nM5\nM30\n"


@pytest.mark.parametrize(
    ("before", "number", "severity"),
    [
        ("", 5, []),
        ("", 4, ["warning"]),
        ("T4 M6\n", 4, ["error"]),
        ("T4\n", 4, ["error"]),  # it is meant to cut, though no M6 loads it
        ("", 25, []),  # of wear: a diameter and no length
    ],
)
def test_the_diameter_of_another_tool(before, number, severity) -> None:
    """D4 under T5 was 1 mm off the contour, without a word."""
    options = vp.Options(tools=CUTTERS, wcs={"G54": (0, 0, 30)}, dialect="fanuc", split_at_stops=True)
    result = check(MILL.format(before, 5, number), "verne", options)
    told = [item for item in result.findings if item.code == "VP049"]
    assert [item.severity for item in told] == severity
    assert result.ok == (severity != ["error"])
    for item in told:
        assert "number 4, 10 mm, is in force, but tool 5, which has 12 mm, is in the spindle" in item.message
        assert ("if tool 4 is to cut, call T4 M6 before, else write D5" in item.message) == bool(item.edits)
        assert [(edit.value, edit.word) for edit in item.edits] == [("5", ("D", 4))]
        assert item.column == MILL.format(before, 5, number).split("\n")[item.line - 1].index("D4") + 1


@pytest.mark.parametrize(
    ("between", "severity"),
    [("M5\nG53 G0 Z0\nM3\n", "error"), ("", "warning"), ("M5\nT3 M6\nM3\nG43 H3\n", "warning")],
)
def test_the_length_of_a_tool_whose_call_is_missing(between, severity) -> None:
    """T2 M6 was missing, and its H2 under T1 drove 10 mm too deep with a warning; a second offset needs no stop."""
    tools = {number: tool(number, length) for number, length in ((1, 90.0), (2, 80.0), (3, 100.0))}
    head, cut = "G21 G90 G94\nG0 A0 C0\nT1 M6\nM3 S900\nG0 X0 Y0\n", "G43 Z40 H{}\nG1 Z20 F600\nX5\nG0 Z40\n"
    program = f"{head}{cut.format(1)}{between}{cut.format(2)}M5\nM2\n"
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}, split_at_stops=True)
    found = [item for item in check(program, "verne", options).findings if item.code == "VP049"]
    assert [item.severity for item in found] == [severity]


@pytest.mark.parametrize(
    ("length", "diameter", "written", "meant", "key"),
    [(14, 5, "H14", "H5", "length"), (5, 6, "D6", "D5", "diameter"), (5, 7, "D7", "D5", "diameter")],
)
def test_a_number_that_no_tool_has_is_that_of_the_tool_in_the_spindle(length, diameter, written, meant, key) -> None:
    """The remedy was to add a tool 14 to the set-up."""
    tools = CUTTERS | {7: vp.Tool(7, 7, tool(7, 80.0).offset, 0.0)}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}, dialect="fanuc", split_at_stops=True)
    (item,) = check(MILL.format("", length, diameter), "verne", options).findings
    assert (item.code, item.settled_by) == ("VP012", (("tools", written[1:], key),))
    assert item.message.startswith(
        f"{written}: tool 5 is in the spindle, and tool {written[1:]} has no "
        if key[0] == "d"
        else f"{written}: tool 5 is in the spindle, and the set-up, or the tool table, has no"
    )
    assert item.message.endswith(f"; did you mean {meant}?")


def test_a_length_in_addition_or_after_a_code_of_the_builder_is_not_one_of_another_tool():
    for body, remap in (("T1 M6\nG43 H1\nG43.2 H5\n", {}), ("T1 M6\nT5\nM106\nG43 H5\n", {"M106": "M6"})):
        source = f"G21 G90 G94\n{body}S3000 M3\nG0 X0 Y0 Z50 A0 C0\nG1 X10 F600\nM2\n"
        tools = {one.number: one for one in TWO}
        options = vp.Options(tools=tools, wcs={"G54": (0, 0, 60)}, dialect="rs274", remap=remap)
        assert check(source, "verne", options).findings == ()


@pytest.mark.parametrize(("word", "line"), [(",ADJUST,5", 3), (",OSETNO,5", 3), ("", None), (",ADJUST,1", None)])
def test_the_register_of_a_length_in_a_cl_file(word, line):
    source = (
        f"PARTNO A\nUNITS/MM\nLOADTL/1{word}\nSPINDL/3000,CLW\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/600,MMPM\n"
        "GOTO/10,0,50\nFINI\n"
    )
    options = vp.Options(tools={one.number: one for one in TWO}, wcs={"G54": (0, 0, 60)}, dialect="aptcl")
    found = [(item.code, item.line) for item in check(source, "verne", options).findings]
    assert found == ([("VP049", line)] if line else [])


@pytest.mark.parametrize("meaning", ["event", "ignore"])
@pytest.mark.parametrize(
    ("body", "found"),
    [
        ("T1 M6\nM46\nG43 H5\nS900 M3\n", "VP049"),
        ("M46\nT1 M6\nG43 H5\nS900 M3\n", "VP049"),
        ("M46\nT1 M6\nG43 H1\nS900 M3\nG0 X0 Y0 Z50 A0 C0\nG1 Z10 F600\nG0 Z50\nT5\nG43 H5\n", "VP041"),
        ("T1 M6\nM46\nG43 H1\n", "VP050"),
        ("S900 M3\nM46\nT1 M6\nG43 H1\n", "VP050"),
    ],
)
def test_a_clamp_of_the_builder_switches_no_check_off(meaning, body, found):
    """After an "event", no check of tools and of the start of the spindle was left."""
    source = f"G21 G90 G94 G54\n{body}G0 X0 Y0 Z50 A0 C0\nG1 Z10 F600\nX10\nM2\n"
    tools = {one.number: one for one in TWO}
    options = vp.Options(
        tools=tools, wcs={"G54": (0, 0, 60)}, dialect="rs274", remap={"M46": meaning}, split_at_stops=True
    )
    assert found in [item.code for item in check(source, "verne", options).findings]


@pytest.mark.parametrize("dialect", ["rs274", "fanuc", "siemens"])
def test_a_code_of_the_builder_changes_the_tool_and_starts_the_spindle(dialect):
    """T and S of its block count for it, as for M6 and M3; in Siemens programs a name may do so."""
    change = "T{0} L6\nD1" if dialect == "siemens" else "T{0} M106\nG43 H{0}"
    cut = "G0 X0. Y0. Z50. A0. C0.\nG1 Z10. F600.\nG0 Z50.\n"
    source = f"{'G71' if dialect == 'siemens' else 'G21'} G90 G54\n"
    source += "".join(f"{change.format(tool)}\nS900 M13\n{cut}" for tool in (1, 5)) + "M30\n"
    source = "O1\n" + source if dialect == "fanuc" else source
    tools = {one.number: one for one in TWO}
    remap = {"L6": "M6"} if dialect == "siemens" else {"M106": "M6"}
    options = vp.Options(
        tools=tools, wcs={"G54": (0, 0, 60)}, dialect=dialect, remap=remap | {"M13": "M3"}, split_at_stops=True
    )
    checked = check(source, "verne", options)
    assert [(item.code, item.message) for item in checked.findings if item.severity != "note"] == []


@pytest.mark.parametrize(
    ("text", "is_told"),
    [
        ("X15.Y-5.; Z41.25 C30.", True),
        ("X15. Y-5. ;Z41.;C30.;", True),
        ("X15. Y-5.;", False),
        ("X15. ; TO Z5", False),
        ("X15. (SLOT; Z5.)", False),
        ("; X15. Y5.", False),  # a line that is taken out
        ("N90 ; X15.", False),
        ("M8 ; X15.", False),
        ("X15. ; T1 S900", False),
    ],
)
def test_words_of_axes_behind_a_semicolon(text, is_told):
    """On a Fanuc ; ends the block: what stood behind it was lost without a word."""
    source = f"G21 G90 G94 G54\nT1 M6\nS900 M3\nG0 X0. Y0. Z50. A0. C0.\nG1 Z40. F500.\n{text}\n{text}\nG0 Z50.\nM30\n"
    for dialect in ("fanuc", "rs274"):
        options = vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 60)}, dialect=dialect, split_at_stops=True)
        items = [item for item in check(source, "verne", options).findings if item.code == "VP001"]
        assert [(item.line, item.severity) for item in items] == [(6, "warning")] * (is_told and dialect == "fanuc")


def find_idle_cuts(program, dialect="rs274", **more):
    options = vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 60)}, dialect=dialect, split_at_stops=True, **more)
    found = check(program, "verne", options).findings
    assert not [item for item in found if item.severity == "error"], found
    return [(item.line, item.last_line, item.count) for item in found if item.code == "VP050"]


@pytest.mark.parametrize(
    ("dialect", "program", "switch"),
    [
        ("rs274", "G21 G90\nT1 M6\n*\nG0 X0 Y0 Z50 A0 C0\nG1 Z40 F600\nX10\nZ50\nM2\n", "M3 S900"),
        ("fanuc", "O1\nG21 G90\nT1 M6\n*\nG0 X0. Y0. Z50. A0. C0.\nG1 Z40. F600.\nX10.\nZ50.\nM30\n", "S900 M13"),
        ("siemens", "G71 G90\nT1 M6 D1\n*\nG0 X0 Y0 Z50 A0 C0\nG1 Z40 F600\nX10\nZ50\nM30\n", "S900 M3"),
        (
            "heidenhain",
            "BEGIN PGM P MM\nTOOL CALL 1 Z S900\n*\nL X+0 Y+0 Z+50 A+0 C+0 R0 FMAX\nL Z+40 F600\nL X+10\nL Z+50\n"
            "END PGM P MM\n",
            "M3",
        ),
        (
            "aptcl",
            "UNITS/MM\nLOADTL/1\n*\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/600,MMPM\nGOTO/0,0,40\nGOTO/10,0,40\nGOTO/10,0,50\n"
            "FINI\n",
            "SPINDL/900,CLW",
        ),
    ],
)
def test_a_spindle_that_is_never_started(dialect, program, switch):
    """With M3 and S removed a program cut without a word: of its three feed moves the last one retracts."""
    cut = next(n for n, text in enumerate(program.splitlines(), 1) if "40" in text)
    more = {"remap": {"M13": "M3"}} if "M13" in switch else {}
    if more:
        assert find_idle_cuts(program.replace("*", switch), dialect, remap={"M13": "event"}) == [(cut, cut + 1, 2)]
    assert find_idle_cuts(program.replace("*\n", "\n"), dialect) == [(cut, cut + 1, 2)]
    assert find_idle_cuts(program.replace("*", switch), dialect, **more) == []


BEGIN = "G21 G90 G61\nS900 M3\nG0 X0 Y0 Z50 A0 C0\nG1 Z40 F600\nX10\n"


@pytest.mark.parametrize(
    ("program", "found"),
    [
        (BEGIN + "M5\nX20\nX30\nG0 Z50\nM2\n", [(7, 8, 2)]),  # it goes on as if nothing were
        (BEGIN + "M5\nX20\nM3\nX30\nG0 Z50\nM2\n", [(7, 7, 1)]),
        (BEGIN + "G0 Z50\nM5\nX0\nG1 Z40\nX10\nM2\n", [(9, 10, 2)]),  # and nothing starts it again
        (BEGIN + "G0 Z50\nM5\nX0\nG1 Z45\nX10\nM3\nG1 Z40\nM2\n", []),  # a slow approach before M3, in the air
        (BEGIN + "Z50\nM5\nX0\nM2\n", []),  # a slow way home
        (BEGIN.replace("X10", "X10 M5") + "G0 Z50\nM2\n", []),  # controls stop it at the end of that block
        (BEGIN + "G0 Z50\nT2 M6\nG0 X0\nG1 Z40\nM2\n", [(9, 9, 1)]),
        (BEGIN + "G0 Z50\nT2 M6\nG0 X0\nM3\nG1 Z40\nM2\n", []),
        # a cycle cuts with every feed move, whatever starts the spindle later; G86 stops it itself
        (BEGIN + "G0 Z50\nT2 M6\nG81 X0 Z40 R45\nX5 M3\nG80\nM2\n", [(8, 8, 1)]),
        (BEGIN + "G0 Z50\nM5\nG83 X0 Z40 R45 Q3\nX5\nG80\nM3\nG1 Z40\nM2\n", [(8, 9, 4)]),
        (BEGIN + "G0 Z50\nG86 X0 Z40 R45 P0\nX5\nG80\nM5\nG0 X9\nM3\nG1 Z40\nM2\n", []),
        ("G21 G90 G61\nG0 X0 Y0 Z50 A0 C0\nG1 Z40 F600\nM2\n", []),  # a dry run has neither tool nor spindle
        ("G21 G90\nT1 M6\nM19 R0\nG0 X0 Y0 Z50 A0 C0\nG1 Z40 F600\nM2\n", []),  # broaching
        ("G21 G90\nT1 M6\nT0 M6\nG0 X0 Y0 Z50 A0 C0\nG1 Z40 F600\nM2\n", []),  # no tool, no cut
    ],
)
def test_a_spindle_that_was_stopped(program, found):
    """One finding with the number of moves; what may be in the air is not told."""
    # --tool-length is that of one tool
    tools = {number: tool(number, 80.0) for number in (1, 2)}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 60)}, dialect="rs274", split_at_stops=True)
    program = (
        program.replace("G61\n", "G61 G43 H1\n").replace("T1 M6\n", "T1 M6 G43 H1\n").replace("T2 M6", "T2 M6 G43")
    )
    given = check(program, "verne", options).findings
    assert {item.severity for item in given} <= {"warning"}, given
    assert [(item.line, item.last_line, item.count) for item in given if item.code == "VP050"] == found


def test_a_tap_turns_the_spindle_itself():
    program = "G21 G90 G94\nT1 M6\nG0 X0. Y0. Z50. A0. C0.\nM29 S100\nG95 G84 X0. Y0. R20. Z10. F1.\nG80\nM30\n"
    for more in ("", "M3\nG81 X9. R20. Z10. F90.\nG80\n"):
        program = program.replace("M30", f"{more}M30")
        assert find_idle_cuts(f"O1\n{program}", "fanuc", tapping="feed") == []


ROUNDS = "G0 X0 Y0 Z80 A0 C0\nG1 X10 F500\nY10\n"


@pytest.mark.parametrize(
    ("program", "options", "said"),
    [
        (f"G64 P0.01\n{ROUNDS}M2\n", {"tolerance": 0.05}, ["tolerance=0.05 has no effect: the program gives its own"]),
        (f"G64 P0.01\n{ROUNDS}M2\n", {}, []),
        (
            f"G64 P0.01\n{ROUNDS}G64\nX20\nY20\nM2\n",
            {"tolerance": 0.05},
            ["an effect on some cuts, and none on others"],
        ),
        (f"G64 P0.01\n{ROUNDS}G64 P0.03\nX20\nY20\nM2\n", {"tolerance": 0.05}, ["corners, 0.01 to 0.03 mm"]),
        (f"{ROUNDS}M2\n", {"tolerance": 0.05, "orientation_tolerance_deg": 0.1}, []),
        (f"G64 P0.01\n{ROUNDS}M2\n", {"orientation_tolerance_deg": 0.1}, []),  # P is of the tip
        (f"G61\n{ROUNDS}M2\n", {"tolerance": 0.05}, ["it has no G64"]),
        (f"G64 P0\n{ROUNDS}M2\n", {"orientation_tolerance_deg": 0.1}, ["orientation_tolerance_deg=0.1 has no effect"]),
        (f"G64 P0.01\n{ROUNDS}G64 P0\nX20\nY20\nM2\n", {"tolerance": 0.05}, ["corners, 0.01 mm"]),
        (f"{ROUNDS}M2\n", {"tolerance": 0.05, "smoothing": "off"}, ['with smoothing="off" the tool stops']),
        (
            f"G642\nCTOL=0.02\nOTOL=0.3\n{ROUNDS}M30\n",
            {"dialect": "siemens", "tolerance": 0.05, "orientation_tolerance_deg": 0.1},
            ["corners, 0.02 mm", "corners, 0.3 deg"],
        ),
    ],
)
def test_a_tolerance_that_no_corner_takes_is_told(program, options, said):
    """A sweep of the tolerance over a program with G64 P gave one time five times, and nothing said why."""
    given = {"tool_length": 80.0, "wcs": {"G54": (0, 0, 30)}}
    head = "G71 G90\n" if "dialect" in options else "G21 G90\n"
    result = check(head + program, "verne", vp.Options(**given, **options))
    told = [item for item in result.findings if item.code == "VP040"]
    assert len(told) == len(said), result.findings
    for item, words in zip(told, said, strict=True):
        assert words in item.message
        assert item.severity == "note"
    if said and "an effect on" in said[0]:
        return
    # it is true: another value gives the same rows, where nothing is told other ones may come
    if said:
        other = {name: 3 * value for name, value in options.items() if "tolerance" in name}
        rows = [vp.convert(head + program, "verne", vp.Options(**given, **(options | more))) for more in ({}, other)]
        assert rows[0].setpoints.to_csv() == rows[1].setpoints.to_csv()


def test_a_tolerance_of_a_klartext_program_is_told_although_rapids_come_before_it():
    """Cycle 32 stands after the first rapids of every program, and they take the tolerance of the option."""
    program = (
        "BEGIN PGM T MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+80 A+0 C+0 R0 FMAX M3\nL Z+40 FMAX\n"
        "CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05\nL Z+0 F500\nL X+10\nL Y+10\nEND PGM T MM\n"
    )
    options = vp.Options(dialect="heidenhain", tool_length=80.0, wcs={"G54": (0, 0, 30)}, tolerance=0.02)
    told = [item for item in check(program, "verne", options).findings if item.code == "VP040"]
    assert [item.line for item in told] == [7]
    assert "tolerance=0.02 has an effect on rapids, and none on cuts: the program gives its own" in told[0].message
    assert "corners, 0.05 mm" in told[0].message


def test_a_tolerance_without_effect_is_told_at_the_code_that_has_its_own():
    result = check(
        f"G21 G90\nG61\nG0 X0 Y0 Z80 A0 C0\nG64 P0.02\n{ROUNDS}M2\n",
        "verne",
        vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 30)}, tolerance=0.1),
    )
    assert [(item.code, item.line) for item in result.findings] == [("VP040", 6)]


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("a.nc", "G21 G90 G49\nG0 X0 Y0 Z50 A0 C0\nG55\nS900 M3\nG0 X5\nG1 Z40 F500\nM2\n", 3),
        ("a.mpf", "G710 G90 G17\nG0 X0 Y0 Z50 A0 C0\nG55\nS900 M3\nG0 X5\nG1 Z40 F500\nM30\n", 3),
        ("a.h", "BEGIN PGM A MM\nL X0 Y0 Z50 A0 C0 FMAX\nCYCL DEF 247 Q339=+2\nM3\nL X+5 FMAX\nEND PGM A MM\n", 3),
    ],
)
def test_a_missing_place_is_told_at_the_word_that_calls_it(tmp_path: Path, name: str, text: str, line: int) -> None:
    """It was told at the first move after it."""
    (tmp_path / name).write_text(text)
    options = vp.Options(tool_length=80.0, wcs={1: vp.WorkOffset((0.0, 0.0, 60.0))})
    found = check(tmp_path / name, "verne", options).findings
    assert [item.line for item in found if item.code == "VP033"] == [line]


@pytest.mark.parametrize(
    ("turn", "length", "line"),
    [
        ("", "G43 H1", 8),
        ("G53.1", "G43 H1", None),
        ("G0 A20. C0.", "G43.4 H1", None),  # the words of the axes align the tool
        ("", "G43.4 H1", 8),
        ("G69", "G43 H1", None),
    ],
)
def test_a_plane_to_which_nothing_turns_the_table(turn, length, line) -> None:
    """A forgotten G53.1 cut the plane with an upright tool, without a word."""
    program = f"""O1
G21 G90 G94 G0 A0. C0.
T1 M6
S5000 M3
G68.2 X0. Y0. Z0. I0. J20. K0.
{turn}
{length} G0 X0. Y0. Z40.
G1 Z20. F500.
G0 Z40.
G69
M30
"""
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 100)}, dialect="fanuc", split_at_stops=True)
    found = check(program, "verne", options).findings
    assert all(item.code in ("VP042", "VP016") for item in found), found
    assert [(item.severity, item.line) for item in found if item.code == "VP042"] == [("warning", line)][: bool(line)]
    assert all("tilted by 20 deg" in item.message for item in found if item.code == "VP042")


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("a.nc", "G21 G90 G49\nG53 G0 Z500\nG0 A0 C0\nG54 X0 Y0 Z50\nS900 M3\nG1 Z40 F500\nM2\n", 4),
        ("a.nc", "G21 G90 G49\nG0 X0 Y0 Z50 A0 C0\nS900 M3\nG1 Z40 F500\nG54 X5\nM2\n", 4),  # it cuts before
        ("a.mpf", "; A\nG710 G90 G17\nSUPA G0 Z500 D0\nG54\nG0 X0 Y0 Z50 A0 C0\nS900 M3\nG1 Z40 F500\nM30\n", 4),
    ],
)
def test_a_retract_before_g54_does_not_take_its_place(tmp_path: Path, name: str, text: str, line: int) -> None:
    """G54 without a place was told at the retract before it, or in line 1."""
    (tmp_path / name).write_text(text)
    found = check(tmp_path / name, "verne", vp.Options(tool_length=80.0)).findings
    assert [item.line for item in found if item.code == "VP033"] == [line]


@pytest.mark.parametrize(
    ("tilt", "end", "level", "left"),
    [
        ("TRAORI\nG0 A-20 C0", "TRAFOOF", "", "TRAFOOF in line 8"),
        ("TRAORI\nG0 A-20 C0", "TRAFOOF", "G0 A0 C0", ""),
        ("TRAORI\nG0 A-20 C0", "TRAFOOF", "SUPA G0 A0 C0 D0\nD1", ""),
        ("TRAORI\nG0 A-20 C0\nG0 A0", "TRAFOOF", "", ""),
        (SWIVEL, "CYCLE800()", "", "CYCLE800() in line 7"),
        (SWIVEL, "CYCLE800()", "G0 A0 C0", ""),
        (SWIVEL, "CYCLE800()", SWIVEL, ""),
        ("G0 A-20 C0", "", "", ""),  # the program itself puts the table there
    ],
)
def test_a_table_that_stays_tilted_after_what_tilted_it(tmp_path: Path, tilt, end, level, left) -> None:
    """Siemens: three-axis work after TRAFOOF, on a table still tilted, had no warning."""
    head = "G17 G54 G64 G90 G94 G710\nT1 D1\nM6\nS900 M3\n"
    text = f"{head}{tilt}\nG0 X0 Y0 Z60\n{end}\nG0 Z70\n{level}\nG0 X0 Y0 Z60\nG1 Z55 F500\nX5\nG0 Z90\nM30\n"
    (tmp_path / "p.mpf").write_text(text)
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 40)})
    result = check(tmp_path / "p.mpf", "verne", options)
    found = [item for item in result.findings if item.severity == "error" or item.code == "VP037"]
    assert [item.code for item in found] == ["VP037"] * bool(left)
    if left:
        assert text.splitlines()[found[0].line - 1] == "G1 Z55 F500"
        assert f"where {left} has left it; name A and C before the cut: A0 C0 if" in found[0].message


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("CYCLE800()\nG0 Z90\nX9", [("VP043", 11)]),
        ("CYCLE800()\nX9\nX7", [("VP043", 10)]),
        ("CYCLE800()\nG0 Z90\nMCALL\nG1 X9 F500", [("VP043", 11), ("VP037", 13)]),
        ("MCALL\nCYCLE800()\nG0 Z70\nMCALL CYCLE81(60,40,2,35)\nX9\nG0 Z90\nMCALL", [("VP037", 14), ("VP043", 15)]),
    ],
)
def test_a_hole_of_a_forgotten_mcall_has_no_directions_of_its_own(tmp_path: Path, lines: str, told) -> None:
    """VP037 of the hole that VP043 names had the same cause; other cuts there keep theirs."""
    head = "G17 G54 G64 G90 G94 G710\nT1 D1\nM6\nS900 M3 F200\nG0 A0 C0\nG0 X0 Y0 Z80\n"
    text = f"{head}{SWIVEL}\nMCALL CYCLE81(30,0,2,-5)\nG0 X5 Y0\n{lines}\nG0 A0 C0\nM30\n"
    (tmp_path / "p.mpf").write_text(text)
    found = check(tmp_path / "p.mpf", "verne", vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 40)})).findings
    assert sorted((one.code, one.line) for one in found if one.code in ("VP037", "VP043")) == sorted(told)


@pytest.mark.parametrize(
    ("between", "line"),
    [
        ("G49\nG43.4 H1 G0 A0. C0.", 12),
        ("G69\nG49\nG43.4 H1 G0 A0. C0.", None),
        ("G49\nG43.4 H1 G0 A-20. C0.", None),  # the same plane goes on
        ("G49\nG43.4 H1 G0 A0. C0.\nG69", None),
    ],
)
def test_a_plane_that_is_in_force_after_g49(between: str, line: int | None) -> None:
    """Without G69 before G43.4, a level pocket was cut with the coordinates of the plane, without a word."""
    program = f"""O1
G21 G90 G94 G49 G69
T1 M6
S5000 M3
G43.4 H1 G0 A0. C0.
G0 X0. Y0. Z90.
G0 A-20.
G68.2 X0. Y0. Z0. I0. J20. K0.
G0 X0. Y0. Z30.
G1 Z20. F500.
G0 Z40.
{between}
G0 X0. Y0. Z30.
G1 Z20. F500.
G0 Z60.
M30
"""
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, dialect="fanuc")
    found = [item for item in check(program, "verne", options).findings if item.quantity == "G49"]
    assert [item.line for item in found] == [line][: bool(line)]
    assert all("still in force after G49, and line 15 cuts in it; write G69 before" in item.message for item in found)


@pytest.mark.parametrize(
    ("angles", "said"),
    [
        ((4, 6, 80, 9, 10), "A80 in this cut, and A6 and A9 in those before and after it: is A8 meant?"),
        ((0, 5, 80, 10, 12), ""),  # slots that step on
        ((2, 5, 80, 11, 14), "A80 in this cut, and A5 and A11 in those before and after it: is A8 meant?"),
        ((-4, -4, 40, 4, 4), ""),
        ((8, 8, 80, 8, 8), "A80 in this cut, and A8 and A8 in those before and after it: is A8 meant?"),
        ((0, 5, 40, 10, 12), ""),  # a tenth is none of those beside it
        ((8, 8, 80, 80, 80), ""),
        ((8, 8, 8, 8, 8), ""),
        ((0, 0, 35, 0, 0), ""),  # a face of the side, and back
        ((5, 5, 45, 5, 5), ""),  # a chamfer between walls of 5 degrees, and of 4 and 5
        ((4, 4, 45, 5, 5), ""),
        ((3, 4, 50, 5, 5), ""),
        ((7, 17, -23, 29, 30), "A-23 in this cut, and A17 and A29 in those before and after it: is A23 meant?"),
        ((7, 18, -19, 29, 30), ""),
    ],
)
def test_a_rotary_word_with_a_wrong_point_or_sign_is_in_doubt(angles: tuple[int, ...], said: str) -> None:
    """The tool swept over the part and back, without a word."""
    cuts = "".join(f"X{10 * number} Y1 Z{6 + number / 10} A{angle} C2\n" for number, angle in enumerate(angles))
    text = f"G17 G54 G90 G94 G710\nT1 D1\nM6\nS900 M3\nTRAORI\nG0 X-30 Y0 A0 C2\nZ30\nG1 Z5 F800\n{cuts}G0 Z60\nM30\n"
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 100)}, dialect="siemens")
    found = [one for one in vp.check(text, "verne", options).findings if "those before and after it" in one.message]
    assert [(one.message, one.line) for one in found] == [(said, 11)] * bool(said)


LEVEL_CUTS = tuple(f"X{at}. Y{round(0.117 * at * at, 3)} Z-1.5" for at in range(1, 10))


@pytest.mark.parametrize(
    ("wrong", "code", "said"),
    [
        ("X5. Y2.925 Z-1.5", "", ""),
        (
            "X5. Y2.925 Z-15.",
            "VP505",
            "Z-15 in this cut, and Z-1.5 and Z-1.5 in those before and after it: is Z-1.5 meant?",
        ),
        ("X5. Y2.925 Z1.5", "", ""),  # less than four steps up: an edge may be there
        ("X5. Y2.925 Z10.", "", ""),
        ("X4. Y1.872 Z-15.", "", ""),  # straight down and up
    ],
)
def test_a_height_of_a_level_contour_is_in_doubt(wrong: str, code: str, said: str) -> None:
    cuts = "\n".join((*LEVEL_CUTS[:4], wrong, *LEVEL_CUTS[5:]))
    head = "G21 G90 G17 G54\nT1 M6\nS900 M3\nG0 X-1. Y0. A0 C0\nG43 H1 Z30.\nG1 Z-1.5 F90.\n"
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, dialect="fanuc")
    result = vp.check(f"{head}{cuts}\nG0 Z30.\nM30\n", "ac_trunnion", options)
    found = [one for one in result.findings if "in this cut, and" in one.message]
    assert [(one.code, one.message, one.line) for one in found] == [(code, said, 11)] * bool(code)


@pytest.mark.parametrize(
    "cuts",
    [
        "X0 Y5\nX10 Y5\nX20 Y-5\nX30 Y5\nX40 Y5",  # a notch
        "G20\nX0 Y.2\nX.4 Y.2\nX.8 Y-.2\nX1.2 Y.2\nX1.6 Y.2\nG21",
        "Y3\nX5 Y3\nX10 Y-3\nX15 Y3\nX20 Y3\nX25 Y3\nX30 Y-3\nX35 Y3\nX40 Y3",  # pointed teeth
        "X-4 Y0\nY10\nX4 Y20\nX-4 Y30\nY40",
        "X2 Y0\nY10\nX20 Y20\nX2 Y30\nY40",
        "Y2\nX5\nX10\nX15\nX20\nX25 Y20\nX30 Y2\nX35\nX40\nX45\nX50\nX55",
        "Z2\nX0\nX5 Z2\nX10 Z-2\nX15 Z2\nX20",  # a groove
        "Z-5\nX0\nX10 Z-5\nX20 Z5\nX30 Z-5\nX40",  # over a clamp
        "Z-5\nX5 Z-5\nX10 Z-5\nX15 Z-5\nX20 Z-5\nX25 Z5\nX30 Z-5\nX35 Z-5\nX40 Z-5\nX45 Z-5",
        "X0 Z-3\nX10\nX20 Z3\nX30 Z-3\nX40\nX50",
        "Z-2\nZ-4\nZ-6\nZ-8\nZ10\nZ-12\nZ-14\nZ-16\nZ-18",  # pecks
        "Z-2\nZ-4\nZ5\nZ-6\nZ-8",
        "Z-0.2\nX0\nX5 Z-0.2\nX10 Z-2\nX15 Z-0.2\nX20",  # a dimple
        "Z-10\nX0\nX5 Z-10\nX10 Z-1\nX15 Z-10\nX20 Z-10",  # a pointed tab
    ],
)
def test_notches_teeth_hops_and_pecks_are_no_slips(cuts: str) -> None:
    """Five round points were taken for a finely divided path; the proposal would have cut through a tab."""
    text = f"G21 G90 G94 G17 G54\nT1 M6\nS1000 M3\nG0 X0 Y0 Z50\nG1 Z0 F500\n{cuts}\nG0 Z50\nM5\nM30\n"
    result = vp.check(text, "serial", vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 50)}, dialect="rs274"))
    assert [one.message for one in result.findings if "in this cut, and" in one.message] == []


@pytest.mark.parametrize("turned", [8.127, 48.127])
@pytest.mark.parametrize(("a", "code"), [(0.0, ""), (0.1, ""), (8.0, "VP056")])
def test_c_of_an_upright_tool_is_not_in_doubt(a: float, turned: float, code: str) -> None:
    """C turned to where the next lean needs it, and the sign of its word was in doubt."""
    angles = [(0.237 * at, turned + 0.4 * at) for at in range(1, 10)]
    cuts = [f"X{5 * x:.3f} Y{x:.3f} Z5. A{a:.1f} C{c:.3f}" for x, c in angles]
    cuts[4] = cuts[4].replace("C", "C-")
    head = "O1\nG21 G90 G17 G54\nT1 M6\nS900 M3\nG43.4 H1 G0 X0 Y0 Z50. A0 C0\nG1 Z5. F90.\n"
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, dialect="fanuc")
    result = vp.check(head + "\n".join(cuts) + "\nG0 Z60.\nM30\n", "ac_trunnion", options)
    found = [one for one in result.findings if "in this cut, and" in one.message]
    assert [(one.code, one.line) for one in found] == [(code, 11)] * bool(code)


@pytest.mark.parametrize(("wrong", "is_doubted"), [("B3=-0.139", True), ("B3=0.139", False), ("B3=-0.05", False)])
def test_a_small_tool_axis_of_the_wrong_sign_is_in_doubt(wrong: str, is_doubted: bool) -> None:
    """Leads of five to fifteen degrees are usual, and axes that turn by half a degree a cut."""
    cuts = [f"X{at} A3={0.005 * at:.3f} B3=0.139 C3=0.990" for at in range(1, 8)]
    cuts[3] = cuts[3].replace("B3=0.139", wrong)
    head = "G17 G54 G90 G94 G710\nT1 D1\nM6\nS900 M3\nTRAORI\nG0 X0 Y0 Z50 A3=0 B3=0.139 C3=0.990\nG1 Z5 F800\n"
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, dialect="siemens")
    result = vp.check(head + "\n".join(cuts) + "\nG0 Z60\nM30\n", "ac_trunnion", options)
    assert [one.line for one in result.findings if one.code == "VP056"] == [11] * is_doubted


EVEN = tuple(
    f"X{3.0246 * at:.3f} Y{-1.01 * at:.2f} Z{1 + 0.01 * at * at:.2f} A{-3.05 * at:.2f} C{6.1 * at:.1f}"
    for at in range(1, 10)
)


@pytest.mark.parametrize(
    ("wrong", "code", "said", "value"),
    [
        ("X15.123 Y-5.05 Z1.25 A-15.25 C30.5", "", "", ""),
        (
            "X15.123 Y-5.05 Z1.25 A15.25 C30.5",
            "VP056",
            "A15.25 in this cut, and A-12.2 and A-18.3 in those before and after it",
            "-15.25",
        ),
        ("X-15.123 Y-5.05 Z1.25 A-15.25 C30.5", "VP056", "X-15.123 in this cut, and X12.098 and X18.148", "15.123"),
        ("X151.23 Y-5.05 Z1.25 A-15.25 C30.5", "VP505", "X151.23 in this cut, and X12.098 and X18.148", "15.123"),
        ("X15.123 Y-5.05 Z12.5 A-15.25 C30.5", "VP505", "Z12.5 in this cut, and Z1.16 and Z1.36", "1.25"),
        ("X1.5123 Y-5.05 Z1.25 A-15.25 C30.5", "VP505", "X1.5123 in this cut, and X12.098 and X18.148", "15.123"),
        (
            "X15.123 Y-5.05 Z1.25 C-15.25 A30.5",
            "VP056",
            "and A-18.3 C36.6 in those before and after it: are A and C exchanged?",
            "C",
        ),
        ("X15.123 Y-5.05 Z50. A-15.25 C30.5", "", "", ""),  # up and down again
        ("X15.123 Y-5.05 Z1.25 A-15.25 C#1", "", "", ""),
        ("X#2 Y-5.05 Z1.25 A-15.25 C30.5", "", "", ""),  # 151.23, and no number that an edit could correct
    ],
)
@pytest.mark.parametrize("unit", ["G21", "G20"])
def test_a_word_that_leaves_the_way_of_the_cuts_beside_it_is_in_doubt(
    unit: str, wrong: str, code: str, said: str, value: str
) -> None:
    head = f"O1\n{unit} G90 G17 G54\nT1 M6\nS900 M3\n#1=30.5\n#2=151.23\nG43.4 H1 G0 X0 Y0 Z5. A0 C0\nG1 Z1. F90.\n"
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, dialect="fanuc")
    found = list[vp.Finding]()
    for before in (4, 2):  # of two cuts before it nothing is said
        cuts = "\n".join((*EVEN[4 - before : 4], wrong, *EVEN[5:]))
        result = vp.check(f"{head}{cuts}\nG0 Z6.\nM30\n", "ac_trunnion", options)
        found += [one for one in result.findings if "in this cut, and" in one.message]
    assert [(one.code, one.line, said in one.message) for one in found] == [(code, 13, True)] * bool(code)
    assert [edit.value for one in found for edit in one.edits] == [value] * bool(value)


AT_8 = "".join(f"G1 X{at}. Y0. Z5. A8. C0.\n" for at in range(1, 6))
BY_0 = "G91\n" + "".join(f"G1 X1. A0. (CUT {at})\n" for at in range(1, 7)) + "G90\n"


@pytest.mark.parametrize(
    ("dialect", "cuts", "wrong", "column"),
    [
        ("siemens", AT_8.replace("A8.", "A=DC(8)"), {"X3. Y0. Z5. A=DC(8)": "X3. Y0. Z5. A=DC(80)"}, 16),
        ("siemens", AT_8.replace("A8.", "A=AC(8)"), {"X3. Y0. Z5. A=AC(8)": "X3. Y0. Z5. A=AC(80)"}, 16),
        ("fanuc", AT_8, {"X3. Y0. Z5. A8.": "X3. Y0. Z5. A#2"}, 16),
        ("fanuc", BY_0, {"A0. (CUT 3)": "A72.", "A0. (CUT 4)": "A-72."}, 8),
        ("fanuc", AT_8, {"X3. Y0. Z5. A8.": "X3. Y28. Z5. A80."}, 17),
        ("fanuc", AT_8.replace("C0.", "C-40.", 1), {"X3. Y0. Z5. A8.": "X3. Y0. Z5. A80."}, 16),
        ("called", AT_8, {"X3. Y0. Z5. A8.": "X3. Y0. Z5. A80."}, 16),
    ],
)
def test_an_angle_is_in_doubt_as_it_is_executed(
    dialect: str, cuts: str, wrong: dict[str, str], column: int | None
) -> None:
    """Of A=DC(80), a variable, G91 and a called file nothing was said, nor where the tip went far."""
    head = "G17 G54 G90 G94 G710\nT1 D1\nM6\nS900 M3\nTRAORI\nG0 X-1 Y0 Z50 A8 C0\nG1 Z6 F800\n"
    if dialect != "siemens":
        head = "O1\nG21 G90 G17 G54\nT1 M6\nS900 M3\n#2=80.\nG43.4 H1 G0 X-1. Y0. Z50. A8. C0.\nG1 Z6. F800.\n"
    is_called = dialect == "called"
    right = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 100)}, dialect="siemens" if dialect == "siemens" else "fanuc")
    for slips in ({}, wrong):
        for said, slip in slips.items():
            assert said in cuts
            cuts = cuts.replace(said, slip)
        options = right.changed(subroutines={"o0100": f"O100\n{cuts}M99\n".encode()}) if is_called else right
        program = f"{head}{'M98 P100' if is_called else cuts.rstrip()}\nG0 Z60.\nM30\n"
        found = [one for one in vp.check(program, "ac_trunnion", options).findings if "is A8 meant" in one.message]
        assert len(found) == bool(slips)
    assert "A80 in this cut, and A8 and A8 in those before and after it" in found[0].message
    has_number = "A80." in cuts or "(80)" in cuts  # else the edit would be in another line
    assert [one.value for one in found[0].edits] == ["8"] * (has_number and not is_called)
    if is_called:
        assert (found[0].called, found[0].line) == (("o0100.ngc", 4, column), 8)
    else:
        assert found[0].column == column


@pytest.mark.parametrize(
    ("before", "doubted", "after", "said"),
    [
        ("TX+0 TY+0.5 TZ+0.866025", "TX+0 TY-0.5 TZ+0.866025", "TX+0 TY+0.5 TZ+0.866025", "TY (-0.5)"),
        ("TX+0.4 TY+0.3 TZ+0.866025", "TX-0.4 TY+0.3 TZ+0.866025", "TX+0.4 TY+0.3 TZ+0.866025", "TX (-0.4)"),
        ("TX+0 TY+0.5 TZ+0.866025", "TX+0 TY-0.5 TZ+0.866025", "TX+0 TY-0.5 TZ+0.866025", ""),
        ("TX+0 TY+0.5 TZ+0.866025", "TX+0 TY+0.5 TZ+0.866025", "TX+0 TY+0.5 TZ+0.866025", ""),
    ],
)
@pytest.mark.parametrize("machine", ["verne", "ac_trunnion"])
def test_a_wrong_sign_of_ln_is_in_doubt(machine: str, before: str, doubted: str, after: str, said: str) -> None:
    """Of a CL file and of A3= it was told; LN has angles in place of the tool axis."""
    axes = (before, before, doubted, after, after)
    cuts = "".join(f"LN X{4 * number:+d} Y+0 Z+0.{number} {axis}\n" for number, axis in enumerate(axes))
    text = (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S900 F600\nM3\nM128\nL X+0 Y+0 Z+40 A+0 C+0 R0 FMAX\n"
        f"{cuts}M129\nL Z+60 FMAX\nM30\nEND PGM A MM\n"
    )
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 80)}, dialect="heidenhain")
    found = [item for item in vp.check(text, machine, options).findings if item.code == "VP056"]
    assert [(item.line, f"the sign of {said}" in item.message) for item in found] == [(8, True)] * bool(said)
    for item in found:
        (edit,) = item.edits
        right = text.replace(edit.misspelt, edit.value)
        assert not [one for one in vp.check(right, machine, options).findings if one.code == "VP056"]


ENDED = {
    "fanuc": "O1\nG21 G90 G94 G49 G69\nT1 M6\nS5000 M3\nG43.4 H1 G0 A0. C0.\nG0 X0. Y0. Z90.\n{}\nG0 X0. Y0. Z30.\n"
    "G1 Z20. F500.\nG0 Z60.\n{}",
    "siemens": "G17 G54 G90 G94 G710\nT1 D1\nM6\nS900 M3\nG0 X0 Y0 Z90\n{}\nG0 X0 Y0 Z30\nG1 Z20 F500\nG0 Z60\n{}",
    "heidenhain": "BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+90 A+0 C+0 R0 FMAX M3\n{}\nL X+0 Y+0 Z+30 FMAX\n"
    "L Z+20 F500\nL Z+60 FMAX\n{}\nEND PGM A MM\n",
}
G68 = "G0 A-20.\nG68.2 X0. Y0. Z0. I0. J20. K0."
LEVEL = 'CYCLE800(0,"",0,57,0,0,0,0,0,0,0,0,0,-1)'


@pytest.mark.parametrize(
    ("dialect", "plane", "end", "said"),
    [
        ("fanuc", G68, "M30\n", "G68.2 in line 8 is still in force at M30: controls keep it for the next program if a"),
        ("fanuc", G68, "G69\nM30\n", ""),
        ("siemens", SWIVEL, "M30\n", "CYCLE800 in line 6 is still in force at M30: controls keep it for the next"),
        ("siemens", SWIVEL, "CYCLE800()\nM30\n", ""),
        ("siemens", SWIVEL, f"{LEVEL}\nG0 Z90\nM30\n", ""),  # angles of 0 end it too
        ("siemens", SWIVEL, "RET\n", ""),  # a subprogram, whose caller may go on in the plane
        (
            "heidenhain",
            SPATIAL,
            "M30",
            "SPATIAL in line 4 is still in force at M30: controls keep it for the next",
        ),
        ("heidenhain", SPATIAL, "M5", "SPATIAL in line 4 is still in force at END PGM: controls keep it for the next"),
        ("heidenhain", SPATIAL, "PLANE RESET STAY\nM30", ""),
    ],
)
def test_a_plane_that_is_in_force_at_the_end(dialect: str, plane: str, end: str, said: str) -> None:
    """The next program began in it, without a word."""
    text = ENDED[dialect].format(plane, end)
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, dialect=dialect)
    found = [item for item in vp.check(text, "verne", options).findings if item.code == "VP043"]
    assert [said in item.message for item in found] == [True] * bool(said)
    for item in found:
        (edit,) = item.edits
        lines = text.splitlines()
        lines.insert(edit.line - 1, edit.value)
        assert not [one for one in vp.check("\n".join(lines) + "\n", "verne", options).findings if one.code == "VP043"]


def test_an_angle_that_a_later_line_gives_is_one_cause() -> None:
    """Cuts before A was named had two warnings: VP036, and VP037 about the angle that VP036 is about."""
    plane = "G68.2 X0. Y0. Z0. I0. J20. K0.\nG53.1\nG0 X0. Y0.\nG1 Z20. F500.\nG0 Z40.\nG69\n{}M30\n"
    program = "O1\nG21 G90 G94\nT1 M6\nS5000 M3\nG0 X0. Y0.\nG43 H1 Z90.\nG1 Z85. F500.\nX10.\nG0 Z95.\n" + plane
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 100)}, dialect="fanuc", split_at_stops=True)
    for more, expected in (("", [("VP036", 7)]), ("G0 Z90.\nG1 X9.\n", [("VP036", 7), ("VP037", 17)])):
        found = check(program.format(more), "verne", options).findings
        assert [(item.code, item.line) for item in found if item.code in ("VP036", "VP037")] == expected


def test_an_odd_length_is_told_with_the_name_of_its_tool(tmp_path) -> None:
    """A tool with a name has a number that nobody has seen."""
    path = tmp_path / "p.mpf"
    path.write_text('G710 G90\nT="EM10" M6\nD1\nG0 X0 Y0 Z100 A0 C0\nG1 Z90 F500\nM30\n')
    options = vp.Options(
        tools={100001: vp.Tool(100001, 1, (0.0, 0.0, 0.08, *(0.0,) * 6), 6.0)},
        dialect="siemens",
        control={"siemens": {"tools": {"EM10": 100001}}},
    )
    told = [item.message for item in check(path, "verne", options).findings if item.code == "VP505"]
    assert any('tool "EM10"' in one for one in told) and not any("100001" in one for one in told)


BACKWARDS = "G21 G90 G94\nT1 M6\nS900 {}\nG43 H1\nG0 X0 Y0 Z80 A0 C0\n{}\nG0 Z80\nM2\n"


@pytest.mark.parametrize(
    ("switch", "cut", "is_told"),
    [
        ("M4", "G1 Z60 F500", True),
        ("M4", "G81 X5 Y0 Z60 R70 F100\nG80", True),
        ("M3", "G1 Z60 F500", False),
        ("M4", "G0 Z60", False),  # it cuts nowhere
        ("M4", "G74 X5 Y0 Z60 R70 F900\nG80", False),  # a tap turns both ways
        ("M4\nM3", "G1 Z60 F500", False),
    ],
)
def test_a_tool_that_turns_backwards_in_its_cuts(switch: str, cut: str, is_told: bool) -> None:
    """A drill under M4 had no warning."""
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, tapping="feed", dialect="rs274")
    found = check(BACKWARDS.format(switch, cut), "verne", options).findings
    told = [item for item in found if item.severity != "note"]
    assert [(item.code, item.line) for item in told] == [("VP050", 3)] * is_told
    assert all("turns counter-clockwise (M4) where it cuts, from line" in item.message for item in told)


@pytest.mark.parametrize(
    ("spindle", "line", "said"),
    [
        ("SPINDL/900,RPM,CCLW", 3, "counter-clockwise (CCLW) where it cuts, from line 7 on"),
        ("SPINDL/900,RPM,CCLW", 3, "a right-hand drill or mill does not cut then; write CLW unless"),
        ("SPINDL/ON,CLW", 3, "as fast as before the program, or not at all; write SPINDL and its speed"),
        ("PPRINT/NONE", 7, "the spindle does not turn in 2 moves at feed rate: nothing starts it"),
        ("SPINDL/900,RPM,CLW", None, ""),
    ],
)
def test_the_spindle_of_a_cl_file_has_its_words(spindle: str, line: int | None, said: str) -> None:
    """M3 and S were to be written into a CL file."""
    text = f"UNITS/MM\nLOADTL/1\n{spindle}\nRAPID\nGOTO/0,0,90\n"
    text += "FEDRAT/500,MMPM\nGOTO/0,0,60\nGOTO/9,0,60\nRAPID\nGOTO/0,0,90\nFINI\n"
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, dialect="aptcl")
    told = [item for item in check(text, "verne", options).findings if item.code == "VP050"]
    assert [item.line for item in told] == ([line] if line else [])
    assert all(said in item.message and not item.edits for item in told)


@pytest.mark.parametrize(
    ("statement", "said"),
    [
        ("GOTO/1,0,60,0,0,0", "the tool axis (i, j, k of GOTO) has length 0; it must be a unit vector"),
        ("SPINDL/RPM,-900,CLW", "SPINDL -900: a spindle speed is not negative"),
        ("DELAY/5000", "a dwell of 5000 s: this language has seconds here; if milliseconds are meant, write 5"),
        ("FEDRAT/300000,MMPM", "FEDRAT is 300000 mm/min here: no cut has more than 100000 mm/min"),
    ],
)
def test_messages_about_a_cl_file_have_its_words(statement: str, said: str) -> None:
    """They spoke of (I, J, K), S, P, F and --dialect fanuc."""
    text = "UNITS/MM\nMULTAX/ON\nLOADTL/1\nSPINDL/900,RPM,CLW\nRAPID\nGOTO/0,0,90,0,0,1\nFEDRAT/500,MMPM\n"
    text += f"{statement}\nGOTO/9,0,60,0,0,1\nRAPID\nGOTO/0,0,90,0,0,1\nFINI\n"
    options = vp.Options(tools=TOOLS, wcs={"G54": (0, 0, 60)}, dialect="aptcl")
    (told,) = (item for item in check(text, "verne", options).findings if item.code in ("VP007", "VP505"))
    assert told.message.startswith(said)


KLARTEXT = """BEGIN PGM T MM
{}
L X+0 Y+0 Z+60 A+0 C+0 R0 FMAX M3
L Z+40 F500
L Z+60 FMAX
M30
END PGM T MM
"""


@pytest.mark.parametrize(
    ("call", "length", "expected", "said"),
    [
        ("TOOL CALL 1 Z S900", None, [], ""),
        ("TOOL CALL 1 Z S900 DL+0.2", None, [], ""),
        ("TOOL CALL 1 Z S900 DL+200", None, [("VP505", 2)], "DL+200 makes tool 1 200 mm longer than the 80 mm"),
        ("TOOL CALL 1 Z S900 DL-20", None, [("VP505", 2)], "DL-20 of tool 1: a deviation of 20 mm is above 10 mm"),
        ("TOOL CALL 1 Z S900 DR+20 ; RL", None, [("VP505", 2)], "if um were meant, write it as 0.02 mm"),
        ("TOOL CALL 1 Z S900 DR+8 ; RL", None, [("VP505", 2)], "and is larger than its 5 mm; a radius belongs in"),
        ("TOOL CALL 1 Z S900 DR+8", None, [], ""),  # no move takes the radius
        ("TOOL CALL 1 Z S900 DR+2.5 DL+3", None, [], ""),  # an allowance of a roughing cut
        ("TOOL DEF 2\nTOOL CALL 1 Z S900\nTOOL DEF 3", None, [], ""),
        ("TOOL DEF 1", None, [("VP012", 4)], "TOOL DEF 1 in line 2 only names the tool; write TOOL CALL 1 Z S"),
        ("TOOL DEF 1", 80.0, [("VP041", 2)], "TOOL DEF 1 only selects the tool, and no TOOL CALL loads it: line 4"),
    ],
)
def test_slips_in_the_call_of_a_tool_in_klartext(call, length, expected, said) -> None:
    """DL+200 for DL+0.200, and TOOL DEF for TOOL CALL, had no warning of their own."""
    tools = {"tools": OF_10_MM} if length is None else {"tool_length": length}
    options = vp.Options(wcs={"G54": (0, 0, 60)}, dialect="heidenhain", **tools)
    contour = "F500\nL X+30 RL\nL X+40\nL Y+20 R0" if "RL" in call else "F500"
    found = check(KLARTEXT.format(call).replace("F500", contour), "verne", options).findings
    assert [(item.code, item.line) for item in found] == expected
    assert all(said in item.message for item in found)


@pytest.mark.parametrize(
    ("wear", "said"),
    [
        ("L11 P1 R-20.", "G10 L11 R-20 of tool 1: a deviation of 20 mm is above 10 mm"),
        ("L13 P1 R6.", "a deviation of 6 mm is added to the radius, and is larger than its 5 mm"),
        ("L11 P1 R-0.2", ""),
        ("L13 P1 R0.3", ""),
        ("L10 P1 R90.", ""),
    ],
)
def test_wear_that_is_a_size(wear, said):
    text = f"G21 G90 G94 G17\nG10 {wear}\nT1 M6\nS900 M3\nG0 A0 C0\nX0 Y0\nG43 H1 Z60.\nG1 Z40. F500.\nG0 Z60.\nM30\n"
    options = vp.Options(wcs={"G54": (0, 0, 60)}, dialect="fanuc", tools=OF_10_MM)
    found = [item for item in check(text, "verne", options).findings if item.code == "VP505"]
    assert [item.line for item in found] == ([2] if said else [])
    assert all(said in item.message for item in found)


@pytest.mark.parametrize(
    ("offset", "code", "said"),
    [
        ("G505", "VP033", 'G505, which is G58 here, has no place on the table, and G54 has one: give wcs={"G58": (X'),
        ("G540", "VP033", "G540, which is G54.1P31 here, has no place on the table"),
        ("G55", "VP033", "G55 has no place on the table"),
        ("D0", "VP034", "activate its length (D1) after line 1, or give it the length 0"),
    ],
)
def test_a_siemens_program_is_told_in_its_own_words(offset, code, said):
    program = f"T1 M6\nD1 S900 M3\nG0 X0 Y0 Z60 A0 C0\n{offset}\nG1 X5 Y0 Z60 A0 C0 F100\nM30"
    tools = {1: vp.Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6))}
    options = vp.Options(dialect="siemens", tools=tools, wcs={"G54": (0, 0, 30)})
    (found,) = [item for item in check(program, "verne", options).findings if item.code == code]
    assert said in found.message
    assert "G43" not in found.message


@pytest.mark.parametrize(
    ("dialect", "cut", "line", "said"),
    [
        ("fanuc", "G95 G1 X5. F900.\nX9.", 6, "F is 900 mm a turn here: no cut has more than 20 mm a turn"),
        ("rs274", "G1 X5 F15000000", 6, "F is 15000000 mm/min here: no cut has more than 100000 mm/min"),
        ("siemens", "G95 G1 X5 F900", 6, "G95 of line 6 is active: if mm/min were meant, write G94 in its"),
        (
            "heidenhain",
            "L X+5 R0 F0.4",
            5,
            "F is 0.4 mm/min here: no cut has less than 1 mm/min; if mm a turn were meant, write M136",
        ),
        ("siemens", "G1 X5 F0.4", 6, "if mm a turn were meant, write G95 before"),
        ("heidenhain", "L X+5 R0 F400 M136", 5, "M136 of line 5 is active: if mm/min were meant, write M137 in"),
        ("fanuc", "G95 G1 X5. F9.\nG94 X9. F20000.", None, ""),
        # no joint goes so fast; the way down to where a hole ends so far may have any feed rate
        (
            "rs274",
            "G81 X5 Z70 R75 F90000\nG80",
            6,
            "drilling cycle, 100 mm a turn, and the joints of the machine",
        ),
        ("siemens", "F90000\nCYCLE81(80,75,1,70)", 7, "is a digit too many?"),
        ("rs274", "G81 X5 Z70 R75 F1900\nG80\nG1 Z70 F90000\nG0 Z80", None, ""),
        ("rs274", "M5\nG81 X5 Z70 R75 F90000\nG80", None, ""),
        (
            "heidenhain",
            "CYCL DEF 205 HOLE Q200=2 Q201=-9 Q206=90 Q202=3 Q203=75 Q204=2 Q212=0 Q205=1 Q258=1 Q259=1 Q257=0 Q256=1 "
            "Q211=0 Q379=3 Q253=90000\nL X+0 FMAX M99",
            None,
            "",
        ),
        ("fanuc", "G1 X5. F1.5\nG95 G0 X9.", None, ""),
    ],
)
def test_a_feed_that_no_cut_has_is_told_once(dialect, cut, line, said):
    """A feed a minute is left in force as a feed a turn, which is an error, or lacks its decimal point."""
    head = "G21 G90 G17\nG54\nS900 M3\nG0 A0. C0.\nG0 X0. Y0. Z80.\n"
    text = f"{head.replace('G21', 'G71') if dialect == 'siemens' else head}{cut}\nM30\n"
    if dialect == "heidenhain":
        text = (
            f"BEGIN PGM B MM\nTOOL CALL 1 Z S900\nL A+0 C+0 R0 FMAX M3\nL X+0 Y+0 Z+80 R0 FMAX\n{cut}\nEND PGM B MM\n"
        )
    options = vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 30)}, dialect=dialect)
    told = [item for item in check(text, "verne", options).findings if item.code == "VP505"]
    severity = "error" if "a turn here" in said or "mm/min were" in said else "warning"
    assert [(item.line, item.severity) for item in told] == ([] if line is None else [(line, severity)])
    assert all(said in item.message for item in told)


def list_sizes(body):
    """Line and message of each VP505 of a milling program; the first line of ``body`` is line 4."""
    program = f"G21 G90 G17\nG54 T1 M6\nS900 M3\n{body}\nM30\n"
    tools = {1: vp.Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6))}
    found = check(program, "ac_trunnion", vp.Options(tools=tools, wcs={"G54": (0, 0, 90)})).findings
    return [(item.line, item.message) for item in found if item.code == "VP505"]


@pytest.mark.parametrize(
    ("cuts", "line", "said"),
    [
        ("G1 Z2 F800\nX20 F1.5", 7, "F is 1.5 mm/min here, and up to 800 mm/min in other cuts: if it is in m/min, it"),
        ("G1 Z2 F400\nX20 F4.5", None, ""),
        ("G1 Z2 F1.5\nX20 F90", None, ""),
        ("G1 Z2 F4.5\nX20 F500", None, ""),  # a slow plunge: 4500 mm/min is no feed rate of this program
        ("G1 Z2 F1.5\nX20 F900", None, ""),  # nor is this one more than slow
        ("G95 G1 Z2 F0.1\nG94 X20 F900", None, ""),
        (
            "G1 Z2 F.15\nX20",
            6,
            "F is 0.15 mm/min here: no cut has less than 1 mm/min; if mm a turn were meant, write G95",
        ),
        ("G1 Z2 F900\nX20 F.15", 7, "F is 0.15 mm/min here: no cut has less than 1 mm/min"),  # once
        ("G1 Z2 F1\nX4 F1", None, ""),
        ("G93 G1 Z2 F0.01", None, ""),
        ("S600000 G1 Z2 F900", 6, "S600000: no spindle of a machine tool has more than 300000 1/min"),
        ("S160000 G1 Z2 F900", None, ""),
    ],
)
def test_feeds_and_speeds_in_another_unit_are_told(cuts, line, said):
    told = list_sizes(f"G0 A0 C0 X0 Y0\nG43 Z50 H1\n{cuts}")
    assert [at for at, _text in told] == ([] if line is None else [line])
    assert all(said in text for _at, text in told)


#: Remarks of tools in the words of five languages, and the diameter where they cut, mm.
TAPERED = (
    ("CENTER DRILL D=10", 3.15), ("CSINK D=20", 5.0), ("D=6 V-BIT", 0.2),
    ("D=10. KEGELSENKER", 3.0), ("D=12 NC-ANBOHRER 90GRAD", 2.0), ("D=8 GRAVIERSTICHEL", 0.5), ("D=16 ENTGRATER", 1.0),
    ("D=8 GEWINDEBOHRER M8", 6.8), ("D=10 FORET A CENTRER", 3.0), ("D=12 FRAISE A CHANFREINER", 2.0),
    ("D=10 PUNTA DA CENTRO", 3.0), ("D=20 SVASATORE", 4.0), ("D=10 BROCA DE CENTRAR", 3.0), ("D=16 AVELLANADOR", 5.0),
)  # fmt: skip


@pytest.mark.parametrize(
    ("dialect", "remark", "call", "diameter", "said"),
    [
        ("rs274", "(T1 D=12. - FLAT END MILL)", "T1 M6", 6.0, "tool 1: a diameter of 6 mm is half the 12 mm that"),
        (
            "siemens",
            '; T1 "EM12" D=12. MILL',
            'T="EM12" M6',
            24.0,
            'tool 1 "EM12": a diameter of 24 mm is twice the 12 mm',
        ),
        ("rs274", "(T1 D=12. - FLAT END MILL)", "T1 M6", 11.4, ""),  # ground again
        ("rs274", "(T1 D=12. - FLAT END MILL)", "T1 M6", 12.5, ""),  # more is left
        ("rs274", "(T1 D=3. - FLAT END MILL)", "T1 M6", 2.75, ""),
        (
            "rs274",
            "(T1 D=12. CR=2. - BULL NOSE END MILL)",
            "T1 M6",
            10.0,
            "tool 1: a diameter of 10 mm is not the 12 mm that the program's remark in line 1 names",
        ),
        ("siemens", '; T1 "EM12" D=12. MILL', 'T="EM12" M6', 16.0, 'tool 1 "EM12": a diameter of 16 mm is not the 12'),
        (
            "rs274",
            "(T1 D12 FLAT END MILL)",
            "T1 M6\nS9 M3 G0 A0 C0 X0 Y0\nG43 Z50 H1\nG41 D12 G1 X9 F90\nX30\nG40 X60",
            10.0,
            "",
        ),  # an entry of the tool table
        ("rs274", "(T1 D=12. TAPER=45. - ENGRAVER)", "T1 M6", 1.0, ""),  # the width where it cuts
        *(("rs274", f"(T1 {text})", "T1 M6", size, "") for text, size in TAPERED),
        ("rs274", "(T1 D=12. SCHAFTFRAESER)", "T1 M6", 10.0, "tool 1: a diameter of 10 mm is not the 12 mm that"),
        ("rs274", "(T1 D1 - FLAT END MILL)", "T1 M6", 2.0, ""),  # an entry of the tool table
        # two diameters, and those of other parts of the tool
        ("rs274", "(T1 CHAMFER MILL D=12. D1=6.)", "T1 M6", 6.0, ""),
        ("rs274", "(T1 D=12. D2=6. BORING BAR)", "T1 M6", 6.0, ""),
        ("rs274", "(T1 SHANK D=12. LOLLIPOP)", "T1 M6", 6.0, ""),
        ("rs274", "(T1 D=6. TIP RADIUS CUTTER)", "T1 M6", 12.0, ""),
    ],
)
def test_a_diameter_that_is_not_that_of_the_remark_is_told(dialect, remark, call, diameter, said):
    length, unit = ("D1", "G71") if dialect == "siemens" else ("G43 H1", "G21")
    text = f"{remark}\n{unit} G90 G17 G54\n{call}\nS900 M3\nG0 A0 C0 X0 Y0\n{length} Z50\nG1 Z9 F90\nM30\n"
    tools = {number: vp.Tool(number, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), diameter) for number in (1, 12)}
    names = {"siemens": {"tools": {"EM12": 1}}} if dialect == "siemens" else {}
    vise = vp.Box("vise", (190.0, 0.0, 0.0), (200.0, 9.0, 10.0))
    options = vp.Options(dialect=dialect, tools=tools, wcs={"G54": (0, 0, 90)}, control=names, keep_out=(vise,))
    told = [item for item in check(text, "ac_trunnion", options).findings if item.code == "VP505"]
    assert len(told) == bool(said)
    assert all(item.message.startswith(said) for item in told)
    if " is not " in said:  # where nothing uses the diameter, it may be any; compensation does
        alone = vp.Options(dialect=dialect, tools=tools, wcs={"G54": (0, 0, 90)}, control=names)
        compensated = text.replace("M30", "G41 X20\nX60\nG40 X90 Y0\nM30")
        for one, count in ((text, 0), (compensated, 1)):
            findings = check(one, "ac_trunnion", alone).findings
            assert [item.message for item in findings if item.code == "VP505"] == [
                item.message for item in told
            ] * count
    assert all(describe_remedy(item, "p.nc").startswith("Correct the diameter in the set-up or") for item in told)


def test_a_rapid_below_every_cut_has_its_own_advice_and_the_other_sign_as_a_choice():
    """The advice was about units of machine files."""
    program = "G21 G90 G17\nG54 T1 M6\nS900 M3\nG0 A0 C0 X0 Y0\nG43 Z50 H1\nG1 Z5 F100\nX20 F1000\nG0 Z-50\nZ50\nM30\n"
    tools = {1: vp.Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6))}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 90)})
    (item,) = (one for one in check(program, "ac_trunnion", options).findings if one.code == "VP505")
    assert describe_remedy(item, "p.nc") == "Correct the value in the program. No action is needed if it is meant."
    (edit,) = item.edits
    assert (edit.line, edit.word, edit.value, edit.is_choice) == (8, ("Z", -50.0), "50", True)


@pytest.mark.parametrize(
    ("clear", "cuts", "end", "line"),
    [
        ("G43 Z-50 H1", "G1 Z-5 F100\nX20", "G0 Z50", 5),
        ("G43 Z50 H1", "G1 Z-5 F100\nX20", "G0 Z-50", 8),
        ("G43 Z50 H1", "G1 Z-5 F100\nG0 Z-50\nX40\nZ2\nG1 Z-5\nX20", "G0 Z50", 7),  # a retract between two cuts
        ("G43 Z50 H1", "G1 Z-5 F100\nG0 Z-40\nX40\nZ2\nG1 Z-5\nX20", "G0 Z50", None),  # no height of the program
        # cuts from below: nothing else has this height, or they begin there
        ("G43 Z50 H1", "G0 Z-20\nG1 Z-5 F100\nX20", "G0 Z50", None),
        ("G43 Z20 H1", "G0 Z-20\nG1 Z-5 F100\nX20", "G0 Z-20\nX0\nZ20", None),
        ("X1\nG43 Z20 H1", "G0 Z-20\nG1 Y-12 Z-5 F100\nX20\nG0 Y-20\nZ-20", "Z20", None),
        ("G43 Z20 H1", "G0 Z-20\nG1 Z-19 F200\nG3 X20 Z-10 I10", "G0 X0\nZ20", None),
        ("G43 Z50 H1\nX40", "G0 Z-20\nG1 X20 F100\nZ-5", "G0 Z50", None),  # beside the part, and into it from there
        ("G43 Z50 H1", "G1 Z-5 F100\nG0 Z5\nZ-4.5\nG1 Z-9", "G0 Z50", None),  # pecks
        ("G43 Z50 H1", "G18 G2 X20 Z40 I10 K-5 F100\nG17 G0 Z34", "G0 X60", None),  # the arc went deeper
        ("G43 Z50 H1", "G1 Z-5 F100", "G91 G28 Z0\nG90", None),
        ("G43 Z50 H1", "G0 Z-60\nG1 Z-58 F100\nG0 Z-59\nX40\nZ59", "G0 Z50", None),  # spot-faced from behind
    ],
)
def test_a_rapid_below_every_cut_is_told(clear, cuts, end, line):
    told = list_sizes(f"G0 A0 C0 X0 Y0\n{clear}\n{cuts}\n{end}")
    assert [at for at, _text in told] == ([] if line is None else [line])
    assert all(
        "goes down to Z -50 mm, the deepest cut of its tool is at Z -5 mm, and other rapids go to Z 50" in text
        for _at, text in told
    )


@pytest.mark.parametrize(
    ("dialect", "lines", "expected"),
    [
        # what is wrong in line 11 is another thing: the second run had VP043
        ("siemens", f"TRANS X5\n{SWIVEL}", [("VP043", 9, "CYCLE800 in line 5 is still"), ("VP017", 12, "TRANS")]),
        # the plane is what is wrong in line 11
        (
            "siemens",
            "G0 A0 C0",
            [("VP017", 11, "CYCLE800 in line 5 (still in force after the change of tools in line 9)")],
        ),
        ("siemens", f"CYCLE800()\nTRANS X5\n{SWIVEL}", [("VP017", 13, "TRANS")]),
        ("heidenhain", f"CYCL DEF 7.0\nCYCL DEF 7.1 X+5\n{SPATIAL}", [("VP017", 11, "PLANE SPATIAL in line 4")]),
        ("fanuc", PLANE, [("VP017", 11, "G68.2 in line 5 (still in force after the change of tools in line 9)")]),
    ],
)
def test_a_plane_that_is_not_ended_is_told_in_the_first_run(dialect, lines, expected):
    """A program with another error had VP043 only after that was mended."""
    siemens = (
        f"G710 G90\nT1 D1 M6\nS800 M3\nG0 X0 Y0 Z60 A0 C0\n{SWIVEL}\nG0 X0 Y0 Z60\nG1 Z45 F200\nG0 Z80\nT2 D1 M6\n"
    )
    fanuc = f"T1 M6\nG43 H1\nS800 M3\nG0 X0. Y0. Z60. A0. C0.\n{PLANE}\nG1 Z45. F200.\nG0 Z80.\nT2 M6\n"
    klartext = (
        f"BEGIN PGM A MM\nTOOL CALL 1 Z S800\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\n{SPATIAL}\nL Z+50 F100\nL Z+60 FMAX\n"
        "TOOL CALL 2 Z S800\nL Z+60 FMAX M3"
    )
    heads = {"siemens": f"{siemens}S800 M3", "fanuc": f"{fanuc}G43 H2", "heidenhain": klartext}
    end = "L Z+45 F200\nEND PGM A MM" if dialect == "heidenhain" else "G0 X5. Y0. Z60.\nG1 Z45. F200.\nG0 Z80.\nM30"
    program = f"{heads[dialect]}\n{lines}\n{end}\n"
    tools = TOOLS | {2: vp.Tool(2, 2, TOOLS[1].offset)}
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 60)}, dialect=dialect, split_at_stops=True)
    found = [item for item in check(program, "verne", options).findings if item.code in ("VP043", "VP017")]
    assert sorted((item.code, item.line) for item in found) == sorted(item[:2] for item in expected)
    for (_code, _line, said), item in zip(sorted(expected), sorted(found, key=lambda one: one.code), strict=True):
        assert said in item.message


def test_a_feed_in_mm_a_minute_under_g93_is_told_by_check_and_explain() -> None:
    """A move of 260 mm would take 0.12 s; explain said that a line before it brings the tool there."""
    text = "G21 G90 G94 G17\nG0 X-130 Y0 Z60 A0 C0\nG93 G1 Z40 F20\nX130 F500\nG0 Z60\nM2\n"
    options = vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 80)})
    (told,) = (one for one in check(text, "ac_trunnion", options).findings if one.code == "VP505")
    assert (told.line, told.severity) == (4, "warning")
    assert "F500 is a time in G93, 0.12 s for this move, which is 130000 mm/min" in told.message
    explained = vp.explain(text, "ac_trunnion", 4, options)
    assert told.message in explained.text
    assert "brings the tool there" not in explained.text
    (edit,) = told.edits
    lines = text.split("\n")
    changed = "\n".join([*lines[: edit.line - 1], edit.value, *lines[edit.line - 1 :]])
    assert "VP505" not in {one.code for one in check(changed, "ac_trunnion", options).findings}


@pytest.mark.parametrize(
    ("shapes", "calls", "unchecked", "said"),
    [
        ((2,), "T1 M6", "shank and holder of tool 1: not among", "no line calls it, and tool 1 of the program has no"),
        ((2, 3), "T1 M6", "shank and holder of tool 1: not among", "no line calls a tool of them, and tool 1 of the"),
        ((1, 2), "T1 M6", "", ""),  # a file for many programs
        ((1,), "T1 M6\nT0 M6\nT1 M6", "", ""),
        ((), "T1 M6", "shank and holder of tool 1: not among", ""),
        ((4,), "T4 M6", "size; holder of tool 4: not among", ""),
        ((4,), "T1 M6\nT4 M6", "shank and holder of tool 1, holder of tool 4: not among", ""),
    ],
)
def test_a_called_tool_that_is_not_among_the_shapes_is_named(shapes, calls, unchecked, said):
    text = f"G21 G90 G17 G54\n{calls}\nS900 M3\nG0 A0 C0 X0 Y0\nG43 H1 Z50\nG1 Z9 F90\nM30\n"
    tools = {number: vp.Tool(number, number, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0) for number in (1, 4)}
    vise = vp.Box("vise", (190.0, 0.0, 0.0), (200.0, 9.0, 10.0))
    parts = (vp.Cylinder("cutter", 10.0, 20.0), vp.Cylinder("holder", 40.0))
    given = {number: parts if number < 4 else parts[:1] for number in shapes}  # tool 4 has a cutter alone
    options = vp.Options(tools=tools, wcs={"G54": (0, 0, 90)}, keep_out=(vise,), tool_shapes=given)
    result = vp.check(text, "ac_trunnion", options)
    told = [item.message for item in result.findings if item.code == "VP018"]
    assert len(told) == bool(said)
    assert all(said in one and one.endswith("; did you mean tool.1?") == (len(shapes) == 1) for one in told)
    summary = " ".join(str(result.summary).split())
    assert unchecked in summary and ("not among the tool shapes" in summary) == bool(unchecked)
