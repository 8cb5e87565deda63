"""Modal groups of G and M codes, what each code does, and the words that it uses. G numbers are times ten.

A code that is in no group cannot be executed. docs/make_words.py makes the tables of docs/gcode.md from this. Another
dialect has another table, derived from this one (:mod:`verne_post.gcode.dialects`).
"""

from collections.abc import Mapping
from functools import cached_property
from typing import Final

from msgspec import Struct

from verne_post.base.tolerances import WHOLE_NUMBER
from verne_post.gcode.program_error import ProgramError

#: Canned cycles.
CYCLES: Final = (730, 740, 760, 810, 820, 830, 840, 850, 860, 870, 880, 890)
#: M codes with which LinuxCNC's examples of switchable kinematics select one, and what it is there.
_KINEMATICS: Final = {428: "tcp on", 429: "tcp off", 430: "tcp off"}
#: Non-modal codes that take the axis words of the block away from the motion; those of Haas too, which one dialect has.
TAKES_AXES: Final = (100, 280, 300, 520, 920, 120, 130, 700, 710, 720)


class CodeTable(Struct, frozen=True, dict=True):
    """The codes of a dialect."""

    #: g_groups, m_groups: Modal group -> its codes -> what each does.
    g_groups: Mapping[str, Mapping[int, str]]
    m_groups: Mapping[str, Mapping[int, str]]
    #: refused_g, refused_m: Codes that are known and not executed -> what they are.
    refused_g: Mapping[int, str]
    refused_m: Mapping[int, str]
    #: words_of_g, words_of_m: Letters beside axes, F, S, T that a code uses.
    words_of_g: Mapping[int, str]
    words_of_m: Mapping[int, str]

    #: What is to be written in place of a code that is not executed.
    instead_of_g: Mapping[int, str] = {}

    @cached_property
    def group_of_g(self) -> dict[int, str]:
        """Code -> its group."""
        return {code: group for group, codes in self.g_groups.items() for code in codes}

    @cached_property
    def group_of_m(self) -> dict[int, str]:
        """Code -> its group."""
        return {code: group for group, codes in self.m_groups.items() for code in codes}

    def is_executed(self, code: str) -> bool:
        """Whether a code such as G68.3 or M428 has a meaning of its own here."""
        number = float(code[1:])
        return round(number * 10) in self.group_of_g if code[0] == "G" else number in self.group_of_m


#: Why [remap] cannot give a code a meaning.
HAS_MEANING: Final = ": it already has a meaning; only what is not executed can be given one"

#: What gives a code or a name of the builder a meaning.
REMAP_GIVES: Final = '[remap] of the set-up, or of verne-post.toml, can give one: "ignore" or "event"'


def describe_remap(code: str) -> str:
    """What a user may write where no language has a meaning for a code: a line of [remap]."""
    key = f'"{code}"' if "." in code else code
    return f'[remap] of the set-up, or of verne-post.toml, can give it a meaning: {key} = "ignore", or "event"'


def make_unknown_function(code: int, column: int | None) -> ProgramError:
    """Refuse (VP002) an M code without a meaning; all of a program are one finding, which one set-up settles."""
    name = f"M{code}"
    text = f"{name}: no meaning in this language; {REMAP_GIVES}"
    return ProgramError("VP002", text, column, about=name, settled_by=("remap", name))


def read_m_code(table: CodeTable, number: float, column: int) -> int:
    """The M code of a number.

    Raises
    ------
    ProgramError
        VP007, VP002: it is none, or none that is executed.
    """
    code = round(number)
    if abs(number - code) > WHOLE_NUMBER or number < 0:
        raise ProgramError("VP007", f"M{number:g}: an M code is a whole number", column)
    settles = describe_remap(f"M{code}")
    if code in _KINEMATICS:
        settles = (
            "LinuxCNC switches kinematics with it, and [remap] of the set-up, or of verne-post.toml, says "
            f"to which: M{code} = "
            f'"tcp on" or "tcp off" (in its examples "{_KINEMATICS[code]}")'
        )
    if code in table.refused_m:
        text = f"M{code} is not executed ({table.refused_m[code]}); {settles}"
        raise ProgramError("VP002", text, column, settled_by=("remap", f"M{code}"))
    if code not in table.group_of_m and code not in _KINEMATICS:
        raise make_unknown_function(code, column)
    if code not in table.group_of_m:
        text = f"M{code} is not a code of this language; {settles}"
        raise ProgramError("VP002", text, column, settled_by=("remap", f"M{code}"))
    return code


#: G codes of RS274/NGC: group (named as in LinuxCNC's documentation) -> code -> what it does.
_G: Final[Mapping[str, Mapping[int, str]]] = {
    "motion": {
        0: "rapid traverse",
        10: "straight move at the feed rate",
        **dict.fromkeys((20, 30), "arcs, clockwise and counter-clockwise: see Arcs"),
        **dict.fromkeys((50, 51, 52, 53), "cubic and quadratic spline, NURBS begin and end: see Splines"),
        **dict.fromkeys((code for code in CYCLES if code != 760), "holes: see Canned cycles"),
    },
    "cancel": {800: "ends the motion code; takes no axis words"},
    "plane": dict.fromkeys((170, 180, 190), "plane of arcs: XY, ZX, YZ"),
    "distance": dict.fromkeys(
        (900, 910),
        "absolute, incremental; from its own block on, but not for I J K, G10, G92 and G53",
    ),
    "arc distance": dict.fromkeys((901, 911), "I J K absolute, or from the start (at the start of the program)"),
    "feed mode": dict.fromkeys((930, 940, 950), "see Feed modes G93, G94, G95"),
    "units": dict.fromkeys(
        (200, 210),
        "inch, mm, of lengths and F; acts before the motion of its own block; angles and deg/min are never scaled",
    ),
    "cutter compensation": dict.fromkeys((400, 410, 411, 420, 421), "off, left, right: see Cutter compensation"),
    "lathe diameter": {70: "diameters: X is then refused", 80: "radii; no effect"},
    "spindle mode": {
        960: "S is m/min or ft/min on the surface, D the most turns a minute: events, and a warning (VP045), since "
        "setpoints have no spindle speed. Feed moves under G95 are refused then (VP017)",
        970: "S is 1/min",
    },
    "tool length": {
        430: "on, that of H: see Tool length and tool-centre-point control",
        431: "on, as the axis words give it",
        432: "that of H is added",
        434: "on, that of H, with tool-centre-point control",
        435: "as G43.4, and I J K are the tool axis: see Tool vectors",
        490: "off",
    },
    "retract": {980: "cycles retract to the initial level", 990: "cycles retract to R (at the start of the program)"},
    "work offset": dict.fromkeys((540, 550, 560, 570, 580, 590, 591, 592, 593), "work systems 1 to 9"),
    "path control": dict.fromkeys((610, 611, 640), "exact path, exact stop, corner blends: see Path control"),
    "machine coordinates": {530: "with G0 or G1, in G90, for its block (VP017 otherwise)"},
    "non-modal": {
        40: "dwell: P seconds; P0 is a stop of one control cycle; comes before the motion of its block",
        100: "L1, L10, L11, L0: tool table: see Tool length and tool-centre-point control. L2: origin of work system "
        "P (1 to 9, or 0 for the active one); R turns X and Y. L20: the present position gets the given values",
        **dict.fromkeys(
            (280, 300),
            "to the home position, by way of the given position; without [home] of the machine file refused (VP015)",
        ),
        **dict.fromkeys((281, 301), "set the home position to the present position"),
        **dict.fromkeys((520, 920), "set the shift, at least one axis word; other axes keep theirs"),
        **dict.fromkeys((921, 922, 923), "clear, suspend, restore the shift"),
    },
}
#: M codes, in the same way.
_M: Final[Mapping[str, Mapping[int, str]]] = {
    "stopping": {
        **dict.fromkeys((0, 60), "stop for the operator"),
        1: "stop, only with --optional-stop",
        **dict.fromkeys((2, 30), "end of the program"),
    },
    "tool change": {6: "loads the tool of T and stops the spindle", 61: "Q: sets the number of the tool only"},
    "spindle": {
        **dict.fromkeys((3, 4, 5), "clockwise, counter-clockwise, off; S in 1/min, not negative"),
        19: "R orients the spindle",
        **dict.fromkeys((70, 71, 72, 73), "saved modes: see O words and subprograms"),
    },
    "coolant": dict.fromkeys((7, 8, 9), "mist, flood, off"),
    "override": dict.fromkeys((48, 49, 50, 51, 52, 53), "shown as events; P0 switches off"),
    "signals": dict.fromkeys(
        (62, 63, 64, 65, 66, 67, 68),
        "shown as events. P digital, E analog output, Q value. M66: P, E input, L mode, Q time",
    ),
    "subprograms": dict.fromkeys((98, 99), "call and return: see O words and subprograms"),
}
#: RS274/NGC as LinuxCNC has it on a mill, and tool vectors (G43.4, G43.5).
RS274: Final = CodeTable(
    g_groups=_G,
    m_groups=_M,
    refused_g={
        62: "splines of Fanuc controls; see --dialect fanuc",
        **dict.fromkeys((330, 331), "spindle-synchronised motion and rigid tapping"),
        **dict.fromkeys((760, 700, 701, 702, 710, 711, 712, 720, 721, 722), "lathe codes"),
        **dict.fromkeys((310, 382, 383, 384, 385), "probing: where the tool touches is only known at the machine"),
        **dict.fromkeys((171, 181, 191), "planes of U, V, W"),
        **dict.fromkeys((680, 682, 690, 531, 541),
                        "tilted work planes and other codes of Fanuc controls; see --dialect fanuc"),
    },
    refused_m=dict.fromkeys(range(100, 200), "external programs: they are never run"),
    words_of_g={
        20: "IJKRP", 30: "IJKRP", 40: "P", 50: "IJPQ", 51: "IJ", 52: "PL", 100: "LPRIJQ", 430: "H", 432: "H", 434: "H",
        435: "H", 640: "PQ",
        410: "D", 411: "D", 420: "D", 421: "D", 960: "D", 730: "RLQ", 740: "RLP", 810: "RL", 820: "RLP", 830: "RLQ",
        840: "RLP",
        850: "RL", 860: "RLP", 870: "RLIJK", 880: "RLP", 890: "RLP",
    },
    words_of_m={
        19: "RQP", 50: "P", 51: "P", 52: "P", 53: "P", 61: "Q", 62: "P", 63: "P", 64: "P", 65: "P", 66: "PELQ",
        67: "EQ", 68: "EQ", 98: "PL",
    },
)  # fmt: skip


def spell_g_code(code: int) -> str:
    """``434`` -> ``G43.4``."""
    return f"G{code // 10}" if code % 10 == 0 else f"G{code // 10}.{code % 10}"
