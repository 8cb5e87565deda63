"""The pictures of README and docs are those that their scripts make now."""

import re
import shutil
from pathlib import Path
from types import ModuleType

import pytest

from .builders import ROOT, load_maker

PICTURES = ROOT / "docs" / "pictures"


@pytest.fixture(scope="module")
def maker() -> ModuleType:
    pytest.importorskip("matplotlib")
    return load_maker("make_pictures")


@pytest.mark.parametrize("script", sorted(PICTURES.glob("[!_]*.py")), ids=lambda script: script.stem)
def test_a_picture_is_what_its_script_makes(maker: ModuleType, script: Path, tmp_path: Path) -> None:
    if "_browser" in script.read_text("utf-8"):
        pytest.importorskip("jupyter_threejs_sage")
        pytest.importorskip("selenium")
        if shutil.which("chromium") is None or shutil.which("chromedriver") is None:
            pytest.skip("needs chromium and chromedriver")
    assert maker.find_stale(script, tmp_path) == []


def test_every_picture_has_a_script(maker: ModuleType) -> None:
    """A picture that nothing makes goes stale unseen."""
    texts = "".join(script.read_text("utf-8") for script in PICTURES.glob("*.py"))
    texts += "".join(
        re.findall(r"\$PICTURES/\S+", "".join(page.read_text("utf-8") for page in PICTURES.parent.glob("*.md")))
    )
    names = [picture.name.replace("_dark.png", ".png") for picture in sorted(PICTURES.glob("*.png"))]
    assert [name for name in names if name not in texts] == []


def test_a_picture_of_other_numbers_is_stale(maker: ModuleType, tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    for name, slope in (("a.png", 1.0), ("b.png", 1.0), ("c.png", 0.6)):
        figure = Figure(figsize=(6.0, 4.0))
        figure.add_subplot().plot([0.0, 1.0], [0.0, slope], lw=2)
        figure.gca().set_ylim(0.0, 1.0)
        figure.savefig(tmp_path / name)
    assert maker.share_of_other_cells(tmp_path / "a.png", tmp_path / "b.png") == 0.0
    assert maker.share_of_other_cells(tmp_path / "a.png", tmp_path / "c.png") > 2 * maker.SHARE
