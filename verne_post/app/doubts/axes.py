"""One cut whose tool axis differs from all beside it: by a sign, or by the decimal point of a rotary word."""

import re
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.app.source_text import take_line_of_move
from verne_post.base.arrays import Array
from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text, decode_lines
from verne_post.base.program_lines import find_address, find_word_of, flip_component, name_component
from verne_post.base.rotations import measure_angles
from verne_post.model.findings import Finding, Remedy, add_line, make_finding
from verne_post.model.moves import AXES, MoveKind, Moves
from verne_post.model.options import Options
from verne_post.model.protocols import Coordinates

#: So many cuts on either side have axes that agree.
BESIDE: Final = 2
#: Cosine between an axis and the middle of those beside it: 5 degrees.
_AGREES: Final = 0.9962
#: Cosine between axes of cuts in a row: 10 degrees. Steps of finely divided surfaces are smaller.
_FOLLOWS: Final = 0.9848
#: Cosine between axes that a cut does not turn to and back: 30 degrees; 8 degrees, which are so many times what the
#: cuts beside it turn.
_DIFFERS: Final = 0.866
_LEAVES: Final = 0.9903
_TIMES_TURN: Final = 4.0
#: Radians by which components with three decimals turn an axis.
_ROUND_RAD: Final = 0.005
#: A line of Klartext that gives the tool axis.
_LN: Final = re.compile(r"[ \t]*+(?:\d+[ \t]++)?LN\b", re.IGNORECASE)
#: Degrees by which rotary axes turn less from one cut to the next; by which an angle of the wrong sign turns more; by
#: which walls of another draft differ more; and by which numbers are rounded.
_STEP_DEG: Final = 15.0
TURN_DEG: Final = 30.0
_SLACK_DEG: Final = 0.5
_ROUND_DEG: Final = 0.02
#: Degrees by which the angles before and after such a word differ less, or else the part of them by which the angle
#: that is meant is not in their middle; and that by which steps differ, of a wrong sign and of a lost point.
_EVEN_DEG: Final = 5.0
_OFF: Final = 0.25
_UNEVEN: Final = {"VP056": 0.5, "VP505": 0.25}
#: So many times as far as in the cuts beside it, the tip may go in a cut that is in doubt.
_TIMES_STEP: Final = 3.0
#: mm along the component whose sign differs: where the tip goes farther, it may go to another flank and back.
_ASIDE: Final = 5.0
#: mm: where it goes farther and comes back at once, it may be behind a rib. Steps of surfaces are smaller.
_BACK: Final = 0.5
#: Makes the finding of a line from its text and number; None where its text has no such word.
Describe = Callable[[str, int], Finding | None]


def check_axes(moves: Moves, from_move: int = 0) -> Iterator[Finding]:
    """VP056: the sign of one component of a tool axis is in doubt; one finding a program.

    With the other sign, the axis is between those of the cuts before and after it, and two on either side turn little
    from one to the next. The tip stays where it is along that component: it does not go to another flank, nor to the
    other side of a rib.
    """
    found: Finding | None = None
    for begin, end in iterate_blocks(len(moves), from_move):
        first = max(begin - 2 * BESIDE, from_move)
        axis, kind = moves.tool_axis[first:end], moves.kind[first:end]
        for at, component in _find_doubtful(axis, moves.end[first:end, :3], kind):
            found = _report(found, moves.language, int(moves.line[first + at]), component, axis[at, component])
    if found is not None:
        yield found


def check_normals(source: Text, moves: Moves, coordinates: Coordinates, from_move: int = 0) -> Iterator[Finding]:
    """The same of LN of Klartext, where the moves have the angles of the rotary axes in place of the tool axis."""
    if moves.language != "heidenhain":
        return
    turns: NDArray[np.bool_] = np.any(np.abs(np.diff(moves.end[:, 3:6], axis=0)) > _STEP_DEG, axis=1)
    lines = list[str]()
    found: Finding | None = None
    for row in (np.flatnonzero(turns[:-1] & turns[1:]) + 1).tolist():
        rows = slice(max(row - BESIDE, from_move), row + BESIDE + 1)
        lines = lines or [*decode_lines(source)]
        if not all(_LN.match(lines[line - 1]) for line in moves.line[rows].tolist()):
            continue
        ends = zip(moves.end[rows].tolist(), moves.frame[rows].tolist(), strict=True)
        axes = [coordinates.find_tool_axis(end, moves.frames[frame]) for end, frame in ends]
        axis, line = np.array([one for one in axes if one is not None]), int(moves.line[row])
        for at, component in _find_doubtful(axis, moves.end[rows, :3], moves.kind[rows]):
            found = _report(found, moves.language, line, component, axis[at, component], lines[line - 1])
    if found is not None:
        yield found


def _report(old: Finding | None, language: str, line: int, component: int, value: float, text: str = "") -> Finding:
    """``old``: what was found before, which gets the line; ``text``: that of the line, for an edit."""
    if old is not None:
        return add_line(old, line)
    said = (
        f"the tool axis of this cut is that of the cuts before and after it, but for the sign of "
        f"{name_component(language, component)} ({value + 0.0:.4g}): is the other sign meant?"
    )
    edits = tuple[Remedy, ...]()
    if (flipped := flip_component(text, language, component)) is not None:
        wrong, right, _value = flipped
        edits = (Remedy(f"write {right}", right, line=line, misspelt=wrong, turns=True, is_choice=True),)
    return make_finding("VP056", said, line=line, edits=edits)


def _find_doubtful(axis: Array, tip: Array, kind: NDArray[np.int8]) -> Iterator[tuple[int, int]]:
    """Rows of axes (n, 3) that are in doubt, and the component whose sign is; ``tip`` (n, 3) where the moves end."""
    if len(axis) <= 2 * BESIDE or not np.isfinite(axis).any():
        return
    first, before, own, after, last = view_beside(axis)
    middle = before + after
    middle = middle / np.maximum(np.linalg.norm(middle, axis=1), np.finfo(float).tiny)[:, None]
    rows = ((first, before, _FOLLOWS), (before, middle, _FOLLOWS), (after, last, _FOLLOWS))
    smooth = np.all([(one * other).sum(axis=1) > least for one, other, least in rows], axis=0)
    smooth &= view_beside(kind == MoveKind.FEED).all(axis=0) & ((own * middle).sum(axis=1) < _LEAVES)
    for row in np.flatnonzero(smooth).tolist():
        at = BESIDE + row
        turn, leaves = _find_turns(axis[row : at + BESIDE + 1], middle[row])
        agrees = _AGREES if own[row] @ middle[row] < _DIFFERS else np.cos(turn) if leaves else 2.0
        for component in range(3):
            other = own[row] * np.where(np.arange(3) == component, -1.0, 1.0)
            aside = np.abs(tip[[at - 1, at + 1], component] - tip[at, component]).max()
            is_back = _goes_behind(tip[row : at + BESIDE + 1], own[row] - other)
            if not is_back and aside <= _ASIDE and middle[row] @ other > agrees:
                yield at, component
                break


def _find_turns(axis: Array, middle: Array) -> tuple[float, bool]:
    """By what axes (5, 3) turn beside the third, rad, and whether this one leaves their way by far more."""
    first, before, own, after, last = axis
    beside = measure_angles(np.array([first, before, after]), np.array([before, middle, last]))
    turn = max(float(beside.max()), _ROUND_RAD)
    return turn, bool(measure_angles(own, middle) > _TIMES_TURN * turn)


def find_change(moves: Moves, coordinates: Coordinates, at: int, axis: int, factor: float) -> Array:
    """By what the tool axis of a move (3,) differs from that with another rotary word; 0: no meaning."""
    ends = np.tile(moves.end[at], (2, 1))
    ends[1, axis] *= factor
    one, other = (coordinates.find_tool_axis(end, moves.frames[moves.frame[at]]) for end in ends.tolist())
    return np.zeros(3) if one is None or other is None else one - other


def is_tool_turned(change: Array) -> bool:
    """Whether a rotary word turns the tool axis by more than roundings do: C of an upright tool does not."""
    return bool(np.linalg.norm(change) > _ROUND_RAD)


def _goes_behind(tip: Array, change: Array) -> bool:
    """Whether a tip (5, 3) is alone on one side along the change of its axis, as on the other one of a rib."""
    aside = (np.delete(tip, BESIDE, axis=0) - tip[BESIDE]) @ change
    least = _BACK * float(np.linalg.norm(change))
    return bool((aside > least).all() or (aside < -least).all())


def view_beside(rows: NDArray[Any]) -> NDArray[Any]:
    """Of each of the rows (n, ...) that has two on either side: these, and it in the middle, (5, n - 4, ...)."""
    return np.moveaxis(np.lib.stride_tricks.sliding_window_view(rows, 2 * BESIDE + 1, axis=0), -1, 0)


def report_words(
    source: Text, moves: Moves, options: Options, words: Iterable[tuple[int, str, Describe]], looked_at: int = 1
) -> Iterator[Finding]:
    """One finding of each code a file, with the lines of all words that are in doubt.

    Parameters
    ----------
    words : iterable of (int, str, callable)
        The move, the code, and what makes the finding of a line.
    looked_at : int
        In so many lines of a finding the word is looked for; others have it as the first ones do.
    """
    found, called = dict[tuple[str, str | None], Finding](), moves.called_lines
    for at, code, describe in words:
        line = int(called.number_moves(moves.line[at : at + 1], np.array([at]))[0])
        file = called.find_file(line)[1]
        item = before = found.get((code, file))
        if before is None or before.count < looked_at:
            item = describe(take_line_of_move(source, options, called, line), line)
        if item is not None:
            found[code, file] = item if before is None else add_line(before, line)
    yield from map(called.place, found.values())


def check_rotary_words(
    source: Text, moves: Moves, coordinates: Coordinates, options: Options, from_move: int = 0
) -> Iterator[Finding]:
    """VP056 and VP505: the sign and the decimal point of a rotary word are in doubt; one finding of each a file.

    With the other sign, or a tenth, the angle that is executed is between those of the cuts before and after it. Of a
    wrong sign, the other rotary axes turn little to it and from it, and the tip does not go to another flank.
    """
    return report_words(source, moves, options, _find_doubtful_angles(moves, coordinates, from_move))


def _find_doubtful_angles(
    moves: Moves, coordinates: Coordinates, from_move: int
) -> Iterator[tuple[int, str, Describe]]:
    for begin, end in iterate_blocks(len(moves), from_move):
        first = max(begin - 2 * BESIDE, from_move)
        angles, tip = moves.end[first:end, 3:6], moves.end[first:end, :3]
        if end - first <= 2 * BESIDE or not (np.abs(np.diff(angles, axis=0)) > TURN_DEG).any():
            continue
        one, two, three, four = np.linalg.norm(np.diff(view_beside(tip), axis=0), axis=2)
        is_near = np.maximum(two, three) <= np.maximum(_ASIDE, _TIMES_STEP * np.maximum(one, four))
        start, low, own, high, last = view_beside(angles)
        away, gap = np.minimum(np.abs(own - low), np.abs(own - high)), np.abs(high - low)
        turned = (away > TURN_DEG) & (gap < 2.0 * _STEP_DEG)
        turned &= (np.abs(low - start) < _STEP_DEG) & (np.abs(last - high) < _STEP_DEG)
        turns_with = np.maximum(np.abs(own - low), np.abs(own - high)) < _STEP_DEG
        is_angle = (moves.kind[first:end] == MoveKind.FEED) & np.isnan(moves.tool_axis[first:end, 0])
        in_doubt: NDArray[np.bool_] = np.all(list(view_beside(is_angle)), axis=0)
        is_alone = (turned | turns_with).all(axis=1) & (turned.sum(axis=1) == 1) & is_near
        half, middle = 0.5 * (high - low), 0.5 * (high + low)
        uneven = np.maximum(np.abs(low - start - half), np.abs(last - high - half))
        steps = np.maximum(np.abs(low - start), np.abs(last - high))
        # between walls of two drafts there may be a chamfer
        slack = np.where(steps > 0.0, 0.5 * gap - _ROUND_DEG, 0.0)
        slack = np.where(gap > _SLACK_DEG, slack, np.minimum(0.5 * steps + _ROUND_DEG, _SLACK_DEG))
        for code, factor, may_be in (("VP056", -1.0, in_doubt & is_alone), ("VP505", 0.1, in_doubt)):
            off = np.abs(factor * own - middle)
            # angles that step on from slot to slot are others, unless they do so evenly
            fits = (off <= _OFF * gap) & (uneven < _UNEVEN[code] * gap)
            fits = np.where(gap < _EVEN_DEG, off < slack, fits)
            for row, axis in np.argwhere(turned & fits & may_be[:, None]).tolist():
                at = first + BESIDE + row
                rows = slice(row, row + 2 * BESIDE + 1)
                change = find_change(moves, coordinates, at, 3 + axis, factor)
                if not is_tool_turned(change) or (factor < 0.0 and _goes_behind(tip[rows], change)):
                    continue
                yield at, code, partial(_describe_angle, moves, at, axis, factor, code)


def _describe_angle(moves: Moves, at: int, axis: int, factor: float, code: str, text: str, line: int) -> Finding | None:
    """The finding of a line; None where LN gives the tool axis (check_normals)."""
    if moves.language == "heidenhain" and _LN.match(text):
        return None
    before, value, after = moves.end[at - 1 : at + 2, 3 + axis].tolist()
    letter, right = AXES[3 + axis], f"{factor * value:.6g}"
    said = (
        f"{letter}{value:.6g} in this cut, and {letter}{before + 0.0:.6g} and {letter}{after + 0.0:.6g} in those "
        f"before and after it: is {letter}{right} meant?"
    )
    edit = Remedy(f"write {letter}{right}", right, line=line, word=(letter, value), is_choice=True)
    edits = (edit,) if find_word_of(text, letter, value) else ()
    return make_finding(code, said, line=line, column=find_address(text, letter), edits=edits)
