"""The machine file as a schema: keys, types, bounds. docs/machine-file.md says what they mean."""

import math
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

    leg1_x_offset: Annotated[Number, "D1 - d1 of leg I: platform attachment (from P) minus slider, along x, mm"]
    R1: Annotated[Positive, "leg I: half distance of the rods at the platform, mm"]
    r1: Annotated[Positive, "leg I: half distance of the rods at the slider, mm"]
    L1: Annotated[Positive, "length of the two rods of leg I, mm"]
    leg23_x_offset: Annotated[
        Number, "D2 - d2 of legs II and III: platform attachment (from P) minus slider, along x, mm"
    ]
    R2: Annotated[Positive, "legs II and III: distance of their platform attachments from P, along y, mm"]
    r4: Annotated[Positive, "legs II and III: distance of their sliders from the middle, along y, mm"]
    L2: Annotated[Positive, "rod length of leg II, mm"]
    L3: Annotated[Positive, "rod length of leg III, mm"]

    def check_together(self) -> None:
        if self.r1 >= self.R1:
            raise ValueError(
                f"r1 = {self.r1:g} must be smaller than R1 = {self.R1:g}, or the rods of leg I always cross"
            )


class SerialModuleFile(Table, frozen=True, kw_only=True):
    """[module] of kind "serial"."""

    zero: Annotated[Point, "P at x = y = z = 0, base frame (z down), mm"]


#: Legs closer together than this, seen from above, hold nothing: the platform would swing about them.
LEG_SEPARATION_DEG: Final = 1.0


class LinearDeltaModuleFile(Table, frozen=True, kw_only=True):
    """[module] of kind "linear_delta"."""

    platform_radius: Annotated[Positive, "distance of the platform's joints from P, mm"]
    base_radius: Annotated[Positive, "distance of the sliders' joints from the z axis of the base frame, mm"]
    rod_length: Annotated[Positive, "length of all six rods, mm"]
    leg_angles_deg: Annotated[Point, "angles of the legs, from x towards y of the base frame"]

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

    platform: Annotated[Point, "joint on the platform, from P, mm"]
    slider: Annotated[Point, "joint on the slider at 0, base frame, mm"]
    rail: Annotated[Point, "direction of the rail"]
    length: Annotated[Positive, "length of the rod, mm"]
    by: Annotated[Literal["rho1", "rho2", "rho3"], "the slider that moves the rod"]

    def check_together(self) -> None:
        expect_direction("rail", self.rail)


class RodsModuleFile(Table, frozen=True, kw_only=True):
    """[module] of kind "rods"."""

    home: Annotated[Point, "P at home, base frame, which decides the assembly mode, mm"]
    home_mm: Annotated[Point, "approximate sliders at home; they say on which side of its slider each rod is"]
    rod: Annotated[list[RodFile], Meta(min_length=6, max_length=6), "the six rods"]
    largest_tilt_deg: Annotated[float, Meta(gt=0, lt=90), "a platform that tilts more is in another assembly mode"] = (
        60.0
    )

    def check_together(self) -> None:
        idle = sorted({"rho1", "rho2", "rho3"} - {rod.by for rod in self.rod})
        if idle:
            raise ValueError(f"rod: none is moved by {', '.join(idle)}")


class SpindleFile(Table, frozen=True, kw_only=True):
    """[spindle]."""

    nose_offset_mm: Annotated[Number, "from P along the tool axis to the gauge line"]
    max_speed_rpm: Annotated[Positive | None, "greatest speed of the spindle"] = None


class TableFile(Table, frozen=True, kw_only=True):
    """[table]."""

    pivot: Annotated[Point, "a point on the tilt axis, base frame (z down), mm"]
    rotary_offset: Annotated[Point, "from the pivot to the rotary centre on the table face, at A = 0, z up, mm"]
    machine_zero: Annotated[Point, "from the rotary centre to the origin of machine coordinates, at A = 0, z up, mm"]
    radius: Annotated[Positive, "radius of the table face, mm"]
    a_positive: Annotated[Sense, "a positive A turns the part, or the tool against the part"] = "workpiece"
    c_positive: Annotated[Sense, "a positive C turns the part, or the tool against the part"] = "workpiece"


class HomeFile(Table, frozen=True, kw_only=True):
    """[home]."""

    g28: Annotated[Pose, "x, y, z and the rotary axes where G28 and --from home go, mm and degrees"]
    g30: Annotated[Pose, "x, y, z and the rotary axes where G30 goes, mm and degrees"]
    park: Annotated[Pose | None, "x, y, z and the rotary axes where --to park goes, mm and degrees"] = None


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

    checks: ClassVar[Checks] = {"a_deg": check_range, "c_deg": check_range}

    a_deg: Annotated[Travel, "tilt travel, in the sense of this file"]
    c_deg: Annotated[Travel | None, "rotary travel, in the sense of this file; unlimited without it"] = None
    a_velocity: Annotated[Positive, "greatest velocity, degrees/s"]
    a_acceleration: Annotated[Positive, "greatest acceleration, degrees/s2"]
    a_jerk: Annotated[Positive | None, "greatest jerk, degrees/s3; not limited without it"] = None
    c_velocity: Annotated[Positive, "greatest velocity, degrees/s"]
    c_acceleration: Annotated[Positive, "greatest acceleration, degrees/s2"]
    c_jerk: Annotated[Positive | None, "greatest jerk, degrees/s3; not limited without it"] = None


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
    jerk = Annotated[PerActuator | None, "greatest jerk, mm/s3; not limited without it"]
    drop = Annotated[NotNegative, "smallest drop of a rod: the distance between its two ends along the rail"]
    fields: list[Any] = [
        (f"{group}_mm", Annotated[PerActuatorRange, "travel of the actuators, one for all or a list of three"]),
        (f"{group}_velocity", Annotated[PerActuator, "greatest velocity, mm/s"]),
        (f"{group}_acceleration", Annotated[PerActuator, "greatest acceleration, mm/s2"]),
        (f"{group}_jerk", jerk, None),
    ]
    if rods:
        measure = Annotated[Positive | None, "smallest measure of the parallel Jacobian"]
        fields += [("serial_singularity_mm", drop), ("parallel_singularity", measure, None)]
    namespace = {"checks": {**LimitsFile.checks, f"{group}_mm": check_ranges}}
    made = defstruct("LimitsFile", fields, bases=(LimitsFile,), namespace=namespace, frozen=True, kw_only=True)
    return cast("type[LimitsFile]", made)


PerLeg = Positive | Annotated[list[Positive], Meta(min_length=3, max_length=3)]
Cone = Annotated[float, Meta(gt=0, lt=180)]


class RodsFile(Table, frozen=True, kw_only=True):
    """[rods] of every kind: sizes of rods and ball joints; a kind adds where its rods are."""

    diameter_mm: Annotated[PerLeg | None, "of the rods: one value, or a list of three for legs I, II, III"] = None
    slider_cone_deg: Annotated[
        Cone | None, "half angle of the cone in which a ball joint at the slider lets its rod move"
    ] = None
    platform_cone_deg: Annotated[
        Cone | None, "half angle of the cone in which a ball joint at the platform lets its rod move"
    ] = None
    cone_centre: Annotated[
        Point | None, "platform position, base frame, at which the rods are in the middle of their cones, mm"
    ] = None

    def check_together(self) -> None:
        cones = self.slider_cone_deg is not None or self.platform_cone_deg is not None
        if cones != (self.cone_centre is not None):
            raise ValueError("cone_centre and slider_cone_deg or platform_cone_deg belong together")


class VerneRodsFile(RodsFile, frozen=True, kw_only=True):
    """[rods] of kind "verne"."""

    leg1_slider_x: Annotated[Number, "x of the slider's joints of leg I, base frame, mm"]
    leg23_slider_x: Annotated[Number, "x of the slider's joints of legs II and III, base frame, mm"]
    leg23_spacing: Annotated[Positive, "distance of the two rods of a parallelogram, along x, mm"]


class TolerancesFile(Table, frozen=True, kw_only=True):
    """[tolerances]: standard deviations of the parts as made, mm and mrad; a key for parts of their own."""

    lengths_mm: Annotated[Positive, "of every position and length without its own key"] = 0.05
    directions_mrad: Annotated[Positive, "of every direction without its own key, mrad"] = 0.1
    platform_ends_mm: Annotated[Positive | None, "of platform_ends_mm in [as_built]; without it lengths_mm"] = None
    slider_ends_mm: Annotated[Positive | None, "of slider_ends_mm in [as_built]; without it lengths_mm"] = None
    rod_lengths_mm: Annotated[Positive | None, "of rod_lengths_mm in [as_built]; without it lengths_mm"] = None
    guides_mrad: Annotated[Positive | None, "of guides_mrad in [as_built], mrad; without it directions_mrad"] = None
    tilt_axis_mm: Annotated[Positive | None, "of tilt_axis_mm in [as_built]; without it lengths_mm"] = None
    tilt_axis_mrad: Annotated[Positive | None, "of tilt_axis_mrad in [as_built], mrad; without it directions_mrad"] = (
        None
    )
    rotary_axis_mm: Annotated[Positive | None, "of rotary_axis_mm in [as_built]; without it lengths_mm"] = None
    rotary_axis_mrad: Annotated[
        Positive | None, "of rotary_axis_mrad in [as_built], mrad; without it directions_mrad"
    ] = None
    spindle_axis_mrad: Annotated[
        Positive | None, "of spindle_axis_mrad in [as_built], mrad; without it directions_mrad"
    ] = None


class ClearanceFile(Table, frozen=True, kw_only=True):
    """[clearance]: smallest distance between bodies, and the bodies other than rods."""

    minimum_mm: Annotated[NotNegative, "smallest distance: rod to rod, rod to spindle, spindle or tool to table"]
    spindle_diameter_mm: Annotated[
        Positive | None, "diameter of the spindle, a capsule that starts at the gauge line"
    ] = None
    spindle_top_mm: Annotated[NotNegative, "height of its upper end above the platform point P"] = 0.0
    tool_diameter_mm: Annotated[Positive | None, "diameter of the largest tool"] = None
    platform_ends_mm: Annotated[
        Annotated[list[Point], Meta(min_length=2, max_length=2)] | None,
        "the platform as a capsule between these two points, platform frame (z down)",
    ] = None
    platform_diameter_mm: Annotated[Positive | None, "of that capsule"] = None

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

    checks: ClassVar[Checks] = {"lead_error": check_lead_error}

    unit: Annotated[
        str,
        Meta(pattern=r"^[A-Za-z][A-Za-z0-9]*$", description="letters and digits, a letter first"),
        "name of the numbers, for the heading",
    ]
    sign: Annotated[Literal[1, -1], "-1 where the drive counts the other way"] = 1
    zero: Annotated[Number, "where the drive reads 0, mm or degrees"] = 0.0
    scale: Annotated[Positive, "numbers per mm or degree"] = 1.0
    integer: Annotated[bool, "whether the drive takes whole numbers"] = False
    lead_error: Annotated[
        Annotated[list[Range], Meta(min_length=2)] | None,
        "measured error at commanded positions, rising: [position, error] in mm or degrees",
    ] = None


class AccuracyFile(Table, frozen=True, kw_only=True):
    """[accuracy]."""

    tip_mm: Annotated[Positive, "how far blended corners may leave the path of the tip"] = 0.01
    axis_deg: Annotated[Positive, "how far blended corners may leave the tool axis"] = 0.05
    uncorrected_axis_deg: Annotated[
        Positive | None, "with [as_built]: largest error of the tool axis that the rotary axes cannot correct"
    ] = None


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

    checks: ClassVar[Checks] = {"modes": check_modes}

    modes: Annotated[
        list[Range], Meta(min_length=1, max_length=4), "vibration modes: [frequency in Hz, damping ratio 0 to 0.5]"
    ]
    shaper: Annotated[Shaper | None, "input shaper, unless --shaper says otherwise"] = None


class ControlFile(Table, frozen=True, kw_only=True):
    """[control]."""

    cycle_s: Annotated[float, Meta(ge=1e-4, le=1.0), "control cycle: time from row to row of a setpoint file"]


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

    schema: Annotated[Literal[1, 2], "version of this format"]
    name: Annotated[str, Meta(min_length=1), "of the machine, in summaries and reports"]
    kind: Annotated[str, "the mechanism that moves the spindle"]
    module: Annotated[dict[str, object], "sizes of the parallel module"]
    spindle: Annotated[SpindleFile, "the spindle on the platform"]
    table: Annotated[TableFile, "the tilting rotary table"]
    home: Annotated[HomeFile | None, "positions of G28, G30 and --to park"] = None
    limits: Annotated[dict[str, object], "travel, velocity, acceleration and jerk of the joints"]
    accuracy: Annotated[AccuracyFile | None, "tolerance of blended corners"] = None
    rods: Annotated[dict[str, object] | None, "sizes of rods and ball joints"] = None
    as_built: Annotated[object, "deviations of the parts of the machine as built"] = None
    tolerances: Annotated[TolerancesFile | None, "standard deviations of the parts as made, before a calibration"] = (
        None
    )
    clearance: Annotated[ClearanceFile | None, "smallest distance between bodies, and their sizes"] = None
    bodies: Annotated[dict[Literal["spindle", "platform"], BodyFile] | None, "meshes of spindle and platform"] = None
    drives: Annotated[dict[str, DriveFile] | None, "how the drives count, by joint"] = None
    vibration: Annotated[VibrationFile | None, "vibration modes, and the input shaper for them"] = None
    control: Annotated[ControlFile, "the control"]
    provenance: Annotated[ProvenanceFile, "where the values of each table are from"]

    def check_together(self) -> None:
        for group in ("home", "accuracy", "rods", "tolerances", "clearance", "bodies", "drives", "vibration"):
            if getattr(self, group) is not None and getattr(self.provenance, group) is None:
                raise ValueError(f"provenance.{group} is missing: every group says where it is from")
