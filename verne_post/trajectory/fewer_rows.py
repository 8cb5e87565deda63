"""Short sections in fewer rows: a control cycle less at a time, as long as shifts along the path keep every limit.

Over few rows the profile in continuous time is not the last word: limits hold for differences of rows, whose number is
whole, and a row is a share of the time that counts. Where there are several elements to a row, the rows that take the
least time need be near no profile: then a row is taken out at each place in turn. A section of a few dozen rows is
treated likewise, since its repair may have cost several.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.trajectory import tuning
from verne_post.trajectory.interpolation import resample_rows
from verne_post.trajectory.row_limits import REST_ROWS, add_rest, measure_rows_excess
from verne_post.trajectory.row_shifts import HELD_ROWS, shift_rows
from verne_post.trajectory.section_path import SectionTask

#: At so many places of a step the feed is looked at, several to an element where it is over ten.
PLACES_IN_STEP: Final = 64


def try_fewer_rows(task: SectionTask, s: Array, most: int = tuning.FEW_ROWS, rounds: int = 1) -> Array:
    """Path parameters of as few rows as are found inside every limit, from such rows s (n,), from rest to rest.

    Sections of more than ``most`` rows stay as they are. Rows spread over a cycle less are shifted in ``rounds``.
    """
    crowded = len(task.section.breaks) - 1 > tuning.CROWDED_ELEMENTS * len(s)
    while HELD_ROWS < len(s) <= most:
        found = (_find_legal(task, starts, count) for starts, count in _starts(s, crowded, rounds))
        faster = next((rows for rows in found if rows is not None), None)
        if faster is None:
            break
        s = faster
    return s


def _starts(s: Array, crowded: bool, rounds: int) -> Iterator[tuple[Array, int]]:
    """Rows (m, n - 1) that shifts may bring inside every limit, from such rows s (n,), and in how many rounds."""
    n = len(s)
    yield resample_rows(s, np.linspace(0.0, n - 1.0, n - 1)[None]), rounds
    widths, rounds = (tuning.TAKEN_OUT_OVER, tuning.CROWDED_ROUNDS) if crowded else ((tuning.SINGLE_OVER,), 1)
    for width in widths if crowded or n <= tuning.SINGLE_ROWS else ():
        yield resample_rows(s, _take_out(n, width)), rounds


def _take_out(n: int, width: int) -> Array:
    """Places (m, n - 1) of n - 1 rows among n, if one is taken out over ``width`` rows, from each third."""
    first = np.arange(-0.5 * width, n - 0.5 * width, width // 3)
    number = np.arange(n - 1.0)
    x = np.clip((number - first[:, None]) / width, 0.0, 1.0)
    return number + x**3 * (10.0 - x * (15.0 - 6.0 * x))


def _find_legal(task: SectionTask, starts: Array, rounds: int) -> Array | None:
    """The first of rows (m, n) that shifts bring inside every limit, shape (n,), or None. All are shifted at once.

    Shifts that are not small against a row's step need several rounds, each with the slopes where the rows then are.
    """
    count, n = len(starts), starts.shape[1] + 2 * REST_ROWS
    z = np.concatenate([add_rest(rows) for rows in starts])
    for _ in range(rounds):
        rows = shift_rows(z, np.full(count, n), n, task)
        shifted = rows.s.reshape(count, n)
        # what begins at the last rows of one begins at rest, and ends in the next one
        worst = (
            np.append(measure_rows_excess(rows, task), np.zeros(REST_ROWS))
            .reshape(count, n)[:, :-REST_ROWS]
            .max(axis=1)
        )
        for legal in np.flatnonzero((worst <= 1.0) & (np.diff(shifted) >= 0.0).all(axis=1)):
            s = np.array(shifted[legal, REST_ROWS:-REST_ROWS])
            if _keeps_feed(task, s):
                return s
        z = rows.s
    return None


def _keeps_feed(task: SectionTask, s: Array) -> bool:
    """Whether no step between rows s (n,) takes longer than a cycle at the feed, which is looked at all along it.

    A step over many elements may be faster than at its ends and in its middle, where :class:`JointRows` looks.
    """
    way = np.diff(s)
    places = (s[:-1] + (np.arange(PLACES_IN_STEP)[:, None] + 0.5) / PLACES_IN_STEP * way).ravel()
    speed = task.feed_share * np.asarray(task.section.find_speed(places), dtype=float).reshape(PLACES_IN_STEP, -1)
    spent = way * np.mean(1.0 / speed, axis=0)
    return bool(spent.max() <= tuning.ACCEPTED_RATIOS[0] * task.cycle)
