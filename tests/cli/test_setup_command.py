"""`verne-post setup`, and the keys of a set-up that it writes: tools, work offsets, meanings of codes."""

import json
import re
import shlex
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import verne_post as vp
from verne_post.config import list_machine_files
from verne_post.config.toml_entries import Change
from verne_post.gcode.remarks import find_corner_radius

FANUC = """%
O1000 (BLADE)
(T1 D=10. CR=0. - FLAT END MILL)
(T5 D=6. CR=3. - BALL)
N10 G90 G94 G17 G49 G40 G80
N15 G21
N20 G28 G91 Z0.
N25 G90
N30 T1 M6
N35 S5000 M3
N40 G54
N45 M11
N50 G0 A0. C0.
N60 G0 X-30. Y0.
N65 G43 Z50. H1
N70 G1 Z40. F800.
N75 X30. A5.
N90 G28 G91 Z0.
N95 G90
N100 T5 M6
N105 S8000 M3
N110 G55
N115 G0 A0. C0.
N120 G0 X0 Y0
N125 G43 Z50. H5
N130 G1 Z40. F600.
N135 Y20. C10.
N145 G28 G91 Z0.
N155 M30
%
"""
SIEMENS = """; PART
N10 G90 G17 G71 G94
N20 T="MILL 10" D1
N30 M6
N40 S6000 M3
N50 G54
N60 TRAORI
N70 G0 A0 C0
N80 G0 X-30 Y0 Z60
N100 G1 Z40 F800
N110 X30 A5
N120 G0 Z80
N150 M30
"""
KLARTEXT = """BEGIN PGM PART MM
TOOL CALL "MILL_10" Z S6000 F800
CYCL DEF 247 DATUM SETTING ~
    Q339=+2 ;DATUM NUMBER
M128
L X-30 Y+0 Z+60 A+0 C+0 FMAX M3
L Z+40 F AUTO
L X+30 A+5
L Z+80 FMAX
M129
L M30
END PGM PART MM
"""
Run = Callable[..., Any]
FILLED = [('length = "measure"', "length = 80"), ('"measure"', "[0, 0, 60]"), ('"decide"', '"ignore"')]


def fill(path: Path) -> None:
    """What a person does: put a value in place of every mark."""
    text = path.read_text()
    for mark, value in FILLED:
        text = text.replace(mark, value)
    path.write_text(text)


@pytest.mark.parametrize(
    ("name", "source", "expected"),
    [
        ("part.nc", FANUC, {
            "tools": {"1": {"length": "measure", "diameter": 10, "corner_radius": 0},
                      "5": {"length": "measure", "diameter": 6, "corner_radius": 3}},
            "wcs": {"G54": "measure", "G55": "measure"}, "remap": {"M11": "decide"}, "split_at_stops": True,
        }),
        ("part.mpf", SIEMENS, {"tools": {"MILL 10": {"length": "measure"}}, "wcs": {"G54": "measure"}}),
        ("part.h", KLARTEXT, {"tools": {"MILL_10": {"length": "measure"}}, "wcs": {"G55": "measure"}}),
    ],
)  # fmt: skip
def test_the_first_own_program_runs_once_its_setup_is_filled_in(
    name: str, source: str, expected: dict[str, object], run: Run, tmp_path: Path
) -> None:
    program = tmp_path / name
    program.write_text(source)
    assert run("setup", program).code == 0
    written = Path(f"{program}.toml")
    assert tomllib.loads(written.read_text()) == expected
    text = written.read_text()
    assert text.partition("\n")[0].endswith(f"{name}: mm and degrees; write numbers where it says measure")
    assert ("presets 1 to 9 (cycle 247) are G54 to G59.3" in text) == (source == KLARTEXT)  # it has no G54 of its own
    refused = run(program, "-o", tmp_path / "axes.csv")
    assert refused.code == 2
    assert not list(tmp_path.glob("axes*"))  # a mark is no value
    assert refused.err.count("VP012 error") == 1  # one cause
    fill(written)
    assert run(program, "-o", tmp_path / "axes.csv").code == 0
    assert "where it says" not in run("setup", program, "-o", "-").out  # nothing is left to be written
    assert vp.convert(program, "verne").ok  # the Python API reads the same file


LENGTHS = '[tools]\n1 = { length = 80 }\n5 = { length = 90 }\n"MILL 10" = { length = 80 }\nMILL_10 = { length = 80 }\n'


@pytest.mark.parametrize(
    ("name", "source", "said"),
    [
        ("part.nc", FANUC.replace("N45 M11\n", ""), ["wcs.G54 is still", "wcs.G55 is still"]),
        ("part.mpf", SIEMENS, ["wcs.G54 is still"]),
        ("part.h", KLARTEXT, ["wcs.G55 (preset 2) is still"]),
        ("part.nc", "G21 G90\nG59.1\nG43 H1\nG0 X0 Y0 Z50 A0 C0\nG1 X10 F600\nM2\n", ['wcs."G59.1" is still']),
        ("part.nc", "G21 G90\nG10 L2 P1 Z-500\nG43 H1\nG0 X0 Y0 Z50 A0 C0\nG1 X10 F600\nM2\n", []),  # sets it
    ],
)
def test_an_offset_still_to_be_measured_is_refused_as_a_length_is(
    name: str, source: str, said: list[str], run: Run, tmp_path: Path
) -> None:
    """With the lengths filled in and the offset not, rows were written for a part at the rotary centre."""
    program, written = tmp_path / name, tmp_path / f"{name}.toml"
    program.write_text(source)
    marks = '[wcs]\nG54 = "measure"\nG55 = "measure"\n"G59.1" = "measure"\n'
    written.write_text(f"split_at_stops = true\n{LENGTHS}{marks}")
    told = run(program, "-o", tmp_path / "axes.csv")
    assert told.code == (2 if said else 0), told.err
    assert told.err.count(" error: ") == len(said)
    assert all(f"part.{name[5:]}.toml: {text}" in told.err for text in said)
    if said:
        assert not list(tmp_path.glob("axes*"))
        findings = vp.check(program, "verne").findings
        assert [(item.code, item.severity) for item in findings] == [("VP033", "error")] * len(said)
        # what the command line gives is measured, and so is what another place gives
        given = [word for system in ("G54", "G55", "G59.1") for word in ("--wcs", f"{system}=0,0,60")]
        assert run("check", program, *given).code == 0
        again = run("setup", program, "-o", "-").out.partition("[wcs]")[2].splitlines()
        assert sum(line.endswith(' = "measure"') for line in again) == len(said)  # the others are not used


@pytest.mark.parametrize("name", ["p.nc", "p.h", "p.mpf", "p.cls"])
@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("hello world\nthis is no program\n", "VP032 error"),
        (" \n", "1: VP032 error: the file has nothing but blank lines"),
        ("", "1: VP032 error: the file is empty"),
    ],
)
def test_no_set_up_is_written_for_what_is_no_program(
    run: Run, tmp_path: Path, name: str, source: str, told: str
) -> None:
    program = tmp_path / name
    program.write_text(source)
    answer = run("setup", program)
    assert answer.code == 2, answer.out
    assert told in answer.out + answer.err
    assert "missing" not in answer.out + answer.err
    assert list(tmp_path.iterdir()) == [program]


def test_fit_seeks_the_place_that_is_still_to_be_measured(run: Run, tmp_path: Path) -> None:
    program = tmp_path / "part.mpf"
    program.write_text(SIEMENS)
    Path(f"{program}.toml").write_text(f'{LENGTHS}[wcs]\nG54 = "measure"\n')
    told = run("fit", program)
    assert told.code == 0
    assert "before: could not run" not in told.out


@pytest.mark.parametrize("name", vp.list_machines())
def test_set_up_and_message_name_the_point_that_offsets_of_a_machine_count_from(
    name: str, run: Run, tmp_path: Path
) -> None:
    """The form said "from the axis of C" of machines whose C is in the head, or that have none."""
    file = tomllib.loads(list_machine_files()[name].read_text("utf-8"))
    point = "the rotary centre on the table face"
    if "chain" in file:
        chain, joint = file["chain"], file["joints"].get("c", {})
        turns_part = "c" in chain["part"] and joint["through"][:2] == chain["part_zero"][:2]
        point = f"part_zero of the machine file{', on the axis of C' if turns_part else ''}"
    program = tmp_path / "p.nc"
    program.write_text("G21 G90 G54\nG0 X0 Y0 Z60\nG1 X5 F600\nM2\n")
    written = run("setup", program, "--machine", name, "-o", "-").out
    assert f"[wcs]  # [x, y, z] of the part zero, from {point}; a fourth number is the turn" in written
    checked = run("check", program, "--machine", name, "--tool-length", 60)
    assert f"G54 is at {point}; give --wcs G54=X,Y,Z\n" in checked.out + checked.err


def test_the_machine_is_no_part_of_a_set_up_and_is_named_where_it_belongs(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After ``setup --machine ac_trunnion`` the next check said "can run" of another machine."""
    monkeypatch.chdir(tmp_path)
    program, written, key = tmp_path / "part.mpf", tmp_path / "part.mpf.toml", 'machine = "ac_trunnion"'
    program.write_text(SIEMENS)
    told = run("setup", "part.mpf", "--machine", "ac_trunnion")
    assert f"write {key} in verne-post.toml" in told.err
    assert "--machine ac_trunnion" in written.read_text()
    fill(written)
    other = run("check", "part.mpf").out
    said = "the set-up was written for AC trunnion, y on the part side, and the machine in use is VERNE; give "
    assert f"part.mpf: VP505 warning: {said}--machine, as the remark in the set-up says\n" in other
    shown = run("check", "part.mpf", "--output-format", "sarif").out
    assert "If the set-up is right for this machine too, delete the remark." in shown
    assert "implausible size: If" not in shown
    assert f"{said}machine, as the remark in the set-up says" in [one.message for one in vp.check(program).findings]
    Path("verne-post.toml").write_text(key)
    right = run("check", "part.mpf").out
    assert right == run("check", "part.mpf", "--machine", "ac_trunnion").out != other
    assert "was written for" not in right
    written.write_text(key)
    refused = run("check", "part.mpf")
    assert (refused.code, f"write {key} in the settings file verne-post.toml" in refused.out) == (2, True)
    Path("verne-post.toml").unlink()
    written.unlink()
    run("setup", "part.mpf")
    assert "machine" not in written.read_text()


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("part.nc", "G21 G90\nG43 H1\nT1 M6\nG0 X0 Y0 Z50 A0 C0\nG41 D1 G1 X10 F600\nX20\nM2\n"),
        ("part.mpf", "G71 G90\nT1 M6 D1\nG0 X0 Y0 Z50 A0 C0\nG1 F600 G41 X10\nX20\nM30\n"),
    ],
)
def test_a_missing_diameter_asks_for_the_diameter(name: str, source: str, run: Run, tmp_path: Path) -> None:
    """The remedy asked for the length, which was there."""
    program = tmp_path / name
    program.write_text(source)
    Path(f"{program}.toml").write_text("[tools]\n1 = { length = 80 }\n[wcs]\nG54 = [0, 0, 60]\n")
    out = run("check", program).out
    assert "tool diameter unknown: Fill in the diameter in " in out
    assert "length" not in out


def test_codes_without_a_meaning_are_one_finding(run: Run, tmp_path: Path) -> None:
    """As CAM systems clamp and unclamp the table; the one finding names all codes and all keys."""
    program = tmp_path / "part.nc"
    program.write_text(FANUC.replace("N45 M11", "N45 M11\nM13\nM10").replace("N110 G55", "N110 M11 G55"))
    told = json.loads(run("check", program, "--output-format", "json").out)["programs"][0]["findings"]
    (found,) = [item for item in told if item["code"] == "VP002"]
    assert found["message"].startswith("M11, M13 and M10: no meaning in this language")
    assert (found["count"], found["settled_by"]) == (4, ["remap.M11", "remap.M13", "remap.M10"])
    assert run("check", program).out.count("Fill in its meaning in ") == 1
    assert run("setup", program).code == 0
    assert set(tomllib.loads(Path(f"{program}.toml").read_text())["remap"]) == {"M10", "M11", "M13"}


def test_rigid_tapping_is_a_choice_of_the_set_up(run: Run, tmp_path: Path) -> None:
    """It is asked for with all the rest; what is written refuses it, until a person chooses."""
    program, written = tmp_path / "tap.nc", tmp_path / "tap.nc.toml"
    head = "%\nO1\nG21 G90 G94 G17\nT1 M6\nS500 M3\nG54 G0 X0. Y0. A0. C0.\nG43 Z50. H1\n"
    program.write_text(f"{head}G84 Z20. R30. F500.\nG80\nM30\n%\n")
    told = run("setup", program)
    assert "the length of tool 1, the place of G54, the choice of tapping" in told.err
    assert "VP048" not in told.err
    assert tomllib.loads(written.read_text())["tapping"] == "refuse"
    fill(written)
    refused = run("check", program)
    assert (refused.code, refused.out.count("error: ")) == (2, 1)
    assert "tapping = 'feed' in the set-up" in refused.out
    written.write_text(written.read_text().replace('"refuse"', '"feed"'))
    assert run("check", program).code == 0


@pytest.mark.parametrize(
    ("source", "line"),
    [
        (
            SIEMENS.replace("; PART", '; T="MILL 10" D=10. CR=0. - flat'),
            '"MILL 10" = { length = "measure", diameter = 10, corner_radius = 0 }  # D=10. CR=0. - flat'
            " - diameter and corner_radius from this remark, check it",
        ),
        (
            KLARTEXT.replace("MM\n", "MM\n1 ;  #7 BALL D=6\n", 1).replace('"MILL_10"', "7"),
            '7 = { length = "measure", diameter = 6, corner_radius = 3 }  # BALL D=6'
            " - diameter and corner_radius from this remark, check it",
        ),
        (
            KLARTEXT.replace("MM\n", "MM\n1 ; TOOL: MILL_10 D=16.000 R=0.8 L=75\n", 1),
            'MILL_10 = { length = "measure", diameter = 16 }  # D=16.000 R=0.8 L=75'
            " - diameter from this remark, check it",
        ),
        (
            KLARTEXT.replace("MM\n", "MM\n1 ; T7 FACE MILL D=20, T8 END MILL D=8\n", 1).replace('"MILL_10"', "7"),
            '7 = { length = "measure", diameter = 20 }  # FACE MILL D=20 - diameter from this remark, check it',
        ),
    ],
)
def test_remarks_of_other_posts_stand_there_too(source: str, line: str, run: Run, tmp_path: Path) -> None:
    program = tmp_path / ("part.mpf" if "TRAORI" in source else "part.h")
    program.write_text(source)
    told = run("setup", program, "-o", "-")
    assert line in told.out.splitlines()
    assert told.err.startswith("the set-up: taken from remarks, check it: the diameter of tool ")


def test_remarks_of_the_program_stand_beside_its_tools(run: Run, tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(FANUC)
    told = run("setup", tmp_path / "part.nc", "-o", "-")
    assert (
        '5 = { length = "measure", diameter = 6, corner_radius = 3 }  # D=6. CR=3. - BALL'
        " - diameter and corner_radius from this remark, check it\n" in told.out
    )
    assert "the length of tools 1 and 5, the place of G54 and G55, the meaning of M11" in told.err
    (tmp_path / "part.nc").write_text(FANUC.replace("M30", "T9 M6\nG43.4 H9\nG1 X1 F100\nM30"))
    assert "the length of tools 1, 5 and 9" in run("setup", tmp_path / "part.nc", "-o", "-").err


@pytest.mark.parametrize(
    ("remark", "diameter"),
    [
        ("(T1 D=16. CR=0. - FLAT END MILL)", 16.0),
        ("(T1 DIA 5.5 DRILL)", 5.5),
        ("(T1 - \u00d8 8 BALL)", 8.0),
        ("(T1 DIAM: 10 MM)", 10.0),
        ("( TOOL - 1  DIA. OFF. - 3  LEN. - 1  DIA. - 8. )", 8.0),
        ("(T1 | 8. BALL ENDMILL | H1 | DIA. OFF. - 12 | LEN. - 12 | DIA. - 8.)", 8.0),
        ("(TOOL - 1  DIA. OFF. - 3)", None),
        (';TOOL 1 "MILL_D10" D10 L80', 10.0),
        (';TOOL 1 "MILL_D10" D1', None),
        (';TOOL 1 "MILL_10" D10', None),
        ("(T1 H1 D3 BALL)", None),  # an entry of the tool table
        ("(T1 D12 ENDMILL H1)", 12.0),
        ("(T1 ENDMILL D12 R2 - H1)", 12.0),
        ("(T1 D12 ENDMILL H12)", None),
        ("(T1 D12 H1 ENDMILL)", None),
        ("(T1 END MILL 12)", None),
        ("( T1 D50 FACE MILL )", 50.0),
        ("(T1 FACE MILL D50)", 50.0),
        ("(T1 D1 FACE MILL)", None),
        ("(T1 D50)", None),
        ("(T1 D50 INCH FACE MILL)", None),
        ("(T1 D1/2 FACE MILL)", None),
        (";T1 | 50. FACE MILL", 50.0),
        ("(T1 | 12.5 FLAT ENDMILL | H1 | D1)", 12.5),
        ("(T1 | 1/2 FLAT ENDMILL)", None),
        ("(T1 | 2.5 INCH FACE MILL)", None),
        ("(T1 | 90. DEG CHAMFER MILL)", None),
        ("(T1 D=0.5 INCH)", None),
        ('(T1 D=0.5")', None),
        ("(T1 D=3/8)", None),
        ("(T1 D=10 SHANK D=12)", None),
        ("(T1 FACE MILL D=20, T2 END MILL D=8)", 20.0),
        ("(T1 FACE MILL, T2 END MILL D=8)", None),
        ("(T1 D=20,5)", None),
        ("(T1 GRID=16)", None),
        ("(T1 D=16)\nG20", None),  # a program in inches
    ],
)
def test_a_diameter_of_a_remark_is_taken_and_marked(
    remark: str, diameter: float | None, run: Run, tmp_path: Path
) -> None:
    path = tmp_path / "a.nc"
    path.write_text(f"{remark}\nG90 G94\nT1 M6\nG43 H1\nS900 M3\nG0 X0 Y0 Z20 A0 C0\nG1 X1 F600\nM2\n", "utf-8")
    answer = run("setup", path)
    text = Path(f"{path}.toml").read_text("utf-8")
    tool = {"length": "measure"} | ({} if diameter is None else {"diameter": diameter})
    written = tomllib.loads(text)["tools"]
    corner = written["1"].pop("corner_radius", None)
    expected = 4 if "BALL" in remark and diameter else 0 if "CR=0." in remark and "MILL" in remark else None
    assert (written, corner) == ({"1": tool}, expected)
    marked = f"diameter{' and corner_radius' * (corner is not None)} from this remark, check it" in text
    told = "taken from remarks, check it: the diameter of tool 1" in answer.err
    assert (marked, told) == (diameter is not None, diameter is not None)
    # what is there stays: the one who measured it knows better
    Path(f"{path}.toml").write_text("split_at_stops = true\n[tools]\n1 = { length = 80 }\n[wcs]\nG54 = [0, 0, 60]\n")
    assert "taken" not in run("setup", path).err
    assert "diameter" not in Path(f"{path}.toml").read_text("utf-8")


@pytest.mark.parametrize(
    ("lines", "diameter"),
    [
        ("(FACE MILL D50)\nT1 M6", 50),
        ("(FACE MILL D=50.)\nN10 T01 M06", 50),
        ("(T1 D=12. END MILL)\n(FACE MILL D50)\nT1 M6", 12),
        ("(FACE MILL D50)\nG90\nT1 M6", None),
        ("(FACE MILL)\nT1 M6", None),
        ("(POCKET 50 WIDE)\nT1 M6", None),
    ],
)
def test_a_remark_above_the_change_of_tools_is_about_its_tool(
    lines: str, diameter: int | None, run: Run, tmp_path: Path
) -> None:
    (tmp_path / "a.nc").write_text(f"G21 G90 G94\n{lines}\nG43 H1\nS900 M3\nG0 X0 Y0 Z20 A0 C0\nG1 X1 F600\nM2\n")
    written = tomllib.loads(run("setup", tmp_path / "a.nc", "-o", "-").out)["tools"]["1"]
    assert written.get("diameter") == diameter


@pytest.mark.parametrize(
    ("remark", "sizes", "second"),
    [
        ("(D=10. CR=0. - FLAT)", (10, 0), ""),
        ("(D=8. CR=4. - BALL)\n(FINE)", (8, 4), ""),
        ("(PART)\n(FLAT END MILL D=12)", (12, None), ""),
        ("(TOOL: D=6)", (6, None), ""),
        ("(D=10. CR=0. - FLAT)", (None, None), "T2 M6\nG43 H2\nG1 X9\n"),
        ("(T1 FLAT D=10)\n(D=8 CR=4)", (10, None), ""),
        ("(T2 D=8 CR=4)", (None, None), ""),
        ("(D=50)", (None, None), ""),
        ("(FLANGE D=50 CR=2)", (None, None), ""),
        ("(TOOL STEEL D=50)", (None, None), ""),
        ("(PLATE D=20 BY 10MM DRILL)", (None, None), ""),
        ("(D=8 CR=4)\n(D=10 CR=0)", (None, None), ""),
    ],
)
def test_a_remark_without_a_tool_is_about_the_only_one(
    remark: str, sizes: tuple[float | None, float | None], second: str, run: Run, tmp_path: Path
) -> None:
    path, start = tmp_path / "a.nc", "G90 G94\nT1 M6\nG43 H1\nS900 M3\nG0 X0 Y0 Z20 A0 C0\nG1 X1 F600\n"
    path.write_text(f"{remark}\n{start}{second}M2\n", "utf-8")
    tool = tomllib.loads(run("setup", path, "-o", "-").out)["tools"]["1"]
    assert (tool.get("diameter"), tool.get("corner_radius")) == sizes


@pytest.mark.parametrize(
    ("remark", "diameter", "corner"),
    [
        ("D=8 CR=4 - ball end mill", 8, 4),
        ("BALL_6 D=6", 6, 3),
        ("BALL D10 R5", 10, 5),
        ("D=10 BALLNOSE", 10, 5),
        ("D=10 BULL NOSE R2", 10, 2),
        ("D=12 CORNER RADIUS 1.5", 12, 1.5),
        ("D=16 R=8 FLAT", 16, None),  # half the diameter
        ("D=10 CR=0. - flat end mill", 10, 0),
        ("D=10 CR=0. - bull nose end mill", 10, None),  # of which CR=0 cannot be true
        ("D=10 CR=0. TAPER=118DEG - DRILL", 10, None),
        ("D=10 BALL R4", 10, None),
        ("D=10 CR=6", 10, None),
        ("D=10 CR=1,5", 10, None),
        ("D=10 BALL BEARING", 10, None),
        ("D=8 - Kugelfr\u00e4ser", 8, 4),
        ("8. BALL ENDMILL - DIA. - 8.", 8, 4),
        # a flat cutter that was a ball in the stock, of which less was removed
        ("D=10 END MILL - ROUGH BEFORE BALL", 10, None),
        ("D=10 END MILL - ROUGH BEFORE BALL NOSE", 10, None),
        ("D=10 VOR KUGELFRAESER", 10, None),
        ("D=6 BALL NOSE FOR SURFACE", 6, 3),
        ("D=8 FINISH ROUGHING BALL", 8, None),
        ("D=6 CR=0.5 TAPER=2deg - tapered mill", 6, None),
        ("D=20 CR=2 - radius mill", 20, None),
    ],
)
def test_a_corner_radius_of_a_remark_is_that_of_a_mill(remark: str, diameter: float, corner: float | None) -> None:
    assert find_corner_radius(remark, diameter) == corner


@pytest.mark.parametrize("corner", [4, 0])
def test_a_corner_radius_of_the_settings_is_written(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, corner: int
) -> None:
    """Without it the tool would be flat in the set-up, and a ball without one; 0 is a flat end, and not an unknown."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.nc").write_text("G90 G94\nT1 M6\nG43 H1\nS900 M3\nG0 X0 Y0 Z20 A0 C0\nG1 X1 F600\nM2\n")
    tool = {"length": 80, "diameter": 8, "corner_radius": corner}
    (tmp_path / "verne-post.toml").write_text(
        f'[setup."a.nc".tools]\n1 = {{ length = 80, diameter = 8, corner_radius = {corner} }}\n'
    )
    assert tomllib.loads(run("setup", "a.nc", "-o", "-").out)["tools"] == {"1": tool}


def test_each_tool_of_a_remark_has_its_own_size(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    cut = "".join(f"T{tool} M6\nG43 H{tool}\nS900 M3\nG0 X0 Y0 Z20 A0 C0\nG1 X{tool} F600\n" for tool in range(1, 7))
    top = "(T1 DRILL D6.8  T2 BALL D10 R5)\n(T3 D=8 FLAT) (T4 D=4 FLAT)\n(T5 D=5 MILL, SAME HOLDER AS T6)\n"
    path.write_text(f"{top}G90 G94\n{cut}M2\n", "utf-8")
    tools = tomllib.loads(run("setup", path, "-o", "-").out)["tools"]
    assert [tools[str(tool)].get("diameter") for tool in range(1, 7)] == [6.8, 10, 8, 4, 5, None]


def test_a_remark_may_have_number_and_name(run: Run, tmp_path: Path) -> None:
    """Siemens programs call a tool by its name; the list at the top has its number too."""
    (tmp_path / "a.mpf").write_text(
        '; T1 "EM_D12_R0"  D=12 R=0 L=75\nG710 G90\nT="EM_D12_R0" M6\nD1\nG0 X0 Y0 Z20\nG1 X1 F600\nM30\n'
    )
    told = run("setup", tmp_path / "a.mpf", "-o", "-")
    assert tomllib.loads(told.out)["tools"] == {"EM_D12_R0": {"length": "measure", "diameter": 12}}
    assert "diameter from this remark, check it" in told.out


def test_what_is_known_is_written_and_not_asked_for(run: Run, tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(FANUC)
    (tmp_path / "tools.tbl").write_text("T1 P1 Z80 D10\nT5 P5 D6\n")
    told = run(
        "setup", tmp_path / "part.nc", "-o", "-", "--tool-table", tmp_path / "tools.tbl", "--wcs", "G54=1,2,3,90"
    )
    assert tomllib.loads(told.out) == {
        "tools": {"1": {"length": 80, "diameter": 10}, "5": {"length": "measure", "diameter": 6}},
        "wcs": {"G54": [1, 2, 3, 90], "G55": "measure"},
        "remap": {"M11": "decide"},
        "split_at_stops": True,
    }


def test_tools_of_a_table_that_are_not_called_are_left_out(run: Run, tmp_path: Path) -> None:
    """A table of a shop has hundreds; a tool without a length that nothing calls is not asked for either."""
    (tmp_path / "part.nc").write_text("G21 G90 G54\nT5 M6\nG43 H5\nG0 X0 Y0 Z90\nG1 Z80 F500\nM30\n")
    (tmp_path / "tools.tbl").write_text("".join(f"T{n} P{n} {'' if n == 3 else f'Z{n}0'} D8\n" for n in range(1, 16)))
    told = run("setup", tmp_path / "part.nc", "-o", "-", "--tool-table", tmp_path / "tools.tbl", "--wcs", "G54=1,2,3")
    assert tomllib.loads(told.out)["tools"] == {"5": {"length": 50, "diameter": 8}}
    assert "# tools that are given and not called are left out: 1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13 and" in told.out
    assert "nothing is missing" in told.err


@pytest.mark.parametrize(("length", "asked"), [("90", ""), ('"measure"', "to be filled in: the length of tool CUTTER")])
def test_a_tool_by_name_keeps_its_number(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, length: str, asked: str
) -> None:
    """The number is what T3 calls and what the events of the rows have; one tool is asked for once."""
    monkeypatch.chdir(tmp_path)
    Path("verne-post.toml").write_text(
        f'[setup."*"]\nwcs = {{G54 = [0, 0, 60]}}\n[setup."*".tools.CUTTER]\nnumber = 3\nlength = {length}\n'
    )
    moves = "G0 X0 Y0 Z50 D1\nG1 Z40 F500\n"
    for call in ('T="CUTTER" M6', "T3 M6", f'T="CUTTER" M6\n{moves}T3 M6'):
        Path("part.mpf").write_text(f"G90 G54 G17 G71\n{call}\nS8000 M3\nTRAORI\n{moves}M30\n")
        told = run("setup", "part.mpf")
        written = length.strip('"')
        expected = {"CUTTER": {"number": 3, "length": float(written) if written.isdecimal() else written}}
        assert tomllib.loads(Path("part.mpf.toml").read_text())["tools"] == expected
        assert (asked or "nothing is missing") in told.err
        assert "tools CUTTER" not in told.err
        checked = run("check", "part.mpf")
        assert "VP503" not in checked.out
        assert ("tool 3" in checked.out) or asked
        Path("part.mpf.toml").unlink()


def test_tools_of_skipped_blocks_are_called_too(run: Run, tmp_path: Path) -> None:
    """The switch of the control may be off the next time: tool 2 was left out, and told to be called by no line."""
    (tmp_path / "part.nc").write_text("G21 G90 G54\nT1 M6\n/T2 M6\nG43 H1\nG0 X0 Y0 Z90\nG1 Z80 F500\nM30\n")
    (tmp_path / "tools.tbl").write_text("".join(f"T{n} P{n} Z{n}0 D8\n" for n in range(1, 4)))
    given = ("--tool-table", tmp_path / "tools.tbl", "--wcs", "G54=1,2,3", "--block-delete")
    told = run("setup", tmp_path / "part.nc", "-o", "-", *given)
    assert list(tomllib.loads(told.out)["tools"]) == ["1", "2"]
    setup = tmp_path / "part.nc.toml"
    setup.write_text("[wcs]\nG54 = [0, 0, 40]\n[tools]\n1 = { length = 80 }\n2 = { length = 90 }\n", "utf-8")
    assert "VP041" not in run("check", tmp_path / "part.nc", "--block-delete").out


def test_a_diameter_is_asked_for_where_a_contour_needs_it(run: Run, tmp_path: Path) -> None:
    """Nothing is said of the diameter that stands in for it: the inside arc has a radius of 2 mm."""
    program = tmp_path / "part.nc"
    head = "G21 G90 G17 G64\nT3 M6\nG54 G0 X0 Y0 A0 C0\nG43 Z50 H3\n"
    program.write_text(f"{head}G41 D3 G1 X10 F500\nY20\nG3 X8 Y22 I-2\nG1 X0\nG40 Y30\nM2\n")
    assert "VP026" not in run("setup", program).err
    found = tomllib.loads(Path(f"{program}.toml").read_text())
    assert found["tools"] == {"3": {"length": "measure", "diameter": "measure"}}


BLANK = "BLK FORM 0.1 Z X-40 Y-40 Z-40\nBLK FORM 0.2 X+40 Y+40 Z+60\n"


@pytest.mark.parametrize(
    ("name", "source", "words", "expected"),
    [
        ("part.nc", FANUC.replace("CR=3. - BALL", ""), ("--stock", "G54=-9,-9,-9,9,9,0"), [10, 6]),
        ("part.nc", FANUC.replace("D=6. CR=3. ", ""), ("--stock", "program"), [10, "measure"]),
        ("part.nc", FANUC.replace("D=6. CR=3. ", ""), (), [10, None]),
        ("part.h", KLARTEXT.replace("TOOL", f"{BLANK}TOOL", 1), (), ["measure"]),
        ("part.h", KLARTEXT.replace("TOOL", f"{BLANK}TOOL", 1), ("--tool-table", "tools.tbl"), [6]),
        ("part.mpf", SIEMENS.replace("N10", 'WORKPIECE(,"",,"BOX",112,0,-20,-80,0,0,50,50)\nN10'), (), ["measure"]),
    ],
)
def test_a_diameter_is_asked_for_where_a_stock_is_cut(
    name: str, source: str, words: tuple[str, ...], expected: list[object], run: Run, tmp_path: Path, monkeypatch: Any
) -> None:
    """As a thin line a tool leaves nearly all of the stock."""
    monkeypatch.chdir(tmp_path)
    Path(name).write_text(source)
    Path("tools.tbl").write_text("T7 P7 Z80 D6\nT8 P8 Z80\n")  # T8 is not called
    Path("verne-post.toml").write_text("[heidenhain.tools]\nMILL_10 = 7\n" if "tools.tbl" in words else "")
    told = run("setup", name, "-o", "-", *words)
    assert [tool.get("diameter") for tool in tomllib.loads(told.out)["tools"].values()] == expected
    assert ("the diameter of tool" in told.err.partition("to be filled in:")[2]) == ("measure" in expected)


@pytest.mark.parametrize(
    "there", ["", "[tools]\n3 = { length = 80 }\n31 = { diameter = 12 }\n[wcs]\nG54 = [0, 0, 60]\n"]
)
def test_a_register_of_a_radius_alone_asks_for_no_length(there: str, run: Run, tmp_path: Path) -> None:
    """D31 beside H3: the length of tool 31 was to be filled in for ever, and check ran without it."""
    program, setup = tmp_path / "d31.nc", tmp_path / "d31.nc.toml"
    head = "%\nO0031\nG21 G17 G90\nT3 M6\nG54 G0 X0 Y0 A0 C0\nG43 Z50 H3\n"
    program.write_text(f"{head}G41 D31 G1 X10 F500\nY20\nG40 X30\nM30\n%\n")
    if there:
        setup.write_text(there)
    said = run("setup", program).err
    assert ("nothing is missing" if there else "the length of tool 3, the diameter of tool") in said
    assert tomllib.loads(setup.read_text())["tools"]["31"] == {"diameter": 12 if there else "measure"}


THERE = """# set-up of part.nc: mm and degrees; write numbers where it says measure
# at the second machine
tapping = "feed"
tolerance = 0.02  # of the drawing

[tools]  # presetter, Monday
1 = { length = 80 }  # flat
9 = { length = 70.5, diameter = 3 }  # drill
"TAP M6" = { length = 60 }

[wcs]
G54 = [0, 0, 60]
G58 = [1, 2, 3]

[siemens]
feed_of_turns = "tip"

[stock]
min = [-40, -40, 0]
max = [40, 40, 40]
system = "G54"
""".replace('[siemens]\nfeed_of_turns = "tip"\n\n', "")
MERGED = """# set-up of part.nc: mm and degrees; write numbers where it says measure
# at the second machine
tapping = "feed"
tolerance = 0.02  # of the drawing
split_at_stops = true  # one file of setpoints from stop to stop; convert needs -o NAME.csv

[tools]  # presetter, Monday
1 = { length = 80, diameter = "measure" }  # flat
9 = { length = 70.5, diameter = 3 }  # drill; not used by the program
"TAP M6" = { length = 60 }  # not used by the program
5 = { length = "measure", diameter = 6, corner_radius = 3 }  # D=6. CR=3. - BALL - diameter and corner_radius \
from this remark, check it

[wcs]
G54 = [0, 0, 60]
G58 = [1, 2, 3]  # not used by the program
G55 = "measure"

[stock]
min = [-40, -40, 0]
max = [40, 40, 40]
system = "G54"

[remap]  # "event" (clamps and the like), "ignore", "M3" to "M6" (spindle, tool change), "tcp on", "tcp off"
M11 = "decide"
"""


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_a_setup_that_is_there_keeps_what_it_says(newline: str, run: Run, tmp_path: Path) -> None:
    """What the program needs in addition is added, what it does not use is marked, and nothing else is touched.

    In the stock tool 1 would be a thin line, so its diameter is asked for.
    """
    program, there = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    program.write_text(FANUC)
    there.write_bytes(THERE.replace("\n", newline).encode())
    told = run("setup", program)
    assert told.code == 0, told.err
    assert there.read_bytes() == MERGED.replace("\n", newline).encode()
    assert (
        "part.nc.toml: added: split_at_stops, tools.1.diameter, tools.5, wcs.G55, remap.M11; not used by the program: "
        'tools.9, tools."TAP M6", wcs.G58; taken from remarks, check it: the diameter of tool 5, '
        "the corner_radius of tool 5; to be filled in: the length of "
        "tool 5, the diameter of tool 1, the place of G55, the meaning of M11\n"
    ) in told.err
    # nothing is new the second time, and a file with nothing new is not written
    before = there.stat().st_mtime_ns, there.stat().st_ino
    assert "added" not in run("setup", program).err
    assert (there.stat().st_mtime_ns, there.stat().st_ino) == before
    # values of the command line take the place of marks; a key that is used again loses its remark
    program.write_text(FANUC.replace("N145 G28 G91 Z0.", "N145 G28 G91 Z0.\nG90\nT9 M6\nG58"))
    told = run("setup", program, "--wcs", "G55=7,8,9")
    merged = tomllib.loads(there.read_text())
    assert merged["wcs"] == {"G54": [0, 0, 60], "G55": [7, 8, 9], "G58": [1, 2, 3]}
    assert "  # drill\n" in there.read_text()
    assert there.read_text().count("not used by the program") == 2  # M6 of the tap, and G58 without a move
    # what "-o -" prints is the whole file, too
    assert run("setup", program, "-o", "-").out.replace("\r", "") == there.read_text()


def test_what_a_program_with_errors_uses_is_not_known(run: Run, tmp_path: Path) -> None:
    program, there = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    program.write_text(FANUC.replace("X30. A5.", "X30. B5."))
    there.write_text(THERE)
    run("setup", program)
    assert "not used" not in there.read_text()
    assert tomllib.loads(there.read_text())["tools"]["5"] == {"length": "measure", "diameter": 6, "corner_radius": 3}


@pytest.mark.parametrize(
    ("there", "expected"),
    [
        ("wcs.G54 = [0, 0, 60]\n", {"wcs": {"G54": [0, 0, 60], "G55": "measure"}}),
        ("wcs.g54 = [0, 0, 60]\n[wcs.x]\n", None),  # it cannot be read
        ("[tools.5]\nlength = 70\n", {"tools": {
            "5": {"length": 70}, "1": {"length": "measure", "diameter": 10, "corner_radius": 0}}}),
        ("[tools]\n01 = { length = 70 }\n5.length = 3\n", {"tools": {"01": {"length": 70}, "5": {"length": 3}}}),
        ("tools = { 1 = { length = 80 }, 5 = { length = 3 } }\n", {"tools": {"1": {"length": 80}, "5": {"length": 3}}}),
        ('[remap]\nM11 = "ignore"', {"remap": {"M11": "ignore"}}),  # its last line has no end
        ("split_at_stops = false\n", {"split_at_stops": False}),
        ('wcs.G54 = [\n  0, # x\n  0,\n  60,\n]\n[tools]\n1 = { length = "measure" }\n', {"wcs": {
            "G54": [0, 0, 60], "G55": "measure"}, "tools": {
                "1": {"length": "measure"}, "5": {"length": "measure", "diameter": 6, "corner_radius": 3}}}),
    ],
)  # fmt: skip
def test_a_setup_is_extended_in_the_way_in_which_it_is_written(
    there: str, expected: dict[str, object] | None, run: Run, tmp_path: Path
) -> None:
    program, written = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    program.write_text(FANUC)
    written.write_text(there)
    told = run("setup", program)
    assert told.code == (2 if expected is None else 0), told.err
    if expected is None:
        assert written.read_text() == there
    else:
        merged = tomllib.loads(written.read_text())
        assert {key: merged[key] for key in expected} == expected
        assert merged["wcs"].keys() == {"G54", "G55"}
        assert {*there.splitlines()} <= {*written.read_text().splitlines()}


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_the_length_of_one_tool_gives_way_to_a_table_of_tools(run: Run, tmp_path: Path, end: str) -> None:
    program, written = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    program.write_text(FANUC.replace("N45 M11\n", ""))
    written.write_bytes(f"tool_length = 80  # calliper{end}wcs.G54 = [0, 0, 60]{end}wcs.G55 = [0, 0, 60]{end}".encode())
    told = run("check", program)
    assert told.code == 2
    assert "VP018 error: --tool-length is the length of one tool, but the program uses T1 and T5" in told.err + told.out
    assert "[tools] of the set-up (`verne-post setup` writes it), without tool_length" in told.err + told.out
    told = run("setup", program)
    assert told.code == 0
    assert "now a remark, because it holds for one tool: tool_length; " in told.err
    assert "to be filled in: the length of tools 1 and 5" in told.err
    text = written.read_bytes().decode()
    assert text.startswith(f"# tool_length = 80  # calliper{end}")
    merged = tomllib.loads(text)
    assert {name: tool["length"] for name, tool in merged["tools"].items()} == {"1": "measure", "5": "measure"}
    assert merged["wcs"] == {"G54": [0, 0, 60], "G55": [0, 0, 60]}
    written.write_bytes(text.replace('length = "measure"', "length = 80").encode())
    assert "VP018" not in run("check", program).out
    # the same of the command line
    written.unlink()
    assert run("setup", program, "--tool-length", 80).code == 0
    merged = tomllib.loads(written.read_text())
    assert "tool_length" not in merged
    assert merged["tools"].keys() == {"1", "5"}


def test_a_setup_in_braces_is_extended_in_them(run: Run, tmp_path: Path) -> None:
    program, written = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    program.write_text(FANUC)
    written.write_text("tools = { 1 = { length = 80 } }\n")
    assert run("setup", program).code == 0
    merged = tomllib.loads(written.read_text())
    assert merged["tools"] == {"1": {"length": 80}, "5": {"length": "measure", "diameter": 6, "corner_radius": 3}}
    assert merged["wcs"] == {"G54": "measure", "G55": "measure"}


def test_a_setup_that_would_mean_something_else_is_left_as_it_is(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program, written = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    program.write_text(FANUC)
    written.write_text("tools = { 1 = { length = 80 } }\n")
    monkeypatch.setattr("verne_post.config.setup_merge.plan_edit", lambda *_given: Change(0, 0, "# nothing\n"))
    told = run("setup", program)
    assert told.code == 2
    assert (
        'write there: split_at_stops = true, tools.5 = { length = "measure", diameter = 6, corner_radius = 3 }, wcs.G54'
        in told.err
    )
    assert written.read_text() == "tools = { 1 = { length = 80 } }\n"


def test_the_diameter_joins_a_tool_that_is_there(run: Run, tmp_path: Path) -> None:
    program, written = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    head = "G21 G90 G17 G64\nT3 M6\nG54 G0 X0 Y0 A0 C0\nG43 Z50 H3\n"
    program.write_text(f"{head}G41 D3 G1 X10 F500\nY20\nG40 Y30\nM2\n")
    for there in (
        "[tools]\n3 = { length = 80 }  # mill\n",
        "[tools]\n3 = {}\n",
        "[tools.3]\nlength = 80\n",
        "tools.3.length = 80\n",
    ):
        written.write_text(there)
        assert run("setup", program).code == 0
        assert tomllib.loads(written.read_text())["tools"]["3"]["diameter"] == "measure"
        written.write_text(written.read_text().replace('diameter = "measure"', "diameter = 8"))
        assert "the diameter" not in run("setup", program).err


def test_tools_of_a_table_are_not_written_beside_it(run: Run, tmp_path: Path) -> None:
    """Both at once would be refused: each says how long all tools are."""
    program, written = tmp_path / "part.nc", tmp_path / "part.nc.toml"
    program.write_text(FANUC)
    (tmp_path / "t.tbl").write_text("T1 P1 Z80 D10\n")
    written.write_text('tool_table = "t.tbl"\n')
    told = run("setup", program)
    assert "tools" not in tomllib.loads(written.read_text())
    assert "its tools are in t.tbl; to be filled in: the length of tool 5" in told.err
    (tmp_path / "sub").mkdir()
    told = run("setup", program, "-o", tmp_path / "sub" / "part.toml")
    assert (told.code, "names files" in told.err) == (2, True)  # t.tbl would be looked for in the other folder


def test_no_setup_is_written_over_by_another(run: Run, tmp_path: Path) -> None:
    program, beside, other = tmp_path / "part.nc", tmp_path / "part.nc.toml", tmp_path / "other.toml"
    program.write_text(FANUC)
    beside.write_text("wcs.G54 = [0, 0, 60]\n")
    other.write_text("wcs.G54 = [0, 0, 70]\n")
    for words in (("--setup", "none"), ("--setup", other), ("-o", other), ("--setup", "none", "-o", other)):
        told = run("setup", program, *words)
        assert told.code == 2, words
        assert "is there already" in told.err
    assert (beside.read_text(), other.read_text()) == ("wcs.G54 = [0, 0, 60]\n", "wcs.G54 = [0, 0, 70]\n")
    assert run("setup", program, "-o", beside).code == 0  # it is the one that is read
    assert tomllib.loads(beside.read_text())["wcs"] == {"G54": [0, 0, 60], "G55": "measure"}


def test_errors_that_no_setup_settles_are_told(run: Run, tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(FANUC.replace("X30. A5.", "X30. B5."))
    told = run("setup", tmp_path / "part.nc", "-o", "-")
    assert told.code == 0
    assert "VP011 error" in told.err
    assert "VP012" not in told.err


@pytest.mark.parametrize(
    ("name", "source", "line", "mistake"),
    [
        ("part.nc", FANUC, "N75 X30. A5.", "WHILE [1 EQ 1] DO1"),
        ("part.nc", FANUC, "N75 X30. A5.", "N75 G65 P700"),
        ("part.nc", FANUC, "N75 X30. A5.", "N75 GOTO 900"),
        ("part.nc", FANUC, "N75 X30. A5.", "\n".join(f"G1 X{n}. Y[{n}" for n in range(60))),  # more than are reported
        ("part.ngc", FANUC.replace("%\nO1000 (BLADE)\n", ""), "N75 X30. A5.", "o100 if [1 eq 1]"),
        ("part.ngc", FANUC.replace("%\nO1000 (BLADE)\n", ""), "N75 X30. A5.", "o<none> call"),
        ("part.mpf", SIEMENS, "N110 X30 A5", "N110 IF R1==1"),
        ("part.mpf", SIEMENS, "N110 X30 A5", "N110 GOTOF NOWHERE"),
        ("part.mpf", SIEMENS, "N110 X30 A5", "N110 SETAL(61000)"),
        ("part.h", KLARTEXT, "L X+30 A+5", "CALL LBL 7"),
        ("part.h", KLARTEXT, "L X+30 A+5", "CALL PGM NOWHERE"),
    ],
)
def test_an_error_hides_nothing_that_the_program_needs(
    name: str, source: str, line: str, mistake: str, run: Run, tmp_path: Path
) -> None:
    """Lines after an error of the program's order were not read: their tools and offsets were not asked for."""
    second = {
        "part.mpf": 'N200 T="DRILL 5" D1\nN210 M6\nN220 S500 M3\nN230 G57\nG0 X0 Y0 Z60\nG1 Z40 M77\nN150 M30',
        "part.h": "TOOL CALL 5 Z S500\nCYCL DEF 247 DATUM SETTING ~\n    Q339=+4 ;DATUM NUMBER\n"
        "L X+0 Y+0 Z+60 FMAX M3\nL Z+40 M77\nL M30",
    }.get(name)
    whole = source if second is None else source.replace("N150 M30", second).replace("L M30", second)
    program = tmp_path / name
    program.write_text(whole)
    expected = tomllib.loads(run("setup", program, "-o", "-").out)
    assert len(expected["tools"]) == len(expected["wcs"]) == 2
    assert expected["remap"]
    program.write_text(whole.replace(line, mistake))
    told = run("setup", program, "-o", "-")
    assert tomllib.loads(told.out) == expected
    assert " error: " in told.err
    assert told.err.endswith(
        "after a correction of the program, give setup again: an error may hide what else it needs\n"
    )


def test_a_loop_without_end_hides_nothing_either(run: Run, tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text(FANUC.replace("N75 X30. A5.", "WHILE [1 EQ 1] DO1\nG1 X[#100+1.]\nX[3\nEND1"))
    told = run("setup", program, "-o", "-", "--max-repeats", "1000")
    assert list(tomllib.loads(told.out)["wcs"]) == ["G54", "G55"]
    assert list(tomllib.loads(told.out)["tools"]) == ["1", "5"]


def test_an_error_of_a_tool_that_stands_in_is_not_told(run: Run, tmp_path: Path) -> None:
    """POCKET3 with paths 4 mm apart was refused because the tool that nobody had given was 1 mm wide."""
    program = tmp_path / "part.mpf"
    pocket = "F500\nPOCKET3(20,0,2,-5,30,20,{},0,0,0,2,0.1,0.1,500,200,0,11,4)"
    program.write_text(SIEMENS.replace("N110 X30 A5", pocket.format(3)))
    told = run("setup", program, "-o", "-")
    assert tomllib.loads(told.out)["tools"] == {"MILL 10": {"length": "measure", "diameter": "measure"}}
    assert "error" not in told.err
    # an error with every tool is told
    program.write_text(SIEMENS.replace("N110 X30 A5", pocket.format(12)))
    assert "VP007 error: POCKET3: " in run("setup", program, "-o", "-").err


def test_the_command_that_a_refusal_names_can_be_pasted(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the name of the program, quoted where a shell needs it, and the keys that are missing."""
    monkeypatch.chdir(tmp_path)
    program = tmp_path / "part 1 ü.nc"
    program.write_text(FANUC.replace("G54", "G56"))
    refused = run("check", program.name).out
    named = re.findall(r"which verne-post (setup .*?) writes", refused)
    assert set(named) == {"setup 'part 1 ü.nc'"}
    assert "Fill in its meaning in part 1 ü.nc.toml" in refused
    assert "Fill in wcs.G55 in part 1 ü.nc.toml" in refused
    assert "give --wcs G55=X,Y,Z" in refused
    assert run(*shlex.split(named[0])).code == 0
    assert (tmp_path / "part 1 ü.nc.toml").exists()
    piped = run("check", "-", stdin=program.read_bytes()).out  # standard input has no name, and no set-up beside it
    assert "which verne-post setup - -o FILE.toml writes" in piped
    assert "INPUT" not in piped
    assert run("setup", "-", "-o", "FILE.toml", stdin=program.read_bytes()).code == 0
    assert "FILE.toml gives no" in run("check", "-", "--setup", "FILE.toml", stdin=program.read_bytes()).out


def test_json_says_which_keys_settle_a_finding(run: Run, tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(FANUC)
    told = run("check", tmp_path / "part.nc", "--output-format", "json")
    found = {item["code"]: item["settled_by"] for item in json.loads(told.out)["programs"][0]["findings"]}
    assert found["VP012"] == ["tools.1.length", "tools.5.length"]
    assert found["VP002"] == ["remap.M11"]
    assert found["VP033"] == ["wcs.G55"]  # the last of the two


@pytest.mark.parametrize("form", ["json", "jsonl"])
def test_json_has_the_remedy_of_the_text(form: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("part.nc").write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X1O F100\nM2\n")
    told = run("check", "part.nc", "--output-format", form).out
    lines = json.loads(told)["programs"][0]["findings"] if form == "json" else map(json.loads, told.splitlines())
    remedies = {item["code"]: item["remedy"] for item in lines}
    assert remedies["VP001"] == ""  # the message says it
    # nothing of a tool is in the program: setup writes no length
    assert remedies["VP012"].startswith("Fill in tool_length, mm, in part.nc.toml")
    text = run("check", "part.nc").out
    assert all(remedy in text for remedy in remedies.values())


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("tool_length = 80\n[tools]\n1 = { length = 80 }\n", "tool_length and tools exclude each other"),
        ('tool_table = "t.tbl"\n[tools]\n1 = { length = 80 }\n', "tools and tool_table exclude each other"),
        ("[tools]\n1 = { length = -80 }\n", "tools.1.length = -80"),
        ("[tools]\n1 = { lenght = 80 }\n", "tools.1.lenght"),
        (
            '[tools]\n1 = { length = "80" }\n',
            "tools.1.length = '80': expected a number: 0 to 10000, without quotes; or \"measure\"",
        ),
        (
            '[wcs]\nG54 = "mesure"\n',
            'expected a list of 3 to 4 numbers: -100000 to 100000, without quotes; or "measure"',
        ),
        ("[tools]\n1 = { length = 80, number = 2 }\n", "the key is its number"),
        ('[tools]\n1 = { length = 80 }\n"A" = { length = 80, number = 1 }\n', "there is a tool 1 already"),
        ('[remap]\nM3 = "ignore"\n', "remap.M3"),
        ('[remap]\nM11 = "skip"\n', "remap.M11"),
        ('[siemens]\nrotation = "zyx"\n', "siemens.rotation"),
        ('[wcs]\nG54 = "table"\n', "wcs.G54"),
    ],
)
def test_keys_that_cannot_be_meant_are_refused_by_name(text: str, sentence: str, run: Run, tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(FANUC)
    (tmp_path / "part.nc.toml").write_text(text)
    told = run("check", tmp_path / "part.nc")
    assert told.code == 2
    assert sentence in told.err + told.out


def test_codes_and_names_of_a_setup_go_before_those_of_the_settings(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    program = tmp_path / "part.h"
    program.write_text(KLARTEXT)
    (tmp_path / "verne-post.toml").write_text("[heidenhain.tools]\nMILL_10 = 7\nOTHER = 8\n")
    Path(f"{program}.toml").write_text("wcs.G55 = [0, 0, 60]\n[tools]\n7 = { length = 75, diameter = 10 }\n")
    assert 'tool 7 "MILL_10": 75 mm' in run(program, "-o", tmp_path / "axes.csv").err
    Path(f"{program}.toml").write_text("wcs.G55 = [0, 0, 60]\n[tools]\nMILL_10 = { length = 85, number = 9 }\n")
    assert 'tool 9 "MILL_10": 85 mm' in run(program, "-o", tmp_path / "axes.csv").err


@pytest.mark.parametrize(
    ("name", "head", "used"),
    [
        ("part.nc", "%\nO1\nG21 G90 G94\nG91 G28 Z0.\nG90\nT1 M6\nG55 {}\nG43.4 H1 Z60.\n", ["G55"]),
        ("part.nc", "%\nO1\nG21 G90 G94\nG91 G28 Z0.\nG28 X0. Y0.\nG90\nT1 M6\nG55 {}\nG43.4 H1 Z60.\n", ["G55"]),
        ("part.nc", "%\nO1\nG21 G90 G94\nG91 G28 Z0.\nG90\nT1 M6\nG54.1 P1 {}\nG43.4 H1 Z60.\n", ["G54.1P1"]),
        # moves of the part before the first word are in G54
        ("part.nc", "%\nO1\nG21 G90 G94\nT1 M6\n{}\nG43.4 H1 Z60.\nG1 X5. F900.\nG55\n", ["G54", "G55"]),
        ("part.mpf", "G710 G90\nSUPA G0 Z0 D0\nT1 M6\nD1\nTRAORI\nG505\n{}\n", ["G58"]),
    ],
)
def test_a_retract_before_the_first_offset_asks_for_none(
    name: str, head: str, used: list[str], run: Run, tmp_path: Path
) -> None:
    path = tmp_path / name
    start = "G0 X0 Y0 Z60 A=0 C=0" if name == "part.mpf" else "G0 X0. Y0. A0. C0."
    path.write_text(f"{head.format(start)}G1 X20. F900.\nM30\n", encoding="utf-8")
    assert run("setup", path).code == 0
    form = Path(f"{path}.toml")
    text = form.read_text(encoding="utf-8")
    assert list(tomllib.loads(text)["wcs"]) == used
    assert ("G505 to G509 are G58" in text) == (name == "part.mpf")
    form.write_text(text.replace('{ length = "measure" }', "{ length = 80 }").replace('"measure"', "[0, 0, 60]"))
    answer = run("check", path)
    assert answer.code == 0, answer.err
    assert "VP033" not in answer.out


@pytest.mark.parametrize(("written", "name"), [("G505", "G58"), ("g510", "G54.1P1"), ("G557", "G54.1P48")])
def test_an_offset_of_siemens_is_told_by_the_name_that_it_has_here(written: str, name: str) -> None:
    with pytest.raises(vp.UsageError, match=rf"{written} of Siemens is {name} here"):
        vp.Options(wcs={written: (0, 0, 0)})


def test_a_tool_change_before_the_start_asks_for_no_split(run: Callable[..., Any], tmp_path: Path) -> None:
    """An error hides the rest; the place after G28 in a tilted system differs from the start by rounding alone."""
    job = tmp_path / "part.nc"
    job.write_text(
        "%\nO1\nG21 G90 G17 G40 G49 G80\nG91 G28 Z0.\nG90\nT1 M6\nG54\nG0 X-10. Y0.\nG68.2 X0. Y0. Z0. I0. J10. K0.\n"
        "G53.1\nG43 H1 Z50.\nG0 X-10. Y-10.\nZ10.\nG1 Z1. F500.\nG0 Z50.\nG69\nG49\nG0 A0. C0.\nM30\n%\n",
        "utf-8",
    )
    assert "VP016" in run("setup", job).err
    assert "split_at_stops" not in (tmp_path / "part.nc.toml").read_text("utf-8")


def test_setup_prints_the_command_that_converts_a_program_with_two_tools(
    run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is run as it is printed, and again where the set-up needs nothing more; one of one part is checked next."""
    monkeypatch.chdir(tmp_path)
    cut = "G54 G0 X{0} Y0 Z20\nG43 H{0} Z10\nG1 Z5 F500\nG0 Z50\n"
    Path("two parts.nc").write_text(f"G21 G90\nT1 M6\nG0 A0 C0\n{cut.format(1)}T2 M6\n{cut.format(2)}M2\n", "utf-8")
    for place, named in (("two parts.nc.toml", []), ("other.toml", ["--setup", "other.toml"])):
        given = ["-o", place] if named else []
        said = run("setup", "two parts.nc", "--machine", "verne", *given).err
        Path(place).write_text(Path(place).read_text("utf-8").replace('G54 = "measure"', "G54 = [0, 0, 60]"), "utf-8")
        Path(place).write_text(Path(place).read_text("utf-8").replace('"measure"', "80"), "utf-8")
        command, files = re.findall(r"^then convert it with: (verne-post .*) \((.*)\)$", said, re.MULTILINE)[0]
        assert shlex.split(command)[1:] == ["two parts.nc", "-o", "axes.csv", "--machine", "verne", *named]
        assert files == "one file for each part, axes.1.csv, ..."
        assert run(*shlex.split(command)[1:]).code == 0
        assert Path("axes.1.csv").is_file() and Path("axes.2.csv").is_file()
        Path("two parts.nc.toml").rename("first.toml") if not named else None
    again = run("setup", "two parts.nc", "--setup", "other.toml", "-o", "other.toml").err
    assert "nothing is missing\nconvert it with: verne-post 'two parts.nc' -o axes.csv --setup other.toml (" in again
    Path("one.nc").write_text(f"G21 G90\nT1 M6\nG0 A0 C0\n{cut.format(1)}M2\n", "utf-8")
    assert run("setup", "one.nc").err.endswith("the place of G54\nthen check it with: verne-post check one.nc\n")
    Path("one.nc.toml").write_text(Path("first.toml").read_text("utf-8").replace("split_at_stops", "#"), "utf-8")
    again = run("setup", "one.nc", "--machine", "verne").err
    command = re.findall(r"^check it with: (verne-post check .*)$", again, re.MULTILINE)[0]
    assert command == "verne-post check one.nc --machine verne" and run(*shlex.split(command)[1:]).code == 0


def test_names_and_codes_that_are_ignored_are_named(run: Run, tmp_path: Path) -> None:
    """A misspelt CYCLE800 is no key of the form; who ignores such a name is told what was not checked."""
    program = tmp_path / "hole.mpf"
    two = SIEMENS.replace("N150", 'T="MILL 2" D1\nM6\nN150')
    program.write_text(two.replace("N100", "CYCLE8OO(1)\nKX_PROBE(2)\nKX_PROBE(3)\nKX_CLAMP\nM150\nN100"))
    written = Path(f"{program}.toml")
    run("setup", program)
    assert tomllib.loads(written.read_text())["remap"] == {"KX_PROBE": "decide", "KX_CLAMP": "decide", "M150": "decide"}
    fill(written)
    refused = run("check", program)
    again = run("setup", program)  # its status is about the file
    assert again.code == 0
    assert again.err.endswith("give setup again: an error may hide what else it needs\n")
    assert "convert it with" not in again.err
    assert (refused.code, "CYCLE8OO: no meaning in this language; did you mean CYCLE800?" in refused.out) == (2, True)
    program.write_text(program.read_text().replace("CYCLE8OO(1)\n", ""))
    told = run("check", program)
    assert told.code == 0
    ignored = "KX_PROBE in line 10 and 1 more, KX_CLAMP in line 12, M150 in line 13"
    assert f"  NOT CHECKED: ignored by [remap]: {ignored}; contact" in told.out


def test_the_length_of_a_program_without_a_tool_is_in_the_form(run: Run, tmp_path: Path) -> None:
    """The form was never complete: check asked for a key that setup had not written."""
    program = tmp_path / "part.nc"
    program.write_text("G21 G90 G54\nG0 X0 Y0 Z50 A0 C0\nG1 Z20 F2000\nM2\n")
    assert "to be filled in: the place of G54, the tool length" in run("setup", program).err
    written = Path(f"{program}.toml")
    assert tomllib.loads(written.read_text()) == {"tool_length": "measure", "wcs": {"G54": "measure"}}
    assert "Fill in tool_length, mm, in" in run("check", program).out
    assert "nothing is missing" in run("setup", program, "--tool-length", 80, "--wcs", "G54=0,0,60").err
    assert run("check", program).code == 0


@pytest.mark.parametrize(("diameter", "is_told"), [(12, True), (10, False)])
def test_a_diameter_that_differs_from_the_remark_is_told(
    diameter: float, is_told: bool, tmp_path: Path, run: Run
) -> None:
    """Check warned of it, and setup said that nothing is missing."""
    path, table = tmp_path / "a.nc", tmp_path / "t.tbl"
    path.write_text(
        "(T1 D=10. - FLAT END MILL)\nG21 G90 G94\nT1 M6\nS900 M3\nG54\nG0 X0 Y0 A0 C0\nG43 H1 Z20\nG1 G41 D1 X9 F600\n"
        "X40\nG0 G40 X60\nM30\n"
    )
    table.write_text(f"T1 P1 Z90 D{diameter}\n")
    doubt = "tool 1: a diameter of 12 mm is not the 10 mm that the program's remark in line 1 names"
    made = run("setup", path, "--tool-table", table, "--wcs", "G54=0,0,60")
    assert (f"in doubt: {doubt}; nothing is missing" in made.err + made.out) == is_told
    form = Path(f"{path}.toml")
    assert (f"# {doubt}\n" in form.read_text()) == is_told
    again = run("setup", path)
    assert (f"in doubt: {doubt}; nothing is missing" in again.err + again.out) == is_told
    assert (doubt in run("check", path).out) == is_told
