"""What a program takes as given: the tool that M6 would load, and the speed of the spindle."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PLACE = ("--tool-length", "80", "--wcs", "G54=0,0,0")
HEAD = "G21 G90 G94 G17\n{}\nG0 X0 Y0 Z60 A0 C0\nG1 X10 Z50 F600\n{}M2\n"


@pytest.mark.parametrize(
    ("begin", "more", "line"),
    [
        ("T2\nS900 M3", "", 2),
        ("T2 M6\nS900 M3", "", None),
        ("T2\nM6 T3\nS900 M3", "", None),  # the next tool is made ready
        ("T2\nS900 M3", "M6\n", None),  # loaded later: another tool may be in the spindle at first
        ("M61 Q2\nT3\nS900 M3", "", None),
        ("T0\nS900 M3", "", None),
        ("T2\nM101\nS900 M3", "", None),  # a code of the builder may load it
        ("S900 M3", "", None),
    ],
)
def test_a_tool_that_is_only_selected(
    run: Callable[..., Any], tmp_path: Path, begin: str, more: str, line: int | None
) -> None:
    path, settings = tmp_path / "p.ngc", tmp_path / "s.toml"
    path.write_text(HEAD.format(begin, more))
    settings.write_text('[remap]\nM101 = "event"\n')
    answer = run("check", path, *PLACE, "--split-at-stops", "--settings", settings)
    assert answer.code == 0, answer.out
    assert answer.out.count("VP041") == (line is not None)
    if line is not None:
        assert f"p.ngc:{line}: VP041 warning: T2 only selects the tool, and no M6 loads it: line 5 cuts" in answer.out


@pytest.mark.parametrize(
    ("begin", "more", "line"),
    [
        ("M3", "", 2),
        ("S900 M3", "", None),
        ("S900\nM3", "", None),
        ("M3", "S900\nG1 X5\n", 2),  # too late: a tool has cut
        ("M3\nS900", "", None),
        ("M3\nM5", "M3\nG1 X5\n", 6),  # the start under which it cuts
    ],
)
def test_a_spindle_without_a_speed(
    run: Callable[..., Any], tmp_path: Path, begin: str, more: str, line: int | None
) -> None:
    path = tmp_path / "p.ngc"
    path.write_text(HEAD.format(begin, more))
    answer = run("check", path, *PLACE)
    assert answer.code == 0, answer.out
    assert answer.out.count("gives its speed") == (line is not None)
    if line is not None:
        late = "before the cut " if "S" in more else ""
        text = f"VP050 warning: the spindle is started here, and no block {late}gives its speed"
        assert f"p.ngc:{line}: {text}" in answer.out


@pytest.mark.parametrize(
    ("begin", "more", "line"),
    [
        ("S900 M3\nS0 M03", "", 3),
        ("S0 M3\nS900", "", None),
        ("S900 M3\nS0", "", 3),
        ("S900 M3\nS0\nM5", "", None),
    ],
)
def test_a_cut_at_speed_0(run: Callable[..., Any], tmp_path: Path, begin: str, more: str, line: int | None) -> None:
    path = tmp_path / "p.ngc"
    path.write_text(HEAD.format(begin, more))
    answer = run("check", path, *PLACE)
    assert answer.code == 0, answer.out
    assert answer.out.count("S0: the spindle does not turn in the cut") == (line is not None)
    if line is not None:
        assert f"p.ngc:{line}: VP050 warning: S0" in answer.out


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("p.mpf", "G17 G90 G54\nT1 D1 M6\nS900 M3\nG0 A0 C0\nX0 Y0 Z9\nT1 D1 M6\nS0 M3\nG1 X5 F100\nM30\n", 7),
        (
            "p.h",
            "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+9 A+0 C+0 FMAX M3\nTOOL CALL 1 Z S0\nL X+5 F100 M3\nM30\n"
            "END PGM P MM\n",
            4,
        ),
    ],
)
def test_a_cut_at_speed_0_in_other_languages(
    run: Callable[..., Any], tmp_path: Path, name: str, text: str, line: int
) -> None:
    (tmp_path / name).write_text(text)
    answer = run("check", tmp_path / name, *PLACE)
    assert f"{name}:{line}: VP050 warning: S0: the spindle does not turn in the cut" in answer.out, answer.out
