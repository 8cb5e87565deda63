"""TRANS, ROT, SCALE, MIRROR and their additive forms, numbers of work offsets, the plane of CYCLE800."""

from verne_post.base.arrays import Array
from verne_post.gcode.affine import build_rotation
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.siemens.frames import Frames
from verne_post.gcode.siemens.motion import SiemensMotion
from verne_post.gcode.siemens.words import Words
from verne_post.model.moves import AXES, Frame
from verne_post.model.part_setup import ADDITIONAL_SYSTEMS


class SiemensFrameWords:
    """Places, and the words that change where they are."""

    def __init__(self, motion: SiemensMotion) -> None:
        self.motion = motion
        self.core = motion.core
        self.state = motion.state
        self.keys = motion.keys

    @staticmethod
    def find_system(number: int) -> int:
        """Work system of a settable offset: 1 to 4 are G54 to G57, 5 and on G505 and on."""
        return number if number <= 9 else ADDITIONAL_SYSTEMS + number - 9

    def run_frame_word(self, words: Words) -> None:
        """Execute TRANS, ROT, SCALE, MIRROR or an additive one."""
        word = words.find_code("frame")
        assert word is not None
        kind = word[1:] if word in ("ATRANS", "AROT", "ASCALE", "AMIRROR") else word
        values = {axis: item for axis, letter in enumerate(AXES[:6]) if (item := words.take(letter)) is not None}
        for axis, item in values.items():
            if item.mode not in ("", "AC"):
                raise item.error("VP001", f"{item.mode}: values of {word} are plain numbers")
            if kind != "TRANS" and axis > 2:
                raise item.error("VP006", f"{word} does not use {item.name}")
            if kind == "SCALE" and item.value <= 0:
                raise item.error("VP007", f"{word} {item.name}{item.value:g}: a scale is greater than 0")
        chain, in_plane = self.motion.modes.frames.begin(word), words.take("RPL") if kind == "ROT" else None
        if in_plane is not None and values:
            raise in_plane.error("VP003", f"{word} takes RPL=, or angles about X, Y, Z")
        if in_plane is not None:
            chain = chain.turn(build_rotation((2, 1, 0)[self.state.plane], in_plane.value))
        else:
            chain = self.change_chain(chain, kind, {axis: item.value for axis, item in values.items()})
        self.change_frames(chain, word)

    def change_frames(self, chain: Frames, word: str) -> None:
        """Put another chain of frames in force while the machine stands still; ``word`` for messages."""
        self.core.refuse_compensation(word)
        before = self.motion.modes.frames
        self.motion.modes.frames = chain
        try:
            self.motion.set_chain()
        except ProgramError:
            self.motion.modes.frames = before
            raise

    def change_chain(self, chain: Frames, kind: str, values: dict[int, float]) -> Frames:
        """A chain after TRANS, ROT, SCALE or MIRROR; values by axis: lengths in program units, degrees, factors."""
        if kind == "TRANS":
            shift = [self.motion.modes.length * values.get(axis, 0.0) for axis in range(3)]
            return chain.move(shift, [values.get(axis, 0.0) for axis in (3, 4, 5)])
        if kind == "ROT":
            return chain.turn(self._read_rotation(*(values.get(axis, 0.0) for axis in range(3))))
        if kind == "SCALE":
            return chain.scale_axes([values.get(axis, 1.0) for axis in range(3)])
        return chain.mirror(sorted(values))

    def _read_rotation(self, x: float, y: float, z: float) -> Array:
        """The turn of ROT by angles about X, Y, Z, in the order of the machine data."""
        if self.keys.rotation == "euler":
            return build_rotation(2, x) @ build_rotation(0, y) @ build_rotation(2, z)
        return build_rotation(2, z) @ build_rotation(1, y) @ build_rotation(0, x)

    def store_offset(self, frame: Frame) -> None:
        """A stored work offset changes; what is written holds from the next G54 on."""
        state, modes = self.state, self.motion.modes
        if frame.system == modes.system and modes.offset is None:
            modes.offset = state.systems[frame.system]
        self.core.frames.store_later(frame)
