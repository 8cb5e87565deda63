"""What a program needs from its set-up, and what of that nobody has given."""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.app.assemble import SPLIT_KEY, assemble, build_interpreter_setup, find_stops
from verne_post.base.long_text import Text
from verne_post.config.control_tables import merge_keys
from verne_post.gcode.languages import NO_PROGRAM
from verne_post.gcode.machining.holes import TAPPING_KEY
from verne_post.gcode.missing_setup import LENGTH_KEY
from verne_post.gcode.program_error import CHECK_CALLER, LIKE_SUBPROGRAM
from verne_post.gcode.read import read_past_errors
from verne_post.model.control_keys import NAMING_TOOLS
from verne_post.model.findings import Finding, InputError
from verne_post.model.machine import Machine
from verne_post.model.moves import ZERO9, Moves, list_tool_changes
from verne_post.model.options import Options
from verne_post.model.part_setup import FIRST_NAMED_TOOL, SYSTEM_NUMBERS, Tool, WorkOffset, name_system

#: A finding may hide another one until it is settled: a program is read again as often as that.
MOST_READINGS: Final = 8
#: Length and diameter of a tool that is not known while others are looked for, mm; and two others: an error that is not
#: the same with both is one of the stand-ins.
STAND_INS_MM: Final = (100.0, 1.0)
OTHER_STAND_INS_MM: Final = (130.0, 40.0)
#: Keys in no table.
_LONE_KEYS: Final = (SPLIT_KEY, TAPPING_KEY, LENGTH_KEY)
#: What of a tool a set-up may say, and nobody has said.
UNKNOWN: Final = (math.nan, 0.0)


class SetupDraft(Struct, frozen=True):
    """What the set-up of a program must say."""

    #: Number or name -> length and diameter, mm; None for one that is needed and not known. An unneeded length is
    #: nan, an unneeded diameter 0.
    tools: Mapping[str, tuple[float | None, float | None]]
    #: Name of a work system -> where it is on the table; None where nobody has said.
    wcs: Mapping[str, WorkOffset | None]
    codes: Mapping[str, str | None]  #: User-defined code -> its meaning; None where nobody has said.
    tool_length: float | None  #: Of the one tool, mm, in place of ``tools``.
    split: bool  #: The setpoints are cut where the machine waits for a person.
    needs_length: bool  #: It calls no tool, and nobody has said how long the one is that it has.
    taps: bool  #: It has rigid tapping, and nobody has said that the control couples the spindle.
    others: tuple[Finding, ...]  #: Errors of the program that no set-up settles.
    #: Table and name of each key that the program asks for, or whose tool or work system it uses; None where nobody
    #: knows, because of errors.
    used: frozenset[tuple[str, str]] | None = None
    #: Why the text is a subprogram, or may be one: a tool is not asked for where another program brings it.
    subprogram: Finding | None = None
    corners: Mapping[str, float] = {}  #: Number or name of a tool -> the corner radius of its cutter, mm, where given.
    moves: Moves | None = None  #: Of the program with stand-ins for what is missing; None where it has other errors.

    @property
    def missing(self) -> dict[str, list[str]]:
        """What is still to be said, by what it is: lengths and diameters of tools, places, meanings."""
        return {
            "length": [name for name, (length, _) in self.tools.items() if length is None],
            "diameter": [name for name, (_, diameter) in self.tools.items() if diameter is None],
            "place": [name for name, place in self.wcs.items() if place is None],
            "meaning": [code for code, meaning in self.codes.items() if meaning is None],
            "tool length": ["tool_length"] if self.needs_length else [],
            "choice": ["tapping"] if self.taps else [],
        }


def draft_setup(source: Text, machine: Machine, options: Options) -> SetupDraft:
    """Read a program as often as something is missing, each time with stand-ins for what is.

    Parameters
    ----------
    options : Options
        With what is known already: tools, work offsets, meanings of codes.
    """
    tools = {str(number): _read_sizes(tool) for number, tool in (options.tools or {}).items()}
    names = {number: name for name, number in list_tool_numbers(options).items()}
    tools = {names.get(int(number), number): sizes for number, sizes in tools.items()}
    corners = {
        names.get(number, str(number)): tool.corner_radius
        for number, tool in (options.tools or {}).items()
        if tool.corner_radius is not None
    }
    wcs: dict[str, WorkOffset | None] = {name_system(system): place for system, place in options.wcs.items()}
    codes: dict[str, str | None] = dict(options.remap)
    keys: dict[tuple[str, ...], None] = {}
    subprogram = None
    for _ in range(MOST_READINGS):
        found, hidden, moves = _find_errors(source, machine, _assume(options, keys))
        subprogram = subprogram or next((item for item in found if item.message.endswith(CHECK_CALLER)), None)
        new = [key for item in (*found, *hidden) for key in item.settled_by if key not in keys]
        if not new or any(item.code == NO_PROGRAM or item.message.startswith(LIKE_SUBPROGRAM) for item in found):
            break
        keys |= dict.fromkeys(new)
    split = options.split_at_stops or SPLIT_KEY in keys
    for kind, name, *what in (key for key in keys if key not in _LONE_KEYS):
        if kind == "tools":
            name = names.get(int(name), name) if name.isdecimal() else name
            length, diameter = tools.get(name, UNKNOWN)
            tools[name] = (length, None) if what == ["diameter"] else (None, diameter)
        else:
            (wcs if kind == "wcs" else codes)[name] = None
    others = _select_others(found)
    if others and any(key[0] in ("tools", "wcs") for key in keys):
        again, *_ = _find_errors(source, machine, _assume(options, keys, OTHER_STAND_INS_MM))
        same = {(item.line, item.code, item.message) for item in again}
        others = tuple(item for item in others if (item.line, item.code, item.message) in same)
    needs_length = LENGTH_KEY in keys and not tools
    tool_length = None if needs_length else _assume(options, keys).tool_length
    return SetupDraft(
        {} if tool_length is not None else tools,
        wcs,
        codes,
        tool_length,
        split,
        needs_length,
        TAPPING_KEY in keys,
        others,
        subprogram=subprogram,
        corners=corners,
        moves=moves,
    )


def find_used(source: Text, machine: Machine, options: Options, draft: SetupDraft) -> SetupDraft:
    """A draft of the same arguments that knows which keys of a set-up the program uses.

    With a stock, of the options or of the program, it asks for the diameters of the tools among them: as a thin line a
    tool leaves nearly all of it.
    """
    if draft.moves is None:
        return draft
    bare = options.changed(tools=None, tool_length=None, wcs={}, unmeasured_wcs={}, remap={})
    needed = draft_setup(source, machine, bare)
    if needed.moves is None:
        return draft
    keys = {("tools", name) for name in needed.tools} | {("wcs", name) for name in needed.wcs}
    keys |= {("remap", code) for code in needed.codes}
    names = {number: name for name, number in list_tool_numbers(options).items()}
    moves = draft.moves
    events = list(moves.events)
    if options.block_delete:  # a switch of the control: the same set-up serves when it is off
        whole = build_interpreter_setup(machine, options.changed(block_delete=False))
        events += read_past_errors(source, whole)[0].events
    for change, number in list_tool_changes(events):
        called = str(number), names.get(number), change.data.get("name")
        keys |= {("tools", str(name)) for name in called if name}
    keys |= {("wcs", name_system(moves.frames[index].system)) for index in np.unique(moves.frame)}
    keys |= {("tools", names[int(name)]) for _table, name in keys if name.isdecimal() and int(name) in names}
    tools = dict(draft.tools)
    if options.stock is not None or moves.stock is not None:
        shaped = {names.get(number, str(number)) for number in options.tool_shapes}
        asked = [name for name in tools if ("tools", name) in keys and name not in shaped]
        tools |= {name: (tools[name][0], tools[name][1] or None) for name in asked}
    return replace(draft, used=frozenset(keys), tools=tools)


def _read_sizes(tool: Tool) -> tuple[float | None, float | None]:
    return math.nan if tool.unmeasured else tool.offset[2], tool.diameter


def list_tool_numbers(options: Options) -> dict[str, int]:
    """Names of tools -> their numbers, whatever the control."""
    return {name: number for keys in options.control.values() for name, number in keys.get("tools", {}).items()}


def _find_errors(
    source: Text, machine: Machine, options: Options
) -> tuple[tuple[Finding, ...], tuple[Finding, ...], Moves | None]:
    """The findings of a program, what of a set-up it lacks in lines that an error hides, and the moves without one."""
    try:
        program = assemble(source, machine, options)
    except InputError as error:
        found = error.findings
    else:
        return program.findings, (), program.moves
    if not _select_others(found):
        return found, (), None
    moves, hidden = read_past_errors(source, build_interpreter_setup(machine, options))
    stops = () if options.split_at_stops else find_stops(moves, optional_stop=options.optional_stop)
    return found, (*hidden, *stops), None


def _select_others(found: Iterable[Finding]) -> tuple[Finding, ...]:
    """The errors that no set-up settles."""
    return tuple(item for item in found if item.severity == "error" and not item.settled_by)


def _assume(
    options: Options, keys: Mapping[tuple[str, ...], None], sizes_mm: tuple[float, float] = STAND_INS_MM
) -> Options:
    """Options with stand-ins for what keys of a set-up would say; ``sizes_mm`` are those of tools."""
    tools = dict(options.tools or {})
    names: dict[str, int] = {}
    known = list_tool_numbers(options)
    for name, what in (key[1:] for key in keys if key[0] == "tools"):
        number = int(name) if name.isdecimal() else known.get(name, 0)
        number = number or names.setdefault(name, FIRST_NAMED_TOOL + len(known) + len(names))
        tool = tools.get(number, Tool(number, number, ZERO9, unmeasured="nobody"))
        sizes: dict[str, Any] = {"diameter": sizes_mm[1], "corner_radius": None}
        if what == "length":
            sizes = {"offset": (0.0, 0.0, sizes_mm[0], *ZERO9[3:]), "unmeasured": ""}
        tools[number] = dataclasses.replace(tool, **sizes)
    wcs = {SYSTEM_NUMBERS[key[1]]: WorkOffset((0.0, 0.0, 0.0)) for key in keys if key[0] == "wcs"}
    remap = {key[1]: "ignore" for key in keys if key[0] == "remap"}
    control = merge_keys(options.control, {dialect: {"tools": names} for dialect in NAMING_TOOLS} if names else {})
    split = options.split_at_stops or SPLIT_KEY in keys
    tapping = "feed" if TAPPING_KEY in keys else options.tapping
    length = sizes_mm[0] if LENGTH_KEY in keys else options.tool_length
    return options.changed(
        tools=tools or None,
        # of one tool, and not beside a table of tools
        tool_length=None if any(key[0] == "tools" for key in keys) else length,
        wcs={**options.wcs, **wcs},
        remap={**options.remap, **remap},
        control=control,
        split_at_stops=split,
        tapping=tapping,
    )
