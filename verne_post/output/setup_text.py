"""The file of a set-up as `verne-post setup` writes it: what is known, and marks for what is not."""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from verne_post.base.printable import make_printable
from verne_post.model.part_setup import WorkOffset

#: Lines of a program in which remarks about its tools are looked for.
HEAD_LINES: Final = 400
_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
#: A remark about a tool: ``(T5 D=6. - BALL)``, ``; T="BALL_6" D=6.``, ``;  #5 BALL_6 D=6`` of Klartext.
_REMARK: Final = re.compile(
    r"^\s*(?:N?\d+\s*)?[(;]\s*(?:T(?:OOL)?\s*=?\s*|#)(?:0*(?P<number>\d+)\b|\"(?P<name>[^\"]+)\")[\s:="
    r"|,-]*(?P<text>.*?)\)?\s*$",
    re.IGNORECASE,
)


def write_setup(
    program: str,
    tools: Mapping[str, tuple[float | None, float | None]],
    wcs: Mapping[str, WorkOffset | None],
    codes: Mapping[str, str | None],
    tool_length: float | None,
    split: bool,
    taps: bool,
    head: Iterable[str],
    dialect: str,
) -> str:
    """The file as TOML text; arguments as in :class:`~verne_post.app.setup_draft.SetupDraft`.

    Parameters
    ----------
    program : str
        Its name.
    head : iterable of str
        First lines of the program, whose remarks about tools are repeated.
    dialect : str
        Its language.
    """
    open_marks = any(None in sizes for sizes in tools.values()) or None in wcs.values()
    todo = "; write numbers where it says measure" if open_marks else ""
    lines = [f"# set-up of {make_printable(program)}: mm and degrees{todo}"]
    if tool_length is not None:
        lines.append(f"tool_length = {tool_length:g}")
    if split:
        lines.append("split_at_stops = true  # one file of setpoints from stop to stop; convert needs -o NAME.csv")
    if taps:
        lines.append('tapping = "refuse"  # "feed" where the control that executes the setpoints couples the spindle')
    if tools:
        remarks = _find_remarks(head)
        lines += ["", "[tools]  # length: from the gauge line of the spindle to the tip"]
        lines += [_describe_tool(name, *sizes, remarks.get(name, "")) for name, sizes in tools.items()]
    if wcs:
        lines += [
            "",
            "[wcs]  # [x, y, z] of the part zero: x, y from the axis of C, z above the table face; a fourth number is "
            "the turn of the part",
            *(["# presets 1 to 9 (cycle 247) are G54 to G59.3"] if dialect == "heidenhain" else []),
        ]
        lines += [f"{quote_key(name)} = {_show_place(offset)}" for name, offset in wcs.items()]
    if codes:
        lines += ["", '[remap]  # what codes and names of the builder mean: "ignore", "event", "tcp on" or "tcp off"']
        lines += [f'{quote_key(code)} = "{meaning or "decide"}"' for code, meaning in codes.items()]
    return "\n".join([*lines, ""])


def list_missing(missing: Mapping[str, list[str]]) -> str:
    """``the length of tools 1 and 5, the place of G54``; empty where nothing is missing."""
    texts = []
    for what, names in missing.items():
        tools = what in ("length", "diameter")
        whose = f"tool{'s' if len(names) > 1 else ''} " if tools else ""
        texts += [f"the {what} of {whose}{' and '.join(make_printable(name) for name in names)}"] if names else []
    return ", ".join(texts)


def _describe_tool(name: str, length: float | None, diameter: float | None, remark: str) -> str:
    sizes = [f"length = {_show_size(length)}", *([f"diameter = {_show_size(diameter)}"] if diameter != 0 else [])]
    return f"{quote_key(name)} = {{ {', '.join(sizes)} }}{f'  # {remark}' if remark else ''}"


def _show_size(value: float | None) -> str:
    return '"measure"' if value is None else f"{value:.9g}"


def _show_place(offset: WorkOffset | None) -> str:
    if offset is None:
        return '"measure"'
    turn = [offset.turn_deg] if offset.turn_deg else []
    return f"[{', '.join(f'{value:.9g}' for value in (*offset.origin_mm, *turn))}]"


def quote_key(name: str) -> str:
    """A key of TOML, in quotes where it needs them."""
    if _BARE_KEY.fullmatch(name):
        return name
    escaped = "".join(
        f"\\u{ord(one):04x}" if ord(one) < 32 or ord(one) == 127 else f"\\{one}" if one in '"\\' else one
        for one in name
    )
    return f'"{escaped}"'


def _find_remarks(head: Iterable[str]) -> dict[str, str]:
    """Number or name of a tool -> the first remark of the program that begins with it."""
    found: dict[str, str] = {}
    for number, text in _read_remarks(head):
        if text:
            found.setdefault(number, make_printable(text))
    return found


def _read_remarks(head: Iterable[str]) -> Iterator[tuple[str, str]]:
    for line in head:
        if match := _REMARK.match(line):
            yield match["number"] or match["name"], match["text"].strip()
