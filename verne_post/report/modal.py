"""The modal state at moves of a program, in words that hold for every dialect."""

from typing import Final

import numpy as np

from verne_post.model.moves import FeedMode, MoveKind, Moves, PathControl, PathMode, find_tool_of_moves
from verne_post.model.part_setup import name_system, spell_tool_word

#: A state: what, and its value.
State = tuple[tuple[str, str], ...]
_FEED_UNITS: Final = {
    FeedMode.PER_MINUTE: "mm/min",
    FeedMode.INVERSE: "1/min (inverse time)",
    FeedMode.PER_REVOLUTION: "mm/rev",
}
_PATH_MODES: Final = {PathMode.EXACT_PATH: "exact path", PathMode.EXACT_STOP: "exact stop", PathMode.BLEND: "blended"}


def collect_modal_states(moves: Moves, move: np.ndarray, first_move: int) -> tuple[list[State], np.ndarray]:
    """Modal states at moves (n,): the different ones, and which of them holds at each (n,); -1 is the approach."""
    numbers, index = np.unique(move, return_inverse=True)
    tools = find_tool_of_moves(numbers, first_move, moves)
    spindle, coolant = (_find_last_events(moves, kind, numbers) for kind in ("spindle", "coolant"))
    states: dict[State, int] = {}
    of = np.array(
        [
            states.setdefault(_describe(moves, int(number), int(tool), turns, cools), len(states))
            for number, tool, turns, cools in zip(numbers, tools, spindle, coolant, strict=True)
        ],
        dtype=np.int32,
    )
    return list(states), of[index]


def _find_last_events(moves: Moves, kind: str, number: np.ndarray) -> list[dict[str, object]]:
    """What the last event of a kind before each move says; nothing where there is none."""
    found = [event for event in moves.events if event.kind == kind]
    at = np.searchsorted([event.before for event in found], number, side="right")
    return [found[k - 1].data if k else {} for k in at.tolist()]


def _describe(moves: Moves, number: int, tool: int, spindle: dict[str, object], coolant: dict[str, object]) -> State:
    if number < 0:
        return (("motion", "approach or departure"),)
    frame = moves.frames[moves.frame[number]]
    plane, speed = frame.feature, float(moves.spindle[number])
    turning = f"{speed:g}/min {spindle.get('direction', '')}".strip() if speed else "off"
    name = f"{spell_tool_word(tool, moves.name_tools())}, " if tool else ""
    return (
        ("motion", _describe_motion(moves, number)),
        ("feed", describe_feed(moves, number)),
        ("spindle", turning),
        ("coolant", str(coolant.get("state", "off"))),
        ("tool", f"{name}length {frame.tool_length:g} mm"),
        ("work offset", name_system(frame.system) + (", shifted (G92)" if any(frame.g92) else "")),
        ("work plane", "tilted" if plane is not None and plane.is_programmed and not plane.is_level else "not tilted"),
        ("corners", _describe_corners(moves.controls[moves.control[number]])),
    )


def _describe_motion(moves: Moves, number: int) -> str:
    kind = MoveKind(moves.kind[number])
    if kind == MoveKind.ARC:
        return "arc, counterclockwise" if moves.arcs.turns[moves.arc[number]] > 0 else "arc, clockwise"
    return {
        MoveKind.RAPID: "rapid",
        MoveKind.FEED: "straight feed",
        MoveKind.DWELL: "dwell",
        MoveKind.SPLINE: "spline",
        MoveKind.TURN: "turn of the table",
        MoveKind.SWING: "turn of the tool about a point",
    }[kind]


def describe_feed(moves: Moves, number: int) -> str:
    """The feed rate of a move with its unit, the length of a dwell, or that it is a rapid."""
    feed, kind = float(moves.feed[number]), MoveKind(moves.kind[number])
    if kind == MoveKind.DWELL:
        return f"{feed:g} s"
    if np.isnan(feed):
        return "rapid"
    mode = FeedMode(moves.feed_mode[number])
    turns = kind in (MoveKind.TURN, MoveKind.SWING) or (
        kind == MoveKind.FEED
        and number > 0
        and moves.frame[number] == moves.frame[number - 1]
        and np.array_equal(*moves.end[number - 1 : number + 1, :3])
    )
    return f"{feed:.6g} {'deg/min' if turns and mode == FeedMode.PER_MINUTE else _FEED_UNITS[mode]}"


def _describe_corners(control: PathControl) -> str:
    text = _PATH_MODES[control.mode]
    return text if control.tolerance is None else f"{text} within {control.tolerance:g} mm"
