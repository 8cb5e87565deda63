"""Tool lengths of Fanuc after G28, G30 and G53, and in G91; Fanuc 0i-MB B-63844EN 14.1.2, and parameters 5001 and 5006.

Places are worked out by hand for the serial machine, whose home is at Z550: a tool of 100 mm with G54 at Z60.
"""

import numpy as np
import pytest

import verne_post as vp
from verne_post.app.assemble import assemble
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool, WorkOffset

LENGTHS = {1: 100.0, 2: 80.0}
HEAD = "%\nO1000\nG21 G17 G40 G49 G80 G90 G94\nT1 M6\nS1000 M3\nG0 G54 X0. Y0. A0. C0.\n"
CUT = "G43 H1 Z50.\nG1 Z5. F500\n"
FIRST = HEAD.count("\n") + 1


@pytest.fixture
def read():
    """What is wrong (code, line of the body), and the tip's Z at the end of each move, of the lines of a body."""

    def view(body, dialect="fanuc", tool_length=None, **keys):
        tools = {n: Tool(n, n, (0.0, 0.0, length, *[0.0] * 6), 10.0) for n, length in LENGTHS.items()}
        options = Options(
            dialect=dialect,
            wcs={1: WorkOffset((0, 0, 60))},
            control={"fanuc": keys},
            split_at_stops=True,
            **({"tools": tools} if tool_length is None else {"tool_length": tool_length}),
        )
        text, machine = f"{HEAD}{body}\nM30\n", vp.load_machine("serial")
        try:
            return [], np.array(assemble(text.encode(), machine, options).moves.end)[:, 2]
        except InputError as refusal:
            errors = [one for one in refusal.findings if one.severity == "error"]
            return [(one.code, one.line - FIRST + 1) for one in errors], None

    return view


RETURNS = ["G91 G28 Z0\nG90", "G53 G0 Z0\nG90", "G91 G30 P2 Z0\nG90", "G28 Z60.\nG90", "G91 G28 X0 Y0 Z0\nG90"]


@pytest.mark.parametrize("back", RETURNS)
@pytest.mark.parametrize("z", ["G0 Z10.", "G1 X9. Z5.", "G81 X9. Z-5. R2. F90", "G91 G0 Z-5.", "G28 Z90.", "G92 Z50."])
def test_z_after_a_return_is_refused(read, back, z):
    assert read(f"{CUT}{back}\nG0 X50. Y0\n{z}\nG0 Z20.\nZ30.")[0] == [("VP017", 6)]  # one mistake, told once
    assert read(f"{CUT}{back}\nG0 X50. Y0\n{z}", length_after_return="restored", length_in_g91="kept")[0] == []


def test_the_message_says_what_to_write(read):
    options = Options(dialect="fanuc", tools={1: Tool(1, 1, (0.0, 0.0, 100.0, *[0.0] * 6), 10.0)})
    text = f"{HEAD}{CUT}G91 G28 Z0\nG90\nG0 X50.\nZ10.\nM30\n"
    (finding,) = [one for one in vp.check(text, vp.load_machine("serial"), options).findings if one.severity == "error"]
    assert (finding.line, finding.column) == (12, 1)
    assert f"G28 of line {FIRST + 2} has cancelled the tool length of G43" in finding.message
    assert "the tool 100 mm deeper: write G43 H1 before Z, or G49" in finding.message


def test_the_message_names_the_tool_in_the_spindle():
    tools = {n: Tool(n, n, (0.0, 0.0, length, *[0.0] * 6), 10.0) for n, length in LENGTHS.items()}
    text = f"{HEAD}{CUT}G53 G0 Z0\nT2 M6\nS1000 M3\nG0 X50.\nZ10.\nM30\n"
    options = Options(dialect="fanuc", tools=tools)
    (finding,) = [one for one in vp.check(text, vp.load_machine("serial"), options).findings if one.severity == "error"]
    assert "the tool 80 mm deeper: write G43 H2 before Z" in finding.message


@pytest.mark.parametrize("change", ["T2 M6", "T2\nM6"])
def test_a_second_tool_beside_one_length_is_one_cause(read, change):
    """Its G43 is refused (VP018), and would have put a length in force: Z after it is right."""
    wrong = read(f"{CUT}G53 G0 Z0\n{change}\nS1000 M3\nG43 Z30. H2\nG81 X-15. Z-16. R3. F320\nG80", tool_length=90.0)[0]
    assert {code for code, _line in wrong} == {"VP018"}
    assert wrong[0] == ("VP018", 4 + change.count("\n"))


@pytest.mark.parametrize("back", RETURNS)
@pytest.mark.parametrize(
    "again", ["G43 H1 Z10.", "G43 Z10.", "H1 Z10.", "G43 H1\nG0 Z10.", "X9. Y9.\nX8.\nG43 H1 Z10."]
)
def test_a_length_that_is_named_again_holds(read, back, again):
    wrong, ends = read(f"{CUT}{back}\nG0 X50. Y0\n{again}")
    assert wrong == []
    assert ends[-1] == 10.0


@pytest.mark.parametrize(
    "body",
    [
        f"{CUT}G91 G28 Z0\nG28 X0 Y0\nG28 Z0\nG90 G53 G0 Z500.",  # no Z of the part
        f"{CUT}G91 G28 X0 Y0\nG90\nG0 Z20.",  # other axes than that of the tool
        f"{CUT}G53 G0 X5. Y5.\nG0 Z20.",
        f"{CUT}G91 G28 Z0\nG90 G49\nG0 Z150.",  # meant
        "G0 Z150.\nG91 G28 Z0\nG90\nG0 Z150.",  # none has been in force
        f"{CUT}G91 G28 Z0\nG90\nT2 M6\nG0 X5.\nG43 H2 Z9.",
        f"{CUT}G91 G28 Z0\nG90\nG68.2 X0 Y0 Z5. I0 J10. K0\nG43 H1\nG53.1\nG0 X1. Y1. Z50.\nG69",
    ],
)
def test_returns_that_change_no_z_are_executed(read, body):
    assert read(body)[0] == []


def test_a_tilted_plane_and_tcp_are_no_exceptions(read):
    tail = "G91 G28 Z0\nG90\nG0 X1. Y1. Z50.\nG69"
    assert read(f"{CUT}G0 Z90.\nG68.2 X0 Y0 Z5. I0 J10. K0\nG53.1\n{tail}")[0] == [("VP017", 8)]
    assert read(f"G43.4 H1 Z50.\n{tail}")[0] == [("VP017", 4)]


def test_one_length_for_the_program_is_cancelled_too(read):
    assert read(f"{CUT}G91 G28 Z0\nG90\nG0 Z20.", tool_length=100.0)[0] == [("VP017", 5)]


def test_linuxcnc_keeps_the_length(read):
    """In LinuxCNC only G49 ends it."""
    wrong, ends = read(f"{CUT}G91 G28 Z0\nG90\nG0 Z20.", "rs274")
    assert (wrong, ends[-1]) == ([], 20.0)


INCREMENTAL = [
    # Z200 without a length; then the tip is at 100 by the tool, so that -50 and -5 end at 45, or with the 100 at 145
    ("G0 Z200.\nG91\nG43 H1 Z-50.\nG1 Z-5. F200", 3, 45.0, 145.0),
    ("G0 Z200.\nG91\nG43 H1\nG0 X5.\nG1 Z-55. F200", 5, 45.0, 145.0),
    # home is Z550 of the machine: the spindle at 490 of the part, the tip 100 lower
    ("G91 G28 Z0\nG43 H1 Z-60.", 2, 330.0, 430.0),
    ("G43 H1 Z50.\nG91\nG28 Z0\nG43 H1 Z-60.", 4, 330.0, 430.0),
    # from 100 mm to 80: the tip is 20 mm higher, or the spindle goes down by these 20
    ("G43 H1 Z50.\nG91\nG43 H2 Z-5.", 3, 65.0, 45.0),
    ("G43 H1 Z50.\nG91\nH2 Z-5.", 3, 65.0, 45.0),
    # G49: the spindle is at 150 of the part
    ("G43 H1 Z50.\nG91\nG49 Z-5.", 3, 145.0, 45.0),
    # two changes that cancel each other, and one
    ("G43 H1 Z50.\nG91\nH2\nH1\nH2 Z-5.", 5, 65.0, 45.0),
    ("G43 H1 Z50.\nG20 G91\nH2 Z-1.", 3, 44.6, 24.6),
]


@pytest.mark.parametrize(("body", "line", "kept", "travelled"), INCREMENTAL)
def test_incremental_z_after_a_change_of_length_needs_a_key(read, body, line, kept, travelled):
    assert read(body)[0] == [("VP017", line)]
    for key, wanted in (("kept", kept), ("travelled", travelled)):
        wrong, ends = read(body, length_in_g91=key)
        assert wrong == []
        assert ends[-1] == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize(
    "body",
    [
        "G91 G28 Z0\nG90 G43 H1 Z50.\nG91 G1 Z-5. F200",
        "G43 H1\nG0 X5.\nX6.\nZ50.\nX7.\nG91 G1 Z-5. F200",  # named in G90, after lines that do not name it
        "G43 H1 Z50.\nG91 G43 H1 Z-5.\nH2\nH1 Z-5.",  # the same length
        "G43 H1\nG53 G0 Z-20.\nG43 H1 Z50.",
        "G43 H1 Z50.\nG91\nH2 X5.\nG28 Z0",  # home whatever holds
    ],
)
def test_other_incremental_values_need_none(read, body):
    assert read(body)[0] == []


@pytest.mark.parametrize("key", ["", "travelled"])
def test_a_cycle_in_g91_is_refused(read, key):
    """Where the level of the tool counts, it must be certain."""
    assert read("G43 H1 Z50.\nG91\nH2\nG81 X5. R-9. Z-5. F90", length_in_g91=key)[0] == [("VP017", 4)]


@pytest.mark.parametrize("dialect", ["fanuc", "rs274"])
def test_lengths_of_several_tools_without_a_change_are_told(dialect):
    """Nothing says that the program lacks T and M6, but that its lengths differ."""
    tools = {n: Tool(n, n, (0.0, 0.0, length, *[0.0] * 6), 10.0) for n, length in {1: 100.0, 2: 80.0, 3: 90.0}.items()}
    cut = "G90 G43 H{} Z50.\nG1 Z5. F500\nG91 G28 Z0\n"
    text = HEAD.replace("T1 M6\n", "{}\n") + cut.format(1) + cut.format(2) + cut.format(3) + "M30\n"
    options = Options(dialect=dialect, wcs={1: WorkOffset((0, 0, 60))}, tools=tools)
    (finding,) = vp.check(text.format("G0"), vp.load_machine("serial"), options).findings
    assert (finding.code, finding.severity, finding.line) == ("VP041", "warning", FIRST + 3)
    assert f"H1 of line {FIRST}, 100 mm: if another tool is to cut, write T2 M6 before" in finding.message
    assert not vp.check(text.format("G0").replace("H2", "H1").replace("H3", "H1"), "serial", options).findings
