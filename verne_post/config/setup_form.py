"""The file of a set-up as `verne-post setup` writes it: what is known, and marks for what is not."""

import math
import tomllib
from collections.abc import Container, Iterator, Mapping, Sequence
from typing import Any, Final

from msgspec import Struct

from verne_post.base.printable import join_names, make_printable
from verne_post.config.program_setup import TO_DECIDE, TO_MEASURE, TOOL_KEYS
from verne_post.config.setup_merge import merge_setup, show_key, turn_into_remark
from verne_post.config.toml_entries import Edit, UnknownLayoutError
from verne_post.model.findings import make_input_error
from verne_post.model.part_setup import WorkOffset

#: So many tools that are left out are named.
_MOST_IDLE: Final = 12


class Asked(Struct, frozen=True):
    """What the set-up of a program must say; as in :class:`~verne_post.app.setup_draft.SetupDraft`."""

    tools: Mapping[str, tuple[float | None, float | None]]
    wcs: Mapping[str, WorkOffset | None]
    codes: Mapping[str, str | None]
    tool_length: float | None
    needs_length: bool  #: That of the one tool, in place of ``tools``, is still to be measured.
    split: bool
    tapping: str  #: What the file says of rigid tapping; empty where the program has none.
    numbers: Mapping[str, int] = {}  #: Name of a tool -> its number, where somebody has given it.
    corners: Mapping[str, float] = {}


def write_setup(
    program: str, asked: Asked, remarks: Mapping[str, str], dialect: str, zero: str, idle: Sequence[str] = ()
) -> str:
    """The file of a program that has none, as TOML text.

    Parameters
    ----------
    remarks : mapping of str to str
        Number or name of a tool -> the remark of the program about it, which is repeated.
    zero : str
        The point that work offsets count from, in words.
    idle : sequence of str
        Tools that are known and not called, which are left out.
    """
    title = f"# set-up of {make_printable(program)}: mm and degrees\n"
    if idle:
        more = f" and {len(idle) - _MOST_IDLE} more" if len(idle) > _MOST_IDLE else ""
        named = ", ".join(map(make_printable, idle[:_MOST_IDLE]))
        title += f"# tools that are given and not called are left out: {named}{more}\n"
    return merge_setup(title, list_edits(asked, {}, remarks), headers=describe_tables(dialect, zero))


class Extended(Struct, frozen=True):
    """A set-up that was there, with what its program needs."""

    text: str
    added: tuple[tuple[str, ...], ...]  #: Keys that are new, or have a value in place of a mark.
    unused: tuple[tuple[str, str], ...]  #: Keys of it that the program does not use.
    replaced: tuple[tuple[str, ...], ...]  #: Keys that are a remark now, because what is added excludes them.
    tool_file: str  #: The file that has the tools, which is not changed; empty where the set-up has them.


def extend_setup(
    text: str,
    asked: Asked,
    used: Container[tuple[str, str]] | None,
    remarks: Mapping[str, str],
    dialect: str,
    zero: str,
) -> Extended:
    """A set-up with what it lacks; what is filled in there stays, and gets a remark where the program does not use it.

    Parameters
    ----------
    text : str
        The file, which can be read as a set-up.
    used : container of tuple or None
        Table and name of each key that the program uses; None where nobody knows.
    dialect, zero : str
        As :func:`write_setup` has them.

    Raises
    ------
    InputError
        VP503: the file is written in a way that is not seen here; the message has what it lacks.
    """
    data = tomllib.loads(text)
    keys = [(table, key) for table in ("tools", "wcs", "remap") for key in data.get(table, {})]
    unused = [] if used is None else [key for key in keys if (key[0], normalise_key(*key)) not in used]
    known = [] if used is None else [key for key in keys if key not in unused]
    replaced = [("tool_length",)] if asked.tools and "tool_length" in data else []
    edits = list(list_edits(asked, {key: data[key] for key in data if (key,) not in replaced}, remarks))
    try:
        for key in replaced:
            text = turn_into_remark(text, key)
        merged = merge_setup(text, edits, unused, known, describe_tables(dialect, zero))
    except UnknownLayoutError:
        lines = ", ".join(f"{show_key(edit.key)} = {edit.value}" for edit in edits)
        raise make_input_error(
            "VP503", f"setup cannot add to a file that is laid out like this; write there: {lines or 'nothing'}"
        ) from None
    tool_file = next((str(data[key]) for key in ("tool_table", "tool_lengths") if key in data), "")
    return Extended(merged, tuple(edit.key for edit in edits), tuple(unused), tuple(replaced), tool_file)


def describe_tables(dialect: str, zero: str) -> dict[str, str]:
    """Remarks behind the headers of a set-up, which say what each table holds."""
    others = {
        "heidenhain": "; presets 1 to 9 (cycle 247) are G54 to G59.3",
        "siemens": "; G505 to G509 are G58 to G59.3, and G510 to G557 are G54.1P1 to G54.1P48",
    }
    return {
        "tools": "length: from the gauge line of the spindle to the tip",
        "wcs": f"[x, y, z] of the part zero, from {zero}; a fourth number is the turn of the "
        f"part{others.get(dialect, '')}",
        "remap": '"event" (clamps and the like), "ignore", "M3" to "M6" (spindle, tool change), "tcp on", "tcp off"',
    }


def list_edits(asked: Asked, data: Mapping[str, Any], remarks: Mapping[str, str]) -> Iterator[Edit]:
    """What is to be written into a set-up that says ``data``; what is filled in there stays."""
    is_open = not data.keys() & set(TOOL_KEYS)
    if asked.tool_length is not None and (is_open or data.get("tool_length") == TO_MEASURE):
        yield Edit(("tool_length",), f"{asked.tool_length:g}")
    elif asked.needs_length and is_open:
        yield Edit(("tool_length",), _show_size(None), "from the gauge line of the spindle to the tip")
    if asked.split and "split_at_stops" not in data:
        yield Edit(("split_at_stops",), "true", "one file of setpoints from stop to stop; convert needs -o NAME.csv")
    if asked.tapping and "tapping" not in data:
        remark = '"feed" where the control that executes the setpoints couples the spindle'
        yield Edit(("tapping",), f'"{asked.tapping}"', remark if asked.tapping == "refuse" else "")
    if not data.keys() & (set(TOOL_KEYS) - {"tools"}):
        yield from _list_tools(asked, data.get("tools", {}), remarks)
    for table, values in (
        ("wcs", {name: _show_place(place) for name, place in asked.wcs.items()}),
        ("remap", {code: f'"{meaning or TO_DECIDE}"' for code, meaning in asked.codes.items()}),
    ):
        known = data.get(table, {})
        spelled = {normalise_key(table, key): key for key in known}
        for name, value in values.items():
            key = spelled.get(name, name)
            if key not in known or (known[key] in (TO_MEASURE, TO_DECIDE) and value != f'"{known[key]}"'):
                yield Edit((table, key), value)


def _list_tools(asked: Asked, known: Mapping[str, Any], remarks: Mapping[str, str]) -> Iterator[Edit]:
    spelled = {normalise_key("tools", key): key for key in known}
    for name, (length, diameter) in asked.tools.items():
        key = spelled.get(name, name)
        if key not in known:
            sizes = [
                *([f"number = {asked.numbers[name]}"] if name in asked.numbers else []),
                *([f"length = {_show_size(length)}"] if length is None or not math.isnan(length) else []),
                *([f"diameter = {_show_size(diameter)}"] if diameter != 0 else []),
                *([f"corner_radius = {_show_size(asked.corners[name])}"] if name in asked.corners else []),
            ]
            yield Edit(("tools", key), f"{{ {', '.join(sizes)} }}", remarks.get(name, ""))
            continue
        if length is not None and not math.isnan(length) and known[key].get("length", TO_MEASURE) == TO_MEASURE:
            yield Edit(("tools", key, "length"), _show_size(length))
        held = known[key].get("diameter", 0)
        if (diameter is None and held == 0) or (diameter and held == TO_MEASURE):
            yield Edit(("tools", key, "diameter"), _show_size(diameter))


def normalise_key(table: str, key: str) -> str:
    """A key of a set-up as messages and findings spell it."""
    if table == "tools":
        return str(int(key)) if key.isdecimal() else key
    return key.strip().upper() if table == "wcs" else key


def list_missing(missing: Mapping[str, list[str]]) -> str:
    """``the length of tools 1 and 5, the place of G54``; empty where nothing is missing."""
    texts = []
    for what, names in missing.items():
        if what == "tool length":
            texts += [f"the {what}"] if names else []
            continue
        tools = what in ("length", "diameter", "corner_radius")
        whose = f"tool{'s' if len(names) > 1 else ''} " if tools else ""
        texts += [f"the {what} of {whose}{join_names([make_printable(name) for name in names])}"] if names else []
    return ", ".join(texts)


def _show_size(value: float | None) -> str:
    return '"measure"' if value is None else f"{value:.9g}"


def _show_place(offset: WorkOffset | None) -> str:
    if offset is None:
        return '"measure"'
    turn = [offset.turn_deg] if offset.turn_deg else []
    return f"[{', '.join(f'{value:.9g}' for value in (*offset.origin_mm, *turn))}]"
