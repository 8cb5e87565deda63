"""Findings and worst places of a program, each with the frame that shows it."""

import re
from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.machined import place_on_table
from verne_post.base.arrays import Array
from verne_post.base.long_text import Text, take_line
from verne_post.base.numbers import format_count, format_fixed
from verne_post.base.rotations import rotate_z
from verne_post.base.tolerances import ACCELERATION_RATIO, JERK_RATIO, VELOCITY_RATIO
from verne_post.model.findings import Finding
from verne_post.model.machine import Machine
from verne_post.model.verdict import SEVERITIES
from verne_post.output.causes import describe_other, find_causes
from verne_post.output.commands import find_run
from verne_post.output.findings import list_remedies
from verne_post.part.sweep import Nearest
from verne_post.part.verdict import find_line, find_tip
from verne_post.report.markup import escape_code, escape_text, escape_values
from verne_post.report.surfaces import find_frames
from verne_post.report.table import Governing, Study

#: Stretches that lose time against the programmed feed, shown among the worst places.
_SLOW_STRETCHES: Final = 2
#: What these places are called.
TIME_LOST: Final = "time lost against the feed rate"
#: Characters of a line before and after the column of a mistake that are quoted.
_QUOTED: Final = 60
#: What verification accepts of each limit, for the differences of rounded rows.
_ALLOWED: Final = {"velocity": VELOCITY_RATIO, "acceleration": ACCELERATION_RATIO, "jerk": JERK_RATIO}


class Place(Struct, frozen=True):
    """A place worth a look: what it is, of which joint or line and the like, how much, and the frame that shows it."""

    what: str
    about: str
    value: str
    frame: int


def write_findings_html(program: str, source: Text, study: Study) -> str:
    """The list of findings, one for each cause, with what helps: errors first, each severity by line.

    Each entry has the frame that a click leads to, or the line where the program does not move. The other places of a
    cause are entries of their own; paper has no clicks, and one sentence for them.
    """
    if not study.findings:
        return "<li>no findings</li>"
    entries = []
    # a stable sort: what refuses the program stands before what does not
    for cause in sorted(find_causes(study.findings), key=lambda one: SEVERITIES.index(one.first.severity)):
        item = cause.first
        remedies = list_remedies(item, program, find_run(study.options))
        helps = "".join(f"<small>{escape_text(remedy)}</small>" for remedy in remedies)
        others = f"<small class=printed>also {escape_text(cause.describe_others())}</small>" if cause.others else ""
        text = escape_text(str(item)) + quote_line(item, source) + others + helps
        also = [escape_text(f"also {describe_other(other)}") for other in cause.others]
        kinds = [item.severity] + [f"{item.severity} also"] * len(also)
        for kind, shown, index in zip(kinds, [text, *also], cause.indices, strict=True):
            frame, line = study.place[index], find_own_line(study.findings[index])
            leads = f'data-frame="{frame}"' if frame >= 0 else f'data-line="{line}"' if line else ""
            tag, place = ("button", f' type="button" {leads}') if leads else ("span", "")
            entries.append(f'<li class="{kind}"><{tag}{place}>{shown}</{tag}></li>')
    return "\n".join(entries)


def find_own_line(item: Finding) -> int | None:
    """The line of the program that a finding is about; None where it is about none, or about another file."""
    return item.line if item.file is None else None


def quote_line(item: Finding, source: Text) -> str:
    """The line of an error or a warning, with the word at its column marked."""
    number = find_own_line(item)
    found = take_line(source, number) if number and item.severity != "note" else None
    if number is None or found is None or not found.strip():
        return ""
    line, at = found.decode("utf-8", errors="replace").rstrip().replace("\t", " "), (item.column or 1) - 1
    begin = max(at - _QUOTED, 0)
    before, after = ("..." if begin else "") + line[begin:at].lstrip(), line[at : at + _QUOTED]
    word = re.match(r"\S*", after) if item.column else None
    wrong = word[0] if word else ""
    mark = f"<mark>{escape_text(wrong)}</mark>" if wrong else ""
    return f"<code>{number} | {escape_code(before)}{mark}{escape_code(after[len(wrong) :])}</code>"


def write_places_html(machine: Machine, study: Study) -> str:
    """Worst places of the motion, each a button that leads to it."""
    return "".join(
        f'<li><button type="button" data-frame="{place.frame}">'
        f"<span>{escape_text(place.what)}{': ' * bool(place.about)}{escape_values(place.about)}</span>"
        f"<b>{escape_values(place.value)}</b></button></li>"
        for place in find_worst_places(machine, study)
    )


def find_worst_places(machine: Machine, study: Study) -> Iterator[Place]:
    """Where the program is nearest to its limits, and which lines lose most time."""
    if np.isfinite(study.margin).any():
        curve = study.curves["margin"][0]
        at = int(np.nanargmin(curve.values))
        frame = _find_frame(study, float(curve.x[at]))
        name = study.margin_names[study.nearest[frame]] if study.nearest[frame] >= 0 else "out of reach"
        # where the program is refused for another reason, such as the table, a margin that is left would mislead
        if study.timed or curve.values[at] < 0:
            yield Place("smallest margin", f"{name}, 0 at a limit", format_fixed(curve.values[at], 3), frame)
    for name, allowed in _ALLOWED.items() if study.timed else ():
        shares_of = list(iterate_shares(machine, study, name))
        joint = int(np.argmax([np.abs(share).max() for _x, share in shares_of]))
        x, share = shares_of[joint]
        at = int(np.abs(share).argmax())
        about = f"{machine.columns[joint].joint}, allowed {100.0 * allowed:g} %"
        yield Place(f"peak {name}", about, f"{abs(share[at]):.1f} % of limit", _find_frame(study, float(x[at])))
    yield from _find_part_places(study)
    if study.governing is not None:
        yield from _find_slow_stretches(study, study.governing)
    if study.summary is not None and (within := study.summary.stops_within).count:
        frame = int(np.abs(study.line - within.line).argmin())
        yield Place("most stops within a line", f"line {within.line}", format_count(within.most, "stop"), frame)
    if study.tilts:
        frame = int(np.nanargmax(np.abs(study.alpha_deg)))
        yield Place("peak platform tilt", "", f"{format_fixed(study.alpha_deg[frame], 2)} deg", frame)


def _find_part_places(study: Study) -> Iterator[Place]:
    """Where the part is cut into most, and where most stays on it."""
    if study.part is None or not study.part.judged or study.program is None:
        return
    judged, program = study.part.judged[0], study.program
    found, asked, frame_of_part = judged.comparison, program.options.part, program.machine.coordinates.part_frame
    assert asked is not None
    origin, turn = place_on_table(program, asked.name, asked.system)

    def make(what: str, value: float, nearest: Nearest, k: int) -> Place:
        tip, line = rotate_z(find_tip(judged, nearest, k)[None], turn) + origin, find_line(judged, nearest, k)
        frame = find_frames(study.tip, study.line, tip @ frame_of_part, np.array([line]))[0]
        return Place(f"{what} {asked.name}", f"line {line}", f"{value:.3f} mm", int(frame))

    if len(found.gouges.depth):
        k = int(found.gouges.shortest.argmax())
        yield make("cut into", float(found.gouges.shortest[k]), found.gouges.nearest, k)
    if (np.nan_to_num(found.deviation, nan=0.0) > 0).any():
        k = int(np.nanargmax(found.deviation))
        yield make("left on", float(found.deviation[k]), found.nearest, k)


def _find_slow_stretches(study: Study, governing: Governing) -> Iterator[Place]:
    """Stretches without a moment at the feed rate that lose most time against it; those of the same lines are one."""
    lost = governing.lost_from_frame
    begins = np.flatnonzero((lost > 0) & ~np.append(False, lost[:-1] > 0))
    ends = np.flatnonzero((lost > 0) & ~np.append(lost[1:] > 0, False))
    sums = np.array([lost[begin : end + 1].sum() for begin, end in zip(begins, ends, strict=True)])
    lines, group = np.unique(study.line[np.stack([begins, ends], axis=1)], axis=0, return_inverse=True)
    counts, of_lines = np.bincount(group, minlength=len(lines)), np.bincount(group, sums, len(lines))
    for k in np.argsort(-of_lines, kind="stable")[:_SLOW_STRETCHES]:
        worst = int(np.where(group == k, sums, -1.0).argmax())
        begin, end = int(begins[worst]), int(ends[worst])
        frame = begin + int(lost[begin : end + 1].argmax())
        first, last = lines[k]
        where = f"line {first}" if first == last else f"lines {first} to {last}"
        about = f"{where}, {governing.names[governing.of_frame[frame]]}"
        about += f", at {counts[k]} places" if counts[k] > 1 else ""
        yield Place(TIME_LOST, about, f"{of_lines[k]:.3f} s", frame)


def iterate_shares(machine: Machine, study: Study, name: str) -> Iterator[tuple[Array, Array]]:
    """Yield x and per cent of the limit on velocity, acceleration or jerk, joint by joint."""
    limit: Array = getattr(machine.limits, name)
    for column, most, curve in zip(machine.columns, limit, study.curves[name], strict=True):
        yield curve.x, 100.0 * curve.values / (most * abs(column.factor))


def _find_frame(study: Study, x: float) -> int:
    """The last frame at or before x."""
    return max(int(np.searchsorted(study.x, x, side="right")) - 1, 0)
