"""The loop that a program repeats without end, in any language: its lines, and what its condition asks."""

import re
from typing import Any, Final

from msgspec import Struct

from verne_post.base.program_lines import remove_remarks
from verne_post.gcode.calls import CallStack
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.repeats import REPEAT_UNIT
from verne_post.gcode.text import ChunkedText, decode_line

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
    growth_error: ProgramError | None = None  #: Of a value that grows in it, beyond any machine.

    def note(self, calls: CallStack[Any, Any], line: int) -> None:
        """A line has been executed, and the program goes on at one before it, in the same call."""
        self.text, self.begin, self.end = calls.text, calls.line, line

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
        condition_hint = f", and no line of it sets {' or '.join(names)}, which its condition asks"
        return f"the loop of lines {self.begin} to {self.end}{condition_hint if names and not is_set else ''}"

    def name(self, error: ProgramError, line: int, language: str) -> ProgramError | None:
        """The error of a line, with the loop in which it comes from repeating; None where it is told already."""
        earlier = self.growth_error is not None and self.begin <= (self.growth_error.line or 0) <= self.end
        if error.code == "VP007" and "beyond any machine" in error.message and self.begin <= line <= self.end:
            if earlier:  # each time round gives another value
                return None
            error.message += f", in {self.describe(language)}"
            error.line, self.growth_error = line, error
        elif error.code == "VP024" and REPEAT_UNIT in error.message and self.begin:
            if earlier:
                return self.growth_error  # told twice, an error ends the execution
            error.message = error.message.replace(REPEAT_UNIT, f"{REPEAT_UNIT}, the last in {self.describe(language)}")
            error.line, error.column = self.begin, None
        return error
