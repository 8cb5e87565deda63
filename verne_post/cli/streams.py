"""The three standard streams as a run needs them: never missing, the same bytes everywhere, errors of standard error never fatal."""

import io
import os
import sys
from typing import Any


class ErrorStream(io.TextIOWrapper):
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

    A closed stream would give its descriptor to the next file that is opened, which would then get what is meant for the stream. In its place
    stands the null device, opened so that reading standard input and writing standard output fail.
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
        # the same bytes on every platform; a name that is no text is shown by its bytes
        sys.stdout.reconfigure(encoding="utf-8", errors="backslashreplace", newline="\n")
    encoding = "utf-8" if sys.stderr is None else sys.stderr.encoding
    sys.stderr = ErrorStream(open(2, "wb", closefd=False), encoding, "backslashreplace", line_buffering=True)  # noqa: SIM115


def drop(stream: Any) -> None:
    """Send what a stream still holds nowhere, so that nothing complains when the process ends."""
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, stream.fileno())
    except (OSError, ValueError):  # closed, or without a descriptor: then nothing is held
        pass
    finally:
        os.close(null)
