"""What would bring a refused program within limits: every remedy is tried on the program before it is reported.

A work offset and an option are tried on the whole program; a tilt, another branch and another end on their line.
"""

import dataclasses
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program, assemble, build_interpreter_setup
from verne_post.app.constraints import check_line, check_program, guard_joints
from verne_post.app.contact_remedies import TRIED_ELEMENTS, find_shallow_depth, propose_heights
from verne_post.app.explain_numbers import format_list, format_number
from verne_post.app.line_remedies import (
    CONTACTS,
    Line,
    Trial,
    describe_plane,
    is_carried_along,
    meets_in_rapid,
    propose_depth,
    propose_ends,
    propose_lift,
    propose_turns,
)
from verne_post.app.meant_motion import find_meant_motion
from verne_post.app.retract_remedies import add_retract, find_missing_retract, find_turn
from verne_post.base.arrays import Array
from verne_post.base.long_text import Text, take_line
from verne_post.base.program_lines import (
    add_angle,
    change_number,
    find_coordinate,
    find_machine_code,
    find_word,
    find_word_of,
    flip_component,
    name_component,
    read_number,
)
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.inch_words import is_in_inches, read_as_mm
from verne_post.kinematics.checks.remedies import (
    FARTHEST_MM,
    ROTARY_CODES,
    find_smallest_shift,
    is_beyond_at_start,
    is_movable,
    is_straight,
    select_line,
)
from verne_post.model.codes import CODES
from verne_post.model.findings import (
    NOT_TRIED,
    NOTHING_FOUND,
    Finding,
    InputError,
    Remedy,
    has_line,
    join_lines,
    list_lines,
    make_finding,
)
from verne_post.model.moves import MoveKind, find_tool_of_moves
from verne_post.model.options import Options
from verne_post.model.part_setup import MACHINE_SYSTEM, WorkOffset, describe_tool_number, name_system
from verne_post.model.protocols import turn_from_setup, turn_to_setup
from verne_post.model.verdict import NO_POSE, Family, find_family, is_about_pose
from verne_post.output.causes import find_excess
from verne_post.output.commands import find_run
from verne_post.toolpath.branch_choice import DEPARTURE
from verne_post.toolpath.contour import make_exact_contour

#: Findings of a program that are given remedies, the gravest place of each: the others mostly follow from them.
REMEDIED: Final = 3
#: Offsets that are tried, each moved so that the worst line of the one before is within limits.
OFFSETS: Final = 4
#: A part that would have to stand farther off than this, mm, is not clamped in a wrong place: the unit is looked at.
FAR_MM: Final = 300.0
#: A part that is raised by no more than this, mm, is not moved along other axes; nor for less than half of the way.
NEAR_MM: Final = 10.0
RAISED: Final = 2.0
#: A component of a move that is no larger than this share of the largest one is left out where nothing needs it.
TRACE: Final = 0.1
#: A work offset so far below the table face, mm, and to the negative side of X and Y, is no place of a part.
DEEP_MM: Final = 100.0
#: A proposed offset is rounded to this, mm, away from where it was: people do not set hundredths.
ROUND_MM: Final = 0.1
#: In a program in inches.
_ROUND_INCH: Final = 0.005
#: Asked of a program in inches that leaves the machine, and in mm only goes below the table face.
_TOO_LOW: Final = ", and a higher work offset?"
#: Options that cure findings of a code -> their fields.
_OPTIONS: Final[dict[str, tuple[str, dict[str, Any]]]] = {
    "VP301": ("--allow-rewind", {"allow_rewind": True}),
    "VP217": ("--correct-axis", {"correct_axis": True}),
}
#: What a hole that is too deep breaks: the travel of a joint, the table, fixtures, stock.
_OF_DEPTH: Final = ("VP101", "VP210", "VP215", "VP216")
#: A number of a letter with a point or a comma (1), of words and of CL files.
_POINTED_WORD: Final = r"(?<![A-Z_$]){}[ \t]*=?[ \t]*[-+]?\d*(\.|,(?=\d))"
_POINTED: Final = {"aptcl": r"(?<=\d)(\.)(?=\d)"}
#: So many places of a lost point are tried, each as long as a check.
_POINTS_TRIED: Final = 3
#: An edit that lets a rotary axis turn so far within a feed line, rad, which turned less, is no remedy.
_WIDE: Final = 0.5 * np.pi
#: Cosine between a tool axis and the one before it where its sign was wrong: 60 degrees.
_NEAR_AXIS: Final = 0.5
#: So many of the places that were tried in vain are named.
_NAMED_PLACES: Final = 4


def add_remedies(source: Text, program: Program, findings: Sequence[Finding]) -> list[Finding]:
    """The findings of a refused program, the first errors with the remedies that were tried and hold.

    Where the unit, or the machine file, is what is wrong, all findings about poses are that one.

    Parameters
    ----------
    findings : sequence of Finding
        Of the whole program, as :func:`check_program` returns them.
    """
    errors = _list_errors(findings)
    if not errors:
        return list(findings)
    if (unreachable := _find_unreachable(program, errors)) is not None:
        return _put_cause(unreachable, findings)
    joints = guard_joints(program)
    is_short = len(program.contour) <= TRIED_ELEMENTS
    movable = [item for item in errors if not _find_line_in_machine(program, item)]
    meant = find_meant_motion(source, program, findings)
    if meant is None:
        meant = find_flipped_axis(source, program, errors)
    retract = find_missing_retract(source, program, findings) if meant is None else None
    if retract is not None and retract.cures_all:
        return add_retract(findings, retract)
    can_help = is_short and meant is None and not all(is_carried_with_part(program, joints, item) for item in movable)
    before = [] if meant is None else list_errors_before(program, errors, meant)
    in_inches = _find_mistaken_unit(source, program, errors)
    places: list[WorkOffset] = []
    # where the part is too low in mm too, its place is wrong, and the unit only if no place helps
    too_low = in_inches is not None and in_inches.message.endswith(_TOO_LOW)
    farthest = FARTHEST_MM if in_inches is None or too_low else FAR_MM
    of_control = _find_offset_of_control(program, movable) if can_help else None
    seeks = of_control is None and (can_help or before)
    found = _find_offset(source, program, movable, places, farthest) if seeks else None
    nothing = _say_no_offset(program.options, places)
    offset, distance = found or (None, np.inf)
    if in_inches is not None and (distance == np.inf and seeks if too_low else distance > FAR_MM):
        return _put_cause(in_inches, [one for one in findings if not _is_about_unit(one)])
    word = None
    if is_short and meant is None:
        word = _find_forgotten_g91(source, program, errors) or find_forgotten_feed(source, program, errors)
        word = word or _find_lost_point(source, program, errors)
        word = word or _find_shallow_depth(source, program, errors) or _find_word(source, program, joints, errors)
    if can_help:  # a sign explains a part under the table better than a word of the program does
        is_far = offset is None and word is None
        word = of_control or _find_slip_of_setup(source, program, movable, is_far=is_far) or word
    chosen: dict[object, Finding] = {}
    for item in errors:
        chosen.setdefault((item.code, item.axis), item)
    remedied = list(chosen.values())[:REMEDIED]
    made: list[Finding] = []
    for item in findings:
        if item in remedied and meant is not None:
            cures = (meant, offset) if offset is not None and item in before else (meant,)
            edits = tuple(one for one in cures if one.value)
            item = dataclasses.replace(item, remedies=tuple(one.text for one in cures), edits=edits)
        elif item in remedied:
            tried = tuple(_try_remedies(source, program, joints, item, offset or nothing))
            fixed_line = _find_line_in_machine(program, item)
            code = _find_machine_code(source, program, fixed_line)
            is_turn = not code and find_turn(program, item) is not None  # no word of the line says where it goes
            if fixed_line and item.code not in (*ROTARY_CODES, *_OPTIONS) and not is_turn:
                if not code and fixed_line not in program.moves.line[list(program.moves.machine_moves)]:
                    code = name_system(MACHINE_SYSTEM)
                word_of = f" ({code})" if code else ""
                why = f"line {fixed_line} is in machine coordinates{word_of}, which no work offset moves"
                cure = Remedy(f"{why}; change its values")
                if word is not None and word.line == fixed_line:
                    cure = dataclasses.replace(word, text=f"{why}; {word.text}")
                tried = (cure, *(one for one in tried if one not in (offset, nothing)))
            elif word is not None:
                tried = (word, *(one for one in tried if one != nothing))
            if plane := describe_plane(program.moves, program.machine, item, item.line or 0):
                tried = (Remedy(f"{NOT_TRIED}{plane}"), *tried)
            edits = tuple(one for one in tried if one.value)
            item = dataclasses.replace(item, remedies=tuple(one.text for one in tried), edits=edits)
        made.append(item)
    return made if retract is None else add_retract(made, retract)


def name_cause(source: Text, program: Program, findings: Sequence[Finding]) -> list[Finding]:
    """What :func:`add_remedies` finds, without a search for remedies where the unit is not in doubt."""
    errors = _list_errors(findings)
    if errors and (unreachable := _find_unreachable(program, errors)) is not None:
        return _put_cause(unreachable, findings)
    if not errors or _find_mistaken_unit(source, program, errors) is None:
        return list(findings)
    return add_remedies(source, program, findings)


def list_errors_before(program: Program, findings: Sequence[Finding], meant: Remedy) -> list[Finding]:
    """Errors that begin before the motion that is doubted: they are not of it alone, and another place may cure them.

    ``meant``: as :func:`find_meant_motion` returns it.
    """
    begun = (item for item in _list_errors(findings) if (item.line or 0) < meant.line)
    return [item for item in begun if not _find_line_in_machine(program, item)]


def find_offset_before(source: Text, program: Program, meant: Remedy, line: int) -> str | None:
    """The work offset that ``check`` names for an error of a line which begins before the motion that is doubted."""
    errors = _list_errors(check_program(program)[1])
    if not any(line in list_lines(item) for item in list_errors_before(program, errors, meant)):
        return None
    movable = [item for item in errors if not _find_line_in_machine(program, item)]
    found = _find_offset(source, program, movable, [], FARTHEST_MM)
    return None if found is None else found[0].text


def _list_errors(findings: Sequence[Finding]) -> list[Finding]:
    return [item for item in findings if item.severity == "error" and is_about_pose(item.code) and item.line]


def _find_unreachable(program: Program, errors: Sequence[Finding]) -> Finding | None:
    """That no pose of the machine file can be reached, where one was not."""
    is_lost = any(item.code in NO_POSE for item in errors)
    return program.machine.unreachable[0] if is_lost and program.machine.unreachable else None


def _put_cause(cause: Finding, findings: Sequence[Finding]) -> list[Finding]:
    """A cause in place of all findings about poses."""
    return [cause, *(one for one in findings if not is_about_pose(one.code))]


def _is_about_unit(item: Finding) -> bool:
    """VP010 of BEGIN PGM and END PGM with two units."""
    return item.code == "VP010" and item.message.endswith("the unit of the numbers")


def _find_machine_code(source: Text, program: Program, line: int | None) -> str:
    options = program.options
    text = (take_line(source, line or 0) or b"").decode("utf-8", errors="replace")
    return find_machine_code(text, choose_dialect_name(options.dialect, source, options.source_name))


def _find_mistaken_unit(source: Text, program: Program, errors: Sequence[Finding]) -> Finding | None:
    """VP505, an error: a program in inches leaves the machine, and in mm no pose of it is refused; else None.

    The reverse, inches that are read as mm, leaves no trace: a small part is within limits too.
    """
    if len(program.contour) > TRIED_ELEMENTS or not any(find_family(item.code) == Family.POSITION for item in errors):
        return None
    found = read_as_mm(source, build_interpreter_setup(program.machine, program.options))
    if found is None:
        return None
    place, text = found
    left = _find_errors_with(text, program, stock=None)  # a contact says nothing about the unit
    refused = None if left is None else {code for code in left if is_about_pose(code)}
    if refused is None or refused - {"VP210"}:
        return None
    tips = np.concatenate([program.path.start[:, :3], program.path.end[:, :3]])
    span = float(np.ptp(tips, axis=0).max())
    in_mm = "the tip goes below the table face, and no more is refused" if refused else "no pose of it is refused"
    message = (
        f"{place.word}: read in inches, the program spans {span:.0f} mm and leaves the machine, first in line "
        f"{min(item.line or 0 for item in errors)}; read in mm, {in_mm}; did you mean {place.word_for_mm}"
        f"{_TOO_LOW if refused else '?'}"
    )
    where = {"line": place.line, "last_line": place.line, "worst_line": place.line, "column": place.column}
    return make_finding("VP505", message, severity="error", **where)


def _try_remedies(source: Text, program: Program, joints: Any, item: Finding, offset: Remedy) -> Iterator[Remedy]:
    """What helps against a finding; ``offset`` has a value, or says that no move of the part was found."""
    departs = not program.options.allow_rewind and any(one.quantity == DEPARTURE for one in program.findings)
    for code in dict.fromkeys((item.code, *(("VP301",) if departs else ()))):
        flag, change = _OPTIONS.get(code, ("", {}))
        if not flag:
            continue
        left = _find_errors_with(source, program, **change) if len(program.contour) <= TRIED_ELEMENTS else None
        if left is not None and item.code not in left:
            what = f"removes this error; {_name_left(left)}" if left else "brings the program within limits"
            yield Remedy(f"{flag} {what}", "true", key=tuple(change))
    if item.code in _OPTIONS:
        return
    own = _find_line(program, joints, item.line, source) if item.code in CONTACTS else None
    is_of_line = item.last_line == item.line  # a line alone is lifted
    if own is not None and is_of_line and (item.code == "VP215" or meets_in_rapid(own, [item])):
        for text in propose_lift(own, [item]):
            yield Remedy(f"line {own.number} alone: {text}")
    if offset.value and item.code not in ROTARY_CODES and not _find_line_in_machine(program, item):
        yield offset
    elif find_family(item.code) != Family.BRANCH:
        line = _find_line(program, joints, item.line, source)
        if line is not None:
            for one in propose_turns(line, [item], build_trial(source, program, line)):
                yield dataclasses.replace(one, text=f"line {line.number} alone: {one.text}")
        moves = line is not None or item.code not in CONTACTS  # not where it starts: an offset does not say how it came
        tried = moves and item.code not in ROTARY_CODES and len(program.contour) <= TRIED_ELEMENTS
        if tried and not _find_line_in_machine(program, item) and not is_carried_with_part(program, joints, item):
            yield offset


def is_carried_with_part(program: Program, joints: Any, item: Finding) -> bool:
    """Whether no work offset can cure a contact: see :func:`~verne_post.app.line_remedies.is_carried_along`."""
    line = _find_line(program, joints, item.line) if item.code in CONTACTS else None
    return line is not None and is_carried_along(program.options, item, line.frame.system)


def list_ends(source: Text, program: Program, item: Finding) -> list[Remedy]:
    """Other numbers for X, Y or Z of the first line of an error, or for a height of its cycle, each an edit.

    They take ten times as long as the check: an editor asks for them, and in words `explain` of the line has them.
    """
    others = item.code in (*ROTARY_CODES, *_OPTIONS) or find_family(item.code) == Family.BRANCH
    if item.severity != "error" or not is_about_pose(item.code) or others:
        return []
    line = _find_line(program, guard_joints(program), item.line, source)
    if line is None:
        return []
    ends = list(propose_ends(line, [item], warnings=False))
    deep = [one for one in ends if one.word[0] == "Z" and one.word[1] < 0.0]
    # a Z below the part may have a sign too many: whoever asks tries the edit
    unsigned = [dataclasses.replace(one, value=format_number(-one.word[1]), is_choice=True) for one in deep]
    return [*propose_heights(source, program, line, item), *unsigned, *ends]


def _find_line(program: Program, joints: Any, number: int | None, source: Text = b"") -> Line | None:
    """A line of errors, with the unit of its words in ``source``; None where it is no motion of the part alone."""
    number = number or 0
    own = select_line(joints, number)
    if not number or not len(own.contour) or not is_movable(own):
        return None
    exact = select_line(replace(joints, contour=make_exact_contour(program.path)), number)
    inches = bool(source) and is_in_inches(source, build_interpreter_setup(program.machine, program.options), number)
    text = (take_line(source, number) or b"").decode("utf-8", errors="replace")
    return Line(number, text, own, program.moves, None, program.options, (), exact, in_inches=inches)


def _find_errors_with(
    source: Text, program: Program, *, only_first: bool = False, **change: Any
) -> tuple[str, ...] | None:
    """Codes of the errors of the program with other options, each once; None where it cannot be read with them."""
    try:
        changed = assemble(source, program.machine, program.options.changed(**change), program.team)
        found = check_program(changed, only_first=only_first)[1]
    except InputError:
        return None
    return tuple(dict.fromkeys(item.code for item in found if item.severity == "error"))


def _is_right_with(source: Text, program: Program, **change: Any) -> bool:
    """Whether the program has no error with other options; without its stock first, because cutting takes longest."""
    if program.options.stock is not None and _find_errors_with(source, program, **{**change, "stock": None}) != ():
        return False
    return _find_errors_with(source, program, only_first=True, **change) == ()


def _name_left(codes: Sequence[str]) -> str:
    """What a remedy leaves to be mended: each code with its meaning."""
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
            if len(program.contour) > TRIED_ELEMENTS:
                return not _list_errors(check_line(made, select_line(guard_joints(made), line.number), line.number))
            after = check_program(made, only_lines=True)[1]
        except InputError:
            return False
        before[:] = before or [_list_places(check_program(program, only_lines=True)[1])]
        is_mended = all(line.number not in list_lines(one) for one in _list_errors(after))
        return is_mended and _list_places(after) <= before[0]

    return holds


def _list_wide_turns(program: Program) -> set[int]:
    """Lines of feed moves in which a rotary axis turns by more than a right angle."""
    path = program.path
    turn = np.abs(path.end[:, 3:] - path.start[:, 3:]).max(axis=1, initial=0.0)
    return set(path.line[(path.feed_time > 0.0) & (turn > _WIDE)].tolist())


def _list_places(findings: Sequence[Finding]) -> set[tuple[object, ...]]:
    told = [*_list_errors(findings), *(one for one in findings if one.code == "VP301")]
    return {(one.code, one.axis, number) for one in told for number in list_lines(one)}


def _change_line(text: str, remedy: Remedy) -> str | None:
    """A line with a remedy in its words; None where it does not have them, as in a loop or in G91."""
    if remedy.misspelt:
        return text.replace(remedy.misspelt, remedy.value, 1)
    word = find_word_of(text, *remedy.word)
    return add_angle(text, remedy.word[0], remedy.value) if word is None else change_number(text, word, remedy.value)


# --- one word of the program ---------------------------------------------------------------------------------


def _find_forgotten_g91(source: Text, program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """G90 in place of the G91 above the first error, or below its line where it is for G28; checked with it."""
    lines = bytes(source).split(b"\n")
    for number in range(min(item.line or 0 for item in errors), 0, -1):
        text = lines[number - 1].decode("utf-8", errors="replace")
        word = find_word_of(text, "G", 91.0)
        if find_word_of(text, "G", 90.0) is not None:
            return None
        if word is not None:
            break
    else:
        return None
    is_for_retract = bool(_find_machine_code(source, program, number))
    if is_for_retract:
        said, lines[number - 1] = f"G90 stands below line {number}, whose G91", lines[number - 1] + b"\nG90"
    else:
        said = f"line {number} has G90 instead of G91, which"
        lines[number - 1] = change_number(text, word, "90").encode()
    if not _is_right_with(b"\n".join(lines), program):
        return None
    text = f"within limits if {said} makes the values from there on distances"
    return Remedy(text) if is_for_retract else Remedy(text, "90", line=number, word=("G", 91.0))


def find_forgotten_feed(source: Text, program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """A feed rate in the first line of errors, a rapid at the height of the cuts beside it; checked with it.

    The line has F, or cuts precede and follow it, in one frame.
    """
    moves, number = program.moves, min(item.line or 0 for item in errors)
    rows = np.flatnonzero(moves.line == number)
    if len(rows) != 1 or not 0 < rows[0] < len(moves) - 1 or moves.kind[rows[0]] != MoveKind.RAPID:
        return None
    row = int(rows[0])
    around = np.array([row - 1, row, row + 1])
    lines = bytes(source).split(b"\n")
    text = lines[number - 1].decode("utf-8", errors="replace")
    cuts = np.isfinite(moves.feed[around]) & (moves.kind[around] != MoveKind.DWELL)
    level = around[: 2 + int(cuts[2])]
    is_level = bool((moves.frame[level] == moves.frame[row]).all() and np.ptp(moves.end[level, 2]) < LIMIT_SLACK_MM)
    touches = any(item.code == "VP216" and item.line == number for item in errors)
    if not touches or not cuts[0] or not is_level or not (cuts[2] or find_word(text, "F")):
        return None
    rate, word = f"F{format_number(float(moves.feed[row - 1]))}", find_word_of(text, "G", 0.0)
    setup = build_interpreter_setup(program.machine, program.options)
    if moves.language != "heidenhain" and word is not None:
        said, right, in_force = word[0], "G1", "" if find_word(text, "F") else f" ({rate} mm/min is in force)"
    elif moves.language == "heidenhain" and "FMAX" in text and not is_in_inches(source, setup, number):
        said, right, in_force = "FMAX", rate, f" ({rate} is in force)"
    else:
        return None
    lines[number - 1] = text.replace(said, right, 1).encode()
    if not _is_right_with(b"\n".join(lines), program):
        return None
    told = f"within limits if line {number} cuts at a feed rate: write {right} in place of {said}{in_force}"
    return Remedy(told, right, line=number, misspelt=said, is_choice=True)


def _find_word(source: Text, program: Program, joints: Any, errors: Sequence[Finding]) -> Remedy | None:
    """The word that alone is at fault: X, Y or Z of the first line of errors, where all of them are in one stretch.

    Of several words the one that changes least; of a line that drills, Z. The program was checked with it.
    """
    first = min(errors, key=lambda item: item.line or 0)
    start, end = first.line or 0, first.last_line or 0
    line = _find_line(program, joints, start, source)
    lines = bytes(source).split(b"\n")
    if line is None or any(item.code in (*ROTARY_CODES, *_OPTIONS) for item in errors):
        return None
    is_hole = not is_straight(line.exact)  # a cycle drills the next ones too, as deep
    if not is_hole and any(not start <= (item.line or 0) <= end for item in errors):
        return None
    text = lines[start - 1].decode("utf-8", errors="replace")
    ends = sorted(propose_ends(line, errors, warnings=False), key=lambda one: abs(float(one.value) - one.word[1]))
    depth = find_word(text, "Z")
    if depth is not None and is_hole:
        ends = list(propose_depth(line, read_number(depth[2])))
    for one in ends:
        letter, now = one.word
        word = find_word_of(text, letter, now)
        if word is None:
            continue
        # the line alone was checked as programmed: a blended corner may take the tool a little farther
        step = ROUND_MM if line.unit[1] == 1.0 else _ROUND_INCH
        # the number of a machine coordinate is that of its limit, and the line alone was checked a little inside it
        least = -1.0 if line.move in program.moves.machine_moves else 0.0
        steps = np.ceil(np.round(abs(float(one.value) - now) / step, 6)) + np.arange(least, 2.0)
        for then in now + np.sign(float(one.value) - now) * steps * step:
            value = format_number(then)
            changed = change_number(text, word, value)
            if _is_right_with(b"\n".join([*lines[: start - 1], changed.encode(), *lines[start:]]), program):
                there = "has" if is_hole else "ends at"
                said = f"within limits if line {start} {there} {letter} {value} instead of {word[2].rstrip('.')}"
                return Remedy(said, value, line=start, word=one.word)
    return None


def find_flipped_axis(source: Text, program: Program, findings: Sequence[Finding]) -> Remedy | None:
    """The tool axis of the first line of errors with the sign of one component that it may have lost; checked with it.

    It leads away from the axis before by more than a right angle, and with the other sign by less than 60 degrees.
    """
    errors = _list_errors(findings)
    moves, number = program.moves, min((item.line or 0 for item in errors), default=0)
    own = np.flatnonzero(moves.line == number)
    if len(program.contour) > TRIED_ELEMENTS or not len(own) or not np.isfinite(moves.tool_axis[own[-1]]).all():
        return None
    axis, before = moves.tool_axis[own[-1]], _find_axis(program, int(own[0]) - 1)
    lines = bytes(source).split(b"\n")
    for component in range(3) if axis @ before < 0.0 else ():
        other = np.where(np.arange(3) == component, -axis, axis)
        text = lines[number - 1].decode("utf-8", errors="replace")
        flipped = flip_component(text, moves.language, component)
        if flipped is None or other @ before < _NEAR_AXIS:
            continue
        said, right, value = flipped
        alike = [at for at in range(number, len(lines) + 1) if said.encode() in lines[at - 1]]
        changed = [one.replace(said.encode(), right.encode()) for one in lines[number - 1 :]]
        if _is_right_with(b"\n".join([*lines[: number - 1], *changed]), program):
            name = name_component(moves.language, component)
            told = f"within limits with {name} {value} in {join_lines(alike)}: is the sign wrong?"
            if len(alike) > 1:  # an edit is of one line
                return Remedy(told, line=number)
            return Remedy(told, right, line=number, misspelt=said, turns=True, is_choice=True)
    return None


def _find_axis(program: Program, row: int) -> Array:
    """The tool axis (3,) at the end of a move, program directions; upright before the first one."""
    moves = program.moves
    if row < 0:
        return np.array([0.0, 0.0, 1.0])
    if np.isfinite(moves.tool_axis[row]).all():
        return moves.tool_axis[row]
    frame = moves.frames[moves.frame[row]]
    axis = program.machine.coordinates.find_tool_axis(moves.end[row].tolist(), frame)
    return np.array([0.0, 0.0, 1.0]) if axis is None else axis


def _find_shallow_depth(source: Text, program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """The depth of the cycle of the first line of errors, with its point one place to the left; checked with it."""
    number = min(item.line or 0 for item in errors)
    excess = [find_excess(item) for item in errors if item.code in _OF_DEPTH]
    if not excess or not np.isfinite(max(excess)):
        return None
    setup = build_interpreter_setup(program.machine, program.options)
    scale = MM_PER_INCH if is_in_inches(source, setup, number) else 1.0
    found = find_shallow_depth(source, program, number, max(excess) / scale)
    return found[1] if found is not None and _is_right_with(found[0], program) else None


def _find_lost_point(source: Text, program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """X, Y or Z of the first line of errors with the decimal point that it may have lost; checked with it.

    With the point it is between the numbers of this letter before and behind it, or has as many decimals as they have;
    others of it have a point. In a CL file X, Y and Z are the numbers of GOTO.
    """
    language = program.moves.language
    number = min(item.line or 0 for item in errors)
    lines = bytes(source).split(b"\n")
    text = lines[number - 1].decode("utf-8", errors="replace")
    left = _POINTS_TRIED
    for letter in "XYZ":
        word = find_coordinate(text, letter, language)
        digits = "" if word is None else word[2].lstrip("+-")
        if word is None or len(digits) < len("10") or not digits.isdecimal():
            continue
        others = re.search(_POINTED.get(language, _POINTED_WORD.format(letter)).encode(), source[:], re.IGNORECASE)
        if others is None:
            continue
        around = (_find_nearest(one, letter, language) for one in (reversed(lines[: number - 1]), lines[number:]))
        texts = [one for one in around if one is not None]
        beside = [read_number(one) for one in texts]
        sign = word[2].removesuffix(digits)
        if len(beside) != 2:
            continue
        point = others[1].decode()
        values = [f"{sign}{digits[:at] or '0'}{point}{digits[at:]}".removeprefix("+") for at in range(len(digits))]
        between = [one for one in values[::-1] if min(beside) <= read_number(one) <= max(beside)]
        decimals = {len(one.partition(point)[2]) for one in texts}
        alike = [one for one in values if {len(one.partition(point)[2])} == decimals]
        for value in (between or alike)[:left]:
            left -= 1
            changed = change_number(text, word, value).encode()
            if _is_right_with(b"\n".join([*lines[: number - 1], changed, *lines[number:]]), program):
                name = f"{letter.lower()} " if language == "aptcl" else letter
                said = f"{name}{value} may be meant in line {number}, its point is missing: within limits with it"
                if language == "aptcl":
                    return Remedy(said, word[1] + value, line=number, misspelt=word[0], is_choice=True)
                return Remedy(said, value, line=number, word=(letter, float(word[2])), is_choice=True)
    return None


def _find_nearest(lines: Iterable[bytes], letter: str, language: str) -> str | None:
    """The number of a letter in the first of some lines that has it, as it is written."""
    words = (find_coordinate(one.decode("utf-8", errors="replace"), letter, language) for one in lines)
    return next((one[2] for one in words if one is not None), None)


def find_end_before_contact(source: Text, program: Program, line: Line) -> str | None:
    """Where a line along one axis ends before it touches what is left of the stock; the program was checked with it.

    Other ends are sought beside the whole stock: of a pocket, which lines before have cut, these find none.
    """
    touches = [item for item in line.findings if item.code == "VP216" and item.contact and item.line == line.number]
    if line.move < 0 or line.move in program.moves.machine_moves or not touches or not is_straight(line.exact):
        return None
    machine, (unit, scale) = program.machine, line.unit
    tip, angles = line.exact.pose(line.exact.contour, np.zeros(2, dtype=int), np.array([0.0, 1.0]))
    begin, end = (machine.coordinates.map_from_table(*ends, line.frame) for ends in zip(tip, angles, strict=True))
    moved = np.flatnonzero(np.abs(end - begin) > ROUND_MM)
    if len(moved) != 1 or moved[0] > 2 or (moved[0] < 2 and meets_in_rapid(line, touches)):
        return None
    axis, way = int(moved[0]), float(np.sign(end - begin)[moved[0]])
    contacts = turn_from_setup(machine.coordinates, np.array([one.contact for one in touches]))
    places = [machine.coordinates.map_from_table(tip, angles[1], line.frame) for tip in contacts]
    at = [float(place[axis]) for place in places]
    step = ROUND_MM if scale == 1.0 else _ROUND_INCH
    # half a step or more before the contact: bodies do not rub
    first = way * np.ceil(round(min(way * place for place in at) / scale / step, 6) - 1.5) * step
    lines = bytes(source).split(b"\n")
    said = lines[line.number - 1].decode("utf-8", errors="replace")
    word = find_word_of(said, "XYZ"[axis], float(end[axis]) / scale)
    if word is None:
        return None
    for then in first - way * step * np.arange(3):  # a contact begins within one cell
        if way * (then * scale - float(begin[axis])) < ROUND_MM:
            return None
        changed = change_number(said, word, format_number(then))
        text = b"\n".join([*lines[: line.number - 1], changed.encode(), *lines[line.number :]])
        try:
            found = check_program(assemble(text, machine, program.options, program.team), only_lines=True)[1]
        except InputError:
            return None
        left = (item for item in found if item.severity == "error")
        if not any(has_line(item, line.number) for item in left):
            return f"the line ended elsewhere: {'XYZ'[axis]} {format_number(then)} in place of {word[2]} {unit}"
    return None


# --- one number of the set-up --------------------------------------------------------------------------------


def _find_offset_of_control(program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """A work offset that no part can have, and that a control's offset page may: it counts from the machine's zero.

    The origin is deep below the table face and has negative X and Y. Where the machine file has another zero than the
    table, the message says where that origin is on the table.
    """
    moves, options = program.moves, program.options
    at = np.flatnonzero(moves.line == min((item.line or 0 for item in errors), default=0))
    if not len(at) or program.machine.table_radius <= 0:
        return None
    frame = moves.frames[moves.frame[at[0]]]
    offset = options.wcs.get(frame.system)
    if offset is None or max(offset.origin_mm[:2]) >= 0 or offset.origin_mm[2] > -DEEP_MM:
        return None
    if not np.allclose(offset.origin_mm, program.machine.find_origin_on_table(frame), atol=LIMIT_SLACK_MM):
        return None  # the program sets its offset itself
    name, zero = name_system(frame.system), -np.array(program.machine.coordinates.work_origin((0.0, 0.0, 0.0)))
    text = (
        f"{NOT_TRIED}{name} = {format_list(offset.origin_mm)} is {-offset.origin_mm[2]:.6g} mm below the table face: "
        "these look like the machine coordinates of a control's offset page, and [wcs] is the place of the part on the "
        "table; "
    )
    if np.abs(zero).max() <= LIMIT_SLACK_MM:
        return Remedy(f"{text}measure it from the rotary centre on the table face")
    place = np.round(zero + np.array(offset.origin_mm), 6)
    return Remedy(
        f"{text}the machine zero of the machine file, {format_list(zero)}, plus these numbers is {name} = "
        f"{format_list(place)}: use it if the control counts from that zero, else measure it"
    )


def _find_slip_of_setup(source: Text, program: Program, errors: Sequence[Finding], *, is_far: bool) -> Remedy | None:
    """A sign of the work offset, or a point of it or of the tool length, that alone is at fault; checked with it.

    Parameters
    ----------
    is_far : bool
        No work offset near this one brings the program within limits: a number may be ten times too large or small.
    """
    moves, options = program.moves, program.options
    at = np.flatnonzero(moves.line == min((item.line or 0 for item in errors), default=0))
    if not len(at):
        return None
    system = moves.frames[moves.frame[at[0]]].system
    number = int(find_tool_of_moves(at[:1], 0, moves)[0])
    tool, offset = (options.tools or {}).get(number), options.wcs.get(system)
    factors = (0.1, 10.0) if is_far else ()
    if tool is not None and tool.offset[2] and options.tool_length is None:
        x, y, now, a, b, c, u, v, w = tool.offset
        for length in (now * factor for factor in factors):
            tools = {
                **(options.tools or {}),
                number: dataclasses.replace(tool, offset=(x, y, length, a, b, c, u, v, w)),
            }
            if _is_right_with(source, program, tools=tools):
                tool_name = describe_tool_number(number, moves.name_tools())
                text = (
                    f"within limits if the set-up gives {tool_name} the length {length:.6g} instead of {now:.6g}: is "
                    "a decimal point missing, or another unit meant?"
                )
                return Remedy(text, f"{length:.6g}", key=("tools", str(number), "length"))
    if offset is None or offset.source.startswith("--"):  # who gives an option has just looked at it
        return None
    for axis, value in enumerate(offset.origin_mm):
        for right in [*([-value] if axis == 2 and value < 0 else []), *(value * factor for factor in factors if value)]:
            x, y, z = (right if one == axis else float(now) for one, now in enumerate(offset.origin_mm))
            wcs = {**options.wcs, system: dataclasses.replace(offset, origin_mm=(x, y, z))}
            if _is_right_with(source, program, wcs=wcs):
                name, turn = name_system(system), [offset.turn_deg] if offset.turn_deg else []
                given, then = (format_list((*one, *turn)) for one in (offset.origin_mm, (x, y, z)))
                source_name = f" of {offset.source}" if offset.source else ""
                what = "a sign" if right == -value else "a decimal point"
                text = f"within limits if {name} = {then} instead of {given}{source_name}: is {what} wrong there?"
                return Remedy(text, f"[{then}]", key=("wcs", name))
    return None


# --- a work offset for the whole program -----------------------------------------------------------------


def _say_no_offset(options: Options, tried: Sequence[WorkOffset]) -> Remedy:
    """That no move of the part was found, and which were tried."""
    named = "; ".join(format_list(one.origin_mm) for one in list(dict.fromkeys(tried))[:_NAMED_PLACES])
    with_them = f" (tried: {named})" if named else ""
    fit = find_run(options).spell("fit", options.source_name)
    return Remedy(
        f"{NOTHING_FOUND} was found that brings the program within limits{with_them}; `{fit}` "
        "seeks one over the whole table"
    )


def _find_offset(
    source: Text, program: Program, errors: Sequence[Finding], tried: list[WorkOffset], farthest: float
) -> tuple[Remedy, float] | None:
    """A work offset, as an option, with which the whole program was checked, and how far it moves the part, mm.

    Those that did not help are added to ``tried``.
    """
    best: tuple[int, float] = (len(CODES), np.inf)
    for one in find_legal_offsets(source, program, errors, tried=tried, farthest=farthest):
        given = program.options.wcs.get(one[0])
        moved_there = np.array(one[1].origin_mm) - np.array(given.origin_mm if given else (0.0, 0.0, 0.0))
        distance = float(np.linalg.norm(moved_there))
        if (len(one[2]), RAISED * distance) < best:
            best, moved_mm, (system, offset, left) = (len(one[2]), distance), moved_there, one
        if distance <= NEAR_MM:
            break
    if not np.isfinite(best[1]):
        return None
    offset, moved_mm = _leave_out_traces(source, program, system, offset, moved_mm, left)
    name = name_system(system)
    then = format_list((*offset.origin_mm, *([offset.turn_deg] if offset.turn_deg else [])))
    moved = f"if the part is moved by {format_list(moved_mm)} mm (then {name} = {then})"
    none_given = "no work offset was given; " if given is None else ""
    what = f"the other errors are gone {moved}; {_name_left(left)}" if left else f"within limits {moved}"
    return Remedy(f"{none_given}{what}", f"[{then}]", key=("wcs", name)), best[1]


def _leave_out_traces(
    source: Text, program: Program, system: int, offset: WorkOffset, moved: Array, left: Sequence[str]
) -> tuple[WorkOffset, Array]:
    """A work offset, and its move (3,), mm, without small components that the program does not need."""
    for axis in np.argsort(np.abs(moved))[:2].tolist():
        if not 0.0 < abs(moved[axis]) <= TRACE * np.abs(moved).max():
            continue
        less = np.where(np.arange(3) == axis, 0.0, moved)
        x, y, z = (round(float(value), 6) for value in np.array(offset.origin_mm) - moved + less)
        there = dataclasses.replace(offset, origin_mm=(x, y, z))
        found = _find_errors_with(source, program, wcs={**program.options.wcs, system: there})
        if found is not None and set(found) <= set(left):
            offset, moved = there, less
    return offset, moved


def find_legal_offsets(
    source: Text,
    program: Program,
    errors: Sequence[Finding],
    free: str = "xyz",
    tried: list[WorkOffset] | None = None,
    farthest: float = FARTHEST_MM,
) -> Iterator[tuple[int, WorkOffset, tuple[str, ...]]]:
    """Work offsets with no errors left but tilt and rotary travel: the system, the offset, the codes that are left.

    The part is moved along its z first, then along all of the axes in ``free``. ``tried`` grows by every place.
    """
    tried = [] if tried is None else tried
    concerned = _select_movable_errors(program, _list_errors(errors))
    first = _find_line(program, guard_joints(program), concerned[0].line) if concerned else None
    if first is None or len(program.contour) > TRIED_ELEMENTS:
        return
    system, turn = first.frame.system, first.frame.part_turn
    given = program.options.wcs.get(system)
    origin = np.array(given.origin_mm if given else (0.0, 0.0, 0.0))
    if np.abs(origin - np.array(program.machine.find_origin_on_table(first.frame))).max() > LIMIT_SLACK_MM:
        return  # the program sets its offset itself: no option moves it
    axes = ["xyz".index(letter) for letter in free if letter in "xyz"]
    for moved in dict.fromkeys((tuple({2}.intersection(axes)), tuple(axes))):
        basis = program.machine.coordinates.part_frame.T[list(moved)]
        where = (origin, system, turn, concerned, basis, tried, farthest)
        found = _find_legal_origin(source, program, *where) if moved else None
        if found is not None:
            (x, y, z), left = found
            yield system, WorkOffset((float(x), float(y), float(z)), turn), left


def _find_legal_origin(
    source: Text,
    program: Program,
    origin: Array,
    system: int,
    turn: float,
    errors: Sequence[Finding],
    basis: Array,
    tried: list[WorkOffset],
    farthest: float,
) -> tuple[Array, tuple[str, ...]] | None:
    """An origin (3,) with no errors left but tilt and rotary travel, and their codes; None if none is found."""
    there, place, concerned = program, origin, list(errors)
    for _ in range(OFFSETS):
        worst = max(concerned, key=find_excess)
        line = _find_line(there, guard_joints(there), worst.worst_line or worst.line)
        shift = None if line is None else find_smallest_shift(line.joints, basis, farthest=farthest)
        if shift is None:
            return None
        step = turn_to_setup(program.machine.coordinates, np.array(shift.vector))
        if not step.any():  # the line alone is within limits: a corner beside it, which is rounded, is not
            step = ROUND_MM * np.sign(place - origin)
            step = step if step.any() else ROUND_MM * np.array([0.0, 0.0, float(worst.code == "VP210")])
        moved = place + step - origin
        place = origin + np.sign(moved) * np.ceil(np.round(np.abs(moved) / ROUND_MM, 6)) * ROUND_MM
        if np.linalg.norm(place - origin) > farthest:
            return None
        x, y, z = (round(float(value), 6) for value in place)
        tried.append(WorkOffset((x, y, z), turn))
        wcs = {**program.options.wcs, system: tried[-1]}
        try:
            there = assemble(source, program.machine, program.options.changed(wcs=wcs), program.team)
            found = [item for item in check_program(there)[1] if item.severity == "error"]
        except InputError:
            return None
        concerned = _select_movable_errors(there, found)
        if not concerned:
            return place, tuple(dict.fromkeys(item.code for item in found))
    return None


def _select_movable_errors(program: Program, errors: Sequence[Finding]) -> list[Finding]:
    """Errors that a move of the part may cure."""
    others = (*ROTARY_CODES, *_OPTIONS)
    return [
        item for item in errors if item.code not in others and item.line and not _find_line_in_machine(program, item)
    ]


def _find_line_in_machine(program: Program, item: Finding) -> int:
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
