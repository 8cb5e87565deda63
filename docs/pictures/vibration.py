"""Draw docs/pictures/vibration.png: a move of 10 mm with and without an input shaper, and a mode of 38 Hz during and
after it.

Run from the repository's root: python docs/pictures/vibration.py (needs the docs extra).
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import verne_post
from verne_post.model.vibration import Mode, Vibration

PROGRAM = b"G21 G90 G61\nG0 X0 Y0 Z50\nG1 X10 F6000\nM2\n"
MODE = Mode(38.0, 0.02)
SHOWN_S = 0.6
machine = replace(verne_post.load_machine("serial"), vibration=Vibration((MODE,), None))


def swing(place: np.ndarray, cycle: float) -> np.ndarray:
    """Where a mass of the mode is against its base, which stands at ``place`` row by row: 20 steps a row."""
    natural, steps = 2 * np.pi * MODE.frequency, 20
    h = cycle / steps
    base = np.interp(np.arange(len(place) * steps) / steps, np.arange(len(place)), place)
    off, rate, found = 0.0, 0.0, []
    for jump in np.diff(np.diff(base, prepend=base[0]), append=0.0):
        rate += -jump / h - h * (2 * MODE.damping * natural * rate + natural**2 * off)
        off += h * rate
        found.append(off)
    return np.array(found[::steps])


figure, (above, below) = plt.subplots(2, 1, figsize=(9, 5), sharex=True, constrained_layout=True)
for shaper, color in (("off", "tab:red"), ("zv", "tab:blue"), ("zvd", "tab:green")):
    options = verne_post.Options(tool_length=50.0, wcs={"G54": (0.0, 0.0, 0.0)}, shaper=shaper)
    setpoints = verne_post.convert(PROGRAM, machine, options).setpoints
    assert setpoints is not None
    rows = round(SHOWN_S / machine.cycle)
    x = np.asarray(setpoints.values)[:, 0]
    x = np.append(x, np.full(max(rows - len(x), 0), x[-1]))[:rows]
    t = machine.cycle * np.arange(rows)
    label = "no shaper" if shaper == "off" else shaper
    above.plot(t, np.gradient(np.gradient(x, machine.cycle), machine.cycle) / 1e3, color=color, lw=1.2, label=label)
    below.plot(t, 1e3 * swing(x, machine.cycle), color=color, lw=1.2)
above.set_ylabel("acceleration of x, m/s2")
above.legend(loc="upper right")
below.set_ylabel("mass against base, um")
below.set_xlabel("s")
for panel in (above, below):
    panel.grid(alpha=0.3)
figure.savefig("docs/pictures/vibration.png", dpi=110)
