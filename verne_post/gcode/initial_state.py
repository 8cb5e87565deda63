"""The modal state at the start of a program."""

from msgspec.structs import replace

from verne_post.gcode.machining.state import State
from verne_post.gcode.offsets import make_vector9
from verne_post.gcode.parameters import Parameters
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.setup import Setup
from verne_post.model.moves import ZERO9
from verne_post.model.option_checks import ACTIVE_SYSTEM


def make_initial_state(setup: Setup, tool_axis: tuple[float, float, float] | None = None) -> State:
    """The state at the start of a program in RS274/NGC: G80 G17 G90 G91.1 G94 G40 G49 G54 G64, mm."""
    systems = dict(setup.frames)
    if setup.tool_length is not None:
        tool = (0.0, 0.0, setup.tool_length, *ZERO9[3:])
        systems = {number: replace(frame, tool=tool) for number, frame in systems.items()}
    state = State(
        position=[0.0] * 9,
        known_axes=[not setup.machine] * 9,
        systems=systems,
        frame=systems[1],
        tools=dict(setup.tools) if setup.tools is not None else None,
        has_tool_length=setup.tool_length is not None,
        modes=Modes(),
        tool_axis=tool_axis,
        home=setup.home,
        home2=setup.home2,
    )
    _apply_parameters(setup, state)
    return state


def _apply_parameters(setup: Setup, state: State) -> None:
    """Start from a parameter file: what it keeps, and the work system and G92 that were active."""
    parameters = Parameters(setup, state)
    for index, value in setup.parameters.items():
        if index not in (5210, ACTIVE_SYSTEM) and not 5221 <= index < 5400:
            parameters.set(index, value)
    for index, value in setup.parameters.items():
        if 5221 <= index < 5400 and (index - 5221) // 20 + 1 not in setup.given_systems:
            parameters.set(index, value)
    if setup.parameters:
        system = round(setup.parameters.get(ACTIVE_SYSTEM, 1.0))
        state.g92_on = setup.parameters.get(5210, 0.0) != 0.0
        g92 = make_vector9(state.g92_stored) if state.g92_on else ZERO9
        state.frame = replace(state.systems[system], g92=g92)
