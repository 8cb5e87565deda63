"""TOML files as people save them, and values as they stand in files that are made."""

import json
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from msgspec import Struct

from verne_post.base.numbers import format_fixed
from verne_post.base.printable import escape_unprinted
from verne_post.base.text_marks import UTF16, decode_text, is_utf16
from verne_post.model.findings import Finding, InputError, make_input_error


def read_toml(raw: bytes) -> dict[str, Any]:
    """The table in the bytes of a TOML file, with or without the mark of UTF-8 before it.

    Raises
    ------
    ValueError
        With why it is no TOML file, for a message: also for a number or a nesting beyond any such file.
    """
    if is_utf16(raw[:2]):
        raise ValueError(f"not a TOML file: {UTF16}")
    try:
        return tomllib.loads(decode_text(raw))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"not a TOML file: {error}") from None


#: A key, which may be quoted and have dots, and what follows it.
_KEY: Final = re.compile(r"\s*((?:\"[^\"]*\"|'[^']*'|[\w-]+)(?:\s*\.\s*(?:\"[^\"]*\"|'[^']*'|[\w-]+))*)\s*=(.*)")
_HEAD: Final = re.compile(r"\s*(\[\[?)([^\]]+)\]")
#: Text in one line whose brackets count for nothing.
_NO_BRACKETS: Final = re.compile(r"\"(?:[^\"\\]|\\.)*\"|'[^']*'|#.*")
#: Where the settings stand in a file of several tools.
_OF_TOOLS: Final = "tool.verne-post."


def find_key_line(text: str, sentence: str) -> int | None:
    """The line, from 1, of what a sentence about a TOML file begins with: a key, its table where it is missing.

    Of a mistake of the syntax it is the line that the sentence names. None where no line is meant.
    """
    if place := re.search(r"\(at line (\d+), column \d+\)$", sentence):
        return int(place[1])
    said = re.sub("['\"]", "", sentence).lstrip("[")
    best, line = "", None
    for name, number in _list_keys(text):
        # "wcs: G540 is no work system" is about wcs.G540, if there is one
        if len(name) > len(best) and any(
            re.match(re.escape(name) + r"(?![\w-])", one) for one in (said, said.replace(": ", ".", 1))
        ):
            best, line = name, number
    return line


def _list_keys(text: str) -> Iterator[tuple[str, int]]:
    """Keys and tables with their names from the top on, without quotes, and their lines; not those of inline tables."""
    table, depth, until = "", 0, ""
    numbers: dict[str, int] = {}
    for number, line in enumerate(text.split("\n"), 1):
        value = line
        if until:
            if until in line:
                until = ""
            continue
        if not depth and (head := _HEAD.match(line)):
            table = re.sub("['\"\\s]", "", head[2])
            if head[1] == "[[":
                numbers[table] = numbers.get(table, -1) + 1
                table += f".{numbers[table]}"
            yield table.removeprefix(_OF_TOOLS), number
            continue
        if not depth and (key := _KEY.match(line)):
            name = f"{table}." if table else ""
            yield (name + re.sub("['\"\\s]", "", key[1])).removeprefix(_OF_TOOLS), number
            value = key[2]
        until = next((mark for mark in ('"""', "'''") if value.count(mark) % 2), "")
        value = "" if until else _NO_BRACKETS.sub("", value)
        depth += sum(value.count(one) for one in "[{") - sum(value.count(one) for one in "]}")


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
