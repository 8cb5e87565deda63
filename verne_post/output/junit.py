"""Findings as JUnit XML: one test case a program, as CI servers show them."""

from collections.abc import Sequence
from xml.etree import ElementTree

from verne_post.model.verdict import worst
from verne_post.output.findings import Report, quoted, text_line

#: Characters that XML cannot hold, made visible.
_UNPRINTABLE = {code: "?" for code in range(32) if chr(code) not in "\t\n\r"} | {0xFFFE: "?", 0xFFFF: "?", 0x7F: "?"}


def as_junit(reports: Sequence[Report]) -> str:
    """A program that breaks limits has failed; one that cannot be read or judged is an error; warnings are output."""
    cases = [_case(report) for report in reports]
    counts: dict[str, str] = {
        "tests": str(len(cases)),
        "failures": str(sum(case.find("failure") is not None for case in cases)),
        "errors": str(sum(case.find("error") is not None for case in cases)),
    }
    root = ElementTree.Element("testsuites", {"name": "verne-post", **counts})
    suite = ElementTree.SubElement(root, "testsuite", {"name": "verne-post check", "skipped": "0", **counts})
    suite.extend(cases)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _case(report: Report) -> ElementTree.Element:
    case = ElementTree.Element(
        "testcase", classname="verne-post", name=_clean(report.program), file=_clean(report.program)
    )
    lines = []
    for item in report.findings:
        lines += [text_line(report.program, item), *quoted(item, report.source, report.program)]
    text = _clean("\n".join(lines))
    if worst(report.findings) == "error":
        first = next(item for item in report.findings if item.severity == "error")
        verdict = first.code[:3] in ("VP1", "VP2", "VP3")
        kind = "failure" if verdict else "error"
        told = ElementTree.SubElement(case, kind, type=first.code, message=_clean(first.message))
        told.text = text
    elif text:
        ElementTree.SubElement(case, "system-out").text = text
    return case


def _clean(text: str) -> str:
    return text.translate(_UNPRINTABLE)
