"""`verne-post machined`: rows as written against the nominal part, on the command line and in Python."""

import contextlib
import importlib.util
import json
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

import verne_post as vp
from verne_post.app.machined import report_missing_shape
from verne_post.app.python_names import name_in_python
from verne_post.cli.main import main
from verne_post.config.tool_shapes import read_tool_shapes
from verne_post.part import compare, sweep

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "gcode_samples" / "blade_5axis.nc"
MAKER = runpy.run_path(str(ROOT / "gcode_samples" / "make_blade_part.py"))

#: A floor of 20 x 10 mm at Z0, cut by a ball of 4 mm in strips 1 mm apart: on lines 5 to 27.
FLOOR = (
    "G21 G90 G94 G64 P0.001\nT1 M6\nM3 S1000 G43 H1\nG0 X-15 Y-5 Z10 A0 C0\nG1 Z0 F6000\n"
    + "".join(f"{'X15' if k % 2 == 0 else 'X-15'} Y{k - 5}\n" + (f"Y{k - 4}\n" if k < 10 else "") for k in range(11))
    + "G0 Z30\nM2\n"
)
TABLE = "T1 P1 Z80 D8 ;\n"
SHAPES = "[tool.1]\ncutter = { diameter = 8.0, length = 20.0, corner_radius = 4.0 }\nholder = { diameter = 30.0 }\n"
PLACE = ("--tool-table", "tools.tbl", "--wcs", "G54=0,0,60")
CONVERTED = (*PLACE, "--quiet")
JUDGE = (
    "machined",
    "axes.csv",
    "--against",
    "part.nc",
    *PLACE,
    "--tool-shapes",
    "shapes.toml",
    "--nominal",
    "part.stl@G54",
)


def plate(z: float = 0.0) -> bytes:
    """A rectangle of 20 x 10 mm in ASCII."""
    corner = [(-10, -5), (10, -5), (10, 5), (-10, 5)]
    facets = "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {corner[k][0]} {corner[k][1]} {z}\n" for k in three)
        + "endloop\nendfacet\n"
        for three in ((0, 1, 2), (0, 2, 3))
    )
    return f"solid plate\n{facets}endsolid plate\n".encode()


def write_files():
    """The program, its tools and the part, into the folder that is open."""
    for name, text in (("part.nc", FLOOR), ("tools.tbl", TABLE), ("shapes.toml", SHAPES)):
        Path(name).write_text(text, encoding="utf-8")
    Path("part.stl").write_bytes(plate())


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A folder with the program, its tools and the part."""
    monkeypatch.chdir(tmp_path)
    write_files()
    return tmp_path


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """The rows of the program."""
    with contextlib.chdir(tmp_path_factory.mktemp("floor")):
        write_files()
        assert main(["convert", "part.nc", "-o", "axes.csv", *CONVERTED]) == 0
        return Path("axes.csv").read_bytes()


@pytest.fixture
def floor(files, rows):
    """The same with the rows of the program."""
    Path("axes.csv").write_bytes(rows)
    return files


def codes(answer):
    return {item["code"] for item in json.loads(answer.out)["programs"][0]["findings"]}


def test_a_floor_as_it_should_be(floor, run):
    answer = run(*JUDGE)
    assert (answer.code, answer.out) == (0, "")
    assert "clear of gouges deeper than 0.05 mm" in answer.err
    assert "where the set-up puts the part" in answer.err
    assert "moved to the best fit" in answer.err
    # the scallop of strips 1 mm apart
    found = vp.machined(
        Path("axes.csv"),
        Path("part.nc"),
        "verne",
        options(),
        nominal=Path("part.stl"),
        grid=0.1,
        excess=0.02,
        distance=np.float32(0),  # type: ignore[arg-type]
        fixtures={}.items(),  # type: ignore[arg-type]
    )
    assert found.judged[0].comparison.deviation.max() == pytest.approx(4 - np.sqrt(16 - 0.25), abs=0.002)


def options() -> vp.Options:
    return vp.Options(
        tools={1: vp.Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 8.0)},
        wcs={"G54": (0, 0, 60)},
        tool_shapes=read_tool_shapes(SHAPES.encode(), "shapes.toml"),
    )


def test_a_deeper_line_is_found_with_its_line_place_and_depth(floor, run):
    """One strip 0.3 mm too deep: the program that the rows are of has it, the drawing has not."""
    lines = FLOOR.splitlines()
    strip = lines.index("X15 Y-1")
    changed = [*lines[:strip], "G1 Z-0.3", lines[strip], "G1 Z0", *lines[strip + 1 :]]
    Path("part.nc").write_text("\n".join(changed) + "\n", encoding="utf-8")
    assert run("convert", "part.nc", "-o", "axes.csv", *CONVERTED).code == 0
    answer = run(*JUDGE, "--output-format", "json", "--csv", "worst.csv")
    assert answer.code == 1
    (gouge,) = (item for item in json.loads(answer.out)["programs"][0]["findings"] if item["code"] == "VP218")
    assert gouge["value"] == pytest.approx(0.3, abs=1e-3)
    assert (gouge["line"], gouge["last_line"]) == (strip + 2, None)
    assert "the cutter of tool 1" in gouge["message"]
    header, worst = Path("worst.csv").read_text(encoding="utf-8").splitlines()[:2]
    assert header == "x_mm,y_mm,z_mm,deviation_mm,line,tool,body,facet,along_normal_mm"
    assert float(worst.split(",")[3]) == pytest.approx(-0.3, abs=1e-3)
    assert abs(float(worst.split(",")[1]) + 1) < 1.6  # the strip at y -1


def test_wrong_length_and_offset_show_and_the_fit_takes_them_away(floor, run):
    """A tool that is 0.2 mm longer than the program was told, and a part that stands 0.2 mm higher, are one
    thing here.
    """
    Path("tools.tbl").write_text("T1 P1 Z80.2 D8 ;\n", encoding="utf-8")
    answer = run(*JUDGE, "--output-format", "json")
    assert (answer.code, codes(answer)) == (1, {"VP218"})
    assert run(*JUDGE, "--datum", "fit", "--quiet").code == 0
    Path("tools.tbl").write_text(TABLE, encoding="utf-8")
    low = [word.replace("0,0,60", "0,0,59.7") for word in JUDGE]
    answer = run(*low, "--output-format", "json")
    assert (answer.code, codes(answer)) == (0, {"VP219"})


def test_a_deep_cut_is_at_least_as_deep_as_the_search(floor, run):
    """10 mm too deep: the nearest way out of the cutter is to its side, and its end is 10 mm below the floor."""
    low = [word.replace("0,0,60", "0,0,70") for word in JUDGE]
    answer = run(*low)
    assert answer.code == 1
    said = re.search(r"VP218 error: the cutter of tool 1 cuts (\d\.\d+) mm into part.stl, by the shortest", answer.err)
    assert said is not None
    assert 3.9 < float(said[1]) <= 4.0
    deep = re.search(r"; along the tool axis it is (\d+\.\d+) mm there \(lines", answer.err)
    assert deep is not None
    assert 9.99 < float(deep[1]) <= 10.001


def test_a_bound_that_does_not_decide_has_no_verdict(floor, run, monkeypatch):
    """A flat cutter 0.04 mm deep: less than 0.05, and more than what an edge that cuts 0.05 deep must reach."""
    monkeypatch.setattr(compare, "MAX_CELLS", 5_000)  # a million small facets decide no more, and take half a minute
    Path("shapes.toml").write_text("[tool.1]\ncutter = { diameter = 8.0, length = 20.0 }\n", encoding="utf-8")
    low = [word.replace("0,0,60", "0,0,60.04") for word in JUDGE]
    answer = run(*low, "--grid", "1", "--output-format", "json")
    assert (answer.code, codes(answer)) == (3, {"VP220"})
    (found,) = json.loads(answer.out)["programs"][0]["findings"]
    assert found["line"] is not None
    assert "0.040 mm by the shortest way out: gouge_mm (--gouge) 0.062 would accept that" in found["message"]


def test_the_map_is_a_ply_file_and_a_picture(floor, run):
    pytest.importorskip("matplotlib")
    assert run(*JUDGE, "--grid", "1", "-o", "map.ply", "--quiet").code == 0
    raw = Path("map.ply").read_bytes()
    head = raw[: raw.index(b"end_header\n")].decode()
    count = int(head.split("element face ")[1].split()[0])
    assert len(raw) == len(head) + len("end_header\n") + count * (36 + 13 + 3 + 4)
    assert run(*JUDGE, "--grid", "1", "-o", "map.png", "--quiet").code == 0
    assert Path("map.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (("--nominal", "part.stl"), 2, "expected a file and its system, as in part.stl@G54"),
        (("--nominal", "part.stl@G55"), 2, "part.stl is given in G55, and G55 is not"),
        (("--nominal", "none.stl@G54"), 2, "none.stl"),
        (("--unit", "m"), 2, "VP506 error: part.stl: read in m it is 20000 mm large"),
        (("--gouge", "0"), 2, "--gouge"),
        (("--search", "0.01"), 2, "--search 0.01 must not be below"),
        (("--grid", "0.005"), 2, "VP018 error: part.stl: a grid of 0.005 mm has too many places; give 0.0"),
        (("--delay", "3"), 2, "name it with --measured"),
        (("-o", "map.obj"), 2, "expected a name that ends in .ply"),
        (("--csv", "axes.csv"), 2, "axes.csv"),
        (("--against", "other.nc"), 1,
         "belongs to line 11, which the program does not execute there; verify says more"),
    ],
)  # fmt: skip
def test_what_cannot_be_compared_is_named(floor, run, words, code, says):
    Path("other.nc").write_text("\n".join([*FLOOR.splitlines()[:10], "M2\n"]), encoding="utf-8")
    answer = run(*JUDGE, *words)
    assert (answer.code, answer.out) == (code, "")
    assert says in answer.err


def test_another_part_is_no_clear_one(floor, run):
    """A part 30 mm beside the cut was "clear of gouges", without a warning."""
    Path("part.stl").write_bytes(plate(z=-30.0))
    answer = run(*JUDGE, "--grid", "1")
    assert answer.code == 0
    assert answer.err.count("VP219 warning: no cutter comes within 2 mm of part.stl: all of its surface is uncut") == 1
    Path("shapes.toml").write_text("[1]\ndiameter = 8\n", encoding="utf-8")
    answer = run(*JUDGE)
    assert answer.err.count("VP504") == 1
    assert "1 is not a key of a file of tool shapes; write [tool.1]" in answer.err


def test_a_tool_without_a_shape_is_refused(floor, run):
    Path("shapes.toml").write_text(SHAPES.replace("tool.1", "tool.2"), encoding="utf-8")
    answer = run(*JUDGE)
    assert answer.code == 2
    assert "VP018 error: tool 1: its shape is not known; give it with --tool-shapes" in answer.err
    assert str(report_missing_shape(100_001, 'tool "M"')).startswith('tool "M": its shape is not known; ')
    assert "tool.100001.cutter = {" in str(report_missing_shape(100_001, 'tool "M"'))
    sizes = '[vp.Cylinder("cutter", diameter=MM, length=MM, corner_radius=MM)]'
    with pytest.raises(vp.InputError) as caught:
        vp.machined(
            Path("axes.csv"),
            Path("part.nc"),
            "verne",
            options().changed(tool_shapes={}),
            nominal=Path("part.stl"),
            setup="none",
        )
    for said, key in (
        (str(caught.value), "1"),
        (name_in_python(str(report_missing_shape(100_001, 'tool "M"'))), '"M"'),
    ):
        assert said.endswith(f": its shape is not known; give it as tool_shapes={{{key}: {sizes}}}")
        given = eval(said.partition(" as tool_shapes=")[2].replace("MM", "8.0", 2).replace("MM", "1.0"))
        assert vp.Options(tools={"M": 80, 1: 80}, tool_shapes=given).tool_shapes
    Path("shapes.toml").write_text(SHAPES.replace("diameter = 8.0", "diameter = 10.0"), encoding="utf-8")
    answer = run(*JUDGE)
    assert "its cutter among the tool shapes is 10 mm thick, but its diameter in the tool table is 8" in answer.err


def test_flipped_and_inverted_meshes_are_refused(floor, run):
    raw = plate().replace(b"vertex -10 -5 0.0\nvertex 10 -5 0.0\n", b"vertex 10 -5 0.0\nvertex -10 -5 0.0\n", 1)
    Path("part.stl").write_bytes(raw)
    answer = run(*JUDGE)
    assert answer.code == 2
    assert "VP506 error: part.stl: facets are flipped" in answer.err


def test_a_measured_log_takes_the_place_of_the_rows(floor, run):
    """The axes lag by 3 rows and the spindle side stands 0.2 mm low throughout."""
    rows = [line.split(",") for line in Path("axes.csv").read_text(encoding="utf-8").splitlines()]
    values = np.array([[float(cell) for cell in row[1:-1]] for row in rows[1:]])
    values = np.vstack([values[:1]] * 3 + [values])
    values[:, :3] += 0.2  # base z points down
    text = "\n".join([",".join(rows[0][1:-1]), *(",".join(f"{cell:.6f}" for cell in row) for row in values)])
    Path("log.csv").write_text(text + "\n", encoding="utf-8")
    answer = run(*JUDGE, "--measured", "log.csv", "--output-format", "json")
    assert answer.code == 1
    worst = max(item["value"] for item in json.loads(answer.out)["programs"][0]["findings"] if item["code"] == "VP218")
    assert worst == pytest.approx(0.2, abs=0.02)


@pytest.fixture(scope="module")
def blade(tmp_path_factory):
    """The blade sample, its rows, and its part."""
    folder = tmp_path_factory.mktemp("blade")
    MAKER["main"](folder)
    shapes = read_tool_shapes((folder / "blade_shapes.toml").read_bytes(), "blade_shapes.toml")
    given = vp.Options(tool_shapes=shapes)
    result = vp.convert(SAMPLE, "verne", given)
    assert result.setpoints is not None
    return folder, given, result.setpoints


def test_the_blade_as_written(blade):
    """Where the ball touches, 0.01 of the corners; beside, sqrt(R^2 + y^2) - R. At the ends of the section the path
    bends so much that the strip, straight across, is touched by the tool of the next lines."""
    folder, given, setpoints = blade
    found = vp.machined(setpoints, SAMPLE, "verne", given, nominal=folder / "blade_part.stl")
    assert found.ok
    assert "clear of gouges deeper than 0.05 mm" in found.text
    deviation = found.judged[0].comparison.deviation
    assert np.quantile(deviation, 0.05) > -0.01
    assert deviation.max() < np.sqrt(16 + 1) - 4 + 0.01


def test_the_blade_is_as_far_from_the_tool_as_its_programmed_points_say(blade):
    """Places on the strip, against the ball's centre straight from point to point: within the tolerance of the corners,
    0.01.
    """
    folder, given, setpoints = blade
    found = vp.machined(setpoints, SAMPLE, "verne", given, nominal=folder / "blade_part.stl", grid=2.0)
    motions = found.judged[0].motions
    text = SAMPLE.read_text(encoding="utf-8")
    tip, axis = MAKER["read_poses"](text)
    share = np.linspace(0, 1, 5)[:, None, None]
    tips, axes = (one[:-1] + share * np.diff(one, axis=0) for one in (tip, axis))
    centre = tips + 4 * axes / np.linalg.norm(axes, axis=2)[..., None]
    start, way = centre[:-1].reshape(-1, 3), np.diff(centre, axis=0).reshape(-1, 3)
    # the points are on one line of the program each, the first on the line of the first G1
    line = np.arange(len(tip)) + next(k for k, one in enumerate(text.splitlines(), 1) if one.startswith("G1"))
    line[1:] += 1  # F alone
    strip = MAKER["make_strip"](tip, axis)[: len(tip) - 1, :2]  # its right edge, a facet for each move
    touched = 0.5 * (strip[:, 0] + MAKER["make_strip"](tip, axis)[: len(tip) - 1, 2])  # its middle
    for place in (strip[:, 0], touched):
        along = np.clip(((place[:, None] - start) * way).sum(2) / (way * way).sum(1), 0, 1)
        away = np.linalg.norm(place[:, None] - start - along[..., None] * way, axis=2)
        nearest = sweep.find_nearest(motions, place, 2.0, ("cutter",))
        off = nearest.distance - (away.min(axis=1) - 4)
        assert np.abs(off).max() <= 0.01
        assert np.median(np.abs(off)) < 0.002
        own = line[1 + away.argmin(axis=1) % (len(tip) - 1)]
        assert np.abs(motions[0].line[nearest.row] - own).max() <= 1


@pytest.mark.skipif(sweep.load_accelerator() is None, reason="numba is not installed")
def test_the_blade_without_numba(blade, monkeypatch):
    folder, given, setpoints = blade
    arguments = {"nominal": folder / "blade_part.stl", "grid": 2.0, "gouge": 0.05}
    fast = vp.machined(setpoints, SAMPLE, "verne", given, **arguments)
    monkeypatch.setattr(sweep, "load_accelerator", lambda: None)
    monkeypatch.setattr("verne_post.part.bound.load_accelerator", lambda: None)
    plain = vp.machined(setpoints, SAMPLE, "verne", given, **arguments)
    np.testing.assert_allclose(
        plain.judged[0].comparison.deviation, fast.judged[0].comparison.deviation, rtol=0, atol=1e-8
    )
    assert (plain.judged[0].comparison.state == fast.judged[0].comparison.state).all()


def test_a_wrong_call_is_refused(blade):
    folder, given, setpoints = blade
    for wrong in (
        {"gouge": 0},
        {"gouge": True},
        {"system": "G99"},
        {"unit": "yard"},
        {"datum": "guess"},
        {"grid": float("inf")},
    ):
        with pytest.raises(vp.UsageError, match=next(iter(wrong))):
            vp.machined(setpoints, SAMPLE, "verne", given, nominal=folder / "blade_part.stl", **wrong)


def vise(low, high) -> bytes:
    """A block in ASCII."""
    place = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)], dtype=float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    threes = [place[[a, *pair]] for a, b, c, d in quads for pair in ((b, c), (c, d))]
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex %g %g %g\n" % tuple(p) for p in three)
        + "endloop\nendfacet\n"
        for three in threes
    )
    return f"solid vise\n{facets}endsolid vise\n".encode()


def test_fixtures_are_meshes_that_tools_keep_out_of(floor, run):
    """The ball of 4 mm passes at y 5; a jaw from y 9.5 on is 0.5 away, below the holder of 15 mm."""
    Path("vise.stl").write_bytes(vise((-30, 9.5, -40), (30, 30, 10)))
    fixture = (*JUDGE[:-2], "--fixture", "vise.stl@G54")
    answer = run(*fixture)
    assert (answer.code, answer.out) == (0, "")
    # a corner of the path may leave it by 0.001 mm
    assert re.search(r"vise.stl, 12 facets: never nearer than 0 mm; nearest place seen 0\.(499|500) mm", answer.err)
    answer = run(*fixture, "--distance", "1", "--output-format", "json")
    assert (answer.code, codes(answer)) == (1, {"VP215"})
    Path("vise.stl").write_bytes(
        vise((-30, 9.5, -40), (30, 30, 25))
    )  # up to the holder, which begins 20 mm above the tip
    answer = run(*fixture, "--nominal", "part.stl@G54")
    assert answer.code == 1
    assert "VP215 error: the holder of tool 1 goes " in answer.err
    assert "clear of gouges deeper than 0.05 mm" in answer.err
    found = vp.machined(
        Path("axes.csv"),
        Path("part.nc"),
        "verne",
        options(),
        nominal=Path("part.stl"),
        fixtures=[(Path("vise.stl"), "G54")],
    )
    assert {item.code for item in found.findings} == {"VP215"}


def test_a_fixture_must_be_a_body(floor, run):
    Path("vise.stl").write_bytes(plate(-5))
    answer = run(*JUDGE[:-2], "--fixture", "vise.stl@G54")
    assert answer.code == 2
    assert "VP506 error: vise.stl: it is open: 4 edges belong to only one facet" in answer.err
    assert "say what the rows are compared with" in run(*JUDGE[:-2]).err


SETUP = (
    'tool_table = "tools.tbl"\n'
    'tool_shapes = "shapes.toml"\n'
    "[wcs]\n"
    "G54 = [0, 0, 60]\n"
    "[part]\n"
    'nominal = "part.stl"\n'
    'system = "G54"\n'
    "grid_mm = 0.5\n"
)


def test_a_gouge_beside_a_contour_asks_for_the_side_of_its_compensation(files, run):
    Path("part.nc.toml").write_text(SETUP, encoding="utf-8")
    Path("part.stl").write_bytes(plate(0.3))
    head = "G21 G90 G94\nT1 M6\nM3 S1000 G43 H1\nG0 X-25 Y-20 Z10 A0 C0\nG1 Z0 F6000\n"
    for entry, end, side in (
        ("G41 D1 ", "G40 ", ". Check the side of the cutter compensation, G41 of line 6"),
        *[("",) * 3],
    ):
        Path("part.nc").write_text(f"{head}{entry}X-15 Y-4\nX15\n{end}Y-20\nG0 Z30\nM2\n", encoding="utf-8")
        (found,) = (item for item in vp.check(Path("part.nc"), "verne").findings if item.code == "VP218")
        assert found.remedy == (
            f"Compare tool, tool length and work offset with those at the machine{side}. If they are right, change the "
            "motion at the line and place of the message."
        )


def test_a_part_of_the_set_up_is_compared_without_more_words(files, run):
    """`check`, `convert`, `batch`, `report` and Python say the same of the part: clear, then gouged at the line that
    does it.
    """
    Path("part.nc.toml").write_text(SETUP, encoding="utf-8")
    answer = run("check", "part.nc")
    assert answer.code == 0
    assert (
        "part: nominal machine, part where the set-up puts the part: clear of gouges deeper than 0.05 mm" in answer.out
    )
    assert run("convert", "part.nc", "-o", "axes.csv", "--meta", "axes.json", "--quiet").code == 0
    assert "clear of gouges" in json.loads(Path("axes.json").read_text(encoding="utf-8"))["part"][1]
    Path("part.stl").write_bytes(plate(0.3))  # the drawing has 0.3 mm more than the program leaves
    answer = run("check", "part.nc", "--output-format", "json")
    assert (answer.code, codes(answer)) == (1, {"VP218"})
    (found,) = (item for item in vp.check(Path("part.nc"), "verne").findings if item.code == "VP218")
    assert found.value == pytest.approx(0.3, abs=0.001)
    assert 5 <= found.line <= found.last_line <= 27
    before = Path("axes.csv").read_bytes()
    answer = run("convert", "part.nc", "-o", "axes.csv", "--quiet")
    assert (answer.code, Path("axes.csv").read_bytes() == before) == (1, True)
    assert "part.nc:6: VP218 error: the cutter of tool 1 cuts 0.300 mm into part.stl" in answer.err
    assert "explain" not in answer.err  # which compares nothing
    assert run("batch", "part.nc", "-o", "out", "--junit", "out.xml", "--quiet").code == 1
    assert "VP218" in Path("out.xml").read_text(encoding="utf-8")
    if importlib.util.find_spec("jupyter_threejs_sage") is not None:
        assert run("report", "part.nc", "-o", "page.html", "--quiet").code == 1
        assert "into part.stl, by the shortest way out" in Path("page.html").read_text(encoding="utf-8")
    # as much as that may be cut away
    Path("part.nc.toml").write_text(SETUP + "gouge_mm = 0.4\n", encoding="utf-8")
    assert run("check", "part.nc").code == 0


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('nominal = "part.stl"\n', "system"),
        ('nominal = "none.stl"\nsystem = "G54"\n', "none.stl"),
        ('nominal = "tools.tbl"\nsystem = "G54"\n', "VP506"),
        ('nominal = "part.stl"\nsystem = "G99"\n', "G54"),
        ('nominal = "part.stl"\nsystem = "G54"\nunit = "ell"\n', "inch"),
        ('nominal = "part.stl"\nsystem = "G54"\nsearch_mm = 0.1\n', "search_mm 0.1 must not be below"),
        ('nominal = "part.stl"\nsystem = "G54"\ngouge_mm = 0\n', "gouge_mm"),
    ],
)
def test_a_part_of_the_set_up_that_cannot_be_used_is_named(files, run, text, says):
    Path("part.nc.toml").write_text(SETUP.partition("[part]")[0] + "[part]\n" + text, encoding="utf-8")
    answer = run("check", "part.nc")
    assert answer.code != 0
    assert says in answer.out
