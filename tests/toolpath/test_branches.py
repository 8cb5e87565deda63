"""Branches of the table against brute force over every sequence of branches, and what happens at the pole."""

import itertools
import math
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import verne_post
from verne_post import check, convert
from verne_post.app.assemble import assemble, build_interpreter_setup
from verne_post.config import list_machine_files
from verne_post.config.load import build_machine
from verne_post.gcode import interpret_program
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.toolpath.branches import plan_branches
from verne_post.toolpath.build import build_path
from verne_post.toolpath.evaluate import evaluate_pose

from ..builders import MACHINE, axis_of, axis_words, with_ranges

#: The part stands there on purpose: no warning.
AT_THE_CENTRE = {"G54": (0.0, 0.0, 0.0)}
HEAD = "G21 G90 G94 G17 F3000\n"
SERIAL = verne_post.load_machine("serial")


def program(body, machine=SERIAL, **options):
    return assemble(
        f"{HEAD}{body}\nM2\n".encode(), machine, Options(**{"tool_length": 50.0, "wcs": AT_THE_CENTRE, **options})
    )


def degrees(path):
    """Angles at both ends of every segment."""
    return np.degrees(np.stack([path.start[:, 3:], path.end[:, 3:]], axis=1))


def found(prog):
    return [(item.code, item.severity, item.line) for item in prog.findings]


# --- turns of more than half a turn ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "says"),
    [
        (
            "G0 X0 Y0 Z60 A20 C170\nG1 X1 C175\nX2 C179.5\nX3 C-176\nX4 C-170",
            "line 5: C turns by -355.5 deg, from 179.5 to -176, while the tip goes 1 mm",
        ),
        (
            "G0 X0 Y0 Z60 A20 C170\nG1 X1 C175\nX2 C179.5\nX3 C-176\nX4 C-170",
            "C184, 4.5 deg away, holds the same tool axis",
        ),
        (
            "G0 X0 Y0 Z60 A20 C-180\nG1 X1 C180\nG1 X2 C-180",
            "line 3: C turns by 360 deg, from -180 to 180, while the tip goes 1 mm, and the tilted tool sweeps around "
            "with it; C-180, 0 deg away, holds the same tool axis",
        ),
        ("G0 X0 Y0 Z60 A20 C0\nG1 C181", "while the tip goes 0 mm"),
        (
            "G0 X0 Y0 Z60 A0 C0\nG1 X1 A10 C-200",
            "C160, 160 deg away, holds the same tool axis, and turns hardly less: is another C meant?",
        ),
        ("G0 X0 Y0 Z60 A20 C0\nG1 X1 C180", None),
        ("G0 X0 Y0 Z60 A20 C170\nG1 X1 C179.5\nX3 C184", None),
        ("G0 X0 Y0 Z60 A20 C170\nG1 X1\nG0 Z90 C-170\nG1 Z60", None),  # a rapid
        ("G0 X0 Y0 Z60 A0 C170\nG1 X1 C-170", None),  # under a vertical tool C means nothing
        ("G0 X50 Y0 Z60 A20 C0\nG3 X50 Y0 I-50 J0 C360", None),  # the table goes round with the path
        ("G0 X50 Y0 Z60 A20 C0\nG3 X0 Y50 I-50 J0 C-280", "C turns by -280 deg"),
    ],
)
def test_a_feed_move_that_turns_the_table_by_more_than_half_a_turn(body, says):
    findings = [item for item in program(body).findings if item.code == "VP301"]
    assert [(item.code, item.severity) for item in findings] == ([("VP301", "warning")] if says else [])
    if says:
        assert says in f"line {findings[0].line}: {findings[0].message}"


def test_all_lines_that_turn_the_table_are_named_and_the_first_has_what_helps():
    (turn,) = program("G0 X0 Y0 Z60 A20 C-180\nG1 X1 C180\nG1 X2\nG1 X3 C-180").findings
    assert (turn.line, turn.lines, turn.count) == (3, (3, 5), 2)
    then = "then add -360 deg to C in the lines up to 4 too"
    assert str(turn).endswith("holds the same tool axis (lines 3 and 5, 2 moves)")
    assert turn.advice == f"Write C-180 in line 3; {then}. Check again: C of the other lines follows from it."


def test_a_great_circle_close_to_the_pole_is_the_same_finding():
    """It turns C by nearly half a turn within a millimetre; one that goes through the pole, or farther around, does
    not.
    """
    begin = f"G43.5\nG0 X0 Y0 Z60 {axis_words(5, 0)}\nG1 "
    close = program(f"{begin}X1 {axis_words(5, 179.8)}")
    assert found(close) == [("VP301", "warning", 4)]
    assert (
        "C turns by 179.8 deg, from 0 to 179.8, while the tip goes 1 mm: the tool axis passes close to the vertical"
        in close.findings[0].message
    )
    for turn in (180.0, 170.0):
        assert not found(program(f"{begin}X1 {axis_words(5, turn)}"))


KLARTEXT = """BEGIN PGM V MM
TOOL CALL 1 Z S8000 F600
M3
{on}
L X+0 Y+0 Z+50 FMAX
LN X+0 Y+0 Z+10 {0}
LN X+5 Y+0 Z+10 {1}
LN X+10 Y+0 Z+10 {0}
{words}M30
END PGM V MM
"""
WORDS = "L X+11 A+5 C+0 FMAX\n" + "".join(f"L X+{k} C{170 * (k % 2):+}\n" for k in range(11, 20))
SIEMENS = """G17 G90 G71 G54
TRAORI
{on}
G0 X0 Y0 Z50
G1 X0 Z10 F600 {0}
X5 {1}
X10 {0}
X15 {1}
X20 {0}
X25 {1}
X30 {0}
X35 {1}
X40 {0}
X45 {1}
M30
"""
VECTOR = "FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR"


@pytest.mark.parametrize(
    ("text", "on", "tilt", "turn", "count", "advice"),
    [
        (KLARTEXT, "M128", 5.7, 180, 2, "Write PATHCTRL VECTOR in FUNCTION TCPM, which stands in place of M128"),
        (KLARTEXT, "M128", 5.7, 130, 2, "Write PATHCTRL VECTOR in FUNCTION TCPM, which stands in place of M128"),
        (SIEMENS, "ORIMKS", 5.7, 180, 9, "Write ORIWKS, or ORIVECT"),
        (KLARTEXT, f"{VECTOR}; --orientation angles", 5.7, 130, 2, "Leave --orientation angles out"),
        (KLARTEXT, VECTOR, 5.7, 180, 0, ""),
        (SIEMENS, "ORIWKS", 5.7, 180, 0, ""),
        (KLARTEXT, "M128", 5.7, 110, 0, ""),
        (KLARTEXT, "M128", 2.9, 180, 0, ""),  # steps of a smooth path over the pole
        (KLARTEXT, "M128", 50.0, 180, 0, ""),  # the vectors themselves are as far apart
    ],
)
def test_tool_vectors_around_which_linear_axes_sweep_a_cone(text, on, tilt, turn, count, advice):
    """The words of A and C after them are meant."""
    names = ("TX", "TY", "TZ") if text is KLARTEXT else ("A3=", "B3=", "C3=")
    axes = [axis_of(math.radians(tilt), math.radians(c)) for c in (0.0, turn)]
    words = [" ".join(f"{n}{v:+.7f}" for n, v in zip(names, axis, strict=True)) for axis in axes]
    source = text.format(*words, on=on.partition(";")[0], words=WORDS).encode()
    options = Options(tool_length=80.0, wcs=AT_THE_CENTRE, tools={1: 80.0} if text is KLARTEXT else {})
    options = options.changed(orientation="angles" if "angles" in on else "auto")
    prog = assemble(source, verne_post.load_machine("ac_trunnion"), options)
    found = [item for item in prog.findings if item.code == "VP301"]
    assert [item.count for item in found] == [count] * bool(count)
    for item in found:
        assert f"C turns by -{turn} deg" in item.message or f"C turns by {turn} deg" in item.message
        assert item.advice.startswith(advice)


def test_the_senses_of_the_machine_hold_in_the_finding():
    text = (
        list_machine_files()["serial"]
        .read_text(encoding="utf-8")
        .replace('c_positive = "workpiece"', 'c_positive = "tool"')
    )
    machine = build_machine(text.encode(), "mine.toml")
    assert machine.columns[-1].factor < 0
    (finding,) = program("G0 X0 Y0 Z60 A20 C179.5\nG1 X3 C-176", machine, wcs={"G54": (0.0, 0.0, 0.0, 30.0)}).findings
    assert "C turns by -355.5 deg, from 179.5 to -176" in finding.message


# --- against brute force ----------------------------------------------------------------------------


def provisional(body):
    moves = interpret_program(
        f"{HEAD}{body}\nM2\n".encode(), build_interpreter_setup(SERIAL, Options(tool_length=50.0, wcs=AT_THE_CENTRE))
    )
    return build_path(moves, SERIAL.coordinates)


def random_body(rng):
    """Up to six moves between tilted and vertical axes, rapids among them."""
    lines = []
    for k in range(rng.integers(3, 6)):
        word = "G0" if rng.random() < 0.3 else "G1"
        tilt = 0.0 if rng.random() < 0.3 else rng.uniform(5, 60)
        lines.append(f"{word} X{10 * k} Y{rng.uniform(-9, 9):.3f} Z60 {axis_words(tilt, rng.uniform(-180, 180))}")
    return "G43.5\n" + "\n".join(lines)


def pair_on(flip, turns, pair):
    a, c = pair
    return (-a, c + math.pi + 2 * math.pi * turns) if flip else (a, c + 2 * math.pi * turns)


def legal_by(a_range):
    low, high = np.radians(a_range)

    def legal(segment, u, angles):
        return (angles[:, 0] >= low - 1e-9) & (angles[:, 0] <= high + 1e-9)

    return legal


def place_on_branches(path, a_range, c_range):
    """A function: the angles (5, 2) of a segment on a branch, and whether all are legal; found once for each."""
    (a0, a1), (c0, c1) = np.radians(a_range), np.radians(c_range)

    @cache
    def place(segment, flip, turns):
        _tip, angles = evaluate_pose(path, np.full(5, segment), np.linspace(0, 1, 5))
        on = np.array([pair_on(flip, turns, pair) for pair in angles])
        inside = (on[:, 0] > a0 - 1e-9) & (on[:, 0] < a1 + 1e-9) & (on[:, 1] > c0 - 1e-8) & (on[:, 1] < c1 + 1e-8)
        return on, bool(inside.all())

    return place


def cost_of(path, place, branches):
    """(illegal segments, fed rewinds, rewinds, turns in place, travel) of one branch for each tilted segment."""
    upright = (np.abs(path.start[:, 3:4]) < 1e-9) & (np.abs(path.end[:, 3:4]) < 1e-9)
    tilted = np.flatnonzero(~upright[:, 0]).tolist()
    total = [0, 0, 0, 0, 0.0]
    before, last = None, -1
    for segment, branch in zip(tilted, branches, strict=True):
        on, legal = place(segment, *branch)
        total[0] += not legal
        if before is not None:
            tilt, turn = np.abs(on[0] - before)
            if tilt + turn > 1e-8:
                total[4] += tilt + turn
                standing = segment == last + 1
                if standing and max(abs(on[0, 0]), abs(before[0])) < 1e-9:
                    total[3] += 1
                elif standing:
                    total[2] += 1
                    total[1] += bool(path.feed_time[segment] > 0 and path.feed_time[last] > 0)
        before, last = on[-1], segment
    return tuple(total[:4]), total[4]


def branch_at(path, plan, segment):
    """Which branch of the provisional angles the plan has chosen for a segment."""
    return next(
        (flip, turns)
        for flip, turns in itertools.product((0, 1), range(-4, 5))
        if np.allclose(pair_on(flip, turns, path.end[segment, 3:]), plan.end[segment], atol=1e-8)
    )


@pytest.mark.parametrize("a_range", [(-95, 95), (-95, 20), (-30, 40)])
@pytest.mark.parametrize("c_range", [(-360, 360), (-200, 200), (-1e9, 1e9)], ids=["360", "200", "unlimited"])
def test_no_sequence_of_branches_is_better(a_range, c_range):
    """Every branch of every tilted segment, tried one by one; sums of angles agree to their rounding."""
    rng = np.random.default_rng(int(c_range[1]) % 1000 + a_range[1])
    limited = c_range[1] < 1e6
    for _ in range(6):
        path = provisional(random_body(rng))
        plan = plan_branches(path, legal_by(a_range), tuple(np.radians(c_range)) if limited else (-math.inf, math.inf))
        states = [(flip, turns) for flip in (0, 1) for turns in (-1, 0, 1)]
        upright = (np.abs(path.start[:, 3]) < 1e-9) & (np.abs(path.end[:, 3]) < 1e-9)
        tilted = np.flatnonzero(~upright)
        if not 0 < len(tilted) <= 4:
            continue
        place = place_on_branches(path, a_range, c_range)
        every = [cost_of(path, place, some) for some in itertools.product(states, repeat=len(tilted))]
        chosen = [branch_at(path, plan, segment) for segment in tilted]
        counts, travel = cost_of(path, place, chosen)
        best = min(every)
        assert len(tilted) == 1 or max(every)[1] > 0.0  # the judge sees what happens between segments
        assert counts <= best[0]
        assert (counts[0] == 0) == plan.legal
        if counts == best[0] and not counts[2]:  # where a rewind happens is not chosen by its length
            assert travel <= best[1] + 1e-6


# --- the pole ------------------------------------------------------------------------------------


@pytest.mark.parametrize("word", ["G0", "G1"])
@pytest.mark.parametrize("off", [0.0, 1e-7, 5e-6])
def test_straight_through_the_pole_c_stands_still(word, off):
    """Exactly, and within what verification accepts: A goes through zero, C stays, the axis leaves the circle
    by less.
    """
    i = math.sqrt(0.25 - off**2)
    body = (
        f"G43.5 G0 X0 Y0 Z60 I-{i:.12f} J{off:.12f} K0.866025403784\n"
        f"{word} X20 I{i:.12f} J{off:.12f} K0.866025403784\n"
        f"X30 {axis_words(50, 90)}"
    )
    prog = program(body)
    assert found(prog) == []
    a, c = degrees(prog.path)[..., 0], degrees(prog.path)[..., 1]
    assert a[0, 0] * a[0, 1] < 0
    assert np.ptp(c) <= np.degrees(2 * off / 0.5) + 1e-9  # what the two azimuths differ by
    u = np.linspace(0, 1, 101)
    _tip, angles = evaluate_pose(prog.path, np.zeros(101, dtype=int), u)
    turned = math.pi / 3 * u - math.pi / 6  # from -30 to 30 degrees about y
    on_circle = np.stack([np.sin(turned), 0 * u, np.cos(turned)], axis=1)
    assert np.linalg.norm(axis_of(angles[:, 0], angles[:, 1]) - on_circle, axis=1).max() <= 1e-5 + off


def test_past_the_pole_the_axis_is_on_the_great_circle_and_c_turns():
    """A tenth of a degree beside it C must turn by nearly half a turn; nothing flips."""
    k0 = np.array([-0.5, 0.0017, 0.0]) + [0, 0, math.sqrt(0.75 - 0.0017**2)]
    body = f"G43.5 G0 X0 Y0 Z60 I{k0[0]:.12f} J{k0[1]} K{k0[2]:.12f}\nG1 X20 I{-k0[0]:.12f} J{k0[1]} K{k0[2]:.12f}"
    path = program(body).path
    assert path.circle[0] == 0
    u = np.linspace(0, 1, 501)
    _tip, angles = evaluate_pose(path, np.zeros(501, dtype=int), u)
    k1 = k0 * [-1, 1, 1]
    omega = math.acos(k0 @ k1)
    slerp = (np.sin((1 - u) * omega)[:, None] * k0 + np.sin(u * omega)[:, None] * k1) / math.sin(omega)
    assert np.abs(axis_of(angles[:, 0], angles[:, 1]) - slerp).max() < 1e-9
    assert (angles[:, 0] > 0).all()
    assert 170 < np.degrees(abs(angles[-1, 1] - angles[0, 1])) < 180


@pytest.mark.parametrize("word", ["G0", "G1"])
def test_a_corner_at_the_pole_turns_c_in_place_and_says_so(word):
    """There the tool stands, vertical: C goes to where the next move tilts, the tip keeps its place."""
    body = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 0)}\n{word} X20 {axis_words(0, 0)}\nX40 {axis_words(30, 60)}"
    prog = program(body)
    assert found(prog) == [("VP301", "warning", 4)]
    assert "C turns under the resting" in prog.findings[0].message
    assert "C 0.000 to A 0.000, C 60.000" in prog.findings[0].message
    path = prog.path
    assert degrees(path)[:, :, 1].tolist() == pytest.approx(np.array([[0, 0], [0, 60], [60, 60]]), abs=1e-9)
    np.testing.assert_array_equal(path.start[1, :3], path.end[1, :3])
    np.testing.assert_array_equal(path.start[1:], path.end[:-1])


def test_words_straight_through_the_pole_are_a_great_circle_as_they_are():
    source = b"G71 G90 F3000\nG0 X0 Y0 Z60 A8 C30\nTRAORI\nORIWKS\nG1 X1\nX20 A-9\nX30\nM30\n"
    path = assemble(source, SERIAL, Options(tool_length=50.0, wcs=AT_THE_CENTRE, dialect="siemens")).path
    assert degrees(path)[:, :, 0].tolist() == pytest.approx(np.array([[8, 8], [8, -9], [-9, -9]]), abs=1e-9)
    assert np.ptp(degrees(path)[:, :, 1]) == 0


def test_a_corner_straight_through_the_pole_needs_no_turn():
    prog = program(f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 0)}\nG1 X20 I0 J0 K1\nX40 {axis_words(30, 180)}")
    assert found(prog) == []
    assert degrees(prog.path).reshape(-1, 2) == pytest.approx(np.array([[30, 0], [0, 0], [0, 0], [-30, 0]]), abs=1e-9)


def test_noise_in_a_vector_turns_nothing():
    """C a hundred-millionth of a turn off at the pole goes into the next move; there is no finding."""
    prog = program(
        "G43.5 G0 X0 Y0 Z60 I0.0000000002 J0.5 K0.866025403784\nG0 X20 I0 J0 K1\nX40 I0 J0.5 K0.866025403784"
    )
    assert found(prog) == []
    assert len(prog.path) == 2
    np.testing.assert_array_equal(prog.path.start[1:], prog.path.end[:-1])


@pytest.mark.parametrize("words", ["A0 C10", "A20 C10", "A0 C0"])
@pytest.mark.parametrize("before", ["", "G1 X5 I0 J0.6 K0.8\nG1 X10 I0 J0 K1\n"], ids=["upright", "tilted before"])
def test_words_after_a_vertical_stretch_turn_the_table_in_their_own_rapid(before, words):
    """The stretch keeps its C; a rapid that leads nowhere new is no segment."""
    prog = program(f"G43.5 G0 X0 Y0 Z60 I0 J0 K1\n{before}G1 X20\nG43.4 G0 {words}\nG1 X30")
    assert found(prog) == []
    assert prog.path.length.min() > 0
    assert degrees(prog.path)[-1, 1] == pytest.approx([float(word[1:]) for word in words.split()], abs=1e-9)
    assert np.ptp(degrees(prog.path)[prog.path.free][..., 1]) == 0
    np.testing.assert_array_equal(prog.path.start[1:], prog.path.end[:-1])


def test_a_vertical_stretch_turns_over_its_rapids_only():
    up = "I0 J0 K1"
    body = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 0)}\nG1 X20 {up}\nX30\nG0 X40\nX50\nG1 X60\nX80 {axis_words(30, 60)}"
    prog = program(body)
    assert found(prog) == []
    c = degrees(prog.path)[:, :, 1]
    assert c == pytest.approx(np.array([[0, 0], [0, 0], [0, 30], [30, 60], [60, 60], [60, 60]]), abs=1e-9)
    np.testing.assert_array_equal(prog.path.start[1:], prog.path.end[:-1])


def test_a_vertical_stretch_without_rapids_turns_over_all_of_it():
    up = "I0 J0 K1"
    body = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 0)}\nG1 X20 {up}\nX30\nX60\nX80 {axis_words(30, 60)}"
    c = degrees(program(body).path)[:, :, 1]
    assert c == pytest.approx(np.array([[0, 0], [0, 15], [15, 60], [60, 60]]), abs=1e-9)


def test_a_vertical_tool_keeps_c_still():
    """Throughout, at the start, and at the end."""
    up = "I0 J0 K1"
    assert np.ptp(degrees(program(f"G43.5 G0 X0 Y0 Z60 {up}\nG1 X20\nG3 X40 I10 J0\nG0 Z80").path)[..., 1]) == 0
    body = f"G43.5 G0 X0 Y0 Z60 {up}\nG1 X20\nX40 {axis_words(30, 75)}\nX60 {up}\nG0 Z80\nG1 X0"
    prog = program(body)
    assert found(prog) == []
    assert degrees(prog.path)[..., 1] == pytest.approx(75.0, abs=1e-9)


# --- limits ---------------------------------------------------------------------------------------


def test_the_other_table_solution_where_the_tilt_needs_it():
    tilted = with_ranges(SERIAL, a=(-95, 20))
    prog = program(f"G43.5 G0 X0 Y0 Z60 I0 J0 K1\nG1 X20 {axis_words(30, 90)}\nX40\nG49 G0 A0 C0", tilted)
    assert found(prog) == [
        ("VP046", "warning", 5)
    ]  # the last rapid begins where the table stands, and swings the spindle
    assert prog.path.end[1, 3:] == pytest.approx(np.radians([-30.0, -90.0]), abs=1e-9)
    assert prog.path.end[-1, 3:] == pytest.approx([0.0, 0.0], abs=1e-12)
    np.testing.assert_array_equal(prog.path.start[1:], prog.path.end[:-1])


@pytest.mark.parametrize("machine", [SERIAL, with_ranges(SERIAL, c=(-360, 360))], ids=["unlimited", "360"])
def test_two_turns_go_from_end_to_end_of_the_range(machine):
    """A spiral of two turns fits into [-360, 360] only from one end; the plan must look ahead for it."""
    turns = "\n".join(f"X{k} {axis_words(20, 30 * k)}" for k in range(1, 24))
    prog = program(f"G43.5 G0 X0 Y0 Z60 {axis_words(20, 0)}\nG1 {turns}", machine)
    assert found(prog) == []
    c = degrees(prog.path)[..., 1]
    assert c[-1, 1] - c[0, 0] == pytest.approx(690.0)
    assert np.abs(c).max() <= 360.0 + 1e-9 or machine is SERIAL  # angles are rounded to 1e-12 rad
    assert check(
        f"{HEAD}G43.5 G0 X0 Y0 Z60 {axis_words(20, 0)}\nG1 {turns}\nM2\n".encode(),
        machine,
        Options(tool_length=50.0, wcs=AT_THE_CENTRE),
    ).ok


def test_three_turns_need_a_rewind():
    """Where the tool feeds it is an error; over a rapid one that --allow-rewind resolves, with both candidates
    named.
    """
    limited = with_ranges(SERIAL, c=(-360, 360))
    lines = [f"X{k} {axis_words(20, 30 * k)}" for k in range(1, 36)]
    fed = f"G43.5 G0 X0 Y0 Z60 {axis_words(20, 0)}\nG1 " + "\n".join(lines)
    prog = program(fed, limited, allow_rewind=True)
    assert {item[:2] for item in found(prog)} == {("VP301", "error")}
    assert "the tool feeds here" in prog.findings[0].message
    assert len(prog.findings) == 1

    lifted = f"G43.5 G0 X0 Y0 Z60 {axis_words(20, 0)}\nG1 " + "\n".join(
        [*lines[:18], "G0 Z90", "Z60", "G1 X19", *lines[18:]]
    )
    prog = program(lifted, limited)
    assert len(prog.findings) == 1
    assert prog.findings[0].severity == "error"
    assert "--allow-rewind" in prog.findings[0].message
    numbers = [float(x) for x in re.findall(r"[AC] (-?[\d.]+)", prog.findings[0].message)]
    assert len(numbers) == 4
    before, after = np.radians(numbers).reshape(2, 2)
    assert axis_of(*before) == pytest.approx(axis_of(*after), abs=1e-4)
    source = f"{HEAD}{lifted}\nM2\n".encode()
    result = convert(
        source, replace(limited, cycle=0.004), Options(tool_length=50.0, wcs=AT_THE_CENTRE, allow_rewind=True)
    )
    assert result.ok
    assert [(item.code, item.severity) for item in result.findings] == [("VP301", "warning")]


def test_findings_of_branches_reach_the_result():
    """A flip where the tool feeds is refused with the error of the planner, and nothing is written."""
    limited = with_ranges(MACHINE, c=(-200, 200))
    turns = "\n".join(f"X{10 * k} {axis_words(30, 90 * k)}" for k in range(1, 6))
    result = convert(
        f"{HEAD}G43.5 G0 X0 Y0 Z110 {axis_words(30, 0)}\nG1 {turns}\nM2\n".encode(),
        limited,
        Options(tool_length=80.0, wcs=AT_THE_CENTRE),
    )
    assert not result.ok
    assert result.exit_code == 1
    assert {item.code for item in result.findings} == {"VP301"}


# --- A and C words --------------------------------------------------------------------------------


def test_words_that_keep_the_limits_stay_as_they_are():
    for machine in (SERIAL, with_ranges(SERIAL, c=(-360, 360))):
        prog = program("G0 X0 Y0 Z60 A95 C360\nG1 X10 A-95\nG0 X20 C-360", machine)  # exactly at the limits
        assert found(prog) == []
        assert degrees(prog.path)[:, 1] == pytest.approx(np.array([[-95, 360], [-95, -360]]), abs=1e-9)


def test_words_beyond_a_limit_are_an_error_that_allow_rewind_resolves():
    limited = with_ranges(SERIAL, c=(-360, 360))
    body = "G0 X0 Y0 Z60 A20 C300\nG1 X10 C350\nG0 Z90\nC400\nG1 X30 C500"
    source = f"{HEAD}{body}\nM2\n".encode()
    refused = check(source, limited, Options(tool_length=50.0, wcs=AT_THE_CENTRE))
    (beyond,) = refused.findings  # where the words are beyond: not where the table would turn already
    assert (beyond.code, beyond.line) == ("VP103", 5)
    assert "allow_rewind brings the program within limits" in beyond.remedies
    rewound = convert(
        source, replace(limited, cycle=0.004), Options(tool_length=50.0, wcs=AT_THE_CENTRE, allow_rewind=True)
    )
    assert rewound.ok
    assert rewound.setpoints is not None
    assert np.abs(rewound.setpoints.values[:, 4]).max() <= 360.0
    assert rewound.setpoints.values[-1, 4] % 360 == pytest.approx(
        500.0 % 360 if rewound.setpoints.values[-1, 3] > 0 else (500.0 + 180) % 360
    )


def test_a_turn_of_words_at_the_pole_is_not_made_without_leave():
    """Words under a vertical tool that leave the range are refused, not turned back in silence."""
    limited = with_ranges(SERIAL, c=(-360, 360))
    result = check(
        f"{HEAD}G0 X0 Y0 Z60 A0 C300\nG1 X10 C350\nG0 X20\nC400\nG1 X30\nM2\n".encode(),
        limited,
        Options(tool_length=50.0, wcs=AT_THE_CENTRE),
    )
    assert not result.ok
    assert all(item.severity == "error" for item in result.findings)


def test_words_and_vectors_meet_where_both_stand():
    """From words to vectors and back without a turn of the table where the axes are the same."""
    body = (
        "G43.4 G0 X0 Y0 Z60 A-30 C20\n"
        "G1 X10\n"
        f"G43.5 G1 X20 {axis_words(-30, 20)}\n"
        f"X30 {axis_words(-40, 20)}\n"
        "G43.4 G1 X40 A-20 C20"
    )
    prog = program(body)
    assert found(prog) == []
    a = degrees(prog.path)[:, :, 0]
    assert a == pytest.approx(np.array([[-30, -30], [-30, -30], [-30, -40], [-40, -20]]), abs=1e-8)
    assert np.ptp(degrees(prog.path)[..., 1]) < 1e-8


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (f"G43.5 G0 X0 Y0 Z60 {axis_words(60, 0)}\nG1 X10 {axis_words(-120, 0)}", "opposite"),
        ("G43.5 G0 X0 Y0 Z600 I0 J0 K1\nG1 X10 I0 J0 K-1", "opposite"),
    ],
)
def test_opposite_axes_have_no_great_circle(body, words):
    with pytest.raises(InputError, match=words):
        program(body)


@pytest.mark.parametrize(
    ("word", "says"),
    [
        (
            "C=30",
            "at C 45.000, from which the tool axes after it can be followed. Line 2 leaves the table at C 30.000.",
        ),
        ("C=45", ""),
        ("C=45.0004", ""),  # the message names three decimals: who writes those was told the same again
        ("C=45.001", "begins at C 45.000"),
    ],
)
def test_a_c_word_that_a_vertical_vector_leaves_is_told(word, says):
    """The rows began at C 45, which the first tilted axis asks for, and nothing said that C 30 was not kept."""
    source = (
        f"G17 G54 G90 G94 G71\nG0 A=0 {word}\nT1 D1 M6\nS5000 M3\nTRAORI\nG0 X0 Y0 Z40 A3=0 B3=0 C3=1\n"
        "G1 F1000 X10 A3=0.1 B3=0.1 C3=0.98\nX20\nG0 Z80\nTRAFOOF\nM30\n"
    )
    options = Options(tool_length=80.0, wcs={"G54": (0, 0, 60)}, dialect="siemens", split_at_stops=True)
    result = convert(source, "verne", options)
    assert [(item.code, item.severity, item.line) for item in result.findings] == [("VP301", "warning", 7)] * bool(says)
    assert says in "".join(item.message for item in result.findings)
    assert result.setpoints.values[0][-1] == pytest.approx(45.0)  # the message is true


def test_a_path_begins_within_half_a_turn_of_the_c_that_words_have_named():
    """C0 is named; the first vector asks for C60. CYCLE800 turns to C360, which is nearer to C420."""
    source = (
        "G17 G54 G90 G94 G710\nT1 D1 M6\nS1000 M3\nG0 X0 Y0 Z50 A0 C{}\nF500\nTRAORI\nMIRROR X0\nROT Z30\n"
        "G1 X10 A3=0.1 B3=0 C3=1\nAMIRROR X0\nG1 X10 A3=0.1 B3=0 C3=1\nTRANS\n"
        'CYCLE800(0,"",0,57,0,0,0,20,0,0,0,0,0,-1)\nAROT X-20\nG1 X0 Y0 Z50 A3=0 B3=0 C3=1\nTRANS\nCYCLE800()\nM30\n'
    )
    for word, begin in ((0, 60), (360, 420), (-170, -120)):
        options = Options(tool_length=100.0, wcs={"G54": (0, 0, 60)}, dialect="siemens")
        path = assemble(source.format(word).encode(), SERIAL, options).path
        assert degrees(path)[0, 0, 1] == pytest.approx(begin), word


ORIWKS = (
    "G17 G90 G71 G54 G94\nT1 M6\nD1 S9000 M3\nSUPA G0 A0 C0\nTRAORI\nORIWKS\nG0 X0 Y0 Z40 A=0 C={}\n"
    "G1 Z5 A=3.2 C=12.5 F800\nX5 A=5 C=14\nG0 Z40\nTRAFOOF\n"
    'CYCLE800(4,"TC1",200000,57,0,0,0,0,20,30,0,0,0,-1,100,1)\n'
    "G0 X0 Y0\nG1 Z5\nG0 Z50\nCYCLE800()\nM30\n"
)


@pytest.mark.parametrize("flip", [1, -1])
def test_words_along_great_circles_name_their_branch_too(flip):
    """A plane that was reached from the other side by less turns moved the line before it to A -3.2, C -167.5."""
    other = ORIWKS.replace("A=3.2 C=12.5", "A=-3.2 C=192.5").replace("A=5 C=14", "A=-5 C=194")
    source = (ORIWKS if flip == 1 else other).format(0)
    options = Options(tool_length=80.0, wcs={"G54": (0, 0, 60)}, dialect="siemens")
    prog = assemble(source.encode(), MACHINE, options)
    ends = {int(line): pair for line, pair in zip(prog.path.line, degrees(prog.path)[:, 1], strict=True)}
    assert ends[8] == pytest.approx([flip * 3.2, 12.5 if flip == 1 else 192.5], abs=1e-6)
    assert ends[9] == pytest.approx([flip * 5.0, 14.0 if flip == 1 else 194.0], abs=1e-6)


def test_the_line_that_settles_the_start_is_named():
    """The message named line 4, and C 12.5 written there was told the same: line 7 names C again."""
    options = Options(tool_length=80.0, wcs={"G54": (0, 0, 60)}, dialect="siemens")
    (item,) = assemble(ORIWKS.format(0).encode(), MACHINE, options).findings
    assert (item.code, item.line) == ("VP301", 8)
    assert "Name C 12.500 in line 7" in item.message
    assert not assemble(ORIWKS.format(12.5).encode(), MACHINE, options).findings


def test_words_of_a_vertical_rapid_turn_c_before_a_great_circle():
    """The path begins at the C where the table stands: nothing is left to tell."""
    source = ORIWKS.format(0).replace("SUPA G0 A0 C0", "SUPA G0 A0 C0\nSUPA G0 X0 Y0 Z0 D0\nD1")
    options = Options(tool_length=80.0, wcs={"G54": (0, 0, 60)}, dialect="siemens")
    prog = assemble(source.replace("X0 Y0 Z40", "X9 Y9 Z40").encode(), MACHINE, options)
    assert not prog.findings
    assert degrees(prog.path)[0, 0, 1] == pytest.approx(0.0)


def test_the_shorter_turn_is_named_with_the_lines_that_follow_it():
    """C365 alone moved the warning to the next line."""
    body = "G0 X0 Y0 Z60 A20 C190\nG1 X1 C191\nX11 C{}\nX21 C{}\nX31 A0 C0"
    (item,) = program(body.format(5, 0)).findings
    assert item.message.endswith(
        "C365, 174 deg away, holds the same tool axis, and turns hardly less: is another C meant?"
    )
    near = "G0 X0 Y0 Z60 A20 C349\nG1 X1 C350\nX11 C{}\nX21 C{}\nX31 A0 C0"
    (item,) = program(near.format(5, 0)).findings
    assert item.advice == "Write C365 in line 4; then add 360 deg to C in the lines up to 6 too."
    assert found(program(body.format(365, 0))) == [("VP301", "warning", 5)]
    assert not program(body.format(365, 360).replace("A0 C0", "A0 C360")).findings


def test_each_wrap_of_a_post_needs_its_own_turn():
    """The lines up to the second wrap: what follows it needs two turns."""
    body = "G0 X0 Y0 Z60 A20 C350\nG1 X1 C{}\nX2 C{}\nX3 C{}\nX4 C{}\nX5 C{}"
    (item,) = program(body.format(5, 150, 300, 350, 5)).findings
    assert item.line == 3
    assert item.message.endswith("C365, 15 deg away, holds the same tool axis")
    assert "then add 360 deg to C in the lines up to 6 too" in (item.advice or "")
    assert found(program(body.format(365, 510, 660, 710, 5))) == [("VP301", "warning", 7)]
    assert not program(body.format(365, 510, 660, 710, 725)).findings


def test_a_turn_begins_at_0_where_the_program_has_0(machine) -> None:
    """C0 was told as C-1.54614e-11, which radians had left of it."""
    program = b"G21 G90\nG0 X0 Y0 Z60 A20 C0\nG1 C7200 F3000\nM2\n"
    found = check(program, machine, Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 50.0)})).findings
    [turn] = [item for item in found if item.code == "VP301"]
    assert turn.message.startswith("C turns by 7200 deg, from 0 to 7200, while the tip goes 0 mm")
    assert "; C0, 0 deg away, holds" in turn.message
