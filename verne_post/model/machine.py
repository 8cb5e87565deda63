"""The machine as all packages see it: frozen values, lengths in mm, angles in rad, times in s."""

import hashlib
import pickle
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.numbers import format_fixed
from verne_post.base.suggestions import explain_names
from verne_post.base.text_tables import format_html_table, format_table
from verne_post.model.deviations import RodPlaces
from verne_post.model.drives import Drive
from verne_post.model.findings import Finding, UsageError
from verne_post.model.moves import AXES, Frame
from verne_post.model.part_setup import FixtureMesh
from verne_post.model.protocols import (
    ClearanceModel,
    FiveAxis,
    Margin,
    ParallelModule,
    TableCoordinates,
    name_rotary_side,
)
from verne_post.model.vibration import Vibration


@dataclass(frozen=True)
class Column:
    """How an actuated joint is written: ``file value = inside value * factor``. A column of ``Machine.columns``.

    Attributes
    ----------
    joint : str
        Its name: "rho1", "a".
    unit : str
        Of the file: "mm", "deg".
    factor : float
        The unit (degrees for a radian) and, by its sign, the sense of the machine file.
    code : str
        Finding code of this joint's travel.
    driven : bool
        False for a column that is no joint: its number only tells where the tool points.
    """

    joint: str
    unit: str
    factor: float
    code: str
    driven: bool = True

    @property
    def header(self) -> str:
        """Name of the column in a setpoint file."""
        return f"{self.joint}_{self.unit}"


@dataclass(frozen=True)
class Limits:
    """Limits of the actuated joints, in mm, rad and s and in workpiece sense: those of ``Machine.limits``.

    ``Machine.scale_limits()`` has them in the units and senses of the rows.

    Attributes
    ----------
    lower, upper : ndarray, shape (n_joints,)
        Travel; infinite for an unlimited joint.
    velocity, acceleration, jerk : ndarray, shape (n_joints,)
        ``jerk`` is infinite where the machine file names none.
    serial_singularity : float
        Smallest vertical drop of a rod, mm; 0 for a machine without rods.
    parallel_singularity : float
        Smallest scaled determinant of the parallel Jacobian; minus infinity where the machine file names none.
    """

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    serial_singularity: float
    parallel_singularity: float = -np.inf

    def bound_jerk(self, cycle: float) -> "Limits":
        """The same limits on rows of a control cycle (s), with a finite jerk where none is named.

        Two accelerations within their limit differ by no more than twice it. So the third differences of rows never
        exceed 2 acceleration / cycle, and planning with that jerk limits nothing.
        """
        return replace(self, jerk=np.minimum(self.jerk, 2.0 * self.acceleration / cycle))


@dataclass(frozen=True)
class Accuracy:
    """Defaults of G64: tip tolerance (mm) and axis tolerance (rad); largest tool axis error as built, rad."""

    tip: float
    axis: float
    uncorrected_axis: float = np.inf


@dataclass(frozen=True)
class Home:
    """Stored positions: machine coordinates x, y, z in mm, a, c in degrees; ``park`` where the file names one."""

    g28: tuple[float, float, float, float, float]
    g30: tuple[float, float, float, float, float]
    park: tuple[float, float, float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Bodies:
    """Sizes of the machine's bodies, mm and rad; None where the machine file says nothing."""

    minimum: float  #: Smallest allowed distance between bodies.
    rod_radius: Array | None = None  #: (k,) or None: Of each rod, in the order of ``module.rods``.
    #: spindle_radius, spindle_top: The spindle reaches from the gauge line to ``spindle_top`` above the platform
    #: point P.
    spindle_radius: float | None = None
    spindle_top: float = 0.0
    tool_radius: float | None = None  #: Of the largest tool.
    #: (3,), or None each: Ends of the platform as a capsule, platform frame.
    platform: tuple[Array, Array] | None = None
    platform_radius: float = 0.0
    #: slider_cone, platform_cone: Half angle that the ball joints allow about the rod's direction at
    #: ``cone_centre``.
    slider_cone: float | None = None
    platform_cone: float | None = None
    #: (3,) or None: Platform position (base frame) at which the joints stand in the middle.
    cone_centre: Array | None = None
    spindle_is_flat: bool = False  #: It is a cylinder with flat ends; a capsule otherwise.


@explain_names(joints="columns", axes="columns", travel="limits")
@dataclass(frozen=True, repr=False)
class Machine:
    """One machine: kinematics, limits, control, and the origin of every number.

    Inside, lengths are in mm, angles in rad, times in s, and the senses those of the workpiece; files have mm and
    degrees, and the senses of the machine file. ``columns`` say how the one becomes the other. The functions
    :meth:`inverse` and :meth:`forward` use the table frame and the inside units.

    Attributes
    ----------
    name, kind : str
        Of the machine file.
    columns : tuple of Column
        How each joint is written, in the order of the rows.
    limits : Limits
        Of the joints, in that order, in mm, rad and s; rows have degrees: :meth:`scale_limits` has the limits in the
        units and senses of rows.
    cycle : float
        Control cycle, s.
    accuracy : Accuracy
        Tolerances of corners, mm and rad.
    home : Home or None
        Stored positions.
    table_radius : float
        mm.
    spindle_rpm : float
        Greatest speed of the spindle, 1/min; inf where the machine file does not give it.
    provenance : dict
        Group of the machine file -> where its values are from.
    warnings : tuple of Finding
        Implausible values (VP505).
    unreachable : tuple of Finding
        Its stored positions that no pose reaches (VP501). A program that no pose reaches either is not the cause.
    vibration : Vibration or None
        Modes for input shapers.
    drives : tuple of Drive
        Of the joints, in their order; empty where the file does not name them.
    bodies, rod_places, meshes : Bodies, RodPlaces, tuple of FixtureMesh
        Sizes of the bodies; where the rods are along x; bodies in the platform frame that keep out of fixtures.
    tolerances : ndarray
        Standard deviations of manufacture, mm and rad, of the 58 deviations of an as-built machine.
    module, five_axis, coordinates, clearance
        Kinematics, which the program uses; not meant to be called.

    Examples
    --------
    >>> import verne_post as vp
    >>> machine = vp.load_machine("verne")
    >>> [f"{column.joint} {column.unit} {column.factor:.4g}" for column in machine.columns][2:4]
    ['rho3 mm 1', 'a deg 57.3']
    >>> f"{machine.limits.velocity[3]:.4f} rad/s, {machine.scale_limits().velocity[3]:g} deg/s"
    '1.5708 rad/s, 90 deg/s'
    """

    name: str
    kind: str
    file_sha256: str
    module: ParallelModule | None
    five_axis: FiveAxis
    coordinates: TableCoordinates
    columns: tuple[Column, ...]
    limits: Limits
    accuracy: Accuracy
    home: Home | None
    table_radius: float
    clearance: ClearanceModel | None
    cycle: float
    provenance: dict[str, str]
    spindle_rpm: float = np.inf
    drives: tuple[Drive, ...] = ()
    bodies: Bodies | None = None
    rod_places: RodPlaces | None = None
    tolerances: Array = field(default_factory=lambda: np.empty(0))
    warnings: tuple[Finding, ...] = ()
    unreachable: tuple[Finding, ...] = ()
    vibration: Vibration | None = None
    meshes: tuple[FixtureMesh, ...] = ()
    #: Makes it again with other values of keys of its file; None where it is from no file.
    rebuild: Callable[[Mapping[str, object]], "Machine"] | None = field(default=None, compare=False)
    #: Of its numbers as the file has them, so that other ones are noticed.
    file_numbers: str = ""
    #: Its kinematics and bodies as made from the file, so that other ones are noticed.
    file_parts: tuple[object, ...] = field(default=(), repr=False, compare=False)

    def __post_init__(self) -> None:
        if not self.file_numbers:
            object.__setattr__(self, "file_numbers", self._compute_hash())
            object.__setattr__(self, "file_parts", self._list_parts())

    def _list_parts(self) -> tuple[object, ...]:
        kinematics = (self.module, self.five_axis, self.coordinates, self.clearance)
        return (*kinematics, self.bodies, self.rod_places, self.meshes)

    def _list_replaced(self) -> Iterator[str]:
        """What of it ``dataclasses.replace`` has changed since it was made from its file."""
        if self._compute_hash() != self.file_numbers:
            yield "numbers"
        if any(part is not own for part, own in zip(self._list_parts(), self.file_parts, strict=True)):
            yield "kinematics or bodies"

    def _compute_hash(self) -> str:
        """The hash of its numbers that people replace."""
        limits = self.limits
        arrays = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk, self.tolerances)
        others = (
            *(self.name, self.kind, self.columns, limits.serial_singularity, limits.parallel_singularity, self.cycle),
            *(self.accuracy, self.home, self.table_radius, self.spindle_rpm, self.drives, self.vibration),
        )
        hashed = hashlib.sha256(repr(others).encode())
        for array in arrays:
            hashed.update(np.asarray(array, dtype=float).tobytes())
        return hashed.hexdigest()

    @property
    def sha256(self) -> str:
        """Hash of the machine file, and of what has been changed since."""
        replaced = tuple(self._list_replaced())
        if not replaced:
            return self.file_sha256
        hashed = hashlib.sha256(f"{self.file_sha256} {self._compute_hash()}".encode())
        for part, own in zip(self._list_parts(), self.file_parts, strict=True):
            if part is not own:
                try:
                    hashed.update(pickle.dumps(part))
                except (pickle.PicklingError, AttributeError, TypeError):  # a class of the user inside a function
                    hashed.update(repr(part).encode())
        return hashed.hexdigest()

    @property
    def changes(self) -> str:
        """In what it differs from its file, in words; empty where it does not."""
        replaced = (f"{what} replaced in Python" for what in self._list_replaced())
        return ", ".join(filter(None, (self.provenance.get("changed"), *replaced)))

    def changed(self, values: Mapping[str, object] | None = None, **keywords: object) -> "Machine":
        """The same machine with other values for keys of its file, validated as it is; ``sha256`` is another one.

        Parameters
        ----------
        values : mapping
            Key -> value, in the units of the file: ``{"limits.a_jerk": 5000.0}``, of schema 2
            ``{"joints.a.jerk": 5000.0}``. None takes the key out.
        **keywords
            Keys have points, so they are no keywords: an error says so.

        Raises
        ------
        InputError
            One finding (VP501) for each mistake, as of :func:`load_machine`.
        UsageError
            The values are no mapping, or the machine has been changed by ``dataclasses.replace``.

        Examples
        --------
        >>> import verne_post as vp
        >>> machine = vp.load_machine("verne")
        >>> slower = machine.changed({"limits.a_jerk": 5000.0})
        >>> slower.scale_limits().jerk.tolist(), slower.provenance["changed"]
        ([100000.0, 100000.0, 100000.0, 5000.0, 20000.0], 'limits.a_jerk = 5000.0')
        """
        if keywords or not isinstance(values, Mapping) or not all(isinstance(key, str) for key in values):
            text = 'expected keys of the machine file in a mapping, as machine.changed({"limits.a_jerk": 5000.0})'
            raise UsageError(next(iter(keywords), "values"), text)
        if self.rebuild is None or any(self._list_replaced()):
            text = "this machine is not that of its file: dataclasses.replace has changed it; begin with load_machine"
            raise UsageError("machine", text)
        return self.rebuild(values)

    def _make_text_rows(self) -> list[list[str]]:
        """Its joints with their limits, in the units and senses of setpoint files."""
        rows = [["joint", "unit", "from", "to", "velocity, /s", "acceleration, /s2", "jerk, /s3"]]
        limits = self.scale_limits()
        sizes = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk)
        for column, *values in zip(self.columns, *sizes, strict=True):
            rows.append([column.joint, column.unit, *(f"{value:g}" for value in values)])
        return rows

    def describe_kind(self) -> str:
        """``kind verne``; a file of schema 2 has no key of this name, so the table that describes its joints."""
        return f"schema 2, [{self.kind}]" if self.module is None else f"kind {self.kind}"

    def _describe(self) -> str:
        return f"{self.name}, {self.describe_kind()}; assumed, not measured: {', '.join(self.assumed) or 'nothing'}"

    def __repr__(self) -> str:
        return f"{self._describe()}\n{format_table(self._make_text_rows())}"

    def _repr_html_(self) -> str:
        import html  # for notebooks only

        return f"<p>{html.escape(self._describe())}</p>{format_html_table(self._make_text_rows())}"

    def scale_limits(self) -> Limits:
        """The limits of the joints in the units and senses of rows: mm or degrees, and s."""
        limits, factor = self.limits, np.array([column.factor for column in self.columns])
        ends = np.sort([limits.lower * factor, limits.upper * factor], axis=0)
        size = np.abs(factor)
        return replace(
            limits,
            lower=ends[0],
            upper=ends[1],
            velocity=limits.velocity * size,
            acceleration=limits.acceleration * size,
            jerk=limits.jerk * size,
        )

    @property
    def assumed(self) -> tuple[str, ...]:
        """Groups of the machine file whose values are not measured."""
        return tuple(group for group, source in self.provenance.items() if source.startswith("assumed"))

    @property
    def unlimited(self) -> str:
        """What the machine file does not limit: joints without a jerk; empty where all have one."""
        joints = [column.joint for column, jerk in zip(self.columns, self.limits.jerk, strict=True) if np.isinf(jerk)]
        return f"jerk of {', '.join(joints)}: the machine file names no limit" if joints else ""

    @property
    def margins(self) -> tuple[Margin, ...]:
        """What the module's ``find_geometry_margins`` measure, with the thresholds of this machine."""
        return self.five_axis.name_margins(self.limits.serial_singularity, self.limits.parallel_singularity)

    @property
    def has_rods(self) -> bool:
        """Whether rods hold a platform with the spindle; a serial machine has neither."""
        q = np.zeros((1, len(self.columns)))
        with np.errstate(all="ignore"):  # how many there are does not depend on the pose
            platform, _ok = self.five_axis.find_platform(q)
            return self.five_axis.sketch(q, platform).shape[1] > 0

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of the joints but the rotary pair."""
        return tuple(column.joint for column in self.columns[:-2])

    @property
    def rotary_letters(self) -> tuple[str, str]:
        """Letters of the rotary axes: of the one that tilts the tool, and of the one that turns about its pole."""
        tilt, turn = self.coordinates.rotary
        return AXES[tilt], AXES[turn]

    @property
    def rotary_side(self) -> str:
        """What the rotary axes turn, in words: ``table``, ``head``, or ``rotary axes`` where each end has one."""
        return name_rotary_side(self.coordinates)

    def place_stored(self, home: tuple[float, ...]) -> Array:
        """Machine coordinates (9,) of a stored position: x, y, z, and the rotary axes in the order of the columns."""
        place = np.zeros(len(AXES))
        place[[0, 1, 2, *self.coordinates.rotary]] = home
        return place

    def name_angles(self, angles: Array | tuple[float, float], decimals: int = 3) -> str:
        """Nominal angles (2,), rad, as words of the rotary axes: ``A 30.000, C -90.000``."""
        program = self.coordinates.map_from_table(np.zeros(3), np.asarray(angles, dtype=float), Frame())
        words = zip(self.rotary_letters, program[list(self.coordinates.rotary)], strict=True)
        return ", ".join(f"{letter} {format_fixed(float(word), decimals)}" for letter, word in words)

    def find_origin_on_table(self, frame: Frame) -> tuple[float, float, float]:
        """Origin of a work system in the table frame, mm."""
        x, y, z = (
            float(v) - w for v, w in zip(frame.origin[:3], self.coordinates.work_origin((0.0, 0.0, 0.0)), strict=True)
        )
        return x, y, z

    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Joint values of five-axis poses.

        Parameters
        ----------
        tip : ndarray, shape (..., 3)
            Tool tip in the table frame, mm.
        axis : ndarray, shape (..., 3)
            Unit tool axis in the table frame, from tip to spindle.
        tool_length : ndarray, shape (...) or float
            Gauge line to tip, mm.

        Returns
        -------
        q : ndarray, shape (..., n_joints)
            mm and rad; the table solution with tilt b in [0, pi] and C in (-pi, pi]. NaN where ``ok`` is False.
        ok : ndarray of bool, shape (...)
            True where a real solution in the working mode exists; travel is not checked here.

        Raises
        ------
        UsageError
            An argument is no array of numbers.
        """
        places = (_read_numbers(tip, "tip", "places in mm"), _read_numbers(axis, "axis", "unit vectors"))
        return self.five_axis.inverse(*places, _read_numbers(tool_length, "tool_length", "mm"))

    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Poses of joint values.

        Parameters
        ----------
        q : ndarray, shape (..., n_joints)
            mm and rad, in the order of ``columns``: rows in mm and degrees divided by ``column.factor`` of each.
        tool_length : ndarray, shape (...) or float
            Gauge line to tip, mm.

        Returns
        -------
        tip : ndarray, shape (..., 3)
            Tool tip in the table frame, mm; NaN where ``ok`` is False.
        axis : ndarray, shape (..., 3)
            Unit tool axis in the table frame, from tip to spindle.
        ok : ndarray of bool, shape (...)
            True where the joints close to a pose in the working mode; travel is not checked here.

        Raises
        ------
        UsageError
            ``q`` is no array of numbers, such as setpoints or the whole answer of :meth:`inverse`.
        """
        if isinstance(q, tuple) and len(q) == 2 and np.asarray(q[1]).dtype.kind == "b":
            raise UsageError("q", "inverse returns (q, ok); pass q")
        right = "joints in mm and rad, as setpoints.values / [column.factor for column in machine.columns]"
        return self.five_axis.forward(_read_numbers(q, "q", right), _read_numbers(tool_length, "tool_length", "mm"))


def _read_numbers(given: object, name: str, right: str) -> Array:
    """An argument as an array of numbers; another one is refused with what is right."""
    try:
        return np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise UsageError(name, f"expected {right}; this {type(given).__name__} is no array of numbers") from None
