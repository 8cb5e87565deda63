"""Path functions of Klartext: words -> one contour element (L, LP, LN, C, CP, CR, CT, CTP), and the pole CC."""

import math
from collections.abc import Callable, Mapping
from typing import Final

from msgspec import Struct

from verne_post.base.tolerances import ARC_CHORD_MM, ARC_RADIUS_INCH_MM, ARC_RADIUS_MM, ZERO_LENGTH_MM
from verne_post.gcode.arcs import PLANES, Arc, build_arc_from_center, build_arc_from_radius
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.words import Words
from verne_post.gcode.machining.elements import Element, make_arc
from verne_post.gcode.machining.plane_geometry import find_center_of_sweep, find_tangent_sweep
from verne_post.gcode.program_error import ProgramError, locate_errors, write_words
from verne_post.gcode.rs274.motion import MAX_TURNS
from verne_post.gcode.rs274.values import LINEAR, MAX_ANGLE_DEG, MAX_LENGTH_MM
from verne_post.model.moves import AXES, MoveKind

_ROTARY: Final = frozenset((3, 4, 5))
#: Letters of axes, absolute and incremental.
_STEPS: Final = tuple((letter, "I" + letter) for letter in AXES)
_FULL_TURN: Final = 360.0
#: Words of an arc before its DR.
_BEFORE_SENSE: Final = (*(letter for step in _STEPS for letter in step), "R", "PR", "IPR", "PA", "IPA")
_Builder = Callable[["KlartextPaths", Statement, Words, "Target"], Arc | None]


class Target(Struct):
    """Where a path function leads.

    ``start`` and ``end`` are nine axes of the frame (mm, degrees); ``axes`` are named; ``turns``: a rotary one is
    named.
    """

    start: list[float]
    end: list[float]
    axes: list[int]
    turns: bool


class KlartextPaths:
    """Frames, and what path functions mean in them."""

    def __init__(self, frames: KlartextFrames) -> None:
        self.frames = frames
        self.core = frames.core
        self.setup = frames.setup
        self.state = frames.state
        self.modes = frames.modes
        self.waiting = frames.waiting
        self.pole: dict[int, float] = {}  #: CC: index of each of its two axes -> input coordinate.
        #: Direction in XY in which the last element ended, for tangential arcs.
        self.direction: tuple[float, float] | None = None
        self.shortest = False  #: M126.
        #: Z of the machine, mm, and the line of a TOOL CALL that has changed the tool length there.
        self.length_change: tuple[float, int] | None = None

    # --- positions -------------------------------------------------------------------------------------

    def find_position(self) -> list[float]:
        """The programmed position (9) at which the next element begins."""
        return self.waiting.find_next_begin(self.state.position)

    def map_to_input(self, position: list[float]) -> list[float]:
        """X, Y, Z of a position of the frame in input coordinates, in the unit of the program."""
        unit = self.frames.convert_length(1.0)
        return [value / factor / unit for value, factor in zip(position, self.frames.factors, strict=False)]

    def read_target(self, statement: Statement, words: Words) -> Target:
        """Take the axis words."""
        start = list(self.find_position())
        end, axes = list(start), list[int]()
        steps = [letter for letter, step in _STEPS if step in words.values]
        here = self.map_to_input(start)
        for axis, (letter, step) in enumerate(_STEPS):
            if letter not in words.values and step not in words.values:
                continue
            if letter not in self.setup.axes:
                at = words.columns[letter if letter in words.values else "I" + letter]
                error = statement.error("VP011", self.setup.describe_missing_axis(letter), at)
                raise error.advise(self.setup.advise_axis(letter, "LN with M128"))
            if axis in _ROTARY:
                if letter in words.values and not self.shortest:
                    self.frames.refuse_open_turn(axis)
                wrap = self.frames.wraps.get(axis, 0.0)
                value = words.read_coordinate(letter, start[axis] - wrap)
                assert value is not None
                end[axis] = self._wrap_shortest(axis, value + wrap, start[axis], step=letter in steps)
            elif axis < 3:
                value = words.read_coordinate(letter, here[axis])
                assert value is not None
                here[axis] = value
            else:
                value = words.read_coordinate(letter, start[axis] / self.frames.convert_length(1.0))
                assert value is not None
                end[axis] = self.frames.convert_length(value)
            bound = MAX_LENGTH_MM if letter in LINEAR else MAX_ANGLE_DEG
            if self.setup.machine and abs(value) > bound:
                place = words.columns.get(letter, words.columns.get("I" + letter))
                raise statement.error("VP007", f"{letter}{value:g} is beyond any machine", place)
            axes.append(axis)
        if 2 in axes:
            self._refuse_step_of_length(is_step="Z" in steps)
        if axes and axes[0] < 3:
            placed_point = self.frames.place(here)
            for axis in axes:
                if axis < 3:
                    end[axis] = placed_point[axis]
        if steps:
            self.core.require_known(
                self.frames.block, [AXES.index(letter) for letter in steps], "an incremental coordinate"
            )
        return Target(start, end, axes, not _ROTARY.isdisjoint(axes))

    def note_length(self, before: float) -> None:
        """Keep where the spindle stands if TOOL CALL has made the tool longer or shorter than ``before``, mm."""
        if self.state.known_axes[2] and abs(self.state.frame.tool_length - before) > ZERO_LENGTH_MM:
            self.length_change = float(self.frames.find_machine_position()[2]), self.frames.block.line

    def _refuse_step_of_length(self, *, is_step: bool) -> None:
        """Refuse IZ while the spindle stands where TOOL CALL has changed the length."""
        change, self.length_change = self.length_change, None
        if is_step and change is not None and abs(self.frames.find_machine_position()[2] - change[0]) < ZERO_LENGTH_MM:
            raise ProgramError(
                "VP017",
                f"IZ counts from where Z is, and TOOL CALL of line {change[1]} has changed the tool length since: "
                "whether that is the tip of the new tool or the Z programmed with the one before is not known here; "
                "name Z before",
            )

    def _wrap_shortest(self, axis: int, value: float, here: float, *, step: bool) -> float:
        """M126: the shorter way for A and C."""
        if not self.shortest or step or axis not in self.frames.wraps:
            return value
        return value - _FULL_TURN * math.floor((value - here) / _FULL_TURN + 0.5)

    def set_pole(self, statement: Statement, words: Words) -> None:
        """CC: two coordinates; without any the last programmed position."""
        here = self.map_to_input(self.find_position())
        open_axes = {axis for axis, letter in enumerate("XYZ") if "I" + letter in words.values}
        given = {
            axis: value
            for axis, letter in enumerate("XYZ")
            if (value := words.read_coordinate(letter, here[axis])) is not None
        }
        words.check_used(statement)
        if len(given) > 2:
            raise statement.error("VP006", "CC takes two coordinates")
        if not given:
            given, open_axes = {0: here[0], 1: here[1]}, {0, 1}
        elif len(given) == 1:
            kept_places = {axis: value for axis, value in self.pole.items() if axis not in given}
            if len(self.pole) != 2 or len(kept_places) != 1:
                raise statement.error("VP005", "CC has one coordinate, and no CC before gives the other")
            given |= kept_places
        self.core.require_known(self.frames.block, sorted(open_axes), "CC")
        self.pole = given

    def _find_pole_plane(self, statement: Statement) -> tuple[int, int, int, int]:
        """Number of the plane of the pole, and its axes."""
        if len(self.pole) != 2:
            raise statement.error("VP005", f"{statement.keyword} needs a pole; write CC before it")
        plane = next(number for number, (u, v, *_) in PLANES.items() if {u, v} == set(self.pole))
        u, v, w, *_ = PLANES[plane]
        return plane, u, v, w

    # --- elements ----------------------------------------------------------------------------------------

    def build(self, statement: Statement, words: Words, target: Target) -> Arc | None:
        """The arc of a path function, or None for a line; completes the target.

        Raises
        ------
        ProgramError
        """
        return BUILDERS[statement.keyword](self, statement, words, target)

    def _move_straight(self, statement: Statement, words: Words, target: Target) -> None:
        return None

    def _move_on_polar_line(self, statement: Statement, words: Words, target: Target) -> None:
        self._find_polar_end(statement, words, target)

    def _find_polar_end(self, statement: Statement, words: Words, target: Target) -> None:
        """LP, CTP: the end by radius and angle about the pole."""
        _plane, u, v, _w = self._find_pole_plane(statement)
        if {u, v} & set(target.axes):
            raise statement.error("VP003", f"{statement.keyword} takes PR and PA, and no coordinates of its plane")
        if not {"PR", "PA"} <= words.values.keys():  # from where the tool stands
            self.core.require_known(self.frames.block, [u, v], statement.keyword)
        here = self.map_to_input(target.start)
        du, dv = here[u] - self.pole[u], here[v] - self.pole[v]
        radius, angle = math.hypot(du, dv), math.degrees(math.atan2(dv, du))
        given_radius, given_angle = words.read_coordinate("PR", radius), words.read_coordinate("PA", angle)
        if given_radius is None and given_angle is None:
            raise statement.error("VP005", f"{statement.keyword} needs PR or PA")
        radius = radius if given_radius is None else given_radius
        angle = angle if given_angle is None else given_angle
        here[u] = self.pole[u] + radius * math.cos(math.radians(angle))
        here[v] = self.pole[v] + radius * math.sin(math.radians(angle))
        placed_point = self.frames.place(here)
        target.end[u], target.end[v] = placed_point[u], placed_point[v]
        target.axes = sorted({*target.axes, u, v})

    def _read_sense(self, statement: Statement, words: Words, u: int, v: int) -> int:
        """DR, as it turns in the frame."""
        if words.rotation is None:
            raise _refuse_no_sense(statement, words, statement.keyword)
        return words.rotation * (-1 if self.frames.factors[u] * self.frames.factors[v] < 0 else 1)

    def _move_on_circle(self, statement: Statement, words: Words, target: Target) -> Arc:
        """C: about the pole."""
        plane, u, v, _w = self._find_pole_plane(statement)
        self.core.require_known(self.frames.block, [0, 1, 2], "C")
        if not {u, v} & set(target.axes):
            raise statement.error("VP005", "C needs a coordinate of its end")
        placed_pole = self.frames.place([self.pole.get(axis, 0.0) for axis in range(3)])
        letters = PLANES[plane][3:]
        offsets = {letters[0]: placed_pole[u], letters[1]: placed_pole[v]}
        tolerance = ARC_RADIUS_INCH_MM if self.modes.inch else ARC_RADIUS_MM
        clockwise = self._read_sense(statement, words, u, v) < 0
        target.axes = sorted({*target.axes, u, v})
        return build_arc_from_center(
            target.start, target.end, plane, clockwise, offsets, True, 0, tolerance, "", self.frames.unit
        )

    def _move_on_polar_circle(self, statement: Statement, words: Words, target: Target) -> Arc:
        """CP: about the pole by an angle, with a height a helix."""
        plane, u, v, _w = self._find_pole_plane(statement)
        self.core.require_known(self.frames.block, [0, 1, 2], "CP")
        if {u, v} & set(target.axes):
            raise statement.error("VP003", "CP takes PA or IPA, and no coordinates of its plane")
        here = self.map_to_input(target.start)
        du, dv = here[u] - self.pole[u], here[v] - self.pole[v]
        radius = math.hypot(du, dv)
        if radius * self.frames.convert_length(1.0) < ZERO_LENGTH_MM:
            raise statement.error("VP008", "CP from the pole itself: the radius is zero")
        begin, step, angle = math.degrees(math.atan2(dv, du)), words.take("IPA"), words.take("PA")
        if (step is None) == (angle is None):
            raise statement.error("VP005", "CP needs PA or IPA, one of them")
        if step is not None:
            if words.rotation is not None and step * words.rotation < 0:
                raise statement.error("VP008", f"CP IPA{step:g} and DR have opposite signs; give both the same sign")
            sweep = step
        else:
            if words.rotation is None:
                raise _refuse_no_sense(statement, words, "CP PA")
            assert angle is not None
            sweep = words.rotation * ((words.rotation * (angle - begin)) % _FULL_TURN)
            if math.radians(abs(sweep)) * radius * self.frames.convert_length(1.0) < ARC_CHORD_MM:
                sweep = words.rotation * _FULL_TURN
        if sweep == 0 or abs(sweep) > MAX_TURNS * _FULL_TURN:
            raise statement.error("VP008", f"CP with an angle of {sweep:g} degrees")
        end = math.radians(begin + sweep)
        here[u], here[v] = self.pole[u] + radius * math.cos(end), self.pole[v] + radius * math.sin(end)
        placed_point = self.frames.place(here)
        target.end[u], target.end[v] = placed_point[u], placed_point[v]
        target.axes = sorted({*target.axes, u, v})
        center = self.frames.place([self.pole.get(axis, 0.0) for axis in range(3)])
        turn = sweep * (-1 if self.frames.factors[u] * self.frames.factors[v] < 0 else 1)
        return make_arc(target.start, plane, (center[u], center[v]), turn)

    def _move_on_radius_circle(self, statement: Statement, words: Words, target: Target) -> Arc:
        """CR: by its radius, negative for the long way."""
        radius = words.take("R")
        if radius is None:
            raise statement.error("VP005", "CR needs R, the radius")
        self.core.require_known(self.frames.block, [0, 1, 2], "CR")
        clockwise = self._read_sense(statement, words, 0, 1) < 0
        if math.dist(target.start[:2], target.end[:2]) < ARC_CHORD_MM:
            raise statement.error("VP008", "CR to the place where the tool is; write a full circle with CC and C")
        with locate_errors(statement.find_place(words.columns["R"])[1]):
            return build_arc_from_radius(
                target.start, target.end, 0, clockwise, radius * self.frames.unit, 0, self.frames.unit
            )

    def _move_on_tangent_circle(self, statement: Statement, words: Words, target: Target) -> Arc | None:
        """CT: goes on in the direction of the element before."""
        self.core.require_known(self.frames.block, [0, 1, 2], "CT")
        if self.direction is None:
            raise statement.error("VP017", "CT needs a line or an arc in X and Y right before it")
        start, end = (target.start[0], target.start[1]), (target.end[0], target.end[1])
        if math.dist(start, end) < ARC_CHORD_MM:
            raise statement.error("VP008", "CT to the place where the tool is")
        sweep = find_tangent_sweep(self.direction, (end[0] - start[0], end[1] - start[1]))
        if sweep == 0.0:
            return None
        if abs(sweep) > _FULL_TURN - 1e-6:
            raise statement.error("VP008", "CT straight back: no arc leads there")
        target.axes = sorted({*target.axes, 0, 1})
        return make_arc(target.start, 0, find_center_of_sweep(start, end, sweep), sweep)

    def _move_on_polar_tangent_circle(self, statement: Statement, words: Words, target: Target) -> Arc | None:
        self._find_polar_end(statement, words, target)
        return self._move_on_tangent_circle(statement, words, target)

    def make_element(self, target: Target, arc: Arc | None, kind: MoveKind) -> Element:
        """The element that leads to a target at the feed rate in force."""
        state = self.state
        axes = tuple(target.axes)
        line = self.frames.recorder.lines.find_own(self.frames.block.line)
        return Element(line, target.start, target.end, kind, state.feed, axes, arc, state.arc_feed)


#: What makes the element of a path function.
BUILDERS: Final[Mapping[str, _Builder]] = {
    "L": KlartextPaths._move_straight,
    "LN": KlartextPaths._move_straight,
    "LP": KlartextPaths._move_on_polar_line,
    "C": KlartextPaths._move_on_circle,
    "CP": KlartextPaths._move_on_polar_circle,
    "CR": KlartextPaths._move_on_radius_circle,
    "CT": KlartextPaths._move_on_tangent_circle,
    "CTP": KlartextPaths._move_on_polar_tangent_circle,
}


def _refuse_no_sense(statement: Statement, words: Words, what: str) -> ProgramError:
    """The error (VP005) of an arc without DR; both are offered behind its last coordinate or radius."""
    at = max((words.columns.get(name, -1) for name in _BEFORE_SENSE), default=-1)
    word = statement.rest[at:].split()[0] if at >= 0 else ""
    edits = write_words(word, f"{word} DR+", f"{word} DR-") if word[-1:].isdigit() else ()
    return statement.error("VP005", f"{what} needs DR+ or DR-", edits=edits)
