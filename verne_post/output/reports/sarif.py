"""Findings as SARIF 2.1.0, which code hosts show beside the G-code line."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from verne_post.base.printable import format_json
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding, name_lines
from verne_post.model.machine import Machine
from verne_post.model.verdict import SEVERITIES, Verdict
from verne_post.output.causes import Cause, describe_other, find_causes
from verne_post.output.code_pages import make_markdown, make_text
from verne_post.output.findings import Report, drop_repeated, find_place, list_remedies, list_unchecked, locate_call
from verne_post.output.policy import find_path_in_repository, make_fingerprint, make_uri

#: Code hosts read no more results of a run.
MAX_RESULTS: Final = 5_000
_SCHEMA: Final = "https://json.schemastore.org/sarif-2.1.0.json"
#: How fingerprints are made; another rule needs another name.
_FINGERPRINT: Final = "verneFinding/v1"
#: The fingerprint by which GitHub recognises a result. Without it the host needs the file, which it may not have.
_LINE_HASH: Final = "primaryLocationLineHash"


def write(reports: Sequence[Report], _machine: Machine | None = None) -> str:
    """One run: a rule for each code that occurs, a result for each cause, and notes of what was not checked."""
    from verne_post import __version__

    told_once = drop_repeated(reports, also_errors=True)
    everything = [(report, cause) for report in told_once for cause in find_causes(report.findings)]
    by_gravity = sorted(range(len(everything)), key=lambda one: SEVERITIES.index(everything[one][1].first.severity))
    shown = [everything[one] for one in sorted(by_gravity[:MAX_RESULTS])]
    rules = sorted({cause.first.code for _report, cause in shown})
    seen: Counter[str] = Counter()
    run: dict[str, Any] = {
        "tool": {
            "driver": {"name": "verne-post", "version": __version__, "rules": [_make_rule(code) for code in rules]}
        },
        "columnKind": "unicodeCodePoints",
        "results": [_make_result(report, cause, rules, seen) for report, cause in shown],
    }
    left_out = len(everything) - len(shown)
    notes = list_unchecked(reports)
    if left_out:
        notes.append(f"{left_out} further findings are left out; `verne-post check` without --output-format prints all")
    if notes:
        run["invocations"] = [_make_invocation("note", notes, successful=True)]
    return _write_document(run)


def write_failure(_verdict: Verdict, message: str, findings: Sequence[Finding]) -> str:
    """One run that was not successful, and why, at the places of the files that are wrong."""
    from verne_post import __version__

    driver = {"name": "verne-post", "version": __version__, "rules": []}
    invocation = _make_invocation("error", [message], successful=False)
    if findings and all(item.file is not None for item in findings):
        invocation["toolExecutionNotifications"] = [
            {"level": "error", "message": {"text": item.message}, "locations": [_make_location("", item)]}
            for item in findings
        ]
    invocations = [invocation]
    return _write_document({"tool": {"driver": driver}, "invocations": invocations, "results": []})


def _make_invocation(level: str, texts: Sequence[str], *, successful: bool) -> dict[str, Any]:
    notifications = [{"level": level, "message": {"text": text}} for text in texts]
    return {"executionSuccessful": successful, "toolExecutionNotifications": notifications}


def _write_document(run: dict[str, Any]) -> str:
    return format_json({"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}, 2) + "\n"


def _make_rule(code: str) -> dict[str, Any]:
    known = CODES[code]
    return {
        "id": code,
        "shortDescription": {"text": known.title},
        "fullDescription": {"text": known.meaning},
        "help": {"text": make_text(code), "markdown": make_markdown(code)},
        "defaultConfiguration": {"level": known.severity},
    }


def _make_result(report: Report, cause: Cause, rules: list[str], seen: Counter[str]) -> dict[str, Any]:
    item, others = cause.first, cause.describe_others()
    also = [f"also {others}"] if others else []
    places = {(other.line, other.last_line, describe_other(other)): other for other in cause.others}  # each once
    related = [
        {**_make_location(report.program, other), "message": {"text": text}}
        for (_line, _last, text), other in places.items()
    ]
    again = [
        replace(item, line=line, last_line=line, column=None, lines=()) for line in item.lines if line != item.line
    ]
    related += [{**_make_location(report.program, one), "message": {"text": "here too"}} for one in again]
    if item.called is not None:
        file, line, column = locate_call(report.program, item.called)
        there = replace(item, file=file, file_line=line, file_column=column, last_line=None, called=None)
        related.append({**_make_location(report.program, there), "message": {"text": "it stands here"}})
    fingerprint = make_fingerprint(report, item, seen, find_path_in_repository)
    properties = {name: getattr(item, name) for name in ("axis", "value", "limit", "unit", "count", "worst_line")}
    properties["plane"] = item.plane and item.plane._asdict()
    return {
        "ruleId": item.code,
        "ruleIndex": rules.index(item.code),
        "level": item.severity,
        # hosts show the message beside the line, and the help of the rule a click away
        "message": {
            "text": "\n".join(
                [
                    item.full_message,
                    *(["in " + name_lines(item)] if item.lines else []),
                    *also,
                    *list_remedies(item, report.program, report.run),
                ]
            )
        },
        "locations": [_make_location(report.program, item)],
        **({"relatedLocations": related} if related else {}),
        "partialFingerprints": {_FINGERPRINT: fingerprint, _LINE_HASH: fingerprint},
        "properties": {name: value for name, value in properties.items() if value is not None},
    }


def _make_location(program: str, item: Finding) -> dict[str, Any]:
    file, line = find_place(program, item)
    # the approach of --from (line 0) and files that cannot be read have no line: code hosts want one all the same
    region: dict[str, Any] = {"startLine": line or 1}
    column = item.column if item.file is None else item.file_column
    if line and column is not None:
        region["startColumn"] = column
    if item.line and item.last_line is not None and item.last_line > item.line and not item.lines:
        region["endLine"] = item.last_line
    return {"physicalLocation": {"artifactLocation": {"uri": make_uri(file)}, "region": region}}
