"""Work on several cores: processes that run the same program side by side and share the work of its maps."""

import os
import pickle
import signal
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from itertools import chain, islice, pairwise
from typing import TYPE_CHECKING, Any, Final, TypeVar

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

Item = TypeVar("Item")
Result = TypeVar("Result")

#: Of prctl: the signal that a process gets when the one that started it ends (linux/prctl.h).
_PR_SET_PDEATHSIG: Final = 1
#: Items of a map that each process works on before they exchange results. With more, more items wait in memory. With
#: fewer, the work is less even: two processes take 2 % longer with 2 and 4, and no less with 16 and 32.
ROUND: Final = 8


def can_fork() -> bool:
    """True where a process may fork into several that share its results; libraries of macOS do not survive that."""
    return sys.platform.startswith("linux")


class Team:
    """Processes that run the same program from the same state on (single program, multiple data).

    Each of them executes every line. In :meth:`map` a process works on some of the items only, and receives the results
    of the others. So they stay alike, and functions and items may hold anything. What must happen once is done by the
    process that :attr:`leads`.
    """

    def __init__(self, rank: int, size: int, links: "tuple[Connection, ...]") -> None:
        self._rank, self._size = rank, size
        #: To all the others for the process that leads, to that one for the others.
        self._links = links

    @property
    def leads(self) -> bool:
        """True in the process that there was before, and that goes on after the others."""
        return self._rank == 0

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        """Results of a function for each item, in their order; those of other processes are copies, by pickle.

        Item k is for process k, modulo their number. What the function changes, it changes there alone.

        An error of the function is raised when its item is reached.

        Raises
        ------
        ChildProcessError
            Another process was killed. One that ended by an error of its own raises that.
        """
        if self._size == 1:
            yield from map(function, items)
            return
        rest = iter(items)
        while some := list(islice(rest, ROUND * self._size)):
            parts = self._exchange([_try(function, item) for item in some[self._rank :: self._size]])
            for number in range(len(some)):
                result, error = parts[number % self._size][number // self._size]
                if error is not None:
                    raise error
                yield result

    def _exchange(self, mine: list[Any]) -> list[list[Any]]:
        """What each process has, by rank."""
        packed = pickle.dumps(mine, pickle.HIGHEST_PROTOCOL)
        killed = ChildProcessError(None, "was killed, perhaps for want of memory", _PROCESS)
        complete = True
        try:
            if self.leads:
                every = [packed, *(link.recv_bytes() for link in self._links)]
                complete = self._spread(every)
            else:
                (link,) = self._links
                link.send_bytes(packed)
                every = [packed if rank == self._rank else link.recv_bytes() for rank in range(self._size)]
        except (EOFError, ConnectionError):
            raise killed from None
        parts = [mine if rank == self._rank else pickle.loads(part) for rank, part in enumerate(every)]
        for part in parts:
            if isinstance(part, Exception):
                raise part
        if not complete:
            raise killed
        return parts

    def _spread(self, every: list[bytes]) -> bool:
        """Send each other process what the rest has; False where one is there no more, which may have reported why."""
        complete = True
        for rank, link in enumerate(self._links, start=1):
            for other, part in enumerate(every):
                if other != rank:
                    try:
                        link.send_bytes(part)
                    except ConnectionError:
                        complete = False
        return complete

    def report_failure(self, error: Exception) -> None:
        """Send the leading process an error in the place of results, before this one ends outside of a map."""
        (link,) = self._links
        with suppress(OSError, TypeError, AttributeError, pickle.PicklingError):
            link.send_bytes(pickle.dumps(error, pickle.HIGHEST_PROTOCOL))


#: What errors name that have no file.
_PROCESS: Final = "a process of --jobs"
#: One process.
ALONE: Final = Team(0, 1, ())


@contextmanager
def work_together(jobs: int) -> Iterator[Team]:
    """Go on as so many processes up to the end of the ``with``, where all but this one end."""
    if jobs == 1:
        yield ALONE
        return
    from multiprocessing import Pipe  # slow to import

    pairs: list[tuple[Connection, Connection]] = []
    rank, followers, leader = 0, [], os.getpid()
    team = ALONE
    try:
        for number in range(1, jobs):
            try:
                pairs.append(Pipe())
                pid = _fork()
            except OSError as error:
                raise OSError(error.errno, error.strerror, _PROCESS) from None
            if not pid:
                rank = number
                _leave_to_leader(leader)
                break
            followers.append(pid)
        mine = (pairs[rank - 1][1],) if rank else tuple(near for near, _far in pairs)
        for link in chain.from_iterable(pairs):
            if link not in mine:  # whoever holds one would keep the other end from seeing that its process has ended
                link.close()
        team = Team(rank, jobs, mine)
        yield team
    except Exception as error:
        if not team.leads:
            team.report_failure(error)
        raise
    finally:
        if os.getpid() != leader:
            os._exit(0)
        for link in chain.from_iterable(pairs):
            link.close()
        for pid in followers:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
            with suppress(ChildProcessError):  # a program may have said that nobody waits for its processes
                os.waitpid(pid, 0)


def split_evenly(n: int, most: int) -> list[tuple[int, int]]:
    """First and last (excluded) of parts of n items, none above ``most``; an even number of parts, or one."""
    count = -(-n // most)
    count += count > 1 and count % 2
    return list(pairwise(n * number // max(count, 1) for number in range(count + 1)))


def _fork() -> int:
    with warnings.catch_warnings():
        # of forking beside threads: those of the linear algebra rest meanwhile
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def _leave_to_leader(leader: int) -> None:
    """In a new process: end with the one that leads, and leave alone its streams, and its answers to signals."""
    from ctypes import CDLL  # numpy imports it too

    CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL))
    if os.getppid() != leader:  # it has ended before
        os._exit(0)
    sys.stdout = sys.stderr = None
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal interrupts all processes; the one that leads says so
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:  # as nohup has it
            signal.signal(number, signal.SIG_DFL)


def _try(function: Callable[[Item], Result], item: Item) -> tuple[Result | None, Exception | None]:
    """The result for an item, or the error."""
    try:
        return function(item), None
    except Exception as error:
        return None, error
