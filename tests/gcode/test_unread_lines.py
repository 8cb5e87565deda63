"""A line that is refused gives a feed rate all the same: what follows from its loss is no second finding."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

KLARTEXT = (
    "0 BEGIN PGM M MM\n1 TOOL CALL 1 Z S3000\n2 L X0 Y0 Z+150 A0 C0 R0 FMAX M3\n{}\n4 L X+30\n5 L Z+150 FMAX\n"
    "8 M30\n9 END PGM M MM\n"
)
APT = "UNITS/MM\nLOADTL/1\nSPINDL/3000,CLW\nRAPID\nGOTO/0,0,150\n{}\nGOTO/0,0,100\nGOTO/10,0,100\nFINI\n"


@pytest.mark.parametrize(
    ("name", "line", "said"),
    [
        ("p.h", "3 LM X-30 Z+100 F1500", "VP002 error: LM: no meaning in this language; did you mean L?"),
        ("p.h", "3 LL Z+100 F100", "VP001 error: LL: the letter is there twice; did you mean L?"),
        ("p.h", "3 LM Z+100 NX0 NY0 NZ1 F100", "VP002 error: LM: no meaning in this language; did you mean LN?"),
        ("p.h", "3 MOVE Z+100 F1500", "VP002 error: MOVE is not a statement that is executed here"),
        ("p.h", "3 CX Y+10 F AUTO", "VP002 error: CX is not a statement that is executed here"),
        ("p.h", "3 CC X0 F300", "VP006 error: CC does not use F"),
        ("p.cls", "FEDRAT/MMPN,200", "VP002 error: MMPN: no word of FEDRAT; did you mean MMPM?"),
    ],
)
def test_the_feed_rate_of_a_refused_line(
    name: str, line: str, said: str, run: Callable[..., Any], tmp_path: Path
) -> None:
    text = (KLARTEXT if name == "p.h" else APT).format(line)
    (tmp_path / name).write_text(text)
    told = run("check", tmp_path / name, "--machine", "ac_trunnion", "--tool-length", "80", "--wcs", "G54=0,0,60").out
    assert said in told
    assert "refused: 1 error, 0 warnings" in told


def test_a_line_without_a_feed_rate_gives_none(run: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "p.h").write_text(KLARTEXT.format("3 MOVE Z+100"))
    told = run("check", tmp_path / "p.h", "--machine", "ac_trunnion", "--tool-length", "80", "--wcs", "G54=0,0,60").out
    assert "VP009 error: a line or an arc with feed rate zero" in told
