"""Expressions against Python's own arithmetic, on trees that are printed both ways."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

SETTINGS = settings(max_examples=200, deadline=None, database=None, derandomize=True)


def value_of(view, expression, head=""):
    """What an expression comes to, by way of an X word; None with an error."""
    moves, findings = view(f"{head}G0 X[{expression}]\nM2", dialect="rs274")
    assert all(item.code in ("VP007", "VP025") for item in findings)
    return None if findings else float(moves.end[0, 0])


leaves = st.one_of(
    st.integers(-20, 20).map(lambda n: (str(n), str(n))),
    st.decimals(-9, 9, places=2).map(lambda d: (str(d), str(d))),
    st.sampled_from([("#1", "2.5"), ("#<a b>", "-3.0"), ("-#1", "(-2.5)"), ("##2", "2.5")]),
)
PYTHON = {
    "+": "({} + {})", "-": "({} - {})", "*": "({} * {})", "/": "({} / {})", "GT": "float({} > {})",
    "LT": "float({} < {})",
    "GE": "float({} >= {})", "LE": "float({} <= {})", "AND": "float(({} != 0) & ({} != 0))",
    "OR": "float(({} != 0) | ({} != 0))", "XOR": "float(({} != 0) != ({} != 0))", "MOD": "mod({}, {})",
}  # fmt: skip
FUNCTIONS = {
    "ABS": "abs({})",
    "SIN": "math.sin(math.radians({}))",
    "COS": "math.cos(math.radians({}))",
    "FIX": "math.floor({})",
    "FUP": "math.ceil({})",
    "SQRT": "math.sqrt({})",
    "ROUND": "math.copysign(math.floor(abs({0}) + .5), {0})",
}


def combined(children):
    binary = st.builds(
        lambda a, o, b: (f"[{a[0]} {o} {b[0]}]", PYTHON[o].format(a[1], b[1])),
        children,
        st.sampled_from(sorted(PYTHON)),
        children,
    )
    unary = st.builds(
        lambda f, a: (f"{f}[{a[0]}]", FUNCTIONS[f].format(a[1])), st.sampled_from(sorted(FUNCTIONS)), children
    )
    return binary | unary


@SETTINGS
@given(st.recursive(leaves, combined, max_leaves=8))
def test_trees(view, tree):
    written, python = tree
    try:
        names = {"math": math, "mod": lambda a, b: a - abs(b) * math.floor(a / abs(b))}
        wanted = float(eval(python, names))
    except (ZeroDivisionError, ValueError):
        wanted = None
    got = value_of(view, written, "#1=2.5 #2=1 #<AB>=-3\n")
    if wanted is None or got is None:
        assert got is None
        assert wanted is None or abs(wanted) > 1e20
    else:
        assert got == pytest.approx(wanted, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize(("expression", "wanted"), [
    ("1+2*3", 7), ("2*3**2", 18), ("2**3**2", 64), ("-2**2", 4), ("10-4-3", 3), ("24/4/2", 3), ("7 MOD 4*2", 6),
    ("1+1 EQ 2", 1), ("1 OR 0 AND 0", 0), ("3 GT 2 GT 1", 0), ("2*-3", -6), ("2--3", 5), ("+2", 2),
    ("5 NE 5.0000001", 0),
    ("5 EQ 5.00001", 0), ("ATAN[1]/[-1]", 135), ("ATAN[-1]/[0]", -90), ("ASIN[1]", 90), ("ACOS[-1]", 180),
    ("EXP[0]", 1),
    ("LN[EXP[2]]", 2), ("TAN[45]", 1), ("ROUND[2.5]", 3), ("ROUND[-2.5]", -3), ("FIX[-2.1]", -3), ("FUP[-2.1]", -2),
    ("-SIN[30]", -0.5), ("-[1+1]", -2), ("SQRT[ABS[-16]]", 4),
])  # fmt: skip
def test_precedence_and_functions(view, expression, wanted):
    assert value_of(view, expression) == pytest.approx(wanted, abs=1e-12)


def test_brackets_have_a_depth():
    from verne_post.gcode.expressions import MAX_NESTING, ValueReader
    from verne_post.gcode.program_error import ProgramError

    def read(depth):
        text = "[" * depth + "1" + "]" * depth
        return ValueReader(text, range(len(text) + 1), None).read_value("X")

    assert read(MAX_NESTING) == 1.0
    with pytest.raises(ProgramError, match="nested brackets"):
        read(MAX_NESTING + 1)
    with pytest.raises(ProgramError, match="nested brackets"):
        read(100_000)


def test_settings_of_a_block_come_after_its_values(moves_text):
    assert moves_text("#3=15\n#3=6 G0 X#3\nX#3\nM2") == ["2 rapid X15", "3 rapid X6"]


def test_fanuc_reads_expressions_its_own_way(view):
    moves, findings = view("#1=2+3*4\n#2=FIX[-2.5]\n#3=FUP[-2.5]\nG0 X#1 Y#2 Z#3\nM30", dialect="fanuc")
    assert findings == ()
    assert moves.end[0, :3].tolist() == [14.0, -2.0, -3.0]
