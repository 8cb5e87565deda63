"""Long stretches of plain straight moves of Siemens programs, as arrays, where they mean what they mean in every dialect."""

from functools import partial
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.gcode import plain
from verne_post.gcode.execution import StopConditions
from verne_post.gcode.motion_codes import length_of
from verne_post.gcode.siemens.flow import Flow
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.siemens.places import NO_AXIS
from verne_post.gcode.text import Chunk

_MOTION: Final = {"G0": 0, "G1": 10}
_ROTARY: Final = [3, 4, 5]
_A, _C = 3, 5


def execute_stretch(flow: Flow, chunk: Chunk, stop: StopConditions, *, in_main: bool) -> int | None:
    """Execute the plain lines that come next at once.

    Parameters
    ----------
    flow : Flow
    chunk : Chunk
        That holds the next line.
    stop : StopConditions
    in_main : bool
        The program itself is executed, not what it calls.

    Returns
    -------
    int or None
        The line after the last one that was executed; None where the next line is to be executed by itself.
    """
    to, line = flow.executor.interpreter, flow.line
    row = line - chunk.first_line
    last = min(chunk.lines.end(row) + chunk.first_line, flow.frame.section.last + 1)
    last = stop.cut(line, last, in_main=in_main) - chunk.first_line
    if last - row < plain.MIN_LINES or flow.frame.repeats or flow.executor.modal is not None or not _is_plain(to):
        return None
    to.state.motion = _MOTION[to.modes.motion]
    pointed = bool(chunk.lines.has_offsets[row])
    if not plain.is_ready(to.state, chunk.lines, row, pointed=pointed):
        return None
    if pointed:
        last = _end_of_vectors(to, chunk.lines, row, last)
    elif chunk.lines.offsets is not None:
        last = min(last, chunk.lines.next_curved(row))
    if pointed or not _rotary_words_are_plain(to):
        last = chunk.lines.first_named(row, last, _ROTARY)
    if last - row < plain.MIN_LINES:
        return None
    start = to.state.position[:3]
    done = plain.execute(
        chunk.lines, row, last, to, flow.shown_line, partial(_point, to, chunk.lines) if pointed else None
    )
    if done == row:
        return None
    to.modes.motion = "G0" if to.state.motion == 0 else "G1"
    heading = _find_heading(chunk.lines, row, done, start)
    to.heading = to.heading if heading is None else heading
    flow.line = line + done - row
    flow.repeats.count(flow.text, line, flow.line - 1, 0)
    return flow.line


def _is_plain(to: SiemensInterpreter) -> bool:
    """True where words of X, Y, Z and F are what they are in every dialect."""
    modes = to.modes
    return (
        modes.motion in _MOTION
        and modes.absolute
        and modes.units in ("G71", "G710")
        and to.has_no_scale
        and modes.frames.rotary == (0.0, 0.0, 0.0)
    )


def _end_of_vectors(to: SiemensInterpreter, lines: plain.PlainLines, first: int, last: int) -> int:
    """Where lines end that all have a tool axis; the first line itself where they cannot be executed at once."""
    modes = to.modes
    of_machine = modes.reference == "ORIMKS" and not modes.frames.total.is_identity
    if not modes.tcp or of_machine or False in to.state.known:
        return first
    assert lines.offsets is not None
    other = ~lines.has_offsets[first:last] | (length_of(np.nan_to_num(lines.offsets[first:last])) < NO_AXIS)
    return first + int(np.argmax(other)) if other.any() else last


def _point(to: SiemensInterpreter, lines: plain.PlainLines, first: int, end: Array) -> Array | None:
    """Turn A and C of ends (n, 9) to the tool axes of the lines; returns these (n, 3), or None where A and C go linearly."""
    state = to.state
    assert lines.offsets is not None
    vectors = np.nan_to_num(lines.offsets[first : first + len(end)])
    axes = to.turn_vectors(vectors / length_of(vectors)[:, None])
    pairs = to.setup.coordinates.point_axes((state.position[_A], state.position[_C]), axes, state.frame)
    end[:, [_A, _C]] = pairs
    linear = to.leads_axes("vector") and to.setup.machine
    state.tool_axis = None if linear else (float(axes[-1, 0]), float(axes[-1, 1]), float(axes[-1, 2]))
    if to.setup.machine:
        state.placed = True
        for axis in (_A, _C):
            state.named[axis] = True
    return None if linear else axes


def _rotary_words_are_plain(to: SiemensInterpreter) -> bool:
    """True where A and C words turn the table linearly."""
    return to.modes.tcp and to.leads_axes("words") and not to.keys.modulo_axes


def _find_heading(lines: plain.PlainLines, first: int, last: int, start: list[float]) -> Array | None:
    """The direction (3,) of the last move with a length among lines ``first`` to ``last`` (excluded); ``start`` is (3,)."""
    if last - first > 1:  # most often the last move has one
        here, there = (
            [word if row >= first else rest for word, row, rest in zip(words, rows, start, strict=False)]
            for words, rows in zip(
                lines.filled[last - 2 : last].tolist(), lines.row[last - 2 : last].tolist(), strict=True
            )
        )
        if here != there:
            step = np.array(there) - here
            return np.asarray(step / np.sqrt((step**2).sum()))
    ends = np.where(lines.row[first:last, :3] >= first, lines.filled[first:last, :3], start)
    steps = np.diff(np.vstack([start, ends]), axis=0)
    lengths = np.sqrt((steps**2).sum(axis=1))
    moving = np.flatnonzero(lengths)
    return np.asarray(steps[moving[-1]] / lengths[moving[-1]]) if len(moving) else None
