"""Codes of Fanuc that change offsets: G10, G52, G92, and additional work systems."""

from typing import Final

import numpy as np

from verne_post.base.printable import quote_key
from verne_post.gcode.block import Block
from verne_post.gcode.machining.machining import warn_of_deviation
from verne_post.gcode.missing_setup import find_tool_key
from verne_post.gcode.program_error import GIVE_PLACE, ProgramError
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.rs274.offsets import OffsetCodes
from verne_post.gcode.rs274.values import read_whole
from verne_post.model.part_setup import ADDITIONAL_SYSTEMS, describe_tool_number, name_system

#: L of G10 -> what it stores of a tool; lengths come first.
_OF_TOOLS: Final = {10: "length", 11: "wear of the length", 12: "radius", 13: "wear of the radius"}
_LAST_OF_LENGTH, _WEAR = 11, (11, 13)
#: P of G10 L2: G54 to G59.
_LAST_SYSTEM: Final = 6


class FanucOffsets:
    """G10, G52 and G92 as Fanuc has them."""

    def __init__(self, offsets: OffsetCodes) -> None:
        self.offsets, self.core, self.values, self.state = offsets, offsets.core, offsets.values, offsets.state
        self.modes: Modes = offsets.state.modes

    def find_additional(self, block: Block) -> int:
        number = read_whole(block, "P")
        if ADDITIONAL_SYSTEMS + number not in self.state.systems or number == 0:
            last = max(self.state.systems) - ADDITIONAL_SYSTEMS
            raise block.error("VP007", f"P{number}: additional work systems are P1 to P{last}", "P")
        return number

    def store_offset(self, block: Block) -> None:
        """L2: G54 to G59; L20: G54.1 P; L10: the length of a tool, as L1 of RS274/NGC has it."""
        words = block.words
        if "L" not in words:
            raise ProgramError("VP005", "G10 needs L: L2 for G54 to G59, L20 for G54.1, L10 to L13 for a tool")
        kind = read_whole(block, "L")
        if kind == 2 and words.get("P") == 0:
            raise block.error("VP007", "P0: the external work offset is not kept here; give it with --wcs", "P")
        if kind == 20 and "P" in words:
            self._store_origin(block, ADDITIONAL_SYSTEMS + self.find_additional(block))
            return
        if kind == 2 and "P" in words and "R" not in words and 0 < read_whole(block, "P") <= _LAST_SYSTEM:
            self._store_origin(block, read_whole(block, "P"))
            return
        if not self.modes.absolute:
            raise ProgramError("VP017", f"G10 L{kind} in G91 adds to what is stored; write G90, and the whole value")
        if kind in _OF_TOOLS:
            self._store_tool_offset(block, kind)
            return
        if kind == 2 and "R" in words:
            raise block.error("VP006", "G10 L2 does not use R: work systems are not turned here", "R")
        if kind != 2:
            raise block.error("VP002", f"G10 L{kind} is not executed; expected L2, L10 to L13 or L20", "L")
        self.offsets.execute_g10(block)

    def _store_origin(self, block: Block, system: int) -> None:
        """The origin of a work system, or in G91 how far it moves from where it is."""
        adds, setup = not self.modes.absolute, self.offsets.setup
        if adds and setup.machine and system not in setup.given_systems | self.core.recorder.placed_systems:
            name = name_system(system)
            raise ProgramError(
                "VP033",
                f"G10 in G91 moves {name}, but its place is not given; give --wcs {name}=X,Y,Z",
                settled_by=("wcs", name),
            ).advise(GIVE_PLACE.format(quote_key(name)))
        self.offsets.set_origin(block, system, adds=adds)

    def _store_tool_offset(self, block: Block, kind: int) -> None:
        """L10, L11: length and its wear; L12, L13: radius and its wear. The tool has the sums, as L1 stores it."""
        words, columns = block.words, block.columns
        if "R" not in words or "P" not in words:
            raise ProgramError("VP005", f"G10 L{kind} needs P, the number, and R, the {_OF_TOOLS[kind]}")
        number, of_length = read_whole(block, "P"), kind <= _LAST_OF_LENGTH
        wear = list(self.modes.wear.get(number, (0.0, 0.0)))
        value, place = self.values.convert_length(words["R"]), 0 if of_length else 1
        if kind in _WEAR:
            tool = (self.state.tools or {}).get(number)
            if tool is None or (of_length and tool.unmeasured) or not (of_length or tool.diameter):
                if value == wear[place]:  # nothing is added to what is not known
                    return
                what = "length" if of_length else "diameter"
                key, name = find_tool_key(number, what, self.state.tool_names), f"tool {number}"
                why = f"the {_OF_TOOLS[kind]} is added to that of tool {number}, which is not known"
                raise block.error("VP012", f"G10 L{kind}: {why}", "P", name, key)
            before = tool.offset[2] if of_length else 0.5 * tool.diameter
            name = describe_tool_number(number, self.state.tool_names)
            warn_of_deviation(self.core, f"G10 L{kind} R", value, 0.0 if of_length else before, name, block.line)
            value, wear[place] = before - wear[place] + value, value
            self.modes.wear = {**self.modes.wear, number: (wear[0], wear[1])}
        else:
            value += wear[place]
        unit = self.values.convert_length(1.0)
        words["L"], words["R"] = 1.0, value / unit
        if of_length:
            words["Z"], columns["Z"] = words.pop("R"), columns.pop("R")
        self.offsets.execute_g10(block, adds_wear=kind in _WEAR)

    def shift_system(self, block: Block, code: int) -> None:
        """G92, and G52: a system inside that of G92, which ends it on the axes that it names."""
        state, axes = self.state, self.values.list_named_axes(block)
        local, outer = list(self.modes.local_shift), np.subtract(state.frame.g92, self.modes.local_shift)
        self.offsets.execute_g92(block, code)
        for axis in axes:
            local[axis] = self.values.read_axis_value(block, axis) if code == 520 else 0.0
        self.modes.local_shift = tuple(local)
        if code == 520:
            self.core.frames.store_shift(float(value) for value in outer + local)
            self.core.frames.apply_shift(on=True)
