"""Machine files from machine data of a SINUMERIK: lines ``N24100 $MC_TRAFO_TYPE_1=24`` of archive or ``initial.ini``.

Read are the generic five-axis transformations (types 24, 40 and 56 of MD24100, or 72 with the data of a tool carrier),
or without one an orientable tool carrier ($TC_CARR); names of the axes, software limits, speeds, and the interpolation
cycle. With the tool adapter at machine zero and all rotary axes at 0, their vectors mean (Siemens, SINUMERIK Operate
(IM9), commissioning manual, offset vectors I1 to I4; the transformations have the same under other names):

    head (T, 24):   I3 from the tool adapter to axis 2, I2 from axis 2 to axis 1, I1 closes;      axis 2 sits on axis 1
    table (P, 40):  I2 from machine zero to axis 1, I3 from axis 1 to axis 2, I4 closes;          axis 2 sits on axis 1
    mixed (M, 56):  I2 from the tool adapter to axis 1 of the head, I3 from machine zero to axis 2 of the table

V1 and V2 are the directions about which an axis turns what it carries, right-handed: the manual reverses them where
the workpiece is moved. What is left out is said in findings (VP509).
"""

import re
from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.printable import escape_unprinted
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
from verne_post.model.findings import InputError, make_finding

_LINE: Final = re.compile(
    r"\s*(?:N\d+\s+)?\$(?P<name>\w+)\s*(?:\[(?P<index>[^\]]*)\])?\s*=\s*(?P<value>\"[^\"]*\"|[^\s;']+)"
)
_CHANNEL: Final = re.compile(r"\s*CHANDATA\s*\(\s*(\d+)\s*\)", re.IGNORECASE)
_IS_DATA: Final = re.compile(r"^\s*(?:N\d+\s+)?\$(?:MN|MC|MA|TC)_", re.MULTILINE)
#: Generic transformations, by MD24100: what of the machine turns.
_GENERIC: Final = {24: "T", 40: "P", 56: "M"}
#: The transformation that takes the vectors of a tool carrier.
_BY_CARRIER: Final = 72
#: Types that name two axes by letters and have no vectors.
_BY_LETTERS: Final = frozenset((*range(16, 22), *range(32, 36), *range(48, 52)))
#: Transformations that a channel may have.
_SLOTS: Final = 20
#: Vectors of a transformation under the names of a tool carrier, by what turns.
_OFFSETS: Final = {
    "T": {"I1": "PART_OFFSET", "I2": "JOINT_OFFSET", "I3": "BASE_TOOL"},
    "P": {"I2": "BASE_TOOL", "I3": "JOINT_OFFSET_PART", "I4": "PART_OFFSET"},
    "M": {"I1": "JOINT_OFFSET", "I2": "BASE_TOOL", "I3": "JOINT_OFFSET_PART", "I4": "PART_OFFSET"},
}
#: First of three parameters of a tool carrier.
_CARRIER: Final = {"I1": 1, "I2": 4, "V1": 7, "V2": 10, "I3": 15, "I4": 18}
_NAMED_IN_CARRIER: Final = (21, 22)
_KIND_OF_CARRIER: Final = 23
_FINE: Final = range(41, 61)
#: Software limits beyond this are none: the default of the control is 1e8.
_NO_LIMIT: Final = 1e7
#: A vector that is shorter is none; chains that close to this do.
_NONE_MM: Final = 1e-9
_DEG_PER_TURN: Final = 360.0
_MM_PER_M: Final = 1000.0
_S_PER_MIN: Final = 60.0


def is_machine_data(raw: bytes) -> bool:
    """Whether a file holds machine data of a SINUMERIK."""
    return _IS_DATA.search(raw.decode("utf-8", errors="replace")) is not None


class MachineData:
    """Values of machine data with their lines; those of a channel by its number. The last of two values counts."""

    def __init__(self, raw: bytes, name: str) -> None:
        self.name, self.channel = name, 1
        self._values = dict[tuple[int, str, str], tuple[str, str]]()
        self.channels: list[int] = [1]
        channel = 1
        for number, line in enumerate(raw.decode("utf-8", errors="replace").splitlines(), start=1):
            if (switched := _CHANNEL.match(line)) is not None:
                channel = int(switched[1])
                if channel not in self.channels:
                    self.channels.append(channel)
            elif (found := _LINE.match(line)) is not None:
                index = re.sub(r"\s", "", found["index"] or "").upper()
                of = channel if found["name"].upper().startswith("MC_") else 0
                self._values[of, found["name"].upper(), index] = found["value"].strip('"'), f"{name}:{number}"

    def find(self, name: str, *indices: str | int) -> tuple[str, str] | None:
        """The value under the first index that has one ("" without indices), with file and line; None without one."""
        of = self.channel if name.startswith("MC_") else 0
        for index in indices or ("",):
            if (found := self._values.get((of, name, str(index).upper()))) is not None:
                return found
        return None

    def find_number(self, name: str, *indices: str | int) -> float | None:
        """A number; TRUE and FALSE are 1 and 0."""
        found = self.find(name, *indices)
        if found is None:
            return None
        text, where = found
        try:
            value = {"TRUE": 1.0, "FALSE": 0.0}.get(text.upper())
            value = float(text) if value is None else value
        except ValueError:
            raise refuse_value(where, f"${name} = {text[:60]!r}: expected a number") from None
        if not np.isfinite(value):
            raise refuse_value(where, f"${name} = {text[:60]!r}: expected a number")
        return value

    def find_vector(self, name: str) -> Array:
        """Three numbers; what is not set is 0, as on the control."""
        return np.array([self.find_number(name, axis) or 0.0 for axis in range(3)])

    def list_carriers(self) -> list[int]:
        """Numbers of the tool carriers whose kind is known."""
        kind = f"TC_CARR{_KIND_OF_CARRIER}"
        return sorted(int(index) for _of, name, index in self._values if name == kind and index.isdigit())


class Pair(Struct, frozen=True):
    """The rotary axes: what turns ("T", "P", "M"), vectors, places in the file, and the slot of TRAORI or 0."""

    kind: str
    offsets: dict[str, Array]
    axes: tuple[Array, Array]
    source: str
    slot: int


class Axis(Struct, frozen=True):
    """An axis of the channel: its letter, and the indices under which its data of the axis stand."""

    letter: str
    indices: tuple[str, ...]


def convert_sinumerik(raw: bytes, name: str) -> ImportedMachine:
    """The machine file of machine data; ``name`` is for messages.

    Raises
    ------
    InputError
        VP507 where something is missing or cannot be read, VP508 where the kinematics are not executed.
    """
    data = MachineData(raw, name)
    pair = _find_pair(data)
    axes = _find_axes(data, pair)
    _check_inches(data)
    notes = list(_find_notes(data, pair))
    joints = [
        _write_joint(data, axis, f'slides = {np.eye(3)[k].tolist()}\npositive = "tool"', rotary=False)
        for k, axis in enumerate(axes[:3])
    ]
    first, second = axes[3:]
    places = _place_pair(pair)
    sides = {"T": ("tool", "tool"), "P": ("part", "part"), "M": ("tool", "part")}[pair.kind]
    for axis, direction, through, side in zip(axes[3:], pair.axes, places, sides, strict=True):
        text = f'turns = {show_list(direction)}\nthrough = {show_list(through)}\npositive = "{side}"'
        joints.append(_write_joint(data, axis, text, rotary=True))
    on_tool = {"T": 5, "P": 3, "M": 4}[pair.kind]
    letters = [*"xyz", first.letter, second.letter]
    if without := list_jerkless(joints):
        notes.append(f"{without}: no $MA_MAX_AX_JERK; the setpoints jerk as far as the accelerations allow")
    cycle = _find_cycle(data)
    if cycle is None:
        notes.append(
            "$MN_SYSCLOCK_CYCLE_TIME and $MN_IPO_SYSCLOCK_TIME_RATIO are not both there: cycle_s is taken as 0.001"
        )
    text = "\n".join(
        [
            f"# From {escape_unprinted(name)}, machine data of a SINUMERIK: {pair.source}. Keys: "
            "docs/machine-file.md, schema 2.",
            "schema = 2",
            f"name = {quote(f'{name}: {pair.source}')}",
            "",
            *write_chain(letters[:on_tool], letters[on_tool:]),
            *joints,
            *write_end(cycle or 0.001, name),
        ]
    )
    return ImportedMachine(text, tuple(make_finding("VP509", f"{name}: {note}") for note in notes))


def _refuse_kinematics(where: str, text: str) -> InputError:
    return refuse_value(where, text, "VP508")


# --- which kinematics -----------------------------------------------------------------------------------------


def _find_pair(data: MachineData) -> Pair:
    """The first five-axis transformation of the first channel that has one, else the only tool carrier."""
    for channel in data.channels:
        data.channel = channel
        for slot in range(1, _SLOTS + 1):
            kind = data.find_number(f"MC_TRAFO_TYPE_{slot}")
            if kind is None:
                continue
            where = (data.find(f"MC_TRAFO_TYPE_{slot}") or ("", data.name))[1]
            if kind in _GENERIC:
                return _read_transformation(data, _GENERIC[int(kind)], slot)
            if kind == _BY_CARRIER:
                number = data.find_number("MC_TRAFO5_TCARR_NO_1")
                if number is None:
                    raise refuse_value(
                        where, "$MC_TRAFO5_TCARR_NO_1 is missing: type 72 takes the vectors of that tool carrier"
                    )
                return _read_carrier(data, int(number), slot)
            if kind in _BY_LETTERS:
                raise _refuse_kinematics(
                    where,
                    f"$MC_TRAFO_TYPE_{slot} = {kind:g} names its axes by letters, without their directions; imported "
                    "are the generic types 24, 40 and 56, and 72 with a tool carrier",
                )
    data.channel = 1
    carriers = data.list_carriers()
    if len(carriers) == 1:
        return _read_carrier(data, carriers[0], 0)
    if carriers:
        raise _refuse_kinematics(
            data.name,
            f"no transformation of five axes, and the tool carriers {', '.join(map(str, carriers))}; keep the lines "
            "$TC_CARR of one of them",
        )
    raise _refuse_kinematics(
        data.name,
        "neither a transformation of five axes ($MC_TRAFO_TYPE_n = 24, 40, 56 or 72) nor a tool carrier ($TC_CARR23)",
    )


def _read_transformation(data: MachineData, kind: str, slot: int) -> Pair:
    offsets = {vector: data.find_vector(f"MC_TRAFO5_{key}_1") for vector, key in _OFFSETS[kind].items()}
    axes = tuple(
        _require_direction(data, f"MC_TRAFO5_AXIS{k}_1", data.find_vector(f"MC_TRAFO5_AXIS{k}_1")) for k in (1, 2)
    )
    for k in (0, 1):
        if data.find_number("MC_TRAFO5_ROT_AX_OFFSET_1", k):
            raise _refuse_kinematics(
                data.name,
                f"$MC_TRAFO5_ROT_AX_OFFSET_1[{k}] is not 0: rotary axes that are not at 0 where the vectors hold "
                "are not imported",
            )
        if data.find_number("MC_TRAFO5_ROT_SIGN_IS_PLUS_1", k) == 0.0:
            raise _refuse_kinematics(
                data.name,
                f"$MC_TRAFO5_ROT_SIGN_IS_PLUS_1[{k}] = FALSE is not imported: reverse "
                f"$MC_TRAFO5_AXIS{k + 1}_1 in its place",
            )
    upright = data.find_vector("MC_TRAFO5_BASE_ORIENT_1")
    if (
        np.abs(upright).max() > _NONE_MM
        and np.linalg.norm(np.cross(upright, [0.0, 0.0, 1.0])) + max(-upright[2], 0.0) > _NONE_MM
    ):
        raise _refuse_kinematics(
            data.name,
            f"$MC_TRAFO5_BASE_ORIENT_1 = {show_list(upright)}: a tool that is not along +z with its axes "
            "at 0 is not imported",
        )
    return Pair(kind, offsets, (axes[0], axes[1]), f"TRAORI, transformation {slot}", slot)


def _read_carrier(data: MachineData, number: int, slot: int) -> Pair:
    def read(first: int) -> Array:
        return np.array([data.find_number(f"TC_CARR{first + k}", number) or 0.0 for k in range(3)])

    found = data.find(f"TC_CARR{_KIND_OF_CARRIER}", number)
    if found is None:
        raise refuse_value(
            data.name,
            f"$TC_CARR{_KIND_OF_CARRIER}[{number}] is missing: it says whether tool (T), part (P) or both (M) turn",
        )
    kind = found[0].upper()
    if kind not in _OFFSETS:
        raise _refuse_kinematics(found[1], f"$TC_CARR{_KIND_OF_CARRIER}[{number}] = {found[0]!r}: expected T, P or M")
    for parameter in (24, 25):
        if data.find_number(f"TC_CARR{parameter}", number):
            raise _refuse_kinematics(
                data.name,
                f"$TC_CARR{parameter}[{number}] is not 0: rotary axes that are not at 0 where the vectors hold are "
                "not imported",
            )
    axes = tuple(
        _require_direction(data, f"TC_CARR{_CARRIER[key]}[{number}] and the next two", read(_CARRIER[key]))
        for key in ("V1", "V2")
    )
    offsets = {key: read(_CARRIER[key]) for key in _OFFSETS[kind]}
    return Pair(kind, offsets, (axes[0], axes[1]), f"tool carrier {number}", slot)


def _require_direction(data: MachineData, name: str, vector: Array) -> Array:
    if np.abs(vector).max() < _NONE_MM:
        raise refuse_value(data.name, f"${name}: no direction; a machine file has two rotary joints")
    return vector


def _place_pair(pair: Pair) -> tuple[Array, Array]:
    """Points of axes 1 and 2, with the tool adapter at machine zero."""
    two, three = pair.offsets["I2"], pair.offsets["I3"]
    if pair.kind == "T":
        return three + two, three
    return two, three + (two if pair.kind == "P" else 0.0)


def _find_notes(data: MachineData, pair: Pair) -> Iterator[str]:
    """What is not taken over."""
    yield (
        f'positive = "{"part" if pair.kind == "P" else "tool"}" of the rotary joints is the side that they turn, about '
        "V1 and V2"
        if pair.kind != "M"
        else 'positive is "tool" of axis 1 and "part" of axis 2: the sides that they turn, about V1 and V2'
    )
    sums = (
        [("I1", "I2", "I3")]
        if pair.kind == "T"
        else [("I2", "I3", "I4")]
        if pair.kind == "P"
        else [("I1", "I2"), ("I3", "I4")]
    )
    for names in sums:
        left = sum((pair.offsets[name] for name in names), np.zeros(3))
        if np.abs(left).max() > _NONE_MM:
            yield (
                f"{' + '.join(names)} = {show_list(left)}: the chain does not close, so that with the transformation "
                "on the control counts from another zero; work offsets here count from machine zero"
            )
    if pair.source.startswith("tool carrier"):
        number = int(pair.source.rsplit(" ", 1)[1])
        if any(data.find_number(f"TC_CARR{parameter}", number) for parameter in _FINE):
            yield "$TC_CARR41 to 60: fine offsets are left out"
    if data.find_number("MC_TRAFO5_TOOL_VECTOR_1") not in (None, 2.0):
        yield "$MC_TRAFO5_TOOL_VECTOR_1: the tool is taken along z"
    yield "[home] and [table] are left out; linear axes are taken as along x, y, z, and as moving the tool"


# --- axes -----------------------------------------------------------------------------------------------------


def _find_axes(data: MachineData, pair: Pair) -> list[Axis]:
    """X, Y, Z, and both rotary axes, first that of V1."""
    if pair.slot:
        numbers = [data.find_number(f"MC_TRAFO_AXES_IN_{pair.slot}", k) for k in range(5)]
        if None in numbers or 0.0 in numbers:
            raise refuse_value(
                data.name, f"$MC_TRAFO_AXES_IN_{pair.slot}[0] to [4]: expected the numbers of five axes of the channel"
            )
        channel = [int(number or 0) - 1 for number in numbers]
    else:
        carrier = pair.source.rsplit(" ", 1)[1]
        names = ["X", "Y", "Z"]
        for parameter in _NAMED_IN_CARRIER:
            found = data.find(f"TC_CARR{parameter}", carrier)
            if found is None or not found[0]:
                raise refuse_value(data.name, f"$TC_CARR{parameter}[{carrier}] is missing: the name of a rotary axis")
            names.append(found[0].upper())
        tab = {(data.find("MC_AXCONF_CHANAX_NAME_TAB", k) or ("", ""))[0].upper(): k for k in range(_SLOTS)}
        if missing := [name for name in names if name not in tab]:
            raise refuse_value(data.name, f"$MC_AXCONF_CHANAX_NAME_TAB names no axis {', '.join(missing)}")
        channel = [tab[name] for name in names]
    return [_find_axis(data, k, "XYZ"[place : place + 1] or "ABC") for place, k in enumerate(channel)]


def _find_axis(data: MachineData, channel: int, letters: str) -> Axis:
    """The axis of the channel with a number from 0 on, whose name is one of some letters."""
    found = data.find("MC_AXCONF_CHANAX_NAME_TAB", channel)
    if found is None:
        raise refuse_value(data.name, f"$MC_AXCONF_CHANAX_NAME_TAB[{channel}] is missing: the name of an axis")
    letter, where = found
    if len(letter) != 1 or letter.upper() not in letters:
        raise _refuse_kinematics(
            where,
            f"$MC_AXCONF_CHANAX_NAME_TAB[{channel}] = {letter!r}: expected {' or '.join(letters)}; axes of other names "
            "are not imported",
        )
    machine = data.find_number("MC_AXCONF_MACHAX_USED", channel)
    if not machine:
        raise refuse_value(where, f"$MC_AXCONF_MACHAX_USED[{channel}] names no machine axis for {letter}")
    number = f"AX{int(machine)}"
    own = data.find("MN_AXCONF_MACHAX_NAME_TAB", int(machine) - 1)
    names = [number, *([own[0]] if own else [])]
    return Axis(letter.lower(), tuple(one for name in names for one in (name, f"0,{name}")))


def _write_joint(data: MachineData, axis: Axis, geometry: str, *, rotary: bool) -> str:
    """[joints.LETTER]: m and turns of the control as mm and degrees."""

    def find(name: str) -> float | None:
        return data.find_number(f"MA_{name}", *axis.indices)

    letter = axis.letter.upper()
    if (find("IS_ROT_AX") == 1.0) != rotary:
        raise refuse_value(
            data.name, f"$MA_IS_ROT_AX of {letter} is not {'TRUE' if rotary else 'FALSE'}, as the kinematics have it"
        )
    low, high = find("POS_LIMIT_MINUS"), find("POS_LIMIT_PLUS")
    unlimited = low is None or high is None or low <= -_NO_LIMIT or high >= _NO_LIMIT
    if rotary and not find("ROT_IS_MODULO") and unlimited:
        raise refuse_value(
            data.name,
            f"$MA_POS_LIMIT_MINUS and _PLUS of {letter} do not bound it, and $MA_ROT_IS_MODULO is not TRUE: "
            "expected one",
        )
    endless = rotary and (bool(find("ROT_IS_MODULO")) or unlimited)
    if not endless and (low is None or high is None or unlimited or low >= high):
        raise refuse_value(
            data.name,
            f"$MA_POS_LIMIT_MINUS and _PLUS of {letter} do not bound its travel: expected both, the smaller first",
        )
    scale = _DEG_PER_TURN if rotary else _MM_PER_M
    keys = {
        "velocity": ("MAX_AX_VELO", (_DEG_PER_TURN if rotary else 1.0) / _S_PER_MIN),  # of turns or mm per minute
        "acceleration": ("MAX_AX_ACCEL", scale),
        "jerk": ("MAX_AX_JERK", scale),
    }
    speeds = convert_speeds(
        data.name, letter, {kind: (f"$MA_{key}", find(key), factor) for kind, (key, factor) in keys.items()}
    )
    travel = "" if endless else f"travel_{'deg' if rotary else 'mm'} = {show_list([low or 0.0, high or 0.0])}"
    return write_joint(axis.letter, geometry, travel, speeds)


def _check_inches(data: MachineData) -> None:
    if data.find_number("MN_SCALING_SYSTEM_IS_METRIC") == 0.0:
        raise _refuse_kinematics(data.name, "$MN_SCALING_SYSTEM_IS_METRIC = FALSE: data in inches are not imported")


def _find_cycle(data: MachineData) -> float | None:
    """The interpolation cycle, s."""
    clock, ratio = data.find_number("MN_SYSCLOCK_CYCLE_TIME"), data.find_number("MN_IPO_SYSCLOCK_TIME_RATIO")
    return None if clock is None or ratio is None else clock * ratio
