"""`verne-post convert`: the main job."""

import shutil
import sys
import tempfile
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Final

import click

from verne_post.cli.common import (
    check_writable,
    load,
    print_findings,
    program_text,
    progress_bar,
    refuse,
    shown_name,
    write_whole,
)
from verne_post.cli.options import build_options, keep_out_options, program_options, units_option, way_options

if TYPE_CHECKING:
    from verne_post.model.setpoints import SetpointBlock
    from verne_post.model.summary import Summary

_COPY: Final = 1 << 20


@click.command("convert")
@click.argument("input_name", metavar="INPUT")
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="OUT",
    help="File to write, in place of standard output.",
)
@click.option("--format", "file_format", type=click.Choice(["csv"]), default="csv", help="Format of the setpoint file.")
@click.option("--decimals", default="auto", metavar="auto|N", help="Decimals of every column.")
@click.option(
    "--override",
    type=click.FloatRange(0.05, 1.0),
    default=1.0,
    show_default=True,
    metavar="SHARE",
    help="Play the planned motion at this share of its speed; dwells keep their length.",
)
@click.option(
    "--slow-start",
    type=click.FloatRange(0.0, 3600.0),
    default=0.0,
    metavar="SECONDS",
    help="Begin at a tenth of the speed and reach it within so many seconds.",
)
@click.option("--accept-rounding", is_flag=True, help="Write even where rounding alone breaks a limit.")
@click.option(
    "--meta",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write facts of the conversion as JSON beside it.",
)
@click.option(
    "--events",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write what is not motion, with time, line and axes, as FILE.csv or FILE.json.",
)
@click.option(
    "--write-parameters",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the parameter file that the program leaves behind.",
)
@units_option
@way_options
@keep_out_options
@program_options
def command(
    input_name: str, output: Path | None, file_format: str, decimals: str, meta: Path | None,
    events: Path | None, write_parameters: Path | None, **given: Any,
) -> int:  # fmt: skip
    """Convert G-code to verified setpoints.

    INPUT is a file, or - for standard input. Nothing is written unless the whole program passes every check.
    """
    from verne_post.model.findings import InputError
    from verne_post.output.events import SUFFIXES, events_text
    from verne_post.pipeline import drives_of

    if decimals != "auto" and not (decimals.isdecimal() and int(decimals) <= 12):
        raise click.UsageError(f"--decimals {decimals}: expected auto, or a whole number from 0 to 12")
    if events is not None and events.suffix not in SUFFIXES:
        raise click.UsageError(f"--events {events}: expected a name that ends in {' or '.join(SUFFIXES)}")
    given["decimals"] = None if decimals == "auto" else int(decimals)
    if given["split_at_stops"]:
        _check_parts(
            output,
            {"INPUT": Path(input_name), "--meta": meta, "--events": events, "--write-parameters": write_parameters},
        )
    check_writable(output, "-o")
    check_writable(meta, "--meta")
    check_writable(events, "--events")
    check_writable(write_parameters, "--write-parameters")
    name = shown_name(input_name)
    try:
        machine = load(given.pop("machine_name"))
        paths = given.pop("subroutine_path")
        source, options = program_text(input_name, build_options(name, **given), paths)
        drives = drives_of(machine, options)
    except InputError as error:
        return refuse(name, error)

    from verne_post.gcode.parameter_file import parameter_file
    from verne_post.output.setpoints import FORMATS
    from verne_post.output.summary import meta as meta_text
    from verne_post.output.summary import paragraph
    from verne_post.pipeline import convert

    header, encode = FORMATS[file_format]
    with tempfile.TemporaryFile("w+", encoding="utf-8", newline="\n") as spool:
        spool.write(header(machine.columns, drives))

        def sink(block: "SetpointBlock") -> None:
            spool.write(encode(block))

        with progress_bar() as progress:
            result = convert(source, machine, options, sink, progress)
        print_findings(name, result.findings)
        if not result.ok:
            return result.exit_code
        assert result.summary is not None
        spool.seek(0)
        if options.split_at_stops:
            assert output is not None
            spool.readline()
            _write_parts(output, spool, header(machine.columns, drives), result.summary)
        elif output is None:
            shutil.copyfileobj(spool, sys.stdout)
            sys.stdout.flush()
        else:
            write_whole(output, iter(lambda: spool.read(_COPY), ""))
    if meta is not None:
        write_whole(meta, [meta_text(result.summary)])
    if events is not None:
        write_whole(events, [events_text(result.summary, events.suffix)])
    if write_parameters is not None:
        write_whole(write_parameters, [parameter_file(dict(result.summary.parameters))])
    click.echo(paragraph(result.summary), nl=False, err=True)
    return result.exit_code


def _check_parts(output: Path | None, others: dict[str, Path | None]) -> None:
    """Refuse names of parts that would be those of other files, before any work is done."""
    from verne_post.output.parts import is_derived

    if output is None:
        raise click.UsageError("--split-at-stops writes several files; give their name with -o")
    for what, path in others.items():
        if path is not None and is_derived(path, output):
            raise click.UsageError(f"{what} {path}: a part of -o {output} may have this name; choose another one")
    for path in output.resolve().parent.glob("*"):
        if path.is_dir() and is_derived(path, output):
            raise click.UsageError(f"-o {output}: a part may have the name of the folder {path.name}")


def _write_parts(output: Path, spool: IO[str], header: str, summary: "Summary") -> None:
    """Write all parts beside their place, and then put them there in the stead of older ones; the index comes last."""
    from verne_post.model.findings import InputError
    from verne_post.output.parts import index, index_path, is_derived, part_path, part_rows, parts_of

    with tempfile.TemporaryDirectory(prefix=f".{output.name}.", dir=output.resolve().parent) as folder:
        names = []
        for number, part in enumerate(summary.parts, start=1):
            names.append(part_path(output, number))
            write_whole(Path(folder) / names[-1].name, part_rows(spool, header, part, summary))
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
