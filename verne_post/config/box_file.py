"""Bodies in the file of a set-up: fixtures, the stock, and the nominal part."""

from collections.abc import Mapping, Sequence
from typing import Annotated, ClassVar, Final, Literal

from msgspec import Meta

from verne_post.config.sentences import Checks, Table
from verne_post.model.part_setup import (
    MAX_PLACE,
    MAX_TOOL,
    OWN_STOCK,
    SYSTEM_NUMBERS,
    Box,
    FixtureMesh,
    NominalPart,
    OwnStock,
    Wanted,
)

Point = Annotated[list[Annotated[float, Meta(ge=-MAX_PLACE, le=MAX_PLACE)]], Meta(min_length=3, max_length=3)]
Distance = Annotated[float, Meta(ge=0, le=MAX_PLACE)]
Unit = Literal["mm", "cm", "m", "inch"]
Depth = Annotated[float, Meta(gt=0, le=MAX_TOOL)]
_ASKED: Final = Wanted()


def check_system(value: str) -> None:
    """The table, or a work system."""
    if value != "table" and value not in SYSTEM_NUMBERS:
        raise ValueError("expected table, or a work system such as G54")


def _check_corners(low: Sequence[float], high: Sequence[float]) -> None:
    for letter, first, last in zip("xyz", low, high, strict=True):
        if first >= last:
            raise ValueError(f"{letter} of min, {first:g}, must be below that of max, {last:g}")


class BodyFile(Table, frozen=True, kw_only=True):
    """[bodies.NAME] of a machine file: a mesh in the platform frame."""

    file: Annotated[
        str, Meta(min_length=1), "an STL, from the folder of the machine file: one closed body in the platform frame"
    ]
    unit: Annotated[Unit, "unit of the STL"] = "mm"


class FixtureFile(Table, frozen=True, kw_only=True):
    """[keep_out.NAME] and [stock]: a box in the table frame or in a work system of --wcs; or a file in its place."""

    checks: ClassVar[Checks] = {"system": check_system}

    min: Annotated[Point | None, "corner of a box: least x, y, z in mm"] = None
    max: Annotated[Point | None, "corner of a box: greatest x, y, z in mm"] = None
    file: Annotated[Annotated[str, Meta(min_length=1)] | None, "a mesh, from the folder of this file"] = None
    unit: Annotated[Unit | None, "unit of the mesh"] = None
    system: Annotated[str, "from where x, y, z count: the table, or a work system such as G54"] = "table"
    distance_mm: Annotated[Distance, "how near anything may come"] = 0.0

    def check_together(self) -> None:
        box = self.min is not None or self.max is not None
        if box == (self.file is not None):
            raise ValueError("expected min and max of a box, or the file of an STL")
        if self.unit is not None and self.file is None:
            raise ValueError("a unit goes with a file; boxes are in mm")
        if self.file is None:
            if self.min is None or self.max is None:
                raise ValueError(f"{'min' if self.min is None else 'max'} is missing")
            _check_corners(self.min, self.max)

    @property
    def is_own(self) -> bool:
        """Whether a stock is that of the program itself."""
        return self.file == OWN_STOCK

    def make(self, name: str, content: tuple[bytes, str] | None) -> Box | FixtureMesh:
        """As the program has it; ``content`` are bytes and name of the file, where it has one."""
        system = SYSTEM_NUMBERS.get(self.system)
        if content is not None:
            return FixtureMesh(name, content[0], system, self.distance_mm, self.unit or "mm", content[1])
        low, high = tuple(self.min or ()), tuple(self.max or ())
        return Box(name, low, high, system, self.distance_mm)  # type: ignore[arg-type]


def make_stock(stock: FixtureFile | None, content: tuple[bytes, str] | None) -> Box | FixtureMesh | OwnStock | None:
    """The stock of a file of a set-up."""
    if stock is None:
        return None
    return OwnStock(distance=stock.distance_mm) if stock.is_own else stock.make("the stock", content)


def name_fixture_files(fixtures: Mapping[str, FixtureFile], stock: FixtureFile | None) -> dict[str, str]:
    """Key of a set-up or settings file -> the file of a fixture or of the stock that it names."""
    bodies: dict[str, FixtureFile | None] = {f"keep_out.{name}.file": one for name, one in fixtures.items()}
    bodies["stock.file"] = None if stock is not None and stock.is_own else stock
    return {key: one.file for key, one in bodies.items() if one is not None and one.file is not None}


class PartFile(Table, frozen=True, kw_only=True):
    """[part]: the part as it should be, an STL in a work system, and which deviations count."""

    checks: ClassVar[Checks] = {"system": check_system}

    nominal: Annotated[str, Meta(min_length=1), "an STL of the part, from the folder of this file"]
    system: Annotated[str, "from where x, y, z of the STL count: the table, or a work system such as G54"]
    unit: Annotated[Unit, "unit of the STL"] = "mm"
    gouge_mm: Annotated[Depth, "the deepest gouge that is accepted"] = _ASKED.gouge
    excess_mm: Annotated[Depth, "the most excess that is accepted"] = _ASKED.excess
    grid_mm: Annotated[Depth | None, "distance of the points that are compared; 0.2, of a large part more"] = None
    search_mm: Annotated[Depth, "largest deviation that is sought"] = _ASKED.search

    def check_together(self) -> None:
        if self.search_mm < max(self.gouge_mm, self.excess_mm):
            raise ValueError(f"search_mm {self.search_mm:g} must not be below gouge_mm and excess_mm")

    def make_part(self, raw: bytes, name: str) -> NominalPart:
        """As the program has it."""
        wanted = Wanted(self.gouge_mm, self.excess_mm, self.grid_mm, self.search_mm)
        return NominalPart(name, raw, SYSTEM_NUMBERS.get(self.system), self.unit, wanted)
