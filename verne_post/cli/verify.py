"""`verne-post verify`: judge a setpoint file as written."""

import sys
from pathlib import Path
from typing import Any

import click

from verne_post.cli.common import load, print_findings, program_text, read_bytes, refuse, shown_name
from verne_post.cli.options import build_options, program_options, units_option, way_options


@click.command("verify")
@click.argument("setpoints", metavar="AXES.CSV")
@click.option("--against", required=True, metavar="INPUT", help="The program that the file was made from.")
@click.option(
    "--meta",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="The side-car of the conversion: says whether program, machine, offsets, tools and options are still the same.",
)
@click.option("--accept-rounding", is_flag=True, help="Judge files whose decimals alone break a limit.")
@units_option
@way_options
@program_options
def command(setpoints: str, against: str, machine_name: str, meta: Path | None, **given: Any) -> int:
    """Judge a setpoint file as written, believing nothing but the file.

    Give the options (--from, --wcs, --tool-table, ...) with which it was made; of the override, the decimals and the fixtures nothing
    need be said.
    """
    from verne_post.cli.main import EXIT_CLEAN, EXIT_VIOLATION
    from verne_post.model.findings import InputError
    from verne_post.output.origin import changed_since, read_side_car
    from verne_post.output.parts import read_parts
    from verne_post.output.setpoints import read_csv
    from verne_post.output.summary import verdict_line
    from verne_post.pipeline import drives_of, read_program, verify_setpoints

    if setpoints == "-" and against == "-":
        raise click.UsageError("only one of the two inputs can be standard input")
    name = shown_name(setpoints)
    try:
        paths = given.pop("subroutine_path")
        source, options = program_text(against, build_options(shown_name(against), **given), paths)
        machine = load(machine_name)
        changed = []
        if meta is not None:
            side_car = read_side_car(read_bytes(str(meta)).decode("utf-8", errors="replace"), str(meta))
            changed = changed_since(side_car, source, machine, options)
        program = read_program(source, machine, options)
        drives = drives_of(program.machine, options)
        if setpoints.endswith(".index.json"):
            lines = [int(program.moves.line[stop]) for stop in program.stops]
            parts = read_parts(Path(setpoints), program.machine.columns, program.cycle, lines, drives)
            verdict = verify_setpoints(program, parts)
        else:
            stream = sys.stdin if setpoints == "-" else click.open_file(setpoints, encoding="utf-8")
            with stream:
                verdict = verify_setpoints(
                    program, read_csv(stream, name, program.machine.columns, program.cycle, drives)
                )
    except InputError as error:
        return refuse(name, error)
    except (OSError, UnicodeDecodeError) as error:
        raise click.UsageError(f"{name}: {error}") from None
    print_findings(shown_name(against), (*changed, *verdict.findings))
    click.echo(verdict_line(name, verdict, program.machine), err=True)
    return EXIT_CLEAN if verdict.ok and not changed else EXIT_VIOLATION
