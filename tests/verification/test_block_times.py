"""Blocks whose feed rate is a time take that time: planning, the summary and verification, each by the rows of the
file.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

import verne_post
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.verification import Verification
from verne_post.output.summary import format_summary, format_verdict

from ..benchmarks.inverse_time import random_program, time_blocks
from ..builders import two_machines
from .test_verifier import codes

#: Blocks are measured from first row to first row: a cycle more or less.
CYCLE = 0.001
MACHINES = two_machines(CYCLE)
#: A block takes at most 1 % and two cycles more where no joint limit holds it back.
SHARE, CYCLES = 1.01, 2.0
OPTIONS = Options(tool_length=60.0, wcs={1: WorkOffset((0.0, 0.0, 30.0))})
HEAD = "G21 G90 G94 G17\nG0 X30 Y0 Z40 A20 C0\n"
#: The tip hardly moves, and not evenly, while C turns at 10 deg/s.
HARDLY = "G93\nG1 C20 X30.01 F30\nC40 X30.03 F30\nC60 X30.031 F30\nC80 X30.061 F30\nM2\n"


def block_times(text: str, name: str, options: Options = OPTIONS) -> tuple[dict[int, float], verne_post.Result]:
    """Seconds that each line takes in the file."""
    result = verne_post.convert(text, MACHINES[name], options)
    assert result.ok, [item.message for item in result.findings]
    assert result.setpoints is not None
    line = np.asarray(result.setpoints.line)
    first = np.flatnonzero(np.diff(line, prepend=-1))
    ends = np.append(first[1:], len(line) - 1)
    return dict(zip(line[first].tolist(), (CYCLE * (ends - first)).tolist(), strict=True)), result


@pytest.mark.parametrize("name", ["verne", "serial"])
def test_inverse_time_is_kept_where_the_tip_hardly_moves(name: str) -> None:
    """A blend gives the tip's motion of one block to the next: 2.2, 1.3, 21.9 and 1.8 s when feed was counted by the
    tip.
    """
    taken, result = block_times(HEAD + HARDLY, name)
    inner = [taken[5], taken[6]]
    assert all(2.0 - CYCLE <= seconds <= SHARE * 2.0 + CYCLES * CYCLE for seconds in inner), taken
    # the first and the last block have the ramps of C: 10 deg/s within 1000 deg/s2 and the jerk limit
    assert all(2.0 - CYCLE <= taken[line] < 2.03 for line in (4, 7)), taken
    text = " ".join(format_summary(result.summary).split())
    assert re.search(
        r"(1 of 4 blocks with a programmed time takes|2 of 4 blocks with a programmed time take) longer; "
        r"line [47] is the worst: 2\.02\d s for 2\.000 s",
        text,
    )


@pytest.mark.parametrize("travel", [0.0, 1e-7, 1e-6, 1e-4, 0.003, 0.03, 0.3, 1.0])
def test_the_time_does_not_depend_on_how_far_the_tip_goes(travel: float) -> None:
    """A micrometre here and none there, or what arithmetic leaves of nothing."""
    x, blocks = 30.0, []
    for k, share in enumerate((1.0, 1.0, 0.1, 1.0), start=1):
        x += share * travel
        blocks.append(f"G1 X{x:.9f} C{20 * k} F30")
    taken, _result = block_times(HEAD + "G93\n" + "\n".join(blocks) + "\nM2\n", "serial")
    assert all(2.0 - CYCLE <= taken[line] < 2.03 for line in (4, 5, 6, 7)), taken


def test_one_block_that_takes_its_time_is_told_in_the_singular() -> None:
    _taken, result = block_times(HEAD + "G93\nG1 X60 F3\nM2\n", "serial")
    assert "; the one block with a programmed time takes it" in " ".join(format_summary(result.summary).split())


def test_many_short_blocks_take_the_sum_of_their_times() -> None:
    """Forty blocks of 0.2 s with jitter of a micrometre took 3.6 s."""
    rng = np.random.default_rng(4)
    x, y = 30 + rng.integers(-1, 2, 40) * 1e-3, rng.integers(-1, 2, 40) * 1e-3
    lines = [f"G1 X{x[k]:.3f} Y{y[k]:.3f} A{20 + 0.1 * k:.1f} C{k + 1} F300" for k in range(40)]
    taken, _result = block_times(HEAD + "G93\n" + "\n".join(lines) + "\nM2\n", "verne")
    inner = [seconds for line, seconds in taken.items() if 4 < line < 43]
    assert sum(inner) == pytest.approx(38 * 0.2, abs=0.01)
    assert min(inner) >= 0.2 - CYCLE
    assert max(inner) <= SHARE * 0.2 + CYCLES * CYCLE


def test_a_place_that_holds_the_motion_back_slows_only_its_own_rows() -> None:
    """Between a fast block and a slow one a joint is at its limit in the corner; the rest of the slow block took 16 ms
    longer.
    """
    blocks = ["Y0.0003 Z39.9999 A20.0552 C0.0018 F512.01", "X30.0012 C1.9623 F512.01"]
    blocks += [
        "X30.0011 Y-0.0004 Z39.9943 A20.0652 C1.9729 F110.64",
        "X30.0021 Y-0.0082 Z40.0077 A20.0393 C1.9733 F110.64",
    ]
    taken, _result = block_times(HEAD + "G93\nG1 " + "\n".join(blocks) + "\nM2\n", "verne")
    assert 60 / 110.64 - CYCLE <= taken[6] <= SHARE * 60 / 110.64 + CYCLES * CYCLE


#: Blocks of 12.3 cycles of 4 ms; two and two are blended, with a standstill between.
BRIEF = 12.3 * 0.004
STANDSTILLS = {
    "turn back": "{0}X30.01 C0.01{1}\n{0}Y0.01{1}\n{0}Y0{1}\n{0}X30.0 C0{1}\n",
    "exact stop": "{0}X30.01 C0.01{1}\n{0}Y0.01{1}\nG61.1 {0}X30.0{1}\nG64 {0}Y0 C0{1}\n{0}X30.01{1}\n",
    "dwell": "{0}X30.01 C0.01{1}\n{0}Y0.01{1}\nG4 P0.1\n{0}X30.0 C0{1}\n{0}Y0{1}\n",
    "short dwell": "{0}X30.01 C0.01{1}\n{0}Y0.01{1}\nG4 P0.004\n{0}X30.0 C0{1}\n{0}Y0{1}\n",
}


@pytest.mark.parametrize("name", ["verne", "serial"])
@pytest.mark.parametrize("between", STANDSTILLS)
def test_a_standstill_makes_no_block_late_where_no_joint_needs_it(between: str, name: str) -> None:
    """With two cycles of rest the block after the standstill took 15 cycles."""
    text = HEAD + "G93\n" + STANDSTILLS[between].format("G1 ", f" F{60 / BRIEF:.6f}") + "M2\n"
    result = verne_post.convert(text, MACHINES[name], replace(OPTIONS, cycle=0.004))
    assert result.ok, [item.message for item in result.findings]
    assert result.setpoints is not None
    rows = np.asarray(result.setpoints.line)
    for number, line in enumerate(text.splitlines(), start=1):
        if "G1 " in line:
            begin = np.searchsorted(rows, number)
            end = min(np.searchsorted(rows, number + 1), len(rows) - 1)
            assert 12 <= end - begin <= 14, (line, end - begin)


@pytest.mark.parametrize(
    ("seed", "line", "before", "most"),
    [
        # a ramp from rest and a change of speed at the other end lose less than a row each, and one together
        (639, 7, 44, 43),
        (158, 8, 24, 23),
        # between slow blocks, with no joint above half of a limit; the optimum (--quality) takes 41
        (654, 8, 73, 60),
        # the table has no time to reach the feed rate: a lower peak within its jerk takes less than the profile
        (342, 8, 71, 56),
    ],
)
def test_late_blocks_of_the_study_of_random_programs(seed: int, line: int, before: int, most: int) -> None:
    """Cycles of 4 ms that blocks took, ``before``, and take at most."""
    text, asked = random_program(seed)
    found = time_blocks(text, verne_post.load_machine(("verne", "serial")[seed % 2]), 0.004, list(asked))
    assert found is not None
    cycles = round(found[0][list(asked).index(line)] / 0.004)
    assert asked[line] / 0.004 - 1 <= cycles <= most < before


@pytest.mark.parametrize(
    ("head", "blocks", "seconds"),
    [
        # degrees per minute: A and C turn one after the other, with a corner that is blended between
        ("", ["G1 A21 F600", "C1", "A22", "C2", "A23", "C3"], [0.1] * 6),
        ("G93\n", ["G5 X40 Y0 I3 J9 P-3 Q9 F60", "G5 X50 Y4 I3 J-9 P-3 Q5 F20"], [1.0, 3.0]),
        ("G93\n", ["G1 X31 C9 F40", "G3 X29 I-1 C0 F30", "G1 Y0.001 C-9 F20"], [1.5, 2.0, 3.0]),
    ],
)  # fmt: skip
def test_no_block_takes_less_than_its_time(head: str, blocks: list[str], seconds: list[float]) -> None:
    taken, result = block_times(HEAD + head + "\n".join(blocks) + "\nM2\n", "serial")
    for spent, wanted in zip(list(taken.values())[-len(seconds) :], seconds, strict=True):
        assert spent >= wanted - CYCLE
    assert result.summary.verification is not None
    assert result.summary.verification.timed_blocks == len(seconds)


def test_inverse_time_of_a_siemens_program() -> None:
    text = (
        "G71 G90 G54 G642\nTRAORI\nG0 X30 Y0 Z40 A20 C0\nG93\nG1 C20 X30.01 F30\nC40 X30.03 F30\nC60 X30.031 F30\nM30\n"
    )
    taken, _result = block_times(text, "serial", replace(OPTIONS, dialect="siemens"))
    assert all(2.0 - CYCLE <= seconds < 2.03 for seconds in list(taken.values())[-3:]), taken


@pytest.mark.parametrize("seed", range(6))
def test_random_blocks_take_their_time(seed: int) -> None:
    """Blocks of 0.05 to 5 s, mixtures of tip and table so slow that no joint limit is near, but at rest at both
    ends.
    """
    rng = np.random.default_rng(seed)
    pose, lines, wanted = np.array([30.0, 0.0, 40.0, 20.0, 0.0]), [], {}
    for number in range(4, 12):
        seconds = float(np.exp(rng.uniform(np.log(0.05), np.log(5.0))))
        way = rng.choice([0.0, 5e-4, 1e-3], 5) * rng.uniform(-1, 1, 5) * [1, 1, 1, 9 * seconds, 9 * seconds]
        way[0] += 5e-4
        pose = np.round(pose + way, 4)
        feed = round(60.0 / seconds, 3)
        lines.append("G1 X{:.4f} Y{:.4f} Z{:.4f} A{:.4f} C{:.4f} F{}".format(*pose, feed))
        wanted[number] = 60.0 / feed
    taken, result = block_times(HEAD + "G93\n" + "\n".join(lines) + "\nM2\n", "verne")
    for number, seconds in wanted.items():
        assert taken[number] >= seconds - CYCLE, number
        if number not in (4, 11):
            assert taken[number] <= SHARE * seconds + CYCLES * CYCLE + 1e-9, number
    assert result.summary.verification is not None
    assert result.summary.verification.timed_blocks == len(wanted)


def test_a_block_of_a_few_micrometres_between_fast_ones_is_not_stepped_over() -> None:
    """At 4 ms its neighbours' steps are longer than its whole way: no row stood on it, and its time was lost
    (VP901).
    """
    blocks = [
        "G93",
        "G1 X30.0849 Y0.0490 Z40.0561 A18.4731 F5.2474",
        "X30.1894 Y-0.3120 Z39.9961 A18.4732 C-0.0155 F706.17",
        "X30.1860 Y-0.3119 Z39.9982 F706.17",
        "X35.4110 Y1.2525 Z43.2296 A18.8864 C0.0692 F706.17",
        "X35.4122 Y1.2518 Z43.2302 C-0.6301 F131.53",
        "X35.3682 Y0.2538 Z43.9710 A21.0273 C2.9711 F131.53",
        "M2",
        "",
    ]
    result = verne_post.convert(HEAD + "\n".join(blocks), MACHINES["verne"], replace(OPTIONS, cycle=4 * CYCLE))
    assert result.ok, [item.message for item in result.findings]
    assert result.setpoints is not None
    rows = np.count_nonzero(np.asarray(result.setpoints.line) == 6)
    assert 4 * CYCLE * (rows + 1) >= 60 / 706.17


# --- verification -------------------------------------------------------------------------------------------


def verdict_on(made_for: str, asked: str, name: str = "serial") -> Verification:
    """What verification says of the file of one program, against another one with the same lines."""
    result = verne_post.convert(HEAD + made_for, MACHINES[name], OPTIONS)
    assert result.ok
    assert result.setpoints is not None
    return verne_post.verify(result.setpoints, HEAD + asked, MACHINES[name], OPTIONS)


def test_a_block_that_is_too_short_is_refused() -> None:
    """As files were written before: block 5 in 1.34 s, the others long enough."""
    verdict = verdict_on(HARDLY.replace("X30.03 F30", "X30.03 F44.9"), HARDLY)
    assert codes(verdict) == {"VP404"}
    assert [item.line for item in verdict.findings] == [5]


def test_blocks_that_are_too_short_together_are_refused() -> None:
    """Twenty blocks of 0.1 s, each of them 0.9 cycles short: no one by itself is certain, all together are."""
    lines = [f"G1 X{30 + 0.001 * (k % 2):.3f} C{0.5 * (k + 1)} F600" for k in range(20)]
    asked = "G93\n" + "\n".join(lines) + "\nM2\n"
    verdict = verdict_on(asked.replace("F600", f"F{60 / 0.0991:.3f}"), asked)
    assert codes(verdict) == {"VP404"}
    assert verdict.feed_ratio < 1.02


def test_a_block_that_is_too_long_is_told() -> None:
    """It is no fault: F is a cap."""
    verdict = verdict_on(HARDLY.replace("X30.031 F30", "X30.031 F3"), HARDLY)
    assert verdict.ok
    latest = verdict.latest_block
    assert latest is not None
    assert (latest.line, latest.asked_s) == (6, 2.0)
    assert latest.spent_s == pytest.approx(20.0, abs=0.05)
    line = format_verdict("a.csv", verdict, MACHINES["serial"], passes=True)
    assert "line 6 is the worst: 20.0" in line
