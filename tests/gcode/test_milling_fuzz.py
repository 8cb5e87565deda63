"""Milling cycles with values at random: no traceback, no hang, nothing passed over, and what runs is the pocket.

``python -m tests.gcode.test_milling_fuzz N FIRST [NAME...]`` tries N programs from number FIRST on: of a language
(siemens, heidenhain), or all of these cycles of Siemens, if any are named. With ``pockets`` behind it sound values are
drawn, and the judge of pockets looks at what they mill.
"""

import itertools
import math
import random
import re
import sys
import time

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from tests.gcode.pocket_judge import circle, curved_slot, judge, polygon, rectangle
from tests.gcode.random_study import study
from verne_post.app.assemble import view_moves_plainly
from verne_post.gcode.klartext.cycle_words import MACHINING
from verne_post.gcode.klartext.milling import CYCLES
from verne_post.gcode.klartext.threads import THREADS
from verne_post.gcode.siemens.contour_milling import PARAMETERS as CONTOURS
from verne_post.gcode.siemens.milling_values import PARAMETERS
from verne_post.model.options import Options

#: Values of which each parameter gets one: usual, at the edge, none, and beyond everything.
NUMBERS = (
    0,
    1,
    2,
    3,
    4,
    5,
    8,
    10,
    12,
    20,
    24,
    40,
    60,
    0.2,
    0.5,
    1.5,
    -1,
    -2,
    -6,
    -20,
    90,
    360,
    500,
    0.001,
    1e-9,
    99999,
    -99999,
    1e7,
    11,
    21,
    31,
    100,
    1000,
    11100,
)
#: More likely values, by parameter.
LIKELY = {
    "RTP": 20, "RFP": 0, "SDIS": 2, "DP": -6, "MID": 3, "FFP1": 500, "FFD": 100, "PA": 0, "PO": 0, "LENG": 40,
    "WID": 24, "NUM": 2, "VARI": 11, "PRAD": 20, "AFSL": 60, "RAD": 30,
    "_GMODE": 0, "_DMODE": 0, "_AMODE": 0, "AP1": 60, "AP2": 60, "LIM": 0, "SSF": 0, "DIATH": 30, "H1": 2, "PIT": 2,
    "NT": 1, "FFR": 400, "KDIAM": 26, "SWL": 40, "RC": 2,
    "_PITA": 0, "TYPTH": 0, "MIDA": 4, "STA": 10, "CDIR": 2, "FAL": 0.2, "FALD": 0,
    200: 2, 201: -6, 202: 3, 203: 0, 204: 50, 206: 100, 207: 500, 215: 1, 218: 40, 219: 24, 223: 40, 222: 50, 351: 1,
    366: 0, 367: 0, 370: 1, 375: 60, 248: 60, 377: 2, 335: 20, 239: 1.5, 355: 1, 356: -9, 357: 0, 358: 0, 359: 2,
    360: 0, 254: 90, 257: 0, 256: 0, 258: 1, 385: 400, 386: -6, 389: 0,
    227: 0, 253: 700, 424: 60, 425: 60, 437: 0, 439: 0, 571: 20, 572: 6, 573: 1, 220: 2, 368: 0, 369: 0, 338: 0, 347: 0,
    348: 0, 349: 0,
}  # fmt: skip
#: Values of cycles in which the likely ones mean something else.
OF_CYCLE = {"CYCLE899": {"VARI": 1001}, "CYCLE79": {"NUM": 6, "VARI": 1}}
TOOL = 8.0
#: Blocks of contours: most are lines and arcs, the others are no business of one.
BLOCKS = (
    "X{}", "Y{}", "X{} Y{}", "X{} Y{}", "G1 X{} Y{}", "G3 X{} Y{} CR={}", "G2 X{} Y{} I{} J{}", "X{} RND={}",
    "Y{} CHR={}", "X=IC({})", "R1=R1+1", "Y=R1 F{}", "G91 X{}", "G90 Y{}",
    "AP={} RP={}", "Z{}", "M8", "G0 X{}", "TRANS X{}", "G41 X{}", "LOOP", "ENDLOOP", "GOTOB BEGIN", "M30", "C{}",
    "G4 F1", "POCKET4(1)", "G70 X{}", "T2", "MSG(", "RNDM={}", "CFC", "COMPON",
)  # fmt: skip
CONTOUR = {
    **dict.fromkeys(CONTOURS["CYCLE72"][17:], 0),
    "KNAME": '"BEGIN:END"',
    "FAL": 0,
    "FALD": 0,
    "VARI": 1,
    "RL": 41,
    "AS1": 2,
    "LP1": 5,
    "FF3": 900,
    "AS2": 1,
    "LP2": 5,
}


def make_contour(rng, value):
    """CYCLE72 with a contour, most of whose blocks are lines and arcs."""
    likely = {
        **CONTOUR,
        "VARI": rng.choice((1, 2, 11, 101, 211, 301)),
        "RL": rng.choice((40, 41, 42)),
        "AS1": rng.choice((1, 1, 2, 3)),
    }
    words = [likely[name] if name in likely and rng.random() < 0.97 else value(name) for name in CONTOURS["CYCLE72"]]
    kinds = BLOCKS[: rng.choice((7, 7, 9, 14, len(BLOCKS)))]
    sizes = (*range(-60, 60, 4), *range(1, 30))
    blocks = [re.sub("{}", lambda _found: str(rng.choice(sizes)), rng.choice(kinds)) for _ in range(rng.randrange(7))]
    call = f"CYCLE72({','.join(map(str, words[: rng.choice((14, 17, 23))]))})"
    contour = "\n".join(["BEGIN: G0 X0 Y0 G90", "G1 Y40", *blocks, "END:"])
    return f"T1 D1 M6\nG0 X10 Y20 Z40 S1000 M3 F300\n{call}\nG0 Z99\nM30\n{contour}\n"


def make_program(seed, only=None):
    """Language and text of a program with one cycle, of any kind or one of ``only``."""
    rng = random.Random(seed)

    def value(name):
        return LIKELY[name] if name in LIKELY and rng.random() < 0.95 else rng.choice(NUMBERS)

    if only is None and rng.random() < 0.3:
        return "siemens", make_contour(rng, value)
    if only is not None or rng.random() < 0.5:
        name = rng.choice(sorted(PARAMETERS) if only is None else only)
        special = OF_CYCLE.get(name, {})
        values = ",".join(
            "" if rng.random() < 0.05 else str(special[one] if one in special and rng.random() < 0.9 else value(one))
            for one in PARAMETERS[name][: rng.randint(8, 40) if rng.random() < 0.3 else None]
        )
        return "siemens", f"T1 D1 M6\nG0 X10 Y20 Z40 S1000 M3 F300\n{name}({values})\nG0 Z99\nM30\n"
    number = rng.choice([*CYCLES, 241, *THREADS])
    needs, defaults = MACHINING[number]
    names = [*needs, *(name for name in defaults if rng.random() < 0.3)]
    words = " ".join(f"Q{name}={value(name):.9f}" for name in names)
    return (
        "heidenhain",
        "BEGIN PGM C MM\n"
        "TOOL CALL 1 Z S1000 F300\n"
        "L X+10 Y+20 Z+40 R0 FMAX M3\n"
        f"CYCL DEF {number} C {words}\n"
        "CYCL CALL\n"
        "L Z+99 FMAX\n"
        "END PGM C MM\n",
    )


def try_program(seed, only=None):
    """Execute a program; it ends in time, in findings of its lines or in moves that reach the part."""
    dialect, text = make_program(seed, only)
    begin = time.process_time()
    options = Options(
        dialect=dialect,
        tools={1: make_tool(1, 10.0, TOOL)},
        max_repeats=3_000,
        control={"siemens": {"polygon_angle": "side"}},
    )
    moves, findings = view_moves_plainly(text.encode(), options)
    assert time.process_time() - begin < 5.0, text
    if findings:
        assert all(item.code.startswith("VP0") and item.line in (3, 4, 5, *range(6, 15)) for item in findings), (
            text,
            findings,
        )
    else:
        assert len(moves) > 2, text
        assert np.isfinite(moves.end).all(), text
        assert moves.end[-1][2] == 99, text
    return not findings


def test_values_at_random():
    """A share of what docs/trials.md tells: hundreds of thousands."""
    assert sum(try_program(seed) for seed in range(150)) > 22


def make_pocket(seed):
    """A Klartext cycle with sound values, the shape that it mills, and the blank of a stud."""
    rng = random.Random(seed)
    pick = rng.choice
    x, y = rng.uniform(-30, 30), rng.uniform(-30, 30)
    side, floor = pick([0, 0.3]), pick([0, 0.2])
    q = {
        215: 0 if side or floor else 1,
        368: side,
        369: floor,
        207: 500,
        351: pick([1, -1]),
        201: -6,
        202: pick([6, 2.5]),
        206: 100,
        338: pick([0, 2]),
        200: 2,
        203: 0,
        204: 50,
        370: rng.uniform(0.6, 1.99),
        366: pick([0, 1, 2]),
        385: 400,
    }
    number, blank = pick([251, 252, 253, 254, 256, 257, 258]), None
    if number == 251:
        q |= {218: rng.uniform(14, 60), 219: rng.uniform(14, 60), 224: rng.uniform(-180, 180), 367: 0}
        q[220] = rng.uniform(0, 0.5 * min(q[218], q[219]))
        shape = rectangle(q[218], q[219], max(q[220], 0.5 * TOOL), q[224], (x, y))
    elif number == 252:
        q |= {223: rng.uniform(14, 60), 366: pick([0, 1])}
        shape = circle(0.5 * q[223], (x, y))
    elif number == 256:
        q |= {218: rng.uniform(5, 40), 219: rng.uniform(5, 40), 224: rng.uniform(-180, 180), 367: 0, 437: 0}
        q |= {
            424: q[218] + rng.uniform(0, 40),
            425: q[219] + rng.uniform(0, 40),
            220: rng.uniform(0, 0.5 * min(q[218], q[219])),
        }
        shape, blank = (
            rectangle(q[a], q[b], corner, q[224], (x, y)) for a, b, corner in ((218, 219, q[220]), (424, 425, 0))
        )
    elif number == 257:
        q |= {223: rng.uniform(5, 40), 376: rng.uniform(0, 360)}
        q[222] = q[223] + rng.uniform(0, 40)
        shape, blank = circle(0.5 * q[223], (x, y)), circle(0.5 * q[222], (x, y))
    elif number == 258:
        q |= {573: pick([0, 1]), 571: rng.uniform(5, 40), 572: rng.randint(3, 30), 224: rng.uniform(-180, 180)}
        inradius = 0.5 * q[571] * (math.cos(math.pi / q[572]) if q[573] else 1.0)
        q |= {220: rng.uniform(0, inradius), 222: q[571] + rng.uniform(0, 40)}
        shape, blank = polygon(q[572], inradius, q[220], q[224], (x, y)), circle(0.5 * q[222], (x, y))
    else:
        q[219] = rng.uniform(TOOL + 2 * side, 15.9)
        if number == 253:
            q |= {218: q[219] + rng.uniform(1, 40), 374: rng.uniform(-180, 180), 367: 0}
            shape = rectangle(q[218], q[219], 0.5 * q[219], q[374], (x, y))
        else:
            q |= {
                375: rng.uniform(50, 90),
                216: x,
                217: y,
                376: rng.uniform(-180, 180),
                248: rng.uniform(20, 250),
                378: 0,
                377: 1,
            }
            shape = curved_slot(0.5 * q[375], q[376], q[248], q[219], (x, y))
    needs = {name: q[name] for name in (*MACHINING[number][0], *MACHINING[number][1]) if name in q}
    return number, needs, (x, y), shape, blank


def try_pocket(seed):
    """Mill a pocket with sound values; the judge looks at it. Returns the number of the cycle."""
    number, q, (x, y), shape, blank = make_pocket(seed)
    words = " ".join(f"Q{name}={value:.9f}" for name, value in q.items())
    text = (
        "BEGIN PGM C MM\n"
        "TOOL CALL 1 Z S1000 F300\n"
        f"L X{x:.9f} Y{y:.9f} Z+40 R0 FMAX M3\n"
        f"CYCL DEF {number} C {words}\n"
        "CYCL CALL\n"
        "END PGM C MM\n"
    )
    moves, findings = view_moves_plainly(
        text.encode(), Options(dialect="heidenhain", tools={1: make_tool(1, 10.0, TOOL)})
    )
    assert findings == (), (seed, text)
    judge(moves, 0.5 * TOOL, shape, 0.0, -6.0, blank=blank)
    return f"of cycle {number}"


@pytest.mark.parametrize("first", range(0, 40, 10))
def test_pockets_at_random(first):
    for seed in range(first, first + 10):
        try_pocket(seed)


if __name__ == "__main__":
    if sys.argv[3:] == ["pockets"]:
        del sys.argv[3:]
        sys.exit(study(try_pocket))
    count, first, names = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
    if unknown := set(names) - {"siemens", "heidenhain", *PARAMETERS}:
        sys.exit(f"no language, and no cycle with values at random: {', '.join(sorted(unknown))}")
    cycles = [name for name in names if name in PARAMETERS] or None
    seeds = (seed for seed in itertools.count(first) if cycles or not names or make_program(seed)[0] in names)
    good = sum(try_program(seed, cycles) for seed in itertools.islice(seeds, count))
    sys.stdout.write(f"{count} programs from {first} on, {good} without an error\n")
