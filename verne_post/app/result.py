"""The result of a check or a conversion."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, overload

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.extras import spell_install
from verne_post.base.numbers import format_count
from verne_post.base.suggestions import explain_names, find_meant
from verne_post.base.text_tables import format_html_table, format_table
from verne_post.config import load_machine
from verne_post.model.findings import (
    Finding,
    Findings,
    InputError,
    UsageError,
    make_findings_table,
    make_input_error,
    sort_by_line,
)
from verne_post.model.machine import Machine
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.summary import Summary
from verne_post.model.verdict import SEVERITIES, Verdict, find_exit_status, find_verdict
from verne_post.output.causes import Cause, find_causes, find_first_error
from verne_post.output.findings import describe_unchecked
from verne_post.output.fixed_point import format_rows

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl
    from matplotlib.figure import Figure

    from verne_post.part.verdict import Machined

Sink = Callable[[SetpointBlock], None]
#: Called with (stage, done, total).
Progress = Callable[[str, int, int], None]
#: Rows that a printed table of setpoints shows at each end.
_SHOWN_ROWS = 3
#: Findings of a result that is printed in a few lines.
_SHOWN_FINDINGS = 3
#: Limits of a joint on its derivatives, from the first on.
_RATES = ("velocity", "acceleration", "jerk")


@contextmanager
def name_missing(library: str, extra: str) -> Iterator[None]:
    """Say how to get the library of an extra that is not installed."""
    try:
        yield
    except ModuleNotFoundError:
        text = f"{library} is not installed; install it with: {spell_install(extra)}"
        raise ModuleNotFoundError(text, name=library) from None


@explain_names(q="values", time="t", rows="values, or row by row zip(setpoints.t, setpoints.values, setpoints.line)")
@dataclass(frozen=True, eq=False)
class Setpoints:
    """A whole setpoint file in memory; ``setpoints["a_deg"]`` is the column of that name.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    values : ndarray, shape (n, n_joints)
        The numbers as written: mm and degrees, or counts of the drives.
    line : ndarray of int32, shape (n,)
        Source line of each row.
    columns : tuple of str
        Names of all columns: time, joints, line.
    format : SetpointFormat
        Control cycle, and how every column is rounded.
    cuts : tuple of int
        Rows at which the program stops for the operator (``split_at_stops``): the last row of each part but the last.
    part : tuple of int
        Of what :meth:`split` returns: the number of the part, from 1, and how many there are.
    """

    t: Array
    values: Array
    line: NDArray[np.int32]
    columns: tuple[str, ...]
    format: SetpointFormat
    cuts: tuple[int, ...] = ()
    part: tuple[int, int] = (1, 1)

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, column: str) -> NDArray[Any]:
        """One column, by its name.

        Raises
        ------
        KeyError
            There is no such column: the names are those of ``columns``.
        """
        if not isinstance(column, str):
            raise TypeError(
                f"columns of setpoints are found by name, as [{self.columns[1]!r}]; t, values and line have the rows"
            )
        if column not in self.columns:
            begun = [name for name in self.columns if name.lower().startswith(f"{column.lower()}_")]
            meant = begun[0] if begun else find_meant(column, self.columns)
            near = f"did you mean {meant}? " if meant else ""
            raise KeyError(f"no column {column!r}; {near}the columns are {', '.join(self.columns)}")
        return self.to_dict()[column]

    def __iter__(self) -> Iterator[Any]:
        """Refuse (TypeError): neither rows nor columns are what a loop would mean for sure."""
        raise TypeError(
            "Setpoints are not iterable, they have rows and columns: "
            "zip(setpoints.t, setpoints.values, setpoints.line) goes through the rows, "
            "and convert(..., sink=...) takes blocks of rows as they are made"
        )

    @overload
    def to_csv(self) -> str: ...
    @overload
    def to_csv(self, path: str | os.PathLike[str]) -> None: ...
    def to_csv(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """The text of the setpoint file, as ``verne-post convert`` writes it.

        Parameters
        ----------
        path : str or path, optional
            A file to write, in place of the text.

        Raises
        ------
        UsageError
            The rows have parts: one file would run through the stops between them.
        """
        if self.cuts:
            raise UsageError(
                "to_csv",
                f"the program stops {format_count(len(self.cuts), 'time')} for the operator; a file would not wait; "
                "write each part of split()",
            )
        text = self.format_csv()
        if path is None:
            return text
        Path(path).write_text(text, encoding="utf-8", newline="\n")
        return None

    def format_csv(self) -> str:
        """All rows as the text of one file, also where the program stops for the operator: for :func:`verify` alone."""
        fmt = self.format
        rows = format_rows(list(self.to_dict().values()), [fmt.time_decimals, *fmt.decimals, 0], ",")
        return ",".join(self.columns) + "\n" + rows

    def split(self) -> "tuple[Setpoints, ...]":
        """The parts between stops for the operator, each from time 0, as ``--split-at-stops`` writes them."""
        if not self.cuts:
            return (self,)
        ends = (0, *(row + 1 for row in self.cuts), len(self))
        return tuple(
            replace(
                self,
                t=self.t[: end - begin],
                values=self.values[begin:end],
                line=self.line[begin:end],
                cuts=(),
                part=(number, len(ends) - 1),
            )
            for number, (begin, end) in enumerate(pairwise(ends), start=1)
        )

    def to_dict(self) -> dict[str, NDArray[Any]]:
        """Column by column, by name."""
        return dict(zip(self.columns, (self.t, *self.values.T, self.line), strict=True))

    def to_pandas(self) -> "pd.DataFrame":
        """As a pandas data frame; needs pandas."""
        with name_missing("pandas", "pandas"):
            import pandas as pd

        return pd.DataFrame(self.to_dict())

    def to_polars(self) -> "pl.DataFrame":
        """As a polars data frame; needs polars."""
        with name_missing("polars", "polars"):
            import polars as pl

        return pl.DataFrame({name: np.ascontiguousarray(column) for name, column in self.to_dict().items()})

    def plot(self, machine: Machine | str | os.PathLike[str] | None = None) -> "Figure":
        """Draw the joints against time with matplotlib (extra ``plot``).

        Parameters
        ----------
        machine : Machine, str or path, optional
            With it, the ends of the travels are dashed lines, and beside each joint stand its velocity, acceleration
            and jerk as shares of their limits, by differences of the rows, each in its own column: 1 is the limit.

        Raises
        ------
        InputError
            The machine file cannot be read.
        UsageError
            The rows are counts of drives, or have other joints than the machine.
        ModuleNotFoundError
            matplotlib is not installed.
        """
        with name_missing("matplotlib", "plot"):
            import matplotlib.pyplot as plt
        if machine is not None and not isinstance(machine, Machine):
            machine = load_machine(machine)
        joints = self.columns[1:-1]
        if machine is not None and self.format.drives:
            raise UsageError("machine", 'the rows are counts of drives; convert with units="joint" to see limits')
        if machine is not None and joints != tuple(one.header for one in machine.columns):
            headers = ", ".join(one.header for one in machine.columns)
            raise UsageError("machine", f"{machine.name} has the joints {headers}, the rows have {', '.join(joints)}")
        figure, axes = plt.subplots(
            len(joints),
            1 if machine is None else 1 + len(_RATES),
            sharex=True,
            squeeze=False,
            layout="constrained",
            figsize=(8 if machine is None else 16, 1.6 * len(joints)),
        )
        limits = None if machine is None else machine.scale_limits()
        for joint, name in enumerate(joints):
            place = axes[joint, 0]
            place.plot(self.t, self.values[:, joint])
            place.set_ylabel(name)
            if limits is None:
                continue
            for end in (limits.lower[joint], limits.upper[joint]):
                if np.isfinite(end):
                    place.axhline(end, color="red", linestyle="--")
            for order, kind in enumerate(_RATES, start=1):
                rate = np.abs(np.diff(self.values[:, joint], order)) / self.format.cycle**order
                beside = axes[joint, order]
                beside.plot(self.t[order:], rate / getattr(limits, kind)[joint], linewidth=0.8)
                beside.axhline(1, color="red", linestyle="--")
                beside.set_ylim(bottom=0)
        for place in axes[-1]:
            place.set_xlabel("time, s")
        if limits is not None:
            for place, kind in zip(axes[0, 1:], _RATES, strict=True):
                place.set_title(f"{kind}, share of its limit", loc="left")
        return figure

    def _make_text_rows(self) -> list[list[str]]:
        n = len(self)
        shown = range(n) if n <= 2 * _SHOWN_ROWS else [*range(_SHOWN_ROWS), -1, *range(n - _SHOWN_ROWS, n)]
        rows = [
            ["..."] * len(self.columns)
            if k < 0
            else [f"{self.t[k]:g}", *(f"{v:.6g}" for v in self.values[k]), str(self.line[k])]
            for k in shown
        ]
        return [list(self.columns), *rows]

    def __repr__(self) -> str:
        return f"{format_table(self._make_text_rows())}\n{self._describe_size()}"

    def _repr_html_(self) -> str:
        return f"{format_html_table(self._make_text_rows())}<p>{self._describe_size()}</p>"

    def _describe_size(self) -> str:
        number, count = self.part
        place = f", part {number} of {count}" if count > 1 else ""
        return f"{len(self)} rows" + (f" in {len(self.cuts) + 1} parts" if self.cuts else place)


@explain_names(
    **dict.fromkeys(("time", "duration", "seconds", "cycle_time", "machining_time"), "summary.cycle_time"),
    rows="setpoints",
)
@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """The result of a check or a conversion.

    Attributes
    ----------
    findings : tuple of Finding
    summary : Summary or None
        Facts of the conversion; None where the program was refused.
    setpoints : Setpoints or None
        None when the result is not ok, for a check, and when a sink or files took the rows; the printed result says
        which. Test ``ok`` before you use them.
    part : Machined or None
        The comparison with the nominal part of the options.
    program, machine : str
        Their names; empty where the one was text, or the other not loaded.
    unchecked : str
        The bodies that were not checked for contact, of a program that is refused too; empty where all were, and where
        the program could not be read.
    called_files : tuple of str
        The files of subprograms that it executes, as seen from its folder; of a refused one, those that it calls before
        an error on which the order of its lines depends.
    uncertain_files : tuple of str
        Those that a refused program calls after such an error: corrected, it may not call them.
    """

    findings: tuple[Finding, ...]
    summary: Summary | None = None
    setpoints: Setpoints | None = field(default=None)
    part: "Machined | None" = field(default=None)
    program: str = ""
    machine: str = ""
    unchecked: str = ""
    called_files: tuple[str, ...] = ()
    uncertain_files: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "findings", sort_by_line(self.findings))

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings that are errors: the program cannot run."""
        return Findings(item for item in self.findings if item.severity == "error")

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """The findings that are warnings."""
        return Findings(item for item in self.findings if item.severity == "warning")

    @property
    def causes(self) -> tuple[Cause, ...]:
        """The findings by what one correction settles, as the commands print them: ``first``, ``others``."""
        return tuple(find_causes(self.findings))

    @property
    def exit_code(self) -> int:
        """The exit status that the command line returns for it."""
        return int(find_exit_status(self.findings))

    @property
    def ok(self) -> bool:
        """Whether the program can run: no finding is an error."""
        return self.exit_code == 0

    def __bool__(self) -> bool:
        return self.ok

    @property
    def verdict(self) -> Verdict:
        """What became of the program, in words."""
        return find_verdict(self.exit_code, self.findings)

    def _make_text_rows(self) -> list[list[str]]:
        """Facts, of which the first finding is one where the program is refused: pytest shows 118 characters."""
        first = find_first_error(self.findings)
        where = "" if first is None or first.line is None else f" in line {first.line}"
        why = "" if first is None else f": {first.code}{where}: {first.placed_message}"
        rows = [["verdict", f"{self.verdict.word}{why}"]]
        rows += [[key, name] for key, name in (("program", self.program), ("machine", self.machine)) if name]
        rows += [["NOT CHECKED", self.unchecked]] if self.unchecked else []
        if self.summary is not None:
            rows += [
                ["machining time", f"{self.summary.cycle_time:.3f} s"],
                ["rows", str(self.summary.n_rows)],
                ["corners blended", str(self.summary.n_blended)],
                ["stops", str(self.summary.n_stops)],
            ]
        if self.setpoints is None:
            rows.append(["setpoints", f"none: {self._say_why_none()}"])
        return rows

    def _say_why_none(self) -> str:
        """Why there are no setpoints."""
        if not self.ok:
            return "the program is refused, see the findings"
        if self.summary is None or self.summary.verification is None:
            return "a check makes none, convert does"
        return "a sink or files took the rows"

    def __str__(self) -> str:
        """Verdict, time and the first causes, with what helps; ``repr`` has all facts and findings as tables."""
        where = [f"on {self.machine}"] if self.machine else []
        seconds = f", {self.summary.cycle_time:.3f} s" if self.summary is not None else ""
        lines = [" ".join([f"{self.program}:"] * bool(self.program) + [self.verdict, *where]) + seconds]
        lines += describe_unchecked([self.unchecked])
        worst = sorted(self.causes, key=lambda cause: SEVERITIES.index(cause.first.severity))
        lines += map(str, worst[:_SHOWN_FINDINGS])
        if len(worst) > _SHOWN_FINDINGS:
            lines.append(f"and {format_count(len(worst) - _SHOWN_FINDINGS, 'more cause')}, in result.causes")
        return "\n".join(lines)

    def __repr__(self) -> str:
        parts = [format_table(self._make_text_rows())]
        if self.findings:
            parts.append(format_table(make_findings_table(self.findings)))
        return "\n".join(parts)

    def _repr_html_(self) -> str:
        return format_html_table([["result", "value"], *self._make_text_rows()]) + (
            format_html_table(make_findings_table(self.findings)) if self.findings else ""
        )


def refuse_program(error: InputError) -> Result:
    """The result of a program that was refused."""
    return Result(error.findings, called_files=error.called_files, uncertain_files=error.uncertain_files)


#: What helps against an internal error.
_REPORT_FAULT: Final = (
    "Report it with the program INPUT; VERNE_POST_TRACEBACK=1 verne-post check INPUT shows where it happened."
)


def refuse_fault(error: Exception, program: str) -> Result:
    """The result of a program that has no verdict, because of an error of verne-post itself or for want of memory.

    With ``VERNE_POST_TRACEBACK`` the error is raised again.
    """
    if isinstance(error, MemoryError):
        return refuse_program(make_input_error("VP022", f"{program}: memory is used up"))
    if os.environ.get("VERNE_POST_TRACEBACK"):
        raise error
    text = f"internal error: {type(error).__name__}: {error}"
    return refuse_program(make_input_error("VP902", text, advice=_REPORT_FAULT))
