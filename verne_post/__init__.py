"""Post-processor for the VERNE, a five-axis hybrid machine tool: G-code in, slider setpoints out.

Public names are imported on first use, so that ``import verne_post`` stays cheap.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from verne_post.app.convert import convert_program as convert
    from verne_post.app.result import Result
    from verne_post.config import load_machine
    from verne_post.model.findings import Finding, InputError
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options

__all__ = ["Finding", "InputError", "Machine", "Options", "Result", "__version__", "convert", "gcode", "load_machine"]
__version__ = "0.1.0"

_HOME = {
    "load_machine": "verne_post.config",
    "Finding": "verne_post.model.findings",
    "InputError": "verne_post.model.findings",
    "Machine": "verne_post.model.machine",
    "Options": "verne_post.model.options",
    "Result": "verne_post.pipeline",
    "convert": "verne_post.pipeline",
}


def __getattr__(name: str) -> Any:
    if name == "gcode":
        return import_module("verne_post.gcode")
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'verne_post' has no attribute {name!r}")
