"""Where the parts of an as-built VERNE are: joint centres, rods, guides, table axes, spindle.

Six rods of their own lengths hold the platform at P with the rotation R:

    |P + R a_i - b_i - rho_j u_j| = L_i,    i = 1 ... 6, j the leg of rod i.

Base frame with z down, mm. Where both rods of a leg are equal and parallel these are the paper's equations (3) to (6).
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.model.deviations import Deviations, RodPlaces

#: Leg of each rod, and the rods of each leg.
LEG: Final = np.array([0, 0, 1, 1, 2, 2])
FIRST_ROD: Final = slice(0, 6, 2)
SECOND_ROD: Final = slice(1, 6, 2)
#: F: the base frame against the upright frame.
MIRROR: Final = np.array([1.0, -1.0, -1.0])


class NominalTable(Struct, frozen=True):
    """Places of the table and of the gauge line, mm; see :class:`TiltingTable`."""

    pivot: Array
    rotary_offset: Array
    nose_offset: float


class AsBuiltGeometry(Struct, frozen=True, eq=False):
    """The parts where they are. Rods in the order of :data:`verne_post.model.deviations.RODS`; mm."""

    platform_ends: Array  #: (6, 3): a_i, platform frame.
    slider_ends: Array  #: (6, 3): b_i at rho = 0, base frame.
    rods: Array  #: (6,): L_i.
    guides: Array  #: (6, 3): Unit direction u_j of the guide of each rod.
    spindle: Array  #: (3,): Unit vector from P towards the tip, platform frame.
    pivot: Array  #: (3,): Origin of the upright frame, base frame.
    #: tilt_origin, tilt_axis (3,): A point on the tilt axis (from the pivot) and its unit direction, upright
    #: frame.
    tilt_origin: Array
    tilt_axis: Array
    #: rotary_origin, rotary_axis (3,): The same of the rotary axis, tilt frame at A = 0; the origin of the table
    #: frame.
    rotary_origin: Array
    rotary_axis: Array
    nose_offset: float  #: From P to the gauge line.


def _normalise(x: float, y: float, z: float) -> Array:
    vector = np.array([x, y, z])
    return vector / np.linalg.norm(vector)


def build_nominal_ends(module: VerneGeometry, places: RodPlaces) -> tuple[Array, Array, Array]:
    """Platform ends (6, 3), slider ends (6, 3) and lengths (6,) of the rods of the nominal machine."""
    half = 0.5 * places.leg23_spacing
    slider_x = np.array([places.leg1_slider_x] * 2 + [places.leg23_slider_x + half, places.leg23_slider_x - half] * 2)
    offset = np.array([module.leg1_x_offset] * 2 + [module.leg23_x_offset] * 4)
    zero = np.zeros(6)
    platform_y = np.array([module.R1, -module.R1, -module.R2, -module.R2, module.R2, module.R2])
    slider_y = np.array([module.r1, -module.r1, -module.r4, -module.r4, module.r4, module.r4])
    rods = np.array([module.L1, module.L1, module.L2, module.L2, module.L3, module.L3])
    return (
        np.stack([slider_x + offset, platform_y, zero], axis=1),
        np.stack([slider_x, slider_y, zero], axis=1),
        rods,
    )


def place_parts(
    module: VerneGeometry, places: RodPlaces, table: NominalTable, deviations: Deviations
) -> AsBuiltGeometry:
    """The parts of a machine whose nominal places and deviations from them are given."""
    platform, slider, rods = build_nominal_ends(module, places)
    guides = np.array([_normalise(x, y, 1.0) for x, y in deviations.guides])
    tilt_y, tilt_z = deviations.tilt_place
    rotary_x, rotary_y = deviations.rotary_place
    return AsBuiltGeometry(
        platform_ends=platform + deviations.platform_ends,
        slider_ends=slider + deviations.slider_ends,
        rods=rods + deviations.rod_lengths,
        guides=guides[LEG],
        spindle=_normalise(deviations.spindle[0], deviations.spindle[1], 1.0),
        pivot=np.asarray(table.pivot, dtype=float),
        tilt_origin=np.array([0.0, tilt_y, tilt_z]),
        tilt_axis=_normalise(1.0, deviations.tilt_direction[0], deviations.tilt_direction[1]),
        rotary_origin=np.add(table.rotary_offset, [rotary_x, rotary_y, 0.0]),
        rotary_axis=_normalise(deviations.rotary_direction[0], deviations.rotary_direction[1], 1.0),
        nose_offset=table.nose_offset,
    )
