"""Tools: which one is in the spindle, whose length holds, and how wide it is."""

import dataclasses
from collections.abc import Callable

from msgspec.structs import replace

from verne_post.base.printable import quote_key
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.frames import Frames, refuse_compensation
from verne_post.gcode.machining.state import describe_tool_event
from verne_post.gcode.missing_setup import check_measured, find_tool_key, report_missing_tool, stands_in
from verne_post.gcode.program_error import At, ProgramError
from verne_post.model.findings import Remedy
from verne_post.model.moves import ZERO9
from verne_post.model.part_setup import Tool, Vector9, describe_tool_number, spell_tool_word


class Tools:
    """Selects and changes tools, and puts their lengths in force."""

    def __init__(self, frames: Frames) -> None:
        self.frames, self.setup, self.state, self.recorder = frames, frames.setup, frames.state, frames.recorder
        #: Number and line of the first length of a program that has called no tool.
        self._first_length: tuple[int, int] | None = None
        #: Number of a tool whose sizes the program has written, and the word that did so.
        self._writers: dict[int, str] = {}

    # --- in the spindle ----------------------------------------------------------------------------

    def check_tool(self, at: At, number: int, word: str) -> None:
        """Refuse (VP012) a tool that the tool table does not have."""
        tools = self.state.tools
        is_assumed = self.setup.tools is None and all(map(stands_in, (tools or {}).values()))
        if (
            tools is not None
            and self.setup.tool_length is None
            and not is_assumed
            and number != 0
            and number not in tools
        ):
            raise report_missing_tool(number, word, at, self.setup, self.state)

    def select(self, at: At, number: int) -> None:
        """The tool comes with the next tool change."""
        name = self.state.tool_names.get(number, "")
        self.recorder.select_tool(number, at.line, name)
        self.check_tool(at, number, "T")
        self.state.selected_tool = number

    def change(self, at: At) -> None:
        """The selected tool comes into the spindle, which stops for it; VP041 where no T has selected one for it."""
        selections = self.recorder.selections
        if is_repeated := not selections or selections[-1].is_loaded:
            self._report_repeated_change(at)
        self._load(self.state.selected_tool or 0)
        if not is_repeated:
            selections[-1] = replace(selections[-1], is_loaded=True)
        refuse_compensation(self.state, "M6")
        self.state.spindle_on = False
        self._record("tool", at)

    def _report_repeated_change(self, at: At) -> None:
        """VP041: M6, and no T since the change of tools before it."""
        number = self.state.loaded_tool
        before = next((one.line for one in reversed(self.recorder.events) if one.kind == "tool"), 0)
        if not self.setup.machine or before == at.line:  # a block that is executed again says it once
            return
        text = (
            f"M6 without T: no block after line {before} selects a tool, so "
            f"{describe_tool_number(number, self.state.tool_names)} comes into the spindle again; write T before M6"
            if number
            else "M6 without T: no block before it selects a tool; write T and its number before M6"
        )
        self.recorder.warn("VP041", text, at.line, at.columns.get("M"))

    def explain_empty_spindle(self) -> str:
        """Why no tool is in the spindle, and what to write."""
        last = self.recorder.selections[-1] if self.recorder.selections else None
        if last is None or not last.number or last.is_loaded:
            return "no tool is in the spindle; load one with T and M6"
        name = describe_tool_number(last.number, self.state.tool_names)
        change = last.describe_change() if last.is_beside_pallet else "M6 after that T"
        return f"{name} of line {last.line} is only selected by T, and no M6 loads it; write {change}"

    def set_number(self, at: At, number: int) -> None:
        """No tool is changed: only its number is set (M61)."""
        self._load(number)
        self._record("tool number", at)

    def _record(self, kind: str, at: At) -> None:
        number = self.state.loaded_tool or 0
        self.recorder.record_tool(at.line, kind, number, describe_tool_event(self.state, number))

    def _load(self, number: int) -> None:
        state = self.state
        if number:
            self._check_one_tool(number)
        state.loaded_tool, state.called_tool = number, None
        if state.compensation is None and state.centre is not None:
            # the tool stays beside the contour that the end of compensation has left
            state.position, state.centre = state.centre, None

    def _check_one_tool(self, number: int) -> None:
        """--tool-length is the length of one tool."""
        state = self.state
        if self.setup.tool_length is not None and state.only_tool is not None and state.only_tool != number:
            names = [spell_tool_word(each, state.tool_names) for each in (state.only_tool, number)]
            raise ProgramError(
                "VP018",
                f"--tool-length is the length of one tool, but the program uses {names[0]} and {names[1]}; use "
                "--tool-table instead, or [tools] of the set-up (`verne-post setup` writes it), without tool_length",
                about=names[1],
                settled_by=find_tool_key(state.only_tool, "length", state.tool_names),
            )
        state.only_tool = number

    # --- length ------------------------------------------------------------------------------------

    def _check_length_number(self, at: At, number: int) -> None:
        """VP012: --tool-length is that of the tool in the spindle, and H has the number of one that no T has called."""
        own = self.state.loaded_tool
        is_called = any(one.number == number for one in self.recorder.selections)
        if not own or own == number or is_called or at.columns.get("H", 1) == 1:
            return
        why = f"{self._describe(own)} is in the spindle, and --tool-length is the length of that tool alone; "
        why += f"give both in [tools] of the set-up if H{number} is meant; did you mean H{own}?"
        raise at.error("VP012", f"H{number}: {why}", "H")

    def set_length(self, find_offset: Callable[[], Vector9]) -> None:
        """Put a tool offset in force. Where it cannot be found that is one error: no feed move lacks a length then."""
        self.state.has_tool_length, self.state.called_tool = True, None
        offset = find_offset()
        if self.setup.tool_length is None:
            self.frames.set_frame(replace(self.state.frame, tool=offset))

    def expect_length(self) -> None:
        """A length counts as given, though nobody knows it: without a machine."""
        self.state.has_tool_length = True

    def find_offset(self, at: At, number: int) -> Vector9:
        """The offset of a tool; of the one in the spindle for 0.

        ProgramError VP012: the tool is not known; VP007: this machine cannot use its offset.
        """
        state = self.state
        if self.setup.tool_length is not None:
            if number:
                self._check_length_number(at, number)
                self._check_one_tool(number)
            self._report_unused_length(at, number or state.loaded_tool or 0)
            return ZERO9
        if number == 0:
            number = state.loaded_tool or 0
        if number == 0:
            if self.setup.machine:
                raise ProgramError(
                    "VP012", f"G43 without H, and {self.explain_empty_spindle()}, or write G43 H, or use --tool-length"
                ).advise("")
            return ZERO9
        if state.tools is None or number not in state.tools:
            raise report_missing_tool(number, "H", at, self.setup, state)
        self.recorder.read_tools.add(number)
        check_measured(state.tools[number], self.setup, state, at.columns.get("H"))
        if number in self._writers:
            self.report_other_sizes(at.line, state.tools[number], self._writers[number], holds=True)
        offset, row = state.tools[number].offset, state.tools[number].row
        name = f"{row}: {self._describe(number)}" if row else self._describe(number)
        if self.setup.machine and offset[2] < 0:
            raise ProgramError("VP007", f"{name} has the length {offset[2]:g} mm; a length is not negative")
        if self.setup.machine and any(offset[:2] + offset[3:]):
            text = f"{name} has offsets other than a length (Z), which this machine cannot use"
            raise ProgramError("VP007", text)
        return offset

    def _report_unused_length(self, at: At, number: int) -> None:
        """Warn (VP018) where --tool-length holds in place of another length that the program gives the tool."""
        tool, only = (self.state.tools or {}).get(number), self.setup.tool_length
        if tool is None or tool.unmeasured or only is None or tool is (self.setup.tools or {}).get(number):
            return
        if abs(tool.offset[2] - only) > ZERO_LENGTH_MM:
            name = describe_tool_number(number, self.state.tool_names)
            text = (
                f"--tool-length gives {only:g} mm to the whole program, and the length that the program gives to "
                f"{name}, {tool.offset[2]:g} mm, is not used; leave out --tool-length (tool_length of the set-up) if "
                "the program is right"
            )
            self.recorder.note_once("VP018", text, at.line, severity="warning")

    def compare_length(self, at: At, number: int) -> None:
        """Warn (VP049) where the length that H puts in force contradicts that of the tool in the spindle.

        H counts in a table of the control, whose numbers need not be those of the tools (H51 for T1). So another number
        is no mistake by itself, but another length is. A tool that T has selected and M6 has not loaded is told where
        the tool table has another tool, of another length, that may be in the spindle in its place.
        """
        state, tools = self.state, self.state.tools or {}
        tool = state.loaded_tool or state.selected_tool
        if not tool and not self.recorder.selections and self.setup.machine and self.setup.tool_length is None:
            self._report_missing_change(at, number)
        if not self.setup.machine or self.setup.tool_length is not None or not tool or number == state.loaded_tool:
            return
        real = {key: one for key, one in tools.items() if not stands_in(one)}
        lengths = {key: one.offset[2] for key, one in real.items() if not one.unmeasured}
        if number not in lengths:
            return
        rivals, length = list(lengths) if tool == number else [tool], lengths[number]
        if not any(abs(lengths.get(rival, length) - length) > ZERO_LENGTH_MM for rival in rivals):
            return
        if state.loaded_tool:
            holds = f"{self._describe(tool)}, which has {lengths[tool]:g} mm, is in the spindle"
        else:
            holds = (
                "the tool table has others" if tool == number else f"T{tool} was called, which has {lengths[tool]:g} mm"
            )
        if self._explain_by_change(at, number, length, holds):
            return
        text = f"the length number {number}, {length:g} mm, is in force, but {holds}"
        if "H" in at.columns:
            text += f"; if tool {number} is to cut, call T{number} M6 before, else write H{tool}"
        own = Remedy("", str(tool), line=at.line, word=("H", number))
        self.recorder.note_once("VP049", text, at.line, (own,), number, "length", column=at.columns.get("H"))

    def _report_missing_change(self, at: At, number: int) -> None:
        """VP041, once a program: H puts another length in force than one before, and no tool has been called."""
        if self._first_length is None:
            self._first_length = number, self.recorder.lines.find_own(at.line)
        first, line = self._first_length
        one, other = ((self.state.tools or {}).get(key) for key in (first, number))
        if one is None or other is None or stands_in(one) or stands_in(other) or one.unmeasured or other.unmeasured:
            return
        if abs(one.offset[2] - other.offset[2]) <= ZERO_LENGTH_MM:
            return
        text = (
            f"no tool is called, and H{number} puts another length in force, {other.offset[2]:g} mm, than H{first} of "
            f"line {line}, {one.offset[2]:g} mm: if another tool is to cut, write T{number} M6 before, and T{first} M6 "
            f"before line {line}"
        )
        if not any(item.code == "VP041" for item in self.recorder.warnings.values()):
            self.recorder.note_once("VP041", text, at.line, (), number, "length")

    def _explain_by_change(self, at: At, number: int, length: float, holds: str) -> bool:
        """Whether the tool of H is not in the spindle because M6, or T, is missing before: VP041 there says so."""
        selections, warnings = self.recorder.selections, self.recorder.warnings
        last = selections[-1] if selections else None
        line = self.recorder.lines.find_own(at.line)
        puts = f"H{number} in line {line} puts its length, {length:g} mm, in force, and {holds}"
        if last is not None and not last.is_loaded and last.number == number:
            text = f"T{number} only selects the tool, and no M6 loads it: {puts}; write {last.describe_change()}"
            self.recorder.note_once("VP041", text, last.own_line, last.propose_change(), number, "length")
            return True
        change = next((one.own_line or one.line for one in reversed(self.recorder.events) if one.kind == "tool"), 0)
        warning = warnings.get((change, "VP041"))
        if warning is None or (last is not None and not last.is_loaded):
            return False
        if warning.tool is None:
            text = f"M6 without T loads no other tool: {puts}; write T{number} before M6"
            changed_warning = dataclasses.replace(warning, line=change, message=text, tool=number, quantity="length")
            warnings[change, "VP041"] = self.recorder.lines.name_calls().place(changed_warning)
        return True

    def compare_diameter(self, at: At, number: int) -> None:
        """Warn (VP049) where D puts the diameter of another tool in force than the one in the spindle has.

        D counts in a table of the control as H does. A tool that the set-up gives a diameter and no length is no tool
        but a number for wear, as D25 for T5.
        """
        tool, tools = self.state.loaded_tool, self.state.tools or {}
        if not self.setup.machine or not tool or number not in tools or tool not in tools:
            return
        diameters = [tools[one].diameter for one in (number, tool)]
        is_tool = any(number == one.number for one in self.recorder.selections) or not tools[number].unmeasured
        if min(diameters) <= 0 or abs(diameters[0] - diameters[1]) <= ZERO_LENGTH_MM or not is_tool:
            return
        if stands_in(tools[number]) or stands_in(tools[tool]):
            return
        text = (
            f"the diameter number {number}, {diameters[0]:g} mm, is in force, but {self._describe(tool)}, which has "
            f"{diameters[1]:g} mm, is in the spindle"
        )
        is_staged, own = self.state.selected_tool == number, Remedy("", str(tool), line=at.line, word=("D", number))
        warnings, last = self.recorder.warnings, self.recorder.selections[-1:]
        if not any(item.code == "VP041" and item.tool == number for item in warnings.values()):
            edits: tuple[Remedy, ...] = () if is_staged else (own,)
            for place, item in list(warnings.items()) if last and last[0].number == tool and edits else ():
                if (item.code, item.tool, item.quantity) == ("VP049", number, "length") and (item.line or 0) > last[
                    0
                ].line:
                    # H and D agree: T is as likely to be wrong
                    edit_of_tool = Remedy(
                        f"write T{number}", f"T{number}", line=last[0].line, misspelt=f"T{tool}", is_choice=True
                    )
                    edits = edit_of_tool, dataclasses.replace(own, is_choice=True)
                    theirs = [dataclasses.replace(one, is_choice=True) for one in item.edits if one != edit_of_tool]
                    warnings[place] = dataclasses.replace(item, edits=(edit_of_tool, *theirs))
            text += f"; if tool {number} is to cut, call T{number} M6 before, else write D{tool}" * bool(edits)
            self.recorder.note_once("VP049", text, at.line, edits, number, "diameter", column=at.columns.get("D"))

    def _describe(self, number: int) -> str:
        return describe_tool_number(number, self.state.tool_names)

    # --- the table ---------------------------------------------------------------------------------

    def find_diameter(self, at: At, number: int, instead: str) -> float:
        """Diameter of a tool in mm; ``instead`` is what may be done without the tool table.

        ProgramError VP012: it is not known.
        """
        state = self.state
        name = describe_tool_number(number, state.tool_names)
        own, diameters = state.loaded_tool, {key: one.diameter for key, one in (state.tools or {}).items()}
        if diameters.get(number, 0.0) <= 0 < diameters.get(own or 0, 0.0) and "D" in at.columns:
            text = (
                f"D{number}: {self._describe(own or 0)} is in the spindle, and {name} has no diameter in the set-up, "
                f"or the tool table (add it there if D{number} is meant); did you mean D{own}?"
            )
            raise at.error("VP012", text, "D", name, find_tool_key(number, "diameter", state.tool_names))
        key = find_tool_key(number, "diameter", state.tool_names)
        if state.tools is None or number not in state.tools:
            text = f"the diameter of {name} is not known; {self.suggest_diameter(number)}{instead}"
            raise at.error("VP012", text, "D", name, key)
        if self.setup.tool_length is not None and own and own != number and own not in diameters:
            # a length for all tools hides that the set-up lacks this one
            text = (
                f"D{number}: {self._describe(own)} is in the spindle, and the set-up gives it no diameter; "
                f"{self.suggest_diameter(own)}{instead}"
            )
            raise at.error("VP012", text, "D", name, find_tool_key(own, "diameter", state.tool_names))
        tool = self.find_called(number)
        assert tool is not None
        if tool.diameter <= 0:
            later = "" if tool is state.tools[number] else " when it was called; write D1 after the block that gives it"
            given = state.tools[number].key
            place = f": the set-up lacks {given}.diameter, mm" if given else " in the set-up, or the tool table"
            raise at.error("VP012", f"{name} has no diameter{place}{later}", "D", name, key)
        self.recorder.read_tools.add(number)
        self.recorder.radius_tools.add(number)
        return tool.diameter

    def report_stand_in(self, at: At) -> ProgramError | None:
        """VP012 of the diameter, where the tool in the spindle only stands in for one that was reported; else None.

        What its width leads to says nothing of the program.
        """
        number = self.state.loaded_tool or 0
        tool = (self.state.tools or {}).get(number)
        if tool is None or not stands_in(tool):
            return None
        name = describe_tool_number(number, self.state.tool_names)
        key = find_tool_key(number, "diameter", self.state.tool_names)
        text = f"the diameter of {name} is not known; {self.suggest_diameter(number)}"
        return at.error("VP012", text, "D", name, key)

    def suggest_diameter(self, number: int) -> str:
        """What gives a tool that is in no table its diameter."""
        key = quote_key(find_tool_key(number, "diameter", self.state.tool_names)[1])
        instead = " (which has no tool_length then)" if self.setup.tool_length is not None else ""
        entry = f"[tools] {key} = {{ length = MM, diameter = MM }}"
        return f"write {entry} into the set-up{instead}, or give --tool-table FILE"

    def define(self, tool: Tool, word: str = "") -> None:
        """Put a tool into the table, or in place of the one with its number; ``word`` writes sizes that are no wear."""
        if word:
            self._writers[tool.number] = word
        self.state.tools = {**(self.state.tools or {}), tool.number: tool}

    def define_for_next_call(self, tool: Tool, word: str = "") -> None:
        """Put a tool into the table; the one in the spindle keeps its sizes until its offset is called again."""
        if tool.number == self.state.loaded_tool and self.state.called_tool is None:
            self.state.called_tool = (self.state.tools or {}).get(tool.number)
        self.define(tool, word)

    def report_other_sizes(self, line: int, tool: Tool, word: str, *, holds: bool) -> bool:
        """Whether a tool that the program describes has a length from outside; VP018 where the two differ.

        ``holds``: the sizes of the program hold, because its word writes the table of the control.
        """
        given = (self.setup.tools or {}).get(tool.number)
        if not self.setup.machine or self.setup.tool_length is not None or given is None:
            return False
        if given.unmeasured or stands_in(given):
            return False
        sizes = [("length", tool.offset[2], given.offset[2])]
        sizes += [("diameter", tool.diameter, given.diameter)] if min(tool.diameter, given.diameter) > 0 else []
        sizes = [size for size in sizes if abs(size[1] - size[2]) > ZERO_LENGTH_MM]
        if sizes:
            own = " and ".join(f"{what} {mm:g} mm" for what, mm, _ in sizes)
            other = " and ".join(f"{what} {mm:g} mm" for what, _, mm in sizes)
            name = describe_tool_number(tool.number, self.state.tool_names)
            text = f"{word} gives {name} the {own}, but the set-up or the tool table gives the {other}; " + (
                f"that of {word} is used, because it writes the tool table: leave {word} out if the other is right"
                if holds
                else f"the measured one is used: correct it in the set-up or the table if that of {word} is right"
            )
            self.recorder.note_once("VP018", text, line, (), tool.number, sizes[0][0], "warning")
        return True

    def find_called(self, number: int) -> Tool | None:
        """A tool of the table; the one in the spindle as it was when its offset was called."""
        tool = self.state.called_tool
        return tool if tool is not None and tool.number == number else (self.state.tools or {}).get(number)

    def find_tool(self, number: int, where: str) -> Tool:
        """A tool of the table, or a new one, which ``where`` names without a length."""
        return (self.state.tools or {}).get(number, Tool(number, number, ZERO9, unmeasured=where))

    def reload_table(self) -> None:
        """The table is as it was at the start."""
        self._writers.clear()
        self.state.tools = dict(self.setup.tools) if self.setup.tools is not None else None
