"""One block with its variables, words, cycles and modal call: what the flow of a program executes."""

import re
from contextlib import suppress
from dataclasses import replace as replace_fields
from typing import Final

from msgspec.structs import replace

from verne_post.gcode.arcs import PLANES
from verne_post.gcode.machining.assumptions import (
    UNREAD_TOOL,
    add_length,
    assume_feed,
    assume_length,
    assume_rigid_tapping,
    assume_tool_call,
    assume_turning_spindle,
    drop_compensation,
    forget_change_of_length,
    know_axis,
)
from verne_post.gcode.machining.state import State
from verne_post.gcode.machining.watcher import name_new_plane
from verne_post.gcode.mistyped import UNREADABLE
from verne_post.gcode.program_error import At, ProgramError, write_before
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.siemens.blank import set_blank
from verne_post.gcode.siemens.cursor import Cursor
from verne_post.gcode.siemens.drilling import PARAMETERS as DRILLING
from verne_post.gcode.siemens.drilling import Drilling
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.siemens.milling import MODAL_MILLING, SiemensMilling
from verne_post.gcode.siemens.milling_values import PARAMETERS as MILLING
from verne_post.gcode.siemens.modes import Modes
from verne_post.gcode.siemens.patterns import PARAMETERS as PATTERNS
from verne_post.gcode.siemens.patterns import list_pattern_places
from verne_post.gcode.siemens.swivel import Swivel
from verne_post.gcode.siemens.system_variables import SystemVariables
from verne_post.gcode.siemens.variables import Variables
from verne_post.gcode.siemens.vocabulary import CYCLES
from verne_post.gcode.siemens.words import Call, WordReader, Words
from verne_post.gcode.text import decode_line, take_code
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES, MoveKind

#: Errors of blocks that lack a tool or its length, or a feed rate.
_LACKING: Final = ("VP009", "VP012")
#: Errors that positions lead to, and what may be given by a block that was not executed.
_OF_POSITIONS: Final = ("VP008", "VP013")
#: Errors of the values of a cycle, wherever it is executed.
_OF_VALUES: Final = ("VP002", "VP005", "VP007", "VP048")
#: Words that name a place.
_PLACES: Final = frozenset({*AXES, "AP", "RP", "I", "J", "K", "CR", "AR", "A3", "B3", "C3"})
#: What errors say that lack the transformation.
_WITHOUT_TCP: Final = "without TRAORI"
#: The motion of a block that cannot be read, also where the G before its number is what is missing.
_MOTION: Final = re.compile(r"(?:(?<![A-Z0-9_$])G|^[ \t/]*(?:N\d+[ \t]+)?)0?([0-3])(?![\d.=])")
_UNKNOWN_CODE: Final = re.compile(r"G\d+ is not a code")
_NAMED_AXIS: Final = re.compile(r"(?<![A-Z0-9_$])([XYZABCF])(?=[ \t]*[-+=.0-9])")
#: What a word of F may have become: its letter is missing, or one whose key is beside, or its number.
_LOST_FEED: Final = re.compile(r"[CDGRTV]?\d++(?:\.\d*+)?F?(?![\w.=])|F(?![\w=])|(?<=F)\(")
_LONE_M: Final = re.compile(r"(?<![A-Z0-9_$])M(?:0?6|[567]6|6[57])?(?=[ \t]|$)")
_TOOL: Final = re.compile(r"(?<![A-Z0-9_$])T1?[ \t]*[=\"]")
_SET_R: Final = re.compile(r"(?<![\w$])R(\d{1,5})[ \t]*=(?!=)")
_SET_VALUE: Final = re.compile(r"[ \t]*+(?:N\d++[ \t]*+)?(?:R\d|\w++[ \t]*+=)")
#: What ends the cycle of MCALL.
_END_MODAL: Final = "write MCALL alone"


def _name_modal(call: Call) -> str:
    return f"MCALL of line {call.line} still calls {call.name}"


class Executor:
    """Reads and executes blocks on one interpreter."""

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.setup = setup
        self.interpreter = SiemensInterpreter(setup, state, recorder)
        self.variables = Variables(SystemVariables(self.interpreter))
        state.show_variables(self.variables)
        self.words = WordReader(self.variables, lambda name: False, setup.remap)
        self.drilling = Drilling(self.interpreter, self.variables)
        self.milling = SiemensMilling(self.interpreter, self.variables)
        self.swivel = Swivel(self.interpreter, self.variables)
        self._modal: Call | None = None
        #: Line, name and place of each cycle called without MCALL since the last one.
        self.lone_calls: list[tuple[int, str, list[float]]] = []
        self._pattern_line = 0  #: At whose places the cycle of MCALL was called last.
        self._beside_pattern = 0  #: The first line after that with one more place.
        self.modal_is_shown = True  #: That line has its columns: it is no call of a file in which MCALL stands.
        #: A line that was not executed has named axes.
        self.uncertain = False
        #: The program has used a name that has no meaning here.
        self.has_unknown_name = False
        #: A line that cannot be read may have set an R parameter: a feed rate of zero may only follow from it.
        self.has_unread_value = False
        #: A T that cannot be read: the spindle may only be empty because of it.
        self.has_unread_tool = False
        #: A CYCLE800 that was not executed: the plane in force is the one before it.
        self.has_unread_plane = False
        #: Where A, B and C stood at the last line of them that was not executed.
        self.angles_of_failed: tuple[float, ...] = ()
        self.interpreter.set_path_control()
        self.run(self.read(Cursor(self.interpreter.keys.start), 1))
        recorder.system_lines.clear()  # the words with which the control begins are in no line of the program

    @property
    def has_ended(self) -> bool:
        """True after M2 or M30."""
        return self.interpreter.has_ended

    @property
    def can_restart(self) -> bool:
        """True where nothing of earlier blocks is still to come: a modal cycle, a spline, the corner of a contour."""
        to = self.interpreter
        return self.modal is None and to.splines.draft is None and to.motion.corners.is_idle

    @property
    def modes(self) -> Modes:
        """What holds from block to block."""
        return self.interpreter.modes

    @property
    def move_count(self) -> int:
        """Moves recorded so far."""
        return self.interpreter.recorder.count

    def record_event(self, line: int, kind: str, **data: object) -> None:
        """Record something that is no motion."""
        self.interpreter.recorder.record_event(line, kind, **data)

    def read(self, cursor: Cursor, line: int) -> Words:
        """Read the words of a block."""
        self.words.motion = self.modes.motion
        return self.words.read(cursor, line)

    def run(self, words: Words) -> bool:
        """Execute a block without its calls, then MCALL's cycle if it moved; True if its subprogram is to be called.

        Raises
        ------
        ProgramError
            A block that lacks nothing but a tool or F has moved the axes all the same: nothing else is reported for it.
        """
        if words.calls:
            words.used_words.add("P")
        self._warn_of_modal(words, is_motion=False)
        try:
            has_moved = self.interpreter.run(words)
        except ProgramError as error:
            if error.code in _LACKING:
                self._go_on(words, error.code)
            raise
        if not has_moved or self.modal is None:
            return False
        if not self.is_modal(self.modal.name):
            return True
        self._warn_of_modal(words, is_motion=True)
        self._beside_pattern = self._beside_pattern or (words.line if self._pattern_line else 0)
        self.milling.begin_block()
        self._run_modal(self.modal, words.line)
        return False

    def _warn_of_modal(self, words: Words, *, is_motion: bool) -> None:
        """VP043, once for each MCALL: a change of tools, the end of the program, or a retract finds its cycle on."""
        call = self.modal
        if call is None or not self.is_modal(call.name):
            return
        normal = AXES[PLANES[self.interpreter.state.plane][2]]
        numbers = [number for number, _column in words.m if number in (2, 6, 30)]
        if is_motion and words.words.keys() & _PLACES == {normal}:
            where = f"{normal} alone, which is one more place"
        elif not is_motion and numbers:
            where = f"M{numbers[0]}"
        else:
            return
        end, edits = self._propose_end(words.line)
        self.interpreter.core.watcher.report(_name_modal(call), f"at {where}", end, words.line, edits)

    def _propose_end(self, line: int) -> tuple[str, tuple[Remedy, ...]]:
        """What ends MCALL before a line; a choice where lines behind a pattern have drilled before that too."""
        edits, end, after = write_before("MCALL", line=line), f"{_END_MODAL} before", self._pattern_line + 1
        if line > self._beside_pattern >= after > 1:  # which of the places are meant is not known
            edits = tuple(replace_fields(one, is_choice=True) for one in (*write_before("MCALL", line=after), *edits))
            end += f", or before line {after} if line {self._beside_pattern} is no place of it"
        return end, edits

    def _run_modal(self, call: Call, line: int, holes: int = 1) -> None:
        """Execute the cycle of MCALL; what is wrong with its values stands in the line of MCALL."""
        to = self.interpreter
        watcher, recorder = to.core.watcher, to.recorder
        is_first = watcher.last_hole is None  # then MCALL is not forgotten: what is wrong with this hole is the cause
        if (plane := watcher.find_new_plane(to.state)) is not None:
            end, edits = self._propose_end(plane.line)
            watcher.report(_name_modal(call), name_new_plane(plane), end, plane.line, edits, at_plane=True)
        is_said = recorder.is_tcp_said
        # in what directions a hole that is not meant would be cut is no question of its own (VP037)
        recorder.say_tcp(is_said or _name_modal(call) in watcher.told_lines)
        try:
            if call.name in MODAL_MILLING:
                self.milling.run(call, line, is_modal=True)
            else:
                self.drilling.run(call, line, holes)
        except ProgramError as error:
            if error.code in _OF_VALUES or error.line == call.line:
                error.line, error.of_program, error.of_value = call.line, True, True
            if not (error.of_value and self.modal_is_shown):
                error.column = None
            # the cycle does not belong here: it was to end before, and is taken as ended; not where the plane is wrong
            if error.code == "VP017" and not (error.cause or error.of_value):
                if not is_first:
                    otherwise = "before this motion if it is no place of it"
                    watcher.explain(error, _name_modal(call), _END_MODAL, line, otherwise)
                self.modal = None
            raise
        finally:
            recorder.say_tcp(is_said)

    @property
    def modal(self) -> Call | None:
        """The cycle of MCALL."""
        return self._modal

    @modal.setter
    def modal(self, call: Call | None) -> None:
        self._modal = call
        self._pattern_line = self._beside_pattern = 0
        self.interpreter.core.watcher.last_hole = None
        self.interpreter.modes.cycle = "" if call is None else call.name

    def end_modal(self, line: int) -> None:
        """MCALL alone; VP023 where it ends nothing, and a cycle was called once before moves to other places."""
        if self.modal is None and len(self.lone_calls) == 1:
            begin, name, place = self.lone_calls[0]
            if place != self.interpreter.state.position[:2]:
                text = (
                    f"MCALL ends nothing: {name} of line {begin} is called at one place alone; write MCALL {name}(...) "
                )
                text += f"there to call it at the places up to line {line} too"
                self.interpreter.recorder.warn("VP023", text, line, None, "warning")
        self.modal = None
        self.lone_calls.clear()

    def _go_on(self, words: Words, code: str) -> None:
        """Execute a block again as if a length, a feed rate and a turning spindle were given: its end point counts."""
        state = self.interpreter.state
        assume_feed(state)
        assume_turning_spindle(state)
        with add_length(state, then=code == "VP012"), suppress(ProgramError):
            self.interpreter.run(words)

    def warn_of_unset(self, number: int, line: int) -> None:
        """VP025, as a warning: an R parameter has the value that a control has kept."""
        if self.setup.machine and not self.has_unread_value:
            text = self.variables.explain_unset(number)
            self.interpreter.recorder.note_once("VP025", text, line, severity="warning")

    def pass_failed(self, raw: bytes, error: ProgramError) -> bool:
        """Take axes and F of a failed line as given; True where the error only follows from an earlier such line.

        Positions after it are not what the program means: errors of arcs and incremental values are reported no more.
        """
        follows = self.uncertain and error.code in _OF_POSITIONS
        text = take_code(decode_line(raw)).upper()
        state, named_letters = self.interpreter.state, set(_NAMED_AXIS.findall(text))
        for letter in named_letters - {"F"}:
            know_axis(state, AXES.index(letter))
        # a letter may be what is missing, or another one
        self.uncertain |= bool(named_letters - {"F"}) or error.code in ("VP001", "VP011")
        if named_letters & set("XYZ"):  # the motion after a change of the length, which VP016 asks for
            forget_change_of_length(state)
        follows |= self.has_unread_value and error.code == "VP009"
        follows |= self.has_unread_tool and error.code == "VP012" and "no tool is in the spindle" in error.message
        follows |= state.loaded_tool == UNREAD_TOOL and error.settled_by[2:] == ("diameter",)
        self.has_unread_tool |= error.code == "VP001" and _TOOL.search(text) is not None
        if error.code == "VP012" and not state.selected_tool:
            assume_tool_call(state)
            assume_length(state)
        follows |= self.has_unread_plane and error.code == "VP017" and "CYCLE800" in error.message
        self.has_unread_plane |= "CYCLE800" in text
        # where it would have turned the rotary axes, a tool still points as they stood
        angles = tuple(state.position[3:6])
        follows |= angles == self.angles_of_failed and "it would be dragged sideways" in error.message
        self.angles_of_failed = angles if named_letters & set("ABC") else self.angles_of_failed
        if error.code in UNREADABLE and state.selected_tool and _LONE_M.search(text):
            assume_tool_call(state)
            assume_length(state)
        self.has_unread_value |= error.code == "VP001" and _SET_VALUE.match(text) is not None
        for number in _SET_R.findall(text):
            self.variables.r.setdefault(int(number), 0.0)
        is_unread = error.code in UNREADABLE and error.column is not None
        if "F" in named_letters or (is_unread and _LOST_FEED.match(text, (error.column or 1) - 1)):
            assume_feed(state)
        if error.code == "VP001" and (motion := _MOTION.search(text)) is not None:
            self.modes.motion = f"G{motion[1]}"
        elif error.code == "VP002" and _UNKNOWN_CODE.match(error.message):  # it may be what ends an arc
            self.modes.motion = "G1"
        if error.code == "VP048":
            assume_rigid_tapping(state)
        if error.code in ("VP017", "VP026"):  # G40 may be missing before it: what follows would only say so again
            drop_compensation(state)
        # a name without a meaning may be what switches TRAORI on at this machine
        follows = follows or (self.has_unknown_name and error.code == "VP017" and _WITHOUT_TCP in error.message)
        self.has_unknown_name = self.has_unknown_name or error.goes_on or error.settled_by[:1] == ("remap",)
        return follows

    def finish(self) -> None:
        """At the end of the program: what waits for its end."""
        self.interpreter.motion.corners.finish()
        self.interpreter.splines.end_spline()

    def restore(self, modes: Modes) -> None:
        """Bring back what SAVE has kept."""
        self.interpreter.core.refuse_compensation("the end of a subprogram with SAVE")
        self.interpreter.state.modes = modes
        self.modal = self._modal  # which SAVE does not keep
        core = self.interpreter.core
        core.set_plane(modes.plane)
        core.set_arc_feed(modes.arc_feed)
        core.set_feed_mode(modes.feed_mode)  # as after G93, G94 and G95: F is to be given again
        self.interpreter.motion.set_chain()
        self.interpreter.set_path_control()

    # --- cycles ---------------------------------------------------------------------------------------------

    def fork(self, feed: float, *, knows_place: bool = False) -> "Executor":
        """An executor with its own state and recorder, in which the same holds except for the feed rate.

        R parameters are the same ones. The position of X and Y is not known in it, unless it ``knows_place``.
        """
        state = self.interpreter.state
        own = replace(
            state,
            position=list(state.position),
            known_axes=list(state.known_axes) if knows_place else [axis > 1 for axis in range(len(AXES))],
            named_axes=list(state.named_axes),
            systems=dict(state.systems),
            first_places=None,
        )
        fork = Executor(self.setup, own, Recorder())
        fork.restore(self.modes.copy())
        fork.interpreter.core.stand(list(state.position))
        fork.interpreter.core.set_feed(feed)
        fork.variables.r = self.variables.r
        return fork

    @staticmethod
    def is_modal(name: str) -> bool:
        """True for the cycles that MCALL may call."""
        return name in DRILLING or name in MODAL_MILLING

    @staticmethod
    def is_cycle(name: str) -> bool:
        """True for cycles of the control that are executed."""
        return name in CYCLES

    def run_cycle(self, call: Call, line: int) -> None:
        """Execute a cycle of the control."""
        self.interpreter.motion.corners.finish()
        self.interpreter.motion.note_numbers()
        self.milling.begin_block()
        if call.name == "CYCLE800":
            self.swivel.run(call, line)
        elif call.name == "CYCLE832":
            self.swivel.set_tolerance(call, line)
        elif call.name == "WORKPIECE":
            set_blank(self.interpreter, call, self.variables, line)
        elif call.name in PATTERNS:
            self._run_pattern(call, line)
        else:
            self.interpreter.motion.check_length_axis(At(line))
            (self.milling if call.name in MILLING else self.drilling).run(call, line)
        if self.is_modal(call.name):
            self.lone_calls.append((line, call.name, self.interpreter.state.position[:2]))

    def _run_pattern(self, call: Call, line: int) -> None:
        """Go to every place of a pattern, and execute the cycle of MCALL there."""
        to, block = self.interpreter, At(line)
        first, second, *_ = PLANES[to.state.plane]
        if self.modal is not None and not self.is_modal(self.modal.name):
            raise ProgramError(
                "VP002", f"{call.name} with MCALL {self.modal.name}: patterns call only cycles", call.column
            )
        is_placed = to.state.is_known(first) and to.state.is_known(second)
        here = (to.motion.find_programmed(first), to.motion.find_programmed(second)) if is_placed else None
        self._pattern_line, self._beside_pattern = line if self.modal else 0, 0
        places = list(list_pattern_places(call, self.variables, self.modes.length, to.state.plane, here))
        for u, v in places:
            to.motion.run_line(block, MoveKind.RAPID, {first: u, second: v})
            if self.modal is not None:
                self._run_modal(self.modal, line, len(places))
