"""Tool tables in LinuxCNC's text format: ``T1 P1 Z50.0 D6.0 ; remark``, one tool a line, mm."""

from verne_post.base.file_kinds import describe_kind
from verne_post.gcode.block import read_block
from verne_post.gcode.program_error import ProgramError
from verne_post.model.findings import Finding, InputError, make_finding
from verne_post.model.moves import AXES
from verne_post.model.part_setup import MAX_PLACE, MAX_TOOL, Tool, Vector9

_LETTERS = set("TPDIJQ" + AXES)


def read_tool_table(text: str, name: str) -> dict[int, Tool]:
    """Parse a tool table.

    Parameters
    ----------
    name : str
        File name for messages.

    Returns
    -------
    dict
        Tools by number, offsets in mm and degrees. A line without Z gives a tool whose length is not known.

    Raises
    ------
    InputError
        With one finding (VP019) a bad line.
    """
    tools: dict[int, Tool] = {}
    errors: list[Finding] = []
    for number, raw in enumerate(text.splitlines(), start=1):
        try:
            tool = _read_line(raw, number, f"{name}:{number}")
        except ProgramError as error:
            message = f"{name}:{number}: {error.message}"
            errors.append(make_finding("VP019", message, column=error.column))
            continue
        if tool is None:
            continue
        if tool.number in tools:
            errors.append(make_finding("VP019", f"{name}:{number}: tool T{tool.number} appears twice in the table"))
        tools[tool.number] = tool
    if len(errors) > 1 and not tools:  # one cause: another kind of file
        other = describe_kind(text.encode(), "a tool table") or "is this a tool table?"
        first = f"{errors[0].message}; no other line is that of a tool either: {other}"
        errors = [make_finding("VP019", first, column=errors[0].column)]
    if errors:
        raise InputError(*errors)
    return tools


def _read_line(raw: str, number: int, where: str) -> Tool | None:
    block = read_block(raw, number)
    if not block.words and not block.codes:
        return None
    if block.codes or not set(block.words) <= _LETTERS:
        strange = block.codes[0][0] if block.codes else min(set(block.words) - _LETTERS)
        hint = "; the length is Z" if strange in "HL" else ""
        text = f"{strange} is not a word of a tool table; expected T, P, an axis, D, I, J or Q{hint}"
        raise ProgramError("VP019", text, block.codes[0][2]) if block.codes else block.error("VP019", text, strange)
    if "T" not in block.words:
        raise ProgramError("VP019", "the tool number T is missing")
    for letter in "TP":
        if block.words.get(letter, 0.0) % 1 or block.words.get(letter, 0.0) < 0:
            raise block.error("VP019", f"{letter} must be a whole number from 0 on", letter)
    for letter, value in block.words.items():
        if letter in AXES and abs(value) > MAX_PLACE:
            raise block.error("VP019", f"{letter}{value:g} is beyond {MAX_PLACE:g}", letter)
        if letter == "D" and not 0 <= value <= MAX_TOOL:
            raise block.error("VP019", f"D{value:g}: expected a diameter from 0 to {MAX_TOOL:g}", letter)
    offset: Vector9 = tuple(block.words.get(axis, 0.0) for axis in AXES)  # type: ignore[assignment]
    without_length = "" if "Z" in block.words else where
    return Tool(
        int(block.words["T"]),
        int(block.words.get("P", 0)),
        offset,
        block.words.get("D", 0.0),
        without_length,
        row=where,
    )
