"""The fast readers of one line give what the exact one gives: the same words, the same numbers, columns that can be
found.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from verne_post.gcode import templates
from verne_post.gcode.block import build_block_of_words, read_exactly
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.templates import find_word_columns, read_by_template
from verne_post.gcode.words import split_words

SETTINGS = settings(max_examples=300, deadline=None, database=None, derandomize=True)


class Values:
    """Parameters of a test: #1 to #9 have values of every size."""

    def __init__(self, custom_macro=False):
        self.custom_macro = custom_macro

    def find_steps_of_word(self, letter):
        return 1000

    def read_value(self, key):
        if key not in range(1, 10):
            raise ProgramError("VP025", f"#{key}")
        return (0.0, 2.0, 3.0, -1.5, 1e-200, 1e200, 0.25, -7.0, 30.0, 1e29)[key]

    def exists(self, key):
        return key in range(1, 10)


numbers = st.sampled_from(
    ["0", "1", "2", "-3", "+.5", "5.", "12.75", "007", "1 2", "9" * 31, "0." + "0" * 32 + "1", "1.2.3", "--1", ".", ""]
)
operators = st.sampled_from(["+", "-", "*", "/", "**", " MOD ", " eq ", "GT", " AND ", "XOR", "OR", "LE"])
names = st.sampled_from(
    ["ABS", "SIN", "cos", "TAN", "FIX", "FUP", "ROUND", "SQRT", "EXP", "LN", "ASIN", "ACOS", "EXISTS"]
)
values = st.recursive(
    numbers
    | st.builds("#{}".format, st.sampled_from(["1", "2", "3", "4", "5", "6", "9", "0", "99", "1.5", "[1+1]", "#2"])),
    lambda inner: st.one_of(
        st.builds("[{}{}{}]".format, inner, operators, inner),
        st.builds("{}[{}]".format, names, inner),
        st.builds("-{}".format, inner),
        st.builds("ATAN[{}]/[{}]".format, inner, inner),
        st.builds("[{}]".format, inner),
    ),
    max_leaves=6,
)
words = st.builds("{}{}".format, st.sampled_from("GGMXYZACFSTPQRIJKLHDENO"), values)
lines = st.lists(
    words | st.builds("#{}={}".format, st.sampled_from(["1", "31", "1.2", "[2]", "#3"]), values), max_size=5
)
lines = st.tuples(
    st.sampled_from(["", "N10", " N5 ", "/", "N-1"]), lines, st.sampled_from(["", " ", "\t", "(c)", ";x"])
).map(lambda parts: parts[0] + parts[2].join(parts[1]))


def parts_of(block):
    """Codes, words and settings without columns, numbers as bits; and all columns in their order."""

    def bits(value):
        return np.float64(value).tobytes()

    columns = [
        *(at for _letter, _number, at in block.codes),
        *block.columns.values(),
        *(at for _key, _value, at in block.settings),
    ]
    codes = [(letter, bits(number)) for letter, number, _at in block.codes]
    given = {letter: bits(value) for letter, value in block.words.items()}
    return (codes, given, [(key, bits(value)) for key, value, _at in block.settings]), columns


@SETTINGS
@given(lines, st.booleans())
def test_templates_read_as_the_exact_reader_does(line, custom_macro):
    fast = read_by_template(line, Values(custom_macro))
    if fast is None:
        return
    exact = read_exactly(line, 1, Values(custom_macro))  # a line with an error is never read by a template
    (wanted, columns), (got, places) = parts_of(exact), parts_of(fast)
    assert got == wanted
    assert [find_word_columns(line)[-place - 1] for place in places] == columns


@SETTINGS
@given(lines)
def test_plain_words_become_the_block_of_the_exact_reader(line):
    table = split_words(1, line.encode() + b"\nX1\n")
    if not table.plain[0]:
        return
    mine = table.row == 0
    block = build_block_of_words(table.letter[mine].tobytes().decode(), table.value[mine].tolist(), 1)
    if block is None:
        return
    (wanted, columns), (got, places) = parts_of(read_exactly(line, 1, Values())), parts_of(block)
    assert got == wanted
    assert [find_word_columns(line)[-place - 1] for place in places] == columns


@pytest.mark.parametrize(
    "line",
    [
        "G1 X[1+#2] Y-#3",
        "N10 G1 X[#1*2+3/4-SIN[30]] F[#2]",
        "#1=5 #2=[#3 MOD 2]",
        "G1X#[1+1]Y##2",
        "G[1] X[1 LT 2]",
        "X-ATAN[1]/[2]",
    ],
)
def test_ordinary_lines_have_templates(line):
    assert read_by_template(line, Values()) is not None


@pytest.mark.parametrize("line", [
    "X[1/0]", "X#99", "X1 X2", "#1=1+1", "X[1e3]", "X[#5*#5]", "X" + "[" * 60 + "1" + "]" * 60, "X#<a>", "(MSG,x) X1",
    "G1 X[2**200]", "N[1] X1",
    "X1.2.3", "O1 X1", "X[1]2", "X1000" + "0" * 30, "%", "X?", "X\u00b2",
])  # fmt: skip
def test_the_rest_is_for_the_exact_reader(line):
    assert read_by_template(line, Values()) is None


def test_so_many_templates_are_kept(monkeypatch):
    monkeypatch.setattr(templates, "_MOST_KEPT", 20)
    for n in range(1, 60):
        assert read_by_template("X[1" + "+1" * n + "]", Values()).words["X"] == n + 1
    assert len(templates._templates) <= 20
