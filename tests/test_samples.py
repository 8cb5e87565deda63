"""Every sample program does what its header promises, by a judge that shares no code with the package.

The judge reads nothing but the text of the setpoint file, the machine file, the header of the sample and
what `dump moves` shows of it. Its kinematics are the paper's rod equations (3) to (6).
"""

import io
import json
import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

from .builders import HEADER, SAME_PATHS

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "gcode_samples"
# The acceptance bounds of a written file.
VELOCITY, ACCELERATION, JERK, FEED, TIP_MM, AXIS_DEG = 1.001, 1.005, 1.02, 1.001, 1e-3, 1e-3
# How much a degree counts for against a millimetre where the nearest pose of a segment is sought: 50 mm a radian.
MM_PER_DEG = 50.0 * np.pi / 180.0
# Programmed lengths below this are no motion (the same bound as the package documents).
NO_LENGTH = 1e-6


def header(sample: Path) -> str:
    """The comment lines at the top of a sample."""
    lines = []
    for line in sample.read_text(encoding="utf-8").splitlines():
        if line.strip() and line[0] not in "(%O;":
            break
        lines.append(line)
    return "\n".join(lines)


def options(sample: Path) -> list[str]:
    """Command-line options that the set-up beside a sample stands for."""
    setup = tomllib.loads(sample.with_name(f"{sample.name}.toml").read_text(encoding="utf-8"))
    wcs = [f"{name}={','.join(map(str, numbers))}" for name, numbers in setup.pop("wcs", {}).items()]
    words = [word for text in wcs for word in ("--wcs", text)]
    for key, value in setup.items():
        words += [f"--{key.replace('_', '-')}", f"gcode_samples/{value}" if key == "tool_table" else str(value)]
    return words


#: Compared with twins in tests/gcode/test_dialects.py: this judge knows no tilted plane, nor lines that are executed
#: several times.
OTHER_DIALECTS = {"fanuc_tilted", "two_faces", "two_faces_fanuc"}
SAMPLES = sorted(path for path in FOLDER.glob("*.nc") if path.stem not in OTHER_DIALECTS)
REFUSED = [sample for sample in SAMPLES if "exit 1" in header(sample)]
GOOD = [sample for sample in SAMPLES if sample not in REFUSED]
#: Every sample that converts, those with a set-up beside them: each path in one dialect.
CONVERTED = sorted(
    path
    for path in {setup.with_suffix("") for setup in FOLDER.glob("*.toml")} - set(REFUSED)
    if path.name not in SAME_PATHS
)


def named(samples: list[Path]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("sample", samples, ids=[sample.stem for sample in samples])


# --- the independent judge -------------------------------------------------------------------


def differences(values: np.ndarray, cycle: float) -> list[np.ndarray]:
    """Velocity, acceleration and jerk of rows between three resting rows at either end."""
    padded = np.vstack([values[:1]] * 3 + [values] + [values[-1:]] * 3)
    return [np.diff(padded, order, axis=0) / cycle**order for order in (1, 2, 3)]


def platform(rho: np.ndarray, m: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Newton on (3) to (6) for x, y, z, alpha: slider coordinates (n, 3) -> P (n, 3), alpha (n,)."""
    d1, d2 = m["leg1_x_offset"], m["leg23_x_offset"]
    big1, small1, big2, small4 = m["R1"], m["r1"], m["R2"], m["r4"]
    state = np.column_stack([np.zeros((len(rho), 2)), rho.mean(axis=1) + 810.0, np.zeros(len(rho))])
    for _ in range(12):
        x, y, z, alpha = state.T
        c, s = np.cos(alpha), np.sin(alpha)
        legs = [
            (x + d1, y + big1 * c - small1, z + big1 * s - rho[:, 0], -big1 * s, big1 * c, m["L1"]),
            (x + d1, y - big1 * c + small1, z - big1 * s - rho[:, 0], big1 * s, -big1 * c, m["L1"]),
            (x + d2, y - big2 * c + small4, z - big2 * s - rho[:, 1], big2 * s, -big2 * c, m["L2"]),
            (x + d2, y + big2 * c - small4, z + big2 * s - rho[:, 2], -big2 * s, big2 * c, m["L3"]),
        ]
        residual = np.stack([u * u + v * v + w * w - rod**2 for u, v, w, _dv, _dw, rod in legs], axis=1)
        jacobian = 2 * np.stack([np.stack([u, v, w, v * dv + w * dw], axis=1) for u, v, w, dv, dw, _ in legs], axis=1)
        if np.abs(residual).max() < 1e-7:  # 1e-10 mm on a rod of 900 mm
            break
        state = state - np.linalg.solve(jacobian, residual[..., None])[..., 0]
    else:
        raise AssertionError("the rod equations do not close")
    x, y, z, alpha = state.T
    # the working mode: rods of leg I uncrossed, sliders above the platform
    assert (big1 * np.cos(alpha) > small1).all()
    assert (rho < z[:, None] - big2 * np.abs(np.sin(alpha))[:, None]).all()
    return state[:, :3], alpha


def turn(vector: np.ndarray, angle: np.ndarray | float, about: int) -> np.ndarray:
    """Active rotation about axis 0 (x) or 2 (z)."""
    first, second = {0: (1, 2), 2: (0, 1)}[about]
    c, s = np.cos(angle), np.sin(angle)
    turned = np.array(np.broadcast_to(vector, (*np.broadcast_shapes(vector.shape[:-1], np.shape(angle)), 3)))
    p, q = turned[..., first].copy(), turned[..., second].copy()
    turned[..., first], turned[..., second] = c * p - s * q, s * p + c * q
    return turned


@dataclass
class Rows:
    """A setpoint file as its text says, and where it puts the tool in the work frame."""

    text: str
    t: np.ndarray
    q: np.ndarray
    line: np.ndarray
    tip: np.ndarray
    axis: np.ndarray
    angles: np.ndarray  # nominal A and the programmed C, degrees

    @classmethod
    def read(cls, text: str, file: dict[str, Any], length: float, work: list[float]) -> "Rows":
        """From CSV text; ``work`` is x, y, z and turn of the part on the table."""
        table = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1)
        position, alpha = platform(table[:, 1:4], file["module"])
        reach = length + file["spindle"]["nose_offset_mm"]
        a, c = np.radians(table[:, 4]), np.radians(table[:, 5])
        tip_base = position + turn(np.array([0.0, 0.0, reach]), alpha, 0)
        upright = (tip_base - file["table"]["pivot"]) * [1.0, -1.0, -1.0]
        point = turn(turn(upright, -a, 0) - file["table"]["rotary_offset"], -c, 2)
        axis = np.column_stack([np.zeros_like(alpha), -np.sin(alpha), np.cos(alpha)])
        part = np.radians(work[3])
        return cls(
            text,
            table[:, 0],
            table[:, 1:6],
            table[:, 6].astype(int),
            turn(point - work[:3], -part, 2),
            turn(turn(turn(axis, -a, 0), -c, 2), -part, 2),
            np.degrees(np.column_stack([a - alpha, c + part])),
        )


def programmed_axis(angles: np.ndarray) -> np.ndarray:
    """k = (sin A sin C, sin A cos C, cos A) of angles (n, 2) in degrees."""
    a, c = np.radians(angles).T
    return np.column_stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)])


def on_line(tip: np.ndarray, angles: np.ndarray, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance of points from the nearest pose of a segment, and the angles programmed there; rows are x, y, z,
    A, C.
    """
    delta = end - start
    scale = np.array([1.0, 1.0, 1.0, MM_PER_DEG, MM_PER_DEG])
    here = (np.hstack([tip, angles]) - start) * scale
    u = here @ (delta * scale) / ((delta * scale) @ (delta * scale))
    at = start + np.clip(u, 0.0, 1.0)[:, None] * delta
    return np.linalg.norm(tip - at[:, :3], axis=1), at[:, 3:]


def on_arc(
    tip: np.ndarray, angles: np.ndarray, start: np.ndarray, end: np.ndarray, arc: dict[str, Any]
) -> tuple[np.ndarray, np.ndarray]:
    """The same for an arc or helix, given as `dump moves` shows it."""
    first, second, _normal = {"XY": (0, 1, 2), "ZX": (2, 0, 1), "YZ": (1, 2, 0)}[arc["plane"]]
    center, sweep = np.array(arc["center"]), np.radians(arc["sweep"])
    (p0, q0), (p1, q1) = ((point - center)[[first, second]] for point in (start[:3], end[:3]))
    r0, r1, phi0 = np.hypot(p0, q0), np.hypot(p1, q1), np.arctan2(q0, p0)
    phi = np.arctan2(tip[:, second] - center[second], tip[:, first] - center[first])
    passed = np.mod((phi - phi0) * np.sign(sweep), 2 * np.pi)
    best, wanted = np.full(len(tip), np.inf), np.zeros((len(tip), 2))
    off = np.full(len(tip), np.inf)
    for turns in range(-1, abs(arc["turns"]) + 1):
        u = np.clip((passed + 2 * np.pi * turns) / abs(sweep), 0.0, 1.0)
        point = start[:3] + u[:, None] * (end - start)[:3]
        radius = r0 + u * (r1 - r0)
        point[:, first] = center[first] + radius * np.cos(phi0 + u * sweep)
        point[:, second] = center[second] + radius * np.sin(phi0 + u * sweep)
        there = start[3:] + u[:, None] * (end - start)[3:]
        distance = np.linalg.norm(tip - point, axis=1)
        # a point may lie on several turns of a circle: the one whose angles fit is meant
        cost = distance + 0.01 * np.abs(angles - there).sum(axis=1)
        closer = cost < best
        best, off = np.where(closer, cost, best), np.where(closer, distance, off)
        wanted = np.where(closer[:, None], there, wanted)
    return off, wanted


def on_spline(
    tip: np.ndarray, angles: np.ndarray, start: np.ndarray, end: np.ndarray, piece: dict[str, Any]
) -> tuple[np.ndarray, np.ndarray]:
    """The same for a piece of a rational B-spline, by scipy; its outermost knots have no influence on it."""
    degree, knots = piece["degree"], np.array(piece["knots"])
    points, weights = np.array(piece["points"])[:, [0, 1, 2, 3, 5]], np.array(piece["weights"])[:, None]
    plane = BSpline(np.concatenate([[knots[0]], knots, [knots[-1]]]), np.hstack([points * weights, weights]), degree)
    low, high = knots[degree - 1], knots[degree]

    def pose(t: np.ndarray) -> np.ndarray:
        values = plane(np.clip(t, low, high))
        return np.asarray(values[:, :5] / values[:, 5:])

    assert np.abs(pose(np.array([low]))[0] - start).max() < 1e-9
    assert np.abs(pose(np.array([high]))[0] - end).max() < 1e-9
    here, scale = np.hstack([tip, angles]), np.array([1.0, 1.0, 1.0, MM_PER_DEG, MM_PER_DEG])
    grid = np.linspace(low, high, 1001)
    best = grid[cKDTree(pose(grid) * scale).query(here * scale)[1]]
    step = np.full(len(here), grid[1] - grid[0])
    for _ in range(60):  # the nearer of two neighbours, ever closer
        tried = [best, best - step, best + step]
        nearest = np.argmin([np.linalg.norm((here - pose(t)) * scale, axis=1) for t in tried], axis=0)
        best = np.clip(np.choose(nearest, tried), low, high)
        step = np.where(nearest == 0, 0.5 * step, step)
    return np.linalg.norm(tip - pose(best)[:, :3], axis=1), pose(best)[:, 3:]


@dataclass
class Judgement:
    """Worst value over limit of each column, and worst distances from the program."""

    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    tip_mm: float
    axis_deg: float
    rotary_deg: float
    feed: float
    lines: list[int]
    programmed_lines: list[int]
    end_gap_mm: float

    def acceptable(self, tip_mm: float = TIP_MM, axis_deg: float = AXIS_DEG) -> None:
        """Raise where an acceptance bound is exceeded; the tolerances are larger where corners are rounded."""
        assert self.velocity.max() <= VELOCITY
        assert self.acceleration.max() <= ACCELERATION
        assert self.jerk.max() <= JERK
        assert self.feed <= FEED
        assert self.tip_mm <= tip_mm
        assert self.axis_deg <= axis_deg
        # C turns the axis by sin(A) of its own angle, and no sample rounds corners below 30 degrees of tilt while C
        # turns
        assert self.rotary_deg <= axis_deg * (1.0 if axis_deg == AXIS_DEG else 2.0)
        assert self.lines == self.programmed_lines
        assert self.end_gap_mm <= TIP_MM


def judged(rows: Rows, file: dict[str, Any], moves: list[dict[str, Any]]) -> Judgement:
    """Judge rows against limits and against the moves of the program."""
    cycle, limits = file["control"]["cycle_s"], file["limits"]
    ratios = [
        np.abs(difference).max(axis=0) / [*[limits[f"rho_{name}"]] * 3, limits[f"a_{name}"], limits[f"c_{name}"]]
        for difference, name in zip(differences(rows.q, cycle), ("velocity", "acceleration", "jerk"), strict=True)
    ]
    here = np.concatenate([rows.tip[0], rows.angles[0]])  # until the first line with rows
    begun, lines = False, []
    tip_off = axis_off = rotary_off = feed = 0.0
    for move in moves:
        if "end" not in move:
            continue
        end = np.array(move["end"])[[0, 1, 2, 3, 5]]
        mine = np.flatnonzero(rows.line == move["line"])
        begun = begun or bool(len(mine))
        if not begun:
            continue
        curve = {"arc": on_arc, "spline": on_spline}.get(move["kind"])
        if not (curve or np.abs(end - here).max() > NO_LENGTH):
            continue
        lines.append(move["line"])
        tip, angles = rows.tip[mine], rows.angles[mine]
        off, wanted = curve(tip, angles, here, end, move) if curve else on_line(tip, angles, here, end)
        tip_off = max(tip_off, off.max())
        # the sine of the angle between two unit vectors, which is exact for small ones
        sine = np.linalg.norm(np.cross(rows.axis[mine], programmed_axis(wanted)), axis=1)
        axis_off = max(axis_off, np.degrees(np.arcsin(sine)).max())
        rotary_off = max(rotary_off, np.abs(angles[:, 1] - wanted[:, 1]).max())
        if move["feed"] is not None and len(mine) > 1:
            turning = not curve and np.linalg.norm((end - here)[:3]) <= NO_LENGTH
            if turning or (move["feed_mode"] == "inverse" and move["kind"] != "spline"):
                # degrees per minute and inverse time are times: that of the rows of the line, to a cycle
                way = np.linalg.norm((end - here)[slice(3, None) if turning else slice(3)])
                if curve:  # a flat arc
                    way = np.linalg.norm((here[:3] - move["center"])[:2]) * np.radians(abs(move["sweep"]))
                feed = max(feed, float(way) / (cycle * (len(mine) + 1)) / (move["feed"] / 60))
            else:
                moved = np.linalg.norm(np.diff(tip, axis=0), axis=1)
                # 7 decimals of the sliders and 8 of the table move the tip by less than 1e-6 mm from row to row
                feed = max(feed, float(((moved - 1e-6) / cycle).max()) / (move["feed"] / 60))
        here = end
    changes = np.flatnonzero(np.diff(rows.line, prepend=-1))
    gap = float(np.linalg.norm(rows.tip[-1] - here[:3]))
    return Judgement(*ratios, tip_off, axis_off, rotary_off, feed, rows.line[changes].tolist(), lines, gap)


# --- samples that convert ----------------------------------------------------------------------


def work_offset(sample: Path, file: dict[str, Any]) -> list[float]:
    """Where the part sits on the table: from --wcs, or from G10 L2 (in machine coordinates) in the program."""
    given = re.search(r"--wcs G54=(\S+)", " ".join(options(sample)))
    if given:
        values = [float(part) for part in given[1].split(",")]
        return [*values, 0.0][:4]
    found = re.search(r"^(?:N\d+ )?G10 L2 P1 X(\S+) Y(\S+) Z(\S+)", sample.read_text(encoding="utf-8"), re.MULTILINE)
    origin = [float(part) for part in found.groups()] if found else [-zero for zero in file["table"]["machine_zero"]]
    return [o + zero for o, zero in zip(origin, file["table"]["machine_zero"], strict=True)] + [0.0]


def tool_length(sample: Path) -> float:
    """From --tool-length, or the length of tool 1 in --tool-table."""
    arguments = options(sample)
    if "--tool-length" in arguments:
        return float(arguments[arguments.index("--tool-length") + 1])
    table = (ROOT / arguments[arguments.index("--tool-table") + 1]).read_text(encoding="utf-8")
    found = re.search(r"^T1\b.*?Z(\S+)", table, re.MULTILINE)
    assert found
    return float(found[1])


@pytest.fixture
def machine_file() -> dict[str, Any]:
    with (ROOT / "machine_configs" / "verne.toml").open("rb") as file:
        return tomllib.load(file)


@pytest.fixture(autouse=True)
def in_root(monkeypatch: pytest.MonkeyPatch) -> None:
    """The headers name files from the root of the repository."""
    monkeypatch.chdir(ROOT)


#: Tip of the first pose of each sample, as `dump poses` shows it.
FIRST_POSES: dict[Path, list[float]] = {}


@pytest.mark.parametrize("smoothing", ["off", "blend", "spline"])
@named(GOOD)
def test_good_sample(
    sample: Path, smoothing: str, run: Callable[..., Any], machine_file: dict[str, Any], tmp_path: Path
) -> None:
    name, arguments = sample.relative_to(ROOT), [*options(sample), "--smoothing", smoothing]
    answer = run(name, *arguments)
    assert answer.code == 0, answer.err
    out = tmp_path / "axes.csv"
    out.write_text(answer.out, encoding="utf-8", newline="")
    verified = run("verify", out, "--against", name, *arguments)
    assert verified.code == 0, verified.err
    assert verified.out == ""

    moves = [json.loads(line) for line in run("dump", "moves", name, *arguments).out.splitlines()]
    if sample not in FIRST_POSES:  # as programmed, whatever the smoothing
        FIRST_POSES[sample] = json.loads(run("dump", "poses", name, *arguments).out.partition("\n")[0])["tip"]
    rows = Rows.read(answer.out, machine_file, tool_length(sample), work_offset(sample, machine_file))
    assert answer.out.startswith(HEADER + "\n")
    cycle, limits = machine_file["control"]["cycle_s"], machine_file["limits"]
    assert [text.split(",", 1)[0] for text in answer.out.splitlines()[1:]] == [
        f"{k * cycle:.3f}" for k in range(len(rows.t))
    ]
    low, high = limits["rho_mm"]
    assert (rows.q[:, :3] >= low).all()
    assert (rows.q[:, :3] <= high).all()
    assert (np.abs(rows.q[:, 3]) <= limits["a_deg"][1]).all()
    # the file begins where the program does; half a unit of the last decimal moves the tip by less than 1e-6 mm
    assert rows.tip[0] == pytest.approx(FIRST_POSES[sample], abs=1e-6)

    judgement = judged(rows, machine_file, moves)
    if smoothing == "off":
        judgement.acceptable()
        assert 0 < judgement.tip_mm < TIP_MM
    else:  # the tolerance of every sample is the machine file's, said by G64 P or not
        tolerance = machine_file["accuracy"]
        judgement.acceptable(tolerance["tip_mm"], tolerance["axis_deg"])
        assert max(judgement.tip_mm / tolerance["tip_mm"], judgement.axis_deg / tolerance["axis_deg"]) > 0.1
    # a judge that measures nothing accepts everything
    assert judgement.jerk.max() > 0.5
    if "worst ratios are those of rho" in header(sample):
        for ratios in (judgement.velocity, judgement.acceleration, judgement.jerk):
            assert ratios.argmax() < 3
            assert ratios.max() > 0.75  # the sliders do bind


@pytest.mark.parametrize(("row", "column", "shift"), [(300, 1, 0.01), (700, 3, -0.002), (900, 4, 0.01), (-1, 5, 0.01)])
def test_the_independent_check_refuses_a_moved_row(
    run: Callable[..., Any], machine_file: dict[str, Any], row: int, column: int, shift: float
) -> None:
    """The judge above is no rubber stamp."""
    sample = FOLDER / "slider_bound.nc"
    name, arguments = sample.relative_to(ROOT), [*options(sample), "--smoothing", "off"]
    moves = [json.loads(line) for line in run("dump", "moves", name, *arguments).out.splitlines()]
    lines = run(name, *arguments).out.splitlines()
    row = row % (len(lines) - 1)
    cells = lines[row + 1].split(",")
    cells[column] = f"{float(cells[column]) + shift:.8f}"
    lines[row + 1] = ",".join(cells)
    rows = Rows.read("\n".join(lines), machine_file, tool_length(sample), work_offset(sample, machine_file))
    with pytest.raises(AssertionError):
        judged(rows, machine_file, moves).acceptable()


# --- samples that must be refused -----------------------------------------------------------------


@named(REFUSED)
def test_violating_sample(sample: Path, spawn: Callable[..., Any], run: Callable[..., Any]) -> None:
    name, arguments = sample.relative_to(ROOT), options(sample)
    answer = spawn(name, *arguments)
    assert answer.returncode == 1
    assert answer.stdout == b""
    promise = re.search(r"Expected: (.*)\)", header(sample))
    assert promise
    codes = set(re.findall(r"VP\d{3}", promise[1]))
    axes = set(re.findall(r"\brho\d", promise[1]))
    lines = re.search(r"lines? (\d+)(?: (?:and|to) (\d+))?", promise[1])
    assert codes
    assert lines
    checked = run("check", name, *arguments, "--output-format", "json")
    assert checked.code == 1
    findings = json.loads(checked.out)["programs"][0]["findings"]
    assert {item["code"] for item in findings} == codes
    assert min(item["line"] for item in findings) == int(lines[1])
    if lines[2]:
        assert max(item["last_line"] for item in findings) == int(lines[2])
    if axes:
        assert {item["axis"] for item in findings} == axes
    for item in findings:
        text = f"{name}:{item['line']}: {item['code']} error: "
        assert any(line.startswith(text) for line in answer.stderr.decode().splitlines())


# --- all of them ------------------------------------------------------------------------------------


@named(SAMPLES)
def test_header_says_what_to_expect(sample: Path) -> None:
    assert re.search(r"^\(Expected: .+\)$", header(sample), re.MULTILINE)
    assert options(sample)


def test_samples_cover_both_outcomes_and_a_slider_bound() -> None:
    assert len(GOOD) >= 3
    assert REFUSED
    assert any("worst ratios are those of rho" in header(sample) for sample in GOOD)


@pytest.mark.parametrize("sample", CONVERTED, ids=lambda sample: sample.name)
def test_the_least_time_without_jerk_is_that_of_toppra(sample: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    """Where planning starts: two solvers of one problem, one of them not ours. toppra's programs are solved to 1e-6 of
    their scale.
    """
    pytest.importorskip("toppra")
    meta = tmp_path / "meta.json"
    done = run(sample, "--solver", "both", "-o", tmp_path / "rows.csv", "--meta", meta)
    assert done.code == 0, done.err
    said = json.loads(meta.read_text(encoding="utf-8"))
    assert said["second_order_bound_toppra_s"] == pytest.approx(said["second_order_bound_s"], rel=1e-5)
