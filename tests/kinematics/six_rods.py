"""The as-built VERNE written down a second time, from the equations alone: for tests, without a line of the product.

Rotations by scipy, no elimination, derivatives by differences. mm, rad; base frame with z down, upright frame with z
up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

#: Nominal VERNE: rods I at +y, I at -y, II at larger x, at smaller x, III at larger x, at smaller x.
D1, D2, SPACING = 480.0, -400.0, 120.0
SLIDERS = np.array(
    [[D1, 80, 0], [D1, -80, 0], [D2 + 60, -565, 0], [D2 - 60, -565, 0], [D2 + 60, 565, 0], [D2 - 60, 565, 0]], float
)
PLATFORM = np.array(
    [[D1 - 320, 130, 0], [D1 - 320, -130, 0], [D2 + 300, -190, 0], [D2 + 180, -190, 0], [D2 + 300, 190, 0],
     [D2 + 180, 190, 0]], float,
)  # fmt: skip
LENGTHS = np.array([850.0, 850, 950, 950, 950, 950])
PIVOT = np.array([0.0, 0.0, 1600.0])
F = np.diag([1.0, -1.0, -1.0])


@dataclass
class SixRods:
    """A machine with the deviations of an [as_built] table: a dictionary of its keys, mm and mrad."""

    table: dict[str, list]

    def entry(self, key, shape):
        return np.array(self.table.get(key, np.zeros(shape)), dtype=float).reshape(shape)

    def __post_init__(self):
        unit = lambda *v: np.array(v) / math.sqrt(sum(x * x for x in v))  # noqa: E731
        self.a = PLATFORM + self.entry("platform_ends_mm", (6, 3))
        self.b = SLIDERS + self.entry("slider_ends_mm", (6, 3))
        self.length = LENGTHS + self.entry("rod_lengths_mm", (6,))
        g = 1e-3 * self.entry("guides_mrad", (3, 2))
        self.u = np.array([unit(x, y, 1.0) for x, y in g])
        t, td = self.entry("tilt_axis_mm", (2,)), 1e-3 * self.entry("tilt_axis_mrad", (2,))
        r, rd = self.entry("rotary_axis_mm", (2,)), 1e-3 * self.entry("rotary_axis_mrad", (2,))
        s = 1e-3 * self.entry("spindle_axis_mrad", (2,))
        self.oa, self.tilt = np.array([0.0, *t]), unit(1.0, *td)
        self.oc, self.rotary = np.array([*r, 0.0]), unit(*rd, 1.0)
        self.spindle = unit(*s, 1.0)

    def rods(self, rho, turn, point):
        """Lengths of the six rods minus what they should be."""
        ends = point + Rotation.from_rotvec(turn).apply(self.a)
        foot = self.b + np.repeat(rho, 2)[:, None] * np.repeat(self.u, 2, axis=0)
        return np.linalg.norm(ends - foot, axis=1) - self.length

    def tool(self, turn, point, a, c, tool):
        """Tip and axis (tip to spindle) in the table frame."""
        down = Rotation.from_rotvec(turn).apply(self.spindle)
        tip = F @ (point + tool * down - PIVOT)
        ra, rc = (Rotation.from_rotvec(angle * axis) for angle, axis in ((a, self.tilt), (c, self.rotary)))
        on_tilt = ra.inv().apply(tip - self.oa) + self.oa
        return rc.inv().apply(on_tilt - self.oc), rc.inv().apply(ra.inv().apply(-F @ down))

    def inverse(self, tip, a, c, tool, start):
        """Joints for a programmed tip, A and C, C as programmed: ten unknowns, ten equations.

        Six rods, the tip, and the axis in one plane with the programmed one and the tilt axis. ``start`` are joints
        near them.
        """
        wanted = np.array([math.sin(c) * math.sin(a), math.cos(c) * math.sin(a), math.cos(a)])

        def equations(x):
            rho, joint_a, turn, point = x[:3], x[3], x[4:7] * 1e-3, x[7:]
            at, axis = self.tool(turn, point, joint_a, c, tool)
            normal = Rotation.from_rotvec(-c * self.rotary).apply(self.tilt)  # the tilt axis on the table
            return np.concatenate([self.rods(rho, turn, point), at - tip, [1e3 * axis @ np.cross(normal, wanted)]])

        alpha = start[3] - a
        point = PIVOT + F @ Rotation.from_rotvec([start[3], 0, 0]).apply(Rotation.from_rotvec([0, 0, c]).apply(tip))
        point = point - tool * np.array([0, -math.sin(alpha), math.cos(alpha)])
        x0 = np.concatenate([start[:4], [1e3 * alpha, 0, 0], point])
        found = least_squares(equations, x0, xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale=1.0, method="lm")
        assert np.abs(found.fun).max() < 1e-9
        return np.array([*found.x[:4], c])


def random_table(seed, mm=0.05, mrad=0.1):
    """Deviations of all 58 entries."""
    rng = np.random.default_rng(seed)
    shapes = {
        "platform_ends_mm": (6, 3),
        "slider_ends_mm": (6, 3),
        "rod_lengths_mm": (6,),
        "guides_mrad": (3, 2),
        "tilt_axis_mm": (2,),
        "tilt_axis_mrad": (2,),
        "rotary_axis_mm": (2,),
        "rotary_axis_mrad": (2,),
        "spindle_axis_mrad": (2,),
    }
    return {
        key: ((mrad if "mrad" in key else mm) * rng.standard_normal(shape)).tolist() for key, shape in shapes.items()
    }


def as_toml(table, source="made for a test"):
    """The [as_built] table as text."""
    return "\n".join(
        ["", "[as_built]", f'source = "{source}"', *(f"{key} = {value}" for key, value in table.items()), ""]
    )
