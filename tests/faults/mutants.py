"""Mutation testing by sample: one small change of the code at a time; does a test notice?

Run: python -m tests.faults.mutants [--mutants 150] [--seed 0] [--areas arcs,...] [--numbers 3,17] [--coverage FOLDER]
Works on a copy of the checkout (pip install coverage). The tests of each area run once, and coverage keeps which of
them run each line; with --coverage that is read from a folder that an earlier run on the same code has left. A change
swaps an operator or a comparison, negates a condition, or moves a number by one. The tests that run the changed line
are asked, the quickest of each file first; where it runs when the module is loaded, those that run another line of the
file. Each mutant is judged in a fork, which finds the libraries loaded and all other files compiled. The tests that
failed run again on the code as it is, where they must pass. Prints every verdict, and a table. A survivor is a missing
test, or a change that means the same: somebody has to look.
"""

import argparse
import ast
import compileall
import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from py_compile import PycInvalidationMode
from typing import Final
from xml.etree import ElementTree

from verne_post.cli import arithmetic

os.environ.update(arithmetic.choose_settings())  # before numpy is imported: once in the parent of all forks

import pytest
from hypothesis import Phase, settings

from tests.faults.trials import ROOT

#: Area -> files of the package, and tests that are asked.
AREAS: Final = {
    "kinematics": (("kinematics/**/*.py",), ("kinematics", "calibration")),
    "verification": (("verification/*.py",), ("verification", "cli/test_following.py", "cli/test_restart.py")),
    "arcs": (
        ("gcode/arcs.py", "gcode/plain_arcs.py", "gcode/machining/spatial_arc.py", "gcode/rs274/cycles.py",
         "gcode/*/*cycle*.py"),
        ("gcode",),
    ),
    "rows": (("trajectory/window_problem.py", "trajectory/row_limits.py", "trajectory/continuous.py"), ("trajectory",)),
    "machining": (("gcode/machining/*.py",), ("gcode",)),
    "chains": (("kinematics/chain/*.py", "kinematics/modules/*.py"),
               ("kinematics", "test_chains.py", "test_nutating.py")),
    # what numba compiles is not traced: accelerated.py and compiled_rays.py, which tests hold against the other path
    "part": (
        ("part/b*.py", "part/cl*.py", "part/compare.py", "part/cutting.py", "part/[d-z]*.py", "app/machined*.py"),
        ("part", "cli/test_machined.py", "cli/test_machined_stock.py"),
    ),
}  # fmt: skip
#: Tests of the whole pipeline, asked in every area.
COMMON: Final = ("test_samples.py", "test_metamorphic.py", "golden")
#: Of the tests that run the changed line those are asked, in that order, that take so long together, s; but at least so
#: many.
ASKED_S: Final = (6.0, 100.0)
LEAST: Final = 5
#: A change that makes tests run so many times longer than they are known to, and so long besides, s, is noticed.
LONGER: Final = 4.0
LONGEST: Final = 20.0

_SWAPS: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.LtE, ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And, ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip

#: No cache is written, and it is known that hypothesis was loaded before.
QUIET: Final = ("-p", "no:cacheprovider", "-W", "ignore::pytest.PytestAssertRewriteWarning")

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
class Asked:
    """Tests, and how long they may take, s."""

    tests: tuple[str, ...]
    longest: float


@dataclass(frozen=True)
class Mutant:
    """One changed file, and the tests to ask, the next ones where the first notice nothing."""

    name: str
    line: int
    what: str
    text: str
    asked: tuple[Asked, ...]


class Sampler:
    """Draws mutants, as many of each area, each change of its files equally likely and at most once."""

    def __init__(self, folder: Path, data: Path, areas: list[str], seed: int) -> None:
        from coverage import CoverageData

        self._package, self._areas, self._seed = folder / "verne_post", areas, seed
        self._data = CoverageData(no_disk=True)
        self._seconds = Counter[str]()
        for times in data.glob("*.xml"):
            part = CoverageData(str(times.with_suffix(".lines")))
            part.read()
            self._data.update(part)
            for case in ElementTree.parse(times).iter("testcase"):
                name = f"{case.attrib['classname']}.{case.attrib['name'].partition('[')[0]}"
                self._seconds[name] += float(case.attrib["time"])  # type: ignore[assignment]
        self._of_file = {str(Path(name)).rpartition("/verne_post/")[2]: name for name in self._data.measured_files()}

    def draw(self, number: int) -> Mutant:
        """The mutant of a number."""
        turn, area = divmod(number, len(self._areas))
        path, index = self._order(self._areas[area])[turn]
        tree = ast.parse(path.read_text("utf-8"))
        line, what, change = list(changes(tree))[index]
        change()
        name = str(path.relative_to(self._package))
        return Mutant(name, line, what, ast.unparse(ast.fix_missing_locations(tree)), self._asked(name, line))

    @cache  # noqa: B019 - one sampler a run
    def _order(self, area: str) -> list[tuple[Path, int]]:
        """File and index of every change of an area, in the order in which they are drawn."""
        files = sorted({path for pattern in AREAS[area][0] for path in self._package.glob(pattern)})
        every = [(path, at) for path in files for at, _ in enumerate(changes(ast.parse(path.read_text("utf-8"))))]
        random.Random(f"{area} {self._seed}").shuffle(every)
        return every

    def _asked(self, name: str, line: int) -> tuple[Asked, ...]:
        """Tests that run a line, or, where loading runs it or none does, any function of the file: to ask at first, and
        then.
        """
        lines = self._data.contexts_by_lineno(self._of_file[name]) if name in self._of_file else {}
        inside = _lines_in_functions(ast.parse((self._package / name).read_text("utf-8")))
        contexts = set(filter(_is_test, lines.get(line, ()) if line in inside else ()))
        contexts = contexts or {one for at in inside for one in lines.get(at, ()) if _is_test(one)}
        parts: list[list[str]] = [[], []]
        total, part = [0.0, 0.0], 0
        for context in self._order_of_tests(contexts):
            if total[part] + self._seconds[context] > ASKED_S[part] and len(parts[part]) >= LEAST:
                part += 1
                if part == len(parts):
                    break
            total[part] += self._seconds[context]
            parts[part].append(_node(context))
        return tuple(
            Asked(tuple(tests), LONGER * known + LONGEST) for tests, known in zip(parts, total, strict=True) if tests
        )

    def _order_of_tests(self, contexts: set[str]) -> list[str]:
        """The quickest test of each file, then the second ones: tests of one file often ask the same."""
        place, taken = dict[str, int](), Counter[str]()
        for context in sorted(contexts, key=lambda context: (self._seconds[context], context)):
            file = context.rpartition(".")[0]
            place[context] = taken[file]
            taken[file] += 1
        return sorted(place, key=lambda context: place[context])


def _lines_in_functions(tree: ast.AST) -> set[int]:
    """Lines that run when a function is called; all others run when the file is loaded, by whichever test does that."""
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return {line for node in functions for line in range(node.body[0].lineno, (node.end_lineno or 0) + 1)}


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
    numbers = [int(number) for number in given.numbers.split(",") if number] or range(given.mutants)
    with tempfile.TemporaryDirectory() as made_folder:
        folder = Path(made_folder)
        for name in ("verne_post", "tests", "machine_configs", "gcode_samples", "docs"):
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "CHANGELOG.md", "README.md"):
            shutil.copy(ROOT / name, folder)
        # by their contents: times would hide changes made within a second
        compileall.compile_dir(folder / "verne_post", quiet=1, invalidation_mode=PycInvalidationMode.CHECKED_HASH)
        data = (given.coverage or folder / "coverage").absolute()
        if not data.exists():
            _cover(folder, data, areas)
        sampler = Sampler(folder, data, areas, given.seed)
        drawn = [(number, sampler.draw(number)) for number in numbers]
        _load(folder, sorted({test for _number, mutant in drawn for asked in mutant.asked for test in asked.tests}))
        _judge(folder, areas, drawn)
    return 0


def _judge(folder: Path, areas: list[str], drawn: list[tuple[int, Mutant]]) -> None:
    """Print the verdict on each mutant, and the table."""
    made, killed, failed = Counter[str](), Counter[str](), set[str]()
    with suppress(KeyboardInterrupt):  # what was judged until then is told
        for number, mutant in drawn:
            path, begun = folder / "verne_post" / mutant.name, time.monotonic()
            good = path.read_text("utf-8")
            path.write_text(mutant.text, "utf-8")
            noticed = next(filter(None, (_notice(folder, asked) for asked in mutant.asked)), "")
            path.write_text(good, "utf-8")
            made[areas[number % len(areas)]] += 1
            killed[areas[number % len(areas)]] += bool(noticed)
            failed |= {noticed} if "::" in noticed else set()
            line = good.splitlines()[mutant.line - 1].strip()
            verdict = f"killed by {noticed}" if noticed else "survives"
            seconds = time.monotonic() - begun
            print(
                f"{number}: {mutant.name}:{mutant.line}: {mutant.what}: {line}: {verdict}: {seconds:.0f} s", flush=True
            )
    for test in sorted(failed):
        if _notice(folder, Asked((test,), 3600.0)):
            print(f"fails without any change: {test}; what it killed may live")
    print(f"{'area':<20} {'mutants':>8} {'killed':>7}")
    for area in areas:
        print(f"{area:<20} {made[area]:>8} {killed[area]:>7}")
    print(f"{'':<20} {made.total():>8} {killed.total():>7}")


def _cover(folder: Path, data: Path, areas: list[str]) -> None:
    """Run the tests of some areas, and keep which of them run each line, and how long each takes."""
    data.mkdir()
    files = "".join(f"\n    */verne_post/{pattern}" for area in areas for pattern in AREAS[area][0])
    rules = folder / "coveragerc"
    rules.write_text(f"[run]\ndynamic_context = test_function\ninclude = {files}\n", "utf-8")
    for name, tests in {**{area: AREAS[area][1] for area in areas}, "pipeline": COMMON}.items():
        words = [
            "-m",
            "coverage",
            "run",
            f"--rcfile={rules}",
            f"--data-file={data / name}.lines",
            "-m",
            "pytest",
            "-qx",
        ]
        words += [*QUIET, f"--junit-xml={data / name}.xml", *(f"tests/{test}" for test in tests)]
        environment = {**os.environ, "PYTHONPATH": str(folder)}
        if subprocess.run([sys.executable, *words], cwd=folder, env=environment, check=False).returncode:
            raise SystemExit("the tests fail on the code as it is")


class _Watcher:
    """Keeps the name of the test that fails; whoever wants to know only that it does needs no smaller example."""

    def __init__(self, folder: Path) -> None:
        self._told = folder / "failed"

    def pytest_sessionstart(self) -> None:
        """After the profile of conftest.py."""
        phases = (Phase.explicit, Phase.generate)
        settings.register_profile("unshrunk", parent=settings.get_profile("repeatable"), phases=phases)
        settings.load_profile("unshrunk")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """A test ends."""
        if report.failed:
            self._told.write_text(report.nodeid, "utf-8")


def _load(folder: Path, tests: list[str]) -> None:
    """Load the tests of a copy in this process: forks find the libraries loaded, and the tests compiled."""
    sys.path.insert(0, str(folder))
    os.environ["PYTHONPATH"] = str(folder)
    os.chdir(folder)
    _forget()
    if pytest.main(["--collect-only", "-qq", "--no-summary", *QUIET, *tests]):
        raise SystemExit("tests are not there: the coverage is of other code")
    _forget()
    sys.dont_write_bytecode = True
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"


def _forget() -> None:
    """Forget what is loaded of this program and its tests."""
    for name in [name for name in sys.modules if name.partition(".")[0] in ("verne_post", "tests")]:
        del sys.modules[name]


def _notice(folder: Path, asked: Asked) -> str:
    """The test that fails, or why none passes; "" where all do."""
    told = folder / "failed"
    told.unlink(missing_ok=True)
    fork = multiprocessing.get_context("fork").Process(target=_ask, args=(folder, asked.tests))
    fork.start()
    fork.join(asked.longest)
    late = fork.is_alive()
    with suppress(ProcessLookupError):
        os.killpg(fork.pid, signal.SIGKILL)  # with what the tests have started
    fork.join()
    if told.exists():
        return told.read_text("utf-8")
    return "time" if late else "an error while tests are loaded" if fork.exitcode else ""


def _ask(folder: Path, tests: tuple[str, ...]) -> None:
    """Run tests in this fork until one fails."""
    os.setsid()
    silent = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(silent, stream)
    os._exit(pytest.main(["-qx", *QUIET, *tests], plugins=[_Watcher(folder)]))


if __name__ == "__main__":
    sys.exit(main())
