"""What verification found in a setpoint file."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from verne_post.model.findings import Finding

Array = NDArray[np.float64]


@dataclass
class Verification:
    """What was found in a file.

    Ratios are the worst value over its limit per joint column; deviations in mm and degrees.
    """

    n_rows: int = 0
    velocity_ratio: Array = field(default_factory=lambda: np.zeros(0))
    acceleration_ratio: Array = field(default_factory=lambda: np.zeros(0))
    jerk_ratio: Array = field(default_factory=lambda: np.zeros(0))
    feed_ratio: float = 0.0
    feed_line: int = 0
    tip_deviation_mm: float = 0.0
    axis_deviation_deg: float = 0.0
    #: Seconds below the programmed feed, by what was nearest to its limit then: ("jerk", "rho2"), ...
    slow: dict[tuple[str, str], float] = field(default_factory=dict)
    first_row: Array = field(default_factory=lambda: np.zeros(0))
    findings: list[Finding] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """True when nothing was found wrong."""
        return not self.findings
