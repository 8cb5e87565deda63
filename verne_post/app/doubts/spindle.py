"""The spindle stands in a cut, or turns at no speed or another tool's (VP050) or too fast (VP055); no tool (VP041)."""

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import iterate_blocks
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.machine import Machine
from verne_post.model.moves import Event, Moves, Selection, describe_tool, list_tool_changes
from verne_post.model.options import Options
from verne_post.model.part_setup import list_setup_names
from verne_post.model.plausibility import PLAUSIBLE
from verne_post.model.toolpath import SegmentKind, ToolPath

#: How moves count while a stretch holds: the spindle turns; it stands, and no move counts; it is started later with
#: this tool, and only moves of a cycle count, or never is; it was stopped, and is started again later with this tool,
#: or is not.
_TURNS, _STANDS, _LATER, _NEVER, _PAUSED, _STOPPED = range(6)
#: Where the tool is after a row: in the air, where it was before, in the material.
_AIR, _AS_BEFORE, _IN = 0, -1, 1


class _Stretch(Struct):
    """Moves from ``begin`` on with one state of the spindle, up to the next stretch."""

    begin: int
    mode: int
    event: Event | None = None  #: What has begun it.


def check_spindle(moves: Moves, path: ToolPath) -> list[Finding]:
    """VP050: cuts while the spindle stands, as one finding.

    A program may move at feed rate with a spindle at rest: in the air before M3 and after M5, or with a tool that does
    not turn and is oriented (M19). So moves count only in two cases. With a tool that was called and never started, all
    moves at feed rate but retracts do. After a stop of the spindle, those do that go on from a cut without a rapid or
    a retract between, and, where the spindle is not started again with this tool, what follows a plunge at feed rate.
    A cycle cuts with every feed move, before a start too, but for those after a stop that is its own.
    Programs that call no tool and start no spindle are not concerned.
    """
    stretches = _list_stretches(moves.events)
    begins = np.array([one.begin for one in stretches])
    modes = np.array([one.mode for one in stretches])
    if not _may_cut(path, begins, modes):
        return []
    stop_lines = np.array([one.event.line if one.event is not None else 0 for one in stretches])
    of_cycles = moves.find_of_cycles()
    count, first, last, state = 0, -1, -1, _AIR
    for begin, end in iterate_blocks(len(path)):
        move = path.move[begin:end]
        at = np.searchsorted(begins, move, side="right") - 1
        mode = modes[at]  # M5 may act at the end of its block
        own_line = (moves.line[move] == stop_lines[at]) & (move >= 0)
        cuts, marks = _judge_rows(path, begin, end, mode)
        states = _fill_forward(marks, state)
        state = int(states[-1])
        goes_on = ((mode >= _PAUSED) & (states == _IN)) | ((mode >= _LATER) & of_cycles[move])
        counted = np.flatnonzero(cuts & ((mode == _NEVER) | (goes_on & ~own_line)))
        if len(counted):
            first, last = int(move[counted[0]]) if first < 0 else first, int(move[counted[-1]])
            count += len(np.unique(move[counted]))
    if first < 0:
        return []
    number = int(np.searchsorted(begins, first, side="right")) - 1
    stretch = stretches[number]
    event = stretch.event
    assert event is not None
    start = stretches[number + 1].event if stretch.mode in (_LATER, _PAUSED) else None
    after = f"after the change to {describe_tool(event)} in line {event.line}"
    if event.kind != "tool":
        why = f"line {event.line} stops it" + (f", and line {start.line} starts it again" if start else "")
    else:
        why = f"line {start.line} is the first that starts it {after}" if start else f"nothing starts it {after}"
    # where it is started later, that start stands too low; in a CL file SPINDL is a line of its own
    is_startable = event.kind == "tool" and start is None and moves.language != "aptcl"
    edits = (Remedy("start the spindle", "M3", line=event.line),) if is_startable else ()
    line, last_line = int(moves.line[first]), int(moves.line[last])
    several = "a move" if count == 1 else f"{count} moves"
    text = f"the spindle does not turn in {several} at feed rate: {why}"
    lines = {"line": line, "last_line": max(line, last_line), "worst_line": line}
    return [make_finding("VP050", text, **lines, count=count, edits=edits)]


def _find_wrong_start(text: str, line: int) -> Finding:
    """VP050 of a spindle that turns; its message says what to write, so that no general remedy is added."""
    return make_finding("VP050", text, line=line, advice="")


def check_speed(moves: Moves, path: ToolPath) -> list[Finding]:
    """VP050: a spindle is started, and cuts before a block has given its speed, or at S0; the first start is named."""
    if any(one.is_defined and not one.is_loaded for one in moves.selections[-1:]):
        return []  # TOOL CALL, which gives it, is what is missing (VP041)
    switches = [event for event in moves.events if event.kind == "spindle"]
    ends = [*(event.before for event in switches), math.inf][1:]
    for event, end in zip(switches, ends, strict=True):
        if event.data["direction"] == "stop" or event.data["speed"]:
            continue
        cut = find_first_cut(path, event.before)
        if not 0 <= cut < end:
            continue
        zeros = [line for line, move in moves.speeds if move <= cut]
        line = zeros[-1] if zeros else event.line
        when = "before the cut " if any(one.data["speed"] for one in switches) else ""
        text = (
            f"S0: the spindle does not turn in the cut of line {int(moves.line[cut])}; write its speed"
            if zeros
            else f"the spindle is started here, and no block {when}gives its speed: on a control it turns as fast as "
            f"before the program, or not at all; write {'SPINDL and its speed' if moves.language == 'aptcl' else 'S'}"
        )
        return [_find_wrong_start(text, line)]
    return []


def check_highest_speed(moves: Moves, machine: Machine) -> Iterator[Finding]:
    """VP055, a warning for each speed above the machine's: it is given at the move's line, or before it.

    Where the machine file gives none, VP505: a speed that no spindle has.
    """
    told, plausible = set[float](), PLAUSIBLE["spindle speed"]
    highest = machine.spindle_rpm if math.isfinite(machine.spindle_rpm) else plausible.high
    for begin, end in iterate_blocks(len(moves)):
        above = np.flatnonzero(moves.spindle[begin:end] > highest) + begin
        speeds, first = np.unique(moves.spindle[above], return_index=True)
        for speed, at in zip(speeds.tolist(), above[first].tolist(), strict=True):
            if speed in told:
                continue
            told.add(speed)
            given = [line for line, move in moves.speeds if move <= at]
            line = given[-1] if given else int(moves.line[at])
            if not math.isfinite(machine.spindle_rpm):
                text = (
                    f"S{speed:.10g}: no {plausible.whose} has more than {highest:.10g} {plausible.unit}; is a digit "
                    "too many, or a decimal point missing?"
                )
                yield make_finding("VP505", text, line=line)
                continue
            text = (
                f"S{speed:g} is above {machine.spindle_rpm:g} 1/min, max_speed_rpm of the machine file: a control "
                "lowers the speed, or stops; write a lower S, and F in the same ratio"
            )
            yield make_finding("VP055", text, line=line, limit=machine.spindle_rpm, advice="")


def check_direction(moves: Moves, path: ToolPath) -> Iterator[Finding]:
    """VP050: a tool cuts, and each start of the spindle since its change turns it counter-clockwise (M4).

    A thread is tapped both ways. A program that calls no tool may use M4 for something else, as for a laser.
    """
    changes = [event for event in moves.events if event.kind == "tool"]
    ends = [*(event.before for event in changes), math.inf][1:]
    forwards, backwards = ("CLW", "CCLW") if moves.language == "aptcl" else ("M3", "M4")
    for event, end in zip(changes, ends, strict=True):
        starts = [
            one
            for one in moves.events
            if one.kind == "spindle" and event.before <= one.before < end and one.data["direction"] != "stop"
        ]
        if not starts or any(one.data["direction"] == "clockwise" for one in starts):
            continue
        first_cut = find_first_cut(path, starts[0].before)
        if 0 <= first_cut < end:
            line = starts[0].line
            text = (
                f"{describe_tool(event)} turns counter-clockwise ({backwards}) where it cuts, from line "
                f"{int(moves.line[first_cut])} on: a right-hand drill or mill does not cut then; write {forwards} "
                "unless it is a left-hand tool"
            )
            yield _find_wrong_start(text, line)


def check_kept_speed(moves: Moves, path: ToolPath) -> Iterator[Finding]:
    """VP050: a tool cuts with the speed of the tool before, because no block has given S since it was loaded."""
    changes = [(at, event) for at, event in enumerate(moves.events) if event.kind == "tool"]
    ends = [*((at, event.before) for at, event in changes[1:]), (len(moves.events), math.inf)]
    numbers = [0, *(event.tool for _at, event in changes)]
    for (at, event), (last, end), (before, number) in zip(
        changes, ends[: len(changes)], pairwise(numbers), strict=True
    ):
        if not before or number in (0, before):
            continue
        starts = [one for one in moves.events[at:last] if one.kind == "spindle" and one.data["direction"] != "stop"]
        is_given = any(line == event.line or event.before <= move < end for line, move in moves.speeds)
        if not starts or is_given or not starts[0].data["speed"]:
            continue
        if 0 <= find_first_cut(path, starts[0].before) < end:
            line = starts[0].line
            text = (
                f"the spindle starts with S{starts[0].data['speed']:g} of the tool before: no block gives S after the "
                f"change to {describe_tool(event)} in line {event.line}; write S"
            )
            yield _find_wrong_start(text, line)


def check_kept_feed(moves: Moves, path: ToolPath) -> Iterator[Finding]:
    """VP009, a warning: a tool cuts at the feed rate of the tool before, because none was given since the change."""
    changes = [event for event in moves.events if event.kind == "tool"]
    ends = [*(event.before for event in changes), math.inf][1:]
    number = 0
    for event, end in zip(changes, ends, strict=True):
        before, number = number, event.tool
        cut = find_first_cut(path, event.before)
        if not before or number in (0, before) or not event.before <= cut < end:
            continue
        if any(event.before <= move <= cut for move in moves.feeds):
            continue
        line = int(moves.line[cut])
        text = (
            f"the tool cuts at the feed rate of the tool before: no block gives F after the change to "
            f"{describe_tool(event)} in line {event.line}; write F"
        )
        yield make_finding("VP009", text, severity="warning", line=line)


def check_tool_change(moves: Moves, path: ToolPath) -> list[Finding]:
    """VP041: T selects a tool, and the program cuts on without M6, each tool once; not what the moves have told.

    Programs make the next tool ready while another one cuts: that T stands beside M6, or before the first cut after it.
    So a T counts where it comes after a cut of the tool before, or before any tool is loaded.
    """
    found = dict[int, Finding]()
    told = {item.line for item in moves.findings if item.code == "VP041"}
    lengths = [item.line or 0 for item in moves.findings if item.quantity == "length"]
    loads = [(event.before, number) for event, number in list_tool_changes(moves.events)]
    for index, one in enumerate(moves.selections):
        then = moves.selections[index + 1] if index + 1 < len(moves.selections) else None
        if one.is_loaded or not one.number or one.number in found or one.line in told:
            continue
        end = math.inf if then is None else then.line
        if any(one.line <= line < end for line in lengths) or (then is not None and then.number == one.number):
            continue
        loaded, number = next((load for load in reversed(loads) if load[0] <= one.before), (-1, 0))
        is_staged = loaded >= 0 and not 0 <= find_first_cut(path, loaded) < one.before
        first = -1 if is_staged or number == one.number else find_first_cut(path, one.before)
        if first < 0 or (then is not None and first >= then.before):
            continue
        cut, word = int(moves.line[first]), one.spell()
        load, call = "M6", one.describe_change()
        if one.is_defined:
            load, call = "TOOL CALL", f"TOOL CALL {one.number} Z S with its speed after {word}"
        text = (
            f"{word} only selects the tool, and no {load} loads it: line {cut} cuts with the tool that was in the "
            f"spindle before; write {call}"
        )
        where = {"line": one.line, "last_line": max(one.line, cut), "worst_line": one.line}
        found[one.number] = make_finding("VP041", text, **where, tool=one.number, edits=one.propose_change())
    return list(found.values())


def check_first_tool(moves: Moves, path: ToolPath, options: Options) -> Iterator[Finding]:
    """VP041: a program cuts before its first tool change, and then changes tools between cuts: the first is missing.

    A program without any change is for the tool that is in the spindle. It is the tool of ``options`` that has the
    length in force, where one alone has it.
    """
    event = next((event for event, number in list_tool_changes(moves.events) if number), None)
    first = -1 if event is None else find_first_cut(path, 0)
    if event is None or not 0 <= first < event.before or moves.language in ("heidenhain", "aptcl"):
        return
    is_told = "VP041" in {item.code for item in moves.findings if (item.line or 0) < event.line}
    if is_told or find_first_cut(path, event.before) < 0:
        return
    own = moves.frames[moves.frame[first]].tool_length
    tools = (options.tools or {}).items()
    numbers = [number for number, tool in tools if own and abs(tool.offset[2] - own) < ZERO_LENGTH_MM]
    names = list_setup_names(options.control) if moves.language == "siemens" else {}  # the others change by number
    name = names.get(numbers[0], "") if len(numbers) == 1 else ""
    word = Selection(numbers[0], 0, 0, name).spell() if len(numbers) == 1 else "T and"
    what = f"{word} M6"
    line = int(moves.line[first])
    text = (
        f"no block before this cut loads a tool, and line {event.line} is the first that does: the cut is made with "
        f"whatever tool is in the spindle before the program; write {what} before it"
    )
    yield make_finding("VP041", text, line=line)


def find_first_cut(path: ToolPath, first: int) -> int:
    """The first move at feed rate from a move on; -1 where there is none."""
    for begin, end in iterate_blocks(len(path)):
        move = path.move[begin:end]
        cuts = np.flatnonzero((path.feed_time[begin:end] > 0) & (move >= first))
        if len(cuts):
            return int(move[cuts[0]])
    return -1


def _list_stretches(events: Iterable[Event]) -> list[_Stretch]:
    """Stretches of one state of the spindle, in the order of the moves."""
    found = [_Stretch(0, _STANDS)]
    tool: int | None = None
    for event in events:
        before = found[-1]
        if event.kind == "tool" and event.tool != tool:  # the same tool again: controls may leave it turning
            tool = event.tool
            found.append(_Stretch(event.before, _NEVER if tool else _STANDS, event))
        elif event.kind == "spindle" and event.data["direction"] != "stop":
            if before.mode == _NEVER:
                before.mode = _LATER
            elif before.mode == _STOPPED:
                before.mode = _PAUSED
            found.append(_Stretch(event.before, _TURNS, event))
        elif event.kind == "spindle" and before.mode == _TURNS:
            found.append(_Stretch(event.before, _STOPPED, event))
        elif event.kind == "orient":  # it stands on purpose
            found.append(_Stretch(event.before, _STANDS, event))
    return found


def _may_cut(path: ToolPath, begins: Ints, modes: Ints) -> bool:
    """Whether there is a move at feed rate in a stretch that may count: most programs end here."""
    if not (modes >= _LATER).any():
        return False
    for begin, end in iterate_blocks(len(path)):
        move = path.move[begin:end]
        move = move[(path.feed_time[begin:end] > 0) & (move >= 0)]
        if (modes[np.searchsorted(begins, move, side="right") - 1] >= _LATER).any():
            return True
    return False


def _judge_rows(path: ToolPath, begin: int, end: int, mode: Ints) -> tuple[Mask, Ints]:
    """Which rows move at feed rate and do not retract, and where the tool is after each row."""
    start, finish = path.start[begin:end], path.end[begin:end]
    delta: Array = finish[:, :3] - start[:, :3]
    axis = find_axis_of_angles(finish[:, 3], finish[:, 4])
    up = (delta * axis).sum(axis=1)
    aside = np.linalg.norm(delta - up[:, None] * axis, axis=1)
    feeds = (path.feed_time[begin:end] > 0) & (path.move[begin:end] >= 0)
    travels = (np.linalg.norm(delta, axis=1) > ZERO_LENGTH_MM) | (path.kind[begin:end] != SegmentKind.LINE)
    retracts = (up > ZERO_LENGTH_MM) & (up >= aside)
    cuts = feeds & travels & ~retracts
    marks = np.full(end - begin, _AS_BEFORE)
    marks[~feeds | retracts] = _AIR
    marks[cuts & ((mode == _TURNS) | ((mode == _STOPPED) & (up < -ZERO_LENGTH_MM)))] = _IN
    return cuts, marks


def _fill_forward(marks: Ints, state: int) -> Ints:
    """Every mark that says nothing becomes the last one that does; ``state`` before the first."""
    every = np.concatenate([[state], marks])
    said = np.maximum.accumulate(np.where(every == _AS_BEFORE, 0, np.arange(len(every))))
    filled: Ints = every[said][1:]
    return filled
