"""The loop that a program repeats without end, in any language: its lines, and what its condition asks."""

import re
from typing import Any, Final

from msgspec import Struct, field

from verne_post.base.program_lines import remove_remarks
from verne_post.gcode.calls import CallStack
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.repeats import REPEAT_UNIT
from verne_post.gcode.text import ChunkedText, decode_line

_BEYOND: Final = "beyond any machine"
#: A condition; what it asks is in the group.
_TESTS: Final = {"heidenhain": re.compile(r"\bFN[ \t]*(?:9|10|11|12)[ \t]*:(.*?)(?=\bGOTO\b|$)", re.IGNORECASE)}
_TEST: Final = re.compile(r"\b(?:WHILE|UNTIL|IF)\b(.*?)(?=GOTO|$)", re.IGNORECASE)
_VARIABLES: Final = {
    "siemens": re.compile(
        r"(?<![\w$])(?!(?:AND|OR|XOR|NOT|DIV|MOD|TRUE|FALSE)\b)[A-Z_]\w*(?!\w|[ \t]*\()", re.IGNORECASE
    ),
    "heidenhain": re.compile(r"\bQ[LRS]?\d+\b", re.IGNORECASE),
}
_PARAMETER: Final = re.compile(r"#(?:<[^<>]*>|\d+)")
#: A value of the control, which changes without a line that sets it.
_OF_CONTROL: Final = re.compile(r"\$")


class Loop(Struct):
    """The loop whose end went back last; without lines before any has."""

    text: ChunkedText | None = None
    begin: int = 0
    end: int = 0
    has_calls: bool = False  #: Whether it calls subprograms, which may set what its condition asks.
    calls_now: bool = False  #: Whether a call has begun or ended since the end went back last.
    #: File and line -> the first error of a value beyond any machine.
    values: dict[tuple[str | None, int], str] = field(default_factory=dict)
    growth_error: ProgramError | None = None  #: Of a value that grows in the loop until it is beyond any machine.

    def note(self, calls: CallStack[Any, Any], line: int) -> None:
        """A line has been executed, and the program goes on at one before it, in the same call."""
        self.text, self.begin, self.end = calls.text, calls.line, line
        self.has_calls, self.calls_now = self.calls_now, False

    def describe(self, language: str) -> str:
        """Its lines, and what its condition asks and no line of it sets."""
        assert self.text is not None
        lines = []
        for line in range(self.begin, self.end + 1):
            chunk = self.text.find_chunk(line)
            raw = b"" if chunk is None else chunk.read_raw(line - chunk.first_line)
            lines.append(remove_remarks(decode_line(raw), language))
        found = (_TESTS.get(language, _TEST).search(line) for line in (lines[0], lines[-1]))
        test = next((one[1] for one in found if one is not None), "")
        names = [] if _OF_CONTROL.search(test) else _VARIABLES.get(language, _PARAMETER).findall(test)
        names = list(dict.fromkeys(name if language else "".join(name.lower().split()) for name in names))
        lines = lines if language else ["".join(line.split()) for line in lines]
        is_set = any(
            re.search(rf"(?<![A-Z_$]){re.escape(name)}[ \t]*(?:\[[^=]*\][ \t]*)?=(?!=)", line, re.IGNORECASE)
            for name in names
            for line in lines
        )
        is_told = bool(names) and not is_set and not self.has_calls
        condition_hint = f", and no line of it sets {' or '.join(names)}, which its condition asks" if is_told else ""
        return f"the loop of lines {self.begin} to {self.end}{condition_hint}"

    def name(self, error: ProgramError, text: ChunkedText, line: int, language: str) -> ProgramError | None:
        """The error of a line, with the loop in which it comes from repeating; None where the line has told it."""
        if error.code == "VP007" and _BEYOND in error.message:
            before = self.values.get((text.name, line), "")
            self.values[text.name, line] = before or error.message
            if text is not self.text or not self.begin <= line <= self.end:
                return error
            if before:  # each time round gives another value, or the same one
                return error if error.message == before and self.growth_error is None else None
            error.message += f", in {self.describe(language)}"
            error.line, self.growth_error = line, error
        elif error.code == "VP024" and REPEAT_UNIT in error.message and text is self.text:
            growth = self.growth_error
            if growth is not None and self.begin <= (growth.line or 0) <= self.end:
                return growth  # an error of the same words ends the execution, and is one finding
            error.message = error.message.replace(REPEAT_UNIT, f"{REPEAT_UNIT}, the last in {self.describe(language)}")
            error.line, error.column = self.begin, None
        return error
