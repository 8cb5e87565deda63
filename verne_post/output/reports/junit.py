"""Findings as JUnit XML: one test case a program, as CI servers show them."""

from collections.abc import Sequence
from xml.etree import ElementTree

from verne_post.base.printable import make_printable
from verne_post.model.findings import Finding
from verne_post.model.machine import Machine
from verne_post.model.verdict import Verdict, is_about_pose
from verne_post.output.causes import find_first_error
from verne_post.output.findings import Report, format_causes

#: Characters that XML cannot hold, made visible.
_UNPRINTABLE = {code: "?" for code in range(32) if chr(code) not in "\t\n\r"} | {0xFFFE: "?", 0xFFFF: "?", 0x7F: "?"}


def write(reports: Sequence[Report], _machine: Machine | None = None) -> str:
    """A program that breaks limits has failed; one that cannot be read or checked is an error; warnings are output."""
    return _write_document([_make_case(report) for report in reports])


def write_failure(verdict: Verdict, message: str, _findings: Sequence[Finding]) -> str:
    """One test case, the check itself, with an error."""
    case = ElementTree.Element("testcase", classname="verne-post", name="check", time="0.000")
    ElementTree.SubElement(case, "error", type=verdict, message=make_printable(message)).text = _clean(message)
    return _write_document([case])


def _write_document(cases: list[ElementTree.Element]) -> str:
    counts: dict[str, str] = {
        "tests": str(len(cases)),
        "failures": str(sum(case.find("failure") is not None for case in cases)),
        "errors": str(sum(case.find("error") is not None for case in cases)),
    }
    counts["time"] = f"{sum(float(case.get('time', '0')) for case in cases):.3f}"
    root = ElementTree.Element("testsuites", {"name": "verne-post", **counts})
    suite = ElementTree.SubElement(root, "testsuite", {"name": "verne-post check", "skipped": "0", **counts})
    suite.extend(cases)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _make_case(report: Report) -> ElementTree.Element:
    case = ElementTree.Element(
        "testcase",
        classname="verne-post",
        name=make_printable(report.program),
        time=f"{report.cycle_time_s or 0.0:.3f}",
    )
    lines = []
    for shown in format_causes(report.program, report.findings, report.source):
        lines += shown
    text = _clean("\n".join(lines))
    if (first := find_first_error(report.findings)) is not None:
        kind = "failure" if is_about_pose(first.code) else "error"
        ElementTree.SubElement(case, kind, type=first.code, message=make_printable(first.message)).text = text
    elif text:
        ElementTree.SubElement(case, "system-out").text = text
    return case


def _clean(text: str) -> str:
    """Replace what XML cannot hold."""
    return text.translate(_UNPRINTABLE)
