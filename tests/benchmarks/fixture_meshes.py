"""How long a fixture of 20,000 facets takes beside a program of 45,000 lines: clear, grazed, and with a holder deep in
them.

``python -m tests.benchmarks.fixture_meshes [--five] [--numpy] [--lines N]`` prints CPU seconds of the check of the mesh
alone, findings and the deepest place. The first call of the compiled code is not counted.
"""

import argparse
import time

import numpy as np

import verne_post
from gcode_samples.make_vise_sample import pack_stl
from verne_post.app.assemble import assemble
from verne_post.app.constraints import guard_joints
from verne_post.kinematics.checks.clearance import build_clearance_checks
from verne_post.kinematics.checks.mesh_contacts import check_meshes
from verne_post.model.options import Options
from verne_post.model.part_setup import Cylinder, FixtureMesh
from verne_post.part import bound, sweep

SHAPE = (Cylinder("cutter", 10.0, 25.0), Cylinder("shank", 10.0, 15.0), Cylinder("holder", 40.0))
PASSES, PITCH = 150, 0.5
#: How far the holder's side is from the jaw at the last pass, mm.
CASES = {"clear": 1.0, "grazed": -0.02, "deep": -30.0}
#: By how much a holder that leans by 3 degrees is nearer to the jaw's upper edge, mm.
LEANING = 4.2


def make_program(lines: int, five: bool) -> str:
    """A raster over 60 x 75 mm; the holder's lower edge is at Z 50 of the work system."""
    n = lines // PASSES
    text = ["G21 G90 G94 G43 H1", "G64 P0.01", "T1 M6", "G0 X-30 Y0 Z10 A0 C0"]
    for k in range(PASSES):
        share = np.linspace(0.0, 1.0, n) if k % 2 == 0 else np.linspace(1.0, 0.0, n)
        x, y = 60.0 * share - 30.0, PITCH * k
        z = 10.0 + np.sin(x / 9.0)
        tilt = 3.0 * np.sin(x / 11.0) if five else 0.0 * x
        for one, height, a in zip(x, z, tilt, strict=True):
            text.append(f"G1 X{one:.3f} Y{y:.3f} Z{height:.4f}" + (f" A{a:.3f}" if five else "") + " F3000")
    return "\n".join([*text, "M2", ""])


def make_jaw(gap: float) -> bytes:
    """A wavy wall of 20,000 facets beside the last pass, as high as the holder."""
    front = PASSES * PITCH - PITCH + 20.0 + gap
    x, z = np.meshgrid(np.linspace(-60, 60, 101), np.linspace(-20, 90, 51), indexing="ij")
    wave = 0.5 - 0.5 * np.cos(x / 4.0) * np.cos(z / 5.0)
    near, far = np.stack([x, front + wave, z], axis=-1), np.stack([x, np.full_like(x, front + 30.0), z], axis=-1)

    def sheet(p: np.ndarray) -> np.ndarray:
        a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
        return np.concatenate([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)]).reshape(-1, 3, 3)

    edges = [(near[:, 0], far[:, 0]), (far[:, -1], near[:, -1]), (far[0], near[0]), (near[-1], far[-1])]
    walls = [sheet(np.stack([upper, lower], axis=1)) for upper, lower in edges]
    return pack_stl(np.concatenate([sheet(near), sheet(far)[:, ::-1], *(one[:, ::-1] for one in walls)]))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--five", action="store_true", help="with tilting")
    parser.add_argument("--numpy", action="store_true", help="without numba")
    parser.add_argument("--lines", type=int, default=45_000)
    parser.add_argument("--only", choices=list(CASES))
    asked = parser.parse_args()
    if asked.numpy:
        sweep.load_accelerator = bound.load_accelerator = lambda: None
    machine = verne_post.load_machine()
    source = make_program(asked.lines, asked.five).encode()
    for name, gap in CASES.items():
        if asked.only not in (None, name):
            continue
        jaw = FixtureMesh("jaw", make_jaw(gap + LEANING * asked.five), system=1)
        options = Options(tool_length=110.0, tool_shapes={1: SHAPE}, wcs={"G54": (0.0, -40.0, 30.0)}, keep_out=(jaw,))
        program = assemble(source, machine, options)
        joints = guard_joints(program)
        keep_out = joints.keep_out.select("mesh")
        seconds = []
        for _ in range(2):
            began = time.process_time()
            found = check_meshes(joints, keep_out, build_clearance_checks(keep_out, 0))
            seconds.append(time.process_time() - began)
        deepest = min((item.value for item in found), default=float("nan"))
        facets = len(keep_out.obstacles[0].mesh.facets)
        print(
            f"{name}: {len(joints.contour)} elements, {facets} facets: {seconds[0]:.2f} s, then {seconds[1]:.2f}; "
            f"{len(found)} findings, deepest {deepest:.3f} mm",
            flush=True,
        )


if __name__ == "__main__":
    main()
