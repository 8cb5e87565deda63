"""Findings for people, one for each cause: the first place of a limit, and beside it the others that go with it.

Findings as such are exact: one for each joint and stretch of moves. A part zero that is wrong breaks the same limit in
many stretches, and limits of several joints in the same moves. For people that is one thing to settle.
"""

import dataclasses
import math
import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from typing import Final

from msgspec import Struct

from verne_post.base.numbers import choose_decimals
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding, describe_trial, list_found
from verne_post.model.verdict import SEVERITIES, Family, count_findings, find_family, is_about_pose

#: A rotary axis beyond its travel: until it is inside, what else the same lines break follows from it.
_ROTARY: Final = ("VP102", "VP103")
#: The tip below the table: what the way back from there comes near is no mistake of its own.
_BELOW: Final = ("VP210",)
#: Contacts of tool and spindle with fixtures and stock.
_CONTACTS: Final = ("VP215", "VP216")
#: A lone word without a decimal point among words with one.
_LOST_POINT: Final = re.compile(r"([A-Z][^ ]+) has no decimal point, and words of line \d+ have one(?=: )")
#: Beside travel and reach (VP1xx): singularities, the height over the table, and the cones of joints. Each contact with
#: a body stays alone.
_OF_THE_WORKSPACE: Final = ("VP201", "VP202", "VP203", "VP210", "VP214")


#: The least excess of a joint that three decimals show.
_SHOWN: Final = 0.0005


class Cause(Struct, frozen=True):
    """Findings that one correction settles.

    Attributes
    ----------
    first : Finding
        Where the program has to be corrected first; with the remedies of all of them.
    others : tuple of Finding
        By line.
    indices : tuple of int
        Their places among the findings: of the first one, then of the others.
    """

    first: Finding
    others: tuple[Finding, ...]
    indices: tuple[int, ...]

    def __repr__(self) -> str:
        """As the commands print it: the first finding, what the others break, and what was tried or else helps."""
        first, others = self.first, self.describe_others()
        helps = [describe_trial(text) for text in list_found(first.remedies)]
        if not helps and first.remedy and (first.severity == "error" or not is_about_pose(first.code)):
            helps = [first.remedy]
        return "\n    = ".join([str(first), *([f"also {others}"] if others else []), *helps])

    def describe_others(self) -> str:
        """By how much and in which lines the others break their limits, the worst place of each joint; or nothing."""
        of_joints: dict[str, list[Finding]] = {}
        for item in self.others:
            of_joints.setdefault(_name_quantity(item), []).append(item)
        own = _name_limit(self.first)
        shown = []
        for name, items in of_joints.items():
            text = _describe_places(items)
            if own and _name_limit(items[0]) == own:  # it stands in the line above
                text = f"{items[0].axis or ''}{text.removeprefix(name)}".strip()
            shown.append(text)
        return "; ".join(shown)


def find_causes(findings: Sequence[Finding]) -> list[Cause]:
    """Findings by their causes, in the order of the first ones, whose lines are shown.

    Findings of one code and severity are one where they break the same limit, or limits of several joints in the same
    lines; the height over the table counts as one of them. Equal contacts in lines that follow each other are one. What
    is broken only in lines in which a rotary axis is beyond its travel, or which are out of reach, has that as its
    cause. A remedy that several causes share is told at the first one.
    """
    groups = [(min(group, key=lambda one: _rank(findings[one])), group) for group in _group(findings)]
    told: dict[str, Finding] = {}
    causes = []
    for first, group in sorted(groups):
        is_rotary = findings[first].code in _ROTARY  # what would settle the others would not settle that
        alike = [one for one in group if not is_rotary or findings[one].code in _ROTARY]
        shared = dict.fromkeys(text for one in alike for text in findings[one].remedies)
        remedies = tuple(dict.fromkeys(_name_remedy(text, told) for text in shared))
        # a word of the program is one place's; a key of the set-up settles all
        keyed = [edit for one in group for edit in findings[one].edits if edit.key]
        edits = tuple(dict.fromkeys((*findings[first].edits, *keyed)))
        head = dataclasses.replace(findings[first], remedies=remedies, edits=edits)
        told |= {text: head for text in shared if text not in told}
        others = [one for one in group if one != first]
        causes.append(Cause(head, tuple(findings[one] for one in others), (first, *others)))
    return causes


def _rank(item: Finding) -> tuple[int, bool, bool, int, float]:
    """What a cause shows first: the gravest, a rotary axis beyond its travel, what is out of reach, the earliest line.

    Only the first one is counted: an error beside a warning would refuse a program that has no error.
    """
    excess = find_excess(item)
    return SEVERITIES.index(item.severity), item.code not in _ROTARY, excess < math.inf, item.line or 0, -excess


def list_first(findings: Sequence[Finding]) -> Iterator[Finding]:
    """The first finding of each cause."""
    return (cause.first for cause in find_causes(findings))


def count_causes(findings: Sequence[Finding]) -> tuple[int, int]:
    """Numbers of errors and of warnings, one for each cause: what every table, report and format of a program has."""
    return count_findings(list_first(findings))


def find_first_error(findings: Sequence[Finding]) -> Finding | None:
    """The first finding of the first cause that refuses a program; None where none does."""
    return next((item for item in list_first(findings) if item.severity == "error"), None)


def find_excess(item: Finding) -> float:
    """How far beyond its limit a finding is; most for what cannot be reached at all."""
    return float("inf") if item.value is None or item.limit is None else abs(item.value - item.limit)


def _group(findings: Sequence[Finding]) -> list[list[int]]:
    """The numbers of the findings by their causes, each group in order, in the order in which they begin."""
    group_of: list[list[int]] = []
    limits: dict[object, list[int]] = {}
    for index, item in enumerate(findings):
        limit = (item.code, item.severity, item.axis, _strip_numbers(item.message))
        group_of.append(limits.setdefault(limit if _is_of_the_workspace(item) else index, []))
        group_of[index].append(index)
    furthest: dict[object, tuple[int, int]] = {}  # code, severity -> last line of joints so far, and which finding's
    for index in sorted(range(len(findings)), key=lambda one: findings[one].line or 0):
        item = findings[index]
        code = "VP101" if item.code == "VP210" else item.code  # one Z too low breaks both
        if (item.axis is None and code == item.code) or item.line is None or not _is_of_the_workspace(item):
            continue
        end, other = furthest.get((code, item.severity), (-1, index))
        if item.line <= end and group_of[other] is not group_of[index]:
            united = sorted(group_of[other] + group_of[index])
            for one in united:
                group_of[one] = united
        if (item.last_line or item.line) > end:
            furthest[code, item.severity] = (item.last_line or item.line, index)
    _join_holes(findings, group_of)
    _join_depths(findings, group_of)
    return _join_consequences(findings, list({id(group): group for group in group_of}.values()))


def _join_holes(findings: Sequence[Finding], group_of: list[list[int]]) -> None:
    """Contacts with a body, as deep in each of lines that follow each other, are one: of a cycle, R is too low."""
    before: int | None = None
    for index, item in enumerate(findings):
        if item.code != "VP216" or item.line is None or item.value is None:
            continue
        if before is not None and _goes_on(findings[before], item):
            group_of[before].append(index)
            group_of[index] = group_of[before]
        before = index


def _join_depths(findings: Sequence[Finding], group_of: list[list[int]]) -> None:
    """What one other word of a line was tried to settle is one: a Z too deep for the fixture and for the table."""
    first_of: dict[object, int] = {}
    for index, item in enumerate(findings):
        words = [(edit.line, edit.word, edit.value) for edit in item.edits if edit.word is not None]
        for word in words if item.severity == "error" and item.code in (*_BELOW, *_CONTACTS) else ():
            other = first_of.setdefault(word, index)
            if group_of[other] is not group_of[index]:
                united = sorted(group_of[other] + group_of[index])
                for one in united:
                    group_of[one] = united


def _goes_on(before: Finding, item: Finding) -> bool:
    """Whether a contact is that of a line before with other numbers of lines and places, and the same depth."""
    words = [(one.severity, re.sub(r"line \d+", "", _strip_numbers(one.message))) for one in (before, item)]
    is_next = before.line is not None and item.line == (before.last_line or before.line) + 1
    is_as_deep = abs(find_excess(before) - find_excess(item)) < _SHOWN
    return is_next and is_as_deep and words[0] == words[1]


def _join_consequences(findings: Sequence[Finding], groups: list[list[int]]) -> list[list[int]]:
    """The groups, where what is broken only beyond the travel of a rotary axis, or out of reach, belongs to that.

    So do warnings below the table alone: on the way back from there.
    """
    for codes in (_ROTARY, ("VP110",), _BELOW):
        groups = _join_to(findings, groups, codes)
    return _join_lost_points(findings, groups)


def _join_lost_points(findings: Sequence[Finding], groups: list[list[int]]) -> list[list[int]]:
    """The groups, where one word without a decimal point belongs to the error that its place leads to.

    Its line is the first or the worst one of a limit, or an impossible arc begins at the word.
    """
    words = {
        (item.line, match[1]): at for at, item in enumerate(findings) if (match := _LOST_POINT.match(item.message))
    }
    for (line, word), at in words.items():
        owner = next(
            (
                group
                for group in groups
                for item in (findings[one] for one in group)
                if item.severity == "error"
                and (
                    (_is_of_the_workspace(item) and line in (item.line, item.worst_line))
                    or (item.code == "VP008" and re.search(rf"[( ]{re.escape(word)}[ )]", item.message))
                )
            ),
            None,
        )
        if owner is not None:
            groups = [group for group in groups if at not in group and group is not owner] + [sorted([*owner, at])]
    return sorted(groups)


def _join_to(findings: Sequence[Finding], groups: list[list[int]], codes: Sequence[str]) -> list[list[int]]:
    """The groups, where those that break something in lines of errors of some codes alone belong to these."""
    spans: list[tuple[int, int, int]] = []  # first line, last line so far, group
    for line, last, number in sorted(
        (findings[one].line or 0, findings[one].last_line or 0, number)
        for number, group in enumerate(groups)
        for one in group
        if findings[one].code in codes and findings[one].severity == "error"
    ):
        before = spans[-1] if spans else (0, -1, number)
        spans.append((line, *max((last, number), before[1:])))
    if not spans:
        return groups
    owners = list(range(len(groups)))
    for number, group in enumerate(groups):
        is_owned = all(
            _is_of_the_machine(findings[one]) and (codes != _BELOW or findings[one].severity == "warning")
            for one in group
        )
        if is_owned and not any(findings[one].code in (*codes, *_ROTARY) for one in group):
            found = {_find_owner(findings[one], spans) for one in group}
            owners[number] = (
                min((one for one in found if one is not None), default=number) if None not in found else number
            )
    united: dict[int, list[int]] = {}
    for number, group in enumerate(groups):
        united.setdefault(owners[number], []).extend(group)
    return sorted(map(sorted, united.values()))


def _find_owner(item: Finding, spans: list[tuple[int, int, int]]) -> int | None:
    """The group of errors that have all lines of a finding."""
    if item.line is None:
        return None
    at = bisect_right(spans, (item.line, math.inf, 0)) - 1
    return spans[at][2] if at >= 0 and (item.last_line or item.line) <= spans[at][1] else None


def _is_of_the_machine(item: Finding) -> bool:
    return _is_of_the_workspace(item) or find_family(item.code) == Family.BRANCH


def _is_of_the_workspace(item: Finding) -> bool:
    return find_family(item.code) == Family.POSITION or item.code in _OF_THE_WORKSPACE


def _strip_numbers(message: str) -> str:
    """The words of a message: the numbers of two places of one limit differ, below and above it do not."""
    return re.sub(r"[-+]?\d+\.\d+", "", message)


def _name_remedy(text: str, told: dict[str, Finding]) -> str:
    first = told.get(text)
    return text if first is None else f"as for {first.code} in line {first.line}"


def _describe_places(findings: Sequence[Finding]) -> str:
    """The worst of some places of one joint, and how many there are."""
    shown = describe_other(max(findings, key=find_excess))
    return shown if len(findings) == 1 else f"{shown} (worst of {len(findings)} places)"


def _name_quantity(item: Finding) -> str:
    """What is beyond its limit: a quantity of a joint, or the joint itself; else the code with its title."""
    if (lost_point := _LOST_POINT.match(item.message)) is not None:
        return f"{item.code} ({lost_point[0]})"
    return item.quantity or item.axis or f"{item.code} ({CODES[item.code].title})"


def _name_limit(item: Finding) -> str:
    """What is beyond its limit, without the joint; empty where that is its travel, or the distance of two bodies."""
    name = _name_quantity(item)
    return "" if name == item.axis or (item.quantity and not item.axis) else name.removesuffix(f" ({item.axis})")


def describe_other(item: Finding) -> str:
    """By how much and in which lines a finding beside the worst one breaks its limit."""
    last = item.last_line or item.line
    where = f"line {item.line}" if last == item.line else f"lines {item.line} to {last}"
    what = f"{_name_quantity(item)} "
    if item.value is None or item.limit is None:
        return f"{what}in {where}"
    unit = f" {item.unit}" if item.unit else ""
    excess = find_excess(item)
    return f"{what}by {excess:.{choose_decimals(excess, item.unit)}f}{unit} in {where}"
