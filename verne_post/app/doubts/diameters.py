"""Diameters of tools that are not those in the remarks of the program."""

import math
import re
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Final

from verne_post.base.long_text import Text, decode_lines
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.remarks import find_tool_diameters, find_tool_remarks
from verne_post.model.findings import Finding, make_finding
from verne_post.model.moves import Moves, list_tool_changes
from verne_post.model.options import Options
from verne_post.model.part_setup import describe_tool_number, list_setup_names

#: Posts list the tools at the top of a program.
_HEAD_LINES: Final = 400
#: A tool that is ground again, or for which more is left, differs less from its remark, as a share and in mm.
_NEARLY: Final = 0.05
_NEARLY_MM: Final = 0.3
#: Parts of a tool whose diameter is another one.
_PARTS: Final = re.compile(
    r"\b(?:SHANK|SHAFT|NECK|TIP|CHAMFER|PILOT|STEP|HOLDER|BODY|SCHAFT|HALS|SPITZE|FASE|FASEN\w*|STUFEN\w*)\b",
    re.IGNORECASE,
)
#: Words of tools that do not cut with their largest diameter: the set-up may have that where they cut.
_TAPERED_BY_LANGUAGE: Final = {
    "English": r"\bTAPER|\bENGRAV|\bCOUNTERS|\bC-?SINK|\bCSK\b|\bCENT(?:ER|RE)[ -]?DRILL|\bDOVETAIL|\bTHREAD|\bTAP\b"
    r"|\bFORM|\bSPOT|\bCONE|\bCONICAL|\bDE-?BURR|\bV[ -]?(?:BIT|CARV|CUTTER)",
    "German": r"KEGEL|\bKONUS|\bKONISCH|SENKER|ANBOHR|ZENTRIER|\bGRAVIER|STICHEL|ENTGRAT|GEWINDE|SCHWALBENSCHWANZ",
    "French": r"\bCONIQUE|\bFRAISURE|CHANFREIN|\bCENTR(?:ER|AGE)|\bPOINTE[RU]|\bGRAV(?:ER|EUR|URE|OIR)|BAVUR|\bTARAUD"
    r"|\bFILETE?R|\bARONDE",
    "Italian": r"\bCONIC[AO]|\bSVASA|\bCENTR(?:O\b|INO|ATORE)|\bINCI[DS]|\bSBAVA|\bSMUSS|\bMASCHI|\bFILETTA|\bRONDINE",
    "Spanish": r"\bC\u00d3NIC[AO]|AVELLANA|\bCENTR(?:AR|OS)|\bPUNTEA|\bGRABA|\bDESBARBA|\bREBABA|\bCHAFL|\bMACHO"
    r"|\bROSCA|\bMILANO",
}
_TAPERED: Final = re.compile("|".join(_TAPERED_BY_LANGUAGE.values()), re.IGNORECASE)
_CORRECT_DIAMETER: Final = (
    "Correct the diameter in the set-up or the tool table, or the remark. No action is needed if both are meant."
)
_SIZE: Final = re.compile(r"(?<!\w)(?:D\d?|DIA\w*)\W{0,4}\d|\u00d8", re.IGNORECASE)


def check_diameters(source: Text, moves: Moves, options: Options) -> Iterator[Finding]:
    """VP505: a tool whose diameter is that of its remark as a radius, or the other way round, or another one.

    Another one is told where it moves the path, or touches fixtures or a stock.
    """
    sizes = {number: tool.diameter for number, tool in (options.tools or {}).items() if tool.diameter > 0.0}
    if not sizes:
        return
    names = {**list_setup_names(options.control), **moves.name_tools()}
    head = list(islice(decode_lines(source), _HEAD_LINES))
    dialect = choose_dialect_name(options.dialect, source, options.source_name)
    remarks = {key: text for key, text in find_tool_remarks(head, dialect).items() if not _may_name_a_part(text)}
    named = find_tool_diameters("\n".join(head).encode(), remarks)
    touches = options.stock is not None or bool(options.keep_out)
    used = moves.radius_tools | ({number for _change, number in list_tool_changes(moves.events)} if touches else set())
    for number, size in sizes.items():
        key = str(number) if str(number) in named else names.get(number, "")
        said = named.get(key)
        if said is None:
            continue
        remark = remarks[key]
        line = next((f" in line {at}" for at, text in enumerate(head, start=1) if remark in text), "")
        head_of_text, text = f"{describe_tool_number(number, names)}: a diameter of {size:g} mm is", ""
        if any(math.isclose(size, said * by, rel_tol=_NEARLY) for by in (0.5, 2.0)):
            what = "half" if size < said else "twice"
            text = (
                f"{head_of_text} {what} the {said:g} mm that the program's remark{line} names; a diameter is meant "
                "here, and no radius"
            )
        elif (
            number in used
            and abs(size - said) > max(_NEARLY * said, _NEARLY_MM)
            and _TAPERED.search(remark) is None
            and not _is_bare(remark, said, head)
        ):
            text = f"{head_of_text} not the {said:g} mm that the program's remark{line} names"
        if text:
            yield make_finding("VP505", text, advice=_CORRECT_DIAMETER)


def _is_bare(remark: str, diameter: float, head: Sequence[str]) -> bool:
    """Whether a diameter may be an entry of the tool table: a D alone, and the program has this D."""
    word = rf"(?<![A-Z_])D0*{diameter:g}(?![\d.])"
    return re.search(word, remark, re.IGNORECASE) is not None and any(
        re.search(rf"^[^(;]*{word}", line, re.IGNORECASE) for line in head
    )


def _may_name_a_part(remark: str) -> bool:
    """Whether the diameter in a remark may be that of another part of the tool, or one of two."""
    return _PARTS.search(remark) is not None or len(_SIZE.findall(remark)) > 1
