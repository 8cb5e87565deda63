"""Checks of single options: each returns the value as the program uses it, or says what would be right."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from mmap import mmap
from typing import Any, Final, Literal, get_args

from msgspec import Struct

from verne_post.base.suggestions import suggest
from verne_post.base.type_words import LARGEST
from verne_post.model.findings import UsageError
from verne_post.model.part_setup import (
    COORDINATES,
    GRID_MM,
    MAX_PLACE,
    MAX_TOOL,
    SYSTEM_NAMES,
    SYSTEM_NUMBERS,
    TOOL_PARTS,
    UNITS,
    Box,
    Cylinder,
    FixtureMesh,
    NominalPart,
    OwnStock,
    Tool,
    ToolShape,
    Wanted,
    WorkOffset,
    describe_mistake,
    name_system,
)

#: The largest number of a parameter; the one that holds the active work system.
MAX_PARAMETER: Final = 5601
ACTIVE_SYSTEM: Final = 5220
#: A G or M code without leading zeros, or the name of a subprogram of a Siemens control.
CODE: Final = re.compile(
    r"G(?:0|[1-9][0-9]{0,8})(?:\.[1-9])?|M(?:0|[1-9][0-9]{0,8})|L[0-9]{1,7}|[A-Z_]{2}[A-Z0-9_]{0,29}"
)
#: What a user-defined code or name may mean.
Meaning = Literal["tcp on", "tcp off", "ignore", "event", "M3", "M4", "M5", "M6"]


def work_offsets(**given: "tuple[float, ...]") -> dict[int, WorkOffset]:
    """Work offsets for :class:`Options`: ``work_offsets(G54=(x, y, z), G55=(x, y, z, c))``, mm and degrees.

    Raises
    ------
    UsageError
    """
    try:
        return check_work_offsets(given)
    except ValueError as error:
        raise UsageError("wcs", str(error)) from None


class Checked(Struct, frozen=True):
    """Metadata of an option whose type does not say everything: ``check`` returns its value, or raises ValueError."""

    check: Callable[[Any], Any]


#: Names of controls -> the dialect that they speak.
_DIALECTS_OF: Final = {
    "fanuc": ("haas",),
    "siemens": ("sinumerik", "840d", "828d"),
    "heidenhain": ("klartext", "tnc", "itnc"),
    "rs274": ("linuxcnc", "emc", "emc2", "ngc", "rs274ngc"),
    "aptcl": ("apt", "cl", "cls"),
}


def suggest_one(value: str, names: Sequence[str]) -> str:
    """Which of some names is meant, as "; did you mean NAME?"; empty where none is near."""
    meant = next((one for one, others in _DIALECTS_OF.items() if one in names and value.lower() in others), "")
    return f"; did you mean {meant}?" if meant else suggest(value, names)


def accept_one(names: Callable[[], tuple[str, ...]]) -> Checked:
    """Takes one of some names."""

    def check(value: object) -> object:
        if not isinstance(value, str) or value not in names():
            raise ValueError(f"expected one of {', '.join(names())}{suggest_one(str(value), names())}")
        return value

    return Checked(check)


def convert_from_numpy(value: Any) -> Any:
    """The number that a number of numpy is, of any type; other values as they are."""
    return value.item() if type(value).__module__ == "numpy" and getattr(value, "ndim", 1) == 0 else value


def check_numbers(value: object, counts: tuple[int, ...], what: str, bound: float) -> tuple[float, ...]:
    """A sequence of so many finite numbers within a bound."""
    found = [convert_from_numpy(one) for one in _list_items(value, what)]
    if len(found) not in counts:
        raise ValueError(f"expected {what}, got {len(found)} numbers")
    for one in found:
        if isinstance(one, bool) or not isinstance(one, int | float) or not abs(one) <= LARGEST:
            raise ValueError(f"expected {what}; {one!r} is not a finite number")
        if abs(one) > bound:
            raise ValueError(f"{one:g} is beyond {bound:g}")
    return tuple(float(one) for one in found)


def _list_items(value: object, what: str) -> list[Any]:
    """Items of a tuple, a list or an array."""
    listed = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(listed, tuple | list):
        raise ValueError(f"expected {what}, got {value!r}")
    return list(listed)


def _read_tool_number(key: object) -> int:
    number = convert_from_numpy(key)
    if not isinstance(number, int) or isinstance(number, bool) or number < 0:
        raise ValueError(f"{key!r} is neither the number nor the name of a tool")
    return number


def check_mapping(value: object, what: str) -> Mapping[Any, Any]:
    """A mapping."""
    if not isinstance(value, Mapping):
        raise ValueError(f"expected {what}, got {value!r}")
    return value


def find_system(value: object) -> int:
    """Number of a work system from its name (G54 ... G59.3, G54.1P1 ... P48), or from the number itself.

    Raises
    ------
    ValueError
    """
    value = convert_from_numpy(value)
    if isinstance(value, str) and value.strip().upper() in SYSTEM_NUMBERS:
        return SYSTEM_NUMBERS[value.strip().upper()]
    if isinstance(value, int) and not isinstance(value, bool) and value in SYSTEM_NAMES:
        return value
    names = list(SYSTEM_NUMBERS)
    if isinstance(value, str) and (siemens := re.fullmatch(r"G5(0[5-9]|[1-4]\d|5[0-7])", value.strip().upper())):
        raise ValueError(f"{value} of Siemens is {names[int(siemens[1]) - 1]} here; write that")
    raise ValueError(
        f"{value!r} is not a work system; expected one of {', '.join(names[:9])}, or {names[9]} to {names[-1]}"
    )


def check_work_offsets(value: object, source: str = "") -> dict[int, WorkOffset]:
    """Work offsets by number; given by name or number, as WorkOffset or as x, y, z and maybe c.

    ``source`` says who gives those that do not name it.
    """
    found: dict[int, WorkOffset] = {}
    for key, offset in check_mapping(value, "a mapping such as {'G54': (x, y, z)}").items():
        number = find_system(key)
        if number in found:
            raise ValueError(f"{name_system(number)} is given twice")
        what = f"x, y, z and maybe c for {name_system(number)}"
        given = [*_list_items(offset.origin_mm, what), offset.turn_deg] if isinstance(offset, WorkOffset) else offset
        x, y, z, *turn = check_numbers(given, (4,) if isinstance(offset, WorkOffset) else (3, 4), what, MAX_PLACE)
        named = offset.source if isinstance(offset, WorkOffset) else ""
        found[number] = WorkOffset((x, y, z), turn[0] if turn else 0.0, named or source)
    return found


def check_unmeasured(value: object) -> dict[int, str]:
    """Names of files by the number of a work system, which is given by name or number."""
    what = "a mapping such as {'G54': 'part.nc.toml'}"
    found = {find_system(key): file for key, file in check_mapping(value, what).items()}
    if not all(isinstance(file, str) for file in found.values()):
        raise ValueError(f"expected {what}")
    return found


def check_replaced_tools(value: object) -> dict[int, str]:
    """Names of tables by the number of a tool."""
    what = "a mapping such as {2: 'verne-post.toml: tools'}"
    found = check_mapping(value, what)
    if not all(type(number) is int and isinstance(place, str) for number, place in found.items()):
        raise ValueError(f"expected {what}")
    return dict(found)


def _make_tool(number: int, given: object) -> Tool:
    """A tool as it is, or one of a length (mm), or of a length and a diameter."""
    if isinstance(given, Tool):
        return given
    what = f"Tool({number}, ...), a length in mm, or a length and a diameter"
    listed = hasattr(convert_from_numpy(given), "__len__")
    length, diameter, *_none = (*check_numbers(given if listed else (given,), (1, 2), what, MAX_TOOL), 0.0)
    if length < 0:
        raise ValueError(f"the length {length:g} is negative; it counts from the gauge line to the tip")
    return Tool(number, number, (0.0, 0.0, length, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), diameter)


def check_tools(value: object) -> dict[int, Tool] | None:
    if value is None:
        return None
    found: dict[int, Tool] = {}
    for name, given in check_mapping(value, "a mapping from number or name of a tool to Tool, or a length").items():
        key = _read_tool_number(name)
        try:
            tool = _make_tool(key, given)
        except ValueError as error:
            raise ValueError(f"tool {key}: {error}") from None
        if isinstance(tool.number, bool) or convert_from_numpy(tool.number) != key:
            raise ValueError(f"tool {key}: expected Tool({key}, ...), got {tool!r}")
        pocket = convert_from_numpy(tool.pocket)
        if not isinstance(pocket, int) or isinstance(pocket, bool):
            raise ValueError(f"tool {key}: pocket {tool.pocket!r} is not a whole number")
        (diameter,) = check_numbers((tool.diameter,), (1,), f"a diameter of tool {key}", MAX_TOOL)
        if diameter < 0:
            raise ValueError(f"tool {key}: diameter {diameter:g} is negative")
        corner = tool.corner_radius
        if corner is not None:
            (corner,) = check_numbers((corner,), (1,), f"a corner_radius of tool {key}", MAX_TOOL)
        # half a diameter that is still to be measured is not known
        if diameter and corner and (mistake := describe_mistake(Cylinder("cutter", diameter, corner_radius=corner))):
            raise ValueError(f"tool {key}: {mistake}")
        x, y, z, a, b, c, u, v, w = check_numbers(tool.offset, (9,), f"nine offsets of tool {key}", MAX_PLACE)
        offset = (x, y, z, a, b, c, u, v, w)
        found[key] = replace(tool, number=key, pocket=pocket, offset=offset, diameter=diameter, corner_radius=corner)
    return found


def check_box(box: object) -> Box:
    if not isinstance(box, Box):
        raise ValueError(f"expected a Box or a FixtureMesh, got {box!r}")
    if not isinstance(box.name, str):
        raise ValueError(f"{box.name!r} is not the name of a box")
    low, high = (
        check_numbers(corner, (3,), f"three coordinates of a corner of {box.name}", MAX_PLACE)
        for corner in (box.low, box.high)
    )
    for letter, first, second in zip("xyz", low, high, strict=True):
        if first >= second:
            raise ValueError(
                f"{box.name}: {letter} of the first corner, {first:g}, must be below that of the second, {second:g}"
            )
    return Box(box.name, (low[0], low[1], low[2]), (high[0], high[1], high[2]), *_check_place(box))


def _check_place(body: Box | FixtureMesh) -> tuple[int | None, float]:
    """Work system and distance of a body."""
    system = None if body.system is None else find_system(body.system)
    (distance,) = check_numbers((body.distance,), (1,), "a distance", MAX_PLACE)
    if distance < 0:
        raise ValueError(f"{body.name}: the distance {distance:g} is negative")
    return system, distance


def _check_fixture(body: object) -> Box | FixtureMesh:
    if not isinstance(body, FixtureMesh):
        return check_box(body)
    if not isinstance(body.name, str) or not isinstance(body.raw, bytes) or body.unit not in UNITS:
        raise ValueError(f"{body.name}: expected a name, the bytes of an STL, and a unit of {', '.join(UNITS)}")
    return FixtureMesh(body.name, body.raw, *_check_place(body), body.unit, body.file)


def check_stock(value: object) -> Box | FixtureMesh | OwnStock | None:
    """The stock: its file, or that of the program, is read when a program is checked."""
    if value is None or isinstance(value, OwnStock):
        return value
    if not isinstance(value, Box | FixtureMesh):
        raise ValueError(f"expected a Box, a FixtureMesh, or OwnStock() for the stock of the program, got {value!r}")
    return _check_fixture(value)


def check_fixtures(value: object) -> tuple[Box | FixtureMesh, ...]:
    boxes = tuple(_check_fixture(one) for one in _list_items(value, "a tuple or list of boxes"))
    names = [box.name for box in boxes]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{name} is given twice; every box needs its own name")
    return boxes


def check_part(value: object) -> NominalPart | None:
    """The nominal part: its file is read when a program is compared with it."""
    if value is None:
        return None
    if not isinstance(value, NominalPart):
        raise ValueError("expected a NominalPart(name, raw, system, unit, wanted)")
    if not isinstance(value.raw, bytes) or value.unit not in UNITS or value.system not in (None, *SYSTEM_NAMES):
        raise ValueError(
            f"{value.name}: expected the bytes of an STL, the number of a work system, and a unit of {', '.join(UNITS)}"
        )
    wanted = value.wanted
    if not isinstance(wanted, Wanted):
        raise ValueError(f"{wanted!r}: expected Wanted(gouge, excess, grid, search)")
    sizes = check_numbers(
        (wanted.gouge, wanted.excess, GRID_MM if wanted.grid is None else wanted.grid, wanted.search),
        (4,),
        f"depths of {value.name}",
        MAX_TOOL,
    )
    if min(sizes) <= 0 or wanted.search < max(wanted.gouge, wanted.excess):
        raise ValueError(
            f"{value.name}: gouge, excess, grid and search must be above 0, and search not below gouge and excess"
        )
    return value


def check_shapes(value: object) -> dict[int, ToolShape]:
    found: dict[int, ToolShape] = {}
    for name, shape in check_mapping(value, "a mapping from number or name of a tool to cylinders").items():
        key = _read_tool_number(name)
        parts = tuple(shape) if isinstance(shape, tuple | list) else ()
        if not parts or not all(isinstance(one, Cylinder) for one in parts):
            raise ValueError(f"tool {key}: expected a sequence of Cylinder(part, diameter, length), got {shape!r}")
        for one in parts:
            if not isinstance(one.part, str) or one.part not in TOOL_PARTS:
                names = ", ".join(TOOL_PARTS)
                raise ValueError(f"tool {key}: {one.part!r} is not a part of a tool; expected one of {names}")
        for at, one in enumerate(parts):
            sizes = (one.diameter,) if one.length is None else (one.diameter, one.length)
            if min(check_numbers(sizes, (1, 2), f"sizes of the {one.part} of tool {key}", MAX_TOOL)) <= 0:
                raise ValueError(f"tool {key}: sizes of the {one.part} must be above 0")
            shape = (one.corner_radius, one.taper, one.point_angle, one.tip_diameter, one.neck_diameter)
            check_numbers(shape, (5,), f"the shape of the {one.part} of tool {key}", MAX_TOOL)
            for point in _list_items(one.profile, "points of a profile"):
                check_numbers(point, (2,), f"radius and height of the {one.part} of tool {key}", MAX_TOOL)
            if mistake := describe_mistake(one):
                raise ValueError(f"tool {key}, {one.part}: {mistake}")
            if one.length is None and at < len(parts) - 1:
                raise ValueError(
                    f"tool {key}: {one.part} needs a length: only the last part may reach up to the gauge line "
                    "without one"
                )
        places = [TOOL_PARTS.index(one.part) for one in parts]
        if places != sorted(places) or any(places.count(place) > 1 for place in (0, 1)):
            raise ValueError(
                f"tool {key}: expected one cutter, one shank, then parts of the holder, from the tip upwards"
            )
        found[key] = parts
    return found


def check_place(value: object) -> str | tuple[float, ...] | None:
    if value is None or (isinstance(value, str) and value == "home"):
        return None if value is None else "home"
    given = _list_items(value, "home, or joint values")
    return check_numbers(given, (max(len(given), 1),), "home, or joint values", math.inf)


def check_override(value: object) -> float:
    (share,) = check_numbers((value,), (1,), "a share from 0.05 to 1", math.inf)
    if not 0.05 <= share <= 1.0:
        hint = f"; {share:g} % is {share / 100:g}" if 5 <= share <= 100 else ""
        raise ValueError(f"expected a share from 0.05 to 1{hint}")
    return share


def check_ranges(free: object, ranges: object) -> dict[str, tuple[float, float]]:
    """Ranges of ``fit`` by the letters of a work offset, mm and degrees; ``free`` has those that may change, None all.

    Raises
    ------
    UsageError
    """
    free = COORDINATES if free is None else free
    if not isinstance(free, str) or not free or len(set(free)) != len(free) or not set(free) <= set(COORDINATES):
        raise UsageError("free", f"{free!r}: expected some of the letters x, y, z, c, each once")
    found: dict[str, tuple[float, float]] = {}
    try:
        for letter, ends in check_mapping(ranges, "a mapping from letter to (low, high)").items():
            if letter not in tuple(free):
                raise ValueError(f"{letter!r} is none of the free coordinates {', '.join(free)}")
            low, high = check_numbers(ends, (2,), f"low and high of {letter}", MAX_PLACE)
            if low > high:
                raise ValueError(f"{letter}: {low:g} is above {high:g}; the lower one comes first")
            found[letter] = (low, high)
    except ValueError as error:
        raise UsageError("range", str(error)) from None
    return found


def check_texts(value: object) -> dict[str, bytes]:
    found = dict(check_mapping(value, "a mapping from name to bytes"))
    for name, text in found.items():
        if not isinstance(name, str) or name != name.lower() or not isinstance(text, bytes | mmap):
            raise ValueError(f"{name!r}: expected a lower-case name without extension, and the bytes of the file")
    return found


def check_file_names(value: object) -> dict[str, str]:
    """Refuse what is no mapping from name to file name."""
    found = dict(check_mapping(value, "a mapping from name to file name"))
    for name, file in found.items():
        if not isinstance(name, str) or name != name.lower() or not isinstance(file, str):
            raise ValueError(f"{name!r}: expected a lower-case name without extension, and the name of the file")
    return found


def check_parameter(index: int, value: float) -> None:
    """Refuse a numbered parameter that no program can find.

    Raises
    ------
    ValueError
    """
    if not 1 <= index <= MAX_PARAMETER:
        raise ValueError(f"parameters have the numbers 1 to {MAX_PARAMETER}, not {index}")
    if 5400 <= index <= 5428 or 5021 <= index <= 5029 or 5081 <= index <= 5089:
        raise ValueError(f"parameter {index} shows a state and cannot be given")
    if index == ACTIVE_SYSTEM and value not in range(1, 10):
        raise ValueError(f"parameter {index} = {value:g}: the active work system has a number from 1 to 9")


def check_parameters(value: object) -> dict[int, float]:
    found: dict[int, float] = {}
    for given, number in check_mapping(value, "a mapping from number to value").items():
        index = convert_from_numpy(given)
        if not isinstance(index, int) or isinstance(index, bool):
            raise ValueError(f"{given!r} is not the number of a parameter")
        (found[index],) = check_numbers((number,), (1,), f"a value of parameter {index}", math.inf)
        check_parameter(index, found[index])
    return found


def check_remap(value: object) -> dict[str, str]:
    meanings = get_args(Meaning)
    found = dict(check_mapping(value, "a mapping from code to meaning"))
    for code, meaning in found.items():
        if not isinstance(code, str) or CODE.fullmatch(code) is None:
            raise ValueError(
                f"{code}: expected a G or M code as it is written, without leading zeros (M428, G68.3), "
                "or in capitals the name of a subprogram of a Siemens control"
            )
        if not isinstance(meaning, str) or meaning not in meanings:
            raise ValueError(f"{code}: {meaning!r}: expected one of {', '.join(meanings)}")
    return found
