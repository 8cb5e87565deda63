"""`verne-post machined`: what the written rows leave of the nominal part."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from verne_post.cli.colour import say
from verne_post.cli.common import print_findings, quiet_option, read_program, refuse, require_positive
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.measured import add_log_options, read_commanded, read_measured, require_delay
from verne_post.cli.numbers import NUMBER
from verne_post.cli.options import FILE, INPUT, GroupedCommand, NameChoice, add_program_options
from verne_post.cli.pictures import SUFFIXES, expect_picture
from verne_post.cli.progress import show_progress
from verne_post.cli.streams import print_as_is
from verne_post.model.part_setup import GRID_MM, SYSTEM_NUMBERS, UNITS, Wanted
from verne_post.model.verdict import find_exit_status

_ASKED = Wanted()


def _add_length(name: str, text: str) -> Callable[[Any], Any]:
    """The option of a length (mm) of :class:`Wanted`; the grid has no default."""
    default = getattr(_ASKED, name)
    shown = f"{GRID_MM:g}, of a large part more" if default is None else True
    return click.option(f"--{name}", type=NUMBER, default=default, metavar="MM", show_default=shown, help=text)


@click.command("machined", cls=GroupedCommand, short_help="Compare the rows with the nominal part.")
@click.argument("setpoints", type=INPUT, metavar="AXES.CSV")
@click.option("--against", required=True, metavar="INPUT", help="The program that the file was made from.")
@click.option("--nominal", metavar="PART.STL@G54", help="The nominal part, in a work system or @table.")
@click.option(
    "--fixture",
    "fixtures",
    multiple=True,
    metavar="VISE.STL@G54",
    help="A fixture that tool and spindle keep out of (VP215); repeatable.",
)
@click.option(
    "--distance",
    type=NUMBER,
    default=0.0,
    metavar="MM",
    show_default=True,
    help="Smallest distance of tool and spindle from fixtures.",
)
@click.option(
    "--stock-from",
    metavar="FILE@G54|program",
    help="Stock to cut: an STL file, a file of --stock-left (.npz), or the stock of the program; --stock is a box.",
)
@click.option(
    "--stock-left", metavar="FILE@G54", help="File for the material that is left, as .stl or, without loss, .npz."
)
@click.option(
    "--unit",
    type=NameChoice(list(UNITS)),
    default="mm",
    show_default=True,
    help="Unit of the STL file, which does not contain it.",
)
@_add_length("gouge", "Depth beyond which a cut into the part is an error (VP218).")
@_add_length("excess", "Excess material beyond which there is a warning (VP219).")
@_add_length("grid", "Largest distance of any point of the surface from an examined point.")
@_add_length("search", "Depth below and height above the surface that are examined; less than the thinnest wall.")
@click.option(
    "--datum",
    type=NameChoice(["table", "fit"]),
    default="table",
    show_default=True,
    help="Position of the part that decides: as the set-up says, or the best fit.",
)
@click.option("--measured", type=FILE, metavar="LOG", help="Measured axes of a run of this file, in place of its rows.")
@add_log_options
@click.option("--csv", "table", type=FILE, metavar="FILE", help="File for a table of the worst places.")
@click.option(
    "-o",
    "--output",
    type=FILE,
    metavar="MAP.ply|.png|.svg",
    help="File for the part with its deviations: triangles with colours, or a picture.",
)
@click.option(
    "--output-format",
    type=NameChoice(["text", "json", "sarif", "junit", "github", "markdown"]),
    default="text",
    show_default=True,
    help="Format of the findings.",
)
@quiet_option
@add_program_options("solver", "quality", "jobs", "slow_start")
def command(
    setpoints: str,
    against: str,
    nominal: str | None,
    fixtures: tuple[str, ...],
    distance: float,
    stock_from: str | None,
    stock_left: str | None,
    unit: str,
    gouge: float,
    excess: float,
    grid: float | None,
    search: float,
    datum: Any,
    measured: Path | None,
    columns: str,
    delay: str,
    table: Path | None,
    output: Path | None,
    output_format: str,
    quiet: bool,
    **given: Any,
) -> int:
    """Compare rows as written, or as measured, with the nominal part and with fixtures: gouges, excess, contacts, and
    what is certain.

    Give the options with which the file was made (--wcs, --tool-table, --tool-shapes, ...). On a machine with
    [as_built] the command compares the rows on the machine as built, which decides, and on the nominal machine. With a
    stock (--stock, --stock-from) it also reports the material that is cut, the contacts, and the material that is left.

    \b
    Example:
    verne-post machined axes.csv --against part.nc --nominal part.stl@G54 --tool-shapes shapes.toml
    """
    from verne_post.model.findings import InputError

    places = [
        (option, *_split_place(option, text))
        for option, text in (("--nominal", nominal), *(("--fixture", one) for one in fixtures))
        if text
    ]
    stock_place = None if stock_from in (None, "program") else _split_place("--stock-from", stock_from)
    left_place = None if stock_left is None else _split_place("--stock-left", stock_left)
    if left_place is not None and left_place[0].suffix.lower() not in (".stl", ".npz"):
        raise click.UsageError(f"--stock-left {stock_left}: expected a name that ends in .stl or .npz")
    if stock_from is not None and given.get("stock") is not None:
        raise click.UsageError("--stock and --stock-from exclude each other")
    if nominal is None and (table is not None or output is not None):
        raise click.UsageError("--csv and -o show the nominal part: name it with --nominal")
    require_positive("--distance", distance, zero=True)
    for option, value in (("--gouge", gouge), ("--excess", excess), ("--grid", grid), ("--search", search)):
        if value is not None:
            require_positive(option, value)
    if search < max(gouge, excess):
        raise click.UsageError(f"--search {search:g} must not be below --gouge and --excess")
    if measured is None and (columns or delay != "auto"):
        raise click.UsageError("--columns and --delay are about a log: name it with --measured")
    require_delay(delay)
    if measured is not None and setpoints.endswith(".index.json"):
        raise click.UsageError("--measured is compared with one setpoint file; name it")
    files, name = RunFiles(), show_name(setpoints)
    files.expect(setpoints, "AXES.CSV")
    for option, file, _system in places:
        files.expect(file, option)
    for path, option in ((stock_place and stock_place[0], "--stock-from"), (measured, "--measured")):
        files.expect(path, option)
    if output_format != "text":
        files.claim_output("the findings")
    for path, option in ((table, "--csv"), (left_place and left_place[0], "--stock-left")):
        files.expect_writing(path, option)
    suffix = _expect_map(files, output)
    try:
        machine, source, options = read_program(files, against, given)
    except InputError as error:
        return refuse(name, error)
    with_stock = stock_from is not None or options.stock is not None
    if not places and not with_stock:
        raise click.UsageError(
            "say what the rows are compared with: --nominal PART.STL@G54, --fixture VISE.STL@G54, a stock "
            "(--stock, --stock-from), or several"
        )
    if left_place is not None and not with_stock:
        raise click.UsageError("--stock-left is about a stock: name it with --stock or --stock-from")

    from verne_post.app.assemble import assemble
    from verne_post.app.machined import Body, judge_rows
    from verne_post.app.machined_stock import add_stock, cut_rows, describe_run, load_stock, make_stock, pack_stock
    from verne_post.output.findings import Report
    from verne_post.output.machined import describe_comparisons, draw_map, encode_ply, list_worst
    from verne_post.output.reports import FORMATS
    from verne_post.part.stl import read_stl

    try:
        bodies = [
            Body(read_stl(bytes(files.read(file, option)), show_name(str(file)), unit), system)
            for option, file, system in places
        ]
        part = bodies.pop(0) if nominal is not None else None
        with show_progress("reading", quiet=quiet) as progress:
            try:
                program = assemble(source, machine, options)
            except InputError as error:
                return refuse(show_name(against), error, source)
            q, lines = read_commanded(files, setpoints, program)
            if measured is not None:
                log, delayed = read_measured(files, measured, columns, delay, q, program)
                count = min(len(q), len(log) - delayed)
                q, lines = log[delayed : delayed + count], lines[:count]
            asked = Wanted(gouge, excess, grid, search)
            found = judge_rows(program, q, lines, part, bodies, asked, datum, distance, progress)
            run, left = None, b""
            if with_stock:
                if stock_place is not None:
                    raw = bytes(files.read(stock_place[0], "--stock-from"))
                    stock = load_stock(program, raw, show_name(str(stock_place[0])), stock_place[1], unit)
                else:
                    stock = make_stock(program)
                run = cut_rows(program, q, lines, stock)
                if part is not None and not part.mesh.open_edges:
                    found = add_stock(program, found, part, run.left)
                if left_place is not None:
                    left = pack_stock(program, run.left, left_place[0].name, left_place[1])
    except InputError as error:
        return refuse(name, error)
    findings = (*found.findings, *(() if run is None else run.findings))
    if output_format == "text":
        print_findings(show_name(against), findings, quiet=quiet)
    else:
        print_as_is(FORMATS[output_format]([Report(show_name(against), findings, None, source, ())], machine))
    if not quiet:
        if places:
            say(describe_comparisons(name if measured is None else show_name(str(measured)), found))
        if run is not None:
            say(describe_run(run))
    if left_place is not None:
        files.write(left_place[0], "--stock-left", [left])
    if table is not None:
        files.write(table, "--csv", [list_worst(found.judged[0])])
    if output is not None:
        picture = encode_ply(found.judged[0]) if suffix == ".ply" else draw_map(found.judged[0], suffix)
        files.write(output, "-o", [picture])
    return find_exit_status(findings)


def _split_place(option: str, text: str) -> tuple[Path, int | None]:
    """File and work system of PART.STL@G54; None: the table."""
    file, _, place = text.rpartition("@")
    if not file or (place != "table" and place not in SYSTEM_NUMBERS) or is_dash(file):
        raise click.UsageError(f"{option} {text}: expected a file and its system, as in part.stl@G54 or part.stl@table")
    return Path(file), SYSTEM_NUMBERS.get(place)


def _expect_map(files: RunFiles, output: Path | None) -> str:
    """The format of the map, as an ending; empty without one."""
    if output is None:
        return ""
    suffix = output.suffix.lower()
    if suffix in SUFFIXES:
        return expect_picture(files, output, "-o")
    if suffix != ".ply":
        raise click.UsageError(f"-o {output}: expected a name that ends in .ply, {' or '.join(SUFFIXES)}")
    files.expect_writing(output, "-o")
    return suffix
