"""For machine monitoring: an MTConnect 2.0 device, with axes, kinematics and limits, as an agent serves it to a probe.

Coordinate system ``machine``: directions of the part frame (over the tilting rotary table the upright frame) with all
rotary joints at 0, origin at machine zero. So its numbers are those of G53. Rods, struts and platform are components
too. The geometry is the nominal one.
"""

import re
from typing import Any, Final, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np

from verne_post.base.arrays import Array
from verne_post.kinematics.chain.carried import CarriedMachine
from verne_post.kinematics.chain.coordinates import ChainCoordinates
from verne_post.kinematics.chain.hexapod import HexapodMachine
from verne_post.kinematics.chain.machine import ChainMachine
from verne_post.kinematics.chain.sliding import SlidingMachine
from verne_post.model.machine import Machine
from verne_post.model.protocols import Drawable
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
        root,
        "Header",
        creationTime=_TIME,
        deviceModelChangeTime=_TIME,
        sender="verne-post",
        instanceId="1",
        version=VERSION,
        bufferSize="131072",
        assetBufferSize="1024",
        assetCount="0",
    )
    device = ET.SubElement(ET.SubElement(root, "Devices"), "Device", id="device", name=name, uuid=machine.sha256)
    assumed = ", ".join(machine.assumed) or "nothing"
    _describe(
        device, f"{machine.name}, {machine.describe_kind()}; places are nominal; assumed, not measured: {assumed}"
    )
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
    links, platform = _list_links(machine)
    if links:
        _add_structures(parts, links, platform)
    ET.indent(root)
    return {"device.xml": ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"}


class _Motion(NamedTuple):
    """How a joint moves: direction and a point (3,) in machine coordinates, the joint before it, and what moves."""

    direction: Array
    origin: Array | None
    parent: str | None
    text: str = ""


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
        texts = [motion.text] if motion.text else []
        if column.driven and np.isfinite(limits.jerk[k]):
            jerk = f"{scale * limits.jerk[k]:.12g} {column.unit}/s3"
            texts.append(f"jerk limit {jerk}, for which MTConnect has no type of data")
        if texts:
            _describe(one, "; ".join(texts))
        settings = ET.SubElement(one, "Configuration")
        bounded = bool(np.isfinite([low, high]).all())
        kind = "PRISMATIC" if tag == "Linear" else ("REVOLUTE" if bounded else "CONTINUOUS")
        moves = ET.SubElement(
            settings,
            "Motion",
            id=f"{column.joint}-motion",
            type=kind,
            actuation="DIRECT" if column.driven else "VIRTUAL",
            coordinateSystemIdRef=_SYSTEM,
        )
        if motion.parent is not None:
            moves.set("parentIdRef", f"{motion.parent}-motion")
        if motion.origin is not None:
            ET.SubElement(moves, "Origin").text = _show(motion.origin)
        ET.SubElement(moves, "Axis").text = _show(motion.direction)
        if column.driven:
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


def _add_structures(parts: ET.Element, links: list["_Link"], platform: str) -> None:
    """The platform, and one link a rod or strut with its length."""
    group = ET.SubElement(ET.SubElement(parts, "Structures", id="structures"), "Components")
    body = ET.SubElement(group, "Structure", id="platform", name="platform")
    _describe(body, platform)
    for k, link in enumerate(links, start=1):
        one = ET.SubElement(group, "Link", id=f"rod-{k}", name=f"rod-{k}")
        _describe(one, link.text)
        if link.ends:
            specified = ET.SubElement(ET.SubElement(one, "Configuration"), "Specifications")
            _add_specification(specified, f"rod-{k}-length", "LENGTH", "MILLIMETER", link.ends)


def _find_motions(machine: Machine) -> list[_Motion]:
    """The motion of every joint, positive as in the machine file.

    Where sliders are to the side enters no equation, so machine files need not say it: they have no point.
    """
    if machine.module is None:
        return _find_chain_motions(machine)
    table: Any = machine.coordinates
    found: list[_Motion] = []
    for k in range(3):
        if isinstance(machine.module, Drawable):
            [rods] = [one for one in _find_rods(machine) if one.slider == k][:1]
            direction = rods.along
        else:
            place, moved = (
                machine.module.forward(_find_middle(machine) + one)[0] for one in (np.zeros(3), np.eye(3)[k])
            )
            direction = moved - place
        found.append(_Motion(direction * _MIRROR, None, None))
    a, c = machine.columns[3], machine.columns[4]
    origin = -(table.rotary_offset + table.machine_zero)
    found.append(_Motion(np.array([np.sign(a.factor), 0.0, 0.0]), origin, None))
    found.append(_Motion(np.array([0.0, 0.0, np.sign(c.factor)]), -table.machine_zero, a.joint))
    return found


# --- machines of schema 2 ------------------------------------------------------------------------------------------


def _find_chain_motions(machine: Machine) -> list[_Motion]:
    """Of a chain, with or without a carrier: linear axes move the tool against the part, whichever of both goes."""
    whole, coordinates = machine.five_axis, machine.coordinates
    assert isinstance(coordinates, ChainCoordinates)
    chain, frame = coordinates.machine, coordinates.part_frame
    text = "moves the tool against the part"
    feet: Array | None = None
    if isinstance(whole, ChainMachine):
        directions = chain.linear.T @ frame
    else:
        assert isinstance(whole, SlidingMachine | CarriedMachine | HexapodMachine)
        to_part = whole.to_polar.T @ frame
        directions, feet, text = _find_actuators(whole)
        directions = directions @ to_part
        if feet is not None:
            feet = (feet - whole.part_zero) @ to_part - coordinates.machine_zero
    found = [_Motion(one, None if feet is None else feet[k], None, text) for k, one in enumerate(directions)]
    tilt, turn = machine.columns[-2:]
    for k, (column, joint, other) in enumerate(((tilt, chain.tilt, chain.turn), (turn, chain.turn, chain.tilt))):
        carry = chain.turn_tool if joint.on_tool else chain.turn_part
        quarter = 0.5 * np.pi * np.eye(2)[k]
        x, y, z = (carry(unit, quarter) - carry(np.zeros(3), quarter) for unit in np.eye(3))
        axis = 0.5 * np.array([y[2] - z[1], z[0] - x[2], x[1] - y[0]])  # of a rotation by a right angle
        # on the tool's side the turning joint stands before the tilting one, on the part's side after it
        carried = joint.on_tool == other.on_tool and (column is tilt) == joint.on_tool
        parent = None if not carried else (turn if column is tilt else tilt).joint
        what = "turns the tool" if joint.on_tool else "turns the part"
        if not column.driven:
            what = "where the tool points, by the actuators together; nothing drives it"
        place = joint.through @ frame - coordinates.machine_zero
        found.append(_Motion(np.sign(column.factor) * axis @ frame, place, parent, what))
    return found


def _find_actuators(whole: SlidingMachine | CarriedMachine | HexapodMachine) -> tuple[Array, Array | None, str]:
    """Directions (k, 3) of sliders, or of struts at home and where these stand, base frame; and what they are."""
    if isinstance(whole, SlidingMachine):
        return whole.module.rails[whole.module.first_rods], None, "slider on a rail"
    home = np.array(whole.home[: len(whole.actuators)])
    if isinstance(whole, HexapodMachine):
        if whole.legs.rails is not None:
            return whole.legs.unit_rails, None, "slider on a rail"
        feet, ends = whole.legs.find_legs(np.array(whole.legs.home, dtype=float), np.eye(3), home)
    else:
        feet, ends = whole.leg.find_rods(np.array(whole.leg.home, dtype=float))
    text = "strut, whose length this is; direction at home, origin at its joint on the base"
    return (ends - feet) / home[:, None], feet, text


class _Link(NamedTuple):
    """What a rod or strut is, and its length: Nominal, or Minimum and Maximum."""

    text: str
    ends: dict[str, float]


def _list_links(machine: Machine) -> tuple[list[_Link], str]:
    """The rods and struts of a carrier, and what its platform does; none of a chain without one."""
    whole = machine.five_axis
    rod, strut = "from slider {} to the platform, ball joints at both ends", "strut from the base to the platform"
    if isinstance(machine.module, Drawable):
        rods = [
            (one.length, f"rod, or pair of equal ones, {rod.format(machine.columns[one.slider].joint)}")
            for one in _find_rods(machine)
        ]
        return [_Link(text, {"Nominal": length}) for length, text in rods], (
            "carries the spindle; a tilt of it follows from its place and is not actuated"
        )
    if isinstance(whole, SlidingMachine):
        links = [_Link(f"rod {rod.format(one.by)}", {"Nominal": one.length}) for one in whole.module.rod]
        return links, "carries the spindle, and never turns"
    if isinstance(whole, HexapodMachine) and whole.legs.rods is not None:
        pairs = zip(whole.actuators, whole.legs.rods, strict=True)
        links = [_Link(f"rod {rod.format(name)}", {"Nominal": length}) for name, length in pairs]
        return links, "carries the spindle; the actuators place and turn it"
    if isinstance(whole, HexapodMachine | CarriedMachine):
        limits = zip(whole.actuators, machine.limits.lower, machine.limits.upper, strict=False)
        links = [
            _Link(f"{strut}, ball joints at both ends; {name} is its length", {"Minimum": low, "Maximum": high})
            for name, low, high in limits
        ]
        if isinstance(whole, HexapodMachine):
            return links, "carries the spindle; the actuators place and turn it"
        passive = _Link("central leg: a universal joint on the base and a slide, which nothing drives", {})
        return [*links, passive], "carries the wrist; it turns with the central leg, as its place says"
    return [], ""


# --- machines over the tilting rotary table ------------------------------------------------------------------------


class _Rod(NamedTuple):
    """One rod of a sketch: its length, the slider that carries it, and where that goes, base frame."""

    length: float
    slider: int
    along: Array


def _find_rods(machine: Machine) -> list[_Rod]:
    """The rods: with the platform held, each moves at one end with its slider."""
    module, middle = machine.module, _find_middle(machine)
    assert module is not None
    assert isinstance(module, Drawable)
    position, alpha, _ok = module.forward(middle)
    rho = np.concatenate([middle[None], middle + np.eye(3)])
    drawn = np.asarray(module.sketch(np.tile(position, (4, 1)), np.tile(alpha, 4), rho))
    moved = drawn[1:, :, 0] - drawn[0, :, 0]  # slider by rod by component
    sliders = np.abs(moved).max(axis=-1).argmax(axis=0).tolist()
    lengths = np.linalg.norm(drawn[0, :, 1] - drawn[0, :, 0], axis=-1)
    return [_Rod(float(lengths[k]), slider, moved[slider, k]) for k, slider in enumerate(sliders)]


def _find_middle(machine: Machine) -> Array:
    """The sliders in the middle of their travel."""
    middle = 0.5 * (machine.limits.lower[:3] + machine.limits.upper[:3])
    assert machine.module is not None
    if not machine.module.forward(middle)[2]:
        raise CannotExport("the platform cannot be in the middle of travel, where its parts are described")
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
