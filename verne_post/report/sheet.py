"""The set-up sheet: program and machine, start, tools, work offsets, actions of the operator, fixtures."""

from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.app.summary import list_tool_lengths
from verne_post.base.arrays import find_used
from verne_post.base.long_text import Text, compute_sha256, decode_lines
from verne_post.base.numbers import format_fixed
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.remarks import find_stop_remarks, find_title, find_tool_diameters, find_tool_remarks
from verne_post.model.findings import InputError
from verne_post.model.machine import Machine
from verne_post.model.moves import AXES, Event, MoveKind, Stock, describe_tool, find_tool_of_moves
from verne_post.model.part_setup import Box, FixtureMesh, OwnStock, Tool, name_system, spell_tool_word
from verne_post.model.work_systems import find_placer
from verne_post.output.summary import LINE_OF_FACT, NOT_CHECKED_STOCK, describe_own_stock, join_lengths, list_facts
from verne_post.part.stl import read_stl
from verne_post.report.markup import Row, count, escape_text, join_few, write_table
from verne_post.report.table import Study

#: So many digits tell one file from another for people.
DIGEST: Final = 16
#: Decimals of the start position; it is written with more in the setpoints.
_DECIMALS: Final = {"mm": 3, "deg": 4}
#: Facts of the summary that stand elsewhere on the page: in tables of the sheet, and in the head.
_TOLD: Final = (
    *("start position", "set-up", "assumed", "tool length", "work offset", "operator"),
    *("NOT CHECKED", "kept out of"),
)
#: A place with more characters needs two columns of the sheet.
_LONG_PLACE: Final = 30
#: So many rows of tools, offsets, fixtures and actions leave room for a finding on one page, some rows in two lines.
_SHEET_ROWS: Final = 16
#: Of a diameter.
_NOT_GIVEN: Final = "not given"
#: Of a length or an offset that the set-up leaves open.
TO_BE_MEASURED: Final = "to be measured"
#: Of an offset that neither a file nor an option of the command line gives.
_GIVEN: Final = "given"
_ACTIONS: Final = {"input": "input {input} is waited for", "stop": "{stop} stop"}


def write_sheet_html(program: str, source: Text, machine: Machine, study: Study) -> str:
    """What a person needs at the machine: set-up, tools, work offsets, start position, fixtures and actions.

    Of a program that cannot be read, tools and offsets are those of the set-up.
    """
    lines = source.count(b"\n") + (not source.endswith(b"\n"))
    setup = study.options.setup_source
    title = find_title(decode_lines(source), _find_dialect(source, study))
    made = (
        ("program", f"{program}, {count(lines, 'line')}"),
        *([("title", title)] if title else []),
        ("machine", machine.name),
        *([("set-up", setup)] if setup else []),
    )
    remarks = _find_remarks_by_number(source, study)
    named = find_tool_diameters(source, {str(number): text for number, text in remarks.items()})
    read = study.program is not None
    places = {
        number: f"line {event.line}" + (f", {time} s" if (time := _describe_time(event, study)) else "")
        for number, event in _find_single_changes(study).items()
    }
    parts = [
        _write_titled_table("Program and machine", ("what", "which"), made, named=True),
        _write_titled_table(
            "Tools",
            (
                *("tool", "in the program", "length, mm", "diameter, mm"),
                *["spindle, 1/min"] * read,
                *["time, s"] * study.timed,
                *["put in at"] * bool(places),
            ),
            [
                (
                    tool,
                    remarks.get(number, ""),
                    length,
                    _add_named(diameter, named.get(str(number))),
                    *(_describe_use(study, number) if read else ()),
                    *([places.get(number, "")] if places else []),
                )
                for number, tool, length, diameter in list_tools(study)
            ],
            wide=True,
            note=_describe_carried(study) if read else "From the set-up: the program was not read to its end.",
        ),
        _write_titled_table(
            "Work offsets",
            ("system", "x, mm", "y, mm", "z, mm", "turned, deg", "from"),
            offsets := list_offsets(machine, study),
            named=True,
            wide=True,
            note=f"The part zero, from {machine.coordinates.zero_point}." if offsets else "",
        ),
        _write_titled_table(
            "Fixtures and stock",
            ("name", "in", "x, y, z, mm"),
            bodies := _list_bodies(study),
            named=True,
            wide=any(len(place) > _LONG_PLACE for _name, _system, place in bodies),
        ),
    ]
    if not read:
        return "".join(parts)
    parts.insert(1, _write_start(machine, study))
    actions = _list_actions(source, study, remarks)
    tools = "the tools above, each put in at its line" if places else ""
    heads, note = ("line", "time, s", "what"), f"Besides: {tools}." if tools and actions else ""
    none = f"none besides {tools}" if tools else "none"
    parts.append(_write_titled_table("Actions of the operator", heads, actions, note=note, none=none))
    if in_parts := _list_parts(study):
        parts.append(_write_titled_table("Parts of the setpoint file", ("part", "lines", "tools", "time, s"), in_parts))
    return "".join(parts)


def _write_start(machine: Machine, study: Study) -> str:
    """The joints at the start, as the first row has them, and where the tip is then, as the control shows it."""
    rows = [
        (column.joint, f"{format_fixed(value, _DECIMALS[column.unit])} {column.unit}")
        for column, value in zip(machine.columns, study.q[0], strict=True)
    ]
    program = study.program
    assert program is not None
    path, moves = program.path, program.moves
    first = int(path.move[0])
    frame = replace(moves.frames[moves.frame[first]] if first >= 0 else moves.start_frame, feature=None)
    words = machine.coordinates.map_from_table(path.start[0, :3], path.start[0, 3:], frame)
    for letter in machine.coordinates.axes:
        unit = "deg" if letter in "ABC" else "mm"
        rows.append((letter, f"{format_fixed(float(words[AXES.index(letter)]), _DECIMALS[unit])} {unit}"))
    note = f"X, Y, Z: the tip in {name_system(frame.system)}, with a tool length of {float(path.tool_length[0]):g} mm."
    return _write_titled_table("Start position", ("joint, axis", "value"), rows, note=note)


def _add_named(diameter: str, named: float | None) -> str:
    """A diameter; where it is not given and a remark names one, with that one, which nothing was checked with."""
    return diameter if diameter != _NOT_GIVEN or named is None else f"{_NOT_GIVEN} in the set-up; remark: {named:g}"


def is_sheet_long(machine: Machine, study: Study) -> bool:
    """Whether tools, offsets and actions leave no room for a finding on the first page of paper."""
    rows = [*list_tools(study), *list_offsets(machine, study), *_list_bodies(study)]
    waits = 0 if study.program is None else len(_list_waits(study.program)) - len(_find_single_changes(study))
    return len(rows) + waits > _SHEET_ROWS


def write_record_html(source: Text, machine: Machine, study: Study) -> str:
    """What tells one conversion from another: its summary, and the checksums of program and machine."""
    from verne_post import __version__

    sums = (
        ("program, SHA-256", compute_sha256(source)[:DIGEST]),
        ("machine, SHA-256", machine.sha256[:DIGEST]),
        ("made by", f"verne-post {__version__}"),
    )
    facts = [] if study.summary is None else list_facts(study.summary)
    rows = "".join(
        f"<div><dt>{escape_text(key)}</dt><dd>{escape_text(_join_lines(text))}</dd></div>"
        for key, text in (*(fact for fact in facts if fact[0] not in _TOLD), *sums)
    )
    return f"<dl>{rows}</dl>"


def _join_lines(text: str) -> str:
    """The lines of a fact as one, with its columns closed up."""
    return " ".join("; ".join(text.split(LINE_OF_FACT)).split())


def _write_titled_table(
    title: str,
    heads: Row,
    rows: Iterable[Row],
    *,
    named: bool = False,
    wide: bool = False,
    note: str = "",
    none: str = "none",
) -> str:
    """Write a table under its title; ``named`` ones end with names, such as paths, which break anywhere.

    ``wide`` ones take two columns of the sheet where it has them. A ``note`` stands below the table, ``none`` in its
    place where it has no rows.
    """
    body = "".join("<tr>" + "".join(f"<td>{escape_text(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    table = write_table(heads, body) if body else f"<p>{escape_text(none)}</p>"
    table += f"<p>{escape_text(note)}</p>" if note else ""
    kinds = [*["named"] * named, *["wide"] * wide]
    return f'<div class="{" ".join(kinds)}"><h3>{title}</h3>{table}</div>'


def _find_remarks_by_number(source: Text, study: Study) -> dict[int, str]:
    """Number of a tool -> what the program says about it."""
    said = find_tool_remarks(decode_lines(source), _find_dialect(source, study))
    remarks = {tool.upper(): text for tool, text in said.items()}
    names = {} if study.program is None else study.program.moves.name_tools()
    numbers = {number: str(number) for number, *_sizes in list_tools(study)}
    found = {number: remarks.get(names.get(number, key).upper(), "") for number, key in numbers.items()}
    return {number: text for number, text in found.items() if text}


def _describe_use(study: Study, tool: int) -> tuple[str, ...]:
    """At which spindle speeds a tool cuts, and how long it is in the spindle where the program has times."""
    program = study.program
    assert program is not None
    moves = program.moves
    used = find_tool_of_moves(np.arange(len(moves)), program.path.first_move, moves) == tool
    used &= np.isfinite(moves.feed) & (moves.kind != MoveKind.DWELL)
    speeds = [f"{speed:g}" for speed in np.unique(moves.spindle[used]).tolist() if speed > 0]
    seconds = sum(one.seconds for one in study.operations if one.tool == tool)
    return join_few(speeds, "more") if speeds else "off", *([f"{seconds:.3f}"] if study.timed else [])


def list_tools(study: Study) -> list[tuple[int, str, str, str]]:
    """Number, name, lengths and diameter of each tool in use; of a program that cannot be read, of the set-up."""
    listed, program = study.options.tools or {}, study.program
    if program is None:
        names: Mapping[int, str] = {}
        lengths = {number: _format_length(tool) for number, tool in sorted(listed.items())}
        if study.options.tool_length is not None:
            lengths = {0: f"{study.options.tool_length:g}"} | lengths
    else:
        names = program.moves.name_tools()
        lengths = join_lengths(list_tool_lengths(program).own)
    rows = []
    for number, used in lengths.items():
        tool = listed.get(number)
        diameter = f"{tool.diameter:g}" if tool is not None and tool.diameter > 0 else _NOT_GIVEN
        rows.append((number, spell_tool_word(number, names) if number else "not named", used, diameter))
    return rows


def _format_length(tool: Tool) -> str:
    """The length of a tool of the set-up, mm, or that it is not known."""
    return TO_BE_MEASURED if tool.unmeasured else f"{tool.offset[2]:g}"


def _describe_carried(study: Study) -> str:
    """Which rapids have the length of another tool, and where the tip is then; empty where none have."""
    program = study.program
    assert program is not None
    names, lengths = program.moves.name_tools(), list_tool_lengths(program)
    own = dict(reversed(lengths.own))  # the first of each tool
    carried, lowest = [], 0.0
    for number, used in lengths.carried:
        above = used - own[number]
        lowest = min(lowest, above)
        where = f"its tip is {abs(above):g} mm {'lower' if above < 0 else 'higher'} than the program says"
        carried.append(f"{spell_tool_word(number, names)} has {used:g} mm: {where}")
    said = "Rapids before the tool's own length is active have that of the tool before"
    in_doubt = lowest < 0 and any(one.code == "VP034" for one in study.findings)  # else they are far above the part
    return f"{'Danger: r' if in_doubt else 'R'}{said[1:]}. {'; '.join(carried)}." if carried else ""


def list_offsets(machine: Machine, study: Study) -> list[Row]:
    """System, place, turn and source of each work offset in use; of a program that cannot be read, of the set-up."""
    program, options = study.program, study.options
    if program is None:
        given = {
            system: (*(f"{value:g}" for value in offset.origin_mm), f"{offset.turn_deg:g}", offset.source or _GIVEN)
            for system, offset in options.wcs.items()
        } | dict.fromkeys(options.unmeasured_wcs, ("", "", "", "", TO_BE_MEASURED))
        return [(name_system(system), *cells) for system, cells in sorted(given.items())]
    move = program.path.move
    used = find_used(program.moves.frame[move[move >= 0]]).tolist()
    rows: dict[Row, None] = {}
    for frame in sorted((program.moves.frames[index] for index in used), key=lambda frame: frame.system):
        place = machine.find_origin_on_table(frame)
        who = find_placer(frame, machine, program.options, program.moves.placed_systems)
        written = options.wcs.get(frame.system)
        source = {
            "set-up": (written.source if written else "") or _GIVEN,
            "program": "the program",
            "machine": "machine zero",
            "nobody": f"not given: {machine.coordinates.zero_point}",
        }[who]
        rows[name_system(frame.system), *(f"{value:g}" for value in place), f"{frame.part_turn:g}", source] = None
    return list(rows)


def _list_bodies(study: Study) -> list[Row]:
    """Name, system and place of each fixture, and of the stock: that of the options, else that of the program."""
    options, own = study.options, None if study.program is None else study.program.moves.stock
    rows = [_describe_body(one, own) for one in (*options.keep_out, *([options.stock] if options.stock else []))]
    if own is not None and options.stock is None:
        name, system, place = _describe_body(OwnStock(), own)
        rows.append((name, system, f"{place}; {NOT_CHECKED_STOCK}"))
    return rows


def _describe_body(body: Box | FixtureMesh | OwnStock, own: Stock | None) -> Row:
    """Name, system and place of a fixture or the stock, of a mesh with its file."""
    system = "table" if body.system is None else name_system(body.system)
    match body:
        case Box():
            return body.name, system, _describe_ends(body.low, body.high)
        case FixtureMesh():
            return body.name, system, "; ".join(filter(None, (_describe_mesh(body), body.file)))
        case OwnStock() if own is None:
            return body.name, "", "as the program says"
        case OwnStock():
            return body.name, name_system(own.frame.system), describe_own_stock(own)


def _describe_mesh(body: FixtureMesh) -> str:
    """Where a mesh begins and ends; empty of a file that cannot be read, which a finding says."""
    try:
        vertices = read_stl(body.raw, body.shown, body.unit).vertices
    except InputError:
        return ""
    return _describe_ends(vertices.min(axis=0), vertices.max(axis=0))


def _describe_ends(low: Iterable[float], high: Iterable[float]) -> str:
    return "; ".join(f"{least:.6g} to {most:.6g}" for least, most in zip(low, high, strict=True))


def _find_dialect(source: Text, study: Study) -> str:
    return choose_dialect_name(study.options.dialect, source, study.options.source_name)


def _list_waits(program: Program) -> list[Event]:
    """Where the machine waits for a person or a signal."""
    return [event for event in program.moves.events if event.waits(optional_stop=program.options.optional_stop)]


def _find_single_changes(study: Study) -> dict[int, Event]:
    """Number of a tool -> where a person puts it in: the table of tools says it, unless one comes twice."""
    program = study.program
    changes = [] if program is None else [event for event in _list_waits(program) if event.kind == "tool"]
    found = {event.tool: event for event in changes}
    shown = {number for number, *_sizes in list_tools(study)} - {0}
    return {number: event for number, event in found.items() if number in shown} if len(found) == len(changes) else {}


def _describe_time(event: Event, study: Study) -> str:
    """When something is done, s; empty without times."""
    assert study.program is not None
    rows = () if study.summary is None else study.summary.timed
    return next((f"{one.row * study.program.cycle:.3f}" for one in rows if one.event is event), "")


def _list_parts(study: Study) -> list[Row]:
    """Lines of the first and the last motion, tools and time of each part of a file that is cut at stops."""
    program, summary = study.program, study.summary
    if program is None or summary is None or len(summary.parts) < 2:
        return []
    names = program.moves.name_tools()
    cycle = summary.format.cycle
    rows: list[Row] = []
    for number, part in enumerate(summary.parts, 1):
        begin, end = (part.first_row * cycle, part.last_row * cycle)
        inside = (study.x > begin - cycle / 2) & (study.x < end + cycle / 2) & (study.line > 0) & (study.move >= 0)
        lines = study.line[inside]
        # the last row may be of the change of tools that ends the part
        before_stop = inside & (study.x < end - cycle / 2)
        tools = find_tool_of_moves(study.move[before_stop], program.path.first_move, program.moves).tolist()
        shown = ", ".join(spell_tool_word(tool, names) for tool in dict.fromkeys(tools) if tool)
        rows.append((str(number), f"{lines[0]} to {lines[-1]}" if len(lines) else "", shown, f"{end - begin:.3f}"))
    return rows


def _list_actions(source: Text, study: Study, remarks: Mapping[int, str]) -> list[Row]:
    program = study.program
    assert program is not None
    told = [id(event) for event in _find_single_changes(study).values()]
    waits = [event for event in _list_waits(program) if id(event) not in told]
    said = find_stop_remarks(
        decode_lines(source), _find_dialect(source, study), {event.line for event in waits if event.kind == "stop"}
    )

    def describe_action(event: Event) -> str:
        if event.kind != "tool":
            what = _ACTIONS[event.kind].format(**event.data)
            return what + (f": {said[event.line]}" if event.kind == "stop" and event.line in said else "")
        remark = remarks.get(event.tool, "")
        return f"put in {describe_tool(event)}" + f" ({remark})" * bool(remark)

    return [(str(event.line), _describe_time(event, study), describe_action(event)) for event in waits]
