"""TOML files as people save them, and values as they stand in files that are made."""

import json
import tomllib
from collections.abc import Iterable
from typing import Any

from msgspec import Struct

from verne_post.base.numbers import format_fixed
from verne_post.base.printable import escape_unprinted
from verne_post.base.text_marks import UTF16, decode_text, is_utf16
from verne_post.model.findings import Finding


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


def write_end(cycle: float, name: str) -> list[str]:
    """Lines of [control], cycle in s, and of the [provenance] of a machine that the file ``name`` specifies."""
    source = quote(f"specified in {name}")
    groups = [f"{group} = {source}" for group in ("chain", "joints", "control")]
    return ["[control]", f"cycle_s = {show_number(cycle)}", "", "[provenance]", *groups, ""]


def quote(text: str) -> str:
    """A string."""
    return json.dumps(escape_unprinted(text), ensure_ascii=False)
