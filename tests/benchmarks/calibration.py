"""What a calibration of the machine as built is worth: `python tests/benchmarks/calibration.py [machines]`.

Simulated machines, parts off by 0.05 mm and 0.1 mrad at random; readings of 3 um (axes 20 urad) with tools of 60 and
160 mm; tip errors at 1000 other poses. The tables stand in docs/as-built.md.
"""

import sys

import numpy as np
from msgspec.structs import replace

import verne_post
from verne_post.calibration.as_built.calibrate import DETERMINED
from verne_post.calibration.as_built.data import ToolReadings, build_prior_of_manufacture, build_tolerance_vector
from verne_post.calibration.as_built.equations import Measurement
from verne_post.calibration.as_built.fit import fit_robustly
from verne_post.calibration.as_built.machine_text import take_as_built_route
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.calibration.as_built.perturb import draw_deviations
from verne_post.calibration.as_built.plan import plan_poses
from verne_post.calibration.as_built.prediction import compute_tool_errors, find_quantiles
from verne_post.calibration.as_built.workspace import WorkspacePoses, sample_workspace
from verne_post.config import list_machine_files
from verne_post.model.deviations import Deviations

MACHINES = int(sys.argv[1]) if len(sys.argv) > 1 else 20
SIGMA, SIGMA_AXIS, TOOLS = 0.003, 2e-5, (60.0, 160.0)
TOLERANCES = build_tolerance_vector()
PRIOR = build_prior_of_manufacture(TOLERANCES)

nominal = verne_post.load_machine()
machine, as_built = take_as_built_route(nominal, list_machine_files()["verne"].read_bytes(), "verne.toml")
model = AsBuiltModel(as_built)
held = sample_workspace(machine, 1000, TOOLS, np.random.default_rng(1))
machines = [draw_deviations(seed, TOLERANCES).pack_vector() for seed in range(MACHINES)]


def read(poses: WorkspacePoses, true: np.ndarray, rng: np.random.Generator, axes: bool) -> ToolReadings:
    """Readings with noise."""
    at, n = model.predict(true, poses.joints, poses.length), len(poses.length)
    axis = at.axis + SIGMA_AXIS * rng.standard_normal((n, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    return ToolReadings(
        poses.joints,
        poses.length,
        at.tip + SIGMA * rng.standard_normal((n, 3)),
        axis if axes else np.full((n, 3), np.nan),
        np.full(n, SIGMA),
        np.full(n, SIGMA_AXIS),
        np.full(n, -1),
        np.zeros(n, dtype=bool),
        np.arange(n),
    )


def row(name: str, tips: list[np.ndarray], axes: list[np.ndarray], determined: str = "") -> None:
    """One line of a table: quantiles of all poses of all machines, and the worst machine's median."""
    tip, axis = (find_quantiles(np.concatenate(values)) for values in (tips, axes))
    worst = max(np.median(values) for values in tips)
    print(
        f"| {name} | {determined} | {1e3 * tip[0]:.1f}, {1e3 * tip[1]:.1f}, {1e3 * tip[2]:.1f} | {1e3 * worst:.1f} "
        f"| {np.degrees(axis[0]):.4f}, {np.degrees(axis[2]):.4f} |"
    )


def left_by_models() -> None:
    """The ideal model, and the true deviations, with C as programmed and corrected."""
    for name in ("ideal", "as built, C as programmed", "as built, C corrected too"):
        tips, axes = [], []
        for true in machines:
            own = as_built.replace_deviations(Deviations.build_from_vector(true))
            five_axis = {"ideal": nominal.five_axis, "as built, C as programmed": own}.get(
                name, own.switch_correction(on=True)
            )
            errors = compute_tool_errors(model, true, five_axis.find_joints(held.tip, held.angles, held.length), held)
            tips.append(errors.tip)
            axes.append(errors.axis)
        row(name, tips, axes)


def left_by_readings() -> None:
    """Machines calibrated from random and from planned poses."""
    plan = plan_poses(machine, model, PRIOR, TOOLS, 40, SIGMA).poses
    for name, count, axes, planned in (
        ("40 random poses, tips", 40, False, False),
        ("40 planned poses, tips", 40, False, True),
        ("150 random poses, tips", 150, False, False),
        ("150 random poses, tips and axes", 150, True, False),
    ):
        tips, directions, known = [], [], []
        for seed, true in enumerate(machines):
            rng = np.random.default_rng([3, seed])
            poses = plan if planned else sample_workspace(machine, count, TOOLS, rng)
            found, kept, _bad = fit_robustly(Measurement(model, read(poses, true, rng, axes)), PRIOR)
            assert found.converged
            assert kept.all()
            one, other = (model.predict(v, held.joints, held.length) for v in (found.deviations, true))
            tips.append(np.linalg.norm(one.tip - other.tip, axis=1))
            directions.append(np.linalg.norm(one.axis - other.axis, axis=1))
            shares = np.linalg.eigvalsh(found.covariance / np.outer(TOLERANCES, TOLERANCES))
            known.append(int((np.sqrt(shares) < DETERMINED).sum()))
        row(name, tips, directions, f"{np.mean(known):.0f}")


def bad_readings() -> None:
    """How many readings off by 1 mm are found and left out, and nothing else."""
    found = 0
    for seed, true in enumerate(machines):
        rng = np.random.default_rng([4, seed])
        readings = read(sample_workspace(machine, 40, TOOLS, rng), true, rng, axes=False)
        tip, at = np.array(readings.tip), (int(rng.integers(40)), int(rng.integers(3)))
        tip[at] += 1.0
        kept = fit_robustly(Measurement(model, replace(readings, tip=tip)), PRIOR)[1]
        found += np.flatnonzero(~kept).tolist() == [at[0]]
    print(f"a reading of 40 off by 1 mm, found and no other left out: {found} of {len(machines)} machines")


if __name__ == "__main__":
    print(f"{MACHINES} machines; tip um: median, 95 %, max of all; worst machine's median; axis deg: median, max")
    left_by_models()
    left_by_readings()
    bad_readings()
