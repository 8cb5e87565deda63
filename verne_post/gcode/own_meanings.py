"""What one word does, where the tables of its language say what the words of its group do."""

from collections.abc import Mapping
from typing import Final

#: Codes and names of RS274/NGC, Fanuc and Siemens -> what each does.
OWN_MEANINGS: Final[Mapping[str, str]] = {
    "G2": "arc clockwise", "G3": "arc counter-clockwise",
    "G17": "plane XY", "G18": "plane ZX", "G19": "plane YZ",
    "G20": "lengths are inches", "G21": "lengths are millimetres",
    "G70": "lengths are inches", "G71": "lengths are millimetres",
    "G700": "lengths and feed rates are inches", "G710": "lengths and feed rates are millimetres",
    "G40": "cutter compensation off", "G41": "the tool goes left of the contour",
    "G42": "the tool goes right of the contour",
    "G74": "tapping, left-hand thread", "G87": "back boring", "G88": "boring, stops for the operator",
    "G73": "drilling with chip breaking", "G81": "drilling", "G82": "drilling with a dwell at the bottom",
    "G83": "deep-hole drilling, out of the hole after each peck", "G84": "tapping, right-hand thread",
    "G85": "boring, in and out at feed rate", "G86": "boring, out in rapid traverse with the spindle at rest",
    "G89": "boring with a dwell, out at feed rate",
    "G90": "absolute coordinates", "G91": "incremental coordinates",
    "G93": "inverse-time feed", "G94": "feed per minute", "G95": "feed per turn of the spindle",
    "M3": "spindle on, clockwise", "M4": "spindle on, counter-clockwise", "M5": "spindle off",
    "M7": "mist on", "M8": "flood coolant on", "M9": "coolant off",
    "M13": "spindle on, clockwise, with coolant", "M14": "spindle on, counter-clockwise, with coolant",
    "CYCL DEF 200": "drilling", "CYCL DEF 201": "reaming", "CYCL DEF 202": "boring, the spindle stops oriented",
    "CYCL DEF 203": "universal drilling with chip breaking", "CYCL DEF 204": "back boring",
    "CYCL DEF 205": "universal pecking", "CYCL DEF 206": "tapping with a floating holder",
    "CYCL DEF 207": "rigid tapping", "CYCL DEF 208": "bore milling", "CYCL DEF 209": "rigid tapping with chip breaking",
    "CYCL DEF 240": "centring",
    "R0": "radius compensation off", "RL": "the tool goes left of the contour",
    "RR": "the tool goes right of the contour",
    "TRAORI": "tool-centre-point control on", "TRAFOOF": "tool-centre-point control off",
    "CYCLE81": "drilling, centring", "CYCLE82": "drilling with a dwell at the bottom",
    "CYCLE83": "deep-hole drilling in steps", "CYCLE84": "rigid tapping",
    "CYCLE840": "tapping with a floating holder", "CYCLE85": "reaming, in and out at feed rate",
    "CYCLE86": "boring, the spindle stops oriented", "CYCLE89": "boring with a dwell, out at feed rate",
    "CYCLE800": "tilts the work plane, and turns the table to it; without values it ends the plane",
}  # fmt: skip
#: The same by the name of the language, of words that are others in another one.
OF_LANGUAGES: Final[Mapping[str, Mapping[str, str]]] = {
    "RS274/NGC": {
        "G5": "cubic spline", "G5.1": "quadratic spline", "G5.2": "a NURBS begins", "G5.3": "the NURBS ends",
        "G61": "exact path: a stop at corners, none where the path goes on smoothly",
        "G61.1": "exact stop at the end of every move", "G64": "corners are blended, within the tolerance P",
    },
    "Fanuc": {"G64": "corners are blended"},
    "Siemens": {
        "ORIWKS": "the tool axis goes along a great circle", "ORIMKS": "A and C go linearly",
        "TRANS": "shifts the zero; replaces the frame in force",
        "ATRANS": "shifts the zero, from the frame in force on",
        "ROT": "turns coordinates; replaces the frame in force",
        "AROT": "turns coordinates, from the frame in force on",
        "SCALE": "scales coordinates; replaces the frame in force",
        "ASCALE": "scales coordinates, from the frame in force on",
        "MIRROR": "mirrors coordinates; replaces the frame in force",
        "AMIRROR": "mirrors coordinates, from the frame in force on",
        "IF": "executes the lines up to ELSE or ENDIF where the condition holds; with GOTOF, jumps",
        "ELSE": "begins the lines for a condition of IF that does not hold", "ENDIF": "ends IF",
        "FOR": "repeats the lines up to ENDFOR; its variable counts up to the value behind TO",
        "ENDFOR": "adds 1 to the variable of FOR, and goes back unless it is beyond the last value",
        "WHILE": "repeats the lines up to ENDWHILE as long as the condition holds", "ENDWHILE": "goes back to WHILE",
        "LOOP": "repeats the lines up to ENDLOOP until a jump leaves them", "ENDLOOP": "goes back to LOOP",
        "REPEAT": "repeats the lines up to UNTIL; with labels, those lines P times",
        "UNTIL": "goes back to REPEAT unless the condition holds",
    },
}  # fmt: skip
_FUNCTIONS: Final = {
    "SIN": "sine of an angle in degrees", "COS": "cosine of an angle in degrees",
    "TAN": "tangent of an angle in degrees",
    "ASIN": "arc sine, in degrees", "ACOS": "arc cosine, in degrees",
    "SQRT": "square root", "ABS": "value without sign",
    "EXP": "power of e", "LN": "natural logarithm", "ROUND": "nearest whole number",
}  # fmt: skip
_MACRO_FUNCTIONS: Final = _FUNCTIONS | {
    "ATAN": "angle of ATAN[y]/[x], in degrees",
    "FIX": "next whole number below",
    "FUP": "next whole number above",
}
#: Words of expressions and of the order of execution that no table of their language has.
OF_EXPRESSIONS: Final[Mapping[str, Mapping[str, str]]] = {
    "RS274/NGC": {
        **_MACRO_FUNCTIONS,
        "SUB": "begins a subprogram", "ENDSUB": "ends a subprogram, and returns to its call",
        "CALL": "calls a subprogram; its values are #1, #2, ... there", "RETURN": "returns to the call",
        "REPEAT": "repeats the lines up to endrepeat so many times", "ENDREPEAT": "goes back to repeat",
        "WHILE": "repeats the lines up to endwhile as long as the condition holds; behind do, goes back to it",
        "ENDWHILE": "goes back to while", "DO": "begins a loop, which ends at while",
        "IF": "executes the lines up to elseif, else or endif where the condition holds",
        "ELSEIF": "another condition, where those of if before it do not hold",
        "ELSE": "begins the lines for conditions of if that do not hold", "ENDIF": "ends if",
        "BREAK": "leaves the loop", "CONTINUE": "goes to the end of the loop",
    },
    "Fanuc": _MACRO_FUNCTIONS,
    "Siemens": {
        **_FUNCTIONS, "ATAN2": "angle of ATAN2(y, x), in degrees", "POT": "square", "TRUNC": "whole number towards 0",
        "ROUNDUP": "next whole number above", "MINVAL": "lower of two values", "MAXVAL": "higher of two values",
        "BOUND": "value within bounds: BOUND(lowest, highest, value)",
    },
}  # fmt: skip
#: Values of cycles of Siemens -> what each says. Others are only named.
OF_VALUES: Final[Mapping[str, str]] = {
    "RTP": "retraction plane, absolute", "RFP": "reference plane, absolute: the surface",
    "SDIS": "safety clearance over the reference plane", "DP": "final depth, absolute",
    "DPR": "final depth, from the reference plane", "DTB": "dwell at the bottom", "DTS": "dwell before each step",
    "FDEP": "first depth, absolute", "FDPR": "first depth, from the reference plane",
    "DAM": "how much less each step is",
    "FRF": "share of the feed rate in the first step", "MPIT": "pitch as the size of the thread", "PIT": "pitch",
    "FFR": "feed rate in", "RFF": "feed rate out", "LENG": "length", "WID": "width", "CRAD": "corner radius",
    "PRAD": "radius", "PA": "centre, first axis of the plane", "PO": "centre, second axis of the plane",
    "STA": "angle of the length to the first axis", "MID": "largest depth of a pass", "FFD": "feed rate down",
    "FFP1": "feed rate in the plane", "FAL": "allowance at the edge", "CDIR": "direction of milling",
    "_FR": "retract before the turn", "_TC": "name of the swivel data", "_ST": "a new plane, or on the one in force",
    "_MODE": "kind and order of the angles", "_X0": "origin before the turn, X", "_Y0": "origin before the turn, Y",
    "_Z0": "origin before the turn, Z", "_A": "first angle", "_B": "second angle", "_C": "third angle",
    "_X1": "origin after the turn, X", "_Y1": "origin after the turn, Y", "_Z1": "origin after the turn, Z",
    "_DIR": "which of the two positions of the table; 0 turns nothing", "_FR_I": "way of the incremental retract",
    "_AMODE": "which of the heights and depths are absolute, and which relative",
    "_DMODE": "the plane, and how the feed rates count",
    "_TOL": "tolerance of the tip", "_TOLM": "kind of machining", "_OTOL": "tolerance of the tool axis",
}  # fmt: skip
_OF_HOLES: Final = {
    "Z": "depth of the hole; in G91 from R",
    "R": "height at which the feed rate begins, and to which G99 goes back",
    "P": "dwell at the bottom of the hole",
    "Q": "step in depth",
    "L": "how often",
    "K": "how often",
}
_ORIGIN: Final = {**dict.fromkeys("XYZABCUVW", "origin of the work offset: {}"), "P": "number of the work offset"}
_OF_TOOL: Final = {"P": "number of the tool", "R": "length or radius of the tool, or its wear: {}"}
_OF_MACRO: Final = {"P": "number of the macro", "L": "how often"}
_CENTRE: Final = dict.fromkeys("XYZ", "centre: {}")
_AT_TOOL: Final = dict.fromkeys("XYZABCUVW", "moves the zero: the tool is at {} then")
_DIRECTIONS: Final = dict.fromkeys("IJK", "direction about which coordinates turn")
#: Letters that mean one thing beside a code, or while it is the motion in force; {} is their value.
_OF_G: Final[Mapping[str, Mapping[str, str]]] = {
    **{code: {"P": "number of turns of the arc"} for code in ("G2", "G3")},
    "G4": dict.fromkeys("PXU", "dwell: {} s"),
    "G10": {"P": "number of the work offset or tool", "L": "kind of G10"},
    "G10 L2": {**_ORIGIN, "R": "turn of the work offset about Z: {} degrees"},
    "G10 L20": {**_ORIGIN, **dict.fromkeys("XYZABCUVW", "sets the work offset so that the tool is at {}")},
    **{f"G10 L{kind}": {**_OF_TOOL, **dict.fromkeys("XYZ", "length of the tool: {}")} for kind in (1, 10, 11, 12, 13)},
    "G41.1": {"D": "diameter of the tool: {}"},
    "G42.1": {"D": "diameter of the tool: {}"},
    "G43.1": dict.fromkeys("XYZ", "length of the tool: {}"),
    "G50.1": dict.fromkeys("XYZ", "ends the mirror image of this axis"),
    "G51": {**_CENTRE, "P": "factor of the scale", **dict.fromkeys("IJK", "factor of this axis")},
    "G51.1": dict.fromkeys("XYZ", "mirror image about the place {}"),
    "G52": dict.fromkeys("XYZABCUVW", "zero of the local system: {}"),
    "G64": {"P": "how far corners may be rounded", "Q": "how far lines may leave the points that they replace"},
    "G65": _OF_MACRO,
    "G66": _OF_MACRO,
    "G68": {**_CENTRE, **_DIRECTIONS, "R": "turn: {} degrees"},
    "G68.2": {
        **dict.fromkeys("XYZ", "origin of the tilted plane: {}; under P2 one of its points"),
        **dict.fromkeys("IJK", "angle of the tilted plane: {} degrees; under P3 a direction"),
        "P": "kind of the plane",
        "Q": "order of the angles",
        "R": "turn of the plane about its Z",
    },
    "G68.3": {**dict.fromkeys("XYZ", "origin of the tilted plane: {}"), "R": "turn of the plane about its Z"},
    "G54.1": {"P": "number of the additional work offset"},
    "G92": _AT_TOOL,
    "G96": {"D": "most turns a minute"},
    "M98": {"P": "number of the subprogram", "L": "how often"},
    **{f"G{number}": _OF_HOLES for number in (73, 74, *range(81, 90))},
    **{code: {**_OF_HOLES, "Q": "shift away from the wall"} for code in ("G76", "G87")},
    **dict.fromkeys(
        ("G28", "G30"),
        dict.fromkeys("XYZABCUVW", "place on the way to the reference position: {}; in G91 by how much"),
    ),
    "G53": {},  # Z is a place there, also while a cycle is modal
}
_SHIFT: Final = dict.fromkeys("XYZ", "shifts the zero by {}")
_DATUM: Final = {
    **dict.fromkeys("XYZ", "shifts the datum to {}"),
    **dict.fromkeys(("IX", "IY", "IZ"), "shifts the datum by {}"),
}
_TURN: Final = {letter: f"rotation by {{}} degrees about {letter}" for letter in "XYZ"}
#: Dialect -> code -> letter beside it -> what it sets; {} is its value.
OF_LETTERS: Final[Mapping[str, Mapping[str, Mapping[str, str]]]] = {
    "rs274": _OF_G,
    "fanuc": {**_OF_G, "G4": {**_OF_G["G4"], "P": "dwell: {} milliseconds, or seconds if the key dwell says so"}},
    "siemens": {
        **dict.fromkeys(("TRANS", "ATRANS"), _SHIFT),
        **dict.fromkeys(("ROT", "AROT"), _TURN),
        **dict.fromkeys(("SCALE", "ASCALE"), dict.fromkeys("XYZ", "factor of this axis: {}")),
        **dict.fromkeys(
            ("MIRROR", "AMIRROR"), dict.fromkeys("XYZ", "mirror image of this axis; the value has no meaning")
        ),
        "G4": {"F": "dwell: {} s", **dict.fromkeys(("S", "S1"), "dwell: {} turns of the spindle")},
        **dict.fromkeys(("G110", "G111", "G112"), dict.fromkeys("XYZ", "pole: {}")),
    },
    "heidenhain": {
        "TOOL CALL": dict.fromkeys("XYZ", "tool axis"),
        "BLK FORM": dict.fromkeys("XYZ", "axis, or corner, of the stock"),
        "CC": dict.fromkeys("XYZ", "pole and centre: {}"),
        "CYCL DEF 7": _DATUM,
        "TRANS DATUM": _DATUM,
        "CYCL DEF 8": dict.fromkeys("XYZ", "mirror image of this axis"),
        "TRANS MIRROR": dict.fromkeys("XYZ", "mirror image of this axis"),
        "CYCL DEF 19": {
            letter: f"angle of the plane about {axis}: {{}} degrees" for letter, axis in zip("ABC", "XYZ", strict=True)
        },
    },
}

#: Letters of RS274/NGC and Fanuc.
LETTERS: Final[Mapping[str, str]] = {
    **dict.fromkeys("XYZABCUVW", "where an axis goes; in G91 by how much"),
    **dict.fromkeys("IJK", "centre of an arc, from its start; tool axis under G43.5; angles of G68.2"),
    "R": "radius of an arc; height to which a cycle goes back",
    "F": "feed rate",
    "S": "spindle speed",
    "T": "selects a tool; M6 loads it",
    "H": "tool whose length holds",
    "D": "tool whose radius holds under G41 and G42",
    "N": "block number",
    "O": "number of a program or subprogram",
    "P": "number that the code of the block takes: a dwell, a subprogram, a kind",
    "Q": "number that the code of the block takes: a step in depth, a count",
    "L": "how often, or which kind of G10",
}
