"""The result of verifying a setpoint file."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.suggestions import explain_names
from verne_post.base.text_tables import format_html_text
from verne_post.model.findings import Finding

#: What holds the tool back where no joint is near a limit: the motion is shorter than its control cycles.
NO_LIMIT_NEAR: Final = "control cycle"


class BlockTime(Struct, frozen=True):
    """How long a block takes whose feed rate is a time."""

    line: int
    #: asked_s, spent_s: What the program asks for, and what the rows take, s.
    asked_s: float
    spent_s: float
    reason: str  #: The limit that was nearest for most of what it takes longer, as in ``Verification.slow``.


@explain_names(**dict.fromkeys(("verdict", "summary"), "text"), errors="findings", causes="findings")
@dataclass(repr=False)
class Verification:
    """The result of verifying a setpoint file.

    Attributes
    ----------
    n_rows, n_followed : int
        Rows of the file, and those before the first one that does not match the program. Path and feed rate are
        compared for these alone.
    velocity_ratio, acceleration_ratio, jerk_ratio : ndarray, shape (n_joints,)
        Worst value of each column over its limit.
    feed_ratio, feed_line : float and int
        Largest share of the programmed feed rate, and its source line.
    tip_deviation_mm, axis_deviation_deg : float
        Largest distance from the programmed path.
    axis_error_deg : float
        Largest angle between the true tool axis of the as-built machine and that of its nominal angles.
    slow : dict
        Seconds below the programmed feed rate, by the nearest limit: "jerk of rho2", ..., or ``NO_LIMIT_NEAR``.
    timed_blocks, late_blocks : int
        Blocks whose feed rate is a time (inverse time, degrees per minute), and those that take longer by more than 1 %
        and two control cycles.
    latest_block : BlockTime or None
        The one that exceeds its time by most seconds.
    first_row : ndarray, shape (n_joints,)
        File units.
    unchecked : str
        What is not checked, where the rows are one part of several; empty where all was checked.
    text : str
        Findings and verdict, as ``verify`` says them: what is printed.
    """

    n_rows: int = 0
    n_followed: int = 0
    velocity_ratio: Array = field(default_factory=lambda: np.zeros(0))
    acceleration_ratio: Array = field(default_factory=lambda: np.zeros(0))
    jerk_ratio: Array = field(default_factory=lambda: np.zeros(0))
    feed_ratio: float = 0.0
    feed_line: int = 0
    tip_deviation_mm: float = 0.0
    axis_deviation_deg: float = 0.0
    axis_error_deg: float = 0.0
    slow: dict[str, float] = field(default_factory=dict)
    timed_blocks: int = 0
    late_blocks: int = 0
    latest_block: BlockTime | None = None
    first_row: Array = field(default_factory=lambda: np.zeros(0))
    findings: list[Finding] = field(default_factory=list)
    unchecked: str = ""
    text: str = ""

    def __repr__(self) -> str:
        return self.text or f"{self.n_rows} rows, {len(self.findings)} findings"

    def _repr_html_(self) -> str:
        return format_html_text(repr(self))

    @property
    def ok(self) -> bool:
        """True when all was checked and nothing was found wrong."""
        return not (self.findings or self.unchecked)

    def __bool__(self) -> bool:
        return self.ok
