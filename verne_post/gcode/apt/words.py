"""Statements of cutter location text that do nothing for the axes, and those that are refused by their names."""

from collections.abc import Mapping
from typing import Final

#: Names of the part, remarks of the CAM system, and how closely it computed its points.
REMARKS: Final = (
    "PARTNO",
    "MACHIN",
    "REMARK",
    "INTOL",
    "OUTTOL",
    "TOLER",
    "LINTOL",
    "CUTTER",
    "SEQNO",
    "LEADER",
    "DISPLY",
)
#: What is for the display of a CAM system or for a post-processor: `dump moves` shows each word once as without effect.
WITHOUT_EFFECT: Final = (
    "PAINT",
    "TLDATA",
    "CAMERA",
    "PPWORD",
    "TPRINT",
    "AUTOPS",
    "PSIS",
    "SETUP",
    "CSI_SET_FLUTE_LENGTH",
    "CSI_SET_EXTENSION_LENGTH",
    "SELCTL",
    "REWIND",
    "ISN",
    "CLPRNT",
    "NOPOST",
    "FLUSH",
)
#: What they are.
FOR_OTHERS: Final = "it is for the display of a CAM system, or for another post-processor"
#: Descriptions of tools leave words out between two commas.
MAY_HAVE_GAPS: Final = frozenset((*REMARKS, *WITHOUT_EFFECT, "TOOLNO"))

_SPLINE: Final = (
    "splines of cutter location text are not executed; let the CAM system write lines and arcs (motion output)"
)
_LATHE: Final = "the statement is for lathes"
_PLANE: Final = "retraction planes are not executed; let the CAM system write RAPID and GOTO"
_RAW: Final = "it puts a code into the program of a control; write what it means, an M code as AUXFUN/m"
_AXES: Final = "it moves single axes of one machine; write GOTO with the tool axis, or ROTABL/a,AAXIS,c,CAXIS"
_PROBE: Final = "probing is not executed; leave the operation out"
#: Statement -> why it is not executed, and what would be right.
REFUSED_WORDS: Final[Mapping[str, str]] = {
    **dict.fromkeys(("NURBS", "KNOT", "CNTRL", "SPLINE"), _SPLINE),
    **dict.fromkeys(("THREAD", "TURRET", "CHUCK", "SWITCH"), _LATHE),
    **dict.fromkeys(("RETRCT", "CLEARP", "CLRSRF"), _PLANE), **dict.fromkeys(("PREFUN", "PPFUN", "LETTER"), _RAW),
    **dict.fromkeys(("ROTHED", "ROTATE", "MOVETO"), _AXES), **dict.fromkeys(("PROBE", "DMIS"), _PROBE),
    "COPY": "copies of a path are not executed; let the CAM system write every path, or use DEFSUB, CALSUB and TRACUT",
    "INDEX": "copies of a path are not executed; let the CAM system write every path, or use DEFSUB, CALSUB and TRACUT",
    "GOFWD": "the arc has no TLON before; write TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/x,y,z,x,y,z), or CIRCLE and GOTO",
    "COUPLE": "the feed of taps is not executed; let the CAM system write points, or mill the thread",
}  # fmt: skip
