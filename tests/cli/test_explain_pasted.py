"""`explain` of words as programs write them, and of whole lines; a command that stands without its group."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verne_post.gcode.known_words import describe_pasted, describe_word, list_words

_NUMBERED = re.compile(r"([GM]|FN |CYCL DEF )(\d+(?:\.\d+)?)")


def test_a_zero_before_the_number_changes_no_answer() -> None:
    codes = {(match[1], match[2]) for _language, name, *_ in list_words() if (match := _NUMBERED.fullmatch(name))}
    assert {("M", "3"), ("G", "5.1"), ("CYCL DEF ", "7"), ("FN ", "9")} <= codes
    for head, number in sorted(codes):
        for zeros in ("0", "00"):
            assert describe_word(f"{head}{zeros}{number}".lower()) == describe_word(f"{head}{number}") != []


@pytest.mark.parametrize(
    ("written", "word"),
    [
        ("N0010", "N10"),
        ("T01", "T1"),
        ("h01", "H1"),
        ("d01", "D1"),
        ("X-10.5", "X10"),
        ("CYCL DEF 200 DRILLING", "CYCL DEF 200"),
        ("CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7"),
    ],
)
def test_a_word_as_programs_write_it_is_the_word(written: str, word: str) -> None:
    assert describe_word(written) == describe_word(word) != []


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("G1 X10 F500", ["G1", "X10", "F500"]),
        ("N10G01X-10.5F500 ; to the edge", ["N10", "G01", "X-10.5", "F500"]),
        ("L X+10 R0 FMAX M3", ["L", "X+10", "R0", "FMAX", "M3"]),
        ('TOOL CALL "BALL 6" Z S3000', ["TOOL CALL", "Z", "S3000"]),
        ("CYCLE81(10,0,2,-5)", ["CYCLE81"]),
        ("GOTO/0,0,50", ["GOTO"]),
    ],
)
def test_a_line_is_told_word_by_word(line: str, words: list[str]) -> None:
    assert [text for text in describe_pasted(line) if not text.startswith(" ")] == words


def test_only_languages_that_know_all_words_of_a_line_are_named(run: Callable[..., Any]) -> None:
    text = run("explain", "G1 X10 F500").out
    assert text.startswith("G1 X10 F500\n  G1\n    RS274/NGC: straight move")
    assert "Klartext" not in text


@pytest.mark.parametrize("line", ["CYCL DEFF 208", "G1 FOO", "", " "])
def test_a_line_with_an_unknown_word_is_not_told(line: str) -> None:
    assert describe_pasted(line) == []


@pytest.mark.parametrize("words", [["calibrate"], ["validate", "x.toml"], ["show"], ["list"], ["tolerances", "--help"]])
def test_a_command_of_machine_is_named_where_it_stands_alone(run: Callable[..., Any], words: list[str]) -> None:
    assert f"did you mean `verne-post machine {' '.join(words)}`?" in run(*words).err


def test_the_short_answer_and_all_agree_on_the_other_solution(run: Callable[..., Any], tmp_path: Path) -> None:
    """C of the other solution, half a turn away, was beyond its travel, although a whole turn brings it back."""
    program = tmp_path / "turned.nc"
    program.write_text("G90 G21\nG0 X0 Y0 Z80 A10 C240\nG1 X10 F300\nM30\n")
    options = ("--machine", "ca_fork_head", "--tool-length", "100", "--wcs", "G54=200,200,100")
    short, whole = (run("explain", f"{program}:3", *options, *more).out for more in ((), ("--all",)))
    assert "other head solution: possible" in short
    assert "other head solution: possible" in whole
    assert "of which 2 possible" in whole
