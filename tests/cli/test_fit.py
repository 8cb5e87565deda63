"""`fit`: what it proposes is legal, is what the block says, leaves more room, or names what stands in the way."""

import json
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import assemble
from verne_post.app.fit import propose
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.toolpath.margins import list_margin_functions
from verne_post.toolpath.work_offset import UNREACHABLE, PartPoints, Search

from ..builders import SAMPLES

TRAVEL = (SAMPLES / "violates_slider_travel.nc", "--tool-length", 50)
TILTED = (
    "G21 G90 G64\n"
    "G0 X-60 Y-30 Z60 A20 C0\n"
    "G1 X60 F3000\n"
    "G1 Y40 A35 C50\n"
    "G3 X20 Y80 R40\n"
    "G1 X-60 Y-30 A10 C90\n"
    "G0 Z90\n"
    "M2\n"
)
#: A level part beside a vise.
LEVEL = """%
G21 G90 G54
T1 M6
S5000 M3
G0 X-60 Y0 A0 C0
G43 H1 Z50
G0 Z-5
G0 X-20
G1 X20 F900
G0 Y18
G0 X-15 Z-28
G1 X-35 F500
G0 Z-26
G0 X60
G0 Z80
M30
%
"""


def told(answer: Any) -> dict[str, Any]:
    assert answer.code == 0, answer.err + answer.out
    return json.loads(answer.out)


@pytest.fixture(scope="module")
def answers() -> dict[tuple[str, ...], Any]:
    """What was said of the sample that violates, by the words that ask."""
    return {}


@pytest.fixture(scope="module")
def searches() -> dict[str, Any]:
    """What was found, by the program and all that the search is given."""
    return {}


@pytest.fixture
def searched_once(monkeypatch: pytest.MonkeyPatch, searches: dict[str, Any]) -> None:
    """Text and --json tell of one search; that it finds the same again is a test of its own."""

    def search(source: bytes, machine: Any, *given: Any, progress: Any, **more: Any) -> Any:
        key = repr((source, machine.name, given, more))
        if key not in searches:
            searches[key] = propose(source, machine, *given, progress=progress, **more)
        return searches[key]

    assert verne_post.fit is not None  # loaded now, it keeps the name as it is
    monkeypatch.setattr("verne_post.app.fit.propose", search)


@pytest.fixture
def fit_travel(run: Callable[..., Any], answers: dict[tuple[str, ...], Any], searched_once: None) -> Callable[..., Any]:
    """``fit_travel("--json")``: fit the sample that violates; once for the same words, which have the same answer."""

    def ask(*words: str) -> Any:
        if words not in answers:
            answers[words] = run("fit", *TRAVEL, "--wcs", "G54=0,0,420", *words)
        return answers[words]

    return ask


@pytest.fixture
def tilted(tmp_path: Path) -> Path:
    path = tmp_path / "tilted.nc"
    path.write_text(TILTED, encoding="utf-8")
    return path


def test_the_sample_that_violates_converts_where_fit_says(
    tmp_path: Path, run: Callable[..., Any], fit_travel: Callable[..., Any]
) -> None:
    assert run("check", *TRAVEL, "--wcs", "G54=0,0,420").code == 1
    answer = fit_travel()
    assert answer.code == 0
    wcs = re.search(r"--wcs (\S+)", answer.out)
    assert wcs
    table = re.search(
        r"^  (G54 = \[.*\])    \(on the table: under \[wcs\] of the set-up file\)$", answer.out, re.MULTILINE
    )
    assert table
    assert tomllib.loads(table[1]) == {"G54": [float(number) for number in wcs[1].partition("=")[2].split(",")]}
    out = tmp_path / "axes.csv"
    assert run("convert", *TRAVEL, "--wcs", wcs[1], "-o", out).code == 0
    assert run("verify", out, "--against", *TRAVEL, "--wcs", wcs[1]).code == 0
    assert "could not run" in answer.out


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("part.mpf", "G710 G90 T1 D1 M6\nG0 A=0 C=0\nG0 X0 Y0 Z60\nG1 X20 F900\nM30\n"),
        ("part.h", "BEGIN PGM A MM\nL A+0 C+0 FMAX\nL X+0 Y+0 Z+60 FMAX\nL X+20 F900\nM30\nEND PGM A MM\n"),
        ("part.nc", "G21 G90\nG0 X0 Y0 Z60 A0 C0\nG1 X20 F900\nM2\n"),
    ],
)
def test_a_block_is_proposed_where_the_language_has_it(
    tmp_path: Path, run: Callable[..., Any], name: str, text: str
) -> None:
    path = tmp_path / name
    path.write_text(text)
    words = (path, "--tool-length", 80, "--wcs", "G54=0,0,60")
    assert ("G10" in run("fit", *words).out) == (name == "part.nc")
    assert (told(run("fit", *words, "--json"))["block"] is not None) == (name == "part.nc")


@pytest.mark.parametrize("dialect", ["rs274", "fanuc"])
def test_the_dialect_accepts_the_block(tmp_path: Path, run: Callable[..., Any], dialect: str) -> None:
    path, text = tmp_path / "part.nc", "G21 G90 G54\n{}G43.4 H1\nG0 X0 Y0 Z60 A0 C0\nG1 X20 F900\nM30\n"
    options = (path, "--tool-length", 80, "--dialect", dialect)
    if dialect == "rs274":
        text = text.replace("G43.4", "G43")
    path.write_text(text.format(""), encoding="utf-8")
    block = told(run("fit", *options, "--wcs", "G54=0,0,300", "--free", "z", "--json"))["block"]
    assert ("R0" in block.split()) == (dialect == "rs274")
    path.write_text(text.format(f"{block}\n"), encoding="utf-8")
    assert run("check", *options, "--wcs", "G54=0,0,300").code == 0
    path.write_text(text.format(""), encoding="utf-8")
    turned = told(run("fit", *options, "--wcs", "G54=0,0,60,30", "--json"))["block"]
    assert (turned is None) == (dialect == "fanuc")  # no word of Fanuc's G10 turns the part


@pytest.mark.parametrize("senses", ["workpiece", "tool"])
def test_the_block_in_the_program_does_the_same(
    tilted: Path, tmp_path: Path, run: Callable[..., Any], senses: str
) -> None:
    from verne_post.config import list_machine_files

    text = (
        list_machine_files()["verne"]
        .read_text(encoding="utf-8")
        .replace('_positive = "workpiece"', f'_positive = "{senses}"')
    )
    machine = tmp_path / "m.toml"
    machine.write_text(
        text.replace("machine_zero = [0.0, 0.0, 550.0]", "machine_zero = [3.0, -4.0, 540.0]"), encoding="utf-8"
    )
    place = ("--tool-length", 70, "--machine", machine)
    found = told(run("fit", tilted, *place, "--wcs", "G54=5,5,40", "--maximise", "margin", "--json"))
    assert abs(float(found["wcs"].split(",")[-1])) > 1  # the part is turned, or the test says little
    by_option = run("dump", "joints", tilted, *place, "--smoothing", "off", "--wcs", found["wcs"]).out.splitlines()
    with_block = tmp_path / "block.nc"
    with_block.write_text(TILTED.replace("G64", f"G64 {found['block']}"), encoding="utf-8")
    by_block = run("dump", "joints", with_block, *place, "--smoothing", "off").out.splitlines()
    ends = []
    for rows in (by_option, by_block):  # the first and the last row of every line; an arc may have one more in between
        lines: dict[int, list[list[float]]] = {}
        for row in map(json.loads, rows):
            lines.setdefault(row["line"], []).append(list(row["q"].values()))
        ends.append({line: (q[0], q[-1]) for line, q in lines.items()})
    assert ends[0].keys() == ends[1].keys()
    for line, q in ends[0].items():
        p = ends[1][line]
        # a decimal of a micrometre in R and C turns a part of 100 mm by as much
        assert np.abs(np.array(q) - np.array(p)).max() < 1e-6


def test_the_margin_is_larger_than_anywhere_near(tilted: Path) -> None:
    """Against a plain scan of places around and far from the proposal, by judging margins on dense points."""
    machine = verne_post.load_machine()
    options = Options(tool_length=70.0, wcs={1: WorkOffset((5.0, 5.0, 40.0))})
    found = propose(TILTED.encode(), machine, options, "xy", aim="margin")
    assert found.after.smallest > found.before.smallest
    margins, _names = list_margin_functions(machine)
    best = found.after.place
    rng = np.random.default_rng(1)
    for spread in (2.0, 20.0, 120.0):
        for _ in range(40):
            x, y = np.clip(np.array([best.x, best.y]) + rng.uniform(-spread, spread, 2), -160, 160)
            moved = assemble(
                TILTED.encode(), machine, Options(tool_length=70.0, wcs={1: WorkOffset((x, y, 40.0))}, smoothing="off")
            )
            # chords of the arc stand for it; all their places at once
            at = np.concatenate(
                [moved.path.start + u * (moved.path.end - moved.path.start) for u in np.linspace(0, 1, 30)]
            )
            dense = margins(at[:, :3], at[:, 3:], np.full(len(at), 70.0)).min(axis=0)
            # the chord cuts off what the arc needs: a few thousandths of the room
            assert dense[found.after.counts[:-1]].min() <= found.after.smallest + 0.02


def test_places_below_a_floor_are_told_by_few_points() -> None:
    """The others have the rating of all points, wherever the floor is: places out of reach among them."""
    machine = verne_post.load_machine()
    rng = np.random.default_rng(2)
    n = 300
    tip, angles = rng.uniform(-150, 150, (n, 3)), rng.uniform(-0.5, 0.5, (n, 2))
    points = PartPoints(tip, angles, np.full(n, 70.0), np.arange(n), np.zeros(n), np.zeros(n, bool))
    ends = np.array([200.0, 200.0, 300.0, 3.0])
    search = Search(machine, points, np.ones(4, bool), -ends, ends)
    places, rows = rng.uniform(-ends, ends, (400, 4)), np.arange(0, n, 2)
    counts = np.arange(len(search.names)) != 2
    whole = search.rate(places, counts, rows)
    few = search.find_deciding_rows(places[::64], counts, rows)
    assert 0 < len(few) < len(rows) / 4
    assert (whole < UNREACHABLE).any()
    for floor in (*np.quantile(whole, (0.02, 0.5, 0.98)), 0.0):
        found = search.rate_promising(places, counts, rows, few, np.full(len(places), floor))
        assert ((found >= floor) == (whole >= floor)).all()
        assert (found[whole >= floor] == whole[whole >= floor]).all()


def test_the_same_program_has_the_same_fit(tilted: Path, run: Callable[..., Any]) -> None:
    place = ("fit", tilted, "--tool-length", 70, "--wcs", "G54=5,5,40", "--maximise", "margin")
    assert run(*place).out == run(*place).out


def test_what_is_not_free_stays(tilted: Path, run: Callable[..., Any]) -> None:
    found = told(
        run(
            "fit",
            tilted,
            "--tool-length",
            70,
            "--wcs",
            "G54=5,-6,40,12",
            "--free",
            "y",
            "--maximise",
            "margin",
            "--json",
        )
    )
    x, y, z, c = (float(value) for value in found["wcs"].partition("=")[2].split(","))
    assert (x, z, c) == (5.0, 40.0, 12.0)
    assert y != -6.0
    found = told(run("fit", tilted, "--tool-length", 70, "--range", "X=7,9", "--range", "c=-5,5", "--json"))
    x, y, z, c = (float(value) for value in found["wcs"].partition("=")[2].split(","))
    assert 7 <= x <= 9
    assert -5 <= c <= 5


@pytest.mark.usefixtures("without_remedies")
def test_the_smallest_move_is_legal_and_none_near_the_start_is(
    run: Callable[..., Any], fit_travel: Callable[..., Any]
) -> None:
    """Shifts that are a tenth smaller are all refused: against checks of the whole program in twelve directions."""
    found = told(fit_travel("--json"))
    shift, turn = np.array(found["moved"][:3]), found["moved"][3]
    assert turn == 0.0
    assert (np.round(shift, 1) == shift).all()
    assert run("check", *TRAVEL, "--wcs", found["wcs"]).code == 0
    assert 15.0 < np.linalg.norm(shift) < 25.0
    machine = verne_post.load_machine()
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(12, 3))
    ways[0] = shift
    for way in ways:
        x, y, z = np.array([0.0, 0.0, 420.0]) + 0.9 * np.linalg.norm(shift) * way / np.linalg.norm(way)
        assert not verne_post.check(TRAVEL[0], machine, Options(tool_length=50.0, wcs={1: WorkOffset((x, y, z))})).ok


@pytest.mark.usefixtures("searched_once")
@pytest.mark.parametrize(("words", "longest"), [((), 18.8), (("--free", "z"), 39.5), (("--maximise", "margin"), 18.8)])
def test_a_contact_is_left_by_the_move_that_the_check_offers(
    words: tuple[str, ...], longest: float, run: Callable[..., Any], tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """No margin sees the vise: the place of the largest one is in it, and was all that was tried."""
    program = tmp_path / "level.nc"
    program.write_text(LEVEL, encoding="utf-8")
    Path(f"{program}.toml").write_text("[tools]\n1 = { length = 60, diameter = 12 }\n", encoding="utf-8")
    given = (program, "--keep-out", "vise=-60,-40,20,-30,40,70", "--wcs")
    answer = run("fit", *given, "G54=0,0,60", *words)
    assert answer.code == 0
    assert "the smallest move found" in answer.out
    largest = re.search(r"^The place of the largest margin, --wcs (\S+), is refused by the check", answer.out, re.M)
    assert largest is not None, "it is in the vise: it was offered as one that fits"
    request.getfixturevalue("without_remedies")  # from here on only verdicts count
    assert run("check", *given, largest[1]).code == 1
    assert "The largest margin," not in answer.out
    wcs = re.search(r"^  --wcs (\S+)", answer.out, re.MULTILINE)
    assert wcs is not None
    assert run("check", *given, wcs[1]).code == 0
    x, y, z = (float(number) for number in wcs[1].partition("=")[2].split(",")[:3])
    assert 15.0 < np.linalg.norm([x, y, z - 60.0]) < longest
    assert np.abs(np.array([x, y, z]) * 10 - np.round(np.array([x, y, z]) * 10)).max() < 1e-9, "nobody sets hundredths"
    assert "z" not in words or (x, y) == (0.0, 0.0)
    if "margin" in words:
        refused = told(run("fit", *given, "G54=0,0,60", *words, "--json"))["refused"]
        assert f"--wcs {refused}, is refused by the check" in answer.out
        assert refused == largest[1]


def test_what_it_says_of_the_largest_margin_is_what_it_finds_when_asked(fit_travel: Callable[..., Any]) -> None:
    by_move, by_margin = told(fit_travel("--json")), told(fit_travel("--maximise", "margin", "--json"))
    assert by_margin["wcs"] == by_move["largest_margin"]["wcs"] != by_move["wcs"]
    assert by_margin["moved"] == by_move["largest_margin"]["moved"]
    assert min(item["after"] for item in by_margin["margins"]) == by_move["largest_margin"]["margin"] > 0.6
    said = fit_travel().out
    assert re.search(r"fits if the part is moved by \S+, \S+, \S+ mm, the smallest move found:\n  --wcs G54=", said)
    found = "The largest margin, 0.686, is with the part moved by -185.3, 167.9, -439.6 mm, turned by 142.214 deg"
    assert found in said


def test_a_part_that_may_stay_stays(tilted: Path, run: Callable[..., Any]) -> None:
    answer = run("fit", tilted, "--tool-length", 70, "--wcs", "G54=5,5,40")
    assert "fits where the part is:\n  --wcs G54=5,5,40,0" in answer.out
    assert "(--maximise margin)" in answer.out
    outside = told(run("fit", tilted, "--tool-length", 70, "--wcs", "G54=5,5,40", "--range", "x=7,9", "--json"))
    assert outside["moved"] == [2.0, 0.0, 0.0, 0.0]


def test_a_part_is_turned_where_no_shift_will_do(tmp_path: Path, run: Callable[..., Any]) -> None:
    program = tmp_path / "p.nc"
    program.write_text("G21 G90\nG0 X0 Y0 Z60 A0 C250\nG1 X9 A30 F900\nM2\n", encoding="utf-8")
    text = (Path(__file__).parents[2] / "machine_configs" / "verne.toml").read_text(encoding="utf-8")
    machine = tmp_path / "m.toml"
    machine.write_text(text.replace("# c_deg absent: unlimited", "c_deg = [-200.0, 200.0]"), encoding="utf-8")
    found = told(run("fit", program, "--tool-length", 70, "--machine", machine, "--wcs", "G54=0,0,60", "--json"))
    assert found["moved"][:3] == [0.0, 0.0, 0.0]
    assert found["moved"][3] == pytest.approx(50.0, abs=0.1)


def test_least_time_is_no_longer(tmp_path: Path, run: Callable[..., Any]) -> None:
    """Rapids of the table bind here; another place of the part needs less of them."""
    program = tmp_path / "p.nc"
    rows = "".join(f"G1 X{60 * (k % 2)} Y{5 * k} A{20 * (k % 2)} F8000\n" for k in range(12))
    program.write_text(f"G21 G90 G64\nG0 X0 Y0 Z60 A0 C0\n{rows}M2\n", encoding="utf-8")
    found = told(run("fit", program, "--tool-length", 70, "--wcs", "G54=60,60,80", "--minimise", "time", "--json"))
    assert found["seconds"]["after"] <= found["seconds"]["before"] * 1.001
    assert all(item["after"] >= 0 for item in found["margins"])


def test_a_dry_run_is_fitted_where_it_is_lifted(tmp_path: Path, run: Callable[..., Any]) -> None:
    path = tmp_path / "air.nc"
    path.write_text(
        "G21 G90 G94\nG0 X40 Y-30 Z50 A20 C30\nG1 X60 Y10 Z40 A25 C50 F800\nG1 X10 Y40 Z60 A-15 C90\nM2\n",
        encoding="utf-8",
    )
    words = ("--tool-length", "80", "--wcs", "G54=10,-20,30,15", "--range", "z=0,500")
    found = []
    for more in ((), ("--air", "500", "--air-along", "table")):
        answer = run("fit", path, *words, *more, "--maximise", "margin")
        assert answer.code == 0, answer.out
        found += re.findall(r"^  --wcs (\S+)", answer.out, re.MULTILINE)
    assert found[0] != found[1]
    assert (
        run("check", path, "--tool-length", "80", "--wcs", found[1], "--air", "500", "--air-along", "table").code == 0
    )


def test_an_impossible_program_is_refused_with_the_axis(tmp_path: Path, run: Callable[..., Any]) -> None:
    program = tmp_path / "p.nc"
    program.write_text("G21 G90\nG0 X0 Y0 Z60 A0 C0\nG1 A130 F900\nM2\n", encoding="utf-8")
    answer = run("fit", program, "--tool-length", 100)
    assert answer.code == 1
    assert "no work offset was found with which it fits" in answer.out
    assert re.search(
        r"p\.nc:3: VP102 error: joint a reaches 1\d\d\.\d+ deg, \S+ deg above its travel of -95 to 95 deg", answer.out
    )
    blocked = json.loads(run("fit", program, "--tool-length", 100, "--json").out)
    assert not blocked["fits"]
    assert ("VP102", "a") in [(item["code"], item["axis"]) for item in blocked["blocked_by"]]


def test_a_part_whose_zero_is_at_its_edge_is_sought_with_its_middle_over_the_table(
    tmp_path: Path, run: Callable[..., Any]
) -> None:
    """From X0 to X350 on a table of radius 200: the zero was sought within 20 mm of the centre, and none was found."""
    program = tmp_path / "edge.nc"
    program.write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X350 F3000\nZ-0.5\nM2\n", encoding="utf-8")
    given = ("--machine", "ac_trunnion", "--tool-length", 100, "--wcs")
    assert run("check", program, *given, "G54=0,0,3").code == 1
    for words in ((), ("--free", "xyz"), ("--maximise", "margin")):
        found = told(run("fit", program, *given, "G54=0,0,3", "--json", *words))
        assert found["fits"], words
        assert run("check", program, *given, found["wcs"]).code == 0
        x, y, _z, turn = (float(word) for word in found["largest_margin"]["wcs"].partition("=")[2].split(","))
        middle = x + 175 * np.cos(np.radians(turn)), y + 175 * np.sin(np.radians(turn))
        assert np.abs(middle).max() < 175.1, "over the table, or where it is now"
    assert [float(word) for word in found["wcs"].partition("=")[2].split(",")] != [0, 0, 3, 0]
    fixed = run("fit", program, *given, "G54=0,0,3", "--free", "z").out
    assert "travel of x is -0.167 in line 3 at every place that was searched.\nSmallest of the other margins" in fixed


def test_a_part_that_is_too_large_is_refused(tmp_path: Path, run: Callable[..., Any]) -> None:
    program = tmp_path / "p.nc"
    program.write_text("G21 G90\nG0 X-600 Y0 Z60 A0 C0\nG1 X600 F900\nM2\n", encoding="utf-8")
    answer = run("fit", program, "--tool-length", 100)
    assert answer.code == 1
    assert re.fullmatch(
        r"\S+ on VERNE: no work offset was found with which it fits\.\n"
        r"Searched: x -?[\d.]+ to [\d.]+ mm, .* deg\. --range x=LOW,HIGH searches elsewhere\.\n"
        r"What is cut reaches 590\.6 mm from its middle, X 9\.4 Y 0\.0 of the part, and the radius of the table "
        r"is 250 mm: the middle was sought .*, x -25\.0 to 25\.0, y -25\.0 to 25\.0 mm from the rotary centre "
        r"on the table face\.\n"
        r"The closest one, --wcs \S+, is blocked by:\n(  \S+: VP\d+ error: .*\n)+",  # no rows of "no reach"
        answer.out,
    )


def test_places_in_machine_coordinates_do_not_follow(tmp_path: Path, run: Callable[..., Any]) -> None:
    """A retract to machine Z 0 stays where it is; the offset is still found, and judged with it."""
    program = tmp_path / "p.nc"
    program.write_text(TILTED.replace("G0 Z90", "G53 G0 Z0"), encoding="utf-8")
    found = told(run("fit", program, "--tool-length", 70, "--wcs", "G54=5,5,40", "--json"))
    assert run("check", program, "--tool-length", 70, "--wcs", found["wcs"]).code == 0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TILTED.replace("G0 Z90", "G55 G0 X0 Y0 Z90"), "this program uses G54, G55"),
        ("G21 G90 G10 L2 P1 X0 Y0 Z-500\nG0 X0 Y0 Z60 A0 C0\nG1 X9 F99\nM2\n", "the program sets its own offset"),
        ("G21 G90\nM2\n", "contains no motion"),
    ],
)
def test_programs_that_cannot_be_fitted(tmp_path: Path, run: Callable[..., Any], text: str, said: str) -> None:
    program = tmp_path / "p.nc"
    program.write_text(text, encoding="utf-8")
    answer = run("fit", program, "--tool-length", 70)
    assert answer.code == 2
    assert said in answer.err


def test_a_text_in_utf_16_is_told_as_everywhere(tmp_path: Path, run: Callable[..., Any]) -> None:
    path = tmp_path / "utf16.nc"
    path.write_bytes(TILTED.encode("utf-16"))
    answer = run("fit", path, "--tool-length", 70)
    assert "text in UTF-16; save it as UTF-8" in answer.err
    with pytest.raises(verne_post.InputError, match="text in UTF-16"):
        verne_post.fit(path, "verne", Options(tool_length=70.0))


def test_a_range_without_the_present_offset_holds(tilted: Path, run: Callable[..., Any]) -> None:
    """The place of now is no answer where it lies outside of what is asked for."""
    wcs = ("--wcs", "G54=5.00012,5,40")
    found = told(run("fit", tilted, "--tool-length", 70, *wcs, "--free", "y", "--range", "y=60,62", "--json"))
    x, y, _z, c = (float(value) for value in found["wcs"].partition("=")[2].split(","))
    assert 60 <= y <= 62
    assert (x, c) == (5.00012, 0.0)  # what is not free is not rounded


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--minimise", "time", "--maximise", "margin"), "exclude each other"),
        (("--free", "xq"), "expected some of the letters x, y, z, c"),
        (("--free", ""), "expected some of the letters"),
        (("--range", "x=3"), "--range x=3: expected x=LOW,HIGH in mm, such as x=-50,50"),
        (("--range", "x"), "--range x: expected LETTER=LOW,HIGH"),
        (("--range", "x=9,3"), "the lower one comes first"),
        (("--range", "x=1,2", "--range", "x=3,4"), "x is given twice"),
        (("--free", "xy", "--range", "z=1,2"), "none of the free coordinates x, y"),
    ],
)
def test_bad_options(tilted: Path, run: Callable[..., Any], words: tuple[str, ...], said: str) -> None:
    answer = run("fit", tilted, "--tool-length", 70, *words)
    assert answer.code == 2
    assert said in answer.err


#: A place of the part where a program does not fit, by machine: linear axes end, rods and struts do not reach.
WITHOUT_TABLE = {
    "ca_fork_head": (4100.0, 1200.0, 0.0),
    "nutating_head": (2050.0, 0.0, -100.0),
    "ab_table": (400.0, 150.0, 150.0),
    "tricept": (900.0, 900.0, 300.0),
    "george_v": (500.0, 500.0, 100.0),
    "hexapod": (620.0, 600.0, 300.0),
    "hexam": (560.0, 500.0, 200.0),
    "hexaglide": (320.0, 500.0, 250.0),
}


@pytest.mark.usefixtures("without_remedies")
@pytest.mark.parametrize("name", WITHOUT_TABLE)
def test_a_part_that_no_joint_turns_is_moved_as_little_as_fits(
    tmp_path: Path, run: Callable[..., Any], name: str
) -> None:
    """The place is legal by option and by block, to the same rows; shifts that are a tenth smaller are refused."""
    words = "A12 B20" if name == "ab_table" else "A12 C20"
    start = words.replace("12", "3").replace("20", "0")
    text = f"G21 G90 G94\nG0 X0 Y0 Z60 {start} F2000\nG1 X40 Y20 Z40 {words}\nM2\n"
    program, block = tmp_path / "p.nc", tmp_path / "block.nc"
    program.write_text(text, encoding="utf-8")
    place = WITHOUT_TABLE[name]
    given = ("--tool-length", 80, "--machine", name)
    found = told(run("fit", program, *given, "--wcs", f"G54={','.join(map(str, place))}", "--json"))
    shift = np.array(found["moved"][:3])
    assert found["moved"][3] == 0.0
    assert found["wcs"].count(",") == 2
    assert np.linalg.norm(shift) > 1.0
    out = tmp_path / "axes.csv"
    assert run("convert", program, *given, "--wcs", found["wcs"], "-o", out).code == 0
    assert run("verify", out, "--against", program, *given, "--wcs", found["wcs"]).code == 0
    block.write_text(text.replace("G94", f"G94 {found['block']}"), encoding="utf-8")
    by_option, by_block = (
        np.array([list(json.loads(row)["q"].values()) for row in run("dump", "joints", *one).out.splitlines()])
        for one in ((program, *given, "--wcs", found["wcs"]), (block, *given))
    )
    assert np.abs(by_option - by_block).max() < 1e-6
    machine = verne_post.load_machine(name)
    ways = np.random.default_rng(5).normal(size=(6, 3))
    ways[0] = shift
    for way in ways:
        x, y, z = np.array(place) + 0.9 * np.linalg.norm(shift) * way / np.linalg.norm(way)
        assert not verne_post.check(text, machine, Options(tool_length=80.0, wcs={1: WorkOffset((x, y, z))})).ok


@pytest.mark.parametrize("words", [("--free", "xc"), ("--range", "c=-5,5")])
def test_a_part_that_no_joint_turns_has_no_free_turn(
    tilted: Path, run: Callable[..., Any], words: tuple[str, ...]
) -> None:
    answer = run("fit", tilted, "--tool-length", 80, "--machine", "hexapod", *words)
    assert answer.code == 2
    assert "VP018 error: c cannot be free: no joint of this machine turns the part about its z" in answer.err


def test_fit_names_the_line_in_machine_coordinates(run: Callable[..., Any], tmp_path: Path) -> None:
    """No offset helps it: none is proposed, the part stays, and the margins are said to be those of the others."""
    path = tmp_path / "part.nc"
    path.write_text("G21 G90 G94 G54\nG0 A0 C0\nG0 X0 Y0 Z50.\nG1 X10. F500\nG53 G0 Z500.\nM30\n", encoding="utf-8")
    given = ("--machine", "ac_trunnion", "--tool-length", 100)
    refused = run("fit", path, *given, "--wcs", "G54=0,0,200")
    assert refused.code == 1
    assert "line 5 is in machine coordinates, and no work offset helps" in refused.out
    assert "Without the lines in machine coordinates:\nSmallest margin" in refused.out
    assert "no work offset was found" not in refused.out and "closest" not in refused.out
    answer = json.loads(run("fit", path, *given, "--wcs", "G54=0,0,200", "--json").out)
    assert (answer["fixed_lines"], answer["moved"]) == ([5], [0.0, 0.0, 0.0, 0.0])
    # what follows the offset and leaves the machine too is moved, and told apart
    both = run("fit", path, *given, "--wcs", "G54=300,0,200")
    assert "line 5 is in machine coordinates" in both.out and "With --wcs G54=" in both.out
    path.write_text(path.read_text("utf-8").replace("Z500.", "Z150."), encoding="utf-8")
    assert json.loads(run("fit", path, *given, "--wcs", "G54=0,0,200", "--json").out)["fixed_lines"] == []


def test_fit_and_explain_name_the_line_that_gave_a_kept_angle(run: Callable[..., Any], tmp_path: Path) -> None:
    """Neither sends to the other: A of line 3 is what is wrong in line 5, and explain has no values for line 5."""
    path = tmp_path / "kept.nc"
    path.write_text("G21 G90 G94 G54\nG0 X0 Y0 Z50 A0 C0\nG1 X20 A105 F1000\nG49\nG0 G53 Z0\nM30\n", encoding="utf-8")
    given = ("--tool-length", 60, "--wcs", "G54=-246,-247,290,48")
    kept = "ine 5 keeps A 105 of line 3: correct line 3 first"
    said = run("fit", path, *given, "--free", "z", "--range", "z=289,291").out
    assert f"no work offset helps. L{kept}." in said and "verne-post explain" not in said
    said = run("explain", f"{path}:5", "--tool-length", 60, "--wcs", "G54=0,0,60").out
    assert f"l{kept}" in said and "verne-post fit" not in said
