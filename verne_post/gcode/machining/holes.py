"""Holes in every language: how many are taken at once, and how a thread is tapped."""

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from typing import Final

from msgspec import Struct

from verne_post.base.printable import join_names
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At, ProgramError
from verne_post.model.moves import FeedMode, Tap

#: Holes of one block: more is a wrong number, and would run for hours.
MAX_HOLES: Final = 10_000
#: Pecks in all holes of one block.
MAX_PECKS: Final = 30_000


class Thread(Struct, frozen=True):
    """A thread that a tap cuts."""

    pitch: float  #: mm.
    left_hand: bool  #: The spindle turns counter-clockwise on the way in.
    #: speed_in, speed_out: Of the spindle, 1/min.
    speed_in: float
    speed_out: float
    dwell: float = 0.0  #: At the bottom, s.
    line: int | None = None  #: Where the program gives the pitch, if not in the block that taps.


#: Pitch of ISO coarse threads, mm: size M -> pitch.
METRIC_PITCH: Final = {
    3.0: 0.5, 4.0: 0.7, 5.0: 0.8, 6.0: 1.0, 7.0: 1.0, 8.0: 1.25, 10.0: 1.5, 12.0: 1.75, 14.0: 2.0, 16.0: 2.0, 18.0: 2.5,
    20.0: 2.5, 22.0: 2.5, 24.0: 3.0,
    27.0: 3.0, 30.0: 3.5, 33.0: 3.5, 36.0: 4.0, 39.0: 4.0, 42.0: 4.5, 45.0: 4.5, 48.0: 5.0,
}  # fmt: skip
#: So many pitches of a program are named.
_NAMED_PITCHES: Final = 6
#: Key of a set-up that settles rigid tapping.
TAPPING_KEY: Final = ("tapping",)


def check_tapping(core: Machining, column: int | None = None) -> None:
    """Refuse (VP048) rigid tapping that nobody has allowed, in the same words everywhere: one finding a program."""
    if core.setup.tapping != "feed" and not core.state.taps_rigidly:
        raise ProgramError(
            "VP048",
            "rigid tapping: setpoints do not turn the spindle; for a control that couples it, --tapping feed makes "
            "the moves in and out at pitch times speed",
            column,
            settled_by=TAPPING_KEY,
        )


def note_tapping(core: Machining, at: At, pitch: float | None = None, line: int | None = None) -> None:
    """Keep the pitch of a thread, and say (VP047) what the control must do where tapping is feed moves.

    ``pitch`` is in mm, and given in a ``line``; None where feed rate and speed in force make it, in the block.
    """
    recorder, state = core.recorder, core.state
    if pitch is None:
        per_turn = state.feed_mode == FeedMode.PER_REVOLUTION
        speed = 1.0 if per_turn else state.spindle_speed
        pitch = state.feed / speed if speed > 0.0 else 0.0
    key = state.loaded_tool, float(f"{pitch:.4g}") if pitch > 0.0 else 0.0
    if key in recorder.taps:
        return
    before = _describe_coupling(tap.pitch for tap in recorder.taps.values())
    recorder.taps[key] = Tap(recorder.lines.find_own(line or at.line), recorder.count, *key)
    if core.setup.tapping == "feed":
        text = _describe_coupling(tap.pitch for tap in recorder.taps.values())
        key_of_note = next((one for one, item in recorder.warnings.items() if item.code == "VP047"), None)
        if key_of_note is None:
            recorder.warn("VP047", text, at.line, None)
        else:
            item = recorder.warnings[key_of_note]
            recorder.warnings[key_of_note] = dataclasses.replace(item, message=item.message.replace(before, text))


def _describe_coupling(pitches: Iterable[float]) -> str:
    """What the control must do, and for which pitches."""
    every = [f"{pitch:g}" for pitch in dict.fromkeys(pitches) if pitch]
    names = join_names([*every[:_NAMED_PITCHES], *(["others"] if len(every) > _NAMED_PITCHES else [])])
    turn = f" ({names} mm a turn)" if every else ""
    return (
        f"the control must couple the spindle to the moves of each tap{turn}: events at their ends have its direction "
        "and speed"
    )


def tap(
    core: Machining,
    at: At,
    thread: Thread,
    places: Sequence[float],
    go: Callable[[float], None],
    after: tuple[bool, bool],
) -> None:
    """Tap a thread from where the tool stands over it: in and out by turns, the spindle forwards and backwards.

    Parameters
    ----------
    core : Machining
    at : At
    thread : Thread
    places : sequence of float
        Where the moves lead: in, out, in, ..., out; only the last way in has the dwell.
    go : callable
        Moves along the hole to a place at the feed rate in force.
    after : tuple of bool
        Whether the spindle turns then, and counter-clockwise; at the speed of before.
    """
    auxiliary, before = core.auxiliary, core.state.spindle_speed
    note_tapping(core, at, thread.pitch, thread.line)
    with core.keep_feed():
        core.set_feed_mode(FeedMode.PER_MINUTE, keep_feed=True)
        for number, place in enumerate(places):
            out = number % 2 == 1
            speed = thread.speed_out if out else thread.speed_in
            auxiliary.set_speed(at, speed, is_switched=True)
            auxiliary.switch_spindle(at, on=True, backwards=thread.left_hand != out)
            core.set_feed(thread.pitch * speed)
            go(place)
            if number == len(places) - 2 and thread.dwell:
                core.dwell(at, thread.dwell)
    auxiliary.set_speed(at, before, is_switched=True)
    auxiliary.switch_spindle(at, on=after[0], backwards=after[1])
