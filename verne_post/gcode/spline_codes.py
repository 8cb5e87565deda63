"""Splines as LinuxCNC has them: G5, G5.1, and G5.2 with G5.3; and what the splines of every dialect have in common."""

from collections.abc import Mapping
from typing import ClassVar, Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.tolerances import ARC_CHORD_MM
from verne_post.base.units import SECONDS_PER_MINUTE
from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.codes import g_name
from verne_post.gcode.frame_codes import whole
from verne_post.gcode.motion_codes import MotionCodes
from verne_post.gcode.splines import BSpline, SplineDraft, cut_spline, uniform_knots
from verne_post.model.moves import AXES, FeedMode, MoveKind, PathControl, PathMode

_CUBIC, _QUADRATIC, _POINT, _FOLLOW = 50, 51, 52, 53
#: Codes of splines; the last is of Fanuc controls.
SPLINES: Final = (_CUBIC, _QUADRATIC, _POINT, _FOLLOW, 62)
#: The lowest order of G5.2, and the one without L.
_ORDER: Final = 3
#: G codes that may stand between the control points of G5.2.
_BESIDE: Final = (_POINT, _FOLLOW, 900, 910)


class SplineCodes(MotionCodes):
    """Codes that move, splines among them."""

    #: G codes that may stand among control points, and how a spline ends.
    beside_spline: ClassVar[tuple[int, ...]] = _BESIDE
    spline_end: ClassVar[str] = "G5.3 ends it"

    # --- what all dialects share -----------------------------------------------------------------

    def _follow_spline(self, block: Block, spline: BSpline, name: str) -> None:
        """Record the motion along a B-spline, at the feed rate in force; its first control point is where the tool is.

        Raises
        ------
        BlockError
            VP031 where there is no such curve; VP017 and others as for arcs.
        """
        state = self.state
        self._check_spline_modes(name)
        start = self._motion_start(MoveKind.SPLINE, absolute=state.absolute, machine=False)
        points = [list(point) for point in spline.points]
        if max(abs(a - b) for a, b in zip(points[0], start, strict=True)) > ARC_CHORD_MM:
            where = " ".join(f"{letter}{points[0][AXES.index(letter)]:.6g}" for letter in self.setup.axes)
            raise BlockError(
                "VP031", f"{name} begins at {where}, and the tool is elsewhere; lead to the first control point"
            )
        points[0] = list(start)
        turning = next((axis for axis in (3, 4, 5) if any(point[axis] != start[axis] for point in points)), None)
        if turning is not None and state.tool_axis is not None:
            raise BlockError(
                "VP013",
                f"{AXES[turning]} in {name} while a tool axis ({self.axis_words}) holds; name A and C in a G1 before",
            )
        if state.tcp_off:
            for point in points[1:]:
                self._check_tcp_off(start, point)
        if any(point[5] != start[5] for point in points):
            self.recorder.fix_c(block.line)
        cut = cut_spline(replace(spline, points=points))
        whole = float(cut.length.sum())
        feed = self._feed_of((whole, True))
        timed = state.feed_mode == FeedMode.INVERSE
        times = SECONDS_PER_MINUTE / state.feed * cut.length / whole if timed else np.full(len(cut.line), np.nan)
        number = self.recorder.keep_pieces(cut.pieces.select(np.flatnonzero(~cut.straight)))
        control = state.control
        if control.mode == PathMode.EXACT_STOP:  # the curve is one motion
            state.control = PathControl(PathMode.EXACT_PATH)
        each = zip(cut.line, cut.end, times.tolist(), strict=True)
        for place, (line, end, seconds) in enumerate(each):
            if place == len(cut.line) - 1:
                state.control = control
            if cut.axis is not None:
                x, y, z = cut.axis[place].tolist()
                state.tool_axis = x, y, z
            if cut.straight[place]:
                self.recorder.add(state, line, MoveKind.FEED, end, feed, seconds=seconds)
            else:
                self.recorder.add(state, line, MoveKind.SPLINE, end, feed, spline=number, seconds=seconds)
                number += 1
        moved = [axis for axis in range(len(AXES)) if any(point[axis] != start[axis] for point in points)]
        self._arrive(list(points[-1]), moved, absolute=True)

    def _check_spline_modes(self, name: str) -> None:
        """What holds for the splines of every dialect."""
        self._refuse_compensation(name)
        if not self.state.arc_may_follow:
            raise BlockError(
                "VP026", "the move after the end of cutter compensation (G40) must be straight, not a spline"
            )

    def _guard_spline(self, g: Mapping[str, int]) -> None:
        """Refuse what must not come before the end of a spline that has been begun; the spline is given up then."""
        draft = self.state.spline
        if draft is None:
            return
        other = next((code for code in g.values() if code not in self.beside_spline), None)
        if other is not None:
            self.state.spline = None
            raise BlockError("VP031", f"{g_name(other)} before the end of {self._name_draft(draft)}")

    def _refuse_unfinished_spline(self) -> None:
        """The program must not end before a spline does."""
        draft, self.state.spline = self.state.spline, None
        if draft is not None:
            raise BlockError("VP031", f"the program ends before the end of {self._name_draft(draft)}")

    def _name_draft(self, draft: SplineDraft) -> str:
        return f"the spline that {g_name(draft.code)} has begun in line {draft.line}; {self.spline_end}"

    # --- G5, G5.1 ----------------------------------------------------------------------------------

    def _execute_spline(self, block: Block, motion: int) -> None:
        own = any(letter == "G" and round(10 * number) == motion for letter, number, _column in block.codes)
        if not own and motion != _POINT:
            raise BlockError("VP005", f"{g_name(motion)} does not go on by itself; write it in every block")
        if motion == _POINT:
            self._add_point(block)
        elif motion == _FOLLOW:
            self._end_nurbs(block)
        else:
            self._move_on_bezier(block, motion)

    def _move_on_bezier(self, block: Block, motion: int) -> None:
        """G5: a cubic, I J from its start and P Q from its end; G5.1: a quadratic, I J from its start."""
        state, name = self.state, g_name(motion)
        end = self._plane_point(block, name)
        start = state.position
        needed = "PQ" if motion == _CUBIC else "IJ"
        for letter in needed:
            if letter not in block.words:
                raise BlockError("VP005", f"{name} needs {' and '.join(needed)}")
        self._check_feed(block, motion)
        offsets = {letter: self._length(block.words[letter]) for letter in "IJPQ" if letter in block.words}
        if motion == _CUBIC and not {"I", "J"} <= offsets.keys():
            if offsets.keys() & {"I", "J"}:
                raise BlockError("VP005", "G5 needs both I and J, or neither of them")
            if state.spline_leg is None or state.spline_leg[0] != self.recorder.count:
                raise BlockError(
                    "VP005", "G5 without I and J goes on where the G5 just before it ends; this one needs I and J"
                )
            offsets["I"], offsets["J"] = state.spline_leg[1:]
        inner = [_shifted(start, offsets["I"], offsets["J"])]
        if motion == _CUBIC:
            inner.append(_shifted(end, offsets["P"], offsets["Q"]))
        degree = len(inner) + 1
        points = [start, *inner, end]
        spline = BSpline(
            degree, points, [1.0] * (degree + 1), uniform_knots(degree + 1, degree), [block.line] * (degree + 1)
        )
        self._follow_spline(block, spline, name)
        if motion == _CUBIC:
            state.spline_leg = (self.recorder.count, -offsets["P"], -offsets["Q"])

    def _plane_point(self, block: Block, name: str) -> list[float]:
        """The X and Y of a block as a point of the present plane."""
        state = self.state
        axes = self._named_axes(block)
        if state.plane != 0:
            raise BlockError("VP017", f"{name} needs the XY plane (G17)")
        for axis in axes:
            if axis > 1:
                raise block.error("VP006", f"{AXES[axis]} in {name}, which moves X and Y only", AXES[axis])
        if not axes:
            raise BlockError("VP005", f"{name} needs X or Y")
        self._require_known(block, [0, 1, 2], name)
        end = list(state.position)
        for axis in axes:
            value = self._axis_value(block, axis)
            end[axis] = value if state.absolute else end[axis] + value
        return end

    # --- G5.2, G5.3 ----------------------------------------------------------------------------------

    def _add_point(self, block: Block) -> None:
        """G5.2: a control point and its weight P; the first one is where the tool is, with weight P of a block without X and Y."""
        state, axes = self.state, self._named_axes(block)
        draft = state.spline
        if draft is None:
            self._check_spline_modes("G5.2")
            self._check_feed(block, _POINT)
            if state.feed_mode == FeedMode.INVERSE:
                raise BlockError("VP017", "G5.2 with inverse-time feed (G93): its blocks are one motion; use G94")
            draft = SplineDraft(_POINT, block.line, _ORDER)
        weight = block.words.get("P")
        if not axes:
            if draft.points:
                raise BlockError(
                    "VP005", "G5.2 needs X and Y; only its first block may have P alone, the weight of the start"
                )
            if weight is None:
                raise BlockError("VP005", "G5.2 needs X and Y, a control point, and P, its weight")
        if weight is None:
            raise BlockError("VP005", "G5.2 needs P, the weight of its control point")
        if weight <= 0:
            raise block.error("VP031", f"P{weight:g}: the weight of a control point is positive", "P")
        if len({0, 1} & set(axes)) == 1:
            raise BlockError("VP005", "G5.2 needs both X and Y")
        order = whole(block, "L") if "L" in block.words else draft.order
        if order < draft.order:
            raise block.error("VP007", f"L{order}: the order of the spline is {draft.order} at least here", "L")
        point = self._plane_point(block, "G5.2") if axes else None
        if not draft.points:
            self._require_known(block, [0, 1, 2], "G5.2")
            draft.add(list(state.position), weight if point is None else 1.0, block.line)
        if point is not None:
            draft.add(point, weight, block.line)
        draft.order = order
        state.spline = draft

    def _end_nurbs(self, block: Block) -> None:
        """G5.3: follow the spline whose control points have been given."""
        state = self.state
        draft, state.spline = state.spline, None
        state.motion = None
        if draft is None:
            raise BlockError("VP031", "G5.3 without G5.2: no control points have been given")
        for letter in (letter for letter in block.words if letter in AXES):
            raise block.error("VP006", f"{letter} beside G5.3, which has no end point of its own", letter)
        self._check_feed(block, _POINT)
        degree = draft.order - 1
        knots = uniform_knots(len(draft.points), degree)
        self._follow_spline(block, BSpline(degree, draft.points, draft.weights, knots, draft.lines), "G5.2")


def _shifted(point: list[float], x: float, y: float) -> list[float]:
    return [point[0] + x, point[1] + y, *point[2:]]
