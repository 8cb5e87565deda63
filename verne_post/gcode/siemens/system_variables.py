"""Variables of the control that programs read and set: work offsets, tool data, positions, modes."""

import dataclasses
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.gcode.missing_setup import check_measured
from verne_post.gcode.offsets import make_vector9
from verne_post.gcode.siemens.cursor import Cursor
from verne_post.gcode.siemens.frame_values import FrameValues, holds_frame
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.siemens.values import Index, Names, Value
from verne_post.model.moves import AXES, ZERO9, Frame

#: 0 here: the program is executed, not searched, tested or simulated.
_ZERO: Final = ("$P_SIM", "$P_ISTEST", "$P_SEARCH", "$P_SEARCHL", "$P_DRYRUN", "$P_PROGTEST", "$AC_SIM")
#: Data of a tool's edge that are kept: type, length, radius.
_TOOL_DATA: Final = {"$TC_DP1": "type", "$TC_DP3": "length", "$TC_DP6": "radius"}
#: Lengths and a feed rate, which G700 makes inches; positions in the frame are inches under G70 too.
_LENGTHS: Final = ("$AA_IM", "$P_UIFR", "$TC_DP3", "$TC_DP6", "$P_TOOLR", "$P_TOOLL", "$P_F")
#: Wear and base: there is none.
_NO_WEAR: Final = tuple(f"$TC_DP{number}" for number in (2, 4, 5, *range(7, 26)))


class SystemVariables:
    """Reads and sets them on an interpreter."""

    def __init__(self, interpreter: SiemensInterpreter) -> None:
        self.to = interpreter

    def read_system(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> Value:
        """Value of a variable."""
        to, state = self.to, self.to.state
        self._refuse_inches(name, index, cursor, at)
        if name in _ZERO:
            return 0.0
        if name in ("$P_EP", "$AA_IW", "$AA_IM"):
            return self._read_position(name, index, cursor, at)
        if name == "$P_UIFR":
            frame, axis, part = self._read_offset(name, index, cursor, at)
            if part == "RT" and frame.part_turn:
                raise cursor.error("VP025", f"{name}[..., RT]: a program cannot read the turn of the part (--wcs)", at)
            turn = frame.turn if axis == 2 else 0.0
            return {"TR": frame.origin[axis], "SC": 1.0, "RT": turn}.get(part, 0.0)
        if name in _TOOL_DATA or name in _NO_WEAR:
            tool = (state.tools or {}).get(self._read_tool(name, index, cursor, at))
            what = _TOOL_DATA.get(name)
            if tool is None or what in (None, "type"):
                return 0.0
            if what == "length":
                check_measured(tool, to.setup, state)
            return tool.offset[2] if what == "length" else 0.5 * tool.diameter
        tool = to.core.tools.find_called(state.loaded_tool or 0)
        values: dict[str, float | None] = {
            "$P_TOOLNO": float(state.loaded_tool or 0),
            "$P_TOOLP": float(state.selected_tool or 0),
            "$P_TOOL": float(to.modes.edge),
            "$P_TOOLR": None if tool is None else 0.5 * tool.diameter * to.modes.edge,
            "$P_TOOLL": state.frame.tool_length if index in ((1,), (3,)) else 0.0,
            "$P_F": state.feed,
            "$P_S": state.spindle_speed,
            "$P_UIFRNUM": float(self._find_active()),
            "$P_TRAFO": float(to.modes.tcp),
            "$P_SDIR": 5.0 if not state.spindle_on else 4.0 if state.spindle_reversed else 3.0,
        }
        value = values.get(name)
        if value is None:
            raise cursor.error("VP025", f"{name}: this variable of the control is not known here", at)
        return value

    def write_system(self, name: str, index: tuple[Index, ...], value: Value, cursor: Cursor, at: int) -> None:
        """Set a variable."""
        if isinstance(value, str):
            raise cursor.error("VP007", f"{name} is a number; a text cannot be assigned to it", at)
        self._refuse_inches(name, index, cursor, at)
        if name == "$P_UIFR":
            frame, axis, part = self._read_offset(name, index, cursor, at)
            if part != "TR":
                if part == "RT" and axis == 2:
                    self.to.frame_words.store_offset(replace(frame, turn=value))
                elif value != (1.0 if part == "SC" else 0.0):
                    text = (
                        f"{name}[..., {AXES[axis]}, {part}]: work offsets here are shifted (TR), and turned about Z "
                        "(RT)"
                    )
                    raise cursor.error("VP002", text, at)
                return
            origin = list(frame.origin)
            origin[axis] = value
            self.to.frame_words.store_offset(replace(frame, origin=make_vector9(origin)))
            return
        if name in _TOOL_DATA or name in _NO_WEAR:
            self._write_tool(name, index, value, cursor, at)
            return
        raise cursor.error("VP025", f"{name}: this variable of the control cannot be set here", at)

    def _refuse_inches(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> None:
        """Refuse (VP017) a length of the control under G700: there it is inches, and here mm; angles are the same."""
        is_angle = not {*index}.isdisjoint({"A", "B", "C", "RT", "SC", "MI"})
        if self.to.modes.units == "G700" and name in _LENGTHS and not is_angle:
            text = (
                f"{name} under G700: a control reads and sets it in inches, which is not executed; write G70 or G710 "
                "before it, under which it counts in mm"
            )
            raise cursor.error("VP017", text, at)

    def assign_frame(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int, names: Names) -> bool:
        """Read the value of a frame and set a variable to it; False for variables that are no frames."""
        if not holds_frame(name, index):
            return False
        FrameValues(self.to, names).assign(name, index, cursor, at)
        return True

    def _find_active(self) -> int:
        system = self.to.modes.system
        return next((number for number in range(100) if self.to.frame_words.find_system(number) == system), 0)

    def _read_position(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> float:
        letter = index[0] if len(index) == 1 else ""
        if not isinstance(letter, str) or len(letter) != 1 or letter not in self.to.setup.axes:
            raise cursor.error("VP025", f"{name} needs one axis of {', '.join(self.to.setup.axes)}", at)
        axis = AXES.index(letter)
        if not self.to.state.is_known(axis):
            raise cursor.error("VP013", f"{name}[{letter}]: no word has named {letter} yet", at)
        if name == "$AA_IM":
            machine = self.to.setup.coordinates.map_to_machine(np.array(self.to.state.position), self.to.state.frame)
            return float(machine[axis])
        value = self.to.motion.find_programmed(axis)
        return value if axis > 2 else value / self.to.modes.length

    def _read_offset(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> tuple[Frame, int, str]:
        number, letter, part = (*index, None, None, None)[:3]
        is_known = (
            isinstance(number, int) and number >= 0 and self.to.frame_words.find_system(number) in self.to.state.systems
        )
        if (
            len(index) != 3
            or not is_known
            or not isinstance(letter, str)
            or letter not in AXES
            or part not in ("TR", "RT", "SC", "MI", "FI")
        ):
            raise cursor.error("VP025", f"{name} is read and set as {name}[number, axis, TR]", at)
        assert isinstance(number, int)
        assert isinstance(part, str)
        return self.to.state.systems[self.to.frame_words.find_system(number)], AXES.index(letter), part

    def _read_tool(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> int:
        flat = self.to.keys.d_numbers == "tools" and len(index) == 1  # numbers of D without those of tools
        number, edge = (*index, 1, 1)[:2]
        if not (flat or len(index) == 2) or not isinstance(number, int) or number < 1 or edge != 1:
            raise cursor.error("VP012", f"{name} needs a tool number and the edge 1: {name}[1, 1]", at)
        return number

    def _write_tool(self, name: str, index: tuple[Index, ...], value: float, cursor: Cursor, at: int) -> None:
        number = self._read_tool(name, index, cursor, at)
        what = _TOOL_DATA.get(name)
        if what is None:
            if value:
                raise cursor.error(
                    "VP002", f"{name}: only the length ($TC_DP3) and the radius ($TC_DP6) of a tool are kept", at
                )
            return
        if what == "type":
            return
        if value < 0:
            raise cursor.error("VP007", f"{name} {value:g}: a {what} is not negative", at)
        tools = self.to.core.tools
        tool = tools.find_tool(number, f"{name} without $TC_DP3")
        if what == "length":
            tool = dataclasses.replace(tool, offset=(*ZERO9[:2], value, *ZERO9[3:]), unmeasured="", row="")
        else:
            tool = dataclasses.replace(tool, diameter=2.0 * value)
        tools.define_for_next_call(tool, name)
