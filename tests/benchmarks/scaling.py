"""How time and memory grow with a program: 10^3 to 10^6 lines of the blade, with every corner rounded.

Run from the repository's root: python tests/benchmarks/scaling.py [--most 1000000] [--write]
With --write the table goes into docs/performance.md, and docs/pictures/scaling.py draws it. Each size is read, and converted by the
command line, in processes of their own. CPU seconds of one thread; memory as the system counts it for that process alone: what getrusage
tells begins with that of the process which has started it.
"""

import argparse
import os
import platform
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from contouring import blade, processor, table
from page import write_section

from verne_post.cli.arithmetic import settings

ROOT = Path(__file__).resolve().parents[2]
SIZES = (1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000)

_TOLD = """
peak = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(time.process_time(), peak)
"""
READ = f"""
import sys, time
import verne_post.gcode as gcode
with open(sys.argv[1], "rb") as file:
    assert len(gcode.read_moves(file.read()))
{_TOLD}"""
CONVERT = f"""
import sys, time
from verne_post.cli.main import main
assert main(sys.argv[1:]) == 0
{_TOLD}"""


def measure(script: str, *words: str) -> tuple[float, float]:
    """CPU s and peak MiB of a script."""
    run = subprocess.run(
        [sys.executable, "-c", script, *words], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True
    )
    cpu, peak = map(float, run.stdout.split())
    return cpu, peak / 1024


def scaling_table(sizes: list[int]) -> str:
    """A row for each size."""
    rows = []
    for moves in sizes:
        print(f"... {moves} lines", file=sys.stderr)
        with tempfile.TemporaryDirectory() as folder:
            source, target = Path(folder) / "program.nc", Path(folder) / "axes.csv"
            source.write_bytes(blade(moves))
            read = measure(READ, str(source))
            converted = measure(CONVERT, str(source), "--tool-length", "80", "-q", "-o", str(target))
            written = target.stat().st_size / 2**20
        rows.append([f"{moves:,}", f"{read[0]:.2f}", f"{read[1]:.0f}", f"{converted[0]:.2f}", f"{1e6 * converted[0] / moves:.0f}",
                     f"{converted[1]:.0f}", f"{written:.1f}"])  # fmt: skip
    return table(["lines", "read s", "read MiB", "convert s", "us/line", "convert MiB", "file MiB"], rows)


def main() -> None:
    """Measure, print, and with --write put the table into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=int, default=SIZES[-1], help="lines of the longest program")
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    given = parser.parse_args()
    text = "\n\n".join(
        [
            f"One thread of: {processor()}, {datetime.now(UTC):%Y-%m-%d}, Python {platform.python_version()}, "
            f"numpy {np.__version__}.\nEach row is one run; start-up is in it.",
            scaling_table([size for size in SIZES if size <= given.most]).strip("\n"),
        ]
    )
    print(text)
    if given.write:
        write_section("scaling", text)


if __name__ == "__main__":
    # as the command does; libraries read this when they are loaded
    if not settings().items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **settings()})
    main()
