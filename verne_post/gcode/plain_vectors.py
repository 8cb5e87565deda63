"""Tool axes I J K (G43.5) in stretches of plain lines, vectorised: to the last bit as the general interpreter."""

from functools import partial
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import VECTOR_LENGTH
from verne_post.gcode import plain
from verne_post.gcode.lengths import measure_length
from verne_post.gcode.machining.machining import Machining

_ROTARY: Final = [3, 4, 5]
_G: Final = 10
#: Column of R among the words of arcs.
_R: Final = 3


def end_of_vectors(core: Machining, view: plain.PlainView, lines: plain.PlainLines, first: int, last: int) -> int:
    """Where straight moves with a tool axis end; ``first`` itself where they cannot be executed at once."""
    state, offsets = core.state, lines.offsets
    if offsets is None or False in state.known_axes:
        return first
    last = lines.find_first_named(first, last, _ROTARY)
    words = offsets[first:last]
    # what has no length is not one either
    other = ~(np.abs(measure_length(words[:, :_R]) - 1.0) <= VECTOR_LENGTH) | ~np.isnan(words[:, _R])
    has_code = lines.row[first:last, _G] >= first
    other |= np.where(has_code, lines.filled_words[first:last, _G], (view.motion or 0) / 10) > 1
    return first + int(np.argmax(other)) if other.any() else last


def take_vectors(core: Machining, lines: plain.PlainLines) -> plain.Point:
    """Takes the tool axes of lines up to :func:`end_of_vectors`."""
    return partial(_aim_tool, core, lines)


def _aim_tool(core: Machining, lines: plain.PlainLines, first: int, end: Array) -> Array:
    """Turn the rotary axes of ends (n, 9) to the tool axes of the lines; returns these (n, 3)."""
    assert lines.offsets is not None
    vectors = lines.offsets[first : first + len(end), :_R]
    axes = vectors / measure_length(vectors)[:, None]
    plain.turn_to_axes(core, end, axes)
    core.hold_tool_axis(axes[-1])
    return np.asarray(axes)
