"""X, Y, Z in directions of the machine beside a turned table, as without tool-centre-point control."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.gcode.affine import Affine, find_table_map
from verne_post.gcode.block import Block
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.machining.turning import move_machine_axes
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.modes import NO_MAPS, TCP_CODES, Modes
from verne_post.gcode.rs274.motion import MotionCodes
from verne_post.model.moves import AXES, Feature, MoveKind

#: A turn of the table by less is rounding, degrees.
_STANDS: Final = 1e-9


class MachineDirections:
    """Keeps the table's turn in the frame, as a plane, while X, Y and Z count along axes of the machine.

    The origin is where that of the work offset is with the table at 0; it stands there however the table turns. So it
    is on a control that stores machine coordinates of the origin, and has neither G43.4 nor a plane in force.
    """

    def __init__(self, core: Machining, motion: MotionCodes) -> None:
        self.core, self.motion = core, motion
        self.setup, self.state, self.recorder = core.setup, core.state, core.recorder
        self.modes: Modes = core.state.modes
        #: The plane in the frame is that of the turned table.
        self.is_laid = False

    def hold(self) -> bool:
        """True while no code in force says that X, Y, Z are those of the part."""
        has_plane = self.state.frame.feature is not None and not self.is_laid and not self.modes.turns
        return not (self.modes.length_code in TCP_CODES or self.modes.follows_table or has_plane)

    def leave(self) -> None:
        """Take the table's turn out of the frame, so that codes find the frame as they know it."""
        if self.is_laid:
            self.is_laid = False
            self.core.frames.set_frame(replace(self.state.frame, feature=None))

    def follow(self) -> None:
        """After codes: the frame as the table stands, or without the table where X, Y, Z are those of the part."""
        if self.state.compensation is not None or self.state.tool_axis is not None:
            return
        if self.hold():
            self._lay(self.state.position)
        else:
            self.leave()

    def _lay(self, place: Sequence[float]) -> None:
        """The frame of a place (9) of the table, mm and degrees."""
        feature = self._find_feature(place)
        if feature is None:
            self.leave()
            return
        if self.modes.turns or self.modes.maps is not NO_MAPS:
            raise ProgramError(
                "VP017",
                f"G68, G51, G51.1 or G16 with the {self.setup.rotary_side} turned, and X, Y, Z in directions of the "
                "machine ([fanuc] directions): end that before, or turn to 0",
            )
        self.is_laid = True
        self.recorder.say_tcp(True)  # the key says in which directions X, Y, Z count
        self.core.frames.set_frame(replace(self.state.frame, feature=feature))

    def _find_feature(self, place: Sequence[float]) -> Feature | None:
        bare = self.state.frame if self.modes.turns else replace(self.state.frame, feature=None)
        return find_table_map(self.setup.coordinates, bare, place).lay(Affine())

    def turn(self, block: Block, kind: MoveKind, axes: list[int]) -> None:
        """A move that names rotary axes: the axes of the machine go there; those that it does not name stand.

        Raises
        ------
        ProgramError
            VP017: the table turns at a feed rate, so that the tip would follow a curve.
        """
        state, core = self.state, self.core
        if not self.modes.absolute:
            core.require_known(block, axes, "an incremental move")
        core.start_of_motion(kind, absolute=True, machine=False, axes=axes)
        end = list(state.position)
        for axis in axes:
            value = self.motion.values.read_axis_value(block, axis)
            end[axis] = value if self.modes.absolute else end[axis] + value
        if all(abs(end[axis] - state.position[axis]) <= _STANDS for axis in self.setup.rotary):
            core.frames.name_axes(end, axes, machine=True)
            self.motion.draw_line(block, kind, end, axes, absolute=self.modes.absolute)
            return
        letter = next(AXES[axis] for axis in self.setup.rotary if axis in axes)
        if kind == MoveKind.FEED:
            raise block.error(
                "VP017",
                f"{letter} turns at a feed rate while X, Y, Z are in directions of the machine ([fanuc] directions): "
                "the tip would follow a curve; write G43.4, or G0",
                letter,
            )
        core.refuse_compensation(f"a turn of the {self.setup.rotary_side}")
        core.leave_beside()
        self._lay(end)
        if self.setup.rotary[1] in axes:
            self.recorder.fix_c(block.line)
        target = self.setup.coordinates.map_to_machine(np.array(end), state.frame)
        move_machine_axes(core, block, kind, target, axes, by_tip=True)
