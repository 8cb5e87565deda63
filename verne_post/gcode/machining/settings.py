"""Settings of the machining core that a program may save and bring back."""

from collections.abc import Mapping

from msgspec import Struct

from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At
from verne_post.model.moves import FeedMode, PathControl


class Settings(Struct, frozen=True):
    """Plane, path control, feed, spindle (on, backwards, speed, surface speed), coolant (mist, flood), overrides."""

    plane: int
    control: PathControl
    feed: tuple[float, float, FeedMode]
    spindle: tuple[bool, bool, float, bool]
    coolant: tuple[bool, bool]
    overrides: Mapping[str, bool]


def save_settings(core: Machining) -> Settings:
    """What is in force."""
    state = core.state
    return Settings(
        state.plane,
        state.control,
        (state.feed, state.feed_angular, state.feed_mode),
        (state.spindle_on, state.spindle_reversed, state.spindle_speed, state.surface_speed),
        (state.mist, state.flood),
        dict(state.overrides),
    )


def restore_settings(core: Machining, at: At, settings: Settings) -> None:
    """Bring back what was in force, with events for what that switches."""
    state, auxiliary = core.state, core.auxiliary
    state.plane, state.control = settings.plane, settings.control
    state.feed, state.feed_angular, state.feed_mode = settings.feed
    auxiliary.restore_spindle(at, *settings.spindle)
    auxiliary.restore_coolant(at, *settings.coolant)
    auxiliary.restore_overrides(at, settings.overrides)
