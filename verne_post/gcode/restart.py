"""Block search, ``--from-line``: where a program can be restarted, and what must be switched on before."""

from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.long_text import Text
from verne_post.gcode.execution import LineTrace, StopConditions
from verne_post.gcode.machining.state import OVERRIDES, State, describe_tool_event, name_unit_of_speed
from verne_post.gcode.read import replay
from verne_post.gcode.setup import Setup
from verne_post.model.findings import make_input_error
from verne_post.model.moves import Event, Moves

#: Kinds of events that say whether the spindle turns.
_TURNS: Final = ("spindle", "orient", "tool")


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
        raise make_input_error("VP029", f"no restart at line {line}: {why}; {right}", line=line)
    state, recorder = replay(source, setup, moves, StopConditions(before_line=line))
    ahead = [event for event in moves.events[len(recorder.events) :] if event.before <= recorder.count]
    events = [*_restore_functions(state, recorder.events, line), *_find_last_executed(recorder.events)]
    return Restart(recorder.count, len(recorder.events), tuple(one for one in events if not _is_replaced(one, ahead)))


def _explain_refusal(spans: np.ndarray, line: int) -> str | None:
    """Why a program cannot be restarted at a line; None where it can."""
    times = spans[(spans[:, 0] <= line) & (line < spans[:, 1])]
    if not len(times):
        return "the program does not execute it, or only in a subprogram"
    if len(times) > 1:
        return f"it is executed {len(times)} times"
    return None if times[0, 2] else "a statement, cutter compensation, a canned cycle or a spline goes on there"


def _find_nearest(spans: np.ndarray, line: int) -> int | None:
    """The nearest line at which a program can be restarted; of two the earlier one."""
    good = spans[spans[:, 2] == 1]
    # spans end where the order of execution jumps, so that a line between their ends is no better than those
    candidates = np.unique(np.concatenate([good[:, 0], good[:, 1] - 1, np.clip(line, good[:, 0], good[:, 1] - 1)]))
    for candidate in candidates[np.argsort(np.abs(candidates - line), kind="stable")].tolist():
        if _explain_refusal(spans, candidate) is None:
            return int(candidate)
    return None


def _find_last_executed(events: list[Event]) -> list[Event]:
    """Skipped outputs, H functions and user-defined codes, in the order in which the program executed each one last.

    What a code of the builder does is not known here. So each set of its words counts, and one may cancel another.
    """
    last: dict[tuple[object, ...], Event] = {}
    for event in events:
        if event.kind in ("signal", "remapped", "auxiliary"):
            key = _name_output(event) if event.kind == "signal" else (event.kind, *event.data.items())
            last.pop(key, None)  # a dict keeps the place of the first insertion
            last[key] = replace(event, before=0)
    return list(last.values())


def _name_output(event: Event) -> tuple[object, ...]:
    """Digital and analog outputs of a number are two."""
    return "signal", event.data["output"], "on" in event.data


def _is_replaced(switched_event: Event, ahead: list[Event]) -> bool:
    """True where blocks from the restart to its first motion set something else; a tool change stops the spindle."""
    kind = switched_event.kind
    if kind == "signal":
        return any(one.kind == kind and _name_output(one) == _name_output(switched_event) for one in ahead)
    if kind == "coolant":  # mist and flood may be on together
        return any(one.kind == kind and one.data["state"] in ("off", switched_event.data["state"]) for one in ahead)
    kinds = {"spindle": _TURNS, "orient": _TURNS, "tool": ("tool", "tool number")}.get(kind, (kind,))
    return kind not in ("remapped", "auxiliary") and any(one.kind in kinds for one in ahead)


def _restore_functions(state: State, events: list[Event], line: int) -> tuple[Event, ...]:
    """Tool, spindle, coolant and overrides that hold after skipped events, as events before the first move."""
    functions: list[tuple[str, dict[str, object]]] = []
    if state.loaded_tool is not None:
        functions.append(("tool", describe_tool_event(state, state.loaded_tool)))
    modes = [one for one in events if one.kind == "spindle mode"][-1:]
    functions += [
        (one.kind, one.data | ({"speed": state.spindle_speed} if "speed" in one.data else {})) for one in modes
    ]
    if state.spindle_on:
        direction = "counterclockwise" if state.spindle_reversed else "clockwise"
        functions.append(
            ("spindle", {"direction": direction, "speed": state.spindle_speed} | name_unit_of_speed(state))
        )
    turns = [one for one in events if one.kind in _TURNS][-1:]
    functions += [(one.kind, one.data) for one in turns if one.kind == "orient"]
    functions += [("coolant", {"state": name}) for on, name in ((state.mist, "mist"), (state.flood, "flood")) if on]
    if state.overrides != OVERRIDES:
        functions.append(("override", dict(state.overrides)))
    tool = state.loaded_tool or 0
    return tuple(Event(line, kind, 0, data, tool=tool if kind == "tool" else 0) for kind, data in functions)
