"""Profiles -> rows: the timeline of sections and dwells in whole control cycles, and which pose each row has."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import release_memory, running_sums
from verne_post.model.contour import Contour
from verne_post.trajectory.override import FeedOverride
from verne_post.trajectory.plan import MotionProfiles, PlanningOptions, dwell_cycles

Array = NDArray[np.float64]
Ints = NDArray[np.integer]

#: Rows made at a time; memory does not depend on the length of the program's motion.
BLOCK_ROWS: Final = 8192


@dataclass(frozen=True, eq=False)
class Timeline:
    """Sections and dwells in order, each a whole number of cycles.

    Attributes
    ----------
    section : ndarray of intp, shape (m,)
        Section of each item, -1 for a dwell.
    line : ndarray, shape (m,)
        Source line of a dwell, 0 for a section.
    first_row : ndarray, shape (m + 1,)
        Row at which each item begins; the last entry is the last row of the file.
    cycle : float
        s.
    playback : FeedOverride
        How fast the profiles are executed.
    """

    section: Ints
    line: Ints
    first_row: Ints
    cycle: float
    playback: FeedOverride

    @property
    def n_rows(self) -> int:
        """Rows of the whole file: from rest to rest, both ends included."""
        return int(self.first_row[-1]) + 1


def timeline(contour: Contour, profiles: MotionProfiles, planning: PlanningOptions) -> Timeline:
    """Lay sections and dwells end to end, each a whole number of cycles."""
    dwells = dwell_cycles(contour, planning.cycle)
    n_sections, n_dwells = len(profiles.cycles), len(dwells)
    # a dwell comes before the section with its number
    position = np.concatenate([np.arange(n_sections) + 0.5, contour.dwell_section.astype(float)])
    order = np.argsort(position, kind="stable")
    section: Ints = np.concatenate([np.arange(n_sections), np.full(n_dwells, -1)])[order]
    line = np.concatenate([np.zeros(n_sections, np.int64), contour.path.dwell_line])[order]
    cycles = np.concatenate([profiles.cycles, dwells])[order]
    return Timeline(section, line, np.append(0, np.cumsum(cycles)), planning.cycle, planning.playback)


@dataclass(frozen=True, eq=False)
class Rows:
    """Consecutive rows: the number of the first, and for each (n,) its pose, source line, and dwell (-1 in a motion)."""

    first: int
    element: Ints
    w: Array
    line: Ints
    dwell: Ints


def rows(contour: Contour, profiles: MotionProfiles, plan: Timeline) -> Iterator[Rows]:
    """All rows, block by block."""
    section_begin, section_end = contour.section_begins[:-1], contour.section_begins[1:]
    ends = running_sums(contour.length)[1:]
    last_element = section_end - 1
    # dwells rest where the next section starts, or where the last one ended
    sections_before = np.cumsum(plan.section >= 0)
    dwell = np.where(plan.section < 0, np.cumsum(plan.section < 0) - 1, -1)
    next_section = np.where(sections_before < len(section_begin), sections_before, -1)
    for first in range(0, plan.n_rows, BLOCK_ROWS):
        release_memory()
        k = np.arange(first, min(first + BLOCK_ROWS, plan.n_rows))
        item = np.minimum(np.searchsorted(plan.first_row, k, side="right") - 1, len(plan.section) - 1)
        section = plan.section[item]
        moving = section >= 0
        owner = np.where(moving, section, next_section[item])
        after_all = owner < 0
        owner[after_all] = len(section_begin) - 1
        cycles = plan.first_row[item + 1] - plan.first_row[item]
        row = k - plan.first_row[item]
        done = plan.playback.shares(
            row.astype(float), np.maximum(cycles, 1), plan.cycle * plan.first_row[item].astype(float), plan.cycle
        )
        s = profiles.profiles.position(owner, np.where(moving, done * profiles.profiles.total[owner], 0.0))
        flows = np.flatnonzero(moving & (profiles.continuous_first[owner] >= 0))
        s[flows] = profiles.continuous_s[profiles.continuous_first[owner[flows]] + row[flows]]
        begin = section_begin[owner]
        at = ends[begin] - contour.length[begin] + s
        element = np.clip(np.searchsorted(ends, at, side="right"), section_begin[owner], last_element[owner])
        length = contour.length[element]
        w = np.clip((at - (ends[element] - length)) / length, 0.0, 1.0)
        finished = after_all | (k == plan.first_row[item + 1])
        element[finished], w[finished] = last_element[owner[finished]], 1.0
        yield Rows(first, element, w, np.where(moving, contour.line(element), plan.line[item]), dwell[item])
