"""Make every picture of README and docs again: python docs/make_pictures.py [NAME ...] [--check].

A picture is made by a script of docs/pictures, run from the repository's root. With ``--check`` they are made in a
folder of their own and compared with those that are committed. error_field.png is made by the commands of its page
(make_transcripts.py). Needs the extras docs, report and test; report.py and tutorial.py also chromium and chromedriver.
"""

import contextlib
import runpy
import sys
import tempfile
from pathlib import Path
from unittest import mock

import matplotlib
import numpy as np
from matplotlib import pyplot
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
#: Pictures are compared in cells of so many pixels: the smoothing of edges differs from machine to machine.
CELL = 16
#: A cell whose mean differs by more, of 255, shows something else.
OTHER = 16.0
#: Largest share of such cells by script: a curve of other numbers changes more. A browser takes the fonts of its
#: machine.
SHARES = {"comparison": 0.1, "report": 0.1, "tutorial": 0.1}
SHARE = 0.01


def find_scripts() -> list[Path]:
    """Every script that makes pictures; what they share begins with an underscore."""
    return sorted(script for script in PICTURES.glob("[!_]*.py"))


def make(script: Path, root: Path) -> None:
    """Run a script in a root of the repository's layout; in this process, where matplotlib is loaded once."""
    with (
        contextlib.chdir(root),
        contextlib.redirect_stdout(None),
        mock.patch.object(sys, "path", [str(script.parent), *sys.path]),
        matplotlib.rc_context(),
    ):
        runpy.run_path(str(script), run_name="__main__")
    pyplot.close("all")


def share_of_other_cells(made: Path, committed: Path) -> float:
    """Share of the cells in which two pictures differ; 1 where they have not the same size."""
    if not committed.exists():
        return 1.0
    pictures = [Image.open(file).convert("RGB") for file in (made, committed)]
    width, height = pictures[0].size
    if pictures[1].size != (width, height):
        return 1.0
    small = (width // CELL, height // CELL)
    first, second = (np.asarray(picture.resize(small, Image.Resampling.BOX), dtype=float) for picture in pictures)
    return float((np.abs(first - second).max(axis=2) > OTHER).mean())


def find_stale(script: Path, folder: Path) -> list[str]:
    """Pictures that a script makes otherwise now, in an empty folder."""
    (folder / "docs" / "pictures").mkdir(parents=True)
    for name in ("gcode_samples", "machine_configs"):
        (folder / name).symlink_to(ROOT / name)
    make(script, folder)
    return find_others(folder / "docs" / "pictures", script.name, SHARES.get(script.stem, SHARE))


def find_others(made: Path, maker: str, largest: float = SHARE) -> list[str]:
    """Pictures in a folder that are not as committed."""
    shares = {file.name: share_of_other_cells(file, PICTURES / file.name) for file in sorted(made.glob("*.png"))}
    return [
        f"{name}: {100 * share:.1f} % of the picture are not as {maker} makes them"
        for name, share in shares.items()
        if share > largest
    ]


def main(words: list[str]) -> int:
    """Make the pictures of the named scripts, or of all; with ``--check`` say which are stale."""
    names = [word for word in words if word != "--check"]
    scripts = [script for script in find_scripts() if not names or script.stem in names]
    if "--check" not in words:
        for script in scripts:
            make(script, ROOT)
        return 0
    stale = []
    for script in scripts:
        with tempfile.TemporaryDirectory() as folder:
            stale += find_stale(script, Path(folder))
    print("\n".join(stale) or "all pictures are as their scripts make them")  # noqa: T201
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
