"""Findings for people."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from verne_post.base.numbers import format_count
from verne_post.base.printable import make_printable
from verne_post.model.machine import Machine
from verne_post.output.findings import (
    Report,
    describe_called,
    describe_not_counted,
    format_causes,
    format_finding,
    format_outcome,
)

#: Notes about the control, whose text is long: the first program of a run has it whole.
_OF_THE_CONTROL: Final = ("VP047",)


def write(reports: Sequence[Report], machine: Machine | None = None) -> str:
    """One line a cause, errors in the text with the line that they stand in; then one line a program.

    Remarks that several programs share are at the end, once, and how many findings of all do not count.
    """
    lines = []
    counts = Counter(remark for report in reports for remark in dict.fromkeys(report.remarks))
    # what several programs have in common is said once, below all of them, and so is what was not checked
    shared = [one for one, n in counts.items() if len(reports) > 1 and (n > 1 or one.startswith("NOT CHECKED"))]
    told = set[str]()
    for report in reports:
        findings = report.findings if report.shown is None else report.shown
        own_causes = [item for item in findings if item.code not in told]
        for cause in format_causes(report.program, own_causes, report.source, report.run):
            lines += cause
        for item in (item for item in findings if item.code in told):
            lines.append(format_finding(report.program, replace(item, message=item.message.partition(": ")[0])))
        told |= {item.code for item in report.findings if item.code in _OF_THE_CONTROL}
        time = "" if report.cycle_time_s is None else f", machining time {report.cycle_time_s:.3f} s"
        own = report.machine or machine
        outcome = format_outcome(report.program, report.findings, report.errors_not_counted, own, report.fail_level)
        lines.append(f"{outcome}{time}")
        lines += [f"  {make_printable(remark)}" for remark in report.remarks if remark not in shared]
    for remark in shared:
        key, _colon, text = remark.partition(": ")
        lines.append(make_printable(f"{key} in {format_count(counts[remark], 'program')}: {text}"))
    return "".join(line + "\n" for line in lines + describe_called(reports) + describe_not_counted(reports))
