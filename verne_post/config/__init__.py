"""Files as the program needs them: machines, settings, set-ups, tools, offsets, subprograms.

Every error names file, key, value and bound.

Its names are imported on first use: whether a machine file exists is known without what reads it.
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from verne_post.config.load import load_machine, validate_machine
    from verne_post.config.machine_paths import list_machine_files

_HOME = {
    "load_machine": "verne_post.config.load",
    "list_machine_files": "verne_post.config.machine_paths",
    "validate_machine": "verne_post.config.load",
}

__all__ = ["list_machine_files", "load_machine", "validate_machine"]


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(_importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module 'verne_post.config' has no attribute {name!r}")
