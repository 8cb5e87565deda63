"""`verne-post convert`: the main job."""

import shutil
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from verne_post.cli.common import (
    build_options,
    check_writable,
    from_option,
    load,
    print_findings,
    program_options,
    program_text,
    progress_bar,
    refuse,
    shown_name,
    write_whole,
)  # fmt: skip

if TYPE_CHECKING:
    from verne_post.model.setpoints import SetpointBlock

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
@click.option("--accept-rounding", is_flag=True, help="Write even where rounding alone breaks a limit.")
@click.option(
    "--meta",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write facts of the conversion as JSON beside it.",
)
@click.option(
    "--write-parameters",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the parameter file that the program leaves behind.",
)
@from_option
@program_options
def command(
    input_name: str, output: Path | None, file_format: str, decimals: str, meta: Path | None,
    write_parameters: Path | None, **given: Any,
) -> int:  # fmt: skip
    """Convert G-code to verified setpoints.

    INPUT is a file, or - for standard input. Nothing is written unless the whole program passes every check.
    """
    from verne_post.model.findings import InputError

    if decimals != "auto" and not (decimals.isdecimal() and int(decimals) <= 12):
        raise click.UsageError(f"--decimals {decimals}: expected auto, or a whole number from 0 to 12")
    given["decimals"] = None if decimals == "auto" else int(decimals)
    if given["split_at_stops"] and output is None:
        raise click.UsageError("--split-at-stops writes several files; give their name with -o")
    check_writable(output, "-o")
    check_writable(meta, "--meta")
    check_writable(write_parameters, "--write-parameters")
    name = shown_name(input_name)
    try:
        machine = load(given.pop("machine_name"))
        paths = given.pop("subroutine_path")
        source, options = program_text(input_name, build_options(name, **given), paths)
    except InputError as error:
        return refuse(name, error)

    from verne_post.gcode.parameter_file import parameter_file
    from verne_post.output.parts import index, index_path, part_path, part_rows
    from verne_post.output.setpoints import FORMATS
    from verne_post.output.summary import meta as meta_text
    from verne_post.output.summary import paragraph
    from verne_post.pipeline import convert

    header, encode = FORMATS[file_format]
    with tempfile.TemporaryFile("w+", encoding="utf-8", newline="\n") as spool:
        spool.write(header(machine.columns))

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
            index_path(output).unlink(missing_ok=True)  # it comes last: where it is, every part is
            for number, part in enumerate(result.summary.parts, start=1):
                write_whole(part_path(output, number), part_rows(spool, header(machine.columns), part, result.summary))
            write_whole(index_path(output), [index(output, result.summary)])
        elif output is None:
            shutil.copyfileobj(spool, sys.stdout)
            sys.stdout.flush()
        else:
            write_whole(output, iter(lambda: spool.read(_COPY), ""))
    if meta is not None:
        write_whole(meta, [meta_text(result.summary)])
    if write_parameters is not None:
        write_whole(write_parameters, [parameter_file(dict(result.summary.parameters))])
    click.echo(paragraph(result.summary), nl=False, err=True)
    return result.exit_code
