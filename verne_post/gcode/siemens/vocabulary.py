"""Every word of the language that is known here: what it does, that it has no effect, or why it is refused.

The readers look words up here, so a word that is not here cannot be executed. docs/make_words.py makes the tables of
docs/siemens.md of it; a test runs every word.
"""

import re
from collections.abc import Mapping
from typing import Final

from verne_post.gcode.codes import RS274, end_texts

_BY_GROUP: Final = "orientation_by_group of the settings file is true"
_CLEARS_FEED: Final = "a change sets F to 0"
#: G functions that are executed, by group -> what each does; one of each group may stand in a block.
GROUPS: Final[Mapping[str, Mapping[str, str]]] = {
    "motion": {
        "G0": "rapid traverse",
        "G1": "straight move",
        "G2": "arc clockwise: I J K, CR=, AR=, polar; TURN= further turns",
        "G3": "arc counter-clockwise: I J K, CR=, AR=, polar; TURN= further turns",
        "CIP": "arc through the intermediate point I1= J1= K1=, in any plane",
        "CT": "arc in the plane, tangent to the last motion",
        "BSPLINE": "B-spline that starts at the tool, with control points in its blocks",
    },
    "dwell": {"G4": "dwell: F seconds, or S turns of the spindle"},
    "fixed point": {
        "G75": "rapid traverse to [home] of the machine file: FP=1 g28, FP=2 g30 *(unverified for a given machine)*"
    },
    "plane": {"G17": "plane XY", "G18": "plane ZX", "G19": "plane YZ"},
    "frame": {
        "TRANS": "shifts the zero; replaces the frame in force",
        "ROT": "turns coordinates; replaces the frame in force",
        "SCALE": "scales coordinates; replaces the frame in force",
        "MIRROR": "mirrors coordinates; replaces the frame in force",
        "ATRANS": "shifts the zero, from the frame in force on",
        "AROT": "turns coordinates, from the frame in force on",
        "ASCALE": "scales coordinates, from the frame in force on",
        "AMIRROR": "mirrors coordinates, from the frame in force on",
    },
    "compensation": {
        "G40": "cutter compensation off",
        "G41": "the tool goes left of the contour, by the radius of the tool table",
        "G42": "the tool goes right of the contour, by the radius of the tool table",
    },
    "feed on arcs": {
        "CFC": "on arcs under G41 and G42, F is the feed rate at the contour",
        "CFTCP": "on arcs under G41 and G42, F is the feed rate of the tool's centre",
        "CFIN": "on inside arcs under G41 and G42, F is the feed rate at the contour; on others that of the centre",
    },
    "offset": {
        "G500": "the machine's zero",
        **{
            f"G{number}": f"work offset G{number}: coordinates count from its zero (--wcs, [wcs])"
            for number in (54, 55, 56, 57)
        },
        **dict.fromkeys(
            (f"G{number}" for number in range(505, 600)),
            "further work offsets: --wcs G58, G59, G59.1 to G59.3 for 505 to 509, then G54.1P1 and so on",
        ),
    },
    "suppression": dict.fromkeys(
        ("G53", "G153", "SUPA"), "machine coordinates, for the block; the tool length counts until D0"
    ),
    "exact stop": {
        "G60": "a stop at the end of every block",
        **dict.fromkeys(("G64", "G641", "G642", "G643", "G644", "G645"), "corners are blended"),
    },
    "exact stop of the block": {"G9": "a stop at the end of the block"},
    "units": {
        "G70": "lengths are inches",
        "G71": "lengths are millimetres",
        "G700": "lengths and feed rates are inches",
        "G710": "lengths and feed rates are millimetres",
    },
    "distance": {"G90": "absolute coordinates", "G91": "incremental coordinates"},
    "feed mode": {
        "G93": f"inverse-time feed; {_CLEARS_FEED}",
        "G94": f"feed per minute; {_CLEARS_FEED}",
        "G95": f"feed per turn of the spindle; {_CLEARS_FEED}",
    },
    "pole": {
        "G110": "the pole is given from the last position",
        "G111": "the pole is given from the zero",
        "G112": "the pole is given from the last pole",
    },
    "transformation": {"TRAORI": "tool-centre-point control on", "TRAFOOF": "tool-centre-point control off"},
    "orientation reference": {
        "ORIWKS": f"the tool axis goes along a great circle; no effect where {_BY_GROUP}",
        "ORIMKS": f"the rotary axes go linearly; no effect where {_BY_GROUP}",
    },
    "orientation path": {
        "ORIAXES": f"the rotary axes go linearly, where {_BY_GROUP}; else no effect: ORIWKS or ORIMKS decides, so "
        "that ORIWKS ORIAXES is a great circle",
        **dict.fromkeys(
            ("ORIVECT", "ORIPLANE"),
            f"the tool axis goes along a great circle, where {_BY_GROUP}; else no effect: ORIWKS or ORIMKS decides",
        ),
    },
}
#: How a value of an axis is meant, where G90 and G91 do not say.
VALUE_MODES: Final[Mapping[str, str]] = {
    "AC": "this value is absolute: X=AC(5)",
    "IC": "this value is incremental: X=IC(5)",
    "DC": "a rotary axis takes the shortest way: C=DC(0); in machine coordinates too, as in SUPA C=DC(0)",
    "ACP": "a rotary axis turns up to the position",
    "ACN": "a rotary axis turns down to the position",
}
#: Words with a value that are executed.
ADDRESSES: Final[Mapping[str, str]] = {
    **dict.fromkeys(("X", "Y", "Z", "A", "B", "C"), "where the axis goes, in mm or degrees; in G91 by how much"),
    **dict.fromkeys(("U", "V", "W"), "axes of other machines: refused (VP011)"),
    **dict.fromkeys(("I", "J", "K"), "centre of an arc, from its start or with AC()"),
    **dict.fromkeys(("I1", "J1", "K1"), "intermediate point of CIP"),
    "CR": "radius of an arc; a negative one takes the long way, more than half a turn",
    "AR": "angle of an arc, with its centre or its end",
    "TURN": "further turns of an arc",
    "AP": "polar angle, also incremental, kept until the next pole or plane",
    "RP": "polar radius, absolute",
    "RPL": "rotation in the plane, of ROT and AROT",
    "PL": "knot interval of BSPLINE",
    "PW": "weight of BSPLINE",
    "SD": "degree of BSPLINE",
    **dict.fromkeys(("A3", "B3", "C3"), "the tool axis at the end of the block"),
    "F": "feed rate, in mm/min under G94",
    **dict.fromkeys(("S", "S1"), "spindle speed in 1/min"),
    **dict.fromkeys(
        ("T", "T1"),
        'selects the tool by number or name: T5, T="name"; '
        "M6 loads it, with length and radius; an empty "
        "spindle has no length",
    ),
    "D": "cutting edge: D1 puts length and radius of the tool in force, D0 ends them; beside T it waits for M6",
    "CUTMOD": "no effect: 0 is cutting edges as in the tool table; other values are refused",
    "H": "an auxiliary function, which `dump moves` and --events show",
    **dict.fromkeys(("M", "M1"), "an M function; M1= is one of the spindle"),
    "G": "a G function, as G=...",
    "L": "calls a subprogram: L10",
    "P": "how often a subprogram runs",
    "N": "block number",
    "ADIS": "length of the blends of G641, in the unit of the program",
    "CTOL": "tolerance of the tip at corners, in the unit of the program",
    "OTOL": "tolerance of the tool axis at corners, degrees",
    "SPOS": "orients the spindle, also SPOS[1]=DC(90)",
    "FP": "which fixed point G75 goes to",
    **dict.fromkeys(("X1", "Y1", "Z1", "A1", "C1"), "an axis that G75 moves"),
    "RND": "rounding before the next line or arc: its radius",
    "RNDM": "rounding of all corners until RNDM=0: its radius",
    "CHF": "chamfer before the next line or arc: its length",
    "CHR": "chamfer: its length on each line",
    "FRC": "feed rate of the corner",
}
#: M functions that are executed, by group; one of each group may stand in a block, but for coolant.
M_FUNCTIONS: Final[Mapping[str, Mapping[int, str]]] = {
    "stopping": {
        0: "stops until the operator starts again",
        1: "stops as M0, only with --optional-stop",
        **dict.fromkeys((2, 30), "end of the program"),
    },
    "tool change": {6: "loads the tool of T"},
    "spindle": {
        3: "spindle on, clockwise",
        4: "spindle on, counter-clockwise",
        5: "spindle off",
        19: "orients the spindle",
    },
    "coolant": RS274.m_groups["coolant"],
    "gear": {40: "no effect: the control chooses the gear"},
}
#: Control statements that are executed.
STATEMENTS: Final[Mapping[str, str]] = {
    "IF": "executes the lines up to ELSE or ENDIF if the condition is true; with GOTOF, jumps",
    "ELSE": "begins the lines for a false condition of IF",
    "ENDIF": "ends IF",
    "GOTO": "jumps to a label, block or computed text, searched forwards, then from the beginning",
    "GOTOF": "jumps forwards to a label or block",
    "GOTOB": "jumps backwards to a label or block",
    "GOTOC": "jumps as GOTO; if the label is missing, the program continues without an alarm",
    "CASE": "jumps to one of several labels, by a value",
    "FOR": "repeats the lines up to ENDFOR; its variable counts up to the value after TO",
    "ENDFOR": "adds 1 to the variable of FOR, and goes back unless it is beyond the last value",
    "WHILE": "repeats the lines up to ENDWHILE as long as the condition is true",
    "ENDWHILE": "goes back to WHILE",
    "LOOP": "repeats the lines up to ENDLOOP until a jump leaves them",
    "ENDLOOP": "goes back to LOOP",
    "REPEAT": "repeats the lines up to UNTIL; with labels, those lines P times",
    "UNTIL": "goes back to REPEAT until the condition is true",
    "REPEATB": "repeats one line P times",
    "DEF": "declares variables",
    "PROC": "begins a subprogram, with its parameters",
    **dict.fromkeys(("RET", "M17"), "end of a subprogram"),
    **dict.fromkeys(("CALL", "EXTCALL"), "calls a subprogram; of a path only the name counts"),
    "MCALL": "runs a drilling cycle, POCKET3, POCKET4, CYCLE76, CYCLE77, CYCLE79, CYCLE70, CYCLE899 or a subprogram "
    "after every block with axes, until MCALL alone; its values are read once",
    "MSG": "shows a message to the operator",
    "SETAL": "raises an alarm; 60000 to 61999 and 65500 to 67999 stop (VP027)",
}
#: Cycles that are executed.
CYCLES: Final[Mapping[str, str]] = {
    "CYCLE81": "drilling, centring",
    "CYCLE82": "drilling with a dwell at the bottom",
    "CYCLE83": "deep-hole drilling in steps",
    "CYCLE84": "rigid tapping",
    "CYCLE85": "reaming, in and out at feed rate",
    "CYCLE86": "boring, the spindle stops oriented",
    "CYCLE89": "boring with a dwell, out at feed rate",
    "CYCLE840": "tapping with a floating holder",
    "HOLES1": "a row of positions, each with the MCALL cycle",
    "HOLES2": "a circle of positions, each with the MCALL cycle",
    "CYCLE801": "a grid of positions, each with the MCALL cycle",
    "CYCLE800": "tilts the work plane, and turns the table to it; without values it ends the plane",
    "CYCLE832": "sets the tolerances of corners",
    "WORKPIECE": "the stock: drawn by `report`, named by the summary and --meta",
    **end_texts(
        ": see Milling cycles",
        {
            "POCKET1": "mills a rectangular pocket (older form)",
            "POCKET2": "mills a circular pocket (older form)",
            "POCKET3": "mills a rectangular pocket",
            "POCKET4": "mills a circular pocket",
            "SLOT1": "mills slots that lie on a circle",
            "SLOT2": "mills slots along a circle",
            "LONGHOLE": "mills long holes, as wide as the tool, on a circle",
            "CYCLE61": "mills a face",
            "CYCLE71": "mills a face",
            "CYCLE76": "mills a rectangular spigot",
            "CYCLE77": "mills a circular spigot",
            "CYCLE79": "mills a spigot with several equal sides",
        },
    ),
    "CYCLE899": "mills an open slot: see Polygons and open slots",
    **end_texts(": see Milled threads", {"CYCLE70": "mills a thread", "CYCLE90": "mills a thread"}),
    **end_texts(
        ": see Milling along a contour",
        {"CYCLE62": "names the contour of the next cycle", "CYCLE72": "mills along a contour"},
    ),
}
#: Words that change how a control moves or watches, not the path, or that are always so here: see `dump moves`.
NO_EFFECT: Final[Mapping[str, str]] = {
    **dict.fromkeys(("G601", "G602", "G603"),
                    "how exact a stop is: verne-post stops exactly at the corner"),
    **dict.fromkeys(("BRISK", "SOFT", "DRIVE", "BRISKA", "SOFTA", "DRIVEA", "JERKLIM", "JERKLIMA", "ACC", "VELOLIM",
                     "VELOLIMA", "ACCLIMA"),
                    "acceleration and jerk: the machine file gives them"),
    **dict.fromkeys(("FFWON", "FFWOF"), "feedforward of the drives"),
    **dict.fromkeys(("COMPON", "COMPCURV", "COMPCAD", "COMPSURF", "COMPOF"), "compressor: --smoothing does this"),
    **dict.fromkeys(("DYNNORM", "DYNPOS", "DYNROUGH", "DYNSEMIFIN", "DYNFINISH", "DYNPREC"),
                    "dynamics: the machine file gives the limits"),
    **dict.fromkeys(("UPATH", "SPATH", "FGROUP", "FGREF"),
                    "F is always the speed of the tip, or deg/min where only the rotary axes turn. FGROUP with "
                    "rotary and linear axes gives a note (VP039); FGROUP with rotary axes alone is refused"),
    **dict.fromkeys(("FNORM", "RTLION", "RTLIOF", "G62", "G621", "FENDNORM"),
                    "the machine file limits rapid traverse and feed"),
    **dict.fromkeys(("STOPRE", "STARTFIFO", "STOPFIFO", "FIFOCTRL"),
                    "how far a control reads ahead: verne-post plans the whole program at once"),
    **dict.fromkeys(("WALIMON", "WALIMOF"), "working area: the machine file gives the limits"),
    **dict.fromkeys(("CPRECON", "CPRECOF", "STOLF", "ADISPOS"),
                    "G64, ADIS, CTOL and OTOL decide how corners are blended"),
    **dict.fromkeys(("CUT2D", "NORM", "G450", "KONTT", "G460", "SPOF", "NORM0"), "verne-post always works this way"),
    **dict.fromkeys(("ORISON", "ORISOF"), "smoothing of the tool axis: the blends of corners do this"),
    **dict.fromkeys(("TOFRAMEOF", "TOROTOF", "PAROTOF", "TCOABS", "PTPOF", "CP", "G290", "DIAMOF"),
                    "the state at the start of a program"),
    **dict.fromkeys(("DISPLON", "DISPLOF", "SBLON", "SBLOF", "ACTBLOCNO"), "display and single block"),
    **dict.fromkeys(("SPCON", "SPCOF", "GETD", "GET", "RELEASE", "NEWCONF"),
                    "position control of spindles, axes and channels of the control"),
    **dict.fromkeys(("TOWSTD", "TOWMCS", "TOWWCS", "TOWBCS", "TOWTCS", "TOWKCS"),
                    "directions of tool wear: verne-post knows no tool wear"),
    "WRTPR": "a line in a log of the control",
    "SETMS": "the first spindle is the master spindle; SETMS with another number is refused",
    **dict.fromkeys(("EXTERN", "ENDPROC"), "declarations"),
    **dict.fromkeys(("GROUP_BEGIN", "GROUP_END", "GROUP_ADDEND"), "folding in the editor")
}  # fmt: skip
#: Words that are known and not executed.
REFUSED_WORDS: Final[Mapping[str, str]] = {
    **dict.fromkeys(("ASPLINE", "CSPLINE", "BAUTO", "BNAT", "BTAN", "EAUTO", "ENAT", "ETAN"),
                    "splines through points: each control computes them in its own way; BSPLINE is executed"),
    **dict.fromkeys(("POLY", "PO", "POLYPATH", "INVCW", "INVCCW"), "polynomials and involutes"),
    **dict.fromkeys(("DIAMON", "DIAM90", "DIAMCYCOF", "DIAMCHAN", "LIMS", "G96", "G961", "G962", "G97", "G971", "G972",
                     "G973", "SCC"), "lathe words"),
    **dict.fromkeys(("G33", "G34", "G35", "G331", "G332", "G63", "G335", "G336"),
                    "spindle-synchronised motion: setpoints cannot wait for the spindle"),
    **dict.fromkeys(("G25", "G26"), "limits of the working area and of the spindle; the machine file gives them"),
    **dict.fromkeys(("G58", "G59"), "programmable offsets of single axes; write TRANS or ATRANS"),
    **dict.fromkeys(("G74", "G751", "G28", "G30"), "reference points; retract with G75, or SUPA G0 Z and D0"),
    **dict.fromkeys(("G43", "G44", "G49"), "tool lengths of Fanuc; write D1 for the length of the tool, D0 for none"),
    **dict.fromkeys(("G43.4", "G43.5"), "tool-centre-point control of Fanuc; write TRAORI, and D1 for the tool length"),
    **dict.fromkeys(("G68.2", "G68.3", "G68.4"), "tilted planes of Fanuc; write CYCLE800"),
    **dict.fromkeys(("G73", "G76", "G80", "G81", "G82", "G83", "G84", "G85", "G86", "G87", "G88", "G89", "G98", "G99"),
                    "cycles of Fanuc; write CYCLE81 to CYCLE86, which MCALL before them repeats, and MCALL alone ends"),
    **dict.fromkeys(("G20", "G21"), "units of Fanuc; write G700 for inches, G710 for mm"),
    **dict.fromkeys(("G51", "G52", "G68", "G69", "G92"),
                    "shifts, turns and scales of Fanuc; write TRANS, ROT, SCALE or CYCLE800"),
    **dict.fromkeys(("G140", "G141", "G142", "G143", "G147", "G148", "G247", "G248", "G340", "G341", "G347", "G348",
                     "DISR", "DISCL", "DISRP", "FAD"),
                    "soft approach and retraction; write the moves"),
    **dict.fromkeys(("G451", "G461", "G462", "DISC", "KONT", "KONTC", "OFFN", "CUT2DF", "CUT2DD", "CUT3DC", "CUT3DF",
                     "CUT3DFS", "CUT3DFF", "CUT3DCC", "CUT3DCCD", "CUTCONON", "CUTCONOF"),
                    "this kind of cutter compensation; executed are G41 and G42 in a plane, with an arc at outside "
                    "corners"),
    **dict.fromkeys(("FRCM", "ANG"),
                    "modal feed rates of corners, and angles of contour programming; write FRC=, and the end point"),
    **dict.fromkeys(("POS", "POSA", "POSP", "FA", "OVRA", "MOV", "WAITP", "FOCON", "FOC", "FXS", "FXST", "FXSW", "PTP",
                     "PTPG0", "PTPWOC", "STAT", "TU"), "positioning axes and point-to-point motion"),
    **dict.fromkeys(("TOROT", "TOROTX", "TOROTY", "TOROTZ", "TOFRAME", "TOFRAMEX", "TOFRAMEY", "TOFRAMEZ"),
                    "a frame along the tool, whose X and Y SD42980 of the control chooses; write TRANS and AROT, or "
                    "CYCLE800"),
    **dict.fromkeys(("PAROT", "TCARR", "TCOFR", "TCOFRX", "TCOFRY", "TCOFRZ"),
                    "frames of tool carriers; write CYCLE800 or ROT"),
    **dict.fromkeys(("ROTS", "AROTS", "CROTS", "CFINE", "MEAFRAME", "SETPA", "RPLA"),
                    "a frame in this form; write TRANS, ROT or CYCLE800"),
    **dict.fromkeys(("A2", "B2", "C2", "ORIEULER", "ORIRPY", "ORIRPY2", "ORIVIRT1", "ORIVIRT2"),
                    "the tool axis as angles: their order differs from machine to machine; write A3= B3= C3=, or "
                    "the angles of the rotary axes"),
    **dict.fromkeys(("A4", "B4", "C4", "A5", "B5", "C5", "LEAD", "TILT"),
                    "the tool axis relative to a surface; write A3= B3= C3="),
    **dict.fromkeys(("A6", "B6", "C6", "A7", "B7", "C7", "THETA", "NUT", "PSI", "XH", "YH", "ZH", "ORICONCW",
                     "ORICONCCW", "ORICONIO", "ORICONTO", "ORICURVE", "ORIPATH", "ORIPATHS", "ORIROTA", "ORIROTR",
                     "ORIROTT", "ORIROTC", "OSC", "OSS", "OSSE", "OSD", "OST", "OSOF"),
                    "this interpolation of the tool axis; ORIVECT and ORIAXES are executed"),
    **dict.fromkeys(("TRANSMIT", "TRACYL", "TRAANG", "TRACON", "TRACOOF", "TRAFOSTAT", "TRAINT", "NORMAL"),
                    "transformations of other machines"),
    **dict.fromkeys(("LIFTFAST", "LFON", "LFOF", "LFTXT", "LFWP", "LFPOS", "POLF", "POLFMASK", "POLFMLIN", "SETINT",
                     "ASUP", "PRIO", "ENABLE", "DISABLE", "CLRINT", "BLSYNC"), "interrupts"),
    **dict.fromkeys(("WAITM", "WAITMC", "WAITE", "SETM", "CLEARM", "INIT", "START"),
                    "programs of several channels: there is one channel"),
    **dict.fromkeys(("ATOL", "ORIRESET"),
                    "tolerances of single axes (write CTOL, OTOL), or a turn to a position that the control knows "
                    "(write the angles of the rotary axes)"),
    **dict.fromkeys(("MEAS", "MEAW", "MEASA", "MEAWA", "MEAC", "MEASURE", "TOOLMEA"),
                    "probing: where the tool touches is only known at the machine"),
    **dict.fromkeys(("ID", "IDS", "DO", "EVERY", "WHEN", "WHENEVER", "FROM", "CANCEL", "RESET", "SYNFCT", "FCTDEF",
                     "POLYF", "PUTFTOC", "PUTFTOCF", "FTOCON", "FTOCOF"),
                     "synchronised actions: they depend on what the machine does"),
    **dict.fromkeys(("TRAILON", "TRAILOF", "LEADON", "LEADOF", "EGON", "EGDEF", "EGONSYN", "EGONSYNE", "EGOFS", "EGOFC",
                     "COUPON", "COUPOF", "COUPDEF", "COUPDEL", "COUPRES", "COUPONC", "MASLON", "MASLOF", "CPON", "CPOF",
                     "TANG", "TANGON", "TANGOF", "TANGDEL", "TLIFT", "CTABDEF", "CTABEND", "PUNCHACC", "PON", "PONS",
                     "SON", "SONS", "SPN", "SPP", "PDELAYON", "PDELAYOF", "G5", "G7"),
                    "axes that follow others, punching, grinding"),
    **dict.fromkeys(("FZ", "FB", "FD", "FL", "FCUB", "FLIN", "FPO", "FPRAON", "FPRAOF", "FPR", "ST", "SR", "G931",
                     "G942", "G952", "OVR", "OVRRAP"), "a feed rate in this form; write F with G93, G94 or G95"),
    **dict.fromkeys(("SPOSA", "SVC", "GWPSON", "GWPSOF", "M70", "M41", "M42", "M43", "M44", "M45"),
                    "gears and further spindles: there is one spindle"),
    **dict.fromkeys(("DEFINE", "REDEF", "MODAXVAL", "GOTOS", "CALLPATH", "PCALL", "EXECTAB", "EXECSTRING", "INDICATE",
                     "READ", "WRITE", "DELETE", "ISFILE", "FILEDATE", "ICYCON", "ICYCOF", "REPOSA", "REPOSL", "REPOSQ",
                     "REPOSH", "REPOSHA", "ASPL", "ISOCALL", "SETDNO", "GETT", "GETSELT", "NEWT", "DELT", "SETPIECE",
                     "DELDL", "TOOLENV", "SAVE_TOOLENV", "CONTPRON", "CONTDCON", "EXECUTE", "INTERSEC", "G291",
                     "PROTA", "PROTS", "NPROT", "NPROTDEF", "COLLPAIR"),
                    "changes the program while it runs, or needs files of the control"),
    **dict.fromkeys(("CYCLE63", "CYCLE64", "CYCLE73", "CYCLE74", "CYCLE75"),
                    "pockets inside a contour; write a POCKET cycle, CYCLE72 for the edge alone, or let the CAM "
                    "system write the moves"),
    "CYCLE60": "engraving; let the CAM system write the lines of the letters",
    "CYCLE78": "drilling and thread milling in one; write CYCLE82 and CYCLE70, each with its tool",
    **dict.fromkeys(("CYCLE95", "CYCLE951", "CYCLE952", "CYCLE99"), "turning"),
    **dict.fromkeys(("CYCLE971", "CYCLE976", "CYCLE977", "CYCLE978", "CYCLE979", "CYCLE982", "CYCLE994", "CYCLE996",
                     "CYCLE998"), "probing: where the tool touches is only known at the machine"),
    "CONTOUR": "milling of contours by cycles; let the CAM system write the moves",
    **dict.fromkeys(("CYCLE87", "CYCLE88"),
                    "cycles that stop for the operator in the hole; write the moves with M5 and M0")
}  # fmt: skip
#: Types of DEF and PROC. AXIS, FRAME are refused.
TYPES: Final = ("REAL", "INT", "BOOL", "CHAR", "STRING")
#: Functions whose value is a frame.
FRAME_FUNCTIONS: Final = ("CTRANS", "CROT", "CSCALE", "CMIRROR")
#: Names that stand for numbers of CYCLE832.
CONSTANTS: Final[Mapping[str, float]] = {
    "_OFF": 0.0, "_FINISH": 1.0, "_SEMIFIN": 2.0, "_ROUGH": 3.0, "_PRECISION": 4.0, "_ORI_FINISH": 11.0,
    "_ORI_SEMIFIN": 12.0, "_ORI_ROUGH": 13.0, "_ORI_PRECISION": 14.0,
    "_TOP_SURFACE_SMOOTH_OFF": 0.0, "_TOP_SURFACE_SMOOTH_ON": 100.0
}  # fmt: skip
_MANY_CYCLES: Final = re.compile(r"CYCLE[0-9]+$|E_[A-Z_]+$|F_[A-Z_]+$")

GROUP_OF: Final[Mapping[str, str]] = {word: group for group, words in GROUPS.items() for word in words}
#: Values of cycles -> what each says. Others are only named.
CYCLE_VALUES: Final[Mapping[str, str]] = {
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
    "FALD": "allowance at the bottom", "VARI": "kind of machining: roughing or finishing, and how the tool goes in",
    "MIDA": "largest width of a cut", "AP1": "blank: first size (length or diameter)", "AP2": "blank: width",
    "AD": "blank: depth", "RAD1": "plunging: radius of the helix, or largest angle of the ramp",
    "DP1": "plunging: depth of one turn of the helix", "FS": "chamfer: width", "ZFS": "chamfer: depth of the tip",
    "_GMODE": "which point the position names, and what is machined", "_UMODE": "reserved, has no effect",
    "NUM": "how many", "RAD": "radius of the circle of positions", "STA1": "angle of the first position, or of the row",
    "INDA": "angle from one position to the next; 0 spreads them evenly", "STA2": "largest plunging angle of a ramp",
    "AFSL": "angle that a slot extends over", "FFCP": "feed rate between slots, on the circle",
    "MIDF": "largest depth of a pass, finishing", "FFP2": "feed rate, finishing", "SSF": "spindle speed, finishing",
    "DIATH": "nominal diameter of the thread", "KDIAM": "core diameter of the thread",
    "TYPTH": "inside or outside thread", "H1": "depth of the thread profile",
    "NT": "teeth of the tool, one above another",
    "NSP": "angle at which the thread begins", "SWL": "width across flats, or length of a side",
    "RC": "radius or chamfer of the corners", "LIM": "edges that limit the strokes",
    "FDP": "how far a stroke goes beyond the edge, along", "FDP1": "how far strokes go beyond the edge, across",
    "SPCA": "reference point of the row, first axis", "SPCO": "reference point of the row, second axis",
    "FDIS": "distance of the first hole from the reference point", "DBH": "distance between holes",
    "CPA": "centre of the circle, first axis", "CPO": "centre of the circle, second axis",
    "_SPCA": "reference point of the grid, first axis", "_SPCO": "reference point of the grid, second axis",
    "_STA": "angle of the grid", "_DIS1": "CYCLE83: distance before the last depth where the feed rate begins again; "
    "CYCLE801: distance of columns", "_DIS2": "distance of rows", "_NUM1": "number of columns",
    "_NUM2": "number of rows",
    "_ANG1": "shear angle of the rows", "_ANG2": "shear angle of the columns", "_HIDE": "positions that are left out",
    "_NSP": "position to begin with", "KNAME": "name of the contour: a subprogram, or labels",
    "TYPE": "how the contour is named", "LAB1": "label where the contour begins",
    "LAB2": "label where the contour ends",
    "RL": "side of the contour: 40 on it, 41 left, 42 right", "AS1": "way of the approach",
    "LP1": "length of the approach",
    "AS2": "way of the departure", "LP2": "length of the departure", "FF3": "feed rate between passes",
    "SDAC": "spindle after the cycle: 3, 4 or 5", "POSS": "angle at which the spindle stops, degrees",
    "SST": "spindle speed in", "SST1": "spindle speed out", "SDIR": "direction of the spindle",
    "SDR": "direction of the spindle out",
    "ENC": "tapping with or without encoder", "RPA": "retract from the wall, first axis",
    "RPO": "retract from the wall, second axis", "RPAP": "retract from the wall, along the tool",
    "_AXN": "tool axis", "_PITA": "unit of the pitch", "_PITM": "pitch, as the text of a standard",
    "_PTAB": "table of the thread", "_PTABA": "choice in the table of the thread", "_TECHNO": "settings of tapping",
    "_VARI": "kind of machining", "_DAM": "how much less each step is", "_MDEP": "smallest step",
    "_VRT": "retract after each step", "_DTD": "dwell at the last depth",
    "_ZA": "depth of the pilot hole", "_FA": "feed rate into the pilot hole",
    "_ZD": "depth where drilling through begins",
    "_FD": "feed rate of drilling through",
    "_TOL": "tolerance of the tip", "_TOLM": "kind of machining", "_OTOL": "tolerance of the tool axis"
}  # fmt: skip


def has_meaning(name: str) -> bool:
    """Whether a word is of the language: executed, without effect, or refused."""
    tables = (ADDRESSES, GROUP_OF, NO_EFFECT, STATEMENTS, CYCLES, VALUE_MODES, FRAME_FUNCTIONS, CONSTANTS)
    return any(name in table for table in tables) or explain_refusal(name) is not None


def explain_refusal(name: str) -> str | None:
    """Why a word is not executed; None where it is, or is not known."""
    if name in REFUSED_WORDS:
        return REFUSED_WORDS[name]
    if _MANY_CYCLES.match(name) and name not in CYCLES:
        return "this cycle; let the CAM system write the moves"
    return None
