"""A whole program -> Moves: its dialect, every error, and where it starts."""

from dataclasses import replace
from typing import Final

import numpy as np

from verne_post.base.long_text import Text
from verne_post.base.tolerances import START_POSE_MM
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.dialects import DIALECTS, choose_dialect
from verne_post.gcode.execution import Execution, StopConditions, all_known
from verne_post.gcode.languages import find_other_language
from verne_post.gcode.missing_setup import missing_offsets
from verne_post.gcode.parameters import Parameters
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State
from verne_post.model.findings import Finding, InputError, finding
from verne_post.model.moves import AXES, Moves

_A: Final = AXES.index("A")
#: A system of equations for the start is solved up to this condition number; beyond it the start is not determined.
_MAX_CONDITION: Final = 1e9


def interpret_program(source: Text, setup: Setup) -> Moves:
    """Interpret a program.

    Parameters
    ----------
    source : Text
        Text in the dialect that the setup names, or that is recognised.
    setup : Setup
        Coordinates, tools, offsets.

    Returns
    -------
    Moves

    Raises
    ------
    InputError
        With every error that could be found (VP0xx).
    """
    dialect = choose_dialect(setup.dialect, source)
    state = dialect.initial_state(setup)
    if setup.machine:
        try:
            position = _start_position(source, setup, dialect)
        except InputError as error:  # report what else is wrong, after the opening lines
            state.known = [True] * 9
            done = dialect.execute(source, setup, state, StopConditions())
            seen = {(item.line, item.code) for item in done.errors}
            every = [*done.errors, *(item for item in error.findings if (item.line, item.code) not in seen)]
            raise _refusal(source, every, dialect, done, setup) from None
        state.known = [True] * 9
        state.position = position
    start, start_frame = list(state.position), state.frame
    done = dialect.execute(source, setup, state, StopConditions())
    if done.errors:
        every = [*done.errors, *done.recorder.warnings.values()]
        raise _refusal(source, every, dialect, done, setup)
    return done.recorder.freeze(start, start_frame, Parameters(setup, state).persistent())


def interpret_until_error(source: Text, setup: Setup) -> tuple[Moves, tuple[Finding, ...]]:
    """As :func:`interpret_program`, without a machine: the moves before the first error, and the errors."""
    dialect = choose_dialect(setup.dialect, source)
    state = dialect.initial_state(setup)
    start, frame = list(state.position), state.frame
    done = dialect.execute(source, setup, state, StopConditions(first_error=True))
    errors = done.errors
    if errors:
        every = dialect.execute(source, setup, dialect.initial_state(setup), StopConditions()).errors
        other = _find_language(source, every, dialect)
        errors = errors if other is None else [other]
    return done.recorder.freeze(start, frame, Parameters(setup, state).persistent()), tuple(errors)


def _explain_tilt(item: Finding, start: list[float], opened: Execution | None) -> Finding:
    """An error that comes from the tilt of the start (VP017), with where that is from: the line that ``opened`` the position of all axes."""
    if item.code != "VP017" or not start[_A] or not item.line or opened is None or not opened.recorder.count:
        return item
    opening = int(opened.recorder.freeze(start, opened.state.frame, {}).line[-1])
    if item.line >= opening:
        return item
    why = f"; A is named first in line {opening}, so the program starts with A {start[_A]:g}: name A and C before line {item.line}"
    return replace(item, message=item.message + why)


def _find_cause(source: Text, errors: list[Finding], dialect: Dialect) -> list[Finding]:
    """Errors in the order of their lines; one alone where the program is in another language."""
    other = _find_language(source, errors, dialect)
    return sorted(errors, key=lambda item: item.line or 0) if other is None else [other]


def _refusal(source: Text, errors: list[Finding], dialect: Dialect, done: Execution, setup: Setup) -> InputError:
    """The errors of a program; where a tool is missing, with the work offsets that nobody gave either."""
    found = _find_cause(source, errors, dialect)
    if done.recorder.count and any(item.code in ("VP012", "VP018") for item in found):
        moves = done.recorder.freeze(list(done.state.position), done.state.frame, {})
        found += missing_offsets(moves, setup)
    return InputError(*found)


def _find_language(source: Text, errors: list[Finding], dialect: Dialect) -> Finding | None:
    name = next(name for name, other in DIALECTS.items() if other is dialect)
    return find_other_language(source, errors, name, DIALECTS, recognised=dialect.recognise(source))


def state_after(source: Text, setup: Setup, moves: Moves, line: int) -> State:
    """The modal state after one line of a program that :func:`interpret_program` has read, for ``explain``.
    The line is 1-based; where it is executed several times, the first time counts.
    """
    return replay(source, setup, moves, StopConditions(after_line=line))[0]


def replay(source: Text, setup: Setup, moves: Moves, stop: StopConditions) -> tuple[State, Recorder]:
    """Execute a program that has been read again from its start, up to ``stop``: the state there, and what was recorded."""
    dialect = choose_dialect(setup.dialect, source)
    state = dialect.initial_state(setup)
    state.known = [True] * 9
    state.position = [float(value) for value in moves.start]
    return state, dialect.execute(source, setup, state, stop).recorder


# --- where the program starts -----------------------------------------------------------------


def _start_position(source: Text, setup: Setup, dialect: Dialect) -> list[float]:
    """Program position at which the machine must stand before the first block.

    Until the program has named an axis, it stands at the machine coordinate that it has in the
    first pose whose axes are all known; axes never named are 0 in the first active work system.
    That pose may itself depend on the start (a Z kept in machine coordinates under tilt), so the
    start is the fixed point of replaying the opening lines. With A and C settled the replay is
    affine in the start, and four replays give the fixed point exactly.
    """
    unnamed = [AXES.index(letter) for letter in setup.axes if not dialect.names_axis(source, letter, setup)]
    coordinates = setup.coordinates
    frame = dialect.initial_state(setup).frame
    discovered: Execution | None = None  # the replay that settled A and C

    def replay(machine: np.ndarray, *, discover: bool) -> tuple[np.ndarray, Execution]:
        """Machine position after the opening lines when they start at ``machine``."""
        state = dialect.initial_state(setup)
        state.known = [axis in unnamed or AXES[axis] not in setup.axes for axis in range(9)]
        state.position = [float(v) for v in coordinates.to_program(machine, frame)]
        if discover:
            state.floating = tuple(unnamed)
            for axis in unnamed:
                state.position[axis] = 0.0
        start = list(state.position)
        done = dialect.execute(source, setup, state, StopConditions(all_known=True))
        # a tool of no length hides nothing: with what it leaves open, A and C are settled all the same
        if done.errors and not (discover and all(item.code == "VP012" for item in done.errors)):
            raise InputError(*(_explain_tilt(item, start, discovered) for item in done.errors))
        return coordinates.to_machine(np.array(done.state.position), done.state.frame), done

    guess, done = replay(coordinates.to_machine(np.zeros(9), frame), discover=True)
    if not all_known(done.state, setup):  # some letters stand only in blocks like G10
        unnamed = [axis for axis in range(9) if not done.state.known[axis]] + unnamed
        guess, done = replay(coordinates.to_machine(np.zeros(9), frame), discover=True)
    discovered = done
    for _ in range(2):  # the first replay settles A and C, the second the rest unless the coupling is real
        again, _done = replay(guess, discover=False)
        if np.abs(again - guess).max() < START_POSE_MM:
            return [float(v) for v in coordinates.to_program(guess, frame)]
        guess = again
    base, _done = replay(guess, discover=False)
    slopes = np.zeros((3, 3))
    for axis in range(3):
        moved = guess.copy()
        moved[axis] += 1.0
        slopes[:, axis] = (replay(moved, discover=False)[0] - base)[:3]
    matrix = np.eye(3) - slopes
    if np.linalg.cond(matrix) < _MAX_CONDITION:
        guess[:3] += np.linalg.solve(matrix, (base - guess)[:3])
        again, _done = replay(guess, discover=False)
        if np.abs(again - guess).max() < START_POSE_MM:
            return [float(v) for v in coordinates.to_program(guess, frame)]
    raise InputError(
        finding("VP013", "the pose at which the program starts cannot be found from its first lines; "
                "name X, Y, Z, A and C in one G0 block first", line=1, last_line=1, worst_line=1)
    )  # fmt: skip
