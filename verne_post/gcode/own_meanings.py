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
    "G73": "drilling with chip breaking", "G81": "drilling", "G82": "drilling with a dwell at the bottom",
    "G83": "deep-hole drilling, out of the hole after each peck", "G84": "tapping, right-hand thread",
    "G85": "boring, in and out at feed rate", "G86": "boring, out in rapid traverse with the spindle at rest",
    "G89": "boring with a dwell, out at feed rate",
    "G90": "absolute coordinates", "G91": "incremental coordinates",
    "G93": "inverse-time feed", "G94": "feed per minute", "G95": "feed per turn of the spindle",
    "M3": "spindle on, clockwise", "M4": "spindle on, counter-clockwise", "M5": "spindle off",
    "M7": "mist on", "M8": "flood coolant on", "M9": "coolant off",
    "TRAORI": "tool-centre-point control on", "TRAFOOF": "tool-centre-point control off",
    "CYCLE81": "drilling, centring", "CYCLE82": "drilling with a dwell at the bottom",
    "CYCLE83": "deep-hole drilling in steps", "CYCLE84": "rigid tapping",
    "CYCLE840": "tapping with a floating holder", "CYCLE85": "reaming, in and out at feed rate",
    "CYCLE86": "boring, the spindle stops oriented", "CYCLE89": "boring with a dwell, out at feed rate",
    "CYCLE800": "tilts the work plane, and turns the table to it; without values it ends the plane",
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
    "_TOL": "tolerance of the tip", "_TOLM": "kind of machining", "_OTOL": "tolerance of the tool axis",
}  # fmt: skip
