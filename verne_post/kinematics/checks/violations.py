"""What is checked, the worst violation of it on each element, and the findings that report it."""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array, Ints
from verne_post.base.numbers import choose_decimals, format_fixed
from verne_post.base.tolerances import LIMIT_SLACK, LIMIT_SLACK_MM
from verne_post.model.codes import CODES
from verne_post.model.contour import Contour
from verne_post.model.findings import Finding, make_finding
from verne_post.model.machine import Machine
from verne_post.model.protocols import Carrying, FiveAxis
from verne_post.model.verdict import Severity

#: So many stretches of lines are named in a finding of several.
NAMED_STRETCHES: Final = 4
#: Why a pose has no solution, by finding code; other codes say what they mean in general.
_UNREACHABLE: Final = {
    "VP110": "out of reach: no slider position satisfies the rod lengths",
    "VP201": "the rods of leg I would cross: R1 cos(alpha) <= r1 in every solution",
    "VP203": "out of reach: beyond a parallel singularity in every solution",
}


class Check(Struct, frozen=True):
    """One bound on one quantity: ``sign * (value - limit)`` must not be below zero."""

    code: str  #: Of the finding.
    name: str
    axis: str | None  #: The joint concerned.
    quantity: int  #: Column of the quantities.
    sign: float
    #: limit, warn: The bound, and a weaker one below which a warning is due.
    limit: float
    warn: float
    slack: float  #: A value may be beyond the bound by this.
    unit: str
    factor: float  #: From the inside unit to the one that is shown.
    travel: tuple[float, float] | None = None  #: Of a joint, both ends; None of other quantities.


class Worst(Struct, frozen=True):
    """Collects the worst margin and value of one check for each element that violates it."""

    #: Margin, value, and the parameter w of the element where they are.
    by_element: dict[int, tuple[float, float, float]] = field(default_factory=dict)

    def note(self, element: Ints, margin: Array, value: Array, w: Array | None = None) -> None:
        """Keep the smallest margins, the values that have them, and where; all (n,).

        Without ``w`` the end: the line of the element itself is at fault, not the one before.
        """
        at = np.ones(len(element)) if w is None else w
        for e, m, v, place in zip(element.tolist(), margin.tolist(), value.tolist(), at.tolist(), strict=True):
            if e not in self.by_element or m < self.by_element[e][0]:
                self.by_element[e] = (m, v, place)


def list_machine_checks(machine: Machine) -> list[Check]:
    """The bounds of a machine, from its limits and the margins of its module."""
    checks = []
    for joint, column in enumerate(machine.columns):
        slack = LIMIT_SLACK_MM if column.unit == "mm" else LIMIT_SLACK
        for sign, limit in ((1.0, machine.limits.lower[joint]), (-1.0, machine.limits.upper[joint])):
            if np.isfinite(limit):
                checks.append(
                    Check(
                        column.code,
                        CODES[column.code].title,
                        column.joint,
                        joint,
                        sign,
                        float(limit),
                        float(limit),
                        slack,
                        column.unit,
                        column.factor,
                        (float(machine.limits.lower[joint]), float(machine.limits.upper[joint])),
                    )
                )
    n = len(machine.columns)
    for index, margin in enumerate(machine.margins):
        checks.append(
            Check(
                margin.code,
                margin.name,
                margin.axis,
                n + index,
                1.0,
                margin.error_below,
                margin.warn_below,
                LIMIT_SLACK_MM,
                margin.unit,
                1.0,
            )
        )
    return checks


# --- findings: one for each stretch of consecutive violating elements, or for each cause ------------


def report_limit(contour: Contour, check: Check, worst: Worst, cause: Ints | None = None) -> list[Finding]:
    """Findings of one check: errors beyond its limit, warnings beyond its weaker bound.

    Parameters
    ----------
    cause : ndarray of int, shape (n_elements,), or None
        All stretches with one cause are one finding.
    """
    value_of = {element: value for element, (_margin, value, _w) in worst.by_element.items()}
    place_of = {element: w for element, (_margin, _value, w) in worst.by_element.items()}
    bad = [element for element, v in value_of.items() if check.sign * (v - check.limit) < -check.slack]
    levels: list[tuple[Severity, list[int], float]] = [("error", bad, check.limit)]
    if check.warn == check.limit:
        levels = [("error", list(value_of), check.limit)]
    else:
        levels.append(("warning", [element for element in value_of if element not in set(bad)], check.warn))
    findings = []
    what = check.axis if check.code.startswith("VP10") and check.axis else check.name
    if check.code in ("VP202", "VP214") and check.axis:
        what = f"{check.name} ({check.axis})"
    unit = f" {check.unit}" if check.unit else ""
    for severity, elements, limit in levels:
        for group in _split_stretches(elements) if cause is None else _split_causes(elements, cause):
            at = min(group, key=lambda element: check.sign * value_of[element])
            value, bound = value_of[at] * check.factor, limit * check.factor
            side = "below" if value <= bound else "above"
            decimals = choose_decimals(abs(value - bound), check.unit)
            contact = _CONTACT.fullmatch(check.name) if check.code == "VP215" else None
            if contact is not None:
                body, fixture = contact.groups()
                far = format_fixed(abs(value), max(decimals, choose_decimals(abs(value), check.unit)))
                how = f"goes {far}{unit} into" if value < -LIMIT_SLACK_MM else f"comes to {far}{unit} from"
                # surfaces of meshes that meet have no depth
                message = f"{body} {how if abs(value) > LIMIT_SLACK_MM else 'runs into'} fixture '{fixture}'"
                message += f"; it must stay {bound:g}{unit} away" if bound else ""
            elif check.travel is None:
                message = (
                    f"{what} {format_fixed(value, decimals)}{unit} is {side} {bound:g}{unit} by "
                    f"{abs(value - bound):.{decimals}f}{unit}"
                )
            else:
                message = _describe_travel(check, value, bound)
            stretches = "" if cause is None else _describe_stretches(contour, group)
            findings.append(
                _make_finding(
                    contour,
                    group,
                    (at, place_of),
                    check.code,
                    message + stretches,
                    names_lines=bool(stretches),
                    severity=severity,
                    axis=check.axis,
                    value=value,
                    limit=bound,
                    unit=check.unit,
                    quantity=what if check.code == "VP215" or what.endswith(f"({check.axis})") else "",
                )
            )
    return findings


#: The distance of a body from another one: below 0 the one is inside the other.
_CONTACT: Final = re.compile("distance of (the .+?) from (.+)")
#: What people call the joints of that name.
_SLIDER: Final = re.compile(r"rho(\d+)")


def _describe_travel(check: Check, value: float, bound: float) -> str:
    """``slider 1 (rho1) reaches 1262.413 mm, 12.413 mm above its travel of 50 to 1250 mm``."""
    excess = abs(value - bound)
    decimals = choose_decimals(excess, check.unit)
    low, high = sorted(end * check.factor for end in check.travel or ())
    travel = (
        f"travel of {low:g} to {high:g}"
        if np.isfinite([low, high]).all()
        else f"{'least' if np.isfinite(low) else 'greatest'} value, {bound:g}"
    )
    slider = _SLIDER.fullmatch(check.axis or "")
    name = f"slider {slider[1]} ({check.axis})" if slider else f"joint {check.axis}"
    side = "below" if value <= bound else "above"
    return (
        f"{name} reaches {format_fixed(value, decimals)} {check.unit}, {excess:.{decimals}f} {check.unit} {side} its "
        f"{travel} {check.unit}"
    )


def report_table(contour: Contour, below: Mapping[str, Worst]) -> list[Finding]:
    """VP210, with the name of what is lowest."""
    findings = []
    lowest = {
        element: min((*worst.by_element[element], name) for name, worst in below.items() if element in worst.by_element)
        for element in set().union(*(worst.by_element for worst in below.values()))
    }
    for group in _split_stretches(lowest):
        at = min(group, key=lambda element: lowest[element][0])
        _margin, value, _w, name = lowest[at]
        place_of = {one: lowest[one][2] for one in group}
        depth = format_fixed(-value, choose_decimals(-value, "mm"))
        message = f"{name} {depth} mm below the table face, inside the table's radius"
        findings.append(
            _make_finding(contour, group, (at, place_of), "VP210", message, value=value, limit=0.0, unit="mm")
        )
    return findings


def report_unreachable(
    contour: Contour, unreachable: dict[int, tuple[str, float]], five_axis: FiveAxis
) -> list[Finding]:
    """Findings of elements that cannot be solved, given with the code of the reason, and the parameter where."""
    said = dict(_UNREACHABLE)
    if isinstance(five_axis, Carrying):
        said["VP110"] = f"out of reach: {five_axis.no_reach}"
    return [
        _make_finding(
            contour,
            group,
            (group[0], {group[0]: unreachable[group[0]][1]}),
            code,
            said.get(code, CODES[code].meaning),
            severity="error",
        )
        for code in sorted({code for code, _w in unreachable.values()})
        for group in _split_stretches(element for element, (why, _w) in unreachable.items() if why == code)
    ]


def _make_finding(
    contour: Contour,
    group: list[int],
    worst: tuple[int, Mapping[int, float]],
    code: str,
    message: str,
    **values: object,
) -> Finding:
    """A finding on the lines of a group of elements; it counts their segments.

    Its line is the one that has to be changed for the first element: there a person begins to correct.

    Parameters
    ----------
    worst : int, mapping
        The worst element, and for it and the first one the parameter where each is worst.
    """
    element, place_of = worst
    path = contour.path
    first, at = (find_culprit(contour, one, place_of[one]) for one in (group[0], element))
    line, worst, last = path.number_lines(np.array([first, at, contour.segment[group[-1]]])).tolist()
    count = len(np.unique(contour.segment[group]))
    item = make_finding(code, message, line=line, last_line=last, worst_line=worst, count=count, **values)
    return path.called_lines.place(item)


def find_culprit(contour: Contour, element: int, w: float) -> int:
    """The segment whose source line has to be changed where element ``element`` is wrong at its parameter ``w``.

    A segment only begins where the one before it was programmed to end. So that one is named for what is wrong there,
    or in the blend of the corner between them; but what is worst where that blend ends is due to its own line.
    """
    segment, path = int(contour.segment[element]), contour.path
    before = segment - 1
    first = int(np.searchsorted(contour.segment, segment))
    if w >= 1.0 or not first or contour.segment[first - 1] != before or path.move[before] < 0:
        return segment
    u = float(contour.find_parameters(np.array([element]), np.array([w]))[0])
    reach = 0.0 if contour.corners is None else float(contour.corners.reach[segment + contour.corners.shift])
    if u > 0.5 or u * path.length[segment] > reach:
        return segment
    # another length of the tool, or another place of the part, is what the later line brings
    joined = np.abs(path.end[before, :3] - path.start[segment, :3]).max() <= LIMIT_SLACK_MM
    same = path.tool_length[before] == path.tool_length[segment]
    return before if joined and same else segment


def _split_causes(elements: Iterable[int], cause: Ints) -> Iterator[list[int]]:
    """The numbers by their cause, in their order."""
    groups: dict[int, list[int]] = {}
    for element in sorted(elements):
        groups.setdefault(int(cause[element]), []).append(element)
    yield from groups.values()


def _describe_stretches(contour: Contour, group: list[int]) -> str:
    """Which lines a group of elements is on, where they are not consecutive."""
    stretches = list(_split_stretches(group))
    if len(stretches) == 1:
        return ""
    ends = contour.find_lines(np.array([(one[0], one[-1]) for one in stretches[:NAMED_STRETCHES]]).ravel()).reshape(
        -1, 2
    )
    named = [f"{first}-{last}" if last > first else f"{first}" for first, last in ends.tolist()]
    left = " and on" if len(stretches) > NAMED_STRETCHES else ""
    return f", in {len(stretches)} stretches: lines {', '.join(dict.fromkeys(named))}{left}"


def _split_stretches(elements: Iterable[int]) -> Iterator[list[int]]:
    """Maximal groups of consecutive numbers."""
    group: list[int] = []
    for element in sorted(elements):
        if group and element != group[-1] + 1:
            yield group
            group = []
        group.append(element)
    if group:
        yield group
