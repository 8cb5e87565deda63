"""How time and memory grow with a program: 10^3 to 10^6 lines of the blade, with every corner rounded.

Run from the repository's root: python tests/benchmarks/scaling.py [--most 1000000] [--write]
With --write the tables go into docs/performance.md, and docs/pictures/scaling.py draws the first. Each size is read,
and converted by the command line, in processes of their own: CPU seconds of one thread, and memory as the system counts
it for that process alone (what getrusage tells begins with that of the process which has started it). The second table
has the time that passes with one and with two processes of --jobs.
"""

import argparse
import math
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from contouring import blade, table
from page import processor, write_section

from verne_post.cli.arithmetic import choose_settings

ROOT = Path(__file__).resolve().parents[2]
SIZES = (1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000)
#: Lines of the programs that several processes convert.
SHARED_SIZES = (10_000, 100_000, 1_000_000)

_TOLD = """
peak = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(time.process_time(), peak)
"""
READ = f"""
import sys, time
import verne_post.gcode as gcode
with open(sys.argv[1], "rb") as file:
    assert len(gcode.interpret_plainly(file.read()))
{_TOLD}"""
CONVERT = f"""
import sys, time
from verne_post.cli.main import main
assert main(sys.argv[1:]) == 0
{_TOLD}"""


def measure(script: str, *words: str) -> tuple[float, float]:
    """CPU s and peak MiB of a script. Modules must be compiled, as pip leaves them: else starting takes 0.3 s more."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-c", script, *words]
    run = subprocess.run(
        command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True
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
        rows.append(
            [
                f"{moves:,}",
                f"{read[0]:.2f}",
                f"{read[1]:.0f}",
                f"{converted[0]:.2f}",
                f"{1e6 * converted[0] / moves:.0f}",
                f"{converted[1]:.0f}",
                f"{written:.1f}",
            ]
        )
    return table(["lines", "read s", "read MiB", "convert s", "us/line", "convert MiB", "file MiB"], rows)


def shared_table(sizes: list[int]) -> str:
    """A row for each size: the seconds that pass, start-up included; the least of some runs by turns where they are
    short.
    """
    rows = []
    for moves in sizes:
        print(f"... {moves} lines by two processes", file=sys.stderr)
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) / "program.nc"
            source.write_bytes(blade(moves))
            least = [math.inf, math.inf]
            for _ in range(max(100_000 // moves, 1)):
                for index in range(2):
                    begun = time.perf_counter()
                    words = [str(source), "--tool-length", "80", "-q", "-o", f"{folder}/axes.csv", "-j", str(index + 1)]
                    subprocess.run([sys.executable, "-m", "verne_post", *words], cwd=ROOT, check=True)
                    least[index] = min(least[index], time.perf_counter() - begun)
        rows.append([f"{moves:,}", *(f"{seconds:.2f}" for seconds in least), f"{least[1] / least[0]:.2f}"])
    return table(["lines", "-j 1 s", "-j 2 s", "ratio"], rows)


def main() -> None:
    """Measure, print, and with --write put the tables into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=int, default=SIZES[-1], help="lines of the longest program")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/performance.md")
    given = parser.parse_args()
    machine = f"{processor()}, Python {platform.python_version()}"
    shared = shared_table([size for size in SHARED_SIZES if size <= given.most]).strip("\n")
    text = "\n\n".join(
        [
            "Each row is one run; start-up is in it.",
            scaling_table([size for size in SIZES if size <= given.most]).strip("\n"),
        ]
    )
    print(text, shared, sep="\n\n")
    if given.write:
        write_section("scaling", text, ran=f"one thread of {machine}, numpy {np.__version__}")
        write_section("cores", shared, ran=f"two cores of {machine}")


if __name__ == "__main__":
    # as the command does; libraries read this when they are loaded
    if not choose_settings().items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **choose_settings()})
    main()
