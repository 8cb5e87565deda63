"""The machine file as a schema: keys, types, bounds. docs/machine-file.md says what they mean."""

from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints, field_validator, model_validator

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Point = Annotated[list[Number], Field(min_length=3, max_length=3)]
Pose = Annotated[list[Number], Field(min_length=5, max_length=5)]
Range = Annotated[list[Number], Field(min_length=2, max_length=2)]
Sense = Literal["workpiece", "tool"]
Source = Annotated[str, StringConstraints(pattern=r"^(identified|assumed|measured|specified)\b")]


class Group(BaseModel):
    """A table of the file: no unknown keys, no numbers in quotes."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


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


PerSlider = Positive | Annotated[list[Positive], Field(min_length=3, max_length=3)]


class LimitsFile(Group):
    """[limits]; slider values are one for all or a list of three."""

    rho_mm: Range | Annotated[list[Range], Field(min_length=3, max_length=3)]
    a_deg: Range
    c_deg: Range | None = None
    rho_velocity: PerSlider
    rho_acceleration: PerSlider
    rho_jerk: PerSlider
    a_velocity: Positive
    a_acceleration: Positive
    a_jerk: Positive
    c_velocity: Positive
    c_acceleration: Positive
    c_jerk: Positive
    serial_singularity_mm: NotNegative
    parallel_singularity: Positive | None = None

    @field_validator("rho_mm", "a_deg", "c_deg")
    @classmethod
    def _ordered(cls, value: object) -> object:
        if isinstance(value, list):
            for item in value if isinstance(value[0], list) else [value]:
                ordered(item)
        return value


class AccuracyFile(Group):
    """[accuracy]."""

    tip_mm: Positive = 0.01
    axis_deg: Positive = 0.05


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
    accuracy: Source | None = None


def known_schema(value: object) -> object:
    """The version of the file's schema."""
    if type(value) is not int or value != 1:
        raise ValueError("this version reads schema = 1")
    return value


class MachineFile(Group):
    """The file as a whole; ``module`` is checked against the schema of its ``kind``."""

    schema_version: Annotated[int, Field(alias="schema"), BeforeValidator(known_schema)]
    name: Annotated[str, Field(min_length=1)]
    kind: str
    module: dict[str, object]
    spindle: SpindleFile
    table: TableFile
    home: HomeFile | None = None
    limits: LimitsFile
    accuracy: AccuracyFile | None = None
    control: ControlFile
    provenance: ProvenanceFile

    @model_validator(mode="after")
    def _optional_groups_have_a_source(self) -> "MachineFile":
        for group in ("home", "accuracy"):
            if getattr(self, group) is not None and getattr(self.provenance, group) is None:
                raise ValueError(f"provenance.{group} is missing: every group says where it is from")
        return self
