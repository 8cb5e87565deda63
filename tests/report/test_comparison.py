"""The page of two programs: lines that belong together, and the numbers of each side against those of its own
conversion.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import verne_post
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.report.alignment import Stretch, align_lines
from verne_post.report.comparison import make_side, write_comparison
from verne_post.report.markup import escape_names
from verne_post.report.study import study

from ..builders import MACHINE

OPTIONS = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 40.0))})
BEFORE = (
    "N10 G21 G90 G64 P0.01\n"
    "(RIM)\n"
    "N20 G0 X0 Y0 Z0 A0 C0\n"
    "N30 G1 X20 F1200\n"
    "N40 Y20\n"
    "(SIDE)\n"
    "N50 X0 F600\n"
    "N60 Y0\n"
    "N70 M2\n"
)
#: Renumbered; one block is faster, one is new.
AFTER = (
    "N5 G21 G90 G64 P0.01\n"
    "(RIM)\n"
    "N6 G0 X0 Y0 Z0 A0 C0\n"
    "N7 G1 X20 F2400\n"
    "N8 X22\n"
    "N9 Y20\n"
    "(SIDE)\n"
    "N10 X0 F600\n"
    "N11 Y0\n"
    "N12 M2\n"
)
LINES = st.lists(st.sampled_from([b"X1", b"N10 X1", b"X2", b"X3", b" X3", b"Y1", b"Y2", b"Z9", b""]), max_size=14)


def text_of(page: str) -> str:
    """What a person reads: cells between bars."""
    body = re.sub(r"(?s)<style>.*?</style>|<script.*?</script>", "", page)
    return re.sub(r"\|[|\s]*", "|", re.sub("<[^>]*>", "|", body))


def compare(before: str, after: str, one: Options = OPTIONS, other: Options = OPTIONS) -> str:
    sides = [
        make_side(name, text.encode(), MACHINE, study(text.encode(), MACHINE, options))
        for name, text, options in (("a.nc", before, one), ("b.nc", after, other))
    ]
    return write_comparison((sides[0], sides[1]))


@given(LINES, LINES)
def test_stretches_cover_both_texts_and_equal_ones_are_equal(a: list[bytes], b: list[bytes]) -> None:
    at_a = at_b = 0
    before = None
    for one in align_lines(a, b):
        assert (one.first_a, one.first_b) == (at_a, at_b)
        at_a, at_b = one.last_a, one.last_b
        assert at_a > one.first_a or at_b > one.first_b
        if one.same:
            plain = [
                [re.sub(rb"^\s*N\d+", b"", line).strip() for line in lines]
                for lines in (a[one.first_a : at_a], b[one.first_b : at_b])
            ]
            assert plain[0] == plain[1]
        assert before is not one.same
        before = one.same
    assert (at_a, at_b) == (len(a), len(b))
    assert all(one.same for one in align_lines(a, a))


def test_lines_that_moved_past_new_ones_belong_together() -> None:
    assert align_lines(BEFORE.encode().split(b"\n"), AFTER.encode().split(b"\n")) == [
        Stretch(True, 0, 3, 0, 3),
        Stretch(False, 3, 4, 3, 5),
        Stretch(True, 4, 10, 5, 11),
    ]
    # every second line of a long program has changed: sorting, not searching
    a = [b"X%d" % k for k in range(60_000)]
    b = [line if k % 2 else line + b" F9" for k, line in enumerate(a)]
    assert sum(one.same for one in align_lines(a, b)) == 30_000


def test_times_of_both_sides_are_those_of_their_rows() -> None:
    page = text_of(compare(BEFORE, AFTER))
    rows = [verne_post.convert(text.encode(), MACHINE, OPTIONS).setpoints for text in (BEFORE, AFTER)]
    assert rows[0] is not None
    assert rows[1] is not None
    of_line = [MACHINE.cycle * np.bincount(one.line[1:], minlength=12) for one in rows]
    whole = [times.sum() for times in of_line]
    assert re.search(rf"\|time, s\|{whole[0]:.3f}\|{whole[1]:.3f}\|{whole[1] - whole[0]:+.3f}\|", page)
    # line 4 became lines 4 and 5
    changed = [of_line[0][4], of_line[1][4:6].sum()]
    assert re.search(
        r"\|A, line 4\|N30 G1 X20 F1200\|B, lines 4 to 5\|N7 G1 X20 F2400\|N8 X22"
        rf"\|{changed[0]:.3f}\|{changed[1]:.3f}\|{changed[1] - changed[0]:+.3f}\|",
        page,
    )
    # the answer is on top
    share = f"{100.0 * (whole[1] / whole[0] - 1.0):+.1f} %"
    difference = whole[1] - whole[0]
    words = f"{abs(difference):.3f} s {'longer' if difference > 0 else 'less'} than A"
    assert page.index(f"|B takes {words}: {whole[1]:.3f} s against {whole[0]:.3f} s ({share})|") < page.index("|What")
    assert page.index("|one line differs: 4|") < page.index("|time, s|")
    # line 5 of the one is line 6 of the other: its text is the same, its time is not (22 mm to go, and no rest of
    # F1200)
    assert abs(of_line[1][6] - of_line[0][5]) > 1e-3
    two = rf"{of_line[0][5]:.3f}\|{of_line[1][6]:.3f}"
    assert re.search(rf"\|A, line 5\|N40 Y20\|B, line 6\|the same text\|{two}\|", page)
    # operations are paired by their remarks
    rim = [of_line[0][1:6].sum(), of_line[1][1:7].sum()]
    assert re.search(rf"\|no tool named: RIM\|{rim[0]:.3f}\|{rim[1]:.3f}\|{rim[1] - rim[0]:+.3f}\|", page)


def test_differences_are_those_of_the_times_that_are_shown() -> None:
    slower = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 40.0))}, override=0.8)
    page = text_of(compare(BEFORE, AFTER, other=slower))
    found = re.findall(r"\|(\d+\.\d{3})\|(\d+\.\d{3})\|([+-]\d+\.\d{3}|same)\|", page)
    assert len(found) > 10
    assert [
        row for row in found if round(float(row[1]) - float(row[0]), 3) != (0.0 if row[2] == "same" else float(row[2]))
    ] == []


def test_a_line_that_is_cut_says_so() -> None:
    page = text_of(compare(BEFORE, AFTER.replace("(SIDE)", f"(SIDE {'x' * 83})").replace("(RIM)", f"(RIM {'y' * 86})")))
    assert f"|(SIDE {'x' * 83})|" in page  # 90 characters
    assert f"|(RIM {'y' * 82}...|" in page


def test_of_many_operations_those_that_differ_most_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """A page of 20,000 operations on both sides would open in ten seconds."""
    monkeypatch.setattr("verne_post.report.comparison.OPERATIONS", 2)
    feeds = ([600] * 6, [600, 1200, 601, 602, 2400, 603])
    before, after = (
        "G21 G90\nG0 X0 Y0 Z0 A0 C0\n"
        + "".join(f"(CUT {k})\nG1 X{10 * (k % 2)} F{feed}\n" for k, feed in enumerate(each, start=1))
        + "M2\n"
        for each in feeds
    )
    page = (
        text_of(compare(before, after)).partition("|Time by tool and operation|")[2].partition("|Lines that differ")[0]
    )
    assert re.findall(r"CUT \d", page) == ["CUT 2", "CUT 5"]
    rest = [
        sum(
            MACHINE.cycle * np.isin(rows.line[1:], [4, 8, 10, 14]).sum()
            for rows in [verne_post.convert(text.encode(), MACHINE, OPTIONS).setpoints]
            if rows
        )
        for text in (before, after)
    ]
    assert f"|4 operations whose times differ less|{rest[0]:.3f}|{rest[1]:.3f}|" in page


def test_the_same_program_differs_in_nothing() -> None:
    page = text_of(compare(BEFORE, BEFORE))
    assert "The same text, and the same times." in page
    assert "|A and B take the same time, " in page
    differing = page.partition("|What differs|")[2].partition("|Findings|")[0]
    assert differing.startswith("None of these numbers.|The same in both: time ")
    assert not re.search(r"[+-]\d+\.\d{3}\|", page.partition("|What differs|")[2])


def test_the_same_program_under_two_set_ups_differs_in_time_alone() -> None:
    slower = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 40.0))}, override=0.5)
    page = text_of(compare(BEFORE, BEFORE, other=slower))
    assert "|the same text|" in page
    assert "|Other text|" not in page
    assert "|N30 G1 X20 F1200|" in page


def test_lines_of_the_same_text_are_not_among_those_that_differ() -> None:
    """Corner and feed of the next line changed, so the time of a line may differ although its text does not."""
    other, _, same = text_of(compare(BEFORE, AFTER)).partition("|Lines that differ")[2].partition("|Same text, other")
    assert "|N7 G1 X20 F2400|" in other
    assert "|the same text|" not in other
    assert same.count("|the same text|") >= 1
    assert "F2400" not in same
    # a refused program has no times to differ
    refused = text_of(compare(BEFORE, BEFORE.replace("N40 Y20", "N40 Y5000"))).partition("|Lines that differ")[2]
    assert "|N40 Y5000|" in refused
    assert "the same text" not in refused


def test_small_differences_of_equal_lines_have_one_row_without_a_colour() -> None:
    """Lines beside a slower one are planned anew, by a millisecond or two: nobody has changed them."""
    before = (
        "G21 G90 G64 P0.01\nG0 X0 Y0 Z0 A0 C0\n"
        + "".join(f"G1 X{10 * (k % 2)} Y{5 * k} F1200\n" for k in range(1, 8))
        + "M2\n"
    )
    page = compare(before, before.replace("Y15 F1200", "Y15 F800"))
    other, _, same = page.partition("<h3>Same text, other time</h3>")
    assert "<b class=slower>+0.278</b>" in other
    assert re.search(r"\|other lines: 2 places, each less than 0\.005 s apart\|1\.131\|1\.131\|same\|", text_of(same))
    assert "the same text" not in text_of(same)
    assert re.findall(r"<b class=(\w+)>", same.partition("</table>")[0]) == []


def test_another_feed_rate_is_named_where_it_stands_and_where_it_holds() -> None:
    page = text_of(compare(BEFORE, BEFORE.replace("F1200", "F2400"))).partition("|Other text|")[2]
    for line in (r"N30 G1 X20 F1200\|.*?N30 G1 X20 F2400", r"N40 Y20\|.*?the same text"):
        shares = [
            float(share)
            for pair in re.findall(
                rf"\|{line}\|.*?\|A: 1200 mm/min reached (\d+) % of the time, else jerk of \w+"
                r"\|B: 2400 mm/min reached (\d+) % of the time, else jerk of \w+\|",
                page,
            )
            for share in pair
        ]
        # a longer way to the speed, and less time at it
        assert 95.0 < shares[0] < 99.0
        assert 80.0 < shares[1] < shares[0] - 3.0
    assert "600 mm" not in page
    # a line that only one program has is no change of a feed rate
    added = text_of(compare(BEFORE, BEFORE.replace("N60 Y0\n", "N60 Y0\nN65 X10\n"))).partition("|Other text|")[2]
    assert "|N65 X10|" in added
    assert "|B: feed rate reached 96 % of the time, else jerk of rho" in added
    assert "mm/min reached" not in added


def test_findings_are_in_one_or_in_both() -> None:
    head = "G21 G90\nG0 X0 Y0 Z0 A0 C0\n"
    wrong = "X1\nG1 A99 F600\nA0\nG1 X5000\nX0\nX1\nA99\nA0\nM2\n"
    page = text_of(compare(f"{head}G1 A99 F600\nA0\nC20\nM2\n", head + wrong))
    before, after = page.partition("|Findings|")[2].partition("|B|")[::2]
    assert re.search(r"\|line 3: VP\d+ error: joint a [^|]*\|3 \|G1 A99 F600\|in both\|tried: ", before)
    assert "|`verne-post explain a.nc:3` explains this line and what would bring it" in before
    assert "only in A" not in before
    after = after.partition("|Time by limit|")[0]
    assert re.search(r"\|line 4: VP\d+ error: joint a [^|]*\|4 \|G1 A99 F600\|in both\|also a by 2.931 deg in", after)
    assert re.search(r"line 6: VP\d+ error: [^|]*\|6 \|G1 X5000\|only in B\|", after)
    assert "|A: refused; B: refused|" in page
    # a cause counts once, as everywhere; each of its members was an error
    assert after.count(" error: ") == 2
    assert "|findings|1 error, no warnings|2 errors, no warnings|" in page
    assert "|There is nothing to compare: A and B cannot run, so no times are known.|" in page


def test_a_comparison_with_a_program_that_cannot_be_read_says_what_it_has() -> None:
    """The line of the error, one path, and no differences of times that nobody knows."""
    page = text_of(compare(BEFORE, BEFORE.replace("Y20", "Y2O")))
    findings = page.partition("|Findings|")[2].partition("|Time by limit|")[0]
    assert re.search(r"\|line 5: VP001 error: [^|]*\|5 \|N40 \|Y2O\|only in B\|", findings)
    assert "|Tool path of A |on the table|" in page
    table = "|B - A|"
    assert table not in page
    assert "|Both tool paths |on the table, with the tips at the same time|" in (
        both := text_of(compare(BEFORE, AFTER))
    )
    assert table in both


def test_the_command_takes_two_programs_with_a_set_up_each(
    run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text, length in (("a", BEFORE, 80), ("b", AFTER, 95)):
        Path(f"{name}.nc").write_text(text)
        Path(f"{name}.nc.toml").write_text(f"tool_length = {length}.0\n\n[wcs]\nG54 = [0.0, 0.0, 40.0]\n")
    answer = run("report", "a.nc", "b.nc", "-o", "two.html")
    assert answer.code == 0
    passed = "can run on VERNE: 0 errors, 0 warnings"
    assert f"a.nc: {passed}; b.nc: {passed}; two.html shows both" in answer.err
    assert "|tool length|80 mm|95 mm|" in text_of(Path("two.html").read_text("utf-8"))
    # one of them is refused: the graver status counts
    Path("b.nc").write_text(AFTER.replace("X22", "A99"))
    assert run("report", "a.nc", "b.nc", "-o", "two.html", "-q").code == 1
    assert run("report", "a.nc", "nothing.nc", "-o", "two.html").code == 2
    # no machine is drawn, so what draws machines is not needed
    with monkeypatch.context() as without:
        without.setattr("importlib.util.find_spec", lambda name: None)
        assert (
            "report -o needs jupyter_threejs_sage (extra report), which" in run("report", "a.nc", "-o", "one.html").err
        )
        assert run("report", "a.nc", "a.nc", "-o", "two.html", "-q").code == 0
    for words, message in (
        (("a.nc", "b.nc", "a.nc", "-o", "two.html"), "shows one program or compares two; 3 are given"),
        (("a.nc", "b.nc", "--static", "two.png"), "--static draws one program"),
        (("-", "-", "-o", "two.html"), "standard input can be one of the two programs"),
    ):
        answer = run("report", *words)
        assert answer.code == 2
        assert message in answer.err


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("blade_5axis.nc.toml", "blade_<wbr>5axis.<wbr>nc.<wbr>toml"),
        ("12.5 mm, -3.25 deg", "12.5 mm, -3.25 deg"),
        ("op-2_<a>.mpf", "op-2_&lt;a&gt;.mpf"),
    ],
)
def test_lines_end_in_names_of_files_behind_their_signs_alone(text: str, html: str) -> None:
    assert escape_names(text) == html
