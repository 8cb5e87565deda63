"""Comments with a message: (MSG,..), (DEBUG,..), (PRINT,..), (LOG,..), (ABORT,..), and those that would open files."""

import re
from collections.abc import Sequence
from typing import Final

from verne_post.gcode.expressions import Values
from verne_post.gcode.program_error import ProgramError

#: They write to files or read from them: a program names no files here.
_FILES: Final = ("LOGOPEN,", "LOGAPPEND,", "LOGCLOSE", "PROBEOPEN", "PROBECLOSE")
_PARAMETER: Final = re.compile(r"#<([^<>]*)>|#([0-9]+)|%(l?f|d|\.[0-9]l?f)")
#: #5599 = 0 silences DEBUG.
_DEBUG_SWITCH: Final = 5599


def read_message(comment: str, values: Values, channels: Sequence[str]) -> tuple[str, str] | None:
    """The message of a comment: (channel, text); None for a plain comment. ``channels`` are those that the control has.

    The channel is "msg", "debug", "print", "log", "abort", or "file" for what is never executed.
    """
    upper = comment.upper()
    if "FILE" in channels and upper.startswith(_FILES):
        return "file", comment
    for name in channels:
        if upper.startswith(name + ","):
            text = comment[len(name) + 1 :]
            if name == "DEBUG" and values.read_value(_DEBUG_SWITCH) == 0:
                return None
            return name.lower(), text if name == "MSG" else _expand(text, values)
    return None


def _expand(text: str, values: Values) -> str:
    """Put in the values of #n and #<name>; %d, %f and %.2f set how those that follow are written."""
    form = "%f"

    def replace_value(match: re.Match[str]) -> str:
        nonlocal form
        name, index, new_form = match.groups()
        if new_form is not None:
            form = "%" + new_form.replace("l", "")
            return ""
        try:
            value = values.read_value(
                name.replace(" ", "").replace("\t", "").lower() if name is not None else int(index)
            )
        except ProgramError:
            return "######"
        return "%d" % round(value) if form == "%d" else form % (value + 0.0)  # noqa: UP031 - the form is the program's

    return _PARAMETER.sub(replace_value, text)
