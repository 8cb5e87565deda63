"""One conversion with its files: what `convert` and `batch` do for each program, whole or not at all."""

import dataclasses
import importlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.extras import spell_install
from verne_post.cli.files import RunFiles, show_name
from verne_post.cli.options import NameChoice
from verne_post.cli.temporary import make_temporary_folder
from verne_post.output.formats import FORMATS

if TYPE_CHECKING:
    from verne_post.app.result import Progress, Result
    from verne_post.base.long_text import Text
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options
    from verne_post.model.summary import Summary
    from verne_post.output.file_format import FileFormat
    from verne_post.output.spool import WrittenRows

#: The format of rows where nobody names one.
DEFAULT_FORMAT: Final = "csv"
#: Endings of the file of events, each a format.
_EVENT_SUFFIXES: Final = (".csv", ".json")
#: Names that formats had before -> what to give now.
_FORMER_FORMATS = {
    "ros2-json": "this is the format ros2 now; it writes JSON to a file whose name ends in .json, else YAML"
}


class _FormatChoice(NameChoice):
    """The formats, by the names of their modules; says what became of a former name."""

    def __init__(self) -> None:
        super().__init__(tuple(FORMATS))

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Check a name.

        Raises
        ------
        UsageError
        """
        if value in _FORMER_FORMATS:
            raise click.UsageError(f"--format {value}: {_FORMER_FORMATS[value]}")
        return super().convert(value, param, ctx)


format_option = click.option(
    "--format",
    "file_format",
    type=_FormatChoice(),
    default=DEFAULT_FORMAT,
    show_default=True,
    help="Format of the setpoint file.",
)


#: Endings of files of other kinds, which a setpoint file would only seem to be.
_NO_ROWS = frozenset((".xlsx", ".xls", ".ods", ".html", ".pdf", ".docx", ".zip", ".png"))


class Outputs(Struct, frozen=True):
    """Where the results go; ``rows`` None: standard output, the others None: not written."""

    rows: Path | None
    file_format: str = DEFAULT_FORMAT
    meta: Path | None = None
    events: Path | None = None
    parameters: Path | None = None

    def check(self, files: RunFiles) -> None:
        """Refuse names that cannot be written, or would collide, before any work is done.

        Raises
        ------
        UsageError, FileError
        """
        check_format(self.file_format)
        if self.rows is not None and self.rows.suffix.lower() in _NO_ROWS:
            kind = self.file_format
            name = self.rows.with_suffix(".csv" if kind == DEFAULT_FORMAT else f".{kind}")
            raise click.UsageError(f"-o {self.rows}: the file would be {kind} in spite of its name; write -o {name}")
        if self.events is not None and self.events.suffix.lower() not in _EVENT_SUFFIXES:
            raise click.UsageError(
                f"--events {self.events}: expected a name that ends in {' or '.join(_EVENT_SUFFIXES)}"
            )
        if self.rows is None:
            files.claim_output("the rows")
        named = {"-o": self.rows, "--meta": self.meta, "--events": self.events, "--write-parameters": self.parameters}
        for what, path in named.items():
            files.expect_writing(path, what)

    def check_parts(self, files: RunFiles, *, asked: bool) -> None:
        """Refuse names of parts that would be those of other files or folders; ``asked`` by the command line.

        Raises
        ------
        UsageError, FileError
        """
        from verne_post.output.parts import find_derived

        origin = "" if asked else files.find_key("split_at_stops")
        why = f"split_at_stops = true ({origin})" if origin else "--split-at-stops"
        if self.rows is None:
            raise click.UsageError(f"{why} writes one file from each stop to the next; give their name: -o axes.csv")
        files.claim_parts(self.rows, "-o")
        for path in find_derived(self.rows):
            if path.is_dir():
                raise click.UsageError(f"-o {self.rows}: a part may have the name of the folder {path.name}")


def check_format(name: str) -> None:
    """Refuse a format whose package is not installed, or does not load beside the others that are."""
    if name == DEFAULT_FORMAT:  # needs none, and looking costs the import of numpy
        return
    needs = FORMATS[name].needs
    if needs is None:
        return
    try:
        importlib.import_module(needs)
    except ModuleNotFoundError:
        raise click.UsageError(
            f"--format {name} needs {needs}, which is not installed; install it with: {spell_install(name)}"
        ) from None
    except ImportError as error:  # another numpy than it was made for
        raise click.UsageError(
            f"--format {name} needs {needs}, which does not load: {str(error).splitlines()[0]}"
        ) from None


def convert_to_files(
    source: "Text",
    machine: "Machine",
    options: "Options",
    outputs: Outputs,
    files: RunFiles,
    progress: "Progress | None" = None,
) -> "tuple[Result, tuple[tuple[str, str], ...]]":
    """Convert a program and write what was asked for, if it passes.

    Returns
    -------
    Result
    tuple of (str, str)
        What the format adds to the summary: keys and texts.
    """
    from verne_post.app.convert import convert_source
    from verne_post.cli.callers import name_caller
    from verne_post.gcode.parameter_file import format_parameter_file
    from verne_post.output.events import format_events
    from verne_post.output.side_car import describe_rows, format_side_car
    from verne_post.output.spool import Spool

    spool = Spool(machine.columns)
    result = convert_source(source, machine, options, spool.take, progress)
    result = dataclasses.replace(result, findings=files.find_lines(name_caller(result.findings, options.source_name)))
    if not result.ok:
        return result, ()
    assert result.summary is not None
    rows = replace(spool.collect_rows(), about=describe_rows(result.summary))
    file_format, added = FORMATS[outputs.file_format], list[tuple[str, str]]()
    if not file_format.has_undriven:
        rows = rows.take_driven()
    assert outputs.rows is not None or not options.split_at_stops
    if outputs.rows is None:
        sys.stdout.flush()
        for part in file_format.write(rows):
            sys.stdout.buffer.write(part)
        sys.stdout.buffer.flush()
    elif options.split_at_stops:
        added = _write_parts(files, outputs.rows, file_format, rows, result.summary)
        if file_format.read is not None:  # what verify reads
            added.append(("verify", _spell_verify(outputs.rows, options)))
    else:
        _remove_parts(outputs.rows)
        files.write(outputs.rows, "-o", file_format.choose_writer(outputs.rows.suffix)(rows))
    if outputs.meta is not None:
        files.write(outputs.meta, "--meta", [format_side_car(result.summary, outputs.file_format, rows)])
    if outputs.events is not None:
        files.write(outputs.events, "--events", [format_events(result.summary, outputs.events.suffix)])
    if outputs.parameters is not None:
        files.write(outputs.parameters, "--write-parameters", [format_parameter_file(dict(result.summary.parameters))])
    if not added and file_format.describe is not None:
        added = [file_format.describe(rows)]
    return result, tuple(added)


def _write_parts(
    files: RunFiles, output: Path, file_format: "FileFormat", rows: "WrittenRows", summary: "Summary"
) -> list[tuple[str, str]]:
    """Write all parts beside their place, and then put them in place of older rows; the index comes last.

    Returns
    -------
    list of (str, str)
        What the summary says of them.
    """
    from verne_post.output.parts import index_path, index_text, name_part

    described = []
    with make_temporary_folder(output.resolve().parent) as folder:
        names = [name_part(output, number) for number in range(1, len(summary.parts) + 1)]
        for number, (name, part) in enumerate(zip(names, summary.parts, strict=True), start=1):
            files.claim(name, "-o")
            taken = rows.take_part(part.first_row, part.last_row)
            files.write(folder / name.name, "-o", file_format.choose_writer(output.suffix)(taken))
            if file_format.describe is not None:
                what, text = file_format.describe(taken)
                described.append((f"{what}, part {number}", text))
        _remove_parts(output)
        if output.is_file():  # rows of an earlier run, which somebody might take for those of this one
            output.unlink()
        for name in names:
            files.place(folder / name.name, name, "-o")
    files.write(index_path(output), "-o", [index_text(output, summary)])
    return [("written", ", ".join(path.name for path in (*names, index_path(output)))), *described]


def _spell_verify(output: Path, options: "Options") -> str:
    """The command that verifies all parts of an output together."""
    from verne_post.output.commands import find_run, quote_word
    from verne_post.output.parts import index_path

    program = "-" if options.source_name == show_name("-") else quote_word(options.source_name)
    return find_run(options).spell("verify", str(index_path(output)), "", "--against", program)


def _remove_parts(output: Path) -> None:
    """Remove the parts that an earlier run has written for an output, and their index."""
    from verne_post.model.findings import InputError
    from verne_post.output.parts import index_path, is_derived, list_parts

    index = index_path(output)
    if not index.exists():
        return
    try:
        old = list_parts(index)
    except InputError:
        return  # not ours; a run that writes parts replaces it
    index.unlink()
    for path in old:
        if is_derived(path, output):
            path.unlink(missing_ok=True)
