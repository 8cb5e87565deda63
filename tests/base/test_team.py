"""Processes that run the same program and share its maps: what each knows, the order, the errors, the ends."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from verne_post.base import team as teams
from verne_post.base.team import ALONE, split_evenly, work_together
from verne_post.model.findings import SolverError, make_finding

needs_fork = pytest.mark.skipif(not teams.can_fork(), reason="a process of this system cannot be forked")

#: Maps until it is killed, and says which processes do it.
MAPPING = """
import os, signal, time
from verne_post.base.team import work_together
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have started the tests without
def work(item):
    time.sleep(0.01)
    return os.getpid()
with work_together(3) as team:
    for pid in team.map(work, iter(int, 1)):
        if team.leads:
            print(pid, flush=True)
"""


def is_running(pid: int) -> bool:
    """False for one that has ended, though nobody may have asked yet how."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_for_end(pids: Iterable[int]) -> None:
    """Fail where processes go on."""
    until = time.monotonic() + 30
    while any(is_running(pid) for pid in pids):
        assert time.monotonic() < until, "they go on"
        time.sleep(0.02)


@needs_fork
def test_every_process_knows_all_results_in_the_order_of_the_items() -> None:
    offset = 1000  # known to the other processes, and nowhere sent

    def work(item: int) -> tuple[int, int]:
        time.sleep(0.01 * (item % 3))
        return item + offset, os.getpid()

    with work_together(3) as team:
        known = list(team.map(work, range(50)))
        of_each = list(team.map(lambda _rank: (known, os.getpid()), range(3)))
    values, pids = zip(*known, strict=True)
    assert values == tuple(range(1000, 1050))
    assert pids[0] == os.getpid()
    assert len(set(pids[:3])) == 3
    assert all(pids[first : first + 3] == pids[:3] for first in range(0, 48, 3))
    assert of_each == [(known, pid) for pid in pids[:3]]
    assert not any(map(is_running, pids[1:3]))


def test_one_process_maps_like_map() -> None:
    with work_together(1) as team:
        assert team is ALONE
        assert team.leads
        results = team.map(str, iter(range(10)))
        assert list(results) == list(map(str, range(10)))


@needs_fork
def test_maps_of_nothing_and_maps_that_are_not_finished() -> None:
    with work_together(2) as team:
        assert list(team.map(len, [])) == []
        for result in team.map(lambda item: -item, range(100)):
            if result == -20:
                break
        assert list(team.map(lambda item: 2 * item, range(5))) == [0, 2, 4, 6, 8]


@needs_fork
def test_items_are_not_taken_far_ahead() -> None:
    taken = []

    def items() -> Iterator[int]:
        for item in range(10_000):
            taken.append(item)
            yield item

    with work_together(2) as team:
        results = team.map(lambda item: -item, items())
        assert [next(results) for _ in range(100)] == [-item for item in range(100)]
        assert len(taken) <= 100 + 2 * teams.ROUND


@needs_fork
def test_results_may_be_larger_than_what_a_link_holds() -> None:
    with work_together(3) as team:
        assert [len(result) for result in team.map(lambda item: bytes(item << 22), range(5))] == [
            item << 22 for item in range(5)
        ]


@needs_fork
def test_an_error_comes_when_its_item_is_reached(capfd: pytest.CaptureFixture[str]) -> None:
    here = os.getpid()

    def work(item: int) -> int:
        if os.getpid() != here:
            print("said")  # noqa: T201 - another process has nowhere to say it
        if item == 5:
            raise SolverError(make_finding("VP420", "too fast", line=7))
        return item

    done = []
    with work_together(2) as team, pytest.raises(SolverError) as caught:
        done.extend(team.map(work, range(9)))
    assert done == [0, 1, 2, 3, 4]
    assert caught.value.findings[0].line == 7
    assert capfd.readouterr().out == ""


@needs_fork
def test_an_error_between_maps_ends_all() -> None:
    pids = set()
    with pytest.raises(KeyError), work_together(3) as team:
        pids.update(team.map(lambda _item: os.getpid(), range(3)))
        raise KeyError
    assert [pid for pid in pids if is_running(pid)] == [os.getpid()]


@needs_fork
def test_a_killed_process_is_named() -> None:
    here = os.getpid()

    def work(item: int) -> int:
        if item >= 5 and os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    pids = set()
    with pytest.raises(ChildProcessError, match="was killed"), work_together(3) as team:
        pids.update(team.map(lambda _item: os.getpid(), range(3)))
        list(team.map(work, range(9)))
    assert [pid for pid in pids if is_running(pid)] == [os.getpid()]


@needs_fork
@pytest.mark.parametrize("jobs", [1, 2, 3])
def test_an_item_has_its_process_in_every_map(jobs: int) -> None:
    """What a function changes stays there: with an item for each process it goes on from what it did before."""
    counted = 0

    def count(_item: int) -> tuple[int, int]:
        nonlocal counted
        counted += 1
        return counted, os.getpid()

    with work_together(jobs) as team:
        pids = list(team.map(lambda _rank: os.getpid(), range(jobs)))
        found = [list(team.map(count, range(jobs))) for _ in range(3)]
    assert len(set(pids)) == jobs
    assert found == [[(number, pid) for pid in pids] for number in (1, 2, 3)]


@pytest.mark.parametrize(("n", "most", "parts"), [
    (0, 4, 0), (1, 4, 1), (4, 4, 1), (5, 4, 2), (8, 4, 2), (9, 4, 4), (17, 4, 6),
])  # fmt: skip
def test_parts_are_even_and_cover_all(n: int, most: int, parts: int) -> None:
    split = split_evenly(n, most)
    assert len(split) == parts
    assert [row for first, last in split for row in range(first, last)] == list(range(n))
    assert all(0 < last - first <= most for first, last in split)
    assert not split or max(b - a for a, b in split) - min(b - a for a, b in split) <= 1


@needs_fork
@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_processes_end_with_the_one_that_leads(
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
    wait_for_end(pids)


#: Works for itself after a map, and says which processes there are.
ALONE_FOR_LONG = """
import os, signal, sys, time
from verne_post.base.team import work_together
if "ignore" in sys.argv:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
with work_together(2) as team:
    pids = list(team.map(lambda _rank: os.getpid(), range(2)))
    if team.leads:
        print(*pids, flush=True)
    time.sleep(float(sys.argv[1]))
    list(team.map(len, ["a", "b"]))
"""


@needs_fork
@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGTERM])
def test_processes_end_at_once_where_they_exchange_nothing(
    ending: signal.Signals, tmp_path: Path, environment: dict[str, str]
) -> None:
    """They hold the streams of the one that leads, for which its caller waits."""
    with subprocess.Popen(
        [sys.executable, "-c", ALONE_FOR_LONG, "600"], cwd=tmp_path, env=environment, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        pids = list(map(int, process.stdout.readline().split()))
        process.send_signal(ending)
        assert process.stdout.read() == b""  # until nobody has it open any more
    wait_for_end(pids)


@needs_fork
def test_a_hang_up_that_is_ignored_ends_no_process(tmp_path: Path, environment: dict[str, str]) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", ALONE_FOR_LONG, "0.3", "ignore"], cwd=tmp_path, env=environment, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        for pid in map(int, process.stdout.readline().split()):
            os.kill(pid, signal.SIGHUP)
        assert process.wait(timeout=30) == 0


@needs_fork
def test_what_ends_another_process_outside_of_a_map_is_raised() -> None:
    with pytest.raises(OSError, match="No space left"), work_together(3) as team:
        list(team.map(len, ["a", "b", "c"]))
        if not team.leads:
            raise OSError(28, "No space left on device", "somewhere")
        list(team.map(len, ["a", "b", "c"]))


@needs_fork
def test_a_process_that_cannot_be_started_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> int:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(os, "fork", refuse)
    with pytest.raises(OSError, match="a process of --jobs"), work_together(2):
        pass
