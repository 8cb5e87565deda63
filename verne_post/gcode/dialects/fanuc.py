"""Programs of Fanuc controls, and of those that speak like them. docs/fanuc.md lists every word.

They are blocks of RS274/NGC with words of their own: :mod:`verne_post.gcode.rs274.fanuc` reads and executes them.
"""

from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.dialect import INCH_OF_BLOCKS, Dialect, Rival, names_axis_in_blocks
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.initial_state import make_initial_state
from verne_post.gcode.machining.state import State
from verne_post.gcode.rs274.fanuc_text import find_program, find_sign
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import FanucKeys, read_keys


def _find_sign(source: Text) -> str:
    start = find_program(source)
    return find_sign(source[start : start + (1 << 16)])


def _make_initial_state(setup: Setup) -> State:
    """As RS274/NGC, but G98, and F on inside arcs is that on the contour, regardless of G62."""
    state = make_initial_state(setup)
    state.modes.initial_level = True
    state.modes.inch = read_keys(FanucKeys, setup.control.get("fanuc", {})).units == "inch"
    return state


def _execute(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    # most programs speak another language, and every run loads all dialects
    from verne_post.gcode.rs274.fanuc import execute_fanuc

    return execute_fanuc(source, setup, state, stop)


DIALECT: Final[Dialect] = Dialect(
    lambda source: bool(_find_sign(source)),
    _make_initial_state,
    _execute,
    names_axis_in_blocks,
    rival=Rival("rs274", _find_sign),
    inch=INCH_OF_BLOCKS,
)
