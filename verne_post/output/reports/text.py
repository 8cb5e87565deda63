"""Findings for people."""

from collections.abc import Sequence

from verne_post.base.printable import printable
from verne_post.model.machine import Machine
from verne_post.model.verdict import counts
from verne_post.output.findings import Report, quote_line, text_line


def write(reports: Sequence[Report], _machine: Machine | None = None) -> str:
    """One line a finding, errors in the text with the line that they stand in; then one line a program."""
    lines = []
    for report in reports:
        for item in report.findings:
            lines += [text_line(report.program, item), *quote_line(item, report.source, report.program)]
        errors, warnings = counts(report.findings)
        hidden = report.errors_not_counted
        verdict = "refused" if errors else f"not refused, {hidden} errors do not count" if hidden else "can run"
        time = "" if report.cycle_time_s is None else f", {report.cycle_time_s:.3f} s"
        lines.append(
            f"{printable(report.program)}: {verdict}: {_counted(errors, 'error')}, {_counted(warnings, 'warning')}{time}"
        )
        lines += [f"  {remark}" for remark in report.remarks]
    return "".join(line + "\n" for line in lines)


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
