"""What tests of several folders build alike: machines, programs, tool axes, setpoints, and the rod equations of the
paper.
"""

import importlib.util
import math
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

import verne_post
from verne_post.app.assemble import Program, assemble
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset

ROOT = Path(__file__).resolve().parents[1]
SAMPLES = ROOT / "gcode_samples"
#: Those that convert; their headers say with which options.
LEGAL_SAMPLES = [
    "blade_5axis.nc",
    "fanuc_nurbs.nc",
    "fanuc_tilted.nc",
    "inch.nc",
    "inverse_time.nc",
    "pocket_3axis.nc",
    "posted.nc",
    "slider_bound.nc",
    "splines.nc",
    "wing.cls",
]
#: The part of two_faces.nc in other languages, to the same setpoints (tests/gcode/test_dialects.py); and curves of
#: fanuc_nurbs.nc in another dialect.
SAME_PATHS = {"two_faces.cls", "two_faces.h", "two_faces.mpf", "two_faces_fanuc.nc", "splines.nc"}
#: Header of the CSV of the default machine.
HEADER = "t_s,rho1_mm,rho2_mm,rho3_mm,a_deg,c_deg,line"
MACHINE = verne_post.load_machine()
#: The part 50 mm above the table, and a tool of 80 mm under it.
OPTIONS = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 50.0))})
#: The identified lengths (docs/theory.md), written out so that a wrong machine file is noticed too.
LENGTHS = {
    "leg1_x_offset": -320.0,
    "R1": 130.0,
    "r1": 80.0,
    "L1": 850.0,
    "leg23_x_offset": 240.0,
    "R2": 190.0,
    "r4": 565.0,
    "L2": 950.0,
    "L3": 950.0,
}


#: How a cell of docs/siemens.md says which values are refused -> what is added to its number for one of them.
_REFUSED = {"": 0, "other than": 1, "above": 1, "from": 0, "with last digit": 10, "with last digit above": 11}


def read_values(cell: str) -> list[tuple[str, int]]:
    """Names in a cell, each with a value that the words behind say: "`A` `B`, each above 3", 4; none, 0."""
    pattern = r"((?:`\w+` ?)+)(?:,? ?(?:each )?([a-z ]*?) ?(\d+))?"
    return [
        (name, int(number) + _REFUSED[how] if number else 0)
        for names, how, number in re.findall(pattern, cell)
        for name in re.findall(r"\w+", names)
    ]


def check_unplanned(program: Any, machine: Any, options: Options) -> verne_post.Result:
    """What :func:`verne_post.check` finds before it plans: all about a text, its set-up, limits and obstacles."""
    result = verne_post.check(program, machine, options, limits_only=True)
    return replace(result, findings=tuple(item for item in result.findings if item.code != "VP421"))


def load_maker(name: str) -> ModuleType:
    """A script beside the pages; docs are no package."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where its dataclasses are looked up
    spec.loader.exec_module(module)
    return module


def two_machines(cycle: float) -> dict[str, Machine]:
    """A parallel and a serial machine with a cycle that keeps files short."""
    return {name: replace(verne_post.load_machine(name), cycle=cycle) for name in ("verne", "serial")}


def with_ranges(
    machine: Machine, a: tuple[float, float] | None = None, c: tuple[float, float] | None = None
) -> Machine:
    """The machine with other ranges of A and C, degrees."""
    lower, upper = machine.limits.lower.copy(), machine.limits.upper.copy()
    for joint, pair in ((3, a), (4, c)):
        if pair is not None:
            lower[joint], upper[joint] = np.radians(pair)
    return replace(machine, limits=replace(machine.limits, lower=lower, upper=upper))


def source(body: str, head: str = "G21 G90 G94 G17") -> bytes:
    """A program; line 1 is the head, the body begins on line 2."""
    return f"{head}\n{body}\nM2\n".encode()


def program(body: str, machine: Machine = MACHINE, head: str = "G21 G90 G94 G17 F3000", **options: Any) -> Program:
    """A program as it is assembled."""
    return assemble(source(body, head), machine, Options(**options))


def setpoints_of(text: bytes, machine: Machine = MACHINE, options: Options = OPTIONS) -> Any:
    """The setpoints of a program that is legal."""
    result = verne_post.convert(text, machine, options)
    assert result.ok, [item.message for item in result.findings]
    return result.setpoints


def axis_of(a: Any, c: Any) -> np.ndarray:
    """The tool axis (..., 3) of nominal angles (rad), written out."""
    a, c = np.asarray(a), np.asarray(c)
    return np.stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)], axis=-1)


def axis_words(tilt: float, turn: float) -> str:
    """Words of the tool axis of a pair of angles, degrees."""
    i, j, k = axis_of(math.radians(tilt), math.radians(turn))
    return f"I{i:.13f} J{j:.13f} K{k:.13f}"


def rods(position: Any, alpha: Any, rho: Any, g: dict[str, float] = LENGTHS) -> np.ndarray:
    """Equations (3), (4), (5), (6) as printed; position (..., 3), alpha (...), rho (..., 3) -> (..., 4) mm2."""
    x, y, z = np.moveaxis(np.asarray(position, dtype=float), -1, 0)
    rho1, rho2, rho3 = np.moveaxis(np.asarray(rho, dtype=float), -1, 0)
    ca, sa = np.cos(alpha), np.sin(alpha)
    d1, d2 = g["leg1_x_offset"], g["leg23_x_offset"]
    eq3 = (x + d1) ** 2 + (y + g["R1"] * ca - g["r1"]) ** 2 + (z + g["R1"] * sa - rho1) ** 2 - g["L1"] ** 2
    eq4 = (x + d1) ** 2 + (y - g["R1"] * ca + g["r1"]) ** 2 + (z - g["R1"] * sa - rho1) ** 2 - g["L1"] ** 2
    eq5 = (x + d2) ** 2 + (y - g["R2"] * ca + g["r4"]) ** 2 + (z - g["R2"] * sa - rho2) ** 2 - g["L2"] ** 2
    eq6 = (x + d2) ** 2 + (y + g["R2"] * ca - g["r4"]) ** 2 + (z + g["R2"] * sa - rho3) ** 2 - g["L3"] ** 2
    return np.stack([eq3, eq4, eq5, eq6], axis=-1)


def orientations(x: float, y: float, g: dict[str, float] = LENGTHS) -> list[float]:
    """All real alpha of the cubic (9) in cos(alpha), both signs, for one x, y."""
    R1, r1, L1 = g["R1"], g["r1"], g["L1"]
    x1 = x + g["leg1_x_offset"]
    p1, p3 = 2 * R1**3 * r1, -2 * R1**3 * r1 - 2 * R1 * r1 * y**2
    p2 = R1**2 * (L1**2 - R1**2 - r1**2) - R1**2 * x1**2
    p4 = R1**2 * x1**2 + (R1**2 + r1**2) * y**2 - R1**2 * (L1**2 - R1**2 - r1**2)
    roots = np.roots([p1, p2, p3, p4])
    cosines = [root.real for root in roots if abs(root.imag) < 1e-9 and abs(root.real) <= 1 + 1e-12]
    return sorted({sign * float(np.arccos(np.clip(c, -1, 1))) for c in cosines for sign in (1.0, -1.0)})
