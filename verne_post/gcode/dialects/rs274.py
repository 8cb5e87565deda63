"""RS274/NGC as LinuxCNC speaks it, the language of the interpreter itself; and as other controls of the family do.

What they do alike is the interpreter's; what differs is named here, and docs/gcode.md has the table.
"""

from collections.abc import Mapping
from typing import ClassVar, Final

from msgspec.structs import replace

from verne_post.base.long_text import Text
from verne_post.gcode.dialect import Dialect, build_dialect_of_blocks
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.initial_state import initial_state
from verne_post.gcode.machining.state import State
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.run import execute_blocks
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import Rs274Keys, read_keys

_MILLISECOND: Final = 1e-3


class PathPilot(Rs274):
    """Q of M98 is L."""

    traits: ClassVar[Traits] = Traits(repeats_of_calls="LQ")


class Mach3(Rs274):
    """The text ends a program, as a lone % does; (MSG, ...) alone speaks; Q of M98 is L."""

    traits: ClassVar[Traits] = Traits(repeats_of_calls="LQ", speaking_remarks=("MSG",))
    ends_with_text: ClassVar[bool] = True
    end_alone: ClassVar[bool] = True


class Grbl(Rs274):
    """The text ends a program, as a lone % does; no comment speaks; G0 holds at the start."""

    traits: ClassVar[Traits] = Traits(speaking_remarks=(), starts_with_rapid=True)
    ends_with_text: ClassVar[bool] = True
    end_alone: ClassVar[bool] = True


#: By the key ``flavour``.
FLAVOURS: Final[Mapping[str, type[Rs274]]] = {
    "": Rs274, "linuxcnc": Rs274, "pathpilot": PathPilot, "mach3": Mach3, "grbl": Grbl,
}  # fmt: skip


def _read_keys(setup: Setup) -> Rs274Keys:
    return read_keys(Rs274Keys, setup.control.get("rs274", {}))


def _make_initial_state(setup: Setup) -> State:
    """As LinuxCNC, but for what the keys say."""
    state, keys = initial_state(setup), _read_keys(setup)
    state.modes.absolute_centers = keys.arc_centres == "absolute"
    state.modes.inch = keys.units == "inch"
    state.modes.dwell_unit = _MILLISECOND if keys.dwell == "milliseconds" else 1.0
    state.modes.motion = 0 if FLAVOURS[keys.flavour].traits.starts_with_rapid else None
    return state


def _execute(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    return execute_blocks(source, setup, state, stop, FLAVOURS[_read_keys(setup).flavour])


#: No header shows this dialect: it is the default.
DIALECT: Final[Dialect] = replace(
    build_dialect_of_blocks(Rs274, recognise=lambda _source: False, initial_state=_make_initial_state), execute=_execute
)
