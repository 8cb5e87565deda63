"""Stops for a person as standstills among the moves: the file is cut there (``--split-at-stops``)."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.model.moves import MOVE_COLUMNS, MoveKind, Moves
from verne_post.model.toolpath import ToolPath, sections_at

#: A stop stands as a dwell of this length, which becomes one cycle.
STOP_SECONDS: Final = 1e-9


def insert_stops(
    moves: Moves, path: ToolPath, stops: Sequence[tuple[int, int]]
) -> tuple[Moves, ToolPath, tuple[int, ...]]:
    """Put standstills among the moves and along their path; returns both, and the numbers of the standstills.

    Parameters
    ----------
    path : ToolPath
        Of these moves.
    stops : sequence of (int, int)
        Number of the move that follows, and source line; ascending, each number once.
    """
    at = np.array([before for before, _line in stops], dtype=np.intp)
    rows = {name: np.insert(getattr(moves, name), at, getattr(moves, name)[at - 1], axis=0) for name in MOVE_COLUMNS}
    new = at + np.arange(len(at))
    rows["line"][new] = [line for _before, line in stops]
    rows["kind"][new], rows["feed"][new], rows["arc"][new], rows["spline"][new] = MoveKind.DWELL, STOP_SECONDS, -1, -1
    events = tuple(
        replace(event, before=event.before + int(np.searchsorted(at, event.before, side="left")))
        for event in moves.events
    )
    stopped = replace(moves, events=events, **rows)
    return stopped, _insert_in_path(path, stopped, at), tuple(new.tolist())


def _insert_in_path(path: ToolPath, moves: Moves, at: NDArray[np.intp]) -> ToolPath:
    """Put standstills into the path before the moves ``at``, which are counted without them."""
    move = path.move + np.searchsorted(at, path.move, side="right")
    new_section = np.diff(path.section, prepend=path.section[:1]) > 0
    new_section[np.searchsorted(path.move, at)] = True
    new_section[0] = False
    section = np.cumsum(new_section).astype(np.int32)
    dwell = moves.dwells
    return replace(
        path, move=move.astype(np.int32), section=section, dwell_section=sections_at(section, np.searchsorted(move, dwell)),
        dwell_seconds=moves.feed[dwell], dwell_line=moves.line[dwell],
    )  # fmt: skip
