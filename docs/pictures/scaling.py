"""Draw docs/pictures/scaling.png: seconds and MiB against lines, from the table that tests/benchmarks/scaling.py
writes.

Run from the repository's root: python docs/pictures/scaling.py (needs the docs extra).
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

page = (Path(__file__).resolve().parents[1] / "performance.md").read_text("utf-8")
section = page.split("<!-- scaling: begin -->")[1].split("<!-- scaling: end -->")[0]
cells = [
    [cell.strip().replace(",", "") for cell in line.strip("| ").split("|")]
    for line in section.splitlines()
    if line.startswith("|")
]
columns = dict(zip(cells[0], np.array(cells[2:], dtype=float).T, strict=True))
lines = columns["lines"]

figure, (seconds, memory) = plt.subplots(1, 2, figsize=(9, 3.6), constrained_layout=True)
for panel, unit in ((seconds, "s"), (memory, "MiB")):
    for name, color in (("read", "tab:orange"), ("convert", "tab:blue")):
        panel.loglog(lines, columns[f"{name} {unit}"], "o-", color=color, linewidth=1.2, markersize=4, label=name)
    panel.set_xlabel("lines of the program")
    panel.grid(True, which="major", linewidth=0.4)
seconds.loglog(
    lines, columns["convert s"][-1] * lines / lines[-1], "k--", linewidth=0.8, label="in proportion to the lines"
)
seconds.set_ylabel("CPU time, s")
memory.loglog(lines, columns["file MiB"], "o:", color="0.5", linewidth=1.0, markersize=3, label="file that is written")
memory.set_ylabel("peak memory, MiB")
for panel in (seconds, memory):
    panel.legend(fontsize=8)
figure.savefig("docs/pictures/scaling.png", dpi=110)
