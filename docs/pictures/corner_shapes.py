"""Draw docs/pictures/corner_shapes.png: the shapes of corner blends at one corner, and the speed at which it is passed.

Run from the repository's root: python docs/pictures/corner_shapes.py (needs the docs extra).
"""

import matplotlib.pyplot as plt
import numpy as np

import verne_post
from verne_post.toolpath.corner_shapes import PEAK, shape_value

TOLERANCE, LENGTH = 0.01, 50.0
ANGLES_DEG = (90, 45, 20)
machine = verne_post.load_machine("serial")


def speeds(angle_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Distance of the tip from a single corner along x, mm, and its speed, mm/s, row by row at F3000."""
    turn = np.radians(angle_deg)
    end = f"G1 X{15 * np.cos(turn):.5f} Y{15 * np.sin(turn):.5f}"
    source = "\n".join([f"G21 G90 G94 G64 P{TOLERANCE} F3000", "G0 X-15 Y0 Z50", "G1 X0", end, "M2\n"]).encode()
    result = verne_post.convert(source, machine, verne_post.Options(tool_length=LENGTH))
    assert result.setpoints is not None
    joints = result.setpoints.values / [column.factor for column in machine.columns]
    tip, _angles, _ok = machine.five_axis.find_nominal_pose(joints, np.full(len(joints), LENGTH))
    step = np.linalg.norm(np.diff(tip, axis=0), axis=1)
    s = np.concatenate([[0.0], np.cumsum(step)])
    corner = s[np.argmin(np.linalg.norm(tip - [0.0, 0.0, 50.0], axis=1))]
    return 0.5 * (s[1:] + s[:-1]) - corner, step / machine.cycle


figure, (shapes, passed) = plt.subplots(1, 2, figsize=(11, 4.2), constrained_layout=True)
colors = plt.get_cmap("viridis")(np.linspace(0, 0.9, len(PEAK)))
s = np.linspace(-0.65, 0.65, 2001)
for number, color in enumerate(colors):
    reach = TOLERANCE / PEAK[number]  # of a corner of 90 degrees: its bend has a part of 1 across each move
    off = reach * shape_value(np.full(len(s), number), s / reach)
    shapes.plot(s, 1e3 * off, color=color, linewidth=1.3, label=f"shape {number}: reach {reach:.2f} mm")
for bound in (-10.0, 10.0):
    shapes.axhline(bound, color="k", linestyle="--", linewidth=0.9)
shapes.axhline(0.0, color="0.55", linewidth=1.0)
shapes.set(
    xlabel="distance from the corner along the path, mm",
    ylabel="distance from the programmed path, um",
    title="a corner of 90 degrees within 0.01 mm; above 0 is inside",
)
shapes.legend(fontsize="x-small", loc="lower center", ncols=2)
shapes.set_ylim(-20, 12)
for angle_deg, color in zip(ANGLES_DEG, ("tab:blue", "tab:orange", "tab:green"), strict=True):
    passed.plot(*speeds(angle_deg), ".-", color=color, markersize=3, linewidth=1.0, label=f"{angle_deg} degrees")
passed.axhline(50.0, color="k", linestyle="--", linewidth=0.9, label="programmed feed")
passed.set(
    xlim=(-2, 2),
    ylim=(0, 56),
    xlabel="distance from the corner, mm",
    ylabel="tip speed, mm/s",
    title="single corners at F3000, serial.toml, a point every millisecond",
)
passed.legend(fontsize="small", loc="lower right")
figure.savefig("docs/pictures/corner_shapes.png", dpi=110)
