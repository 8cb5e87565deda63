"""The least distance for which a question is true."""

from collections.abc import Callable, Iterable


def find_least(is_true: Callable[[float], bool], tried: Iterable[float], settled: float) -> float | None:
    """A distance for which the question is true, no more than ``settled`` above one for which it is not; else None.

    The distances are tried in their order, the smallest first. Between the first that is right and the one before, or
    0, the distance is halved: a smaller one may be right too where the question changes its answer more than once.
    """
    outside = 0.0
    for inside in tried:
        if is_true(inside):
            break
        outside = inside
    else:
        return None
    while inside - outside > settled:
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if is_true(middle) else (inside, middle)
    return inside
