"""Mutation testing by sample: one small change of the code at a time, and the tests that should notice.

Run: python -m tests.faults.mutants [--mutants 30] [--seed 0] [--files inverse.py,...]
Works on a copy of the checkout. A change swaps an operator or a comparison, negates a condition, or moves a number. Prints every
survivor with its line, and a table. A survivor is a missing test, or a change that means the same: somebody has to look.
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
from pathlib import Path

from tests.faults.trials import ROOT

#: File of the package -> tests that should notice.
TARGETS = {
    "kinematics/modules/verne/inverse.py": ("kinematics/test_verne_module.py", "kinematics/test_verne_modes.py", "kinematics/test_round_trip.py"),
    "kinematics/five_axis.py": ("kinematics/test_five_axis.py", "kinematics/test_identities.py"),
    "verification/verifier.py": ("verification",),
    "verification/rows.py": ("verification",),
    "gcode/arcs.py": ("gcode/test_arcs.py", "gcode/test_reference.py"),
    "gcode/cycle_codes.py": ("gcode/test_cycles.py", "gcode/test_reference.py"),
    "trajectory/window_problem.py": ("trajectory/test_interior_point.py", "trajectory/test_continuous.py", "trajectory/test_window_problem.py"),
}  # fmt: skip
#: A change that makes tests run so long is noticed, s.
LONGEST = 600

_SWAPS: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE,
    ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip


def changes(tree: ast.AST) -> Iterator[tuple[int, str, Callable[[], None]]]:
    """Line, description and deed of every change of a file."""
    for node in ast.walk(tree):
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


def main() -> int:
    """Make and judge a sample."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mutants", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--files", default="")
    given = parser.parse_args()
    chosen = [name for name in TARGETS if not given.files or Path(name).name in given.files.split(",")]
    pick, made, killed = random.Random(given.seed), Counter[str](), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for name in ("verne_post", "tests", "machine_configs", "gcode_samples", "docs"):
            shutil.copytree(ROOT / name, Path(folder, name), ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "CHANGELOG.md", "README.md"):
            shutil.copy(ROOT / name, folder)
        for name in chosen:
            if _tests_notice(folder, TARGETS[name]):
                raise SystemExit(f"the tests of {name} fail, or take too long, on the code as it is")
        for number in range(given.mutants):
            name = chosen[number % len(chosen)]
            path = Path(folder, "verne_post", name)
            good = path.read_text("utf-8")
            tree = ast.parse(good)
            line, what, change = pick.choice(list(changes(tree)))
            change()
            path.write_text(ast.unparse(ast.fix_missing_locations(tree)), "utf-8")
            made[name] += 1
            if _tests_notice(folder, TARGETS[name]):
                killed[name] += 1
            else:
                print(f"survives: {name}:{line}: {what}: {good.splitlines()[line - 1].strip()}", flush=True)
            path.write_text(good, "utf-8")
    print(f"{'file':<40} {'mutants':>8} {'killed':>7}")
    for name in chosen:
        print(f"{name:<40} {made[name]:>8} {killed[name]:>7}")
    return 0


def _tests_notice(folder: str, tests: tuple[str, ...]) -> bool:
    words = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *(f"tests/{one}" for one in tests)]
    # the copy goes before an editable install
    environment = {**os.environ, "PYTHONPATH": folder}
    try:
        return (
            subprocess.run(
                words, cwd=folder, env=environment, capture_output=True, timeout=LONGEST, check=False
            ).returncode
            != 0
        )
    except subprocess.TimeoutExpired:
        return True


if __name__ == "__main__":
    sys.exit(main())
