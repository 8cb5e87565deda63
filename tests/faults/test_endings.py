"""Commands that are ended by a signal: nothing temporary stays, no process is left, every file is old or whole."""

import os
import random
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.faults.trials import ENDINGS, Ground, killed, limited, together

#: Writes a file that never ends, as a command does; says "writing" once the temporary file is there.
WRITER = """
import itertools, sys
from pathlib import Path
from verne_post.cli.files import RunFiles
from verne_post.cli.temporary import make_temporary_folder, tidy_up_when_ended
tidy_up_when_ended()
def rows():
    print("writing", flush=True)
    for number in itertools.count():
        yield f"{number}\\n"
with make_temporary_folder(Path.cwd()) as folder:
    (folder / "rows").touch()
    RunFiles().write(Path("axes.csv"), "-o", rows())
"""
#: What the next run does first.
NEXT = (
    "from pathlib import Path; from verne_post.cli.files import RunFiles; RunFiles().expect_writing(Path('other.csv'), "
    "'-o')"
)


@contextmanager
def writer(folder: Path, environment: dict[str, str], script: str = WRITER) -> Iterator["subprocess.Popen[bytes]"]:
    """A process that writes; whatever a test finds, none goes on after it."""
    process = subprocess.Popen([sys.executable, "-c", script], cwd=folder, env=environment, stdout=subprocess.PIPE)
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"writing\n"
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("ending", ENDINGS)
def test_what_is_written_meanwhile_does_not_stay(
    tmp_path: Path, environment: dict[str, str], ending: signal.Signals
) -> None:
    (tmp_path / "axes.csv").write_text("old")
    with writer(tmp_path, environment) as process:
        assert len(list(tmp_path.iterdir())) == 3
        process.send_signal(ending)
        process.communicate(timeout=60)
        assert process.returncode in (-ending, 1)  # 1: an interruption that a script does not catch
    left = sorted(path.name for path in tmp_path.iterdir())
    if ending == signal.SIGKILL:
        assert len(left) == 3
        subprocess.run([sys.executable, "-c", NEXT], cwd=tmp_path, env=environment, check=True)
        left = sorted(path.name for path in tmp_path.iterdir())
    assert left == ["axes.csv"]
    assert (tmp_path / "axes.csv").read_text() == "old"


def test_what_a_living_process_writes_stays(tmp_path: Path, environment: dict[str, str]) -> None:
    """And so does what only looks like it: a link, or a file of somebody who named it so."""
    (tmp_path / ".verne-post-link.tmp").symlink_to("axes.csv")
    with writer(tmp_path, environment):
        before = sorted(tmp_path.iterdir())
        subprocess.run([sys.executable, "-c", NEXT], cwd=tmp_path, env=environment, check=True)
        assert sorted(tmp_path.iterdir()) == before


def test_a_signal_that_the_shell_ignores_stays_ignored(tmp_path: Path, environment: dict[str, str]) -> None:
    script = WRITER.replace(
        "import itertools", "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\nimport itertools"
    )
    with writer(tmp_path, environment, script) as process:
        process.send_signal(signal.SIGHUP)
        size = 0
        for _ in range(200):  # it goes on writing
            time.sleep(0.05)
            now = sum(path.stat().st_size for path in tmp_path.iterdir() if path.is_file())
            if now > size > 0:
                break
            size = now
        assert process.poll() is None
        process.terminate()
        process.wait(timeout=60)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "ending", "share"),
    [
        ("convert", signal.SIGTERM, 0.8),
        ("batch", signal.SIGKILL, 0.7),
        ("check", signal.SIGINT, 0.6),
        ("setup", signal.SIGHUP, 0.3),
        ("axis-check", signal.SIGKILL, 0.5),
    ],
)
def test_commands_that_are_ended(ground: Ground, name: str, ending: signal.Signals, share: float) -> None:
    """At some moment of their work; tests/faults/long.py does it at all of them."""
    assert killed(ground, random.Random(0), name, ending, share, 1.5) == []


def test_two_processes_write_the_same_files(ground: Ground) -> None:
    assert together(ground, "convert whole", 2) == []


@pytest.mark.parametrize(
    ("name", "most"), [("convert", 300), ("report", 10_000), ("machine export", 8000), ("machine import", 100)]
)
def test_a_full_disk(ground: Ground, name: str, most: int) -> None:
    """Files may have no more bytes than that: status 2, the disk is named, nothing half is left."""
    assert limited(ground, name, resource.RLIMIT_FSIZE, most) == []


def test_a_full_disk_is_no_fault_of_ours(ground: Ground) -> None:
    ground.clear()

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    run = ground.run("batch", "short.nc", "--tool-length", "60", "-o", "out", "-j", "1", preexec_fn=limit)
    assert run.status == 2
    assert b"internal error" not in run.out + run.err
    assert b"VP022 error: " in run.err
    assert b"File too large" in run.err


@pytest.mark.parametrize("megabytes", [172, 180, 190, 200, 300])
def test_memory_that_ends(ground: Ground, megabytes: int) -> None:
    """Between 176 and 200 MB the BLAS of scipy asked for memory without end while it was loaded."""
    assert limited(ground, "convert whole", resource.RLIMIT_AS, megabytes << 20) == []


def test_a_clock_that_jumps(ground: Ground, tmp_path: Path) -> None:
    """Clocks of every kind go forth and back by days between two calls: the rows are the same, and a batch is done
    once.
    """
    (tmp_path / "sitecustomize.py").write_text(
        "import itertools, time\n"
        "jump = itertools.cycle((0.0, 4e5, -3e5, -9e8))\n"
        "for name in ('time', 'monotonic', 'perf_counter'):\n"
        "    setattr(time, name, lambda real=getattr(time, name): real() + next(jump))\n"
    )
    environment = {
        **ground.environment,
        "PYTHONPATH": os.pathsep.join((str(tmp_path), ground.environment["PYTHONPATH"])),
    }
    good = ground.expect("convert whole")["s.csv"]
    words = ("short.nc", "--tool-length", "60", "--wcs", "G54=0,0,20")
    assert ground.run(*words, env=environment).out == good
    again = tuple(("batch", *words, "-o", "jumps", "-j", "1") for _ in range(2))
    results = [ground.run(*one, env=environment) for one in again]
    assert [one.status for one in results] == [0, 0]
    os.utime(ground.folder / "short.nc", (0, 2**31))
    assert b"1 program: 1 can run (as before)" in ground.run(*again[0], env=environment).out
