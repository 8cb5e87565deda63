"""Protocols: what packages expect of each other, so that none has to import another.

gcode and toolpath are given coordinates; trajectory is given joint functions; app, output and calibration are given the
kinematics of a machine.
"""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.model.contour import Contour
from verne_post.model.moves import Frame
from verne_post.model.nutation import Nutation
from verne_post.model.poses import JointPoses, Platform, Pose
from verne_post.model.toolpath import TurnSegments


class Margin(Struct, frozen=True):
    """A geometric margin of a module: positive is good."""

    name: str  #: What it measures.
    code: str  #: Finding code when it is too small.
    axis: str | None  #: The joint concerned.
    unit: str
    #: error_below, warn_below: Thresholds.
    error_below: float
    warn_below: float


class PoseFunction(Protocol):
    """Evaluates the geometry of a contour."""

    def __call__(self, contour: Contour, element: Ints, w: Array) -> tuple[Array, Array]:
        """Tip (n, 3) and nominal angles (n, 2) at parameter w (n,) of elements (n,)."""


class JointFunctions(Protocol):
    """The joints along a contour, and the speed that the feed rate allows."""

    @property
    def contour(self) -> Contour:
        """The contour that is followed."""

    @property
    def pose(self) -> PoseFunction:
        """Tip and angles along a contour."""

    def find_joints(self, element: Ints, w: Array) -> Array:
        """Joints (n, n_joints) at parameter w (n,) of elements (n,)."""

    def find_joint_poses(self, element: Ints, w: Array) -> JointPoses:
        """Joints, and what ``pose`` says, at parameter w (n,) of elements (n,)."""

    def find_speed_cap(self, element: Ints, w: Array) -> Array:
        """Feed cap: largest ds/dt (n,) that the feed rate allows, mm/s; infinite for rapids."""


class SpeedFunction(Protocol):
    """The feed cap along a contour."""

    def __call__(self, contour: Contour, element: Ints, w: Array) -> Array:
        """Largest ds/dt (n,) at parameter w (n,) of elements (n,)."""


class InverseSolution(Struct, frozen=True):
    """One inverse solution of a module: tilt (rad), configuration indices s1, s2, ..., actuators (mm).

    ``refused`` is None for the one that the machine uses, else the reason by geometry.
    """

    alpha: float
    signs: tuple[int, ...]
    rho: tuple[float, float, float]
    refused: str | None


class ForwardSolution(Struct, frozen=True):
    """One assembly mode: position of P (mm), tilt (rad), and why it is refused (None for the one in use)."""

    position: tuple[float, float, float]
    alpha: float
    refused: str | None


class ParallelModule(Protocol):
    """Kinematics of the spindle carrier, parallel or not. Positions in the base frame (z down), mm.

    Rows without a solution are NaN with ok False, never an exception. The platform may tilt about x
    by an angle alpha that follows from its position (parasitic motion).
    """

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of the actuated joints."""

    def inverse(self, position: Array) -> tuple[Array, Array, Mask]:
        """(..., 3) -> actuators (..., 3), mm, alpha (...), rad, and ok (...), in the working mode."""

    def forward(self, rho: Array) -> tuple[Array, Array, Mask]:
        """(..., 3) -> position (..., 3), mm, alpha (...), rad, and ok (...), in the working mode."""

    def solve_coupled(self, pivot: Array, gauge: Array) -> tuple[Array, Array, Mask]:
        """Solve for a platform point ``pivot + F Rx(alpha) gauge``, which turns with the platform's tilt.

        F is diag(1, -1, -1). Pivot (3,) in the base frame, gauge (..., 3) in the upright frame at alpha = 0, mm;
        returns the same as :meth:`inverse`.
        """

    def explain_unreachable(self, pivot: Array, gauge: Array) -> list[str]:
        """Finding codes for poses (m, 3) without a solution in the working mode.

        "VP110" out of reach, "VP201" rods that cross, "VP203" beyond a parallel singularity.
        """

    def inverse_all(self, position: Array) -> Sequence[InverseSolution]:
        """All real inverse solutions of one position (3,), each with the geometric reason why it is refused."""

    def forward_all(self, rho: Array) -> Sequence[ForwardSolution]:
        """All real assembly modes of one set of actuators (3,), each with the reason why it is refused."""

    def find_geometry_margins(self, position: Array, alpha: Array) -> Array:
        """Margins (..., m) of solved poses, in the order of :meth:`name_margins`."""

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` returns, with thresholds."""

    def solve_coupled_all(self, pivot: Array, gauge: Array) -> Sequence[InverseSolution]:
        """All real solutions of :meth:`solve_coupled` for one gauge point (3,)."""

    def find_jacobians(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Parallel (..., 4, 4) and serial (..., 4, 3) part of the closure equations of solved poses.

        ``parallel @ d(x, y, z, alpha) + serial @ d(rho) = 0``.
        """

    def measure_conditioning(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the scaled parallel and serial part, each (...)."""


@runtime_checkable
class RodModule(Protocol):
    """A machine whose legs are rods with a ball joint at both ends."""

    @property
    def rod_legs(self) -> tuple[str, ...]:
        """Name of the leg of each rod."""

    @property
    def parallelograms(self) -> tuple[str, ...]:
        """Legs whose rods stay parallel."""

    @property
    def shortest_rod(self) -> float:
        """mm."""

    def find_rod_directions(self, position: Array) -> tuple[Array, Array]:
        """Directions of the rods (k, 3) of the machine as drawn, in base and platform frame, at a place (3,) of P."""

    def find_rod_ends(self, rho: Array, platform: Platform) -> tuple[Array, Array]:
        """Ends of the rods at slider and platform of solved poses (n,): each (n, k, 3), base frame, mm."""


class ClearanceModel(Protocol):
    """How near the bodies of a machine come to each other."""

    @property
    def names(self) -> tuple[Margin, ...]:
        """What is measured, with thresholds."""

    @property
    def reach(self) -> Array:
        """How much each margin changes at most while the points of its group move by 1 mm, (m,)."""

    @property
    def group(self) -> tuple[str, ...]:
        """Group of points that carries each margin."""

    @property
    def convex_below(self) -> Array:
        """Values (m,) below which a margin is exact, and convex while the tool moves straight with constant axis."""

    @property
    def slack(self) -> float:
        """A margin may be below its threshold by this, mm: the resolution of the check."""

    def evaluate(self, pose: Pose, *, least_only: bool = False) -> tuple[Array, dict[str, Array]]:
        """Margins (n, m), and by group the points (n, p, 3) whose motion bounds their change.

        With ``least_only`` the least of each margin has to be right, and the others no smaller: that is faster.
        """


class WholeSolution(Struct, frozen=True):
    """One of several solutions of the whole machine."""

    q: tuple[float, ...]  #: Joints, mm and rad; A is the table's, with the platform's tilt in it.
    angles: tuple[float, float]  #: Nominal A and C, rad.
    alpha: float  #: Platform tilt, rad.
    signs: tuple[int, ...]  #: Configuration indices of the module.
    other_table: bool  #: The table solution with the tilt on the other side and C turned by half a turn.
    refused: str | None  #: Reason by the module's geometry why it cannot be used; None where it can.


@runtime_checkable
class Identifiable(Protocol):
    """A module whose lengths can be identified: its loop equations can be evaluated with any lengths."""

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of the actuated joints, m of them."""

    @property
    def length_names(self) -> tuple[str, ...]:
        """Names of the p lengths: keys of [module], and attributes of the module (mm)."""

    @property
    def signed_lengths(self) -> frozenset[str]:
        """Those that may be negative."""

    def evaluate_loops(self, lengths: Array, rho: Array, pose: Array) -> tuple[Array, Array, Array, Array]:
        """Misfits of the loops (n, e), mm; their derivatives by lengths (n, e, p), actuators (n, e, m), pose (n, e, 4).

        Lengths (p,), actuators (n, m), pose (n, 4): x, y, z in the base frame (mm) and the tilt alpha (rad).
        """


@runtime_checkable
class IsoAlpha(Protocol):
    """A module whose positions of equal tilt are closed curves in x and y."""

    def trace_iso_alpha(self, alpha: float, turn: Array) -> Array:
        """Points (n, 2) of P whose platform tilt is alpha or -alpha, by the parameter turn (n,)."""


@runtime_checkable
class Drawable(Protocol):
    """A module that can be drawn: its rods, exact enough for a picture."""

    def sketch(self, position: Array, alpha: Array, rho: Array) -> Array:
        """Rods of solved poses (n,) from slider to platform: (n, k, 2, 3), base frame, mm."""


@runtime_checkable
class AxisCorrecting(Protocol):
    """A machine whose tool axis is not exactly the programmed one while C stays as programmed."""

    @property
    def nominal_machine(self) -> "FiveAxis":
        """The machine as it was meant."""

    def switch_correction(self, *, on: bool) -> "FiveAxis":
        """The machine whose C takes its share of the axis error, or does not."""

    @property
    def corrects_axis(self) -> bool:
        """Whether C takes its share of the axis error."""

    def measure_axis_error(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Axis error (...) of solved poses that is left along the tilt axis, rad."""


@runtime_checkable
class Nutating(Protocol):
    """A machine whose rotary joints may be given beside the nominal angles, which do not tell them near a fold."""

    def place_joints(self, tip: Array, turns: Array, tool_length: Array | float) -> Array:
        """Joints (..., n_joints) of tips (..., 3) with the angles d and t (..., 2) of the rotary pair."""


@runtime_checkable
class Carrying(Protocol):
    """A machine whose rotary joints follow from the tool axis alone: its carrier turns; words differ from joints."""

    @property
    def home(self) -> Array:
        """Joint values (n_joints,) with the carrier at home and the rotary joints at 0."""

    @property
    def no_reach(self) -> str:
        """Why a pose is out of reach, in the words of its carrier."""


class FiveAxis(Protocol):
    """The whole machine: parallel module and tilting rotary table, with TCP. Table frame, workpiece sense."""

    @property
    def nose_offset(self) -> float:
        """From P to the gauge line along the tool axis, mm."""

    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Pose in the frame of the set-up -> (q, ok); see :func:`turn_to_setup`."""

    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Joints -> (tip, axis, ok) in the frame of the set-up; :meth:`measure` has that of the path."""

    def solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Platform, Mask]:
        """Tip (..., 3), nominal angles (..., 2) -> (q, platform, ok); the table makes up for the tilt, C as given."""

    def find_joints(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """The q of :meth:`solve` alone."""

    def find_platform_gauge(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Gauge point g (..., 3) of the nominal machine, seen from the pivot in the upright frame."""

    def find_nominal_pose(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Joints -> (tip (..., 3), nominal angles (..., 2), ok)."""

    def measure(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """Joints -> (tip (..., 3), nominal angles (..., 2), true tool axis (..., 3), ok)."""

    def find_platform(self, q: Array) -> tuple[Platform, Mask]:
        """The platform for joint values (..., n_joints), and whether the rods close (...)."""

    @property
    def spindle(self) -> Array:
        """Unit vector (3,) from P towards the tip, platform frame."""

    def find_tool_axis(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Tool axis (..., 3), tip to spindle, in the table frame, of solved poses."""

    def carry_to_table(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the base frame in the table frame, for joint values (..., n_joints)."""

    def find_geometry_margins(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Margins (..., m) of solved poses, in the order of :meth:`name_margins`."""

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` returns, with thresholds."""

    def measure_conditioning(self, q: Array, platform: Platform) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the scaled parallel and serial Jacobians of solved poses, each (...)."""

    def sketch(self, q: Array, platform: Platform) -> Array:
        """Rods (n, k, 2, 3) from slider to platform for a picture of poses (n,), base frame, mm; k = 0 without rods."""

    def find_jacobian(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint rates by pose rates of solved poses: (..., n_joints, 5) by tip and nominal A and C."""

    def inverse_all(self, tip: Array, axis: Array, tool_length: float) -> Sequence[WholeSolution]:
        """All real solutions of one pose (3,), (3,): both table solutions, every tilt, every posture."""

    def explain_unreachable(self, tip: Array, angles: Array, tool_length: Array | float) -> list[str]:
        """Finding codes of poses (m, 3), (m, 2) that :meth:`solve` cannot solve."""


class Coordinates(Protocol):
    """Maps between program and machine coordinates.

    Points are nine-vectors X Y Z A B C U V W, shape (..., 9), mm and degrees, file sense.
    """

    def map_to_machine(self, program: Array, frame: Frame) -> Array:
        """Program coordinates -> machine coordinates."""

    def map_to_program(self, machine: Array, frame: Frame) -> Array:
        """Machine coordinates -> program coordinates."""

    def turn_displacement(self, vector: Array, frame: Frame) -> Array:
        """Turn displacements (..., 3) of the program into the directions of the work origin."""

    def turn_to_axis(self, program: list[float], vector: Array, frame: Frame) -> list[float]:
        """A program point (9) with rotary words that hold the tool axis ``vector`` (3,), program directions."""

    def turn_to_axes(self, words: tuple[float, float], vectors: Array, frame: Frame) -> list[tuple[float, float]]:
        """Words of A and C that hold one tool axis (n, 3) after the other, from a pair of words on."""

    def find_tool_axis(self, program: list[float], frame: Frame) -> Array | None:
        """Tool axis (3,) at a program point, program directions, tip to spindle; None where angles have no meaning."""

    def find_other_side(self, machine: Array) -> Array | None:
        """Machine coordinates (9,) of the same tool axis with the tilt beyond the pole; None at the pole."""

    def is_upright(self, machine: Array) -> bool:
        """Whether the tool points along z of the part at machine coordinates (9,)."""

    @property
    def nutation(self) -> Nutation | None:
        """What angles and joints have to do with each other where the rotary pair is not at right angles."""

    @property
    def head(self) -> tuple[int, ...]:
        """Which of the rotary axes turn the tool's end of the machine, as numbers of ``AXES``."""

    @property
    def zero_point(self) -> str:
        """The point that work offsets count from, in words."""


def name_rotary_side(coordinates: Coordinates) -> str:
    """What the rotary axes turn, in words, by the number of them that the head has."""
    return ("table", "rotary axes", "head")[len(coordinates.head)]


def name_solution(coordinates: Coordinates) -> str:
    """``table solution``: what there are two of for one tool axis."""
    return f"{name_rotary_side(coordinates).removesuffix(' axes')} solution"


def turn_to_setup(coordinates: "TableCoordinates", vectors: Array) -> Array:
    """Places and directions (..., 3) of the path in the frame of the set-up: of work offsets, fixtures and messages."""
    return np.asarray(vectors @ coordinates.part_frame)


def turn_from_setup(coordinates: "TableCoordinates", vectors: Array) -> Array:
    """Inverse of :func:`turn_to_setup`."""
    return np.asarray(vectors @ coordinates.part_frame.T)


class TableTravel(Protocol):
    """What an interpreter may ask about the travel of the table."""

    def find_beyond(self, place: Array, tool_length: float) -> str:
        """Letters of the rotary axes beyond their travel at machine coordinates (9,); "" where none is."""

    def describe_tilt(self, tilts: list[float]) -> str:
        """The travel of the axis that tilts the tool, in words, and the least excess of some angles; degrees."""

    def is_reached(self, place: Array, tool_length: float) -> bool:
        """Whether every joint is within its travel at machine coordinates (9,)."""


class TableCoordinates(Coordinates, Protocol):
    """Coordinates of a real machine: they also know where the tool is on the table."""

    @property
    def axes(self) -> str:
        """Letters of the axes that the machine has."""

    @property
    def rotary(self) -> tuple[int, int]:
        """Which of ``AXES`` tilt the tool and turn about its pole."""

    @property
    def part_frame(self) -> Array:
        """Rows (3, 3): x, y, z of the frame of the path in directions of that of the set-up: :func:`turn_to_setup`."""

    @property
    def home_tilt(self) -> float:
        """Nominal A where the tilting joint stands at 0, rad."""

    @property
    def joints_by_axis(self) -> bool:
        """Whether the rotary joints follow from the tool axis alone: at the pole of the words C then moves nothing."""

    @property
    def turns_with_part(self) -> bool:
        """Whether a part that stands turned about z is the same as another angle of the joint that carries it."""

    def carry_tips(self, start: Array, end: Array, tool_length: Array) -> TurnSegments:
        """Moves from pose to pose (n, 5) along which the axes of the machine go linearly, with tool lengths (n,)."""

    def map_to_table(self, program: Array, frame: Frame) -> tuple[Array, Array]:
        """Program (..., 9) -> tip in the table frame (..., 3), nominal angles (..., 2) rad, workpiece sense."""

    def map_from_table(self, tip: Array, angles: Array, frame: Frame) -> Array:
        """Inverse of :meth:`map_to_table`: program coordinates (..., 9)."""

    def map_to_work(self, point: Array, axis: Array, frame: Frame) -> tuple[Array, Array]:
        """A point and a direction (..., 3) of the table frame in the work frame."""

    def work_origin(self, offset_mm: tuple[float, float, float]) -> tuple[float, float, float]:
        """Origin in machine coordinates of a work offset o given in the table frame."""
