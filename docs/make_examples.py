"""Live report pages of the site, made of the samples while it is built: mkdocs calls this file as a hook (mkdocs.yml).

They are megabytes that one command makes, so they are not kept. Needs the extra docs.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from contextlib import chdir
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from verne_post.model.verdict import ExitStatus

if TYPE_CHECKING:
    from mkdocs.structure.files import Files

SAMPLES: Final = Path(__file__).resolve().parents[1] / "gcode_samples"
#: The other version of the blade: a higher feed rate, and a larger tolerance of corners.
CHANGES: Final = (("F2400", "F3600"), ("G64 P0.01", "G64 P0.05"))
#: Page of the site -> programs on it, and the exit status of the command.
EXAMPLES: Final = {
    "examples/blade.html": (("blade_5axis.nc",), ExitStatus.CLEAN),
    "examples/refused.html": (("violates_slider_travel.nc",), ExitStatus.VIOLATION),
    "examples/difference.html": (("blade_5axis.nc", "faster/blade_5axis.nc"), ExitStatus.CLEAN),
}
#: Only on the site: a report of a user has no pages beside it.
WAY_BACK: Final = '<a href="../report.html" style="color: inherit">to the documentation</a>'


@cache
def make_example(place: str) -> str:
    """Run the command in a folder of its own, where programs have short names."""
    programs, expected = EXAMPLES[place]
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        for name in programs:
            for suffix in ("", ".toml"):
                text = (SAMPLES / (Path(name).name + suffix)).read_text("utf-8")
                for old, new in CHANGES if name.startswith("faster/") else ():
                    text = text.replace(old, new)
                Path(name + suffix).parent.mkdir(exist_ok=True)
                Path(name + suffix).write_text(text, "utf-8")
        # in a process of its own, as a user does: numbers of the page have the last digit of those in the pictures
        command = [sys.executable, "-m", "verne_post", "report", *programs, "-o", "page.html", "--quiet"]
        status = subprocess.run(command, check=False).returncode
        if status != expected:
            raise RuntimeError(f"verne-post report {' '.join(programs)}: exit status {status}")
        return Path("page.html").read_text("utf-8").replace("</h1>", f"</h1>{WAY_BACK}", 1)


def on_files(files: Files, config: Any) -> Files:
    """Hook of mkdocs: add the pages."""
    from mkdocs.structure.files import File

    for place in EXAMPLES:
        files.append(File.generated(config, place, content=make_example(place)))
    return files
