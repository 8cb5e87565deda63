"""Values of the words of RS274/NGC blocks: lengths in the unit in force, axes, whole numbers, polar words."""

import math
from typing import Final

from verne_post.base.tolerances import WHOLE_NUMBER, ZERO_LENGTH_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.block import Block
from verne_post.gcode.machining.machining import check_dwell
from verne_post.gcode.machining.state import State
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.setup import Setup
from verne_post.model.moves import AXES

#: Axes whose words are lengths.
LINEAR: Final = "XYZUVW"
_NUMBER_OF_AXIS: Final = {letter: axis for axis, letter in enumerate(AXES)}
#: Coordinates beyond this are mistakes, not motion: 100 m, and nearly 300 turns.
MAX_LENGTH_MM: Final = 1e5
MAX_ANGLE_DEG: Final = 1e5


def read_whole(block: Block, letter: str) -> int:
    """Value of a word that must be a whole number from 0 on."""
    value = block.words[letter]
    number = round(value)
    if abs(value - number) > WHOLE_NUMBER:
        raise block.error("VP007", f"{letter}{value:g} must be a whole number", letter)
    if number < 0:
        raise block.error("VP007", f"{letter}{value:g} must not be negative", letter)
    return number


def find_polar_end(block: Block, x: float, y: float, *, absolute: bool) -> tuple[float, float]:
    """Where the polar words of a block lead from a place, all in the unit of the program."""
    distance, angle = math.hypot(x, y), math.degrees(math.atan2(y, x))
    if distance < ZERO_LENGTH_MM and (not absolute or "^" not in block.polar):
        raise block.error("VP017", "at X0 Y0 the last angle is not defined; give @ and ^ in G90", "X")
    if absolute:
        distance, angle = block.polar.get("@", distance), block.polar.get("^", angle)
    else:
        distance, angle = distance + block.polar.get("@", 0.0), angle + block.polar.get("^", 0.0)
    return distance * math.cos(math.radians(angle)), distance * math.sin(math.radians(angle))


class WordValues:
    """Values of words in mm and degrees."""

    def __init__(self, setup: Setup, state: State) -> None:
        self.setup, self.state = setup, state
        self.modes: Modes = state.modes

    def convert_length(self, value: float) -> float:
        """A length of the program in mm."""
        return value * MM_PER_INCH if self.modes.inch else value

    def read_dwell(self, block: Block) -> float:
        """P, the time of a dwell, s."""
        return check_dwell(block, block.words["P"] * self.modes.dwell_unit)

    def read_axis_value(self, block: Block, axis: int) -> float:
        """The word of an axis, mm or degrees; refuses (VP007) what is beyond any machine."""
        letter = AXES[axis]
        value = block.words[letter]
        if self.modes.inch and letter in LINEAR:
            value *= MM_PER_INCH
        if self.setup.machine and abs(value) > (MAX_LENGTH_MM if letter in LINEAR else MAX_ANGLE_DEG):
            lost_point = "; its decimal point may be missing" if value == round(value) else ""
            raise block.error("VP007", f"{letter}{value:g} is beyond any machine{lost_point}", letter)
        return value

    def list_named_axes(self, block: Block) -> list[int]:
        """The axes that a block names, in their order."""
        return sorted([_NUMBER_OF_AXIS[letter] for letter in block.words if letter in _NUMBER_OF_AXIS])
