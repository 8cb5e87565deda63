"""The report page in a real browser: no errors, no network, pictures that show something, one cursor through all of them."""

import json
import re
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.study import FRAMES, study

FOLDER = Path(__file__).resolve().parents[2] / "gcode_samples"
POCKET = (FOLDER / "pocket_3axis.nc", "--tool-length", 80, "--wcs", "G54=-10,15,60")
TRAVEL = (FOLDER / "violates_slider_travel.nc", "--tool-length", 50, "--wcs", "G54=0,0,420")
MACHINE = verne_post.load_machine()


def embedded(page: str) -> dict[str, Any]:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)
    assert found
    return json.loads(found[1].replace("<\\/", "</"))


# --- what is shown ---------------------------------------------------------------------------------


def test_frames_are_rows_and_extremes_are_not_lost() -> None:
    source = (FOLDER / "pocket_3axis.nc").read_bytes()
    options = Options(tool_length=80.0, wcs={1: WorkOffset((-10.0, 15.0, 60.0))})
    seen = study(source, MACHINE, options)
    rows = verne_post.convert(source, MACHINE, options).setpoints
    assert rows is not None
    assert len(seen.x) <= FRAMES + 1
    at = np.round(seen.x / 0.001).astype(int)
    assert np.allclose(seen.q, rows.values[at], rtol=1e-14, atol=1e-14)
    assert np.array_equal(seen.line, rows.line[at])
    assert (at[0], at[-1]) == (0, len(rows.values) - 1)
    for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1):
        whole = (
            np.abs(np.diff(np.pad(rows.values, ((3, 0), (0, 0)), mode="edge"), order, axis=0)).max(axis=0)
            / 0.001**order
        )
        assert np.allclose(np.abs(seen.extremes[name]).max(axis=0), whole, rtol=1e-9)
    lengths = np.linalg.norm(seen.rods[:, :, 1] - seen.rods[:, :, 0], axis=-1)
    assert np.abs(lengths - [850, 850, 950, 950]).max() < 1e-5  # rounded rows
    # the tool ends where the forward kinematics say, carried to the machine by hand
    nose_to_tip = np.linalg.norm(seen.nose - seen.platform, axis=1)
    assert np.abs(nose_to_tip).max() < 1e-9  # nose offset 0


def test_a_million_rows_are_few_frames() -> None:
    """10 minutes of motion at 1 ms: the frames, and the page with them, stay small."""
    source = b"G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X100 F10\nM2\n"
    seen = study(source, MACHINE, Options(tool_length=60.0))
    assert seen.summary is not None
    assert seen.summary.n_rows > 600_000
    assert len(seen.x) <= FRAMES + 1


@pytest.mark.parametrize("machine", ["serial", "linear_delta"])
def test_other_machines_have_a_page_too(tmp_path: Path, run: Callable[..., Any], machine: str) -> None:
    pytest.importorskip("plotly")
    answer = run("report", *POCKET, "--machine", machine, "-o", tmp_path / "r.html")
    assert answer.code == 0, answer.err
    data = embedded((tmp_path / "r.html").read_text("utf-8"))
    assert len(data["rods"][0]) == (3 if machine == "linear_delta" else 0)


def test_texts_of_the_program_cannot_become_markup(tmp_path: Path, run: Callable[..., Any]) -> None:
    pytest.importorskip("plotly")
    program = tmp_path / "<b>p.nc"
    program.write_text(
        "G21 G90\nG0 X0 Y0 Z50 A0 C0 ; </script><script>alert(1)</script>\nG1 X9 F900 (<img src=x>)\nM2\n"
    )
    assert run("report", program, "--tool-length", 60, "-o", tmp_path / "r.html").code == 0
    page = (tmp_path / "r.html").read_text("utf-8")
    assert "<script>alert" not in page
    assert "<img src=x>" not in re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert "<b>p.nc" not in page.split("<main>")[0]


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_a_static_picture(tmp_path: Path, run: Callable[..., Any], suffix: str) -> None:
    import matplotlib.image

    out = tmp_path / f"r{suffix}"
    for sample, code in ((POCKET, 0), (TRAVEL, 1)):
        assert run("report", *sample, "--static", out).code == code
        raw = out.read_bytes()
        assert run("report", *sample, "--static", out).code == code
        assert out.read_bytes() == raw
        if suffix == ".png":
            pixels = matplotlib.image.imread(out)
            assert pixels[..., :3].std() > 0.05
        else:
            assert raw.count(b"<path") > 20


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "say where to write"),
        (("--static", "r.gif"), "ends in .png or .svg"),
        (("-o", "no/r.html"), "the folder does not exist"),
    ],
)
def test_bad_options(run: Callable[..., Any], words: tuple[str, ...], said: str) -> None:
    answer = run("report", *POCKET, *words)
    assert answer.code == 2
    assert said in answer.err


# --- in a browser ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Debian's chromium without a screen; skipped where it is not installed (.ci/run installs it)."""
    webdriver = pytest.importorskip("selenium.webdriver")
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("needs chromium and chromedriver")
    options = webdriver.ChromeOptions()
    for argument in (
        "--headless=new", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
        "--disable-component-update", "--disable-sync", "--enable-unsafe-swiftshader", "--use-angle=swiftshader",
        "--window-size=1366,1600", f"--user-data-dir={tmp_path_factory.mktemp('profile')}",
    ):  # fmt: skip
        options.add_argument(argument)
    options.binary_location = chromium
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    running = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    running.set_script_timeout(60)
    yield running
    running.quit()


def opened(browser: Any, page: Path) -> None:
    browser.get(page.as_uri())
    begin = time.monotonic()
    while browser.execute_script("return document.body.dataset.ready") != "yes":
        assert time.monotonic() - begin < 90, "the page does not become ready"
        time.sleep(0.1)


def cursor(browser: Any) -> int:
    return int(browser.execute_script("return document.body.dataset.cursor"))


def pixels(browser: Any, name: str) -> np.ndarray:
    """What one of the figures shows."""
    import io

    import matplotlib.image

    element = browser.find_element("id", name)
    browser.execute_script("arguments[0].scrollIntoView()", element)
    time.sleep(0.3)
    return np.asarray(matplotlib.image.imread(io.BytesIO(element.screenshot_as_png)))[..., :3]


def errors(browser: Any) -> list[dict[str, Any]]:
    return [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]


def test_the_page_of_a_good_program(browser: Any, tmp_path: Path, run: Callable[..., Any]) -> None:
    pytest.importorskip("plotly")
    page = tmp_path / "r.html"
    assert run("report", *POCKET, "-o", page).code == 0
    assert page.stat().st_size < 10e6
    browser.get_log("performance")
    opened(browser, page)
    asked = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    urls = {one["params"]["request"]["url"] for one in asked if one["method"] == "Network.requestWillBeSent"}
    assert all(url.startswith(("file:", "data:", "blob:")) for url in urls), urls
    for name in ("path", "axes", "slice", "mechanism"):
        assert pixels(browser, name).std() > 0.02, name
    # the cursor moves everything
    before = pixels(browser, "mechanism")
    browser.execute_script(
        "const t = document.getElementById('time'); t.value = 1500; t.dispatchEvent(new Event('input'))"
    )
    time.sleep(0.5)
    assert cursor(browser) == 1500
    data = embedded(page.read_text("utf-8"))
    now = browser.find_element("id", "now").text
    assert f"line {data['line'][1500]}: {data['text'][str(data['line'][1500])]}" in now
    marker = browser.execute_script(
        "const d = document.getElementById('path').data[2]; return [d.x[0], d.y[0], d.z[0]]"
    )
    assert marker == pytest.approx(data["tip"][1500])
    shown = browser.execute_script("return document.getElementById('axes').layout.shapes.at(-1).x0")
    assert shown == pytest.approx(data["x"][1500])
    tool = browser.execute_script("const d = document.getElementById('mechanism').data[3]; return [d.x, d.y, d.z]")
    ends = np.array(tool, dtype=float).T
    assert np.linalg.norm(ends[2] - ends[1]) == pytest.approx(80.0, abs=1e-2)  # from nose to tip: the tool's length
    assert np.abs(pixels(browser, "mechanism") - before).max() > 0.1
    assert errors(browser) == []


def test_a_finding_leads_to_its_place(browser: Any, tmp_path: Path, run: Callable[..., Any]) -> None:
    pytest.importorskip("plotly")
    page = tmp_path / "r.html"
    assert run("report", *TRAVEL, "-o", page).code == 1
    opened(browser, page)
    entries = browser.find_elements("css selector", "#findings li")
    assert [re.search(r"VP101 error: (rho\d)", entry.text)[1] for entry in entries] == ["rho2", "rho3"]  # type: ignore[index]
    data = embedded(page.read_text("utf-8"))
    for entry, worst in zip(entries, (10, 9), strict=True):
        entry.click()
        assert data["line"][cursor(browser)] == worst
        assert data["margin"][cursor(browser)] < 0
    assert browser.execute_script("return document.getElementById('path')._fullData[1].x.length") > 0
    assert errors(browser) == []


def test_a_program_that_cannot_be_read_has_a_page(browser: Any, tmp_path: Path, run: Callable[..., Any]) -> None:
    pytest.importorskip("plotly")
    program, page = tmp_path / "p.nc", tmp_path / "r.html"
    program.write_text("G21 G90\nG1 X\nM2\n")
    assert run("report", program, "-o", page).code == 2
    opened(browser, page)
    assert "VP001" in browser.find_element("id", "findings").text
    assert errors(browser) == []
