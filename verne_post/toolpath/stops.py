"""Stops for a person as standstills among the moves: the file is cut there (``--split-at-stops``)."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from verne_post.model.moves import MOVE_COLUMNS, MoveKind, Moves

#: A stop stands as a dwell of this length, which becomes one cycle.
STOP_SECONDS: Final = 1e-9


def with_stops(moves: Moves, stops: Sequence[tuple[int, int]]) -> tuple[Moves, tuple[int, ...]]:
    """Put standstills among the moves; returns the moves, and the places of the standstills.

    Parameters
    ----------
    moves : Moves
    stops : sequence of (int, int)
        Number of the move that follows, and source line; ascending, each number once.
    """
    at = np.array([before for before, _line in stops], dtype=np.intp)
    rows = {name: np.insert(getattr(moves, name), at, getattr(moves, name)[at - 1], axis=0) for name in MOVE_COLUMNS}
    new = at + np.arange(len(at))
    rows["line"][new] = [line for _before, line in stops]
    rows["kind"][new], rows["feed"][new], rows["arc"][new] = MoveKind.DWELL, STOP_SECONDS, -1
    events = tuple(
        replace(event, before=event.before + int(np.searchsorted(at, event.before, side="left")))
        for event in moves.events
    )
    return replace(moves, events=events, **rows), tuple(new.tolist())
