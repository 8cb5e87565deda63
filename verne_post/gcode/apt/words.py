"""Statements of cutter location text that do nothing for the axes, and those that are refused by their names."""

from collections.abc import Mapping
from typing import Final

#: Statement -> what it does.
STATEMENTS: Final[Mapping[str, str]] = {
    "GOTO": "moves to a point, or along the arc of a CIRCLE before it",
    "GODLTA": "moves by an increment, or by a distance along the tool axis",
    "FROM": "rapid traverse to the start position",
    "GOHOME": "moves to the home position of the machine; with x, y, z in a TOOL PATH to a point of the part, "
    "in rapid traverse",
    "RAPID": "the next move is in rapid traverse",
    "CIRCLE": "the next GOTO is an arc",
    "INDIRV": "gives the direction in which the next TLON begins",
    "TLON": "moves along an arc to the end of its line",
    "CYCLE": "the points that follow are holes of this cycle; after one with its own feed rate, that from "
    "before comes back",
    "MULTAX": "says whether GOTO may have another tool axis than the one before",
    "TLAXIS": "sets the tool axis from here on",
    "TRACUT": "moves the points that follow by a matrix",
    "MSYS": "names the system in which points are; the work offset is that of the first",
    "TRNTYP": "TRNTYP/WORLD,0,0,0: all points are in one system",
    "CSYS": "says how an operation lies in the system of the points; one that would move them is refused",
    **dict.fromkeys(("ORIGIN", "TRANS"), "shifts nothing: one that would shift points is refused"),
    "ROTABL": "The table turns at rapid traverse while the tool tip stays at its place of the part",
    "TOOL PATH": "TOOL PATH/name,TOOL,name: an operation and its tool",
    "END-OF-PATH": "the end of an operation",
    **dict.fromkeys(
        ("$$-> CSYS", "$$*CATIA0"),
        "Check remarks of Creo and CATIA about the system of points in the model: a change would move the points",
    ),
    "FEDRAT": "sets the feed rate: a number and its unit, in either order, as FEDRAT/600,MMPM",
    **dict.fromkeys(("UNITS", "UNIT"), "says whether points are in mm or inches from here on"),
    **dict.fromkeys(("LOADTL", "LOAD"), "changes the tool; its length may be in the same statement"),
    "TOOLNO": "changes the tool where it has its number alone; else it describes the tool of the next LOADTL",
    "SELECT": "SELECT/TOOL,n: the magazine prepares the next tool",
    "SPINDL": "switches the spindle on at a speed, clockwise (CLW) or counter-clockwise (CCLW), or off; its "
    "words may stand in any order",
    "COOLNT": "switches coolant: mist, flood, off (M7, M8, M9)",
    **dict.fromkeys(("DELAY", "DWELL"), "waits so many seconds, or turns of the spindle"),
    "STOP": "stops until the operator starts again (M0)",
    "OPSTOP": "stops only with --optional-stop (M1)",
    **dict.fromkeys(("FINI", "END"), "ends the program (M30)"),
    "DEFSUB": "begins a subprogram, which CALSUB runs",
    "ENDSUB": "ends a subprogram",
    "CALSUB": "runs a subprogram",
    "PPRINT": "a message to the operator",
    "AUXFUN": "an M code: AUXFUN/8 is M8",
    "INSERT": "text for the control; refused, or shown, as the set-up says",
    "CUTCOM": "ends the cutter compensation; it may begin only where points are those of the tool's centre, and"
    " nothing is left to correct",
    **dict.fromkeys(("MODE", "SET"), "milling and absolute coordinates, which are always active"),
}
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
