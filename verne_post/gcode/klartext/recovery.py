"""After an error in a Klartext statement: the state that it would have left, so that no consequences are reported.

A refused move still sets its end point, its feed rate and its modes. Nothing of this reaches the user: a program with
an error has no moves.
"""

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

from verne_post.base.suggestions import list_near_numbers
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.klartext.paths import BUILDERS
from verne_post.gcode.klartext.program import Klartext
from verne_post.gcode.klartext.q_parameters import SETTING_REFUSED, find_set_name
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.words import Words, read_usable_words
from verne_post.gcode.machining.assumptions import (
    assume_feed,
    assume_length,
    assume_loaded_tool,
    assume_rigid_tapping,
    assume_speed,
    assume_tools,
    drop_compensation,
    name_axis,
    place,
)
from verne_post.gcode.program_error import ProgramError
from verne_post.model.moves import AXES

#: Statements that are about elements of a contour, of which one may have waited.
_CONTOUR: Final = (*BUILDERS, "RND", "CHF", "APPR", "DEP")
#: Of these the end may be computed; of the others it is given by coordinates.
_POLAR: Final = ("LP", "CP", "CTP")
#: M functions that hold on, and those that give a block coordinates of another system.
_MODES: Final = (3, 4, 5, 8, 9, 13, 14, 116, 117, 126, 127, 128, 129, 136, 137)
_ELSEWHERE: Final = (91, 92, 130)
#: A coordinate whose letter is missing.
_LETTERLESS: Final = re.compile(r"(?<!\S)[-+]\d")
#: What names a tool and its axis.
_TOOL: Final = re.compile(r"(?<!\w)(?:TOOL|CALL)[ \t]+.*?(\d{1,5})[ \t]*Z(?!\w)", re.IGNORECASE)
#: What gives a parameter a value, and what may switch on tool-centre-point control.
_SETS: Final = re.compile(r"(?<!\w)(Q[LR]?\d{1,4})[ \t]*=", re.IGNORECASE)
_TCP: Final = re.compile(r"(?<!\w)(?:TC[PM]{2}|[NJK]128)(?!\w)", re.IGNORECASE)
#: A feed rate that holds on.
_FEED: Final = re.compile(r"(?<!\w)F[UZ]?[ \t]*(?:[\d.,]|Q|AUTO)", re.IGNORECASE)
#: A spindle speed.
_SPEED: Final = re.compile(r"(?<!\w)S[ \t]*[\d.,Q]", re.IGNORECASE)
#: Errors that positions lead to, and poles.
_OF_POSITIONS: Final = ("VP008", "VP013")


class KlartextRecovery:
    """Goes on after refused statements of one program.

    ``uncertain``: a refused statement has left the tool at a place that is not known. ``has_no_side``: RL or RR of one
    does not hold. ``lacks_call``: a tool was needed, and no TOOL CALL had come.
    """

    def __init__(self, interpreter: Klartext) -> None:
        self.to, self.uncertain, self.has_no_side, self.lacks_call = interpreter, False, False, False

    def pass_failed(self, statement: Statement, error: ProgramError) -> bool:
        """Take what a refused statement would have set; True where its error only follows from one before."""
        to, keyword = self.to, statement.keyword
        follows = self.uncertain and error.code in _OF_POSITIONS
        follows = follows or error.message.endswith(SETTING_REFUSED) or (self.lacks_call and error.about == "TOOL CALL")
        self.lacks_call |= error.about == "TOOL CALL"
        follows = follows or (self.has_no_side and keyword == "DEP" and error.code == "VP017")
        is_late_end = error.code in ("VP017", "VP026") and re.search(r"(?<!\w)R0(?!\w)", statement.rest) is not None
        self.has_no_side = is_late_end or keyword == "APPR" or (self.has_no_side and keyword != "DEP")
        to.has_failed = True
        if error.code == "VP025" and (unset := re.match(r"(Q[LR]?\d+) has no value", error.message)):
            to.q.refuse(unset[1])
        if _FEED.search(statement.rest):
            assume_feed(to.state)
        if error.code == "VP048":
            assume_rigid_tapping(to.state)
        if error.code in ("VP017", "VP026"):  # R0, or a move after it, may be missing before it
            drop_compensation(to.state)
            to.contour.side = None
        if keyword == "DEP":  # it would have ended the compensation
            drop_compensation(to.state)
            to.contour.side = None
        if keyword in _CONTOUR:
            place(to.state, list(to.paths.find_position()))
            to.waiting.forget()
        if error.code == "VP012" and not to.state.loaded_tool:  # TOOL CALL is missing
            self._assume_tool(to.state.selected_tool)
            to.contour.call_feed = to.contour.call_feed or 1.0
        if keyword in BUILDERS or keyword in ("APPR", "CYCL CALL"):
            self._take_move(statement, error)
        elif keyword == "CC":
            self._take_pole(statement)
        elif keyword == "PLANE":
            for number in range(3):
                to.q.control_values.setdefault(120 + number, to.state.position[3 + number])
        elif keyword == "FUNCTION" and re.search("TC[PM]", statement.rest):
            with suppress(ProgramError):
                to.functions.set_tcp(on="RESET" not in statement.rest)
        elif error.code == "VP002" and (function := re.match(r"M(\d+): ", error.message)) is not None:
            if list_near_numbers(function[1], ["128"]):
                self._assume_tcp()
        elif keyword in ("Q", "QL", "QR", "FN") and not statement.further_lines and (name := find_set_name(statement)):
            to.q.refuse(name)
        elif keyword in ("CALL LBL", "LBL", "FN"):
            to.q.is_jump_refused = True
        elif keyword == "CYCL DEF" or (keyword == "Q" and statement.further_lines):
            to.patterns.cycle_unread = True
        elif keyword == "TOOL DEF":
            with suppress(ProgramError):
                missing_number = to.functions.read_tool(statement)[0]
                if missing_number is not None and missing_number not in (to.state.tools or {}):
                    assume_tools(to.state, [missing_number])
        elif keyword == "TOOL CALL":
            tool: int | None = to.state.selected_tool
            with suppress(ProgramError):  # its number may be right where the tool axis is not
                tool = to.functions.read_tool(statement)[0] or tool
            if (joined_number := re.match(r"[ \t]*(\d{1,5})[A-Z]", statement.rest)) is not None:
                tool = int(joined_number[1])
            self._assume_tool(tool)
            to.functions.hide_tool()
            if "F" in read_usable_words(statement, to.q).values:
                to.contour.call_feed = to.contour.call_feed or 1.0  # any feed rate will do
            if _SPEED.search(statement.rest):
                assume_speed(to.state)
        return follows

    def pass_unread(self, parts: Sequence[str]) -> None:
        """A statement without a known first word: a misspelt L may be what names the axes, and gives the feed rate."""
        self.uncertain = True
        if any(map(_FEED.search, parts)):
            assume_feed(self.to.state)
        if (tool := _TOOL.search(parts[0])) is not None:
            self._assume_tool(int(tool[1]))
        if (setting := _SETS.search(parts[0])) is not None:
            self.to.q.refuse(setting[1].upper())
        if _TCP.search(parts[0]) is not None:
            self._assume_tcp()

    def _assume_tcp(self) -> None:
        """A statement that may be M128 is not read: paths are those of the tip, and nothing says in which line."""
        modes = self.to.modes
        if not modes.tcp:
            modes.tcp, modes.tcp_line = True, 0
            self.to.frames.refresh_frame()

    def _assume_tool(self, number: int | None) -> None:
        state = self.to.state
        assume_length(state)
        if self.to.setup.tool_length is None:
            assume_loaded_tool(state, number)

    def _take_move(self, statement: Statement, error: ProgramError) -> None:
        """The modes, the feed rate and the end point of a statement that moves."""
        to, state = self.to, self.to.state
        words = read_usable_words(statement, to.q)
        elsewhere = any(word.number in _ELSEWHERE for word in words.functions)
        words.functions = [word for word in words.functions if word.number in _MODES]
        with suppress(ProgramError):
            to.functions.begin_functions(words)
        self._take_feed(statement, words, error)
        axes = [axis for axis, letter in enumerate(AXES) if {letter, "I" + letter} & set(words.values)]
        is_lost = error.code == "VP001" and _LETTERLESS.search(statement.rest) is not None
        self.uncertain |= (
            elsewhere or is_lost or any(not state.known_axes[axis] and AXES[axis] not in words.values for axis in axes)
        )
        for axis in axes:
            if AXES[axis] not in to.setup.axes:
                words.values.pop(AXES[axis], None)
                words.values.pop("I" + AXES[axis], None)
            name_axis(state, axis)
        if not elsewhere:
            self._go_to_end(statement, words)
        with suppress(ProgramError):
            to.functions.end_functions(words)

    def _take_feed(self, statement: Statement, words: Words, error: ProgramError) -> None:
        state = self.to.state
        given = error.code == "VP009" or bool({"F", "FU", "FZ"} & set(words.values))
        given = given or (error.code == "VP025" and re.search(r"(?<!\w)F[UZ]?[ \t]*Q", statement.rest) is not None)
        words.values.pop("FZ", None)
        with suppress(ProgramError):
            self.to.contour.set_feed(statement, words)
        if given:
            assume_feed(state)

    def _go_to_end(self, statement: Statement, words: Words) -> None:
        to, state = self.to, self.to.state
        start = list(state.position)
        try:
            target = to.paths.read_target(statement, words)
            if statement.keyword in _POLAR:
                to.paths.build(statement, words, target)
        except ProgramError:
            self.uncertain = True
            return
        way = [end - begin for begin, end in zip(start[:2], target.end[:2], strict=True)]
        if (size := math.hypot(*way)) > ZERO_LENGTH_MM:
            to.paths.direction = way[0] / size, way[1] / size
        if target.turns and not to.modes.tcp:  # X, Y, Z of the machine keep their numbers
            self.uncertain |= to.maps.tilt is not None
            place(state, [*start[:3], *target.end[3:]])
            to.frames.refresh_frame()
        place(state, list(target.end))

    def _take_pole(self, statement: Statement) -> None:
        """The coordinates of CC that can be read; X and Y where the tool is, for those that cannot."""
        to = self.to
        words = read_usable_words(statement, to.q)
        here = to.paths.map_to_input(to.paths.find_position())
        given = {axis: words.values[letter] for axis, letter in enumerate("XYZ") if letter in words.values}
        self.uncertain |= len(given) != 2
        to.paths.pole = given if len(given) == 2 else {0: here[0], 1: here[1]}
