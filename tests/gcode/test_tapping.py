"""Tapping in every dialect: refused once, or feed moves at pitch times speed with spindle events at their ends.

Expected moves are worked out by hand from what the manuals say of each cycle: pitch, heights, speed in and out.
"""

import numpy as np
import pytest

from verne_post import check
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options

FANUC = "%\nO1\nG21 G90 G17\nG0 X0 Y0 Z50\n"
SIEMENS = "G17 G90 G54\nT1 M6\nG0 X0 Y0 Z50\n"
KLARTEXT = "BEGIN PGM T MM\nTOOL CALL 1 Z S500\nL X0 Y0 Z50 R0 FMAX\n"
ENDS = {"fanuc": "\nM30\n%", "siemens": "\nM30", "heidenhain": "\nM30\nEND PGM T MM"}
TAP_207 = "CYCL DEF 207 RIGID Q200=2 Q201=-10 Q239={pitch} Q203=0 Q204=20\nCYCL CALL"
TAP_209 = "CYCL DEF 209 RIGID Q200=2 Q201=-10 Q239=-1.5 Q203=0 Q204=20 Q257=4 Q256={back} Q336=50 Q403=2\nCYCL CALL"

#: Dialect, program, moves (height and feed rate; None: rapid traverse, P: a dwell), spindle events (c clockwise, w counter-clockwise,
#: s stop, with the speed) and the number of the move before which each stands.
CASES = [
    # G84: from R to Z at F, dwell P ms, spindle reversed, back to R at F, G98 to the initial level
    ("fanuc", "M3 S500\nG84 Z-10 R5 P300 F600", "5 -10:600 P0.3 5:600 50", "c500@1 c500@2 w500@4 c500@5"),
    ("fanuc", "M29 S500\nG99 G84 Z-10 R5 F600", "5 -10:600 5:600", "c500@2 w500@3 s500@4"),
    ("fanuc", "S500\nG74 Z-10 R5 F600", "5 -10:600 5:600 50", "w500@2 c500@3 s500@4"),
    # under G95 F is the pitch: 1.25 mm at 400 turns a minute; Haas: J times as fast out
    ("fanuc", "S400\nG95 G84 Z-10 R5 F1.25 J3.", "5 -10:500 5:1500 50", "c400@2 w1200@3 s400@4"),
    ("fanuc", "S400 G20\nG84 Z-1 R1 F20", "25.4 -25.4:508 25.4:508 50", "c400@2 w400@3 s400@4"),
    # CYCLE84: M6 has a pitch of 1 mm; SST in, SST1 out, SDAC 5 stops
    ("siemens", "CYCLE84(20,0,2,-10,,0.5,5,6,,90,300,600)", "2 -10:300 P0.5 2:600 20", "c300@2 w600@4 s0@5"),
    ("siemens", "CYCLE84(20,0,2,,10,,4,,-1.25,0,300)", "2 -10:375 2:375 20", "w300@2 c300@3 w0@4"),
    # 20 turns an inch; cuts of 4 mm from the reference plane, back by 2 mm, and out of the hole
    ("siemens", "CYCLE84(20,0,2,-10,,,3,,20,0,500,,,2,,1,4,2)", "2 -4:635 -2:635 -8:635 -6:635 -10:635 2:635 20",
     "c500@2 w500@3 c500@4 w500@5 c500@6 w500@7 c0@8"),
    ("siemens", "CYCLE84(20,0,2,-10,,,3,,1,0,500,,,1,,2,5)", "2 -5:500 2:500 -10:500 2:500 20", "c500@2 w500@3 c500@4 w500@5 c0@6"),
    # 207: pitch Q239 at S; 209: each Q257 back by Q256 pitches or to the clearance, out Q403 times as fast
    ("heidenhain", TAP_207.format(pitch="+1.5"), "2 -10:750 2:750 20", "c500@2 w500@3 s500@4"),
    ("heidenhain", "M3\n" + TAP_207.format(pitch="-2"), "2 -10:1000 2:1000 20", "c500@1 w500@2 c500@3 c500@4"),
    ("heidenhain", TAP_209.format(back=1), "2 -4:750 -2.5:1500 -8:750 -6.5:1500 -10:750 2:1500 20",
     "s500@2 w500@2 c1000@3 w500@4 c1000@5 w500@6 c1000@7 s500@8"),
    ("heidenhain", TAP_209.format(back=0).replace("Q257=4", "Q257=6"), "2 -6:750 2:1500 -10:750 2:1500 20",
     "s500@2 w500@2 c1000@3 w500@4 c1000@5 s500@6"),
]  # fmt: skip


def program(dialect, text):
    return {"fanuc": FANUC, "siemens": SIEMENS, "heidenhain": KLARTEXT}[dialect] + text + ENDS[dialect]


def shown(moves):
    """Heights with feed rates, after the first move that the heads have."""
    found = []
    for i in range(len(moves)):
        if moves.kind[i] == MoveKind.DWELL:
            found.append(f"P{moves.feed[i]:g}")
        elif i and not (moves.end[i] == moves.end[i - 1]).all():
            feed = "" if moves.kind[i] == MoveKind.RAPID else f":{np.round(moves.feed[i], 6):g}"
            found.append(f"{np.round(moves.end[i][2], 6):g}{feed}")
    return " ".join(found)


def places_of_events(moves):
    """Spindle events, each with the number of rows with a length or a duration before it."""
    rows = np.array(
        [
            i == 0 or moves.kind[i] == MoveKind.DWELL or (moves.end[i] != moves.end[i - 1]).any()
            for i in range(len(moves))
        ]
    )
    letter = {"clockwise": "c", "counterclockwise": "w", "stop": "s"}
    return " ".join(
        f"{letter[e.data['direction']]}{e.data['speed']:g}@{rows[: e.before].sum()}"
        for e in moves.events
        if e.kind == "spindle"
    )


@pytest.mark.parametrize(("dialect", "text", "moves", "events"), CASES)
def test_rigid_tapping_is_moves_at_pitch_times_speed(view, dialect, text, moves, events):
    found, findings = view(program(dialect, text), dialect=dialect, tapping="feed")
    assert findings == ()
    assert shown(found) == moves
    assert places_of_events(found) == events
    assert [item.code for item in found.findings] == ["VP047"]


@pytest.mark.parametrize(("dialect", "text"), [(dialect, text) for dialect, text, *_rest in CASES])
def test_without_the_option_a_program_has_one_refusal_that_names_it(machine, dialect, text):
    wrong = {"fanuc": "G0 X1 W5", "siemens": "G1 X=LENGTH", "heidenhain": "L X+1 H5 F100"}[dialect]
    source = program(dialect, f"{text}\n{text}\n{'G80' if dialect == 'fanuc' else ''}\n{wrong}")
    findings = check(source.encode(), machine, Options(dialect=dialect, tool_length=50.0)).findings
    codes = [item.code for item in findings]
    assert codes.count("VP048") == 1
    assert next("--tapping feed" in item.message for item in findings if item.code == "VP048")
    assert [(item.code, item.line) for item in findings if item.code not in ("VP033", "VP048")] == [
        (
            "VP011" if dialect == "fanuc" else "VP025" if dialect == "siemens" else "VP001",
            source[: source.index(wrong)].count("\n") + 1,
        )
    ]


def test_holes_of_one_cycle_are_one_refusal_and_one_note(view, machine):
    text = program("fanuc", "S500\nG84 Z-10 R5 F600\nX10\nX20 Y5\nG80")
    refused = check(text.encode(), machine, Options(dialect="fanuc", tool_length=50.0)).findings
    assert [(item.code, item.count) for item in refused if item.code != "VP033"] == [("VP048", 1)]
    moves, findings = view(text, dialect="fanuc", tapping="feed")
    assert findings == ()
    assert [item.code for item in moves.findings] == ["VP047"]
    assert (moves.feed == 600).sum() == 6


@pytest.mark.parametrize(("dialect", "text"), [
    ("rs274", "M3 S500 F600\nG0 X0 Y0 Z50\nG84 Z-10 R5\nM2"),
    ("siemens", SIEMENS + "S500 M3 F600\nCYCLE840(20,0,2,-10,,0,4,3,0,0,1.25)\nM30"),
    ("heidenhain", KLARTEXT + "M3\nCYCL DEF 206 TAP Q200=2 Q201=-10 Q206=150 Q211=0 Q203=0 Q204=5\nCYCL CALL\nEND PGM T MM"),
])  # fmt: skip
def test_a_floating_holder_needs_no_option(view, dialect, text):
    with_option, without = (view(text, dialect=dialect, tapping=choice) for choice in ("feed", "refuse"))
    assert with_option[1] == without[1] == ()
    assert (with_option[0].end == without[0].end).all()
    assert [item.code for item in with_option[0].findings] == ["VP047"]
    assert without[0].findings == ()


@pytest.mark.parametrize(("dialect", "text", "code", "part"), [
    ("fanuc", "G84 Z-10 R5 F600", "VP017", "give S"), ("fanuc", "S500\nG84 Z-10 R5 Q2 F600", "VP002", "Q"),
    ("fanuc", "S500\nG84 Z-10 R5 J10 F600", "VP007", "J10"), ("fanuc", "S500\nG84 Z-10 R5", "VP009", "feed"),
    ("siemens", "CYCLE84(20,0,2,-10,,,5,,0,0,300)", "VP005", "pitch"), ("siemens", "CYCLE84(20,0,2,-10,,,5,,1,0,0)", "VP005", "SST"),
    ("siemens", "CYCLE84(20,0,2,-10,,,5,,1,0,300,,,,,1)", "VP002", "_DAM"), ("siemens", "CYCLE84(20,0,2,-10,,,5,37,,0,300)", "VP007", "MPIT"),
    ("siemens", "CYCLE84(20,0,2,-10,,,5,,1,0,300,,,4)", "VP002", "_PITA"), ("siemens", "CYCLE84(20,0,2,-10,,,6,,1,0,300)", "VP005", "SDAC"),
    ("siemens", "CYCLE84(20,0,2,-10,,,5,,1,0,300,,,,,1,0.0001)", "VP007", "cuts"),
    ("heidenhain", TAP_207.format(pitch="+0"), "VP007", "Q239"), ("heidenhain", TAP_209.format(back=-1), "VP007", "Q256"),
])  # fmt: skip
def test_what_tapping_needs(view, dialect, text, code, part):
    findings = view(program(dialect, text), dialect=dialect, tapping="feed")[1]
    assert [item.code for item in findings] == [code]
    assert part in findings[0].message


def test_the_same_thread_is_the_same_motion_in_every_language(view):
    """M8 coarse, 400 turns a minute, from 2 mm over the surface to 10 mm below it, then to 20 mm; RS274/NGC written out."""
    programs = {
        "rs274": "G21 G90 G0 X0 Y0 Z50\nF500\nG0 Z2\nG1 Z-10\nZ2\nG0 Z20\nM2",
        "fanuc": program("fanuc", "S400\nG0 Z20\nG84 Z-10 R2 F500"),
        "siemens": program("siemens", "CYCLE84(20,0,2,-10,,,5,8,,0,400)"),
        "heidenhain": program("heidenhain", "TOOL CALL S400\n" + TAP_207.format(pitch="+1.25")),
    }
    found = {name: shown(view(text, dialect=name, tapping="feed")[0]) for name, text in programs.items()}
    assert found["rs274"] == "2 -10:500 2:500 20"
    assert found["fanuc"] == "20 2 -10:500 2:500 20"  # one retract more: G98 goes back to where the cycle began
    assert found["siemens"] == found["heidenhain"] == found["rs274"]
