"""One function over many items by several processes: the order, the errors, the ends."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from verne_post.base import processes
from verne_post.base.processes import map_in_order
from verne_post.model.findings import SolverError, finding

pytestmark = pytest.mark.skipif(not processes.can_fork(), reason="a process of this system cannot be forked")

#: Maps until it is killed, and says which processes do it.
MAPPING = """
import os, signal, time
from verne_post.base import processes
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have started the tests without
processes.WORTH_STARTING = -1.0
def work(item):
    time.sleep(0.05)
    return os.getpid()
for pid in processes.map_in_order(work, iter(int, 1), 3):
    print(pid, flush=True)
"""


@pytest.fixture
def _always_worth(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "WORTH_STARTING", -1.0)


@pytest.mark.usefixtures("_always_worth")
def test_results_keep_the_order_of_the_items() -> None:
    offset = 1000  # known to the other processes, and nowhere sent

    def work(item: int) -> tuple[int, int]:
        time.sleep(0.02 * (item % 3))
        return item + offset, os.getpid()

    values, pids = zip(*map_in_order(work, range(13), 3), strict=True)
    assert values == tuple(range(1000, 1013))
    assert pids[0] == os.getpid()  # the first one shows whether others are worth it
    assert pids[1:] == pids[1:4] * 4
    assert len(set(pids)) == 3
    assert multiprocessing.active_children() == []


def test_quick_or_few_items_are_worked_on_here(monkeypatch: pytest.MonkeyPatch) -> None:
    assert set(map_in_order(lambda _item: os.getpid(), range(1000), 2)) == {os.getpid()}
    assert list(map_in_order(len, [], 2)) == []
    monkeypatch.setattr(processes, "WORTH_STARTING", -1.0)
    assert set(map_in_order(lambda _item: os.getpid(), range(8), 1)) == {os.getpid()}


@pytest.mark.usefixtures("_always_worth")
def test_items_are_not_taken_far_ahead() -> None:
    taken = []

    def items() -> Iterator[int]:
        for item in range(10_000):
            taken.append(item)
            yield item

    results = map_in_order(lambda item: -item, items(), 2)
    assert [next(results) for _ in range(100)] == [-item for item in range(100)]
    assert len(taken) <= 100 + processes.SEEN_ITEMS
    results.close()  # type: ignore[attr-defined]
    assert multiprocessing.active_children() == []


@pytest.mark.usefixtures("_always_worth")
def test_an_error_comes_when_its_item_is_reached(capfd: pytest.CaptureFixture[str]) -> None:
    here = os.getpid()

    def work(item: int) -> int:
        if os.getpid() != here:
            print("said")  # noqa: T201 - another process has nowhere to say it
        if item == 5:
            raise SolverError(finding("VP420", "too fast", line=7))
        return item

    done = []
    with pytest.raises(SolverError) as caught:
        done.extend(map_in_order(work, range(1, 9), 2))
    assert caught.value.findings[0].line == 7
    assert capfd.readouterr().out == ""
    results = map_in_order(work, range(1, 9), 2)
    assert [next(results) for _ in range(4)] == [1, 2, 3, 4]
    with pytest.raises(SolverError):
        next(results)


@pytest.mark.usefixtures("_always_worth")
def test_a_killed_process_is_named() -> None:
    here = os.getpid()

    def work(item: int) -> int:
        if item >= 5 and os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    with pytest.raises(ChildProcessError, match="was killed"):
        list(map_in_order(work, range(9), 2))


def is_running(pid: int) -> bool:
    """False for one that has ended, though nobody may have asked yet how."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_processes_end_with_the_one_that_started_them(
    ending: signal.Signals, tmp_path: Path, environment: dict[str, str]
) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", MAPPING],
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ) as process:
        assert process.stdout is not None
        pids = {int(process.stdout.readline()) for _ in range(8)} - {process.pid}
        process.send_signal(ending)
        assert process.wait(timeout=30) != 0
    assert len(pids) == 2
    until = time.monotonic() + 30
    while any(is_running(pid) for pid in pids):
        assert time.monotonic() < until, "they go on"
        time.sleep(0.02)
