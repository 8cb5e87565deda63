"""Programs that mean the same, or nearly, in other words: what must not change over the whole pipeline, does not.

Nobody needs to know the right answer for this: each test converts two programs and compares. Tolerances are reasons,
not results:

ROUNDING: rows are written with so many decimals that rounding stays far below any limit; the inputs of both programs
agree to 1e-9 mm, and profiles from stop to stop have closed forms, so rows differ by the last decimal at most.
PLANNING: where corners are blended, an iteration ends at a threshold; planning then finds one of many profiles within a
few parts in 1e4 of each other. Rows at the same instant may be that far apart along the path, so durations are
compared.
"""

import numpy as np
import pytest

from verne_post import Machine, Options, convert, load_machine
from verne_post.config import list_machine_files
from verne_post.config.load import build_machine

ROUNDING_MM = 2e-6
PLANNING = 1e-3
HEAD = "G21 G90 {mode}\nT1 M6\nG43 H1\nG0 X-20 Y-15 Z30 A0 C0\n"
POINTS = ((20, -15, 20, 0, 0), (20, 15, 22, 4, 0), (-10, 18, 20, 4, 30), (-20, 0, 24, 0, 30), (-20, -15, 20, 0, 0))
PART = "".join("G1 X{:g} Y{:g} Z{:g} A{:g} C{:g} F2500\n".format(*point) for point in POINTS) + "G0 Z30\nM2\n"


def program(mode: str = "G64 P0.05", body: str = PART) -> str:
    return HEAD.format(mode=mode) + body


def rows(
    source: str, machine: Machine | str = "verne", offset: tuple[float, ...] = (0.0, 0.0, 20.0), **options: object
):
    """Setpoints of a program, and its summary."""
    result = convert(source, machine=machine, options=Options(tool_length=60.0, wcs={"G54": offset}, **options))
    assert result.ok, result.findings
    assert result.setpoints is not None
    return result.setpoints, result.summary


def assert_same_rows(one: str, other: str, **offsets: tuple[float, ...]) -> None:
    """From stop to stop the rows are those of the other program but for rounding; with blended corners the
    duration is.
    """
    for mode in ("G61.1", "G64 P0.05"):
        first, first_summary = rows(one.replace("{mode}", mode), offset=offsets.get("first", (0.0, 0.0, 20.0)))
        second, second_summary = rows(other.replace("{mode}", mode), offset=offsets.get("second", (0.0, 0.0, 20.0)))
        if mode == "G61.1":
            assert first.values.shape == second.values.shape
            assert np.abs(first.values - second.values).max() < ROUNDING_MM
        else:
            assert second_summary.cycle_time == pytest.approx(first_summary.cycle_time, rel=PLANNING)


def moved(points: np.ndarray) -> str:
    """The part of PART, tilted nowhere, at other places."""
    return (
        HEAD.replace("G0 X-20 Y-15 Z30", "G0 X{:.10f} Y{:.10f} Z{:.10f}".format(*points[0]))
        + "".join("G1 X{:.10f} Y{:.10f} Z{:.10f} F2500\n".format(*point) for point in points[1:])
        + "M2\n"
    )


PLACES = np.array([(-20, -15, 30), *(point[:3] for point in POINTS)], dtype=float)


def test_the_program_moved_against_its_offset() -> None:
    shift = np.array([3.25, -7.5, 4.125])
    assert_same_rows(moved(PLACES), moved(PLACES + shift), second=tuple(np.array([0.0, 0.0, 20.0]) - shift))


def test_the_part_turned_about_c() -> None:
    """By 30 degrees on the table, about its axis: C turns it back, and nothing else moves otherwise, tilted or not."""
    for mode in ("G61.1", "G64 P0.05"):
        straight, straight_summary = rows(program(mode))
        turned, turned_summary = rows(program(mode), offset=(0.0, 0.0, 20.0, 30.0))
        assert turned_summary.cycle_time == pytest.approx(straight_summary.cycle_time, rel=PLANNING)
        if mode == "G61.1":
            apart = turned.values - straight.values
            assert np.abs(apart - (0.0, 0.0, 0.0, 0.0, -30.0)).max() < ROUNDING_MM


def test_the_same_in_inches() -> None:
    """Nine decimals of an inch are 2.5e-8 mm."""

    def inches(text: str) -> str:
        words = []
        for word in text.replace("G21", "G20").replace("P0.05", f"P{0.05 / 25.4:.12f}").split(" "):
            head, digits = word[:1], word[1:].rstrip("\n")
            end = "\n" if word.endswith("\n") else ""
            lengths = head in "XYZF" and digits.replace("-", "").replace(".", "").isdigit()
            words.append(f"{head}{float(digits) / 25.4:.9f}{end}" if lengths else word)
        return " ".join(words)

    for mode in ("G61.1", "G64 P0.05"):
        text = program(mode).replace("\n", " \n ").replace(" \n ", "\n")
        twin = "\n".join(inches(line) for line in text.split("\n"))
        first, first_summary = rows(text)
        second, second_summary = rows(twin)
        assert second_summary.cycle_time == pytest.approx(first_summary.cycle_time, rel=PLANNING)
        if mode == "G61.1":
            assert np.abs(first.values - second.values).max() < ROUNDING_MM


def test_a_move_split_in_two() -> None:
    """At its middle: the contour is the same, and so is the duration but for planning."""
    split = []
    for line in program().split("\n"):
        if line.startswith("G1 X20 Y-15"):
            split.append("G1 X0 Y-15 Z25 A0 C0 F2500")  # from X-20 Z30 to X20 Z20
        split.append(line)
    assert rows("\n".join(split))[1].cycle_time == pytest.approx(rows(program())[1].cycle_time, rel=PLANNING)


def test_numbers_comments_and_blanks_change_nothing_but_lines() -> None:
    lines = program().split("\n")
    noisy = []
    for number, line in enumerate(lines):
        noisy += [f"N{10 * number + 10} {line} ; part {number}" if line else line, "", "(nothing) ", "  \t"]
    plain, _ = rows(program())
    other, _ = rows("\n".join(noisy))
    assert np.array_equal(plain.values, other.values)
    assert np.array_equal((plain.line - 1) * 4 + 1, other.line)


@pytest.mark.parametrize("mode", ["G61.1", "G64 P0.05"])
def test_larger_limits_are_never_slower(mode: str) -> None:
    """Every velocity, acceleration and jerk is a quarter larger. From stop to stop a section is a whole number of
    cycles.
    """
    text = list_machine_files()["verne"].read_text("utf-8")
    larger = build_machine(scaled_limits(text, 1.25).encode(), "larger.toml")
    fast = program(mode).replace("F2500", "F20000")
    slow_time, fast_time = (rows(fast, one)[1].cycle_time for one in (load_machine(), larger))
    assert fast_time <= slow_time * (1.0 if mode == "G61.1" else 1.0 + PLANNING)
    assert fast_time < 0.99 * slow_time  # the limits matter here


def scaled_limits(text: str, factor: float) -> str:
    """A machine file with larger rates in [limits]."""
    head, limits = text.split("[limits]", 1)
    lines = limits.split("\n")
    for k, line in enumerate(lines):
        if line.startswith("["):
            break
        key, equals, rest = line.partition("=")
        if equals and any(rate in key for rate in ("velocity", "acceleration", "jerk")):
            number, hash_, remark = rest.partition("#")
            lines[k] = f"{key}= {float(number) * factor!r} {hash_}{remark}"
    return head + "[limits]" + "\n".join(lines)


SQUARES = {
    "rs274": "G21 G90 G94 G17 G61.1\n"
    "T1 M6\n"
    "G43 H1\n"
    "G0 X-10 Y-10 Z30 A0 C0\n"
    "G1 X10 F2000\n"
    "G3 X10 Y10 I0 J10\n"
    "G1 X-10 Y-10\n"
    "G0 Z40\n"
    "M2\n",
    "fanuc": "%\n"
    "O1\n"
    "G21 G90 G94 G17 G61\n"
    "T1 M6\n"
    "G43 H1\n"
    "G0 X-10. Y-10. Z30. A0. C0.\n"
    "G1 X10. F2000.\n"
    "G3 X10. Y10. I0. J10.\n"
    "G1 X-10. Y-10.\n"
    "G0 Z40.\n"
    "M30\n"
    "%\n",
}


def test_two_dialects_make_the_same_part() -> None:
    made = [rows(text, dialect=name, smoothing="off")[0].values for name, text in SQUARES.items()]
    assert np.array_equal(*made)


def test_an_as_built_machine_without_deviations_is_the_nominal_one() -> None:
    from verne_post.calibration.as_built.machine_text import write_machine_text
    from verne_post.model.deviations import Deviations

    raw = list_machine_files()["verne"].read_bytes()
    built = build_machine(
        write_machine_text(raw, Deviations.build_nominal(), "specified: none", "verne.toml").encode(), "built.toml"
    )
    text = program("G61.1")
    nominal, _ = rows(text)
    same, _ = rows(text, built)
    assert np.abs(nominal.values - same.values).max() < ROUNDING_MM


def test_a_program_and_its_reverse_have_the_same_bound() -> None:
    """The fastest profile without jerk limits does not know its direction. Both are found on grids, which begin at
    their starts.
    """
    forth = PLACES[1:]
    bounds = [
        rows(moved(np.vstack([path[:1], path])).replace("{mode}", "G64 P0.05").replace("F2500", "F30000"))[
            1
        ].second_order_bound_s
        for path in (forth, forth[::-1])
    ]
    assert bounds[0] == pytest.approx(bounds[1], rel=1e-3)
    assert bounds[0] > 0
