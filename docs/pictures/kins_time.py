"""Draw docs/pictures/kins_time.png: time of one solution in a servo thread, from the table of docs/linuxcnc.md.

Run from the repository's root: python docs/pictures/kins_time.py (needs the docs extra).
"""

import re
from pathlib import Path

import matplotlib.pyplot as plt

METHODS = {"closed form": "#1f77b4", "Newton, cold": "#d62728", "Newton, warm": "#ff7f0e"}
page = (Path(__file__).resolve().parents[1] / "linuxcnc.md").read_text(encoding="utf-8")
page = page.partition("kinematics in a servo thread: begin")[2]
rows = re.findall(r"^\| `(.+?)` \| (inverse|forward) \|(.*)\|$", page, flags=re.M)

figure, axes = plt.subplots(figsize=(8.6, 3.8), constrained_layout=True)
for k, (_machine, _title, cells) in enumerate(rows):
    for j, ((method, color), cell) in enumerate(zip(METHODS.items(), cells.split("|"), strict=True)):
        median, worst = (float(word) for word in cell.split(","))
        place = k + 0.27 * (j - 1)
        axes.bar(place, median, 0.25, color=color, label=method if k == 0 else None)
        axes.plot([place, place], [median, worst], color=color, lw=1)
        axes.plot(place, worst, "_", color=color, ms=9, label="slowest pose" if k == j == 0 else None)
axes.set_xticks(range(len(rows)), [f"{machine.replace(', ', chr(10))}\n{title}" for machine, title, _cells in rows])
axes.tick_params(axis="x", labelsize=8)
axes.set_ylabel("ns for one pose")
axes.set_title("Kinematics of the whole machine in C; a servo period of 1 ms is 1,000,000 ns", fontsize=10)
axes.grid(axis="y", alpha=0.3)
axes.set_axisbelow(True)
axes.legend(fontsize=8)
figure.savefig("docs/pictures/kins_time.png", dpi=100)
