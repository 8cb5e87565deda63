"""What goes into a calibration of the machine as built: readings of the tool, of lengths, and what was known before."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.model.deviations import IS_ANGLE

#: Deviations of manufacture that are expected where nobody says otherwise: mm and rad, standard deviations.
TOLERANCE_MM: Final = 0.05
TOLERANCE_RAD: Final = 1e-4


class ToolReadings(Struct, frozen=True, eq=False):
    """Measured tools on the table, n rows."""

    joints: Array  #: (n, 5): As commanded: rho1, rho2, rho3 (mm), A and C (rad, workpiece sense).
    length: Array  #: (n,): Gauge line to tip, mm.
    #: (n, 3): In the table frame or as the row's station reads it, mm; NaN where a coordinate was not measured.
    tip: Array
    axis: Array  #: (n, 3): Unit tool axis from tip to spindle, table frame; NaN where it was not measured.
    #: sigma_tip, sigma_axis (n,): Standard uncertainties: of each coordinate (mm), and of the axis about each of
    #: two directions (rad).
    sigma_tip: Array
    sigma_axis: Array
    station: Ints  #: (n,): Which unknown place the tool is measured from; -1: the table frame.
    turned: Mask  #: (n,): True where the directions of the station are not known either.
    line: Ints  #: (n,): Where the row stands in its file.

    def __len__(self) -> int:
        return len(self.line)

    def take(self, chosen: Ints | Mask) -> "ToolReadings":
        """Some of the rows."""
        return ToolReadings(*(getattr(self, name)[chosen] for name in self.__struct_fields__))


class LengthReading(Struct, frozen=True):
    """A length that was measured on the machine: a rod, or the distance of the ends of two rods.

    ``part`` is "rod", "platform" or "slider", ``rods`` are one or two of 0 ... 5; mm.
    """

    part: str
    rods: tuple[int, ...]
    value: float
    sigma: float
    line: int


class JointUncertainty(Struct, frozen=True):
    """Standard uncertainty of where a commanded joint really stands: sliders in mm, A and C in rad."""

    slider: float = 0.0
    angle: float = 0.0

    @property
    def spread(self) -> Array:
        """Of the five joints (5,)."""
        return np.array([self.slider] * 3 + [self.angle] * 2)

    def propagate_covariance(self, by_joint: Array) -> Array:
        """Covariance (n, k, k) of quantities whose derivatives by the joints are ``by_joint`` (n, k, 5)."""
        scaled = by_joint * self.spread
        return np.asarray(scaled @ scaled.transpose(0, 2, 1))


COMMANDED_EXACTLY: Final = JointUncertainty()


class Prior(Struct, frozen=True, eq=False):
    """What is known of the deviations before the readings: a normal distribution."""

    mean: Array  #: (58,)
    factor: Array  #: (58, 58): The covariance is ``factor @ factor.T``.


def build_tolerance_vector(lengths: float = TOLERANCE_MM, directions: float = TOLERANCE_RAD) -> Array:
    """One tolerance (58,) for all places and lengths, mm, and one for all directions, rad."""
    return np.where(IS_ANGLE, directions, lengths)


def build_prior_of_manufacture(tolerances: Array) -> Prior:
    """Every part near its nominal place, as far off as its tolerance (58,) says."""
    return Prior(np.zeros(len(tolerances)), np.diag(tolerances))


def build_prior_of_covariance(mean: Array, covariance: Array) -> Prior:
    """A normal distribution with this mean (58,) and covariance (58, 58).

    Raises
    ------
    numpy.linalg.LinAlgError
        The covariance is not positive definite.
    """
    scale = np.sqrt(np.diag(covariance))
    return Prior(mean, scale[:, None] * np.linalg.cholesky(covariance / np.outer(scale, scale)))
