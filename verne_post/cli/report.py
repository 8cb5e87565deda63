"""`verne-post report`: one page that shows a program from all sides."""

from pathlib import Path
from typing import Any

import click

from verne_post.cli.colour import say
from verne_post.cli.common import PROGRAM, print_findings, quiet_option, read_program, refuse
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.options import FILE, INPUT, GroupedCommand, add_program_options
from verne_post.cli.pictures import expect_picture, require_package
from verne_post.cli.progress import show_progress
from verne_post.model.verdict import find_exit_status, find_gravest

#: Endings of a page; a device has none.
_PAGES = ("", ".html", ".htm")


@click.command("report", cls=GroupedCommand, short_help="Write one page: verdict, machine, path, time, set-up sheet.")
@click.argument("inputs", type=INPUT, nargs=-1, required=True, metavar="INPUT [INPUT]")
@click.option("-o", "--output", type=FILE, metavar="OUT.html", help="The page to write.")
@click.option("--static", type=FILE, metavar="OUT.png|OUT.svg", help="A picture of path and axes to write, for CI.")
@quiet_option
@add_program_options()
def command(inputs: tuple[str, ...], output: Path | None, static: Path | None, quiet: bool, **given: Any) -> int:
    """Write one HTML page about a program: whether it can run, how long it takes, and what limits it.

    Below the findings, the page shows the machine in motion beside the program, time by limit and operation, the axes,
    and the set-up sheet. Printed to A4, it is the sheet at the machine. It loads nothing from a network. Of two
    programs, or two versions of one, the page says what differs.

    The exit status is that of `check`. A program that is refused is drawn by its path, with the violations marked.

    \b
    Example:
    verne-post report part.nc -o report.html
    """
    from verne_post.model.findings import InputError

    if output is None and static is None:
        raise click.UsageError("say where to write: -o OUT.html, --static OUT.png, or both")
    if len(inputs) > 2:
        raise click.UsageError(f"a page shows one program or compares two; {len(inputs)} are given")
    if len(inputs) == 2 and static is not None:
        raise click.UsageError("--static draws one program; two are compared by -o OUT.html alone")
    if all(map(is_dash, inputs)) and len(inputs) > 1:
        raise click.UsageError("standard input can be one of the two programs; the other one is a file")
    files = RunFiles()
    for input_name in inputs:
        files.expect(input_name, PROGRAM)
    suffix = "" if static is None else expect_picture(files, static, "--static")
    if output is not None:
        files.expect_writing(output, "-o")
        if len(inputs) == 1:  # a comparison draws no machine
            require_package("jupyter_threejs_sage", "report -o", "report")
    read = []
    for input_name in inputs:
        try:
            read.append((show_name(input_name), *read_program(files, input_name, given)))
        except InputError as error:
            return refuse(show_name(input_name), error)
    if output is not None and output.suffix.lower() not in _PAGES:  # a file that is read has been told by its option
        raise click.UsageError(f"-o {output}: expected a name that ends in .html")

    from verne_post.output.findings import format_outcome
    from verne_post.report import picture
    from verne_post.report.comparison import make_side, write_comparison
    from verne_post.report.page import make_page
    from verne_post.report.study import study

    found = []
    for name, machine, source, options in read:
        with show_progress(f"reading {name}" if len(read) > 1 else "reading", quiet=quiet) as progress:
            found.append((name, source, machine, study(source, machine, options, progress)))
    if output is not None:
        if len(found) == 1:
            text = make_page(*found[0])
        else:
            text = write_comparison((make_side(*found[0]), make_side(*found[1])))
        files.write(output, "-o", [text])
    if static is not None:
        name, _source, machine, studied = found[0]
        files.write(static, "--static", [picture.picture_of(name, machine, studied, suffix)])
    for name, source, _machine, studied in found:
        print_findings(name, studied.findings, source, quiet=quiet)
    if not quiet:
        written = " and ".join(show_name(str(path)) for path in (output, static) if path is not None)
        outcomes = "; ".join(format_outcome(name, seen.findings, 0, machine) for name, _source, machine, seen in found)
        show = "shows" if output is None or static is None else "show"
        say(f"{outcomes}; {written} {show} {'it' if len(found) == 1 else 'both'}\n")
    return find_gravest(find_exit_status(studied.findings) for *_program, studied in found)
