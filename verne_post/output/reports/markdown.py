"""Findings in Markdown, for a comment on a pull request."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

from verne_post.base.numbers import format_count
from verne_post.base.printable import make_printable
from verne_post.model.findings import Finding, describe, describe_trial
from verne_post.model.machine import Machine
from verne_post.model.verdict import OF_THE_PART, SEVERITIES, Verdict, is_about_pose
from verne_post.output.causes import Cause, find_causes
from verne_post.output.findings import Report, describe_remedy, format_outcome, list_unchecked

#: A comment has room for 65,536 characters.
MAX_CHARACTERS: Final = 60_000
#: Lines above the findings of a program.
_HEAD: Final = 5
#: ASCII that Markdown could take for its own, in a table as well.
_MARKS: Final = re.compile(r"[\\`*_{}\[\]<>|~&$!]")


def write(reports: Sequence[Report], machine: Machine | None = None) -> str:
    """The programs, how many of each result, and the findings of each as far as a comment has room: tables."""
    if not reports:
        return "No program was checked.\n"
    several = any(report.machine is not None for report in reports)
    on = "" if machine is None or several else f" on {_escape(machine.name)}"
    lines, words = [f"| program | result{on} | machining time |", "|---|---|---|"], Counter[str]()
    for report in reports:
        result = format_outcome("", report.findings, report.errors_not_counted, None, report.fail_level)
        result = result.removeprefix(": ")
        words[re.split("[:,]", result)[0]] += 1
        own = report.machine or machine
        result += f" ({_escape(own.name)})" if several and own is not None else ""
        time = "" if report.cycle_time_s is None else f"{report.cycle_time_s:.3f} s"
        lines.append(f"| {_escape(report.program)} | {result} | {time} |")
    counted = ", ".join(f"{count} {word}" for word, count in words.items())
    lines += ["", f"{format_count(len(reports), 'program')}: {counted}"]
    unchecked = [_escape(text).replace("NOT CHECKED", "**NOT CHECKED**", 1) for text in list_unchecked(reports)]
    shown = _count_that_fit(unchecked, MAX_CHARACTERS // 4)
    more = [f"**NOT CHECKED** in others: {len(unchecked) - shown} further lines"] * (shown < len(unchecked))
    for text in (*unchecked[:shown], *more):
        lines += ["", text]
    heads = [["", f"**{_escape(report.program)}**", "", "| line | finding |", "|---|---|"] for report in reports]
    rows = [row for at, report in enumerate(reports) for row in _list_rows(at, report)]
    room, shown_rows = MAX_CHARACTERS - sum(map(len, lines)), 0
    for _gravity, at, row in sorted(rows, key=lambda one: one[0]):  # of all programs the errors first
        room -= len(row) + (sum(map(len, heads[at])) if len(heads[at]) == _HEAD else 0)
        if room < 0:
            break
        heads[at].append(row)
        shown_rows += 1
    lines += [line for head in heads if len(head) > _HEAD for line in head]
    if left_out := len(rows) - shown_rows:
        lines += ["", f"{format_count(left_out, 'further finding')}: a comment has no room for them."]
    return "".join(line + "\n" for line in lines)


def write_failure(_verdict: Verdict, message: str, findings: Sequence[Finding]) -> str:
    """One sentence, or a table of what is wrong in files."""
    head = "**verne-post could not check the programs**"
    if not findings:
        return f"{head}: {_escape(message)}\n"
    rows = [_write_row(cause, "") for cause in find_causes(findings)]
    return "".join(f"{line}\n" for line in (head, "", "| line | finding |", "|---|---|", *rows))


def _list_rows(at: int, report: Report) -> Iterator[tuple[int, int, str]]:
    """How grave each finding of a program is, the number of the program, and the row of a table, the gravest first."""
    seen = set()
    for cause in sorted(find_causes(report.findings), key=lambda one: SEVERITIES.index(one.first.severity)):
        # a comment has no terminal beside it: remedies stand in it, each once; those of poses were tried
        was_tried = is_about_pose(cause.first.code) and cause.first.code not in OF_THE_PART
        remedy = "" if was_tried else describe_remedy(cause.first, report.program, report.run)
        yield SEVERITIES.index(cause.first.severity), at, _write_row(cause, "" if remedy in seen else remedy)
        seen.add(remedy)


def _count_that_fit(rows: list[str], room: int) -> int:
    shown = 0
    while shown < len(rows) and len(rows[shown]) <= room:
        room -= len(rows[shown])
        shown += 1
    return shown


def _write_row(cause: Cause, remedy: str) -> str:
    item, others = cause.first, cause.describe_others()
    also = f"<br>also {_escape(others)}" if others else ""
    remedies = also + "".join(f"<br>{_escape(describe_trial(tried))}" for tried in item.remedies)
    remedies += f"<br>{_escape(remedy)}" if remedy else ""
    line = "" if item.line is None else str(item.line)
    if item.file is not None:  # another one than the heading names
        line = _escape(item.file if item.file_line is None else f"{item.file}:{item.file_line}")
    return f"| {line} | {_escape(describe(item))}{remedies} |"


def _escape(text: str) -> str:
    """Text that means nothing to Markdown; a word joiner keeps names and numbers from calling people and issues."""
    escaped = _MARKS.sub(r"\\\g<0>", " ".join(make_printable(text).split()))
    return re.sub("[@#]", "\\g<0>\u2060", escaped)
