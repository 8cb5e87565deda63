"""What a controller dialect is. Each is one file of :mod:`verne_post.gcode.dialects`."""

import re
from collections.abc import Callable
from typing import Final

from msgspec import Struct

from verne_post.base.long_text import Text
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.machining.state import State
from verne_post.gcode.setup import Setup
from verne_post.gcode.words import read_whole_lines

#: Inches and mm of RS274 blocks.
INCH_OF_BLOCKS: Final = (r"(?<![A-Z])(G0*20)(?![\d.])", "G21")


class Rival(Struct, frozen=True):
    """A dialect whose texts look like those of another, and what shows that a text is of the latter."""

    name: str
    find_sign: Callable[[Text], str]  #: Empty where nothing shows it.


class Dialect(Struct, frozen=True):
    """One controller dialect."""

    #: True for a text that can only be of this dialect. Of several that do, the first by name reads it.
    recognise: Callable[[Text], bool]
    initial_state: Callable[[Setup], State]  #: The modal state at the start of a program.
    #: What :meth:`execute` does for this language.
    run: Callable[[Text, Setup, State, StopConditions], Execution]
    #: (text, axis letter, setup) -> True when the text gives this axis a position.
    names_axis: Callable[[Text, str, Setup], bool]
    #: Of files whose text is of this dialect where no dialect recognises it, in lower case.
    endings: tuple[str, ...] = ()
    #: Whether a text in such a file is of this dialect in spite of a first line that another one recognises.
    has_title: Callable[[Text], bool] = lambda _source: False
    rival: Rival | None = None  #: Might read a text that this one has recognised.
    #: Pattern of the word that asks for inches, as its first group, and the word for mm, which
    #: may name further groups; None where it has none.
    inch: tuple[str, str] | None = None

    def execute(self, source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
        """Execute a text on a state until it ends or a stop condition is met.

        Raises
        ------
        RuntimeError
            A line was given up, and no error says so: without it the program would count as one that can run.
        """
        execution = self.run(source, setup, state, stop)
        line = execution.recorder.given_up_line
        if line and not execution.errors:
            raise RuntimeError(f"line {line} was given up, or read as another one, and no error says why")
        return execution


def names_axis_in_blocks(source: Text, letter: str, setup: Setup) -> bool:
    """Of RS274 blocks: true when the letter stands anywhere outside comments: it may give the axis a position."""
    pattern = letter.encode()
    if letter in setup.rotary_letters:  # tool axes name them
        pattern += rb"|G0*43\.50*(?![0-9])|G0*53\.10*(?![0-9])"
    elif letter in "XY":
        pattern += rb"|[@^]"
    texts = (text for whole in (source, *setup.subroutines.values()) for text in read_whole_lines(whole))
    return any(
        re.search(pattern, re.sub(rb"\([^)\n]*(?:\)|$)|;[^\n]*", b"", text, flags=re.MULTILINE).upper())
        for text in texts
    )
