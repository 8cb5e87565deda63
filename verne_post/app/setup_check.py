"""What the set-up leaves open although the program uses it: warnings before anything else is looked at."""

import numpy as np

from verne_post.base.columns import blocks
from verne_post.gcode.missing_setup import missing_offset
from verne_post.model.findings import Finding, finding
from verne_post.model.machine import Machine
from verne_post.model.moves import Moves
from verne_post.model.options import Options
from verne_post.model.toolpath import ToolPath
from verne_post.model.work_systems import placed_by


def check_setup(moves: Moves, path: ToolPath, machine: Machine, options: Options) -> list[Finding]:
    """Work systems that nobody has placed (VP033), and feed motion with a tool of no length (VP034)."""
    systems: dict[int, int] = {}  # index of a frame -> first move that uses it
    bare = -1
    for begin, end in blocks(len(path)):
        move = path.move[begin:end]
        used, first = np.unique(moves.frame[move[move >= 0]], return_index=True)
        for frame, at in zip(used.tolist(), move[move >= 0][first].tolist(), strict=True):
            systems.setdefault(frame, at)
        cutting = np.flatnonzero((path.tool_length[begin:end] == 0.0) & (path.feed_time[begin:end] > 0) & (move >= 0))
        if bare < 0 and len(cutting):
            bare = int(move[cutting[0]])
    unplaced: dict[int, int] = {}  # system -> first move that uses it
    for index, at in sorted(systems.items(), key=lambda item: item[1]):
        frame = moves.frames[index]
        if placed_by(frame, machine, options, moves.placed_systems) == "nobody":
            unplaced.setdefault(frame.system, at)
    found = [missing_offset(system, int(moves.line[at])) for system, at in unplaced.items()]
    if bare >= 0 and options.tool_length is None:
        text = (
            "the tool has a length of 0 mm here (G49, or a table says so): its tip is the gauge line of the spindle; "
            "write G43 with its length, or give --tool-length"
        )
        line = int(moves.line[bare])
        found.append(finding("VP034", text, line=line, last_line=line, worst_line=line))
    return found
