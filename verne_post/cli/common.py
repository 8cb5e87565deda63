"""What several commands share: programs and machines, findings and progress on standard error."""

import math
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from verne_post.cli.colour import say
from verne_post.cli.files import PROGRAM as PROGRAM
from verne_post.cli.files import RunFiles, is_dash, locate_errors, name_unreadable, show_name
from verne_post.cli.numbers import NUMBER
from verne_post.model.verdict import find_exit_status

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from verne_post.base.long_text import Text
    from verne_post.model.findings import Finding, InputError
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options


#: Endings of documents, which are no programs.
_NO_PROGRAMS = dict.fromkeys((".md", ".rst", ".html", ".htm", ".pdf", ".docx"), "a document") | {
    ".tbl": "a tool table",
    ".toml": "a machine file, a set-up or settings",
}
#: Endings of files that may be another input of a command.
_OF_OTHER_KINDS = (".toml", ".stl")
#: A text of more bytes is not held in memory.
LONG_TEXT = 1 << 22


def read_program(files: RunFiles, name: str, given: dict[str, Any]) -> "tuple[Machine, Text, Options]":
    """What every command that reads a program begins with: the machine, the program's text, its options.

    Raises
    ------
    InputError
        For a machine file, a program, or a file named by an option that cannot be used.
    """
    from verne_post.cli.options import build_options

    files.expect(name, PROGRAM)
    machine_name = name_machine(files, given["machine_name"], given, name)
    expect_machine(machine_name)
    options = build_options(files, show_name(name), name, **given)
    machine = load(files, machine_name)
    return machine, *read_program_text(files, name, options, given["subroutine_path"])


def choose_machine(name: str | None, named: str | None) -> str | None:
    """The machine that an argument or --machine names: whoever gives both may mean either.

    Raises
    ------
    UsageError
    """
    if name is not None and named is not None:
        raise click.UsageError(f"the machine is given twice: {name}, and --machine {named}")
    return named if name is None else name


@locate_errors
def name_machine(files: RunFiles, /, named: str | None, given: dict[str, Any] | None = None, program: str = "") -> str:
    """What --machine names, else the settings file, else the machine where none is named; a name or a path.

    Parameters
    ----------
    given : dict, optional
        Other values of the command line, where it has options that name files.
    program : str
        From whose folder upwards settings are looked for; empty: from the current folder.

    Raises
    ------
    InputError
        For a settings file that cannot be used.
    """
    from verne_post.cli.options import claim_input, find_settings
    from verne_post.config.machine_paths import DEFAULT_MACHINE

    if named is not None:
        return named
    claim_input(files, given or {})
    settings = find_settings(files, (given or {}).get("settings"), program)
    if settings is None:
        return DEFAULT_MACHINE
    expect_machine(settings.machine, f"{Path(settings.shown).name}: machine = {settings.file.machine!r}")
    return settings.machine


def expect_options(files: RunFiles, programs: "Iterable[str]", given: dict[str, Any]) -> None:
    """Refuse what is wrong with the command line or with settings, which is no finding of a program: once a folder.

    Raises
    ------
    InputError
    """
    from verne_post.cli.options import build_options

    for name in {Path(name).parent: name for name in programs}.values():
        expect_machine(name_machine(files, given["machine_name"], given, name))
        build_options(files, "", beside=name, **given)


def load_machines(files: RunFiles, programs: "Iterable[str]", given: dict[str, Any]) -> "dict[str, Machine]":
    """The machine of each program: that of --machine, else of the settings above its folder. Each is loaded once.

    Raises
    ------
    InputError
    """
    loaded: dict[str, Machine] = {}
    found = {}
    for program in programs:
        name = name_machine(files, given["machine_name"], given, program)
        expect_machine(name)
        if name not in loaded:
            loaded[name] = load(files, name)
        found[program] = loaded[name]
    return found


def read_program_text(
    files: RunFiles, name: str, options: "Options", subroutine_path: tuple[str, ...]
) -> "tuple[Text, Options]":
    """A program, and options with the files of subroutines that it may call.

    From standard input they come from the current folder, and only where ``--subroutine-path`` asks for them.
    """
    from verne_post.app.source_text import check_source_text
    from verne_post.base.file_kinds import describe_kind
    from verne_post.config.subprograms import collect_subprograms
    from verne_post.model.findings import UsageError, make_input_error

    files.called_texts = {}
    suffix = Path(name).suffix.lower()
    kind = _NO_PROGRAMS.get(suffix)
    source = _read_text(files, name, options.max_megabytes) if kind is None or suffix == ".toml" else b""
    if suffix in _OF_OTHER_KINDS and (other := describe_kind(source[:], "a program", show_name(name))):
        raise make_input_error("VP022", other)
    if kind is not None:
        text = f"{show_name(name)} is no NC program: {Path(name).suffix} is {kind}; name a program (.nc, .mpf, .h)"
        raise make_input_error("VP022", text)
    check_source_text(source, show_name(name), options.dialect)
    if is_dash(name) and not subroutine_path:
        return source, options
    folder = Path.cwd() if is_dash(name) else Path(name).resolve().parent
    try:
        found, names = collect_subprograms(
            source, folder, subroutine_path, lambda path, called: files.read(path, f"subprogram {called}")
        )
    except UsageError as error:
        raise click.UsageError(f"{error.option} {error.reason}") from None
    files.called_texts = {names[name]: text for name, text in found.items()}
    return source, options.changed(subroutines=found, subroutine_files=names)


def expect_machine(name: str, what: str = "") -> None:
    """Check that a machine file exists, without loading what reads it; ``what`` says where it is named.

    Standard input is not checked.

    Raises
    ------
    InputError
    """
    if is_dash(name):
        return
    from verne_post.config.machine_paths import expect_file, find_machine_path

    expect_file(find_machine_path(name), what or f"machine file {name!r}", Path(name).name)


@locate_errors
def load(files: RunFiles, /, name: str, what: str = "--machine") -> "Machine":
    """Load a machine, from standard input for "-"; its findings end the command."""
    expect_machine(name)
    if is_dash(name):
        raw = files.read(name, what)
        from verne_post.config.load import build_machine

        return build_machine(raw, show_name(name))
    from dataclasses import replace

    from verne_post.config import load_machine

    machine = load_machine(name, lambda path: files.read_or_raise(path, what))
    if not (machine.warnings or machine.unreachable):
        return machine
    return replace(
        machine, warnings=files.find_lines(machine.warnings), unreachable=files.find_lines(machine.unreachable)
    )


def _read_text(files: RunFiles, name: str, max_megabytes: int) -> "Text":
    """A program's text, from standard input for ``-``; a long one in a copy, so that it stays what was there.

    Raises
    ------
    InputError
        VP022: what begins as no text is not read on, nor more megabytes than allowed.
    """
    from verne_post.app.source_text import check_source_begin
    from verne_post.base.columns import name_storage_errors
    from verne_post.base.long_text import map_text
    from verne_post.base.text_marks import strip_mark
    from verne_post.model.findings import make_input_error

    with files.open_input(name, PROGRAM) as file:
        with name_unreadable(name):
            part = file.read(LONG_TEXT)
        if len(part) < LONG_TEXT:
            return strip_mark(part)
        check_source_begin(part, show_name(name))
        part, read = strip_mark(part), 0
        with name_storage_errors():
            copy = tempfile.TemporaryFile()  # noqa: SIM115 - closed below
        with copy:
            while part:
                read += len(part)
                if read > max_megabytes * 1_000_000:
                    text = (
                        f"{show_name(name)} has more than {max_megabytes} MB; if it is meant to, raise --max-megabytes"
                    )
                    raise make_input_error("VP022", text)
                with name_storage_errors():
                    copy.write(part)
                    copy.flush()
                with name_unreadable(name):
                    part = file.read(LONG_TEXT)
            return map_text(copy)


def print_findings(program: str, findings: "tuple[Finding, ...]", source: "Text" = b"", *, quiet: bool = False) -> None:
    """Findings on standard error, as ``check`` prints them; only errors where ``quiet``."""
    from verne_post.cli.options import find_given_run
    from verne_post.model.findings import sort_by_line
    from verne_post.output.findings import format_causes

    context = click.get_current_context(silent=True)
    run = find_given_run({} if context is None else context.params)
    shown = sort_by_line(item for item in findings if item.severity == "error" or not quiet)
    for lines in format_causes(program, shown, source, run):
        say("".join(line + "\n" for line in lines))


def refuse(program: str, error: "InputError", source: "Text" = b"") -> int:
    """Print why a program cannot be used; returns the exit status."""
    print_findings(program, error.findings, source)
    return find_exit_status(error.findings)


quiet_option = click.option("-q", "--quiet", is_flag=True, help="Print only errors: no summary, warnings or progress.")


def require_positive(option: str, value: float, *, zero: bool = False, infinite: bool = False) -> None:
    """Refuse the value of an option that is no number above 0, or from 0 on."""
    if not ((infinite or math.isfinite(value)) and (value >= 0 if zero else value > 0)):
        raise click.UsageError(f"{option} {value:g}: expected a number {'from 0 on' if zero else 'above 0'}")


def add_sigma_option(
    name: str, default: float, unit: str, text: str, *, zero: bool = True, infinite: bool = False
) -> "Callable[[Callable[..., Any]], Callable[..., Any]]":
    """A standard uncertainty as an option, which is checked when it is read."""

    def check(_context: click.Context, _option: click.Parameter, value: float) -> float:
        require_positive(name, value, zero=zero, infinite=infinite)
        return value

    return click.option(name, type=NUMBER, default=default, show_default=True, metavar=unit, callback=check, help=text)
