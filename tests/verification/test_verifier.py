"""The verifier passes what is right in any block size, and refuses every way in which a file can be wrong."""

import io
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs

import verne_post
from verne_post.app.assemble import Program, assemble
from verne_post.app.verify import verify_setpoints
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.verification import Verification
from verne_post.output.expected import Expected
from verne_post.output.rounding import choose_setpoint_format
from verne_post.output.setpoints import read_csv, write_csv_header, write_csv_rows

from ..builders import MACHINE, OPTIONS

Table = tuple[np.ndarray, np.ndarray]

WHOLE = 10**9  # one block


def program(body: str, head: str = "G21 G90 G94 G17 G61.1") -> bytes:
    """A program; line 1 is the head, the body begins on line 2."""
    return f"{head}\n{body}\nM2\n".encode()


MADE: dict[tuple[bytes, str], Table] = {}


def made(source: bytes, options: Options = OPTIONS) -> Table:
    """Setpoints and lines of a program, made once; not to be written to."""
    key = (source, repr(options))
    if key not in MADE:
        result = verne_post.convert(source, MACHINE, options)
        assert result.ok, [item.message for item in result.findings]
        assert result.setpoints is not None
        MADE[key] = result.setpoints.values, result.setpoints.line
    return MADE[key]


ASKED: dict[tuple[bytes, str], Program] = {}


def ask(source: bytes, options: Options) -> Program:
    """What a program asks for; kept, because most are asked for in several ways one after the other."""
    key = (source, repr(options))
    if key not in ASKED:
        if len(ASKED) == 8:
            ASKED.clear()
        ASKED[key] = assemble(source, MACHINE, options)
    return ASKED[key]


def verify_rows(
    source: bytes,
    values: np.ndarray,
    line: np.ndarray,
    options: Options = OPTIONS,
    block: int = WHOLE,
    fmt: SetpointFormat | None = None,
) -> Verification:
    """The verdict on rows that are fed in blocks."""
    asked = ask(source, options)
    fmt = fmt or choose_setpoint_format(MACHINE, asked.cycle, options.decimals, accept_rounding=True)
    fmt = structs.replace(fmt, header_lines=1)
    blocks = (
        SetpointBlock(first, values[first : first + block], line[first : first + block], fmt)
        for first in range(0, len(values), block)
    )
    return verify_setpoints(asked, blocks)


def codes(verdict: Verification) -> set[str]:
    return {item.code for item in verdict.findings}


# --- a good file, spoilt ------------------------------------------------------------------------

# lines: 2 start, 3 down, 4 out, 5 dwell, 6 sideways with a turn, 7 full circle, 8 out, 9 back the same way, 10 up
BODY = """G0 X0 Y0 Z24 A0 C0
Z22
G1 X4 F2000
G4 P0.05
Y3 A4 C5
G2 I1 J0 F1500
G1 X5
X4
G0 Z24"""
SOURCE = program(BODY)
# stops at vertical tool, without rotation
UPRIGHT = program("G0 X0 Y0 Z40 A0 C0\nG1 Z36 F1500\nX10\nG0 Z40")


def rows_of(line: np.ndarray, number: int) -> np.ndarray:
    found = np.flatnonzero(line == number)
    assert len(found)
    return found


def moved(values: np.ndarray, line: np.ndarray) -> Table:
    values[rows_of(line, 4)[100], 0] += 0.01
    return values, line


def exchanged(values: np.ndarray, line: np.ndarray) -> Table:
    k = rows_of(line, 6)[50]
    values[[k, k + 1]] = values[[k + 1, k]]
    return values, line


def without(number: int) -> Callable[..., Table]:
    def change(values: np.ndarray, line: np.ndarray) -> Table:
        rows = rows_of(line, number)
        return np.delete(values, rows, axis=0), np.delete(line, rows)

    return change


def twice(number: int) -> Callable[..., Table]:
    def change(values: np.ndarray, line: np.ndarray) -> Table:
        rows = rows_of(line, number)
        return np.insert(values, rows[0], values[rows], axis=0), np.insert(line, rows[0], line[rows])

    return change


def shorter_dwell(rows: int) -> Callable[..., Table]:
    def change(values: np.ndarray, line: np.ndarray) -> Table:
        dwell = rows_of(line, 5)[10 : 10 + rows]
        return np.delete(values, dwell, axis=0), np.delete(line, dwell)

    return change


def out_and_back_left_out(values: np.ndarray, line: np.ndarray) -> Table:
    """Lines 8 and 9 end where they begin, so nothing jumps."""
    rows = np.concatenate([rows_of(line, 8), rows_of(line, 9)])
    return np.delete(values, rows, axis=0), np.delete(line, rows)


def turned(degrees: float) -> Callable[..., Table]:
    def change(values: np.ndarray, line: np.ndarray) -> Table:
        values[:, 4] += degrees
        return values, line

    return change


def relined(old: int, new: int) -> Callable[..., Table]:
    def change(values: np.ndarray, line: np.ndarray) -> Table:
        line[line == old] = new
        return values, line

    return change


def raised(values: np.ndarray, line: np.ndarray) -> Table:
    """Every slider 0.002 mm lower: a smooth motion, 0.002 mm beside the path."""
    values[:, :3] += 0.002
    return values, line


TAMPERED: dict[str, tuple[Callable[..., Table], set[str]]] = {
    "twenty identical rows": (lambda q, n: (np.repeat(q[:1], 20, axis=0), np.repeat(n[:1], 20)), {"VP412", "VP413"}),
    "cut in half": (lambda q, n: (q[: len(q) // 2], n[: len(n) // 2]), {"VP412"}),
    "one row moved": (moved, {"VP402", "VP403", "VP411"}),
    "two rows exchanged": (exchanged, {"VP413", "VP403"}),
    "starts at full speed": (lambda q, n: (q[60:], n[60:]), {"VP412", "VP403"}),
    "first row dropped": (lambda q, n: (q[1:], n[1:]), {"VP403"}),
    "last ten rows dropped": (lambda q, n: (q[:-10], n[:-10]), {"VP412"}),
    "stops at full speed": (lambda q, n: (q[:-60], n[:-60]), {"VP412"}),
    "last line left out": (without(10), {"VP412"}),
    "dwell one cycle short": (shorter_dwell(1), {"VP412"}),
    "dwell shortened": (shorter_dwell(20), {"VP412"}),
    "dwell left out": (without(5), {"VP413"}),
    "one segment left out": (without(6), {"VP413"}),
    "full circle left out": (without(7), {"VP413"}),
    "out and back left out": (out_and_back_left_out, {"VP413"}),
    "rows of a line repeated": (twice(6), {"VP413"}),
    "rows of a full circle repeated": (twice(7), {"VP413"}),
    "rows of the first line repeated": (twice(3), {"VP413"}),
    "rows of the last line repeated": (twice(10), {"VP413"}),
    "C a turn further": (turned(360.0), {"VP411"}),
    "C 0.01 deg further": (turned(0.01), {"VP411"}),
    "0.002 mm off throughout": (raised, {"VP411"}),
    "all lines one further": (lambda q, n: (q, n + 1), {"VP413"}),
    "one line under another's number": (relined(6, 7), {"VP413"}),
    "an unknown line": (relined(8, 80), {"VP413"}),
    "a negative line": (relined(8, -8), {"VP413"}),
    "a dwell under the next line's number": (relined(5, 6), {"VP413"}),
    "the first row alone": (lambda q, n: (q[:1], n[:1]), {"VP412"}),
}


@pytest.mark.parametrize("how", TAMPERED)
def test_tampered_file_fails(how: str) -> None:
    values, line = made(SOURCE)
    change, expected = TAMPERED[how]
    values, line = change(values.copy(), line.copy())
    found = codes(verify_rows(SOURCE, values, line, block=100))
    if how == "twenty identical rows":
        assert found & expected
    else:
        assert expected <= found


@pytest.mark.parametrize("missing", [1, 60, 200])
def test_a_file_that_ends_in_motion_is_one_finding(missing: int) -> None:
    """The joints that do not come to rest behind its end are no causes of their own."""
    source = program("G0 X0 Y0 Z20 A0 C0\nG1 X30 F9000\nY20 A5")
    values, line = made(source)
    last = int(np.flatnonzero(line == 3)[-1])  # in the middle of the last line for some
    cut = last + 100 - missing
    verdict = verify_rows(source, values[:cut], line[:cut])
    assert [item.code for item in verdict.findings] == ["VP412"]
    assert "the file ends" in verdict.findings[0].message
    assert verdict.jerk_ratio.max() < 1.02


@pytest.mark.parametrize("degrees", [0.01, -0.01, 360.0, -360.0])
def test_turned_rotary_under_a_vertical_tool_on_the_axis_fails(degrees: float) -> None:
    """At X0 Y0 and A0 the tip and the tool axis do not feel C: only the angle itself tells."""
    source = program("G0 X0 Y0 Z40 A0 C0\nG1 Z30 F1000\nG0 Z40")
    values, line = made(source)
    values = values.copy()
    values[:, 4] += degrees
    verdict = verify_rows(source, values, line)
    assert codes(verdict) == {"VP411"}
    assert any("rotary angle" in item.message for item in verdict.findings)


#: A blended corner on each side of a dwell, and a stop before the last move; the tolerance is 0.1 mm.
STANDING = "G0 X0 Y0 Z{0} A0 C0\nG1 X6 F1500\nY6 Z{1}\nG4 P0.01\nX12\nY12 Z{2}\nG61\nX18\nY18 Z{3}\nG0 X24"


@pytest.mark.parametrize("off", [0.0, 0.0009, 0.002, 0.05, 0.09, -0.002])
@pytest.mark.parametrize("which", [0, 1, 2, 3, None])
def test_no_corner_reaches_to_where_the_machine_stands_still(which: int | None, off: float) -> None:
    """Start, dwell, stop, end, or the whole file for another Z offset: all within the tolerance of the corners."""
    places = [40.0, 40.0, 40.0, 40.0]
    other = [z + off * (which in (None, k)) for k, z in enumerate(places)]
    head = "G21 G90 G94 G17 G64 P0.1"
    source = program(STANDING.format(*places), head)
    verdict = verify_rows(source, *made(program(STANDING.format(*other), head)))
    if abs(off) < 0.001:
        assert verdict.ok
    else:
        assert "VP411" in codes(verdict)


def test_finding_names_row_line_column_and_numbers() -> None:
    values, line = made(UPRIGHT)
    values = values.copy()
    row = rows_of(line, 4)[200]
    values[row, 1] += 0.01
    verdict = verify_rows(UPRIGHT, values, line, block=100)
    jerk = next(item for item in verdict.findings if item.code == "VP403")
    assert (jerk.line, jerk.axis, jerk.unit, jerk.limit) == (4, "rho2", "mm/s3", 100000.0)
    # 0.01 mm in one row is 0.01, 0.03, 0.03, 0.01 mm in the third differences; the motion adds at most its own limit
    assert jerk.value == pytest.approx(0.01 / 1e-9, abs=1.02e5)
    assert jerk.message == (
        f"row {row} (line {row + 2} of the file): the jerk of joint rho2 is {jerk.value / 1e5:.4g} times its limit of "
        f"100000 mm/s3 (the first of 4 rows; the worst is row {row + 1}: {verdict.jerk_ratio[1]:.4g} times its limit)"
    )
    assert verdict.jerk_ratio[1] == pytest.approx(300.0, abs=1.02)
    assert verdict.jerk_ratio[0] <= 1.02


def test_a_file_that_is_off_by_one_vector_is_of_another_set_up() -> None:
    """The vector is said where most standstills agree on it, and not of a file with one place beside its path."""
    made_at = OPTIONS.changed(wcs={1: WorkOffset((3.0, -4.0, 100.0))})
    base = OPTIONS.changed(wcs={1: WorkOffset((0.0, 0.0, 100.0))})
    values, line = made(UPRIGHT, made_at)
    off = [item.message for item in verify_rows(UPRIGHT, values, line, base).findings if item.code == "VP411"]
    assert any("the tip is 5 mm off the programmed segment, allowed 0.001 mm (" in text for text in off)
    assert any("the tip is off by X3.000 Y-4.000 Z0.000 mm on the table at every standstill" in text for text in off)
    again, _line = moved(made(UPRIGHT, base)[0].copy(), line)
    off = [item.message for item in verify_rows(UPRIGHT, again, line, base).findings if item.code == "VP411"]
    assert off
    assert not any("the tip is off by" in text for text in off)
    # a last row that is elsewhere is one standstill of several
    ends = np.vstack([values[:-1], made(UPRIGHT, base)[0][-1:]])
    off = [item.message for item in verify_rows(UPRIGHT, ends, line, base).findings if item.code == "VP411"]
    assert any(
        re.search(r"off by X3.000 Y-4.000 Z0.000 mm on the table at (\d+) of \d+ standstills", text) for text in off
    )


def test_rows_of_another_program_are_called_so() -> None:
    """Their lines are in another order, or nearly every row is off; a program with one move elsewhere is none."""
    moves = "G0 X0 Y0 Z40 A0 C0\nG1 X3 F3000\nG1 Y{0}\nG1 X0\nG0 Z42"
    other = "G0 X20 Y{0} Z60 A0 C0\nG1 X40 Y9 F3000\nG1 Y30\nG1 X50\nG0 Z80"
    said = "these are rows of another program, or were made with other options or set-up"
    ours = program(moves.format(8))
    strange = verify_rows(ours, *made(program(other.format(5))))
    assert any(said in item.message for item in strange.findings)
    # what follows from that is no finding of its own
    others = [item.code for item in strange.findings if said not in item.message and item.code != "VP411"]
    assert not {"VP404", "VP412", "VP413"}.intersection(others)
    values, line = made(ours)
    values = values.copy()
    values[len(values) // 2, 1] += 0.01
    bump = verify_rows(ours, values, line)
    assert not bump.ok
    assert not any(said in item.message for item in bump.findings)


@pytest.mark.parametrize(("change", "said"), [(-1.0, "1.000 mm shorter"), (2.0, "2.000 mm longer")])
def test_rows_for_another_tool_length_name_it(change: float, said: str) -> None:
    """They had three symptoms and no cause; where the tool axis turns, no work offset makes them fit."""
    source = program("G0 X0 Y0 Z40 A0 C0\nG1 X3 F3000\nA-10 C20\nY8 A-20 C30\nX0 A-15 C10\nG0 Z42")
    assert OPTIONS.tool_length is not None
    longer = OPTIONS.changed(tool_length=OPTIONS.tool_length + change)
    told = [one.message for one in verify_rows(source, *made(source, longer)).findings if one.code == "VP411"]
    assert any(f"fit a tool that is {said}, at every standstill: they were made with another" in text for text in told)
    assert not any("work offset" in text for text in told)


def test_rows_that_begin_aside_and_are_mostly_off_are_of_another_set_up() -> None:
    """Without standstills, the vector is not known; rows that begin well and go wrong later are no such case."""
    source = program("G0 X0 Y0 Z40 A0 C0\nG1 Y20 F3000\nX90\nY30", "G21 G90 G94 G17 G64 P0.01")
    said = "the first row and most others do not fit: these are rows of another program, or were made with other"
    values, line = made(source, OPTIONS.changed(wcs={1: WorkOffset((0.0, 3.0, 100.0))}))
    base = OPTIONS.changed(wcs={1: WorkOffset((0.0, 0.0, 100.0))})
    part = 3 * len(line) // 4
    found = verify_rows(source, values[:part], line[:part], base).findings
    assert [said in one.message for one in found if one.code == "VP411"] == [True]
    late = made(source, base)[0].copy()
    late[len(late) // 4 :, 1] += 0.01
    assert not any(said in one.message for one in verify_rows(source, late, line, base).findings)


def test_line_0_is_no_line_of_the_program() -> None:
    values, line = made(UPRIGHT)
    found = verify_rows(UPRIGHT, values, np.zeros_like(line)).findings
    assert [(item.code, item.line) for item in found] == [("VP413", None)]
    assert "the rows begin with an approach, and the program has none" in found[0].message
    assert "another program" not in found[0].message
    late = np.where(np.arange(len(line)) < len(line) // 2, line, 0)
    late_text = verify_rows(UPRIGHT, values, late).findings[0].message
    assert "it belongs to line 0, where the program goes on with line " in late_text


@pytest.mark.parametrize(("degrees", "fine"), [(0.0005, True), (0.002, False), (-0.01, False)])
def test_tilt_about_the_tip_is_checked(degrees: float, fine: bool) -> None:
    """The tip stays on its path: only the tool axis tells. 0.001 degrees is the bound."""
    moves = "G0 X0 Y0 Z40 A{0} C10\nG1 X3 F3000\nG0 Z42"
    verdict = verify_rows(program(moves.format(5)), *made(program(moves.format(5 + degrees))))
    assert verdict.axis_deviation_deg == pytest.approx(abs(degrees), rel=1e-3)
    assert codes(verdict) == (set() if fine else {"VP411"})
    if not fine:
        assert any("tool axis" in item.message for item in verdict.findings)


@pytest.mark.parametrize(
    ("which", "code", "ratio"),
    [("velocity", "VP401", 1.001), ("acceleration", "VP402", 1.005), ("jerk", "VP403", 1.02)],
)
def test_each_limit_has_its_own_bound(which: str, code: str, ratio: float) -> None:
    """Against a machine whose limit is so low that the file just passes, or just does not."""
    values, line = made(SOURCE)
    worst = getattr(verify_rows(SOURCE, values, line), f"{which}_ratio")
    fmt = choose_setpoint_format(MACHINE, 0.001, None, accept_rounding=False)
    for scale, found in ((0.9995, set()), (1.0005, {code})):
        low = getattr(MACHINE.limits, which) * worst / (ratio * scale)
        machine = replace(MACHINE, limits=replace(MACHINE.limits, **{which: low}))
        asked = assemble(SOURCE, machine, OPTIONS)
        verdict = verify_setpoints(asked, iter([SetpointBlock(0, values, line, fmt)]))
        assert codes(verdict) == found
        assert getattr(verdict, f"{which}_ratio") == pytest.approx(ratio * scale, rel=1e-9)
        assert {item.axis for item in verdict.findings} == ({"rho1", "rho2", "rho3", "a", "c"} if found else set())


def test_travel_is_checked_in_the_file() -> None:
    """A machine with less travel than the one the file was made for."""
    values, line = made(UPRIGHT)
    highest = float(values[:, 0].max())
    limits = MACHINE.limits
    narrow = replace(MACHINE, limits=replace(limits, upper=np.array([highest - 0.01, *limits.upper[1:]])))
    asked = assemble(UPRIGHT, narrow, OPTIONS)
    fmt = choose_setpoint_format(MACHINE, asked.cycle, None, accept_rounding=False)
    verdict = verify_setpoints(asked, iter([SetpointBlock(0, values, line, fmt)]))
    assert codes(verdict) == {"VP101"}
    assert verdict.findings[0].axis == "rho1"
    assert verdict.findings[0].limit == pytest.approx(highest - 0.01)


@pytest.mark.parametrize("missing", [1, 5, 20])
def test_dwell_at_the_end_that_is_too_short_fails(missing: int) -> None:
    """Nothing moves in these rows: only their number tells."""
    source = program("G0 X0 Y0 Z20 A0 C0\nG1 X1 F3000\nG4 P0.02")
    values, line = made(source)
    assert (line == 4).sum() == 21  # 20 cycles, and the last row of the file
    verdict = verify_rows(source, values[:-missing], line[:-missing], block=10)
    assert codes(verdict) == {"VP412"}


# --- a good file for something else -----------------------------------------------------------------

OTHER: dict[str, tuple[bytes, Options]] = {
    "a longer tool": (SOURCE, OPTIONS.changed(tool_length=80.02)),
    "another part position": (SOURCE, OPTIONS.changed(wcs={1: WorkOffset((0.0, 0.01, 50.0))})),
    "a turned part": (SOURCE, OPTIONS.changed(wcs={1: WorkOffset((0.0, 0.0, 50.0), 0.01)})),
    "another end point": (program(BODY.replace("G1 X4 F2000", "G1 X4.01 F2000")), OPTIONS),
    "another tilt": (program(BODY.replace("A4 C5", "A4.01 C5")), OPTIONS),
    "another rotary angle": (program(BODY.replace("A4 C5", "A4 C5.01")), OPTIONS),
    "a larger circle": (program(BODY.replace("I1", "I1.01")), OPTIONS),
    "a circle the other way": (program(BODY.replace("G2", "G3")), OPTIONS),
    "two turns": (program(BODY.replace("G2", "G2 P2")), OPTIONS),
    "one more line": (program(BODY + "\nX9"), OPTIONS),
    "one line less": (program(BODY.rsplit("\n", 1)[0]), OPTIONS),
    "a longer dwell": (program(BODY.replace("P0.05", "P0.0501")), OPTIONS),
    "a dwell more": (program(BODY.replace("\nX4\n", "\nG4 P0.001\nX4\n")), OPTIONS),
    "a dwell at the end": (program(BODY + "\nG4 P0.002"), OPTIONS),
}


@pytest.mark.parametrize("what", OTHER)
def test_file_of_another_program_fails(what: str) -> None:
    source, options = OTHER[what]
    verdict = verify_rows(source, *made(SOURCE), options)
    assert codes(verdict) & {"VP404", "VP411", "VP412", "VP413"}


@pytest.mark.parametrize("feed", ["F1500", "F90000", "G93 F120000"])
@pytest.mark.parametrize("turns", [1, 3])
def test_full_circle_that_stands_still_fails(feed: str, turns: int) -> None:
    """The rows of a closed segment rest at its start, under its line number; F120000 in G93 asks for half a cycle."""
    source = program(f"G0 X0 Y0 Z20 A0 C0\nG1 Z19 F900\n{feed} G2 I1 P{turns}\nG94 G0 Z20")
    values, line = made(source)
    assert verify_rows(source, values, line).ok
    values = values.copy()
    rows = rows_of(line, 4)
    values[rows] = values[rows[0]]
    verdict = verify_rows(source, values, line)
    assert codes(verdict) & {"VP404", "VP412", "VP413"}


@pytest.mark.parametrize("cut", [0.01, 0.1])
def test_corner_cut_fails(cut: float) -> None:
    """A chamfer at the corner of lines 3 and 4, made as a program of its own and given the lines of the corner."""
    corner = program("G0 X0 Y0 Z30 A0 C0\nG1 X10 F1000\nY10")
    chamfer = program(f"G0 X0 Y0 Z30 A0 C0\nG1 X{10 - cut} F1000\nX10 Y{cut}\nY10")
    values, line = made(chamfer)
    line = np.where(line == 5, 4, line).astype(line.dtype)
    verdict = verify_rows(corner, values, line)
    assert "VP411" in codes(verdict)
    assert verdict.tip_deviation_mm > 0.4 * cut  # the middle of the chamfer is cut / 2 from the nearer leg


# --- feed ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("feed", [1.0, 10.0, 100.0, 1000.0, 5000.0])
@pytest.mark.parametrize(("excess", "fine"), [(1.01, False), (0.9995, True)])
def test_feed_is_checked_at_any_speed(feed: float, excess: float, fine: bool) -> None:
    """A file that is legal in every joint, against the same program at a lower feed: 1.001 is the bound."""
    # two seconds of one straight move, or 20 mm
    moves = "G0 X0 Y0 Z20 A0 C0\nG1 X{:.6f} F{:.9f}"
    written = program(moves.format(min(feed / 30, 20.0), feed))
    asked = program(moves.format(min(feed / 30, 20.0), feed / excess))
    for block in (100, 8192):
        assert codes(verify_rows(asked, *made(written), block=block)) == (set() if fine else {"VP404"})


def test_faster_clock_exceeds_the_feed() -> None:
    """The same path 1.01 times as fast: made at a cycle of 1.01 ms, said to be one of 1 ms."""
    source = program("G0 X0 Y0 Z20 A0 C0\nG1 X20 F1000")
    slow = OPTIONS.changed(cycle=0.00101)
    fmt = choose_setpoint_format(MACHINE, 0.001, None, accept_rounding=False)
    assert verify_rows(source, *made(source, slow), slow).ok
    verdict = verify_rows(source, *made(source, slow), fmt=fmt)
    assert "VP404" in codes(verdict)
    # 1.01, less what the whole cycles cost: at most one cycle in 1.2 s
    assert verdict.feed_ratio == pytest.approx(1.01, rel=1e-3)


def test_rotary_only_feed_is_checked() -> None:
    """F is degrees per minute."""
    fast, slow = (program(f"G0 X0 Y0 Z20 A0 C0\nG1 C30 F{feed}") for feed in (1000, 990))
    assert verify_rows(fast, *made(fast)).ok
    assert codes(verify_rows(slow, *made(fast))) == {"VP404"}


@pytest.mark.parametrize(("feed", "fast"), [(87, False), (80, True)])
def test_the_last_step_before_a_dwell_may_cut_a_corner(feed: float, fast: bool) -> None:
    """From X0.09 to X0.1 Y0.01 in a cycle: 0.0141 mm, where the program goes 0.02. F87 is 0.0145 mm a cycle."""
    options = OPTIONS.changed(cycle=0.01)
    source = program(f"G0 X0 Y0 Z20 A0 C0\nG1 X.1 F{feed}\nY.01\nG4 P.01", head="G21 G90 G94 G17 G64 P.01")
    places = [f"X{0.01 * k:.2f}" for k in range(1, 10)]
    values, line = made(program("G0 X0 Y0 Z20 A0 C0\nG1 F1000\n" + "\n".join([*places, "X.1 Y.01"])))
    stops = np.flatnonzero(np.diff(line, append=0))
    rows = values[np.concatenate([[0], stops[-10:], stops[-1:]])]
    lines = np.array([3] * 10 + [5] * 2)
    assert ("VP404" in codes(verify_rows(source, rows, lines, options))) == fast


# --- what must pass, in any block size ---------------------------------------------------------------------

LAYERS = "\n".join(f"X{0.01 * k:.2f}" for k in range(1, 301))
#: For programs of more than a second: every row is a block of its own below.
FEW_ROWS = OPTIONS.changed(cycle=0.004)
PASSING: dict[str, tuple[str, Options]] = {
    "everything": (BODY, OPTIONS),
    "G28 with a via point": ("G0 X0 Y0 Z419 A0 C0\nG28 X10 Y10\nG0 X5 Y5 Z418", OPTIONS),
    "G28 at the head": ("G28 G91 Z0\nG90 G0 X0 Y0 Z418 A0 C0\nG1 X1 F900\nG28 G91 Z0", OPTIONS),
    "G30 of every axis": ("G0 X0 Y0 Z415 A0 C0\nG30", OPTIONS),
    "dwell and move on one line": ("G0 X0 Y0 Z20 A0 C0\nG1 X1 F900\nG4 P.1 G1 X4\nG4 P.05 X2", OPTIONS),
    "dwells in a row": (
        "G4 P.01\nG0 X0 Y0 Z20 A0 C0\nZ21\nG4 P.02\nG4 P.03\nG1 X2 F900\nG4 P0.05\nG4 P0.0001",
        OPTIONS,
    ),
    "full circles and turns": (
        "G0 X1 Y0 Z20 A0 C0\nG1 Z19.5 F900\nG2 I-1 F5000\nG3 I-.5 P3\nG2 X-1 I-1 Z20 P2\nG18 G3 X0 Z20 R.5",
        FEW_ROWS,
    ),
    "arcs with a turning table": (
        "G0 X3 Y0 Z20 A0 C0\nG3 X-3 I-3 A4 C20 F3000\nG3 X3 I3 A-2 C-10\nG2 I-3 C30 F9000",
        FEW_ROWS,
    ),
    "rotary only": ("G0 X3 Y0 Z20 A0 C0\nG1 C20 F9000\nA5\nC-4 A2\nG0 C0 A0", FEW_ROWS),
    "C turns under a vertical tool": ("G0 X0 Y0 Z20 A0 C350\nG1 C400 F30000", OPTIONS),
    "very slow": ("G0 X0 Y0 Z20 A0 C0\nG1 X0.01 F1\nG2 X0.01 I-0.01 F5", FEW_ROWS),
    "longer tool in the middle": (
        "G43.1 Z80\nG0 X0 Y0 Z30 A0 C0\nG1 X2 F900\nG4 P.02\nG43.1 Z79.5\nG4 P.02\nG1 Z29 F1500\nG0 Z30",
        OPTIONS.changed(tool_length=None),
    ),
    "another length between blended moves": (
        "G64 P.01 G43.1 Z80\nG0 X0 Y0 Z5 A0 C0\nG1 X5 F1000\nG43.1 Z100\nG1 X10\nG1 Y3\nG43.1 Z80.5\nX9\nY2 A2",
        OPTIONS.changed(tool_length=None),
    ),
    "another tool under tilt": (
        "G43.1 Z80\nG0 X0 Y0 Z30 A20 C10\nG1 X2 F900\nG43.1 Z82\nG4 P.02\nG0 X0 Y0 Z31\nG1 X1",
        OPTIONS.changed(tool_length=None),
    ),
    "approach from home": ("G4 P.01\nG0 X1 Y2 Z415 A1 C2\nG1 X2 F900", OPTIONS.changed(approach="home")),
    "approach from below": (
        "G0 X0 Y0 Z415 A0 C0\nG1 X1 F900",
        OPTIONS.changed(approach=(300.0, 250.0, 240.0, 5.0, -10.0)),
    ),
    "work offsets change": (
        "G0 X0 Y0 Z20 A0 C0\nG1 X1 F900\nG55\nG1 X0 Y0 Z20 F3000\nG52 X1\nX1",
        OPTIONS.changed(wcs={1: WorkOffset((0.0, 0.0, 50.0)), 2: WorkOffset((2.0, 1.0, 49.0), 5.0)}),
    ),
    "inverse time": ("G0 X0 Y0 Z20 A0 C0\nG93 G1 X3 C3 F400\nA2 F300\nX4 F9000", OPTIONS),
    "long cycle": ("G0 X0 Y0 Z20 A0 C0\nG1 X30 F3000\nY1\nG4 P.1", OPTIONS.changed(cycle=0.01)),
    "short cycle": ("G0 X0 Y0 Z20 A0 C0\nG1 X.1 F3000\nG4 P.01", OPTIONS.changed(cycle=0.000125)),
    "few decimals": ("G0 X0 Y0 Z20 A0 C0\nG1 X2 F3000\nY.1 C1\nG4 P.01", OPTIONS.changed(decimals=5,
                                                                              accept_rounding=True)),
}  # fmt: skip


#: Of these every row is a block of its own too: they have whatever a block can end at.
ROW_BY_ROW = ("everything", "full circles and turns", "dwells in a row", "approach from home")


@pytest.mark.parametrize("what", PASSING)
def test_right_file_passes_in_any_block_size(what: str) -> None:
    body, options = PASSING[what]
    source = program(body)
    values, line = made(source, options)
    verdicts = [
        verify_rows(source, values, line, options, block)
        for block in ((1, 7, 8192) if what in ROW_BY_ROW else (7, 8192))
    ]
    whole = verdicts[-1]
    assert whole.findings == []
    assert whole.n_rows == len(values)
    # fewer rows a block end the iteration of the forward kinematics a step earlier: 1e-9 mm at most
    for verdict in verdicts:
        assert verdict.findings == []
        assert verdict.n_rows == whole.n_rows
        assert (verdict.first_row == values[0]).all()
        for name in ("velocity_ratio", "acceleration_ratio", "jerk_ratio"):
            assert getattr(verdict, name) == pytest.approx(getattr(whole, name), rel=1e-12)
        assert verdict.feed_ratio == pytest.approx(whole.feed_ratio, rel=1e-5)
        assert verdict.tip_deviation_mm == pytest.approx(whole.tip_deviation_mm, abs=2e-9)
        assert verdict.axis_deviation_deg == pytest.approx(whole.axis_deviation_deg, abs=2e-9)


@pytest.mark.parametrize("what", ROW_BY_ROW)
@pytest.mark.parametrize("block", [1, 7])
def test_wrong_file_fails_in_any_block_size(what: str, block: int) -> None:
    """The second half of the file is missing, or rows in its middle are."""
    body, options = PASSING[what]
    source = program(body)
    values, line = made(source, options)
    half = len(values) // 2
    assert "VP412" in codes(verify_rows(source, values[:half], line[:half], options, block))
    gap = slice(half, half + 40)
    assert not verify_rows(source, np.delete(values, gap, axis=0), np.delete(line, gap), options, block).ok


# --- decimals as written -------------------------------------------------------------------------------------

STILL = program("G0 X0 Y0 Z40 A0 C0\nG1 Z38 F1000\nX3\nY1 C2\nG4 P.02\nG0 Z40")


def verify_text(source: bytes, text: str, options: Options = OPTIONS) -> Verification:
    asked = ask(source, options)
    return verify_setpoints(asked, read_csv(io.StringIO(text), Expected("axes.csv", MACHINE.columns, asked.cycle, ())))


def written(source: bytes, options: Options = OPTIONS) -> list[list[str]]:
    """Cells of the rows of a setpoint file."""
    values, line = made(source, options)
    fmt = choose_setpoint_format(MACHINE, 0.001, options.decimals, accept_rounding=True)
    return [row.split(",") for row in write_csv_rows(SetpointBlock(0, values, line, fmt)).splitlines()]


def shortest(cell: str) -> str:
    """The same number without trailing zeros, as spreadsheets and data frames write it."""
    return (cell.rstrip("0").rstrip(".") or "0") if "." in cell else cell


def as_text(rows: list[list[str]]) -> str:
    return write_csv_header(MACHINE.columns, ()) + "".join(",".join(row) + "\n" for row in rows)


def test_same_numbers_without_trailing_zeros_pass() -> None:
    rows = [[shortest(cell) for cell in row] for row in written(STILL)]
    assert rows[0][5] == "0"  # C stands still in the first rows, and shows no decimals
    assert verify_text(STILL, as_text(rows)).findings == []


SPOILT: dict[str, Callable[[int, list[float]], list[float]]] = {
    "0.5 mm lower": lambda _k, q: [q[0] + 0.5, q[1] + 0.5, q[2] + 0.5, *q[3:]],
    "A jumps": lambda k, q: [*q[:3], q[3] + 0.05 * (k >= 300), q[4]],
    "one slider jumps": lambda k, q: [q[0] + 0.02 * (k == 500), *q[1:]],
    "C jumps back": lambda k, q: [*q[:4], q[4] - 1.0 * (k >= 450)],
}


@pytest.mark.parametrize("trim", [False, True])
@pytest.mark.parametrize("how", SPOILT)
def test_wrong_numbers_fail_however_many_decimals_are_shown(how: str, trim: bool) -> None:
    """Few decimals in the first rows say nothing about how the rest of the file is rounded."""
    rows = written(STILL)
    for k, row in enumerate(rows):
        spoilt = SPOILT[how](k, [float(cell) for cell in row[1:6]])
        row[1:6] = [f"{value:.{d}f}" for value, d in zip(spoilt, (7, 7, 7, 8, 8), strict=True)]
    if trim:
        rows = [[shortest(cell) for cell in row] for row in rows]
    assert not verify_text(STILL, as_text(rows)).ok


@pytest.mark.parametrize(("decimals", "shift"), [(5, 0.001), (4, 0.003), (3, 0.01)])
def test_noise_of_coarse_decimals_hides_no_moved_row(decimals: int, shift: float) -> None:
    """A row moved by many times the last decimal makes three times that in the third difference."""
    options = OPTIONS.changed(decimals=decimals, accept_rounding=True)
    rows = written(STILL, options)
    assert verify_text(STILL, as_text(rows), options).ok
    rows[500][1] = f"{float(rows[500][1]) + shift:.{decimals}f}"
    assert "VP403" in codes(verify_text(STILL, as_text(rows), options))


# --- flow through many collinear segments ------------------------------------------------------------------------

PLAIN = "G21 G90 G94 G17"


@pytest.mark.parametrize("cycle", [0.001, 0.004, 0.01])
def test_several_segments_in_one_cycle(cycle: float) -> None:
    """3 mm in steps of 0.01 mm at 50 mm/s: at 4 ms a row passes up to 20 segments."""
    options = OPTIONS.changed(cycle=cycle)
    source = program(f"G0 X0 Y0 Z20 A0 C0\nG1 F3000\n{LAYERS}\nG61.1 Y1", PLAIN)
    values, line = made(source, options)
    steps = np.diff(line)
    assert (steps >= 0).all()
    assert steps.max() > 1  # segments are passed between two rows
    for block in (1, 7, 8192):
        assert verify_rows(source, values, line, options, block).ok
    # a stretch left out is seen though no stop is in it
    gap = slice(len(values) // 2, len(values) // 2 + 3)
    assert not verify_rows(source, np.delete(values, gap, axis=0), np.delete(line, gap), options).ok


@pytest.mark.parametrize(("tail", "cycle"), [(0.01, 0.01), (0.002, 0.004), (0.0001, 0.002)])
def test_short_segment_before_a_stop(tail: float, cycle: float) -> None:
    """The last collinear segment before a corner may be passed within one cycle: that is no error."""
    options = OPTIONS.changed(cycle=cycle)
    source = program(f"G43.4\nG0 X0 Y10 Z20 A10 C0\nG1 F3000 X5\nX{5 + tail:.6f}\nG61.1 Y9", PLAIN)
    result = verne_post.convert(source, MACHINE, options)
    assert [item.message for item in result.findings] == []
    assert result.exit_code == 0


# --- any small program --------------------------------------------------------------------------------------------


def number(low: float, high: float) -> st.SearchStrategy[float]:
    return st.integers(round(low * 1000), round(high * 1000)).map(lambda k: k / 1000)


@st.composite
def small_programs(draw: st.DrawFn) -> bytes:
    """Lines, arcs, dwells and rotary moves inside the workspace."""
    x, y, a, c = draw(number(-60, 60)), draw(number(-60, 60)), draw(number(-30, 30)), draw(number(-90, 90))
    z = draw(number(5, 60))
    blocks = [f"G0 X{x} Y{y} Z{z} A{a} C{c}"]
    for _ in range(draw(st.integers(1, 4))):
        feed = draw(st.sampled_from([90, 600, 3000, 12000]))
        kind = draw(st.sampled_from(["line", "rapid", "arc", "circle", "rotary", "dwell", "dwell and line"]))
        if kind in ("line", "rapid", "dwell and line"):
            x, y = x + draw(number(0.5, 12)), y + draw(number(-12, 12))
            z = draw(number(5, 60)) if kind == "rapid" else z
            a = draw(number(-30, 30)) if draw(st.booleans()) else a
            dwell = "G4 P0.011 " if kind.startswith("dwell") else ""
            code = "G0" if kind == "rapid" else f"F{feed} G1"
            blocks.append(f"{dwell}{code} X{x:.3f} Y{y:.3f} Z{z} A{a}")
        elif kind == "arc":
            radius, begin, sweep = draw(number(1, 8)), draw(number(-180, 180)), draw(number(10, 350))
            sign = draw(st.sampled_from([1, -1]))
            i, j = -radius * np.cos(np.radians(begin)), -radius * np.sin(np.radians(begin))
            turn = np.radians(begin + sign * sweep)
            x, y = x + i + radius * np.cos(turn), y + j + radius * np.sin(turn)
            c = draw(number(-90, 90)) if draw(st.booleans()) else c
            code = "G3" if sign > 0 else "G2"
            blocks.append(f"{code} X{x:.9f} Y{y:.9f} I{i:.9f} J{j:.9f} C{c} F{feed}")
        elif kind == "circle":
            blocks.append(f"G2 X{x:.9f} Y{y:.9f} I{draw(number(1, 6))} P{draw(st.integers(1, 3))} F{feed}")
        elif kind == "rotary":
            a, c = draw(number(-30, 30)), c + draw(number(1, 60))
            blocks.append(f"G1 A{a} C{c:.3f} F{feed}")
        else:
            blocks.append(f"G4 P{draw(number(0.001, 0.05))}")
    if not any(block.split()[0] != "G4" for block in blocks[1:]):
        blocks.append(f"G0 Z{z + 1}")
    return program("\n".join(blocks))


@settings(max_examples=25, deadline=None, derandomize=True, database=None)
@given(source=small_programs(), place=st.floats(0, 1), column=st.integers(0, 4), sign=st.sampled_from([1, -1]))
def test_any_program_passes_and_any_moved_row_fails(source: bytes, place: float, column: int, sign: int) -> None:
    result = verne_post.convert(source, MACHINE, OPTIONS)
    assert result.ok, (source.decode(), [item.message for item in result.findings])
    assert result.setpoints is not None
    values, line = result.setpoints.values, result.setpoints.line
    assert verify_rows(source, values, line, block=1000).ok
    row = round(place * (len(values) - 1))
    values[row, column] += sign * 0.01  # mm or degrees
    assert not verify_rows(source, values, line).ok
