"""Where a program starts: the position at which the machine must stand before the first block, from the opening lines."""

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.long_text import Text
from verne_post.base.tolerances import START_POSE_MM, ZERO_ANGLE
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.execution import Execution, StopConditions, all_known
from verne_post.gcode.setup import Setup
from verne_post.model.findings import Finding, InputError, finding
from verne_post.model.moves import AXES, MoveKind, Moves

_A: Final = AXES.index("A")
_C: Final = AXES.index("C")
#: A system of equations for the start is solved up to this condition number; beyond it the start is not determined.
_MAX_CONDITION: Final = 1e9
#: Table angles that are compared differ by one degree, or not at all.
_TURN_DEG: Final = 1.0


class Start(NamedTuple):
    """Program position (9) at the start, mm and degrees.

    ``unsaid`` is what to say where the program cuts before it has said how the table stands, and the table is not taken to
    stand at 0; with the line of that cut. None elsewhere.
    """

    position: list[float]
    unsaid: tuple[str, int] | None


def find_start(source: Text, setup: Setup, dialect: Dialect) -> Start:
    """Find where a program starts.

    Until the program has named an axis, it stands at the machine coordinate that it has in the
    first pose whose axes are all known; axes never named are 0 in the first active work system.

    Raises
    ------
    InputError
        What is wrong in the opening lines; VP013 where they do not determine the start.
    """
    opening = _Opening(source, setup, dialect)
    machine = opening.find_start()
    position = opening.program_position(machine)
    return Start(position, opening.find_unsaid_table(machine, position))


class _Opening:
    """The opening lines of a program, up to the one after which the position of every axis is known."""

    def __init__(self, source: Text, setup: Setup, dialect: Dialect) -> None:
        self.source, self.setup, self.dialect = source, setup, dialect
        self.frame = dialect.initial_state(setup).frame
        self.unnamed = [AXES.index(letter) for letter in setup.axes if not dialect.names_axis(source, letter, setup)]
        self.discovered: Execution | None = None  # the replay that settled A and C

    def program_position(self, machine: Array) -> list[float]:
        """Program position of a machine position, before the first block."""
        return [float(value) for value in self.setup.coordinates.to_program(machine, self.frame)]

    def find_start(self) -> Array:
        """Machine position at the start.

        The first pose may itself depend on the start (a Z kept in machine coordinates under tilt), so the
        start is the fixed point of replaying the opening lines. With A and C settled the replay is
        affine in the start, and four replays give the fixed point exactly.
        """
        zero = self.setup.coordinates.to_machine(np.zeros(9), self.frame)
        guess, done = self._replay(zero, discover=True)
        if not all_known(done.state, self.setup):  # some letters stand only in blocks like G10
            self.unnamed = [axis for axis in range(9) if not done.state.known[axis]] + self.unnamed
            guess, done = self._replay(zero, discover=True)
        self.discovered = done
        for _ in range(2):  # the first replay settles A and C, the second the rest unless the coupling is real
            again, _done = self._replay(guess)
            if np.abs(again - guess).max() < START_POSE_MM:
                return guess
            guess = again
        base, _done = self._replay(guess)
        slopes = np.zeros((3, 3))
        for axis in range(3):
            moved = guess.copy()
            moved[axis] += 1.0
            slopes[:, axis] = (self._replay(moved)[0] - base)[:3]
        matrix = np.eye(3) - slopes
        if np.linalg.cond(matrix) < _MAX_CONDITION:
            guess[:3] += np.linalg.solve(matrix, (base - guess)[:3])
            again, _done = self._replay(guess)
            if np.abs(again - guess).max() < START_POSE_MM:
                return guess
        raise InputError(
            finding("VP013", "the pose at which the program starts cannot be found from its first lines; "
                    "name X, Y, Z, A and C in one G0 block first", line=1, last_line=1, worst_line=1)
        )  # fmt: skip

    def find_unsaid_table(self, machine: Array, position: list[float]) -> tuple[str, int] | None:
        """What to say of cuts of a program that starts at a machine position before A and C are named.

        Their angles are those at which the table is taken to start: they change when that does.
        """
        turned = [
            axis
            for axis in (_A, _C)
            if AXES[axis] in self.setup.axes and axis not in self.unnamed
            and abs(machine[axis]) > ZERO_ANGLE * DEG_PER_RAD
        ]  # fmt: skip
        if not turned:
            return None
        other = machine.copy()
        other[turned] += _TURN_DEG
        here, there = (self._moves(start) for start in (machine, other))
        if len(here) != len(there):  # an error in one of them, which is reported by itself
            return None
        cuts = np.isin(here.kind, (MoveKind.FEED, MoveKind.ARC, MoveKind.SPLINE))
        unsaid = np.abs(here.end[:, turned] - there.end[:, turned]) > 0.5 * _TURN_DEG
        at = np.flatnonzero(cuts & unsaid.any(axis=1))
        if not len(at):
            return None
        first, named = int(here.line[at[0]]), int(here.line[-1])
        axes = [axis for axis, is_open in zip(turned, unsaid[at[0]], strict=True) if is_open]
        letters = " and ".join(AXES[axis] for axis in axes)
        stands = " ".join(f"{AXES[axis]}{position[axis]:.6g}" for axis in axes)
        text = (
            f"the program cuts before it names {letters}: the table is taken to start at {stands}, where line {named} "
            f"puts it; name {letters} before"
        )
        return text, first

    def _moves(self, machine: Array) -> Moves:
        """Moves of the opening lines of a program that starts at a machine position."""
        _end, done = self._replay(machine, discover=True)
        return done.recorder.freeze(self.program_position(machine), self.frame, {})

    def _replay(self, machine: Array, *, discover: bool = False) -> tuple[Array, Execution]:
        """Machine position after the opening lines when they start at ``machine``."""
        state = self.dialect.initial_state(self.setup)
        state.known = [axis in self.unnamed or AXES[axis] not in self.setup.axes for axis in range(9)]
        state.position = self.program_position(machine)
        if discover:
            state.floating = tuple(self.unnamed)
            for axis in self.unnamed:
                state.position[axis] = 0.0
        start = list(state.position)
        done = self.dialect.execute(self.source, self.setup, state, StopConditions(all_known=True))
        # a tool of no length hides nothing: with what it leaves open, A and C are settled all the same
        if done.errors and not (discover and all(item.code == "VP012" for item in done.errors)):
            raise InputError(*(self._explain_tilt(item, start) for item in done.errors))
        return self.setup.coordinates.to_machine(np.array(done.state.position), done.state.frame), done

    def _explain_tilt(self, item: Finding, start: list[float]) -> Finding:
        """An error that comes from the tilt of the start (VP017), with where that is from: the last of the opening lines."""
        opened = self.discovered
        if item.code != "VP017" or not start[_A] or not item.line or opened is None or not opened.recorder.count:
            return item
        opening = int(opened.recorder.freeze(start, opened.state.frame, {}).line[-1])
        if item.line >= opening:
            return item
        why = f"; A is named first in line {opening}, so the program starts with A {start[_A]:g}: name A and C before line {item.line}"
        return replace(item, message=item.message + why)
