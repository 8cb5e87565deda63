"""Types in words, and whether a value has the shape of a type: beside msgspec, which decides what is taken."""

import math
from typing import Annotated, Any, Literal

import msgspec
import pytest
from msgspec import Meta

from verne_post.base.type_words import LARGEST, describe, has_shape

Share = Annotated[float, Meta(gt=0, lt=1)]
Point = Annotated[list[float], Meta(min_length=3, max_length=3)]


class Box(msgspec.Struct):
    """A table."""

    low: Point


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (float, "a number"),
        (Annotated[float, Meta(ge=-LARGEST, le=LARGEST)], "a number"),
        (Share, "a number: above 0, below 1"),
        (Annotated[float, Meta(gt=0, le=5.0)], "a number: above 0, at most 5"),
        (Annotated[int, Meta(ge=1)] | None, "a whole number: 1 or more"),
        (Annotated[int, Meta(ge=1, le=12)], "a whole number: 1 to 12"),
        (Literal["zv", "ei"] | None, "one of zv, ei"),
        (Literal[1], "1"),
        (Point, "a list of 3 numbers"),
        (Annotated[list[Point], Meta(min_length=2)], "a list of 2 or more lists of 3 numbers"),
        (Annotated[list[int], Meta(min_length=2, max_length=3)], "a list of 2 to 3 whole numbers"),
        (Share | Point, "a number: above 0, below 1, or a list of 3 numbers"),
        (Annotated[str, Meta(min_length=1)], "text: 1 or more characters"),
        (bool, "true or false"),
        (Box, "a table of keys"),
        (dict[int, float], "a mapping from whole numbers to numbers"),
    ],
)
def test_types_in_words(kind: Any, words: str) -> None:
    assert describe(kind) == words


VALUES = [
    0,
    1,
    -2,
    0.5,
    math.inf,
    True,
    None,
    "1",
    "",
    b"1",
    [],
    [1.0, 2.0, 3.0],
    ["x"],
    (1, 2, 3),
    {},
    {"low": [1, 2, 3]},
    {1: 2.0},
]
KINDS = [float, int, str, bool, None, Share, Point, Box, dict[int, float], list[str], Any, Literal["1"]]


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_taken_has_the_shape(kind: Any) -> None:
    """The shape never refuses what msgspec takes, and a number, text or truth value of another type never has it."""
    for value in VALUES:
        try:
            msgspec.convert(value, kind)
            taken = True
        except msgspec.ValidationError:
            taken = False
        shape = has_shape(type(None) if kind is None else kind, value)
        assert shape or not taken, value
        if kind in (float, int, str, bool, None):
            assert shape == taken, value
