"""Where the time of a conversion goes, by package, and beside it the least that any program of the kind must do.

Run from the repository's root: python tests/benchmarks/profile_packages.py [--lines 100000] [--write]
With --write the table goes into docs/performance.md. A timer of CPU time notes each millisecond which file of
verne_post is executed, or has called what is executed (numpy, the interpreter). The floor: one scan of the text, one
inverse and one forward solution of each row, its digits.
"""

import argparse
import os
import platform
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from types import FrameType

import numpy as np
from contouring import blade, table
from page import processor, write_section

import verne_post as vp
from verne_post.app.convert import convert_source
from verne_post.cli.arithmetic import choose_settings
from verne_post.output.fixed_point import format_rows
from verne_post.output.setpoints import write_csv_rows

#: CPU time between two looks, s.
INTERVAL = 0.001
#: Packages below it have no row.
LEAST_SHARE = 0.005
#: Of the floor, as many as rows of the VERNE have.
DECIMALS = 7
PACKAGE = str(Path(vp.__file__).resolve().parent)


def profile(source: bytes, machine: vp.Machine, options: vp.Options) -> tuple[dict[str, float], list[np.ndarray]]:
    """Shares of CPU time by package, and the blocks of rows as written."""
    looks, blocks = Counter[str](), []

    def look(_signal: int, frame: FrameType | None) -> None:
        while frame is not None and not frame.f_code.co_filename.startswith(PACKAGE):
            frame = frame.f_back
        where = "elsewhere" if frame is None else frame.f_code.co_filename[len(PACKAGE) + 1 :].partition("/")[0]
        looks[where.removesuffix(".py")] += 1

    def take(block: object) -> None:
        write_csv_rows(block)  # as convert writes it
        blocks.append(block.written)

    signal.signal(signal.SIGPROF, look)
    signal.setitimer(signal.ITIMER_PROF, INTERVAL, INTERVAL)
    result = convert_source(source, machine, options, take)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    assert result.ok, result
    whole = sum(looks.values())
    return {name: count / whole for name, count in looks.most_common()}, blocks


def measure_floor(source: bytes, machine: vp.Machine, tool_length: float, blocks: list[np.ndarray]) -> float:
    """CPU s of what no converter can leave out."""
    begin = time.process_time()
    text = np.frombuffer(source, np.uint8)
    np.flatnonzero(text == ord("\n"))
    np.flatnonzero((text >= ord("0")) & (text <= ord("9")))
    for rows in blocks:
        joints = np.column_stack([rows[:, :3], np.deg2rad(rows[:, 3:])])
        tip, axis, _ok = machine.five_axis.forward(joints, tool_length)
        machine.five_axis.inverse(tip, axis, tool_length)
        format_rows([*rows.T], [DECIMALS] * rows.shape[1], ",")
    return time.process_time() - begin


def main() -> None:
    """Print the table, or write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lines", type=int, default=100_000)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    source, machine = blade(given.lines), vp.load_machine("verne")
    options = vp.Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 10.0)})
    begin = time.process_time()
    shares, blocks = profile(source, machine, options)
    taken = time.process_time() - begin
    floor = measure_floor(source, machine, 80.0, blocks)
    rows = [[f"`{name}`", f"{100 * share:.0f} %"] for name, share in shares.items() if share >= LEAST_SHARE]
    rows.append(
        ["the floor: text scan, one inverse and one forward solution per row, digits", f"{100 * floor / taken:.0f} %"]
    )
    text = "\n\n".join(
        [
            f"{given.lines:,} lines of the blade, {sum(map(len, blocks)):,} rows, {taken:.1f} s of CPU.",
            table(["package", "share of the time"], rows).strip("\n"),
        ]
    )
    print(text)
    if given.write:
        write_section("packages", text, ran=f"{processor()}, Python {platform.python_version()}")


if __name__ == "__main__":
    # as the command does; libraries read this when they are loaded
    if not choose_settings().items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **choose_settings()})
    main()
