"""Take the pictures of the tutorial: the program that it writes, with its set-up, in a browser without a screen.

Run from the repository's root: python docs/pictures/tutorial.py (needs the extras report and test, chromium and
chromedriver).
"""

import re
import tempfile
from pathlib import Path

from _browser import report_page, take

#: The last frame of a line.
AT = "report.setCursor(report.arrays.line.lastIndexOf(arguments[0]));"
SIZE = (1400, 900)
TUTORIAL = (Path(__file__).parents[1] / "tutorial.md").read_text("utf-8")

with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    for file in ("lean.nc", "lean.nc.toml"):
        found = re.search(rf"^\$ cat {re.escape(file)}\n(.*?)(?=^\$ |^```$)", TUTORIAL, re.DOTALL | re.MULTILINE)
        assert found is not None, file
        (folder / file).write_text(found[1], "utf-8")
    with report_page("lean.nc", SIZE, folder) as browser:
        take(browser, "tutorial_part.png", AT, 10, part="#near")
        take(browser, "tutorial_report.png", AT, 11)
        # the end of the move that leans the tool most
        take(browser, "tutorial_machine.png", f"{AT} report.view('fit')", 12, part="#stage")
    # its findings stand above the machine: a taller page, or the machine is cut off
    with report_page("lean.nc --wcs G54=0,0,620", (SIZE[0], 1100), folder) as browser:
        take(browser, "tutorial_refused.png", AT, 13, part="#stage")
