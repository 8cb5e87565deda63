"""[tools] of a set-up: length and diameter of each tool by its number or its name, in place of a tool table."""

from collections.abc import Mapping
from typing import Annotated, Final, Literal

from msgspec import Meta

from verne_post.config.sentences import Table
from verne_post.model.part_setup import FIRST_NAMED_TOOL, MAX_TOOL, Tool

#: Stands for a size that is still to be measured: the tool is there, and its size is not known.
TO_MEASURE: Final = "measure"

#: A length or a diameter, mm.
Size = Annotated[float, Meta(ge=0, le=MAX_TOOL)] | Literal["measure"]


class InlineTool(Table, frozen=True, kw_only=True):
    """One tool of [tools]; ``number`` is that of a tool which the program calls by its name."""

    length: Size = TO_MEASURE
    diameter: Size = 0.0
    number: Annotated[int, Meta(ge=1)] | None = None


def number_tools(entries: Mapping[str, InlineTool], place: str) -> tuple[dict[int, Tool], dict[str, int]]:
    """Tools by their numbers, and the numbers of those that have names.

    Parameters
    ----------
    entries : mapping
        Number or name -> tool.
    place : str
        Where they stand, for messages.

    Raises
    ------
    ValueError
        Two of them have one number.
    """
    tools: dict[int, Tool] = {}
    names: dict[str, int] = {}
    for key, entry in entries.items():
        number = int(key) if key.isdecimal() else entry.number or FIRST_NAMED_TOOL + len(names)
        if key.isdecimal() and entry.number not in (None, number):
            raise ValueError(f"tools.{key}.number = {entry.number}: the key is its number; leave the other out")
        if number in tools or not number:
            raise ValueError(f"tools.{key}: {f'there is a tool {number} already' if number else 'no tool is tool 0'}")
        if not key.isdecimal():
            names[key] = number
        length, diameter = (0.0 if size == TO_MEASURE else float(size) for size in (entry.length, entry.diameter))
        offset = (0.0, 0.0, length, *(0.0,) * 6)
        tools[number] = Tool(number, number, offset, diameter, place if entry.length == TO_MEASURE else "")
    return tools, names
