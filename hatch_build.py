"""Build hook of wheels: the man page is made from the commands and goes to share/man/man1, where `man verne-post` looks
for it.
"""

import runpy
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class ManPage(BuildHookInterface):  # type: ignore[type-arg]
    """Makes the man page in a temporary folder, for as long as the wheel is built."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make the page, and name it as data of the wheel."""
        sys.path.insert(0, self.root)
        made = runpy.run_path(str(Path(self.root, "docs", "make_reference.py")))
        self.folder = Path(tempfile.mkdtemp())
        page = self.folder / "verne-post.1"
        page.write_text(made["man_page"](), encoding="utf-8")
        build_data["shared_data"][str(page)] = "share/man/man1/verne-post.1"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the folder."""
        shutil.rmtree(self.folder)
