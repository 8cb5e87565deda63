"""`verne-post dump`: one stage as JSON lines."""

import sys
from typing import Any

import click

from verne_post.cli.common import load, print_findings, program_text, refuse, shown_name
from verne_post.cli.files import RunFiles
from verne_post.cli.options import build_options, program_options, way_options


@click.command("dump")
@click.argument("stage", type=click.Choice(["moves", "poses", "joints"]))
@click.argument("input_name", metavar="INPUT")
@way_options
@program_options
def command(stage: str, input_name: str, machine_name: str, subroutine_path: tuple[str, ...], **given: Any) -> int:
    """Print one stage of a program as JSON lines.

    \b
    moves   what an interpreter reports: program coordinates, no machine
    poses   tool tip and axis in the work frame
    joints  joint values, lean of the platform, margins to every limit
    """
    from verne_post.cli.main import EXIT_CLEAN, EXIT_USAGE
    from verne_post.model.findings import InputError
    from verne_post.output import dump
    from verne_post.app.assemble import interpreter_view, assemble

    name = shown_name(input_name)
    files = RunFiles()
    try:
        source, options = program_text(files, input_name, build_options(files, name, **given), subroutine_path)
        if stage == "moves":
            moves, errors = interpreter_view(source, options)
            sys.stdout.writelines(dump.moves(moves))
            print_findings(name, errors)
            return EXIT_USAGE if errors else EXIT_CLEAN
        program = assemble(source, load(files, machine_name), options)
    except InputError as error:
        return refuse(name, error)
    lines = dump.poses(program.joints(), program.moves) if stage == "poses" else dump.joints(program.joints())
    sys.stdout.writelines(lines)
    return EXIT_CLEAN
