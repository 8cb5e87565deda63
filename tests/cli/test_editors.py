"""`verne-post lsp` in real editors, with the configuration that docs/editors.md gives for each."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pygls", reason="needs the extra lsp")

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "docs" / "editors.md"
#: Room for a loaded machine, s; each step in the editor has a bound of its own.
PATIENCE = 300
SETUP = "tool_length = 120\nsplit_at_stops = true\n\n[wcs]\nG54 = [0, 0, 60]\n"
#: A tilt beyond the range of the table in line 7, and a subprogram.
PROGRAM = (
    "%\n"
    "O0001 (BRACKET)\n"
    "G21 G90 G94 G17 G40 G49 G80\n"
    "T1 M6 S900 M3\n"
    "(FACE)\n"
    "G43.4 H1 G0 X0. Y0. Z120. A0. C0.\n"
    "G1 A101. F2000.\n"
    "G1 A60.\n"
    "G0 Z160. A0.\n"
    "M98 P100\n"
    "M30\n"
    "O0100\n"
    "G1 Z150. F2000.\n"
    "M99\n"
    "%\n"
)
BARE = "T1 M6 S900 M3\nG43 H1\nG0 X0 Y0 Z90 A0 C0\nG1 X5 F500\nM2\n"


def find_block(heading: str, kind: str) -> str:
    """The configuration under a heading of the page."""
    section = PAGE.read_text("utf-8").partition(f"### {heading}")[2].partition("\n### ")[0]
    found = re.search(rf"```{kind}\n(.*?)```", section, re.DOTALL)
    assert found, f"docs/editors.md has no {kind} block under {heading}"
    return found[1]


def write_programs(folder: Path) -> tuple[Path, Path]:
    """A program with a set-up beside it, and one without."""
    part, bare = folder / "part.nc", folder / "bare.nc"
    part.write_text(PROGRAM, "utf-8")
    (folder / "part.nc.toml").write_text(SETUP, "utf-8")
    bare.write_text(BARE, "utf-8")
    return part, bare


def drive(folder: Path, *command: str) -> Any:
    """What an editor wrote down, started by a person with no files of their own, whose path has verne-post."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    homes = dict.fromkeys(("HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "XDG_DATA_HOME"), str(folder))
    answer = subprocess.run(
        [*command, "seen.json"],
        cwd=folder,
        env={**os.environ, **homes, "PATH": path},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
    return json.loads((folder / "seen.json").read_text("utf-8"))


def find_neovim() -> str:
    """The editor, new enough for the configuration of the page; a test is skipped without it."""
    path = shutil.which("nvim", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    version = path and subprocess.run([path, "--version"], capture_output=True, text=True, check=True).stdout
    number = version and re.match(r"NVIM v(\d+)\.(\d+)", version)
    if not path or not number or (int(number[1]), int(number[2])) < (0, 11):
        pytest.skip("Neovim 0.11 or newer is not installed")
    return path


def test_neovim_shows_findings_poses_and_lenses_and_applies_a_fix(tmp_path: Path) -> None:
    neovim = find_neovim()
    part, bare = write_programs(tmp_path)
    (tmp_path / "init.lua").write_text(find_block("Neovim", "lua"), "utf-8")
    script = str(HERE / "editors" / "neovim.lua")
    seen = drive(tmp_path, neovim, "--headless", "-u", "init.lua", "-l", script, str(part), str(bare))
    assert seen["filetype"] == "gcode"
    assert seen["diagnostics"] == [{"code": "VP102", "line": 7, "word": "A101."}]
    assert seen["refused"] == ["refused: 1 error, 0 warnings; the first in line 7"]
    assert re.search(r"^G1 A99\.\d+ F2000\.$", seen["mended"], re.MULTILINE)
    assert part.read_text("utf-8") == seen["mended"]
    # the cursor stands on the mended line
    assert "line 7: G1 A99" in seen["hover"] and "margin to its travel" in seen["hover"]
    assert [name.split("] ")[-1] for name in seen["symbols"]] == ["O0001", "tool 1", "FACE", "O0100"]
    assert seen["definition"] == 12
    assert '1 = { length = "measure" }' in seen["setup"]


def test_emacs_shows_findings_poses_and_symbols_and_applies_a_fix(tmp_path: Path) -> None:
    emacs = shutil.which("emacs")
    needed = (emacs or "", "--batch", "--eval", "(require 'eglot)")
    if emacs is None or subprocess.run(needed, capture_output=True, check=False).returncode:
        pytest.skip("Emacs with eglot is not installed")
    part, _bare = write_programs(tmp_path)
    (tmp_path / "init.el").write_text(find_block("Emacs", "elisp"), "utf-8")
    script = str(HERE / "editors" / "emacs.el")
    seen = drive(tmp_path, emacs, "--batch", "-l", "init.el", "-l", script, str(part))
    assert seen["mode"] == "gcode-mode"
    assert [(one["line"], one["word"], "VP102" in one["text"]) for one in seen["diagnostics"]] == [(7, "A101.", True)]
    assert "line 7: G1 A101" in seen["hover"] and "pose: refused" in seen["hover"]
    assert {"O0001", "tool 1", "FACE", "O0100"} <= set(seen["symbols"])
    assert re.search(r"^G1 A99\.\d+ F2000\.$", seen["mended"], re.MULTILINE)
    assert seen["definition"] == 12


STUBS = """
exports.workspace = { getConfiguration: () => ({ get: () => ["--machine", "serial"] }) };
exports.LanguageClient = class {
  constructor(name, server, client) { console.log(JSON.stringify([server, client.documentSelector])); }
  start() {}
};
"""


def test_the_extension_for_vs_code_starts_the_server_that_wrote_it(tmp_path: Path, run: Callable[..., Any]) -> None:
    """In node, where stubs stand for VS Code and for the client that npm installs."""
    folder = tmp_path / "new" / "extension"
    assert run("lsp", "--write-vscode", folder).code == 0
    package = json.loads((folder / "package.json").read_text("utf-8"))
    assert {*package["dependencies"]} == {"vscode-languageclient"}
    assert {".nc", ".mpf", ".h", ".cls"} <= {*package["contributes"]["languages"][0]["extensions"]}
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    for name in ("vscode.js", "vscode-languageclient/node.js"):
        file = folder / "node_modules" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(STUBS, "utf-8")
    script = f"require({json.dumps(str(folder / package['main']))}).activate()"
    told = subprocess.run([node, "-e", script], capture_output=True, text=True, check=True).stdout
    server, selector = json.loads(told)
    assert selector == [{"language": "gcode"}, {"pattern": "**/*.toml"}]
    command = [server["command"], *server["args"]]
    assert command == [sys.executable, "-m", "verne_post", "lsp", "--machine", "serial"]
    ended = subprocess.run(command, input=b"", capture_output=True, timeout=PATIENCE, check=False)
    assert (ended.returncode, ended.stdout) == (0, b""), ended.stderr
