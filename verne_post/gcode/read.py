"""A whole program -> Moves: start and end of the text, errors collected, the start pose found."""

import re
from dataclasses import dataclass
from typing import Final

import numpy as np

from verne_post.base.tolerances import START_POSE_MM
from verne_post.gcode import plain
from verne_post.gcode.block import Block, BlockError, read_block
from verne_post.gcode.interpret import Interpreter, initial_state
from verne_post.gcode.scan import chunks, scan
from verne_post.gcode.state import Recorder, Setup, State
from verne_post.model.findings import Finding, InputError, finding
from verne_post.model.moves import AXES, Moves

#: So many errors are reported at most: behind them a file is not G-code.
MAX_ERRORS: Final = 50


@dataclass
class Pass:
    """One interpretation of a program, or of its beginning."""

    state: State
    recorder: Recorder
    errors: list[Finding]
    complete: bool


def interpret_program(source: bytes, setup: Setup) -> Moves:
    """Interpret a program.

    Parameters
    ----------
    source : bytes
        RS274/NGC text.
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
    first = initial_state(setup)
    if setup.machine:
        try:
            position = _start_position(source, setup)
        except InputError as error:  # report what else is wrong, behind the opening lines
            state = initial_state(setup)
            state.known = [True] * 9
            others = _interpret(source, setup, state).errors
            seen = {(item.line, item.code) for item in error.findings}
            every = [*error.findings, *(item for item in others if (item.line, item.code) not in seen)]
            raise InputError(*sorted(every, key=lambda item: item.line or 0)) from None
        state = initial_state(setup)
        state.known = [True] * 9
        state.position = position
    else:
        state = first
    start, start_frame = list(state.position), state.frame
    done = _interpret(source, setup, state)
    if done.errors:
        raise InputError(*done.errors)
    return done.recorder.freeze(start, start_frame)


def interpreted_until_error(source: bytes, setup: Setup) -> tuple[Moves, tuple[Finding, ...]]:
    """As :func:`interpret_program` for an interpreter's view: the moves before the first error, and the errors."""
    state = initial_state(setup)
    start, frame = list(state.position), state.frame
    done = _interpret(source, setup, state, stop_at_error=True)
    return done.recorder.freeze(start, frame), tuple(done.errors)


def state_after(source: bytes, setup: Setup, moves: Moves, line: int) -> State:
    """The modal state behind one line of a program that :func:`interpret_program` has read, for explanations.

    Parameters
    ----------
    source : bytes
    setup : Setup
        As it was read with.
    moves : Moves
        What was read; says where the program starts.
    line : int
        1-based.
    """
    state = initial_state(setup)
    state.known = [True] * 9
    state.position = [float(value) for value in moves.start]
    # without its end the text is no whole program: that one error is of no concern here
    _interpret(b"\n".join(source.split(b"\n")[:line]) + b"\n", setup, state)
    return state


# --- one pass over the text -----------------------------------------------------------------


def _interpret(
    source: bytes, setup: Setup, state: State, *, until_known: bool = False, stop_at_error: bool = False
) -> Pass:
    """Execute blocks until the program ends (or, on demand, until every axis is known)."""
    recorder = Recorder()
    run = Pass(state, recorder, [], complete=False)
    machine = Interpreter(setup, state, recorder)
    percent_first, percent_last = _percent_lines(source)
    for first_line, text in chunks(source):
        words = scan(first_line, text)
        lines = plain.PlainLines(words, setup)
        stretch_end = lines.ends()
        raw_lines: list[bytes] | None = None
        row = 0
        while row < words.n_lines:
            line = first_line + row
            if percent_last is not None and line >= percent_last:
                return _ended(run, percent_first, percent_last, line, machine)
            last = int(stretch_end[row])
            if percent_last is not None:
                last = min(last, percent_last - first_line)
            if last - row >= plain.MIN_LINES and plain.ready(state):
                done = plain.execute(lines, row, last, setup, state, recorder)
                if until_known and _all_known(state, setup):
                    return run
                if done > row:
                    row = done
                    continue
            if raw_lines is None:
                raw_lines = text.split(b"\n")
            raw = raw_lines[row]
            row += 1
            deleted = setup.block_delete and raw.lstrip().startswith(b"/")
            if line == percent_first or deleted or not raw.strip():
                continue
            try:
                machine.execute(_block(raw, line))
            except BlockError as error:
                run.errors.append(finding(error.code, error.message, line=line,
                                          last_line=line, worst_line=line, column=error.column))  # fmt: skip
                if stop_at_error or len(run.errors) >= MAX_ERRORS:
                    return run
            if machine.ended:
                run.complete = True
                return run
            if until_known and _all_known(state, setup):
                return run
    return _ended(run, percent_first, percent_last, source.count(b"\n") + (not source.endswith(b"\n")), machine)


def _block(raw: bytes, line: int) -> Block:
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")  # older CAM systems; it can only matter inside comments
    return read_block(text, line)


def _percent_lines(source: bytes) -> tuple[int | None, int | None]:
    """1-based lines of the opening and the closing ``%``; None where there are none."""
    opening = re.match(rb"\s*%[ \t\r]*(?:\n|$)", source)
    if opening is None:
        return None, None
    first = source.count(b"\n", 0, source.index(b"%")) + 1
    closing = re.compile(rb"^[ \t]*%[ \t\r]*$", re.MULTILINE).search(source, opening.end())
    if closing is None:
        return first, None
    return first, source.count(b"\n", 0, closing.start()) + 1


def _ended(run: Pass, first: int | None, last: int | None, line: int, machine: Interpreter) -> Pass:
    """The text is over without M2 or M30: right only with a pair of %."""
    if first is not None and last is not None:
        machine.recorder.event(line, "end", code="%")
    else:
        what = "M2, M30 or a closing %" if first is not None else "M2 or M30"
        at = max(line, 1)
        run.errors.append(finding("VP010", f"the file ends without {what}", line=at, last_line=at, worst_line=at))
    run.complete = True
    return run


# --- where the program starts -----------------------------------------------------------------


def _all_known(state: State, setup: Setup) -> bool:
    return all(state.known[AXES.index(letter)] for letter in setup.axes)


def _never_named(source: bytes, axes: str) -> list[int]:
    """Axes whose letter stands nowhere outside comments."""
    text = re.sub(rb"\([^)\n]*\)|;[^\n]*", b"", source).upper()
    if re.search(rb"G0*43\.50*(?![0-9])", text):
        text += b" A C"  # tool axes name them
    return [AXES.index(letter) for letter in axes if letter.encode() not in text]


def _start_position(source: bytes, setup: Setup) -> list[float]:
    """Program position at which the machine must stand before the first block.

    Until the program has named an axis, it stands at the machine coordinate that it has in the
    first pose whose axes are all known; axes never named are 0 in the first active work system.
    That pose may itself depend on the start (a Z kept in machine coordinates under tilt), so the
    start is the fixed point of replaying the opening lines. With A and C settled the replay is
    affine in the start, and four replays give the fixed point exactly.
    """
    unnamed = _never_named(source, setup.axes)
    coordinates = setup.coordinates
    frame = initial_state(setup).frame

    def replay(machine: np.ndarray, *, discover: bool) -> tuple[np.ndarray, Pass]:
        """Machine position after the opening lines when they start at ``machine``."""
        state = initial_state(setup)
        state.known = [axis in unnamed or AXES[axis] not in setup.axes for axis in range(9)]
        state.position = [float(v) for v in coordinates.to_program(machine, frame)]
        if discover:
            state.floating = tuple(unnamed)
            for axis in unnamed:
                state.position[axis] = 0.0
        done = _interpret(source, setup, state, until_known=True)
        if done.errors:
            raise InputError(*done.errors)
        return coordinates.to_machine(np.array(done.state.position), done.state.frame), done

    guess, done = replay(coordinates.to_machine(np.zeros(9), frame), discover=True)
    if not _all_known(done.state, setup):  # some letters stand only in blocks like G10
        unnamed = [axis for axis in range(9) if not done.state.known[axis]] + unnamed
        guess, done = replay(coordinates.to_machine(np.zeros(9), frame), discover=True)
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
    if np.linalg.cond(matrix) < 1e9:
        guess[:3] += np.linalg.solve(matrix, (base - guess)[:3])
        again, _done = replay(guess, discover=False)
        if np.abs(again - guess).max() < START_POSE_MM:
            return [float(v) for v in coordinates.to_program(guess, frame)]
    raise InputError(
        finding("VP013", "the pose at which the program starts cannot be told from its first lines; "
                "name X, Y, Z, A and C in one G0 block first", line=1, last_line=1, worst_line=1)
    )  # fmt: skip
