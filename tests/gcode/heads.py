"""How programs begin: heads as CAM systems and people write them, and first moves, each in four dialects.

Nothing here is copied from a post-processor: each head has the order of blocks that such programs have. docs/starts.md
shows them in RS274 words, and where each combination starts.
"""

import math
from typing import Final

DIALECTS: Final = ("rs274", "fanuc", "siemens", "heidenhain")
#: Where the tool first goes, mm and degrees.
X, Y, Z, A, C = -30.0, 20.0, 50.0, 30.0, 40.0
#: A tool of this length is in the table as tool 1, and the part's zero lies so high over the table face.
LENGTH, PART_HEIGHT = 80.0, 60.0

#: What a head does, in order. Steps are below; "tool" is the tool change.
HEADS: Final = {
    "Fusion 360, G28": "retract tool spindle system table",
    "Fusion 360, G53": "lift tool spindle system",
    "Mastercam": "tool system table spindle",
    "Mastercam, home": "retract home_xy tool system spindle",
    "SolidCAM": "lift lift_xy table_home tool system spindle",
    "PowerMill": "retract_all turn_home tool system spindle",
    "FreeCAD": "system tool length spindle",
    "NX": "retract tool table system spindle",
    "by hand, short": "tool system spindle",
    "by hand, retract after the tool": "tool spindle retract system",
    "by hand, all axes home": "all_home tool system spindle",
    "by hand, stops": "lift table stop tool lift stop system spindle",
}

_ISO: Final = {
    "retract": "G91 G28 Z0\nG90", "retract_all": "G91 G28 X0 Y0 Z0\nG90", "home_xy": "G91 G28 X0 Y0\nG90",
    "turn_home": "G91 G28 A0 C0\nG90",
    "all_home": "G28", "lift": "G53 G0 Z0", "lift_xy": "G53 G0 X0 Y0", "table_home": "G53 G0 A0 C0",
    "table": "G0 A0 C0", "tool": "T1 M6",
    "system": "G54", "length": "G43 H1", "spindle": "S9000 M3", "stop": "M0",
}  # fmt: skip
_SIEMENS: Final = {
    "retract": "G0 SUPA Z0 D0", "retract_all": "G0 SUPA X0 Y0 Z0 D0", "home_xy": "G0 SUPA X0 Y0",
    "turn_home": "G0 SUPA A0 C0",
    "all_home": "G0 SUPA X0 Y0 Z0 A0 C0 D0", "lift": "G0 SUPA Z0 D0", "lift_xy": "G0 SUPA X0 Y0 D0",
    "table_home": "G0 SUPA A0 C0", "table": "G0 A0 C0",
    "tool": "T1 M6", "system": "G54", "length": "D1", "spindle": "S9000 M3", "stop": "M0",
}  # fmt: skip
_KLARTEXT: Final = {
    "retract": "L Z+0 R0 FMAX M91", "retract_all": "L X+0 Y+0 Z+0 R0 FMAX M91", "home_xy": "L X+0 Y+0 R0 FMAX M91",
    "turn_home": "L A+0 C+0 R0 FMAX M91",
    "all_home": "L X+0 Y+0 Z+0 A+0 C+0 R0 FMAX M91", "lift": "M140 MB MAX", "lift_xy": "L X+0 Y+0 R0 FMAX M91",
    "table_home": "L A+0 C+0 R0 FMAX M91",
    "table": "L A+0 C+0 R0 FMAX", "tool": "TOOL CALL 1 Z S9000", "system": "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+0",
    "length": "", "spindle": "M3",
    "stop": "STOP",
}  # fmt: skip

#: The first moves. The last but one goes to a height of Z along a plane that A and C lie on, the last drills.
MOVES: Final = ("X Y Z", "X Y, Z", "Z, X Y", "X, Y, Z", "X Y Z A C", "A C, X Y, Z", "plane", "drill")


def _place_over_plane() -> tuple[float, float, float]:
    """The place at height Z of the plane whose zero is X Y 0, in coordinates of the part."""
    a, c = math.radians(A), math.radians(C)
    k = (math.sin(a) * math.sin(c), math.sin(a) * math.cos(c), math.cos(a))
    return X + Z * k[0], Y + Z * k[1], Z * k[2]


_ON_PLANE: Final = "G0 X{:.6f} Y{:.6f} Z{:.6f}".format(*_place_over_plane())
_RS274_MOVES: Final = {
    "X Y Z": "G43 H1\nG0 X-30 Y20 Z50",
    "X Y, Z": "G0 X-30 Y20\nG43 H1 Z50",
    "Z, X Y": "G43 H1\nG0 Z50\nX-30 Y20",
    "X, Y, Z": "G43 H1\nG0 X-30\nY20\nZ50",
    "X Y Z A C": "G43.4 H1\nG0 X-30 Y20 Z50 A30 C40",
    "A C, X Y, Z": "G43.4 H1\nG0 A30 C40\nX-30 Y20\nZ50",
    "plane": f"G0 A30 C40\nG43 H1 {_ON_PLANE}",
    "drill": "G43 H1\nG98 G81 X-30 Y20 Z-5 R2 F300\nG80",
}
_FANUC_MOVES: Final = _RS274_MOVES | {"plane": "G68.2 X-30. Y20. Z0 I140. J30. K0\nG53.1\nG43 H1\nG0 X0 Y0\nZ50.\nG69"}
_SIEMENS_MOVES: Final = {
    "X Y Z": "D1\nG0 X-30 Y20 Z50",
    "X Y, Z": "G0 X-30 Y20\nD1 Z50",
    "Z, X Y": "D1\nG0 Z50\nX-30 Y20",
    "X, Y, Z": "D1\nG0 X-30\nY20\nZ50",
    "X Y Z A C": "D1\nTRAORI\nG0 X-30 Y20 Z50 A30 C40",
    "A C, X Y, Z": "D1\nTRAORI\nG0 A30 C40\nX-30 Y20\nZ50",
    "plane": 'D1\nCYCLE800(0,"",0,39,-30,20,0,140,30,0,0,0,0,1)\nG0 X0 Y0\nZ50',
    "drill": "D1\nG0\nF300\nMCALL CYCLE81(2,0,2,-5)\nX-30 Y20\nMCALL",
}
_KLARTEXT_MOVES: Final = {
    "X Y Z": "L X-30 Y+20 Z+50 R0 FMAX",
    "X Y, Z": "L X-30 Y+20 R0 FMAX\nL Z+50 R0 FMAX",
    "Z, X Y": "L Z+50 R0 FMAX\nL X-30 Y+20 R0 FMAX",
    "X, Y, Z": "L X-30 R0 FMAX\nL Y+20 R0 FMAX\nL Z+50 R0 FMAX",
    "X Y Z A C": "M128\nL X-30 Y+20 Z+50 A+30 C+40 R0 FMAX",
    "A C, X Y, Z": "M128\nL A+30 C+40 R0 FMAX\nL X-30 Y+20 R0 FMAX\nL Z+50 R0 FMAX",
    "plane": "CYCL DEF 7.0 DATUM SHIFT\n"
    "CYCL DEF 7.1 X-30\n"
    "CYCL DEF 7.2 Y+20\n"
    "PLANE EULER EULPR+140 EULNU+30 EULROT+0 TURN FMAX SEQ+\n"
    "L X+0 Y+0 R0 FMAX\n"
    "L Z+50 R0 FMAX",
    "drill": "CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=300 Q202=5 Q210=0 Q203=+0 Q204=2 Q211=0\n"
    "CYCL CALL POS X-30 Y+20 Z+0 FMAX",
}


def program(head: str, move: str, dialect: str) -> str:
    """A program with a head and a first move."""
    steps = HEADS[head].split()
    if dialect == "heidenhain":
        lines = [
            "BEGIN PGM T MM",
            *(_KLARTEXT[step] for step in steps),
            _KLARTEXT_MOVES[move],
            "L Z+70 R0 FMAX",
            "M30",
            "END PGM T MM",
        ]
    elif dialect == "siemens":
        lines = ["G71 G90 G17", *(_SIEMENS[step] for step in steps), _SIEMENS_MOVES[move], "G0 Z70", "M30"]
    else:
        moves = _RS274_MOVES if dialect == "rs274" else _FANUC_MOVES
        lines = [
            *(["%", "O1000"] if dialect == "fanuc" else []),
            "G21 G17 G90 G94",
            *(_ISO[step] for step in steps),
            moves[move],
            "G0 Z70",
            "M30",
        ]
    return "\n".join(line for line in lines if line) + "\n"
