"""Motion of Siemens programs: places in the frame chain, with and without TRAORI, lines, arcs, tool axes."""

import math
from collections.abc import Sequence
from typing import ClassVar, Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.arcs import PLANES, Arc
from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.codes import RS274, CodeTable
from verne_post.gcode.frame_codes import MAX_ANGLE_DEG, MAX_LENGTH_MM
from verne_post.gcode.interpret import Interpreter
from verne_post.gcode.lengths import arc_length, length_of
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.siemens.frames import Affine, Split, split
from verne_post.gcode.siemens.modes import Modes
from verne_post.gcode.siemens.vocabulary import REFUSED
from verne_post.gcode.spatial_arc import SpatialArc, arc_through, plane_of_arc
from verne_post.gcode.standing_table import standing_table
from verne_post.gcode.state import State
from verne_post.model.control_keys import SiemensKeys, read_keys
from verne_post.model.moves import AXES, ZERO9, Feature, Frame, MoveKind

_A, _C = 3, 5
#: A rotary axis that is sent nearer to where it stands than this (deg) does not turn.
_STANDS: Final = 1e-9
#: Scales of two axes that differ by less than this share are equal: circles stay circles.
_ALIKE: Final = 1e-9
#: 1 - cosine of the angle between an arc's axis and X, Y or Z that is rounding.
_IN_PLANE: Final = 1e-14


def tangent_of(plane: int, center: Sequence[float], end: Sequence[float], sweep: float) -> list[float]:
    """Along an arc at its end (3,), of any length; ``sweep`` is positive counter-clockwise."""
    first, second, *_ = PLANES[plane]
    sign, tangent = (1.0 if sweep > 0 else -1.0), [0.0, 0.0, 0.0]
    tangent[first], tangent[second] = -sign * (end[second] - center[second]), sign * (end[first] - center[first])
    return tangent


class SiemensMotion(Interpreter):
    """The interpreter of all dialects, which is given places instead of blocks."""

    table: ClassVar[CodeTable] = replace(
        RS274,
        g_groups={},
        m_groups={
            "stopping": (0, 1, 2, 30),
            "tool change": (6,),
            "spindle": (3, 4, 5, 19),
            "coolant": (7, 8, 9),
            "gear": (40,),
        },
        refused_g={},
        refused_m={int(word[1:]): why for word, why in REFUSED.items() if word[0] == "M" and word[1:].isdigit()},
    )

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        super().__init__(setup, state, recorder)
        self.keys: SiemensKeys = read_keys(SiemensKeys, setup.control.get("siemens", {}))
        self.modes = Modes()
        state.arc_feed = self.modes.arc_feed
        self._split = Split(None)
        #: Direction (3,) in which the last motion ended, for CT.
        self.heading: list[float] | None = None
        #: Where axes stood in numbers of the program before their offsets changed, of those that no block has named since.
        self.shifted: dict[int, float] = {}
        #: The same of all axes when the block began.
        self.block_numbers: list[float] = []
        state.systems = {0: Frame(0, tool=state.frame.tool), **state.systems}

    # --- the frame chain ------------------------------------------------------------------------------

    def set_chain(self) -> None:
        """Put the frame chain in force while the machine stands still."""
        chain = self.modes.frames
        self._split = split(chain.total, chain.mirrored)
        offset = self.modes.offset or self.state.systems[self.modes.system]
        base = replace(offset, g92=ZERO9, tool=self.state.frame.tool)
        self._set_frame(replace(base, feature=self._plane(base, self.state.position)))

    def note_numbers(self) -> None:
        """Keep where all axes stand, before offsets may change."""
        self.block_numbers = [self.programmed(axis) for axis in range(len(AXES))]

    def _set_frame(self, frame: Frame) -> None:
        """As all dialects change frames; keeps where axes stood, for G91."""
        super()._set_frame(frame)
        for axis, before in enumerate(self.block_numbers):
            if abs(self.programmed(axis) - before) > ZERO_LENGTH_MM:
                self.shifted.setdefault(axis, before)

    def _plane(self, base: Frame, position: list[float]) -> Feature | None:
        """The plane in which X, Y, Z count: of the chain, and without TRAORI of the table as it stands."""
        plane = self._split.feature
        if self.follows_part:
            return plane
        standing = standing_table(self.setup.coordinates, base, position)
        if standing is None or plane is None:
            return standing or plane
        total = Affine(plane.origin, plane.rotation).after(standing)
        return Feature((total.shift[0], total.shift[1], total.shift[2]), total.matrix)

    @property
    def follows_part(self) -> bool:
        """True where places are those of the part, however the table stands: with TRAORI, or on a plane of CYCLE800."""
        return self.modes.tcp or not self.modes.frames.swivel.is_identity

    @property
    def has_no_scale(self) -> bool:
        """True where programmed lengths are those of the part."""
        return self._split.scale == (1.0, 1.0, 1.0)

    def scale(self, axis: int) -> float:
        """What a programmed value of an axis is multiplied with."""
        return self._split.scale[axis] if axis < 3 else 1.0

    def programmed(self, axis: int) -> float:
        """Where an axis stands, as the program would say it (mm, degrees)."""
        value = self.state.position[axis] / self.scale(axis)
        return value - self.modes.frames.rotary[axis - 3] if 3 <= axis < 6 else value

    def to_core(self, axis: int, value: float) -> float:
        """A programmed place of an axis, in the numbers of the interpreter of all dialects."""
        if 3 <= axis < 6:
            return value + self.modes.frames.rotary[axis - 3]
        return value * self.scale(axis)

    # --- straight moves ---------------------------------------------------------------------------------

    def run_line(self, block: Block, kind: MoveKind, places: dict[int, float], vector: Array | None = None) -> None:
        """A straight move to programmed places of some axes, and to a tool axis (3,) in program directions."""
        state = self.state
        if kind == MoveKind.FEED:
            self._check_feed(block, 10)
        self._check_places(block, places)
        begin = list(state.position)
        end = self._begin_turn(block, kind, places)
        axes = list(places)
        if vector is not None:
            end = self._point(vector, end)
            axes = [*axes, _A, _C] if self.setup.machine else axes
        elif {_A, _C} & set(places):
            self._take_rotary(end, places)
        if _C in places:
            self.recorder.fix_c(block.line)
        if not self.follows_part and {_A, _C} & set(places):  # the axes of the machine go there, beside the table
            self._name_axes(end, axes, machine=True)
        self._record(block.line, kind, end, axes, absolute=True)
        self.set_heading([b - a for a, b in zip(begin[:3], state.position[:3], strict=True)])

    def set_heading(self, way: Sequence[float]) -> None:
        """Keep the direction (3,) of a move for CT, unless it has no length."""
        length = math.hypot(*way)
        if length > 0.0:
            self.heading = [part / length for part in way]

    def _check_places(self, block: Block, places: dict[int, float]) -> None:
        for axis, value in places.items():
            letter = AXES[axis]
            if letter not in self.setup.axes:
                named = ", ".join(self.setup.axes)
                raise block.error("VP011", f"{letter}: the machine has no such axis; it has {named}", letter)
            if self.setup.machine and abs(value) > (MAX_ANGLE_DEG if 3 <= axis < 6 else MAX_LENGTH_MM):
                raise block.error("VP007", f"{letter}{value:g} is beyond any machine", letter)

    def _begin_turn(self, block: Block, kind: MoveKind, places: dict[int, float]) -> list[float]:
        """The end of a move in core numbers; without TRAORI the frame first follows the table to where it will stand."""
        state = self.state
        if state.tool_axis is not None and not self.follows_part:
            self._settle_table(block.line)
        end = list(self._motion_start(kind, absolute=True, machine=False))
        for axis, value in places.items():
            end[axis] = self.to_core(axis, value)
        if self.modes.tcp or not {_A, _C} & set(places):
            return end
        if self.follows_part:
            raise block.error("VP017", "A and C on a plane of CYCLE800 without TRAORI: the plane would no longer stand upright; write CYCLE800() "
                              "first", "A" if _A in places else "C")  # fmt: skip
        turned = max(abs(end[axis] - state.position[axis]) for axis in (_A, _C)) > _STANDS
        if turned and kind == MoveKind.FEED:
            raise block.error("VP017", "A and C turn at a feed rate without TRAORI: on a machine with three linear axes the tip would follow a curve; "
                              "write TRAORI, or G0", "A" if _A in places else "C")  # fmt: skip
        if turned:
            self._refuse_compensation("a turn of the table")
            base = replace(state.frame, feature=None)
            self._set_frame(replace(base, feature=self._plane(base, end)))
        return end

    def _settle_table(self, line: int) -> None:
        """As in all dialects; places without TRAORI follow the table."""
        super()._settle_table(line)
        self.set_chain()

    # --- tool axes ----------------------------------------------------------------------------------------

    def _point(self, vector: Array, end: list[float]) -> list[float]:
        """Take a tool axis in program directions: the end point with a pair A, C that holds it."""
        state = self.state
        turned = self.turn_vectors(vector)
        state.tool_axis = (float(turned[0]), float(turned[1]), float(turned[2]))
        end = self.setup.coordinates.point_axis(end, turned, state.frame)
        if self.leads_axes("vector") and self.setup.machine:
            state.tool_axis = None
        return end

    def turn_vectors(self, vectors: Array) -> Array:
        """Tool axes (..., 3) of the program, of any length, as unit vectors of the interpreter of all dialects."""
        turned = vectors * np.sign(self._split.scale)
        return np.asarray(turned / length_of(turned)[..., None])

    def _take_rotary(self, end: list[float], places: dict[int, float]) -> None:
        """A and C words hold: as they are, or as a tool axis that goes on a great circle."""
        state = self.state
        if state.tool_axis is not None and not {_A, _C} <= set(places):
            letter = "A" if _A in places else "C"
            raise BlockError(
                "VP013",
                f"{letter} alone after tool vectors: which side the table stands on was not programmed; name A and C together",
            )
        state.tool_axis = None
        if not self.modes.tcp or self.leads_axes("words"):
            return
        axis = self.setup.coordinates.tool_axis(end, state.frame)
        if axis is not None:
            state.tool_axis = (float(axis[0]), float(axis[1]), float(axis[2]))

    def leads_axes(self, given: str) -> bool:
        """True where A and C go linearly along a block; ``given``: "words" or "vector"."""
        modes = self.modes
        word = modes.path if self.keys.orientation_by_group else modes.reference
        if word is None:
            return self.keys.orientation == "axes" or (self.keys.orientation == "words" and given == "words")
        return word in ("ORIAXES", "ORIMKS")

    # --- arcs -----------------------------------------------------------------------------------------------

    def run_arc(
        self,
        block: Block,
        clockwise: bool,
        places: dict[int, float],
        center: tuple[float, float] | None,
        radius: float,
        turns: int,
    ) -> None:
        """An arc in the active plane to programmed places; ``center`` counts from the start (programmed, in the plane), or a radius."""
        state = self.state
        first, second, _normal, letter1, letter2 = PLANES[state.plane]
        self._check_feed(block, 20)
        self._check_places(block, places)
        scales = self.scale(first), self.scale(second)
        if abs(abs(scales[0]) - abs(scales[1])) > _ALIKE * abs(scales[0]):
            raise BlockError("VP017", "an arc under unequal scales of its plane would be an ellipse")
        self._require_known(block, [0, 1, 2], "an arc")
        start, end = self._begin_arc(block, places)
        made = Block(block.line, columns=dict(block.columns))
        made.words = {AXES[axis]: 0.0 for axis in places} | {"P": float(turns + 1)}
        if center is not None:
            made.words[letter1], made.words[letter2] = center[0] * scales[0], center[1] * scales[1]
        else:
            made.words["R"] = radius * abs(scales[0])
        mirrored = scales[0] * scales[1] < 0
        state.absolute_centers = False
        self._move_on_arc(made, 20 if clockwise != mirrored else 30, start, end)
        arc = self.recorder.arcs[-1]
        self.set_heading(tangent_of(state.plane, arc.center, end, arc.sweep))

    def _begin_arc(self, block: Block, places: dict[int, float]) -> tuple[list[float], list[float]]:
        """Where an arc to programmed places starts and ends, the table's axes with it."""
        end = self._begin_turn(block, MoveKind.FEED, places)
        start = list(self.state.position)
        if {_A, _C} & set(places):
            self._take_rotary(end, places)
        return start, end

    def run_spatial_arc(self, block: Block, middle: list[float], places: dict[int, float]) -> None:
        """CIP: an arc over a programmed point (3,) to programmed places."""
        self._check_feed(block, 20)
        self._check_places(block, places)
        self._refuse_compensation("CIP")
        self._require_known(block, [0, 1, 2], "an arc")
        if np.ptp(np.abs(self._split.scale)) > _ALIKE:
            raise BlockError("VP017", "CIP under unequal scales would be an ellipse")
        start, end = self._begin_arc(block, places)
        over = np.array([self.to_core(axis, value) for axis, value in enumerate(middle)])
        circle = arc_through(np.array(start[:3]), over, np.array(end[:3]))
        along = int(np.argmax(np.abs(circle.normal)))
        if abs(circle.normal[along]) > 1.0 - _IN_PLANE:  # a plane of the axes
            sign = 1 if circle.normal[along] > 0 else -1
            center = [float(value) for value in circle.center]
            center[along] = start[along]
            arc = Arc((2, 1, 0)[along], (center[0], center[1], center[2]), sign, sign * circle.sweep)
            self._add_arc(block.line, start, end, arc)
        else:
            self._add_tilted_arc(block.line, start, end, circle)
        self._arrive(end, list(places), absolute=True)
        self.set_heading(np.cross(circle.normal, np.array(end[:3]) - circle.center).tolist())

    def _add_arc(self, line: int, start: list[float], end: list[float], arc: Arc) -> None:
        feed = self._feed_of((arc_length(arc, start, end), True))
        self.recorder.add(self.state, line, MoveKind.ARC, end, feed, arc)

    def _add_tilted_arc(self, line: int, start: list[float], end: list[float], circle: SpatialArc) -> None:
        """Record an arc in the plane that holds it."""
        state = self.state
        frame, vector = state.frame, state.tool_axis
        within = np.array(plane_of_arc(circle, None).rotation).reshape(3, 3)
        begin, last = [
            [*map(float, (np.array(place[:3]) - circle.center) @ within), *place[3:]] for place in (start, end)
        ]
        state.frame = replace(frame, feature=plane_of_arc(circle, frame.feature))
        if vector is not None:
            x, y, z = (float(value) for value in np.array(vector) @ within)
            state.tool_axis = (x, y, z)
        self._add_arc(line, begin, last, Arc(0, (0.0, 0.0, begin[2]), 1, circle.sweep))
        state.frame, state.tool_axis = frame, vector

    # --- machine coordinates --------------------------------------------------------------------------------

    def run_machine_line(self, block: Block, kind: MoveKind, places: dict[int, float]) -> None:
        """G53, G153, SUPA: places of the machine; the tool length in force counts."""
        state = self.state
        if kind == MoveKind.FEED:
            self._check_feed(block, 10)
        self._check_places(block, places)
        self._refuse_compensation("G53, G153 and SUPA")
        machine = self.setup.coordinates.to_machine(np.array(state.position), state.frame)
        turned = max(abs(math.sin(math.radians(machine[_A]))), abs(math.sin(math.radians(0.5 * machine[_C])))) > _STANDS
        if self.modes.tcp and self.setup.machine and (turned or {_A, _C} & set(places)):
            raise BlockError("VP017", "G53, G153 or SUPA under TRAORI while the table is turned: places would be those of the turned part; write "
                             "TRAFOOF first")  # fmt: skip
        self._end_vector_for_machine(block.line, list(places))
        targets = dict(places)
        if 2 in targets and self.modes.edge:
            targets[2] += state.frame.tool_length
        self._move_to_machine(block.line, kind, targets)
        if {_A, _C} & set(places):
            self.set_chain()
        self.heading = None
