"""What several commands share: reading and writing files, findings and progress on standard error."""

import os
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from verne_post.app.result import Progress
    from verne_post.base.long_text import Text
    from verne_post.model.findings import Finding, InputError
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options


#: A zero byte in so much of a file tells that it is no text.
_LOOKED_AT = 4096
#: A text of more bytes is not held in memory.
LONG_TEXT = 1 << 22


def program_text(name: str, options: "Options", subroutine_path: tuple[str, ...]) -> "tuple[Text, Options]":
    """A program, and options with the files of subroutines that it may call.

    From standard input they come from the current folder, and only where ``--subroutine-path`` asks for them.
    """
    from dataclasses import replace

    from verne_post.cli.subroutines import gather
    from verne_post.model.findings import InputError, finding

    source = _text(name)
    if b"\0" in source[:_LOOKED_AT]:
        raise InputError(finding("VP022", f"{shown_name(name)} is not a text file"))
    if source.startswith(b"t_s,"):
        raise InputError(finding("VP022", f"{shown_name(name)} is a setpoint file, not a program"))
    if name == "-" and not subroutine_path:
        return source, options
    folder = Path.cwd() if name == "-" else Path(name).resolve().parent
    return source, replace(options, subroutines=gather(source, folder, subroutine_path))


def load(name: str) -> "Machine":
    """Load a machine; its findings end the command."""
    from verne_post.config import load_machine

    return load_machine(name)


def _text(name: str) -> "Text":
    """A program's text, from standard input for ``-``; a long one in a copy, so that it stays what was there."""
    from verne_post.base.columns import temporary_storage
    from verne_post.base.long_text import text_in

    with _reading(name):
        opened = nullcontext(sys.stdin.buffer) if name == "-" else Path(name).open("rb")  # noqa: SIM115 - closed below
    with opened as file:
        with _reading(name):
            part = file.read(LONG_TEXT)
        if len(part) < LONG_TEXT:
            return part
        with temporary_storage():
            copy = tempfile.TemporaryFile()  # noqa: SIM115 - closed below
        with copy:
            while part:
                with temporary_storage():
                    copy.write(part)
                    copy.flush()
                with _reading(name):
                    part = file.read(LONG_TEXT)
            return text_in(copy)


@contextmanager
def _reading(name: str) -> Iterator[None]:
    """What goes wrong with a file is told with its name."""
    try:
        yield
    except OSError as error:
        raise click.UsageError(f"{name}: {error.strerror or error}") from None


def read_bytes(name: str) -> bytes:
    """A file, or standard input for ``-``."""
    if name == "-":
        return sys.stdin.buffer.read()
    with _reading(name):
        return Path(name).read_bytes()


def check_writable(path: Path | None, option: str) -> None:
    """Refuse a file that could not be written, before any work is done."""
    if path is None or (path.exists() and not path.is_file()):
        return  # a device or a pipe is written through
    folder = path.resolve().parent
    if not folder.is_dir():
        raise click.UsageError(f"{option} {path}: the folder does not exist")
    if path.is_dir():
        raise click.UsageError(f"{option} {path}: is a folder")
    try:
        handle, probe = tempfile.mkstemp(prefix=f".{path.name}.", dir=folder)
    except OSError as error:
        raise click.UsageError(f"{option} {path}: cannot be written: {error.strerror}") from None
    os.close(handle)
    Path(probe).unlink()


def write_whole(path: Path, parts: Iterable[str] | Iterable[bytes]) -> None:
    """Write a file so that it is whole or untouched: a temporary name in the same folder, then a rename.

    Text is written as UTF-8 with line feeds, bytes as they are. A symbolic link keeps pointing where it does; devices and pipes are written through.
    """
    if path.exists() and not path.is_file():
        with path.open("wb") as device:
            device.writelines(_encoded(parts))
        return
    target = path.resolve()
    handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.writelines(_encoded(parts))
        umask = os.umask(0)
        os.umask(umask)
        Path(temporary).chmod(0o666 & ~umask)
        Path(temporary).replace(target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _encoded(parts: Iterable[str] | Iterable[bytes]) -> Iterator[bytes]:
    for part in parts:
        yield part.encode("utf-8") if isinstance(part, str) else part


def shown_name(name: str) -> str:
    """How an input is called in messages."""
    return "<stdin>" if name == "-" else name


def print_findings(program: str, findings: "tuple[Finding, ...]") -> None:
    """One line a finding on standard error."""
    from verne_post.output.findings import text_line

    for item in findings:
        click.echo(text_line(program, item), err=True)


def refuse(program: str, error: "InputError") -> int:
    """Print why a program cannot be used; returns the exit status."""
    from verne_post.pipeline import exit_code_of

    print_findings(program, error.findings)
    return exit_code_of(error)


@contextmanager
def progress_bar() -> Iterator["Progress | None"]:
    """A progress bar on standard error, only on a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    bars: dict[str, Any] = {}

    def show(stage: str, done: int, total: int) -> None:
        if stage not in bars:
            for bar in bars.values():
                bar.__exit__(None, None, None)
            bars[stage] = click.progressbar(length=total, label=stage, file=sys.stderr)
            bars[stage].__enter__()
        bars[stage].update(done - bars[stage].pos)

    try:
        yield show
    finally:
        for bar in bars.values():
            bar.__exit__(None, None, None)
