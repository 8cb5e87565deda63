"""Words of Klartext: which are executed, which have no effect here, which are refused and why; names of Q parameters.

docs/heidenhain.md has the same tables, made by docs/make_words.py; a test runs every one of their words.
"""

import math
from collections.abc import Mapping
from typing import Final

from verne_post.model.moves import ArcFeed

#: Why contours of cycles, and probing, are refused.
SL: Final = "contours of SL cycles; write cycles 251 to 257, or the contour with RL or RR, or let the CAM system write the moves"
PROBING: Final = (
    "touch probes: where the tool touches is only known at the machine; take them out, and give the datum with --wcs"
)
#: M function -> M codes of RS274/NGC, at the beginning of the block.
AT_BEGIN: Final = {3: (3,), 4: (4,), 7: (7,), 8: (8,), 13: (3, 8), 14: (4, 8)}
#: The same at its end.
AT_END: Final = {0: (0,), 1: (1,), 2: (2,), 5: (5,), 9: (9,), 30: (30,)}
#: Executed by Klartext itself.
OWN: Final = {
    19: "orientation of the spindle to the angle of cycle 13",
    89: "modal cycle call", 91: "coordinates of the machine in this block", 92: "coordinates from [home] g30 in this block",
    94: "A and C are reduced to less than a turn", 99: "cycle call in this block",
    109: "F holds at the cutting edge on arcs", 110: "the same on inside arcs alone", 111: "end of M109 and M110", 116: "F of rotary axes in mm/min",
    117: "end of M116", 126: "A and C take the shorter way", 127: "end of M126", 128: "tool-centre-point control",
    129: "end of M128", 130: "coordinates of the untilted system in this block", 136: "F in mm per turn of the spindle",
    137: "end of M136", 140: "retract along the tool axis: MB, MB MAX",
}  # fmt: skip
#: Where F holds on arcs.
ARC_FEEDS: Final[Mapping[int, ArcFeed]] = {
    109: ArcFeed("M109", 0.0, math.inf),
    110: ArcFeed("M110", 0.0, 1.0),
    111: ArcFeed(),
}
#: How the control reacts or smooths, or ends of modes that cannot be begun.
FUNCTIONS_WITHOUT_EFFECT: Final = {
    6: "tool change: TOOL CALL has made it", 90: "smoothing of corners; cycle 32 sets the tolerance",
    102: "end of M101", 104: "back to the last preset: there is one", 105: "lag compensation", 106: "lag compensation",
    107: "no error message for replacement tools", 108: "end of M107", 113: "end of M112",
    119: "end of M118", 120: "look-ahead under compensation", 121: "end of M120", 135: "end of M134", 145: "end of M144",
    149: "end of M148", 199: "end of M197",
}  # fmt: skip
#: M functions that are known and not executed.
REFUSED_FUNCTIONS: Final = {
    97: "machining of small steps of the contour",
    98: "complete machining of open contours", 101: "change to a replacement tool when the tool life is over",
    103: "reduced feed rate when plunging", 112: "corner rounding between lines; cycle 32 sets the tolerance",
    114: "compensation of the machine's geometry; M128 does that", 115: "end of M114", 118: "handwheel during the program",
    124: "filter of contour points", 134: "exact stop of rotary axes", 138: "choice of axes for tilting",
    141: "no touch-probe monitoring", 142: "deletes modal information", 143: "deletes the basic rotation",
    144: "positions of the table in the tool position", 148: "retract at a stop", 150: "suppresses limit switch messages",
    197: "rounding of outside corners", **dict.fromkeys(range(200, 205), "laser cutting"),
}  # fmt: skip
#: Cycles that setpoints do not know.
CYCLES_WITHOUT_EFFECT: Final = {
    332: "tunes the drives for a tolerance",
    392: "tunes the drives for the weight of the part",
}
#: Cycles that are known and not executed.
REFUSED_CYCLES: Final = {
    1: "pecking of older controls; write cycle 200", 2: "tapping of older controls; write cycle 206",
    3: "slot milling of older controls; write cycle 253", 4: "pocket milling of older controls; write cycle 251", 5: "circular pocket of older controls; write cycle 252",
    6: SL, 12: "program call as a cycle; write CALL PGM", 14: SL, 15: SL, 16: SL, 17: "rigid tapping of older controls; write cycle 207", 18: "thread cutting: setpoints cannot wait for the spindle; write cycle 207",
    **dict.fromkeys((20, 21, 22, 23, 24, 25, 270, 271, 272, 273, 274, 275, 276), SL), **dict.fromkeys((285, 286, 287), "gears; let the CAM system write the moves"),
    26: "axis-specific scaling: circles would become ellipses; let the CAM system scale the contour", **dict.fromkeys((27, 28, 29, 39), "cylinder surface; let the CAM system write X Y Z A C"),
    30: "3-D data from files; let the CAM system write the lines",
    225: "engraving; let the CAM system write the lines of the letters", 230: "multipass milling of older controls; write cycle 233",
    231: "ruled surface; let the CAM system write the moves", 239: "weighs the workpiece; take it out",
    258: "polygon stud; write its sides with RL or RR", **dict.fromkeys((263, 264, 265, 267), "thread milling with countersinking, without a hole, or outside; write cycle 262, or let the CAM system write the helix"),
    **dict.fromkeys(range(400, 500), PROBING), **dict.fromkeys(range(800, 900), "turning and gear cycles; let the CAM system write the moves of a mill"),
}  # fmt: skip
#: Words that begin statements which are not executed, and why.
REFUSED_STATEMENTS: Final = {
    "TCH": PROBING, "CONTOUR": SL, **dict.fromkeys(("FPOL", "FL", "FLT", "FC", "FCT"), "free contour programming; let the CAM system write lines and arcs"),
    "SEL": "files of the control; write CALL PGM for a program, cycles 251 to 257 for a contour", **dict.fromkeys(("OPEN", "POLARKIN"), "files and kinematics of the control"), "ERROR": "the control has marked this block as one that it could not read",
}  # fmt: skip
#: What the functions of FN that are not executed would do.
REFUSED_FN: Final = {
    17: "SYSWRITE changes data of the control", 19: "PLC: values of the machine", 20: "WAIT FOR: conditions of the machine",
    26: "tables are not read", 27: "tables are not written", 28: "tables are not read", 29: "PLC: values of the machine",
    37: "EXPORT: cycles of the user", 38: "SEND: data to other computers",
}  # fmt: skip


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
    BY_DIAMETER, FIRST_LIMIT, SECOND_LIMIT, THIRD_LIMIT, AXIS, CLIMB = 343, 347, 348, 349, 350, 351
    SIDE_CLEARANCE, ALONG_CIRCLE, PLUNGING, POSITION, SIDE_ALLOWANCE, FLOOR_ALLOWANCE = 357, 365, 366, 367, 368, 369
    OVERLAP, SLOT_ROTATION, PITCH_DIAMETER, FIRST_ANGLE, SLOTS, SLOT_STEP = 370, 374, 375, 376, 377, 378
    START_DEPTH, FINISHING_FEED, END_Z, STRATEGY, DEPTH_OF_SHANK, RETRACT_FACTOR = 379, 385, 386, 389, 395, 403
    BLANK_LENGTH, BLANK_WIDTH, ENTRY_SENSE, ENTRY_SPEED, DRILLING_SPEED, COOLANT_IN = 424, 425, 426, 427, 428, 429
    COOLANT_OUT, DWELL_DEPTH, APPROACH, FEED_REFERENCE, TURNS, APPROACH_FEED = 430, 435, 437, 439, 355, 512
