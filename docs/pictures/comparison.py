"""Take the picture of a page of two programs: the pocket sample, and the same with a lower feed rate and a larger
corner.

Run from the repository's root: python docs/pictures/comparison.py (needs the extras report and test, chromium and
chromedriver).
"""

import tempfile
from pathlib import Path

from _browser import report_page, take

SAMPLE = Path("gcode_samples/pocket_3axis.nc").resolve()

with tempfile.TemporaryDirectory() as folder:
    for name in ("before", "after"):
        version = Path(folder, name)
        version.mkdir()
        text = SAMPLE.read_text("utf-8")
        if name == "after":
            text = text.replace("G1 X14 Y-16 F1200", "G1 X14 Y-16 F1800").replace("G3 X24 Y-6 R10", "G1 X24\nY-6")
        (version / "pocket.nc").write_text(text, "utf-8")
        (version / "pocket.nc.toml").write_text(SAMPLE.with_name("pocket_3axis.nc.toml").read_text("utf-8"), "utf-8")
    with report_page("before/pocket.nc after/pocket.nc", (1400, 900), Path(folder)) as browser:
        take(
            browser,
            "comparison.png",
            "document.getElementById('time').value = 500; "
            "document.getElementById('time').dispatchEvent(new Event('input'))",
        )
