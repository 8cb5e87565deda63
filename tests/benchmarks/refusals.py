"""CPU time of wrong invocations, against an empty program and one that imports numpy: python
tests/benchmarks/refusals.py.

Each is started in turn with the two others, so that a drift of the machine hits all three; the table has the median of
the runs. ``tests/cli/test_refusals.py`` sees that each is refused, and that none loads numpy.
"""

import argparse
import os
import platform
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
#: Words of the command line, and words of the answer.
WRONG: Final = {
    "no.nc": "no.nc: VP022 error: no such file",
    "part.nc --bogus": "No such option",
    "part.nc --tool-length abc": "not a number",
    "part.nc --tolerance -1": "expected 1e-06 to 10 mm",
    "part.nc --wcs 1,2,3": "expected G54=X,Y,Z",
    "part.nc --from nowhere": "not a list of numbers",
    "part.nc --machine no.toml": "verne-post machine list",
    "part.nc --tool-table no.tbl": "--tool-table no.tbl: No such file",
    "part.nc --setup no.toml": "--setup no.toml: No such file",
    "part.nc --settings bad.toml": "not a TOML file",
    "part.nc --format nope": "is not one of",
    "part.nc -o no/axes.csv": "the folder does not exist",
    "part.nc --meta part.nc": "this is the file of INPUT",
    "part.nc --meta -": "only one of them can be standard output",
    "chek part.nc": "did you mean check",
    "check part.nc --ignore VPXX": "is no code",
    "check part.nc --baseline no.json": "--baseline no.json: No such file",
    "batch nowhere -o out": "no such file or folder",
    "batch empty -o out": "no programs in empty",
    "batch . -o part.nc": "is a file",
    "batch . -o part.nc/out": "a folder is needed",
    "verify no.csv --against part.nc": "no.csv: VP022 error: No such file",
    "explain part.nc": ":LINE is missing",
    "fit part.nc --free q": "expected some of the letters",
    "report part.nc -o no/r.html": "the folder does not exist",
    "machine validate no.toml": "verne-post machine list",
    "machine show verne --plot x.gif": "expected a name that ends in",
    "machine axis-check --at 0 -o full": "the folder is not empty",
    "machine identify no.csv": "no.csv: VP022 error: No such file",
    "machine calibrate no.csv -o m.toml": "no.csv: VP022 error: No such file",
    "machine perturb --seed 1 -o no/m.toml": "the folder does not exist",
}


def make_files(folder: Path) -> None:
    """What the invocations are about."""
    shutil.copy(ROOT / "gcode_samples" / "pocket_3axis.nc", folder / "part.nc")
    (folder / "bad.toml").write_text("x =\n")
    (folder / "empty").mkdir()
    (folder / "full").mkdir()
    (folder / "full" / "x.txt").write_text("x\n")


def cpu_seconds(words: list[str], folder: Path) -> float:
    """User and system time of a process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    subprocess.run(words, cwd=folder, env=environment, capture_output=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=7)
    given = parser.parse_args()
    empty, numpy = ([sys.executable, "-c", code] for code in ("pass", "import numpy"))
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_files(folder)
        for wrong in WRONG:
            command = [sys.executable, "-m", "verne_post", *wrong.split()]
            cpu_seconds(command, folder)  # the first run may compile modules
            runs = [[cpu_seconds(words, folder) for words in (command, empty, numpy)] for _ in range(given.runs)]
            rows.append((wrong, *(statistics.median(column) for column in zip(*runs, strict=True))))
    alike: dict[str, list[str]] = {}
    for wrong, ours, _least, _base in rows:
        alike.setdefault(f"{ours:.2f}", []).append(f"`{wrong}`")
    least, base = (statistics.median(row[k] for row in rows) for k in (2, 3))
    text = "\n".join(
        [
            f"{platform.machine()}, Python {platform.python_version()}, {datetime.now(UTC):%Y-%m-%d}, median of "
            f"{given.runs}. `python -c pass` takes {least:.2f} s, `import numpy` {base:.2f} s.",
            "",
            "| CPU s | `verne-post` ... |",
            "| --- | --- |",
            *(f"| {seconds} | {', '.join(names)} |" for seconds, names in sorted(alike.items())),
        ]
    )
    print(text)


if __name__ == "__main__":
    main()
