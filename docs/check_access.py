"""Whether everybody can read the built site: axe over its pages, wide and narrow, light and dark.

    npm install axe-core
    mkdocs build --strict
    python docs/check_access.py node_modules/axe-core/axe.min.js build/site

Prints each violation, and each page that scrolls sideways, and exits with 1 if there is one. Needs the extra test,
chromium and chromedriver.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any, Final

from selenium import webdriver

#: Width, height, scheme.
SCREENS: Final = ((1400, 900, "light"), (390, 844, "dark"), (1400, 900, "dark"), (390, 844, "light"))
#: Pages that are made one like the other: one of them is enough.
LIKE: Final = "VP"
_RUN: Final = """
const done = arguments[0], first = node => (node.any[0] || node.all[0] || node.none[0] || {}).message;
const run = () => axe.run(document, { resultTypes: ["violations"] }).then(found => done(found.violations.map(
  one => [one.id, one.impact, one.nodes.map(node => node.html.slice(0, 160) + "  " + first(node))])));
// the theme still adds to the page for a moment after it is loaded
setTimeout(run, 400);
"""


def open_browser() -> webdriver.Chrome:
    """Chromium without a screen."""
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader"):
        options.add_argument(argument)
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        raise SystemExit("needs chromium and chromedriver")
    options.binary_location = chromium
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    browser.set_script_timeout(120)
    # the theme stores the first scheme that it shows, and keeps it on all later screens
    browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": "localStorage.clear()"})
    return browser


def list_violations(browser: Any, axe: str, page: Path, screen: tuple[int, int, str]) -> list[str]:
    """Open a page on a screen and list what axe finds."""
    width, height, scheme = screen
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    browser.get(page.resolve().as_uri())
    browser.execute_script(axe)
    widest = browser.execute_script("return Math.max(document.documentElement.scrollWidth, innerWidth)")
    wide = [f"the page scrolls sideways: it is {widest} pixels wide"] if widest > width else []
    found = browser.execute_async_script(_RUN)
    shown = browser.execute_script("return document.body.dataset.mdColorScheme")
    if shown not in (None, {"light": "default", "dark": "slate"}[scheme]):  # a page without the theme names none
        raise SystemExit(f"{page.name} shows the scheme {shown}, not {scheme}")
    return wide + [f"{rule} ({impact}): {' '.join(node.split())}" for rule, impact, nodes in found for node in nodes]


def main(axe: str, site: str) -> int:
    """Go through the site."""
    pages = sorted(Path(site).rglob("*.html"))
    like = [page for page in pages if page.name.startswith(LIKE)]
    browser, count = open_browser(), 0
    try:
        for page in [page for page in pages if page not in like[1:]]:
            for screen in SCREENS:
                for text in list_violations(browser, Path(axe).read_text("utf-8"), page, screen):
                    count += 1
                    sys.stdout.write(f"{page.relative_to(site)}, {screen[0]} {screen[2]}: {text}\n")
    finally:
        browser.quit()
    sys.stdout.write(f"{count} violations on {len(pages) - len(like[1:])} pages, {len(SCREENS)} screens each\n")
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
