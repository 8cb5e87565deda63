"""A table of options in a file: what is wrong with it."""

import json
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Annotated, Any, Literal

from msgspec import field

from verne_post.base.suggestions import suggest
from verne_post.config.machine_paths import find_meant_machine, list_machines
from verne_post.config.sentences import Table
from verne_post.model.control_keys import KEYS
from verne_post.model.findings import UsageError
from verne_post.model.options import check_value


class CheckFile(Table, frozen=True, kw_only=True):
    """[check]: which findings count; ``baseline`` is relative to the folder of the settings file."""

    select: Annotated[list[str], "codes that alone count, by how they begin"] = field(default_factory=list)
    ignore: Annotated[list[str], "codes that do not count, by how they begin"] = field(default_factory=list)
    severity: Annotated[dict[str, Literal["error", "warning", "note"]], "another severity, by code"] = field(
        default_factory=dict
    )
    fail_level: Annotated[Literal["error", "warning"] | None, "warning: warnings too give exit status 1"] = None
    exclude: Annotated[
        list[str], "patterns of programs that are not checked alone, in the folder of the settings file"
    ] = field(default_factory=list)
    baseline: Annotated[str | None, "file of findings that are accepted, in the folder of the settings file"] = None


def find_tables(tables: Mapping[str, Iterable[str]], check: str = "[check]") -> dict[str, str]:
    """Keys, and where each belongs: in tables, in those of controls, or in ``check``."""
    places: dict[str, list[str]] = {}
    controls = {f"[{dialect}]": kind.__struct_fields__ for dialect, kind in KEYS.items()}
    for table, keys in {**tables, **controls, check: CheckFile.__struct_fields__}.items():
        for key in keys:
            if key != "tools" or table not in controls:  # of tools people mean the lengths, not the names
                places.setdefault(key, []).append(table)
    return {key: f"{key} belongs into {' or '.join(where)}" for key, where in places.items()}


def find_wrong_options(
    given: dict[str, Any],
    allowed: Sequence[str],
    others: Sequence[str] = (),
    kind: str = "a settings file",
    elsewhere: Mapping[str, str] = MappingProxyType({}),
) -> list[str]:
    """What is wrong with a table of options, as sentences: a name that is none of those allowed, or a value.

    Parameters
    ----------
    others : sequence of str
        Names that the table may have beside options.
    kind : str
        Of the file, in words.
    elsewhere : mapping
        Names that people write, and where what they mean stands.
    """
    found = []
    for name, value in given.items():
        if name == "machine" and name not in others and name not in elsewhere:
            found.append(f"machine: {kind} does not choose the machine; {_say_where_machine_is_chosen(value)}")
        elif name == "options" and name not in allowed and name not in others and name not in elsewhere:
            found.append(
                f"options: the options of {kind} belong at its top; delete the line [options], a table of settings"
            )
        elif name not in allowed:
            word = name.lower().replace("-", "_")
            hint = f"; {elsewhere[word]}" if word in {*elsewhere} - {*allowed} else _suggest(name, [*allowed, *others])
            found.append(f"{name}: this is no option of {kind}{hint}")
        else:
            try:
                check_value(name, value)
            except UsageError as error:
                found.append(f"{error.option} = {error.reason}")
    return found


def _suggest(name: str, known: Sequence[str]) -> str:
    return f"; did you mean {name.lower()}?" if name.lower() in known else suggest(name, known)


def _say_where_machine_is_chosen(value: Any) -> str:
    """Where to write the machine that a set-up names; of a name that no machine has, the one that is meant."""
    more = ""
    if isinstance(value, str) and value not in list_machines() and not value.endswith(".toml"):
        more, value = f"; no machine is named {value}, see verne-post machine list", find_meant_machine(value) or "NAME"
    return (
        f"write machine = {json.dumps(value, default=str)} in the settings file verne-post.toml, above its tables, or "
        f"give --machine{more}"
    )
