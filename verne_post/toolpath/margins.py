"""Margins of a pose to every limit, in one measure: 0 at the limit, 1 where there is plenty.

* the distance of each limited joint from its travel, over half that travel: 1 in its middle, 0 at its end;
* each margin of the module above its error threshold, over the distance from there to its warning threshold:
  1 where warnings begin, 0 at the error;
* where asked for, what is left of the cones of joints, which have no warning, over an angle that counts as plenty.
"""

from collections.abc import Callable

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.machine import Machine

#: Margins (m, k) of poses: tips (m, 3), nominal angles (m, 2), tool lengths (m,); below any number where unreachable.
Margins = Callable[[Array, Array, Array], Array]


def list_margin_functions(machine: Machine, plenty_deg: float | None = None) -> tuple[Margins, tuple[str, ...]]:
    """The margins of a machine, and what each measures; cones of joints where ``plenty_deg`` says what is plenty."""
    limits = machine.limits
    travel = np.flatnonzero(np.isfinite(limits.lower) & np.isfinite(limits.upper))
    half = 0.5 * (limits.upper - limits.lower)[travel]
    plenty = [
        plenty_deg or 0.0 if margin.code == "VP214" else margin.warn_below - margin.error_below
        for margin in machine.margins
    ]
    kept = [k for k, margin in enumerate(machine.margins) if np.isfinite(margin.error_below) and plenty[k] > 0.0]
    error = np.array([machine.margins[k].error_below for k in kept])
    scale = np.array([plenty[k] for k in kept])

    def find_margins(tip: Array, angles: Array, tool_length: Array) -> Array:
        q, platform, ok = machine.five_axis.solve(tip, angles, tool_length)
        inside = np.minimum(q - limits.lower, limits.upper - q)[:, travel] / half
        geometry = (machine.five_axis.find_geometry_margins(q, angles, platform)[:, kept] - error) / scale
        table = np.concatenate([inside, geometry], axis=1)
        table[~ok] = -np.inf
        return table

    names = [f"travel of {machine.columns[joint].joint}" for joint in travel]
    measured = [machine.margins[k] for k in kept]
    names += [f"{margin.name} of {margin.axis}" if margin.axis else margin.name for margin in measured]
    return find_margins, tuple(names)
