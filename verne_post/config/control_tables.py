"""Tables of settings and set-ups that say what a control's builder has chosen: [remap], [siemens] and the like."""

from collections.abc import Iterator, Mapping
from typing import Any

from verne_post.gcode.user_meanings import refuse_known_meanings
from verne_post.model.control_keys import KEYS, read_keys
from verne_post.model.option_checks import check_remap
from verne_post.model.part_setup import FIRST_NAMED_TOOL


def find_wrong_codes(remap: Mapping[str, str]) -> Iterator[str]:
    """Why codes of [remap] cannot be given their meanings, as sentences."""
    for code, meaning in remap.items():
        try:
            refuse_known_meanings(check_remap({code: meaning}))
        except ValueError as error:
            yield f"remap.{error}"


def find_wrong_keys(control: Mapping[str, Mapping[str, object]], elsewhere: Mapping[str, str]) -> Iterator[str]:
    """What is wrong with keys of controls, by dialect, as sentences; of keys ``elsewhere``, where they belong."""
    for dialect, given in control.items():
        misplaced = [name for name in given if name in elsewhere and name not in KEYS[dialect].__struct_fields__]
        yield from (f"{dialect}.{name} is not a key of this control; {elsewhere[name]}" for name in misplaced)
        keys = {name: value for name, value in given.items() if name not in misplaced}
        try:
            read_keys(KEYS[dialect], keys)
        except ValueError as error:
            yield f"{dialect}.{error}"


def drop_counted_names(table: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Keys by dialect without tools that have only a name: a stronger tool table counts its own anew."""
    return {
        dialect: {
            key: {name: number for name, number in value.items() if number < FIRST_NAMED_TOOL}
            if key == "tools"
            else value
            for key, value in keys.items()
        }
        for dialect, keys in table.items()
    }


def merge_keys(*tables: Mapping[str, Mapping[str, object]]) -> dict[str, dict[str, object]]:
    """Keys by dialect of several places, the weaker first; names of tools, and pitches, are collected."""
    merged: dict[str, dict[str, object]] = {}
    for table in tables:
        for dialect, keys in table.items():
            if not keys:
                continue
            known = merged.setdefault(dialect, {})
            both = {
                name: {**known[name], **value}  # type: ignore[dict-item]
                for name, value in keys.items()
                if isinstance(value, Mapping) and isinstance(known.get(name), Mapping)
            }
            known.update({**keys, **both})
    return merged
