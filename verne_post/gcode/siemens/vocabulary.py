"""Every word of the language that is known here: what is executed, what has no effect here, what is refused and why.

docs/siemens.md shows the same tables; a test compares them, and runs every word.
"""

import re
from collections.abc import Mapping
from typing import Final

#: G functions that are executed, by group: one of each group may stand in a block.
GROUPS: Final[Mapping[str, tuple[str, ...]]] = {
    "motion": ("G0", "G1", "G2", "G3", "CIP", "CT", "BSPLINE"),
    "dwell": ("G4",),
    "fixed point": ("G75",),
    "plane": ("G17", "G18", "G19"),
    "frame": ("TRANS", "ATRANS", "ROT", "AROT", "SCALE", "ASCALE", "MIRROR", "AMIRROR"),
    "compensation": ("G40", "G41", "G42"),
    "feed on arcs": ("CFC", "CFTCP", "CFIN"),
    "offset": ("G500", "G54", "G55", "G56", "G57", *(f"G{number}" for number in range(505, 600))),
    "suppression": ("G53", "G153", "SUPA"),
    "exact stop": ("G60", "G64", "G641", "G642", "G643", "G644", "G645"),
    "exact stop of the block": ("G9",),
    "units": ("G70", "G71", "G700", "G710"),
    "distance": ("G90", "G91"),
    "feed mode": ("G93", "G94", "G95"),
    "pole": ("G110", "G111", "G112"),
    "transformation": ("TRAORI", "TRAFOOF"),
    "orientation reference": ("ORIWKS", "ORIMKS"),
    "orientation path": ("ORIAXES", "ORIVECT", "ORIPLANE"),
}
#: Words that change how a control moves or watches, not where the tool goes, or that are so here: shown by `dump moves`.
NO_EFFECT: Final[Mapping[str, str]] = {
    **dict.fromkeys(("G601", "G602", "G603"), "when an exact stop is reached: the tool stands still at every exact stop"),
    **dict.fromkeys(("BRISK", "SOFT", "DRIVE", "BRISKA", "SOFTA", "DRIVEA", "JERKLIM", "JERKLIMA", "ACC", "VELOLIM", "VELOLIMA", "ACCLIMA"),
                    "acceleration and jerk: the machine file gives them"),
    **dict.fromkeys(("FFWON", "FFWOF"), "feedforward of the drives"),
    **dict.fromkeys(("COMPON", "COMPCURV", "COMPCAD", "COMPSURF", "COMPOF"), "compressor: --smoothing takes its place"),
    **dict.fromkeys(("DYNNORM", "DYNPOS", "DYNROUGH", "DYNSEMIFIN", "DYNFINISH", "DYNPREC"), "dynamics: the machine file gives the limits"),
    **dict.fromkeys(("UPATH", "SPATH", "FGROUP", "FGREF"), "F is always the speed of the tip, or deg/min where only A and C turn; a note (VP039) names an FGROUP with rotary axes, and one of these alone is refused"),
    **dict.fromkeys(("FNORM", "RTLION", "RTLIOF", "G62", "G621", "FENDNORM"), "the machine file limits rapid traverse and feed"),
    **dict.fromkeys(("STOPRE", "STARTFIFO", "STOPFIFO", "FIFOCTRL"), "nothing is read ahead"),
    **dict.fromkeys(("WALIMON", "WALIMOF"), "working area: the machine file gives the limits"),
    **dict.fromkeys(("CPRECON", "CPRECOF", "STOLF", "ADISPOS"), "G64, ADIS, CTOL and OTOL decide how corners are blended"),
    **dict.fromkeys(("CUT2D", "NORM", "G450", "KONTT", "G460", "SPOF", "NORM0"), "this is always so here"),
    **dict.fromkeys(("ORISON", "ORISOF"), "smoothing of the tool axis: the blends of corners take its place"),
    **dict.fromkeys(("TOFRAMEOF", "TOROTOF", "PAROTOF", "TCOABS", "PTPOF", "CP", "G290", "DIAMOF"), "this is the state at the start"),
    **dict.fromkeys(("DISPLON", "DISPLOF", "SBLON", "SBLOF", "ACTBLOCNO"), "display and single block"),
    **dict.fromkeys(("SPCON", "SPCOF", "GETD", "GET", "RELEASE", "NEWCONF"),
                    "position control of spindles, axes and channels of the control"),
    **dict.fromkeys(("TOWSTD", "TOWMCS", "TOWWCS", "TOWBCS", "TOWTCS", "TOWKCS"), "directions of tool wear: there is no tool wear here"),
    "WRTPR": "a line in a log of the control",
    "SETMS": "the first spindle is the master spindle; SETMS with another number is refused",
    **dict.fromkeys(("EXTERN", "ENDPROC"), "declarations"),
    **dict.fromkeys(("GROUP_BEGIN", "GROUP_END", "GROUP_ADDEND"), "marks of the editor"),
}  # fmt: skip
#: Words that are known and not executed.
REFUSED: Final[Mapping[str, str]] = {
    **dict.fromkeys(("ASPLINE", "CSPLINE", "BAUTO", "BNAT", "BTAN", "EAUTO", "ENAT", "ETAN"), "splines through points: each control computes them in its own way; BSPLINE is executed"),
    **dict.fromkeys(("POLY", "PO", "POLYPATH", "INVCW", "INVCCW"), "polynomials and involutes"),
    **dict.fromkeys(("DIAMON", "DIAM90", "DIAMCYCOF", "DIAMCHAN", "LIMS", "G96", "G961", "G962", "G97", "G971", "G972", "G973", "SCC"), "lathe words"),
    **dict.fromkeys(("G33", "G34", "G35", "G331", "G332", "G63", "G335", "G336"), "spindle-synchronised motion: setpoints cannot wait for the spindle"),
    **dict.fromkeys(("G25", "G26"), "limits of the working area and of the spindle; the machine file gives them"),
    **dict.fromkeys(("G58", "G59"), "programmable offsets of single axes; write TRANS or ATRANS"),
    **dict.fromkeys(("G74", "G751"), "reference points; retract with G75, or SUPA G0 Z and D0"),
    **dict.fromkeys(("G140", "G141", "G142", "G143", "G147", "G148", "G247", "G248", "G340", "G341", "G347", "G348", "DISR", "DISCL", "DISRP", "FAD"),
                    "soft approach and retraction; write the moves"),
    **dict.fromkeys(("G451", "G461", "G462", "DISC", "KONT", "KONTC", "OFFN", "CUT2DF", "CUT2DD", "CUT3DC", "CUT3DF", "CUT3DFS", "CUT3DFF", "CUT3DCC", "CUT3DCCD", "CUTCONON", "CUTCONOF"),
                    "this kind of cutter compensation; executed are G41 and G42 in a plane, with an arc at outside corners"),
    **dict.fromkeys(("FRCM", "ANG"), "modal feed rates of corners, and angles of contour programming; write FRC=, and the end point"),
    **dict.fromkeys(("POS", "POSA", "POSP", "FA", "OVRA", "MOV", "WAITP", "FOCON", "FOC", "FXS", "FXST", "FXSW", "PTP", "PTPG0", "PTPWOC", "STAT", "TU"), "positioning axes and point-to-point motion"),
    **dict.fromkeys(("TOROT", "TOROTX", "TOROTY", "TOROTZ", "TOFRAME", "TOFRAMEX", "TOFRAMEY", "TOFRAMEZ", "PAROT", "TCARR", "TCOFRX", "TCOFRY", "TCOFRZ"),
                    "frames of tool carriers; write CYCLE800 or ROT"),
    **dict.fromkeys(("ROTS", "AROTS", "CROTS", "CFINE", "MEAFRAME", "SETPA", "RPLA"), "a frame in this form; write TRANS, ROT or CYCLE800"),
    **dict.fromkeys(("A2", "B2", "C2", "ORIEULER", "ORIRPY", "ORIRPY2", "ORIVIRT1", "ORIVIRT2"), "the tool axis as angles: their order differs from machine to machine; write A3= B3= C3=, or A and C"),
    **dict.fromkeys(("A4", "B4", "C4", "A5", "B5", "C5", "LEAD", "TILT"), "the tool axis relative to a surface; write A3= B3= C3="),
    **dict.fromkeys(("A6", "B6", "C6", "A7", "B7", "C7", "THETA", "NUT", "PSI", "XH", "YH", "ZH", "ORICONCW", "ORICONCCW", "ORICONIO", "ORICONTO", "ORICURVE", "ORIPATH", "ORIPATHS", "ORIROTA", "ORIROTR", "ORIROTT", "ORIROTC", "OSC", "OSS", "OSSE", "OSD", "OST", "OSOF"),
                    "this interpolation of the tool axis; ORIVECT and ORIAXES are executed"),
    **dict.fromkeys(("TRANSMIT", "TRACYL", "TRAANG", "TRACON", "TRACOOF", "TRAFOSTAT", "TRAINT", "NORMAL"), "transformations of other machines"),
    **dict.fromkeys(("LIFTFAST", "LFON", "LFOF", "LFTXT", "LFWP", "LFPOS", "POLF", "POLFMASK", "POLFMLIN", "SETINT", "ASUP", "PRIO", "ENABLE", "DISABLE", "CLRINT", "BLSYNC"), "interrupts"),
    **dict.fromkeys(("WAITM", "WAITMC", "WAITE", "SETM", "CLEARM", "INIT", "START"), "programs of several channels: there is one channel"),
    **dict.fromkeys(("ATOL", "ORIRESET"), "tolerances of single axes (write CTOL, OTOL), or a turn to a position that the control knows (write A and C)"),
    **dict.fromkeys(("MEAS", "MEAW", "MEASA", "MEAWA", "MEAC", "MEASURE", "TOOLMEA"), "probing: where the tool touches is only known at the machine"),
    **dict.fromkeys(("ID", "IDS", "DO", "EVERY", "WHEN", "WHENEVER", "FROM", "CANCEL", "RESET", "SYNFCT", "FCTDEF", "POLYF", "PUTFTOC", "PUTFTOCF", "FTOCON", "FTOCOF"), "synchronised actions: they depend on what the machine does"),
    **dict.fromkeys(("TRAILON", "TRAILOF", "LEADON", "LEADOF", "EGON", "EGDEF", "EGONSYN", "EGONSYNE", "EGOFS", "EGOFC", "COUPON", "COUPOF", "COUPDEF", "COUPDEL", "COUPRES", "COUPONC", "MASLON", "MASLOF", "CPON", "CPOF", "TANG", "TANGON", "TANGOF", "TANGDEL", "TLIFT", "CTABDEF", "CTABEND", "PUNCHACC", "PON", "PONS", "SON", "SONS", "SPN", "SPP", "PDELAYON", "PDELAYOF", "G5", "G7"),
                    "axes that follow others, punching, grinding"),
    **dict.fromkeys(("FZ", "FB", "FD", "FL", "FCUB", "FLIN", "FPO", "FPRAON", "FPRAOF", "FPR", "ST", "SR", "G931", "G942", "G952", "OVR", "OVRRAP"), "a feed rate in this form; write F with G93, G94 or G95"),
    **dict.fromkeys(("SPOSA", "SVC", "GWPSON", "GWPSOF", "M70", "M41", "M42", "M43", "M44", "M45"), "gears and further spindles: there is one spindle"),
    **dict.fromkeys(("DEFINE", "REDEF", "MODAXVAL", "GOTOS", "CALLPATH", "PCALL", "EXECTAB", "EXECSTRING", "INDICATE", "READ", "WRITE", "DELETE", "ISFILE", "FILEDATE", "ICYCON", "ICYCOF", "REPOSA", "REPOSL", "REPOSQ", "REPOSH", "REPOSHA", "ASPL", "ISOCALL", "SETDNO", "GETT", "GETSELT", "NEWT", "DELT", "SETPIECE", "DELDL", "TOOLENV", "SAVE_TOOLENV", "CONTPRON", "CONTDCON", "EXECUTE", "INTERSEC", "G291", "CALL", "PROTA", "PROTS", "NPROT", "NPROTDEF", "COLLPAIR"),
                    "changes the program while it runs, or needs files of the control"),
    **dict.fromkeys(("CYCLE63", "CYCLE64", "CYCLE73", "CYCLE74", "CYCLE75"), "pockets inside a contour; write a POCKET cycle, CYCLE72 for the edge alone, or let the CAM system write the moves"),
    "CYCLE60": "engraving; let the CAM system write the lines of the letters",
    **dict.fromkeys(("CYCLE70", "CYCLE78", "CYCLE90"), "thread milling; let the CAM system write the helix, or write G2 or G3 with TURN="),
    "CYCLE79": "polygons; write the sides with G41 or G42",
    **dict.fromkeys(("CYCLE95", "CYCLE951", "CYCLE952", "CYCLE99"), "turning"),
    **dict.fromkeys(("CYCLE971", "CYCLE976", "CYCLE977", "CYCLE978", "CYCLE979", "CYCLE982", "CYCLE994", "CYCLE996", "CYCLE998"), "probing: where the tool touches is only known at the machine"),
    "CONTOUR": "milling of contours by cycles; let the CAM system write the moves",
    **dict.fromkeys(("CYCLE87", "CYCLE88"), "cycles that stop for a person in the hole; write the moves with M5 and M0"),
}  # fmt: skip
#: Cycles that are executed.
CYCLES: Final = (
    "CYCLE81", "CYCLE82", "CYCLE83", "CYCLE84", "CYCLE85", "CYCLE86", "CYCLE89", "CYCLE840", "HOLES1", "HOLES2", "CYCLE801", "CYCLE800", "CYCLE832", "WORKPIECE",
    "POCKET1", "POCKET2", "POCKET3", "POCKET4", "SLOT1", "SLOT2", "LONGHOLE", "CYCLE61", "CYCLE71", "CYCLE76", "CYCLE77", "CYCLE62", "CYCLE72",
)  # fmt: skip
#: Functions whose value is a frame.
FRAME_FUNCTIONS: Final = ("CTRANS", "CROT", "CSCALE", "CMIRROR")
#: Control statements that are executed.
STATEMENTS: Final = (
    "IF", "ELSE", "ENDIF", "FOR", "ENDFOR", "WHILE", "ENDWHILE", "LOOP", "ENDLOOP", "REPEAT", "REPEATB", "UNTIL", "GOTO", "GOTOF", "GOTOB", "GOTOC", "CASE",
    "DEF", "PROC", "RET", "M17", "MCALL", "EXTCALL", "MSG", "SETAL",
)  # fmt: skip
#: Words with a value that are executed.
ADDRESSES: Final = (
    "X", "Y", "Z", "A", "B", "C", "U", "V", "W", "I", "J", "K", "I1", "J1", "K1", "CR", "AR", "AP", "RP", "TURN", "RPL", "PL", "PW", "SD", "A3", "B3", "C3", "F", "S", "T", "D",
    "CUTMOD", "H", "M", "G", "L", "P", "N", "ADIS", "CTOL", "OTOL", "SPOS", "S1", "M1", "T1", "FP", "X1", "Y1", "Z1", "A1", "C1",
    "RND", "RNDM", "CHF", "CHR", "FRC",
)  # fmt: skip
#: Names that stand for numbers of CYCLE832.
CONSTANTS: Final[Mapping[str, float]] = {
    "_OFF": 0.0, "_FINISH": 1.0, "_SEMIFIN": 2.0, "_ROUGH": 3.0, "_PRECISION": 4.0, "_ORI_FINISH": 11.0, "_ORI_SEMIFIN": 12.0, "_ORI_ROUGH": 13.0, "_ORI_PRECISION": 14.0,
    "_TOP_SURFACE_SMOOTH_OFF": 0.0, "_TOP_SURFACE_SMOOTH_ON": 100.0,
}  # fmt: skip
_MANY_CYCLES: Final = re.compile(r"CYCLE[0-9]+$|E_[A-Z_]+$|F_[A-Z_]+$")

GROUP_OF: Final[Mapping[str, str]] = {word: group for group, words in GROUPS.items() for word in words}


def explain_refusal(name: str) -> str | None:
    """Why a word is not executed; None where it is, or is not known."""
    if name in REFUSED:
        return REFUSED[name]
    if _MANY_CYCLES.match(name) and name not in CYCLES:
        return "this cycle; let the CAM system write the moves"
    return None
