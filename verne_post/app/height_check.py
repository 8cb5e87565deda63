"""Rapids that go deeper than every cut of their tool: mostly a height with the wrong sign."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.findings import Finding, make_finding
from verne_post.model.moves import MoveKind, Moves, find_tool_of_moves

#: The kind of what is found: a limit that the same line breaks says it, too.
HEIGHT: Final = "height"
#: Rapids that go to the depth of a cut or hardly deeper may be meant, mm.
_DEEPER_MM: Final = 0.5


def check_heights(moves: Moves, begin: int = 0) -> Iterator[Finding]:
    """VP505, once a program: the first rapid that goes down below every cut of its tool in the same system.

    ``begin``: the first move that is judged; cuts before it count.

    A cut straight up is no sign of depth: it may only leave it. Cycles plunge as they must, as those that bore
    backwards, and a line that cuts, too, is one. Nor is a line looked at of which something else was found.
    """
    cuts = ~np.isin(moves.kind, (MoveKind.RAPID, MoveKind.DWELL))
    if len(moves) < 2 or not cuts.any():
        return
    tools = find_tool_of_moves(np.arange(len(moves)), 0, moves)
    _pairs, system = np.unique(np.column_stack([moves.frame, tools]), axis=0, return_inverse=True)
    system = system.reshape(-1)
    end = moves.end[:, :3]
    start = np.vstack([moves.start[None, :3], end[:-1]])
    follows = np.append(False, np.diff(system) == 0)
    lowest = np.full(int(system.max()) + 1, np.inf)
    beside = (np.abs(end - start)[:, :2] > 0.0).any(axis=1)
    depths = np.where(follows & (beside | (end[:, 2] < start[:, 2])), np.minimum(start[:, 2], end[:, 2]), end[:, 2])
    np.minimum.at(lowest, system[cuts], _lower_arcs(moves, depths)[cuts])
    lengths = np.array([frame.tool_length for frame in moves.frames])[moves.frame]
    is_called = np.append(False, (np.diff(tools) != 0) | (np.diff(lengths) != 0))  # as in G43 Z50 H1
    deep = (moves.kind == MoveKind.RAPID) & ~moves.find_in_machine()
    deep &= is_called | (follows & (end[:, 2] < start[:, 2]))
    deep &= (
        (end[:, 2] < lowest[system] - _DEEPER_MM) & np.isfinite(lowest[system]) & ~np.isin(moves.line, moves.line[cuts])
    )
    deep &= ~np.isin(moves.line, [item.line or 0 for item in moves.findings])
    for at in (begin + np.flatnonzero(deep[begin:])[:1]).tolist():
        line, height, cut = int(moves.line[at]), float(end[at, 2]), float(lowest[system[at]])
        text = (
            f"this rapid goes down to Z {height:.6g} mm, and the deepest cut of its tool is at Z {cut:.6g} mm: is the "
            "sign of the height right?"
        )
        yield make_finding("VP505", text, line=line, last_line=line, worst_line=line, quantity=HEIGHT)


def _lower_arcs(moves: Moves, depths: Array) -> Array:
    """The depths (n,) of moves, those of arcs outside the XY plane at the lowest point of their circles."""
    at = np.flatnonzero(moves.arc >= 0)
    at = at[moves.arcs.plane[moves.arc[at]] != 0]
    center, lower = moves.arcs.center[moves.arc[at]], depths.copy()
    lower[at] = np.minimum(lower[at], center[:, 2] - np.linalg.norm(moves.end[at, :3] - center, axis=1))
    return lower
