"""The list of public programs: its rows can be read, and the script judges a program as they say."""

from dataclasses import replace
from pathlib import Path

from tests.benchmarks.public_programs import ROOT, judge, table_rows, wide_machine

CORPUS = ROOT / "tests" / "corpus" / "apt"


def test_rows_of_the_list_are_of_one_form():
    rows = table_rows()
    assert len({(row.repository, row.path) for row in rows}) == len(rows) >= 25
    for row in rows:
        assert row.repository.count("/") == 1
        assert {row.read, row.run} <= {"yes", "no"}
        assert (row.run == "yes") == (row.refusal == row.right == ""), row  # a refusal says why it is right
        assert Path(row.path).name


def test_a_program_is_judged_as_the_list_has_it():
    machine, row = wide_machine(), next(row for row in table_rows() if "insert" in row.setup)
    raw = (CORPUS / "bracket.apt").read_bytes()
    good = judge(row, raw, machine)
    assert (good.read, good.run, good.refusal) == ("yes", "yes", "")
    bad = judge(replace(row, setup=""), raw, machine)
    assert (bad.read, bad.run, bad.refusal) == ("no", "no", "VP002, line 10")
    far = judge(row, raw.replace(b"GOTO/0,20.,60.", b"GOTO/0,20.,29000."), machine)
    assert (far.read, far.run, far.refusal[:5]) == ("yes", "no", "VP101")
