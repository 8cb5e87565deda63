"""A fuzz of Options: whatever is given is used as it is meant, or refused with a UsageError; nothing is ignored in
silence.

What each value means is said here a second time, in :data:`MEANING`, without the model.
"""

import math
import random
import sys
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

import verne_post as vp
from verne_post.model.options import OPTIONS, Options, find_about, find_key
from verne_post.model.part_setup import TOOL_PARTS, Cylinder, NominalPart, Wanted

CASES = 10_000
REFUSED: Final = object()
#: May be taken as the value that it equals, or refused.
EITHER: Final = (np.generic, Fraction, Decimal, np.ndarray, range)


class Odd:
    """An object of a kind that no option knows, but that compares like a number."""

    def __eq__(self, other: object) -> bool:
        return True

    def __hash__(self) -> int:
        return 0

    def __repr__(self) -> str:
        return "Odd()"


# --- what values mean ---------------------------------------------------------------------------------------


def number(low: float, high: float, *, none: bool = False, whole: bool = False) -> Callable[[Any], Any]:
    def meaning(value: Any) -> Any:
        if value is None:
            return None if none else REFUSED
        kinds = (int,) if whole else (int, float)
        return value if type(value) in kinds and low <= value <= high and (whole or math.isfinite(value)) else REFUSED

    return meaning


def words(*names: str, none: bool = False) -> Callable[[Any], Any]:
    return lambda value: value if (none and value is None) or (type(value) is str and value in names) else REFUSED


def flag(value: Any) -> Any:
    return value if type(value) is bool else REFUSED


def finite(value: Any) -> bool:
    return type(value) in (int, float) and value == value and abs(value) <= sys.float_info.max


def plain_numbers(value: Any, counts: tuple[int, ...], bound: float = 1e5) -> Any:
    if not isinstance(value, tuple | list) or len(value) not in counts:
        return REFUSED
    good = all(finite(one) and abs(one) <= bound for one in value)
    return tuple(value) if good else REFUSED


def system(key: Any) -> Any:
    names = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]
    numbers = {name: at for at, name in enumerate(names, 1)} | {f"G54.1P{p}": 100 + p for p in range(1, 49)}
    number = numbers.get(key.strip().upper()) if isinstance(key, str) else key
    return number if type(number) is int and number in numbers.values() else REFUSED


def offsets(value: Any) -> Any:
    if not isinstance(value, dict):
        return REFUSED
    meant = {}
    for key, offset in value.items():
        number = system(key)
        if number is REFUSED or number in meant:
            return REFUSED
        if isinstance(offset, vp.WorkOffset):
            origin = plain_numbers(offset.origin_mm, (3,))
            offset = REFUSED if origin is REFUSED else (*origin, offset.turn_deg)
        given = plain_numbers(offset, (3, 4))
        if given is REFUSED:
            return REFUSED
        meant[number] = vp.WorkOffset(given[:3], given[3] if len(given) > 3 else 0.0)
    return meant


def boxes(value: Any) -> Any:
    if not isinstance(value, tuple | list) or any(box(one) is REFUSED or one is None for one in value):
        return REFUSED
    names = [one.name for one in value]
    return tuple(box(one) for one in value) if len(set(names)) == len(names) else REFUSED


def box(value: Any) -> Any:
    if value is None:
        return None
    if type(value) is not vp.Box or type(value.name) is not str:
        return REFUSED
    low, high = plain_numbers(value.low, (3,)), plain_numbers(value.high, (3,))
    if low is REFUSED or high is REFUSED or any(a >= b for a, b in zip(low, high, strict=True)):
        return REFUSED
    if plain_numbers([value.distance], (1,)) is REFUSED or value.distance < 0:
        return REFUSED
    number = None if value.system is None else system(value.system)
    return REFUSED if number is REFUSED else replace(value, low=low, high=high, system=number)


def tool_of_length(number: Any, value: Any) -> Any:
    """The tool that a length means, or a length and a diameter; another value as it is."""
    given = plain_numbers([value] if finite(value) else value, (1, 2), 1e4)
    if given is REFUSED or given[0] < 0:
        return value
    return vp.Tool(number, number, (0.0, 0.0, given[0], *(0.0,) * 6), *given[1:])


def tools(value: Any) -> Any:
    if value is None:
        return None
    if not isinstance(value, dict):
        return REFUSED
    value = {key: tool_of_length(key, one) for key, one in value.items()}
    for key, tool in value.items():
        if (
            type(key) is not int
            or key < 0
            or type(tool) is not vp.Tool
            or type(tool.number) is not int
            or tool.number != key
        ):
            return REFUSED
        if type(tool.pocket) is not int or plain_numbers(tool.offset, (9,)) is REFUSED:
            return REFUSED
        if plain_numbers([tool.diameter], (1,), 1e4) is REFUSED or tool.diameter < 0:
            return REFUSED
    return {key: replace(tool, offset=tuple(tool.offset)) for key, tool in value.items()}


def shapes(value: Any) -> Any:
    if not isinstance(value, dict):
        return REFUSED
    for key, parts in value.items():
        if type(key) is not int or key < 0 or not isinstance(parts, tuple | list) or not parts:
            return REFUSED
        for at, part in enumerate(parts):
            if type(part) is not Cylinder or type(part.part) is not str or part.part not in TOOL_PARTS:
                return REFUSED
            sizes = [part.diameter] + ([] if part.length is None else [part.length])
            if plain_numbers(sizes, (1, 2), 1e4) is REFUSED or min(sizes) <= 0:
                return REFUSED
            if part.length is None and at < len(parts) - 1:
                return REFUSED
        names = [part.part for part in parts]
        if names != sorted(names, key=["cutter", "shank", "holder"].index) or names.count("cutter") + names.count(
            "shank"
        ) > len({*names} - {"holder"}):
            return REFUSED
    return {key: tuple(parts) for key, parts in value.items()}


def part(value: Any) -> Any:
    if value is None:
        return None
    if type(value) is not NominalPart or type(value.wanted) is not Wanted:
        return REFUSED
    if type(value.raw) is not bytes or value.unit == "ell" or value.system not in (None, 1):
        return REFUSED
    asked = [
        value.wanted.gouge,
        value.wanted.excess,
        1.0 if value.wanted.grid is None else value.wanted.grid,
        value.wanted.search,
    ]
    if plain_numbers(asked, (4,), 1e4) is REFUSED or min(asked) <= 0 or asked[3] < max(asked[:2]):
        return REFUSED
    return value


def place(value: Any) -> Any:
    if value is None or (type(value) is str and value == "home"):
        return value
    return plain_numbers(value, tuple(range(1, 10)), math.inf)


def texts(value: Any) -> Any:
    if not isinstance(value, dict):
        return REFUSED
    good = all(type(name) is str and name == name.lower() and type(text) is bytes for name, text in value.items())
    return value if good else REFUSED


def file_names(value: Any) -> Any:
    if not isinstance(value, dict):
        return REFUSED
    good = all(type(name) is str and name == name.lower() and type(file) is str for name, file in value.items())
    return value if good else REFUSED


def list_of_texts(value: Any) -> Any:
    good = isinstance(value, list | tuple) and all(type(one) is str for one in value)
    return tuple(value) if good else REFUSED


def marked_systems(value: Any) -> Any:
    if not isinstance(value, dict) or any(system(key) is REFUSED or type(one) is not str for key, one in value.items()):
        return REFUSED
    return {system(key): one for key, one in value.items()}


def replaced_tools(value: Any) -> Any:
    if not isinstance(value, dict) or any(type(key) is not int or type(one) is not str for key, one in value.items()):
        return REFUSED
    return value


def numbered(value: Any) -> Any:
    if not isinstance(value, dict):
        return REFUSED
    states = {*range(5400, 5429), *range(5021, 5030), *range(5081, 5090)}
    good = all(
        type(key) is int
        and 1 <= key <= 5601
        and key not in states
        and finite(one)
        and (key != 5220 or one in range(1, 10))
        for key, one in value.items()
    )
    return value if good else REFUSED


def remapped(value: Any) -> Any:
    if not isinstance(value, dict):
        return REFUSED
    # M3 means something already: refused where the program is read
    free = {"M428", "G68.3", "M3", "XYZ", "OFF"}
    good = all(
        code in free
        and type(meaning) is str
        and meaning in ("tcp on", "tcp off", "ignore", "event", "M3", "M4", "M5", "M6")
        for code, meaning in value.items()
    )
    return value if good else REFUSED


def controls(value: Any) -> Any:
    if not isinstance(value, dict):
        return REFUSED
    allowed: dict[str, dict[str, tuple[Any, ...]]] = {
        "siemens": {"rotation": ("rpy", "euler"), "orientation_by_group": (True, False)},
        "fanuc": {"decimal_point": ("", "calculator", "conventional")},
        "rs274": {"flavour": ("", "linuxcnc", "pathpilot", "mach3", "grbl"), "dwell": ("seconds", "milliseconds")},
        "aptcl": {
            "units": ("", "mm", "inch"),
            "msys": ("", "one clamping"),
            "cutcom": ("", "centre"),
            "insert": ("", "message"),
            "times": ("", "begun", "whole"),
            "lengths": ("", "tools"),
        },
    }
    good = all(
        type(dialect) is str
        and dialect in allowed
        and isinstance(keys, dict)
        and all(
            type(key) is str
            and key in allowed[dialect]
            and any(type(one) is type(two) and one == two for two in allowed[dialect][key])
            for key, one in keys.items()
        )
        for dialect, keys in value.items()
    )
    return value if good else REFUSED


MEANING: Final[dict[str, Callable[[Any], Any]]] = {
    "tool_length": number(0, 1e4, none=True),
    "tools": tools,
    "wcs": offsets,
    "cycle": number(1e-4, 1, none=True),
    "dialect": words("auto", "rs274", "fanuc", "aptcl", "heidenhain", "siemens"),
    "block_delete": flag,
    "optional_stop": flag,
    "subroutines": texts,
    "parameters": numbered,
    "parameter_units": words("mm", "inch"),
    "remap": remapped,
    "control": controls,
    "tapping": words("refuse", "feed"),
    "max_repeats": number(0, math.inf, whole=True),
    "max_megabytes": number(1, math.inf, whole=True),
    "max_rows": number(2, math.inf, whole=True),
    "smoothing": words("spline", "blend", "off"),
    "shaper": words("off", "zv", "zvd", "ei", none=True),
    "tolerance": number(1e-6, 10, none=True),
    "orientation_tolerance_deg": number(1e-6, 10, none=True),
    "rapids": words("line", "joint"),
    "orientation": words("auto", "vector", "angles"),
    "correct_axis": flag,
    "allow_rewind": flag,
    "free_c": flag,
    "approach": place,
    "departure": words("home", "park", none=True),
    "from_line": number(1, math.inf, none=True, whole=True),
    "split_at_stops": flag,
    "keep_out": boxes,
    "stock": box,
    "tool_shapes": shapes,
    "part": part,
    "air": number(0, 1000),
    "air_along": words("tool", "table"),
    "override": number(0.05, 1),
    "slow_start": number(0, 3600),
    "units": words("joint", "drive"),
    "decimals": number(0, 12, none=True, whole=True),
    "accept_rounding": flag,
    "solver": words("reachability", "toppra", "both"),
    "quality": flag,
    "jobs": number(1, 256, whole=True),
    "source_name": lambda value: value if type(value) is str else REFUSED,
    "subroutine_files": file_names,
    "setup_source": lambda value: value if type(value) is str else REFUSED,
    "setup_machine": lambda value: value if type(value) is str else REFUSED,
    "setup_file": lambda value: value if type(value) is str else REFUSED,
    "command_words": list_of_texts,
    "unmeasured_wcs": marked_systems,
    "replaced_tools": replaced_tools,
}


def meant_by(values: dict[str, Any]) -> Any:
    """What options mean together: values by name, or REFUSED."""
    meant = {}
    names: dict[str, int] = {}
    for option in ("tools", "tool_shapes"):
        table = values.get(option)
        if not (isinstance(table, dict) and len(table) == 1 and isinstance(key := next(iter(table)), str)):
            continue
        if not key.strip() or ("control" in values and MEANING["control"](values["control"]) is REFUSED):
            return REFUSED
        (tool,) = table.values()
        number = tool.number if isinstance(tool, vp.Tool) and type(tool.number) is int else 0
        if not key.isdecimal():
            names[key] = number or names.get(key) or max([100_000, *names.values()]) + 1
        values = {**values, option: {names.get(key) or int(key): tool}}
    for name, value in values.items():
        if name not in MEANING or (one := MEANING[name](value)) is REFUSED:
            return REFUSED
        meant[name] = one
    if names:
        control = meant.get("control", {})
        own = {one: control.get(one, {}) for one in ("siemens", "heidenhain", "aptcl")}
        meant["control"] = {**control, **{one: {**keys, "tools": names} for one, keys in own.items()}}
    if meant.get("from_line") is not None and meant.get("approach") is None:
        return REFUSED
    if meant.get("air_along", "tool") != "tool" and not meant.get("air", 0):
        return REFUSED
    return meant


# --- what is given ------------------------------------------------------------------------------------------


class Cases:
    """Seeded values: legal ones, nearly legal ones, and of any other kind."""

    def __init__(self, seed: int) -> None:
        self.pick = random.Random(seed)

    def one(self) -> Any:
        """A value of any kind."""
        pick = self.pick
        numbers = [
            0,
            1,
            -1,
            2,
            5,
            12,
            13,
            48,
            149,
            0.0,
            -0.0,
            0.05,
            0.5,
            1.0,
            1e-4,
            1e-6,
            1e-7,
            9.99,
            10.1,
            80.0,
            100.0,
            1000.0,
            3600.0,
            3601.0,
            1e4,
            1e5,
            1.1e5,
            1e300,
            -3,
            -40.0,
            math.nan,
            math.inf,
            -math.inf,
            10**400,
            True,
            False,
        ]
        other = [
            None,
            "",
            " ",
            "home",
            "park",
            "Home",
            "line",
            "off",
            "OFF",
            "bogus",
            "mm",
            "tool",
            "table",
            "both",
            "0.5",
            "1",
            "nan",
            b"",
            b"spline",
            (),
            [],
            {},
            set(),
            frozenset({1, 2, 3}),
            range(3),
            object,
            object(),
            Odd(),
            1j,
            Decimal("0.5"),
            Fraction(1, 2),
            np.float64(0.5),
            np.float32(0.5),
            np.int64(1),
            np.array(0.5),
            np.array([1.0, 2.0, 3.0]),
            np.bool_(True),
            lambda: 1,
            iter((1, 2, 3)),
            Path("home"),
            bytearray(b"x"),
        ]
        return pick.choice([*numbers, *other, pick.uniform(-20, 20), pick.randint(-5, 20)])

    def place(self, count: int = 3) -> Any:
        """Nearly always so many numbers."""
        pick = self.pick
        many = [pick.choice([pick.uniform(-200, 200), pick.randint(-50, 50)]) for _ in range(count)]
        many.sort()
        if pick.random() < 0.15:
            many[pick.randrange(count)] = self.one()
        if pick.random() < 0.07:
            many = many[1:]
        return pick.choice([tuple, list])(many) if pick.random() < 0.95 else self.one()

    def name_of_a_system(self) -> Any:
        pick = self.pick
        names = [
            "G54",
            "g54",
            " G55",
            "G59.3",
            "G54.1P7",
            "G54.1P49",
            "G60",
            1,
            2,
            9,
            10,
            101,
            149,
            0,
            "1",
            "",
            None,
            54,
        ]
        return pick.choice(names) if pick.random() < 0.9 else self.key()

    def key(self) -> Any:
        value = self.one()
        try:
            hash(value)
        except TypeError:
            return "x"
        return value

    def box(self) -> Any:
        pick = self.pick
        low, high = self.place(), self.place()
        if pick.random() < 0.8 and isinstance(low, tuple | list) and all(type(one) in (int, float) for one in low):
            high = type(low)(one + 1 for one in low)
        name = pick.choice(["vise", "clamp", "vise", self.one()])
        return vp.Box(
            name,
            low,
            high,
            pick.choice([None, None, 1, 101, 77, self.one()]),
            pick.choice([0.0, 0.0, 2, -1.0, self.one()]),
        )

    def fitting(self, name: str) -> Any:
        """A value that a user might give for an option, often legal."""
        pick = self.pick
        match name:
            case "wcs":
                keys = [self.name_of_a_system() for _ in range(pick.randint(0, 3))]
                turned = vp.WorkOffset(self.place(), pick.choice([0.0, 90, self.one()]))
                return {key: pick.choice([self.place(3), self.place(4), turned]) for key in keys}
            case "keep_out":
                return pick.choice([list, tuple])(self.box() for _ in range(pick.randint(0, 2)))
            case "stock":
                return self.box()
            case "tools":
                number = pick.choice([0, 1, 7, -1, "MILL", "5", self.key()])
                sizes = tuple(float(k) for k in range(9))
                sizes = sizes if pick.random() < 0.8 else self.place(9)
                same = number if pick.random() < 0.85 else self.one()
                if not isinstance(sizes, tuple | list) or len(sizes) != 9 or pick.random() < 0.2:
                    return {number: pick.choice([sizes, 80, 0.0, -3, (60, 8), [60, -8], (1, 2, 3), self.one()])}
                return {
                    number: vp.Tool(
                        same, pick.choice([1, 1, 1, self.one()]), sizes, pick.choice([0.0, 8, -1.0, self.one()])
                    )
                }
            case "tool_shapes":
                part = pick.choice(["cutter", "shank", "holder", "holder", "wheel", self.one()])
                first = Cylinder("cutter", 10.0, pick.choice([20.0, None, 5, self.one()]))
                last = Cylinder(part, pick.choice([20.0, 0, self.one()]), pick.choice([None, 30.0, self.one()]))
                return {
                    pick.choice([1, -1, "MILL", self.key()]): pick.choice(
                        [(first, last), [last], (first,), (), self.one()]
                    )
                }
            case "part":
                wanted = Wanted(*(pick.choice([0.05, 1, 0.0, 3.0, self.one()]) for _ in range(4)))
                raw, unit = pick.choice([b"solid", b"solid", "solid"]), pick.choice(["mm", "mm", "inch", "ell"])
                return NominalPart(
                    "part", raw, pick.choice([None, 1, 1, 77]), unit, pick.choice([Wanted(), wanted, self.one()])
                )
            case "approach":
                return pick.choice(["home", self.place(5), self.place(5), "park", self.one()])
            case "subroutines":
                return {pick.choice(["bore", "Bore", self.key()]): pick.choice([b"M2\n", "M2\n", [1], self.one()])}
            case "parameters":
                return {pick.choice([1, 5220, self.key()]): self.one()}
            case "remap":
                code = pick.choice(["M428", "M428", "G68.3", "M3", "M030", "XYZ", "", self.key()])
                return {code: pick.choice(["tcp on", "event", "ignore", "TCP ON", self.one()])}
            case "control":
                key = pick.choice(["rotation", "rotation", "orientation_by_group", "Rotation", self.key()])
                given = {key: pick.choice(["rpy", "euler", "xyz", True, self.one()])}
                return {
                    pick.choice(["siemens", "siemens", "siemens", "rs274", self.key()]): pick.choice(
                        [given, given, {}, self.one()]
                    )
                }
            case "from_line":
                return pick.choice([1, 3, 3.0, 0, self.one()])
            case "subroutine_files":
                return {pick.choice(["bore", "Bore", self.key()]): pick.choice(["Bore.SPF", b"M2", self.one()])}
            case "replaced_tools":
                return {pick.choice([1, 7, self.key()]): pick.choice(["verne-post.toml: tools", self.one()])}
            case "unmeasured_wcs":
                return {self.name_of_a_system(): pick.choice(["part.nc.toml", self.one()])}
            case "source_name":
                return pick.choice(["a.nc", self.one()])
            case _:
                choices = find_about(name).choices
                named = (
                    list(choices())
                    if choices
                    else [
                        "auto",
                        "rs274",
                        "spline",
                        "blend",
                        "off",
                        "line",
                        "joint",
                        "vector",
                        "angles",
                        "home",
                        "park",
                        "drive",
                        "inch",
                    ]
                )
                return pick.choice(
                    [self.one(), self.one(), pick.choice(named), pick.uniform(0, 12), pick.randint(0, 12), True]
                )

    def misspelt(self, name: str) -> str:
        """A name with one mistake."""
        pick = self.pick
        at = pick.randrange(len(name))
        return pick.choice(
            [
                name[:at] + name[at + 1 :],
                name[:at] + name[at] + name[at:],
                name.upper(),
                name.replace("_", "-"),
                name + "s",
                name.replace("_", ""),
                "_" + name,
                name + "_mm",
                name[:at] + "e" + name[at + 1 :],
                find_key(name) + " ",
                name.title(),
            ]
        )

    def values(self) -> dict[str, Any]:
        """One to four options."""
        pick, names = self.pick, list(OPTIONS)
        values = {}
        for name in pick.sample(names, pick.choice([1, 1, 1, 2, 3, 4])):
            given = self.misspelt(name) if pick.random() < 0.08 else name
            value = self.fitting(name) if pick.random() < 0.75 else self.one()
            tries = pick.choice([0, 0, 20])
            while tries and MEANING[name](value) is REFUSED:
                value, tries = self.fitting(name), tries - 1
            values[given] = value
        if "from_line" in values and pick.random() < 0.7:
            values.setdefault("approach", "home")
        if "air_along" in values and pick.random() < 0.7:
            values.setdefault("air", 40.0)
        return values


def contains(value: Any, kinds: tuple[type, ...]) -> bool:
    if isinstance(value, dict):
        return any(contains(one, kinds) for pair in value.items() for one in pair)
    if isinstance(value, tuple | list):
        return any(contains(one, kinds) for one in value)
    if not isinstance(value, type):
        names = getattr(value, "__struct_fields__", None) or getattr(value, "__dataclass_fields__", ())
        if names:
            return any(contains(getattr(value, name), kinds) for name in names)
    return isinstance(value, kinds)


# --- tests --------------------------------------------------------------------------------------------------


def test_every_option_has_a_meaning_here() -> None:
    assert set(MEANING) == set(OPTIONS)


def test_options_are_used_as_meant_or_refused() -> None:
    cases, accepted, refused = Cases(17), 0, 0
    defaults = Options()
    for case in range(CASES):
        values = cases.values()
        meant = meant_by(values)
        where = f"case {case}: {values!r:.500}"
        try:
            options = Options(**values)
        except vp.UsageError as error:
            refused += 1
            assert meant is REFUSED or contains(values, EITHER), f"{where}: {error}"
            assert error.option in values or error.option in MEANING, where
            assert error.reason, where
            continue
        except Exception as error:
            raise AssertionError(f"{where}: {type(error).__name__}: {error}") from error
        accepted += 1
        if not contains(values, EITHER):
            assert meant is not REFUSED, f"{where}: accepted, though it means nothing"
            for name in MEANING:
                expected = meant[name] if name in meant else getattr(defaults, name)
                assert getattr(options, name) == expected, f"{where}: {name}"
            changed = options.changed()
            assert changed == options
            options.record()
    assert accepted > CASES // 8
    assert refused > CASES // 3


PROGRAM: Final = b"G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X2 F900\nM2\n"


def test_options_that_are_accepted_never_break_a_check(machine: vp.Machine) -> None:
    cases, done = Cases(71), 0
    while done < 150:
        values = cases.values()
        try:
            options = Options(**{"tool_length": 60.0, "wcs": {"G54": (0, 0, 20)}, **values, "solver": "reachability"})
        except vp.UsageError:
            continue
        done += 1
        # more processes of this size take seconds, and check no more
        options = options.changed(jobs=min(options.jobs, 2))
        try:
            result = vp.check(PROGRAM, machine, options)
        except vp.UsageError:
            continue
        except Exception as error:
            raise AssertionError(f"{values!r:.500}: {type(error).__name__}: {error}") from error
        assert result.ok or result.findings


@pytest.mark.parametrize("call", [vp.check, vp.convert])
def test_wrong_arguments_raise_the_documented_error(call: Callable[..., Any], machine: vp.Machine) -> None:
    cases = Cases(5)
    wrong = [
        None,
        5,
        1.5,
        True,
        object(),
        [],
        {},
        (),
        {"tool_length": 60},
        "bogus",
        b"bogus",
        Options,
        vp.UsageError("a", "b"),
        1j,
        set(),
    ]
    wrong += [cases.one() for _ in range(100)]
    good = (PROGRAM, machine, vp.Options(tool_length=60.0))
    for value in wrong:
        for at in range(3):
            arguments = [*good[:at], value, *good[at + 1 :]]
            try:
                result = call(*arguments)
            except (vp.UsageError, vp.InputError):
                continue
            except Exception as error:
                raise AssertionError(f"argument {at}: {value!r}: {type(error).__name__}: {error}") from error
            # text and paths are sources, None is the default of machine and options: a verdict is given on them
            assert (at == 0 and isinstance(value, bytes | str | Path)) or (at > 0 and value is None), (at, value)
            assert result.findings or result.ok
        for name in ("sink", "progress"):
            if value is None or callable(value) or (call is vp.check and name == "sink"):
                continue
            with pytest.raises(vp.UsageError):
                call(*good, **{name: value})


def test_a_code_with_a_meaning_is_given_no_other(machine: vp.Machine) -> None:
    with pytest.raises(vp.UsageError, match="remap: M3: it already has a meaning"):
        vp.check(PROGRAM, machine, vp.Options(remap={"M3": "ignore"}))


def test_misspelt_names_are_answered_with_the_right_one() -> None:
    for name, right in (
        ("tool_lenght", "tool_length"),
        ("smothing", "smoothing"),
        ("keepout", "keep_out"),
        ("wsc", "wcs"),
    ):
        with pytest.raises(vp.UsageError, match=f"{name}: there is no such option; did you mean {right}?"):
            Options(**{name: 1})


@pytest.mark.parametrize(
    ("name", "value", "taken"),
    [
        ("tool_length", np.int64(80), 80.0), ("tool_length", np.float32(80.5), 80.5),
        ("tool_length", np.array(80.0), 80.0),
        ("jobs", np.int32(2), 2), ("decimals", np.uint8(3), 3), ("quality", np.bool_(True), True),
    ],
)  # fmt: skip
def test_numbers_of_numpy_are_numbers(name: str, value: object, taken: object) -> None:
    found = getattr(Options(**{name: value}), name)
    assert (found, type(found)) == (taken, type(taken))


def test_arrays_and_lists_of_numbers_of_numpy_are_numbers() -> None:
    """Tools and offsets that come from a table of measurements mean the same as in plain numbers."""
    offset = (0.0, 0.0, 66.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    plain = Options(tools={1: vp.Tool(1, 1, offset, 6.0)}, wcs={"G54": (1, 2, 3)}, parameters={100: 1.5})
    measured = Options(
        tools={1: vp.Tool(1, 1, np.array(offset), np.float32(6))},  # type: ignore[arg-type]
        wcs={"G54": tuple(np.array([1, 2, 3]))},
        parameters={np.int64(100): np.float64(1.5)},
    )
    assert measured == plain
    assert measured.record() == plain.record()


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("parameters", {0: 1.0}, "numbers 1 to 5601, not 0"),
        ("parameters", {5602: 1.0}, "numbers 1 to 5601, not 5602"),
        ("parameters", {5420: 1.0}, "shows a state"),
        ("parameters", {5220: 12.0}, "work system has a number from 1 to 9"),
        ("parameters", {5220: 1.5}, "work system has a number from 1 to 9"),
        ("smoothing", "\ud800", "expected one of spline"),
        ("dialect", np.array(["fanuc", "rs274"]), "expected one of auto"),
        ("dialect", "sinumerik", "; did you mean siemens?"),
        ("dialect", "haas", "; did you mean fanuc?"),
        ("dialect", "LinuxCNC", "; did you mean rs274?"),
    ],
)
def test_values_that_once_broke_a_call(name: str, value: object, said: str) -> None:
    with pytest.raises(vp.UsageError, match=said):
        Options(**{name: value})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("tool_length", np.bool_(True)),
        ("tool_length", np.float64("nan")),
        ("jobs", np.float64(2.0)),
        ("tool_length", np.array([80.0])),
    ],
)
def test_other_values_of_numpy_are_refused(name: str, value: object) -> None:
    with pytest.raises(vp.UsageError, match=f"{name}: .*expected"):
        Options(**{name: value})


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ([Cylinder("foo", 5.0, 20.0)], "tool 1: 'foo' is not a part of a tool; expected one of cutter, shank, holder"),
        ("cutter", r"tool 1: expected a sequence of Cylinder\(part, diameter, length\), got 'cutter'"),
    ],
)
def test_a_wrong_part_of_a_tool_is_named(parts: Any, said: str) -> None:
    with pytest.raises(vp.UsageError, match=said):
        Options(tool_shapes={1: parts})
