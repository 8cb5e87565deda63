"""NURBS interpolation of Fanuc controls: G6.2 P order K knot, control point, R weight; then as many knots alone as the order."""

from typing import ClassVar, Final

from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.frame_codes import whole
from verne_post.gcode.interpret import Interpreter
from verne_post.gcode.splines import BSpline, SplineDraft
from verne_post.model.moves import AXES, FeedMode

#: G6.2; its orders, and the one without P.
NURBS: Final = 62
_ORDERS: Final = (2, 3, 4)
_ORDER: Final = 4


class NurbsCodes(Interpreter):
    """The interpreter of RS274/NGC with G6.2, which is modal: every block is a control point with its knot, or a knot."""

    beside_spline: ClassVar[tuple[int, ...]] = (NURBS,)
    spline_end: ClassVar[str] = "as many blocks with K alone as the order of the spline end it"

    def _choose_motion(self, block: Block, g: dict[str, int], axes: list[str]) -> int | None:
        motion = super()._choose_motion(block, g, axes)
        if motion is None and self.state.motion == NURBS and "K" in block.words and "non-modal" not in g:
            return NURBS
        return motion

    def _execute_spline(self, block: Block, motion: int) -> None:
        state, axes = self.state, self._named_axes(block)
        draft, state.spline = (
            state.spline,
            None,
        )  # a block that is refused ends the spline: its rest would make another one
        if draft is None:
            draft = self._begin_nurbs(block)
        else:
            for letter in (letter for letter in "PF" if letter in block.words):
                raise block.error(
                    "VP006", f"{letter} among the control points of G6.2; it belongs in the first block", letter
                )
        if axes or not draft.points:
            self._add_control_point(block, draft, axes)
        elif "R" in block.words:
            raise block.error("VP006", "R beside a knot alone: a weight belongs to a control point", "R")
        if "K" in block.words:
            draft.knots.append(block.words["K"])
        elif draft.knots or len(draft.points) > 1:
            raise BlockError("VP005", "a block of G6.2 needs K, its knot")
        if draft.knots and len(draft.knots) < len(draft.points):  # the first block may leave K to the second
            draft.knots.insert(0, draft.knots[0])
        if len(draft.knots) < len(draft.points) + draft.order:
            state.spline = draft
            return
        spline = BSpline(draft.order - 1, draft.points, draft.weights, draft.knots, draft.lines)
        self._follow_spline(block, spline, "G6.2")

    def _begin_nurbs(self, block: Block) -> SplineDraft:
        """Check what holds where a spline begins."""
        state = self.state
        self._check_spline_modes("G6.2")
        if not state.absolute:
            raise BlockError("VP017", "G6.2 in G91; control points are absolute here, write G90")
        if state.feed_mode != FeedMode.PER_MINUTE:
            raise BlockError("VP017", "G6.2 needs feed per minute (G94)")
        if state.vectors:
            raise BlockError("VP017", "G6.2 under G43.5: K would be a knot and a tool axis; use G43.4 with A and C")
        self._check_feed(block, NURBS)
        order = whole(block, "P") if "P" in block.words else _ORDER
        if order not in _ORDERS:
            raise block.error("VP007", f"P{order}: the order of G6.2 is {_ORDERS[0]} to {_ORDERS[-1]}", "P")
        self._require_known(block, [axis for axis, letter in enumerate(AXES) if letter in self.setup.axes], "G6.2")
        return SplineDraft(NURBS, block.line, order)

    def _add_control_point(self, block: Block, draft: SplineDraft, axes: list[int]) -> None:
        """A control point; axes that are not named keep their value of the one before, at first where the tool is."""
        if len(draft.knots) > len(draft.points):
            raise BlockError("VP031", "a control point after knots alone: those come at the end of G6.2")
        weight = block.words.get("R", 1.0)
        if weight <= 0:
            raise block.error("VP031", f"R{weight:g}: the weight of a control point is positive", "R")
        point = list(draft.points[-1] if draft.points else self.state.position)
        for axis in axes:
            point[axis] = self._axis_value(block, axis)
        draft.add(point, weight, block.line)
