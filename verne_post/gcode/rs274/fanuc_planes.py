"""Tilted work planes of Fanuc: G68.2 and how the table turns to them."""

import math

import numpy as np
from msgspec.structs import replace

from verne_post.base.units import RAD_PER_DEG
from verne_post.gcode.block import Block
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.fanuc_codes import PLANE_OFF
from verne_post.gcode.rs274.values import WordValues
from verne_post.model.moves import Feature, MoveKind


class FanucPlanes:
    """G68.2, G53.1 and G69."""

    def __init__(self, core: Machining, values: WordValues) -> None:
        self.core, self.values = core, values
        self.setup, self.state, self.recorder = core.setup, core.state, core.recorder

    def set_plane(self, block: Block, code: int) -> None:
        """G68.2 X Y Z I J K: origin and Euler angles (Z, X, Z) of the plane in which the program goes on; G69 ends it."""
        state = self.state
        if code == PLANE_OFF:
            self.core.frames.set_frame(replace(state.frame, feature=None))
            return
        self.recorder.says_tcp = True  # a plane of the part
        if state.frame.feature is not None:
            raise ProgramError("VP017", "G68.2 under G68.2; write G69 first")
        origin = [
            self.values.axis_value(block, axis) if letter in block.words else 0.0 for axis, letter in enumerate("XYZ")
        ]
        i, j, k = (RAD_PER_DEG * block.words.get(letter, 0.0) for letter in "IJK")
        rotation = _turn_z(i) @ _turn_x(j) @ _turn_z(k)
        feature = Feature((origin[0], origin[1], origin[2]), tuple(float(v) for v in rotation.ravel()))
        self.core.frames.set_frame(replace(state.frame, feature=feature))
        for letter in "XYZIJK":
            block.words.pop(letter, None)

    def turn_to_plane(self, block: Block) -> None:
        """G53.1: turn the table so that the tool stands upright on the plane; the tip stays where it is on the part."""
        state = self.state
        if state.frame.feature is None:
            raise ProgramError("VP017", "G53.1 without G68.2: there is no plane to turn to")
        self.core.refuse_compensation("G53.1")
        if state.tcp_off:
            raise ProgramError("VP017", "G53.1 while tool-centre-point control is off (user-defined code)")
        self.core.hold_tool_axis((0.0, 0.0, 1.0))
        begin = self.core.start_of_motion(MoveKind.RAPID, absolute=True, machine=False, axes=(3, 5))
        end = self.setup.coordinates.point_axis(list(begin), np.array([0.0, 0.0, 1.0]), state.frame)
        self.recorder.fix_c(block.line)
        self.core.line(block, MoveKind.RAPID, end, [3, 5] if self.setup.machine else [])


def _turn_z(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _turn_x(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
