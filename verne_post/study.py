"""A program looked at from all sides: what a report page shows. Rows when it converts, poses along the path when it does not."""

import numpy as np
from numpy.typing import NDArray

from verne_post.app.assemble import assemble
from verne_post.app.convert import convert_source
from verne_post.app.result import Progress, refused
from verne_post.base.long_text import Text
from verne_post.base.rotations import axis_of_angles
from verne_post.model.findings import Finding, InputError
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.protocols import Sketched
from verne_post.model.setpoints import SetpointBlock
from verne_post.model.study import Study
from verne_post.model.summary import Summary
from verne_post.output.rounding import places_of
from verne_post.toolpath.room import margins_of

Array = NDArray[np.float64]

#: So many frames are shown at most: more than a screen has points.
FRAMES = 3000
#: Where a program that is refused is looked at: points of each segment, ends included.
_ALONG = 9


class _Frames:
    """Keeps every so many rows, and the extremes of those between, while rows go by."""

    def __init__(self) -> None:
        self.every = 1
        self.kept: list[tuple[Array, NDArray[np.int32], NDArray[np.int64], list[Array]]] = []
        self._tail: Array | None = None
        self._cycle = 0.0
        self._count = 0

    def take(self, block: SetpointBlock) -> None:
        """The next rows; frames are thinned whenever they have become twice too many."""
        values = places_of(block.written, block.format)
        before = values[:1].repeat(3, axis=0) if self._tail is None else self._tail
        padded = np.concatenate([before, values])
        sizes = [np.diff(padded, order, axis=0)[3 - order :] / block.format.cycle**order for order in (1, 2, 3)]
        self.kept.append((values, block.line, block.first + np.arange(len(values)), sizes))
        self._tail, self._cycle = padded[-3:], block.format.cycle
        self._count += len(values)
        if self._count > 4 * FRAMES:
            self._thin()

    def _joined(self) -> tuple[Array, NDArray[np.int32], NDArray[np.int64], list[Array]]:
        values, line, row = (np.concatenate([one[k] for one in self.kept]) for k in range(3))
        return values, line, row, [np.concatenate([one[3][k] for one in self.kept]) for k in range(3)]

    def _thin(self, wanted: int = FRAMES) -> None:
        values, line, row, sizes = self._joined()
        every = max(-(-len(values) // wanted), 1)
        starts = np.arange(0, len(values), every)
        thinned = []
        for size in sizes:
            padded = np.concatenate([size, np.zeros((len(starts) * every - len(size), size.shape[1]))])
            groups = padded.reshape(len(starts), every, -1)
            at = np.abs(groups).argmax(axis=1)
            thinned.append(np.take_along_axis(groups, at[:, None], axis=1)[:, 0])
        keep = np.append(starts, len(values) - 1) if starts[-1] != len(values) - 1 else starts
        ends = [np.concatenate([size, size[-1:]])[: len(keep)] for size in thinned]
        self.kept = [(values[keep], line[keep], row[keep], ends)]
        self._count = len(keep)

    def finished(self) -> tuple[Array, NDArray[np.int32], Array, dict[str, Array]]:
        """Joints, lines, times and extremes of the frames."""
        if self._count > FRAMES:
            self._thin()
        values, line, row, sizes = self._joined()
        names = ("velocity", "acceleration", "jerk")
        return values, line, np.asarray(row * self._cycle, dtype=np.float64), dict(zip(names, sizes, strict=True))


def study(source: Text, machine: Machine, options: Options, progress: Progress | None = None) -> Study:
    """Look at a program: convert it, or where that is refused, follow it as far as it can be read."""
    frames = _Frames()
    result = convert_source(source, machine, options, frames.take, progress)
    if result.ok:
        values, line, x, extremes = frames.finished()
        q = values / [column.factor for column in machine.columns]
        lengths = assemble(source, machine, options).path.tool_length_at(line)
        return _studied(machine, result.findings, result.summary, x, line.astype(np.int64), q, extremes, lengths)
    try:
        program = assemble(source, machine, options)
    except InputError as error:
        return _nothing(machine, refused(error).findings)
    n = len(program.contour)
    step = max(n * _ALONG // FRAMES, 1)
    segment = np.repeat(np.arange(0, n, step), _ALONG)
    w = np.tile(np.linspace(0.0, 1.0, _ALONG), len(range(0, n, step)))
    solved = program.joints().solve(segment, w)
    begins = np.append(0.0, np.cumsum(program.contour.length))
    x = begins[segment] + w * program.contour.length[segment]
    lengths = program.contour.tool_length(segment)
    lines = program.contour.line(segment).astype(np.int64)
    return _studied(machine, result.findings, None, x, lines, solved.q, {}, lengths, (solved.tip, solved.angles))


def _studied(
    machine: Machine, findings: tuple[Finding, ...], summary: Summary | None, x: Array, line: NDArray[np.int64],
    q: Array, extremes: dict[str, Array], lengths: Array, wanted: tuple[Array, Array] | None = None,
) -> Study:  # fmt: skip
    """Everything that follows from the joints, and where they are out of reach from the poses that were ``wanted``."""
    factor = np.array([column.factor for column in machine.columns])
    five_axis, module = machine.five_axis, machine.module
    position, alpha, ok = module.forward(np.where(np.isfinite(q[:, :-2]), q[:, :-2], 0.0))
    tip, angles, _ok = five_axis.nominal(q, lengths)
    if wanted is not None:
        tip, angles = wanted
    margins = margins_of(machine)[0](tip, angles, lengths).min(axis=1)
    margin = np.where(np.isfinite(margins) & np.isfinite(q).all(axis=1), margins, np.nan)
    up = np.array([1.0, -1.0, -1.0])
    down = np.stack([np.zeros(len(alpha)), -np.sin(alpha), np.cos(alpha)], axis=1)
    rods = np.empty((len(x), 0, 2, 3))
    if isinstance(module, Sketched):
        rods = module.sketch(position, alpha, q[:, :-2]) * up
    speed = np.full(len(x), np.nan)
    if summary is not None and len(x) > 1:
        speed = np.append(0.0, np.linalg.norm(np.diff(tip, axis=0), axis=1) / np.maximum(np.diff(x), 1e-9))
    unreached = ~(ok & np.isfinite(q).all(axis=1))
    lean = np.where(unreached, np.nan, np.degrees(alpha))
    return Study(
        findings, summary, summary is not None, x, line, q * factor, extremes, tip, axis_of_angles(angles[:, 0], angles[:, 1]),
        speed, margin, lean, (position + five_axis.nose_offset * down) * up, position * up, rods, q[:, -2], q[:, -1],
    )  # fmt: skip


def _nothing(machine: Machine, findings: tuple[Finding, ...]) -> Study:
    """A program that cannot be read has nothing but findings."""
    none, three = np.empty(0), np.empty((0, 3))
    joints = np.empty((0, len(machine.columns)))
    return Study(
        findings, None, False, none, np.empty(0, dtype=np.int64), joints, {}, three, three, none, none, none, three, three,
        np.empty((0, 0, 2, 3)), none, none,
    )  # fmt: skip
