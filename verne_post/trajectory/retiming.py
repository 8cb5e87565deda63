"""One pass of the interior point method over a section: X, the square of the rate at which a profile is re-timed.

Between two ranges of cruise lies a piece. Short pieces are solved together, a long one window by window.
"""

from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.columns import Growing, release_memory
from verne_post.base.tolerances import WHOLE_CYCLE_SHARE
from verne_post.trajectory import tuning
from verne_post.trajectory.cruise import Piece, split_into_pieces
from verne_post.trajectory.interior_point import solve
from verne_post.trajectory.section_path import SectionTask
from verne_post.trajectory.spline_profile import Profile, Times
from verne_post.trajectory.tuning import PassSettings
from verne_post.trajectory.window_problem import TIED, Layout, Window, build_window_problem


def retime(task: SectionTask, profile: Profile, settings: PassSettings) -> Times:
    """Make one pass over the whole section: over the pieces between its ranges of cruise.

    Where a piece has no solution that is tied to the cruise beside it, the pass is made without cruises. A pass that
    finds no solution, and would slow the section down by far, leaves the profile as it is.
    """
    times, legal = _retime(task, profile, settings)
    if not legal and len(task.cruise):
        times, legal = _retime(replace(task, cruise=task.cruise[:0]), profile, settings)
    if not legal and times.total > tuning.LOST_RATIO * profile.duration:
        return Times.build_from_coefficients(np.ones(len(times.t) + TIED - 1), times.knot)
    return times


def _retime(task: SectionTask, profile: Profile, settings: PassSettings) -> tuple[Times, bool]:
    """One pass, and whether all limits hold at its points."""
    knot = settings.knot_units * task.unit
    knots = int(np.ceil(profile.duration / knot * (1 - WHOLE_CYCLE_SHARE)))
    settled, legal = Growing(float), True
    rows = 2 + 2 * sum(count or len(task.limits.jerk) for count in settings.tightest_rows)
    most = tuning.TOGETHER_VALUES // (rows * settings.points_per_knot)
    groups = _group(split_into_pieces(task, profile, knots, settings), most)
    for coefficients, all_legal in task.team.map(partial(_solve_group, task, profile, settings), groups):
        settled.copy(coefficients)
        legal &= all_legal
    return Times.build_from_coefficients(settled.freeze(), knot), legal


def _group(pieces: Iterable[Piece], most: int) -> Iterator[list[Piece]]:
    """Pieces that are solved together: of no more than so many knots, or a single one."""
    group: list[Piece] = []
    knots = 0
    for piece in pieces:
        knots += piece.end - piece.begin
        if group and knots > most:
            yield group
            group, knots = [], piece.end - piece.begin
        group.append(piece)
    yield group


def _solve_group(task: SectionTask, profile: Profile, settings: PassSettings, group: list[Piece]) -> tuple[Array, bool]:
    """Coefficients of pieces and of the cruises before them, and whether all limits hold."""
    release_memory()
    if len(group) == 1:
        return _retime_piece(task, profile, settings, group[0])
    found, legal = _solve(task, profile, settings, [_make_whole_window(piece, settings) for piece in group])
    parts = [part for piece, own in zip(group, found, strict=True) for part in (piece.cruise[TIED:-TIED], own)]
    return np.concatenate(parts), legal


def _solve(
    task: SectionTask, profile: Profile, settings: PassSettings, windows: list[Window]
) -> tuple[list[Array], bool]:
    """Coefficients of every window, and whether all limits hold in all of them."""
    layout = Layout.build(windows, task, settings)
    found = solve(
        build_window_problem(task, profile, settings, layout),
        layout.start(),
        start_gap=settings.start_gap,
        final_gap=settings.final_gap,
        iterations=settings.iterations,
    )
    return layout.split(found.coefficients), found.legal


def _make_whole_window(piece: Piece, settings: PassSettings) -> Window:
    known = np.append(piece.cruise[-TIED:], np.full(piece.end - piece.begin + TIED, _find_held(piece)))
    known = known[: piece.end - piece.begin + TIED]
    return _build_window(known, _find_held(piece), settings.knot_units, piece.begin, piece.after)


def _find_held(piece: Piece) -> float:
    """X of the cruise beside a piece; 1 where there is none."""
    if len(piece.cruise):
        return float(piece.cruise[-1])
    return 1.0 if piece.after is None else float(piece.after[0])


def _retime_piece(task: SectionTask, profile: Profile, settings: PassSettings, piece: Piece) -> tuple[Array, bool]:
    """Solve a piece window by window: its coefficients with those of the cruise before, and whether all limits hold."""
    settled = Growing(float)
    settled.extend(piece.cruise[TIED:-TIED])
    recent = piece.cruise[-TIED:]  # coefficients of the window before, and of this one
    held = _find_held(piece)
    begin, careful, all_legal = piece.begin, -1, True
    done = begin  # knots before which all is settled
    look_ahead = tuning.LOOK_AHEAD_UNITS // settings.knot_units
    while begin < piece.end:
        release_memory()
        end = min(begin + tuning.WINDOW_KNOTS + look_ahead, piece.end)
        if piece.end - end < look_ahead:
            end = piece.end
        recent = np.append(recent, np.full(max(end + TIED - done - len(recent), 0), held))
        coefficients = recent[begin - done : end + TIED - done]
        crawl = tuning.CRAWLING_X if begin <= careful else tuning.WINDOW_END_X
        after = piece.after if end == piece.end else np.full(TIED, crawl)
        found, legal = _solve(
            task, profile, settings, [_build_window(coefficients, held, settings.knot_units, begin, after)]
        )
        if begin > careful and begin > piece.begin and not legal:
            # the window before may have been too fast at its end: again, this time down to a crawl
            careful = begin
            begin -= tuning.WINDOW_KNOTS
            continue
        all_legal &= legal
        coefficients[:] = found[0]
        settled.extend(recent[: begin - done].copy())
        recent, done = recent[begin - done :], begin
        begin = end if end == piece.end else begin + tuning.WINDOW_KNOTS
    settled.extend(recent)
    return settled.freeze(), all_legal


def _build_window(known: Array, held: float, knot_units: int, begin: int, after: Array | None) -> Window:
    """The window from knot ``begin`` on. It starts near the X ``held`` of cruises and ends with coefficients ``after``.

    Where it goes on, ``known`` begins with those of the window before.
    """
    start = np.full(len(known), tuning.START_X * held)
    ramp, seen = tuning.START_RAMP // knot_units, (tuning.LOOK_AHEAD_UNITS - tuning.START_RAMP) // knot_units
    ramp, seen = min(ramp, len(known)), min(seen, len(known))
    if begin:  # less and less of them: the window before slows down
        start[:seen] += (known[:seen] - start[:seen]) * _taper_smoothly(seen)
        start[:TIED] = known[:TIED]
    if after is not None:  # as the solution will, change over the end of the window
        start[-ramp:] *= (after[0] / held) ** (1.0 - _taper_smoothly(ramp))
        start[-TIED:] = after
    return Window(begin, begin + len(known) - TIED, start, begin > 0, after is not None)


def _taper_smoothly(n: int) -> Array:
    """From 1 to 0 in n values, even at both ends."""
    f = np.linspace(0.0, 1.0, n)
    return np.asarray(1.0 - f * f * (3.0 - 2.0 * f))
