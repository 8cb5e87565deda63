"""What a conversion that rounds corners spends on starting, against the time to import numpy and scipy.linalg.

Run: python tests/benchmarks/startup.py [--runs 15] [--write]   with --write the table goes into docs/performance.md
A process converts a sample twice. Starting is what the first conversion takes more than the second, from the begin of
the process on. CPU seconds of one thread, the least of runs that take turns. Modules must be compiled, as pip leaves
them.
"""

import argparse
import os
import platform
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from page import write_section

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "gcode_samples" / "two_faces.nc"

_IMPORT = "import time\nimport {}\nprint(time.process_time())"
_CONVERT = """
import sys, time
from verne_post.__main__ import run
taken = [0.0]
for _ in range(2):
    try:
        run()
    except SystemExit as end:
        assert end.code == 0
    taken.append(time.process_time())
print(2 * taken[1] - taken[2])
"""
_BASE = "numpy, scipy.linalg"
SCRIPTS = {
    "import os": _IMPORT.format("os"),
    "import numpy": _IMPORT.format("numpy"),
    f"import {_BASE}": _IMPORT.format(_BASE),
    "import numpy, msgspec, click": _IMPORT.format("numpy, msgspec, click"),
    f"verne-post {SAMPLE.name}": _CONVERT,
}


def measure(script: str, folder: str) -> float:
    """CPU seconds that a script prints."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    words = [sys.executable, "-c", script, str(SAMPLE), "-q", "-o", "out.csv"]
    run = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=True)
    return float(run.stdout.split()[-1])


def main() -> None:
    """Measure and print, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=15)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    least = dict.fromkeys(SCRIPTS, float("inf"))
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(given.runs):
            for name, script in SCRIPTS.items():
                least[name] = min(least[name], measure(script, folder))
    base = least[f"import {_BASE}"]
    versions = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "msgspec", "click"))
    text = "\n".join(
        [
            f"| program | CPU s | compared with `import {_BASE}` |",
            "| --- | --- | --- |",
            *(f"| `{name}` | {taken:.3f} | {100 * (taken - base) / base:+.0f} % |" for name, taken in least.items()),
        ]
    )
    print(text)
    if given.write:
        write_section("start-up", text, ran=f"{platform.machine()}, Python {platform.python_version()}, {versions}")


if __name__ == "__main__":
    main()
