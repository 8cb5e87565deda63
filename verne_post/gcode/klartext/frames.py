"""Frames of Klartext: where input coordinates are on the workpiece, with and without tool-centre-point control (M128).

Without it a control moves the axes of the machine: its coordinates do not turn with the table. Where the table stands
still, that is a rigid map of the workpiece, so it is one more map of the frame. Where the table turns, the tip goes on
a curve of the workpiece, which is recorded in short pieces.
"""

import math
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ROTARY_CHORD_MM, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.base.units import RAD_PER_DEG, SECONDS_PER_MINUTE
from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.interpret import Interpreter
from verne_post.gcode.klartext.q_parameters import QParameters
from verne_post.gcode.klartext.transformations import Map, Transformations
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State
from verne_post.model.moves import MoveKind

_A, _C = 3, 5
#: A turn of the table is recorded in so many pieces at most.
_MAX_PIECES: Final = 2000


class KlartextFrames(Interpreter):
    """The state of Klartext, and what its coordinates mean.

    Attributes
    ----------
    q : QParameters
    maps : Transformations
    tcp : bool
        M128 or FUNCTION TCPM: the tool centre point is controlled.
    wraps : dict
        Whole turns, in degrees, that M94 has taken off the numbers of A and C.
    """

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        super().__init__(setup, state, recorder)
        self.q = QParameters()
        self.maps = Transformations()
        self.tcp = False
        self.wraps = {_A: 0.0, _C: 0.0}
        self.factors = np.ones(3)
        self.metres = False  # M116
        self.block = Block(0)

    def _feed_of(self, lengths: tuple[object, object]) -> float:
        """Feed of a move; that of a turn alone is the same number in degrees."""
        self.state.feed_angular = self.state.feed
        return super()._feed_of(lengths)

    # --- beside a contour ---------------------------------------------------------------------------

    def _record(self, line: int, kind: MoveKind, end: list[float], axes: list[int], *, absolute: bool) -> None:
        """As all dialects record a straight move; after R0 it needs X or Y."""
        if not {0, 1} & set(axes):
            self._refuse_after_side("a move without X and Y")
        super()._record(line, kind, end, axes, absolute=absolute)

    def _refuse_beside(self, what: str) -> None:
        """Refuse what moves the tool otherwise than a contour does, while it is beside one."""
        self._refuse_compensation(what)
        self._refuse_after_side(what)

    def _refuse_after_side(self, what: str) -> None:
        """After R0 the tool is beside the contour until it moves in the plane; whether anything else takes it there is open."""
        if self.state.compensation is None and self.state.centre is not None:
            raise BlockError("VP017", f"{what} after R0, while the tool is beside the contour: whether it then goes onto the contour depends on the "
                             "control; move in X and Y first, or write DEP in place of R0")  # fmt: skip

    # --- coordinates ---------------------------------------------------------------------------------

    @property
    def unit(self) -> float:
        """Mm of a unit of the program, with the scaling in force."""
        return self._length(1.0) * self.maps.factor

    def place(self, point: Array) -> list[float]:
        """Input coordinates (3,) as X, Y, Z of the frame, mm."""
        x, y, z = np.asarray(point) * self.factors * self._length(1.0)
        return [float(x), float(y), float(z)]

    @property
    def flips(self) -> bool:
        """True where a mirror image changes the direction of arcs in the plane."""
        return bool(self.factors[0] * self.factors[1] < 0)

    # --- frames -----------------------------------------------------------------------------------------

    def refresh_frame(self) -> None:
        """Put the maps that are in force into the frame; the machine stands still."""
        whole = self.maps.map()
        if not self.tcp and self.maps.tilt is None:
            whole = self.table_map(self.state.position[_A], self.state.position[_C]).after(whole)
        feature, factors = whole.split()
        self._set_frame(replace(self.state.frame, feature=feature))
        self.factors = factors

    def table_map(self, a: float, c: float) -> Map:
        """Where coordinates that do not turn with the table are on the workpiece, with the table at A and C (degrees)."""
        if not self.setup.machine:
            return Map()
        base = replace(self.state.frame, feature=None)
        upright, turned = np.zeros((4, 9)), np.zeros((1, 9))
        upright[1:, :3] = np.eye(3)
        turned[0, [_A, _C]] = a, c
        machine = self.setup.coordinates.to_machine(upright, base)
        machine[:, 3:] = self.setup.coordinates.to_machine(turned, base)[0, 3:]
        if np.array_equal(machine[0, 3:], self.setup.coordinates.to_machine(upright, base)[0, 3:]):
            return Map()
        on_part = self.setup.coordinates.to_program(machine, base)[:, :3]
        return Map((on_part[1:] - on_part[0]).T, on_part[0])

    def check_upright(self, what: str) -> None:
        """Without tool-centre-point control a tilted plane needs the tool upright on it."""
        if self.tcp or self.maps.tilt is None or not self.setup.machine:
            return
        if self.tilted_tool() is not None:
            raise BlockError(
                "VP017", f"{what} in a tilted plane, and the tool does not stand upright on it; position the rotary axes first "
                "(PLANE ... MOVE or TURN, or L A+Q120 C+Q122)",
            )  # fmt: skip

    # --- motion of machine axes ----------------------------------------------------------------------------

    def machine_position(self) -> Array:
        """Machine coordinates (9,) of the present position."""
        return np.array(self.setup.coordinates.to_machine(np.array(self.state.position), self.state.frame))

    def move_machine(self, kind: MoveKind, target: Array, axes: list[int]) -> None:
        """All axes of the machine go straight to machine coordinates (9,), at the feed rate of axes (mm, degrees)."""
        self._refuse_beside("a motion of machine axes")
        state, coordinates = self.state, self.setup.coordinates
        start = self.machine_position()
        base = replace(state.frame, feature=None)
        self._set_frame(base)
        n = self._pieces(start, target)
        shares = np.arange(1, n + 1)[:, None] / n
        points = coordinates.to_program(start + shares * (target - start), base)
        points[:, [_A, _C]] = (
            np.array(state.position)[[_A, _C]]
            + shares * (coordinates.to_program(target, base) - np.array(state.position))[[_A, _C]]
        )
        change = target - start
        way = float(np.linalg.norm(change[:3]))
        size = (
            float(np.linalg.norm(change[[0, 1, 2, _A, _C]]))
            if way > ZERO_LENGTH_MM
            else float(np.linalg.norm(change[[_A, _C]]))
        )
        self.record_points(kind, points, axes, size)

    def record_points(self, kind: MoveKind, points: Array, axes: list[int], size: float) -> None:
        """Record straight pieces to points (n, 9); at a feed rate they take as long as ``size`` (mm or degrees) at F does."""
        state, line = self.state, self.block.line
        seconds = SECONDS_PER_MINUTE * size / state.feed / len(points) if kind == MoveKind.FEED and state.feed else 0.0
        for point in points:
            end = [float(value) for value in point]
            feed, timed = math.nan, False
            if kind == MoveKind.FEED:
                tip = math.dist(state.position[:3], end[:3])
                turn = math.dist(state.position[3:6], end[3:6])
                feed = state.feed
                timed = not (self.metres and tip > ZERO_LENGTH_MM) and seconds > 0.0
                if timed:
                    feed = SECONDS_PER_MINUTE * (tip if tip > ZERO_LENGTH_MM else turn) / seconds
            self.recorder.add(state, line, kind, end, feed or state.feed, seconds=seconds if timed else math.nan)
            self._arrive(end, axes, absolute=True)
        state.arc_may_follow = True

    def _pieces(self, start: Array, target: Array) -> int:
        """How many straight pieces keep the tip on its curve."""
        turn = RAD_PER_DEG * float(np.linalg.norm((target - start)[[_A, _C]]))
        if not self.setup.machine or turn < ZERO_ANGLE:
            return 1
        coordinates, base = self.setup.coordinates, replace(self.state.frame, feature=None)
        shares = np.linspace(0.0, 1.0, 9)[:, None]
        tips = coordinates.to_program(start + shares * (target - start), base)[:, :3]
        chord = np.linalg.norm(tips[:-2] - 2 * tips[1:-1] + tips[2:], axis=1).max() / 8  # of one of eight pieces
        return int(np.clip(math.ceil(8 * math.sqrt(chord / ROTARY_CHORD_MM)), 1, _MAX_PIECES))

    def turn_axes(self, kind: MoveKind, targets: dict[int, float], point: list[float] | None) -> None:
        """Turn A and C to program positions (degrees) without tool-centre-point control.

        ``point``: X, Y, Z to which the other axes go at the same time, in the frame that holds at the end, mm; None
        where they stand still.
        """
        state, coordinates = self.state, self.setup.coordinates
        ends = list(state.position)
        for axis, value in targets.items():
            ends[axis] = value
        end = self.machine_position()
        axes = sorted(targets)
        if point is not None:
            feature, _factors = (
                self.maps.map().split() if self.maps.tilt is not None
                else self.table_map(ends[_A], ends[_C]).after(self.maps.map()).split()
            )  # fmt: skip
            program = np.array([*point, *ends[3:]])
            end = np.array(coordinates.to_machine(program, replace(state.frame, feature=feature)))
            axes = [0, 1, 2, *axes]
        else:
            base = replace(state.frame, feature=None)
            end[3:] = coordinates.to_machine(np.array(ends), base)[3:]
        if _C in targets:
            self.recorder.fix_c(self.block.line)
        self.move_machine(kind, end, axes)
        self.refresh_frame()
