"""The Python API: what the commands do, for programs that import verne_post.

A program is given as bytes, as text, or as a path; a path brings the subprograms and the set-up beside it, as on the
command line. In :func:`convert`, :func:`check`, :func:`explain` and :func:`batch` bad input becomes findings of the
result, as on the command line; a call without a meaning raises UsageError.
"""

import dataclasses
import html
import importlib
import io
import math
import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeGuard, get_args

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post import config
from verne_post.app.assemble import Program, assemble, read_draft, view_moves_plainly
from verne_post.app.called_files import drop_called
from verne_post.app.convert import check_source, convert_source
from verne_post.app.explain import Explanation, explain_refused, explain_source
from verne_post.app.fit import propose
from verne_post.app.machined import Body, judge_rows
from verne_post.app.program_folders import choose_names, describe_lack, find_programs_inside
from verne_post.app.python_names import translate_messages
from verne_post.app.result import Progress, Result, Setpoints, Sink, name_missing, refuse_fault, refuse_program
from verne_post.app.verify import find_lines, judge_part, read_all_parts, read_rows, verify_index, verify_setpoints
from verne_post.base.long_text import LongText, Text
from verne_post.base.printable import escape_unprinted
from verne_post.base.suggestions import explain_names
from verne_post.base.text_marks import strip_mark
from verne_post.base.text_tables import format_html_table
from verne_post.config import setup_values
from verne_post.config.settings import Settings
from verne_post.config.setup_values import Setup, lay_over_setup, take_settings
from verne_post.config.subprograms import collect_subprograms
from verne_post.model.findings import Finding, InputError, UsageError, make_input_error
from verne_post.model.machine import Machine
from verne_post.model.option_checks import check_ranges, convert_from_numpy, find_system
from verne_post.model.options import Options
from verne_post.model.part_setup import UNITS, Wanted
from verne_post.model.setpoints import SetpointBlock
from verne_post.model.verdict import ExitStatus, find_exit_status
from verne_post.model.verification import Verification
from verne_post.output.batch_table import count_results, format_batch, make_batch_rows
from verne_post.output.commands import find_run
from verne_post.output.dump import list_records
from verne_post.output.findings import (
    Report,
    choose_remedy,
    describe_remedy,
    format_finding,
    format_outcome,
    list_unchecked,
)
from verne_post.output.fit import make_text as fit_text
from verne_post.output.machined import describe_comparisons
from verne_post.output.parts import find_derived, find_index, is_derived, name_part, open_parts
from verne_post.output.summary import format_verdict
from verne_post.part.stl import read_stl
from verne_post.part.verdict import Datum, Machined
from verne_post.toolpath.work_offset import Aim, Proposal

#: A program: its bytes, its text, or where its file is.
Source = bytes | str | os.PathLike[str]
#: Rows: what convert returned, a setpoint file, or all parts of a program.
SetpointsLike = Setpoints | Source | Sequence[Setpoints | Source]
#: A text of one word that no language reads, and that ends as names of files do.
_FILE_NAME = re.compile(r"\s*[^\s;()]+\.[A-Za-z]+\s*")
#: A machine, its name, or where its file is.
MachineLike = Machine | str | os.PathLike[str]
#: Settings, or where their file is.
SettingsLike = Settings | os.PathLike[str] | None

load_machine = translate_messages(config.load_machine)
read_settings = translate_messages(setup_values.read_settings)


@translate_messages
def convert(
    source: Source,
    machine: MachineLike | None = None,
    options: Options | None = None,
    sink: Sink | None = None,
    progress: Progress | None = None,
    *,
    setup: Setup = "beside",
    settings: SettingsLike = None,
) -> Result:
    """Convert a program to verified setpoints.

    Parameters
    ----------
    source : bytes, str or path
        G-code. A ``str`` is the text of a program, never the name of a file.
    machine : Machine, str or path, optional
        Without one that of ``settings``, and else that of :func:`load_machine` and of the commands.
    options : Options, optional
        Options that are not the default override the set-up.
    sink : callable, optional
        Takes blocks of rows (:class:`~verne_post.model.setpoints.SetpointBlock`) as they are made; discard them unless
        the result is ok. Without a sink the rows are collected in ``Result.setpoints``.
    progress : callable, optional
        Called with (stage, done, total).
    setup : {"beside", "none"} or path
        The set-up of the program: ``part.nc.toml`` beside a path ``part.nc``, where there is one, as the commands read
        it; none; or another file.
    settings : Settings or path, optional
        What :func:`read_settings` returns, or the file. Its options hold below the set-up, and its machine where no
        ``machine`` is given. No file is looked for.

    Returns
    -------
    Result
        ``ok``, ``exit_code``, ``findings``, ``summary``, ``setpoints``. Bad programs do not raise, and an internal
        error is a finding (VP902); with ``VERNE_POST_TRACEBACK=1`` in the environment it is raised.

    Raises
    ------
    UsageError
        An argument has the wrong type, or a file cannot be read. What ``sink`` and ``progress`` raise is raised.
    InputError
        The machine file cannot be used.

    Examples
    --------
    >>> import verne_post as vp

    >>> options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)})
    >>> result = vp.convert("G21 G90 F600\\nG0 X0 Y0 Z20\\nG1 X10\\nM2\\n", "verne", options)
    >>> result.ok, len(result.setpoints) > 1000
    (True, True)
    """
    raised: list[Exception] = []
    sink, progress = _watch(sink, "sink", raised), _watch(progress, "progress", raised)

    def run(text: Text, loaded: Machine, chosen: Options) -> Result:
        return convert_source(text, loaded, chosen, sink, progress)

    return _judge(run, (source, options, setup, settings), machine, raised)


@translate_messages
def check(
    source: Source,
    machine: MachineLike | None = None,
    options: Options | None = None,
    progress: Progress | None = None,
    *,
    setup: Setup = "beside",
    settings: SettingsLike = None,
    limits_only: bool = False,
) -> Result:
    """Check a program against every limit, without making setpoints; arguments and result as of :func:`convert`.

    With ``limits_only`` the limits of joints and the obstacles are checked, and nothing is planned. The result has no
    summary and no machining time, but a note VP421. It takes 40 % of the CPU time of a conversion.

    Examples
    --------
    >>> import verne_post as vp
    >>> options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 0)})
    >>> result = vp.check("G21 G90\\nG0 X0 Y0 Z20 A0 C0\\nZ700\\nM2\\n", "verne", options)
    >>> result.ok, result.findings[0].code
    (False, 'VP101')
    """
    raised: list[Exception] = []
    progress = _watch(progress, "progress", raised)

    def run(text: Text, loaded: Machine, chosen: Options) -> Result:
        return check_source(text, loaded, chosen, progress, limits_only=limits_only)

    return _judge(run, (source, options, setup, settings), machine, raised)


def _judge(
    run: Callable[[Text, Machine, Options], Result],
    program: tuple[Source, Options | None, Setup, SettingsLike],
    machine: MachineLike | None,
    raised: Sequence[Exception],
) -> Result:
    """What becomes of a program: whatever is wrong with it, or with verne-post, is a finding.

    ``raised`` are the errors of functions of the caller, which are raised again.
    """
    source, options, *_others = program
    try:
        text, chosen, read = _read_program(*program)
    except UsageError:
        raise
    except Exception as error:
        return _name_result(_refuse(error, source), source, options)
    loaded = _load_machine(machine, read)
    try:
        result = run(text, loaded, chosen)
    except UsageError:
        raise
    except Exception as error:
        if any(error is one for one in raised):
            raise
        result = _refuse(error, source)
    return _name_result(result, source, options, loaded)


def _refuse(error: Exception, source: Source) -> Result:
    """The result of a program that cannot be used, or in which verne-post failed."""
    if isinstance(error, InputError):
        return refuse_program(error)
    return refuse_fault(error, str(source) if isinstance(source, os.PathLike) else "the program")


@translate_messages
def explain(
    source: Source,
    machine: MachineLike | None = None,
    line: int | None = None,
    options: Options | None = None,
    *,
    setup: Setup = "beside",
    settings: SettingsLike = None,
) -> Explanation:
    """Explain one source line: words, findings with remedies, pose; ``working`` has every step and every solution.

    Of a program that cannot be read, what the words of the line do and the findings of the line; of a set-up that
    cannot be read, its findings.

    Raises
    ------
    InputError
        The machine file cannot be used.
    UsageError
        The program has no such line.
    """
    line = convert_from_numpy(line)
    if isinstance(line, bool) or not isinstance(line, int) or line < 0:
        raise UsageError("line", f"{line!r}: expected the number of a source line, from 1, or 0 for the approach")
    try:
        text, chosen, read = _read_program(source, options, setup, settings)
    except InputError as error:
        return _list_findings(line, error, str(source) if isinstance(source, os.PathLike) else "program")
    loaded = _load_machine(machine, read)
    try:
        told = explain_source(text, loaded, chosen, line)
    except InputError as error:
        if not line:
            return _list_findings(line, error, chosen.source_name)
        told = explain_refused(text, loaded, chosen, line, error.findings)
    shown = told.text
    for item in told.findings:  # the words of Python are for remedies that name no program yet
        if remedy := describe_remedy(item, chosen.source_name, find_run(chosen)):
            shown = shown.replace(remedy, choose_remedy(item))
    return dataclasses.replace(told, text=shown)


def _list_findings(line: int, error: InputError, name: str) -> Explanation:
    """What there is to say of a line where no line can be looked at."""
    text = "".join(f"{format_finding(name, item)}\n" for item in error.findings)
    return Explanation(line, error.findings, text, "")


@translate_messages
def verify(
    setpoints: SetpointsLike,
    source: Source,
    machine: MachineLike | None = None,
    options: Options | None = None,
    *,
    setup: Setup = "beside",
    settings: SettingsLike = None,
) -> Verification:
    """Verify setpoints as written (CSV) against the program that they were made from.

    Parameters
    ----------
    setpoints : Setpoints, bytes, str or path, or a list of them
        What :func:`convert` returned, or the content or file of setpoints, as CSV, linuxcnc, twincat, npz or parquet.
        Of a program with parts, a list of all, or the index that the command writes. Of one part alone not all is
        checked: ``unchecked`` says what.
    source, machine, options, setup, settings
        Those of the conversion.

    Raises
    ------
    InputError
        The file or the program cannot be read.
    """
    name, read_blocks = _open_setpoints(setpoints)
    text, chosen, read = _read_program(source, options, setup, settings)
    loaded = _load_machine(machine, read)
    are_parts, (number, count) = isinstance(setpoints, list | tuple), _find_place(setpoints)
    if are_parts or count > 1 or _is_index(setpoints):
        chosen = chosen.changed(split_at_stops=True)
    program = assemble(text, loaded, chosen)
    if _is_index(setpoints):
        verdict = verify_index(program, Path(setpoints))
    else:
        verdict = verify_setpoints(program, read_blocks(program), split=are_parts)
    verdict = judge_part(name, verdict, number, count)
    lines = [format_finding(chosen.source_name, item) for item in verdict.findings]
    if verdict.unchecked:
        lines.append(f"{verdict.unchecked} Verify all parts together: give the index, as axes.index.json.")
    else:
        passes = find_exit_status(verdict.findings) == ExitStatus.CLEAN
        lines.append(format_verdict(name, verdict, loaded, passes=passes))
    verdict.text = "\n".join(lines)
    return verdict


@translate_messages
def machined(
    setpoints: SetpointsLike,
    source: Source,
    machine: MachineLike | None = None,
    options: Options | None = None,
    *,
    nominal: bytes | os.PathLike[str],
    system: str = "G54",
    unit: str = "mm",
    gouge: float = Wanted().gouge,
    excess: float = Wanted().excess,
    grid: float | None = None,
    search: float = Wanted().search,
    datum: Datum = "table",
    fixtures: Sequence[tuple[bytes | os.PathLike[str], str]] = (),
    distance: float = 0.0,
    setup: Setup = "beside",
    settings: SettingsLike = None,
) -> Machined:
    """Compare setpoints as written (CSV) with the nominal part and fixtures: gouges, excess, contacts, certainty.

    Parameters
    ----------
    setpoints : Setpoints, bytes, str or path, or a list of them
        As for :func:`verify`.
    source, machine, options, setup, settings
        Those of the conversion; ``tool_shapes`` has the cutters.
    nominal : bytes or path
        An STL file.
    system : str
        The work system that it is in, or "table".
    unit : {"mm", "cm", "m", "inch"}
        Unit of the STL.
    gouge, excess : float
        mm along the normal: deeper cuts are errors (VP218), more material is a warning (VP219).
    grid : float or None
        mm; largest distance of a point of the surface from an examined one. None: 0.2, or for a large part the finest
        that has not too many places.
    search : float
        mm; depth below and height above the surface that are examined.
    datum : {"table", "fit"}
        Which comparison counts: the part at its position in the set-up, or at the best fit.
    fixtures : sequence of (bytes or path, str)
        STL files that tool and spindle keep out of (VP215), each with its system.
    distance : float
        mm; the smallest distance allowed.

    Raises
    ------
    InputError
        A file or the program cannot be read, or a tool has no shape.
    UsageError
    """
    sizes = {"gouge": gouge, "excess": excess, "grid": grid, "search": search}
    given = {name: convert_from_numpy(value) for name, value in sizes.items() if value is not None}
    distance = convert_from_numpy(distance)
    fixtures = tuple(fixtures) if isinstance(fixtures, Iterable) and not isinstance(fixtures, str) else fixtures
    for name, value in {**given, "distance": distance}.items():
        least = 0 if name == "distance" else sys.float_info.min
        if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value < math.inf:
            raise UsageError(name, f"{value!r}: expected mm{', 0 or more' if name == 'distance' else ' above 0'}")
    if not isinstance(fixtures, list | tuple) or any(
        not isinstance(one, list | tuple) or len(one) != 2 for one in fixtures
    ):
        raise UsageError("fixtures", f"{fixtures!r}: expected (file, system) of each, as [(Path('vise.stl'), 'G54')]")
    systems = [_find_system(one) for one in (system, *(place for _file, place in fixtures))]
    for key, word, allowed in (("unit", unit, UNITS), ("datum", datum, get_args(Datum))):
        if word not in allowed:
            raise UsageError(key, f"{word!r}: expected one of {', '.join(allowed)}")
    text, chosen, read = _read_program(source, options, setup, settings)
    program = assemble(text, _load_machine(machine, read), chosen)
    shown_rows, read_blocks = _open_setpoints(setpoints)
    rows = list(find_lines(program, read_blocks(program)))
    if not rows:
        raise make_input_error("VP020", "the setpoint file has no rows")
    factor = np.array([column.factor for column in program.machine.columns])
    q, line = np.concatenate([one.values for one in rows]) / factor, np.concatenate([one.line for one in rows])
    bodies: list[Body] = []
    meshes = ((nominal, "the nominal part"), *((file, "a fixture") for file, _place in fixtures))
    for (file, name), place in zip(meshes, systems, strict=True):
        raw = _read_mesh(file, "fixtures" if bodies else "nominal")
        shown = str(file) if isinstance(file, os.PathLike) else name
        bodies.append(Body(read_stl(raw, shown, unit), place))
    found = judge_rows(program, q, line, bodies[0], bodies[1:], Wanted(**given), datum, distance)
    lines = [format_finding(chosen.source_name, item) for item in found.findings]
    return replace(found, text="\n".join([*lines, describe_comparisons(shown_rows, found).rstrip()]))


def _find_system(place: object) -> int | None:
    """The number of the work system of a mesh; None: the table."""
    try:
        return None if place == "table" else find_system(place)
    except ValueError as error:
        raise UsageError("system", f"{error}, or 'table'") from None


@translate_messages
def fit(
    source: Source,
    machine: MachineLike | None = None,
    options: Options | None = None,
    free: str | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    *,
    aim: Aim = "move",
    setup: Setup = "beside",
    settings: SettingsLike = None,
) -> Proposal:
    """Find a work offset that brings the whole program within limits.

    Parameters
    ----------
    source, machine, options, setup, settings
        As for :func:`convert`; ``wcs`` says where the part is now.
    free : str, optional
        Letters of what may change: x, y, z (mm) and c (the part's rotation, where a joint of the machine turns it).
        Without it all of them may.
    ranges : mapping, optional
        (low, high) by letter, mm and degrees.
    aim : {"move", "margin", "time"}
        The smallest move of the part that brings the program within limits, none where it is; the largest margin; or
        least time.

    Raises
    ------
    InputError
    """
    text, chosen, read = _read_program(source, options, setup, settings)
    allowed = check_ranges(free, {} if ranges is None else ranges)
    if aim not in get_args(Aim):
        raise UsageError("aim", f"{aim!r}: expected one of {', '.join(get_args(Aim))}")
    loaded = _load_machine(machine, read)
    found = propose(text, loaded, chosen, free, allowed, aim=aim)
    return replace(found, text=fit_text(chosen.source_name, loaded, found).rstrip("\n"))


@explain_names(
    **{name: f"result.{name}" for name in ("summary", "setpoints", "verdict", "errors", "warnings", "causes")}
)
class BatchRow(Struct, frozen=True):
    """What became of one program of a batch.

    Attributes
    ----------
    program : Path
    result : Result
        Without its rows, where they were written.
    files : tuple of Path
        What was written; one for each part between stops.
    called : tuple of str
        Files of the folder that this program calls, and that have no row of their own.
    """

    program: Path
    result: Result
    files: tuple[Path, ...] = ()
    called: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether it can run."""
        return self.result.ok

    def __bool__(self) -> bool:
        return self.ok

    @property
    def status(self) -> int:
        """The exit status that the command line would return for it."""
        return self.result.exit_code

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Those of the result."""
        return self.result.findings

    @property
    def cycle_time_s(self) -> float | None:
        """Machining time, s; None where it cannot run."""
        return self.result.summary.cycle_time if self.result.summary is not None else None

    @property
    def rows(self) -> int | None:
        """How many rows it has; None where it cannot run."""
        return self.result.summary.n_rows if self.result.summary is not None else None

    @property
    def again(self) -> bool:
        """Whether rows of an earlier run were kept; never, since :func:`batch` converts every program."""
        return False


@explain_names()
class Batch(Struct, frozen=True):
    """What became of many programs: ``len(batch)`` of them, ``batch[0]`` is the first one.

    Attributes
    ----------
    programs : tuple of BatchRow
        ``program``, ``result``, ``files`` and ``called`` of each, in the given order; those of a folder by name.
    """

    programs: tuple[BatchRow, ...]

    @property
    def ok(self) -> bool:
        """Whether all of them can run."""
        return all(one.ok for one in self.programs)

    def __bool__(self) -> bool:
        return self.ok

    def __len__(self) -> int:
        return len(self.programs)

    def __getitem__(self, index: int) -> BatchRow:
        return self.programs[index]

    def __iter__(self) -> Iterator[BatchRow]:
        return iter(self.programs)

    def _list_unchecked(self) -> list[str]:
        return list_unchecked([_report_row(one, one.called) for one in self.programs])

    def __repr__(self) -> str:
        return "\n".join([format_batch(self.programs).rstrip("\n"), *self._list_unchecked()])

    def _repr_html_(self) -> str:
        said = [count_results(self.programs), *self._list_unchecked()]
        return format_html_table(make_batch_rows(self.programs)) + "".join(f"<p>{html.escape(one)}</p>" for one in said)


@translate_messages
def batch(
    programs: Iterable[os.PathLike[str]] | os.PathLike[str],
    machine: MachineLike | None = None,
    options: Options | None = None,
    folder: os.PathLike[str] | None = None,
    progress: Progress | None = None,
    *,
    setup: Setup = "beside",
    settings: SettingsLike = None,
) -> Batch:
    """Convert many programs one after another, each with its own set-up; the failure of one does not stop the others.

    The command ``batch`` does the same with several processes, and skips programs that have not changed.

    Parameters
    ----------
    programs : path or iterable of path
        Files, and folders that are searched, as ``Path("programs")``. A subprogram of a folder that is refused alone,
        and that another program executes, has no row: it is in ``called`` of that one.
    machine, options, setup, settings
        As for :func:`convert`, for all of them.
    folder : path, optional
        Where rows are written, ``part.csv`` of ``part.nc``, in the structure of a folder that is searched; without it
        each result keeps its own.
    progress : callable, optional
        Called with ("programs", done, total).

    Raises
    ------
    InputError
        The machine file or the settings cannot be used.
    UsageError
        Two programs would be written to one file, or a file is there already, be it a part or the index of parts: rows
        of another run must not be taken for those of this one. There is no program, or none in a folder.
    """
    _check_callable(progress, "progress")
    if isinstance(programs, os.PathLike) and Path(programs).exists():
        programs = [programs]
    if isinstance(programs, str | bytes | os.PathLike):
        name = os.fsdecode(programs)
        lack = "" if os.path.exists(name) else f"{escape_unprinted(name)}: no such file or folder; "
        raise UsageError("programs", f"{lack}expected a path or several, as Path({name!r})")
    if not isinstance(programs, Iterable):
        raise UsageError("programs", f"expected a path or several, got {type(programs).__name__}")
    if folder is not None and (not isinstance(folder, str | os.PathLike) or Path(folder).is_file()):
        raise UsageError("folder", f"{folder!r}: expected a pathlib.Path of a folder")
    found, named = _find_programs(programs, None if folder is None else Path(folder))
    read = take_settings(settings)
    loaded = _load_machine(machine, read)
    paths = [Path(name) for name, _place in found]
    targets = [None if folder is None else Path(folder, name) for name in choose_names(found, ".csv")]
    _refuse_files(targets)
    for path, shared, output in _list_shared_names(paths, targets):
        if _has_parts(path, options, setup, read):
            raise UsageError("folder", f"{shared}: a part of {output} may have this name; give each its own folder")
    rows = []
    for path, target in zip(paths, targets, strict=True):
        try:
            result = convert(path, loaded, options, setup=setup, settings=read)
        except UsageError as error:
            if error.option != "source":
                raise
            result = _name_result(refuse_program(make_input_error("VP022", error.reason)), path, options, loaded)
        rows.append(_write_rows(path, result, target))
        if progress is not None:
            progress("programs", len(rows), len(paths))
    reports = {str(one.program): _report_row(one, one.result.called_files) for one in rows}
    kept = drop_called(reports, named, lambda _name: read)
    left = (one for one in rows if str(one.program) in kept)
    return Batch(tuple(replace(one, called=kept[str(one.program)].called) for one in left))


def _find_programs(programs: Iterable[object], folder: Path | None) -> tuple[list[tuple[str, Path]], set[str]]:
    """Every program, and its place in the structure of its folder; and those that are named, each by itself."""
    found: list[tuple[str, Path]] = []
    named: set[str] = set()
    searched: set[str] = set()
    wrong: list[str] = []
    for one in programs:
        path = Path(_require_path(one))
        if not path.is_dir():
            found += [] if str(path) in searched else [(str(path), Path(path.name))]
            named.add(str(path))
            continue
        inside = find_programs_inside(path, folder, wrong)
        if not inside:
            wrong.append(f"no programs in {path}; {describe_lack(path, folder)}")
        found += (each for each in inside if each[0] not in named and each[0] not in searched)
        searched |= {name for name, _place in inside}
    if not (found or wrong):
        wrong.append("there is none; the list is empty, or a pattern fits no file")
    if wrong:
        raise UsageError("programs", "; ".join(wrong))
    return found, named


def _report_row(row: BatchRow, called: tuple[str, ...]) -> Report:
    """The facts of a row as reports have them."""
    return Report(str(row.program), row.findings, unchecked=row.result.unchecked, called=called)


def _require_path(given: object) -> str:
    if not isinstance(given, os.PathLike):
        as_path = f": pass pathlib.Path({given!r})" if isinstance(given, str) else ""
        raise UsageError("programs", f"expected paths, got {type(given).__name__}{as_path}")
    return os.fspath(given)


def _refuse_files(targets: Sequence[Path | None]) -> None:
    known: set[Path] = set()
    for target in targets:
        if target is None:
            continue
        if target in known or target.exists():
            why = "two programs have this name" if target in known else "is there already; give an empty folder"
            raise UsageError("folder", f"{target}: {why}")
        if old := find_derived(target):
            raise UsageError("folder", f"{old[0]}: may be a part of {target} of another run; give an empty folder")
        known.add(target)


def _list_shared_names(programs: Sequence[Path], targets: Sequence[Path | None]) -> Iterator[tuple[Path, Path, Path]]:
    """Each program whose parts may have the name of other rows: the program, these rows, and its own."""
    places = {target: program for program, target in zip(programs, targets, strict=True) if target is not None}
    for target in places:
        output = target.with_name(f"{Path(target.stem).stem}{target.suffix}")
        if output in places and is_derived(target, output):
            yield places[output], target, output


def _has_parts(program: Path, options: Options | None, setup: Setup, settings: SettingsLike) -> bool:
    """Whether a program is cut at its stops; one that cannot be used is not."""
    try:
        return _read_program(program, options, setup, settings)[1].split_at_stops
    except (InputError, UsageError):
        return False


def _write_rows(program: Path, result: Result, target: Path | None) -> BatchRow:
    """A program of a batch with its rows in files, one for each part between stops."""
    if target is None or result.setpoints is None:
        return BatchRow(program, result)
    parts = result.setpoints.split()
    files = [target] if len(parts) == 1 else [name_part(target, number) for number in range(1, len(parts) + 1)]
    target.parent.mkdir(parents=True, exist_ok=True)
    for file, part in zip(files, parts, strict=True):
        part.to_csv(file)
    return BatchRow(program, dataclasses.replace(result, setpoints=None), tuple(files))


@explain_names(moves="records", to_pandas="records", ends="records")
class ProgramMoves(Struct, frozen=True):
    """The moves and events of a program in order of execution, as the command ``dump moves`` prints them.

    Its length and its items are those of ``records``; ``pandas.DataFrame(moves.records)`` is a table of them.

    Attributes
    ----------
    records : tuple of dict
        Each has ``line`` and ``kind``. The kinds of motion are "rapid", "feed", "arc", "spline", "turn" (the axes of
        the machine go linearly) and "swing" (the tool turns about its standing tip). They have ``end``: X Y Z A B C U
        V W, mm and degrees, in program coordinates of the active work system and plane. ``feed`` is in mm/min, deg/min
        for turns alone, mm a turn where ``feed_mode`` is "per_rev", and None for rapids. ``axis`` is the tool vector,
        where one is programmed. Arcs have ``plane``, ``center``, ``turns`` and ``sweep`` (deg); splines ``degree``,
        ``points``, ``weights`` and ``knots``. A "dwell" has ``seconds``. All other kinds are events, such as "tool" and
        "spindle", with their words.
    findings : tuple of Finding
        Warnings of the program as text; there are no errors.
    """

    records: tuple[dict[str, Any], ...]
    findings: tuple[Finding, ...]

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.records)

    def __getitem__(self, number: int) -> dict[str, Any]:
        return self.records[number]

    def __repr__(self) -> str:
        kinds = Counter(str(one["kind"]) for one in self.records)
        counts = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        return f"{len(self)} moves and events: {counts}; {len(self.findings)} findings"


@translate_messages
def read_moves(
    source: Source,
    machine: MachineLike | None = None,
    options: Options | None = None,
    *,
    setup: Setup = "beside",
    settings: SettingsLike = None,
) -> ProgramMoves:
    """Read the moves of a program: end points, feed rates and events, without solving the machine.

    Parameters
    ----------
    source, options, setup, settings
        As for :func:`convert`.
    machine : Machine, str or path, optional
        Reads the program as ``check`` does: A and C are those of the table, G53 and G28 lead to places of the machine.
        Without one no machine is known, not that of the settings either: every axis begins at 0, and home is 0.

    Raises
    ------
    InputError
        The program or the set-up cannot be used: every error that was found.

    Examples
    --------
    >>> import verne_post as vp
    >>> moves = vp.read_moves("G21 G90 F600\\nG0 X0 Y0 Z20\\nG1 X10\\nM2\\n")
    >>> [(one["line"], one["kind"], one["end"][:3], one["feed"]) for one in moves if "end" in one]
    [(2, 'rapid', [0.0, 0.0, 20.0], None), (3, 'feed', [10.0, 0.0, 20.0], 600.0)]
    """
    text, chosen, _read = _read_program(source, options, setup, settings)
    if machine is not None:
        moves = read_draft(text, _load_machine(machine, None), chosen).moves
    else:
        moves, errors = view_moves_plainly(text, chosen)
        if errors:
            raise InputError(*errors)
    return ProgramMoves(tuple(list_records(moves)), moves.findings)


@explain_names(**dict.fromkeys(("save", "to_html", "to_file"), "write"))
class Page(Struct, frozen=True):
    """A report as a separate page.

    Attributes
    ----------
    html : str
    findings : tuple of Finding
        Of the program; of two programs of both.
    """

    html: str
    findings: tuple[Finding, ...]
    text: str = ""

    @property
    def ok(self) -> bool:
        """Whether the program can run; of two programs both."""
        return find_exit_status(self.findings) == ExitStatus.CLEAN

    def __bool__(self) -> bool:
        return self.ok

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write it to a file."""
        Path(path).write_text(self.html, encoding="utf-8", newline="\n")

    def __repr__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{html.escape(self.html)}" width="100%" height="720"></iframe>'


@translate_messages
def make_report(
    source: Source,
    machine: MachineLike | None = None,
    options: Options | None = None,
    *,
    versus: Source | None = None,
    setup: Setup = "beside",
    settings: SettingsLike = None,
) -> Page:
    """Make one page that shows a program: findings, path, axes, limits, times; as the command ``report`` does.

    Parameters
    ----------
    source, machine, options, setup, settings
        As for :func:`convert`.
    versus : bytes, str or path, optional
        Another program, or a version of this one: the page says what differs.

    Returns
    -------
    Page
        Also of a program that is refused. ``write(path)`` writes it; notebooks show it.

    Raises
    ------
    InputError
        The set-up, the settings or the machine file cannot be used.
    ModuleNotFoundError
        The extra ``report`` is not installed.
    """
    from verne_post.report.comparison import make_side, write_comparison
    from verne_post.report.page import make_page
    from verne_post.report.study import study

    with name_missing("jupyter_threejs_sage", "report"):
        importlib.import_module("jupyter_threejs_sage")
    read = take_settings(settings)
    loaded = _load_machine(machine, read)
    seen = []
    for what, one in (("source", source), *([] if versus is None else [("versus", versus)])):
        text, chosen, _settings = _read_program(one, options, setup, read, what)
        seen.append((chosen.source_name, text, loaded, study(text, loaded, chosen)))
    page = make_page(*seen[0]) if versus is None else write_comparison((make_side(*seen[0]), make_side(*seen[1])))
    outcomes = "; ".join(format_outcome(name, each.findings, 0, loaded) for name, _text, _machine, each in seen)
    return Page(page, tuple(item for *_program, each in seen for item in each.findings), outcomes)


# --- arguments -----------------------------------------------------------------------------------------


def _read_program(
    source: Source, options: Options | None, setup: Setup, settings: SettingsLike, what: str = "source"
) -> tuple[Text, Options, Settings | None]:
    """The text of a program, its options and its settings; a path brings its subprograms and its set-up."""
    if options is not None and not isinstance(options, Options):
        raise UsageError("options", f"expected Options, got {type(options).__name__}")
    chosen = options or Options()
    other = {one.offset[2] for one in (chosen.tools or {}).values()} - {0.0, chosen.tool_length}
    if chosen.tool_length is not None and other:
        lengths = ", ".join(f"{length:g}" for length in sorted(other))
        why = f"{chosen.tool_length:g} mm for all tools, but tools gives {lengths} mm; give one of the two"
        raise UsageError("tool_length", why)
    text = _read(source, what)
    path = Path(source) if isinstance(source, os.PathLike) else None
    read = take_settings(settings)
    chosen = lay_over_setup(chosen, path, setup, read)
    if path is None:
        return text, chosen, read
    found, files = collect_subprograms(text, path.resolve().parent, (), lambda file, _name: file.read_bytes())
    files = {name: file for name, file in files.items() if name not in chosen.subroutines}
    called = {**found, **chosen.subroutines}
    named = {**files, **chosen.subroutine_files}
    return text, chosen.changed(subroutines=called, subroutine_files=named, source_name=str(path)), read


def _name_result(result: Result, source: Source, options: Options | None, machine: Machine | None = None) -> Result:
    """A result with the names of its program and machine; a text has a name where the options give it one."""
    given = Options() if options is None else options
    own = "" if given.source_name == Options().source_name else given.source_name
    program = os.fspath(source) if isinstance(source, os.PathLike) else own
    return dataclasses.replace(result, program=program, machine="" if machine is None else machine.name)


def _read(source: object, what: str) -> Text:
    """Bytes of a text, or of a file."""
    if isinstance(source, os.PathLike):
        try:
            return strip_mark(Path(source).read_bytes())
        except OSError as error:
            raise UsageError(what, f"{source}: {error.strerror or error}") from None
        except ValueError:
            raise UsageError(what, f"{str(source)!r}: a file name has no zero byte") from None
    if isinstance(source, str):
        if "\n" not in source and source.strip() and (os.path.exists(source) or _FILE_NAME.fullmatch(source)):
            raise UsageError(what, f"{source!r} is taken as text; pass pathlib.Path({source!r}) to read the file")
        try:
            return strip_mark(source.encode())
        except UnicodeEncodeError as error:
            raise UsageError(what, f"character {error.start + 1} is half of a surrogate pair, not text") from None
    if isinstance(source, bytes):
        return strip_mark(source)
    if isinstance(source, LongText):
        return source
    kinds = "Setpoints, a list of them, bytes" if what == "setpoints" else "bytes"
    inside = "; pass its read()" if hasattr(source, "read") else ""
    inside = "; pass its setpoints" if what == "setpoints" and isinstance(source, Result) else inside
    raise UsageError(what, f"expected {kinds}, text or a path, got {type(source).__name__}{inside}")


def _read_mesh(file: object, what: str) -> bytes:
    """An STL, or what a file of one holds."""
    if isinstance(file, bytes):
        return file
    if isinstance(file, os.PathLike):
        try:
            return Path(file).read_bytes()
        except OSError as error:
            raise UsageError(what, f"{file}: {error.strerror or error}") from None
    if isinstance(file, str):
        raise UsageError(what, f"{file!r} is a text; pass pathlib.Path({file!r}) to read the file")
    raise UsageError(what, f"expected bytes or a path, got {type(file).__name__}")


def _read_setpoints(setpoints: SetpointsLike) -> bytes:
    """The bytes of a setpoint file."""
    if setpoints is None:
        raise UsageError("setpoints", "None: a result has setpoints where convert made them and result.ok is true")
    written = setpoints.format_csv() if isinstance(setpoints, Setpoints) else setpoints
    return _read(written, "setpoints")[:]


def _is_index(setpoints: SetpointsLike) -> TypeGuard[os.PathLike[str]]:
    return isinstance(setpoints, os.PathLike) and os.fspath(setpoints).endswith(".index.json")


def _find_place(setpoints: SetpointsLike) -> tuple[int, int]:
    """The number of a part, and how many there are; (1, 1) of rows that are no part of several."""
    if isinstance(setpoints, Setpoints):
        return setpoints.part
    found = find_index(Path(setpoints)) if isinstance(setpoints, os.PathLike) else None
    return (1, 1) if found is None else found[1:]


def _open_setpoints(setpoints: SetpointsLike) -> tuple[str, Callable[[Program], Iterator[SetpointBlock]]]:
    """What setpoints are called, and what reads their rows: those of one file, or of all parts of a program."""
    name = str(setpoints) if isinstance(setpoints, os.PathLike) else "setpoints"
    if _is_index(setpoints):
        _read(setpoints, "setpoints")  # a file that is not there is a wrong call
        return name, lambda program: read_all_parts(program, name, open_parts(Path(setpoints)))
    if isinstance(setpoints, list | tuple):
        files = [
            (str(one) if isinstance(one, os.PathLike) else f"part {number}", _read_setpoints(one))
            for number, one in enumerate(setpoints, start=1)
        ]
        parts = [(part, partial(io.BytesIO, raw)) for part, raw in files]
        return name, lambda program: read_all_parts(program, name, parts)
    raw = _read_setpoints(setpoints)
    return name, lambda program: read_rows(program, name, io.BytesIO(raw))


def _load_machine(machine: MachineLike | None, read: Settings | None) -> Machine:
    """The machine that is given, or else that of the settings."""
    if isinstance(machine, Machine):
        return machine
    if machine is not None:
        return config.load_machine(machine)
    return config.load_machine() if read is None else config.load_machine(read.machine)


def _check_callable(given: object, what: str) -> None:
    if given is not None and not callable(given):
        raise UsageError(what, f"expected a function, got {type(given).__name__}")


def _watch(given: Callable[..., None] | None, what: str, raised: list[Exception]) -> Callable[..., None] | None:
    """A function of the caller, whose errors are kept: they are no errors of verne-post."""
    _check_callable(given, what)
    if given is None:
        return None

    def call(*arguments: Any) -> None:
        try:
            given(*arguments)
        except Exception as error:
            raised.append(error)
            raise

    return call
