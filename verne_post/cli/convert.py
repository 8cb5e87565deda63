"""`verne-post convert`: the main job."""

from pathlib import Path
from typing import Any

import click

from verne_post.cli.colour import say
from verne_post.cli.common import PROGRAM, print_findings, quiet_option, read_program, refuse
from verne_post.cli.conversion import Outputs, convert_to_files, format_option
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.options import FILE, INPUT, WRITING, GroupedCommand, add_options, add_program_options
from verne_post.cli.progress import show_progress
from verne_post.model.options import Group


@click.command("convert", cls=GroupedCommand, own=Group.OUTPUT, short_help="Convert a program to verified setpoints.")
@click.argument("input_name", type=INPUT, metavar="INPUT")
@click.option("-o", "--output", type=FILE, metavar="OUT", help="File to write, in place of standard output.")
@click.option("--meta", type=FILE, metavar="FILE", help="Write a description of the setpoint file as JSON.")
@click.option(
    "--events",
    type=FILE,
    metavar="FILE",
    help="Write auxiliary functions and dwells, with time, line and joints, as FILE.csv or FILE.json.",
)
@click.option(
    "--write-parameters", type=FILE, metavar="FILE", help="Write the parameters after the end of the program."
)
@format_option
@add_options(*WRITING)
@quiet_option
@add_program_options()
def command(
    input_name: str,
    output: Path | None,
    file_format: str,
    meta: Path | None,
    events: Path | None,
    write_parameters: Path | None,
    quiet: bool,
    **given: Any,
) -> int:
    """Convert a program (G-code, Klartext or CL file) to verified setpoints.

    INPUT is a file, or - for standard input. verne-post writes nothing unless the whole program passes every check.

    \b
    Example:
    verne-post convert part.nc --tool-table tools.tbl -o axes.csv
    """
    from verne_post.model.findings import InputError

    output = None if is_dash(output) else output
    files, outputs = RunFiles(), Outputs(output, file_format, meta, events, write_parameters)
    files.expect(input_name, PROGRAM)
    outputs.check(files)
    name = show_name(input_name)
    try:
        machine, source, options = read_program(files, input_name, given)
    except InputError as error:
        return refuse(name, error)
    if options.split_at_stops:
        outputs.check_parts(files, asked=bool(given.get("split_at_stops")))

    from verne_post.output.findings import describe_unchecked, format_outcome
    from verne_post.output.summary import format_summary

    with show_progress("reading", quiet=quiet) as progress:
        result, added = convert_to_files(source, machine, options, outputs, files, progress)
    print_findings(name, result.findings, source, quiet=quiet)
    if not quiet:
        if result.ok and result.summary is not None:
            say(format_summary(result.summary, added))
        else:
            say(f"{format_outcome(name, result.findings)}; nothing was written\n")
            say("".join(f"  {text}\n" for text in describe_unchecked([result.unchecked])))
    return result.exit_code
