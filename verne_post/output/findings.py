"""Findings as text and JSON."""

import json
from collections.abc import Sequence
from dataclasses import dataclass

from verne_post.model.findings import Finding
from verne_post.model.machine import Machine


@dataclass(frozen=True)
class Report:
    """Everything that was found out about one program."""

    program: str
    findings: tuple[Finding, ...]
    cycle_time_s: float | None = None


def text_line(program: str, item: Finding) -> str:
    """``FILE:LINE: CODE severity: message``, with the stretch when it is longer than one line."""
    where = program if item.line is None else f"{program}:{item.line}"
    text = f"{where}: {item.code} {item.severity}: {item.message}"
    if item.column is not None:
        text += f" (column {item.column})"
    if item.count > 1 and item.line is not None and item.last_line not in (None, item.line):
        text += f" (lines {item.line} to {item.last_line}, worst {item.worst_line}, {item.count} moves)"
    return text


def text(reports: Sequence[Report]) -> str:
    """One line a finding, then one line a program."""
    lines = []
    for report in reports:
        lines += [text_line(report.program, item) for item in report.findings]
        errors, warnings = counts(report.findings)
        verdict = "can run" if not errors else "refused"
        time = "" if report.cycle_time_s is None else f", {report.cycle_time_s:.3f} s"
        lines.append(f"{report.program}: {verdict}: {errors} errors, {warnings} warnings{time}")
    return "".join(line + "\n" for line in lines)


def counts(findings: Sequence[Finding]) -> tuple[int, int]:
    """Numbers of errors and of warnings."""
    severities = [item.severity for item in findings]
    return severities.count("error"), severities.count("warning")


def as_json(reports: Sequence[Report], machine: Machine) -> str:
    """The documented schema 1 (docs/findings.md)."""
    programs = []
    for report in reports:
        errors, warnings = counts(report.findings)
        programs.append(
            {
                "program": report.program,
                "machine": {"name": machine.name, "sha256": machine.sha256},
                "summary": {"errors": errors, "warnings": warnings, "cycle_time_s": report.cycle_time_s},
                "findings": [
                    {
                        key: getattr(item, key)
                        for key in ("code", "severity", "line", "last_line", "worst_line", "column", "axis", "value",
                                    "limit", "unit", "message", "count")
                    }
                    for item in report.findings
                ],
            }
        )  # fmt: skip
    return json.dumps({"schema": 1, "programs": programs}, indent=2, allow_nan=False) + "\n"


#: Output formats of `check`.
FORMATS = ("text", "json")
