"""Frames of Klartext: where input coordinates are on the workpiece, with and without tool-centre-point control (M128).

Without it a control moves the axes of the machine: its coordinates do not turn with the table. Where the table stands
still, that is a rigid map of the workpiece, so it is one more map of the frame. Where the table turns, the tip goes on
a curve of the workpiece, which is one move of its own kind.
"""

import math
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ROTARY_CHORD_MM, ZERO_LENGTH_MM
from verne_post.base.units import MM_PER_INCH, SECONDS_PER_MINUTE
from verne_post.gcode.arcs import Arc
from verne_post.gcode.klartext.modes import Modes
from verne_post.gcode.klartext.q_parameters import QParameters
from verne_post.gcode.klartext.transformations import Map, Transformations
from verne_post.gcode.klartext.waiting import Waiting
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.machining.state import State
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.model.moves import MoveKind

#: At a place in each degree, of up to eleven turns. The chords between them are shorter than the way of the tip by 1e-5 of it.
_MOST_PLACES: Final = 4000


class KlartextFrames:
    """The state of Klartext, and what its coordinates mean.

    Attributes
    ----------
    q : QParameters
    maps : Transformations
    modes : Modes
    wraps : dict
        Whole turns, in degrees, that M94 has taken off the numbers of A and C.
    """

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.core = Machining(setup, state, recorder)
        self.setup, self.state, self.recorder = setup, state, recorder
        self.q = QParameters()
        self.maps = Transformations()
        self.modes = state.modes = Modes()
        self.wraps = dict.fromkeys(setup.rotary, 0.0)
        self.factors = np.ones(3)
        self.metres = False  # M116
        self.block = At(0)
        self.waiting = Waiting()

    # --- beside a contour ---------------------------------------------------------------------------

    def length(self, value: float) -> float:
        """A length of the program in mm."""
        return value * MM_PER_INCH if self.modes.inch else value

    def run_line(self, at: At, kind: MoveKind, end: list[float], axes: list[int], *, absolute: bool = True) -> None:
        """A straight move to an end (9) of the frame; after R0 it needs X or Y."""
        if not {0, 1} & set(axes):
            self._refuse_after_side("a move without X and Y")
        self.core.line(at, kind, end, axes, absolute=absolute)

    def refuse_beside(self, what: str) -> None:
        """Refuse what moves the tool otherwise than a contour does, while it is beside one."""
        self.core.refuse_compensation(what)
        self._refuse_after_side(what)

    def _refuse_after_side(self, what: str) -> None:
        """After R0 the tool is beside the contour until it moves in the plane; whether anything else takes it there is open."""
        if self.state.compensation is None and self.state.centre is not None:
            raise ProgramError("VP017", f"{what} after R0, while the tool is beside the contour: whether it then goes onto the contour depends on the "
                             "control; move in X and Y first, or write DEP in place of R0")  # fmt: skip

    # --- coordinates ---------------------------------------------------------------------------------

    @property
    def unit(self) -> float:
        """Mm of a unit of the program, with the scaling in force."""
        return self.length(1.0) * self.maps.factor

    def place(self, point: Array) -> list[float]:
        """Input coordinates (3,) as X, Y, Z of the frame, mm."""
        x, y, z = np.asarray(point) * self.factors * self.length(1.0)
        return [float(x), float(y), float(z)]

    @property
    def flips(self) -> bool:
        """True where a mirror image changes the direction of arcs in the plane."""
        return bool(self.factors[0] * self.factors[1] < 0)

    # --- frames -----------------------------------------------------------------------------------------

    def refresh_frame(self) -> None:
        """Put the maps that are in force into the frame; the machine stands still."""
        whole = self.maps.map()
        if not self.modes.tcp and self.maps.tilt is None:
            whole = self.table_map(self.state.position).after(whole)
        feature, factors = whole.split()
        self.core.frames.set_frame(replace(self.state.frame, feature=feature))
        self.factors = factors

    def table_map(self, program: list[float]) -> Map:
        """Where coordinates that do not turn with the table are on the workpiece, with it at the rotary words of a point (9)."""
        if not self.setup.machine:
            return Map()
        base = replace(self.state.frame, feature=None)
        upright, turned = np.zeros((4, 9)), np.zeros((1, 9))
        upright[1:, :3] = np.eye(3)
        turned[0, 3:6] = program[3:6]
        machine = self.setup.coordinates.to_machine(upright, base)
        machine[:, 3:] = self.setup.coordinates.to_machine(turned, base)[0, 3:]
        if np.array_equal(machine[0, 3:], self.setup.coordinates.to_machine(upright, base)[0, 3:]):
            return Map()
        on_part = self.setup.coordinates.to_program(machine, base)[:, :3]
        return Map((on_part[1:] - on_part[0]).T, on_part[0])

    def check_upright(self, what: str) -> None:
        """Without tool-centre-point control a tilted plane needs the tool upright on it."""
        if self.modes.tcp or self.maps.tilt is None or not self.setup.machine:
            return
        if self.core.tilted_tool() is not None:
            raise ProgramError(
                "VP017", f"{what} in a tilted plane, and the tool does not stand upright on it; position the rotary axes first "
                "(PLANE ... MOVE or TURN, or L A+Q120 C+Q122)",
            )  # fmt: skip

    # --- motion of machine axes ----------------------------------------------------------------------------

    def machine_position(self) -> Array:
        """Machine coordinates (9,) of the present position."""
        return np.array(self.setup.coordinates.to_machine(np.array(self.state.position), self.state.frame))

    def move_machine(self, kind: MoveKind, target: Array, axes: list[int]) -> None:
        """All axes of the machine go straight to machine coordinates (9,), at the feed rate of axes (mm, degrees)."""
        self.refuse_beside("a motion of machine axes")
        state, coordinates = self.state, self.setup.coordinates
        start = self.machine_position()
        base = replace(state.frame, feature=None)
        self.core.frames.set_frame(base)
        self.core.frames.name_axes([float(value) for value in coordinates.to_program(target, base)], axes, machine=True)
        change, rotary = target - start, list(self.setup.rotary)
        shares = np.linspace(0.0, 1.0, self.places_along(float(np.linalg.norm(change[rotary]))))[:, None]
        points = coordinates.to_program(start + shares * change, base)
        way = float(np.linalg.norm(change[:3]))
        counted = [0, 1, 2, *rotary] if way > ZERO_LENGTH_MM else rotary
        self.record_carried(kind, MoveKind.TURN, points, axes, float(np.linalg.norm(change[counted])))

    @staticmethod
    def places_along(angle: float) -> int:
        """At so many places the way of the tip is looked at while A and C turn by an angle, degrees."""
        return min(3 + math.ceil(angle), _MOST_PLACES)

    def record_carried(
        self,
        kind: MoveKind,
        carried: MoveKind,
        points: Array,
        axes: list[int],
        size: float,
        held: tuple[float, float, float] | None = None,
    ) -> None:
        """Record a move that turns the table, RAPID or FEED; at a feed rate it takes as long as ``size`` (mm or degrees) at F does.

        It is straight where ``points`` (n, 9), at even shares of it from its start on, say so within ROTARY_CHORD_MM, else of the
        kind ``carried``. ``held`` is the point that stands still in a SWING, mm.
        """
        state = self.state
        tip, shares = points[:, :3], np.linspace(0.0, 1.0, len(points))[:, None]
        aside = np.linalg.norm(tip - tip[0] - shares * (tip[-1] - tip[0]), axis=1).max()
        end = [float(value) for value in points[-1]]
        feed, seconds = math.nan, math.nan
        if kind == MoveKind.FEED:
            way = float(np.linalg.norm(np.diff(tip, axis=0), axis=1).sum())
            turn = math.dist(points[0, 3:6], points[-1, 3:6])
            by_tip = self.metres and way > ZERO_LENGTH_MM
            size = way if by_tip else size
            # what the feed rate of the recorded move counts
            shown = turn if aside > ROTARY_CHORD_MM or way <= ZERO_LENGTH_MM else way
            feed = state.feed * shown / size if size else state.feed
            if size and not (by_tip and aside <= ROTARY_CHORD_MM):
                seconds = SECONDS_PER_MINUTE * size / state.feed
        about = None if held is None else Arc(0, held, 1, 0.0)
        if aside > ROTARY_CHORD_MM:
            self.recorder.add(state, self.block.line, carried, end, feed, about, seconds=seconds)
        else:
            self.recorder.add(state, self.block.line, kind, end, feed, seconds=seconds)
        self.core.arrive(end, axes, absolute=False)
        self.core.allow_arc()

    def turn_axes(self, kind: MoveKind, targets: dict[int, float], point: list[float] | None, axes: list[int]) -> None:
        """Turn A and C to program positions (degrees) without tool-centre-point control.

        ``point``: X, Y, Z to which the other axes go at the same time, in the frame that holds at the end, mm; None
        where they stand still. ``axes`` are those that the program names.
        """
        state, coordinates = self.state, self.setup.coordinates
        ends = list(state.position)
        for axis, value in targets.items():
            ends[axis] = value
        end = self.machine_position()
        if point is not None:
            feature, _factors = (
                self.maps.map().split() if self.maps.tilt is not None
                else self.table_map(ends).after(self.maps.map()).split()
            )  # fmt: skip
            program = np.array([*point, *ends[3:]])
            end = np.array(coordinates.to_machine(program, replace(state.frame, feature=feature)))
        else:
            base = replace(state.frame, feature=None)
            end[3:] = coordinates.to_machine(np.array(ends), base)[3:]
        if self.setup.rotary[1] in targets:
            self.recorder.fix_c(self.block.line)
        self.move_machine(kind, end, axes)
        self.refresh_frame()
