"""`verne-post dump`: one stage as JSON lines."""

import sys
from typing import TYPE_CHECKING, Any

import click

from verne_post.cli.common import print_findings, read_program, refuse
from verne_post.cli.files import RunFiles, show_name
from verne_post.cli.options import INPUT, GroupedCommand, NameChoice, add_program_options
from verne_post.cli.progress import show_progress
from verne_post.model.verdict import ExitStatus, find_exit_status

if TYPE_CHECKING:
    from verne_post.base.long_text import Text


@click.command("dump", cls=GroupedCommand)
@click.argument("stage", type=NameChoice(["moves", "poses", "joints"]))
@click.argument("input_name", type=INPUT, metavar="INPUT")
@add_program_options("solver", "quality", "jobs", "override", "slow_start")
def command(stage: str, input_name: str, **given: Any) -> int:
    """Print the moves, path or poses of a program as JSON lines.

    \b
    moves   what an interpreter reports: program coordinates; as on a
            machine with --machine, else as without one
    poses   tool tip and axis in the work frame
    joints  joint values, tilt of the platform, margins to every limit

    \b
    Example:
    verne-post dump joints part.nc
    """
    from verne_post.app.assemble import assemble, read_draft, view_moves_plainly
    from verne_post.model.findings import InputError
    from verne_post.output import dump

    name = show_name(input_name)
    files = RunFiles()
    source: Text = b""
    try:
        machine, source, options = read_program(files, input_name, given)
        if stage == "moves":
            moves, errors = (
                view_moves_plainly(source, options)
                if given["machine_name"] is None
                else (read_draft(source, machine, options).moves, ())
            )
            sys.stdout.writelines(dump.dump_moves(moves))
            print_findings(name, (*moves.findings, *errors), source)
            return find_exit_status(errors)
        with show_progress("reading"):
            program = assemble(source, machine, options)
    except InputError as error:
        return refuse(name, error, source)
    lines = (
        dump.dump_poses(program.build_joint_path(), program.moves)
        if stage == "poses"
        else dump.dump_joints(program.build_joint_path())
    )
    sys.stdout.writelines(lines)
    return ExitStatus.CLEAN
