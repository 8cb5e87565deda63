"""The verifier on files with rounded corners: it passes what is right, and refuses what leaves more than
corners out.
"""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import verne_post
from verne_post.model.options import Options

from ..builders import MACHINE, OPTIONS
from .test_verifier import Table, codes, made, rows_of, verify_rows, without

HEAD = "G21 G90 G94 G17 G64 P0.02"


def program(body: str, head: str = HEAD) -> bytes:
    return f"{head}\nG0 X0 Y0 Z30 A0 C0\n{body}\nM2\n".encode()


# lines 3 to 13: a square corner, two gentle ones, an arc, a turn of the table, a stop, fine steps
BODY = """G1 X5 F2000
Y5
X7 Y8
X8 Y12
G3 X3 Y17 I-5 J0
G1 X0 Y17
X-2 A3 C10
G61.1 Y10
G64 P0.02 X-3 Y9.5
X-3.3 Y9.2
X-3.5 Y8.8
Y0"""
SOURCE = program(BODY)


@pytest.mark.parametrize("mode", ["blend", "spline"])
def test_a_rounded_file_passes_in_any_block_size(mode: str) -> None:
    options = OPTIONS.changed(smoothing=mode)
    values, line = made(SOURCE, options)
    for block in (100, 8192):
        verdict = verify_rows(SOURCE, values, line, options, block)
        assert verdict.findings == []
        assert 0.01 < verdict.tip_deviation_mm <= 0.02


def shifted(values: np.ndarray, line: np.ndarray) -> Table:
    values[rows_of(line, 4)[80], 1] += 0.02
    return values, line


def moved_aside(values: np.ndarray, line: np.ndarray) -> Table:
    """Every slider 0.03 mm lower: smooth, and more than the tolerance."""
    values[:, :3] += 0.03
    return values, line


def turned(values: np.ndarray, line: np.ndarray) -> Table:
    values[:, 4] += 360.0
    return values, line


def turned_from_the_corner(values: np.ndarray, line: np.ndarray) -> Table:
    values[line >= 9, 4] += 360.0
    return values, line


def early(values: np.ndarray, line: np.ndarray) -> Table:
    """The next line's number from the middle of line 4 on."""
    rows = rows_of(line, 4)
    line[rows[len(rows) // 2 :]] = 5
    return values, line


def exchanged(values: np.ndarray, line: np.ndarray) -> Table:
    k = rows_of(line, 7)[60]
    values[[k, k + 3]] = values[[k + 3, k]]
    return values, line


HOSTILE: dict[str, tuple[Callable[..., Table], set[str]]] = {
    "a row shifted by 0.02 mm": (shifted, {"VP403"}),
    "beside the path": (moved_aside, {"VP411"}),
    "C a turn further": (turned, {"VP411"}),
    "C a turn further from a corner on": (turned_from_the_corner, {"VP401", "VP411"}),
    "rows under the next line's number": (early, {"VP411"}),
    "two rows exchanged": (exchanged, {"VP402", "VP403"}),
    "a line left out": (without(5), {"VP401", "VP403"}),
    "the stop's line left out": (without(10), {"VP413"}),
    "the second half left out": (lambda q, n: (q[: len(q) // 2], n[: len(n) // 2]), {"VP412"}),
}


@pytest.mark.parametrize("mode", ["blend", "spline"])
@pytest.mark.parametrize("how", HOSTILE)
def test_a_spoilt_file_fails(how: str, mode: str) -> None:
    change, expected = HOSTILE[how]
    options = OPTIONS.changed(smoothing=mode)
    values, line = made(SOURCE, options)
    assert expected <= codes(verify_rows(SOURCE, *change(values.copy(), line.copy()), options))


@pytest.mark.parametrize("mode", ["blend", "spline"])
def test_a_rounded_file_fails_where_no_rounding_was_asked_for(mode: str) -> None:
    values, line = made(SOURCE, OPTIONS.changed(smoothing=mode))
    assert {"VP411", "VP412"} <= codes(verify_rows(SOURCE, values, line, OPTIONS.changed(smoothing="off")))
    for word in ("G64 P0.01", "G61", "G61.1", "G64 P0"):
        asked = program(BODY.replace("G64 P0.02", word), HEAD.replace("G64 P0.02", word))
        assert codes(verify_rows(asked, values, line, OPTIONS.changed(smoothing=mode))) & {"VP411", "VP412"}


@pytest.mark.parametrize("excess", [1.01, 1.003])
def test_feed_is_checked_on_rounded_segments(excess: float) -> None:
    """A polygon of many gentle corners, all of it rounded, judged against a feed that is lower by less than 1 %."""
    angle = np.linspace(0, np.pi, 60)
    points = "\n".join(f"X{10 * np.sin(a):.4f} Y{10 - 10 * np.cos(a):.4f}" for a in angle[1:])
    for mode in ("blend", "spline"):
        options = OPTIONS.changed(smoothing=mode)
        values, line = made(program(f"G1 F1200\n{points}"), options)
        asked = program(f"G1 F{1200 / excess:.9f}\n{points}")
        assert codes(verify_rows(asked, values, line, options)) == {"VP404"}


# --- more than a corner left out --------------------------------------------------------------------------

# a program, the same with something left out, and the lines of its rows in the first
LEFT_OUT: dict[str, tuple[str, str, dict[int, int]]] = {
    "a tooth of 5 mm": ("G1 X10 F1500\nY5\nX10.01\nY0\nX20", "G1 X10 F1500\nX20", {4: 7}),
    "a tooth of 0.3 mm": ("G1 X10 F1500\nY0.3\nX10.06\nY0\nX20", "G1 X10 F1500\nX20", {4: 7}),
    "a full circle": ("G1 X10 F1500\nG2 I1 J-2\nG1 X20", "G1 X10 F1500\nX20", {4: 5}),
    "five turns": ("G1 X10 F1500\nG2 I1 J-2 P5\nG1 X20", "G1 X10 F1500\nX20", {4: 5}),
    "a swing of the table": ("G1 X10 F1500\nA2\nC3\nA0\nC0\nX20", "G1 X10 F1500\nX20", {4: 8}),
}


@pytest.mark.parametrize("cycle", [0.001, 0.01])
@pytest.mark.parametrize("what", LEFT_OUT)
def test_what_is_left_out_between_two_rows_is_seen(what: str, cycle: float) -> None:
    """Every row lies on its line, the lines follow each other, nothing jumps: only the path between is missing."""
    whole, short, lines = LEFT_OUT[what]
    options = OPTIONS.changed(cycle=cycle)
    values, line = made(program(short), options)
    line = np.vectorize(lambda k: lines.get(k, k))(line).astype(line.dtype)
    verdict = verify_rows(program(whole), values, line, options, block=30)
    row = rows_of(line, lines[4])[0]
    where = f"row {row} (line {row + 2} of the file): the motion of line 4 is left out"  # in no first block
    assert where in [item.message for item in verdict.findings if item.code == "VP412"]


def test_rows_beyond_the_end_of_a_segment_are_seen() -> None:
    """The tool goes too far by 0.05 mm, straight on, on a line of 10 mm, and comes back on the next one."""
    options = OPTIONS.changed(smoothing="off")
    values, line = made(program("G1 X10.05 F1500\nX10\nY5"), options)
    line = np.minimum(line, 4)
    verdict = verify_rows(program("G1 X10 F1500\nY5"), values, line, options)
    found = [item.message for item in verdict.findings if item.code == "VP413"]
    assert any("is beyond the ends of the motion of line 3" in message for message in found)


@pytest.mark.parametrize("mode", ["off", "blend", "spline"])
@pytest.mark.parametrize("tilt", [1e-4, 2e-3, 0.05])
def test_great_circles_beside_the_pole_pass(tilt: float, mode: str) -> None:
    """C turns by much over little of them: places on the segment are told by what goes evenly, tip and tool axis."""
    directions = [(1, 1), (-1.2, 1), (-1.2, -1), (0, 0), (2, -3), (1, -3)]
    axes = [np.array([tilt * i, tilt * j, 1.0]) for i, j in directions]
    moves = [
        f"G1 X{k + 1} Y{0.3 * (k % 2)} I{v[0]:.7f} J{v[1]:.7f} K{v[2]:.7f}"
        for k, v in enumerate(axis / np.linalg.norm(axis) for axis in axes)
    ]
    source = "\n".join(["G21 G90 G94 G17 G64 P0.05", "G43.5", "G0 X0 Y0 Z40", "F3000", *moves, "M2", ""])
    result = verne_post.convert(source.encode(), MACHINE, OPTIONS.changed(smoothing=mode, allow_rewind=True))
    assert [item.message for item in result.findings if item.severity == "error"] == []


# --- any program --------------------------------------------------------------------------------------------------


@st.composite
def programs(draw: st.DrawFn) -> tuple[bytes, Options]:
    """Lines, arcs, rotary moves, rapids, dwells and changes of path control, in mm or inches."""
    inch = draw(st.booleans())
    unit = 25.4 if inch else 1.0
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    step = 10.0 ** draw(st.sampled_from([-2, -1, 0, 1]))
    point = np.array([0.0, 0.0, 40.0, 0.0, 0.0])
    words = [("G20" if inch else "G21") + " G90 G94 G17", f"G0 X0 Y0 Z{40 / unit:.5f} A0 C0 F{2000 / unit:.4f}"]
    for kind in draw(st.lists(st.sampled_from("LLLLLT5RADMMF"), min_size=3, max_size=14)):
        point[:2] = np.clip(point[:2] + rng.normal(size=2) * step, -40, 40)
        xy = f"X{point[0] / unit:.5f} Y{point[1] / unit:.5f}"
        if kind in "T5":
            point[3:] = np.clip(point[3:] + rng.normal(size=2) * [1.0, 5.0], [-15, -90], [15, 90])
        turned = f"A{point[3]:.4f} C{point[4]:.4f}"
        if kind == "A":
            radius = float(np.hypot(*(rng.normal(size=2) * step))) + 0.2
            words.append(f"G{rng.integers(2, 4)} I{radius / unit:.5f} J0")
        elif kind == "D":
            words.append(f"G4 P{rng.choice([0.0, 0.003, 0.02])}")
        elif kind == "M":
            words.append(str(rng.choice(["G61", "G61.1", "G64", "G64 P0", f"G64 P{0.1 / unit:.5f} Q0.01"])))
        elif kind == "F":
            words.append(f"F{10.0 ** rng.uniform(2.5, 4.3) / unit:.3f}")
        else:
            words.append({"L": f"G1 {xy}", "T": f"G1 {turned}", "5": f"G1 {xy} {turned}", "R": f"G0 {xy}"}[kind])
    if not any(word.startswith(("G1", "G2 ", "G3 ", "G0")) for word in words[2:]):
        words.append("G0 X1")
    options = OPTIONS.changed(
        cycle=draw(st.sampled_from([0.00025, 0.001, 0.004])),
        smoothing=draw(st.sampled_from(["blend", "spline"])),
    )
    return "\n".join([*words, "M2", ""]).encode(), options


@settings(max_examples=14, deadline=None, derandomize=True, database=None)
@given(programs())
def test_any_program_converts_or_is_refused_with_a_reason(made_of: tuple[bytes, Options]) -> None:
    source, options = made_of
    result = verne_post.convert(source, MACHINE, options)
    assert result.ok or (result.findings and result.exit_code in (1, 2)), (source.decode(), result.findings)
