"""Machine files of schema 2: a chain of joints from base to tool and to part. Meaning: docs/machine-file.md."""

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Final, Literal

import numpy as np
from msgspec import Meta, field
from msgspec.structs import asdict

from verne_post.base.arrays import Array
from verne_post.base.printable import escape_unprinted
from verne_post.base.suggestions import suggest
from verne_post.base.units import DEG_PER_RAD, RAD_PER_DEG
from verne_post.config.carrier import CarrierFile, build_carrier_machine, build_leg_clearance
from verne_post.config.common import convert_drives, convert_home, convert_vibration
from verne_post.config.plausibility import find_implausible_in_chain
from verne_post.config.schema import (
    AccuracyFile,
    ControlFile,
    DriveFile,
    HomeFile,
    NotNegative,
    Point,
    Positive,
    Range,
    Source,
    VibrationFile,
    check_range,
    expect_direction,
)
from verne_post.config.sentences import Checks, Table, WrongTableError, check_table
from verne_post.kinematics.chain.coordinates import ChainCoordinates
from verne_post.kinematics.chain.hexapod import HexapodMachine
from verne_post.kinematics.chain.machine import ChainMachine, Rotary
from verne_post.kinematics.chain.pair import PARALLEL, RIGHT_ANGLE, build_pair
from verne_post.kinematics.chain.senses import is_upside_down, name_direction
from verne_post.kinematics.chain.sliding import SlidingMachine
from verne_post.kinematics.checks.bodies import Clearance
from verne_post.kinematics.tables.words import RotaryWords
from verne_post.model.findings import Finding, InputError, make_finding, make_input_error
from verne_post.model.machine import Accuracy, Bodies, Column, Limits, Machine
from verne_post.model.moves import AXES
from verne_post.model.nutation import Nutation
from verne_post.model.protocols import FiveAxis

#: Three directions span no space where the volume of their unit vectors is smaller.
_FLAT: Final = 1e-6
#: Sine of the angle below which up lies along x of the base, so that y takes its place.
_ALONG: Final = 0.1
_LINEAR: Final = ("x", "y", "z")
_ROTARY: Final = ("a", "b", "c")


class ChainFile(Table, frozen=True, kw_only=True):
    """[chain]: joints from the base outwards, gauge point and tool axis at home, and the part's frame."""

    tool: Annotated[list[str], "the joints from the base outwards to the tool; linear ones before rotary ones"]
    part: Annotated[list[str], "the joints from the base outwards to the part; linear ones before rotary ones"]
    gauge: Annotated[Point, "gauge point of the spindle at home, from which the tool length counts, mm"]
    axis: Annotated[Point, "direction from the tip to the spindle"]
    part_zero: Annotated[Point, "origin of the part frame, in which work offsets are given, mm"]
    up: Annotated[Point, "direction of z of the part frame"] = field(default_factory=lambda: [0.0, 0.0, 1.0])
    words: Annotated[Literal["AC", "BC"] | None, "the rotary axes that programs have"] = None

    def check_together(self) -> None:
        for key in ("axis", "up"):
            expect_direction(key, getattr(self, key))


class JointFile(Table, frozen=True, kw_only=True):
    """[joints.NAME]: a direction to slide along or to turn about, whose motion is positive, travel, and speed limits.

    A strut of a carrier has neither direction: its value is its length.
    """

    checks: ClassVar[Checks] = {"travel_mm": check_range, "travel_deg": check_range}

    slides: Annotated[Point | None, "direction along which the joint moves"] = None
    turns: Annotated[Point | None, "direction about which the joint turns right-handed"] = None
    through: Annotated[Point | None, "of a rotary joint: a point of its axis, mm"] = None
    positive: Annotated[Literal["tool", "part"] | None, "whether a positive value moves the tool or the part"] = None
    travel_mm: Annotated[Range | None, "travel of a linear joint: [least, greatest]"] = None
    travel_deg: Annotated[Range | None, "travel of a rotary joint: [least, greatest]; endless without it"] = None
    velocity: Annotated[Positive, "greatest velocity, mm/s or degrees/s"]
    acceleration: Annotated[Positive, "greatest acceleration, mm/s2 or degrees/s2"]
    jerk: Annotated[Positive | None, "greatest jerk, mm/s3 or degrees/s3; not limited without it"] = None

    def check_together(self) -> None:
        if self.slides is not None and self.turns is not None:
            raise ValueError("expected one of slides and turns, a direction")
        for key in ("slides", "turns"):
            if getattr(self, key) is not None:
                expect_direction(key, getattr(self, key))
        if self.turns is None and (self.travel_mm is None or self.through is not None or self.travel_deg is not None):
            raise ValueError("a joint that slides has travel_mm, and neither travel_deg nor through")
        if self.turns is not None and (self.through is None or self.travel_mm is not None):
            raise ValueError(
                "a joint that turns has through, a point of its axis, and no travel_mm; without travel_deg it "
                "is endless"
            )


class PartTableFile(Table, frozen=True, kw_only=True):
    """[table]: the face on which the part lies, about the part zero."""

    radius: Annotated[Positive, "radius of the table face, about the part zero, mm"]


class ChainSpindleFile(Table, frozen=True, kw_only=True):
    """[spindle]."""

    max_speed_rpm: Annotated[Positive, "greatest speed of the spindle"]


class ChainClearanceFile(Table, frozen=True, kw_only=True):
    """[clearance]: the spindle, a cylinder with flat ends about the tool axis, and its distance from the table."""

    spindle_diameter_mm: Annotated[Positive, "diameter of the spindle, a cylinder that starts at the gauge line"]
    spindle_top_mm: Annotated[Positive, "height of its upper end above the gauge line"]
    minimum_mm: Annotated[NotNegative, "smallest distance of the spindle from the table"] = 0.0


class ChainProvenanceFile(Table, frozen=True, kw_only=True):
    """[provenance]: each begins with identified, assumed, measured or specified."""

    chain: Source
    joints: Source
    control: Source
    carrier: Source | None = None
    spindle: Source | None = None
    table: Source | None = None
    home: Source | None = None
    drives: Source | None = None
    accuracy: Source | None = None
    clearance: Source | None = None
    vibration: Source | None = None


class ChainMachineFile(Table, frozen=True, kw_only=True):
    """The file as a whole."""

    schema: Annotated[Literal[2], "version of this format"]
    name: Annotated[str, Meta(min_length=1), "of the machine, in summaries and reports"]
    chain: Annotated[ChainFile, "the joints from the base to the tool and to the part"]
    carrier: Annotated[CarrierFile | None, "parallel module that carries the tool"] = None
    joints: Annotated[dict[str, JointFile], "directions, travel and speed limits of the joints, by their names"]
    spindle: Annotated[ChainSpindleFile | None, "the spindle"] = None
    table: Annotated[PartTableFile | None, "the face on which the part lies"] = None
    home: Annotated[HomeFile | None, "positions of G28, G30 and --to park"] = None
    accuracy: Annotated[AccuracyFile | None, "tolerance of blended corners"] = None
    clearance: Annotated[ChainClearanceFile | None, "size of the spindle, and its distance from the table"] = None
    drives: Annotated[dict[str, DriveFile] | None, "how the drives count, by joint"] = None
    vibration: Annotated[VibrationFile | None, "vibration modes, and the input shaper for them"] = None
    control: Annotated[ControlFile, "the control"]
    provenance: Annotated[ChainProvenanceFile, "where the values of each table are from"]

    def check_together(self) -> None:
        for group in ("carrier", "spindle", "table", "home", "accuracy", "clearance", "drives", "vibration"):
            if getattr(self, group) is not None and getattr(self.provenance, group) is None:
                raise ValueError(f"provenance.{group} is missing: every group says where it is from")
        if self.table is None and self.clearance is not None and self.clearance.minimum_mm:
            raise ValueError("clearance.minimum_mm: the spindle keeps off the table, and there is no [table]")
        find = (
            _find_faults(self.chain, self.joints) if self.carrier is None else _find_carrier_faults(self, self.carrier)
        )
        for text in find:
            raise ValueError(text)
        six = self.carrier is not None and self.carrier.is_hexapod
        if six != (self.chain.words is not None):
            raise ValueError(
                "chain.words is missing: six legs have no rotary joints that name the words; expected 'AC' or 'BC'"
                if six
                else "chain.words: the rotary joints of this machine name the words; leave the key out"
            )


def _find_faults(chain: ChainFile, joints: dict[str, JointFile]) -> Iterator[str]:
    """What is wrong with a chain, but for the directions of its joints."""
    named = [*chain.tool, *chain.part]
    for name in joints:
        if name not in named:
            near = suggest(name, [one for one in named if one not in joints])
            yield f"joints.{name}: neither chain.tool nor chain.part names it{near}"
    if sorted(named) != sorted(joints):
        yield (
            f"chain.tool and chain.part name {', '.join(named) or 'no joint'}, and the joints are {', '.join(joints)}; "
            "expected every joint once"
        )
    bare = [name for name in named if joints[name].slides is joints[name].turns is None]
    if bare:
        yield f"joints.{bare[0]}: expected one of slides and turns, a direction"
    slides = [name for name in named if joints[name].slides is not None]
    turns = [name for name in named if name not in slides]
    if sorted(slides) != list(_LINEAR) or len(turns) != 2 or not set(turns) <= set(_ROTARY):
        yield (
            f"the joints slide: {', '.join(slides)}, and turn: {', '.join(turns)}; expected x, y, z, and two of a, b, c"
        )
    for side in (chain.tool, chain.part):
        kinds = [name in turns for name in side]
        if kinds != sorted(kinds):
            yield (
                f"{side[kinds.index(True)]} turns {side[len(kinds) - 1 - kinds[::-1].index(False)]}: a rotary joint "
                "that carries a linear one is not executed yet"
            )


def _find_carrier_faults(file: ChainMachineFile, carrier: CarrierFile) -> Iterator[str]:
    """What is wrong with the joints of a carrier and its rotary pair, or of six legs, which have none."""
    turns = [name for name, joint in file.joints.items() if joint.turns is not None]
    if carrier.is_hexapod and turns:
        yield (
            f"the joints turn: {', '.join(turns)}; six actuators hold the platform in every direction, so expected "
            "none; a rotary table under them is not executed yet"
        )
    elif not carrier.is_hexapod and (len(turns) != 2 or not set(turns) <= set(_ROTARY)):
        yield f"the joints turn: {', '.join(turns) or 'none'}; expected two of a, b, c"
    if set(carrier.actuators) != set(file.joints) - set(turns):
        yield (
            f"carrier.actuators are {', '.join(carrier.actuators)}, and the joints that do not turn are "
            f"{', '.join(name for name in file.joints if name not in turns)}; expected the same"
        )
    for name in carrier.actuators:
        if file.joints[name].slides is not None:
            value = "a strut is its length" if carrier.rods is None else "a slider is its place on the rails"
            yield f"joints.{name}.slides: the value of {value}; leave the direction out"
        if file.joints[name].positive is not None:
            yield (
                f"joints.{name}.positive: a strut that grows, and a slider along its rails, is positive; leave the key "
                "out"
            )
    if carrier.is_hexapod:
        if file.chain.tool != ["carrier"] or file.chain.part:
            yield (
                f"chain.tool = {file.chain.tool}, chain.part = {file.chain.part}: expected tool = ['carrier'] and part "
                "= []"
            )
        if file.table is not None:
            yield "table: the part under six legs does not turn; leave [table] out"
        return
    if carrier.rods is not None:
        if file.chain.tool[:1] != ["carrier"] or sorted([*file.chain.tool[1:], *file.chain.part]) != sorted(turns):
            yield (
                f"chain.tool = {file.chain.tool}, chain.part = {file.chain.part}: expected 'carrier' first in tool, "
                "then the rotary joints of the tool, and those of the part in part"
            )
        return
    if file.table is not None:
        yield "table: the part of a carrier with a wrist does not turn; leave [table] out"
    if file.chain.part or file.chain.tool[:1] != ["carrier"] or sorted(file.chain.tool[1:]) != sorted(turns):
        yield (
            f"chain.tool = {file.chain.tool}, chain.part = {file.chain.part}: expected 'carrier' first in tool, then "
            "both rotary joints, and part = []; a central leg over a rotary table is not executed yet"
        )


#: Limits of the two angles of a machine without rotary joints, per s, s2, s3. Nothing drives them, so they exceed what
#: any program needs, except where the tool passes upright.
_ANGLE_VELOCITY: Final = 1e4
_ANGLE_ACCELERATION: Final = 1e7
_ANGLE_JERK: Final = 1e10


def _add_words(file: ChainMachineFile) -> tuple[list[str], dict[str, JointFile]]:
    """``chain.tool`` and the joints, with words as joints of a head through the gauge point: C, and A or B on it."""
    chain = file.chain
    if chain.words is None:
        return chain.tool, file.joints
    up, axis = _normalise(chain.up), _normalise(chain.axis)
    if np.abs(up - axis).max() > PARALLEL:
        raise ValueError("chain.axis is not along chain.up: with six legs the tool must be along z of the part at home")
    x, y, _z = _find_part_directions(up)
    tilt = chain.words[0].lower()
    about = {"c": up, tilt: x if tilt == "a" else y}
    words = {
        name: JointFile(
            turns=one.tolist(),
            through=chain.gauge,
            velocity=_ANGLE_VELOCITY,
            acceleration=_ANGLE_ACCELERATION,
            jerk=_ANGLE_JERK,
        )
        for name, one in about.items()
    }
    return ["carrier", "c", tilt], {**file.joints, **words}


def _find_part_directions(up: Array) -> Array:
    """Rows: x, y, z of the part frame in directions of the base."""
    x = next(unit for unit in np.eye(3) if np.linalg.norm(np.cross(unit, up)) > _ALONG)
    x = _normalise(x - (x @ up) * up)
    return np.stack([x, np.cross(up, x), up])


def _is_in_reverse(turn: Array, tilt: Array, axis: Array, preferred: float) -> bool:
    """Whether a pair that cannot point the tool could if its joints were in the other order."""
    try:
        build_pair(turn, tilt, axis, preferred)
    except ValueError:
        return False
    return True


# --- geometry -------------------------------------------------------------------------------------------------


class _Geometry:
    """The chain in its polar frame, or a ValueError with a sentence."""

    def __init__(self, file: ChainMachineFile) -> None:
        chain = file.chain
        tool, joints = _add_words(file)
        to_part = _find_part_directions(_normalise(chain.up))
        in_order = (*reversed(chain.part), *tool)
        rotary = [name for name in in_order if name in joints and joints[name].turns is not None]
        self.turn, self.tilt = rotary
        directions = {
            name: to_part @ _normalise(one) for name, joint in joints.items() if (one := joint.turns or joint.slides)
        }
        axis = to_part @ _normalise(chain.axis)
        on_tool = {name: name in tool for name in joints}
        self.joints = joints
        #: 1 where the positive sense is that of the tool's motion against the part, -1 where it is the part's.
        self.senses = {
            name: 1.0 if (joint.positive or ("tool" if on_tool[name] else "part")) == "tool" else -1.0
            for name, joint in joints.items()
        }
        low, high = joints[self.tilt].travel_deg or (-1.0, 1.0)
        longer = self.senses[self.tilt] * (1.0 if high >= -low else -1.0)
        try:
            self.pair = build_pair(directions[self.turn], directions[self.tilt], axis, longer)
        except ValueError as error:
            reverse = _is_in_reverse(directions[self.tilt], directions[self.turn], axis, longer)
            side = next((key for key in ("part", "tool") if {*rotary} <= {*getattr(chain, key)}), "")
            if not (reverse and side):
                raise
            listed = [name for name in getattr(chain, side) if name in rotary]
            raise ValueError(
                f"chain.{side}: {error}; is the order of {listed[0]} and {listed[1]} reversed? The joints are listed "
                "from the base outwards"
            ) from None
        polar, zero = self.pair.directions, np.array(chain.part_zero)
        self.linear = _LINEAR if file.carrier is None else tuple(file.carrier.actuators)
        linear = polar  # of a carrier: X, Y, Z of the machine are those of the part
        if file.carrier is None:
            linear = np.stack([polar @ directions[name] * self.senses[name] for name in _LINEAR], axis=1)
        if abs(np.linalg.det(linear)) < _FLAT:
            raise ValueError("the directions of x, y, z lie in a plane: the tool cannot move out of it")

        def place(point: list[float]) -> Array:
            return np.asarray(polar @ to_part @ (np.array(point) - zero))

        tilt, turn = (Rotary(place(joints[name].through or []), on_tool[name]) for name in (self.tilt, self.turn))
        gauge = place(chain.gauge)
        if (nutation := self.pair.nutation) is None:
            axis = np.array([0.0, math.sin(self.pair.home_tilt), math.cos(self.pair.home_tilt)])
        else:
            axis = polar @ axis
            _check_travel(
                nutation, self.tilt, joints[self.tilt].travel_deg, self.pair.tilt_sign * self.senses[self.tilt]
            )
        wrist = ChainMachine(self.pair, gauge, axis, linear, tilt, turn, _compute_inverse(linear))
        self.machine: FiveAxis = wrist
        if file.carrier is not None:
            names = self.tilt, self.turn
            self.machine = build_carrier_machine(file.carrier, wrist, polar @ to_part, zero, names)
        #: Joint values inside per value of the file, rad per rad.
        self.signs = (self.pair.tilt_sign * self.senses[self.tilt], self.pair.turn_sign * self.senses[self.turn])
        axes = AXES.index(self.tilt.upper()), AXES.index(self.turn.upper())
        words = RotaryWords(axes, *self.signs, self.pair.home_tilt, self.pair.nutation)
        by_axis = not isinstance(self.machine, ChainMachine | SlidingMachine)
        self.coordinates = ChainCoordinates(wrist, words, polar.T @ gauge, by_axis)


def _check_travel(nutation: Nutation, name: str, travel: list[float] | None, sign: float) -> None:
    """Refuse a travel of a nutating pair's tilting joint that passes a fold: beyond it the solutions repeat."""
    home, pole = sign * DEG_PER_RAD * nutation.home, nutation.near == nutation.far
    low, high = -180.0 - home, 180.0 - home
    if not pole:  # the fold at d = 0 too
        low, high = (-home, high) if sum(travel or (0.0, 0.0)) > -2.0 * home else (low, -home)
    slack = DEG_PER_RAD * RIGHT_ANGLE
    if travel is None or travel[0] < low - slack or travel[1] > high + slack:
        raise ValueError(
            f"joints.{name}.travel_deg = {travel if travel else 'absent'}: the pair nutates, and its solutions meet at "
            f"{name} {low:.6g} and {high:.6g}, its folds; expected a travel between them"
        )


def _compute_inverse(matrix: Array) -> Array:
    """The inverse; exact for axes that lie along each other's."""
    inverse = np.linalg.inv(matrix)
    near = np.round(inverse)
    return np.asarray(near) + 0.0 if np.array_equal(matrix @ near, np.eye(3)) else np.asarray(inverse)


def describe_skew_joints(data: Mapping[str, Any]) -> Iterator[str]:
    """One line for each joint of a file of schema 2 whose direction is along no axis: that may be meant, or not."""
    joints = data.get("joints")
    for name, joint in joints.items() if isinstance(joints, Mapping) else ():
        for key, word in (("slides", "along"), ("turns", "about")):
            if np.count_nonzero(joint.get(key, ())) > 1:
                unit = _normalise(joint[key])
                near = int(np.argmax(np.abs(unit)))
                angle = np.degrees(np.arctan2(np.linalg.norm(np.delete(unit, near)), abs(unit[near])))
                shown = ", ".join(f"{value:.6g}" for value in unit)
                yield f"{name} {key} {word} ({shown}): along no axis, {angle:.6g} degrees from {'xyz'[near]}"


def _normalise(vector: list[float] | Array) -> Array:
    """A direction; one along an axis is exact."""
    array = np.asarray(vector, dtype=float)
    return np.asarray(array / np.linalg.norm(array))


# --- the machine ------------------------------------------------------------------------------------------------


def build_chain_machine(data: dict[str, Any], raw: bytes, file_name: str) -> Machine:
    """The machine of a file of schema 2, given as its tables and as its bytes.

    Raises
    ------
    InputError
        VP501 with every mistake.
    """
    try:
        file = check_table(ChainMachineFile, data, "a machine file of schema 2")
    except WrongTableError as error:
        raise InputError(*(make_finding("VP501", f"{file_name}: {text}") for text in error.sentences)) from None
    try:
        geometry = _Geometry(file)
    except ValueError as error:
        raise make_input_error("VP501", f"{file_name}: {error}") from None
    if file.table is not None and abs(geometry.pair.directions[2, 2]) < 1.0 - PARALLEL:
        text = (
            f"{file_name}: table.radius: {geometry.turn} does not turn about z of the part, so it has no face at z = "
            "0; leave [table] out"
        )
        raise make_input_error("VP501", text)
    signs = dict(zip((geometry.tilt, geometry.turn), geometry.signs, strict=True))
    columns = (
        *(Column(name, "mm", 1.0, "VP101") for name in geometry.linear),
        Column(geometry.tilt, "deg", DEG_PER_RAD * signs[geometry.tilt], "VP102", driven=geometry.tilt in file.joints),
        Column(geometry.turn, "deg", DEG_PER_RAD * signs[geometry.turn], "VP103", driven=geometry.turn in file.joints),
    )
    limits = _convert_limits(file, geometry.joints, columns)
    accuracy = file.accuracy or AccuracyFile()
    clearance, bodies = _make_clearance(file, geometry.machine)
    return Machine(
        name=escape_unprinted(file.name),
        kind="chain" if file.carrier is None else "carrier",
        file_sha256=hashlib.sha256(raw).hexdigest(),
        module=None,
        five_axis=geometry.machine,
        coordinates=geometry.coordinates,
        columns=columns,
        limits=limits,
        accuracy=Accuracy(accuracy.tip_mm, RAD_PER_DEG * accuracy.axis_deg),
        home=convert_home(file.home) if file.home else None,
        table_radius=file.table.radius if file.table else 0.0,
        spindle_rpm=file.spindle.max_speed_rpm if file.spindle else math.inf,
        clearance=clearance,
        bodies=bodies,
        cycle=file.control.cycle_s,
        provenance={
            key: escape_unprinted(value) for key, value in asdict(file.provenance).items() if value is not None
        },
        drives=convert_drives(file.drives, columns, limits, file_name),
        warnings=(
            *find_implausible_in_chain(data, file_name),
            *_find_reversed_axis(file, geometry, limits, file_name),
            *_find_mirrored_axes(file, geometry, file_name),
        ),
        vibration=convert_vibration(file.vibration),
    )


def _make_clearance(file: ChainMachineFile, five_axis: FiveAxis) -> tuple[Clearance | None, Bodies | None]:
    """The clearances of legs or of the spindle from the table, and what keeps out of fixtures and stock."""
    clearance = None
    if file.carrier is not None and isinstance(five_axis, HexapodMachine):
        clearance = build_leg_clearance(file.carrier, five_axis)
    bodies = clearance.bodies if clearance else None
    if file.clearance is None:
        return clearance, bodies
    bodies = replace(
        bodies or Bodies(minimum=file.clearance.minimum_mm),
        spindle_radius=0.5 * file.clearance.spindle_diameter_mm,
        spindle_top=file.clearance.spindle_top_mm,
        spindle_is_flat=True,
    )
    if file.table is not None:
        clearance = Clearance(bodies, None, five_axis.nose_offset, five_axis.spindle, file.table.radius)
    return clearance, bodies


def _find_reversed_axis(
    file: ChainMachineFile, geometry: _Geometry, limits: Limits, file_name: str
) -> Iterator[Finding]:
    """VP505 of a tool that points up at joints 0, and that no travel turns down: the reverse of its axis is meant."""
    if is_upside_down(geometry.machine, limits):
        meant = ", ".join(f"{-value + 0.0:g}" for value in file.chain.axis)
        text = (
            f"{file_name}: chain.axis: at joints 0 the tool points towards +z of the part, from the spindle up, and no "
            f"travel of {geometry.tilt} and {geometry.turn} turns it down; chain.axis goes from the tip to the "
            f"spindle: is [{meant}] meant, or chain.up the other way?"
        )
        yield make_finding("VP505", text, advice="Reverse chain.axis, or chain.up, whichever is wrong.")


def _find_mirrored_axes(file: ChainMachineFile, geometry: _Geometry, file_name: str) -> Iterator[Finding]:
    """VP505 of x, y, z that move the tool against the part along left-handed directions: one sense is wrong."""
    machine = geometry.machine
    if not isinstance(machine, ChainMachine) or np.linalg.det(machine.linear) > 0.0:
        return
    ways = dict(zip(_LINEAR, map(name_direction, (geometry.pair.directions.T @ machine.linear).T), strict=True))
    moves = ", ".join(f"+{name.upper()} towards {way}" for name, way in ways.items())
    against = [name for name, way in ways.items() if way == f"-{name}"]
    default = [name for name in against if name in file.chain.part and file.joints[name].positive is None]
    if len(default) == 1:
        (name,) = default
        key, cure = f"joints.{name}.positive", f'write positive = "tool" if the table moves towards -{name}'
        jog = f"{name.upper()} +10"
    elif len(against) == 1:
        (name,) = against
        end = "table moves towards -" if name in file.chain.part else "tool moves towards +"
        key, cure = f"joints.{name}.slides", f"reverse it if the {end}{name}"
        jog = f"{name.upper()} +10"
    else:
        names = [name for name, way in ways.items() if way[1] != name] or list(_LINEAR)
        key, jog = f"joints.{names[0]}.slides", " and ".join(f"{name.upper()} +10" for name in names)
        cure = f"correct {' and '.join(f'joints.{name}' for name in names)} where the tool moves another way"
    text = (
        f"{file_name}: {key}: the tool moves in the part by {moves}: left-handed, as no machine tool counts "
        f"(ISO 841), so that every part would be its mirror image; jog {jog}: {cure}"
    )
    yield make_finding("VP505", text, advice=f"Jog {jog}, see where the tool goes, and correct the machine file.")


def _convert_limits(file: ChainMachineFile, named: dict[str, JointFile], columns: tuple[Column, ...]) -> Limits:
    joints = [named[column.joint] for column in columns]
    travel = np.array(
        [
            sorted(value / column.factor for value in joint.travel_mm or joint.travel_deg or (-math.inf, math.inf))
            for joint, column in zip(joints, columns, strict=True)
        ]
    )
    size = np.array([abs(column.factor) for column in columns])
    velocity, acceleration, jerk = (
        np.array([getattr(joint, key) or math.inf for joint in joints]) / size
        for key in ("velocity", "acceleration", "jerk")
    )
    smallest, drop = -math.inf, 0.0
    if file.carrier is not None:
        smallest, drop = file.carrier.smallest_singular_value, file.carrier.smallest_drop_mm or 0.0
    return Limits(travel[:, 0], travel[:, 1], velocity, acceleration, jerk, drop, smallest)
