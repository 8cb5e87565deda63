"""Findings as text and JSON."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from verne_post.base.long_text import Text, line_of
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding
from verne_post.model.machine import Machine
from verne_post.model.verdict import concerns_pose, concerns_text, counts, status_of, verdict_of


@dataclass(frozen=True)
class Report:
    """Everything that was found out about one program."""

    program: str
    findings: tuple[Finding, ...]
    cycle_time_s: float | None = None
    source: Text = b""
    remarks: tuple[str, ...] = ()


def text_line(program: str, item: Finding) -> str:
    """``FILE:LINE: CODE severity: message``, with the stretch when it is longer than one line."""
    where = program if item.line is None else f"{program}:{item.line}"
    text = f"{where}: {item.code} {item.severity}: {item.message}"
    if item.column is not None:
        text += f" (column {item.column})"
    if item.count > 1 and item.line is not None and item.last_line not in (None, item.line):
        text += f" (lines {item.line} to {item.last_line}, worst {item.worst_line}, {item.count} moves)"
    return text


#: So much of a long line is shown around a column.
_SHOWN: Final = 100


def quoted(item: Finding, source: Text, program: str) -> list[str]:
    """The line of an error, a caret under the column, what the code means and what helps; nothing for other findings."""
    in_text = concerns_text(item.code)
    at = item.line if in_text else item.worst_line or item.line
    if not at or (item.severity != "error" and not in_text):
        return []
    text = line_of(source, at)
    if text is None:
        return []
    line = text.decode("utf-8", errors="replace").rstrip("\r").replace("\t", " ")
    line = "".join(character if character.isprintable() else "?" for character in line)
    column = item.column or 1
    begin = max(0, column - 1 - _SHOWN // 2) if len(line) > _SHOWN else 0
    number = str(at)
    blank = " " * len(number)
    found = [f"  {number} | {'...' if begin else ''}{line[begin : begin + _SHOWN]}"]
    if item.column is not None:
        found.append(f"  {blank} | {' ' * (column - 1 - begin + (3 if begin else 0))}^")
    code = CODES[item.code]
    found.append(f"  {blank} = {code.title}: {code.remedy}")
    if concerns_pose(item.code):
        found.append(f"  {blank} = `verne-post explain {program}:{at}` says how much is needed")
    return found


def text(reports: Sequence[Report]) -> str:
    """One line a finding, errors in the text with the line that they stand in; then one line a program."""
    lines = []
    for report in reports:
        for item in report.findings:
            lines += [text_line(report.program, item), *quoted(item, report.source, report.program)]
        errors, warnings = counts(report.findings)
        verdict = "can run" if not errors else "refused"
        time = "" if report.cycle_time_s is None else f", {report.cycle_time_s:.3f} s"
        lines.append(f"{report.program}: {verdict}: {errors} errors, {warnings} warnings{time}")
        lines += [f"  {remark}" for remark in report.remarks]
    return "".join(line + "\n" for line in lines)


_KEYS: Final = (
    "code", "severity", "line", "last_line", "worst_line", "column", "axis", "value", "limit", "unit", "message", "count",
)  # fmt: skip


def as_jsonl(reports: Sequence[Report]) -> str:
    """One finding a line, with its program."""
    return "".join(
        json.dumps({"program": report.program, **{key: getattr(item, key) for key in _KEYS}}, allow_nan=False) + "\n"
        for report in reports for item in report.findings
    )  # fmt: skip


def as_json(reports: Sequence[Report], machine: Machine) -> str:
    """The documented schema 1 (docs/findings.md)."""
    programs = []
    for report in reports:
        errors, warnings = counts(report.findings)
        programs.append(
            {
                "program": report.program,
                "machine": {"name": machine.name, "sha256": machine.sha256},
                "verdict": verdict_of(status_of(report.findings), report.findings),
                "summary": {"errors": errors, "warnings": warnings, "cycle_time_s": report.cycle_time_s},
                "findings": [
                    {key: getattr(item, key) for key in _KEYS}
                    for item in report.findings
                ],
            }
        )  # fmt: skip
    return json.dumps({"schema": 1, "programs": programs}, indent=2, allow_nan=False) + "\n"
