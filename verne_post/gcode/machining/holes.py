"""Holes in every language: how many are taken at once, and how a thread is tapped."""

from collections.abc import Callable, Sequence
from typing import Final

from msgspec import Struct

from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At, ProgramError
from verne_post.model.moves import FeedMode

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


def note_tapping(core: Machining, at: At) -> None:
    """Say (VP047) what the control must do where tapping is feed moves."""
    if core.setup.tapping == "feed":
        core.recorder.note_once(
            "VP047",
            "the control must couple the spindle to the moves of each tap: events at their ends have its direction "
            "and speed",
            at.line,
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
    note_tapping(core, at)
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
