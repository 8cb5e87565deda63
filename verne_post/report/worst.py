"""Findings and worst places of a program, each with the frame that shows it."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.machined import place_on_table
from verne_post.base.arrays import Array
from verne_post.base.numbers import format_count, format_fixed
from verne_post.base.rotations import rotate_z
from verne_post.base.tolerances import ACCELERATION_RATIO, JERK_RATIO, VELOCITY_RATIO
from verne_post.model.machine import Machine
from verne_post.output.causes import describe_other, find_causes
from verne_post.output.findings import describe
from verne_post.part.sweep import Nearest
from verne_post.part.verdict import find_line, find_tip
from verne_post.report.markup import escape_text
from verne_post.report.surfaces import find_frames
from verne_post.report.table import Governing, Study

#: Stretches that lose time against the programmed feed, shown among the worst places.
_SLOW_STRETCHES: Final = 2
#: What verification accepts of each limit, for the differences of rounded rows.
_ALLOWED: Final = {"velocity": VELOCITY_RATIO, "acceleration": ACCELERATION_RATIO, "jerk": JERK_RATIO}


class Place(Struct, frozen=True):
    """A place worth a look: what, how much, and the frame that shows it."""

    what: str
    value: str
    frame: int


def write_findings_html(study: Study) -> str:
    """The list of findings, one for each cause; each entry has the frame that a click leads to."""
    if not study.findings:
        return "<li>no findings</li>"
    entries = []
    for cause in find_causes(study.findings):
        item = cause.first
        text = escape_text(("" if item.line is None else f"line {item.line}: ") + describe(item))
        tried = "".join(f"<small>tried: {escape_text(remedy)}</small>" for remedy in item.remedies)
        also = [escape_text(f"also {describe_other(other)}") for other in cause.others]
        kinds = [item.severity] + [f"{item.severity} also"] * len(also)
        for kind, shown, index in zip(kinds, [text + tried, *also], cause.indices, strict=True):
            frame = study.place[index]
            tag, place = ("button", f' type="button" data-frame="{frame}"') if frame >= 0 else ("span", "")
            entries.append(f'<li class="{kind}"><{tag}{place}>{shown}</{tag}></li>')
    return "\n".join(entries)


def write_places_html(machine: Machine, study: Study) -> str:
    """Worst places of the motion, each a button that leads to it."""
    return "".join(
        f'<li><button type="button" data-frame="{place.frame}"><span>{escape_text(place.what)}</span>'
        f"<b>{escape_text(place.value)}</b></button></li>"
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
            yield Place(f"smallest margin (0 at a limit): {name}", format_fixed(curve.values[at], 3), frame)
    for name, allowed in _ALLOWED.items() if study.timed else ():
        shares_of = list(iterate_shares(machine, study, name))
        joint = int(np.argmax([np.abs(share).max() for _x, share in shares_of]))
        x, share = shares_of[joint]
        at = int(np.abs(share).argmax())
        what = f"peak {name}: {machine.columns[joint].joint}, allowed {100.0 * allowed:g} %"
        yield Place(what, f"{abs(share[at]):.1f} %", _find_frame(study, float(x[at])))
    yield from _find_part_places(study)
    if study.governing is not None:
        yield from _find_slow_stretches(study, study.governing)
    if study.summary is not None and (within := study.summary.stops_within).count:
        frame = int(np.abs(study.line - within.line).argmin())
        yield Place(f"stops within line {within.line}", format_count(within.most, "time"), frame)
    if study.tilts:
        frame = int(np.nanargmax(np.abs(study.alpha_deg)))
        yield Place("peak platform tilt", f"{format_fixed(study.alpha_deg[frame], 2)} deg", frame)


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
        return Place(f"{what} {asked.name}: line {line}", f"{value:.3f} mm", int(frame))

    if len(found.gouges.depth):
        k = int(found.gouges.depth.argmax())
        yield make("cut into", float(found.gouges.depth[k]), found.gouges.nearest, k)
    if (np.nan_to_num(found.deviation, nan=0.0) > 0).any():
        k = int(np.nanargmax(found.deviation))
        yield make("left on", float(found.deviation[k]), found.nearest, k)


def _find_slow_stretches(study: Study, governing: Governing) -> Iterator[Place]:
    """Stretches without a moment at the feed rate that lose most time against it."""
    lost = governing.lost_from_frame
    begins = np.flatnonzero((lost > 0) & ~np.append(False, lost[:-1] > 0))
    ends = np.flatnonzero((lost > 0) & ~np.append(lost[1:] > 0, False))
    sums = np.array([lost[begin : end + 1].sum() for begin, end in zip(begins, ends, strict=True)])
    for k in np.argsort(-sums, kind="stable")[:_SLOW_STRETCHES]:
        begin, end = int(begins[k]), int(ends[k])
        frame = begin + int(lost[begin : end + 1].argmax())
        first, last = study.line[[begin, end]]
        lines = f"line {first} loses" if first == last else f"lines {first} to {last} lose"
        yield Place(f"{lines}: {governing.names[governing.of_frame[frame]]}", f"{sums[k]:.3f} s", frame)


def iterate_shares(machine: Machine, study: Study, name: str) -> Iterator[tuple[Array, Array]]:
    """Yield x and per cent of the limit on velocity, acceleration or jerk, joint by joint."""
    limit: Array = getattr(machine.limits, name)
    for column, most, curve in zip(machine.columns, limit, study.curves[name], strict=True):
        yield curve.x, 100.0 * curve.values / (most * abs(column.factor))


def _find_frame(study: Study, x: float) -> int:
    """The last frame at or before x."""
    return max(int(np.searchsorted(study.x, x, side="right")) - 1, 0)
