"""A whole program -> Moves: its dialect, every error, and where it starts."""

import math
import re
from contextlib import suppress
from dataclasses import replace
from typing import Final

import numpy as np
from msgspec import structs

from verne_post.base.long_text import Text, take_line
from verne_post.base.program_lines import find_word_of
from verne_post.base.suggestions import find_correction
from verne_post.base.tolerances import DIAMETER_SLACK_MM
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.dialects import DIALECTS, choose_dialect, choose_dialect_name, name_dialect
from verne_post.gcode.execution import MAX_ERRORS, Execution, LineTrace, StopConditions
from verne_post.gcode.languages import find_other_language
from verne_post.gcode.machining.state import State
from verne_post.gcode.machining.watcher import place_at_plane, report_kept_planes
from verne_post.gcode.missing_setup import report_missing_offsets
from verne_post.gcode.mistyped import UNREADABLE, say_what_is_meant
from verne_post.gcode.parameters import Parameters
from verne_post.gcode.program_error import IS_SUBPROGRAM
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.remarked_diameters import list_remarked_diameters
from verne_post.gcode.setup import Setup
from verne_post.gcode.start import find_start
from verne_post.gcode.subprograms import explain_subprogram, has_own_tool, keep_one
from verne_post.gcode.text import decode_line
from verne_post.model.findings import Finding, InputError, Remedy
from verne_post.model.moves import Frame, Moves
from verne_post.model.part_setup import describe_tool_number, list_setup_names

#: Codes of errors about words that another dialect may have.
_ABOUT_WORDS: Final = ("VP002", "VP003", "VP006")
#: Errors that follow where an incremental word (G91 in place of G90) leaves it open where the axes stand.
_OF_POSITIONS: Final = ("VP008", "VP013", "VP017", "VP025", "VP026")
#: Warnings about the words of a line, which hold wherever the axes stand, and whichever tool is in the spindle.
_OF_WORDS: Final = ("VP004", "VP007", "VP038", "VP044")
#: Errors that a line has whether or not the program comes to it.
_OF_A_LINE: Final = ("VP001", "VP002", "VP003", "VP004", "VP023")
#: So many blocks are repeated after an error, which may have left a loop without an end.
_MOST_REPEATS: Final = 100_000
#: So many errors are tried with the other side of the contour, or another diameter, each by reading the program again.
_MOST_SIDES: Final = 3
#: Of arcs, as edits have them: no side of a contour.
_SENSES: Final = ("2", "3", "DR+", "DR-")
#: The tool that an error is about, and its diameter.
_WIDTH: Final = re.compile(r"(tool (?:\d++|\"[^\"]*+\")(?: \"[^\"]*+\")?) \(diameter (\S++) mm\)")
_CORRECT_DIAMETER: Final = "Correct the diameter in the set-up or the tool table, in the tool shapes, or in the remark."


def interpret_program(source: Text, setup: Setup) -> Moves:
    """Interpret a program.

    Parameters
    ----------
    source : Text
        Text in the dialect that the setup names, or that is recognised.
    setup : Setup
        Coordinates, tools, offsets.

    Returns
    -------
    Moves

    Raises
    ------
    InputError
        With every error that could be found (VP0xx).
    """
    dialect = choose_dialect(setup.dialect, source, setup.source_name)
    state, unsaid = dialect.initial_state(setup), None
    if setup.machine:
        try:
            state.position, unsaid = find_start(source, setup, dialect)
        except InputError as error:  # report what else is wrong, after the opening lines
            state.known_axes = [True] * 9
            execution = dialect.execute(source, setup, state, StopConditions())
            errors = _add_hidden_errors(source, setup, execution)
            seen_errors = {(item.line, item.code) for item in errors}
            every = [*errors, *(item for item in error.findings if (item.line, item.code) not in seen_errors)]
            lost_line = min(
                (item.line or 0 for item in error.findings if item.code == "VP013" and item.column), default=math.inf
            )
            every = [item for item in every if item.code not in _OF_POSITIONS or (item.line or 0) <= lost_line]
            every += [item for item in execution.recorder.warnings.values() if item.code in _OF_WORDS]
            raise _make_refusal(source, every, dialect, execution, setup) from None
        state.known_axes = [True] * 9
    start, start_frame = list(state.position), state.frame
    execution = dialect.execute(source, setup, state, StopConditions())
    if unsaid is not None:
        finding, execution.recorder.assumed_axes = unsaid
        execution.recorder.warnings[finding.line or 0, finding.code] = finding
    if execution.errors:
        # after an error neither the axes, the tools nor the motion need be what the program means
        first = min((item.line for item in execution.errors if item.line), default=math.inf)
        unread_line = min((item.line or 0 for item in execution.errors if item.code in UNREADABLE), default=math.inf)
        warnings = [
            one
            for one in execution.recorder.warnings.values()
            if not (one.code in ("VP009", "VP041", "VP046") and (one.line or 0) >= first)
            and not (one.code in ("VP024", "VP025") and (one.line or 0) >= unread_line)  # M300 for M30
            and one.code != "VP023"  # the call of a cycle may be what is wrong
        ]
        found = _add_hidden_errors(source, setup, execution)
        raise _make_refusal(source, [*found, *warnings], dialect, execution, setup)
    return execution.recorder.freeze(start, start_frame, Parameters(setup, state).list_persistent())


def interpret_until_error(source: Text, setup: Setup) -> tuple[Moves, tuple[Finding, ...]]:
    """As :func:`interpret_program`, without a machine: the moves before the first error, and the errors."""
    dialect = choose_dialect(setup.dialect, source, setup.source_name)
    state = dialect.initial_state(setup)
    start, frame = list(state.position), state.frame
    execution = dialect.execute(source, setup, state, StopConditions(first_error=True))
    errors = execution.errors
    if errors:
        every = dialect.execute(source, setup, dialect.initial_state(setup), StopConditions()).errors
        errors = _find_cause(source, errors, dialect, setup, every)
    return execution.recorder.freeze(start, frame, Parameters(setup, state).list_persistent()), tuple(errors)


def read_past_errors(source: Text, setup: Setup) -> tuple[Moves, tuple[Finding, ...]]:
    """The moves of a program with errors, and what of a set-up it lacks, in lines that an error hides as well.

    The order of those lines is that of the text: what it needs is found, and not what it does.
    """
    start, frame, execution = _execute_past_errors(source, setup, StopConditions(past_errors=True))
    moves = execution.recorder.freeze(start, frame, {})
    found = [item for item in execution.errors if item.settled_by]
    return moves, (*found, *report_missing_offsets(moves, setup))


def _add_hidden_errors(source: Text, setup: Setup, execution: Execution) -> list[Finding]:
    """Errors of a program, with those that later lines have by themselves where a jump or a call leads nowhere.

    A later line may be one that the program passes over: what it would do is not asked, only whether it can be read,
    and whether its tools are known.
    """
    if not execution.is_lost:
        return execution.errors
    found_errors = {(item.line, item.code, item.column): item for item in execution.errors}
    misspelt_ends = {edit.line for item in execution.errors if item.code == "VP023" for edit in item.edits}
    for item in _execute_past_errors(source, setup, StopConditions(past_errors=True))[2].errors:
        key = item.line, item.code, item.column  # one of several lines counts the later ones too
        is_independent = item.line not in misspelt_ends and (item.code in _OF_A_LINE or item.settled_by)
        if key in found_errors or is_independent:
            found_errors[key] = item
    return list(found_errors.values())[:MAX_ERRORS]


def find_state_past_errors(source: Text, setup: Setup, line: int, file: str | None = None) -> tuple[State | None, int]:
    """The modal state after a line of a program with errors; None where the program itself does not come to the line.

    Of a line with an error, what could be read of it holds. The line may be one of a called ``file``: then the line of
    the program from which that is called comes with the state.
    """
    stop = StopConditions(past_errors=True, after_line=line, file=file, trace=(trace := LineTrace()))
    execution = _execute_past_errors(source, setup, stop)[2]
    if file is not None:
        return (execution.state if trace.is_met else None), trace.met_call
    is_reached = any(first <= line < last for first, last, _may_restart in trace.spans)
    return (execution.state if is_reached or any(item.line == line for item in execution.errors) else None), 0


def _execute_past_errors(source: Text, setup: Setup, stop: StopConditions) -> tuple[list[float], Frame, Execution]:
    """Where a program with errors starts, the frame there, and the execution of all its lines."""
    dialect = choose_dialect(setup.dialect, source, setup.source_name)
    setup = structs.replace(setup, max_repeats=min(setup.max_repeats, _MOST_REPEATS))
    state = _make_placed_state(source, setup, dialect)
    start, frame = list(state.position), state.frame
    return start, frame, dialect.execute(source, setup, state, stop)


def _make_placed_state(source: Text, setup: Setup, dialect: Dialect) -> State:
    """The state before a program whose errors are asked for: where it starts, as far as that can be found."""
    state = dialect.initial_state(setup)
    with suppress(InputError):
        state.position, _unsaid = find_start(source, setup, dialect)
    state.known_axes = [True] * 9
    return state


def _find_cause(
    source: Text, errors: list[Finding], dialect: Dialect, setup: Setup, every: list[Finding] | None = None
) -> list[Finding]:
    """Errors in the order of their lines; one alone where the program is in another language.

    ``every``: those of the whole program, where ``errors`` end with the first.
    """
    other = find_language(source, every or errors, dialect)
    if other is not None:
        return [other]
    in_order = [_place_at_word(source, item) for item in sorted(errors, key=lambda item: item.line or 0)]
    in_order = _try_other_side(source, setup, in_order, every or in_order, dialect)
    called_texts = {setup.name_file(name, "ngc"): text for name, text in setup.subroutines.items()}
    found = say_what_is_meant(source, in_order, name_dialect(dialect), called_texts)
    return _show_rival(source, setup, found, every or found, dialect)


def _try_other_side(
    source: Text, setup: Setup, errors: list[Finding], every: list[Finding], dialect: Dialect
) -> list[Finding]:
    """Errors, of which those that the other side of the contour settles say so: the program has been read with it.

    It must have none but the others of ``every`` then. The first ones are tried. Where the diameter of the tool is in
    doubt, that is said, and no other side.
    """
    errors_before = {(item.line, item.code) for item in every}
    choices = [
        item
        for item in errors
        if item.code == "VP026" and item.edits and item.edits[0].is_choice and item.edits[0].value not in _SENSES
    ]
    by_finding: dict[int, Finding] = {}
    for item in errors:
        if (
            item.code == "VP026"
            and (about_size := _report_other_diameter(source, setup, item, every, dialect)) is not None
        ):
            by_finding[id(item)] = about_size
    choices = [item for item in choices if id(item) not in by_finding]
    for item in choices[:_MOST_SIDES]:
        other_text = _write_edit(source, item.edits[0])
        left = (
            errors_before
            if other_text is None
            else {(one.line, one.code) for one in _list_errors(other_text, setup, dialect)}
        )
        if left <= errors_before - {(item.line, item.code)}:
            word = item.edits[0].text.removeprefix("write ")
            text = f"{item.message}: with {word} in line {item.edits[0].line} the tool fits: is the side right?"
            by_finding[id(item)] = replace(item, message=text, advice="")  # one cause, one remedy
    untold = {id(item) for item in choices}
    return [by_finding.get(id(item), replace(item, edits=()) if id(item) in untold else item) for item in errors]


def _report_other_diameter(
    source: Text, setup: Setup, item: Finding, every: list[Finding], dialect: Dialect
) -> Finding | None:
    """An error about the width of a tool whose shape or remark has another diameter, which says so; else None.

    Where the tool fits with that diameter, it says this too: the program has been read with it.
    """
    width = _WIDTH.search(item.message)
    names = list_setup_names(setup.control)
    number = next((one for one in setup.tools or {} if width and describe_tool_number(one, names) == width[1]), 0)
    if width is None or not number or setup.tools is None:
        return None
    size, others = float(width[2]), dict[float, list[str]]()
    for part in setup.tool_shapes.get(number, ())[:1]:
        if min(abs(part.diameter - size), abs(part.widest - size)) > DIAMETER_SLACK_MM:
            others.setdefault(part.diameter, []).append(
                f"its cutter among the tool shapes is {part.diameter:g} mm thick"
            )
    remark_by_tool = list_remarked_diameters(source, choose_dialect_name(setup.dialect, source, setup.source_name))
    remark = remark_by_tool.get(str(number)) or remark_by_tool.get(names.get(number, ""))
    if remark is not None and remark.is_other_than(size):
        text = f"the program's remark{remark.describe_line()} names {remark.diameter:g} mm"
        others.setdefault(remark.diameter, []).append(text)
    if not others:
        return None
    text = f"{item.message}; but {' and '.join(one for texts in others.values() for one in texts)}"
    before = {(one.line, one.code) for one in every}
    for other in others:
        tools = {**setup.tools, number: replace(setup.tools[number], diameter=other)}
        left = {(one.line, one.code) for one in _list_errors(source, structs.replace(setup, tools=tools), dialect)}
        if left <= before - {(item.line, item.code)}:
            text += f": with {other:g} mm the tool fits"
            break
    return replace(item, message=f"{text}: which diameter is right?", advice=_CORRECT_DIAMETER, edits=())


def _write_edit(source: Text, edit: Remedy) -> Text | None:
    """The program with another word, or another number behind its letter; None where its line does not have it."""
    lines = bytes(source).split(b"\n")
    text = lines[edit.line - 1].decode("utf-8", errors="surrogateescape") if edit.line <= len(lines) else ""
    if edit.misspelt:
        found = re.search(rf"(?<!\w)({edit.misspelt})(?!\w)", text, re.IGNORECASE)
        span = None if found is None else found.span(1)
    else:
        found = find_word_of(text, *edit.word)
        span = None if found is None else found.span(2)
    if span is None:
        return None
    lines[edit.line - 1] = f"{text[: span[0]]}{edit.value}{text[span[1] :]}".encode("utf-8", errors="surrogateescape")
    return b"\n".join(lines)


def _list_errors(source: Text, setup: Setup, dialect: Dialect) -> list[Finding]:
    """The errors of a program that starts where it says."""
    state = _make_placed_state(source, setup, dialect) if setup.machine else dialect.initial_state(setup)
    return dialect.execute(source, setup, state, StopConditions()).errors


def _show_rival(
    source: Text, setup: Setup, errors: list[Finding], every: list[Finding], dialect: Dialect
) -> list[Finding]:
    """Errors, of which the first about a word that the rival of a recognised dialect reads says so.

    The rival must read all that this dialect reads: it has no error in a line in which ``every`` has none.
    """
    refused_words = [(item.line, item.code) for item in every if item.code in _ABOUT_WORDS]
    if setup.dialect != "auto" or dialect.rival is None or not refused_words:
        return errors
    rival = DIALECTS[dialect.rival.name]
    state = rival.initial_state(setup)
    state.known_axes = [True] * 9
    bad_lines = {item.line for item in rival.execute(source, setup, state, StopConditions()).errors}
    refused_words = [one for one in refused_words if one[0] not in bad_lines]
    at = next((at for at, item in enumerate(errors) if (item.line, item.code) in refused_words), None)
    if at is None or not bad_lines <= {item.line for item in every}:
        return errors
    sign = dialect.rival.find_sign(source)
    hint = (
        f"; the program was read as {name_dialect(dialect)} because of {sign}; if it is {dialect.rival.name}, "
        f"--dialect {dialect.rival.name} reads this word"
    )
    return [replace(item, message=item.message + hint) if n == at else item for n, item in enumerate(errors)]


def _make_refusal(
    source: Text, errors: list[Finding], dialect: Dialect, execution: Execution, setup: Setup
) -> InputError:
    """The errors of a program, planes kept over a change of tools, and missing offsets where a tool is missing."""
    found = _find_cause(source, errors, dialect, setup)
    if subprogram := next((item for item in found if item.message.startswith(IS_SUBPROGRAM)), None):
        found = keep_one(found, subprogram)
    elif not has_own_tool(execution.recorder):
        found = explain_subprogram(source, found, name_dialect(dialect), setup.source_name)
    codes = {item.code for item in found}
    holds_plane = setup.machine and any(plane.word for plane in execution.recorder.planes)
    if execution.recorder.count and (holds_plane or codes & {"VP008", "VP012", "VP018"}):
        moves = execution.recorder.freeze(list(execution.state.position), execution.state.frame, {})
        found = _name_unturned_planes(source, found, moves, setup, dialect)
        found = [_report_at_start(item, moves, setup) if item.code == "VP008" else item for item in found]
        found += report_missing_offsets(moves, setup) if codes & {"VP012", "VP018"} else []
        unread = min(
            (one.line or 0 for one in found if one.code in UNREADABLE and not find_correction(one.message)), default=0
        )
        found += [
            item
            for item in report_kept_planes(moves, setup.coordinates)
            if not _is_told(item, found) and (not unread or (item.line or 0) < unread)  # else it may be its end
        ]
    error = InputError(*(place_at_plane(source, item) for item in found))
    error.called_files, error.uncertain_files = execution.recorder.lines.split_files()
    return error


def _is_told(kept_plane: Finding, errors: list[Finding]) -> bool:
    """Whether an error names the plane that is kept (VP043), as its cause."""
    cause = kept_plane.message.removeprefix("the plane of ").split(" is still in force")[0]
    return any(cause in item.message for item in errors)


def _place_at_word(source: Text, item: Finding) -> Finding:
    """An error without a column, at the word of its line that an edit of it replaces."""
    edit = next((one for one in item.edits if one.word[0] and one.line == item.line), None)
    if item.column is not None or edit is None:
        return item
    word = find_word_of(decode_line(take_line(source, item.line or 0) or b""), *edit.word)
    return item if word is None else replace(item, column=word.start() + 1)


def _report_at_start(item: Finding, moves: Moves, setup: Setup) -> Finding:
    """An impossible arc (VP008), at the line before where that one leads out of the reach of the machine.

    Where the machine does not get to the place before, either, the part is somewhere else, and nothing is known.
    """
    later = np.flatnonzero(moves.line >= (item.line or 0))
    last = (int(later[0]) if len(later) else len(moves)) - 1
    if setup.travel is None or last < 1:
        return item
    in_reach = []
    for index in (last - 1, last):
        frame = moves.frames[moves.frame[index]]
        in_reach.append(
            setup.travel.is_reached(setup.coordinates.map_to_machine(moves.end[index], frame), frame.tool_length)
        )
    if in_reach != [True, False]:
        return item
    line = int(moves.line[last])
    place = " ".join(f"{axis}{value:g}" for axis, value in zip("XYZ", moves.end[last, :3].tolist(), strict=True))
    message = (
        f"{place} is out of the reach of the machine, and the arc of line {item.line} begins there: {item.message}"
    )
    return replace(item, message=message, line=line, last_line=line, worst_line=line, column=None)


def _name_unturned_planes(
    source: Text, errors: list[Finding], moves: Moves, setup: Setup, dialect: Dialect
) -> list[Finding]:
    """Errors in which arcs that are impossible (VP008) only because nothing turns the table to their plane say so.

    Each plane is one error, at its first arc, and the program has been read with G53.1.
    """
    found, arcs_left = list[Finding](), dict[int, set[int | None]]()
    for item in errors:
        line = item.line or 0
        calls = [one for one in moves.planes if one.own_line < line] if item.code == "VP008" else []
        plane = max(calls, key=lambda one: one.own_line, default=None)
        if plane is None or plane.word != "G68.2":
            found.append(item)
            continue
        at, is_first = plane.own_line, plane.own_line not in arcs_left
        if is_first:
            lines = bytes(source).split(b"\n")
            left = _list_errors(b"\n".join([*lines[:at], b"G53.1", *lines[at:]]), setup, dialect)
            # what is wrong where the table is turned is another cause
            errors_left = {((one.line or 0) - ((one.line or 0) > at), one.code) for one in left}
            is_cause = errors_left < {(one.line or 0, one.code) for one in errors}
            arcs_left[at] = {of for of, code in errors_left if code == "VP008"} if is_cause else {line}
        if line in arcs_left[at]:
            found.append(item)
        elif is_first:
            message = f"the plane of G68.2 in line {at}{' of the main program' * bool(item.called)} is in force, and "
            message += "nothing turns the table to it: with the tool length, the tip is not where X Y Z of the plane "
            message += f"are, and this arc does not fit; {plane.turn}"
            turn = Remedy("write G53.1", "G53.1", line=at, word=("G", 68.2), way="below")
            found.append(replace(item, message=message, column=None, edits=(turn,), advice=""))
    return found


def find_language(source: Text, errors: list[Finding], dialect: Dialect) -> Finding | None:
    """The finding that a program with errors is no text of its dialect; None where nothing shows it."""
    is_recognised = dialect.recognise(source)
    return find_other_language(source, errors, name_dialect(dialect), DIALECTS, is_recognised=is_recognised)


def replay(source: Text, setup: Setup, moves: Moves, stop: StopConditions) -> tuple[State, Recorder]:
    """Execute a program again from its start up to ``stop``: the state there, and what was recorded."""
    dialect = choose_dialect(setup.dialect, source, setup.source_name)
    state = dialect.initial_state(setup)
    state.known_axes = [True] * 9
    state.position = [float(value) for value in moves.start]
    return state, dialect.execute(source, setup, state, stop).recorder
