"""Find, read and check machine files."""

import hashlib
import json
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np
from msgspec.structs import asdict

from verne_post.base.arrays import Array
from verne_post.base.file_kinds import describe_kind
from verne_post.base.printable import escape_unprinted
from verne_post.base.suggestions import find_meant, find_suggestion, suggest
from verne_post.base.units import MILLI, RAD_PER_DEG
from verne_post.config.beside import find_file_beside
from verne_post.config.common import convert_drives, convert_home, convert_vibration
from verne_post.config.files import read_file
from verne_post.config.kinds import KINDS, Kind
from verne_post.config.machine_paths import DEFAULT_MACHINE, find_machine_path, read_machine_file
from verne_post.config.plausibility import find_implausible
from verne_post.config.schema import (
    AccuracyFile,
    LimitsFile,
    MachineFile,
    RodsFile,
    TolerancesFile,
    describe_limits_table,
)
from verne_post.config.sentences import Table, WrongTableError, check_table, list_all_keys
from verne_post.config.toml_text import read_toml
from verne_post.kinematics.checks.bodies import Clearance
from verne_post.kinematics.five_axis import HybridMachine
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.kinematics.tables.tilting import TiltingTable
from verne_post.model.deviations import ENTRIES, Deviations, RodPlaces
from verne_post.model.findings import Finding, InputError, UsageError, make_finding, make_input_error
from verne_post.model.machine import Accuracy, Bodies, Column, Limits, Machine
from verne_post.model.moves import Frame
from verne_post.model.option_checks import convert_from_numpy
from verne_post.model.part_setup import FixtureMesh
from verne_post.model.protocols import FiveAxis, RodModule

if TYPE_CHECKING:
    from verne_post.kinematics.as_built.bodies import VerneRods

_Schema = TypeVar("_Schema", bound=Table)
#: Machines whose files hold all that they are made of, by name and bytes of the file; and how many are kept.
_BUILT: Final[dict[tuple[str, bytes], Machine]] = {}
_KEPT_MACHINES: Final = 8


def load_machine(
    name_or_path: str | os.PathLike[str] = DEFAULT_MACHINE, read: Callable[[Path], bytes] | None = None
) -> Machine:
    """Load a machine by name, or from a file; ``read`` gives the bytes of its files, where it is not the disk.

    Raises
    ------
    InputError
        One finding (VP501) for each mistake: file, key, value, bound.
    UsageError
        Neither a name nor a path.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        raise UsageError("machine", f"expected a name or a path, got {type(name_or_path).__name__}")
    path = find_machine_path(name_or_path)

    raw = read_machine_file(path, f"machine file {str(name_or_path)!r}", path.name, read or read_file)

    if (known := _BUILT.get((path.name, raw))) is not None:
        return known
    beside = []

    def read_named(name: str, key: str = "as_built.file") -> bytes:
        beside.append(name)
        try:
            found = find_file_beside(path.parent, name, key, "put it there")
        except ValueError as error:
            raise make_input_error("VP501", f"{path.name}: {error}") from None
        return read_machine_file(found, f"{path.name}: {key} {name!r}", read=read or read_file)

    machine = build_machine(raw, path.name, read_named)
    if not beside:  # else its file does not say all of it
        while len(_BUILT) >= _KEPT_MACHINES:
            _BUILT.pop(next(iter(_BUILT)))
        _BUILT[path.name, raw] = machine
    return machine


def _refuse_files(name: str, key: str = "as_built.file") -> bytes:
    text = f"{key} = {name!r}: a machine that is not read from a file has no files beside it"
    raise make_input_error("VP501", text)


def build_machine(raw: bytes, file_name: str, read: Callable[..., bytes] = _refuse_files) -> Machine:
    """Build a machine from the bytes of its file; ``read`` gives the bytes of a file that a key names."""
    try:
        data = read_toml(raw)
    except ValueError as error:
        why = describe_kind(raw, "a machine file") or error
        raise make_input_error("VP501", f"{file_name}: {why}") from None
    if "schema" not in data and (other := describe_kind(raw, "a machine file")):
        raise make_input_error("VP501", f"{file_name}: {other}")
    files: dict[str, bytes] = {}

    def keep(name: str, key: str = "as_built.file") -> bytes:
        files[name] = read(name, key)
        return files[name]

    machine = _build_reachable(data, raw, file_name, keep)
    return replace(machine, rebuild=partial(_rebuild_machine, raw, file_name, files, {}))


def _rebuild_machine(
    raw: bytes, file_name: str, files: Mapping[str, bytes], before: Mapping[str, object], values: Mapping[str, object]
) -> Machine:
    """The machine of a file with other values for keys, whose names have points; ``before`` are those changed before.

    Raises
    ------
    InputError
        VP501 with every mistake.
    """
    data, changed, absent = read_toml(raw), dict[str, Any](), dict[str, Any]()
    asked = dict(before)
    for key, value in values.items():  # a table replaces what was changed in it
        asked = {**{old: one for old, one in asked.items() if not _is_in(old, key)}, key: value}
    for key, value in asked.items():
        given = _convert_value(value)
        if _put_value(data, key, given, file_name):
            changed[key] = given
        elif given is None:
            absent[key] = {}

    def read(name: str, key: str = "as_built.file") -> bytes:
        if name not in files:
            text = f"{file_name}: {key} = {name!r} is not the file that was loaded; load a machine file that names it"
            raise make_input_error("VP501", text)
        return files[name]

    if absent:
        _expect_keys(raw, absent, file_name, read)
    told = json.loads(json.dumps(changed, default=str), parse_int=float)  # 5000 is 5000.0
    hashed = raw + json.dumps(told, sort_keys=True).encode() if changed else raw
    try:
        machine = _build_reachable(data, hashed, file_name, read)
    except InputError as error:
        raise InputError(*_name_whole_keys(error.findings, read_toml(raw), changed, file_name)) from None
    provenance = machine.provenance
    if changed:
        said = (f"{key} = {'absent' if value is None else value}" for key, value in sorted(changed.items()))
        provenance = {**provenance, "changed": ", ".join(said)}
    return replace(machine, provenance=provenance, rebuild=partial(_rebuild_machine, raw, file_name, files, changed))


def _expect_keys(raw: bytes, absent: dict[str, Any], file_name: str, read: Callable[..., bytes]) -> None:
    """Refuse keys that no file of this kind has, where what is not there is to be taken out."""
    data = read_toml(raw)
    for key, value in absent.items():
        _put_value(data, key, value, file_name)
    try:
        _build_machine(data, raw, file_name, read)
    except InputError as error:
        wrong = [item for item in error.findings if " is not a key of " in item.message]
        if wrong:
            raise InputError(*_name_whole_keys(wrong, read_toml(raw), absent, file_name)) from None


#: A mistake about the name of a key: its place, and what is said of it.
_WRONG_KEY: Final = re.compile(r"(\S++) is (missing|not a key of .*)")
#: So many keys are named where each may be meant.
_MOST_MEANT: Final = 6


def _name_whole_keys(
    findings: Iterable[Finding], data: dict[str, Any], changed: Mapping[str, Any], file_name: str
) -> Iterator[Finding]:
    """Findings about changed keys, with the whole key that is meant, and one for a table that lacks keys.

    ``data`` is the file as it was.
    """
    known = dict.fromkeys(_list_known_keys(data))
    told: dict[str, None] = {}
    for item in findings:
        found = _WRONG_KEY.fullmatch(item.message.removeprefix(f"{file_name}: "))
        texts: dict[str, str] = {}
        if found and found[2] == "missing":
            texts = {
                key: _describe_lacking_table(key, value, found[1])
                for key, value in changed.items()
                if isinstance(value, dict) and _is_in(found[1], key) and _has_table(data, key)
            }
        elif found:
            meant = {key: _name_meant_key(key, known) for key in changed if _is_in(key, found[1]) and key not in known}
            texts = {key: f"{key} is not a key of this machine file; {text}" for key, text in meant.items() if text}
        if not texts:
            yield item
        yield from (replace(item, message=f"{file_name}: {text}") for key, text in texts.items() if key not in told)
        told.update(dict.fromkeys(texts))


def _is_in(key: str, table: str) -> bool:
    return f"{key}.".startswith(f"{table}.")


def _has_table(data: dict[str, Any], key: str) -> bool:
    found: Any = data
    for name in key.split("."):
        found = found.get(name) if isinstance(found, dict) else None
    return isinstance(found, dict)


def _describe_lacking_table(key: str, value: Any, place: str) -> str:
    text = f"{key}: this table replaces the whole one of the file, and lacks {place.removeprefix(f'{key}.')}"
    while isinstance(value, dict) and value:
        inner, value = next(iter(value.items()))
        key += f".{inner}"
    return text if isinstance(value, dict) else f'{text}; machine.changed({{"{key}": {value!r}}}) changes one key'


def _name_meant_key(key: str, known: Iterable[str]) -> str:
    """Which key is meant: one with all words of the last part of ``key``; else the keys of its table.

    Empty where the table is one that the file could have.
    """
    table, _point, last = key.rpartition(".")
    near = find_meant(last, dict.fromkeys(one.rpartition(".")[2] for one in known), slip_alone=True)
    for word in filter(None, (last, near)):
        words = _split_words(f"{table}.{word}")
        shared = {
            one: len(words & _split_words(one))
            for one in known
            if _split_words(word) <= _split_words(one) and not _is_in(one, "provenance")
        }
        meant = [one for one, count in shared.items() if count == max(shared.values())]
        if len(meant) == 1:
            return f"did you mean {meant[0]}?"
        if 0 < len(meant) <= _MOST_MEANT:
            return f"there are {', '.join(meant)}"
    if of_table := [one.removeprefix(f"{table}.") for one in known if one.startswith(f"{table}.")]:
        return f"the keys of {table} are {', '.join(of_table)}"
    tables = dict.fromkeys(one.split(".")[0] for one in known)
    return "" if table.split(".")[0] in tables else f"its keys and tables are {', '.join(tables)}"


def _split_words(key: str) -> set[str]:
    return set(re.split(r"[._]", key.lower()))


def _list_known_keys(data: dict[str, Any]) -> Iterator[str]:
    if data.get("schema") == 2:
        from verne_post.config.chain import ChainMachineFile  # the default machine has another schema

        yield from list_all_keys(ChainMachineFile, data)
        return
    kind = KINDS[data["kind"]]
    parts = {"module": kind.schema, "limits": describe_limits_table(kind.group, kind.rods), "rods": kind.bodies}
    yield from list_all_keys(MachineFile, {key: value for key, value in data.items() if key not in parts})
    for name, schema in parts.items():
        yield from (f"{name}.{key}" for key in (list_all_keys(schema, {}) if schema else ()))


def _put_value(data: dict[str, Any], key: str, value: Any, file_name: str) -> bool:
    """Put a value into the tables of a file, None for no such key; returns whether it is another one."""
    *tables, last = key.split(".")
    table: Any = data
    for number, name in enumerate(tables, start=1):
        table = table.setdefault(name, {}) if value is not None else table.get(name, {})
        if not isinstance(table, dict):
            raise make_input_error("VP501", f"{file_name}: {key}: {'.'.join(tables[:number])} is no table")
    old = table.get(last)
    if old == value and isinstance(old, bool) == isinstance(value, bool):
        return False
    if value is None:
        del table[last]
    else:
        table[last] = value
    return True


def _convert_value(value: object) -> Any:
    """A value as a TOML file has it: numbers, lists and tables of Python."""
    value = convert_from_numpy(value.tolist() if isinstance(value, np.ndarray) else value)
    if isinstance(value, Mapping):
        return {str(key): _convert_value(one) for key, one in value.items()}
    return [_convert_value(one) for one in value] if isinstance(value, list | tuple) else value


def _build_reachable(data: dict[str, Any], raw: bytes, file_name: str, read: Callable[..., bytes]) -> Machine:
    """The machine of the tables of a file, and which of its stored positions are out of reach."""
    machine = _build_machine(data, raw, file_name, read)
    unreachable: list[Finding] = []
    for name, home, ok, _q in solve_stored(machine):
        if not ok:
            what = f"home.{name} = {list(home)} is out of reach, and so is the program"
            meant = () if unreachable else tuple(_find_meant_lengths(data, raw, file_name, read, name))
            if len(meant) == 1:
                key, value, right = meant[0]
                text = f"{key} = {value:g}: {what}; with {right:g} it is within reach"
            elif meant:
                others = " or ".join(f"{key} = {right:g} instead of {value:g}" for key, value, right in meant)
                text = f"{what}; it is within reach with {others}"
            else:
                lengths = "the joints" if machine.module is None else "[module]"
                text = f"{what}: correct the lengths of {lengths}, or [table], or this position"
            unreachable.append(make_finding("VP501", f"{file_name}: {text}"))
    return replace(machine, unreachable=tuple(unreachable)) if unreachable else machine


#: How a length that is not meant is mostly off: another unit, a decimal point elsewhere, a sign.
_SLIPS: Final = (1000.0, 0.001, 10.0, 0.1, -1.0)


def _find_meant_lengths(
    data: dict[str, Any], raw: bytes, file_name: str, read: Callable[..., bytes], name: str
) -> Iterator[tuple[str, float, float]]:
    """Lengths of [module] of which one slip alone puts a stored position out of reach: key, value, what is right.

    What is right is of the size of the other lengths.
    """
    lengths = {key: value for key, value in data.get("module", {}).items() if isinstance(value, int | float)}
    for key, value in lengths.items():
        others = [abs(one) for other, one in lengths.items() if other != key]
        for right in (value * factor for factor in _SLIPS):
            if not others or not min(others) <= abs(right) <= max(others):
                continue
            try:
                other = _build_machine({**data, "module": {**data["module"], key: right}}, raw, file_name, read)
            except InputError:
                continue  # no such machine
            if all(ok for stored, _home, ok, _q in solve_stored(other) if stored == name) and not other.warnings:
                yield f"module.{key}", value, right


def _build_machine(data: dict[str, Any], raw: bytes, file_name: str, read: Callable[..., bytes]) -> Machine:
    if "carrier" in data:
        from verne_post.config.carrier import describe_refused_carrier  # few machines have one

        if why := describe_refused_carrier(data["carrier"], data.get("schema")):
            raise make_input_error("VP501", f"{file_name}: {why}")
    if data.get("schema") == 2:
        from verne_post.config.chain import build_chain_machine  # the default machine has another schema

        return build_chain_machine(data, raw, file_name)
    content, kind, module_file, limits, rods = _check_schemas(data, file_name)
    as_built = None
    if content.as_built is not None:
        from verne_post.config.as_built import build_as_built, read_as_built  # few machines have it

        as_built = read_as_built(content.as_built, file_name, read)
    try:
        module = kind.build(**asdict(module_file))
    except ValueError as error:
        raise make_input_error("VP501", f"{file_name}: module: {error}") from None
    table = TiltingTable(
        pivot=np.array(content.table.pivot),
        rotary_offset=np.array(content.table.rotary_offset),
        machine_zero=np.array(content.table.machine_zero),
        a_sign=1.0 if content.table.a_positive == "workpiece" else -1.0,
        c_sign=1.0 if content.table.c_positive == "workpiece" else -1.0,
    )
    columns = (
        *(Column(name, "mm", 1.0, "VP101") for name in module.actuators),
        Column("a", "deg", table.a_sign / RAD_PER_DEG, "VP102"),
        Column("c", "deg", table.c_sign / RAD_PER_DEG, "VP103"),
    )
    joint_limits = _convert_limits(limits, kind, len(module.actuators), table)
    home, accuracy = content.home, content.accuracy or AccuracyFile()
    places = _find_rod_places(kind, rods)
    threshold = accuracy.uncorrected_axis_deg or math.inf
    nominal = HybridMachine(module, table, content.spindle.nose_offset_mm)
    five_axis: FiveAxis = nominal
    provenance = {
        key: escape_unprinted(value) for key, value in asdict(content.provenance).items() if value is not None
    }
    if as_built is not None:
        _require_places(content, places, file_name)
        assert places is not None
        five_axis = build_as_built(nominal, places, as_built[0], threshold, joint_limits, file_name)
        provenance["as_built"] = as_built[0].source
    clearance = _make_clearance(content, five_axis, nominal, rods, places)
    meshes = _read_bodies(content, read)
    return Machine(
        name=escape_unprinted(content.name),
        kind=content.kind,
        file_sha256=hashlib.sha256(
            raw + (as_built[1] if as_built else b"") + b"".join(one.raw for one in meshes)
        ).hexdigest(),
        module=module,
        five_axis=five_axis,
        coordinates=table,
        columns=columns,
        limits=joint_limits,
        accuracy=Accuracy(accuracy.tip_mm, RAD_PER_DEG * accuracy.axis_deg, RAD_PER_DEG * threshold),
        home=convert_home(home) if home else None,
        table_radius=content.table.radius,
        spindle_rpm=content.spindle.max_speed_rpm or math.inf,
        clearance=clearance,
        cycle=content.control.cycle_s,
        provenance=provenance,
        drives=convert_drives(content.drives, columns, joint_limits, file_name),
        bodies=clearance.bodies if clearance else None,
        rod_places=places,
        warnings=tuple(find_implausible(data, kind.group, file_name)),
        tolerances=_convert_tolerances(content.tolerances or TolerancesFile()),
        vibration=convert_vibration(content.vibration),
        meshes=meshes,
    )


def _read_bodies(content: MachineFile, read: Callable[..., bytes]) -> tuple[FixtureMesh, ...]:
    """The bodies that are meshes.

    Raises
    ------
    InputError
        VP506 where a file is no STL of one closed body.
    """
    meshes = []
    for name, one in (content.bodies or {}).items():
        mesh = FixtureMesh(name, read(one.file, f"bodies.{name}.file"), unit=one.unit, file=one.file)
        from verne_post.part.fixture import load_fixture  # few machine files have meshes

        load_fixture(mesh.raw, mesh.shown, mesh.unit)
        meshes.append(mesh)
    return tuple(meshes)


def _convert_tolerances(file: TolerancesFile) -> np.ndarray:
    """Of all deviations in the order of their vector, mm and rad."""
    parts = []
    for key, shape, angle in ENTRIES.values():
        common = file.directions_mrad if angle else file.lengths_mm
        value = getattr(file, key) or common
        parts.append(np.full(int(np.prod(shape)), value * (MILLI if angle else 1.0)))
    return np.concatenate(parts)


def _convert_limits(file: LimitsFile, kind: Kind, n: int, table: TiltingTable) -> Limits:
    values = asdict(file)

    def convert_actuators(value: float | list[float] | None) -> list[float]:
        return list(value) if isinstance(value, list) else [value or math.inf] * n

    travel = values[f"{kind.group}_mm"]
    ranges = travel if isinstance(travel[0], list) else [travel] * n
    angles = []
    for limits_deg, sign in ((file.a_deg, table.a_sign), (file.c_deg, table.c_sign)):
        low, high = limits_deg or (-math.inf, math.inf)
        angles.append(
            [RAD_PER_DEG * low, RAD_PER_DEG * high] if sign > 0 else [-RAD_PER_DEG * high, -RAD_PER_DEG * low]
        )
    rows = np.array([*ranges, *angles], dtype=float)

    def collect_joints(what: str) -> np.ndarray:
        a, c = (RAD_PER_DEG * (values[f"{joint}_{what}"] or math.inf) for joint in ("a", "c"))
        return np.array([*convert_actuators(values[f"{kind.group}_{what}"]), a, c])

    smallest_drop = values["serial_singularity_mm"] if kind.rods else 0.0
    determinant = values["parallel_singularity"] if kind.rods else None
    return Limits(
        rows[:, 0],
        rows[:, 1],
        collect_joints("velocity"),
        collect_joints("acceleration"),
        collect_joints("jerk"),
        smallest_drop,
        -math.inf if determinant is None else determinant,
    )


def _check_schemas(
    data: dict[str, Any], file_name: str
) -> tuple[MachineFile, Kind, Table, LimitsFile, RodsFile | None]:
    """The file against its schemas: the whole, and the groups whose keys depend on the kind.

    Raises
    ------
    InputError
        With every mistake at once.
    """
    mistakes: list[Finding] = []

    def check_part(schema: type[_Schema], part: dict[str, Any], prefix: str = "", kind: str = "") -> _Schema | None:
        try:
            return check_table(schema, part, f"a machine file{f' of kind {kind!r}' if kind else ''}", prefix)
        except WrongTableError as error:
            mistakes.extend(make_finding("VP501", f"{file_name}: {text}") for text in error.sentences)
            return None

    content = check_part(MachineFile, data)
    of_schema = [item for item in mistakes if item.message.startswith(f"{file_name}: schema = ")]
    if "schema" not in data:
        of_schema = [item for item in mistakes if find_suggestion(item.message) == "schema"] or [
            make_finding("VP501", f"{file_name}: schema is missing; write schema = 2 for a chain of joints, else 1")
        ]
    if of_schema:  # which keys there are depends on it
        raise InputError(*of_schema)
    name = data.get("kind")
    kind = KINDS.get(name) if isinstance(name, str) else None
    if kind is None and isinstance(name, str):
        message = (
            f"{file_name}: kind = {name!r}: unknown; expected one of {', '.join(KINDS)}{suggest(name.lower(), KINDS)}"
        )
        mistakes.append(make_finding("VP501", message))
    module = limits = rods = None
    if kind is not None:
        groups = {
            name: data.get(name) if isinstance(data.get(name), dict) else None for name in ("module", "limits", "rods")
        }
        if groups["module"] is not None:
            module = check_part(kind.schema, groups["module"], "module", str(name))
        if groups["limits"] is not None:
            limits = check_part(describe_limits_table(kind.group, kind.rods), groups["limits"], "limits", str(name))
        if groups["rods"] is not None and kind.bodies is not None:
            rods = check_part(kind.bodies, groups["rods"], "rods", str(name))
        elif groups["rods"] is not None:
            mistakes.append(make_finding("VP501", f"{file_name}: [rods]: kind {name!r} has no rods as bodies"))
    if mistakes:
        raise InputError(*mistakes)
    assert content is not None
    assert kind is not None
    assert module is not None
    assert limits is not None
    return content, kind, module, limits, rods


def _find_rod_places(kind: Kind, rods: RodsFile | None) -> RodPlaces | None:
    """Where the rods are along x; None where the file or the kind does not say."""
    if rods is None or kind.rod_places is None:
        return None
    return kind.rod_places(
        **{key: value for key, value in asdict(rods).items() if key not in RodsFile.__struct_fields__}
    )


def _require_places(content: MachineFile, places: RodPlaces | None, file_name: str) -> None:
    """Refuse [as_built] of a machine that has no as-built model."""
    if KINDS[content.kind].rod_places is None:
        raise make_input_error("VP501", f"{file_name}: as_built: kind {content.kind!r} has no as-built model")
    if places is None:
        raise make_input_error(
            "VP501",
            f"{file_name}: rods is missing: as_built needs to know where the rods are along x "
            "(leg1_slider_x, leg23_slider_x, leg23_spacing)",
        )


def _make_rod_bodies(five_axis: FiveAxis, nominal: HybridMachine, places: RodPlaces) -> "VerneRods":
    """The rods as bodies, where they are on the machine as built."""
    from verne_post.kinematics.as_built.bodies import VerneRods  # few machine files have their diameters
    from verne_post.kinematics.as_built.machine import AsBuiltMachine

    drawn = AsBuiltMachine(nominal, places, Deviations.build_nominal()).geometry
    assert isinstance(nominal.module, VerneGeometry)
    return VerneRods(nominal.module, five_axis.geometry if isinstance(five_axis, AsBuiltMachine) else drawn, drawn)


def _make_clearance(
    content: MachineFile, five_axis: FiveAxis, nominal: HybridMachine, rods: RodsFile | None, places: RodPlaces | None
) -> Clearance | None:
    """The bodies of the machine file, None where it has none that distances could be computed from."""
    file = content.clearance
    measured = rods is not None and (rods.diameter_mm is not None or rods.cone_centre is not None)
    if file is None and not measured:
        return None
    rod_module: RodModule | None = None
    if measured and places is not None:
        rod_module = _make_rod_bodies(five_axis, nominal, places)
    elif measured and isinstance(nominal.module, RodModule):
        rod_module = nominal.module
    radius = None
    if rods is not None and rods.diameter_mm is not None and rod_module is not None:
        legs = list(dict.fromkeys(rod_module.rod_legs))
        diameters = rods.diameter_mm if isinstance(rods.diameter_mm, list) else [rods.diameter_mm] * len(legs)
        radius = np.array([0.5 * diameters[legs.index(leg)] for leg in rod_module.rod_legs])

    def convert_angle(value: float | None) -> float | None:
        return None if value is None else RAD_PER_DEG * value

    bodies = Bodies(
        minimum=file.minimum_mm if file else 0.0,
        rod_radius=radius,
        spindle_radius=0.5 * file.spindle_diameter_mm if file and file.spindle_diameter_mm else None,
        spindle_top=file.spindle_top_mm if file else 0.0,
        tool_radius=0.5 * file.tool_diameter_mm if file and file.tool_diameter_mm else None,
        platform=_stack_ends(file.platform_ends_mm) if file and file.platform_ends_mm else None,
        platform_radius=0.5 * file.platform_diameter_mm if file and file.platform_diameter_mm else 0.0,
        slider_cone=convert_angle(rods.slider_cone_deg) if rods else None,
        platform_cone=convert_angle(rods.platform_cone_deg) if rods else None,
        cone_centre=np.array(rods.cone_centre) if rods and rods.cone_centre else None,
    )
    return Clearance(bodies, rod_module, nominal.nose_offset, five_axis.spindle, content.table.radius)


def _stack_ends(points: list[list[float]]) -> tuple[np.ndarray, np.ndarray]:
    return np.array(points[0]), np.array(points[1])


# --- does the machine make sense -----------------------------------------------------------------


def solve_stored(machine: Machine) -> Iterator[tuple[str, tuple[float, ...], bool, Array]]:
    """Each stored position: its name, its numbers, whether there is a pose, and the joints."""
    stored = () if machine.home is None else ("g28", "g30", "park")
    for name in stored:
        home = getattr(machine.home, name)
        if home is None:
            continue
        point, frame = machine.place_stored(home), Frame()
        tip, angles = machine.coordinates.map_to_table(machine.coordinates.map_to_program(point, frame), frame)
        q, _platform, ok = machine.five_axis.solve(tip, angles, 0.0)
        yield name, home, bool(ok), q


def validate_machine(machine: Machine) -> list[Finding]:
    """What `machine validate` checks beyond the schema: every stored position can be reached.

    Returns
    -------
    list of Finding
        Empty when the machine is sound.
    """
    findings: list[Finding] = []
    for name, home, ok, q in solve_stored(machine):
        if not ok:
            findings.append(make_finding("VP501", f"home.{name} = {list(home)} is out of reach"))
            continue
        for column, value, low, high in zip(
            machine.columns, q, machine.limits.lower, machine.limits.upper, strict=True
        ):
            if not low <= value <= high:
                shown, bound = value * column.factor, (low if value < low else high) * column.factor
                text = f"home.{name} = {list(home)} needs {column.header} = {shown:.4f}, beyond its limit {bound:.4f}"
                findings.append(
                    make_finding("VP501", text, axis=column.joint, value=shown, limit=bound, unit=column.unit)
                )
    return findings
