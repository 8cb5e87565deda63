"""Functions are verbs: one whose name begins with no verb fails."""

import ast
from pathlib import Path

import pytest

import verne_post

PACKAGE = Path(verne_post.__file__).parent

#: What a function may do. A predicate begins with the verb of its sentence: is, has, can.
WORDS = """
accept add address adjust agrees aim align allow amend append apply approach are arrive assemble assign assume average
begin bind blank blend bore bound bracket break build calibrate call can cap capitalise carry chamfer change check
choose claim classify clean climb close collect combine compare compensate compile complete compute connect convert
copy correct count cover cross cut decode decorate define depart depends derive describe differ differentiate displace
disturb divide draft draw drill drop dump dwell echo emit enclose encode end enter escape estimate evaluate exchange
execute exists expand expect explain extend factorise fair fetch fill find finish fit fits fix flatten flip flips flush
follow follows forget fork format freeze gather get give go goes group guard halve happens has hold holds identify
ignore improve index initialise insert interpolate interpret intersect invert invoke is iterate join judge jump keep keeps
know knows label lay lead leave lies lift limit linearise list load locate lock look lose lower make map mark match may
measure meet meets merge mill minimise mirror move multiply name names narrow need needs nest normalise normalize note
number open order orient pack pad paint parse pass peek perturb picture place plan polish predict prepare preset print
probe project propagate propose put quote raise rank rate reach reaches read ream rebuild recognise record reduce
refine reflect refresh refuse release reload remove renumber repair repeat replace replay report require resample reset
resolve restart restore retime retract return rotate round run sample save say scale scan search see seek select send
sends separate serve set settle shape share shift shorten show simulate sketch skip slice slow smooth solve sort space
span spell split spread stack stand stands start starts stay step stop store straighten strip study suggest sum
summarise suspend sweep switch take tap taper test thin tick tidy tilt touch trace transform translate trim truncate
try turn unpack update validate verify view wait waits wake warn watch weigh whiten widen work wrap write
"""
VERBS = frozenset(WORDS.split())
#: No functions by nature: an attribute that is computed, and a command that bears the name that its user types.
NAMED_OTHERWISE = {"property", "cached_property", "setter", "command", "group"}
#: Hooks that a library calls by these names, and a function that bears the name of its command.
HOOKS = {"_repr_html_", "shell_complete", "startswith", "endswith", "main", "machined"}
#: Names that programs outside rely on, and what builds an exception as a class would: ``raise at.error(...)``.
FIXED = {
    "inverse",
    "inverse_all",
    "forward",
    "forward_all",
    "changed",
    "to_csv",
    "to_dict",
    "to_pandas",
    "to_polars",
    "error",
}


def decorator_name(decorator: ast.expr) -> str:
    """The last part of a decorator's name: ``machine.command(...)`` is a command."""
    target = decorator.func if isinstance(decorator, ast.Call) else decorator
    return target.attr if isinstance(target, ast.Attribute) else target.id if isinstance(target, ast.Name) else ""


def names_without_verb(source: str) -> list[str]:
    """Names of the functions and methods of a source text that begin with no verb, inner ones too."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) or node.name.startswith("__"):
            continue
        if node.name in HOOKS | FIXED or NAMED_OTHERWISE & {decorator_name(one) for one in node.decorator_list}:
            continue
        if node.name.strip("_").split("_")[0] not in VERBS:
            found.append(node.name)
    return found


def test_every_function_begins_with_a_verb():
    found = [
        f"{path.relative_to(PACKAGE).as_posix()}: {name}"
        for path in sorted(PACKAGE.rglob("*.py"))
        for name in names_without_verb(path.read_text(encoding="utf-8"))
    ]
    assert not found, "functions are verbs; name what these do (or add a verb to WORDS)"


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("def find_roots(): ...", []),
        ("def _roots(): ...", ["_roots"]),
        ("class A:\n    def read(self): ...\n    def words(self): ...", ["words"]),
        ("class A:\n    @property\n    def words(self): ...\n    def __len__(self): ...", []),
        ("@machine.command('list')\ndef names(): ...", []),
        ("def find():\n    def inner(): ...", ["inner"]),
    ],
)
def test_names_are_judged_by_their_first_word(source, found):
    assert names_without_verb(source) == found
