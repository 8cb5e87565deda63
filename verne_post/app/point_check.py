"""One point that leaves the way of the cuts beside it in one word, and is on it with another sign or decimal point."""

from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.app.axis_check import BESIDE, TURN_DEG, Describe, report_words, view_beside
from verne_post.base.arrays import Array
from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text
from verne_post.base.program_lines import find_word_of
from verne_post.base.tolerances import START_POSE_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.moves import AXES, MoveKind, Moves
from verne_post.model.options import Options

#: The part of what an axis moves from the cut before to the one after, by which its steps beside them differ, and by
#: which what is meant is not in the middle.
_UNEVEN: Final = 0.5
_OFF: Final = 0.25
#: So many steps of the cuts beside it, a word is beyond both of them.
_TIMES_STEP: Final = 1.5
#: mm or degrees: the least of that; numbers are rounded.
_LEAST: Final = 1.0
#: A file with more such words has them as a pattern.
_MOST: Final = 2
#: What a slip makes of a number, and the code by which its finding goes.
_SLIPS: Final = ((-1.0, "VP056"), (0.1, "VP505"), (10.0, "VP505"))


def check_points(source: Text, moves: Moves, options: Options, from_move: int = 0) -> Iterator[Finding]:
    """VP056 and VP505: the sign or the decimal point of one word is in doubt, or two rotary words are exchanged.

    Five cuts in a row go on evenly, or stand, in every axis but for this word in the middle one. One finding of each a
    file.
    """
    words = _find_doubtful_points(moves, from_move)
    return (item for item in report_words(source, moves, options, words, _MOST + 1) if item.count <= _MOST)


def _find_doubtful_points(moves: Moves, from_move: int) -> Iterator[tuple[int, str, Describe]]:
    for begin, end in iterate_blocks(len(moves), from_move):
        first = max(begin - 2 * BESIDE, from_move)
        if end - first <= 2 * BESIDE or not (np.abs(np.diff(moves.end[first:end, :6], axis=0)) > _LEAST).any():
            continue
        for row, axes, factor, code in _find_doubtful(moves, slice(first, end)):
            at = first + row
            yield at, code, partial(_describe, moves.end[at - 1 : at + 2], axes, factor, code)


def _find_doubtful(moves: Moves, block: slice) -> Iterator[tuple[int, tuple[int, ...], float, str]]:
    """Rows of a block that are in doubt, the axes whose words are, by what the number is wrong, and the code."""
    is_cut = moves.kind[block] == MoveKind.FEED
    points = moves.end[block, :6]
    start, low, own, high, last = view_beside(points)
    all_cuts = view_beside(is_cut).all(axis=0)
    gap, middle = high - low, 0.5 * (low + high)
    step = np.maximum(np.abs(low - start), np.abs(last - high))
    away = np.maximum(np.minimum(low, high) - own, own - np.maximum(low, high))
    leaves = away > np.maximum(_TIMES_STEP * step, _LEAST)
    rows = np.flatnonzero(all_cuts & leaves.any(axis=1))
    gap, middle, step, own, leaves = (one[rows] for one in (gap, middle, step, own, leaves))
    half = 0.5 * gap
    uneven = np.maximum(np.abs((low - start)[rows] - half), np.abs((last - high)[rows] - half))
    goes_on = (uneven <= _UNEVEN * np.abs(gap)) & (gap != 0.0)
    stands = (gap == 0.0) & (step == 0.0)
    stands[:, 3:] = False  # check_rotary_words
    widest = np.abs(gap).reshape(-1, 2, 3).max(axis=2).repeat(3, axis=1)  # of the linear axes, of the rotary ones
    keeps = (np.abs(own - middle) <= np.abs(half) + step) & (uneven <= np.maximum(_UNEVEN * widest, _LEAST))
    for k, row in enumerate(rows.tolist()):
        axes = tuple(np.flatnonzero(leaves[k]).tolist())
        at, is_free = row + BESIDE, bool(np.isfinite(moves.tool_axis[block.start + row + BESIDE, 0]))
        follows = goes_on[k] | (stands[k] & (widest[k] > 0.0))
        if len(axes) > 2 or not (follows[list(axes)].all() and np.delete(keeps[k], axes).all()):
            continue
        others = np.setdiff1d(np.arange(3), axes)
        along = others[int(np.argmax(np.abs(gap[k, others])))]
        if gap[k, along] and not np.abs(own[k, along] - middle[k, along]) < np.abs(half[k, along]):
            continue  # up or down, where the tip stands else
        if axes[-1] >= 3 and (is_free or (len(axes) == 1 and away[row, axes[0]] > TURN_DEG)):
            continue  # its angles are those of a tool axis; check_rotary_words
        near = np.maximum(_OFF * np.abs(gap[k]), START_POSE_MM)
        if len(axes) == 1:
            slips = ((factor, code) for factor, code in _SLIPS if _fits(factor * own[k], middle[k], near)[axes[0]])
            for factor, code in slips:
                yield at, axes, factor, code
                break
        elif axes[0] >= 3 and _fits(own[k, list(axes[::-1])], middle[k, list(axes)], near[list(axes)]).all():
            yield at, axes, 1.0, "VP056"


def _fits(value: Array, middle: Array, near: Array) -> NDArray[np.bool_]:
    return np.asarray(np.abs(value - middle) <= near)


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
