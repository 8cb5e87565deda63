"""For LinuxCNC 2.9 and 2.10: the machine as a kinematics component in C, and a simulation of it (INI, HAL, tool table).

The C stands in ``kins/`` as it is compiled; only ``machine.h`` is written here, the numbers of the machine file under
their own names. A new kind of machine needs a header ``kins/KIND.h`` with the functions that ``kins/model.h`` calls;
the whole machine around it is ``kins/ideal.h``, or ``kins/as_built.h`` where the file has [as_built].
"""

import math
from collections.abc import Iterator, Mapping
from importlib.resources import files
from string import Template
from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from verne_post.base.arrays import Array
from verne_post.base.units import RAD_PER_DEG
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.kinematics.chain.machine import ChainMachine
from verne_post.kinematics.chain.pair import PARALLEL
from verne_post.kinematics.five_axis import HybridMachine
from verne_post.model.machine import Machine
from verne_post.output.file_format import CannotExport, MachineFormat

_TEXTS: Final = files("verne_post.output.machine_formats") / "kins"
_AXES: Final = "XYZAC"
#: The world of a simulation is this many radii of the table wide: a frame for the screen, the joints bound the motion.
_WORLD_RADII: Final = 2.0
#: Following error at which the simulation faults, mm and degrees: nothing follows there, so any would do.
_FERROR: Final = 1.0


def write_component(machine: Machine) -> dict[str, str]:
    """Texts of the component and of its simulation.

    Raises
    ------
    CannotExport
        The kind has no C code.
    """
    whole, name = machine.five_axis, name_component(machine)
    ideal = whole.nominal_machine if isinstance(whole, AsBuiltMachine) else whole
    carrier = _TEXTS / f"{machine.kind}.h"
    if not isinstance(ideal, HybridMachine) or not carrier.is_file():
        own = name_own_component(machine)
        text = f"there is no C code for {machine.name} ({machine.describe_kind()}); kinds that have it: {_list_kinds()}"
        raise CannotExport(f"{text}. LinuxCNC's own {own} has these joints: set its pins" if own else text)
    values = {
        "name": _show_name(machine),
        "component": name,
        "axes": "\n\n".join(_describe_axes(machine)),
        "joints": "\n\n".join(_describe_joints(machine, ideal)),
        "velocity": repr(float(machine.limits.velocity[:3].min())),
        "acceleration": repr(float(machine.limits.acceleration[:3].min())),
        "planner": _choose_planner(machine),
        "tip": repr(machine.accuracy.tip),
        "period": round(1e9 * machine.cycle),
        "loops": "\n".join(f"net motor{k} joint.{k}.motor-pos-cmd => joint.{k}.motor-pos-fb" for k in range(5)),
        "sha256": machine.sha256,
    }
    made = {f"machine.{end}": _fill(f"machine.{end}", values) for end in ("ini", "hal")}
    made["README.txt"] = _fill("README.txt", values)
    made["tool.tbl"] = "T1 P1 Z0 ; length of tool 1, mm\n"
    return made | {
        f"{name}.c": _read("kins.c"),
        "machine.h": _write_numbers(machine, ideal),
        "model.h": _read("model.h"),
        "whole.h": _read("as_built.h" if isinstance(whole, AsBuiltMachine) else "ideal.h"),
        "carrier.h": _read(f"{machine.kind}.h"),
    }


def _list_kinds() -> str:
    """The kinds with a carrier in C."""
    shared = {"as_built", "ideal", "model"}
    names = sorted(path.name.removesuffix(".h") for path in _TEXTS.iterdir() if path.name.endswith(".h"))
    return ", ".join(name for name in names if name not in shared)


def name_own_component(machine: Machine) -> str:
    """The component that LinuxCNC has for a trunnion, A or B, which carries a table C; empty for other machines."""
    whole, tilt = machine.five_axis, machine.columns[3].joint
    name = {"a": "xyzac-trt-kins", "b": "xyzbc-trt-kins"}.get(tilt, "")
    if not isinstance(whole, ChainMachine) or not name or whole.tilt.on_tool or whole.turn.on_tool:
        return ""
    pair, about = whole.pair, np.eye(3)["ab".index(tilt)]
    # directions about which positive values turn the tool against the part: both conventional, or both the reverse
    tilts, turns = (
        -math.copysign(1.0, machine.columns[k].factor) * pair.directions[row] for k, row in ((3, 0), (4, 2))
    )
    along = [
        *(pair.directions.T @ whole.linear - np.eye(3)).ravel(),
        *(tilts - turns[2] * about),
        abs(turns[2]) - 1.0,
        pair.home_tilt,
    ]
    is_own = machine.columns[4].joint == "c" and pair.nutation is None and np.allclose(along, 0.0, atol=PARALLEL)
    return name if is_own else ""


def name_component(machine: Machine) -> str:
    """Name of the component: one for a kind, because a control has one machine."""
    return f"{machine.kind}_kins"


def _show_name(machine: Machine) -> str:
    """Name of the machine in one line that ends no comment."""
    return " ".join(machine.name.replace("*/", "* /").split())


def _read(name: str) -> str:
    return (_TEXTS / name).read_text(encoding="utf-8")


def _fill(name: str, values: Mapping[str, object]) -> str:
    return Template(_read(f"{name}.in")).substitute(values)


def _write_numbers(machine: Machine, ideal: HybridMachine) -> str:
    """C definitions of all that the equations need, by the names of the machine file or of ``AsBuiltGeometry``."""
    a, c = (column.factor for column in machine.columns[3:])
    whole = machine.five_axis
    assert isinstance(ideal.module, Struct)  # as every module that has C
    numbers: dict[str, Any] = {
        **asdict(ideal.module),
        **(asdict(whole.geometry) if isinstance(whole, AsBuiltMachine) else {}),
        "pivot": ideal.table.pivot,
        "rotary_offset": ideal.table.rotary_offset,
        "machine_zero": ideal.table.machine_zero,
        "nose_offset": ideal.nose_offset,
        "serial_singularity_mm": machine.limits.serial_singularity,
        "a_factor": a,
        "c_factor": c,
    }
    lines = [
        f"/* The numbers of machine {_show_name(machine)}, sha256 {machine.sha256}; mm.",
        " * a_factor, c_factor: degrees of the machine file, in its sense, for one radian that the workpiece turns. */",
        "#ifndef MACHINE_H",
        "#define MACHINE_H",
        "",
        "#include <math.h>",
        "",
        f'#define KINS_NAME "{name_component(machine)}"',
        "",
    ]
    for name, value in numbers.items():
        values = ", ".join(repr(float(one)) for one in np.ravel(value))
        array = f"[{np.size(value)}]" if np.ndim(value) else ""
        lines.append(f"static const double {name}{array} = {f'{{{values}}}' if array else values};")
    return "\n".join([*lines, "", "#endif", ""])


def _describe_axes(machine: Machine) -> Iterator[str]:
    """Sections of the five axes of the world; X, Y and Z of it are as fast as the slowest actuator of the spindle."""
    limits, (low, high) = machine.limits, _find_travel(machine)
    wide = _WORLD_RADII * machine.table_radius
    for k, letter in enumerate(_AXES):
        group = slice(0, 3) if k < 3 else slice(k, k + 1)
        scale = abs(machine.columns[k].factor)
        lines = [
            f"[AXIS_{letter}]",
            *_bound(min(low[k], -wide) if k < 3 else low[k], max(high[k], wide) if k < 3 else high[k]),
        ]
        lines.append(f"MAX_VELOCITY = {scale * limits.velocity[group].min():.12g}")
        lines.append(f"MAX_ACCELERATION = {scale * limits.acceleration[group].min():.12g}")
        lines += _limit_jerk(scale * limits.jerk[group].min())
        yield "\n".join(lines)


def _choose_planner(machine: Machine) -> str:
    """Lines of [TRAJ]: the planner of LinuxCNC 2.10 that keeps jerk, where every joint has a limit of it."""
    jerk = machine.limits.jerk
    if not np.isfinite(jerk).all():
        return "# without jerk: the machine file does not limit that of every axis\nPLANNER_TYPE = 0"
    return (
        f"# 1: S-curve, in LinuxCNC 2.10; 2.9 reads no jerk\nPLANNER_TYPE = 1\nMAX_LINEAR_JERK = {jerk[:3].min():.12g}"
    )


def _limit_jerk(jerk: float) -> list[str]:
    """The jerk limit of an axis or joint; an unlimited one has none."""
    return [f"MAX_JERK = {jerk:.12g}"] if np.isfinite(jerk) else []


def _describe_joints(machine: Machine, ideal: HybridMachine) -> Iterator[str]:
    """Sections of the five joints: limits of the machine file, home at G28."""
    limits, (low, high), home = machine.limits, _find_travel(machine), _find_home(machine, ideal)
    for k, column in enumerate(machine.columns):
        scale = abs(column.factor)
        yield "\n".join(
            [
                f"# {column.joint}",
                f"[JOINT_{k}]",
                f"TYPE = {'LINEAR' if k < 3 else 'ANGULAR'}",
                *_bound(low[k], high[k]),
                f"MAX_VELOCITY = {scale * limits.velocity[k]:.12g}",
                f"MAX_ACCELERATION = {scale * limits.acceleration[k]:.12g}",
                *_limit_jerk(scale * limits.jerk[k]),
                f"FERROR = {_FERROR}",
                f"MIN_FERROR = {_FERROR}",
                f"HOME = {home[k]:.12g}",
                f"HOME_OFFSET = {home[k]:.12g}",
                "HOME_SEARCH_VEL = 0",
                "HOME_LATCH_VEL = 0",
                "HOME_SEQUENCE = 0",
            ]
        )


def _bound(low: float, high: float) -> list[str]:
    """Travel of an axis or joint; an unlimited one has none."""
    ends = (("MIN_LIMIT", low), ("MAX_LIMIT", high))
    return [f"{key} = {value:.12g}" for key, value in ends if np.isfinite(value)]


def _find_travel(machine: Machine) -> Array:
    """Travel (2, 5) in units and sense of the machine file."""
    factors = np.array([column.factor for column in machine.columns])
    return np.sort(np.stack([machine.limits.lower, machine.limits.upper]) * factors, axis=0)


def _find_home(machine: Machine, ideal: HybridMachine) -> Array:
    """Joints (5,) at G28, or else in the middle of travel, in units and sense of the machine file."""
    factors = np.array([column.factor for column in machine.columns])
    if machine.home is None:
        travel = _find_travel(machine)
        joints = np.where(np.isfinite(travel).all(axis=0), travel.mean(axis=0), 0.0)
        if not machine.five_axis.find_nominal_pose(joints / factors, 0.0)[2]:
            raise CannotExport("[home] is missing, and the platform cannot be in the middle of travel; give [home]")
        return joints
    table, place = ideal.table, np.array(machine.home.g28)
    angles = RAD_PER_DEG * place[3:] * [table.a_sign, table.c_sign]
    tip = table.find_tip_of_gauge(place[:3] + table.rotary_offset + table.machine_zero, angles, 0.0)
    joints = machine.five_axis.find_joints(tip, angles, 0.0)
    if not np.isfinite(joints).all():
        raise CannotExport("[home] g28 is out of reach; verne-post machine validate says more")
    return np.asarray(joints * factors)


FORMAT: Final = MachineFormat(
    write_component, lambda machine: f"sudo halcompile --install {name_component(machine)}.c; linuxcnc machine.ini"
)
