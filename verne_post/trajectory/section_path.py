"""A section between two standstills as a function of its path parameter s, and a grid with derivatives along it."""

from typing import Final, Protocol

import numpy as np
from msgspec import Struct, field

from verne_post.base import spans
from verne_post.base.arrays import Array
from verne_post.base.ragged import number_parts
from verne_post.base.rows import find_row_max
from verne_post.base.team import ALONE, Team
from verne_post.model.machine import Limits
from verne_post.trajectory import tuning

#: A span is halved at most so often, to a 64th: joints with a jump would otherwise be halved for ever.
SPAN_HALVINGS: Final = 6


class Section(Protocol):
    """Motion between two standstills.

    The joints are functions of s with continuous q' and q''; q''' may jump at ``breaks``. Bad input is
    found by what is computed from it: joints that are not finite, or lengths and breaks out of order.
    """

    @property
    def length(self) -> float:
        """Length by s, mm."""

    @property
    def breaks(self) -> Array:
        """Ends of the elements, from 0 to length, in order; both included."""

    def find_joints(self, s: Array) -> Array:
        """Joints (n, n_joints) at s (n,)."""

    def find_speed(self, s: Array) -> Array:
        """Largest ds/dt (n,) by the feed at s (n,), mm/s; infinite for rapids."""

    def measure_hidden(self, s: Array) -> Array:
        """Ratios (n - 1,) of steps between rows s (n,) to the longest that show the path; see ``visible``."""

    def find_joints_and_hidden(self, s: Array) -> tuple[Array, Array]:
        """What :meth:`find_joints` and :meth:`measure_hidden` say of rows s (n,), for less than one after the other."""


class SectionTask(Struct, frozen=True, eq=False):
    """A section that is planned, and what it is planned with."""

    section: Section
    limits: Limits
    #: cycle, unit: Control cycle, and the time scale of the profile, s.
    cycle: float
    unit: float
    #: (k, 2): Ranges of s in which the profile is known to be even, at the feed rate; see :mod:`cruise`.
    cruise: Array = field(default_factory=lambda: np.empty((0, 2)))
    feed_share: float = 1.0  #: Rows may have this share of the feed rate: the override that they are executed with.
    team: Team = ALONE  #: The processes that plan it.


class Grid(Struct, frozen=True, eq=False):
    """Points along a section, in order, with derivatives of the joints by s."""

    s: Array  #: (n,): mm; both ends included.
    #: d1, d2, d3 (n, n_joints)
    d1: Array
    d2: Array
    d3: Array
    speed: Array  #: (n,): Largest ds/dt by the feed, mm/s.


def build_grid_along(section: Section, first: int = 0, last: int | None = None) -> Grid:
    """Some Chebyshev points of spans over elements of a section, with spectral derivatives.

    Parameters
    ----------
    first, last : int
        Elements, ``last`` excluded; to the end of the section if None.

    Raises
    ------
    ValueError
        The section has no length, its breaks are out of order, or a joint or speed is not a number.
    """
    whole = np.asarray(section.breaks, dtype=float)
    if not (np.isfinite(section.length) and section.length > 0):
        raise ValueError(f"a section needs a finite length above 0, got {section.length}")
    breaks = whole[first:] if last is None else whole[first : last + 1]
    if len(breaks) < 2 or whole[0] != 0.0 or whole[-1] != section.length or not (np.diff(breaks) >= 0).all():
        raise ValueError(f"the breaks of a section rise from 0 to its length {section.length:g}")
    breaks = _join_short(section, breaks)
    width = np.diff(breaks)
    parts = np.ceil(width / tuning.LONGEST_SPAN).astype(int)  # none of an element without length
    owner, index = number_parts(parts)
    width = width[owner] / parts[owner]
    low = breaks[owner] + index * width
    q = _sample_spans(section, low, width)
    done: list[tuple[Array, Array, Array]] = []
    for halving in range(SPAN_HALVINGS + 1):
        motion = q.max(axis=0) - q.min(axis=0)
        rough = find_row_max(spans.bound_tail(q) - tuning.TAIL_SHARE * motion) > tuning.TAIL_NOISE
        if halving == SPAN_HALVINGS:
            rough[:] = False
        if not rough.any():
            done.append((low, width, q))
            break
        done.append((low[~rough], width[~rough], q[:, ~rough]))
        half = 0.5 * width[rough]
        low, width = np.concatenate([low[rough], low[rough] + half]), np.concatenate([half, half])
        q = _sample_spans(section, low, width)
    lows, widths, samples = zip(*done, strict=True)
    order = np.argsort(np.concatenate(lows), kind="stable")
    low, width = (np.concatenate(column)[order] for column in (lows, widths))
    kept = tuning.KEPT_POINTS if len(low) > tuning.MANY_SPANS else list(range(spans.NODES))
    noise = tuning.JOINT_ROUNDING * max(float(np.abs(chunk).max(initial=0.0)) for chunk in samples)
    derived = [_differentiate(chunk, wide, kept, noise) for chunk, wide in zip(samples, widths, strict=True)]
    d1, d2, d3 = (
        np.concatenate(part).take(order, axis=0).reshape(len(order) * len(kept), -1)
        for part in zip(*derived, strict=True)
    )
    s = (low[:, None] + spans.SAMPLES[kept] * width[:, None]).ravel()
    speed = np.asarray(section.find_speed(s), dtype=float)
    if not (speed > 0).all():
        raise ValueError(f"the feed allows no speed at s = {s[np.argmin(speed > 0)]:.6g} mm of the section")

    def repeat_ends(a: Array) -> Array:
        return np.concatenate([a[:1], a, a[-1:]])

    return Grid(
        np.concatenate([breaks[:1], s, breaks[-1:]]),
        repeat_ends(d1),
        repeat_ends(d2),
        repeat_ends(d3),
        repeat_ends(speed),
    )


def divide_grid(grid: Grid, most: int) -> list[Grid]:
    """A grid as stretches of at most ``most`` points, and one more on either side: :func:`join_grids` joins them."""
    return [
        Grid(*(getattr(grid, name)[first - 1 : first + most + 1] for name in Grid.__struct_fields__))
        for first in range(1, len(grid.s) - 1, most)
    ]


def join_grids(pieces: list[Grid]) -> Grid:
    """Grids along stretches that follow each other, as one."""
    first, last = pieces[0], pieces[-1]

    def join(name: str) -> Array:
        inner = [getattr(piece, name)[1:-1] for piece in pieces]
        return np.concatenate([getattr(first, name)[:1], *inner, getattr(last, name)[-1:]])

    return Grid(*map(join, Grid.__struct_fields__))


def _join_short(section: Section, breaks: Array) -> Array:
    """Breaks (n,), fewer of them where few elements together take less than ``tuning.SHORT_SPAN`` at the feed rate."""
    if len(breaks) <= tuning.MANY_SPANS:
        return breaks
    speed = np.asarray(section.find_speed(0.5 * (breaks[1:] + breaks[:-1])), dtype=float)
    way = tuning.SHORT_SPAN * np.where(np.isfinite(speed), speed, 0.0)
    short = np.diff(breaks) < way
    share = np.divide(np.diff(breaks), way, out=np.ones_like(way), where=short)
    share = np.maximum(share, 1.0 / tuning.SPAN_ELEMENTS)
    kept = (np.diff(np.floor(np.cumsum(share))) > 0) | ~short[1:] | ~short[:-1]
    return breaks[np.concatenate([[True], kept, [True]])]


def find_finite_joints(section: Section, s: Array) -> Array:
    """``section.find_joints(s)``, which must be finite.

    Raises
    ------
    ValueError
        Naming the first s without joints.
    """
    q = np.asarray(section.find_joints(s), dtype=float)
    check_joints(q, s)
    return q


def check_joints(q: Array, s: Array) -> None:
    """Raise ValueError where the joints (n, n_joints) at s (n,) are not finite; it names the first s."""
    if not np.isfinite(q).all():
        bad = s[~np.isfinite(q).all(axis=1)].min()
        raise ValueError(f"the joints are not finite at s = {bad:.6g} mm of the section")


def _sample_spans(section: Section, low: Array, width: Array) -> Array:
    """Joints (nodes, m, n_joints) at the Chebyshev points of spans."""
    s = low + spans.SAMPLES[:, None] * width
    return find_finite_joints(section, s.ravel()).reshape(*s.shape, -1)


def _differentiate(q: Array, width: Array, kept: list[int], noise: float) -> list[Array]:
    """First three derivatives by s, each (m, len(kept), n_joints), of joints (nodes, m, n_joints) on spans (m,).

    Only what they have beyond the ``noise`` of the joints counts: tiny spans would otherwise seem to bend.
    """
    result = [np.empty((q.shape[1], len(kept), q.shape[2])) for _ in _DERIVE]
    for first in range(0, len(width), tuning.AT_A_TIME):
        part = slice(first, first + tuning.AT_A_TIME)
        per_mm = (1.0 / width[part])[:, None]
        chunk = np.ascontiguousarray(q[:, part])
        for order, (matrix, out) in enumerate(zip(_DERIVE, result, strict=True), start=1):
            values = spans.apply_matrix(matrix[kept], chunk)
            bound = noise * _NOISE_GAIN[order - 1]
            values -= np.clip(values, -bound, bound)
            values *= per_mm**order
            out[part] = values.transpose(1, 0, 2)
    return result


def _build_derivative_matrices() -> list[Array]:
    """Samples -> derivatives of order 1 to 3 at the same samples, by the span's own 0..1 parameter."""
    monomials = np.linalg.inv(np.vander(spans.SAMPLES, spans.NODES, increasing=True))
    result = []
    for order in (1, 2, 3):
        derived = np.array([np.polynomial.polynomial.polyder(column, order) for column in monomials.T])
        result.append(np.vander(spans.SAMPLES, spans.NODES - order, increasing=True) @ derived.T)
    return result


_DERIVE: Final = _build_derivative_matrices()
_NOISE_GAIN: Final = [float(np.abs(matrix).sum(axis=1).max()) for matrix in _DERIVE]
