"""What rows are compared with: the program, the limits of the machine, and what rounding adds to the rows."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM, ROUNDING_SHARES, SHARE_ROUNDING
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.contour import Contour
from verne_post.model.machine import Column, Limits
from verne_post.model.setpoints import SetpointFormat
from verne_post.model.toolpath import ToolPath
from verne_post.verification.items import Items, SegmentMeasures, list_items, measure_segments
from verne_post.verification.programmed import RADIAN_MM

#: Rounded joints move the tip by at most this many units of a linear actuator's last decimal, and this many mm per
#: radian of a table angle's. Half a unit in each actuator moves the tip by at most 1.5 units on the VERNE, 1.6 on the
#: linear delta and 0.9 on the serial machine (measured over the workspaces of the shipped files). A radian of A or C
#: moves sliders by 200 mm, and a tip may be 1 m from the table's axes.
_TIP_PER_SLIDER: Final = 3.0
_TIP_PER_RADIAN_MM: Final = 1000.0
#: Rounding that moves the tip by no more than this share of the tolerance is inside it; the default decimals do.
_FINE_SHARE: Final = 0.1
#: Derivatives of the joints by their order - 1.
DERIVATIVES: Final = ("velocity", "acceleration", "jerk")


class RoundingNoise(Struct, frozen=True, eq=False):
    """What rounding to the decimals of the file may change."""

    #: (n_joints,) each: First, second and third differences over the cycle, file units; 0 where the acceptance
    #: ratio covers the noise.
    differences: tuple[Array, ...]
    joints: Array  #: (n_joints,): One unit of the last decimal, mm and rad.
    tip: float  #: Displacement of the tip, mm.
    angle: float  #: Change of the nominal angles, rad.
    coarse: bool  #: The decimals are so few that the noise is added to the tolerance of the path.


class Reference(Struct, frozen=True, eq=False):
    """Everything that the checks of a file compare its rows with; none of it changes."""

    path: ToolPath  #: The programmed segments.
    #: tip_tolerance, axis_tolerance (n_segments,): How far the motion may be from each segment, mm and rad.
    tip_tolerance: Array
    axis_tolerance: Array
    entry: int  #: A restart begins with this segment; -1 for a whole program.
    #: How far along that segment, or before it, the first pose of a restart may be, mm. This pose is the middle
    #: of a corner, which is blended beside its vertex, the farther the sharper it is.
    entry_aside: float
    measures: SegmentMeasures
    items: Items
    columns: tuple[Column, ...]
    factor: Array  #: (n_joints,): File value over inside value.
    limits: Limits
    derivative_limits: tuple[Array, ...]  #: (n_joints,) each: Velocity, acceleration and jerk in file units.
    cycle: float  #: s.
    noise: RoundingNoise

    def find_bounds(self, segment: Ints) -> tuple[Array, Array]:
        """How far rows may be from segments (n,): tip (mm), and tool axis and rotary angle (rad); (n,) both.

        PATH_TIP_MM and PATH_AXIS_DEG, or the tolerance of the segment where its corners may be rounded, plus what
        rounding to coarse decimals adds.
        """
        tip, angle = self.exact_bounds
        return (
            np.maximum(tip, self.tip_tolerance[segment] + tip - PATH_TIP_MM),
            np.maximum(angle, self.axis_tolerance[segment] + self.noise.angle),
        )

    @property
    def exact_bounds(self) -> tuple[float, float]:
        """How far rows may be from where no corner is rounded: tip (mm), and tool axis and rotary angle (rad)."""
        return PATH_TIP_MM + self.noise.coarse * self.noise.tip, PATH_AXIS_DEG * RAD_PER_DEG + self.noise.angle

    @property
    def words_bound(self) -> float:
        """How far (rad) words may be from the tool axis that joints tell, where they tell no more.

        Rounding is within: it turns the tool axes of the shipped machines by some 1e-7 rad at the default decimals, ten
        times as much on a platform a tenth as large.
        """
        return _FINE_SHARE * PATH_AXIS_DEG * RAD_PER_DEG + self.noise.angle

    def find_standing_poses(self, item: Ints) -> Array:
        """Poses (n, 5), mm and rad, at which the machine stands before items (n,), or in a dwell after all motion.

        A restart stands in the middle of the corner that the whole program would round.
        """
        path, rest = self.path, self.items.rest_segment[item]
        poses = np.where((rest < len(path))[:, None], path.start[np.minimum(rest, len(path) - 1)], path.end[-1:])
        poses[rest == self.entry] = path.first_pose
        return poses


def build_reference(
    contour: Contour, limits: Limits, columns: tuple[Column, ...], fmt: SetpointFormat, *, by_axis: bool = False
) -> Reference:
    """Build the reference of a program. Of the contour only segments, standstills and tolerances are taken.

    ``by_axis`` where the joints of the machine tell the tool axis, and not which words hold it.
    """
    factor = np.array([column.factor for column in columns])
    size = np.abs(factor)
    derivative_limits = (limits.velocity * size, limits.acceleration * size, limits.jerk * size)
    measures = measure_segments(contour, by_axis=by_axis)
    return Reference(
        contour.path,
        contour.tip_tolerance,
        contour.axis_tolerance,
        contour.entry,
        _measure_entry(contour),
        measures,
        list_items(contour, measures, fmt.cycle),
        columns,
        factor,
        limits,
        derivative_limits,
        fmt.cycle,
        _compute_rounding_noise(fmt, size, derivative_limits),
    )


def _measure_entry(contour: Contour) -> float:
    """Largest distance along the segment that a restart begins with, from its beginning to its first pose, mm."""
    if contour.entry < 0:
        return 0.0
    aside = contour.path.first_pose - contour.path.start[contour.entry]
    aside[3:] *= RADIAN_MM
    return float(0.5 * np.pi * np.linalg.norm(aside))  # an arc of up to half a turn is so many times its chord


def _compute_rounding_noise(fmt: SetpointFormat, size: Array, derivative_limits: tuple[Array, ...]) -> RoundingNoise:
    """Noise of a format; ``size`` (n_joints,) are file units per mm and rad."""
    noise = [2**order * fmt.quanta / fmt.cycle ** (order + 1) for order in range(3)]
    # fine decimals are inside the acceptance ratios; coarser ones that were asked for are allowed their noise
    differences = tuple(
        np.where(one > share * limit * (1 + SHARE_ROUNDING), one, 0.0)
        for one, share, limit in zip(noise, ROUNDING_SHARES, derivative_limits, strict=True)
    )
    joints = fmt.quanta / size
    tip = float(_TIP_PER_SLIDER * joints[:-2].max() + _TIP_PER_RADIAN_MM * joints[-2:].max())
    return RoundingNoise(differences, joints, tip, float(2 * joints[-2:].max()), tip > _FINE_SHARE * PATH_TIP_MM)
