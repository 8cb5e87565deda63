"""`verne-post check`: judge programs, in any of the report formats."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from verne_post.cli.common import PROGRAM, load, program_text, progress_bar, refuse, shown_name
from verne_post.cli.files import RunFiles, Unreadable
from verne_post.cli.options import build_options, keep_out_options, policy_of, program_options, settings_of, way_options

if TYPE_CHECKING:
    from verne_post.base.long_text import Text


@click.command("check")
@click.argument("inputs", nargs=-1, required=True, metavar="INPUT...")
@click.option(
    "--output-format",
    type=click.Choice(["text", "json", "jsonl", "sarif", "junit", "github"]),
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
    envvar="VERNE_POST_FAIL_LEVEL",
    help="Gravity from which findings make exit status 1; default: error.",
)
@click.option(
    "--select", envvar="VERNE_POST_SELECT", metavar="VP1,VP202,...", help="Only these codes count, by their beginnings."
)
@click.option("--ignore", envvar="VERNE_POST_IGNORE", metavar="VP203,...", help="These codes do not count.")
@click.option(
    "--severity", multiple=True, metavar="VP202=error", help="Weigh a code as error, warning or note; repeatable."
)
@click.option(
    "--baseline",
    type=click.Path(dir_okay=False, path_type=Path),
    envvar="VERNE_POST_BASELINE",
    metavar="FILE",
    help="Findings that are known and do not count.",
)
@click.option(
    "--write-baseline",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write all findings of now as a baseline.",
)
@click.option("--exit-zero", is_flag=True, help="Exit with 0 whatever limits are violated.")
@way_options
@keep_out_options
@program_options
def command(
    inputs: tuple[str, ...],
    output_format: str,
    output_file: Path | None,
    fail_level: str | None,
    exit_zero: bool,
    write_baseline: Path | None,
    **given: Any,
) -> int:
    """Judge programs against every limit, without writing setpoints.

    What counts may also stand in [check] of verne-post.toml, or [tool.verne-post.check] of pyproject.toml; an option goes before an
    environment variable, and that before the file.
    """
    from verne_post.cli.main import EXIT_VIOLATION, gravest
    from verne_post.model.findings import InputError, finding
    from verne_post.output.findings import Report, counts
    from verne_post.output.policy import applied, baseline_text
    from verne_post.output.reports import FORMATS
    from verne_post.output.summary import remarks

    files = RunFiles()
    for name in inputs:
        files.reads(name, PROGRAM)
    for path, option in ((output_file, "--output-file"), (write_baseline, "--write-baseline")):
        if path is not None:
            files.writes(path, option)
    asked = {key: given.pop(key) for key in ("select", "ignore", "severity", "baseline")}
    paths = given.pop("subroutine_path")
    try:
        machine = load(files, given.pop("machine_name"))
        options = build_options(files, "", **given)
        policy, level = policy_of(files, settings_of(files, given.get("settings")), fail_level, **asked)
    except InputError as error:
        return refuse(inputs[0], error)

    from dataclasses import replace

    from verne_post.app.check import check
    from verne_post.app.result import failed

    everything: list[Report] = []
    reports, statuses = [], []
    for name in inputs:
        shown = shown_name(name)
        source: Text = b""
        with progress_bar() as progress:
            try:
                source, own = program_text(files, name, replace(options, source_name=shown), paths)
                result = check(source, machine, own, progress)
            except InputError as error:  # the others are judged all the same
                result = failed(error)
            except (click.UsageError, Unreadable) as error:
                result = failed(InputError(finding("VP022", str(error))))
        time = result.summary.cycle_time if result.summary else None
        said = tuple(remarks(result.summary)) if result.summary else ()
        everything.append(Report(shown, result.findings, time, source, said))
        reports.append(applied(everything[-1], policy))
        status = result.exit_code
        if status in (0, EXIT_VIOLATION):
            errors, warnings = counts(reports[-1].findings)
            status = EXIT_VIOLATION if errors or (level == "warning" and warnings) else 0
        statuses.append(0 if exit_zero and status == EXIT_VIOLATION else status)
    if write_baseline is not None:
        files.write(write_baseline, "--write-baseline", [baseline_text(everything)])
    written = FORMATS[output_format](reports, machine)
    if output_file is None:
        click.echo(written, nl=False)
    else:
        files.write(output_file, "--output-file", [written])
    return gravest(statuses)
