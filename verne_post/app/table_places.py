"""Where the table stands when a program goes on from tool axes in machine coordinates: known from the whole program.

A tool axis leaves the side of the table open, and turns of C. The branches of a program are chosen over all of it; but
where the machine is on the part after SUPA X0 Y0, or G53, depends on that. So such a program is read, its branches
are chosen, and where the table stands elsewhere than it was read for, it is read again with the places that were found.
"""

from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post import gcode
from verne_post.base.long_text import Text
from verne_post.base.team import ALONE, Team
from verne_post.base.tolerances import POLE_SINE, ZERO_ANGLE
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.setup import Setup
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Machine
from verne_post.model.moves import Frame, Moves, TablePlace
from verne_post.model.options import Options
from verne_post.model.protocols import name_solution
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.branch_choice import choose_branches
from verne_post.toolpath.branches import BranchPlan

#: Times that a program is read again: once finds the places, unless what follows them changes the choice.
MOST_READINGS: Final = 4


def add_table(setup: Setup, moves: Moves) -> Setup:
    """A set-up with which a program is read again as it was read for these moves."""
    return replace(setup, table_places=tuple(place.machine for place in moves.table_places))


def lay_out(
    source: Text, setup: Setup, moves: Moves, machine: Machine, options: Options, team: Team = ALONE
) -> tuple[Moves, ToolPath, BranchPlan | None]:
    """Choose the branches of a program, and read it again where they put the table elsewhere than it was read for.

    Parameters
    ----------
    moves : Moves
        The program as it was read first.

    Raises
    ------
    InputError
        VP013: no choice of branches fits the places of the machine that follow from it.
    """
    places_known = len(setup.table_places)
    for _ in range(MOST_READINGS):
        path, branches = choose_branches(
            moves,
            machine,
            options.orientation,
            allow_rewind=options.allow_rewind,
            team=team,
            places_known=places_known,
        )
        found = tuple(
            _find_place(place, path, machine, is_known=number < places_known)
            for number, place in enumerate(moves.table_places)
        )
        wrong = [place for place, stands in zip(moves.table_places, found, strict=True) if not _agrees(place, stands)]
        if not wrong:
            return moves, path, branches
        moves, places_known = gcode.interpret_program(source, replace(setup, table_places=found)), len(found)
    line = int(moves.line[max(wrong[0].before - 1, 0)])
    text = (
        "after the tool axis of this line the program names machine coordinates, and which of the two "
        "{}s is used depends on them; name {} and {} in one rapid traverse before them"
    ).format(name_solution(machine.coordinates), *machine.rotary_letters)
    raise make_input_error("VP013", text, line=line)


def _find_place(place: TablePlace, path: ToolPath, machine: Machine, *, is_known: bool) -> tuple[float, float]:
    """Where the table really stands, as :class:`TablePlace` has it.

    Under an upright tool C may still turn to a known place: the rapid that leads to it does.
    """
    at = int(np.searchsorted(path.move, place.before)) - 1
    after = at + 1 if at + 1 < len(path) and path.move[at + 1] == place.before else at
    if place.by_words:
        at = after  # a rewind may come right before it
    if at < 0:
        return place.machine
    found = _name_place(path, at, machine)
    is_upright = max(abs(np.sin(path.end[at, 3])), abs(np.sin(path.end[after, 3]))) <= POLE_SINE
    if is_known and is_upright and not _agrees(place, found):
        return _name_place(path, after, machine)
    return found


def _name_place(path: ToolPath, at: int, machine: Machine) -> tuple[float, float]:
    """A and C at the end of a segment, machine coordinates, degrees."""
    words = machine.coordinates.map_from_table(np.zeros(3), path.end[at, 3:], Frame())
    a, c = (float(words[axis]) for axis in machine.coordinates.rotary)
    return a, c


def _agrees(place: TablePlace, stands: tuple[float, float]) -> bool:
    return bool(np.abs(np.subtract(place.machine, stands)).max() <= DEG_PER_RAD * ZERO_ANGLE)
