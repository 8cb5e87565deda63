"""The line that a finding quotes is the one that has to be changed, in every language."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import verne_post as vp
from verne_post.model.findings import Finding

#: A word outside the machine, in the line of each program that ends there; the line after it leads back.
PLACES = {
    "rs274.ngc": ("G21 G17 G90 G94 G64 P0.05", "G0 A0 C0 G43 H1", "G0 X0 Y0 Z20", "G1 {} F1000", "G1 {} F1000", "M2"),
    "fanuc.nc": ("%", "O1", "G21 G17 G90 G94", "G0 A0. C0.", "G43.4 H1", "G0 X0. Y0. Z20.", "G1 {} F1000.", "G1 {}",
                 "M30", "%"),
    "klartext.h": ("BEGIN PGM A MM", "TOOL CALL 1 Z S1000", "L A+0 C+0 FMAX", "M128", "L X+0 Y+0 Z+20 FMAX",
                   "CYCL DEF 32.0 TOLERANZ", "CYCL DEF 32.1 T0.05", "L {} F1000", "L {} F1000", "M30", "END PGM A MM"),
    "siemens.mpf": ("G710 G90 G17 G94 T1 D1 M6", "G0 A=0 C=0", "TRAORI", "G0 X0 Y0 Z20", "G645 CTOL=0.05",
                    "G1 {} F1000", "G1 {} F1000", "M30"),
}  # fmt: skip


def check(path: Path, words: tuple[str, str]) -> tuple[list[Finding], int]:
    """The errors of a program whose two last moves have these words, and the number of the first of the two lines."""
    lines = PLACES[path.name]
    first = next(k for k, line in enumerate(lines) if "{}" in line)

    def write(word: str) -> str:
        return (
            f"{word[0]}{float(word[1:]):+g}"
            if path.suffix == ".h"
            else {".mpf": f"{word[0]}={word[1:]}", ".nc": f"{word}."}.get(path.suffix, word)
        )

    moves = [line.format(" ".join(map(write, words[k].split()))) for k, line in enumerate(lines[first : first + 2])]
    path.write_text("\n".join([*lines[:first], *moves, *lines[first + 2 :]]) + "\n")
    found = vp.check(path, "verne", vp.Options(tool_length=80.0, wcs={1: vp.WorkOffset((0.0, 0.0, 60.0))})).findings
    return [item for item in found if item.severity == "error"], first + 1


@pytest.mark.parametrize("name", PLACES)
@pytest.mark.parametrize(
    ("outside", "back", "code"),
    [("A-125", "A-94 X120", "VP102"), ("X3500", "X10", "VP110"), ("Z-120", "X50 Z-119", "VP210")],
)
def test_the_line_that_ends_outside_is_quoted(tmp_path: Path, name: str, outside: str, back: str, code: str) -> None:
    """Not the line that leads back: it begins outside, and half of the blended corner belongs to it."""
    errors, line = check(tmp_path / name, (outside, back))
    assert {item.worst_line for item in errors} == {line}
    assert code in {item.code for item in errors}
    assert all(item.line == line for item in errors)


@pytest.mark.parametrize("name", PLACES)
def test_a_line_that_goes_farther_out_is_quoted_itself(tmp_path: Path, name: str) -> None:
    """The line before it ends outside too, but less far."""
    errors, line = check(tmp_path / name, ("A-110", "A-125"))
    assert [(item.line, item.worst_line) for item in errors if item.code == "VP102"] == [(line, line + 1)]


def test_the_line_whose_explanation_shows_the_finding_is_named(tmp_path: Path, run: Callable[..., Any]) -> None:
    """Line 4 ends within reach, or at the limit of A: the blend of the corner after it is beyond because of line 5."""
    path = tmp_path / "part.ngc"
    begin = "G21 G17 G90 G94 G64 P0.05\nG43 H1\nG0 X0 Y0 Z60 {}\nG1 X0.6 {} F2000\nX1.2 {}\nX1.8 {}\nM2\n"
    for machine, words, code in (
        ("hexapod", ("A59.8 C0", "A59.95", "A60.1", "A60.25"), "VP110"),
        ("ac_trunnion", ("A20 C0", "A30", "A40 Y3", "A41"), "VP102"),
    ):
        path.write_text(begin.format(*words))
        given = ("--machine", machine, "--tool-length", 100, "--wcs", "G54=0,0,60")
        said = run("check", path, *given).out
        assert f"{path}:5: {code} error" in said
        assert f"{code} error" in run("explain", f"{path}:5", *given).out


def test_a_plunge_is_shown_where_it_begins(tmp_path: Path, run: Callable[..., Any]) -> None:
    """A later line is 0.01 mm deeper: it is named as the worst, and what has to be corrected is the plunge."""
    path = tmp_path / "part.ngc"
    path.write_text("G21 G90 G49\nG0 A0 C0\nG0 X0 Y0 Z20\nG1 Z-2 F500\nX10 Z-2.01\nG0 Z20\nX20\nG1 Z-3\nG0 Z20\nM2\n")
    text = run("check", path, "--tool-length", 80, "--wcs", "G54=0,0,0").out
    head, quoted, also = text.splitlines()[:3]
    assert head.startswith(f"{path}:4: VP210 error: tip 2.01")
    assert "(lines 4 to 6, worst 5, 3 moves)" in head
    assert quoted == "  4 | G1 Z-2 F500"
    assert also == "    = also by 3.000 mm in lines 8 to 9"
    assert f"explain {path}:4" in text


@pytest.mark.parametrize(
    ("line", "then"), [("X10 Z-120", "Z -79.9 instead of -120"), ("Z700 X10", "Z 533.7 instead of 700")]
)
def test_one_wrong_word_is_named(tmp_path: Path, run: Callable[..., Any], line: str, then: str) -> None:
    """The part was to be moved, or nothing helped, and the word of one line was wrong."""
    path = tmp_path / "part.ngc"
    text = f"G21 G90 G49\nG0 A0 C0\nG0 X0 Y0 Z20\nG1 F500 {line}\nX20\nG0 Z20\nX30\nM2\n"
    path.write_text(text)
    words = ("--tool-length", 100, "--wcs", "G54=0,0,80")
    said = run("check", path, *words).out
    assert f"tried: within limits if line 4 ends at {then}" in said
    assert "no work offset" not in said
    letter, value, _instead, _of, before = then.split()
    path.write_text(text.replace(letter + before, letter + value))
    assert run("check", path, *words).code == 0
    # another line is wrong by itself: no word alone helps
    path.write_text(text.replace("X30", "Z20\nG0 X30\nZ720\nZ20"))
    assert "ends at" not in run("check", path, *words).out


#: X, and Z in another line, put the tool where the program starts; the line after these moves first.
STARTS = {
    "start.ngc": ("G21 G17 G90 G94", "G0 A0 C0", "G0 X{} Y0", "G43 H1 Z{}", "G1 Z10 F600", "X{}", "G0 Z60", "M2"),
    "start.nc": (
        "%",
        "O1",
        "G21 G17 G90 G94",
        "G0 A0. C0.",
        "G0 X{}. Y0.",
        "G43 H1 Z{}.",
        "G1 Z10. F600.",
        "X{}.",
        "G0 Z60.",
        "M30",
        "%",
    ),
    "start.mpf": (
        "G710 G90 G17 G94 T1 D1 M6",
        "G0 A0 C0",
        "G0 X{} Y0",
        "G0 Z{}",
        "G1 Z10 F600",
        "X{}",
        "G0 Z60",
        "M30",
    ),
    "start.h": (
        "BEGIN PGM A MM",
        "TOOL CALL 1 Z S1000",
        "L A+0 C+0 FMAX",
        "L X{:+d} Y+0 FMAX",
        "L Z{:+d} FMAX",
        "L Z+10 F600",
        "L X{:+d}",
        "L Z+60 FMAX",
        "M30",
        "END PGM A MM",
    ),
}


@pytest.mark.parametrize("name", STARTS)
@pytest.mark.parametrize(("x", "z", "letter"), [(-750, 50, "X"), (0, 1500, "Z"), (0, 50, "")])
def test_a_place_outside_at_which_the_program_starts(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
    name: str,
    x: int,
    z: int,
    letter: str,
) -> None:
    """The first motion was blamed: the line with the wrong word moves nothing.

    Moves that would help it are sought among joints, of which no language is left, and take most of the time: once,
    and where they are found at once.
    """
    if (name, letter) != ("start.ngc", "X"):
        request.getfixturevalue("without_remedies")
        monkeypatch.setattr("verne_post.app.explain_line.propose", lambda *_given: iter(()))
    values = iter((x, z, x + 50))
    lines = [line.format(next(values)) if "{" in line else line for line in STARTS[name]]
    path = tmp_path / name
    path.write_text("\n".join(lines) + "\n")
    options = vp.Options(tool_length=80.0, wcs={1: vp.WorkOffset((0.0, 0.0, 60.0))})
    errors = [item for item in vp.check(path, "verne", options).findings if item.severity == "error"]
    number = next((at for at, line in enumerate(lines, 1) if letter and f"{letter}{{" in STARTS[name][at - 1]), None)
    assert bool(errors) == bool(letter)
    assert min((item.line or 0 for item in errors), default=None) == number
    if number is not None:  # check advises to have this line explained, which moves nothing by itself
        shown = vp.explain(path, "verne", number, options)
        assert {item.code for item in shown.findings} >= {min(errors, key=lambda item: item.line or 0).code}
        assert "at 0 % of the way" in shown.text and shown.working


@pytest.mark.parametrize(
    ("dialect", "block", "code", "low"),
    [
        ("fanuc", "G53 G0 Z500.", "VP101", False),
        ("fanuc", "G53 G0 Z500.", "VP101", True),
        ("fanuc", "G53 G0 Z-330.", "VP210", False),
        ("siemens", "G0 SUPA Z500", "VP101", False),
    ],
)
def test_no_work_offset_is_proposed_for_a_move_to_machine_coordinates(
    dialect: str, block: str, code: str, low: bool
) -> None:
    """A cut of the same program that is too low has its offset as before."""
    text = f"{'G71' if dialect == 'siemens' else 'G21'} G90 G54\nG0 X0. Y0. Z100. A0. C0.\n"
    text += f"G1 Z{-70 if low else 5}. F900.\nG0 Z100.\n{block}\nM30\n"
    options = vp.Options(dialect=dialect, tool_length=100.0, wcs={"G54": (0, 0, 60)})
    errors = [item for item in vp.check(text, "ac_trunnion", options).findings if item.severity == "error"]
    assert [(item.code, item.line) for item in errors] == [("VP210", 3)] * low + [(code, 5)]
    (remedy,) = (one for one in errors[-1].remedies if "offset" in one or "part" in one)
    assert remedy.startswith("line 5 is in machine coordinates (") and "which no work offset moves" in remedy
    assert not low or any("G54" in one or "line 3 ends at" in one for one in errors[0].remedies)


@pytest.mark.parametrize(
    ("dialect", "shift", "end", "shown"),
    [
        ("fanuc", "G52 X400.", "G52 X0", "X 400"),
        ("fanuc", "G68.2 X400. Y0 Z0 I0 J0 K0\nG53.1", "G69", "X 400"),
        ("rs274", "G52 X400 Z1.5", "G52 X0 Z0", "X 400, Z 1.5"),
        ("rs274", "G92 X-400", "G92.1", "X 400"),
        ("siemens", "TRANS X400\nAROT RPL=0", "TRANS", "X 400"),
        ("heidenhain", "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+400", "TRANS DATUM RESET", "X 400"),
        ("fanuc", "G54", "G53 G0 X900.", ""),
        ("fanuc", "G52 Y9.", "G53 G0 X900.", ""),
    ],
)
@pytest.mark.parametrize(("machine", "code"), [("verne", "VP110"), ("ac_trunnion", "VP101")])
def test_a_limit_under_a_shift_names_the_shift(
    without_remedies: None, machine: str, code: str, dialect: str, shift: str, end: str, shown: str
) -> None:
    """The numbers of the line are within limits; a move to machine coordinates knows no shift."""
    x, feed = ("900" if not shown else "300"), "G1 "
    lines = ["G21 G90 G54", "G0 X0. Y0. Z100. A0. C0."]
    if dialect == "siemens":
        lines[0] = "G71 G90 G54"
    if dialect == "heidenhain":
        lines, feed = ["BEGIN PGM A MM", "L X+0 Y+0 Z+100 A+0 C+0 R0 FMAX"], "L "
    lines += [*shift.split("\n"), *([f"{feed}X{x} Y10 F900", f"{feed}X10"] if shown else []), end]
    text = "\n".join([*lines, f"{feed}X0 F900", "M30", *["END PGM A MM"] * (dialect == "heidenhain")])
    options = vp.Options(dialect=dialect, tool_length=80.0, wcs={"G54": (0, 0, 60)})
    item = next(one for one in vp.check(text, machine, options).findings if one.severity == "error")
    at = 2 + shift.count("\n") + 2
    assert item.line == at
    assert item.code == code
    begin = at - (end == "G69")  # G53.1 turns the table, in the shifted plane
    tail = f"; the zero is shifted by {shown} mm from line {begin} on" if shown else "?"
    assert item.message.endswith(tail) if shown else "shifted" not in item.message
