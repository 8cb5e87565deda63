"""Options of check and batch that write the findings to files, in formats of other programs, beside what is printed."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from verne_post.cli.files import RunFiles, Unreadable
from verne_post.cli.options import FILE, decorate
from verne_post.model.verdict import Verdict, find_exit_status, find_verdict

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from verne_post.model.findings import InputError
    from verne_post.model.machine import Machine
    from verne_post.output.findings import Report

#: Formats with an option of their own, and how its help calls them.
_FORMATS: Final = {"junit": "JUnit XML", "sarif": "SARIF", "markdown": "a table in Markdown"}


def add_report_files(command: "Callable[..., Any]") -> "Callable[..., Any]":
    """Give a command the options --junit, --sarif and --markdown."""
    options = [
        click.option(f"--{name}", type=FILE, metavar="F", help=f"Write the findings as {words} too.")
        for name, words in _FORMATS.items()
    ]
    return decorate(command, options)


def take_report_files(files: RunFiles, given: dict[str, Any]) -> dict[str, Path]:
    """The files that are asked for, by their formats, taken out of `given`; each is tried before any work."""
    asked = {name: path for name in _FORMATS if (path := given.pop(name)) is not None}
    for name, path in asked.items():
        files.expect_writing(path, f"--{name}")
    return asked


def write_report_files(
    files: RunFiles, asked: "Mapping[str, Path]", reports: "Sequence[Report]", machine: "Machine | None"
) -> None:
    """Write the findings of all programs to every file that was asked for."""
    from verne_post.output.reports import FORMATS

    for name, path in asked.items():
        files.write(path, f"--{name}", [FORMATS[name](reports, machine)])


def report_failure(
    files: RunFiles,
    asked: "Mapping[str, Path]",
    error: "InputError | click.UsageError | Unreadable",
    printed: str,
    emit: "Callable[[str], object]",
) -> None:
    """Say in every report that was asked for why nothing was checked; ``printed`` is the format that ``emit`` takes.

    The error itself is a text already.
    """
    from verne_post.model.findings import InputError
    from verne_post.output.reports import FAILURES

    found = error.findings if isinstance(error, InputError) else ()
    verdict = find_verdict(find_exit_status(found), found) if found else Verdict.USAGE_ERROR
    message = error.message if isinstance(error, click.UsageError) else str(error)
    for name, path in asked.items():
        files.write(path, f"--{name}", [FAILURES[name](verdict, message, found)])
    if printed != "text":
        emit(FAILURES[printed](verdict, message, found))
