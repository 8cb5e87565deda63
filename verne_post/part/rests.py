"""Stock that stays around the nominal part: ridges between strips, and what no cutter reaches."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.part.cutting import STEP_MM
from verne_post.part.dexels import Dexels
from verne_post.part.stl import Mesh
from verne_post.part.stock_forms import list_intervals

#: Rests of fewer cells than this are not told: a corner of a ray.
_LEAST_CELLS: Final = 4


class Rest(Struct, frozen=True, eq=False):
    """Stock that stays in one place."""

    volume: float  #: Farther from the part than was asked for, mm3.
    place: Array  #: (3,): The upper end of it where it is thickest along the rays, mm, in the frame of the part.


def find_rests(stock: Dexels, mesh: Mesh, allowed: float) -> list[Rest]:
    """Stock that is certain to be farther than ``allowed`` from the part, the largest first; both in one frame.

    Every ray is compared with a larger part: by ``allowed``, by the error of walls between rays, and by the teeth that
    standing bodies leave.

    Raises
    ------
    InputError
        VP506: a ray leaves the part more often than it enters it.
    """
    from scipy.ndimage import label

    left = stock.copy()
    corner, _ = left.place_inside(mesh.list_corners(), np.zeros(3))
    low, high = list_intervals(mesh.name, corner, left.cell, left.counts)
    wide = allowed + left.resolution + 0.5 * STEP_MM
    reach = np.floor(wide / left.cell).astype(int)
    rays: list[Ints] = [one.ravel() for one in np.indices(left.counts)]
    for i in range(-reach[0], reach[0] + 1):
        for j in range(-reach[1], reach[1] + 1):
            up = wide**2 - (i * left.cell[0]) ** 2 - (j * left.cell[1]) ** 2
            if up < 0:
                continue
            filled = left.find_filled(rays)  # few rays are, once the first places of the part are taken away
            rays = [one[filled] for one in rays]
            of = rays[0] - i, rays[1] - j
            inside = np.logical_and(*((one >= 0) & (one < n) for one, n in zip(of, left.counts, strict=True)))
            own, (at_i, at_j) = [one[inside] for one in rays], (one[inside] for one in of)
            for k in range(low.shape[2]):
                enter, leave = low[at_i, at_j, k] - np.sqrt(up), high[at_i, at_j, k] + np.sqrt(up)
                met = enter < leave
                left.take_along([one[met] for one in own], enter[met, None], leave[met, None])
    thick = np.maximum(left.high - left.low, 0.0)
    total = thick.sum(axis=2)
    number, count = label(total > 0.0, structure=np.ones((3, 3)))
    rests = []
    for k in range(1, count + 1):
        x, y = np.nonzero(number == k)
        if len(x) < _LEAST_CELLS:
            continue
        worst = int(total[x, y].argmax())
        one = thick[x[worst], y[worst]]
        top = left.high[x[worst], y[worst], int(one.argmax())]
        inside = np.append((np.array([x[worst], y[worst]]) + 0.5) * left.cell, top)
        volume = left.area * float(total[x, y].sum())
        rests.append(Rest(volume, left.place_outside(inside)))
    return sorted(rests, key=lambda rest: -rest.volume)
