"""A refused program with another text or other options: what is left of its errors then."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program, assemble, build_interpreter_setup
from verne_post.app.constraints import check_line, check_program, guard_joints
from verne_post.app.remedies.lines import (
    CONTACTS,
    Line,
    Trial,
    is_carried_along,
)
from verne_post.base.long_text import Text, take_line
from verne_post.base.program_lines import (
    add_angle,
    change_number,
    find_machine_code,
    find_word_of,
)
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.inch_words import is_in_inches
from verne_post.kinematics.checks.remedies import (
    is_beyond_at_start,
    is_movable,
    select_line,
)
from verne_post.model.codes import CODES
from verne_post.model.findings import (
    Finding,
    InputError,
    Remedy,
    list_lines,
)
from verne_post.model.verdict import is_about_pose
from verne_post.toolpath.contour import make_exact_contour

#: A proposed offset is rounded to this, mm, away from where it was: people do not set hundredths.
ROUND_MM: Final = 0.1
#: A longer contour is not checked anew for remedies: the refusal should not take many times as long as the check.
TRIED_ELEMENTS: Final = 20_000
#: Options that cure findings of a code -> their fields.
CURING_OPTIONS: Final[dict[str, tuple[str, dict[str, Any]]]] = {
    "VP301": ("--allow-rewind", {"allow_rewind": True}),
    "VP217": ("--correct-axis", {"correct_axis": True}),
}
#: An edit that lets a rotary axis turn so far within a feed line, rad, which turned less, is no remedy.
_WIDE: Final = 0.5 * np.pi


def is_short(program: Program) -> bool:
    """Whether the whole program is checked anew with each remedy."""
    return len(program.contour) <= TRIED_ELEMENTS


def list_errors(findings: Sequence[Finding]) -> list[Finding]:
    """Errors about poses, each with its line."""
    return [item for item in findings if item.severity == "error" and is_about_pose(item.code) and item.line]


def find_line(program: Program, joints: Any, number: int | None, source: Text = b"") -> Line | None:
    """A line of errors, with the unit of its words in ``source``; None where it is no motion of the part alone."""
    number = number or 0
    own = select_line(joints, number)
    if not number or not len(own.contour) or not is_movable(own):
        return None
    exact = select_line(replace(joints, contour=make_exact_contour(program.path)), number)
    inches = bool(source) and is_in_inches(source, build_interpreter_setup(program.machine, program.options), number)
    text = (take_line(source, number) or b"").decode("utf-8", errors="replace")
    return Line(number, text, own, program.moves, None, program.options, (), exact, in_inches=inches)


def find_line_in_machine(program: Program, item: Finding) -> int:
    """The first or the worst line of a finding, where it leads to machine coordinates (G53, G500, SUPA, M91); else 0.

    No work offset moves it, and none brings the lines of the finding within limits. A line that G500 holds for in one
    of its executions alone is not meant.
    """
    moves = program.moves
    in_machine = moves.find_in_machine()
    for line in (item.line, item.worst_line):
        at = np.flatnonzero(moves.line == line)
        if not line or not (len(at) and (in_machine[at].all() or np.isin(at, moves.machine_moves).any())):
            continue
        # it may be the worst one only because it begins where the line before has broken the limit
        if line == item.line or not is_beyond_at_start(select_line(guard_joints(program), line), item):
            return line
    return 0


def find_code_of_line(source: Text, program: Program, line: int | None) -> str:
    """The code of machine coordinates in a line (G53, SUPA, M91, G28); empty where it has none."""
    options = program.options
    text = (take_line(source, line or 0) or b"").decode("utf-8", errors="replace")
    return find_machine_code(text, choose_dialect_name(options.dialect, source, options.source_name))


def is_carried_with_part(program: Program, joints: Any, item: Finding) -> bool:
    """Whether no work offset can cure a contact: see :func:`~verne_post.app.remedies.lines.is_carried_along`."""
    line = find_line(program, joints, item.line) if item.code in CONTACTS else None
    return line is not None and is_carried_along(program.options, item, line.frame.system)


def try_program(
    source: Text, program: Program, *, only_first: bool | str = False, only_lines: bool = False, **change: Any
) -> tuple[Program, list[Finding]] | None:
    """The program with another text or other options, and its errors; None where it cannot be read with them.

    ``only_first`` and ``only_lines`` are those of :func:`check_program`.
    """
    try:
        options = program.options.changed(**change) if change else program.options
        changed = assemble(source, program.machine, options, program.team)
        found = check_program(changed, only_first=only_first, only_lines=only_lines)[1]
    except InputError:
        return None
    return changed, [item for item in found if item.severity == "error"]


def find_codes_with(
    source: Text, program: Program, *, only_first: bool = False, **change: Any
) -> tuple[str, ...] | None:
    """Codes of the errors that :func:`try_program` finds, each once."""
    tried = try_program(source, program, only_first=only_first, **change)
    return None if tried is None else tuple(dict.fromkeys(item.code for item in tried[1]))


def is_right_with(source: Text, program: Program, **change: Any) -> bool:
    """Whether the program has no error with other options; without its stock first, because cutting takes longest."""
    if program.options.stock is not None and find_codes_with(source, program, **{**change, "stock": None}) != ():
        return False
    return find_codes_with(source, program, only_first=True, **change) == ()


def name_left(codes: Sequence[str]) -> str:
    """What a remedy leaves to be mended: each code with its meaning."""
    codes = list(dict.fromkeys(codes))
    named = ", ".join(f"{code} ({CODES[code].title})" for code in codes)
    return f"{named} {'remains' if len(codes) == 1 else 'remain'}"


def build_trial(source: Text, program: Program, line: Line) -> Trial:
    """Whether words leave a line no errors, and other lines no errors and no turns of the table that they had not.

    None where a line does not have them, as in a loop or in G91.
    """
    before: list[set[tuple[object, ...]]] = []
    wide_turns = _list_wide_turns(program)

    def holds(words: Sequence[Remedy]) -> bool | None:
        lines = bytes(source).split(b"\n")
        for word in words:
            changed = _change_line(lines[word.line - 1].decode("utf-8", errors="replace"), word)
            if changed is None:
                return None
            lines[word.line - 1] = changed.encode()
        try:
            made = assemble(b"\n".join(lines), program.machine, program.options, program.team)
            if not _list_wide_turns(made) <= wide_turns:
                return False
            if not is_short(program):
                return not list_errors(check_line(made, select_line(guard_joints(made), line.number), line.number))
            after = check_program(made, only_lines=True)[1]
        except InputError:
            return False
        before[:] = before or [list_places(check_program(program, only_lines=True)[1])]
        is_mended = all(line.number not in list_lines(one) for one in list_errors(after))
        return is_mended and list_places(after) <= before[0]

    return holds


def _list_wide_turns(program: Program) -> set[int]:
    """Lines of feed moves in which a rotary axis turns by more than a right angle."""
    path = program.path
    turn = np.abs(path.end[:, 3:] - path.start[:, 3:]).max(axis=1, initial=0.0)
    return set(path.line[(path.feed_time > 0.0) & (turn > _WIDE)].tolist())


def list_places(findings: Sequence[Finding]) -> set[tuple[object, ...]]:
    """What is wrong where: code, axis and line of each error and of each turn of the table."""
    told = [*list_errors(findings), *(one for one in findings if one.code == "VP301")]
    return {(one.code, one.axis, number) for one in told for number in list_lines(one)}


def _change_line(text: str, remedy: Remedy) -> str | None:
    """A line with a remedy in its words; None where it does not have them, as in a loop or in G91."""
    if remedy.misspelt:
        return text.replace(remedy.misspelt, remedy.value, 1)
    word = find_word_of(text, *remedy.word)
    return add_angle(text, remedy.word[0], remedy.value) if word is None else change_number(text, word, remedy.value)
