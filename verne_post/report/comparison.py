"""The page of two programs, or two versions of one: what differs in time, findings, limits, operations and lines."""

import sys
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.long_text import Text, compute_sha256
from verne_post.base.numbers import format_fixed
from verne_post.model.findings import Finding
from verne_post.model.machine import Machine
from verne_post.model.moves import MoveKind
from verne_post.model.part_setup import spell_tool_word
from verne_post.model.verdict import SEVERITIES
from verne_post.output.causes import count_causes, find_causes
from verne_post.output.commands import find_run
from verne_post.output.findings import list_remedies
from verne_post.report.alignment import Stretch, align_lines
from verne_post.report.head import list_setup, name_verdict, write_title_html
from verne_post.report.markup import (
    count,
    escape_code,
    escape_names,
    escape_text,
    join_few,
    write_css_string,
    write_table,
)
from verne_post.report.modal import describe_feed
from verne_post.report.pack import Pack
from verne_post.report.page import fill_page, write_json_in_html
from verne_post.report.sheet import DIGEST
from verne_post.report.table import Operation, Study
from verne_post.report.times import OPERATIONS
from verne_post.report.worst import TIME_LOST, find_worst_places, quote_line

#: So many stretches of lines are shown, those whose times differ most; and so many lines of the text of each.
_STRETCHES: Final = 40
_LINES: Final = 6
#: Characters of a line that are shown.
_LINE_CHARACTERS: Final = 90
#: Times that differ by less are the same: rows are a cycle apart.
_SAME_S: Final = 5e-4
#: Lines of the same text whose times differ by less have one row together: beside a change, motion is planned anew.
_SMALL_S: Final = 5e-3
_PARTS: Final = ("style.css", "shared.js", "charts.js", "paths.js", "comparison.js")
#: Shown where a side has nothing.
_NONE: Final = "–"


class Side(Struct, frozen=True, eq=False):
    """A program with what came of it, and its lines."""

    program: str
    source: Text
    machine: Machine
    study: Study
    lines: Sequence[bytes]


def make_side(program: str, source: Text, machine: Machine, study: Study) -> Side:
    """Split the text of one of the programs."""
    return Side(program, source, machine, study, source[:].split(b"\n"))


def write_comparison(sides: tuple[Side, Side]) -> str:
    """Write the page."""
    a, b = sides
    stretches = align_lines(a.lines, b.lines)
    different = _name_different_lines(stretches)
    pack = Pack()
    data: dict[str, Any] = {"sides": [_pack_side(pack, name, side) for name, side in zip("ab", sides, strict=True)]}
    data["arrays"] = pack.contents
    title = f"{a.program} and {b.program}"
    return fill_page(
        "comparison.html",
        _PARTS,
        {
            "title": escape_text(title),
            "foot": write_css_string(f"{title}, page "),
            "heads": "".join(_write_head_html(name, side) for name, side in zip("AB", sides, strict=True)),
            "outcome": escape_text(_describe_outcome(sides)),
            **_name_paths(sides),
            "text_differs": f" <small>{escape_text(different)}</small>" if different else "",
            "facts": _write_facts_html(sides),
            "findings": _write_findings_html(sides, stretches),
            "limits": _write_limits_html(sides),
            "operations": _write_operations_html(sides),
            "lines": _write_lines_html(sides, stretches),
            "data": write_json_in_html(data),
            "bytes": pack.encode(),
        },
    )


def _pack_side(pack: Pack, name: str, side: Side) -> dict[str, Any]:
    """Pack the path of the tip, its speed and what governs, for the picture and the curves."""
    study = side.study
    tick = study.summary.format.cycle if study.summary is not None else 1.0
    for curve in ("feed", "speed") if study.timed else ():
        pack.add_curves(f"{name}.{curve}", study.curves[curve], tick, np.ones(1))
    pack.add(f"{name}.trail", study.trail.tip)
    pack.add(f"{name}.rapid", study.trail.rapid, "|u1")
    if study.governing is not None:
        pack.add(f"{name}.x", study.x, "<f8")
        pack.add(f"{name}.tip", study.tip)
        pack.add(f"{name}.line", study.line, "<i4")
        pack.add(f"{name}.governing", study.governing.of_frame, "|u1")
    return {
        "name": name,
        "program": side.program,
        "timed": study.timed,
        "tick": tick,
        "end": float(study.x[-1]) if study.timed else 0.0,
        "joints": len(side.machine.columns),
        "limits": list(study.governing.names) if study.governing is not None else [],
    }


def _name_different_lines(stretches: Sequence[Stretch]) -> str:
    """How many lines differ, and which: those of A, or of B where A has none; empty where none does."""
    spans = [
        (one.first_a + 1, one.last_a, "") if one.last_a > one.first_a else (one.first_b + 1, one.last_b, " of B")
        for one in stretches
        if not one.same
    ]
    number = sum(last - first + 1 for first, last, _side in spans)
    names = [f"{first}{f' to {last}' if last > first else ''}{side}" for first, last, side in spans]
    said = "one line differs" if number == 1 else f"{number} lines differ"
    return f"{said}: {join_few(names, 'more below')}" if spans else ""


def _write_head_html(name: str, side: Side) -> str:
    word, kind = name_verdict(side.machine, side.study)
    return (
        f"<div><h2>{name}: "
        f'{write_title_html(side.program, side.machine)}</h2><strong class="{kind}">{word}</strong></div>'
    )


def _name_paths(sides: tuple[Side, Side]) -> dict[str, str]:
    """Titles of the picture: a program that cannot be read has no path, and one that is refused no times."""
    drawn = [name for name, side in zip("AB", sides, strict=True) if len(side.study.trail.tip)]
    both, timed = len(drawn) == 2, all(side.study.timed for side in sides)
    return {
        "paths": "Both tool paths" if both else f"Tool path of {''.join(drawn)}",
        "paths_about": "on the table" + ", with the tips at the same time" * timed,
        "paths_label": "tool paths of A, wide, and B, narrow, in one view" if both else "tool path",
    }


def _describe_outcome(sides: tuple[Side, Side]) -> str:
    """Which one is faster, and by how much; the verdicts where one has no time."""
    one, other = (side.study.summary for side in sides)
    if one is None or other is None:
        words = (
            name_verdict(side.machine, side.study)[0].lower()
            + (f", {side.study.summary.cycle_time:.3f} s" if side.study.summary is not None else "")
            for side in sides
        )
        return "; ".join(f"{name}: {word}" for name, word in zip("AB", words, strict=True))
    times = one.cycle_time, other.cycle_time
    difference = _compute_difference(*times)
    if not difference:
        return f"A and B take the same time, {times[0]:.3f} s"
    more = "longer" if difference > 0 else "less"
    share = f" ({100.0 * difference / times[0]:+.1f} %)" if times[0] else ""
    return f"B takes {abs(difference):.3f} s {more} than A: {times[1]:.3f} s against {times[0]:.3f} s{share}"


def _write_row(head: str, cells: Sequence[str], *, marked: bool = False) -> str:
    """Write a row whose cells are HTML already."""
    body = "".join(f"<td>{cell}</td>" for cell in cells)
    return f"<tr{' class=differs' if marked else ''}><th scope=row>{head}</th>{body}</tr>"


def _write_times(
    head: str,
    pairs: Sequence[tuple[float | None, float | None]],
    *,
    marked: bool = False,
    judged: Sequence[int] = (0, 1),
) -> str:
    """Write a row of times: both sides and the difference of each pair, coloured where less is better."""
    cells = []
    for k, (one, other) in enumerate(pairs):
        cells += [_NONE if each is None else format_fixed(each, 3) for each in (one, other)]
        cells.append(_write_difference(one, other, judged=k in judged))
    return _write_row(head, cells, marked=marked)


def _compute_difference(one: float, other: float) -> float:
    """Subtract the times as the page shows them: a reader who subtracts them finds the same."""
    return round(round(other, 3) - round(one, 3), 3)


def _write_difference(one: float | None, other: float | None, *, judged: bool = True) -> str:
    if one is None or other is None:
        return ""
    difference = _compute_difference(one, other)
    if not difference:
        return "same"
    kind = "plain" if not judged else "slower" if difference > 0 else "faster"
    return f"<b class={kind}>{difference:+.3f}</b>"


# --- facts -------------------------------------------------------------------------------------------------


def _write_facts_html(sides: tuple[Side, Side]) -> str:
    """A table of what differs, times first; below it in one sentence what is the same."""
    rows, same = [], []
    timed = all(side.study.timed for side in sides)
    for what, (one, other) in _match_numbers([_list_times(side) for side in sides]):
        if one is None or other is None:
            continue  # the outcome says why, and which time the other one has
        if _compute_difference(one, other):
            rows.append(_write_times(f"{what}, s", [(one, other)]))
        else:
            same.append(f"{what} {one:.3f} s")
    facts = [_list_facts(side) for side in sides]
    for what in dict.fromkeys(key for each in facts for key in each):
        if not all(what in each for each in facts) and None in (sides[0].study.summary, sides[1].study.summary):
            continue  # nobody could check it on the other side
        texts = [each.get(what, _NONE) for each in facts]
        if texts[0] == texts[1]:
            same.append(f"{what} {texts[0]}")
        else:
            cells = [f"<span class=whole>{text}</span>" if "SHA" in what else escape_names(text) for text in texts]
            rows.append(_write_row(escape_text(what), cells + [""] * timed))
    table = (
        write_table(("what", "A", "B", *["B - A"] * timed), "".join(rows)) if rows else "<p>None of these numbers.</p>"
    )
    return table + (f"<p>The same in both: {escape_text('; '.join(same))}.</p>" if same else "")


def _match_numbers(numbers: Sequence[dict[str, float]]) -> Iterator[tuple[str, tuple[float | None, float | None]]]:
    """By name, those of the first first; a side that has none of a name has None."""
    one, other = numbers
    for name in dict.fromkeys([*one, *other]):
        yield name, (one.get(name), other.get(name))


def _list_times(side: Side) -> dict[str, float]:
    study = side.study
    if study.summary is None or study.governing is None:
        return {}
    return {
        "time": study.summary.cycle_time,
        "motion": study.summary.motion_time,
        "dwells": study.summary.dwell_time,
        "standing at stops": study.summary.stop_time,
        "rapids": sum(one.rapid for one in study.operations),
        "lost against the feed rate": float(study.governing.lost.sum()),
        "lost near stops": float(study.governing.at_stops.sum()),
    }


def _list_facts(side: Side) -> dict[str, str]:
    study = side.study
    errors, warnings = count_causes(study.findings)
    facts = {
        "findings": f"{count(errors, 'error')}, {count(warnings, 'warning')}",
        **{
            place.what: f"{place.value} ({place.about})" if place.about else place.value
            for place in find_worst_places(side.machine, study)
            if place.what != TIME_LOST  # the table of lines compares these
        },
        **dict(list_setup(side.machine, study, sys.maxsize)),  # this page has no set-up sheet
    }
    if study.summary is not None:
        facts["stops"] = str(study.summary.n_stops)
        facts["blended corners"] = str(study.summary.n_blended)
    facts["set-up"] = study.options.setup_source or "none"
    facts["machine"] = side.machine.name
    facts["machine, SHA-256"] = side.machine.sha256[:DIGEST]
    facts["program, SHA-256"] = compute_sha256(side.source)[:DIGEST]
    return facts


# --- findings ----------------------------------------------------------------------------------------------


def _write_findings_html(sides: tuple[Side, Side], stretches: Sequence[Stretch]) -> str:
    """Which causes are in one program alone, and which in both: same code and joint, at corresponding lines."""
    keyed = [
        [(_make_key(one.first, stretches, first=number == 0), one) for one in find_causes(side.study.findings)]
        for number, side in enumerate(sides)
    ]
    shared = Counter(key for key, _cause in keyed[0]) & Counter(key for key, _cause in keyed[1])
    texts = []
    for name, side, found in zip("AB", sides, keyed, strict=True):
        left = shared.copy()
        alone, both = list[str](), list[str]()
        for key, cause in sorted(found, key=lambda one: SEVERITIES.index(one[1].first.severity)):
            item, others = cause.first, cause.describe_others()
            into, where = (both, "in both") if left[key] > 0 else (alone, f"only in {name}")
            left[key] -= left[key] > 0
            text = escape_text(str(item)) + quote_line(item, side.source)
            also = [f"also {others}"] if others else []
            remedies = list_remedies(item, side.program, find_run(side.study.options))
            helps = "".join(f"<small>{escape_text(one)}</small>" for one in (where, *also, *remedies))
            into.append(f'<li class="{item.severity}"><span>{text}{helps}</span></li>')
        entries = "".join(alone + both)
        texts.append(f"<div><h3>{name}</h3><ul class=findings>{entries or '<li>no findings</li>'}</ul></div>")
    return "".join(texts)


def _make_key(item: Finding, stretches: Sequence[Stretch], *, first: bool) -> tuple[Any, ...]:
    """What findings of both sides share: code, joint, and the line, or the stretch of lines that differ."""
    if item.line is None:
        return item.code, item.axis, item.severity
    k = bisect_left(stretches, item.line, key=lambda one: one.last_a if first else one.last_b)
    one = stretches[k]
    return (
        item.code,
        item.axis,
        item.severity,
        k,
        item.line - (one.first_a if first else one.first_b) if one.same else 0,
    )


# --- limits and operations -----------------------------------------------------------------------------------


def _write_limits_html(sides: tuple[Side, Side]) -> str:
    """Seconds that each limit governs and costs."""
    if without := _name_without_times(sides):
        return without
    both = [side.study.governing for side in sides]
    columns = [
        [{} if one is None else dict(zip(one.names, getattr(one, name).tolist(), strict=True)) for one in both]
        for name in ("seconds", "lost")
    ]
    governs, lost = (dict(_match_numbers(column)) for column in columns)
    names = [name for name, pair in governs.items() if any(pair)]
    names.sort(key=lambda name: -max(value or 0.0 for value in governs[name]))
    rows = "".join(_write_times(escape_text(name), [governs[name], lost[name]], judged=[1]) for name in names)
    heads = ("limit", "A governs, s", "B governs, s", "B - A", "A lost, s", "B lost, s", "B - A")
    return write_table(heads, rows)


def _name_without_times(sides: tuple[Side, Side]) -> str:
    """Which side has no times to be compared; nothing where both have."""
    names = [name for name, side in zip("AB", sides, strict=True) if not side.study.timed]
    return f"<p>There is nothing to compare: {' and '.join(names)} cannot run, so no times are known.</p>" * bool(names)


def _write_operations_html(sides: tuple[Side, Side]) -> str:
    """Time of each operation, paired by tool and remark; repeated pairs are matched in their order."""
    if without := _name_without_times(sides):
        return without
    times, losses = (
        dict(
            _match_numbers(
                [{head: getattr(one, name) for head, one in _number_operations(side).items()} for side in sides]
            )
        )
        for name in ("seconds", "lost")
    )

    def compare(head: str) -> float:
        one, other = times[head]
        return abs((other or 0.0) - (one or 0.0))

    shown = set(sorted(times, key=compare, reverse=True)[:OPERATIONS])
    rows = "".join(
        _write_times(escape_text(head), [times[head], losses[head]], marked=None in times[head])
        for head in times
        if head in shown
    )
    if len(shown) < len(times):
        rest = [
            [sum(pair[k] or 0.0 for head, pair in each.items() if head not in shown) for k in (0, 1)]
            for each in (times, losses)
        ]
        rows += _write_times(
            f"{len(times) - len(shown)} operations whose times differ less", [(one, other) for one, other in rest]
        )
    heads = ("tool and operation", "A, s", "B, s", "B - A", "A lost, s", "B lost, s", "B - A")
    return write_table(heads, rows)


def _number_operations(side: Side) -> dict[str, Operation]:
    program, seen, found = side.study.program, Counter[str](), {}
    names = {} if program is None else program.moves.name_tools()
    for one in side.study.operations:
        tool = spell_tool_word(one.tool, names) if one.tool else "no tool named"
        head = f"{tool}: {one.name or one.tool_remark or 'without a remark'}"
        seen[head] += 1
        found[head if seen[head] == 1 else f"{head} ({seen[head]})"] = one
    return found


# --- lines -------------------------------------------------------------------------------------------------


def _write_lines_html(sides: tuple[Side, Side], stretches: Sequence[Stretch]) -> str:
    """Stretches of different lines, and equal ones with other times; the largest differences, in program order."""
    timed = all(side.study.timed for side in sides)
    spent = [_sum_times(side) for side in sides]
    worth: list[tuple[float, Stretch]] = []
    for one in stretches:
        if one.same and not timed:
            continue  # the side that is refused has no times
        for part in _cut_by_times(one, *spent) if one.same else [one]:
            times = spent[0][part.last_a] - spent[0][part.first_a], spent[1][part.last_b] - spent[1][part.first_b]
            worth.append((abs(times[1] - times[0]), part))
    small = [part for seconds, part in worth if part.same and seconds < _SMALL_S]
    worth = [(seconds, part) for seconds, part in worth if not part.same or seconds >= _SMALL_S]
    shown = sorted(sorted(range(len(worth)), key=lambda k: -worth[k][0])[:_STRETCHES])
    left = len(worth) - len(shown)
    note = f"<p>Not shown: {count(left, 'place')} whose times differ less.</p>" if left else ""
    heads = ("A", "B", "A, s", "B, s", *["B - A"] * timed, "feed rate and limit")
    if not shown and not small:
        return f"<p>The same text{', and the same times' if timed else ''}.</p>"
    # equal texts among lines that differ look like a mistake of the comparison
    tables = []
    for title, same in (("Other text", False), ("Same text, other time", True)):
        rows = "".join(_write_stretch(sides, worth[k][1], spent) for k in shown if worth[k][1].same is same)
        if rows := rows + (_write_small(small, spent) if same and small else ""):
            tables.append(f"<h3>{title}</h3>{write_table(heads, rows)}")
    return "".join(tables) + note


def _write_small(small: Sequence[Stretch], spent: Sequence[Array]) -> str:
    """One row for places of the same text whose times differ a little, without a colour."""
    one = sum(float(spent[0][part.last_a] - spent[0][part.first_a]) for part in small)
    other = sum(float(spent[1][part.last_b] - spent[1][part.first_b]) for part in small)
    head = f"other lines: {count(len(small), 'place')}, each less than {_SMALL_S:g} s apart"
    cells = f"<td>{format_fixed(one, 3)}</td><td>{format_fixed(other, 3)}</td>"
    return (
        f"<tr class=equal><th scope=row class=text>{head}</th><td></td>{cells}"
        f"<td>{_write_difference(one, other, judged=abs(other - one) >= _SMALL_S)}</td><td></td></tr>"
    )


def _sum_times(side: Side) -> Array:
    """Seconds of all lines before each (n_lines + 1,), and of all of them; nothing where the program is refused."""
    times, n = side.study.lines, len(side.lines)
    return np.zeros(n + 1) if times is None else np.concatenate([[0.0], np.cumsum(times.seconds[1 : n + 1])])


def _cut_by_times(one: Stretch, spent_a: Array, spent_b: Array) -> Iterator[Stretch]:
    """Cut lines of the same text: runs whose times differ line by line."""
    difference = np.diff(spent_b[one.first_b : one.last_b + 1]) - np.diff(spent_a[one.first_a : one.last_a + 1])
    differs = np.concatenate([[False], np.abs(difference) >= _SAME_S, [False]])
    begins, ends = np.flatnonzero(differs[1:] & ~differs[:-1]), np.flatnonzero(differs[:-1] & ~differs[1:])
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        yield Stretch(True, one.first_a + begin, one.first_a + end, one.first_b + begin, one.first_b + end)


def _write_stretch(sides: tuple[Side, Side], one: Stretch, spent: Sequence[Array]) -> str:
    texts, reached, times = list[str](), list[str](), list[float | None]()
    spans = (one.first_a, one.last_a), (one.first_b, one.last_b)
    feeds = [_list_feeds(side, *span) for side, span in zip(sides, spans, strict=True)]
    other_feed = all(feeds) and feeds[0] != feeds[1]
    for side, sums, (first, last), each in zip(sides, spent, spans, feeds, strict=True):
        times.append(float(sums[last] - sums[first]) if side.study.timed else None)
        text = "<small>the same text</small>" if one.same and texts else _write_text(side, first, last)
        texts.append(f"<b>{'AB'[len(texts)]}, {_write_span(first, last)}</b><br>{text}")
        rate = join_few(each, "more") + ":" * (len(each) > 1) if other_feed else "feed rate"
        reached.append(_describe_reached(side, first, last, rate))
    if reached[0] != reached[1]:
        reached = [f"{name}: {text}" for name, text in zip("AB", reached, strict=True) if text]
    governs = "<br>".join(map(escape_text, dict.fromkeys(reached)))
    seconds = "".join(f"<td>{_NONE if each is None else format_fixed(each, 3)}</td>" for each in times)
    difference = "" if None in times else f"<td>{_write_difference(*times)}</td>"
    kind = "equal" if one.same else "differs"
    return (
        f"<tr class={kind}><th scope=row class=text>{texts[0]}</th><td class=text>{texts[1]}</td>{seconds}"
        f"{difference}<td class=limit>{governs}</td></tr>"
    )


def _write_span(first: int, last: int) -> str:
    if first == last:
        return "no line"
    return f"line {last}" if last - first == 1 else f"lines {first + 1} to {last}"


def _write_text(side: Side, first: int, last: int) -> str:
    shown = side.lines[first : min(last, first + _LINES)]
    texts = (line.decode("utf-8", errors="replace").strip() for line in shown)
    lines = [text if len(text) <= _LINE_CHARACTERS else text[: _LINE_CHARACTERS - 3] + "..." for text in texts]
    left = last - first - len(lines)
    return "<br>".join(map(escape_code, lines)) + (f"<br><small>and {left} more</small>" if left else "")


def _list_feeds(side: Side, first: int, last: int) -> list[str]:
    """The feed rates of a stretch, in its order."""
    program = side.study.program
    if program is None:
        return []
    moves = program.moves
    on_lines = (moves.line > first) & (moves.line <= last)
    found = np.flatnonzero(on_lines & np.isfinite(moves.feed) & (moves.kind != MoveKind.DWELL))
    return list(dict.fromkeys(describe_feed(moves, int(number)) for number in found))


def _describe_reached(side: Side, first: int, last: int, rate: str) -> str:
    """How long a stretch has its feed rate, and the limit that governs where it loses most; nothing of rapids."""
    times, governing = side.study.lines, side.study.governing
    if times is None or governing is None:
        return "" if rate == "feed rate" else rate.removesuffix(":")
    lines = slice(first + 1, last + 1)
    if not (feed := times.feed[lines].sum()):
        return ""
    # rounded down: what is not all is not 100 %
    share = f"{rate} reached {int(100.0 * times.at_feed[lines].sum() / feed + 1e-9)} % of the time"
    if times.lost[lines].sum() < _SAME_S:
        return share
    return f"{share}, else {governing.names[times.limit[first + 1 + int(times.lost[lines].argmax())]]}"
