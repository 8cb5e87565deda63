"""Diameters of tools that the remarks of a program name."""

import re
from collections.abc import Sequence
from itertools import islice
from typing import Final

from msgspec import Struct

from verne_post.base.long_text import Text, decode_lines
from verne_post.gcode.remarks import find_tool_diameters, find_tool_remarks

#: Posts list the tools at the top of a program.
_HEAD_LINES: Final = 400
#: A tool that is ground again, or for which more is left, differs less from its remark, as a share and in mm.
NEARLY: Final = 0.05
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
_TAPERED_KINDS: Final = re.compile("|".join(_TAPERED_BY_LANGUAGE.values()), re.IGNORECASE)
_SIZE: Final = re.compile(r"(?<!\w)(?:D\d?|DIA\w*)\W{0,4}\d|\u00d8", re.IGNORECASE)


class RemarkedDiameter(Struct, frozen=True):
    """What a remark says of a tool."""

    diameter: float  #: mm
    line: int  #: Of the remark; 0 where that is not known.
    is_certain: bool  #: No other diameter of the tool, nor an entry of the tool table, can be meant.

    def is_other_than(self, size: float) -> bool:
        """Whether a tool with this diameter is another one."""
        return self.is_certain and abs(size - self.diameter) > max(NEARLY * self.diameter, _NEARLY_MM)

    def describe_line(self) -> str:
        """Where it stands."""
        return f" in line {self.line}" if self.line else ""


def list_remarked_diameters(source: Text, dialect: str) -> dict[str, RemarkedDiameter]:
    """Number or name of a tool -> the diameter that the head of a program names."""
    head = list(islice(decode_lines(source), _HEAD_LINES))
    remarks = {key: text for key, text in find_tool_remarks(head, dialect).items() if not _may_name_a_part(text)}
    found = {}
    for key, diameter in find_tool_diameters("\n".join(head).encode(), remarks).items():
        remark = remarks[key]
        line = next((at for at, text in enumerate(head, start=1) if remark in text), 0)
        is_certain = _TAPERED_KINDS.search(remark) is None and not _is_bare(remark, diameter, head)
        found[key] = RemarkedDiameter(diameter, line, is_certain)
    return found


def _is_bare(remark: str, diameter: float, head: Sequence[str]) -> bool:
    """Whether a diameter may be an entry of the tool table: a D alone, and the program has this D."""
    word = rf"(?<![A-Z_])D0*{diameter:g}(?![\d.])"
    return re.search(word, remark, re.IGNORECASE) is not None and any(
        re.search(rf"^[^(;]*{word}", line, re.IGNORECASE) for line in head
    )


def _may_name_a_part(remark: str) -> bool:
    """Whether the diameter in a remark may be that of another part of the tool, or one of two."""
    return _PARTS.search(remark) is not None or len(_SIZE.findall(remark)) > 1
