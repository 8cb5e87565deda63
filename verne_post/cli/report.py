"""`verne-post report`: one page that shows a program from all sides."""

from pathlib import Path
from typing import Any

import click

from verne_post.cli.colour import say
from verne_post.cli.common import PROGRAM, quiet_option, read_program, refuse
from verne_post.cli.files import RunFiles, show_name
from verne_post.cli.options import FILE, INPUT, GroupedCommand, add_program_options
from verne_post.cli.pictures import expect_picture, require_package
from verne_post.cli.progress import show_progress
from verne_post.model.verdict import find_exit_status


@click.command("report", cls=GroupedCommand)
@click.argument("input_name", type=INPUT, metavar="INPUT")
@click.option("-o", "--output", type=FILE, metavar="OUT.html", help="The page.")
@click.option("--static", type=FILE, metavar="OUT.png|OUT.svg", help="A picture of the path and the axes, for CI.")
@quiet_option
@add_program_options()
def command(input_name: str, output: Path | None, static: Path | None, quiet: bool, **given: Any) -> int:
    """Write one self-contained page, no network: findings, tool path, axes against time, workspace, and the mechanism at the cursor.

    A program that is refused is drawn by its path, with the violations marked; the exit status is that of `check`.
    """
    from verne_post.model.findings import InputError

    if output is None and static is None:
        raise click.UsageError("say where to write: -o OUT.html, --static OUT.png, or both")
    files = RunFiles()
    files.expect(input_name, PROGRAM)
    suffix = "" if static is None else expect_picture(files, static, "--static")
    if output is not None:
        files.expect_writing(output, "-o")
        require_package("jupyter_threejs_sage", "-o", "report")
    name = show_name(input_name)
    try:
        machine, source, options = read_program(files, input_name, given)
    except InputError as error:
        return refuse(name, error)

    from verne_post.output.findings import format_outcome
    from verne_post.report import picture
    from verne_post.report.page import make_page
    from verne_post.report.study import study

    with show_progress("reading", quiet=quiet) as progress:
        found = study(source, machine, options, progress)
    if output is not None:
        files.write(output, "-o", [make_page(name, source, machine, found)])
    if static is not None:
        files.write(static, "--static", [picture.picture_of(name, machine, found, suffix)])
    if not quiet:
        written = " and ".join(show_name(str(path)) for path in (output, static) if path is not None)
        say(f"{format_outcome(name, found.findings)}; {written} shows it\n")
    return find_exit_status(found.findings)
