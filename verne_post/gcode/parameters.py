"""Parameters: numbered and named ones, and those that show the state of the interpreter.

Numbers and names as LinuxCNC has them (docs/gcode.md). Lengths in 5161 to 5413 are in the unit of the
parameter file, those of 5420 to 5428 and of the named positions in the unit of the program.
"""

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.suggestions import find_meant
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.expressions import Key, show_key
from verne_post.gcode.machining.frames import set_home, set_stored_shift, set_stored_system
from verne_post.gcode.machining.state import State
from verne_post.gcode.missing_setup import check_measured
from verne_post.gcode.offsets import make_vector9
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.macro_variables import read_variable, set_variable
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.setup import Setup
from verne_post.model.moves import AXES, ZERO9, FeedMode, Frame
from verne_post.model.option_checks import ACTIVE_SYSTEM, MAX_PARAMETER

#: Arguments of a call: saved and restored by it.
LOCAL_INDICES: Final = range(1, 31)
_HOME, _HOME2, _G92, _ORIGINS = 5161, 5181, 5211, 5221
#: #5400 is the tool, #5403 its length; the position of X is #5420.
_TOOL, _TOOL_LENGTH, POSITION = 5400, 5403, 5420
_LINEAR: Final = (0, 1, 2, 6, 7, 8)
#: Letters of lengths, of angles, and of whole numbers, for ROUND of custom macros.
_LENGTHS, _ANGLES, _WHOLE = frozenset("XYZUVWIJKRQ"), frozenset("ABC"), frozenset("GMNOPHDSTL")


class Parameters:
    """The parameters of one interpretation; implements :class:`~verne_post.gcode.expressions.Values`.

    ``line`` is the block that is being read. ``custom_macro``: expressions are Fanuc's. ``passed_word`` is the letter
    of a word that has been skipped, with a vacant variable.
    """

    def __init__(self, setup: Setup, state: State, *, custom_macro: bool = False) -> None:
        self.setup, self.state, self.custom_macro = setup, state, custom_macro
        self.modes: Modes = state.modes
        self.line = 0
        self.passed_word = ""

    # --- reading ------------------------------------------------------------------------------

    def read_value(self, key: Key) -> float:
        """Value of a parameter; a number that was never set is 0.

        Raises
        ------
        ProgramError
            VP025: no such parameter.
        """
        if isinstance(key, str):
            return self._read_named(key)
        if self.custom_macro:
            return read_variable(self, key)
        if not 1 <= key <= MAX_PARAMETER:
            raise ProgramError("VP025", f"#{key}: parameters have the numbers 1 to {MAX_PARAMETER}")
        if 5161 <= key <= 5428:
            return self._read_numbered_state(key)
        if 5021 <= key <= 5029 or 5081 <= key <= 5089:
            raise ProgramError("VP025", f"#{key}: positions of the machine have no parameter here; use #5420 to #5428")
        return self.state.store.numbered_values.get(key, 0.0)

    def find_steps_of_word(self, letter: str) -> int | None:
        """To how many steps of a unit Fanuc's ROUND rounds in the word of a letter; None where controls differ.

        Lengths and angles have the least input increment of most controls (IS-B).
        """
        if letter in _LENGTHS:
            return 10_000 if self.modes.inch else 1000
        return 1000 if letter in _ANGLES else 1 if letter in _WHOLE else None

    def pass_word(self, letter: str) -> None:
        """The word of a letter has a vacant variable."""
        self.passed_word = letter

    def exists(self, key: Key) -> bool:
        """True for a named parameter that has a value, and for a number that parameters have."""
        if not isinstance(key, str):
            return 1 <= key <= MAX_PARAMETER
        store, name = self.state.store, key
        return name in (store.named_values if name.startswith("_") else store.local[-1]) or name in PREDEFINED_NAMES

    def _read_named(self, name: str) -> float:
        store = self.state.store
        place = store.named_values if name.startswith("_") else store.local[-1]
        if name in place:
            return place[name]
        read_state = PREDEFINED_NAMES.get(name)
        if read_state is not None:
            return float(read_state(self))
        if name.startswith(("_ini[", "_hal[")):
            raise ProgramError("VP025", f"#<{name}>: values of a running machine are not known when a program is read")
        near = find_meant(name, place)
        if near:
            raise ProgramError("VP025", f"#<{name}>: it has no value; did you mean #<{near}>?")
        raise ProgramError("VP025", f"#<{name}> has no value; set it first with #<{name}>=...")

    def _read_numbered_state(self, key: int) -> float:
        if POSITION <= key <= 5428:
            return self.find_position(key - POSITION)
        state, store = self.state, self.state.store
        for first, point in ((_HOME, state.home), (_HOME2, state.home2)):
            if first <= key < first + 9:
                if point is None:
                    raise ProgramError("VP015", f"#{key}: the machine file has no such home position")
                return self._read_in_file(key - first, point[key - first])
        if _G92 <= key < _G92 + 9:
            return self._read_in_file(key - _G92, state.g92_stored[key - _G92])
        if key == 5210:
            return float(state.g92_on)
        if key == ACTIVE_SYSTEM:
            return float(state.frame.system)
        if _ORIGINS <= key < 5400:
            system, entry = divmod(key - _ORIGINS, 20)
            if system < 9 and entry < 10:
                frame = state.systems[system + 1]
                return frame.turn if entry == 9 else self._read_in_file(entry, frame.origin[entry])
            if key == 5399 and key not in store.numbered_values and self.modes.inputs_read:
                raise ProgramError("VP025", "#5399: what M66 reads is only known at the machine")
        if _TOOL <= key <= 5413:
            tool = (state.tools or {}).get(state.loaded_tool or 0)
            if key == _TOOL:
                return float(state.loaded_tool or 0)
            if key <= 5409:
                if tool is not None and key == _TOOL_LENGTH:
                    check_measured(tool, self.setup, self.state)
                return self._read_in_file(key - 5401, tool.offset[key - 5401]) if tool else 0.0
            return self._read_in_file(0, tool.diameter) if tool and key == 5410 else 0.0
        return store.numbered_values.get(key, 0.0)

    def find_position(self, axis: int) -> float:
        """Position in the program, in the unit of the program."""
        if not self.state.is_known(axis):
            raise ProgramError(
                "VP013", f"the position of {AXES[axis]} is not known yet; name {AXES[axis]} with G90 first"
            )
        return self._read_in_program(axis, self.state.position[axis])

    def find_machine_position(self, axis: int) -> float:
        """Position of the machine, in the unit of the program."""
        self.find_position(axis)
        state = self.state
        return self._read_in_program(
            axis, float(self.setup.coordinates.map_to_machine(np.array(state.position), state.frame)[axis])
        )

    def _read_in_program(self, axis: int, value: float) -> float:
        return value / MM_PER_INCH if self.modes.inch and axis in _LINEAR else value

    def _read_in_file(self, axis: int, value: float) -> float:
        return value / self.setup.parameter_mm if axis in _LINEAR else value

    # --- setting ------------------------------------------------------------------------------

    def set(self, key: Key, value: float) -> None:
        """Set a parameter.

        Raises
        ------
        ProgramError
            VP025: it cannot be set.
        """
        state, store = self.state, self.state.store
        if isinstance(key, str):
            if key in PREDEFINED_NAMES and key not in SETTABLE:
                raise ProgramError("VP025", f"{show_key(key)} shows a state and cannot be set")
            (store.named_values if key.startswith("_") else store.local[-1])[key] = value
            return
        if self.custom_macro:
            set_variable(store, key, value)
            return
        if not 1 <= key <= MAX_PARAMETER:
            raise ProgramError("VP025", f"#{key}: parameters have the numbers 1 to {MAX_PARAMETER}")
        if key in (5210, ACTIVE_SYSTEM) or _TOOL <= key <= 5428 or 5021 <= key <= 5029 or 5081 <= key <= 5089:
            raise ProgramError("VP025", f"#{key} shows a state and cannot be set")
        if _HOME <= key < _HOME + 9:
            set_home(state, self._set_entry(state.home, key - _HOME, value), second=False)
        elif _HOME2 <= key < _HOME2 + 9:
            set_home(state, self._set_entry(state.home2, key - _HOME2, value), second=True)
        elif _G92 <= key < _G92 + 9:
            set_stored_shift(state, self._set_entry(state.g92_stored, key - _G92, value))
        elif _ORIGINS <= key < 5400 and (key - _ORIGINS) // 20 < 9 and (key - _ORIGINS) % 20 < 10:
            system, entry = divmod(key - _ORIGINS, 20)
            frame = state.systems[system + 1]
            origin = make_vector9(self._set_entry(frame.origin, entry, value)) if entry < 9 else frame.origin
            set_stored_system(state, replace(frame, origin=origin, turn=value if entry == 9 else frame.turn))
        else:
            store.numbered_values[key] = value

    def _set_entry(self, point: tuple[float, ...] | None, axis: int, value: float) -> tuple[float, ...]:
        values = [np.nan] * 9 if point is None else list(point)
        values[axis] = value * self.setup.parameter_mm if axis in _LINEAR else value
        return tuple(values)

    def list_persistent(self) -> dict[int, float]:
        """What a parameter file keeps: home positions, G92, the active system, all work systems, and earlier values."""
        state = self.state
        found = {index: self.read_value(index) for index in self.setup.parameters}
        kept_values = {index: value for index, value in found.items() if not math.isnan(value)}  # nor a vacant variable
        for first, point in ((_HOME, state.home), (_HOME2, state.home2), (_G92, state.g92_stored)):
            for axis, value in enumerate(point or ()):
                if np.isfinite(value):
                    kept_values[first + axis] = self._read_in_file(axis, value)
        kept_values[5210] = float(state.g92_on)
        kept_values[ACTIVE_SYSTEM] = 1.0  # the end of a program selects G54
        for system in range(9):
            frame, first = state.systems[system + 1], _ORIGINS + 20 * system
            kept_values |= {first + axis: self._read_in_file(axis, value) for axis, value in enumerate(frame.origin)}
            kept_values[first + 9] = frame.turn
        return dict(sorted(kept_values.items()))


def _read_system_code(frame: Frame) -> float:
    return 540.0 + 10 * (frame.system - 1) if frame.system < 7 else 590.0 + frame.system - 6


_Reader = Callable[[Parameters], float]


def _name_positions() -> dict[str, _Reader]:
    readers: dict[str, _Reader] = {}
    for axis, letter in enumerate(AXES.lower()):
        readers[f"_{letter}"] = lambda p, axis=axis: p.find_position(axis)  # type: ignore[misc]
        readers[f"_abs_{letter}"] = lambda p, axis=axis: p.find_machine_position(axis)  # type: ignore[misc]
    return readers


def _read_motion_mode(p: Parameters) -> float:
    return 800.0 if p.modes.motion is None else float(p.modes.motion)


#: Names that show the state. Codes are ten times the G number.
PREDEFINED_NAMES: Final[dict[str, _Reader]] = {
    **_name_positions(),
    "_line": lambda p: p.line,
    "_motion_mode": _read_motion_mode,
    "_plane": lambda p: 170 + 10 * p.state.plane,
    "_ccomp": lambda p: 400 if p.state.compensation is None else p.state.compensation.code,
    "_metric": lambda p: not p.modes.inch,
    "_imperial": lambda p: p.modes.inch,
    "_absolute": lambda p: p.modes.absolute,
    "_incremental": lambda p: not p.modes.absolute,
    "_ijk_absolute_mode": lambda p: p.modes.absolute_centers,
    "_inverse_time": lambda p: p.state.feed_mode == FeedMode.INVERSE,
    "_units_per_minute": lambda p: p.state.feed_mode == FeedMode.PER_MINUTE,
    "_units_per_rev": lambda p: p.state.feed_mode == FeedMode.PER_REVOLUTION,
    "_coord_system": lambda p: _read_system_code(p.state.frame),
    "_tool_offset": lambda p: p.state.frame.tool != ZERO9,
    "_retract_r_plane": lambda p: not p.modes.initial_level,
    "_retract_old_z": lambda p: p.modes.initial_level,
    "_spindle_rpm_mode": lambda p: not p.state.surface_speed,
    "_spindle_css_mode": lambda p: p.state.surface_speed,
    "_lathe_diameter_mode": lambda p: p.modes.diameter_mode,
    "_lathe_radius_mode": lambda p: not p.modes.diameter_mode,
    "_spindle_on": lambda p: p.state.spindle_on,
    "_spindle_cw": lambda p: p.state.spindle_on and not p.state.spindle_reversed,
    "_mist": lambda p: p.state.mist,
    "_flood": lambda p: p.state.flood,
    "_speed_override": lambda p: p.state.overrides["speed"],
    "_feed_override": lambda p: p.state.overrides["feed"],
    "_adaptive_feed": lambda p: p.state.overrides["adaptive"],
    "_feed_hold": lambda p: p.state.overrides["hold"],
    "_feed": lambda p: p.state.feed_angular,
    "_rpm": lambda p: p.state.spindle_speed,
    "_current_tool": lambda p: p.state.loaded_tool or 0,
    "_current_pocket": lambda p: _read_pocket(p, p.state.loaded_tool, 0),
    "_selected_tool": lambda p: p.state.selected_tool or 0,
    "_selected_pocket": lambda p: _read_pocket(p, p.state.selected_tool, -1),
    "_value": lambda _p: 0,
    "_value_returned": lambda _p: 0,
    "_call_level": lambda p: len(p.state.store.local) - 1,
    "_remap_level": lambda _p: 0,
    "_task": lambda _p: 0,
}
#: Names of that table that returning from a call sets.
SETTABLE: Final = ("_value", "_value_returned")


def _read_pocket(p: Parameters, tool: int | None, none: int) -> float:
    if not tool:
        return none
    return (p.state.tools or {})[tool].pocket if tool in (p.state.tools or {}) else tool
