"""Splines as LinuxCNC has them: G5, G5.1, and G5.2 with G5.3; and what the splines of every dialect have in common."""

from collections.abc import Mapping
from typing import Final

from verne_post.gcode.block import Block
from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.machining.machining import Machining, explain_inverse_time
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.rs274.motion import MotionCodes
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.rs274.values import WordValues, read_whole
from verne_post.gcode.splines import BSpline, SplineDraft, build_uniform_knots
from verne_post.model.moves import AXES, FeedMode

_CUBIC, _QUADRATIC, _POINT, _FOLLOW = 50, 51, 52, 53
#: Codes of splines; the last is of Fanuc controls.
SPLINES: Final = (_CUBIC, _QUADRATIC, _POINT, _FOLLOW, 62)
#: The lowest order of G5.2, and the one without L.
_ORDER: Final = 3


class SplineCodes:
    """G5, G5.1, G5.2 and G5.3, and what all splines whose control points stand in blocks have in common."""

    def __init__(self, core: Machining, values: WordValues, motion: MotionCodes, traits: Traits) -> None:
        self.core, self.values, self.motion, self.traits = core, values, motion, traits
        self.state, self.recorder = core.state, core.recorder
        self.modes: Modes = core.state.modes

    def guard(self, g: Mapping[str, int]) -> None:
        """Refuse what must not come before the end of a spline that has been begun; the spline is given up then."""
        draft = self.modes.spline
        if draft is None:
            return
        other = next((code for code in g.values() if code not in self.traits.beside_spline), None)
        if other is not None:
            self.modes.spline = None
            raise ProgramError("VP031", f"{spell_g_code(other)} before the end of {self._name_draft(draft)}")

    def refuse_unfinished(self) -> None:
        """The program must not end before a spline does."""
        draft, self.modes.spline = self.modes.spline, None
        if draft is not None:
            raise ProgramError("VP031", f"the program ends before the end of {self._name_draft(draft)}")

    def _name_draft(self, draft: SplineDraft) -> str:
        return f"the spline that {spell_g_code(draft.code)} has begun in line {draft.line}; {self.traits.spline_end}"

    # --- G5, G5.1 ----------------------------------------------------------------------------------

    def execute(self, block: Block, motion: int) -> None:
        own = any(letter == "G" and round(10 * number) == motion for letter, number, _column in block.codes)
        if not own and motion != _POINT:
            raise ProgramError("VP005", f"{spell_g_code(motion)} is not modal; write it in every block")
        if motion == _POINT:
            self._add_point(block)
        elif motion == _FOLLOW:
            self._end_nurbs(block)
        else:
            self._move_on_bezier(block, motion)

    def _move_on_bezier(self, block: Block, motion: int) -> None:
        """G5: a cubic, I J from its start and P Q from its end; G5.1: a quadratic, I J from its start."""
        state, name = self.state, spell_g_code(motion)
        end = self._read_plane_point(block, name)
        start = state.position
        needed_letters = "PQ" if motion == _CUBIC else "IJ"
        for letter in needed_letters:
            if letter not in block.words:
                raise ProgramError("VP005", f"{name} needs {' and '.join(needed_letters)}")
        self.motion.check_feed(block, motion)
        offsets = {
            letter: self.values.convert_length(block.words[letter]) for letter in "IJPQ" if letter in block.words
        }
        if motion == _CUBIC and not {"I", "J"} <= offsets.keys():
            if offsets.keys() & {"I", "J"}:
                raise ProgramError("VP005", "G5 needs both I and J, or neither of them")
            if self.modes.spline_leg is None or self.modes.spline_leg[0] != self.recorder.count:
                raise ProgramError(
                    "VP005", "G5 without I and J continues a G5 directly before it; there is none, so give I and J"
                )
            offsets["I"], offsets["J"] = self.modes.spline_leg[1:]
        inner = [_shift_points(start, offsets["I"], offsets["J"])]
        if motion == _CUBIC:
            inner.append(_shift_points(end, offsets["P"], offsets["Q"]))
        degree = len(inner) + 1
        points = [start, *inner, end]
        spline = BSpline(
            degree, points, [1.0] * (degree + 1), build_uniform_knots(degree + 1, degree), [block.line] * (degree + 1)
        )
        self.core.follow_spline(block, spline, name, absolute=self.modes.absolute)
        if motion == _CUBIC:
            self.modes.spline_leg = (self.recorder.count, -offsets["P"], -offsets["Q"])

    def _read_plane_point(self, block: Block, name: str) -> list[float]:
        """The X and Y of a block as a point of the present plane."""
        state = self.state
        axes = self.values.list_named_axes(block)
        if state.plane != 0:
            raise ProgramError("VP017", f"{name} needs the XY plane (G17)")
        for axis in axes:
            if axis > 1:
                raise block.error("VP006", f"{AXES[axis]} in {name}, which moves X and Y only", AXES[axis])
        if not axes:
            raise ProgramError("VP005", f"{name} needs X or Y")
        self.core.require_known(block, [0, 1, 2], name)
        end = list(state.position)
        for axis in axes:
            value = self.values.read_axis_value(block, axis)
            end[axis] = value if self.modes.absolute else end[axis] + value
        return end

    # --- G5.2, G5.3 ----------------------------------------------------------------------------------

    def _add_point(self, block: Block) -> None:
        """G5.2: a control point with weight P; the first is at the tool, with the P of a block without X and Y."""
        state, axes = self.state, self.values.list_named_axes(block)
        draft = self.modes.spline
        if draft is None:
            self.core.check_spline("G5.2")
            self.motion.check_feed(block, _POINT)
            if state.feed_mode == FeedMode.INVERSE:
                text = "G5.2 with inverse-time feed (G93): its blocks are one motion; use G94"
                raise explain_inverse_time(self.core, ProgramError("VP017", text))
            draft = SplineDraft(_POINT, block.line, _ORDER)
        weight = block.words.get("P")
        if not axes:
            if draft.points:
                raise ProgramError(
                    "VP005", "G5.2 needs X and Y; only its first block may have P alone, the weight of the start"
                )
            if weight is None:
                raise ProgramError("VP005", "G5.2 needs X and Y, a control point, and P, its weight")
        if weight is None:
            raise ProgramError("VP005", "G5.2 needs P, the weight of its control point")
        if weight <= 0:
            raise block.error("VP031", f"P{weight:g}: the weight of a control point is positive", "P")
        if len({0, 1} & set(axes)) == 1:
            raise ProgramError("VP005", "G5.2 needs both X and Y")
        order = read_whole(block, "L") if "L" in block.words else draft.order
        if order < draft.order:
            raise block.error("VP007", f"L{order}: the order of the spline is {draft.order} at least here", "L")
        point = self._read_plane_point(block, "G5.2") if axes else None
        if not draft.points:
            self.core.require_known(block, [0, 1, 2], "G5.2")
            draft.add(list(state.position), weight if point is None else 1.0, block.line)
        if point is not None:
            draft.add(point, weight, block.line)
        draft.order = order
        self.modes.spline = draft

    def _end_nurbs(self, block: Block) -> None:
        """G5.3: follow the spline whose control points have been given."""
        draft, self.modes.spline = self.modes.spline, None
        self.modes.motion = None
        if draft is None:
            raise ProgramError("VP031", "G5.3 without G5.2: no control points have been given")
        for letter in (letter for letter in block.words if letter in AXES):
            raise block.error("VP006", f"{letter} beside G5.3, which has no end point", letter)
        self.motion.check_feed(block, _POINT)
        degree = draft.order - 1
        knots = build_uniform_knots(len(draft.points), degree)
        self.core.follow_spline(
            block,
            BSpline(degree, draft.points, draft.weights, knots, draft.lines),
            "G5.2",
            absolute=self.modes.absolute,
        )


def _shift_points(point: list[float], x: float, y: float) -> list[float]:
    return [point[0] + x, point[1] + y, *point[2:]]
