"""The layer rule: which room may import which, who may import a solver, and how cheap the package is to import."""

import ast
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import verne_post

PACKAGE = Path(verne_post.__file__).resolve().parent
CHECKOUT = Path(__file__).resolve().parents[1]  # the installed package has no docs beside it

#: Lowest first. A file may import its own room and lower layers; rooms of one layer never see each other.
LAYERS = [
    {"base"},
    {"model"},
    {"part"},
    {"gcode", "toolpath", "kinematics", "trajectory", "verification"},
    {"config", "output"},
    {"calibration"},
    {"app"},
    {"report"},
    {"api", "cli"},
    {"__init__", "__main__"},
]
LEVEL = {room: level for level, rooms in enumerate(LAYERS) for room in rooms}
#: A solver and the only file that may import it.
SOLVERS = {"ruckig": "trajectory/ruckig_backend.py", "toppra": "trajectory/toppra_backend.py"}


def room_of(path: Path) -> str:
    """The room that a file belongs to: its folder, or its own name at the top."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def imports(path: Path) -> list[tuple[int, str]]:
    """(line, absolute dotted name) of everything that a file imports, wherever in the file it does so."""
    here = ["verne_post", *path.relative_to(PACKAGE).with_suffix("").parts]
    found: list[tuple[int, str]] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), filename=str(path))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, name.name) for name in node.names]
        elif isinstance(node, ast.ImportFrom):
            start = here[: -node.level] if node.level else []
            base = ".".join([*start, *([node.module] if node.module else [])])
            # "from verne_post import gcode" names a room by what it imports
            found += [(node.lineno, f"{base}.{name.name}") for name in node.names]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute):
            name = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
            if name in ("import_module", "__import__") and node.args and isinstance(node.args[0], ast.Constant):
                found.append((node.lineno, str(node.args[0].value)))
    return found


def target_room(name: str) -> str | None:
    """The room that an imported name lies in, None for names outside the package."""
    parts = name.split(".")
    if parts[0] != "verne_post":
        return None
    return parts[1] if len(parts) > 1 and parts[1] in LEVEL else "__init__"


FILES = sorted(PACKAGE.rglob("*.py"))


def test_every_file_has_a_place_in_the_rule():
    assert FILES
    assert {room_of(path) for path in FILES} - set(LEVEL) == set()


def test_imports_run_downwards():
    wrong = []
    for path in FILES:
        room = room_of(path)
        for line, name in imports(path):
            target = target_room(name)
            if target is None or target == room:
                continue
            if target == "__init__" and name.split(".")[-1] == "__version__":
                continue  # the number of the package itself, not a room
            if LEVEL[target] >= LEVEL[room]:
                wrong.append(f"{path.relative_to(PACKAGE.parent)}:{line}: {room} -> {target} ({name})")
    assert not wrong, "arrows that run the wrong way:\n" + "\n".join(wrong)


def files_imported(path: Path) -> set[Path]:
    """The files of the package that a file imports, wherever in the file it does so."""
    found = set()
    for _line, name in imports(path):
        parts = name.split(".")
        while len(parts) > 1 and parts[0] == "verne_post":
            place = PACKAGE.joinpath(*parts[1:])
            target = place.with_suffix(".py") if place.with_suffix(".py").is_file() else place / "__init__.py"
            if target.is_file():
                found.add(target)
                break
            parts.pop()
    return found - {path, PACKAGE / "__init__.py"}


def test_no_files_import_each_other_in_a_circle():
    graph = {path: files_imported(path) for path in FILES}
    state: dict[Path, str] = {}
    trail: list[Path] = []

    def visit(path: Path) -> list[Path]:
        state[path] = "open"
        trail.append(path)
        for target in sorted(graph[path]):
            if state.get(target) == "open":
                return [*trail[trail.index(target) :], target]
            if target not in state and (found := visit(target)):
                return found
        state[path] = "done"
        trail.pop()
        return []

    for path in FILES:
        circle = [] if path in state else visit(path)
        assert not circle, " -> ".join(str(one.relative_to(PACKAGE)) for one in circle)


def test_the_page_on_the_architecture_names_what_is_there():
    """Each row of "where to change what": the file exists and holds the name."""
    page = (CHECKOUT / "docs" / "architecture.md").read_text("utf-8")
    table = page.split("## Where to change what")[1].split("\n## ")[0]
    rows = [line.split("|")[2:4] for line in table.splitlines() if line.startswith("| ") and "`" in line]
    assert len(rows) > 120
    for file, name in rows:
        place = file.strip().strip("`")  # of the package as it is installed, or of the checkout
        text = ((PACKAGE.parent if place.startswith("verne_post/") else CHECKOUT) / place).read_text("utf-8")
        assert name.strip().strip("`") in text, f"{file.strip()} has no {name.strip()}"


def test_the_steps_of_changes_name_files_that_are_there():
    """Each path in "Changes in several files", but those of files to be made (NAME)."""
    page = (CHECKOUT / "docs" / "architecture.md").read_text("utf-8")
    steps = page.split("## Changes in several files")[1].split("\n## ")[0]
    places = [place for place in re.findall(r"`([\w.-]+/[\w./-]+\.\w+)`", steps) if "NAME" not in place]
    assert len(places) > 30
    for place in places:
        assert any((folder / place).is_file() for folder in (CHECKOUT, PACKAGE, PACKAGE / "gcode")), place
    text = "\n".join(
        path.read_text("utf-8") for folder in (PACKAGE, CHECKOUT / "tests") for path in folder.rglob("*.py")
    )
    names = {name for name in re.findall(r"`([A-Za-z_][\w.]+)(?:\(\))?`", steps) if "NAME" not in name}
    words = set(re.findall(r"\w+", text))
    files = (".toml", ".css", ".html", ".js", ".py")
    unknown = [name for name in names if not name.endswith(files) and not words.issuperset(name.split("."))]
    assert len(names) > 60 and not unknown, unknown


@pytest.mark.parametrize("solver", SOLVERS)
def test_only_its_backend_imports_a_solver(solver):
    users = {
        f"{path.relative_to(PACKAGE).as_posix()}:{line}"
        for path in FILES
        for line, name in imports(path)
        if name.split(".")[0] == solver
    }
    strangers = sorted(user for user in users if not user.startswith(SOLVERS[solver] + ":"))
    assert not strangers, f"{solver} is imported outside {SOLVERS[solver]}: {strangers}"


@pytest.mark.parametrize("room", ["base", "model"])
def test_the_lowest_rooms_do_no_input_or_output(room):
    """Only cli, output and config see files and the terminal.

    What columns keep in files is memory that nobody else sees; a process that is started leaves the streams alone.
    """
    for path in FILES:
        if room_of(path) == room:
            modules = {name.split(".")[0] for _line, name in imports(path)}
            if path.name == "columns.py":
                modules.discard("tempfile")
            if path.name == "team.py":
                modules -= {"os", "sys"}
            if path.name == "options.py":  # names of dialects are those of the files of their package
                modules.discard("pathlib")
            assert not modules & {"pathlib", "os", "sys", "io", "click", "tempfile", "subprocess"}, path


def loaded_after(statement: str) -> set[str]:
    """Top-level modules in a fresh interpreter after a statement."""
    code = f"import sys\n{statement}\nprint(*sorted({{name.split('.')[0] for name in sys.modules}}))"
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, cwd=PACKAGE.parent, check=True
    )
    return set(done.stdout.split())


HEAVY = {"numpy", "scipy", "msgspec", "click", "ruckig", "toppra", "matplotlib", "tomllib"}


def test_importing_the_package_is_cheap():
    loaded = loaded_after("import verne_post")
    assert "verne_post" in loaded
    assert not loaded & HEAVY


def test_public_names_are_found_on_use():
    loaded = loaded_after("import verne_post\nfor name in verne_post.__all__: getattr(verne_post, name)")
    assert "numpy" in loaded
    for name in verne_post.__all__:
        assert getattr(verne_post, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = verne_post.nothing


def test_the_rule_itself_sees_wrong_arrows(tmp_path, monkeypatch):
    """What the parser must notice: plain, from, relative, inside functions, under TYPE_CHECKING, by name."""
    folder = tmp_path / "verne_post" / "gcode" / "deep"
    folder.mkdir(parents=True)
    text = """
import verne_post.trajectory.sample
from verne_post.kinematics import checks
from verne_post import toolpath
from ...verification import verifier
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    from verne_post.app.result import Result
def late():
    from verne_post.output.rounding import round_setpoints
    importlib.import_module("verne_post.cli.main")
"""
    (folder / "bad.py").write_text(text, encoding="utf-8")
    monkeypatch.setattr(sys.modules[__name__], "PACKAGE", tmp_path / "verne_post")
    rooms = [target_room(name) for _line, name in imports(folder / "bad.py")]
    expected = ["trajectory", "kinematics", "toolpath", "verification", "app", "output", "cli"]
    assert sorted(room for room in rooms if room) == sorted(expected)
