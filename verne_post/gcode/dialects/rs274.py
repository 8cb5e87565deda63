"""RS274/NGC as LinuxCNC speaks it: the language of the interpreter itself."""

import re

from verne_post.base.long_text import Text
from verne_post.gcode.execution import Pass, Stops, run_blocks
from verne_post.gcode.interpret import Interpreter, initial_state
from verne_post.gcode.scan import whole_lines
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State


def recognise(source: Text) -> bool:
    """Nothing shows this dialect: it is what is left."""
    return False


def start(setup: Setup) -> State:
    """G80 G17 G90 G91.1 G94 G40 G49 G54 G64 G99, mm."""
    return initial_state(setup)


def run(source: Text, setup: Setup, state: State, stops: Stops) -> Pass:
    """Execute the blocks."""
    return run_blocks(source, setup, state, stops, Interpreter)


def names(source: Text, letter: str, setup: Setup) -> bool:
    """True when the letter stands anywhere outside comments: at least it may give the axis a place."""
    sought = letter.encode()
    if letter in "AC":  # tool axes name them
        sought += rb"|G0*43\.50*(?![0-9])|G0*53\.10*(?![0-9])"
    elif letter in "XY":
        sought += rb"|[@^]"
    texts = (text for whole in (source, *setup.subroutines.values()) for text in whole_lines(whole))
    return any(re.search(sought, re.sub(rb"\([^)\n]*\)|;[^\n]*", b"", text).upper()) for text in texts)
