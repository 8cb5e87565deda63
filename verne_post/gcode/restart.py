"""Block search, ``--from-line``: where a program can be restarted, and what must be switched on before."""

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.long_text import Text
from verne_post.gcode.execution import LineTrace, StopConditions
from verne_post.gcode.machining.state import State, describe_tool_event, name_unit_of_speed
from verne_post.gcode.read import replay
from verne_post.gcode.setup import Setup
from verne_post.model.findings import make_input_error
from verne_post.model.moves import Event, Moves


class Restart(Struct, frozen=True):
    """Begin of the remaining program: its first move and event, and what the skipped blocks have switched on."""

    move: int
    event: int
    switched_events: tuple[Event, ...]


def restart_at(source: Text, setup: Setup, moves: Moves, line: int) -> Restart:
    """Replay a program that has been read, up to a line.

    Parameters
    ----------
    setup : Setup
        As it was read with.
    moves : Moves
        What was read, with the position at which the program starts.
    line : int
        1-based; the first line that is to be executed.

    Raises
    ------
    InputError
        VP029: the line is not executed exactly once by the program itself, or cutter compensation or a canned cycle
        holds there; names the nearest line that will do.
    """
    trace = LineTrace()
    replay(source, setup, moves, StopConditions(trace=trace))
    spans = np.array(trace.spans, dtype=np.int64).reshape(-1, 3)
    why = _explain_refusal(spans, line)
    if why is not None:
        near = _find_nearest(spans, line)
        right = "no line of this program will do" if near is None else f"the nearest line that will do is {near}"
        raise make_input_error(
            "VP029", f"no restart at line {line}: {why}; {right}", line=line, last_line=line, worst_line=line
        )
    state, recorder = replay(source, setup, moves, StopConditions(before_line=line))
    ahead = [event for event in moves.events[len(recorder.events) :] if event.before <= recorder.count]
    events = [*_restore_functions(state, line), *_find_last_outputs(recorder.events)]
    return Restart(recorder.count, len(recorder.events), tuple(one for one in events if not _is_replaced(one, ahead)))


def _explain_refusal(spans: np.ndarray, line: int) -> str | None:
    """Why a program cannot be restarted at a line; None where it can."""
    times = spans[(spans[:, 0] <= line) & (line < spans[:, 1])]
    if not len(times):
        return "the program does not execute it, or only in a subprogram"
    if len(times) > 1:
        return f"it is executed {len(times)} times"
    return None if times[0, 2] else "cutter compensation, a canned cycle or a spline goes on there"


def _find_nearest(spans: np.ndarray, line: int) -> int | None:
    """The nearest line at which a program can be restarted; of two the earlier one."""
    good = spans[spans[:, 2] == 1]
    # spans end where the order of execution jumps, so that a line between their ends is no better than those
    candidates = np.unique(np.concatenate([good[:, 0], good[:, 1] - 1, np.clip(line, good[:, 0], good[:, 1] - 1)]))
    for candidate in candidates[np.argsort(np.abs(candidates - line), kind="stable")].tolist():
        if _explain_refusal(spans, candidate) is None:
            return int(candidate)
    return None


def _find_last_outputs(events: list[Event]) -> list[Event]:
    """The last skipped event of each output and user-defined code: what these still hold is not known here."""
    last: dict[tuple[str, object], Event] = {}
    for event in events:
        if event.kind in ("signal", "remapped"):
            last[event.kind, event.data.get("output", event.data.get("code"))] = event
    return [replace(event, before=0) for event in last.values()]


def _is_replaced(switched_event: Event, ahead: list[Event]) -> bool:
    """True where blocks from the restart to its first motion set something else; a tool change stops the spindle."""
    kinds = {"spindle": ("spindle", "tool"), "tool": ("tool", "tool number")}.get(
        switched_event.kind, (switched_event.kind,)
    )
    if switched_event.kind == "signal":
        return any(event.kind == "signal" and event.data["output"] == switched_event.data["output"] for event in ahead)
    return switched_event.kind != "remapped" and any(event.kind in kinds for event in ahead)


def _restore_functions(state: State, line: int) -> tuple[Event, ...]:
    """Tool, spindle, coolant and overrides that hold, as events before the first move."""
    functions: list[tuple[str, dict[str, object]]] = []
    if state.loaded_tool is not None:
        functions.append(("tool", describe_tool_event(state, state.loaded_tool)))
    if state.spindle_on:
        direction = "counterclockwise" if state.spindle_reversed else "clockwise"
        functions.append(
            ("spindle", {"direction": direction, "speed": state.spindle_speed} | name_unit_of_speed(state))
        )
    functions += [("coolant", {"state": name}) for on, name in ((state.mist, "mist"), (state.flood, "flood")) if on]
    if not state.overrides["feed"] or not state.overrides["speed"]:
        functions.append(("override", dict(state.overrides)))
    return tuple(Event(line, kind, 0, data) for kind, data in functions)
