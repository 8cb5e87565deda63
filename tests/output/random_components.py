"""Exported kinematics of random machines, C against Python.

``python -m tests.output.random_components [COUNT] [SEED]``. A machine is verne, linear_delta or serial. All lengths of
its module are up to 3 % off, pivot, zero and nose stand somewhere else, and the senses of A and C are drawn. Every
second verne has 58 deviations as built. Each is compiled, and solves 2,000 random poses both ways, with both solvers.
"""

import random
import re
import sys
import tempfile
from pathlib import Path
from typing import Final

import numpy as np

from tests.kinematics.six_rods import as_toml, random_table
from tests.output.test_machine_export import KINDS, ROOT, SHARE, SIZE, SOLVERS, Compiled, draw_poses
from verne_post.config.load import build_machine
from verne_post.model.findings import InputError

POSES: Final = 2000
#: Lengths of a module are off by up to this share.
OFF: Final = 0.03


def draw_text(rng: random.Random, kind: str) -> str:
    """A machine file with other lengths, places and senses."""
    text = (ROOT / "machine_configs" / f"{kind}.toml").read_text(encoding="utf-8")
    begin, end = text.index("[module]"), text.index("[spindle]")

    def change(found: re.Match[str]) -> str:
        return f"{found[1]}{float(found[2]) * (1 + rng.uniform(-OFF, OFF)):.4f}"

    module = re.sub(r"(?m)(^\w+ *= *)(-?\d+\.\d+)", change, text[begin:end])
    text = text[:begin] + module + text[end:]
    places = {
        "nose_offset_mm": f"{rng.uniform(0, 60):.3f}",
        "pivot": f"[{rng.uniform(-20, 20):.3f}, {rng.uniform(-20, 20):.3f}, {rng.uniform(1570, 1630):.3f}]",
        "rotary_offset": str([round(rng.uniform(-20, 20), 3) for _ in range(3)]),
        "machine_zero": f"[{rng.uniform(-5, 5):.3f}, {rng.uniform(-5, 5):.3f}, {rng.uniform(480, 600):.3f}]",
        "a_positive": f'"{rng.choice(("workpiece", "tool"))}"',
        "c_positive": f'"{rng.choice(("workpiece", "tool"))}"',
    }
    for key, value in places.items():
        text, changed = re.subn(rf"(?m)^{key} = [^#\n]*", f"{key} = {value} ", text)
        assert changed == 1, key
    if kind == "verne" and rng.random() < 0.5:
        text += as_toml(random_table(rng.randrange(1 << 30), mm=0.5, mrad=1.0))
    return text


def try_machine(seed: int) -> tuple[int, str]:
    """Poses that were reached and compared, and what is wrong; -1 for a machine that cannot be."""
    rng = random.Random(seed)
    try:
        machine = build_machine(draw_text(rng, KINDS[seed % len(KINDS)]).encode(), "drawn.toml")
    except InputError:
        return -1, ""
    with tempfile.TemporaryDirectory() as folder:
        compiled = Compiled(machine, Path(folder))
    poses = draw_poses(machine, POSES, 250.0)
    which, worst = poses.reached, 0.0
    world, tool, joints = poses.world[which], poses.tool[which], poses.joints[which]
    for solver in SOLVERS.values():
        for function, given, wanted in (("inverse_rows", world, joints), ("forward_rows", joints, world)):
            found, ok = compiled.solve(function, given, tool, solver)
            off = np.abs(found - wanted) / np.maximum(SIZE, np.abs(wanted))
            worst = max(worst, float(off.max(initial=0.0))) if ok.all() else np.inf
    return len(world), "" if worst <= SHARE else f"{KINDS[seed % len(KINDS)]}: off by {worst:.2g} of a length"


def main() -> int:
    """Try so many machines."""
    count, first = ([int(word) for word in sys.argv[1:]] + [30, 0][len(sys.argv) - 1 :])[:2]
    compared = refused = wrong = 0
    for seed in range(first, first + count):
        poses, said = try_machine(seed)
        refused, compared, wrong = refused + (poses < 0), compared + max(poses, 0), wrong + bool(said)
        sys.stdout.write(f"seed {seed}, {said}\n" if said else "")
        sys.stdout.flush()
    sys.stdout.write(
        f"{count} machines from {first} on, {refused} refused: {compared} poses compared, {wrong} machines wrong\n"
    )
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
