"""What became of many programs, as a table: of `batch` on the command line and in Python."""

from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import Final, Protocol

from verne_post.base.numbers import format_count
from verne_post.base.printable import make_printable
from verne_post.model.findings import Finding
from verne_post.model.verdict import Verdict, find_verdict
from verne_post.output.causes import count_causes, find_first_error, list_first
from verne_post.output.findings import find_place


class Converted(Protocol):
    """What became of one program; ``again`` where nothing had to be done."""

    @property
    def program(self) -> str | PurePath: ...
    @property
    def status(self) -> int: ...
    @property
    def findings(self) -> tuple[Finding, ...]: ...
    @property
    def cycle_time_s(self) -> float | None: ...
    @property
    def rows(self) -> int | None: ...
    @property
    def again(self) -> bool: ...


#: What was not made again can run as well.
_AGAIN: Final = f"{Verdict.CAN_RUN} (as before)"
_NONE: Final[Mapping[str, str]] = {}
#: The order in which results are counted.
_ORDER: Final = tuple(dict.fromkeys((Verdict.CAN_RUN.word, _AGAIN, *(verdict.word for verdict in Verdict))))


def format_batch(outcomes: Sequence[Converted], *, is_brief: bool = False, machines: Mapping[str, str] = _NONE) -> str:
    """A line a program, and how many of each; ``is_brief`` where the findings stand above the table.

    ``machines`` are the names of the machines by program: the last line has the one of all, else each line its own.
    """
    rows = make_batch_rows(outcomes, is_brief=is_brief)
    names = list(dict.fromkeys(machines[str(one.program)] for one in outcomes if str(one.program) in machines))
    if len(names) > 1:
        for row, one in zip(rows[1:], outcomes, strict=True):
            row[1] += f" on {make_printable(machines[str(one.program)])}"
    on = f", on {make_printable(names[0])}" if len(names) == 1 else ""
    width, room = (max(len(row[k]) for row in rows) for k in (0, 1))
    lines = [
        f"{name:<{width}}  {word:<{room}} {time:>10} {count:>10}  {reason}".rstrip()
        for name, word, time, count, reason in rows
    ]
    return "\n".join([*lines, count_results(outcomes) + on]) + "\n"


def make_batch_rows(outcomes: Sequence[Converted], *, is_brief: bool = False) -> list[list[str]]:
    """Programs as rows of text, the first one the header; ``is_brief`` counts the findings and names the first."""
    rows = [["program", "result", "time s", "rows", "findings" if is_brief else "first finding"]]
    for one in outcomes:
        time = "-" if one.cycle_time_s is None else f"{one.cycle_time_s:.3f}"
        count = "-" if one.rows is None else str(one.rows)
        first = _find_first(one.findings)
        reason = "" if first is None else f"{first.code}{_name_place(str(one.program), first)}"
        errors, warnings = count_causes(one.findings)
        more = (errors or warnings) - 1
        if first is not None and is_brief:
            counts = ((errors, "error"), (warnings, "warning"))
            reason = f"{', '.join(format_count(n, word) for n, word in counts if n)}: {reason}"
            reason += f" +{more}" if more else ""
        elif first is not None:
            reason += f"{f' +{more}' if more else ''}: {make_printable(first.full_message)}"
        rows.append([make_printable(str(one.program)), _name_result(one), time, count, reason])
    return rows


def _name_place(program: str, item: Finding) -> str:
    name, line = find_place(program, item)
    if line is None:
        return ""
    return f" line {line}" if name == program else f" {make_printable(name)}:{line}"


def count_results(outcomes: Sequence[Converted]) -> str:
    """How many programs had each result."""
    return count_words(list(map(_name_result, outcomes)))


def count_words(words: Sequence[str]) -> str:
    """How many programs have each word of a result."""
    counted = ", ".join(f"{words.count(word)} {word}" for word in _ORDER if word in words)
    return f"{format_count(len(words), 'program')}: {counted}"


def _name_result(one: Converted) -> str:
    return _AGAIN if one.again and one.status == 0 else find_verdict(one.status, one.findings).word


def _find_first(findings: Sequence[Finding]) -> Finding | None:
    """The first error; of a program without one the first warning, in a line if one has a line."""
    warnings = [item for item in list_first(findings) if item.severity == "warning"]
    return find_first_error(findings) or next((item for item in warnings if item.line), next(iter(warnings), None))
