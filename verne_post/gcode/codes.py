"""Modal groups of G and M codes, and the words that each code uses. G numbers are times ten.

Another dialect has another table, derived from this one (:mod:`verne_post.gcode.dialects`).
"""

from collections.abc import Iterable, Mapping
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
    """The codes of a dialect.

    Attributes
    ----------
    g_groups, m_groups : mapping
        Modal group -> codes.
    refused_g, refused_m : mapping
        Codes that are known and not executed -> what they are.
    words_of_g, words_of_m : mapping
        Letters beside axes, F, S, T that a code uses.
    """

    g_groups: Mapping[str, tuple[int, ...]]
    m_groups: Mapping[str, tuple[int, ...]]
    refused_g: Mapping[int, str]
    refused_m: Mapping[int, str]
    words_of_g: Mapping[int, str]
    words_of_m: Mapping[int, str]

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
HAS_MEANING: Final = ": this code has a meaning of its own; only codes that are not executed can be given one"


def describe_remap(code: str) -> str:
    """What a user may write where no language has a meaning for a code: a line of [remap]."""
    key = f'"{code}"' if "." in code else code
    return f'[remap] of the set-up, or of verne-post.toml, can give it a meaning: {key} = "ignore", or "event"'


def make_unknown_function(code: int, column: int | None) -> ProgramError:
    """Refuse (VP002) an M code without a meaning; all of a program are one finding, which one set-up settles."""
    text = f'M{code}: no meaning in this language; [remap] of the set-up, or of verne-post.toml, can give one: "ignore" or "event"'
    return ProgramError("VP002", text, column, about=f"M{code}", settled_by=("remap", f"M{code}"))


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
            f"LinuxCNC switches kinematics with it, and [remap] of the set-up, or of verne-post.toml, says to which: M{code} = "
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


#: RS274/NGC as LinuxCNC has it on a mill (names of groups as in its documentation), and tool vectors (G43.4, G43.5).
RS274: Final = CodeTable(
    g_groups={
        "non-modal": (40, 100, 280, 281, 300, 301, 520, 920, 921, 922, 923),
        "machine coordinates": (530,),
        "motion": (0, 10, 20, 30, 50, 51, 52, 53, *(code for code in CYCLES if code != 760)),
        "cancel": (800,),
        "plane": (170, 180, 190),
        "distance": (900, 910),
        "arc distance": (901, 911),
        "feed mode": (930, 940, 950),
        "units": (200, 210),
        "lathe diameter": (70, 80),
        "spindle mode": (960, 970),
        "cutter compensation": (400, 410, 411, 420, 421),
        "tool length": (430, 431, 432, 434, 435, 490),
        "retract": (980, 990),
        "work offset": (540, 550, 560, 570, 580, 590, 591, 592, 593),
        "path control": (610, 611, 640),
    },
    m_groups={
        "signals": (62, 63, 64, 65, 66, 67, 68),
        "stopping": (0, 1, 2, 30, 60),
        "tool change": (6, 61),
        "spindle": (3, 4, 5, 19, 70, 71, 72, 73),
        "coolant": (7, 8, 9),
        "override": (48, 49, 50, 51, 52, 53),
        "subprograms": (98, 99),
    },
    refused_g={
        62: "splines of Fanuc controls; see --dialect fanuc",
        **dict.fromkeys((330, 331), "spindle-synchronised motion and rigid tapping"),
        **dict.fromkeys((760, 700, 701, 702, 710, 711, 712, 720, 721, 722), "lathe codes"),
        **dict.fromkeys((382, 383, 384, 385), "probing: where the tool touches is only known at the machine"),
        **dict.fromkeys((171, 181, 191), "planes of U, V, W"),
        **dict.fromkeys((680, 682, 690, 531, 541), "tilted work planes and other codes of Fanuc controls; see --dialect fanuc"),
    },
    refused_m=dict.fromkeys(range(100, 200), "external programs: they are never run"),
    words_of_g={
        20: "IJKRP", 30: "IJKRP", 40: "P", 50: "IJPQ", 51: "IJ", 52: "PL", 100: "LPRIJQ", 430: "H", 432: "H", 434: "H", 435: "H", 640: "PQ",
        410: "D", 411: "D", 420: "D", 421: "D", 960: "D", 730: "RLQ", 740: "RLP", 810: "RL", 820: "RLP", 830: "RLQ", 840: "RLP",
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


def refuse_known_codes(remap: Iterable[str], *tables: CodeTable) -> None:
    """Refuse to give codes another meaning that all of some tables execute.

    Raises
    ------
    ValueError
    """
    for code in remap:
        if all(table.is_executed(code) for table in tables):
            raise ValueError(f"{code}{HAS_MEANING}")
