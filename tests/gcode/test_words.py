"""The vectorised reader: numbers as float() reads them, words as a regular expression finds them, chunks."""

import re
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from verne_post.gcode import build_plain_setup, words
from verne_post.gcode.block import read_block
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.text import ProgramText

SETTINGS = settings(max_examples=120, deadline=None, database=None, derandomize=True)


def bits(value):
    """The 64 bits of a double: tells -0.0 from 0.0."""
    return struct.pack("<d", float(value))


@st.composite
def decimals(draw, most=20):
    """Decimal numbers as G-code writes them: sign, leading zeros, '.5', '5.', 1 to ``most`` digits."""
    digits = draw(st.text("0123456789", min_size=1, max_size=most) | st.integers(1, most).map("9".__mul__))
    point = draw(st.none() | st.integers(0, len(digits)))
    text = digits if point is None else f"{digits[:point]}.{digits[point:]}"
    return draw(st.sampled_from(["", "", "+", "-"])) + text


@st.composite
def spaced(draw, texts):
    """A text with blanks put between its characters."""
    text = draw(texts)
    gaps = draw(st.lists(st.sampled_from(["", "", "", " ", "\t", "  "]), min_size=len(text), max_size=len(text)))
    return "".join(gap + character for gap, character in zip(gaps, text, strict=True))


def plain_words(table):
    """Line, letter and value of the words of plain lines."""
    words = zip(table.row.tolist(), map(chr, table.letter), table.value.tolist(), strict=True)
    return [word for word in words if table.plain[word[0]]]


# --- numbers ---------------------------------------------------------------------------------


@SETTINGS
@given(st.lists(spaced(decimals()), min_size=1, max_size=8))
def test_numbers_are_bit_identical_to_float(texts):
    letters = "ABCDEFGH"
    lines = [f"{letter}{text}" for letter, text in zip(letters, texts, strict=False)]
    table = words.split_words(1, "\n".join(lines).encode())
    values = {row: value for row, _letter, value in plain_words(table)}
    for row, text in enumerate(texts):
        exact = float(re.sub(r"\s", "", text))
        n_digits = sum(character.isdigit() for character in text)
        assert table.plain[row] == (n_digits <= words.MAX_DIGITS)
        if table.plain[row]:
            assert bits(values[row]) == bits(exact)
        # longer numbers, and any others, are read the same by the exact reader
        assert bits(read_block(f"X{text}", 1).words["X"]) == bits(exact)


@pytest.mark.parametrize("text", [
    "0", "-0", "+0.", "-.0", ".5", "5.", "-.5", "+5.", "000123.4500", "0.1", "0.3", "4.35", "2.675", "1.005",
    "123456789012345", "0.00000000000001", "99999999999999.9", "-.000000000000001", "12345678.9012345",
    "000000000000001",
])  # fmt: skip
def test_numbers_of_up_to_fifteen_digits_are_read_fast_and_exactly(text):
    table = words.split_words(1, f"X{text}\n".encode())
    assert table.plain.tolist() == [True]
    assert bits(table.value[0]) == bits(float(text))


# --- words ----------------------------------------------------------------------------------


def by_regex(text):
    """Words of each line as (letter, value), None for a line that is not plain."""
    lines = text.split("\n")[: text.count("\n") + (not text.endswith("\n"))]
    number = r"[+-]?(?=\.?[0-9])[0-9]*\.?[0-9]*"
    found = []
    for line in lines:
        solid = "|".join(re.sub(r"[ \t\r]", "", part) for part in without_comments(line))
        words = [(letter.upper(), float(value)) for letter, value in re.findall(rf"([A-Za-z])({number})", solid)]
        short = all(len(re.sub(r"[^0-9]", "", w)) <= 15 for w in re.findall(r"[A-Za-z][^A-Za-z|]*", solid))
        found.append(words if re.fullmatch(rf"(?:[A-Za-z]{number}|\|)*", solid) and short else None)
    return found


def without_comments(line):
    """The parts of a line between its comments, one character after the other; damage stays where it is."""
    parts, rest = [""], line
    while rest:
        if rest[0] == ";":
            return [*parts, ""]
        inside = rest[1:].partition(")")[0]
        closed = rest[0] == "(" and ")" in rest and "(" not in inside
        if closed and not inside.lstrip(" \t").upper().startswith(("MSG", "DEBUG", "PRINT", "LOG", "ABORT", "PROBE")):
            parts.append("")
            rest = rest[len(inside) + 2 :]
        else:
            parts[-1] += rest[0]
            rest = rest[1:]
    return parts


LINES = st.lists(
    st.one_of(
        st.lists(st.tuples(st.sampled_from("GXYZACFNMgn"), spaced(decimals(8))).map("".join), max_size=5).map("".join),
        st.text("GXYaz0123456789+-. \t\r", max_size=12),
        st.text("GX01.-(;)#[%/é", max_size=8),
        st.lists(
            st.sampled_from(["X1", "G0", "(c)", "(", ")", ";", " ", "(MSG,", "( debug", "5", "."]), max_size=6
        ).map("".join),
    ),
    max_size=12,
)


@SETTINGS
@given(LINES, st.sampled_from(["\n", "\r\n"]), st.booleans())
def test_words_are_those_of_a_regular_expression(lines, newline, final):
    text = newline.join(lines) + (newline if final else "")
    if not text:
        return
    wanted = by_regex(text)
    table = words.split_words(7, text.encode())
    assert (table.first_line, table.n_lines) == (7, len(wanted))
    assert table.plain.tolist() == [words is not None for words in wanted]
    read = [(row, letter, bits(value)) for row, letter, value in plain_words(table)]
    assert read == [(row, *w[:1], bits(w[1])) for row, line in enumerate(wanted) for w in line or ()]


@pytest.mark.parametrize("line", [
    "X", "X+", "X-", "X.", "X-.", "X1.2.3", "X1-2", "X--1", "X+-5", "XY1", "5", "5X1", ".X1", "-X1", "G0 X1 (c",
    "X(c)1", "X1(c)5",
    "#1=2", "X#1", "X[1]", "/X1", "%", "X1,5", "X1\u00e9", "X1\x00", "G0 X1 Y", "@1", "X1e", "X1234567890123456",
    "X0.0000000000000001",
])  # fmt: skip
def test_what_is_not_plain_is_flagged(line):
    """Neighbours of a damaged line are read as if it were not there."""
    table = words.split_words(1, f"G1 X2\n{line}\nY3\n".encode())
    assert table.plain.tolist() == [True, False, True]
    assert plain_words(table) == [(0, "G", 1.0), (0, "X", 2.0), (2, "Y", 3.0)]
    assert words.split_words(1, line.encode()).plain.tolist() == [False]


@pytest.mark.parametrize(
    "line", ["", " ", "\t\r", "X1", "x1", "x 1 . 5", "N1G0X1", "X1Y2 X3", "X1 (c) Y2", "X1;c", "(a)(b;)X1;(", "(c)"]
)
def test_what_is_plain(line):
    assert words.split_words(1, f"5\n{line}\n5\n".encode()).plain.tolist() == [False, True, False]


# --- chunks -----------------------------------------------------------------------------------

TEXT = "G1 F100\nX1\n\nY2.5 (a comment longer than most chunks)\r\nX3Y4\n%\nZ5\nX6"


@pytest.mark.parametrize("size", [1, 2, 3, 5, 8, 13, 30, 64, 1000])
@pytest.mark.parametrize("source", [TEXT, TEXT + "\n", "", "\n", "\n\n", "X1", "X1\n", "\r\n"])
def test_chunks_are_whole_lines_and_lose_nothing(monkeypatch, size, source):
    monkeypatch.setattr(words, "CHUNK_BYTES", size)
    raw = source.encode()
    text = ProgramText(raw, build_plain_setup(), Rs274)
    segments, line = [], 1
    while (chunk := text.find_chunk(line)) is not None:
        segments.append((chunk.first_line, chunk.text))
        line += len(chunk.lines.plain)
    assert b"".join(segment for _line, segment in segments) == raw
    done = b""
    for line, segment in segments:
        assert segment
        assert line == 1 + done.count(b"\n")
        assert not done or done.endswith(b"\n")
        assert len(segment) <= size or b"\n" not in segment[:-1]  # longer than asked only where one line is
        done += segment


PROGRAM = (
    "%\nG21 G90 (start)\nG0 X0 Y0 Z5\nG1 F300\n"
    + "".join(f"X{i} Y{i * i % 7}.25\n" for i in range(40))
    + "G91\nX1\nG90 (MSG, half)\n"
    + "".join(f"N{i} G{i % 2} Z{i % 3} F{100 + i}\n" for i in range(25))
    + "G2 X48 I4\n\nM30\n%\n"
)


def same(one, two):
    """Two answers of the interpreter are equal to the last bit."""
    for name in ("line", "kind", "end", "feed", "feed_mode", "frame", "control", "arc", "start"):
        assert np.array_equal(getattr(one[0], name), getattr(two[0], name), equal_nan=name == "feed"), name
    assert one[0].events == two[0].events
    assert one[1] == two[1]
    return True


@pytest.mark.parametrize("size", [1, 7, 20, 50, 111, 400])
def test_chunk_boundaries_mean_nothing(monkeypatch, view, size):
    whole = view(PROGRAM)
    assert whole[1] == ()
    assert len(whole[0]) == 2 + 40 + 1 + 25 + 1  # a G1 alone moves, too, by nothing
    monkeypatch.setattr(words, "CHUNK_BYTES", size)
    assert same(view(PROGRAM), whole)
    assert same(view(PROGRAM.replace("G2 X48 I4", "G2 X48")), view(PROGRAM.replace("G2 X48 I4", "G2 X48 (no centre)")))


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.rstrip("\n"),
        lambda text: text.replace("\n", "  \t\n"),
        lambda text: text.lower().replace("msg, half", "MSG, half"),
        lambda text: text + "X1 garbage ((\n",
        lambda text: text.replace("X", " X ").replace("Y", "\tY"),
    ],
    ids=["CRLF", "no final newline", "trailing blanks", "lower case", "text after the end", "blanks"],
)
def test_line_ends_blanks_and_case_mean_nothing(view, change):
    assert same(view(change(PROGRAM)), view(PROGRAM))


@pytest.mark.parametrize(
    ("source", "said"),
    [("", "the file is empty"), *((text, "the file has nothing but blank lines") for text in ("\n", " \n\n\t\r\n"))],
)
def test_a_text_of_blanks_is_told_as_such(view, source, said):
    _moves, (item,) = view(source)
    assert (item.code, item.line, item.message) == ("VP032", 1, said)


@pytest.mark.parametrize("line", ["G1 X20 Q", "G1 X", "G1 X[1+", "G1 X1 Y(no value) Z", "G1 X1 F "])
def test_columns_are_the_same_with_both_ends_of_lines(view, line):
    """The carriage return is no column: the end of the line stood one further right."""
    (_moves, unix), (_moves, windows) = (view(f"G21{end}{line}{end}M2{end}") for end in ("\n", "\r\n"))
    assert [(item.line, item.column, item.message) for item in windows] == [
        (item.line, item.column, item.message) for item in unix
    ]
    assert any(item.column is not None for item in unix)


@pytest.mark.parametrize(("source", "line"), [("G0 X1", 1), ("G0 X1\n", 1), ("(c)\nG0 X1\n", 2)])
def test_a_text_without_an_end_is_refused_on_its_last_line(view, source, line):
    _moves, findings = view(source)
    assert [(item.code, item.line) for item in findings] == [("VP010", line)]
