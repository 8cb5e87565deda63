"""What would bring a refused program within limits: every remedy is tried on the program before it is reported.

A work offset and an option are tried on the whole program; a tilt, another branch and another end on their line.
"""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from verne_post.app.assemble import Program, build_interpreter_setup
from verne_post.app.constraints import check_program, guard_joints
from verne_post.app.explain_numbers import format_number
from verne_post.app.remedies.contacts import propose_heights
from verne_post.app.remedies.lines import (
    CONTACTS,
    describe_plane,
    meets_in_rapid,
    propose_ends,
    propose_lift,
    propose_turns,
)
from verne_post.app.remedies.meant_motion import find_meant_motion
from verne_post.app.remedies.retracts import add_retract, find_missing_retract, find_turn
from verne_post.app.remedies.setup import (
    FAR_MM,
    find_offset,
    find_offset_of_control,
    find_slip_of_setup,
    say_no_offset,
)
from verne_post.app.remedies.trials import (
    CURING_OPTIONS,
    build_trial,
    find_code_of_line,
    find_codes_with,
    find_line,
    find_line_in_machine,
    is_carried_with_part,
    is_short,
    list_errors,
    name_left,
)
from verne_post.app.remedies.words import (
    find_flipped_axis,
    find_forgotten_feed,
    find_forgotten_g91,
    find_lost_point,
    find_too_deep,
    find_wrong_word,
)
from verne_post.base.long_text import Text
from verne_post.gcode.inch_words import read_as_mm
from verne_post.kinematics.checks.remedies import (
    FARTHEST_MM,
    ROTARY_CODES,
)
from verne_post.model.findings import (
    NOT_TRIED,
    Finding,
    Remedy,
    list_lines,
    make_finding,
)
from verne_post.model.part_setup import MACHINE_SYSTEM, WorkOffset, name_system
from verne_post.model.verdict import NO_POSE, Family, find_family, is_about_pose
from verne_post.toolpath.branch_choice import DEPARTURE

#: Findings of a program that are given remedies, the gravest place of each: the others mostly follow from them.
REMEDIED: Final = 3
#: Asked of a program in inches that leaves the machine, and in mm only goes below the table face.
_TOO_LOW: Final = ", and a higher work offset?"


def add_remedies(source: Text, program: Program, findings: Sequence[Finding]) -> list[Finding]:
    """The findings of a refused program, the first errors with the remedies that were tried and hold.

    Where the unit, or the machine file, is what is wrong, all findings about poses are that one.

    Parameters
    ----------
    findings : sequence of Finding
        Of the whole program, as :func:`check_program` returns them.
    """
    errors = list_errors(findings)
    if not errors:
        return list(findings)
    if (unreachable := _find_unreachable(program, errors)) is not None:
        return _put_cause(unreachable, findings)
    joints = guard_joints(program)
    is_tried = is_short(program)
    movable = [item for item in errors if not find_line_in_machine(program, item)]
    meant = find_meant_motion(source, program, findings)
    if meant is None:
        meant = find_flipped_axis(source, program, errors)
    retract = find_missing_retract(source, program, findings) if meant is None else None
    if retract is not None and retract.cures_all:
        return add_retract(findings, retract)
    can_help = is_tried and meant is None and not all(is_carried_with_part(program, joints, item) for item in movable)
    before = [] if meant is None else list_errors_before(program, errors, meant)
    in_inches = _find_mistaken_unit(source, program, errors)
    places: list[WorkOffset] = []
    # where the part is too low in mm too, its place is wrong, and the unit only if no place helps
    too_low = in_inches is not None and in_inches.message.endswith(_TOO_LOW)
    farthest = FARTHEST_MM if in_inches is None or too_low else FAR_MM
    of_control = find_offset_of_control(program, movable) if can_help else None
    seeks = of_control is None and (can_help or before)
    found = find_offset(source, program, movable, places, farthest) if seeks else None
    nothing = say_no_offset(program.options, places)
    offset, distance = found or (None, np.inf)
    if in_inches is not None and (distance == np.inf and seeks if too_low else distance > FAR_MM):
        return _put_cause(in_inches, [one for one in findings if not _is_about_unit(one)])
    word = None
    if is_tried and meant is None:
        word = find_forgotten_g91(source, program, errors) or find_forgotten_feed(source, program, errors)
        word = word or find_lost_point(source, program, errors)
        word = word or find_too_deep(source, program, errors) or find_wrong_word(source, program, joints, errors)
    if can_help:  # a sign explains a part under the table better than a word of the program does
        is_far = offset is None and word is None
        word = of_control or find_slip_of_setup(source, program, movable, is_far=is_far) or word
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
            fixed_line = find_line_in_machine(program, item)
            code = find_code_of_line(source, program, fixed_line)
            is_turn = not code and find_turn(program, item) is not None  # no word of the line says where it goes
            if fixed_line and item.code not in (*ROTARY_CODES, *CURING_OPTIONS) and not is_turn:
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
    errors = list_errors(findings)
    if errors and (unreachable := _find_unreachable(program, errors)) is not None:
        return _put_cause(unreachable, findings)
    if not errors or _find_mistaken_unit(source, program, errors) is None:
        return list(findings)
    return add_remedies(source, program, findings)


def list_errors_before(program: Program, findings: Sequence[Finding], meant: Remedy) -> list[Finding]:
    """Errors that begin before the motion that is doubted: they are not of it alone, and another place may cure them.

    ``meant``: as :func:`find_meant_motion` returns it.
    """
    begun = (item for item in list_errors(findings) if (item.line or 0) < meant.line)
    return [item for item in begun if not find_line_in_machine(program, item)]


def find_offset_before(source: Text, program: Program, meant: Remedy, line: int) -> str | None:
    """The work offset that ``check`` names for an error of a line which begins before the motion that is doubted."""
    errors = list_errors(check_program(program)[1])
    if not any(line in list_lines(item) for item in list_errors_before(program, errors, meant)):
        return None
    movable = [item for item in errors if not find_line_in_machine(program, item)]
    found = find_offset(source, program, movable, [], FARTHEST_MM)
    return None if found is None else found[0].text


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


def _find_mistaken_unit(source: Text, program: Program, errors: Sequence[Finding]) -> Finding | None:
    """VP505, an error: a program in inches leaves the machine, and in mm no pose of it is refused; else None.

    The reverse, inches that are read as mm, leaves no trace: a small part is within limits too.
    """
    if not is_short(program) or not any(find_family(item.code) == Family.POSITION for item in errors):
        return None
    found = read_as_mm(source, build_interpreter_setup(program.machine, program.options))
    if found is None:
        return None
    place, text = found
    left = find_codes_with(text, program, stock=None)  # a contact says nothing about the unit
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
        flag, change = CURING_OPTIONS.get(code, ("", {}))
        if not flag:
            continue
        left = find_codes_with(source, program, **change) if is_short(program) else None
        if left is not None and item.code not in left:
            what = f"removes this error; {name_left(left)}" if left else "brings the program within limits"
            yield Remedy(f"{flag} {what}", "true", key=tuple(change))
    if item.code in CURING_OPTIONS:
        return
    own = find_line(program, joints, item.line, source) if item.code in CONTACTS else None
    is_of_line = item.last_line == item.line  # a line alone is lifted
    if own is not None and is_of_line and (item.code == "VP215" or meets_in_rapid(own, [item])):
        for text in propose_lift(own, [item]):
            yield Remedy(f"line {own.number} alone: {text}")
    if offset.value and item.code not in ROTARY_CODES and not find_line_in_machine(program, item):
        yield offset
    elif find_family(item.code) != Family.BRANCH:
        line = find_line(program, joints, item.line, source)
        if line is not None:
            for one in propose_turns(line, [item], build_trial(source, program, line)):
                yield dataclasses.replace(one, text=f"line {line.number} alone: {one.text}")
        moves = line is not None or item.code not in CONTACTS  # not where it starts: an offset does not say how it came
        tried = moves and item.code not in ROTARY_CODES and is_short(program)
        if tried and not find_line_in_machine(program, item) and not is_carried_with_part(program, joints, item):
            yield offset


def list_ends(source: Text, program: Program, item: Finding) -> list[Remedy]:
    """Other numbers for X, Y or Z of the first line of an error, or for a height of its cycle, each an edit.

    They take ten times as long as the check: an editor asks for them, and in words `explain` of the line has them.
    """
    others = item.code in (*ROTARY_CODES, *CURING_OPTIONS) or find_family(item.code) == Family.BRANCH
    if item.severity != "error" or not is_about_pose(item.code) or others:
        return []
    line = find_line(program, guard_joints(program), item.line, source)
    if line is None:
        return []
    ends = list(propose_ends(line, [item], warnings=False))
    deep = [one for one in ends if one.word[0] == "Z" and one.word[1] < 0.0]
    # a Z below the part may have a sign too many: whoever asks tries the edit
    unsigned = [dataclasses.replace(one, value=format_number(-one.word[1]), is_choice=True) for one in deep]
    return [*propose_heights(source, program, line, item), *unsigned, *ends]
