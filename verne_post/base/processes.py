"""Work on several cores: one function over many items, in order, by processes that end with the one that started them."""

import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import partial
from itertools import chain, islice
from time import perf_counter
from typing import TYPE_CHECKING, Final, TypeVar

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

Item = TypeVar("Item")
Result = TypeVar("Result")

#: So many items are looked at before processes are started: with fewer to come, or quick ones, it does not pay.
SEEN_ITEMS: Final = 32
#: Work that is expected to take less, s, is done by this process: to start and end another one takes some 5 ms.
WORTH_STARTING: Final = 0.05
#: Bytes of results that wait to be taken, from each process: as many as the system gives everybody.
WAITING_BYTES: Final = 1 << 20


def can_fork() -> bool:
    """True where a process can go on as several that share what it has computed; libraries of macOS do not survive that."""
    return sys.platform.startswith("linux")


def map_in_order(function: Callable[[Item], Result], items: Iterable[Item], jobs: int) -> Iterator[Result]:
    """Results of a function for each item, in their order, by so many processes, of which this one is the first.

    Each process takes every so many-th item, and makes all of them as this one would: functions and items may hold anything.
    Results are pickled. An error of the function is raised here when its item is reached.

    Raises
    ------
    ChildProcessError
        A process was killed.
    """
    rest, each = iter(items), 0.0
    for item in islice(rest, 1):
        begun = perf_counter()
        result = function(item)
        each = perf_counter() - begun
        yield result
    seen = list(islice(rest, SEEN_ITEMS)) if jobs > 1 else []
    work = partial(_map_by_processes, jobs) if seen and each * len(seen) > WORTH_STARTING else map
    yield from work(function, chain(seen, rest))


def _map_by_processes(jobs: int, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    # not on every system, and slow to import
    import fcntl
    from multiprocessing import get_context

    context = get_context("fork")
    others = []
    try:
        for index in range(1, jobs):
            receiver, sender = context.Pipe(duplex=False)
            with suppress(OSError):  # less does, with more waiting for each other
                fcntl.fcntl(sender, fcntl.F_SETPIPE_SZ, WAITING_BYTES)
            process = context.Process(
                target=_work, args=(function, islice(items, index, None, jobs), sender), daemon=True
            )
            with warnings.catch_warnings():
                # of forking beside threads: those of the linear algebra rest meanwhile
                warnings.simplefilter("ignore", DeprecationWarning)
                process.start()
            others.append((process, receiver))
            sender.close()
        for index, item in enumerate(items):
            if index % jobs == 0:
                yield function(item)
                continue
            error, result = others[index % jobs - 1][1].recv()
            if error is not None:
                raise error
            yield result
    except EOFError:
        raise ChildProcessError(None, "was killed, perhaps for want of memory", "a process of --jobs") from None
    finally:
        for process, receiver in others:
            receiver.close()
            process.terminate()
            process.join()


def _work(function: Callable[[Item], Result], items: Iterable[Item], sender: "Connection") -> None:
    """In a new process: send the results, up to the first error."""
    # what belongs to the process that started this one is left alone: its streams, its signals and its files
    sys.stdout = sys.stderr = None
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal interrupts all processes; the other one says so
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    end_with_parent()
    try:
        for item in items:
            sender.send((None, function(item)))
    except BrokenPipeError:  # nobody wants any more
        pass
    except Exception as error:
        sender.send((error, None))


def end_with_parent(tidy_up: Callable[[], None] | None = None) -> None:
    """In a process that another one started: end with that one, however it ends; ``tidy_up`` is called before."""
    from multiprocessing import parent_process

    parent = parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        if tidy_up is not None:
            tidy_up()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
