"""Positions of the table that hold a tool axis within its travel: PLANE and CYCLE800 choose among them.

(A, C) and (-A, C + 180) hold the same axis, and so does every whole turn of C. A control takes one in reach.
"""

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.gcode.setup import Setup
from verne_post.model.moves import Frame

_FULL_TURN: Final = 360.0
#: Farther beyond the travel than this, degrees, less tilt is asked for; up to it the check also tries to move the part.
_FAR_TILT_DEG: Final = 20.0


class TablePosition(Struct, frozen=True, eq=False):
    """One position."""

    program: list[float]  #: Nine-vector in the frame.
    tilt: float  #: A of the machine, degrees; its sign tells the two sides apart.
    motion: float  #: How far C is from where it stood, degrees.
    beyond: str  #: Letters of the axes that would be beyond their travel.


def find_positions(
    setup: Setup, start: list[float], vector: Array, frame: Frame, *, tip_stays: bool
) -> list[TablePosition]:
    """Positions that hold a tool axis (3,), program directions: the nearest C of each side, and other turns.

    One position where the tool comes to stand upright on the table.

    Parameters
    ----------
    start : list of float
        Where the machine is, nine-vector in the frame.
    tip_stays : bool
        The tip keeps its place on the part; else the linear axes of the machine stand.
    """
    coordinates, (tilt, turn) = setup.coordinates, setup.rotary
    here = np.array(coordinates.map_to_machine(np.array(start), frame))
    first = np.array(coordinates.map_to_machine(np.array(coordinates.turn_to_axis(start, vector, frame)), frame))
    other = coordinates.find_other_side(first) if setup.machine else None
    sides = [first] if other is None else [first, other]
    found = []
    for side in sides:
        words = coordinates.map_to_program(side, frame)
        nearest = float(words[turn]) - _FULL_TURN * round((float(words[turn]) - start[turn]) / _FULL_TURN)
        for whole in (0.0, -_FULL_TURN, _FULL_TURN):
            program = np.array(start)
            program[[tilt, turn]] = words[tilt], nearest + whole
            place = np.array(coordinates.map_to_machine(program, frame))
            if not tip_stays:
                place[:3] = here[:3]
                program = np.array(coordinates.map_to_program(place, frame))
            beyond = setup.travel.find_beyond(place, frame.tool_length) if setup.travel is not None else ""
            if beyond and whole:
                continue
            values = [float(value) for value in program]
            found.append(TablePosition(values, float(side[tilt]), abs(values[turn] - start[turn]), beyond))
            if len(sides) == 1:
                return found
    return found


def describe_far_tilt(setup: Setup, positions: list[TablePosition], frame: Frame) -> str:
    """The tilt that a plane needs far beyond the travel where the part stands (VP102); "" where it is not so.

    What follows would be its consequences. Nearer to the limit the check of the motion decides: the tilt of the
    platform depends on the place of the part, so that it may find one with which the plane is within reach.
    """
    tilt, places = setup.rotary[0], []
    if setup.travel is None:
        return ""
    for one in positions:
        place = np.array(setup.coordinates.map_to_machine(np.array(one.program), frame))
        places.append(float(place[tilt]))
        place[tilt] -= math.copysign(_FAR_TILT_DEG, one.tilt)
        if setup.rotary_letters[0] not in setup.travel.find_beyond(place, frame.tool_length):
            return ""
    words = " or ".join(dict.fromkeys(f"{setup.rotary_letters[0]}{one.tilt:+.3f}" for one in positions))
    return (
        f"needs {words}, and {setup.travel.describe_tilt(places)}: that is far beyond the travel where the part "
        "stands; use less tilt"
    )


def choose_position(
    positions: list[TablePosition], rank: Callable[[TablePosition], tuple[float, ...]]
) -> TablePosition:
    """The first in rank within the travel, or of all where none is; the limit check then reports the excess."""
    return min((one for one in positions if not one.beyond), key=rank, default=min(positions, key=rank))
