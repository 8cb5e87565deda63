"""Where the time goes: by limit, by tool and operation, and at which share of the feed rate."""

import itertools
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from verne_post.app.line_facts import AT_FEED
from verne_post.base.numbers import format_fixed
from verne_post.model.machine import Machine
from verne_post.model.part_setup import spell_tool_word
from verne_post.report.governing import FEED_BANDS, HIGHER
from verne_post.report.markup import Row, escape_text, write_table
from verne_post.report.table import Governing, Operation, Study

#: A way to win time is named where it concerns such a share of the program.
_WORTH_A_WORD: Final = 0.005
#: So many operations are shown, the longest, or those that differ most; the rest stands in one row.
OPERATIONS: Final = 200


def write_governing_html(machine: Machine, study: Study) -> str:
    """Seconds that each limit governs, what it costs, and what more of it would win."""
    governing = study.governing
    if governing is None:
        return ""
    order = [k for k in np.argsort(-governing.seconds) if governing.seconds[k] > 0]
    columns = (governing.seconds, governing.rapid, governing.lost, governing.at_stops)
    rows: list[Row] = [
        (governing.names[k], *(f"{column[k]:.3f}" for column in (*columns, governing.won))) for k in order
    ]
    rows.append(("all", *(f"{column.sum():.3f}" for column in columns), ""))
    keys = [*order, None]
    body = "".join(
        f"<tr><th scope=row>{'' if key is None else f'<i data-limit={key}></i>'}{escape_text(row[0])}</th>"
        + "".join(f"<td>{cell}</td>" for cell in row[1:])
        + "</tr>"
        for key, row in zip(keys, rows, strict=True)
    )
    more = f"saved by {100.0 * (HIGHER - 1.0):.0f} % more"
    table = write_table(("limit", "governs", "in rapids", "lost", "lost near stops", more), body)
    ways = "".join(f"<li>{escape_text(way)}</li>" for way in _list_ways_to_win(machine, study, governing))
    return table + (f"<ul class=ways>{ways}</ul>" if ways else "")


def _list_ways_to_win(machine: Machine, study: Study, governing: Governing) -> Iterator[str]:
    """What would win lost time back, the largest loss first: one sentence for each kind of limit that costs much."""
    rotary = {f"velocity of {column.joint}" for column in machine.columns if column.unit == "deg"}
    between = dict(zip(governing.names, governing.lost - governing.at_stops, strict=True))
    kinds = {name: "turning" if name in rotary else name.partition(" ")[0] for name in between if " of " in name}
    sums = {kind: sum(between[name] for name in kinds if kinds[name] == kind) for kind in kinds.values()}
    ways = (
        (governing.at_stops.sum(), "near stops. Blended corners (G64) have no stop."),
        (sums["turning"], "to the velocity of rotary axes. Let the tool axis turn less for each mm of path."),
        (
            sums.get("velocity", 0.0),
            "to the velocity of other joints. Another place of the part may help: verne-post fit searches for it.",
        ),
        (
            sums["acceleration"] + sums["jerk"],
            "to acceleration and jerk between stops. Allow a larger corner tolerance, or program fewer and rounder "
            "corners.",
        ),
    )
    for lost, words in sorted(ways, reverse=True):
        if lost >= _WORTH_A_WORD * study.x[-1]:
            yield f"{lost:.3f} s are lost {words}"


def write_times_html(study: Study) -> str:
    """Time by tool and by operation; an entry leads to where the operation begins."""
    if not study.operations:
        return ""
    program = study.program
    assert program is not None
    names, body = program.moves.name_tools(), []
    shown = sorted(study.operations, key=lambda one: -one.seconds)[:OPERATIONS]
    for tool in dict.fromkeys(one.tool for one in study.operations):
        of_tool = [one for one in study.operations if one.tool == tool]
        head = spell_tool_word(tool, names) if tool else "no tool named"
        body.append(f"<tr class=tool><th scope=row>{escape_text(head)}</th><td></td>{_write_spent(of_tool)}</tr>")
        body += [
            '<tr><th scope=row><button type="button" '
            f'data-frame="{one.frame}">{escape_text(one.name or one.tool_remark or "without a remark")}</button></th>'
            f"<td>{_name_lines(one)}</td>{_write_spent([one])}</tr>"
            for one in of_tool
            if one in shown
        ]
        rest = [one for one in of_tool if one not in shown]
        if rest:
            body.append(f"<tr><th scope=row>{len(rest)} shorter operations</th><td></td>{_write_spent(rest)}</tr>")
    body.append(f"<tr class=tool><th scope=row>all</th><td></td>{_write_spent(study.operations)}</tr>")
    heads = ("tool and operation", "lines", "time, s", "feed, s", "rapids, s", "standing, s", "lost, s")
    return write_table(heads, "".join(body))


def _write_spent(operations: Sequence[Operation]) -> str:
    seconds, rapid, standing, lost = (
        sum(getattr(one, name) for one in operations) for name in ("seconds", "rapid", "standing", "lost")
    )
    cells = (seconds, seconds - rapid - standing, rapid, standing, lost)
    return "".join(f"<td>{format_fixed(cell, 3)}</td>" for cell in cells)


def _name_lines(one: Operation) -> str:
    if not one.last_line:
        return "approach"
    return str(one.first_line) if one.first_line == one.last_line else f"{one.first_line} to {one.last_line}"


def write_reached_html(study: Study) -> str:
    """How long feed moves reach which share of the programmed feed rate, as bars."""
    governing = study.governing
    if governing is None or not governing.reached.any():
        return ""
    whole, most = governing.reached.sum(), governing.reached.max()
    ends = [*(100.0 * k / FEED_BANDS for k in range(FEED_BANDS)), 100.0 * AT_FEED]
    names = [f"{low:.0f} to {high:.0f} %" for low, high in itertools.pairwise(ends)] + [f"{ends[-1]:.0f} % or more"]
    rows = "".join(
        f"<tr><th scope=row>{name}</th><td><i style='width:{100.0 * seconds / most:.1f}%'></i></td>"
        f"<td>{seconds:.3f}</td><td>{100.0 * seconds / whole:.1f}</td></tr>"
        for name, seconds in zip(reversed(names), reversed(governing.reached.tolist()), strict=True)
    )
    return write_table(("share", "<span class=unseen>bar</span>", "s", "%"), rows)
