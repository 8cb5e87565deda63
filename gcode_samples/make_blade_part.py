"""Make the nominal part of blade_5axis.nc: ``python gcode_samples/make_blade_part.py FOLDER`` writes blade_part.stl and
blade_shapes.toml.

The part is the strip that a ball of 4 mm touches along the programmed path, 1 mm to both sides, straight from point to
point. Its normal is the part of the tool axis that is square to the path. An open mesh: a surface, no body.
"""

import re
import struct
import sys
from pathlib import Path

import numpy as np

RADIUS, SIDE = 4.0, 1.0
SHAPES = f"""# shapes of the tools of blade_5axis.nc, which names none: tool 0
[tool.0]
cutter = {{ diameter = {2 * RADIUS:g}, length = 25.0, corner_radius = {RADIUS:g} }}
holder = {{ diameter = 30.0 }}
"""


def read_poses(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Tips (n, 3) and tool axes (n, 3) of the feed moves, in G54."""
    now, poses, feeds = dict.fromkeys("XYZAC", 0.0), [], False
    for line in text.splitlines():
        line = re.sub(r"\(.*?\)", "", line)
        feeds = "G1" in line.split() or (feeds and "G0" not in line.split())
        words = re.findall(r"([XYZAC])([-+.\d]+)", line)
        now |= {letter: float(value) for letter, value in words}
        if words and feeds:
            poses.append([now[letter] for letter in "XYZAC"])
    x, y, z, a, c = np.array(poses).T
    a, c = np.radians(a), np.radians(c)
    return np.stack([x, y, z], axis=1), np.stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)], axis=1)


def make_strip(tip: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Facets (m, 3, 3), counter-clockwise from outside."""
    along = np.gradient(tip, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    normal = axis - (axis * along).sum(1)[:, None] * along
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    touched = tip + RADIUS * (axis - normal)
    across = np.cross(normal, along)
    left, right = touched + SIDE * across, touched - SIDE * across
    lower = np.stack([right[:-1], right[1:], left[:-1]], axis=1)
    upper = np.stack([right[1:], left[1:], left[:-1]], axis=1)
    return np.concatenate([lower, upper])


def main(folder: Path) -> None:
    """Write both files, into a folder that is made where it is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    facets = make_strip(*read_poses(Path(__file__).with_name("blade_5axis.nc").read_text(encoding="utf-8")))
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *one.ravel(), 0) for one in facets)
    (folder / "blade_part.stl").write_bytes(
        b"nominal part of blade_5axis.nc".ljust(80) + struct.pack("<I", len(facets)) + rows
    )
    (folder / "blade_shapes.toml").write_text(SHAPES, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
