"""Stock that is cut in the order of time, and what touches it on the way.

A rapid traverse is checked along its whole line against the stock as it is, then cuts it: a turn is many short spans,
and each would meet only what the span before has left. A rounded corner that begins it is checked before the rest. In
feed motion the cutter cuts short stretches, of one long span or of many short ones; shank, holder and spindle are
checked after each.

Bodies are checked twice. They are made smaller by the error of the model: a ray that still meets material is a certain
touch. They are made larger by what may lie between rays: if no ray meets material, they are clear. Between the two
nothing is decided, except where the tool follows its own cut, or only moves away from where it stood while cutting:
both leave it as clear as before.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import ClassVar, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.part.bodies import Piece, measure_phi
from verne_post.part.clearance import TOUCH_MM
from verne_post.part.dexels import Dexels, Sweeps, count_bodies, find_boxes, find_upright, list_sweeps, load_compiled
from verne_post.part.ray_tables import RayTable, make_table
from verne_post.part.thin_cutters import LINE_RADIUS_MM, ThinCuts
from verne_post.part.tool_spans import (
    STRETCH_MM,
    Spans,
    Tool,
    group_spans,
    join_stretches,
    list_pairs,
    place_along,
    split_span,
)
from verne_post.part.ways import find_ways, follows_ways, list_columns

#: Standing bodies are so far from each other, mm.
STEP_MM: Final = 0.1
#: Spans of feed motion before which the stock is asked which bodies it can meet on them at all.
MOST_AHEAD: Final = 128
#: In a contact that goes on, stretches that are cut and checked together at most: it is an error already.
MOST_IN_CONTACT: Final = 4
#: Smaller stretches, where one enters or leaves the way that the tool has cut.
FINE_MM: Final = 0.05
#: Stands for an enlargement by what may lie between rays.
RESOLVED: Final = np.inf
#: Compiling takes as long as this many bodies without.
WORTH_COMPILING: Final = 3000
#: Places along a stretch at which the distance of points is measured: at least, and where the depth of a long one is.
PLACES: Final = 17
MOST_PLACES: Final = 401
#: Places at which it is first measured: most points are seen to be nowhere the deepest.
FEW_PLACES: Final = 3
#: So many distances are measured together: on a long rapid that turns the tool, many points stay near many places.
AT_A_TIME: Final = 1 << 15
#: Rays with the longest overlaps at which it is measured, and as many evenly among the others.
MEASURED_RAYS: Final = 300
#: Standing bodies of one span on whose rays it is measured; on a long one they are farther apart than ``STEP_MM``.
MEASURED_BODIES: Final = 20
#: Rays across a body from which these are chosen, if that leaves enough.
CHOSEN_FROM: Final = 10_000
#: To this its radius is told, mm, from the room that it has in rapids.
ROOM_MM: Final = 1.0
#: Points of a contact that are asked for.
LINE_POINTS: Final = 16
#: The depth of a long contact is measured again after this share of itself: it changes by no more than the body moves.
DEPTH_SHARE: Final = 0.05


class Touch(Struct, frozen=True):
    """A body in the stock, on one span."""

    span: int
    line: int
    body: str
    depth: float  #: mm; negative where it only passes too near; NaN where it is not decided whether it touches.
    #: Where the contact begins: how far the tip has come along its line, and how far it goes, mm. 0 where undecided.
    begin: tuple[float, float] = (0.0, 0.0)
    begin_turn: tuple[float, float] = (0.0, 0.0)  #: The same of the tool axis in the part, deg.
    tip: tuple[float, float, float] | None = None  #: There, in the table frame, mm; None where undecided.
    by_line: bool = False  #: Undecided because a cutter of unknown diameter may have cut the material before.
    #: From a certain contact to the cuts of such cutters, mm; infinite below or far above them, NaN without.
    line_gap: float = np.nan


#: Where the contact begins of a touch that is undecided.
NO_BEGIN: Final = (0.0, 0.0), (0.0, 0.0), None


class Cut(Struct, frozen=True, eq=False):
    """What a run has cut: volume of each span (n,), mm3, and what touched the stock."""

    volume: Array
    touches: tuple[Touch, ...]

    def sum_by(self, number: Ints) -> dict[int, float]:
        """Volume by line, or by tool (n,), mm3."""
        numbers, index = np.unique(number, return_inverse=True)
        return dict(zip(numbers.tolist(), np.bincount(index, self.volume, len(numbers)).tolist(), strict=True))


def cut_stock(
    stock: Dexels,
    spans: Spans,
    tools: Sequence[Tool],
    keep_off: float = 0.0,
    report: Callable[[int], None] | None = None,
    *,
    only_first: bool | str = False,
    only_spans: bool = False,
) -> Cut:
    """Run spans of motion through a stock, which is cut.

    Parameters
    ----------
    keep_off : float
        How near other bodies than feeding cutters may come, mm.
    report : callable, optional
        Called with the number of spans that are done.
    only_first : bool or str
        Nothing is cut after the first certain touch, of any body or of those of this name.
    only_spans : bool
        Which spans touch is asked, not where and how deep: certain touches have the depth ``TOUCH_MM``.
    """
    run = _Run(stock, spans, tools, keep_off)
    run.only_first, run.only_spans = only_first, bool(only_first) or only_spans
    if report is not None:
        run.report = report
    tip, axis = stock.place_inside(spans.tip, spans.axis)
    change = (np.diff(spans.tool) != 0) | (np.diff(spans.rapid) != 0)
    for rows in np.split(np.arange(len(spans.line)), np.flatnonzero(change) + 1):
        if len(rows) and not (only_first and run.is_over):
            run.pass_rows(rows, tip[rows], axis[rows])
    begin = run.measure_begins()
    room = np.where(run.rounding > 0, run.rounding - keep_off, -np.inf)
    touches = (
        Touch(
            row,
            int(spans.line[row]),
            body,
            depth,
            way,
            turn,
            at,
            body == "cutter" and depth != depth and row >= run.thin.first_span,
            run.thin.gaps.get(int(spans.line[row]), np.nan)
            if body == "cutter" and row >= run.thin.first_span
            else np.nan,
        )
        for (row, body), depth in run.depth.items()
        for way, turn, at in (begin.get((row, body), NO_BEGIN),)
        if body != "cutter" or not np.nan_to_num(depth) <= room[row]
    )
    return Cut(run.volume, tuple(touches))


class _Run:
    """A stock on its way through a program."""

    #: Bodies that are cut or held against the stock, of all runs: remedies try a short program many times, and what one
    #: run has compiled the next one has. Of feed motion in contact every stretch has its own.
    bodies: ClassVar[int] = 0

    def __init__(self, stock: Dexels, spans: Spans, tools: Sequence[Tool], keep_off: float) -> None:
        self.stock, self.spans, self.tools, self.keep_off = stock, spans, tools, keep_off
        self.report: Callable[[int], None] = lambda _done: None
        self.tables = {
            id(piece): make_table(piece)
            for tool in tools
            for _n, body in tool.list_bodies(with_cutter=True)
            for piece in body
        }
        self.volume = np.zeros(len(spans.line))
        self.rounding = np.zeros(len(spans.line)) if spans.rounding is None else spans.rounding
        #: Depth by span and body; NaN while nothing is decided.
        self.depth: dict[tuple[int, str], float] = {}
        #: Spans of one line in a row, and these by body where a touch is noted: an undecided one more says no more.
        self.run_of_line = np.cumsum(np.diff(spans.line, prepend=spans.line[:1]) != 0)
        self.told: set[tuple[int, str]] = set()
        #: Tip and axis by span and body where a certain contact begins, in the frame of the stock.
        self.begin: dict[tuple[int, str], tuple[Array, Array]] = {}
        _Run.bodies += sum(
            int(count_bodies(spans.tip[own], spans.axis[own], piece.high, STEP_MM).sum())
            for own, tool in ((spans.tool == number, tool) for number, tool in enumerate(tools))
            for piece in tool.cutter
        )
        #: Straight cuts by tool (tip and axis, 2, 3, n), in parts, which a rapid may follow.
        self.cuts: dict[int, list[Array]] = {}
        self.thin = ThinCuts()
        #: By body the last place where the depth of a contact was measured: span, tip, axis, and the depth.
        self.measured: dict[str, tuple[int, Array, Array, float]] = {}
        #: Tools, and their bodies other than the cutter, that have run into the stock.
        self.broken: set[tuple[int, str]] = set()
        #: Whether to stop at the first certain touch, and whether there was one that no rounded corner explains.
        self.only_first: bool | str = False
        self.is_over = False
        self.only_spans = False
        #: Standing bodies leave teeth up to half their distance.
        self.left = 0.0

    @property
    def compiled(self) -> bool:
        """Whether there are so many bodies that compiling pays; the answers are the same."""
        return self.bodies > WORTH_COMPILING and load_compiled() is not None

    def pass_rows(self, rows: Ints, tip: Array, axis: Array) -> None:
        """Spans of one tool, all in rapid traverse or all in feed motion; poses in the frame of the stock."""
        number = int(self.spans.tool[rows[0]])
        tool, past = self.tools[number], self.cuts.setdefault(number, [])
        if self.spans.rapid[rows[0]]:
            if tool.is_line and not self.thin:
                self._find_room(number, tip, axis, tool.cutter)
            self._pass_rapids(rows, tip, axis, tool, past)
            return
        self._pass_feed(rows, tip, axis, tool)
        past.append(list_columns(tip, axis))
        if self.spans.still is not None:
            turning = ~self.spans.still[rows]
            rows, tip, axis = rows[turning], tip[turning], axis[turning]
        if tool.is_line and len(rows):
            self.thin.add(number, rows, tip, axis)

    def _pass_rapids(self, rows: Ints, tip: Array, axis: Array, tool: Tool, past: list[Array]) -> None:
        bodies = dict(tool.list_bodies(with_cutter=True))
        near = self._find_near(tip, axis, bodies.values(), self.keep_off + self.stock.resolution + 0.5 * STEP_MM)
        in_corner = self.rounding[rows] > 0
        changes = (np.diff(self.spans.line[rows]) != 0) | (np.diff(in_corner) != 0)
        for part in np.split(np.arange(len(rows)), np.flatnonzero(changes) + 1):
            stood = tip[part[0], 0], axis[part[0], 0]
            for group in group_spans(part, tip, axis):
                beside = group[near[group]]
                if len(beside) > 1 and self._is_far(tip[group], axis[group], bodies.values()):
                    continue
                for k in beside.tolist():
                    self._check(rows[k : k + 1], tip[k], axis[k], tool, bodies, stood)
            self._cut(rows[part], tip[part], axis[part], tool.cutter)
            self._break(rows[part], tip[part], axis[part], tool)
            past.append(list_columns(tip[part], axis[part]))

    def _pass_feed(self, rows: Ints, tip: Array, axis: Array, tool: Tool) -> None:
        near = self._find_near(tip, axis, tool.others.values(), self.keep_off + self.stock.resolution)
        changes = (np.diff(self.spans.line[rows]) != 0) | (np.diff(near) != 0)
        parts = np.split(np.arange(len(rows)), np.flatnonzero(changes) + 1)
        # of a cutter in two pieces, the first would take what the second has cut on the line before
        joins = find_upright(axis) & (len(tool.cutter) == 1)
        number = np.cumsum([len(part) for part in parts]) // MOST_AHEAD
        for block in np.split(np.arange(len(parts)), np.flatnonzero(np.diff(number)) + 1):
            some = [parts[k] for k in block.tolist()]
            begin, end = some[0][0], some[-1][-1] + 1
            met = {
                name: self._find_met(tip[begin:end], axis[begin:end], near[begin:end], body, tool.follows_cutter(name))
                for name, body in tool.others.items()
            }
            waiting = begin  # spans from here to the next part are cut together
            for part in some:
                bodies = {name: tool.others[name] for name, where in met.items() if where[part - begin].any()}
                if not bodies and joins[part].all():
                    continue
                self._cut_from(waiting, part[0], rows, tip, axis, tool)
                waiting = part[-1] + 1
                if bodies:
                    self._pass_line(rows, tip, axis, part, tool, bodies)
                else:
                    self._cut(rows[part], tip[part], axis[part], tool.cutter)
                if self.only_first and self.is_over:
                    return
            self._cut_from(waiting, end, rows, tip, axis, tool)

    def _cut_from(self, begin: int, end: int, rows: Ints, tip: Array, axis: Array, tool: Tool) -> None:
        """Cut some of the spans, where there are any."""
        if begin < end:
            self._cut(rows[begin:end], tip[begin:end], axis[begin:end], tool.cutter)

    def _pass_line(
        self, rows: Ints, tip: Array, axis: Array, part: Ints, tool: Tool, bodies: Mapping[str, tuple[Piece, ...]]
    ) -> None:
        """Feed motion of one line, in stretches: bodies are checked after each."""
        for group in group_spans(part, tip, axis):
            tips, axes = (np.append(one[group, 0], one[group[-1:], 1], axis=0) for one in (tip, axis))
            stretches = [(tips, axes)] if len(group) > 1 else [*split_span(tips, axes, STRETCH_MM)]
            stands = (axes[0] == axes).all()  # a cutter that turns can cut what another body would have met
            done, together = 0, 1
            while done < len(stretches):
                some = stretches[done : done + together]
                at_tip, at_axis = some[0] if len(some) == 1 else join_stretches(some)
                self._cut(rows[group], *list_pairs(at_tip, at_axis), tool.cutter)
                self._check(rows[group], at_tip, at_axis, tool, bodies)
                if self.only_first and self.is_over:
                    return
                done += together
                touches = any(self.depth.get((int(rows[group[-1]]), name), 0.0) > 0 for name in bodies)
                together = min(2 * together, MOST_IN_CONTACT) if touches and stands else 1
        self._break(rows[part], tip[part], axis[part], tool)

    def _find_met(self, tip: Array, axis: Array, near: Mask, body: tuple[Piece, ...], follows_cutter: bool) -> Mask:
        """Spans (n,) on which a body may meet the stock, or a cut ahead of them has to take material out of its way."""
        met, some = np.zeros(len(tip), dtype=bool), np.flatnonzero(near)
        if not len(some):
            return met
        upright = find_upright(axis)
        # of standing bodies, those of a whole line are not where those of its stretches are
        by = (-TOUCH_MM - self.left if follows_cutter else RESOLVED), 0.5 * STEP_MM * (not upright[some].all())
        for sweeps, table in self._list_enlarged(tip[some], axis[some], body, by[0]):
            touching = self.stock.find_touching(sweeps, table.extend(by[1]), compiled=self.compiled)
            owner = some[sweeps.owner[touching]]
            met[owner] = True
            if not upright[owner].all():  # short spans share bodies
                met[some] |= ~upright[some]
        return met

    def _find_near(self, tip: Array, axis: Array, bodies: Iterable[tuple[Piece, ...]], by: float) -> Mask:
        """Spans (n,) on which a body that is larger by ``by`` may come to the stock."""
        near = np.zeros(len(tip), dtype=bool)
        turn = np.linalg.norm(axis[:, 1] - axis[:, 0], axis=1)[:, None]
        for piece in (one for body in bodies for one in body):
            table = self.tables[id(piece)].extend(by)
            # between two axes a body reaches beyond both boxes by less than this
            beyond = turn * (max(abs(table.low), abs(table.high)) + table.radius)
            for end in range(2):
                low, high = find_boxes(Sweeps(tip[:, 0], tip[:, 1], axis[:, end], np.arange(len(tip))), table)
                near |= ((high + beyond > self.stock.least) & (low - beyond < self.stock.most)).all(axis=1)
        return near

    def _cut(self, rows: Ints, tip: Array, axis: Array, body: tuple[Piece, ...]) -> None:
        self.report(int(rows[0]))
        for piece in body:
            sweeps = list_sweeps(tip, axis, piece.high, STEP_MM)
            volume = self.stock.cut(sweeps, self.tables[id(piece)], compiled=self.compiled)
            self.volume[rows] += np.bincount(sweeps.owner, volume, len(rows))
            if volume[(sweeps.start == sweeps.end).all(axis=1) & (sweeps.axis[:, 2] < 1.0)].any():
                self.left = 0.5 * STEP_MM

    def _break(self, rows: Ints, tip: Array, axis: Array, tool: Tool) -> None:
        """Cut what other bodies than the cutter have run into: it is gone, so that one mistake is one finding."""
        for name, body in tool.list_bodies(with_cutter=False):
            hit = np.array([self.depth.get((row, name), np.nan) > 0 for row in rows.tolist()])
            if hit.any():
                self._cut(rows[hit], tip[hit], axis[hit], body)

    def _check(
        self,
        rows: Ints,
        tip: Array,
        axis: Array,
        tool: Tool,
        bodies: Mapping[str, tuple[Piece, ...]],
        stood: tuple[Array, Array] | None = None,
    ) -> None:
        """Note which bodies touch the stock on n spans in a row, in rapid traverse from where the tool ``stood``.

        ``tip``, ``axis`` (n + 1, 3): where they begin, and where the last one ends.
        """
        self.report(int(rows[0]))
        for name, body in bodies.items():
            follows_cutter = tool.follows_cutter(name)
            if not follows_cutter and not self._is_touching(tip, axis, body, RESOLVED):
                continue  # the largest is asked first: most bodies are clear
            if self._is_touching(tip, axis, body, -TOUCH_MM - self.left):
                if name == "cutter" and self.thin and self._may_be_cut(rows, tip, axis, body):
                    self.depth.update(dict.fromkeys(((row, name) for row in rows.tolist()), np.nan))
                    continue
                first, depth = self._follow_contact(rows, tip, axis, name, body)
                for row in rows[first:].tolist():
                    self.depth[row, name] = max(depth, self.depth.get((row, name), -np.inf))
                self.broken.add((int(self.spans.tool[rows[0]]), name))
                self.told.update((one, name) for one in self.run_of_line[rows[first:]].tolist())
                if self.only_first in (True, name):
                    self.is_over |= name != "cutter" or not self.rounding[rows[0]] > 0
            elif not follows_cutter:
                for row, tips, axes in zip(rows.tolist(), *list_pairs(tip, axis), strict=True):
                    run = int(self.run_of_line[row]), name
                    if run not in self.told and not self._is_clear(
                        row, tips, axes, name, body, stood or (tip[0], axis[0])
                    ):
                        self.depth.setdefault((row, name), np.nan)
                        self.told.add(run)

    def _find_room(self, number: int, tip: Array, axis: Array, body: tuple[Piece, ...]) -> None:
        """Note how wide a thin line can be that has cut nothing yet: a wider one meets the stock in these rapids."""
        turns = (axis[:, 0] != axis[:, 1]).any(axis=1)
        near = ~turns & self._find_near(tip, axis, [body], LINE_RADIUS_MM)

        def has_room(at: slice, radius: float) -> bool:
            sweeps = list_sweeps(tip[at], axis[at], max(piece.high for piece in body), STEP_MM)
            return not any(
                self.stock.find_touching(
                    sweeps,
                    self.tables[id(piece)].widen(radius).extend(-TOUCH_MM),
                    compiled=self.compiled,
                    only_first=True,
                ).any()
                for piece in body
            )

        for k in np.flatnonzero(near).tolist():
            at, low, high = slice(k, k + 1), 0.0, self.thin.get_radius(number)
            if has_room(at, high):
                continue
            while high - low > ROOM_MM:
                middle = 0.5 * (low + high)
                low, high = (middle, high) if has_room(at, middle) else (low, middle)
            self.thin.set_radius(number, high)

    def _may_be_cut(self, rows: Ints, tip: Array, axis: Array, body: tuple[Piece, ...]) -> bool:
        """Whether all material that a body meets may have been cut by a cutter that is a thin line here."""
        point = self._list_points(tip, axis, body)
        if not len(point):
            return True
        some = np.append((point @ axis[0]).argmin(), np.linspace(0, len(point) - 1, LINE_POINTS).astype(int))
        return self.thin.may_have_cut(point[some], int(self.spans.line[rows[0]]), -TOUCH_MM - self.left)

    def _find_begin(self, tip: Array, axis: Array, body: tuple[Piece, ...]) -> tuple[Array, Array]:
        """Tip and axis where a body that certainly touches on a span does so first, within ``FINE_MM``."""
        clear, touching = 0.0, 1.0
        reach = max(piece.high for piece in body)
        long = float(np.linalg.norm(tip[1] - tip[0]) + reach * np.linalg.norm(axis[1] - axis[0]))
        while (touching - clear) * long > FINE_MM:
            share = 0.5 * (clear + touching)
            ends = (np.stack([one[0], one[0] + share * (one[1] - one[0])]) for one in (tip, axis))
            tips, axes = ends
            axes /= np.linalg.norm(axes, axis=1)[:, None]
            if self._is_touching(tips, axes, body, -TOUCH_MM - self.left):
                touching = share
            else:
                clear = share
        return tip[0] + clear * (tip[1] - tip[0]), axis[0] + clear * (axis[1] - axis[0])

    def measure_begins(
        self,
    ) -> dict[tuple[int, str], tuple[tuple[float, float], tuple[float, float], tuple[float, float, float]]]:
        """``begin``, ``begin_turn`` and ``tip`` of the certain touches, by span and body."""
        tip, axis = self.stock.place_inside(self.spans.tip, self.spans.axis)
        ways = [np.append(0.0, np.cumsum(np.linalg.norm(one[:, 1] - one[:, 0], axis=1))) for one in (tip, axis)]
        ends = np.concatenate([[0], np.flatnonzero(np.diff(self.spans.line)) + 1, [len(tip)]])
        begins = {}
        for (row, name), at in self.begin.items():
            last = int(np.searchsorted(ends, row, "right"))
            parts = []
            for way, ends_of_spans, now in zip(ways, (tip, axis), at, strict=True):
                there = way[row] + np.linalg.norm(now - ends_of_spans[row, 0])
                parts.append((float(there - way[ends[last - 1]]), float(way[ends[last]] - there)))
            begin, (before, after) = parts
            x, y, z = self.stock.place_outside(at[0]).tolist()
            begins[row, name] = begin, (math.degrees(before), math.degrees(after)), (x, y, z)
        return begins

    def _is_touching(self, tip: Array, axis: Array, body: tuple[Piece, ...], by: float, step: float = STEP_MM) -> bool:
        """Whether a ray has material in a body larger by ``by``, or by the space between rays (``RESOLVED``)."""
        return any(
            self.stock.find_touching(sweeps, table, compiled=self.compiled, only_first=True).any()
            for sweeps, table in self._list_enlarged(*list_pairs(tip, axis), body, by, step)
        )

    def _is_far(self, tip: Array, axis: Array, bodies: Iterable[tuple[Piece, ...]]) -> bool:
        """Whether bodies are clear on n spans (n, 2, 3) in a row by what they move between few standing ones."""
        tips, axes = (np.append(one[:, 0], one[-1:, 1], axis=0) for one in (tip, axis))
        by = self.stock.resolution + 0.5 * (STRETCH_MM + STEP_MM)
        return not any(self._is_touching(tips, axes, body, by, STRETCH_MM) for body in bodies)

    def _find_hits(
        self, tip: Array, axis: Array, body: tuple[Piece, ...], by: float
    ) -> Iterator[tuple[Ints, Sweeps, RayTable]]:
        """For each piece which of its bodies are hit, all its bodies, and the piece as it was enlarged."""
        for sweeps, table in self._list_enlarged(*list_pairs(tip, axis), body, by):
            yield np.flatnonzero(self.stock.find_touching(sweeps, table, compiled=self.compiled)), sweeps, table

    def _list_enlarged(
        self, tip: Array, axis: Array, body: tuple[Piece, ...], by: float, step: float = STEP_MM
    ) -> Iterator[tuple[Sweeps, RayTable]]:
        """The bodies of each piece on spans (n, 2, 3), and the piece larger by ``by``."""
        for piece in body:
            sweeps, table = list_sweeps(tip, axis, piece.high, step), self.tables[id(piece)].extend(self.keep_off)
            if by != RESOLVED:
                table = table.extend(by)
            elif (sweeps.axis[:, 2] == 1.0).all():  # heights are exact along a ray
                table = table.widen(self.stock.resolution)
            else:
                table = table.extend(self.stock.resolution + 0.5 * STEP_MM)
            _Run.bodies += len(sweeps)
            yield sweeps, table

    def _is_clear(
        self, row: int, tip: Array, axis: Array, name: str, body: tuple[Piece, ...], stood: tuple[Array, Array]
    ) -> bool:
        """Whether a body is clear that no ray certainly meets, and that may meet material between the rays."""
        if self.keep_off or not (name == "cutter" or (int(self.spans.tool[row]), name) in self.broken):
            return False
        parts = self.cuts.get(int(self.spans.tool[row]), [])
        if not parts:
            return False
        while len(parts) > 1 and parts[-2].shape[-1] <= parts[-1].shape[-1]:  # few parts, and few copies
            parts[-2:] = [np.concatenate(parts[-2:], axis=-1)]
        long, lifts = max(piece.high for piece in body), self.tools[int(self.spans.tool[row])].widens_upwards
        tips, axes = zip(*(find_ways(part, tip, axis, long) for part in parts), strict=True)
        ways = np.concatenate(tips), np.concatenate(axes)

        def follows(part: tuple[Array, Array], size: float) -> bool:
            if follows_ways(part, ways, long, lifts) or not self._is_touching(*part, body, RESOLVED):
                return True
            if size == FINE_MM:
                return False
            size = 0.5 * size if size > STRETCH_MM else FINE_MM
            return all(follows(one, size) for one in split_span(*part, size))

        if follows((tip, axis), max(float(np.linalg.norm(tip[1] - tip[0])), STRETCH_MM)):
            return True
        (_tip, last_tip), (_axis, last_axis) = parts[-1][..., -1]
        was_here = np.abs(last_tip - stood[0]).max() <= TOUCH_MM and np.abs(last_axis - stood[1]).max() == 0
        return bool(was_here and self._is_leaving(tip, axis, body, stood))

    def _is_leaving(self, tip: Array, axis: Array, body: tuple[Piece, ...], stood: tuple[Array, Array]) -> bool:
        """Whether a body comes nowhere nearer to material on a span than where it stood."""
        tips, axes = place_along(tip, axis, PLACES)
        return all(
            (_measure_nearest(tips, axes, body, point) >= measure_phi(body, point, *stood) - TOUCH_MM).all()
            for hit, sweeps, table in self._find_hits(tip, axis, body, RESOLVED)
            for point in (self.stock.list_overlaps(sweeps, table, one)[0] for one in hit[::-1].tolist())
        )

    def _follow_contact(
        self, rows: Ints, tip: Array, axis: Array, name: str, body: tuple[Piece, ...]
    ) -> tuple[int, float]:
        """On which of the spans in a row a contact is first, and how deep a body is in the material, mm.

        Also notes where the contact begins. In a contact that goes on along a line, both are measured again only where
        they can have changed.
        """
        first, last, in_corner = 0, self.measured.get(name), self.rounding[rows[0]] > 0
        line = self.spans.line[rows[0]]
        if last is not None and not (0 <= rows[0] - last[0] <= 1 and line == self.spans.line[last[0]]):
            last = None
        if last is None:
            first = self._find_first(tip, axis, body)
        if self.only_spans and not in_corner:
            self.measured[name] = int(rows[-1]), tip[-1], axis[-1], TOUCH_MM
            return first, TOUCH_MM
        if last is not None:
            _row, old_tip, old_axis, depth = last
            reach = max(piece.high for piece in body)
            gone = np.linalg.norm(tip - old_tip, axis=1) + reach * np.linalg.norm(axis - old_axis, axis=1)
            most = max(STEP_MM, DEPTH_SHARE * depth)
            told = min(max(most, *self.stock.cell) - self.stock.resolution, most)  # the rest is for what rays miss
            # standing bodies miss no more than half the distance between them, upright ones that are swept nothing
            deeper = depth + (min(told, 0.5 * most) if (axis[:, 2] == 1.0).all() else 0.5 * told) + self.keep_off
            if not in_corner and (gone.max() <= told or not self._is_touching(tip, axis, body, -deeper, told)):
                self.measured[name] = int(rows[-1]), old_tip, old_axis, depth
                return first, depth
        else:
            span = slice(first, first + 2)
            self.begin[int(rows[first]), name] = self._find_begin(tip[span], axis[span], body)
        depth = self._measure_depth(tip, axis, body)
        if not in_corner:  # what it leaves may be no contact
            self.measured[name] = int(rows[-1]), tip[-1], axis[-1], depth
        return first, depth

    def _find_first(self, tip: Array, axis: Array, body: tuple[Piece, ...]) -> int:
        """The first of spans in a row on which a body certainly touches; one of them does."""
        last = len(tip) - 2
        pairs = zip(*list_pairs(tip, axis), strict=True)
        touching = (
            k for k, pair in enumerate(pairs) if k == last or self._is_touching(*pair, body, -TOUCH_MM - self.left)
        )
        return next(touching)

    def _measure_depth(self, tip: Array, axis: Array, body: tuple[Piece, ...]) -> float:
        """How deep a body is in the material at most, mm; negative where it is beside it, nearer than it may be."""
        point = self._list_points(tip, axis, body)
        if not len(point):
            return 0.0
        long = np.linalg.norm(np.diff(tip, axis=0), axis=1).sum()
        most = int(np.clip(long / STEP_MM, PLACES, MOST_PLACES))
        reach = np.linalg.norm(point - tip[0], axis=1).max() + long
        places = FEW_PLACES
        while places < most:  # a distance changes by no more than the body moves from one place to the next
            tips, axes = place_along(tip, axis, places)
            way, turn = (np.linalg.norm(np.diff(one, axis=0), axis=1) for one in (tips, axes))
            nearest = _measure_nearest(tips, axes, body, point)
            point, places = point[nearest <= nearest.min() + (way + reach * turn).max()], 2 * places
        return -float(_measure_nearest(*place_along(tip, axis, most), body, point).min())

    def _list_points(self, tip: Array, axis: Array, body: tuple[Piece, ...]) -> Array:
        """Material (m, 3) on rays that meet a body: both ends and the middle on some of them."""
        found = []
        for hit, sweeps, table in self._find_hits(tip, axis, body, 0.0):
            if len(hit) > MEASURED_BODIES:
                hit = hit[np.linspace(0, len(hit) - 1, MEASURED_BODIES).astype(int)]
            for one in hit.tolist():
                middle, overlap = self.stock.list_overlaps(sweeps, table, one, CHOSEN_FROM)
                if len(overlap) < MEASURED_RAYS:
                    middle, overlap = self.stock.list_overlaps(sweeps, table, one)
                order = np.argsort(-overlap)
                spread = order[MEASURED_RAYS :: len(order) // MEASURED_RAYS + 1]
                kept = np.append(order[:MEASURED_RAYS], spread)
                up = 0.5 * overlap[kept, None] * (0.0, 0.0, 1.0)
                found += [middle[kept] - up, middle[kept], middle[kept] + up]
        return np.concatenate(found) if found else np.empty((0, 3))


def _measure_nearest(tips: Array, axes: Array, body: tuple[Piece, ...], point: Array) -> Array:
    """Least signed distance (m,) of points (m, 3) from a body at places (n, 3)."""
    some = max(AT_A_TIME // len(tips), 1)
    parts = [point[first : first + some] for first in range(0, len(point), some)]
    nearest = [measure_phi(body, part, tips[:, None], axes[:, None]).min(axis=0) for part in parts]
    return np.concatenate(nearest) if nearest else np.empty(0)
