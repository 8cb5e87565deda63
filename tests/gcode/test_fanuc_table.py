"""docs/fanuc.md: every example of its tables is executed, without effect, or refused, as the table says."""

import re
from pathlib import Path

import numpy as np
import pytest

from verne_post import check
from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode.codes import RS274, spell_g_code
from verne_post.gcode.plain_setup import build_plain_setup
from verne_post.gcode.read import interpret_program
from verne_post.gcode.rs274.fanuc_codes import make_table
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

PAGE = Path(__file__).resolve().parents[2] / "docs" / "fanuc.md"
BEFORE = """%
O1
G17 G21 G40 G80 G90 G94 G98
T1 M6
G54 G0 X20. Y5. Z30. A0 C0 S1000 M3
G0 G43 H1 Z30. F400""".splitlines()
AFTER = """G0 X30. Y5. Z30.
G1 Y15. F500
G0 Z40.
M30
%""".splitlines()


def read_rows(title):
    """Words and blocks of the examples of one table."""
    section = PAGE.read_text(encoding="utf-8").split(f"## {title}\n")[1].split("\n## ")[0]
    found = []
    for line in section.splitlines():
        cells = re.split(r"(?<!\\)\|", line)
        if len(cells) == 5 and "---" not in line and "`" in cells[2]:
            examples = re.findall("`([^`]+)`", cells[2])
            found += [
                pytest.param(example.split(" / "), id=f"{cells[1].strip()} {example}"[:40]) for example in examples
            ]
    return found


@pytest.fixture(scope="module")
def outcome(machine):
    """Everything that a program does, as comparable values, and its findings."""
    tools = {number: Tool(number, number, (0.0, 0.0, 78.0 + 2.0 * number, *(0.0,) * 6), 8.0) for number in (1, 2)}
    systems = dict.fromkeys(("G54", "G55", "G54.1P3"), (0.0, 0.0, 40.0))
    options = Options(tools=tools, dialect="fanuc", tapping="feed", wcs=systems)

    def run(blocks):
        try:
            moves = interpret_program(
                "\n".join([*BEFORE, *blocks, *AFTER]).encode(), build_interpreter_setup(machine, options)
            )
        except InputError as error:
            return None, error.findings
        columns = (moves.kind, moves.end, moves.feed, moves.feed_mode, moves.spindle, moves.tool_axis)
        shown = [np.round(np.nan_to_num(column), 9).tolist() for column in columns]
        frames = [moves.frames[index] for index in moves.frame]
        controls = [moves.controls[index] for index in moves.control]
        arcs = [np.round(column, 9).tolist() for column in (moves.arcs.center, moves.arcs.sweep)]
        silent = ("without effect", "smoothing", "look-ahead")
        events = [(event.kind, event.before, event.data) for event in moves.events if event.kind not in silent]
        return (shown, frames, controls, arcs, events), ()

    return run


@pytest.mark.parametrize("example", read_rows("Executed"))
def test_executed(outcome, example):
    done, findings = outcome(example)
    assert findings == ()
    assert done != outcome([])[0]


@pytest.mark.parametrize("example", read_rows("Without effect"))
def test_without_effect(outcome, example):
    done, findings = outcome(example)
    assert findings == ()
    assert done == outcome([])[0]


@pytest.mark.parametrize("example", read_rows("Refused"))
def test_refused(outcome, example):
    done, findings = outcome(example)
    assert done is None
    first = findings[0]
    assert len(BEFORE) < first.line <= len(BEFORE) + len(example)
    assert first.code in {"VP002", "VP005", "VP006", "VP007", "VP012", "VP015", "VP017", "VP023", "VP025"}
    words = set(re.findall(r"[A-Z]+|\d+", " ".join(example)))
    assert words & set(re.findall(r"[A-Z]+|\d+", first.message)), first.message


@pytest.mark.parametrize("table", [RS274, make_table()], ids=["rs274", "fanuc"])
def test_refused_codes_are_refused_with_the_reason_of_the_vocabulary(table):
    dialect = "rs274" if table is RS274 else "fanuc"
    codes = {spell_g_code(code): why for code, why in table.refused_g.items()}
    codes |= {f"M{code}": why for code, why in table.refused_m.items()}
    for code, why in codes.items():
        with pytest.raises(InputError) as caught:
            interpret_program(f"G0 X1.\n{code}\nM30\n".encode(), build_plain_setup(dialect=dialect))
        (found,) = caught.value.findings
        assert (found.code, found.line) == ("VP002", 2)
        assert why in found.message


@pytest.mark.parametrize(
    ("head", "begin", "end", "line"),
    [
        ("G40 G80", "D1 X-25. F500.", "G40 X-40.", 6),
        ("G40 G80", "G41 D1 X-25. F500.", "G40 X-40.", None),
        ("G40 G80", "D1 X-25. F500.", "G0 Z50.", None),  # a D that no G40 ends may be of another control
        ("G40 G80", "D1 X-25. F500.", "G40", None),  # a safety line
        ("G40 G80 D1", "X-25. F500.", "G0 G40 Z50.", None),
    ],
)
def test_a_d_that_no_g41_uses_before_g40(machine, head, begin, end, line):
    text = f"%\nO1\nT1 M6\n{head}\nG54 G90 G43 H1 G0 X0. Y0. Z60. A0. C0. S9 M3\nG1 {begin}\nY9.\n{end}\nM30\n%\n"
    options = Options(
        dialect="fanuc", wcs={"G54": (0, 0, 0)}, tools={1: Tool(1, 1, (0, 0, 80.0, 0, 0, 0, 0, 0, 0), 6.0)}
    )
    findings = check(text.encode(), machine, options).findings
    assert not [one for one in findings if one.severity == "error"]
    assert [one.line for one in findings if one.code == "VP026"] == ([] if line is None else [line])
