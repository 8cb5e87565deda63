"""After an error: the state that the program would have had, so that nothing is reported that only follows from it.

What the error calls missing or wrong is assumed to be right, and the block is executed again; where that is impossible,
its modal words and its end point are taken. Nothing of this reaches the user: a program with an error has no moves.
"""

import re
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Final

from verne_post.base.suggestions import find_correction
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.block import Block
from verne_post.gcode.codes import CYCLES, TAKES_AXES
from verne_post.gcode.execution import FATAL
from verne_post.gcode.machining.assumptions import (
    assume_homes,
    assume_length,
    assume_loaded_tool,
    assume_only_tool,
    assume_rigid_tapping,
    assume_tools,
    assume_turning_spindle,
    drop_compensation,
    keep_only_tool,
    lose_axis,
    place_axis,
)
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.values import LINEAR
from verne_post.model.moves import AXES, ZERO9

#: Codes of words that are missing or too many: beside what has been left out of a block they follow from that.
OF_WORDS: Final = ("VP005", "VP006")
#: So many errors of one block.
_MAX_TRIES: Final = 8
_COMMENTS: Final = re.compile(r"\([^()]*\)?|;.*", re.DOTALL)
#: A letter, and its number where that is short and plain.
_WORD: Final = re.compile(r"([A-Z])\s*(\d{1,6}(?:\.\d{0,3})?(?![\d.])|)")
#: A variable that is set, also where its name is not closed; and the one that a message begins with.
_SETTING: Final = re.compile(r"#(<[^<>=]*|\d+)>?\s*=(?!=)")
#: A variable at the beginning of a line, whose = may be what is missing.
_SETTING_ALONE: Final = re.compile(r"\A\s*(?:N\d+\s*)?#(<[^<>=]*|\d+)")
_VARIABLE: Final = re.compile(r"#(<[^<>]*|\d+)")
#: Groups of codes that are no modes.
_NO_MODES: Final = ("motion", "cancel", "non-modal", "machine coordinates", "subprograms", "cutter compensation")


def place_at_code(error: ProgramError, block: Block) -> None:
    """Give what is missing, which has no column, that of the code that the message begins with."""
    if error.code == "VP005" and not (error.column or error.line):
        error.column = block.find_code(error.message.partition(" ")[0])


class Recovery:
    """Executes blocks of one program, and goes on after errors.

    ``uncertain`` are axes whose position is reported as unknown, or depends on a block that was not executed.
    """

    def __init__(self, interpreter: Rs274) -> None:
        self.interpreter = interpreter
        self.uncertain: set[int] = set()
        #: Rotary axes that stand elsewhere, where a block names axes that the machine lacks.
        self._lost_turns: set[int] = set()
        self._is_any_unset = False  #: Of a line that sets a variable nothing but = and its value is there.
        self._unset: set[str] = set()  #: Variables that lines set which could not be read.

    def execute(self, block: Block) -> list[ProgramError]:
        """Execute a block as far as possible; returns its errors, without those that follow from others."""
        self._lost_turns -= {axis for axis in self._lost_turns if AXES[axis] in block.words}
        with keep_only_tool(self.interpreter.state):
            return self._execute(block)

    def _execute(self, block: Block) -> list[ProgramError]:
        execute: Callable[[Block], None] = self.interpreter.execute
        errors: list[ProgramError] = []
        for _ in range(_MAX_TRIES):
            try:
                execute(block)
                return errors
            except ProgramError as error:
                self.interpreter.recorder.give_up(block.line)
                place_at_code(error, block)
                if not self._follows(error, errors):
                    errors.append(error)
                if error.code in FATAL:
                    return errors
                if not self._assume(block, error):
                    break
            execute = partial(Rs274.execute, self.interpreter)  # the block is in the words of RS274/NGC by now
        self._give_up(block)
        return errors

    def pass_unread(self, text: str, line: int) -> None:
        """Take the codes of a line that could not be read; its axes are uncertain, without one X and Y."""
        block = Block(line)
        if re.match(r"\s*(?:N\d+\s*)?=", text, re.IGNORECASE):  # the name is what is missing
            self._is_any_unset = True
        self._unset |= {"".join(one.split()).lower() for one in _SETTING.findall(text) + _SETTING_ALONE.findall(text)}
        words = _WORD.findall(_COMMENTS.sub("", text).upper())
        if not any(letter in AXES for letter, _number in words):  # a letter may be what is missing
            words += [("X", ""), ("Y", "")]
        for letter, number in words:
            if letter in AXES:
                self._lose(AXES.index(letter))
            elif number and letter in "GM":
                block.codes.append((letter, float(number), 0))
            elif number and letter in "FSTH":
                block.words[letter], block.columns[letter] = float(number), 0
        self._give_up(block)
        if self.interpreter.modes.motion is None:  # its code may be what could not be read
            self.interpreter.modes.motion = 0

    def follows_unread(self, error: ProgramError) -> bool:
        """True where a variable has no value because the line that sets it could not be read."""
        variable = _VARIABLE.match(error.message)
        is_unset = variable is not None and (self._is_any_unset or variable[1].lower() in self._unset)
        return error.code == "VP025" and is_unset

    def _follows(self, error: ProgramError, errors: list[ProgramError]) -> bool:
        """True for an error that another one has caused."""
        if error.code == "VP013":
            unknown_axes = {axis for axis, is_known in enumerate(self.interpreter.state.known_axes) if not is_known}
            is_reported = bool(unknown_axes & self.uncertain)
            self.uncertain |= unknown_axes
            return is_reported or bool(errors)
        compensation = self.interpreter.state.compensation
        if error.code == "VP026" and compensation is not None and compensation.is_assumed:
            return True
        if error.code == "VP017" and self._lost_turns:
            return self.interpreter.core.find_tilted_tool(PLANES[self.interpreter.state.plane][2]) is not None
        if errors and error.leaves_unknown:  # without the words that have been left out
            errors[0].leaves_unknown = True
            return True
        return bool(errors) and error.code in OF_WORDS  # words beside what has been left out of the block

    # --- what the block needs is assumed ----------------------------------------------------------

    def _assume(self, block: Block, error: ProgramError) -> bool:
        """Let a block do without what the error names; False where it cannot."""
        assume = {
            "VP002": self._drop_code,
            "VP003": self._drop_code,
            "VP005": self._assume_motion,
            "VP006": self._drop_word,
            "VP009": self._assume_feed,
            "VP011": self._drop_axes,
            "VP012": self._assume_tool,
            "VP015": self._assume_home,
            "VP016": self._go_on,
            "VP018": self._assume_one_tool,
            "VP048": self._assume_rigid_tapping,
        }.get(error.code)
        return assume is not None and assume(block, error)

    def _go_on(self, _block: Block, _error: ProgramError) -> bool:
        return True

    def _assume_one_tool(self, _block: Block, _error: ProgramError) -> bool:
        """--tool-length is that of the tool of this block; :meth:`execute` brings the first one back."""
        assume_only_tool(self.interpreter.state)
        return True

    def _assume_rigid_tapping(self, _block: Block, _error: ProgramError) -> bool:
        assume_rigid_tapping(self.interpreter.state)
        return True

    def _drop_code(self, block: Block, error: ProgramError) -> bool:
        other_codes = [code for code in block.codes if code[2] != error.column]
        correction = find_correction(error.message)
        is_refused = correction is not None and correction[0] == "not executed"  # and may be meant as it is written
        if correction is not None and correction[1].startswith("G") and not is_refused:
            right = ("G", float(correction[1][1:]), error.column or 0)
            others = [code for code in block.codes if code[2] != error.column]
            # words beside it may have added the code already
            is_there = any(code[:2] == right[:2] for code in others)
            block.codes = others if is_there else [*others, right]
            return True
        dropped_letters = [letter for letter, _number, column in block.codes if column == error.column]
        if not dropped_letters or (
            error.code == "VP002" and dropped_letters != ["M"]
        ):  # an unknown G code takes words that are not known
            return False
        block.codes = other_codes
        return True

    @staticmethod
    def _drop_word(block: Block, error: ProgramError) -> bool:
        letter = next((letter for letter, column in block.columns.items() if column == error.column), None)
        if letter is None:
            return False
        del block.words[letter], block.columns[letter]
        return True

    def _drop_axes(self, block: Block, _error: ProgramError) -> bool:
        setup = self.interpreter.setup
        for letter in set(block.words) & set(AXES) - set(setup.axes):
            del block.words[letter], block.columns[letter]
            if letter in "ABC":
                self._lost_turns |= {axis for axis in setup.rotary if AXES[axis] not in block.words}
        return True

    def _assume_motion(self, block: Block, _error: ProgramError) -> bool:
        """A rapid traverse, for axis words without a motion code."""
        table = self.interpreter.table
        motions = table.g_groups["motion"]
        if self.interpreter.modes.motion is not None or any(
            letter == "G" and round(10 * n) in motions for letter, n, _at in block.codes
        ):
            return False
        self.interpreter.modes.motion = 0
        return True

    def _assume_feed(self, block: Block, _error: ProgramError) -> bool:
        state = self.interpreter.state
        block.words["F"] = 1.0
        self.interpreter.core.set_feed(1.0)
        assume_turning_spindle(state)
        return True

    def _assume_tool(self, block: Block, error: ProgramError) -> bool:
        state = self.interpreter.state
        if not state.has_tool_length and not {"H", "T", "D"} & set(block.words):
            assume_length(state)
            return True
        # a T beside G43 H selects the next tool: what it lacks is said where it is loaded
        letters = "THDQ" if error.column in (None, block.columns.get("T")) else "HDQ"
        numbers = {round(block.words[letter]) for letter in letters if letter in block.words}
        numbers.add(state.loaded_tool or 0)
        known_tools = state.tools or {}
        if missing := {
            n for n in numbers if n not in known_tools or known_tools[n].diameter <= 0 or known_tools[n].unmeasured
        }:
            assume_tools(state, missing)
        elif state.loaded_tool:
            return False
        assume_loaded_tool(state, state.loaded_tool or 1)
        return True

    def _assume_home(self, _block: Block, _error: ProgramError) -> bool:
        state = self.interpreter.state
        if state.home == state.home2 == ZERO9:
            return False
        assume_homes(state)
        return True

    # --- the block is given up ----------------------------------------------------------------------

    def _give_up(self, block: Block) -> None:
        """Take the modes and the end point of a block that cannot be executed."""
        interpreter, state = self.interpreter, self.interpreter.state
        table = interpreter.table
        codes = [
            (letter, round(number * 10) if letter == "G" else round(number), column)
            for letter, number, column in block.codes
        ]
        modes = Block(block.line)
        modes.codes = [
            word
            for word, (letter, code, _column) in zip(block.codes, codes, strict=True)
            if (table.group_of_g if letter == "G" else table.group_of_m).get(code, _NO_MODES[0]) not in _NO_MODES
        ]
        drop_compensation(state)
        used_letters = "FST" + "".join(
            table.words_of_g.get(code, "") for letter, code, _column in codes if letter == "G"
        )
        modes.words = {
            letter: value for letter, value in block.words.items() if letter in used_letters and letter in "FSTH"
        }
        modes.columns = dict.fromkeys(modes.words, 1)
        with suppress(ProgramError):  # it has been reported what is wrong with the block
            Rs274.execute(interpreter, modes)
        g = {code for letter, code, _column in codes if letter == "G"}
        motion = g & set(table.g_groups["motion"])
        if motion:
            self.interpreter.modes.motion = min(motion)
        plain = not any(code not in table.group_of_g or code in (530, *TAKES_AXES) for code in g)
        is_known = plain and self.interpreter.modes.absolute and self.interpreter.modes.motion not in (None, *CYCLES)
        for letter in AXES:
            if letter in block.words and letter in interpreter.setup.axes:
                axis = AXES.index(letter)
                if is_known:
                    self._place(axis, block.words[letter])
                else:
                    self._lose(axis)

    def _place(self, axis: int, value: float) -> None:
        """Let an axis stand where its word says."""
        state = self.interpreter.state
        value *= MM_PER_INCH if self.interpreter.modes.inch and AXES[axis] in LINEAR else 1.0
        place_axis(state, axis, value)

    def lose_plane(self) -> None:
        """Where the axes of the plane stand is not known until they are named again."""
        for axis in PLANES[self.interpreter.state.plane][:2]:
            self._lose(axis)

    def is_plane_lost(self) -> bool:
        """Whether an axis of the plane has not been named again."""
        state = self.interpreter.state
        return not all(state.known_axes[axis] for axis in PLANES[state.plane][:2])

    def _lose(self, axis: int) -> None:
        lose_axis(self.interpreter.state, axis)
        self.uncertain.add(axis)
