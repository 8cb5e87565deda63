"""Take pictures of the report page of the vise sample with a step that is 0.3 mm too deep: the part, and the stock that
is left.

Run from the repository's root: python docs/pictures/machined_page.py (needs the extras report, part and test, chromium
and chromedriver).
"""

import runpy
import tempfile
from pathlib import Path

from _browser import report_page, take

_CHOOSE = """
report.view('part');
if (document.getElementById('tool-axes').checked) document.getElementById('tool-axes').click();
const body = document.getElementById('body');
body.value = arguments[0];
body.dispatchEvent(new Event('change'));
"""

with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    runpy.run_path("gcode_samples/make_vise_sample.py")["main"](folder)
    program = folder / "vise.nc"
    program.write_text(program.read_text("utf-8").replace("\nZ-6\n", "\nZ-6.3\n"), "utf-8")
    with report_page("vise.nc", (1400, 900), folder) as browser:
        take(browser, "machined_page.png", _CHOOSE, "part", part="#machine")
        take(browser, "machined_left.png", _CHOOSE, "left", part="#machine")
