"""Work that nobody may wait for any more: it asks at each trial, and ends by the error that the answer raises."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final

_ASK: Final[ContextVar[Callable[[], None] | None]] = ContextVar("ask", default=None)


@contextmanager
def stop_by(ask: Callable[[], None]) -> Iterator[None]:
    """Have the work below end where ``ask`` raises; searches call functions too deep to be given it by each."""
    before = _ASK.set(ask)
    try:
        yield
    finally:
        _ASK.reset(before)


def check_wanted() -> None:
    """Ask whether the work is still wanted, where somebody may stop it."""
    if (ask := _ASK.get()) is not None:
        ask()
