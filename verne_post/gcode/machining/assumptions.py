"""After an error: what the core would hold, had the program been right. Nothing of it reaches the user."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from verne_post.gcode.machining.state import State
from verne_post.gcode.missing_setup import ASSUMED_TOOL
from verne_post.model.moves import ZERO9
from verne_post.model.part_setup import FIRST_NAMED_TOOL

#: Number of a tool whose call was not readable: no table has it.
UNREAD_TOOL = FIRST_NAMED_TOOL - 1


def assume_feed(state: State) -> None:
    """Any feed rate will do."""
    state.feed, state.feed_angular = state.feed or 1.0, state.feed_angular or 1.0


def assume_speed(state: State) -> None:
    """Any speed will do."""
    state.spindle_speed = state.spindle_speed or 1.0


def assume_turning_spindle(state: State) -> None:
    """The spindle turns."""
    state.spindle_on = True
    assume_speed(state)


def assume_length(state: State) -> None:
    """Any tool length will do."""
    state.has_tool_length = True


@contextmanager
def add_length(state: State, *, then: bool) -> Iterator[None]:
    """A length counts as given meanwhile, and afterwards where it was or ``then``."""
    given, state.has_tool_length = state.has_tool_length, True
    try:
        yield
    finally:
        state.has_tool_length = given or then


def assume_tools(state: State, numbers: Iterable[int]) -> None:
    """Tools are in the table."""
    new = {number: replace(ASSUMED_TOOL, number=number, pocket=number) for number in numbers}
    state.tools = {**(state.tools or {}), **new}


def assume_loaded_tool(state: State, number: int | None) -> None:
    """A tool is in the spindle, and in the table."""
    state.loaded_tool = number
    state.tools = {number or 0: ASSUMED_TOOL, **(state.tools or {})}


@contextmanager
def keep_only_tool(state: State) -> Iterator[None]:
    """The tool whose length is --tool-length is afterwards the one that it was before, if there was one."""
    only_tool = state.only_tool
    try:
        yield
    finally:
        state.only_tool = state.only_tool if only_tool is None else only_tool


def assume_only_tool(state: State) -> None:
    """--tool-length is that of the next tool."""
    state.only_tool = None


def assume_tool_call(state: State) -> None:
    """A tool has been called, and is in the spindle."""
    assume_tools(state, [UNREAD_TOOL])
    state.selected_tool = state.loaded_tool = UNREAD_TOOL


def assume_homes(state: State) -> None:
    """Both home positions are somewhere."""
    state.home = state.home2 = ZERO9


def assume_rigid_tapping(state: State) -> None:
    """Rigid tapping is meant."""
    state.taps_rigidly = True


def drop_compensation(state: State) -> None:
    """What the contour would have been is not known."""
    if state.compensation is not None or state.centre is not None:
        state.compensation = state.centre = None
        state.arc_may_follow = True


def place_axis(state: State, axis: int, value: float) -> None:
    """An axis stands where its word says (mm, degrees)."""
    state.position = [value if i == axis else old for i, old in enumerate(state.position)]
    name_axis(state, axis)


def name_axis(state: State, axis: int) -> None:
    """The program has said where an axis is."""
    state.known_axes[axis] = state.named_axes[axis] = True


def know_axis(state: State, axis: int) -> None:
    """The position of an axis counts as known."""
    state.known_axes[axis] = True


def forget_change_of_length(state: State) -> None:
    """The motion that has to follow a change of the tool length counts as made."""
    state.values_before_length = None


def lose_axis(state: State, axis: int) -> None:
    """Where an axis stands is not known."""
    state.known_axes[axis] = False


def place(state: State, position: list[float]) -> None:
    """The axes stand at a position (9)."""
    state.position = position
