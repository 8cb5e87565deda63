"""Machine files are found in a built wheel, in an editable install and in the source checkout."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from verne_post.cli.main import COMMANDS

#: Where the man page is, in the data of a wheel.
MAN = "data/share/man/man1/verne-post.1"
ROOT = Path(__file__).resolve().parents[1]
SHIPPED = sorted(path.name for path in (ROOT / "machine_configs").glob("*.toml"))

#: Prints where the package is, its machine files as "name=path" lines, and the default machine's name.
PROBE = """
import pathlib, verne_post
from verne_post.config import list_machine_files
print(pathlib.Path(verne_post.__file__).resolve().parent)
for name, path in list_machine_files().items():
    print(f"{name}={path}")
print(verne_post.load_machine().name)
"""


def probe(folder: Path, code: str, tmp_path: Path) -> tuple[Path, dict[str, Path], str]:
    """Run the probe in an interpreter that finds the package in a folder only."""
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], capture_output=True, text=True, env=environment, cwd=tmp_path, check=False
    )
    assert done.returncode == 0, done.stderr
    package, *files, machine = done.stdout.splitlines()
    return Path(package), {name: Path(path) for name, path in (line.split("=", 1) for line in files)}, machine


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """A wheel made with the project's own backend."""
    out = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(out), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=out, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (made,) = out.glob("*.whl")
    return made


@pytest.fixture(scope="module")
def unpacked(wheel, tmp_path_factory) -> Path:
    """The wheel, unpacked as pip would put it into site-packages."""
    site = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    return site


def test_machine_files_of_a_wheel(unpacked, tmp_path):
    package, files, machine = probe(unpacked, PROBE, tmp_path)
    assert package == unpacked.resolve() / "verne_post"
    assert sorted(path.name for path in files.values()) == SHIPPED
    assert "verne" in files
    assert machine == "VERNE"
    for path in files.values():
        assert path.is_relative_to(unpacked.resolve()), path
        assert path.read_bytes() == (ROOT / "machine_configs" / path.name).read_bytes()


def test_a_wheel_has_the_whole_package_and_nothing_else(wheel):
    """Every module and the typing marker are in; tests, programs and caches are not."""
    source = {p.relative_to(ROOT).as_posix() for p in (ROOT / "verne_post").rglob("*.py")} | {
        "verne_post/py.typed",
        "verne_post/output/codes.toml",
    }
    source |= {
        p.relative_to(ROOT).as_posix()
        for p in (ROOT / "verne_post/report").iterdir()
        if p.suffix in (".html", ".css", ".js")
    }
    source |= {p.relative_to(ROOT).as_posix() for p in (ROOT / "verne_post/output/machine_formats/kins").iterdir()}
    with zipfile.ZipFile(wheel) as archive:  # not the unpacked files: importing them adds caches
        inside = set(archive.namelist())
    assert source <= inside
    rest = {
        name for name in inside - source if not name.startswith(("verne_post/machine_configs/", "verne_post/rejected/"))
    }
    assert all(name.split("/")[0].endswith(".dist-info") for name in rest if not name.endswith(MAN)), rest


def test_the_wheel_has_the_man_page(wheel, tmp_path):
    """Where `man` finds it beside the command; it is made anew, and names every command."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(MAN))
        page = archive.read(name).decode("utf-8")
    assert name.split("/")[0].endswith(".data")
    assert page.startswith(".TH VERNE-POST 1")
    headings = {line.replace("\\-", "-") for line in page.splitlines() if line.startswith(".SS verne")}
    assert set(COMMANDS) == {line.split()[2] for line in headings}
    if shutil.which("man") is None:
        return
    manual = tmp_path / "share" / "man" / "man1" / "verne-post.1"
    manual.parent.mkdir(parents=True)
    manual.write_text(page, encoding="utf-8")
    (tmp_path / "bin").mkdir()
    environment = {**os.environ, "PATH": f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}", "LC_ALL": "C.UTF-8"}
    environment.pop("MANPATH", None)
    done = subprocess.run(
        ["man", "-P", "cat", "verne-post"], capture_output=True, text=True, env=environment, check=False, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert "--tool-length" in done.stdout and not done.stderr


def test_the_wheel_has_the_command(unpacked):
    (entry,) = unpacked.glob("*.dist-info/entry_points.txt")
    assert "verne-post = verne_post.__main__:run" in entry.read_text(encoding="utf-8")


def test_machine_files_of_the_source_checkout(tmp_path):
    package, files, machine = probe(ROOT, PROBE, tmp_path)
    assert package == ROOT / "verne_post"
    assert files["verne"] == ROOT / "machine_configs" / "verne.toml"
    assert sorted(path.name for path in files.values()) == SHIPPED
    assert machine == "VERNE"


def test_machine_files_of_an_editable_install(tmp_path):
    """A .pth file leads to the checkout; the backend also leaves a folder with a copy of the machine files.

    The copy has no __init__.py and goes stale, so it must not be the one that is found.
    """
    site = tmp_path / "site"
    stale = site / "verne_post" / "machine_configs"
    stale.mkdir(parents=True)
    (stale / "verne.toml").write_text("stale", encoding="utf-8")
    (site / "_editable.pth").write_text(f"{ROOT}\n", encoding="utf-8")
    # in front of what the test environment may have installed itself
    code = f"""
import site, sys
before = list(sys.path)
site.addsitedir({str(site)!r})
sys.path[:] = [entry for entry in sys.path if entry not in before] + before
{PROBE}"""
    package, files, machine = probe(tmp_path, code, tmp_path)
    assert package == ROOT / "verne_post"
    assert files["verne"] == ROOT / "machine_configs" / "verne.toml"
    assert machine == "VERNE"
