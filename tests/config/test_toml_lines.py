"""Where in a TOML file a key stands that a message begins with, and where a new one goes."""

import pytest

from verne_post.config.toml_entries import Cursor, Edit, UnknownLayoutError, find_cursor, find_place, plan_edit
from verne_post.config.toml_text import read_toml

TEXT = '''# one
tool_length = 90
keys = [1,
  2, # [limits]
]
note = """
[wcs]
"""
[wcs]
G54 = [0, 0,
       "]"]
"G54.1P2" = [0, 0, 1]
[setup."*.nc".wcs]
G55 = [1, 2, 3]
[[leg]]
length = 1
[[leg]]
length = 2
[tool.verne-post]
options.air = 3
'''


@pytest.mark.parametrize(
    ("sentence", "line"),
    [
        ("tool_length = -1: expected a number", 2),
        ("tool_length and tool_lengths exclude each other", 2),
        ("keys.1 = 2: expected", 4),
        ("wcs: no system", 9),
        ("wcs.G54.2 = ']': expected", 11),
        ("wcs: G54: is given twice", 10),
        ("wcs.G54.1P2 = 7: expected", 12),
        ("wcs.G59 is missing", 9),
        ("setup.'*.nc'.wcs.G55 = 1: expected", 14),
        ("leg.1.length = 2: expected", 18),
        ("[leg]: without", None),
        ("options.air = 3: expected", 20),
        ("tool = 3: expected", None),
        ("limits is missing", None),
        ("not a TOML file: Invalid value (at line 7, column 3)", 7),
    ],
)
def test_a_key_has_a_line(sentence: str, line: int | None) -> None:
    """Of what is missing it is the line of its table; text of several lines has no keys."""
    place = find_place(TEXT, sentence)
    assert (None if place is None else place[0]) == line


def test_a_sentence_of_a_file_in_a_folder_is_not_about_the_first_of_several_tables() -> None:
    """The folder m was taken for a name of [wcs], and any table of its kind for the place."""
    assert find_place(TEXT, "wcs.m/part.stl: a grid", 2) is None
    assert find_place(TEXT, "wcs.G54: a grid", 2) == find_place(TEXT, "wcs.G54: a grid")


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("[wcs]\nG54 = [0, 0, 40\n", "(at line 2, column 1)"),
        ("[wcs]\n  G54 = [0, 0,\n # x\n", "(at line 2, column 3)"),
        ("x = 1\nkeys = [[1],\n[2],\n", "(at line 2, column 1)"),
        ('x = """\ny = 1\n', "(at line 1, column 5)"),
        ("x = 1\ny = 'a", "(at line 2, column 5)"),
    ],
)
def test_what_is_open_at_the_end_of_the_file_has_a_line(text: str, place: str) -> None:
    """The message had "at end of document", and no line, so that no line was shown."""
    with pytest.raises(ValueError, match="not a TOML file") as caught:
        read_toml(text.encode())
    assert str(caught.value).endswith(f": what begins here is open up to the end of the file {place}")


def test_keys_in_braces_have_their_columns() -> None:
    text = "x = 1\r\n[tools] # of\r\n5 = { length = 80, lenght = 3 }\r\n"
    line, begin, end = find_place(text, "tools.5.lenght: unknown key") or (0, 0, 0)
    assert (line, text.splitlines()[line - 1][begin:end]) == (3, "lenght")


@pytest.mark.parametrize(
    ("text", "key", "value", "made"),
    [
        ("", ("wcs", "G54"), "[1, 2, 3]", "[wcs]\nG54 = [1, 2, 3]\n"),
        ("# mine\n[wcs]", ("wcs", "G54.1P3"), "[1]", '# mine\n[wcs]\n"G54.1P3" = [1]\n'),
        ("[wcs]\nG55 = [0]\n\n[tools]\nG54 = 1\n", ("wcs", "G54"), "[1]",
         "[wcs]\nG55 = [0]\nG54 = [1]\n\n[tools]\nG54 = 1\n"),
        ('[wcs]\nG54 = "measure" # of\n', ("wcs", "G54"), "[1]", "[wcs]\nG54 = [1] # of\n"),
        ("wcs.G54 = [0,\n 1] # of\n", ("wcs", "G54"), "[1]", "wcs.G54 = [1] # of\n"),
        ("wcs.G54 = [0,\n 1] # of\n", ("wcs", "G55"), "[1]", "wcs.G54 = [0,\n 1] # of\nwcs.G55 = [1]\n"),
        ("wcs = {G54 = [0]}\n", ("wcs", "G55"), "[1]", "wcs = { G54 = [0], G55 = [1] }\n"),
        ("[tools]\n5.length = 80\n", ("tools", "5", "diameter"), "6", "[tools]\n5.length = 80\n5.diameter = 6\n"),
        ("# mine\n[wcs]\nallow_rewind = 1\n", ("allow_rewind",), "true",
         "# mine\nallow_rewind = true\n[wcs]\nallow_rewind = 1\n"),
        ("allow_rewind = false\n", ("allow_rewind",), "true", "allow_rewind = true\n"),
        ("x = 'a'\r\n", ("wcs", "G54"), "[1]", "x = 'a'\r\n\r\n[wcs]\r\nG54 = [1]\r\n"),
    ],
)  # fmt: skip
def test_a_key_is_set_in_a_text(text: str, key: tuple[str, ...], value: str, made: str) -> None:
    assert plan_edit(text, Edit(key, value)).apply(text) == made


@pytest.mark.parametrize("text", ["wcs", "wcs = [", "wcs = 1 2 # ]", "[wcs", "wcs = { G54 = 1", "wcs = 3\n"])
def test_a_text_that_cannot_hold_the_key_is_not_changed(text: str) -> None:
    with pytest.raises(UnknownLayoutError):
        plan_edit(text, Edit(("wcs", "G54"), "[1]"))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", Cursor((), 0)),
        ("a = 1\n", Cursor((), 6)),
        ("a = ", Cursor((), 4, ("a",))),
        ("a = 1 ", None),
        ("a = 1 # b", None),
        ("# a", None),
        ('a = "x y', Cursor((), 4, ("a",))),
        ('a = "x y"', None),
        ("[", Cursor((), 1, is_header=True)),
        ("[a]", None),
        ("[a.", Cursor(("a",), 3, is_header=True)),
        ("[a]\nb.c.d", Cursor(("a", "b", "c"), 8)),
        ("[a]\nb = { c = 1, ", Cursor(("a", "b"), 17)),
        ("[a]\nb = { c = 1, d = t", Cursor(("a",), 21, ("a", "b", "d"))),
        ("[a]\nb = [1, ", Cursor(("a",), 12, ("a", "b", "1"))),
        ("[a]\nb = [\n 1,\n ", Cursor(("a",), 15, ("a", "b", "1"))),
        ("[[a]]\nb = 1\n[[a]]\nc", Cursor(("a", "1"), 18)),
        ("wrong line\n[a]\nalso wrong\nb", Cursor(("a",), 26)),
    ],
)
def test_what_is_being_written_at_the_end_of_a_text(text: str, expected: Cursor | None) -> None:
    assert find_cursor(text) == expected


def test_every_beginning_of_a_text_has_a_cursor_in_its_last_line() -> None:
    for end in range(len(TEXT) + 1):
        found = find_cursor(TEXT[:end])
        assert found is None or TEXT[:end].rfind("\n") < found.begin <= end
