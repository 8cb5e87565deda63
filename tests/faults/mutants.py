"""Mutation testing by sample: one small change of the code at a time; does a test notice?

Run: python -m tests.faults.mutants [--mutants 150] [--seed 0] [--areas arcs,...] [--numbers 3,17] [--coverage FILE]
Works on a copy of the checkout (pip install coverage). The tests of each area run once, and coverage keeps which of them run
each line; with --coverage that is read from a file that an earlier run on the same code has left. A change swaps an operator or a comparison, negates a
condition, or moves a number by one. The tests that run the changed line are asked, the quickest first; where it runs when the module is
loaded, those that run another line of the file. Prints every survivor with its line, and a table. A survivor is a missing test, or a change that means the same: somebody has to look.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from tests.faults.trials import ROOT

#: Area -> files of the package, and tests that are asked.
AREAS: Final = {
    "kinematics": (("kinematics/**/*.py",), ("kinematics",)),
    "verification": (("verification/*.py",), ("verification", "cli/test_following.py")),
    "arcs": (
        ("gcode/arcs.py", "gcode/plain_arcs.py", "gcode/spatial_arc.py", "gcode/cycle_codes.py", "gcode/*/*cycle*.py"),
        ("gcode",),
    ),
    "rows": (("trajectory/window_problem.py", "trajectory/row_limits.py", "trajectory/section_rows.py"), ("trajectory",)),
}  # fmt: skip
#: Tests of the whole pipeline, asked in every area.
COMMON: Final = ("test_samples.py", "test_metamorphic.py", "golden")
#: Of the tests that run the changed line those are asked, the quickest first, that take so long together, s; but at least so many.
ASKED_S: Final = (6.0, 60.0)
LEAST: Final = 5
#: A change that makes the first tests run so long is noticed, s; the others take long by themselves.
LONGEST: Final = 300

_SWAPS: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE,
    ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip

Change = tuple[int, str, Callable[[], None]]


def changes(tree: ast.AST) -> Iterator[Change]:
    """Line, description and deed of every change of a file; types are no code."""
    types = {
        id(part)
        for node in ast.walk(tree)
        for note in (getattr(node, "annotation", None), getattr(node, "returns", None))
        if note is not None
        for part in ast.walk(note)
    }
    for node in ast.walk(tree):
        if id(node) in types:
            continue
        if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in _SWAPS:
            if isinstance(node.op, ast.BitOr) and isinstance(node.right, ast.Name | ast.Constant):
                continue  # a type
            other = _SWAPS[type(node.op)]
            yield (
                node.lineno,
                f"{type(node.op).__name__} -> {other.__name__}",
                lambda node=node, other=other: setattr(node, "op", other()),
            )
        if isinstance(node, ast.Compare) and type(node.ops[0]) in _SWAPS:
            other = _SWAPS[type(node.ops[0])]
            yield (
                node.lineno,
                f"{type(node.ops[0]).__name__} -> {other.__name__}",
                lambda node=node, other=other: node.ops.__setitem__(0, other()),
            )
        if isinstance(node, ast.If):
            yield (
                node.lineno,
                "condition negated",
                lambda node=node: setattr(node, "test", ast.UnaryOp(ast.Not(), node.test)),
            )
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            yield (
                node.lineno,
                f"{node.value} -> {node.value + 1}",
                lambda node=node: setattr(node, "value", node.value + 1),
            )


@dataclass(frozen=True)
class Mutant:
    """One changed file, and the tests to ask."""

    name: str
    line: int
    what: str
    text: str
    first: tuple[str, ...]
    then: tuple[str, ...]


class Sampler:
    """Draws mutants, each area's in proportion to what can be changed in its files."""

    def __init__(self, folder: Path, data: Path, areas: list[str], seed: int) -> None:
        from coverage import CoverageData

        self._folder, self._areas, self._pick = folder, areas, random.Random(seed)
        self._data = CoverageData(str(data))
        self._data.read()
        self._of_file = {str(Path(name)).rpartition("/verne_post/")[2]: name for name in self._data.measured_files()}
        self._seconds = Counter[str]()
        for case in ElementTree.parse(_times(data)).iter("testcase"):
            name = f"{case.attrib['classname']}.{case.attrib['name'].partition('[')[0]}"
            self._seconds[name] += float(case.attrib["time"])  # type: ignore[assignment]

    def draw(self, number: int) -> Mutant:
        """The mutant of a number; numbers are drawn in order."""
        package = self._folder / "verne_post"
        files = sorted(
            {path for pattern in AREAS[self._areas[number % len(self._areas)]][0] for path in package.glob(pattern)}
        )
        every = [
            (path, index) for path in files for index in range(len(list(changes(ast.parse(path.read_text("utf-8"))))))
        ]
        path, index = self._pick.choice(every)
        tree = ast.parse(path.read_text("utf-8"))
        line, what, change = list(changes(tree))[index]
        change()
        name = str(path.relative_to(package))
        return Mutant(name, line, what, ast.unparse(ast.fix_missing_locations(tree)), *self._asked(name, line))

    def _asked(self, name: str, line: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Tests that run a line, or one of its file: those to ask at first, and then."""
        lines = self._data.contexts_by_lineno(self._of_file[name]) if name in self._of_file else {}
        contexts = set(filter(_is_test, lines.get(line, ()))) or {
            one for some in lines.values() for one in some if _is_test(one)
        }
        parts: list[list[str]] = [[], []]
        total, part = 0.0, 0
        for context in sorted(contexts, key=lambda context: (self._seconds[context], context)):
            total += self._seconds[context]
            if total > ASKED_S[part] and len(parts[part]) >= LEAST:
                total, part = self._seconds[context], part + 1
                if part == len(parts):
                    break
            parts[part].append(_node(context))
        return tuple(parts[0]), tuple(parts[1])


def _times(data: Path) -> Path:
    """Where the times of the tests are, beside what each runs."""
    return data.with_name(f"{data.name}.xml")


def _is_test(context: str) -> bool:
    """Whether a context is a test function, and not one that a test makes."""
    return context.startswith("tests.") and ".test_" in context and "<" not in context


def _node(context: str) -> str:
    """``tests.gcode.test_arcs.test_it`` -> ``tests/gcode/test_arcs.py::test_it``."""
    module, _dot, function = context.rpartition(".")
    return f"{module.replace('.', '/')}.py::{function}"


def main() -> int:
    """Make and judge a sample."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mutants", type=int, default=150)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--areas", default=",".join(AREAS))
    parser.add_argument("--numbers", default="", help="judge only these of them")
    parser.add_argument("--coverage", type=Path, help="what an earlier run has left, or where to leave it")
    given = parser.parse_args()
    areas = given.areas.split(",")
    wanted = {int(number) for number in given.numbers.split(",") if number}
    made, killed = Counter[str](), Counter[str]()
    with tempfile.TemporaryDirectory() as made_folder:
        folder = Path(made_folder)
        for name in ("verne_post", "tests", "machine_configs", "gcode_samples", "docs"):
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "CHANGELOG.md", "README.md"):
            shutil.copy(ROOT / name, folder)
        data = (given.coverage or folder / "coverage").absolute()
        if not data.exists():
            _cover(folder, data, areas)
        sampler = Sampler(folder, data, areas, given.seed)
        drawn = [(number, sampler.draw(number)) for number in range(given.mutants)]
        drawn = [(number, mutant) for number, mutant in drawn if not wanted or number in wanted]
        asked = sorted({test for _number, mutant in drawn for test in (*mutant.first, *mutant.then)})
        if _notice(folder, ("--collect-only", *asked)):
            raise SystemExit(f"{data} names tests that are not there: it is of other code")
        with suppress(KeyboardInterrupt):  # what was judged until then is told
            for number, mutant in drawn:
                area, path = areas[number % len(areas)], folder / "verne_post" / mutant.name
                good = path.read_text("utf-8")
                path.write_text(mutant.text, "utf-8")
                noticed = bool(mutant.first) and _notice(folder, mutant.first, LONGEST) is not False
                noticed = noticed or (bool(mutant.then) and _notice(folder, mutant.then, LONGEST) is True)
                path.write_text(good, "utf-8")
                made[area] += 1
                killed[area] += noticed
                if not noticed:
                    line = good.splitlines()[mutant.line - 1].strip()
                    print(f"survives: {number}: {mutant.name}:{mutant.line}: {mutant.what}: {line}", flush=True)
    print(f"{'area':<20} {'mutants':>8} {'killed':>7}")
    for area in areas:
        print(f"{area:<20} {made[area]:>8} {killed[area]:>7}")
    print(f"{'':<20} {made.total():>8} {killed.total():>7}")
    return 0


def _cover(folder: Path, data: Path, areas: list[str]) -> None:
    """Run the tests of some areas, and keep which of them run each line."""
    settings = folder / "coveragerc"
    settings.write_text(
        f"[run]\nsource_pkgs = verne_post\ndata_file = {data}\ndynamic_context = test_function\n", "utf-8"
    )
    tests = [f"tests/{name}" for area in areas for name in AREAS[area][1]] + [f"tests/{name}" for name in COMMON]
    words = [
        "-m",
        "coverage",
        "run",
        f"--rcfile={settings}",
        "-m",
        "pytest",
        "-q",
        "-x",
        "-p",
        "no:cacheprovider",
        f"--junit-xml={_times(data)}",
    ]
    if subprocess.run([sys.executable, *words, *tests], cwd=folder, env=_environment(folder), check=False).returncode:
        raise SystemExit("the tests fail on the code as it is")


def _notice(folder: Path, tests: tuple[str, ...], longest: float | None = None) -> bool | None:
    """True where a test fails, None where they take too long."""
    words = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests]
    try:
        run = subprocess.run(
            words, cwd=folder, env=_environment(folder), capture_output=True, timeout=longest, check=False
        )
    except subprocess.TimeoutExpired:
        return None
    return run.returncode != 0


def _environment(folder: Path) -> dict[str, str]:
    """The copy goes before an editable install; compiled files would hide changes made within a second."""
    return {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}


if __name__ == "__main__":
    sys.exit(main())
