"""Machine files from configurations of LinuxCNC: the INI file, and what its HAL files set of the kinematics.

Kinematics with their pins, units, travels and speeds of the joints, and the servo period are read. docs/machines.md has
the meaning of the kinematics; findings (VP509) name what is left out.
"""

import math
import re
from collections.abc import Iterator
from typing import Final

from msgspec import Struct

from verne_post.base.printable import escape_unprinted
from verne_post.config.linuxcnc_files import IniFile, Pins, Read, parse_number
from verne_post.config.toml_text import (
    ImportedMachine,
    convert_speeds,
    list_jerkless,
    quote,
    refuse_value,
    show_list,
    write_chain,
    write_end,
    write_joint,
)
from verne_post.model.findings import make_finding

_MM: Final = {"mm": 1.0, "metric": 1.0, "in": 25.4, "inch": 25.4, "imperial": 25.4}
#: Numbers count units in one mm, and in one degree. People round that of an inch to 0.03937.
_INCH_IN_MM: Final = 1.0 / 25.4
_ROUNDED: Final = 1e-5
_DEGREES: Final = ("deg", "degree")
#: Limits beyond this are none: the default of LinuxCNC is 1e99.
_NO_LIMIT: Final = 1e9
#: The struts at home may miss [JOINT_n]HOME by this, mm: people round to a hundredth of a millimetre, or to 1e-4 inch.
_HOME_APART_MM: Final = 0.05
#: Of the Jacobian of a hexapod, which a configuration does not say: that of the shipped ones.
_SMALLEST_MEASURE: Final = 0.05
#: Nanoseconds of a second: SERVO_PERIOD is in them.
_NANO: Final = 1e-9


class Kinematics(Struct, frozen=True):
    """A kinematics that is executed: order of the joints, pins of lengths, rotary joints as in a machine file."""

    coordinates: str  #: Letters of the joints where the INI names none.
    pins: tuple[str, ...]  #: Lengths, 0 where nothing sets them.
    tool: tuple[str, ...]  #: Pins that the tool length comes in by; one of them has to be connected.


_ROT_POINT: Final = ("x-rot-point", "y-rot-point", "z-rot-point")
_HEXAPOD: Final = "genhexkins"
#: Pins of the hexapod that may be left as they are.
_HEXAPOD_PINS: Final = ("spindle-offset", "screw-lead")
_STRUT_PINS: Final = tuple(f"{end}.{k}.{axis}" for end in ("base", "platform") for k in range(6) for axis in "xyz")
#: By the name of the component.
_KINEMATICS: Final = {
    "xyzac-trt-kins": Kinematics("xyzac", (*_ROT_POINT, "y-offset", "z-offset"), ("tool-offset",)),
    "xyzbc-trt-kins": Kinematics("xyzbc", (*_ROT_POINT, "x-offset", "z-offset"), ("tool-offset",)),
    "xyzab_tdr_kins": Kinematics("xyzab", (*_ROT_POINT, "x-offset", "z-offset"), ("tool-offset-z",)),
    "5axiskins": Kinematics("xyzbcw", ("pivot-length",), ()),
    "maxkins": Kinematics("xyzabcuvw", ("pivot-length",), ()),
    _HEXAPOD: Kinematics("xyzabc", (*_STRUT_PINS, *_HEXAPOD_PINS), ("tool-offset",)),
}
#: Lengths that a component has where nothing sets its pin, in units of the INI.
_DEFAULTS: Final = {("5axiskins", "pivot-length"): 250.0, ("maxkins", "pivot-length"): 0.666}
#: Why others are refused; the table of docs/machines.md in short.
_REFUSED: Final = {
    "genhex": "the name of an older version: expected genhexkins",
    "pentakins": "five struts on rings about the tool are not executed",
    "lineardeltakins": "three axes; kind = 'linear_delta' has this carrier over a tilting table: start from "
    "linear_delta",
    "rotarydeltakins": "arms that turn in place of sliders are not executed",
    "tripodkins": "three wires hold no tool axis",
    "xyzacb_trsrn": "three rotary joints: a chain has two",
    "xyzbca_trsrn": "three rotary joints: a chain has two",
    "trivkins": "joints without a relation of tool and part: start from the shipped file that has the machine's "
    "rotary joints",
}


def convert_linuxcnc(raw: bytes, name: str, read: Read) -> ImportedMachine:
    """The machine file of a LinuxCNC configuration.

    Parameters
    ----------
    raw : bytes
        The INI file; ``name`` is for messages.

    Raises
    ------
    InputError
        VP507 where it cannot be read, VP508 where its kinematics are not executed.
    """
    ini = IniFile(raw, name, read)
    component, coordinates = _find_kinematics(ini)
    kinematics = _KINEMATICS[component]
    pins = Pins(ini).read(read)
    notes = list(_find_notes(ini, pins, component, coordinates))
    unit = _find_unit(ini)
    lengths = {}
    for pin in kinematics.pins:
        value = pins.find_number(f"{component}.{pin}")
        if value is None and component == _HEXAPOD and pin not in _HEXAPOD_PINS:
            raise refuse_value(
                name,
                f"nothing sets {component}.{pin}: the joints of the struts are needed, and the defaults of the "
                "component are those of a demonstration",
            )
        if value is None:
            value = _DEFAULTS.get((component, pin), 0.0)
            notes.append(f"nothing sets {component}.{pin}: taken as {value:g}, its default")
        lengths[pin] = unit * value
    sense = pins.find_number(f"{component}.conventional-directions") or 0.0
    if component == _HEXAPOD:
        chain, joints = _place_hexapod(ini, lengths, unit, notes)
    else:
        joints = [_write_joint(ini, letter, coordinates.index(letter), unit) for letter in "xyz"]
        chain, rotary = _place_rotary(component, lengths, conventional=bool(sense))
        joints += [_write_joint(ini, letter, coordinates.index(letter), unit, text) for letter, text in rotary]
    notes.append("[home] and [table] are left out: the configuration does not say them")
    if without := list_jerkless(joints):
        notes.append(f"{without}: no MAX_JERK; the setpoints jerk as far as the accelerations allow")
    period = ini.read_number("EMCMOT", "SERVO_PERIOD")
    cycle = 0.001 if period is None else period * _NANO
    groups = ("carrier",) if component == _HEXAPOD else ()
    return ImportedMachine(
        "\n".join([*_write_head(ini, component), *chain, *joints, *write_end(cycle, name, *groups)]),
        tuple(make_finding("VP509", f"{name}: {text}") for text in notes),
    )


def _find_kinematics(ini: IniFile) -> tuple[str, str]:
    """The component, and the letters of its joints."""
    found = ini.find("KINS", "KINEMATICS")
    if found is None or not found[0].split():
        raise refuse_value(ini.name, "[KINS]KINEMATICS is missing: it says which kinematics the machine has")
    component, *parameters = found[0].split()
    if component not in _KINEMATICS:
        known = ", ".join(_KINEMATICS)
        why = _REFUSED.get(component, "no kinematics whose meaning is known here")
        raise refuse_value(found[1], f"KINEMATICS = {component}: {why}; imported are {known}", "VP508")
    coordinates = _KINEMATICS[component].coordinates
    for parameter in parameters:
        key, _equals, value = parameter.partition("=")
        if key.lower() == "coordinates" and value:
            coordinates = value.lower()
    needed = set(_KINEMATICS[component].coordinates) - set("auvw") | ({"a"} if component.startswith("xyza") else set())
    if missing := sorted(needed - set(coordinates)):
        raise refuse_value(found[1], f"coordinates={coordinates}: {component} needs {', '.join(missing)} too")
    return component, coordinates


def _find_notes(ini: IniFile, pins: Pins, component: str, coordinates: str) -> Iterator[str]:
    """What of a configuration is not taken over."""
    kinematics = _KINEMATICS[component]
    if component == "xyzab_tdr_kins":
        yield "the kinematics are those of its type 1, with tool-centre-point control; type 0 has none"
    for pin in kinematics.tool:
        if not pins.is_connected(f"{component}.{pin}"):
            yield (
                f"{component}.{pin} is not connected to motion.tooloffset.z: LinuxCNC then compensates no tool length; "
                "the file does"
            )
    spare = [
        letter.upper()
        for letter in dict.fromkeys(coordinates)
        if letter in "uvw" and f"AXIS_{letter.upper()}" in {s for s, _k in ini.values}
    ]
    if spare:
        yield f"{', '.join(spare)}: a machine file has five joints; these are left out, as if they stood at 0"
    twice = sorted({letter.upper() for letter in coordinates if coordinates.count(letter) > 1})
    if twice:
        yield f"{', '.join(twice)} has several joints: the limits of the first are taken"
    if pins.skipped:
        yield f"not read: {', '.join(pins.skipped)}; what they set of the kinematics is not in the file"


def _find_unit(ini: IniFile) -> float:
    """Millimetres of a unit of length."""
    value, where = ini.find("TRAJ", "LINEAR_UNITS") or ("mm", ini.name)
    angular, there = ini.find("TRAJ", "ANGULAR_UNITS") or ("deg", ini.name)
    if angular.lower() not in _DEGREES and _read_unit(angular) != 1.0:
        raise refuse_value(there, f"[TRAJ]ANGULAR_UNITS = {angular}: expected deg, degree, or 1: units in one degree")
    if value.lower() in _MM:
        return _MM[value.lower()]
    in_mm = _read_unit(value)
    for unit, number in ((1.0, 1.0), (25.4, _INCH_IN_MM)):
        if abs(in_mm - number) <= _ROUNDED * number:
            return unit
    text = f"[TRAJ]LINEAR_UNITS = {value}: expected one of {', '.join(_MM)}, or 1 or 0.03937: units in one mm"
    raise refuse_value(where, text)


def _read_unit(text: str) -> float:
    """A unit that is given as a number; nan where it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _place_rotary(
    component: str, lengths: dict[str, float], *, conventional: bool
) -> tuple[list[str], list[tuple[str, str]]]:
    """[chain], and both rotary joints: trunnions turn the part right-handed, or as conventional directions do."""
    point = [lengths.get(pin, 0.0) for pin in _ROT_POINT]
    through = [one + lengths.get(f"{axis}-offset", 0.0) for axis, one in zip("xyz", point, strict=True)]
    if component == "xyzab_tdr_kins":  # b carries a, and both turn the part left-handed
        rotary = [
            ("b", f'turns = [0.0, 1.0, 0.0]\nthrough = {show_list(point)}\npositive = "tool"'),
            ("a", f'turns = [1.0, 0.0, 0.0]\nthrough = {show_list(through)}\npositive = "tool"'),
        ]
        return write_chain([*"xyz"], ["b", "a"]), rotary
    if component.endswith("trt-kins"):
        tilt = component[3]
        positive = f'positive = "{"tool" if conventional else "part"}"'
        direction = [1.0, 0.0, 0.0] if tilt == "a" else [0.0, 1.0, 0.0]
        rotary = [
            (tilt, f"turns = {direction}\nthrough = {show_list(through)}\n{positive}"),
            ("c", f"turns = [0.0, 0.0, 1.0]\nthrough = {show_list(point)}\n{positive}"),
        ]
        return write_chain([*"xyz"], [tilt, "c"]), rotary
    pivot = show_list([0.0, 0.0, lengths["pivot-length"]])
    if component == "5axiskins":
        rotary = [
            ("c", "turns = [0.0, 0.0, 1.0]\nthrough = [0.0, 0.0, 0.0]"),
            ("b", f"turns = [0.0, -1.0, 0.0]\nthrough = {pivot}"),
        ]
        return write_chain([*"xyzcb"], []), rotary
    sense = 1.0 if conventional else -1.0
    rotary = [
        ("b", f"turns = [0.0, {sense}, 0.0]\nthrough = {pivot}"),
        ("c", 'turns = [0.0, 0.0, 1.0]\nthrough = [0.0, 0.0, 0.0]\npositive = "tool"'),
    ]
    return write_chain([*"xyzb"], ["c"]), rotary


def _place_hexapod(
    ini: IniFile, lengths: dict[str, float], unit: float, notes: list[str]
) -> tuple[list[str], list[str]]:
    """[chain] and [carrier] of genhexkins, and its struts as joints.

    Its world is the base frame, and its pose that of the tool, with the platform's turn R about it: the platform's
    origin is at ``pose + (R z - z) (spindle-offset + tool-offset)``. So upright the gauge point is spindle-offset below
    the platform's origin, and program coordinates count from spindle-offset below the origin of the base.
    """
    if lengths["screw-lead"]:
        text = (
            f"{_HEXAPOD}.screw-lead = {lengths['screw-lead'] / unit:g}: struts whose value turns with their joints "
            "(strut length correction) are not executed; expected 0"
        )
        raise refuse_value(ini.name, text, "VP508")
    home = _read_home(ini, unit, notes)
    shift = lengths["spindle-offset"]
    lines = [
        "[chain]                             # mm, base frame: the world of genhexkins, z up",
        'tool = ["carrier"]',
        "part = []",
        'words = "AC"',
        f"gauge = {show_list([*home[:2], home[2] - shift])}",
        "axis = [0.0, 0.0, 1.0]",
        f"part_zero = {show_list([0.0, 0.0, -shift])}",
        "",
        "[carrier]",
        'kind = "rods"',
        f"actuators = [{', '.join(quote(f'joint{k}') for k in range(6))}]",
        f"home = {show_list(home)}",
        "struts = [",
    ]
    joints = []
    for k in range(6):
        base, end = ([lengths[f"{side}.{k}.{axis}"] for axis in "xyz"] for side in ("base", "platform"))
        lines.append(f"  {{ platform = {show_list(end)}, base = {show_list(base)}, length = {quote(f'joint{k}')} }},")
        length = math.dist([h + e for h, e in zip(home, end, strict=True)], base)
        stated = ini.read_number(f"JOINT_{k}", "HOME")
        if stated is not None and abs(unit * stated - length) > _HOME_APART_MM:
            notes.append(
                f"[JOINT_{k}]HOME = {stated:g}, and with the platform at [TRAJ]HOME the strut is {length / unit:.6g} "
                "long: one of them is wrong, or the machine homes elsewhere"
            )
        joints.append(_write_strut(ini, k, unit))
    lines += ["]", f"smallest_singular_value = {_SMALLEST_MEASURE}         # assumed", ""]
    notes.append(
        "its words A, B, C are roll, pitch and yaw of the platform; here A and C say where the tool points, and the "
        "platform takes the shortest turn from home to there"
    )
    notes.append(
        "machine coordinates (G53, G28) count from the gauge point at [TRAJ]HOME, those of LinuxCNC from the base; "
        "work offsets of --wcs are those of LinuxCNC"
    )
    notes.append(
        f"smallest_singular_value = {_SMALLEST_MEASURE} is assumed; rod_diameter_mm and the cones of the joints are "
        "left out, so that distances of the struts and their joints are not checked"
    )
    return lines, joints


def _read_home(ini: IniFile, unit: float, notes: list[str]) -> list[float]:
    """The place of the platform at home, mm."""
    value, where = ini.find("TRAJ", "HOME") or ("", ini.name)
    words = re.split(r"[#;]", value, maxsplit=1)[0].replace(",", " ").split()
    if len(words) < 3:
        raise refuse_value(
            where, f"[TRAJ]HOME = {value[:60]!r}: expected X Y Z of the platform at home, which chooses the assembly"
        )
    home = [parse_number(word, where, "[TRAJ]HOME") for word in words]
    if any(home[3:]):
        notes.append(
            "[TRAJ]HOME has the platform turned; the file has it at the same place with the directions of the base"
        )
    return [unit * one for one in home[:3]]


def _write_strut(ini: IniFile, number: int, unit: float) -> str:
    """[joints.jointN] of a strut, whose length is never below 0."""
    low, high = (ini.read_number(f"JOINT_{number}", key) for key in ("MIN_LIMIT", "MAX_LIMIT"))
    if high is None or not 0.0 < unit * high < _NO_LIMIT or (low is not None and low >= high):
        raise refuse_value(
            ini.name,
            f"[JOINT_{number}]: MIN_LIMIT and MAX_LIMIT do not bound the strut; expected both, the smaller first",
        )
    travel = f"travel_mm = {show_list([unit * max(low or 0.0, 0.0), unit * high])}"
    return write_joint(f"joint{number}", "", travel, _read_speeds(ini, f"JOINT_{number}", f"joint{number}", unit))


def _read_speeds(ini: IniFile, section: str, name: str, scale: float) -> dict[str, float | None]:
    keys = {"velocity": "MAX_VELOCITY", "acceleration": "MAX_ACCELERATION", "jerk": "MAX_JERK"}
    given = {kind: (f"[{section}]{key}", ini.read_number(section, key), scale) for kind, key in keys.items()}
    return convert_speeds(ini.name, name, given)


def _write_joint(ini: IniFile, letter: str, number: int, unit: float, rotary: str = "") -> str:
    """[joints.LETTER] of the joint with a number: limits of the joint, and of rotary ones of the axis too."""
    section, axis = f"JOINT_{number}", f"AXIS_{letter.upper()}"
    scale, what = (1.0, "travel_deg") if rotary else (unit, "travel_mm")
    ends = []
    for key, choose, sign in (("MIN_LIMIT", max, -1.0), ("MAX_LIMIT", min, 1.0)):
        given = [
            value
            for one in ((section, axis) if rotary else (section,))
            if (value := ini.read_number(one, key)) is not None
        ]
        ends.append(choose([value * scale for value in given], default=sign * 2 * _NO_LIMIT))
    wrapped = (ini.find(axis, "WRAPPED_ROTARY") or ("0", ""))[0].strip() not in ("0", "NO", "no", "FALSE", "false", "")
    endless = bool(rotary) and (wrapped or (ends[0] <= -_NO_LIMIT and ends[1] >= _NO_LIMIT))
    if not endless and not (-_NO_LIMIT < ends[0] < ends[1] < _NO_LIMIT):
        raise refuse_value(
            ini.name,
            f"[{section}]: MIN_LIMIT and MAX_LIMIT of {letter} do not bound its travel; expected both, the "
            "smaller first",
        )
    geometry = rotary or f"slides = {[float(one == letter) for one in 'xyz']}"
    travel = "" if endless else f"{what} = {show_list(ends)}"
    return write_joint(letter, geometry, travel, _read_speeds(ini, section, letter, scale))


def _write_head(ini: IniFile, component: str) -> list[str]:
    title = (ini.find("EMC", "MACHINE") or (component, ""))[0] or component
    return [
        f"# From {escape_unprinted(ini.name)}, a configuration of LinuxCNC with {component}. Keys: "
        "docs/machine-file.md, schema 2.",
        "schema = 2",
        f"name = {quote(title)}",
        "",
    ]
