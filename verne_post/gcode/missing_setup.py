"""What a program's set-up lacks (tools, tool numbers, work offsets), in the same words for every dialect."""

import re
from collections.abc import Collection, Mapping
from typing import Any, Final

import numpy as np

from verne_post.base.printable import quote_key
from verne_post.base.suggestions import MAY_BE_MEANT, find_meant, list_near_numbers, name_near_numbers
from verne_post.gcode.machining.state import State
from verne_post.gcode.program_error import FILL_IN_LENGTH, GIVE_PLACE, At, ProgramError
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import KEYS, FanucKeys, Rs274Keys, read_keys
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.moves import ZERO9, Moves, Selection
from verne_post.model.part_setup import (
    ADDITIONAL_SYSTEMS,
    FIRST_NAMED_TOOL,
    Tool,
    describe_tool_number,
    list_setup_names,
    name_system,
)

#: What else may be done about the length of a tool; nothing where the program uses several.
ONE_TOOL: Final = ", or give --tool-length MM where the program has one tool"
#: The tool that one digit tells apart from a missing one; nothing where several are missing.
NEAR_TOOL: Final = re.compile(r", but tool .* nearly this number(?=; add)|; did you mean \d+\?$")
#: Tools of a set-up for which one length is no remedy.
_SEVERAL: Final = 2
#: G54 to G57 of Siemens controls; G505 and on are further ones.
_SIEMENS_NAMES_ALIKE: Final = range(5)
#: Tools that a message lists.
_MOST_LISTED: Final = 4
#: Stands for a tool that is in no table, once that has been reported: its width only has to be greater than 0.
ASSUMED_TOOL: Final = Tool(0, 0, ZERO9, 1.0)


def find_tool_key(number: int, what: str, names: Mapping[int, str]) -> tuple[str, ...]:
    """The key of a set-up that says something of a tool; one without a number of its own is called by its name."""
    return "tools", names.get(number, str(number)) if number >= FIRST_NAMED_TOOL else str(number), what


def stands_in(tool: Tool) -> bool:
    """Whether a tool is the :data:`ASSUMED_TOOL` of one that has been reported."""
    return (tool.offset, tool.diameter) == (ASSUMED_TOOL.offset, ASSUMED_TOOL.diameter)


def report_missing_tool(number: int, letter: str, at: At, setup: Setup, state: State) -> ProgramError:
    """VP012: the length of a tool is needed, or the tool itself, and it is in no table."""
    name, own = describe_tool_number(number, state.tool_names), state.loaded_tool
    edits: tuple[Remedy, ...] = ()
    # CL files have no H: what stands for theirs has the first column
    if letter == "H" and at.columns.get("H", 1) != 1 and not stands_in((state.tools or {}).get(own or 0, ASSUMED_TOOL)):
        tool = describe_tool_number(own or 0, state.tool_names)
        why = f"{tool} is in the spindle, and the set-up, or the tool table, has no {name} "
        why += f"(add it there if H{number} is meant); did you mean H{own}?"
        key = find_tool_key(number, "length", state.tool_names)
        return at.error("VP012", f"H{number}: {why}", "H", name, key)
    names = list_setup_names(setup.control).values()
    alike = next((one for one in names if one[:1] in "Tt" and one[1:].lstrip("0") == str(number)), "")
    if alike:
        why = f"the set-up has no {name}, and {alike} is the name of one; write {number} in place of {alike} there"
    elif place := setup.replaced_tools.get(number, ""):
        why = (
            f"{place} has it, but tools are not joined: the tools of a nearer set-up, or a tool table, replace all of "
        )
        why += "that table; add the tool there"
    elif setup.tools is None:
        why = f"the length is in no set-up and in no tool table; give --tool-table FILE{ONE_TOOL}"
    else:
        numbers = [
            str(one) for one, tool in (state.tools or {}).items() if one < FIRST_NAMED_TOOL and not stands_in(tool)
        ]
        # another digit more or less tells tools apart: a 1 is not near to 51; one twice, as in 11, is a slip
        near = [one for one in numbers if len(one) == len(str(number)) or set(one) == set(str(number))]
        near = list_near_numbers(str(number), near)
        but = f", but {name_near_numbers(str(number), near, 'tool ')}" if len(near) > 1 else ""
        has = f"tool{'s' * (len(numbers) > 1)} {', '.join(numbers[:_MOST_LISTED])}" if numbers and not near else ""
        but += f", which has {has}{' and others' * (len(numbers) > _MOST_LISTED)}" * bool(has)
        also = ONE_TOOL if len(numbers) < _SEVERAL else ""
        why = f"no entry in the set-up or the tool table{but}; add one{also}"
        if len(near) == 1:
            why += f"; did you mean {near[0]}?"
            # Klartext writes the number alone
            words = [(f"{before}{number}", f"{before}{near[0]}") for before in ("", letter)]
            edits = tuple(Remedy(f"write {new}", new, misspelt=old, is_choice=True) for old, new in words)
    error = at.error("VP012", f"{name}: {why}", letter, name, find_tool_key(number, "length", state.tool_names), edits)
    return error.advise("" if alike else FILL_IN_LENGTH)


def check_measured(tool: Tool, setup: Setup, state: State, column: int | None = None) -> None:
    """Refuse (VP012) to use the length of a tool that is named without one; a plain interpreter reads it as 0."""
    if setup.machine and tool.unmeasured:
        name = describe_tool_number(tool.number, state.tool_names)
        text = f"{name}: {tool.unmeasured} gives no length"
        if " " not in tool.unmeasured:  # a set-up or a line of a tool table, and not a word of the program
            in_table = " (Z; Z0 if the gauge line is meant)" if ":" in tool.unmeasured else ""
            text += f"; write one there, mm from the gauge line to the tip{in_table}"
        key = find_tool_key(tool.number, "length", state.tool_names)
        raise ProgramError("VP012", text, column, about=name, settled_by=key).advise(
            "" if " " not in tool.unmeasured else None
        )


#: The key of a set-up that has the length of the one tool, which no line of the program calls.
LENGTH_KEY: Final = ("tool_length",)


def find_length_key(setup: Setup) -> tuple[str, ...]:
    """The key that settles a missing length of a program that calls no tool; none beside tools, which exclude it."""
    return LENGTH_KEY if setup.tools is None else ()


def advise_length(setup: Setup, *, call: bool = True) -> str:
    """What helps where no tool length is in force, and the program names no tool: no form asks for its length.

    ``call``: the message does not say that a call of the tool is missing.
    """
    if setup.tools is None:
        return f"Fill in tool_length, mm, in INPUT.toml{', or call the tool in the program' * call}."
    return (  # tools of a set-up exclude tool_length
        "Write the length of the tool under [tools] in INPUT.toml, or in the tool table"
        f"{', and call the tool in the program' * call}."
    )


def report_unloaded(selection: Selection, before: str) -> ProgramError:
    """VP012 at the T whose tool no M6 has loaded before what needs it."""
    change = selection.describe_change()
    text = f"{selection.spell()} only selects the tool, and no M6 loads it before {before}; write {change}"
    return ProgramError(
        "VP012", text, line=selection.own_line, of_program=True, edits=selection.propose_change()
    ).advise("")


def suggest_call(setup: Setup, state: State, form: str, others: str) -> str:
    """How to call a tool where none is called, although lengths of tools are there; empty where none are.

    ``form`` calls a tool of the set-up, ``{word}`` with the number ``{number}``, if there is one; ``others`` any tool.
    """
    numbers = [number for number, tool in (state.tools or {}).items() if tool.offset[2] > 0 and not tool.unmeasured]
    if state.loaded_tool is not None or not numbers:
        return ""
    names = list_setup_names(setup.control)
    if len(numbers) == 1:
        word = f'"{names[numbers[0]]}"' if numbers[0] in names else str(numbers[0])
        return (
            f"write {form.format(word=word, number=numbers[0])} before it: the set-up, or the tool table, has this tool"
        )
    first_tools = ", ".join(names.get(number, str(number)) for number in numbers[:_MOST_LISTED])
    more = f" and {len(numbers) - _MOST_LISTED} more" if len(numbers) > _MOST_LISTED else ""
    return f"write {others} before it: the set-up, or the tool table, has the tools {first_tools}{more}"


def number_of_tool(name: str, call: str, dialect: str, setup: Setup, state: State, column: int | None) -> int:
    """The number of a tool that a program calls by its name, which is kept for messages.

    Parameters
    ----------
    name, call : str
        The name, and how the program writes it.
    dialect : str
        In whose table of the settings file names have numbers.
    setup : Setup
    state : State
    column : int or None

    Raises
    ------
    ProgramError
        VP012: there is a tool table, and the name has no number.
    """
    names, keys = state.tool_names, read_keys(KEYS[dialect], setup.control.get(dialect, {}))
    numbers = {} if isinstance(keys, FanucKeys | Rs274Keys) else keys.tools  # their tools have no names
    if name in numbers:
        number = numbers[name]
    elif setup.tools is not None and setup.tool_length is None:
        other = next((one for one in numbers if one.lower() == name.lower()), "") or find_meant(name, numbers)
        # the name may stand in a word, whose quotes stay
        is_behind_words = " " in call.replace(name, "")
        near = f"; did you mean {other if is_behind_words else call.replace(name, other)}?" if other else ""
        edits: tuple[Remedy, ...] = ()
        alike = [one for one in numbers if len(one) == len(name) and sum(map(str.__ne__, one, name)) == 1]
        if len(alike) > 1:  # as FRAESER_D10 and FRAESER_D12 are for FRAESER_D13
            near = f"; {' or '.join(alike)}{MAY_BE_MEANT}"
            edits = tuple(Remedy(f"write {one}", one, misspelt=name, is_choice=True) for one in alike)
        text = (
            f"{call}: no tool of this name is given; write it under [tools] of the set-up, or give its number in a "
            f"tool table under [{dialect}.tools] of the settings file{near}"
        )
        error = ProgramError("VP012", text, column, settled_by=("tools", name, "length"), edits=edits)
        error.cause = f"tools.{name}"  # of TOOL DEF and TOOL CALL one finding
        raise error.advise("" if near else None)
    else:
        number = next(
            (given for given, other in names.items() if other == name),
            1 + max([FIRST_NAMED_TOOL - 1, *names, *numbers.values()]),
        )
    names[number] = name
    return number


def _spell_system(system: int, language: str) -> str:
    """What a language calls a work system that has another name in --wcs; empty where it has not."""
    number = system % ADDITIONAL_SYSTEMS
    if language == "heidenhain":
        return f"preset {number}"
    if language != "siemens" or system in _SIEMENS_NAMES_ALIKE:
        return ""
    return f"G{500 + system if system < ADDITIONAL_SYSTEMS else 509 + number}"


def report_missing_offset(
    moves: Moves, system: int, at: int, setup_name: str, zero: str, others: Collection[int] = ()
) -> Finding:
    """VP033: a work system that a program selects, and uses in a move, and that nobody has placed.

    The message calls it as the language of the program does, and says which --wcs that is, and from where it counts
    (``zero``). An error where a set-up, ``setup_name``, says that the place is still to be measured, or where
    ``others`` have a place: it is not there then.
    """
    name, word = name_system(system), _spell_system(system, moves.language)
    line = moves.find_selecting_line(system, at)
    where: dict[str, Any] = {"line": line, "settled_by": (("wcs", name),)}
    if line == moves.system_lines.get(system):
        where["column"] = moves.system_columns.get(system)
    if setup_name:
        key = f"wcs.{name}" if name.isalnum() else f'wcs."{name}"'
        also = f" ({word})" if word else ""
        text = f'{setup_name}: {key}{also} is still "measure"; write [x, y, z] of the part zero there, mm from {zero}'
        return make_finding("VP033", text, severity="error", advice="", **where)
    if others:
        names = [name_system(one) for one in sorted(others)]
        what = f"{word}, which is {name} here," if word else name
        text = (
            f"{what} has no place on the table, and {' and '.join(names)} {'has' if len(names) == 1 else 'have'} one: "
            f"give --wcs {name}=X,Y,Z, mm from {zero}"
        )
        if len(names) == 1 and moves.language != "heidenhain":
            text += f", or write {names[0]} if that is meant"
            if re.fullmatch(r"G\d+(?:\.\d)?", word or name) and re.fullmatch(r"G\d+", names[0]):
                given_word = "G", float((word or name)[1:])
                where["edits"] = (
                    Remedy(f"write {names[0]}", names[0][1:], line=line, word=given_word, is_choice=True),
                )
        advice = f"Write {quote_key(name)} = [x, y, z] under [wcs] of INPUT.toml, in mm from that point."
        return make_finding("VP033", text, severity="error", advice=advice, **where)
    what = f"no {'datum' if moves.language == 'heidenhain' else 'work offset'} was given: {word or name}"
    meaning = f", the name of {word} here" if word else ""
    text = f"{what} is at {zero}; give --wcs {name}=X,Y,Z{meaning}"
    # the message has the option; the file is left to say, and the unit
    return make_finding("VP033", text, advice=GIVE_PLACE.format(quote_key(name)), **where)


def report_missing_offsets(moves: Moves, setup: Setup) -> list[Finding]:
    """VP033 for a program that was refused, with the moves that it would have had."""
    found: dict[int, Finding] = {}
    called_lines, moves = moves.called_lines, moves.count_own_lines()
    for index, at in zip(*np.unique(moves.frame, return_index=True), strict=True):
        frame = moves.frames[index]
        given = setup.frames.get(frame.system)
        given_systems = (
            frame.system in setup.given_systems | moves.placed_systems or given is None or frame.origin != given.origin
        )
        if setup.machine and not given_systems and not _is_left_unused(moves, frame.system):
            setup_name = setup.unmeasured_wcs.get(frame.system, "")
            others = setup.given_systems if frame.system != moves.start_frame.system else ()
            item = report_missing_offset(moves, frame.system, int(at), setup_name, setup.coordinates.zero_point, others)
            found.setdefault(frame.system, called_lines.place(item))
    return list(found.values())


def _is_left_unused(moves: Moves, system: int) -> bool:
    """Whether a program begins in a work system, does not leave its start there, and selects another one.

    A retract in machine coordinates at the start leads to no place of the part.
    """
    if system in moves.system_lines or not moves.system_lines:
        return False
    frames = [index for index, frame in enumerate(moves.frames) if frame.system == system]
    own = moves.end[np.isin(moves.frame, frames)]
    return bool((own == own[:1]).all())
