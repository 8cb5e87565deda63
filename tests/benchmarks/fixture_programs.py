"""Random programs against random boxes and meshes: does ``check`` miss a collision that brute force finds?

``python -m tests.benchmarks.fixture_programs [COUNT] [--seed N] [--numpy]``. Half of the programs have three axes, half
five. Brute force takes poses at most 0.4 mm and 0.3 degrees apart and points all over the surface of the fixture, and
refines the deepest pairs of both; and points of the axes of bodies inside the fixture. It shares nothing with the
kernels but the solved poses.
"""

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

import verne_post
from tests.kinematics.test_fixture_meshes import pack_stl, unite_boxes
from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program
from verne_post.base.rotations import rotate_z
from verne_post.config.machine_paths import list_machine_files
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.options import Options
from verne_post.model.part_setup import Box, Cylinder, FixtureMesh
from verne_post.part import bound, sweep

#: Nothing deeper is missed, mm: what bodies may reach into a fixture.
STATED = 0.005
LENGTH = 110.0
SIZES = """
[clearance]
minimum_mm = 0.0
spindle_diameter_mm = 90.0
spindle_top_mm = 200.0
platform_ends_mm = [[0.0, -120.0, -40.0], [0.0, 120.0, -40.0]]
platform_diameter_mm = 80.0
"""


def load_machine(folder: Path) -> Any:
    """The VERNE with sizes for spindle, platform and rods."""
    text = list_machine_files()["verne"].read_text(encoding="utf-8").replace("[provenance]", SIZES + "\n[provenance]")
    assert "[rods]" in text
    text = text.replace("[rods]", "[rods]\ndiameter_mm = 40.0").replace(
        "[provenance]", '[provenance]\nclearance = "assumed"'
    )
    (folder / "machine.toml").write_text(text, encoding="utf-8")
    return verne_post.load_machine(folder / "machine.toml")


def make_program(rng: np.random.Generator, five: bool) -> str:
    lines = ["G21 G90 G94 G43 H1", "G64 P0.05" if rng.random() < 0.5 else "G61.1", "T1 M6"]
    place = rng.uniform([-50, -50, 40], [50, 50, 80])
    tilt = rng.uniform(-25, 25, 2) * [1, 3] if five else np.zeros(2)
    lines.append("G0 X{:.3f} Y{:.3f} Z{:.3f} A{:.3f} C{:.3f}".format(*place, *tilt))
    for _ in range(rng.integers(4, 12)):
        end = np.clip(place + rng.normal(0, [25, 25, 12]), [-60, -60, 25], [60, 60, 90])
        word = "G0" if rng.random() < 0.2 else "G1 F3000"
        text = "{} X{:.3f} Y{:.3f} Z{:.3f}".format(word, *end)
        if five and rng.random() < 0.7:
            tilt = np.clip(tilt + rng.normal(0, [8, 25]), [-30, -170], [30, 170])
            text += " A{:.3f} C{:.3f}".format(*tilt)
        elif rng.random() < 0.2 and np.linalg.norm(end[:2] - place[:2]) > 1:
            text = "G3 F3000 X{:.3f} Y{:.3f} R{:.3f}".format(
                *end[:2], rng.uniform(0.6, 2.0) * np.linalg.norm(end[:2] - place[:2])
            )
            end[2] = place[2]
        place = end
        lines.append(text)
    return "\n".join([*lines, "M2", ""])


def make_shape(rng: np.random.Generator) -> tuple[Cylinder, ...]:
    d = float(rng.choice([2.0, 6.0, 12.0, 20.0]))
    ball = d / 2 if rng.random() < 0.5 else 0.0
    holder = float(rng.uniform(24, 60))
    return (
        Cylinder("cutter", d, 25.0, corner_radius=ball),
        Cylinder("shank", float(rng.uniform(6, 20)), 15.0),
        Cylinder("holder", holder),
    )


def make_fixture(rng: np.random.Generator, near: np.ndarray) -> tuple[Box | FixtureMesh, np.ndarray, Any]:
    """The body, its facets in its own frame, and whether points are inside, by how much (n,)."""
    middle, half = near + rng.normal(0, [30, 30, 35]), rng.uniform(1.5, 25, 3)
    boxes = [(middle - half, middle + half)]
    kind = rng.integers(3)
    if kind == 2:
        points = middle + rng.normal(0, 1, (rng.integers(8, 40), 3)) * half
        hull = ConvexHull(points)
        a, b, c = points[hull.simplices].transpose(1, 0, 2)
        flip = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(1) < 0
        facets = (
            np.stack([a, np.where(flip[:, None], c, b), np.where(flip[:, None], b, c)], axis=1)
            .astype(np.float32)
            .astype(float)
        )
        return (
            FixtureMesh("post", pack_stl(facets)),
            facets,
            lambda x: -(x @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1),
        )
    if kind == 1:
        for _ in range(rng.integers(0, 3)):
            other = middle + rng.uniform(-1, 1, 3) * half
            boxes.append((other - half * rng.uniform(0.3, 1.5, 3), other + half * rng.uniform(0.3, 1.5, 3)))
    boxes = [(low.astype(np.float32).astype(float), high.astype(np.float32).astype(float)) for low, high in boxes]

    def inside(x: np.ndarray) -> np.ndarray:
        return np.max([np.minimum(x - low, high - x).min(axis=1) for low, high in boxes], axis=0)

    facets = unite_boxes([(tuple(low), tuple(high)) for low, high in boxes])
    if kind == 0:
        return Box("post", tuple(boxes[0][0].tolist()), tuple(boxes[0][1].tolist())), facets, inside
    return FixtureMesh("post", pack_stl(facets)), facets, inside


# --- brute force -------------------------------------------------------------------------------------


class Bodies:
    """Cylinders and capsules at poses of one program, in the frame of the fixture; distances by their plainest
    formulas.
    """

    def __init__(
        self, machine: Any, joints: JointPath, shape: tuple[Cylinder, ...], place: np.ndarray, turn: float
    ) -> None:
        self.machine, self.joints, self.shape, self.place, self.turn = machine, joints, shape, place, turn

    def at(self, element: np.ndarray, w: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Ends (n, 3) of the axes of bodies."""
        machine, pose = self.machine, self.joints.place_bodies(element, self.joints.solve(element, w))
        tip, k = pose.tip, pose.axis
        found, low = {}, 0.0
        for one in self.shape:
            high = LENGTH if one.length is None else low + one.length
            found[one.part] = (tip + low * k, tip + high * k)
            low = high
        found["spindle"] = (tip + LENGTH * k, tip + (LENGTH + machine.five_axis.nose_offset + 200.0) * k)
        table = machine.five_axis.carry_to_table
        ends = (np.array([0.0, y, -40.0]) for y in (-120.0, 120.0))
        found["platform"] = tuple(table(pose.platform.position + pose.platform.turn(end), pose.q) for end in ends)
        start, end = machine.clearance.module.find_rod_ends(pose.q[:, :-2], pose.platform)
        for j, leg in enumerate(machine.clearance.module.rod_legs):
            found[f"leg {leg}", j] = (table(start[:, j], pose.q), table(end[:, j], pose.q))
        return {name: tuple(rotate_z(one - self.place, -self.turn) for one in pair) for name, pair in found.items()}

    def measure(self, name: Any, ends: tuple[np.ndarray, np.ndarray], x: np.ndarray) -> np.ndarray:
        """Signed distance of points (..., 3) from a body whose ends broadcast with them."""
        start, end = ends
        along = end - start
        long = np.linalg.norm(along, axis=-1)
        k = along / long[..., None]
        h = ((x - start) * k).sum(-1)
        if name in ("cutter", "shank", "holder"):
            one = next(part for part in self.shape if part.part == name)
            radius, low = 0.5 * one.diameter, one.corner_radius
            r = np.linalg.norm(x - start - h[..., None] * k, axis=-1)
            a, b = r - radius, np.maximum(low - h, h - long)
            cylinder = np.where((a > 0) & (b > 0), np.hypot(a, b), np.maximum(a, b))
            return cylinder if not low else np.minimum(cylinder, np.hypot(r, h - low) - low)
        skin = {"spindle": 45.0, "platform": 40.0}.get(name, 20.0)
        return np.linalg.norm(x - start - np.clip(h, 0, long)[..., None] * k, axis=-1) - skin


def search(
    bodies: Bodies, joints: JointPath, facets: np.ndarray, inside: Any, rng: np.random.Generator
) -> dict[str, float]:
    """The least signed distance that is found, of each body."""
    contour = joints.contour
    parts = np.ceil(np.maximum(contour.length / 0.4, np.degrees(contour.rotation) / 0.3)).astype(int) + 1
    element = np.repeat(np.arange(len(contour)), parts + 1)
    w = np.concatenate([np.linspace(0, 1, n + 1) for n in parts])
    area = 0.5 * np.linalg.norm(np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0]), axis=1)
    facet = np.concatenate([np.repeat(np.arange(len(facets)), 3), rng.choice(len(facets), 900, p=area / area.sum())])
    share = np.concatenate([np.tile(np.eye(3), (len(facets), 1)), rng.dirichlet(np.ones(3), 900)])
    point = np.einsum("nk,nkx->nx", share, facets[facet])
    reach = np.linalg.norm(point - point.mean(axis=0), axis=1).max()
    placed = bodies.at(element, w)
    best: dict[str, float] = {}
    for name, (start, end) in placed.items():
        key = name if isinstance(name, str) else name[0]
        best.setdefault(key, np.inf)
        k = np.clip(((point.mean(axis=0) - start) * (end - start)).sum(1) / ((end - start) ** 2).sum(1), 0, 1)
        near = np.flatnonzero(
            np.linalg.norm(start + k[:, None] * (end - start) - point.mean(axis=0), axis=1) < reach + 60
        )
        pairs = []
        for some in np.array_split(near, len(near) // 500 + 1) if len(near) else ():
            value = bodies.measure(name, (start[some, None], end[some, None]), point[None])
            flat = np.argpartition(value.ravel(), 30)[:30]
            pairs += [(value.ravel()[i], some[i // len(point)], i % len(point)) for i in flat]
            at = start[some, None] + np.linspace(0.001, 0.999, 60)[None, :, None] * (end - start)[some, None]
            depth = inside(at.reshape(-1, 3)).max()
            best[key] = min(best[key], -depth if depth > 0 else np.inf)
        value, row, p = (
            (np.array(one) for one in zip(*(one for one in sorted(pairs)[:30] if one[0] < 5.0), strict=True))
            if pairs and min(pairs)[0] < 5.0
            else ((), (), ())
        )
        if len(value):
            best[key] = min(
                best[key], refine(bodies, name, facets[facet[p]], (value, element[row], w[row], share[p], parts), rng)
            )
    return best


def refine(bodies: Bodies, name: Any, facets: np.ndarray, pairs: Any, rng: np.random.Generator) -> float:
    """The least distance near pairs (n,) of a pose and a place of a facet: random steps that become smaller."""
    value, element, at, share, parts = pairs
    n, tries, step = len(value), 40, 1.0
    for _ in range(14):
        w = np.clip(at[:, None] + step / parts[element][:, None] * rng.normal(0, 1, (n, tries)), 0, 1)
        s = np.abs(share[:, None] + 0.2 * step * rng.normal(0, 1, (n, tries, 3)))
        s /= s.sum(axis=2, keepdims=True)
        ends = bodies.at(np.repeat(element, tries), w.ravel())[name]
        found = bodies.measure(name, ends, np.einsum("ntk,nkx->ntx", s, facets).reshape(-1, 3)).reshape(n, tries)
        i = found.argmin(axis=1)
        better = np.flatnonzero(found[np.arange(n), i] < value)
        value[better], at[better], share[better] = (one[better, i[better]] for one in (found, w, s))
        step *= 0.6
    return float(value.min())


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("count", type=int, nargs="?", default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--numpy", action="store_true", help="without numba")
    asked = parser.parse_args()
    if asked.numpy:
        sweep.load_accelerator = bound.load_accelerator = lambda: None
    with tempfile.TemporaryDirectory() as folder:
        machine = load_machine(Path(folder))
    tally = {
        kind: dict.fromkeys(("programs", "collisions", "reported", "missed", "bodies", "bodies not named"), 0)
        for kind in ("boxes", "meshes")
    }
    worst_missed, worst_false, seconds = 0.0, -np.inf, 0.0
    for k in range(asked.seed, asked.seed + asked.count):
        rng = np.random.default_rng(k)
        source, shape = make_program(rng, bool(k % 2)), make_shape(rng)
        turn = float(rng.choice([0.0, 30.0]))
        given = {"tool_length": LENGTH, "tool_shapes": {1: shape}, "wcs": {"G54": (10.0, -5.0, 0.0, turn)}}
        program = assemble(source.encode(), machine, Options(**given))
        joints = program.build_joint_path()
        along = joints.solve(rng.integers(0, len(program.contour), 1), rng.random(1))
        axis = joints.find_tool_axis(along)[0]
        near = along.tip[0] + axis * rng.choice(
            [0.0, 10.0, 40.0, 80.0, 200.0, 400.0], p=[0.3, 0.2, 0.2, 0.15, 0.1, 0.05]
        )
        place, radians = np.array([10.0, -5.0, 0.0]), np.radians(turn)
        body, facets, inside = make_fixture(rng, rotate_z(near - place, -radians))
        body = type(body)(**{**body.__dict__, "system": 1})
        program = assemble(source.encode(), machine, Options(**given, keep_out=(body,)))
        began = time.process_time()
        told = [item for item in check_program(program)[1] if item.code == "VP215"]
        seconds += time.process_time() - began
        best = search(Bodies(machine, joints, shape, place, radians), joints, facets, inside, rng)
        count = tally["boxes" if isinstance(body, Box) else "meshes"]
        deepest = min(best.values(), default=np.inf)
        count["programs"] += 1
        count["reported"] += bool(told)
        count["collisions"] += int(deepest < -STATED)
        if deepest < -STATED and not told:
            count["missed"] += 1
            worst_missed = min(worst_missed, deepest)
            print(f"program {k}: brute force finds {deepest:.6f}, check nothing")
        if told and deepest > -STATED + 0.01:
            worst_false = max(worst_false, deepest)
            print(f"program {k}: reported {min(item.value for item in told):.6f}, brute force finds {deepest:.6f}")
        for name, value in best.items() if told else ():
            if value < -2 * STATED:
                count["bodies"] += 1
                count["bodies not named"] += not any(f"the {name} " in item.message for item in told)
        if (k + 1) % 20 == 0:
            print(k + 1, tally, f"{seconds:.0f} s of check", flush=True)
    print(tally, f"deepest missed {worst_missed:g}, farthest reported {worst_false:g}, {seconds:.0f} s of check")


if __name__ == "__main__":
    main()
