"""The extended tool table (``--tool-shapes``): cutter, shank and holder of each tool. Every error names file, key and value."""

from typing import Annotated

from msgspec import Meta

from verne_post.base.numbers import is_count
from verne_post.config.sentences import Table, WrongTableError, check_table
from verne_post.config.toml_text import read_toml
from verne_post.model.findings import InputError, finding
from verne_post.model.part_setup import MAX_TOOL, TOOL_PARTS, Cylinder, ToolShape

Size = Annotated[float, Meta(gt=0, le=MAX_TOOL)]


class PartFile(Table, frozen=True, kw_only=True):
    """One cylinder; without a length it goes up to the gauge line."""

    diameter: Size
    length: Size | None = None


class ToolFile(Table, frozen=True, kw_only=True):
    """[tool.N], parts from the tip upwards."""

    cutter: PartFile
    shank: PartFile | None = None
    holder: PartFile | None = None


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
        file = check_table(ShapesFile, data, "a file of tool shapes")
    except WrongTableError as error:
        raise InputError(*(finding("VP504", f"{name}: {text}") for text in error.sentences)) from None
    except ValueError as error:
        raise InputError(finding("VP504", f"{name}: {error}")) from None
    shapes = {}
    for key, tool in file.tool.items():
        if not (is_count(key) and key == str(int(key))):
            raise InputError(finding("VP504", f"{name}: tool.{key}: expected the number of a tool, as in [tool.3]"))
        parts = [(part, getattr(tool, part)) for part in TOOL_PARTS if getattr(tool, part) is not None]
        for part, one in parts[:-1]:
            if one.length is None:
                text = (
                    f"{name}: tool.{key}.{part} needs a length: only the last part goes up to the gauge line by itself"
                )
                raise InputError(finding("VP504", text))
        shapes[int(key)] = tuple(Cylinder(part, one.diameter, one.length) for part, one in parts)
    return shapes
