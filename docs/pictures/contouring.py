"""Draw docs/pictures/contouring.png: one rounded corner with its rows, and a zigzag against the limits.

Run from the repository's root: python docs/pictures/contouring.py (needs the docs extra).
"""

import matplotlib.pyplot as plt
import numpy as np

import verne_post

LENGTH, TOLERANCE = 50.0, 0.01
machine = verne_post.load_machine()
CORNERS_DEG = (30, 10)


def zigzag(corner_deg: float, moves: int) -> tuple[bytes, np.ndarray]:
    """Moves of 1 mm that turn left and right by an angle, and their corners in mm."""
    half, k = np.radians(corner_deg) / 2, np.arange(moves + 1)
    corner = np.stack([np.cos(half) * k, np.sin(half) * (k % 2)], axis=1)
    lines = [f"G1 X{x:.5f} Y{y:.5f}" for x, y in corner[1:]]
    head = f"G21 G90 G94 G64 P{TOLERANCE}\nG0 X0 Y0 Z60 A0 C0\nF3000\n"
    return "\n".join([head, *lines, "M2\n"]).encode(), corner


def rows(source: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, joint values in file units, and tips on the table of every row."""
    result = verne_post.convert(source, machine, verne_post.Options(tool_length=LENGTH))
    assert result.setpoints is not None
    q = result.setpoints.values
    joints = q / [column.factor for column in machine.columns]
    tip, _angles, _ok = machine.five_axis.find_nominal_pose(joints, np.full(len(q), LENGTH))
    return result.setpoints.t, q, tip


figure = plt.figure(figsize=(11, 5.6), constrained_layout=True)
grid = figure.add_gridspec(3, 2, width_ratios=[1.0, 1.35])
near = figure.add_subplot(grid[:, 0])
panels = [figure.add_subplot(grid[row, 1]) for row in range(3)]
size = np.abs([column.factor for column in machine.columns])
limits = (machine.limits.acceleration * size, machine.limits.jerk * size)

for corner_deg, color in zip(CORNERS_DEG, ("tab:blue", "tab:orange"), strict=True):
    source, corner = zigzag(corner_deg, 10)
    t, q, tip = rows(source)
    at = corner[5]
    shifted = tip[:, :2] - at
    shown = np.abs(shifted[:, 0]) < 0.33
    near.plot(
        *(corner[4:7] - at).T, color="0.55", linewidth=1.0, label="programmed" if corner_deg == CORNERS_DEG[0] else None
    )
    near.plot(
        *shifted[shown].T, ".-", color=color, markersize=6, linewidth=1.2, label=f"{corner_deg} deg: rows, 1 ms apart"
    )
    speed = np.linalg.norm(np.diff(tip, axis=0), axis=1) / machine.cycle
    panels[0].plot(t[1:], speed, color=color, linewidth=1.1, label=f"{corner_deg} deg corners")
    for panel, order, limit in zip(panels[1:], (2, 3), limits, strict=True):
        share = np.abs(np.diff(q, n=order, axis=0) / machine.cycle**order / limit).max(axis=1)
        panel.plot(t[order:], share, color=color, linewidth=1.1)

around = np.linspace(0, 2 * np.pi, 200)
near.plot(
    TOLERANCE * np.cos(around), TOLERANCE * np.sin(around), "k--", linewidth=0.9, label=f"tolerance {TOLERANCE} mm"
)
near.set(
    xlim=(-0.3, 0.3),
    ylim=(-0.082, 0.02),
    xlabel="x mm",
    ylabel="y mm (stretched)",
    title="two corners, rounded within 0.01 mm",
)
near.legend(loc="lower center", fontsize="small")
for panel, bound, text in zip(
    panels, (50.0, 1.0, 1.0), ("tip speed mm/s", "acceleration / limit", "jerk / limit"), strict=True
):
    panel.axhline(bound, color="k", linestyle="--", linewidth=0.9, label="programmed feed, limit")
    panel.set(ylabel=text, ylim=(0, 1.18 * bound), xlim=(0, None))
panels[0].set_title("zigzags of 10 moves of 1 mm, F3000: the joint nearest to its limit")
panels[0].set_ylim(0, 80)
panels[0].legend(loc="upper right", fontsize="small", ncols=3)
panels[2].set_xlabel("time s")
figure.savefig("docs/pictures/contouring.png", dpi=110)
