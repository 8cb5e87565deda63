"""Margins of a pose to every limit, in one measure: 0 at the limit, 1 where there is plenty.

* the distance of each limited joint from its travel, over half that travel: 1 in its middle, 0 at its end;
* each margin of the module above its error threshold, over the distance from there to its warning threshold:
  1 where warnings begin, 0 at the error.
"""

from collections.abc import Callable

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.machine import Machine

#: Margins (m, k) of poses: tips (m, 3), nominal angles (m, 2), tool lengths (m,); below any number where unreachable.
Margins = Callable[[Array, Array, Array], Array]


def list_margin_functions(machine: Machine) -> tuple[Margins, tuple[str, ...]]:
    """The margins of a machine, and what each measures."""
    limits = machine.limits
    travel = np.flatnonzero(np.isfinite(limits.lower) & np.isfinite(limits.upper))
    half = 0.5 * (limits.upper - limits.lower)[travel]
    measured = [
        (index, margin)
        for index, margin in enumerate(machine.margins)
        if np.isfinite(margin.error_below) and margin.warn_below > margin.error_below
    ]
    kept = [index for index, _margin in measured]
    error = np.array([margin.error_below for _index, margin in measured])
    scale = np.array([margin.warn_below for _index, margin in measured]) - error

    def find_margins(tip: Array, angles: Array, tool_length: Array) -> Array:
        q, platform, ok = machine.five_axis.solve(tip, angles, tool_length)
        inside = np.minimum(q - limits.lower, limits.upper - q)[:, travel] / half
        geometry = (machine.five_axis.find_geometry_margins(q, angles, platform)[:, kept] - error) / scale
        table = np.concatenate([inside, geometry], axis=1)
        table[~ok] = -np.inf
        return table

    names = [f"travel of {machine.columns[joint].joint}" for joint in travel]
    names += [f"{margin.name} of {margin.axis}" if margin.axis else margin.name for _index, margin in measured]
    return find_margins, tuple(names)
