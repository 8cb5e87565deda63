"""`verne-post batch`: many programs, each by itself."""

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from msgspec.structs import replace

from verne_post.app.program_folders import choose_names, name_rows
from verne_post.base.numbers import is_count
from verne_post.base.printable import format_json, make_printable
from verne_post.cli.common import expect_options, load_machines, print_findings, quiet_option, refuse
from verne_post.cli.conversion import check_format, format_option
from verne_post.cli.files import RunFiles, Unreadable, is_dash
from verne_post.cli.numbers import Whole
from verne_post.cli.options import (
    FOLDER,
    INPUT,
    WRITING,
    GroupedCommand,
    add_options,
    add_program_options,
    build_options,
    find_given_run,
    find_settings,
)
from verne_post.cli.pictures import require_package
from verne_post.cli.programs import add_exclude_option, drop_excluded, find_programs, name_passed_over
from verne_post.cli.progress import show_progress
from verne_post.cli.report_files import add_report_files, report_failure, take_report_files, write_report_files
from verne_post.cli.streams import echo, print_as_is
from verne_post.model.verdict import find_gravest
from verne_post.output.batch_table import format_batch
from verne_post.output.causes import count_causes
from verne_post.output.formats import FORMATS

if TYPE_CHECKING:
    from verne_post.cli.jobs import Job, Outcome
    from verne_post.config.settings import Settings
    from verne_post.model.findings import Finding
    from verne_post.model.machine import Machine
    from verne_post.output.findings import Report


@click.command("batch", cls=GroupedCommand, short_help="Convert many programs, each with its own set-up.")
@click.argument("inputs", type=INPUT, nargs=-1, required=True, metavar="DIR|FILE...")
@click.option(
    "-o",
    "--output",
    required=True,
    type=FOLDER,
    metavar="OUTDIR",
    help="Folder for the setpoint files, in the structure of the input.",
)
@click.option("-j", "--jobs", type=Whole(min=1), metavar="N", help="Number of processes; default: one for each core.")
@click.option(
    "--scheduler",
    default="local",
    show_default=True,
    metavar="local|ADDRESS",
    help="Address of a Dask scheduler whose workers see the same folders, as tcp://host:8786.",
)
@click.option("--shard", metavar="I/N", help="Convert only the I-th of N equal shares, for CI matrices.")
@add_report_files
@add_exclude_option
@click.option("--github", is_flag=True, help="Print the findings as annotations of a GitHub workflow too.")
@quiet_option
@format_option
@add_options(*WRITING)
@add_program_options("jobs")
def command(
    inputs: tuple[str, ...],
    output: Path,
    jobs: int | None,
    scheduler: str,
    shard: str | None,
    exclude: tuple[str, ...],
    github: bool,
    quiet: bool,
    file_format: str,
    **given: Any,
) -> int:
    """Convert many programs, each with its own set-up.

    An argument may be a file, a folder of programs, or a pattern with * and ?. A program that fails does not stop the
    others. Options apply to all programs, and override the set-up beside each program (part.nc.toml). A second run
    skips unchanged programs, so it resumes an interrupted batch. OUTDIR/batch.json lists all results.

    \b
    Example:
    verne-post batch programs -o setpoints
    """
    from verne_post.model.findings import InputError

    files = RunFiles()

    def find_own_settings(name: str) -> "Settings | None":
        return find_settings(files, given.get("settings"), name)

    if github or not quiet:
        files.claim_output("--github" if github else "the table of results (none with --quiet)")
    if any(map(is_dash, inputs)):
        raise click.UsageError("batch takes files and folders; convert and check read standard input (-)")
    report_files, printed = take_report_files(files, given), "github" if github else "text"
    files.claim_folder(output, "-o")
    if scheduler != "local" and jobs is not None:
        raise click.UsageError("-j is for processes of this machine; a cluster has its own workers")
    share = _share(shard)
    paths = given["subroutine_path"]
    try:
        programs, named = find_programs(
            inputs,
            lambda name: files.note_read(name, f"program {name}"),
            output,
            may_lack=output.exists(),  # old rows of what is gone must go
        )
        programs, excluded = drop_excluded(programs, named, inputs, exclude, find_own_settings)
        names = [name for name, _place in programs] or [""]
        expect_options(files, names, given)
        machines = load_machines(files, names, given)
        machine = machines[names[0]]
        check_format(file_format)
        every = _make_jobs(files, programs, output, machines, file_format, given)
    except InputError as error:
        report_failure(files, report_files, error, printed, print_as_is)
        return refuse(inputs[0], error)
    except (click.UsageError, Unreadable) as error:
        report_failure(files, report_files, error, printed, print_as_is)
        raise
    from verne_post.app.called_files import drop_called, find_callers, has_call_to_any
    from verne_post.cli.jobs import find_called_files, find_left_over, run_here, run_on_cluster
    from verne_post.output.findings import Report, describe_called, drop_repeated, list_unchecked

    left_over = find_left_over(every)
    _claim(files, every, output, paths)
    callers: dict[str, str] = {}
    elsewhere: list[Job] = []
    if share != slice(None):
        # a subprogram is refused alone: it is in the share of the program that calls it
        callers = find_callers([job.program for job in every])
        alone = [job for job in every if job.program not in callers]
        own = {job.program for job in alone[share]}
        elsewhere = [job for job in alone if job.program not in own]
        every = [job for job in every if callers.get(job.program, job.program) in own]
    output.mkdir(parents=True, exist_ok=True)
    running = (
        run_here(every, jobs or _count_cores()) if scheduler == "local" else run_on_cluster(every, _address(scheduler))
    )
    outcomes = sorted(_collect(running, len(every), quiet=quiet or github), key=lambda outcome: outcome.program)
    made = {
        one.program: Report(
            one.program,
            one.findings,
            one.cycle_time_s,
            _read_text(files, one.program) if report_files or github else b"",
            unchecked=one.unchecked,
            elapsed_s=one.elapsed_s,
            machine=None if machines[one.program] is machine else machines[one.program],
            run=find_given_run(given),
            called=one.called_files,
            uncertain=one.uncertain_files,
        )
        for one in outcomes
    }

    def drop(reports: Mapping[str, Report]) -> dict[str, Report]:
        return drop_called(reports, named, find_own_settings)

    kept, away = drop(made), list[Report]()
    if any(one.status and one.program in kept and one.program in callers for one in outcomes):
        # the first program whose text calls it does not come to the call: one of another share may
        told = {
            job.program: Report(job.program, (), called=called, uncertain=uncertain)
            for job in elsewhere
            if has_call_to_any(job.program, callers)
            for called, uncertain in (find_called_files(job),)
        }
        kept = drop(made | told)
        away = [kept.pop(name) for name in told]
    if kept:
        kept |= {name: replace(one, excluded=excluded) for name, one in list(kept.items())[:1]}
    reports, outcomes = list(kept.values()), [one for one in outcomes if one.program in kept]
    for report in drop_repeated(reports):
        if report.findings:
            source = report.source or _read_text(files, report.program)
            print_findings(make_printable(report.program), report.findings, source, quiet=quiet)
    for one in outcomes:
        for name in one.left:
            echo(
                make_printable(
                    f"{name}: not removed: batch did not make this file, or it was changed since; it is not of "
                    f"{one.program} as it is now"
                ),
                err=True,
            )
    for name, program in left_over:
        echo(
            make_printable(f"{name}: left over from an earlier run: {program} is not there any more; remove this file"),
            err=True,
        )
    write_report_files(files, report_files, reports, machine)
    if github:
        from verne_post.output.reports import FORMATS as REPORTS

        print_as_is(REPORTS["github"](reports, machine))
    if not quiet:
        echo("".join(f"{line}\n" for line in [*list_unchecked(reports), *describe_called(away)]), nl=False, err=True)
        called = [name for one in outcomes for name in one.called_files]
        echo(name_passed_over(inputs, "converted", called, output), nl=False, err=True)
        echo(
            format_batch(outcomes, is_brief=True, machines={name: one.name for name, one in machines.items()}), nl=False
        )
    files.write(output / "batch.json", _LIST, [_write_results_json(outcomes, reports)])
    return find_gravest([outcome.status for outcome in outcomes])


#: What batch.json is for.
_LIST = "the list of results"


def _claim(files: RunFiles, jobs: "list[Job]", output: Path, paths: tuple[str, ...]) -> None:
    """Name everything that the jobs read and write, before any work: what one writes may be what another one reads."""
    from verne_post.config.subprograms import list_callable_files
    from verne_post.model.findings import UsageError

    for job in jobs:
        files.note_read(job.program, f"program {job.program}")
    for folder in sorted({Path(job.program).resolve().parent for job in jobs}):
        with suppress(UsageError, OSError):  # the jobs of this folder say what is wrong with --subroutine-path
            for path in list_callable_files(folder, paths):
                files.note_read(path, f"subprogram {path.stem}")
    for job in jobs:
        job.claim(files)
    files.claim(output / "batch.json", _LIST)


def _count_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _share(text: str | None) -> slice:
    """The programs of ``--shard``, counted in their order."""
    if text is None:
        return slice(None)
    number, _slash, of = text.partition("/")
    if not (is_count(number) and is_count(of) and 1 <= int(number) <= int(of)):
        raise click.UsageError(f"--shard {text}: expected I/N with I from 1 to N")
    return slice(int(number) - 1, None, int(of))


def _make_jobs(
    files: RunFiles,
    programs: Sequence[tuple[str, Path]],
    output: Path,
    machines: "dict[str, Machine]",
    file_format: str,
    given: dict[str, Any],
) -> "list[Job]":
    """A job for every program, in the order of their names, with the options of its own set-up."""
    from verne_post.cli.jobs import Job, forget
    from verne_post.model.findings import InputError
    from verne_post.model.options import Options

    suffix = FORMATS[file_format].suffix
    found: dict[Path, str] = {}
    for (program, _place), target in zip(programs, choose_names(programs, suffix), strict=True):
        other = found.setdefault(target, program)
        if other != program:
            raise click.UsageError(
                f"{program} and {other} would both be written to {output / target}; convert them into two folders"
            )
    # a program whose neighbour of the same name has come or gone had its rows under its other name
    for name in sorted({name for _program, place in programs for name in name_rows(place, suffix)} - set(found)):
        forget(Job("", output, name, next(iter(machines.values())), Options(), file_format, ()))
    jobs = []
    for target, program in sorted(found.items(), key=lambda item: item[1]):
        wrong: tuple[Finding, ...] = ()
        files.tables.clear()
        try:
            options = build_options(files, program, program, **given)
        except InputError as error:  # in its set-up: the others are converted all the same
            options, wrong = Options(source_name=program), error.findings
        paths, tables = given["subroutine_path"], tuple(files.tables)
        jobs.append(Job(program, output, target, machines[program], options, file_format, paths, wrong, tables))
    return jobs


def _address(scheduler: str) -> str:
    require_package("distributed", "--scheduler", "dask")
    return scheduler


def _collect(outcomes: Any, total: int, *, quiet: bool) -> "list[Outcome]":
    """All outcomes; on a terminal with the time that is left."""
    found = []
    with show_progress("programs", quiet=quiet) as progress:
        for outcome in outcomes:
            found.append(outcome)
            if progress is not None:
                progress("programs", len(found), total)
    return found


def _read_text(files: RunFiles, program: str) -> bytes:
    try:
        return files.read(program, f"program {program}")
    except Unreadable:
        return b""


def _write_results_json(outcomes: "Sequence[Outcome]", reports: "Sequence[Report]") -> str:
    """The results for programs; the same whoever made them, and whether they were made again."""
    counts = [count_causes(one.findings) for one in outcomes]
    programs = [
        {
            "program": one.program,
            "status": one.status,
            "cycle_time_s": one.cycle_time_s,
            "rows": one.rows,
            "errors": errors,
            "warnings": warnings,
            "unchecked": one.unchecked,
            "called": report.called,
        }
        for one, report, (errors, warnings) in zip(outcomes, reports, counts, strict=True)
    ]
    return format_json({"schema": 1, "programs": programs}, 2) + "\n"
