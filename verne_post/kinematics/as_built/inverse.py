"""Sliders, tilt of the table and rotation of the platform for a programmed pose of the as-built machine.

The unknowns are the three rotations of the platform: both rods of a leg must ask for the same slider position. Inside
that everything is explicit. The table's tilt takes the component of the tool axis that it can (the axis is brought
into the plane of the programmed one and the tilt axis), the tip is exact, which gives P, and each slider position is a
root of one quadratic. Newton's method starts at the nominal machine's tilt.

Arrays keep components first and poses last, (3, n) and (3, 6, n): sums over components are then sums of rows.
"""

from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from verne_post.base.arrays import Array, Mask
from verne_post.base.tolerances import PLATFORM_BEND, PLATFORM_ERROR, ROD_RESIDUAL_MM2
from verne_post.kinematics.as_built.geometry import FIRST_ROD, MIRROR, SECOND_ROD, AsBuiltGeometry

#: Rows worked on at a time: the intermediate arrays then stay in the processor's cache.
CHUNK: Final = 4096
#: Newton's steps. Two reach rounding on a machine made to tenths of a millimetre; the rest is for its rim.
STEPS: Final = 12
#: Every slider above the platform.
WORKING_SIDE: Final = -np.ones(6)
#: Below this step (rad) rounding decides the next one, which no longer tells how the equations bend.
_ROUNDED_STEP: Final = 1e-7


class PlatformSolution(Struct, frozen=True, eq=False):
    """Solved poses; every column NaN where a pose has no solution."""

    rho: Array  #: (3, n): mm.
    tilt: Array  #: (n,): Joint A minus the programmed A, rad.
    position: Array  #: (3, n): P in the base frame, mm.
    rotation: Array  #: (3, 3, n): R of the platform.
    #: (n,): What the tilt axis cannot correct: the tool axis's component along the tilt axis minus that of the
    #: programmed axis (an angle up to the second order), rad.
    across: Array


class ProgrammedPose(Struct, frozen=True, eq=False):
    """A pose with the table at its programmed angles: upright frame, seen from the tilt axis. Each (3, n), mm.

    A further turn of the table by theta moves a vector to ``along + upright cos(theta) + turned sin(theta)``.
    """

    tip_along: Array
    tip_upright: Array
    tip_turned: Array
    axis_along: Array
    axis_upright: Array
    axis_turned: Array
    length: Array


def cross(a: Array, b: Array) -> Array:
    """Cross product of components first, (3, ...)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def sum_products(a: Array, b: Array) -> Array:
    """Scalar product of components first, (3, ...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def turn_about(axis: Array, vector: Array, c: Array, s: Array) -> Array:
    """Vectors (3, n) turned about a unit axis (3,) by angles given by cosine and sine (n,)."""
    along, upright, turned = split_about(axis, vector)
    return along + upright * c + turned * s


def split_about(axis: Array, vector: Array) -> tuple[Array, Array, Array]:
    """The parts of vectors (3, n) that a turn about a unit axis keeps, multiplies by its cosine and by its sine."""
    along = axis[:, None] * (axis @ vector)
    return along, vector - along, cross(axis[:, None], vector)


def stand_on_table(geometry: AsBuiltGeometry, tip: Array, angles: Array, turn: Array, length: Array) -> ProgrammedPose:
    """Pose of tips (3, n) and nominal angles (2, n); joint C at ``turn`` (n,), P ``length`` (n,) above the tip."""
    a, c = angles
    ca, sa, cc, sc = np.cos(a), np.sin(a), np.cos(c), np.sin(c)
    axis = np.stack([sc * sa, cc * sa, ca])  # Rz(-C) Rx(-A) z
    if turn is not c:
        cc, sc = np.cos(turn), np.sin(turn)
    axis = turn_about(geometry.tilt_axis, turn_about(geometry.rotary_axis, axis, cc, sc), ca, sa)
    offset = geometry.rotary_origin - geometry.tilt_origin
    point = turn_about(geometry.rotary_axis, tip, cc, sc) + offset[:, None]
    point = turn_about(geometry.tilt_axis, point, ca, sa)
    return ProgrammedPose(*split_about(geometry.tilt_axis, point), *split_about(geometry.tilt_axis, axis), length)


def solve_platform(
    geometry: AsBuiltGeometry, pose: ProgrammedPose, rotation: Array, side: Array = WORKING_SIDE
) -> PlatformSolution:
    """Solve poses (n,) by Newton's method from rotations (3, 3, n).

    ``side`` (6,) is -1 for rods whose slider is above the platform, +1 for the others: all -1 in the working mode.
    A step is the last one when the next would be below :data:`PLATFORM_ERROR`. The next one is the square of this one
    times half the second derivative over the first, which two steps tell.
    """
    bend = np.full(rotation.shape[-1], PLATFORM_BEND)
    before = np.full(rotation.shape[-1], np.inf)
    done = np.zeros(rotation.shape[-1], dtype=bool)
    for _ in range(STEPS):
        step = _find_step(geometry, pose, rotation, side)
        size = np.sqrt(sum_products(step, step))
        measured = before > _ROUNDED_STEP
        bend = np.where(measured & np.isfinite(before), np.maximum(size / before**2, PLATFORM_BEND), bend)
        done = size**2 * bend < PLATFORM_ERROR  # False for NaN
        rotation, before = turn_rotation(rotation, step), size
        if bool(done.all()):
            break
    return _close_rods(geometry, pose, rotation, done, side)


def make_tilts(alpha: Array) -> Array:
    """Rotations (3, 3, n) about x by tilts (n,)."""
    c, s = np.cos(alpha), np.sin(alpha)
    one, zero = np.ones_like(c), np.zeros_like(c)
    return np.array([[one, zero, zero], [zero, c, -s], [zero, s, c]])


def turn_rotation(rotation: Array, turn: Array) -> Array:
    """Rotations (3, 3, n) followed by small turns (3, n): exactly orthogonal (Cayley), true up to third order."""
    half = 0.5 * turn
    scale = 2.0 / (1.0 + sum_products(half, half))
    once = cross(half[:, None], rotation)
    return np.asarray(rotation + scale * (once + cross(half[:, None], once)))


class _Placed(Struct, frozen=True, eq=False):
    """Everything that follows from the platform's rotation."""

    spindle: Array  # (3, n), R s
    cosine: Array  # (n,), of the table's further turn
    sine: Array
    stretch: Array  # (n,), what the turn's derivative is divided by
    position: Array  # (3, n), P
    arms: Array  # (3, 6, n), R a_i
    drop: Array  # (6, n), of each rod along its guide, mm
    rods: Array  # (3, 6, n), from slider to platform
    rho: Array  # (6, n)


def _place(geometry: AsBuiltGeometry, pose: ProgrammedPose, rotation: Array, side: Array) -> _Placed:
    spindle = geometry.spindle[0] * rotation[:, 0]
    for k in (1, 2):
        spindle = spindle + geometry.spindle[k] * rotation[:, k]
    upright = spindle * -MIRROR[:, None]
    x, y = sum_products(upright, pose.axis_upright), sum_products(upright, pose.axis_turned)
    stretch = np.hypot(x, y)
    cosine, sine = x / stretch, y / stretch
    tip = pose.tip_along + pose.tip_upright * cosine + pose.tip_turned * sine + geometry.tilt_origin[:, None]
    position = MIRROR[:, None] * tip + geometry.pivot[:, None] - pose.length * spindle
    arms = np.matmul(geometry.platform_ends, rotation)
    free = arms + (position[:, None] - geometry.slider_ends.T[:, :, None])
    guides = geometry.guides.T[:, :, None]
    height = sum_products(guides, free)
    drop = -side[:, None] * np.sqrt(height**2 - sum_products(free, free) + (geometry.rods**2)[:, None])
    rho = height - drop
    return _Placed(spindle, cosine, sine, stretch, position, arms, drop, free - rho * guides, rho)


def solve_three(rows: Array, right: Array) -> Array:
    """Solutions (3, n) of three equations each, given by rows (3 components, 3 rows, n) and right sides (3, n)."""
    first, second, third = rows[:, 0], rows[:, 1], rows[:, 2]
    a, b, c = cross(second, third), cross(third, first), cross(first, second)
    return np.asarray((a * right[0] + b * right[1] + c * right[2]) / sum_products(first, a))


def _find_step(geometry: AsBuiltGeometry, pose: ProgrammedPose, rotation: Array, side: Array) -> Array:
    """Newton's step (3, n), a turn of the platform in the base frame."""
    at = _place(geometry, pose, rotation, side)
    mirror = MIRROR[:, None]
    # how the table follows a turn of the platform, and the tip the table
    axis_rate = mirror * (pose.axis_turned * at.cosine - pose.axis_upright * at.sine)
    tip_rate = mirror * (pose.tip_turned * at.cosine - pose.tip_upright * at.sine)
    table = cross(at.spindle, axis_rate) / at.stretch
    gradient = at.rods / at.drop
    by_turn = cross(at.arms - (pose.length * at.spindle)[:, None], gradient)
    by_table = sum_products(gradient, tip_rate[:, None])
    miss = at.rho[FIRST_ROD] - at.rho[SECOND_ROD]
    rows = by_turn[:, FIRST_ROD] - by_turn[:, SECOND_ROD]
    rows -= table[:, None] * (by_table[FIRST_ROD] - by_table[SECOND_ROD])
    return -solve_three(rows, miss)  # rows are the gradients of the three misses


def _close_rods(
    geometry: AsBuiltGeometry, pose: ProgrammedPose, rotation: Array, done: Mask, side: Array
) -> PlatformSolution:
    """The solution at final rotations (3, 3, n); NaN where the iteration has not ended or a leg does not close."""
    at = _place(geometry, pose, rotation, side)
    miss = np.abs(at.rho[FIRST_ROD] - at.rho[SECOND_ROD]).max(axis=0)
    longest = float(geometry.rods.max())
    ok = done & (miss * longest < ROD_RESIDUAL_MM2 * max(longest / 850.0, 1.0) ** 2)
    upright = at.spindle * -MIRROR[:, None]
    across = geometry.tilt_axis @ (upright - pose.axis_along)
    rho = 0.5 * (at.rho[FIRST_ROD] + at.rho[SECOND_ROD])
    solution = PlatformSolution(rho, np.arctan2(at.sine, at.cosine), at.position, rotation, across)
    if not ok.all():
        for field in asdict(solution).values():
            field[..., ~ok] = np.nan
    return solution
