"""`verne-post check`: judge programs, in any of the report formats."""

from pathlib import Path
from typing import Any

import click

from verne_post.cli.common import check_writable, load, program_text, progress_bar, refuse, shown_name, write_whole
from verne_post.cli.options import build_options, keep_out_options, program_options, way_options


@click.command("check")
@click.argument("inputs", nargs=-1, required=True, metavar="INPUT...")
@click.option(
    "--output-format",
    type=click.Choice(["text", "json", "sarif", "junit", "github"]),
    default="text",
    help="How findings are written.",
)
@click.option(
    "--output-file",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="F",
    help="Write there in place of standard output.",
)
@click.option(
    "--fail-level",
    type=click.Choice(["error", "warning"]),
    default="error",
    help="Gravity from which findings make exit status 1.",
)
@click.option("--exit-zero", is_flag=True, help="Exit with 0 whatever limits are violated.")
@way_options
@keep_out_options
@program_options
def command(
    inputs: tuple[str, ...],
    output_format: str,
    output_file: Path | None,
    fail_level: str,
    exit_zero: bool,
    **given: Any,
) -> int:
    """Judge programs against every limit, without writing setpoints."""
    from verne_post.cli.main import EXIT_VIOLATION, gravest
    from verne_post.model.findings import InputError, finding
    from verne_post.output.findings import Report, counts
    from verne_post.output.reports import FORMATS
    from verne_post.output.summary import remarks

    check_writable(output_file, "--output-file")
    paths = given.pop("subroutine_path")
    try:
        machine = load(given.pop("machine_name"))
        options = build_options("", **given)
    except InputError as error:
        return refuse(inputs[0], error)

    from dataclasses import replace

    from verne_post.pipeline import check, failed

    reports, statuses = [], []
    for name in inputs:
        shown = shown_name(name)
        source = b""
        with progress_bar() as progress:
            try:
                source, own = program_text(name, replace(options, source_name=shown), paths)
                result = check(source, machine, own, progress)
            except InputError as error:  # the others are judged all the same
                result = failed(error)
            except click.UsageError as error:
                result = failed(InputError(finding("VP022", error.message)))
        time = result.summary.cycle_time if result.summary else None
        said = tuple(remarks(result.summary)) if result.summary else ()
        reports.append(Report(shown, result.findings, time, source, said))
        status = result.exit_code
        if status == 0 and fail_level == "warning" and counts(result.findings)[1]:
            status = EXIT_VIOLATION
        statuses.append(0 if exit_zero and status == EXIT_VIOLATION else status)
    written = FORMATS[output_format](reports, machine)
    if output_file is None:
        click.echo(written, nl=False)
    else:
        write_whole(output_file, [written])
    return gravest(statuses)
