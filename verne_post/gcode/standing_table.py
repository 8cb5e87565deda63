"""Programs without tool-centre-point control: what their X, Y, Z mean on the part while the table stands turned.

X, Y, Z are then coordinates of the machine, shifted by the work offset: those of the part as it would stand with A and
C at 0. While the table stands, they are coordinates of the part in another position, which a tilted plane (Feature)
describes.
"""

import numpy as np

from verne_post.gcode.offsets import make_vector9
from verne_post.model.moves import ZERO9, Feature, Frame
from verne_post.model.protocols import Coordinates


def find_standing_plane(coordinates: Coordinates, frame: Frame, program: list[float]) -> Feature | None:
    """The plane in which X, Y, Z count while the table stands at the rotary words of a program point (9).

    Parameters
    ----------
    coordinates : Coordinates
    frame : Frame
        Its tilted plane does not count.
    program : list of float
        Only the entries of A, B, C count, degrees.

    Returns
    -------
    Feature or None
        In program coordinates without a plane; None where the table is not turned.
    """
    bare = Frame(frame.system, frame.origin, frame.turn, frame.part_turn, frame.g92, frame.tool)
    points = np.zeros((4, 9))
    points[1:, :3] = np.eye(3)
    machine = coordinates.map_to_machine(points, bare)
    turned = np.tile(np.array(ZERO9), (4, 1))
    turned[:, 3:6] = program[3:6]
    machine[:, 3:6] = coordinates.map_to_machine(turned, bare)[:, 3:6]
    place = coordinates.map_to_program(machine, bare)[:, :3]
    rotation = (place[1:] - place[0]).T
    if np.array_equal(place, points[:, :3]) or np.abs(place - points[:, :3]).max() < _NOTHING:
        return None
    # nearly orthogonal by rounding of differences: made so
    u, _s, v = np.linalg.svd(rotation)
    origin = make_vector9([*place[0], *ZERO9[3:]])[:3]
    return Feature((origin[0], origin[1], origin[2]), tuple(float(value) for value in (u @ v).ravel()))


#: A plane that differs from none by less than this (mm, per mm) is none: rounding of machine coordinates.
_NOTHING = 1e-9
