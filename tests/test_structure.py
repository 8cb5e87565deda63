"""The structure of the package, read from its source: classes, private names, lengths of prose, the core's state."""

import ast
import io
import tokenize
from functools import cache
from pathlib import Path

import pytest

import verne_post

PACKAGE = Path(verne_post.__file__).parent
#: Levels of classes of the package, and methods of one class itself.
MAX_LEVELS, MAX_METHODS = 3, 40
#: Columns of a line of prose, as of code.
MAX_COLUMNS = 120


#: Every file of the package, by its path in it.
FILES = sorted(path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py"))


@cache
def parse(file: str) -> ast.Module:
    """One of them."""
    return ast.parse((PACKAGE / file).read_text(encoding="utf-8"))


@cache
def classes() -> dict[str, list[ast.ClassDef]]:
    """All classes at the top of files, by name: a name may stand in several files."""
    found: dict[str, list[ast.ClassDef]] = {}
    for tree in map(parse, FILES):
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                found.setdefault(node.name, []).append(node)
    return found


def count_levels(name: str) -> int:
    """How many classes of the package stand on each other, with the one of this name at the end."""
    bases = [base.id for node in classes().get(name, []) for base in node.bases if isinstance(base, ast.Name)]
    return 1 + max((count_levels(base) for base in bases if base in classes() and base != name), default=0)


#: Names of the standard library that begin so.
_OF_PYTHON = {"_exit", "_replace", "_asdict"}


def is_private(name: str) -> bool:
    """One underscore at the beginning, and no name of Python's own."""
    return name.startswith("_") and not name.startswith("__") and name not in _OF_PYTHON


def find_long_prose(source: str) -> list[int]:
    """Numbers of the lines of docstrings, and of comments that stand alone, which are longer than MAX_COLUMNS."""
    lines = source.split("\n")
    if max(map(len, lines)) <= MAX_COLUMNS:
        return []
    prose = set()
    for node in ast.walk(ast.parse(source)):
        documented = isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        if documented and ast.get_docstring(node) is not None:
            prose.update(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT and not lines[token.start[0] - 1][: token.start[1]].strip():
            prose.add(token.start[0])
    return [number for number in sorted(prose) if len(lines[number - 1]) > MAX_COLUMNS]


def test_docstrings_and_comments_keep_to_the_columns():
    """The formatter wraps code, and ruff lets messages stay whole (E501); nothing else looks at prose."""
    found = {
        path.relative_to(PACKAGE).as_posix(): numbers
        for path in sorted(PACKAGE.rglob("*.py"))
        if (numbers := find_long_prose(path.read_text(encoding="utf-8")))
    }
    assert found == {}


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ('"""{}"""', [1]),
        ('def f():\n    """Short.\n\n    {}\n    """', [4]),
        ("x = 1\n#: {}\ny = 2", [2]),
        ('x = "{}"', []),
        ('x = "{}"  # a remark', []),
        ("class A:\n    # short\n    x = 1", []),
    ],
)
def test_long_prose_is_found(source, found):
    assert find_long_prose(source.format("w " * MAX_COLUMNS)) == found


def test_classes_have_few_levels():
    assert {name: levels for name in classes() if (levels := count_levels(name)) > MAX_LEVELS} == {}


def test_classes_have_few_methods():
    counts = {
        node.name: sum(isinstance(item, ast.FunctionDef | ast.AsyncFunctionDef) for item in node.body)
        for nodes in classes().values()
        for node in nodes
    }
    assert {name: count for name, count in counts.items() if count > MAX_METHODS} == {}


def find_foreign_names(tree: ast.Module) -> list[str]:
    """Private names of other files that one uses: ``other._x`` of a name it does not give itself, ``from other import _x``."""
    nodes = list(ast.walk(tree))
    own = {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    own |= {
        node.attr
        for node in nodes
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and is_private(node.attr)
    }
    own |= {
        target.id
        for node in nodes
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else [])
        if isinstance(target, ast.Name)
    }  # fmt: skip
    imported = [
        alias.name
        for node in nodes
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("verne_post")
        for alias in node.names
        if is_private(alias.name)
    ]
    used = [
        node.attr
        for node in nodes
        if isinstance(node, ast.Attribute) and is_private(node.attr) and node.attr not in own
    ]
    return imported + used


def test_no_private_name_is_used_from_another_file():
    assert {path: names for path in FILES if (names := find_foreign_names(parse(path)))} == {}


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("from verne_post.base import _x", ["_x"]),
        ("other._x()", ["_x"]),
        ("other._x()\ndef _x(): pass", []),
        ("self._x = 1\nother._x()", []),
        ("_x: int = 1\nother._x()", []),
        ("_x = 1\nother._x()", []),
        ("from numpy import _x\nother.x()", []),
    ],
)
def test_private_names_of_others_are_found(source, found):
    assert find_foreign_names(ast.parse(source)) == found


#: What is given before a program is executed; and the core's fast way through stretches of plain lines.
_OF_THE_CORE = {"gcode/start.py", "gcode/read.py", "gcode/initial_state.py", "gcode/plain.py"}


def test_only_the_core_writes_its_state():
    """Languages ask for an operation; what holds afterwards is the core's to say."""
    state = next(node for node in classes()["State"] if any(isinstance(item, ast.AnnAssign) for item in node.body))
    fields = {item.target.id for item in state.body if isinstance(item, ast.AnnAssign)} - {"modes"}
    written = []
    for path in FILES:
        if not path.startswith("gcode/") or path.startswith("gcode/machining/") or path in _OF_THE_CORE:
            continue
        for node in ast.walk(parse(path)):
            if isinstance(node, ast.Attribute | ast.Subscript) and isinstance(node.ctx, ast.Store):
                target = node.value if isinstance(node, ast.Subscript) else node
                if isinstance(target, ast.Attribute) and target.attr in fields:
                    holder = (
                        target.value.attr
                        if isinstance(target.value, ast.Attribute)
                        else getattr(target.value, "id", "")
                    )
                    if holder == "state":
                        written.append(f"{path}:{node.lineno} {target.attr}")
    assert written == []
