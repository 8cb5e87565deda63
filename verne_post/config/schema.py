"""The machine file as a schema: keys, types, bounds. docs/machine-file.md says what they mean."""

from functools import cache
from itertools import combinations, pairwise
from typing import Annotated, Any, Final, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StringConstraints,
    create_model,
    field_validator,
    model_validator,
)

from verne_post.model.drives import STEEPEST_ERROR
from verne_post.model.vibration import Shaper

#: No length, limit or count of a machine is larger: squares and products of such numbers stay finite.
_LARGEST: Final = 1e12
Number = Annotated[float, Field(ge=-_LARGEST, le=_LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, le=_LARGEST, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, le=_LARGEST, allow_inf_nan=False)]
Point = Annotated[list[Number], Field(min_length=3, max_length=3)]
Pose = Annotated[list[Number], Field(min_length=5, max_length=5)]
Range = Annotated[list[Number], Field(min_length=2, max_length=2)]
Sense = Literal["workpiece", "tool"]
Source = Annotated[str, StringConstraints(pattern=r"^(identified|assumed|measured|specified)\b")]


class Group(BaseModel):
    """A table of the file: no unknown keys, no numbers in quotes."""

    #: Schemas are built when a file is first read with them: a command needs few of them.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, defer_build=True)


def ordered(value: list[float]) -> list[float]:
    """A range has its smaller value first."""
    if value[0] >= value[1]:
        raise ValueError(f"the lower end {value[0]:g} must be below the upper end {value[1]:g}")
    return value


class VerneModuleFile(Group):
    """[module] of kind "verne"."""

    leg1_x_offset: Number
    R1: Positive
    r1: Positive
    L1: Positive
    leg23_x_offset: Number
    R2: Positive
    r4: Positive
    L2: Positive
    L3: Positive

    @model_validator(mode="after")
    def _uncrossed(self) -> "VerneModuleFile":
        if self.r1 >= self.R1:
            raise ValueError(
                f"r1 = {self.r1:g} must be smaller than R1 = {self.R1:g}, or the rods of leg I always cross"
            )
        return self


class SerialModuleFile(Group):
    """[module] of kind "serial"."""

    zero: Point


#: Legs closer together than this, seen from above, hold nothing: the platform would swing about them.
LEG_SEPARATION_DEG: Final = 1.0


class LinearDeltaModuleFile(Group):
    """[module] of kind "linear_delta"."""

    platform_radius: Positive
    base_radius: Positive
    rod_length: Positive
    leg_angles_deg: Point

    @model_validator(mode="after")
    def _stands_on_three_legs(self) -> "LinearDeltaModuleFile":
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
                    f"leg_angles_deg: legs {i} and {j} stand at {one:g} and {other:g} degrees, "
                    f"they must be {LEG_SEPARATION_DEG:g} degree or more apart"
                )
        return self


class SpindleFile(Group):
    """[spindle]."""

    nose_offset_mm: Number


class TableFile(Group):
    """[table]."""

    pivot: Point
    rotary_offset: Point
    machine_zero: Point
    radius: Positive
    a_positive: Sense = "workpiece"
    c_positive: Sense = "workpiece"


class HomeFile(Group):
    """[home]."""

    g28: Pose
    g30: Pose
    park: Pose | None = None


PerActuator = Positive | Annotated[list[Positive], Field(min_length=3, max_length=3)]
PerActuatorRange = Range | Annotated[list[Range], Field(min_length=3, max_length=3)]


def ranges_ordered(value: object) -> object:
    """One range or a list of them: each has its smaller value first."""
    if isinstance(value, list):
        for item in value if isinstance(value[0], list) else [value]:
            ordered(item)
    return value


class LimitsFile(Group):
    """[limits] of the table; :func:`limits_file` adds the actuators of a kind."""

    a_deg: Range
    c_deg: Range | None = None
    a_velocity: Positive
    a_acceleration: Positive
    a_jerk: Positive
    c_velocity: Positive
    c_acceleration: Positive
    c_jerk: Positive

    @field_validator("a_deg", "c_deg")
    @classmethod
    def _ordered(cls, value: object) -> object:
        return ranges_ordered(value)


@cache
def limits_file(group: str, rods: bool) -> type[LimitsFile]:
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
    fields: dict[str, Any] = {f"{group}_mm": (PerActuatorRange, ...)}
    fields |= {f"{group}_{kind}": (PerActuator, ...) for kind in ("velocity", "acceleration", "jerk")}
    if rods:
        fields["serial_singularity_mm"] = (NotNegative, ...)
        fields["parallel_singularity"] = (Positive | None, None)
    checks: dict[str, Any] = {"_ordered_actuators": field_validator(f"{group}_mm")(ranges_ordered)}
    return create_model("LimitsFile", __base__=LimitsFile, __validators__=checks, **fields)


PerLeg = Positive | Annotated[list[Positive], Field(min_length=3, max_length=3)]
Cone = Annotated[float, Field(gt=0, lt=180, allow_inf_nan=False)]


class RodsFile(Group):
    """[rods] of every kind: sizes of rods and ball joints; a kind adds where its rods are."""

    diameter_mm: PerLeg | None = None
    slider_cone_deg: Cone | None = None
    platform_cone_deg: Cone | None = None
    cone_centre: Point | None = None

    @model_validator(mode="after")
    def _cones_have_a_middle(self) -> "RodsFile":
        cones = self.slider_cone_deg is not None or self.platform_cone_deg is not None
        if cones != (self.cone_centre is not None):
            raise ValueError("cone_centre and slider_cone_deg or platform_cone_deg belong together")
        return self


class VerneRodsFile(RodsFile):
    """[rods] of kind "verne"."""

    leg1_slider_x: Number
    leg23_slider_x: Number
    leg23_spacing: Positive


class TolerancesFile(Group):
    """[tolerances]: standard deviations of the parts as made, mm and mrad; a key of [as_built] for parts of their own."""

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


class ClearanceFile(Group):
    """[clearance]: smallest distance between bodies, and the bodies other than rods."""

    minimum_mm: NotNegative
    spindle_diameter_mm: Positive | None = None
    spindle_top_mm: NotNegative = 0.0
    tool_diameter_mm: Positive | None = None
    platform_ends_mm: Annotated[list[Point], Field(min_length=2, max_length=2)] | None = None
    platform_diameter_mm: Positive | None = None

    @model_validator(mode="after")
    def _platform_whole(self) -> "ClearanceFile":
        if (self.platform_ends_mm is None) != (self.platform_diameter_mm is None):
            raise ValueError("platform_ends_mm and platform_diameter_mm belong together")
        return self


class DriveFile(Group):
    """[drives.JOINT]: how one drive counts."""

    unit: Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9]*$")]
    sign: Literal[1, -1] = 1
    zero: Number = 0.0
    scale: Positive = 1.0
    integer: bool = False
    lead_error: Annotated[list[Range], Field(min_length=2)] | None = None

    @field_validator("lead_error")
    @classmethod
    def _rises(cls, value: list[list[float]] | None) -> list[list[float]] | None:
        for (low, error_low), (high, error_high) in pairwise(value or []):
            if high <= low:
                raise ValueError(f"places rise from row to row; {high:g} follows {low:g}")
            if abs(error_high - error_low) > STEEPEST_ERROR * (high - low):
                raise ValueError(
                    f"between {low:g} and {high:g} the error changes by more than {STEEPEST_ERROR:g} of the way: [place, error], both in mm or degrees"
                )
        return value


class AccuracyFile(Group):
    """[accuracy]."""

    tip_mm: Positive = 0.01
    axis_deg: Positive = 0.05
    uncorrected_axis_deg: Positive | None = None


#: A mode of a lower frequency (Hz) would make a machine wait for a second at every stop; one of more damping needs no shaper.
LOWEST_MODE: Final = 1.0
MOST_DAMPING: Final = 0.5


class VibrationFile(Group):
    """[vibration]: modes as [frequency in Hz, damping ratio], and the input shaper for them."""

    modes: Annotated[list[Range], Field(min_length=1, max_length=4)]
    shaper: Shaper | None = None

    @field_validator("modes")
    @classmethod
    def _are_modes(cls, value: list[list[float]]) -> list[list[float]]:
        for frequency, damping in value:
            if not (frequency >= LOWEST_MODE and 0.0 <= damping <= MOST_DAMPING):
                raise ValueError(
                    f"[{frequency:g}, {damping:g}] is no mode: [frequency in Hz, at least {LOWEST_MODE:g}; "
                    f"damping ratio, 0 to {MOST_DAMPING:g}]"
                )
        return value


class ControlFile(Group):
    """[control]."""

    cycle_s: Annotated[float, Field(ge=1e-4, le=1.0, allow_inf_nan=False)]


class ProvenanceFile(Group):
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


def known_schema(value: object) -> object:
    """The version of the file's schema."""
    if type(value) is not int or value != 1:
        raise ValueError("this version reads schema = 1")
    return value


class MachineFile(Group):
    """The file as a whole; ``module`` and ``limits`` are checked against the schemas of its ``kind``."""

    schema_version: Annotated[int, Field(alias="schema"), BeforeValidator(known_schema)]
    name: Annotated[str, Field(min_length=1)]
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
    drives: dict[str, DriveFile] | None = None
    vibration: VibrationFile | None = None
    control: ControlFile
    provenance: ProvenanceFile

    @model_validator(mode="after")
    def _optional_groups_have_a_source(self) -> "MachineFile":
        for group in ("home", "accuracy", "rods", "tolerances", "clearance", "drives", "vibration"):
            if getattr(self, group) is not None and getattr(self.provenance, group) is None:
                raise ValueError(f"provenance.{group} is missing: every group says where it is from")
        return self
