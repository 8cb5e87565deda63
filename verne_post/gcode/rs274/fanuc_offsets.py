"""Codes of Fanuc that change offsets: G10, G52, G92, and additional work systems."""

import numpy as np

from verne_post.gcode.block import Block
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.rs274.offsets import OffsetCodes
from verne_post.gcode.rs274.values import whole
from verne_post.model.part_setup import ADDITIONAL_SYSTEMS


class FanucOffsets:
    """G10, G52 and G92 as Fanuc has them."""

    def __init__(self, offsets: OffsetCodes) -> None:
        self.offsets, self.core, self.values, self.state = offsets, offsets.core, offsets.values, offsets.state
        self.modes: Modes = offsets.state.modes

    def find_additional(self, block: Block) -> int:
        number = whole(block, "P")
        if ADDITIONAL_SYSTEMS + number not in self.state.systems or number == 0:
            last = max(self.state.systems) - ADDITIONAL_SYSTEMS
            raise block.error("VP007", f"P{number}: additional work systems are P1 to P{last}", "P")
        return number

    def store_offset(self, block: Block) -> None:
        """L2: G54 to G59; L20: G54.1 P; L10: the length of a tool, as L1 of RS274/NGC has it."""
        words = block.words
        if "L" not in words:
            raise ProgramError("VP005", "G10 needs L: L2 for G54 to G59, L20 for G54.1, L10 for the length of a tool")
        kind = whole(block, "L")
        if not self.modes.absolute:
            raise ProgramError("VP017", "G10 in G91 adds to what is stored; write G90, and the whole value")
        if kind == 2 and words.get("P") == 0:
            raise block.error("VP007", "P0: the external work offset is not kept here; give it with --wcs", "P")
        if kind == 20 and "P" in words:
            self.offsets.set_origin(block, ADDITIONAL_SYSTEMS + self.find_additional(block))
            return
        if kind == 10:
            if "R" not in words:
                raise ProgramError("VP005", "G10 L10 needs R, the length")
            words["L"], words["Z"], block.columns["Z"] = 1.0, words.pop("R"), block.columns.pop("R")
        elif kind == 2 and "R" in words:
            raise block.error("VP006", "G10 L2 does not use R: work systems are not turned here", "R")
        elif kind != 2:
            raise block.error("VP002", f"G10 L{kind} is not executed; expected L2, L10 or L20", "L")
        self.offsets.execute_g10(block)

    def shift_system(self, block: Block, code: int) -> None:
        """G92, and G52: a system inside that of G92, which ends it on the axes that it names."""
        state, axes = self.state, self.values.named_axes(block)
        local, outer = list(self.modes.local_shift), np.subtract(state.frame.g92, self.modes.local_shift)
        self.offsets.execute_g92(block, code)
        for axis in axes:
            local[axis] = self.values.axis_value(block, axis) if code == 520 else 0.0
        self.modes.local_shift = tuple(local)
        if code == 520:
            self.core.frames.store_shift(float(value) for value in outer + local)
            self.core.frames.apply_shift(on=True)
