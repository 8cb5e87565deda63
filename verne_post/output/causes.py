"""Findings for people, one for each cause: the worst place of a limit, and beside it the others that go with it.

Findings as such are exact: one for each joint and stretch of moves. A part zero that is wrong breaks the same limit in
many stretches, and limits of several joints in the same moves. For people that is one thing to settle.
"""

import dataclasses
import re
from collections.abc import Iterator, Sequence
from typing import Final

from msgspec import Struct

from verne_post.model.findings import Finding
from verne_post.model.verdict import Family, find_family

#: Beside travel and reach (VP1xx): singularities, and the height over the table. Each contact with a body stays alone.
_OF_THE_WORKSPACE: Final = ("VP201", "VP202", "VP203", "VP210")


class Cause(Struct, frozen=True):
    """Findings that one thing settles."""

    worst: Finding  #: With the remedies of all of them.
    others: tuple[Finding, ...]  #: By line.
    indices: tuple[int, ...]  #: Their places among the findings: of the worst one, then of the others.

    def describe_others(self) -> str:
        """By how much and in which lines the others break their limits, the worst place of each joint; or nothing."""
        of_joints: dict[str | None, list[Finding]] = {}
        for item in self.others:
            of_joints.setdefault(item.axis, []).append(item)
        return "; ".join(map(_describe_places, of_joints.values()))


def find_causes(findings: Sequence[Finding]) -> list[Cause]:
    """Findings by their causes, in the order of the worst ones, whose lines are shown.

    Findings of one code and severity are one where they break the same limit, or limits of several joints in the same
    lines. A remedy that several causes share is told at the first one.
    """
    groups = [(max(group, key=lambda one: (find_excess(findings[one]), -one)), group) for group in _group(findings)]
    told: dict[str, Finding] = {}
    causes = []
    for worst, group in sorted(groups):
        shared = dict.fromkeys(text for one in group for text in findings[one].remedies)
        remedies = tuple(dict.fromkeys(_name_remedy(text, told) for text in shared))
        head = dataclasses.replace(findings[worst], remedies=remedies)
        told |= {text: head for text in shared if text not in told}
        others = [one for one in group if one != worst]
        causes.append(Cause(head, tuple(findings[one] for one in others), (worst, *others)))
    return causes


def list_worst(findings: Sequence[Finding]) -> Iterator[Finding]:
    """The worst finding of each cause."""
    return (cause.worst for cause in find_causes(findings))


def find_first_error(findings: Sequence[Finding]) -> Finding | None:
    """The worst finding of the first cause that refuses a program; None where none does."""
    return next((item for item in list_worst(findings) if item.severity == "error"), None)


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
        if item.axis is None or item.line is None or not _is_of_the_workspace(item):
            continue
        end, other = furthest.get((item.code, item.severity), (-1, index))
        if item.line <= end and group_of[other] is not group_of[index]:
            united = sorted(group_of[other] + group_of[index])
            for one in united:
                group_of[one] = united
        if (item.last_line or item.line) > end:
            furthest[item.code, item.severity] = (item.last_line or item.line, index)
    return list({id(group): group for group in group_of}.values())


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


def describe_other(item: Finding) -> str:
    """By how much and in which lines a finding beside the worst one breaks its limit."""
    last = item.last_line or item.line
    where = f"line {item.line}" if last == item.line else f"lines {item.line} to {last}"
    if item.value is None or item.limit is None:
        return where
    what = f"{item.axis} " if item.axis else ""
    unit = f" {item.unit}" if item.unit else ""
    return f"{what}by {find_excess(item):.6f}{unit} in {where}"
