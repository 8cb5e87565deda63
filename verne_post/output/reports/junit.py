"""Findings as JUnit XML: one test case a program, as CI servers show them."""

from collections.abc import Mapping, Sequence
from xml.etree import ElementTree

from verne_post.base.printable import make_printable
from verne_post.model.findings import Finding
from verne_post.model.machine import Machine
from verne_post.model.verdict import Verdict, is_about_pose
from verne_post.output.causes import find_first_error
from verne_post.output.findings import Report, format_causes, format_outcome, list_unchecked

#: Characters that XML cannot hold, made visible.
_UNPRINTABLE = {code: "?" for code in range(32) if chr(code) not in "\t\n\r"} | {0xFFFE: "?", 0xFFFF: "?", 0x7F: "?"}


def write(reports: Sequence[Report], machine: Machine | None = None) -> str:
    """A program that breaks limits has failed; one that cannot be read or checked is an error; warnings are output.

    The time of a test case is that of its check. The property of the suite is the version; those of a test case are the
    machine and the machining time in s. Output also says what was not checked.
    """
    return _write_document([_make_case(report, report.machine or machine) for report in reports])


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
    from verne_post import __version__

    root = ElementTree.Element("testsuites", {"name": "verne-post", **counts})
    suite = ElementTree.SubElement(root, "testsuite", {"name": "verne-post check", "skipped": "0", **counts})
    _add_properties(suite, {"version": __version__})
    suite.extend(cases)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _make_case(report: Report, machine: Machine | None) -> ElementTree.Element:
    case = ElementTree.Element(
        "testcase", classname="verne-post", name=make_printable(report.program), time=f"{report.elapsed_s:.3f}"
    )
    properties: dict[str, str] = {}
    if machine is not None:
        properties |= {"machine": make_printable(machine.name), "machine_sha256": machine.sha256}
    if report.cycle_time_s is not None:
        properties["machining_time_s"] = f"{report.cycle_time_s:.3f}"
    if properties:
        _add_properties(case, properties)
    lines = []
    for shown in format_causes(report.program, report.findings, report.source, report.run):
        lines += shown
    text, output = _clean("\n".join(lines)), list_unchecked([report])
    if (first := find_first_error(report.findings)) is not None:
        kind = "failure" if is_about_pose(first.code) else "error"
        ElementTree.SubElement(case, kind, type=first.code, message=make_printable(first.full_message)).text = text
    elif report.verdict == Verdict.WARNINGS_FAIL:
        outcome = format_outcome(report.program, report.findings, fail_level=report.fail_level)
        ElementTree.SubElement(case, "failure", type="warning", message=outcome).text = text
    elif text:
        output.insert(0, text)
    if output:
        ElementTree.SubElement(case, "system-out").text = _clean("\n".join(output))
    return case


def _add_properties(element: ElementTree.Element, values: Mapping[str, str]) -> None:
    properties = ElementTree.SubElement(element, "properties")
    for name, value in values.items():
        ElementTree.SubElement(properties, "property", name=name, value=value)


def _clean(text: str) -> str:
    """Replace what XML cannot hold."""
    return text.translate(_UNPRINTABLE)
