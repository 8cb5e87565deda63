"""The Python API: what it takes, what it says of misuse, and that its page and its types are true."""

import ast
import dataclasses
import doctest
import inspect
import io
import json
import math
import os
import pickle
import pydoc
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post as vp
from verne_post import api
from verne_post.app.python_names import _ARGUMENTS, name_in_python
from verne_post.cli import arithmetic
from verne_post.gcode.program_error import FILL_IN_LENGTH, GIVE_PLACE
from verne_post.model import machine as machine_model
from verne_post.model import options
from verne_post.model.codes import CODES
from verne_post.model.findings import Findings

from .builders import load_maker

ROOT = Path(__file__).resolve().parents[1]
POCKET = ROOT / "gcode_samples" / "pocket_3axis.nc"
OPTIONS = vp.Options(tool_length=80, wcs={"G54": (-10, 15, 60)}, cycle=0.004)
SHORT = "G21 G90 F600\nG0 X0 Y0 Z20\nG1 X10\nM2\n"


def test_names_are_visible_and_only_they() -> None:
    assert sorted(vp.__all__) == dir(vp)
    for name in vp.__all__:
        assert getattr(vp, name) is not None
    for name in vp.__all__:
        thing = getattr(vp, name)
        assert name == "__version__" or inspect.getdoc(thing), name


def test_bytes_text_and_paths_are_the_same_program() -> None:
    text = POCKET.read_text("utf-8")
    rows = [vp.convert(source, "verne", OPTIONS).setpoints for source in (text, text.encode(), POCKET)]
    for one in rows:
        assert one is not None
        assert one.to_csv() == rows[0].to_csv()  # type: ignore[union-attr]


def test_what_is_not_ok_is_false() -> None:
    good = vp.convert(SHORT, "verne", OPTIONS)
    assert good
    refused = vp.check(SHORT.replace("X10", "X5000"), "verne", OPTIONS)
    assert not refused
    assert vp.Machined((), (), ())
    assert not vp.Machined((), (), refused.findings)
    assert good.setpoints is not None
    rows = good.setpoints.to_csv()
    assert vp.verify(rows, SHORT, "verne", OPTIONS)
    assert not vp.verify(rows, SHORT.replace("X10", "X9"), "verne", OPTIONS)
    for result in (good, refused):  # of several programs, and of a page, too
        row = api.BatchRow(Path("a.nc"), result)
        for thing in (row, vp.Batch((row, api.BatchRow(Path("b.nc"), good))), vp.Page("", result.findings)):
            assert (bool(thing), thing.ok) == (result.ok, result.ok)


def test_kernels_are_chosen_before_numpy_is_loaded() -> None:
    """In a process that has none of the variables; a second call, and one in a process that was started so, is fine."""
    chosen = arithmetic.choose_settings()
    plain = {name: value for name, value in os.environ.items() if name not in chosen}
    for text, told in (
        ("import verne_post as vp; vp.choose_kernels(); import numpy; vp.choose_kernels()", ""),
        ("import numpy, verne_post as vp; vp.choose_kernels()", "UsageError: choose_kernels: numpy is loaded already"),
    ):
        for variables in (plain, plain | chosen):
            done = subprocess.run([sys.executable, "-c", text], env=variables, capture_output=True, text=True)
            expected = told if variables is plain else ""
            assert (done.returncode == 0) == (not expected), done.stderr
            assert expected in done.stderr
    show = "import verne_post as vp; vp.choose_kernels(); import os; print({name: os.environ[name] for name in NAMES})"
    done = subprocess.run(
        [sys.executable, "-c", show.replace("NAMES", repr(list(chosen)))], env=plain, capture_output=True, text=True
    )
    assert done.stdout == f"{chosen}\n"


def test_the_csv_is_that_of_the_command(run: Any) -> None:
    answer = run("convert", POCKET, "--tool-length", 80, "--wcs", "G54=-10,15,60", "--cycle", 0.004)
    result = vp.convert(POCKET, "verne", OPTIONS)
    assert result.setpoints is not None
    assert result.setpoints.to_csv() == answer.out
    assert vp.verify(result.setpoints, POCKET, "verne", OPTIONS).ok
    assert vp.verify(answer.out, POCKET, "verne", OPTIONS).ok
    row = answer.out.splitlines()[500]
    first = row.split(",")[1]
    spoilt = answer.out.replace(row, row.replace(first, f"{float(first) + 0.1:.7f}"))
    assert not vp.verify(spoilt, POCKET, "verne", OPTIONS).ok


def test_a_path_brings_its_subprograms(tmp_path: Path) -> None:
    (tmp_path / "main.ngc").write_text("G21 G90 G0 X0 Y0 Z20\no<hop> call [7]\nM2\n")
    (tmp_path / "hop.ngc").write_text("o<hop> sub\nG1 X#1 F600\no<hop> endsub\n")
    assert vp.check(tmp_path / "main.ngc", "verne", vp.Options(tool_length=80)).ok
    assert not vp.check((tmp_path / "main.ngc").read_bytes(), "verne", vp.Options(tool_length=80)).ok


def test_the_mark_before_utf_8_means_nothing(tmp_path: Path) -> None:
    """Excel writes it before CSV files, editors of Windows before programs."""
    plain = vp.convert(SHORT, "verne", OPTIONS)
    assert plain.setpoints is not None
    rows = plain.setpoints.to_csv()
    (tmp_path / "part.nc").write_text(SHORT, encoding="utf-8-sig")
    for source in ("\ufeff" + SHORT, b"\xef\xbb\xbf" + SHORT.encode(), tmp_path / "part.nc"):
        assert vp.check(source, "verne", OPTIONS).ok
    assert vp.verify("\ufeff" + rows, SHORT, "verne", OPTIONS).ok


@pytest.fixture
def part(tmp_path: Path) -> Path:
    """A program with its set-up beside it, and what the set-up names."""
    path = tmp_path / "part.nc"
    path.write_text(SHORT.replace("\nG0", "\nT1 M6 S900 M3\nG43 H1\nG0"), encoding="utf-8")
    (tmp_path / "tools.tbl").write_text("T1 P1 Z66 D6\n", encoding="utf-8")
    (tmp_path / "part.nc.toml").write_text(
        "tool_length = 80\ntolerance = 0.02\n[wcs]\nG54 = [1, 2, 60]\nG55 = [3, 4, 61]\n"
        "[keep_out.vise]\nmin = [200, 200, 0]\nmax = [210, 210, 9]\n",
        encoding="utf-8",
    )
    return path


def test_a_path_brings_its_set_up_as_on_the_command_line(part: Path, run: Callable[..., Any]) -> None:
    answer = run(part, "-o", part.with_suffix(".csv"))
    assert answer.code == 0, answer.err
    result = vp.convert(part, "verne")
    assert result.setpoints is not None
    assert result.setpoints.to_csv() == part.with_suffix(".csv").read_text(encoding="utf-8")
    assert result.summary is not None
    taken = result.summary.options
    assert (taken.tool_length, taken.tolerance, taken.setup_source) == (80, 0.02, "part.nc.toml")
    assert [box.name for box in taken.keep_out] == ["vise"]
    assert vp.check(part, "verne").ok
    assert vp.verify(result.setpoints, part, "verne").ok
    assert not vp.verify(result.setpoints, part, "verne", vp.Options(tool_length=80), setup="none").ok
    assert "tool length 80 mm" in str(vp.explain(part, "verne", 5))
    assert vp.fit(part, "verne").before.place.x == 1.0


def test_options_of_the_caller_go_before_the_set_up(part: Path) -> None:
    def taken(options: vp.Options | None = None, **more: Any) -> vp.Options:
        result = vp.check(part, "verne", options, **more)
        assert result.summary is not None, result
        return result.summary.options

    box = vp.Box("vise", (300, 300, 0), (310, 310, 9))
    given = taken(vp.Options(tolerance=0.03, wcs={"G54": (5, 6, 62)}, keep_out=(box,)))
    assert (given.tool_length, given.tolerance, given.keep_out) == (80, 0.03, (box,))
    assert {system: offset.origin_mm for system, offset in given.wcs.items()} == {1: (5, 6, 62), 2: (3, 4, 61)}
    with_table = vp.Options(tools={1: vp.Tool(1, 1, (0, 0, 70, 0, 0, 0, 0, 0, 0))})
    assert taken(with_table).tool_length is None
    none = taken(vp.Options(tool_length=70, wcs={"G54": (0, 0, 60)}), setup="none")
    assert (none.tool_length, none.tolerance, none.setup_source, none.keep_out) == (70, None, "", ())
    other = part.with_name("other.toml")
    other.write_text('tool_table = "tools.tbl"\n[wcs]\nG54 = [0, 0, 60]\n', encoding="utf-8")
    tools = taken(setup=other).tools
    assert tools is not None
    assert tools[1].offset[2] == 66
    for_text = vp.check(part.read_text(encoding="utf-8"), "verne", setup=other).summary
    assert for_text is not None
    assert for_text.options.setup_source == "other.toml"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("tool_lenght = 80\n", "part.nc.toml, line 1: tool_lenght: this is no option"),
        ('tool_table = "none.tbl"\n', "part.nc.toml, line 1: tool_table = "),
        ('measured_offset = "wcs.csv"\n[wcs]\nG54 = [0, 0, 60]\n', "wcs.csv has this work offset too; give it once"),
    ],
)
def test_a_bad_set_up_makes_a_result(part: Path, text: str, said: str) -> None:
    (part.parent / "wcs.csv").write_text("system,x_mm,y_mm,z_mm\nG54,0,0,30\n", encoding="utf-8")
    Path(f"{part}.toml").write_text(text, encoding="utf-8")
    for result in (vp.convert(part, "verne"), vp.check(part, "verne")):
        (item,) = result.findings
        assert (item.code, result.exit_code) == ("VP503", 2)
        assert said in item.placed_message
    told = vp.explain(part, "verne", 3)
    assert told.findings == result.findings
    assert said.replace(", line 1", "") in told.text and told.text.startswith(f"{part}: VP503 error: ")
    with pytest.raises(vp.UsageError, match="'beside', 'none' or a pathlib"):
        vp.check(part, "verne", setup="nothing")  # type: ignore[arg-type]


def test_what_is_printed_is_what_the_commands_say(
    part: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(part.parent)
    source = Path("part.nc")
    said = run(source, "-o", "axes.csv").err
    result = vp.convert(source, "verne")
    assert f"{result.summary}\n" == name_in_python(said)
    assert repr(result.summary) == str(result.summary)
    passes = vp.verify(Path("axes.csv"), source, "verne")
    assert f"{passes}\n" == run("verify", "axes.csv", "--against", source).err
    moved = vp.verify(Path("axes.csv"), source, "verne", vp.Options(wcs={"G54": (1, 2, 61)}))
    wrong = run("verify", "axes.csv", "--against", source, "--wcs", "G54=1,2,61")
    assert wrong.code == 1
    assert f"{moved}\n" == wrong.err
    assert f"{vp.fit(source, 'verne')}\n" == name_in_python(run("fit", source).out)


TWO_TOOLS = "G21 G90 F600\nT1 M6\nG43 H1\nG0 X0 Y0 Z20\nG1 X10\nT2 M6\nG43 H2\nG1 X0\nM2\n"


@pytest.mark.parametrize(
    ("source", "given", "said"),
    [
        (TWO_TOOLS, {"tool_length": 80}, "tool_length is the length of one tool"),
        (TWO_TOOLS, {"tool_length": 80}, "use tools instead"),
        (SHORT, {"units": "drive", "tool_length": 80}, 'units="drive" needs'),
        (SHORT, {"stock": vp.OwnStock(), "tool_length": 80}, "stock=OwnStock(): the program defines no stock"),
        (SHORT, {"correct_axis": True, "tool_length": 80}, "correct_axis needs"),
        ("G21 G90\nG0 X0 Y0 Z20\nG1 X5 F600\nM2\n", {"slow_start": 0.001, "tool_length": 80}, "slow_start=0.001:"),
        (SHORT, {}, 'give wcs={"G54": (X, Y, Z)}'),
    ],
)
def test_messages_have_the_names_of_python(source: str, given: dict[str, Any], said: str) -> None:
    result = vp.convert(source, "verne", vp.Options(**given))
    messages = [item.message for item in result.findings]
    assert any(said in message for message in messages), messages
    assert said in repr(result) + str(result.summary)
    assert not [message for message in messages if "--" in message]


def test_errors_and_proposals_have_the_names_of_python() -> None:
    for line in (0, 6):
        told = vp.explain(TWO_TOOLS, "verne", line, vp.Options(tool_length=80))
        assert "tool_length is the length of one tool" in told.findings[0].message in told.text
        assert "--" not in told.text
    with pytest.raises(vp.InputError, match="tool_length is the length of one tool") as caught:
        vp.fit(TWO_TOOLS, "verne", vp.Options(tool_length=80))
    assert "--" not in str(caught.value)
    assert 'wcs={"G54": (' in str(vp.fit(SHORT, "verne", vp.Options(tool_length=80)))
    with pytest.raises(vp.UsageError, match=r"^air_along: table needs air, the height"):
        vp.Options(air_along="table")
    # the wrapper changes neither the signature nor what a result is
    assert str(inspect.signature(vp.convert)).startswith("(source: ")
    assert pickle.loads(pickle.dumps(vp.convert(SHORT, "verne", OPTIONS))).summary is not None


def test_a_tool_is_given_by_its_length() -> None:
    """Nine offsets are for tools that have them."""
    zeros = (0.0,) * 6
    meant = {1: vp.Tool(1, 1, (0.0, 0.0, 80.0, *zeros)), 5: vp.Tool(5, 5, (0.0, 0.0, 60.0, *zeros), 6.0)}
    assert vp.Options(tools={1: 80, 5: (60, 6)}).tools == meant
    assert vp.Options(tools={1: np.float64(80), 5: np.array([60, 6])}).tools == meant
    # the program gets the length
    one = SHORT.replace("G0 X0", "T1 M6\nG43 H1\nG0 X0")
    rows = [vp.convert(one, "verne", vp.Options(tools=tools)).setpoints for tools in (meant, {1: 80}, {1: 90})]
    first, same, other = (None if one is None else one.to_csv() for one in rows)
    assert first == same is not None
    assert other not in (first, None)


def test_a_tool_is_given_by_its_name(tmp_path: Path) -> None:
    """As [tools] of a set-up gives it; beside a set-up whose tools have names too, each name has its own length."""
    text = 'G54 G17 G90 G71\nT="MILL" M6\nD1\nTRAORI\nG0 X0 Y0 Z20\nG1 X10 F600\nM30\n'
    program = tmp_path / "part.mpf"
    program.write_text(text, encoding="utf-8")
    given = vp.Options(tools={"MILL": (112.5, 12), "5": 80, 3: 70}, wcs={"G54": (0, 0, 60)}, dialect="siemens")
    assert sorted(given.tools or {})[:2] == [3, 5]
    assert given.changed(tools={"MILL": 90}).control == given.control
    numbered = given.changed(control={"siemens": {"tools": {"MILL": 6}}}, tools={"MILL": 90})
    assert sorted(numbered.tools or {}) == [6]
    for one in (given, given.changed(air=0), given.changed(control={"siemens": {"start": "G71"}})):
        summary = vp.check(text, "verne", one).summary
        assert summary is not None
        assert summary.tools == (("MILL", 112.5),)
    Path(f"{program}.toml").write_text("[tools]\nMILL = { length = 70 }\n", encoding="utf-8")
    (finding,) = vp.check(program, "verne", vp.Options(tools={"DRILL": 60}, wcs=given.wcs)).findings
    assert (finding.code, "give it in tools" in finding.message, "set-up" in finding.message) == ("VP012", True, False)
    summary = vp.check(program, "verne", vp.Options(tools={"DRILL": 60, "MILL": 99}, wcs=given.wcs)).summary
    assert summary is not None
    assert summary.tools == (("MILL", 99.0),)
    Path(f"{program}.toml").write_text("[tools]\nDRILL = { length = 60 }\nMILL = { length = 70 }\n", encoding="utf-8")
    shapes = {"MILL": [vp.Cylinder("cutter", 10, 40)]}  # has the number that the set-up counts
    body = {"wcs": given.wcs, "stock": vp.Box("stock", (-50, -50, -20), (50, 50, 5))}
    without, told = (vp.check(program, "verne", vp.Options(tool_shapes=one, **body)) for one in ({}, shapes))
    assert ["the width of tool" in one.unchecked for one in (without, told)] == [True, False]


@pytest.mark.parametrize("name", ["T1", "t01"])
def test_a_tool_number_as_a_name_is_told_with_the_number(name: str) -> None:
    """As [tools] of a set-up does; Siemens calls a tool of this name by it."""
    given = vp.Options(tools={name: 80}, wcs={"G54": (0, 0, 60)})
    (finding,) = vp.check("G21 G90\nT1 M6\nG43 H1 G0 X0 Y0 Z50 A0 C0\nM2\n", options=given).errors
    assert finding.message == f'tool 1: there is no tool 1, and "{name}" is the name of one; write tools={{1: MM}}'
    siemens = f'G17 G90 G71 G54\nT="{name}" M6\nD1 G0 X0 Y0 Z50 A0 C0\nG1 X5 F600\nM30\n'
    assert vp.check(siemens, options=given)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: vp.Options(tools={"MILL": -80}), 'tool "MILL": the length -80 is negative'),
        (lambda: vp.Options(tools={"5": 80, 5: 80}), "there is a tool 5 already"),
        (
            lambda: vp.check(SHORT, tool_lenght=80),
            r"tool_lenght: an option of the program: .*Options\(tool_length=...\)",
        ),
        (lambda: vp.check(SHORT, machin="verne"), "machin: no such argument; did you mean machine?"),  # type: ignore[call-arg]
        (lambda: vp.Options(work_offsets={}), "work_offsets: .*did you mean wcs?"),
        (lambda: vp.Options(**{"from": "home"}), "from: .*did you mean approach?"),
        (lambda: vp.check(io.BytesIO(b"M2")), r"source: .*got BytesIO; pass its read\(\)"),  # type: ignore[arg-type]
        (lambda: vp.verify(vp.check(SHORT), SHORT), "setpoints: .*got Result; pass its setpoints"),  # type: ignore[arg-type]
        (lambda: vp.make_report(SHORT, versus=5), "versus: expected bytes, text or a path"),  # type: ignore[arg-type]
        (lambda: vp.batch(None), "programs: expected a path or several, got NoneType"),  # type: ignore[arg-type]
        (lambda: vp.check(SHORT, OPTIONS), "machine: got Options; pass it by name, as options=...$"),  # type: ignore[arg-type]
        (lambda: vp.explain(SHORT, 10), "machine: got 10; pass it by name, as line=10$"),  # type: ignore[arg-type]
        (lambda: vp.explain(SHORT, np.int64(10)), "machine: got 10; pass it by name, as line=10$"),  # type: ignore[arg-type]
        (lambda: vp.explain(SHORT, "verne", OPTIONS), "line: got Options; pass it by name, as options=...$"),  # type: ignore[arg-type]
        (lambda: OPTIONS.changed({"tolerence": 0.1}), "tolerence: .*did you mean tolerance?"),
        (lambda: OPTIONS.changed(0.1), r"0.1 has no name; write for example options.changed\(tool_length=80\)"),  # type: ignore[arg-type]
        (
            lambda: vp.load_machine("verne").forward(vp.convert(SHORT, "verne", OPTIONS).setpoints, 80),  # type: ignore[arg-type]
            r"^q: expected .* setpoints.values / \[column.factor .*\]; this Setpoints is",
        ),
        (lambda: vp.load_machine("verne").forward(np.zeros(5), "x"), "tool_length: expected mm; this str is no array"),  # type: ignore[arg-type]
        (
            lambda: vp.load_machine("verne").inverse(OPTIONS, (0, 0, 1), 80),
            "tip: expected places in mm; this Options is no",
        ),  # type: ignore[arg-type]
        (lambda: vp.batch([], folder=Path(__file__)), "folder: .*expected a pathlib.Path of a folder"),
        (lambda: vp.machined("", SHORT, nominal=b"", distance="1 mm"), "distance: '1 mm': expected mm, 0 or more"),  # type: ignore[arg-type]
        (lambda: vp.machined("", SHORT, nominal=b"", fixtures=[Path("a")]), "fixtures: .*'G54'"),  # type: ignore[list-item]
        (lambda: vp.machined("", SHORT, nominal=b"", system="G99"), "'G99' .* or G54.1P1 to G54.1P48, or 'table'$"),
        (lambda: vp.machined("", SHORT, nominal=b"", fixtures=[(b"", "G5")]), "system: 'G5' is not a work system"),
        (
            lambda: (verne := vp.load_machine("verne")).forward(
                verne.inverse(np.zeros((2, 3)), np.eye(3)[[2, 2]], 80), 80
            ),
            r"^q: inverse returns \(q, ok\); pass q$",
        ),
        (lambda: vp.Options(tools={" ": 80}), "' ' is neither the number nor the name of a tool"),
        (lambda: vp.Options(tool_shapes={"": [vp.Cylinder("cutter", 6)]}), "'' is neither the number nor the name"),
        (lambda: vp.Options(tool_shapes={"MILL": []}), 'tool_shapes: tool "MILL": expected a sequence of Cylinder'),
        (lambda: vp.Options(tools={"\N{SUPERSCRIPT TWO}": 80}), "is neither the number nor the name of a tool"),
        (lambda: vp.Tool(1, 1, 80), r"80: expected nine numbers.*tools=\{1: 80\}"),  # type: ignore[arg-type]
        (lambda: vp.Tool(1, 1, (0.0, 0.0, 80.0)), "expected nine numbers"),  # type: ignore[arg-type]
        (lambda: vp.Tool(1, 80), r"Tool: missing .*'offset'; expected Tool\(number, pocket, .*tools=\{1: 80\}.*, mm"),
        (lambda: vp.Tool(1, length=80), r"expected Tool\(.*tools=\{1: \(80, 10\)\}, mm"),
        (lambda: vp.WorkOffset(x=0), r"expected WorkOffset\(origin_mm=\(x, y, z\), turn_deg=0\)"),
        (lambda: vp.Box((0, 0, 0), (1, 1, 1)), r"expected Box\(name, low=.*, mm"),  # type: ignore[arg-type, call-arg]
        (lambda: vp.FixtureMesh("vise.stl"), r"expected FixtureMesh\(name, raw\).*read_bytes\(\)"),
        (lambda: vp.Options(80), "80 has no name; .*tool_length=80"),
        (lambda: vp.Options(tools={1: -80}), "tool 1: the length -80 is negative"),
        (lambda: vp.Options(tools={1: (80, 6, 3)}), "tool 1: expected .* a length and a diameter, got 3 numbers"),
        (lambda: vp.Options(tools={1: (80, -6)}), "tool 1: diameter -6 is negative"),
        (lambda: vp.Options(tools={1: "80"}), "tool 1: expected .*got '80'"),
        (lambda: vp.Options(tools={1: True}), "tool 1: expected .*True is not a finite number"),
    ],
)
def test_a_tool_that_is_none_is_refused_where_it_is_written(call: Callable[[], Any], said: str) -> None:
    with pytest.raises(vp.UsageError, match=said):
        call()


def test_columns_of_setpoints_are_found_by_name() -> None:
    rows = vp.convert(SHORT, "verne", OPTIONS).setpoints
    assert rows is not None
    for name, column in rows.to_dict().items():
        assert (rows[name] == column).all(), name
    for guess, said in (
        ("a", "did you mean a_deg"),
        ("rho1", "did you mean rho1_mm"),
        ("rho2_m", "did you mean rho2_mm"),
    ):
        with pytest.raises(KeyError, match=f"no column '{guess}'; {said}.*the columns are t_s, rho1_mm"):
            rows[guess]
    with pytest.raises(KeyError, match="no column 'time'; the columns are t_s"):
        rows["time"]
    with pytest.raises(TypeError, match=r"found by name, as .'rho1_mm'.; t, values and line"):
        rows[0]  # type: ignore[index]
    with pytest.raises(TypeError, match=r"not iterable, .*zip\(setpoints\.t, setpoints\.values"):
        list(rows)  # type: ignore[call-overload]


def test_the_number_of_an_edit_is_that_of_the_program() -> None:
    """Not what radians make of it."""
    options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 0)})
    for written in (101.0, -101.3):
        text = f"G21 G90\nG0 X0 Y0 Z20 A0 C0\nG1 F500 A{written}\nM2\n"
        (edit,) = vp.check(text, "verne", options).findings[0].edits
        assert edit.word == ("A", written)
        # towards the side that holds
        assert vp.check(text.replace(f"A{written}", f"A{edit.value}"), "verne", options).ok


def test_words_after_an_option_are_values_only_where_they_may_be() -> None:
    for said, meant in (
        ("give --wcs G54=0,0,0.", 'give wcs={"G54": (0, 0, 0)}.'),
        ("--tool-table FILE, or --tool-length MM where", "tools, or tool_length=MM where"),
        ("see --dialect fanuc", 'see dialect="fanuc"'),
        ("--smoothing takes its place", "smoothing takes its place"),
        ("use --decimals auto, or --accept-rounding", "use decimals=None, or accept_rounding"),
        ("(--maximise margin).", '(aim="margin").'),
        ("the --from and --to of", "the approach and departure of"),
        ("a--wcs b; --wcs-x --meta", "a--wcs b; --wcs-x --meta"),
        # settings of a control, wherever a file would have them
        ('[fanuc] a = "b" or "c" in verne-post.toml', 'control={"fanuc": {"a": "b"}} or "c"'),
        (
            '[fanuc] a = "b" (1 mm) or "c" (2 mm) in the settings file',
            'control={"fanuc": {"a": "b"}} (1 mm) or "c" (2 mm)',
        ),
        ('[fanuc] a = "b", "c" or "d" in the settings file, or I', 'control={"fanuc": {"a": "b"}}, "c" or "d", or I'),
        ('a = "b" or "c" under [aptcl] of the settings file', 'control={"aptcl": {"a": "b"}} or "c"'),
        ("F into start under [siemens] of the settings file", 'F into control={"siemens": {"start": VALUE}}'),
        ("under [aptcl.pitches] of the settings file", 'in control={"aptcl": {"pitches": {NAME: VALUE}}}'),
        ('[fanuc] a = "b"; c in the settings file', 'control={"fanuc": {"a": "b"}}; c in the settings file'),
        ('correct G54 or [stock]; system = "G54" under [stock]', 'correct G54 or stock; system = "G54" in stock'),
    ):
        assert name_in_python(said) == meant


def test_no_message_sends_python_to_a_file_of_settings() -> None:
    """Every text of a language that says where a setting belongs; what is computed in it stands for a control."""
    place = re.compile(r"\b(?:in|under \S+ of) (?:verne-post\.toml|the settings file)")
    for path in (ROOT / "verne_post" / "gcode").rglob("*.py"):
        text = path.read_text("utf-8")
        nodes = list(ast.walk(ast.parse(text))) if "settings file" in text or "verne-post.toml" in text else []
        inside = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
        inside |= {id(node.value) for node in nodes if isinstance(node, ast.Expr)}  # docstrings
        for node in nodes:
            parts = node.values if isinstance(node, ast.JoinedStr) else [node] if id(node) not in inside else []
            said = "".join(str(part.value) if isinstance(part, ast.Constant) else "aptcl" for part in parts)
            assert not (place.search(said) and place.search(name_in_python(said))), said


#: Options of commands that the Python API has no argument for: it does not do what they do.
OF_COMMANDS = {
    "--meta",
    "--settings",
    "--columns",
    "--stock-left",
    "--stock-from",
    "--machine",
    "--events",
    "--csv",
    "--ignore",
}


def test_every_option_in_a_message_has_a_name_in_python() -> None:
    """Messages of what the API runs; those of the command line, of calibration and of imports are read there alone."""
    unknown = set()
    for folder in ("gcode", "toolpath", "kinematics", "trajectory", "verification", "part", "app"):
        for path in (ROOT / "verne_post" / folder).rglob("*.py"):
            tree = ast.parse(path.read_text("utf-8"))
            written = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}  # docstrings
            for node in ast.walk(tree):
                if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in written:
                    flags = re.findall(r"(?<![\w-])--[a-z][a-z-]*", name_in_python(node.value))
                    unknown |= {(path.name, flag) for flag in flags if flag not in OF_COMMANDS}
    unknown -= {("python_names.py", flag) for flag in _ARGUMENTS}
    assert not unknown


def test_an_option_that_is_given_as_an_argument_is_told() -> None:
    with pytest.raises(vp.UsageError, match=r"^tool_length: .*pass options=Options\(tool_length=\.\.\.\)$"):
        vp.check(POCKET, "verne", tool_length=80.0)
    with pytest.raises(vp.UsageError, match=r"^qqq: no such argument; the arguments are source, machine, "):
        vp.check(POCKET, "verne", qqq=80.0)


def test_a_name_of_a_file_is_not_taken_for_a_program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(POCKET.parent)
    with pytest.raises(vp.UsageError, match=r"pathlib\.Path\('pocket_3axis\.nc'\)"):
        vp.convert("pocket_3axis.nc", "verne", OPTIONS)
    for absent in ("absent.nc", "C:\\parts\\part.h", "../parts/1.ngc"):
        with pytest.raises(vp.UsageError, match=f"{absent!r} is taken as text; pass pathlib.Path".replace("\\", r"\\")):
            vp.check(absent, "verne", OPTIONS)
    with pytest.raises(vp.UsageError, match=r"pathlib\.Path\('axes\.csv'\)"):
        vp.verify("axes.csv", SHORT, "verne", OPTIONS)


@pytest.mark.parametrize("text", ["G1X5.F100", "(part.nc)", ";part.nc", "CALL PGM part.h", "M2"])
def test_a_program_of_one_line_is_no_name_of_a_file(text: str) -> None:
    assert not vp.check(text, "verne", OPTIONS).ok


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: vp.convert(5, "verne"), "source"),  # type: ignore[arg-type]
        (lambda: vp.convert(SHORT, 5), "machine"),  # type: ignore[arg-type]
        (lambda: vp.convert(SHORT, "verne", {"tolerance": 1}), "options"),  # type: ignore[arg-type]
        (lambda: vp.convert(SHORT, "verne", None, "rows"), "sink"),  # type: ignore[arg-type]
        (lambda: vp.check(SHORT, "verne", None, 3), "progress"),  # type: ignore[arg-type]
        (lambda: vp.explain(SHORT, "verne", "3"), "line"),  # type: ignore[arg-type]
        (lambda: vp.explain(SHORT, "verne", -1, OPTIONS), "line"),
        (lambda: vp.explain(SHORT, "verne", 99, vp.Options(tool_length=80)), "line"),
        (lambda: vp.fit(SHORT, "verne", free="xq"), "free"),
        (lambda: vp.fit(SHORT, "verne", free=5), "free"),  # type: ignore[arg-type]
        (lambda: vp.fit(SHORT, "verne", ranges={"x": (math.nan, 1)}), "ranges"),
        (lambda: vp.fit(SHORT, "verne", ranges={"x": (2, 1)}), "ranges"),
        (lambda: vp.fit(SHORT, "verne", free="xy", ranges={"z": (1, 2)}), "ranges"),
        (lambda: vp.fit(SHORT, "verne", ranges=[("x", 1, 2)]), "ranges"),  # type: ignore[arg-type]
        (lambda: vp.convert(Path("no such file"), "verne"), "source"),
        (lambda: vp.convert(Path("a\0b"), "verne"), "source"),
        (lambda: vp.convert("G1 \ud800", "verne"), "source"),
        (lambda: vp.load_machine(None), "machine"),  # type: ignore[arg-type]
        (lambda: vp.load_machine(b""), "machine"),  # type: ignore[arg-type]
        (lambda: vp.read_moves(5), "source"),  # type: ignore[arg-type]
        (lambda: vp.load_machine().changed({1: 2}), "values"),  # type: ignore[dict-item]
        (lambda: vp.load_machine().changed(rho_jerk=1), "rho_jerk"),
        (lambda: dataclasses.replace(vp.load_machine(), cycle=0.004).changed({}), "machine"),
        (lambda: dataclasses.replace(vp.load_machine(), module=None).changed({}), "machine"),
        (lambda: vp.verify(3, SHORT, "verne"), "setpoints"),  # type: ignore[arg-type]
        (lambda: vp.work_offsets(G60=(1, 2, 3)), "wcs"),
        (lambda: setattr(OPTIONS, "air", 3.0), "air"),
    ],
)
def test_misuse_raises_one_documented_error(call: Any, name: str) -> None:
    with pytest.raises(vp.UsageError) as caught:
        call()
    assert caught.value.option == name
    assert len(caught.value.reason) > 10


def test_two_lengths_of_one_tool_are_refused() -> None:
    given = vp.Options(tools={1: 60}, tool_length=70, wcs={"G54": (0, 0, 60)})
    with pytest.raises(
        vp.UsageError, match="70 mm for all tools, but tools gives 60 mm; give one of the two"
    ) as caught:
        vp.check(SHORT, "verne", given)
    assert caught.value.option == "tool_length"
    assert vp.check(SHORT, "verne", given.changed(tool_length=60)).exit_code in (0, 1)


def test_rows_that_are_none_are_told() -> None:
    with pytest.raises(vp.UsageError, match="None: a result has setpoints where convert made them"):
        vp.verify(None, SHORT, "verne")  # type: ignore[arg-type]
    with pytest.raises(vp.UsageError, match="expected Setpoints, a list of them, bytes, text or a path, got int"):
        vp.verify(3, SHORT, "verne")  # type: ignore[arg-type]


def test_a_machine_that_does_not_exist_is_an_input_error() -> None:
    for name in ("no such machine", "a\0b"):
        with pytest.raises(vp.InputError):
            vp.convert(SHORT, name)


def test_a_changed_machine_is_validated_and_has_another_hash() -> None:
    machine = vp.load_machine("verne")
    half = machine.changed({"limits.a_jerk": 5000, "limits.rho_jerk": np.array([1e4, 2e4, 3e4])})
    assert half.scale_limits().jerk.tolist() == [1e4, 2e4, 3e4, 5000.0, 20000.0]
    assert half.provenance["changed"] == "limits.a_jerk = 5000, limits.rho_jerk = [10000.0, 20000.0, 30000.0]"
    assert half.sha256 != machine.sha256
    result = vp.convert(SHORT, half, OPTIONS)
    assert "changed not as in the machine file: limits.a_jerk = 5000, limits" in " ".join(str(result.summary).split())
    again = machine.changed({"limits.rho_jerk": (1e4, 2e4, 3e4)}).changed({"limits.a_jerk": 5000.0})
    assert again.sha256 == pickle.loads(pickle.dumps(half)).changed({}).sha256 == half.sha256
    back = half.changed({"limits.a_jerk": 10000, "limits.rho_jerk": 100000})
    assert (back.sha256, back.provenance) == (machine.sha256, machine.provenance)
    assert "jerk of a: " in machine.changed({"limits.a_jerk": None}).unlimited
    # the last word counts, be it a table or a key in it; what a table replaces is no change any longer
    table = {**tomllib.loads((ROOT / "machine_configs" / "verne.toml").read_text("utf-8"))["limits"], "rho_jerk": 5e4}
    key_in_table = machine.changed({"limits": table}).changed({"limits.rho_jerk": 2e4})
    table_again = key_in_table.changed({"limits": {**table, "rho_jerk": 8e4}})
    assert [one.scale_limits().jerk[0] for one in (key_in_table, table_again)] == [2e4, 8e4]
    assert table_again.sha256 == machine.changed({"limits": {**table, "rho_jerk": 8e4}}).sha256
    # keys that the file may have, and does not
    absent = dict.fromkeys(("drives.rho1.unit", "vibration.modes", "rods.diameter_mm"))
    assert machine.changed(absent).sha256 == machine.sha256
    for key, value, said in (
        ("limits.a_jrk", 1, "did you mean limits.a_jerk?"),
        ("limits.rho_jrk", None, "limits.rho_jrk is not a key of this machine file; did you mean limits.rho_jerk?"),
        ("clearance.minimum_m", None, "did you mean clearance.minimum_mm?"),
        ("rho_jerk", 1, "rho_jerk is not a key of this machine file; did you mean limits.rho_jerk?"),
        ("a_velocity", 1, "did you mean limits.a_velocity?"),
        ("cycle_s", 0.002, "did you mean control.cycle_s?"),
        ("joints.a.jerk", 1, "did you mean limits.a_jerk?"),
        ("limits.rho_travel", 1, "the keys of limits are a_deg, c_deg, "),
        ("foo", 1, "its keys and tables are schema, name, kind, "),
        ("drives.rho1.unt", 1, "did you mean unit?"),  # a table that the file may have, and does not
        ("limits", {"rho_jerk": 1}, 'machine.changed({"limits.rho_jerk": 1}) changes one key'),
        ("vibration", {"shaper": "zv"}, "vibration.modes is missing"),  # of a table that the file has not
        ("limits.a_jerk", -1, "limits.a_jerk = -1: expected a number: above 0"),
        ("name.first", "x", "name.first: name is no table"),
        ("as_built.file", "other.toml", "'other.toml' is not the file that was loaded"),
    ):
        with pytest.raises(vp.InputError, match=re.escape(said)) as caught:
            machine.changed({key: value})
        assert len(caught.value.findings) == 1
    chain = vp.load_machine("ac_trunnion")
    for keys, said in (
        (("limits.x_jerk", "limits.y_jerk"), "mean joints.x.jerk?; .* mean joints.y.jerk?"),
        (("limits.jerk",), "there are joints.x.jerk, joints.y.jerk, joints.z.jerk, joints.a.jerk, joints.c.jerk$"),
    ):
        with pytest.raises(vp.InputError, match=said.replace("?", "[?]")):
            chain.changed(dict.fromkeys(keys, 1))


def test_replaced_numbers_give_a_machine_another_hash() -> None:
    machine = vp.load_machine("verne")
    limits = dataclasses.replace(machine.limits, jerk=machine.limits.jerk / 2)
    for given in ({"limits": limits}, {"cycle": 0.004}, {"name": "other"}):
        assert dataclasses.replace(machine, **given).sha256 != machine.sha256
        assert dataclasses.replace(machine, **given).changes == "numbers replaced in Python"
    other = vp.load_machine("verne_by_rods")
    for name in ("module", "five_axis", "coordinates"):
        replaced = dataclasses.replace(machine, **{name: getattr(other, name)})
        assert replaced.sha256 != machine.sha256
        assert replaced.changes == "kinematics or bodies replaced in Python"
    assert dataclasses.replace(machine, limits=machine.limits).sha256 == machine.sha256
    assert not pickle.loads(pickle.dumps(machine)).changes
    assert not machine.changes


def test_moves_are_those_that_the_command_prints(part: Path, run: Callable[..., Any]) -> None:
    """With and without a machine; the set-up beside the program gives the tools."""
    for machine in (None, "verne"):
        answer = run("dump", "moves", str(part), *(["--machine", machine] if machine else []))
        assert [json.loads(line) for line in answer.out.splitlines()] == list(vp.read_moves(part, machine))
    moves = vp.read_moves(SHORT)
    assert list(moves) == list(vp.read_moves(SHORT.encode())) == [moves[k] for k in range(len(moves))]
    assert repr(moves) == "3 moves and events: 1 rapid, 1 feed, 1 end; 0 findings"
    with pytest.raises(vp.InputError, match="X appears twice in the block"):
        vp.read_moves("G21 G90\nG0 X1 X2\nM2\n")


def test_an_error_of_a_program_names_its_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the file where one was given, in another process too; a called file stands after the line of its call."""
    monkeypatch.chdir(tmp_path)
    Path("err.nc").write_text("G21 G90\nG0 X0\nG1 X\nM2\n", "utf-8")
    Path("main.nc").write_text("G21 G90\nM98 P1000\nM30\n", "utf-8")
    Path("O1000.nc").write_text("O1000\nG1 X\nM99\n", "utf-8")
    for source, place in (
        (Path("err.nc"), "err.nc, line 3"),
        (Path("err.nc").resolve(), "err.nc, line 3"),
        (Path("err.nc").read_text("utf-8"), "line 3"),
        (Path("main.nc"), "main.nc, line 2: O1000.nc, line 2"),
    ):
        for read in (vp.read_moves, vp.fit, lambda one: vp.verify(b"", source=one)):
            with pytest.raises(vp.InputError) as caught:
                read(source)
            for error in (caught.value, pickle.loads(pickle.dumps(caught.value))):
                assert str(error) == f"{place}: X needs a number, found the end of the line"


def test_bad_programs_are_results() -> None:
    for source, verdict in (
        ("G1 X", "refused: unusable program"),
        ("G21 G90\nG0 X0 Y0 Z20 A0 C0\nZ700\nM2\n", "refused: violates limits"),
    ):
        result = vp.convert(source, "verne", vp.Options(tool_length=80))
        assert (result.ok, result.setpoints) == (False, None)
        assert result.verdict == verdict
        assert result.findings[0].code in repr(result)
        assert result.findings[0].code in result._repr_html_()


def test_results_print_as_tables() -> None:
    result = vp.convert(POCKET, "verne", OPTIONS)
    assert "can run" in repr(result)
    for text in (str(result), repr(result), result._repr_html_(), repr(api.Batch((api.BatchRow(Path("a"), result),)))):
        assert re.search("NOT CHECKED.{1,60}contact with fixtures", text)
    assert result.setpoints is not None
    lines = repr(result.setpoints).splitlines()
    assert lines[0].split()[0] == "t_s"
    assert lines[-1] == f"{len(result.setpoints)} rows"
    html = result.setpoints._repr_html_()
    assert html.startswith("<table><thead><tr><th>t_s</th>")
    assert f'<td style="text-align: right">{result.setpoints.values[0, 0]:.6g}</td>' in html
    refused = vp.check(ROOT / "gcode_samples" / "violates_slider_travel.nc", "verne")
    for text in (repr(refused), refused._repr_html_()):
        assert "within limits if the part is moved by 0, 0, -22.9 mm" in text
    assert '<td style="text-align: right">8</td>' in refused._repr_html_()
    explained = vp.explain(ROOT / "gcode_samples" / "violates_slider_travel.nc", "verne", 8)
    assert repr(explained) == str(explained) == explained.text
    # what a program says makes no markup
    assert "<b>" not in vp.check("G1 <b>\n", "verne")._repr_html_()
    shown = explained._repr_html_()
    assert shown.startswith("<p><strong>line 8: ")
    assert '<td style="text-align: left">in force</td><td style="text-align: left">G' in shown
    assert "<pre>" not in shown
    for one in (result.summary, vp.verify(result.setpoints, POCKET, "verne", OPTIONS), *refused.findings):
        assert re.match("<(pre|table)>", one._repr_html_())  # type: ignore[union-attr]
    for public in ("Explanation", "Finding", "Machine", "Machined", "Result", "Setpoints", "Summary", "Verification"):
        assert hasattr(getattr(vp, public), "_repr_html_"), public


def test_a_printed_result_is_a_few_lines(part: Path) -> None:
    good = vp.convert(part, "verne", vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)}))
    assert good.summary is not None
    assert good.summary.time_s == good.summary.cycle_time > 0
    first, *rest = str(good).splitlines()
    assert first == f"{part}: can run on VERNE, {good.summary.time_s:.3f} s"
    assert len(rest) == 1 + len(good.findings) < 3
    source = "G21 G90\nG0 X0 Y0 Z20 A0 C0\nG1 X\nX1O\nG999\nG2 X5\nM2\n"
    bad = vp.check(source, "verne", vp.Options(tool_length=80))
    assert len(bad.findings) > 3
    first, *shown, last = (line for line in str(bad).splitlines() if not line.startswith("    = "))
    assert first == "refused: unusable program on VERNE"
    error = bad.findings[0]
    assert shown[0] == f"line {error.line}: {error.code} error: {error.message}"
    assert len(shown) == 3
    assert last.startswith(f"and {len(bad.causes) - 3} more cause")


def test_a_result_has_the_causes_that_the_commands_print() -> None:
    """And remedies in the words of Python, none of which says that nothing was found."""
    source = "G20 G90 G94\nG0 X0 Y0 Z3 A0 C0\nG1 X1 Z-3000 F60\nM2\n"
    bad = vp.check(source, "verne", vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)}))
    counted = [one for cause in bad.causes for one in (cause.first, *cause.others)]
    assert len(counted) == len(bad.findings) > len(bad.causes)
    first = bad.causes[0]
    helps = [f"also {first.describe_others()}", *(f"tried: {one}" for one in first.first.remedies)]
    assert f"{first}".splitlines() == [str(first.first), *(f"    = {one}" for one in helps)]
    assert str(first) in str(bad)
    assert not [text for one in bad.findings for text in one.remedies if "was found" in text]
    said = vp.check("G21 G90\nG0 X0 Y0 Z20 A0 C0\nG1 Z-300 F90\nM2\n", "verne", vp.Options(tool_length=80)).errors
    assert {one.remedy for one in said if one.code == "VP210"} == {"Raise the work offset (wcs), or use a longer tool."}


def test_options_print_what_is_not_the_default() -> None:
    assert repr(vp.Options()) == "Options()"
    options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)}, tolerance=0.02)
    assert repr(options).startswith("Options(tool_length=80.0, wcs={1: WorkOffset(origin_mm=(0.0, 0.0, 60.0)")
    assert repr(options).endswith("tolerance=0.02)")
    assert eval(repr(options), {"Options": vp.Options, "WorkOffset": vp.WorkOffset}) == options


def test_a_result_names_program_and_machine_and_says_why_it_has_no_setpoints(part: Path) -> None:
    options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)})
    made = vp.convert(part, "verne", options)
    assert (made.program, made.machine) == (str(part), "VERNE")
    assert "none" not in repr(made)
    assert vp.convert(SHORT, "verne", options).program == ""
    bad = vp.convert(part, "verne", vp.Options(tool_length=80, wcs={"G54": (0, 0, 2000)}))
    taken = vp.convert(part, "verne", options, lambda _block: None)
    for result, why in (
        (bad, "the program is refused, see the findings"),
        (vp.check(part, "verne", options), "a check makes none, convert does"),
        (vp.check(part, "verne", options, limits_only=True), "a check makes none, convert does"),
        (taken, "a sink or files took the rows"),
        (vp.batch([part], "verne", options, part.with_name("out")).programs[0].result, "a sink or files took the rows"),
    ):
        assert result.setpoints is None
        for text in (repr(result), result._repr_html_()):
            assert f"none: {why}" in text
            assert str(part) in text
            assert "VERNE" in text


def test_an_assertion_of_pytest_shows_the_first_finding() -> None:
    saferepr = pytest.importorskip("_pytest._io.saferepr").saferepr  # what `assert result.ok` prints
    for source in ("G21 G90\nG0 X0 Y0 Z20 A0 C0\nZ700\nX5\nG1 A99 F900\nM2\n", "G1 X\n"):
        result = vp.check(source, "verne", vp.Options(tool_length=80))
        shown = saferepr(result)
        first = next(one.first for one in result.causes if one.first.severity == "error")
        assert f"refused: {first.code} in line {first.line}: {first.message}"[:100] in shown


def test_a_machine_prints_its_limits_in_the_units_and_senses_of_its_rows(tmp_path: Path) -> None:
    path = tmp_path / "<b>.toml"
    text = (ROOT / "machine_configs" / "verne.toml").read_text("utf-8")
    text = text.replace('a_positive = "workpiece"', 'a_positive = "tool"').replace("a_deg = [-95.0", "a_deg = [-30.0")
    path.write_text(text.replace('name = "VERNE"', 'name = "<b>"'), "utf-8")
    machine = vp.load_machine(path)
    lines = repr(machine).splitlines()
    assert lines[0].startswith("<b>, kind verne; assumed, not measured: spindle, table")
    assert lines[2].split() == ["rho1", "mm", "50", "1250", "833", "5000", "100000"]
    assert lines[5].split() == ["a", "deg", "-30", "95", "90", "500", "10000"]
    assert lines[6].split()[2:4] == ["-inf", "inf"]
    scaled = machine.scale_limits()  # the travel of a turns round with its sense, rates have no sign
    assert (scaled.lower[3], scaled.upper[3]) == pytest.approx((-30, 95))
    assert machine.limits.lower[3] == pytest.approx(math.radians(-95))
    assert scaled.jerk == pytest.approx([1e5, 1e5, 1e5, 1e4, 2e4])
    assert '<td style="text-align: right">1250</td>' in machine._repr_html_()
    assert "<b>" not in machine._repr_html_()


def test_rows_are_written_to_a_file(tmp_path: Path) -> None:
    rows = vp.convert(POCKET, "verne", OPTIONS).setpoints
    assert rows is not None
    rows.to_csv(tmp_path / "axes.csv")
    assert (tmp_path / "axes.csv").read_bytes().decode() == rows.to_csv()
    assert vp.verify(tmp_path / "axes.csv", POCKET, "verne", OPTIONS).ok


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_data_frames(library: str) -> None:
    pytest.importorskip(library)
    rows = vp.convert(POCKET, "verne", OPTIONS).setpoints
    assert rows is not None
    frame = getattr(rows, f"to_{library}")()
    assert list(frame.columns) == list(rows.columns)
    np.testing.assert_array_equal(np.asarray(frame["rho1_mm"]), rows.values[:, 0])


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_library_of_data_frames_that_is_not_installed_is_named(library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, library, None)  # as where it is not installed
    rows = vp.convert(POCKET, "verne", OPTIONS).setpoints
    with pytest.raises(ModuleNotFoundError, match=f"install it with: pip install '{library}>="):
        getattr(rows, f"to_{library}")()


SETTINGS = """machine = "verne"
[options]
tool_length = 70
tolerance = 0.05
[remap]
M150 = "event"
[keep_out.clamp]
min = [300, 300, 0]
max = [310, 310, 9]
[setup."part*".wcs]
G55 = [9, 9, 61]
G56 = [7, 7, 60]
"""


def test_settings_hold_below_the_set_up_as_on_the_command_line(part: Path, run: Callable[..., Any]) -> None:
    file = part.with_name("own.toml")
    file.write_text(SETTINGS, "utf-8")
    answer = run(part, "-o", part.with_suffix(".csv"), "--settings", file, "--tolerance", "0.03")
    assert answer.code == 0, answer.err
    settings = vp.read_settings(file)
    for given in (settings, file):
        result = vp.convert(part, settings.machine, vp.Options(tolerance=0.03), settings=given)
        assert result.setpoints is not None, result
        assert result.setpoints.to_csv() == part.with_suffix(".csv").read_text(encoding="utf-8")
    assert result.summary is not None
    taken = result.summary.options
    assert (taken.tool_length, taken.tolerance, dict(taken.remap)) == (80, 0.03, {"M150": "event"})
    assert [box.name for box in taken.keep_out] == ["clamp", "vise"]
    assert {system: offset.origin_mm[0] for system, offset in taken.wcs.items()} == {1: 1, 2: 3, 3: 7}
    assert taken.setup_source == f"{settings.shown}, setup.'part*', part.nc.toml, overridden by tolerance"
    shown = taken.setup_source.replace("tolerance", "--tolerance")
    assert "".join(shown.split()) in "".join(answer.err.split())  # the summary breaks lines
    assert vp.check(part, "verne", setup="none", settings=settings).summary.options.tool_length == 70  # type: ignore[union-attr]
    assert "clamp" in repr(settings)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: vp.read_settings(3), "path: expected the name of a file, got int"),  # type: ignore[arg-type]
        (lambda: vp.check(SHORT, "verne", settings="x.toml"), "settings: expected Settings or a pathlib.Path, got str"),
        (lambda: vp.batch(__file__, "verne"), f"programs: expected a path or several, as Path('{__file__}')"),  # type: ignore[arg-type]
        (lambda: vp.batch("p", "verne"), "programs: p: no such file or folder; expected a path or several"),  # type: ignore[arg-type]
        (lambda: vp.batch(Path("missing"), "verne"), "programs: missing: no such file or folder; expected a path or"),
        (lambda: vp.batch([], "verne"), "programs: there is none; the list is empty, or a pattern fits no file"),
        (lambda: vp.batch(["a.nc"], "verne"), "programs: expected paths, got str: pass pathlib.Path('a.nc')"),  # type: ignore[list-item]
    ],
)
def test_settings_and_batches_that_are_none(call: Callable[[], Any], said: str) -> None:
    with pytest.raises(vp.UsageError, match=re.escape(said)):
        call()


def test_wrong_settings_are_told_one_by_one(tmp_path: Path) -> None:
    (tmp_path / "verne-post.toml").write_text("[options]\ntolerence = 1\n[remap]\nM3 = 'event'\n", "utf-8")
    with pytest.raises(vp.InputError) as caught:
        vp.read_settings(tmp_path / "verne-post.toml")
    assert [one.code for one in caught.value.findings] == ["VP503", "VP503"]


def test_numbers_of_numpy_are_numbers_of_tools_and_systems() -> None:
    one, parts = np.int64(1), [vp.Cylinder("cutter", 6, 20)]
    for key in (1, one):
        tool = vp.Tool(key, key, (0, 0, 80, 0, 0, 0, 0, 0, 0))
        given = {"wcs": {key: (0, 0, 60)}, "tool_shapes": {key: parts}}
        made = [vp.Options(tools={key: length}, **given) for length in (80, tool)]  # type: ignore[arg-type]
        assert (
            repr(made[0])
            == repr(made[1])
            == repr(vp.Options(tools={1: 80}, wcs={1: (0, 0, 60)}, tool_shapes={1: parts}))
        )  # type: ignore[arg-type, dict-item]
    with pytest.raises(vp.UsageError, match="neither the number nor the name"):
        vp.Options(tools={np.float64(1): 80})  # type: ignore[dict-item]


def test_options_change_by_a_mapping_as_machines_do() -> None:
    assert OPTIONS.changed({"air": 5, "tolerance": 1}, tolerance=0.1) == OPTIONS.changed(air=5, tolerance=0.1)


def test_a_batch_takes_one_file(part: Path) -> None:
    (row,) = vp.batch(part, "verne", OPTIONS)
    assert (row.program, row.ok) == (part, True)


def test_a_batch_writes_what_can_run_and_tells_of_the_others(part: Path) -> None:
    low, stops = part.with_name("low.nc"), part.with_name("stops.nc")
    low.write_text(SHORT.replace("Z20", "Z900"), "utf-8")
    stops.write_text(SHORT.replace("G1 X10", "G1 X10\nM0\nX0"), "utf-8")
    out = part.with_name("out")
    options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)}, split_at_stops=True)
    done = vp.batch([part, low, stops, part.with_name("none.nc")], "verne", options, out)
    assert [one.status for one in done.programs] == [0, 1, 0, 2]
    assert not done.ok
    assert sorted(path.name for path in out.iterdir()) == ["part.csv", "stops.1.csv", "stops.2.csv"]
    for one in (done.programs[0].files[0], done.programs[2].files):
        path = one if isinstance(one, Path) else one[0]
        assert path.read_text("utf-8").startswith("t_s,rho1_mm")
    alone = vp.convert(part, "verne", options).setpoints
    assert alone is not None
    assert (out / "part.csv").read_text("utf-8") == alone.to_csv()
    for text in (repr(done), done._repr_html_()):
        assert "4 programs: 2 can run, 2 refused" in text
    assert f'<tr><td style="text-align: left">{low}</td>' in done._repr_html_()
    with pytest.raises(vp.UsageError, match="is there already"):
        vp.batch([part], "verne", options, out)
    with pytest.raises(vp.UsageError, match="two programs have this name"):
        vp.batch([part, part.parent / "other" / part.name], "verne", options, part.with_name("new"))
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    for text in (stops.read_text("utf-8").replace("M0\n", ""), "G1 X\n"):  # no parts any more, or refused
        stops.write_text(text, "utf-8")
        for chosen in (options, options.changed(split_at_stops=False)):
            with pytest.raises(vp.UsageError, match=r"stops\.1\.csv: may be a part of .*stops\.csv of another run"):
                vp.batch([stops], "verne", chosen, out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    (index := part.with_name("of") / "part.index.json").parent.mkdir()
    index.write_text("{}", "utf-8")
    with pytest.raises(vp.UsageError, match=r"part\.index\.json: may be a part of"):
        vp.batch([part], "verne", options, index.parent)


def test_a_part_takes_the_name_of_no_other_program(part: Path) -> None:
    second = part.with_name("part.2.nc")
    part.write_text(SHORT.replace("G1 X10", "G1 X10\nM0\nX0"), "utf-8")
    second.write_text(SHORT, "utf-8")
    out, whole = part.with_name("out"), vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)})
    for given, setup in ((whole.changed(split_at_stops=True), ""), (whole, "split_at_stops = true\n")):
        part.with_name("part.nc.toml").write_text(setup, "utf-8")
        with pytest.raises(vp.UsageError, match=r"part\.2\.csv: a part of .*part\.csv may have this name"):
            vp.batch([part, second], "verne", given, out)
    part.with_name("part.nc.toml").unlink()
    assert not out.exists()
    assert [len(one.files) for one in vp.batch([part, second], "verne", whole, out)] == [0, 1]


def test_a_batch_of_a_folder_is_that_of_the_command(part: Path, run: Callable[..., Any]) -> None:
    """Its structure, names that two programs share, and the subprogram that another program executes."""
    top = part.parent / "p"
    (top / "sub").mkdir(parents=True)
    (top / "main.nc").write_text(SHORT.replace("G1 X10", "G1 X10\nO<hole> CALL"), "utf-8")
    (top / "hole.ngc").write_text("O<hole> SUB\nG1 X5\nO<hole> ENDSUB\n", "utf-8")
    for name in ("part.nc", "part.tap"):
        (top / "sub" / name).write_text(SHORT, "utf-8")
    options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)}, cycle=0.004)
    given = ("--tool-length", 80, "--wcs", "G54=0,0,60", "--cycle", 0.004, "-j", 1)
    told = run("batch", top, "-o", part.with_name("out"), *given)
    done = vp.batch(top, "verne", options, part.with_name("own"))
    assert (told.code, done.ok) == (0, True)
    written = [
        sorted(one.relative_to(folder) for one in folder.rglob("*.csv"))
        for folder in map(part.with_name, ("out", "own"))
    ]
    assert written[0] == written[1] == [Path("main.csv"), Path("sub/part.nc.csv"), Path("sub/part.tap.csv")]
    said = f"not checked alone: {top / 'hole.ngc'}, called by {top / 'main.nc'}"
    assert all(said in text for text in (told.err, repr(done), done._repr_html_()))
    assert done[0].called == (str(top / "hole.ngc"),)
    named = vp.batch([top, top / "hole.ngc"], "verne", options)  # what is named is converted
    assert [one.program.name for one in named] == ["hole.ngc", "main.nc", "part.nc", "part.tap"]
    (part.parent / "empty").mkdir()
    with pytest.raises(vp.UsageError, match=r"no programs in .*empty; looked for \.nc"):
        vp.batch([part.parent / "empty"], "verne", options)


def test_a_report_is_the_page_of_the_command(part: Path, run: Callable[..., Any]) -> None:
    pytest.importorskip("jupyter_threejs_sage")
    answer = run("report", part, "-o", part.with_suffix(".html"))
    assert answer.code == 0, answer.err
    page = vp.make_report(part, "verne")
    page.write(part.with_name("own.html"))
    assert part.with_name("own.html").read_bytes() == part.with_suffix(".html").read_bytes()
    assert repr(page) in answer.err
    both = vp.make_report(part, "verne", versus=SHORT)
    assert len(both.html) < len(page.html)  # a comparison draws no machine
    assert "<iframe" in both._repr_html_()


def test_rows_are_drawn_with_the_limits_of_their_machine() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    rows = vp.convert(POCKET, "verne", OPTIONS).setpoints
    assert rows is not None
    assert len(rows.plot().axes) == 5
    machine = vp.load_machine("verne")
    axes = rows.plot(machine).axes
    assert len(axes) == 20
    shares = [place.lines[0].get_ydata().max() for place in axes[1:4]]
    limits = machine.scale_limits()
    speed = np.abs(np.diff(rows.values[:, 0])).max() / 0.004
    assert shares[0] == pytest.approx(speed / limits.velocity[0])
    assert max(shares) < 1.01  # rows are rounded, which differences of third order show
    with pytest.raises(vp.UsageError, match="has the joints"):
        rows.plot("serial")
    with pytest.raises(vp.UsageError, match="machine: expected a name or a path, got int"):
        rows.plot(5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"nominal": "part.stl"}, r"nominal: 'part.stl' is a text; pass pathlib.Path\('part.stl'\) to read the file"),
        ({"nominal": 5}, "nominal: expected bytes or a path, got int"),
        ({"nominal": Path("none.stl")}, "nominal: none.stl: No such file"),
    ],
)
def test_a_part_is_bytes_or_a_path(given: dict[str, Any], said: str) -> None:
    rows = vp.convert(SHORT, "verne", OPTIONS).setpoints
    assert rows is not None
    with pytest.raises(vp.UsageError, match=said):
        vp.machined(rows, SHORT, "verne", OPTIONS, **given)


def test_a_proposal_goes_into_options() -> None:
    """In degrees: the part stands in it where the proposal was checked."""
    program = "G21 G90 F600\nG0 X0 Y0 Z20 A0 C0\nG1 X10\nM2\n"
    given = vp.Options(tool_length=80, wcs={"G54": (0, 0, 900, 30), "G55": (1, 2, 3)})
    assert not vp.check(program, "verne", given).ok
    proposal = vp.fit(program, "verne", given)
    assert list(proposal.wcs) == [1]
    assert proposal.wcs[1].turn_deg == pytest.approx(proposal.after.place.c_deg, abs=1e-9)
    there = vp.check(program, "verne", given.changed(wcs=proposal.wcs))
    assert there.ok
    assert there.summary is not None
    assert there.summary.time_s == proposal.seconds


def test_the_snippets_of_the_page_run_as_pasted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "api.md").read_text("utf-8").partition("## Functions")[0]
    exec("\n".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL)), {})
    said = capsys.readouterr().out
    assert (said.count("can run on VERNE"), "6 VP110 out of reach" in said, "refused" in said) == (2, True, False)
    assert np.shape(vp.load_machine("verne").forward(([0.0] * 5, [1.0] * 5), 80.0)[0]) == (2, 3)  # a tuple of poses
    assert "last tip: [30. 30. 50.] from G54, all True True\n" in said
    assert Path("axes-1.csv").stat().st_size > 1000


def test_what_helps_is_said_in_words_of_python() -> None:
    """No command, no option of one, and no file beside a program, which a text has not."""
    texts = [code.remedy for code in CODES.values()] + [FILL_IN_LENGTH, GIVE_PLACE.format("G54")]
    said = [name_in_python(text) for text in texts]
    assert not [
        text for text in said if re.search(r"verne-post |INPUT|(?<!\w)--[a-z]|\[(?:tools|wcs|remap)\]|\.toml", text)
    ]
    assert name_in_python("turn the part: `verne-post fit m/x19.nc --machine verne` does") == "turn the part: fit does"
    (lacking,) = vp.check("G21 G90\nT1 M6\nG43 H1 G0 X0 Y0 Z20 A0 C0\nM30\n", "verne").errors
    assert lacking.remedy == "Give the length in tools, or in the set-up."


def test_what_is_printed_has_words_of_python(tmp_path: Path) -> None:
    """A text has no file beside it, and no setting of a control is in a file."""
    shift = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S300\n2 L Z+50 R0 FMAX\n3 CYCL DEF 7.0 DATUM SHIFT\n4 CYCL DEF 7.1 #5\n"
    tools = vp.Options(tools={1: 80}, wcs={"G54": (0, 0, 60)})
    program = tmp_path / "part.nc"
    program.write_text("G21 G90\nT1 M6\nG43 H1 G0 X0 Y0 Z20 A0 C0\nG1 X10 F600\nM30\n", "utf-8")
    lacks = "  VP012, remedy: Give the length in tools, or in the set-up.\n"
    for source, line, given, said in (
        (program.read_text("utf-8"), 3, None, lacks),
        (program, 3, None, lacks),
        (f"{shift}5 L X+0 F100\n6 M30\n", 5, tools, '; give control={"heidenhain": {"datums": {"5": (X, Y, Z)}}}, mm,'),
        (SHORT, 0, OPTIONS.changed(approach="home"), "line 0: the approach (approach), in no words of the program"),
    ):
        told = str(vp.explain(source, "verne", line, given))
        assert said in told
        assert not re.search(r"verne-post|\.toml|--[a-z]|under \[", told)
    # what the message says needs no remedy: the file that is not there, the tool that no line calls
    (missing,) = vp.check(program, "verne", setup=tmp_path / "nix.toml").findings
    Path(f"{program}.toml").write_text("[tools]\n1 = { length = 80 }\n2 = { length = 70 }\n", "utf-8")
    unused = next(
        item for item in vp.check(program, "verne", OPTIONS.changed(tool_length=None)).findings if not item.line
    )
    assert [(item.code, item.remedy) for item in (missing, unused)] == [("VP503", ""), ("VP041", "")]
    with pytest.raises(vp.UsageError, match="'MILL': another tool has its number already"):
        vp.Options(tools={"DRILL": (tool := vp.Tool(100001, 1, (0, 0, 80, 0, 0, 0, 0, 0, 0))), "MILL": tool})


def test_a_mistake_in_a_file_has_the_place_that_commands_name(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a set-up, settings and a machine; the error, and what is printed, name the file too."""
    monkeypatch.chdir(tmp_path)
    program, setup = Path("part.nc"), Path("part.nc.toml")
    program.write_text("G21 G90 G54\nT1 M6\nG43 H1 G0 X0 Y0 Z20 A0 C0\nG1 X10 F600\nM30\n", "utf-8")
    for text, line, column in (
        ("[tols]\n", 1, 1),
        ("[tools]\n1 = { length = -5 }\n", 2, 7),
        ("\ntool_length = \n", 2, 15),
        ("[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 80 }\n2 = { length = 80 }\n", 5, 1),  # no line calls it
    ):
        setup.write_text(text, "utf-8")
        result = vp.check(program, "verne")
        first = next(item for item in result.findings if item.line is None)
        assert [first.file, first.file_line, first.file_column] == ["part.nc.toml", line, column]
        assert f"part.nc.toml:{line}:{column}: {first.code} " in run("check", "part.nc").out
        assert f"part.nc.toml:{line}: {first.code} " in str(first)
        assert f"part.nc.toml, line {line}: {first.message}" in repr(result)
    for read in (vp.read_settings, vp.load_machine, lambda path: vp.fit(SHORT, "verne", settings=Path(path))):
        Path("wrong.toml").write_text("\nmachin = 1\n", "utf-8")
        with pytest.raises(vp.InputError, match=r"wrong\.toml(, line 2)?: ") as caught:
            read("wrong.toml")
        lines = [item.file_line for item in caught.value.findings if item.file == "wrong.toml"]
        assert lines and (2 in lines or read is vp.load_machine)  # a key that is missing has no line


def test_a_finding_prints_as_one_line() -> None:
    result = vp.check(
        "G21 G90\nG0 X0 Y0 Z20 A0 C0\nZ700\nM2\n", "verne", vp.Options(tool_length=80, wcs={"G54": (0, 0, 0)})
    )
    first = result.causes[0].first
    assert f"{first}" == str(first)
    assert str(first).startswith("line 3: VP101 error: slider 2 (rho2) reaches ")
    assert str(first) in str(result)
    other = dataclasses.replace(first, file="tools.tbl", file_line=7)
    assert str(other).startswith("tools.tbl:7: VP101 error: ")


def test_a_finding_of_a_called_file_has_the_file_and_line_of_json(tmp_path: Path) -> None:
    program = tmp_path / "main.nc"
    program.write_text("O1\nG21 G90\nG0 X0 Y0 Z50 A0 C0\nM98 P2000\nM30\n", encoding="utf-8")
    for line, code in (("G1 Z-900 F500", "VP210"), ("G1 X1O", "VP001")):
        (tmp_path / "O2000.nc").write_text(f"O2000\nG0 Z20\n{line}\nM99\n", encoding="utf-8")
        result = vp.check(program, "ac_trunnion", vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)}))
        first = result.causes[0].first
        assert (first.code, first.file, first.file_line, first.line) == (code, "O2000.nc", 3, 4)
        assert str(first).startswith(f"line 4: {code} error: O2000.nc, line 3: ")
        assert f"{code} line 4" in repr(api.Batch((api.BatchRow(program, result),)))


def test_a_finding_shows_what_is_given_and_findings_are_a_table() -> None:
    result = vp.check("G21 G90\nG0 X0 Y0 Z60 A0 C0\nG1 X5O F600\nM2\n", "verne")
    first = result.errors[0]
    assert re.fullmatch(r"Finding\(code='VP001', severity='error', message='X5O: [^']*', line=3, .*\)", repr(first))
    assert "=None" not in repr(first) and "count=" not in repr(first)
    assert eval(repr(first), {"Finding": vp.Finding, "Remedy": type(first.edits[0])}) == first
    assert isinstance(result.findings, Findings)
    page = result.findings._repr_html_()
    assert (page.count("<table>"), page.count("<tr>")) == (1, 1 + len(result.findings))
    for severity, found in (("error", result.errors), ("warning", result.warnings)):
        assert found == tuple(one for one in result.findings if one.severity == severity)
        assert found
        assert isinstance(found, Findings)
    assert Findings()._repr_html_() == "<p>no findings</p>"
    assert pickle.loads(pickle.dumps(result.findings)) == result.findings


def test_a_name_that_a_result_does_not_have_is_told() -> None:
    machine, result = vp.load_machine("verne"), vp.check(SHORT, "verne", OPTIONS)
    told = (
        (result, "time", "Result has no attribute time; did you mean summary.cycle_time?"),
        (result, "seconds", "Result has no attribute seconds; did you mean summary.cycle_time?"),
        (result, "setpoint", "Result has no attribute setpoint; did you mean setpoints?"),
        (result.summary, "time", "Summary has no attribute time; did you mean cycle_time?"),
        (result.summary, "duration", "Summary has no attribute duration; did you mean cycle_time?"),
        (machine, "joints", "Machine has no attribute joints; did you mean columns?"),
        (machine, "qqqq", "Machine has no attribute qqqq"),
        (vp.Page("", ()), "htm", "Page has no attribute htm; did you mean html?"),
        (vp.Page("", ()), "save", "Page has no attribute save; did you mean write?"),
        (api.BatchRow(Path("a"), result), "summary", "BatchRow has no attribute summary; did you mean result.summary?"),
        (vp.Verification(), "errors", "Verification has no attribute errors; did you mean findings?"),
        (vp, "compare", "module 'verne_post' has no attribute 'compare'; did you mean make_report(..., versus=...)?"),
    )
    for thing, name, said in told:
        with pytest.raises(AttributeError) as raised:
            getattr(thing, name)
        assert str(raised.value) == said
    # what Python asks for by itself stays as it was
    assert pickle.loads(pickle.dumps(machine)).name == machine.name


def test_what_an_option_needs_is_named_as_python_has_it(run: Any, tmp_path: Path) -> None:
    with pytest.raises(vp.UsageError) as told:
        vp.Options(from_line=3)
    assert str(told.value).startswith("from_line: 3 needs approach, the start")
    (tmp_path / "a.nc").write_text(SHORT)
    assert "--from-line 3 needs --from, the start" in run("check", tmp_path / "a.nc", "--from-line", "3").err


def test_times_have_the_decimals_of_the_cycle() -> None:
    summary = vp.check(
        "G21 G90 F600\nG0 X0 Y0 Z20\nG1 X98.28\nM2\n", "verne", vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)})
    ).summary
    assert summary is not None
    assert repr(summary.time_s) == f"{summary.time_s:.3f}".rstrip("0")


def test_a_batch_has_a_length_and_an_index(part: Path) -> None:
    done = vp.batch([part, part], "verne")
    assert len(done) == 2
    assert done[0] is done.programs[0]
    assert [one.program for one in done] == [part, part]


def test_help_begins_with_what_a_user_needs() -> None:
    text = pydoc.plain(pydoc.render_doc(vp))
    for name in (
        "convert",
        "check",
        "explain",
        "verify",
        "batch",
        "make_report",
        "load_machine",
        "Options",
        "read_settings",
    ):
        assert re.search(rf"^    +{name} {{2,}}", text[: text.index("PACKAGE CONTENTS")], re.MULTILINE), name


def test_options_are_written_once() -> None:
    """Each option has help, and its record a key; the settings file takes what it may."""
    record = vp.Options().record()
    for name in options.OPTIONS:
        assert options.find_about(name).help.endswith("."), name
        assert (
            options.find_key(name) in record
            or name in ("source_name", "setup_source", "setup_file", "command_words", "subroutine_files", "jobs")
            or name in ("replaced_tools", "setup_machine")
        )


def test_help_shows_every_option_with_type_default_and_meaning() -> None:
    shown = inspect.signature(vp.Options).parameters
    assert list(shown) == list(options.OPTIONS)
    assert all(one.kind is one.KEYWORD_ONLY for one in shown.values())
    assert str(shown["tolerance"]) == "tolerance: float | None = None"
    assert str(shown["smoothing"]) == "smoothing: Literal['spline', 'blend', 'off'] = 'spline'"
    text = " ".join(pydoc.plain(pydoc.render_doc(vp.Options)).replace("|", " ").split())
    for name, option in options.OPTIONS.items():
        # a default as it is given makes the default: the signature tells no other value than the model
        assert getattr(vp.Options(**{name: shown[name].default}), name) == option.default()
        assert shown[name].annotation is not inspect.Parameter.empty
        assert f" {name} : " in text, name
        assert " ".join(name_in_python(option.about.help).replace("|", " ").split()) in text, name
    assert (
        "tool_length : float, default None Length from the gauge line to the tip, for the whole program; default: "
        "that of each tool. 0 to 10000 mm." in text
    )
    assert "smoothing : {'spline', 'blend', 'off'}, default 'spline'" in text
    assert "approach : str or tuple[float, ...], default None" in text
    assert "Command line: ``--from``." in text


@pytest.mark.parametrize("module", [vp, api, options, machine_model])
def test_examples_of_the_docstrings(module: Any) -> None:
    assert doctest.testmod(module).failed == 0


def test_the_page_is_made_from_the_docstrings() -> None:
    page = load_maker("make_api").page()
    for call in (
        "split() -> tuple[Setpoints, ...]",
        "changed(given: Mapping[str, Any] | None = None, /, **keywords: Any) -> Options",
        "forward(q: ndarray",
    ):
        assert f"- `{call}" in page
    assert page == (ROOT / "docs" / "api.md").read_text("utf-8"), "run python docs/make_api.py"


CLIENT = """
from pathlib import Path

import verne_post as vp

machine = vp.load_machine("verne")
offsets = vp.work_offsets(G54=(-10.0, 15.0, 60.0))
tool = vp.Tool(1, 1, (0.0, 0.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
options = vp.Options(tool_length=80.0, wcs=offsets, tools={1: tool})
result: vp.Result = vp.convert(Path("part.nc"), machine, options)
codes: list[str] = [finding.code for finding in result.findings]
if result.ok and result.setpoints is not None:
    csv: str = result.setpoints.to_csv()
    good: bool = vp.verify(result.setpoints, Path("part.nc"), machine, options).ok
text: str = vp.explain("G0 X1", machine, 1, options).text
short = vp.Options(wcs={"G54": (-10, 15, 60)}, tools={1: 80, 2: (80, 10), "MILL": 90})
lengths: list[float] = [one.offset[2] for one in (short.tools or {}).values()]
"""


def test_a_strict_type_checker_accepts_a_client(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    client = tmp_path / "client.py"
    client.write_text(CLIENT, "utf-8")
    answer = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), str(client)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert answer.returncode == 0, answer.stdout
    client.write_text("import verne_post as vp\nvp.Options(tool_lenght=80.0)\n", "utf-8")
    wrong = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), str(client)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert wrong.returncode == 1


@pytest.mark.parametrize(
    ("text", "dialect", "line", "wrong", "right"),
    [
        ("G21 G90 F600\nG0 X0 Y0 Z20 A0 C0\nG1X3O\nM2\n", "auto", 3, "X3O", "X30"),
        ("G90 G71\ntraoir\nG0 X0 Y0 Z50 A0 C0\nM30\n", "siemens", 2, "traoir", "TRAORI"),
        (
            "BEGIN PGM A MM\nTOOL CAL 1 Z S9\nL X+1 Y+2 Z+30 A+0 C+0 FMAX\nEND PGM A MM\n",
            "heidenhain",
            2,
            "CAL",
            "CALL",
        ),
    ],
)
def test_what_a_misspelt_word_is_meant_for_is_an_edit(
    text: str, dialect: Any, line: int, wrong: str, right: str
) -> None:
    (found,) = [
        item for item in vp.check(text, "verne", OPTIONS.changed(dialect=dialect)).findings if item.code < "VP003"
    ]
    (edit,) = found.edits
    assert (edit.line, edit.misspelt, edit.value, found.line) == (line, wrong, right, line)
    assert found.column is not None
    assert text.split("\n")[line - 1].startswith(wrong, found.column - 1)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("machines", "list_machines"),
        ("list_machine", "list_machines"),
        ("Report", "make_report"),  # report is a module of the package once it is loaded
        ("load_settings", "read_settings"),
        ("convrt", "convert"),
        ("quite_another", ""),
        ("_machines", ""),
    ],
)
def test_a_name_that_the_module_does_not_have_says_what_is_meant(name: str, meant: str) -> None:
    with pytest.raises(AttributeError) as caught:
        getattr(vp, name)
    assert str(caught.value).partition("; did you mean ")[2] == (f"{meant}?" if meant else "")


def test_machines_are_listed_as_the_command_lists_them(run: Any) -> None:
    assert list(vp.list_machines()) == [line.split()[0] for line in run("machine", "list").out.splitlines()]
    assert vp.load_machine(vp.list_machines()[0]).name


@pytest.mark.parametrize(("name", "line"), [("violates_tilt", 10), ("violates_slider_travel", 8)])
def test_findings_of_an_explanation_have_the_remedies_that_its_text_shows(name: str, line: int) -> None:
    """They had none."""
    told = vp.explain(ROOT / f"gcode_samples/{name}.nc", "verne", line)
    shown, unchecked, _rest = told.text.partition("each was checked along the whole line\n")[2].partition(
        "NOT CHECKED: "
    )
    assert shown and unchecked
    for item in told.findings:
        assert item.remedies == tuple(text.strip() for text in shown.splitlines())


def test_a_missing_line_and_the_beginning_of_an_option_are_named() -> None:
    with pytest.raises(vp.UsageError, match="line: None: expected the number of a source line"):
        vp.explain("M2\n", "verne")
    with pytest.raises(vp.UsageError, match="tol: there is no such option; did you mean tolerance"):
        vp.Options(tol=1)


def test_the_machine_is_the_default_of_load_machine_where_none_is_given() -> None:
    given, default = vp.check(SHORT, "verne", OPTIONS), vp.check(SHORT, options=OPTIONS)
    assert repr(default.summary) == repr(given.summary) and vp.convert(SHORT, options=OPTIONS).ok


def test_the_machine_is_that_of_the_settings_where_none_is_given(tmp_path: Path) -> None:
    """Else the program would be checked for another machine than the one that cuts it."""
    file, program = tmp_path / "verne-post.toml", tmp_path / "part.nc"
    file.write_text('machine = "ac_trunnion"\n', "utf-8")
    program.write_text(SHORT, "utf-8")
    given = vp.load_machine("ac_trunnion")
    name = given.name
    for settings in (file, vp.read_settings(file)):
        made = vp.convert(SHORT, options=OPTIONS, settings=settings)
        assert (made.machine, vp.check(SHORT, None, OPTIONS, settings=settings).machine) == (name, name)
        assert vp.check(SHORT, "verne", OPTIONS, settings=settings).machine == "VERNE"
        assert made.setpoints is not None
        assert vp.verify(made.setpoints, SHORT, options=OPTIONS, settings=settings).ok
        assert [one.result.machine for one in vp.batch([program], options=OPTIONS, settings=settings)] == [name]
        assert str(vp.explain(SHORT, None, 3, OPTIONS, settings=settings)) == str(vp.explain(SHORT, given, 3, OPTIONS))
        assert name in vp.fit(SHORT, options=OPTIONS, settings=settings).text


@pytest.mark.parametrize("line", [1, 3])
def test_a_line_of_a_form_that_is_not_filled_in_is_explained_as_by_the_command(
    part: Path, run: Callable[..., Any], line: int
) -> None:
    Path(f"{part}.toml").write_text('tool_length = 80\n[wcs]\nG54 = "measure"\n', "utf-8")
    told, said = vp.explain(part, "verne", line), run("explain", f"{part}:{line}")
    assert said.code == 2
    assert told.text.splitlines()[:3] == said.out.splitlines()[:3]
    assert told.text.startswith(f"line {line}: ")


def test_an_internal_error_is_a_finding_as_on_the_command_line(part: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_arguments: Any, **_named: Any) -> Any:
        raise KeyError("no such thing")

    monkeypatch.setattr("verne_post.app.convert.assemble", fail)
    for result in (vp.check(SHORT), vp.convert(part), vp.batch([part])[0].result):
        (item,) = result.findings
        assert (item.code, item.message) == ("VP902", "internal error: KeyError: 'no such thing'")
        assert (result.ok, result.machine) == (False, "VERNE")
    monkeypatch.setenv("VERNE_POST_TRACEBACK", "1")
    with pytest.raises(KeyError):
        vp.check(SHORT)


@pytest.mark.parametrize("what", ["sink", "progress"])
def test_what_a_function_of_the_caller_raises_is_raised(what: str) -> None:
    def stop(*_arguments: Any) -> None:
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        vp.convert(SHORT, options=OPTIONS, **{what: stop})


#: What files of other kinds are, and what Python does with them.
FILES_OF_OTHER_KINDS = {
    SHORT: "this is a program, not {}; give it as source",
    "t_s,rho1_mm\n": "this is a setpoint file, not {}; give it to verify as setpoints",
    "tool_length = 80\n": "this is a set-up, not {}; give it as setup",
    "tool,length_mm\n": "this is a file of tool lengths, not {}; name it in the set-up: tool_lengths",
}


@pytest.mark.parametrize("text", FILES_OF_OTHER_KINDS)
def test_a_file_of_another_kind_is_told_in_words_of_python(text: str, tmp_path: Path) -> None:
    path = tmp_path / "file.x"
    path.write_text(text, "utf-8")
    for call, kind in (
        (lambda: vp.check("M2\n", path), "a machine file"),
        (lambda: vp.load_machine(path), "a machine file"),
        (lambda: vp.read_settings(path), "a settings file"),
    ):
        with pytest.raises(vp.InputError, match=re.escape(FILES_OF_OTHER_KINDS[text].format(kind))):
            call()


def test_setpoints_in_place_of_the_program_are_named(tmp_path: Path) -> None:
    """Every row was an error, in 4,731 characters."""
    rows = tmp_path / "rows.csv"
    rows.write_text("t_s,rho1_mm\n0,1\n" * 50, "utf-8")
    said = f"{rows} is a setpoint file, not a program; give it to verify as setpoints"
    with pytest.raises(vp.InputError) as caught:
        vp.verify("M2\n", rows)
    assert str(caught.value) == said
    assert [item.full_message for item in vp.check(rows).findings] == [said]


def test_the_stock_of_the_program_is_named_as_python_has_it() -> None:
    text = 'G54 G17 G90\nWORKPIECE(,,,"BOX",0,0,-20,80,0,0,50,50)\nG0 X0 Y0 Z20\nG1 X10 F600\nM30\n'
    summary = str(vp.check(text, "verne", OPTIONS.changed(dialect="siemens")).summary)
    assert "not checked (stock=OwnStock() checks it)" in summary
    assert "no keep_out and no stock given" in " ".join(summary.split())
    with pytest.raises(vp.UsageError, match=r"or OwnStock\(\) for the stock of the program"):
        vp.Options(stock="program")


def test_rows_of_setpoints_are_told() -> None:
    setpoints = vp.convert(SHORT, options=OPTIONS).setpoints
    with pytest.raises(AttributeError, match=r"row by row zip\(setpoints.t, setpoints.values, setpoints.line\)"):
        _ = setpoints.rows  # type: ignore[union-attr]
