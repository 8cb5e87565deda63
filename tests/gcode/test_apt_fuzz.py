"""Damaged cutter location text: no traceback, no hang, and no word that is passed over in silence.

``python -m tests.gcode.test_apt_fuzz 100000 [SEED]`` makes so many inputs; the suite a few hundred.
"""

import random
import re
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from tests.gcode.test_apt_writers import EXECUTED, WITH_CONDITIONS
from verne_post.gcode import build_plain_setup
from verne_post.gcode.apt.words import REFUSED_WORDS, REMARKS, WITHOUT_EFFECT
from verne_post.gcode.read import interpret_program
from verne_post.model.findings import InputError

CORPUS = sorted((Path(__file__).parents[1] / "corpus" / "apt").glob("bracket.[anc]*"))
#: What makes every statement worth something, before it and after.
BEFORE = "UNITS/MM\nLOADTL/2\nSPINDL/60,RPM,CCLW\nCOOLNT/ON\nFEDRAT/90\nGOTO/0,0,9"
AFTER = "GOTO/7,1,9\nRAPID\nGOTO/8,1,9\nGODLTA/1\nFEDRAT/70\nGOTO/7,5,9\nSPINDL/ON\nDELAY/1\nEND"
#: Words that stand in no statement by themselves, and bytes that stand nowhere.
WORDS = [
    "QQQ",
    "7",
    "-3",
    "1E3",
    ",",
    ",,",
    "/",
    "$",
    "$$",
    "(",
    ")",
    "ON",
    "OFF",
    "MM",
    "INCH",
    "IPM",
    "MMPR",
    "RPM",
    "CLW",
    "CCLW",
    "AUTO",
    "RTRCTO",
    "TAP",
    "RATIO",
    "RAPTO",
    "DEPTH",
    "STEP",
    "CLEAR",
    "TOOL",
    "ADJUST",
    "NOMORE",
    "TIMES",
    "XYPLAN",
    "LEFT",
    "INTOF",
    "PAST",
    "GOTO",
    "GOTO/1,2,3",
    "CYCLE/OFF",
    "RAPID",
    "END-OF-PATH",
    "MSYS",
    "TRACUT",
    "0.0",
    "1.0",
    "ÿ",
    "%",
    ":",
    "=",
]
TEXTS = [text for text, _left in EXECUTED.values()] + [*WITH_CONDITIONS.values()]
TEXTS += [
    "CYCLE/TAP,DEPTH,5,CLEAR,1,MMPR,1\nGOTO/4,0,0\nCYCLE/OFF",
    "CYCLE/TAP,5,1\nGOTO/4,0,0\nCYCLE/OFF",
    "CYCLE/TAP,5,60,MMPM,25.4,1\nGOTO/4,0,0\nCYCLE/OFF",
    "CYCLE/TAP,DEEP,FEDTO,-5,RAPTO,1,STEP,2,TPI,20,RATIO,2,ORIENT,9,DWELL,1,RTRCTO,3\nGOTO/4,0,0,0,.6,.8\nCYCLE/OFF",
]
TEXTS += [f"{word}/1,2" for word in (*REMARKS, *WITHOUT_EFFECT, *REFUSED_WORDS)]
SETUPS = [
    build_plain_setup(
        tools={1: make_tool(1, 10.0), 2: make_tool(2, 25.0)},
        dialect="aptcl",
        control=control,
        tapping="feed",
        max_repeats=300,
    )
    for control in (
        {},
        {
            "aptcl": {
                "pitches": {"2": 1.0},
                "cutcom": "centre",
                "insert": "message",
                "msys": "one clamping",
                "times": "begun",
                "tools": {"B": 1},
            }
        },
    )
]


def outcome(text, setup):
    """What a program does, as comparable values; or the first code of its refusal. Anything else that is raised is a
    fault.
    """
    begun = time.process_time()
    try:
        moves = interpret_program(text.encode("latin-1"), setup)
    except InputError as error:
        return error.findings[0].code
    finally:
        assert time.process_time() - begun < 5
    columns = [
        moves.kind,
        np.round(moves.end, 9),
        np.nan_to_num(moves.feed),
        moves.spindle,
        moves.arcs.sweep,
        np.nan_to_num(moves.tool_axis),
    ]
    return (
        [column.tolist() for column in columns],
        [moves.frames[at] for at in moves.frame],
        [(e.kind, e.before, e.data) for e in moves.events],
    )


def damage(text, pick):
    """A text with one to three damages."""
    for _ in range(pick.randint(1, 3)):
        place, kind = pick.randrange(len(text) + 1), pick.random()
        if kind < 0.25:
            text = text[:place] + text[place + 1 :]
        elif kind < 0.6:
            text = text[:place] + pick.choice(WORDS) + text[place:]
        elif kind < 0.7:
            text = text[:place] + chr(pick.randrange(256)) + text[place:]
        elif kind < 0.85:
            text = f"{text[:place]}\n{pick.choice(TEXTS)}\n{text[place:]}"
        else:
            lines = text.split("\n")
            lines.insert(pick.randrange(len(lines) + 1), pick.choice(lines))
            text = "\n".join(lines)
    return text


def insert_word(pick):
    """A statement, and the same with one word more that means nothing there."""
    statement = pick.choice(TEXTS)
    lines = statement.split("\n")
    at = pick.randrange(len(lines))
    words = lines[at].split(",")
    words.insert(pick.randint(1, len(words)), pick.choice(["QQQ", "7.5", "PAST", "-2.25", "NOW"]))
    return statement, "\n".join([*lines[:at], ",".join(words), *lines[at + 1 :]])


def says_so(statement):
    """True for a statement that is a remark, or that is told to be without effect as a whole."""
    word = re.split(r"[/,\s]", statement.split("\n")[0])[0]
    return word in (*REMARKS, *WITHOUT_EFFECT) or statement.startswith("$$")


def study(first, count):
    """So many inputs from a seed on; returns those that were passed over in silence."""
    silent = []
    for seed in range(first, first + count):
        pick = random.Random(seed)
        setup = pick.choice(SETUPS)
        if pick.random() < 0.2:
            text = pick.choice(CORPUS).read_text(encoding="utf-8")
            outcome(damage(text, pick), setup)
            continue
        if pick.random() < 0.5:
            outcome(
                "\n".join([BEFORE, damage("\n".join(pick.choices(TEXTS, k=pick.randint(1, 4))), pick), AFTER]), setup
            )
            continue
        statement, longer = insert_word(pick)
        without, with_it = (outcome("\n".join([BEFORE, each, AFTER]), setup) for each in (statement, longer))
        if without == with_it and not isinstance(with_it, str) and not says_so(statement):
            silent.append((seed, longer))
    return silent


@pytest.mark.parametrize("first", [0, 1000, 2000])
def test_damaged_statements_are_refused_or_told(first):
    assert study(first, 150) == []


if __name__ == "__main__":
    begun = time.perf_counter()
    found = study(int(sys.argv[2]) if len(sys.argv) > 2 else 0, int(sys.argv[1]))
    shown = "\n".join(map(str, found[:40]))
    sys.stdout.write(f"{shown}\n{len(found)} passed over in silence, {time.perf_counter() - begun:.0f} s\n")
    sys.exit(1 if found else 0)
