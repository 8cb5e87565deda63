"""Deviations of the parts of a machine from their nominal places: the 58 numbers of [as_built] of a machine file."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array

#: Every entry of :class:`Deviations`: its key in a machine file, its shape, and True where it is an angle.
ENTRIES: Final[dict[str, tuple[str, tuple[int, ...], bool]]] = {
    "platform_ends": ("platform_ends_mm", (6, 3), False),
    "slider_ends": ("slider_ends_mm", (6, 3), False),
    "rod_lengths": ("rod_lengths_mm", (6,), False),
    "guides": ("guides_mrad", (3, 2), True),
    "tilt_place": ("tilt_axis_mm", (2,), False),
    "tilt_direction": ("tilt_axis_mrad", (2,), True),
    "rotary_place": ("rotary_axis_mm", (2,), False),
    "rotary_direction": ("rotary_axis_mrad", (2,), True),
    "spindle": ("spindle_axis_mrad", (2,), True),
}
#: Names of the rods in the order of the arrays.
RODS: Final = ("I at +y", "I at -y", "II at larger x", "II at smaller x", "III at larger x", "III at smaller x")
#: Components of the places and directions that have two.
_COMPONENTS: Final = {
    "guides": "xy",
    "tilt_place": "yz",
    "tilt_direction": "yz",
    "rotary_place": "xy",
    "rotary_direction": "xy",
    "spindle": "xy",
}


class RodPlaces(Struct, frozen=True):
    """Places along x that the nominal equations cannot see, mm, base frame: [rods] of the machine file.

    ``leg1_slider_x`` and ``leg23_slider_x`` are d1 and d2 of the paper, ``leg23_spacing`` is the distance of the two
    rods of legs II and III.
    """

    leg1_slider_x: float
    leg23_slider_x: float
    leg23_spacing: float


class Deviations(Struct, frozen=True, eq=False):
    """Deviations from the nominal machine, mm and rad.

    Rods are ordered as in :data:`RODS`, guides by leg. Directions are small: (x, y) stands for the unit vector along
    (x, y, 1), (y, z) of the tilt axis for the one along (1, y, z).
    """

    #: (6, 3): Joint centres on the platform, platform frame (origin P, z down, turned with the platform).
    platform_ends: Array
    slider_ends: Array  #: (6, 3): Joint centres on the sliders at rho = 0, base frame.
    rod_lengths: Array  #: (6,)
    guides: Array  #: (3, 2): x and y of the guide's direction: a joint centre moves by rho times the unit vector.
    #: tilt_place, tilt_direction (2,): y and z in the upright frame: the tilt axis runs through the pivot + (0,
    #: y, z) along (1, y, z).
    tilt_place: Array
    tilt_direction: Array
    #: rotary_place, rotary_direction (2,): x and y in the tilt frame at A = 0: the rotary axis runs through
    #: rotary_offset + (x, y, 0) along (x, y, 1).
    rotary_place: Array
    rotary_direction: Array
    spindle: Array  #: (2,): x and y in the platform frame: from P towards the tool's tip the direction is (x, y, 1).

    @classmethod
    def build_nominal(cls) -> "Deviations":
        """All zero: the nominal machine."""
        return cls.build_from_vector(np.zeros(len(PARAMETERS)))

    def pack_vector(self) -> Array:
        """All 58 numbers in the order of :data:`PARAMETERS`, mm and rad."""
        return np.concatenate([np.ravel(getattr(self, name)) for name in self.__struct_fields__])

    @classmethod
    def build_from_vector(cls, vector: Array) -> "Deviations":
        """Inverse of :meth:`pack_vector`."""
        parts, first = {}, 0
        for name, (_key, shape, _angle) in ENTRIES.items():
            size = int(np.prod(shape))
            parts[name] = np.array(vector[first : first + size], dtype=float).reshape(shape)
            first += size
        return cls(**parts)


def _list_names() -> tuple[str, ...]:
    """Names of the parameters: "rod_lengths_mm, rod I at +y"."""
    names: list[str] = []
    for entry, (key, shape, _angle) in ENTRIES.items():
        if len(shape) == 2 and shape[0] == 6:
            names += [f"{key}, rod {rod}, {letter}" for rod in RODS for letter in "xyz"]
        elif entry == "rod_lengths":
            names += [f"{key}, rod {rod}" for rod in RODS]
        elif entry == "guides":
            names += [f"{key}, leg {leg}, {letter}" for leg in ("I", "II", "III") for letter in "xy"]
        else:
            names += [f"{key}, {letter}" for letter in _COMPONENTS[entry]]
    return tuple(names)


#: Name of each number of :meth:`Deviations.pack_vector`, by its key in a machine file.
PARAMETERS: Final = _list_names()
#: True where a parameter is an angle (rad), False where it is a length (mm).
IS_ANGLE: Final = np.concatenate([np.full(int(np.prod(shape)), angle) for _key, shape, angle in ENTRIES.values()])
