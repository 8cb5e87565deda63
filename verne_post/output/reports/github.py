"""Findings as annotations of GitHub's workflow commands: they stand beside the line in a pull request."""

from collections import Counter
from collections.abc import Sequence
from typing import Final

from verne_post.base.numbers import format_count
from verne_post.base.printable import make_lines_printable
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding, name_lines
from verne_post.model.machine import Machine
from verne_post.model.verdict import Verdict
from verne_post.output.causes import Cause, find_causes
from verne_post.output.findings import Report, drop_repeated, find_place, format_outcome, list_remedies, list_unchecked
from verne_post.output.policy import find_path_in_repository

#: Annotations of each level that GitHub shows for one step.
MAX_ANNOTATIONS: Final = 10
_LEVELS: Final = {"error": "error", "warning": "warning", "note": "notice"}


def write(reports: Sequence[Report], _machine: Machine | None = None) -> str:
    """One workflow command a cause, the gravest first; notices say what was not checked, and how many are not shown."""
    told_once = drop_repeated(reports, also_errors=True)
    everything = [(report, cause) for report in told_once for cause in find_causes(report.findings)]
    lines, unchecked = [], list_unchecked(reports)
    shown = Counter(note=len(unchecked[:1]))
    for severity in _LEVELS:
        for report, cause in everything:
            if cause.first.severity == severity and shown[severity] < MAX_ANNOTATIONS:
                shown[severity] += 1
                lines.append(_write_annotation(report, cause))
    left_out = len(everything) - len(lines)
    if unchecked:  # one annotation, as the room for them is small
        lines.append(f"::notice title=verne-post::{_escape_data(chr(10).join(unchecked))}")
    for report in reports:  # no error says why the step fails
        if report.verdict == Verdict.WARNINGS_FAIL:
            outcome = format_outcome(report.program, report.findings, fail_level=report.fail_level)
            lines.append(f"::error title=verne-post::{_escape_data(outcome)}")
    if left_out:
        lines.append(
            f"::notice title=verne-post::{format_count(left_out, 'further finding')}; "
            f"GitHub shows {MAX_ANNOTATIONS} of each level"
        )
    return "".join(line + "\n" for line in lines)


def write_failure(_verdict: Verdict, message: str, findings: Sequence[Finding]) -> str:
    """Annotations of the files that are wrong; else one of the step."""
    if findings and all(item.file is not None for item in findings):
        causes = find_causes(findings)[:MAX_ANNOTATIONS]
        return "".join(_write_annotation(Report("", ()), cause) + "\n" for cause in causes)
    return f"::error title=verne-post::{_escape_data(message)}\n"


def _write_annotation(report: Report, cause: Cause) -> str:
    item, others = cause.first, cause.describe_others()
    file, line = find_place(report.program, item)
    where = [] if file == "<stdin>" else [f"file={_escape_property(find_path_in_repository(file))}"]
    if line and where:
        where.append(f"line={line}")
        if item.last_line is not None and item.last_line > line and not item.lines:
            where.append(f"endLine={item.last_line}")
        column = item.column if item.file is None else item.file_column
        if column is not None:
            where.append(f"col={column}")
    title = CODES[item.code].title
    where.append(f"title={_escape_property(f'{item.code} {title}')}")
    also = [f"also {others}"] if others else []
    remedies = [text.removeprefix(f"{title}: ") for text in list_remedies(item, report.program, report.run)]
    # an annotation stands beside the last line of its stretch
    spread = bool(item.line and item.last_line and item.last_line > item.line)
    measured = item.value is not None and item.worst_line
    stretch = f"worst in line {item.worst_line}" if measured else name_lines(item)
    stretch += "" if measured or item.count < 2 else f", {item.count} times"
    text = "\n".join([item.full_message, *([stretch] if spread else []), *also, *remedies])
    return f"::{_LEVELS[item.severity]} {','.join(where)}::{_escape_data(text)}"


def _escape_data(text: str) -> str:
    """A text inside a command of ours, in which other agents find none either."""
    return make_lines_printable(text).replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _escape_property(text: str) -> str:
    return _escape_data(text).replace(":", "%3A").replace(",", "%2C")
