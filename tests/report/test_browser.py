"""The report page in a real browser: nothing is cropped, one cursor moves everything, and everybody can read it."""

import base64
import io
import json
import re
import runpy
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.model.options import Options
from verne_post.model.part_setup import Box, FixtureMesh, Tool, WorkOffset
from verne_post.report.comparison import Side, make_side, write_comparison

from ..builders import ROOT, SAMPLES
from .test_report import NASTY_PROGRAM, ONE_IN_3000, embedded
from .test_surfaces import FLOOR, make_options

pytest.importorskip("jupyter_threejs_sage")
webdriver = pytest.importorskip("selenium.webdriver")
DRAWING = runpy.run_path(str(ROOT / "docs" / "pictures" / "_browser.py"))
settle, drawn = DRAWING["settle"], DRAWING["drawn"]

WHOLE_MACHINE = ("fit", "top", "front", "tool")
#: A4 without the margins of 12 mm, in pixels of the page.
PAPER_WIDTH = 703
PAPER_HEIGHT = 1032
#: In how many columns the program is printed.
COLUMNS = "getComputedStyle(document.getElementById('code-lines')).columnCount"
SIZES = {"desktop": (1400, 900), "tablet": (1024, 768), "phone": (390, 844)}


@cache
def page_of(name: str) -> str:
    """The page of one of the programs below."""
    from verne_post.report.page import make_page
    from verne_post.report.study import study

    if name in COMPARED:
        return write_comparison((side_of(COMPARED[name][0]), side_of(COMPARED[name][1])))
    text, machine, options = PROGRAMS[name]
    source = text if isinstance(text, bytes) else text.encode()
    place = verne_post.load_machine(machine)
    return make_page(name, source, place, study(source, place, options))


def side_of(name: str) -> Side:
    """One of the programs below, to be compared."""
    from verne_post.report.study import study

    text, machine, options = PROGRAMS[name]
    source, place = text if isinstance(text, bytes) else text.encode(), verne_post.load_machine(machine)
    return make_side(name, source, place, study(source, place, options))


def sample(name: str, tool: float, place: tuple[float, float, float], **more: Any) -> tuple[bytes, str, Options]:
    return (SAMPLES / name).read_bytes(), "verne", Options(tool_length=tool, wcs={1: WorkOffset(place)}, **more)


VISE = runpy.run_path(str(SAMPLES / "make_vise_sample.py"))
VISE_STL = VISE["pack_stl"](VISE["unite_boxes"]([VISE["BASE"], *VISE["JAWS"], VISE["STOP"]]))

#: A face of 84 by 24 mm, with retracts to the reference point as posts write them.
RETRACTED = """G21 G90 G54
G28 G91 Z0.
(MULTIAXISSWARFING1)
G90 G0 X-42. Y-12.
Z5.
G1 Z-1. F800.
X42.
Y12.
X-42.
Y-12.
G28 G91 Z0.
M30
"""

#: A face that a cutter of 50 mm mills in two lines.
FACED = """G21 G90 G54
T1 M6 G43 H1
G0 X-30 Y-15 Z20
Z-1
G1 X30 F1200
Y15
X-30
G0 Z20
M30
"""

PROGRAMS: dict[str, tuple[bytes | str, str, Options]] = {
    "faced": (
        FACED,
        "verne",
        Options(tools={1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 50.0)}, wcs={1: WorkOffset((0.0, 0.0, 60.0))}),
    ),
    "pocket": sample(
        "pocket_3axis.nc", 80.0, (-10.0, 15.0, 60.0), stock=Box("the stock", (-40.0, -20.0, 40.0), (30.0, 50.0, 60.0))
    ),
    "vise": (
        VISE["PROGRAM"].partition("T2")[0] + "M2\n",
        "verne",
        Options(tool_length=100.0, wcs={1: WorkOffset((0.0, 0.0, 70.0))}, keep_out=(FixtureMesh("vise", VISE_STL),)),
    ),
    "floor": (FLOOR, "verne", make_options(stock=Box("the stock", (-10.0, -5.0, -8.0), (10.0, 5.0, 0.0), 1))),
    "blade": sample("blade_5axis.nc", 120.0, (0.0, 0.0, 10.0)),
    "travel": sample("violates_slider_travel.nc", 50.0, (0.0, 0.0, 420.0)),
    "tilt": sample("violates_tilt.nc", 120.0, (0.0, 0.0, 60.0)),
    "klartext": sample("two_faces.h", 80.0, (0.0, 0.0, 40.0)),
    "retracted": (RETRACTED, "ac_trunnion", Options(tool_length=110.0, wcs={1: WorkOffset((0.0, 0.0, 60.0))})),
    "offsets": (
        "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X30 F900\nM2\n",
        "verne",
        Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 40.0), source="two_faces_of_it.nc.toml")}),
    ),
    "low": ("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X20 F900\nZ-20\nX40\nM2\n", "verne", Options(tool_length=80.0)),
    "out of reach": ("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X3000 F9000\nM2\n", "verne", Options(tool_length=60.0)),
    "serial": ("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X30 A20 C40 F900\nM2\n", "serial", Options(tool_length=60.0)),
    "delta": ("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X30 A2 C4 F900\nM2\n", "linear_delta", Options(tool_length=60.0)),
    "hexapod": ("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X30 A2 C4 F900\nM2\n", "hexapod", Options(tool_length=60.0)),
    "fork": (
        "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X30 A20 C40 F900\nM2\n",
        "ca_fork_head",
        Options(tool_length=100.0, wcs={1: WorkOffset((1000.0, 1000.0, -200.0))}),
    ),
    "tricept": (
        "G21 G90\nG0 X0 Y0 Z50 A20 C0\nG1 X30 A30 C40 F900\nM2\n",
        "tricept",
        Options(tool_length=100.0, wcs={1: WorkOffset((300.0, 100.0, 50.0))}),
    ),
    "inches": (
        "G20 G90\nG0 X-15 Y-15 Z25 A0 C0\nG1 Z-5 F400\nX15 Y15\nX-15\nZ25\nM2\n",
        "verne",
        Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 100.0))}),
    ),
    "nasty": (NASTY_PROGRAM, "verne", Options(tool_length=60.0)),
    "many": (ONE_IN_3000, "verne", Options(tool_length=60.0)),
    "many findings": (
        "G21 G90\n" + "".join(f"G1 X{k} Q{k}\nG99{k}\n" for k in range(1, 8)) + "M2\n",
        "verne",
        Options(),
    ),
    "unreadable": (
        "G21 G90 F600\n" + "G1 X1\n" * 250 + "G1 X\nG1 X2O\n" + "G1 X1\n" * 200 + "M2\n",
        "verne",
        Options(tool_length=60.0),
    ),
    # the table leans until the eye that sees the front of the machine sees its back
    "over": (
        "G21 G90\nG0 X0 Y30 Z80 A-115 C0\nG1 Z60 F600\nX20\nZ80\nM2\n",
        "verne",
        Options(tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 60.0))}),
    ),
    "clamp": (
        "G21 G90\nG0 X-40 Y0 Z30 A0 C0\nG1 Z-2 F500\nX40\nG0 Z50\nM2\n",
        "verne",
        Options(
            tools={0: Tool(0, 0, (0.0, 0.0, 120.0, *(0.0,) * 6), 10.0)},
            tool_length=120.0,
            wcs={1: WorkOffset((0.0, 0.0, 60.0))},
            keep_out=(Box("clamp", (30.0, -15.0, -10.0), (60.0, 15.0, 20.0), 1),),
        ),
    ),
    "tools": (
        "G21 G90 G54\n"
        + "".join(
            f"T{k} M6\nG43 H{k}\nS900 M3\nG0 X0 Y0 Z50 A0 C0\nG1 Z40 F900\n" + "X10 A-5.000\nX0 A-4.000\n" * lines
            for k, lines in ((1, 20), (2, 20), (3, 150))
        )
        + "M30\n",
        "verne",
        Options(tools={1: 90, 2: 95, 3: 98}, wcs={1: WorkOffset((0.0, 0.0, 60.0))}, split_at_stops=True),
    ),
}


COMPARED = {"two": ("blade", "pocket"), "refused and not": ("travel", "pocket"), "neither": ("unreadable", "nasty")}


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Debian's chromium without a screen; skipped where it is not installed (.ci/run installs it).

    WebGL is drawn by software, and edges need no smoothing. Putting pages together needs no WebGL: by the same software
    it would take most of the time.
    """
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("needs chromium and chromedriver")
    options = webdriver.ChromeOptions()
    for argument in (
        "--headless=new",
        "--no-sandbox",
        "--disable-quic",
        "--no-first-run",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--enable-unsafe-swiftshader",
        "--use-angle=swiftshader",
        "--disable-gpu-compositing",
        "--webgl-antialiasing-mode=none",
        "--hide-scrollbars",
        f"--user-data-dir={tmp_path_factory.mktemp('profile')}",
    ):
        options.add_argument(argument)
    options.binary_location = chromium
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    running = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    running.set_script_timeout(60)
    running.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": DRAWING["DRAW_WHEN_ASKED"]})
    yield running
    running.quit()


#: Program, size and scheme of the page that the browser shows; none before the first, and after a test that failed.
Shown = list[tuple[str, str, str]]


@pytest.fixture(scope="module")
def shown() -> Shown:
    return []


#: Makes of a page that an earlier test has used the page as it is when it is opened.
_AS_OPENED = """
document.activeElement.blur();
window.scrollTo(0, 0);
const colour = document.getElementById('colour');
colour.selectedIndex = 0;
colour.dispatchEvent(new Event('change'));
for (const chart of report.charts.charts) chart.canvas.dispatchEvent(new MouseEvent('dblclick'));
report.setCursor(Math.max(report.data.first, 0));
report.view('fit');
"""


@pytest.fixture
def show(
    browser: Any, shown: Shown, tmp_path: Path, request: pytest.FixtureRequest
) -> Iterator[Callable[..., dict[str, Any]]]:
    """Open the page of a program; at the end of the test there must have been no error and no request.

    Loading and first drawing take seconds without a graphics card: tests of one page stand together, and share it.
    """
    loaded = []

    def opened(name: str, size: str = "desktop", scheme: str = "light") -> dict[str, Any]:
        if shown == [(name, size, scheme)]:
            browser.execute_script(_AS_OPENED)
            settle(browser)
            return embedded(page_of(name))
        shown[:] = [(name, size, scheme)]
        loaded.append(name)
        (tmp_path / "r.html").write_text(page_of(name), "utf-8")
        assert (tmp_path / "r.html").stat().st_size < 5e6
        width, height = SIZES[size]
        screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": size == "phone"}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        browser.get((tmp_path / "r.html").as_uri())
        until(
            lambda: browser.execute_script("return document.body.dataset.ready") == "yes",
            "the page does not become ready",
        )
        return embedded(page_of(name))

    browser.get_log("browser")
    browser.get_log("performance")
    failed = request.session.testsfailed
    yield opened
    if request.session.testsfailed > failed:
        shown.clear()
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []
    asked = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    sent = [one["params"] for one in asked if one["method"] == "Network.requestWillBeSent"]
    # what the browser asks for by itself while it starts belongs to no page of ours
    urls = {one["request"]["url"] for one in sent if one["documentURL"].startswith("file:")}
    assert bool(urls) == bool(loaded)
    assert all(url.startswith(("file:", "data:", "blob:")) for url in urls)
    assert len(browser.window_handles) == 1


def until(holds: Callable[[], bool], failure: str) -> None:
    """Wait until something holds."""
    begin = time.monotonic()
    while not holds():
        assert time.monotonic() - begin < 90, failure
        time.sleep(0.05)


def js(browser: Any, script: str, *words: Any) -> Any:
    return browser.execute_script("return " + script, *words)


def cursor(browser: Any) -> int:
    return int(js(browser, "document.body.dataset.cursor"))


def press(browser: Any, *keys: str) -> None:
    """Press keys while no control has the focus."""
    js(browser, "document.activeElement.blur()")
    for key in keys:
        browser.find_element("tag name", "body").send_keys(key)


def pixels(browser: Any, name: str) -> np.ndarray:
    """What an element shows, RGB from 0 to 1."""
    import matplotlib.image

    settle(browser)
    with drawn(browser) if name in ("scene", "close") else nullcontext():
        raw = browser.find_element("id", name).screenshot_as_png
    return np.asarray(matplotlib.image.imread(io.BytesIO(raw)))[..., :3]


def canvas_pixels(browser: Any) -> np.ndarray:
    """The scene alone, RGBA from 0 to 1: alpha is 0 where nothing is drawn."""
    with drawn(browser):
        return read_scene(browser)


def read_scene(browser: Any) -> np.ndarray:
    """What was drawn of the scene last, as :func:`canvas_pixels`."""
    import matplotlib.image

    raw = js(browser, "document.getElementById('scene').toDataURL('image/png')").partition(",")[2]
    return np.asarray(matplotlib.image.imread(io.BytesIO(base64.b64decode(raw))))


def count_red(picture: np.ndarray) -> int:
    """Pixels in the colour of violations, outside of the corner with the triad."""
    picture = np.concatenate(
        [picture[:-110].reshape(-1, picture.shape[-1]), picture[-110:, 110:].reshape(-1, picture.shape[-1])]
    )
    return int(((picture[..., 0] > 0.7) & (picture[..., 1:3].max(axis=-1) < 0.3)).sum())


def test_stock_is_where_it_stands() -> None:
    [box] = embedded(page_of("pocket"))["scene"]["boxes"]
    assert box["stock"]
    assert np.allclose(box["middle"], [-5.0, 15.0, 50.0])
    assert np.allclose(box["half"], [35.0, 35.0, 10.0])
    [box] = embedded(page_of("klartext"))["scene"]["boxes"]  # BLK FORM, at the work offset
    assert np.allclose(box["middle"], [0.0, 0.0, 37.5])
    assert np.allclose(box["half"], [40.0, 30.0, 7.5])


# --- for everybody -----------------------------------------------------------------------------------

#: Texts whose contrast is below 4.5 (3 for large ones), as the guidelines for web content ask.
_LOW_CONTRAST = """
const number = text => text.match(/[\\d.]+/g).map(Number);
const light = rgb => {
  const [r, g, b] = rgb.slice(0, 3).map(v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const behind = element => {
  for (let at = element; at; at = at.parentElement) {
    const c = number(getComputedStyle(at).backgroundColor);
    if (c.length < 4 || c[3] > 0.9) return c;
  }
  return [255, 255, 255];
};
const low = [];
let seen = 0;
for (const element of document.querySelectorAll('body *')) {
  if (![...element.childNodes].some(node => node.nodeType === 3 && node.textContent.trim())) continue;
  if (!element.getClientRects().length || element.closest('.unseen') || element.tagName === 'SCRIPT') continue;
  const style = getComputedStyle(element), a = light(number(style.color)), b = light(behind(element));
  const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), size = parseFloat(style.fontSize);
  seen++;
  const asked = size >= 24 || size >= 18.66 && Number(style.fontWeight) >= 700 ? 3 : 4.5;
  if (ratio < asked) low.push([element.tagName, element.textContent.slice(0, 30), ratio]);
}
return [seen, low];
"""


def count_in_colour(picture: np.ndarray, rgb: tuple[float, float, float]) -> int:
    """Pixels whose hue is near to that of a colour, whatever the light on it."""
    picture = picture[picture[..., 3] > 0.5][:, :3]
    unit = picture / np.maximum(np.linalg.norm(picture, axis=-1, keepdims=True), 1e-9)
    return int((unit @ (np.array(rgb) / np.linalg.norm(rgb)) > 0.995).sum())


def test_fixtures_that_are_meshes_are_drawn(browser: Any, show: Callable[..., Any]) -> None:
    teal = (0.247, 0.612, 0.561)
    show("pocket")
    js(browser, "report.view('part')")
    without = count_in_colour(canvas_pixels(browser), teal)
    show("vise")
    js(browser, "report.view('part')")
    assert without == 0
    assert count_in_colour(canvas_pixels(browser), teal) > 20_000  # of half a million


#: Where a click meets the part where it is cut into, in the picture of the path.
_DEEP = """
const canvas = document.getElementById('scene');
for (let x = 4; x < canvas.clientWidth; x += 4) for (let y = 4; y < canvas.clientHeight; y += 4) {
  const found = report.scene.probe(x, y);
  if (found && found.value < -0.19) return [x, y];
}
"""


def test_the_part_shows_where_it_is_cut_and_a_click_leads_there(browser: Any, show: Callable[..., Any]) -> None:
    data = show("floor")
    js(browser, "report.view('part')")
    assert [option.text for option in browser.find_elements("css selector", "#body option")] == [
        "part, deviation",
        "stock that is left",
        "stock",
    ]
    x, y = browser.execute_script(_DEEP)
    press(browser, webdriver.Keys.HOME)
    canvas = browser.find_element("id", "scene")
    webdriver.ActionChains(browser).move_to_element_with_offset(
        canvas, x - canvas.size["width"] // 2, y - canvas.size["height"] // 2
    ).click().perform()
    assert data["line"][cursor(browser)] in (8, 9)
    said = browser.find_element("id", "probe").text
    assert re.fullmatch(r"there: cut into by 0\.(19\d|200) mm along the normal, line [89]", said)
    # the stock in its place
    browser.execute_script(
        "const body = document.getElementById('body'); body.value = 'stock'; body.dispatchEvent(new Event('change'));"
    )
    assert not browser.find_element("id", "part-legend").is_displayed()
    assert browser.execute_script(_DEEP) is None
    # the button of the finding leads to its line
    press(browser, webdriver.Keys.HOME)
    [button] = [one for one in browser.find_elements("css selector", "#findings button") if "VP218" in one.text]
    button.click()
    assert data["line"][cursor(browser)] in (8, 9)


@contextmanager
def on_paper(browser: Any) -> Iterator[None]:
    """The page as it is printed."""
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        js(browser, "window.dispatchEvent(new Event('beforeprint'))")
        yield
    finally:
        js(browser, "window.dispatchEvent(new Event('afterprint'))")
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_paper_is_white(browser: Any, show: Callable[..., Any]) -> None:
    show("travel", scheme="dark")
    for event, scheme in (("beforeprint", "light"), ("afterprint", "dark")):
        js(browser, "window.dispatchEvent(new Event(arguments[0]))", event)
        assert js(browser, "document.documentElement.dataset.theme") == scheme
        # scroll bars and lists have its colours too
        assert js(browser, "getComputedStyle(document.documentElement).colorScheme") == scheme


@pytest.mark.parametrize(("name", "size"), [("pocket", "desktop"), ("travel", "phone")])
def test_paper_has_the_whole_set_up_sheet(browser: Any, show: Callable[..., Any], name: str, size: str) -> None:
    """A4 has machine, set-up, findings and tiles, all inside its width, and nothing is stretched: first what is needed
    at the machine.
    """
    show(name, size)
    with drawn(browser), on_paper(browser):
        tops = js(
            browser,
            "['#verdict', '#sheet', '#findings', '#places', '#scene', '#charts', '#record', '#code'].map(s => "
            "document.querySelector(s).getBoundingClientRect().top)",
        )
        assert tops == sorted(tops)
        boxes = js(
            browser,
            "[...document.querySelectorAll('#findings li:not(.also), #places li, #sheet-parts > div, canvas, "
            "#code-lines div')].map(e => [e.getBoundingClientRect().toJSON(), e.width / e.height || 0])",
        )
        assert len(boxes) > 25
        # charts of many lanes have the paper's width, and others stand side by side: no row is half empty
        lanes = js(browser, "[...document.querySelectorAll('#charts .lanes')].map(e => e.clientWidth)")
        assert all(width > 0.9 * PAPER_WIDTH for width in lanes)
        for box, aspect in boxes:
            assert box["width"] > 20
            assert box["height"] > 10
            assert -1 <= box["left"] < box["right"] <= PAPER_WIDTH + 1
            # a canvas has whole pixels
            assert aspect == 0 or box["width"] / box["height"] == pytest.approx(aspect, rel=0.02)
        lines = len(PROGRAMS[name][0].splitlines())
        # a program of up to a hundred lines is printed whole, of a longer one the beginning
        assert len(browser.find_elements("css selector", "#code-lines div")) == (lines if lines < 100 else 50)
        # what a person needs at the machine is on the first page
        assert js(browser, "document.getElementById('places').getBoundingClientRect().bottom") < PAPER_HEIGHT
        sheet = browser.find_element("id", "sheet").text
        assert f"program {name}, {lines} lines" in sheet
        assert "SHA-256" not in sheet
        record = browser.find_element("id", "record").text
        assert "program, SHA-256" in record
        # the badge is white on its colour: it must not depend on whether backgrounds are printed
        for part in ("#verdict strong", "#findings li", *(["#reached i"] if name == "pocket" else [])):
            style = js(browser, f"getComputedStyle(document.querySelector('{part}')).printColorAdjust")
            assert style == "exact", part
        if name == "pocket":
            assert " path segments; " in record
        assert read_scene(browser)[..., :3].std() > 0.02  # the machine is drawn before the paper is taken
        # and copied: a browser may print the picture of the graphics card as a blank
        copied = browser.execute_script(
            "const c = document.getElementById('printed');"
            "const p = c.getContext('2d').getImageData(0, 0, c.width, c.height);"
            "return [getComputedStyle(c).display, c.clientWidth, new Set(new Uint32Array(p.data.buffer)).size]",
        )
        assert copied[0] == "block"
        assert copied[1] > 300
        assert copied[2] > 100


@pytest.mark.parametrize("word", ["Can run, with warnings, on assumed limits", "Can run, on limits of unknown source"])
def test_the_verdict_is_whole_on_a_phone(browser: Any, show: Callable[..., Any], word: str) -> None:
    show("pocket", "phone")
    badge = "document.querySelector('#verdict strong')"
    browser.execute_script(f"{badge}.textContent = arguments[0]", word)
    assert js(browser, f"{badge}.getBoundingClientRect().right") <= js(browser, "innerWidth")
    assert js(browser, f"{badge}.scrollWidth <= {badge}.clientWidth")


@pytest.mark.parametrize(
    ("name", "total", "kept"),
    [
        ("many", 3004, [*range(1, 51), *range(1501, 1510)]),
        ("tools", 397, [*range(1, 52), *range(88, 97)]),
        ("unreadable", 454, [*range(1, 51), *range(248, 258)]),
        ("clamp", 6, [*range(1, 7)]),
    ],
)
def test_paper_has_the_lines_that_are_asked_for(
    browser: Any, show: Callable[..., Any], name: str, total: int, kept: list[int]
) -> None:
    """Of a long program its beginning, changes of tools, stops and findings; it says so above them."""
    show(name)
    with on_paper(browser):
        shown = browser.find_elements("css selector", "#code-lines div")
        assert [int(one.get_attribute("data-line")) for one in shown] == kept
        said = browser.find_element("id", "left-out")
        assert said.is_displayed() == (len(kept) < total)
        if len(kept) < total:
            assert said.text == (
                f"Printed are {len(kept)} of {total} lines: the first 50, and those about changes of tools, stops and "
                "findings."
            )
            # above the first line: under the last one it may come to another page
            assert 0 <= min(one.rect["y"] for one in shown) - said.rect["y"] - said.rect["height"] < 40
        words = "[...document.querySelectorAll('#code-lines .word')].map(one => one.getClientRects().length)"
        assert set(js(browser, words)) <= {1}  # no line ends behind a minus


def test_pages_are_a4(browser: Any, show: Callable[..., Any]) -> None:
    show("travel")
    raw = base64.b64decode(browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})["data"])
    boxes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", raw)
    assert 2 <= len(boxes) <= 4
    for width, height in boxes:
        assert float(width) / 72 * 25.4 == pytest.approx(210.0, abs=0.5)
        assert float(height) / 72 * 25.4 == pytest.approx(297.0, abs=0.5)


def test_small_parts_share_the_width_of_paper_and_go_back(browser: Any, show: Callable[..., Any]) -> None:
    """The map of the workspace stands beside the shares of the feed rate, and lines that are short in three columns."""
    show("pocket")
    parents = "document.getElementById('workspace').parentElement.id"
    with on_paper(browser):
        assert js(browser, parents) == "side-by-side"
        left, right = js(
            browser,
            "['reached', 'workspace'].map(id => document.getElementById(id).getBoundingClientRect().toJSON())",
        )
        assert left["right"] < right["left"]
        assert right["top"] < left["bottom"]
        assert js(browser, COLUMNS) == "2"  # it has long remarks
    assert js(browser, parents) == "main"
    show("travel")  # it has no times
    with on_paper(browser):
        assert js(browser, parents) == "main"
    show("serial")
    with on_paper(browser):
        assert js(browser, COLUMNS) == "3"


def test_the_last_rows_of_a_table_stay_together(browser: Any, show: Callable[..., Any]) -> None:
    """A sum alone at the head of a page says nothing: wherever the page ends, two rows or more stand above it."""
    show("pocket")
    rule = "[...document.querySelectorAll('#governing tbody tr')].map(e => getComputedStyle(e).breakBefore)"
    with on_paper(browser):
        breaks = js(browser, rule)
        assert breaks[-3:] == ["avoid"] * 3
        assert len(breaks) < 6 or "auto" in breaks


def test_many_findings_are_few_on_the_screen_until_one_asks(browser: Any, show: Callable[..., Any]) -> None:
    show("many findings")
    shown_now = "[...document.querySelectorAll('#findings li')].filter(e => e.getClientRects().length).length"
    number = js(browser, "document.querySelectorAll('#findings li').length")
    assert number > 8
    assert js(browser, shown_now) == 6
    button = browser.find_element("id", "all-findings")
    assert button.text == f"show all {number} entries"
    button.click()
    assert js(browser, shown_now) == number


def test_a_finding_leads_to_its_place(browser: Any, show: Callable[..., Any]) -> None:
    data = show("travel")
    entries = browser.find_elements("css selector", "#findings button")
    told = [re.search(r"(?:VP101 error: slider \d \(|also )(rho\d)", entry.text) for entry in entries]
    assert [one and one[1] for one in told] == ["rho2", "rho3"]  # one cause, two places
    for entry, worst in zip(entries, (10, 8), strict=True):
        press(browser, "1")
        js(browser, "report.setCursor(0)")
        before = js(browser, "report.scene.camera.position.toArray()")
        entry.click()
        assert data["line"][cursor(browser)] == worst
        assert data["margin"][cursor(browser)] < 0
        assert entry.get_attribute("aria-current") == "true"
        assert np.linalg.norm(np.subtract(js(browser, "report.scene.camera.position.toArray()"), before)) > 100
        tip = js(browser, "report.scene.tipOnScreen()")
        assert np.abs(tip[:2]).max() < 0.05  # in the middle of the picture
        assert browser.find_element("css selector", "#readout .beyond").text.startswith("rho")
        assert count_red(pixels(browser, "scene")) > 50


@pytest.mark.parametrize(
    ("name", "size", "scheme"),
    [
        *(("travel", "desktop", "light"), ("travel", "desktop", "dark"), ("travel", "tablet", "light"),
          ("travel", "phone", "light")),
        *(("pocket", "phone", "light"), ("pocket", "tablet", "light"), ("pocket", "desktop", "dark"),
          ("pocket", "desktop", "light")),
    ],
)  # fmt: skip
def test_everybody_can_read_it(browser: Any, show: Callable[..., Any], name: str, size: str, scheme: str) -> None:
    """It fits its window, its texts and curves have contrast, and its controls have names."""
    show(name, size, scheme)
    assert js(browser, "document.documentElement.dataset.theme") == scheme
    seen, low = browser.execute_script(_LOW_CONTRAST)
    assert seen > 60
    assert low == []
    # curves too: 3 against the panel, as the guidelines ask of graphics
    ratios = browser.execute_script(
        _LOW_CONTRAST.split("const low")[0]
        + """
const panel = light(number(getComputedStyle(document.getElementById('machine')).backgroundColor));
return report.charts.charts.flatMap(c => c.series || []).map(s => {
  const x = light([1, 3, 5].map(k => parseInt(s.colour.slice(k, k + 2), 16)));
  return (Math.max(x, panel) + 0.05) / (Math.min(x, panel) + 0.05);
});
"""
    )
    assert len(ratios) > 5
    assert min(ratios) >= 3.0
    assert js(browser, "document.documentElement.scrollWidth - window.innerWidth") <= 0
    for label in ("#verdict strong", "#scene", "#transport"):
        assert browser.find_element("css selector", label).is_displayed()
    # the verdict is in the first screen, and so is the bar that moves the cursor
    for label in ("verdict", "transport"):
        box = js(browser, "document.getElementById(arguments[0]).getBoundingClientRect().toJSON()", label)
        assert 0 <= box["top"] < box["bottom"] <= SIZES[size][1] + 1, label
    # the bar covers nothing, wherever one scrolls to; findings have no window of their own
    assert js(browser, "getComputedStyle(document.getElementById('transport')).position") == "static"
    assert js(browser, "(e => e.scrollHeight - e.clientHeight)(document.getElementById('findings'))") <= 0
    assert (
        js(
            browser,
            "[...document.querySelectorAll('#places button')].filter(e => e.scrollWidth > e.clientWidth).length",
        )
        == 0
    )
    nameless = js(
        browser,
        "[...document.querySelectorAll('button, select, input, canvas, [role]')].filter(e => e.getClientRects().length"
        " && !(e.getAttribute('aria-label') || (e.labels && e.labels.length && e.labels[0].textContent.trim()) || "
        "e.textContent.trim())).map(e => e.outerHTML)",
    )
    assert nameless == []


# --- the cursor, on the pocket -----------------------------------------------------------------------


def test_worst_places_are_buttons_and_nothing_is_red_where_nothing_is_wrong(
    browser: Any, show: Callable[..., Any]
) -> None:
    show("pocket")
    press(browser, "2")
    assert count_red(canvas_pixels(browser)[..., :3]) == 0
    for entry in browser.find_elements("css selector", "#places button"):
        entry.click()
        assert cursor(browser) == int(entry.get_attribute("data-frame"))


def test_one_cursor_moves_everything(browser: Any, show: Callable[..., Any]) -> None:
    data = show("pocket")
    before = {name: pixels(browser, name) for name in ("scene", "close", "chart-speed", "slice")}
    js(browser, "(t => { t.value = 1500; t.dispatchEvent(new Event('input')); })(document.getElementById('time'))")
    settle(browser)  # the listing scrolls, and has new rows then
    assert cursor(browser) == 1500
    line = int(data["line"][1500])
    assert browser.find_element("css selector", "#code [aria-current=true]").get_attribute("data-line") == str(line)
    text = (SAMPLES / "pocket_3axis.nc").read_text().splitlines()[line - 1]
    assert text in browser.find_element("css selector", "#code [aria-current=true]").text
    assert f"line {line}" in browser.find_element("id", "clock").text
    shown = [row.text.split()[1] for row in browser.find_elements("css selector", "#readout tr")]
    assert np.abs(np.array(shown, dtype=float) - data["q"][1500]).max() <= 0.51e-3
    modal = browser.find_element("id", "modal").text
    assert "G54" in modal
    assert "T1, length 80 mm" in modal
    assert "12000/min clockwise" in modal
    for name, old in before.items():
        browser.execute_script("document.getElementById(arguments[0]).scrollIntoView()", name)
        now = pixels(browser, name)
        rows = min(len(now), len(old))  # a screenshot of half a pixel more or less has a row more or less
        assert np.abs(now[:rows] - old[:rows]).max() > 0.1, name
    # a click on a line leads to its first frame
    row = browser.find_element("css selector", "#code [data-line='20']")
    browser.execute_script("arguments[0].click()", row)
    assert cursor(browser) == int(np.flatnonzero(data["line"] == 20)[0])


def test_play_and_keys(browser: Any, show: Callable[..., Any]) -> None:
    data = show("pocket")
    line, last = data["line"], data["frames"] - 1
    browser.find_element("id", "play").click()
    until(lambda: cursor(browser) > 20, "it does not play")
    press(browser, " ")
    assert browser.find_element("id", "play").text == "play"
    stopped = cursor(browser)
    settle(browser)
    assert cursor(browser) == stopped
    press(browser, "\ue012")  # left
    assert cursor(browser) == stopped - 1
    press(browser, "\ue014", "\ue014")  # right
    assert cursor(browser) == stopped + 1
    press(browser, "\ue010")
    assert cursor(browser) == last
    press(browser, "[")  # to the first frame of this block
    assert line[cursor(browser)] == line[last]
    assert line[cursor(browser) - 1] != line[last]
    press(browser, "\ue011")
    assert cursor(browser) == 0
    # block by block through the whole program, none is left out: by key, then by button without a picture after each
    changes = np.flatnonzero(np.append(True, line[1:] != line[:-1]))
    assert len(changes) > 20
    for first in changes[1:5]:
        press(browser, "]")
        assert cursor(browser) == first
    passed = browser.execute_script(
        "return [...Array(arguments[0])].map(() => (document.getElementById('block-on').click(), "
        "Number(document.body.dataset.cursor)))",
        len(changes) - 4,
    )
    assert passed == [*changes[5:].tolist(), last]
    press(browser, "\ue011", "]")
    assert cursor(browser) == changes[1]
    for key, view in (("2", "part"), ("3", "top"), ("4", "front"), ("5", "tool"), ("1", "fit")):
        press(browser, key)
        assert browser.find_element("css selector", "#views [aria-pressed=true]").get_attribute("data-view") == view
    for scheme in ("dark", "light"):
        press(browser, "d")
        assert js(browser, "document.documentElement.dataset.theme") == scheme


# --- the scene, at last of the blade -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("pocket", "phone"),
        ("tilt", "tablet"),
        ("serial", "phone"),
        ("delta", "desktop"),
        ("fork", "desktop"),
        ("tricept", "desktop"),
        ("blade", "desktop"),
    ],
)
def test_the_whole_machine_is_in_every_view(browser: Any, show: Callable[..., Any], name: str, size: str) -> None:
    data = show(name, size)
    for frame in (0, data["frames"] // 2, data["frames"] - 1):
        for view in WHOLE_MACHINE:
            js(browser, "report.setCursor(arguments[0])", frame)
            js(browser, "report.view(arguments[0])", view)
            corners = np.array(js(browser, "report.scene.machineOnScreen()"))
            assert np.abs(corners[:, :2]).max() < 1.0, (view, frame)
            # and it is as large as the canvas allows
            assert np.abs(corners[:, :2]).max() > 0.6, (view, frame)
    # what the camera says is what is drawn: nothing touches the border, much is inside
    for view in WHOLE_MACHINE:
        js(browser, "report.view(arguments[0])", view)
        alpha = canvas_pixels(browser)[..., 3]
        assert max(alpha[0].max(), alpha[-1].max(), alpha[:, 0].max(), alpha[:, -1].max()) == 0.0, view
        assert (alpha > 0).mean() > 0.03, view  # long struts, seen along the tool, are thin
    js(browser, "report.view('part')")
    path = np.array(js(browser, "report.scene.pathOnScreen()"))
    assert np.abs(path[:, :2]).max() < 1.0
    assert canvas_pixels(browser)[..., :3].std() > 0.02


def test_the_machine_stands_where_the_kinematics_say(browser: Any, show: Callable[..., Any]) -> None:
    """The drawn tool ends where the path, carried by the drawn table, has its point; rods keep their length."""
    data = show("blade")
    for frame in (0, 700, data["frames"] - 1):
        js(browser, "report.setCursor(arguments[0])", frame)
        nose, tip = np.array(js(browser, "report.scene.toolEnds()"))
        assert np.linalg.norm(nose - tip) == pytest.approx(120.0, abs=1e-2)
        # the close-up has gone with it
        assert np.abs(js(browser, "report.scene.tipInCloseUp()")[:2]).max() < 0.9
        direction = -data["basis"][frame, 1]  # the tool hangs along the platform's z
        assert np.abs(nose + 120.0 * direction - tip).max() < 1e-2
    lengths = np.linalg.norm(data["rods"][:, :, 1] - data["rods"][:, :, 0], axis=-1)
    assert np.abs(lengths - [850, 850, 950, 950, 950, 950]).max() < 1e-2
    # sliders run on their guides
    for rod, guide in enumerate(data["scene"]["guides"]):
        low, high = np.array(guide["ends"])
        travel = data["q"][:, guide["joint"]] - data["joints"][guide["joint"]]["low"]
        along = (high - low) / np.linalg.norm(high - low)
        assert np.abs(low + travel[:, None] * along - data["rods"][:, rod, 0]).max() < 1e-2
    # the platform's joints do not move in it
    x, z = data["basis"][:, 0], data["basis"][:, 1]
    axes = np.stack([x, np.cross(z, x), z], axis=1)
    ends = data["platform"][:, None] + np.array(data["scene"]["joints"]) @ axes
    assert np.abs(ends - data["rods"][:, :, 1]).max() < 1e-2


def test_the_path_is_coloured_and_picked(browser: Any, show: Callable[..., Any]) -> None:
    data = show("blade")
    press(browser, "2")
    seen = []
    for kind in ("margin", "speed", "limit", "tool"):
        js(
            browser,
            "(s => { s.value = arguments[0]; s.dispatchEvent(new Event('change')); "
            "})(document.getElementById('colour'))",
            kind,
        )
        seen.append(canvas_pixels(browser))
        assert browser.find_element("id", "legend").text
    # one tool: the whole path has its colour, which no other scale has as a whole
    tool = [
        int((np.abs(picture[..., :3] - np.array([0x1C, 0x6D, 0xD0]) / 255).max(axis=-1) < 0.02).sum())
        for picture in seen
    ]
    assert tool[3] > 500
    assert max(tool[:3]) < 0.5 * tool[3]
    # a click on the path: the point under the tip is of the frame at the cursor
    js(browser, "report.setCursor(900)")
    at = js(browser, "report.scene.tipOnScreen()")
    width, height = js(
        browser, "[document.getElementById('scene').clientWidth, document.getElementById('scene').clientHeight]"
    )
    point = js(
        browser,
        "report.scene.pick(arguments[0], arguments[1])",
        (at[0] + 1) / 2 * width,
        (1 - at[1]) / 2 * height,
    )
    assert np.linalg.norm(data["trail.tip"][point] - data["tip"][900]) < 0.5
    assert js(browser, "report.scene.pick(5, 5)") == -1


def test_curves_are_drawn_with_every_peak(browser: Any, show: Callable[..., Any]) -> None:
    """A peak of one point between two frames is as high on the canvas as its value: the jerk of the blade touches 100
    per cent.
    """
    show("blade")
    drawn = js(
        browser,
        "report.charts.charts.map(c => [c.title, c.canvas.id = c.canvas.id || 'chart-' + c.title.slice(0, 4), "
        "c.bounds])",
    )
    assert any(title.startswith("Jerk") for title, _name, _bounds in drawn)
    for _title, name, _bounds in drawn:
        browser.execute_script("document.getElementById(arguments[0]).scrollIntoView()", name)
        assert pixels(browser, name).std() > 0.02, name


def test_every_joint_of_a_busy_chart_is_seen(browser: Any, show: Callable[..., Any]) -> None:
    """Five curves that turn back dozens of times have a lane each, in which nothing hides them; calm ones share one."""
    show("blade")
    lanes = {
        title: (name, drawn)
        for title, name, drawn in js(
            browser,
            "report.charts.charts.map(c => [c.title, c.canvas.id = c.canvas.id || 'chart-' + c.title.slice(0, 4), "
            "c.lanes])",
        )
    }
    assert not lanes["Velocity, % of limit"][1]
    name, drawn = lanes["Jerk, % of limit"]
    assert drawn
    browser.execute_script("document.getElementById(arguments[0]).scrollIntoView()", name)
    shown_now = pixels(browser, name)[34:-18]
    for k, colour in enumerate(
        ((0, 0x67, 0xA8), (0xB3, 0x6B, 0), (0, 0x7A, 0x55), (0xA6, 0x3D, 0x86), (0xC4, 0x49, 0))
    ):
        near = np.abs(shown_now - np.array(colour) / 255).max(axis=-1) < 0.06
        rows = np.flatnonzero(near.any(axis=1)) / len(shown_now)
        assert near.sum() > 200, k
        # all of it is in its own fifth of the height, to the width of a line
        assert k / 5 - 0.05 < rows.min(), k
        assert rows.max() < (k + 1) / 5 + 0.05, k


def test_zoom_by_wheel(browser: Any, show: Callable[..., Any]) -> None:
    show("blade")
    chart = browser.find_element("id", "chart-speed")
    browser.execute_script("arguments[0].scrollIntoView()", chart)
    before = pixels(browser, "chart-speed")
    browser.execute_script(
        "arguments[0].dispatchEvent(new WheelEvent('wheel', { deltaY: -1500, clientX: 300, bubbles: true, cancelable: "
        "true }))",
        chart,
    )
    zoomed = pixels(browser, "chart-speed")
    assert np.abs(zoomed - before).max() > 0.1
    browser.execute_script("arguments[0].dispatchEvent(new MouseEvent('dblclick'))", chart)
    assert np.abs(pixels(browser, "chart-speed") - before).max() < 0.01
    # by keys, about the cursor
    js(browser, "report.setCursor(700)")
    plain = pixels(browser, "chart-speed")
    for keys, changes in (("+++", True), ("--", True), ("-", False), ("+0", False)):
        press(browser, *keys)
        assert (np.abs(pixels(browser, "chart-speed") - plain).max() > 0.1) == changes, keys


# --- other programs ----------------------------------------------------------------------------------


def test_a_violation_without_a_margin_is_marked(browser: Any, show: Callable[..., Any]) -> None:
    """Below the table the margins of travel and singularity are large."""
    show("low")
    assert js(browser, "report.data.marginOf") == "travel, singularity"
    assert js(browser, "report.arrays.margin.every(value => value > 0.5)")
    told = "document.getElementById('now').textContent"
    assert "violationVP210 on this line" in js(browser, told)
    runs = js(browser, "report.charts.charts.find(one => /^Margin .travel, singularity., 0/.test(one.title)).runs")
    at = js(browser, "report.arrays.x[report.arrays.line.indexOf(4)]")
    assert [(run["colour"] is not None, run["from"]) for run in runs] == [(False, 0), (True, at)]
    js(browser, "report.setCursor(0)")
    assert "violation" not in js(browser, told)


def test_a_pose_out_of_reach_says_so(browser: Any, show: Callable[..., Any]) -> None:
    data = show("out of reach")
    js(browser, "report.setCursor(arguments[0])", data["frames"] - 1)
    assert browser.find_element("id", "unreached").is_displayed()
    js(browser, "report.setCursor(0)")
    assert not browser.find_element("id", "unreached").is_displayed()


def test_a_program_of_many_lines_has_few_rows_in_the_page(browser: Any, show: Callable[..., Any]) -> None:
    data = show("many")
    assert data["line"][cursor(browser)] in (1504, 1505, 1506)  # it opens at its worst place
    for frame in (0, 1000, data["frames"] - 1):
        js(browser, "report.setCursor(arguments[0])", frame)
        settle(browser)  # the listing scrolls, and has new rows then
        rows = browser.find_elements("css selector", "#code [data-line]")
        assert len(rows) < 80
        current = browser.find_element("css selector", "#code [aria-current=true]")
        assert current.get_attribute("data-line") == str(data["line"][frame])
    assert len(js(browser, "report.arrays['trail.frame']")) < 30_000


def test_of_a_very_long_text_there_are_the_lines_with_frames(
    browser: Any, show: Callable[..., Any], shown: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("verne_post.report.page.WHOLE_TEXT_BYTES", 1000)
    page_of.cache_clear()
    shown.clear()
    data = show("many")
    unread = embedded(page_of("unreadable"))
    page_of.cache_clear()
    shown.clear()
    # and those about the beginning and about each finding: else a program that cannot be read would show nothing
    near = {mark[0] + k for mark in [(1,), *data["marks"]] for k in range(-5, 6)}
    assert set(data["numbers"].tolist()) == {line for line in set(data["line"].tolist()) | near if line > 0}
    assert {252, 253} < set(unread["numbers"].tolist()) <= {*range(1, 7), *range(247, 259)}
    lines = ONE_IN_3000.split("\n")
    for frame in (0, 777, data["frames"] - 1):
        js(browser, "report.setCursor(arguments[0])", frame)
        line = int(data["line"][frame])
        shown = js(browser, "document.querySelector('#code [aria-current=true]').textContent")
        assert shown == f"{line} {lines[line - 1]}"


def test_a_refused_program_opens_on_the_cause(browser: Any, show: Callable[..., Any]) -> None:
    """The line of a wrong unit is the cause of all limits that it breaks. Else the first error is shown."""
    current = "document.querySelector('#code [aria-current=true]').textContent"
    show("inches")
    assert browser.find_element("css selector", "#findings li").text.startswith("line 1: VP505")
    assert js(browser, current) == "1 G20 G90"
    data = show("travel")
    assert cursor(browser) == data["first"] > 0
    assert js(browser, current).startswith("10 ")
    causes = js(browser, "document.querySelectorAll('#findings li:not(.also)').length")
    others = (
        "[...document.querySelectorAll('#findings .printed')].filter(e => e.checkVisibility()).map(e => e.innerText)"
    )
    assert js(browser, others) == []
    with on_paper(browser):  # all causes are printed, and where else in one sentence
        shown = js(browser, "[...document.querySelectorAll('#findings li')].filter(e => e.checkVisibility()).length")
        assert shown == causes > 0
        assert any(re.match(r"also .*lines? \d+", text) for text in js(browser, others))


def test_a_program_that_cannot_be_read_has_a_page(browser: Any, show: Callable[..., Any]) -> None:
    show("unreadable")
    assert "Refused" in browser.find_element("id", "verdict").text
    first, second, *_rest = browser.find_elements("css selector", "#findings button")
    assert re.match(r"line 252: VP\d+ error: .*\n252 \| G1 X$", first.text)  # the message says what is right
    assert "did you mean X20?" in second.text
    assert second.text.endswith("\n253 | G1 X2O")
    assert second.find_element("tag name", "mark").text == "X2O"
    current = browser.find_element("css selector", "#code [aria-current=true]")
    assert (current.text, current.is_displayed()) == ("252 G1 X", True)
    second.click()
    assert browser.find_element("css selector", "#code [aria-current=true]").text == "253 G1 X2O"
    assert not browser.find_element("id", "scene").is_displayed()
    # what stays has something in it
    for part in browser.find_elements("css selector", "h2, h3, section, footer"):
        text = part.text
        assert not part.is_displayed() or text.strip()
    shown_heads = [one.text for one in browser.find_elements("css selector", "h2, h3") if one.is_displayed()]
    assert shown_heads == [
        *("Set-up sheet", "Program and machine", "Tools", "Work offsets", "Fixtures and stock"),
        "Record of the conversion",
    ]
    sheet = browser.find_element("id", "sheet").text
    assert "not named 60 not given\nFrom the set-up: the program was not read to its end." in sheet


def test_nasty_texts_stay_texts(browser: Any, show: Callable[..., Any]) -> None:
    data = show("nasty")
    lines = NASTY_PROGRAM.split("\n")
    for frame in np.unique(data["line"], return_index=True)[1].tolist():
        js(browser, "report.setCursor(arguments[0])", frame)
        shown = js(browser, "document.querySelector('#code [aria-current=true]').textContent")
        assert shown == f"{data['line'][frame]} {lines[data['line'][frame] - 1].strip()}"
    assert js(browser, "document.querySelectorAll('img, a, form, iframe, [onmouseover]').length") == 0
    assert js(browser, "window.open('about:blank')") is None


# --- two programs --------------------------------------------------------------------------------------


def test_a_comparison_draws_both_on_one_scale(browser: Any, show: Callable[..., Any]) -> None:
    data = show("two")
    ends = [side["end"] for side in data["sides"]]
    assert ends[0] != ends[1]
    canvases = browser.find_elements("css selector", "#curves canvas")
    assert [one.get_attribute("aria-label").split(":")[0] for one in canvases] == ["A", "A", "B", "B"]
    pictures = []
    for k in (1, 3):
        browser.execute_script("arguments[0].id = 'curve'; arguments[0].scrollIntoView()", canvases[k])
        pictures.append(pixels(browser, "curve"))
        browser.execute_script("arguments[0].id = ''", canvases[k])
    drawn = [
        np.flatnonzero((np.abs(one - np.array([0x0B, 0x63, 0xC5]) / 255).max(axis=-1) < 0.1)[20:].any(axis=0))
        for one in pictures
    ]
    # the shorter one ends where its time is on the scale of the longer one
    width = drawn[1].max() - drawn[1].min()
    assert (drawn[0].max() - drawn[0].min()) / width == pytest.approx(ends[0] / ends[1], abs=0.02)
    for scheme in ("dark", "light"):
        press(browser, "d")
        assert js(browser, "document.documentElement.dataset.theme") == scheme
        assert (
            js(browser, "getComputedStyle(document.body).backgroundColor")
            == {"dark": "rgb(14, 19, 24)", "light": "rgb(243, 245, 247)"}[scheme]
        )


#: Lightness of a colour, as the contrast of texts is measured (WCAG 2).
_LIGHTNESS = """
const part = value => value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
return Shared.channels(Paths.colourOf(arguments[0])).map(value => part(value / 255))
  .reduce((sum, value, k) => sum + [0.2126, 0.7152, 0.0722][k] * value, 0);
"""


def test_a_comparison_shows_both_paths_with_both_tips_at_one_time(browser: Any, show: Callable[..., Any]) -> None:
    data = show("two", "tablet")
    end = max(side["end"] for side in data["sides"])
    at = 0.4 * end
    slider = "document.getElementById('time')"
    js(browser, f"[{slider}.value = 400, {slider}.dispatchEvent(new Event('input'))]")
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    lines = [data[f"{name}.line"][np.searchsorted(data[f"{name}.x"], at, side="right") - 1] for name in "ab"]
    assert browser.find_element("id", "clock").text == f"{at:.3f} s: A line {lines[0]}, B line {lines[1]}"
    pictures = {}
    for scheme in ("light", "dark"):
        lightness = [browser.execute_script(_LIGHTNESS, name) for name in "ab"]
        # in shades of grey the two differ too
        assert (max(lightness) + 0.05) / (min(lightness) + 0.05) > 2
        pictures[scheme] = picture = pixels(browser, "both")
        for name in "ab":
            colour = np.array(browser.execute_script("return Shared.channels(Paths.colourOf(arguments[0]))", name))
            assert (np.abs(picture - colour / 255).max(axis=-1) < 0.02).sum() > 300, (scheme, name)
        press(browser, "d")
    # another view is another picture, and the end of the shorter program is named
    browser.find_element("css selector", "[data-view=top]").click()
    js(browser, f"[{slider}.value = 1000, {slider}.dispatchEvent(new Event('input'))]")
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    assert np.abs(pixels(browser, "both") - pictures["light"]).max() > 0.3
    shorter = "AB"[int(np.argmin([side["end"] for side in data["sides"]]))]
    assert f"{shorter} ended" in browser.find_element("id", "clock").text


def test_a_refused_program_has_its_path_beside_the_other(browser: Any, show: Callable[..., Any]) -> None:
    """It has no times: the tip of the other one alone moves."""
    show("refused and not")
    assert js(browser, "[...document.querySelectorAll('#path-legend span')].map(e => e.textContent)") == [
        *("A, wide", "B, narrow", "rapids, dashed")
    ]
    assert browser.find_element("id", "clock").text.startswith("0.000 s: B line ")
    show("neither")  # the one cannot be read, the other one has a path
    assert len(browser.find_elements("css selector", "#path-legend span")) == 1


def test_a_comparison_on_paper_has_both_side_by_side(browser: Any, show: Callable[..., Any]) -> None:
    show("refused and not", "phone")
    with on_paper(browser):
        heads = browser.find_elements("css selector", "header .sides > div")
        assert [one.text.split()[-1] for one in heads] == ["Refused", "limits"]
        assert heads[0].rect["y"] == heads[1].rect["y"]
        for one in heads:
            assert "on VERNE" in one.text
        # findings are on the first page, above the picture
        tops = js(
            browser,
            "['[aria-label=\"what differs\"]', '[aria-label=findings]', '#paths', '#curves'].map(s => "
            "document.querySelector(s).getBoundingClientRect().top)",
        )
        assert tops == sorted(tops)
        both = js(browser, "document.getElementById('both').getBoundingClientRect().toJSON()")
        assert both["height"] == 240
        assert both["bottom"] < PAPER_HEIGHT
        assert js(browser, "getComputedStyle(document.querySelector('header strong')).printColorAdjust") == "exact"
        # nobody ticks paper, and the curves of both are to be compared
        assert not browser.find_element("id", "rapids").is_displayed()
        assert js(browser, "getComputedStyle(document.getElementById('curves')).breakInside") == "avoid"
    show("two", "phone")
    with on_paper(browser):  # below one another they did not fit below the paths: a page with a few lines came last
        tops = js(browser, "[...document.querySelectorAll('#curves .side')].map(e => e.getBoundingClientRect().top)")
        assert len(tops) == 2
        assert tops[0] == tops[1]


@pytest.mark.parametrize(
    ("name", "size", "scheme"),
    [("two", "phone", "dark"), ("refused and not", "tablet", "light"), ("neither", "desktop", "dark")],
)
def test_a_comparison_is_whole_and_readable(
    browser: Any, show: Callable[..., Any], name: str, size: str, scheme: str
) -> None:
    """Nothing is wider than the screen but tables that scroll, and every text has its contrast."""
    show(name, size, scheme)
    width = SIZES[size][0]
    assert js(browser, "document.documentElement.scrollWidth") <= width
    seen, low = browser.execute_script(_LOW_CONTRAST)
    assert seen > 20
    assert low == []
    for one in browser.find_elements("css selector", ".table"):
        assert one.get_attribute("tabindex") == "0"
        # a checksum is read, and compared, in one piece
        heights = js(browser, "[...arguments[0].querySelectorAll('.whole')].map(e => e.getClientRects().length)", one)
        assert set(heights) <= {1}
        if size == "phone":  # numbers stand below their names
            assert js(browser, "arguments[0].scrollWidth - arguments[0].clientWidth", one) <= 0
    assert js(browser, "document.querySelectorAll('img, a, form, iframe, [onmouseover]').length") == 0


def test_retracts_are_pale_and_out_of_the_frame(browser: Any, show: Callable[..., Any]) -> None:
    """The part fills the view of the path and the close-up, on screen and on paper, wherever the tool is."""
    data = show("retracted")
    tip, rapid = data["trail.tip"], data["trail.rapid"].astype(bool)
    # the retract is many times as high as what is cut
    assert np.ptp(tip[:, 2]) > 100.0
    assert np.ptp(tip[~rapid], axis=0) == pytest.approx([84.0, 24.0, 6.0], abs=0.1)
    box = np.array([[x, y, z] for x in (-42, 42) for y in (-12, 12) for z in (59, 65)])  # G54 is at z 60
    for frame, is_away in ((0, True), (data["frames"] // 2, False), (data["frames"] - 1, True)):
        js(browser, "(report.setCursor(arguments[0]), report.view('part'))", frame)
        path = np.array(js(browser, "report.scene.pathOnScreen()"))[:, :2]
        assert 0.6 < np.abs(path).max() < 1.0
        near = np.array(js(browser, "report.scene.inCloseUp(arguments[0])", box.tolist()))[:, :2]
        # the close-up shows a part of them, larger; while the tool is away, it and where it goes
        assert (np.ptp(near, axis=0).max() > 1.5 * np.ptp(path, axis=0).max()) != is_away
        assert np.abs(js(browser, "report.scene.tipInCloseUp()")[:2]).max() < 1.0
        assert np.abs(near).min(axis=0).max() < 1.0
    # the row of worst places stays whole on paper
    with on_paper(browser):
        assert js(browser, "getComputedStyle(document.getElementById('places')).breakInside") == "avoid"
    assert "rapid, thin and pale" in js(browser, "document.getElementById('legend').textContent")
    js(browser, "report.view('part')")
    with_rapids = canvas_pixels(browser)
    press(browser, "r")
    assert not js(browser, "document.getElementById('rapids').checked || report.scene.showsRapids()")
    assert (canvas_pixels(browser) != with_rapids).any()
    js(browser, "document.getElementById('rapids').click()")
    assert (canvas_pixels(browser) == with_rapids).all()
    with on_paper(browser):
        near = np.array(js(browser, "report.scene.inCloseUp(arguments[0])", box.tolist()))[:, :2]
        assert 0.6 < np.abs(near).max() < 1.0


def test_every_joint_has_its_own_colour(browser: Any, show: Callable[..., Any]) -> None:
    show("hexapod")
    for _theme in range(2):
        colours = js(browser, "report.data.joints.map((joint, k) => Shared.jointColour(k))")
        assert len(set(colours)) == len(colours) == 8
        press(browser, "d")


def test_the_table_does_not_hide_the_tip(browser: Any, show: Callable[..., Any]) -> None:
    """The eye of the close-up, of the path and of a place stands on the side of the table that the part is on."""
    data = show("over")
    tip = data["tip"][int(js(browser, "document.body.dataset.cursor"))]
    inside = (tip - [0, 0, 20]).tolist()  # towards the table
    above, below = js(browser, "report.scene.inCloseUp(arguments[0])", [tip.tolist(), inside])
    assert above[2] < below[2]
    for way in ("report.view('part')", "document.querySelector('#findings button').click()"):
        js(browser, way)
        eye = np.array(js(browser, "report.scene.camera.position.clone().sub(report.scene.tipInScene()).toArray()"))
        assert eye[1] > 0  # the table leans away from the front


def test_the_path_is_seen_through_a_large_cutter(browser: Any, show: Callable[..., Any]) -> None:
    """The path behind the cutter is seen, and the close-up is as wide as the cutter."""
    data = show("faced")
    # the eye stands at (0.7, -1.2, 0.7) and more: from here the cutter, 80 mm long, covers the corner at (-30, 15)
    frame = int(np.abs(data["tip"] - [-12.5, -15.0, 59.0]).sum(axis=1).argmin())
    assert np.abs(data["tip"][frame] - [-12.5, -15.0, 59.0]).max() < 3.0
    js(browser, "(report.setCursor(arguments[0]), report.view('part'))", frame)
    corner = np.array(js(browser, "report.scene.pathOnScreen()"))[2, :2]  # smallest x, largest y

    def look_at_corner() -> np.ndarray:
        picture = canvas_pixels(browser)
        row, column = np.round((corner * [1, -1] + 1) / 2 * picture.shape[1::-1]).astype(int)[::-1]
        return picture[row - 6 : row + 7, column - 6 : column + 7, :3]

    seen = look_at_corner()
    js(browser, "document.getElementById('solids').click()")
    without_cutter = look_at_corner()
    js(browser, "document.getElementById('solids').click()")
    assert np.abs(seen - without_cutter).max(axis=-1).min() > 0.05  # the cutter stands before it
    # blue on its yellow: the path is behind, not the cutter alone
    assert np.median(seen[..., 0]) - seen[..., 0].min() > 0.2
    tip = data["tip"][frame]
    sides = js(browser, "report.scene.inCloseUp(arguments[0])", [(tip + [x, 0, 0]).tolist() for x in (-25, 25)])
    assert np.abs(np.array(sides)[:, :2]).max() < 1.0


@pytest.mark.parametrize(("name", "view"), [("pocket", "part"), ("travel", "fit")])
def test_a_page_opens_with_the_path(browser: Any, show: Callable[..., Any], name: str, view: str) -> None:
    """A refused program opens with the machine, where the slider beyond its travel is red; paper always has it."""
    show(name)
    assert browser.find_element("css selector", "#views [aria-pressed=true]").get_attribute("data-view") == view
    if view == "part":  # with the stock about it
        path = np.array(js(browser, "report.scene.pathOnScreen()"))[:, :2]
        assert 0.5 < np.abs(path).max() < 1.0
    with on_paper(browser):
        assert np.abs(np.array(js(browser, "report.scene.machineOnScreen()"))[:, :2]).max() < 1.0


def test_a_table_beyond_its_travel_does_not_fill_the_close_up_with_red(browser: Any, show: Callable[..., Any]) -> None:
    show("tilt")
    assert count_red(pixels(browser, "scene")) > 50
    assert count_red(pixels(browser, "close")) < 50


def test_the_table_of_operations_breaks_few_names_and_no_tool_ends_a_page(
    browser: Any, show: Callable[..., Any]
) -> None:
    show("faced", "tablet")
    button = "document.querySelector('#operations button')"
    assert js(browser, f"{button}.textContent") == "without a remark"
    assert js(browser, f"{button}.getBoundingClientRect().height") < 45
    with on_paper(browser):
        assert js(browser, "getComputedStyle(document.querySelector('#operations .tool')).breakAfter") == "avoid"


@pytest.mark.parametrize(("size", "share"), [("desktop", 0.12), ("tablet", 0.17)])
def test_the_head_leaves_the_screen_to_the_machine(
    browser: Any, show: Callable[..., Any], size: str, share: float
) -> None:
    show("blade", size)
    height = js(browser, "document.querySelector('header').getBoundingClientRect().height")
    assert height < share * SIZES[size][1]


def test_tables_of_the_set_up_sheet_have_room(browser: Any, show: Callable[..., Any]) -> None:
    """Offsets name the file that gives them, whole."""
    show("offsets")
    wide = "[...document.querySelectorAll('#sheet-parts > div')].filter(e => e.scrollWidth > e.clientWidth)"
    assert js(browser, f"{wide}.map(e => e.textContent)") == []
    cell = "[...document.querySelectorAll('#sheet .wide td')].find(e => e.textContent === 'two_faces_of_it.nc.toml')"
    assert js(browser, f"{cell}.getBoundingClientRect().height") < 30


#: Draws the charts again; the texts that end beyond their canvas.
_CUT_TEXTS = """(() => {
const own = CanvasRenderingContext2D.prototype.fillText, cut = [], all = [];
CanvasRenderingContext2D.prototype.fillText = function (text, x, y, most) {
  all.push(text);
  const wide = Math.min(this.measureText(text).width, most ?? Infinity);
  if (this.textAlign === 'left' && x + wide > this.canvas.clientWidth) cut.push(text);
  own.apply(this, arguments);
};
report.charts.draw(0);
CanvasRenderingContext2D.prototype.fillText = own;
return [cut, all];
})()"""


def test_titles_of_charts_are_whole(browser: Any, show: Callable[..., Any]) -> None:
    """The longest of them names the red of violations."""
    show("travel", "phone")
    for _place in ("phone", "paper"):
        cut, texts = js(browser, _CUT_TEXTS)
        assert cut == []
        assert "Margin (travel, singularity), 0 at a limit; red: violation" in " ".join(texts)
        js(browser, "window.dispatchEvent(new Event('beforeprint'))")
    js(browser, "window.dispatchEvent(new Event('afterprint'))")


def test_times_of_operations_have_room_on_a_phone(browser: Any, show: Callable[..., Any]) -> None:
    """A long word in a name is broken before the last column is cut off."""
    show("retracted", "phone")
    assert js(browser, "(e => e.scrollWidth - e.clientWidth)(document.getElementById('operations'))") == 0
    heads = "[...document.querySelectorAll('#operations thead th')].filter(e => e.scrollWidth > e.clientWidth)"
    assert js(browser, f"{heads}.map(e => e.textContent)") == []
    # the texts of two cells of a row have a gap between them
    gaps = js(
        browser,
        """[...document.querySelectorAll('#operations tr')].flatMap(row => {
          const cells = [...row.cells].slice(1).map(cell => {
            const range = document.createRange(); range.selectNodeContents(cell);
            return range.getBoundingClientRect();
          }).filter(box => box.width);
          return cells.slice(1).map((box, k) => box.left - cells[k].right);
        })""",
    )
    assert min(gaps) >= 4
