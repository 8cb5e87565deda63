"""How long the blocks of random programs in G93 take: python -m tests.benchmarks.inverse_time [FIRST LAST].

Three to twelve blocks of 0.05 to 20 s: jitter of the tip beside a turning table, moves of the tip, turns, and all
mixtures. A block lasts from its first row to the first row of the next. It is late where it takes more than 1 % and two
cycles longer than it asks for; then the largest share of any joint limit in its rows says whether a joint holds it
back. Rows are means over the cycle, so a joint may hold back a block whose rows stay below its limits: such blocks are
tried on the same machine with limits so large that no joint holds anything back.
"""

import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np

import verne_post
from verne_post.base.arrays import Array
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset

#: Late blocks are counted by the largest share of a limit that a joint has in them.
SHARES = (0.3, 0.5, 0.7, 0.9)
#: A step at the feed rate may be shorter by this share of a cycle (``tuning.ACCEPTED_RATIOS``).
SLACK = 1e-3
#: Machines whose limits are so many times as large. A ramp within a jerk limit is shorter by the root of it: of 16 rows
#: 3 are left at 30 times the jerk.
LOOSE = (30.0, 1000.0)


def random_program(seed: int) -> tuple[str, dict[int, float]]:
    """A program, and the seconds of its lines."""
    rng = np.random.default_rng(seed)
    count, style = int(rng.integers(3, 13)), int(rng.integers(0, 4))
    pose, lines, asked = np.array([30.0, 0.0, 40.0, 20.0, 0.0]), ["G21 G90 G94", "G0 X30 Y0 Z40 A20 C0", "G93"], {}
    seconds = 1.0
    for _ in range(count):
        kind = int(rng.integers(0, 5)) if style == 0 else style
        if not (style and asked and rng.random() < 0.5):
            seconds = float(np.exp(rng.uniform(np.log(0.05), np.log(20.0))))
        way, most = np.zeros(5), 20.0 * min(seconds, 4.0)
        if kind in (0, 2, 3):
            way[:3] = rng.choice([0.0, 1e-3, 1e-3, 1e-2, 3e-2, 0.1], 3) * rng.uniform(-1, 1, 3)
        if kind in (1, 4):
            direction = rng.normal(size=3)
            way[:3] = np.exp(rng.uniform(np.log(1e-3), np.log(20.0))) * direction / np.linalg.norm(direction)
        if kind in (0, 1, 2):
            way[3:] = rng.choice([0.0, 1e-3, 0.1, 1.0, 1.0], 2) * rng.uniform(-1, 1, 2) * [0.3 * most, most]
        if style == 2:
            way[3:] = [0.1 * way[3], abs(way[4])]
        new = np.round(np.clip(pose + way, [-40, -40, 20, 2, -170], [40, 40, 60, 40, 170]), 4)
        moved = np.abs(new - pose) > 1e-5
        if moved.any():
            words = " ".join(f"{w}{v:.4f}" for w, v, m in zip("XYZAC", new, moved, strict=True) if m)
            feed = float(f"{60 / seconds:.5g}")
            lines.append(f"G1 {words} F{feed:.8g}")
            asked[len(lines)] = 60 / feed
            pose = new
    return "\n".join([*lines, "M2", ""]), asked


def largest_shares(values: Array, machine: Machine, cycle: float) -> Array:
    """Largest share of a limit (n,) in the differences that each row is part of."""
    size = np.abs([column.factor for column in machine.columns])
    shares, difference = np.zeros(len(values)), np.pad(values, ((3, 3), (0, 0)), mode="edge")
    for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1):
        difference = np.diff(difference, axis=0) / cycle
        share = (np.abs(difference) / (getattr(machine.limits, name) * size)).max(axis=1)
        for k in range(order + 1):
            shares = np.maximum(shares, share[3 - k : 3 - k + len(values)])
    return shares


def loosen(machine: Machine, factor: float) -> Machine:
    """The same machine with larger limits of velocity, acceleration and jerk."""
    limits = machine.limits
    scaled = {name: factor * getattr(limits, name) for name in ("velocity", "acceleration", "jerk")}
    return replace(machine, limits=replace(limits, **scaled))


def time_blocks(text: str, machine: Machine, cycle: float, lines: list[int]) -> tuple[Array, Array] | None:
    """Seconds that the blocks of lines (n,) take, and their largest share of a limit; None where the program is
    refused.
    """
    options = Options(tool_length=60.0, wcs={1: WorkOffset((0.0, 0.0, 30.0))}, cycle=cycle)
    result = verne_post.convert(text, machine, options)
    if not result.ok or result.setpoints is None:
        print([item.message for item in result.findings])
        return None
    line, shares = np.asarray(result.setpoints.line), largest_shares(result.setpoints.values, machine, cycle)
    begins = np.append(np.searchsorted(line, lines), len(line) - 1)
    most = [shares[begin : end + 1].max() for begin, end in pairwise(begins)]
    return cycle * np.diff(begins), np.array(most)


def study(first: int, last: int) -> None:
    """Print what the blocks of some programs take."""
    machines = [verne_post.load_machine(name) for name in ("verne", "serial")]
    blocks = short = late = refused = 0
    unheld = dict.fromkeys(LOOSE, 0)
    below = dict.fromkeys(SHARES, 0)
    for seed in range(first, last):
        text, asked = random_program(seed)
        if not asked:
            continue
        seconds, machine = np.array(list(asked.values())), machines[seed % 2]
        total = seconds.sum()
        cycle = 0.001 if total < 8 else 0.002 if total < 25 else 0.004
        found = time_blocks(text, machine, cycle, list(asked))
        if found is None:
            refused += 1
            continue
        spent, most = found
        allowed = 1.01 * seconds + (2 + SLACK) * cycle
        blocks += len(spent)
        short += int((spent < (1 - SLACK) * seconds - cycle).sum())
        late += int((spent > allowed).sum())
        for share in SHARES:
            below[share] += int(((spent > allowed) & (most < share)).sum())
        doubtful = (spent > allowed) & (most < SHARES[-1])
        for factor in LOOSE if doubtful.any() else ():
            loose = time_blocks(text, loosen(machine, factor), cycle, list(asked))
            still = doubtful if loose is None else doubtful & (loose[0] > allowed)
            unheld[factor] += int(still.sum())
            names = [f"{line} of {seed}" for line, one in zip(asked, still, strict=True) if one]
            if names:
                print(f"late at {factor:g} times the limits: line " + ", ".join(names))
    print(f"{blocks} blocks of programs {first} to {last - 1}, {refused} refused: {short} short, {late} late")
    print("late with no joint above: " + ", ".join(f"{share} of a limit {count}" for share, count in below.items()))
    for factor, count in unheld.items():
        print(f"of those below {SHARES[-1]} late too where limits are {factor:g} times as large: {count}")


if __name__ == "__main__":
    study(*(int(word) for word in sys.argv[1:3] or (0, 2000)))
