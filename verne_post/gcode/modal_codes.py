"""Codes that set modes: plane, units, work offset, path control, distance modes; and the non-modal codes that do not move."""

from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.codes import CYCLES, g_name
from verne_post.gcode.cycle_codes import CycleCodes
from verne_post.model.moves import AXES, ZERO9, PathControl, PathMode

_SYSTEMS: Final = {540: 1, 550: 2, 560: 3, 570: 4, 580: 5, 590: 6, 591: 7, 592: 8, 593: 9}


class ModalCodes(CycleCodes):
    """Cycle codes, and those that set modes."""

    def _set_modes(self, block: Block, g: dict[str, int]) -> None:
        state = self.state
        if "plane" in g:
            plane = (g["plane"] - 170) // 10
            if plane != state.plane:
                self._refuse_compensation("a change of plane")
            state.plane = plane
        if "units" in g:
            state.inch = g["units"] == 200
        if "lathe diameter" in g:
            state.diameter_mode = g["lathe diameter"] == 70
        if state.diameter_mode and "X" in block.words:
            raise block.error("VP002", "X under G7 is a diameter, which only a lathe has; write G8 first", "X")
        if "cutter compensation" in g:
            self._compensate(block, g["cutter compensation"])
        if "tool length" in g:
            self._refuse_compensation(g_name(g["tool length"]))
            state.vectors = g["tool length"] == 435
            self._set_tool_length(block, g["tool length"])
        if "work offset" in g:
            self._select_system(block, g["work offset"])
        if "path control" in g:
            self._set_path_control(block, g["path control"])
        if "distance" in g:
            state.absolute = g["distance"] == 900
        if "arc distance" in g:
            state.absolute_centers = g["arc distance"] == 901
        if "retract" in g:
            state.initial_level = g["retract"] == 980
        if "motion" in g or "cancel" in g:
            state.motion = g.get("motion")
        if state.motion not in CYCLES:
            state.cycle = None

    def _select_system(self, block: Block, code: int) -> None:
        state = self.state
        system = self._system_number(block, code)
        if system != state.frame.system:
            self._set_frame(replace(state.systems[system], g92=state.frame.g92, tool=state.frame.tool))

    def _system_number(self, block: Block, code: int) -> int:
        """Number of the work system of a code."""
        return _SYSTEMS[code]

    def _set_path_control(self, block: Block, code: int) -> None:
        if code != 640:
            mode = PathMode.EXACT_PATH if code == 610 else PathMode.EXACT_STOP
            self.state.control = PathControl(mode)
            return
        values = []
        for letter in "PQ":
            value = block.words.get(letter)
            if value is not None and value < 0:
                raise block.error("VP007", f"{letter}{value:g}: a tolerance is not negative", letter)
            values.append(None if value is None else self._length(value))
        self.state.control = PathControl(PathMode.BLEND, values[0], values[1] if values[1] is not None else values[0])

    # --- dwell, offsets, home ------------------------------------------------------------

    def _dwell(self, block: Block) -> None:
        if "P" not in block.words:
            raise BlockError("VP005", "G4 needs P, the time")
        self._record_dwell(block, self._dwell_seconds(block))

    def _execute_non_modal(self, block: Block, code: int) -> None:
        if code == 100:
            self._execute_g10(block)
        elif code in (280, 300):
            self._go_home(block, code)
        elif code in (281, 301):
            self._store_home(block, code)
        elif code in (520, 920):
            self._execute_g92(block, code)
        elif code in (921, 922):
            if code == 921:
                self.state.g92_stored = self.state.local_shift = ZERO9
            self._apply_shift(on=False)
        else:
            self._apply_shift(on=True)

    def _store_home(self, block: Block, code: int) -> None:
        """G28.1, G30.1: the home position is where the machine stands."""
        state = self.state
        self._require_known(block, [AXES.index(letter) for letter in self.setup.axes], g_name(code))
        point = tuple(float(v) for v in self.setup.coordinates.to_machine(np.array(state.position), state.frame))
        if code == 281:
            state.home = point
        else:
            state.home2 = point
