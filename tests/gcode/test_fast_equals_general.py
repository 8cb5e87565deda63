"""The vectorised path for plain lines against the general interpreter: the same moves to the last bit, same errors."""

from math import cos, sin
from unittest.mock import patch

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from verne_post.app.assemble import build_interpreter_setup, view_moves_plainly
from verne_post.gcode import interpret_program, plain
from verne_post.model.findings import InputError
from verne_post.model.moves import ZERO9
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

SETTINGS = settings(max_examples=60, deadline=None, database=None, derandomize=True)
COLUMNS = ("line", "kind", "end", "feed", "feed_mode", "spindle", "frame", "control", "arc", "start", "tool_axis")
TOOLS = {1: Tool(1, 1, (0.0, 0.0, 60.0, *ZERO9[3:]))}


def snapshot(moves):
    """Everything of a Moves table as comparable values; bytes tell -0.0 from 0.0 and find NaN equal to itself."""
    arcs = tuple(getattr(moves.arcs, name).tobytes() for name in ("plane", "center", "turns", "sweep"))
    columns = tuple((getattr(moves, name).dtype.str, getattr(moves, name).tobytes()) for name in COLUMNS)
    return columns, arcs, moves.frames, moves.controls, moves.events, moves.start_frame


def as_interpreter(source, **options):
    moves, findings = view_moves_plainly(source, Options(tools=TOOLS, **options))
    return snapshot(moves), findings


def as_machine(source, machine, **options):
    try:
        return snapshot(interpret_program(source, build_interpreter_setup(machine, Options(tools=TOOLS, **options))))
    except InputError as error:
        return error.findings


def fast_and_general(run, *arguments, **options):
    """The same interpretation three times: fast wherever possible, as it comes, and never fast."""
    answers = []
    for least in (1, plain.MIN_LINES, 1 << 40):
        with patch.object(plain, "MIN_LINES", least):
            answers.append(run(*arguments, **options))
    return answers


# --- generated programs -------------------------------------------------------------------------

numbers = st.one_of(
    st.integers(-300, 300).map(str),
    st.decimals(-300, 300, places=3).map(str),
    st.sampled_from([".5", "-.25", "7.", "+3", "0", "-0", "- 1 2", "0.1234567890123456789", "1e", "1.2.3"]),
)
good_numbers = numbers.filter(lambda text: text not in ("1e", "1.2.3"))
axis_words = st.lists(st.sampled_from("XYZAC"), min_size=1, max_size=5, unique=True).flatmap(
    lambda letters: st.tuples(*(good_numbers.map(letter.__add__) for letter in letters)).map(" ".join)
)
feeds = st.sampled_from(["", "", "", " F100", " F33.3", " F0", "F 1 2 . 5"])


def plain_line():
    """A line that the fast path takes in a suitable state."""
    return st.builds(
        "{}{}{}{}{}".format,
        st.sampled_from(["", "", "N10 ", "N0.5"]),
        st.sampled_from(["", "", "", "G0 ", "G1 ", "g01", "G00"]),
        axis_words,
        feeds,
        st.sampled_from(["", "", "", "(c)", " ; c", "(a)(b)", " (MSG,m)", "(X1)", "(c)Z4"]),
    )


general_line = st.one_of(
    st.sampled_from([
        "G20", "G21", "G93", "G94 F200", "G95 F.1", "G90", "G91", "G91 X1 Y2", "G90 G0", "G90", "G90",
        "G92 X1", "G92.1", "G92.2", "G92.3", "G10 L2 P1 X5 Y-3", "G10 L2 P1 R30", "G10 L20 P1 Z7", "G54",
        "G55", "F300", "F0", "N7", "N8 F250", "G0", "G1", "(a comment)", "X1 (MSG, here)", "; remark", "",
        "  \t", "G2 I5", "G3 X10 R40 Z2", "G4 P.5", "M3 S500", "M5", "G61", "G64 P.01", "G43 H1", "G49",
        "G43.1 Z30", "G53 G0 Z0", "G28 G91 Z0", "G80", "/X3", "S100", "T1", "G0 X1 G21", "G17", "G18 Z1",
        "N1 N2",
    ]),
    st.builds("{}{}".format, st.sampled_from("XGNFQBUL"), numbers),
    st.builds("{} {}".format, axis_words, axis_words),
)  # fmt: skip


@st.composite
def programs(draw):
    """Stretches of plain lines, some long enough for the fast path, with general lines between them."""
    lines = draw(
        st.sampled_from(
            [
                ["G0 X0 Y0 Z200 A0 C0", "G49 G1 F500"],
                ["G1 F500", "G43 H1"],
                ["G0 X0 Y0"],
                ["G28 G91 Z0", "G90 G0", "F50"],
                [],
            ]
        )
    )[:]
    for _ in range(draw(st.integers(1, 4))):
        lines += draw(st.lists(plain_line(), min_size=0, max_size=12))
        lines += draw(st.lists(general_line, min_size=0, max_size=2))
    lines += draw(st.sampled_from([["M2"], ["M30", "X1"], []]))
    return "\n".join(lines).encode()


@SETTINGS
@given(programs())
def test_generated_programs_as_an_interpreter(source):
    fast, usual, general = fast_and_general(as_interpreter, source)
    assert fast == general
    assert usual == general


@SETTINGS
@given(programs(), st.sampled_from([None, 60.0]))
def test_generated_programs_on_the_machine(machine, source, length):
    fast, usual, general = fast_and_general(as_machine, source, machine, tool_length=length)
    assert fast == general
    assert usual == general


def arc_words(draw, here, there, plane, wrong):
    """Words of an arc between two points of a plane, by its centre or its radius."""
    u, v, normal = {0: ("X", "Y", "Z"), 1: ("Z", "X", "Y"), 2: ("Y", "Z", "X")}[plane]
    ends = f"{u}{there[0]} {v}{there[1]}"
    ends = draw(st.sampled_from([ends, ends, f"{ends} {normal}7", f"{ends} A3 C{draw(st.integers(-9, 9))}"]))
    first, second = ({"X": "I", "Y": "J", "Z": "K"}[letter] for letter in (u, v))
    half = [(b - a) / 2 for a, b in zip(here, there, strict=True)]
    lean = draw(st.sampled_from([0, 0, 0.5, -3, 1e-4]))
    center = f"{first}{half[0] - lean * half[1]:.9f} {second}{half[1] + lean * half[0]:.9f}"
    chord = 2 * (half[0] ** 2 + half[1] ** 2) ** 0.5
    radius = f"R{draw(st.sampled_from([-1, 1])) * chord * draw(st.sampled_from([0.5, 0.500001, 0.7, 4])):.9f}"
    if wrong:
        return draw(
            st.sampled_from(
                [f"{ends} {center} {radius}", ends, f"{ends} R0", f"{ends} R1", f"{ends} {first}2", f"R{chord}"]
            )
        )
    return f"{ends} {draw(st.sampled_from([center, radius]))}"


@st.composite
def arc_programs(draw):
    """Arcs and lines in one plane, in states that allow arcs and in others; in some words of arcs where they mean
    nothing.
    """
    plane, wrong = draw(st.integers(0, 2)), draw(st.sampled_from([0, 0, 1]))
    u, v, letter = {0: "XYI", 1: "ZXK", 2: "YZJ"}[plane]
    lines, here, straight = [f"G{17 + plane} G49 F300", "G0 X0 Y0 Z0 A0 C0"], (0, 0), True
    others = [["G90.1", "G91.1"], ["G93", "G94 F100"], ["#1=2"], ["M8"], [f"{letter}1"]]
    others += [["G20"], ["G18"], ["G0 I5"], ["G41.1 D1", "G40"], ["P2"], ["G90.1"]] * wrong
    for _ in range(draw(st.integers(4, 24))):
        there = (here[0] + draw(st.sampled_from([-7.5, 2, 4, 31])), draw(st.sampled_from([0, 0, 5, -7.25])))
        code = draw(st.sampled_from(["G2 ", "G3 ", "G2 ", "g03 F50", "N5 G2 ", "", "", "G1 "]))
        straight = code == "G1 " or (straight and not code)
        odd = wrong and draw(st.integers(0, 9)) == 0
        lines.append(code + (f"{u}{there[0]} {v}{there[1]}" if straight else arc_words(draw, here, there, plane, odd)))
        here = there
        more = draw(st.sampled_from([[]] * 30 + others))
        lines += [] if straight and letter in more[:1] else more
    return "\n".join([*lines, "M2"]).encode()


@settings(SETTINGS, max_examples=120)
@given(arc_programs())
def test_generated_arcs_as_an_interpreter(source):
    fast, usual, general = fast_and_general(as_interpreter, source)
    assert fast == general
    assert usual == general


@settings(SETTINGS, max_examples=50)
@given(arc_programs())
def test_generated_arcs_on_the_machine(machine, source):
    fast, usual, general = fast_and_general(as_machine, source, machine, tool_length=60.0)
    assert fast == general
    assert usual == general


def unit_vector(draw):
    """I J K of a tool axis, upright ones and such a hair beside the pole among them."""
    tilt = draw(st.sampled_from([0.0, 1e-9, 0.2, 0.5, 1.0, -0.3, 3.0]))
    turn = draw(st.sampled_from([0.0, 0.1, 1.5, 3.0, -2.0, 3.14159]))
    vector = sin(tilt) * cos(turn), sin(tilt) * sin(turn), cos(tilt)
    return " ".join(f"{letter}{value:.6f}" for letter, value in zip("IJK", vector, strict=True))


@st.composite
def vector_programs(draw):
    """Straight moves with tool axes, lines without or with wrong ones among them, and states in which I J K mean
    something else.
    """
    start = draw(
        st.sampled_from(
            [["G49"], ["G10 L2 P1 X5 R30", "G49"], ["G10 L2 P1 A3 C-20", "G49"], ["G68.2 X0 Y0 Z0 I0 J30 K0", "G53.1"]]
        )
    )
    lines = [
        "G17 G49 F300",
        draw(st.sampled_from(["G0 X0 Y0 Z0 A0 C0", "G0 X0 Y0 Z0 A0 C0", "G0 X0 Y0"])),
        *start,
        draw(st.sampled_from(["G43.5", "G43.5 H1", "G43.5 H1 G20", "G43.4"])),
    ]
    others = [
        "G0 X1",
        "G1 X2 F99",
        "X3 Y1",
        "G91 X1",
        "G90",
        "G93",
        "G94 F100",
        "M8",
        "G2 X5 I2",
        "G3 R9 X0",
        "G43.4",
        "G43.5",
        "A5 C5",
        "X1 I1",
        "X1 I0 J0 K1.1",
        "X1 I0 J0 K1 R2",
        "C3 I0 J0 K1",
        "G20",
        "G21",
        "G55",
        "F0",
        "G53 G0 Z0",
        "G28 Z0",
        "Q1",
    ]
    for _ in range(draw(st.integers(2, 30))):
        place = draw(st.sampled_from(["", "X1", "X2.5 Y-3", "Z4", "X-7 Y1 Z2"]))
        code = draw(st.sampled_from(["", "", "", "", "", "G1 ", "G0 ", "N7 ", "N8 G1 "]))
        lines.append(f"{code}{place} {unit_vector(draw)}{draw(feeds)}")
        lines += [draw(st.sampled_from(others))] if draw(st.integers(0, 5)) == 0 else []
    return "\n".join([*lines, "M2"]).encode()


@settings(SETTINGS, max_examples=100)
@given(vector_programs())
@example(b"G17 G49 F300\nG0 X0 Y0\nG49\nG43.5\n I0 J0 K1\nG1 X2 F99\n I0.198669 J0 K0.980067\nG2 X5 I2\nM2")
def test_generated_vectors(machine, source):
    for answers in (
        fast_and_general(as_interpreter, source),
        fast_and_general(as_machine, source, machine, tool_length=60.0),
    ):
        assert answers[0] == answers[1] == answers[2]


# --- states in which the fast path may not be fast ------------------------------------------------

PLAIN = "X1 Y2 Z3 F100\nX2\nY3 F200\nN5 Z4\nG0 X0\nG1 X.1\nA10 C20\nF50\nX7 Y8\nX3\nG0\nX4\nG1\nC30\n"


@pytest.mark.parametrize("head", [
    "", "G0", "G1", "G1 F100", "G1 F100 G20", "G91 G1 F10", "G93 G1", "G93 G0", "G95 F1 G0",
    "S100 M3 G95 F1 G1", "G2", "G80", "G0 X0 Y0 Z0 A30 C0\nG43 H1", "G92 X5", "G10 L2 P1 X5 R45", "G55",
    "G1 F100\nG61", "G28", "G53 G0 Z0", "G49 G0 X0 Y0 Z0 A0 C0", "G49 G0 X0", "G49 G20 G0 X0 Y0 Z0",
    "G0 X0 Y0 Z5 A0 C0 G49",
])  # fmt: skip
@pytest.mark.parametrize(
    "tail",
    [
        "M2",
        "X1 X2\nQ5\nM2",
        "X1 F-1\nX1 N5\nN-1 X2\nX3 F0\nX4\nM2",
        "G0 X200000\nX1\nC200000\nX2\nM2",
        "",
    ],
)
def test_states(machine, head, tail):
    source = f"{head}\n{PLAIN * 3}G93\n{PLAIN}G94 G90 F10\n{PLAIN}{tail}".encode()
    for answers in (fast_and_general(as_interpreter, source), fast_and_general(as_machine, source, machine)):
        assert answers[0] == answers[1] == answers[2]


@pytest.mark.parametrize("word", ["G43 H1", "G55", "G64 P.1"])
@pytest.mark.parametrize("idle", ["\n", "F100\n", "N5\n"])
def test_stretches_without_motion_leave_no_trace(word, idle):
    source = f"G0 X1\n{word}\n{idle * 20}G49 G54 G64 G0 X2\nM2".encode()
    fast, usual, general = fast_and_general(as_interpreter, source)
    assert fast == usual == general
    assert view_moves_plainly(source, Options(tools=TOOLS))[0].frame.tolist() == [0, 0]


@pytest.mark.parametrize(
    "source",
    [
        # axes that keep their programmed values after a change of length
        "G0 X0 Y0 Z100 A30 C0\nX1\nG43 H1\n" + "Y1\n" * 20 + "G1 F9\n" + "Y2\n" * 20,
        # a rotary feed is never scaled, also when it was last given in a stretch
        "G49 G20 G0 X0 Y0 Z4 A0 C0\nG1 F1 X1\n" + "X2 F3\n" * 20 + "G17 A5\n" + "A6\n" * 20,
    ],
)
def test_what_stretches_inherit_and_change(machine, source):
    for answers in (
        fast_and_general(as_interpreter, f"{source}M2".encode()),
        fast_and_general(as_machine, f"{source}M2".encode(), machine),
    ):
        assert answers[0] == answers[1] == answers[2]
        assert isinstance(answers[0][0], tuple)  # moves, not findings


def test_the_fast_path_is_really_taken(monkeypatch):
    """Guards the tests above: they would hold as well if nothing ever were fast."""
    taken = []
    execute = plain.execute

    def watched(lines, first, last, *rest):
        done = execute(lines, first, last, *rest)
        taken.append(done - first)
        return done

    monkeypatch.setattr(plain, "execute", watched)
    moves, findings = view_moves_plainly(("G1 F100\n" + PLAIN * 3 + "M2").encode(), Options())
    assert findings == ()
    assert sum(taken) == 1 + 3 * PLAIN.count("\n")  # the first line says G1
    assert len(moves) == 1 + 3 * (PLAIN.count("\n") - 1)  # F50 alone is no move


def test_lines_that_are_refused_one_after_the_other_are_not_all_looked_at_again_and_again(monkeypatch):
    """Each attempt at a long stretch of errors looks at a few lines; it was all that were left, quadratic in their
    number.
    """
    looked = []
    execute = plain._execute

    def watched(lines, first, last, *rest):
        looked.append(last - first)
        return execute(lines, first, last, *rest)

    monkeypatch.setattr(plain, "_execute", watched)
    arcs = "".join(f"G2 X{number % 50} Y{number % 7} I3\n" for number in range(4000))
    _moves, findings = view_moves_plainly(f"G21 G90 F100\nG0 X0 Y0 Z0 A0 C0\n{arcs}M2".encode(), Options())
    assert {finding.code for finding in findings} == {"VP008"}
    assert sum(looked) < 4000 * plain._HEAD + plain._LONG_STRETCH**2
