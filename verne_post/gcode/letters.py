"""What letters say, beside which code; words of expressions, and other words that no table of a language has."""

from collections.abc import Mapping
from typing import Final

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
#: Operators between two values, or two conditions.
_OPERATORS: Final = {
    "EQ": "true if both values are equal",
    "NE": "true if the values differ",
    "LT": "true if the first value is less",
    "LE": "true if the first value is less, or both are equal",
    "GT": "true if the first value is greater",
    "GE": "true if the first value is greater, or both are equal",
}
_LOGIC: Final = {
    "AND": "true if both conditions are true",
    "OR": "true if one of the conditions is true, or both",
    "XOR": "true if exactly one of the conditions is true",
    "MOD": "remainder of a division",
}
#: Words behind o and its label, in which the order of execution is written.
FLOW: Final = {
    "SUB": "begins a subprogram", "ENDSUB": "ends a subprogram, and returns to its call",
    "CALL": "calls a subprogram; its values are #1, #2, ... there", "RETURN": "returns to the call",
    "DO": "begins a loop, which ends at while",
    "WHILE": "repeats the lines up to endwhile as long as the condition is true; after do, goes back to it",
    "ENDWHILE": "goes back to while",
    "IF": "executes the lines up to elseif, else or endif if the condition is true",
    "ELSEIF": "another condition, if those of if before it are false",
    "ELSE": "begins the lines for false conditions of if", "ENDIF": "ends if",
    "BREAK": "leaves the loop", "CONTINUE": "goes to the end of the loop",
    "REPEAT": "repeats the lines up to endrepeat so many times", "ENDREPEAT": "goes back to repeat",
}  # fmt: skip
#: Words of expressions and of the order of execution that no table of their language has.
OF_EXPRESSIONS: Final[Mapping[str, Mapping[str, str]]] = {
    "RS274/NGC": {
        **_MACRO_FUNCTIONS, **_OPERATORS, **_LOGIC,
        **FLOW,
    },
    "Fanuc": {
        **_MACRO_FUNCTIONS, **_OPERATORS, **_LOGIC,
        "AND": "the bits that both values have", "OR": "the bits that one of two values has, or both",
        "XOR": "the bits that exactly one of two values has",
        "IF": "[condition] GOTO n jumps if it is true; [condition] THEN sets a variable",
        "THEN": "sets a variable if the condition is true",
        "GOTO": "jumps to the block N of this number, searched to the end, then from the beginning",
        "WHILE": "[condition] DO1 repeats the lines up to END1 as long as it is true",
        "DO": "begins a loop; DO1 ends at END1",
        "END": "goes back to DO of the same number",
    },
    "Klartext": {
        "EQU": "true if both values are equal", "NE": "true if the values differ",
        "LT": "true if the first value is less", "GT": "true if the first value is greater",
        "IF": "the condition of a jump: FN 9 to FN 12", "GOTO": "jumps to the label if the condition of FN is true",
    },
    "Siemens": {
        "REAL": "number, as a type of DEF and PROC", "INT": "whole number, as a type of DEF and PROC",
        "BOOL": "TRUE or FALSE, as a type of DEF and PROC", "CHAR": "a character, as a type of DEF and PROC",
        "STRING": "text of so many characters, as a type of DEF and PROC",
        "TO": "between the first and last value of FOR",
        "NOT": "true if the condition after it is false",
        **_LOGIC, "DIV": "division without its remainder",
        **_FUNCTIONS, "ATAN2": "angle of ATAN2(y, x), in degrees", "POT": "square", "TRUNC": "whole number towards 0",
        "ROUNDUP": "next whole number above", "MINVAL": "lower of two values", "MAXVAL": "higher of two values",
        "BOUND": "value within bounds: BOUND(lowest, highest, value)",
    },
}  # fmt: skip
#: Those of them that stand in a value or a condition alone.
OF_VALUES: Final = {
    *_MACRO_FUNCTIONS,
    *_FUNCTIONS,
    *_OPERATORS,
    *_LOGIC,
    "EQU",
    "NOT",
    "DIV",
    "ATAN2",
    "POT",
    "TRUNC",
    "ROUNDUP",
    "MINVAL",
    "MAXVAL",
    "BOUND",
}
_OF_HOLES: Final = {
    "Z": "depth of the hole; in G91 from R",
    "R": "height at which the feed rate begins, and to which G99 goes back",
    "P": "dwell at the bottom of the hole",
    "Q": "step in depth",
    "L": "how often",
    "K": "how often",
}
_RADIUS: Final = "radius of the arc: {}; a negative one takes the long way"
_OF_ARC: Final = {
    **{letter: f"centre of the arc, from its start in {axis}: {{}}" for letter, axis in zip("IJK", "XYZ", strict=True)},
    "R": _RADIUS,
    "P": "number of turns of the arc",
}
_OF_ABSOLUTE_ARC: Final = _OF_ARC | {a: f"centre of the arc in {b}: {{}}" for a, b in zip("IJK", "XYZ", strict=True)}
_TOOL_AXIS: Final = {letter: f"tool axis: component in {axis}" for letter, axis in zip("IJK", "XYZ", strict=True)}
_WALL: Final = dict.fromkeys("IJK", "shift away from the wall: {}")
_ORIGIN: Final = {**dict.fromkeys("XYZABCUVW", "origin of the work offset: {}"), "P": "number of the work offset"}
_OF_TOOL: Final = {"P": "number of the tool", "R": "length or radius of the tool, or its wear: {}"}
_OF_MACRO: Final = {"P": "number of the macro", "L": "how often"}
_CENTRE: Final = dict.fromkeys("XYZ", "centre: {}")
_AT_TOOL: Final = dict.fromkeys("XYZABCUVW", "moves the zero: the tool is at {} then")
_DIRECTIONS: Final = dict.fromkeys("IJK", "direction about which coordinates turn")
#: Letters behind a comma: what the corner to the next move becomes.
OF_CORNERS: Final[Mapping[str, str]] = {
    "R": "rounding of the corner, radius {}",
    "C": "chamfer of the corner, {}",
    "A": "angle of the line",
}
#: Codes with a letter of their own, beside which the motion in force goes on.
BESIDE_MOTION: Final = ("G41", "G42", "G41.1", "G42.1", "G43.5", "G64", "G96")
#: Letters that mean one thing beside a code, or while it is the motion in force; {} is their value.
_OF_G: Final[Mapping[str, Mapping[str, str]]] = {
    **dict.fromkeys(("G2", "G3"), _OF_ARC),
    "G43.5": _TOOL_AXIS,
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
    **{code: {**_OF_HOLES, **_WALL, "Q": "shift away from the wall"} for code in ("G76", "G87")},
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
    "rs274": {
        **_OF_G,
        **dict.fromkeys(("G2 G90.1", "G3 G90.1"), _OF_ABSOLUTE_ARC),
        "G5": {
            **dict.fromkeys("IJ", "first control point of the spline, from the start: {}"),
            **dict.fromkeys("PQ", "second control point of the spline, from the end: {}"),
        },
        "G5.1": dict.fromkeys("IJ", "control point of the spline, from the start: {}"),
        "G5.2": {"P": "weight of this control point: {}", "L": "order of the NURBS: {}"},
    },
    "fanuc": {
        **_OF_G,
        "G6.2": {"P": "order of the NURBS: {}", "K": "knot: {}", "R": "weight of this control point: {}"},
        "G4": {**_OF_G["G4"], "P": "dwell: {} milliseconds, or seconds if the key dwell says so"},
    },
    "siemens": {
        **dict.fromkeys(("TRANS", "ATRANS"), _SHIFT),
        **dict.fromkeys(("ROT", "AROT"), _TURN),
        **dict.fromkeys(("SCALE", "ASCALE"), dict.fromkeys("XYZ", "factor of this axis: {}")),
        **dict.fromkeys(
            ("MIRROR", "AMIRROR"), dict.fromkeys("XYZ", "mirror image of this axis; the value has no meaning")
        ),
        **{key: {"P": "how often the lines run"} for key in ("REPEAT", "REPEATB", "UNTIL")},
        "G4": {"F": "dwell: {} s", **dict.fromkeys(("S", "S1"), "dwell: {} turns of the spindle")},
        **dict.fromkeys(("G110", "G111", "G112"), dict.fromkeys("XYZ", "pole: {}")),
    },
    "heidenhain": {
        "TOOL CALL": dict.fromkeys("XYZ", "tool axis"),
        "BLK FORM": dict.fromkeys("XYZ", "axis, or corner, of the stock"),
        "PATTERN DEF": {**dict.fromkeys("XY", "place of the pattern: {}"), "Z": "surface of the holes: {}"},
        "CC": dict.fromkeys("XYZ", "pole and centre: {}"),
        "CR": {"R": _RADIUS},
        "RND": {"R": "radius of the rounding: {}"},
        "CYCL DEF 7": _DATUM,
        "TRANS DATUM": _DATUM,
        "CYCL DEF 8": dict.fromkeys("XYZ", "mirror image of this axis"),
        "TRANS MIRROR": dict.fromkeys("XYZ", "mirror image of this axis"),
        "CYCL DEF 19": {
            letter: f"angle of the plane about {axis}: {{}} degrees" for letter, axis in zip("ABC", "XYZ", strict=True)
        },
    },
}

_AXES: Final = dict.fromkeys("XYZABCUVW", "where an axis goes; in G91 by how much")
#: Letters of RS274/NGC and Fanuc.
LETTERS: Final[Mapping[str, str]] = {
    **_AXES,
    **dict.fromkeys("IJK", "centre of an arc, from its start; tool axis under G43.5; angles of G68.2"),
    "R": "radius of an arc, a negative one for more than half a turn; height to which a cycle goes back",
    "F": "feed rate",
    "S": "spindle speed",
    "T": "selects a tool; M6 loads it",
    "H": "tool whose length is used",
    "D": "tool whose radius is used under G41 and G42",
    "N": "block number",
    "O": "number of a program or subprogram",
    "P": "number that the code of the block takes: a dwell, a subprogram, a kind",
    "Q": "number that the code of the block takes: a step in depth, a count",
    "L": "how often, or which kind of G10",
}
#: Words of Klartext that have a value.
LETTERS_OF_KLARTEXT: Final[Mapping[str, str]] = {
    **dict.fromkeys("XYZABCUVW", "where an axis goes"),
    **{f"I{letter}": "by how much an axis goes" for letter in "XYZABCUVW"},
    "F": "feed rate",
    "S": "spindle speed in 1/min: in TOOL CALL, or in a block",
    "R": "radius",
    "TOOL CALL": "loads a tool; its length is active at once",
    "TOOL DEF": "names the next tool, or gives its length and radius",
    "DL": "added to the length of the tool, in the unit of the program",
    "DR": "added to the radius of the tool, in the unit of the program",
    "DR+": "arc counter-clockwise",
    "DR-": "arc clockwise",
    "ROT": "rotation about Z of the active datum, degrees",
    "SCL": "factor of all lengths",
    "PR": "radius about the pole",
    "PA": "angle about the pole",
    "IPA": "by what angle, about the pole",
    **{f"SP{letter}": f"angle of the plane about {axis}, degrees" for letter, axis in zip("ABC", "XYZ", strict=True)},
    "DIST": "how far before the tip the point is that stays on the part, mm",
    "LBL": "label: a subprogram ends at LBL 0",
    "REP": "how often a section runs again",
    "MB": "how far M140 or a turn of the table retracts",
}
_NO_WORD: Final = "a name of tool-centre-point control, and no word of a program"
#: Words that no table has by their own names -> what they do, by language. Behind a letter the number is left out.
OF_NAMES: Final[Mapping[str, Mapping[str, str]]] = {
    "RS274/NGC": {
        **LETTERS,
        "D0": "the tool in the spindle, for G41 and G42",
        "#": "a variable: #1 to #30 in a subprogram are its own, others are of the whole program",
    },
    "Fanuc": {
        **LETTERS,
        "D0": "no radius: under G41 and G42 the tool's centre goes on the contour",
        **dict.fromkeys(("RTCP", "TCP"), f"{_NO_WORD}; G43.4 H switches it on, and G49 off"),
        "#": "a variable: #1 to #33 are those of a macro, #100 to #999 those of all programs; #1000 and higher are "
        "values of the control",
    },
    "Siemens": {
        "R": "an R parameter: a number that the program sets and reads, as in R1=5 and X=R1",
        **dict.fromkeys(("RTCP", "TCP"), f"{_NO_WORD}; TRAORI switches it on, and TRAFOOF off"),
    },
    "Klartext": {
        **LETTERS_OF_KLARTEXT,
        "Q": "a Q parameter: a number that the program sets and reads; a formula may follow =",
        **dict.fromkeys(("QL", "QR"), "a Q parameter: QL of this program alone, QR kept for later programs"),
        "QS": "a Q parameter with a text",
        **dict.fromkeys(("TX", "TY", "TZ"), "a component of the tool axis, in LN"),
        **dict.fromkeys(("NX", "NY", "NZ"), "a component of the normal of the surface, in LN"),
        "T": "number or name of the tool, in TOOL CALL",
        "CYCL": "CYCL DEF defines a cycle, CYCL CALL calls it",
        "RTCP": f"{_NO_WORD}; M128 or FUNCTION TCPM switches it on, M129 or FUNCTION RESET TCPM off",
        "TCPM": "FUNCTION TCPM switches tool-centre-point control on, as M128 does; FUNCTION RESET TCPM ends it",
        "BLK FORM 0.1": "the stock, a box: the tool axis, and the corner of the lowest X Y Z",
        "BLK FORM 0.2": "the stock, a box: the corner of the highest X Y Z",
        "TRANS DATUM AXIS": "shifts the datum to X Y Z, or by IX IY IZ; TRANS DATUM RESET ends it",
        "TRANS DATUM RESET": "ends the shift of the datum",
        "FUNCTION TCPM": "tool-centre-point control on, as M128; FUNCTION RESET TCPM ends it",
        "FUNCTION RESET TCPM": "tool-centre-point control off, as M129",
        "FUNCTION DWELL": "waits so many seconds (TIME), or turns of the spindle (REV)",
        "FUNCTION MODE MILL": "milling, which is the only mode here",
    },
}
_APPROACHES: Final = {
    "LCT": "along a line and an arc, tangent to both",
    "PLCT": "along a line and an arc; the point is polar",
    "LT": "along a line that is tangent",
    "PLT": "along a tangent line; the point is polar",
    "LN": "along a line that is normal to the contour",
    "PLN": "along a normal line; the point is polar",
    "CT": "along an arc that is tangent",
    "PCT": "along a tangent arc; the point is polar",
}
#: Words of a formula of Klartext, besides those that Siemens has too, and of FN.
OF_FORMULAS: Final[Mapping[str, str]] = {
    **OF_EXPRESSIONS["Siemens"],
    "SQ": "square",
    "INT": "whole part",
    "FRAC": "part after the decimal point",
    "NEG": "other sign",
    "LOG": "logarithm to base 10",
    "SGN": "sign: -1, 0 or 1",
    "PI": "3.14159...",
    "ATAN": "arc tangent, in degrees",
    "TOCHAR": "a number as text",
    "TONUMB": "a text as number",
    "DAT": "the number",
    "DECIMALS": "how many decimals",
    "FMAX": "rapid traverse",
    "FAUTO": "the feed rate of TOOL CALL",
}
OF_FN: Final[Mapping[str, str]] = {
    **OF_EXPRESSIONS["Klartext"],
    "DIV": "divided by",
    "SQRT": "square root",
    "SIN": "sine",
    "COS": "cosine",
    "LEN": "length of two sides",
    "ANG": "angle of two sides",
    "IS UNDEFINED": "has no value",
    "IS DEFINED": "has a value",
    "LBL": LETTERS_OF_KLARTEXT["LBL"],
}
#: First word of a statement of Klartext -> words that stand in it alone, and what they do; "*" are those of any.
WORDS_OF_STATEMENTS: Final[Mapping[str, Mapping[str, str]]] = {
    "*": {
        "IPR": "by how much the radius about the pole grows",
        "CCA": "angle of the arc, degrees",
        "LEN": "length of the straight line",
        "DR2": "added to the corner radius of the tool",
        "FZ": "feed rate per tooth",
        "FU": "feed rate in mm per turn of the spindle",
        "LA": "blocks of look-ahead",
    },
    "PLANE": {
        **{name: text for name, text in LETTERS_OF_KLARTEXT.items() if name.startswith("SP")},
        "EULPR": "turn about Z, degrees",
        "EULNU": "turn about the new X, degrees",
        "EULROT": "turn about the new Z, degrees",
        **{
            f"{letter}{axis}": f"direction of {'X' if letter == 'B' else 'Z'} of the plane: its component in {axis}"
            for letter in "BN"
            for axis in "XYZ"
        },
        **{f"P{number}{axis}": f"point {number} of the plane: its {axis}" for number in "123" for axis in "XYZ"},
        "DIST": LETTERS_OF_KLARTEXT["DIST"],
        "ABST": LETTERS_OF_KLARTEXT["DIST"],
        "SETUP": LETTERS_OF_KLARTEXT["DIST"],
        "SET-UP": LETTERS_OF_KLARTEXT["DIST"],
        "SEQ+": "chooses the solution whose tilting axis is positive",
        "SEQ-": "chooses the solution whose tilting axis is negative",
        "SYM+": "chooses the solution on the positive side",
        "SYM-": "chooses the solution on the negative side",
        "RELATIVE": "turns the tilted work plane once more",
        **dict.fromkeys("ABC", "angle of the rotary axis, of PLANE AXIAL"),
    },
    "APPR": _APPROACHES,
    "DEP": _APPROACHES,
    "FUNCTION": {
        "F TCP": "F is the feed rate of the tip; no effect, it always is",
        "F CONT": "F is that of the contour; no effect, it is always that of the tip",
        "AXIS POS": "A, B, C are the angles of the rotary axes",
        "AXIS SPAT": "A, B, C are spatial angles",
        "PATHCTRL AXIS": "the rotary axes go linearly",
        "PATHCTRL VECTOR": "the tool axis goes along a great circle",
        "REFPNT": "the point that is led, and the one about which the tool turns",
        "TIP-TIP": "both are the tip",
        "TIP-CENTER": "the tip is led, the centre turns",
        "CENTER-CENTER": "both are the centre",
        "TIME": "seconds",
        "REV": "turns of the spindle",
    },
    "TRANS": {
        "DATUM TABLE": "takes a row of the datum table",
        "TABLINE": "number of the row",
        "AXIS": "by values of axes",
        "ROT": LETTERS_OF_KLARTEXT["ROT"],
        "SCL": LETTERS_OF_KLARTEXT["SCL"],
        "MIRROR": "mirrors axes",
        "ROTATION": "turns the datum",
        "SCALE": "scales lengths",
        "RESET": "ends it",
        "DATUM": "the datum is shifted",
    },
    "CYCL": {
        "POS": "at the position given",
        "PAT": "at every place of PATTERN DEF",
        "ROT": LETTERS_OF_KLARTEXT["ROT"],
        "SCL": LETTERS_OF_KLARTEXT["SCL"],
        "#": "row of the datum table",
        "V.ZEIT": "seconds",
        "DWELL": "seconds",
        "T": "tolerance of corners",
        "TA": "tolerance of the rotary axes, degrees: no effect",
        "HSC-MODE": "0 finishing, 1 roughing: no effect",
        "ANGLE": "angle of the spindle, degrees",
        "ORIENTATION": "angle of the spindle",
    },
    "CALL": {"REP": LETTERS_OF_KLARTEXT["REP"]},
    "BLK": {
        "CYLINDER": "the stock, a cylinder about this axis",
        "DIST": "height of the datum over its upper face",
        "RI": "inner radius",
        "DI": "inner diameter",
        "R": "radius",
        "D": "diameter",
        "L": "length",
    },
    "TOOL": {"L": "length of the tool"},
    "PATTERN": {
        **{
            f"{kind}{number}": text
            for number in "123456789"
            for kind, text in (
                ("POS", "a position"),
                ("ROW", "a row of positions"),
                ("PAT", "a grid of positions"),
                ("FRAME", "a frame of positions"),
                ("CIRC", "a circle of positions"),
                ("PITCHCIRC", "an arc of positions"),
            )
        },
        "DX": "distance of columns",
        "DY": "distance of rows",
        "NUMX": "number of columns",
        "NUMY": "number of rows",
        "NUM": "how many",
        "D": "distance, or diameter of the circle",
        "START": "angle of the first",
        "STEP": "angle from one to the next",
        "ROT": "turn of the whole pattern",
        "ROTX": "turn of columns",
        "ROTY": "turn of rows",
    },
}
