"""The codes of Fanuc controls: which there are, the words that each takes, and which are refused."""

from collections.abc import Iterable
from typing import Final

from verne_post.gcode.codes import RS274, CodeTable, refuse_known_codes

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
SMOOTHING: Final = (50, 51, 80)
#: G5 P: high-speed modes off and on; other numbers call cycles.
HIGH_SPEED: Final = (0, 1, 2, 3, 10000)
#: Tool-centre-point control of other controls, and offsets along the tool axis: here they are what G43.4 is.
TWINS: Final = {431: 434, 2340: 434, 1540: ADDITIONAL}
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
#: Codes that name axes without moving them, and those that take none.
NAMES_AXES: Final = (51, MIRROR_OFF)
ALONE: Final = (80, 150, 160, SCALE_OFF, *ENDS, *LOOK_AHEAD, TABLE, TABLE_OFF, PLANE_OFF, TO_PLANE, ABOUT_TIP)
#: Cycles that mean what they mean in RS274/NGC.
CYCLES: Final = (730, 740, 760, 810, 820, 830, 840, 850, 860, 880, 890)


def make_table() -> CodeTable:
    groups = {name: tuple(code for code in codes if code not in (70, 80)) for name, codes in RS274.g_groups.items()}
    del groups["lathe diameter"], groups["spindle mode"]
    groups["non-modal"] = (40, 100, 280, 300, 520, 920, 921, *POCKETS, *PATTERNS)
    groups["motion"] = (0, 10, 20, 30, NURBS, *CYCLES)
    groups["arc distance"] = ()
    groups["tool length"] = (430, 434, 435, 490, 431, 2340)
    groups["cutter compensation"] = (400, 410, 420)
    groups["work offset"] = (540, 550, 560, 570, 580, 590, ADDITIONAL, 1540)
    groups["path control"] = (610, 640)
    groups["exact stop"] = (90,)
    groups["tilted plane"] = (PLANE, ROTATION, OF_TOOL, PLANE_OFF)
    groups["plane axis"] = (TO_PLANE, ABOUT_TIP)
    groups["dynamic work offset"] = (TABLE, TABLE_OFF)
    groups["scaling"], groups["mirror image"] = (SCALE, SCALE_OFF), (MIRROR, MIRROR_OFF)
    groups["polar coordinates"] = (150, 160)
    groups["look-ahead"] = LOOK_AHEAD
    groups["smoothing"] = SMOOTHING
    groups["macro call"] = (650, 660)
    for code in ENDS:
        groups[f"end of G{code / 10:g}"] = (code,)
    m_groups = {
        name: RS274.m_groups[name] for name in ("stopping", "tool change", "coolant", "override", "subprograms")
    }
    m_groups |= {
        "subprograms": (97, 98, 99),
        "tool change": (6,),
        "override": (48, 49),
        "spindle": (3, 4, 5, 19),
        "rigid tapping": (29,),
    }
    return CodeTable(
        g_groups=groups,
        m_groups=m_groups,
        refused_g={
            **dict.fromkeys((310, 350, 360, 370, 1360), "probing and tool measurement: where the tool touches is only known at the machine; take it out"),
            1500: "pockets of Haas inside a contour; write G12 or G13 for a round one, or let the CAM system write the moves",
            470: "engraving; let the CAM system write the lines of the letters",
            770: "back boring of Haas, from below; write the moves", **dict.fromkeys((*range(1100, 1300, 10),), "work offsets of Haas, with numbers that differ between its controls, or polar axes; write G154 P"),
            **dict.fromkeys((1070, 71, 121), "coordinates on a cylinder or by polar axes; let the CAM system write X Y Z A C"),
            **dict.fromkeys((1410, 1430), "offsets for a program that is made for one machine and one tool length; let the CAM system write G43.4 or G234"),
            **dict.fromkeys((681, 684), "tilted planes on planes; write one G68.2"),
            **dict.fromkeys((841, 842, 1740, 1840), "tapping of other controls; write G84 or G74"),
            661: "a macro call after every block; write G66",
            870: "on Fanuc back boring from below, so write the moves; on Haas a stop for a person in the hole, so write G88",
            **dict.fromkeys((441, 442, 450, 440), "tool offsets by H that RS274/NGC does not have"),
            960: "constant surface speed",
            **dict.fromkeys((611, 432, 901, 911, 591, 592, 593), "codes of RS274/NGC; see --dialect rs274"),
        },
        refused_m={},
        words_of_g={
            **RS274.words_of_g, 20: "IJKR", 30: "IJKR", 430: "HD", ADDITIONAL: "P", PLANE: "IJK", 50: "P", 51: "PQR", NURBS: "PKR", 80: "P", 640: "", ABOUT_TIP: "HR", 1870: "PE", 1030: "P", **dict.fromkeys((730, 830), "RLQPIJK"), **dict.fromkeys((740, 840), "RLPQJ"), 760: "RLPQIJ", **dict.fromkeys(POCKETS, "DIKLQ"), CIRCLE_OF_HOLES: "IJL", ARC_OF_HOLES: "IJKL", ROW_OF_HOLES: "IJL",
        },
        words_of_m={**RS274.words_of_m, 97: "PL", 99: "P"},
    )  # fmt: skip


def refuse_codes_of_blocks(remap: Iterable[str]) -> None:
    """Refuse new meanings of codes that both RS274/NGC and Fanuc controls execute; for others a block decides.

    Raises
    ------
    ValueError
    """
    if codes := list(remap):
        refuse_known_codes(codes, RS274, make_table())
