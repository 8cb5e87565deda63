"""Calls of Fanuc: G65, G66, M97 and M99 P; and variables of the control that a program sets."""

import re
from typing import Final

from msgspec.structs import replace

from verne_post.gcode.block import Block, strip_comments
from verne_post.gcode.expressions import ValueReader, Values
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.rs274.fanuc_codes import MIRROR_OFF, OF_FRAMES, SCALE_OFF
from verne_post.gcode.rs274.fanuc_points import find_lines_without_point
from verne_post.gcode.rs274.interpreter import Call
from verne_post.gcode.rs274.macro_text import read_arguments
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.rs274.values import read_whole
from verne_post.model.control_keys import FanucKeys

#: P and L of a call, and the local variables of the macro.
Arguments = tuple[dict[str, float], dict[int, float]]
_CALL: Final = re.compile(r"(?<![A-Z])G[ \t]*0*6[ \t]*[56](?![0-9.])", re.IGNORECASE)
#: Codes whose axis words move nothing.
_STANDING: Final = (100, 520, 920, SCALE_OFF, MIRROR_OFF, *OF_FRAMES)
#: Variables that raise an alarm or stop a program; and settings of the control that are without effect here: clocks,
#: single block, overrides, mirror images of the operator.
_ALARM: Final = 3000
_ALARMS: Final = (_ALARM, 3006)
_WITHOUT_EFFECT: Final = (3001, 3002, 3003, 3004, 3011, 3012)
_OF_CONTROL: Final = frozenset((*_ALARMS, *_WITHOUT_EFFECT))
#: Of a program number on most controls; more in P of M98 may be repeats before it.
_DIGITS: Final = 4


def read_macro_call(text: str, values: Values, keys: FanucKeys) -> tuple[str, Arguments | None]:
    """A line up to its G65 or G66, and the arguments that follow; None for any other line."""
    if "6" not in text or _CALL.search(text) is None:
        return text, None
    characters, places, _comment = strip_comments(text)
    match = _CALL.search(characters)
    if match is None:  # it stands in a comment
        return text, None
    begin = places[match.end()]
    reader = ValueReader(characters, places, values)
    reader.at = match.end()
    if keys.decimal_point == "conventional" and find_lines_without_point(text[begin:].encode()).size:
        what = (
            "arguments of a macro without a decimal point count increments that depend on their letters; write "
            "the point"
        )
        raise ProgramError("VP007", what, begin + 1)
    return text[:begin], read_arguments(reader)


def find_macro_call(block: Block, codes: set[int], modes: Modes, axes: str) -> Call | None:
    """The call of G65, or that of G66 after a block that moves; G66 and G67 begin and end the latter."""
    if not codes & {650, 660}:
        if 670 in codes:
            modes.macro = None
        moves = modes.motion is not None and set(axes) & set(block.words) and not codes & set(_STANDING)
        return modes.macro if moves else None
    calls, arguments = block.arguments or ({}, {})
    if "P" not in calls:
        raise ProgramError("VP005", "G65 and G66 need P, the program number of the macro")
    column = next(at for letter, number, at in block.codes if letter == "G" and round(number) in (65, 66))
    words = Block(block.line, words=calls)
    repeats = read_whole(words, "L") if "L" in calls else 1
    word = "G66" if 660 in codes else "G65"
    label = str(read_whole(words, "P"))
    call = Call(label, column, repeats, arguments=dict(arguments), keeps=660 in codes, word=word)
    if 650 in codes:
        return call
    if modes.macro is not None:
        raise ProgramError("VP002", "G66 under G66: only one modal macro call can be active; write G67 before", column)
    modes.macro = replace(call, column=None)  # the column is one of this line, not of those after which it is executed
    return None


def find_local_call(block: Block, subprograms: list[int]) -> Call | None:
    """The call of M97 P, which begins at a block of the program, or of M99, which may go back to one; None for M98."""
    code = next((code for code in subprograms if code in (97, 99)), None)
    if code is None:
        return None
    column = next(at for letter, number, at in block.codes if letter == "M" and round(number) == code)
    number = read_whole(block, "P") if "P" in block.words else None
    if code == 99:
        return Call(None, column, number=number)
    if number is None:
        raise ProgramError("VP005", "M97 needs P, the number of the block where the subprogram begins", column)
    return Call(
        f"N{number}", block.columns.get("P", column), read_whole(block, "L") if "L" in block.words else 1, number
    )


def divide_number(call: Call) -> Call:
    """M98 P with more than four digits: the number of a program (Haas), or the repeats before one (Fanuc)."""
    if call.label is None or len(call.label) <= _DIGITS:
        return call
    return replace(call, divided_label=(str(int(call.label[-_DIGITS:])), int(call.label[:-_DIGITS])))


def set_control_variable(core: Machining, line: int, key: int | str, value: float, column: int, text: str) -> bool:
    """Set a variable of the control: an alarm, a stop, or none with an effect here; False for any other variable."""
    if key not in _OF_CONTROL:
        return False
    comment = strip_comments(text)[2]
    if key in _WITHOUT_EFFECT or not value:
        core.recorder.record_event(line, "without effect", word=f"#{key}")
    elif key == _ALARM:
        shown_comment = f" ({comment})" if comment else ""
        raise ProgramError("VP027", f"the program asks to stop: #3000={value:g}{shown_comment}", column)
    else:
        core.recorder.record_event(line, "message", text=comment or "")
        core.auxiliary.stop(At(line), 0)
    return True
