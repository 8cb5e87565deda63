"""One point that leaves the way of the cuts beside it in one word, and is on it with another sign or decimal point."""

from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from verne_post.app.doubts.axes import (
    BESIDE,
    TURN_DEG,
    Describe,
    find_change,
    is_tool_turned,
    report_words,
    view_beside,
)
from verne_post.base.arrays import Array
from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text
from verne_post.base.program_lines import find_word_of
from verne_post.base.tolerances import START_POSE_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.moves import AXES, MoveKind, Moves
from verne_post.model.options import Options
from verne_post.model.protocols import Coordinates

#: So many cuts on either side go evenly.
_BESIDE: Final = 4
#: The part of the longer of two steps in a row by which they differ, and that of a step of the axis in doubt by which
#: the place that is meant is not where the cuts beside it lead.
_UNEVEN: Final = 0.6
_OFF: Final = 0.25
#: So many steps of the cuts beside it, a word is beyond both of them; a height of a level contour.
_TIMES_STEP: Final = 1.5
_TIMES_LEVEL: Final = 4.0
#: mm or degrees: the least of that; numbers are rounded.
_LEAST: Final = 1.0
_ROUNDED: Final = 0.005
#: mm: numbers that a person writes are mostly multiples of one of them.
_ROUND: Final = (0.1, 0.01 * MM_PER_INCH)
#: A file with more such words has them as a pattern.
_MOST: Final = 2
#: What a slip may have made of words: the axes, by what the number is multiplied, and the code of the finding.
_DOUBTS: Final = (
    *(
        ((axis,), factor, code)
        for axis in range(6)
        for factor, code in ((-1.0, "VP056"), (0.1, "VP505"), (10.0, "VP505"))
    ),
    *((axes, 1.0, "VP056") for axes in ((3, 4), (3, 5), (4, 5))),
)


def check_points(
    source: Text, moves: Moves, coordinates: Coordinates, options: Options, from_move: int = 0
) -> Iterator[Finding]:
    """VP056 and VP505: the sign or the decimal point of one word is in doubt, or two rotary words are exchanged.

    Nine cuts in a row go on evenly but for this word in the middle one, as those of a finely divided curve do; notches,
    teeth, hops and pecks have fewer. One finding of each a file.
    """
    words = _find_doubtful_points(moves, coordinates, from_move)
    return (item for item in report_words(source, moves, options, words, _MOST + 1) if item.count <= _MOST)


def _find_doubtful_points(
    moves: Moves, coordinates: Coordinates, from_move: int
) -> Iterator[tuple[int, str, Describe]]:
    for begin, end in iterate_blocks(len(moves), from_move):
        first = max(begin - 2 * _BESIDE, from_move)
        if not (np.abs(np.diff(moves.end[first:end, :6], axis=0)) > _LEAST).any():
            continue
        for row, axes, factor, code in _find_doubtful(moves, slice(first, end)):
            at = first + row
            if axes[0] < 3 or len(axes) > 1 or is_tool_turned(find_change(moves, coordinates, at, axes[0], factor)):
                yield at, code, partial(_describe, moves.end[at - 1 : at + 2], axes, factor, code)


def _find_doubtful(moves: Moves, block: slice) -> list[tuple[int, tuple[int, ...], float, str]]:
    """Rows of a block that are in doubt, the axes whose words are, by what the number is wrong, and the code."""
    points, is_cut = moves.end[block, :6], moves.kind[block] == MoveKind.FEED
    if len(points) <= 2 * _BESIDE:
        return []
    _first, low, own, high, _last = view_beside(points[_BESIDE - BESIDE : len(points) + BESIDE - _BESIDE])
    away = np.maximum(np.minimum(low, high) - own, own - np.maximum(low, high))
    rows = np.flatnonzero((away > _LEAST).any(axis=1) & sliding_window_view(is_cut, 2 * _BESIDE + 1).all(axis=1))
    paths, away = sliding_window_view(points, 2 * _BESIDE + 1, axis=0)[rows].transpose(0, 2, 1), away[rows]
    beside = np.delete(np.abs(np.diff(paths, axis=1)), (_BESIDE - 1, _BESIDE), axis=1).max(axis=1)
    leaves = away > np.maximum(_TIMES_STEP * beside, _LEAST)
    is_free = np.isfinite(moves.tool_axis[block][rows + _BESIDE, 0])  # its angles are those of a tool axis
    found = dict[int, tuple[int, tuple[int, ...], float, str]]()
    for axes, factor, code in _DOUBTS:
        columns = list(axes)
        some = leaves[:, columns] & ~(is_free[:, None] & (np.array(axes) >= 3))
        if axes[0] >= 3 and len(axes) == 1:
            some &= away[:, columns] <= TURN_DEG  # check_rotary_words
        at = np.flatnonzero(some.all(axis=1))
        at = at[_find_even(paths[at], away[at], columns, factor)]
        found = {row: (row + _BESIDE, axes, factor, code) for row in rows[at].tolist()} | found
    return [found[row] for row in sorted(found)]


def _find_even(paths: Array, away: Array, axes: list[int], factor: float) -> NDArray[np.bool_]:
    """Which paths (n, 9, 6) go on evenly with the words that are meant; the middle is ``away`` (n, 6) from them."""
    meant = paths.copy()
    meant[:, _BESIDE, axes] = factor * paths[:, _BESIDE, axes[::-1]]
    steps = np.diff(meant, axis=1)
    bends = np.diff(steps, axis=1)
    length, bend = (np.linalg.norm(one[..., :3], axis=2) for one in (steps, bends))
    is_even = (bend <= _UNEVEN * np.maximum(length[:, :-1], length[:, 1:]) + _ROUNDED).all(axis=1)
    steps, bends = np.abs(steps), np.abs(bends)
    most = steps.max(axis=1)
    is_even &= (bends[..., 3:] <= _UNEVEN * most[:, None, 3:] + _ROUNDED).all(axis=(1, 2))
    is_fine = np.all([np.abs(meant - np.rint(meant / one) * one) > START_POSE_MM for one in _ROUND], axis=0)
    is_even &= ((is_fine.sum(axis=1) >= _BESIDE) & (most > 0.0)).any(axis=1)
    if axes[0] < 3:
        is_even &= (most[:, axes[0]] > 0.0) | (away[:, axes[0]] > _TIMES_LEVEL * length.max(axis=1))
    else:  # check_rotary_words
        is_even &= (most[:, axes] > 0.0).all(axis=1)
    # where a cubic through the two cuts on either side leads
    leads = np.tensordot(meant[:, _BESIDE - 2 : _BESIDE + 3], (-1.0, 4.0, 0.0, 4.0, -1.0), (1, 0)) / 6.0
    turn = np.delete(bends, (_BESIDE - 2, _BESIDE - 1, _BESIDE), axis=1).max(axis=1)
    near = _OFF * np.maximum(0.5 * np.abs(meant[:, _BESIDE + 1] - meant[:, _BESIDE - 1]), turn) + _ROUNDED
    return np.asarray(is_even & (np.abs(meant[:, _BESIDE] - leads) <= near)[:, axes].all(axis=1))


def _describe(ends: Array, axes: tuple[int, ...], factor: float, code: str, text: str, line: int) -> Finding | None:
    """The finding of a line; None where its text has not these words, as in a loop, or in G91."""
    unit = 1.0
    words = [find_word_of(text, AXES[axis], float(ends[1, axis])) for axis in axes]
    if axes[0] < 3 and words[0] is None:
        unit, words = MM_PER_INCH, [find_word_of(text, AXES[axes[0]], float(ends[1, axes[0]]) / MM_PER_INCH)]
    if any(word is None for word in words):
        return None
    columns = list(axes)
    before, own, after = (
        " ".join(f"{AXES[axis]}{value + 0.0:.6g}" for axis, value in zip(axes, end, strict=True))
        for end in (ends[:, columns] / unit).tolist()
    )
    letter, value = AXES[axes[0]], float(ends[1, axes[0]]) / unit
    if len(axes) == 2:
        other = AXES[axes[1]]
        meant = f"are {letter} and {other} exchanged"
        edit = Remedy(
            f"exchange {letter} and {other}", other, line=line, word=(letter, value), way="exchanged", is_choice=True
        )
    else:
        right = f"{factor * value:.6g}"
        meant = f"is {letter}{right} meant"
        edit = Remedy(f"write {letter}{right}", right, line=line, word=(letter, value), is_choice=True)
    said = f"{own} in this cut, and {before} and {after} in those before and after it: {meant}?"
    assert words[0] is not None
    return make_finding(code, said, line=line, column=words[0].start() + 1, edits=(edit,))
