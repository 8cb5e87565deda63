"""Laws -> rows: the timeline of runs and dwells in whole control cycles, and which pose each row has."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import give_up, running_sums
from verne_post.model.contour import Contour
from verne_post.timing.plan import Planning, RunPlan, dwell_cycles
from verne_post.timing.playback import Playback

Array = NDArray[np.float64]
Ints = NDArray[np.integer]

#: Rows made at a time; memory does not depend on the length of the program's motion.
BLOCK_ROWS: Final = 8192


@dataclass(frozen=True, eq=False)
class Timeline:
    """Runs and dwells in order, each a whole number of cycles.

    Attributes
    ----------
    run : ndarray of intp, shape (m,)
        Run of each item, -1 for a dwell.
    line : ndarray, shape (m,)
        Source line of a dwell, 0 for a run.
    first_row : ndarray, shape (m + 1,)
        Row at which each item begins; the last entry is the last row of the file.
    cycle : float
        s.
    playback : Playback
        How fast the laws are played.
    """

    run: Ints
    line: Ints
    first_row: Ints
    cycle: float
    playback: Playback

    @property
    def n_rows(self) -> int:
        """Rows of the whole file: from rest to rest, both ends included."""
        return int(self.first_row[-1]) + 1


def timeline(contour: Contour, laws: RunPlan, planning: Planning) -> Timeline:
    """Lay runs and dwells end to end, each a whole number of cycles."""
    dwells = dwell_cycles(contour, planning.cycle)
    n_runs, n_dwells = len(laws.cycles), len(dwells)
    # a dwell comes before the run with its number
    position = np.concatenate([np.arange(n_runs) + 0.5, contour.dwell_run.astype(float)])
    order = np.argsort(position, kind="stable")
    run: Ints = np.concatenate([np.arange(n_runs), np.full(n_dwells, -1)])[order]
    line = np.concatenate([np.zeros(n_runs, np.int64), contour.path.dwell_line])[order]
    cycles = np.concatenate([laws.cycles, dwells])[order]
    return Timeline(run, line, np.append(0, np.cumsum(cycles)), planning.cycle, planning.playback)


@dataclass(frozen=True, eq=False)
class Rows:
    """Consecutive rows: the number of the first, and for each (n,) its pose, source line, and dwell (-1 in a motion)."""

    first: int
    segment: Ints
    w: Array
    line: Ints
    dwell: Ints


def rows(contour: Contour, laws: RunPlan, plan: Timeline) -> Iterator[Rows]:
    """All rows, block by block."""
    run_begin, run_end = contour.run_begins[:-1], contour.run_begins[1:]
    ends = running_sums(contour.length)[1:]
    last_segment = run_end - 1
    # dwells rest where the next run starts, or where the last one ended
    runs_before = np.cumsum(plan.run >= 0)
    dwell = np.where(plan.run < 0, np.cumsum(plan.run < 0) - 1, -1)
    next_run = np.where(runs_before < len(run_begin), runs_before, -1)
    for first in range(0, plan.n_rows, BLOCK_ROWS):
        give_up()
        k = np.arange(first, min(first + BLOCK_ROWS, plan.n_rows))
        item = np.minimum(np.searchsorted(plan.first_row, k, side="right") - 1, len(plan.run) - 1)
        run = plan.run[item]
        moving = run >= 0
        owner = np.where(moving, run, next_run[item])
        after_all = owner < 0
        owner[after_all] = len(run_begin) - 1
        cycles = plan.first_row[item + 1] - plan.first_row[item]
        row = k - plan.first_row[item]
        done = plan.playback.shares(
            row.astype(float), np.maximum(cycles, 1), plan.cycle * plan.first_row[item].astype(float), plan.cycle
        )
        s = laws.laws.position(owner, np.where(moving, done * laws.laws.total[owner], 0.0))
        flows = np.flatnonzero(moving & (laws.flow_first[owner] >= 0))
        s[flows] = laws.flow_s[laws.flow_first[owner[flows]] + row[flows]]
        begin = run_begin[owner]
        at = ends[begin] - contour.length[begin] + s
        segment = np.clip(np.searchsorted(ends, at, side="right"), run_begin[owner], last_segment[owner])
        length = contour.length[segment]
        w = np.clip((at - (ends[segment] - length)) / length, 0.0, 1.0)
        finished = after_all | (k == plan.first_row[item + 1])
        segment[finished], w[finished] = last_segment[owner[finished]], 1.0
        yield Rows(first, segment, w, np.where(moving, contour.line(segment), plan.line[item]), dwell[item])
