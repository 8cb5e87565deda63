"""Which limit governs and what it costs, the spectrum, the modal state and the set-up sheet: each by a route of its
own.
"""

import hashlib
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.app.line_facts import OTHERS
from verne_post.base.printable import make_printable
from verne_post.model.options import Options
from verne_post.model.part_setup import Box, Tool, WorkOffset
from verne_post.output.summary import format_summary
from verne_post.report.governing import HIGHER
from verne_post.report.head import list_setup, write_verdict_html
from verne_post.report.markup import write_css_string
from verne_post.report.modal import collect_modal_states, describe_feed
from verne_post.report.sheet import list_tools, write_record_html, write_sheet_html
from verne_post.report.spectrum import measure_spectrum
from verne_post.report.study import study
from verne_post.report.table import Study
from verne_post.report.times import write_reached_html, write_times_html
from verne_post.report.worst import find_worst_places

from ..builders import MACHINE, SAMPLES

CYCLE = MACHINE.cycle


def study_of(text: str | bytes, **options: Any) -> Study:
    source = text if isinstance(text, bytes) else text.encode()
    return study(source, MACHINE, Options(**{"tool_length": 80.0, "wcs": {1: WorkOffset((0.0, 0.0, 40.0))}, **options}))


def test_a_slow_straight_move_is_governed_by_its_feed() -> None:
    """10 mm at 60 mm/min: ten seconds, of which next to nothing is lost."""
    seen = study_of("G21 G90\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F60\nM2\n")
    assert seen.governing is not None
    by_name = dict(zip(seen.governing.names, seen.governing.seconds, strict=True))
    assert by_name["programmed feed"] == pytest.approx(10.0, abs=0.1)
    assert seen.governing.lost.sum() < 0.1
    assert seen.governing.seconds.sum() == pytest.approx(seen.x[-1], abs=1e-9)  # every cycle once
    feed = seen.curves["feed"][0].values
    assert np.nanmax(np.abs(feed - 1.0)) < 1e-12


def test_a_turn_faster_than_the_table_costs_what_it_takes_longer() -> None:
    """C by 90 degrees in 0.1 s is asked for; C does 180 deg/s and 1000 deg/s2."""
    seen = study_of("G21 G90\nG0 X0 Y0 Z0 A0 C0\nG93 G1 C90 F600\nM2\n")
    assert seen.governing is not None
    by_name = dict(zip(seen.governing.names, seen.governing.seconds, strict=True))
    lost = dict(zip(seen.governing.names, seen.governing.lost, strict=True))
    assert max(by_name, key=lambda name: by_name[name]) == "velocity of c"
    assert by_name["acceleration of c"] > 0.2
    assert by_name["jerk of c"] > 0.02
    assert sum(by_name[name] for name in by_name if name.endswith("of c")) > 0.95 * seen.x[-1]
    # everything beyond the 0.1 s that the program asks for is lost, to its limits
    assert sum(lost.values()) == pytest.approx(seen.x[-1] - 0.1, abs=0.005)
    assert seen.governing.lost_from_frame.sum() == pytest.approx(sum(lost.values()))


def test_dwells_stand_still_and_rapids_lose_nothing() -> None:
    seen = study_of("G21 G90\nG0 X0 Y0 Z0 A0 C0\nG4 P0.5\nG0 X60\nM2\n")
    assert seen.governing is not None
    rest, moving = OTHERS.index("standstill") - len(OTHERS), seen.governing.rapid
    assert seen.governing.seconds[rest] == pytest.approx(0.5, abs=0.01)
    assert seen.governing.lost.sum() == 0.0
    # who stands is in no rapid
    assert moving.sum() == pytest.approx(seen.governing.seconds.sum() - seen.governing.seconds[rest])
    assert moving.sum() == pytest.approx(sum(one.rapid for one in seen.operations))
    assert np.isnan(seen.curves["feed"][0].values).all()


def test_a_dwell_is_time_of_the_tool_that_waits() -> None:
    """The next motion is one of the next tool; two dwells before it are of two tools."""
    program = "G21 G90\n(ONE)\nT1 M6\nG0 X0 Y0 Z0 A0 C0\nX20\nG4 P0.3\n(TWO)\nT2 M6\nG4 P0.2\nG0 X0\nG4 P0.1\nX5\nM2\n"
    program = program.replace("M6", "M6\nG43")
    seen = study_of(program, split_at_stops=True, tool_length=None, tools={1: 80, 2: 70})
    spent = {(one.tool, one.name): one.standing for one in seen.operations}
    assert list(spent) == [(1, "ONE"), (2, "TWO")]
    assert list(spent.values()) == [pytest.approx(0.3, abs=0.005), pytest.approx(0.3, abs=0.005)]
    text = re.sub("<[^>]*>", " ", write_sheet_html("two.nc", program.encode(), MACHINE, seen))
    for one in seen.operations:
        assert re.search(rf"T{one.tool} +{90 - 10 * one.tool} .* {one.seconds:.3f} ", text)


def test_remarks_about_a_tool_are_no_operations() -> None:
    """They stand beside the tool already; a remark about what it does is one."""
    first = "(T1 D=10 END MILL)\nT1 M6\nG43\nG0 X0 Y0 Z0 A0 C0\nX20\n"
    program = f"G21 G90\n{first}T2 M6\n(BALL MILL D6)\nG43\nX0\n(RIM)\nX5\nM2\n"
    seen = study_of(program, split_at_stops=True, tool_length=None, tools={1: 80, 2: 70})
    assert [(one.tool, one.name) for one in seen.operations] == [(1, ""), (2, ""), (2, "RIM")]


def test_a_stop_is_time_of_the_tool_in_the_spindle() -> None:
    """The remark above it heads what the next tool does."""
    program = "G21 G90\n(ONE)\nT1 M6\nG43\nG0 X0 Y0 Z0 A0 C0\nX20\n(TWO)\nM9\nM0\nT2 M6\nG43\nG0 X0\nX5\nM2\n"
    seen = study_of(program, split_at_stops=True, tool_length=None, tools={1: 80, 2: 70})
    assert [(one.tool, one.name, one.first_line, one.last_line) for one in seen.operations] == [
        (1, "ONE", 6, 6),
        (2, "TWO", 12, 13),
    ]
    assert seen.lines is not None
    assert seen.lines.seconds[9] == pytest.approx(CYCLE)


def test_motion_dwells_and_stops_are_all_of_the_time() -> None:
    """Two dwells, one of them not a whole number of cycles; each of two stops is a cycle; all that moves is motion."""
    program = "G21 G90 G61\nG0 X0 Y0 Z0 A0 C0\nG4 P0.5\nG0 X60\nM0\nG1 Y5 F600\nG4 P0.0104\nG0 X0\nM0\nY0\nM2\n"
    seen = study_of(program, split_at_stops=True)
    summary = seen.summary
    assert summary is not None
    assert (summary.dwell_time, summary.stop_time) == (pytest.approx(0.511), pytest.approx(2 * CYCLE))
    assert summary.motion_time + summary.dwell_time + summary.stop_time == pytest.approx(summary.cycle_time)
    text = " ".join(format_summary(summary).split())
    parts = re.search(r"time (\S+) s = (\S+) s motion \+ 0\.511 s dwells \+ 0\.002 s stops(?= rows )", text)
    assert parts is not None
    assert float(parts[1]) == pytest.approx(float(parts[2]) + 0.513)
    assert f"|{parts[0][5:]}|" in re.sub("<[^>]*>", "|", write_verdict_html(MACHINE, seen))
    # a motion alone has no parts
    alone = study_of("G21 G90\nG0 X0 Y0 Z0 A0 C0\nG0 X60\nM2\n").summary
    assert alone is not None
    assert alone.motion_time == alone.cycle_time
    assert "=" not in format_summary(alone)


@pytest.mark.parametrize(
    ("name", "missing", "tilts"),
    [
        ("ac_trunnion", "spindle: the", False),
        ("linear_delta", "spindle, platform, rods: the", False),
        ("hexam", "spindle, platform: the", False),
        ("verne", "spindle, platform, rods: the", True),
    ],
)
def test_bodies_are_those_of_the_machine(name: str, missing: str, tilts: bool) -> None:
    machine = verne_post.load_machine(name)
    box = Box("vise", (300.0, 300.0, 0.0), (310.0, 310.0, 10.0))
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 60.0))}, keep_out=(box,))
    seen = study(b"G21 G90\nG0 X-20 Y10 Z20 A0 C0\nG1 X20 F900\nM2\n", machine, options)
    assert seen.summary is not None
    shown = " ".join(format_summary(seen.summary).split())
    assert f"NOT CHECKED contact with stock: no [stock] given; {missing} machine file has no size; " in shown
    assert any("tilt" in place.what for place in find_worst_places(machine, seen)) == seen.tilts == tilts


def test_seconds_below_the_feed_are_those_of_the_verification() -> None:
    """The verification measures progress along the program by projection of the rows, and counts the same seconds."""
    source = (SAMPLES / "blade_5axis.nc").read_bytes()
    seen = study_of(source, tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 10.0))})
    assert seen.summary is not None
    assert seen.summary.verification is not None
    assert seen.governing is not None
    slow = seen.summary.verification.slow
    own = dict(zip(seen.governing.names, seen.governing.seconds - seen.governing.rapid, strict=True))
    for name in ("velocity of c", "acceleration of c", "jerk of c"):
        assert own[name] == pytest.approx(slow[name], rel=0.05, abs=0.02), name
    # what the strip shows adds up to the table, stretch by stretch: half of a stretch at most is another limit's
    shown = np.bincount(
        seen.governing.of_frame, np.diff(np.append(seen.x, seen.x[-1] + CYCLE)), len(seen.governing.names)
    )
    assert np.abs(shown - seen.governing.seconds).max() < 0.2


TWO_TOOLS = """G21 G90 G64 P0.01
(PLATE)
T1 M6
G43 H1 G54
G0 X-30 Y-20 Z50 A0 C0
Z20
(FACE)
G1 Z5 F2400
X30
Y-10
G0 Z30
(RIM)
T2 M6
G43 H2
G0 X-25
G4 P0.25
G1 Y15 F600
(DRILL)
G81 X-20 Y-10 Z-8 R2 F300
G80
T1 M6
G43 H1
G0 Z60
M2
"""
TOOLS = {number: Tool(number, 1, (0.0, 0.0, 70.0, 0, 0, 0, 0, 0, 0), 8.0) for number in (1, 2)}


def test_time_by_tool_and_operation_is_that_of_the_rows() -> None:
    """A remark before a tool change heads what comes; a change after motion ends the operation before it."""
    options = {"tools": TOOLS, "tool_length": None, "split_at_stops": True}
    seen = study_of(TWO_TOOLS, **options)
    assert seen.program is not None
    assert seen.governing is not None
    found = {(one.tool, one.name): one for one in seen.operations}
    assert list(found) == [(1, "PLATE"), (1, "FACE"), (2, "RIM"), (2, "DRILL"), (1, "")]
    rows = verne_post.convert(TWO_TOOLS.encode(), MACHINE, seen.program.options).setpoints
    assert rows is not None
    lines = {
        (1, "PLATE"): (5, 6),
        (1, "FACE"): (8, 11),
        (2, "RIM"): (13, 17),
        (2, "DRILL"): (19, 20),
        (1, ""): (21, 23),
    }
    for key, (first, last) in lines.items():
        one = found[key]
        assert first <= one.first_line <= one.last_line <= last, key
        of_rows = CYCLE * np.count_nonzero((rows.line[1:] >= first) & (rows.line[1:] <= last))
        assert one.seconds == pytest.approx(of_rows, abs=1e-9), key
        assert seen.line[one.frame] == one.first_line
    assert found[2, "RIM"].standing == pytest.approx(0.25, abs=0.005)
    assert found[1, "PLATE"].rapid == pytest.approx(found[1, "PLATE"].seconds, abs=0.005)
    assert found[1, "FACE"].lost > 0.0
    assert seen.lines is not None
    assert seen.lines.at_feed[found[1, "FACE"].first_line : found[1, "FACE"].last_line + 1].sum() > 0.0
    at_feed = seen.governing.seconds[seen.governing.names.index("programmed feed")]
    assert seen.lines.at_feed.sum() == pytest.approx(at_feed, abs=1e-9)
    assert (seen.lines.at_feed <= seen.lines.feed + 1e-12).all()
    in_feed_moves = sum(one.seconds - one.rapid - one.standing for one in seen.operations)
    assert seen.lines.feed.sum() == pytest.approx(in_feed_moves, abs=1e-9)
    for name, column in (("seconds", "seconds"), ("lost", "lost")):
        together = sum(getattr(one, name) for one in seen.operations)
        assert together == pytest.approx(getattr(seen.governing, column).sum(), abs=1e-9), name
    page = re.sub("<[^>]*>+", "|", write_times_html(seen))
    assert re.search(rf"\|T2\|+{found[2, 'RIM'].seconds + found[2, 'DRILL'].seconds:.3f}\|", page)
    assert re.search(rf"\|RIM\|+13 to 17\|+{found[2, 'RIM'].seconds:.3f}\|", page)


CALLS = """O0001 (TWO SIDES)
G21 G90 G17 G94
T1 M6
G0 X0 Y0 Z20 A0 C0
(LEFT SIDE)
G0 X-20
M98 P1001
(RIGHT SIDE)
G0 X20
M98 P1001
M98 P1001
G0 Z40
M30
O1001
M98 P1002
M99
O1002
(PECKS)
G91 G1 Z-18 F1200
(BACK)
G1 Z18
G90
M99
"""


def test_the_time_in_a_subprogram_is_that_of_the_operation_that_calls() -> None:
    """Without one, the comments in the subprogram head operations; those never head the program itself."""
    seen = study_of(CALLS, dialect="fanuc")
    assert seen.lines is not None
    found = {one.name: one for one in seen.operations}
    assert list(found) == ["LEFT SIDE", "RIGHT SIDE"]
    assert [(one.first_line, one.last_line) for one in found.values()] == [(6, 7), (9, 12)]
    in_calls = seen.lines.seconds[19] + seen.lines.seconds[21]
    for name, calls, own in (("LEFT SIDE", 1, [6]), ("RIGHT SIDE", 2, [9, 12])):
        expected = in_calls * calls / 3 + seen.lines.seconds[own].sum()
        assert found[name].seconds == pytest.approx(expected, rel=0.01), name
    plain = study_of(re.sub(r"\(.* SIDE\)\n", "", CALLS), dialect="fanuc")
    assert plain.lines is not None
    found = {one.name: one for one in plain.operations}
    assert list(found) == ["", "PECKS", "BACK"]
    assert [found[name].seconds for name in ("PECKS", "BACK")] == pytest.approx(plain.lines.seconds[[17, 19]])
    assert (found[""].first_line, found[""].last_line) == (5, 10)


def test_operations_of_a_part_are_the_same_in_three_languages() -> None:
    """Subprograms stand before the program, after it, and in a section of their own."""
    seconds = []
    for ending in ("nc", "h", "mpf"):
        name = f"two_faces.{ending}"
        seen = study_of((SAMPLES / name).read_bytes(), source_name=name)
        assert all(one.name for one in seen.operations)
        seconds.append([one.seconds for one in seen.operations])
    assert len(seconds[0]) == 4
    assert seconds[0] == seconds[1] == seconds[2]


def test_an_operation_without_a_remark_has_that_of_its_tool() -> None:
    seen = study_of("(T3 D16 ENDMILL)\nG21 G90 F900\nT3 M6\nG0 X0 Y0 Z50 A0 C0\nG1 X5\nM2\n")
    assert [one.name for one in seen.operations] == [""]
    assert ">D16 ENDMILL</button>" in write_times_html(seen)


def test_of_many_operations_the_longest_are_shown_and_the_rest_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("verne_post.report.times.OPERATIONS", 2)
    seen = study_of(
        "G21 G90 F900\nG0 X0 Y0 Z0 A0 C0\n" + "".join(f"(CUT {k})\nG1 X{k * k}\n" for k in range(1, 6)) + "M2\n"
    )
    text = re.sub("<[^>]*>+", "|", write_times_html(seen))
    assert re.findall(r"CUT \d|without a remark", text) == ["CUT 4", "CUT 5"]
    short = [one.seconds for one in seen.operations if one.name not in ("CUT 4", "CUT 5")]
    assert re.search(rf"\|3 shorter operations\|+{sum(short):.3f}\|", text)


def test_what_is_lost_at_stops_and_at_corners_is_told_apart() -> None:
    """Squares with exact stops lose everything there; blended ones next to nothing, but at begin and end and in the
    corners.
    """
    body = "G0 X0 Y0 Z0 A0 C0\nG1 X20 F3000\nY20\nX0\nY0\nM2\n"
    exact, blended = (study_of(f"G21 G90 {mode}\n{body}").governing for mode in ("G61.1", "G64 P0.05"))
    assert exact is not None
    assert blended is not None
    assert exact.at_stops.sum() == pytest.approx(exact.lost.sum(), abs=1e-9)
    assert 0.0 < blended.at_stops.sum() < 0.6 * exact.at_stops.sum()
    assert blended.lost.sum() - blended.at_stops.sum() > 0.02
    assert (blended.at_stops <= blended.lost + 1e-12).all()


@pytest.mark.parametrize("block", [13, 23])
def test_blocks_of_rows_change_nothing(monkeypatch: pytest.MonkeyPatch, block: int) -> None:
    """Stretches below the feed rate go on from block to block."""
    options = {"tools": TOOLS, "tool_length": None, "split_at_stops": True}
    whole = study_of(TWO_TOOLS, **options)
    monkeypatch.setattr("verne_post.base.columns.BLOCK_ROWS", block)
    parts = study_of(TWO_TOOLS, **options)
    for name in ("seconds", "rapid", "lost", "at_stops", "won", "reached"):
        ours, theirs = getattr(whole.governing, name), getattr(parts.governing, name)
        assert ours == pytest.approx(theirs, abs=1e-9), name
    for one, other in zip(whole.operations, parts.operations, strict=True):
        assert (one.tool, one.name, one.first_line, one.last_line, one.frame) == (
            other.tool,
            other.name,
            other.first_line,
            other.last_line,
            other.frame,
        )
        assert one.seconds == pytest.approx(other.seconds)


@pytest.mark.parametrize(
    ("limit", "joint", "within"), [("velocity", "c", 0.1), ("jerk", "c", 0.8), ("acceleration", "c", 0.8)]
)
def test_what_more_of_a_limit_would_win_is_what_planning_with_it_wins(limit: str, joint: str, within: float) -> None:
    """The estimate takes each row by itself. Where one limit costs much it is good; of small sums it says the size."""
    source, options = (
        (SAMPLES / "blade_5axis.nc").read_bytes(),
        Options(tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 10.0))}),
    )
    seen = study(source, MACHINE, options)
    assert seen.governing is not None
    more = getattr(MACHINE.limits, limit).copy()
    more[[column.joint for column in MACHINE.columns].index(joint)] *= HIGHER
    faster = study(source, replace(MACHINE, limits=replace(MACHINE.limits, **{limit: more})), options)
    won = seen.governing.won[seen.governing.names.index(f"{limit} of {joint}")]
    assert won == pytest.approx(seen.x[-1] - faster.x[-1], rel=within)
    assert won > 0.01


def test_a_higher_feed_rate_wins_what_the_table_says() -> None:
    source = (SAMPLES / "pocket_3axis.nc").read_text()
    options = Options(tool_length=80.0, wcs={1: WorkOffset((-10.0, 15.0, 60.0))})
    seen = study(source.encode(), MACHINE, options)
    faster = study(re.sub(r"F(\d+)", lambda word: f"F{HIGHER * float(word[1]):g}", source).encode(), MACHINE, options)
    assert seen.governing is not None
    won = seen.governing.won[seen.governing.names.index("programmed feed")]
    assert won == pytest.approx(seen.x[-1] - faster.x[-1], rel=0.02)


def test_the_reached_feed_is_a_histogram_of_all_feed_moves() -> None:
    seen = study_of("G21 G90\nG0 X0 Y0 Z0 A0 C0\nG61.1\nG1 X10 F600\nX20 F60000\nG4 P1\nG0 X0\nM2\n")
    governing = seen.governing
    assert governing is not None
    rows = seen.curves["feed"][0]
    assert np.isfinite(rows.values).any()
    # the first move is at its 10 mm/s for a second; the second never comes near its 1000 mm/s, and standstills do not
    # count
    assert governing.reached[-1] == pytest.approx(1.0, abs=0.05)
    spent = {one.name: one for one in seen.operations}[""]
    assert governing.reached.sum() == pytest.approx(spent.seconds - spent.rapid - spent.standing, abs=1e-9)
    assert governing.reached[:4].sum() > 0.05
    text = re.sub("<[^>]*>+", "|", write_reached_html(seen))
    assert re.search(rf"\|99 % or more\|+{governing.reached[-1]:.3f}\|", text)


# --- the spectrum ----------------------------------------------------------------------------------


def test_a_sine_is_in_its_band() -> None:
    n, cycle, hertz, amplitude = 20_000, 0.001, 30.0, 0.02
    t = cycle * np.arange(n + 1)
    values = np.stack([amplitude * np.sin(2 * np.pi * hertz * t), 0 * t], axis=1)
    seen = measure_spectrum(values, cycle)
    assert seen is not None
    band = int(np.searchsorted(seen.edges, hertz, side="right")) - 1
    # half the square of the amplitude of the acceleration; differences over a cycle see a sine a little smaller
    expected = amplitude * (2 * np.sin(np.pi * hertz * cycle) / cycle) ** 2 / np.sqrt(2)
    assert seen.rms[0, band] == pytest.approx(expected, rel=1e-2)
    assert np.delete(seen.rms[0], band).max() < 0.05 * expected
    assert not seen.rms[1].any()


def test_a_long_program_has_the_spectrum_of_its_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bands of noise, which has no lines that would fall on the other side of an edge, are those of the whole."""
    rng = np.random.default_rng(11)
    values = np.cumsum(np.cumsum(rng.normal(size=(60_001, 2)), axis=0), axis=0) * 1e-6
    whole = measure_spectrum(values, 0.001)
    monkeypatch.setattr("verne_post.report.spectrum._PIECE", 20_000)
    pieces = measure_spectrum(values, 0.001)
    assert whole is not None
    assert pieces is not None
    wide = whole.edges[:-1] > 5.0  # bands of many frequencies even in a piece
    assert pieces.rms[:, wide] == pytest.approx(whole.rms[:, wide], rel=0.05)
    # nothing is lost between pieces: white noise of the second differences has its mean square
    assert (pieces.rms**2).sum(axis=1) == pytest.approx((whole.rms**2).sum(axis=1), rel=1e-3)


@pytest.mark.parametrize("n", [4000, 4001])
def test_bands_add_up_to_the_whole(n: int) -> None:
    rng = np.random.default_rng(7)
    values = np.cumsum(np.cumsum(rng.normal(size=(n + 1, 2)), axis=0), axis=0) * 1e-6
    seen = measure_spectrum(values, 0.001)
    assert seen is not None
    acceleration = np.diff(values, 2, axis=0, prepend=values[:1]) / 0.001**2
    lines = np.fft.rfft(acceleration, axis=0) / n
    below = np.fft.rfftfreq(n, 0.001) < seen.edges[0]
    slow = (np.abs(lines[below]) ** 2 * np.where(np.arange(below.sum()) == 0, 1.0, 2.0)[:, None]).sum(axis=0)
    assert (seen.rms**2).sum(axis=1) + slow == pytest.approx((acceleration**2).mean(axis=0), rel=1e-9)
    assert seen.edges[-1] == pytest.approx(500.0)


def test_too_short_for_a_spectrum() -> None:
    assert measure_spectrum(np.zeros((100, 5)), 0.001) is None


# --- words -------------------------------------------------------------------------------------------

STATES = (
    "G21 G90 G64 P0.02\n"
    "T3 M6\n"
    "G43 H3\n"
    "G54\n"
    "S900 M3\n"
    "M8\n"
    "G0 X0 Y0 Z20 A0 C0\n"
    "G1 X5 F300\n"
    "G2 X10 Y5 I5 J0\n"
    "M4\n"
    "M9\n"
    "G55\n"
    "G61\n"
    "G0 Z30\n"
    "M2\n"
)


def test_only_moves_that_turn_have_feed_rates_in_degrees() -> None:
    """A full circle too ends where it begins."""
    seen = study_of("G21 G90 G17 F900\nG0 X0 Y0 Z0 A0 C0\nG1 X6\nG3 X6 Y0 I-6 J0\nG1 A-3\nG1 X9 A0\nM2\n")
    assert seen.program is not None
    moves = seen.program.moves
    told = {int(line): describe_feed(moves, number) for number, line in enumerate(moves.line)}
    assert told == {2: "rapid", 3: "900 mm/min", 4: "900 mm/min", 5: "900 deg/min", 6: "900 mm/min"}


def test_modal_states_are_those_of_the_text() -> None:
    tools = {3: Tool(3, 1, (0.0, 0.0, 70.0, 0, 0, 0, 0, 0, 0), 8.0)}
    options = {
        "tools": tools,
        "tool_length": None,
        "wcs": {1: WorkOffset((0.0, 0.0, 40.0)), 2: WorkOffset((1.0, 2.0, 45.0))},
    }
    seen = study_of(STATES, **options)
    assert seen.program is not None
    states, of = collect_modal_states(seen.program.moves, seen.move, seen.program.path.first_move)
    said = {int(line): dict(states[of[np.flatnonzero(seen.line == line)[-1]]]) for line in np.unique(seen.line) if line}
    assert said[8] == {
        "motion": "straight feed",
        "feed": "300 mm/min",
        "spindle": "900/min clockwise",
        "coolant": "flood",
        "tool": "T3, length 70 mm",
        "work offset": "G54",
        "work plane": "not tilted",
        "corners": "blended within 0.02 mm",
    }
    assert said[9]["motion"] == "arc, clockwise"
    assert said[14]["motion"] == said[14]["feed"] == "rapid"
    assert said[14]["spindle"] == "900/min counterclockwise"
    assert said[14]["coolant"] == "off"
    assert said[14]["work offset"] == "G55"
    assert said[14]["corners"] == "exact path"
    assert re.search(
        r"set-up\s+states.nc.toml ",
        re.sub(
            "<[^>]*>",
            " ",
            write_sheet_html("states.nc", b"", MACHINE, study_of(STATES, **options, setup_source="states.nc.toml")),
        ),
    )
    sheet = re.sub("<[^>]*>", " ", write_sheet_html("states.nc", STATES.encode(), MACHINE, seen))
    assert re.search(rf"T3\s+70\s+8\s+900\s+{seen.x[-1]:.3f}\s+line 2, 0\.000 s ", sheet)
    assert re.search(r"program\s+states.nc, 15 lines ", sheet)
    assert re.search(rf"machine\s+{MACHINE.name}\s", sheet)
    assert re.search(r"G54\s+0\s+0\s+40\s+0\s+given", sheet)
    assert re.search(r"G55\s+1\s+2\s+45", sheet)
    assert f"{seen.q[0, 0]:.3f} mm" in sheet
    assert f"{seen.q[0, 3]:.4f} deg" in sheet
    record = re.sub("<[^>]*>", " ", write_record_html(STATES.encode(), MACHINE, seen))
    assert re.search(rf"program, SHA-256\s+{hashlib.sha256(STATES.encode()).hexdigest()[:16]}\s", record)
    assert re.search(rf"machine, SHA-256\s+{MACHINE.sha256[:16]}\s", record)
    # what is at most so much is rounded up, to what people read
    assert re.search(r"at most 0\.\d{4} mm and 0\.\d{4} deg from the programmed one", record)


@pytest.mark.parametrize(
    "name", ["a.nc", 'a"; } body { display: none } /* .nc', "</style><script>alert(1)</script>", "\\22 \n;é"]
)
def test_no_name_ends_a_string_of_the_style_sheet(name: str) -> None:
    written = write_css_string(name)
    assert re.fullmatch(r'"(?:[A-Za-z0-9]|\\[0-9a-f]+ )*"', written)
    read = re.sub(r"\\([0-9a-f]+) ", lambda code: chr(int(code[1], 16)), written[1:-1])
    assert read == make_printable(name)


def test_the_verdict_comes_first_and_says_what_is_assumed() -> None:
    good, bad = (
        study_of("G21 G90\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F600\nM2\n"),
        study_of("G21 G90\nG0 X0 Y0 Z0 A0 C0\nG1 A99 F600\nM2\n"),
    )
    warned = study_of("G21 G90\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F600\nM2\n", wcs={})
    measured = replace(MACHINE, provenance={**MACHINE.provenance, "limits": "measured"})
    for seen, word, assumed in (
        (good, "Can run", True),
        (warned, "Can run, with warnings", True),
        (bad, "Refused", False),
    ):
        text = re.sub("<[^>]*>", "|", write_verdict_html(MACHINE, seen))
        assert text.startswith(f"|{word}{', on assumed limits' * assumed}|")
        assert "spindle, table, limits" in text
        assert re.sub("<[^>]*>", "|", write_verdict_html(measured, seen)).startswith(
            f"|{word}{', on measured limits' * assumed}|"
        )
        assert "|tool length||80 mm|" in text
        assert "|work offset||G54 at 0, 0, " in text
    assert f"{good.x[-1]:.3f} s" in write_verdict_html(MACHINE, good)
    assert "1 error, " in write_verdict_html(MACHINE, bad)


def test_stops_inside_lines_are_named() -> None:
    """A hole in pecks has many motions in line 3; the moves around it, and a dwell at the bottom, do not count."""
    head = "G21 G90\nG0 X0 Y0 Z20 A0 C0\n"
    drilled = study_of(head + "G83 X10 Y0 Z-9 R2 Q3 F300\nG80\nG0 X0\nM2\n")
    assert drilled.summary is not None
    within = drilled.summary.stops_within
    assert within.line == 3
    assert within.count == within.most > 5
    place = next(place for place in find_worst_places(MACHINE, drilled) if place.what == "most stops within a line")
    assert (place.about, place.value) == ("line 3", f"{within.most} stops")
    assert drilled.line[place.frame] == 3
    lost = [one for one in find_worst_places(MACHINE, drilled) if one.what == "time lost against the feed rate"]
    assert [re.sub(r"\d+ places", "N places", one.about.split(", ", 1)[1]) for one in lost] == [
        "jerk of rho1, at N places"
    ]
    assert drilled.governing is not None
    assert lost[0].value == f"{drilled.governing.lost_from_frame.sum():.3f} s"
    text = " ".join(format_summary(drilled.summary).split())
    assert f" stops, of which {within.count} are inside line 3" in text
    for body in ("G1 X10 F300\nG4 P0.1\nG1 X20\nG0 X0\n", "G61\nG1 X10 F300\nX10 Y10\nX0\n"):
        plain = study_of(head + "G49\n" + body + "M2\n")
        assert plain.summary is not None
        assert plain.summary.n_stops > 0
        assert plain.summary.stops_within.count == 0
        assert "of which" not in format_summary(plain.summary)
        assert not any("stops" in place.what for place in find_worst_places(MACHINE, plain))


def test_worst_places_are_where_the_rows_are_worst() -> None:
    source = (SAMPLES / "pocket_3axis.nc").read_bytes()
    options = Options(tool_length=80.0, wcs={1: WorkOffset((-10.0, 15.0, 60.0))})
    seen = study(source, MACHINE, options)
    rows = verne_post.convert(source, MACHINE, options).setpoints
    assert rows is not None
    found = list(find_worst_places(MACHINE, seen))
    places = {place.what: place for place in found}
    slow = [place.about for place in found if place.what == "time lost against the feed rate"]
    assert slow
    assert all(re.fullmatch(r"line \d+, [a-z ]+\d?|lines \d+ to \d+, [a-z ]+\d?", about) for about in slow), slow
    values = np.pad(rows.values, ((3, 0), (0, 0)), mode="edge")
    for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1):
        limit = getattr(MACHINE.limits, name) * np.abs([column.factor for column in MACHINE.columns])
        share = np.abs(np.diff(values, order, axis=0)[3 - order :]) / CYCLE**order / limit
        place = places[f"peak {name}"]
        assert place.about.endswith(f", allowed {(100.1, 100.5, 102)[order - 1]} %")
        assert place.value == f"{100 * share.max():.1f} % of limit"
        row = int(np.unravel_index(share.argmax(), share.shape)[0])
        assert seen.x[place.frame] <= row * CYCLE + 1e-9
        assert row * CYCLE < seen.x[min(place.frame + 1, len(seen.x) - 1)] + CYCLE
    least = np.nanmin(seen.curves["margin"][0].values)
    assert float(places["smallest margin"].value) == pytest.approx(least, abs=5e-4)


def test_a_tool_has_one_row_with_the_length_it_works_with() -> None:
    """CAM posts move X and Y after M6 under the length of the tool before: that one is a note below the tools."""
    program = "G21 G90\nT1 M6\nG0 X0 Y0 A0 C0\nG43 Z90 H1\nG1 Z80 F600\nT2 M6\nG0 X5\nG43 Z95 H2\nG1 X10 F600\nM2\n"
    tools = {n: Tool(n, n, (0.0, 0.0, length, *6 * (0.0,)), 6.0) for n, length in ((1, 80.0), (2, 95.0))}
    study = study_of(program, tool_length=None, tools=tools, split_at_stops=True)
    assert dict(list_setup(MACHINE, study))["tool length"] == "T1: 80 mm; T2: 95 mm"
    assert [row[1:3] for row in list_tools(study)] == [("T1", "80"), ("T2", "95")]
    sheet = write_sheet_html("p.nc", program.encode(), MACHINE, study)
    said = (
        "before the tool&#x27;s own length is active have that of the tool before. T2 has 80 mm: its tip is 15 mm lower"
    )
    assert f"<p>Rapids {said} than the program says.</p>" in sheet
    lowered = study_of(program.replace("G0 X5", "G0 X5 Z-5"), tool_length=None, tools=tools, split_at_stops=True)
    assert [one.code for one in lowered.findings if one.line == 7] == ["VP034"]
    sheet = write_sheet_html("p.nc", program.encode(), MACHINE, lowered)
    assert f"<p>Danger: rapids {said} than the program says.</p>" in sheet
    program = program.replace("T2 M6\nG0 X5", "G1 Z90\nT2 M6\nG1 X5")  # without the retract it is an error
    fed = study_of(program, tool_length=None, tools=tools, split_at_stops=True)
    assert dict(list_setup(MACHINE, fed))["tool length"] == "T1: 80 mm; T2: 80 then 95 mm"
    assert len(list_tools(fed)) == 2
    assert "tool before" not in write_sheet_html("p.nc", program.encode(), MACHINE, fed)
