"""Post-processor for the VERNE, a five-axis hybrid machine tool: G-code in, slider setpoints out.

Public names are imported on first use, so that ``import verne_post`` stays cheap. docs/api.md describes them.
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from verne_post import gcode
    from verne_post.api import check, convert, explain, fit, machined, verify
    from verne_post.app.explain import Explanation
    from verne_post.app.result import Result, Setpoints
    from verne_post.config import load_machine
    from verne_post.model.findings import Finding, InputError, UsageError
    from verne_post.model.machine import Machine
    from verne_post.model.option_checks import work_offsets
    from verne_post.model.options import Options
    from verne_post.model.part_setup import Box, Cylinder, FixtureMesh, NominalPart, OwnStock, Tool, Wanted, WorkOffset
    from verne_post.model.summary import Summary
    from verne_post.model.verdict import Verdict
    from verne_post.model.verification import Verification
    from verne_post.part.verdict import Machined

__version__ = "0.1.0"

#: Public name -> module that defines it.
_HOME = {
    "Box": "verne_post.model.part_setup",
    "Cylinder": "verne_post.model.part_setup",
    "Explanation": "verne_post.app.explain",
    "Finding": "verne_post.model.findings",
    "FixtureMesh": "verne_post.model.part_setup",
    "OwnStock": "verne_post.model.part_setup",
    "InputError": "verne_post.model.findings",
    "Machine": "verne_post.model.machine",
    "Machined": "verne_post.part.verdict",
    "NominalPart": "verne_post.model.part_setup",
    "Options": "verne_post.model.options",
    "Result": "verne_post.app.result",
    "Setpoints": "verne_post.app.result",
    "Summary": "verne_post.model.summary",
    "Tool": "verne_post.model.part_setup",
    "UsageError": "verne_post.model.findings",
    "Verdict": "verne_post.model.verdict",
    "Verification": "verne_post.model.verification",
    "Wanted": "verne_post.model.part_setup",
    "WorkOffset": "verne_post.model.part_setup",
    "check": "verne_post.api",
    "convert": "verne_post.api",
    "explain": "verne_post.api",
    "fit": "verne_post.api",
    "load_machine": "verne_post.config",
    "machined": "verne_post.api",
    "verify": "verne_post.api",
    "work_offsets": "verne_post.model.option_checks",
}

__all__ = [
    "Box",
    "Cylinder",
    "Explanation",
    "Finding",
    "FixtureMesh",
    "InputError",
    "Machine",
    "Machined",
    "NominalPart",
    "Options",
    "OwnStock",
    "Result",
    "Setpoints",
    "Summary",
    "Tool",
    "UsageError",
    "Verdict",
    "Verification",
    "Wanted",
    "WorkOffset",
    "__version__",
    "check",
    "convert",
    "explain",
    "fit",
    "gcode",
    "load_machine",
    "machined",
    "verify",
    "work_offsets",
]


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> object:
    if name == "gcode":
        return _importlib.import_module("verne_post.gcode")
    if name in _HOME:
        return getattr(_importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module 'verne_post' has no attribute {name!r}")
