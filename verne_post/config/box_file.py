"""A box in a file: fixtures and stock."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from verne_post.model.part_setup import SYSTEM_NUMBERS, Box

Point = Annotated[list[Annotated[float, Field(ge=-1e5, le=1e5)]], Field(min_length=3, max_length=3)]


class BoxFile(BaseModel):
    """[keep_out.NAME] and [stock]: a box in the table frame, or in a work system as --wcs gives it."""

    model_config = ConfigDict(extra="forbid", strict=True, defer_build=True)

    min: Point
    max: Point
    system: str = "table"
    distance_mm: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0

    @field_validator("system")
    @classmethod
    def _known(cls, value: str) -> str:
        if value != "table" and value not in SYSTEM_NUMBERS:
            raise ValueError("expected table, or a work system such as G54")
        return value

    @model_validator(mode="after")
    def _not_flat(self) -> "BoxFile":
        for letter, low, high in zip("xyz", self.min, self.max, strict=True):
            if low >= high:
                raise ValueError(f"{letter} of min, {low:g}, must be below that of max, {high:g}")
        return self

    def box(self, name: str) -> Box:
        """As the program has it."""
        low, high = tuple(self.min), tuple(self.max)
        return Box(name, low, high, SYSTEM_NUMBERS.get(self.system), self.distance_mm)  # type: ignore[arg-type]
