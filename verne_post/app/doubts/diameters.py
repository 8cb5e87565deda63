"""Diameters of tools that are not those in the remarks of the program."""

import math
from collections.abc import Iterator
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.remarked_diameters import NEARLY, list_remarked_diameters
from verne_post.model.findings import Finding, make_finding
from verne_post.model.moves import Moves, list_tool_changes
from verne_post.model.options import Options
from verne_post.model.part_setup import describe_tool_number, list_setup_names

_CORRECT_DIAMETER: Final = (
    "Correct the diameter in the set-up or the tool table, or the remark. No action is needed if both are meant."
)


def check_diameters(source: Text, moves: Moves, options: Options) -> Iterator[Finding]:
    """VP505: a tool whose diameter is that of its remark as a radius, or the other way round, or another one.

    Another one is told where it moves the path, or touches fixtures or a stock.
    """
    sizes = {number: tool.diameter for number, tool in (options.tools or {}).items() if tool.diameter > 0.0}
    if not sizes:
        return
    names = {**list_setup_names(options.control), **moves.name_tools()}
    named = list_remarked_diameters(source, choose_dialect_name(options.dialect, source, options.source_name))
    touches = options.stock is not None or bool(options.keep_out)
    used = moves.radius_tools | ({number for _change, number in list_tool_changes(moves.events)} if touches else set())
    for number, size in sizes.items():
        said = named.get(str(number)) or named.get(names.get(number, ""))
        if said is None:
            continue
        remark = f"the {said.diameter:g} mm that the program's remark{said.describe_line()} names"
        head, text = f"{describe_tool_number(number, names)}: a diameter of {size:g} mm is", ""
        if any(math.isclose(size, said.diameter * by, rel_tol=NEARLY) for by in (0.5, 2.0)):
            what = "half" if size < said.diameter else "twice"
            text = f"{head} {what} {remark}; a diameter is meant here, and no radius"
        elif number in used and said.is_other_than(size):
            text = f"{head} not {remark}"
        if text:
            yield make_finding("VP505", text, advice=_CORRECT_DIAMETER)
