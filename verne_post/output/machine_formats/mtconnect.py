"""For machine monitoring: an MTConnect 2.0 device, with axes, kinematics and limits, as an agent serves it to a probe.

Coordinate system ``machine``: axes of the upright frame, origin at machine zero with the table at A = C = 0. So its
numbers are those of G53. Rods and platform are components too. The geometry is the nominal one.
"""

import re
from typing import Any, Final, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.machine import Machine
from verne_post.model.protocols import Drawable, ParallelModule
from verne_post.output.file_format import CannotExport, MachineFormat

VERSION: Final = "2.0"
_SPACE: Final = f"urn:mtconnect.org:MTConnectDevices:{VERSION}"
#: In place of the time of writing, which the agent puts in: the same machine file gives the same bytes.
_TIME: Final = "1970-01-01T00:00:00Z"
_SYSTEM: Final = "machine"
#: F: the base frame against the upright frame.
_MIRROR: Final = np.array([1.0, -1.0, -1.0])
#: What an MTConnect axis is called that slides or turns, and the unit of its place.
_KINDS: Final = {"mm": ("Linear", "POSITION", "MILLIMETER", ""), "deg": ("Rotary", "ANGLE", "DEGREE", "ANGULAR_")}
#: What the control says besides the axes: category, type, units.
_OF_PATH: Final = (
    ("SAMPLE", "PATH_POSITION", "MILLIMETER_3D"),
    ("SAMPLE", "PATH_FEEDRATE", "MILLIMETER/SECOND"),
    ("EVENT", "PROGRAM", None),
    ("EVENT", "LINE_NUMBER", None),
    ("EVENT", "EXECUTION", None),
)


def write_device(machine: Machine) -> dict[str, str]:
    """The device as one XML file.

    Raises
    ------
    CannotExport
        The platform cannot stand in the middle of travel, where the parts are described.
    """
    name = re.sub(r"[^A-Za-z0-9_.-]+", "-", machine.name) or machine.kind
    root = ET.Element("MTConnectDevices", {"xmlns": _SPACE})
    ET.SubElement(
        root, "Header", creationTime=_TIME, deviceModelChangeTime=_TIME, sender="verne-post", instanceId="1", version=VERSION,
        bufferSize="131072", assetBufferSize="1024", assetCount="0",
    )  # fmt: skip
    device = ET.SubElement(ET.SubElement(root, "Devices"), "Device", id="device", name=name, uuid=machine.sha256)
    assumed = ", ".join(machine.assumed) or "nothing"
    _describe(device, f"{machine.name}, kind {machine.kind}; places are nominal; assumed, not measured: {assumed}")
    systems = ET.SubElement(ET.SubElement(device, "Configuration"), "CoordinateSystems")
    origin = ET.SubElement(systems, "CoordinateSystem", id=_SYSTEM, name="machine-zero", type="MACHINE")
    ET.SubElement(origin, "Origin").text = "0 0 0"
    items = ET.SubElement(device, "DataItems")
    _add_item(items, "EVENT", "AVAILABILITY", "device")
    parts = ET.SubElement(device, "Components")
    _add_axes(machine, ET.SubElement(parts, "Axes", id="axes"))
    controller = ET.SubElement(ET.SubElement(parts, "Controller", id="controller"), "Components")
    of_path = ET.SubElement(ET.SubElement(controller, "Path", id="path"), "DataItems")
    for category, kind, units in _OF_PATH:
        _add_item(of_path, category, kind, "path", units)
    if isinstance(machine.module, Drawable):
        _add_rods(machine, ET.SubElement(parts, "Structures", id="structures"))
    ET.indent(root)
    return {"device.xml": ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"}


def _add_axes(machine: Machine, axes: ET.Element) -> None:
    """One component a joint: motion, limits, where it stands."""
    group = ET.SubElement(axes, "Components")
    for k, (column, motion) in enumerate(zip(machine.columns, _find_motions(machine), strict=True)):
        tag, place, unit, prefix = _KINDS[column.unit]
        scale, limits = abs(column.factor), machine.limits
        low, high = sorted((limits.lower[k] * column.factor, limits.upper[k] * column.factor))
        one = ET.SubElement(
            group, tag, id=column.joint, name=column.joint.upper() if len(column.joint) == 1 else column.joint
        )
        if np.isfinite(limits.jerk[k]):
            _describe(
                one,
                f"jerk limit {scale * limits.jerk[k]:.12g} {column.unit}/s3, for which MTConnect has no type of data",
            )
        settings = ET.SubElement(one, "Configuration")
        direction, origin, parent = motion
        bounded = bool(np.isfinite([low, high]).all())
        kind = "PRISMATIC" if tag == "Linear" else ("REVOLUTE" if bounded else "CONTINUOUS")
        moves = ET.SubElement(
            settings,
            "Motion",
            id=f"{column.joint}-motion",
            type=kind,
            actuation="DIRECT",
            coordinateSystemIdRef=_SYSTEM,
        )
        if parent is not None:
            moves.set("parentIdRef", f"{parent}-motion")
        if origin is not None:
            ET.SubElement(moves, "Origin").text = _show(origin)
        ET.SubElement(moves, "Axis").text = _show(direction)
        specified = ET.SubElement(settings, "Specifications")
        bounds: dict[str, tuple[str, dict[str, float]]] = {
            f"{prefix}VELOCITY": (f"{unit}/SECOND", {"Maximum": scale * limits.velocity[k]}),
            f"{prefix}ACCELERATION": (f"{unit}/SECOND^2", {"Maximum": scale * limits.acceleration[k]}),
        }
        if bounded:
            bounds[place] = (unit, {"Minimum": low, "Maximum": high})
        for what, (units, ends) in bounds.items():
            _add_specification(specified, f"{column.joint}-{what.lower()}-limit", what, units, ends)
        _add_item(ET.SubElement(one, "DataItems"), "SAMPLE", place, column.joint, unit)


def _add_rods(machine: Machine, structures: ET.Element) -> None:
    """The platform, and one link a rod with its length and the slider that carries it."""
    group = ET.SubElement(structures, "Components")
    body = ET.SubElement(group, "Structure", id="platform", name="platform")
    _describe(body, "carries the spindle; a tilt of it follows from its place and is not actuated")
    for k, one in enumerate(_find_rods(machine), start=1):
        rod = ET.SubElement(group, "Link", id=f"rod-{k}", name=f"rod-{k}")
        _describe(
            rod,
            f"rod, or pair of equal ones, from slider {machine.columns[one.slider].joint} to the platform, "
            "ball joints at both ends",
        )
        specified = ET.SubElement(ET.SubElement(rod, "Configuration"), "Specifications")
        _add_specification(specified, f"rod-{k}-length", "LENGTH", "MILLIMETER", {"Nominal": one.length})


def _find_motions(machine: Machine) -> list[tuple[Array, Array | None, str | None]]:
    """Direction, a point and the joint before, of every joint: machine coordinates, positive as in the machine file.

    Where sliders are to the side enters no equation, so machine files need not say it: they have no point.
    """
    table: Any = machine.coordinates
    found: list[tuple[Array, Array | None, str | None]] = []
    for k in range(3):
        if isinstance(machine.module, Drawable):
            [rods] = [one for one in _find_rods(machine) if one.slider == k][:1]
            direction = rods.along
        else:
            place, moved = (
                _find_module(machine).forward(_find_middle(machine) + one)[0] for one in (np.zeros(3), np.eye(3)[k])
            )
            direction = moved - place
        found.append((direction * _MIRROR, None, None))
    a, c = machine.columns[3], machine.columns[4]
    found.append((np.array([np.sign(a.factor), 0.0, 0.0]), -(table.rotary_offset + table.machine_zero), None))
    found.append((np.array([0.0, 0.0, np.sign(c.factor)]), -table.machine_zero, a.joint))
    return found


class _Rod(NamedTuple):
    """One rod of a sketch: its length, the slider that carries it, and where that goes, base frame."""

    length: float
    slider: int
    along: Array


def _find_rods(machine: Machine) -> list[_Rod]:
    """The rods: with the platform held, each moves at one end with its slider."""
    module, middle = machine.module, _find_middle(machine)
    assert isinstance(module, Drawable)
    position, alpha, _ok = _find_module(machine).forward(middle)
    rho = np.concatenate([middle[None], middle + np.eye(3)])
    drawn = np.asarray(module.sketch(np.tile(position, (4, 1)), np.tile(alpha, 4), rho))
    moved = drawn[1:, :, 0] - drawn[0, :, 0]  # slider by rod by component
    sliders = np.abs(moved).max(axis=-1).argmax(axis=0).tolist()
    lengths = np.linalg.norm(drawn[0, :, 1] - drawn[0, :, 0], axis=-1)
    return [_Rod(float(lengths[k]), slider, moved[slider, k]) for k, slider in enumerate(sliders)]


def _find_module(machine: Machine) -> ParallelModule:
    if machine.module is None:
        raise CannotExport(f"kind = {machine.kind!r}: machines of one chain are not described for MTConnect")
    return machine.module


def _find_middle(machine: Machine) -> Array:
    """The sliders in the middle of their travel."""
    middle = 0.5 * (machine.limits.lower[:3] + machine.limits.upper[:3])
    if not _find_module(machine).forward(middle)[2]:
        raise CannotExport("the platform cannot stand in the middle of travel, where its parts are described")
    return np.asarray(middle)


def _show(vector: Array) -> str:
    return " ".join(f"{round(float(one), 9) + 0.0:.12g}" for one in vector)


def _describe(parent: ET.Element, text: str) -> None:
    ET.SubElement(parent, "Description").text = text


def _add_specification(parent: ET.Element, name: str, kind: str, units: str, ends: dict[str, float]) -> None:
    one = ET.SubElement(parent, "Specification", id=name, type=kind, units=units)
    for key, value in ends.items():
        ET.SubElement(one, key).text = f"{value:.12g}"


def _add_item(parent: ET.Element, category: str, kind: str, owner: str, units: str | None = None) -> None:
    one = ET.SubElement(parent, "DataItem", id=f"{owner}-{kind.lower()}", category=category, type=kind)
    if units is not None:
        one.set("units", units)
    if kind in ("POSITION", "ANGLE", "PATH_POSITION"):
        one.set("subType", "ACTUAL")
        one.set("coordinateSystem", "MACHINE")


FORMAT: Final = MachineFormat(write_device, lambda _machine: "give device.xml to the agent")
