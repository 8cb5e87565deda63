"""In which line of a TOML file a key stands that a message begins with."""

import pytest

from verne_post.config.toml_text import find_key_line

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
        ("keys.1 = 2: expected", 3),
        ("wcs: no system", 9),
        ("wcs.G54.2 = ']': expected", 10),
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
    """Of what is missing it is the line of its table; text and lists of several lines have no keys."""
    assert find_key_line(TEXT, sentence) == line
