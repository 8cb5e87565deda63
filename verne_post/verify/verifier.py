"""The verifier: rows in, in order, block by block; a verdict out.

It is handed the programmed pieces as data and the forward kinematics as a function. It checks
velocity, acceleration and jerk by differences of the rows (three rest rows padded at both ends),
travel, the path by forward kinematics, the feed, and completeness: every piece is passed in program
order, from the first pose to the last, and progress never runs back.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.ragged import ragged
from verne_post.base.rows import row_norm
from verne_post.base.tolerances import (
    ACCELERATION_RATIO,
    FEED_RATIO,
    JERK_RATIO,
    LIMIT_SLACK,
    LIMIT_SLACK_MM,
    PATH_AXIS_DEG,
    PATH_TIP_MM,
    ROUNDING_SHARES,
    VELOCITY_RATIO,
)  # fmt: skip
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.contour import Contour
from verne_post.model.findings import Finding, finding
from verne_post.model.machine import Column, Limits
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.verification import Verification
from verne_post.verify.items import items_of, piece_measures
from verne_post.verify.projection import (
    RADIAN_MM,
    Measured,
    deviation,
    deviation_nearby,
    programmed_pose,
    tool_axis,
    unwrapped_u,
    ways,
)

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Forward = Callable[[Array, Array], tuple[Array, Array, NDArray[np.bool_]]]

_REST_ROWS: Final = 3
#: Rounded joints move the tip by at most this many quanta of a linear actuator, and this many mm per radian
#: of a table angle. Half a quantum in each actuator moves the tip by at most 1.5 quanta on the VERNE, 1.6 on the
#: linear delta and 0.9 on the serial machine (measured over the workspaces of the shipped files); a radian of A or C
#: moves sliders by 200 mm, and a tip may be 1 m from the table's axes.
_TIP_PER_SLIDER: Final = 3.0
_TIP_PER_RADIAN_MM: Final = 1000.0
#: Mean square of what rounding adds to a step between two rows, over the square of the largest displacement above: half a
#: unit of the last decimal displaces by half of it, and values between are as likely as others.
_NOISE_SQUARE: Final = 2.0 / 12.0
#: Rows looked at together when several pieces share a source line.
_LOOK_AHEAD: Final = 1024
#: The feed is judged over so many rows.
_FEED_ROWS: Final = (1, 16, 256, 4096)
#: A row that takes less than this share of its cycle at the programmed feed is slow. Laws come to the feed from below, to
#: within two thousandths: nobody could see those.
SLOW: Final = 0.99
#: Rounding that moves the tip by no more than this share of the tolerance is inside it; the decimals chosen by default do.
_FINE_SHARE: Final = 0.1
#: Where a piece between two rows is looked at; no multiples of a turn, for arcs of several.
_BETWEEN: Final = (0.17, 0.41, 0.68, 1.0)
#: What lies between two rows is at most half the way between them from the nearer one; the way is known from the step
#: itself and the one before, and a corner is a little longer than its chord.
_BULGE: Final = 0.6
#: A step along an arc of half a turn is longer than its chord by pi / 2; more than half a turn a row cannot be told.
_ARC_OVER_CHORD: Final = 1.6


def _across(axis: Array) -> Array:
    """Two unit vectors (n, 2, 3) across each axis (n, 3), which need not be one."""
    normal = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    helper = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    one = np.cross(normal, helper)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    return np.stack([one, np.cross(normal, one)], axis=1)


class Verifier:
    """Judges a stream of setpoint rows against a program.

    Parameters
    ----------
    contour : Contour
        The programmed pieces, where they may be stopped between, and how far the motion may be from each. Nothing
        else is taken from it: the geometry that was followed is not looked at.
    forward : callable
        (q, tool_length) -> tip, nominal angles, ok; mm and rad, workpiece sense.
    limits, columns :
        Of the machine.
    fmt : SetpointFormat
        How the rows are rounded, and their cycle.
    """

    def __init__(
        self, contour: Contour, forward: Forward, limits: Limits, columns: tuple[Column, ...], fmt: SetpointFormat
    ) -> None:
        self.path, self.forward, self.limits, self.columns, self.fmt = contour.path, forward, limits, columns, fmt
        self.tip_tolerance, self.axis_tolerance = contour.tip_tolerance, contour.axis_tolerance
        self.entry = contour.entry
        self.measures = piece_measures(contour)
        self.items = items_of(contour, self.measures.chord_length, fmt.cycle)
        self.result = Verification()
        self.factor = np.array([column.factor for column in columns])
        size = np.abs(self.factor)
        self.quanta = fmt.quanta
        dt = fmt.cycle
        self.limit = [limits.velocity * size, limits.acceleration * size, limits.jerk * size]
        # fine decimals are inside the acceptance ratios; coarser ones the user asked for are allowed their own noise
        noise = [2**order * self.quanta / dt ** (order + 1) for order in range(3)]
        self.noise = [
            np.where(one > share * limit * (1 + 1e-12), one, 0.0)
            for one, share, limit in zip(noise, ROUNDING_SHARES, self.limit, strict=True)
        ]
        self.worst = [np.zeros(len(columns)) for _ in range(3)]
        inside = self.quanta / size
        self.tip_noise = float(_TIP_PER_SLIDER * inside[:-2].max() + _TIP_PER_RADIAN_MM * inside[-2:].max())
        self.tail = np.empty((0, len(columns)))
        self.counts: dict[str, Finding] = {}
        # where the last row was: item, its u, its line
        self.item, self.u, self.group = -1, 0.0, -1
        self.line: int | None = None
        self.dwelt = 0
        self.pose: Array | None = None
        self.axis: Array | None = None
        self.moved = np.zeros(5)
        self.feed_totals, self.feed_slacks = np.zeros(1), np.zeros(1)
        self.lost = False

    # --- stream ---------------------------------------------------------------------------

    def feed(self, block: SetpointBlock) -> None:
        """Judge the next rows."""
        if not len(block.values):
            return
        values = block.values
        if self.result.n_rows == 0:
            self.result.first_row = values[0].copy()
            self.tail = np.repeat(values[:1], _REST_ROWS, axis=0)
        self._dynamics(np.concatenate([self.tail, values]), block.first, block.line)
        self._travel(values, block)
        if not self.lost:
            self._path(block)
        self.tail = np.concatenate([self.tail, values])[-_REST_ROWS:]
        self.result.n_rows += len(values)

    def finish(self) -> Verification:
        """Judge the end of the file and return the verdict."""
        result = self.result
        if result.n_rows == 0:
            self._note("VP412", "the file has no rows", None)
        else:
            end = np.repeat(self.tail[-1:], _REST_ROWS, axis=0)
            self._dynamics(np.concatenate([self.tail, end]), result.n_rows, None)
            if not self.lost:
                self._complete()
        result.velocity_ratio, result.acceleration_ratio, result.jerk_ratio = (
            worst / limit for worst, limit in zip(self.worst, self.limit, strict=True)
        )
        result.findings = list(self.counts.values())
        return result

    def _note(self, code: str, message: str, line: int | None, **more: object) -> None:
        """Keep the first finding of each kind and count the others."""
        key = f"{code}{more.get('axis', '')}"
        if key in self.counts:
            self.counts[key] = replace(self.counts[key], count=self.counts[key].count + 1)
        else:
            self.counts[key] = finding(code, message, line=line, last_line=line, worst_line=line, **more)

    # --- limits ---------------------------------------------------------------------------

    def _dynamics(self, values: Array, first: int, lines: Ints | None) -> None:
        """Differences of rows; ``values`` begins with the rows before row ``first``."""
        dt = self.fmt.cycle
        difference = values
        names = (("VP401", "velocity", VELOCITY_RATIO), ("VP402", "acceleration", ACCELERATION_RATIO),
                 ("VP403", "jerk", JERK_RATIO))  # fmt: skip
        nearest, self.binding = np.zeros(len(values) - _REST_ROWS), np.zeros(len(values) - _REST_ROWS, dtype=np.int64)
        for order, (code, name, ratio) in enumerate(names):
            difference = np.diff(difference, axis=0) / dt
            # only differences that end in a new row: the others have been judged before
            size = np.abs(difference[_REST_ROWS - 1 - order :])
            share = size / self.limit[order]
            joint_of_row = share.argmax(axis=1)
            top = share[np.arange(len(share)), joint_of_row]
            nearer = top > nearest
            nearest = np.where(nearer, top, nearest)
            self.binding = np.where(nearer, order * len(self.columns) + joint_of_row, self.binding)
            self.worst[order] = np.maximum(self.worst[order], size.max(axis=0))
            bound = ratio * self.limit[order] + self.noise[order]
            for joint in np.flatnonzero((size > bound).any(axis=0)):
                rows = np.flatnonzero(size[:, joint] > bound[joint])
                column, row = self.columns[joint], int(rows[0])
                line = None if lines is None else int(lines[row])
                unit = f"{column.unit}/s{order + 1}" if order else f"{column.unit}/s"
                self._note(
                    code, f"row {first + row}: {name} of {column.joint} {size[row, joint]:.6g} {unit} exceeds "
                    f"{self.limit[order][joint]:g} {unit} ({len(rows)} rows)", line, axis=column.joint,
                    value=float(size[row, joint]), limit=float(self.limit[order][joint]), unit=unit,
                )  # fmt: skip

    def _travel(self, values: Array, block: SetpointBlock) -> None:
        inside = values / self.factor
        for joint, column in enumerate(self.columns):
            slack = (LIMIT_SLACK_MM if column.unit == "mm" else LIMIT_SLACK) + self.quanta[joint] / abs(
                self.factor[joint]
            )
            low, high = self.limits.lower[joint], self.limits.upper[joint]
            bad = np.flatnonzero(~((inside[:, joint] >= low - slack) & (inside[:, joint] <= high + slack)))
            if len(bad):
                row = int(bad[0])
                limit = (low if inside[row, joint] < low else high) * column.factor
                self._note(
                    column.code, f"row {block.first + row}: {column.header} = {values[row, joint]:.6f} is beyond {limit:g}",
                    int(block.line[row]), axis=column.joint, value=float(values[row, joint]), limit=float(limit),
                    unit=column.unit,
                )  # fmt: skip

    # --- path -----------------------------------------------------------------------------

    def _path(self, block: SetpointBlock) -> None:
        group, stray = self._groups(block)
        if stray is not None:
            self._lost_at(block, len(group), "VP413", stray)
            return
        item: Ints = self.items.group_first[group]
        several = self.items.group_first[group + 1] - item > 1
        q = block.values / self.factor
        if several.any():
            item = self._split_groups(q, group, item, several)
        piece = self.items.piece[item]
        dwell = piece < 0
        at = np.where(dwell, np.minimum(self.items.rest_piece[item], len(self.path) - 1), piece)
        tip, angles, ok = self.forward(q, self.path.tool_length[at])
        if not ok.all():
            self._lost_at(block, int(np.argmin(ok)), "VP411", ": the joint values close no position of the platform")
            return
        measured = Measured(q, tip, angles)
        fresh = np.append(item[0] != self.item, item[1:] != item[:-1])
        u = unwrapped_u(self.path, at, measured, fresh, self.u)
        resting = np.where(self.items.rest_piece[item] < len(self.path), 0.0, 1.0)
        u = np.where(dwell, resting, u)
        self._deviations(block, at, u, measured)
        self._progress(block, item, at, u, dwell, measured)
        dwelt = self._rows_before(item, len(item))
        self.item, self.u, self.group, self.line = int(item[-1]), float(u[-1]), int(group[-1]), int(block.line[-1])
        self.dwelt = dwelt

    def _lost_at(self, block: SetpointBlock, row: int, code: str, text: str) -> None:
        """Judge the rows of a block before one from which on the path cannot be followed."""
        if row:
            self._path(SetpointBlock(block.first, block.values[:row], block.line[:row], block.format))
        self._note(code, f"row {block.first + row}{text}", int(block.line[row]))
        self.lost = True

    def _groups(self, block: SetpointBlock) -> tuple[Ints, str | None]:
        """Group of each row by its source line, up to one whose line is not the program's next, and what is wrong with that."""
        line = block.line.astype(np.int64)
        previous = np.append(self.line if self.line is not None else -2, line[:-1])
        group = self.group + np.cumsum(line != previous)
        while True:
            beyond = group >= len(self.items.group_line)
            expected = self.items.group_line[np.minimum(group, len(self.items.group_line) - 1)]
            wrong = np.flatnonzero(beyond | (expected != line))
            if not len(wrong):
                return group, None
            row = int(wrong[0])
            hop = self._skipped(int(group[row]), int(line[row]))
            if hop is None:
                where = f"line {expected[row]}" if not beyond[row] else "the end"
                hint = (
                    "; line 0 is a way to or from the program: give the --from and --to of the conversion"
                    if not line[row]
                    else ""
                )
                return group[:row], f" belongs to line {line[row]}, where the program has {where}{hint}"
            group[row:] += hop

    def _skipped(self, group: int, line: int) -> int | None:
        """How many whole pieces of one run were passed between two rows, None if the line does not follow."""
        for hop in range(1, len(self.items.group_line) - group):
            first = self.items.group_first[group + hop]
            if self.items.stop_before[self.items.group_first[group] : first].any():
                return None
            if self.items.group_line[group + hop] == line:
                return hop
        return None

    def _split_groups(self, q: Array, group: Ints, item: Ints, several: NDArray[np.bool_]) -> Ints:
        """Which item of its group each row belongs to, for groups of several items."""
        item = item.copy()
        edges = np.flatnonzero(np.diff(group, prepend=-1, append=-1))
        for begin, end in pairwise(edges.tolist()):
            if not several[begin]:
                continue
            first = int(self.items.group_first[group[begin]])
            last = int(self.items.group_first[group[begin] + 1]) - 1
            continued = begin == 0 and group[0] == self.group
            now, dwelt = (self.item, self.dwelt) if continued else (first, 0)
            u = self.u if continued else None
            row = begin
            while row < end:
                if now == last:
                    item[row:end] = now
                    break
                if self.items.piece[now] < 0:
                    take = min(int(self.items.dwell_cycles[now]) - dwelt, end - row)
                else:
                    take = self._rows_of_item(q[row:end], now, u)
                item[row : row + take] = now
                row += take
                if row < end:
                    now, u, dwelt = now + 1, None, 0
        return item

    def _rows_of_item(self, q: Array, item: int, u_before: float | None) -> int:
        """How many of the following rows lie before the end of a piece, whose u the row before has; None if it is not on it."""
        piece = int(self.items.piece[item])
        close = 1.0 - self.tip_noise / self.measures.told_by[piece]
        for begin in range(0, len(q), _LOOK_AHEAD):
            some = q[begin : begin + _LOOK_AHEAD]
            at = np.full(len(some), piece)
            tip, angles, _ok = self.forward(some, self.path.tool_length[at])
            fresh = np.zeros(len(some), dtype=bool)
            fresh[0] = u_before is None
            u = unwrapped_u(self.path, at, Measured(some, tip, angles), fresh, u_before or 0.0)
            past = np.flatnonzero(u >= close)
            if len(past):
                return begin + int(past[0])
            u_before = float(u[-1])
        return len(q)

    def _deviations(self, block: SetpointBlock, piece: Ints, u: Array, measured: Measured) -> None:
        tip_off, axis_off, rotary_off = deviation(self.path, piece, np.clip(u, 0.0, 1.0), measured)
        # rounding of coarse decimals moves the tip too; fine ones are far below the tolerance
        coarse = any(noise.any() for noise in self.noise) or self.tip_noise > _FINE_SHARE * PATH_TIP_MM
        allowed = np.maximum(PATH_TIP_MM, self.tip_tolerance[piece]) + coarse * self.tip_noise
        turned = np.maximum(PATH_AXIS_DEG * RAD_PER_DEG, self.axis_tolerance[piece]) + self._angle_noise()
        doubtful = np.flatnonzero(
            (self.measures.rounded[piece] | (self.path.circle[piece] >= 0))
            & ~((tip_off <= allowed) & (axis_off <= turned) & (rotary_off <= turned))
        )
        if len(doubtful):
            some = Measured(measured.q[doubtful], measured.tip[doubtful], measured.angles[doubtful])
            tip_off[doubtful], axis_off[doubtful], rotary_off[doubtful] = deviation_nearby(
                self.path,
                piece[doubtful],
                u[doubtful],
                some,
                allowed[doubtful],
                turned[doubtful],
                self.measures.chord_length[piece[doubtful]],
            )
        result = self.result
        result.tip_deviation_mm = max(result.tip_deviation_mm, float(tip_off.max()))
        result.axis_deviation_deg = max(result.axis_deviation_deg, float(axis_off.max()) / RAD_PER_DEG)
        for off, bound, what, unit, factor in (
            (tip_off, allowed, "tip", "mm", 1.0),
            (axis_off, turned, "tool axis", "deg", 1 / RAD_PER_DEG),
            (rotary_off, turned, "rotary angle", "deg", 1 / RAD_PER_DEG),
        ):
            bad = np.flatnonzero(~(off <= bound))
            if len(bad):
                row = int(bad[0])
                self._note(
                    "VP411", f"row {block.first + row}: the {what} is {off[row] * factor:.6f} {unit} off the programmed piece, "
                    f"allowed {bound[row] * factor:.6f} {unit} ({len(bad)} rows)", int(block.line[row]),
                    value=float(off[row] * factor), limit=float(bound[row] * factor), unit=unit,
                )  # fmt: skip

    def _angle_noise(self) -> float:
        return float(2 * (self.quanta[-2:] / np.abs(self.factor[-2:])).max())

    def _progress(
        self, block: SetpointBlock, item: Ints, piece: Ints, u: Array, dwell: NDArray[np.bool_], measured: Measured
    ) -> None:
        """Order, completeness between items, and feed."""
        path = self.path
        even = self.measures.told_by
        before_item = np.append(self.item, item[:-1])
        before_u = np.append(self.u, u[:-1])
        noise_u = 2 * self.tip_noise / even[piece] + self.measures.corner_u[piece]
        same = before_item == item
        # each of two rows may stand aside of the piece, one ahead of its place and one behind
        back = np.flatnonzero(same & ~dwell & ~(u >= before_u - noise_u - self.measures.corner_u[piece]))
        if len(back):
            row = int(back[0])
            self._note("VP413", f"row {block.first + row}: progress on line {block.line[row]} runs back ({len(back)} rows)",
                       int(block.line[row]))  # fmt: skip
        margin = noise_u + PATH_TIP_MM / even[piece]
        outside = np.flatnonzero(~dwell & ((u < -margin) | (u > 1 + margin)))
        if len(outside):
            row = int(outside[0])
            self._note("VP413", f"row {block.first + row} lies beyond the ends of the piece of line {block.line[row]}",
                       int(block.line[row]))  # fmt: skip
        step = np.where(same & ~dwell, u - before_u, 0.0)
        budget = step * path.feed_time[piece]
        way = self._way(item, u) - self._way(item, np.where(same & ~dwell, before_u, u))
        slack = np.where(dwell, 0.0, 4 * self.tip_noise / even[piece] * path.feed_time[piece])
        now = np.concatenate([measured.tip, RADIAN_MM * measured.angles], axis=1)
        moved = now - np.vstack([now[:1] if self.pose is None else self.pose[None], now[:-1]])
        before = now - moved
        self.pose = now[-1]
        swung = self._swung(measured.angles)
        chord, chord_slack = self._chord_time(piece, moved, swung)
        changed = np.flatnonzero(~same)
        if len(changed):
            old, new = before_item[changed], item[changed]
            self._judge_changes(block, item, changed, old, new, u[changed])
            budget[changed], way[changed], more = self._spent(old, new, before_u[changed], u[changed])
            slack[changed] += more
            step, one, part = self._passed(changed, old, new, before_u[changed], u[changed])
            # a corner is shorter than its vertex: the step itself counts, by the fastest piece that it touches
            way[step], chord[step], chord_slack[step] = 0.0, np.inf, np.inf
            for found, passing in zip(
                (chord, chord_slack), self._chord_time(one, moved[step], swung[step]), strict=True
            ):
                np.minimum.at(found, step, passing)
            goes_on = ~self.items.stop_before[item[step]]
            self._judge_between(block, *self._places(step[goes_on], one[goes_on], part[goes_on]), before, moved)
        self.moved = moved[-1]
        by_chord = self.measures.rounded[piece] & ~dwell
        budget, slack = np.where(by_chord, chord, budget), np.where(by_chord, chord_slack, slack)
        self._judge_feed(block, budget, slack)
        self._count_slow(budget + slack)
        # a corner may cut turns short that are narrower than its tolerance: there the tolerance tells
        self._judge_chords(block, row_norm(moved), np.where(self.measures.rounded[piece] & same, 0.0, way))

    def _judge_feed(self, block: SetpointBlock, budget: Array, slack: Array) -> None:
        """Time at the programmed feed that rows take, over one row and over many: rounding weighs less over many."""
        dt, n = self.fmt.cycle, len(budget)
        # totals and slacks of the rows before this block reach back as far as the longest stretch
        totals = np.append(self.feed_totals, self.feed_totals[-1] + np.cumsum(budget))
        slacks = np.append(self.feed_slacks, slack)
        self.feed_totals, self.feed_slacks = totals[-_FEED_ROWS[-1] :], slacks[-_FEED_ROWS[-1] :]
        for rows in _FEED_ROWS:
            first = max(len(totals) - n, rows)
            if first >= len(totals):
                break
            spent = totals[first:] - totals[first - rows : len(totals) - rows]
            noise = np.maximum(slacks[first:], slacks[first - rows : len(slacks) - rows])
            certain = np.zeros(n)
            certain[n - len(spent) :] = (spent - noise) / (rows * dt)
            top = int(np.argmax(certain))
            if certain[top] > self.result.feed_ratio:
                self.result.feed_ratio, self.result.feed_line = float(certain[top]), int(block.line[top])
            bad = np.flatnonzero(certain > FEED_RATIO)
            if len(bad):
                row = int(bad[0])
                self._note(
                    "VP404",
                    f"row {block.first + row}: {certain[row]:.6f} of the programmed feed on line {block.line[row]} "
                    f"({len(bad)} rows)",
                    int(block.line[row]),
                    value=float(certain[row]),
                    limit=FEED_RATIO,
                    unit="of the feed",
                )

    def _count_slow(self, budget: Array) -> None:
        """Rows of feed moves that fall short of the feed, by the limit that was nearest."""
        slow = (budget > 0) & (budget < SLOW * self.fmt.cycle)
        count = np.bincount(self.binding[: len(slow)][slow], minlength=3 * len(self.columns))
        for index in np.flatnonzero(count).tolist():
            kind, joint = divmod(index, len(self.columns))
            key = (("velocity", "acceleration", "jerk")[kind], self.columns[joint].joint)
            self.result.slow[key] = self.result.slow.get(key, 0.0) + float(count[index]) * self.fmt.cycle

    def _swung(self, angles: Array) -> Array:
        """Angle (n,) by which the tool axis has turned since the row before, rad."""
        axis = tool_axis(angles)
        before = np.vstack([axis[:1] if self.axis is None else self.axis[None], axis[:-1]])
        self.axis = axis[-1]
        return row_norm(axis - before)

    def _chord_time(self, piece: Ints, moved: Array, swung: Array) -> tuple[Array, Array]:
        """Seconds (n,) that steps take at the feed of pieces (n,), 0 for rapids, and by how much rounding may change them.

        Steps are given by tip and weighted angles (n, 5), and by the angle of the tool axis (n,). Rounding makes every step
        longer across its direction, so that a sum of steps grows with their number: the mean of that is taken off.
        """
        one = self.measures
        by_tip, by_turn = one.tip_pace[piece], one.turn_pace[piece] / RADIAN_MM
        by_swing = one.swing_pace[piece] / RADIAN_MM
        square = _NOISE_SQUARE * self.tip_noise**2
        tip, turn, swing = (
            np.sqrt(np.maximum(size**2 - square, 0.0))
            for size in (row_norm(moved[:, :3]), row_norm(moved[:, 3:]), RADIAN_MM * swung)
        )
        return tip * by_tip + turn * by_turn + swing * by_swing, 4 * self.tip_noise * (by_tip + by_turn + by_swing)

    def _passed(self, row: Ints, old: Ints, new: Ints, old_u: Array, new_u: Array) -> tuple[Ints, Ints, Array]:
        """What steps from one item to a later one (n,) touch, where a corner of it may be rounded.

        Returns
        -------
        row, piece : ndarray, shape (m,)
            In order.
        part : ndarray, shape (m, 2)
            Between which u the step passes the piece, from 0 to 1.
        """
        begin = np.maximum(old, 0)
        step, within = ragged(new - begin + 1)
        piece = self.items.piece[begin[step] + within]
        step, piece = step[piece >= 0], piece[piece >= 0]
        rounded = np.zeros(len(row), dtype=bool)
        rounded[step[self.measures.rounded[piece]]] = True
        step, piece = step[rounded[step]], piece[rounded[step]]
        first, last = np.diff(step, prepend=-1) != 0, np.diff(step, append=-1) != 0
        low = np.where(first, np.clip(old_u[step], 0.0, 1.0), 0.0)
        high = np.where(last, np.clip(new_u[step], 0.0, 1.0), 1.0)
        return row[step], piece, np.stack([low, high], axis=1)

    def _places(self, row: Ints, piece: Ints, part: Array) -> tuple[Ints, Ints, Array]:
        """Rows, pieces and u of places that steps pass, from what they touch; of straight pieces the ends tell everything."""
        straight = (self.path.arc[piece] < 0) & (self.path.circle[piece] < 0)
        last = np.diff(row, append=-1) != 0
        touch, within = ragged(np.where(straight, ~last, len(_BETWEEN)))
        share = np.where(straight[touch], _BETWEEN[-1], np.array(_BETWEEN)[within])
        low, high = part[touch].T
        return row[touch], piece[touch], low + share * (high - low)

    def _judge_between(
        self, block: SetpointBlock, row: Ints, piece: Ints, u: Array, before: Array, moved: Array
    ) -> None:
        """What the program has between two rows, at u of pieces (m,), must lie near the straight step between them.

        A pose of the step within both bounds has a sum of squared shares of at most 2, and so has the nearest one.
        """
        if not len(row):
            return
        tip, angles = programmed_pose(self.path, piece, u)
        size = np.stack([row_norm(moved[:, :3]), row_norm(moved[:, 3:])])
        last = np.stack([np.linalg.norm(self.moved[:3]), np.linalg.norm(self.moved[3:])])
        size = np.maximum(size, np.concatenate([last[:, None], size[:, :-1]], axis=1))[:, row]
        # the pieces that a step passes share their corners, and each corner its tolerance
        tip_bound, axis_bound = np.zeros(len(moved)), np.zeros(len(moved))
        np.maximum.at(tip_bound, row, self.tip_tolerance[piece])
        np.maximum.at(axis_bound, row, self.axis_tolerance[piece])
        bound = np.empty((len(row), 5))
        bound[:, :3] = (tip_bound[row] + PATH_TIP_MM + self.tip_noise + _BULGE * size[0])[:, None]
        turn = axis_bound[row] + PATH_AXIS_DEG * RAD_PER_DEG + self._angle_noise()
        bound[:, 3:] = (RADIAN_MM * turn + _BULGE * size[1])[:, None]
        first, step = before[row], moved[row]
        # along a great circle the tool axis goes evenly; near the pole A and C do not
        swung = np.flatnonzero(self.path.circle[piece] >= 0)
        axis = np.concatenate([tip, RADIAN_MM * angles], axis=1)
        if len(swung):
            ends = [RADIAN_MM * tool_axis(at[swung, 3:] / RADIAN_MM) for at in (first, first + step)]
            here = RADIAN_MM * tool_axis(angles[swung])
            # two components tell the axis apart: those across the mean of both ends
            across = _across(ends[0] + ends[1])
            start, stop, place = (np.einsum("nij,nj->ni", across, vector) for vector in (*ends, here))
            first[swung, 3:], step[swung, 3:], axis[swung, 3:] = start, stop - start, place
        off = (axis - first) / bound
        step /= bound
        along = np.sum(off * step, axis=1) / np.maximum(np.sum(step**2, axis=1), np.finfo(float).tiny)
        off -= np.clip(along, 0.0, 1.0)[:, None] * step
        bad = np.flatnonzero(np.sum(off**2, axis=1) > 2.0)
        if len(bad):
            worst = int(row[bad[0]])
            line = int(self.path.line[piece[bad[0]]])
            self._note(
                "VP412", f"row {block.first + worst}: the motion of line {line} is left out", int(block.line[worst])
            )

    def _judge_chords(self, block: SetpointBlock, moved: Array, way: Array) -> None:
        """Progress along the path needs motion: a full circle is not passed by standing still."""
        bad = np.flatnonzero(way > _ARC_OVER_CHORD * moved + PATH_TIP_MM + 2 * self.tip_noise)
        if len(bad):
            row = int(bad[0])
            text = f"row {block.first + row}: {way[row]:.4f} mm of the path of line {block.line[row]} are left out"
            self._note("VP412", text, int(block.line[row]))

    def _judge_changes(self, block: SetpointBlock, item: Ints, row: Ints, old: Ints, new: Ints, u: Array) -> None:
        """Steps from one item to a later one (n,): nothing is left out, and stops are stopped at."""
        stops_there = self.items.stop_before[new]
        skips = self._stops(old, new) > stops_there
        after_dwell = (old >= 0) & (self.items.piece[old] < 0)
        piece = self.items.piece[new]
        # a restart may begin beside the corner that the whole program would round
        aside = np.where(piece == self.entry, self.measures.corner_u[piece] * self.measures.told_by[piece], 0.0)
        off = np.abs(u) * self.measures.told_by[piece] > PATH_TIP_MM + self.tip_noise + aside
        off &= stops_there & (piece >= 0)
        for at in np.flatnonzero(skips | after_dwell | off).tolist():
            where, line = f"row {block.first + row[at]}", int(block.line[row[at]])
            if skips[at]:
                skipped = self.items.line[old[at] + 1 : new[at]]
                lines = ", ".join(str(value) for value in skipped[:5]) or str(line)
                self._note("VP412", f"{where}: the motion of line {lines} is left out", line)
                continue
            if after_dwell[at] and self._rows_before(item, int(row[at])) < self.items.dwell_cycles[old[at]]:
                self._note("VP412", f"{where}: the dwell of line {self.items.line[old[at]]} is too short", line)
            if off[at]:
                what = f"the end of the piece before line {line} is not reached"
                if old[at] < 0:
                    what = "the file does not begin at the start pose"
                self._note("VP412", f"{where}: {what}", line)

    def _stops(self, old: Ints, new: Ints) -> Ints:
        """How many stops stand between items, that before the new one included."""
        return self.items.stops_before[new + 1] - self.items.stops_before[old + 1]

    def _spent(self, old: Ints, new: Ints, old_u: Array, new_u: Array) -> tuple[Array, Array, Array]:
        """Seconds at the programmed feed, way (mm), and seconds of noise more, of steps from one item to a later one (n,).

        Nothing where a stop has been left out.
        """
        from_item, begun = np.maximum(old, 0), old >= 0
        left = np.where(begun, np.maximum(1.0 - old_u, 0.0), 0.0)
        came = np.maximum(new_u, 0.0)
        one, before = self._time, self.items.time_before
        spent = left * one(from_item) + (before[new] - before[old + 1]) + came * one(new)
        way = self._way(from_item, np.ones(len(old))) - self._way(from_item, 1.0 - left)
        way += self.items.way_before[new] - self.items.way_before[old + 1] + self._way(new, came)
        last = self.items.piece[from_item]
        noise = np.where(
            begun & (last >= 0), 2 * self.tip_noise / self.measures.told_by[last] * self._time(from_item), 0.0
        )
        whole = self._stops(old, new) <= self.items.stop_before[new]
        return spent * whole, way * whole, noise

    def _time(self, item: Ints) -> Array:
        """Seconds (n,) that items take at the programmed feed."""
        piece = self.items.piece[item]
        return np.where(piece >= 0, self.path.feed_time[piece], 0.0)

    def _way(self, item: Ints, u: Array) -> Array:
        """Way (n,) from the start of items to u (n,), mm; 0 for dwells."""
        piece = self.items.piece[item]
        return np.where(piece >= 0, ways(self.path, piece, u, self.measures.chord_length), 0.0)

    def _rows_before(self, item: Ints, row: int) -> int:
        """How many rows the item before ``row`` has had; those of earlier blocks count."""
        if row == 0:
            return self.dwelt
        old = item[row - 1]
        other = np.flatnonzero(item[:row] != old)
        begin = int(other[-1]) + 1 if len(other) else 0
        return row - begin + (self.dwelt if begin == 0 and old == self.item else 0)

    def _complete(self) -> None:
        last = len(self.items.piece) - 1
        line = self.line
        if self.item < last:
            missing = self.items.line[self.item + 1]
            self._note("VP412", f"the file ends on line {line}; the motion of line {missing} is missing", line)
            return
        piece = int(self.items.piece[last])
        if piece >= 0 and abs(1.0 - self.u) * self.measures.told_by[piece] > PATH_TIP_MM + self.tip_noise:
            self._note("VP412", f"the file ends before the end of the motion of line {line}", line)
        if piece < 0 and self.dwelt < self.items.dwell_cycles[last] + 1:
            self._note("VP412", f"the dwell of line {line} is too short", line)
