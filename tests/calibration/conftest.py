"""The VERNE with its as-built kinematics, poses on it, and what an instrument reads there."""

from collections.abc import Callable

import numpy as np
import pytest

import verne_post
from verne_post.calibration.as_built.data import ToolReadings
from verne_post.calibration.as_built.machine_text import take_as_built_route
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.calibration.as_built.workspace import WorkspacePoses, sample_workspace
from verne_post.config import list_machine_files

from .independent import SIGMA, tools


@pytest.fixture(scope="session")
def as_built(machine: verne_post.Machine) -> verne_post.Machine:
    """The VERNE with deviations of zero."""
    return take_as_built_route(machine, list_machine_files()["verne"].read_bytes(), "verne.toml")[0]


@pytest.fixture(scope="session")
def model(as_built: verne_post.Machine) -> AsBuiltModel:
    return AsBuiltModel(as_built.five_axis)


@pytest.fixture(scope="session")
def draw_poses(machine: verne_post.Machine) -> Callable[..., WorkspacePoses]:
    """``draw_poses(40, seed=3)``: legal poses with tools of 60 and 160 mm."""

    def poses(count: int, seed: int = 0) -> WorkspacePoses:
        return sample_workspace(machine, count, (60.0, 160.0), np.random.default_rng(seed))

    return poses


@pytest.fixture(scope="session")
def read_tools() -> Callable[..., ToolReadings]:
    """``read_tools(poses, true, seed=3)``: what an instrument of 3 um reads on a machine with deviations ``true``."""

    def read(
        poses: WorkspacePoses, true: np.ndarray, seed: int, sigma: float = 0.003, axes: float | None = None
    ) -> ToolReadings:
        rng = np.random.default_rng(seed)
        tip, axis = tools(true, poses.joints, poses.length)
        n = len(tip)
        noisy = axis + (axes or 0.0) * rng.standard_normal((n, 3))
        noisy /= np.linalg.norm(noisy, axis=1, keepdims=True)
        return ToolReadings(
            joints=poses.joints,
            length=poses.length,
            tip=tip + sigma * rng.standard_normal((n, 3)),
            axis=noisy if axes else np.full((n, 3), np.nan),
            sigma_tip=np.full(n, sigma),
            sigma_axis=np.full(n, axes or 1e-5),
            station=np.full(n, -1),
            turned=np.zeros(n, dtype=bool),
            line=np.arange(n) + 2,
        )

    return read


@pytest.fixture(scope="session")
def true_machine() -> Callable[[int], np.ndarray]:
    """``true_machine(7)``: deviations of a machine made within the tolerances."""
    return lambda seed: SIGMA * np.random.default_rng([7, seed]).standard_normal(58)
