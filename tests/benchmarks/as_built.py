"""The as-built machine: a second formulation on many machines, samples on perturbed machines, speed against the nominal
one.

``python tests/benchmarks/as_built.py [check] [samples] [speed]``; without words all three. Minutes.
"""

import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import verne_post as vp
from verne_post.config import list_machine_files
from verne_post.config.load import build_machine

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "kinematics"))
from six_rods import PIVOT, F, SixRods, as_toml, random_table  # noqa: E402

VERNE = list_machine_files()["verne"].read_text(encoding="utf-8")
TOOL = 100.0
MACHINES, POSES, PERTURBED = 50, 10_000, 10
#: Steps of the central differences of the second formulation, and its Newton steps.
DIFFERENCE, STEPS = 1e-4, 6


def machine_of(table):
    return build_machine((VERNE + as_toml(table)).encode(), "perturbed.toml")


def poses(n):
    """Legal poses of the nominal machine, the corners of the workspace among them."""
    rng = np.random.default_rng(0)
    corners = np.array(
        [
            (x, y, z, a, c)
            for x in (-220, 220)
            for y in (-220, 220)
            for z in (5, 260)
            for a in (-85, 0, 85)
            for c in (-170, 40)
        ],
        float,
    )
    some = rng.uniform([-220, -220, 0, -85, -180], [220, 220, 260, 85, 180], (2 * n, 5))
    every = np.concatenate([corners, some])
    tip, angles = every[:, :3], np.radians(every[:, 3:])
    machine = vp.load_machine("verne")
    q, _platform, ok = machine.five_axis.solve(tip, angles, TOOL)
    ok &= ((q >= machine.limits.lower) & (q <= machine.limits.upper)).all(axis=1)
    return tip[ok][:n], angles[ok][:n], q[ok][:n]


def misses(rods, x, tip, angles):
    """The ten equations of :class:`SixRods` for many poses at once: x (n, 10) -> (n, 10)."""
    rho, joint_a, turn, point = x[:, :3], x[:, 3], Rotation.from_rotvec(x[:, 4:7] * 1e-3), x[:, 7:]
    a, c = angles.T
    ends = point[:, None] + np.stack([turn.apply(np.tile(end, (len(x), 1))) for end in rods.a], axis=1)
    foot = rods.b + np.repeat(rho, 2, axis=1)[..., None] * np.repeat(rods.u, 2, axis=0)
    down = turn.apply(np.tile(rods.spindle, (len(x), 1)))
    ra, rc = (Rotation.from_rotvec(angle[:, None] * axis) for angle, axis in ((joint_a, rods.tilt), (c, rods.rotary)))
    upright = (point + TOOL * down - PIVOT) @ F
    at = rc.inv().apply(ra.inv().apply(upright - rods.oa) + rods.oa - rods.oc)
    axis = rc.inv().apply(ra.inv().apply(-down @ F))
    wanted = np.stack([np.sin(c) * np.sin(a), np.cos(c) * np.sin(a), np.cos(a)], axis=1)
    normal = rc.inv().apply(np.tile(rods.tilt, (len(x), 1)))
    plane = 1e3 * (axis * np.cross(normal, wanted)).sum(axis=1)
    return np.column_stack([np.linalg.norm(ends - foot, axis=2) - rods.length, at - tip, plane])


def solve_all(rods, tip, angles, near):
    """Newton's method with central differences on all ten unknowns."""
    alpha = near[:, 3] - angles[:, 0]
    carried = Rotation.from_rotvec(near[:, 3:4] * [1.0, 0, 0]).apply(
        Rotation.from_rotvec(angles[:, 1:] * [0, 0, 1.0]).apply(tip)
    )
    point = PIVOT + carried @ F - TOOL * np.column_stack([0 * alpha, -np.sin(alpha), np.cos(alpha)])
    x = np.column_stack([near[:, :4], 1e3 * alpha, 0 * alpha, 0 * alpha, point])
    for _ in range(STEPS):
        value = misses(rods, x, tip, angles)
        columns = []
        for k in range(10):
            step = np.zeros(10)
            step[k] = DIFFERENCE * (1e-3 if k == 3 else 1.0)
            columns.append((misses(rods, x + step, tip, angles) - misses(rods, x - step, tip, angles)) / (2 * step[k]))
        x = x - np.linalg.solve(np.stack(columns, axis=2), value[..., None])[..., 0]
    return x


def check():
    """The product's inverse against the ten equations."""
    tip, angles, near = poses(POSES)
    worst = np.zeros(2)
    uncorrected, bend = [], []
    for seed in range(MACHINES):
        table = random_table(seed)
        machine = machine_of(table)
        q, platform, ok = machine.five_axis.solve(tip, angles, TOOL)
        assert ok.all()
        x = solve_all(SixRods(table), tip, angles, near)
        off = np.abs(q[:, :4] - x[:, :4])
        worst = np.maximum(worst, [off[:, :3].max(), off[:, 3].max()])
        uncorrected.append(np.degrees(np.abs(machine.five_axis.measure_axis_error(q, angles, platform))))
        bend.append(np.degrees(np.abs(platform.angles[:, 1:])).max(axis=0))
    left = np.concatenate(uncorrected)
    print(
        f"{MACHINES} machines, {len(tip)} poses: sliders within {worst[0]:.1e} mm, A within {worst[1]:.1e} rad of the "
        "ten equations"
    )
    print(
        f"axis error with C as programmed: median {np.median(left):.3f}, max {left.max():.3f} deg; "
        f"platform turned about y, z by up to {np.max(bend, axis=0).round(3)} deg"
    )


def samples():
    """Every sample converts on perturbed machines; convert verifies what it writes."""
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(PERTURBED):
            path = Path(folder) / "perturbed.toml"
            path.write_text(VERNE + as_toml(random_table(seed)), encoding="utf-8")
            done = []
            for program in sorted((ROOT / "gcode_samples").iterdir()):
                found = re.search(r"\(?options: ([^)\n]*)\)?", program.read_text(encoding="utf-8"))
                if found is None or program.name.startswith("violates") or program.suffix == ".tbl":
                    continue
                words = [
                    str(ROOT / word) if word.startswith("gcode_samples/") else word for word in shlex.split(found[1])
                ]
                if "--machine" in words:
                    continue
                status = run([str(program), *words, "--machine", str(path), "-o", str(Path(folder) / "rows.csv")])
                done.append((program.name, status))
            wrong = [name for name, status in done if status != 0]
            print(
                f"machine {seed}: {len(done) - len(wrong)} of {len(done)} samples converted and verified",
                *wrong,
                flush=True,
            )


def run(words):
    """Exit status of one command."""
    return subprocess.run([sys.executable, "-m", "verne_post", *words], check=False, capture_output=True).returncode


def speed():
    """Poses a second, and CPU of one conversion, each the least of three."""
    tip, angles, _q = poses(40_000)
    for name, machine in (("nominal", vp.load_machine("verne")), ("as built", machine_of(random_table(1)))):
        print(name, *rates(machine.five_axis, tip, angles))
    blade = (ROOT / "gcode_samples" / "blade_5axis.nc").read_bytes()
    options = vp.Options(tool_length=120.0, wcs={"G54": (0, 0, 10)})
    vp.convert(blade, "verne", options)
    times = [
        least(lambda m=m: vp.convert(blade, m, options))
        for m in (vp.load_machine("verne"), machine_of(random_table(1)))
    ]
    print(f"blade_5axis.nc: {times[0]:.3f} s nominal, {times[1]:.3f} s as built, {times[1] / times[0]:.2f} times")


def rates(five, tip, angles):
    """Poses a second of inverse, forward and margins."""
    q, platform, _ok = five.solve(tip, angles, TOOL)
    jobs = {
        "inverse": lambda: five.find_joints(tip, angles, TOOL),
        "forward": lambda: five.find_nominal_pose(q, TOOL),
        "margins": lambda: five.find_geometry_margins(q, angles, platform),
    }
    return [f"{job} {len(tip) / least(work):,.0f} poses/s" for job, work in jobs.items()]


def least(work):
    seconds = []
    for _ in range(3):
        begin = time.process_time()
        work()
        seconds.append(time.process_time() - begin)
    return min(seconds)


if __name__ == "__main__":
    for word in sys.argv[1:] or ("check", "samples", "speed"):
        {"check": check, "samples": samples, "speed": speed}[word]()
