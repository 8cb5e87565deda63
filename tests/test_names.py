"""Functions are verbs: one whose name begins with no verb fails. In the front end a participle has its noun:
kept_cycle.
"""

import ast
from pathlib import Path

import pytest

import verne_post

PACKAGE = Path(verne_post.__file__).parent

#: What a function may do. A predicate begins with the verb of its sentence: is, has, can.
WORDS = """
accept add address adjust advise agrees aim align allow amend append apply approach are arrive assemble assign assume
average begin bind blank blend bore bound bracket break build calibrate call can cap capitalise carry chamfer change
check choose claim classify clean climb close collect combine compare compensate compile complete compute connect
convert copy correct count cover cross cut decode decorate define depart depends derive describe differ differentiate
displace disturb divide draft draw drill drop dump dwell echo emit enclose encode end enter escape estimate evaluate
exchange execute exists expand expect explain extend factorise fair fetch fill find finish fit fits fix flatten flip
flips flush follow follows forget fork format freeze gather get give go goes group guard halve happens has hide hold
holds identify ignore improve index initialise insert interpolate interpret intersect invert invoke is iterate join
judge jump keep keeps know knows label lay lead leave lies lift limit linearise list load locate lock look lose lower
make map mark match may measure meet meets merge mill minimise mirror move multiply name names narrow need needs nest
normalise normalize note number open order orient pack pad paint parse pass peek perturb picture place plan plot polish
predict prepare preset print probe project propagate propose put quote raise rank rate reach reaches read ream rebuild
recognise recognize record reduce refine reflect refresh refuse release reload remove renumber repair repeat replace
replay report require resample reset resolve restart restore retime retract return rotate round run sample save say
scale scan search see seek select send sends separate serve set settle shape share shift shorten show simulate sketch
skip slice slow smooth solve sort space span spell split spread stack stand stands start starts stay step stop store
straighten strip study suggest sum summarise suspend sweep switch take tap taper test thin tick tidy tilt touch trace
transform translate trim truncate try turn unpack update validate verify view wait waits wake warn watch weigh whiten
widen work wrap write
"""
VERBS = frozenset(WORDS.split())
#: No functions by nature: an attribute that is computed, and a command that bears the name that its user types.
NAMED_OTHERWISE = {"property", "cached_property", "setter", "command", "group"}
#: Hooks that a library calls by these names, and functions that bear the names of their commands.
HOOKS = {"_repr_html_", "shell_complete", "startswith", "endswith", "readable", "readinto", "main", "machined", "batch"}
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


#: Participles that do not end in -ed.
IRREGULAR = frozenset(
    [
        "begun",
        "bent",
        "born",
        "bought",
        "bound",
        "broken",
        "brought",
        "built",
        "caught",
        "chosen",
        "cut",
        "dealt",
        "done",
        "drawn",
        "driven",
        "fallen",
        "felt",
        "flown",
        "forgotten",
        "found",
        "frozen",
        "given",
        "gone",
        "grown",
        "held",
        "hidden",
        "hung",
        "kept",
        "known",
        "left",
        "lent",
        "lit",
        "lost",
        "made",
        "meant",
        "met",
        "put",
        "risen",
        "said",
        "seen",
        "sent",
        "shaken",
        "shot",
        "shown",
        "shut",
        "slept",
        "sought",
        "spent",
        "split",
        "spoken",
        "spread",
        "stuck",
        "struck",
        "sung",
        "swept",
        "sworn",
        "taken",
        "taught",
        "thought",
        "thrown",
        "told",
        "torn",
        "understood",
        "worn",
        "wound",
        "woven",
        "written",
    ]
)
#: Words that look like participles and are none, or stand for more than one.
ALLOWED_ALONE = {
    "feed": "a noun",
    "infeed": "a noun",
    "speed": "a noun",
    "cut": "a noun: the piece that is cut off",
    "split": "a noun: a map taken apart",
    "bound": "a noun: a limit",
    "left": "an operand, beside right",
    "found": "what a function has found so far, and returns",
    "given": "what the words of a block give",
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


def is_lone_participle(name: str) -> bool:
    """Whether a name says in which state something is, and not what."""
    word = name.strip("_").lower()
    return word not in ALLOWED_ALONE and "_" not in word and (word in IRREGULAR or word.endswith("ed"))


def lone_participles(source: str) -> list[str]:
    """Variables, parameters, fields and properties of a source text that are a participle without a noun."""
    found = []
    for node in ast.walk(ast.parse(source)):
        name = ""
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            name = node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            name = node.attr
        elif isinstance(node, ast.arg):
            name = node.arg
        elif isinstance(node, ast.FunctionDef) and any("property" in decorator_name(d) for d in node.decorator_list):
            name = node.name
        if name and is_lone_participle(name):
            found.append(name)
    return found


def test_participles_of_the_front_end_have_a_noun():
    found = [
        f"{path.relative_to(PACKAGE).as_posix()}: {name}"
        for path in sorted((PACKAGE / "gcode").rglob("*.py"))
        for name in lone_participles(path.read_text(encoding="utf-8"))
    ]
    assert not found, (
        "kept_cycle, is_known, has_ended: say what is kept, known or ended (or give a reason in ALLOWED_ALONE)"
    )


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("held = 1", ["held"]),
        ("held_axis = 1", []),
        ("def place(moved): ...", ["moved"]),
        ("class A:\n    shared: int", ["shared"]),
        ("self._kept = {}", ["_kept"]),
        ("class A:\n    @property\n    def ended(self): ...", ["ended"]),
        ("use(held=1)", []),
        ("feed = 1", []),
    ],
)
def test_names_that_are_a_participle_alone(source, found):
    assert lone_participles(source) == found
