"""`verne-post check`: check programs, in any of the report formats."""

import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
from msgspec.structs import replace

from verne_post.base.numbers import format_count
from verne_post.base.text_marks import decode_text
from verne_post.cli.colour import say
from verne_post.cli.common import (
    PROGRAM,
    expect_options,
    load_machines,
    quiet_option,
    read_program_text,
    refuse,
)
from verne_post.cli.files import FileError, RunFiles, Unreadable, is_dash, report_unread, show_name
from verne_post.cli.options import (
    FILE,
    INPUT,
    WRITING,
    GroupedCommand,
    NameChoice,
    add_options,
    add_program_options,
    build_options,
    decorate,
    find_given_run,
    find_settings,
)
from verne_post.cli.programs import add_exclude_option, drop_excluded, find_programs, find_readers, name_passed_over
from verne_post.cli.progress import show_progress
from verne_post.cli.report_files import add_report_files, report_failure, take_report_files, write_report_files
from verne_post.cli.streams import print_as_is
from verne_post.model.verdict import ExitStatus, find_exit_status, find_gravest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from verne_post.base.long_text import Text
    from verne_post.config.settings import Settings
    from verne_post.model.findings import Finding
    from verne_post.model.machine import Machine
    from verne_post.model.verdict import Severity
    from verne_post.output.findings import Report
    from verne_post.output.policy import Policy


#: Options that say which findings count.
_POLICY: Final = (
    click.option(
        "--select",
        envvar="VERNE_POST_SELECT",
        metavar="VP1,VP202,...",
        help="Count only findings whose code begins with one of these prefixes.",
    ),
    click.option("--ignore", envvar="VERNE_POST_IGNORE", metavar="VP203,...", help="Ignore codes with these prefixes."),
    click.option(
        "--severity",
        multiple=True,
        metavar="VP202=error",
        help="Change the severity of a code to error, warning or note; repeatable.",
    ),
    click.option(
        "--baseline",
        type=FILE,
        envvar="VERNE_POST_BASELINE",
        metavar="FILE",
        help="File of known findings, which do not count.",
    ),
)


def add_policy_options(command: "Callable[..., Any]") -> "Callable[..., Any]":
    """The options that say which findings count, for the commands that show them."""
    return decorate(command, _POLICY)


@click.command("check", cls=GroupedCommand, short_help="Check programs against every limit; write no file.")
@click.argument("inputs", type=INPUT, nargs=-1, required=True, metavar="INPUT|DIR...")
@click.option(
    "--output-format",
    type=NameChoice(["text", "json", "jsonl", "sarif", "junit", "github", "markdown"]),
    default="text",
    help="Format of the findings; default: text.",
)
@click.option("--output-file", type=FILE, metavar="F", help="File for the findings, in place of standard output.")
@add_report_files
@click.option(
    "--fail-level",
    type=NameChoice(["error", "warning"]),
    envvar="VERNE_POST_FAIL_LEVEL",
    help="Lowest severity that makes exit status 1; default: error.",
)
@add_policy_options
@add_exclude_option
@click.option(
    "--write-baseline",
    type=FILE,
    metavar="FILE",
    help="Write the current findings as a baseline; FILE may be that of --baseline.",
)
@click.option(
    "--changed",
    is_flag=True,
    help="INPUT lists changed files. If programs share one of them, check every program that git tracks. With "
    "--quiet, warnings of programs that have changed are printed, too.",
)
@click.option(
    "--limits-only",
    is_flag=True,
    help="Check the limits without planning: 40 % of the CPU time, and no machining time (VP421).",
)
@click.option("--exit-zero", is_flag=True, help="Exit with 0 even if limits are violated.")
@quiet_option
@add_options(*WRITING)
@add_program_options()
def command(
    inputs: tuple[str, ...],
    output_format: str,
    output_file: Path | None,
    fail_level: "Severity | None",
    exit_zero: bool,
    exclude: tuple[str, ...],
    write_baseline: Path | None,
    changed: bool,
    limits_only: bool,
    quiet: bool,
    **given: Any,
) -> int:
    """Check programs against every limit, without writing setpoints.

    INPUT may be a file, a folder of programs, or a pattern: verne-post check part.nc programs "more/op*.nc"
    A subprogram in a folder or pattern is checked as a part of each program that calls it, and not by itself.

    No rows are written. --decimals, --units and --accept-rounding say how `convert` would round them: check refuses a
    program where rounding alone exceeds a limit (VP018).

    The table [check] of verne-post.toml, or [tool.verne-post.check] of pyproject.toml, may also say which findings
    count. An option overrides an environment variable, and a variable overrides the file.

    \b
    Example:
    verne-post check programs --fail-level warning
    """
    from verne_post.model.findings import InputError
    from verne_post.output.reports import FORMATS

    def find_own_settings(name: str) -> "Settings | None":
        return find_settings(files, given.get("settings"), name)

    own = {name.removesuffix(".toml") for name in inputs} if changed else set()
    inputs = find_readers(inputs) if changed else inputs
    files = RunFiles()
    found, programs, lacking = list[tuple[str, Path]](), list[str](), None
    named = set[str]()
    try:
        if inputs:
            found, named = find_programs(inputs, lambda name: files.note_read(name, PROGRAM), may_lack=True)
    except click.UsageError as error:  # every report that is asked for says it
        lacking = error
    output_file = None if is_dash(output_file) else output_file
    if output_file is None:
        files.claim_output("the findings")
    for path, option in ((output_file, "--output-file"), (write_baseline, "--write-baseline")):
        files.expect_writing(path, option)
    report_files = take_report_files(files, given)
    asked = {key: given.pop(key) for key in ("select", "ignore", "severity", "baseline")}
    try:
        if lacking is not None:
            raise lacking
        excluded = 0
        if inputs:
            found, excluded = drop_excluded(
                found, () if changed else named, inputs, exclude, find_own_settings, may_lack=changed
            )
        if not found:  # what an earlier run has reported is no report of this one
            write_report_files(files, report_files, [], None)
            _emit(files, output_file, FORMATS[output_format]([], None))
            return ExitStatus.CLEAN
        programs = [name for name, _place in found]
        expect_options(files, programs, given)
        policies = {
            name: make_policy(files, find_own_settings(name), fail_level, **asked, written=write_baseline)
            for name in programs
        }
        machines = load_machines(files, programs, given)
        machine = machines[programs[0]]
    except InputError as error:
        report_failure(files, report_files, error, output_format, partial(_emit, files, output_file))
        status = refuse(inputs[0], error)
        if output_format == "text":
            say(f"nothing was checked: {_count_errors(error.findings)}\n")
        return status
    except (click.UsageError, Unreadable) as error:
        report_failure(files, report_files, error, output_format, partial(_emit, files, output_file))
        raise

    from verne_post.app.called_files import drop_called
    from verne_post.output.batch_table import count_words
    from verne_post.output.findings import Report, drop_repeated
    from verne_post.output.policy import apply_policy, format_baseline

    made: dict[str, Report] = {}
    # a log that is a terminal, as of act, would show the line of progress before a command, which then is none
    still = quiet or output_format == "github"
    for name in programs:
        report = _check_one(files, name, machines[name], given, quiet=still, limits_only=limits_only)
        machine_of_it = None if machines[name] is machine else machines[name]
        made[name] = replace(report, machine=machine_of_it, fail_level=policies[name][1])
    if not quiet:
        say("".join(f"{note}\n" for note in dict.fromkeys(policy.note for policy, _level in policies.values()) if note))
    counted = {name: apply_policy(report, policies[name][0]) for name, report in made.items()}
    kept = drop_called(counted, () if changed else named, find_own_settings)
    everything, statuses = [made[name] for name in kept], []
    reports = list(kept.values())
    reports[0] = replace(reports[0], excluded=excluded)
    for report in reports:
        status = find_exit_status(report.findings, report.fail_level)
        statuses.append(ExitStatus.CLEAN if exit_zero and status == ExitStatus.VIOLATION else status)
    if write_baseline is not None:
        baseline, known, left_out = format_baseline(everything, None if is_dash(write_baseline) else write_baseline)
        files.write(write_baseline, "--write-baseline", [baseline])
        if not quiet:
            before = frozenset[str]().union(*(policy.baseline for policy, _level in policies.values()))
            rules = {name: replace(policies[name][0], select=(), ignore=()) for name in kept}
            again = sum(apply_policy(made[name], rule).known for name, rule in rules.items())
            old = f", with {again} of the {len(before)} known before" if before else ""
            never = f", without {format_count(left_out, 'error')} that cannot be ignored" if left_out else ""
            say(f"{write_baseline}: written, {format_count(known, 'known finding')}{old}{never}\n")
    reports = drop_repeated(reports)
    write_report_files(files, report_files, reports, machine)
    if quiet and output_format == "text":
        reports = [_keep_gravest(one, warnings=one.program in own or one.fail_level == "warning") for one in reports]
        reports = [one for one in reports if one.shown]
    text = FORMATS[output_format](reports, machine)
    if output_format == "text" and not quiet and len(reports) > 1:
        text += count_words([one.verdict.word for one in reports]) + "\n"
    if output_format == "text" and output_file is None:
        say(text, err=False)
    else:
        _emit(files, output_file, text)
    if not quiet:
        say(name_passed_over(inputs, "checked", (name for one in everything for name in one.called)))
    return find_gravest(statuses)


def _check_one(
    files: RunFiles, name: str, machine: "Machine", given: dict[str, Any], *, quiet: bool, limits_only: bool
) -> "Report":
    """Check one program; what is wrong with its file or its set-up is a finding too."""
    from verne_post.app.convert import check_source
    from verne_post.app.result import refuse_fault, refuse_program
    from verne_post.cli.callers import name_caller
    from verne_post.model.findings import InputError
    from verne_post.output.findings import Report, describe_unchecked
    from verne_post.output.summary import list_remarks

    shown, begin = show_name(name), time.perf_counter()
    source: Text = b""
    files.tables.clear()
    with show_progress(f"reading {shown}", quiet=quiet) as progress:
        try:
            options = build_options(files, shown, name, **given)
            source, options = read_program_text(files, name, options, given["subroutine_path"])
            result = check_source(source, machine, options, progress, limits_only=limits_only)
        except InputError as error:  # the others are checked all the same
            result = refuse_program(error)
        except (click.UsageError, Unreadable) as error:
            result = refuse_program(InputError(*files.find_lines([report_unread(error)])))
        except (click.Abort, click.exceptions.Exit, FileError):
            raise  # the run is to end
        except Exception as error:  # the others go on
            result = refuse_fault(error, shown)
    seconds = result.summary.cycle_time if result.summary else None
    remarked = list_remarks(result.summary) if result.summary else describe_unchecked([result.unchecked])
    elapsed, run = time.perf_counter() - begin, find_given_run(given)
    found = files.find_lines(name_caller(result.findings, name))
    facts = (shown, found, seconds, source, tuple(remarked), result.unchecked)
    called, uncertain = result.called_files, result.uncertain_files
    return Report(*facts, elapsed_s=elapsed, run=run, called=called, uncertain=uncertain)


def _keep_gravest(report: "Report", *, warnings: bool) -> "Report":
    """A report that prints no notes and remarks, and warnings only if they are asked for. It counts them all."""
    kept = ("error", "warning") if warnings else ("error",)
    shown = tuple(one for one in report.findings if one.severity in kept)
    return replace(report, shown=shown, remarks=(), called=(), uncertain=(), excluded=0, ignored=0, known=0)


def _emit(files: RunFiles, output_file: Path | None, text: str) -> None:
    """Write the findings where they were asked for."""
    if output_file is None:
        print_as_is(text)
    else:
        files.write(output_file, "--output-file", [text])


def _count_errors(findings: "Sequence[Finding]") -> str:
    """``2 errors in mine.toml``: the files that stop every program."""
    count = format_count(sum(one.severity == "error" for one in findings), "error")
    files = ", ".join(dict.fromkeys(one.file for one in findings if one.file is not None))
    return f"{count} in {files}" if files else count


def make_policy(
    files: RunFiles,
    settings: "Settings | None",
    fail_level: "Severity | None",
    select: str | None,
    ignore: str | None,
    severity: tuple[str, ...],
    baseline: Path | None,
    written: Path | None = None,
) -> "tuple[Policy, Severity]":
    """Which findings count, and from which gravity: options and environment before the settings file.

    ``written`` is the baseline that the run writes; it may replace the one that is read, which need not be there then.
    """
    from verne_post.output.policy import Policy, find_mistakes, read_baseline

    file = settings.check if settings is not None else None
    codes = {
        name: tuple(code.strip() for code in text.split(",") if code.strip())
        if text is not None
        else tuple(getattr(file, name, ()))
        for name, text in (("select", select), ("ignore", ignore))
    }
    weights = dict(file.severity) if file is not None else {}
    for text in severity:
        code, _equals, level = text.partition("=")
        if level not in ("error", "warning", "note"):
            raise click.UsageError(f"--severity {text}: expected CODE=error, CODE=warning or CODE=note")
        weights[code] = level  # type: ignore[assignment]
    wrong = find_mistakes(codes["select"], codes["ignore"], weights)
    if wrong:
        raise click.UsageError("; ".join(wrong))
    place = "--baseline" if baseline is not None else "settings: check.baseline"
    known = baseline if baseline is not None else Path(file.baseline) if file is not None and file.baseline else None
    policy = Policy(codes["select"], codes["ignore"], weights)
    level = fail_level or (file.fail_level if file else None) or "error"
    if known is not None and written is not None and not is_dash(known):
        place = "--write-baseline" if files.is_same(known, written) else place
        if not files.has(known):
            files.note_read(known, place)
            return replace(policy, note=f"{show_name(known)}: not there; no finding is known yet"), level
    if known is not None:
        text = decode_text(files.read(known, place), "replace")
        fingerprints, folder, note = read_baseline(text, show_name(known), None if is_dash(known) else known)
        policy = replace(policy, baseline=fingerprints, folder=folder, note=note)
    return policy, level
