"""Auxiliary functions, F, S and T: spindle, tool, coolant, signals, override switches; saved modal state."""

from typing import Final

from msgspec.structs import replace

from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.codes import g_name
from verne_post.gcode.frame_codes import FrameCodes, whole
from verne_post.gcode.missing_setup import missing_tool
from verne_post.gcode.state import Saved, tool_facts, unit_of_speed
from verne_post.model.moves import FeedMode

#: Codes of the group "spindle" that are the spindle's; the others save and restore modes.
_SPINDLE: Final = (3, 4, 5, 19)
_COOLANT: Final = {7: "mist", 8: "flood", 9: "off"}
#: M50 to M53 -> switch; M48 and M49 turn the first two.
_SWITCHES: Final = {50: "feed", 51: "speed", 52: "adaptive", 53: "hold"}
#: L words of M66: L0 at once, rise, fall, high, low.
_MAX_WAIT: Final = 4
#: What M70 and M73 save of the state. The motion mode is not among it.
_SAVED: Final = (
    "plane", "absolute", "absolute_centers", "feed_mode", "inch", "control", "feed", "feed_angular", "spindle_speed",
    "surface_speed", "spindle_on", "spindle_reversed", "mist", "flood", "diameter_mode", "initial_level",
)  # fmt: skip


class MachineCodes(FrameCodes):
    """Frame codes, and auxiliary functions."""

    # --- feed, speed, tool ---------------------------------------------------------------------

    def _set_feed(self, block: Block, g: dict[str, int]) -> None:
        state = self.state
        mode = g.get("feed mode")
        if mode is not None:
            wanted = {930: FeedMode.INVERSE, 940: FeedMode.PER_MINUTE, 950: FeedMode.PER_REVOLUTION}[mode]
            if wanted != state.feed_mode:
                self._refuse_compensation("a change of feed mode")
                state.feed = state.feed_angular = 0.0
            state.feed_mode = wanted
        if "F" in block.words:
            value = block.words["F"]
            if value < 0:
                raise block.error("VP007", f"F{value:g}: a feed rate is not negative", "F")
            state.feed_angular = value
            state.feed = value if state.feed_mode == FeedMode.INVERSE else self._length(value)

    def _set_spindle_mode(self, block: Block, code: int) -> None:
        """G96: S is the speed of the surface, D the most turns a minute; G97: S is turns a minute."""
        state, data = self.state, dict[str, object]()
        if code == 960 and "S" not in block.words:
            raise BlockError("VP005", "G96 needs S, the speed of the surface")
        changed, state.surface_speed = state.surface_speed != (code == 960), code == 960
        if code == 960:
            data = {"speed": block.words["S"]} | unit_of_speed(state)
            data |= {"most_per_minute": abs(block.words["D"])} if "D" in block.words else {}
            text = "G96: the spindle is to follow the distance of the tool from X0; setpoints have no spindle speed, the event has S and D"
            self.recorder.warn("VP045", text, block.line, None)
        self.recorder.event(block.line, "spindle mode", code=g_name(code), **data)
        state.spindle_speed = block.words.get("S", state.spindle_speed)
        if changed and state.spindle_on:  # also where the number is the same, it means something else
            self._switch_spindle(block.line, on=True, backwards=state.spindle_reversed)

    def _execute_auxiliary(self, block: Block, m: dict[str, list[int]]) -> None:
        state = self.state
        if "S" in block.words:
            if block.words["S"] < 0:
                raise block.error("VP007", f"S{block.words['S']:g}: a spindle speed is not negative", "S")
            changed = state.spindle_speed != block.words["S"]
            state.spindle_speed = block.words["S"]
            if changed and state.spindle_on and not any(code in _SPINDLE for code in m.get("spindle", [])):
                self._switch_spindle(block.line, on=True, backwards=state.spindle_reversed)
        if "T" in block.words:
            tool = whole(block, "T")
            if state.tools is not None and tool != 0 and tool not in state.tools:
                raise missing_tool(tool, "T", block, self.setup, state)
            state.selected_tool = tool
        for code in m.get("signals", []):
            self._set_output(block, code)
        for code in m.get("tool change", []):
            self._change_tool(block, code)
        for code in m.get("spindle", []):
            if code not in _SPINDLE:
                self._save_or_restore(code, block.line)
            elif code == 19:
                self.recorder.event(block.line, "orient", angle=block.words.get("R", 0.0))
                state.spindle_on = False
            else:
                self._switch_spindle(block.line, on=code != 5, backwards=code == 4)
        for code in m.get("coolant", []):
            state.mist = code == 7 or (state.mist and code != 9)
            state.flood = code == 8 or (state.flood and code != 9)
            self.recorder.event(block.line, "coolant", state=_COOLANT[code])
        for code in m.get("override", []):
            self._set_overrides(block, code)

    def _change_tool(self, block: Block, code: int) -> None:
        state = self.state
        tool = state.selected_tool or 0
        if code == 61:
            if "Q" not in block.words:
                raise BlockError("VP005", "M61 needs Q, the number of the tool")
            tool = whole(block, "Q")
            if state.tools is not None and tool != 0 and tool not in state.tools:
                raise missing_tool(tool, "Q", block, self.setup, state)
        if tool:
            self._check_one_tool(tool)
        state.loaded_tool = tool
        if (
            state.compensation is None and state.centre is not None
        ):  # the tool stays beside the contour that G40 has left
            state.position, state.centre = state.centre, None
        if code == 61:  # no tool is changed: only the number is set
            self.recorder.event(block.line, "tool number", **tool_facts(state, tool))
            return
        self._refuse_compensation("M6")
        state.spindle_on = False
        self.recorder.event(block.line, "tool", **tool_facts(state, tool))

    def _switch_spindle(self, line: int, *, on: bool, backwards: bool = False) -> None:
        state = self.state
        state.spindle_on = on
        if on:
            state.spindle_reversed = backwards
        direction = "stop" if not on else "counterclockwise" if backwards else "clockwise"
        self.recorder.event(line, "spindle", direction=direction, speed=state.spindle_speed, **unit_of_speed(state))

    # --- switches and signals --------------------------------------------------------------------

    def _set_overrides(self, block: Block, code: int) -> None:
        overrides = self.state.overrides
        if code in (48, 49):
            overrides["feed"] = overrides["speed"] = code == 48
        else:
            overrides[_SWITCHES[code]] = block.words.get("P", 1.0) != 0.0
        self.recorder.event(block.line, "override", **overrides)

    def _set_output(self, block: Block, code: int) -> None:
        """M62 to M68: outputs, and M66, which waits for an input."""
        if code == 66:
            self._wait_for_input(block)
            return
        digital = code <= 65
        letter = "P" if digital else "E"
        if letter not in block.words:
            raise BlockError("VP005", f"M{code} needs {letter}, the number of the output")
        data: dict[str, object] = {"output": whole(block, letter), "synchronised": code in (62, 63, 67)}
        if digital:
            data["on"] = code in (62, 64)
        elif "Q" not in block.words:
            raise BlockError("VP005", f"M{code} needs Q, the value")
        else:
            data["value"] = block.words["Q"]
        self.recorder.event(block.line, "signal", **data)

    def _wait_for_input(self, block: Block) -> None:
        words = block.words
        if ("P" in words) == ("E" in words):
            raise BlockError("VP005", "M66 needs P, a digital input, or E, an analog one")
        how = whole(block, "L") if "L" in words else 0
        if how > _MAX_WAIT:
            raise block.error("VP007", f"M66 L{how}: modes of waiting are L0 to L{_MAX_WAIT}", "L")
        if how and "E" in words:
            raise block.error("VP007", "M66 E waits for nothing: only L0 goes with an analog input", "L")
        if how and words.get("Q", 0.0) <= 0:
            raise BlockError("VP005", f"M66 L{how} needs Q, the longest time to wait, greater than 0")
        self.state.inputs_read = True
        letter = "P" if "P" in words else "E"
        self.recorder.event(block.line, "input", input=whole(block, letter), analog=letter == "E", wait=how)

    # --- saved state ---------------------------------------------------------------------------------

    def _save_or_restore(self, code: int, line: int) -> None:
        saved = self.state.saved
        if code == 71:
            saved[-1] = None
        elif code == 72:
            last = saved[-1]
            if last is None:
                raise BlockError("VP017", "M72 without M70 or M73 before it at the same level of calls")
            self._restore(last, line)
        else:
            state = self.state
            values = {name: getattr(state, name) for name in _SAVED}
            saved[-1] = Saved(
                values, dict(state.overrides), state.frame.system, state.g92_on, state.frame.tool, code == 73
            )

    def _restore(self, saved: Saved, line: int) -> None:
        state = self.state
        spindle = (state.spindle_on, state.spindle_reversed, state.spindle_speed)
        coolant = (state.mist, state.flood)
        overrides = state.overrides
        self._refuse_compensation("M72, or a return after M73,")
        for name, value in saved.values.items():
            setattr(state, name, value)
        state.overrides = dict(saved.overrides)
        if (state.spindle_on, state.spindle_reversed, state.spindle_speed) != spindle:
            self._switch_spindle(line, on=state.spindle_on, backwards=state.spindle_reversed)
        if (state.mist, state.flood) != coolant:
            self.recorder.event(line, "coolant", state="off")
            for on, name in ((state.mist, "mist"), (state.flood, "flood")):
                if on:
                    self.recorder.event(line, "coolant", state=name)
        if state.overrides != overrides:
            self.recorder.event(line, "override", **state.overrides)
        frame = state.frame
        if saved.system != frame.system:
            self._set_frame(replace(state.systems[saved.system], g92=frame.g92, tool=frame.tool))
        if saved.g92_on != state.g92_on:
            self._apply_shift(on=saved.g92_on)
        if saved.tool != state.frame.tool:
            self._set_frame(replace(state.frame, tool=saved.tool))

    def leave_call(self, line: int) -> None:
        """Back from a call: bring back what M73 has saved in it."""
        saved = self.state.saved.pop()
        if saved is not None and saved.automatic:
            self._restore(saved, line)
