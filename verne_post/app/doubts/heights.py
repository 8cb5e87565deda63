"""Rapids that go deeper than every cut of their tool: mostly a height with the wrong sign."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.moves import MoveKind, Moves, find_tool_of_moves

#: The kind of what is found: a limit that the same line breaks says it, too.
HEIGHT: Final = "height"
#: Rapids that go to the depth of a cut or hardly deeper may be meant, mm.
_DEEPER_MM: Final = 0.5


def check_heights(moves: Moves, begin: int = 0) -> Iterator[Finding]:
    """VP505, once a program: the first rapid below every cut of its tool in the same system whose height with the
    other sign is that of another rapid of the program.

    ``begin``: the first move that is judged; cuts before it count.

    Who spot-faces from behind, deburrs a lower edge or mills a thread upwards goes down so, too: a height from which
    cuts begin is meant, unless it is the first one of its tool, which comes from where tools are changed. Cycles
    plunge as they must, and a line that cuts, too, is one. Nor is a line looked at of which something else was found.
    """
    cuts = ~np.isin(moves.kind, (MoveKind.RAPID, MoveKind.DWELL))
    rapids = (moves.kind == MoveKind.RAPID) & ~moves.find_in_machine()
    if len(moves) < 2 or not cuts.any():
        return
    tools = find_tool_of_moves(np.arange(len(moves)), 0, moves)
    begins = np.flatnonzero(np.append(True, (np.diff(moves.frame) != 0) | (np.diff(tools) != 0)))
    _pairs, of_run = np.unique(np.column_stack([moves.frame, tools])[begins], axis=0, return_inverse=True)
    system = np.repeat(of_run.reshape(-1), np.diff(begins, append=len(moves)))
    end = moves.end[:, :3]
    start = np.vstack([moves.start[None, :3], end[:-1]])
    follows = np.append(False, np.diff(system) == 0)
    lowest = np.full(int(system.max()) + 1, np.inf)
    # a cut straight up is no sign of depth: it may only leave it
    beside = (np.abs(end - start)[:, :2] > 0.0).any(axis=1)
    depths = np.where(follows & (beside | (end[:, 2] < start[:, 2])), np.minimum(start[:, 2], end[:, 2]), end[:, 2])
    np.minimum.at(lowest, system[cuts], _lower_arcs(moves, depths)[cuts])
    deep = rapids & (end[:, 2] < lowest[system] - _DEEPER_MM) & np.isfinite(lowest[system])
    deep &= ~np.isin(moves.line, moves.line[cuts]) & ~np.isin(moves.line, [item.line or 0 for item in moves.findings])
    lengths = np.array([frame.tool_length for frame in moves.frames])[moves.frame]
    first = np.append(False, (np.diff(tools) != 0) | (np.diff(lengths) != 0))  # as in G43 Z50 H1
    deep &= first | (follows & (end[:, 2] < start[:, 2]))
    deep[:begin] = False
    if not deep.any():
        return
    deep &= np.isin(-end[:, 2], end[rapids, 2])
    begun = start[cuts & follows, 2]
    for at in np.flatnonzero(deep).tolist():
        line, height, cut = int(moves.line[at]), float(end[at, 2]), float(lowest[system[at]])
        if not first[at] and height in begun[system[cuts & follows] == system[at]]:
            continue
        if (end[:at, 2][rapids[:at] & (system[:at] == system[at])] < height).any():
            continue  # it has been lower
        text = (
            f"this rapid goes down to Z {height:.6g} mm, the deepest cut of its tool is at Z {cut:.6g} mm, and other "
            f"rapids go to Z {-height:.6g} mm: is the sign of the height right?"
        )
        right = f"{-height:.6g}"
        edits = (Remedy(f"write Z{right}", right, line=line, word=("Z", height), is_choice=True),)
        yield make_finding("VP505", text, line=line, quantity=HEIGHT, edits=edits)
        return


def _lower_arcs(moves: Moves, depths: Array) -> Array:
    """The depths (n,) of moves, those of arcs outside the XY plane at the lowest point of their circles."""
    at = np.flatnonzero(moves.arc >= 0)
    at = at[moves.arcs.plane[moves.arc[at]] != 0]
    center, lower = moves.arcs.center[moves.arc[at]], depths.copy()
    lower[at] = np.minimum(lower[at], center[:, 2] - np.linalg.norm(moves.end[at, :3] - center, axis=1))
    return lower
