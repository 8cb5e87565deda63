"""`verne-post fit`: the work offset with which a program fits."""

from typing import TYPE_CHECKING, Any

import click

from verne_post.cli.common import read_program, refuse
from verne_post.cli.files import RunFiles, show_name
from verne_post.cli.numbers import read_numbers
from verne_post.cli.options import INPUT, GroupedCommand, NameChoice, add_program_options
from verne_post.cli.progress import show_progress
from verne_post.cli.streams import echo
from verne_post.model.verdict import find_exit_status
from verne_post.output.commands import WITHOUT

if TYPE_CHECKING:
    from verne_post.base.long_text import Text


@click.command("fit", cls=GroupedCommand, short_help="Find a work offset with which the program is within limits.")
@click.argument("input_name", type=INPUT, metavar="INPUT")
@click.option(
    "--free",
    metavar="LETTERS",
    help="Coordinates that may change: x, y, z, and c, the part's rotation; default: all, c only if a joint "
    "turns the part.",
)
@click.option(
    "--range",
    "ranges",
    multiple=True,
    metavar="x=LOW,HIGH",
    help="Range of the zero, in mm of the part frame, or in degrees for c; default: over the table, with "
    "nothing below its face, or without a table everything in reach. Example: --range x=-50,50. Repeatable.",
)
@click.option(
    "--minimise",
    type=NameChoice(["move", "time"]),
    help="Seek the smallest move of the part that brings the program within limits (the default), or the least "
    "time, with a small margin to every limit.",
)
@click.option("--maximise", type=NameChoice(["margin"]), help="Seek the place with the largest margin to every limit.")
@click.option("--json", "as_json", is_flag=True, help="Write JSON in place of text.")
@add_program_options(*WITHOUT["fit"])
def command(
    input_name: str,
    free: str | None,
    ranges: tuple[str, ...],
    minimise: str | None,
    maximise: str | None,
    as_json: bool,
    **given: Any,
) -> int:
    """Find a work offset that brings the whole program within limits, with the smallest move of the part.

    --wcs gives the present place of the part. Coordinates that are not free keep these values. The proposed offset has
    been checked like any program. Exit status: 0 it fits, 1 no position was found, 2 unusable input.

    \b
    Example:
    verne-post fit part.nc --wcs G54=0,0,60 --free xy
    """
    from verne_post.model.findings import InputError, UsageError
    from verne_post.model.option_checks import check_ranges

    name = show_name(input_name)
    if minimise and maximise:
        raise click.UsageError(f"--minimise {minimise} and --maximise {maximise} exclude each other")
    free = None if free is None else free.lower()
    aim: Any = minimise or maximise or "move"
    try:
        allowed = check_ranges(free, _read_ranges(ranges))
    except UsageError as error:
        raise click.UsageError(f"--{error.option} {error.reason}") from None
    source: Text = b""
    try:
        machine, source, options = read_program(RunFiles(), input_name, given)
        from verne_post.app.fit import propose
        from verne_post.output import fit as output
        from verne_post.output.commands import find_run

        with show_progress("reading") as progress:
            proposal = propose(source, machine, options, free, allowed, aim=aim, progress=progress)
    except InputError as error:
        return refuse(name, error, source)
    if as_json:
        echo(output.make_json(name, machine, proposal), nl=False)
    else:
        echo(output.make_text(name, machine, proposal, find_run(options)), nl=False)
    return find_exit_status(proposal.findings)


def _read_ranges(texts: tuple[str, ...]) -> dict[str, tuple[float, ...]]:
    """LOW and HIGH by letter."""
    found: dict[str, tuple[float, ...]] = {}
    for text in texts:
        letter, equals, rest = text.lower().partition("=")
        if not equals:
            raise click.UsageError(
                f"--range {text}: expected LETTER=LOW,HIGH with x, y, z (mm) or c (degrees), such as x=-50,50"
            )
        if letter in found:
            raise click.UsageError(f"--range {text}: {letter} is given twice")
        found[letter] = tuple(read_numbers(rest, f"--range {text}"))
        if len(found[letter]) != 2:
            unit = "degrees" if letter == "c" else "mm"
            raise click.UsageError(f"--range {text}: expected {letter}=LOW,HIGH in {unit}, such as {letter}=-50,50")
    return found
