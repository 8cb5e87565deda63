"""Machines beside the VERNE, end to end; and a machine that only this file knows.

The judge of the files written here has its own forward kinematics: the serial machine's is three signs and a shift, the
linear delta's is Newton on its rod equations. Limits are read from the machine file's text.
"""

import io
import json
import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import verne_post
from verne_post.config.kinds import KINDS, Kind
from verne_post.config.schema import Positive
from verne_post.config.sentences import Table
from verne_post.model.options import Options
from verne_post.model.protocols import ForwardSolution, InverseSolution, Margin

ROOT = Path(__file__).resolve().parents[1]
#: Short samples of every kind of motion; the blade adds minutes of the same.
SAMPLES = ["inch", "inverse_time", "pocket_3axis", "posted", "slider_bound"]
MACHINES = {"serial": ["x_mm", "y_mm", "z_mm"], "linear_delta": ["rho1_mm", "rho2_mm", "rho3_mm"]}
GROUP = {"serial": "xyz", "linear_delta": "rho"}
#: Acceptance of a written file: velocity, acceleration, jerk over their limits; tip in mm.
RATIOS, TIP_MM = (1.001, 1.005, 1.02), 1e-3
PROGRAM = """G21 G90 G94 G17 G40 G49
S9000 M3
G0 X20 Y-10 Z30 A0 C0
G1 Z5 F1200
X40 Y15 A20 C35
G3 X20 Y35 I-20 J0 F900
G1 A-15 C90 F900
G53 G0 Z0
M2
"""
PLACE = ["--tool-length", "90", "--wcs", "G54=12,-8,45"]


def position(name: str, q: np.ndarray, module: dict[str, Any]) -> np.ndarray:
    """P in the base frame (n, 3) of written actuators (n, 3)."""
    if name == "serial":
        return np.array(module["zero"]) + q * [1, -1, -1]
    theta = np.radians(module["leg_angles_deg"])
    d = module["base_radius"] - module["platform_radius"]
    centre = np.zeros((*q.shape, 3))
    centre[..., 0], centre[..., 1], centre[..., 2] = d * np.cos(theta), d * np.sin(theta), q
    point = np.column_stack([np.zeros((len(q), 2)), q.mean(axis=1) + module["rod_length"]])
    for _ in range(20):
        rod = point[:, None, :] - centre
        residual = np.sum(rod**2, axis=-1) - module["rod_length"] ** 2
        point = point - np.linalg.solve(2 * rod, residual[..., None])[..., 0]
    assert np.abs(residual).max() < 1e-6
    assert (q < point[:, 2:]).all()  # sliders above the platform
    return point


def table_tip(point: np.ndarray, a: np.ndarray, c: np.ndarray, reach: float, table: dict[str, Any]) -> np.ndarray:
    """Tip in the table frame (n, 3) of P, table angles in degrees and the length from P to the tip."""
    a, c = np.radians(a), np.radians(c)
    x, y, z = ((point - table["pivot"]) * [1, -1, -1]).T
    z = z - reach
    y, z = np.cos(a) * y + np.sin(a) * z, np.cos(a) * z - np.sin(a) * y
    x, y, z = x - table["rotary_offset"][0], y - table["rotary_offset"][1], z - table["rotary_offset"][2]
    return np.column_stack([np.cos(c) * x + np.sin(c) * y, np.cos(c) * y - np.sin(c) * x, z])


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("sample", SAMPLES)
def test_samples_convert_and_verify(
    name: str, sample: str, run: Callable[..., Any], sample_words: Callable[[str], list[str]], tmp_path: Path
) -> None:
    """The written numbers keep every limit, and put the tip where the program has it at the end of every segment."""
    source, axes = ROOT / "gcode_samples" / f"{sample}.nc", tmp_path / "axes.csv"
    options = ["--machine", name, *sample_words(source.name)]
    answer = run("convert", source, *options, "-o", axes)
    assert answer.code == 0, answer.err
    assert "module, spindle, table, limits, control, home, accuracy" in " ".join(answer.err.split())
    verified = run("verify", axes, "--against", source, *options)
    assert verified.code == 0, verified.err
    text = axes.read_text(encoding="utf-8")
    assert text.splitlines()[0].split(",") == ["t_s", *MACHINES[name], "a_deg", "c_deg", "line"]
    rows = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1)
    file = tomllib.loads((ROOT / "machine_configs" / f"{name}.toml").read_text(encoding="utf-8"))
    limits, cycle = file["limits"], file["control"]["cycle_s"]
    padded = np.vstack([rows[:1, 1:6]] * 3 + [rows[:, 1:6]] + [rows[-1:, 1:6]] * 3)
    for order, (what, ratio) in enumerate(zip(("velocity", "acceleration", "jerk"), RATIOS, strict=True), start=1):
        bound = [limits[f"{GROUP[name]}_{what}"]] * 3 + [limits[f"a_{what}"], limits[f"c_{what}"]]
        assert (np.abs(np.diff(padded, order, axis=0)).max(axis=0) / cycle**order <= ratio * np.array(bound)).all()
    travel = limits[f"{GROUP[name]}_mm"]
    low, high = np.array(travel if isinstance(travel[0], list) else [travel] * 3).T
    assert ((rows[:, 1:4] >= low) & (rows[:, 1:4] <= high)).all()

    if "--tool-length" not in options:
        return  # the tool's length changes in the program; the rest is the verifier's
    reach = float(options[options.index("--tool-length") + 1]) + file["spindle"]["nose_offset_mm"]
    tips = table_tip(position(name, rows[:, 1:4], file["module"]), rows[:, 4], rows[:, 5], reach, file["table"])
    origin = [float(v) for v in options[options.index("--wcs") + 1].partition("=")[2].split(",")]
    assert len(origin) == 3
    dumped = run("dump", "poses", source, *options)
    for pose in map(json.loads, dumped.out.splitlines()):
        mine = tips[rows[:, 6] == pose["line"]] - origin
        # points inside a curved segment lie between rows; only those at rest must be rows
        if len(mine):
            step = np.linalg.norm(np.diff(mine, axis=0), axis=1).max(initial=0.0)
            assert np.linalg.norm(mine - pose["tip"], axis=1).min() < TIP_MM + step
    ends = {record["line"]: record["tip"] for record in map(json.loads, dumped.out.splitlines())}
    last = max(ends)
    assert np.linalg.norm(tips[-1] - origin - ends[last]) < TIP_MM


@pytest.mark.parametrize("name", MACHINES)
def test_approach_from_home_and_from_joint_values(name: str, run: Callable[..., Any], tmp_path: Path) -> None:
    program, axes = tmp_path / "part.nc", tmp_path / "axes.csv"
    program.write_text(PROGRAM, encoding="utf-8")
    options = ["--machine", name, *PLACE]
    assert run("convert", program, *options, "--from", "home", "-o", axes).code == 0
    first = axes.read_text(encoding="utf-8").splitlines()[1].split(",")
    home = verne_post.load_machine(name)
    q, ok = home.inverse(np.array([0.0, 0.0, 550.0]), np.array([0.0, 0.0, 1.0]), 0.0)
    assert ok
    assert [float(cell) for cell in first[1:4]] == pytest.approx(q[:3], abs=1e-6)
    assert first[-1] == "0"
    assert run("verify", axes, "--against", program, *options, "--from", "home").code == 0
    assert run("verify", axes, "--against", program, *options).code == 1
    values = ",".join(str(round(value + 3.0, 2)) for value in q[:3]) + ",10,-20"
    assert run("convert", program, *options, f"--from={values}", "-o", axes).code == 0
    assert run("verify", axes, "--against", program, *options, f"--from={values}").code == 0
    refused = run("convert", program, *options, "--from", "1,2", "-o", axes)
    assert refused.code == 2
    assert "5 values " + ",".join(column.partition("_")[0] for column in MACHINES[name]) + ",a,c" in refused.err


def test_machine_coordinates_are_the_axes_of_the_serial_machine(run: Callable[..., Any], tmp_path: Path) -> None:
    """G53 names x, y, z, A and C; the last row must show these numbers, whatever offset and tool are in force."""
    program, axes = tmp_path / "park.nc", tmp_path / "axes.csv"
    program.write_text("G49 G0 X0 Y0 Z120 A0 C0\nG53 G0 X-30 Y55 Z-120 A12 C34\nM2\n", encoding="utf-8")
    assert run(program, "--machine", "serial", *PLACE, "-o", axes).code == 0
    last = [float(cell) for cell in axes.read_text(encoding="utf-8").splitlines()[-1].split(",")]
    assert last[1:6] == pytest.approx([-30.0, 55.0, -120.0, 12.0, 34.0], abs=1e-6)


@pytest.mark.parametrize(("name", "solutions"), [("serial", 2), ("linear_delta", 16)])
def test_explain_and_dump_speak_of_this_machines_joints(
    name: str, solutions: int, run: Callable[..., Any], tmp_path: Path
) -> None:
    program = tmp_path / "part.nc"
    program.write_text(PROGRAM, encoding="utf-8")
    told = run("explain", f"{program}:5", "--all", "--machine", name, *PLACE)
    assert told.code == 0
    assert told.out.count("\n  alpha ") == solutions
    assert told.out.count("in use") == 1
    for column in (*MACHINES[name], "a_deg", "c_deg"):
        assert f"\n  {column} " in told.out
    assert ("VP202" in told.out) == (name == "linear_delta")
    if name == "serial":
        assert "rho" not in told.out
        assert " s (" not in told.out
    dumped = run("dump", "joints", program, "--machine", name, *PLACE)
    assert dumped.code == 0
    rods = [
        "vertical drop of a rod (rho1)",
        "vertical drop of a rod (rho2)",
        "vertical drop of a rod (rho3)",
        "distance from the parallel singularity",
    ]
    joints = [column.partition("_")[0] for column in (*MACHINES[name], "a_deg", "c_deg")]
    for record in map(json.loads, dumped.out.splitlines()):
        assert list(record["q"]) == [*MACHINES[name], "a_deg", "c_deg"]
        assert record["alpha_deg"] == 0.0
        assert list(record["margins"]) == [f"travel of {j}" for j in joints] + (rods if name != "serial" else [])


@pytest.mark.parametrize(
    ("name", "line", "code", "axis", "limit"),
    [
        ("serial", "G1 X450 F900", "VP101", "x", 400.0),
        ("serial", "G1 Z700 F900", "VP101", "z", 100.0),
        ("serial", "G1 A97 F900", "VP102", "a", 95.0),
        ("linear_delta", "G1 X0 Y0 Z750 F900", "VP101", "rho1", 50.0),
        ("linear_delta", "G1 X-545 F900", "VP202", "rho1", 100.0),
        ("linear_delta", "G1 X900 F900", "VP110", None, None),
    ],
)
def test_check_names_the_joint_in_its_report(
    name: str, line: str, code: str, axis: str | None, limit: float | None, run: Callable[..., Any], tmp_path: Path
) -> None:
    program = tmp_path / "part.nc"
    program.write_text(f"G49 G0 X0 Y0 Z60 A0 C0\n{line}\nM2\n", encoding="utf-8")
    answer = run("check", program, "--machine", name, "--tool-length", 50, "--output-format", "json")
    assert answer.code == 1
    (report,) = json.loads(answer.out)["programs"]
    assert report["machine"]["name"] == verne_post.load_machine(name).name
    found = [item for item in report["findings"] if (item["code"], item["axis"]) == (code, axis)]
    assert [(item["severity"], item["line"], item["limit"]) for item in found[:1]] == [("error", 2, limit)]


def test_machine_command_knows_them(run: Callable[..., Any]) -> None:
    shown = [tuple(line.split(maxsplit=1)) for line in run("machine", "list").out.splitlines()]
    files = sorted((ROOT / "machine_configs").glob("*.toml"))
    assert shown == [(path.stem, tomllib.loads(path.read_text("utf-8"))["name"]) for path in files]
    for name in MACHINES:
        assert run("machine", "show", name).out == (ROOT / "machine_configs" / f"{name}.toml").read_text()
        valid = run("machine", "validate", name)
        assert (valid.code, valid.err) == (0, "")
        assert f"(kind {name}) is sound" in valid.out


# --- a machine that only this file knows --------------------------------------------------------------


class ToyFile(Table, frozen=True, kw_only=True):
    """[module] of the toy."""

    height: Positive


@dataclass(frozen=True)
class ToyModule:
    """A spindle on two crossed slides and a wedge: ``u = x + y, v = x - y, w = height - z + x / 4``; never tilts."""

    height: float

    actuators: ClassVar[tuple[str, ...]] = ("u", "v", "w")

    def inverse(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x, y, z = np.moveaxis(np.asarray(position, dtype=float), -1, 0)
        q = np.stack([x + y, x - y, self.height - z + x / 4], axis=-1)
        return q, np.zeros(x.shape), np.isfinite(q).all(axis=-1)

    def forward(self, rho: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        u, v, w = np.moveaxis(np.asarray(rho, dtype=float), -1, 0)
        x = (u + v) / 2
        position = np.stack([x, (u - v) / 2, self.height - w + x / 4], axis=-1)
        return position, np.zeros(u.shape), np.isfinite(position).all(axis=-1)

    def solve_coupled(self, pivot: np.ndarray, gauge: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self.inverse(pivot + gauge * [1.0, -1.0, -1.0])

    def explain_unreachable(self, pivot: np.ndarray, gauge: np.ndarray) -> list[str]:
        return ["VP110"] * len(gauge)

    def inverse_all(self, position: np.ndarray) -> list[InverseSolution]:
        u, v, w = (float(value) for value in self.inverse(position)[0])
        return [InverseSolution(0.0, (), (u, v, w), None)]

    def forward_all(self, rho: np.ndarray) -> list[ForwardSolution]:
        x, y, z = (float(value) for value in self.forward(rho)[0])
        return [ForwardSolution((x, y, z), 0.0, None)]

    def find_geometry_margins(self, position: np.ndarray, alpha: np.ndarray) -> np.ndarray:
        return 1000.0 - np.abs(position[..., :1])

    def solve_coupled_all(self, pivot: np.ndarray, gauge: np.ndarray) -> list[InverseSolution]:
        return self.inverse_all(pivot + gauge * [1.0, -1.0, -1.0])

    def find_jacobians(self, position: np.ndarray, alpha: np.ndarray, rho: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        by_position = np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [0.25, 0.0, -1.0]])
        parallel = np.zeros((*np.shape(rho)[:-1], 4, 4))
        parallel[..., :3, :3], parallel[..., 3, 3] = by_position, 1.0
        return parallel, np.broadcast_to(-np.eye(4, 3), (*np.shape(rho)[:-1], 4, 3))

    def measure_conditioning(
        self, position: np.ndarray, alpha: np.ndarray, rho: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        return np.full(np.shape(alpha), 0.5), np.ones(np.shape(alpha))

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        return (Margin("wedge left", "VP202", "w", "mm", 10.0, 20.0),)


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """One entry in the table of kinds and one machine file: all that a new machine needs."""
    monkeypatch.setitem(KINDS, "toy", Kind(ToyFile, ToyModule, group="slide", rods=False))
    text = (ROOT / "machine_configs" / "serial.toml").read_text(encoding="utf-8")
    text = text.replace('kind = "serial"', 'kind = "toy"').replace("zero = [0.0, 0.0, 1050.0]", "height = 1600.0")
    text = re.sub(r"^xyz_mm = .*$", "slide_mm = [-900.0, 900.0]", text, flags=re.MULTILINE).replace("xyz_", "slide_")
    file = tmp_path / "toy.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_new_kind_is_one_entry_and_runs_through_everything(
    toy: Path, run: Callable[..., Any], tmp_path: Path
) -> None:
    program, axes, meta = tmp_path / "part.nc", tmp_path / "axes.csv", tmp_path / "meta.json"
    program.write_text(PROGRAM, encoding="utf-8")
    options = ["--machine", toy, *PLACE]
    valid = run("machine", "validate", toy)
    assert (valid.code, valid.err) == (0, "")
    assert "(kind toy) is sound" in valid.out
    answer = run(program, *options, "--from", "home", "-o", axes, "--meta", meta)
    assert answer.code == 0, answer.err
    assert run("verify", axes, "--against", program, *options, "--from", "home").code == 0
    header, first, *_rows = axes.read_text(encoding="utf-8").splitlines()
    assert header == "t_s,u_mm,v_mm,w_mm,a_deg,c_deg,line"
    # home is 550 over the rotary centre at z = 1600: P = (0, 0, 1050)
    assert [float(cell) for cell in first.split(",")[1:4]] == pytest.approx([0.0, 0.0, 550.0], abs=1e-9)
    facts = json.loads(meta.read_text(encoding="utf-8"))
    assert list(facts["verification"]["jerk_ratio"]) == ["u", "v", "w", "a", "c"]
    told = run("explain", f"{program}:5", "--all", *options)
    assert told.code == 0
    assert "wedge left (w)" in told.out
    dumped = run("dump", "joints", program, *options)
    assert list(json.loads(dumped.out.splitlines()[0])["q"]) == ["u_mm", "v_mm", "w_mm", "a_deg", "c_deg"]
    far = tmp_path / "far.nc"
    far.write_text("G49 G0 X0 Y0 Z60 A0 C0\nG1 X985 Y-985 F900\nM2\n", encoding="utf-8")
    report = json.loads(run("check", far, *options, "--output-format", "json").out)
    codes = {(item["code"], item["axis"], item["severity"]) for item in report["programs"][0]["findings"]}
    assert codes == {("VP101", "u", "error"), ("VP202", "w", "error")}


def test_limits_of_a_new_kind_take_its_own_name(toy: Path, run: Callable[..., Any]) -> None:
    toy.write_text(toy.read_text(encoding="utf-8").replace("slide_velocity", "slide_velocty"), encoding="utf-8")
    answer = run("machine", "validate", toy)
    assert answer.code == 2
    assert "is missing" not in answer.err  # one mistake
    assert (
        "limits.slide_velocty is not a key of a machine file of kind 'toy'; did you mean slide_velocity?" in answer.err
    )


@pytest.mark.parametrize("name", [*MACHINES, "verne"])
def test_a_machine_can_be_sent_to_another_process(name: str) -> None:
    """Machines are data: they survive pickling, and convert to the same bytes."""
    import pickle

    machine = verne_post.load_machine(name)
    options = Options(tool_length=90.0)
    source = b"G0 X20 Y-10 Z130 A0 C0\nG1 X40 A20 F1200\nM2\n"
    here = verne_post.convert(source, machine, options)
    there = verne_post.convert(source, pickle.loads(pickle.dumps(machine)), options)
    assert here.ok
    assert there.ok
    np.testing.assert_array_equal(here.setpoints.values, there.setpoints.values)


def test_a_direction_along_no_axis_is_named(run: Callable[..., Any], tmp_path: Path) -> None:
    """[1, 1, 0] may be meant, as on a nutating table, or be two axes in one line; upright ones are not named."""
    text = (ROOT / "machine_configs" / "ac_trunnion.toml").read_text("utf-8")
    file = tmp_path / "mine.toml"
    file.write_text(re.sub(r"(?m)^turns = \[.*?\]", "turns = [1, 1, 0]", text, count=1), "utf-8")
    answer = run("machine", "validate", file)
    assert "a turns about (0.707107, 0.707107, 0): along no axis, 45 degrees from x" in answer.out + answer.err
    assert "along no axis" not in run("machine", "validate", "ac_trunnion").out


def test_a_misspelt_key_is_one_mistake(run: Callable[..., Any], tmp_path: Path) -> None:
    text = (ROOT / "machine_configs" / "ac_trunnion.toml").read_text("utf-8")
    file = tmp_path / "mine.toml"
    file.write_text(text.replace("\nvelocity = ", "\nvelocty = ", 1), "utf-8")
    line, *_shown = run("machine", "validate", file).err.splitlines()
    assert sum(" error: " in one for one in (line, *_shown)) == 1
    assert "velocty is not a key of a machine file of schema 2; did you mean velocity?" in line
