"""Findings as JSON lines, for streams."""

import json
from collections.abc import Sequence

from verne_post.model.machine import Machine
from verne_post.output.findings import Report, record_of


def write(reports: Sequence[Report], _machine: Machine | None = None) -> str:
    """One finding a line, with its program."""
    return "".join(
        json.dumps({"program": report.program, **record_of(item)}, allow_nan=False) + "\n"
        for report in reports for item in report.findings
    )  # fmt: skip
