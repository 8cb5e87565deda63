"""Frames of Klartext: where input coordinates are on the workpiece, with and without tool-centre-point control (M128).

Without it a control moves the axes of the machine: its coordinates do not turn with the table. Where the table stands
still, that is a rigid map of the workpiece, so it is one more map of the frame. Where the table turns, the tip goes on
a curve of the workpiece, which is one move of its own kind.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.affine import Affine, find_table_map, split
from verne_post.gcode.klartext.modes import Modes
from verne_post.gcode.klartext.q_parameters import QParameters
from verne_post.gcode.klartext.transformations import Transformations
from verne_post.gcode.klartext.waiting import Waiting
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.machining.state import State
from verne_post.gcode.machining.turning import find_machine_place, move_machine_axes
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.model.moves import FeedMode, MoveKind

#: F of a program in inches counts tenths of an inch a minute.
MM_PER_TENTH: Final = 2.54


class KlartextFrames:
    """The state of Klartext, and what its coordinates mean."""

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.core = Machining(setup, state, recorder)
        self.setup, self.state, self.recorder = setup, state, recorder
        self.q = QParameters()
        state.show_variables(self.q)
        self.maps = Transformations()
        self.modes = state.modes = Modes()
        #: Whole turns, in degrees, that M94 has taken off the numbers of A and C.
        self.wraps = dict.fromkeys(setup.rotary, 0.0)
        #: Axes that M94 has reduced from below 0, and what to say of it.
        self.open_turns: dict[int, str] = {}
        #: Scales of X, Y, Z in force, below 0 where they are mirrored.
        self.factors = (1.0, 1.0, 1.0)
        self.metres = False  # M116
        self.block = At(0)
        self.waiting = Waiting()

    # --- beside a contour ---------------------------------------------------------------------------

    def convert_length(self, value: float) -> float:
        """A length of the program in mm."""
        return value * MM_PER_INCH if self.modes.inch else value

    @contextmanager
    def _count_degrees(self) -> Iterator[None]:
        """The feed rate of turns alone is the number of F in degrees, as the program has it, also in inches."""
        feed, unit = self.state.feed, 1.0
        if self.modes.inch:
            unit = MM_PER_INCH if self.state.feed_mode == FeedMode.PER_REVOLUTION else MM_PER_TENTH
        with self.core.keep_feed():
            self.core.set_feed(feed, feed / unit, is_given=False)
            yield

    def run_line(self, at: At, kind: MoveKind, end: list[float], axes: list[int], *, absolute: bool = True) -> None:
        """A straight move to an end (9) of the frame; after R0 it needs X or Y."""
        if not {0, 1} & set(axes):
            self._refuse_after_side("a move without X and Y")
        with self._count_degrees():
            self.core.go_straight(at, kind, end, axes, absolute=absolute)

    def refuse_beside(self, what: str) -> None:
        """Refuse what moves the tool otherwise than a contour does, while it is beside one."""
        self.core.refuse_compensation(what)
        self._refuse_after_side(what)

    def _refuse_after_side(self, what: str) -> None:
        """Refuse ``what`` after R0 until a move in the plane: whether the tool leaves its side there is open."""
        if self.state.compensation is None and self.state.centre is not None:
            raise ProgramError(
                "VP017",
                f"{what} after R0, while the tool is beside the contour: controls differ in whether it then goes onto "
                "the contour; move in X and Y first, or write DEP instead of R0",
            )

    # --- coordinates ---------------------------------------------------------------------------------

    @property
    def unit(self) -> float:
        """Mm of a unit of the program, with the scaling in force."""
        return self.convert_length(1.0) * self.maps.factor

    def find_height(self, height: float) -> float:
        """A height of the program as Z of the frame, mm."""
        return height * self.factors[2] * self.convert_length(1.0)

    def place(self, point: Sequence[float]) -> list[float]:
        """Input coordinates (3) as X, Y, Z of the frame, mm."""
        unit = self.convert_length(1.0)
        return [value * factor * unit for value, factor in zip(point, self.factors, strict=True)]

    @property
    def flips(self) -> bool:
        """True where a mirror image changes the direction of arcs in the plane."""
        return self.factors[0] * self.factors[1] < 0

    def refuse_open_turn(self, axis: int) -> None:
        """Refuse a position of an axis that M94 has reduced from below 0: controls may count it from 0, or below."""
        if axis in self.open_turns:
            raise ProgramError(
                "VP017",
                f"{self.open_turns[axis]}, and whether controls make a value below 0 positive is not known here: this "
                "position would be a turn away; write M126 for the shorter way, or M94 where the value is not below 0",
            )

    # --- frames -----------------------------------------------------------------------------------------

    def refresh_frame(self) -> None:
        """Put the maps that are in force into the frame; the machine stands still."""
        parts = split(self.maps.map())
        is_beside = not self.modes.tcp and self.maps.tilt is None
        table = self.map_with_table(self.state.position) if is_beside else Affine()
        self.core.frames.set_frame(replace(self.state.frame, feature=table.lay(parts.rigid)))
        self.factors = parts.scale

    def map_with_table(self, program: list[float]) -> Affine:
        """The map to the workpiece of coordinates that do not turn with the table, at rotary words of a point (9)."""
        return find_table_map(self.setup.coordinates, self.state.frame, program) if self.setup.machine else Affine()

    def check_upright(self, what: str) -> None:
        """Without tool-centre-point control a tilted plane needs the tool upright on it."""
        if self.modes.tcp or self.maps.tilt is None or not self.setup.machine:
            return
        if self.core.find_tilted_tool() is not None:
            remedy = self.core.recorder.explain_plane("position the rotary axes first")
            text = f"{what} in a tilted plane that the tool is not normal to; {remedy}"
            raise ProgramError("VP017", text, about=what, edits=self.core.recorder.list_plane_edits())

    # --- motion of machine axes ----------------------------------------------------------------------------

    def find_machine_position(self) -> Array:
        """Machine coordinates (9,) of the present position."""
        return find_machine_place(self.core)

    def move_machine(self, kind: MoveKind, target: Array, axes: list[int]) -> None:
        """All axes of the machine go straight to machine coordinates (9,), at the feed rate of axes (mm, degrees)."""
        self.refuse_beside("a motion of machine axes")
        self.core.frames.set_frame(replace(self.state.frame, feature=None))
        is_turn = np.linalg.norm((target - self.find_machine_position())[:3]) <= ZERO_LENGTH_MM
        with self._count_degrees() if is_turn else nullcontext():
            move_machine_axes(self.core, self.block, kind, target, axes, by_tip=self.metres)

    def turn_axes(self, kind: MoveKind, targets: dict[int, float], point: list[float] | None, axes: list[int]) -> None:
        """Turn A and C to program positions (degrees) without tool-centre-point control.

        ``point``: X, Y, Z to which the other axes go at the same time, in the frame that holds at the end, mm; None
        where they stand still. ``axes`` are those that the program names.
        """
        state, coordinates = self.state, self.setup.coordinates
        ends = list(state.position)
        for axis, value in targets.items():
            ends[axis] = value
        end = self.find_machine_position()
        if point is not None:
            whole = self.maps.map()
            if self.maps.tilt is None:
                whole = self.map_with_table(ends).put_inside(whole)
            program = np.array([*point, *ends[3:]])
            end = np.array(
                coordinates.map_to_machine(program, replace(state.frame, feature=split(whole).rigid.feature))
            )
        else:
            base = replace(state.frame, feature=None)
            end[3:] = coordinates.map_to_machine(np.array(ends), base)[3:]
        if self.setup.rotary[1] in targets:
            self.recorder.fix_c(self.block.line)
        self.move_machine(kind, end, axes)
        self.refresh_frame()
