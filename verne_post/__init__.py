"""Post-processor for the VERNE, a five-axis hybrid machine tool: G-code in, slider setpoints out.

    convert         a program to verified setpoints           Result, with .setpoints
    check           a program against every limit             Result
    explain         one line: pose, limits, what would help   Explanation
    verify          setpoints as written, against a program   Verification
    machined        setpoints against the nominal part        Machined
    fit             where the part may be clamped             Proposal
    batch           many programs, each with its set-up       Batch
    make_report     one page that shows a program             Page
    read_moves      the moves of a program, as it is read     ProgramMoves
    load_machine    a machine by name or file                 Machine
    list_machines   the names of the machines it comes with   tuple of str
    Options         tools, work offsets, tolerances, ...
    read_settings   the file verne-post.toml                  Settings
    choose_kernels  rows are those of the commands, to the last digit

>>> import verne_post as vp
>>> setup = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)})
>>> vp.convert("G21 G90 F600\\nG0 X0 Y0 Z20\\nG1 X10\\nM2\\n", "verne", setup).ok
True

Only the names of ``dir(verne_post)`` are public; docs/api.md describes them.
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from verne_post.api import (
        Batch,
        Page,
        ProgramMoves,
        batch,
        check,
        convert,
        explain,
        fit,
        load_machine,
        machined,
        make_report,
        read_moves,
        read_settings,
        verify,
    )
    from verne_post.app.explain import Explanation
    from verne_post.app.result import Result, Setpoints
    from verne_post.cli.arithmetic import choose_kernels
    from verne_post.config.machine_paths import list_machines
    from verne_post.config.settings import Settings
    from verne_post.model.findings import Finding, InputError, UsageError
    from verne_post.model.machine import Machine
    from verne_post.model.option_checks import work_offsets
    from verne_post.model.options import Options
    from verne_post.model.part_setup import Box, Cylinder, FixtureMesh, NominalPart, OwnStock, Tool, Wanted, WorkOffset
    from verne_post.model.setpoints import SetpointBlock
    from verne_post.model.summary import Summary
    from verne_post.model.verdict import Verdict
    from verne_post.model.verification import Verification
    from verne_post.part.verdict import Machined
    from verne_post.toolpath.work_offset import Proposal

__version__ = "0.1.0"

#: Module -> the public names that it defines.
_NAMES = {
    "api": (
        "Batch Page ProgramMoves batch check convert explain fit load_machine machined make_report read_moves "
        "read_settings verify"
    ),
    "app.explain": "Explanation",
    "app.result": "Result Setpoints",
    "cli.arithmetic": "choose_kernels",
    "config.machine_paths": "list_machines",
    "config.settings": "Settings",
    "model.findings": "Finding InputError UsageError",
    "model.machine": "Machine",
    "model.option_checks": "work_offsets",
    "model.options": "Options",
    "model.part_setup": "Box Cylinder FixtureMesh NominalPart OwnStock Tool Wanted WorkOffset",
    "model.setpoints": "SetpointBlock",
    "model.summary": "Summary",
    "model.verdict": "Verdict",
    "model.verification": "Verification",
    "part.verdict": "Machined",
    "toolpath.work_offset": "Proposal",
}
#: Public name -> module that defines it.
_HOME = {name: f"verne_post.{module}" for module, names in _NAMES.items() for name in names.split()}

#: What people look for by a command or by another word -> the call that does it.
_DONE_BY = {
    "compare": "make_report(..., versus=...)",
    "dump": "read_moves",
    "gcode": "read_moves",
    "stream": "convert(..., sink=...)",
    "split": "setpoints.split()",
}

__all__ = [
    "Batch", "Box", "Cylinder", "Explanation", "Finding", "FixtureMesh", "InputError", "Machine", "Machined",
    "NominalPart", "Options", "OwnStock", "Page", "ProgramMoves", "Proposal", "Result", "SetpointBlock", "Setpoints",
    "Settings", "Summary", "Tool", "UsageError", "Verdict", "Verification", "Wanted", "WorkOffset", "__version__",
    "batch", "check", "choose_kernels", "convert", "explain", "fit", "list_machines", "load_machine", "machined",
    "make_report", "read_moves", "read_settings", "verify", "work_offsets",
]  # fmt: skip


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(_importlib.import_module(_HOME[name]), name)
    near = ""
    if not name.startswith("_"):  # Python and notebooks try these by themselves
        from verne_post.base.suggestions import find_meant

        names = [one for one in __all__ if not one.startswith("_")]
        slip = find_meant(name, names, slip_alone=True)
        parts = [one for one in names if name.lower() in one.lower().split("_")]  # report: make_report
        ends = [one for one in names if name.rpartition("_")[2] == one.rpartition("_")[2]]  # load_settings
        meant = _DONE_BY.get(name) or next(filter(None, (*parts, slip, *ends)), "") or find_meant(name, names)
        near = f"; did you mean {meant}?" if meant else ""
    raise AttributeError(f"module 'verne_post' has no attribute {name!r}{near}")
