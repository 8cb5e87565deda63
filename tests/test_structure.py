"""The structure of the package, read from its source: classes, private names, layout, the core's state."""

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
#: A list of fewer values reads well with one on a line, as the formatter writes it.
TABLE_VALUES = 20


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


def hold_table(node: ast.expr) -> bool:
    """Whether it is rows of data: TABLE_VALUES literals and names or more, and nothing that is executed for each."""
    if any(isinstance(part, ast.Lambda | ast.comprehension | ast.JoinedStr) for part in ast.walk(node)):
        return False
    return sum(isinstance(part, ast.Constant | ast.Name) for part in ast.walk(node)) >= TABLE_VALUES


def find_unformatted(source: str) -> list[int]:
    """Numbers of the lines that keep the formatter from something other than a table.

    A table stands at the top of a file or class, or gives the cases of a test.
    """
    tree = ast.parse(source)
    tables = set()
    for block in [tree, *(node for node in ast.walk(tree) if isinstance(node, ast.ClassDef))]:
        for node in block.body:
            values = [getattr(node, "value", None)] if isinstance(node, ast.Assign | ast.AnnAssign) else []
            values += [one for one in getattr(node, "decorator_list", ()) if "parametrize" in ast.unparse(one)]
            tables.update(value.end_lineno for value in values if value is not None and hold_table(value))
    return [
        token.start[0]
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT and "fmt:" in token.string and token.start[0] not in tables
    ]


def test_the_formatter_decides_but_for_tables():
    """Everything else has one layout; ruff holds the columns (E501), in tables too."""
    repository = Path(__file__).parents[1]
    files = [
        *PACKAGE.rglob("*.py"),
        *(path for part in ("tests", "docs") for path in (repository / part).rglob("*.py")),
    ]
    texts = {str(path): text for path in files if "fmt:" in (text := path.read_text(encoding="utf-8"))}
    assert {path: numbers for path, text in texts.items() if (numbers := find_unformatted(text))} == {}


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("X = [{numbers}]  # fmt: skip", []),
        ("class A:\n    X = dict(a=({numbers}))  # fmt: skip", []),
        ("@pytest.mark.parametrize('x', [{numbers}])  # fmt: skip\ndef test(): pass", []),
        ("X = 1  # fmt: skip", [1]),
        ("# fmt: off\nX = 1\n# fmt: on", [1, 3]),
        ("X = [lambda: ({numbers})]  # fmt: skip", [1]),
        ("def f():\n    return [{numbers}]  # fmt: skip", [2]),
    ],
)
def test_unformatted_lines_are_found(source, found):
    assert find_unformatted(source.format(numbers="1, " * TABLE_VALUES)) == found


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
    """Private names of other files that one uses: ``other._x`` of a name not given here, ``from other import _x``."""
    own = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    own |= {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and is_private(node.attr)
    }
    own |= {
        target.id
        for node in ast.walk(tree)
        for target in (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        if isinstance(target, ast.Name)
    }
    imported = [
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("verne_post")
        for alias in node.names
        if is_private(alias.name)
    ]
    used = [
        node.attr
        for node in ast.walk(tree)
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
