"""Long stretches of GOTO in cutter location text, as arrays: what each of them means alone, to the last bit."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import VECTOR_LENGTH
from verne_post.gcode import plain
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.statements import Points
from verne_post.gcode.expressions import MAX_NUMBER
from verne_post.gcode.lengths import measure_length
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.words import WordTable

_LETTERS: Final = np.frombuffer(b"XYZIJK", dtype=np.uint8)


def execute_points(points: Points, row: int, last: int, modes: AptModes, interpreter: Rs274) -> int:
    """Execute lines ``row`` to ``last`` (excluded) at once, as far as possible; returns the first line not done."""
    state = interpreter.state
    if last - row < plain.MIN_LINES or not _is_plain(modes, interpreter):
        return row
    places, axes, which = points.places, points.axes, points.which_axis
    vectors = np.vstack([axes, modes.axis])[which[row:last]]  # before the first axis stands that from before
    sizes = measure_length(vectors)
    bad = (np.abs(sizes - 1.0) > VECTOR_LENGTH) | ~(np.abs(places[row:last]).max(axis=1) <= MAX_NUMBER)
    if not modes.multax:
        bad |= (np.abs(np.diff(vectors, axis=0, prepend=[modes.axis])) > VECTOR_LENGTH).any(axis=1)
    n = int(np.argmax(bad)) if bad.any() else last - row  # the general way names the error
    if n < plain.MIN_LINES:
        return row
    words = WordTable(
        points.line + row,
        b"",
        n,
        np.tile(_LETTERS, n),
        np.hstack([places[row : row + n], vectors[:n]]).ravel(),
        np.repeat(np.arange(n), len(_LETTERS)),
        np.ones(n, dtype=bool),
    )
    lines = plain.PlainLines(words, interpreter.setup, bare_codes=False, others="IJK")
    view = interpreter.view_plain_lines(has_vector=True)
    if view is None or not plain.is_ready(state, view, lines, 0):
        return row

    def aim_tool(first: int, end: Array) -> Array:
        units = vectors[first : first + len(end)] / sizes[first : first + len(end), None]
        plain.turn_to_axes(interpreter.core, end, units)
        interpreter.core.hold_tool_axis(units[-1])
        return units

    stretch = plain.execute(lines, 0, n, interpreter.core, view, aim_tool)
    if stretch:
        interpreter.go_on_after_plain_lines(view)
        modes.axis = tuple(vectors[stretch - 1].tolist())
    return row + stretch


def _is_plain(modes: AptModes, interpreter: Rs274) -> bool:
    """True where GOTO is nothing but a straight move at feed rate, with its tool axis."""
    state = interpreter.state
    return (
        not modes.rapid
        and modes.circle is None
        and modes.cycle is None
        and modes.map.is_identity
        and modes.last_arc is None
        and interpreter.modes.vectors
        and interpreter.modes.motion == 10
        and False not in state.known_axes
    )
