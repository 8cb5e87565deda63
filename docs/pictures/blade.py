"""Draw the picture of the README: the blade sample as programmed, and what the machine does for it.

Run from the repository's root: python docs/pictures/blade.py (needs the docs extra).
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import verne_post
from verne_post.app.assemble import assemble
from verne_post.base.rotations import find_axis_of_angles
from verne_post.model.part_setup import WorkOffset

SAMPLE = Path("gcode_samples/blade_5axis.nc")
OPTIONS = verne_post.Options(tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 10.0))}, source_name=SAMPLE.name)

machine = verne_post.load_machine()
source = SAMPLE.read_bytes()
path = assemble(source, machine, OPTIONS).path
result = verne_post.convert(source, machine, OPTIONS)
assert result.setpoints is not None
t, q = result.setpoints.t, result.setpoints.values

figure = plt.figure(figsize=(11, 4.6), constrained_layout=True)
grid = figure.add_gridspec(2, 2, width_ratios=[1.0, 1.5])
scene = figure.add_subplot(grid[:, 0], projection="3d")
tip = path.end[:, :3]
axis = find_axis_of_angles(path.end[:, 3], path.end[:, 4])
scene.plot(*tip[1:-1].T, color="tab:blue", linewidth=1.0)
for row in range(1, len(tip) - 1, 12):
    scene.plot(*np.stack([tip[row], tip[row] + 15 * axis[row]]).T, color="0.6", linewidth=0.6)
scene.set(xlabel="x mm", ylabel="y mm", zlabel="z mm", title="programmed: tip and tool axis on the table")
scene.set_box_aspect(np.ptp(tip[1:-1], axis=0) + 20)

sliders = figure.add_subplot(grid[0, 1])
for joint, name in enumerate(("rho1", "rho2", "rho3")):
    sliders.plot(t, q[:, joint], label=name, linewidth=0.9)
sliders.set(ylabel="sliders mm", title="written: axes.csv, one row every millisecond")
sliders.legend(loc="upper right", ncols=3, fontsize="small")
table = figure.add_subplot(grid[1, 1], sharex=sliders)
table.plot(t, q[:, 3], color="tab:red", linewidth=0.9, label="a (tilt + platform tilt)")
table.set(xlabel="time s", ylabel="a deg")
rotary = table.twinx()
rotary.plot(t, q[:, 4], color="tab:green", linewidth=0.9, label="c")
rotary.set_ylabel("c deg")
lines = [*table.get_lines(), *rotary.get_lines()]
table.legend(lines, [line.get_label() for line in lines], loc="lower center", fontsize="small")
figure.savefig("docs/pictures/blade.png", dpi=110)
