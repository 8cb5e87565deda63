"""Tapping in every dialect: refused once, or feed moves at pitch times speed with spindle events at their ends.

Expected moves are worked out by hand from what the manuals say of each cycle: pitch, heights, speed in and out.
"""

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from verne_post import check, convert
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options

FANUC = "%\nO1\nG21 G90 G17\nG0 X0 Y0 Z50\n"
SIEMENS = "G17 G90 G54\nT1 M6\nG0 X0 Y0 Z50\n"
KLARTEXT = "BEGIN PGM T MM\nTOOL CALL 1 Z S500\nL X0 Y0 Z50 R0 FMAX\n"
CL = "UNITS/MM\nLOADTL/1\nRAPID\nGOTO/0,0,50\nSPINDL/{},RPM,{}\n"
ENDS = {"fanuc": "\nM30\n%", "siemens": "\nM30", "heidenhain": "\nM30\nEND PGM T MM", "aptcl": "\nFINI"}
#: A thread of CL files: from 2 mm over the surface to 10 mm below it, back to 20 mm.
TAP_CL = "CYCLE/TAP,{},CLEAR,2,RETURN,20\nGOTO/0,0,0\nCYCLE/OFF"
TAP_207 = "CYCL DEF 207 RIGID Q200=2 Q201=-10 Q239={pitch} Q203=0 Q204=20\nCYCL CALL"
TAP_209 = "CYCL DEF 209 RIGID Q200=2 Q201=-10 Q239=-1.5 Q203=0 Q204=20 Q257=4 Q256={back} Q336=50 Q403=2\nCYCL CALL"

#: Dialect, program, moves (height and feed rate; None: rapid traverse, P: a dwell), spindle events (c clockwise, w
#: counter-clockwise, s stop, with the speed) and the number of the move before which each stands.
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
    ("siemens", "CYCLE84(20,0,2,-10,,,3,,1,0,500,,,1,,2,5)", "2 -5:500 2:500 -10:500 2:500 20",
     "c500@2 w500@3 c500@4 w500@5 c0@6"),
    # 207: pitch Q239 at S; 209: each Q257 back by Q256 pitches or to the clearance, out Q403 times as fast
    ("heidenhain", TAP_207.format(pitch="+1.5"), "2 -10:750 2:750 20", "c500@2 w500@3 s500@4"),
    ("heidenhain", "M3\n" + TAP_207.format(pitch="-2"), "2 -10:1000 2:1000 20", "c500@1 w500@2 c500@3 c500@4"),
    ("heidenhain", TAP_209.format(back=1), "2 -4:750 -2.5:1500 -8:750 -6.5:1500 -10:750 2:1500 20",
     "s500@2 w500@2 c1000@3 w500@4 c1000@5 w500@6 c1000@7 s500@8"),
    ("heidenhain", TAP_209.format(back=0).replace("Q257=4", "Q257=6"), "2 -6:750 2:1500 -10:750 2:1500 20",
     "s500@2 w500@2 c1000@3 w500@4 c1000@5 s500@6"),
    # CYCLE/TAP: Creo and NX with the feed rate, by minute and by turn; the pitch by itself, and 20 turns an inch; NX
    # names heights
    ("aptcl", CL.format(400, "CLW") + TAP_CL.format("DEPTH,10,MMPM,500"), "2 -10:500 2:500 20",
     "c400@1 c400@2 w400@3 c400@4"),
    ("aptcl", CL.format(400, "CCLW") + TAP_CL.format("DEPTH,10,MMPR,1.25,DWELL,.5"), "2 -10:500 P0.5 2:500 20",
     "w400@1 w400@2 c400@4 w400@5"),
    ("aptcl", CL.format(500, "CLW") + TAP_CL.format("RIGID,DEPTH,10,TPI,20,RATIO,3"), "2 -10:635 2:1905 20",
     "c500@1 c500@2 w1500@3 c500@4"),
    ("aptcl", CL.format(400, "CLW") + "CYCLE/TAP,RAPTO,2,FEDTO,-10,RTRCTO,20,MMPM,500,PITCH,1.25\nGOTO/0,0,0",
     "2 -10:500 2:500 20",
     "c400@1 c400@2 w400@3 c400@4"),
    # Creo, cycle_format fixed: depth, feed rate, unit, turns an inch, height; CATIA: depth and clearance, the pitch
    # from the set-up
    ("aptcl", CL.format(500, "CLW") + "CYCLE/TAP,10,635,MMPM,20,2\nGOTO/0,0,0", "2 -10:635 2:635",
     "c500@1 c500@2 w500@3 c500@4"),
    ("aptcl", CL.format(400, "CLW") + "CYCLE/TAP,10,2\nGOTO/0,0,0\nGOTO/0,0,1", "2 -10:400 2:400 3 -9:400 3:400",
     "c400@1 c400@2 w400@3 c400@4 c400@5 w400@6 c400@7"),
    # in steps of 5 mm from the clearance, out of the hole after each
    ("aptcl", CL.format(400, "CLW") + TAP_CL.format("DEEP,DEPTH,10,STEP,5,MMPR,1.25"),
     "2 -3:500 2:500 -8:500 2:500 -10:500 2:500 20",
     "c400@1 c400@2 w400@3 c400@4 w400@5 c400@6 w400@7 c400@8"),
    ("aptcl", "UNITS/INCHES\n" + CL.format(100, "CLW").replace("UNITS/MM\n", "")
     + "CYCLE/TAP,DEPTH,1,IPR,.05,CLEAR,.1,ORIENT,90\nGOTO/0,0,0",
     "2.54 -25.4:127 2.54:127", "c100@1 c100@2 w100@3 c100@4"),
]  # fmt: skip


def program(dialect, text):
    return {"fanuc": FANUC, "siemens": SIEMENS, "heidenhain": KLARTEXT, "aptcl": ""}[dialect] + text + ENDS[dialect]


#: What cutter location text does not say: the pitch of a tap.
PITCHES = {"aptcl": {"pitches": {"1": 1.0}}}


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
    control = PITCHES if "TAP,10,2" in text else {}
    found, findings = view(program(dialect, text), dialect=dialect, tapping="feed", control=control)
    assert findings == ()
    assert shown(found) == moves
    assert places_of_events(found) == events
    assert [item.code for item in found.findings] == ["VP047"]


@pytest.mark.parametrize(("dialect", "text"), [(dialect, text) for dialect, text, *_rest in CASES])
def test_without_the_option_a_program_has_one_refusal_that_names_it(machine, dialect, text):
    wrong = {"fanuc": "G0 X1 W5", "siemens": "G1 X=LENGTH", "heidenhain": "L X+1 H5 F100", "aptcl": "SPINDL/FAST"}[
        dialect
    ]
    again = text[text.find("CYCLE/") :] if dialect == "aptcl" else text
    source = program(dialect, f"{text}\n{again}\n{ {'fanuc': 'G80', 'aptcl': 'CYCLE/OFF'}.get(dialect, '') }\n{wrong}")
    control = PITCHES if "TAP,10,2" in text else {}
    findings = check(source.encode(), machine, Options(dialect=dialect, tool_length=50.0, control=control)).findings
    codes = [item.code for item in findings]
    assert codes.count("VP048") == 1
    assert next('tapping="feed"' in item.message for item in findings if item.code == "VP048")
    assert [(item.code, item.line) for item in findings if item.code not in ("VP033", "VP048")] == [
        (
            {"fanuc": "VP011", "siemens": "VP025", "heidenhain": "VP001", "aptcl": "VP005"}[dialect],
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


CYCLE_84 = "CYCLE84(20,0,2,-10,,,3,,{},0,400)"
G84 = "S400 M3\nM29 S{}\nG84 Z-10 R5 F{}"


@pytest.mark.parametrize(
    ("dialect", "remark", "text", "pitch", "reason"),
    [
        ("fanuc", "", G84.format(400, "500."), "1.25", ""),
        ("fanuc", "", G84.format(400, "5000."), "12.5", "tool 1 has a diameter of 8 mm"),
        ("fanuc", "", G84.format(40, "500."), "12.5", "tool 1 has a diameter of 8 mm"),
        ("fanuc", "", G84.format(400, "50."), "0.125", "none has less than 0.15 mm"),
        ("fanuc", "(T1 M8 TAP)", G84.format(400, "50."), "0.125", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 M8 TAP)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 M8 TAP)", G84.format(400, "1000."), "2.5", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 M8 TAP)", G84.format(400, "200."), "0.5", ""),  # the finest thread of this size
        ("fanuc", "(T1 M8 ROUGH)", G84.format(400, "508."), "1.27", ""),  # 20 threads an inch
        ("fanuc", "(T1 TAP 5/16-18 M8)", G84.format(400, "564.4"), "1.411", ""),
        ("fanuc", "(T1 M8X1 TAP)", G84.format(400, "400."), "1", ""),
        ("fanuc", "(T1 M8X1.25 TAP)", G84.format(400, "400."), "1", "its tool that it is M8X1.25;"),
        ("fanuc", "(T1 M8X20 TAP)", G84.format(400, "400."), "1", ""),  # a length
        ("fanuc", "(T1 M2.5 TAP)", G84.format(400, "180."), "0.45", ""),
        ("fanuc", "(T1 TAP, M08)", G84.format(400, "1200."), "3", ""),  # coolant
        ("fanuc", "(T1 TAP 1/2-13 M3 S400)", G84.format(400, "781.6"), "1.954", ""),
        ("fanuc", "(T1 TAP 3/8-16 LH M4)", G84.format(400, "635."), "1.587", ""),
        ("fanuc", "(T1 TAP 4-40 COLLET M24)", G84.format(400, "254."), "0.635", ""),
        ("fanuc", "(T1 TAP NO.4 COLLET M24)", G84.format(400, "254."), "0.635", ""),
        ("fanuc", "(T1 TAP 1/2 HOLDER SK40 M3)", G84.format(400, "781.6"), "1.954", ""),
        ("fanuc", "(T1 M8 TAP COLLET M24)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 M8 ROUGH, CHUCK ER32)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 M8 TAP HOLDER SK40)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 M8 SHANK 8 MM)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 M8 TAP 12 MM DEEP)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 G1/4 TAP M5)", G84.format(400, "534.7"), "1.337", ""),
        ("fanuc", "(T1 M8 OP 2/3)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 M8 5/16-18)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 TAP 8 MM M3)", G84.format(400, "500."), "1.25", ""),
        ("fanuc", "(T1 TAP 8X1.25 RIGID M3)", G84.format(400, "500."), "1.25", ""),
        ("fanuc", "(T1 TAP M8 M3 S400)", G84.format(400, "1200."), "3", "M8, whose coarse pitch is 1.25 mm"),
        ("fanuc", "(T1 TAP M8X1.25-6H M3)", G84.format(400, "400."), "1", "its tool that it is M8X1.25;"),
        ("fanuc", "(T1 M8X1.25-6H M3)", G84.format(400, "400."), "1", ""),  # two sizes
        ("fanuc", "(T1 TAP M8X1.25-6H)", G84.format(400, "400."), "1", "its tool that it is M8X1.25;"),
        ("rs274", "(T1 M8 TAP)", "S400 M3 F5000\nG84 Z-10 R5", "12.5", "M8, whose coarse pitch is 1.25 mm"),
        ("siemens", "; T1 M8 TAP", CYCLE_84.format(125), "125", "M8, whose coarse pitch is 1.25 mm"),
        ("siemens", "; T1 M8 TAP", f"MCALL {CYCLE_84.format(125)}\nX9\nMCALL", "125", "M8, whose coarse pitch is 1.25"),
        ("siemens", "", CYCLE_84.format(1.25), "1.25", ""),
        ("heidenhain", "", TAP_207.format(pitch="+125"), "125", "tool 1 has a diameter of 8 mm"),
        ("heidenhain", "", TAP_207.format(pitch=125).replace(" Q2", " ~\n Q2"), "125", "has a diameter of 8 mm"),
        ("heidenhain", "", TAP_207.format(pitch="-1"), "1", ""),
        ("aptcl", "", CL.format(400, "CLW") + TAP_CL.format("DEPTH,10,MMPR,12.5"), "12.5", "a diameter of 8 mm"),
    ],
)
def test_a_pitch_that_no_tap_has_is_told(dialect, remark, text, pitch, reason):
    starts = {
        "fanuc": "%\nO1\n{}\nG21 G90 G17 G94 G54\nT1 M6\nG0 X0 Y0 A0 C0\nG43 H1 Z50\n",
        "rs274": "{}\nG21 G90 G17 G94 G54\nT1 M6\nG0 X0 Y0 A0 C0\nG43 H1 Z50\n",
        "siemens": "{}\nG17 G90 G54 G94\nT1 M6\nD1\nS400 M3\nG0 X0 Y0 A0 C0\nZ50\n",
        "heidenhain": KLARTEXT,
        "aptcl": "",
    }
    ends = {**ENDS, "rs274": "\nM2"}
    options = Options(dialect=dialect, tapping="feed", tools={1: make_tool(1, 80.0, 8.0)}, wcs={"G54": (0, 0, 90)})
    source = starts[dialect].format(remark) + text + ends[dialect]
    found = check(source, "ac_trunnion", options).findings
    (note,) = (item.message for item in found if item.code == "VP047")
    told = [item for item in found if item.code == "VP505"]
    assert f"each tap ({pitch} mm a turn)" in note
    assert len(told) == bool(reason)
    assert all(one.message.startswith(f"{pitch} mm a turn") and reason in one.message for one in told)
    words = {"fanuc": ("F", "F (pitch times S"), "siemens": (pitch, "PIT, value 9"), "heidenhain": ("Q239", "Q239")}
    for item in told if dialect in words else ():  # under the caret, and in the message
        assert source.splitlines()[item.line - 1][item.column - 1 :].startswith(words[dialect][0])
        assert f"; correct {words[dialect][1]}" in item.message


def test_a_pitch_of_a_called_file_is_marked_at_its_word():
    """The place in the file was its line alone."""
    called = {"o2000": b"%\nO2000\nM29 S400\nG84 Z-10. R5. F1200.\nG80\nM99\n%\n"}
    tools, wcs = {1: make_tool(1, 80.0, 8.0)}, {"G54": (0, 0, 90)}
    options = Options(dialect="fanuc", tapping="feed", tools=tools, wcs=wcs, subroutines=called)
    program = "O1\n(T1 M8 TAP)\nG21 G90 G17 G94 G54\nT1 M6\nG0 X0 Y0 A0 C0\nG43 H1 Z50\nS400 M3\nM98 P2000\nM30\n"
    (item,) = (one for one in check(program, "ac_trunnion", options).findings if one.code == "VP505")
    assert (item.line, item.column, item.called) == (8, None, ("o2000.ngc", 4, 15))


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("rs274", "M3 S500 F600\nG0 X0 Y0 Z50\nG84 Z-10 R5\nM2"),
        ("siemens", SIEMENS + "S500 M3 F600\nCYCLE840(20,0,2,-10,,0,4,3,0,0,1.25)\nM30"),
        (
            "heidenhain",
            KLARTEXT + "M3\nCYCL DEF 206 TAP Q200=2 Q201=-10 Q206=150 Q211=0 Q203=0 Q204=5\nCYCL CALL\nEND PGM T MM",
        ),
        ("aptcl", CL.format(400, "CLW") + TAP_CL.format("FLOAT,DEPTH,10,MMPM,400") + "\nFINI"),
    ],
)
def test_a_floating_holder_needs_no_option(view, dialect, text):
    with_option, without = (view(text, dialect=dialect, tapping=choice) for choice in ("feed", "refuse"))
    assert with_option[1] == without[1] == ()
    assert (with_option[0].end == without[0].end).all()
    assert [item.code for item in with_option[0].findings] == ["VP047"]
    assert without[0].findings == ()


@pytest.mark.parametrize(
    ("dialect", "text", "code", "part"),
    [
        ("fanuc", "G84 Z-10 R5 F600", "VP017", "give S"),
        ("fanuc", "S500\nG84 Z-10 R5 Q2 F600", "VP002", "Q"),
        ("fanuc", "S500\nG84 Z-10 R5 J10 F600", "VP007", "J10"),
        ("fanuc", "S500\nG84 Z-10 R5", "VP009", "feed"),
        ("siemens", "CYCLE84(20,0,2,-10,,,5,,0,0,300)", "VP005", "pitch"),
        ("siemens", "CYCLE84(20,0,2,-10,,,5,,1,0,0)", "VP005", "SST"),
        ("siemens", "CYCLE84(20,0,2,-10,,,5,,1,0,300,,,,,1)", "VP002", "_DAM"),
        ("siemens", "CYCLE84(20,0,2,-10,,,5,37,,0,300)", "VP007", "MPIT"),
        ("siemens", "CYCLE84(20,0,2,-10,,,5,,1,0,300,,,4)", "VP002", "_PITA"),
        ("siemens", "CYCLE84(20,0,2,-10,,,6,,1,0,300)", "VP005", "CYCLE84 needs SDAC 3, 4 or 5"),
        ("siemens", "CYCLE84(20,0,2,-10,,,5,,0,0,300)", "VP005", "CYCLE84 needs the pitch (value 9, PIT, or"),
        ("siemens", "CYCLE84(20,0,2,-10,,,5,,1,0,300,,,,,1,0.0001)", "VP007", "cuts"),
        *(
            ("aptcl", CL.format(400, "CLW") + f"CYCLE/TAP,{words}\nGOTO/0,0,0", code, part)
            for words, code, part in (
                ("10,2", "VP005", "tool 1"),
                ("DEPTH,10,CLEAR,2", "VP005", "pitch"),
                ("10,500,MMPM,20,2", "VP007", "1.25 mm of its feed"),
                ("DEPTH,10,CLEAR,2,MMPR,-1", "VP007", "-1"),
                ("DEPTH,10,CLEAR,-1,MMPR,1", "VP007", "CLEAR"),
            )
        ),
        (
            "aptcl",
            CL.format(400, "CLW") + "SPINDL/OFF\nCYCLE/TAP,DEPTH,10,CLEAR,2,MMPR,1\nGOTO/0,0,0",
            "VP017",
            "SPINDL",
        ),
        *(
            ("aptcl", CL.format(400, "CLW") + f"CYCLE/TAP,{words}", code, part)
            for words, code, part in (
                ("10,2,3", "VP005", "3"),
                ("10,2,MMPR,1.25", "VP005", "10"),
                ("BRKCHP,DEPTH,9,CLEAR,2,STEP,3,MMPR,1", "VP002", "BRKCHP"),
                ("DEEP,DEPTH,10,CLEAR,2,MMPR,1", "VP005", "STEP"),
                ("DEPTH,10,CLEAR,2,STEP,3,MMPR,1", "VP002", "STEP"),
                ("DEPTH,10,CLEAR,2,TPI,0", "VP007", "TPI"),
                ("DEPTH,10,CLEAR,2,MMPR,1,RATIO,.5", "VP007", "RATIO"),
                ("DEPTH,10,CLEAR,2,MMPR,1,MULTRD,2", "VP002", "MULTRD"),
            )
        ),
        ("heidenhain", TAP_207.format(pitch="+0"), "VP007", "Q239"),
        ("heidenhain", TAP_209.format(back=-1), "VP007", "Q256"),
    ],
)
def test_what_tapping_needs(view, dialect, text, code, part):
    findings = view(program(dialect, text), dialect=dialect, tapping="feed")[1]
    assert [item.code for item in findings] == [code]
    assert part in findings[0].message


def test_the_same_thread_is_the_same_motion_in_every_language(view):
    """M8 coarse, 400 turns a minute, from 2 mm over the surface to 10 mm below it, then to 20 mm; RS274/NGC written
    out.
    """
    programs = {
        "rs274": "G21 G90 G0 X0 Y0 Z50\nF500\nG0 Z2\nG1 Z-10\nZ2\nG0 Z20\nM2",
        "fanuc": program("fanuc", "S400\nG0 Z20\nG84 Z-10 R2 F500"),
        "siemens": program("siemens", "CYCLE84(20,0,2,-10,,,5,8,,0,400)"),
        "heidenhain": program("heidenhain", "TOOL CALL S400\n" + TAP_207.format(pitch="+1.25")),
        "aptcl": program("aptcl", CL.format(400, "CLW") + "CYCLE/TAP,DEPTH,10,CLEAR,2,RETURN,20,MMPR,1.25\nGOTO/0,0,0"),
    }
    found = {name: shown(view(text, dialect=name, tapping="feed")[0]) for name, text in programs.items()}
    assert found["rs274"] == "2 -10:500 2:500 20"
    assert found["fanuc"] == "20 2 -10:500 2:500 20"  # one move more: G98 begins at the height to which it goes back
    assert found["siemens"] == found["heidenhain"] == found["aptcl"] == found["rs274"]


@pytest.mark.parametrize(
    ("cl", "twin"),
    [
        (
            "CYCLE/TAP,DEPTH,10,CLEAR,2,MMPR,1.25,DWELL,.2\nGOTO/0,0,0\nGOTO/9,0,0",
            "G43 H1\nG99 G84 X0 Y0 Z-10 R2 P.2 F500\nX9",
        ),
        (
            "CYCLE/TAP,DEPTH,10,CLEAR,2,MMPR,1.25\nGOTO/10,0,0,0,.6,.8",
            "G0 X10 Y1.2 Z1.6 I0 J.6 K.8\nG61.1 G1 X10 Y-6 Z-8 F500 I0 J.6 K.8\nX10 Y1.2 Z1.6 I0 J.6 K.8",
        ),
    ],
)
def test_setpoints_of_a_thread_are_those_of_g84_and_of_moves_written_out(machine, cl, twin):
    """On the machine: upright against G84 of RS274/NGC, along a tilted axis against moves."""
    options = {
        "tools": {1: make_tool(1, 80.0)},
        "wcs": {"G54": (0.0, 0.0, 40.0)},
        "cycle": 0.01,
        "smoothing": "off",
        "tapping": "feed",
    }
    texts = {
        "aptcl": CL.format(400, "CLW") + cl + "\nCYCLE/OFF\nFINI",
        "rs274": f"G21 G90 G94\nT1 M6\nG43.5 H1\nG0 X0 Y0 Z50 I0 J0 K1\nS400 M3\n{twin}\nM2",
    }
    values = []
    for dialect, text in texts.items():
        result = convert(text.encode(), machine, Options(dialect=dialect, **options))
        assert result.ok, result.findings
        values.append(result.setpoints.values)
    np.testing.assert_allclose(values[0], values[1], rtol=0.0, atol=1e-6)
