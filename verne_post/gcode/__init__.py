"""The G-code front end (RS274/NGC): text -> words -> Moves. It knows no machine.

Its names are imported on first use: most mistakes on a command line are found before a program is read.
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from verne_post.gcode.plain_setup import build_plain_setup, interpret_plainly
    from verne_post.gcode.read import interpret_program

_HOME = {
    "interpret_program": "verne_post.gcode.read",
    "build_plain_setup": "verne_post.gcode.plain_setup",
    "interpret_plainly": "verne_post.gcode.plain_setup",
}

__all__ = ["build_plain_setup", "interpret_plainly", "interpret_program"]


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(_importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module 'verne_post.gcode' has no attribute {name!r}")
