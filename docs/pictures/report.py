"""Take the picture of the report page: the blade sample, in a browser without a screen.

Run from the repository's root: python docs/pictures/report.py (needs the extras report and test, chromium and chromedriver).
"""

import base64
import shutil
import tempfile
import time
from pathlib import Path

from selenium import webdriver

import verne_post
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.report.page import page
from verne_post.report.study import study

NAME = "gcode_samples/blade_5axis.nc"
SIZE = (1400, 1180)

machine = verne_post.load_machine()
source = Path(NAME).read_bytes()
options = Options(tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 10.0))})
settings = webdriver.ChromeOptions()
for argument in (
    "--headless=new",
    "--no-sandbox",
    "--enable-unsafe-swiftshader",
    "--use-angle=swiftshader",
    "--hide-scrollbars",
):
    settings.add_argument(argument)
settings.binary_location = str(shutil.which("chromium"))
browser = webdriver.Chrome(options=settings, service=webdriver.ChromeService(shutil.which("chromedriver")))
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "report.html"
    file.write_text(page(NAME, source, machine, study(source, machine, options)), "utf-8")
    screen = {"width": SIZE[0], "height": SIZE[1], "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    browser.get(file.as_uri())
    while browser.execute_script("return document.body.dataset.ready") != "yes":
        time.sleep(0.1)
    # in the middle of the blade, where C is at its velocity
    browser.execute_script("report.setCursor(report.data.frames >> 1)")
    browser.execute_async_script(
        "requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(arguments[0], 300)))"
    )
    shot = browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})["data"]
browser.quit()
Path("docs/pictures/report.png").write_bytes(base64.b64decode(shot))
