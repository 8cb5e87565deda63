"""One cut whose tool axis differs from all beside it: by a sign, or by the decimal point of a rotary word."""

import re
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text, take_line
from verne_post.base.program_lines import find_word_of, flip_component, name_component
from verne_post.model.findings import Finding, Remedy, add_line, make_finding
from verne_post.model.moves import AXES, MoveKind, Moves
from verne_post.model.protocols import Coordinates

#: So many cuts on either side have axes that agree.
_BESIDE: Final = 2
#: Cosine between an axis and the middle of those beside it: 5 degrees.
_AGREES: Final = 0.9962
#: Cosine between axes of cuts in a row: 10 degrees. Steps of finely divided surfaces are smaller.
_FOLLOWS: Final = 0.9848
#: Cosine between axes that a cut does not turn to and back: 30 degrees.
_DIFFERS: Final = 0.866
#: A line of Klartext that gives the tool axis.
_LN: Final = re.compile(rb"[ \t]*+(?:\d+[ \t]++)?LN\b", re.IGNORECASE)
#: Degrees by which rotary axes turn less from one cut to the next; by which an angle of the wrong sign turns more; and
#: by which numbers are rounded.
_STEP_DEG: Final = 15.0
_TURN_DEG: Final = 30.0
_SLACK_DEG: Final = 0.5
#: Degrees by which the angles before and after a lost point differ less.
_EVEN_DEG: Final = 5.0
#: So many times as far as in the cuts beside it, the tip may go in a cut that is in doubt.
_TIMES_STEP: Final = 3.0
#: mm along the component whose sign differs: where the tip goes farther, it may go to another flank and back.
_ASIDE: Final = 5.0
#: mm: where it goes farther and comes back at once, it may be behind a rib. Steps of surfaces are smaller.
_BACK: Final = 0.5


def check_axes(moves: Moves, from_move: int = 0) -> Iterator[Finding]:
    """VP056: the sign of one component of a tool axis is in doubt; one finding a program.

    With the other sign, the axis is between those of the cuts before and after it, and two on either side turn little
    from one to the next. The tip stays where it is along that component: it does not go to another flank, nor to the
    other side of a rib.
    """
    found: Finding | None = None
    for begin, end in iterate_blocks(len(moves), from_move):
        first = max(begin - 2 * _BESIDE, from_move)
        axis, kind = moves.tool_axis[first:end], moves.kind[first:end]
        for at, component in _find_doubtful(axis, moves.end[first:end, :3], kind):
            line = int(moves.line[first + at])
            found = (
                _report(moves.language, line, component, axis[at, component])
                if found is None
                else add_line(found, line)
            )
    if found is not None:
        yield found


def check_normals(source: Text, moves: Moves, coordinates: Coordinates, from_move: int = 0) -> Iterator[Finding]:
    """The same of LN of Klartext, where the moves have the angles of the rotary axes in place of the tool axis."""
    if moves.language != "heidenhain" or len(moves) - from_move <= 2 * _BESIDE:
        return
    turns: NDArray[np.bool_] = np.any(np.abs(np.diff(moves.end[:, 3:6], axis=0)) > _STEP_DEG, axis=1)
    lines = list[bytes]()
    found: Finding | None = None
    for row in (np.flatnonzero(turns[:-1] & turns[1:]) + 1).tolist():
        rows = slice(row - _BESIDE, row + _BESIDE + 1)
        if rows.start < from_move or rows.stop > len(moves) or (moves.kind[rows] != MoveKind.FEED).any():
            continue
        lines = lines or source[:].split(b"\n")
        if not all(_LN.match(lines[line - 1]) for line in moves.line[rows].tolist()):
            continue
        ends = zip(moves.end[rows].tolist(), moves.frame[rows].tolist(), strict=True)
        axes = [coordinates.find_tool_axis(end, moves.frames[frame]) for end, frame in ends]
        if any(one is None for one in axes):
            continue
        axis, line = np.array(axes, dtype=float), int(moves.line[row])
        for at, component in _find_doubtful(axis, moves.end[rows, :3], moves.kind[rows]):
            if found is not None:
                found = add_line(found, line)
                continue
            flipped = flip_component(lines[line - 1].decode("utf-8", errors="replace"), moves.language, component)
            found = _report(moves.language, line, component, axis[at, component], flipped)
    if found is not None:
        yield found


def _report(
    language: str, line: int, component: int, value: float, flipped: tuple[str, str, str] | None = None
) -> Finding:
    """``flipped``: as :func:`flip_component` returns it, for an edit."""
    text = (
        f"the tool axis of this cut is that of the cuts before and after it, but for the sign of "
        f"{name_component(language, component)} ({value + 0.0:.4g}): is the other sign meant?"
    )
    edits = tuple[Remedy, ...]()
    if flipped is not None:
        wrong, right, _value = flipped
        edits = (Remedy(f"write {right}", right, line=line, misspelt=wrong, turns=True, is_choice=True),)
    return make_finding("VP056", text, line=line, last_line=line, worst_line=line, edits=edits)


def _find_doubtful(axis: Array, tip: Array, kind: NDArray[np.int8]) -> Iterator[tuple[int, int]]:
    """Rows of axes (n, 3) that are in doubt, and the component whose sign is; ``tip`` (n, 3) where the moves end."""
    n, width = len(axis), 2 * _BESIDE + 1
    if n < width or not np.isfinite(axis).any():
        return
    own = axis[_BESIDE : n - _BESIDE]
    first, before, after, last = (axis[shift : n - width + 1 + shift] for shift in range(width) if shift != _BESIDE)
    middle = before + after
    middle = middle / np.maximum(np.linalg.norm(middle, axis=1), np.finfo(float).tiny)[:, None]
    rows = ((first, before, _FOLLOWS), (before, middle, _FOLLOWS), (after, last, _FOLLOWS))
    smooth = np.all([(one * other).sum(axis=1) > least for one, other, least in rows], axis=0)
    smooth &= _find_cuts(kind) & ((own * middle).sum(axis=1) < _DIFFERS)
    for row in np.flatnonzero(smooth).tolist():
        at = _BESIDE + row
        for component in range(3):
            other = own[row].copy()
            other[component] *= -1.0
            aside = tip[[at - 1, at + 1], component] - tip[at, component]
            is_back = (aside > _BACK).all() or (aside < -_BACK).all()
            if not is_back and np.abs(aside).max() <= _ASIDE and middle[row] @ other > _AGREES:
                yield at, component
                break


def _find_cuts(kind: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Whether each of the rows of moves (n,) that has two on either side, and these, are straight cuts."""
    n, width = len(kind), 2 * _BESIDE + 1
    cuts: NDArray[np.bool_] = np.all(
        [kind[shift : n - width + 1 + shift] == MoveKind.FEED for shift in range(width)], axis=0
    )
    return cuts


def check_rotary_words(source: Text, moves: Moves, from_move: int = 0) -> Iterator[Finding]:
    """VP056 and VP505: the sign and the decimal point of a rotary word are in doubt; one finding of each a program.

    With the other sign, or a tenth, its angle is between those of the cuts before and after it. The other rotary axes
    turn little in all of these cuts, and the tip is not much farther away than in those beside.
    """
    found: dict[str, Finding] = {}
    width = 2 * _BESIDE + 1
    for begin, end in iterate_blocks(len(moves), from_move):
        first = max(begin - 2 * _BESIDE, from_move)
        n = end - first
        if n < width:
            continue
        angles, tip = moves.end[first:end, 3:6], moves.end[first:end, :3]
        steps = np.abs(np.diff(angles, axis=0))
        if not (steps > _TURN_DEG).any():
            continue
        way = np.linalg.norm(np.diff(tip, axis=0), axis=1)
        one, two, three, four = (way[shift : n - width + 1 + shift] for shift in range(width - 1))
        is_near = np.maximum(two, three) <= np.maximum(_ASIDE, _TIMES_STEP * np.maximum(one, four))
        own, low = angles[_BESIDE : n - _BESIDE], angles[_BESIDE - 1 : n - _BESIDE - 1]
        high = angles[_BESIDE + 1 : n - _BESIDE + 1]
        near = (np.abs(high - low) < 2.0 * _STEP_DEG) & (steps[: n - width + 1] < _STEP_DEG)
        near &= steps[width - 2 :] < _STEP_DEG
        turned = near & (np.abs(own - low) > _TURN_DEG) & (np.abs(own - high) > _TURN_DEG)
        turns_with = near & (np.abs(own - low) < _STEP_DEG)
        in_doubt = (turned | turns_with).all(axis=1) & _find_cuts(moves.kind[first:end]) & is_near
        in_doubt &= turned.sum(axis=1) == 1
        # an angle that steps on from slot to slot has other ones beside it
        is_even = (np.abs(high - low) < _EVEN_DEG) & (low * high > 0.0)
        for code, factor, is_away in (("VP056", -1.0, turned), ("VP505", 0.1, turned & is_even)):
            meant = factor * own
            is_between = (meant >= np.minimum(low, high) - _SLACK_DEG) & (meant <= np.maximum(low, high) + _SLACK_DEG)
            for row, axis in np.argwhere(is_away & is_between & in_doubt[:, None]).tolist():
                line, value = int(moves.line[first + _BESIDE + row]), float(own[row, axis])
                letter, text = AXES[3 + axis], (take_line(source, line) or b"").decode("utf-8", errors="replace")
                word = find_word_of(text, letter, value)
                if word is None:
                    continue
                if code in found:
                    found[code] = add_line(found[code], line)
                    continue
                right = f"{meant[row, axis]:.6g}"
                said = (
                    f"{letter}{value:.6g} in this cut, and {letter}{low[row, axis] + 0.0:.6g} and "
                    f"{letter}{high[row, axis] + 0.0:.6g} in those before and after it: is {letter}{right} meant?"
                )
                edits = (Remedy(f"write {letter}{right}", right, line=line, word=(letter, value), is_choice=True),)
                where = {"line": line, "last_line": line, "worst_line": line, "column": word.start() + 1}
                found[code] = make_finding(code, said, **where, edits=edits)
    yield from found.values()
