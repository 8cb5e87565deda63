"""Modal groups of G and M codes, what each code does, and the words that it uses. G numbers are times ten.

A code that is in no group cannot be executed. docs/make_words.py makes the tables of docs/gcode.md from this. Another
dialect has another table, derived from this one (:mod:`verne_post.gcode.dialects`).
"""

from collections.abc import Collection, Mapping
from functools import cached_property
from typing import Final, TypeVar

from msgspec import Struct

from verne_post.base.suggestions import drop_doubles
from verne_post.base.tolerances import WHOLE_NUMBER
from verne_post.gcode.program_error import ProgramError
from verne_post.model.findings import Remedy

_Name = TypeVar("_Name", int, str)
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


_THREE_DIGITS: Final = 100
#: Why [remap] cannot give a code a meaning.
HAS_MEANING: Final = ": it already has a meaning; only what is not executed can be given one"

#: What gives a code or a name of the builder a meaning.
REMAP_GIVES: Final = '[remap] of the set-up, or of verne-post.toml, can give one: "ignore" or "event"'


def describe_remap(code: str) -> str:
    """What a user may write where no language has a meaning for a code: a line of [remap]."""
    key = f'"{code}"' if "." in code else code
    return f'[remap] of the set-up, or of verne-post.toml, can give it a meaning: {key} = "ignore", or "event"'


def make_unknown_function(code: int, column: int | None, near_codes: Collection[int] = ()) -> ProgramError:
    """Refuse (VP002) an M code without a meaning; all of a program are one finding, which one set-up settles.

    The one of the ``near_codes`` that there is may be meant, or a code of the builder's own.
    """
    name = f"M{code}"
    right = f"M{next(iter(near_codes))}" if len(near_codes) == 1 else ""
    text = f"{name}: no meaning in this language; {f'did you mean {right}? Else ' * bool(right)}{REMAP_GIVES}"
    edits = (Remedy(f"write {right}", right, misspelt=name, is_choice=True),) if right else ()
    about = None if right else name
    return ProgramError("VP002", text, column, about=about, settled_by=("remap", name), edits=edits)


def read_m_code(table: CodeTable, number: float, column: int) -> int:
    """The M code of a number.

    Raises
    ------
    ProgramError
        VP007, VP002: it is none, or none that is executed.
    """
    code = round(number)
    if abs(number - code) > WHOLE_NUMBER or number < 0:
        right_code = f"; did you mean M{-number:g}?" if number == code else ""
        raise ProgramError("VP007", f"M{number:g}: an M code is a whole number without a sign{right_code}", column)
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
        near = {int(one) for one in drop_doubled_digits(str(code))} & _OFTEN_MEANT & table.group_of_m.keys()
        raise make_unknown_function(code, column, near)
    if code not in table.group_of_m:
        text = f"M{code} is not a code of this language; {settles}"
        raise ProgramError("VP002", text, column, settled_by=("remap", f"M{code}"))
    return code


#: M codes that a code with a digit twice may be meant for, as M330; M11 and M22 are of builders, as clamps.
_OFTEN_MEANT: Final = frozenset({3, 5, 8, 9, 30, 98, 99})


def drop_doubled_digits(digits: str) -> set[str]:
    """What is meant if a digit but 0 is there twice: 21 of 211; G200 and M200 are of builders."""
    return {*drop_doubles(digits, "1-9")}


def spell_g_code(code: int) -> str:
    """``434`` -> ``G43.4``."""
    return f"G{code // 10}" if code % 10 == 0 else f"G{code // 10}.{code % 10}"


def end_texts(end: str, texts: Mapping[_Name, str]) -> dict[_Name, str]:
    """Texts with what all of them end with, such as ": see Arcs"."""
    return {name: f"{text}{end}" for name, text in texts.items()}


#: Ends the text of a code that holds before the program has said anything.
AT_START: Final = "; in force at the start of the program"
#: What holds for all codes of a group.
_FROM_ITS_BLOCK: Final = "from its own block on, but not for I J K, G10, G92 and G53"
_OF_UNITS: Final = "acts before the motion of its own block; angles and deg/min are never scaled"
_OF_SPEED: Final = "S in 1/min, not negative"
#: G codes of RS274/NGC: group (named as in LinuxCNC's documentation) -> code -> what it does.
_G: Final[Mapping[str, Mapping[int, str]]] = {
    "motion": {
        0: "rapid traverse",
        10: "straight move at the feed rate",
        **end_texts(": see Arcs", {20: "arc clockwise", 30: "arc counter-clockwise"}),
        **end_texts(
            ": see Splines", {50: "cubic spline", 51: "quadratic spline", 52: "a NURBS begins", 53: "the NURBS ends"}
        ),
        **end_texts(
            ": see Canned cycles",
            {
                730: "drilling with chip breaking",
                740: "tapping, left-hand thread",
                810: "drilling",
                820: "drilling with a dwell at the bottom",
                830: "deep-hole drilling, out of the hole after each peck",
                840: "tapping, right-hand thread",
                850: "boring, in and out at feed rate",
                860: "boring, out in rapid traverse with the spindle at rest",
                870: "back boring",
                880: "boring, stops for the operator",
                890: "boring with a dwell, out at feed rate",
            },
        ),
    },
    "cancel": {800: "ends the motion code; takes no axis words"},
    "plane": {170: "plane XY", 180: "plane ZX", 190: "plane YZ"},
    "distance": {900: f"absolute coordinates; {_FROM_ITS_BLOCK}", 910: f"incremental coordinates; {_FROM_ITS_BLOCK}"},
    "arc distance": {
        901: "I J K of arcs are absolute",
        911: "I J K of arcs count from the start of the arc" + AT_START,
    },
    "feed mode": end_texts(
        ": see Feed modes G93, G94, G95",
        {930: "inverse-time feed", 940: "feed per minute", 950: "feed per turn of the spindle"},
    ),
    "units": {200: f"lengths are inches; {_OF_UNITS}", 210: f"lengths are millimetres; {_OF_UNITS}"},
    "cutter compensation": end_texts(
        ": see Cutter compensation",
        {
            400: "cutter compensation off",
            410: "the tool goes left of the contour",
            411: "the tool, of diameter D, goes left of the contour",
            420: "the tool goes right of the contour",
            421: "the tool, of diameter D, goes right of it",
        },
    ),
    "lathe diameter": {70: "X is a diameter: X is then refused", 80: "X is a radius, as always on a mill; no effect"},
    "spindle mode": {
        960: "S is m/min or ft/min on the surface, D the most turns a minute: events, and a warning (VP045), since "
        "setpoints have no spindle speed. Feed moves under G95 are refused then (VP017)",
        970: "S is 1/min",
    },
    "tool length": {
        430: "the tool length of H is in force: see Tool length and tool-centre-point control",
        431: "the tool length is what the axis words say",
        432: "the tool length of H is added to that in force",
        434: "tool-centre-point control on, with the tool length of H: "
        "X Y Z are those of the tip while the rotary axes turn",
        435: "tool-centre-point control on, with the tool length of H; I J K are the tool axis: see Tool vectors",
        490: "no tool length is in force",
    },
    "retract": {
        980: "cycles go back to the height where the first one began",
        990: "cycles go back to the height R" + AT_START,
    },
    "work offset": {
        code: f"work offset {spell_g_code(code)}: coordinates count from its zero (--wcs, [wcs])"
        for code in (540, 550, 560, 570, 580, 590, 591, 592, 593)
    },
    "path control": end_texts(
        ": see Path control",
        {
            610: "exact path: a stop at corners, none where the path goes on smoothly",
            611: "exact stop at the end of every move",
            640: "corners are blended, within the tolerance P",
        },
    ),
    "machine coordinates": {530: "this block is in machine coordinates; it needs G0 or G1, and G90 (VP017 otherwise)"},
    "non-modal": {
        40: "dwell: P seconds; P0 is a stop of one control cycle; comes before the motion of its block",
        100: "L1, L10, L11, L0: tool table: see Tool length and tool-centre-point control. L2: origin of work system "
        "P (1 to 9: G54 to G59.3, or 0 for the active one); R turns X and Y. L20: the present position gets the given "
        "values",
        280: "rapid traverse to the home position, by way of the place given; without [home] of the machine file "
        "refused (VP015)",
        300: "rapid traverse to the second home position, by way of the place given; without [home] of the "
        "machine file refused (VP015)",
        281: "the present position becomes the home position of G28",
        301: "the present position becomes the home position of G30",
        520: "shifts the zero by the values given, at least one; other axes keep theirs",
        920: "shifts the zero: the present position gets the values given, at least one; other axes keep theirs",
        921: "ends the shift of G92",
        922: "suspends the shift of G92",
        923: "restores the shift of G92",
    },
}
#: M codes, in the same way.
_M: Final[Mapping[str, Mapping[int, str]]] = {
    "stopping": {
        **dict.fromkeys((0, 60), "stop for the operator"),
        1: "stop, only with --optional-stop",
        **dict.fromkeys((2, 30), "end of the program"),
    },
    "tool change": {
        6: "loads the tool of T and stops the spindle",
        61: "sets the number of the tool to Q, and loads none",
    },
    "spindle": {
        3: f"spindle on, clockwise; {_OF_SPEED}",
        4: f"spindle on, counter-clockwise; {_OF_SPEED}",
        5: "spindle off",
        19: "turns the spindle to the angle R and stops it there",
        **end_texts(
            ": see O words and subprograms",
            {
                70: "saves the modes",
                71: "forgets the saved modes",
                72: "restores the saved modes",
                73: "saves the modes, and restores them at the end of the subprogram",
            },
        ),
    },
    "coolant": {7: "mist on", 8: "flood coolant on", 9: "coolant off"},
    "override": {
        48: "the operator may change feed and speed; shown as an event",
        49: "the operator may not change feed and speed; shown as an event",
        50: "feed override on, P0 off; shown as an event",
        51: "speed override on, P0 off; shown as an event",
        52: "adaptive feed on, P0 off; shown as an event",
        53: "feed stop on, P0 off; shown as an event",
    },
    "signals": {
        62: "switches the digital output P on with the next move; shown as an event",
        63: "switches the digital output P off with the next move; shown as an event",
        64: "switches the digital output P on; shown as an event",
        65: "switches the digital output P off; shown as an event",
        66: "waits for the input P or E in the way L, at most Q seconds; shown as an event",
        67: "sets the analog output E to Q with the next move; shown as an event",
        68: "sets the analog output E to Q; shown as an event",
    },
    "subprograms": end_texts(
        ": see O words and subprograms", {98: "calls a subprogram", 99: "returns from a subprogram"}
    ),
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
                        "tilted work planes and other codes of Fanuc controls; see --dialect fanuc")
    },
    refused_m=dict.fromkeys(range(100, 200), "external programs: they are never run"),
    words_of_g={
        20: "IJKRP", 30: "IJKRP", 40: "P", 50: "IJPQ", 51: "IJ", 52: "PL", 100: "LPRIJQ", 430: "H", 432: "H", 434: "H",
        435: "H", 640: "PQ",
        410: "D", 411: "D", 420: "D", 421: "D", 960: "D", 730: "RLQ", 740: "RLP", 810: "RL", 820: "RLP", 830: "RLQ",
        840: "RLP",
        850: "RL", 860: "RLP", 870: "RLIJK", 880: "RLP", 890: "RLP"
    },
    words_of_m={
        19: "RQP", 50: "P", 51: "P", 52: "P", 53: "P", 61: "Q", 62: "P", 63: "P", 64: "P", 65: "P", 66: "PELQ",
        67: "EQ", 68: "EQ", 98: "PL"
    },
)  # fmt: skip
