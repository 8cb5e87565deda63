"""Was a setpoint file made from what lies before us? Its side-car against program, machine file, offsets, tools, options."""

import json
from collections.abc import Iterator
from typing import Any

from verne_post.base.long_text import Text, sha256
from verne_post.model.findings import Finding, InputError, finding
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.output.summary import options_record

#: How options are called in messages, where their key does not say it.
_NAMES = {"wcs": "work offset", "tools": "tool"}
#: Options that say how rows are planned, judged or written, and not what the tool does.
_BESIDE = frozenset({
    "accept_rounding", "decimals", "override", "slow_start_s", "solver", "quality", "keep_out", "stock", "tool_shapes",
})  # fmt: skip


def read_side_car(text: str, name: str) -> dict[str, Any]:
    """What ``--meta`` wrote.

    Raises
    ------
    InputError
        VP020: not such a file.
    """
    try:
        data = json.loads(text)
        _ = data["program"]["sha256"], data["machine"]["sha256"], data["options"].items()
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(finding("VP020", f"{name}: not a side-car of --meta: {error!r}")) from None
    return dict(data)


def changed_since(side_car: dict[str, Any], source: Text, machine: Machine, options: Options) -> list[Finding]:
    """VP414 for everything that is not what it was when the side-car was written.

    Lengths and offsets are named with both values. ``[length, diameter]`` of tools, ``[x, y, z, turn]`` of offsets.
    """
    found = []
    if side_car["program"]["sha256"] != sha256(source):
        found.append(f"the program is not the one that it was made from ({side_car['program'].get('name')})")
    if side_car["machine"]["sha256"] != machine.sha256:
        found.append(f"the machine file is not the one that it was made with ({side_car['machine'].get('name')})")
    # as JSON has them: tuples are lists there
    now = json.loads(json.dumps(options_record(options)))
    for key, value in now.items():
        if key in side_car["options"] and key not in _BESIDE:
            found += _differences(_NAMES.get(key, key), side_car["options"][key], value)
    return [finding("VP414", f"the setpoint file is out of date: {text}") for text in found]


def _differences(name: str, before: object, now: object) -> Iterator[str]:
    if before == now:
        return
    if isinstance(before, dict) and isinstance(now, dict):
        for key in sorted({*before, *now}):
            if before.get(key) != now.get(key):
                yield f"{name} {key} was {_shown(before.get(key))}, and is {_shown(now.get(key))}"
    else:
        yield f"{name} was {_shown(before)}, and is {_shown(now)}"


def _shown(value: object) -> str:
    return "not given" if value is None else json.dumps(value)
