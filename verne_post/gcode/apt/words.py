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
_FEED_UNITS: Final = {
    "MMPM": "the feed rate is in mm/min",
    "IPM": "the feed rate is in inch/min",
    "PERMIN": "the feed rate is per minute, in the unit of UNITS",
    "MMPR": "the feed rate is in mm per turn",
    "IPR": "the feed rate is in inch per turn",
    "PERREV": "the feed rate is per turn, in the unit of UNITS",
}
_NO_MORE: Final = {"NOMORE": "ends it"}
_DIRECTIONS: Final = {
    "CLW": "the spindle turns clockwise (M3)",
    **dict.fromkeys(("CCLW", "CCW"), "the spindle turns counter-clockwise (M4)"),
}
_OF_TOOLS: Final = {
    "TOOL": "a tool is loaded",
    **dict.fromkeys(("ADJUST", "OSETNO"), "register of the length"),
    "LENGTH": "no effect: the length is that of the tool table",
    **dict.fromkeys(("SPINDL", "HOLDER", "MILL", "DRILL", "MANUAL"), "no effect: a fact about the tool"),
}
#: Statement -> words that may follow its slash, and what each says.
WORDS_OF: Final[Mapping[str, Mapping[str, str]]] = {
    "FEDRAT": _FEED_UNITS,
    "SPINDL": {
        "RPM": "the speed is in 1/min",
        **_DIRECTIONS,
        "ON": "the spindle turns (M3, or M4 if it did before)",
        "OFF": "the spindle stops (M5)",
        "RANGE": "gear: no effect",
        **dict.fromkeys(("SFM", "SMM"), "not executed: the speed of a surface; write RPM"),
    },
    "COOLNT": {
        "ON": "the coolant that was on before, or flood (M8)",
        "OFF": "coolant off (M9)",
        "FLOOD": "flood (M8)",
        "MIST": "mist (M7)",
        **dict.fromkeys(("TAP", "THRU", "AIR", "LOW", "MEDIUM", "HIGH"), "no effect: a kind of coolant"),
    },
    "CYCLE": {
        "DRILL": "drilling",
        "FACE": "drilling with a dwell",
        "CSINK": "countersinking",
        **dict.fromkeys(("DEEP", "DEEP2"), "deep-hole drilling, out of the hole after each step"),
        "BRKCHP": "drilling with chip breaking",
        "BORE": "boring, out at feed rate",
        "REAM": "reaming, out at feed rate",
        "TAP": "tapping",
        "OFF": "ends the cycle",
        **_NO_MORE,
        "INIT": "the height above the hole",
        **dict.fromkeys(("DEPTH", "FEDTO"), "depth of the hole"),
        **dict.fromkeys(("CLEAR", "RAPTO"), "height at which the feed rate begins"),
        **dict.fromkeys(("STEP", "INCR", "SUBPECK"), "step in depth"),
        "1STPECK": "first step in depth",
        "DWELL": "dwell at the bottom, seconds",
        **dict.fromkeys(("RETURN", "RTRCTO"), "height of the retract"),
        "AUTO": "the control chooses",
        "TPI": "turns of the thread an inch",
        "PITCH": "pitch of the thread",
        "RATIO": "how many times as fast the tap goes out",
        "ORIENT": "angle of the spindle, degrees",
        "FLOAT": "in a floating holder",
        **dict.fromkeys(("RIGID", "FIXED"), "rigid tapping"),
        **_FEED_UNITS,
    },
    "MULTAX": {"ON": "GOTO may have a tool axis", "OFF": "the tool axis stays"},
    **{key: {"MM": "millimetres", "INCHES": "inches", "INCH": "inches"} for key in ("UNITS", "UNIT")},
    **dict.fromkeys(("LOADTL", "LOAD"), _OF_TOOLS),
    "SELECT": {"TOOL": "the tool of this number"},
    "ROTABL": {"AAXIS": "the angle is that of A", "CAXIS": "the angle is that of C"},
    "CUTCOM": {"OFF": "ends it", "ON": "begins it", "LEFT": "left of the contour", "RIGHT": "right of the contour"},
    "CIRCLE": {"TIMES": "how many turns"},
    "TLON": {
        "CIRCLE": "the circle along which the tool moves",
        "CYLNDR": "the cylinder along which the tool moves",
        "POINT": "its centre",
        "VECTOR": "a direction",
        "LINE": "the line at which the arc ends",
        "PLANE": "the plane at which the arc ends",
        "ON": "the tool ends on it",
        "PERPTO": "normal to",
        "INTOF": "which intersection",
        "TO": "the tool ends before it",
        "PAST": "the tool ends past it",
    },
    **{key: {**_NO_MORE, "OFF": "ends it"} for key in ("TRACUT", "ORIGIN", "TRANS", "CSYS", "MSYS")},
    "TRNTYP": {"WORLD": "points are in the system of the part"},
    **{key: {"REV": "turns of the spindle"} for key in ("DELAY", "DWELL")},
    **{key: {"MILL": "milling", "ABSOL": "absolute coordinates", "MODE": "the mode"} for key in ("MODE", "SET")},
}
_POINT: Final = "x, y, z of the point"
_POINT_AND_AXIS: Final = f"{_POINT}, and i, j, k of the tool axis"
#: Statement or word, and how many numbers follow it (0: any) -> what they are.
NUMBERS_OF: Final[Mapping[tuple[str, int], str]] = {
    **{
        (name, count): text
        for name in ("GOTO", "FROM", "GOHOME")
        for count, text in ((3, _POINT), (6, _POINT_AND_AXIS))
    },
    ("GODLTA", 1): "distance along the tool axis",
    ("GODLTA", 3): "by how much, in x, y, z",
    ("CIRCLE", 7): "x, y, z of the centre, i, j, k of the direction of its axis, and the radius",
    ("INDIRV", 3): "i, j, k of the direction",
    ("TLAXIS", 3): "i, j, k of the tool axis",
    ("LOADTL", 0): "number of the tool",
    ("TOOL", 0): "number of the tool",
    ("FEDRAT", 0): "feed rate",
    ("SPINDL", 0): "spindle speed",
    ("RPM", 0): "spindle speed, 1/min",
    ("AUXFUN", 0): "number of the M code",
    **{(unit, 0): "feed rate" for unit in _FEED_UNITS},
    **dict.fromkeys((("DELAY", 0), ("DWELL", 0)), "how long"),
    **dict.fromkeys((("CALSUB", 0), ("DEFSUB", 0)), "number of the subprogram"),
    ("TRACUT", 12): "the matrix by which points move, row by row",
    ("ROTABL", 0): "angle, degrees",
    ("AAXIS", 0): "angle, degrees",
    ("CAXIS", 0): "angle, degrees",
}
