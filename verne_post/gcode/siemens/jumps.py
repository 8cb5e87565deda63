"""Jumps, branches, loops and repeated stretches of Siemens programs: what each statement does to the next line."""

import math
import re
from collections.abc import Callable
from functools import partial
from typing import Final, Protocol

from verne_post.base.suggestions import find_meant
from verne_post.gcode.calls import CallStack
from verne_post.gcode.program_error import CLOSE_IN_ORDER, GIVE_LABEL, ProgramError, write_meant
from verne_post.gcode.siemens.calls import Frame, Repeat
from verne_post.gcode.siemens.cursor import Cursor, strip_zeros
from verne_post.gcode.siemens.executor import Executor
from verne_post.gcode.siemens.program import SiemensText, split_line
from verne_post.gcode.siemens.slips import explain_moved_blank, refuse_lost_equals
from verne_post.gcode.siemens.values import Value, are_equal, read_indices, read_number, read_value, spell_value
from verne_post.gcode.siemens.variables import refuse_leftover
from verne_post.model.findings import Remedy


class Running(Protocol):
    """What statements see and change of a running program: :class:`~verne_post.gcode.siemens.flow.Flow`."""

    executor: Executor
    calls: CallStack[SiemensText, Frame]


#: A subprogram or a stretch is repeated so often at most by one P.
_MOST_REPEATS: Final = 9999
_JUMPS: Final = ("GOTOF", "GOTOB", "GOTO", "GOTOC")
_WHOLE: Final = 1e-9
_BLOCK_NUMBER: Final = re.compile(r"N\d+")


def read_repeats(value: float, column: int) -> int:
    """How often P says."""
    number = round(value) if abs(value) <= _MOST_REPEATS else -1
    if abs(value - number) > _WHOLE or number < 0:
        raise ProgramError("VP007", f"P{value:g}: a whole number from 0 to {_MOST_REPEATS}", column)
    return number


_GOTO: Final = ("GOTO", "GOTOF", "GOTOB", "GOTOC")


def _execute_if(flow: Running, cursor: Cursor, line: int) -> None:
    holds = read_number(cursor, flow.executor.variables) != 0
    word = cursor.peek_name()
    if word in _GOTO:
        cursor.name()
        if holds:
            _jump(flow, cursor, line, word)
        return
    if word and (message := flow.executor.words.explain_moved_blank(cursor.text, cursor.at)):
        raise cursor.error("VP001", message)
    if word and "0" in word and (meant_word := find_meant(word, _GOTO, slip_alone=True)):
        raise cursor.error("VP002", f"{word}: no meaning in this language; did you mean {meant_word}?")
    refuse_leftover(cursor)
    structure = flow.calls.text.structure
    branch = structure.branch[line]
    if not holds and branch not in structure.end:  # ENDIF
        _refuse_misspelt_else(flow, line, branch)
    elif not holds:
        item = split_line(flow.calls.text.read_line(branch))
        other = Cursor(item.text, item.begin)
        other.name()
        refuse_leftover(other)
    if not holds:
        flow.calls.line = branch + (branch in structure.end)


def _refuse_misspelt_else(flow: Running, begin: int, end: int) -> None:
    """Refuse (VP002) a line that is passed, of one word that is nearly ELSE, in an IF that has none."""
    begin_of = flow.calls.text.structure.begin
    for line, (word, column) in flow.calls.text.like_else.items():
        if not begin < line < end or any(begin < first < line < last for last, first in begin_of.items()):
            continue
        if not flow.executor.words.is_subprogram(word.upper()):
            error = ProgramError("VP002", f"{word}: no meaning in this language; did you mean ELSE?", column, line)
            error.breaks_structure = True
            raise error


def _execute_else(flow: Running, cursor: Cursor, line: int) -> None:
    refuse_leftover(cursor)
    flow.calls.line = flow.calls.text.structure.branch[line]


def _execute_endif(flow: Running, cursor: Cursor, line: int) -> None:
    _ = flow.calls.text.structure
    refuse_leftover(cursor)


def _execute_case(flow: Running, cursor: Cursor, line: int) -> None:
    """CASE(value) OF 1 GOTOF A 2 GOTOF B DEFAULT GOTOF C: a jump for the value, else that of DEFAULT, else none."""
    variables = flow.executor.variables
    value = read_number(cursor, variables)
    if cursor.name() != "OF":
        raise cursor.error("VP001", "expected OF after the value of CASE")
    chosen_branch: tuple[str, str, int] | None = None
    while not cursor.is_at_end:
        default = cursor.peek_name() == "DEFAULT"
        if default:
            cursor.name()
        holds = default or are_equal(read_number(cursor, variables), value)
        at, word = cursor.at, cursor.name()
        if word not in _JUMPS:
            text = "expected GOTOF, GOTOB, GOTO or GOTOC after a value of CASE"
            raise cursor.error("VP001", text, at, write_meant(word or "", _JUMPS))
        cursor.skip()
        at, target = cursor.at, _read_target(flow, cursor)
        if holds and chosen_branch is None:
            chosen_branch = target, word, at
        if default:
            refuse_leftover(cursor)
    if chosen_branch is not None:
        _go(flow, cursor, line, *chosen_branch)


def _jump(flow: Running, cursor: Cursor, line: int, word: str) -> None:
    cursor.skip()
    at = cursor.at
    target = _read_target(flow, cursor)
    refuse_leftover(cursor)
    _go(flow, cursor, line, target, word, at)


def _go(flow: Running, cursor: Cursor, line: int, target: str, word: str, at: int) -> None:
    found = _find(flow, target, line, forward=word != "GOTOB", backward=word != "GOTOF")
    if found is None:
        if word == "GOTOC":
            return
        other = _find(flow, target, line, forward=True, backward=True)
        if other is not None:
            place, right = ("before", "GOTOB") if word == "GOTOF" else ("after", "GOTOF")
            begin = cursor.text.upper().rindex(word, 0, at)
            edits = (Remedy(f"write {right}", right, misspelt=word, is_choice=True),)
            text = f"{word} {target}: the label is {place} this line, in line {other}; write {right}"
            error = cursor.error("VP023", text, begin, edits)
            error.passes_to = other
            raise error
        bare = flow.calls.text.find_bare_label(target)
        if bare is not None:
            if word != "GOTOB" and (bare.line or 0) > line:
                flow.calls.line = (bare.line or 0) + 1
            raise bare
        damaged_lines = [one for one in flow.calls.text.find_damaged_labels(target) if word != "GOTOB" or one < line]
        if damaged_lines and (word != "GOTOF" or damaged_lines[-1] > line):
            flow.calls.line = damaged_lines[-1]  # which says what is wrong
            return
        begin = cursor.text.upper().rindex(word, 0, at)
        if message := flow.executor.words.explain_moved_blank(cursor.text, begin):
            raise cursor.error("VP001", message, begin)
        where = {"GOTOF": " after this line", "GOTOB": " before this line"}.get(word, "")
        text = f"there is no such label or block number{where}"
        others = (
            label
            for label in flow.calls.text.labels
            if _find(flow, label, line, forward=word != "GOTOB", backward=word != "GOTOF") is not None
        )
        near = find_meant(target, others, slip_alone=True)
        message = f"{target}: {text}; did you mean {near}?" if near else f"{word} {target}: {text}"
        error = cursor.error("VP023", message, at).advise("" if near else GIVE_LABEL)
        if word != "GOTOB" and not near:  # else the program goes on at the near one
            is_number, last = _BLOCK_NUMBER.fullmatch(target) is not None, flow.calls.frame.section.last
            alike = [
                places
                for label, places in flow.calls.text.labels.items()
                if (_BLOCK_NUMBER.fullmatch(label) is not None) == is_number
            ]
            error.passes_to = min((at for places in alike for at in places if line < at <= last), default=0)
        raise error
    flow.calls.line = found
    repeats = flow.calls.frame.repeats
    while repeats and not repeats[-1].first <= found <= repeats[-1].last:
        repeats.pop()  # a jump inside the stretch goes on with it


def _read_target(flow: Running, cursor: Cursor) -> str:
    name = cursor.peek_name()
    if name is not None and flow.executor.variables.find(name) is None and name not in ("N",):
        cursor.name()
        return _read_block_number(name)
    value: Value = read_value(cursor, flow.executor.variables)
    return _read_block_number(spell_value(value).upper())


def _read_block_number(name: str) -> str:
    return f"N{strip_zeros(name[1:])}" if name[0:1] == "N" and name[1:].isdigit() else name


def _find(flow: Running, label: str, line: int, *, forward: bool, backward: bool) -> int | None:
    """The line of a label in the running program: after this line first, then before it."""
    section = flow.calls.frame.section
    lines = [place for place in flow.calls.text.labels.get(label, ()) if section.first <= place <= section.last]
    after = next((place for place in lines if place > line), None)
    before = next((place for place in reversed(lines) if place <= line), None)
    return after if forward and after is not None else before if backward else None


#: A FOR whose first and last value are numbers.
_WRITTEN_COUNT: Final = re.compile(r"=[ \t]*[-+]?[\d.]+[ \t]+TO[ \t]+[-+]?[\d.]+[ \t]*$", re.IGNORECASE)


def _execute_for(flow: Running, cursor: Cursor, line: int) -> None:
    variables, ends = flow.executor.variables, flow.calls.frame.ends
    ends[line] = math.nan  # until its words are read: ENDFOR of a refused FOR is no error of its own
    cursor.skip()
    at, name = cursor.at, cursor.name()
    if name is None:
        raise cursor.error("VP001", "expected a variable after FOR", at)
    known_name, is_known = name.rstrip("0123456789"), variables.is_known
    sign = cursor.skip()
    if sign in ("-", "+") and is_known(name):
        raise refuse_lost_equals(cursor, at, name, cursor.text[at : cursor.at + 1])
    if sign not in ("=", "[") and known_name != name and is_known(known_name):
        right = f"{known_name}={name[len(known_name) :]}"
        edits = (Remedy(f"write {right}", right, misspelt=name),)
        raise cursor.error("VP001", f"{name}: an = is missing; write {right}", at, edits)
    variables.assign(name, cursor, at)
    cursor.skip()
    at, word = cursor.at, cursor.name()
    if message := explain_moved_blank(cursor.text, at, ["TO"], lambda _to, name: name.isdigit() or is_known(name)):
        raise cursor.error("VP001", message, at)
    if word != "TO":
        slip = "T0: a zero in place of the letter O; did you mean TO?"
        other = f"{word}: no word of FOR; did you mean TO?" if word else "expected TO and the last value of FOR"
        raise cursor.error("VP001", slip if word == "T0" else other, at)
    last = read_number(cursor, variables)
    refuse_leftover(cursor)
    end = flow.calls.text.structure.end[line]
    ends[line] = last
    if _read_loop_value(flow, line, cursor) > last:
        flow.calls.line = end + 1
        if _WRITTEN_COUNT.search(cursor.text):  # of values that the program computes it may be meant
            text = "FOR begins above its last value, and counts up: its lines are not executed; exchange the values"
            flow.executor.interpreter.recorder.note_once("VP051", text, flow.calls.show(line))


def _read_loop_value(flow: Running, line: int, cursor: Cursor) -> float:
    """The value of the variable of a FOR."""
    name, at, inner = _read_loop_variable(flow, line)
    value = flow.executor.variables.read(name, read_indices(inner, flow.executor.variables), inner, at)
    if isinstance(value, str):
        raise cursor.error("VP007", f"FOR {name}: a number is needed")
    return value


def _read_loop_variable(flow: Running, line: int) -> tuple[str, int, Cursor]:
    item = split_line(flow.calls.text.read_line(line))
    cursor = Cursor(item.text, item.begin)
    cursor.name()
    cursor.skip()
    at, name = cursor.at, cursor.name()
    assert name is not None
    return name, at, cursor


def _execute_endfor(flow: Running, cursor: Cursor, line: int) -> None:
    refuse_leftover(cursor)
    begin = flow.calls.text.structure.begin[line]
    last = flow.calls.frame.ends.get(begin)
    if last is None:
        raise cursor.error("VP023", f"ENDFOR is executed, but its FOR (line {begin}) was not", 0).advise(CLOSE_IN_ORDER)
    if math.isnan(last):
        return
    value = _read_loop_value(flow, begin, cursor) + 1.0
    name, at, inner = _read_loop_variable(flow, begin)
    flow.executor.variables.write(name, read_indices(inner, flow.executor.variables), value, inner, at)
    if value < last or are_equal(value, last):
        flow.calls.line = begin + 1


def _execute_while(flow: Running, cursor: Cursor, line: int) -> None:
    holds = read_number(cursor, flow.executor.variables) != 0
    if cursor.peek_name() == "DO":
        edits = (Remedy("take DO out", "", misspelt="DO"),)
        raise cursor.error("VP001", "DO: WHILE of this language has none; take DO out", edits=edits)
    refuse_leftover(cursor)
    end = flow.calls.text.structure.end[line]
    if not holds:
        flow.calls.line = end + 1


def _begin_loop(flow: Running, cursor: Cursor, line: int) -> None:
    refuse_leftover(cursor)
    _ = flow.calls.text.structure


def _execute_loop_end(flow: Running, cursor: Cursor, line: int) -> None:
    """ENDWHILE, ENDLOOP."""
    refuse_leftover(cursor)
    begin = flow.calls.text.structure.begin[line]
    flow.calls.line = begin


def _execute_until(flow: Running, cursor: Cursor, line: int) -> None:
    holds = read_number(cursor, flow.executor.variables) != 0
    refuse_leftover(cursor)
    begin = flow.calls.text.structure.begin[line]
    if not holds:
        flow.calls.line = begin + 1


def _repeat(flow: Running, cursor: Cursor, line: int) -> None:
    """REPEAT of REPEAT ... UNTIL, or REPEAT label [label] P=n."""
    if cursor.is_at_end:
        _ = flow.calls.text.structure.end[line]
        return
    _repeat_stretch(flow, cursor, line, one_block=False)


def _repeat_stretch(flow: Running, cursor: Cursor, line: int, *, one_block: bool) -> None:
    labels: list[tuple[str, int]] = []
    times = 1
    while not cursor.is_at_end:
        at, name = cursor.at, cursor.name()
        if name == "P" and cursor.take("="):
            times = read_repeats(read_number(cursor, flow.executor.variables), at + 1)
        elif name is not None and name[0] == "P" and name[1:].isdigit():
            times = read_repeats(float(name[1:]), at + 1)
        elif name is None or len(labels) == (1 if one_block else 2):
            raise cursor.error("VP001", "expected a label, and P= for how often", at)
        else:
            labels.append((_read_block_number(name), at))
    if not labels:
        raise cursor.error("VP001", "expected a label after REPEAT", 0)
    places = []
    for label, at in labels:
        place = _find(flow, label, line, forward=True, backward=True)
        if place is None:
            raise cursor.error("VP023", f"REPEAT {label}: there is no such label", at).advise(GIVE_LABEL)
        places.append(place)
    first = places[0]
    if one_block:
        last = first
    elif len(places) == 2:
        last = places[1]
    else:
        ends = [
            place
            for place in flow.calls.text.labels.get("ENDLABEL", ())
            if first <= place <= flow.calls.frame.section.last
        ]
        last = next((place for place in ends if place < line or first > line), line - 1)
    if last < first or first <= line <= last:
        raise cursor.error(
            "VP023",
            f"REPEAT {labels[0][0]}: the lines {first} to {last} cannot be repeated from line {line}",
            labels[0][1],
        )
    if times:
        flow.calls.frame.repeats.append(Repeat(first, last, times, line + 1))
        flow.calls.line = first


def end_stretch(flow: Running, line: int) -> None:
    """After the last line of a repeated stretch: once more, or on."""
    repeats = flow.calls.frame.repeats
    while repeats and repeats[-1].last == line and flow.calls.line == line + 1:
        repeat = repeats[-1]
        repeat.remaining -= 1
        if repeat.remaining > 0:
            flow.calls.line = repeat.first
            return
        repeats.pop()
        flow.calls.line = repeat.back
        line = repeat.back - 1


#: What the statements do.
JUMPS: Final[dict[str, Callable[[Running, Cursor, int], None]]] = {
    "IF": _execute_if, "ELSE": _execute_else, "ENDIF": _execute_endif, "CASE": _execute_case,
    "GOTO": partial(_jump, word="GOTO"), "GOTOF": partial(_jump, word="GOTOF"),
    "GOTOB": partial(_jump, word="GOTOB"), "GOTOC": partial(_jump, word="GOTOC"),
    "FOR": _execute_for, "ENDFOR": _execute_endfor, "WHILE": _execute_while, "ENDWHILE": _execute_loop_end,
    "LOOP": _begin_loop, "ENDLOOP": _execute_loop_end, "REPEAT": _repeat, "UNTIL": _execute_until,
    "REPEATB": partial(_repeat_stretch, one_block=True),
}  # fmt: skip
