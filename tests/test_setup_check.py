"""VP033, VP034 and VP040: a set-up that nobody has given, or that nothing takes, is a finding."""

import pytest

import verne_post as vp

BODY = "G21 G90 F600\n{length}\nG0 X0 Y0 Z80 A0 C0\nG1 X5\n{more}M2\n"
TOOLS = {1: vp.Tool(1, 1, (0.0, 0.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))}


def warnings(length="", more="", **options):
    result = vp.check(BODY.format(length=length, more=more), "verne", vp.Options(**options))
    assert all(item.severity == "warning" for item in result.findings), result.findings
    return [(item.code, item.line) for item in result.findings if item.code in ("VP033", "VP034")]


@pytest.mark.parametrize(
    ("options", "length", "more", "expected"),
    [
        ({"tool_length": 80.0}, "", "", [("VP033", 4)]),
        ({"tool_length": 80.0, "wcs": {"G54": (0, 0, 0)}}, "", "", []),  # meant so
        ({"tool_length": 80.0, "wcs": {"G54": (0, 0, 30)}}, "", "", []),
        ({"tool_length": 80.0, "wcs": {"G54": (0, 0, 30)}}, "", "G55 X0\n", [("VP033", 5)]),
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
        ("T1 M6\nG43 H1\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nG49\nG0 Z90\nG1 X6\n", 8, "the tool has no length"),
    ],
)
def test_a_length_of_0_in_the_tool_table_is_told_as_such(program, line, text):
    """The warning asked for G43 where the program has it."""
    tools = TOOLS | {2: vp.Tool(2, 2, (0.0,) * 9)}
    result = vp.check(f"G21 G90 F600\n{program}M2\n", "verne", vp.Options(tools=tools, wcs={"G54": (0, 0, 30)}))
    assert [(item.code, item.line) for item in result.findings] == [("VP034", line)]
    assert text in result.findings[0].message
    assert ("no length is in force" in str(result.summary)) == ("G49" in program)


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
    found = [item for item in vp.check(program, "verne", options).findings if item.code == "VP505"]
    assert [said in item.message for item in found] == ([True] if said else [])


def test_a_name_that_begins_like_another_is_a_system_of_its_own():
    result = vp.check(BODY.format(length="", more="G59.1 X0\nG59 X2\n"), "verne", vp.Options(tool_length=80.0))
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
    result = vp.check(program, "verne", vp.Options(tool_length=80.0, dialect="heidenhain"))
    preset = f"preset {number or 1}"
    assert [item.message for item in result.findings if item.code == "VP033"] == [
        f"no datum was given: {preset} is on the table face, at the rotary centre; "
        f'give wcs={{"{name}": (X, Y, Z)}}, the name of {preset} here'
    ]


def test_each_system_once_and_with_its_option():
    source = BODY.format(length="", more="G55 X0\nG54 X0\nG55 X5\n")
    result = vp.check(source, "verne", vp.Options(tool_length=80.0))
    texts = [item.message for item in result.findings if item.code == "VP033"]
    assert len(texts) == 2
    assert 'give wcs={"G54": (X, Y, Z)}' in texts[0]
    assert 'give wcs={"G55": (X, Y, Z)}' in texts[1]


ROUNDS = "G0 X0 Y0 Z80 A0 C0\nG1 X10 F500\nY10\n"


@pytest.mark.parametrize(
    ("program", "options", "said"),
    [
        (f"G64 P0.01\n{ROUNDS}M2\n", {"tolerance": 0.05}, ["tolerance=0.05 has no effect: the program gives its own"]),
        (f"G64 P0.01\n{ROUNDS}M2\n", {}, []),
        (f"G64 P0.01\n{ROUNDS}G64\nX20\nY20\nM2\n", {"tolerance": 0.05}, []),  # some corner takes it
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
    result = vp.check(head + program, "verne", vp.Options(**given, **options))
    told = [item for item in result.findings if item.code == "VP040"]
    assert len(told) == len(said), result.findings
    for item, words in zip(told, said, strict=True):
        assert words in item.message
        assert item.severity == "note"
    # it is true: another value gives the same rows, where nothing is told other ones may come
    if said:
        other = {name: 3 * value for name, value in options.items() if "tolerance" in name}
        rows = [vp.convert(head + program, "verne", vp.Options(**given, **(options | more))) for more in ({}, other)]
        assert rows[0].setpoints.to_csv() == rows[1].setpoints.to_csv()


def test_a_tolerance_without_effect_is_told_at_the_code_that_has_its_own():
    result = vp.check(
        f"G21 G90\nG61\nG0 X0 Y0 Z80 A0 C0\nG64 P0.02\n{ROUNDS}M2\n",
        "verne",
        vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 30)}, tolerance=0.1),
    )
    assert [(item.code, item.line) for item in result.findings] == [("VP040", 6)]
