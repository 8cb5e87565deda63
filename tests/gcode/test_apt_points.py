"""Stretches of GOTO in cutter location text are executed as arrays, and give what single lines give.

A remark at the end of every line keeps a text from being read as stretches, and changes nothing else.
"""

import random

import numpy as np
import pytest

from tests.gcode.conftest import assert_same_moves
from verne_post import check
from verne_post.app.assemble import view_moves_plainly
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

HEADS = [
    "",
    "MULTAX/ON",
    "MULTAX/ON",
    "MULTAX/ON",
    "MULTAX/ON\nUNITS/INCHES",
    "MULTAX/ON\nRAPID",
    "MULTAX/ON\nCYCLE/DRILL,DEPTH,2,CLEAR,1",
    "MULTAX/ON\nTRACUT/1,0,0,5,0,1,0,6,0,0,1,7",
    "MULTAX/ON\nCIRCLE/0,0,0,0,0,1,5",
    "ROTABL/0,AAXIS,90,CAXIS",
    "MULTAX/ON\nFEDRAT/2,MMPR",
    "FEDRAT/0",
    "TLAXIS/0,0.6,0.8",
    "MULTAX/ON\nDEFSUB/A",
    "MULTAX/ON\nPPRINT a $",
]
ODD = [
    "GOTO/1,2", "GOTO/1,2,3,0,0,2", "GOTO/1,2,3,4", "goto/1,2,3", "GOTO/1D1,2,3", "GOTO/1,2,3,0,1,0 ", "RAPID",
    "COOLNT/ON", "GOTO/1e9,0,0",
    "GOTO/1,,3", "GOTO/1,2,3 $", "FEDRAT/700", "GODLTA/0,0,1", "GOTO/1_0,2,3", "GOTO/nan,0,0", "GOTO/1 2,3,4", "",
    "STOP", "FINI", "ENDSUB\nCALSUB/A",
    "GOTO/1E300,0,0", "GOTO/0,0,0,0,0,1E-400",
]  # fmt: skip


def lines(pick):
    """A stretch of about 60 lines, most of them plain."""
    found, tilt, turn = [], pick.uniform(-20, 20), pick.uniform(-180, 180)
    with_axis = pick.choice([0.0, 0.5, 1.0])
    for _ in range(60):
        tilt, turn = pick.choice([tilt + pick.uniform(-6, 6)] * 9 + [0.0]), turn + pick.uniform(-40, 60)
        a, c = np.radians(tilt), np.radians(turn)
        numbers = [pick.uniform(-20, 20) for _ in range(3)]
        if pick.random() < with_axis:
            numbers += [np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)]
        form = pick.choice(["{:.4f}", "{:.6f}", "{:.3e}", "{:+.5f}"])
        blank = pick.choice(["", "", " "])
        found.append(f"{blank}GOTO{blank}/{blank}" + f"{blank},{blank}".join(form.format(value) for value in numbers))
        if pick.random() < 0.02:
            found.append(pick.choice(ODD))
    return found


def view(text):
    return view_moves_plainly(text.encode(), Options(dialect="aptcl", tools={1: Tool(1, 1, (0.0,) * 9)}))


@pytest.mark.parametrize("seed", range(150))
def test_stretches_are_their_lines(seed):
    pick = random.Random(seed)
    end = pick.choice(["\n", "\r\n"])
    text = [
        "PARTNO/A",
        "LOADTL/1",
        "FEDRAT/500,MMPM",
        "GOTO/1,2,3",
        *pick.choice(HEADS).split("\n"),
        *lines(pick),
        *pick.choice(ODD).split("\n"),
        *lines(pick),
        pick.choice(["FINI", ""]),
    ]
    text = [part for line in text for part in line.split("\n")]
    fast, fast_errors = view(end.join(text))
    single = [line if not line.strip().startswith("GOTO") or "$" in line else line + " $$ alone" for line in text]
    slow, slow_errors = view(end.join(single))
    assert fast_errors == slow_errors
    assert_same_moves(fast, slow)
    assert [(event.line, event.kind) for event in fast.events] == [(event.line, event.kind) for event in slow.events]


def test_stretches_are_executed_as_arrays(stretches):
    points = [f"GOTO/{number},0,5,0,0.6,0.8" for number in range(40)]
    view("\n".join(["FEDRAT/9", "MULTAX/ON", *points, "RAPID", *points, "FINI"]))
    assert stretches == [39, 38]  # the first, and after RAPID the second, set the modes


@pytest.mark.parametrize(
    ("written", "meant", "place"),
    [
        ("SPINDL/RPM,900,CWL", "CLW", (2, 16)),
        ("FEDRAT/MMPN,250", "MMPM", (2, 8)),
        ("LOADTL/3,LENGHT,80", "LENGTH", (2, 10)),
        ("CYCLE/DRILL,DEPHT,5,MMPM,100,CLEAR,2", "DEPTH", (2, 13)),
        ("GOTO/20.0,0.0-2.0", "0.0,-2.0", (2, 11)),
        ("GOTO 20,0,5", "GOTO/20", (2, 1)),
        ("GOTO/20.0;0.0,2.0", "20.0,0.0", (2, 6)),
        ("GOTO/20.0,,0.0,2.0", "20.0", (2, 6)),
        ("GOTO/20.0,0..5,2.0", "0.5", (2, 11)),
        ("PARTN BLADE", "PARTNO", (2, 1)),
    ],
)
def test_a_slip_in_a_statement_names_what_is_meant(written: str, meant: str, place: tuple[int, int]) -> None:
    source = f"RAPID\n{written}\nFINI\n".encode()
    options = Options(dialect="aptcl", tool_length=80.0, wcs={"G54": (0, 0, 60)})
    (item,) = [one for one in check(source, "verne", options).findings if one.severity == "error"]
    assert (item.line, item.column) == place
    assert item.message.endswith(f"did you mean {meant}?")


def test_an_arc_that_is_refused_is_told_once() -> None:
    """The points and the rapid behind it were errors of the arc too."""
    arc = "CIRCLE/20,12,0,0,0,1,10\nGOTO/30,10,0\nGOTO/30,20,0\nRAPID\nGOTO/30,20,50\nEND-OF-PATH\nFINI\n"
    source = f"PARTNO A\nRAPID\nGOTO/20,0,0\nFEDRAT/500,MMPM\n{arc}".encode()
    options = Options(dialect="aptcl", tool_length=80.0, wcs={"G54": (0, 0, 60)})
    found = [one for one in check(source, "verne", options).findings if one.severity == "error"]
    assert [(one.code, one.line) for one in found] == [("VP008", 6)]
