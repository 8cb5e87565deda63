"""Long stretches of plain straight moves of Siemens programs, as arrays, where they mean what they mean in every dialect."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.gcode import plain
from verne_post.gcode.siemens.flow import Flow
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.text import Chunk

_MOTION: Final = {"G0": 0, "G1": 10}
_ROTARY: Final = slice(3, 6)
#: The last direction is looked for in so many lines, before it is in all.
_NEAR: Final = 64


def execute_stretch(flow: Flow, chunk: Chunk, before: int | None) -> int | None:
    """Execute the plain lines that come next at once.

    Parameters
    ----------
    flow : Flow
    chunk : Chunk
        That holds the next line.
    before : int or None
        Line before which the stretch must end.

    Returns
    -------
    int or None
        The line after the last one that was executed; None where the next line is to be executed by itself.
    """
    to, line = flow.executor.interpreter, flow.line
    row = line - chunk.first_line
    last = min(chunk.ends[row], flow.frame.section.last + 1 - chunk.first_line)
    if before is not None:
        last = min(last, before - chunk.first_line)
    if last - row < plain.MIN_LINES or flow.frame.repeats or flow.executor.modal is not None or not _is_plain(to):
        return None
    to.state.motion = _MOTION[to.modes.motion]
    if not plain.is_ready(to.state, chunk.lines, row):
        return None
    if not _rotary_words_are_plain(to):
        rows = np.arange(row, last, dtype=chunk.lines.row.dtype)
        named = (chunk.lines.row[row:last, _ROTARY] == rows[:, None]).any(axis=1)
        last = row + int(np.argmax(named)) if named.any() else last
        if last - row < plain.MIN_LINES:
            return None
    start = np.array(to.state.position[:3])
    done = plain.execute(chunk.lines, row, last, to, flow.shown_line)
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


def _rotary_words_are_plain(to: SiemensInterpreter) -> bool:
    """True where A and C words turn the table linearly."""
    return to.modes.tcp and to.leads_axes("words") and not to.keys.modulo_axes


def _find_heading(lines: plain.PlainLines, first: int, last: int, start: Array) -> Array | None:
    """The direction (3,) of the last move with a length among lines ``first`` to ``last`` (excluded); ``start`` is (3,)."""
    for begin in (max(first, last - _NEAR), first):
        rows = slice(max(begin - 1, first), last)
        ends = np.where(lines.row[rows, :3] >= first, lines.filled[rows, :3], start)
        ways = np.diff(ends if begin > first else np.vstack([start, ends]), axis=0)
        lengths = np.sqrt((ways**2).sum(axis=1))
        moving = np.flatnonzero(lengths)
        if len(moving):
            return np.asarray(ways[moving[-1]] / lengths[moving[-1]])
    return None
