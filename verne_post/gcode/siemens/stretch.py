"""Long stretches of plain moves of Siemens programs, as arrays, where they mean what they mean in every dialect."""

from functools import partial
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.gcode import plain
from verne_post.gcode.execution import StopConditions
from verne_post.gcode.lengths import measure_length
from verne_post.gcode.plain_arcs import find_arcs
from verne_post.gcode.siemens.flow import Flow
from verne_post.gcode.siemens.interpreter import MOTIONS, SiemensInterpreter
from verne_post.gcode.siemens.motion import find_tangent_at_end
from verne_post.gcode.siemens.places import LOST_POINT, NO_AXIS
from verne_post.gcode.text import Chunk

_CODES: Final = {motion: code for code, motion in MOTIONS.items()}
_ROTARY: Final = [3, 4, 5]
_G: Final = 10


def execute_stretch(flow: Flow, chunk: Chunk, stop: StopConditions) -> int | None:
    """Execute the plain lines that come next at once.

    Parameters
    ----------
    flow : Flow
    chunk : Chunk
        That holds the next line.
    stop : StopConditions

    Returns
    -------
    int or None
        The line after the last one that was executed; None where the next line is to be executed by itself.
    """
    to, line = flow.executor.interpreter, flow.calls.line
    row = line - chunk.first_line
    last = min(chunk.lines.end(row) + chunk.first_line, flow.calls.frame.section.last + 1)
    last = stop.cut(line, last, is_about=stop.is_about(flow.calls.text)) - chunk.first_line
    if last - row < plain.MIN_LINES or flow.calls.frame.repeats or flow.executor.modal is not None or not _is_plain(to):
        return None
    has_vectors = not chunk.lines.arcs and bool(chunk.lines.has_offsets[row])
    motion = MOTIONS[to.modes.motion]
    view = plain.PlainView(motion, has_tool_axes=has_vectors)
    if not plain.is_ready(to.state, view, chunk.lines, row):
        return None
    if has_vectors:
        last = _end_of_vectors(to, chunk.lines, row, last)
    elif not chunk.lines.arcs:
        last = min(last, chunk.lines.find_next_curved(row))
    if has_vectors or not _has_plain_rotary_words(to):
        last = chunk.lines.find_first_named(row, last, _ROTARY)
    if last - row < plain.MIN_LINES:
        return None
    start = to.state.position
    stretch = plain.execute(
        chunk.lines,
        row,
        last,
        to.core,
        view,
        partial(_aim_tool, to, chunk.lines) if has_vectors else None,
    )
    if stretch == row:
        return None
    if has_vectors:
        assert chunk.lines.offsets is not None
        own_line = to.core.recorder.lines.number(line + stretch - row - 1)
        to.motion.last_vector = chunk.lines.offsets[stretch - 1, :3].copy(), own_line
    to.modes.motion = _CODES[view.motion or 0]
    for axis in [axis for axis in to.motion.places_before if chunk.lines.row[stretch - 1, axis] >= row]:
        del to.motion.places_before[axis]
    _set_heading(to, chunk.lines, row, stretch, start, motion)
    to.motion.note_places(line, line + stretch - row - 1, is_rapid=not view.motion)
    flow.calls.line = line + stretch - row
    flow.repeats.count(flow.calls.text, line, flow.calls.line - 1, 0)
    return flow.calls.line


def _is_plain(to: SiemensInterpreter) -> bool:
    """True where words of X, Y, Z and F are what they are in every dialect."""
    modes = to.modes
    return (
        modes.motion in MOTIONS
        and modes.absolute
        and modes.units in ("G71", "G710")
        and to.motion.has_no_scale
        and modes.frames.rotary == (0.0, 0.0, 0.0)
        and to.motion.corners.is_idle
        and not to.motion.has_doubtful_length
    )


def _end_of_vectors(to: SiemensInterpreter, lines: plain.PlainLines, first: int, last: int) -> int:
    """Where lines end that all have a whole tool axis; the first line itself where they cannot be executed at once."""
    modes = to.modes
    of_machine = modes.reference == "ORIMKS" and not modes.frames.total.is_identity
    if not modes.tcp or of_machine or False in to.state.known_axes:
        return first
    assert lines.offsets is not None
    sizes = measure_length(lines.offsets[first:last])
    other = ~(sizes >= NO_AXIS)  # a component that is missing is NaN
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = sizes / np.append(measure_length(to.motion.last_vector[0]), sizes[:-1])
    other |= ~((ratio < LOST_POINT) & (ratio > 1.0 / LOST_POINT))
    return first + int(np.argmax(other)) if other.any() else last


def _aim_tool(to: SiemensInterpreter, lines: plain.PlainLines, first: int, end: Array) -> Array | None:
    """Turn A and C of ends (n, 9) to the tool axes of lines; returns these (n, 3), or None for linear A and C."""
    assert lines.offsets is not None
    vectors = lines.offsets[first : first + len(end)]
    axes = to.motion.turn_vectors(vectors / measure_length(vectors)[:, None])
    plain.turn_to_axes(to.core, end, axes)
    linear = to.motion.has_linear_axes("vector") and to.setup.machine
    to.core.hold_tool_axis(None if linear else axes[-1], is_aimed=bool(linear))
    return None if linear else axes


def _has_plain_rotary_words(to: SiemensInterpreter) -> bool:
    """True where A and C words turn the table linearly."""
    return to.modes.tcp and to.motion.has_linear_axes("words") and not to.keys.modulo_axes


def _set_heading(
    to: SiemensInterpreter, lines: plain.PlainLines, first: int, last: int, start: list[float], motion: int
) -> None:
    """Keep the direction of the last move with a length among lines ``first`` to ``last`` (excluded).

    ``start`` (9,) and ``motion`` are those before these lines.
    """

    def place(row: int) -> list[float]:
        words = zip(lines.filled_words[row].tolist(), lines.row[row].tolist(), start, strict=False)
        return start if row < first else [word if at >= first else rest for word, at, rest in words]

    for row in range(last - 1, first - 1, -1):  # most often the last line has one
        begin, end = place(row - 1), place(row)
        code = 10 * int(lines.filled_words[row, _G]) if lines.row[row, _G] >= first else motion
        if code >= MOTIONS["G2"] and lines.moves[row]:
            assert lines.offsets is not None
            clockwise = np.array([code == MOTIONS["G2"]])
            arc = find_arcs(
                lines.offsets[[row]], clockwise, np.array([1]), np.array([begin, end]), to.state, inch=False
            )
            to.motion.set_heading(find_tangent_at_end(to.state.plane, arc.center[0].tolist(), end, float(arc.sweep[0])))
            return
        if begin[:3] != end[:3]:
            to.motion.set_heading([b - a for a, b in zip(begin[:3], end[:3], strict=True)])
            return
