"""The text of a machine file with another [as_built] table; everything else, comments too, stays as it is."""

import re
import tomllib
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.printable import format_json
from verne_post.base.text_marks import decode_text
from verne_post.base.units import MILLI
from verne_post.config.load import build_machine
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.model.deviations import ENTRIES, RODS, Deviations
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Machine

#: A header of a table or of an array of tables, alone on its line.
_HEADER: Final = re.compile(r"^\s*\[\[?\s*([\w.\-\"' ]+?)\s*\]\]?\s*(#.*)?$")
#: Decimals of mm and mrad: a thousandth of what any reading could tell.
DECIMALS: Final = 7


def write_machine_text(raw: bytes, deviations: Deviations, source: str, file_name: str) -> str:
    """The machine file with these deviations in [as_built], in place of any that it has.

    Raises
    ------
    InputError
        VP501: the file writes [as_built] in a way that cannot be replaced line by line.
    """
    text = decode_text(raw)
    kept = "".join(_drop_as_built(text)).rstrip() + "\n"
    written = kept + "\n" + "".join(format_as_built(deviations, source))
    before: dict[str, Any] = tomllib.loads(text)
    before.pop("as_built", None)
    try:
        after = tomllib.loads(written)
    except tomllib.TOMLDecodeError:
        after = {}
    after.pop("as_built", None)
    if before != after:
        text = f"{file_name}: as_built is not a table [as_built]; write it as a table, so that it can be replaced"
        raise make_input_error("VP501", text)
    return written


def _drop_as_built(text: str) -> Iterator[str]:
    """The lines of a file but for those under [as_built]."""
    inside = False
    for line in text.splitlines(keepends=True):
        header = _HEADER.match(line)
        if header:
            inside = re.split(r"\s*\.\s*", header[1])[0].strip("\"'") == "as_built"
        if not inside:
            yield line


def format_as_built(deviations: Deviations, source: str) -> Iterator[str]:
    """The lines of an [as_built] table."""
    yield (
        "[as_built]                          # deviations from the nominal machine, mm and mrad; see docs/as-built.md\n"
    )
    yield f"source = {format_json(source, ensure_ascii=False)}\n"
    for name, (key, shape, angle) in ENTRIES.items():
        values = np.asarray(getattr(deviations, name)) / (MILLI if angle else 1.0)
        if len(shape) == 1:
            yield f"{key} = {_list(values)}\n"
            continue
        yield f"{key} = [\n"
        names = [f"rod {rod}" for rod in RODS] if shape[0] == len(RODS) else ["leg I", "leg II", "leg III"]
        for row, remark in zip(values, names, strict=True):
            yield f"    {_list(row)},".ljust(52) + f"# {remark}\n"
        yield "]\n"


def _list(values: Array) -> str:
    return "[" + ", ".join(f"{value + 0.0:.{DECIMALS}f}" for value in np.round(values, DECIMALS) + 0.0) + "]"


def take_as_built_route(machine: Machine, raw: bytes, file_name: str) -> tuple[Machine, AsBuiltMachine]:
    """A machine with its as-built kinematics; a nominal one gets deviations of zero.

    Raises
    ------
    InputError
        VP501: the file does not say where the rods are.
    """
    if not isinstance(machine.five_axis, AsBuiltMachine):
        text = write_machine_text(raw, Deviations.build_nominal(), "nominal", file_name)
        machine = build_machine(text.encode(), file_name)
    assert isinstance(machine.five_axis, AsBuiltMachine)
    return machine, machine.five_axis
