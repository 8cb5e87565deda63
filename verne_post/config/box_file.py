"""Bodies in the file of a set-up: fixtures and stock as boxes, and the nominal part."""

from typing import Annotated, ClassVar, Final, Literal

from msgspec import Meta

from verne_post.config.sentences import Checks, Table
from verne_post.model.part_setup import MAX_PLACE, MAX_TOOL, SYSTEM_NUMBERS, Box, NominalPart, Wanted

Point = Annotated[list[Annotated[float, Meta(ge=-MAX_PLACE, le=MAX_PLACE)]], Meta(min_length=3, max_length=3)]

Depth = Annotated[float, Meta(gt=0, le=MAX_TOOL)]
_ASKED: Final = Wanted()


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


class PartFile(Table, frozen=True, kw_only=True):
    """[part]: the part as it should be, an STL in a work system, and which deviations count."""

    checks: ClassVar[Checks] = {"system": check_system}

    nominal: Annotated[str, Meta(min_length=1)]
    system: str
    unit: Literal["mm", "cm", "m", "inch"] = "mm"
    gouge_mm: Depth = _ASKED.gouge
    excess_mm: Depth = _ASKED.excess
    grid_mm: Depth = _ASKED.grid
    search_mm: Depth = _ASKED.search

    def check_together(self) -> None:
        if self.search_mm < max(self.gouge_mm, self.excess_mm):
            raise ValueError(f"search_mm {self.search_mm:g} must not be below gouge_mm and excess_mm")

    def make_part(self, raw: bytes, name: str) -> NominalPart:
        """As the program has it."""
        wanted = Wanted(self.gouge_mm, self.excess_mm, self.grid_mm, self.search_mm)
        return NominalPart(name, raw, SYSTEM_NUMBERS.get(self.system), self.unit, wanted)
