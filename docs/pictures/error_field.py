"""Draw the picture of docs/as-built.md: tip errors over the table before and after a calibration, by the page's commands.

Run from the repository's root: python docs/pictures/error_field.py (needs the docs extra).
"""

import tempfile
from pathlib import Path

from verne_post.cli.main import main

PICTURE = Path("docs/pictures/error_field.png").resolve()

with tempfile.TemporaryDirectory() as folder:
    real, plan, mine = (str(Path(folder, name)) for name in ("real.toml", "plan.csv", "mine.toml"))
    for words in (
        ["perturb", "--seed", "7", "-o", real],
        ["calibrate", "--plan", "40", "--simulate", real, "--seed", "1", "-o", plan],
        ["calibrate", plan, "-o", mine, "--plot", str(PICTURE)],
    ):
        assert main(["machine", *words]) == 0
