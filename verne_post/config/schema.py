"""The machine file as a schema: keys, types, bounds. docs/machine-file.md says what they mean."""

import math
from collections.abc import Mapping
from functools import cache
from itertools import combinations, pairwise
from typing import Annotated, Any, ClassVar, Final, Literal, cast

from msgspec import Meta, defstruct

from verne_post.config.box_file import BodyFile
from verne_post.config.sentences import Checks, Table
from verne_post.model.drives import STEEPEST_ERROR
from verne_post.model.vibration import Shaper

#: No length, limit or count of a machine is larger: squares and products of such numbers stay finite.
_LARGEST: Final = 1e12
Number = Annotated[float, Meta(ge=-_LARGEST, le=_LARGEST)]
Positive = Annotated[float, Meta(gt=0, le=_LARGEST)]
NotNegative = Annotated[float, Meta(ge=0, le=_LARGEST)]
Point = Annotated[list[Number], Meta(min_length=3, max_length=3)]
Pose = Annotated[list[Number], Meta(min_length=5, max_length=5)]
Range = Annotated[list[Number], Meta(min_length=2, max_length=2)]
Sense = Literal["workpiece", "tool"]
Source = Annotated[
    str,
    Meta(
        pattern=r"^(identified|assumed|measured|specified)\b",
        description="text that begins with identified, assumed, measured or specified",
    ),
]


def check_range(value: list[float] | None) -> None:
    """A range has its smaller value first."""
    if value is not None and value[0] >= value[1]:
        raise ValueError(f"the lower end {value[0]:g} must be below the upper end {value[1]:g}")


class VerneModuleFile(Table, frozen=True, kw_only=True):
    """[module] of kind "verne"."""

    about: ClassVar[Mapping[str, str]] = {
        "leg1_x_offset": "D1 - d1 of leg I: platform attachment (from P) minus slider, along x, mm",
        "R1": "leg I: half distance of the rods at the platform, mm",
        "r1": "leg I: half distance of the rods at the slider, mm",
        "L1": "length of the two rods of leg I, mm",
        "leg23_x_offset": "D2 - d2 of legs II and III: platform attachment (from P) minus slider, along x, mm",
        "R2": "legs II and III: distance of their platform attachments from P, along y, mm",
        "r4": "legs II and III: distance of their sliders from the middle, along y, mm",
        "L2": "rod length of leg II, mm",
        "L3": "rod length of leg III, mm",
    }

    leg1_x_offset: Number
    R1: Positive
    r1: Positive
    L1: Positive
    leg23_x_offset: Number
    R2: Positive
    r4: Positive
    L2: Positive
    L3: Positive

    def check_together(self) -> None:
        if self.r1 >= self.R1:
            raise ValueError(
                f"r1 = {self.r1:g} must be smaller than R1 = {self.R1:g}, or the rods of leg I always cross"
            )


class SerialModuleFile(Table, frozen=True, kw_only=True):
    """[module] of kind "serial"."""

    about: ClassVar[Mapping[str, str]] = {
        "zero": "P at x = y = z = 0, base frame (z down), mm",
    }

    zero: Point


#: Legs closer together than this, seen from above, hold nothing: the platform would swing about them.
LEG_SEPARATION_DEG: Final = 1.0


class LinearDeltaModuleFile(Table, frozen=True, kw_only=True):
    """[module] of kind "linear_delta"."""

    about: ClassVar[Mapping[str, str]] = {
        "platform_radius": "distance of the platform's joints from P, mm",
        "base_radius": "distance of the sliders' joints from the z axis of the base frame, mm",
        "rod_length": "length of all six rods, mm",
        "leg_angles_deg": "angles of the legs, from x towards y of the base frame",
    }

    platform_radius: Positive
    base_radius: Positive
    rod_length: Positive
    leg_angles_deg: Point

    def check_together(self) -> None:
        if self.platform_radius >= self.base_radius:
            raise ValueError(
                f"platform_radius = {self.platform_radius:g} must be smaller than base_radius = {self.base_radius:g}"
            )
        reach = self.base_radius - self.platform_radius
        if self.rod_length <= reach:
            raise ValueError(
                f"rod_length = {self.rod_length:g} must be longer than base_radius - platform_radius = {reach:g}, "
                "or no rod reaches the middle"
            )
        for (i, one), (j, other) in combinations(enumerate(self.leg_angles_deg, start=1), 2):
            if abs((one - other + 180.0) % 360.0 - 180.0) < LEG_SEPARATION_DEG:
                raise ValueError(
                    f"leg_angles_deg: legs {i} and {j} are at {one:g} and {other:g} degrees, "
                    f"they must be {LEG_SEPARATION_DEG:g} degree or more apart"
                )


#: A direction is at least so long: the square of a shorter one may vanish.
_LEAST_DIRECTION: Final = 1e-6


def expect_direction(name: str, vector: list[float]) -> None:
    """Raise ValueError where three numbers are no direction, because all of them are next to 0."""
    if math.hypot(*vector) < _LEAST_DIRECTION:
        raise ValueError(f"{name} = {vector}: expected a direction, with a length of at least {_LEAST_DIRECTION:g}")


class RodFile(Table, frozen=True, kw_only=True):
    """One of module.rod."""

    about: ClassVar[Mapping[str, str]] = {
        "platform": "joint on the platform, from P, mm",
        "slider": "joint on the slider at 0, base frame, mm",
        "rail": "direction of the rail",
        "length": "length of the rod, mm",
        "by": "the slider that moves the rod",
    }

    platform: Point
    slider: Point
    rail: Point
    length: Positive
    by: Literal["rho1", "rho2", "rho3"]

    def check_together(self) -> None:
        expect_direction("rail", self.rail)


class RodsModuleFile(Table, frozen=True, kw_only=True):
    """[module] of kind "rods"."""

    about: ClassVar[Mapping[str, str]] = {
        "home": "P at home, base frame, which decides the assembly mode, mm",
        "home_mm": "approximate sliders at home; they say on which side of its slider each rod is",
        "rod": "the six rods",
        "largest_tilt_deg": "a platform that tilts more is in another assembly mode",
    }

    home: Point
    home_mm: Point
    rod: Annotated[list[RodFile], Meta(min_length=6, max_length=6)]
    largest_tilt_deg: Annotated[float, Meta(gt=0, lt=90)] = 60.0

    def check_together(self) -> None:
        idle = sorted({"rho1", "rho2", "rho3"} - {rod.by for rod in self.rod})
        if idle:
            raise ValueError(f"rod: none is moved by {', '.join(idle)}")


class SpindleFile(Table, frozen=True, kw_only=True):
    """[spindle]."""

    about: ClassVar[Mapping[str, str]] = {
        "nose_offset_mm": "from P along the tool axis to the gauge line",
        "max_speed_rpm": "greatest speed of the spindle",
    }

    nose_offset_mm: Number
    max_speed_rpm: Positive | None = None


class TableFile(Table, frozen=True, kw_only=True):
    """[table]."""

    about: ClassVar[Mapping[str, str]] = {
        "pivot": "a point on the tilt axis, base frame (z down), mm",
        "rotary_offset": "from the pivot to the rotary centre on the table face, at A = 0, z up, mm",
        "machine_zero": "from the rotary centre to the origin of machine coordinates, at A = 0, z up, mm",
        "radius": "radius of the table face, mm",
        "a_positive": "a positive A turns the part, or the tool against the part",
        "c_positive": "a positive C turns the part, or the tool against the part",
    }

    pivot: Point
    rotary_offset: Point
    machine_zero: Point
    radius: Positive
    a_positive: Sense = "workpiece"
    c_positive: Sense = "workpiece"


class HomeFile(Table, frozen=True, kw_only=True):
    """[home]."""

    about: ClassVar[Mapping[str, str]] = {
        "g28": "x, y, z and the rotary axes where G28 and --from home go, mm and degrees",
        "g30": "x, y, z and the rotary axes where G30 goes, mm and degrees",
        "park": "x, y, z and the rotary axes where --to park goes, mm and degrees",
    }

    g28: Pose
    g30: Pose
    park: Pose | None = None


PerActuator = Positive | Annotated[list[Positive], Meta(min_length=3, max_length=3)]
#: One range for all, or three.
PerActuatorRange = Annotated[
    list[Number | Range],
    Meta(min_length=2, max_length=3, description="[least, greatest], such as [50, 1250], or three such lists"),
]
#: The travel of a rotary axis.
Travel = Annotated[list[Number], Meta(min_length=2, max_length=2, description="[least, greatest], such as [-95, 95]")]


def check_ranges(value: list[Any]) -> None:
    """One range or three: each has its smaller value first."""
    lists = [item for item in value if isinstance(item, list)]
    if (lists and not len(lists) == len(value) == 3) or (not lists and len(value) != 2):
        raise ValueError("expected 2 numbers, [lower, upper], or 3 such pairs")
    for item in lists or [value]:
        check_range(item)


class LimitsFile(Table, frozen=True, kw_only=True):
    """[limits] of the table; :func:`describe_limits_table` adds the actuators of a kind."""

    about: ClassVar[Mapping[str, str]] = {
        "a_deg": "tilt travel, in the sense of this file",
        "c_deg": "rotary travel, in the sense of this file; unlimited without it",
        "a_velocity": "greatest velocity, degrees/s",
        "c_velocity": "greatest velocity, degrees/s",
        "a_acceleration": "greatest acceleration, degrees/s2",
        "c_acceleration": "greatest acceleration, degrees/s2",
        "a_jerk": "greatest jerk, degrees/s3; not limited without it",
        "c_jerk": "greatest jerk, degrees/s3; not limited without it",
    }

    checks: ClassVar[Checks] = {"a_deg": check_range, "c_deg": check_range}

    a_deg: Travel
    c_deg: Travel | None = None
    a_velocity: Positive
    a_acceleration: Positive
    a_jerk: Positive | None = None
    c_velocity: Positive
    c_acceleration: Positive
    c_jerk: Positive | None = None


@cache
def describe_limits_table(group: str, rods: bool) -> type[LimitsFile]:
    """Schema of [limits] for a kind.

    Parameters
    ----------
    group : str
        How the kind calls its actuators together: "rho" makes the keys rho_mm, rho_velocity, rho_acceleration and
        rho_jerk, each one value for all or a list of three.
    rods : bool
        True where a rod can come close to the horizontal, so that serial_singularity_mm is needed and
        parallel_singularity allowed.
    """
    fields: list[Any] = [(f"{group}_mm", PerActuatorRange)]
    fields += [(f"{group}_{what}", PerActuator) for what in ("velocity", "acceleration")]
    fields.append((f"{group}_jerk", PerActuator | None, None))
    if rods:
        fields += [("serial_singularity_mm", NotNegative), ("parallel_singularity", Positive | None, None)]
    namespace = {
        "checks": {**LimitsFile.checks, f"{group}_mm": check_ranges},
        "about": {
            f"{group}_mm": "travel of the actuators, one for all or a list of three",
            f"{group}_velocity": "greatest velocity, mm/s",
            f"{group}_acceleration": "greatest acceleration, mm/s2",
            f"{group}_jerk": "greatest jerk, mm/s3; not limited without it",
            "serial_singularity_mm": "smallest drop of a rod: the distance between its two ends along the rail",
            "parallel_singularity": "smallest measure of the parallel Jacobian",
        },
    }
    made = defstruct("LimitsFile", fields, bases=(LimitsFile,), namespace=namespace, frozen=True, kw_only=True)
    return cast("type[LimitsFile]", made)


PerLeg = Positive | Annotated[list[Positive], Meta(min_length=3, max_length=3)]
Cone = Annotated[float, Meta(gt=0, lt=180)]


class RodsFile(Table, frozen=True, kw_only=True):
    """[rods] of every kind: sizes of rods and ball joints; a kind adds where its rods are."""

    about: ClassVar[Mapping[str, str]] = {
        "diameter_mm": "of the rods: one value, or a list of three for legs I, II, III",
        "slider_cone_deg": "half angle of the cone in which a ball joint at the slider lets its rod move",
        "platform_cone_deg": "half angle of the cone in which a ball joint at the platform lets its rod move",
        "cone_centre": "platform position, base frame, at which the rods are in the middle of their cones, mm",
    }

    diameter_mm: PerLeg | None = None
    slider_cone_deg: Cone | None = None
    platform_cone_deg: Cone | None = None
    cone_centre: Point | None = None

    def check_together(self) -> None:
        cones = self.slider_cone_deg is not None or self.platform_cone_deg is not None
        if cones != (self.cone_centre is not None):
            raise ValueError("cone_centre and slider_cone_deg or platform_cone_deg belong together")


class VerneRodsFile(RodsFile, frozen=True, kw_only=True):
    """[rods] of kind "verne"."""

    about: ClassVar[Mapping[str, str]] = {
        "leg1_slider_x": "x of the slider's joints of leg I, base frame, mm",
        "leg23_slider_x": "x of the slider's joints of legs II and III, base frame, mm",
        "leg23_spacing": "distance of the two rods of a parallelogram, along x, mm",
    }

    leg1_slider_x: Number
    leg23_slider_x: Number
    leg23_spacing: Positive


class TolerancesFile(Table, frozen=True, kw_only=True):
    """[tolerances]: standard deviations of the parts as made, mm and mrad; a key for parts of their own."""

    about: ClassVar[Mapping[str, str]] = {
        "lengths_mm": "of every position and length without its own key",
        "directions_mrad": "of every direction without its own key, mrad",
        "platform_ends_mm": "of platform_ends_mm in [as_built]; without it lengths_mm",
        "slider_ends_mm": "of slider_ends_mm in [as_built]; without it lengths_mm",
        "rod_lengths_mm": "of rod_lengths_mm in [as_built]; without it lengths_mm",
        "tilt_axis_mm": "of tilt_axis_mm in [as_built]; without it lengths_mm",
        "rotary_axis_mm": "of rotary_axis_mm in [as_built]; without it lengths_mm",
        "guides_mrad": "of guides_mrad in [as_built], mrad; without it directions_mrad",
        "tilt_axis_mrad": "of tilt_axis_mrad in [as_built], mrad; without it directions_mrad",
        "rotary_axis_mrad": "of rotary_axis_mrad in [as_built], mrad; without it directions_mrad",
        "spindle_axis_mrad": "of spindle_axis_mrad in [as_built], mrad; without it directions_mrad",
    }

    lengths_mm: Positive = 0.05
    directions_mrad: Positive = 0.1
    platform_ends_mm: Positive | None = None
    slider_ends_mm: Positive | None = None
    rod_lengths_mm: Positive | None = None
    guides_mrad: Positive | None = None
    tilt_axis_mm: Positive | None = None
    tilt_axis_mrad: Positive | None = None
    rotary_axis_mm: Positive | None = None
    rotary_axis_mrad: Positive | None = None
    spindle_axis_mrad: Positive | None = None


class ClearanceFile(Table, frozen=True, kw_only=True):
    """[clearance]: smallest distance between bodies, and the bodies other than rods."""

    about: ClassVar[Mapping[str, str]] = {
        "minimum_mm": "smallest distance: rod to rod, rod to spindle, spindle or tool to table",
        "spindle_diameter_mm": "diameter of the spindle, a capsule that starts at the gauge line",
        "spindle_top_mm": "height of its upper end above the platform point P",
        "tool_diameter_mm": "diameter of the largest tool",
        "platform_ends_mm": "the platform as a capsule between these two points, platform frame (z down)",
        "platform_diameter_mm": "of that capsule",
    }

    minimum_mm: NotNegative
    spindle_diameter_mm: Positive | None = None
    spindle_top_mm: NotNegative = 0.0
    tool_diameter_mm: Positive | None = None
    platform_ends_mm: Annotated[list[Point], Meta(min_length=2, max_length=2)] | None = None
    platform_diameter_mm: Positive | None = None

    def check_together(self) -> None:
        if (self.platform_ends_mm is None) != (self.platform_diameter_mm is None):
            raise ValueError("platform_ends_mm and platform_diameter_mm belong together")


def check_lead_error(value: list[list[float]] | None) -> None:
    """Places rise, and errors change little between them."""
    for (low, error_low), (high, error_high) in pairwise(value or []):
        if high <= low:
            raise ValueError(f"places rise from row to row; {high:g} follows {low:g}")
        if abs(error_high - error_low) > STEEPEST_ERROR * (high - low):
            raise ValueError(
                f"between {low:g} and {high:g} the error changes by more than {STEEPEST_ERROR:g} of the way: [place, "
                "error], both in mm or degrees"
            )


class DriveFile(Table, frozen=True, kw_only=True):
    """[drives.JOINT]: how one drive counts."""

    about: ClassVar[Mapping[str, str]] = {
        "unit": "name of the numbers, for the heading",
        "sign": "-1 where the drive counts the other way",
        "zero": "where the drive reads 0, mm or degrees",
        "scale": "numbers per mm or degree",
        "integer": "whether the drive takes whole numbers",
        "lead_error": "measured error at commanded positions, rising: [position, error] in mm or degrees",
    }

    checks: ClassVar[Checks] = {"lead_error": check_lead_error}

    unit: Annotated[str, Meta(pattern=r"^[A-Za-z][A-Za-z0-9]*$", description="letters and digits, a letter first")]
    sign: Literal[1, -1] = 1
    zero: Number = 0.0
    scale: Positive = 1.0
    integer: bool = False
    lead_error: Annotated[list[Range], Meta(min_length=2)] | None = None


class AccuracyFile(Table, frozen=True, kw_only=True):
    """[accuracy]."""

    about: ClassVar[Mapping[str, str]] = {
        "tip_mm": "how far blended corners may leave the path of the tip",
        "axis_deg": "how far blended corners may leave the tool axis",
        "uncorrected_axis_deg": "with [as_built]: largest error of the tool axis that the rotary axes cannot correct",
    }

    tip_mm: Positive = 0.01
    axis_deg: Positive = 0.05
    uncorrected_axis_deg: Positive | None = None


#: A lower frequency (Hz) would make a machine wait for a second at every stop; more damping needs no shaper.
LOWEST_MODE: Final = 1.0
MOST_DAMPING: Final = 0.5


def check_modes(value: list[list[float]]) -> None:
    """Each is a vibration that an input shaper can be made for."""
    for frequency, damping in value:
        if not (frequency >= LOWEST_MODE and 0.0 <= damping <= MOST_DAMPING):
            raise ValueError(
                f"[{frequency:g}, {damping:g}] is no mode: [frequency in Hz, at least {LOWEST_MODE:g}; "
                f"damping ratio, 0 to {MOST_DAMPING:g}]"
            )


class VibrationFile(Table, frozen=True, kw_only=True):
    """[vibration]: modes as [frequency in Hz, damping ratio], and the input shaper for them."""

    about: ClassVar[Mapping[str, str]] = {
        "modes": "vibration modes: [frequency in Hz, damping ratio 0 to 0.5]",
        "shaper": "input shaper, unless --shaper says otherwise",
    }

    checks: ClassVar[Checks] = {"modes": check_modes}

    modes: Annotated[list[Range], Meta(min_length=1, max_length=4)]
    shaper: Shaper | None = None


class ControlFile(Table, frozen=True, kw_only=True):
    """[control]."""

    about: ClassVar[Mapping[str, str]] = {
        "cycle_s": "control cycle: time from row to row of a setpoint file",
    }

    cycle_s: Annotated[float, Meta(ge=1e-4, le=1.0)]


class ProvenanceFile(Table, frozen=True, kw_only=True):
    """[provenance]: each begins with identified, assumed, measured or specified."""

    module: Source
    spindle: Source
    table: Source
    limits: Source
    control: Source
    home: Source | None = None
    rods: Source | None = None
    tolerances: Source | None = None
    clearance: Source | None = None
    drives: Source | None = None
    accuracy: Source | None = None
    vibration: Source | None = None
    bodies: Source | None = None


class MachineFile(Table, frozen=True, kw_only=True):
    """The file as a whole; ``module`` and ``limits`` are checked against the schemas of its ``kind``."""

    about: ClassVar[Mapping[str, str]] = {
        "schema": "version of this format",
        "name": "of the machine, in summaries and reports",
        "kind": "the mechanism that moves the spindle",
        "module": "sizes of the parallel module",
        "spindle": "the spindle on the platform",
        "table": "the tilting rotary table",
        "home": "positions of G28, G30 and --to park",
        "limits": "travel, velocity, acceleration and jerk of the joints",
        "accuracy": "tolerance of blended corners",
        "rods": "sizes of rods and ball joints",
        "as_built": "deviations of the parts of the machine as built",
        "tolerances": "standard deviations of the parts as made, before a calibration",
        "clearance": "smallest distance between bodies, and their sizes",
        "bodies": "meshes of spindle and platform",
        "drives": "how the drives count, by joint",
        "vibration": "vibration modes, and the input shaper for them",
        "control": "the control",
        "provenance": "where the values of each table are from",
    }

    schema: Literal[1, 2]
    name: Annotated[str, Meta(min_length=1)]
    kind: str
    module: dict[str, object]
    spindle: SpindleFile
    table: TableFile
    home: HomeFile | None = None
    limits: dict[str, object]
    accuracy: AccuracyFile | None = None
    rods: dict[str, object] | None = None
    as_built: object = None
    tolerances: TolerancesFile | None = None
    clearance: ClearanceFile | None = None
    bodies: dict[Literal["spindle", "platform"], BodyFile] | None = None
    drives: dict[str, DriveFile] | None = None
    vibration: VibrationFile | None = None
    control: ControlFile
    provenance: ProvenanceFile

    def check_together(self) -> None:
        for group in ("home", "accuracy", "rods", "tolerances", "clearance", "bodies", "drives", "vibration"):
            if getattr(self, group) is not None and getattr(self.provenance, group) is None:
                raise ValueError(f"provenance.{group} is missing: every group says where it is from")
