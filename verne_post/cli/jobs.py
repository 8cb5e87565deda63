"""Programs of a batch as jobs: what each writes, how a job is recognised, who runs it. Jobs can be pickled."""

import hashlib
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import cache
from multiprocessing import get_context, parent_process
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.printable import format_json
from verne_post.cli.common import read_program_text
from verne_post.cli.conversion import Outputs, convert_to_files
from verne_post.cli.files import FileError, RunFiles, Unreadable, report_unread
from verne_post.cli.temporary import make_temporary_folder, remove_all, tidy_up_when_ended
from verne_post.config.files import read_file
from verne_post.model.findings import Finding, InputError, make_finding
from verne_post.model.verdict import ExitStatus, find_exit_status

if TYPE_CHECKING:
    from verne_post.base.long_text import Text
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options

#: Where records lie, in the output folder.
RECORDS = ".verne-post"
#: Option -W of the process that removes semaphores: it would warn of those of a process that a signal has ended.
_SILENT: Final = "ignore:resource_tracker"
#: A record of another layout is not read.
_LAYOUT: Final = 3


class Job(Struct, frozen=True):
    """One program: its file, and where its rows go: to the file ``place`` of the output folder ``root``.

    ``wrong`` is what is wrong with its set-up; ``tables`` are the files of its set-up and settings.
    """

    program: str
    root: Path
    place: Path
    machine: "Machine"
    options: "Options"
    file_format: str
    subroutine_path: tuple[str, ...]
    wrong: tuple[Finding, ...] = ()
    tables: tuple[str, ...] = ()

    @property
    def output(self) -> Path:
        """The file of the rows."""
        return self.root / self.place

    @property
    def side_car(self) -> Path:
        """The file of ``--meta``."""
        return self.output.with_name(f"{self.output.name}.meta.json")

    @property
    def record(self) -> Path:
        """The file that knows what was made of the program last time."""
        return self.root / RECORDS / self.place.with_name(f"{self.place.name}.json")

    def claim(self, files: RunFiles) -> None:
        """Name everything that this job writes, as far as it is known before the work.

        Raises
        ------
        FileError
        """
        from verne_post.output.parts import index_path

        split = self.options.split_at_stops
        if split:
            files.claim_parts(self.output, self.describe_file(self.output))
        for path in (index_path(self.output) if split else self.output, self.side_car, self.record):
            self.claim_one(files, path)

    def claim_one(self, files: RunFiles, path: Path) -> None:
        """Name a file that this job writes; it lies in the output folder, and nowhere else by a link.

        Raises
        ------
        FileError
        """
        if not _has_no_links(self.root, path):
            raise FileError(f"{path}: a symbolic link inside {self.root} leads to it; batch follows none there")
        files.claim(path, self.describe_file(path))

    def describe_file(self, path: Path) -> str:
        """What a file of this job is for, in messages."""
        kind = {self.side_car: "metadata file", self.record: "record"}.get(path, "rows")
        return f"the {kind} of {self.program}"


class Outcome(Struct, frozen=True):
    """What became of a program; ``again`` where nothing had to be done.

    ``left`` are files that bear the names of its rows, and that are not known to be made by batch.
    """

    program: str
    status: int
    findings: tuple[Finding, ...] = ()
    cycle_time_s: float | None = None
    rows: int | None = None
    again: bool = False
    left: tuple[str, ...] = ()
    unchecked: str = ""  #: Bodies that were not checked for contact; "" also where it could not be read.
    called_files: tuple[str, ...] = ()  #: As of its result, and the next.
    uncertain_files: tuple[str, ...] = ()
    elapsed_s: float = 0.0  #: How long this run took for it; not recorded.


class Record(Struct, frozen=True):
    """What was made of a program: SHA-256 of each file by its name in the output folder.

    It is written before the files are put in place, and counts only while all of them are as it says. So whenever batch
    is killed, a file of rows either is what its record says or was never made by batch.
    """

    layout: Literal[3]
    key: str
    files: dict[str, str]
    outcome: Outcome


def run_job(job: Job) -> Outcome:
    """Convert one program, unless that has been done: whatever happens to it is an outcome."""
    begin, files = time.perf_counter(), RunFiles()
    done = _run(job)
    for name in (job.program, *job.tables):
        files.note_read(name, "--setup")
    # not in the record: a comment more in a set-up moves its lines, and no row
    return replace(done, findings=files.find_lines(done.findings), elapsed_s=time.perf_counter() - begin)


def _run(job: Job) -> Outcome:
    try:
        return _make_outcome(job)
    except KeyboardInterrupt:
        raise
    except FileError as error:
        return _make_failure(job, make_finding("VP022", str(error)))
    except OSError as error:  # a full disk, a folder that cannot be written
        return _make_failure(job, make_finding("VP022", f"{error.filename or job.output}: {error.strerror or error}"))
    except MemoryError:
        return _make_failure(job, make_finding("VP022", f"{job.program}: memory is used up"))
    except Exception as error:
        return _make_failure(job, make_finding("VP902", f"internal error: {type(error).__name__}: {error}"))


def forget(job: Job) -> None:
    """Remove what batch made for a program under a name that it does not have any more."""
    _remove_made(job, _record(job))


def find_left_over(jobs: Sequence[Job]) -> list[tuple[str, str]]:
    """Files that batch made of programs that are not there any more, each with its program.

    They stay: a program may only be out of reach of the folder in which batch runs.
    """
    found, root, places = [], jobs[0].root, {job.place for job in jobs}
    for path in sorted((root / RECORDS).rglob("*.json")):
        place = path.relative_to(root / RECORDS).with_suffix("")
        job = replace(jobs[0], place=place)
        record = None if place in places else _record(job)
        if record is not None and not Path(record.outcome.program).exists():
            made = [name for name, digest in record.files.items() if _is_made(job, name, digest)]
            found += [(str(root / name), record.outcome.program) for name in made]
    return found


def _remove_made(job: Job, record: Record | None) -> None:
    """Rows of another program, or of other options, must not stay."""
    if record is not None:
        for name, digest in record.files.items():
            if _is_made(job, name, digest):
                (job.root / name).unlink(missing_ok=True)  # another share of the programs may have removed it
    job.record.unlink(missing_ok=True)


def _make_failure(job: Job, *findings: Finding) -> Outcome:
    """The outcome of a program that could not be converted."""
    return Outcome(job.program, int(find_exit_status(findings)), findings)


def _make_outcome(job: Job) -> Outcome:
    import click

    files, record, key = RunFiles(), _record(job), None
    job.claim(files)
    try:
        if job.wrong:
            raise InputError(*job.wrong)
        options = job.options
        source, options = read_program_text(files, job.program, options, job.subroutine_path)
        key = _compute_key(job, source, options)
    except InputError as error:
        done = _make_failure(job, *error.findings)
    except (click.UsageError, Unreadable) as error:
        done = _make_failure(job, report_unread(error))
    if record is not None and record.key == key and all(_is_made(job, *file) for file in record.files.items()):
        return replace(
            record.outcome, program=job.program, again=True, left=_find_unknown_files(job, record, record.files)
        )
    _remove_made(job, record)
    if key is None:
        return replace(done, left=_find_unknown_files(job, record, ()))
    job.output.parent.mkdir(parents=True, exist_ok=True)
    with make_temporary_folder(job.output.parent) as folder:
        outputs = Outputs(folder / job.output.name, job.file_format, meta=folder / job.side_car.name)
        result, _said = convert_to_files(source, job.machine, options, outputs, files)
        summary = result.summary if result.ok else None
        done = Outcome(
            job.program,
            result.exit_code,
            result.findings,
            None if summary is None else summary.cycle_time,
            None if summary is None else summary.n_rows,
            unchecked=result.unchecked,
            called_files=result.called_files,
            uncertain_files=result.uncertain_files,
        )
        made = {(job.place.parent / path.name).as_posix(): path for path in sorted(folder.iterdir())}
        for name in made:
            job.claim_one(files, job.root / name)
        if done.status != ExitStatus.INTERNAL_ERROR:
            digests = {name: _compute_digest(path) for name, path in made.items()}
            made_now = msgspec.to_builtins(Record(_LAYOUT, key, digests, done), enc_hook=float)
            text = format_json(made_now)
            job.record.parent.mkdir(parents=True, exist_ok=True)
            files.write(job.record, job.describe_file(job.record), [text + "\n"])
            for name, path in made.items():
                files.place(path, job.root / name, job.describe_file(job.root / name))
    return replace(done, left=_find_unknown_files(job, record, made))


def find_called_files(job: Job) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The files that a program calls, and those that it may call, as its moves tell; nothing is converted."""
    from verne_post.app.assemble import read_draft

    if job.wrong:
        return (), ()
    try:
        source, options = read_program_text(RunFiles(), job.program, job.options, job.subroutine_path)
        return read_draft(source, job.machine, options).moves.called_lines.files, ()
    except InputError as error:
        return error.called_files, error.uncertain_files
    except Exception:  # whatever is wrong with it, the share that converts it says so
        return (), ()


def _compute_key(job: Job, source: "Text", options: "Options") -> str:
    """The same for the same program, machine, options and code of verne-post."""
    from verne_post.base.long_text import compute_sha256

    parts = {
        "code": _compute_code_digest(),
        "program": compute_sha256(source),
        "machine": job.machine.sha256,
        "format": job.file_format,
        "options": options.record(),
        "name": job.program,
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _record(job: Job) -> Record | None:
    """What was made last time; None where nothing is known, or the record is none that batch can have written."""
    from verne_post.output.parts import index_path, is_derived

    try:
        raw = read_file(job.record)
        record = msgspec.json.decode(raw, type=Record)
        paths = [job.root / name for name in record.files]
        names_are_own = all(path in (job.output, job.side_car) or is_derived(path, job.output) for path in paths)
    except (OSError, ValueError, RecursionError):
        return None
    whole = record.outcome.status != 0 or {job.output, index_path(job.output)} & set(paths)
    return record if names_are_own and whole else None


def _has_no_links(root: Path, path: Path) -> bool:
    """True for a path that lies below a folder as its name says: no link on the way from there leads elsewhere."""
    return Path(os.path.realpath(path)) == Path(os.path.realpath(root)) / path.relative_to(root)


def _is_made(job: Job, name: str, digest: str) -> bool:
    """True for a file that is as batch made it."""
    path = job.root / name
    try:
        return _has_no_links(job.root, path) and _compute_digest(path) == digest
    except OSError:
        return False


def _find_unknown_files(job: Job, record: Record | None, made: Collection[str]) -> tuple[str, ...]:
    """Files that bear names of this program's results, and are none."""
    from verne_post.output.parts import find_derived

    parts = find_derived(job.output) if job.options.split_at_stops else []
    own = [path for path in parts if not replace(job, place=path.relative_to(job.root)).record.exists()]
    paths = {job.output, job.side_car, *own, *(job.root / name for name in (record.files if record else ()))}
    return tuple(sorted(str(path) for path in paths - {job.root / name for name in made} if os.path.lexists(path)))


@cache
def _compute_code_digest() -> str:
    """The same while no file of verne-post changes; revisions of its repository may have one version."""
    top = Path(__file__).parents[1]
    files = sorted(one for one in top.rglob("*") if one.is_file() and one.parent.name != "__pycache__")
    digests = [(one.relative_to(top).as_posix(), _compute_digest(one)) for one in files]
    return hashlib.sha256(json.dumps(digests).encode()).hexdigest()


def _compute_digest(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


# --- who runs them ---------------------------------------------------------------------------------


def run_here(jobs: Sequence[Job], workers: int) -> Iterator[Outcome]:
    """Outcomes as they come, from ``workers`` processes of this machine; from this process where one is enough."""
    if workers == 1 or len(jobs) < 2:
        for job in jobs:
            yield run_job(job)
        return
    alone: list[Job] = []
    with _start_pool(min(workers, len(jobs))) as pool:
        with _hold_interruptions():
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
        with _start_pool(1) as pool:
            with _hold_interruptions():
                last = pool.submit(run_job, job)
            try:
                yield last.result()
            except BrokenProcessPool:
                yield _make_failure(job, make_finding("VP902", "the process that converted this program was killed"))


def _start_pool(workers: int) -> ProcessPoolExecutor:
    _start_tracker()
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin_worker)


def _start_tracker() -> None:
    """Start the process that removes semaphores behind this one: a terminal that hangs up must not end it too.

    Where this process is ended by a signal, that is what it is for, and nothing to warn of.
    """
    number = getattr(signal, "SIGHUP", None)
    if number is None:
        return
    from multiprocessing import resource_tracker

    before = signal.signal(number, signal.SIG_IGN)
    sys.warnoptions.append(_SILENT)
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions[:] = [one for one in sys.warnoptions if one != _SILENT]
        signal.signal(number, before)


@contextmanager
def _hold_interruptions() -> Iterator[None]:
    """Hold interruptions back, here and in processes started meanwhile, whose imports would show tracebacks."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin_worker() -> None:
    """In a worker: end with the process that started it, however that ends, and leave nothing behind."""
    tidy_up_when_ended("SIGINT")  # a terminal interrupts all processes; the parent says so
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    parent = parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        remove_all()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def run_on_cluster(jobs: Sequence[Job], address: str) -> Iterator[Outcome]:
    """Outcomes as they come, from the workers of a Dask scheduler, which see the same folders.

    Raises
    ------
    FileError
        Nobody answers at the address, or it is none.
    """
    from distributed import Client
    from distributed import as_completed as as_done

    try:
        connected = Client(address)
    except Exception as error:  # each protocol has errors of its own
        raise FileError(
            f"--scheduler {address}: {error}; expected the address of a Dask scheduler that runs, as tcp://host:8786"
        ) from None
    with connected as client:
        submitted = client.map(run_job, list(jobs), pure=False)
        futures = {future.key: job for future, job in zip(submitted, jobs, strict=True)}
        for future in as_done(submitted):
            try:
                yield future.result()
            except Exception as error:
                yield _make_failure(
                    futures[future.key], make_finding("VP902", f"the cluster did not finish this program: {error}")
                )
