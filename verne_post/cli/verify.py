"""`verne-post verify`: verify a setpoint file as written."""

import os
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import click

from verne_post.base.text_marks import decode_text
from verne_post.cli.colour import say
from verne_post.cli.common import print_findings, quiet_option, read_program, refuse, require_positive
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.measured import add_log_options, read_commanded, read_measured, require_delay
from verne_post.cli.numbers import NUMBER
from verne_post.cli.options import FILE, INPUT, GroupedCommand, add_options, add_program_options
from verne_post.cli.progress import show_progress
from verne_post.cli.streams import echo
from verne_post.model.verdict import ExitStatus, find_exit_status, find_gravest
from verne_post.output.commands import WITHOUT

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from verne_post.app.assemble import Program
    from verne_post.app.result import Progress
    from verne_post.model.setpoints import SetpointBlock
    from verne_post.verification.following import Following


@click.command("verify", cls=GroupedCommand, short_help="Check a setpoint file against limits and program.")
@click.argument("setpoints", type=INPUT, metavar="AXES.CSV")
@click.option("--against", required=True, metavar="INPUT", help="Program from which the file was made.")
@click.option(
    "--meta",
    type=FILE,
    metavar="FILE",
    help="Metadata file of the conversion. The command compares program, machine, offsets, tools and options with it.",
)
@click.option(
    "--measured",
    type=FILE,
    metavar="LOG",
    help="Log of the measured joints of a run of this file (halsampler text or CSV, one row a cycle). The command "
    "compares both.",
)
@add_log_options
@click.option(
    "--following",
    type=NUMBER,
    metavar="MM",
    help="Largest distance of the measured tip from the commanded path; a larger one is an error. Default: none; the "
    "distance is printed.",
)
@quiet_option
@add_options("accept_rounding")
@add_program_options(*WITHOUT["verify"])
def command(
    setpoints: str,
    against: str,
    meta: Path | None,
    measured: Path | None,
    columns: str,
    delay: str,
    following: float | None,
    quiet: bool,
    **given: Any,
) -> int:
    """Verify a setpoint file against its program and its machine.

    The file may have every --format but pvt and ros2. The command reads its numbers, and compares them with the program
    and with the limits of the machine. It trusts the program, the machine file and the options, so give the options
    with which the file was made (--from, --wcs, --tool-table, ...). --override names the share of the feed rate that
    the rows must keep. --keep-out and --stock name bodies that the program must keep out of.

    \b
    Example:
    verne-post verify axes.csv --against part.nc
    """
    from verne_post.model.findings import InputError

    if measured is None and (columns or delay != "auto" or following is not None):
        raise click.UsageError("--columns, --delay and --following are about a log: name it with --measured")
    require_delay(delay)
    if following is not None:
        require_positive("--following", following, zero=True)
    if measured is not None and (is_dash(setpoints) or setpoints.endswith(".index.json")):
        raise click.UsageError("--measured is compared with one setpoint file; name it")
    name, files = show_name(setpoints), RunFiles()
    files.expect(setpoints, "AXES.CSV")
    for path, option in ((meta, "--meta"), (measured, "--measured")):
        files.expect(path, option)
    try:
        machine, source, options = read_program(files, against, given)
    except InputError as error:
        return refuse(show_name(against), error)

    from verne_post.app.assemble import assemble
    from verne_post.app.constraints import check_program
    from verne_post.app.verify import judge_part, read_rows, verify_index, verify_setpoints
    from verne_post.output.commands import find_run
    from verne_post.output.parts import find_index, list_parts
    from verne_post.output.side_car import read_side_car, report_changes
    from verne_post.output.summary import describe_following, format_verdict

    beside = None if is_dash(setpoints) else find_index(Path(setpoints))
    if beside is not None or setpoints.endswith(".index.json"):
        options = options.changed(split_at_stops=True)  # only a program that is cut at its stops has parts
    try:
        found = []
        if meta is not None:
            side_car = read_side_car(decode_text(files.read(meta, "--meta"), "replace"), str(meta))
            found = report_changes(side_car, source, machine, options)
        try:
            with show_progress("reading", quiet=quiet):
                program = assemble(source, machine, options)
        except InputError as error:
            return refuse(show_name(against), error, source)
        if options.keep_out or options.stock:
            found += check_program(program)[1]
        if setpoints.endswith(".index.json"):
            for part in list_parts(Path(setpoints)):
                files.note_read(part, "AXES.CSV")
            verdict = verify_index(program, Path(setpoints))
        else:
            with files.open_input(setpoints, "AXES.CSV") as raw:
                rows = read_rows(program, name, raw)
                with show_progress("verifying", quiet=quiet) as progress:
                    verdict = verify_setpoints(program, _watch(rows, raw, progress))
        log = None if measured is None else _follow_log(files, setpoints, measured, columns, delay, program)
    except InputError as error:
        return refuse(name, error)
    if beside is not None:
        index, number, count = beside
        verdict = judge_part(name, verdict, number, count)
    findings = (*found, *verdict.findings)
    print_findings(show_name(against), findings, quiet=quiet)
    status = find_exit_status(findings)
    if beside is not None and verdict.unchecked:
        together = find_run(options).spell("verify", str(index), "", "--against", shlex.quote(against))
        echo(f"{verdict.unchecked} Verify all parts together: {together}", err=True)
        status = status or ExitStatus.NO_VERDICT
    elif not quiet:
        say(format_verdict(name, verdict, program.machine, passes=status == ExitStatus.CLEAN) + "\n")
    if log is not None and measured is not None:
        followed, source_lines = log
        echo(
            describe_following(show_name(measured), followed, source_lines, program.cycle, program.machine),
            nl=False,
            err=True,
        )
        if following is not None and not followed.path_worst <= following:
            echo(f"{show_name(measured)}: farther from the commanded path than --following {following:g} mm", err=True)
            status = find_gravest([status, ExitStatus.VIOLATION])
    return status


def _watch(rows: "Iterator[SetpointBlock]", raw: IO[bytes], progress: "Progress | None") -> "Iterator[SetpointBlock]":
    """The blocks of a file, telling how much of it has been read."""
    size = os.fstat(raw.fileno()).st_size if progress is not None and raw.seekable() else 0
    for block in rows:
        yield block
        if progress is not None:
            progress("verifying", raw.tell() if size else 0, size)


def _follow_log(
    files: RunFiles,
    setpoints: str,
    measured: Path,
    columns: str,
    delay: str,
    program: "Program",
) -> "tuple[Following, NDArray[np.int32]]":
    """Compare a log with the file that it is a run of; also returns the source lines of the file's rows."""
    from verne_post.verification.following import compare_log

    commanded, lines = read_commanded(files, setpoints, program)
    measured_joints, delayed = read_measured(files, measured, columns, delay, commanded, program)
    lengths = program.path.find_tool_lengths(lines)
    return compare_log(commanded, measured_joints, lengths, program.machine.five_axis.find_nominal_pose, delayed), lines
