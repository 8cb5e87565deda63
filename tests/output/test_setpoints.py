"""Setpoint CSV: the text to the byte, the exact way back, and damage that is named with its row."""

import csv
import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import verne_post
from verne_post.model.findings import InputError
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.expected import Expected
from verne_post.output.rounding import choose_setpoint_format
from verne_post.output.setpoint_files import read_setpoints
from verne_post.output.setpoints import read_csv, write_csv_header, write_csv_rows

from ..builders import HEADER, MACHINE, OPTIONS

SOURCE = b"G21 G90 G94 G17\nG0 X0 Y0 Z20 A0 C0\nG1 X3 F3000\nG4 P0.01\nY2 A3 C-5\nC5\nG2 I1\nM2\n"
ARGUMENTS = ("--tool-length", "80", "--wcs", "G54=0,0,50")


@pytest.fixture(scope="module")
def made() -> Any:
    result = verne_post.convert(SOURCE, MACHINE, OPTIONS)
    assert result.ok
    return result.setpoints


@pytest.fixture(scope="module")
def text(made: Any) -> str:
    fmt = choose_setpoint_format(MACHINE, 0.001, None, accept_rounding=False)
    return write_csv_header(MACHINE.columns, ()) + write_csv_rows(SetpointBlock(0, made.values, made.line, fmt))


def read(text: str, cycle: float = 0.001) -> list[SetpointBlock]:
    return list(read_csv(io.StringIO(text), Expected("axes.csv", MACHINE.columns, cycle, ())))


# --- writing ---------------------------------------------------------------------------------


def test_file_to_the_byte(made: Any, text: str, spawn: Callable[..., Any], tmp_path: Path) -> None:
    program = tmp_path / "a.nc"
    program.write_bytes(SOURCE)
    out = spawn(program, *ARGUMENTS).stdout
    assert out.decode("ascii") == text
    assert out.startswith(HEADER.encode() + b"\n")
    assert b"\r" not in out
    assert out.endswith(b"\n")
    assert not out.endswith(b"\n\n")
    assert not re.search(rb"-0\.0*(,|\n)", out)
    row = re.compile(r"\d+\.\d{3}(,-?\d+\.\d{7}){3}(,-?\d+\.\d{8}){2},\d+")
    lines = text.splitlines()
    assert all(row.fullmatch(line) for line in lines[1:])
    assert len(lines) == 1 + len(made.values)
    assert any(",-" in line for line in lines)  # C is negative somewhere
    for k, cells in enumerate(csv.reader(lines[1:])):
        assert float(cells[0]) == pytest.approx(k * 0.001, abs=1e-12)


def test_columns_of_the_result_are_those_of_the_file(made: Any) -> None:
    assert ",".join(made.columns) == HEADER
    assert made.t == pytest.approx(0.001 * np.arange(len(made.values)), abs=1e-12)
    assert made.line.dtype == np.int32


# --- reading ---------------------------------------------------------------------------------


@pytest.mark.parametrize("rows", [1, 100, 8192])
def test_round_trip_is_exact(made: Any, text: str, rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("verne_post.output.setpoints.READ_ROWS", rows)
    blocks = read(text)
    assert np.concatenate([block.values for block in blocks]).tolist() == made.values.tolist()
    assert np.concatenate([block.line for block in blocks]).tolist() == made.line.tolist()
    assert [block.first for block in blocks] == list(range(0, len(made.values), rows))
    assert blocks[0].format == replace(
        choose_setpoint_format(MACHINE, 0.001, None, accept_rounding=False), header_lines=1
    )


def test_other_line_ends_and_a_missing_last_one_are_read(made: Any, text: str) -> None:
    blocks = list(read_csv(io.StringIO(text.rstrip("\n"), newline=None), Expected("a", MACHINE.columns, 0.001, ())))
    assert sum(len(block.values) for block in blocks) == len(made.values)
    windows = io.TextIOWrapper(io.BytesIO(text.replace("\n", "\r\n").encode()), encoding="utf-8")
    assert next(read_csv(windows, Expected("a", MACHINE.columns, 0.001, ()))).values.tolist() == made.values.tolist()


def edited(text: str, row: int, edit: Callable[[list[str]], list[str]]) -> str:
    """Change the cells of one row; row 0 is the first after the header."""
    lines = text.splitlines()
    lines[row + 1] = ",".join(edit(lines[row + 1].split(",")))
    return "\n".join(lines) + "\n"


def cell(column: int, value: str) -> Callable[[list[str]], list[str]]:
    return lambda cells: [*cells[:column], value, *cells[column + 1 :]]


ROW = 37
DAMAGE: dict[str, Callable[[list[str]], list[str]]] = {
    "a cell missing": lambda cells: cells[:-2] + cells[-1:],
    "a cell too many": lambda cells: [*cells, "1"],
    "text in a cell": cell(2, "abc"),
    "an empty cell": cell(3, ""),
    "NaN": cell(1, "nan"),
    "infinity": cell(4, "inf"),
    "a quoted number": cell(1, '"650.1"'),
    "a decimal comma": cell(1, "650,1"),
    "half a line number": cell(6, "3.5"),
    "a line number beyond any file": cell(6, "1000000000000"),
    "no line number": cell(6, ""),
    "time out of step": cell(0, "0.038"),
    "time of the row before": cell(0, "0.036"),
    "time a little out": cell(0, "0.0371"),
    "negative time": cell(0, "-0.037"),
    "a comment": lambda cells: ["# remark"],
    "an empty line": lambda cells: [""],
    "a truncated row": lambda cells: cells[:3],
}


@pytest.mark.parametrize("rows", [10, 8192])
@pytest.mark.parametrize("what", DAMAGE)
def test_damage_is_named_with_its_row(what: str, rows: int, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("verne_post.output.setpoints.READ_ROWS", rows)
    with pytest.raises(InputError) as caught:
        read(edited(text, ROW, DAMAGE[what]))
    (item,) = caught.value.findings
    assert item.code == "VP020"
    # line of the file: the header is line 1
    assert (item.file, item.file_line) == ("axes.csv", ROW + 2)
    assert "axes.csv" not in item.message


HEADERS = {
    "empty": "",
    "a column missing": "t_s,rho1_mm,rho2_mm,a_deg,c_deg,line\n",
    "columns exchanged": "t_s,rho2_mm,rho1_mm,rho3_mm,a_deg,c_deg,line\n",
    "a column more": HEADER + ",extra\n",
    "no header": "0.000,1.0,2.0,3.0,4.0,5.0,1\n",
    "other separator": HEADER.replace(",", ";") + "\n",
}


@pytest.mark.parametrize("what", HEADERS)
def test_wrong_header_is_shown_beside_the_right_one(what: str) -> None:
    with pytest.raises(InputError) as caught:
        read(HEADERS[what])
    (item,) = caught.value.findings
    assert item.code == "VP020"
    assert HEADER in item.message
    if what == "a column missing":
        assert item.message == f"1 column is missing: rho3_mm; expected {HEADER!r}"


def test_a_row_of_another_number_of_values_is_told_in_words() -> None:
    for row, said in (
        ("0.000,1,2", "this row has 3 values, expected 7 with commas between them"),
        ("0.000;1;2;3;4;5;6", "this row has semicolons between its values; write commas in place of them"),
    ):
        with pytest.raises(InputError) as caught:
            read(f"{HEADER}\n{row}\n")
        assert caught.value.findings[0].message == said


def test_times_must_be_told_apart() -> None:
    """A time column without the decimals of the cycle tells nothing: every row at 0 is out of step."""
    rows = "".join(f"0,600.0,600.0,600.0,0.0,0.0,{2 + k // 10}\n" for k in range(20))
    with pytest.raises(InputError) as caught:
        read(HEADER + "\n" + rows)
    assert caught.value.findings[0].code == "VP020"
    assert (caught.value.findings[0].file, caught.value.findings[0].file_line) == ("axes.csv", 3)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "VP020"),
        (HEADER.encode() + b"\n", "VP020"),
        (HEADER.encode() + b"\n0.000,1,2\n", "VP020"),
        (b"\xff\xfe\x00", "text in UTF-16"),
        (HEADER.encode() + b"\n0.000,\xff,2\n", "no text in UTF-8"),
    ],
    ids=["empty", "header alone", "truncated", "not UTF-8", "not UTF-8 behind the header"],
)
def test_unreadable_file_is_exit_status_2(content: bytes, says: str, run: Callable[..., Any], tmp_path: Path) -> None:
    program, axes = tmp_path / "a.nc", tmp_path / "axes.csv"
    program.write_bytes(SOURCE)
    axes.write_bytes(content)
    answer = run("verify", axes, "--against", program, *ARGUMENTS)
    assert answer.code == 2
    assert answer.out == ""
    assert says in answer.err
    assert "axes.csv" in answer.err


@pytest.mark.parametrize(
    ("first", "said"),
    [
        ("0.000,574.1,520.7,520.7,-20,0,11", "the header row 't_s,rho1_mm,rho2_mm,rho3_mm,"),
        ("t_s,rho2_mm,rho1_mm,rho3_mm,a_deg,c_deg,line", "line'; they are in another order"),
        ("t_s;rho1_mm;rho2_mm", "line'; write commas between them"),
        ("t_s,x_mm,y_mm,z_mm,a_deg,c_deg,line", "line'; give the --machine with which the file was made"),
        ("0.025,0.2,30.9,0.2", "line'; verify reads the rows of every --format but pvt and ros2"),
        ('joint_names: ["rho1", "rho2", "rho3", "a", "c"]', "the file has knots of cubics, and not every row; verify"),
        ("0.025,0.2,30.9,0.2,24.6,0.2,32.0,0.1,0.1,0.0,0.0", "the file has knots of cubics, and not every row; verify"),
        ("574.1 520.7 520.7 -20.0", "this row has 4 values, expected 5 with blanks between them"),
        ("PK\3\4", "no archive with t, values, line and columns, as --format npz writes"),
    ],
)
def test_a_first_line_that_is_not_the_header_says_what_it_is(first: str, said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        list(read_setpoints(io.BytesIO(f"{first}\n".encode()), Expected("axes.csv", MACHINE.columns, 0.001, ())))
