"""Where F holds on arcs beside the contour: CFC, CFIN, CFTCP, M109, M110, M111, Fanuc's inside arcs, and LinuxCNC's
none.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from verne_post import check, convert, verify
from verne_post.base.units import MM_PER_INCH
from verne_post.model.codes import CODES
from verne_post.model.control_keys import FanucKeys, read_keys
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options
from verne_post.output.summary import format_summary

from .conftest import make_tool

F, TOOL = 600.0, make_tool(1, 80.0, 10.0)
#: Inside R6 between lines, an outside corner at X0 Y12, and outside R6; the tool has the radius 5.
G_CODE = "G{side} X0 Y0 F600\nX20\nG3 X20 Y12 {r}6\nG1 X0\nY40\nG2 X6 Y46 {r}6\nG1 X40\nG40 Y80"
SIEMENS = f"T1 M6\nD1\nS900 M3\nG0 X-30 Y0 Z20 A0 C0\nG1 {G_CODE.format(side=41, r='CR=')}\nM30"
FANUC = f"%\nO1\nG40 G80 G94\nT1 M6\nG43 H1 G0 X-30 Y0 Z20 A0 C0\nG1 D1 {G_CODE.format(side=41, r='R')}\nM30"
KLARTEXT = (
    "BEGIN PGM A MM\nTOOL CALL 1 Z S900 F600\nL X-30 Y+0 Z+20 A+0 C+0 R0 FMAX M3\n{words}\nL X+0 Y+0 RL F600\nL X+20\n"
    "CR X+20 Y+12 R+6 DR+\nL X+0\nL Y+40\nCR X+6 Y+46 R+6 DR-\nL X+40\nL Y+80 R0\n{after}M30\nEND PGM A MM"
)


def arc_feeds(moves):
    """Feed rates of the arcs."""
    return [round(float(value), 9) for value in moves.feed[moves.kind == MoveKind.ARC]]


@pytest.fixture(scope="session")
def feeds(view):
    """Feed rates of the arcs of a text; lines and the arc about the corner have F."""

    def run(text, dialect, control=None):
        moves, errors = view(text, dialect=dialect, tools={1: TOOL}, control=control or {})
        assert errors == ()
        assert set(moves.feed[moves.kind == MoveKind.FEED].tolist()) == {F}
        inside, *corner, outside = arc_feeds(moves)
        assert corner in ([], [F])
        return [inside, outside]

    return run


@pytest.mark.parametrize(("word", "start", "inside", "outside"), [
    ("CFC", "", 100, 1100), ("CFIN", "", 100, 600), ("CFTCP", "", 600, 600),
    ("", "", 100, 1100),  # the factory's reset state
    ("", "CFTCP", 600, 600), ("", "CFIN", 100, 600), ("CFC", "CFTCP", 100, 1100),
])  # fmt: skip
def test_siemens(feeds, word, start, inside, outside):
    control = {"siemens": {"start": f"G1 G17 G40 G54 G60 G710 G90 G94 {start}"}} if start else {}
    assert feeds(f"{word}\n{SIEMENS}", "siemens", control) == [inside, outside]
    assert feeds(SIEMENS.replace("G41", f"{word} G41"), "siemens", control) == [inside, outside]  # beside others too


@pytest.mark.parametrize(("words", "inside", "outside"), [
    ("L M109", 100, 1100), ("L M110", 100, 600), ("L M111", 600, 600), ("", 600, 600), ("L M109\nL M111", 600, 600),
    ("L M110\nL M109", 100, 1100),
])  # fmt: skip
def test_klartext(feeds, words, inside, outside):
    assert feeds(KLARTEXT.format(words=words, after=""), "heidenhain") == [inside, outside]


def test_klartext_begins_with_its_block_and_ends_after_it(feeds):
    text = KLARTEXT.format(words="", after="").replace("R+6 DR+", "R+6 DR+ M109")
    assert feeds(text, "heidenhain") == [100, 1100]
    assert feeds(text.replace("R+6 DR-", "R+6 DR- M111"), "heidenhain") == [100, 1100]
    assert feeds(text.replace("L Y+40", "L Y+40 M111"), "heidenhain") == [100, 600]


def test_a_rounding_has_the_function_of_the_element_before_it(view):
    text = KLARTEXT.format(words="L M110", after="").replace("CR X+20 Y+12 R+6 DR+", "L Y+20\nRND R15")
    moves, errors = view(text, dialect="heidenhain", tools={1: TOOL})
    assert errors == ()
    assert arc_feeds(moves)[0] == pytest.approx(F * 10 / 15)


@pytest.mark.parametrize(("percent", "inside"), [(None, 100), (0, 100), (12.5, 100), (25, 150), (100, 600)])
def test_fanuc_slows_inside_arcs_down_to_a_share(feeds, percent, inside):
    """F x Rc/Rp, no less than parameter 1710, in compensation; G62 has nothing to do with it."""
    control = {} if percent is None else {"fanuc": {"inside_arc_percent": percent}}
    assert feeds(FANUC, "fanuc", control) == [inside, 600]


@pytest.mark.parametrize("value", [-1, 101, "12", True, math.nan])
def test_wrong_share(value):
    with pytest.raises(ValueError, match="inside_arc_percent: expected a number from 0 to 100"):
        read_keys(FanucKeys, {"inside_arc_percent": value})


def test_linuxcnc_knows_the_centre_alone(feeds):
    assert feeds(FANUC.replace("%\nO1\n", ""), "rs274") == [600, 600]


@pytest.mark.parametrize("word", ["CFC", "CFIN", "CFTCP"])
def test_without_compensation_f_is_that_of_the_tool(feeds, word):
    assert feeds(f"{word}\n{SIEMENS.replace('G41', '')}", "siemens") == [600, 600]


def test_arcs_about_corners_keep_f(view):
    """A corner has no length on the contour; its arc belongs to the block after it."""
    for side, wanted in (("G41", [100, F, 1100]), ("G42", [1100, 100])):
        moves, errors = view(f"CFC\n{SIEMENS.replace('G41', side)}", dialect="siemens", tools={1: TOOL})
        assert errors == ()
        assert arc_feeds(moves) == wanted


def test_feed_per_turn_and_inches(view):
    turned = SIEMENS.replace("F600", "F0.3").replace("S900 M3", "S900 M3 G95")
    moves, errors = view(turned, dialect="siemens", tools={1: TOOL})
    assert errors == ()
    assert arc_feeds(moves) == pytest.approx([0.05, 0.3, 0.55])
    inch = (
        "G700\n"
        "T1 M6\n"
        "D1\n"
        "S900 M3\n"
        "G0 X-1 Y0 Z1 A0 C0\n"
        "G1 G41 X0 Y0 F20\n"
        "X1\n"
        "G3 X1 Y=12/25.4 CR=6/25.4\n"
        "G1 X0\n"
        "G40 Y4\n"
        "M30"
    )
    moves, errors = view(inch, dialect="siemens", tools={1: TOOL})
    assert errors == ()
    assert arc_feeds(moves)[0] == pytest.approx(20 * MM_PER_INCH / 6)


def test_a_subprogram_with_save_gives_the_word_back(feeds):
    text = SIEMENS.replace("G1 G41", "CFTCP\nSUB1\nG1 G41")
    assert feeds(f"{text}\n%_N_SUB1_SPF\nPROC SUB1 SAVE\nCFC\nRET", "siemens") == [600, 600]
    assert feeds(f"{text}\n%_N_SUB1_SPF\nPROC SUB1\nCFC\nRET", "siemens") == [100, 1100]


def test_one_word_of_the_group_a_block(view):
    assert view(f"CFC CFIN\n{SIEMENS}", dialect="siemens", tools={1: TOOL})[1][0].code == "VP003"
    text = KLARTEXT.format(words="L M109 M110", after="")
    assert view(text, dialect="heidenhain", tools={1: TOOL})[1][0].code == "VP004"


@given(
    st.floats(0.5, 60.0),
    st.floats(0.1, 8.0),
    st.floats(5.0, 300.0),
    st.floats(-20.0, 20.0),
    st.booleans(),
    st.sampled_from([41, 42]),
)
def test_an_arc_takes_the_time_of_its_contour(view, radius, tool, sweep, rise, left, side):
    """Between lines that touch it no corner shortens it: its length on the contour over F, helices too."""
    sense = 1 if left else -1
    if sense == (1 if side == 41 else -1) and radius < tool + 1e-6:
        return  # the tool does not fit inside
    turn = math.radians(sweep)
    x, y = radius * math.sin(turn), sense * radius * (1 - math.cos(turn))
    c, s = math.cos(turn), sense * math.sin(turn)
    text = (
        f"T1 M6\nD1\nG0 X-99 Y0 Z0 A0 C0\nCFC G1 G{side} X-50 Y0 F600\nX0\nG{3 if left else 2} X{x:.12f} Y{y:.12f} "
        f"Z{rise:.9f} I0 J{sense * radius:.12f}\nG1 X{x + 50 * c:.12f} Y{y + 50 * s:.12f}\nM30"
    )
    moves, errors = view(text, dialect="siemens", tools={1: make_tool(1, 80.0, 2 * tool)})
    assert errors == ()
    row = int(np.flatnonzero(moves.kind == MoveKind.ARC)[0])
    center = moves.arcs.center[moves.arc[row]]
    centre_radius = math.dist(moves.end[row, :2], center[:2])
    length = math.hypot(centre_radius * math.radians(moves.arcs.sweep[moves.arc[row]]), rise)
    # twelve decimals of the contour's end, seen from the centre of an arc of 0.5 mm: 1e-11
    assert length / moves.feed[row] == pytest.approx(math.hypot(radius * turn, rise) / F, rel=1e-9, abs=1e-12)


def test_bore_milling(view):
    """Cycle 208: its helix and its circle cut the wall of the hole; the half circles to it and back cut none."""
    cycle = "CYCL DEF 208 BORE Q200=2 Q201=-4 Q206=99 Q334=2 Q203=0 Q204=9 Q335=12 Q342=0 Q351=1 Q370=0\nCYCL CALL\n"
    helix = 99 * math.hypot(2 * math.pi, 2.0) / math.hypot(12 * math.pi, 2.0)
    for words, wanted in (
        ("M109", [99, helix, helix, helix, 16.5, 99]),
        ("M110", [99, helix, helix, helix, 16.5, 99]),
        ("M111", [99] * 6),
    ):
        text = KLARTEXT.format(words=f"L {words}", after=cycle)
        moves, errors = view(text, dialect="heidenhain", tools={1: TOOL})
        assert errors == ()
        assert arc_feeds(moves)[3:] == pytest.approx(wanted, abs=1e-9)  # as rounded


OPTIONS = Options(tools={1: TOOL}, wcs={"G54": (0.0, 0.0, 60.0)}, dialect="siemens", source_name="a.mpf")


def test_rows_keep_the_contour_at_f_and_the_judge_agrees(machine):
    result = convert(SIEMENS, machine, OPTIONS)
    assert result.ok
    values, line = result.setpoints.values, result.setpoints.line
    factor = np.array([column.factor for column in machine.columns])
    tip, _axis, ok = machine.forward(values / factor, 80.0)
    assert ok.all()
    tip = tip[:, :2]
    lines = SIEMENS.split("\n")
    for words, center, inside in (("G3", (20.0, 6.0), True), ("G2", (6.0, 40.0), False)):
        on = np.flatnonzero(line == 1 + next(k for k, text in enumerate(lines) if text.startswith(words)))
        on = on[len(on) // 3 : 2 * len(on) // 3]  # away from its ends
        radius = np.linalg.norm(tip[on] - center, axis=1)
        assert radius == pytest.approx(1.0 if inside else 11.0, abs=1e-3)
        speed = np.linalg.norm(tip[on + 1] - tip[on - 1], axis=1) / (2 * machine.cycle)
        # rows are written to 1e-5 mm: 0.005 mm/s of 1.7 mm/s over two cycles
        assert speed * 6.0 / radius == pytest.approx(F / 60.0, rel=5e-3)
    verdict = verify(result.setpoints, SIEMENS, machine, OPTIONS)
    assert 0.99 < verdict.feed_ratio <= 1.001
    faster = convert(f"CFTCP {SIEMENS}", machine, OPTIONS)
    wrong = verify(faster.setpoints, f"CFC {SIEMENS}", machine, OPTIONS)
    assert "VP404" in {item.code for item in wrong.findings}
    assert CODES["VP404"].severity == "error"


@pytest.mark.parametrize(
    ("word", "text"),
    [
        (
            "",
            "F applies on the contour (CFC, assumed: neither the program nor the settings file says so): the tool's "
            "centre goes at 0.1667 to 1.833 times F on 2 arcs",
        ),
        ("CFC", "F applies on the contour (CFC): the tool's centre goes at 0.1667 to 1.833 times F on 2 arcs"),
        ("CFIN", "F applies on the contour of inside arcs (CFIN): the tool's centre goes at 0.1667 times F on 1 arc"),
        ("CFTCP", None),
    ],
)
def test_the_summary_says_what_holds_and_what_is_assumed(machine, word, text):
    result = check(f"{word} {SIEMENS}", machine, OPTIONS)
    assert result.ok
    shown = " ".join(format_summary(result.summary).split())
    assert ("feed on arcs" in shown) == (text is not None)
    assert text is None or f"feed on arcs {text}" in shown
