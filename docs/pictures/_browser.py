"""Pictures of report pages, in a browser without a screen: what the scripts beside share; makes no picture itself."""

import base64
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from selenium import webdriver

_ARGUMENTS = (
    "--headless=new",
    "--no-sandbox",
    "--enable-unsafe-swiftshader",
    "--use-angle=swiftshader",
    "--disable-gpu-compositing",  # only WebGL is drawn by that software, which is slow; not the page
    "--hide-scrollbars",
)
#: Nothing is drawn of the machine until somebody looks (``drawn``): by software it would take most of the time.
DRAW_WHEN_ASKED = """
for (const name of ['drawArrays', 'drawArraysInstanced', 'drawElements', 'drawElementsInstanced']) {
  const own = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...words) {
    if (window.isDrawn) own.apply(this, words); else window.isToBeDrawn = true;
  };
}
"""


def settle(browser: Any) -> None:
    """Wait until what was asked to be drawn is drawn."""
    browser.execute_async_script(
        "requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(arguments[0], 0)))"
    )


@contextmanager
def drawn(browser: Any) -> Iterator[None]:
    """The machine is drawn meanwhile; what the page has asked to be drawn before, at once, and nothing else."""
    settle(browser)
    browser.execute_script("window.isDrawn = true; if (window.isToBeDrawn) report.scene.draw()")
    settle(browser)
    yield
    browser.execute_script("window.isDrawn = window.isToBeDrawn = false")


@contextmanager
def report_page(words: str, size: tuple[int, int], cwd: Path | None = None) -> Iterator[Any]:
    """A browser that shows what `verne-post report` writes with these words; a refused program has a report too."""
    settings = webdriver.ChromeOptions()
    for argument in _ARGUMENTS:
        settings.add_argument(argument)
    settings.binary_location = str(shutil.which("chromium"))
    browser = webdriver.Chrome(options=settings, service=webdriver.ChromeService(shutil.which("chromedriver")))
    try:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "report.html"
            command = [sys.executable, "-m", "verne_post", "report", *words.split(), "-q", "-o", str(file)]
            subprocess.run(command, cwd=cwd, check=False, stderr=subprocess.DEVNULL)
            screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
            browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
            browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": DRAW_WHEN_ASKED})
            browser.get(file.as_uri())
            while browser.execute_script("return document.body.dataset.ready") != "yes":
                time.sleep(0.1)
            yield browser
    finally:
        browser.quit()


def take(browser: Any, picture: str, script: str, *words: object, part: str | None = None) -> None:
    """Run a script in the page; save what is seen, or one part of it, as docs/pictures/PICTURE, and in dark colours."""
    browser.execute_script(script, *words)
    Path("docs/pictures", picture).write_bytes(_capture(browser, part))
    browser.find_element("id", "theme").click()
    Path("docs/pictures", picture.replace(".png", "_dark.png")).write_bytes(_capture(browser, part))
    browser.find_element("id", "theme").click()


def _capture(browser: Any, part: str | None) -> bytes:
    """The page as it is drawn now, or one part of it, as a PNG file."""
    browser.execute_async_script("setTimeout(arguments[0], 300)")
    clip: dict[str, Any] = {}
    if part is not None:
        box = browser.execute_script(
            "const b = document.querySelector(arguments[0]).getBoundingClientRect();"
            "return [b.x + scrollX, b.y + scrollY, b.width, b.height]",
            part,
        )
        clip = {"clip": dict(zip(("x", "y", "width", "height"), map(round, box), strict=True)) | {"scale": 1}}
    with drawn(browser):
        return base64.b64decode(browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png", **clip})["data"])
