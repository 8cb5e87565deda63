"""The three standard streams of a run: never missing, the same bytes everywhere, errors of standard error ignored."""

import io
import os
import sys
from typing import Any

import click

from verne_post.base.printable import break_commands, find_open_line


class TextStream(io.TextIOWrapper):
    """A stream of text in which agents of CI servers find no commands, however it is cut into pieces."""

    #: The line that is not ended yet.
    _line = ""

    def write(self, text: str) -> int:
        """Write, with commands broken."""
        safe = break_commands(self._line + text)
        super().write(safe[len(self._line) :])
        self._line = find_open_line(safe)
        return len(text)


class ErrorStream(TextStream):
    """Standard error that fails silently: what cannot be shown must not change what is done, nor the exit status."""

    def write(self, text: str) -> int:
        """Write, or not."""
        try:
            return super().write(text)
        except OSError:
            drop(self)
            return len(text)

    def flush(self) -> None:
        """Write what is held, or not."""
        try:
            super().flush()
        except OSError:
            drop(self)


def prepare_streams() -> None:
    """Put something in the place of streams that are closed, and choose the encoding of all; once, as a process begins.

    A closed stream would give its descriptor to the next file that is opened, which would then get the output of the
    stream. The null device takes its place, opened so that reading standard input and writing standard output fail.
    """
    for descriptor, flags in ((0, os.O_WRONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, flags)  # takes the lowest free descriptor, which is this one
    if sys.stdin is None:
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):
        at_once = sys.stdout.line_buffering or sys.stdout.write_through
        # the same bytes on every platform; a name that is no text is shown by its bytes
        sys.stdout = TextStream(sys.stdout.detach(), "utf-8", "backslashreplace", newline="\n", line_buffering=at_once)
    encoding = "utf-8" if sys.stderr is None else sys.stderr.encoding
    sys.stderr = ErrorStream(open(2, "wb", closefd=False), encoding, "backslashreplace", line_buffering=True)  # noqa: SIM115


def echo(text: str, *, nl: bool = True, err: bool = False, color: bool | None = None) -> None:
    """Print a text for people; the streams of :func:`prepare_streams` break commands to agents of CI servers."""
    # click would put a stream of its own in place of one whose encoding is ASCII
    click.echo(text, file=sys.stderr if err else sys.stdout, nl=nl, color=color)


def print_as_is(text: str) -> None:
    """Print what programs read: annotations, which are commands, and formats whose writers escape what is none."""
    sys.stdout.flush()
    sys.stdout.buffer.write(text.encode("utf-8", "backslashreplace"))
    sys.stdout.buffer.flush()


def drop(stream: Any) -> None:
    """Send what a stream is still in force nowhere, so that nothing complains when the process ends."""
    try:
        number = stream.fileno()
    except (OSError, ValueError):  # closed, or without a descriptor: then nothing is held
        return
    try:
        null = os.open(os.devnull, os.O_WRONLY)
    except OSError:  # no descriptor is left but that one
        os.close(number)
        null = os.open(os.devnull, os.O_WRONLY)
    if null != number:
        os.dup2(null, number)
        os.close(null)
