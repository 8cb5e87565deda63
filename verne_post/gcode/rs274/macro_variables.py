"""Variables of custom macros: local, common, and known ones of the control; a vacant one is not a number."""

import math
from typing import Final, Protocol

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.codes import CYCLES
from verne_post.gcode.machining.state import ParameterStore, State
from verne_post.gcode.missing_setup import check_measured
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.fanuc_lengths import explain_length_end
from verne_post.gcode.rs274.modes import NO_MAPS, Modes
from verne_post.gcode.setup import Setup
from verne_post.model.moves import FeedMode
from verne_post.model.part_setup import ADDITIONAL_SYSTEMS

LOCAL: Final = range(1, 34)
#: Up to 199 lost when the control is switched off, and kept; how many there are is an option of the control.
_COMMON: Final = (range(100, 1000), range(98000, 98500), range(900000, 907400))
#: Haas has #100 to #999 as #10100 to #10999 too.
_OF_HAAS: Final = 10_000
#: The end of a block in the work system: X, Y, Z. Two sets of names; the third of the second is the spindle nose's.
ENDS: Final = {5001: 0, 5002: 1, 5003: 2, 5041: 0, 5042: 1}
_MACHINE: Final = range(5021, 5024)
#: Those of the tool where it is: beside the contour under cutter compensation.
_ACTUAL: Final = (5041, 5042)
#: Origins of G54 to G59, and of G54.1 P1 on: so many numbers each, of which the first are X, Y, Z.
_ORIGINS, _ADDITIONAL, _STRIDE = range(5221, 5341), range(7001, 7961), 20
#: Length and radius of tools, by their numbers.
_LENGTHS, _RADII = range(11001, 11401), range(13001, 13401)
_FEED_CODES: Final = {FeedMode.PER_MINUTE: 94.0, FeedMode.INVERSE: 93.0, FeedMode.PER_REVOLUTION: 95.0}


class Shown(Protocol):
    """What variables of the control show."""

    setup: Setup
    state: State
    modes: Modes

    def find_position(self, axis: int) -> float:
        """Position in the program, in the unit of the program."""

    def find_machine_position(self, axis: int) -> float:
        """Position of the machine, in the unit of the program."""


def set_variable(store: ParameterStore, key: int, value: float) -> None:
    """Give a local or common variable a value, or none (not a number).

    Raises
    ------
    ProgramError
        VP025: it belongs to the control.
    """
    if key not in LOCAL and not any(key in span for span in _COMMON):
        raise ProgramError(
            "VP025",
            f"#{key} is a variable of the control itself, which is not set here; programs have #1 to #33, #100 to "
            f"#999{_describe_haas_name(key)}",
        )
    if math.isnan(value) and key in LOCAL:
        store.numbered_values.pop(key, None)
    else:
        store.numbered_values[key] = value


def read_variable(parameters: Shown, key: int) -> float:
    """Value of a variable; not a number where it is vacant.

    Raises
    ------
    ProgramError
        VP025: its value is only known at the machine.
    """
    numbered_values = parameters.state.store.numbered_values
    if key in LOCAL or key == 0:
        return numbered_values.get(key, math.nan)
    if any(key in span for span in _COMMON):
        if key not in numbered_values:
            raise ProgramError(
                "VP025",
                f"#{key} may have a value at the machine, from before the program: set it first, or give it with "
                "--parameters FILE",
            )
        return numbered_values[key]
    value = _read_position(parameters, key)
    value = _read_mode(parameters, key) if value is None else value
    value = _read_offset(parameters, key) if value is None else value
    if value is None:
        raise ProgramError(
            "VP025",
            f"#{key} is a variable of the control itself, whose value is only known at the machine; programs "
            f"have #1 to #33, #100 to #999, and some of the control (docs/fanuc.md){_describe_haas_name(key)}",
        )
    return value


def _describe_haas_name(key: int) -> str:
    """What a Haas control has under a number where others have the offset of a tool."""
    return f"; of Haas #{key} is #{key - _OF_HAAS}, so write that" if key - _OF_HAAS in _COMMON[0] else ""


def _read_position(parameters: Shown, key: int) -> float | None:
    """Positions in the unit of the program."""
    modes, state = parameters.modes, parameters.state
    if key in (*_MACHINE, *_ACTUAL) and (state.compensation is not None or state.centre is not None):
        raise ProgramError(
            "VP025",
            f"#{key} under cutter compensation: it is the place of the tool's centre, which the next block decides; "
            f"read #{key % 10 + 5000}, the end of the block on the contour, or write G40 and a move before",
        )
    if key in ENDS:
        if modes.turns or modes.maps is not NO_MAPS:
            raise ProgramError(
                "VP025",
                f"#{key} under G68, G51, G51.1 or G16: controls differ in the system in which they count; read "
                "it before",
            )
        if key == 5003 and state.length_end:
            raise ProgramError("VP025", f"#{key}: {explain_length_end(parameters.setup, state)}")
        return parameters.find_position(ENDS[key])
    return parameters.find_machine_position(key - _MACHINE.start) if key in _MACHINE else None


def _read_mode(parameters: Shown, key: int) -> float | None:
    """Codes that hold, and F, S, T."""
    state, modes = parameters.state, parameters.modes
    motion = modes.motion
    if key == 4001:
        return None if motion in (None, *CYCLES) else motion / 10
    if key == 4014:
        system = state.frame.system
        return 53.0 + system if system <= 6 else None
    shown_values = {
        4002: 17.0 + state.plane,
        4003: 90.0 if modes.absolute else 91.0,
        4005: _FEED_CODES[state.feed_mode],
        4006: 20.0 if modes.inch else 21.0,
        4007: 40.0 if state.compensation is None else state.compensation.code / 10,
        4009: motion / 10 if motion in CYCLES else 80.0,
        4010: 98.0 if modes.initial_level else 99.0,
        4109: state.feed_angular if state.feed_mode == FeedMode.INVERSE or not modes.inch else state.feed / MM_PER_INCH,
        4119: state.spindle_speed,
        4120: float(state.selected_tool or 0),
    }
    return shown_values.get(key)


def _read_offset(parameters: Shown, key: int) -> float | None:
    """Origins of work systems and offsets of tools, in the unit of the program."""
    state, unit = parameters.state, MM_PER_INCH if parameters.modes.inch else 1.0
    for numbers, first in ((_ORIGINS, 1), (_ADDITIONAL, ADDITIONAL_SYSTEMS + 1)):
        if key in numbers and (key - numbers.start) % _STRIDE < 3:
            frame = state.systems.get(first + (key - numbers.start) // _STRIDE)
            return None if frame is None else frame.origin[(key - numbers.start) % _STRIDE] / unit
    for numbers in (_LENGTHS, _RADII):
        if key in numbers:
            tool = (state.tools or {}).get(key - numbers.start + 1)
            if tool is None:
                raise ProgramError("VP012", f"#{key}: the tool table has no tool {key - numbers.start + 1}")
            if numbers is _RADII:
                return 0.5 * tool.diameter / unit
            check_measured(tool, parameters.setup, state)
            return tool.offset[2] / unit
    return None
