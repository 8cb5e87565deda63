"""Findings as JSON for programs: schema 1 of docs/findings.md."""

from collections.abc import Sequence

from verne_post.base.printable import format_json
from verne_post.model.findings import Finding
from verne_post.model.machine import Machine
from verne_post.model.verdict import Verdict
from verne_post.output.causes import count_causes
from verne_post.output.findings import Report, make_records


def write(reports: Sequence[Report], machine: Machine | None) -> str:
    """One document: each program with its verdict and its findings."""
    programs = []
    for report in reports:
        own = report.machine or machine
        errors, warnings = count_causes(report.findings)
        programs.append(
            {
                "program": report.program,
                "machine": None if own is None else {"name": own.name, "sha256": own.sha256},
                "verdict": report.verdict,
                "summary": {
                    "errors": errors,
                    "warnings": warnings,
                    "ignored": report.ignored,
                    "known": report.known,
                    "cycle_time_s": report.cycle_time_s,
                },
                "unchecked": report.unchecked,
                "called": report.called,
                "findings": make_records(report.findings, report.program, report.run),
            }
        )
    return _write_document({"schema": 1, "programs": programs})


def write_failure(verdict: Verdict, message: str, findings: Sequence[Finding]) -> str:
    """The document of a check that could not begin: no program was checked."""
    failure = {"verdict": verdict, "message": message, "findings": make_records(findings, "<stdin>")}
    return _write_document({"schema": 1, "failure": failure, "programs": []})


def _write_document(data: dict[str, object]) -> str:
    return format_json(data, 2) + "\n"
