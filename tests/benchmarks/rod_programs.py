"""Random programs on machines described by their rods, judged by matrices of its own.

python tests/benchmarks/rod_programs.py [--programs 500] [--seed 48] [--machine NAME]

Each program turns the table, then goes straight with constant A and C. The judge reads the TOML alone: unknown are
position and turn of the platform and the sliders, nine numbers; equations are six rods and the tip on the table. It
follows the way in steps by Newton with differences, from home on. Programs within ``BAND`` of a limit are counted
apart.
"""

import argparse
import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

import verne_post

ROOT: Final = Path(__file__).resolve().parents[2]
LENGTH: Final = 80.0
STEPS: Final = 24
#: mm, of travels and drops.
BAND: Final = 3.0


class Judge:
    """The machine of a file."""

    def __init__(self, name: str) -> None:
        data = tomllib.loads((ROOT / f"machine_configs/{name}.toml").read_text())
        module, self.limits = data["module"], data["limits"]
        rods = module["rod"]
        self.a, self.b, self.u = (np.array([rod[key] for rod in rods], float) for key in ("platform", "slider", "rail"))
        self.length = np.array([rod["length"] for rod in rods])
        self.by = np.array([int(rod["by"][-1]) - 1 for rod in rods])
        self.pivot = np.array(data["table"]["pivot"])
        self.home = np.array([*module["home"], 0, 0, 0, *module["home_mm"]], float)

    def rods(self, x: np.ndarray) -> np.ndarray:
        """Vectors along the rods of x = position, turn, sliders."""
        return x[:3] + Rotation.from_rotvec(x[3:6]).apply(self.a) - self.b - x[6:][self.by, None] * self.u

    def misfit(self, x: np.ndarray, tip: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Six rods, and the tip of the tool against its place on the table, whose tilt has that of the platform
        in it.
        """
        table = Rotation.from_euler("zx", [angles[1], angles[0] + x[3]])
        place = self.pivot + table.apply(tip) * [1, -1, -1]
        nose = x[:3] + Rotation.from_rotvec(x[3:6]).apply([0, 0, LENGTH])
        return np.append(np.linalg.norm(self.rods(x), axis=1) - self.length, nose - place)

    def solve(self, x: np.ndarray, tip: np.ndarray, angles: np.ndarray) -> np.ndarray | None:
        """Newton with differences from x on."""
        for _ in range(12):
            value = self.misfit(x, tip, angles)
            if np.abs(value).max() < 1e-9:
                return x
            step = 1e-6 * np.eye(9)
            slope = np.array(
                [(self.misfit(x + d, tip, angles) - self.misfit(x - d, tip, angles)) / 2e-6 for d in step]
            ).T
            try:
                x = x - np.linalg.solve(slope, value)
            except np.linalg.LinAlgError:
                return None
        return None

    def spare(self, x: np.ndarray, angles: np.ndarray) -> float:
        """What is left to the nearest limit: mm; the Jacobian counts 1000 times."""
        rods, low_high = self.rods(x), self.limits["rho_mm"]
        drops = np.abs((rods * self.u).sum(axis=1)) - self.limits["serial_singularity_mm"]
        unit = rods / self.length[:, None]
        arm = Rotation.from_rotvec(x[3:6]).apply(self.a - self.a.mean(axis=0))
        size = np.linalg.norm(arm, axis=1).mean()
        measure = 1 / np.linalg.norm(np.linalg.inv(np.hstack([unit, np.cross(arm, unit) / size])))
        tilt = np.degrees(angles[0] + x[3])
        return float(
            min(
                (x[6:] - low_high[0]).min(),
                (low_high[1] - x[6:]).min(),
                drops.min(),
                95 - abs(tilt),
                1000 * (measure - self.limits["parallel_singularity"]),
            )
        )

    def judge_way(self, points: np.ndarray, angles: np.ndarray) -> float:
        """The least spare along straight lines through points (n, 3), from home led there; -inf where rods do not
        close.
        """
        least, x = np.inf, self.home
        start = np.array([0.0, 0.0, self.pivot[2] - self.home[2] - LENGTH])
        for share in np.linspace(0.1, 1, 10):
            x = x if x is None else self.solve(x, start + share * (points[0] - start), share * angles)
        for begin, end in pairwise(points):
            for share in np.linspace(0, 1, STEPS):
                x = x if x is None else self.solve(x, begin + share * (end - begin), angles)
                if x is None:
                    return -np.inf
                least = min(least, self.spare(x, angles))
        return least


#: Machine files of this kind.
MACHINES: Final = ("verne_by_rods", "urane_sx", "quickstep")


def main() -> None:
    """Print the counts of each kind."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=48)
    parser.add_argument("--machine", choices=MACHINES)
    given = parser.parse_args()
    for name in [given.machine] if given.machine else MACHINES:
        judge, machine, random = Judge(name), verne_post.load_machine(name), np.random.default_rng(given.seed)
        count = dict.fromkeys(("accepted", "refused", "near a limit", "wrongly accepted", "wrongly refused"), 0)
        for _ in range(given.programs):
            angles = np.round(random.uniform([-60, -180], [60, 180]), 2)
            points = np.round(random.uniform([-350, -350, 20], [350, 350, 450], (3, 3)), 2)
            blocks = [f"G0 X{points[0, 0]} Y{points[0, 1]} Z{points[0, 2]} A{angles[0]} C{angles[1]}"]
            blocks += [f"G1 X{x} Y{y} Z{z} F3000" for x, y, z in points[1:]]
            text = "G21 G90\n" + "\n".join(blocks) + "\nM2\n"
            options = verne_post.Options(tool_length=LENGTH, wcs={"G54": (0, 0, 0)})
            ok, spare = verne_post.check(text, machine, options).ok, judge.judge_way(points, np.radians(angles))
            if abs(spare) < BAND:
                verdict = "near a limit"
            elif ok == (spare > 0):
                verdict = "accepted" if ok else "refused"
            else:
                verdict = "wrongly accepted" if ok else "wrongly refused"
                print(text, spare, flush=True)
            count[verdict] += 1
        print(name, count, flush=True)


if __name__ == "__main__":
    main()
