"""Tools, feed rates and M functions of Klartext."""

import dataclasses
import re
from itertools import pairwise
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.suggestions import MAY_BE_MEANT, drop_doubles, find_meant_number, list_near_numbers
from verne_post.gcode.codes import RS274, make_unknown_function
from verne_post.gcode.expressions import MAX_NUMBER
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.first_words import LETTERS_AS_DIGITS
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.vocabulary import (
    ARC_FEEDS,
    AT_BEGIN,
    AT_END,
    FUNCTIONS,
    FUNCTIONS_WITHOUT_EFFECT,
    REFUSED_FUNCTIONS,
)
from verne_post.gcode.klartext.words import TOOL_WORDS, MWord, Words, read_words
from verne_post.gcode.machining.machining import warn_of_deviation
from verne_post.gcode.machining.turning import warn_of_late_tcp
from verne_post.gcode.missing_setup import number_of_tool
from verne_post.gcode.offsets import make_vector9
from verne_post.gcode.program_error import At, ProgramError, locate_errors, write_before
from verne_post.model.findings import Remedy
from verne_post.model.moves import ZERO9, FeedMode, MoveKind
from verne_post.model.part_setup import Tool, describe_tool_number

_TOOL_NAME: Final = re.compile(r"[ \t]*(?:\"([^\"]+)\"|(QS\d+))(?=[ \t]|$)")
_TOOL_NUMBER: Final = re.compile(r"[ \t]*(\d+(?:[.,]\d+)?|Q[LR]?\d+)(?=[ \t]|$)")
_TOOL_AXIS: Final = re.compile(r"[ \t]+([XYZUVW])(?=[ \t]|$)")
_FULL_TURN: Final = 360.0
#: Functions that say in which system the coordinates of their block are.
_PLACES: Final = {91, 92, 130}
_THREE_DIGITS: Final = 100
#: A digit, and the one on the key beside it.
_KEYS_BESIDE: Final = tuple([pair] for a, b in pairwise("1234567890") for pair in (a + b, b + a))
#: Functions of which one may stand in a block.
_ALIKE: Final = (_PLACES, set(ARC_FEEDS))


class KlartextFunctions:
    """The contour, and what happens beside it."""

    def __init__(self, frames: KlartextFrames, contour: KlartextContour) -> None:
        self.frames = frames
        self.contour = contour
        self.core = frames.core
        self.setup = frames.setup
        self.state = frames.state
        self.q = frames.q
        self.modes = frames.modes
        self.waiting = frames.waiting
        self.calls: list[str] = []  #: What a block asks for at its end: "cycle" (M99), "modal" (M89).
        self.has_ended = False
        self.delta_length = 0.0
        self.core.auxiliary.switch_tcp = lambda on, _at: self.set_tcp(on=on)
        self.spindle_angle = 0.0  #: Cycle 13: where M19 orients the spindle.

    # --- tools ---------------------------------------------------------------------------------------------

    def call_tool(self, statement: Statement) -> None:
        """TOOL CALL 5 Z S2500 F500 DL+0.1 DR+0.05; without a number only S and F."""
        self.waiting.refuse("TOOL CALL")
        text = statement.rest
        number, at = self.read_tool(statement)
        axis = _TOOL_AXIS.match(text if at else " " + text, at)
        if axis is not None:
            at = axis.end() - (0 if at else 1)
            if axis.group(1) != "Z":
                what = f"tool axis {axis.group(1)}: the spindle of this machine points along Z"
                raise statement.error("VP017", what, at - 1)
        statement = replace(statement, rest=text[at:], begin=statement.begin + at)  # of which the words have columns
        words = read_words(statement, self.q)
        speed, feed = words.take("S"), words.take("F")
        delta = self.frames.convert_length(words.take("DL") or 0.0), self.frames.convert_length(words.take("DR") or 0.0)
        for name in ("FZ", "FU"):
            if name in words.values:
                raise statement.error(
                    "VP002", f"{name} of TOOL CALL is not executed; give F in mm/min", words.columns[name]
                )
        if words.take("DR2"):
            raise statement.error("VP002", "DR2 is not executed: radii of ball ends are not compensated")
        words.check_used(statement)
        if feed is not None:
            with statement.place_errors(words.columns["F"]):
                self.core.set_feed(self.contour.read_feed_word(feed))
            self.contour.call_feed = feed
            self.contour.change_feed_mode(FeedMode.PER_MINUTE)
        if number is not None:
            self.core.refuse_compensation("TOOL CALL")
            self.warn_of_tcp("TOOL CALL")
            self._change(number, *delta, column=statement.begin - len(text[:at].lstrip()) + 1)
            if feed is not None:
                self.core.recorder.note_feed()
        elif any(delta):
            raise statement.error("VP006", "DL and DR belong to a tool number")
        if speed is not None:
            self.core.auxiliary.set_speed(At(self.frames.block.line, {"S": 1}), speed, is_switched=False)

    def read_tool(self, statement: Statement) -> tuple[int | None, int]:
        """The number of the called or defined tool, by number or name, and the end of the words; None without one."""
        text = statement.rest
        if (name_match := _TOOL_NAME.match(text)) is not None:
            quoted_name, parameter = name_match.groups()
            name = quoted_name if quoted_name is not None else self.q.read_text(parameter)
            column = statement.begin + name_match.end() - len(name_match.group().lstrip()) + 1
            call = f'{statement.keyword} "{name}"'
            return number_of_tool(name, call, "heidenhain", self.setup, self.state, column), name_match.end()
        found = _TOOL_NUMBER.match(text)
        if found is None:
            if letters := re.match(r"[ \t]*([\dLIO]+)(?=[ \t]+Z)", text):
                right = letters[1].translate(LETTERS_AS_DIGITS)
                message = f"{letters[1].replace('L', 'l')}: a letter in the number; did you mean {right}?"
                raise statement.error("VP001", message, letters.start(1))
            return None, 0
        name = found.group(1)
        number = self.q.read_value(name) if name.startswith("Q") else float(name.replace(",", "."))
        if not 0 <= number <= MAX_NUMBER or number != int(number):
            raise statement.error("VP002", f"tool {name}: stepped tools are not known here; a tool number is whole")
        return int(number), found.end()

    def _change(self, number: int, delta_length: float, delta_radius: float, *, column: int) -> None:
        """The tool comes into the spindle, and its length counts at once."""
        line, state = self.frames.block.line, self.state
        length_before = state.frame.tool_length
        self.contour.delta_radius, self.delta_length = delta_radius, delta_length
        self.contour.delta_line = self.core.recorder.lines.find_own(line) if delta_radius else 0
        at, tools = At(line, {"T": column, "H": column}), self.core.tools
        tools.select(at, number)
        tools.change(at)
        tools.set_length(lambda: tools.find_offset(at, number) if number else ZERO9)
        name_of_tool = describe_tool_number(number, state.tool_names)
        if delta_length:
            if delta_length > state.frame.tool_length > 0:
                text = (
                    f"DL{delta_length:+g} makes {name_of_tool} {delta_length:g} mm longer than the "
                    f"{state.frame.tool_length:g} mm that it has: DL is a deviation, mostly below 1 mm; write the "
                    "length of the tool into the tool table"
                )
                self.core.recorder.warn("VP505", text, line, None)
            length = state.frame.tool_length + delta_length
            if self.setup.machine and length < 0:
                raise ProgramError(
                    "VP007", f"{name_of_tool} has the length {length:g} mm with DL; a length is not negative"
                )
            if delta_length <= state.frame.tool_length:
                warn_of_deviation(self.core, "DL", delta_length, 0.0, name_of_tool, line)
            self.core.frames.set_frame(
                replace(state.frame, tool=make_vector9((*state.frame.tool[:2], length, *state.frame.tool[3:])))
            )
        if (
            self.setup.coordinates.head
        ):  # without M128 a length along Z of the machine is another place of a turned tool
            self.frames.refresh_frame()
        self.contour.paths.note_length(length_before)
        self._show_tool()

    def hide_tool(self) -> None:
        """After a refused TOOL CALL: what reads Q108 and Q114 only follows from that, and the tool before is gone."""
        for number in (108, 114):
            self.q.control_values.pop(number, None)
            self.q.refuse(f"Q{number}")

    def _show_tool(self) -> None:
        """Q108, Q109 and Q114: radius, axis and length of the tool."""
        state = self.state
        number = state.loaded_tool or 0
        tool = (state.tools or {}).get(number)
        if tool is not None and tool.diameter:
            self.q.control_values[108] = 0.5 * tool.diameter + self.contour.delta_radius
        else:  # not that of the tool before
            self.q.control_values.pop(108, None)
            self.q.refused_names.discard("Q108")
        self.q.control_values |= {109: 2.0, 114: state.frame.tool_length}

    def define_tool(self, statement: Statement) -> None:
        """TOOL DEF 5 L+80 R+5; with the number alone the tool that comes next."""
        number, at = self.read_tool(statement)
        if number is None:
            raise statement.error("VP005", "TOOL DEF needs the number of the tool, or its name")
        rest = replace(statement, rest=statement.rest[at:], begin=statement.begin + at)
        if self.state.loaded_tool is None:  # nothing has called a tool, for which it may prepare the next one
            self.core.recorder.select_tool(number, self.frames.block.line, is_defined=True)
        words = read_words(rest, self.q, TOOL_WORDS)
        given = [(name[0], words.take(name)) for name in ("LEN", "L", "R")]
        words.check_used(rest)
        sizes = {letter: self.frames.convert_length(value) for letter, value in given if value is not None}
        if not sizes:
            return
        if "L" not in sizes or sizes.get("R", 0.0) < 0:
            raise statement.error("VP005", "TOOL DEF needs L, the length, and R, the radius, not negative")
        offset = make_vector9((0.0, 0.0, sizes["L"], *ZERO9[3:]))
        tools, tool = self.core.tools, Tool(number, number, offset, 2 * sizes.get("R", 0.0))
        if tools.report_other_sizes(self.frames.block.line, tool, "TOOL DEF", holds=False):
            measured_tool = tools.find_tool(number, "")
            tool = dataclasses.replace(measured_tool, diameter=measured_tool.diameter or tool.diameter)
        tools.define_for_next_call(tool)

    # --- M functions ----------------------------------------------------------------------------------------

    def run_codes(self, codes: list[int], speed: float | None = None) -> None:
        """Execute M codes of spindle, coolant and stops; ``speed`` is S of their block."""
        at, auxiliary = At(self.frames.block.line, {"S": 1}), self.core.auxiliary
        groups: dict[str, int] = {}
        for code in codes:
            if auxiliary.execute_user_code(at, "M", float(code), {}):
                continue
            groups[RS274.group_of_m[code]] = code
        if speed is not None:
            auxiliary.set_speed(at, speed, is_switched="spindle" in groups)
        if "spindle" in groups:
            auxiliary.execute_spindle_code(at, groups["spindle"], self.spindle_angle)
        if "coolant" in groups:
            auxiliary.switch_coolant(at, groups["coolant"])
        if (stop := groups.get("stopping")) in (2, 30):
            self.has_ended = True
            auxiliary.end(at, f"M{stop}")
        elif stop is not None:
            auxiliary.stop(at, stop)

    def check_functions(self, words: Words, beside: str = "") -> None:
        """Refuse M functions that are not executed, or mean nothing ``beside`` other words, before the block is."""
        numbers = [word.number for word in words.functions]
        groups: dict[str, int] = {}
        for at, word in enumerate(words.functions):
            number = word.number
            if number in numbers[:at] or any(number in alike and alike & {*numbers[:at]} for alike in _ALIKE):
                raise ProgramError("VP004", f"M{number} after M{numbers[at - 1]}: one of them is enough", word.column)
            if self.core.auxiliary.find_user_meaning("M", number) is None:
                for group in {RS274.group_of_m[code] for code in (*AT_BEGIN.get(number, ()), *AT_END.get(number, ()))}:
                    if (other := groups.setdefault(group, number)) != number:
                        text = f"M{other} and M{number} are of one modal group ({group})"
                        raise ProgramError("VP003", text, word.column)
            if number in _PLACES and beside != "coordinates":
                raise ProgramError("VP006", f"M{number} needs L and coordinates in its block", word.column)
            if number in (89, 99) and beside not in ("", "coordinates"):
                right = "write it in a separate block"
                if beside == "CYCL CALL":
                    right = "both call the cycle; write one of the two"
                raise ProgramError("VP017", f"M{number} beside {beside}; {right}", word.column)
            if number in REFUSED_FUNCTIONS and self.core.auxiliary.find_user_meaning("M", number) is None:
                text = f"M{number} is not executed ({REFUSED_FUNCTIONS[number]})"
                near = _list_near_functions(number, tcp=self.modes.tcp)
                edits = tuple(Remedy(f"write M{one}", f"M{one}", misspelt=f"M{number}", is_choice=True) for one in near)
                text += f"; M{near[0]}{MAY_BE_MEANT}" if edits else ""
                raise ProgramError("VP002", text, word.column, edits=edits)
            is_known = number in FUNCTIONS or number in FUNCTIONS_WITHOUT_EFFECT
            if not is_known and self.core.auxiliary.find_user_meaning("M", number) is None:
                raise make_unknown_function(number, word.column, _list_near_functions(number, tcp=self.modes.tcp))

    def begin_functions(self, words: Words) -> None:
        """What M functions do at the beginning of their block; S of the block."""
        speed = words.take("S")
        codes = [code for word in words.functions for code in AT_BEGIN.get(self._find_meant(word.number), ())]
        if speed is not None or codes:
            self.run_codes(codes, speed)
        for word in words.functions:
            if word.number not in FUNCTIONS:
                self.core.auxiliary.execute_user_code(self.frames.block, "M", word.number, {})
            else:
                self._begin_own(word)

    def _find_meant(self, number: int) -> int:
        """The M function as which one is executed: [remap] may name it."""
        stand_in = None if number in FUNCTIONS else self.core.auxiliary.find_stand_in("M", number)
        return number if stand_in is None else stand_in

    def _end_feed(self, number: int) -> None:
        """M136 or M137: the number in force is one of the other kind, and F is to be given again."""
        core, line = self.core, self.frames.block.line
        is_zero, had_feed = core.has_zero_feed, core.state.feed > 0.0 or core.why_no_feed
        core.set_feed(0.0)
        core.has_zero_feed = is_zero
        if had_feed:
            unit = "mm per turn" if number == 136 else "mm/min"
            core.why_no_feed = f": M{number} of line {line} has ended the last F, and takes a new one in {unit}"

    def _begin_own(self, word: MWord) -> None:
        number = word.number
        if number == 94:
            self._reduce_angles(word.axes)
        elif number == 126:
            self.contour.paths.shortest = True
        elif number == 116:
            self.frames.metres = True
        elif number in (136, 137):
            if self.contour.per_turn != (number == 136):
                self._end_feed(number)
            self.contour.per_turn, recorder = number == 136, self.core.recorder
            self.contour.turn_line = 0 if number == 137 else recorder.lines.find_own(self.frames.block.line)
            recorder.turn_feeds.append((self.contour.turn_line, recorder.count))
        elif number in (109, 110):
            self.core.set_arc_feed(ARC_FEEDS[number])
        elif number == 19:
            self.run_codes([19])
        elif number == 128:
            self.set_tcp(on=True)
        elif number == 99:
            self.calls.append("cycle")
        elif number == 89:
            self.calls.append("modal")

    def end_functions(self, words: Words) -> None:
        """What M functions do at the end of their block."""
        for word in words.functions:
            number = word.number
            if number == 140:
                self._retract(word)
            elif number == 129:
                self.set_tcp(on=False)
            elif number == 111:
                self.core.set_arc_feed(ARC_FEEDS[number])
            elif number == 127:
                self.contour.paths.shortest = False
            elif number == 117:
                self.frames.metres = False
        codes = [code for word in words.functions for code in AT_END.get(self._find_meant(word.number), ())]
        if codes:
            self.run_codes(codes)

    def set_tcp(self, *, on: bool) -> None:
        """M128 and M129: the machine stands still, its coordinates change their meaning."""
        if not on and self.state.tool_axis is not None:  # a tool vector without angles ends
            self.core.settle_table(self.frames.block)
        self.waiting.refuse("M128" if on else "M129")
        self.core.refuse_compensation("M128" if on else "M129")
        if on and not self.modes.tcp:
            self.modes.tcp_line = self.core.recorder.lines.find_own(self.frames.block.line)
            self.core.recorder.leave_plane(self.modes.tcp_line)
            if self.frames.maps.tilt is None:
                warn_of_late_tcp(self.core, self.contour.last_cut, self.modes.tcp_line, "M128")
        self.modes.tcp = on
        self.frames.refresh_frame()

    def warn_of_tcp(self, what: str) -> None:
        """VP043, once for each M128 that was read, where it holds at what manuals of TNC controls place after M129."""
        if self.modes.tcp and self.modes.tcp_line:
            line = self.frames.block.line
            code = f"M128 of line {self.modes.tcp_line} is still in force"
            where, edits = f"at {what}, before which controls require its end", write_before("M129", line=line)
            self.core.watcher.report(code, where, "write M129 first", line, edits)

    def _reduce_angles(self, letters: str) -> None:
        """M94: positions of A and C as numbers from 0 to less than a turn; A below 0, which makes no turns, stays."""
        for axis, letter in zip(self.setup.rotary, self.setup.rotary_letters, strict=True):
            if (not letters or letter in letters) and letter in self.setup.axes:
                value = self.state.position[axis]
                is_turned = axis == self.setup.rotary[1] or abs(value) >= _FULL_TURN
                self.frames.wraps[axis] = _FULL_TURN * (value // _FULL_TURN) if is_turned else 0.0
                self.frames.open_turns.pop(axis, None)
                if value < 0 and is_turned:
                    self.frames.open_turns[axis] = f"M94 in line {self.frames.block.line} has reduced {letter}{value:g}"

    def _retract(self, word: MWord) -> None:
        """M140 MB: away along the tool axis."""
        self.waiting.refuse("M140")
        if not word.to_limit and "MB" not in word.words:
            raise ProgramError("VP005", "M140 needs MB and a distance, or MB MAX", word.column)
        distance = None if word.to_limit else self.frames.convert_length(word.words["MB"])
        with self.core.keep_feed():
            if "F" in word.words:
                with locate_errors(word.column):
                    self.contour.set_feed_word(word.words["F"])
            self.retract(distance, MoveKind.FEED if "F" in word.words else MoveKind.RAPID)

    def retract(self, distance: float | None, kind: MoveKind) -> None:
        """Away along the tool axis, mm; None: to machine coordinate Z 0, if the tool is below it."""
        state = self.state
        self.frames.refuse_beside("a retract along the tool axis")
        if distance is None:
            machine = self.frames.find_machine_position()
            if machine[2] < 0 or not state.is_known(2):  # while the start is sought, this names Z
                machine[2] = 0.0
                self.frames.move_machine(kind, machine, [2])
                self.frames.refresh_frame()
            return
        if distance < 0:
            raise ProgramError("VP007", f"MB{distance:g} mm: a retract is not negative")
        self.core.require_known(self.frames.block, [2], "a retract by MB")
        axis = self.setup.coordinates.find_tool_axis(state.position, state.frame)
        end = list(state.position)
        end[:3] = [
            float(v) for v in np.array(end[:3]) + distance * (np.array([0.0, 0.0, 1.0]) if axis is None else axis)
        ]
        self.core.start_of_motion(kind, absolute=True, machine=False)
        self.frames.run_line(self.frames.block, kind, end, [0, 1, 2], absolute=False)


def _list_near_functions(number: int, *, tcp: bool) -> list[int]:
    """The M function that a slip of typing makes of this number: [] where none, or no one, is likely.

    M129 ends M128, and each is meant only where the other state holds.
    """
    digits, switch = str(number), "129" if tcp else "128"
    known_numbers = [str(one) for one in FUNCTIONS if one not in (128, 129)]
    shorter_numbers = [one for one in drop_doubles(digits, "0-9") if one in (*known_numbers, switch)]
    if len(set(shorter_numbers)) == 1:
        return [int(shorter_numbers[0])]
    if list_near_numbers(digits, [switch]):  # of two digits, as M12, it may be another one where M128 is not in force
        return [int(switch)] if tcp or number >= _THREE_DIGITS else []
    beside = [
        one
        for one in known_numbers
        if len(one) == len(digits) and [a + b for a, b in zip(one, digits, strict=True) if a != b] in _KEYS_BESIDE
    ]
    near = beside or [one for one in known_numbers if number >= _THREE_DIGITS and find_meant_number(digits, [one])]
    return [int(near[0])] if len(near) == 1 else []
