"""A sketch of one more language on the machining core: Heidenhain's DIN/ISO, as far as a facing program needs it.

``test_new_language.py`` runs it beside the same program in Klartext. It is no dialect of the command line.
"""

import re

from verne_post.gcode.arcs import build_arc_from_center
from verne_post.gcode.calls import CallStack
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.execution import Execution, run_program
from verne_post.gcode.initial_state import make_initial_state
from verne_post.gcode.machining.compensation import Compensation
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.text import Language, ProgramText, decode_line
from verne_post.model.moves import AXES, MoveKind

_WORD = re.compile(r"[ \t]*([A-Z])[ \t]*([+-]?[0-9]*\.?[0-9]+)")
_HEADER = re.compile(r"[ \t]*(?:N[0-9]+[ \t]*)?%[ \t]*\w+[ \t]*G7([01])")
_RADIUS = {40: 0.0, 41: 1.0, 42: -1.0}


class Text(Language):
    """Lines of the control are not read ahead as plain words."""

    percent = rb"(?!)"
    o_letters = b"\x00"


class Interpreter:
    """What the words of a block do."""

    def __init__(self, setup, state, recorder):
        self.core = Machining(setup, state, recorder)
        self.motion, self.absolute, self.pole, self.has_ended = 0, True, {}, False

    def execute(self, text, line):
        """One block."""
        header = _HEADER.match(text)
        if header is not None or not text.strip():
            self.has_ended = header is not None and line > 1
            return
        at, words = self.read(text, line)
        for letter, number in words:
            handler = getattr(self, f"take_{letter.lower()}", None)
            if handler is not None:
                handler(at, number)
        places = {AXES.index(letter): number for letter, number in words if letter in AXES[:6]}
        centre = {letter: number for letter, number in words if letter in "IJ"}
        self.pole.update(centre)
        if places:
            self.move(at, places)
        for letter, number in words:
            if letter == "M":
                self.switch(at, int(number))

    def read(self, text, line):
        """Letters and numbers of a block, and where they stand."""
        at, words, end = At(line), [], 0
        while (match := _WORD.match(text, end)) is not None:
            at.columns[match[1]] = match.start(1) + 1
            words.append((match[1], float(match[2])))
            end = match.end()
        if (rest := text[end:].strip()) not in ("", "*"):
            raise ProgramError("VP001", f"unexpected {rest[0]!r}", text.index(rest, end) + 1)
        return at, words

    def take_g(self, at, number):
        """Modes."""
        code = int(number)
        if code in (0, 1, 2, 3):
            self.motion = code
        elif code in (90, 91):
            self.absolute = code == 90
        elif code in (41, 42):
            radius = 0.5 * self.core.tools.find_diameter(at, self.core.state.loaded_tool or 0, "")
            self.core.start_compensation(
                Compensation(10 * code, 0, _RADIUS[code] * radius, perpendicular=True, start_line=at.line)
            )
        elif code == 40:
            self.core.end_compensation()
        elif code not in (17, 30, 31):
            raise at.error("VP002", f"G{code} is not executed", "G")

    def take_f(self, at, number):
        """Feed rate, mm/min."""
        self.core.set_feed(number)

    def take_s(self, at, number):
        """Spindle speed."""
        self.core.auxiliary.set_speed(at, number, is_switched=False)

    def take_t(self, at, number):
        """The tool comes at once, with its length."""
        tools = self.core.tools
        tools.select(at, int(number))
        tools.change(at)
        tools.set_length(lambda: tools.find_offset(at, int(number)))

    def switch(self, at, code):
        """M functions."""
        if code in (3, 4, 5):
            self.core.auxiliary.switch_spindle(at, on=code != 5, backwards=code == 4)
        elif code in (2, 30):
            self.core.auxiliary.end(at, f"M{code}")
            self.has_ended = True

    def move(self, at, places):
        """A line, or an arc about the pole of I and J."""
        start = list(self.core.state.position)
        end = [places.get(axis, value if self.absolute else 0.0) for axis, value in enumerate(start)]
        if not self.absolute:
            end = [a + b if axis in places else a for axis, (a, b) in enumerate(zip(start, end, strict=True))]
        if self.motion > 0 and self.core.find_lacking() is not None:
            raise at.error("VP009", "a line or an arc with feed rate zero; give F", "G")
        kind = MoveKind.FEED if self.motion else MoveKind.RAPID
        self.core.start_of_motion(kind, absolute=self.absolute, machine=False, axes=tuple(places))
        if self.motion < 2:
            self.core.go_straight(at, kind, end, list(places), absolute=self.absolute)
        else:
            arc = build_arc_from_center(start, end, 0, self.motion == 2, self.pole, True, 0)
            self.core.go_on_arc(at, start, end, arc, list(places), absolute=self.absolute)


class Run:
    """A program in execution, line by line; there are no calls."""

    def __init__(self, text, interpreter):
        self.interpreter, self.calls = interpreter, CallStack(text, 1, None)

    has_ended = property(lambda self: self.interpreter.has_ended)
    may_restart = staticmethod(lambda: True)

    def find_chunk(self):
        """The chunk of the next line."""
        return self.calls.text.find_chunk(self.calls.line)

    def execute(self, chunk, stop):
        """One line."""
        line = self.calls.line
        self.calls.line += 1
        self.interpreter.execute(decode_line(chunk.read_raw(line - chunk.first_line)), line)
        return line + 1, []

    def end_text(self, execution):
        """The text ends without its last line."""
        execution.report_at_line("VP010", "the file ends without its last line, %NAME", self.calls.line - 1)
        return False


def execute(source, setup, state, stop):
    """Execute a program."""
    execution = Execution(state, Recorder())
    run = Run(ProgramText(source, setup, Text), Interpreter(setup, state, execution.recorder))
    return run_program(run, execution, setup, stop)


def names_axis(source, letter, setup):
    """True where the letter stands in the text."""
    return letter.encode() in source


DIALECT = Dialect(
    lambda source: _HEADER.match(decode_line(source)) is not None, make_initial_state, execute, names_axis, (".i",)
)
