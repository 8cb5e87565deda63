"""NURBS interpolation of Fanuc (G6.2): P order, K knot, control point, R weight; then ``order`` knots alone."""

from typing import Final

from verne_post.gcode.block import Block
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.fanuc_codes import NURBS
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.rs274.motion import MotionCodes
from verne_post.gcode.rs274.values import WordValues, read_whole
from verne_post.gcode.splines import BSpline, SplineDraft
from verne_post.model.moves import AXES, FeedMode

#: The orders that P may name, and the one without P.
_ORDERS: Final = (2, 3, 4)
_ORDER: Final = 4


class NurbsCodes:
    """G6.2, which is modal: every block is a control point with its knot, or a knot."""

    def __init__(self, core: Machining, values: WordValues, motion: MotionCodes) -> None:
        self.core, self.values, self.motion = core, values, motion
        self.setup, self.state = core.setup, core.state
        self.modes: Modes = core.state.modes

    def goes_on(self, block: Block, g: dict[str, int]) -> bool:
        """True for a block with a knot alone."""
        return self.modes.motion == NURBS and "K" in block.words and "non-modal" not in g

    def execute(self, block: Block) -> None:
        """A control point, or a knot; the last one follows the spline."""
        axes = self.values.list_named_axes(block)
        draft, self.modes.spline = (
            self.modes.spline,
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
            raise ProgramError("VP005", "a block of G6.2 needs K, its knot")
        if draft.knots and len(draft.knots) < len(draft.points):  # the first block may leave K to the second
            draft.knots.insert(0, draft.knots[0])
        if len(draft.knots) < len(draft.points) + draft.order:
            self.modes.spline = draft
            return
        spline = BSpline(draft.order - 1, draft.points, draft.weights, draft.knots, draft.lines)
        self.core.follow_spline(block, spline, "G6.2")

    def _begin_nurbs(self, block: Block) -> SplineDraft:
        """Check what holds where a spline begins."""
        state = self.state
        self.core.check_spline("G6.2")
        if not self.modes.absolute:
            raise ProgramError("VP017", "G6.2 in G91; control points are absolute here, write G90")
        if state.feed_mode != FeedMode.PER_MINUTE:
            raise ProgramError("VP017", "G6.2 needs feed per minute (G94)")
        if self.modes.vectors:
            letters = " and ".join(self.setup.rotary_letters)
            raise ProgramError(
                "VP017", f"G6.2 under G43.5: K would be a knot and a tool axis; use G43.4 with {letters}"
            )
        self.motion.check_feed(block, NURBS)
        order = read_whole(block, "P") if "P" in block.words else _ORDER
        if order not in _ORDERS:
            raise block.error("VP007", f"P{order}: the order of G6.2 is {_ORDERS[0]} to {_ORDERS[-1]}", "P")
        self.core.require_known(block, [axis for axis, letter in enumerate(AXES) if letter in self.setup.axes], "G6.2")
        return SplineDraft(NURBS, block.line, order)

    def _add_control_point(self, block: Block, draft: SplineDraft, axes: list[int]) -> None:
        """A control point; axes that are not named keep their value of the one before, at first where the tool is."""
        if len(draft.knots) > len(draft.points):
            raise ProgramError("VP031", "a control point after knots alone: those come at the end of G6.2")
        weight = block.words.get("R", 1.0)
        if weight <= 0:
            raise block.error("VP031", f"R{weight:g}: the weight of a control point is positive", "R")
        point = list(draft.points[-1] if draft.points else self.state.position)
        for axis in axes:
            point[axis] = self.values.read_axis_value(block, axis)
        draft.add(point, weight, block.line)
