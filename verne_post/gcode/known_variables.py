"""Variables of controls by their numbers and names: what each is, and how a program that reads it is treated."""

import re
from collections.abc import Mapping
from typing import Final

#: How a variable is treated whose value only a control has.
_AT_MACHINE: Final = "its value is only known at the machine, so a program that reads it is refused (VP025)"
_MODAL: Final = {
    4001: "the G code of the motion in force",
    4002: "the plane in force: 17, 18 or 19",
    4003: "90 or 91, whichever is in force",
    4005: "the mode of the feed rate: 93, 94 or 95",
    4006: "the unit: 20 (inch) or 21 (mm)",
    4007: "the cutter compensation in force: 40, 41 or 42",
    4009: "the cycle in force, or 80",
    4010: "98 or 99, whichever is in force",
    4014: "the work system in force, such as 54",
    4109: "the feed rate F",
    4119: "the spindle speed S",
    4120: "the tool number T",
}
#: First and last number -> what they are. Those of the first table are read here.
_FANUC_READ: Final = {
    (5001, 5003): "the end of the last block in the work system: {XYZ}",
    (5021, 5023): "the place of the machine: {XYZ}",
    (5041, 5042): "the present place in the work system: {XYZ}",
    (11001, 11400): "the length of tool {number}",
    (13001, 13400): "the radius of tool {number}",
}
_FANUC_NOT_READ: Final = {
    (1000, 1035): "a signal of the machine to the program",
    (1100, 1135): "a signal of the program to the machine",
    (2001, 2800): "an offset of a tool in a table of the control",
    (3001, 3002): "a timer",
    (3003, 3004): "what stops the operator may make: single block, feed hold, override",
    (3011, 3012): "date or time",
    (3901, 3902): "a count of parts",
    (4000, 4999): "a code or a word that is in force",
    (5004, 5200): "a place or a length that the control keeps, such as that of a skip (G31)",
}
_SET_WITHOUT_EFFECT: Final = (3001, 3002, 3003, 3004, 3011, 3012)
_LINUXCNC: Final = {
    (5061, 5070): "the result of a probe (G38), which is not executed: 0 until the program sets it",
    (5161, 5169): "the home position of G28",
    (5181, 5189): "the home position of G30",
    (5210, 5210): "1 while G92 is in force, else 0",
    (5211, 5219): "the shift of G92",
    (5220, 5220): "the number of the work system in force: 1 is G54",
    (5221, 5390): "an entry of the work systems: 20 numbers each, from #5221 for G54 on",
    (5399, 5399): "what M66 has read",
    (5400, 5400): "the number of the tool in the spindle",
    (5401, 5409): "an offset of the tool in the spindle; #5403 is its length",
    (5410, 5410): "the diameter of the tool in the spindle",
    (5420, 5428): "the present place in the program",
}
_SIEMENS: Final = {
    "$PI": "3.14159...",
    "$P_EP": "the programmed end of the last block, by axis: $P_EP[X]",
    "$AA_IW": "the place in the work system, by axis: $AA_IW[X]",
    "$AA_IM": "the place of the machine, by axis: $AA_IM[X]",
    "$P_UIFR": "a work offset: $P_UIFR[1,X,TR] is X of G54",
    "$P_PFRAME": "the programmable frame",
    "$P_IFRAME": "the work offset in force",
    "$TC_DP1": "the type of a tool: 0 here",
    "$TC_DP3": "the length of a tool: $TC_DP3[1,1]",
    "$TC_DP6": "the radius of a tool: $TC_DP6[1,1]",
    "$P_TOOLNO": "the number of the tool in the spindle",
    "$P_TOOLP": "the number of the tool that T has chosen",
    "$P_TOOL": "the number D of the edge in force",
    "$P_TOOLR": "the radius of the tool in force",
    "$P_TOOLL": "the length of the tool in force: $P_TOOLL[1]",
    "$P_F": "the feed rate F",
    "$P_S": "the spindle speed S",
    "$P_SDIR": "the sense of the spindle: 3, 4 or 5",
    "$P_UIFRNUM": "the number of the work offset in force",
    "$P_TRAFO": "1 while TRAORI is in force, else 0",
    **dict.fromkeys(
        ("$P_SIM", "$P_ISTEST", "$P_SEARCH", "$P_SEARCHL", "$P_DRYRUN", "$P_PROGTEST", "$AC_SIM"),
        "whether the control simulates, tests or searches: 0 here",
    ),
    **{f"$TC_DP{number}": "wear or base of a tool: 0 here" for number in (2, 4, 5, *range(7, 26))},
}
_PREFIXES: Final = {
    "$TC_": "data of tools",
    "$M": "machine data",
    "$S": "setting data",
    "$P_": "the state of the program on the control",
    "$A": "the state of the machine",
    "$V": "a value of the drives",
}
_KLARTEXT_READ: Final = {
    (108, 108): "the radius of the tool, with DR, if the set-up gives its diameter",
    (109, 109): "the tool axis: 2 is Z",
    (113, 113): "the unit of the program: 0 is mm, 1 is inch",
    (114, 114): "the length of the tool",
    (120, 122): "the angle of {ABC} that PLANE or cycle 19 has computed",
}
_KLARTEXT_NOT_READ: Final = {
    (100, 107): "a value that the machine gives (PLC)",
    (110, 110): "the state of the spindle",
    (111, 111): "the state of the coolant",
    (112, 112): "the overlap of pockets",
    (115, 119): "a place that the touch probe has measured",
    (150, 199): "a result of a cycle of the touch probe",
}


def describe_variable(name: str) -> dict[str, str]:
    """What a variable is by the languages that have it: #5021, $P_EP[X], Q120; empty for other words."""
    if name.startswith("#") and name[1:].isdecimal():
        number = int(name[1:])
        return {"RS274/NGC": _describe_of_linuxcnc(number), "Fanuc": _describe_of_fanuc(number)}
    system = re.fullmatch(r"(\$[A-Z]\w*)(?:\[.*\])?", name)
    if system is not None:
        return {"Siemens": _describe_of_siemens(system[1])}
    if re.fullmatch(r"Q1\d\d", name):
        number = int(name[1:])
        if text := _find(_KLARTEXT_READ, number):
            return {"Klartext": f"{text}; the control sets it, and so does verne-post"}
        if text := _find(_KLARTEXT_NOT_READ, number):
            how_refused = "a program that reads it, and has not set it, is refused (VP025)"
            return {"Klartext": f"{text}, which the control sets and verne-post does not know: {how_refused}"}
    return {}


def _find(table: Mapping[tuple[int, int], str], number: int) -> str:
    """What a table says of a number; empty where it has it not."""
    for (first, last), text in table.items():
        if first <= number <= last:
            place = number - first
            return text.format(XYZ="XYZ"[place % 3], ABC="ABC"[place % 3], number=place + 1)
    return ""


def _describe_of_fanuc(number: int) -> str:
    if number == 0:
        return "has no value, and cannot be given one: a word with it is left out"
    if number < 34:
        return "a variable of a macro: a word of its call (G65), or what the macro sets"
    if 100 <= number < 1000 or 98000 <= number < 98500 or 900000 <= number < 907400:
        return "a variable of all programs; one that the program reads, and has not set, is refused (VP025)"
    if number == 3000:
        return "#3000=1(TEXT) stops the program with an alarm: a program that gets there is refused (VP027)"
    if number == 3006:
        return "#3006=1(TEXT) stops the program with a message, as M0"
    for first, last, system in ((5221, 5340, "G{}"), (7001, 7960, "G54.1 P{}")):
        index, axis = divmod(number - first, 20)
        if first <= number <= last and axis < 3:
            return f"{'XYZ'[axis]} of the work offset {system.format(index + (54 if first == 5221 else 1))}; it is read"
    if text := _MODAL.get(number, "") or _find(_FANUC_READ, number):
        return f"{text}; it is read, and not set"
    text = _find(_FANUC_NOT_READ, number) or "verne-post knows no variable of this number"
    without = "; setting it has no effect" if number in _SET_WITHOUT_EFFECT else ""
    return f"{text}; {_AT_MACHINE}{without}"


def _describe_of_linuxcnc(number: int) -> str:
    if 5021 <= number <= 5029 or 5081 <= number <= 5089:
        return "no parameter here: a program that reads it is refused (VP025); #5420 to #5428 are the present place"
    if not 1 <= number <= 5601:
        return "no parameter: they have the numbers 1 to 5601 (VP025)"
    if number <= 30:
        return "a variable: in a subprogram its own, a word of the call"
    if text := _find(_LINUXCNC, number):
        return text
    return "a variable of the whole program: 0 until the program, or --parameters FILE, sets it"


def _describe_of_siemens(name: str) -> str:
    if name in _SIEMENS:
        return _SIEMENS[name]
    kind = next((text for begin, text in _PREFIXES.items() if name.startswith(begin)), "a variable of the control")
    return f"{kind}, which verne-post does not know: a program that reads or sets it is refused (VP025)"
