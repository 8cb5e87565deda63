"""Modal groups of G and M codes, and the words that each code uses. G numbers are times ten."""

from typing import Final

#: Codes that this version executes, by modal group (names as in the LinuxCNC documentation).
G_GROUPS: Final[dict[str, tuple[int, ...]]] = {
    "non-modal": (40, 100, 280, 300, 520, 920, 921, 922, 923),
    "machine coordinates": (530,),
    "motion": (0, 10, 20, 30),
    "cancel": (800,),
    "plane": (170, 180, 190),
    "distance": (900, 910),
    "arc distance": (901, 911),
    "feed mode": (930, 940, 950),
    "units": (200, 210),
    "cutter compensation": (400,),
    "tool length": (430, 431, 434, 435, 490),
    "retract": (980, 990),
    "work offset": (540, 550, 560, 570, 580, 590, 591, 592, 593),
    "path control": (610, 611, 640),
}
GROUP_OF_G: Final[dict[int, str]] = {code: group for group, codes in G_GROUPS.items() for code in codes}

#: Codes of the language that this version refuses, with the reason.
REFUSED_G: Final[dict[int, str]] = {
    **dict.fromkeys((50, 51, 52, 53, 62, 63), "splines"),
    **dict.fromkeys((70, 80, 330, 331, 760, 700, 701, 702, 710, 711, 712, 720, 721, 722, 960, 970),
                    "lathe codes and spindle-synchronised motion"),
    **dict.fromkeys((382, 383, 384, 385), "probing"),
    **dict.fromkeys((730, 740, 810, 820, 830, 840, 850, 860, 870, 880, 890), "canned cycles"),
    **dict.fromkeys((410, 411, 420, 421), "cutter compensation"),
    **dict.fromkeys((171, 181, 191), "planes of U, V, W"),
    **dict.fromkeys((281, 301), "storing home positions"),
    **dict.fromkeys((432,), "adding tool offsets"),
    **dict.fromkeys((680, 682, 690, 531, 541), "tilted work planes and dialect codes"),
}  # fmt: skip

M_GROUPS: Final[dict[str, tuple[int, ...]]] = {
    "stopping": (0, 1, 2, 30, 60),
    "tool change": (6,),
    "spindle": (3, 4, 5),
    "coolant": (7, 8, 9),
    "override": (48, 49),
}
GROUP_OF_M: Final[dict[int, str]] = {code: group for group, codes in M_GROUPS.items() for code in codes}
REFUSED_M: Final[dict[int, str]] = {
    19: "spindle orientation",
    61: "setting the loaded tool",
    **dict.fromkeys(range(50, 54), "override switches"),
    **dict.fromkeys((62, 63, 64, 65, 66, 67, 68), "digital and analog signals"),
    **dict.fromkeys((70, 71, 72, 73), "saved modal state"),
    **dict.fromkeys((98, 99), "subprograms"),
    **dict.fromkeys(range(100, 200), "external programs"),
}

#: Words beside axes, F, S, T that a G code uses.
WORDS_OF_G: Final[dict[int, str]] = {
    20: "IJKRP", 30: "IJKRP", 40: "P", 100: "LPRIJQ", 430: "H", 434: "H", 435: "H", 640: "PQ",
}  # fmt: skip
#: Non-modal codes that take the axis words of the block away from the motion.
TAKES_AXES: Final = (100, 280, 300, 520, 920)


def g_name(code: int) -> str:
    """``434`` -> ``G43.4``."""
    return f"G{code // 10}" if code % 10 == 0 else f"G{code // 10}.{code % 10}"
