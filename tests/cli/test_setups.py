"""The set-up of a program: part.nc.toml beside it, [setup.GLOB] of the settings file, and the command line
above both.
"""

import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import verne_post
from verne_post.app.program_folders import PROGRAMS
from verne_post.gcode.dialects import DIALECTS

MACHINES = Path(__file__).resolve().parents[2] / "machine_configs"
SAMPLES = Path(__file__).resolve().parents[2] / "gcode_samples"
PROGRAM = "G21 G90 G94 G49\nG0 X0 Y0 Z50 A0 C0\nG1 Z20 F2000\nX10\nM2\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a program."""
    monkeypatch.chdir(tmp_path)
    Path("part.nc").write_text(PROGRAM, encoding="utf-8")
    return tmp_path


def options_of(run: Callable[..., Any], *words: object) -> dict[str, Any]:
    """The options that a conversion took, from its metadata file."""
    answer = run("part.nc", "-o", "axes.csv", "--meta", "meta.json", *words)
    assert answer.code == 0, answer.err
    record: dict[str, Any] = json.loads(Path("meta.json").read_text(encoding="utf-8"))["options"]
    return record


def test_the_file_beside_the_program_gives_what_the_command_line_would(folder: Path, run: Callable[..., Any]) -> None:
    words = [
        "--tool-length",
        "80",
        "--wcs",
        "G54=1,2,40,30",
        "--tolerance",
        "0.02",
        "--keep-out",
        "vise=200,200,0,210,210,9",
    ]
    given = options_of(run, *words)
    rows = Path("axes.csv").read_bytes()
    Path("part.nc.toml").write_text(
        "tool_length = 80\ntolerance = 0.02\n[wcs]\nG54 = [1, 2, 40, 30]\n"
        "[keep_out.vise]\nmin = [200, 200, 0]\nmax = [210, 210, 9]\n",
        encoding="utf-8",
    )
    assert options_of(run) == given
    assert Path("axes.csv").read_bytes() == rows
    said = run("check", "part.nc").out
    assert "set-up: from part.nc.toml\n" in said


def test_the_summary_names_options_that_override_the_set_up(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc.toml").write_text("tool_length = 80\n[wcs]\nG54 = [1, 2, 40]\n", encoding="utf-8")
    measured = Path("offsets.json")
    measured.write_text('[{"system": "G54", "x_mm": 1, "y_mm": 2, "z_mm": 41}]', encoding="utf-8")
    for words, told in (
        (["--wcs", "G55=0,0,40", "--tolerance", "0.02"], ""),  # the set-up has neither
        (["--wcs", "G54=1,2,41", "--tool-length", "81"], ", overridden by --tool-length, --wcs"),
        (["--measured-offset", str(measured)], ", overridden by --measured-offset"),
    ):
        answer = run("check", "part.nc", *words)
        assert f"set-up: from part.nc.toml{told}\n" in answer.out, answer.out + answer.err


def test_every_command_reads_it(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc.toml").write_text("tool_length = 80\n[wcs]\nG54 = [0, 0, 300]\n", encoding="utf-8")
    assert run("part.nc", "-o", "axes.csv").code == 0
    assert run("verify", "axes.csv", "--against", "part.nc").code == 0
    assert "tool length 80 mm" in run("explain", "part.nc:3").out
    assert "o = (0.000000, 0.000000, 300.000000)" in run("explain", "part.nc:3", "--all").out
    assert run("verify", "axes.csv", "--against", "part.nc", "--setup", "none").code == 1
    # without its file the program is another one
    assert "VP033" in run("check", "part.nc", "--setup", "none").out
    stdin = Path("part.nc").read_bytes()
    assert "VP033" in run("check", "-", stdin=stdin).out
    assert "VP033" not in run("check", "-", "--setup", "part.nc.toml", stdin=stdin).out


def test_the_command_line_goes_before_the_file_and_the_file_before_the_settings(
    folder: Path, run: Callable[..., Any]
) -> None:
    Path("verne-post.toml").write_text(
        '[options]\ntolerance = 0.03\nsmoothing = "blend"\n[setup."*.nc"]\ntolerance = 0.04\ntool_length = 70\n'
        '[setup."*.nc".wcs]\nG54 = [0, 0, 30]\nG55 = [0, 0, 31]\n[setup."other/*.nc"]\ntool_length = 1\n',
        encoding="utf-8",
    )
    assert options_of(run)["tolerance_mm"] == 0.04
    Path("part.nc.toml").write_text("tolerance = 0.05\n[wcs]\nG54 = [0, 0, 50]\n", encoding="utf-8")
    taken = options_of(run)
    assert taken["tolerance_mm"] == 0.05
    assert taken["tool_length_mm"] == 70
    assert taken["wcs"] == {"G54": [0, 0, 50, 0], "G55": [0, 0, 31, 0]}
    taken = options_of(run, "--tolerance", 0.06, "--wcs", "G55=1,1,31")
    assert taken["tolerance_mm"] == 0.06
    assert taken["wcs"] == {"G54": [0, 0, 50, 0], "G55": [1, 1, 31, 0]}
    assert options_of(run, "--setup", "none")["tolerance_mm"] == 0.03


def test_lengths_of_tools_come_from_one_place(folder: Path, run: Callable[..., Any]) -> None:
    """A length of the command line is not beaten by a table of the file, nor a table of the file by a length of the
    settings. The diameters of the table hold beside it.
    """
    Path("part.nc").write_text(PROGRAM.replace(" G49", "").replace("G0 X0", "T1 M6\nG43 H1 G0 X0"), encoding="utf-8")
    Path("tools.tbl").write_text("T1 P1 Z66 D6\n", encoding="utf-8")
    Path("verne-post.toml").write_text('[setup."part.nc"]\ntool_length = 70\n', encoding="utf-8")
    Path("part.nc.toml").write_text('tool_table = "tools.tbl"\n[wcs]\nG54 = [0, 0, 30]\n', encoding="utf-8")
    taken = options_of(run)
    assert (taken["tool_length_mm"], taken["tools"]) == (None, {"1": [66, 6]})
    taken = options_of(run, "--tool-length", 80)
    assert (taken["tool_length_mm"], taken["tools"]) == (80, {"1": [66, 6]})
    Path("part.nc.toml").write_text("[tools]\n1 = { length = 66, diameter = 6 }\n[wcs]\nG54 = [0, 0, 30]\n")
    Path("part.nc").write_text("G21 G90 G17\nT1 M6\nG0 X0 Y0 Z60 A0 C0\nG1 Z50 F500\nG41 D1 X9\nX20\nG40 X40\nM2\n")
    answer = run("setup", "part.nc", "--tool-length", 80)
    assert "nothing is missing" in answer.err


def test_a_tool_that_the_setup_lacks_does_not_take_the_diameter_of_another(
    folder: Path, run: Callable[..., Any]
) -> None:
    Path("p.mpf").write_text('G17 G90 G54 G71\nT="B" D1 M6\nG0 X0 Y0 Z60\nG1 Z50 F500\nG41 X9\nX20\nG40 X40\nM30\n')
    Path("p.mpf.toml").write_text("[tools]\nA = { length = 66, diameter = 6 }\n[wcs]\nG54 = [0, 0, 30]\n")
    answer = run("check", "p.mpf", "--tool-length", 80)
    said = answer.out + answer.err
    assert said.count(" error: ") == 1
    assert 'VP012 error: the diameter of tool "B" is not known' in said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("tool_lenght = 80", "VP503 error: tool_lenght: this is no option of a set-up; did you mean tool_length?"),
        (
            "[options]\ntool_length = 80",
            "options: the options of a set-up belong at its top; delete the line [options]",
        ),
        ('machine = "hexapot"', 'write machine = "hexapod" in the settings file verne-post.toml, above its tables'),
        ('machine = "hexapot"', "; no machine is named hexapot, see verne-post machine list"),
        ('machine = "my.toml"', 'write machine = "my.toml" in the settings file verne-post.toml'),
        ("tool_length = -1", "VP503 error: tool_length = -1"),
        ("[wcs]\nG54 = [1, 2]", "VP503 error: wcs.G54"),
        ("[wcs]\nG44 = [1, 2, 3]", "'G44' is not a work system"),
        ("[wcs]\nfoo = 3", "VP503 error: wcs: 'foo' is not a work system; expected one of G54, G55,"),
        ("[wcs]\nG54 = 3", 'wcs.G54 = 3: expected a list of 3 to 4 numbers: -100000 to 100000; or "measure"'),
        ("[wcs]\nG54 = [1, 2, 1e6]", "VP503 error: wcs.G54, value 3 = 1000000.0"),
        (
            '[tools]\n3 = { length = "90" }',
            """VP503 error: tools.3.length = '90': expected a number: 0 to 10000, without quotes; or "measure\"""",
        ),
        (
            '[wcs]\nG54 = "0,0,20"',
            'expected a list of 3 to 4 numbers: -100000 to 100000, without quotes; or "measure"',
        ),
        ("tool_length = ", "VP503 error: not a TOML file"),
        (
            "[tools]\n3 = { length = 90,5 }",
            "part.nc.toml:2:21: VP503 error: not a TOML file: 90,5: a decimal comma; write 90.5\n",
        ),
        ("[wcs]\nG54 = [0, 0, 40,5]", "part.nc.toml:2:14: VP503 error: 40,5: write 40.5, or a blank after the comma"),
        ('wcs = { "G54" = [0, 1,5, 40] }', "1,5: write 1.5, or a blank after the comma"),
        ("tool_length = 90,5 # mm", "90,5: a decimal comma; write 90.5\n"),
        (
            "[tools]\n3 = { length = 90,5, diameter = 6 }",
            "part.nc.toml:2:20: VP503 error: not a TOML file: 90,5: a decimal",
        ),
        (
            "[tools]\n3 = { length = 8O }",
            "2:17: VP503 error: not a TOML file: 8O: the letter O in a number; write 80\n",
        ),
        ("tool_length = 90mm", "90mm: a number has no unit; write 90, in the unit of the key\n"),
        ("tool_length = 90.", "90.: a number needs a digit on both sides of the point; write 90.0\n"),
        ("tool_length: 90", "write = instead of :\n"),
        ("; of part.nc\n", "a remark begins with #\n"),
        ("[tools]\n3 = { length = 90; diameter = 6 }", "2:18: VP503 error: not a TOML file: write a comma between"),
        ("[tools]\n3 = { length = 90 diameter = 6 }", "write a comma between the keys of a table\n"),
        (
            "tool_table = “tools.tbl”",
            'a left double quotation mark (U+201C), as copied from a mail or PDF; write a straight quote (")\n',
        ),
        ("tool_length = \u201190", "a non-breaking hyphen (U+2011), as copied from a mail or PDF; write a minus (-)\n"),
        ("split_at_stops = True", "True: write true\n"),
        ("wcs.G54.1P1 = [0, 0, 1]", 'wcs.G54.1P1: a name with a point is in quotes; write "G54.1P1" = [X, Y, Z]'),
        ("wcs.G54 = {x = 1, y = 2}", "wcs.G54: a place is a list of three numbers; write G54 = [X, Y, Z]"),
        ("tool_table = tools.tbl", 'tools.tbl: a text is in quotes; write "tools.tbl"\n'),
        (
            'tool_table = "tools.tbl\n',
            '1:24: VP503 error: not a TOML file: "tools.tbl: the quote is not closed; write "tools.tbl"',
        ),
        ('tool_table = "C:\\Users"', "a backslash in a text; write the text in ' ' instead of quotation marks\n"),
        ("[tools]\n3 = { length = 90,\n", "the brace { is not closed in its line; write } where the table ends"),
        (
            "[wcs]\nG54 = [0, 0, 60\n[tools]\n",
            "2:7: VP503 error: not a TOML file: [0, 0, 60: the bracket [ is not closed; write [0, 0, 60]",
        ),
        ("[wcs]\nG54 = [0, 0, 60\nG55 = [1, 2, 3]\n", "2:7: VP503 error: not a TOML file: [0, 0, 60: the bracket"),
        ("[wcs]\nG54 = [0, 0,\n60\n[tools]\n", "the bracket [ is not closed; write ] where the list ends"),
        ("[wcs]\nG54 = [0,0 60]", "write [0, 0, 60]"),
        (
            "[tools]\n3 = { length = 90 }\n3 = { length = 80 }",
            "3:1: VP503 error: not a TOML file: 3: the key is there twice, first in line 2; write it",
        ),
        (
            "[wcs]\nG54 = [1,\n2, 3]\n'G54' = [1,\n2, 3]",
            "4:1: VP503 error: not a TOML file: 'G54': the key is there twice",
        ),
        ("[wcs] G54 = [1, 2, 3]", "[wcs]: the header of a table stands alone in its line"),
        (
            "[tools]\n3 = { length = 9, length = 9 }",
            "2:19: VP503 error: not a TOML file: length: the key is there twice",
        ),
        ("[tools]\n3 = { length = 9 }\n[tools.3]\n", "3:9: VP503 error: not a TOML file: tools.3: the table is there"),
        ("[tools]\n[tools]", "2:7: VP503 error: not a TOML file: tools: the table is there twice, first in line 1"),
        ("[WCS]\nG54 = [1, 2, 3]", "WCS: this is no option of a set-up; did you mean wcs?"),
        ('tool_table = ""', "VP503 error: tool_table = ''"),
        (
            "[keep_out.vise]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ndistance_mm = 1e6",
            "keep_out.vise.distance_mm = 1000000.0",
        ),
        ('tool_table = "parts.nc"', "tool_table = parts.nc: No such file or directory; did you mean part.nc?"),
        ('tool_table = "none.tbl"', "part.nc.toml:1:14: VP022 error: tool_table = none.tbl: No such file or directory"),
        (
            'tool_lengths = "none.csv"',
            "part.nc.toml:1:16: VP022 error: tool_lengths = none.csv: No such file or directory",
        ),
        (
            'tool_shapes = "none.toml"',
            "part.nc.toml:1:15: VP022 error: tool_shapes = none.toml: No such file or directory",
        ),
        ('parameters = "none.var"', "part.nc.toml:1:14: VP022 error: parameters = none.var: No such file or directory"),
        (
            'measured_offset = "none.csv"',
            "part.nc.toml:1:19: VP022 error: measured_offset = none.csv: No such file or directory",
        ),
        ("[keep_out.vise]\nmin = [0, 0, 0]\nmax = [1, 1, 0]", "keep_out.vise"),
    ],
)
def test_mistakes_name_the_file_and_the_key(folder: Path, run: Callable[..., Any], text: str, said: str) -> None:
    Path("part.nc.toml").write_text(text + "\n", encoding="utf-8")
    answer = run("part.nc", "-o", "axes.csv")
    assert answer.code == 2
    assert said in answer.err
    assert answer.err.count("part.nc.toml") == 1, answer.err
    assert not Path("axes.csv").exists()


def test_a_mistake_of_a_set_up_looks_like_one_of_a_program(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc.toml").write_text("[wcs]\nG54 = [0, 0, 4000000]  # x\n[tools]\n1 = {lenght = 80}\n", encoding="utf-8")
    assert run("check", "part.nc").out.splitlines()[:6] == [
        "part.nc.toml:2:14: VP503 error: wcs.G54, value 3 = 4000000: expected a number: -100000 to 100000",
        "  2 | G54 = [0, 0, 4000000]  # x",
        "    |              ^",
        "part.nc.toml:4:6: VP503 error: tools.1.lenght is not a key of a set-up; did you mean length?",
        "  4 | 1 = {lenght = 80}",
        "    |      ^",
    ]
    Path("none.toml").write_text('tool_table = "none.tbl"\n', encoding="utf-8")
    for command in ("check", "convert", "explain"):
        words = ("part.nc:1",) if command == "explain" else ("part.nc",)
        said = run(command, *words, "--setup", "none.toml")
        assert (said.out + said.err).splitlines()[:3] == [
            "none.toml:1:14: VP022 error: tool_table = none.tbl: No such file or directory",
            '  1 | tool_table = "none.tbl"',
            "    |              ^",
        ]
    (found, _other) = json.loads(run("check", "part.nc", "--output-format", "json").out)["programs"][0]["findings"]
    assert (found["file"], found["file_line"], found["file_column"], found["column"]) == ("part.nc.toml", 2, 14, None)


def test_a_tool_number_that_is_written_as_a_name(run: Callable[..., Any], tmp_path: Path) -> None:
    """The line of the program was named, and a length asked for that the set-up has."""
    program = tmp_path / "part.nc"
    program.write_text("G21 G90 G94 G54\nT3 M6\nG43 H3\nS900 M3\nG0 A0 C0\nX0 Y0 Z50\nG1 X5 F100\nM30\n")
    setup = tmp_path / "part.nc.toml"
    setup.write_text("[tools]\nT3 = { length = 90 }\n[wcs]\nG54 = [0, 0, 40]\n")
    told = run("check", program)
    assert "the set-up has no tool 3, and T3 is the name of one; write 3 in place of T3 there" in told.out
    assert (told.code, "Fill in" in told.out) == (2, False)
    setup.write_text(setup.read_text().replace("T3", "3"))
    assert run("check", program).code == 0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[setup."*.nc"]\ntool_table = "none.tbl"', "verne-post.toml, setup.'*.nc': tool_table = "),
        ('[check]\nbaseline = "none.json"', "settings: check.baseline = "),
        ('machine = "serail"', "verne-post.toml:1:1: VP501 error: machine = 'serail': No such file or directory"),
    ],
)
def test_a_file_that_the_settings_name_and_nobody_has_is_named_with_its_key(
    folder: Path, run: Callable[..., Any], text: str, said: str
) -> None:
    Path("verne-post.toml").write_text(text + "\n", encoding="utf-8")
    answer = run("check", "part.nc")
    assert answer.code == 2
    assert said in answer.err + answer.out
    assert "No such file or directory" in answer.err + answer.out
    if "serail" in text:
        assert answer.err.endswith("nothing was checked: 1 error in verne-post.toml\n")
        assert not answer.out


def test_files_may_begin_with_the_mark_that_editors_write(folder: Path, run: Callable[..., Any]) -> None:
    """A set-up, settings, a machine and what they name: as without the mark."""
    Path("part.nc").write_text(PROGRAM.replace(" G49", "").replace("G0 X0", "T1 M6\nG43 H1\nG0 X0"), encoding="utf-8")
    texts = {
        "verne-post.toml": 'machine = "mine.toml"\n',
        "mine.toml": (MACHINES / "verne.toml").read_text(encoding="utf-8"),
        "part.nc.toml": 'tool_table = "tools.tbl"\ntool_shapes = "shapes.toml"\nmeasured_offset = "wcs.csv"\n',
        "tools.tbl": "T1 P1 Z66 D6\n",
        "shapes.toml": "[tool.1]\ncutter = { diameter = 6, length = 20 }\n",
        "wcs.csv": "system,x_mm,y_mm,z_mm\nG54,0,0,30\n",
    }
    for encoding in ("utf-8", "utf-8-sig"):
        for name, text in texts.items():
            Path(name).write_text(text, encoding=encoding)
        taken = options_of(run)
        assert (taken["tools"], taken["wcs"]) == ({"1": [66, 6]}, {"G54": [0, 0, 30, 0]})
    Path("part.nc.toml").write_text(texts["part.nc.toml"], encoding="utf-16")
    assert "part.nc.toml: VP503 error: not a TOML file: text in UTF-16; save it as UTF-8" in run("check", "part.nc").out


def test_a_diameter_that_is_not_that_of_the_shape_has_both_places(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc").write_text(PROGRAM.replace(" G49", "").replace("G0 X0", "T1 M6\nG43 H1\nG0 X0"), encoding="utf-8")
    Path("part.nc.toml").write_text(
        'tool_shapes = "shapes.toml"\n[tools]\n1 = { length = 66, diameter = 8 }\n'
        "[keep_out.vise]\nmin = [190, 0, 0]\nmax = [200, 9, 9]\n",
        encoding="utf-8",
    )
    Path("shapes.toml").write_text("[tool.1]\ncutter = { diameter = 6, length = 20 }\n", encoding="utf-8")
    assert (
        "part.nc.toml:3:1: VP018 error: tool 1: its cutter among the tool shapes (shapes.toml:2) is 6 mm thick, but "
        "its diameter in tools.1 of the set-up is 8"
    ) in run("check", "part.nc").out


def test_every_mistake_is_told_at_once(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc.toml").write_text('tool_lenght = 80\ntolerance = "big"\n[wcs]\nG44 = [1, 2, 3]\n', encoding="utf-8")
    answer = run("part.nc")
    assert all(
        text in answer.err for text in ("tool_lenght: this is no option", "tolerance = 'big'", "'G44' is not a work")
    )


def test_a_set_up_may_leave_half_of_a_pair_to_the_command_line(folder: Path, run: Callable[..., Any]) -> None:
    """from_line needs --from, which changes with every restart."""
    Path("part.nc.toml").write_text(
        'tool_length = 80\nair_along = "table"\n[wcs]\nG54 = [0, 0, 60]\n', encoding="utf-8"
    )
    assert run("check", "part.nc", "--air", 50).code == 0
    assert "needs --air, the height" in run("part.nc").err


def test_a_set_up_is_not_written_over(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc.toml").write_text("tool_length = 80\n", encoding="utf-8")
    assert run("part.nc", "-o", "part.nc.toml").code == 2
    assert Path("part.nc.toml").read_text(encoding="utf-8") == "tool_length = 80\n"


def test_the_samples_run_as_they_stand(run: Callable[..., Any]) -> None:
    """Every sample has its set-up beside it: only those that violate on purpose are refused; docs/batch.md converts
    them.
    """
    expected = {path.name for path in SAMPLES.iterdir() if path.name.startswith("violates")} - {
        path.name for path in SAMPLES.glob("*.toml")
    }
    answer = run("check", SAMPLES, "--limits-only", "--output-format", "json")
    assert answer.code == 1
    listed = json.loads(answer.out)["programs"]
    assert len(listed) > 12
    assert {Path(one["program"]).name for one in listed if one["verdict"] != "not refused"} == expected
    assert not [item for one in listed for item in one["findings"] if item["severity"] == "warning"]


def test_batch_keeps_the_mistake_of_one_set_up_alone(folder: Path, run: Callable[..., Any]) -> None:
    shutil.copy("part.nc", "second.nc")
    Path("part.nc.toml").write_text("tool_length = 80\n[wcs]\nG54 = [0, 0, 30]\n", encoding="utf-8")
    Path("second.nc.toml").write_text("nonsense = 1\n", encoding="utf-8")
    answer = run("batch", ".", "-o", "out", "-j", 1)
    assert answer.code == 2
    assert "1 can run" in answer.out
    assert "second.nc.toml:1:1: VP503 error: nonsense: this is no option" in answer.err
    # the set-up is part of what the rows were made of
    assert "as before" in run("batch", "part.nc", "-o", "out", "-j", 1).out
    Path("part.nc.toml").write_text("tool_length = 81\n[wcs]\nG54 = [0, 0, 30]\n", encoding="utf-8")
    assert "as before" not in run("batch", "part.nc", "-o", "out", "-j", 1).out


def test_rows_under_a_name_that_is_shared_now_do_not_stay(folder: Path, run: Callable[..., Any]) -> None:
    place = ("--tool-length", 80, "--wcs", "G54=0,0,30")
    assert run("batch", ".", "-o", "out", "-j", 1, *place).code == 0
    assert Path("out/part.csv").exists()
    shutil.copy("part.nc", "part.ngc")
    assert run("batch", ".", "-o", "out", "-j", 1, *place).code == 0
    assert sorted(path.name for path in Path("out").glob("*.csv")) == ["part.nc.csv", "part.ngc.csv"]


def test_the_settings_file_names_the_machine_of_a_folder(folder: Path, run: Callable[..., Any]) -> None:
    words = ("--tool-length", "80", "--wcs", "G54=0,0,60")
    text = (MACHINES / "verne.toml").read_text(encoding="utf-8")
    (folder / "machines").mkdir()
    (folder / "machines" / "mine.toml").write_text(text.replace('name = "VERNE"', 'name = "MINE"'), encoding="utf-8")
    settings = folder / "verne-post.toml"
    for value, name in (("machines/mine.toml", "MINE"), ("serial", "serial five-axis machine"), (None, "VERNE")):
        settings.write_text("" if value is None else f'machine = "{value}"\n', encoding="utf-8")
        assert f"can run on {name}," in run("part.nc", "-o", "axes.csv", *words).err
        assert "can run on VERNE," in run("part.nc", "-o", "axes.csv", "--machine", "verne", *words).err
    settings.write_text('machine = "machines/mine.toml"\n', encoding="utf-8")
    below = folder / "below"
    below.mkdir()
    shutil.copy(folder / "part.nc", below)
    assert "can run" in run("check", below / "part.nc", *words).out
    assert run("batch", below, "-o", folder / "out", *words).code == 0
    settings.write_text('machine = "none.toml"\n', encoding="utf-8")
    for command in (("check", "part.nc"), ("part.nc", "-o", "axes.csv"), ("batch", "below", "-o", "out")):
        answer = run(*command, *words)
        assert answer.code == 2
        assert "none.toml" in answer.err


TOOLS = "G21 G90 G94\nT1 M6\nG43 H1\nG0 X0 Y0 Z50 A0 C0\nG1 Z20 F2000\nX10\nM2\n"


def test_a_tool_table_goes_before_a_length_of_the_settings_file(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc").write_text(TOOLS, encoding="utf-8")
    Path("t.tbl").write_text("T1 P1 Z50 D8\n", encoding="utf-8")
    Path("l.csv").write_text("tool,length_mm\n1,50\n", encoding="utf-8")
    Path("verne-post.toml").write_text("[options]\ntool_length = 120\n", encoding="utf-8")
    place = ("--wcs", "G54=0,0,60")
    assert "tool 1: 120 mm" in run("check", "part.nc", *place).out
    assert "tool 1: 50 mm" in run("check", "part.nc", *place, "--tool-table", "t.tbl").out
    assert "tool 1: 50 mm" in run("check", "part.nc", *place, "--tool-lengths", "l.csv").out
    assert "tool 1: 70 mm" in run("check", "part.nc", *place, "--tool-length", "70").out
    Path("part.nc.toml").write_text('tool_table = "t.tbl"\n', encoding="utf-8")
    assert "tool 1: 50 mm" in run("check", "part.nc", *place).out


def test_a_work_system_twice_in_a_set_up_is_refused(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc.toml").write_text("tool_length = 80\n[wcs]\nG54 = [0, 0, 60]\ng54 = [0, 0, 90]\n", encoding="utf-8")
    answer = run("check", "part.nc")
    assert answer.code == 2
    assert "given twice" in answer.err + answer.out


def test_measured_offsets_replace_the_systems_that_they_name(folder: Path, run: Callable[..., Any]) -> None:
    Path("part.nc").write_text(PROGRAM.replace("G0 X0", "G55 G0 X0"), encoding="utf-8")
    Path("part.nc.toml").write_text("tool_length = 80\n[wcs]\nG54 = [1, 1, 60]\nG55 = [5, 5, 60]\n", encoding="utf-8")
    Path("m.csv").write_text("system,x_mm,y_mm,z_mm\nG54,0,0,50\n", encoding="utf-8")
    assert "G55 at (5, 5, 60)" in run("check", "part.nc", "--measured-offset", "m.csv").out
    Path("m.csv").write_text("system,x_mm,y_mm,z_mm\nG55,7,0,50\n", encoding="utf-8")
    assert "G55 at (7, 0, 50)" in run("check", "part.nc", "--measured-offset", "m.csv").out
    answer = run("check", "part.nc", "--measured-offset", "m.csv", "--wcs", "G55=1,1,1")
    assert (answer.code, "give it once" in answer.err) == (2, True)
    Path("part.nc.toml").write_text('tool_length = 80\nmeasured_offset = "m.csv"\n', encoding="utf-8")
    assert "G55 at (7, 0, 50)" in run("check", "part.nc").out
    assert "G55 at (1, 1, 61)" in run("check", "part.nc", "--wcs", "G55=1,1,61").out
    Path("n.csv").write_text("system,x_mm,y_mm,z_mm\nG54,0,0,50\n", encoding="utf-8")
    assert "G55 at (7, 0, 50)" in run("check", "part.nc", "--measured-offset", "n.csv").out
    with Path("part.nc.toml").open("a", encoding="utf-8") as file:
        file.write("[wcs]\nG55 = [1, 1, 1]\n")
    answer = run("part.nc")
    assert (answer.code, "VP503 error: wcs.G55: " in answer.err) == (2, True)


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        ('# see [tool.verne-post] in the docs\n[project]\nname = "x"\n', "verne-post.toml"),
        ("[tool.verne-posts.options]\ntolerance = 0.02\n", "verne-post.toml"),
        ("[tool]\nverne-post = {options = {tolerance = 0.02}}\n", "pyproject.toml"),
        ("[ tool.verne-post.options ]\ntolerance = 0.02\n", "pyproject.toml"),
    ],
)
def test_a_project_file_counts_by_its_table(folder: Path, run: Callable[..., Any], text: str, settings: str) -> None:
    Path("verne-post.toml").write_text("", encoding="utf-8")
    below = folder / "below"
    below.mkdir()
    shutil.copy("part.nc", below)
    (below / "pyproject.toml").write_text(text, encoding="utf-8")
    os.chdir(below)
    answer = run("check", "part.nc", "--tool-length", "80", "--wcs", "G54=0,0,60")
    assert (answer.code, Path(answer.err.split("settings of ")[1].split("\n")[0]).name) == (0, settings)


@pytest.mark.parametrize("text", ["tool = 5\n", "[tool]\nverne-post = 5\n", "[[tool]]\n", "[project]\n"])
def test_a_project_file_without_the_table_is_no_settings_file(folder: Path, run: Callable[..., Any], text: str) -> None:
    Path("pyproject.toml").write_text(text, encoding="utf-8")
    answer = run("check", "part.nc", "--tool-length", "80", "--settings", "pyproject.toml")
    assert (answer.code, "no table [tool.verne-post]" in answer.err) == (2, True)


def test_a_path_is_no_name_of_a_machine(folder: Path) -> None:
    shutil.copy(MACHINES / "serial.toml", folder / "verne")
    assert verne_post.load_machine(Path("verne")).name == "serial five-axis machine"
    assert verne_post.load_machine("verne").name == "VERNE"


@pytest.mark.parametrize(
    "words",
    [
        ("machine", "axis-check", "--at", "0,0,0,0,0", "-o", "check"),
        ("machine", "perturb", "--seed", "1", "-o", "built.toml"),
        ("machine", "tolerances"),
        ("machine", "calibrate", "--plan", "8", "-o", "readings.csv"),
        ("machine", "identify", "measured.csv"),
    ],
)
def test_commands_of_the_machine_take_that_of_the_folder(
    folder: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    monkeypatch.setattr("verne_post.calibration.as_built.plan.CANDIDATES", 300)
    Path("measured.csv").write_text("rho1_mm\n", encoding="utf-8")
    Path("verne-post.toml").write_text('machine = "no such file.toml"\n', encoding="utf-8")
    answer = run(*words)
    assert answer.code == 2
    assert "no such file.toml" in answer.err
    assert "no such file.toml" not in run(*words, "--machine", "verne").err


def test_axis_check_takes_the_cycle_of_the_settings(folder: Path, run: Callable[..., Any]) -> None:
    """Files that are played at another cycle than they were made for move the machine at another speed."""
    Path("verne-post.toml").write_text("[options]\ncycle = 0.004\n", encoding="utf-8")
    assert run("machine", "axis-check", "--at", "600,600,600,0,0", "-o", "check").code == 0
    rows = next(Path("check").glob("*.csv")).read_text(encoding="utf-8").splitlines()
    assert [row.split(",")[0] for row in rows[1:4]] == ["0.000", "0.004", "0.008"]


def test_lengths_twice_in_a_set_up_are_refused_by_name(folder: Path, run: Callable[..., Any]) -> None:
    Path("l.csv").write_text("tool,length_mm\n1,50\n", encoding="utf-8")
    Path("part.nc.toml").write_text('tool_length = 80\ntool_lengths = "l.csv"\n', encoding="utf-8")
    answer = run("part.nc")
    assert answer.code == 2
    assert "part.nc.toml:1:1: VP503 error: tool_length and tool_lengths exclude each other" in answer.err


# --- files that a set-up or the settings file names --------------------------------------------------

#: Key of a set-up -> a file for it that nothing is wrong with.
NAMED_FILES = {
    "tool_table": "T1 P1 Z60\n",
    "tool_lengths": "tool,length_mm\n1,60\n",
    "measured_offset": "system,x_mm,y_mm,z_mm\nG54,0,0,0\n",
    "tool_shapes": "[tool.1.cutter]\ndiameter = 5\nlength = 20\n",
    "parameters": "5221 10\n",
}
SECRET = "TOKEN = 'abc123'\n"


@pytest.fixture
def job(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, job, beside which and below which the same files stand; outside there is a secret too."""
    work = folder / "job"
    (work / "below").mkdir(parents=True)
    (folder / "part.nc").rename(work / "part.nc")
    for place in (folder, work, work / "below"):
        for key, text in NAMED_FILES.items():
            (place / key).write_text(text)
    (folder / "secret").write_text(SECRET)
    (work / "link").symlink_to("../secret")
    (work / "up").symlink_to("..")
    (work / "round").symlink_to("below")
    monkeypatch.chdir(work)
    return work


def _places(job: Path, key: str) -> dict[str, bool]:
    """Names of a file for a key -> whether they lead to a file inside."""
    return {
        key: True,
        f"below/{key}": True,
        f"below/../{key}": True,
        f"round/{key}": True,
        f"../job/{key}": True,
        f"../{key}": False,
        str(job / key): False,
        str(job.parent / key): False,
        f"up/{key}": False,
        "link": False,
        "/dev/stdin": False,
        "../secret": False,
        "below/../../secret": False,
    }


@pytest.mark.parametrize("key", NAMED_FILES)
def test_files_of_a_set_up_lie_in_its_folder(job: Path, run: Callable[..., Any], key: str) -> None:
    """Else the error names file and key, and nothing is read; a set-up that the command line names may name any
    file.
    """
    for name, inside in _places(job, key).items():
        text = f"{key} = {json.dumps(name)}\n"
        Path("part.nc.toml").write_text(text)
        Path("verne-post.toml").unlink(missing_ok=True)
        own = run("check", "part.nc").out
        named = run("check", "part.nc", "--setup", "part.nc.toml").out
        Path("part.nc.toml").unlink()
        Path("verne-post.toml").write_text(f'[setup."*.nc"]\n{text}')
        answer = run("check", "part.nc")
        shared = answer.err + answer.out
        for said, where in ((own, f"VP503 error: {key} = "), (shared, f"VP503 error: setup.'*.nc'.{key} = ")):
            assert ("VP503" in said) == (not inside), (name, said)
            assert inside or f"{where}{name!r}: " in said
            assert "TOKEN" not in said
            assert "abc123" not in said
        assert "VP503" not in named


def test_files_of_the_settings_lie_in_their_folder(job: Path, run: Callable[..., Any]) -> None:
    """The machine and the baseline; settings that the command line names may name any file."""
    machine = (MACHINES / "verne.toml").read_text()
    baseline = '{"schema": 1, "known": {}}'
    for place in (job, job.parent, job / "below"):
        (place / "ours.toml").write_text(machine)
        (place / "known.json").write_text(baseline)
    for key, line, file in (("machine", "", "ours.toml"), ("check.baseline", "[check]\n", "known.json")):
        for name, inside in _places(job, file).items():
            Path("verne-post.toml").write_text(f"{line}{key.removeprefix('check.')} = {json.dumps(name)}\n")
            said = "".join(str(run("check", "part.nc")))
            assert (f"VP503 error: {key} = {name!r}: " in said.replace("\\'", "'")) == (not inside), (name, said)
            assert "TOKEN" not in said
            named = run("check", "part.nc", "--settings", "verne-post.toml")
            assert f"VP503 error: {key} = " not in named.err


def test_what_is_found_is_no_link_to_another_folder(job: Path, run: Callable[..., Any]) -> None:
    """A set-up, settings, a program of a folder that is searched: each is read where the command line names it."""
    Path("part.nc.toml").symlink_to("../secret")
    said = run("check", "part.nc").out
    assert "part.nc.toml: is a link that leads out of its folder; name it with --setup" in said
    assert "TOKEN" not in said
    Path("part.nc.toml").unlink()
    Path("part.nc.toml").symlink_to("below/s.toml")
    Path("below/s.toml").write_text("tool_length = 60\n")
    assert "set-up: from part.nc.toml" in run("check", "part.nc").out
    Path("part.nc.toml").unlink()
    Path("verne-post.toml").symlink_to("../secret")
    said = run("check", "part.nc").err
    assert "verne-post.toml: VP503 error: is a link that leads out of its folder; name it with --settings" in said
    assert "TOKEN" not in said
    Path("verne-post.toml").unlink()
    for name in (
        "part.nc.toml",
        "verne-post.toml",
    ):  # what is meant to hold, and is not there, does not go without a word
        Path(name).symlink_to("lost.toml")
        said = run("check", "part.nc", "--tool-length", 60)
        assert said.code == 2
        assert f"{name}: No such file or directory" in said.out + said.err
        Path(name).unlink()
    Path("below/s.nc").symlink_to("../../secret")
    for words in (("check", "below"), ("batch", "below", "-o", "out")):
        refused = run(*words)
        assert refused.code == 2
        assert "s.nc: is a link that leads out of below, which is searched" in refused.err
        assert "TOKEN" not in refused.err
    assert "VP0" in run("check", "below/s.nc").out


def test_deviations_of_a_machine_lie_in_its_folder(job: Path, run: Callable[..., Any]) -> None:
    text = (MACHINES / "verne.toml").read_text()
    for name in ("../secret", "link", "/etc/hostname"):
        Path("ours.toml").write_text(f'{text}\n[as_built]\nfile = "{name}"\n')
        said = run("machine", "validate", "ours.toml").err
        assert f"VP501 error: as_built.file = '{name}': " in said
        assert "TOKEN" not in said


def test_a_set_up_stands_for_its_program(folder: Path, run: Callable[..., Any]) -> None:
    """As a hook names what has changed: once, however it is named; a set-up without its program is told."""
    Path("part.nc.toml").write_text("tool_length = 80\n[wcs]\nG54 = [0, 0, 300]\n")
    named = run("check", "part.nc")
    assert "set-up: from part.nc.toml" in named.out
    assert run("check", "part.nc.toml") == run("check", "part.nc.toml", "part.nc") == named
    run("batch", "part.nc.toml", "-o", "out")
    assert Path("out/part.csv").exists()
    Path("part.nc").unlink()
    assert "part.nc: VP022 error: no such file\n" in run("check", "part.nc.toml").out


def test_a_program_that_is_not_there_is_not_read(folder: Path, run: Callable[..., Any]) -> None:
    told = run("check", "prt.nc")
    assert told.code == 2
    assert told.out == (
        "prt.nc: VP022 error: no such file; did you mean part.nc?\nprt.nc: not read: 1 error, 0 warnings\n"
    )
    assert "\n2 programs: 2 not read\n" in run("check", "prt.nc", "other.mpf").out
    batch = run("batch", "prt.nc", "part.nc", "-o", "out")
    assert batch.code == 2
    assert "1 not read" in batch.out
    assert "prt.nc: VP022 error: no such file; did you mean part.nc?" in batch.out + batch.err


def test_every_ending_of_a_language_is_looked_for_in_folders() -> None:
    """But `.spf`: a subprogram is read where it is called."""
    endings = {ending for dialect in DIALECTS.values() for ending in dialect.endings}
    assert endings - {".spf"} <= set(PROGRAMS)


def read_hook() -> dict[str, Any]:
    """What pre-commit reads of the hook."""
    yaml = pytest.importorskip("yaml")
    (hook,) = yaml.safe_load((Path(__file__).resolve().parents[2] / ".pre-commit-hooks.yaml").read_text("utf-8"))
    return dict(hook)


@pytest.mark.parametrize("name", [*(f"P{e.upper()}" for e in PROGRAMS), *(f"p{e}.toml" for e in PROGRAMS)])
def test_the_hook_is_told_of_programs_and_set_ups(name: str) -> None:
    assert re.search(read_hook()["files"], name)


def test_the_hook_is_told_of_what_programs_share_alone() -> None:
    pattern = read_hook()["files"]
    assert all(re.search(pattern, name) for name in ("tools.tbl", "verne-post.toml", "lengths.csv", "a.VAR", "w.json"))
    assert not any(re.search(pattern, name) for name in ("readme.md", "a.ncx", "pnc"))


@pytest.mark.skipif(not shutil.which("git"), reason="needs git")
def test_the_hook_reads_each_program_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]
) -> None:
    """A program and its set-up are one; a file that programs share stands for what git tracks, in one process.

    Ignored and untracked files do not refuse a commit; a tracked program does, whatever the case of its ending.
    """
    hook = read_hook()
    assert hook["require_serial"] and hook.get("pass_filenames", True)
    monkeypatch.chdir(tmp_path)

    def run_hook(*changed: str) -> Any:
        return run(*hook["entry"].split()[1:], "--tool-length", "80", "--wcs", "G54=0,0,60", "--limits-only", *changed)

    (tmp_path / "tools.tbl").write_text("T1 P1 Z80\n")
    done = run_hook("tools.tbl")
    assert done.code == 2 and "--changed tools.tbl: git cannot list the programs" in done.err
    subprocess.run(["git", "init", "-q"], check=True)
    assert run_hook("tools.tbl").code == 0  # no program is no mistake
    (tmp_path / ".gitignore").write_text("build\n")
    for name in ("build/numpy.h", "untracked.nc"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("#include <numpy.h>\n")
    (tmp_path / "sub").mkdir()
    part, other, setup = (tmp_path / "sub" / name for name in ("two words.NC", "b.nc", "two words.NC.toml"))
    legal = "G21 G90\nG0 X0 Y0 Z20 A0 C0\nG1 X5 F600\nM2\n"
    part.write_text(legal)
    other.write_text(legal.replace("X5 ", "X5000 "))
    setup.write_text("")
    subprocess.run(["git", "add", "."], check=True)
    subprocess.run(["git", "rm", "-q", "--cached", "untracked.nc"], check=True)
    done = run_hook("sub/two words.NC", "sub/two words.NC.toml")
    assert (done.code, done.out, done.err) == (0, "", ""), "of what passes nothing is said"
    part.write_text(legal.replace("G0", "T1 M6\nG0"))  # and no M3
    assert hook["verbose"], "pre-commit shows what a hook prints that passes"
    for changed in ("sub/two words.NC", "sub/two words.NC.toml"):
        done = run_hook(changed)
        assert (done.code, done.out.count("two words.NC:4: VP050 warning")) == (0, 1)
    assert "VP050" not in run_hook("tools.tbl").out
    part.write_text(legal.replace("X5 ", "X5000 "))
    done = run_hook("sub/two words.NC", "sub/two words.NC.toml")
    assert done.code == 1
    assert done.out.count("two words.NC:3: VP110 error") == 1 and "b.nc" not in done.out
    done = run_hook("sub/two words.NC", "tools.tbl")
    assert done.code == 1
    assert done.out.count("two words.NC:3: VP110 error") == done.out.count("b.nc:3: VP110 error") == 1
    other.unlink()  # from the disk, while git still has it
    assert "b.nc" not in run_hook("tools.tbl").out


@pytest.mark.parametrize(
    ("name", "calls"),
    [
        ("part.nc", {1: "T1 M6\nG43\n", 3: "T3 M6\nG43\n"}),
        ("part.h", {1: "TOOL CALL 1 Z S3000\n", 3: "TOOL CALL 3 Z S3000\n"}),
        ("part.mpf", {1: "T1 D1\nM6\n", 3: "T3 D1\nM6\n"}),
    ],
)
def test_a_tool_of_the_set_up_that_no_line_calls_is_told(
    run: Callable[..., Any], tmp_path: Path, name: str, calls: dict[int, str]
) -> None:
    """A deleted tool call was silent: the tool before went on with the work of the other."""
    heads = {"part.h": "BEGIN PGM P MM\n", "part.mpf": "G17 G90 G94 G710 G54\n", "part.nc": "G17 G90 G94 G21 G54\n"}
    move = "L A+0 C+0 FMAX M3\nL X+0 Y+0 Z+50 FMAX\nL Z+20 F300\nL Z+50 FMAX\n"
    if name != "part.h":
        move = "S3000 M3\nG0 A0 C0\nG0 X0 Y0 Z50\nG1 Z20 F300\nG0 Z50\n"
    end = "M30\nEND PGM P MM\n" if name == "part.h" else "M30\n"
    whole, program = heads[name] + calls[1] + move + calls[3] + move + end, tmp_path / name
    tools = "[tools]\n1 = {length = 80}\n3 = {length = 90, diameter = 6}\n"
    (tmp_path / f"{name}.toml").write_text(f"split_at_stops = true\n{tools}[wcs]\nG54 = [0, 0, 40]\n")
    program.write_text(whole)
    assert "VP041" not in run("check", program).out
    program.write_text(whole.replace(calls[3], ""))
    told = run("check", program, "--fail-level", "warning")
    said = "VP041 warning: tools.3 of the set-up: no line of the program calls it; write its call, or take it out"
    assert (told.code, said in told.out) == (1, True)
    # a set-up that is named may serve several programs
    shop = tmp_path / "shop.toml"
    shop.write_text((tmp_path / f"{name}.toml").read_text())
    assert "VP041" not in run("check", program, "--setup", shop).out
    if name == "part.nc":  # H and D put the sizes of other numbers in force
        program.write_text(whole.replace(calls[3], "").replace("G43\n", "G43 H3\n"))
        (tmp_path / "part.nc.toml").write_text(
            "[tools]\n1 = {length = 90}\n3 = {length = 90}\n[wcs]\nG54 = [0, 0, 40]\n"
        )
        assert "VP041" not in run("check", program).out
    # tools of the settings file are those of the shop
    (tmp_path / f"{name}.toml").write_text("[wcs]\nG54 = [0, 0, 40]\n")
    (tmp_path / "verne-post.toml").write_text(tools.replace("[tools]", '[setup."*".tools]'))
    program.write_text(whole.replace(calls[3], ""))
    assert "VP041" not in run("check", program, "--settings", tmp_path / "verne-post.toml").out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "[part.stock]\nmin = [-30, -30, 0]\nmax = [30, 30, 20]\n",
            ["part.stock: stock is a separate table; write [stock]"],
        ),
        ("[stock.wcs]\nG54 = [0, 0, 40]\n", ["stock.wcs: wcs is a separate table; write [wcs]"]),
        (
            "[part]\nunit = 'mm'\n[part.wcs]\nG54 = [0, 0, 40]\n",
            ["part.wcs: wcs is a separate table; write [wcs]", "part.nominal is missing", "part.system is missing"],
        ),
    ],
)
def test_a_table_inside_another_is_one_mistake(
    run: Callable[..., Any], folder: Path, text: str, said: list[str]
) -> None:
    """The keys that [part] lacks were told too, although there was no [part]."""
    Path("part.nc.toml").write_text(text)
    told = run("check", "part.nc", "--tool-length", 80)
    assert (told.code, told.out.count("VP503")) == (2, len(said))
    assert all(f"VP503 error: {one}\n" in told.out for one in said), told.out


@pytest.mark.parametrize(
    "command",
    [
        ["check", "part.nc"],
        ["check", "part.nc", "--output-format", "json"],
        ["check", "part.nc", "--output-format", "github"],
        ["check", "part.nc", "--output-format", "junit"],
        ["check", "part.nc", "--output-format", "markdown"],
        ["convert", "part.nc", "-o", "axes.csv"],
        ["explain", "part.nc:4"],
        ["fit", "part.nc"],
        ["report", "part.nc", "-o", "page.html"],
        ["batch", "part.nc", "-o", "out"],
    ],
    ids=" ".join,
)
def test_what_is_missing_is_filled_in_in_the_set_up_that_was_named(run, folder, command):
    Path("part.nc").write_text("G21 G90 G94 G54\nT1 M6\nS900 M3\nG0 X0 Y0 Z50 G43 H1\nG1 Z20 F900\nM2\n")
    Path("other.toml").write_text("wcs.G54 = [0, 0, 0]\n")

    def say(*words: str) -> str:
        answer, page = run(*command, *words), Path("page.html")
        return answer.out + answer.err + (page.read_text(encoding="utf-8") if page.exists() else "")

    assert "Fill in the length in part.nc.toml, which verne-post setup part.nc writes" in say()
    said = say("--setup", "other.toml")
    completes = "verne-post setup part.nc -o other.toml --setup other.toml"
    assert f"Fill in the length in other.toml, which {completes} writes" in said
    assert "part.nc.toml" not in said
    assert run(*completes.split()[1:]).code == 0
    assert "measure" in Path("other.toml").read_text()
    assert not Path("part.nc.toml").exists()


def test_a_page_of_findings_names_the_set_up_that_was_named(run, folder):
    Path("other.toml").write_text("tool_length = 80\n")
    Path("part.nc").write_text(f"G54 {PROGRAM}")
    assert run("report", "part.nc", "-o", "page.html", "--setup", "other.toml", "--air", "120").code in (0, 1)
    assert "Fill in wcs.G54 in other.toml" in Path("page.html").read_text(encoding="utf-8")


def test_a_tool_of_a_table_that_is_replaced_is_said_to_be_there(folder: Path, run: Callable[..., Any]) -> None:
    """Neither set-up nor tool table had it, said the message, and the settings file has it."""
    Path("part.nc").write_text("G21 G90\nT2 M6\nG43 H2\nG0 X0 Y0 Z50 A0 C0\nG1 Z20 F2000\nM2\n", "utf-8")
    Path("verne-post.toml").write_text('[setup."*.nc".tools.2]\nlength = 90\n', "utf-8")
    Path("part.nc.toml").write_text("[wcs]\nG54 = [0, 0, 40]\n[tools.1]\nlength = 100\n", "utf-8")
    said = "tool 2: verne-post.toml, setup.'*.nc': tools has it, but tools are not joined"
    assert said in run("check", "part.nc").out
    settings = verne_post.read_settings("verne-post.toml")
    (error,) = verne_post.check(Path("part.nc"), "verne", settings=settings, setup="beside").findings[:1]
    assert said in error.message


def test_a_named_tool_of_a_table_that_is_replaced_has_no_length(folder: Path, run: Callable[..., Any]) -> None:
    """Both tables count from one number: MILL of the settings had the length of DRILL in the set-up."""
    Path("part.mpf").write_text('G54 G17 G90 G71\nT="MILL" M6\nD1\nTRAORI\nG0 X0 Y0 Z50\nG1 X9 F600\nM30\n', "utf-8")
    Path("verne-post.toml").write_text('[setup."*.mpf".tools.MILL]\nlength = 99\n', "utf-8")
    Path("part.mpf.toml").write_text("[wcs]\nG54 = [0, 0, 40]\n[tools.DRILL]\nlength = 60\n", "utf-8")
    assert 'VP012 error: T="MILL": no tool of this name is given' in run("check", "part.mpf").out
    errors = verne_post.check(Path("part.mpf"), "verne", settings=Path("verne-post.toml")).errors
    assert [item.code for item in errors] == ["VP012"]


@pytest.mark.parametrize(
    ("pattern", "fits"),
    [
        ("roughing/*.nc", ["roughing/A.nc"]),
        ("roughing/**/*.nc", ["roughing/A.nc", "roughing/old/B.nc"]),
        ("**/*.nc", ["C.nc", "roughing/A.nc", "roughing/old/B.nc"]),
        ("roughing", ["roughing/A.nc", "roughing/old/B.nc"]),
        ("./roughing/*.nc", ["roughing/A.nc"]),
        ("?.nc", ["C.nc", "roughing/A.nc", "roughing/old/B.nc"]),  # a name, in any folder
        ("old/*.nc", []),
        ("roughng/*.nc", []),
    ],
)
def test_patterns_of_setups_have_the_rules_of_paths(
    pattern: str, fits: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]
) -> None:
    """A star crossed folders, two did not match none, and a pattern that fits nothing was silent."""
    monkeypatch.chdir(tmp_path)
    Path("roughing/old").mkdir(parents=True)
    names = ["C.nc", "roughing/A.nc", "roughing/old/B.nc"]
    for name in names:
        Path(name).write_text("G21 G90 G94 G54\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F900\nM2\n")
    Path("verne-post.toml").write_text(f'[setup."{pattern}"]\ntool_length = 80\nwcs.G54 = [0, 0, 20]\n')
    answer = run("check", *names, "--limits-only")
    told = [name for name in names if f"{name}: no pattern of [setup] in verne-post.toml fits" in answer.err]
    assert told == [name for name in names if name not in fits]
    assert [name for name in names if f"{name}: not refused" in answer.out] == fits
