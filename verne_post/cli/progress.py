"""The present task and its remaining time: one line on a terminal, for everything that takes over a second."""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from verne_post.app.result import Progress

#: Nothing is shown before, s: most commands are done by then.
PATIENCE: Final = 1.0
#: Time between two pictures of the line, s.
_TICK: Final = 0.2
#: Cells of the bar.
_CELLS: Final = 24


class ProgressLine:
    """One line on standard error: the stage, a bar where its length is known, the time that is left or has passed."""

    def __init__(self, stage: str) -> None:
        self.began = self.stage_began = time.monotonic()
        self.stage, self.done, self.total = stage, 0, 0
        self.shown = False
        self._ended = threading.Event()
        self._ticker = threading.Thread(target=self._tick, daemon=True)
        self._ticker.start()

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Take note of the progress; ``total`` 0 where nobody knows how much there is to do."""
        if stage != self.stage:
            self.stage_began = time.monotonic()
        self.stage, self.done, self.total = stage, done, total

    def make_text(self, now: float) -> str:
        """The line at a time of the monotonic clock."""
        passed = now - self.stage_began
        if not self.total or not self.done:
            return f"{self.stage}, {passed:.0f} s"
        share = min(self.done / self.total, 1.0)
        bar = "#" * round(_CELLS * share)
        return f"{self.stage} [{bar:-<{_CELLS}}] {100 * share:3.0f} %, {passed / share - passed:.0f} s left"

    def end(self) -> None:
        """Take the line away."""
        self._ended.set()
        self._ticker.join()
        self.hide()

    def hide(self) -> None:
        """Make room for other text, until the line is drawn again."""
        if self.shown:
            self._write("")

    def _tick(self) -> None:
        while not self._ended.wait(_TICK):
            now = time.monotonic()
            if now - self.began >= PATIENCE:
                self.shown = True
                self._write(self.make_text(now))

    @staticmethod
    def _write(text: str) -> None:
        sys.stderr.write(f"\r\x1b[K{text}")
        sys.stderr.flush()


@contextmanager
def show_progress(stage: str, *, quiet: bool = False) -> "Iterator[Progress | None]":
    """Show progress on standard error while the block runs; only on a terminal.

    Parameters
    ----------
    stage : str
        What is done until another stage is given.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    line = ProgressLine(stage)
    try:
        yield line
    finally:
        line.end()
