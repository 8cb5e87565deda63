"""Arcs in any plane of space, recorded as arcs of a tilted plane that holds them."""

import math

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ARC_CHORD_MM
from verne_post.gcode.program_error import ProgramError
from verne_post.model.moves import Feature


class SpatialArc(Struct, frozen=True):
    """A circle in space: centre, unit normal, and counter-clockwise angle from start to end about it, degrees."""

    center: Array
    normal: Array
    sweep: float


def build_arc_through(start: Array, middle: Array, end: Array) -> SpatialArc:
    """The arc from start over a point in between to the end, (3,) each, mm.

    Raises
    ------
    ProgramError
        VP008 where the points do not determine a circle.
    """
    first, second = middle - start, end - start
    normal = np.cross(first, second)
    size = float(np.linalg.norm(normal))
    if size <= ARC_CHORD_MM * max(float(np.linalg.norm(first)), float(np.linalg.norm(second))):
        raise ProgramError(
            "VP008",
            "start, intermediate point and end lie on one line, or two of them are one point: there is no "
            "circle through them",
        )
    square = size**2
    center = start + (
        float(first @ first) * np.cross(second, normal) + float(second @ second) * np.cross(normal, first)
    ) / (2.0 * square)
    normal = normal / size
    u = start - center
    v = np.cross(normal, u)
    angle = math.degrees(math.atan2(float((end - center) @ v), float((end - center) @ u))) % 360.0
    return SpatialArc(center, normal, angle)


def build_plane_of_arc(arc: SpatialArc, feature: Feature | None) -> Feature:
    """The plane whose X, Y hold the arc, with its centre at 0, inside a plane in force."""
    helper = np.eye(3)[int(np.argmin(np.abs(arc.normal)))]
    u = np.cross(helper, arc.normal)
    u /= np.linalg.norm(u)
    rotation = np.column_stack([u, np.cross(arc.normal, u), arc.normal])
    origin = arc.center
    if feature is not None:
        origin, rotation = feature.map_outside(origin), feature.turn_outside(rotation.T).T
    x, y, z = (float(value) for value in origin)
    asked_for = feature is not None and feature.is_programmed
    return Feature((x, y, z), tuple(float(value) for value in rotation.ravel()), asked_for)
