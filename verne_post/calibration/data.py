"""What goes into an identification, readings with their uncertainties, and what comes out."""

from typing import Final

from msgspec import Struct

from verne_post.base.arrays import Array, Ints


class Readings(Struct, frozen=True, eq=False):
    """Readings pairs."""

    rho: Array  #: (n, m): Actuators, mm.
    pose: Array  #: (n, 4): x, y, z of P in the base frame (mm) and alpha (rad), NaN where it was not measured.
    setting: Ints  #: (n,): Rows of one setting share one reading of the actuators, and so its error.
    line: Ints  #: (n,): Where the row stands in its file.


class Uncertainty(Struct, frozen=True):
    """Standard uncertainties of the readings: sliders and positions in mm, tilt in rad; 0 is exact.

    An infinite ``tilt`` uses measured tilts only to know which solution a row is. ``rod`` is how far each rod may miss
    (mm): play and bending, which no length explains; the only error left where all readings are taken as exact.
    """

    slider: float
    position: float
    tilt: float
    rod: float = 0.0


#: Readings exact, all error in the rods: poor statistics, but defined for any lengths, so it comes first.
EXACT: Final = Uncertainty(0.0, 0.0, 0.0, 1.0)


class Direction(Struct, frozen=True):
    """A combination of lengths that the data do not determine: coefficients, the largest +-1."""

    coefficients: dict[str, float]

    def describe(self) -> str:
        """As one clause: "R1 +1.00 with r1 +1.00"."""
        parts = [f"{name} {value:+.2f}" for name, value in self.coefficients.items()]
        return " with ".join(parts) if len(parts) > 1 else f"{next(iter(self.coefficients))} alone"


class Landing(Struct, frozen=True):
    """Where random starts ended: all lengths (mm), the chi-square there, and how many came."""

    lengths: dict[str, float]
    chi_square: float
    count: int


class Identification(Struct, frozen=True, eq=False):
    """What the data say about the lengths."""

    lengths: dict[str, float]  #: All lengths, mm; held and undetermined ones stand as in the machine file.
    #: Standard uncertainty of the estimated lengths, mm; NaN where the data do not determine a length.
    uncertainty: dict[str, float]
    correlation: Array  #: (k, k): In the order of ``uncertainty``.
    tied: tuple[tuple[str, ...], ...]
    undetermined: tuple[Direction, ...]
    chi_square: float  #: Of the corrections.
    degrees_of_freedom: int
    #: That readings with the stated uncertainties give as much or more (NaN without redundancy).
    probability: float
    residual: Array  #: (n, m + 4): Readings minus fitted: actuators, x, y, z (mm), alpha (rad, NaN where not used).
    misfit: Array  #: (n, e): What each rod misses at the fitted readings, mm; zero where rods are exact.
    scaled: Array  #: (n, m + 4 + e): Both in standard uncertainties; NaN where exact or not used.
    converged: bool
    landings: tuple[Landing, ...]  #: Best first; empty without random starts.
    failed_starts: int
