"""A program of which a line was given up never counts as one that can run, whatever a front end forgets to report."""

import pytest

from verne_post.gcode import build_plain_setup
from verne_post.gcode.execution import Execution
from verne_post.gcode.klartext.recovery import KlartextRecovery
from verne_post.gcode.read import interpret_program
from verne_post.gcode.rs274.recovery import Recovery
from verne_post.gcode.rs274.run import _BlockRun
from verne_post.gcode.siemens.executor import Executor
from verne_post.model.findings import InputError

_RS274 = "G21 G90 G94\nG1 X0 Y0 Z5 F100\n{}\nG1 X10\nM2\n"
_SIEMENS = "G90 G94\nG1 X0 Y0 Z5 F100\n{}\nX10\nM30\n"
_KLARTEXT = "BEGIN PGM A MM\nL X+0 Y+0 Z+5 R0 F100\n{}\nL X+5 R0\nEND PGM A MM\n"

#: Dialect, program, its third line, which has an error, and the place where the front end forgets it.
FORGOTTEN = [
    ("rs274", _RS274, "#<a>=[#<a>-1.5]", Recovery, "follows_unread", True),  # as it was once
    ("rs274", _RS274, "G1 X5 Q3", Recovery, "_follows", True),
    ("rs274", _RS274, "G1 X5 Q3", _BlockRun, "_execute_line", []),
    ("rs274", _RS274, "G1 X[1+", Execution, "drop_consequences", []),
    ("rs274", _RS274, "o10 call", Execution, "report_all", True),
    ("fanuc", _RS274.replace("M2", "M30"), "G1 X5 Q3", Execution, "report", True),
    ("siemens", _SIEMENS, "G1 X=R(", Executor, "pass_failed", True),
    ("siemens", _SIEMENS, "G1 X1O", Execution, "report", True),
    ("heidenhain", _KLARTEXT, "L X+5 RX", KlartextRecovery, "pass_failed", True),
    ("heidenhain", _KLARTEXT, "LL X+5", Execution, "report_all", True),
    ("aptcl", "PARTNO A\nFEDRAT/100\n{}\nGOTO/1,2,3\nFINI\n", "GOTO/1,2,", Execution, "report", True),
    ("aptcl", "PARTNO A\nFEDRAT/100\n{}\nGOTO/1,2,3\nFINI\n", "GOTO/1,2,3,0,0,0", Recovery, "execute", []),
]


@pytest.mark.parametrize(
    ("dialect", "program", "line", "owner", "name", "answer"),
    FORGOTTEN,
    ids=[f"{dialect}-{name}-{line}" for dialect, _program, line, _owner, name, _answer in FORGOTTEN],
)
def test_a_forgotten_error_is_an_internal_one(
    dialect: str, program: str, line: str, owner: type, name: str, answer: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    source, setup = program.format(line).encode(), build_plain_setup(dialect=dialect)
    with pytest.raises(InputError) as refused:
        interpret_program(source, setup)
    assert [one.line for one in refused.value.findings] == [3]
    real = getattr(owner, name)

    def forget(*arguments: object, **where: object) -> object:
        real(*arguments, **where)
        return answer

    if owner is Execution:
        monkeypatch.setattr(owner, name, lambda *_arguments, **_where: answer)
    else:
        monkeypatch.setattr(owner, name, forget)
    with pytest.raises(RuntimeError, match="line 3 was given up"):
        interpret_program(source, setup)
