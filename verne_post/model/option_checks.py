"""Checks of the values of single options; each returns the value as the program uses it, or says what would be right."""

import difflib
import math
from collections.abc import Callable, Mapping
from typing import Any, Literal, get_args

from pydantic import AfterValidator

from verne_post.model.findings import UsageError
from verne_post.model.part_setup import (
    MAX_PLACE,
    MAX_TOOL,
    SYSTEM_NAMES,
    SYSTEM_NUMBERS,
    TOOL_PARTS,
    Box,
    Cylinder,
    Tool,
    ToolShape,
    WorkOffset,
)

#: What a user-defined code may mean.
Meaning = Literal["tcp on", "tcp off", "ignore", "event"]


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


def one_of(names: Callable[[], tuple[str, ...]]) -> AfterValidator:
    def check(value: str) -> str:
        if value not in names():
            raise ValueError(_expected(value, names()))
        return value

    return AfterValidator(check)


def _expected(value: str, names: tuple[str, ...]) -> str:
    near = difflib.get_close_matches(value, names, n=1)
    return f"expected one of {', '.join(names)}" + (f"; did you mean {near[0]}?" if near else "")


def _numbers(value: object, counts: tuple[int, ...], what: str, bound: float) -> tuple[float, ...]:
    """A sequence of so many finite numbers within a bound."""
    if isinstance(value, str | bytes | Mapping) or not hasattr(value, "__iter__"):
        raise ValueError(f"expected {what}, got {value!r}")
    found = list(value)
    if len(found) not in counts:
        raise ValueError(f"expected {what}, got {len(found)} numbers")
    for one in found:
        if isinstance(one, bool) or not isinstance(one, int | float) or not math.isfinite(one):
            raise ValueError(f"expected {what}; {one!r} is not a finite number")
        if abs(one) > bound:
            raise ValueError(f"{one:g} is beyond {bound:g}")
    return tuple(float(one) for one in found)


def _mapping(value: object, what: str) -> Mapping[Any, Any]:
    if not isinstance(value, Mapping):
        raise ValueError(f"expected {what}, got {value!r}")
    return value


def system_number(value: object) -> int:
    """Number of a work system from its name (G54 ... G59.3, G54.1P1 ... P48), or from the number itself.

    Raises
    ------
    ValueError
    """
    if isinstance(value, str) and value.strip().upper() in SYSTEM_NUMBERS:
        return SYSTEM_NUMBERS[value.strip().upper()]
    if isinstance(value, int) and not isinstance(value, bool) and value in SYSTEM_NAMES:
        return value
    names = list(SYSTEM_NUMBERS)
    raise ValueError(
        f"{value!r} is not a work system; expected one of {', '.join(names[:9])}, or {names[9]} to {names[-1]}"
    )


def check_work_offsets(value: object) -> dict[int, WorkOffset]:
    """Work offsets by number; given by name or number, as WorkOffset or as x, y, z and maybe c."""
    found: dict[int, WorkOffset] = {}
    for key, offset in _mapping(value, "a mapping such as {'G54': (x, y, z)}").items():
        number = system_number(key)
        if number in found:
            raise ValueError(f"{SYSTEM_NAMES[number]} is given twice")
        given = (*offset.origin_mm, offset.turn_deg) if isinstance(offset, WorkOffset) else offset
        x, y, z, *turn = _numbers(given, (3, 4), f"x, y, z and maybe c for {SYSTEM_NAMES[number]}", MAX_PLACE)
        found[number] = WorkOffset((x, y, z), turn[0] if turn else 0.0)
    return found


def check_tools(value: object) -> dict[int, Tool] | None:
    if value is None:
        return None
    found: dict[int, Tool] = {}
    for key, tool in _mapping(value, "a mapping from tool number to Tool").items():
        if isinstance(key, bool) or not isinstance(key, int) or key < 0:
            raise ValueError(f"{key!r} is not the number of a tool")
        if not isinstance(tool, Tool) or tool.number != key:
            raise ValueError(f"tool {key}: expected Tool({key}, ...), got {tool!r}")
        _numbers(tool.offset, (9,), f"nine offsets of tool {key}", MAX_PLACE)
        if not _numbers((tool.diameter,), (1,), f"a diameter of tool {key}", MAX_TOOL)[0] >= 0:
            raise ValueError(f"tool {key}: diameter {tool.diameter:g} is negative")
        found[key] = tool
    return found


def check_box(box: object) -> Box:
    if not isinstance(box, Box):
        raise ValueError(f"expected a Box, got {box!r}")
    low, high = (
        _numbers(corner, (3,), f"three coordinates of a corner of {box.name}", MAX_PLACE)
        for corner in (box.low, box.high)
    )
    for letter, first, second in zip("xyz", low, high, strict=True):
        if first >= second:
            raise ValueError(
                f"{box.name}: {letter} of the first corner, {first:g}, must be below that of the second, {second:g}"
            )
    if box.system is not None:
        system_number(box.system)
    if _numbers((box.distance,), (1,), "a distance", MAX_PLACE)[0] < 0:
        raise ValueError(f"{box.name}: the distance {box.distance:g} is negative")
    return box


def check_boxes(value: object) -> tuple[Box, ...]:
    if isinstance(value, str | bytes | Mapping | Box) or not hasattr(value, "__iter__"):
        raise ValueError(f"expected boxes, got {value!r}")
    boxes = tuple(check_box(one) for one in value)
    names = [box.name for box in boxes]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{name} is given twice; every box needs its own name")
    return boxes


def check_shapes(value: object) -> dict[int, ToolShape]:
    found: dict[int, ToolShape] = {}
    for key, shape in _mapping(value, "a mapping from tool number to cylinders").items():
        if isinstance(key, bool) or not isinstance(key, int) or key < 0:
            raise ValueError(f"{key!r} is not the number of a tool")
        parts = tuple(shape) if isinstance(shape, tuple | list) else ()
        if not parts or not all(isinstance(one, Cylinder) and one.part in TOOL_PARTS for one in parts):
            raise ValueError(f"tool {key}: expected a tuple of Cylinder({' | '.join(TOOL_PARTS)}, diameter, length)")
        for at, one in enumerate(parts):
            sizes = (one.diameter,) if one.length is None else (one.diameter, one.length)
            if min(_numbers(sizes, (1, 2), f"sizes of the {one.part} of tool {key}", MAX_TOOL)) <= 0:
                raise ValueError(f"tool {key}: sizes of the {one.part} must be above 0")
            if one.length is None and at < len(parts) - 1:
                raise ValueError(
                    f"tool {key}: {one.part} needs a length: only the last part goes up to the gauge line by itself"
                )
        found[key] = parts
    return found


def check_place(value: object) -> str | tuple[float, ...] | None:
    if value is None or value == "home":
        return None if value is None else "home"
    if isinstance(value, str):
        raise ValueError(f"{value!r}: expected home, or joint values")
    given = tuple(value) if hasattr(value, "__iter__") else ()
    if not given:
        raise ValueError("expected home, or joint values")
    return _numbers(given, (len(given),), "joint values", math.inf)


def check_override(value: float) -> float:
    if not 0.05 <= value <= 1.0:
        hint = f"; {value:g} % is {value / 100:g}" if 5 <= value <= 100 else ""
        raise ValueError(f"expected a share from 0.05 to 1{hint}")
    return value


def check_texts(value: object) -> dict[str, bytes]:
    found = dict(_mapping(value, "a mapping from name to bytes"))
    for name, text in found.items():
        if (
            not isinstance(name, str)
            or name != name.lower()
            or not hasattr(text, "__getitem__")
            or isinstance(text, str)
        ):
            raise ValueError(f"{name!r}: expected a lower-case name without ending, and the bytes of the file")
    return found


def check_remap(value: object) -> dict[str, str]:
    meanings = get_args(Meaning)
    found = dict(_mapping(value, "a mapping from code to meaning"))
    for code, meaning in found.items():
        if not isinstance(code, str) or meaning not in meanings:
            raise ValueError(f"{code}: {meaning!r}: expected one of {', '.join(meanings)}")
    return found
