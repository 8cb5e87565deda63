"""One conversion with its files: what `convert` and `batch` do for each program, whole or not at all."""

import importlib.util
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import click

from verne_post.cli.common import check_writable, write_whole

if TYPE_CHECKING:
    from verne_post.app.result import Progress, Result
    from verne_post.base.long_text import Text
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options
    from verne_post.model.summary import Summary
    from verne_post.output.spool import WrittenRows

#: Names of the formats; the table itself (output.formats) costs numpy.
FORMAT_NAMES = ("csv", "linuxcnc", "pvt", "ros2", "ros2-json", "twincat", "npz", "parquet")


@dataclass(frozen=True)
class Files:
    """Where the results go; ``output`` None: standard output, the others None: not written."""

    output: Path | None
    file_format: str = "csv"
    meta: Path | None = None
    events: Path | None = None
    parameters: Path | None = None
    inputs: Mapping[str, Path] = field(default_factory=dict)

    def check(self, *, split: bool) -> None:
        """Refuse names that cannot be written, or would get in each other's way, before any work is done.

        Raises
        ------
        UsageError
        """
        from verne_post.output.events import SUFFIXES
        from verne_post.output.formats import FORMATS

        needs = FORMATS[self.file_format].needs
        if needs is not None and importlib.util.find_spec(needs) is None:
            raise click.UsageError(
                f"--format {self.file_format} needs {needs}, which is not installed; install it with: pip install 'verne-post[{self.file_format}]'"
            )
        if self.events is not None and self.events.suffix not in SUFFIXES:
            raise click.UsageError(f"--events {self.events}: expected a name that ends in {' or '.join(SUFFIXES)}")
        self._check_apart()
        if split:
            self._check_parts()
        for what, path in self._named().items():
            check_writable(path, what)

    def _named(self) -> dict[str, Path | None]:
        return {"-o": self.output, "--meta": self.meta, "--events": self.events, "--write-parameters": self.parameters}

    def _check_apart(self) -> None:
        """Refuse an output that is an input, or another output."""
        seen = {path.resolve(): what for what, path in self.inputs.items()}
        for what, path in self._named().items():
            if path is None or not (path.is_file() or not path.exists()):
                continue  # a device or a pipe may serve twice
            other = seen.setdefault(path.resolve(), what)
            if other != what:
                raise click.UsageError(f"{what} {path}: this is the file of {other}; choose another name")

    def _check_parts(self) -> None:
        """Refuse names of parts that would be those of other files."""
        from verne_post.output.parts import is_derived

        if self.output is None:
            raise click.UsageError("--split-at-stops writes several files; give their name with -o")
        if self.file_format != "csv":
            raise click.UsageError(f"--split-at-stops writes csv; --format {self.file_format} is for whole programs")
        others = {**self._named(), **self.inputs}
        for what, path in others.items():
            if what != "-o" and path is not None and is_derived(path, self.output):
                raise click.UsageError(
                    f"{what} {path}: a part of -o {self.output} may have this name; choose another one"
                )
        for path in self.output.resolve().parent.glob("*"):
            if path.is_dir() and is_derived(path, self.output):
                raise click.UsageError(f"-o {self.output}: a part may have the name of the folder {path.name}")


def converted(
    source: "Text", machine: "Machine", options: "Options", files: Files, progress: "Progress | None" = None
) -> "tuple[Result, str]":
    """Convert a program and write what was asked for, if it passes; also returns what a format says of itself."""
    from verne_post.app.convert import convert_program as convert
    from verne_post.gcode.parameter_file import parameter_file
    from verne_post.output.controllers import pvt_knots
    from verne_post.output.events import events_text
    from verne_post.output.formats import FORMATS
    from verne_post.output.spool import Spool
    from verne_post.output.summary import meta as meta_text

    said = ""
    spool = Spool(machine.columns)
    result = convert(source, machine, options, spool.take, progress)
    if not result.ok:
        return result, said
    assert result.summary is not None
    rows = spool.rows()
    if options.split_at_stops:
        assert files.output is not None
        _write_parts(files.output, rows, result.summary)
    elif files.output is None:
        sys.stdout.flush()
        for part in FORMATS[files.file_format].write(rows):
            sys.stdout.buffer.write(part)
        sys.stdout.buffer.flush()
    else:
        write_whole(files.output, FORMATS[files.file_format].write(rows))
    if files.file_format == "pvt":
        step, off = pvt_knots(rows)
        said = f"Knots every {step * rows.format.cycle:g} s; between them the cubics are off the rows by at most " + ", ".join(
            f"{column.joint} {value:.1e} {column.unit}" for column, value in zip(machine.columns, off, strict=True)
        ) + ".\n"  # fmt: skip
    if files.meta is not None:
        write_whole(files.meta, [meta_text(result.summary)])
    if files.events is not None:
        write_whole(files.events, [events_text(result.summary, files.events.suffix)])
    if files.parameters is not None:
        write_whole(files.parameters, [parameter_file(dict(result.summary.parameters))])
    return result, said


def _write_parts(output: Path, rows: "WrittenRows", summary: "Summary") -> None:
    """Write all parts beside their place, and then put them there in the stead of older ones; the index comes last."""
    from verne_post.model.findings import InputError
    from verne_post.output.formats import FORMATS
    from verne_post.output.parts import index, index_path, is_derived, part_path, parts_of

    with tempfile.TemporaryDirectory(prefix=f".{output.name}.", dir=output.resolve().parent) as folder:
        names = []
        for number, part in enumerate(summary.parts, start=1):
            names.append(part_path(output, number))
            write_whole(Path(folder) / names[-1].name, FORMATS["csv"].write(rows.part(part.first_row, part.last_row)))
        old: list[Path] = []
        if index_path(output).exists():
            try:
                old = parts_of(index_path(output))
            except InputError:
                old = []  # not ours: it is replaced all the same
            index_path(output).unlink()
        for path in old:
            if is_derived(path, output):
                path.unlink(missing_ok=True)
        for name in names:
            (Path(folder) / name.name).replace(name)
    write_whole(index_path(output), [index(output, summary)])
