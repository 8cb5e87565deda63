"""`machine export`: C against Python, refusals, the files, and LinuxCNC itself where it is installed."""

import configparser
import ctypes
import re
import shutil
import subprocess
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import verne_post
from tests.benchmarks.linuxcnc_run import run_program, stream, why_not
from tests.kinematics.six_rods import as_toml, random_table
from tests.kinematics.test_chain import CHAINS
from verne_post.config.load import build_machine
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.model.machine import Machine
from verne_post.output.machine_formats.linuxcnc_kins import write_component
from verne_post.output.machine_formats.mtconnect import write_device

ROOT: Final = Path(__file__).resolve().parents[2]
HARNESS: Final = Path(__file__).with_name("kins_harness.c")
KINDS: Final = ("verne", "linear_delta", "serial")
SOLVERS: Final = {"closed form": 0, "Newton": 1}
#: C and Python agree to this share of a rod, and of a radian.
SHARE: Final = 1e-12
SIZE: Final = np.array([850.0, 850.0, 850.0, 57.3, 57.3])

needs_compiler = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


class Poses(NamedTuple):
    """Poses of a machine, their joints by Python, in the units and senses of the machine file."""

    world: NDArray[np.float64]
    tool: NDArray[np.float64]
    joints: NDArray[np.float64]
    reached: NDArray[np.bool_]


class Compiled:
    """The exported C of a machine, called for arrays."""

    def __init__(self, machine: Machine, folder: Path) -> None:
        for name, text in write_component(machine).items():
            (folder / name).write_text(text, encoding="utf-8")
        library = folder / "kins.so"
        strict = ["-O2", "-std=c99", "-D_POSIX_C_SOURCE=199309L", "-Wall", "-Wextra", "-Werror"]
        subprocess.run(["gcc", *strict, "-shared", "-fPIC", "-I", folder, HARNESS, "-o", library, "-lm"], check=True)
        self.library = ctypes.CDLL(str(library))

    def solve(
        self, function: str, rows: NDArray[np.float64], tool: NDArray[np.float64], solver: int, keep: bool = False
    ):
        """Rows out of rows (n, 5), NaN where nothing was written, and ok (n,)."""
        out, ok = np.full((len(rows), 5), np.nan), np.zeros(len(rows), dtype=np.int32)
        rows = np.ascontiguousarray(rows)
        getattr(self.library, function)(len(rows), _at(rows), _at(tool), solver, int(keep), _at(out), _at(ok))
        return out, ok.astype(bool)

    def jacobian(self, rows: NDArray[np.float64], tool: NDArray[np.float64]) -> NDArray[np.float64]:
        rates, ok = np.full((len(rows), 5, 5), np.nan), np.zeros(len(rows), dtype=np.int32)
        self.library.jacobian_rows(len(rows), _at(rows), _at(tool), _at(rates), _at(ok))
        assert ok.all()
        return rates


def _at(array: NDArray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def other_places(kind: str) -> str:
    """The file of a machine whose every place is off zero, with axes in the tool's sense."""
    text = (ROOT / "machine_configs" / f"{kind}.toml").read_text(encoding="utf-8")
    for old, new in (
        ("nose_offset_mm = 0.0", "nose_offset_mm = 31.0"),
        ("pivot = [0.0, 0.0, 1600.0]", "pivot = [7.0, -5.0, 1590.0]"),
        ("rotary_offset = [0.0, 0.0, 0.0]", "rotary_offset = [3.0, -11.0, 13.0]"),
        ("machine_zero = [0.0, 0.0, 550.0]", "machine_zero = [2.0, 1.0, 500.0]"),
        ('a_positive = "workpiece"', 'a_positive = "tool"'),
        ('c_positive = "workpiece"', 'c_positive = "tool"'),
    ):
        assert old in text
        text = text.replace(old, new)
    return text


def built(text: str) -> Machine:
    """A VERNE whose 58 deviations are those of parts made badly: ten times the tolerances of the page."""
    return build_machine((text + as_toml(random_table(3, mm=0.5, mrad=1.0))).encode(), "built.toml")


@pytest.fixture(
    scope="module",
    params=[*KINDS, "other verne", "other linear_delta", "other serial", "other built verne"],
)
def machine(request: pytest.FixtureRequest) -> Machine:
    *words, kind = request.param.split()
    text = other_places(kind) if "other" in words else (ROOT / "machine_configs" / f"{kind}.toml").read_text("utf-8")
    return built(text) if "built" in words else build_machine(text.encode(), f"{request.param}.toml")


@pytest.fixture(scope="module")
def compiled(machine: Machine, tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    return Compiled(machine, tmp_path_factory.mktemp("kins"))


def draw_poses(machine: Machine, n: int, half: float) -> Poses:
    """Random tips within ``half`` of the middle of the table, all tilts, all turns; reached: with sliders in travel and
    drops as the machine file asks."""
    random = np.random.default_rng(49)
    tip = random.uniform([-half, -half, -half], [half, half, half], (n, 3))
    angles = np.radians(random.uniform([-95.0, -400.0], [95.0, 400.0], (n, 2)))
    tool = random.uniform(0.0, 250.0, n)
    q, platform, ok = machine.five_axis.solve(tip, angles, tool)
    factors = np.array([column.factor for column in machine.columns])
    margins = machine.five_axis.find_geometry_margins(q, angles, platform)
    rods = [k for k, one in enumerate(machine.margins) if one.unit == "mm"]
    least = [one.error_below for one in machine.margins if one.unit == "mm"]
    with np.errstate(invalid="ignore"):
        ok &= (margins[:, rods] > least).all(axis=1)
        ok &= ((q >= machine.limits.lower) & (q <= machine.limits.upper)).all(axis=1)
    world = tip - machine.coordinates.machine_zero  # type: ignore[attr-defined]
    world[:, 2] += tool
    return Poses(np.column_stack([world, angles * factors[3:]]), tool, q * factors, ok)


# --- C against Python -----------------------------------------------------------------------------------


@needs_compiler
@pytest.mark.parametrize("solver", SOLVERS)
def test_c_solves_what_python_solves(machine: Machine, compiled: Compiled, solver: str):
    """Both ways, and from the solution of the pose before as well, which here is anywhere."""
    poses = draw_poses(machine, 100_000, 250.0)
    which = poses.reached
    assert which.sum() > 30_000
    world, tool, joints = poses.world[which], poses.tool[which], poses.joints[which]
    for keep in (False, True):
        found, ok = compiled.solve("inverse_rows", world, tool, SOLVERS[solver], keep)
        assert ok.all()
        assert (np.abs(found - joints) <= SHARE * np.maximum(SIZE, np.abs(joints))).all()
        found, ok = compiled.solve("forward_rows", joints, tool, SOLVERS[solver], keep)
        assert ok.all()
        assert (np.abs(found - world) <= SHARE * np.maximum(SIZE, np.abs(world))).all()


@needs_compiler
@pytest.mark.parametrize("solver", SOLVERS)
def test_c_refuses_what_python_cannot_reach_and_writes_nothing(machine: Machine, compiled: Compiled, solver: str):
    """Far tips, so that most poses are out of reach; a pose that C solves and Python does not has sliders beyond
    travel.
    """
    poses = draw_poses(machine, 20_000, 900.0)
    found, ok = compiled.solve("inverse_rows", poses.world, poses.tool, SOLVERS[solver])
    assert ok[poses.reached].all()
    travel = np.sort(
        [machine.limits.lower, machine.limits.upper] * np.array([c.factor for c in machine.columns]), axis=0
    )
    with np.errstate(invalid="ignore"):
        inside = ((found >= travel[0]) & (found <= travel[1])).all(axis=1)
    assert (inside == poses.reached).all()
    assert np.isfinite(found[ok]).all()
    assert np.isnan(found[~ok]).all()  # untouched


@needs_compiler
@pytest.mark.parametrize("solver", SOLVERS)
def test_c_never_answers_with_a_number_that_is_none(machine: Machine, compiled: Compiled, solver: str):
    good = np.array([0.0, 0.0, -400.0, 0.0, 0.0])
    rows = np.array([np.where(np.arange(5) == k, bad, good) for k in range(5) for bad in (np.nan, np.inf, -np.inf)])
    for function in ("inverse_rows", "forward_rows"):
        found, ok = compiled.solve(function, rows, np.zeros(len(rows)), SOLVERS[solver], keep=True)
        assert not ok.any()
        assert np.isnan(found).all()
    far = np.array([[0.0, 0.0, 1e200, 0.0, 0.0], [1e9, 0.0, 0.0, 0.0, 0.0]])
    found, ok = compiled.solve("inverse_rows", far, np.zeros(2), SOLVERS[solver], keep=True)
    assert np.isfinite(found[ok]).all()
    assert not ok.any() or machine.kind == "serial"


@needs_compiler
def test_forward_agrees_on_sliders_that_belong_to_no_pose(machine: Machine, compiled: Compiled):
    """Random sliders: both refuse the same, but beside the crossing of rods, where Python's iteration gives up.

    As built Python leaves sliders below the platform to the margins.
    """
    random = np.random.default_rng(7)
    sliders = random.uniform(machine.limits.lower[:3], machine.limits.upper[:3], (50_000, 3))
    joints = np.column_stack([sliders, np.zeros((len(sliders), 2))])
    _tip, angles, ok = machine.five_axis.find_nominal_pose(joints, 0.0)
    margins = machine.five_axis.find_geometry_margins(joints, angles, machine.five_axis.find_platform(joints)[0])
    ok &= (margins[:, [one.unit == "mm" for one in machine.margins]] > 0.0).all(axis=1)
    for solver in SOLVERS.values():
        found, solved = compiled.solve("forward_rows", joints, np.zeros(len(joints)), solver)
        assert solved[ok].all()
        assert (solved & ~ok).sum() <= 0.001 * len(ok)
        assert np.abs(found[ok, 3] - machine.columns[3].factor * angles[ok, 0]).max() < SHARE * 57.3


@needs_compiler
def test_jacobian_of_the_actuators_is_pythons(machine: Machine, compiled: Compiled):
    poses = draw_poses(machine, 5000, 250.0)
    world, tool = poses.world[poses.reached], poses.tool[poses.reached]
    factors = np.array([column.factor for column in machine.columns])
    tip = world[:, :3] + machine.coordinates.machine_zero  # type: ignore[attr-defined]
    tip[:, 2] -= tool
    expected = machine.five_axis.find_jacobian(tip, world[:, 3:] / factors[3:], tool)
    expected *= factors[:, None] / np.array([1.0, 1.0, 1.0, *factors[3:]])
    # both solve the same linear systems, whose conditions are some tens; as built both are differences, good to 1e-8 a
    # unit
    slack = 2e-7 if isinstance(machine.five_axis, AsBuiltMachine) else 1e-10
    assert np.abs(compiled.jacobian(world, tool) - expected).max() < slack


# --- the files ----------------------------------------------------------------------------------------------


def test_simulation_has_the_limits_of_the_machine_file(machine: Machine):
    made = write_component(machine)
    settings = configparser.ConfigParser(strict=False)
    settings.read_string(made["machine.ini"])
    assert settings["KINS"]["KINEMATICS"] == f"{machine.kind}_kins"
    assert f"{machine.kind}_kins.c" in made
    for k, column in enumerate(machine.columns):
        joint, scale = settings[f"JOINT_{k}"], abs(column.factor)
        ends = np.sort([machine.limits.lower[k] * column.factor, machine.limits.upper[k] * column.factor])
        for key, end in zip(("min_limit", "max_limit"), ends, strict=True):
            assert joint.getfloat(key, fallback=end) == pytest.approx(end, rel=1e-11)
            assert (key in joint) == np.isfinite(end)
        assert joint.getfloat("max_velocity") == pytest.approx(scale * machine.limits.velocity[k], rel=1e-11)
        assert joint.getfloat("max_acceleration") == pytest.approx(scale * machine.limits.acceleration[k], rel=1e-11)
        assert joint.getfloat("max_jerk") == pytest.approx(scale * machine.limits.jerk[k], rel=1e-11)
        assert joint["home"] == joint["home_offset"]
    assert settings["TRAJ"]["planner_type"] == "1"
    assert settings["TRAJ"].getfloat("max_linear_jerk") == machine.limits.jerk[:3].min()


def test_a_joint_without_a_jerk_limit_has_none_in_the_simulation():
    text = (ROOT / "machine_configs/serial.toml").read_text(encoding="utf-8")
    machine = build_machine(re.sub(r"(?m)^c_jerk = .*$", "", text).encode(), "mine.toml")
    settings = configparser.ConfigParser(strict=False)
    settings.read_string(write_component(machine)["machine.ini"])
    moving = [name for name in settings.sections() if name.startswith(("AXIS_", "JOINT_"))]
    assert len(moving) == 10
    assert [name for name in moving if "max_jerk" not in settings[name]] == ["AXIS_C", "JOINT_4"]
    assert settings["TRAJ"]["planner_type"] == "0"
    assert "max_linear_jerk" not in settings["TRAJ"]


def test_home_of_the_simulation_is_g28():
    settings = configparser.ConfigParser(strict=False)
    settings.read_string(write_component(verne_post.load_machine("serial"))["machine.ini"])
    assert [settings[f"JOINT_{k}"].getfloat("home") for k in range(5)] == [0.0] * 5  # zero is machine zero there


def test_the_command_writes_one_folder_and_none_into_another(run: Callable[..., Any], tmp_path: Path):
    folder = tmp_path / "out"
    done = run("machine", "export", "serial", "--format", "linuxcnc-kins", "-o", folder)
    assert done.code == 0
    assert "halcompile --install serial_kins.c" in done.out
    assert {one.name for one in folder.iterdir()} == set(write_component(verne_post.load_machine("serial")))
    other = run("machine", "export", "hexapod", "--format", "linuxcnc-kins", "-o", tmp_path / "other")
    assert "there is no C code for " in " ".join(other.err.split())
    assert "Choose from:\n  linuxcnc-kins,\n  mtconnect\n" in run("machine", "export", "hexapod").err
    again = run("machine", "export", "verne", "--format", "linuxcnc-kins", "-o", folder)
    assert again.code == 2
    assert "not empty" in again.err
    assert not (folder / "verne_kins.c").exists()


# --- MTConnect --------------------------------------------------------------------------------------------------

DEVICES: Final = {"d": "urn:mtconnect.org:MTConnectDevices:2.0"}


@pytest.fixture
def device(machine: Machine) -> ElementTree.Element:
    return ElementTree.fromstring(write_device(machine)["device.xml"])


def test_device_names_every_joint_with_its_limits(machine: Machine, device: ElementTree.Element):
    axes = device.findall(".//d:Axes/d:Components/*", DEVICES)
    assert [one.get("id") for one in axes] == [column.joint for column in machine.columns]
    for k, (one, column) in enumerate(zip(axes, machine.columns, strict=True)):
        linear, scale = column.unit == "mm", abs(column.factor)
        assert one.tag.endswith("}Linear" if linear else "}Rotary")
        stated = {
            spec.get("type"): {end.tag.rpartition("}")[2]: float(end.text) for end in spec}
            for spec in one.findall(".//d:Specification", DEVICES)
        }
        prefix = "" if linear else "ANGULAR_"
        assert stated[f"{prefix}VELOCITY"]["Maximum"] == pytest.approx(scale * machine.limits.velocity[k])
        assert stated[f"{prefix}ACCELERATION"]["Maximum"] == pytest.approx(scale * machine.limits.acceleration[k])
        ends = np.sort([machine.limits.lower[k] * column.factor, machine.limits.upper[k] * column.factor])
        if np.isfinite(ends).all():
            assert stated["POSITION" if linear else "ANGLE"] == pytest.approx({"Minimum": ends[0], "Maximum": ends[1]})
        else:
            assert one.find(".//d:Motion", DEVICES).get("type") == "CONTINUOUS"
        assert f"{scale * machine.limits.jerk[k]:g}" in one.find("d:Description", DEVICES).text


def test_device_moves_as_the_machine_does(machine: Machine, device: ElementTree.Element):
    """A and C: a point fixed to the table turns about the stated axes, in the stated sense, as the coordinates of G53
    say.
    """
    motions = {one.get("id"): one for one in device.findall(".//d:Motion", DEVICES)}
    table: Any = machine.coordinates
    tip, turned = np.array([40.0, -30.0, 70.0]), np.array([41.0, 7.0])  # file sense, degrees

    def place(a: float, c: float) -> NDArray[np.float64]:
        angles = np.radians([a * np.sign(machine.columns[3].factor), c * np.sign(machine.columns[4].factor)])
        return table.find_gauge_point(tip, angles, 0.0) - table.rotary_offset - table.machine_zero

    for name, (a, c) in (("a", (turned[0], 0.0)), ("c", (0.0, turned[1]))):
        origin, axis = (
            np.array(motions[f"{name}-motion"].find(f"d:{tag}", DEVICES).text.split(), float)
            for tag in ("Origin", "Axis")
        )
        begin, angle = place(0.0, 0.0) - origin, np.radians(a + c)
        rotated = (
            begin * np.cos(angle) + np.cross(axis, begin) * np.sin(angle) + axis * (axis @ begin) * (1 - np.cos(angle))
        )
        assert origin + rotated == pytest.approx(place(a, c), abs=1e-9)
    assert motions["c-motion"].get("parentIdRef") == "a-motion"
    for k, column in enumerate(machine.columns[:3]):
        axis = [float(word) for word in motions[f"{column.joint}-motion"].find("d:Axis", DEVICES).text.split()]
        # a serial axis is one of the machine's, a slider goes down
        assert axis == ([float(k == i) for i in range(3)] if machine.kind == "serial" else [0.0, 0.0, -1.0])


@pytest.mark.parametrize(
    ("kind", "lengths"),
    [
        ("verne", [850, 850, 950, 950]),
        ("linear_delta", [900] * 3),
        ("serial", []),
        ("quickstep", [800] * 6),
        ("george_v", [750] * 6),
        ("hexaglide", [1010, 1010, 950, 950, 880, 880]),
        ("bc_trunnion", []),
    ],
)
def test_device_has_the_rods_as_components(kind: str, lengths: list[float]):
    device = ElementTree.fromstring(write_device(verne_post.load_machine(kind))["device.xml"])
    links = device.findall(".//d:Structures/d:Components/d:Link", DEVICES)
    assert [float(one.find(".//d:Nominal", DEVICES).text) for one in links] == pytest.approx(lengths)
    identities = [one.get("id") for one in device.iter() if one.get("id")]
    assert len(identities) == len(set(identities))


class Turn(NamedTuple):
    """An axis of a device in machine coordinates, its parent, and whether it turns the part."""

    origin: NDArray[np.float64]
    axis: NDArray[np.float64]
    parent: str | None
    of_part: bool

    def carry(self, point: NDArray[np.float64], degrees: float, share: float = 1.0) -> NDArray[np.float64]:
        return self.origin * share + Rotation.from_rotvec(np.radians(degrees) * self.axis).apply(
            point - self.origin * share
        )


def read_turns(device: ElementTree.Element) -> dict[str, Turn]:
    found = {}
    for one in device.findall(".//d:Rotary", DEVICES):
        motion = one.find(".//d:Motion", DEVICES)
        origin, axis = (
            np.array(motion.find(f"d:{tag}", DEVICES).text.split(), dtype=float) for tag in ("Origin", "Axis")
        )
        parent = (motion.get("parentIdRef") or "").removesuffix("-motion") or None
        found[one.get("id")] = Turn(origin, axis, parent, "turns the part" in one.find("d:Description", DEVICES).text)
    return found


def place_by_device(
    turns: dict[str, Turn], values: dict[str, float], tip: NDArray[np.float64], moved: NDArray[np.float64], share: float
) -> NDArray[np.float64]:
    """A point (or direction, share 0) of the tool on the part, machine coordinates: linear axes go by ``moved``."""
    inner = [name for name, one in turns.items() if one.parent is not None]
    order = [*inner, *(name for name in turns if name not in inner)]
    for name in order:  # on the tool's side the carried joint first
        if not turns[name].of_part:
            tip = turns[name].carry(tip, values[name], share)
    tip = tip + share * moved
    for name in reversed(order):
        if turns[name].of_part:
            tip = turns[name].carry(tip, -values[name], share)
    return tip


@pytest.mark.parametrize("name", [*CHAINS, "tricept", "george_v", "hexapod", "hexaglide"])
def test_axes_of_a_device_carry_the_tool_as_the_machine_does(name: str):
    """By the device alone: what its axes do to tool and part, against the joints; carriers stand at home."""
    machine = verne_post.load_machine(name)
    device = ElementTree.fromstring(write_device(machine)["device.xml"])
    turns, coordinates = read_turns(device), machine.coordinates
    linear = np.array(
        [one.find(".//d:Axis", DEVICES).text.split() for one in device.findall(".//d:Linear", DEVICES)], dtype=float
    )
    assert np.linalg.norm(linear, axis=1) == pytest.approx(np.ones(len(linear)))
    factors = np.array([column.factor for column in machine.columns])
    upright = coordinates.machine.axis @ coordinates.part_frame  # type: ignore[attr-defined]
    random, zero, length = np.random.default_rng(31), coordinates.machine_zero, 90.0  # type: ignore[attr-defined]
    checked = 0
    for _ in range(40):
        values = random.uniform([-40.0, -120.0], [40.0, 120.0])
        joints = np.array([*random.uniform(-50.0, 50.0, 3), *values])
        names = {column.joint: value for column, value in zip(machine.columns[-2:], values, strict=True)}
        moved = joints[:3] @ linear if machine.kind == "chain" else np.zeros(3)
        tip = place_by_device(turns, names, -length * upright, moved, 1.0) + zero
        axis = place_by_device(turns, names, upright, moved, 0.0)
        if name.startswith("hexa"):
            q, ok = machine.inverse(tip, axis, length)
            if ok and abs(values[0]) > 1.0:
                seen = q[-2:] * factors[-2:]
                assert np.abs(seen[0]) == pytest.approx(abs(values[0]), abs=1e-9)
                turned = values[1] - seen[1] + (180.0 if seen[0] * values[0] < 0 else 0.0)
                assert abs((turned + 180.0) % 360.0 - 180.0) < 1e-9
                checked += 1
            continue
        q = joints / factors if machine.kind == "chain" else np.append(machine.five_axis.home[:3], values / factors[3:])  # type: ignore[attr-defined]
        there, leans, ok = machine.forward(q, length)
        assert ok
        assert there == pytest.approx(tip, abs=1e-6)
        assert leans == pytest.approx(axis, abs=1e-9)
        checked += 1
    assert checked > 10


def test_struts_of_a_device_are_those_of_the_machine_file():
    data = tomllib.loads((ROOT / "machine_configs/hexapod.toml").read_text(encoding="utf-8"))
    device = ElementTree.fromstring(write_device(verne_post.load_machine("hexapod"))["device.xml"])
    struts = {one["length"]: one for one in data["carrier"]["struts"]}
    down = np.array([1.0, -1.0, -1.0])  # the file's base frame has z down, the part's z up
    assert data["chain"]["up"] == [0, 0, -1]
    for one in device.findall(".//d:Linear", DEVICES):
        origin, axis = (np.array(one.find(f".//d:{tag}", DEVICES).text.split(), float) for tag in ("Origin", "Axis"))
        strut = struts[one.get("id")]
        leg = np.array(data["carrier"]["home"]) + strut["platform"] - strut["base"]
        assert axis == pytest.approx(leg / np.linalg.norm(leg) * down, abs=1e-8)
        assert origin == pytest.approx((np.array(strut["base"]) - data["chain"]["gauge"]) * down, abs=1e-6)
        assert one.find(".//d:Motion", DEVICES).get("actuation") == "DIRECT"
    for one in device.findall(".//d:Rotary", DEVICES):
        assert one.find(".//d:Motion", DEVICES).get("actuation") == "VIRTUAL"
        assert one.find(".//d:Specification", DEVICES) is None  # nothing drives it, so nothing limits it


# --- LinuxCNC itself ------------------------------------------------------------------------------------------

#: It rests at each place: on a busy machine the sampler misses rows, and a stop has few.
PROGRAM: Final = """
G21 G90 G94 G64 P0.01
G10 L2 P1 X0 Y0 Z-550
G43.1 Z100
G0 X10 Y5 Z60 A0 C0
G1 F6000 X20 Y15 Z50 A10 C20
G4 P0.2
M68 E3 Q1 (joints)
M66 E0 L0
G53 G1 X{0:.6f} Y{1:.6f} Z{2:.6f} A{3:.6f} C{4:.6f} F6000
G4 P0.2
M68 E3 Q0 (tool centre point)
M66 E0 L0
G1 X0 Y0 Z50 A0 C0
M2
"""


@pytest.mark.skipif(why_not() is not None, reason=f"LinuxCNC: {why_not()}")
@pytest.mark.parametrize(
    ("kind", "newton"), [("verne", True), ("linear_delta", False), ("serial", False), ("built verne", True)]
)
def test_linuxcnc_runs_a_program_with_the_component(kind: str, newton: bool, tmp_path: Path):
    """Poses under tool-centre-point control, joints beside them, and back: each stands where Python says."""
    *words, name = kind.split()
    text = (ROOT / f"machine_configs/{name}.toml").read_text(encoding="utf-8")
    machine = built(text) if words else build_machine(text.encode(), name)
    factors = np.array([column.factor for column in machine.columns])

    def joints(tip: list[float], a: float, c: float) -> NDArray[np.float64]:
        return machine.five_axis.find_joints(np.array(tip), np.radians([a, c]), 100.0) * factors

    first, beside, last = joints([20, 15, 50], 10, 20), joints([22, 16, 55], 11, 21), joints([0, 0, 50], 0, 0)
    run = run_program(machine, tmp_path, PROGRAM.format(*beside), 120, newton=newton)
    assert run.said == []
    assert run.done
    for place in (first, beside, last):
        assert np.abs(run.joints - place).max(axis=1).min() < 2e-6  # samples and words have six decimals
    assert np.abs(run.joints[-1] - last).max() < 2e-6


@pytest.mark.skipif(why_not() is not None, reason=f"LinuxCNC: {why_not()}")
def test_linuxcnc_refuses_a_program_beyond_travel(tmp_path: Path):
    machine = verne_post.load_machine("linear_delta")
    run = run_program(machine, tmp_path, "G21 G90\nG10 L2 P1 Z-550\nG0 Z60\nG0 X2000\nM2\n", 120)
    assert not run.done
    assert any("kinematicsInverse" in text or "limit" in text for text in run.said)


@pytest.mark.skipif(why_not() is not None, reason=f"LinuxCNC: {why_not()}")
def test_setpoints_are_played_back_by_halstreamer_as_they_are(tmp_path: Path):
    source = b"G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG1 X5 Y3 A2 C4 F3000\nM2\n"
    result = verne_post.convert(source, "verne", verne_post.Options(tool_length=50.0))
    assert result.setpoints is not None
    rows = np.asarray(result.setpoints.values)
    played = stream(tmp_path, rows)
    assert len(played) == len(rows) > 100
    assert np.abs(played - rows).max() < 5.1e-7  # samples have six decimals
