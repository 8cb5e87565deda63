"""The dialects of G-code: how each is recognised, where it starts, and who reads it. All end in one Moves table.

A new dialect is a file of this folder and a line in the table.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.dialects import aptcl, fanuc, rs274
from verne_post.gcode.execution import Pass, Stops
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State

#: Stands for the dialect that the first lines speak.
AUTO: Final = "auto"


@dataclass(frozen=True)
class Dialect:
    """One dialect.

    Attributes
    ----------
    name : str
    recognise : callable
        True for a text that only this dialect explains.
    start : callable
        The state that a program finds.
    run : callable
        Execute a text on a state, until it ends or a stop is met.
    names : callable
        (text, axis letter, setup) -> True when the text gives this axis a place.
    """

    name: str
    recognise: Callable[[Text], bool]
    start: Callable[[Setup], State]
    run: Callable[[Text, Setup, State, Stops], Pass]
    names: Callable[[Text, str, Setup], bool]


def _dialect(name: str, module: object) -> Dialect:
    return Dialect(name, *(getattr(module, part) for part in ("recognise", "start", "run", "names")))


DIALECTS: Final[Mapping[str, Dialect]] = {
    name: _dialect(name, module) for name, module in (("rs274", rs274), ("fanuc", fanuc), ("aptcl", aptcl))
}


def chosen(name: str, source: Text) -> Dialect:
    """The dialect of that name; for "auto" the one that the text's beginning shows, else RS274/NGC."""
    if name != AUTO:
        return DIALECTS[name]
    return next((dialect for dialect in DIALECTS.values() if dialect.recognise(source)), DIALECTS["rs274"])
