"""One line of a program explained, on the same contour and by the same check as ``check`` and ``convert``."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import (
    Program,
    assemble,
    build_interpreter_setup,
    count_executions,
    find_called_state,
    find_modal_state,
    find_state_if_executed,
)
from verne_post.app.constraints import check_line, check_program, guard_joints
from verne_post.app.explain_line import (
    add_line_remedies,
    describe_modes,
    explain_findings,
    explain_line,
    find_lines_near,
    work_through,
)
from verne_post.app.line_facts import describe_time, measure_lines
from verne_post.app.plan import plan_program
from verne_post.app.remedies.contacts import name_heights, propose_heights, propose_stick_out
from verne_post.app.remedies.lines import Line
from verne_post.app.remedies.meant_motion import find_meant_motion
from verne_post.app.remedies.refused import find_offset_before
from verne_post.app.remedies.retracts import add_retract, find_missing_retract, find_turn
from verne_post.app.remedies.trials import build_trial, is_short
from verne_post.app.remedies.words import find_end_before_contact, find_flipped_axis, find_forgotten_feed
from verne_post.app.start_lines import quote_start
from verne_post.base.long_text import Text, iterate_lines, take_line
from verne_post.base.program_lines import remove_remarks
from verne_post.base.suggestions import explain_names
from verne_post.base.text_tables import format_html_sections
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.known_words import name_axes
from verne_post.gcode.machining.state import State
from verne_post.gcode.pasted_line import find_words
from verne_post.gcode.read import find_state_past_errors
from verne_post.kinematics.checks.remedies import select_line
from verne_post.model.findings import Finding, InputError, UsageError
from verne_post.model.machine import Machine
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options
from verne_post.model.verdict import find_worst, is_about_pose
from verne_post.output.commands import find_run
from verne_post.output.findings import describe_remedy
from verne_post.toolpath.contour import make_exact_contour
from verne_post.trajectory.override import build_feed_override


@explain_names()
@dataclasses.dataclass(frozen=True, repr=False)
class Explanation:
    """One line of a program worked through.

    Attributes
    ----------
    line : int
        1-based source line; 0 is the approach.
    findings : tuple of Finding
        Of this line.
    text : str
        Words, findings with remedies, and the pose at the end of the line: what a person asks first.
    working : str
        Every step from words to joints, all margins of both table solutions, and every solution of the machine. Empty
        for a line without motion.
    """

    line: int
    findings: tuple[Finding, ...]
    text: str
    working: str

    def __repr__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return format_html_sections(self.text)


def explain_source(
    source: Text, machine: Machine, options: Options, line: int, tell: Callable[[str], None] | None = None
) -> Explanation:
    """Explain one line of a program.

    ``tell`` gets the beginning of the text, up to the findings, before remedies are sought, which may take longer.

    Raises
    ------
    InputError
        The program cannot be read.
    UsageError
        The program has no such line.
    """
    program = assemble(source, machine, options)
    build_feed_override(
        options.override, options.slow_start, machine.limits
    )  # refuses too short a slow start, as check does
    text = take_line(source, line) if line else None
    if line and text is None:
        raise _make_line_error(source, line)
    if text is not None and not len(select_line(guard_joints(program), line).contour):
        return _explain_words(source, program, line, text.decode("utf-8", errors="replace").strip())
    shown = look_at_line(source, program, line)
    shown = _plan_line(program, shown)
    if tell is not None:
        tell("\n".join(explain_findings(shown)) + "\n")
    shown = _add_remedies(source, program, shown)
    return Explanation(line, shown.findings, *("\n".join(part(shown)) + "\n" for part in (explain_line, work_through)))


def _add_remedies(source: Text, program: Program, shown: Line) -> Line:
    """The same line, with what would bring it within limits; another place is no cure of a motion that is not meant."""
    meant = find_meant_motion(source, program, shown.findings) or find_flipped_axis(source, program, shown.findings)
    turns = meant is None and any(find_turn(program, item) for item in shown.findings)
    if turns and (retract := find_missing_retract(source, program, check_program(program)[1])) is not None:
        cured = tuple(add_retract(shown.findings, retract))
        if any(item.remedies for item in cured):
            return replace(shown, findings=cured)
    if meant is None:
        return _add_contact_remedies(source, program, add_line_remedies(shown, build_trial(source, program, shown)))
    cures = tuple(filter(None, (meant.text, find_offset_before(source, program, meant, shown.number))))
    told = (dataclasses.replace(item, remedies=cures) if item.severity == "error" else item for item in shown.findings)
    return replace(shown, findings=tuple(told))


def _add_contact_remedies(source: Text, program: Program, shown: Line) -> Line:
    """The same line; contacts with the stock have what only the whole program can be asked."""
    is_told = any("ended elsewhere" in text for one in shown.findings for text in one.remedies)
    end = None if is_told else find_end_before_contact(source, program, shown)
    errors = [item for item in shown.findings if item.severity == "error" and is_about_pose(item.code)]
    feed = find_forgotten_feed(source, program, errors) if errors and is_short(program) else None
    told = []
    for item in shown.findings:
        if item.code == "VP216":
            more = [] if feed is None else [feed.text]
            more += [one.text for one in propose_heights(source, program, shown, item)]
            if (longer := propose_stick_out(source, program, shown, item)) is not None:
                more.append(longer.text)
            more += filter(None, [end])
            item = dataclasses.replace(item, remedies=(*more, *item.remedies))
        told.append(item)
    return replace(shown, findings=tuple(told), tried_heights=name_heights(source, program, shown))


def _plan_line(program: Program, shown: Line) -> Line:
    """The line with its time and the feed rate that it reaches, or why there is none: that it takes too long."""
    refused = replace(shown, planned="not planned: the program is refused")
    if find_worst(shown.findings) == "error":
        return refused
    try:
        plan = plan_program(program, only_first=True)
    except InputError as error:
        too_long = (item for item in error.findings if item.code == "VP035" and item.line == shown.number)
        return replace(refused, findings=(*shown.findings, *too_long))
    return replace(shown, planned=describe_time(plan, measure_lines(plan), shown.number))


def _explain_words(source: Text, program: Program, line: int, text: str) -> Explanation:
    """A line without motion: its words, what is found in its text, and what holds after it."""
    options, machine = program.options, program.machine
    dialect = choose_dialect_name(options.dialect, source, options.source_name)
    findings = tuple(item for item in program.findings if item.line == line)
    nearest = find_lines_near(guard_joints(program), line)
    near = " and ".join(map(str, nearest))
    said = [f"line {line}: {text}", f"  no motion{_say_why_still(program, line)}; the nearest lines that have: {near}"]
    said += _list_words(source, line, text, dialect, machine, options.remap)
    said += [f"  {item.code} {item.severity}: {item.full_message}" for item in findings]
    state = find_state_if_executed(source, program, line)
    if not remove_remarks(text, dialect).strip():
        said.append("  nothing to execute: a remark, or an empty line")
    elif state is None:
        said.append("  the program itself does not come to this line")
    else:
        said.append(f"  {describe_modes(state, program.machine, with_values=True)}")
    if nearest and nearest[-1] > line:
        begun = look_at_line(source, program, nearest[-1])
        first = add_line_remedies(begun, build_trial(source, program, begun))
        start = [item for item in quote_start(source, program, first.findings) if item.line == line]
        if start:  # check has named this line
            said += ["  the program starts at the place that this line names, and moves from there:", ""]
            said += explain_line(first)
            working = "\n".join(work_through(first)) + "\n"
            return Explanation(line, (*findings, *start), "\n".join(said) + "\n", working)
    return Explanation(line, findings, "\n".join(said) + "\n", "")


def _list_words(
    source: Text, line: int, text: str, dialect: str, machine: Machine, remap: Mapping[str, str]
) -> list[str]:
    """The words of a line, each with what it does on a machine."""
    is_continued = _find_begin(source, line, dialect) < line
    words = find_words(text, dialect, is_continued=is_continued, remap=remap)
    written_words = [" ".join(text[word.begin : word.end].upper().split()) for word in words]
    return [
        f"  {written:<20} {name_axes(word.text, machine.rotary_letters)}"
        for written, word in zip(written_words, words, strict=True)
    ]


def _find_begin(source: Text, line: int, dialect: str) -> int:
    """The line that begins the statement of a line: in Klartext, it may run over several."""
    while line > 1 and dialect == "heidenhain" and (take_line(source, line - 1) or b"").rstrip().endswith(b"~"):
        line -= 1
    return line


def _make_line_error(source: Text, line: int) -> UsageError:
    last = max((number for number, text in enumerate(iterate_lines(source), start=1) if text.strip()), default=0)
    return UsageError("line", f"line {line} is after the end of the program, whose last line is {last}")


def _say_why_still(program: Program, line: int) -> str:
    """Why a line that names a place moves nothing; empty for other lines."""
    moves = program.moves
    own = np.flatnonzero((moves.line == line) & (moves.kind != MoveKind.DWELL))
    if not len(own):
        return ""
    if own[-1] < program.path.moves_with_length[0]:
        return ": the line names the place where the program starts"
    return ": the machine is already at the place that the line names"


def explain_refused(
    source: Text, machine: Machine, options: Options, line: int, findings: Sequence[Finding]
) -> Explanation:
    """A line of a program that cannot be read: its words, its findings, and how many others the program has.

    Raises
    ------
    UsageError
    """
    text = take_line(source, line)
    if text is None:
        raise _make_line_error(source, line)
    shown = text.decode("utf-8", errors="replace").strip()
    dialect, name = choose_dialect_name(options.dialect, source, options.source_name), options.source_name
    own = [item for item in findings if item.line in (line, None)]
    said = [f"line {line}: {shown}"]
    said += _list_words(source, line, shown, dialect, machine, options.remap)
    said += [f"  {item.code} {item.severity}: {item.full_message}" for item in own]
    for item in {item.code: item for item in own}.values():
        if remedy := describe_remedy(item, name, find_run(options)):
            said.append(f"  {item.code}, remedy: {remedy}")
    errors = [item for item in findings if item.severity == "error" and item.line is not None]
    if errors and not any(item.severity == "error" for item in own):
        start = _find_begin(source, line, dialect)  # what runs over several lines is told at its first one
        cause = next((item for item in errors if item.line == start), None)
        said.append(f"  part of line {start}, which has the error" if cause else "  no error is found in its words")
        first = cause or min(errors, key=lambda item: item.line or 0)
        said.append(
            f"  limits were not checked, because line {first.line} cannot be executed: "
            f"{first.code} {first.full_message}"
        )
    state, _call = find_state_past_errors(source, build_interpreter_setup(machine, options), line)
    is_sure = all((item.line or 0) >= line for item in errors)
    said += [] if state is None else [f"  {describe_modes(state, machine, with_values=is_sure)}"]
    if others := [item.line for item in findings if item.line not in (line, None) and item.severity == "error"]:
        counted = f"{len(others)} other error{'' if len(others) == 1 else 's'}"
        whole = find_run(options).spell("check", name)
        said.append(f"the program has {counted}, the first in line {min(others)}: {whole} shows all")
    return Explanation(line, tuple(own), "\n".join(said) + "\n", "")


def look_at_line(source: Text, program: Program, line: int) -> Line:
    """What there is to say about one line of a program.

    Raises
    ------
    UsageError
        For a line without motion.
    """
    whole = guard_joints(program)
    joints = select_line(whole, line)
    if not len(joints.contour) and line == 0:
        raise UsageError("line", "lines of a program count from 1; line 0 is the approach (--from), and none is given")
    if not len(joints.contour):
        near = " and ".join(str(one) for one in find_lines_near(whole, line))
        raise UsageError("line", f"line {line} has no motion; the nearest lines that have: {near}")
    text = b"" if line == 0 else take_line(source, line) or b""
    state, count = (None, 0) if line == 0 else find_modal_state(source, program, line)
    exact = select_line(replace(whole, contour=make_exact_contour(program.path)), line)
    findings = tuple(check_line(program, joints, line))
    words = text.decode("utf-8", errors="replace")
    shown = Line(line, words, joints, program.moves, state, program.options, findings, exact, count)
    # a move that waits for the next line, as before a corner, is one of the pass
    is_once = shown.is_repeated and count_executions(source, program, line) == 1
    return replace(shown, n_recorded=int(shown.rows[-1]) + 1) if is_once else shown


def look_at_called_line(
    source: Text, program: Program, file: str, line: int, text: str
) -> tuple[State, Line | None, int] | None:
    """The state after the first execution of a line of a called file, its motion, and the line that calls the file.

    None where the program does not come to it. Without motion is a line that makes none, and one whose motion waits for
    later lines, as before a corner.
    """
    found = find_called_state(source, program, file, line)
    if found is None:
        return None
    state, made, call = found
    whole, exact = program.build_joint_path(), make_exact_contour(program.path)
    own = np.flatnonzero(np.isin(exact.path.move[exact.segment], made))
    end = np.array(state.position)
    if not len(own) or np.abs(program.moves.end[made[-1], :3] - end[:3]).max() > ZERO_LENGTH_MM:
        return state, None, call
    joints = replace(whole, contour=exact.select(own))
    return state, Line(line, text, joints, program.moves, state, program.options, (), joints, made.stop), call
