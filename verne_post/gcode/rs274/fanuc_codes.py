"""The codes of Fanuc controls: what each does, the words that it takes, and which are refused.

docs/make_words.py makes the tables of docs/fanuc.md of it, with what RS274/NGC does not have or does otherwise.
"""

from collections.abc import Mapping
from typing import Final

from verne_post.gcode.codes import AT_START, RS274, CodeTable, end_texts

#: Codes of the control that are not in RS274/NGC: tilted plane, its axis, its end, additional work systems.
PLANE, TO_PLANE, PLANE_OFF, ADDITIONAL = 682, 531, 690, 541
#: G53.6, which turns to the plane about the tip; G68, G68.3; G51, G50, G51.1, G50.1.
ABOUT_TIP, ROTATION, OF_TOOL, SCALE, SCALE_OFF, MIRROR, MIRROR_OFF = 536, 680, 683, 510, 500, 511, 501
#: G254, G255 of Haas: the work system turns about its origin with the table, its axes stay those of the machine.
TABLE, TABLE_OFF = 2540, 2550
#: Codes that say what words of X, Y, Z mean from there on, and take those of their block.
OF_FRAMES: Final = (PLANE, ROTATION, OF_TOOL, SCALE, MIRROR)
#: Words of each.
WORDS_OF_FRAMES: Final = {
    PLANE: "XYZIJKRPQ",
    ROTATION: "XYZIJKR",
    OF_TOOL: "XYZR",
    SCALE: "XYZIJKP",
    MIRROR: "XYZ",
    MIRROR_OFF: "XYZ",
}
#: NURBS interpolation, G6.2.
NURBS: Final = 62
#: Accepted, and shown as events: look-ahead and its like change how a control smooths, not where the tool goes.
SMOOTHING: Final = (50, 51, 54, 80)
#: G5 P: high-speed modes off and on; other numbers call cycles.
HIGH_SPEED: Final = (0, 1, 2, 3, 10000)
#: Automatic override at corners.
OVERRIDE: Final = 620
#: Tool-centre-point control of other controls, and offsets along the tool axis: here they are what G43.4 is.
TWINS: Final = {431: 434, 2340: 434, 1540: ADDITIONAL}
#: Work systems of Haas: G110 is G154 P1, and so on. G112 and G113 are polar coordinates on other controls.
NUMBERED_SYSTEMS: Final = {1100 + 10 * number: number + 1 for number in range(20) if number not in (2, 3)}
#: Mirror images of Haas, in the words of Fanuc.
MIRRORS_OF_HAAS: Final = {1010: MIRROR, 1000: MIRROR_OFF}
#: Codes of Haas controls: how corners are smoothed, and how far a control reads ahead.
LOOK_AHEAD: Final = (1870, 1030)
#: Ends of modes that cannot be begun: nothing to do.
ENDS: Final = (401, 670, 131, 970)
#: Round pockets of Haas (G12, G13), and patterns of holes: a circle, an arc, a row.
POCKETS: Final = (120, 130)
CIRCLE_OF_HOLES, ARC_OF_HOLES, ROW_OF_HOLES = 700, 710, 720
PATTERNS: Final = (CIRCLE_OF_HOLES, ARC_OF_HOLES, ROW_OF_HOLES)
#: I J K from the start of the arc, which Mach4 writes: they always are.
CENTERS_FROM_START: Final = 911
#: Dynamic fixture offset, which turns with the table, and workpiece setting error compensation. P0 ends them, as heads
#: of programs do; the data of others are in the control.
FIXTURES: Final = (542, 544)
#: Forbidden zones on and off, and a watch on the spindle: the machine file has the limits.
WATCHING: Final = (220, 230, 250, 260)
#: Codes that change no move.
WITHOUT_EFFECT: Final = (*SMOOTHING, *LOOK_AHEAD, *ENDS, CENTERS_FROM_START, *FIXTURES, *WATCHING)
#: Codes that name axes without moving them, and those that take none.
NAMES_AXES: Final = (51, MIRROR_OFF, 220)
ALONE: Final = (80, 150, 160, SCALE_OFF, *ENDS, *LOOK_AHEAD, TABLE, TABLE_OFF, PLANE_OFF, TO_PLANE, ABOUT_TIP)


#: Words that are no codes, and what they do.
WORDS: Final[Mapping[str, str]] = {
    "#1=": "a variable: local #1 to #33, common #100 to #999 (#98000 to #98499, #900000 to #907399), and expressions: "
    "see Variables",
    ",C ,R": "chamfer (its size on each line), or rounding (between lines and arcs in X and Y). The next block must be "
    "the next line or arc",
    "H": "H alone in a block, while G43 is active, changes the length; H0 ends it. G43 without H takes the last H "
    "since the tool change",
}
#: In place of codes that are not executed.
_INSTEAD: Final = {433: "G43.4", 630: "G84", 661: "G66"}
_ENDS_MODE: Final = "ends a mode; no effect where none is active"
#: What holds for all cycles.
_KEPT_WORDS: Final = "R, Z, Q and P are kept for other cycles, until G80: see Cycles"
#: What G codes do that RS274/NGC does not have, or does otherwise; by group, with all codes of a group that differs.
_GROUPS: Final[Mapping[str, Mapping[int, str]]] = {
    "non-modal": {
        40: "dwell: P milliseconds, with a decimal point seconds; X and U seconds",
        100: "L2, L20: origins; L10 to L13 of tool P: length, its wear, radius, its wear; wear is added",
        280: "rapid traverse to the reference position, by way of the place given",
        300: "rapid traverse to the second reference position (P2), by way of the place given",
        520: "a local system inside that of G92",
        920: RS274.g_groups["non-modal"][920],
        921: RS274.g_groups["non-modal"][921],
        **end_texts(
            ": see Circles of Haas",
            {
                120: "Haas, in G17: mills a circle of radius I about the tool, clockwise",
                130: "Haas, in G17: mills a circle of radius I about the tool, counter-clockwise",
            },
        ),
        CIRCLE_OF_HOLES: "Haas: L holes of the cycle in force, evenly on a circle of radius I about X Y, or about the "
        "tool; the first is at the angle J",
        ARC_OF_HOLES: "Haas: L holes of the cycle in force on an arc of radius I about X Y, or about the tool, K "
        "degrees apart; the first is at the angle J",
        ROW_OF_HOLES: "Haas: L holes of the cycle in force in a row at the angle J, I apart; *unverified*: the "
        "first is at X Y, or at the tool",
    },
    "cancel": {800: "ends the canned cycle; axis words beside it move with the code that was in force before it"},
    "motion": {
        **{code: RS274.g_groups["motion"][code] for code in (0, 10, 20, 30)},
        NURBS: "NURBS interpolation: see Splines",
        **end_texts(
            f"; {_KEPT_WORDS}",
            {
                730: "drilling with chip breaking",
                810: "drilling",
                820: "drilling with a dwell at the bottom",
                830: "deep-hole drilling, out of the hole after each peck",
                850: "boring, in and out at feed rate",
                860: "boring, out in rapid traverse with the spindle at rest",
                880: "boring, stops for the operator",
                890: "boring with a dwell, out at feed rate",
            },
        ),
        **end_texts(": see Tapping", {740: "tapping, left-hand thread", 840: "tapping, right-hand thread"}),
        760: "fine boring: oriented stop, then away from the wall by I and J, or by Q in the direction of `bore_shift` "
        '(`"+X"`, `"-X"`, `"+Y"`, `"-Y"`) in `[fanuc]`',
    },
    "tool length": {
        **{code: RS274.g_groups["tool length"][code] for code in (430, 434, 435, 490)},
        431: "tool-centre-point control on, with the tool length of H (G43.4); *unverified*: on a Fanuc it may be "
        "length compensation along the tool axis",
        2340: "tool-centre-point control on, with the tool length of H (G43.4)",
    },
    "cutter compensation": {code: RS274.g_groups["cutter compensation"][code] for code in (400, 410, 420)},
    "work offset": {
        **{code: RS274.g_groups["work offset"][code] for code in (550, 560, 570, 580, 590)},
        540: "work offset G54: coordinates count from its zero; G54 P1 is G54.1 P1",
        ADDITIONAL: 'additional work offset, of the number P from 1 to 48; --wcs "G54.1P3=x,y,z"',
        1540: 'Haas: additional work offset, of the number P from 1 to 48; --wcs "G54.1P3=x,y,z"',
        **{code: f"Haas: work offset, the same as G154 P{number}" for code, number in NUMBERED_SYSTEMS.items()},
    },
    "path control": {
        610: "a stop at the end of every move",
        OVERRIDE: "ends G61, as G64 does: corners are blended within the tolerance",
        640: "corners are blended: see Path control",
    },
    "exact stop": {90: "exact stop at the end of the block"},
    "tilted plane": {
        PLANE: "tilts the work plane, by angles, points or directions: see Tilted planes",
        ROTATION: "turns coordinates in the plane; with I J K about a direction, and one more G68 may be nested: see "
        "Turns, scales, mirror images",
        OF_TOOL: "the plane of the tool: Z along it, X level, turned by R. A note (VP039) names parameter 12321",
        PLANE_OFF: "ends G68, G68.2 and G68.3",
    },
    "plane axis": {
        TO_PLANE: "turns the rotary axes until the tool is normal to the tilted plane",
        ABOUT_TIP: "turns the rotary axes until the tool is normal to the tilted plane, while the tip stays in place",
    },
    "dynamic work offset": {
        TABLE: "Haas: dynamic work offset on: the zero turns with the table; X, Y, Z follow the axes of the machine",
        TABLE_OFF: "Haas: dynamic work offset off",
    },
    "scaling": {
        SCALE: "scales about a point by P, or each axis by its own factor I, J, K",
        SCALE_OFF: "ends the scale of G51",
    },
    "mirror image": {MIRROR: "mirrors an axis about a place", MIRROR_OFF: "ends the mirror image of G51.1"},
    "polar coordinates": {
        160: "polar coordinates on, in G17: X is the distance from X0 Y0, Y the angle; in G91 Y alone is allowed,"
        " and adds up",
        150: "polar coordinates off",
    },
    "look-ahead": {
        1870: "Haas: chooses how smoothly corners are machined (P, E); no effect on the rows, shown as an event",
        1030: "Haas: limits how many blocks the control reads ahead (P); no effect on the rows, shown as an event",
    },
    "smoothing": dict.fromkeys(
        SMOOTHING, "look-ahead and smoothing of the control; no effect on the rows, shown as events"
    ),
    "macro call": {
        650: "calls a macro with arguments and its own variables; L repeats: see Arguments",
        660: "calls a macro after every block that moves, until G67; its variables are kept from one call to the next",
    },
    **{f"end of G{code / 10:g}": {code: _ENDS_MODE} for code in ENDS},
    "end of G67": {670: "ends the calls of the macro of G66"},
    "fixture offset": dict.fromkeys(
        FIXTURES, "P0 ends the fixture offset or the setting error compensation; others are refused"
    ),
    "watching": {
        220: "watches forbidden zones; no effect, the machine file has the limits",
        230: "ends the watch on forbidden zones; no effect",
        250: "ends the watch on the spindle; no effect",
        260: "watches the spindle; no effect",
    },
    "centres of arcs": {CENTERS_FROM_START: "Mach4: I J K count from the start of the arc; they always do"},
}


def make_table() -> CodeTable:
    retract = RS274.g_groups["retract"]
    at_start = {980: retract[980] + AT_START, 990: retract[990].removesuffix(AT_START)}
    groups = {**RS274.g_groups, "retract": at_start, **_GROUPS}
    del groups["arc distance"], groups["lathe diameter"], groups["spindle mode"]
    m_groups = {name: RS274.m_groups[name] for name in ("stopping", "coolant")} | {
        "subprograms": {
            97: "Haas: a subprogram that begins at block P of the program, L times",
            98: "the subprogram O P, L times; P30012 is O30012 where that is there, else O12 three times",
            99: "end of a subprogram; with P it returns to a block; in the main program a jump",
        },
        "tool change": {6: RS274.m_groups["tool change"][6]},
        "override": {code: RS274.m_groups["override"][code] for code in (48, 49)},
        "spindle": {code: RS274.m_groups["spindle"][code] for code in (3, 4, 5, 19)},
        "rigid tapping": {29: "the next G84 or G74 is rigid tapping: see Tapping"},
    }
    return CodeTable(
        g_groups=groups,
        m_groups=m_groups,
        instead_of_g=_INSTEAD,
        refused_g={
            **dict.fromkeys(
                (310, 350, 360, 370, 1360),
                "probing and tool measurement: where the tool touches is only known at the machine; take it out",
            ),
            1500: "pockets of Haas inside a contour; write G12 or G13 for a round one, or let the CAM system write "
            "the moves",
            470: "engraving; let the CAM system write the lines of the letters",
            770: "back boring of Haas, from below; write the moves",
            **dict.fromkeys(
                (1120, 1130),
                "a work offset of Haas (G154 P3, P4), or polar axes of other controls; write G154 P, or X Y Z",
            ),
            **dict.fromkeys(
                (1070, 71, 121),
                "coordinates on a cylinder or by polar axes; let the CAM system write X Y Z with the rotary axes",
            ),
            **dict.fromkeys(
                (1410, 1430),
                "offsets for a program that is made for one machine and one tool length; let the CAM system write "
                "G43.4 or G234",
            ),
            **dict.fromkeys((681, 684), "tilted planes on planes; write one G68.2"),
            **dict.fromkeys(
                (2530, 2680, 2690), "tilted planes of Haas; let the CAM system write G254, or write G68.2 and G53.1"
            ),
            **dict.fromkeys((24, 34), "arcs in space; let the CAM system write lines"),
            **dict.fromkeys((22, 32, 23, 33), "involutes and exponential curves; let the CAM system write lines"),
            **dict.fromkeys(
                (412, 422, 413, 423, 414, 424, 415, 425, 416, 426),
                "cutter compensation in space: the program has the contour; let the CAM system write where "
                "the tool's centre goes",
            ),
            **dict.fromkeys((411, 421), "C follows the contour; let the CAM system write C"),
            **dict.fromkeys(
                (438, 439), "the program has the point that cuts; let the CAM system write the tip, for G43.4 or G43.5"
            ),
            433: f"the tool length of a nutating head; write {_INSTEAD[433]}",
            330: "thread cutting; write G84, or the helix",
            **dict.fromkeys(
                (270, 301), "reference positions that the control checks or stores; write G28, G30 P2 or G53"
            ),
            110: "the end of data that G10 L50 enters; take both out",
            382: "probing of RS274/NGC; take it out",
            630: f"tapping without feed override; write {_INSTEAD[630]}",
            **dict.fromkeys((841, 842, 1740, 1840), "tapping of other controls; write G84 or G74"),
            661: f"a macro call after every block; write {_INSTEAD[661]}",
            870: "on Fanuc back boring from below, so write the moves; on Haas a stop for the operator in the hole, so "
            "write G88",
            440: "subtracts the tool length of H, which G43 adds; write G43, and the length with the other sign",
            **dict.fromkeys((441, 442, 450), "other offsets of the tool; write G43 for its length, G41 for its radius"),
            960: "constant surface speed",
            **dict.fromkeys((611, 432, 901, 591, 592, 593), "codes of RS274/NGC; see --dialect rs274"),
        },
        refused_m={
            25: "on Centroid controls Z goes to its home; write G91 G28 Z0 and G90 in its place",
            198: "calls a program of another device; write M98, and put its file beside the program",
        },
        words_of_g={
            **RS274.words_of_g,
            20: "IJKR",
            30: "IJKR",
            430: "HD",
            ADDITIONAL: "P",
            PLANE: "IJK",
            50: "P",
            51: "PQR",
            54: "Q",
            **dict.fromkeys(FIXTURES, "P"),
            220: "XYZIJK",
            260: "PQRI",
            TO_PLANE: "P",
            NURBS: "PKR",
            80: "P",
            640: "",
            ABOUT_TIP: "HR",
            1870: "PE",
            1030: "P",
            **dict.fromkeys((730, 830), "RLQPIJK"),
            810: "RLPQ",
            **dict.fromkeys((740, 840), "RLPQJ"),
            760: "RLPQIJ",
            **dict.fromkeys(POCKETS, "DIKLQ"),
            CIRCLE_OF_HOLES: "IJL",
            ARC_OF_HOLES: "IJKL",
            ROW_OF_HOLES: "IJL",
        },
        words_of_m={**RS274.words_of_m, 97: "PL", 99: "P"},
    )
