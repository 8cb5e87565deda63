"""Mutated Siemens programs: findings or moves, never another exception; a changed word is executed, told or refused.

``python tests/gcode/test_siemens_fuzz.py N FIRST`` runs N mutated programs from number FIRST on.
"""

import random
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from verne_post.app.assemble import view_moves_plainly
from verne_post.gcode.siemens.vocabulary import ADDRESSES, CYCLES, GROUPS, NO_EFFECT, REFUSED_WORDS, STATEMENTS
from verne_post.model.moves import ZERO9, MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

SAMPLE = (Path(__file__).parents[2] / "gcode_samples" / "two_faces.mpf").read_text(encoding="utf-8")
OTHERS = """\
N10 G17 G54 G64 G90 G710 F500 S900 M3 ; head
DEF REAL P1=2.5, LIST[3]=SET(1,2,3)
DEF STRING[20] TEXT="A"
R1=3 R2=R1*2-SIN(30)
T1 M6
G0 X0 Y0 Z50 A0 C0
LOOP1: G1 X=R1 Y=IC(2) Z=LIST[1]
R1=R1-1
IF (R1>0) AND (R2<9) GOTOB LOOP1
LOOP2:
G0 X0 Y0
G2 X10 Y0 I5 J=AC(2.5) TURN=1
G3 X=20 Y5 CR=12
CIP X30 Y5 Z-2 I1=25 J1=0 K1=-1
CT X40 Y0
TRANS X5 Y-5
AROT Z30
AMIRROR X0
G1 X1 Y2 Z3
TRANS
G111 X1 Y1
G0 AP=30 RP=12
G4 F0.5
G1 G41 X20 Y20
X30
Y30
G40 X40
FOR R3=1 TO 3
X=R3*10
ENDFOR
WHILE R3<6
R3=R3+1
ENDWHILE
IF R3==6
MSG("R3 is "<<R3)
ELSE
M0
ENDIF
REPEAT LOOP1 LOOP2 P=1
MCALL CYCLE83(50,0,2,-20,,-5,,1,0.1,0,0.8,1)
HOLES2(0,0,20,0,0,4)
MCALL
CYCLE832(0.05,_ORI_FINISH,1)
CYCLE800(0,"",0,57,1,2,3,10,-5,20,0,0,0,1)
X5 Y5 Z60
CYCLE800()
SUPA G0 Z200 D0
G0 A0 C0 D1
TRAORI
ORIWKS FFWON SOFT
G1 X5 A3=0.1 B3=0.2 C3=1
X6 A=DC(10) C=ACP(20)
TRAFOOF
X6 Y5 Z60
PART(1,,"X")
L10 P2
M30
%_N_PART_SPF
PROC PART(REAL A1, REAL B1=2, STRING[9] C1) SAVE
G91 X=A1 Z=B1
RET
%_N_L10_SPF
Y=IC(1)
M17
"""
WORDS = [
    *ADDRESSES,
    *CYCLES,
    *STATEMENTS,
    *NO_EFFECT,
    *REFUSED_WORDS,
    *(word for words in GROUPS.values() for word in words),
]
PIECES = [
    "(", ")", "[", "]", "=", "==", "<<", "\"", "'", ";", ":", "%", "/", ",", ".", "-", "+", "EX", "N", "0", "1e9",
    "99999999999999999999", "X=", "=X", "$P_EP[X]",
    "R1", "R[R1]", "AC(1)", "IC(", "DC(5)", "LOOP1", "P=3", "P-1", "TRUE", "SIN(90)", "1/0", "\u00e9", "\x00", "\t",
    "X1 X2", "G1 X", "LIST[9]", "TEXT", "REP(1)",
]  # fmt: skip
OPTIONS = [
    Options(dialect="siemens", max_repeats=500, tools={1: Tool(1, 1, (0.0, 0.0, 60.0, *ZERO9[3:]), 6.0)}),
    Options(dialect="siemens", max_repeats=500, tool_length=80.0, block_delete=True),
]


def mutated(text: str, pick: random.Random) -> str:
    """One to four changes: of characters, words and lines."""
    for _ in range(pick.randint(1, 4)):
        at = pick.randrange(len(text))
        what = pick.randrange(8)
        if what == 0:
            text = text[:at] + text[at + 1 :]
        elif what == 1:
            text = text[:at] + pick.choice(text) + text[at + 1 :]
        elif what == 2:
            text = text[:at] + pick.choice(PIECES) + text[at:]
        elif what == 3:
            text = (
                text[:at]
                + " "
                + pick.choice(WORDS)
                + pick.choice(["", " ", "5", "=5", "(1,2)", "[X]=1", "()"])
                + text[at:]
            )
        elif what == 4:
            words = list(re.finditer(r"[-+]?\d+\.?\d*", text))
            word = pick.choice(words)
            text = (
                text[: word.start()]
                + pick.choice(["0", "-1", "1EX9", "7.5", str(pick.uniform(-300, 300)), "1EX-9"])
                + text[word.end() :]
            )
        else:
            lines = text.split("\n")
            here, there = pick.randrange(len(lines)), pick.randrange(len(lines))
            if what == 5:
                lines[here], lines[there] = lines[there], lines[here]
            elif what == 6:
                lines.insert(here, lines[there])
            else:
                del lines[here]
            text = "\n".join(lines)
            if len(text) < 20:
                text += SAMPLE
    return text


def stretch(pick: random.Random) -> str:
    """The head of the second program, a few or some of its lines, and its subprograms where they are called."""
    lines = OTHERS.split("\n")
    begin = pick.randrange(6, len(lines) - 14)
    part = lines[begin : begin + pick.choice([3, 3, 12])]
    end = lines[-12:] if any(line.startswith(("PART", "L10")) for line in part) else ["M30"]
    return "\n".join([*lines[:2], *lines[4:6], *part, *end])


def run_one(seed: int) -> bool:
    """Interpret one mutated program; True where it has no error."""
    pick = random.Random(seed)
    text = mutated(pick.choice([SAMPLE, OTHERS, *[""] * 38]) or stretch(pick), pick)
    try:
        moves, findings = view_moves_plainly(text.encode(), OPTIONS[seed % len(OPTIONS)])
    except Exception as error:
        raise AssertionError(f"seed {seed}: {type(error).__name__}: {error}") from error
    assert all(item.code.startswith("VP") and item.message for item in findings), seed
    assert np.isfinite(moves.end).all(), seed
    assert np.isfinite(moves.feed[moves.kind != MoveKind.RAPID]).all(), seed
    return not findings


@pytest.mark.parametrize("block", range(8))
def test_mutated_programs_are_moves_or_findings(block):
    results = [run_one(seed) for seed in range(60 * block, 60 * (block + 1))]
    assert any(results)
    assert not all(results)


def executed_lines() -> list[int]:
    """Numbers of the lines of OTHERS that are executed and are no texts: a word in them cannot be skipped."""
    lines = OTHERS.split("\n")
    return [number for number, line in enumerate(lines) if line and not re.match(r"%|M0|MSG|PROC|DEF STRING", line)]


@pytest.mark.parametrize("number", executed_lines())
def test_an_unknown_word_is_refused_in_every_line(number):
    """At its beginning, its end, and between its words; where it becomes a part of a word the line is another one."""
    lines = OTHERS.split("\n")
    code = lines[number].partition(";")[0].rstrip()
    for at in {0, len(code), *(match.start() for match in re.finditer(" ", code))}:
        changed = [*lines[:number], f"{code[:at]} QZ7K {code[at:]}", *lines[number + 1 :]]
        _moves, findings = view_moves_plainly("\n".join(changed).encode(), OPTIONS[0])
        assert findings, changed[number]


def test_a_changed_number_changes_the_motion_or_is_refused():
    """Every number of the axes, arcs, frames and cycles of the program: nothing reads it and forgets it."""
    plain = view_moves_plainly(OTHERS.encode(), OPTIONS[0])
    assert plain[1] == ()

    def shown(moves):
        kinds = [(event.kind, event.line, sorted(map(str, event.data.items()))) for event in moves.events]
        return (
            moves.end.tolist(),
            moves.feed.round(6).tolist(),
            [moves.frames[i] for i in moves.frame],
            [moves.controls[i] for i in moves.control],
            moves.arcs.sweep.tolist(),
            moves.arcs.center.tolist(),
            kinds,
            moves.spindle.tolist(),
        )

    before, lines = str(shown(plain[0])), OTHERS.split("\n")
    silent = []
    for number, line in enumerate(lines):
        if re.match(r"[%;]|PROC|DEF|L10|REPEAT|WHILE|R3|IF|CYCLE83|FOR|MIRROR|AMIRROR", line):
            continue
        for match in re.finditer(r"(?<![A-Z\d.\[_])(?:[XYZACIJKF]|[=(,]-?)(\d+\.?\d*)", line):
            changed = line[: match.start(1)] + str(float(match[1]) + 0.375) + line[match.end(1) :]
            moves, findings = view_moves_plainly(
                "\n".join([*lines[:number], changed, *lines[number + 1 :]]).encode(), OPTIONS[0]
            )
            if not findings and str(shown(moves)) == before:
                silent.append(changed)
    assert silent == []


if __name__ == "__main__":
    count, first = (int(argument) for argument in sys.argv[1:3])
    good = sum(run_one(seed) for seed in range(first, first + count))
    print(f"{count} mutated programs from {first} on, {good} without an error")  # noqa: T201
