"""Auxiliary functions, F, S and T: spindle, tool, coolant, signals, override switches; saved modal state."""

from typing import Final

from msgspec.structs import replace

from verne_post.gcode.block import Block
from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.machining.machining import Machining, name_feed_mode
from verne_post.gcode.machining.settings import restore_settings, save_settings
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.rs274.modes import Modes, Saved
from verne_post.gcode.rs274.offsets import say_directions
from verne_post.gcode.rs274.values import WordValues, read_whole
from verne_post.model.moves import FeedMode

#: Codes of the group "spindle" that are the spindle's; the others save and restore modes.
_SPINDLE: Final = (3, 4, 5, 19)
_FEED_MODES: Final = {930: FeedMode.INVERSE, 940: FeedMode.PER_MINUTE, 950: FeedMode.PER_REVOLUTION}
#: M50 to M53 -> switch; M48 and M49 turn the first two.
_SWITCHES: Final = {50: "feed", 51: "speed", 52: "adaptive", 53: "hold"}
#: L words of M66: L0 at once, rise, fall, high, low.
_MAX_WAIT: Final = 4
#: What M70 and M73 save of the state. The motion mode is not among it.
_SAVED_MODES: Final = ("absolute", "absolute_centers", "inch", "diameter_mode", "initial_level", "length_code")


class FunctionCodes:
    """F, S, T and M codes."""

    def __init__(self, core: Machining, values: WordValues) -> None:
        self.core, self.values, self.state = core, values, core.state
        self.modes: Modes = core.state.modes

    # --- feed, speed, tool ---------------------------------------------------------------------

    def set_feed(self, block: Block, g: dict[str, int]) -> None:
        state = self.state
        if (mode := g.get("feed mode")) is not None:
            name_feed_mode(self.core, _FEED_MODES[mode], block.line)
        if "F" in block.words:
            value = block.words["F"]
            if value < 0:
                raise block.error("VP007", f"F{value:g}: a feed rate is not negative", "F")
            self.core.set_feed(
                value if state.feed_mode == FeedMode.INVERSE else self.values.convert_length(value), value
            )

    def set_spindle_mode(self, block: Block, code: int) -> None:
        """G96: S is the speed of the surface, D the most turns a minute; G97: S is turns a minute."""
        words = block.words
        if code == 960 and "S" not in words:
            raise ProgramError("VP005", "G96 needs S, the speed of the surface")
        most = abs(words["D"]) if code == 960 and "D" in words else None
        self.core.auxiliary.set_spindle_mode(block, spell_g_code(code), words.get("S"), surface=code == 960, most=most)

    def execute(self, block: Block, m: dict[str, list[int]]) -> None:
        auxiliary, tools, words = self.core.auxiliary, self.core.tools, block.words
        if "S" in words:
            auxiliary.set_speed(block, words["S"], is_switched=any(code in _SPINDLE for code in m.get("spindle", [])))
        if "T" in words:
            tools.select(block, read_whole(block, "T"))
        for code in m.get("signals", []):
            self._set_output(block, code)
        for code in m.get("tool change", []):
            self._change_tool(block, code)
        for code in m.get("spindle", []):
            if code in _SPINDLE:
                auxiliary.execute_spindle_code(block, code, words.get("R", 0.0))
            else:
                self._save_or_restore(block, code)
        if "rigid tapping" in m:
            self.modes.stops_after_tapping = True
        for code in m.get("coolant", []):
            auxiliary.switch_coolant(block, code)
        for code in m.get("override", []):
            both = {"feed": code == 48, "speed": code == 48}
            auxiliary.set_overrides(block, both if code in (48, 49) else {_SWITCHES[code]: words.get("P", 1.0) != 0.0})

    def _change_tool(self, block: Block, code: int) -> None:
        """M6; M61, which only sets the number."""
        if code != 61:
            self.core.tools.change(block)
            if self.modes.cycle is not None:
                change = self.core.recorder.lines.find_own(block.line)
                self.modes.cycle = replace(self.modes.cycle, change=change)
            if "F" in block.words:  # it is that of the new tool
                self.core.recorder.note_feed()
            return
        if "Q" not in block.words:
            raise ProgramError("VP005", "M61 needs Q, the number of the tool")
        tool = read_whole(block, "Q")
        self.core.tools.check_tool(block, tool, "Q")
        self.core.tools.set_number(block, tool)

    # --- signals ---------------------------------------------------------------------------------

    def _set_output(self, block: Block, code: int) -> None:
        """M62 to M68: outputs, and M66, which waits for an input."""
        if code == 66:
            self._wait_for_input(block)
            return
        digital = code <= 65
        letter = "P" if digital else "E"
        if letter not in block.words:
            raise ProgramError("VP005", f"M{code} needs {letter}, the number of the output")
        output = read_whole(block, letter)
        if not digital and "Q" not in block.words:
            raise ProgramError("VP005", f"M{code} needs Q, the value")
        value: dict[str, object] = {"on": code in (62, 64)} if digital else {"value": block.words["Q"]}
        self.core.auxiliary.set_output(block, output, with_motion=code in (62, 63, 67), **value)

    def _wait_for_input(self, block: Block) -> None:
        words = block.words
        if ("P" in words) == ("E" in words):
            raise ProgramError("VP005", "M66 needs P, a digital input, or E, an analog one")
        how = read_whole(block, "L") if "L" in words else 0
        if how > _MAX_WAIT:
            raise block.error("VP007", f"M66 L{how}: modes of waiting are L0 to L{_MAX_WAIT}", "L")
        if how and "E" in words:
            raise block.error("VP007", "M66 E waits for nothing: only L0 goes with an analog input", "L")
        if how and words.get("Q", 0.0) <= 0:
            raise ProgramError("VP005", f"M66 L{how} needs Q, the longest time to wait, greater than 0")
        letter = "P" if "P" in words else "E"
        self.modes.inputs_read = True
        self.core.auxiliary.wait_for_input(block, read_whole(block, letter), analog=letter == "E", wait=how)

    # --- saved state ---------------------------------------------------------------------------------

    def _save_or_restore(self, block: Block, code: int) -> None:
        saved_states = self.modes.saved_states
        if code == 71:
            saved_states[-1] = None
        elif code == 72:
            last = saved_states[-1]
            if last is None:
                raise ProgramError("VP017", "M72 without M70 or M73 before it at the same level of calls")
            self._restore(last, block)
        else:
            state = self.state
            values = {name: getattr(self.modes, name) for name in _SAVED_MODES}
            frame = state.frame
            saved_states[-1] = Saved(
                values, save_settings(self.core), frame.system, state.g92_on, frame.tool, code == 73
            )

    def _restore(self, saved_state: Saved, at: At) -> None:
        state, frames = self.state, self.core.frames
        self.core.refuse_compensation("M72, or a return after M73,")
        for name, value in saved_state.values.items():
            setattr(self.modes, name, value)
        restore_settings(self.core, at, saved_state.settings)
        frames.select_system(saved_state.system)
        if saved_state.g92_on != state.g92_on:
            self.core.frames.apply_shift(on=saved_state.g92_on)
        if saved_state.tool != state.frame.tool:
            frames.set_frame(replace(state.frame, tool=saved_state.tool))
        say_directions(self.core)

    def leave_call(self, line: int) -> None:
        """Back from a call: bring back what M73 has saved in it."""
        saved_state = self.modes.saved_states.pop()
        if saved_state is not None and saved_state.automatic:
            self._restore(saved_state, At(line))
