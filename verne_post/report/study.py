"""A program looked at from all sides: what a report page shows. Rows when it converts, poses along the path when it does not.

Frames are evenly spaced over the whole program, so that what moves through them moves truly; what happens between two of them is
kept as the lowest and highest values of every curve.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.app.assemble import Program, assemble
from verne_post.app.convert import convert_source
from verne_post.app.result import Progress, Result, refused
from verne_post.base.columns import BLOCK_ROWS, GrowingTable, blocks, running_sums
from verne_post.base.long_text import Text
from verne_post.base.rotations import axis_of_angles
from verne_post.model.findings import Finding, InputError
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.protocols import Drawable
from verne_post.model.setpoints import SetpointBlock
from verne_post.report.table import Curve, Study, Trail
from verne_post.toolpath.margins import margin_functions

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: A program is cut into so many stretches at most, with a frame at the beginning of each and one at the end: more than a screen
#: shows, and no stretch is longer than a thousandth of the program (or a cycle).
FRAMES: Final = 2000
#: Where a program that is refused is looked at between frames: points of each segment, ends included.
_ALONG: Final = 9
_RATES: Final = ("velocity", "acceleration", "jerk")


def study(source: Text, machine: Machine, options: Options, progress: Progress | None = None) -> Study:
    """Look at a program: convert it, or where that is refused, follow it as far as it can be read."""
    table = GrowingTable(values=(float, len(machine.columns)), line=(np.int32,), tool_length=(float,))

    def take(block: SetpointBlock) -> None:
        assert block.tool_length is not None
        table.extend(values=block.values, line=block.line, tool_length=block.tool_length)

    result = convert_source(source, machine, options, take, progress)
    if result.ok:
        return _of_rows(machine, result, **table.columns())
    try:
        program = assemble(source, machine, options)
    except InputError as error:
        return _nothing(machine, refused(error).findings)
    if not len(program.contour):
        return _nothing(machine, result.findings)
    return _of_path(machine, result, program)


def _of_rows(machine: Machine, result: Result, values: Array, line: Ints, tool_length: Array) -> Study:
    """Frames are rows: every so many from the first on, and the last."""
    assert result.summary is not None
    n, cycle = len(line), result.summary.format.cycle
    frames = np.append(np.arange(0, n - 1, max(-(-(n - 1) // FRAMES), 1)), n - 1)
    factor = np.array([column.factor for column in machine.columns])
    seen = _Seen(machine, result.findings)
    for first, last in blocks(n):
        row = np.arange(first, last)
        near = values[np.maximum(np.arange(first - 3, last), 0)]
        rates = {name: np.diff(near, k, axis=0)[3 - k :] / cycle**k for k, name in enumerate(_RATES, start=1)}
        q, length = near / factor, tool_length[first:last]
        tip, angles, ok = machine.five_axis.nominal(q[3:], length)
        # a step of the tool's length is no motion: both ends of a step in time have the tool of the later one
        fresh = np.flatnonzero(np.append(True, length[1:] != length[:-1]))
        before = np.concatenate([tip[:1], tip[:-1]])
        before[fresh] = machine.five_axis.nominal(q[2:-1][fresh], length[fresh])[0]
        speed = np.linalg.norm(tip - before, axis=1) / cycle
        stretch = np.searchsorted(frames, row, side="right") - 1
        seen.take(
            _Samples(np.asarray(row * cycle), line[first:last], q[3:], length, tip, angles, ok, speed, stretch),
            frames[stretch] == row, {"position": near[3:], **rates},
        )  # fmt: skip
    return seen.finished(result)


def _of_path(machine: Machine, result: Result, program: Program) -> Study:
    """Frames are evenly spaced along the path; between them every segment is looked at in some points."""
    contour, n = program.contour, len(program.contour)
    joints, factor = program.joints(), np.array([column.factor for column in machine.columns])
    begins = running_sums(contour.length)
    frames = np.linspace(0.0, begins[-1], FRAMES + 1)
    owner = np.minimum(np.searchsorted(begins, frames, side="right") - 1, n - 1)
    seen = _Seen(machine, result.findings)
    for first, last in ((at, min(at + BLOCK_ROWS // _ALONG, n)) for at in range(0, n, BLOCK_ROWS // _ALONG)):
        some = np.flatnonzero((owner >= first) & (owner < last))
        share = np.clip((frames[some] - begins[owner[some]]) / contour.length[owner[some]], 0.0, 1.0)
        segment = np.append(owner[some], np.repeat(np.arange(first, last), _ALONG))
        w = np.append(share, np.tile(np.linspace(0.0, 1.0, _ALONG), last - first))
        order = np.lexsort((w, segment))
        segment, w, frame = segment[order], w[order], order < len(some)
        solved = joints.solve(segment, w)
        x = begins[segment] + w * contour.length[segment]
        stretch = np.searchsorted(owner, first) + np.cumsum(frame) - 1
        speed = np.full(len(x), np.nan)
        line, length = contour.line(segment), contour.tool_length(segment)
        seen.take(
            _Samples(x, line, solved.q, length, solved.tip, solved.angles, solved.ok, speed, stretch),
            frame, {"position": solved.q * factor},
        )  # fmt: skip
    return seen.finished(result)


@dataclass(frozen=True, eq=False)
class _Samples:
    """Places of a program in order (n,), joints in mm and rad; each lies in a stretch, which its frame opens."""

    x: Array
    line: Ints
    q: Array
    tool_length: Array
    tip: Array
    angles: Array
    ok: Mask
    speed: Array
    stretch: Ints


class _Seen:
    """Takes samples block by block, and keeps frames, curves, the way of the tip, and the places of findings."""

    def __init__(self, machine: Machine, findings: tuple[Finding, ...]) -> None:
        self.machine, self.findings = machine, findings
        self._margins = margin_functions(machine)[0]
        self._frames: list[tuple[NDArray[Any], ...]] = []
        self._trail: list[tuple[NDArray[Any], ...]] = []
        self._curves: dict[str, list[list[tuple[Array, Array]]]] = {}
        self._wanted = np.array(sorted({_worst_line(item) for item in findings} - {-1}), dtype=np.int64)
        self._worst: dict[int, tuple[float, float, Array]] = {}

    def take(self, some: _Samples, frame: Mask, curves: dict[str, Array]) -> None:
        """The next samples, which of them are frames, and what is drawn against x: columns (n, k) by name."""
        reached = some.ok & np.isfinite(some.q).all(axis=1)
        margin = self._margins(some.tip, some.angles, some.tool_length).min(axis=1)
        margin[~(reached & np.isfinite(margin))] = np.nan
        alpha = np.where(reached, np.degrees(some.q[:, -2] - some.angles[:, 0]), np.nan)
        self._frames.append(
            tuple(
                all_of[frame]
                for all_of in (some.x, some.line, some.q, some.tip, some.angles, some.speed, margin, alpha)
            )
        )
        begins = np.flatnonzero(np.append(True, some.stretch[1:] != some.stretch[:-1]))
        for name, columns in {**curves, "alpha": alpha[:, None]}.items():
            parts = self._curves.setdefault(name, [[] for _ in columns.T])
            for part, column in zip(parts, columns.T, strict=True):
                shown = _telling(column, begins)
                part.append((some.x[shown], column[shown]))
        shown = np.unique(np.concatenate([_telling(column, begins) for column in (*some.tip.T, margin)]))
        self._trail.append(tuple(all_of[shown] for all_of in (some.stretch, some.line, some.tip, some.speed, margin)))
        self._note(some, np.nan_to_num(margin, nan=-np.inf))

    def _note(self, some: _Samples, margin: Array) -> None:
        """Where the lines of the findings have the smallest margin."""
        at = np.flatnonzero(np.isin(some.line, self._wanted))
        at = at[np.lexsort((margin[at], some.line[at]))]
        for k in at[np.unique(some.line[at], return_index=True)[1]]:
            line = int(some.line[k])
            if line not in self._worst or margin[k] < self._worst[line][0]:
                self._worst[line] = float(margin[k]), float(some.x[k]), some.tip[k]

    def finished(self, result: Result) -> Study:
        """Everything that follows for the frames."""
        machine, module, timed = self.machine, self.machine.module, result.ok
        x, line, q, tip, angles, speed, margin, alpha = _joined(self._frames)
        position, alpha, _ok = module.forward(np.where(np.isfinite(q[:, :-2]), q[:, :-2], 0.0))
        up = np.array([1.0, -1.0, -1.0])
        down = np.stack([np.zeros(len(alpha)), -np.sin(alpha), np.cos(alpha)], axis=1)
        rods = np.empty((len(x), 0, 2, 3))
        if isinstance(module, Drawable):
            rods = module.sketch(position, alpha, q[:, :-2]) * up
        curves = {name: tuple(Curve(*_joined(part)) for part in parts) for name, parts in self._curves.items()}
        place, place_tip = self._places(x, line)
        return Study(
            self.findings, result.summary if timed else None, timed, x, line.astype(np.int64),
            q * [column.factor for column in machine.columns], curves, Trail(*_joined(self._trail)), tip,
            axis_of_angles(angles[:, 0], angles[:, 1]), speed, margin, alpha,
            (position + machine.five_axis.nose_offset * down) * up, position * up, rods, q[:, -2], q[:, -1], place, place_tip,
        )  # fmt: skip

    def _places(self, x: Array, line: Ints) -> tuple[NDArray[np.intp], Array]:
        """The frame and the tip of each finding."""
        place, tips = np.full(len(self.findings), -1, dtype=np.intp), np.full((len(self.findings), 3), np.nan)
        for index, item in enumerate(self.findings):
            worst = self._worst.get(_worst_line(item))
            if worst is not None:
                own = np.flatnonzero(line == _worst_line(item))
                among = own if len(own) else np.arange(len(x))
                place[index], tips[index] = among[np.abs(x[among] - worst[1]).argmin()], worst[2]
        return place, tips


def _worst_line(item: Finding) -> int:
    return item.worst_line or item.line or -1


def _joined(parts: Iterable[tuple[NDArray[Any], ...]]) -> Iterator[NDArray[Any]]:
    return (np.concatenate(each) for each in zip(*parts, strict=True))


def _telling(values: Array, begins: Ints) -> Ints:
    """Of values (n,) in groups that begin at ``begins``: where each has its first, lowest and highest, and its first NaN."""
    group = np.repeat(np.arange(len(begins)), np.diff(np.append(begins, len(values))))
    low, high = np.fmin.reduceat(values, begins), np.fmax.reduceat(values, begins)
    chosen: list[Any] = [begins]
    for told in (values == low[group], values == high[group], np.isnan(values)):
        at = np.flatnonzero(told)
        chosen.append(at[np.unique(group[at], return_index=True)[1]])
    return np.unique(np.concatenate(chosen))


def _nothing(machine: Machine, findings: tuple[Finding, ...]) -> Study:
    """A program that cannot be read has nothing but findings."""
    none, three, whole = np.empty(0), np.empty((0, 3)), np.empty(0, dtype=np.int64)
    joints = np.empty((0, len(machine.columns)))
    curves = {"position": (Curve(none, none),) * len(machine.columns)}
    return Study(
        findings, None, False, none, whole, joints, curves, Trail(whole, whole, three, none, none), three, three, none, none, none,
        three, three, np.empty((0, 0, 2, 3)), none, none, np.full(len(findings), -1), np.full((len(findings), 3), np.nan),
    )  # fmt: skip
