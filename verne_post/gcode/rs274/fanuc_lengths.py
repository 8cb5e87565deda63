"""Tool lengths of Fanuc: G28, G30 and G53 cancel them, and in G91 a change of them may be travelled."""

from typing import Final

from verne_post.gcode.block import Block
from verne_post.gcode.codes import CYCLES, spell_g_code
from verne_post.gcode.machining.machining import Machining, explain_g91, note_length_end
from verne_post.gcode.machining.state import State
from verne_post.gcode.machining.turning import find_machine_place
from verne_post.gcode.rs274.fanuc_codes import PATTERNS, POCKETS
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.rs274.offsets import say_directions
from verne_post.gcode.rs274.values import WordValues
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import FanucKeys

_HOME: Final = (280, 300)
_DWELL: Final = 40
_G92: Final = 920
_G53: Final = 530
#: Lengths that differ by less are the same, mm.
_SAME_MM: Final = 1e-9


class FanucLengths:
    """What Z means after a tool length has changed, and after the control has cancelled it."""

    def __init__(self, core: Machining, values: WordValues, keys: FanucKeys) -> None:
        self.core, self.values, self.keys, self.state = core, values, keys, core.state
        self.modes: Modes = core.state.modes

    def measure(self) -> float:
        """The length in force on the control, mm; it is 0 after G28 has cancelled that of G43."""
        modes = self.modes
        if modes.length_code in (None, 490) or modes.length_number == 0 or self.state.length_end:
            return 0.0
        return self.core.setup.tool_length or self.state.frame.tool[2]

    def follow(self, block: Block, g: dict[str, int], before: float) -> None:
        """The modes of a block hold now, and the length was ``before``; refuses (VP017) a Z that is not certain."""
        modes, words = self.modes, block.words
        code = None if g.get("non-modal") == _DWELL else g.get("non-modal")
        if "tool length" in g:
            self._note_end("")
            modes.length_travel += self.measure() - before
        drills = code in PATTERNS or (code is None and modes.motion in CYCLES and not words.keys().isdisjoint("XYZR"))
        goes_home = code in _HOME or "machine coordinates" in g
        via = code in _HOME and "Z" in words and (modes.absolute or words["Z"] != 0.0)
        names_z = "Z" in words and (via or (not goes_home and code in (None, _G92, *POCKETS)))
        if not (names_z or drills):
            return
        if self.state.length_end:
            text = explain_length_end(self.core.setup, self.state)
            self._note_end("")  # it is one mistake, however often Z follows
            raise block.error("VP017", text, "Z")
        if abs(modes.length_travel) > _SAME_MM and (not modes.absolute or code == _G92):
            self._add_length_change(block, travels_itself=not drills and code is None)
        modes.length_travel = 0.0

    def _add_length_change(self, block: Block, *, travels_itself: bool) -> None:
        """Add the change of length to an incremental Z, where the control does."""
        change, self.modes.length_travel = self.modes.length_travel, 0.0
        key = self.keys.length_in_g91
        if key == "kept":
            return
        is_upright = self.core.setup.coordinates.is_upright(find_machine_place(self.core))
        if not is_upright and self.state.values_before_length is not None:  # VP016 refuses the motion
            return
        if key == "travelled" and travels_itself and is_upright and self.state.frame.feature is None:
            block.words["Z"] += change / self.values.convert_length(1.0)
            return
        text = (
            f"the tool length has changed by {change:g} mm, and Z does not name a place in G90 after it: parameter "
            "5006 of the control (TOS) decides whether an incremental Z also moves by that change; name Z in G90 once"
        )
        if not key:
            text += ', or give [fanuc] length_in_g91 = "travelled" or "kept" in verne-post.toml'
        raise explain_g91(self.core, block.error("VP017", text, "Z"), block.line)

    def end(self, block: Block, codes: set[int]) -> None:
        """A block of G28, G30 or G53 has been executed: with Z it cancels the length, though G43 stays in force."""
        code = next((code for code in (*_HOME, _G53) if code in codes), None)
        if code is None or ("Z" not in block.words and (code == _G53 or not {*"XYABC"}.isdisjoint(block.words))):
            return
        modes, length = self.modes, self.measure()
        modes.length_travel = 0.0
        if abs(length) <= _SAME_MM:
            return
        if self.keys.length_after_return == "restored":
            modes.length_travel = length
            return
        self._note_end(f"{spell_g_code(code)} of line {block.line}")

    def _note_end(self, by: str) -> None:
        """The control has cancelled the length ``by`` a code, so that no tip is held; empty where it takes one."""
        note_length_end(self.core, by)
        say_directions(self.core)


def explain_length_end(setup: Setup, state: State) -> str:
    """Why a Z is not certain after the control has cancelled the tool length, and what to write before it."""
    modes: Modes = state.modes
    number, length = modes.length_number, setup.tool_length or state.frame.tool[2]
    if number is None:  # the tool has been changed since
        tool = (state.tools or {}).get(state.loaded_tool or 0)
        number = state.loaded_tool or 0
        length = setup.tool_length or (0.0 if tool is None or tool.unmeasured else tool.offset[2])
    name, h = spell_g_code(modes.length_code or 0), f" H{number:g}" if number else ""
    deeper = f"{length:g} mm deeper" if length else "deeper by its length"
    return (
        f"{state.length_end} has cancelled the tool length of {name}, so Z would be that of the spindle, and the tool "
        f"{deeper}: write {name}{h} before Z, or G49 if it is meant; where the control restores the length (parameter "
        '5001, EVO), give [fanuc] length_after_return = "restored" in verne-post.toml'
    )
