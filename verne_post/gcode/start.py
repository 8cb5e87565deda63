"""Where a program starts: the position at which the machine must stand before the first block, from opening lines."""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.long_text import Text, take_line
from verne_post.base.program_lines import remove_remarks
from verne_post.base.tolerances import START_POSE_MM, ZERO_ANGLE
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.first_places import FirstPlaces
from verne_post.gcode.setup import Setup
from verne_post.model.findings import Finding, InputError, Remedy, make_finding, make_input_error
from verne_post.model.moves import AXES, MoveKind, Moves

#: A system of equations for the start is solved up to this condition number; beyond it the start is not determined.
_MAX_CONDITION: Final = 1e9
#: So many times what is missing is added before its slopes are computed.
_PLAIN_STEPS: Final = 2
#: Table angles that are compared differ by one degree, or not at all.
_TURN_DEG: Final = 1.0


class Start(NamedTuple):
    """Program position (9) at the start, mm and degrees.

    ``unsaid`` is VP036, and the axes of which it is true, each with the line that names it: the program cuts before it
    has said how the table stands, and the table is not taken to stand at 0. None elsewhere.
    """

    position: list[float]
    unsaid: tuple[Finding, dict[int, int]] | None


def find_start(source: Text, setup: Setup, dialect: Dialect) -> Start:
    """Find where a program starts.

    Every axis stands, from the beginning, where its own first naming in absolute terms puts it
    (:class:`~verne_post.gcode.first_places.FirstPlaces`); axes never named are 0 in the first active work system. So
    are A and C where the program ends all planes, cuts, and names them first for a plane.

    Raises
    ------
    InputError
        What is wrong in the opening lines; VP013 where they do not determine the start.
    """
    opening = _Opening(source, setup, dialect)
    position = opening.find_start()
    unsaid = opening.find_unsaid_table(position)
    if unsaid is not None and opening.is_level_first:
        opening.unnamed_axes += tuple(unsaid[1])
        position = opening.find_start()
        unsaid = opening.find_unsaid_table(position)
    return Start(position.tolist(), unsaid)


class _Opening:
    """The opening lines of a program, up to the one after which the position of every axis is known."""

    def __init__(self, source: Text, setup: Setup, dialect: Dialect) -> None:
        self.source, self.setup, self.dialect = source, setup, dialect
        self.frame = dialect.initial_state(setup).frame
        self.unnamed_axes = tuple(
            AXES.index(letter) for letter in setup.axes if not dialect.names_axis(source, letter, setup)
        )
        self.discovered_run: Execution | None = None  # the replay that settled A and C
        #: Whether the program ends all planes, cuts, and then names A and C for a plane: the cuts are those of a level
        #: table, not of one that stands as the plane wants it.
        self.is_level_first = False

    def find_start(self) -> Array:
        """Program position (9) at the start.

        The opening lines are replayed from a place; what is then missing at each axis is the distance to the start. In
        most programs adding it is exact. Otherwise, with A and C settled, it is affine in X, Y, Z: three more replays
        give its slopes, and these the start.
        """
        position = np.zeros(len(AXES))
        misses, execution = self._replay(position, tolerant=True)
        late = [axis for axis in range(len(AXES)) if not execution.state.is_known(axis)]
        if late:  # their letters stand in blocks like G10 alone
            self.unnamed_axes += tuple(late)
            misses, execution = self._replay(position, tolerant=True)
        self.discovered_run = execution
        found = self._solve(position, misses, waits=False)
        if found is None:
            misses = self._replay(position, tolerant=True, waits=True)[0]
            found = self._solve(position, misses, waits=True)
        if found is not None:
            return found
        letters = " and ".join(self.setup.rotary_letters)
        raise make_input_error(
            "VP013",
            "the pose at which the program starts cannot be found from its first lines: they leave an axis open, "
            f"or contradict each other; name X, Y, Z, {letters} in one rapid traverse first",
            line=1,
        )

    def _solve(self, guess: Array, misses: Array, *, waits: bool) -> Array | None:
        """The position at which nothing is missing, from a guess at which ``misses`` (9) are; None where there is
        none.
        """
        position = guess.copy()
        for _ in range(_PLAIN_STEPS):
            position += misses
            misses = self._replay(position, waits=waits)[0]
            if np.abs(misses).max() < START_POSE_MM:
                return position
        slopes = np.zeros((3, 3))
        for axis in range(3):
            moved_position = position.copy()
            moved_position[axis] += 1.0
            slopes[:, axis] = (self._replay(moved_position, waits=waits)[0] - misses)[:3]
        position[:3] -= np.linalg.lstsq(slopes, misses[:3], rcond=1.0 / _MAX_CONDITION)[0]
        misses = self._replay(position, waits=waits)[0]
        return position if np.abs(misses).max() < START_POSE_MM else None

    def find_unsaid_table(self, position: Array) -> tuple[Finding, dict[int, int]] | None:
        """What to say of cuts before A and C are named, of a program that starts at a program position (9).

        Their angles are those at which the table is taken to start: they change when that does.
        """
        machine = self.setup.coordinates.map_to_machine(position, self.frame)
        turned_rows = [
            axis
            for axis in self.setup.rotary
            if AXES[axis] in self.setup.axes
            and axis not in self.unnamed_axes
            and abs(machine[axis]) > ZERO_ANGLE * DEG_PER_RAD
        ]
        if not turned_rows:
            return None
        other = position.copy()
        other[turned_rows] += _TURN_DEG
        here, there = (self._list_moves(start) for start in (position, other))
        if len(here) != len(there):  # an error in one of them, which is reported by itself
            return None
        cuts = np.isin(here.kind, (MoveKind.FEED, MoveKind.ARC, MoveKind.SPLINE))
        unsaid = np.abs(here.end[:, turned_rows] - there.end[:, turned_rows]) > 0.5 * _TURN_DEG
        at = np.flatnonzero(cuts & unsaid.any(axis=1))
        if not len(at):
            return None
        first, named_line = int(here.line[at[0]]), int(here.line[-1])
        planes = here.planes
        self.is_level_first = bool(
            planes and planes[-1].word and any(not one.word and one.before <= at[0] for one in planes)
        )
        axes = [axis for axis, is_open in zip(turned_rows, unsaid[at[0]], strict=True) if is_open]
        letters = " and ".join(AXES[axis] for axis in axes)
        stands = _spell_angles(axes, position)
        text = f"the program cuts before it names {letters}: assumed to start at {stands}, as line {named_line} says; "
        if planes and planes[-1].word and not any(self._has_word(named_line, AXES[axis]) for axis in axes):
            text = (
                f"the program cuts before line {named_line}, the first to turn the table, to {stands}; where the table "
                f"stands before is not known, and is assumed to be {stands} too; "
            )
        text += f"name {letters} before"
        edits = (Remedy(f"name {letters}", stands, line=first),)
        return make_finding("VP036", text, line=first, edits=edits), dict.fromkeys(axes, named_line)

    def _has_word(self, line: int, letter: str) -> bool:
        """Whether a line names an axis: a plane turns it without its letter."""
        text = remove_remarks((take_line(self.source, line) or b"").decode("latin-1"))
        return re.search(rf"(?<![A-Z]){letter}\s*[-+=.\[#\dQ]", text, re.IGNORECASE) is not None

    def _list_moves(self, position: Array) -> Moves:
        """Moves of the opening lines of a program that starts at a position."""
        _misses, execution = self._replay(position, tolerant=True)
        return execution.recorder.freeze(position.tolist(), self.frame, {})

    def _replay(self, position: Array, *, tolerant: bool = False, waits: bool = False) -> tuple[Array, Execution]:
        """What is missing at each axis (9) when the opening lines start at a program position, mm and degrees."""
        state = self.dialect.initial_state(self.setup)
        state.known_axes = [letter not in self.setup.axes for letter in AXES]
        state.position = position.tolist()
        machine = self.setup.coordinates.map_to_machine(position, self.frame)
        state.first_places = FirstPlaces(self.unnamed_axes, machine, waits)
        start = list(state.position)
        execution = self.dialect.execute(self.source, self.setup, state, StopConditions(all_known=True))
        # a tool of no length hides nothing: with what it leaves open, A and C are settled all the same
        if execution.errors and not (tolerant and all(item.code == "VP012" for item in execution.errors)):
            raise InputError(*(self._explain_tilt(item, start) for item in execution.errors))
        return np.array(state.first_places.misses), execution

    def _explain_tilt(self, item: Finding, start: list[float]) -> Finding:
        """Extend an error (VP017) from the tilt of the start by its source: the last of the opening lines."""
        opening_run, tilt = self.discovered_run, self.setup.rotary[0]
        if (
            item.code != "VP017"
            or not start[tilt]
            or not item.line
            or opening_run is None
            or not opening_run.recorder.count
        ):
            return item
        opening = int(opening_run.recorder.freeze(start, opening_run.state.frame, {}).line[-1])
        is_called = item.line >= opening  # a subprogram behind, which the opening lines call
        if is_called and "the tool points along" not in item.message:
            return item
        letter = AXES[tilt]
        is_named = self._has_word(opening, letter)
        first = f"{letter} is named first in line {opening}" if is_named else f"line {opening} turns {letter}"
        why = (
            f"; {first}, so the program starts with {letter} {start[tilt]:g}: name "
            f"{self.setup.both_rotary} before {'the call of ' * is_called}line {item.line}"
        )
        angles = _spell_angles([axis for axis in self.setup.rotary if AXES[axis] in self.setup.axes], start)
        edits = (*item.edits, Remedy(f"name {self.setup.both_rotary}", angles, line=item.line))
        return replace(item, message=item.message + why, edits=edits)


def _spell_angles(axes: Sequence[int], position: Sequence[float] | Array) -> str:
    """Rotary axes as a program names them: ``A30 C0``."""
    return " ".join(f"{AXES[axis]}{position[axis]:.6g}" for axis in axes)
