"""Controller dialects: how they are recognised, what their words mean, and that they give what their RS274
twins give.
"""

import json
import math
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import verne_post
from tests.gcode.conftest import make_tool
from verne_post import convert
from verne_post.app.assemble import build_interpreter_setup, read_draft, view_moves_plainly
from verne_post.config.subprograms import collect_subprograms
from verne_post.gcode.dialects import DIALECTS, choose_dialect
from verne_post.gcode.read import interpret_program
from verne_post.model.control_keys import Rs274Keys, read_keys
from verne_post.model.findings import InputError, UsageError
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool, WorkOffset

PACKAGE = Path(verne_post.__file__).parent
#: A dialect whose programs begin with HELLO.
DUMMY = '''
"""Only a test has this dialect."""
from functools import partial
from verne_post.gcode.dialect import Dialect, names_axis_in_blocks
from verne_post.gcode.initial_state import make_initial_state
from verne_post.gcode.rs274.run import execute_blocks
from verne_post.gcode.rs274.interpreter import Rs274


class _Hello(Rs274):
    @classmethod
    def prepare(cls, text):
        return text.replace("HELLO", "")

    def read(self, text, line):
        return super().read(self.prepare(text), line)


DIALECT = Dialect(
    lambda source: source[:5] == b"HELLO",
    make_initial_state,
    partial(execute_blocks, language=_Hello),
    names_axis_in_blocks,
)
'''
SAMPLES = Path(__file__).parents[2] / "gcode_samples"


@pytest.mark.parametrize(("text", "name"), [
    ("G0 X1\nM2", "rs274"), ("%\nO1000 (prog)\nG0 X1\nM30\n%", "fanuc"), ("O1000\nG0 X1", "fanuc"),
    ("O1000 (A)\nG0 X1\n", "fanuc"), ("O1000\n#<a>=1", "rs274"), ("o100 sub\no100 endsub", "rs274"),
    ("%\nO1000\nG64 P.01", "rs274"), ("%\nO1\nG43.4 H1\nG10 L20 P1 Z0", "rs274"),
    ("%\nO1\nG64 P0.01\nG43.4 H1", "rs274"), ("%\nO1\nG64 P0.01\nG54.1 P1", "fanuc"),
    ("%\nO1\n(G64 P1)\nG43.4 H1\nG61.1", "fanuc"), ("%\nO1\nG61.1", "rs274"), ("O1\nIF [1 EQ 1] GOTO 5\nN5", "fanuc"),
    ("%\nO1\nG64\nG43.4 H1", "fanuc"), ("%\nO1\nG41.1 D1 X20.", "fanuc"), ("G41.1 D1 X20.", "rs274"),
    ("%\nO1\nG54.1 P1\nG10 L20 P1 Z0", "fanuc"), ("%\no100 sub\n", "rs274"), ("", "rs274"),
    ("% O1000\nG0 X1\n%", "fanuc"), ("%PROG-NC\nG0", "fanuc"), ("%\n:1000\nG0 X1", "fanuc"),
    ("%\nN10 G40 G17\nN20 G65 P9021 T1", "fanuc"), ("G0 X1\nG05 P10000\nX2", "fanuc"), ("G0 X1\nG5.1 Q1", "fanuc"),
    ("G0 X1\nG5 P1 Q1 X5", "rs274"), ("G0 X1\nM2\nO100\nG4 P2\nM99", "rs274"),
    ("G0 X1\nM2\no1 sub", "rs274"), ("#<a>=1\nGOTO 5", "rs274"),
    ("M2\n(IF [1 EQ 1] GOTO 5)", "rs274"),
    ("#<a>=1\nG65 P1", "rs274"), ("G0 X1 (G65 P1)", "rs274"), ("%\nO1000\nG68.2 X0", "fanuc"),
    ("%\nO1(A)\n(x)\nN1G54.1P2", "fanuc"), ("%\nO1\nM98 P20005", "fanuc"), ("%\nO1\n(G54.1 P2)\nG43.1 Z3", "rs274"),
    ("LISTING\n%\nO1\nG43.1 Z3 H1", "fanuc"), ("%\nO1 G90 (A)\nG0 X1", "fanuc"), ("LISTING\nO1\n%\nO1", "rs274"),
    ("%\nO12 sub\nG43.4", "rs274"),
    ("%\nO1\n#<a>=1", "rs274"), ("PARTNO/ X\n", "aptcl"), ("$$ remark\n\nMULTAX/ON", "aptcl"), ("UNITS / MM", "aptcl"),
    ("from/0,0,0", "aptcl"), ("G0 (PARTNO/)", "rs274"), ("%_N_A_MPF\nG0 X1", "siemens"),
    ("; x\n;$PATH=/_N_WKS_DIR\nG0", "siemens"), ("N10 TRAORI\n", "siemens"),
    ("G0 X=R1", "siemens"), ("DEF REAL A", "siemens"), ("MSG(\"A\")", "siemens"), ("(MSG, A)\nG0", "rs274"),
    ("G0 (TRAORI)", "rs274"), ("G0 ; TRAORI", "rs274"), ("%\nO1 (X=1)\nG0", "fanuc"),
    ("G0 X#1 (SUPA)\nTRAORI", "rs274"), ("N5 MCALL CYCLE81 (52,50,2,-4,)", "siemens"), ("T=\"A\"", "siemens"),
    ("R1 = 5", "siemens"), ("G81 X1 R2 Z-3\nG80", "rs274"),
])  # fmt: skip
def test_recognised_by_the_header(text, name):
    assert choose_dialect("auto", text.encode(), "") is DIALECTS[name]
    assert choose_dialect("fanuc", text.encode(), "") is DIALECTS["fanuc"]
    assert sum(dialect.recognise(text.encode()) for dialect in DIALECTS.values()) <= 1


@pytest.mark.parametrize(
    ("sample", "right", "wrong", "name"),
    [
        ("tests/corpus/rs274/plate.ngc", "I-4 J0", "I=4 J0", "rs274"),
        ("tests/corpus/rs274/plate.ngc", "G40 G49", "G644 G49", "rs274"),
        ("gcode_samples/two_faces.cls", "PARTNO", "PARTN0", "aptcl"),
        ("tests/corpus/apt/thread.cls", "TOOL PATH", "TOOLPATH", "aptcl"),
        *(("tests/corpus/fanuc/umc.nc", "O4 (", wrong, "fanuc") for wrong in ("P4 (", "4O (", "O (", "%\nO4 (")),
        ("tests/corpus/siemens/side.mpf", "%_N_", "%_B_", "siemens"),
        ("tests/corpus/siemens/side.mpf", "TRAFOOF", "#1=1", "siemens"),
        ("gcode_samples/two_faces_fanuc.nc", "O1300 (BRACKET, TWO FACES, AS TWO_FACES.NC)\n", "", "fanuc"),
        ("gcode_samples/two_faces_fanuc.nc", "%\nO1300", "5\nO1300", "fanuc"),
    ],
)
def test_a_slip_does_not_make_a_program_one_of_another_language(sample, right, wrong, name):
    """I=4 alone made RS274/NGC a program of Siemens, whose errors were G21 and G43."""
    text = (SAMPLES.parent / sample).read_text("utf-8")
    assert right in text
    assert choose_dialect("auto", text.replace(right, wrong, 1).encode(), "") is DIALECTS[name]


@pytest.mark.parametrize("first", ["5_N_A_MPF", "_N_A_MPF", "%N_A_MPF", "%_N_A_MFP", "%_N_AMPF", "5_N_A_SPF"])
def test_a_first_line_with_a_slip_shows_siemens_where_no_other_word_does(first):
    text = f"{first}\nN10 G17 G54 G90\nN20 G0 X1\nM30\n"
    assert choose_dialect("auto", text.encode(), "a.nc") is DIALECTS["siemens"]


def test_a_title_without_parentheses_says_how_its_line_was_read(view):
    """The list of words of RS274/NGC was no help to who writes Fanuc programs."""
    (found,) = view("O2001 BRACKET\nG0 X1\nM30")[1]
    assert found.code == "VP023"
    assert found.message.endswith(
        "These are words of RS274/NGC (LinuxCNC); a title is written in parentheses, as in O2001 (BRACKET)"
    )
    (found,) = view("o2001 sbu\nG0 X1\nM30")[1]
    assert "parentheses" not in found.message


_WITH_TOLERANCE = "G21 G90 G64 G17 P0.01\nG64 G17 P0.02\nG0 X1\nM30\n%"
_READ_AS = "; the program was read as fanuc because of {}; if it is rs274, --dialect rs274 reads this word"


@pytest.mark.parametrize(
    ("begin", "sign"),
    [
        ("%\nO1001 (A)\n", "O1001"),
        ("O7\n", "O7"),
        ("% O1\n", ""),
        ("%\nO1\nG999\n", "O1"),
        ("%\nO1\nG43.4 H1\n", "O1"),
        ("%\nO1\nG68.2 X0 Y0 Z0 I0 J0 K0\n", ""),
        ("%\nO1\nIF [1 EQ 1] GOTO 5\nN5\n", ""),
    ],
)
def test_a_word_of_the_other_dialect_says_why_the_program_was_read_as_this(machine, begin, sign):
    """Once, and only where RS274/NGC reads whatever Fanuc reads in the program.

    G68.2, GOTO and words after % it does not read.
    """
    text = begin + _WITH_TOLERANCE
    for dialect in ("auto", "fanuc"):
        options = Options(dialect=dialect, tool_length=60.0, wcs={1: WorkOffset((0.0, 0.0, 100.0))})
        with pytest.raises(InputError) as refusal:
            interpret_program(text.encode(), build_interpreter_setup(machine, options))
        messages = [item.message for item in refusal.value.findings if item.code == "VP006"]
        hint = _READ_AS.format(sign) if sign and dialect == "auto" else ""
        assert messages == [f"nothing in the block uses P0.01{hint}", "nothing in the block uses P0.02"]


def test_the_first_error_alone_says_it_too(view):
    (item,) = view("O3\n" + _WITH_TOLERANCE)[1]
    assert item.message == "nothing in the block uses P0.01" + _READ_AS.format("O3")


def test_samples_are_recognised():
    for path in SAMPLES.glob("*.*"):
        if path.suffix in (".nc", ".cls", ".h", ".mpf"):
            wanted = {
                "fanuc_nurbs.nc": "fanuc",
                "fanuc_tilted.nc": "fanuc",
                "posted.nc": "fanuc",
                "wing.cls": "aptcl",
                "two_faces.cls": "aptcl",
                "two_faces.h": "heidenhain",
                "two_faces_fanuc.nc": "fanuc",
                "two_faces.mpf": "siemens",
            }.get(path.name, "rs274")
            assert choose_dialect("auto", path.read_bytes(), "") is DIALECTS[wanted], path.name
    assert set(DIALECTS) == {"rs274", "fanuc", "aptcl", "heidenhain", "siemens"}


def test_a_new_file_is_a_new_dialect(tmp_path):
    """A copy of the package with one more file: the command line lists the dialect, recognises and executes it."""
    shutil.copytree(PACKAGE, tmp_path / "verne_post", ignore=shutil.ignore_patterns("__pycache__"))
    if (PACKAGE.parent / "machine_configs").is_dir():  # beside the package in a checkout, inside it when installed
        shutil.copytree(PACKAGE.parent / "machine_configs", tmp_path / "machine_configs")
    (tmp_path / "verne_post" / "gcode" / "dialects" / "dummy.py").write_text(DUMMY)
    (tmp_path / "program.nc").write_text("HELLO\nG0 X5\nM2\n")

    def run(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "verne_post", *arguments],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(tmp_path)},
            capture_output=True,
            text=True,
            check=False,
        )

    assert "dummy" in run("check", "--dialect", "no-dialect", "program.nc").stderr
    for options in ([], ["--dialect", "dummy"]):
        result = run("dump", "moves", *options, "program.nc")
        assert (result.returncode, result.stderr) == (0, "")
        assert json.loads(result.stdout.splitlines()[0])["end"][0] == 5.0


def test_a_code_that_one_language_has_may_be_remapped_in_another(view):
    """M51 is an override in RS274/NGC, and the builder's on a Fanuc control; M3 has a meaning in both."""
    text, remap = "G0 X1\nM51\nG0 X2", {"M51": "ignore"}
    moves, findings = view(f"%\nO1\n{text}\nM30\n%", dialect="fanuc", remap=remap)
    assert findings == ()
    assert moves.end[-1][0] == 2
    found = view(f"{text}\nM2", dialect="rs274", remap=remap)[1]
    assert [(item.code, item.line, "remap" in item.message) for item in found] == [("VP002", 2, True)]
    with pytest.raises(UsageError, match="M3"):
        view(text, dialect="fanuc", remap={"M3": "ignore"})


def test_axes_beside_an_m_code_of_the_builder_are_those_of_the_motion(view):
    """Controls have M codes in blocks of motion; a G code of the user may take the axis words."""
    moves, findings = view("G0 X1\nX2 M51\nM2", dialect="fanuc", remap={"M51": "event"})
    assert findings == ()
    assert moves.end[-1][0] == 2
    found = view("G0 X1\nX2 G68.4\nM2", dialect="rs274", remap={"G68.4": "event"})[1]
    assert [(item.code, item.line) for item in found] == [("VP006", 2)]


def test_g43_without_h_has_the_last_one_since_the_tool_change(view):
    tools = {number: Tool(number, number, (0.0, 0.0, 70.0 + number, *(0.0,) * 6), 8.0) for number in (1, 2)}
    head = "%\nO1\nG21 G90\nT1 M6\nG0 X0 Y0\nG43 H1 Z50.\nG49\n"

    def run(text):
        return view(f"{head}{text}\nM30\n%", dialect="fanuc", tools=tools)

    one, two = (run(text) for text in ("G43 Z40.\nX1.", "G43 H1 Z40.\nX1."))
    assert (one[1], two[1]) == ((), ())
    lengths = [[moves.frames[index].tool_length for index in moves.frame] for moves in (one[0], two[0])]
    assert lengths[0] == lengths[1]
    assert lengths[0][-1] == 71
    for text, line in (("T2 M6\nG43 Z40.", 9), ("T2 M6 G43 Z40.", 8)):
        assert [(item.code, item.line) for item in run(text)[1]] == [("VP005", line)]


def test_what_holds_before_any_code_of_motion(view):
    """Parameter 3402: refused with the key that says it, then rapid traverse or feed; G80 is no beginning.

    Cycles are a modal group of their own: after G80 the code from before the cycle holds, as programs of CAM systems
    use it.
    """
    text = "%\nO1\nG21 G90 G80 F90\nX2 Y3{}\nM30\n%"
    found = view(text.format(""), dialect="fanuc")[1]
    assert [(item.code, item.line, "[fanuc] motion" in item.message) for item in found] == [("VP005", 4, True)]
    for motion, kind in (("G0", MoveKind.RAPID), ("G1", MoveKind.FEED)):
        moves, findings = view(text.format(""), dialect="fanuc", control={"fanuc": {"motion": motion}})
        assert (findings, moves.kind.tolist()) == ((), [kind])
    for code, kind in (("G0", MoveKind.RAPID), ("G1", MoveKind.FEED)):
        for between in ("", "G98 G81 X7 Z-1 R2\n", "G81 X7 Z-1 R2\nG99 G82 X8 Z-2 P9\nX9\n"):
            moves, findings = view(f"O1\nG21 G90 F90\n{code} X9 Y1 Z5\n{between}G80\nZ50.\nM30", dialect="fanuc")
            assert (findings, moves.kind[-1], moves.end[-1, 2]) == ((), kind, 50.0)
    found = view("O1\nG21 G90 F90\nG0 X9 Y1 Z5\nG81 X7 Z-1 R2\nG80\nZ50.\nM2", dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [("VP005", 6)]  # no code of motion holds there after G80


def test_arcs_without_centre_and_radius(view):
    """Bit 5 of parameter 3403: an alarm (1), here with the key that is 0; then a line to where the arc would end."""
    places = [(x, x % 7) for x in range(1, 60)]
    arcs = "".join(f"G{2 + x % 2} X{x}. Y{y}.\n" for x, y in places)
    text = f"%\nO1\nG21 G90 G17 F90\nG0 X0 Y0 Z5.\n{arcs}X60. Y0\nG2 X70. I5.\nM30\n%"
    found = view(text, dialect="fanuc")[1]
    assert [(item.code, item.line, "[fanuc] bare_arcs" in item.message) for item in found[:1]] == [("VP005", 5, True)]
    moves, errors = view(text, dialect="fanuc", control={"fanuc": {"bare_arcs": "lines"}})
    assert errors == ()
    assert [(item.code, item.severity, item.line) for item in moves.findings] == [
        ("VP039", "note", 5),
        ("VP039", "note", 6),
    ]
    assert moves.kind[1:].tolist() == [MoveKind.FEED] * 60 + [MoveKind.ARC]  # one with its centre stays an arc
    assert moves.end[1:60, :2].tolist() == [list(map(float, place)) for place in places]
    assert [item.code for item in view(text.replace("O1", ""), dialect="rs274")[1][:1]] == ["VP005"]


def test_d_holds_the_wear_where_the_path_is_that_of_the_centre(view):
    """No offset, as with D0: also in corners that the tool of the table could not reach into; G10 may not give one."""
    body = "G41 D{} X10. Y0\nX10.03 Y0.02\nG3 X9. Y5. R30.\nG1 G40 X0\n"
    text = "%\nO1\nG21 G90 G17 T2 M6\nG0 X0 Y-9. Z5.\nF90 G1 Z0\n" + body + "M30\n%"
    tools = {2: Tool(2, 2, (0.0,) * 9, 12.0)}
    wear, errors = view(text.format(2), dialect="fanuc", tools=tools, control={"fanuc": {"cutter_offsets": "wear"}})
    zero, zero_errors = view(text.format(0), dialect="fanuc", tools=tools)
    assert (errors, zero_errors) == ((), ())
    assert np.array_equal(wear.end, zero.end)
    assert wear.end[2, :2].tolist() == [10.0, 0.0]
    assert [item.code for item in view(text.format(2), dialect="fanuc", tools=tools)[1]] == ["VP026"]
    given = text.format(2).replace("G0 X0", "G10 L12 P2 R6.\nG0 X0")
    found = view(given, dialect="fanuc", tools=tools, control={"fanuc": {"cutter_offsets": "wear"}})[1]
    assert [(item.code, item.line) for item in found] == [("VP017", 4)]


def test_p_and_q_of_g81_are_kept_and_have_no_effect_there(view):
    head = "%\nO1\nG21 G90 G17 G0 X0 Y0 Z5.\nF90 "
    moves, findings = view(head + "G81 X5. Z-2. R2. P500 Q1.\nG82 X9.\nG83 X12.\nM30\n%", dialect="fanuc")
    assert findings == ()
    assert [(item.code, item.line) for item in moves.findings] == [("VP039", 4)]
    assert "P and Q of G81 are kept" in moves.findings[0].message
    dwells = moves.kind == MoveKind.DWELL
    assert (moves.line[dwells].tolist(), moves.feed[dwells].tolist()) == ([5], [0.5])
    depths = moves.end[(moves.line == 6) & (moves.kind == MoveKind.FEED), 2]
    assert depths.tolist() == [1.0, 0.0, -1.0, -2.0]  # pecks of Q1. from R2.


# --- fanuc ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("fanuc", "rs274"), [
    ("G4 P500", "G4 P.5"), ("G4 P1.5", "G4 P1.5"), ("G4 P2.", "G4 P2"), ("G4 P200 (P1.5)", "G4 P.2"),
    ("G4 X1.5", "G4 P1.5"), ("G4 U2", "G4 P2"),
    ("G0 Z9\nG82 X1 Z-1 R2 P300 F9\nX2", "G0 Z9\nG98 G82 X1 Z-1 R2 P.3 F9\nX2"),
    # P holds for another cycle, with a decimal point it is in seconds, and without one there is none
    ("G0 Z9\nG82 X1 Z-1 R2 P.3 F9\nX2\nX3 P400\nG89 X4",
     "G0 Z9\nG98 G82 X1 Z-1 R2 P.3 F9\nX2\nX3 P.4\nG80 G0 X4\nZ2\nG1 Z-1\nG4 P.4\nG1 Z2\nG0 Z9"),
    ("G0 Z9\nG82 X1 Z-1 R2 F9\nX2", "G0 Z9\nG98 G81 X1 Z-1 R2 F9\nX2"), ("G91 G0 X2\nG53\nX3", "G91 G0 X2\nX3"),
    ("G91 G0 Z9\nG99 G81 X1 Z-1 R-2 F9 K3", "G91 G0 Z9\nG81 X1 Z-1 R-2 F9 L3"),
    ("G0 X5\nG91 G28 Z0\nG90 X6", "G0 X5\nG91 G28 Z0\nG90 X6"), ("G1 F9 X1\nG0 G28 X3\nX4", "G1 F9 X1\nG28 X3\nG0 X4"),
    ("G0 X5\nG53 X2\nX7", "G0 X5\nG53 X2\nX7"), ("G1 F9 X5\nG53 X2\nX7", "G1 F9 X5\nG0 G53 X2\nG1 X7"),
    ("G30 P2 X5", "G30 X5"), ("M98 P30100\nM30\nO100\nG91 G0 X1\nM99", "M98 P100 L3\nM30\nO100\nG91 G0 X1\nM99"),
    ("M98 P30100\nM30\nO30100\nG91 G0 X1\nM99", "M98 P100\nM30\nO100\nG91 G0 X1\nM99"),
    ("G10 L2 P2 X5. Y4.\nG91 G10 L2 P2 X2.\nG90 G55 G0 X1 Y1", "G10 L2 P2 X7 Y4\nG55 G0 X1 Y1"),
    ("/2 G0 X1\nX2", "G0 X1\nX2"), ("G61 G1 F9 X1", "G61.1 G1 F9 X1"), ("G0 X[1+2]", "G0 X[1+2]"),
    ("G10 L10 P1 R33.\nG43 H1\nG0 Z0", "G10 L1 P1 Z33\nG43 H1\nG0 Z0"),
    ("G10 L2 P2 X5.\nG55 G0 X1", "G10 L2 P2 X5\nG55 G0 X1"),
    ("#100=4.\n#101=#100*2+1\nG0X#101Y-#100", "G0 X9 Y-4"),
    ("G15 G50 G67 G40 G49 G80 G69\nG0 X1", "G40 G49 G80\nG0 X1"),
    ("G43.1 H1\nG0 Z0", "G43 H1\nG0 Z0"), ("G234 H1\nG0 Z0\nG49", "G43.4 H1\nG0 Z0\nG49"),
    ("G43 H0\nG0 Z0", "G49\nG0 Z0"),
    ("T1 M6\nG43 H0\nG0 Z0", "T1 M6\nG49\nG0 Z0"), ("(TOOL (10MM)) G0 X1 (A (B)\n(C (D (E)))X2", "G0 X1\nX2"),
    ("M98 P100\nX9\nM30\nO100 G91 G0 X1 (A)\nG90 M99", "M98 P100\nX9\nM30\nO100\nG91 G0 X1\nG90 M99"),
    ("T1 D0 M6\nG0 X-9 F9\nG41 G1 X0\nX9\nY9\nG40 X3\nG41 X4",
     "T1 M6\nG0 X-9 F9\nG41.1 D0 G1 X0\nX9\nY9\nG40 X3\nG41.1 D0 X4"),
    ("T1 M6\nG0 X-9 F9\nG41 G1 X0 D0\nX9\nY9", "T1 M6\nG0 X-9 F9\nG41.1 D0 G1 X0\nX9\nY9"),
])  # fmt: skip
def test_fanuc_words_have_rs274_twins(view, fanuc, rs274):
    first, errors = view(f"%\nO1\n{fanuc}\nM30\n%", dialect="fanuc")
    assert errors == ()
    second, errors = view(f"{rs274}\nM30", dialect="rs274")
    assert errors == ()
    for name in ("kind", "end", "feed"):
        assert np.array_equal(getattr(first, name), getattr(second, name), equal_nan=True), name
    modes = [[moves.controls[index].mode for index in moves.control] for moves in (first, second)]
    cycles = re.search("G8[1-9] X", fanuc)
    assert cycles or modes[0] == modes[1]


def test_fanuc_compensation_begins_beside_the_contour(view):
    """Start-up type A: the entry ends at a right angle to the next move, and the whole contour is cut, however short it
    is.
    """
    program = "%\nO1\nT1 M6\nG0 X50 Y-2 F100\nG41 G1 Y2 D1\nX7\nG2 X2 Y7 R5\nG40 G1 X-9\nM30\n%"
    moves, errors = view(program, dialect="fanuc", tools={1: make_tool(1, 10.0, 10.0)})
    assert errors == ()
    assert moves.end[1:, :2].round(9).tolist() == [[50, -3], [7, -3], [-3, 7], [-9, 7]]


@pytest.mark.parametrize(
    ("text", "last"),
    [
        ("LISTING OF 4711\nDATE: 1.2.\n\n%\nO1\nG0 X5\nM30\n%\nG0 X7", 5.0),  # what a listing prints before the program
        ("\n\n%\nO1 G0 X5\nX6\nM30\n%", 6.0),
        ("%\nO1\nG0 X5\n%\nX7", 5.0),  # % ends it, without M30
        ("O1\nG0 X5\n%", 5.0),
        ("G0 X5\nM30\n%\nO2\nG0 X8\nM30", 5.0),  # an end before the %: no listing
    ],
)
def test_fanuc_programs_begin_and_end_at_percent(view, text, last):
    moves, errors = view(text, dialect="fanuc")
    assert errors == ()
    assert moves.end[-1, 0] == last
    told = [event.data["text"] for event in moves.events if event.kind == "not executed"]
    assert told == (["lines 1 to 3, before the %"] if text.startswith("LISTING") else [])


def test_fanuc_smoothing_is_told(view):
    moves, _ = view("%\nO1\nG5 P10000\nG5.1 Q1\nG8 P1\nG0 X1\nG05 P0\nM30\n%")
    assert [event.data["code"] for event in moves.events if event.kind == "smoothing"] == ["G5", "G5.1", "G8", "G5"]


@pytest.mark.parametrize(("line", "code", "part"), [
    ("G84.2 Z-5 R2", "VP002", "tapping"),
    ("G53.1", "VP017", "G68.2"), ("G54.1 X0", "VP005", "needs P"), ("G54.1 P49", "VP007", "P1 to P48"),
    ("G4 X1 P2", "VP003", "one of them"), ("G41.1 D5", "VP002", "G41.1"), ("o1 sub", "VP002", "rs274"),
    ("G59.1", "VP002", "rs274"),
    ("G68.2 I30\nG68.2 I30", "VP017", "G69"),
    ("G68.2 I30\nG55", "VP017", "G69"), ("G68.2 I30\nG92 X0", "VP017", "G69"),
    ("G68.2 G0 X1", "VP003", "another block"),
    ("M77", "VP002", "remap"), ("G8 P1 Q2", "VP006", "Q2"),
    ("G41 X1", "VP005", "needs D"), ("D1\nM6 T1\nG41 X1", "VP005", "after the tool change"),
    ("G41 D0\nG1 X9\nD1", "VP006", "D1"), ("G43 Z1", "VP005", "needs H"), ("G5 P10001", "VP002", "P10000"),
    ("G5", "VP002", "P10000"),
    ("(A (B) C) X1", "VP001", "C"),
])  # fmt: skip
def test_what_fanuc_has_and_we_do_not_is_an_error(view, line, code, part):
    found = view(f"%\nO1\nG0 X0 Y0 Z5 F100\n{line}\nM30\n%", dialect="fanuc")[1]
    assert [item.code for item in found] == [code]
    assert part in found[0].message
    assert found[0].line == 4 + line.count("\n")


def rotated(point, i, j, k, origin):
    """A point of the plane of G68.2, in program coordinates, by three turns one after the other (no matrix of the
    package).
    """

    def about(p, axis, angle):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        u, v = [axis_ for axis_ in range(3) if axis_ != axis] if axis != 1 else (2, 0)
        q = list(p)
        q[u], q[v] = c * p[u] - s * p[v], s * p[u] + c * p[v]
        return q

    turned = about(about(about(point, 2, k), 0, j), 2, i)
    return [a + b for a, b in zip(turned, origin, strict=True)]


@pytest.mark.parametrize("line", ["(a (b) c)", "(a (b) X50)", "(3 (4) mm)"])
def test_fanuc_names_the_parenthesis_that_ends_a_nested_comment(view, line):
    """Read on, its words would be those of the block, or a mistake in a word that nobody wrote."""

    def mistake(line):
        return view(f"G21 G90\n{line}\nM30\n", dialect="fanuc")[1][0]

    found = mistake(line)
    assert (found.code, found.line, found.column > 6) == ("VP001", 2, True)
    assert found.message.startswith(
        "the comment that begins in column 1 ends at the ')' of column 6, because comments do not nest"
    )
    assert mistake("X1 (a b)) Y2").message == ")): the ) is there twice; did you mean )?"
    assert mistake("X1 ) Y2").message == "')' without a comment that it would end"
    assert mistake("(a (b)) X1 X2").message == "X appears twice in the block"


def nearest_table(x, y, z):
    """A and C that hold a tool axis, of both sides that with the smaller C: G53.1 takes it from A0 C0, X Y Z of the
    machine stand.
    """
    a, c = math.degrees(math.acos(z)), math.degrees(math.atan2(x, y))
    a, c = (a, c) if abs(c) < 91 else (-a, c - math.copysign(180, c))
    return f"A{a:.12f} C{c:.12f}"


@pytest.mark.parametrize("angles", [(0, 25, 0), (30, 20, -40), (90, 15, 10)])
def test_a_tilted_plane_gives_the_setpoints_of_its_vector_twin(machine, angles):
    i, j, k = angles
    origin, path = (3.0, -4.0, 5.0), [(-6, 2, 6), (-6, 2, 1), (7, 3, 1), (7, 3, 6)]
    head = "G49 G54 G0 X0 Y0 Z40 A0 C0\n"
    first = "%\nO1\n" + head + f"G68.2 X3. Y-4. Z5. I{i} J{j} K{k}\nG0 X-6. Y2. Z20.\nG53.1\n"
    first += "G0 X-6. Y2. Z6.\nG1 Z1. F900\nX7. Y3.\nG0 Z6.\nG69\nM30\n%"
    x, y, z = rotated((0, 0, 1), i, j, k, (0, 0, 0))
    vector = f"I{x:.15f} J{y:.15f} K{z:.15f}"
    place = [
        " ".join(f"{letter}{value:.12f}" for letter, value in zip("XYZ", rotated(p, i, j, k, origin), strict=True))
        for p in [(-6, 2, 20), *path]
    ]
    second = (
        head + f"G0 {place[0]}\nG53 G0 {nearest_table(x, y, z)}\n"
        f"G43.5 G0 {place[1]} {vector}\nG1 {place[2]} F900\n{place[3]}\nG0 {place[4]}\nM30"
    )
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 40.0))}, decimals=9, accept_rounding=True)
    results = [convert(text.encode(), machine, options) for text in (first, second)]
    assert all(result.ok for result in results), [result.findings for result in results]
    values = [result.setpoints.values for result in results]
    assert values[0].shape == values[1].shape
    assert np.abs(values[0] - values[1]).max() < 1e-6


def twin_of_the_bracket():
    """gcode_samples/fanuc_tilted.nc in RS274 words: passes written out, the tilted plane as points and vectors of the
    part.
    """
    lines = ["G21 G90 G49 G54", "G0", "G0 X-20 Y-20 Z40 A0 C0", "G0 Z12"]
    for depth in (8.5, 7.0, 5.5, 4.0):
        lines += [f"G1 Z{depth} F400", "X20 F1200", "G0 Z12", "X-20"]
    lines += ["G0 Z40"]

    def at(x, y, z):
        place = rotated((x, y, z), 0, 25, 0, (0, 10, 5))
        return " ".join(f"{letter}{value:.12f}" for letter, value in zip("XYZ", place, strict=True))

    x, y, z = rotated((0, 0, 1), 0, 25, 0, (0, 0, 0))
    lines += [f"G53 G0 {nearest_table(x, y, z)}", f"G43.5 G0 {at(-15, 5, 30)} I{x:.15f} J{y:.15f} K{z:.15f}"]
    lines += ["G61"]  # cycles take no corner
    for i, j in ((-15, 5), (0, 5), (15, 8)):
        lines += ["F250", f"G0 {at(i, j, 30)}", f"G0 {at(i, j, 3)}"]
        for depth in (-1, -5):
            lines += [f"G1 {at(i, j, depth)}", f"G0 {at(i, j, 3)}", f"G0 {at(i, j, depth + 0.254)}"]
        lines += [f"G1 {at(i, j, -9)}", f"G0 {at(i, j, 30)}"]
    lines += [
        "F200",
        f"G0 {at(0, 18, 30)}",
        f"G0 {at(0, 18, 3)}",
        f"G1 {at(0, 18, -2)}",
        "G4 P.3",
        f"G0 {at(0, 18, 30)}",
    ]
    return "\n".join([*lines, "M2"])


def test_the_bracket_gives_the_setpoints_of_its_twin(machine):
    samples = ((SAMPLES / "fanuc_tilted.nc").read_bytes(), 103), (twin_of_the_bracket().encode(), 1)
    results = [
        convert(
            text,
            machine,
            Options(
                tool_length=80.0,
                wcs={system: WorkOffset((0.0, 0.0, 40.0))},
                decimals=9,
                accept_rounding=True,
            ),
        )
        for text, system in samples
    ]
    assert all(result.ok for result in results), [result.findings for result in results]
    values = [result.setpoints.values for result in results]
    assert values[0].shape == values[1].shape
    assert np.abs(values[0] - values[1]).max() < 1e-6


def test_an_arc_in_a_tilted_plane_is_an_arc_of_the_part(machine):
    text = (
        b"%\nO1\nG49 G54 G0 X0 Y0 Z40 A0 C0\nG68.2 X0. Y0. Z5. J20.\nG53.1\nG0 X10. Y0. Z5.\nG3 I-10. "
        b"F2000\nG69\nM30\n%"
    )
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 40.0))}, smoothing="off")
    result = convert(text, machine, options)
    assert result.ok, result.findings
    rows = result.setpoints.line == 7
    q = result.setpoints.values[rows] / [column.factor for column in machine.columns]
    tip, axis, ok = machine.forward(q, 80.0)
    assert ok.all()
    normal = np.array([0.0, -math.sin(math.radians(20)), math.cos(math.radians(20))])
    center = np.array([0.0, 0.0, 45.0])
    circle = tip - center - 5.0 * normal
    assert np.abs(circle @ normal).max() < 1e-4
    assert np.abs(np.linalg.norm(circle, axis=1) - 10.0).max() < 1e-3
    assert np.abs(axis - normal).max() < 1e-5


# --- all ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def two_faces(machine):
    """Setpoints of gcode_samples/two_faces.nc, whose planes are computed in the program."""
    return _convert_two_faces(machine, "two_faces.nc")


def _convert_two_faces(machine, name):
    options = Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 40.0)}, decimals=9, accept_rounding=True)
    result = convert((SAMPLES / name).read_bytes(), machine, options)
    assert result.ok, result.findings
    return result.setpoints.values


@pytest.mark.parametrize("name", ["two_faces_fanuc.nc", "two_faces.mpf", "two_faces.h", "two_faces.cls"])
def test_one_part_has_the_same_setpoints_in_five_languages(machine, two_faces, name):
    values = _convert_two_faces(machine, name)
    assert values.shape == two_faces.shape
    assert np.abs(values - two_faces).max() < 1e-6


# --- aptcl ---------------------------------------------------------------------------------------------


def twin_of_the_wing():
    """gcode_samples/wing.cls in RS274 words, written anew from what the statements mean."""
    text = (SAMPLES / "wing.cls").read_text().replace("$\n", "")
    lines, rapid, feed, axis, circle, hole, place = ["G21 G90 G43.5"], False, None, "I0 J0 K1", None, None, None
    last = None
    for raw in text.splitlines():
        word, _, rest = raw.partition("/")
        numbers = [float(n) for n in re.findall(r"-?[0-9]+\.[0-9]+", rest)]
        if word in ("FROM", "GOTO"):
            if len(numbers) == 6:
                axis = "I{:.7f} J{:.7f} K{:.7f}".format(*numbers[3:])
            point = np.array(numbers[:3])
            if hole is not None and not rapid:
                a = np.array([float(n) for n in re.findall(r"[-0-9.]+", axis)])
                stood = (last - point) @ a / (a @ a)
                heights = [
                    (max(stood, 12), 0),
                    (2, 0),
                    (-2, 1),
                    (2, 0),
                    (-2 + 0.254, 0),
                    (-6, 1),
                    (2, 0),
                    (-6 + 0.254, 0),
                    (-9, 1),
                    (2, 0),
                    (12, 0),
                ]
                lines.append("F200")
                if stood < 12:  # up along the axis before anything goes sideways
                    lines.append("G0 X{:.12f} Y{:.12f} Z{:.12f} {}".format(*(last + (12 - stood) * a), axis))
                for height, code in heights:
                    lines.append("G{} X{:.12f} Y{:.12f} Z{:.12f} {}".format(code, *(point + height * a), axis))
                last = point + 12 * a
                continue
            shown = "X{} Y{} Z{}".format(*numbers[:3])
            if circle is not None:
                lines.append(f"G3 {shown} I{circle[0] - place[0]:.9f} J{circle[1] - place[1]:.9f}")
            else:
                lines.append(f"G{0 if rapid or word == 'FROM' else 1} {shown} {axis}")
            rapid, circle, place, last = False, None, numbers, point
        elif word == "FEDRAT":
            rapid, feed = False, numbers[0]
            lines.append(f"F{feed}")
        elif word == "CIRCLE":
            circle = numbers
        elif word == "CYCLE":
            hole = None if rest == "OFF" else rest
        rapid = rapid or word == "RAPID"
    return "\n".join([*lines, "M2"])


def test_the_wing_gives_the_setpoints_of_its_twin(machine):
    # several moves of a hole have one line here and one each there, which decides about their corners
    options = Options(
        tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 40.0))}, decimals=9, accept_rounding=True, smoothing="off"
    )
    results = [
        convert(text, machine, options) for text in ((SAMPLES / "wing.cls").read_bytes(), twin_of_the_wing().encode())
    ]
    assert all(result.ok for result in results), [result.findings for result in results]
    values = [result.setpoints.values for result in results]
    assert values[0].shape == values[1].shape
    assert np.abs(values[0] - values[1]).max() < 1e-6


def apt(view, text, **options):
    """Moves of statements without errors."""
    moves, findings = view(text + "\nFINI", dialect="aptcl", **options)
    assert findings == ()
    return moves


def test_statements(view):
    moves = apt(
        view,
        "UNITS/INCHES\nRAPID\nGOTO/1,2,3\nFEDRAT/100,MMPM\nGODLTA/0,0,-1\nGODLTA/-0.5\nDELAY/1.5\nGOTO/1.0E0,2,+.5D0",
    )
    assert moves.end[:, 2].round(6).tolist() == [76.2, 50.8, 38.1, 38.1, 12.7]
    assert moves.kind.tolist() == [0, 1, 1, 3, 1]
    assert moves.feed[1] == pytest.approx(100.0)
    moves = apt(
        view,
        "PPRINT hello / there\n"
        "SPINDL/800,CCLW\n"
        "COOLNT/MIST\n"
        "STOP\n"
        "OPSTOP\n"
        "AUXFUN/8\n"
        "TLAXIS/0,1,0\n"
        "UNITS/MM\n"
        "FEDRAT/IPM,10\n"
        "GOTO/0,0,1 $$ note",
    )
    kinds = [(event.kind, *event.data.values()) for event in moves.events]
    assert kinds[0] == ("message", "hello / there")
    assert kinds[1:6] == [
        ("spindle", "counterclockwise", 800.0),
        ("coolant", "mist"),
        ("stop", "program"),
        ("stop", "optional"),
        ("coolant", "flood"),
    ]
    assert moves.tool_axis.tolist() == [[0.0, 1.0, 0.0]]
    assert moves.feed.tolist() == [254.0]


def test_rapid_is_for_one_goto_and_feeds_hold_after_a_cycle(view):
    moves = apt(
        view,
        "FEDRAT/500\n"
        "RAPID\n"
        "GOTO/0,0,9\n"
        "GOTO/0,0,8\n"
        "CYCLE/BORE,DEPTH,2,MMPM,100,CLEAR,1\n"
        "GOTO/5,0,0\n"
        "CYCLE/OFF\n"
        "GOTO/6,0,0",
    )
    assert moves.kind.tolist() == [0, 1, 0, 0, 1, 1, 1]
    assert moves.feed[[1, 4, 5, 6]].tolist() == [500, 100, 100, 500]
    assert moves.end[2:6, 2].tolist() == [8, 1, -2, 1]


def test_compensation_begins_with_the_first_motion_in_the_plane(view):
    """A block that moves Z alone, or nothing, is no start-up."""
    head = "%\nO1\nT1 M6\nG21 G90 G94 G17\nG0 X0 Y0 Z5. F100\n"
    contour = "X30.\nY30.\nG40 X0 Y0\nM30\n%"
    wanted = view(f"{head}G1 Z-5.\nG41 D1 {contour}", dialect="fanuc")[0].end[-4:]
    for begin in ("G1 G41 D1 Z-5.", "G41 D1\nG1 Z-5."):
        moves, errors = view(f"{head}{begin}\n{contour}", dialect="fanuc")
        assert errors == ()
        np.testing.assert_allclose(moves.end[-4:], wanted)


def test_g89_goes_to_the_initial_level_in_rapid_traverse(view):
    for dialect, out in (("fanuc", [(2.0, MoveKind.FEED), (50.0, MoveKind.RAPID)]), ("rs274", [(50.0, MoveKind.FEED)])):
        time = 500 if dialect == "fanuc" else 0.5
        text = (
            f"{'O1' if dialect == 'fanuc' else ''}\n"
            "G21 G90 G94 G17\n"
            "G0 X0 Y0 Z50.\n"
            "F100\n"
            f"G98 G89 X10. Z-5. R2. P{time}\n"
            "G80\n"
            "M30\n"
        )
        moves, errors = view(text, dialect=dialect)
        assert errors == ()
        after = moves.kind == MoveKind.DWELL
        last = int(np.flatnonzero(after)[0]) + 1
        assert [(float(z), kind) for z, kind in zip(moves.end[last:, 2], moves.kind[last:], strict=True)] == out


@pytest.mark.parametrize(("text", "code", "line"), [
    ("GOTO/1,2", "VP005", 1), ("FEDRAT/9\nGOTO/1,2,x", "VP001", 2), ("GOTO/1,2,3", "VP009", 1),
    ("INSERT/G0", "VP002", 1), ("ROTHED/30", "VP002", 1),
    ("MULTAX/OFF\nFEDRAT/9\nGOTO/0,0,0,0,1,0", "VP017", 3), ("MULTAX/ON\nFEDRAT/9\nGOTO/0,0,0,0,1,1", "VP007", 3),
    ("CYCLE/THREAD,5", "VP002", 1), ("CYCLE/TAP,5", "VP005", 1),
    ("CYCLE/DRILL,DEPTH,5", "VP005", 1), ("CYCLE/DRILL,5,CLEAR,-1", "VP007", 1),
    ("CYCLE/DEEP,DEPTH,5,CLEAR,1", "VP005", 1), ("CYCLE/DEEP,DEPTH,5,CLEAR,1,STEP,1E-9", "VP007", 1),
    ("CYCLE/DRILL,DEPTH,5,CLEAR,1,CAM", "VP005", 1), ("UNITS/FURLONG", "VP005", 1), ("LOADTL/A", "VP005", 1),
    ("LOADTL/1,LENGHT,5", "VP002", 1),
    ("CUTCOM/LEFT", "VP002", 1), ("FEDRAT/9\nGOTO/0,0,0\nCIRCLE/5,0,0,0,.6,.9,5\nGOTO/10,0,0", "VP008", 3),
    ("FEDRAT/9\nGOTO/0,0,0\nCIRCLE/5,0,0,0,0,1,9\nGOTO/10,0,0", "VP008", 4), ("GOTO/1,$\n\n,2", "VP001", 1),
    ("GOTO/1,,2", "VP001", 1), ("12,3", "VP001", 1),
    ("CIRCLE/0,0,0,0,0,1,5\nCIRCLE/0,0,0,0,0,1,6", "VP017", 2), ("MULTAX/OF", "VP005", 1),
    ("UNITS/MM,INCHES", "VP005", 1), ("COOLNT/ON,FROG", "VP005", 1), ("GOHOME/1,2,3", "VP005", 1),
    ("RAPID/5", "VP005", 1),
    ("CUTCOM/OFF,LEFT", "VP002", 1), ("CYCLE/OFF,DRILL", "VP005", 1), ("STOP/5", "VP005", 1), ("OPSTOP/X", "VP005", 1),
    ("CIRCLE/0,0,0,0,0,1,5,1", "VP005", 1),
    ("SPINDL/500,CLW,CCLW", "VP005", 1), ("SPINDL/OFF,CLW", "VP005", 1), ("SPINDL/9,OFF", "VP005", 1),
    ("SPINDL/9,RPM,RPM", "VP005", 1), ("SPINDL", "VP005", 1),
    ("CYCLE/DRILL,DEPTH,5,DEPTH,8,CLEAR,2", "VP004", 1), ("CYCLE/DRILL,DEPTH,5,CLEAR,2,RAPTO,2", "VP004", 1),
    ("CYCLE/DRILL,5,CLEAR,2,MMPM,9,IPM,9", "VP004", 1),
    ("CYCLE/DRILL,DEPTH,5,CLEAR,2,RETURN,1", "VP007", 1), ("CYCLE/DRILL,DEPTH,5,CLEAR,2,STEP,2", "VP002", 1),
    ("FEDRAT/9,FPM", "VP002", 1), ("SPINDL/FAST", "VP005", 1), ("GOTO/1,2,1E99", "VP007", 1),
    ("AUXFUN/250", "VP002", 1), ("GOTO/0,0,0 $", "VP001", 1),
])  # fmt: skip
def test_statements_that_are_refused(view, text, code, line):
    found = view(f"{text}\nFINI" if not text.endswith("$") else text, dialect="aptcl")[1]
    assert [(item.code, item.line) for item in found[:1]] == [(code, line)]


@pytest.mark.parametrize(
    ("text", "column"),
    [
        (" GOTO / 1 , 2 , x3", 17), ("GOTO/1,,2", 8), ("GOTO/1,2,", 10), ("  FOO/1", 3), ("  12,3", 3),
        ("TLAXIS/0,0,1E99", 12),
        ("RAPID/5", 7), ("CYCLE/THREAD,5", 7), ("CYCLE/DRILL,DEPTH,5,CAM,1", 21), ("LOADTL/1, LENGHT,5", 11),
        ("GOTO/1,2", None), ("GOTO/1,$\n2,x", None),
    ],
)  # fmt: skip
def test_errors_of_a_word_name_its_column(view, text, column):
    assert view(f"{text}\nFINI", dialect="aptcl")[1][0].column == column


@pytest.mark.parametrize("text", ["", "0", "0/G0X5", "G54", "/M8", " G0X5", "12/1,2", "0 G0 $"])
def test_text_for_the_control_is_refused_however_it_is_glued(view, text):
    found = view(f"UNITS/MM\nINSERT{text}\nFINI", dialect="aptcl")[1]
    assert [(item.code, item.line) for item in found] == [("VP002", 2)]
    assert found[0].message.startswith("INSERT puts text")


@pytest.mark.parametrize(
    "remark", ["PPRINT5 $", "PPRINT X $", "PPRINT 5$", "REMARK5$", "PARTNO12 $$ x $", "REMARK 5 $"]
)
def test_free_text_never_takes_the_next_statement_along(view, remark):
    moves, findings = view(f"FEDRAT/9\n{remark}\nGOTO/7,8,9\nFINI", dialect="aptcl")
    assert findings == ()
    assert moves.end[:, :3].tolist() == [[7, 8, 9]]


def test_a_text_without_fini_is_refused(view):
    assert [(item.code, item.line) for item in view("UNITS/MM\n", dialect="aptcl")[1]] == [("VP010", 1)]


def test_work_systems_of_haas_are_additional_ones(view):
    """G110 is G154 P1, G129 P20: the manual of its mills. G54 P1 is G54.1 P1, but for a P that another word takes."""
    offsets = "G10 L20 P1 X5.\nG10 L20 P20 X7.\nG91 G10 L20 P20 X-3. Z1."
    text = f"%\nO1\nG21 G90\n{offsets}\nG90\n{{}} G0 X1. Z2.\n{{}}\nX2. Z3.\nM30\n%"
    one, found = view(text.format("G110", "G129"), dialect="fanuc")
    assert found == ()
    two, found = view(text.format("G154 P1", "G54.1 P20"), dialect="fanuc")
    assert found == ()
    assert one.end.tolist() == two.end.tolist()
    assert [one.frames[index].origin[0] for index in one.frame] == [5, 4]
    assert [one.frames[index] for index in one.frame] == [two.frames[index] for index in two.frame]
    three, found = view(text.format("G54 P1", "G54 G17 P20"), dialect="fanuc")
    assert (found, three.end.tolist(), three.frames) == ((), one.end.tolist(), one.frames)
    moves, found = view("%\nO1\nG21 G90\nG55 G0 X1. Z2.\nG54 M98 P7\nM30\nO7\nX2.\nM99\n%", dialect="fanuc")
    assert (found, [moves.frames[index].system for index in moves.frame]) == ((), [2, 1])


def test_an_origin_that_nobody_has_given_cannot_be_moved(machine):
    text = "%\nO1\nG21 G91\nG10 L2 P2 X5.\nG90 G55 G0 X1. Y2. Z30.\nM30\n%"
    options = Options(dialect="fanuc", tool_length=60.0)
    with pytest.raises(InputError) as raised:
        interpret_program(text.encode(), build_interpreter_setup(machine, options))
    assert [(item.code, item.line, "G55" in item.message) for item in raised.value.findings] == [("VP033", 4, True)]
    given = replace(options, wcs={"G55": (1.0, 2.0, 3.0)})
    interpret_program(text.encode(), build_interpreter_setup(machine, given))


PROGRAM = b"G91 G0 X1\nG90\nM99\n"


def test_a_name_of_a_file_in_another_encoding_is_the_one_that_a_program_writes(tmp_path):
    """It ended with UnicodeEncodeError."""
    (tmp_path / os.fsdecode(b"h\xe9le.spf")).write_text("RET\n")
    read = [
        collect_subprograms(text, tmp_path, (), lambda path, _name: path.read_bytes())[0]
        for text in (b"X1\n", b"h\xe9le\n")
    ]
    assert read == [{}, {os.fsdecode(b"h\xe9le"): b"RET\n"}]


@pytest.mark.parametrize(
    ("call", "programs", "xs"),
    [
        ("P40008", "", "neither O40008"),
        ("P40008", "o40008", [1]),
        ("P40008", "o0008", [1, 2, 3, 4]),
        ("P40008", "8", [1, 2, 3, 4]),
        ("P40008", "o40008 o00008", "both O40008"),
        ("P40008 L2", "o40008 8", [1, 2]),
        ("P8 L2", "o00008", [1, 2]),
        ("P30000", "o30000", [1]),
        ("P108", "o00108", [1]),
    ],
)
def test_five_digits_behind_m98(view, tmp_path, call, programs, xs):
    """A program of Haas has up to five digits; of Fanuc four, with the repeats before them: what is there decides."""
    for name in programs.split():
        (tmp_path / f"{name.upper()}.nc").write_bytes(PROGRAM)
    text = f"%\nO1\nG0 G21 G90 X0\nM98 {call}\nM30\n%"
    files, names = collect_subprograms(text.encode(), tmp_path, (), lambda path, _name: path.read_bytes())
    assert set(names.values()) == {f"{name.upper()}.nc" for name in programs.split()}
    assert set(files) == set(programs.split())
    moves, found = view(text, dialect="fanuc", subroutines=files)
    if isinstance(xs, str):
        assert [(item.code, item.line, xs in item.message) for item in found] == [("VP023", 4, True)]
    else:
        assert (found, moves.end[1:, 0].tolist()) == ((), xs)


@pytest.mark.parametrize(
    ("call", "programs", "xs"),
    [
        ("M98 P8", {"O0008": 1}, [1]),
        ("M98 P8", {"o8": 1}, [1]),
        ("M98 P40008", {"O0008": 1}, [1, 2, 3, 4]),
        ("G65 P8", {"O8": 1, "8.nc": 1}, [1]),
        ("M98 P8", {"O8": 1, "O8.nc": 2}, "the files O8.nc and O8 have this number, and differ"),
        ("M98 P40008", {"O8": 1, "8.nc": 2}, "the files 8.nc and O8 have this number, and differ"),
        ("M98 P8", {"8": 1}, "in no file beside it whose name has the number"),
        ("M98 P8", {"O8.bak": 1}, "in no file beside it whose name has the number"),
        ("M98 P1208", {"O1209": 1}, "a file beside it has O1209, which is nearly this number"),
        ("o8 call", {"O8": 1}, "defined neither in the program nor in a file 8.ngc"),
    ],
)
def test_a_subprogram_is_a_file_without_an_ending_as_controls_store_it(view, tmp_path, call, programs, xs):
    for name, x in programs.items():
        (tmp_path / name).write_text(f"G91 G0 X{x}\nG90\nM99\n")
    dialect = "rs274" if "call" in call else "fanuc"
    text = f"{'O1' * (dialect == 'fanuc')}\nG0 G21 G90 X0\n{call}\nM30\n"
    files, names = collect_subprograms(text.encode(), tmp_path, (), lambda path, _name: path.read_bytes())
    moves, found = view(text, dialect=dialect, subroutines=files, subroutine_files=names)
    if isinstance(xs, str):
        assert [(item.code, item.line, xs in item.message) for item in found] == [("VP023", 3, True)], found
    else:
        assert (found, moves.end[1:, 0].tolist()) == ((), xs)


@pytest.mark.parametrize(
    ("block", "code", "letter"),
    [
        ("M98 P12 K3", "VP006", "K"),
        ("G4 P100 K2", "VP006", "K"),
        ("X5 K2 L3", "VP003", "K"),
        ("G10 L2 P1 X5 K3", "VP006", "K"),
        ("X5 M98 P12 K3", "VP003", None),
    ],
)
def test_k_is_the_repeats_of_a_cycle_only_where_the_cycle_has_the_words(view, block, code, letter):
    program = f"F9 G0 Z5\nG99 G81 X1 Z-1 R1\n{block}\nG80\nM30\nO12\nG80 G0 Y9\nM99"
    found = view(program, dialect="fanuc")[1]
    assert [(item.code, item.line) for item in found[:1]] == [(code, 3)]
    if letter:
        assert found[0].column == block.index(letter) + 1
    alone = view(program.replace(block, "X5 K2"), dialect="fanuc")
    assert alone[1] == ()
    assert np.count_nonzero(alone[0].kind == 1) == 3


def test_tracut_moves_points_axes_arcs_and_increments(view):
    """A quarter turn about X and a shift, against the same program with every coordinate turned by hand."""
    turned = apt(
        view,
        "MULTAX/ON\n"
        "FEDRAT/9\n"
        "TRACUT/1,0,0,10,0,0,-1,20,0,1,0,30\n"
        "GOTO/1,2,3,0,0,1\n"
        "GODLTA/0,5,0\n"
        "GODLTA/4\n"
        "CIRCLE/11,7,7,0,0,1,10\n"
        "GOTO/11,17,7\n"
        "CYCLE/DRILL,DEPTH,5,CLEAR,1\n"
        "GOTO/0,0,0\n"
        "CYCLE/OFF\n"
        "TRACUT/NOMORE\n"
        "GOTO/1,2,3",
    )
    plain = apt(
        view,
        "MULTAX/ON\nFEDRAT/9\nGOTO/11,17,32,0,-1,0\nGODLTA/0,0,5\nGODLTA/0,-4,0\nCIRCLE/21,13,37,0,-1,0,10\n"
        "GOTO/21,13,47\nCYCLE/DRILL,DEPTH,5,CLEAR,1\nGOTO/10,20,30\nCYCLE/OFF\nGOTO/1,2,3,0,0,1",
    )
    assert turned.end == pytest.approx(plain.end, abs=1e-12)
    assert turned.tool_axis[:-1] == pytest.approx(plain.tool_axis[:-1], abs=1e-12, nan_ok=True)
    assert turned.kind.tolist() == plain.kind.tolist()
    assert turned.arcs.center == pytest.approx(plain.arcs.center)


def test_a_subprogram_is_executed_where_it_is_called(view):
    called = apt(
        view, "FEDRAT/9\nDEFSUB/A\nGODLTA/1,0,0\nGODLTA/0,2,0\nENDSUB\nGOTO/0,0,5\nCALSUB/A\nGOTO/0,0,6\nCALSUB/A"
    )
    assert called.end[:, :3].tolist() == [[0, 0, 5], [1, 0, 5], [1, 2, 5], [0, 0, 6], [1, 0, 6], [1, 2, 6]]
    assert called.line.tolist() == [6, 3, 4, 8, 3, 4]


def test_holes_of_a_cycle_are_not_rounded(view):
    moves = apt(view, "FEDRAT/9\nGOTO/0,0,9\nCYCLE/DRILL,DEPTH,5,CLEAR,1\nGOTO/5,0,0\nCYCLE/OFF\nGOTO/9,0,9")
    modes = [moves.controls[index].mode.name for index in moves.control]
    assert modes == ["BLEND", *["EXACT_PATH"] * 4, "BLEND"]


def table_angles(machine, text):
    """A and C (deg) at the ends of the motions of a program."""
    options = Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 40.0)})
    path = read_draft(
        f"LOADTL/1\nMULTAX/ON\nFEDRAT/900\nRAPID\nGOTO/5,0,30,0,0,1\n{text}\nFINI".encode(), machine, options
    ).path
    return np.degrees(path.end[:, 3:]).round(9).tolist()


def test_rotabl_says_on_which_side_the_table_stands(machine):
    assert (
        table_angles(machine, "ROTABL/-20,AAXIS,-90,CAXIS\nGOTO/5,5,30,0.3420201433,0,0.9396926208")[-2:]
        == [[-20, -90]] * 2
    )
    assert (
        table_angles(machine, "ROTABL/90,CAXIS,20,AAXIS\nGOTO/5,5,30,0.3420201433,0,0.9396926208")[-2:]
        == [[20, 90]] * 2
    )
    with pytest.raises(InputError) as raised:  # points in the coordinates of the turned table
        table_angles(machine, "ROTABL/90,CAXIS,20,AAXIS\nGOTO/5,5,30")
    assert raised.value.findings[0].code == "VP017"


@pytest.mark.parametrize("decimals", [6, 10])
@pytest.mark.parametrize("begin", [0.0, 20.0])
def test_points_after_rotabl_tilt_as_they_say(machine, begin, decimals):
    """Twelve points of 0.02 degrees each, less than a table that snaps to ROTABL would show."""
    tilts = [begin + 0.02 * k for k in range(13)]
    points = [
        f"GOTO/{5 + k},5,30,0,{np.sin(np.radians(a)):.{decimals}f},{np.cos(np.radians(a)):.{decimals}f}"
        for k, a in enumerate(tilts)
    ]
    angles = table_angles(machine, f"ROTABL/{begin},AAXIS,0,CAXIS\n" + "\n".join(points))[-13:]
    # half the last decimal of an axis, seen from 20 degrees: 1.5 times as much in the angle
    assert angles == pytest.approx(np.stack([tilts, np.zeros(13)], axis=1), abs=np.degrees(0.8 * 10.0**-decimals))
    assert angles[0] == [begin, 0.0]


@pytest.mark.parametrize(
    ("axis", "turns"),
    [
        ("0,0.342020,0.939693", False),  # 20 degrees with six decimals
        ("0,0.342021,0.939693", True),  # one more in the last: 0.00006 degrees
        ("0,0.342,0.94", False),
        ("0,0.3420201433,0.9396926208", False),
        ("0,0.3420202,0.9396926", True),
    ],
)
def test_the_table_of_rotabl_stays_while_the_axis_is_that_one_as_printed(machine, axis, turns):
    angles = table_angles(machine, f"ROTABL/20,AAXIS,0,CAXIS\nGOTO/5,5,30,{axis}")[-1]
    assert (angles != [20.0, 0.0]) == turns
    assert angles == pytest.approx([20.0, 0.0], abs=1e-4)


@pytest.mark.parametrize("axis", ["", ",0,0,1", ",0.000000,0.000000,1.000000"])
def test_upright_points_after_the_smallest_tilt_are_refused(machine, axis):
    with pytest.raises(InputError) as raised:
        table_angles(machine, f"ROTABL/0.05,AAXIS,0,CAXIS\nGOTO/5,5,30{axis}")
    assert [item.code for item in raised.value.findings] == ["VP017"]


@pytest.mark.parametrize(("units", "radius", "allowed", "refused"), [
    ("MM", 100.0, 100.09, 100.11), ("MM", 5.0, 5.028, 5.029), ("INCHES", 1.0, 1.0028, 1.0029),
    ("MM", 100.0, 99.91, 99.89),
])  # fmt: skip
def test_the_radius_of_circle_is_that_of_its_points(view, units, radius, allowed, refused):
    """As start and end of an arc: 0.1 %, and 0.028 mm or 0.0028 inches where that is more. The radius moves nothing."""
    text = f"UNITS/{units}\nFEDRAT/900\nGOTO/{radius},0,0\nCIRCLE/0,0,0,0,0,1,{{}}\nGOTO/0,{radius},0\nFINI"
    assert view(text.format(allowed), dialect="aptcl")[1] == ()
    assert [item.code for item in view(text.format(refused), dialect="aptcl")[1]] == ["VP008"]


@pytest.mark.parametrize(
    ("axis", "code"),
    [
        ("0,0.342020,0.939693", None),
        ("0,0.342021,0.939692", None),  # one in the last decimal is rounding
        ("0,0.342022,0.939692", "VP002"),
        ("0,0.343,0.94", "VP002"),
    ],
)
def test_the_point_after_circle_has_the_same_axis_as_printed(view, axis, code):
    found = view(
        "LOADTL/1\n"
        "MULTAX/ON\n"
        "FEDRAT/900\n"
        "GOTO/5,0,0,0,0.342020,0.939693\n"
        "CIRCLE/0,0,0,0,0,1,5\n"
        f"GOTO/0,5,0,{axis}\n"
        "FINI",
        dialect="aptcl",
    )[1]
    assert [item.code for item in found] == ([] if code is None else [code])


@pytest.mark.parametrize(("text", "code", "line"), [
    ("TRACUT/1,2,3", "VP005", 1), ("TRACUT/2,0,0,0,0,1,0,0,0,0,1,0", "VP002", 1),
    ("TRACUT/-1,0,0,0,0,1,0,0,0,0,1,0", "VP002", 1),
    ("TRACUT/M1", "VP001", 1), ("CIRCLE/0,0,0,0,0,1,5\nTRACUT/NOMORE", "VP017", 2), ("CALSUB/1", "VP017", 1),
    ("ENDSUB", "VP017", 1),
    ("DEFSUB/1\nENDSUB\nDEFSUB/1\nENDSUB", "VP017", 3), ("DEFSUB/1\nCALSUB/1\nENDSUB", "VP017", 2),
    ("DEFSUB/1\nDEFSUB/2\nENDSUB", "VP017", 2),
    ("DEFSUB", "VP005", 1), ("ROTABL/30", "VP005", 1), ("ROTABL/30,AAXIS", "VP005", 1),
    ("ROTABL/30,AAXIS,5,BAXIS", "VP005", 1),
    ("ROTABL/30,AAXIS,CLW,CAXIS", "VP001", 1), ("CYCLE/DRILL,5,CLEAR,1\nROTABL/0,AAXIS,0,CAXIS", "VP017", 2),
    ("UNITS/MM\nDEFSUB/7\nGOTO/1,2,3", "VP010", 2),
    ("FEDRAT/9\nMULTAX/ON\nGOTO/0,0,0\nCYCLE/DRILL,DEPTH,2,CLEAR,1\nGOTO/5,0,0,0,0,0", "VP007", 5),
])  # fmt: skip
def test_transformations_and_calls_that_are_refused(view, text, code, line):
    found = view(f"{text}\nFINI", dialect="aptcl")[1]
    assert (code, line) in [(item.code, item.line) for item in found]


@pytest.mark.parametrize(
    ("name", "dialect"),
    [
        ("a.mpf", "siemens"),
        ("A.SPF", "siemens"),
        ("a.h", "heidenhain"),
        ("a.cls", "aptcl"),
        ("a.nc", "rs274"),
        ("mpf", "rs274"),
    ],
)
def test_the_ending_of_a_file_decides_where_its_text_does_not(name, dialect):
    assert choose_dialect("auto", b"N10 G0 X1\n", name) is DIALECTS[dialect]
    assert choose_dialect("auto", b"BEGIN PGM A MM\n", name) is DIALECTS["heidenhain"]
    assert choose_dialect("fanuc", b"N10 G0 X1\n", name) is DIALECTS["fanuc"]


@pytest.mark.parametrize(
    ("name", "text", "dialect"),
    [
        ("a.mpf", "% LID OP10\nG71 G90\nG0 X1\n", "siemens"),
        ("A.SPF", "%LID\nR1=5\nG0 X=R1\n", "siemens"),
        ("a.nc", "% LID OP10\nG71 G90\nG0 X1\n", "fanuc"),
        ("a.mpf", "% LID OP10\nG21 G90\nG0 X1\n", "fanuc"),
        ("a.mpf", "% LID OP10\nG90\n#1=5\nG0 X#1\n", "fanuc"),
        ("a.mpf", "% O1234\nG90\nG0 X1\n", "fanuc"),
    ],
)
def test_a_title_behind_a_percent_sign_is_of_siemens_in_its_files(name, text, dialect):
    assert choose_dialect("auto", text.encode(), name) is DIALECTS[dialect]


@pytest.mark.parametrize("name", ["a.h", "a.nc"])
@pytest.mark.parametrize("first", ["BEGIN PMG A MM", "; A"])
def test_klartext_without_a_right_begin_pgm_is_recognised(name, first):
    """TRANS and CYCL DEF were taken for words of Siemens; one stray line shows nothing."""
    text = f"0 {first}\n1 TOOL CALL 1 Z S8000\n2 TRANS DATUM AXIS X+12\n3 L X+1 FMAX\n4 END PGM A MM\n".encode()
    assert choose_dialect("auto", text, name) is DIALECTS["heidenhain"]
    assert choose_dialect("auto", b"TRAORI\nG0 X1\nTOOL CALL 1 Z\n", name) is DIALECTS["siemens"]


FANUC_HEAD = "%\nO1\nG90 G54 G0 X0 Y0 Z50. A0 C0\n"


def last_tip(lines, machine, **options):
    """Where the tip ends, in G54 as given; mm."""
    given = {"tool_length": 50.0, "wcs": {"G54": (0.0, 0.0, 0.0)}} | options
    return read_draft(f"{FANUC_HEAD}{lines}\nM30\n%\n".encode(), machine, Options(**given)).path.end[-1, :3]


@pytest.mark.parametrize(
    ("lines", "x"),
    [
        ("#1=25.4567\nX[ROUND[#1]]", 25.457),
        ("#1=-25.4567\nX[ROUND[#1*2]-ROUND[#1]]", -25.456),
        ("#1=ROUND[25.4567]\nX#1", 25.0),
        ("#1=25.4567\n#26=7.\nX#[ROUND[#1]+1]", 7.0),
        ("G20\n#1=1.23456\nX[ROUND[#1]]", 25.4 * 1.2346),
        ("#1=-8 MOD 3\nX#1", -2.0),
        ("#1=7.6 MOD 3\nX#1", 2.0),
        ("#1=8.6 MOD 3.4\nX[#1+1]", 1.0),
        ("#1=ATAN[-1]/[1]\nX[#1/10]", 31.5),
        ("#1=ATAN[1]/[-1]\nX[#1/10]", 13.5),
        ("#1=ASIN[-0.5]\nX[#1/10]", 33.0),
        ("#1=ASIN[0.5]\nX[#1/10]", 3.0),
        ("#1=FIX[-1.5]*10+FUP[-1.5]\nX#1", -12.0),
    ],
)
def test_fanuc_computes_in_its_own_way(lines, x, machine):
    assert last_tip(lines, machine)[0] == pytest.approx(x, abs=1e-9)


def test_fanuc_rounds_angles_to_steps_of_a_degree(machine):
    source = f"{FANUC_HEAD}#1=12.34567\nC[ROUND[#1]]\nM30\n%\n".encode()
    path = read_draft(source, machine, Options(tool_length=50.0, wcs={"G54": (0.0, 0.0, 0.0)})).path
    assert np.degrees(path.end[-1, 4]) == pytest.approx(12.346, abs=1e-9)


@pytest.mark.parametrize(
    ("lines", "x"),
    [
        ("X10.\nG92 X100.\nX0", -90.0),
        ("X10.\nG92 X100.\nG52 X0\nX0", -90.0),
        ("X10.\nG92 X100.\nG52 X5.\nX0", -85.0),
        ("X10.\nG92 X100.\nG52 X5.\nG52 X0\nX0", -90.0),
        ("G52 X5.\nX0\nG92 X20.\nG52 X0\nX0", -15.0),  # G92 ends the local system, and holds the place
        ("G52 X5. Y3.\nX10.\nG92 Y0\nG52 X0\nX0", 0.0),
        ("X10.\nG92 X100.\nG52 X5.\nG92.1 X0\nX1.", 1.0),
    ],
)
def test_fanuc_g52_is_a_system_inside_that_of_g92(lines, x, machine):
    assert last_tip(lines, machine)[0] == pytest.approx(x, abs=1e-9)


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("G10 P1 R90.", "VP005"),
        ("G10 L2 P1 R90.", "VP006"),
        ("G2 X40. R20. P3 F100.", "VP006"),
        ("X10. F[ROUND[1.5]]", "VP002"),
    ],
)
def test_fanuc_has_no_such_words(line, code, machine):
    with pytest.raises(InputError) as caught:
        last_tip(line, machine)
    assert [(item.code, item.line) for item in caught.value.findings if item.severity == "error"] == [(code, 4)]


def test_apt_rapid_before_a_hole_is_refused(machine):
    source = (
        b"PARTNO/A\nUNITS/MM\nFEDRAT/100\nRAPID\nGOTO/0,0,50\n"
        b"CYCLE/DRILL,DEPTH,10,CLEAR,2\nGOTO/10,0,0\n%sGOTO/20,0,0\nCYCLE/OFF\nFINI\n"
    )
    given = Options(tool_length=50.0, wcs={"G54": (0.0, 0.0, 0.0)})
    assert len(read_draft(source % b"", machine, given).path)
    with pytest.raises(InputError) as caught:
        read_draft(source % b"RAPID\n", machine, given)
    assert [(item.code, item.line) for item in caught.value.findings] == [("VP017", 9)]


@pytest.mark.parametrize(
    ("first", "second", "refused"),
    [
        ("100", "200", False), ("100,MMPM", "200", False), ("0.1,MMPR", "0.2,MMPR", False),
        ("0.1,MMPR", "200,MMPM", False),
        ("0.1,MMPR", "0.2", True), ("10,IPM", "20", True), ("10,IPM", "20,IPM", False),
        ("100\nUNITS/INCHES", "4", False),
    ],
)  # fmt: skip
def test_apt_feed_rates_without_a_unit_after_another_one(first, second, refused, machine):
    source = (
        "PARTNO/A\n"
        "UNITS/MM\n"
        "SPINDL/1000,CLW\n"
        "RAPID\n"
        "GOTO/0,0,50\n"
        f"FEDRAT/{first}\n"
        "GOTO/10,0,50\n"
        f"FEDRAT/{second}\n"
        "GOTO/20,0,50\n"
        "FINI\n"
    )
    given = Options(tool_length=50.0, wcs={"G54": (0.0, 0.0, 0.0)})
    if not refused:
        assert len(read_draft(source.encode(), machine, given).path) == 2
        return
    with pytest.raises(InputError) as caught:
        read_draft(source.encode(), machine, given)
    assert [(item.code, item.line) for item in caught.value.findings] == [("VP005", 8)]


# --- words without a decimal point --------------------------------------------------------------------


def fanuc_moves(body, decimal_point):
    options = Options(dialect="fanuc", tool_length=60.0, control={"fanuc": {"decimal_point": decimal_point}})
    moves, errors = view_moves_plainly(f"O1\nG90 G21\n{body}\nM30\n".encode(), options)
    assert errors == ()
    return moves


@pytest.mark.parametrize(
    ("bare", "pointed"),
    [
        ("G0 X20 Y-5 Z20.", "G0 X.02 Y-.005 Z20."),
        ("G0 X 2 0 Y+1500", "G0 X.02 Y1.5"),
        ("G0 X20 (X30)\nY10", "G0 X.02 (X30)\nY.01"),
        ("G0 A30000 C-1500", "G0 A30. C-1.5"),
        ("G20\nG0 X20000 A30000", "G20\nG0 X2. A30."),
        ("G20 G0 X20000", "G20 G0 X2."),
        ("G20\nG21 G0 X20000", "G20\nG21 G0 X20."),
        ("G1 X20000 F100\nX1.\nG94 X5 F200", "G1 X20. F100.\nX1.\nG94 X.005 F200."),
        ("G1 X0 Y0 F9\nG2 X10000 Y0 I5000 J0\nG3 X0 Y0 R5000", "G1 X0 Y0 F9\nG2 X10. Y0 I5. J0\nG3 X0 Y0 R5."),
        ("G4 X1500\nG4 P200\nG0 X1.", "G4 X1.5\nG4 P200\nG0 X1."),
        ("G0 Z10.\nG83 X5000 Z-3000 R2000 Q1000 K2 F50\nX7000", "G0 Z10.\nG83 X5. Z-3. R2. Q1. K2 F50\nX7."),
        ("G10 L2 P1 X5000 Z-2000\nG54 G0 X1.", "G10 L2 P1 X5. Z-2.\nG54 G0 X1."),
        ("G52 X5000\nG0 X1.", "G52 X5.\nG0 X1."),
        ("#1=20\nG0 X#1 Y[#1+1] Z-#1", "#1=20\nG0 X20. Y21. Z-20."),  # values have no increments
        ("G43.5 H1\nG1 X5000 I0 J0 K1 F9", "G43.5 H1\nG1 X5. I0 J0 K1 F9"),
        ("G68.2 X1000 Y0 Z0 I30000 J20000 K0\nG0 X1.", "G68.2 X1. Y0 Z0 I30. J20. K0\nG0 X1."),
        (
            "G6.2 P3 K0 X0 Y0 R1 F9\nK0 X1000 Y2000\nK0 X3000 Y0\nK1\nK1\nK1",
            "G6.2 P3 K0 X0 Y0 R1 F9\nK0 X1. Y2.\nK0 X3. Y0\nK1\nK1\nK1",
        ),
        ("G1 X0 Y0 F9\nX9000. ,R2000\nY9000.", "G1 X0 Y0 F9\nX9000. ,R2.\nY9000."),  # corners
        ("G1 X0 Y0 F9\nX9000. , C 1500\nY9000.", "G1 X0 Y0 F9\nX9000. ,C1.5\nY9000."),
        ("G20\nG1 X0 Y0 F9\nX9000. ,R2000\nY9000. ,C.5\nX5.", "G20\nG1 X0 Y0 F9\nX9000. ,R.2\nY9000. ,C.5\nX5."),
        ("#1=2\nG1 X0 Y0 F9\nX9. (,R9) ,R#1\nY9.", "G1 X0 Y0 F9\nX9. ,R2.\nY9."),
        ("M98 P1002\nG0 X7.\nM30\nO1002\nG0 X20\nM99", "M98 P1002\nG0 X7.\nM30\nO1002\nG0 X.02\nM99"),
    ],
)
def test_words_without_a_point_count_increments(bare, pointed):
    """Conventional: 0.001 mm and degrees, 0.0001 inch; feeds, numbers and values of variables stay."""
    found, expected = (fanuc_moves(body, "conventional") for body in (bare, pointed))
    assert found.end == pytest.approx(expected.end, abs=1e-9)
    assert found.feed == pytest.approx(expected.feed, nan_ok=True)
    plain = fanuc_moves(bare, "calculator")
    assert plain.end.tolist() == fanuc_moves(bare, "").end.tolist()


def test_long_stretches_without_points_are_read_alike():
    """Fast readers see the same words: one line in three has none."""
    places = [f"X{k}.5 Y{1000 * k}" if k % 3 else f"X{k}. Y{k}." for k in range(300)]
    body = "G1 F900 X0 Y0\n" + "\n".join(places)
    found = fanuc_moves(body, "conventional").end[1:, :2]
    expected = [(k + 0.5 if k % 3 else k, k) for k in range(300)]
    assert found == pytest.approx(np.array(expected), abs=1e-9)


def test_f_per_turn_without_a_point_is_refused():
    options = Options(dialect="fanuc", tool_length=60.0, control={"fanuc": {"decimal_point": "conventional"}})
    _moves, errors = view_moves_plainly(b"O1\nG90 G21 G95 S100 M3\nG1 X5. F20\nM30\n", options)
    assert [(item.code, item.line, item.column) for item in errors] == [("VP007", 3, 8)]


MIXED = "%\nO1 (A10)\nG21 G90 F600 (X5 Y3.2)\nG43.4 H1\nG0 X0 Y0 Z60. A0 C0\n{body}\nM30\n%\n"


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("G1 X20", (6, 4, "X20 has no decimal point, and words of line 5 have one: it is read as 20 mm")),
        ("G1 X20.\nG4 X2", (7, 4, "X2 has no")),
        ("G1 X20.\nG0 C90\nY90", (7, 4, "2 words (C90 first; lines 7 to 8) have no decimal point, and")),
        (
            "G1 X20.\nG0 C90\nY90.",
            (7, 4, "C90 has no decimal point, and words of line 5 have one: it is read as 90 degrees"),
        ),
        ("G68.2 X0. Y0. Z0. I0 J30 K0 (I7)\nG53.1\nG0 Z70.", (6, 22, "J30 has no decimal point, and words of line 5")),
        ("G68.2 P3 Q1 X0. Y0. Z0. I1 J0 K0\nG68.2 P3 Q2 I0 J0 K1\nG53.1\nG0 Z70.", None),
        ("G68 X0. Y0. R30\nG69\nG0 Z70.", (6, 13, "it is read as 30 degrees")),
        (
            "G1 X20. F100\nG4 X900",
            (7, 4, "is read as 900 s; a control set otherwise counts increments, and reads 0.9 s"),
        ),
        ("G81 X5. Z50. R55", (6, 14, "R55 has no")),
        ("G1 X20. Y0 A0 F100\nG4 P100\nG5.1 Q1 R5\nG0 Z70.", None),
        ("#1=20\nG1 X#1 Y[#1+1]", None),
    ],
)
def test_a_program_that_mixes_numbers_with_and_without_a_point(body, says):
    source = MIXED.format(body=body).encode()
    given = {"tool_length": 80.0, "wcs": {"G54": (0.0, 0.0, 60.0)}}
    found = [item for item in verne_post.check(source, "verne", Options(**given)).findings if item.code == "VP038"]
    assert [(item.line, item.column) for item in found] == ([says[:2]] if says else [])
    if says:
        assert says[2] in found[0].message
        assert '"decimal_point": "calculator"}} (' in found[0].message
    chosen = Options(**given, control={"fanuc": {"decimal_point": "calculator"}})
    assert "VP038" not in [item.code for item in verne_post.check(source, "verne", chosen).findings]


def test_what_controls_do_otherwise_is_said_once():
    body = "G81 X5. Z50. R65. G98\nX6.\nG80\nG0 Z60.\nG81 X5. Z50. R65.\nG80\n#1=1.23456\nG0 X#1\nX[#1+1]\nG0 Z61."
    result = verne_post.check(
        MIXED.format(body=body).encode(), "verne", Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 60.0)})
    )
    notes = [(item.line, item.severity) for item in result.findings if item.code == "VP039"]
    assert notes == [(6, "note"), (13, "note")]


# --- controls of the family -------------------------------------------------------------------------------


def read_family():
    """Rows of the table of docs/gcode.md: name, dialect, keys, and the cells."""
    text = (Path(__file__).parents[2] / "docs" / "gcode.md").read_text(encoding="utf-8")
    for line in text.split("## Controls similar to LinuxCNC\n")[1].split("\n## ")[0].splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 7 and cells[0] not in ("control", "---"):
            keys = dict(re.findall(r'`(\w+) = "(\w+)"`', cells[1]))
            dialect = "fanuc" if "--dialect fanuc" in cells[1] else "rs274"
            yield pytest.param(dialect, {dialect: keys} if keys else {}, cells, id=cells[0])


@pytest.mark.parametrize(("dialect", "control", "cells"), list(read_family()))
def test_each_control_of_the_family_is_what_the_table_says(dialect, control, cells):
    _name, _option, end, repeats, remarks, motion, dwell = cells

    def run(text):
        return view_moves_plainly(text.encode(), Options(dialect=dialect, control=control))

    assert (run("G0 X1\n")[1] == ()) == ("its text" in end)
    assert (run("G0 X1\n%\nG0 X2\n")[1] == ()) == ("`%`" in end and "pair" not in end)
    for letter in "LQ":
        moves, findings = run(f"G91\nM98 P10 {letter}3\nM30\nO10\nG0 X1\nM99\n")
        assert (findings == ()) == (letter in repeats.split(", "))
        assert findings or len(moves) == 3
    spoken = []
    for word in ("MSG", "DEBUG", "PRINT", "LOG", "ABORT", "LOGOPEN"):
        moves, findings = run(f"G0 X1 ({word}, a)\nM30\n")
        assert all(item.code == "VP027" for item in findings)
        spoken += [word] if findings or any(event.kind == "message" for event in moves.events) else []
    assert spoken == ([] if remarks == "none" else remarks.split())
    assert (run("X1\nM30\n")[1] == ()) == (motion == "G0")
    for text in ("G4 P500", "G0 Z9\nG82 X1 Z-1 R2 P500 F90"):
        moves = run(f"{text}\nM30\n")[0]
        assert moves.feed[moves.kind == MoveKind.DWELL].tolist() == [500.0 if dwell == "s" else 0.5]
    arc, absolute = (
        run("G0 X10 Y0\nG3 X0 Y10 I0 J0 F90\nM30\n"),
        control.get("rs274", {}).get("arc_centres") == "absolute",
    )
    assert (arc[1] == ()) == absolute
    assert not absolute or run("G0 X10 Y0\nG91.1 G3 X0 Y10 I-10 J0 F90\nM30\n")[0].arcs.center[0][:2].tolist() == [
        0.0,
        0.0,
    ]


def read_family_words():
    """Rows of the second table: dialect, keys, word, and whether it is refused."""
    keys = {row.id: row.values[:2] for row in read_family()}
    keys["Mach4"] = keys["Mach4, Haas, Fanuc"]
    text = (Path(__file__).parents[2] / "docs" / "gcode.md").read_text(encoding="utf-8")
    for line in (
        text.split("| control | words | what verne-post does |\n|---|---|---|\n")[1].split("\n\n")[0].splitlines()
    ):
        control, words, does = (cell.strip() for cell in line.strip("|").split("|"))
        for word in re.findall("`([^`]+)`", words):
            yield pytest.param(*keys[control], word, does.split(":")[0].split(",")[0], id=f"{control} {word}")


@pytest.mark.parametrize(("dialect", "control", "word", "does"), list(read_family_words()))
def test_each_word_of_the_family_is_what_the_table_says(dialect, control, word, does):
    def run(text):
        return view_moves_plainly(text.encode(), Options(dialect=dialect, control=control))

    moves, findings = run(f"{word}\nG0 X1 Y2 Z3\nM30\n")
    if does == "refused":
        assert [(item.code, item.line, item.column) for item in findings] == [("VP002", 1, 1)]
        assert (
            "take it out" in findings[0].message
            or "write" in findings[0].message
            or "let the CAM" in findings[0].message
        )
        return
    assert findings == ()
    assert moves.end[-1, 0] == (25.4 if word == "G70" else 1.0)
    if does == "no effect":
        assert len(moves) == 1
    else:
        assert run(f"{'G20' if word == 'G71' else 'G21'}\n{word}\nG0 X1\nM30\n")[0].end[-1, 0] == moves.end[-1, 0]


#: Programs as posts for these controls, and their users, write them: moves, and where the last one ends.
FAMILY = {
    "linuxcnc/contour.ngc": (13, (30, 31.8, -60)), "linuxcnc/holes.ngc": (27, (10, -20 * math.sqrt(0.75), -60)),
    "pathpilot/pocket.nc": (10, (0, 0, -60)),
    "pathpilot/holes.nc": (63, (38.1, 12.7, -60)), "mach3/profile.txt": (10, (0, 0, 20)),
    "mach3/calls.tap": (18, (0, 0, 7)), "grbl/square.nc": (7, (50, 50, 12.7)),
    "grbl/laser.gc": (8, (0, 0, 0)), "mach4/contour.tap": (11, (0, 0, -60)), "mach4/calls.tap": (12, (0, 0, 10)),
    "centroid/contour.cnc": (10, (33.02, -1.27, -60)),
    "centroid/calls.cnc": (4, (10, 0, 10)),
}  # fmt: skip


@pytest.mark.parametrize("name", FAMILY)
def test_programs_as_users_of_the_family_write_them(name):
    count, end = FAMILY[name]
    flavour = name.split("/")[0]
    dialect, control = {
        "mach4": ("fanuc", {}),
        "centroid": ("fanuc", {"fanuc": {"dwell": "seconds"}}),
    }.get(flavour, ("rs274", {"rs274": {"flavour": flavour}}))
    raw = (Path(__file__).parents[1] / "corpus" / "family" / name).read_bytes()
    tools = {1: make_tool(1, 60.0), 2: make_tool(2, 60.0)}
    moves, findings = view_moves_plainly(raw, Options(dialect=dialect, control=control, tools=tools))
    assert findings == ()
    assert len(moves) == count
    assert moves.end[-1, :3] == pytest.approx(end)


def test_keys_of_the_family_are_checked():
    with pytest.raises(ValueError, match="flavour: expected linuxcnc or pathpilot or mach3 or grbl"):
        read_keys(Rs274Keys, {"flavour": "mach9"})
    with pytest.raises(ValueError, match="dwell: expected seconds or milliseconds"):
        read_keys(Rs274Keys, {"dwell": "ms"})


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("G0 X1.", 3),
        ("G0 A0 C0 (G20)\nG0 X1.", 4),
        ("G020\nG0 X1.", None),
        ("G0 X1.\nG21", None),
        ("G0 A5.", None),
        ("#1=2\nG0 X1.", 4),
        ("G04 P210\nG0 X1.", 4),
    ],
)
def test_a_fanuc_program_without_a_unit_is_noted(machine, text, line):
    """Shops in inches leave G20 out: one note says that lengths are mm; the key ends it, and says which they are."""

    def run(**keys):
        options = Options(dialect="fanuc", tool_length=50.0, control={"fanuc": keys})
        moves = interpret_program(f"%\nO1\n{text}\nM30\n%\n".encode(), build_interpreter_setup(machine, options))
        return moves, [item.line for item in moves.findings if "neither G20" in item.message]

    assert run()[1] == ([] if line is None else [line])
    assert run(units="inch")[1] == run(units="mm")[1] == []
    if text == "G0 X1.":
        assert [run(units=unit)[0].end[0][0] for unit in ("mm", "inch")] == [1.0, 25.4]
        assert view_moves_plainly(b"G0 X1\nM2", Options(control={"rs274": {"units": "inch"}}))[0].end[0][0] == 25.4
