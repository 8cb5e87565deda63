"""docs/heidenhain.md: every example of its tables is executed, without effect, or refused, as the table says."""

import ast
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode.klartext import vocabulary
from verne_post.gcode.klartext.cycle_words import MACHINING, PATTERNS
from verne_post.gcode.klartext.program import PATHS, STATEMENTS
from verne_post.gcode.klartext.settings import SETTINGS
from verne_post.gcode.klartext.vocabulary import (
    AT_BEGIN,
    AT_END,
    CYCLES_WITHOUT_EFFECT,
    FUNCTIONS_WITHOUT_EFFECT,
    REFUSED_CYCLES,
    REFUSED_FN,
    REFUSED_FUNCTIONS,
    REFUSED_STATEMENTS,
)
from verne_post.gcode.read import interpret_program
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

ZERO = (0.0,) * 6
PAGE = Path(__file__).resolve().parents[2] / "docs" / "heidenhain.md"
BEFORE = """BEGIN PGM TABLE MM
TOOL CALL 1 Z S1000 F700
L X+1 Y+2 Z+30 A+0 C+0 R0 FMAX M3
CC X+0 Y+0
CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=99 Q202=5 Q210=0 Q203=0 Q204=9 Q211=0
L X+20 Y+0 F500""".splitlines()
AFTER = """L X+60 Y+7
L X+70 Y+30 R0
L Z+40 FMAX
M30
END PGM TABLE MM""".splitlines()


def make_tool(number, length, diameter):
    return Tool(number, number, (0.0, 0.0, length, *ZERO), diameter)


def rows(title):
    """Words and statements of the examples of one table."""
    section = PAGE.read_text(encoding="utf-8").split(f"## {title}\n")[1].split("\n## ")[0]
    found = []
    for line in section.splitlines():
        cells = re.split(r"(?<!\\)\|", line)
        if len(cells) == 5 and "---" not in line and "`" in cells[2]:
            examples = re.findall("`([^`]+)`", cells[2].replace("\\|", "|"))
            found += [
                pytest.param(example.split(" / "), id=f"{cells[1].strip()} {example}"[:50]) for example in examples
            ]
    return found


@pytest.fixture(scope="module")
def outcome(machine):
    """Everything that a program does, as comparable values, and its findings; once for each program."""
    options = Options(
        tools={1: make_tool(1, 80.0, 8.0), 2: make_tool(2, 60.0, 6.0)},
        subroutines={"other": b"L X+44 FMAX\nEND PGM OTHER MM"},
        control={"heidenhain": {"tools": {"MILL": 2}, "datums": {"1": [1.0, 2.0, 3.0]}}},
        dialect="heidenhain",
        wcs={"G54": (0.0, 0.0, 40.0), "G55": (5.0, 0.0, 40.0)},
    )

    @cache
    def interpret(text):
        try:
            moves = interpret_program(text.encode(), build_interpreter_setup(machine, options))
        except InputError as error:
            return None, error.findings
        shown = [
            np.round(column, 9).tolist()
            for column in (
                moves.kind,
                moves.end,
                np.nan_to_num(moves.feed),
                moves.feed_mode,
                moves.spindle,
                np.nan_to_num(moves.tool_axis),
            )
        ]
        frames = [moves.frames[index] for index in moves.frame]
        controls = [moves.controls[index] for index in moves.control]
        arcs = [np.round(column, 9).tolist() for column in (moves.arcs.center, moves.arcs.sweep)]
        events = [(event.kind, event.before, event.data) for event in moves.events]
        return (shown, frames, controls, arcs, events), ()

    return lambda statements: interpret("\n".join([*BEFORE, *statements, *AFTER]))


@pytest.mark.parametrize("example", rows("Executed"))
def test_executed(outcome, example):
    done, findings = outcome(example)
    assert findings == ()
    plain, _none = outcome([])
    assert done != plain
    of_first = 2 if re.match(r"CYCL DEF \d+\.0 ", example[0]) else 1  # the name of a cycle, and its values
    without_first, _findings = outcome(example[of_first:])
    assert done != without_first


@pytest.mark.parametrize("example", rows("Without effect"))
def test_without_effect(outcome, example):
    done, findings = outcome(example)
    assert findings == ()
    assert done == outcome([])[0]


@pytest.mark.parametrize("example", rows("Refused"))
def test_refused(outcome, example):
    done, findings = outcome(example)
    assert done is None
    first = findings[0]
    assert len(BEFORE) < first.line <= len(BEFORE) + len(example)
    assert first.code in {"VP002", "VP006", "VP007", "VP012", "VP017", "VP026", "VP027"}
    words = set(re.findall(r"[A-Z]+|\d+", " ".join(example)))
    assert words & set(re.findall(r"[A-Z]+|\d+", first.message)), first.message


#: Words of the vocabulary, each as a statement.
WITHOUT_EFFECT = [
    *(f"M{number}" for number in FUNCTIONS_WITHOUT_EFFECT),
    *(f"CYCL DEF {number} X Q240=0" for number in CYCLES_WITHOUT_EFFECT),
]
NOT_EXECUTED = {
    **{f"{word} X": why for word, why in REFUSED_STATEMENTS.items()},
    **{f"M{number}": why for number, why in REFUSED_FUNCTIONS.items()},
    **{f"CYCL DEF {number}.0 X": why for number, why in REFUSED_CYCLES.items()},
    **{f"FN {number}: X": why for number, why in REFUSED_FN.items()},
}


@pytest.mark.parametrize("statement", WITHOUT_EFFECT)
def test_words_without_effect(outcome, statement):
    assert outcome([statement]) == outcome([])


@pytest.mark.parametrize(("statement", "why"), NOT_EXECUTED.items(), ids=str)
def test_refused_words(outcome, statement, why):
    done, findings = outcome([statement])
    assert done is None
    assert (findings[0].code, findings[0].line) == ("VP002", len(BEFORE) + 1)
    assert why in findings[0].message


def test_what_is_executed_is_in_the_vocabulary():
    """Each word has its code, and each code its word."""
    assert {*STATEMENTS, *PATHS} == set(vocabulary.STATEMENTS)
    assert {*AT_BEGIN, *AT_END} <= set(vocabulary.FUNCTIONS)
    assert {*MACHINING, *PATTERNS, *SETTINGS} == set(vocabulary.CYCLES)


#: In patterns, but no words of the language: letters that are looked for one by one, F AUTO without its blank, slips of
#: LBL, and the points of REFPNT, of which all but one are refused.
NO_WORDS = {"LCMQFS", "FAUTO", "TIP", "LB", "BL", "LL", "LABEL", "SP", "TC"}


def list_words_of_patterns():
    """Words of two letters and more in the regular expressions by which Klartext is read."""
    found = {}
    for path in Path(vocabulary.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "re.compile":
                constants = [part.value for part in ast.walk(node.args[0]) if isinstance(part, ast.Constant)]
                texts = [text.decode() if isinstance(text, bytes) else text for text in constants]
                pattern = " ".join(text for text in texts if isinstance(text, str))
                words = re.findall(r"(?<![A-Z])[A-Z]{2,}(?![A-Z])", re.sub(r"\[[^\]]*\]", " ", pattern))
                found |= dict.fromkeys(words, path.name)
    return found


def test_words_that_are_read_are_in_the_page():
    named = set(re.findall("[A-Z]{2,}", PAGE.read_text(encoding="utf-8")))
    found = list_words_of_patterns()
    assert len(found) > 60
    assert {word: file for word, file in found.items() if word not in named | NO_WORDS} == {}


def test_no_word_is_in_two_tables():
    for executed, *others in (
        (vocabulary.FUNCTIONS, FUNCTIONS_WITHOUT_EFFECT, REFUSED_FUNCTIONS),
        (vocabulary.CYCLES, CYCLES_WITHOUT_EFFECT, REFUSED_CYCLES),
        (vocabulary.FN, REFUSED_FN),
        (vocabulary.STATEMENTS, REFUSED_STATEMENTS),
    ):
        seen = set(executed)
        for words in others:
            assert not seen & set(words)
            seen |= set(words)
