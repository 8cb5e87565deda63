"""Diameters of tools that are half or twice those in the remarks of the program."""

import math
import re
from collections.abc import Iterator
from itertools import islice
from typing import Final

from verne_post.base.long_text import Text, decode_lines
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.remarks import find_tool_diameters, find_tool_remarks
from verne_post.model.findings import Finding, make_finding
from verne_post.model.moves import Moves
from verne_post.model.options import Options
from verne_post.model.part_setup import describe_tool_number, list_setup_names

#: Posts list the tools at the top of a program.
_HEAD_LINES: Final = 400
#: Tools are ground again, and still tell a radius from a diameter.
_NEARLY: Final = 0.05
#: Parts of a tool whose diameter is another one.
_PARTS: Final = re.compile(
    r"\b(?:SHANK|SHAFT|NECK|TIP|CHAMFER|PILOT|STEP|HOLDER|BODY|SCHAFT|HALS|SPITZE|FASE|FASEN\w*|STUFEN\w*)\b",
    re.IGNORECASE,
)
_CORRECT_DIAMETER: Final = (
    "Correct the diameter in the set-up or the tool table, or the remark. No action is needed if both are meant."
)
_SIZE: Final = re.compile(r"(?<!\w)(?:D\d?|DIA\w*)\W{0,4}\d|\u00d8", re.IGNORECASE)


def check_diameters(source: Text, moves: Moves, options: Options) -> Iterator[Finding]:
    """VP505: a tool whose diameter is that of its remark as a radius, or the other way round."""
    sizes = {number: tool.diameter for number, tool in (options.tools or {}).items() if tool.diameter > 0.0}
    if not sizes:
        return
    names = {**list_setup_names(options.control), **moves.name_tools()}
    head = list(islice(decode_lines(source), _HEAD_LINES))
    dialect = choose_dialect_name(options.dialect, source, options.source_name)
    remarks = {key: text for key, text in find_tool_remarks(head, dialect).items() if not _may_name_a_part(text)}
    named = find_tool_diameters("\n".join(head).encode(), remarks)
    for number, size in sizes.items():
        said = named.get(str(number), named.get(names.get(number, "")))
        if said is not None and any(math.isclose(size, said * by, rel_tol=_NEARLY) for by in (0.5, 2.0)):
            what = "half" if size < said else "twice"
            text = (
                f"{describe_tool_number(number, names)}: a diameter of {size:g} mm is {what} the {said:g} mm that the "
                "program's remark about it names; a diameter is meant here, and no radius"
            )
            yield make_finding("VP505", text, advice=_CORRECT_DIAMETER)


def _may_name_a_part(remark: str) -> bool:
    """Whether the diameter in a remark may be that of another part of the tool, or one of two."""
    return _PARTS.search(remark) is not None or len(_SIZE.findall(remark)) > 1
