"""What keeps a tool out of the stock besides another end of its line; each number is applied and checked again."""

import re
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verne_post.app.assemble import assemble
from verne_post.app.remedies.words import find_end_before_contact
from verne_post.cli.lsp.command import command
from verne_post.cli.lsp.fixes import find_fixes
from verne_post.cli.lsp.inspector import Inspector

SETUP = """split_at_stops = true
[tools]
4 = { length = 430, diameter = 8.5 }
[wcs]
G54 = [0, 0, 60]
[stock]
min = [-38, -8, -16]
max = [38, 24, 0]
system = "G54"
"""
PROGRAMS = {
    "drill.nc": "G21 G90 G94 G17\nT4 M6\nS2000 M3\nG54\nG0 X-30. Y0.\nG43 Z30. H4\n"
    "G99 G81 X-30. Y0. Z-15. R-3. F200.\nX0.\nX30.\nG80\nG0 Z50.\nM30\n",
    "drill.mpf": "G17 G90 G94 G710\nG54\nT4 D1\nM6\nS2000 M3\nF180\nG0 X-30 Y0\nZ30\n"
    "MCALL CYCLE83(30,-5,2,-15,,-10,,2,0.5,0.5,1,0)\nX-30 Y0\nX30\nMCALL\nG0 Z50\nM30\n",
    "drill.h": "BEGIN PGM D MM\nTOOL CALL 4 Z S2000\nL X-30 Y+0 R0 FMAX M3\nL Z+30 R0 FMAX\nCYCL DEF 200 DRILLING ~\n"
    "Q200=+2 ;SET-UP CLEARANCE ~\nQ201=-15 ;DEPTH ~\nQ206=+150 ;FEED ~\nQ202=+5 ;PLUNGING ~\nQ210=+0 ;DWELL ~\n"
    "Q203=-5 ;SURFACE ~\nQ204=+50 ;2ND ~\nQ211=+0 ;DWELL\nCYCL CALL\nL X+30 R0 FMAX M99\n"
    "L Z+50 FMAX\nM30\nEND PGM D MM\n",
    # RTP is in the stock as well: the tool goes there from hole to hole
    "deep.mpf": "G17 G90 G94 G710\nG54\nT4 D1\nM6\nS2000 M3\nF180\nG0 X0 Y0\nZ30\n"
    "MCALL CYCLE81(-2, -6, 1.5, -9)\nX10\nX20\nMCALL\nG0 Z50\nM30\n",
    "pocket.mpf": "G17 G90 G94 G710\nG54\nT4 D1\nM6\nS2000 M3\nF180\nG0 X-30 Y0\nZ30\nMCALL CYCLE81(30,10,2,9)\nMCALL\n"
    "POCKET3(30,-5,2,-8,30,12,5,0,8,0,3,0,0,300,100,0,1)\nG0 Z50\nM30\n",
}
# a remark with the same number, and words that touch
PROGRAMS["remark.nc"] = PROGRAMS["drill.nc"].replace(
    "G99 G81 X-30. Y0. Z-15. R-3. F200.", "(R-3.)G99G81X-30.Z-15.R-3.F200."
)


# R in force at X0 is that of the subprogram, whose text comes later
PROGRAMS["sub.nc"] = (
    "%\nO1\nG21 G90 G94 G17\nT4 M6\nS2000 M3\nG54\nG0 X-30. Y0.\nG43 Z30. H4\nG99 G81 X-30. Y0. Z-15. R5. F200.\n"
    "M98 P100\nX0.\nG80\nG0 Z50.\nM30\nO100\nG99 G81 X-20. Y0. Z-15. R-3. F200.\nM99\n%\n"
)


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str, str], Path]:
    def write(name: str, text: str) -> Path:
        (tmp_path / f"{name}.toml").write_text(SETUP, encoding="utf-8")
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize(
    ("name", "line", "said", "before", "after"),
    [
        ("drill.nc", 7, "R 0.1 instead of -3,", "R-3.", "R0.1"),
        ("drill.nc", 8, "R 0.1 instead of -3 in line 7,", "R-3.", "R0.1"),
        ("remark.nc", 7, "R 0.1 instead of -3,", ".R-3.", ".R0.1"),
        ("pocket.mpf", 11, "safety clearance SDIS 5.1 instead of 2,", "(30,-5,2", "(30,-5,5.1"),
        ("drill.mpf", 10, "safety clearance SDIS 5.1 instead of 2 in line 9,", "30,-5,2", "30,-5,5.1"),
        ("drill.h", 14, "set-up clearance Q200 5.1 instead of 2 in line 6,", "Q200=+2", "Q200=5.1"),
    ],
)
def test_a_clearance_in_the_stock_is_given_a_higher_value(
    name: str, line: int, said: str, before: str, after: str, write: Any, run: Callable[..., Any]
) -> None:
    path = write(name, PROGRAMS[name])
    refused = run("check", path)
    assert refused.code == 1
    assert "VP216 error: the cutter runs into the stock" in refused.out
    told = run("explain", f"{path}:{line}").out
    assert f"\n  {said} one step of 0.1 above the lowest found\n" in told
    assert "was found" not in told
    path.write_text(PROGRAMS[name].replace(before, after), encoding="utf-8")
    assert run("check", path).code == 0
    lower = re.sub(r"[\d.]+$", lambda one: f"{float(one[0]) - 0.2:.1f}", after)
    path.write_text(PROGRAMS[name].replace(before, lower), encoding="utf-8")
    assert run("check", path).code == 1


@pytest.mark.parametrize(
    ("name", "line", "old", "new", "said"),
    [
        ("drill.nc", 7, "R-3.", "R[0-3]", ""),
        ("sub.nc", 11, "X0.", "X0.", ""),
        ("pocket.mpf", 11, "30,-5,2", "15*2,-5,2*1", ""),
        ("pocket.mpf", 11, "30,-5,2", "30,-5,2*1", "higher values of retraction plane RTP of POCKET3 in line 11"),
    ],
)
def test_only_heights_that_were_tried_are_told(
    name: str, line: int, old: str, new: str, said: str, write: Any, run: Callable[..., Any]
) -> None:
    """A move of the part does not help against the stock that it carries along, and was not tried."""
    told = run("explain", f"{write(name, PROGRAMS[name].replace(old, new))}:{line}").out
    tried = f"{said} were" if said else f"retraction and clearance of the cycle that line {line} executes were not"
    assert f"within limits: nothing was found; {tried} tried" in told
    assert "no move within" not in told


#: A tool that cuts along a vise, and is not retracted before the table turns.
TURNS = {
    "plane.h": "BEGIN PGM P MM\nTOOL CALL 1 Z S8000 F800\nL A+0 C+0 R0 FMAX M3\nL X-30 Y-20 R0 FMAX\nL Z+20 R0 FMAX\n"
    "L Z-3 F300\nL Y+20\nPLANE SPATIAL SPA+40 SPB+0 SPC+0 TURN FMAX SEQ-\nL X+0 Y+10 R0 FMAX\nL Z+60 R0 FMAX\n"
    "PLANE RESET TURN FMAX\nL Z+100 R0 FMAX\nM30\nEND PGM P MM\n",
    "m128.h": "BEGIN PGM P MM\nTOOL CALL 1 Z S8000 F800\nL A+0 C+0 R0 FMAX M3\nM128\nL X-30 Y-20 R0 FMAX\n"
    "L Z+20 R0 FMAX\nL Z-3 F300\nL Y+20\nL A-40 C+0 R0 FMAX\nL X+0 Z+40 R0 FMAX\nL A+0 R0 FMAX\nM129\nM30\n"
    "END PGM P MM\n",
    "plane.mpf": "G17 G54 G90 G94 G710\nT1 D1\nM6\nCYCLE800()\nG0 X-30 Y-20\nG0 Z20\nG1 Z-3 F300 S8000 M3\nY20\n"
    'CYCLE800(0,"",0,57,0,0,0,40,0,0,0,0,0,-1)\nG0 X0 Y10\nG0 Z60\nCYCLE800()\nM30\n',
    "plane.nc": "%\nO0001\nG21 G17 G40 G49 G69 G80 G90 G94\nT1 M6\nS8000 M3\nG54 G0 A0. C0.\nG0 X-30. Y-20.\n"
    "G43 H1 Z20.\nG1 Z-3. F300.\nY20.\nG68.2 X0. Y0. Z0. I0. J40. K0.\nG53.1\nG0 X0. Y10.\nG0 Z60.\nG69\n"
    "G0 A0. C0.\nG0 Z100.\nM30\n%\n",
    "inch.ngc": "G20 G17 G40 G49 G90 G94\nT1 M6\nS8000 M3\nG54 G0 A0 C0\nG43 H1\nG0 X-1.2 Y-.8\nG0 Z.8\nG1 Z-.12 F12\n"
    "Y.8\nG0 A-40 C0\nG0 X0 Z1.6\nG0 A0 C0\nG0 Z4\nM30\n",
}
TURNS["two.ngc"] = TURNS["inch.ngc"].replace(
    "G0 Z4\n", "G0 X-1.2 Y-.8\nG1 Z-.12\nY.8\nG0 A-35\nG0 X0 Z1.6\nG0 A0\nG0 Z4\n"
)
VISE = """[tools]
1 = { length = 80, diameter = 8 }
[wcs]
G54 = [0, 0, 60]
[keep_out.vise]
min = [-80, 30, -40]
max = [80, 60, 5]
system = "G54"
"""


@pytest.mark.parametrize(
    ("name", "turn", "before", "retract"),
    [
        ("plane.h", 8, [8], "L Z+100 R0 FMAX"),
        ("m128.h", 9, [9], "L Z+50 R0 FMAX"),
        ("plane.mpf", 9, [9], "G0 Z50"),
        ("plane.nc", 12, [11], "G0 Z100."),
        ("inch.ngc", 10, [10], "G0 Z4"),
        ("two.ngc", 10, [10, 16], "G0 Z4"),
    ],
)
def test_a_table_turns_after_a_retract(
    name: str, turn: int, before: list[int], retract: str, write: Any, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """The line is written before that of the plane: behind it, Z would be that of the plane."""
    path = write(name, TURNS[name])
    (tmp_path / f"{name}.toml").write_text(VISE, encoding="utf-8")
    refused = run("check", path, "--machine", "ac_trunnion").out
    where = f"line{'s' * (len(before) > 1)} {' and '.join(map(str, before))}"
    z = "-3.048" if name.endswith("ngc") else "-3"
    said = f"retract the tool before {where}: {retract} (the tool is at Z {z} mm when line {turn} turns the table)"
    assert refused.count(f" = tried: {said}: within limits\n") == refused.count("tried: ") == 1
    assert f"  {said}: within limits\n" in run("explain", f"{path}:{turn}", "--machine", "ac_trunnion").out
    lines = TURNS[name].split("\n")
    for number in reversed(before):
        lines.insert(number - 1, retract)
    path.write_text("\n".join(lines), encoding="utf-8")
    assert run("check", path, "--machine", "ac_trunnion").code == 0


#: A stock of 120 x 100 x 40 mm, whose top is Z0.
BLOCK = """split_at_stops = true
[tools]
1 = { length = 100, diameter = 10 }
2 = { length = 110, diameter = 10 }
[wcs]
G54 = [0, 0, 60]
[stock]
min = [-60, -50, -40]
max = [60, 50, 0]
system = "G54"
"""
KLARTEXT = (
    "BEGIN PGM P MM\nL A+0 C+0 R0 FMAX\nTOOL CALL 1 Z S8000 F800\nL X-70 Y+0 R0 FMAX M3\nL Z+20 R0 FMAX\n"
    "L Z-2 R0 FMAX\nL X+70 F800\n{}M30\nEND PGM P MM\n"
)
CLEAR_TURNS = {
    "plane.h": KLARTEXT.format(
        "L Z+2 FMAX\nPLANE SPATIAL SPA+0 SPB+40 SPC+0 TURN FMAX SEQ-\nL X+20 Y+0 FMAX\nL Z+40 FMAX\n"
    ),
    "tool.h": KLARTEXT.format("TOOL CALL 2 Z S8000 F800\nL X+0 Y+0 FMAX M3\nL Z+50 FMAX\n"),
    "plane.nc": "G21 G17 G40 G49 G69 G80 G90 G94\nT1 M6\nS8000 M3\nG54 G0 A0. C0.\nX-70. Y0.\nG43 Z20. H1\nZ-2.\n"
    "G1 X70. F800.\nG0 Z2.\nG68.2 X0. Y0. Z0. I90. J40. K-90.\nG53.1\nG0 X20. Y0.\nZ40.\nG69\nM30\n",
}


@pytest.mark.parametrize(
    ("name", "rapid", "before", "said"),
    [
        ("plane.h", 10, 9, "L Z+100 R0 FMAX (the tool is at Z 2 mm when line 9 turns the table)"),
        ("tool.h", 9, 8, "L Z+50 R0 FMAX (the tool is at Z -2 mm when line 8 changes the tool)"),
        ("plane.nc", 12, 10, "G0 Z100. (the tool is at Z 2 mm when line 11 turns the table)"),
    ],
)
def test_a_rapid_meets_stock_after_a_clear_turn_or_another_tool(
    name: str, rapid: int, before: int, said: str, write: Any, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """Another X or Y of the rapid is no remedy; behind a rapid that leads up, the retract before is none either."""
    path = write(name, CLEAR_TURNS[name])
    (tmp_path / f"{name}.toml").write_text(BLOCK, encoding="utf-8")
    refused = run("check", path, "--machine", "ac_trunnion").out
    assert f"{name}:{rapid}: VP216 error" in refused
    told = f"retract the tool before line {before}: {said}: within limits\n"
    assert f" = tried: {told}" in refused and refused.count("tried: ") == 1
    explained = run("explain", f"{path}:{rapid}", "--machine", "ac_trunnion").out
    assert f"  {told}" in explained and "ended elsewhere" not in explained
    lines = path.read_text(encoding="utf-8").split("\n")
    lines.insert(before - 1, said.split(" (")[0])
    path.write_text("\n".join(lines), encoding="utf-8")
    assert run("check", path, "--machine", "ac_trunnion").code == 0


FACE = KLARTEXT.replace("L X+70 F800", "L X-65 F300\nL X+70 FMAX").format("L Y+20 F800\nL Z+50 FMAX\n")
FACE_ISO = (
    "G21 G17 G90 G94\nT1 M6\nS8000 M3\nG54 G0 A0 C0\nX-70. Y0.\nG43 Z20. H1\nZ-2.\nG1 X-65. F300\n{}\nG0 Z50.\nM30\n"
)


@pytest.mark.parametrize(
    ("name", "text", "line", "said"),
    [
        ("face.h", FACE, 8, "F300 in place of FMAX (F300 is in force)"),
        ("face.nc", FACE_ISO.format("G0 X70.\nG1 Y20."), 9, "G1 in place of G0 (F300 mm/min is in force)"),
        ("fed.nc", FACE_ISO.format("G0 X70. F800."), 9, "G1 in place of G0"),
        ("back.nc", FACE_ISO.format("G0 X70."), 9, ""),  # a retract may be missing as well
        ("plunge.nc", FACE_ISO.format("G0 X70.").replace("Z-2.\nG1 X-65.", "G1 Z-2."), 8, "G1 in place of G0 (F300"),
        ("modal.nc", FACE_ISO.format("G0 X70. F800.\nZ50."), 9, ""),  # the retract would become a cut
        ("turn.nc", FACE_ISO.replace("G1 X-65. F300", "G95 G1 X-65. F0.3").format("G0 X70.\nG1 Y20."), 9, ""),
    ],
)
def test_a_rapid_between_cuts_is_given_a_feed_rate(
    name: str, text: str, line: int, said: str, write: Any, tmp_path: Path, run: Callable[..., Any]
) -> None:
    path = write(name, text)
    (tmp_path / f"{name}.toml").write_text(BLOCK, encoding="utf-8")
    for told in (
        run("check", path, "--machine", "ac_trunnion").out,
        run("explain", f"{path}:{line}", "--machine", "ac_trunnion").out,
    ):
        assert "VP216 error" in told and "a retract before it" in told
        assert "ends at X" not in told and "ended elsewhere" not in told
        assert said in told and ("cuts at a feed rate" in told) == bool(said)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("G0 A-40 C0", "G91\nG0 A-40\nG90"),  # a height would be a distance there
        ("G0 A-40 C0", "A-40 C0 F900"),  # after a rapid, the feed move that turns would be one
        ("G0 X0 Z1.6", "G0 X0 Z1.6\nG0 Y1.6"),  # the contact comes after the turn
    ],
)
def test_no_retract_is_told_that_does_not_help(
    old: str, new: str, write: Any, tmp_path: Path, run: Callable[..., Any]
) -> None:
    path = write("inch.ngc", TURNS["inch.ngc"].replace(old, new))
    vise = VISE if "Y1.6" not in new else VISE.replace("30, -40", "45, -40").replace("60, 5", "90, 90")
    (tmp_path / "inch.ngc.toml").write_text(vise, encoding="utf-8")
    refused = run("check", path, "--machine", "ac_trunnion")
    assert refused.code == 1
    assert "VP215 error" in refused.out
    assert "retract the tool" not in refused.out


def test_a_call_of_a_file_is_no_cycle(write: Any, run: Callable[..., Any]) -> None:
    """It has rapids and cuts too."""
    path = write("call.nc", "G21 G90 G94 G17\nT4 M6\nS2000 M3\nG54\nG0 X0. Y0.\nG43 Z30. H4\nM98 P2001\nG0 Z50.\nM30\n")
    write("O2001.nc", "O2001\nG0 Z-9.\nG1 X9. F500.\nG0 Z40.\nM99\n")
    told = run("explain", f"{path}:7").out
    assert "VP216 error: O2001.nc, line 2: the cutter runs into the stock" in told
    assert "within limits: nothing was found\n" in told


def test_a_clearance_is_given_with_a_plane_that_leaves_no_contact_in_the_next_hole(
    write: Any, run: Callable[..., Any]
) -> None:
    path = write("deep.mpf", PROGRAMS["deep.mpf"])
    told = run("explain", f"{path}:10").out
    wanted = (
        "retraction plane RTP 0.2 instead of -2 and safety clearance SDIS 6.1 instead of 1.5 in line 9, one step of"
    )
    assert f"\n  {wanted} 0.1 above the lowest found\n" in told
    assert "remains" not in told
    path.write_text(PROGRAMS["deep.mpf"].replace("-2, -6, 1.5", "0.2, -6, 6.1"), encoding="utf-8")
    assert run("check", path).code == 0
    path.write_text(PROGRAMS["deep.mpf"].replace("-2, -6, 1.5", "-2, -6, 6.1"), encoding="utf-8")
    assert "VP216 error" in run("check", path).out, "the clearance alone is not enough"


def test_a_contact_in_another_line_of_the_call_is_told(write: Any, run: Callable[..., Any]) -> None:
    """An RTP that is no plain number is not changed."""
    path = write("deep.mpf", PROGRAMS["deep.mpf"].replace("(-2, ", "(-2*1, "))
    told = run("explain", f"{path}:10").out
    wanted = "SDIS 6.1 instead of 1.5 in line 9, one step of 0.1 above the lowest found; a contact remains in line 11"
    assert f"\n  safety clearance {wanted}\n" in told


def test_no_height_is_tried_twice(write: Any, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]) -> None:
    tried: list[bytes] = []

    def record(source: bytes, *others: Any) -> Any:
        tried.append(bytes(source))
        return assemble(source, *others)

    monkeypatch.setattr("verne_post.app.remedies.trials.assemble", record)
    text = PROGRAMS["drill.nc"].replace("Z-15. R-3.", "Z-16. R-7.")
    assert "R 0.1 instead of -7" in run("explain", f"{write('drill.nc', text)}:7").out
    assert len(tried) > 3
    assert len(tried) == len(set(tried))


def test_another_end_is_sought_once_for_all_contacts_of_a_line(
    write: Any, run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sought: list[int] = []

    def record(source: bytes, program: Any, line: Any) -> str | None:
        sought.append(line.number)
        return find_end_before_contact(source, program, line)

    monkeypatch.setattr("verne_post.app.explain.find_end_before_contact", record)
    (tmp_path / "shapes.toml").write_text(
        "[tool.4]\ncutter = { diameter = 8.5, length = 4.0 }\nholder = { diameter = 25.0 }\n", encoding="utf-8"
    )
    path = write(
        "deep.nc", "G21 G90 G94 G17\nT4 M6\nS2000 M3\nG0 X0. Y0.\nG43 Z30. H4\nG1 Z-3. F200.\nG0 Z-8.\nG0 Z30.\nM30\n"
    )
    told = run("explain", f"{path}:7", "--tool-shapes", tmp_path / "shapes.toml").out
    assert told.count("VP216 error") == 2
    assert sought == [7]


def test_a_tool_sticks_out_of_its_holder_farther(write: Any, run: Callable[..., Any], tmp_path: Path) -> None:
    shapes = (
        "[tool.4]\ncutter = {{ diameter = 8.5, length = 4.0 }}\n"
        "shank = {{ diameter = 8.0, length = {} }}\nholder = {{ diameter = 25.0 }}\n"
    )
    text = "G21 G90 G94\nG17\nT4 M6\nM3 S9\nG0 X-20. Y0.\nG43 Z20. H4\nG1 Z-6. F200\nX20.\n"
    text += "G0 Z20.\nX0. Y20.\nG1 Z-6.\nG0 Z20.\nM30\n"
    path = write("slot.nc", text)

    def check(more: float) -> Any:
        (tmp_path / "shapes.toml").write_text(shapes.format(0.5 + more), encoding="utf-8")
        (tmp_path / "slot.nc.toml").write_text(SETUP.replace("430", f"{200 + more}"), encoding="utf-8")
        return run("check", path, "--tool-shapes", tmp_path / "shapes.toml").out

    refused = check(0.0)
    assert refused.count("the holder runs into the stock") == 2
    assert refused.count("`verne-post explain") == 1, "once for all lines"
    assert "explains line 7 and tries what its motion allows: other ends" in refused
    assert re.search(r"longer stick-out; likewise lines? .*\b11\n", refused)
    told = run("explain", f"{path}:7", "--tool-shapes", tmp_path / "shapes.toml").out
    found = re.search(r"stick-out of tool 4 ([\d.]+) mm more, its length ([\d.]+) instead of 200 mm: no holder", told)
    assert found is not None, told
    assert float(found[1]) == pytest.approx(1.7, abs=0.11)
    assert float(found[2]) == pytest.approx(200 + float(found[1]))
    assert "the holder" not in check(float(found[1]))
    assert "the holder" in check(float(found[1]) - 0.3)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("drill.nc", "R-3.", "R0.1"),
        ("drill.mpf", "30,-5,2", "30,-5,5.1"),
        ("deep.mpf", "-2, -6, 1.5", "0.2, -6, 6.1"),
        ("remark.nc", ".R-3.", ".R0.1"),
    ],
)
def test_an_editor_writes_a_clearance_of_a_cycle(name: str, old: str, new: str, write: Any) -> None:
    path = write(name, PROGRAMS[name])
    given = dict(command.make_context("lsp", [], help_option_names=["-h", "--help"]).params)
    del given["extension"]
    inspector, texts = Inspector(given), {path: PROGRAMS[name]}
    found = inspector.check(path, texts, threading.Event())
    item = next(one for one in found.findings if one.code == "VP216")
    fixes = find_fixes(inspector, found, item, texts, threading.Event())
    made = [f"{fix.text[: fix.begin]}{fix.new}{fix.text[fix.end :]}" for fix in fixes if fix.text is not None]
    assert PROGRAMS[name].replace(old, new) in made, [fix.title for fix in fixes]
