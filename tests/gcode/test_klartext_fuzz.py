"""Damaged Klartext: no traceback, no hang, and no word that is passed over in silence."""

import random
import re
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode import build_plain_setup
from verne_post.gcode.read import interpret_program
from verne_post.model.findings import InputError
from verne_post.model.options import Options

PAGE = Path(__file__).resolve().parents[2] / "docs" / "heidenhain.md"
BEFORE = """BEGIN PGM FUZZ MM
TOOL CALL 1 Z S1000 F700
L X+1 Y+2 Z+30 A+0 C+0 R0 FMAX M3
CC X+3 Y+1
CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=99 Q202=5 Q210=0 Q203=0 Q204=9 Q211=0
L X+20 Y+1 F510""".splitlines()
AFTER = """L X+60 Y+7
L X+70 Y+30 R0
L IZ+9 FU0.3
L X+75 F600
L A+3 C+4 F400
L C+350 FMAX
L X+5 Y+5 FMAX M99
M30
LBL 99
L IX+1
LBL 0
END PGM FUZZ MM""".splitlines()
#: Words that stand in no statement by themselves, and bytes that stand nowhere.
WORDS = [
    "X+5 Y-3 Z+31 IX+2 IY+3 IZ-4 A+9 C+8 IA+2 IC+4 B+3 U+1 PR+12 PA+33 IPA+40 IPR+2 DR+ DR- R+20 R-20 R+7 RL RR R0 "
    "FMAX F333 F AUTO",
    "FU0.2 FZ0.1 M3 M4 M5 M8 M9 M13 M91 M92 M94 M99 M89 M116 M126 M128 M129 M130 M136 M140 MB5 MB MAX M97 M120 LA5 M6 "
    "M77 S500 T5 TX+0 TY+0",
    "TZ+1 NX+0 NY+0 NZ+1 CCA90 LEN5 DL+1 DR+1 DR2+1 SPA+5 SPB+5 SPC+5 STAY TURN MOVE SEQ+ SEQ- DIST5 TABLE ROT COORD "
    "ROT REP 2 Q1 Q200=3 ~ ; / *",
    'Q9=5 Q201=-2 #5 #6 ABST5 LBL 99 GOTO IF ROT+5 SCL2 "A" ( ) + - 5 0 . , 1e5 99999999 ÿ % ! = : X Y C L',
]
WORDS = [word for line in WORDS for word in re.findall(r"F AUTO|MB MAX|TABLE ROT|COORD ROT|REP 2|LBL 99|\S+", line)]
#: Without effect by themselves where they are inserted: what they say holds already, they end what does not hold, or
#: (M91, M130) mean the same without a machine.
NEUTRAL = re.compile(r"R0|[;~*]|M(?:6|77|9[0124]|120|129|130)|\+|/|LA5|-?0+")

#: The name of a cycle of several lines is a remark; only words of axes have no place in it.
NAMED = re.compile(r"CYCL DEF \d+\.0 ")
AXIS_WORDS = [word for word in WORDS if re.match(r"I?[XYZABC][-+]", word)]


#: What the set-ups have of the control, and statements that need it.
CONTROL = {"heidenhain": {"datums": {"5": [3.0, -2.0, 1.0]}, "cycle_19": "moves"}}
OF_CONTROL = [
    ["CYCL DEF 7.1 #5", "L X+0 Y+3 FMAX"],
    ['SEL TABLE "A.D"', "TRANS DATUM TABLE TABLINE5", "L X+0 Y+3 FMAX"],
    ["CYCL DEF 19.1 A+10 B+0 C+5 F2000 ABST25", "L X+5 FMAX"],
]


def examples():
    """Statements of the first two tables of docs/heidenhain.md, and of what a set-up has of the control."""
    text = PAGE.read_text(encoding="utf-8").split("## Executed\n")[1].split("\n## Refused")[0]
    found = re.findall(r"^\|[^|]*\| `((?:\\\||[^|`])*)` \|", text, re.MULTILINE)
    return [one.replace("\\|", "|").split(" / ") for one in found] + OF_CONTROL


def setups(machine):
    """The machine, and no machine: without it planes turn nothing, which is much faster."""
    tools = {1: make_tool(1, 80.0, 8.0), 2: make_tool(2, 60.0, 6.0)}
    options = Options(
        tools=tools, dialect="heidenhain", wcs={"G54": (0.0, 0.0, 40.0)}, max_repeats=300, control=CONTROL
    )
    plain = build_plain_setup(tools=tools, dialect="heidenhain", max_repeats=300, control=CONTROL)
    return build_interpreter_setup(machine, options), plain


def outcome(statements, setup):
    """What a program does, as comparable values; or the first code of its refusal. Anything else that is raised is a
    fault.
    """
    text = "\n".join([*BEFORE, *statements, *AFTER]).encode("latin-1")
    begun = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            moves = interpret_program(text, setup)
    except InputError as error:
        assert time.process_time() - begun < 20
        return error.findings[0].code
    assert time.process_time() - begun < 20
    columns = [
        moves.kind,
        np.round(moves.end, 9),
        np.round(np.nan_to_num(moves.feed), 9),
        moves.feed_mode,
        moves.spindle,
        moves.arcs.sweep,
    ]
    frames = [moves.frames[index] for index in moves.frame]
    controls = [moves.controls[index] for index in moves.control]
    return [column.tolist() for column in columns], frames, controls, [(e.kind, e.before, e.data) for e in moves.events]


def damaged(pool, random_):
    """Statements with one to three damages."""
    statements = list(random_.choice(pool))
    if random_.random() < 0.4:
        statements += random_.choice(pool)
    for _ in range(random_.randint(1, 3)):
        at = random_.randrange(len(statements))
        text = statements[at]
        place = random_.randrange(len(text) + 1)
        kind = random_.random()
        if kind < 0.25:
            text = text[:place] + text[place + 1 :]
        elif kind < 0.6:
            text = text[:place] + random_.choice(WORDS) + text[place:]
        elif kind < 0.7:
            text = text[:place] + chr(random_.randrange(256)) + text[place:]
        elif kind < 0.8:
            statements.insert(at, random_.choice(random_.choice(pool)))
            continue
        else:
            words = text.split(" ")
            words[random_.randrange(len(words))] = random_.choice(WORDS)
            text = " ".join(words)
        statements[at] = text
    return statements


def with_word(pool, random_):
    """Statements, and the same with one more word in one of them."""
    statements = list(random_.choice([one for one in pool if not re.match(r"\*|FN 9|M1[13]6", one[0])]))
    at = random_.randrange(len(statements))
    words = statements[at].split(" ")
    while re.match(r"CYCL DEF \d{3} [A-Z]+ ", " ".join(words)):  # names of cycles are free
        del words[3]
    first = 4 if len(words) > 3 and words[1] == "DEF" and len(words[2]) == 3 else 1
    place, word = random_.randint(first, len(words)), random_.choice(WORDS)
    changed = [*statements]
    changed[at] = " ".join([*words[:place], word, *words[place:]])
    return statements, changed, word


def run_damaged(seed, n, both):
    """Execute ``n`` damaged programs; returns how many were executed and how many refused."""
    pool, random_ = examples(), random.Random(seed)
    executed = 0
    for k in range(n):
        executed += not isinstance(outcome(damaged(pool, random_), both[k % 8 > 0]), str)
    return executed, n - executed


def find_silent(seed, n, both):
    """Programs that one more word does not change."""
    pool, random_, before, silent = examples(), random.Random(seed), {}, []
    for _ in range(n):
        statements, changed, word = with_word(pool, random_)
        key = tuple(statements)
        if key not in before:
            before[key] = outcome(statements, both[0])
        after = outcome(changed, both[0])
        is_free = NEUTRAL.fullmatch(word) or (
            word not in AXIS_WORDS and NAMED.search("\n".join({*changed} - {*statements}))
        )
        if after == before[key] and not isinstance(after, str) and not is_free:
            silent.append((statements, changed))
    return silent


@pytest.fixture(scope="module")
def both(machine):
    return setups(machine)


def test_damaged_programs(both):
    executed, refused = run_damaged(1, 300, both)
    assert executed > 20
    assert refused > 100


def test_no_word_is_passed_over(both):
    assert find_silent(2, 60, both) == []  # of 6,500 (docs/trials.md)
