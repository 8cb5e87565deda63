"""M functions of Klartext: what they are in words of RS274/NGC, and those without effect or refused."""

import math
from collections.abc import Mapping
from typing import Final

from verne_post.model.moves import ArcFeed

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
WITHOUT_EFFECT: Final = {
    6: "tool change: TOOL CALL has made it", 90: "smoothing of corners; cycle 32 sets the tolerance",
    102: "end of M101", 104: "back to the last preset: there is one", 105: "lag compensation", 106: "lag compensation",
    107: "no error message for replacement tools", 108: "end of M107", 113: "end of M112",
    119: "end of M118", 120: "look-ahead under compensation", 121: "end of M120", 135: "end of M134", 145: "end of M144",
    149: "end of M148", 199: "end of M197",
}  # fmt: skip
REFUSED: Final = {
    97: "machining of small steps of the contour",
    98: "complete machining of open contours", 101: "change to a replacement tool when the tool life is over",
    103: "reduced feed rate when plunging", 112: "corner rounding between lines; cycle 32 sets the tolerance",
    114: "compensation of the machine's geometry; M128 does that", 115: "end of M114", 118: "handwheel during the program",
    124: "filter of contour points", 134: "exact stop of rotary axes", 138: "choice of axes for tilting",
    141: "no touch-probe monitoring", 142: "deletes modal information", 143: "deletes the basic rotation",
    144: "positions of the table in the tool position", 148: "retract at a stop", 150: "suppresses limit switch messages",
    197: "rounding of outside corners", **dict.fromkeys(range(200, 205), "laser cutting"),
}  # fmt: skip
