"""TRANS, ROT, SCALE, MIRROR and their additive forms, numbers of work offsets, the plane of CYCLE800."""

import numpy as np

from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.siemens.frames import rotation_about
from verne_post.gcode.siemens.places import SiemensPlaces
from verne_post.gcode.siemens.words import Words
from verne_post.model.moves import AXES
from verne_post.model.part_setup import ADDITIONAL_SYSTEMS


class SiemensFrameWords(SiemensPlaces):
    """Places, and the words that change where they are."""

    @staticmethod
    def system_number(number: int) -> int:
        """Work system of a settable offset: 1 to 4 are G54 to G57, 5 and on G505 and on."""
        return number if number <= 9 else ADDITIONAL_SYSTEMS + number - 9

    def run_frame_word(self, words: Words, block: Block) -> None:
        """Execute TRANS, ROT, SCALE, MIRROR or an additive one."""
        word = words.code("frame")
        assert word is not None
        self._refuse_compensation(word)
        chain = self.modes.frames.begin(word)
        kind = word[1:] if word in ("ATRANS", "AROT", "ASCALE", "AMIRROR") else word
        values = {axis: item for axis, letter in enumerate(AXES[:6]) if (item := words.take(letter)) is not None}
        for item in values.values():
            if item.mode not in ("", "AC"):
                raise item.error("VP001", f"{item.mode}: values of {word} are plain numbers")
        if kind != "TRANS" and any(axis > 2 for axis in values):
            item = next(item for axis, item in values.items() if axis > 2)
            raise item.error("VP006", f"{word} does not use {item.name}")
        numbers = {axis: item.value for axis, item in values.items()}
        if kind == "TRANS":
            shift = [self.modes.length * numbers.get(axis, 0.0) for axis in range(3)]
            chain = chain.move(shift, [numbers.get(axis, 0.0) for axis in (3, 4, 5)])
        elif kind == "ROT":
            chain = chain.turn(self._rotation(words, numbers, word))
        elif kind == "SCALE":
            for axis, factor in numbers.items():
                if factor <= 0:
                    raise values[axis].error(
                        "VP007", f"{word} {values[axis].name}{factor:g}: a scale is greater than 0"
                    )
            chain = chain.stretch([numbers.get(axis, 1.0) for axis in range(3)])
        else:
            chain = chain.mirror(sorted(numbers))
        before = self.modes.frames
        self.modes.frames = chain
        try:
            self.set_chain()
        except BlockError:
            self.modes.frames = before
            raise

    def _rotation(self, words: Words, angles: dict[int, float], word: str) -> np.ndarray:
        """The turn of ROT: RPL in the plane, or angles about X, Y, Z in the order of the machine data."""
        in_plane = words.take("RPL")
        if in_plane is not None:
            if angles:
                raise in_plane.error("VP003", f"{word} takes RPL=, or angles about X, Y, Z")
            return rotation_about((2, 1, 0)[self.state.plane], in_plane.value)
        x, y, z = (angles.get(axis, 0.0) for axis in range(3))
        if self.keys.rotation == "euler":
            return rotation_about(2, x) @ rotation_about(0, y) @ rotation_about(2, z)
        return rotation_about(2, z) @ rotation_about(1, y) @ rotation_about(0, x)
