"""Rows come in blocks, and a verdict does not depend on where the blocks end: not of good files, and not of spoilt
ones.
"""

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from verne_post.app.assemble import Program, assemble
from verne_post.app.verify import verify_setpoints
from verne_post.model.part_setup import WorkOffset
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.rounding import choose_setpoint_format
from verne_post.trajectory.sample import BLOCK_ROWS
from verne_post.verification import one_line

from ..builders import MACHINE, OPTIONS
from .test_verifier import Table, made, program, verify_rows

# lines: 2 start, 4 four circles and 7 three dwells and moves of one line each, 9 back, 10 an arc of several turns
LOOPS = program("""G0 X0 Y0 Z24 A0 C0
o1 repeat [4]
G2 I.5 F1500
o1 endrepeat
o2 repeat [3]
G4 P.02 G91 G1 X1
o2 endrepeat
G90 X0 A2
G3 I-.4 P3 C2
G0 Z25""")
# the same where corners are rounded and collinear moves go on
ROUNDED = program(
    "G0 X0 Y0 Z24 A0 C0\nG1 X2 F1500\nX4\nX5 Y2\nG2 I.5 J.3\nG2 I.5 J.3\nG1 X6\nG61.1 X7\nG64 P.02 X8 Y4\nG4 P.01\nX6",
    "G21 G90 G94 G17 G64 P0.02",
)


def verdict(asked: Program, values: np.ndarray, line: np.ndarray, ends: Iterable[int]) -> set[tuple[str, str | None]]:
    """Codes and axes of what is found in rows in blocks with these ends; of each, only the first place of a block is
    kept.
    """
    fmt = choose_setpoint_format(MACHINE, asked.cycle, None, accept_rounding=False)
    places = [0, *ends, len(values)]
    blocks = (SetpointBlock(a, values[a:b], line[a:b], fmt) for a, b in pairwise(places) if a < b)
    return {(item.code, item.axis) for item in verify_setpoints(asked, blocks).findings}


def deleted(values: np.ndarray, line: np.ndarray, first: int, last: int) -> Table:
    return np.delete(values, slice(first, last), axis=0), np.delete(line, slice(first, last))


def repeated(values: np.ndarray, line: np.ndarray, first: int, last: int) -> Table:
    rows = np.concatenate([np.arange(last), np.arange(first, len(line))])
    return values[rows], line[rows]


def exchanged(values: np.ndarray, line: np.ndarray, first: int, last: int) -> Table:
    rows = np.arange(len(line))
    rows[first:last] = rows[first:last][::-1]
    return values[rows], line[rows]


def stood_still(values: np.ndarray, line: np.ndarray, first: int, last: int) -> Table:
    values = values.copy()
    values[first:last] = values[first]
    return values, line


def early(values: np.ndarray, line: np.ndarray, first: int, last: int) -> Table:
    line = line.copy()
    line[first:last] = line[last]
    return values, line


def late(values: np.ndarray, line: np.ndarray, first: int, last: int) -> Table:
    line = line.copy()
    line[first:last] = line[first - 1]
    return values, line


HOW: dict[str, Callable[..., Table]] = {
    "deleted": deleted,
    "repeated": repeated,
    "reversed": exchanged,
    "stood still": stood_still,
    "under the later line": early,
    "under the earlier line": late,
}
SOURCES = {
    "stops": (LOOPS, OPTIONS.changed(cycle=0.002)),
    "rounded": (ROUNDED, OPTIONS.changed(cycle=0.002)),
    "0.05 s a row": (ROUNDED, OPTIONS.changed(cycle=0.05)),
}


def rest_places(values: np.ndarray) -> np.ndarray:
    """Rows at which the machine stands: where a file can be cut without a jolt."""
    return np.flatnonzero(np.abs(np.diff(values, axis=0)).max(axis=1) < 1e-6) + 1


@pytest.mark.parametrize("what", SOURCES)
def test_a_good_file_passes_wherever_a_block_ends(what: str) -> None:
    source, options = SOURCES[what]
    values, line = made(source, options)
    asked = assemble(source, MACHINE, options)
    changes = np.flatnonzero(np.diff(line)) + 1
    near = np.unique(
        np.concatenate([changes + k for k in (-2, -1, 0, 1, 2)] + [rest_places(values), [1, 2, len(line) - 1]])
    )
    for end in near[(near > 0) & (near < len(line))].tolist():
        assert verdict(asked, values, line, [end]) == set()
    assert verdict(asked, values, line, range(1, len(line), 3)) == set()


@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("what", SOURCES)
def test_a_spoilt_file_fails_alike_wherever_a_block_ends(what: str, how: str) -> None:
    """Spoilt from a line's first row on, to its last, and by a single row; blocks end at each edge and beside it."""
    source, options = SOURCES[what]
    values, line = made(source, options)
    asked = assemble(source, MACHINE, options)
    edges = [0, *(np.flatnonzero(np.diff(line)) + 1).tolist(), len(line) - 1]
    for first, last in pairwise(edges):
        for a, b in {(first, last), (first, first + 1), (last - 1, last), (first, (first + last) // 2)}:
            if a == b or a == 0:
                continue
            spoilt = HOW[how](values, line, a, b)
            if spoilt[1].shape == line.shape and (spoilt[1] == line).all() and (spoilt[0] == values).all():
                continue  # a single row that is reversed: the good file of the test above
            whole = verdict(asked, *spoilt, [])
            if what == "stops" and b - a > 30:
                assert whole, (a, b)
            inside = set(range(1, len(spoilt[1])))
            # at every edge and beside it, one at each end of the rows at a time, and all together; rows of a part of
            # a line have one of the edges of the whole line
            sets = [{a, b}, {a - 1, a, a + 1, b - 1, b, b + 1}]
            sets += [{a - 1, b + 1}, {a + 1, b - 1}] if (a, b) == (first, last) else []
            for ends in {tuple(sorted(one & inside)) for one in sets} - {()}:  # of a single row two are the same
                assert verdict(asked, *spoilt, ends) == whole, (a, b, ends)


# --- several motions of one line ------------------------------------------------------------------------------


def of_line(values: np.ndarray, line: np.ndarray, number: int, count: int) -> list[tuple[int, int]]:
    """First and last row of each of the motions of a line, which begin at rest and take equally long."""
    rows = np.flatnonzero(line == number)
    edges = np.linspace(rows[0], rows[-1] + 1, count + 1).round().astype(int)
    return list(pairwise(edges.tolist()))


def cut_finely(line: np.ndarray, first: int, last: int) -> list[int]:
    """Ends of blocks of three rows about two rows of a file, and of 40 rows elsewhere."""
    near = [range(max(k - 30, 1), min(k + 30, len(line)), 3) for k in (first, last)]
    return sorted({*near[0], *near[1], *range(1, len(line), 40)})


@pytest.mark.parametrize("number", [0, 1, 2, 3])
def test_one_of_several_motions_of_a_line_left_out(number: int) -> None:
    """A circle ends where it begins: without its rows nothing jumps, no line is missing, and only one of four
    is gone.
    """
    values, line = made(LOOPS)
    asked = assemble(LOOPS, MACHINE, OPTIONS)
    first, last = of_line(values, line, 4, 4)[number]
    spoilt = deleted(values, line, first, last)
    for ends in ([], [first], [first - 1], [first + 1], cut_finely(spoilt[1], first, first)):
        assert {("VP412", None), ("VP413", None)} & verdict(asked, *spoilt, ends)


@pytest.mark.parametrize("number", [0, 1, 2, 3])
def test_one_of_several_motions_of_a_line_twice(number: int) -> None:
    values, line = made(LOOPS)
    asked = assemble(LOOPS, MACHINE, OPTIONS)
    first, last = of_line(values, line, 4, 4)[number]
    spoilt = repeated(values, line, first, last)
    for ends in ([], [first], [last], [last - 1], [last + 1], cut_finely(spoilt[1], first, last)):
        assert verdict(asked, *spoilt, ends)


def test_motions_of_one_line_that_are_longer_than_what_is_looked_at_at_a_time() -> None:
    """Two arcs of three turns, 3800 rows each; every turn passes the same places."""
    source = program("G0 X0 Y0 Z24 A0 C0\no1 repeat [2]\nG2 I2 P3 F600\no1 endrepeat\nG0 Z25")
    values, line = made(source)
    assert (line == 4).sum() > 7000
    asked = assemble(source, MACHINE, OPTIONS)
    for ends in ([], [1024], [5000], range(0, len(line), 700)):
        assert verdict(asked, values, line, ends) == set()
    first, last = of_line(values, line, 4, 6)[1]  # the second turn of the first arc
    assert verdict(asked, *deleted(values, line, first, last), [first])


# X, Y, A, C of moves without a stop between them: obtuse and acute corners, there and almost back, and over the same
# places again
MOVES = [
    "3 0 0 0",
    "5 1 0 0",
    "6 1.5 3 4",
    "7 3 3 4",
    "4 3.5 3 4",
    "7 3.4 3 4",
    "7 1 0 0",
    "3 0 0 0",
    "5 1 0 0",
    "5.2 1.5 0 0",
]


@pytest.mark.parametrize("word", ["G1", "G2 R5"])
def test_moves_of_one_line_without_a_stop_between_them(word: str) -> None:
    """The same moves by a line each give the same rows; by one line, rows left out, twice or exchanged are seen as
    well.
    """
    head = "G0 X0 Y0 Z24 A0 C0\nF1500 G64 P.01\n"
    moves = [move.split() for move in MOVES]
    lines = "\n".join(f"{word} X{x} Y{y} A{a} C{c}" for x, y, a, c in moves)
    calls = "\n".join("o10 call " + " ".join(f"[{value}]" for value in move) for move in moves)
    each = program(f"{head}{lines}\nG0 Z25")
    one = program(f"{head}o10 sub\n{word} X#1 Y#2 A#3 C#4\no10 endsub\n{calls}\nG0 Z25")
    (expected, of_move), (values, line) = made(each), made(one)
    np.testing.assert_array_equal(values, expected)
    asked = assemble(one, MACHINE, OPTIONS)
    assert asked.contour.n_blended >= 8
    for ends in ([], [100], range(0, len(line), 37), range(0, len(line), 1000)):
        assert verdict(asked, values, line, ends) == set()
    for number in np.unique(of_move)[1:-1].tolist():
        first, last = np.flatnonzero(of_move == number)[[0, -1]].tolist()
        for spoil in (deleted, repeated, exchanged):
            assert verdict(asked, *spoil(values, line, first, last), [first])


def test_rows_that_are_off_everywhere_are_not_placed_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each took several trials: a wrong work offset made the check a hundred times as long."""
    moves = "\n".join(f"o10 call [{x}] [{y}]" for x, y, *_turned in map(str.split, MOVES))
    source = program(f"G0 X0 Y0 Z24 A0 C0\nF600 G64 P.01\no10 sub\nG1 X#1 Y#2\no10 endsub\n{moves}\nG0 Z25")
    values, line = made(source, OPTIONS.changed(wcs={1: WorkOffset((0.0, 0.0, 101.0))}))
    asked: list[int] = []

    def count(*args: Any) -> Any:
        asked.append(1)
        return choose(*args)

    choose = one_line._choose
    monkeypatch.setattr(one_line, "_choose", count)
    right = OPTIONS.changed(wcs={1: WorkOffset((0.0, 0.0, 100.0))})
    found = verify_rows(source, values, line, right).findings
    assert any("off by X0.000 Y0.000 Z1.000 mm on the table" in one.message for one in found)
    assert 0 < len(asked) < len(line) / 10


# lines: 9, 10, 12 and 14 call line 5, and between the last three there are moves shorter than the way from row to row
CALLS = program(
    """G0 X0 Y0 Z24 A0 C0
F1500
o10 sub
G91 G1 X[#1] Y[#2]
G90
o10 endsub
G64 P0.01
o10 call [2] [0]
o10 call [2] [0]
X4.003 Y0.003
o10 call [0] [2]
X4.001 Y2.006
o10 call [2] [1]
G0 Z25""".replace("[#1]", "#1").replace("[#2]", "#2")
)


@pytest.mark.parametrize("cycle", [0.001, 0.004])
def test_what_is_passed_between_two_executions_of_a_line(cycle: float) -> None:
    options = OPTIONS.changed(cycle=cycle)
    values, line = made(CALLS, options)
    asked = assemble(CALLS, MACHINE, options)
    rows = np.flatnonzero(line == 5)
    assert not {11, 13} <= set(line.tolist())
    for ends in ([], rows.tolist(), range(1, len(line), 7), range(0, len(line), 64)):
        assert verdict(asked, values, line, ends) == set()
    for first, last in pairwise(np.linspace(rows[0], rows[-1], 6).astype(int).tolist()):
        assert verdict(asked, *deleted(values, line, first, last), [first])


def test_a_circle_among_others_that_go_on_without_a_stop_left_out() -> None:
    """At even speed nothing jumps where a whole circle is missing, no line is out of order, and no stop is passed."""
    circles = "\n".join(["G2 J3 F60000"] * 3)
    source = program(f"G0 X0 Y0 Z24 A0 C0\n{circles}\nG61.1 G1 X9", "G21 G90 G94 G17")
    options = OPTIONS.changed(smoothing="off")
    values, line = made(source, options)
    asked = assemble(source, MACHINE, options)
    rows = np.flatnonzero(line == 4)
    for shift in (-1, 0, 1):
        a, b = int(rows[0]) + shift, int(rows[-1]) + 1 + shift
        spoilt = deleted(values, line, a, b)
        for ends in ([], [a], [a - 1], range(1, a + 40)):
            assert {("VP412", None), ("VP404", None)} <= verdict(asked, *spoilt, ends)


@pytest.mark.parametrize("number", [4, 5, 6])
def test_one_of_several_dwells_in_a_row_left_out(number: int) -> None:
    source = program("G0 X0 Y0 Z24 A0 C0\nG1 X1 F900\nG4 P.02\nG4 P.03\nG4 P.01\nX2")
    values, line = made(source)
    asked = assemble(source, MACHINE, OPTIONS)
    rows = np.flatnonzero(line == number)
    spoilt = deleted(values, line, rows[0], rows[-1] + 1)
    for ends in ([], [rows[0]], [rows[0] - 1], [rows[0] + 1]):
        assert {("VP412", None), ("VP413", None)} & verdict(asked, *spoilt, ends)


# --- blocks as they are written and read --------------------------------------------------------------------------

LONG = "\n".join(f"G1 X{10 * (k % 2)} Y{0.5 * k:.1f} F900" for k in range(1, 25)) + "\nG2 I-5 P2\nG4 P.05\nG0 Z30"


@pytest.mark.parametrize("shift", [-2, -1, 0, 1])
@pytest.mark.parametrize("how", HOW)
def test_a_file_spoilt_where_a_block_of_the_real_size_ends(how: str, shift: int) -> None:
    source = program(f"G0 X0 Y0 Z24 A0 C0\n{LONG}")
    values, line = made(source)
    assert len(line) > BLOCK_ROWS + 1000
    asked = assemble(source, MACHINE, OPTIONS)
    at = BLOCK_ROWS + shift
    spoilt = HOW[how](values, line, at, at + 40)
    whole = verdict(asked, *spoilt, [])
    assert verdict(asked, *spoilt, range(BLOCK_ROWS, len(spoilt[1]), BLOCK_ROWS)) == whole
    if how in ("deleted", "repeated", "reversed", "stood still"):
        assert whole


@pytest.mark.parametrize("short", [0, 1])
def test_a_dwell_counts_over_the_ends_of_blocks(short: int) -> None:
    """Its rows are counted wherever a block ends in it; where some are missing it is too short."""
    source = program("G0 X0 Y0 Z24 A0 C0\nG1 X4 F2000\nG4 P0.05\nG1 X5")
    values, line = made(source)
    asked = assemble(source, MACHINE, OPTIONS)
    first = int(np.flatnonzero(line == 4)[5])
    values, line = deleted(values, line, first, first + short)
    expected = {("VP412", None)} if short else set()
    for end in range(first - 4, first + 44 - short, 7):
        assert verdict(asked, values, line, [end]) == expected
        assert verdict(asked, values, line, [end - 3, end, end + 2]) == expected


@pytest.mark.parametrize("size", [1, 2, 1000])
def test_the_first_row_of_a_file_is_kept_whatever_the_blocks(size: int) -> None:
    source = program("G0 X0 Y0 Z24 A0 C0\nG1 X4 F2000")
    values, line = made(source)
    asked = assemble(source, MACHINE, OPTIONS)
    fmt = choose_setpoint_format(MACHINE, asked.cycle, None, accept_rounding=False)
    starts = [0, 1, *range(1 + size, len(values), size)]
    ends = [*starts[1:], len(values)]
    blocks = (SetpointBlock(a, values[a:b], line[a:b], fmt) for a, b in zip(starts, ends, strict=True))
    found = verify_setpoints(asked, blocks)
    assert found.first_row is not None
    assert found.first_row.tolist() == values[0].tolist()
    assert found.n_rows == len(values)
