"""VP056: an arc of half a turn or more where one of the other sense or sign would continue its neighbours."""

import math
from pathlib import Path

import pytest

from verne_post import check
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

from .builders import SAMPLES

HEADS = {
    "rs274": "G21 G17 G90 G94\nT1 M6\nG0 A0 C0\nX-20 Y-10\nG43 Z40\nS900 M3\nG1 Z20 F400\n",
    "siemens": "G17 G54 G90 G94 G710\nT1 D1\nM6\nG0 A0 C0\nX-20 Y-10 Z40\nS900 M3\nG1 Z20 F400\n",
    "heidenhain": "BEGIN PGM A MM\nTOOL CALL 1 Z S900 F400\nL A+0 C+0 FMAX M3\nL X-20 Y-10 FMAX\nL Z+40 FMAX\nL Z+20\n",
}
ENDS = {"rs274": "M2", "siemens": "M30", "heidenhain": "END PGM A MM"}
RADIUS = "meets both moves beside it at an angle, and one of 90 deg would continue them: is the other sign of {} meant?"
SENSE = "goes back on both moves beside it, and one of 90 deg would continue them: is the other sense meant ({})?"


def list_doubts(machine, dialect, text, diameter=4.0):
    """Line and message of each VP056; the lines count from the first one behind the head."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), diameter)}
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 40)}, tools=tools)
    result = check(f"{HEADS[dialect]}{text}\n{ENDS[dialect]}\n".encode(), machine, options)
    assert not [item for item in result.findings if item.severity == "error"], result.findings
    first = HEADS[dialect].count("\n")
    return [(item.line - first, item.message) for item in result.findings if item.code == "VP056"]


@pytest.mark.parametrize(("dialect", "wrong", "right", "said"), [
    ("rs274", "X10\nG3 X20 Y0 R-10\nG1 Y20", ("R-", "R"), RADIUS.format("R")),
    ("rs274", "X10\nG2 X20 Y0 J10\nG1 Y20", ("G2", "G3"), SENSE.format("G2 or G3")),
    ("rs274", "X10\nG2 X10 Y10 J10\nG1 X-20", ("G2", "G3"), SENSE.replace("90", "180").format("G2 or G3")),
    # beside the contour: arcs about the outside corners lie between
    ("rs274", "G41 X-10 Y-10\nX10\nG3 X20 Y0 R-10\nG1 Y20\nG40 Y30", ("R-", "R"), RADIUS.format("R")),
    ("rs274", "G41 X-10 Y-10\nX10\nG2 X20 Y0 J10\nG1 Y20\nG40 Y30", ("G2", "G3"), SENSE.format("G2 or G3")),
    ("siemens", "X10\nG3 X20 Y0 CR=-10\nG1 Y20", ("=-", "="), RADIUS.format("CR")),
    ("heidenhain", "L X+10\nCR X+20 Y+0 R-10 DR+\nL Y+20", ("R-", "R+"), RADIUS.format("R")),
    ("heidenhain", "L X+10\nCC X+10 Y+0\nC X+20 Y+0 DR-\nL Y+20", ("DR-", "DR+"), SENSE.format("DR+ or DR-")),
])  # fmt: skip
def test_another_arc_that_would_continue_both_neighbours_is_told(machine, dialect, wrong, right, said):
    ((line, message),) = list_doubts(machine, dialect, wrong)
    assert message.endswith(said) and message.startswith(("the arc of 270 deg ", "the arc of 180 deg ")), message
    assert wrong.split("\n")[line - 1].startswith(("G2", "G3", "C ", "CR"))
    assert list_doubts(machine, dialect, wrong.replace(*right)) == []


@pytest.mark.parametrize(
    "text",
    [
        "X10\nG2 X20 Y0 R10\nG1 Y20",  # a coved corner: less than half a turn
        "X20\nG3 X10 Y0 R-10\nG1 Y-20",  # a loop that continues both
        "X10\nG3 X20 Y0 R-10\nG1 X40",  # one neighbour alone
        "X10\nG3 X10 Y-10 J10\nG1 X20",  # a full circle
        "X10\nG3 X20 Y0 R-10\nG0 Y20",  # the contour ends
        # a row of scallops, and with an end piece of less than half a turn
        "X-40 Y0\nG2 X-20 Y0 I10 J0\nG2 X0 I10 J0\nG2 X20 I10 J0\nG2 X40 I10 J0\nG1 X45",
        "X-20 Y0\nG1 Y10\nG2 X0 Y10 I10 J0\nG2 X20 Y10 I10 J0\nG1 Y0",
    ],
)
def test_other_arcs_are_in_no_doubt(machine, text):
    assert list_doubts(machine, "rs274", text) == []


def test_many_are_one_finding_of_a_kind(machine):
    square = "X10\nG3 X20 Y0 R-10\nG1 Y10\nG3 X10 Y20 R-10\nG1 X-20"
    assert [line for line, _ in list_doubts(machine, "rs274", square)] == [2]


@pytest.mark.parametrize("sample", sorted(SAMPLES.glob("*.toml")), ids=lambda one: one.stem)
def test_samples_are_in_no_doubt(run, sample: Path) -> None:
    assert "VP056" not in run("check", sample.with_suffix(""), "--limits-only").out


@pytest.mark.parametrize(
    ("dialect", "text", "lines"),
    [
        ("rs274", "G18\nX-10\nG3 X0 Y0 R10", [3]),
        ("rs274", "G18\nX-10\nG3 X0 Y0 R10\nG1 Y10\nG3 X-10 Y20 R10", [3]),  # once a plane
        ("rs274", "G19\nX-10\nG2 X0 Z30 R10", [3]),
        ("rs274", "X-10\nG2 X0 Z30 R10", [2]),  # G18 is forgotten
        ("rs274", "G18\n" + "".join(f"X{n}\n" for n in range(-19, 11)) + "G3 X20 Y0 R10", [32]),  # read as an array
        ("siemens", "G18\nX-10\nG3 X0 Y0 CR=10", [3]),
        ("rs274", "G18\nX-10\nG3 X0 Y0 Z20 R10", []),  # a helix that names its axes
        ("rs274", "G18\nX-10\nG3 X0 Y0 R5", []),  # half a turn ends beside its start
        ("rs274", "X-10\nG2 X0 Z15 R5\nX-10 Z10 R5", []),
        ("rs274", "G18\nX-10\nG3 X0 Z30 R10", []),
        # turns of a thread in quarters and thirds, some of whose chords are along an axis
        ("rs274", "X7.0711 Y7.0711\nG3 X-7.0711 Z29.5 R10\nY-7.0711 Z29 R10\nX7.0711 Z28.5 R10\nY7.0711 Z28 R10", []),
        ("rs274", "X0 Y10\nG3 X-8.6603 Y-5 Z29.5 R10\nX8.6603 Z29 R10\nX0 Y10 Z28.5 R10", []),
        ("rs274", "Y-9\nX-9\nG1 X-10 Y-10\nG3 X10 Z29 R14.1421\nG1 X11 Y-9", []),  # tangent to the cuts beside it
    ],
)
def test_an_arc_to_two_axes_of_another_plane_is_told(machine, dialect, text, lines):
    found = list_doubts(machine, dialect, text)
    assert [line for line, _message in found] == lines
    for _line, message in found:
        right = "G17" if "G18" in text else "G18"
        assert f"the axes of {right}" in message and f"write {right} before" in message
    if lines and "G18" in text:
        assert "G18 of line" in found[0][1]
        assert not list_doubts(machine, dialect, text.replace("G18", "G17"))


AXES = {
    "siemens": "X{0} Y{2} A3=0 B3={1} C3=.866",
    "aptcl": "GOTO/{0},{2},50,0,{1},.8660254",
}


@pytest.mark.parametrize(
    ("dialect", "signs", "doubtful"),
    [
        ("siemens", "++++-++++", [5]),
        ("siemens", "++++_++++", []),  # the other flank, and back
        ("aptcl", "++++i++++", []),  # the other side of a rib
        ("aptcl", "++++~++++", [5]),
        ("aptcl", "+z+zi+z+z", []),
        ("aptcl", "z+z+j+z+z", [5]),  # to and fro by 1 mm
        ("aptcl", "++++-++++", [5]),
        ("siemens", "++++++++", []),
        ("siemens", "++++----", []),  # the other wall
        ("siemens", "+-+-+-+-", []),  # to and fro
        ("siemens", "++++--++++", []),
        ("siemens", "+++-", []),  # nothing behind says that it is not meant
    ],
)
def test_a_tool_axis_with_a_wrong_sign(dialect: str, signs: str, doubtful: list[int]) -> None:
    """B3=-0.5 in one line was followed to the other side of the part and back."""
    values = {
        "+": (".5", 0),
        "-": ("-.5", 0),
        "_": ("-.5", -20),
        "i": ("-.5", -2),
        "~": ("-.5", -0.3),
        "z": (".5", -1),
        "j": ("-.5", -1),
    }
    lines = [AXES[dialect].format(at, *values[sign]) for at, sign in enumerate(signs)]
    first = "G1 F400" if dialect == "siemens" else "FEDRAT/400,MMPM"
    head = {
        "siemens": "G17 G54 G90 G94 G710\nT1 D1\nM6\nTRAORI\nG0 X-1 Y0 Z50 A3=0 B3=.5 C3=.866\nS900 M3",
        "aptcl": "UNITS/MM\nMULTAX/ON\nLOADTL/1\nSPINDL/900,RPM,CLW\nRAPID\nGOTO/-1,0,50,0,.5,.8660254",
    }[dialect]
    end = "M30" if dialect == "siemens" else "FINI"
    text = "\n".join([head, first, *lines, end])
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 4.0)}
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 40)}, tools=tools)
    found = [item for item in check(text.encode(), "hexapod", options).findings if item.code == "VP056"]
    begin = head.count("\n") + 2
    assert [item.line - begin for item in found] == doubtful
    assert all("is the other sign meant?" in item.message for item in found)


@pytest.mark.parametrize(
    ("dialect", "wrong", "said"),
    [
        ("fanuc", {}, None),
        ("fanuc", {20: -1.0}, "A-22.878 in this cut, and A22.878 and A22.878 in those before and after it: is A22.878"),
        ("fanuc", dict.fromkeys(range(20, 22), -1.0), None),  # two on the other side are no slip
        ("fanuc", dict.fromkeys(range(1, 40, 2), -1.0), None),  # to and fro
        ("siemens", {}, None),
        ("siemens", {20: -1.0}, "but for the sign of B3 (-0.3305): is the other sign meant?"),
    ],
)
def test_a_wrong_sign_where_the_tool_axis_turns_from_cut_to_cut(
    dialect: str, wrong: dict[int, float], said: str | None
) -> None:
    """A circle of which each line turns C by 4 degrees; with one wrong sign the tool swung by 45 degrees and back."""
    lines = list[str]()
    for at in range(1, 40):
        turn, sign = math.radians(4.0 * at), wrong.get(at, 1.0)
        words = {
            "fanuc": f"A{22.878 * sign:.3f} C{4.0 * at:.1f}",
            "siemens": f"A3={0.3356 * math.cos(turn):.4f} B3={sign * 0.3356 * math.sin(turn):.4f} C3=.942",
        }
        lines.append(f"X{15.0 * math.cos(turn):.3f} Y{15.0 * math.sin(turn):.3f} {words[dialect]}")
    head, end = {
        "fanuc": ("G21 G90 G17\nT1 M6\nS900 M3\nG43.4 H1 G0 X15. Y0. Z60. A22.878 C0.\nG1 Z5. F500.", "G0 Z60.\nM30"),
        "siemens": (
            "G17 G90 G94 G710\nG54\nT1 D1\nM6\nS900 M3\nTRAORI\nG0 X15 Y0 Z60 A3=.3356 B3=0 C3=.942\nG1 Z5 F500",
            "G0 Z60\nM30",
        ),
    }[dialect]
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 4.0)}
    options = Options(dialect=dialect, wcs={"G54": (0, 0, 40)}, tools=tools)
    findings = check("\n".join([head, *lines, end]).encode(), "ac_trunnion", options, limits_only=True).findings
    found = [(item.line, said is not None and said in item.message) for item in findings if item.code == "VP056"]
    assert found == ([] if said is None else [(head.count("\n") + 1 + 20, True)])


@pytest.mark.parametrize("machine", ["verne", "ac_trunnion"])
@pytest.mark.parametrize(
    ("beside", "x", "words", "is_told"),
    [
        (2.0, -2.0, "A-22.4 C90.", False),  # the other flank of a rib, and back
        (2.0, -2.0, "A22.4 C-90.", False),
        (2.0, 1.9, "A-22.4 C90.", True),
        (2.0, 1.9, "A22.4 C-90.", True),
        (0.8, 0.8, "A-22.4 C90.", True),  # to and fro by 1.2 mm
        (0.8, -2.0, "A-22.4 C90.", False),
    ],
)
def test_rotary_words_of_the_other_flank_are_in_no_doubt(
    machine: str, beside: float, x: float, words: str, is_told: bool
) -> None:
    """The edit of such a warning tilted the tool into the rib."""
    cuts = [f"X{(2.0, beside)[at % 2]} Y{at}. Z0. A22.4 C90." for at in range(7)]
    cuts[3] = f"X{x} Y3. Z0. {words}"
    text = "O1\nG21 G90 G17\nT1 M6\nS900 M3\nG43.4 H1 G0 X2. Y0. Z60. A22.4 C90.\nG1 Z5. F500.\n" + "\n".join(cuts)
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 4.0)}
    options = Options(dialect="fanuc", wcs={"G54": (0, 0, 40)}, tools=tools)
    findings = check(f"{text}\nG0 Z60.\nM30".encode(), machine, options, limits_only=True).findings
    assert [item.line for item in findings if item.code == "VP056"] == [10] * is_told
