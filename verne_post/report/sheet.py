"""What a person reads first: the verdict, the worst places, and the set-up sheet, as parts of the page."""

import html
import itertools
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.machined import place_on_table
from verne_post.app.summary import list_tool_lengths
from verne_post.base.arrays import Array, find_used
from verne_post.base.long_text import Text, compute_sha256
from verne_post.base.numbers import format_count, format_fixed
from verne_post.base.printable import make_printable
from verne_post.base.rotations import rotate_z
from verne_post.base.tolerances import ACCELERATION_RATIO, JERK_RATIO, VELOCITY_RATIO
from verne_post.model.machine import Machine
from verne_post.model.moves import Event, MoveKind, describe_tool, find_tool_of_moves, name_tools
from verne_post.model.part_setup import SYSTEM_NAMES, Box, FixtureMesh, OwnStock, spell_tool_word
from verne_post.model.verdict import count_findings, find_exit_status, find_verdict
from verne_post.model.work_systems import find_placer
from verne_post.output.causes import describe_other, find_causes, list_worst
from verne_post.output.findings import describe
from verne_post.output.summary import describe_time, list_facts
from verne_post.part.sweep import Nearest
from verne_post.part.verdict import find_line, find_tip
from verne_post.report.governing import AT_FEED, FEED_BANDS, HIGHER
from verne_post.report.surfaces import find_frames
from verne_post.report.table import Governing, Operation, Study

#: Stretches that lose time against the programmed feed, shown among the worst places.
_SLOW_STRETCHES: Final = 2
#: A way to win time is named where it concerns such a share of the program.
_WORTH_A_WORD: Final = 0.005
#: So many operations are shown, the longest, or those that differ most; the rest stands in one row.
OPERATIONS: Final = 200
#: So many digits tell one file from another for people.
DIGEST: Final = 16
#: So many tools and work offsets are in the head.
_IN_HEAD: Final = 2
#: What verification accepts of each limit, for the differences of rounded rows.
_ALLOWED: Final = {"velocity": VELOCITY_RATIO, "acceleration": ACCELERATION_RATIO, "jerk": JERK_RATIO}
#: A cell of so many characters has no room in its column.
_LONG_CELL: Final = 20
_ACTIONS: Final = {"input": "input {input} is waited for", "stop": "{stop} stop"}
Row = tuple[str, ...]


class Place(Struct, frozen=True):
    """A place worth a look: what, how much, and the frame that shows it."""

    what: str
    value: str
    frame: int


def escape_text(text: str) -> str:
    """Escape text for HTML."""
    return html.escape(make_printable(text))


# --- the verdict --------------------------------------------------------------------------------------


def write_verdict_html(machine: Machine, study: Study) -> str:
    """Whether the program can run, how long it takes, and what is assumed."""
    errors, warnings = count_findings(list_worst(study.findings))
    shown = []
    if study.timed:
        assert study.summary is not None
        shown = [("time", describe_time(study.summary))]
        if study.governing is not None and study.summary.feed_segments:
            shown.append(("lost against the feed rate", f"{study.governing.lost.sum():.3f} s"))
    elif len(study.x):
        shown = [("path", f"{study.x[-1]:.1f} mm, no time: nothing is written")]
    else:
        shown = [("program", "refused, nothing is laid out")]
    shown += list_setup(machine, study)
    shown.append(("findings", count(errors, "error") + ", " + count(warnings, "warning")))
    shown.append(("assumed, not measured", ", ".join(machine.assumed) or "nothing"))
    word, kind = name_verdict(machine, study)
    cells = "".join(f"<div><dt>{escape_text(name)}</dt><dd>{escape_text(value)}</dd></div>" for name, value in shown)
    return f'<strong class="{kind}">{word}</strong><dl>{cells}</dl>'


def name_verdict(machine: Machine, study: Study) -> tuple[str, str]:
    """The verdict with what it rests on, and its class in the style sheet."""
    word = find_verdict(find_exit_status(study.findings), study.findings).word.capitalize()
    if not study.timed:
        return word, "refused"
    warned = any(item.severity == "warning" for item in study.findings)
    # it says that the numbers of the file hold, not that the machine does
    said = machine.provenance.get("limits") or machine.provenance.get("joints") or ""  # of a chain, joints have them
    source = said.partition(" ")[0].strip(":,;")
    on = f"on {source} limits" if source else "on limits of unknown source"
    return f"{word}{', with warnings' if warned else ''}, {on}", "warned" if warned else "runs"


def list_setup(machine: Machine, study: Study) -> list[tuple[str, str]]:
    """Tool length and work offset in a few words."""
    if study.program is None:
        return []
    lengths: dict[str, list[str]] = {}  # a tool has the length of the one before until G43
    for _number, tool, length, _diameter in _list_tools(study):
        lengths.setdefault(tool, []).append(length)
    tools = [f"{tool}: {' then '.join(used)} mm".removeprefix("not named: ") for tool, used in lengths.items()]
    offsets = [f"{name} at {', '.join(place)} mm" for name, *place, _turn, _source in _list_offsets(machine, study)]
    return [("tool length", _join_few(tools)), ("work offset", _join_few(offsets))]


def _join_few(texts: list[str], more: str = "more on the set-up sheet") -> str:
    """Join as many texts as the head has room for; the set-up sheet has all."""
    rest = len(texts) - _IN_HEAD
    return "; ".join([*texts[:_IN_HEAD], *([f"{rest} {more}"] if rest > 0 else [])]) or "none"


def count(number: int, what: str) -> str:
    """Say how many, in words for people."""
    return format_count(number, what) if number else f"no {what}s"


# --- findings and worst places --------------------------------------------------------------------------


def write_css_string(text: str) -> str:
    """Write text as a string of a style sheet; all but plain letters and digits are escaped, so nothing ends it."""
    text = "".join(one if one.isascii() and one.isalnum() else f"\\{ord(one):x} " for one in make_printable(text))
    return f'"{text}"'


def write_title_html(program: str, machine: Machine) -> str:
    """The program and its machine; the folder is quiet."""
    folder, slash, name = program.rpartition("/")
    return (
        f"<small>{escape_text(folder + slash)}</small><wbr>{escape_text(name)} <small>on "
        f"{escape_text(machine.name)}</small>"
    )


def write_findings_html(study: Study) -> str:
    """The list of findings, one for each cause; each entry has the frame that a click leads to."""
    if not study.findings:
        return "<li>no findings</li>"
    entries = []
    for cause in find_causes(study.findings):
        item = cause.worst
        text = escape_text(("" if item.line is None else f"line {item.line}: ") + describe(item))
        tried = "".join(f"<small>tried: {escape_text(remedy)}</small>" for remedy in item.remedies)
        also = [escape_text(f"also {describe_other(other)}") for other in cause.others]
        kinds = [item.severity] + [f"{item.severity} also"] * len(also)
        for kind, shown, index in zip(kinds, [text + tried, *also], cause.indices, strict=True):
            frame = study.place[index]
            tag, place = ("button", f' type="button" data-frame="{frame}"') if frame >= 0 else ("span", "")
            entries.append(f'<li class="{kind}"><{tag}{place}>{shown}</{tag}></li>')
    return "\n".join(entries)


def write_places_html(machine: Machine, study: Study) -> str:
    """Worst places of the motion, each a button that leads to it."""
    return "".join(
        f'<li><button type="button" data-frame="{place.frame}"><span>{escape_text(place.what)}</span>'
        f"<b>{escape_text(place.value)}</b></button></li>"
        for place in find_worst_places(machine, study)
    )


def find_worst_places(machine: Machine, study: Study) -> Iterator[Place]:
    """Where the program is nearest to its limits, and which lines lose most time."""
    if np.isfinite(study.margin).any():
        curve = study.curves["margin"][0]
        at = int(np.nanargmin(curve.values))
        frame = _find_frame(study, float(curve.x[at]))
        name = study.margin_names[study.nearest[frame]] if study.nearest[frame] >= 0 else "out of reach"
        # where the program is refused for another reason, such as the table, a margin that is left would mislead
        if study.timed or curve.values[at] < 0:
            yield Place(f"smallest margin (0 at a limit): {name}", format_fixed(curve.values[at], 3), frame)
    for name, allowed in _ALLOWED.items() if study.timed else ():
        shares_of = list(iterate_shares(machine, study, name))
        joint = int(np.argmax([np.abs(share).max() for _x, share in shares_of]))
        x, share = shares_of[joint]
        at = int(np.abs(share).argmax())
        what = f"peak {name}: {machine.columns[joint].joint}, allowed {100.0 * allowed:g} %"
        yield Place(what, f"{abs(share[at]):.1f} %", _find_frame(study, float(x[at])))
    yield from _find_part_places(study)
    if study.governing is not None:
        yield from _find_slow_stretches(study, study.governing)
    if study.summary is not None and (within := study.summary.stops_within).count:
        frame = int(np.abs(study.line - within.line).argmin())
        yield Place(f"line {within.line} stops inside", format_count(within.most, "time"), frame)
    if study.tilts:
        frame = int(np.nanargmax(np.abs(study.alpha_deg)))
        yield Place("peak platform tilt", f"{format_fixed(study.alpha_deg[frame], 2)} deg", frame)


def _find_part_places(study: Study) -> Iterator[Place]:
    """Where the part is cut into most, and where most stays on it."""
    if study.part is None or not study.part.judged or study.program is None:
        return
    judged, program = study.part.judged[0], study.program
    found, asked, frame_of_part = judged.comparison, program.options.part, program.machine.coordinates.part_frame
    assert asked is not None
    origin, turn = place_on_table(program, asked.name, asked.system)

    def make(what: str, value: float, nearest: Nearest, k: int) -> Place:
        tip, line = rotate_z(find_tip(judged, nearest, k)[None], turn) + origin, find_line(judged, nearest, k)
        frame = find_frames(study.tip, study.line, tip @ frame_of_part, np.array([line]))[0]
        return Place(f"{what} {asked.name}: line {line}", f"{value:.3f} mm", int(frame))

    if len(found.gouges.depth):
        k = int(found.gouges.depth.argmax())
        yield make("cut into", float(found.gouges.depth[k]), found.gouges.nearest, k)
    if (np.nan_to_num(found.deviation, nan=0.0) > 0).any():
        k = int(np.nanargmax(found.deviation))
        yield make("left on", float(found.deviation[k]), found.nearest, k)


def _find_slow_stretches(study: Study, governing: Governing) -> Iterator[Place]:
    """Stretches without a moment at the feed rate that lose most time against it."""
    lost = governing.lost_from_frame
    begins = np.flatnonzero((lost > 0) & ~np.append(False, lost[:-1] > 0))
    ends = np.flatnonzero((lost > 0) & ~np.append(lost[1:] > 0, False))
    sums = np.array([lost[begin : end + 1].sum() for begin, end in zip(begins, ends, strict=True)])
    for k in np.argsort(-sums, kind="stable")[:_SLOW_STRETCHES]:
        begin, end = int(begins[k]), int(ends[k])
        frame = begin + int(lost[begin : end + 1].argmax())
        first, last = study.line[[begin, end]]
        lines = f"line {first} loses" if first == last else f"lines {first} to {last} lose"
        yield Place(f"{lines}: {governing.names[governing.of_frame[frame]]}", f"{sums[k]:.3f} s", frame)


def iterate_shares(machine: Machine, study: Study, name: str) -> Iterator[tuple[Array, Array]]:
    """Yield x and per cent of the limit on velocity, acceleration or jerk, joint by joint."""
    limit: Array = getattr(machine.limits, name)
    for column, most, curve in zip(machine.columns, limit, study.curves[name], strict=True):
        yield curve.x, 100.0 * curve.values / (most * abs(column.factor))


def _find_frame(study: Study, x: float) -> int:
    """The last frame at or before x."""
    return max(int(np.searchsorted(study.x, x, side="right")) - 1, 0)


# --- what governs ------------------------------------------------------------------------------------------


def write_governing_html(machine: Machine, study: Study) -> str:
    """Seconds that each limit governs, what it costs, and what more of it would win."""
    governing = study.governing
    if governing is None:
        return ""
    order = [k for k in np.argsort(-governing.seconds) if governing.seconds[k] > 0]
    columns = (governing.seconds, governing.rapid, governing.lost, governing.at_stops)
    rows: list[Row] = [
        (governing.names[k], *(f"{column[k]:.3f}" for column in (*columns, governing.won))) for k in order
    ]
    rows.append(("all", *(f"{column.sum():.3f}" for column in columns), ""))
    keys = [*order, None]
    body = "".join(
        f"<tr><th scope=row>{'' if key is None else f'<i data-limit={key}></i>'}{escape_text(row[0])}</th>"
        + "".join(f"<td>{cell}</td>" for cell in row[1:])
        + "</tr>"
        for key, row in zip(keys, rows, strict=True)
    )
    more = f"{100.0 * (HIGHER - 1.0):.0f} % more wins about, s"
    table = write_table(("limit", "governs, s", "in rapids, s", "lost, s", "of it near stops, s", more), body)
    ways = "".join(f"<li>{escape_text(way)}</li>" for way in _list_ways_to_win(machine, study, governing))
    return table + (f"<ul class=ways>{ways}</ul>" if ways else "")


def _list_ways_to_win(machine: Machine, study: Study, governing: Governing) -> Iterator[str]:
    """What would win lost time back, the largest loss first: one sentence for each kind of limit that costs much."""
    rotary = {f"velocity of {column.joint}" for column in machine.columns if column.unit == "deg"}
    between = dict(zip(governing.names, governing.lost - governing.at_stops, strict=True))
    kinds = {name: "turning" if name in rotary else name.partition(" ")[0] for name in between if " of " in name}
    sums = {kind: sum(between[name] for name in kinds if kinds[name] == kind) for kind in kinds.values()}
    ways = (
        (governing.at_stops.sum(), "near stops: blended corners (G64 and its like) have no stop"),
        (sums["turning"], "to the velocity of rotary axes: a tool axis that turns less for each mm of path"),
        (sums.get("velocity", 0.0), "to the velocity of other joints: another place of the part (fit)"),
        (
            sums["acceleration"] + sums["jerk"],
            "to acceleration and jerk between stops: a larger corner tolerance, fewer and rounder corners",
        ),
    )
    for lost, words in sorted(ways, reverse=True):
        if lost >= _WORTH_A_WORD * study.x[-1]:
            yield f"{lost:.3f} s are lost {words}."


# --- where the time goes -----------------------------------------------------------------------------------


def write_times_html(study: Study) -> str:
    """Time by tool and by operation; an entry leads to where the operation begins."""
    if not study.operations:
        return ""
    program = study.program
    assert program is not None
    names, body = name_tools(program.moves.events), []
    shown = sorted(study.operations, key=lambda one: -one.seconds)[:OPERATIONS]
    for tool in dict.fromkeys(one.tool for one in study.operations):
        of_tool = [one for one in study.operations if one.tool == tool]
        head = spell_tool_word(tool, names) if tool else "no tool named"
        body.append(f"<tr class=tool><th scope=row>{escape_text(head)}</th><td></td>{_write_spent(of_tool)}</tr>")
        body += [
            '<tr><th scope=row><button type="button" '
            f'data-frame="{one.frame}">{escape_text(one.name or "without a remark")}</button></th>'
            f"<td>{_name_lines(one)}</td>{_write_spent([one])}</tr>"
            for one in of_tool
            if one in shown
        ]
        rest = [one for one in of_tool if one not in shown]
        if rest:
            body.append(f"<tr><th scope=row>{len(rest)} shorter operations</th><td></td>{_write_spent(rest)}</tr>")
    body.append(f"<tr class=tool><th scope=row>all</th><td></td>{_write_spent(study.operations)}</tr>")
    heads = ("tool and operation", "lines", "time, s", "feed, s", "rapids, s", "stands, s", "lost, s")
    return write_table(heads, "".join(body))


def _write_spent(operations: Sequence[Operation]) -> str:
    seconds, rapid, standing, lost = (
        sum(getattr(one, name) for one in operations) for name in ("seconds", "rapid", "standing", "lost")
    )
    cells = (seconds, seconds - rapid - standing, rapid, standing, lost)
    return "".join(f"<td>{format_fixed(cell, 3)}</td>" for cell in cells)


def _name_lines(one: Operation) -> str:
    if not one.last_line:
        return "approach"
    return str(one.first_line) if one.first_line == one.last_line else f"{one.first_line} to {one.last_line}"


def write_reached_html(study: Study) -> str:
    """How long feed moves reach which share of the programmed feed rate, as bars."""
    governing = study.governing
    if governing is None or not governing.reached.any():
        return ""
    whole, most = governing.reached.sum(), governing.reached.max()
    ends = [*(100.0 * k / FEED_BANDS for k in range(FEED_BANDS)), 100.0 * AT_FEED]
    names = [f"{low:.0f} to {high:.0f} %" for low, high in itertools.pairwise(ends)] + ["reached"]
    rows = "".join(
        f"<tr><th scope=row>{name}</th><td><i style='width:{100.0 * seconds / most:.1f}%'></i></td>"
        f"<td>{seconds:.3f}</td><td>{100.0 * seconds / whole:.1f}</td></tr>"
        for name, seconds in zip(reversed(names), reversed(governing.reached.tolist()), strict=True)
    )
    return write_table(("of the feed rate", "<span class=unseen>bar</span>", "s", "%"), rows)


# --- set-up sheet ------------------------------------------------------------------------------------------


def write_sheet_html(program: str, source: Text, machine: Machine, study: Study) -> str:
    """Which program and machine; tools, work offsets, fixtures and stock, start position, and what a person does."""
    from verne_post import __version__

    lines = source.count(b"\n") + (not source.endswith(b"\n"))
    setup = study.program.options.setup_source if study.program is not None else ""
    made = (
        ("program", f"{program}, {count(lines, 'line')}"),
        ("its SHA-256", compute_sha256(source)[:DIGEST]),
        *([("set-up", setup)] if setup else []),
        ("machine", machine.name),
        ("its SHA-256", machine.sha256[:DIGEST]),
        ("made by", f"verne-post {__version__}"),
    )
    parts = [_write_titled_table("Program and machine", ("what", "which"), made)]
    if study.program is None:
        return parts[0] + "<p>The program was refused before it was laid out on the machine.</p>"
    parts += [
        _write_titled_table(
            "Start position",
            ("joint", "value"),
            [
                (column.joint, f"{format_fixed(value, 4)} {column.unit}")
                for column, value in zip(machine.columns, study.q[0], strict=True)
            ],
        ),
        _write_titled_table(
            "Tools",
            ("tool", "length, mm", "diameter, mm", "spindle, 1/min", "time, s"),
            [
                (tool, length, diameter, *_describe_use(study, number))
                for number, tool, length, diameter in _list_tools(study)
            ],
        ),
        _write_titled_table(
            "Work offsets", ("system", "x, mm", "y, mm", "z, mm", "turned, deg", "from"), _list_offsets(machine, study)
        ),
        _write_titled_table("Actions of the operator", ("line", "at", "what"), _list_actions(study)),
    ]
    options = study.program.options
    bodies = [*options.keep_out, *([options.stock] if options.stock else [])]
    parts.append(
        _write_titled_table(
            "Fixtures and stock", ("name", "in", "x, y, z, mm"), [_describe_body(one) for one in bodies]
        )
    )
    if study.summary is not None:
        rows = "".join(
            f"<div><dt>{escape_text(key)}</dt><dd>{escape_text(text)}</dd></div>"
            for key, text in list_facts(study.summary)
        )
        parts.append(f"<div class=whole><h3>Summary of the conversion</h3><dl>{rows}</dl></div>")
    return "".join(parts)


def _write_titled_table(title: str, heads: Row, rows: Iterable[Row]) -> str:
    body = "".join("<tr>" + "".join(map(_write_cell, row)) + "</tr>" for row in rows)
    return f"<div><h3>{title}</h3>{write_table(heads, body) if body else '<p>none</p>'}</div>"


def _write_cell(text: str) -> str:
    """Write a cell; a long one, such as a path, breaks anywhere, but numbers never do."""
    return f"<td{' class=long' if len(text) > _LONG_CELL else ''}>{escape_text(text)}</td>"


def write_table(heads: Row, body: str) -> str:
    """Write a table: heads and rows that are HTML already."""
    columns = "".join(f"<th scope=col>{head}</th>" for head in heads)
    return f"<table><thead><tr>{columns}</tr></thead><tbody>{body}</tbody></table>"


def _describe_use(study: Study, tool: int) -> tuple[str, str]:
    """At which spindle speeds a tool cuts, and how long it is in the spindle."""
    program = study.program
    assert program is not None
    moves = program.moves
    used = find_tool_of_moves(np.arange(len(moves)), program.path.first_move, moves) == tool
    used &= np.isfinite(moves.feed) & (moves.kind != MoveKind.DWELL)
    speeds = [f"{speed:g}" for speed in np.unique(moves.spindle[used]).tolist() if speed > 0]
    seconds = sum(one.seconds for one in study.operations if one.tool == tool)
    return _join_few(speeds, "more") if speeds else "off", f"{seconds:.3f}" if study.timed else ""


def _list_tools(study: Study) -> list[tuple[int, str, str, str]]:
    """Number, name, length and diameter of each tool in use; once for each length."""
    program = study.program
    assert program is not None
    listed = program.options.tools or {}
    names = name_tools(program.moves.events)
    rows = []
    for number, length in list_tool_lengths(program)[0]:
        tool = listed.get(number)
        known = tool is not None and tool.diameter > 0
        rows.append(
            (
                number,
                spell_tool_word(number, names) if number else "not named",
                f"{length:g}",
                f"{tool.diameter:g}" if tool and known else "not given",
            )
        )
    return rows


def _list_offsets(machine: Machine, study: Study) -> list[Row]:
    program = study.program
    assert program is not None
    move = program.path.move
    used = find_used(program.moves.frame[move[move >= 0]]).tolist()
    rows: dict[Row, None] = {}
    for frame in sorted((program.moves.frames[index] for index in used), key=lambda frame: frame.system):
        place = machine.find_origin_on_table(frame)
        who = find_placer(frame, machine, program.options, program.moves.placed_systems)
        source = {"set-up": "given", "program": "the program"}.get(who, "nobody: rotary centre on the table face")
        rows[SYSTEM_NAMES[frame.system], *(f"{value:g}" for value in place), f"{frame.part_turn:g}", source] = None
    return list(rows)


def _describe_body(body: Box | FixtureMesh | OwnStock) -> Row:
    """Name, system and place of a fixture or the stock; a mesh says by its file where it is."""
    system = "table" if body.system is None else SYSTEM_NAMES[body.system]
    match body:
        case Box():
            ends = (f"{low:g} to {high:g}" for low, high in zip(body.low, body.high, strict=True))
            return body.name, system, "; ".join(ends)
        case FixtureMesh():
            return body.name, system, body.file
        case OwnStock():
            return body.name, "", "as the program says"


def _list_actions(study: Study) -> list[Row]:
    program = study.program
    assert program is not None
    waits = [event for event in program.moves.events if event.waits(optional_stop=program.options.optional_stop)]
    rows = {} if study.summary is None else {id(timed.event): timed.row for timed in study.summary.timed}
    cycle = program.cycle

    def describe_time(event: Event) -> str:
        return f"{rows[id(event)] * cycle:.3f} s" if id(event) in rows else ""

    def describe_action(event: Event) -> str:
        return f"put in {describe_tool(event)}" if event.kind == "tool" else _ACTIONS[event.kind].format(**event.data)

    return [(str(event.line), describe_time(event), describe_action(event)) for event in waits]
