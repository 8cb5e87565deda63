"""TOML files as people save them, and values as they stand in files that are made."""

import json
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from msgspec import Struct

from verne_post.base.numbers import format_fixed
from verne_post.base.printable import escape_unprinted
from verne_post.base.text_marks import UTF16, decode_text, is_utf16
from verne_post.model.findings import Finding, InputError, make_input_error

#: How a message of tomllib ends that names no line.
_AT_END: Final = " (at end of document)"


def read_toml(raw: bytes) -> dict[str, Any]:
    """The table in the bytes of a TOML file, with or without the mark of UTF-8 before it.

    Raises
    ------
    ValueError
        With why it is no TOML file, for a message: also for a number or a nesting beyond any such file.
    """
    if is_utf16(raw[:2]):
        raise ValueError(f"not a TOML file: {UTF16}")
    text = ""
    try:
        text = decode_text(raw)
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"not a TOML file: {_name_beginning(text, str(error))}") from None


def _name_beginning(text: str, message: str) -> str:
    """What is wrong with a TOML file; of what is open at the end of the file, with where that begins."""
    opening = r"^[ \t]*[^ \t\r\n].*" if message.startswith("Expected") else r"^[ \t]*[\w\"'][^=\n#\[]*="
    if "string" in message and (quotes := re.findall(r"\"{3}|'{3}", text)):
        opening = quotes[-1]
    *_others, last = [None, *re.finditer(opening, text, re.MULTILINE)]
    if last is None or not message.endswith(_AT_END):
        return message
    at = last.end() - len(last.group().lstrip())
    place = f"(at line {text.count(chr(10), 0, at) + 1}, column {at - text.rfind(chr(10), 0, at)})"
    return f"{message.removesuffix(_AT_END)}: what begins here is open up to the end of the file {place}"


def refuse_value(where: str, text: str) -> InputError:
    """VP507: what stands at a place of the file of a control cannot be taken."""
    return make_input_error("VP507", f"{where}: {text}")


class ImportedMachine(Struct, frozen=True):
    """A machine file as text, and what was left out or has to be looked at."""

    text: str
    findings: tuple[Finding, ...]


def show_number(value: float) -> str:
    """A number: nine decimals of a length are finer than any machine."""
    text = format_fixed(value, 9).rstrip("0")
    return f"{text}0" if text.endswith(".") else text


def show_list(values: Iterable[float]) -> str:
    """A list of numbers."""
    return f"[{', '.join(show_number(value) for value in values)}]"


def write_chain(tool: Sequence[str], part: Sequence[str]) -> list[str]:
    """Lines of the [chain] of a machine whose base frame is that of its coordinates, the tool upright at 0."""
    return [
        "[chain]                             # all joints at 0; mm, base frame: that of the machine's coordinates, z "
        "up",
        f"tool = {json.dumps(tool)}",
        f"part = {json.dumps(part)}",
        "gauge = [0.0, 0.0, 0.0]",
        "axis = [0.0, 0.0, 1.0]",
        "part_zero = [0.0, 0.0, 0.0]",
        "",
    ]


def write_joint(name: str, geometry: str, travel: str, speeds: Mapping[str, float | None]) -> str:
    """[joints.NAME]: lines of its geometry, the line of its travel or "", and the speeds that there are."""
    given = [f"{key} = {show_number(value)}" for key, value in speeds.items() if value is not None]
    return "\n".join([f"[joints.{name}]", *(line for line in (geometry, travel) if line), *given, ""])


def convert_speeds(
    file: str, joint: str, given: Mapping[str, tuple[str, float | None, float]]
) -> dict[str, float | None]:
    """Speeds of a joint of a control's file, in the units of the machine file; only jerk may be missing, as None.

    ``given`` has for velocity, acceleration and jerk the key of the control, its value, and a factor.

    Raises
    ------
    InputError
        VP507: a value is missing, or not above 0.
    """
    for kind, (key, value, _factor) in given.items():
        if (value is None and kind != "jerk") or (value is not None and value <= 0):
            found = "missing" if value is None else f"{value:g}"
            raise refuse_value(file, f"{key} of {joint} is {found}; expected a number above 0")
    return {kind: None if value is None else factor * value for kind, (_key, value, factor) in given.items()}


def list_jerkless(joints: Sequence[str]) -> str:
    """Keys of the joints whose text, of :func:`write_joint`, has no jerk; "" without one."""
    return ", ".join(joint.split("]", 1)[0][1:] for joint in joints if "\njerk = " not in joint)


def write_end(cycle: float, name: str, *groups: str) -> list[str]:
    """Lines of [control], cycle in s, and of the [provenance] of a machine that the file ``name`` specifies.

    ``groups`` are what it specifies beside chain, joints and control.
    """
    source = quote(f"specified in {name}")
    lines = [f"{group} = {source}" for group in ("chain", *groups, "joints", "control")]
    return ["[control]", f"cycle_s = {show_number(cycle)}", "", "[provenance]", *lines, ""]


def quote(text: str) -> str:
    """A string."""
    return json.dumps(escape_unprinted(text), ensure_ascii=False)
