"""Milled threads of Siemens programs: the table of the page, move by move, and the surface that the tool leaves."""

import math

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from verne_post.model.moves import MoveKind

HEAD = "T1 D1 M6\nG0 X10 Y20 Z40 S1000 M3 F300\n"


@pytest.fixture(scope="module")
def mill(view):
    def run(call, head=HEAD):
        return view(f"{head}{call}\nM30\n", dialect="siemens", tools={1: make_tool(1, 10.0, 8.0)})

    return run


def show(moves):
    """Kind, X, Y, Z, centre and sweep of each move after the first."""
    rows = []
    for row in range(1, len(moves)):
        x, y, z = (float(value) for value in np.round(moves.end[row, :3], 6) + 0.0)
        kind = "RLA"[(MoveKind.RAPID, MoveKind.FEED, MoveKind.ARC).index(moves.kind[row])]
        if kind != "A":
            rows.append((kind, x, y, z))
            continue
        center = (float(value) for value in np.round(moves.arcs.center[moves.arc[row], :2], 6) + 0.0)
        rows.append((kind, x, y, z, *center, round(float(moves.arcs.sweep[moves.arc[row]]), 6)))
    return rows


def test_cuts_worked_out_by_hand(mill):
    moves, findings = mill("CYCLE70(20,0,2,-5,20,1.2,0.2,2,1,0.6,500,0,10,20,90,11)")
    assert findings == ()

    def cut(radius):
        top, bottom = 20 + radius, 20 - radius
        return [
            ("L", 10, 20, 0.35),
            ("A", 10, top, 0, 10, 20 + radius / 2, -180),
            ("A", 10, top, -2, 10, 20, -360),
            ("A", 10, top, -4, 10, 20, -360),
            ("A", 10, bottom, -5, 10, 20, -180),
            ("A", 10, 20, -5.35, 10, 20 - radius / 2, -180),
            ("R", 10, 20, 2),
        ]

    assert show(moves) == [("R", 10, 20, 2), *cut(5.3), *cut(5.8), ("R", 10, 20, 20)]
    assert set(moves.feed[moves.kind == MoveKind.ARC]) == {500.0}


def test_an_outside_thread_worked_out_by_hand(mill):
    moves, findings = mill("CYCLE90(20,0,2,-4,,20,16,2,500,3,1,10,20)")
    assert findings == ()
    assert show(moves) == [
        ("R", 28, 20, 40),
        ("R", 28, 20, 2),
        ("L", 28, 20, 0.55),
        ("A", 22, 20, 0, 25, 20, -180),
        ("A", 22, 20, -2, 10, 20, 360),
        ("A", 22, 20, -4, 10, 20, 360),
        ("A", 28, 20, -4.55, 25, 20, -180),
        ("R", 28, 20, 2),
        ("R", 28, 20, 20),
    ]


@pytest.mark.parametrize("outside", [0, 1])
@pytest.mark.parametrize(("way", "hand"), [(1, 0), (2, 0), (1, 1), (2, 1)])
def test_the_hand_of_a_thread_and_its_length(mill, outside, way, hand):
    """Along the helix the angle over the height is one turn a pitch, right-hand where it grows upwards."""
    moves, findings = mill(f"CYCLE70(20,0,2,-7.5,24,1.5,0.1,2.5,1,0.5,500,{outside},10,20,33,{hand}{way}1)")
    assert findings == ()
    helix = (moves.kind == MoveKind.ARC) & (moves.arc >= 0)
    own = [row for row in np.flatnonzero(helix) if np.hypot(*(moves.arcs.center[moves.arc[row], :2] - (10, 20))) < 1e-9]
    assert len(own) == 3 * 3  # three cuts of three turns
    for row in own:
        rise = moves.end[row, 2] - moves.end[row - 1, 2]
        assert rise == pytest.approx(2.5 if way == 2 else -2.5)
        assert np.sign(moves.arcs.sweep[moves.arc[row]] * rise) == (-1 if hand else 1)
    radii = sorted({round(float(np.hypot(*(moves.end[row, :2] - (10, 20)))), 6) for row in own})
    cuts = [1.4 * share for share in (1 / 3, 2 / 3, 1)]
    expected = [12 - cut + 4 for cut in cuts] if outside else [12 - 1.5 + cut - 4 for cut in cuts]
    assert radii == pytest.approx(sorted(expected), abs=1e-6)
    heights = [moves.end[row, 2] for row in own] + [moves.end[row - 1, 2] for row in own]
    assert (min(heights), max(heights)) == pytest.approx((-7.5, 0.0), abs=1e-9)


@pytest.mark.parametrize("outside", [0, 1])
def test_nothing_is_touched_beyond_the_thread(mill, outside):
    """Samples of the path: the tool keeps off the wall of the finished thread, and off a bolt's blank where it is
    rapid.
    """
    moves, findings = mill(f"CYCLE70(20,0,2,-7,24,1.5,0,2,1,0.5,500,{outside},10,20,33,11)")
    assert findings == ()
    for row in range(1, len(moves)):
        begin, end = moves.end[row - 1, :3], moves.end[row, :3]
        if moves.kind[row] == MoveKind.ARC:
            center, sweep = moves.arcs.center[moves.arc[row], :2], math.radians(moves.arcs.sweep[moves.arc[row]])
            turn = math.atan2(*(begin[:2] - center)[::-1]) + np.linspace(0, 1, 181) * sweep
            places = center + np.hypot(*(begin[:2] - center)) * np.column_stack([np.cos(turn), np.sin(turn)])
        else:
            places = begin[:2] + np.linspace(0, 1, 50)[:, None] * (end - begin)[:2]
            if min(begin[2], end[2]) > 1:
                continue
        away = np.hypot(*(places - (10, 20)).T)
        if outside:
            assert away.min() >= 12 - 1.5 + 4 - 1e-9
            assert moves.kind[row] == MoveKind.ARC or away.min() >= 12 + 4 + 2 - 1e-9
        else:
            assert away.max() <= 12 - 4 + 1e-9
            assert moves.kind[row] == MoveKind.ARC or away.max() < 1e-9


def test_a_thread_from_the_bottom_up(mill):
    """DP above RFP: the same helix as CYCLE70 upwards; the tool goes through the hole, so rapid traverse ends
    at RTP.
    """
    up, findings = mill("CYCLE90(20,-6,0,0,,20,18.16,1.5,500,3,0,10,20)")
    assert findings == ()
    other, _ = mill("CYCLE70(20,0,20,-6,20,0.92,0,1.5,1,0,500,0,10,20,0,21)")
    assert show(up) == show(other)


def test_threads_of_a_pattern(mill):
    """At each place of MCALL as a call of its own there, in inches as in mm."""
    call = "CYCLE70(20,0,2,-5,20,1.2,0,2,1,0,500,0,{},{},0,11)"
    one, found = mill(f"MCALL {call.format('', '')}\nX30\nHOLES1(0,0,0,50,25,2)\nMCALL")
    assert found == ()
    two, found = mill("\n".join(f"G0 X{x} Y{y}\n{call.format(x, y)}" for x, y in ((30, 20), (50, 0), (75, 0))))
    assert found == ()
    assert show(one) == show(two)
    inch = "CYCLE70({},0,{},{},{},{},0,12.7,1,0,500,0,{},{},0,11,2)".format(
        *(x / 25.4 for x in (20, 2, -5, 20, 1.2, 10, 20))
    )
    moves, found = mill(f"G70\n{inch}")
    assert found == ()
    assert show(moves) == show(mill(call.format(10, 20))[0])


@pytest.mark.parametrize(
    ("call", "code", "part"),
    [
        ("CYCLE70(20,0,2,-5,8,0.6,0,1,1,0,500,0,0,0,0,11)", "VP007", "no room"),
        ("CYCLE70(20,0,2,-5,20,10,0,1,1,0,500,0,0,0,0,11)", "VP007", "H1"),
        ("CYCLE70(20,0,2,-5,20,0.6,0.6,1,1,0,500,0,0,0,0,11)", "VP007", "FAL"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,0,1,0,500,0,0,0,0,11)", "VP007", "PIT"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,0,0,500,0,0,0,0,11)", "VP002", "NT 0"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,2,0,500,0,0,0,0,11)", "VP002", "write NT 1"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,1,0,500,2,0,0,0,11)", "VP007", "TYPTH"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,1,0,500,0,0,0,0,31)", "VP002", "VARI"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,1,0,500,0,0,0,0,13)", "VP002", "VARI"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,1,0,500,0,0,0,0,211)", "VP002", "VARI"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,1,0,500,0,0,0,0,11,4)", "VP002", "_PITA"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,1,0,500,0,0,0,0,11,,,,,1)", "VP002", "_GMODE"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,1,0,500,0,0,0,0,11,,,,,,,12)", "VP002", "_AMODE"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,1,1,0,500,0,0,0,0,11,,,,,,,200001)", "VP002", "_AMODE"),
        ("CYCLE70(20,0,2,-5,20,0.6,0,0.00001,1,0,500,0,0,0,0,11)", "VP007", "turns"),
        ("CYCLE90(20,0,2,-5,,20,16,2,500,4,0,0,0)", "VP002", "CDIR"),
        ("CYCLE90(20,0,2,-5,,20,22,2,500,2,0,0,0)", "VP007", "KDIAM"),
        ("CYCLE90(20,0,2,-5,,20,0,2,500,2,1,0,0)", "VP007", "KDIAM"),
        ("CYCLE90(20,-5,2,0,,20,16,2,500,2,0,0,0)", "VP002", "SDIS"),
        ("CYCLE90(20,0,2,-5,,20,8,2,500,2,0,0,0)", "VP007", "no room"),
        ("CYCLE90(20,0,2,-5,,20,16,2,-1,2,0,0,0)", "VP009", "FFR"),
        ("MCALL CYCLE90(20,0,2,-5,,20,16,2,500,2,0,0,0)", "VP002", "CYCLE90"),
    ],
)
def test_mistakes_are_refused_before_the_first_move(mill, call, code, part):
    moves, findings = mill(call)
    assert [item.code for item in findings] == [code]
    assert part in findings[0].message
    assert len(moves) == 1
