"""Feed rate, spindle, auxiliary functions, tools and their edges of a Siemens block."""

from typing import Final

from verne_post.base.numbers import is_count
from verne_post.base.tolerances import WHOLE_NUMBER
from verne_post.gcode.block import Block, BlockError
from verne_post.gcode.missing_setup import number_of_tool
from verne_post.gcode.siemens.splines import SiemensSplines
from verne_post.gcode.siemens.words import Word, Words

_FEED_MODES: Final = {"G93": 930, "G94": 940, "G95": 950}


class SiemensAuxiliary(SiemensSplines):
    """Motion and splines, and what a block says beside them."""

    def _run_auxiliary(self, words: Words, block: Block) -> None:
        made = Block(words.line, columns=block.columns)
        if (speed := words.words.get("S")) is not None and words.code("dwell") is None:
            words.take("S")
            made.words["S"] = speed.value
        if (tool := words.take("T")) is not None:
            made.words["T"] = float(self._tool_number(tool))
        if (position := words.take("SPOS")) is not None:
            self._stop_spindle_at(position, words.line)
        if (edges := words.take("CUTMOD")) is not None:
            self._refuse_turned_edges(edges, words.line)
        if (function := words.take("H")) is not None:
            self.recorder.event(words.line, "auxiliary", code=f"H{function.value:g}")
        groups: dict[str, list[int]] = {}
        for number, column in words.m:
            if number in (0, 1, 2, 17, 30) or self._execute_user_code(made, "M", float(number)):
                continue
            groups.setdefault(self.table.group_of_m[self._m_code(float(number), column)], []).append(number)
        for group, codes in groups.items():
            if len(codes) > 1 and group != "coolant":
                raise BlockError(
                    "VP003", f"M{codes[0]} and M{codes[1]} are of one group ({group})", block.columns.get("M")
                )
        if "gear" in groups:
            self.recorder.event(words.line, "without effect", word="M40")
        self._execute_auxiliary(made, groups)
        self._select_edge(words, loaded=bool(groups.get("tool change")))

    def _stop_spindle_at(self, word: Word, line: int) -> None:
        """SPOS: the spindle stops at an angle; DC, ACP and ACN say in which sense it turns there."""
        if word.mode == "IC":
            raise word.error(
                "VP002", "SPOS=IC() counts from where the spindle stands, which is not known here; write DC()"
            )
        self.recorder.event(line, "orient", angle=word.value)
        self.state.spindle_on = False

    def _refuse_turned_edges(self, word: Word, line: int) -> None:
        """CUTMOD: only 0, cutting edges as the tool table has them."""
        if word.value:
            raise word.error(
                "VP002",
                f"CUTMOD={word.value:g} is not executed; cutting edges are as the tool table has them, CUTMOD=0",
            )
        self.recorder.event(line, "without effect", word="CUTMOD")

    def _run_feed(self, words: Words, block: Block) -> None:
        mode = words.code("feed mode")
        if mode is None and "F" not in words.words:
            return
        groups = {} if mode is None else {"feed mode": _FEED_MODES[mode]}
        made = Block(words.line, columns=block.columns)
        if (feed := words.words.get("F")) is not None and words.code("dwell") is None:
            words.take("F")
            made.words["F"] = block.words["F"] = feed.value
        self._set_feed(made, groups)
        self.modes.feed_mode = self.state.feed_mode
        if "F" in made.words and self.modes.feed != 1.0 and self.state.feed_mode.name != "INVERSE":
            self.state.feed *= self.modes.feed

    def _tool_number(self, word: Word) -> int:
        """T5, T="5", T="name"."""
        name = word.text
        if name is None or is_count(name):
            number = word.value if name is None else float(name)
            if abs(number - round(number)) > WHOLE_NUMBER or number < 0:
                raise word.error("VP007", f"T{number:g}: a tool number is whole and not negative")
            return round(number)
        return number_of_tool(name, f'T="{name}"', "siemens", self.setup, self.state, word.column)

    def _cutter_diameter(self, block: Block, code: int) -> float:
        """Of the tool in the spindle; with D0 the path is on the contour."""
        if self.state.loaded_tool and not self.modes.edge:
            return 0.0
        return super()._cutter_diameter(block, code)

    def _select_edge(self, words: Words, *, loaded: bool) -> None:
        """D: the length of the tool is in force with D1, which M6 brings with it; D0 takes it away. An empty spindle has no length."""
        word, state = words.take("D"), self.state
        waits = "T" in words.words and not loaded  # D beside T alone is that of the tool which M6 will bring
        tool = state.selected_tool if waits else state.loaded_tool
        on = word is None or self._switches_edge_on(word, tool or 0)
        if (word is None and not loaded) or (waits and on):
            return
        self._refuse_compensation("a change of tool offset")
        block, self.modes.edge = Block(words.line), on
        if not on or (loaded and not tool):
            self._set_tool_length(block, 490)
        elif state.tools is None and not self.setup.machine:
            state.length_given = True
        elif tool or not self.setup.machine or self.setup.tool_length is not None:
            self._set_tool_length(block, 430)
        self.set_chain()

    def _switches_edge_on(self, word: Word, tool: int) -> bool:
        """False for D0; D1 is the one edge of the tool, with the key ``d_numbers`` it is D and the tool's own number."""
        number, by_tool = round(word.value), self.keys.d_numbers == "tools"
        if abs(word.value - number) <= WHOLE_NUMBER and number in (0, tool if by_tool and tool else 1):
            return number != 0
        if by_tool and not tool:  # no tool, no length
            return True
        if by_tool:
            raise word.error(
                "VP012",
                f"D{word.value:g}, and the tool is {tool}: D has the number of its tool ([siemens] d_numbers); D0 switches the offset off",
            )
        raise word.error("VP012", f"D{word.value:g}: the tool table has one edge a tool, D1; D0 switches the offset off; where D has the number of its "
                         'tool, say so: [siemens] d_numbers = "tools" in the settings file')  # fmt: skip
