"""Work on several cores: one function over many items, in order, by processes that end with the one that started them."""

import os
import signal
import sys
import threading
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import chain, islice
from time import perf_counter
from typing import Any, Final, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

#: So many items are looked at before processes are started: with fewer to come, or quick ones, it does not pay.
SEEN_ITEMS: Final = 32
#: Work that is expected to take less, s, is done by this process: to start and end others takes 15 to 25 ms.
WORTH_STARTING: Final = 0.08
#: Items for each process that wait for it, or whose results wait to be taken; more would only take memory.
WAITING_ITEMS: Final = 3

#: What a process that :func:`map_in_order` started does with items.
_function: Callable[[Any], Any]


def can_fork() -> bool:
    """True where a process can go on as several that share what it has computed; libraries of macOS do not survive that."""
    return sys.platform.startswith("linux")


def map_in_order(function: Callable[[Item], Result], items: Iterable[Item], jobs: int) -> Iterator[Result]:
    """Results of a function for each item, in their order, by so many processes; by this one where ``jobs`` is 1.

    The function may hold anything: a process knows what this one knows when it is started. Items and results are pickled.
    An error of the function is raised here when its item is reached.

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
    # imported where they are needed: they take as long as a short program
    from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor
    from multiprocessing import get_context

    pool = ProcessPoolExecutor(jobs, mp_context=get_context("fork"), initializer=_prepare, initargs=(function,))
    waiting: deque[Any] = deque()
    try:
        for item in items:
            with warnings.catch_warnings():
                # forking beside threads: those of the linear algebra rest meanwhile
                warnings.simplefilter("ignore", DeprecationWarning)
                waiting.append(pool.submit(_apply, item))
            if len(waiting) >= WAITING_ITEMS * jobs:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    except BrokenProcessPool:
        raise ChildProcessError(None, "was killed, perhaps for want of memory", "a process of --jobs") from None
    finally:
        pool.shutdown(cancel_futures=True)


def _prepare(function: Callable[[Any], Any]) -> None:
    """In a new process: leave alone what belongs to the one that started it, its streams, its signals and its files."""
    global _function
    _function = function
    sys.stdout = sys.stderr = None  # what they hold is written by the other process
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal interrupts all processes; the other one says so
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    end_with_parent()


def _apply(item: Any) -> Any:
    return _function(item)


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
