"""Values of frames: CTRANS, CROT, CSCALE, CMIRROR, chained by a colon, and frame variables of the control."""

from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.affine import build_rotation, split
from verne_post.gcode.offsets import make_vector9
from verne_post.gcode.siemens.cursor import Cursor
from verne_post.gcode.siemens.frames import Frames
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.siemens.values import Index, Names, read_number
from verne_post.gcode.siemens.vocabulary import FRAME_FUNCTIONS
from verne_post.model.moves import AXES, ZERO9, Frame

#: The programmable frame, the work offset in force, and the stored ones, which have an index.
_PROGRAMMABLE, _ACTIVE_OFFSET, _STORED_OFFSET = "$P_PFRAME", "$P_IFRAME", "$P_UIFR"
#: 1 - cosine of the angle between the Z of a work offset and that of the machine that is rounding.
_UPRIGHT: Final = 1e-12


def holds_frame(name: str, index: tuple[Index, ...]) -> bool:
    """True for variables whose value is a whole frame."""
    return (name in (_PROGRAMMABLE, _ACTIVE_OFFSET) and not index) or (name == _STORED_OFFSET and len(index) == 1)


class FrameValues:
    """Reads and sets frames on an interpreter; ``names`` are the variables of expressions."""

    def __init__(self, interpreter: SiemensInterpreter, names: Names) -> None:
        self.to, self.names = interpreter, names

    def assign(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> None:
        """Read the value of a frame, and set a variable to it.

        ProgramError VP001 and others where it is no frame; VP002 for work offsets that mirror, scale or tilt.
        """
        value, to = self._read(cursor), self.to
        to.splines.end_spline()
        to.motion.corners.finish()
        if name == _PROGRAMMABLE:
            to.motion.note_numbers()
            to.frame_words.change_frames(replace(value, swivel=to.modes.frames.swivel), name)
            return
        if name == _ACTIVE_OFFSET:
            to.core.refuse_compensation(name)
            to.motion.note_numbers()
            to.modes.offset = self._work_offset(value, to.state.systems[to.modes.system], name, cursor, at)
            to.motion.set_chain()
            return
        frame = self._read_stored(name, index, cursor, at)
        to.frame_words.store_offset(self._work_offset(value, frame, name, cursor, at))

    def _read(self, cursor: Cursor) -> Frames:
        """Frames between colons: each refers to the one before."""
        frame = self._read_term(cursor)
        while cursor.take(":"):
            frame = frame.put_inside(self._read_term(cursor))
        return frame

    def _read_term(self, cursor: Cursor) -> Frames:
        cursor.skip()
        at, name = cursor.at, cursor.name()
        if name in FRAME_FUNCTIONS:
            return self._read_function(name, cursor)
        if name == _PROGRAMMABLE:
            return replace(self.to.modes.frames, swivel=Frames().swivel)
        if name in (_ACTIVE_OFFSET, _STORED_OFFSET):
            return self._read_offset_frame(name, cursor, at)
        expected_values = (
            f"expected a frame: {', '.join(FRAME_FUNCTIONS)}, {_PROGRAMMABLE}, {_ACTIVE_OFFSET} or {_STORED_OFFSET}[n]"
        )
        raise cursor.error("VP001", expected_values, at)

    def _read_function(self, name: str, cursor: Cursor) -> Frames:
        """CTRANS(X,10,Y,20) and so on: axes with values; CMIRROR(X) axes alone."""
        values: dict[int, float] = {}
        cursor.expect("(", f"after {name}")
        while not cursor.take(")"):
            if values:
                cursor.expect(",", f"or ')' in {name}")
            cursor.skip()
            at, letter = cursor.at, cursor.name()
            if letter not in tuple("XYZABC" if name == "CTRANS" else "XYZ"):
                raise cursor.error("VP001", f"{name}: expected the name of an axis", at)
            axis = AXES.index(letter)
            if axis in values:
                raise cursor.error("VP004", f"{letter} appears twice in {name}", at)
            values[axis] = 0.0
            if name != "CMIRROR":
                cursor.expect(",", f"and a value after {letter}")
                values[axis] = read_number(cursor, self.names)
            if name == "CSCALE" and values[axis] <= 0:
                raise cursor.error("VP007", f"{name}({letter},{values[axis]:g}): a scale is greater than 0", at)
        return self.to.frame_words.change_chain(Frames(), name[1:], values)

    # --- work offsets -----------------------------------------------------------------------------------

    def _read_offset_frame(self, name: str, cursor: Cursor, at: int) -> Frames:
        """A work offset as the value of a frame."""
        if name == _ACTIVE_OFFSET:
            frame = self.to.modes.offset or self.to.state.systems[self.to.modes.system]
        else:
            cursor.expect("[", f"after {name}")
            number = read_number(cursor, self.names)
            cursor.expect("]", f"after the number of {name}")
            frame = self._read_stored(name, (round(number),), cursor, at)
        if frame.part_turn:
            raise cursor.error("VP025", f"{name}: a program cannot read the turn of the part (--wcs)", at)
        value = Frames().move(list(frame.origin[:3]), list(frame.origin[3:6]))
        return value.turn(build_rotation(2, frame.turn))

    def _read_stored(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> Frame:
        number = index[0]
        systems = self.to.state.systems
        if not isinstance(number, int) or number < 0 or self.to.frame_words.find_system(number) not in systems:
            raise cursor.error("VP025", f"{name}[{number}]: there is no such work offset", at)
        return systems[self.to.frame_words.find_system(number)]

    @staticmethod
    def _work_offset(value: Frames, frame: Frame, name: str, cursor: Cursor, at: int) -> Frame:
        """A work offset with the shift and the turn about Z of a frame."""
        parts = split(value.program, value.mirrored_axis)
        rotation = parts.rigid.linear
        turn = float(DEG_PER_RAD * np.arctan2(rotation[1, 0], rotation[0, 0]))
        if parts.scale != (1.0, 1.0, 1.0) or rotation[2, 2] < 1.0 - _UPRIGHT:
            raise cursor.error(
                "VP002",
                f"{name}: a work offset here is shifted, and turned about Z; write the rest as {_PROGRAMMABLE}",
                at,
            )
        origin = make_vector9([*value.program.shift, *value.rotary, *ZERO9[6:]])
        return replace(frame, origin=origin, turn=turn, g92=ZERO9)
