"""Tool axes of one cut that differ from those of all cuts beside it by the sign of one component."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.columns import iterate_blocks
from verne_post.base.program_lines import name_component
from verne_post.model.findings import Finding, add_line, make_finding
from verne_post.model.moves import MoveKind, Moves

#: So many cuts on either side have axes that agree.
_BESIDE: Final = 2
#: Cosine between axes that agree: 5 degrees. Steps of finely divided surfaces are smaller.
_AGREES: Final = 0.9962
#: Cosine between axes that a cut does not turn to and back: 30 degrees.
_DIFFERS: Final = 0.866
#: mm along the component whose sign differs: where the tip goes farther, it may go to another flank and back.
_ASIDE: Final = 5.0
#: mm: where it goes farther and comes back at once, it may be behind a rib. Steps of surfaces are smaller.
_BACK: Final = 0.5


def check_axes(moves: Moves, from_move: int = 0) -> Iterator[Finding]:
    """VP056: the sign of one component of a tool axis is in doubt; one finding a program.

    With the other sign, the axis is that of two cuts before and two after it, and these agree. The tip stays where it
    is along that component: it does not go to another flank, nor to the other side of a rib.
    """
    found: Finding | None = None
    for begin, end in iterate_blocks(len(moves), from_move):
        first = max(begin - 2 * _BESIDE, from_move)
        axis, kind = moves.tool_axis[first:end], moves.kind[first:end]
        for at, component in _find_doubtful(axis, moves.end[first:end, :3], kind):
            line = int(moves.line[first + at])
            if found is not None:
                found = add_line(found, line)
                continue
            name = name_component(moves.language, component)
            text = (
                f"the tool axis of this cut is that of the cuts before and after it, but for the sign of {name} "
                f"({axis[at, component] + 0.0:.4g}): is the other sign meant?"
            )
            found = make_finding("VP056", text, line=line, last_line=line, worst_line=line)
    if found is not None:
        yield found


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
            aside = tip[[at - 1, at + 1], component] - tip[at, component]
            is_back = (aside > _BACK).all() or (aside < -_BACK).all()
            if not is_back and np.abs(aside).max() <= _ASIDE and all(one[row] @ other > _AGREES for one in beside):
                yield at, component
                break
