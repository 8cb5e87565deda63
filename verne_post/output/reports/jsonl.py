"""Findings as JSON lines, for streams."""

from collections.abc import Sequence

from verne_post.base.printable import format_json
from verne_post.model.findings import Finding
from verne_post.model.machine import Machine
from verne_post.model.verdict import Verdict
from verne_post.output.findings import Report, make_records


def write(reports: Sequence[Report], _machine: Machine | None = None) -> str:
    """One finding a line, with its program."""
    return "".join(
        format_json({"program": report.program, **record}) + "\n"
        for report in reports
        for record in make_records(report.findings, report.program, report.run)
    )


def write_failure(verdict: Verdict, message: str, _findings: Sequence[Finding]) -> str:
    """One line, which no finding is like."""
    return format_json({"failure": {"verdict": verdict, "message": message}}) + "\n"
