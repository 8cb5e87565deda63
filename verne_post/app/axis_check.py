"""One cut whose tool axis differs from all beside it: by the sign of a component, or the point of a rotary word."""

import re
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text
from verne_post.base.program_lines import flip_component, name_component
from verne_post.base.tolerances import ZERO_ANGLE
from verne_post.model.findings import Finding, Remedy, add_line, make_finding
from verne_post.model.moves import AXES, MoveKind, Moves
from verne_post.model.protocols import Coordinates

#: So many cuts on either side have axes that agree.
_BESIDE: Final = 2
#: Cosine between axes that agree: 5 degrees. Steps of finely divided surfaces are smaller.
_AGREES: Final = 0.9962
#: Cosine between axes that a cut does not turn to and back: 30 degrees.
_DIFFERS: Final = 0.866
#: A line of Klartext that gives the tool axis, and how far rotary axes turn at least for a wrong sign, deg.
_LN: Final = re.compile(rb"[ \t]*+(?:\d+[ \t]++)?LN\b", re.IGNORECASE)
_TURN_DEG: Final = 15.0
#: Rotary words of cuts beside each other, deg: they differ by less; one that has lost its point, by more.
_NEAR_DEG: Final = 15.0
_AWAY_DEG: Final = 30.0
#: mm along the component whose sign differs: where the tip goes farther, it may go to another flank and back.
_ASIDE: Final = 5.0


def check_axes(moves: Moves, from_move: int = 0) -> Iterator[Finding]:
    """VP056: the sign of one component of a tool axis is in doubt; one finding a program.

    With the other sign, the axis is that of two cuts before and two after it, and these agree. The tip stays where it
    is along that component: it does not go to another flank.
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
    turns: NDArray[np.bool_] = np.any(np.abs(np.diff(moves.end[:, 3:6], axis=0)) > _TURN_DEG, axis=1)
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


def check_angles(moves: Moves, from_move: int = 0) -> Iterator[Finding]:
    """VP505: the decimal point of a rotary word is in doubt; one finding a program.

    Two cuts before and two after have nearly the same angle, this one is far from it, and a tenth of it is between its
    neighbours. Who turns the table for one cut, and back, leaves the part by a rapid.
    """
    for begin, end in iterate_blocks(len(moves), from_move):
        first = max(begin - 2 * _BESIDE, from_move)
        n, width = end - first, 2 * _BESIDE + 1
        if n < width:
            continue
        kind, angles = moves.kind[first:end], moves.end[first:end, 3:6]
        cuts = np.all([kind[shift : n - width + 1 + shift] == MoveKind.FEED for shift in range(width)], axis=0)
        own = angles[_BESIDE : n - _BESIDE]
        beside = np.array([angles[shift : n - width + 1 + shift] for shift in range(width) if shift != _BESIDE])
        low, high = beside.min(axis=0), beside.max(axis=0)
        around = beside[_BESIDE - 1 : _BESIDE + 1]
        tenth = own / 10.0
        is_between = (tenth >= around.min(axis=0) - ZERO_ANGLE) & (tenth <= around.max(axis=0) + ZERO_ANGLE)
        is_far = (own < low - _AWAY_DEG) | (own > high + _AWAY_DEG)
        doubtful = cuts[:, None] & is_between & is_far & (high - low < _NEAR_DEG)
        for row, axis in np.argwhere(doubtful).tolist():
            line, value = int(moves.line[first + _BESIDE + row]), float(own[row, axis])
            letter, right = AXES[3 + axis], f"{value / 10.0:.6g}"
            text = (
                f"{letter}{value:.6g} in this cut, and {letter}{around[0, row, axis]:.6g} and "
                f"{letter}{around[1, row, axis]:.6g} in those before and after it: is {letter}{right} meant?"
            )
            edits = (Remedy(f"write {letter}{right}", right, line=line, word=(letter, value), is_choice=True),)
            yield make_finding("VP505", text, line=line, last_line=line, worst_line=line, edits=edits)
            return


def _find_doubtful(axis: Array, tip: Array, kind: NDArray[np.int8]) -> Iterator[tuple[int, int]]:
    """Rows of axes (n, 3) that are in doubt, and the component whose sign is; ``tip`` (n, 3) where the moves end."""
    n, width = len(axis), 2 * _BESIDE + 1
    if n < width or not np.isfinite(axis).any():
        return
    own = axis[_BESIDE : n - _BESIDE]
    cuts = np.all([kind[shift : n - width + 1 + shift] == MoveKind.FEED for shift in range(width)], axis=0)
    beside = [axis[shift : n - width + 1 + shift] for shift in range(width) if shift != _BESIDE]
    agree = np.all([(one * beside[0]).sum(axis=1) > _AGREES for one in beside[1:]], axis=0)
    agree &= cuts & ((own * beside[0]).sum(axis=1) < _DIFFERS)
    for row in np.flatnonzero(agree).tolist():
        for component in range(3):
            other = own[row].copy()
            other[component] *= -1.0
            at = _BESIDE + row
            aside = np.abs(tip[[at - 1, at + 1], component] - tip[at, component]).max()
            if aside <= _ASIDE and all(one[row] @ other > _AGREES for one in beside):
                yield at, component
                break
