"""Feed rate, spindle, auxiliary functions, tools and their edges of a Siemens block."""

from typing import Final

from verne_post.base.numbers import is_count
from verne_post.base.tolerances import WHOLE_NUMBER
from verne_post.gcode.codes import CodeTable, read_m_code
from verne_post.gcode.machining.auxiliary import read_stand_in, refuse_twice
from verne_post.gcode.machining.machining import name_feed_mode
from verne_post.gcode.missing_setup import number_of_tool
from verne_post.gcode.program_error import At
from verne_post.gcode.siemens.modes import FEED_CODES
from verne_post.gcode.siemens.motion import SiemensMotion
from verne_post.gcode.siemens.vocabulary import M_FUNCTIONS, REFUSED_WORDS
from verne_post.gcode.siemens.words import Word, Words
from verne_post.model.findings import Remedy
from verne_post.model.moves import ZERO9, FeedMode
from verne_post.model.part_setup import describe_tool_number

_FEED_MODES: Final = {code: mode for mode, code in FEED_CODES.items()}
#: M functions; those of the builder are given a meaning by [remap].
_M_CODES: Final = CodeTable(
    g_groups={},
    m_groups=M_FUNCTIONS,
    refused_g={},
    refused_m={int(word[1:]): why for word, why in REFUSED_WORDS.items() if word[0] == "M" and word[1:].isdigit()},
    words_of_g={},
    words_of_m={},
)


class SiemensAuxiliary:
    """Motion and splines, and what a block says beside them."""

    def __init__(self, motion: SiemensMotion) -> None:
        self.motion = motion
        self.core = motion.core
        self.setup = motion.setup
        self.state = motion.state
        self.recorder = motion.recorder
        self.keys = motion.keys

    def run(self, words: Words, block: At) -> None:
        speed = words.take("S") if words.find_code("dwell") is None else None
        tool = None if (word := words.take("T")) is None else self._read_tool_number(word)
        if (position := words.take("SPOS")) is not None:
            self._stop_spindle_at(position, block)
        if (edges := words.take("CUTMOD")) is not None:
            self._refuse_turned_edges(edges, words.line)
        if (function := words.take("H")) is not None:
            self.recorder.record_event(words.line, "auxiliary", code=f"H{function.value:g}")
        groups: dict[str, list[int]] = {}
        for name in words.user_names:
            if (stand_in := read_stand_in(self.setup.remap[name])) is not None:
                groups.setdefault(_M_CODES.group_of_m[stand_in], []).append(stand_in)
        for number, column in words.m:
            if number in (0, 1, 2, 17, 30):
                continue
            if self.core.auxiliary.execute_user_code(block, "M", float(number), {}):
                if (stand_in := self.core.auxiliary.find_stand_in("M", float(number))) is not None:
                    groups.setdefault(_M_CODES.group_of_m[stand_in], []).append(stand_in)
            else:
                groups.setdefault(_M_CODES.group_of_m[read_m_code(_M_CODES, float(number), column)], []).append(number)
        refuse_twice(groups, dict(words.m))
        if "gear" in groups:
            self.recorder.record_event(words.line, "without effect", word="M40")
        auxiliary, tools, spindle = self.core.auxiliary, self.core.tools, groups.get("spindle", [])
        if speed is not None:
            auxiliary.set_speed(block, speed.value, is_switched=bool(spindle))
        if tool is not None:
            tools.select(block, tool)
        for _code in groups.get("tool change", []):
            tools.change(block)
        for code in spindle:
            auxiliary.execute_spindle_code(block, code, 0.0)
        for code in groups.get("coolant", []):
            auxiliary.switch_coolant(block, code)
        self._select_edge(words, is_loaded=bool(groups.get("tool change")))

    def _stop_spindle_at(self, word: Word, at: At) -> None:
        """SPOS: the spindle stops at an angle; DC, ACP and ACN say in which sense it turns there."""
        if word.mode == "IC":
            raise word.error(
                "VP002", "SPOS=IC() counts from the angle of the spindle, which is not known here; write DC()"
            )
        self.core.auxiliary.orient_spindle(at, word.value)

    def _refuse_turned_edges(self, word: Word, line: int) -> None:
        """CUTMOD: only 0, cutting edges as the tool table has them."""
        if word.value:
            raise word.error(
                "VP002",
                f"CUTMOD={word.value:g} is not executed; cutting edges are as the tool table has them, CUTMOD=0",
            )
        self.recorder.record_event(line, "without effect", word="CUTMOD")

    def run_feed(self, words: Words) -> None:
        state = self.state
        if (mode := words.find_code("feed mode")) is not None:
            name_feed_mode(self.core, _FEED_MODES[mode], words.line)
        feed = words.take("F") if words.find_code("dwell") is None else None
        if feed is not None:
            if feed.value < 0:
                raise feed.error("VP007", f"F{feed.value:g}: a feed rate is not negative")
            self.motion.has_feed = True
            unit = 1.0 if state.feed_mode == FeedMode.INVERSE else self.motion.modes.feed
            self.core.set_feed(feed.value * unit, feed.value)
        self.motion.modes.feed_mode = state.feed_mode

    def _read_tool_number(self, word: Word) -> int:
        """T5, T="5", T="name"."""
        name = word.text
        if name is None or is_count(name):
            number = word.value if name is None else float(name)
            if abs(number - round(number)) > WHOLE_NUMBER or number < 0:
                raise word.error("VP007", f"T{number:g}: a tool number is whole and not negative")
            return round(number)
        return number_of_tool(name, f'T="{name}"', "siemens", self.setup, self.state, word.column)

    def _select_edge(self, words: Words, *, is_loaded: bool) -> None:
        """D: D1, which M6 brings, activates the tool's length; D0 cancels it. An empty spindle has no length."""
        word, state = words.take("D"), self.state
        waits = "T" in words.words and not is_loaded  # D beside T alone is that of the tool which M6 will bring
        tool = state.selected_tool if waits else state.loaded_tool
        on = word is None or self._is_edge_on(word, tool or 0)
        if (word is None and not is_loaded) or (waits and on):
            return
        if waits:
            text = (
                "D0 beside T without M6: M6 makes D1 of the new tool active, as on a control whose machine data 20270 "
                "is 1; write D0 in the block of M6, or after it, if no length is meant"
            )
            self.core.recorder.note_once("VP039", text, words.line)
        self.core.refuse_compensation("a change of tool offset")
        at, tools, self.motion.modes.edge = At(words.line), self.core.tools, on
        if not on or (is_loaded and not tool):
            tools.set_length(lambda: ZERO9)
        elif state.tools is None and not self.setup.machine:
            tools.expect_length()
        elif tool or not self.setup.machine or self.setup.tool_length is not None:
            tools.set_length(lambda: tools.find_offset(at, 0))
        self.motion.set_chain()

    def _is_edge_on(self, word: Word, tool: int) -> bool:
        """False for D0; D1 is the one edge of the tool. With the key ``d_numbers`` D is the tool's own number."""
        number, by_tool = round(word.value), self.keys.d_numbers == "tools"
        if abs(word.value - number) <= WHOLE_NUMBER and number in (0, tool if by_tool and tool else 1):
            return number != 0
        if by_tool and not tool:  # no tool, no length
            return True
        if by_tool:
            raise word.error(
                "VP012",
                f"D{word.value:g}, and the tool is {tool}: D has the number of its tool ([siemens] d_numbers); D0 "
                "switches the offset off",
            )
        if number == tool:
            raise word.error(
                "VP012",
                f"D{word.value:g}: the tool table has one edge a tool, D1; D0 switches the offset off; if D is the "
                'number of its tool, give [siemens] d_numbers = "tools" in the settings file',
            )
        name = describe_tool_number(tool, self.state.tool_names) if tool else "a tool"
        own = self.state.tool_names.get(tool, "")
        call = f'T="{own}_D{number}"' if own else "T with another number"
        text = (
            f"D{word.value:g}: the set-up gives {name} one cutting edge, D1; enter edge {number} in [tools] as a "
            f"separate tool, with length and diameter, and write {call}, and M6, where edge {number} is meant; "
            "or write D1"
        )
        error = word.error("VP012", text).advise("")
        error.edits = (Remedy("write D1", "D1", misspelt=f"D{word.value:g}", is_choice=True),)
        raise error
