"""Cycles of Klartext: heights, feeds and places of every move, worked out by hand from what the parameters mean."""

import math

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode import interpret_program
from verne_post.model.moves import MoveKind, PathMode
from verne_post.model.options import Options

HEAD = ["BEGIN PGM C MM", "TOOL CALL 1 Z S1000 F300", "L X+4 Y+5 Z+40 R0 F100 M3"]


@pytest.fixture(scope="module")
def run(view):
    def interpret(*statements):
        text = "\n".join([*HEAD, *statements, "END PGM C"])
        moves, findings = view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, 6.0)})
        assert findings == ()
        return moves

    return interpret


def heights(moves):
    """Z and feed (0 for rapid traverse, None for a dwell) of every move after the head that moves Z."""
    shown, z = [], 40.0
    for kind, end, feed in zip(moves.kind[1:], moves.end[1:, 2], moves.feed[1:], strict=True):
        if kind == MoveKind.DWELL:
            shown.append(("dwell", feed))
        elif abs(end - z) > 1e-9:
            shown.append((round(float(end), 6), 0.0 if kind == MoveKind.RAPID else round(float(feed), 6)))
            z = end
    return shown


@pytest.mark.parametrize(
    ("cycle", "wanted"),
    [
        (
            "200 DRILL Q200=2 Q201=-10 Q206=150 Q202=4 Q210=0.5 Q203=1 Q204=20 Q211=0.25",
            [(3, 0), (-3, 150), (3, 0), ("dwell", 0.5), (-1, 0), (-7, 150), (3, 0), ("dwell", 0.5), (-5, 0), (-9, 150),
             ("dwell", 0.25), (3, 0), (21, 0)],
        ),
        ("200 DRILL Q200=2 Q201=-10 Q206=150 Q202=10 Q210=0 Q203=0 Q204=2 Q211=0", [(2, 0), (-10, 150), (2, 0)]),
        ("201 REAM Q200=2 Q201=-10 Q206=150 Q211=0.5 Q208=0 Q203=0 Q204=5",
         [(2, 0), (-10, 150), ("dwell", 0.5), (2, 150), (5, 0)]),
        ("201 REAM Q200=2 Q201=-10 Q206=150 Q211=0 Q208=80 Q203=0 Q204=2", [(2, 0), (-10, 150), (2, 80)]),
        (
            "203 UNIV Q200=2 Q201=-9 Q206=150 Q202=3 Q210=0 Q203=0 Q204=2 Q212=1 Q213=1 Q205=1.5 Q211=0 Q208=MAX "
            "Q256=0.2",
            [(2, 0), (-3, 150), (-2.8, 0), (-5, 150), (2, 0), (-3, 0), (-6.5, 150), (-6.3, 0), (-8, 150), (2, 0),
             (-6, 0), (-9, 150), (2, 0)],
        ),
        (
            "205 PECK Q200=2 Q201=-10 Q206=150 Q202=4 Q203=0 Q204=2 Q212=0 Q205=0 Q258=0.5 Q259=1.5 Q257=0 Q256=0 "
            "Q211=0 Q208=MAX",
            [(2, 0), (-4, 150), (2, 0), (-3.5, 0), (-8, 150), (2, 0), (-7, 0), (-10, 150), (2, 0)],
        ),
        (
            "205 PECK Q200=2 Q201=-10 Q206=150 Q202=4 Q203=0 Q204=2 Q212=0 Q205=0 Q258=0.5 Q259=0.5 Q257=4 Q256=0.3 "
            "Q211=0 Q379=-3 Q253=700",
            [(2, 0), (-1, 700), (-7, 150), (2, 0), (-6.5, 0), (-10, 150), (2, 0)],
        ),
        # plunges of 10, with chips broken every 3
        (
            "205 PECK Q200=2 Q201=-20 Q206=150 Q202=10 Q203=0 Q204=2 Q212=0 Q205=0 Q258=0.5 Q259=0.5 Q257=3 "
            "Q256=0.25 Q211=0 Q208=MAX",
            [
                (2, 0), (-3, 150), (-2.75, 0), (-6, 150), (-5.75, 0), (-9, 150), (-8.75, 0), (-10, 150), (2, 0),
                (-9.5, 0),
                (-13, 150), (-12.75, 0), (-16, 150), (-15.75, 0), (-19, 150), (-18.75, 0), (-20, 150), (2, 0),
            ],
        ),
        ("206 TAP Q200=2 Q201=-10 Q206=150 Q211=0.5 Q203=0 Q204=5",
         [(2, 0), (-10, 150), ("dwell", 0.5), (2, 150), (5, 0)]),
        ("240 CENTRE Q200=2 Q343=0 Q201=-2 Q344=0 Q206=150 Q211=0.5 Q203=0 Q204=5",
         [(2, 0), (-2, 150), ("dwell", 0.5), (2, 0), (5, 0)]),
        ("202 BORE Q200=2 Q201=-10 Q206=150 Q211=0 Q208=90 Q203=0 Q204=5 Q214=3",
         [(2, 0), (-10, 150), (2, 90), (5, 0)]),
        # the last peck is a whole one; no depth at all
        ("200 DRILL Q200=2 Q201=-8 Q206=150 Q202=4 Q210=0 Q203=0 Q204=2 Q211=0",
         [(2, 0), (-4, 150), (2, 0), (-2, 0), (-8, 150), (2, 0)]),
        ("200 DRILL Q200=2 Q201=0 Q206=150 Q202=4 Q210=0 Q203=0 Q204=5 Q211=1", [(2, 0), (5, 0)]),
        ("201 REAM Q200=2 Q201=0 Q206=150 Q211=1 Q208=80 Q203=0 Q204=5", [(2, 0), (5, 0)]),
        ("202 BORE Q200=2 Q201=0 Q206=150 Q211=0 Q208=90 Q203=0 Q204=5 Q214=3", [(2, 0), (5, 0)]),
        ("240 CENTRE Q200=2 Q343=0 Q201=0 Q344=0 Q206=150 Q211=1 Q203=0 Q204=5", [(2, 0), (5, 0)]),
        # plunges of 6, 4 and 3, which is the least; a chip is broken, then all is cleared, in turn
        (
            "203 UNIV Q200=2 Q201=-20 Q206=150 Q202=6 Q210=0.1 Q203=0 Q204=2 Q212=2 Q213=1 Q205=3 Q211=0.4 Q208=0 "
            "Q256=0.5",
            [
                (2, 0), (-6, 150), (-5.5, 0), (-10, 150), (2, 150), ("dwell", 0.1), (-8, 0), (-13, 150), (-12.5, 0),
                (-16, 150), (2, 150), ("dwell", 0.1), (-14, 0), (-19, 150), (-18.5, 0), (-20, 150), ("dwell", 0.4),
                (2, 150),
            ],
        ),
        # no plunge is as long as Q257: no chip is broken
        (
            "205 PECK Q200=2 Q201=-20 Q206=150 Q202=4 Q203=0 Q204=6 Q212=0 Q205=0 Q258=0.5 Q259=0.5 Q257=5 Q256=0.3 "
            "Q211=0.2 Q208=200",
            [
                (2, 0), (-4, 150), (2, 200), (-3.5, 0), (-8, 150), (2, 200), (-7.5, 0), (-12, 150), (2, 200),
                (-11.5, 0),
                (-16, 150), (2, 200), (-15.5, 0), (-20, 150), ("dwell", 0.2), (2, 200), (6, 0),
            ],
        ),
        (
            "205 PECK Q200=2 Q201=-12 Q206=150 Q202=5 Q203=0 Q204=2 Q212=1.5 Q205=3 Q258=1 Q259=1 Q257=0 Q256=0.3 "
            "Q211=0 Q208=0",
            [(2, 0), (-5, 150), (2, 150), (-4, 0), (-8.5, 150), (2, 150), (-7.5, 0), (-11.5, 150), (2, 150), (-10.5, 0),
             (-12, 150), (2, 150)],
        ),
    ],
)  # fmt: skip
def test_heights(run, cycle, wanted):
    moves = run(f"CYCL DEF {cycle}", "CYCL CALL")
    assert heights(moves) == [(z, feed) for z, feed in wanted]
    assert all(moves.controls[row].mode == PathMode.EXACT_PATH for row in moves.control[1:])


def spindle(moves):
    return [event.data["direction"] for event in moves.events if event.kind == "spindle"]


def test_tapping_turns_the_spindle_back(run):
    moves = run("CYCL DEF 206 TAP Q200=2 Q201=-10 Q206=150 Q211=0 Q203=0 Q204=5", "CYCL CALL")
    assert spindle(moves) == ["clockwise", "counterclockwise", "clockwise"]


def test_boring_leaves_the_wall(run):
    """Q214=3: towards +X, by Q357."""
    moves = run(
        "CYCL DEF 202 BORE Q200=2 Q201=-10 Q206=150 Q211=0 Q208=90 Q203=0 Q204=5 Q214=3 Q336=45 Q357=0.4", "CYCL CALL"
    )
    assert moves.end[:, 0] == pytest.approx([4, 4, 4, 4.4, 4.4, 4.4, 4.0])
    assert [event.data for event in moves.events if event.kind == "orient"] == [{"angle": 45.0}]
    assert spindle(moves) == ["clockwise", "stop", "clockwise"]


@pytest.mark.parametrize(("side", "way"), [(0, (0, 0)), (1, (-1, 0)), (2, (0, -1)), (3, (1, 0)), (4, (0, 1))])
def test_a_boring_tool_leaves_the_wall_to_the_side_that_is_asked_for(run, side, way):
    """By 0.2 unless Q357 says more; with the spindle that turned the other way before, it turns so again."""
    moves = run(
        "M4", f"CYCL DEF 202 BORE Q200=2 Q201=-10 Q206=150 Q211=0 Q208=0 Q203=0 Q204=5 Q214={side}", "CYCL CALL"
    )
    assert heights(moves) == [(2, 0), (-10, 150), (2, 150), (5, 0)]
    off = np.abs(moves.end[1:, :2] - [4.0, 5.0]).max(axis=0)
    assert off == pytest.approx(np.abs(way) * 0.2)
    out = moves.end[np.isclose(moves.end[:, 2], -10.0)][-1, :2] - [4.0, 5.0]
    assert out == pytest.approx(np.array(way) * 0.2)
    assert moves.end[-1, :2] == pytest.approx([4.0, 5.0])
    assert spindle(moves) == ["clockwise", "counterclockwise", "stop", "counterclockwise"]


#: What each cycle of this module needs, as the manuals of the control list it; a value that every parameter may have.
NEEDED = {
    200: (200, 201, 206, 202, 210, 203, 204), 201: (200, 201, 206, 211, 208, 203, 204),
    202: (200, 201, 206, 211, 208, 203, 204, 214),
    203: (200, 201, 206, 202, 210, 203, 204, 212, 213, 205, 211, 208, 256),
    204: (200, 249, 250, 251, 252, 253, 254, 255, 203, 204, 214),
    205: (200, 201, 206, 202, 203, 204, 212, 205, 258, 259, 257, 256, 211),
    206: (200, 201, 206, 211, 203, 204), 262: (200, 201, 203, 204, 335, 239, 355, 253, 351, 207),
    263: (335, 239, 201, 356, 253, 351, 200, 357, 358, 359, 203, 204, 254, 207),
    264: (335, 239, 201, 356, 253, 351, 202, 258, 257, 256, 358, 359, 200, 203, 204, 206, 207),
    265: (335, 239, 201, 253, 358, 359, 360, 200, 203, 204, 254, 207),
    267: (335, 239, 201, 355, 253, 351, 200, 358, 359, 203, 204, 254, 207),
    208: (200, 201, 206, 334, 203, 204, 335), 240: (200, 343, 201, 344, 206, 211, 203, 204),
    220: (216, 217, 244, 245, 246, 247, 241, 200, 203, 204, 301),
    221: (225, 226, 237, 238, 242, 243, 224, 200, 203, 204, 301),
}  # fmt: skip


@pytest.mark.parametrize("cycle", NEEDED)
def test_a_cycle_names_the_parameter_that_is_missing(view, cycle):
    for missing in NEEDED[cycle]:
        given = " ".join(f"Q{name}={-1 if name == 201 else 1}" for name in NEEDED[cycle] if name != missing)
        text = "\n".join([*HEAD, f"CYCL DEF {cycle} A {given}", "END PGM C"])
        _moves, findings = view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, 6.0)})
        assert [(one.code, one.line) for one in findings] == [("VP005", len(HEAD) + 1)]
        assert f"Q{missing}" in findings[0].message


def test_back_boring_comes_from_below(run):
    """The part is 20 thick, the edge stands 1 above the tip, the counterbore goes 5 up; beside the hole by 3 towards
    -Y.
    """
    moves = run(
        "CYCL DEF 204 BACK Q200=2 Q249=5 Q250=20 Q251=3 Q252=1 Q253=750 Q254=200 Q255=0.5 Q203=0 Q204=9 Q214=2 Q336=0",
        "CYCL CALL",
    )
    assert heights(moves) == [(2, 0), (-23, 750), (-16, 200), ("dwell", 0.5), (-23, 750), (2, 750), (9, 0)]
    places = [(round(float(y), 6), round(float(z), 6)) for y, z in moves.end[1:, 1:3]]
    assert places[1:4] == [(2, 2), (2, -23), (5, -23)]
    assert places[-1] == (5, 9)
    assert spindle(moves) == ["clockwise", "stop", "clockwise", "stop", "clockwise"]


def test_bore_milling(run):
    """A hole of 20 with a tool of 6: helices of radius 7 about (4, 5) from 2 over the surface to -4 in four turns of
    1.5.
    """
    moves = run("CYCL DEF 208 BORE Q200=2 Q201=-4 Q206=150 Q334=1.6 Q203=0 Q204=2 Q335=20", "CYCL CALL")
    helices = moves.arcs.sweep[1:-2]
    assert helices == pytest.approx([360.0] * 4)
    assert moves.arcs.center[1:-1, :2] == pytest.approx(np.array([[4.0, 5.0]] * 5))
    arcs = moves.end[moves.kind == MoveKind.ARC]
    assert arcs[:-1, :2] == pytest.approx(np.array([[11.0, 5.0]] * 6))
    assert arcs[:, 2] == pytest.approx([2, 0.5, -1, -2.5, -4, -4, -4])
    assert arcs[-1, :2] == pytest.approx([4.0, 5.0])
    # half circles from the centre to the wall, and back
    assert moves.arcs.center[[0, -1], :2] == pytest.approx(np.array([[7.5, 5.0]] * 2))
    assert moves.arcs.sweep[[0, -2, -1]] == pytest.approx([180.0, 360.0, 180.0])
    assert moves.feed[moves.kind == MoveKind.ARC] == pytest.approx([150.0] * 7)
    assert moves.end[-1, :3].tolist() == [4.0, 5.0, 2.0]
    other = run("CYCL DEF 208 BORE Q200=2 Q201=-4 Q206=150 Q334=1.6 Q203=0 Q204=2 Q335=20 Q351=-1", "CYCL CALL")
    assert other.arcs.sweep == pytest.approx(-moves.arcs.sweep)
    mirrored = run(
        "CYCL DEF 8.0 MIRROR IMAGE",
        "CYCL DEF 8.1 X",
        "CYCL DEF 208 BORE Q200=2 Q201=-4 Q206=150 Q334=1.6 Q203=0 Q204=2 Q335=20",
        "CYCL CALL",
    )
    assert mirrored.arcs.sweep == pytest.approx(-moves.arcs.sweep)


THREAD = "CYCL DEF 262 THREAD MILLING Q335=20 Q239={} Q201=-8 Q355={} Q253={} Q351={} Q200=2 Q203=1 Q204=9 Q207=300 {}"


#: Mm/min of the middle of the tool on a circle of 7 where the wall, at 10, is milled at 300.
ON_WALL = round(300 * math.hypot(14 * math.pi, 1.5) / math.hypot(20 * math.pi, 1.5), 6)


def test_a_milled_thread_worked_out_by_hand(run):
    """M20 x 1.5 to 8 under Z1 with a tool of 6: the middle on a circle of 7 about (4, 5); 5 1/3 turns upwards, a
    quarter of the pitch on each half circle.

    The teeth go at Q207 along the wall, so the middle goes slower.
    """
    moves = run(THREAD.format("+1.5", 1, 700, "+1", "Q512=80"), "CYCL CALL")
    angle = math.radians(120)
    end = 4 + 7 * math.cos(angle), 5 + 7 * math.sin(angle)
    assert heights(moves) == [
        (3, 0),
        (-7.375, 700),
        (-7, 80),
        *((-7 + 1.5 * turn, ON_WALL) for turn in (1, 2, 3, 4, 5)),
        (1, ON_WALL),
        (1.375, ON_WALL),
        (3, 0),
        (10, 0),
    ]
    arcs = moves.kind == MoveKind.ARC
    assert moves.end[arcs, :2] == pytest.approx(np.array([*[(11, 5)] * 6, end, (4, 5)]))
    assert moves.arcs.sweep == pytest.approx([180, *[360] * 5, 120, 180])
    assert moves.arcs.center[:, :2] == pytest.approx(
        np.array([(7.5, 5), *[(4, 5)] * 6, (0.5 * (4 + end[0]), 0.5 * (5 + end[1]))])
    )


@pytest.mark.parametrize("pitch", [2.0, -2.0])
@pytest.mark.parametrize("climb", [1, -1])
@pytest.mark.parametrize(("count", "bottoms"), [(0, [-7]), (1, [-7]), (2, [-7, -3])])
@pytest.mark.parametrize("before", ["", "M4", "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X"])
def test_every_way_of_milling_cuts_the_same_thread(run, pitch, climb, count, bottoms, before):
    """On the wall the height goes with the angle about the hole as the pitch has it, right-handed where it is positive;
    whatever the way round, which is climb milling with M3 counter-clockwise."""
    moves = run(*before.split("\n"), THREAD.format(pitch, count, "MAX", climb, ""), "CYCL CALL")
    mirrored = "MIRROR" in before
    at_wall = [row for row in range(len(moves)) if moves.arc[row] >= 0 and abs(moves.arcs.sweep[moves.arc[row]]) != 180]
    sweep = moves.arcs.sweep[moves.arc[at_wall]]
    assert set(np.sign(sweep)) == {climb * (-1 if mirrored or before == "M4" else 1)}
    rise = moves.end[at_wall, 2] - moves.end[[row - 1 for row in at_wall], 2]
    hand = np.sign(pitch) * (-1 if mirrored else 1)
    assert rise == pytest.approx(hand * sweep / 360 * abs(pitch))
    lows = np.minimum(moves.end[at_wall, 2], moves.end[[row - 1 for row in at_wall], 2])
    reached = sorted({round(float(low), 6) for low in lows})
    assert reached[0] == -7
    if count != 1:
        assert reached == bottoms
    else:
        assert moves.end[at_wall, 2].max() == pytest.approx(1 if rise[0] > 0 else -1)
    # the half circles have the slope of the helix, from and to the middle of the hole
    ways = [row for row in range(len(moves)) if moves.arc[row] >= 0 and row not in at_wall]
    assert moves.end[ways, 2] - moves.end[[row - 1 for row in ways], 2] == pytest.approx(
        [0.25 * math.copysign(2, rise[0])] * len(ways)
    )
    assert moves.end[-1, :3] == pytest.approx([4, 5, 10])


@pytest.mark.parametrize(("words", "code", "part"), [
    ({"Q239=+1.5": "Q239=0"}, "VP007", "Q239"), ({"Q355=1": "Q355=-1"}, "VP007", "Q355"),
    ({"Q355=1": "Q355=1.5"}, "VP007", "Q355"), ({"Q351=+1": "Q351=0"}, "VP007", "Q351"),
    ({"Q335=20": "Q335=6"}, "VP007", "Q335"), ({"Q207=300": "Q207=0"}, "VP009", "Q207"),
    ({"Q207=300": "Q207=MAX"}, "VP009", "Q207"), ({"Q239=+1.5": "Q239=0.0001"}, "VP007", "turns"),
    ({"Q201=-8": "Q201=8"}, "VP007", "Q201"), ({"Q253=700": "Q253=-7"}, "VP007", "Q253"),
])  # fmt: skip
def test_threads_that_cannot_be_milled(view, words, code, part):
    cycle = THREAD.format("+1.5", 1, 700, "+1", "")
    for before, after in words.items():
        cycle = cycle.replace(before, after)
    text = "\n".join([*HEAD, cycle, "CYCL CALL", "END PGM C"])
    findings = view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, 6.0)})[1]
    assert [(item.code, part in item.message) for item in findings] == [(code, True)], findings


# --- where they run ---------------------------------------------------------------------------------------

CENTRE = "CYCL DEF 240 CENTRE Q200=2 Q343=0 Q201=-2 Q344=0 Q206=150 Q211=0 Q203=0 Q204=5"


def holes(moves):
    """Places at the bottom of the holes."""
    return np.round(moves.end[np.isclose(moves.end[:, 2], -2.0)][:, :2], 6)


def test_calls(run):
    moves = run(
        CENTRE, "CYCL CALL", "L X+10 FMAX M99", "L X+20 FMAX M89", "L X+30 FMAX", "L X+40 FMAX M99", "L X+50 FMAX"
    )
    assert holes(moves)[:, 0].tolist() == [4, 10, 20, 30, 40]


def test_a_new_cycle_ends_the_calls_of_every_block(run):
    moves = run(CENTRE, "L X+10 FMAX M89", CENTRE, "L X+20 FMAX", "L X+30 FMAX", "L X+40 FMAX M99")
    assert holes(moves)[:, 0].tolist() == [10, 40]


def test_between_places_of_a_pattern_the_tool_is_as_high_as_it_stood(run):
    """The greater of Q203 + Q204 and the height at the call; a call at one place has its feed rate for the way there
    alone.
    """
    places = "PATTERN DEF ROW1 (X+10 Y+0 D+10 NUM3 ROT+0 Z+0)"
    for stood, between in ((40, 40), (3, 5)):
        moves = run(CENTRE, places, f"L Z+{stood} FMAX", "CYCL CALL PAT FMAX")
        sideways = np.flatnonzero(np.abs(np.diff(moves.end[:, 0])) > 1.0)[1:] + 1
        assert len(sideways) == 2
        assert (moves.end[sideways, 2] == between).all()


def test_patterns_begin_at_the_second_clearance(run):
    grid = "CYCL DEF 221 G Q225=11 Q226=1 Q237=3 Q238=5 Q242=2 Q243=2 Q224=0 Q200=2 Q203=0 Q204=20 Q301=1"
    moves = run(CENTRE, "L Z+3 FMAX", grid)
    first = int(np.flatnonzero(moves.end[:, 0] == 11.0)[0])
    assert moves.end[first - 1 : first + 2, 2].tolist() == [20.0, 20.0, 2.0]


def test_the_feed_of_a_call_at_a_place_holds_for_the_way_there(run):
    moves = run(CENTRE, "L X+5 F300", "CYCL CALL POS X+10 Y+10 F777", "L X+20")
    assert moves.feed[np.flatnonzero(np.isclose(moves.end[:, 0], 10.0))[0]] == 777.0
    assert moves.feed[-1] == 300.0


def test_calls_at_places(run):
    moves = run(CENTRE, "CYCL CALL POS X+10 Y+20 Z+3 FMAX", "CYCL CALL POS IX+5 F200")
    low = moves.end[np.isclose(moves.feed, 150.0)]
    assert low[:, :3] == pytest.approx(np.array([[10, 20, 1], [15, 20, -2]]))
    assert moves.feed[~np.isnan(moves.feed)].tolist().count(200.0) == 1


def test_patterns_of_places(run):
    pattern = (
        "POS1 (X+1 Y+2 Z+0) ROW1 (X+0 Y+0 D+10 NUM3 ROT+90) PAT1 (X+0 Y+0 DX+4 DY+6 NUMX2 NUMY2) CIRC1 (X+0 Y+0 D20 "
        "START+90 NUM2)"
    )
    moves = run(CENTRE, f"PATTERN DEF {pattern} PITCHCIRC1 (X+0 Y+0 D20 START+0 STEP+90 NUM2)", "CYCL CALL PAT FMAX")
    wanted = [(1, 2), (0, 0), (0, 10), (0, 20), (0, 0), (4, 0), (4, 6), (0, 6), (0, 10), (0, -10), (10, 0), (0, 10)]
    assert holes(moves) == pytest.approx(np.array(wanted, dtype=float))


def test_a_circle_of_holes(run):
    moves = run(
        CENTRE, "CYCL DEF 220 C Q216=1 Q217=2 Q244=20 Q245=0 Q246=360 Q247=0 Q241=4 Q200=2 Q203=0 Q204=20 Q301=1"
    )
    assert holes(moves) == pytest.approx(np.array([[11, 2], [1, 12], [-9, 2], [1, -8]], dtype=float))
    assert moves.end[-1, 2] == 20.0
    part = run(CENTRE, "CYCL DEF 220 C Q216=0 Q217=0 Q244=20 Q245=0 Q246=90 Q247=0 Q241=3 Q200=2 Q203=0 Q204=20 Q301=0")
    c = 10 * math.cos(math.radians(45))
    assert holes(part) == pytest.approx(np.array([[10, 0], [c, c], [0, 10]]))
    between = part.end[1:-1][np.diff(part.end[1:, 0]) != 0]
    assert (between[1:, 2] == 2.0).all()  # at the set-up clearance from hole to hole


def test_a_grid_of_holes(run):
    """Rows to and fro, turned by 90 degrees about the first place."""
    moves = run(CENTRE, "CYCL DEF 221 G Q225=1 Q226=1 Q237=3 Q238=5 Q242=2 Q243=2 Q224=90 Q200=2 Q203=0 Q204=20 Q301=1")
    assert holes(moves) == pytest.approx(np.array([[1, 1], [1, 4], [-4, 4], [-4, 1]], dtype=float))


def test_a_parameter_that_is_changed_after_the_definition(run, view):
    cycle = "CYCL DEF 200 DRILL Q200=2 Q201=-10 Q206=150 Q202=4 Q210=0 Q203=0 Q204=2 Q211=0"
    plain = run(cycle, "L X+20 M99")
    assert len(run(cycle, "L X+5 FMAX", "Q201 = -10", "Q1 = 5", "L X+20 M99")) == len(plain) + 1
    text = "\n".join([*HEAD, cycle, "L X+5 FMAX", "Q201 = -3", "L X+20 M99", "END PGM C"])
    _moves, errors = view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, 6.0)})
    assert [(item.code, "Q201" in item.message) for item in errors] == [("VP017", True)]


def test_a_cycle_under_m136_is_refused(view):
    """Whether a control takes Q206 per turn then is open: 0.2 would be 0.2 mm a minute, or 150 mm a turn."""
    cycle = "CYCL DEF 200 D Q200=2 Q201=-5 Q206=150 Q202=5 Q210=0 Q203=0 Q204=20 Q211=0"
    for word, wanted in ("M136", [("VP017", 7)]), ("M137", []):
        text = "\n".join([*HEAD[:3], cycle, "M136", word, "L X+9 FMAX M99", "END PGM C"])
        _moves, errors = view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, 6.0)})
        assert [(item.code, item.line) for item in errors] == wanted


@pytest.mark.parametrize(
    "word", ["L M140 MB5 F600", "PLANE AXIAL A+0 C+30 TURN F600", "PLANE SPATIAL SPA+0 SPB+0 SPC+30 TURN MB5 F600"]
)
def test_f_of_a_retract_and_of_a_plane_after_fu_is_a_minute(machine, word):
    """FU0.2 holds before and after: F600 of the statement is no feed rate per turn."""
    text = (
        "BEGIN PGM C MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+40 A+0 C+0 FMAX M3\nL X+5 FU0.2\n"
        f"{word}\nPLANE RESET STAY\nL Z+50\nEND PGM C MM\n"
    )
    setup = build_interpreter_setup(machine, Options(dialect="heidenhain", tool_length=60.0))
    moves = interpret_program(text.encode(), setup)
    found = list(zip(moves.line.tolist(), moves.feed.tolist(), moves.feed_mode.tolist(), strict=True))
    per_turn, per_minute = found[1][2], found[2][2]
    assert per_turn != per_minute
    assert {row[1:] for row in found if row[0] == 5} == {(600.0, per_minute)}
    assert found[-1][1:] == (0.2, per_turn)


def test_a_call_at_a_place_keeps_the_feed_per_turn(run):
    """Sideways the tool moves at the feed in force, FU is one per turn before and after."""
    moves = run(
        "CYCL DEF 200 D Q200=2 Q201=-5 Q206=150 Q202=5 Q210=0 Q203=0 Q204=20 Q211=0",
        "L X+5 FU0.2",
        "CYCL CALL POS X+10 Y+0 Z+0",
        "L X+30",
    )
    sideways = [row for row in range(1, len(moves)) if abs(moves.end[row, 0] - moves.end[row - 1, 0]) > 0.5]
    assert [round(float(moves.end[row, 0])) for row in sideways] == [5, 10, 30]
    assert len({(moves.feed[row], moves.feed_mode[row]) for row in sideways}) == 1


def test_corners_under_m136_have_their_feed_per_turn_in_inches(view):
    text = "\n".join(
        [
            "BEGIN PGM C INCH",
            "TOOL CALL 1 Z S1000",
            "L X+0 Y+0 Z+1 R0 F100 M3",
            "M136",
            "L X+1 F0.01",
            "RND R0.1 F0.02",
            "L Y+1",
            "END PGM C",
        ]
    )
    moves, findings = view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, 6.0)})
    assert findings == ()
    assert np.allclose(moves.feed[-3:], [0.254, 0.508, 0.254])


@pytest.mark.parametrize(("feed", "per_minute", "pitch"), [("200", 508.0, 1.27), ("FAUTO", 50.8, 0.127)])
def test_feed_rates_of_cycles_in_inches_count_in_tenths(view, feed, per_minute, pitch):
    cycle = f"CYCL DEF 206 TAP Q200=.2 Q201=-.4 Q206={feed} Q211=0 Q203=0 Q204=2"
    text = f"BEGIN PGM C INCH\nTOOL CALL 1 Z S400 F20\nL X0 Y0 Z2 R0 FMAX M3\n{cycle}\nCYCL CALL\nEND PGM C"
    moves, findings = view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, 6.0)})
    assert findings == ()
    assert heights(moves) == [(5.08, 0), (-10.16, per_minute), (5.08, per_minute), (50.8, 0)]
    assert [tap.pitch for tap in moves.taps] == [pitch]


def test_an_assignment_after_a_whole_cycle_is_none_of_its_parameters(run):
    moves = run(
        "CYCL DEF 200 D Q200=2 Q201=-5 Q206=150 Q202=5 Q210=0 Q203=0 Q204=20 Q211=0",
        "Q102 = -7",
        "L X+Q102 R0 FMAX M99",
    )
    assert moves.end[-1, 0] == -7


def test_a_length_from_a_local_parameter(view):
    text = "\n".join(
        [
            *HEAD[:1],
            "QL1 = 80",
            "TOOL DEF 5 L+QL1 R+5",
            "TOOL CALL 5 Z S1000 F300",
            "L X+4 Y+5 Z+40 R0 F100 M3",
            "END PGM C",
        ]
    )
    moves, findings = view(text, dialect="heidenhain")
    assert findings == ()
    assert moves.frames[int(moves.frame[-1])].tool[2] == 80


DRILL = "CYCL DEF 200 DRILL Q200=2 Q201=-10 Q206=150 Q202=0.001 Q210=0 Q203=0 Q204=2 Q211=0"


@pytest.mark.parametrize(
    ("block", "part"),
    [
        (
            f"{DRILL}\nPATTERN DEF ROW1 (X+0 Y+0 D+1 NUM4 ROT+0 Z+0)\nCYCL CALL PAT FMAX",
            "more than 30000 pecks in the holes of one block",
        ),
        (
            f"{DRILL}\n"
            "CYCL DEF 220 POLAR PATTERN Q216=+0 Q217=+0 Q244=60 Q245=+0 Q246=+360 Q247=+0 Q241=4 Q200=2 Q203=+0 "
            "Q204=20 Q301=1 Q365=0",
            "more than 30000 pecks in the holes of one block",
        ),
        (f"{DRILL}\nPATTERN DEF PAT1 (X+0 Y+0 DX+1 DY+1 NUMX10000 NUMY10000 ROT+0 Z+0)", "from 1 to 10000"),
    ],
)
def test_holes_and_pecks_of_one_block_are_bounded_before_the_first(view, block, part):
    """10,000 pecks in a hole are allowed; in four of one block they are not, and none of them is drilled."""
    text = "\n".join([*HEAD, block, "END PGM C"])
    moves, findings = view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, 6.0)})
    assert [item.code for item in findings] == ["VP007"]
    assert part in findings[0].message
    assert moves is None or len(moves) < 10
