"""APT cutter location text (CLDATA as CAM systems write it): GOTO with tool axis, RAPID, FEDRAT, CIRCLE, CYCLE.

Each statement becomes blocks of the interpreter: the same modes, checks and moves as in any other program.
docs/apt.md lists the statements.
"""

import re
from itertools import islice
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.initial_state import make_initial_state
from verne_post.gcode.machining.state import State
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import AptKeys, read_keys

_HEADER: Final = re.compile(
    rb"\s*(?:\$\$[^\n]*\n\s*)*(?:PARTNO|MACHIN\s*/|UNITS?\s*/|MULTAX|FROM\s*/|LOADTL\s*/|TOOL[ \t]+PATH\s*/|TLDATA\s*/"
    rb"|MSYS\s*/|PPRINT)",
    re.IGNORECASE,
)
#: Lines of no other language: two show a text whose first statement is misspelt.
_OWN: Final = re.compile(
    rb"^[ \t]*(?:GOTO|FEDRAT|LOADTL|SPINDL|CUTTER|COOLNT|RAPID|INDIRV|FROM)[ \t]*/", re.IGNORECASE | re.MULTILINE
)

_INCH: Final = (r"^[ \t]*UNITS?[ \t]*/[ \t]*(INCH(?:ES)?)\b", "MM")


def _recognise(source: Text) -> bool:
    """A statement with which only CLDATA begins, or lines that only it has."""
    head = source[: 1 << 16]
    return _HEADER.match(head) is not None or len(list(islice(_OWN.finditer(head), 2))) > 1


def _make_initial_state(setup: Setup) -> State:
    """Tool vectors, absolute, mm, or as the set-up says."""
    state = make_initial_state(setup, tool_axis=(0.0, 0.0, 1.0))
    state.modes.vectors = True
    state.modes.inch = read_keys(AptKeys, setup.control.get("aptcl", {})).units == "inch"
    return state


def _execute(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    from verne_post.gcode.apt.run import (
        execute_text,
    )  # most programs speak another language, and every run loads all dialects

    return execute_text(source, setup, state, stop)


def _names_axis(_source: Text, letter: str, _setup: Setup) -> bool:
    """GOTO names every axis: its tool axis those that turn."""
    return letter in "XYZAC"


DIALECT: Final[Dialect] = Dialect(
    _recognise,
    _make_initial_state,
    _execute,
    _names_axis,
    (".cls", ".clsf", ".apt", ".aptsource", ".ncl", ".cl"),
    inch=_INCH,
)
