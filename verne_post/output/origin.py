"""Is a setpoint file up to date? Its side-car is compared with program, machine file, offsets, tools and options."""

import json
from collections.abc import Iterator
from typing import Any

from verne_post.base.long_text import Text, sha256
from verne_post.model.findings import Finding, InputError, finding
from verne_post.model.machine import Machine
from verne_post.model.options import Changes, Options, about, key_of
from verne_post.output.side_car import SIDE_CAR_SCHEMA

#: Names of options in messages, where the key does not say it.
_NAMES = {"wcs": "work offset", "tools": "tool"}


def read_side_car(text: str, name: str) -> dict[str, Any]:
    """Read what ``--meta`` wrote.

    Raises
    ------
    InputError
        VP020: not such a file.
    """
    try:
        data = json.loads(text)
        schema, _ = data["schema"], (data["program"]["sha256"], data["machine"]["sha256"], data["options"].items())
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(finding("VP020", f"{name}: not a side-car of --meta: {error!r}")) from None
    if schema != SIDE_CAR_SCHEMA:
        text = f"{name}: a side-car of layout {schema}; this version reads layout {SIDE_CAR_SCHEMA}: convert the program again"
        raise InputError(finding("VP020", text))
    return dict(data)


def changed_since(side_car: dict[str, Any], source: Text, machine: Machine, options: Options) -> list[Finding]:
    """Report each difference from the time when the side-car was written as VP414.

    Options that change the tool's motion are compared. The message has both values.
    """
    texts = []
    if side_car["program"]["sha256"] != sha256(source):
        texts.append(f"the program is not the one that it was made from ({side_car['program'].get('name')})")
    if side_car["machine"]["sha256"] != machine.sha256:
        texts.append(f"the machine file is not the one that it was made with ({side_car['machine'].get('name')})")
    now = options.record()
    for name in Options.model_fields:
        key = key_of(name)
        if about(name).changes == Changes.MOTION and key in now:
            texts += _differences(_NAMES.get(name, key), side_car["options"].get(key), now[key])
    return [finding("VP414", f"the setpoint file is out of date: {text}") for text in texts]


def _differences(name: str, before: object, now: object) -> Iterator[str]:
    """Say what changed in one option, key by key."""
    if before == now:
        return
    if isinstance(before, dict) and isinstance(now, dict):
        for key in sorted({*before, *now}):
            if before.get(key) != now.get(key):
                yield f"{name} {key} was {_show(before.get(key))}, and is {_show(now.get(key))}"
    else:
        yield f"{name} was {_show(before)}, and is {_show(now)}"


def _show(value: object) -> str:
    return "not given" if value is None else json.dumps(value)
