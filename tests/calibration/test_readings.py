"""Files of measured poses: what is read, and what every mistake is told."""

import numpy as np
import pytest

from tests.builders import LENGTHS
from verne_post.calibration.readings import explain_refused_lengths, read_readings
from verne_post.model.findings import InputError

SLIDERS = ("rho1", "rho2", "rho3")
HEADER = "rho1_mm,rho2_mm,rho3_mm,x_mm,y_mm,z_mm"
ROW = "1,2,3,4,5,6"


def mistakes(text):
    with pytest.raises(InputError) as caught:
        read_readings(text.encode() if isinstance(text, str) else text, SLIDERS)
    assert {item.code for item in caught.value.findings} == {"VP502"}
    return [(item.line, item.message) for item in caught.value.findings]


def test_columns_in_any_order_blank_tilts_comments_and_lines():
    text = (
        "\ufeff# by hand\n"
        "alpha_deg, z_mm,y_mm,x_mm,rho3_mm,rho2_mm,rho1_mm,remark\r\n"
        "\n"
        '90,6,5,4,3,2,1,"a, b"\n'
        " ,6,5,4,3,2,1,\n"
    )
    data = read_readings(text.encode(), SLIDERS)
    assert data.rho.tolist() == [[1, 2, 3], [1, 2, 3]]
    assert data.pose[:, :3].tolist() == [[4, 5, 6], [4, 5, 6]]
    assert data.pose[0, 3] == np.pi / 2
    assert np.isnan(data.pose[1, 3])
    assert data.line.tolist() == [4, 5]
    assert len(set(data.setting.tolist())) == 2  # equal readings are not one reading, unless the file says so


def test_settings_group_rows_and_radians_are_taken():
    data = read_readings(f"{HEADER},setting,alpha_rad\n{ROW},a,0.5\n9,2,3,4,5,6,b,\n{ROW},a,1\n".encode(), SLIDERS)
    assert data.setting[0] == data.setting[2] != data.setting[1]
    assert data.pose[[0, 2], 3].tolist() == [0.5, 1.0]


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("", None, "no header line; expected the columns rho1_mm"),
        (f"{HEADER}\n", 1, "no row of values"),
        (HEADER.replace("x_mm", "x") + f"\n{ROW}\n", 1, "column 'x' is not known; did you mean x_mm?"),
        (f"{HEADER},x_m\n{ROW},1\n", 1, "column 'x_m' is not known; did you mean x_mm?"),
        (f"{HEADER}\n{ROW}\n".replace("x_mm", "x_inch"), 1, "column 'x_inch' is not known; did you mean x_mm?"),
        ("rho1_mm,rho2_mm,x_mm,y_mm,z_mm\n1,2,3,4,5\n", 1, "column rho3_mm is missing"),
        (f"{HEADER},x_mm\n{ROW},1\n", 1, "column x_mm appears twice"),
        (f"{HEADER},alpha_deg,alpha_rad\n{ROW},1,1\n", 1, "both alpha_deg and alpha_rad"),
        (f"{HEADER}\n{ROW}\n1,2,3,4,5\n", 3, "5 values; expected 6"),
        (f"{HEADER}\n1,2,3,4,five,6\n", 2, "y_mm = 'five' is not a finite number; expected millimetres"),
        (f"{HEADER}\n1,2,3,,5,6\n", 2, "x_mm is blank; expected millimetres"),
        (f"{HEADER}\n1,2,3,nan,5,6\n", 2, "x_mm = 'nan'"),
        (f"{HEADER}\n1,2,3,4e7,5,6\n", 2, "x_mm = 4e+07 is beyond"),
        (f"{HEADER},alpha_deg\n{ROW},inf\n", 2, "alpha_deg = 'inf' is not a finite number; expected degrees"),
        (f"{HEADER},setting\n{ROW},\n", 2, "setting is blank"),
        (f"{HEADER},setting\n{ROW},a\n1,2,3.5,4,5,6,a\n", 3, "rho3_mm = 3.5, but setting 'a' has 3 in line 2"),
        (HEADER.encode() + b"\n1,2,3,4,5,\xff\n", 2, "not UTF-8"),
    ],
)
def test_mistakes_say_line_column_and_what_is_right(text, line, says):
    ((where, message),) = mistakes(text)
    assert where == line
    assert says in message


def test_every_mistake_of_a_file_comes_at_once():
    found = mistakes(f"{HEADER}\n1,b,3,4,5,6\n1,2\n1,2,3,4,5,z\n")
    assert [line for line, _message in found] == [2, 3, 4]


def test_lengths_that_a_machine_file_would_refuse():
    assert explain_refused_lengths("verne", LENGTHS) is None
    assert "r1 = 131 must be smaller" in str(explain_refused_lengths("verne", {**LENGTHS, "r1": 131.0}))
