"""What more workers make of a program of 10^7 lines, and of 10^4 programs: computed from parts that are measured here.

Run from the repository's root, with the extra `bench`: python tests/benchmarks/workers.py [--lines 1000000] [--write]
With --write the table goes into docs/performance.md. Measured are one program with one and with two processes, and a
folder of programs with one process and with the two workers of a Dask scheduler. What the processes of one program do
not share, and what the scheduler and the command do for each program, no worker more makes shorter.
"""

import argparse
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from contouring import blade, table
from page import processor, write_section

from verne_post.cli.arithmetic import choose_settings

ROOT = Path(__file__).resolve().parents[2]
WORKERS = (1, 2, 10, 100)
LONG_LINES, MANY_PROGRAMS = 10_000_000, 10_000
#: Programs of so many lines, in a folder of so many; and a short folder, whose time is that of starting.
PROGRAM_LINES, FOLDER, SHORT_FOLDER = 1000, 80, 10

#: Two workers; when standard input ends, the CPU time of the process of the scheduler.
CLUSTER = """
import sys, time
from distributed import LocalCluster

if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster:
        print(cluster.scheduler_address, flush=True)
        for _line in sys.stdin:
            print(time.process_time(), flush=True)
"""


def time_command(*words: str) -> tuple[float, float]:
    """Seconds that pass, and CPU seconds of the command and what it starts."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, "-m", "verne_post", *words], cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter() - begun, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure_program(folder: Path, lines: int) -> tuple[float, float]:
    """Seconds of a program that processes do not share, and that they do."""
    source = folder / "long.nc"
    source.write_bytes(blade(lines))
    words = [str(source), "--tool-length", "80", "-q", "-o", str(folder / "axes.csv")]
    alone, shared = (min(time_command(*words, "-j", n)[0] for _ in range(2)) for n in "12")
    return 2.0 * shared - alone, 2.0 * (alone - shared)


def measure_folder(folder: Path) -> tuple[float, float]:
    """Seconds of one program among many, and CPU seconds of scheduler and command for each."""
    for name, count in (("many", FOLDER), ("few", SHORT_FOLDER)):
        (folder / name).mkdir()
        for number in range(count):
            (folder / name / f"{number}.nc").write_bytes(blade(PROGRAM_LINES))

    def convert(name: str, target: str, *more: str) -> tuple[float, float]:
        return time_command("batch", str(folder / name), "-o", str(folder / target), "--tool-length", "80", "-q", *more)

    more = FOLDER - SHORT_FOLDER
    each = (convert("many", "a", "-j", "1")[0] - convert("few", "b", "-j", "1")[0]) / more
    script = folder / "cluster.py"
    script.write_text(CLUSTER, encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=folder
    ) as cluster:
        assert cluster.stdin is not None and cluster.stdout is not None
        address = cluster.stdout.readline().strip()

        def spend(name: str, target: str) -> float:
            """CPU s of scheduler and command."""
            spent = [0.0, 0.0]
            for index in range(2):
                if index:
                    command = convert(name, target, "--scheduler", address)[1]
                print(file=cluster.stdin, flush=True)
                spent[index] = float(cluster.stdout.readline())
            return spent[1] - spent[0] + command

        spend("few", "c")  # the workers load what they need
        dispatch = (spend("many", "d") - spend("few", "e")) / more
        cluster.stdin.close()
    return each, dispatch


def main() -> None:
    """Measure, compute, print; with --write put the table into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lines", type=int, default=1_000_000, help="lines of the program that is measured")
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        own, shared = measure_program(Path(name), given.lines)
        each, dispatch = measure_folder(Path(name))
    longer = LONG_LINES / given.lines
    rows = [
        [f"{n}", f"{longer * (own + shared / n):,.0f}", f"{MANY_PROGRAMS * max(each / n, dispatch):,.0f}"]
        for n in WORKERS
    ]
    measured = (
        f"Of {given.lines:,} lines, "
        f"{own:.1f} s are not\n"
        f"shared and {shared:.1f} s are. A program of {PROGRAM_LINES:,} lines takes {each:.3f} s of a worker, and "
        f"{1000 * dispatch:.1f} ms of\n"
        "scheduler and command."
    )
    heads = ["workers", f"{LONG_LINES:,} lines, -j, s", f"{MANY_PROGRAMS:,} programs, --scheduler, s"]
    text = measured + "\n\n" + table(heads, rows).strip("\n")
    print(text)
    if given.write:
        write_section("workers", text, ran=f"{processor()}, Python {platform.python_version()}")


if __name__ == "__main__":
    # as the command does; libraries read this when they are loaded
    if not choose_settings().items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **choose_settings()})
    main()
