"""A box in a file: fixtures and stock."""

from typing import Annotated, ClassVar

from msgspec import Meta

from verne_post.config.sentences import Checks, Table
from verne_post.model.part_setup import MAX_PLACE, SYSTEM_NUMBERS, Box

Point = Annotated[list[Annotated[float, Meta(ge=-MAX_PLACE, le=MAX_PLACE)]], Meta(min_length=3, max_length=3)]


def check_system(value: str) -> None:
    """The table, or a work system."""
    if value != "table" and value not in SYSTEM_NUMBERS:
        raise ValueError("expected table, or a work system such as G54")


class BoxFile(Table, frozen=True, kw_only=True):
    """[keep_out.NAME] and [stock]: a box in the table frame, or in a work system as --wcs gives it."""

    checks: ClassVar[Checks] = {"system": check_system}

    min: Point
    max: Point
    system: str = "table"
    distance_mm: Annotated[float, Meta(ge=0, le=MAX_PLACE)] = 0.0

    def check_together(self) -> None:
        for letter, low, high in zip("xyz", self.min, self.max, strict=True):
            if low >= high:
                raise ValueError(f"{letter} of min, {low:g}, must be below that of max, {high:g}")

    def box(self, name: str) -> Box:
        """As the program has it."""
        low, high = tuple(self.min), tuple(self.max)
        return Box(name, low, high, SYSTEM_NUMBERS.get(self.system), self.distance_mm)  # type: ignore[arg-type]
