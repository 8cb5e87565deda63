"""Golden setpoints of the samples: what they are, and the one command that makes them anew.

Run: python -m tests.golden.renew
Converts every sample of SAMPLES, with the set-up file beside it, and writes golden.json: its duration, and every column
at 24 instants and at its extremes. The command prints a fingerprint. It belongs into the newest entry under "Motion
changes" of CHANGELOG.md, as "(golden 0123abcd)", with what has changed for users and why: the suite fails until it
stands there.
"""

import hashlib
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
FILE = Path(__file__).with_name("golden.json")
#: One each of corners that are blended, five axes in short segments, arcs and holes, splines, inverse time, tilted
#: planes; seconds each.
SAMPLES = (
    "inch.nc",
    "posted.nc",
    "pocket_3axis.nc",
    "splines.nc",
    "inverse_time.nc",
    "fanuc_tilted.nc",
    "two_faces.h",
    "wing.cls",
)
#: Instants, evenly spread over the duration, both ends among them.
INSTANTS = 24


def measure(csv: str) -> dict[str, Any]:
    """What is kept of a setpoint file: duration, s, columns (joints and line), lowest and highest values, values at the
    instants.
    """
    head, *lines = csv.splitlines()
    table = np.array([line.split(",") for line in lines], dtype=float)
    at = np.unique(np.linspace(0, len(table) - 1, INSTANTS).round().astype(int))
    return {
        "columns": head.split(",")[1:-1],
        "duration_s": float(table[-1, 0]),
        "lowest": table[:, 1:-1].min(axis=0).round(6).tolist(),
        "highest": table[:, 1:-1].max(axis=0).round(6).tolist(),
        "fastest": (np.abs(np.diff(table[:, 1:-1], axis=0)).max(axis=0) / (table[1, 0] - table[0, 0]))
        .round(3)
        .tolist(),
        "share": (at / (len(table) - 1)).round(9).tolist(),
        "rows": table[at, 1:-1].round(6).tolist(),
    }


def make() -> dict[str, Any]:
    """Convert every sample by the real command."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for sample in SAMPLES:
            output = Path(folder) / "rows.csv"
            command = [sys.executable, "-P", "-m", "verne_post", f"gcode_samples/{sample}", "-o", str(output)]
            subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
            found[sample] = measure(output.read_text("utf-8"))
    return found


def fingerprint(raw: bytes) -> str:
    """Eight digits that another golden file does not have."""
    return hashlib.sha256(raw).hexdigest()[:8]


def main() -> int:
    """Write the file."""
    lines = [f"{json.dumps(sample)}: {json.dumps(found)}" for sample, found in make().items()]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")
    print(
        f'golden {fingerprint(FILE.read_bytes())}: name it under "Motion changes" of CHANGELOG.md, with what has '
        "changed and why"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
