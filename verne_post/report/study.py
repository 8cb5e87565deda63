"""Collect what a report shows of a program: its rows when it converts, else poses along its path.

Frames are evenly spaced over the whole program, so a cursor that goes from frame to frame shows the motion at a
constant scale. What happens between two frames is kept as the lowest and highest values of every curve.
"""

from collections.abc import Iterable, Iterator
from typing import Any, Final

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.app.assemble import Program, assemble
from verne_post.app.constraints import guard_joints
from verne_post.app.convert import convert_program
from verne_post.app.line_facts import RATES
from verne_post.app.machined import place_on_table
from verne_post.app.result import Progress, Result, refuse_program
from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import BLOCK_ROWS, GrowingTable, iterate_blocks, sum_running
from verne_post.base.long_text import Text
from verne_post.base.rotations import find_axis_of_angles, rotate_z
from verne_post.base.team import work_together
from verne_post.kinematics.checks.clearance import list_clearances
from verne_post.kinematics.rod_sketch import sketch_rods
from verne_post.model.findings import Finding, InputError
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.poses import Pose
from verne_post.model.protocols import turn_from_setup
from verne_post.model.setpoints import SetpointBlock
from verne_post.part.verdict import Machined
from verne_post.report.governing import GoverningLimits
from verne_post.report.operations import OperationTimes
from verne_post.report.spectrum import measure_spectrum
from verne_post.report.surfaces import find_frames
from verne_post.report.table import Curve, Governing, LineTimes, Operation, Spectrum, Study, Trail
from verne_post.toolpath.margins import list_margin_functions

#: A program is cut into so many stretches at most, with a frame at the beginning of each and one at the end. That is
#: more than a screen shows, and no stretch is longer than a thousandth of the program (or a cycle).
FRAMES: Final = 2000
#: Points of each element of a program that is refused, ends included.
_ELEMENT_POINTS: Final = 9
#: Findings about distances between bodies.
_NEARNESS: Final = ("VP211", "VP212", "VP213", "VP214", "VP215")
#: Cosine of the angle within which a spindle lies along a direction: never along two at right angles.
ALONG: Final = 0.9


def study(source: Text, machine: Machine, options: Options, progress: Progress | None = None) -> Study:
    """Convert a program and collect its rows; where it is refused, follow its path as far as it can be read.

    Raises nothing for a bad program: its findings are in the study.
    """
    table = GrowingTable(values=(float, len(machine.columns)), line=(np.int32,), segment=(np.int32,))

    def take(block: SetpointBlock) -> None:
        assert block.segment is not None
        table.extend(values=block.values, line=block.line, segment=block.segment)

    with work_together(options.jobs) as team:
        try:
            program = assemble(source, machine, options, team)
        except InputError as error:
            return _study_findings(machine, options, refuse_program(error).findings)
        result = convert_program(source, program, take, progress)
    if result.ok:
        return _study_rows(source, program, result, **table.freeze())
    if not len(program.contour):
        return _study_findings(machine, options, result.findings)
    return _study_path(program, result)


def choose_frames(last: int, line: Ints) -> Ints:
    """Rows that are frames: evenly spaced ones, the last, and first rows of blocks while these are not more."""
    frames = np.append(np.arange(0, last, max(-(-last // FRAMES), 1)), last)
    starts = np.flatnonzero(line[1:] != line[:-1]) + 1
    return np.union1d(frames, starts) if len(starts) <= FRAMES else frames


def _study_rows(source: Text, program: Program, result: Result, values: Array, line: Ints, segment: Ints) -> Study:
    """Take rows at a constant interval as frames, and the first rows of blocks."""
    assert result.summary is not None
    machine, path = program.machine, program.path
    n, cycle = len(line), result.summary.format.cycle
    frames = choose_frames(n - 1, line)
    factor = np.array([column.factor for column in machine.columns])
    collector = _Collector(program, result.findings)
    governing, operations = GoverningLimits(program, cycle, len(frames)), OperationTimes(source, program)
    for first, last in iterate_blocks(n):
        row = np.arange(first, last)
        recent = values[np.maximum(np.arange(first - 3, last), 0)]
        rates = {name: np.diff(recent, k, axis=0)[3 - k :] / cycle**k for name, k in RATES.items()}
        of, q = segment[first:last], recent / factor
        length = path.tool_length[of]
        tip, angles, ok = machine.five_axis.find_nominal_pose(q[3:], length)
        # a change of the tool's length is no motion: both ends of a step in time are solved with the later tool
        changed = np.flatnonzero(np.append(True, length[1:] != length[:-1]))
        before, angles_before = np.concatenate([tip[:1], tip[:-1]]), np.concatenate([angles[:1], angles[:-1]])
        before[changed], angles_before[changed], _ok = machine.five_axis.find_nominal_pose(
            q[2:-1][changed], length[changed]
        )
        speed = np.linalg.norm(tip - before, axis=1) / cycle
        turning = np.linalg.norm(np.remainder(angles - angles_before + np.pi, 2 * np.pi) - np.pi, axis=1) / cycle
        stretch = np.searchsorted(frames, row, side="right") - 1
        feed, spent = governing.add(stretch, of, speed, turning, rates)
        operations.add(line[first:last], of, stretch, spent)
        collector.add(
            _Samples(np.asarray(row * cycle), line[first:last], q[3:], of, tip, angles, ok, speed, stretch),
            frames[stretch] == row,
            {"position": recent[3:], **rates, "speed": speed[:, None], "feed": feed[:, None]},
        )
    return collector.finish(result, governing.finish(), *operations.finish(), measure_spectrum(values, cycle))


def _study_path(program: Program, result: Result) -> Study:
    """Take evenly spaced points of the path and block beginnings as frames; between them, points of every element."""
    machine, contour, n = program.machine, program.contour, len(program.contour)
    joints, factor = program.build_joint_path(), np.array([column.factor for column in machine.columns])
    begins = sum_running(contour.length)
    frames = np.linspace(0.0, begins[-1], FRAMES + 1)
    line = contour.find_lines()
    starts = np.flatnonzero(line[1:] != line[:-1]) + 1
    if len(starts) <= FRAMES:
        frames = np.union1d(frames, begins[starts])
    owner = np.minimum(np.searchsorted(begins, frames, side="right") - 1, n - 1)
    collector = _Collector(program, result.findings)
    for first, last in (
        (at, min(at + BLOCK_ROWS // _ELEMENT_POINTS, n)) for at in range(0, n, BLOCK_ROWS // _ELEMENT_POINTS)
    ):
        here = np.flatnonzero((owner >= first) & (owner < last))
        share = np.clip((frames[here] - begins[owner[here]]) / contour.length[owner[here]], 0.0, 1.0)
        element = np.append(owner[here], np.repeat(np.arange(first, last), _ELEMENT_POINTS))
        w = np.append(share, np.tile(np.linspace(0.0, 1.0, _ELEMENT_POINTS), last - first))
        order = np.lexsort((w, element))
        element, w, frame = element[order], w[order], order < len(here)
        solved = joints.solve(element, w)
        x = begins[element] + w * contour.length[element]
        stretch = np.searchsorted(owner, first) + np.cumsum(frame) - 1
        speed = np.full(len(x), np.nan)
        collector.add(
            _Samples(
                x,
                line[element],
                solved.q,
                contour.segment[element],
                solved.tip,
                solved.angles,
                solved.ok,
                speed,
                stretch,
            ),
            frame,
            {"position": solved.q * factor},
        )
    return collector.finish(result, None, (), None, None)


class _Samples(Struct, frozen=True, eq=False):
    """Points of a program in order (n,), joints in mm and rad; each lies in a stretch, which begins with a frame."""

    x: Array
    line: Ints
    q: Array
    segment: Ints
    tip: Array
    angles: Array
    ok: Mask
    speed: Array
    stretch: Ints


class _Collector:
    """Takes samples block by block, and keeps frames, curves, the path of the tip, and the worst points of findings."""

    def __init__(self, program: Program, findings: tuple[Finding, ...]) -> None:
        self.program, self.machine, self.findings = program, program.machine, findings
        self._margins, self._margin_names = list_margin_functions(program.machine)
        self._move = program.path.move_reached
        rate = program.contour.feeds.rate
        self._rapid = ~(np.isfinite(rate) & (rate > 0.0))
        self._frames: list[tuple[NDArray[Any], ...]] = []
        self._trail: list[tuple[NDArray[Any], ...]] = []
        self._curves: dict[str, list[list[tuple[Array, Array]]]] = {}
        self._wanted = np.array(sorted({_find_worst_line(item) for item in findings} - {-1}), dtype=np.int64)
        self._worst: dict[int, tuple[float, float, Array]] = {}

    def add(self, samples: _Samples, frame: Mask, curves: dict[str, Array]) -> None:
        """Add the next samples: which of them are frames, and what is drawn against x, columns (n, k) by name."""
        reached = samples.ok & np.isfinite(samples.q).all(axis=1)
        tool_length = self.program.path.tool_length[samples.segment]
        margins = self._margins(samples.tip, samples.angles, tool_length)
        margin, nearest = margins.min(axis=1), margins.argmin(axis=1)
        reached_margin = reached & np.isfinite(margin)
        margin[~reached_margin], nearest[~reached_margin] = np.nan, -1
        parallel = self.machine.module is not None  # no platform that tilts
        alpha = np.where(reached, parallel * np.degrees(samples.q[:, -2] - samples.angles[:, 0]), np.nan)
        kept = (
            samples.x,
            samples.line,
            samples.q,
            tool_length,
            samples.tip,
            samples.angles,
            samples.speed,
            margin,
            nearest,
            samples.segment,
            alpha,
        )
        self._frames.append(tuple(column[frame] for column in kept))
        begins = np.flatnonzero(np.append(True, samples.stretch[1:] != samples.stretch[:-1]))
        for name, columns in {**curves, "alpha": alpha[:, None], "margin": margin[:, None]}.items():
            parts = self._curves.setdefault(name, [[] for _ in columns.T])
            for part, column in zip(parts, columns.T, strict=True):
                at = _find_extremes(column, begins)
                part.append((samples.x[at], column[at]))
        at = np.unique(np.concatenate([_find_extremes(column, begins) for column in (*samples.tip.T, margin)]))
        self._trail.append(
            tuple(
                column[at]
                for column in (
                    *(samples.stretch, samples.line, samples.tip, samples.speed, margin),
                    self._rapid[samples.segment],
                )
            )
        )
        self._note_worst(samples, np.nan_to_num(margin, nan=-np.inf))

    def _note_worst(self, samples: _Samples, margin: Array) -> None:
        """Keep the point with the smallest margin on each line that has a finding."""
        at = np.flatnonzero(np.isin(samples.line, self._wanted))
        at = at[np.lexsort((margin[at], samples.line[at]))]
        for k in at[np.unique(samples.line[at], return_index=True)[1]]:
            line = int(samples.line[k])
            if line not in self._worst or margin[k] < self._worst[line][0]:
                self._worst[line] = float(margin[k]), float(samples.x[k]), samples.tip[k]

    def finish(
        self,
        result: Result,
        governing: Governing | None,
        operations: tuple[Operation, ...],
        lines: LineTimes | None,
        bands: Spectrum | None,
    ) -> Study:
        """Solve the mechanism at the frames, and join all blocks."""
        machine, timed = self.machine, result.ok
        x, line, q, tool_length, tip, angles, speed, margin, nearest, segment, alpha_deg = _join(self._frames)
        five_axis = machine.five_axis
        platform, _ok = five_axis.find_platform(np.where(np.isfinite(q), q, 0.0))
        part, position = machine.coordinates.part_frame, platform.position
        up = np.diag([1.0, -1.0, -1.0]) @ part  # from the base frame, z down, to directions of the part
        along = np.asarray(five_axis.spindle)
        nose = position + five_axis.nose_offset * platform.turn(along)
        # across it, what the platform calls x, or y where the spindle lies along x
        aside = next(unit for unit in np.eye(3) if abs(unit @ along) < ALONG)
        aside = aside - (aside @ along) * along
        basis = np.stack([platform.turn(axis) for axis in (aside / np.linalg.norm(aside), -along)], axis=1) @ up
        rods = sketch_rods(machine, q, platform) @ up
        curves = {name: tuple(Curve(*_join(part)) for part in parts) for name, parts in self._curves.items()}
        axis = find_axis_of_angles(angles[:, 0], angles[:, 1])
        pose = Pose(q, platform, tip, axis, tool_length, segment)
        place, place_tip = self._find_places(x, line.astype(np.int64), pose, result.part)
        stretch, on_line, at, how_fast, how_far, rapid = _join(self._trail)
        trail = Trail(stretch, on_line, at @ part, how_fast, how_far, _find_bad(self.findings, on_line, how_far), rapid)
        return Study(
            self.findings,
            self.program.options,
            result.summary if timed else None,
            self.program,
            governing,
            operations,
            lines,
            bands,
            timed,
            x,
            line.astype(np.int64),
            q * [column.factor for column in machine.columns],
            curves,
            trail,
            tip @ part,
            axis @ part,
            speed,
            margin,
            nearest,
            self._margin_names,
            self._move[segment],
            alpha_deg,
            nose @ up,
            position @ up,
            basis,
            rods,
            *_turn_table(machine, q),
            tool_length,
            place,
            place_tip @ part,
            result.part,
        )

    def _find_places(self, x: Array, line: Ints, pose: Pose, part: Machined | None) -> tuple[NDArray[np.intp], Array]:
        """Find the frame and the tip of each finding: the worst of its line, or where a contact begins.

        Of a gouge or excess the tip is the place on the part.
        """
        place, tips, tip = np.full(len(self.findings), -1), np.full((len(self.findings), 3), np.nan), pose.tip
        for index, item in enumerate(self.findings):
            worst = self._worst.get(_find_worst_line(item))
            if worst is not None:
                on_line = np.flatnonzero(line == _find_worst_line(item))
                candidates = on_line if len(on_line) else np.arange(len(x))
                place[index], tips[index] = candidates[np.abs(x[candidates] - worst[1]).argmin()], worst[2]
            if item.contact is not None and len(on_line := np.flatnonzero(line == item.line)):
                contact = turn_from_setup(self.machine.coordinates, np.array(item.contact))
                away = np.linalg.norm(tip[on_line] - contact, axis=1)
                place[index], tips[index] = on_line[np.nan_to_num(away, nan=np.inf).argmin()], contact
        for index, frame in self._find_contacts(line, pose):
            place[index], tips[index] = frame, tip[frame]
        asked = self.program.options.part
        if part is not None and asked is not None:
            origin, turn = place_on_table(self.program, asked.name, asked.system)
            of = {id(spot.finding): spot for spot in part.spots}
            for index, item in enumerate(self.findings):
                if (spot := of.get(id(item))) is not None:
                    at, tips[index] = rotate_z(np.stack([spot.tip, spot.place]), turn) + origin
                    here = line if item.line is not None else np.zeros_like(line)
                    place[index] = find_frames(tip, here, at[None], np.array([max(_find_worst_line(item), 0)]))[0]
        return place, tips

    def _find_contacts(self, line: Ints, pose: Pose) -> Iterator[tuple[int, int]]:
        """Findings of bodies that come too near to each other, each with the frame where that begins.

        Where it happens between two frames, this is the frame where they are nearest.
        """
        asked = [index for index, item in enumerate(self.findings) if item.code in _NEARNESS and item.line is not None]
        for model in list_clearances(guard_joints(self.program), meshes=True) if asked else ():
            for index in asked:
                item = self.findings[index]
                own = [k for k, one in enumerate(model.names) if one.code == item.code and _is_about(item, one.name)]
                first = item.line or 0
                frames = np.flatnonzero((line >= first) & (line <= (item.last_line or first)))
                frames = frames[np.isfinite(pose.q[frames]).all(axis=1)]
                if own and len(frames):
                    error = item.severity == "error"
                    limits = [one.error_below if error else one.warn_below for one in model.names]
                    excess = model.evaluate(pose.take(frames))[0] - limits + model.slack
                    nearest = excess[:, own].min(axis=1)
                    below = np.flatnonzero(nearest < 0)
                    yield index, int(frames[below[0] if len(below) else nearest.argmin()])


def _is_about(item: Finding, name: str) -> bool:
    """Whether a finding is about a distance of this name."""
    return item.quantity == name or item.message.startswith(name)


def _turn_table(machine: Machine, q: Array) -> tuple[Array, Array]:
    """Tilt and turn (n,) of what carries the part, rad: 0 for a joint that carries the tool."""
    tilt, turn = (
        q[:, column] * (axis not in machine.coordinates.head)
        for column, axis in zip((-2, -1), machine.coordinates.rotary, strict=True)
    )
    return tilt, turn


def _find_bad(findings: tuple[Finding, ...], line: Ints, margin: Array) -> Mask:
    """Points (n,) in violation: :class:`Trail`."""
    bad = np.zeros(len(line), dtype=bool)
    for item in findings:
        if item.severity == "error" and item.line is not None:
            on_line = (line >= item.line) & (line <= (item.last_line or item.line))
            beyond = on_line & ~(margin >= 0)
            bad |= beyond if beyond.any() else on_line
    return bad


def _find_worst_line(item: Finding) -> int:
    return item.worst_line or item.line or -1


def _join(parts: Iterable[tuple[NDArray[Any], ...]]) -> Iterator[NDArray[Any]]:
    """Concatenate blocks, column by column."""
    return (np.concatenate(each) for each in zip(*parts, strict=True))


def _find_extremes(values: Array, begins: Ints) -> Ints:
    """Indices of first, lowest and highest value and first NaN in groups of values (n,) from ``begins`` on."""
    group = np.repeat(np.arange(len(begins)), np.diff(np.append(begins, len(values))))
    low, high = np.fmin.reduceat(values, begins), np.fmax.reduceat(values, begins)
    chosen: list[Any] = [begins]
    for matches in (values == low[group], values == high[group], np.isnan(values)):
        at = np.flatnonzero(matches)
        chosen.append(at[np.unique(group[at], return_index=True)[1]])
    return np.unique(np.concatenate(chosen))


def _study_findings(machine: Machine, options: Options, findings: tuple[Finding, ...]) -> Study:
    """Study a program that cannot be read: it has findings and a set-up, and no motion."""
    none, three, whole = np.empty(0), np.empty((0, 3)), np.empty(0, dtype=np.int64)
    joints = np.empty((0, len(machine.columns)))
    curves = {"position": (Curve(none, none),) * len(machine.columns)}
    return Study(
        findings,
        options,
        None,
        None,
        None,
        (),
        None,
        None,
        False,
        none,
        whole,
        joints,
        curves,
        Trail(whole, whole, three, none, none, whole > 0, whole > 0),
        three,
        three,
        none,
        none,
        whole,
        (),
        whole,
        none,
        three,
        three,
        np.empty((0, 2, 3)),
        np.empty((0, 0, 2, 3)),
        none,
        none,
        none,
        np.full(len(findings), -1),
        np.full((len(findings), 3), np.nan),
    )
