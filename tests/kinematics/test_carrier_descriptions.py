"""What cannot depend on how a machine with a carrier is described: directions of the base, home, and the order of rods
and struts.
"""

import tomllib
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.kinematics.test_chain import ROOT, random_axes
from verne_post.config.load import build_machine
from verne_post.model.machine import Machine

LENGTH = 90.0
#: Keys whose three numbers are a place or a direction of the base; the places on the platform turn along.
VECTORS = frozenset(
    {"gauge", "axis", "part_zero", "up", "home", "platform", "base", "slider", "rail", "first_axis", "turns", "through"}
)


def read(name: str) -> dict[str, Any]:
    return tomllib.loads((ROOT / f"machine_configs/{name}.toml").read_text(encoding="utf-8"))


def show(value: Any) -> str:
    """A value of TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {show(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list | np.ndarray):
        return "[" + ", ".join(show(one) for one in value) + "]"
    return f'"{value}"' if isinstance(value, str) else repr(float(value)) if isinstance(value, float) else str(value)


def build(data: dict[str, Any]) -> Machine:
    return build_machine("".join(f"{key} = {show(value)}\n" for key, value in data.items()).encode(), "mine.toml")


def turned(data: Any, turn: np.ndarray, key: str = "") -> Any:
    """The same data with every place and direction of the base turned."""
    if isinstance(data, dict):
        return {name: turned(one, turn, name) for name, one in data.items()}
    if isinstance(data, list):
        if key in VECTORS and len(data) == 3 and not isinstance(data[0], dict | list):
            return [float(value) for value in turn @ np.array(data, dtype=float)]
        return [turned(one, turn) for one in data]
    return data


def find_part_frame(data: dict[str, Any]) -> np.ndarray:
    """Columns: x, y, z of the part in the base; x is that of the base, across z."""
    z = np.array(data["chain"]["up"], dtype=float)
    x = np.array([1.0, 0.0, 0.0]) - z[0] * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def draw_poses() -> tuple[np.ndarray, np.ndarray]:
    axis = random_axes(900)
    axis = axis[axis[:, 2] > 0.4][:150]
    return np.random.default_rng(8).uniform([-180, -180, 0], [180, 180, 120], axis.shape), axis


@pytest.mark.parametrize("name", ["george_v", "tricept"])
def test_directions_of_the_base_do_not_matter(name: str) -> None:
    """The whole file in another base: the same poses of the part have the same joints."""
    data = read(name)
    home = data.pop("home")  # machine coordinates: no places of the base
    del data["provenance"]["home"]
    assert len(home) == 2
    turn = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
    other = turned(data, turn)
    to_other = find_part_frame(other).T @ turn @ find_part_frame(data)
    tip, axis = draw_poses()
    joints, ok = build(data).inverse(tip, axis, LENGTH)
    again, found = build(other).inverse(tip @ to_other.T, axis @ to_other.T, LENGTH)
    assert ok.all()
    assert found.all()
    assert np.abs(joints[:, :3] - again[:, :3]).max() < 1e-6  # files give nine digits
    # nominal A and C are those of the part's frame, and so is the turn of C that is nearest to them
    apart = (joints - again)[:, 3:]
    assert np.abs(apart - 2 * np.pi * np.round(apart / (2 * np.pi))).max() < 1e-8


def test_home_does_not_matter_where_the_carrier_never_turns() -> None:
    """Another place of the same mechanism as home, with all that the platform carries."""
    data, shift = read("george_v"), np.array([60.0, -40.0, 70.0])
    other = read("george_v")
    other["carrier"]["home"] = [float(value) for value in np.array(data["carrier"]["home"]) + shift]
    other["chain"]["gauge"] = [float(value) for value in np.array(data["chain"]["gauge"]) + shift]
    for joint in ("a", "c"):
        other["joints"][joint]["through"] = [
            float(value) for value in np.array(data["joints"][joint]["through"]) + shift
        ]
    del other["carrier"]["base_cone_deg"]  # counted from home
    tip, axis = draw_poses()
    assert np.abs(build(data).inverse(tip, axis, LENGTH)[0] - build(other).inverse(tip, axis, LENGTH)[0]).max() < 1e-9


@pytest.mark.parametrize(("name", "key"), [("george_v", "rods"), ("tricept", "struts")])
def test_the_order_of_rods_and_joints_does_not_matter(name: str, key: str) -> None:
    data, other = read(name), read(name)
    other["carrier"]["actuators"] = list(reversed(data["carrier"]["actuators"]))
    other["carrier"][key] = list(reversed(data["carrier"][key]))
    if "home_actuators_mm" in data["carrier"]:
        other["carrier"]["home_actuators_mm"] = list(reversed(data["carrier"]["home_actuators_mm"]))
    first, second = build(data), build(other)
    assert [column.joint for column in second.columns[:3]] == [column.joint for column in first.columns[2::-1]]
    tip, axis = draw_poses()
    joints, again = (machine.inverse(tip, axis, LENGTH)[0] for machine in (first, second))
    assert np.abs(joints[:, [2, 1, 0, 3, 4]] - again).max() < 1e-9
