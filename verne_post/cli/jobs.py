"""Programs of a batch as jobs: what each writes, how a job is known again, and who runs it. Jobs and outcomes can be pickled."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

from verne_post.cli.common import program_text, write_whole
from verne_post.cli.conversion import Files, converted
from verne_post.model.findings import Finding, InputError, finding

if TYPE_CHECKING:
    from verne_post.base.long_text import Text
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options

#: Where records lie, in the output folder.
RECORDS = ".verne-post"
#: A record of another layout is not read.
_LAYOUT = 1


@dataclass(frozen=True)
class Job:
    """One program: its file, and where its rows go.

    ``record`` is the file that knows what was made of it last time.
    """

    program: str
    output: Path
    record: Path
    machine: "Machine"
    options: "Options"
    file_format: str
    subroutine_path: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """What became of a program; ``again`` where nothing had to be done."""

    program: str
    status: int
    findings: tuple[Finding, ...] = ()
    cycle_time_s: float | None = None
    rows: int | None = None
    again: bool = False


def run_job(job: Job) -> Outcome:
    """Convert one program, unless that has been done: whatever happens to it is an outcome."""
    try:
        return _outcome(job)
    except KeyboardInterrupt:
        raise
    except Exception as error:
        text = f"internal error: {type(error).__name__}: {error}"
        return Outcome(job.program, 70, (finding("VP902", text),))


def _outcome(job: Job) -> Outcome:
    import click

    try:
        source, options = program_text(job.program, replace(job.options, source_name=job.program), job.subroutine_path)
    except InputError as error:
        return Outcome(job.program, 2, error.findings)
    except click.UsageError as error:
        return Outcome(job.program, 2, (finding("VP022", error.message),))
    key = _key(job, source, options)
    old = _record(job.record)
    if (
        old is not None
        and old["key"] == key
        and all(_digest(Path(name)) == digest for name, digest in old["files"].items())
    ):
        return _known(job, old)
    for name in () if old is None else old["files"]:
        Path(name).unlink(missing_ok=True)  # rows of another program, or of other options, must not stay
    job.record.unlink(missing_ok=True)
    job.output.parent.mkdir(parents=True, exist_ok=True)
    files = Files(job.output, job.file_format, meta=_side_car(job.output))
    result, _said = converted(source, job.machine, options, files)
    summary = result.summary if result.ok else None
    done = Outcome(
        job.program, result.exit_code, result.findings,
        None if summary is None else summary.cycle_time, None if summary is None else summary.n_rows,
    )  # fmt: skip
    if done.status != 70:
        written = _written(job, options) if result.ok else []
        record = {"layout": _LAYOUT, "key": key, "files": {str(path): _digest(path) for path in written},
                  "outcome": {**asdict(done), "again": True}}  # fmt: skip
        job.record.parent.mkdir(parents=True, exist_ok=True)
        write_whole(job.record, [json.dumps(record, allow_nan=False) + "\n"])
    return done


def _key(job: Job, source: "Text", options: "Options") -> str:
    """The same for the same program, machine, options and version."""
    from verne_post import __version__
    from verne_post.base.long_text import sha256
    from verne_post.output.summary import options_record

    parts = {
        "version": __version__, "program": sha256(source), "machine": job.machine.sha256,
        "format": job.file_format, "options": options_record(options), "max_repeats": options.max_repeats,
        "cycle": options.cycle, "split": options.split_at_stops, "name": job.program,
    }  # fmt: skip
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _record(path: Path) -> dict[str, Any] | None:
    """What was made last time, None where nothing is known."""
    try:
        data = json.loads(path.read_text("utf-8"))
        return dict(data) if data["layout"] == _LAYOUT and isinstance(data["files"], dict) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _known(job: Job, record: dict[str, Any]) -> Outcome:
    told = record["outcome"]
    return Outcome(**{**told, "findings": tuple(Finding(**item) for item in told["findings"]), "program": job.program})


def _side_car(output: Path) -> Path:
    return output.with_name(f"{output.name}.meta.json")


def _written(job: Job, options: "Options") -> list[Path]:
    """The files that a conversion has written."""
    from verne_post.output.parts import index_path, parts_of

    if not options.split_at_stops:
        return [job.output, _side_car(job.output)]
    index = index_path(job.output)
    return [*parts_of(index), index, _side_car(job.output)]


def _digest(path: Path) -> str | None:
    """SHA-256 of a file, None where there is none."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None


# --- who runs them ---------------------------------------------------------------------------------


def run_here(jobs: Sequence[Job], workers: int) -> Iterator[Outcome]:
    """Outcomes as they come, from ``workers`` processes of this machine; from this process where one is enough."""
    if workers == 1 or len(jobs) < 2:
        for job in jobs:
            yield run_job(job)
        return
    alone: list[Job] = []
    with ProcessPoolExecutor(min(workers, len(jobs)), mp_context=get_context("spawn")) as pool:
        futures: dict[Future[Outcome], Job] = {pool.submit(run_job, job): job for job in jobs}
        try:
            for future in as_completed(futures):
                try:
                    yield future.result()
                except BrokenProcessPool:  # some process was killed: nobody knows which program did it
                    alone.append(futures[future])
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    for job in alone:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            try:
                yield pool.submit(run_job, job).result()
            except BrokenProcessPool:
                yield Outcome(
                    job.program, 70, (finding("VP902", "the process that converted this program was killed"),)
                )


def run_on_cluster(jobs: Sequence[Job], address: str) -> Iterator[Outcome]:
    """Outcomes as they come, from the workers of a Dask scheduler, which see the same folders."""
    from distributed import Client
    from distributed import as_completed as as_done

    with Client(address) as client:
        submitted = client.map(run_job, list(jobs), pure=False)
        futures = {future.key: job for future, job in zip(submitted, jobs, strict=True)}
        for future in as_done(submitted):
            try:
                yield future.result()
            except Exception as error:
                job = futures[future.key]
                yield Outcome(job.program, 70, (finding("VP902", f"the cluster did not finish this program: {error}"),))
