"""The extended tool table (``--tool-shapes``): cutter, shank, holder of each tool. Errors name file, key and value."""

from typing import Annotated

from msgspec import Meta

from verne_post.base.numbers import is_count
from verne_post.config.sentences import Table, WrongTableError, check_table
from verne_post.config.toml_text import read_toml
from verne_post.model.findings import InputError, make_finding, make_input_error
from verne_post.model.part_setup import MAX_TOOL, TOOL_PARTS, Cylinder, ToolShape, describe_mistake

Size = Annotated[float, Meta(gt=0, le=MAX_TOOL)]
#: Radius and height above the lower end of a part, mm.
Point = Annotated[list[Annotated[float, Meta(ge=0, le=MAX_TOOL)]], Meta(min_length=2, max_length=2)]


class PartFile(Table, frozen=True, kw_only=True):
    """One part; without a length it goes up to the gauge line. What each key means: :class:`Cylinder`."""

    diameter: Size | None = None
    length: Size | None = None
    corner_radius: Annotated[float, Meta(ge=0, le=MAX_TOOL)] = 0.0
    taper: Annotated[float, Meta(ge=-80, le=80)] = 0.0
    point_angle: Annotated[float, Meta(ge=0, lt=180)] = 0.0
    tip_diameter: Annotated[float, Meta(ge=0, le=MAX_TOOL)] = 0.0
    neck_diameter: Annotated[float, Meta(ge=0, le=MAX_TOOL)] = 0.0
    profile: Annotated[list[Point], Meta(min_length=2, max_length=1000)] | None = None

    def check_together(self) -> None:
        if (self.diameter is None) == (self.profile is None):
            raise ValueError("expected a diameter, or a profile = [[radius, height], ...], which has its own")
        if mistake := describe_mistake(self.shape("cutter")):
            raise ValueError(mistake)

    def shape(self, part: str) -> Cylinder:
        """As the program has it."""
        profile = tuple((one[0], one[1]) for one in self.profile or ())
        return Cylinder(
            part,
            2.0 * max(one[0] for one in profile) if self.diameter is None else self.diameter,
            self.length if not profile or self.length is not None else profile[-1][1],
            self.corner_radius,
            self.taper,
            self.point_angle,
            self.tip_diameter,
            self.neck_diameter,
            profile,
        )


class ToolFile(Table, frozen=True, kw_only=True):
    """[tool.N], parts from the tip upwards; the holder may have several."""

    cutter: PartFile
    shank: PartFile | None = None
    holder: PartFile | Annotated[list[PartFile], Meta(min_length=1, max_length=100)] | None = None


class ShapesFile(Table, frozen=True, kw_only=True):
    """Content of the file."""

    tool: dict[str, ToolFile]


def read_tool_shapes(raw: bytes, name: str) -> dict[int, ToolShape]:
    """Shapes of tools by number.

    Raises
    ------
    InputError
        With one finding (VP504) a mistake.
    """
    try:
        data = read_toml(raw)
        if "tool" not in data and (numbers := [key for key in data if is_count(key)]):
            raise ValueError(f"{numbers[0]} is not a key of a file of tool shapes; write [tool.{numbers[0]}]")
        file = check_table(ShapesFile, data, "a file of tool shapes")
    except WrongTableError as error:
        raise InputError(*(make_finding("VP504", f"{name}: {text}") for text in error.sentences)) from None
    except ValueError as error:
        raise make_input_error("VP504", f"{name}: {error}") from None
    shapes = {}
    for key, tool in file.tool.items():
        if not (is_count(key) and key == str(int(key))):
            text = f"{name}: tool.{key}: expected the number of a tool, as in [tool.3]"
            if not is_count(key):
                text += f"; a tool of a name has the number that its set-up gives: [tools.{key}] number = 3"
            raise make_input_error("VP504", text)
        holder = tool.holder if isinstance(tool.holder, list) else [tool.holder]
        listed = zip((*TOOL_PARTS[:2], *[TOOL_PARTS[2]] * len(holder)), (tool.cutter, tool.shank, *holder), strict=True)
        parts = [one.shape(part) for part, one in listed if one is not None]
        for one in parts[:-1]:
            if one.length is None:
                text = (
                    f"{name}: tool.{key}.{one.part} needs a length: only the last part may reach up to the gauge line "
                    "without one"
                )
                raise make_input_error("VP504", text)
        shapes[int(key)] = tuple(parts)
    return shapes
