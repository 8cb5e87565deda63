"""Findings for people: one for each cause, and nothing that is broken goes untold."""

import json
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.output.causes import find_causes
from verne_post.output.findings import format_outcome


def break_limit(joint: str, value: float, first: int, last: int, code: str = "VP101", **more: object) -> Finding:
    """A finding of a joint below 50 mm or above 1250 mm."""
    limit, side = (50.0, "below") if value < 50 else (1250.0, "above")
    text = f"{joint} {value:.6f} mm is {side} {limit:g} mm by {abs(value - limit):.6f} mm"
    where = {"line": first, "last_line": last, "worst_line": first, "axis": joint}
    return make_finding(code, text, value=value, limit=limit, unit="mm", severity="error", **where, **more)


def name_groups(findings: list[Finding]) -> list[list[int]]:
    """Places of the findings of each cause, the one that is shown first."""
    causes = find_causes(findings)
    assert all([findings[index] for index in cause.indices[1:]] == list(cause.others) for cause in causes)
    return [list(cause.indices) for cause in causes]


def test_one_limit_in_three_stretches_is_one_cause() -> None:
    found = [break_limit("rho2", value, line, line + 2) for value, line in ((40.0, 3), (10.0, 20), (30.0, 40))]
    [cause] = find_causes(found)
    assert cause.first == found[0]
    assert cause.describe_others() == "rho2 by 40.000 mm in lines 20 to 22 (worst of 2 places)"
    assert format_outcome("a.nc", tuple(found)) == "a.nc: refused: 1 error, 0 warnings"


def test_joints_in_the_same_lines_are_one_cause_and_others_are_not() -> None:
    found = [
        break_limit("rho1", 40.0, 3, 9),
        break_limit("rho2", 20.0, 9, 12),  # shares line 9 with rho1
        break_limit("rho3", 1260.0, 30, 31),  # elsewhere
        break_limit("rho1", 45.0, 50, 50),  # the limit of the first
        break_limit("a", 99.0, 3, 9, code="VP102"),  # another code
        make_finding("VP216", "tool cuts the stock 1.5 mm deep", line=4, last_line=4),
        make_finding("VP216", "tool cuts the stock 2.5 mm deep", line=8, last_line=8),  # each contact is a mistake
    ]
    assert name_groups(found) == [[0, 1, 3], [2], [4], [5], [6]]
    others = "rho2 by 30.000 mm in lines 9 to 12; rho1 by 5.000 mm in line 50"
    assert find_causes(found)[0].describe_others() == others


def test_warnings_on_the_way_back_from_a_place_far_too_low_are_no_mistakes_of_their_own() -> None:
    """`G1 Z-3000`: the retract comes near the singularity of a rod. An error, or a warning elsewhere, stays alone."""
    low = make_finding("VP210", "tip 2960.0 mm below the table face", line=8, last_line=11, value=-2960.0, limit=0.0)
    drop = replace(break_limit("rho2", 26.0, 11, 11, code="VP202"), severity="warning")
    assert name_groups([low, drop]) == [[0, 1]]
    assert name_groups([low, replace(drop, severity="error")]) == [[0], [1]]
    assert name_groups([low, replace(drop, line=12, last_line=12)]) == [[0], [1]]
    turn = make_finding("VP301", "C turns by 400 deg", severity="warning", line=9, last_line=9)  # has no value
    assert name_groups([low, turn]) == [[0, 1]]  # the warning came first, and a refused program had no error


def test_one_z_too_low_is_one_cause() -> None:
    """`G1 Z-220` was the travel of z and the height over the table, as two errors; elsewhere they are two."""
    low = make_finding("VP210", "tip 160.0 mm below the table face", line=7, last_line=8, value=-160.0, limit=0.0)
    found = [break_limit("z", -100.0, 7, 8), low, break_limit("z", 1260.0, 30, 30)]
    assert name_groups(found) == [[1, 0], [2]]
    assert find_causes(found)[0].describe_others() == "z by 150.000 mm in lines 7 to 8"
    apart = replace(low, line=20, last_line=20)
    assert name_groups([break_limit("z", -100.0, 7, 8), apart]) == [[0], [1]]


def test_holes_with_one_r_too_low_are_one_cause() -> None:
    """R-2 of G83 was an error in each line of holes; a contact farther on, or of another depth, has its own."""
    found = [
        make_finding(
            "VP216",
            f"the cutter runs into the stock: this begins {60.0 + line:.1f} mm along line {line}; {depth:.3f} mm",
            line=line,
            last_line=line,
            value=-depth,
            limit=0.0,
        )
        for line, depth in ((7, 2.0), (8, 2.0), (9, 2.0), (10, 3.0), (14, 2.0))
    ]
    assert name_groups(found) == [[0, 1, 2], [3], [4]]
    assert find_causes(found)[0].describe_others() == "by 2.000000 in line 8 (worst of 2 places)"


def test_the_drop_of_a_rod_is_not_the_travel_of_its_slider() -> None:
    """Both were told as "rho1", with other numbers."""
    head = make_finding("VP110", "out of reach", line=3, last_line=9, severity="error")
    drop = break_limit("rho1", 30.0, 4, 4, code="VP202")
    drop = replace(drop, quantity="vertical drop of a rod (rho1)")
    [cause] = find_causes([head, break_limit("rho1", 40.0, 5, 5), drop])
    others = ("vertical drop of a rod (rho1) by 20.000 mm in line 4", "rho1 by 10.000 mm in line 5")
    assert sorted(cause.describe_others().split("; ")) == sorted(others)


def test_what_only_a_rotary_axis_beyond_its_travel_breaks_belongs_to_it() -> None:
    """B-120 where B ends at -35 was three errors, the slider first, with a move of the part as its remedy."""
    move = "within limits if the part is moved by 30 mm"
    found = [
        break_limit("z", 20.0, 10, 11, remedies=(move,)),
        break_limit("b", -120.0, 10, 11, code="VP102", remedies=("within limits if the line ends at B -34.999",)),
        make_finding("VP301", "the table changes to its other position", line=11, last_line=11, severity="error"),
    ]
    [cause] = find_causes(found)
    assert cause.first.axis == "b"
    assert cause.first.remedies == ("within limits if the line ends at B -34.999",)
    assert (
        cause.describe_others()
        == "z by 30.000 mm in lines 10 to 11; VP301 (flip, rewind or large turn of the rotary axes) in line 11"
    )
    # so has a place that is out of reach: what the lines break on their way there
    lost = make_finding("VP110", "out of reach", line=9, last_line=11, severity="error")
    assert name_groups([lost, found[0]]) == [[0, 1]]
    assert name_groups([lost, found[0], break_limit("z", 10.0, 40, 41)]) == [[0], [1, 2]]
    # a limit that is broken in other lines, too, has a cause of its own
    assert name_groups([*found, break_limit("z", 10.0, 40, 41)]) == [[0, 3], [1, 2]]
    assert name_groups([found[1], break_limit("z", 10.0, 9, 11)]) == [[0], [1]]
    # of two stretches beyond the travel the right one
    two = [found[1], break_limit("c", -400.0, 30, 60, code="VP103"), break_limit("z", 10.0, 31, 32)]
    assert name_groups(two) == [[0], [1, 2]]


def test_below_and_above_are_two_limits() -> None:
    assert len(find_causes([break_limit("x", 40.0, 3, 3), break_limit("x", 1260.0, 9, 9)])) == 2


def test_warnings_stay_apart_from_errors_and_many_are_counted() -> None:
    found = [break_limit("rho1", 40.0 - n, 3 * n, 3 * n) for n in range(1, 9)]
    warned = make_finding("VP202", found[0].message, line=3, last_line=3, axis="rho1", severity="warning")
    first, second = find_causes([*found, warned])
    assert second.first == warned
    assert first.describe_others() == "rho1 by 18.000 mm in line 24 (worst of 7 places)"


def test_a_remedy_is_told_once() -> None:
    moved, turned = "within limits if the part is moved", "line 9 alone: another turn"
    found = [
        break_limit("rho1", 40.0, 3, 3, remedies=(moved,)),
        make_finding("VP210", "tip 5.0 mm below", line=9, last_line=9, remedies=(moved, turned)),
    ]
    assert [cause.first.remedies for cause in find_causes(found)] == [(moved,), ("as for VP101 in line 3", turned)]


@pytest.mark.parametrize("seed", range(20))
def test_every_finding_is_in_one_cause(seed: int) -> None:
    """Against a plain search for what hangs together, in findings at random."""
    rng = random.Random(seed)
    found = []
    for _ in range(30):
        line = rng.randint(1, 80)
        found.append(break_limit(rng.choice("xyz"), rng.choice((40.5, 1260.5)), line, line + rng.randint(0, 3)))
    left, expected = set(range(30)), []
    while left:
        group, waiting = set(), [min(left)]
        while waiting:
            one = waiting.pop()
            group.add(one)
            a = found[one]
            for other in left - group:
                b = found[other]
                same = (a.axis, a.limit) == (b.axis, b.limit)
                if same or (a.line <= b.last_line and b.line <= a.last_line):
                    waiting.append(other)
        left -= group
        expected.append(sorted(group))
    assert sorted(sorted(group) for group in name_groups(found)) == expected


PROGRAM = """G21 G90 G94 G49
G0 X0 Y0 Z50 A0 C0
G1 X10 F2000
G0 Z120
X20
G1 Z50
Y10
G0 Z130
Y20
M2
"""


def test_a_part_zero_that_is_too_high_is_one_error(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both retracts leave the travel of two sliders: four findings for programs, one for people, with the cure."""
    monkeypatch.chdir(tmp_path)
    Path("part.nc").write_text(PROGRAM, encoding="utf-8")
    words = ("part.nc", "--tool-length", "60", "--wcs", "G54=0,0,600")
    exact = json.loads(run("check", *words, "--output-format", "json").out)["programs"][0]["findings"]
    assert {item["code"] for item in exact} == {"VP101"}
    assert len(exact) >= 4
    text = run("check", *words).out
    assert text.count("VP101 error") == 1
    assert "= also " in text
    assert "refused: 1 error, 0 warnings" in text
    place = text.partition("(then ")[2].partition(")")[0].replace(" ", "")
    assert run("check", *words[:-1], place).code == 0
    for output_format in ("markdown", "github", "junit"):
        assert "also " in run("check", *words, "--output-format", output_format).out
    assert run("convert", *words).err.count("VP101 error") == 1


def test_a_z_too_deep_for_fixture_and_table_is_one_cause():
    """VP210 and VP215 of one Z had the same remedy."""
    edit = Remedy("Z -39.9 in place of -65", "-39.9", line=6, word=("Z", -65.0))
    table = make_finding("VP210", "below", line=6, last_line=7, value=-5.0, limit=0.0, unit="mm", edits=(edit,))
    vise = make_finding("VP215", "vise", line=6, last_line=7, value=-25.0, limit=0.0, unit="mm", edits=(edit,))
    (cause,) = find_causes([table, vise])
    assert (cause.first.code, cause.describe_others()) == (
        "VP215",
        "VP210 (below the table face) by 5.000 mm in lines 6 to 7",
    )
    other = Remedy("X 5 in place of 9", "5", line=6, word=("X", 9.0))
    assert len(find_causes([table, replace(vise, edits=(other,))])) == 2


def test_a_lost_point_and_what_it_leads_to_are_one_cause() -> None:
    """Other words without a point, in other lines or many of them, are a question of their own."""
    text = "{} has no decimal point, and words of line 6 have one: it is read as 1050 mm; write the point"
    bare = make_finding("VP038", text.format("Y1050"), line=10, last_line=10, worst_line=10)
    reach = make_finding("VP110", "out of reach", line=10, last_line=12, worst_line=10)
    arc = make_finding("VP008", "radius 5 mm at the start (X20 Y1050), 9 mm at the end", line=11, last_line=11)
    other_arc = make_finding("VP008", "radius 5 mm at the start (X20 Y105), 9 mm at the end", line=11, last_line=11)
    many = make_finding("VP038", text.format("3 words (Y1050 first; lines 10 to 13)"), line=10, last_line=10)
    assert name_groups([bare, reach]) == name_groups([bare, arc]) == [[1, 0]]
    (cause,) = find_causes([bare, reach])
    assert cause.first.code == "VP110"
    assert cause.describe_others() == "VP038 (Y1050 has no decimal point, and words of line 6 have one) in line 10"
    for apart in ([bare, other_arc], [many, reach], [bare, replace(reach, line=11, worst_line=11)]):
        assert name_groups(apart) == [[0], [1]]
    assert name_groups([bare, replace(reach, severity="warning", code="VP202")]) == [[0], [1]]
