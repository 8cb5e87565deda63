"""Words of Klartext: what they do, that they have no effect here, or why they are refused; names of Q parameters.

The readers look words up here, so a word that is not here cannot be executed. docs/make_words.py makes the tables of
docs/heidenhain.md of it; a test runs every one of their words.
"""

import math
from collections.abc import Mapping
from typing import Final

from verne_post.gcode.codes import RS274, end_texts
from verne_post.model.moves import ArcFeed

#: Why contours of cycles, and probing, are refused.
SL: Final = (
    "contours of SL cycles; write cycles 251 to 257, or the contour with RL or RR, or let the CAM system write the "
    "moves"
)
PROBING: Final = (
    "touch probes: where the tool touches is only known at the machine; take them out, and give the datum with --wcs"
)
#: Keywords that begin a statement, and what it does.
STATEMENTS: Final[Mapping[str, str]] = {
    "BEGIN PGM": "the program begins; MM or INCH is the unit of all lengths",
    "END PGM": "the program ends",
    "BLK FORM": "the stock, a box or a cylinder: see Stock, patterns, functions",
    "TOOL CALL": "changes the tool, as M6 does; its length, with DL, counts at once. Without a number only S and F "
    "change. `[heidenhain.tools]` gives a name its number",
    "TOOL DEF": "length and radius, from the next TOOL CALL on, unless the set-up or tool table has them. With the "
    "number alone it only names the next tool",
    "CYCL DEF": "a cycle: below",
    "CYCL CALL": "calls the defined cycle. POS calls it at a position; Z raises the surface; F applies to the move "
    "there. PAT: PATTERN DEF",
    "LBL": "a label; LBL 0 ends a subprogram, which a program that runs on enters too (VP024)",
    "CALL LBL": "runs the subprogram from a label to LBL 0; with REP m, the section from the label again m times",
    "CALL PGM": "runs another program, a file in the folder of this one",
    "CALL SELECTED PGM": "refused: write CALL PGM",
    "SEL TABLE": "names the datum table of `datums`, by one name in a program: see Keys of the settings file",
    "PLANE": "a tilted plane: below",
    "FUNCTION": "begins TCPM, RESET TCPM, DWELL or MODE MILL: see Stock, patterns, functions",
    "TRANS": "shifts (DATUM AXIS), mirrors (MIRROR), turns (ROTATION) or scales (SCALE) the datum, as cycles 7, 8, 10 "
    "and 11 do; RESET ends it. DATUM TABLE takes a row of `datums`: see Keys of the settings file",
    "PATTERN DEF": "positions for CYCL CALL PAT: see Stock, patterns, functions",
    "STOP": "stops the program until the operator starts it again, as M0; the block may have other M functions",
    "APPR": "approaches the first point of the contour (LT, LN, CT, LCT; with P polar): auxiliary point in X and Y, "
    "then Z, then onto the contour",
    "DEP": "leaves the contour (LT, LN, CT, LCT; CT with its angle CCA), and ends the compensation",
    "RND": "arc between two elements; its F applies to it alone",
    "CHF": "chamfer; the number is its length on each line",
    **dict.fromkeys(("CT", "CTP"), "arc that continues the direction of the element before"),
    "CP": "arc about CC by an angle; IPA may be several turns",
    "CR": "arc by its radius; a negative one takes the long way, more than half a turn",
    "CC": "pole and centre; without coordinates the last position; two of X Y Z choose the plane",
    "LP": "line by radius PR (IPR) and angle PA (IPA) about CC",
    "LN": "tool axis T, or the normal N without T; needs M128",
    "L": "a straight line to the coordinates; I before a letter counts from the last programmed position",
    "C": "an arc about CC to the coordinates, in the plane of CC; a third coordinate makes a helix",
    **dict.fromkeys(
        ("Q", "QL", "QR"),
        "a Q parameter gets a value or the result of a formula: + - * / ^ % and functions, with angles in degrees",
    ),
    "QS": "a text parameter gets a text (also DECLARE STRING): quotes, TOCHAR (DAT, DECIMALS), TONUMB",
    "FN": "a function of parameters: below",
    "M": "an M function: alone, or at the end of a block",
    "F": "feed rate in mm/min, from this block on",
    "S": "spindle speed in 1/min: in TOOL CALL, or in a block",
    "R0": "radius compensation off",
    **end_texts(
        ": the first move ends beside the start of the first element, the last move starts beside the end of the last",
        {"RL": "the tool goes left of the contour", "RR": "the tool goes right of the contour"},
    ),
}
#: Words within statements, and what they do.
WORDS: Final[Mapping[str, str]] = {
    "FMAX": "rapid traverse, for this block",
    "F AUTO": "the feed rate of TOOL CALL",
    "FU": "feed rate in mm per turn of the spindle",
    "R F M": "R, F or M without a value keeps the present value; older controls write it where nothing was entered. "
    "F needs M after it",
    "MOVE": "the rotary axes turn, and the point DIST before the tip stays on the part (ABST, SETUP, SET-UP)",
    "TURN": "the rotary axes turn, X Y Z of the machine do not move, after a retract by MB",
    "STAY": "nothing moves; a line with A+Q120 C+Q122 follows",
    **dict.fromkeys(
        ("SEQ", "SYM"),
        "chooses the sign of the tilting axis; without it the rotary axes take the shorter way within the travel",
    ),
    "TABLE ROT": "with a vertical tool, C turns until X of the plane is along X of the machine",
    "COORD ROT": "with a vertical tool, C turns to 0",
}
#: Kinds of PLANE.
PLANES: Final[Mapping[str, str]] = {
    "SPATIAL": "tilts the work plane: turned about X, then Y, then Z of the untilted system",
    "EULER": "tilts the work plane: about Z, the new X, the new Z",
    "VECTOR": "tilts the work plane: X along B, Z along N",
    "POINTS": "tilts the work plane: X from P1 to P2, P3 on the side of Y",
    "RELATIV": "turns the tilted work plane once more; also RELATIVE",
    "AXIAL": "tilts the work plane: by the angles of the rotary axes",
    "RESET": "ends the tilted work plane",
}
#: M functions.
FUNCTIONS: Final[Mapping[int, str]] = {
    0: "stops the program until the operator starts it again",
    1: "stops as M0, only with --optional-stop",
    2: "end of the program",
    3: "spindle on, clockwise",
    4: "spindle on, counter-clockwise",
    5: "spindle off",
    **RS274.m_groups["coolant"],
    30: "end of the program",
    13: "spindle on, clockwise, with coolant",
    14: "spindle on, counter-clockwise, with coolant",
    19: "orients the spindle to the angle of cycle 13",
    89: "calls the cycle after every block that moves, until M99 or the next machining cycle",
    99: "calls the cycle in this block",
    91: "machine coordinates, as G53: gauge line, nominal machine; under M128 with a warning (VP043)",
    92: "machine coordinates from `g30` of `[home]`",
    94: "the angles of the rotary axes are reduced to less than a turn; after an angle below 0, positions need M126",
    **end_texts(
        ": see F on arcs",
        {
            109: "on arcs F is the feed rate of the cutting edge",
            110: "on inside arcs F is that of the cutting edge",
            111: "on arcs F is the feed rate of the tool's centre",
        },
    ),
    116: "F of a turn of the rotary axes is the speed of the tip in mm/min",
    117: "ends M116",
    126: "the rotary axes take the shorter way",
    127: "ends M126",
    128: "tool-centre-point control on; F of M128 has no effect",
    129: "tool-centre-point control off",
    130: "coordinates of the untilted system, for this block",
    136: "F is in mm per turn of the spindle, and needs a new value; cycles are refused",
    137: "F is per minute again, and needs a new value",
    140: "retract along the tool axis by MB; MB MAX: to machine Z 0, if the tool is below",
}
#: M function -> what F directly behind it says, in place of the feed rate from this block on.
FEED_OF_FUNCTIONS: Final[Mapping[str, str]] = {
    "M128": "belongs to M128, and has no effect: the feed rate in force stays",
    "M140": "feed rate of the retract of M140 alone",
}
#: M function -> M codes of RS274/NGC, at the beginning of the block.
AT_BEGIN: Final = {3: (3,), 4: (4,), 7: (7,), 8: (8,), 13: (3, 8), 14: (4, 8)}
#: The same at its end.
AT_END: Final = {0: (0,), 1: (1,), 2: (2,), 5: (5,), 9: (9,), 30: (30,)}
#: Cycles.
CYCLES: Final[Mapping[int, str]] = {
    7: "datum shift, also incremental",
    8: "mirror image of X, Y or both; arcs and sides change direction",
    9: "waits so many seconds",
    10: "rotation about Z of the active datum",
    11: "scaling of all lengths, not of the tool",
    13: "the angle of the spindle for M19",
    19: "working plane by spatial angles. The axes do not move, or with `cycle_19` turn at F, with the set-up "
    "clearance as DIST of MOVE: see Keys of the settings file",
    32: "sets the tolerance of corners, T, as G64 P",
    247: "preset: 1 to 9 are G54 to G59.3 of --wcs, 10 to 48 G54.1P10 to P48; 0, the one set by hand, is G54. It ends "
    "shifts, mirror images, rotations and scalings",
    **end_texts(
        ": see Cycles",
        {
            200: "drilling",
            201: "reaming",
            202: "boring, the spindle stops oriented",
            203: "universal drilling with chip breaking",
            204: "back boring",
            205: "universal pecking",
            206: "tapping with a floating holder",
            207: "rigid tapping",
            208: "bore milling",
            209: "rigid tapping with chip breaking",
            240: "centring",
        },
    ),
    241: "single-lip deep-hole drilling: see Cycles",
    262: "a milled inside thread: see Thread milling",
    263: "mills an inside thread, with a countersink at the front of the tool (Q358)",
    264: "drills, and mills an inside thread",
    265: "an inside thread from the surface down",
    267: "a milled outside thread",
    220: "the cycle before it, at holes on a circle",
    221: "the cycle before it, at the holes of a grid",
    232: "a face: see Milling cycles",
    233: "a face from the position of the tool",
    251: "a rectangular pocket",
    252: "a circular pocket",
    253: "a slot",
    254: "slots along a circle",
    256: "a rectangular stud",
    257: "a circular stud",
    258: "a stud with 3 to 30 equal sides",
}
#: Functions of FN.
FN: Final[Mapping[int, str]] = {
    0: "sets a Q parameter",
    1: "adds",
    2: "subtracts",
    3: "multiplies",
    4: "divides",
    5: "square root",
    6: "sine",
    7: "cosine",
    8: "length of two sides (LEN)",
    13: "angle of two sides (ANG)",
    9: "jumps to a label where two values are equal (EQU), or where a parameter IS UNDEFINED, IS DEFINED",
    10: "jumps to a label where two values differ (NE)",
    11: "jumps to a label where the first value is greater (GT)",
    12: "jumps to a label where the first value is less (LT)",
    15: "prints to a file of the control; `dump moves` shows it as `not executed`",
    16: "prints a text of the control; `dump moves` shows it as `not executed`",
    18: "reads a value of the control (SYSREAD) into a parameter; it is not executed, and using the parameter later is "
    "refused (VP025)",
}
#: Where F holds on arcs.
ARC_FEEDS: Final[Mapping[int, ArcFeed]] = {
    109: ArcFeed("M109", 0.0, math.inf),
    110: ArcFeed("M110", 0.0, 1.0),
    111: ArcFeed(),
}
#: FUNCTION with these words ends what cannot be begun here; MODE MILL is the only mode.
ENDED_FUNCTIONS: Final = (
    "MODE MILL",
    "FEED RESET",
    "S-PULSE RESET",
    "LIFTOFF RESET",
    "CORRDATA RESET",
    "PARAXCOMP OFF",
    "PARAXMODE OFF",
)
#: How the control reacts or smooths, or ends of modes that cannot be begun.
FUNCTIONS_WITHOUT_EFFECT: Final = {
    6: "tool change: TOOL CALL has made it", 90: "smoothing of corners; cycle 32 sets the tolerance",
    102: "end of M101", 104: "back to the preset set last, which is active",
    105: "lag compensation", 106: "lag compensation",
    107: "no error message for replacement tools", 108: "end of M107", 113: "end of M112",
    119: "end of M118", 120: "look-ahead under compensation", 121: "end of M120", 135: "end of M134",
    145: "end of M144",
    149: "end of M148", 199: "end of M197"
}  # fmt: skip
#: M functions that are known and not executed.
REFUSED_FUNCTIONS: Final = {
    97: "machining of small steps of the contour",
    98: "complete machining of open contours; M99 calls a cycle",
    101: "change to a replacement tool when the tool life is over",
    103: "reduced feed rate when plunging", 112: "corner rounding between lines; cycle 32 sets the tolerance",
    114: "compensation of the machine's geometry; M128 does that", 115: "end of M114",
    118: "handwheel during the program",
    124: "filter of contour points", 134: "exact stop of rotary axes", 138: "choice of axes for tilting",
    141: "no touch-probe monitoring", 142: "deletes modal information", 143: "deletes the basic rotation",
    144: "positions of the table in the tool position", 148: "retract at a stop",
    150: "suppresses limit switch messages",
    197: "rounding of outside corners", **dict.fromkeys(range(200, 205), "laser cutting")
}  # fmt: skip
#: Cycles that setpoints do not know.
CYCLES_WITHOUT_EFFECT: Final = {
    332: "tunes the drives for a tolerance",
    392: "tunes the drives for the weight of the part",
}
#: Cycles that are known and not executed.
REFUSED_CYCLES: Final = {
    1: "pecking of older controls; write cycle 200", 2: "tapping of older controls; write cycle 206",
    3: "slot milling of older controls; write cycle 253", 4: "pocket milling of older controls; write cycle 251",
    5: "circular pocket of older controls; write cycle 252",
    6: SL, 12: "program call as a cycle; write CALL PGM", 14: SL, 15: SL, 16: SL,
    17: "rigid tapping of older controls; write cycle 207",
    18: "thread cutting: setpoints cannot wait for the spindle; write cycle 207",
    **dict.fromkeys((20, 21, 22, 23, 24, 25, 270, 271, 272, 273, 274, 275, 276), SL),
    **dict.fromkeys((285, 286, 287), "gears; let the CAM system write the moves"),
    26: "axis-specific scaling: circles would become ellipses; let the CAM system scale the contour",
    **dict.fromkeys((27, 28, 29, 39), "cylinder surface; let the CAM system write X Y Z with the rotary axes"),
    30: "3-D data from files; let the CAM system write the lines",
    225: "engraving; let the CAM system write the lines of the letters",
    230: "multipass milling of older controls; write cycle 233",
    231: "ruled surface; let the CAM system write the moves", 239: "weighs the workpiece; take it out",
    **dict.fromkeys(range(400, 500), PROBING),
    **dict.fromkeys(range(800, 900), "turning and gear cycles; let the CAM system write the moves of a mill")
}  # fmt: skip
#: Words that begin statements which are not executed, and why.
REFUSED_STATEMENTS: Final = {
    "TCH": PROBING,
    "CONTOUR": SL,
    **dict.fromkeys(
        ("FPOL", "FL", "FLT", "FC", "FCT"), "free contour programming; let the CAM system write lines and arcs"
    ),
    "SEL": "files of the control; write CALL PGM for a program, cycles 251 to 257 for a contour",
    **dict.fromkeys(("OPEN", "POLARKIN"), "files and kinematics of the control"),
    "ERROR": "the control has marked this block as one that it could not read",
}
#: What the functions of FN that are not executed would do.
REFUSED_FN: Final = {
    17: "SYSWRITE changes data of the control",
    19: "PLC: values of the machine",
    20: "WAIT FOR: conditions of the machine",
    26: "tables are not read",
    27: "tables are not written",
    28: "tables are not read",
    29: "PLC: values of the machine",
    37: "EXPORT: cycles of the user",
    38: "SEND: data to other computers",
}


class Q:
    """Q parameters of cycles, by what they are there."""

    CLEARANCE, DEPTH, INFEED, SURFACE, SECOND_CLEARANCE, SMALLEST_INFEED = 200, 201, 202, 203, 204, 205
    PLUNGE_FEED, MILLING_FEED, RETRACT_FEED, DWELL_ABOVE, DWELL_BELOW, DECREMENT = 206, 207, 208, 210, 211, 212
    BREAKS, DIRECTION, OPERATION, CENTER_X, CENTER_Y, LENGTH, WIDTH, CORNER = 213, 214, 215, 216, 217, 218, 219, 220
    BLANK_DIAMETER, DIAMETER, ROTATION, START_X, START_Y, START_Z, STEP_X = 222, 223, 224, 225, 226, 227, 237
    STEP_Y, PITCH, HOLES, COLUMNS, ROWS, CIRCLE, START_ANGLE, STOP_ANGLE = 238, 239, 241, 242, 243, 244, 245, 246
    ANGLE_STEP, OPENING, BORE_DEPTH, THICKNESS, OFFSET, EDGE_HEIGHT = 247, 248, 249, 250, 251, 252
    POSITIONING_FEED, BORE_FEED, BORE_DWELL, CHIP_RETRACT, CHIP_DEPTH, UPPER_STOP = 253, 254, 255, 256, 257, 258
    LOWER_STOP, GO_HIGH, HELIX_PITCH, HOLE_DIAMETER, SPINDLE_ANGLE, FINISHING_INFEED = 259, 301, 334, 335, 336, 338
    PREDRILLED_DIAMETER, CENTRING_DIAMETER, FEED_SHARE_PERCENT = 342, 344, 401
    BY_DIAMETER, FIRST_LIMIT, SECOND_LIMIT, THIRD_LIMIT, AXIS, CLIMB = 343, 347, 348, 349, 350, 351
    SIDE_CLEARANCE, ALONG_CIRCLE, PLUNGING, POSITION, SIDE_ALLOWANCE, FLOOR_ALLOWANCE = 357, 365, 366, 367, 368, 369
    OVERLAP, SLOT_ROTATION, PITCH_DIAMETER, FIRST_ANGLE, SLOTS, SLOT_STEP = 370, 374, 375, 376, 377, 378
    START_DEPTH, FINISHING_FEED, END_Z, STRATEGY, DEPTH_OF_SHANK, RETRACT_FACTOR = 379, 385, 386, 389, 395, 403
    BLANK_LENGTH, BLANK_WIDTH, ENTRY_SENSE, ENTRY_SPEED, DRILLING_SPEED, COOLANT_IN = 424, 425, 426, 427, 428, 429
    COOLANT_OUT, DWELL_DEPTH, APPROACH, FEED_REFERENCE, TURNS, APPROACH_FEED = 430, 435, 437, 439, 355, 512
    SINKING_DEPTH, FRONT_DEPTH, FRONT_OFFSET, SINKS_AFTER = 356, 358, 359, 360
    REFERENCE_DIAMETER, CORNERS, REFERENCE, PRESET_NUMBER = 571, 572, 573, 339


def name_parameter(number: int) -> str:
    """What a Q parameter of cycles is, in words, as "surface" for 203; empty for one that no cycle has."""
    return next((name.lower().replace("_", " ") for name, value in vars(Q).items() if value == number), "")


#: Q parameters whose unit is none of length, by that unit.
_UNITS: Final = {
    "per minute, in the unit of the program": (206, 207, 208, 253, 254, 385, 512),
    "s": (210, 211, 255),
    "degrees": (224, 245, 246, 247, 248, 336, 374, 376, 378),
    "1/min": (427, 428),
    "percent": (401,),
    "": (213, 241, 242, 243, 339, 347, 348, 349, 355, 370, 377, 389, 403, 426, 429, 430, 437, 439, 572, 573),
}
#: Q parameters whose names do not say enough: which side it is, and what the values of a switch mean.
_MORE: Final = {
    214: "of the retract: 0 none, 1 -X, 2 -Y, 3 +X, 4 +Y",
    215: "0 roughing and finishing, 1 roughing alone, 2 finishing alone",
    218: "first side, along X of the cycle, in the unit of the program",
    219: "second side, along Y of the cycle, or width of a slot, in the unit of the program",
    301: "way between the places: 0 at the set-up clearance Q200, 1 at the second one, Q204",
    343: "0 by the depth Q201, 1 by the diameter Q344",
    350: "of the paths: 1 along X, 2 along Y of the cycle",
    351: "1 climb milling, -1 conventional milling",
    360: "0 sinks before the thread, 1 after it",
    365: "way between the places: 0 along a line, 1 along the circle",
    366: "0 straight down, 1 on a helix, 2 swinging (cycle 252 has no 2)",
    367: "of the tool on call; of a pocket or stud: 0 in the middle, 1 to 4 at a corner, from -X -Y on, anticlockwise",
    395: "the depth is that of 0 the tip, 1 the cylindrical shank",
}


def describe_parameter(number: int) -> str:
    """Name of a Q parameter of cycles with its unit, or with what its values mean; empty for one that no cycle has."""
    unit = next((unit for unit, numbers in _UNITS.items() if number in numbers), "in the unit of the program")
    return ", ".join(filter(None, (name_parameter(number), _MORE.get(number, unit)))) if name_parameter(number) else ""
