"""Profiles -> rows: the timeline of sections and dwells in whole control cycles, and which pose each row has."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import release_memory, sum_running
from verne_post.model.contour import Contour
from verne_post.trajectory.override import FeedOverride
from verne_post.trajectory.plan import MotionProfiles, PlanningOptions, dwell_cycles
from verne_post.trajectory.shaper import shape_rows

#: Rows made at a time; memory does not depend on the length of the program's motion.
BLOCK_ROWS: Final = 8192


class Timeline(Struct, frozen=True, eq=False):
    """Sections and dwells in order, each a whole number of cycles."""

    section: Ints  #: (m,): Section of each item, -1 for a dwell.
    line: Ints  #: (m,): Source line of a dwell, 0 for a section.
    first_row: Ints  #: (m + 1,): Row at which each item begins; the last entry is the last row of the file.
    cycle: float  #: s.
    playback: FeedOverride  #: How fast the profiles are executed.
    weights: Array  #: (2 h + 1,): Of the input shaper; each section has h cycles of rest before and after its motion.

    @property
    def n_rows(self) -> int:
        """Rows of the whole file: from rest to rest, both ends included."""
        return int(self.first_row[-1]) + 1

    @property
    def rest(self) -> int:
        """Cycles of rest before and after the motion of each section."""
        return len(self.weights) // 2


def lay_out(contour: Contour, profiles: MotionProfiles, planning: PlanningOptions) -> Timeline:
    """Lay sections and dwells end to end, each a whole number of cycles."""
    dwells = dwell_cycles(contour, planning.cycle)
    n_sections, n_dwells = len(profiles.cycles), len(dwells)
    # a dwell comes before the section with its number
    position = np.concatenate([np.arange(n_sections) + 0.5, contour.dwell_section.astype(float)])
    order = np.argsort(position, kind="stable")
    section: Ints = np.concatenate([np.arange(n_sections), np.full(n_dwells, -1)])[order]
    line = np.concatenate([np.zeros(n_sections, np.int64), contour.path.dwell_line])[order]
    cycles = np.concatenate([profiles.cycles + 2 * planning.rest, dwells])[order]
    return Timeline(section, line, np.append(0, np.cumsum(cycles)), planning.cycle, planning.playback, planning.weights)


class Rows(Struct, frozen=True, eq=False):
    """Consecutive rows (n,): what the joints are solved at, and what each row shows."""

    first: int  #: Number of the first row.
    #: element, w (n + 2 h,): Where the motion is before an input shaper of 2 h + 1 weights, from h rows before
    #: these to h rows after them.
    element: Ints
    w: Array
    #: shown, shown_w (n,): The same after the shaper, which displaces the motion along the path and beside it;
    #: the latter is left out here.
    shown: Ints
    shown_w: Array
    at: Array  #: (n,): Length of the path up to there, mm.
    #: line, dwell (n,): Source line, and dwell (-1 in a motion).
    line: Ints
    dwell: Ints


class RowSampler:
    """Where the motion of a timeline is at any of its rows."""

    def __init__(self, contour: Contour, profiles: MotionProfiles, plan: Timeline) -> None:
        self.contour, self.profiles, self.plan = contour, profiles, plan
        self.section_begin, self.last_element = contour.section_begins[:-1], contour.section_begins[1:] - 1
        self.ends = sum_running(contour.length)[1:]
        # dwells rest where the next section starts, or where the last one ended
        sections_before = np.cumsum(plan.section >= 0)
        self.dwell = np.cumsum(plan.section < 0) - 1
        self.next_section = np.where(sections_before < len(self.section_begin), sections_before, -1)

    def list_blocks(self) -> range:
        """First rows of the blocks that make up the whole file."""
        return range(0, self.plan.n_rows, BLOCK_ROWS)

    def make_rows(self, first: int) -> Rows:
        """The rows of a block, by its first one."""
        release_memory()
        plan, h = self.plan, self.plan.rest
        last = min(first + BLOCK_ROWS, plan.n_rows)
        # the file begins and ends at rest
        k = np.clip(np.arange(first - h, last + h), 0, plan.n_rows - 1)
        item = np.minimum(np.searchsorted(plan.first_row, k, side="right") - 1, len(plan.section) - 1)
        owner, at = self._measure_path_lengths(k, item)
        finished = self._find_finished_rows(k, item)
        element, w = self._locate(owner, at, finished)
        middle = slice(h, len(k) - h)
        shown, shown_w = element, w
        if h:
            at = shape_rows(at, plan.weights)
            shown, shown_w = self._locate(owner[middle], at, finished[middle])
        section, own = plan.section[item[middle]], item[middle]
        dwell = np.where(section < 0, self.dwell[own], -1)
        line = np.where(section >= 0, self.contour.find_lines(shown), plan.line[own])
        return Rows(first, element, w, shown, shown_w, at, line, dwell)

    def _measure_path_lengths(self, k: Ints, item: Ints) -> tuple[Ints, Array]:
        """Section that rows k (n,) of items (n,) are on, and the length of the path up to them, mm."""
        plan, profiles = self.plan, self.profiles
        section = plan.section[item]
        moving = section >= 0
        owner = np.where(moving, section, self.next_section[item])
        owner[owner < 0] = len(self.section_begin) - 1
        rest = np.where(moving, plan.rest, 0)
        begin = plan.first_row[item] + rest
        cycles = plan.first_row[item + 1] - rest - begin
        row = np.clip(k - begin, 0, cycles)
        done = plan.playback.find_shares(
            row.astype(float), np.maximum(cycles, 1), plan.cycle * begin.astype(float), plan.cycle
        )
        s = profiles.profiles.find_position(owner, np.where(moving, done * profiles.profiles.total[owner], 0.0))
        flows = np.flatnonzero(moving & (profiles.continuous_first[owner] >= 0))
        s[flows] = profiles.continuous_s[profiles.continuous_first[owner[flows]] + row[flows]]
        first = self.section_begin[owner]
        at = self.ends[first] - self.contour.length[first] + s
        return owner, np.where(self._find_final_dwells(item), self.ends[-1], at)

    def _find_finished_rows(self, k: Ints, item: Ints) -> Mask:
        """Whether rows k (n,) of items (n,) end their section: last rows of it, and dwells after all motion."""
        return np.asarray(self._find_final_dwells(item) | (k == self.plan.first_row[item + 1]))

    def _find_final_dwells(self, item: Ints) -> Mask:
        """Items (n,) that are dwells after all motion."""
        return np.asarray((self.plan.section[item] < 0) & (self.next_section[item] < 0))

    def _locate(self, owner: Ints, at: Array, finished: Mask) -> tuple[Ints, Array]:
        """Element (n,) of sections (n,) and w (n,) at lengths of the path (n,)."""
        last = self.last_element[owner]
        element = np.clip(np.searchsorted(self.ends, at, side="right"), self.section_begin[owner], last)
        length = self.contour.length[element]
        w = np.clip((at - (self.ends[element] - length)) / length, 0.0, 1.0)
        element[finished], w[finished] = last[finished], 1.0
        return element, w


class EventRows:
    """Finds the rows of events while rows go by.

    Parameters
    ----------
    before : ndarray of int, shape (n,)
        Number of the move that follows each event, ascending; -1 for what happens at the very beginning.
    """

    def __init__(self, before: Ints) -> None:
        self.before = before
        self.row = np.full(len(before), -1, dtype=np.int64)
        self.numbers: list[Array] = []
        self._last: Array | None = None
        self._seen = 0

    def take_rows(self, first: int, move: Ints, numbers: Array) -> None:
        """The next rows: the number of the first, the move that each belongs to, and what is written of it."""
        while len(self.numbers) < len(self.before):
            due = self.before[len(self.numbers)]
            at = 0 if due < 0 else int(np.argmax(move >= due)) if (move >= due).any() else -1
            if at < 0:
                break
            self._happens(first + at, numbers[at])
        self._last, self._seen = numbers[-1], first + len(move)

    def finish(self) -> None:
        """No more rows: what is left happens at the last one."""
        while self._last is not None and len(self.numbers) < len(self.before):
            self._happens(self._seen - 1, self._last)

    def _happens(self, row: int, numbers: Array) -> None:
        self.row[len(self.numbers)] = row
        self.numbers.append(numbers)
